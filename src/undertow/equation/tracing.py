"""A user's own law as a list of operations: read from its own code once, so that compiled code can evaluate it.

`Term.force` is called with symbols in place of arrays. Every operation on a symbol is written down; what is not in
`OPERATIONS` (a look-up, a loop over samples, a branch on a value) makes the law unreadable, and the general path in
Python is taken. Nothing is generated and nothing is evaluated as text: the list is data for one compiled function.

Belongs here: the operations' names, symbols, the list, the check of the list against the law. Does not belong here: its
evaluation (tape.py), integration (tape_march.py), which path is taken (general.py).
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from undertow.equation.term import Array, PlacedTerm, Term
from undertow.errors import UndertowError

NAMES = (
    "constant", "number", "x", "v", "t", "where",
    "add", "subtract", "multiply", "divide", "power", "maximum", "minimum", "arctan2", "hypot",
    "greater", "greater_equal", "less", "less_equal", "logical_and", "logical_or",
    "negative", "positive", "absolute", "sign", "sqrt", "square", "reciprocal", "exp", "expm1", "log", "log1p",
    "sin", "cos", "tan", "sinh", "cosh", "tanh", "arcsin", "arccos", "arctan",
)  # fmt: skip
"""The operations that a list may have, by numpy's names."""

OPERATIONS: dict[str, int] = {name: code for code, name in enumerate(NAMES)}
OPERATIONS |= {
    "fabs": OPERATIONS["absolute"], "float_power": OPERATIONS["power"], "true_divide": OPERATIONS["divide"],
    "fmax": OPERATIONS["maximum"], "fmin": OPERATIONS["minimum"], "bitwise_and": OPERATIONS["logical_and"],
    "bitwise_or": OPERATIONS["logical_or"],
}  # fmt: skip
"""Their numbers, and other names of theirs."""

UNREADABLE = (
    TypeError, AttributeError, ValueError, LookupError, ArithmeticError, RuntimeError, AssertionError, UndertowError,
)  # fmt: skip
"""What a law's code may raise when it is given symbols."""

MOST_OPERATIONS = 2000
"""A longer law is no formula."""

AGREE = 1e-12
"""Relative difference between the list and the law's own code: rounding."""

MOST_CHECKS = 200
"""Lists whose check is remembered."""

PROBES = np.array([-1.0, -0.37, -0.002, 0.0013, 0.41, 1.0])
"""Displacements, speeds and times of the check, relative to the motion's size, speed and span."""

_WITH_ARRAYS: dict[Callable[..., Any], Callable[..., Any]] = {}


class UnreadableError(UndertowError):
    """A law is no formula of known operations."""


@dataclass
class _Sheet:
    """The operations noted so far: each (operation, operand, operand, operand), a constant's operand its place."""

    rows: list[tuple[int, int, int, int]] = field(default_factory=list)
    known: dict[tuple[int, int, int, int], int] = field(default_factory=dict)
    constants: list[float] = field(default_factory=list)
    numbers: dict[str, int] = field(default_factory=dict)

    def note(self, name: str, *operands: int) -> Symbol:
        """One operation, the same one once."""
        a, b, c = (*operands, 0, 0, 0)[:3]
        row = (OPERATIONS[name], a, b, c)
        if row not in self.known:
            if len(self.rows) >= MOST_OPERATIONS:
                raise UnreadableError(f"a law has more than {MOST_OPERATIONS} operations")
            self.known[row] = len(self.rows)
            self.rows.append(row)
        return Symbol(self, self.known[row])

    def of(self, value: Any) -> Symbol:
        """A symbol for an operand: itself, or a constant."""
        if isinstance(value, Symbol):
            return value
        if np.ndim(value) != 0 and np.size(value) != 1:
            raise UnreadableError("a law combines its samples with an array of other numbers")
        number = float(np.asarray(value, dtype=np.float64).reshape(()))
        place = self.numbers.setdefault(number.hex(), len(self.constants))
        if place == len(self.constants):
            self.constants.append(number)
        return self.note("constant", place)


class Symbol(np.lib.mixins.NDArrayOperatorsMixin):
    """A number of the motion, or of a law, that operations are noted of."""

    __array_priority__ = 1000.0
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, sheet: _Sheet, row: int) -> None:
        self.sheet, self.row = sheet, row

    def __array_ufunc__(self, function: np.ufunc, method: str, *inputs: Any, **more: Any) -> Symbol:
        if method != "__call__" or more or function.__name__ not in OPERATIONS:
            raise UnreadableError(f"a law calls {function.__name__}, which is no known operation")
        return self.sheet.note(function.__name__, *(self.sheet.of(one).row for one in inputs))

    def __array_function__(self, function: Any, types: Any, args: Any, kwargs: Any) -> Symbol:
        if function not in _WITH_ARRAYS or kwargs:
            raise UnreadableError(f"a law calls {getattr(function, '__name__', function)}, which is no known operation")
        made: Symbol = _WITH_ARRAYS[function](self.sheet, *args)
        return made

    def __array__(self, *_: Any, **__: Any) -> Any:
        raise UnreadableError("a law makes an array of its samples")

    def __bool__(self) -> bool:
        raise UnreadableError("a law decides by a value")


def _where(sheet: _Sheet, condition: Any, yes: Any, no: Any) -> Symbol:
    return sheet.note("where", *(sheet.of(one).row for one in (condition, yes, no)))


def _clip(sheet: _Sheet, value: Any, low: Any, high: Any) -> Symbol:
    return sheet.note("minimum", sheet.note("maximum", sheet.of(value).row, sheet.of(low).row).row, sheet.of(high).row)


_WITH_ARRAYS |= {
    np.where: _where, np.clip: _clip,
    np.zeros_like: lambda sheet, _: sheet.of(0.0),
    np.ones_like: lambda sheet, _: sheet.of(1.0),
    np.full_like: lambda sheet, _, value: sheet.of(value),
}  # fmt: skip


@dataclass(frozen=True)
class Formula:
    """Laws as one list: ``rows`` (n, 4) operations in order, the last one the sum of all forces in newtons;
    ``constants`` (c,). Operands that are parameters are places of the parameter vector."""

    rows: np.ndarray
    constants: Array


def formula_of(
    laws: Sequence[tuple[Term, tuple[int, ...]]], theta: Array, size: float, speed: float, span: float
) -> Formula | None:
    """All laws' forces as one list; None where a law cannot be read, or its list does not give what its code does.

    ``laws`` are terms with their places (`PlacedTerm`) in ``theta``, the parameters' values; ``size`` (m), ``speed``
    (m/s) and ``span`` (s) are the motion's, at which the list is held against the code.
    """
    placed = [PlacedTerm(*law) for law in laws]
    sheet = _Sheet()
    try:
        with np.errstate(all="ignore"):
            x, v, t = (sheet.note(name) for name in ("x", "v", "t"))
            total = sheet.of(0.0)
            for term, places in placed:
                total = total + sheet.note("number", places[0]) * sheet.of(_traced(sheet, term, places, (x, v, t)))
    except UNREADABLE:
        return None
    if not math.isfinite(sum(sheet.constants)):
        return None
    rows = np.array(sheet.rows, dtype=np.int64)
    found = Formula(rows, np.array(sheet.constants, dtype=np.float64))
    return found if _agrees(found, placed, theta, size, speed, span) else None


def _traced(sheet: _Sheet, term: Term, places: tuple[int, ...], motion: tuple[Symbol, Symbol, Symbol]) -> Any:
    """A law's force per unit coefficient, its inner parameters as symbols."""
    law = copy.copy(term)
    for parameter, place in zip(term.parameters[1:], places[1:], strict=True):
        object.__setattr__(law, parameter.name, sheet.note("number", place))
    x, v, t = motion
    force: Any = law.force(x, v, sheet.of(0.0), t)  # type: ignore[arg-type]
    return force


_CHECKS: dict[tuple[object, ...], bool] = {}


def _agrees(found: Formula, laws: Sequence[PlacedTerm], theta: Array, size: float, speed: float, span: float) -> bool:
    """Whether the list gives what the laws' code gives, at a few motions; asked once for each list and law."""
    from undertow.equation.tape import evaluate  # compiled where the first law of a user's own is

    key = (found.rows.tobytes(), found.constants.tobytes(), tuple(type(term) for term, _ in laws))
    if key not in _CHECKS:
        if len(_CHECKS) > MOST_CHECKS:
            _CHECKS.clear()
        x, v, t = size * PROBES, speed * PROBES[[3, 0, 4, 1, 5, 2]], span * PROBES**2
        none = np.full(theta.size, -1, dtype=np.int64)
        ours = evaluate(found.rows, found.constants, theta, none, x, v, t)[0]
        with np.errstate(all="ignore"):
            code = np.zeros(x.size)
            for coefficient, law in (placed.at(theta) for placed in laws):
                code += coefficient * np.asarray(law.force(x.copy(), v.copy(), np.zeros(x.size), t.copy()))
        scale = AGREE * np.max(np.abs(code[np.isfinite(code)]), initial=0.0)
        _CHECKS[key] = bool(np.allclose(ours, code, rtol=AGREE, atol=scale, equal_nan=True))
    return _CHECKS[key]
