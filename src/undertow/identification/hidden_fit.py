"""The final numbers of an equation with hidden oscillators: output error seeded by the regression.

The regression finds how many there are and roughly where; the trajectories then settle mass, frequency and damping
together with the equation's own coefficients, all over the inertia that moves with the body. A stiffness known
beforehand turns them into kg and N.

Belongs here: the fit and its estimates. Does not belong here: how many oscillators (hidden_search.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from undertow.conditioning.motion import Motion
from undertow.equation.kernel import MAX_HIDDEN, N_SLOTS, SLOT
from undertow.equation.term import Term
from undertow.errors import IdentificationError
from undertow.identification import output_error
from undertow.identification.hidden_modes import HankelModes, coupled_modes, hankel_modes, seeds_from_modes
from undertow.identification.hidden_search import CRITICAL_T, EQUATION_15, HiddenOscillator, HiddenSearch, find_hidden
from undertow.identification.intervals import noise_covariance
from undertow.identification.library import label
from undertow.identification.output_error import Solution
from undertow.identification.problem import Link, ProblemBuilder, TrialOptions
from undertow.identification.sindy import SindyResult, discover
from undertow.quantities import OK, Estimate

Array = NDArray[np.float64]

DRIFT_STD_M = 1e-3
"""Prior of the potentiometer's drift over a window: the common string potentiometer's."""

LARGEST_DAMPING = 1.0
LARGEST_RATIO = 5.0
"""Bounds of a hidden oscillator in the fit: far outside what the search keeps, so that a bound is never an answer."""


@dataclass(frozen=True)
class HiddenFit:
    """Equation with hidden oscillators from all trials' trajectories.

    ``coefficients`` are those of ``terms`` over the moving inertia (unit / kg); ``ratios``, ``frequencies`` (rad/s) and
    ``dampings`` those of the oscillators, in the search's order. ``outcome`` is the fit's; ``search`` how they were
    found; ``modes`` those of a short window of the largest trial; ``chi2`` the mean squared residual in units of the
    sensors' noise.
    """

    terms: tuple[Term, ...]
    coefficients: Mapping[str, Estimate]
    ratios: tuple[Estimate, ...]
    frequencies: tuple[Estimate, ...]
    dampings: tuple[Estimate, ...]
    chi2: float
    outcome: str
    search: HiddenSearch
    modes: HankelModes
    solution: Solution

    @property
    def backed(self) -> bool:
        """Whether the modes of the largest trial's short window lie where body and oscillators put them; True where
        none was found and the window has one mode."""
        stiffness = self.coefficients.get("stiffness")
        if stiffness is None or stiffness.value <= 0.0:
            return False
        hidden = [
            (w.value, z.value, r.value) for r, w, z in zip(self.ratios, self.frequencies, self.dampings, strict=True)
        ]
        expected = coupled_modes(math.sqrt(stiffness.value), hidden)
        return self.modes.agree_with(expected) and (self.count > 0 or len(self.modes.modes) == 1)

    @property
    def count(self) -> int:
        """Number of hidden oscillators."""
        return len(self.ratios)

    def moving_inertia(self, stiffness_N_per_m: float) -> Estimate:
        """Inertia that moves with the body, kg, from a stiffness known in N/m.

        IdentificationError where the equation has no stiffness.
        """
        if "stiffness" not in self.coefficients:
            raise IdentificationError(
                f"a stiffness of {stiffness_N_per_m:g} N/m gives no scale: the equation's terms are "
                f"{', '.join(self.coefficients)}; add stiffness"
            )
        found = self.coefficients["stiffness"]
        mass = stiffness_N_per_m / found.value
        return Estimate(mass, mass * found.stderr / found.value, unit="kg", source="hidden")

    def masses(self, stiffness_N_per_m: float) -> tuple[Estimate, ...]:
        """Hidden masses in kg from a stiffness known in N/m, in order."""
        scale = self.moving_inertia(stiffness_N_per_m)
        return tuple(
            Estimate(
                one.value * scale.value,
                math.hypot(one.stderr * scale.value, one.value * scale.stderr),
                unit="kg", source="hidden",
            )
            for one in self.ratios
        )  # fmt: skip

    def theta(self) -> Array:
        """The integrator's parameter vector over the moving inertia (its mass is 1), x0 and v0 zero."""
        vector = np.zeros(N_SLOTS)
        vector[SLOT["mass"]] = 1.0
        for term in self.terms:
            vector[_slot(term)] = self.coefficients[label(term)].value
            for name, value in term.inner.items():
                vector[SLOT[term.slots[name]]] = value
        for number, (m, w, z) in enumerate(zip(self.ratios, self.frequencies, self.dampings, strict=True), start=1):
            for letter, one in zip("mwz", (m, w, z), strict=True):
                vector[SLOT[f"h{letter}{number}"]] = one.value
        return vector


def discover_hidden(
    motions: Sequence[Motion],
    terms: Sequence[Term] = EQUATION_15,
    most: int = MAX_HIDDEN,
    critical_t: float = CRITICAL_T,
) -> HiddenFit:
    """The number of hidden oscillators, then all coefficients.

    Modes of a short window give starts, `find_hidden` decides how many there are, `fit_hidden` settles the numbers.
    ``critical_t`` as in `find_hidden`. With none found this is the equation's own output-error fit.
    """
    seeds = seeds_from_modes(_largest_modes(motions))
    return fit_hidden(motions, terms, find_hidden(motions, terms, most=most, critical_t=critical_t, seeds=seeds))


def _largest_modes(motions: Sequence[Motion]) -> HankelModes:
    return hankel_modes(max(motions, key=lambda motion: motion.amplitude))


def fit_hidden(
    motions: Sequence[Motion], terms: Sequence[Term], search: HiddenSearch, initial_velocity: bool = False
) -> HiddenFit:
    """Output error of all trials together, from the regression's numbers; every trial has its own x0, clock, rest.

    ``terms`` must have places in the compiled integrator. ``initial_velocity`` lets trials start with one of their own
    within the clock's prior.

    Raises IdentificationError for terms without such places, for more oscillators than the integrator holds, and where
    the start has no bounds.
    """
    own = tuple(term for term in terms if term.name != "added_mass")
    foreign = [label(term) for term in own if not term.slots]
    if foreign or search.count > MAX_HIDDEN:
        raise IdentificationError(
            f"output error integrates at most {MAX_HIDDEN} hidden oscillators and compiled terms; this equation has "
            f"{search.count} and {', '.join(foreign) or 'no other terms'}: leave some out"
        )
    start = _regression(motions, own, search.oscillators)
    builder, base = ProblemBuilder(), np.zeros(N_SLOTS)
    base[SLOT["mass"]] = 1.0
    links = []
    for term, value in zip(own, start.coefficients[: len(own)], strict=True):
        for name, inner in term.inner.items():
            base[SLOT[term.slots[name]]] = inner
        index = builder.unknown(label(term), float(value), scale=max(abs(float(value)), 1e-9))
        links.append(Link(_slot(term), index))
    for number, one in enumerate(search.oscillators, start=1):
        links += _oscillator_links(builder, number, one, float(start.coefficients[len(own) + number - 1]))
    options = TrialOptions(initial_velocity=initial_velocity, drift_std=DRIFT_STD_M)
    for motion in motions:
        builder.trial(motion, base, tuple(links), options)
    problem = builder.build()
    growing = output_error.fit(problem)
    whole = output_error.fit(problem, growing=False)
    solution = min((growing, whole), key=lambda one: one.cost)
    return _as_fit(own, search, _largest_modes(motions), solution)


def _slot(term: Term) -> int:
    return SLOT[term.slots[term.coefficient.name]]


def _regression(
    motions: Sequence[Motion], terms: tuple[Term, ...], oscillators: Sequence[HiddenOscillator]
) -> SindyResult:
    """Coefficients of the equation with the oscillators where the search left them."""
    return discover(motions, (*terms, *(one.term for one in oscillators)), subset=False)


def _oscillator_links(builder: ProblemBuilder, number: int, one: HiddenOscillator, ratio: float) -> list[Link]:
    """Mass ratio, frequency and damping of one oscillator as unknowns; its mass from the regression without rivals,
    where that is positive."""
    mass = ratio if ratio > 0.0 else one.ratio
    m = builder.unknown(f"hidden_ratio[{number}]", mass, lower=0.0, upper=LARGEST_RATIO, scale=mass)
    w = builder.unknown(f"hidden_w[{number}]", one.w, lower=0.1 * one.w, upper=10.0 * one.w, scale=one.w, unit="rad/s")
    z = builder.unknown(f"hidden_zeta[{number}]", one.zeta, lower=0.0, upper=LARGEST_DAMPING, scale=0.01)
    return [Link(SLOT[f"h{letter}{number}"], index) for letter, index in zip("mwz", (m, w, z), strict=True)]


def _as_fit(terms: tuple[Term, ...], search: HiddenSearch, modes: HankelModes, solution: Solution) -> HiddenFit:
    errors = np.sqrt(np.maximum(np.diag(noise_covariance(solution)), 0.0))
    names = solution.problem.names

    def estimate(name: str, unit: str) -> Estimate:
        place = names.index(name)
        stderr = float(errors[place])
        outcome = OK if stderr > 0.0 else f"{name} ran into a bound; its error is unknown"
        return Estimate(float(solution.values[place]), stderr or math.nan, unit=unit, source="hidden", outcome=outcome)

    numbers = range(1, search.count + 1)
    return HiddenFit(
        terms,
        MappingProxyType({label(term): estimate(label(term), f"{term.coefficient.unit} / kg") for term in terms}),
        tuple(estimate(f"hidden_ratio[{i}]", "1") for i in numbers),
        tuple(estimate(f"hidden_w[{i}]", "rad/s") for i in numbers),
        tuple(estimate(f"hidden_zeta[{i}]", "1") for i in numbers),
        solution.chi2 / solution.n_data,
        solution.outcome,
        search,
        modes,
        solution,
    )
