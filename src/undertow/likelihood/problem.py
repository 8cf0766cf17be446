"""What is fitted to what: unknowns, trials as the integrator sees them, channels with their nuisances.

Belongs here: the frozen description of a fit. Does not belong here: the search (output_error.py).

A trial's parameter vector is linear in the unknowns: theta = base + sum factor * unknown, so that mu and C_d, shared
by trials with different normal forces and areas, need no special case.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.polynomial.legendre import legvander

from undertow.conditioning.motion import Motion, once_a_motion
from undertow.conditioning.period import dominant_period
from undertow.equation.input import Drive, MotionSize
from undertow.equation.kernel import SLOT
from undertow.equation.term import PlacedTerm
from undertow.errors import IdentificationError
from undertow.likelihood.priors import GAIN_STD, LATE_RELEASE_RADIANS, REST_SHARE, clock_std
from undertow.recording.recording import Array

SAMPLES_PER_PERIOD = 50
"""Cells a period that samples are averaged into: averaging to 100 Hz at 2 Hz loses nothing (cell's mean compared)."""

TRAJECTORY_STEPS_PER_PERIOD = 30
"""Largest step in fits: error under 1e-6 of x0 (docs/performance_measured.md), far below any sensor."""


EVEN = 1e-4
"""Cells whose centres are a cell's width apart within this share of it share their edges."""


@dataclass(frozen=True)
class Unknown:
    """One number to be found: start, bounds, and a Gaussian prior (mean ``start``, ``prior_std``; inf for none)."""

    name: str
    start: float
    lower: float = -math.inf
    upper: float = math.inf
    prior_std: float = math.inf
    scale: float = 1.0
    unit: str = ""


@dataclass(frozen=True)
class Link:
    """theta[slot] += factor * unknown, in one trial."""

    slot: int
    unknown: int
    factor: float = 1.0


@dataclass(frozen=True)
class Channel:
    """One recorded quantity of a trial in cells: ``values`` (n,) in SI with noise ``sigma``.

    Indices into the unknowns (-1: none): ``offset``, ``drift`` (of every shape of `TrialProblem.slow` that it has),
    ``shift`` (s, on top of the trial's own), ``gain`` (relative). ``unsure`` marks cells that say nothing, (n,); None:
    every cell counts.
    """

    quantity: str
    values: Array
    sigma: float
    offset: int = -1
    drift: tuple[int, ...] = ()
    shift: int = -1
    gain: int = -1
    unsure: np.ndarray | None = None

    @cached_property
    def data(self) -> Array:
        """The values, not a number where cells say nothing, (n,)."""
        said = self.values if self.unsure is None else np.where(self.unsure, math.nan, self.values)
        return np.require(said, np.float64, ["C", "W"])


@dataclass(frozen=True)
class TrialProblem:
    """One trial: cell centres ``t`` (n,) s after the release, cell width, base parameter vector, links, channels.

    ``shift`` is the index of the unknown by which the trial's clock is late (s; -1: none); ``width_s`` the
    width of a cell, 0 for instants that stand alone, and ``averaged`` whether several samples make up a cell
    (observation_model.py).
    ``laws`` holds all terms where the compiled integrator lacks one (equation/general.py), else nothing. ``drive`` is
    the measured input of a driven trial (None: a decay), ``extent`` how far and how fast its body moves;
    ``steps_a_period`` those of a decay's integrator.
    """

    name: str
    t: Array
    base: Array
    links: tuple[Link, ...]
    channels: tuple[Channel, ...]
    shift: int = -1
    width_s: float = 0.0
    period_s: float = 1.0
    laws: tuple[PlacedTerm, ...] = ()
    averaged: bool = True
    drive: Drive | None = None
    extent: MotionSize = field(default_factory=MotionSize)
    steps_a_period: int = TRAJECTORY_STEPS_PER_PERIOD

    @cached_property
    def slots(self) -> np.ndarray:
        """Distinct slots that an unknown reaches, sorted, (p,) int64: the integrator's ``active``."""
        return np.array(sorted({link.slot for link in self.links}), dtype=np.int64)

    @cached_property
    def used(self) -> np.ndarray:
        """Indices (k,) of the unknowns that the trial's residuals depend on, rising."""
        wanted = {self.shift, *(link.unknown for link in self.links)}
        for c in self.channels:
            wanted |= {c.offset, *c.drift, c.shift, c.gain}
        return np.array(sorted(wanted - {-1}), dtype=np.int64)

    @cached_property
    def linked(self) -> tuple[np.ndarray, Array]:
        """Of every link slot, unknown, and their columns in a motion and in a Jacobian, (l, 4); factors (l,)."""
        place = {slot: column for column, slot in enumerate(self.slots.tolist(), start=1)}
        column = {unknown: c for c, unknown in enumerate(self.used.tolist())}
        rows = [(link.slot, link.unknown, place[link.slot], column[link.unknown]) for link in self.links]
        return np.array(rows, dtype=np.int64).reshape(-1, 4), np.array([float(link.factor) for link in self.links])

    @cached_property
    def nuisance_columns(self) -> tuple[np.ndarray, ...]:
        """Of every channel, the Jacobian's columns of the trial's clock, its own, offset and gain (-1: none), and those
        of its drift."""
        column = {-1: -1, **{unknown: c for c, unknown in enumerate(self.used.tolist())}}
        wanted = [(self.shift, c.shift, c.offset, c.gain, *c.drift) for c in self.channels]
        return tuple(np.array([column[j] for j in one], dtype=np.int64) for one in wanted)

    @cached_property
    def edges_are_shared(self) -> bool:
        """Whether each cell ends where the next one begins: no gap, and an even clock."""
        return bool(np.all(np.abs(np.diff(self.t) - self.width_s) <= EVEN * self.width_s))

    @cached_property
    def instants(self) -> tuple[Array, int]:
        """Instants (k,) s at which the motion is needed, and how far apart two cells' beginnings stand in them.

        Lone instants: themselves, 0. Cells: n + 1 edges, 1, where they touch; else beginnings and ends in turns, 2.
        """
        half = 0.5 * self.width_s
        if half <= 0.0:
            return self.t, 0
        if self.edges_are_shared:
            return np.append(self.t - half, self.t[-1] + half), 1
        return np.column_stack([self.t - half, self.t + half]).ravel(), 2

    @cached_property
    def slow(self) -> Array:
        """What a drift of one is at each cell, (n, degrees)."""
        return self.drifting(self.t, max((len(c.drift) for c in self.channels), default=0))

    def drifting(self, t: Array, degree: int) -> Array:
        """What a drift of one is at instants t (n,), (n, degree): a straight line through zero at the window's middle,
        then Legendre's polynomials, the odd ones without that line: what the first one says is how far it went."""
        along = 2.0 * (t - self.t[0]) / (self.t[-1] - self.t[0]) - 1.0
        found: Array = 0.5 * legvander(along, degree)[:, 1:]
        found[:, 2::2] -= found[:, :1]
        return np.ascontiguousarray(found)


@dataclass(frozen=True)
class Problem:
    """All trials of one fit and all unknowns, shared ones and each trial's own."""

    unknowns: tuple[Unknown, ...]
    trials: tuple[TrialProblem, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the unknowns, in order."""
        return tuple(u.name for u in self.unknowns)

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper bounds of the unknowns, each (p,)."""
        return np.array([u.lower for u in self.unknowns]), np.array([u.upper for u in self.unknowns])

    @cached_property
    def believed(self) -> tuple[Array, Array]:
        """Centres and precisions of the unknowns' priors, each (p,)."""
        centres, widths = (np.array([getattr(u, which) for u in self.unknowns]) for which in ("start", "prior_std"))
        return centres, 1.0 / widths**2


@dataclass(frozen=True)
class TrialOptions:
    """Which nuisances a trial brings along, with the widths of their priors (priors.py); 0 leaves one out.

    ``rest_offset_std`` is the prior of the equilibrium in SI (mu N / k; its own error is added; nan: `REST_SHARE` of
    the trial's largest displacement), ``drift_std`` the displacement's drift in SI, a polynomial of time of
    ``drift_degree``. ``spring_force`` among the
    ``channels`` takes the load cells in, with a gain and a clock of their own that all trials share: a load cell late
    by tau looks like k tau more damping, but for the release's edge, so that its clock needs its prior. ``hooked`` says
    that the hook may have let go slowly: such a release is seen late.
    """

    channels: tuple[str, ...] = ("displacement", "acceleration", "velocity")
    rest_offset_std: float = math.nan
    displacement_gain_std: float = 0.0
    acceleration_gain_std: float = 0.0
    drift_std: float = 0.0
    drift_degree: int = 1
    end_s: float = math.inf
    hooked: bool = False


COARSE = 0.3
"""By so much of a cell's noise its mean may miss the motion's where samples are instants: their mean is that of the
span but for (w dt)^2 / 24, the same share in all channels of a sine, not of the overtones of drag and friction."""


FEW = 4.0
"""From so many samples a cell on their mean is near enough that of the span for any sensor (4e-5 of the motion)."""


def _samples_a_cell(motion: Motion, period_s: float, dt: float) -> float:
    """How many samples a cell of a fiftieth of the period has, no whole number; 1 where so few and so quiet ones do not
    show the mean over a cell."""
    wanted = period_s / SAMPLES_PER_PERIOD / dt
    rate = 2.0 * math.pi / period_s
    sizes = {"displacement": 1.0, "velocity": rate, "acceleration": rate**2}
    missed = (rate * dt) ** 2 / 24.0 * motion.amplitude * math.sqrt(max(wanted, 1.0))
    quiet = any(missed * sizes[q] > COARSE * noise for q, noise in motion.noise.items() if q in sizes)
    return 1.0 if quiet and wanted < FEW else wanted


@once_a_motion
def cells(motion: Motion, period_s: float, end_s: float = math.inf) -> tuple[np.ndarray, int]:
    """Indices (n_cells, m) of the window's samples, m consecutive ones a cell, and m (`COARSE`: else one).

    What follows the window fills its last cell, so that no rate loses more of the motion's end than another. Cells in
    which samples are missing are left out: the mean of what is left is of no span of the motion. Raises
    IdentificationError where fewer than 20 cells are left.
    """
    dt = motion.step_s
    # a sample stands for half a step before it too: that of the first one must lie in the motion
    chosen = np.flatnonzero(motion.inside & (motion.t >= 0.5 * dt) & (motion.t <= end_s))
    wanted = _samples_a_cell(motion, period_s, dt)
    widths = range(max(1, round(0.9 * wanted)), max(1, round(1.1 * wanted)) + 1)
    m = min(widths, key=lambda m: (-chosen.size % m, abs(m - wanted)))
    first = int(chosen[0]) if chosen.size else 0
    n = min(math.ceil(chosen.size / m), (motion.t.size - first) // m)
    index = np.arange(first, first + n * m).reshape(n, m)
    index = index[motion.t[index[:, -1]] - motion.t[index[:, 0]] < (m - 0.5) * dt]
    if len(index) < 20:
        raise IdentificationError(
            f"trial {motion.name}: {chosen.size} samples in the motion window make {len(index)} whole cells of {m}; a "
            "fit needs 20: widen trials.window"
        )
    index.setflags(write=False)
    return index, m


class ProblemBuilder:
    """Collects unknowns and trials into a Problem. The one mutable object of a fit's set-up.

    >>> b = ProblemBuilder()
    >>> b.unknown("added_mass_kg", 100.0), b.unknown("added_mass_kg", 5.0)
    (0, 0)
    """

    def __init__(self) -> None:
        self._unknowns: dict[str, Unknown] = {}
        self._places: dict[str, int] = {}
        self._trials: list[TrialProblem] = []

    def unknown(
        self,
        name: str,
        start: float,
        *,
        lower: float = -math.inf,
        upper: float = math.inf,
        prior_std: float = math.inf,
        scale: float = 1.0,
        unit: str = "",
    ) -> int:
        """Index of the unknown of that name; made with the given start, bounds and prior if it is new."""
        if name not in self._unknowns:
            self._places[name] = len(self._unknowns)
            self._unknowns[name] = Unknown(name, float(start), lower, upper, prior_std, scale, unit)
        return self._places[name]

    def unknowns(self) -> tuple[Unknown, ...]:
        """What was collected so far, in order."""
        return tuple(self._unknowns.values())

    def trial(
        self,
        motion: Motion,
        base: Array,
        links: tuple[Link, ...],
        options: TrialOptions,
        laws: tuple[PlacedTerm, ...] = (),
    ) -> None:
        """Add a trial with its own nuisances: x0, v0, shift, rest offset, accelerometer bias."""
        period = dominant_period(motion)
        index, m = cells(motion, period, options.end_s)
        t = motion.t[index].mean(axis=1)
        dt = motion.step_s
        own, shift = self._initial_state(motion, period, options.hooked)
        channels = tuple(
            self._channel(motion, quantity, index, m, options, period)
            for quantity in options.channels
            if quantity in motion.recording.channels and motion.noise.get(quantity, 0.0) > 0.0
        )
        if not channels:
            have = ", ".join(motion.recording.channels)
            raise IdentificationError(
                f"trial {motion.name}: none of {', '.join(options.channels)} is recorded (it has {have}); map one"
            )
        self._trials.append(
            TrialProblem(
                motion.name, t, np.array(base, dtype=np.float64), links + own, channels, shift,
                m * dt, period, laws, m > 1,
            )
        )  # fmt: skip

    def _initial_state(self, motion: Motion, period: float, hooked: bool) -> tuple[tuple[Link, ...], int]:
        name = motion.name
        x_start = float(motion.x[0] - motion.equilibrium.value)
        size = max(abs(x_start), 1e-3 * float(np.ptp(motion.x)))
        x0 = self.unknown(f"x0_m[{name}]", x_start, scale=size, unit="m")
        own = Link(SLOT["x0"], x0)
        if not motion.window.held:
            speed = float(np.max(np.abs(motion.v)))
            v0 = self.unknown(f"v0_m_per_s[{name}]", float(motion.v[0]), scale=speed, unit="m/s")
            return (own, Link(SLOT["v0"], v0)), -1
        seen = LATE_RELEASE_RADIANS * period / (2.0 * math.pi) if hooked else clock_std(period)
        prior = math.hypot(seen, motion.window.release_stderr_s)
        return (own,), self.unknown(f"shift_s[{name}]", 0.0, prior_std=prior, scale=prior, unit="s")

    def _channel(
        self, motion: Motion, quantity: str, index: np.ndarray, m: int, options: TrialOptions, period: float
    ) -> Channel:
        name = motion.name
        values = motion.recorded(quantity)[index].mean(axis=1)
        sigma = motion.noise[quantity] / math.sqrt(m)
        gain = shift = -1
        if quantity == "displacement":
            width = math.hypot(_rest_width(motion, options), motion.equilibrium.total_stderr)
            offset = self.unknown(
                f"rest_m[{name}]", motion.equilibrium.value, prior_std=width, scale=width, unit="m"
            )
            if options.displacement_gain_std > 0.0:
                gain = self._small(f"displacement_gain[{name}]", options.displacement_gain_std)
            degrees = ["", *range(2, options.drift_degree + 1)] if options.drift_std > 0.0 else []
            drift = tuple(self._small(f"drift_m{degree}[{name}]", options.drift_std) for degree in degrees)
            return Channel(quantity, values, sigma, offset, drift, shift, gain)
        spread = float(np.ptp(values)) or 1.0
        offset = self.unknown(f"{quantity}_offset[{name}]", 0.0, prior_std=spread, scale=1e-2 * spread)
        if quantity == "spring_force":
            gain = self._small("spring_force_gain", GAIN_STD)
            shift = self._small("spring_force_shift_s", clock_std(period))
        if quantity == "acceleration":
            shift = self._small(f"acceleration_shift_s[{name}]", clock_std(period))
            if options.acceleration_gain_std > 0.0:
                gain = self._small(f"acceleration_gain[{name}]", options.acceleration_gain_std)
        return Channel(quantity, values, sigma, offset, (), shift, gain)

    def _small(self, name: str, std: float) -> int:
        return self.unknown(name, 0.0, prior_std=std, scale=std)

    def build(self) -> Problem:
        """The finished problem; IdentificationError without a trial."""
        if not self._trials:
            raise IdentificationError(f"a fit needs at least 1 trial; it was given {len(self._trials)}")
        return Problem(tuple(self._unknowns.values()), tuple(self._trials))


def _rest_width(motion: Motion, options: TrialOptions) -> float:
    """Prior of a trial's rest position, m: as given, else relative to its largest displacement."""
    given = options.rest_offset_std
    return given if math.isfinite(given) else REST_SHARE * motion.amplitude
