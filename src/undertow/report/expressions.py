"""A method's equation as text and as LaTeX with numbers and units.

Belongs here: putting found numbers into the group's equation, and writing it. Does not belong here: rendering
(typeset.py).
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

from undertow.discrepancy.findings import GroupFindings
from undertow.equation import shelf
from undertow.equation.equation import Equation
from undertow.equation.term import Term
from undertow.errors import UndertowError
from undertow.identification.fit import Fit, Specimen
from undertow.quantities import Estimate, format_number

Errors = dict[str, float]
LATEX_LINE = 4
"""Terms a line of a long equation, so that it fits a column of text."""


def force_factors(specimen: Specimen) -> Mapping[str, tuple[str, float]]:
    """Parameter of the contract -> the term it belongs to, and coefficient per parameter.

    Friction is mu times the normal force, drag C_d times rho A / 2; both nan where the laboratory did not say.
    """
    return {
        "k_N_per_m": ("stiffness", 1.0),
        "c_Ns_per_m": ("viscous_damping", 1.0),
        "mu": ("coulomb_friction", specimen.normal_force_N),
        "friction_N": ("coulomb_friction", 1.0),
        "force_N": ("coulomb_friction", 1.0),
        "added_mass_kg": ("added_mass", 1.0),
        "drag_coefficient": ("quadratic_drag", specimen.drag_N_per_unit_coefficient),
        "drag_Ns2_per_m2": ("quadratic_drag", 1.0),
    }


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
        if "." in name or name == "added_mass" or name not in shelf.names():
            continue
        terms.append(shelf.find(name, **inner.get(name, {})))
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
    if not mass + values.get("added_mass", 0.0) > 0.0:
        return group.equation, dict(group.equation_errors)
    return Equation(group.equation.terms, numbers, mass, group.equation.rest_m), errors


def unit_latex(unit: str) -> str:
    """A unit in upright LaTeX, empty for a pure number.

    >>> unit_latex("N s^2/m^2")
    '\\\\mathrm{N\\\\,s^{2}/m^{2}}'
    """
    if unit in ("", "1"):
        return ""
    body = re.sub(r"\^(\w+|\(.*?\))", r"^{\1}", unit).replace(" ", r"\,")
    return rf"\mathrm{{{body}}}"


def number_latex(value: float, error: float) -> str:
    """A number with its error in LaTeX; the number alone where there is no error.

    >>> number_latex(1271.4, 12.0), number_latex(8.1, math.nan)
    ('(1271 \\\\pm 12)', '8.1')
    """
    if not (math.isfinite(error) and error > 0.0):
        return _power_of_ten(f"{value:.5g}")
    small = format_number(error, error)
    return rf"({format_number(value, error)} \pm {small})"


def _power_of_ten(text: str) -> str:
    mantissa, e, exponent = text.partition("e")
    return rf"{mantissa}\cdot 10^{{{int(exponent)}}}" if e else text


def numeric_terms(equation: Equation, errors: Mapping[str, float]) -> list[str]:
    """Each term of the equation in LaTeX with number, error and unit, the inertia first; signs included."""
    per_mass = equation.mass_kg == 1.0
    mass = number_latex(equation.mass_kg, errors.get("mass", math.nan))
    parts = [r"\ddot{x}" if per_mass else rf"{mass}\,\mathrm{{kg}}\;\ddot{{x}}"]
    for term, value in zip(equation.terms, equation.coefficients, strict=True):
        number = number_latex(abs(value), errors.get(term.name, math.nan))
        sign = "-" if value < 0.0 else "+"
        unit = "" if per_mass else unit_latex(term.coefficient.unit)
        space = r"\," if unit else ""
        parts.append(rf"{sign} {number}{space}{unit}\;{_law_without_symbol(term)}")
    return parts


def _law_without_symbol(term: Term) -> str:
    """The law's LaTeX after its coefficient: ``q\\,v|v|`` -> ``v|v|``; the whole where it does not start with it."""
    law = term.latex.split(r",\ ")[0]
    symbol = re.match(r"[A-Za-z]+(_\{\w+\}|_\w)?", law)
    rest = law[symbol.end() :].lstrip() if symbol else law
    return re.sub(r"^\\,", "", rest).strip() or law


def numeric_latex(equation: Equation, errors: Mapping[str, float]) -> str:
    """The equation in one line of LaTeX with numbers, errors and units."""
    return " ".join(numeric_terms(equation, errors)) + " = 0"


def numeric_lines(equation: Equation, errors: Mapping[str, float]) -> list[str]:
    """The same broken into lines of at most LATEX_LINE terms."""
    parts = numeric_terms(equation, errors)
    parts[-1] += " = 0"
    return [" ".join(parts[i : i + LATEX_LINE]) for i in range(0, len(parts), LATEX_LINE)]
