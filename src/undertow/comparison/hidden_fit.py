"""The final numbers of an equation with hidden oscillators: output error seeded by the regression.

The regression finds how many there are and roughly where; the trajectories then settle mass, frequency and damping
together with the equation's own coefficients, all over the inertia that moves with the body. A stiffness known
beforehand turns them into kg and N.

Belongs here: the fit and its estimates. Does not belong here: how many oscillators (hidden_search.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from undertow.comparison.hidden_modes import HankelModes, coupled_modes, hankel_modes, seeds_from_modes
from undertow.comparison.hidden_search import CRITICAL_T, EQUATION_15, HiddenSearch, HiddenStep, find_hidden
from undertow.conditioning.motion import Motion
from undertow.equation.algebra import MAX_HIDDEN, N_SLOTS, SLOT
from undertow.equation.hidden import Relaxation
from undertow.equation.term import Term
from undertow.errors import IdentificationError
from undertow.likelihood import output_error
from undertow.likelihood.output_error import Solution
from undertow.likelihood.priors import DRIFT_SHARE, STATE_IN_MOTIONS
from undertow.likelihood.problem import Link, Problem, ProblemBuilder, TrialOptions
from undertow.methods.library import label
from undertow.methods.sindy import discover
from undertow.quantities import OK, Estimate
from undertow.uncertainty.intervals import noise_covariance

Array = NDArray[np.float64]

CONFIRMED = 3.0
"""Standard errors by which a hidden mass must differ from nothing in output error: what a diagnosis asks of a name."""

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

    @property
    def confirmed(self) -> tuple[bool, ...]:
        """Whether each oscillator's mass on the trajectories is at least `CONFIRMED` standard errors."""
        return tuple(one.value > CONFIRMED * one.stderr for one in self.ratios)

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
    """The number of hidden oscillators, then all coefficients, from trials with measured acceleration.

    Modes of a short window give starts, `find_hidden` decides how many there are, `fit_hidden` settles the numbers; an
    oscillator whose mass is not confirmed there is taken out again.
    ``critical_t`` as in `find_hidden`. With none found this is the equation's own output-error fit. Where only
    displacement was recorded, `hidden_trajectories.discover_hidden_on_trajectories` does the same on the motion itself.
    """
    seeds = seeds_from_modes(largest_modes(motions))
    fit = fit_hidden(motions, terms, find_hidden(motions, terms, most=most, critical_t=critical_t, seeds=seeds))
    while not all(fit.confirmed):
        fit = fit_hidden(motions, terms, without_unconfirmed(fit))
    return fit


def without_unconfirmed(fit: HiddenFit) -> HiddenSearch:
    """The search without the oscillators whose mass the trajectories do not confirm, and a step that says so."""
    kept = tuple(one for one, sure in zip(fit.search.oscillators, fit.confirmed, strict=True) if sure)
    gone = [i for i, sure in enumerate(fit.confirmed) if not sure]
    words = ", ".join(f"{fit.frequencies[i].value:.4g} rad/s (mass ratio {fit.ratios[i]})" for i in gone)
    because = f"{len(kept)} hidden: on the trajectories {words} is under {CONFIRMED:g} standard errors; refused"
    step = HiddenStep(kept, 0.0, 0.0, min((one.t for one in kept), default=math.nan), True, False, because)
    return replace(fit.search, oscillators=kept, steps=(*fit.search.steps, step))


def largest_modes(motions: Sequence[Motion]) -> HankelModes:
    """Modes of a short window of the largest trial."""
    return hankel_modes(max(motions, key=lambda motion: motion.amplitude))


def fit_hidden(motions: Sequence[Motion], terms: Sequence[Term], search: HiddenSearch) -> HiddenFit:
    """Output error of all trials together, from the regression's numbers; every trial has its own x0, clock, rest.

    ``terms`` must have places in the compiled integrator. Hidden states are at rest at the release where a hold was
    seen, else each trial's own unknowns.

    Raises IdentificationError for terms without such places, for more oscillators than the integrator holds, and where
    the start has no bounds.
    """
    own = tuple(term for term in terms if not term.is_inertia)
    regression = discover(motions, (*own, *(one.term for one in search.oscillators)), subset=False).coefficients
    ratios = [
        float(seen) if seen > 0.0 else one.ratio
        for seen, one in zip(regression[len(own) :], search.oscillators, strict=True)
    ]
    starts = [(one.w, one.zeta, ratio) for one, ratio in zip(search.oscillators, ratios, strict=True)]
    return as_fit(motions, own, search, best_solution(hidden_problem(motions, own, regression[: len(own)], starts)))


def hidden_problem(
    motions: Sequence[Motion],
    terms: Sequence[Term],
    coefficients: Array,
    oscillators: Sequence[tuple[float, float, float]],
    relaxation: tuple[float, float] | None = None,
    times_s: tuple[float, float] = (0.0, math.inf),
) -> Problem:
    """What output error fits: ``coefficients`` (p,) of ``terms`` over the moving inertia, ``oscillators`` (w in rad/s,
    zeta, mass ratio) and a ``relaxation`` (stiffness over inertia, time in s within ``times_s``), all as starts, shared
    by all trials; raises as `fit_hidden` does."""
    foreign = [label(term) for term in terms if not term.slots]
    if foreign or len(oscillators) > MAX_HIDDEN:
        raise IdentificationError(
            f"output error integrates at most {MAX_HIDDEN} hidden oscillators and compiled terms; this equation has "
            f"{len(oscillators)} and {', '.join(foreign) or 'no other terms'}: leave some out"
        )
    builder, base, links = ProblemBuilder(), np.zeros(N_SLOTS), []
    base[SLOT["mass"]] = 1.0
    for term, value in zip(terms, coefficients, strict=True):
        for name, inner in term.inner.items():
            base[SLOT[term.slots[name]]] = inner
        lower = 0.0 if term.coefficient.lower >= 0.0 else -math.inf
        index = builder.unknown(label(term), float(value), scale=abs(float(value)) or 1.0, lower=lower)
        links.append(Link(_slot(term), index))
    for number, oscillator in enumerate(oscillators, start=1):
        links += _oscillator_links(builder, number, oscillator)
    if relaxation is not None:
        k, time = relaxation
        links += [
            Link(SLOT["rk1"], builder.unknown(Relaxation.name, k, scale=k, lower=0.0)),
            Link(SLOT["rt1"], builder.unknown(
                "relaxation_time", time, scale=time, lower=times_s[0], upper=times_s[1], unit="s")),
        ]  # fmt: skip
    drift = DRIFT_SHARE * max(motion.amplitude for motion in motions)
    for motion in motions:
        own = [] if motion.window.held else _free_state(builder, motion, len(oscillators))
        builder.trial(motion, base, (*links, *own), TrialOptions(drift_std=drift))
    return builder.build()


def best_solution(problem: Problem) -> Solution:
    """The better of a fit with growing windows and one on the whole at once: a start that is nearly right needs no
    growing, and a short window alone can lead it astray."""
    growing = output_error.fit(problem)
    whole = output_error.fit(problem, growing=False)
    return min((growing, whole), key=lambda one: one.cost)


def _slot(term: Term) -> int:
    return SLOT[term.slots[term.coefficient.name]]


def _oscillator_links(builder: ProblemBuilder, number: int, start: tuple[float, float, float]) -> list[Link]:
    """Mass ratio, frequency and damping of one oscillator as unknowns."""
    w, zeta, ratio = start
    indices = (
        builder.unknown(f"hidden_ratio[{number}]", ratio, lower=0.0, upper=LARGEST_RATIO, scale=ratio),
        builder.unknown(f"hidden_w[{number}]", w, lower=0.1 * w, upper=10.0 * w, scale=w, unit="rad/s"),
        builder.unknown(f"hidden_zeta[{number}]", zeta, lower=0.0, upper=LARGEST_DAMPING, scale=0.01),
    )
    return [Link(SLOT[f"h{letter}{number}"], index) for letter, index in zip("mwz", indices, strict=True)]


def _free_state(builder: ProblemBuilder, motion: Motion, count: int) -> list[Link]:
    """Displacement and velocity of each oscillator relative to the body at a trial's start, with the body's own size as
    prior: it was carried along before the window began."""
    size = max(motion.amplitude, float(np.ptp(motion.windowed("x"))))
    speed = float(np.max(np.abs(motion.windowed("v"))))
    links = []
    for number in range(1, count + 1):
        s = builder.unknown(
            f"hidden_s0_m[{number}][{motion.name}]", 0.0, prior_std=STATE_IN_MOTIONS * size, scale=size, unit="m"
        )
        u = builder.unknown(
            f"hidden_u0_m_per_s[{number}][{motion.name}]", 0.0, prior_std=STATE_IN_MOTIONS * speed, scale=speed,
            unit="m/s",
        )  # fmt: skip
        links += [Link(SLOT[f"hs{number}"], s), Link(SLOT[f"hu{number}"], u)]
    return links


def as_fit(
    motions: Sequence[Motion], terms: tuple[Term, ...], search: HiddenSearch, solution: Solution
) -> HiddenFit:
    """A solution of `hidden_problem` as estimates with the residual's own noise in their errors."""
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
        largest_modes(motions),
        solution,
    )
