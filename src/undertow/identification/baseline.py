"""The config's equation fitted to a group's trials by output error, and scored by free run.

Belongs here: which unknowns an equation has in a group, their names and starts; the structure from dry trials; the
free run with its floors. Does not belong here: what the equation leaves out.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from undertow.conditioning.motion import Motion
from undertow.equation import shelf
from undertow.equation.equation import Equation, slot_values
from undertow.equation.kernel import N_SLOTS, SLOT
from undertow.equation.term import Term
from undertow.errors import IdentificationError
from undertow.identification import output_error
from undertow.identification.fit import Fit, Specimen, Structure
from undertow.identification.intervals import noise_covariance
from undertow.identification.output_error import Solution
from undertow.identification.problem import Link, Problem, ProblemBuilder, TrialOptions, dominant_period
from undertow.identification.scale import contract_name
from undertow.quantities import OK, Estimate
from undertow.recording.recording import Array

STRUCTURAL = ("stiffness", "viscous_damping", "coulomb_friction")
"""Terms whose parameters the dry trials give: k, c, mu."""

WATER = ("added_mass", "quadratic_drag", "linear_damping", "cubic_damping", "drag_exponent")
"""Terms that a dry trial does not have."""

LINEAR = ("stiffness", "sine_restoring", "viscous_damping", "added_mass")
"""Terms of a linear oscillator (sine restoring is one at small angles): where a fit that went astray starts anew."""

WITHIN_NOISE = 2.0
"""Mean squared residual in units of noise up to which a fit needs no second start: what is left is noise."""


@dataclass(frozen=True)
class Coefficient:
    """One unknown of an equation: its contract name, unit, slot, and the factor from the unknown to the slot."""

    name: str
    unit: str
    slot: str
    factor: float
    start: float
    lower: float = -math.inf
    upper: float = math.inf
    scale: float = 1.0
    term: str = ""
    per_mass: bool = False


@dataclass(frozen=True)
class GroupModel:
    """An equation as it is fitted in one group.

    ``base`` is the parameter vector of what is fixed (the same in all trials but for k), ``coefficients`` what is
    found; ``fixed`` the structure held, None where everything is free.
    """

    terms: tuple[Term, ...]
    specimen: Specimen
    base: Array
    coefficients: tuple[Coefficient, ...]
    fixed: Structure | None = None
    stiffness: Mapping[str, float] = field(default_factory=dict)
    anchored: bool = True

    def trial_base(self, trial: str) -> Array:
        """Parameter vector of what is fixed in one trial: the group's, with the trial's own k where it has one."""
        base = self.base.copy()
        if trial in self.stiffness:
            base[SLOT["k1"]] = self.stiffness[trial]
        return base

    def theta(self, values: Mapping[str, float], trial: str = "") -> Array:
        """Parameter vector at values of the coefficients by name."""
        theta = self.trial_base(trial)
        for c in self.coefficients:
            theta[SLOT[c.slot]] += c.factor * values[c.name]
        return theta


def group_model(
    terms: Sequence[Term],
    motions: Sequence[Motion],
    specimen: Specimen,
    structure: Structure | None,
    *,
    dry: bool,
    anchored: bool,
    stiffness: Mapping[str, float] | None = None,
) -> GroupModel:
    """The unknowns of ``terms`` in one group.

    With a ``structure`` its k, c, mu are fixed and the water's terms are unknown; without, all are. ``anchored`` says
    that k (or the mass, when dry) gives kilograms; else the total mass is 1 and every unknown is per mass.
    """
    period = float(np.median([dominant_period(m) for m in motions]))
    rate = 2.0 * math.pi / period
    known_mass = math.isfinite(specimen.mass_kg)
    kept = tuple(t for t in terms if not (dry and t.name in WATER) and (anchored or t.name != "added_mass"))
    base = np.zeros(N_SLOTS)
    mass = specimen.mass_kg if known_mass and anchored else 1.0
    coefficients: list[Coefficient] = []
    fixes_k = anchored and not dry and (structure is not None or math.isfinite(specimen.stiffness_N_per_m))
    names = {t.name for t in kept}
    if anchored and (not known_mass or (fixes_k and structure is None and "added_mass" not in names)):
        k = structure.k.value if structure else specimen.stiffness_N_per_m
        mass = k / rate**2
        kept = tuple(t for t in kept if t.name != "added_mass")
        coefficients.append(Coefficient("total_mass_kg", "kg", "mass", 1.0, mass, 1e-9 * mass, scale=mass))
    else:
        base[SLOT["mass"]] = mass
    speed = max(float(np.max(np.abs(m.v))) for m in motions)
    size = max(m.amplitude for m in motions)
    for term in kept:
        if structure is not None and term.name in STRUCTURAL:
            _fix(base, term.name, structure, specimen)
        elif term.name == "stiffness" and fixes_k:
            base[SLOT["k1"]] = specimen.stiffness_N_per_m
        else:
            coefficients += _unknowns(term, specimen, mass, rate, speed, size, anchored)
    own = dict(stiffness or {}) if structure is not None else {}
    return GroupModel(kept, specimen, base, tuple(coefficients), structure, own, anchored)


def _fix(base: Array, term: str, structure: Structure, specimen: Specimen) -> None:
    if term == "stiffness":
        base[SLOT["k1"]] = structure.k.value
    elif term == "viscous_damping":
        base[SLOT["c1"]] = structure.c.value
    else:
        base[SLOT["fc"]] = structure.mu.value * specimen.normal_force_N


def _unknowns(
    term: Term, specimen: Specimen, mass: float, rate: float, speed: float, size: float, anchored: bool
) -> list[Coefficient]:
    """Unknowns of one term: contract name, start from the motion's own scale (5 % of critical in total), bounds."""
    force = mass * rate * speed
    suffix = "" if anchored else "_per_mass"
    label, unit, per_force = contract_name(term.name, specimen if anchored else Specimen())
    if term.name == "added_mass":
        return [_one("added_mass_kg", "kg", "mass", 0.1 * mass, 0.1 * mass, term, "", lower=-0.9 * mass)]
    starts = {
        "stiffness": mass * rate**2,
        "sine_restoring": mass * rate**2,
        "viscous_damping": 0.02 * mass * rate,
        "coulomb_friction": 2e-3 * force,
        "quadratic_drag": 0.02 * mass * rate / speed,
    }
    if term.name in starts:
        start = starts[term.name] * per_force
        lower = 0.0 if term.name == "stiffness" else -math.inf
        slot = term.slots[term.coefficient.name]
        return [_one(label, unit, slot, start, start, term, suffix, factor=1.0 / per_force, lower=lower)]
    return _general(term, force / _typical(term, size, speed), suffix)


def _one(
    name: str, unit: str, slot: str, start: float, scale: float, term: Term, suffix: str,
    factor: float = 1.0, lower: float = -math.inf,
) -> Coefficient:  # fmt: skip
    return Coefficient(
        name + suffix, unit + (" per kg" if suffix else ""), slot, factor, start, lower, math.inf, scale, term.name,
        bool(suffix),
    )  # fmt: skip


def _typical(term: Term, size: float, speed: float) -> float:
    """Force per unit coefficient at the motion's largest displacement and speed."""
    one = np.ones(1)
    return max(abs(float(term.force(size * one, speed * one, one, one)[0])), 1e-12)


def _general(term: Term, scale: float, suffix: str) -> list[Coefficient]:
    """Unknowns of any other compiled term, its inner parameters included, named term.parameter."""
    if not term.slots:
        raise IdentificationError(
            f"term {term.name} has no place in the compiled integrator; output error cannot fit it: give it slots"
        )
    out = []
    for slot, number in slot_values(term, 1e-3 * scale).items():
        parameter = next((p for p in term.parameters if term.slots[p.name] == slot), term.coefficient)
        label = f"{term.name}_{parameter.name}"
        size = abs(number) if number else scale
        numbered = slot + "1" if slot in {"hm", "hw", "hz", "hb", "hg", "rk", "rt"} else slot
        out.append(
            Coefficient(
                label + (suffix if parameter is term.coefficient else ""), parameter.unit, numbered, 1.0, number,
                parameter.lower, parameter.upper, size, term.name, bool(suffix),
            )
        )  # fmt: skip
    return out


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
            if term.name == "added_mass":
                terms.append(term)
                numbers.append(float(theta[SLOT["mass"]]) - self.model.specimen.mass_kg)
                continue
            inner = {
                p.name: float(theta[SLOT[term.slots[p.name] + ("1" if term.slots[p.name] + "1" in SLOT else "")]])
                for p in term.parameters[1:]
            }
            slot = term.slots[term.coefficient.name]
            slot = slot + "1" if slot + "1" in SLOT and slot not in SLOT else slot
            terms.append(replace(term, **inner) if inner else term)
            numbers.append(float(theta[SLOT[slot]]))
        added = "added_mass" in {t.name for t in terms}
        mass = self.model.specimen.mass_kg if added else float(theta[SLOT["mass"]])
        return Equation(tuple(terms), tuple(numbers), mass_kg=mass)

    def equation_errors(self) -> dict[str, float]:
        """Standard errors by term name, in the equation's units."""
        errors: dict[str, float] = {}
        for c in self.model.coefficients:
            estimate = self.estimates[c.name]
            key = c.term or "mass"
            if key not in errors:
                errors[key] = abs(c.factor) * estimate.total_stderr
        if self.model.fixed is not None:
            normal = self.model.specimen.normal_force_N
            errors |= {
                "stiffness": self.model.fixed.k.total_stderr,
                "viscous_damping": self.model.fixed.c.total_stderr,
                "coulomb_friction": self.model.fixed.mu.total_stderr * normal,
            }
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
    return _group_fit(model, output_error.fit(full, start, growing=False))


def _fit_plain(model: GroupModel, problem: Problem) -> Solution:
    """The fit from the motion's own scale; where it ends badly also from the linear equation's answer.

    An equation that is wrong can be led, by growing windows, to coefficients that a linear oscillator beats; started
    from a linear answer that is better, the search cannot end above it. The better end is returned.
    """
    direct = output_error.fit(problem)
    if direct.outcome == OK and direct.chi2 <= WITHIN_NOISE * direct.n_data:
        return direct
    leading = {t.slots[t.coefficient.name] for t in model.terms if t.slots and t.name not in LINEAR}
    unknowns = list(problem.unknowns)
    for i, c in enumerate(model.coefficients):
        if c.slot in leading:
            unknowns[i] = replace(unknowns[i], start=0.0, lower=0.0, upper=0.0)
    if unknowns == list(problem.unknowns):
        return direct
    linear = output_error.fit(Problem(tuple(unknowns), problem.trials))
    if linear.cost >= direct.cost:
        return direct
    again = output_error.fit(problem, linear.values, growing=False)
    return again if again.cost < direct.cost else direct


def _problem(
    model: GroupModel, motions: Sequence[Motion], options: TrialOptions, scattering: Scattering
) -> Problem:
    builder = ProblemBuilder()
    shared = [
        builder.unknown(c.name, c.start, lower=c.lower, upper=c.upper, scale=c.scale) for c in model.coefficients
    ]
    for motion in motions:
        links = [Link(SLOT[c.slot], i, c.factor) for c, i in zip(model.coefficients, shared, strict=True)]
        if scattering != "none":
            links += _random_effects(builder, model, motion.name, scattering == "trials and means")
        builder.trial(motion, model.trial_base(motion.name), tuple(links), options)
    return builder.build()


def _random_effects(builder: ProblemBuilder, model: GroupModel, trial: str, means: bool) -> list[Link]:
    """Deviations of k, c, mu from what is fixed: of this trial, and (``means``) of the group as a whole."""
    structure = model.fixed
    if structure is None:
        return []
    normal = model.specimen.normal_force_N
    links = []
    for symbol, slot, estimate, factor in (
        ("k", "k1", structure.k, 1.0), ("c", "c1", structure.c, 1.0), ("mu", "fc", structure.mu, normal),
    ):  # fmt: skip
        if not math.isfinite(estimate.value) or not math.isfinite(factor):
            continue
        if means and estimate.total_stderr > 0.0 and math.isfinite(estimate.total_stderr):
            std = estimate.total_stderr
            links.append(Link(SLOT[slot], builder.unknown(f"{symbol}_mean", 0.0, prior_std=std, scale=std), factor))
        spread = structure.scatter.get(symbol, 0.0) * estimate.value
        if spread > 0.0:
            own = builder.unknown(f"{symbol}[{trial}]", 0.0, prior_std=spread, scale=spread)
            links.append(Link(SLOT[slot], own, factor))
    return links


def _group_fit(model: GroupModel, solution: Solution) -> GroupFit:
    covariance = noise_covariance(solution)
    means = [i for i, n in enumerate(solution.problem.names) if n.endswith("_mean")]
    estimates: dict[str, Estimate] = {}
    for i, c in enumerate(model.coefficients):
        total = float(covariance[i, i])
        part = 0.0
        for j in means:  # what the uncertain mean of k, c or mu contributes
            part += float(solution.covariance[i, j]) ** 2 / max(float(solution.covariance[j, j]), 1e-300)
        part = min(part, total)
        outcome = OK
        value = float(solution.values[i])
        stderr = math.sqrt(max(total - part, 0.0))
        if value <= c.lower or value >= c.upper:
            outcome, stderr = f"{c.name} on its bound {value:.4g} {c.unit}", math.nan
        estimates[c.name] = Estimate(value, stderr, math.sqrt(part), c.unit, "output error", outcome)
    return GroupFit(model, solution, estimates, solution.outcome)


def as_fit(group: GroupFit, method: str, trials: Sequence[str], anchor: str) -> Fit:
    """The group's estimates as a Fit in the contract's names, with the fixed structure's values beside them."""
    parameters = dict(group.estimates)
    specimen = group.model.specimen
    if "added_mass_kg" in parameters:
        added = parameters["added_mass_kg"]
        parameters["total_mass_kg"] = replace(added, value=added.value + specimen.mass_kg)
    elif group.model.anchored and "total_mass_kg" not in parameters and math.isfinite(specimen.mass_kg):
        parameters["total_mass_kg"] = Estimate(specimen.mass_kg, 0.0, unit="kg", source="config")
    if group.model.fixed is not None:
        held = group.model.fixed
        parameters |= {"k_N_per_m": held.k, "c_Ns_per_m": held.c, "mu": held.mu}
    return Fit(method, tuple(trials), {}, parameters, group.outcome, (), anchor)


def terms_by_name(names: Sequence[str]) -> tuple[Term, ...]:
    """Terms of the shelf by their names, in order."""
    return tuple(shelf.find(name) for name in names)
