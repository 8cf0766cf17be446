"""Curves of a harmonic set for its page: the equation found, swept up and down through each trial's frequencies.

Belongs here: those sweeps, points as recorded. Does not belong here: the picture (report/driven_page.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from undertow.campaign.config import RunConfig
from undertow.campaign.response.sets import Sweeps
from undertow.comparison.response_search import ResponseFound
from undertow.conditioning.harmonic import HarmonicSet
from undertow.equation.input import MotionSize
from undertow.equation.steady_state import SteadyState, swept
from undertow.equation.term import Array
from undertow.errors import IdentificationError
from undertow.report.driven_page import DrawnCurve, DrawnSet

CURVE_POINTS = 80
"""Frequencies of a drawn curve."""


def drawn_sets(config: RunConfig, group: Sweeps, found: ResponseFound, most: int) -> list[DrawnSet]:
    """The first trials of a group with the equation's curves, as many as are drawn at most."""
    response = config.recordings.response
    absolute = response is not None and response.amplitude.frame == "absolute"
    out = []
    for i, table in enumerate(group.tables[:most]):
        here = group.trial == i
        leads = float(np.sum(table.amplitude * np.sin(table.phase))) > 0.0
        curves = _curves(group.measured.part(here), found.best.theta, absolute, leads)
        hertz, phase = table.rate / (2.0 * math.pi), _turned(table.phase, leads)
        out.append(
            DrawnSet(table.name, group.unit, hertz, table.amplitude, phase, table.rising, found.unseen[here], curves)
        )
    return out


def _curves(measured: HarmonicSet, theta: Array, absolute: bool, leads: bool) -> Sequence[DrawnCurve]:
    """The equation swept up and down where the body is drawn to motions of the drive's period."""
    order = np.argsort(measured.rate, kind="stable")
    rates = np.linspace(measured.rate.min(), measured.rate.max(), CURVE_POINTS)
    force = np.interp(rates, measured.rate[order], measured.force[order])
    reach = float(np.max(measured.amplitude))
    extent = MotionSize(reach, reach * float(rates[-1]))
    curves = []
    for word, way in (("up", slice(None)), ("down", slice(None, None, -1))):
        try:
            states = swept(theta, force[way], rates[way], extent, measured.mover)
        except IdentificationError:
            continue
        cosine, sine = seen(states, force[way], absolute)
        curves.append(
            DrawnCurve(f"equation, swept {word}", rates[way] / (2.0 * math.pi), np.hypot(cosine, sine),
                       _turned(np.arctan2(-sine, cosine), leads))
        )  # fmt: skip
    return curves


def seen(states: Sequence[SteadyState], force: Array, absolute: bool) -> tuple[Array, Array]:
    """Cosines and sines (n,) as recorded: against the earth where the base's motion is to be added (``force`` is then
    its acceleration)."""
    cosine, sine = np.array([[s.cosine, s.sine] for s in states]).T
    if absolute:
        cosine = cosine - force / np.array([s.rate for s in states]) ** 2
    return cosine, sine


def _turned(phase: Array, leads: bool) -> Array:
    """Phases in degrees about -90, or about 90 where the motion is before the drive: a resonance makes no jump."""
    centre = 90.0 if leads else -90.0
    return np.asarray((np.degrees(phase) - centre + 180.0) % 360.0 - 180.0 + centre)
