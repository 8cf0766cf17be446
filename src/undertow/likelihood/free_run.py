"""The score: how far a free run from the release ends up from the recording, and how far it may.

Free run: the equation is integrated from the release; nothing of the motion is fed back. Only x0, the clock and the
rest offset (v0 where no hold was seen) are adjusted to the trial, alike for every equation. The error stands beside
what the sensors alone give, and beside what scatter of k, c, mu from trial to trial would give with the same equation.

Belongs here: nrmse and its two floors. Does not belong here: why it is large.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from undertow.conditioning.motion import Motion
from undertow.conditioning.release import followed
from undertow.equation.equation import Equation
from undertow.equation.general import placed_equation
from undertow.equation.kernel import SLOT
from undertow.equation.simulate import fastest_frequency
from undertow.equation.term import PlacedTerm
from undertow.errors import IdentificationError
from undertow.likelihood import output_error
from undertow.likelihood.problem import (
    SAMPLES_PER_PERIOD,
    TRAJECTORY_STEPS_PER_PERIOD,
    Link,
    Problem,
    ProblemBuilder,
    TrialOptions,
)
from undertow.likelihood.residuals import motion_of, parameter_vector
from undertow.recording.recording import Array

DRAWS = 200
"""Simulated repetitions for the 95 % quantile of repeatability: its own error is then about 3 %."""

DRAWN_STEPS_PER_PERIOD = 12
"""Largest step of a simulated repetition: some 1e-4 of the release off, where repetitions differ by 1e-2. Bristles
keep the usual step."""

REPEATABILITY_QUANTILE = 0.95

HALVINGS = 8
"""Halvings of x0 and v0 tried where the motion from the recorded ones has no bounds: down to 0.4 %."""


class OwnUnknown(NamedTuple):
    """An unknown of one trial: its scale, and the slots that it moves, with factors, on top of what stands there. One
    with a ``typical`` value, the time in which a hook lets go, begins with what stands, or else there."""

    scale: float
    slots: tuple[tuple[str, float], ...]
    typical: float = 0.0
    lower: float = -math.inf
    upper: float = math.inf


class OwnDrift(NamedTuple):
    """Width of the prior (m) and degree in time of the drift of one trial's displacement sensor."""

    std: float = 0.0
    degree: int = 1


STEADY = OwnDrift()
"""A sensor that does not drift."""


@dataclass(frozen=True)
class FreeRun:
    """One trial against one parameter vector.

    ``t`` (n,) s after the release inside the motion window, ``measured`` and ``simulated`` (n,) about the rest
    position (m, rad; rad/s where only a rate was recorded), ``nrmse`` RMS error over RMS measured. ``theta`` is the
    parameter vector with the trial's x0, v0 in it (laws that the compiled integrator lacks behind its own places),
    ``nuisance`` the derivatives of ``simulated`` by x0, clock, rest.
    """

    t: Array
    measured: Array
    simulated: Array
    nrmse: float
    theta: Array
    nuisance: Array

    @property
    def residual(self) -> Array:
        """Measured minus simulated, (n,)."""
        return self.measured - self.simulated


def scored_channel(motion: Motion) -> str:
    """What the free run is scored against: displacement, or velocity where only a rate was recorded."""
    return followed(motion.recording)


def free_run(
    motion: Motion,
    theta: Array,
    rest_offset_std: float,
    own: Mapping[str, OwnUnknown] | None = None,
    laws: tuple[PlacedTerm, ...] = (),
    drift: OwnDrift = STEADY,
) -> FreeRun:
    """The free run of ``theta`` (its x0, v0 are ignored) with x0, clock and rest fitted to this trial.

    ``rest_offset_std`` is the prior of the rest position in the sensor's scale (mu N / k, or its own error); ``own``
    are unknowns that are this trial's own as its release is, beside what ``theta`` has of them: an outside force's size
    and phase; ``laws`` all forces where the compiled integrator lacks one; ``drift`` is what a displacement sensor is
    suspected of, adjusted to the trial and taken from what was measured.
    """
    quantity = scored_channel(motion)
    builder = ProblemBuilder()
    base = np.array(theta)
    base[SLOT["x0"]] = base[SLOT["v0"]] = 0.0
    mine = []
    hooked = False
    for name, unknown in (own or {}).items():
        start = 0.0
        if unknown.typical:
            if not motion.window.held:
                continue
            place = SLOT[unknown.slots[0][0]]
            start, base[place], hooked = base[place] or unknown.typical, 0.0, True
        index = builder.unknown(name, start, scale=unknown.scale, lower=unknown.lower, upper=unknown.upper)
        mine += [Link(SLOT[slot], index, factor) for slot, factor in unknown.slots]
    options = TrialOptions((quantity,), rest_offset_std, drift_std=drift.std, drift_degree=drift.degree, hooked=hooked)
    builder.trial(motion, base, tuple(mine), options, laws)
    problem = builder.build()
    solution = output_error.fit(problem, _bounded_start(problem), growing=False)
    return _at_samples(motion, solution.problem, solution.values, quantity)


def equation_runs(equation: Equation, motions: Iterable[Motion]) -> tuple[FreeRun, ...]:
    """The free run of an equation on each trial, whose rest lies within what friction holds, or its own error."""
    theta, laws = placed_equation(equation)
    stiffness = float(theta[SLOT["k1"]] + theta[SLOT["ks"]])
    held = max(float(theta[SLOT["fc"]]), 0.0) / stiffness if stiffness > 0.0 else 0.0
    return tuple(free_run(m, theta, math.hypot(held, m.equilibrium.total_stderr), laws=laws) for m in motions)


def _bounded_start(problem: Problem) -> Array:
    """The trial's own start, with x0 and v0 halved until its motion has bounds: damping that feeds a fast motion may
    still hold a slow one. The trial's own start where no half helps; the search then says what is wrong."""
    own = np.array([u.start for u in problem.unknowns])
    free = np.array([name.startswith(("x0_", "v0_")) for name in problem.names])
    for halving in range(HALVINGS + 1):
        start = np.where(free, own * 0.5**halving, own)
        if output_error.residuals(problem.trials[0], start) is not None:
            return start
    return own


def _at_samples(motion: Motion, problem: Problem, values: Array, quantity: str) -> FreeRun:
    """The fitted free run at every recorded sample of the window."""
    trial = problem.trials[0]
    t = motion.windowed("t")
    offset = trial.channels[0].offset
    rest = float(values[offset]) if offset >= 0 else 0.0
    measured = motion.recorded(quantity)[motion.inside] - rest
    drift = trial.channels[0].drift
    measured = measured - trial.drifting(t, len(drift)) @ values[list(drift)]
    theta = parameter_vector(trial, values)
    shift = float(values[trial.shift]) if trial.shift >= 0 else 0.0
    x, v, a = motion_of(trial, theta, np.maximum(t + shift, 0.0))
    signal = {"displacement": x, "velocity": v, "acceleration": a}[quantity]
    simulated = signal[:, 0]
    columns = [signal[:, 1:], np.ones((t.size, 1))]
    if trial.shift >= 0:
        rate = {"displacement": v[:, 0], "velocity": a[:, 0]}.get(quantity)
        columns.append((np.gradient(simulated, t) if rate is None else rate)[:, None])
    score = float(np.sqrt(np.mean((measured - simulated) ** 2) / np.mean(measured**2)))
    return FreeRun(t, measured, simulated, score, theta, np.hstack(columns))


def as_released(motion: Motion, theta: Array) -> FreeRun | None:
    """The free run of ``theta`` with nothing adjusted: released where and when the recording says, about the rest
    position it says, at rest where a hold was seen. None where that motion has no bounds, or no displacement was
    recorded."""
    if scored_channel(motion) != "displacement":
        return None
    started = np.array(theta)
    started[SLOT["x0"]] = motion.x[0] - motion.equilibrium.value
    started[SLOT["v0"]] = 0.0 if motion.window.held else motion.v[0]
    measured = motion.recorded("displacement")[motion.inside] - motion.equilibrium.value
    t = motion.windowed("t")
    try:
        x, _, _ = output_error.trajectory(started, np.zeros(0, dtype=np.int64), t)
    except IdentificationError:
        return None
    score = float(np.sqrt(np.mean((measured - x[:, 0]) ** 2) / np.mean(measured**2)))
    return FreeRun(t, measured, x[:, 0], score, started, np.zeros((t.size, 0)))


def error_as_measured(motion: Motion, theta: Array) -> float:
    """nrmse of ``theta`` with nothing adjusted (`as_released`); nan where there is no such motion."""
    run = as_released(motion, theta)
    return math.nan if run is None else run.nrmse


def sensor_floor(motion: Motion, run: FreeRun) -> float:
    """nrmse from the sensor alone: its noise, and its slow drift as far as the fused motion's error shows it."""
    noise = motion.noise.get(scored_channel(motion), math.nan)
    return noise / float(np.sqrt(np.mean(run.measured**2)))


def repeatability(
    run: FreeRun, spread: Mapping[str, float], floor: float, quantity: str, seed: int, freedom: float = math.inf
) -> float:
    """95 % quantile of nrmse for the same equation when slots vary from trial to trial.

    ``spread`` maps slots to standard deviations (k1, c1, fc in their units), seen with ``freedom`` degrees of freedom:
    draws are Student's where these are few, since a few dry trials can look more alike than the rig is. Each draw is
    simulated in full and its x0, clock and rest are taken out linearly, as a fit would; the sensors' ``floor`` is added
    in quadrature. Draws whose motion has no bounds (an equation that feeds fast motion) are left out.
    """
    active = {slot: std for slot, std in spread.items() if std > 0.0}
    if not active:
        return floor
    generator = np.random.default_rng(seed)
    few = slice(None, None, _every(run))
    times = run.t[few]
    basis, _ = np.linalg.qr(run.nuisance[few])
    scale = float(np.sqrt(np.mean(run.measured**2)))
    pick = {"displacement": 0, "velocity": 1, "acceleration": 2}[quantity]
    none = np.zeros(0, dtype=np.int64)
    steps = _drawn_steps(run, times)
    start = output_error.trajectory(run.theta, none, times, steps)[pick][:, 0]
    drawn = []
    for _ in range(DRAWS):
        theta = run.theta.copy()
        for slot, std in active.items():
            draw = generator.standard_normal()
            if math.isfinite(freedom) and freedom > 0.0:
                draw /= math.sqrt(generator.chisquare(freedom) / freedom)
            here = theta[SLOT[slot]]
            theta[SLOT[slot]] = max(here + std * draw, 0.0) if here != 0.0 else std * draw  # a pendulum's stiffness
        try:
            drawn.append(output_error.trajectory(theta, none, times, steps)[pick][:, 0])
        except IdentificationError:  # no rig has motions without bounds: such a draw says nothing of repeatability
            continue
    if not drawn:
        return floor
    away = np.array(drawn) - start
    away -= away @ basis @ basis.T
    errors = np.sqrt(np.mean(away**2, axis=1)) / scale
    return math.hypot(float(np.quantile(errors, REPEATABILITY_QUANTILE)), floor)


def _drawn_steps(run: FreeRun, times: Array) -> int:
    """Steps a period of the repetitions: few, where the equation's own motion keeps its bounds with them (that of
    bristles does not)."""
    try:
        output_error.trajectory(run.theta, np.zeros(0, dtype=np.int64), times, DRAWN_STEPS_PER_PERIOD)
    except IdentificationError:
        return TRAJECTORY_STEPS_PER_PERIOD
    return DRAWN_STEPS_PER_PERIOD


def _every(run: FreeRun) -> int:
    """How many samples apart a draw's motion is looked at: an RMS over a smooth motion needs no more."""
    step = (run.t[-1] - run.t[0]) / max(run.t.size - 1, 1)
    return max(1, int(2.0 * math.pi / fastest_frequency(run.theta) / SAMPLES_PER_PERIOD / step))
