"""A method's equation with its numbers, as LaTeX broken into lines.

Belongs here: putting found numbers into the group's equation, and breaking it. Does not belong here: how a law is
written (equation/notation.py), drawing it (html.py).
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

from undertow.discrepancy.findings import GroupFindings
from undertow.equation import registry
from undertow.equation.equation import Equation
from undertow.equation.term import Term
from undertow.errors import UndertowError
from undertow.likelihood.fit import Fit, Specimen
from undertow.quantities import Estimate

Errors = dict[str, float]
LATEX_LINE = 4
"""Terms a line of a long equation, so that it fits a column of text."""

_UNIT = re.compile(r"\\,\\mathrm\{(?!sgn)(?:[^{}]|\{[^{}]*\})*\}")
"""A unit behind a number, as the equation's LaTeX writes it."""


_TO_THE_ZERO = re.compile(r"\(\|z\|/[^()]*\)\^\{1-1\}")
"""What a hysteresis does not have whose exponent is held at 1."""


def force_factors(specimen: Specimen) -> Mapping[str, tuple[str, float]]:
    """Parameter of the contract -> the term it belongs to, and coefficient per parameter.

    Friction is mu times the normal force, drag C_d times rho A / 2; both nan where the laboratory did not say.
    """
    factors: dict[str, tuple[str, float]] = {}
    for law in registry.catalogue():
        said = law.published
        if said is None:
            continue
        factors[said.column] = (law.name, 1.0)
        if said.ratio:
            factors[said.ratio] = (law.name, getattr(specimen, said.per))
            factors[law.parameters[0].name] = (law.name, 1.0)
    return factors


def method_equation(group: GroupFindings, method: str) -> tuple[Equation, Errors]:
    """The equation with one method's numbers, and standard errors by term name ("mass" for the total mass).

    Where the method chose its own terms (``per_mass``) those are written, per unit mass unless it found a total mass;
    otherwise its numbers replace the group's. "baseline" is the group's equation itself.
    """
    if method == "baseline" or method not in group.fits:
        return group.equation, dict(group.equation_errors)
    fit = group.fits[method]
    if fit.per_mass:
        try:
            return _from_per_mass(fit)
        except UndertowError:
            return _from_parameters(group, fit)
    return _from_parameters(group, fit)


def _from_per_mass(fit: Fit) -> tuple[Equation, Errors]:
    mass = fit.parameters.get("total_mass_kg", Estimate(1.0, 0.0))
    inner: dict[str, dict[str, float]] = {}
    for name, estimate in fit.per_mass.items():
        term, dot, parameter = name.partition(".")
        if dot:
            inner.setdefault(term, {})[parameter] = estimate.value
    terms: list[Term] = []
    coefficients: list[float] = []
    errors: Errors = {"mass": mass.total_stderr}
    for name, estimate in fit.per_mass.items():
        law = registry.row(name)
        if "." in name or law is None or law.is_inertia:
            continue
        terms.append(registry.find(name, **inner.get(name, {})))
        coefficients.append(estimate.value * mass.value)
        errors[name] = math.hypot(estimate.total_stderr * mass.value, estimate.value * mass.total_stderr)
    return Equation(tuple(terms), tuple(coefficients), mass.value), errors


def _from_parameters(group: GroupFindings, fit: Fit) -> tuple[Equation, Errors]:
    values = {term.name: c for term, c in zip(group.equation.terms, group.equation.coefficients, strict=True)}
    errors = dict(group.equation_errors)
    factors = force_factors(group.specimen)
    for parameter, estimate in fit.parameters.items():
        term, factor = factors.get(parameter, ("", math.nan))
        if term in values and math.isfinite(factor * estimate.value):
            values[term] = factor * estimate.value
            errors[term] = abs(factor) * estimate.total_stderr
    numbers = tuple(values[term.name] for term in group.equation.terms)
    mass = group.equation.mass_kg
    if not mass + sum(values[term.name] for term in group.equation.terms if term.is_inertia) > 0.0:
        return group.equation, dict(group.equation_errors)
    return Equation(group.equation.terms, numbers, mass, group.equation.rest_m), errors


def numeric_latex(equation: Equation, errors: Mapping[str, float], drive: str = "0", rotation: bool = False) -> str:
    """The equation in one line of LaTeX with numbers, errors and units (of a ``rotation`` those of moments and
    inertias); on its right what drives the body.

    Per unit mass (a mass of 1 without an error) it starts with the acceleration alone and bears no units: they would be
    those of forces.

    >>> numeric_latex(Equation((registry.find("stiffness"),), (41.6,)), {"stiffness": 0.2})
    '\\\\ddot{x} + (41.60 \\\\pm 0.20)\\\\,x = 0'
    """
    written = equation.to_latex(numbers=True, errors=errors, rotation=rotation).replace(" = 0", f" = {drive}", 1)
    written = _TO_THE_ZERO.sub("", written).replace("+ -", "- ").replace("^{0+", "^{")
    return _UNIT.sub("", written).removeprefix(r"1\,") if is_per_mass(equation, errors) else written


def is_per_mass(equation: Equation, errors: Mapping[str, float]) -> bool:
    """Whether an equation's numbers are per unit mass: its mass is exactly 1 and has no error."""
    return equation.mass_kg == 1.0 and not errors.get("mass", 0.0) > 0.0


def numeric_lines(
    equation: Equation, errors: Mapping[str, float], terms: int = LATEX_LINE, drive: str = "0",
    rotation: bool = False,
) -> list[str]:
    """The same broken into lines of at most so many terms, every equation of a hidden state on lines of its own."""
    motion, *memory = numeric_latex(equation, errors, drive, rotation).split(r",\quad ")
    parts = re.split(r" (?=[+-] )", motion)
    lines = [" ".join(parts[i : i + terms]) for i in range(0, len(parts), terms)]
    for state in (law for written in memory for law in written.split(r",\ ")):
        pieces = re.split(r"(?=\+)(?![^()]*\))(?![^{}]*\})", state)
        lines += ["".join(pieces[i : i + terms]) for i in range(0, len(pieces), terms)]
    return lines
