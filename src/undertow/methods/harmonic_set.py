"""The numbers of an equation from a harmonic set: amplitude and phase of the motion under F cos(w t), at many w.

    M x'' + sum of laws = F cos(w t),   x = A cos(w t + phase) + overtones

or -M y'' on a base that moves as y = Y cos(w t), with x relative to it.

Start values come from the balance of the fundamental alone (Krylov and Bogoliubov 1937), which is linear in the laws'
coefficients: every law's force on the measured A cos(w t + phase), its part at w against the force. From there the
steady motion itself is fitted (steady_state.py), each point on the branch on which it was measured.

Belongs here: that regression and that fit. Does not belong here: steady states, what a user sees (front/response.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from undertow.conditioning.harmonic import HarmonicSet
from undertow.equation.driven_laws import DrivenUnknown, must_be_apart, numbers_to_find, places, without_memory
from undertow.equation.driven_slots import DRIVEN_SLOT, N_DRIVEN
from undertow.equation.input import MotionSize
from undertow.equation.steady_state import NOTHING, SteadyState, closed_orbit, settled
from undertow.equation.term import Array, Term
from undertow.errors import IdentificationError
from undertow.quantities import OK, Estimate

ANGLES = 256
"""Instants of a period at which a law's force on a cosine is taken."""

UNFELT = 1e-9
"""Share of a law's force below which its part at the drive's frequency is rounding: by symmetry it has none."""

MASS = "mass_kg"
STARTS_AT_ONE = {"gain": 1.0, "bw_unit": 1.0, "bw_n": 1.0}
"""Slots that are not zero where nothing is said of them."""


@dataclass(frozen=True)
class HarmonicFit:
    """``numbers`` by mass_kg and law.parameter, ``theta`` (driven_slots.DRIVEN_SLOTS), the steady states fitted (None
    where the search found none), ``rms`` of what cosine and sine miss, unit of the amplitude, and each point's
    ``missed`` (2, n); ``covariance`` of the numbers that were ``free``, ``terms`` with their ``held`` numbers;
    ``outcome`` is ok, or says which numbers ended on a bound and at how many points there is no steady motion."""

    numbers: Mapping[str, Estimate]
    theta: Array
    states: tuple[SteadyState | None, ...]
    rms: float
    missed: Array
    free: tuple[str, ...]
    covariance: Array
    terms: tuple[Term, ...]
    held: Mapping[str, float]
    outcome: str = OK

    @property
    def values(self) -> dict[str, float]:
        """The numbers without their errors: starts for another fit."""
        return {name: one.value for name, one in self.numbers.items()}


def harmonic_theta(values: Mapping[str, float], unknowns: Sequence[DrivenUnknown]) -> Array:
    """The driven integrator's vector from numbers by name."""
    theta = np.zeros(N_DRIVEN)
    for slot, value in STARTS_AT_ONE.items():
        theta[DRIVEN_SLOT[slot]] = value
    theta[DRIVEN_SLOT["mass"]] = values[MASS]
    for unknown in unknowns:
        for slot in unknown.slots:
            theta[DRIVEN_SLOT[slot]] += values[unknown.name]
    return theta


def fit_harmonic_set(
    measured: HarmonicSet, terms: Sequence[Term], held: Mapping[str, float], starts: Mapping[str, float],
    whole: bool = True, evaluations: int | None = None,
) -> HarmonicFit:  # fmt: skip
    """Mass and laws from a harmonic set by least squares on cosine and sine.

    ``held`` and ``starts`` go by mass_kg and law.parameter; on a base that moves the mass is held at 1 kg where no
    number is. Raises ConfigError for a law with a memory or a name that the equation lacks, IdentificationError where
    there are more unknowns than measured values, and where the equation has no steady motion near some points (not
    ``whole``: these count as points at which it stands still). ``evaluations`` ends a search early.
    """
    without_memory(terms)
    unknowns = places(terms, measured.mover)
    names = [MASS, *(u.name for u in unknowns)]
    if measured.mover != "force" and not held:
        held = {MASS: 1.0}
    free = numbers_to_find(names, held, starts)
    must_be_apart({u.name: u.slots for u in unknowns if u.name in free})
    if len(free) > 2 * measured.rate.size:
        raise IdentificationError(
            f"{len(free)} numbers are unknown ({', '.join(free)}), and {measured.rate.size} points hold "
            f"{2 * measured.rate.size} measured values; give more points, or hold numbers"
        )
    first = {**_balanced(measured, unknowns, held, starts), **starts, **held}
    search = _Missed(measured, unknowns, first, free)
    limits = {u.name: (u.parameter.lower, u.parameter.upper) for u in unknowns} | {MASS: (1e-9, np.inf)}
    lower, upper = np.array([limits[name] for name in free]).reshape(-1, 2).T / search.scale
    start = np.clip(np.array([first[name] for name in free]) / search.scale, lower, upper)
    found = least_squares(search.missed, start, search.slopes, (lower, upper), x_scale="jac", max_nfev=evaluations)
    states = search.at(found.x)
    lost = [rate for rate, s in zip(measured.rate, states, strict=True) if s is None]
    if whole and lost:
        raise IdentificationError(
            f"the equation has no steady motion near what was measured at {len(lost)} of {len(states)} points (the "
            f"first at {lost[0] / (2.0 * math.pi):.6g} Hz); it lacks a law, or a start value is far off"
        )
    size = 1.0 if measured.sigma.size else math.sqrt(2.0 * found.cost / max(found.fun.size - len(free), 1))
    covariance = np.linalg.pinv(found.jac.T @ found.jac, hermitian=True) * size**2
    covariance *= np.outer(search.scale, search.scale)
    errors = np.sqrt(np.diag(covariance))
    units = {u.name: u.parameter.unit for u in unknowns} | {MASS: "kg"}
    values = dict(zip(free, zip((found.x * search.scale).tolist(), errors.tolist(), strict=True), strict=True))
    values |= {name: (float(value), 0.0) for name, value in held.items()}
    numbers = {name: Estimate(*values[name], unit=units[name]) for name in names}
    theta = harmonic_theta({name: e.value for name, e in numbers.items()}, unknowns)
    left = (search.missed(found.x) * np.tile(search.sigma, 2)).reshape(2, -1)
    bound = [name for name, side in zip(free, found.active_mask, strict=True) if side]
    said = [f"on a bound: {', '.join(bound)}"] if bound else []
    said += [f"no steady motion at {len(lost)} of {len(states)} points"] if lost else []
    return HarmonicFit(
        numbers, theta, tuple(states), float(np.sqrt(np.mean(left**2))), left, tuple(free), covariance, tuple(terms),
        dict(held), "; ".join(said) or OK,
    )  # fmt: skip


def missed_at(fitted: HarmonicFit, measured: HarmonicSet) -> Array:
    """What a fitted equation misses of the cosines and sines (2, n) of a set that it need not have seen, each point on
    its own branch; the whole motion where the equation has none there."""
    states = [_on_branch(fitted.theta, measured, i, NOTHING) for i in range(measured.rate.size)]
    both = np.array([(0.0, 0.0) if s is None else (s.cosine, s.sine) for s in states]).T
    return np.asarray(both - [measured.cosine, measured.sine])


class _Missed:
    """What a set of unknowns, each over its start value, misses of the measured cosines and sines, with slopes."""

    def __init__(
        self, measured: HarmonicSet, unknowns: Sequence[DrivenUnknown], first: Mapping[str, float], free: Sequence[str]
    ) -> None:
        self.measured, self.unknowns, self.first, self.free = measured, unknowns, first, free
        self.scale = np.array([abs(first[name]) or 1.0 for name in free])
        alike = np.full(measured.rate.size, float(np.max(measured.amplitude)))
        self.sigma = measured.sigma if measured.sigma.size else alike
        self.active, self.gather = slots_of(free, unknowns)
        self._last: tuple[bytes, list[SteadyState | None]] = (b"", [])

    def at(self, scaled: Array) -> list[SteadyState | None]:
        """The steady motion at every point."""
        key = scaled.tobytes()
        if key != self._last[0]:
            values = {**self.first, **dict(zip(self.free, scaled * self.scale, strict=True))}
            theta = harmonic_theta(values, self.unknowns)
            points = range(self.measured.rate.size)
            self._last = key, [_on_branch(theta, self.measured, i, self.active) for i in points]
        return self._last[1]

    def missed(self, scaled: Array) -> Array:
        """Cosines and then sines (2 n,) less the measured ones, in standard errors."""
        both = np.array([(0.0, 0.0) if s is None else (s.cosine, s.sine) for s in self.at(scaled)]).T
        return np.asarray((both - [self.measured.cosine, self.measured.sine]) / self.sigma).ravel()

    def slopes(self, scaled: Array) -> Array:
        """Their derivatives (2 n, p)."""
        none = np.zeros((2, self.active.size))
        each = np.array([none if s is None else s.slopes for s in self.at(scaled)]).swapaxes(0, 1)  # (2, n, slots)
        weighed = (each / self.sigma[:, None]).reshape(-1, self.active.size)
        return np.asarray(weighed @ self.gather * self.scale)


def slots_of(names: Sequence[str], unknowns: Sequence[DrivenUnknown]) -> tuple[np.ndarray, Array]:
    """Slots (q,) of these numbers, and which slot each of them stands in (q, p): slopes by slots times this matrix are
    slopes by numbers."""
    columns = [_slots(name, unknowns) for name in names]
    active = np.array(sorted({slot for slots in columns for slot in slots}), dtype=np.int64)
    return active, np.array([[float(slot in slots) for slots in columns] for slot in active.tolist()])


def _slots(name: str, unknowns: Sequence[DrivenUnknown]) -> tuple[int, ...]:
    if name == MASS:
        return (DRIVEN_SLOT["mass"],)
    return next(tuple(DRIVEN_SLOT[slot] for slot in u.slots) for u in unknowns if u.name == name)


def _on_branch(theta: Array, measured: HarmonicSet, i: int, active: np.ndarray) -> SteadyState | None:
    """The steady motion next to the measured one, else what the body is drawn to from there; None where there is
    neither."""
    if not theta[DRIVEN_SLOT["mass"]] > 0.0:
        return None
    rate, force = float(measured.rate[i]), float(measured.force[i])
    guess = np.array([measured.cosine[i], measured.sine[i] * rate])
    extent = MotionSize(float(measured.amplitude[i]), float(measured.amplitude[i]) * rate)
    found = closed_orbit(theta, force, rate, guess, extent, active, measured.mover)
    if found is not None:
        return found
    try:
        drawn = settled(theta, force, rate, guess, extent, measured.mover)
    except IdentificationError:
        return None
    return closed_orbit(theta, force, rate, drawn.state, extent, active, measured.mover)


def _balanced(
    measured: HarmonicSet, unknowns: Sequence[DrivenUnknown], held: Mapping[str, float], starts: Mapping[str, float]
) -> dict[str, float]:
    """Mass and every law's coefficient from the balance of the fundamental; what a law has inside as it is given."""
    inside = [u for u in unknowns if u.parameter != u.term.coefficient]
    inner = {u.name: float(u.term.inner.get(u.parameter.name, 0.0)) for u in inside}
    angle = 2.0 * math.pi * np.arange(ANGLES) / ANGLES
    waves = np.array([np.cos(angle), np.sin(angle)]) * (2.0 / ANGLES)
    columns: dict[str, list[Array]] = {MASS: []}
    linear = [u for u in unknowns if u.name not in inner]
    for u in linear:
        columns[u.name] = []
    based = measured.mover != "force"
    for rate, amplitude, phase, force in zip(
        measured.rate, measured.amplitude, measured.phase, measured.force, strict=True
    ):
        x, v = amplitude * np.cos(angle + phase), -amplitude * rate * np.sin(angle + phase)
        a, t = -(rate**2) * x, angle / rate
        beside = (force / rate * np.sin(angle), force * np.cos(angle)) if based else (0.0, 0.0)
        columns[MASS].append(waves @ (a + beside[1]) / force)
        for u in linear:
            wet = u.term.relative_to == "water"
            seen = (v + beside[0], a + beside[1]) if wet else (v, a)
            acting = np.asarray(u.term.force(x, *seen, t))
            part = waves @ acting
            felt = np.abs(part) > UNFELT * float(np.max(np.abs(acting)))
            columns[u.name].append(np.where(felt, part, 0.0) / force)
    known = {**starts, **held}
    whole = {name: np.concatenate(parts) for name, parts in columns.items()}
    asked = [name for name in whole if name not in known]
    left = np.tile([0.0 if based else 1.0, 0.0], measured.rate.size) - sum(
        (known[name] * column for name, column in whole.items() if name in known), np.zeros(2 * measured.rate.size)
    )
    if not asked:
        return inner
    matrix = np.column_stack([whole[name] for name in asked])
    size = np.maximum(np.linalg.norm(matrix, axis=0), 1e-300)
    solved = np.linalg.lstsq(matrix / size, left, rcond=1e-10)[0] / size
    return inner | dict(zip(asked, solved.tolist(), strict=True))
