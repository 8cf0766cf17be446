"""Whether one trial's displacement has another scale than the others': a unit, a range, a column.

Friction over stiffness goes with the scale, drag with its inverse: a trial in centimetres among others in millimetres
has a tenth of their friction and ten times their drag, at their period.

Belongs here: that one trial. Does not belong here: periods and releases (one_body.py), numbers that no body has
(plausible.py).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from undertow.discrepancy.findings import GroupFindings, TrialFindings
from undertow.methods.repeated import NAMES
from undertow.quantities import OK, Estimate

DRAG = ("drag_coefficient", "drag_Ns2_per_m2", "drag_Ns2_per_m2_per_mass")
"""What a single fit calls drag."""

LEAST = math.log(1.5)
"""Logarithm of a scale that is doubted: trials' friction differs by less."""

SURE = 5.0
"""Standard errors, of the trial's own number and of how the others differ together, beyond which it is doubted."""

SAME = 3.0
"""Friction and drag say the same scale within so many."""

LEAST_SPREAD = 0.05
"""Trials of one rig differ by at least so much in friction and drag, relative, for all that a few show."""

KNOWN_WITHIN = 0.5
"""A number with a larger relative error says nothing of a scale."""

UNITS = (10.0, 25.4, 39.37, 100.0, 304.8, 1000.0)
"""Ratios of units of length: without drag only such a scale is doubted. A smaller one may be a rail that was dirty."""


@dataclass(frozen=True)
class _Scale:
    """Logarithm of one trial's number over the others' median, and its standard error."""

    ratio: float
    error: float


def scaled_trial(group: GroupFindings, known: Collection[str] = ()) -> str:
    """The one trial whose friction and drag show another scale of its displacement, in words; empty where there is
    none but of those ``known`` to be strange."""
    for one in (t for t in group.trials if t.motion.name not in known):
        others = [t for t in group.trials if t is not one]
        friction, drag = (_seen(one, others, names) for names in (NAMES["mu"], DRAG))
        if friction is None or abs(friction.ratio) < max(LEAST, SURE * friction.error):
            continue
        if _drag_agrees(friction, drag) if drag is not None else _is_a_unit(friction):
            times = math.exp(friction.ratio)
            inverse = "" if drag is None else f" and {math.exp(drag.ratio):.2g} times their drag"
            return (
                f"trial {one.motion.name} has {times:.2g} times the friction of the "
                f"others{inverse}, as if its displacement were written {max(times, 1.0 / times):.3g} times too "
                f"{'large' if times > 1.0 else 'small'}: look at its unit and column (recordings.layouts), or leave it "
                "out (recordings.exclude)"
            )
    return ""


def _seen(one: TrialFindings, others: Sequence[TrialFindings], names: Sequence[str]) -> _Scale | None:
    """How one trial's number compares with the others'; None where fewer than two others say it, or they differ."""
    mine, theirs = _number(one, names), [n for t in others if (n := _number(t, names)) is not None]
    if mine is None or len(theirs) < 2:
        return None
    logs = np.log([n.value for n in theirs])
    own = max(float(np.ptp(logs)) if len(theirs) == 2 else float(np.std(logs, ddof=1)), LEAST_SPREAD)
    noise = math.hypot(mine.stderr / mine.value, own * math.sqrt(1.0 + 1.0 / len(theirs)))
    return _Scale(math.log(mine.value) - float(np.median(logs)), noise)


def _number(trial: TrialFindings, names: Sequence[str]) -> Estimate | None:
    """A trial's own number, where its fit alone knows it well; None where it does not."""
    fit = trial.fits.get("output_error")
    if fit is None or fit.outcome != OK:
        return None
    for name in names:
        found = fit.parameters.get(name)
        if found is not None and found.value > 0.0 and 0.0 < found.stderr < KNOWN_WITHIN * found.value:
            return found
    return None


def _drag_agrees(friction: _Scale, drag: _Scale) -> bool:
    """Whether drag shows the same scale: its ratio is friction's inverse, and surely not one."""
    together = math.hypot(friction.error, drag.error)
    return abs(friction.ratio + drag.ratio) < SAME * together and abs(drag.ratio) > SAME * drag.error


def _is_a_unit(friction: _Scale) -> bool:
    return any(abs(abs(friction.ratio) - math.log(unit)) < SAME * LEAST_SPREAD for unit in UNITS)
