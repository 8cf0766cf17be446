"""The part of the rows' expressions that numpy evaluates: columns.py, beside the integrator's algebra.py.

A law's force per unit coefficient along a whole motion, the forces that springs hold, and the largest slopes of all
laws over a motion, from which steps are chosen. Does not belong here: what numba compiles (generate.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import sympy as sp

from undertow.equation.code_text import PLACE, SIDE, D, T, V, X, slope, symbol, text
from undertow.equation.generate import Law, read
from undertow.equation.generate_states import Lanes
from undertow.equation.term import Expression, Term, unit_force

HEAD = '''"""Generated from the laws' rows: their forces along a whole motion, and their largest slopes.

Do not edit: change a law's row (structure.py and its neighbours) and run `python -m undertow.equation.generate`.
A test compares.
"""

# ruff: noqa: E501

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Inner = Mapping[str, float]
Size = Callable[[str], float]

'''


def column_text(row: type[Term]) -> str:
    """Its text by numpy: a new array, also where the law is one of its arguments."""
    written = unit_force(row, PLACE)
    if written is None:
        return ""
    names = {symbol(p.name): f'p["{p.name}"]' for p in row.parameters[1:]}
    out = text(written, names, array=True)
    return f"1.0 * {out}" if written in (X, V, T) else out


def _columns(rows: Sequence[type[Term]]) -> str:
    out = "COLUMNS: dict[str, Callable[[Array, Array, Array, Inner], Array]] = {\n"
    out += "".join(f'    "{row.name}": lambda x, v, t, p: {body},\n' for row in rows if (body := column_text(row)))
    return out + '}\n"""Force per unit coefficient (n,) by a law\'s name, at x, v, t and its inner parameters."""\n\n'


def _springs(rows: Sequence[type[Term]]) -> str:
    """What load cells in the springs see, by slot: the law and its slope."""
    out = "SPRINGS: dict[str, tuple[Callable[[Array], Array], Callable[[Array], Array]]] = {\n"
    for row in (row for row in rows if row.sprung):
        one = unit_force(row, PLACE)
        ways = {sp.Abs(X): X * SIDE, sp.sign(X): SIDE}
        by = slope(sp.sympify(one).subs(ways), X).subs(SIDE, sp.sign(X)).subs(X * sp.sign(X), sp.Abs(X))
        steep = text(by, array=True) if by.has(X) else f"{text(by, array=True)} + 0.0 * x"
        slot = row.slots[row.parameters[0].name]
        out += f'    "{slot}": (lambda x: {column_text(row)}, lambda x: {steep}),\n'
    return out + '}\n"""Force in the springs per unit coefficient and its slope, by slot, at x (n,)."""\n\n\n'


def _largest(expression: Expression, names: Mapping[Expression, str], at_rest: bool) -> str:
    """Text of an expression's size at the ends of the motion, or of what it is at rest where that is more."""
    ends = expression.subs({D: 1, SIDE: 1}).subs({X: sp.Symbol("size"), V: sp.Symbol("speed")})
    if not at_rest or not ends.atoms(sp.Function):
        return text(ends, names)
    still = expression.subs({D: 1, SIDE: 1}).subs({X: 0, V: 0})
    return text(still, names)


def _sizes(laws: Sequence[Law], lanes: Sequence[Lanes]) -> str:
    stiff, damped = [], []
    for law in laws:
        names = {symbol(slot): f'at("{slot}")' for slot in law.slots}
        if law.smooth != 0 and not law.force.has(V) and not law.force.has(T):
            stiff.append(_largest(slope(law.force, X), names, at_rest=True))
        elif law.smooth != 0 and law.powers:
            damped.append(_largest(slope(law.force, V), names, at_rest=False))
    fading = []
    for one in lanes:
        for number in (range(1, one.most + 1) if one.most else ("",)):
            names = {symbol(slot): f'at("{slot}{number}")' for slot in one.slots}
            stiff.append(_largest(slope(one.rate, V).subs(one.state, 0), names, at_rest=False))
            fade = -slope(one.rate, one.state).subs(V, 0)
            if fade != 0:
                fading.append((names[symbol(one.present)], text(fade, names)))
    rates = ", ".join(f"({fade} if {present} > 0.0 else 0.0)" for present, fade in fading)
    return (
        "def stiffest(at: Size, size: float) -> float:\n"
        '    """Bound of the restoring laws\' slope up to the displacement ``size`` (m), N/m, from slots\' sizes."""\n'
        f"    return {_over_lines(stiff)}\n\n\n"
        "def most_damped(at: Size, size: float, speed: float) -> float:\n"
        '    """Bound of the damping laws\' slope up to the displacement ``size`` and the speed ``speed``, N s/m."""\n'
        f"    return {_over_lines(damped)}\n\n\n"
        "def fading(at: Size) -> tuple[float, ...]:\n"
        '    """Rates at which memories fade by themselves, 1/s (0: there is none)."""\n'
        f"    return ({rates},)\n"
    )


def _over_lines(parts: Sequence[str]) -> str:
    return "float(\n        " + "\n        + ".join(part for part in parts if part != "0.0") + "\n    )"


def columns_text(rows: Sequence[type[Term]]) -> str:
    """Text of columns.py for these rows."""
    laws, _, lanes = read(rows)
    return HEAD + _columns(rows) + _springs(rows) + _sizes(laws, lanes)
