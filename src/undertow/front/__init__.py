"""The Python front: read, fit, diagnose, simulate, predict, hand over."""
