"""`predict`: an equation run free on a trial, or from a start, with the band that its numbers' errors leave.

Belongs here: start states, draws of the equation's numbers, the frozen prediction. Does not belong here: the score with
x0, clock and rest adjusted to a trial (likelihood/free_run.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from numbers import Integral
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from undertow.comparison.deviations import SLOTS
from undertow.conditioning.motion import Motion
from undertow.discrepancy.words import percent
from undertow.equation.equation import Equation
from undertow.equation.general import general_trajectory, placed_equation
from undertow.equation.kernel import SLOT
from undertow.equation.simulate import rising
from undertow.equation.simulate import simulate as integrate
from undertow.equation.term import PlacedTerm
from undertow.errors import IdentificationError, UndertowError
from undertow.front.columns import Columns, Units
from undertow.front.reading import read
from undertow.front.simulation import equation_of, one_group
from undertow.likelihood.free_run import scored_channel
from undertow.likelihood.output_error import trajectory
from undertow.methods.dry import DEFAULT_SCATTER
from undertow.recording.arrays import instants
from undertow.recording.recording import Array
from undertow.report.trial_curves import Axes, Curve, draw_run, new_axes
from undertow.uncertainty.confidence import INTERVAL_LEVEL, half_width
from undertow.uncertainty.seeds import random_numbers

DRAWS = 200
"""Motions that a band is made of: its ends are then right within a tenth of its width."""

LEAST_DRAWS = 2
"""Fewer have no spread."""

BAND_POINTS = 1000
"""Instants at which a band is computed; between them it is interpolated."""

NOTHING = np.zeros(0, dtype=np.int64)

FROM_START = ("from x0", "translation", "displacement")
"""Name, coordinate and quantity of a free run without a trial."""


@dataclass(frozen=True, eq=False)
class PredictedRun:
    """One free run in the recording's own scale: ``t`` (n,) s after the release, ``predicted``, ``lower``, ``upper``
    (n,) in SI (nan where there is no band), ``measured`` (n,) or empty, ``x0`` and ``rest`` it started with."""

    name: str
    t: Array
    predicted: Array
    lower: Array
    upper: Array
    measured: Array
    x0: float
    rest: float
    coordinate: str = "translation"
    quantity: str = "displacement"

    @property
    def rms(self) -> float:
        """RMS of measured less predicted, SI; nan without a recording."""
        return float(np.sqrt(np.mean((self.measured - self.predicted) ** 2))) if self.measured.size else math.nan

    @property
    def nrmse(self) -> float:
        """The same over the RMS of the measured motion about its rest position."""
        return self.rms / float(np.sqrt(np.mean((self.measured - self.rest) ** 2))) if self.measured.size else math.nan

    @property
    def inside(self) -> float:
        """Share of the samples that lie inside the band; nan without a recording or a band."""
        if not self.measured.size or not np.isfinite(self.lower).all():
            return math.nan
        return float(np.mean((self.measured >= self.lower) & (self.measured <= self.upper)))


@dataclass(frozen=True, eq=False, repr=False)
class Prediction:
    """Free runs of one equation: ``runs``, the ``level`` of their band, and ``notes`` on what it holds."""

    equation: Equation
    runs: tuple[PredictedRun, ...]
    level: float
    notes: tuple[str, ...] = ()

    @property
    def table(self) -> pd.DataFrame:
        """Columns trial, time_s, measured, predicted, lower, upper: one row a sample, SI."""
        frames = []
        for run in self.runs:
            measured = run.measured if run.measured.size else np.full(run.t.size, math.nan)
            columns = {"time_s": run.t, "measured": measured, "predicted": run.predicted}
            frames.append(pd.DataFrame({"trial": run.name, **columns, "lower": run.lower, "upper": run.upper}))
        return pd.concat(frames, ignore_index=True)

    def plot(self, axes: Axes | None = None, trial: int = 0) -> Axes:
        """One free run with its band, and the recording where there is one; returns the Axes."""
        run = self.runs[trial]
        band = np.isfinite(run.lower).all()
        none = np.zeros(0)
        error = f": error {percent(run.nrmse)}" if run.measured.size else ""
        curve = Curve(
            f"{run.name}{error}", run.t, run.predicted, run.measured, run.lower if band else none,
            run.upper if band else none, run.coordinate, run.quantity,
        )  # fmt: skip
        return draw_run(curve, new_axes() if axes is None else axes)

    def score(self) -> float:
        """1 less the mean error (RMS over RMS motion) of the runs with a recording; nan without one."""
        return 1.0 - float(np.mean([run.nrmse for run in self.runs]))

    def __repr__(self) -> str:
        lines = [f"free run of {self.equation}"]
        for run in self.runs:
            begun = f"{run.name} =" if run.name == FROM_START[0] else f"{run.name} from"
            start = f"{begun} {run.x0:.4g} (SI), {run.t[-1]:.4g} s"
            seen = f": error {percent(run.nrmse)} of the motion (rms {run.rms:.3g})" if run.measured.size else ""
            held = f", {percent(run.inside)} of it inside the {self.level:.0%} band" if run.inside >= 0.0 else ""
            lines.append(f"  {start}{seen}{held}")
        return "\n".join([*lines, *(f"- {note}" for note in self.notes)])

    def _repr_html_(self) -> str:
        return f"<pre>{escape(str(self))}</pre>"


def predict(
    found: Any,
    trials: Any = None,
    *,
    t: ArrayLike | Sequence[ArrayLike] | None = None,
    columns: Columns | None = None,
    units: Units | None = None,
    x0: float | None = None,
    v0: float = 0.0,
    times: ArrayLike | None = None,
    rest_m: float = 0.0,
    adjust: bool = False,
    level: float = INTERVAL_LEVEL,
    draws: int = DRAWS,
    seed: int = 0,
) -> Prediction:
    """The equation of a fit, or of a diagnosis' or an opened run's group, run free on trials or from ``x0``; where
    there is one group, the diagnosis or the run stands for it.

    Trials are given as `read` takes them, with ``t``, ``columns`` and ``units``. On one it starts from the mean of its
    hold (where none was seen, from the motion's first instant) about the sensor's zero plus ``rest_m``; nothing that
    came after is used. With ``adjust`` x0, clock and rest position are fitted to the trial, as scores are. Without
    trials it starts from ``x0`` with the velocity ``v0`` (SI) and runs over ``times``. The band holds ``level`` of what
    the numbers' errors, the scatter of k, c and mu from trial to trial and the sensor's noise leave, by ``draws``
    equations drawn with ``seed``; free decays only.

    Raises UndertowError where neither trials nor x0 and times are given, times do not increase or draws are too few,
    IdentificationError where the motion has no bounds.

    >>> import undertow
    >>> run = undertow.simulate({"stiffness": 400.0, "viscous_damping": 2.0}, x0=0.1, mass_kg=4.0, duration_s=6.0)
    >>> found = undertow.fit(run.recorded(noise_m=1e-4), ["stiffness", "viscous_damping"], mass_kg=4.0)
    >>> ahead = predict(found, x0=0.05, times=run.t)
    >>> bool(abs(ahead.runs[0].predicted - run.x / 2).max() < 1e-4)
    True
    """
    if not 0.0 < level < 1.0:
        raise UndertowError(f"level is {level:g}; the band's share must lie between 0 and 1, as 0.9")
    if not (isinstance(draws, Integral) and draws >= LEAST_DRAWS):
        raise UndertowError(f"draws is {draws!r}; a band is made of {LEAST_DRAWS} equations at least, as {DRAWS}")
    found = one_group(found)
    equation = equation_of(found)
    rng = random_numbers(seed)
    drawn, notes = _drawn(found, draws, rng)
    if trials is None:
        if x0 is None or times is None:
            raise UndertowError(f"x0 is {x0} and times {'given' if times is not None else None}; give trials or both")
        run = _run(equation, drawn, FROM_START, rising(instants(times, "times")), (x0, v0), rest_m, level)
        return Prediction(equation, (run,), level, notes)
    if x0 is not None:
        raise UndertowError(f"x0 is {x0:g} beside trials, which have their own; give one of the two")
    motions = read(trials, columns, units, t=t)
    runs = tuple(_on_trial(found, equation, drawn, motion, rest_m, adjust, level) for motion in motions)
    return Prediction(equation, runs, level, notes)


def predict_whole(
    found: Any, where: Motion | Array, x0: float, others: tuple[float, float, float]
) -> PredictedRun:
    """One free run over every sample of a recording (held before its release), or from ``x0`` at the given times.

    ``others`` go into the band beside what `predict` holds: the sensor's noise and the error of the rest position (SI,
    1 sigma), and the share of the motion that the equation misses.
    """
    equation = equation_of(found)
    drawn, _ = _drawn(found, DRAWS, np.random.default_rng(0))
    noise, rest_std, missed = others
    named = FROM_START
    if isinstance(where, Motion):
        quantity = scored_channel(where)
        times = where.recording.time - where.window.release_s
        measured = where.recording.channels[quantity]
        (x0, v0), rest = _start(where, 0.0)
        named = (where.name, where.recording.coordinate, quantity)
    else:
        times, measured, v0, rest = where, None, 0.0, 0.0
    free = _run(equation, drawn, named, times, (x0, v0), rest, INTERVAL_LEVEL)
    beyond = missed * float(np.sqrt(np.mean((free.predicted[times >= 0.0] - rest) ** 2)))
    size = math.hypot(noise, rest_std, beyond)
    return _run(equation, drawn, named, times, (x0, v0), rest, INTERVAL_LEVEL, measured, size)


def _drawn(found: Any, draws: int, rng: np.random.Generator) -> tuple[Array, tuple[str, ...]]:
    """Parameter vectors (draws, slots) as their errors and the scatter from trial to trial spread them, and a note."""
    spread = getattr(found, "theta_draws", None)
    if spread is None:
        return np.zeros((0, 0)), ("no band: an equation alone has no errors",)
    thetas, scatter, note = spread(draws, rng)
    for symbol, slot in SLOTS.items():
        factors = 1.0 + scatter.get(symbol, 0.0) * rng.standard_normal(draws)
        thetas[:, SLOT[slot]] *= np.maximum(factors, 0.0)
    return thetas, (note,)


def scatter_of(structure: Any, known: Mapping[str, float] | None = None) -> tuple[Mapping[str, float], str]:
    """Relative scatter of k, c, mu from trial to trial, and where it comes from, in words; ``known``: what is stated or
    seen where there are no dry trials."""
    if structure is not None:
        return structure.scatter, f"band: the numbers' errors and the scatter of {structure.source}"
    if known is not None:
        return known, "band: the numbers' errors and the scatter of the run's trials"
    parts = ", ".join(f"{100 * v:g} % in {k}" for k, v in DEFAULT_SCATTER.items())
    return DEFAULT_SCATTER, f"band: the numbers' errors and an assumed scatter from trial to trial of {parts}"


def _on_trial(
    found: Any, equation: Equation, drawn: Array, motion: Motion, rest_m: float, adjust: bool, level: float
) -> PredictedRun:
    quantity = scored_channel(motion)
    measured = motion.recorded(quantity)[motion.inside]
    t = motion.windowed("t")
    noise = float(motion.noise.get(quantity, 0.0))
    late = 0.0
    start, rest = _start(motion, rest_m)
    if adjust:
        free = found.free_runs(read(motion))[0] if hasattr(found, "free_runs") else None
        if free is None:
            raise UndertowError(
                f"adjust is {adjust} but a {type(found).__name__} cannot be fitted to trial {motion.name}; leave it out"
            )
        start = (float(free.theta[SLOT["x0"]]), float(free.theta[SLOT["v0"]]))
        rest = float(np.mean(measured - free.measured)) if quantity == "displacement" else 0.0
        late = _clock(free.simulated, equation, start, t, quantity)
    named = (motion.name, motion.recording.coordinate, quantity)
    return _run(equation, drawn, named, t, start, rest, level, measured, noise, late)


def _clock(simulated: Array, equation: Equation, start: tuple[float, float], t: Array, quantity: str) -> float:
    """By how much the adjusted free run's clock is ahead of the recording's, s: one Gauss-Newton step is enough."""
    theta, laws = placed_equation(equation)
    theta[SLOT["x0"]], theta[SLOT["v0"]] = start
    x, v, a = _under(theta, laws, t)
    level, rate = {"displacement": (x, v), "velocity": (v, a), "acceleration": (a, a)}[quantity]
    slope = rate[:, 0]
    return float(slope @ (simulated - level[:, 0]) / (slope @ slope))


def _start(motion: Motion, rest_m: float) -> tuple[tuple[float, float], float]:
    """x0 about the rest position and v0 at the release, and the rest position in the sensor's scale."""
    recording, window = motion.recording, motion.window
    hold = recording.time < window.release_s - (window.start_s - window.release_s)
    if window.held and "displacement" in recording.channels and np.count_nonzero(hold) > 1:
        return (float(np.mean(recording.channels["displacement"][hold])) - rest_m, 0.0), rest_m
    return (float(motion.x[0]) - rest_m, 0.0 if window.held else float(motion.v[0])), rest_m


def _run(
    equation: Equation, drawn: Array, named: tuple[str, str, str], times: Array, start: tuple[float, float],
    rest: float, level: float, measured: Array | None = None, noise: float = 0.0, late: float = 0.0,
) -> PredictedRun:  # fmt: skip
    """One free run with its band; ``named`` is its name, coordinate and quantity."""
    name, coordinate, quantity = named
    place = {"displacement": 0, "velocity": 1, "acceleration": 2}[quantity]
    at = np.maximum(times + late, 0.0)
    grid = np.unique(np.concatenate([[0.0], at]))
    moved = integrate(equation, start[0], grid, start[1])
    level_at = (moved.x, moved.v, moved.a)[place][np.searchsorted(grid, at)]
    shown = rest if quantity == "displacement" else 0.0
    lower = upper = np.full(times.size, math.nan)
    if drawn.size:
        coarse = grid[:: max(1, grid.size // BAND_POINTS)]
        around = _spread(drawn, placed_equation(equation)[1], start, coarse, place)
        base = np.interp(coarse, grid, (moved.x, moved.v, moved.a)[place])
        tail = 0.5 - 0.5 * level
        wide = half_width(noise, level)
        below = base - np.quantile(around, tail, axis=0)
        above = np.quantile(around, 1.0 - tail, axis=0) - base
        lower = level_at + shown - np.hypot(np.interp(at, coarse, np.maximum(below, 0.0)), wide)
        upper = level_at + shown + np.hypot(np.interp(at, coarse, np.maximum(above, 0.0)), wide)
    seen = np.zeros(0) if measured is None else measured
    return PredictedRun(name, times, level_at + shown, lower, upper, seen, start[0], rest, coordinate, quantity)


def _under(theta: Array, laws: tuple[PlacedTerm, ...], times: Array) -> tuple[Array, Array, Array]:
    """x, v, a, each (n, 1), of a parameter vector: by the integrator that knows its laws."""
    return general_trajectory(theta, laws, NOTHING, times) if laws else trajectory(theta, NOTHING, times)


def _spread(
    drawn: Array, laws: tuple[PlacedTerm, ...], start: tuple[float, float], times: Array, place: int
) -> Array:
    """Motions (draws, n) of the drawn equations from one start; those without bounds are left out."""
    out = []
    for theta in drawn:
        theta = theta.copy()
        theta[SLOT["x0"]], theta[SLOT["v0"]] = start
        try:
            out.append(_under(theta, laws, times)[place][:, 0])
        except IdentificationError:
            continue
    if not out:
        raise IdentificationError(
            f"none of {len(drawn)} equations within their errors has a motion with bounds; a coefficient feeds it"
        )
    return np.array(out)


def normal_thetas(
    base: Array, places: Sequence[int], factors: Sequence[float], covariance: Array, draws: int,
    rng: np.random.Generator,
) -> Array:  # fmt: skip
    """Parameter vectors (draws, slots): ``base`` plus normal deviations of unknowns with their covariance (q, q)."""
    values, vectors = np.linalg.eigh(covariance)
    away = rng.standard_normal((draws, len(places))) @ (vectors * np.sqrt(np.maximum(values, 0.0))).T
    out = np.tile(base, (draws, 1))
    for column, (place, factor) in enumerate(zip(places, factors, strict=True)):
        out[:, place] += factor * away[:, column]
    return out
