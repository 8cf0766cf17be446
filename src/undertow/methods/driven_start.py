"""Start values of a driven equation from the record itself: the equation in weak form.

    M <w'', x> + sum_i c_i <w, force_i(x, v)> = <w, u>

or, of a base that moves with the acceleration y'' and with x relative to it, M <w, x'' + y''> + ... = 0, laws of the
water at the velocity x' + y'; or, in water that moves with the velocity u, M <w'', x> + ... = rho V <w, u'> with its
laws at x' - u; what is held at a value goes to the right;

for bumps w of many lengths, w = (1 - s^2)^4, whose derivatives stand in for those of x; a spring sees the recorded x,
a damper -<w', x>, other laws x and a velocity smoothed over a part of the bump. Which length suits a body is not asked
beforehand: each from a handful of samples up to a part of the record is tried; the free run over windows decides.

Belongs here: that regression. Does not belong here: fits of motions (likelihood/), laws.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from scipy.signal import fftconvolve, savgol_filter

from undertow.conditioning.driven import DrivenTrial
from undertow.equation.driven_slots import MOVING
from undertow.equation.term import Term
from undertow.errors import IdentificationError
from undertow.likelihood.driven import MASS, against_base, drive_for
from undertow.recording.recording import Array

SHORTEST = 4
"""Half length of the shortest test function, samples."""
LENGTHS = 9
"""Test functions tried, each twice as long as the one before."""
ROWS_A_BUMP = 4
SMOOTHED_SHARE = 0.5
"""Length of the cubic that a velocity is taken from, as a share of the test function."""


def bump(half: int, step: float) -> tuple[Array, Array, Array]:
    """The test function (2 half + 1,), its first and its second derivative by time.

    As sums over samples the derivatives are exact for displacements up to a parabola: of a short bump the sampled
    second derivative alone would not add up to 0, and where a body is would look like an acceleration.

    >>> w, dw, ddw = bump(4, 0.1)
    >>> t = np.arange(-4, 5) * 0.1
    >>> bool(np.allclose([ddw.sum(), (ddw * t**2).sum() / 2 - w.sum(), (dw * t).sum() + w.sum()], 0.0))
    True
    """
    s = np.arange(-half, half + 1) / half
    q = 1.0 - s * s
    width = half * step
    w, dw, ddw = q**4, -8.0 * s * q**3 / width, (-8.0 * q**3 + 48.0 * s * s * q**2) / width**2
    curve = 0.5 * (s * width) ** 2
    sums = np.array([[ddw.sum(), w.sum()], [ddw @ curve, w @ curve]])
    alike, level = np.linalg.solve(sums, [0.0, w.sum()])
    return w, -dw * w.sum() / (dw @ (s * width)), alike * ddw + level * w


def start_values(
    trial: DrivenTrial, terms: Sequence[Term], half: int, held: Mapping[str, float] | None = None
) -> Mapping[str, float]:
    """Mass and every coefficient by weak-form least squares with bumps of that half length, samples.

    Keys: ``mass_kg`` and the laws' names; ``held`` gives those that are known. Raises IdentificationError where fewer
    rows than unknowns are there.
    """
    held = held or {}
    columns, response = weak_form(trial, terms, half)
    free = [name for name in columns if name not in held]
    response = response - sum((held[name] * columns[name] for name in columns if name in held), 0.0 * response)
    if response.size < 2 * len(free):
        raise IdentificationError(
            f"trial {trial.name}: {response.size} rows for {len(free)} numbers; give a longer record"
        )
    design = np.column_stack([columns[name] for name in free])
    scale = np.sqrt(np.mean(design**2, axis=0))
    scale[scale == 0.0] = 1.0
    found = np.linalg.lstsq(design / scale, response, rcond=None)[0] / scale
    return {**{name: held[name] for name in columns if name in held}, **dict(zip(free, found.tolist(), strict=True))}


def weak_form(trial: DrivenTrial, terms: Sequence[Term], half: int) -> tuple[dict[str, Array], Array]:
    """The equation against bumps of that half length: a column (m,) of the mass (`MASS`) and of each law by its name,
    and what they add up to (m,). Row j belongs to the bump that begins at sample ``j * row_step(half)``."""
    trial = against_base(trial)
    step = float(np.median(np.diff(trial.t)))
    w, dw, ddw = bump(half, step)

    def against(values: Array, weights: Array) -> Array:
        """<weights, values> around every ROWS_A_BUMP-th part of a bump."""
        return np.asarray(fftconvolve(values, weights[::-1], "valid")[:: row_step(half)] * step)

    x, v, inertia = _motion(trial, half, step, against, (w, dw, ddw))
    response, carried = against(_between_samples(trial), w), np.zeros(trial.t.size)
    through, accelerated = inertia, carried
    if trial.mover != "force":
        drive, way = drive_for(trial), MOVING[trial.mover]
        accelerated = drive.at(trial.t)
        through = inertia + way * against(accelerated, w)
        response, carried = 0.0 * response, way * drive.velocity_at(trial.t)
    columns = {MASS: through if trial.mover == "base" else inertia}
    for term in terms:
        wet = term.relative_to == "water"
        if term.is_inertia:
            columns[term.name] = through
            continue
        force = np.asarray(term.force(x, v + carried if wet else v, accelerated, trial.t), dtype=np.float64)
        recorded = trial.outputs.get("displacement")
        if recorded is not None and np.array_equal(force, x):
            columns[term.name] = against(recorded, w)
        elif recorded is not None and np.array_equal(force, v):
            columns[term.name] = -against(recorded, dw)
        else:
            columns[term.name] = against(force, w)
    return columns, response


def row_step(half: int) -> int:
    """Samples from the begin of one bump of that half length to the next one's.

    >>> row_step(16)
    4
    """
    return max(1, half // ROWS_A_BUMP)


def _between_samples(trial: DrivenTrial) -> Array:
    """The input as a sum over samples has it: what is held from sample to sample acts half a step later."""
    if trial.mover != "force" or trial.hold != "zero":
        return trial.u
    return np.asarray(0.5 * (trial.u + np.concatenate([trial.u[:1], trial.u[:-1]])))


def _motion(
    trial: DrivenTrial,
    half: int,
    step: float,
    against: Callable[[Array, Array], Array],
    bumps: tuple[Array, Array, Array],
) -> tuple[Array, Array, Array]:
    """Displacement, velocity and the inertia's column from whatever was recorded."""
    w, dw, ddw = bumps
    window = max(5, 2 * int(SMOOTHED_SHARE * half) + 1)
    outputs = trial.outputs
    if "displacement" in outputs:
        x = outputs["displacement"]
        v = outputs.get("velocity")
        if v is None:
            v = savgol_filter(x, window, 3, deriv=1, delta=step)
        smooth = savgol_filter(x, window, 3)
        inertia = against(outputs["acceleration"], w) if "acceleration" in outputs else against(x, ddw)
        return smooth, v, inertia
    if "velocity" in outputs:
        v = outputs["velocity"]
        x = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(trial.t))])
        return x, v, against(outputs["acceleration"], w) if "acceleration" in outputs else -against(v, dw)
    a = outputs["acceleration"]
    v = np.concatenate([[0.0], np.cumsum(0.5 * (a[1:] + a[:-1]) * np.diff(trial.t))])
    x = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * np.diff(trial.t))])
    return x, v, against(a, w)


def half_lengths(samples: int) -> list[int]:
    """Half lengths that are tried for a record of so many samples, from `SHORTEST` on, each twice the one before.

    >>> half_lengths(1000)
    [4, 8, 16, 32]
    """
    return [SHORTEST * 2**i for i in range(LENGTHS) if SHORTEST * 2**i * 24 <= samples]
