"""Expressions of laws as Python text that numba compiles, and their derivatives in one direction of motion.

A law's expression may bend where the body reverses or passes its rest position, and nowhere else: |v| is v d and |x| is
x side there, with d the direction of motion and side the side of the rest position, so that a step sees a smooth law.

Belongs here: symbols, the rewriting by directions, the printer. Does not belong here: which functions the text of the
integrator has (generate.py), the laws themselves.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import sympy as sp

from undertow.equation.term import Expression, SymbolPlace
from undertow.errors import UndertowError

X, V, D, A, T, ECHO, SIDE = (sp.Symbol(name, real=True) for name in ("x", "v", "d", "a", "t", "echo", "side"))
PLACE = SymbolPlace(X, V, D, A, T, ECHO)
"""What an expression may hold of the motion: `SIDE` comes in for |x|."""

MOST_FACTORS = 6
"""Up to this power a product is written out, which is what the compiler would make of it."""

_CALLS = {
    sp.exp: "math.exp", sp.log: "math.log", sp.sin: "math.sin", sp.cos: "math.cos", sp.tan: "math.tan",
    sp.sinh: "math.sinh", sp.cosh: "math.cosh", sp.tanh: "math.tanh", sp.asin: "math.asin", sp.acos: "math.acos",
    sp.atan: "math.atan", sp.atan2: "math.atan2", sp.Abs: "abs",
}  # fmt: skip
"""Functions that a law's expression may hold, and what they are called in the text."""


class OddPower(sp.Function):  # type: ignore[misc]
    """|y|^p sign(y), with its direction as a third argument for the slope: odd beyond a reversal."""

    nargs = 3

    def fdiff(self, argindex: int = 1) -> Expression:
        """By y the slope; by p the value times log|y|."""
        y, p, way = self.args
        if argindex == 1:
            return PowerSlope(y, p, way)
        return PowerLog(y, p) if argindex == 2 else sp.Integer(0)


class PowerSlope(sp.Function):  # type: ignore[misc]
    """p |y|^(p-1); 0 where it has a pole."""

    nargs = 3


class PowerLog(sp.Function):  # type: ignore[misc]
    """|y|^p sign(y) log|y|; 0 at y = 0."""

    nargs = 2


_ARRAY_CALLS = {
    function: name.replace("math.a", "np.arc").replace("math", "np")
    for function, name in _CALLS.items()
} | {sp.Abs: "np.abs", sp.sign: "np.sign"}
"""The same by numpy, for whole motions."""

_CALLS |= {OddPower: "_power_law", PowerSlope: "_power_slope", PowerLog: "_power_log"}


def symbol(slot: str) -> Expression:
    """What stands for a slot's number in an expression."""
    return sp.Symbol(slot, real=True)


def place(slot: str) -> str:
    """Name of the constant that holds a slot's place in the parameter vector."""
    return f"_{slot.upper()}"


def directed(expression: Expression) -> Expression:
    """The expression smooth in one direction: |v| is v d and |x| is x side; d and side are the signs, their squares 1.

    Raises UndertowError where something is left that bends or jumps elsewhere.
    """
    out = sp.sympify(expression)
    for y, way in ((V, D), (X, SIDE)):
        out = out.replace(
            lambda e, y=y: e.is_Pow and e.base == sp.Abs(y) and not e.exp.is_Integer,
            lambda e, y=y, way=way: OddPower(y, e.exp, way) * way,
        )
        out = out.subs({sp.Abs(y): y * way, sp.sign(y): way}, simultaneous=True)
    out = _reduced(out)
    for bent in out.atoms(sp.Abs, sp.sign, sp.Heaviside, sp.Piecewise, sp.Max, sp.Min):
        raise UndertowError(
            f"a law's expression has {bent}, which bends where the integrator knows no event; it may bend at v = 0 and "
            "at x = 0 alone: leave its slots empty, and it takes the general path"
        )
    return out


def _reduced(expression: Expression) -> Expression:
    """Even powers of a direction are 1, odd ones the direction itself."""
    return sp.expand(expression, power_base=False, power_exp=False, log=False).replace(
        lambda e: e.is_Pow and e.base in (D, SIDE) and e.exp.is_Integer,
        lambda e: e.base if int(e.exp) % 2 else sp.Integer(1),
    )


def slope(expression: Expression, symbol: Expression) -> Expression:
    """Derivative by a symbol, of an expression in one direction."""
    return _reduced(sp.diff(expression, symbol))


def linear_in(expression: Expression, symbols: Iterable[Expression]) -> tuple[Expression, ...]:
    """Those of the symbols that the expression is linear in."""
    return tuple(s for s in symbols if expression.has(s) and not sp.diff(expression, s).has(s))


def nested(expression: Expression) -> Expression:
    """A sum of powers of the motion with common factors taken out (Horner's form); what goes with the time is left as
    it is, for a fraction of exponentials would overflow late in a record."""
    if expression.has(T):
        return expression
    gens = [s for s in (V, X) if expression.has(s)]
    others = expression.free_symbols - set(gens)
    if not gens or any(f.free_symbols & set(gens) for f in expression.atoms(sp.Function)) or not others:
        return expression
    return sp.horner(expression, *gens) if expression.is_polynomial(*gens) else expression


def text(expression: Expression, names: Mapping[Expression, str] = MappingProxyType({}), array: bool = False) -> str:
    """Python text of an expression, with other ``names`` for some of its symbols; by numpy where it is an ``array``.

    Raises UndertowError for a function that compiled code does not have.

    >>> text(2 * X**3 - V / T)
    '2.0 * x * x * x - v / t'
    >>> text(2 * X**3 + sp.sign(V), array=True)
    '2.0 * x**3 + np.sign(v)'
    """
    return _Writer(names, array).written(sp.sympify(expression))[0]


_SUM, _PRODUCT, _POWER, _ATOM = range(4)


@dataclass(frozen=True)
class _Writer:
    """Writes expressions: text, and how tightly it binds."""

    names: Mapping[Expression, str]
    array: bool

    def written(self, e: Expression) -> tuple[str, int]:
        """Any expression."""
        if e in self.names:
            return self.names[e], _ATOM
        if e.is_Symbol:
            return e.name, _ATOM
        if e.is_Number or e.is_NumberSymbol:
            number = repr(float(e))
            return number, _SUM if number.startswith("-") else _ATOM
        if e.is_Add:
            return self._sum(e), _SUM
        if e.is_Mul:
            return self._product(e)
        if e.is_Pow:
            return self._power(e)
        calls = _ARRAY_CALLS if self.array else _CALLS
        if type(e) in calls:
            given = e.args[:2] if isinstance(e, OddPower) else e.args
            return f"{calls[type(e)]}({', '.join(self.written(a)[0] for a in given)})", _ATOM
        raise UndertowError(
            f"a law's expression has {e}, which compiled code does not hold; write it with functions of `code_text`"
        )

    def _bound(self, e: Expression, tightness: int) -> str:
        written, binds = self.written(e)
        return written if binds >= tightness else f"({written})"

    def _sum(self, e: Expression) -> str:
        out = ""
        for term in e.as_ordered_terms():
            minus = term.could_extract_minus_sign()
            part = self._bound(-term if minus else term, _PRODUCT)
            if out:
                out += f" - {part}" if minus else f" + {part}"
            else:
                out = f"-{part}" if minus else part
        return out

    def _product(self, e: Expression) -> tuple[str, int]:
        if e.as_coeff_Mul()[0].is_negative:
            return f"-{self._bound(-e, _PRODUCT)}", _SUM
        above, below = [], []
        for factor in e.as_ordered_factors():
            if factor.is_Pow and factor.exp.is_number and factor.exp.is_negative:
                below.append(1 / factor)
            else:
                above.append(self._bound(factor, _PRODUCT))
        if not below:
            return " * ".join(above), _PRODUCT
        return f"{' * '.join(above) or '1.0'} / {self._bound(sp.Mul(*below), _POWER)}", _PRODUCT

    def _power(self, e: Expression) -> tuple[str, int]:
        if e.exp.is_Integer and 0 < int(e.exp) <= (0 if self.array else MOST_FACTORS):
            return " * ".join([self._bound(e.base, _POWER)] * int(e.exp)), _PRODUCT
        if e.exp.is_number and e.exp.is_negative:
            return f"1.0 / {self._bound(1 / e, _POWER)}", _PRODUCT
        if e.exp == sp.Rational(1, 2):
            return f"{'np' if self.array else 'math'}.sqrt({self.written(e.base)[0]})", _ATOM
        exponent = str(int(e.exp)) if e.exp.is_Integer else self._bound(e.exp, _ATOM)
        apart = "" if exponent.isdigit() and e.base.is_Symbol else " "
        return f"{self._bound(e.base, _ATOM)}{apart}**{apart}{exponent}", _POWER


def function(name: str, arguments: str, words: str, lines: Sequence[str], inline: bool = True) -> str:
    """Text of one compiled function."""
    options = 'inline="always", **WITHIN' if inline else "**WITHIN"
    body = "".join(f"    {line}\n" for line in lines)
    return f'@njit({options})\ndef {name}({arguments}):\n    """{words}"""\n{body}\n\n'
