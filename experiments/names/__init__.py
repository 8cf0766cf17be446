"""Simulated campaigns with one known thing missing, for every name a verdict can give, and the studies on them.

The motion is integrated here and seen through sensors that share nothing with the package that is judged; only
verdicts.py imports it.
"""
