"""Limits of the comparison that are also spoken of where nothing is compared: pages, tables, calibration.

Belongs here: those numbers, without anything that takes long to import. Does not belong here: limits of one step of
the search (beside it).
"""

import math

FAR_ABOVE_NOISE = 2.5
"""Mean squared residual, in units of the sensors' noise, from which a law is missing whatever a free run allows."""

LEAST_P = 1e-6
"""Smallest p-value that is said: no tail of so many replicas is known further."""

OVERWHELMING = math.log(1e6)
"""Log odds from which an effect is there though the free run hardly shows it."""

WORTH = 0.5
"""Share of repeatability by which the free run must come closer (in quadrature) for an effect to be named."""
