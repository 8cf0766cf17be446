"""An equation of motion: terms, their coefficients, and what is at rest where.

Belongs here: the frozen `Equation`, its text, its LaTeX, and its parameter vector for the compiled integrator.
Does not belong here: integration (simulate.py) or identification.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np

from undertow.equation import registry
from undertow.equation.notation import quantity_latex, term_latex, term_text
from undertow.equation.term import Array, Term
from undertow.errors import UndertowError
from undertow.quantities import format_number, unit_in_rotation


@dataclass(frozen=True)
class Equation:
    """M x'' + sum_i coefficient_i force_i = 0.

    ``mass_kg`` is the total mass M (1 when everything is per mass), without added mass where ``added_mass`` is a term.
    ``coefficients`` (in the order of ``terms``) in each term's unit; ``rest_m`` is the position in which the springs
    are at rest. UndertowError where lengths differ, a number is not finite, or the total mass is not positive.

    >>> from undertow.equation.structure import Stiffness, ViscousDamping
    >>> eq = Equation((Stiffness(), ViscousDamping()), (100.0, 2.0), mass_kg=4.0)
    >>> print(eq)
    4 x'' + 100 x + 2 v = 0
    """

    terms: tuple[Term, ...]
    coefficients: tuple[float, ...]
    mass_kg: float = 1.0
    rest_m: float = 0.0
    constants: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "coefficients", tuple(float(c) for c in self.coefficients))
        object.__setattr__(self, "constants", MappingProxyType(dict(self.constants)))
        if len(self.terms) != len(self.coefficients):
            raise UndertowError(
                f"equation has {len(self.terms)} terms but {len(self.coefficients)} coefficients; give one each"
            )
        for term, value in zip(self.terms, self.coefficients, strict=True):
            if not np.isfinite(value):
                raise UndertowError(
                    f"coefficient of {term.name} is {value}; give a finite value in {term.coefficient.unit}"
                )
        if not self.total_mass_kg > 0.0:
            raise UndertowError(f"total mass is {self.total_mass_kg:g} kg; it must be positive: check added_mass")

    @property
    def total_mass_kg(self) -> float:
        """M plus added mass, in kg (1 when per mass)."""
        added = sum(c for t, c in zip(self.terms, self.coefficients, strict=True) if t.is_inertia)
        return self.mass_kg + added

    @property
    def compiled(self) -> bool:
        """Whether the compiled integrator knows every term (a user's own law takes the general path)."""
        names = [t.name for t in self.terms]
        return all(t.slots and names.count(t.name) <= (t.held_by_kernel or len(names)) for t in self.terms)

    def theta(self, x0: float = 0.0, v0: float = 0.0) -> Array:
        """Parameter vector of the compiled integrator (kernel.SLOTS) with the initial state x0 (m), v0 (m/s)."""
        from undertow.equation.kernel import N_SLOTS, SLOT

        theta = np.zeros(N_SLOTS)
        theta[SLOT["mass"]] = self.mass_kg
        theta[SLOT["xe"]], theta[SLOT["x0"]], theta[SLOT["v0"]] = self.rest_m, x0, v0
        seen: dict[str, int] = {}
        for term, value in zip(self.terms, self.coefficients, strict=True):
            seen[term.name] = seen.get(term.name, 0) + 1
            suffix = str(seen[term.name]) if term.held_by_kernel else ""
            for slot, number in term.slot_values(value).items():
                theta[SLOT[slot + suffix]] += number
        return theta

    def __str__(self) -> str:
        return self.text()

    def text(self, errors: Mapping[str, float] | None = None) -> str:
        """The equation in one line, each number with the digits its error (by term name, "mass") allows.

        The equations of hidden states follow after a semicolon each.
        """
        errors = errors or {}
        written = [
            term_text(term, value, errors.get(term.name, math.nan), number, _inner_errors(errors, term, number))
            for term, value, number in self._numbered_terms()
        ]
        inertia = f"{format_number(self.mass_kg, errors.get('mass', math.nan))} x''"
        motion = " ".join([inertia, *(w[0] for w in written)])
        return "; ".join([f"{motion} = 0", *(w[1] for w in written if w[1])])

    def to_latex(
        self, numbers: bool = False, errors: Mapping[str, float] | None = None, rotation: bool = False
    ) -> str:
        r"""The equation in LaTeX: with symbols, or with numbers, units and standard errors (by term name, "mass").

        Units of a ``rotation`` are those of moments, inertias and radians.

        >>> from undertow.equation.structure import Stiffness
        >>> print(Equation((Stiffness(),), (100.0,), mass_kg=4.0).to_latex(numbers=True))
        4\,\mathrm{kg}\,\ddot{x} + 100\,\mathrm{N/m}\,x = 0
        """
        errors = errors or {}
        inertia = r"m\ddot{x}" if any(t.is_inertia for t in self.terms) else r"M\ddot{x}"
        if numbers:
            unit = unit_in_rotation("kg") if rotation else "kg"
            inertia = quantity_latex(self.mass_kg, unit, errors.get("mass", math.nan)) + r"\,\ddot{x}"
        written = [
            term_latex(
                term, value if numbers else None, errors.get(term.name, math.nan), number and f"_{number}",
                _inner_errors(errors, term, number), rotation,
            )
            for term, value, number in self._numbered_terms()
        ]
        motion = " ".join([inertia, *(w[0] for w in written)])
        return r",\quad ".join([f"{motion} = 0", *(w[1] for w in written if w[1])])

    def _numbered_terms(self) -> list[tuple[Term, float, str]]:
        """Terms, coefficients, and a number where a term occurs more than once."""
        names = [t.name for t in self.terms]
        return [
            (term, value, str(names[: i + 1].count(term.name)) if names.count(term.name) > 1 else "")
            for i, (term, value) in enumerate(zip(self.terms, self.coefficients, strict=True))
        ]


def _inner_errors(errors: Mapping[str, float], term: Term, number: str) -> dict[str, float]:
    """Errors of a term's inner parameters, given as "name.parameter", of a second term as "name#2.parameter"."""
    prefix = f"{term.name}#{number}." if number not in ("", "1") else f"{term.name}."
    return {key.removeprefix(prefix): error for key, error in errors.items() if key.startswith(prefix)}


def equation_15(
    mass_kg: float, added_mass_kg: float, c: float, k: float, friction_N: float, drag_Ns2_per_m2: float
) -> Equation:
    """The report's Eq. 15: (m + m_a) x'' + c x' + k x + F_c sign(x') + q x'|x'| = 0, all SI.

    >>> equation_15(2637.4, 1271.0, 590.0, 109600.0, 170.0, 3924.0).total_mass_kg
    3908.4
    """
    terms = tuple(registry.find(name) for name in registry.EQUATION_15)
    return Equation(terms, (k, c, friction_N, added_mass_kg, drag_Ns2_per_m2), mass_kg=mass_kg)
