"""Simulated campaigns with one known thing missing, for every name a verdict can give, and the studies on them.

Motion and sensors share nothing with the package that is judged; only verdicts.py and seen.py import it.
"""
