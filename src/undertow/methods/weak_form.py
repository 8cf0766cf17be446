"""A second way to the coefficients: the equation in weak form on the samples as they were recorded.

    sum w (a + sum_i theta_i force_i) = 0 for every test function w,

in which derivatives are moved on to w: w'' x stands for w a where only displacement exists, -w' x for w v. The smoothed
motion enters nonlinear forces alone. Trials may have any length. Where this and the trajectories disagree, one of them
is wrong, and the reader is told.

Belongs here: the design from recorded samples, the comparison. Does not belong here: least squares (sindy.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag
from scipy.signal import fftconvolve
from scipy.stats import f as fisher

from undertow.conditioning.motion import Motion
from undertow.equation.term import Term
from undertow.errors import IdentificationError
from undertow.methods.library import MIN_ROWS, Design, evaluate, motion_period
from undertow.methods.sindy import LeastSquares, solve_design

Array = NDArray[np.float64]

WINDOW_PERIODS = 0.7
"""Length of a test function, in periods: sin^4, as wide as a Hann window of half a period."""

ROWS_PER_WINDOW = 6

DISAGREEMENT = 0.99
"""Two routes disagree where their difference is beyond this quantile of what errors alone would give: Fisher's F of as
many terms and of the residual's effective samples beyond the unknowns."""


DERIVATIVES = {"acceleration": 0, "velocity": 1, "displacement": 2}
"""How often the test function is differentiated for what was recorded."""


@dataclass(frozen=True)
class Route:
    """The same terms by the second route.

    ``values`` and ``stderr`` (p,) coefficients over mass; ``distance`` (1,) square of the difference from the first
    route over its covariance, per term; ``agrees`` whether that is within `DISAGREEMENT`; ``response`` what stood for
    acceleration.
    """

    names: tuple[str, ...]
    values: Array
    stderr: Array
    distance: float
    agrees: bool
    response: str
    sentence: str


def measured_design(
    motions: Sequence[Motion], terms: Sequence[Term], clocks: Mapping[str, float] | None = None
) -> Design:
    """Rows of the equation in weak form on recorded samples, all trials together.

    The response is the recorded acceleration (``clocks`` by how much its samples are of a later instant than stamped,
    s a trial), else displacement against w'', else velocity against w'. Springs see the recorded displacement, viscous
    dampers the recorded velocity, or displacement against w'; other forces the smoothed motion.

    Raises IdentificationError without motions, without a recorded channel of motion, or for windows too short.
    """
    if not motions:
        raise IdentificationError(f"{len(motions)} motions; give at least one trial")
    period = float(np.median([motion_period(motion) for motion in motions]))
    length, step = WINDOW_PERIODS * period, WINDOW_PERIODS * period / ROWS_PER_WINDOW
    parts = [_rows(motion, terms, length, step, (clocks or {}).get(motion.name, 0.0)) for motion in motions]
    return Design.of(parts, terms, motions, (length, step, period))


def response_channel(motion: Motion) -> str:
    """The recorded channel that stands for the acceleration; IdentificationError where there is none."""
    for quantity in ("acceleration", "displacement", "velocity"):
        if quantity in motion.recording.channels:
            return quantity
    have = ", ".join(motion.recording.channels) or "nothing"
    raise IdentificationError(f"trial {motion.name}: recorded is {have}; map displacement, velocity or acceleration")


def _rows(motion: Motion, terms: Sequence[Term], length: float, step: float, clock: float) -> Array:
    """Columns, response and time (n, p + 2) of one trial."""
    kernels, starts = _test_functions(motion, length, step)

    def against(values: Array, order: int) -> Array:
        # w and w'' are even about the middle; convolution turns w' round, which is the minus of partial integration
        mean: Array = fftconvolve(values[motion.inside], kernels[order], mode="valid")[starts]
        return mean

    forces = evaluate(terms, motion.x - motion.equilibrium.value, motion.v, motion.a, motion.t)
    columns = [against(*_source(motion, term, forces[:, index])) for index, term in enumerate(terms)]
    channel = response_channel(motion)
    recorded = motion.recorded(channel)
    if channel == "acceleration" and clock:
        recorded = np.interp(motion.t - clock, motion.t, recorded)
    return np.column_stack([*columns, -against(recorded, DERIVATIVES[channel]), against(motion.t, 0)])


def _test_functions(motion: Motion, length: float, step: float) -> tuple[tuple[Array, ...], NDArray[np.int_]]:
    """w, w' and w'' of one trial by sample, each over the area of w, and the samples of its window where they start."""
    dt = motion.step_s
    count = max(5, round(length / dt))
    phase = np.pi * (np.arange(count) + 0.5) / count
    w = np.sin(phase) ** 4
    slope = 4.0 * np.sin(phase) ** 3 * np.cos(phase) * np.pi / (count * dt)
    bend = (12.0 * (np.sin(phase) * np.cos(phase)) ** 2 - 4.0 * np.sin(phase) ** 4) * (np.pi / (count * dt)) ** 2
    area = float(w.sum())
    first = np.arange(0.0, max(motion.windowed("t").size - count, 0), max(step / dt, 1.0))
    starts = np.unique(first.astype(int))
    if starts.size < MIN_ROWS:
        raise IdentificationError(
            f"trial {motion.name}: {starts.size} rows in a window of {motion.windowed('t').size * dt:.3g} s with test "
            f"functions of {length:.3g} s; {MIN_ROWS} are needed: widen trials.window or leave the trial out"
        )
    return (w / area, slope / area, bend / area), starts


def _overlap(motion: Motion, length: float, step: float) -> Array:
    """Covariance (n, n) of one trial's rows from a sensor's white noise of variance 1: what test functions share."""
    kernels, starts = _test_functions(motion, length, step)
    kernel = kernels[DERIVATIVES[response_channel(motion)]]
    shared = np.correlate(kernel, kernel, "full")[kernel.size - 1 :]
    apart = np.abs(starts[:, None] - starts)
    return np.where(apart < kernel.size, shared[np.minimum(apart, kernel.size - 1)], 0.0)


def _covariances(motions: Sequence[Motion], solution: LeastSquares) -> tuple[Array, Array]:
    """Covariance (p, p) of the coefficients by two accounts of their errors.

    One estimates the residual's memory from the residual: that holds for any noise, and is poor in the few directions
    that a few short trials determine best. The other takes the sensor's noise as white, with a memory that the test
    functions alone give it, and needs one number from the residual.
    """
    design = solution.design
    count = len(design.names)
    stacked = np.hstack([design.columns, design.nuisance])
    shared = block_diag(*(_overlap(motion, design.length_s, design.step_s) for motion in motions))
    inverse = np.linalg.pinv(stacked)
    left = float(np.trace(shared) - np.trace(stacked @ (inverse @ shared)))
    variance = float(solution.residual @ solution.residual) / left
    white = variance * (inverse @ shared @ inverse.T)[:count, :count]
    return solution.within * np.outer(solution.widening, solution.widening), white


def _source(motion: Motion, term: Term, smoothed: Array) -> tuple[Array, int]:
    """What a term's column is made of, and how often the test function is differentiated for it."""
    channels = motion.recording.channels
    if term.name == "stiffness" and "displacement" in channels:
        return motion.recorded("displacement") - motion.equilibrium.value, 0
    if term.speed_power == 1.0:
        if "velocity" in channels:
            return motion.recorded("velocity"), 0
        if "displacement" in channels:
            return motion.recorded("displacement") - motion.equilibrium.value, 1
    return smoothed, 0


def second_route(
    motions: Sequence[Motion],
    terms: Sequence[Term],
    values: Array,
    covariance: Array,
    clocks: Mapping[str, float] | None = None,
) -> Route:
    """The coefficients of ``terms`` in weak form beside ``values`` (p,) with ``covariance`` (p, p) of the first route.

    The first route's errors come from the same samples; adding both covariances is therefore on the careful side. The
    routes disagree where they do by both accounts of the second one's errors. Raises IdentificationError as
    `measured_design` does, and where two terms are the same force.
    """
    design = measured_design(motions, terms, clocks)
    solution = solve_design(design)
    found = solution.values[: len(terms)]
    away = found - values
    accounts = _covariances(motions, solution)
    distances = [_distance(away, covariance + own) for own in accounts]
    own, distance = accounts[int(np.argmin(distances))], min(distances)
    freedom = max(solution.n_effective - len(solution.values), 1.0)
    ratio, limit = distance / max(len(terms), 1), float(fisher.ppf(DISAGREEMENT, len(terms), freedom))
    agrees = ratio <= limit
    scale = np.sqrt(np.diag(covariance + own))
    response = " and ".join(sorted({response_channel(motion) for motion in motions}))
    worst = int(np.argmax(np.abs(away) / scale))
    number = abs(float(away[worst])) / float(scale[worst])
    verdict = "agrees" if agrees else "DISAGREES"
    sentence = (
        f"weak form on the recorded {response} {verdict}: F = {ratio:.1f} (limit {limit:.1f}), the largest "
        f"difference {number:.1f} standard errors in {design.names[worst]}"
    )
    return Route(design.names, found, np.sqrt(np.diag(own)), ratio, agrees, response, sentence)


def _distance(away: Array, covariance: Array) -> float:
    """Square of a difference (p,) over its covariance (p, p), 1."""
    scale = np.sqrt(np.diag(covariance))
    unit = np.linalg.pinv(covariance / np.outer(scale, scale), hermitian=True)
    return float((away / scale) @ unit @ (away / scale))
