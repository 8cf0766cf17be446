"""Whether a force and a displacement stand in each other's columns.

Two things tell. In their places the force is a sum of the displacement and its rates at the same instant, and the
displacement remembers what the force was; exchanged, it is the other way round. And a force that drives a body gives it
energy on average, whatever the body's laws, if these take energy (Willems 1972, doi:10.1007/BF00276493: passivity): the
mean of F v is that of what is lost. Exchanged it is the mean of x F', which is that of -F v but for the ends. A sign
that is turned, or a delay, makes the power negative too, so that it decides nothing alone.

Belongs here: that decision. Does not belong here: start values (driven_start.py).
"""

from __future__ import annotations

import math

import numpy as np
from scipy.signal import fftconvolve

from undertow.conditioning.driven import DrivenTrial
from undertow.errors import IdentificationError
from undertow.methods.driven_start import bump, half_lengths, row_step
from undertow.recording.recording import Array

SWAPPED_LEAST = 0.03
SWAPPED_SHARE = 0.15
"""Columns are swapped where the equation's linear part leaves more than the first of the input's power unexplained, and
with input and output exchanged less than the second of that."""
TAKES_ENERGY = 3.0
"""Or where the input's mean power is so many standard errors below 0, and the exchanged order leaves less for the test
functions that distinguish the two orders best. Set on seeds 11000 to 11003 of bodies like those that
`experiments/driven/order.py` counts."""
BLOCKS = 20
"""Blocks of a record whose scatter gives the error of the mean power."""


def must_not_be_swapped(trial: DrivenTrial) -> None:
    """IdentificationError where a force and a displacement are each other's columns."""
    if trial.mover != "force" or "displacement" not in trial.outputs:
        return
    pairs = _left_over(trial.u, trial.outputs["displacement"], float(np.median(np.diff(trial.t))))
    if not pairs:
        return
    given, swapped = (min(pair[order] for pair in pairs) for order in (0, 1))
    power = power_given(trial)
    because = ""
    if not (given > SWAPPED_LEAST and swapped < SWAPPED_SHARE * given):
        given, swapped = max(pairs, key=lambda pair: abs(math.log(pair[0] / pair[1])))
        if not (power < -TAKES_ENERGY and swapped < given):
            return
        because = f", and it takes energy from what it drives (its mean power is {-power:.2g} standard errors below 0)"
    raise IdentificationError(
        f"trial {trial.name}: the input follows the output: {trial.quantity} is no sum of the displacement and its "
        f"rates ({100.0 * given:.2g} % is left), but the displacement is one of {trial.quantity} and its rates "
        f"({100.0 * swapped:.2g} % is left){because}, as where the two columns are swapped; exchange them"
    )


def power_given(trial: DrivenTrial) -> float:
    """Mean power that a force gives to a body whose displacement was recorded, in its standard errors from blocks.

    >>> t = np.linspace(0.0, 60.0, 3000)
    >>> u = np.sin(3.0 * t)
    >>> power_given(DrivenTrial("r", t, u, {"displacement": -np.cos(3.0 * t)})) > 3.0
    True
    """
    power = (trial.u - np.mean(trial.u)) * np.gradient(trial.outputs["displacement"], trial.t)
    means = np.array([np.mean(block) for block in np.array_split(power, BLOCKS)])
    scatter = float(np.std(means, ddof=1))
    return float(np.mean(means)) / (scatter / math.sqrt(BLOCKS)) if scatter > 0.0 else 0.0


def _left_over(u: Array, x: Array, step: float) -> list[tuple[float, float]]:
    """Share of the power of u that no sum of x, x' and x'' explains, and the other way round, in weak form: a pair for
    test functions of each length."""
    out = []
    for half in half_lengths(u.size):
        parts = bump(half, step)
        of_u, of_x = ([fftconvolve(v, w[::-1], "valid")[:: row_step(half)] for w in parts] for v in (u, x))
        out.append((_unexplained(of_u[0], of_x), _unexplained(of_x[0], of_u)))
    return out


def _unexplained(wanted: Array, columns: list[Array]) -> float:
    """Share of the variance of ``wanted`` (m,) that no sum of the columns and a constant explains; never 0."""
    design = np.column_stack([*columns, np.ones(wanted.size)])
    scale = np.sqrt(np.mean(design**2, axis=0))
    scale[scale == 0.0] = 1.0
    left = wanted - design / scale @ np.linalg.lstsq(design / scale, wanted, rcond=None)[0]
    power = float(np.var(wanted))
    return max(float(np.mean(left**2)) / power if power > 0.0 else 1.0, float(np.finfo(float).eps))
