"""The config's equation fitted to a group's trials by output error.

Belongs here: that fit, and its estimates with errors. Does not belong here: which unknowns an equation has (group.py),
what the equation leaves out.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from undertow.conditioning.motion import Motion
from undertow.equation import registry
from undertow.equation.equation import Equation
from undertow.equation.kernel import SLOT
from undertow.equation.term import Term
from undertow.errors import IdentificationError
from undertow.likelihood import multistart as blind
from undertow.likelihood import output_error
from undertow.likelihood.fit import Fit, Structure
from undertow.likelihood.group import Coefficient, GroupModel, group_model, terms_by_name
from undertow.likelihood.multistart import as_recorded
from undertow.likelihood.output_error import Solution
from undertow.likelihood.problem import Link, Problem, ProblemBuilder, TrialOptions
from undertow.likelihood.scale import structural_parameters, with_scale_error
from undertow.quantities import OK, Estimate
from undertow.recording.recording import Array
from undertow.uncertainty.confidence import as_stderr, widening
from undertow.uncertainty.hierarchy import Effect, Held, group_posterior, held_intervals
from undertow.uncertainty.intervals import noise_covariance, noise_factors, residual_covariance

WITHIN_NOISE = 2.0
"""Mean squared residual in units of noise up to which a fit needs no second start: what is left is noise."""


INNER_STARTS = (0.1, 0.3, 3.0, 10.0)
"""Multiples of a law's inner number as it usually is from which it is sought where a fit leaves more than noise."""

HALF_PERIODS = range(2, 17)
"""The same of a delay, in half periods: a fit moves it by a quarter of one."""

WITHIN_COLOUR = 5.0
"""The same for a fit with random effects: coloured noise and drift, which differences of samples do not see."""

REWEIGHED = 2
"""So often noise is set to what a fit with random effects leaves: what the first leaves is bent by what it took up."""


@dataclass(frozen=True)
class GroupFit:
    """A group's equation with its numbers: the search's solution, estimates by contract name, and the model."""

    model: GroupModel
    solution: Solution
    estimates: Mapping[str, Estimate]
    outcome: str

    @property
    def values(self) -> dict[str, float]:
        """Values of the model's coefficients by name."""
        return {c.name: self.estimates[c.name].value for c in self.model.coefficients}

    def equation(self) -> Equation:
        """The equation with the group's numbers in force units (or per mass), structure included."""
        theta = self.model.theta(self.values)
        terms, numbers = [], []
        for term in self.model.terms:
            if term.is_inertia:
                terms.append(term)
                numbers.append(float(theta[SLOT["mass"]]) - self.model.specimen.mass_kg)
                continue
            inner = {p.name: float(theta[self._place(term, p.name)]) for p in term.parameters[1:]}
            if term.slot_parameters:
                inner |= term.of_slots({slot: float(theta[SLOT[slot]]) for slot in term.slots.values()})
            terms.append(replace(term, **inner) if inner else term)
            numbers.append(self._number(term, theta))
        added = any(t.is_inertia for t in terms)
        mass = self.model.specimen.mass_kg if added else float(theta[SLOT["mass"]])
        return Equation(tuple(terms), tuple(numbers), mass_kg=mass)

    def _place(self, term: Term, parameter: str) -> int:
        """Place of a term's parameter in the parameter vector; the first of a numbered one."""
        if not term.slots:
            return self.model.place(f"{term.name}.{parameter}")
        slot = term.slots[parameter]
        return SLOT[slot if slot in SLOT else f"{slot}1"]

    def _number(self, term: Term, theta: Array) -> float:
        """A term's coefficient in a parameter vector: damping of the structure and of the water share a place there,
        and each has its own."""
        place = self._place(term, term.coefficient.name)
        here = {c.name: c.factor * self.estimates[c.name].value for c in self.model.coefficients
                if self.model.place(c.slot) == place}  # fmt: skip
        own = [here[c.name] for c in self.model.coefficients if c.name in here and c.term == term.name]
        return float(sum(own) if own else theta[place] - sum(here.values()))

    def equation_errors(self) -> dict[str, float]:
        """Standard errors by term name, of inner numbers by "term.parameter", in the equation's units."""
        errors: dict[str, float] = {}
        for c in self.model.coefficients:
            key = c.term or "mass"
            key = f"{key}.{c.name.removeprefix(f'{key}_')}" if key in errors else key
            errors[key] = abs(c.factor) * self.estimates[c.name].total_stderr
        if self.model.fixed is not None:
            for law in (law for law in registry.catalogue() if law.structural):
                held: Estimate = getattr(self.model.fixed, law.structural)
                per = law.published.per if law.published is not None else ""
                errors[law.name] = held.total_stderr * (getattr(self.model.specimen, per) if per else 1.0)
        return errors


Scattering = Literal["none", "trials", "trials and means"]
"""What of a fixed structure may vary in a fit: nothing; k, c, mu of each trial; or their means too."""


def fit_group(
    model: GroupModel, motions: Sequence[Motion], options: TrialOptions, scattering: Scattering = "none"
) -> GroupFit:
    """Output error of all trials together; each has its own x0, clock, rest and sensor offsets.

    With ``scattering`` the k, c, mu of a fixed structure vary from trial to trial within the structure's scatter
    (random effects), so that no trial counts more than its turn; with "trials and means" their means vary too, within
    their standard errors, and intervals hold both.
    """
    plain = _fit_plain(model, _problem(model, motions, options, "none"))
    if scattering == "none" or model.fixed is None:
        return _group_fit(model, plain)
    full = _problem(model, motions, options, scattering)
    known = dict(zip(plain.problem.names, plain.values.tolist(), strict=True))
    start = np.array([known.get(u.name, u.start) for u in full.unknowns])
    search = _fit_weighed if scattering == "trials and means" else _fit_scattering
    return _group_fit(model, search(full, start))


def fit_alone(together: GroupFit, motion: Motion, options: TrialOptions) -> GroupFit:
    """The same model on one of its trials, from where the fit of all ended: what this trial says by itself."""
    problem = _problem(together.model, [motion], options, "none")
    known = dict(zip(together.solution.problem.names, together.solution.values.tolist(), strict=True))
    start = np.array([known.get(u.name, u.start) for u in problem.unknowns])
    return _group_fit(together.model, output_error.fit(problem, start, growing=False))


def _fit_scattering(problem: Problem, start: Array) -> Solution:
    """The fit with random effects, from where the fit without them ended.

    Where a body sticks the misfit has kinks, and the whole record seen at once can hold a trial fast in the wrong one:
    the window grows. Where that ends badly the whole record is tried too, and the better end returned.
    """
    grown = as_recorded(output_error.fit(problem, start))
    if grown.chi2 <= WITHIN_COLOUR * grown.n_data:
        return grown
    direct = as_recorded(output_error.fit(problem, start, growing=False))
    return direct if direct.cost < grown.cost else grown


def _fit_weighed(problem: Problem, start: Array) -> Solution:
    """The fit with random effects and their means where the equation may be wrong: what it leaves is no sensor's noise,
    and counted as such it outweighs all that dry trials say (a k forty of its errors off, with a mass to match). Noise
    is as large as what was left where the motion is, and the search repeated with that.
    """
    found = _fit_scattering(problem, start)
    for _ in range(REWEIGHED):
        factors = noise_factors(found)
        if max(float(np.max(f)) for f in factors) <= WITHIN_COLOUR:
            return found
        louder = [
            replace(trial, channels=tuple(
                replace(c, sigma=c.sigma * math.sqrt(f)) for c, f in zip(trial.channels, factor, strict=True)
            )) for trial, factor in zip(problem.trials, factors, strict=True)
        ]  # fmt: skip
        found = _as_stated(_fit_scattering(Problem(problem.unknowns, tuple(louder)), start), problem, factors)
    return found


def _as_stated(found: Solution, problem: Problem, factors: Sequence[Array]) -> Solution:
    """A fit with louder noise in units of the noise as stated; its covariance stays."""
    sizes = [
        np.repeat(np.sqrt(factor), trial.t.size) for trial, factor in zip(problem.trials, factors, strict=True)
    ]
    residuals = tuple(r * size for r, size in zip(found.residuals, sizes, strict=True))
    jacobians = tuple(j * size[:, None] for j, size in zip(found.jacobians, sizes, strict=True))
    chi2 = float(sum(r @ r for r in residuals))
    cost = found.cost - found.chi2 + chi2
    return replace(found, problem=problem, residuals=residuals, jacobians=jacobians, chi2=chi2, cost=cost)


def _fit_plain(model: GroupModel, problem: Problem) -> Solution:
    """The fit from the motion's own scale; where it ends badly also from the record's period and from the linear
    equation's answer.

    An equation that is wrong can be led, by growing windows, to coefficients that a linear oscillator beats; started
    from a linear answer that is better, the search cannot end above it. The better end is returned.
    """
    direct = blind.fit(problem)
    if direct.outcome == OK and direct.chi2 <= WITHIN_NOISE * direct.n_data:
        return direct
    leading = {
        t.slots[t.coefficient.name] if t.slots else f"{t.name}.{t.coefficient.name}"
        for t in model.terms
        if not t.linear  # where a fit that went astray starts anew
    }
    unknowns = list(problem.unknowns)
    for i, c in enumerate(model.coefficients):
        if c.slot in leading:
            unknowns[i] = replace(unknowns[i], start=0.0, lower=0.0, upper=0.0)
    if unknowns == list(problem.unknowns):
        return _from_other_inner_numbers(model, direct, direct.values)
    linear = output_error.fit(Problem(tuple(unknowns), direct.problem.trials))
    if linear.cost < direct.cost:
        again = output_error.fit(direct.problem, linear.values, growing=False)
        direct = again if again.cost < direct.cost else direct
    return _from_other_inner_numbers(model, direct, linear.values)


def _from_other_inner_numbers(model: GroupModel, found: Solution, linear: Array) -> Solution:
    """The fit from the linear equation's answer with a law's inner number (a speed, a time) elsewhere, where that ends
    closer: from too far off none leads to where it is, and the law's coefficient takes it out."""
    places = {c.name: i for i, c in enumerate(model.coefficients)}
    inner = ((t, f"{t.name}_{p.name}") for t in model.terms if t.slots for p in t.parameters[1:])
    period = found.problem.trials[0].period_s
    for term, name in ((t, n) for t, n in inner if n in places):
        usual = linear[places[name]]
        starts = [0.5 * n * period for n in HALF_PERIODS] if term.kind == "delay" else [m * usual for m in INNER_STARTS]
        for value in starts:
            if found.chi2 <= WITHIN_NOISE * found.n_data:
                return found
            start = linear.copy()
            start[places[name]] = value
            for i in (i for i, c in enumerate(model.coefficients) if c.term == term.name and linear[i] == 0.0):
                start[i] = model.coefficients[i].start  # at none at all nothing leads to the inner number
            try:
                again = output_error.fit(found.problem, start, growing=False)
            except IdentificationError:
                continue
            found = again if again.cost < found.cost else found
    return found


def _problem(
    model: GroupModel, motions: Sequence[Motion], options: TrialOptions, scattering: Scattering
) -> Problem:
    builder = ProblemBuilder()
    shared = [
        builder.unknown(c.name, c.start, lower=c.lower, upper=c.upper, scale=c.scale) for c in model.coefficients
    ]
    for motion in motions:
        links = [Link(model.place(c.slot), i, c.factor) for c, i in zip(model.coefficients, shared, strict=True)]
        if scattering != "none":
            links += _random_effects(builder, model, motion.name, scattering == "trials and means")
        builder.trial(motion, model.trial_base(motion.name), tuple(links), options, model.laws)
    return builder.build()


def _random_effects(builder: ProblemBuilder, model: GroupModel, trial: str, means: bool) -> list[Link]:
    """Deviations of k, c, mu from what is fixed: of this trial, and (``means``) of the group as a whole."""
    if model.fixed is None:
        return []
    links = []
    for symbol, slot, estimate, factor in _deviations(model, model.fixed):
        std = _mean_error(model, symbol, estimate)
        if means and std > 0.0:
            links.append(Link(SLOT[slot], builder.unknown(f"{symbol}_mean", 0.0, prior_std=std, scale=std), factor))
        spread = model.fixed.scatter.get(symbol, 0.0) * abs(estimate.value)
        if spread > 0.0:
            own = builder.unknown(f"{symbol}[{trial}]", 0.0, prior_std=spread, scale=spread)
            links.append(Link(SLOT[slot], own, factor))
    return links


def _deviations(model: GroupModel, structure: Structure) -> list[tuple[str, str, Estimate, float]]:
    """What may differ from trial to trial: symbol, slot, dry mean, and the factor from the deviation to the slot."""
    normal = model.specimen.normal_force_N
    every = (
        ("k", "k1", structure.k, 1.0), ("c", "c1", structure.c, 1.0), ("mu", "fc", structure.mu, normal),
    )  # fmt: skip
    return [d for d in every if math.isfinite(d[2].value) and math.isfinite(d[3])]


def _mean_error(model: GroupModel, symbol: str, estimate: Estimate) -> float:
    """A dry mean's standard error without the widening for few trials, which the scatter's posterior brings itself.

    Friction is mu times the normal force: a volume that is not known well counts as a mu that is not.
    """
    error = estimate.total_stderr / widening(estimate.freedom)
    if symbol == "mu" and model.specimen.normal_force_error_N > 0.0:
        relative = model.specimen.normal_force_error_N / model.specimen.normal_force_N
        error = math.hypot(error, relative * estimate.value)
    return error if math.isfinite(error) else 0.0


def _group_fit(model: GroupModel, solution: Solution) -> GroupFit:
    """Estimates with errors: what the residual says, and what is not known of the structure where one is held."""
    size = len(model.coefficients)
    values = solution.values[:size].copy()
    errors = np.sqrt(np.maximum(np.diag(noise_covariance(solution))[:size], 0.0))
    share = np.zeros(size)
    if model.fixed is not None and size:
        values, halves, share = _with_structure(model, model.fixed, solution)
        errors = as_stderr(1.0) * halves
    if solution.ambiguity is not None:
        errors = np.hypot(errors, solution.ambiguity[:size])
    estimates: dict[str, Estimate] = {}
    for i, c in enumerate(model.coefficients):
        parts = float(errors[i] * math.sqrt(1.0 - share[i])), float(errors[i] * math.sqrt(share[i]))
        value, outcome = float(values[i]), OK
        if c.name == "drag_coefficient" and model.specimen.area_m2 > 0.0:
            area = model.specimen.area_error_m2 / model.specimen.area_m2
            parts = parts[0], math.hypot(parts[1], area * value)
        if not c.lower < solution.values[i] < c.upper:
            value = float(solution.values[i])
            outcome, parts = f"{c.name} on its bound {value:.4g} {c.unit}", (math.nan, 0.0)
        estimates[c.name] = Estimate(value, *parts, c.unit, "output error", outcome)
    return GroupFit(model, solution, with_scale_error(estimates, model.specimen), solution.outcome)


@np.errstate(invalid="ignore", over="ignore")
def _with_structure(model: GroupModel, structure: Structure, solution: Solution) -> tuple[Array, Array, Array]:
    """Values, half widths of intervals and the share of the dry means in them, each (coefficients,).

    Half widths are NaN or infinite where slopes by the structure overflow, as after a search that did not converge.
    """
    size = len(model.coefficients)
    if any(name.endswith("_mean") for name in solution.problem.names):
        effects = [Effect(symbol, structure.scatter_freedom) for symbol, _, _, _ in _deviations(model, structure)]
        found = group_posterior(solution, range(size), effects)
        return found.values, found.half_widths, found.share_of_means
    deviations = _deviations(model, structure)
    slopes = np.array([_led(solution, at, deviations)[:, :size] for at in range(len(solution.problem.trials))])
    held = [
        Held(slopes[:, j], structure.scatter.get(symbol, 0.0) * abs(estimate.value),
             _mean_error(model, symbol, estimate), structure.scatter_freedom)
        for j, (symbol, _, estimate, _) in enumerate(deviations)
    ]  # fmt: skip
    noise = np.maximum(np.diag(residual_covariance(solution))[:size], 0.0)
    return solution.values[:size].copy(), *held_intervals(noise, held)


def _led(solution: Solution, at: int, deviations: Sequence[tuple[str, str, Estimate, float]]) -> Array:
    """How far all unknowns are led away per unit by which one trial's k, c or mu is not what the fit holds, (m, p)."""
    trial, names = solution.problem.trials[at], solution.problem.names
    added = solution.values.size + np.arange(len(deviations))
    links = tuple(
        Link(SLOT[slot], int(new), factor) for new, (_, slot, _, factor) in zip(added, deviations, strict=True)
    )
    values = np.append(solution.values, np.zeros(added.size))
    found = output_error.residuals(replace(trial, links=trial.links + links), values)
    out = np.zeros((added.size, solution.values.size))
    for j, (symbol, _, _, _) in enumerate(deviations):
        own = f"{symbol}[{trial.name}]"
        if own in names:  # a random effect: only its prior leads the others away
            index = names.index(own)
            out[j] = solution.covariance[:, index] / solution.problem.unknowns[index].prior_std ** 2
        elif found is not None:
            column = found[1][:, found[2] == added[j]]
            out[j] = (solution.covariance[:, solution.used[at]] @ (solution.jacobians[at].T @ column))[:, 0]
    return out


def as_fit(group: GroupFit, method: str, trials: Sequence[str], anchor: str) -> Fit:
    """The group's estimates as a Fit in the contract's names, with the fixed structure's values beside them."""
    parameters = dict(group.estimates)
    specimen = group.model.specimen
    if "added_mass_kg" in parameters:
        added = parameters["added_mass_kg"]
        parameters["total_mass_kg"] = replace(added, value=added.value + specimen.mass_kg)
    elif group.model.anchored and "total_mass_kg" not in parameters and math.isfinite(specimen.mass_kg):
        error = specimen.mass_error_kg
        said = "load cells" if error > 0.0 else "config"
        parameters["total_mass_kg"] = Estimate(specimen.mass_kg, 0.0, error, specimen.unit("kg"), said)
    if group.model.fixed is not None:
        parameters |= structural_parameters(group.model.fixed, specimen)
    elif group.model.anchored and "k_N_per_m" not in parameters and math.isfinite(specimen.stiffness_N_per_m):
        error = specimen.stiffness_error_N_per_m
        said = "load cells" if error > 0.0 else "config"
        parameters["k_N_per_m"] = Estimate(specimen.stiffness_N_per_m, 0.0, error, specimen.unit("N/m"), said)
    return Fit(method, tuple(trials), {}, parameters, group.outcome, (), anchor)


__all__ = [
    "Coefficient", "GroupFit", "GroupModel", "Scattering", "as_fit", "fit_alone", "fit_group", "group_model",
    "terms_by_name",
]  # fmt: skip
