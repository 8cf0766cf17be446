"""Curves of a harmonic set for its page: the equations, swept up and down through each trial's frequencies.

Belongs here: those sweeps, points as recorded. Does not belong here: the picture (report/driven_figures.py).
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
from undertow.methods.harmonic_set import missed_at
from undertow.report.driven_figures import DrawnCurve, DrawnSet
from undertow.report.trial_figures import drawn_as

CURVE_POINTS = 80
"""Frequencies of a drawn curve."""


def drawn_sets(config: RunConfig, group: Sweeps, found: ResponseFound, most: int) -> list[DrawnSet]:
    """The first trials of a group, as many as are drawn at most, with the curves of the equation as prescribed and with
    what was added: those fitted to the points that were not held back, where some were."""
    response = config.recordings.response
    absolute = response is not None and response.amplitude.frame == "absolute"
    before, after = found.proof or (found.baseline, found.augmented)
    fits = [before, after] if found.added and after is not None else [before]
    out = []
    for i, table in enumerate(group.tables[:most]):
        here = group.trial == i
        part = group.measured.part(here)
        leads = float(np.sum(table.amplitude * np.sin(table.phase))) > 0.0
        ways = [way for way in (True, False) if (table.rising == way).any()]
        curves = [
            curve for number, fit in enumerate(fits)
            for curve in _curves(part, fit.theta, (absolute, leads, number == 1), ways)
        ]  # fmt: skip
        left = [np.hypot(*missed_at(fit, part)) for fit in fits]
        hertz, phase = table.rate / (2.0 * math.pi), _turned(table.phase, leads)
        shown = drawn_as("displacement", config.equation.coordinate)
        out.append(
            DrawnSet(table.name, shown, hertz, table.amplitude, phase, table.rising, found.unseen[here], curves, left)
        )
    return out


def _curves(
    measured: HarmonicSet, theta: Array, seen_as: tuple[bool, bool, bool], ways: Sequence[bool]
) -> list[DrawnCurve]:
    """The equation swept up (True) and down where the body is drawn to motions of the drive's period; ``seen_as``:
    against the earth, before the drive, repaired."""
    absolute, leads, repaired = seen_as
    order = np.argsort(measured.rate, kind="stable")
    rates = np.linspace(measured.rate.min(), measured.rate.max(), CURVE_POINTS)
    force = np.interp(rates, measured.rate[order], measured.force[order])
    reach = float(np.max(measured.amplitude))
    extent = MotionSize(reach, reach * float(rates[-1]))
    curves = []
    for up in ways:
        way = slice(None) if up else slice(None, None, -1)
        try:
            states = swept(theta, force[way], rates[way], extent, measured.mover)
        except IdentificationError:
            continue
        cosine, sine = seen(states, force[way], absolute)
        phase = _turned(np.arctan2(-sine, cosine), leads)
        curves.append(DrawnCurve(repaired, up, rates[way] / (2.0 * math.pi), np.hypot(cosine, sine), phase))
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
