"""Driven trials as problems of the one search: unknowns, windows with start states of their own, start values.

A long record goes in windows, each with a start state of its own, so that a wrong equation or a body that sticks cannot
lead a search astray; then the windows are joined, and the record is one motion with one start state.

Belongs here: how a driven trial and a law set become a `Problem`. Does not belong here: the search (output_error.py),
start values from the record itself (methods/driven_start.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
from scipy.signal import savgol_filter

from undertow.conditioning.driven import DrivenTrial
from undertow.equation.base_motion import moving_drive
from undertow.equation.driven_laws import DrivenUnknown, must_be_apart, places
from undertow.equation.driven_slots import DRIVEN_SLOT, N_DRIVEN
from undertow.equation.input import Drive, MotionSize, drive_of
from undertow.equation.term import Term
from undertow.likelihood.problem import Channel, Link, Problem, ProblemBuilder, TrialProblem
from undertow.quantities import Mover
from undertow.recording.recording import Array

SLOPE_SAMPLES = 7
"""Samples of the cubic that a window's start velocity is taken from."""

MASS = "mass_kg"
"""Name of the inertia among the unknowns."""

OSCILLATING = "hm"
"""Slot of a hidden oscillator's mass, before its number."""
SWINGS = 10.0
"""How far a hidden oscillator may swing where a record begins, in extents of the body's motion: a prior that hardly
acts, since one with 5 % of critical damping goes so far at its resonance."""


@dataclass(frozen=True)
class DrivenLaws:
    """An equation to be fitted to driven trials: its laws, what is held at a value, start values of the rest.

    ``fixed`` and ``starts`` go by the unknown's name: ``mass_kg``, law.parameter, ``input_gain`` (N per unit),
    ``input_delay_s``. ``priors`` gives mean and standard deviation of what is known beforehand.
    """

    terms: tuple[Term, ...]
    fixed: Mapping[str, float] = field(default_factory=dict)
    starts: Mapping[str, float] = field(default_factory=dict)
    priors: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def places(self) -> tuple[DrivenUnknown, ...]:
        """Every parameter of the laws with its slot."""
        return places(self.terms)

    @property
    def units(self) -> Mapping[str, str]:
        """Unit of the inertia and of every parameter, by the unknown's name."""
        return {MASS: "kg"} | {place.name: place.parameter.unit for place in self.places}

    @property
    def memory(self) -> str:
        """Name of the number that is the stiffness of a small loop of the hysteresis; empty where there is none."""
        return next((place.name for place in self.places if place.slots == ("bw_a",)), "")

    @property
    def oscillators(self) -> tuple[str, ...]:
        """Numbers of the hidden oscillators' slots; in the middle of a record these do not begin at rest."""
        inertias = (slot for place in self.places for slot in place.slots if slot[:-1] == OSCILLATING)
        return tuple(slot.removeprefix(OSCILLATING) for slot in inertias)

    @property
    def usual(self) -> dict[str, float]:
        """Numbers that are held at their rows' values, because nobody gave them."""
        return {
            place.name: float(getattr(place.term, place.parameter.name))
            for place in self.places
            if place.parameter.name in place.term.held_unless_asked
            and place.name not in {*self.fixed, *self.starts, *self.priors}
        }


def drive_for(trial: DrivenTrial) -> Drive:
    """The trial's input between its samples; the acceleration of base or water where that moves."""
    if trial.quantity == "force":
        return drive_of(trial.t, trial.u, trial.hold)
    return moving_drive(trial.t, trial.u, trial.quantity, trial.hold, trial.absolute)


def against_base(trial: DrivenTrial) -> DrivenTrial:
    """The trial with every output relative to its base, by the recorded input as it stands."""
    if not trial.absolute:
        return trial
    drive, outputs = drive_for(trial), dict(trial.outputs)
    moved = {"acceleration": drive.at, "velocity": drive.velocity_at, "displacement": drive.displacement_at}
    for name in trial.absolute:
        outputs[name] = outputs[name] - moved[name](trial.t)
    return replace(trial, outputs=outputs, frames=dict.fromkeys(outputs, "relative"))


def slopes(t: Array, x: Array) -> Array:
    """Velocity (n,) of a recorded displacement from short cubics, unit of x a second."""
    step = float(np.median(np.diff(t)))
    window = min(SLOPE_SAMPLES, x.size - (x.size + 1) % 2)
    return np.asarray(savgol_filter(x, window, 3, deriv=1, delta=step), dtype=np.float64)


def extent_of(trial: DrivenTrial) -> MotionSize:
    """How far and how fast the trial's body moves; a recorded velocity or acceleration alone gives its own size."""
    trial = against_base(trial)
    if "displacement" in trial.outputs:
        x = trial.outputs["displacement"]
        speed = trial.outputs.get("velocity", slopes(trial.t, x))
        return MotionSize(float(np.max(np.abs(x))) or 1.0, float(np.max(np.abs(speed))) or 1.0)
    span = float(trial.t[-1] - trial.t[0])
    v = trial.outputs.get("velocity")
    speed_size = float(np.max(np.abs(v))) if v is not None else float(np.max(np.abs(trial.outputs[trial.main]))) * span
    return MotionSize(speed_size * span or 1.0, speed_size or 1.0)


def driven_problem(
    trials: Sequence[DrivenTrial],
    laws: DrivenLaws,
    windows: int = 1,
    noise: Mapping[str, Mapping[str, float]] | None = None,
    drives: Mapping[str, Drive] | None = None,
    extents: Mapping[str, MotionSize] | None = None,
    begun: Mapping[str, Mapping[str, float]] | None = None,
) -> Problem:
    """All trials, each in so many windows of equal length with start states of their own, and the equation's unknowns.

    ``noise`` gives each trial's outputs their standard deviation (default: the trial's own white noise); ``drives``
    the inputs between samples, ``extents`` how far the bodies move, where that is known already; ``begun`` the start
    states that are held, by the trial's name (of a trial in windows: name:number) and the state's slot.
    """
    builder = ProblemBuilder()
    shared = _equation_unknowns(builder, laws, sorted({trial.mover for trial in trials}))
    pieces: list[TrialProblem] = []
    for trial in trials:
        drive = (drives or {}).get(trial.name) or drive_for(trial)
        sigma = (noise or {}).get(trial.name) or trial.noise()
        extent = (extents or {}).get(trial.name) or extent_of(trial)
        moved = against_base(trial).outputs
        x, speed = moved.get("displacement"), moved.get("velocity")
        if speed is None and x is not None:
            speed = slopes(trial.t, x)
        ends = np.linspace(0, trial.t.size, windows + 1).astype(int)
        for i, (begin, end) in enumerate(pairwise(ends)):
            label = trial.name if windows == 1 else f"{trial.name}:{i}"
            begins = tuple(0.0 if values is None else float(values[begin]) for values in (x, speed))
            held = (begun or {}).get(label, {})
            own = _start_state(builder, begins, extent, label, laws, _base_unknown(drive, laws), held)
            cut = slice(int(begin), int(end))
            channels = tuple(Channel(name, values[cut], sigma[name]) for name, values in trial.outputs.items())
            base, links = shared[trial.mover]
            base = _holding(base, held)
            times = np.array(trial.t[cut])
            pieces.append(TrialProblem(label, times, base, links + own, channels, drive=drive, extent=extent))
    return Problem(builder.unknowns(), tuple(pieces))


def _holding(base: Array, held: Mapping[str, float]) -> Array:
    """A trial's fixed numbers with those of a start state that is held, by slot."""
    base = base.copy()
    for name, value in held.items():
        base[DRIVEN_SLOT[name]] = value
    return base


def _equation_unknowns(
    builder: ProblemBuilder, laws: DrivenLaws, kinds: Sequence[Mover]
) -> dict[Mover, tuple[Array, tuple[Link, ...]]]:
    """Unknowns of the equation. Per kind of trial (what drives): what is held as a vector, and links."""
    wanted: list[tuple[str, str, float, float, float]] = [(MASS, "kg", 0.0, np.inf, 1.0)]
    for place in laws.places:
        p = place.parameter
        wanted.append((place.name, p.unit, p.lower, p.upper, float(getattr(place.term, p.name, 0.0))))
    wanted += [("input_gain", "N", -np.inf, np.inf, 1.0), ("input_delay_s", "s", -np.inf, np.inf, 0.0)]
    usually: dict[str, tuple[str, ...]] = {MASS: ("mass",), "input_gain": ("gain",), "input_delay_s": ("delay",)}
    at = {kind: usually | {place.name: place.slots for place in places(laws.terms, kind)} for kind in kinds}
    held = {kind: np.zeros(N_DRIVEN) for kind in kinds}
    links: dict[Mover, list[Link]] = {kind: [] for kind in kinds}
    for base in held.values():
        for slot, value in (pair for term in laws.terms for pair in term.constants.items()):
            base[DRIVEN_SLOT[slot]] = value
    fixed = {**laws.usual, **laws.fixed}
    free = [place.name for place in laws.places if place.name not in {*fixed, *laws.priors}]
    must_be_apart({name: tuple(at[kind][name] for kind in kinds) for name in free})
    for name, unit, lower, upper, usual in wanted:
        mean, std = laws.priors.get(name, (laws.starts.get(name, usual), np.inf))
        own = name.startswith("input_") and name not in laws.starts and name not in laws.priors
        if name in fixed or own:
            for kind, base in held.items():
                for slot in at[kind][name]:
                    base[DRIVEN_SLOT[slot]] += fixed.get(name, usual)
            continue
        index = builder.unknown(
            name, mean, lower=lower, upper=upper, prior_std=std, scale=abs(mean) or 1.0, unit=unit
        )
        for kind in kinds:
            links[kind] += [Link(DRIVEN_SLOT[slot], index) for slot in at[kind][name]]
    return {kind: (held[kind], tuple(links[kind])) for kind in kinds}


def _base_unknown(drive: Drive, laws: DrivenLaws) -> float:
    """Standard deviation of what the velocity of base or water at a start is beyond its record, m/s; 0 where nothing
    is."""
    wet = any(term.relative_to == "water" and not {"mass", "wave"} & {*term.slots.values()} for term in laws.terms)
    return drive.drifts if wet or "velocity" in drive.absolute else 0.0


def _start_state(
    builder: ProblemBuilder,
    begins: tuple[float, ...],
    extent: MotionSize,
    label: str,
    laws: DrivenLaws,
    base_speed: float,
    held: Mapping[str, float],
) -> tuple[Link, ...]:
    """Start displacement, velocity, hysteresis and hidden motions of a window: unknowns, from the samples where it
    begins; and what the velocity of base or water is beyond an integral, where ``base_speed`` is not 0. What is
    ``held``, by slot, is no unknown."""
    x0, v0 = begins
    links: list[Link] = []

    def own(slot: str, name: str, start: float, std: float, scale: float) -> None:
        """An unknown of this window alone."""
        if slot not in held:
            index = builder.unknown(f"{name}[{label}]", start, prior_std=std, scale=scale)
            links.append(Link(DRIVEN_SLOT[slot], index))

    # twice the extent as prior: none to speak of, but a record too short for its start stays finite
    own("x0", "x0_m", x0, 2.0 * extent.size, extent.size)
    own("v0", "v0_m_per_s", v0, 4.0 * extent.speed, extent.speed)
    if laws.memory:
        stiffness = laws.fixed.get(laws.memory, laws.starts.get(laws.memory, 1.0))
        pull = abs(stiffness) * extent.size or 1.0
        own("bw_z0", "z0_N", 0.0, pull, pull)
    for number in laws.oscillators:
        own(f"hs{number}", f"s0_m_{number}", 0.0, SWINGS * extent.size, extent.size)
        own(f"hu{number}", f"s0_m_per_s_{number}", 0.0, SWINGS * extent.speed, extent.speed)
    if base_speed > 0.0:
        own("absolute_v0", "base_v0_m_per_s", 0.0, base_speed, base_speed)
    return tuple(links)
