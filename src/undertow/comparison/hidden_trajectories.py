"""A hidden oscillator where only displacement was recorded: judged on trajectories.

Without an accelerometer the regression's columns are twice differentiated noise. The trajectories are not: each
candidate equation is fitted by output error and judged by what it leaves, with effective samples. An oscillator
starts from the two largest modes of a short window, and has to beat every static rival.

Belongs here: candidates, their criterion and the choice. Does not belong here: the fit itself (hidden_fit.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from undertow.comparison.hidden_fit import HiddenFit, as_fit, best_solution, hidden_problem, largest_modes
from undertow.comparison.hidden_modes import HankelModes
from undertow.comparison.hidden_search import HiddenOscillator, HiddenSearch, HiddenStep
from undertow.conditioning.motion import Motion
from undertow.equation.hydrodynamics import CubicDamping
from undertow.equation.structure import AsymmetricStiffness, CubicStiffness, Stiffness, ViscousDamping
from undertow.equation.term import Term
from undertow.errors import IdentificationError
from undertow.likelihood import output_error
from undertow.likelihood.noise import residual_memory
from undertow.likelihood.output_error import Solution
from undertow.likelihood.problem import Problem
from undertow.methods.library import label
from undertow.methods.sindy import discover
from undertow.uncertainty.intervals import noise_covariance

Array = NDArray[np.float64]

LINEAR: tuple[Term, ...] = (Stiffness(), ViscousDamping())
STATIC_RIVALS: tuple[Term, ...] = (CubicStiffness(), AsymmetricStiffness(), CubicDamping())
"""Static laws that are offered all together in the oscillator's place."""

LEAST_EVIDENCE = 6.0
"""Difference of the criterion that decides: odds of 20 to 1, as for the rivals of a subset."""

RATIO_SHARE = 0.5
"""Start of the mass ratio, as a share of the largest that lets two modes lie as close as they do."""

LARGEST_START_RATIO = 0.3
START_DAMPING = 0.02


@dataclass(frozen=True)
class Hypothesis:
    """One equation on the trajectories: its ``name``, its ``solution``, free ``parameters`` shared by the trials or in
    a hidden state's start, and the ``criterion`` n_eff ln(mean squared residual) + parameters ln(n_eff)."""

    name: str
    solution: Solution
    parameters: int
    criterion: float

    @property
    def misfit(self) -> float:
        """Mean squared residual in units of the sensors' noise."""
        return self.solution.chi2 / self.solution.n_data


@dataclass(frozen=True)
class TrajectoryChoice:
    """``candidates``, the best first, and the ``fit`` with the number of oscillators decided for (0 or 1)."""

    candidates: tuple[Hypothesis, ...]
    fit: HiddenFit


def discover_hidden_on_trajectories(
    motions: Sequence[Motion], terms: Sequence[Term] = LINEAR, rivals: Sequence[Term] = STATIC_RIVALS
) -> TrajectoryChoice:
    """Whether one hidden oscillator explains what the equation and its static rivals cannot, and its numbers.

    Candidates: ``terms``; ``terms`` with all ``rivals``; ``terms`` with an oscillator; the rivals with one. An
    oscillator is kept where the best equation that has one beats the best that has none by `LEAST_EVIDENCE`.

    Raises IdentificationError without trials and as `fit_hidden` does.
    """
    if not motions:
        raise IdentificationError("0 motions; give at least one trial")
    own = tuple(term for term in terms if not term.is_inertia)
    beside = tuple(term for term in rivals if label(term) not in {label(one) for one in own})
    modes = largest_modes(motions)
    plain = fit_equation(motions, own)
    solutions = {"the equation alone": plain, "with an oscillator": _with_oscillator(motions, own, plain, modes)}
    if beside:
        both = fit_equation(motions, (*own, *beside), like=plain)
        solutions["with static rivals"] = both
        solutions["with rivals and an oscillator"] = _with_oscillator(
            motions, (*own, *beside), both, modes, solutions["with an oscillator"]
        )
    made = {name: one for name, one in solutions.items() if one is not None}
    n_effective = effective_values(min(made.values(), key=lambda one: one.chi2))
    candidates = sorted((weigh(name, one, n_effective) for name, one in made.items()), key=lambda one: one.criterion)
    return TrajectoryChoice(tuple(candidates), _decide(motions, own, beside, candidates, n_effective))


def fit_equation(motions: Sequence[Motion], terms: Sequence[Term], like: Solution | None = None) -> Solution:
    """An equation without hidden states by output error, per moving inertia.

    The search starts from the regression on the smoothed motion and, where given, from what a smaller equation
    ``like`` this one ended at, so that a larger one never leaves more. Raises IdentificationError where no start has
    bounds.
    """
    own = tuple(terms)
    if like is not None:
        problem = hidden_problem(motions, own, np.array([_value(like, label(term)) for term in own]), [])
        return _carried_on(problem, like)
    first = discover(motions, own, subset=False).coefficients
    return best_solution(hidden_problem(motions, own, _sound(own, first), []))


def _value(solution: Solution, name: str) -> float:
    """An unknown's value; 0 where the solution does not have it."""
    return solution.value(name) if name in solution.problem.names else 0.0


def _carried_on(problem: Problem, like: Solution) -> Solution:
    """The search from where a smaller equation ended, every unknown that both have taken over."""
    start = np.array(
        [_value(like, one.name) if one.name in like.problem.names else one.start for one in problem.unknowns]
    )
    return output_error.fit(problem, start, growing=False)


def _sound(terms: tuple[Term, ...], values: Array) -> Array:
    """Starts within their signs."""
    lower = np.array([0.0 if term.coefficient.lower >= 0.0 else -math.inf for term in terms])
    return np.asarray(np.maximum(values, lower), dtype=np.float64)


def _with_oscillator(
    motions: Sequence[Motion],
    terms: tuple[Term, ...],
    without: Solution,
    modes: HankelModes,
    smaller: Solution | None = None,
) -> Solution | None:
    """The best fit with one oscillator; None where the window has one mode.

    Starts: both ways in which two modes can belong to body and oscillator, and a ``smaller`` equation's oscillator.
    """
    start = _sound(terms, np.array([without.value(label(term)) for term in terms]))
    names = [term.name for term in terms]
    tried = []
    for body_w, oscillator in _starts(modes):
        values = start.copy()
        if "stiffness" in names:
            values[names.index("stiffness")] = body_w**2
        try:
            tried.append(best_solution(hidden_problem(motions, terms, values, [oscillator])))
        except IdentificationError:  # a start whose motion has no bounds says nothing against the other
            continue
    if smaller is not None:
        values = np.array([_value(smaller, label(term)) for term in terms])
        oscillator = (smaller.value("hidden_w[1]"), smaller.value("hidden_zeta[1]"), smaller.value("hidden_ratio[1]"))
        tried.append(_carried_on(hidden_problem(motions, terms, values, [oscillator]), smaller))
    return min(tried, key=lambda one: one.cost) if tried else None


def _starts(modes: HankelModes) -> list[tuple[float, tuple[float, float, float]]]:
    """Body's w_0 and oscillator (w, zeta, ratio) whose coupled modes are the window's two largest.

    w_0^2 and (1 + r) w^2 are the roots of y^2 - (w_a^2 + w_b^2) y + (1 + r) w_a^2 w_b^2 = 0; they are real up to a
    largest ratio r. Which root is the body's is open: both are starts.

    >>> from undertow.comparison.hidden_modes import Mode, coupled_modes
    >>> modes = HankelModes((Mode(8.0, 0.02, 1.0), Mode(6.0, 0.02, 0.5)), 4, np.ones(4))
    >>> [[round(w, 6) for w, _ in coupled_modes(w0, [(w, 0.0, r)])] for w0, (w, _, r) in _starts(modes)]
    [[6.0, 8.0], [6.0, 8.0]]
    """
    if len(modes.modes) < 2:
        return []
    one, other = (mode.w**2 for mode in modes.modes[:2])
    total, product = one + other, one * other
    ratio = min(RATIO_SHARE * (total**2 / (4.0 * product) - 1.0), LARGEST_START_RATIO)
    root = math.sqrt(max(total**2 - 4.0 * (1.0 + ratio) * product, 0.0))
    return [
        (math.sqrt(square), (math.sqrt(product / square), START_DAMPING, ratio))
        for square in (0.5 * (total + root), 0.5 * (total - root))
    ]


def effective_values(solution: Solution) -> float:
    """Independent values among the residuals of the best fit: n over their memory."""
    return solution.n_data / residual_memory(solution)


def weigh(name: str, solution: Solution, n_effective: float) -> Hypothesis:
    """The criterion of one candidate; the trials' own nuisances are in all of them alike."""
    shared = [unknown for unknown in solution.problem.names if "[" not in unknown or unknown.startswith("hidden_")]
    criterion = n_effective * math.log(solution.chi2 / solution.n_data) + len(shared) * math.log(n_effective)
    return Hypothesis(name, solution, len(shared), criterion)


def _decide(
    motions: Sequence[Motion],
    own: tuple[Term, ...],
    beside: tuple[Term, ...],
    candidates: Sequence[Hypothesis],
    n_effective: float,
) -> HiddenFit:
    """The fit that stands, and the sentence why."""
    hidden = [one for one in candidates if "oscillator" in one.name]
    without = [one for one in candidates if "oscillator" not in one.name]
    best = without[0]
    evidence = best.criterion - hidden[0].criterion if hidden else -math.inf
    kept = evidence > LEAST_EVIDENCE
    chosen = hidden[0] if kept else best
    terms = tuple(term for term in (*own, *beside) if label(term) in chosen.solution.problem.names)
    oscillator = _oscillator(hidden[0].solution) if hidden else ()
    gain = 1.0 - hidden[0].misfit / best.misfit if hidden else 0.0
    verdict = "kept" if kept else "refused"
    because = "1 hidden: the window has one mode; refused"
    if oscillator:
        because = (
            f"1 hidden: {oscillator[0].w:.4g} rad/s, mass ratio {oscillator[0].ratio:.3g}; {hidden[0].name} leaves "
            f"{100.0 * (1.0 - gain):.0f} % of what {best.name} leaves; {verdict}, the evidence is {evidence:.1f}"
        )
    weakest = oscillator[0].t if oscillator else math.nan
    step = HiddenStep(oscillator, gain, evidence, weakest, bool(oscillator), kept, because)
    stiffness = chosen.solution.value("stiffness") if "stiffness" in chosen.solution.problem.names else math.nan
    search = HiddenSearch(
        oscillator if kept else (), (step,), math.sqrt(max(stiffness, 0.0)), n_effective,
        tuple(label(term) for term in own), tuple(label(term) for term in beside),
    )  # fmt: skip
    return as_fit(motions, terms, search, chosen.solution)


def _oscillator(solution: Solution) -> tuple[HiddenOscillator, ...]:
    """The fitted oscillator with its ratio's error from the residual as it is."""
    place = solution.problem.names.index("hidden_ratio[1]")
    stderr = math.sqrt(max(float(noise_covariance(solution)[place, place]), np.finfo(float).tiny))
    w, zeta, ratio = (solution.value(f"hidden_{name}[1]") for name in ("w", "zeta", "ratio"))
    return (HiddenOscillator(w, zeta, ratio, stderr, (ratio,)),)
