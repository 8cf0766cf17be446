"""An equation as symbols: what accelerates the body, what friction holds, how hidden states change.

    M a = -smooth(x, v, states, t) - friction(x, v, d) d

with d the direction of motion (+1, -1; 0 while the body sticks) and x the displacement from rest. Programs are printed
from this (programs.py), and `to_sympy` gives it in a reader's own form. Each law of `equation/` gives its own share; a
test holds every printed program against the compiled integrator.

Belongs here: the sum of the laws' shares as SymPy expressions. Does not belong here: the shares themselves (each law's
class), any program's text.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from undertow.equation.equation import Equation
from undertow.equation.term import Expression, SymbolPlace, Term
from undertow.errors import UndertowError


@dataclass(frozen=True)
class System:
    """A whole equation: ``values`` maps every symbol's name to its number, ``words`` to its unit and term."""

    smooth: Expression
    friction: Expression
    states: tuple[tuple[str, Expression], ...]
    values: Mapping[str, float]
    words: Mapping[str, str]
    place: SymbolPlace
    delay: str = ""


def system_of(equation: Equation) -> System:
    """An equation as symbols and numbers; UndertowError where a term is a user's own law, which is code, not symbols.

    >>> from undertow.equation.equation import equation_15
    >>> sorted(system_of(equation_15(10.0, 2.0, 1.0, 400.0, 3.0, 5.0)).values)[:2]
    ['coulomb_friction_force_N', 'mass_kg']
    """
    import sympy as sp

    place = SymbolPlace(*(sp.Symbol(name, real=True) for name in ("x", "v", "d", "a", "t", "echo")))
    smooth, friction = sp.Integer(0), sp.Integer(0)
    states: list[tuple[str, Expression]] = []
    values, words, delay = {"mass_kg": equation.total_mass_kg}, {"mass_kg": "kg, all that moves"}, ""
    seen: dict[str, int] = {}
    for term, coefficient in zip(equation.terms, equation.coefficients, strict=True):
        if term.is_inertia:
            continue
        seen[term.name] = seen.get(term.name, 0) + 1
        number = str(seen[term.name]) if seen[term.name] > 1 else ""
        share = term.share(_symbols(term, coefficient, number, values, words), place, number) if term.slots else None
        if share is None:
            raise UndertowError(
                f"{term.name} is a law of your own, written as code; it cannot be handed over as symbols: simulate it "
                "with undertow.simulate, or write it with terms that `undertow terms` lists"
            )
        smooth, friction = smooth + share.smooth, friction + share.friction
        states += share.states
        delay = delay or share.delay
    return System(smooth, friction, tuple(states), values, words, place, delay)


def _symbols(
    term: Term, coefficient: float, number: str, values: dict[str, float], words: dict[str, str]
) -> dict[str, Expression]:
    """A symbol for each parameter of a term; adds their numbers and units."""
    import sympy as sp

    out = {}
    numbers = {term.coefficient.name: coefficient, **term.inner}
    for parameter in term.parameters:
        name = f"{term.name}{number}_{parameter.name}"
        values[name] = float(numbers[parameter.name])
        unit = "" if parameter.unit == "1" else f"{parameter.unit}, "
        words[name] = f"{unit}{term.name.replace('_', ' ')}: {parameter.name}"
        out[parameter.name] = sp.Symbol(name, real=True)
    return out


@dataclass(frozen=True)
class SymbolicEquation:
    """An equation in SymPy: ``equations`` of x(t) and the hidden states, each an Eq, and ``values`` of the symbols.

    ``symbols`` maps names to symbols; ``with_numbers()`` has the numbers in.
    """

    equations: tuple[Expression, ...]
    values: Mapping[Expression, float]

    @property
    def symbols(self) -> dict[str, Expression]:
        """Name -> symbol of every parameter."""
        return {symbol.name: symbol for symbol in self.values}

    def with_numbers(self) -> tuple[Expression, ...]:
        """The equations with numbers in place of the parameters' symbols."""
        return tuple(one.subs(self.values) for one in self.equations)


def symbolic(equation: Equation) -> SymbolicEquation:
    """An equation of x(t) and its hidden states in SymPy.

    >>> from undertow.front.simulation import equation_of
    >>> print(symbolic(equation_of({"stiffness": 400.0}, 4.0)).with_numbers()[0])
    Eq(400.0*x(t) + 4.0*Derivative(x(t), (t, 2)), 0)
    """
    import sympy as sp

    system = system_of(equation)
    t = system.place.t
    x = sp.Function("x", real=True)(t)
    v, rest = x.diff(t), x - sp.Float(equation.rest_m) if equation.rest_m else x
    values = {sp.Symbol(name, real=True): number for name, number in system.values.items()}
    hidden = {sp.Symbol(name, real=True): sp.Function(name, real=True)(t) for name, _ in system.states}
    delayed = v.subs(t, t - sp.Symbol(system.delay, real=True)) if system.delay else sp.Integer(0)
    swap = {
        system.place.x: rest, system.place.v: v, system.place.d: sp.sign(v), system.place.a: x.diff(t, 2),
        system.place.echo: delayed, **hidden,
    }  # fmt: skip
    mass = sp.Symbol("mass_kg", real=True)
    left = mass * x.diff(t, 2) + (system.smooth + system.friction * system.place.d).subs(swap, simultaneous=True)
    equations = [sp.Eq(left, 0)]
    for name, rate in system.states:
        state = sp.Function(name, real=True)(t)
        equations.append(sp.Eq(state.diff(t), rate.subs(swap, simultaneous=True)))
    return SymbolicEquation(tuple(equations), values)
