"""An equation as symbols: what accelerates the body, what friction holds, how hidden states change.

    M a = -smooth(x, v, states, t) - friction(x, v, d) d

with d the direction of motion (+1, -1; 0 while the body sticks) and x the displacement from rest. Programs are printed
from this (programs.py), and `to_sympy` gives it in a reader's own form. The laws are those of `equation/`; a test holds
every printed program against the compiled integrator.

Belongs here: the laws as SymPy expressions. Does not belong here: any program's text.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from undertow.equation.equation import Equation
from undertow.equation.term import Term
from undertow.errors import UndertowError

Expression = Any
"""A SymPy expression."""


@dataclass(frozen=True)
class Place:
    """The symbols that a law may use: displacement from rest, velocity, direction, acceleration, time, v(t - tau)."""

    x: Expression
    v: Expression
    d: Expression
    a: Expression
    t: Expression
    echo: Expression


@dataclass(frozen=True)
class Share:
    """What one term adds: a smooth force, a size of friction, hidden states (name, rate of change)."""

    smooth: Expression = 0
    friction: Expression = 0
    states: tuple[tuple[str, Expression], ...] = ()


@dataclass(frozen=True)
class System:
    """A whole equation: ``values`` maps every symbol's name to its number, ``words`` to its unit and term."""

    smooth: Expression
    friction: Expression
    states: tuple[tuple[str, Expression], ...]
    values: Mapping[str, float]
    words: Mapping[str, str]
    place: Place
    delay: str = ""


Law = Callable[[Mapping[str, Expression], Place, str], Share]
"""From a term's symbols by parameter name, the place, and the number of the term, to what it adds."""


def _laws() -> dict[str, Law]:
    """The law of each term, by its name."""
    import sympy as sp

    def resonator(p: Mapping[str, Expression], q: Place, number: str) -> Share:
        s, u = sp.Symbol(f"s{number}", real=True), sp.Symbol(f"u{number}", real=True)
        w, z = p["natural_frequency_rad_per_s"], p["damping_ratio"]
        pull = 2 * z * w * u + w**2 * s
        pull += p["quadratic_damping_per_m"] * u * sp.Abs(u) + p["cubic_stiffness_per_m2_s2"] * s**3
        return Share(smooth=-p["mass_kg"] * pull, states=((s.name, u), (u.name, -q.a - pull)))

    def relaxation(p: Mapping[str, Expression], q: Place, number: str) -> Share:
        z = sp.Symbol(f"z{number}", real=True)
        return Share(smooth=z, states=((z.name, p["stiffness_N_per_m"] * q.v - z / p["time_s"]),))

    def hysteresis(p: Mapping[str, Expression], q: Place, number: str) -> Share:
        r = sp.Symbol(f"r{number}", real=True)
        k, width = p["stiffness_N_per_m"], p["yield_displacement_m"]
        return Share(smooth=r, states=((r.name, k * q.v * (1 - q.d * r / (sp.Abs(k) * width))),))

    def forcing(p: Mapping[str, Expression], q: Place, number: str) -> Share:
        return Share(smooth=p["amplitude_N"] * sp.cos(p["frequency_rad_per_s"] * q.t + p["phase_rad"]))

    def stribeck(p: Mapping[str, Expression], q: Place, number: str) -> Share:
        return Share(friction=p["static_force_N"] * sp.exp(-((q.v / p["velocity_m_per_s"]) ** 2)))

    plain: dict[str, tuple[str, Callable[[Place], Expression]]] = {
        "stiffness": ("k_N_per_m", lambda q: q.x),
        "viscous_damping": ("c_Ns_per_m", lambda q: q.v),
        "linear_damping": ("c_Ns_per_m", lambda q: q.v),
        "quadratic_drag": ("drag_Ns2_per_m2", lambda q: q.v**2 * q.d),
        "cubic_damping": ("Ns3_per_m3", lambda q: q.v**3),
        "cubic_stiffness": ("N_per_m3", lambda q: q.x**3),
        "quintic_stiffness": ("N_per_m5", lambda q: q.x**5),
        "asymmetric_stiffness": ("N_per_m2", lambda q: q.x**2),
        "quadratic_stiffness": ("N_per_m2", lambda q: q.x * sp.Abs(q.x)),
        "sine_restoring": ("N", lambda q: sp.sin(q.x)),
        "position_damping": ("Ns_per_m2", lambda q: q.x * q.v),
        "van_der_pol_damping": ("Ns_per_m3", lambda q: q.x**2 * q.v),
        "delayed_echo": ("gain", lambda q: q.echo),
    }
    rubbing: dict[str, tuple[str, Callable[[Place], Expression]]] = {
        "coulomb_friction": ("force_N", lambda q: sp.Integer(1)),
        "asymmetric_friction": ("force_N", lambda q: q.d),
        "variable_normal_force": ("N_per_m", lambda q: sp.Abs(q.x)),
    }
    laws: dict[str, Law] = {
        "hidden_resonator": resonator, "relaxation": relaxation, "hysteresis": hysteresis,
        "external_forcing": forcing, "stribeck_friction": stribeck,
        "drag_exponent": lambda p, q, _: Share(
            smooth=p["coefficient_N_sp_per_mp"] * sp.Abs(q.v) ** p["exponent"] * q.d
        ),
    }  # fmt: skip
    for name, (key, law) in plain.items():
        laws[name] = lambda p, q, _, key=key, law=law: Share(smooth=p[key] * law(q))  # type: ignore[misc]
    for name, (key, law) in rubbing.items():
        laws[name] = lambda p, q, _, key=key, law=law: Share(friction=p[key] * law(q))  # type: ignore[misc]
    return laws


def system_of(equation: Equation) -> System:
    """An equation as symbols and numbers; UndertowError where a term is a user's own law, which is code, not symbols.

    >>> from undertow.equation.equation import equation_15
    >>> sorted(system_of(equation_15(10.0, 2.0, 1.0, 400.0, 3.0, 5.0)).values)[:2]
    ['coulomb_friction_force_N', 'mass_kg']
    """
    import sympy as sp

    place = Place(*(sp.Symbol(name, real=True) for name in ("x", "v", "d", "a", "t", "echo")))
    laws = _laws()
    smooth, friction = sp.Integer(0), sp.Integer(0)
    states: list[tuple[str, Expression]] = []
    values, words, delay = {"mass_kg": equation.total_mass_kg}, {"mass_kg": "kg, all that moves"}, ""
    seen: dict[str, int] = {}
    for term, coefficient in zip(equation.terms, equation.coefficients, strict=True):
        if term.name == "added_mass":
            continue
        if term.name not in laws or not term.slots:
            raise UndertowError(
                f"{term.name} is a law of your own, written as code; it cannot be handed over as symbols: simulate it "
                "with undertow.simulate, or write it with terms that `undertow terms` lists"
            )
        seen[term.name] = seen.get(term.name, 0) + 1
        number = str(seen[term.name]) if seen[term.name] > 1 else ""
        symbols = _symbols(term, coefficient, number, values, words)
        share = laws[term.name](symbols, place, number)
        smooth, friction = smooth + share.smooth, friction + share.friction
        states += share.states
        delay = delay or (symbols["delay_s"].name if term.name == "delayed_echo" else "")
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
