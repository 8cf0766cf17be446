"""The integrator's part that follows from the laws' rows: `python -m undertow.equation.generate` writes algebra.py.

Every row of the registry gives its expression (`Term.by_slots`). Its force, the slopes by x and v and the derivatives
by its parameters become text that numba compiles; so do the rates of hidden states. A law whose coefficient is 0 is
passed over: laws that are sums of powers share one look at their coefficients, any other has a look of its own, and
those of Eq. 15 are always there. `--check` says whether the file is up to date, and writes nothing.

What stays by hand, in kernel.py: events and sticking, the history behind a delay, the jump of sensitivities, steps that
shrink near a reversal. Does not belong here: how an expression becomes text (code_text.py).
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import sympy as sp

from undertow.equation import registry
from undertow.equation.code_text import (
    ECHO,
    PLACE,
    SIDE,
    D,
    T,
    V,
    X,
    directed,
    function,
    linear_in,
    nested,
    place,
    slope,
    symbol,
    text,
)
from undertow.equation.generate_states import STARTS, Lanes, Oscillator, lanes_text, oscillator_text
from undertow.equation.term import Expression, Share, Term
from undertow.errors import UndertowError

TARGET = Path(__file__).with_name("algebra.py")

BODY = ("mass", "xe", "x0", "v0", "let_go", "let_go_p", "hold")
"""Places of the body's own numbers: mass, rest position, displacement and velocity at the release; the time in which
its hook lets go, with the exponent of how, and what that held, which the integrator itself works out."""

LONG = 4
"""Sums of more parts are written with what they have in common worked out first."""

_HEAD = '''"""Generated from the laws' rows: forces, slopes and derivatives of all laws, compiled into the integrators.

Do not edit: change a law's row (structure.py and its neighbours) and run `python -m undertow.equation.generate`.
A test compares.
"""

# mypy: disable-error-code="no-untyped-def, untyped-decorator, no-any-return"
# ruff: noqa: E501

from __future__ import annotations

import math

from numba import njit

from undertow.compiling import WITHIN

'''


@dataclass(frozen=True)
class Law:
    """An algebraic law in the integrator's own numbers: its slots, force (friction times direction in it), the size of
    its friction, the slots at which it is linear, and whether it is passed over where it is not ``shown``."""

    name: str
    slots: tuple[str, ...]
    smooth: Expression
    friction: Expression
    linear: tuple[str, ...]
    always: bool

    @property
    def force(self) -> Expression:
        """All of it, in the direction of motion."""
        return directed(self.smooth + self.friction * D)

    @property
    def shown(self) -> tuple[str, ...]:
        """The slots of which one is not 0 where it is there: its rates, of a force that the time alone tells."""
        of_time = self.force.has(T) and not self.force.has(X, V, D, SIDE, ECHO)
        return tuple(slot for slot in self.slots if slot not in self.linear) if of_time else self.linear

    @property
    def powers(self) -> bool:
        """Whether it is a sum of powers of x and v."""
        return bool(self.force.is_polynomial(X, V, D, SIDE)) and not self.force.has(T, ECHO)


def read(rows: Sequence[type[Term]]) -> tuple[tuple[Law, ...], Oscillator, tuple[Lanes, ...]]:
    """All rows in the integrator's numbers: algebraic laws, the hidden oscillator, first-order states.

    Raises UndertowError where a row with slots has no expression, is not linear in its coefficient, shares a slot with
    another expression, or has states of a form that the integrator does not hold; where no row is an oscillator.
    """
    laws: dict[tuple[str, ...], Law] = {}
    oscillator: Oscillator | None = None
    lanes: list[Lanes] = []
    for row in (row for row in rows if row.slots and not row.is_inertia):
        slots = tuple(row.slots[parameter.name] for parameter in row.parameters)
        share = row().by_slots({slot: symbol(slot) for slot in slots}, PLACE, "")
        if share is None:
            raise UndertowError(f"{row.name} has slots {', '.join(slots)} and no expression; write its `share`")
        if len(share.states) == 1:
            lanes.append(Lanes.of(row, slots, share))
        elif share.states:
            if oscillator is not None:
                raise UndertowError(f"{row.name} is a second kind of hidden oscillator; the integrator holds one kind")
            oscillator = Oscillator.of(row, slots, share)
        else:
            _place(laws, _law(row, slots, share))
    if oscillator is None:
        raise UndertowError(f"none of {len(rows)} rows is a hidden oscillator; the integrator has places for one kind")
    return tuple(laws.values()), oscillator, tuple(lanes)


def _place(laws: dict[tuple[str, ...], Law], law: Law) -> None:
    """Add a law; two rows may stand at one slot with one expression, and never otherwise."""
    for known in laws.values():
        if set(known.slots) & set(law.slots) and (known.slots, known.force) != (law.slots, law.force):
            raise UndertowError(
                f"{law.name} and {known.name} stand at slot {sorted(set(known.slots) & set(law.slots))[0]!r} with "
                "other expressions; give the new law slots of its own"
            )
    laws.setdefault(law.slots, law)


def _law(row: type[Term], slots: tuple[str, ...], share: Share) -> Law:
    smooth, friction = directed(share.smooth), directed(share.friction)
    linear = linear_in(directed(smooth + friction * D), [symbol(slot) for slot in slots])
    if not linear or (smooth + friction).subs({s: 0 for s in linear}) != 0:
        raise UndertowError(
            f"{row.name}: its force {smooth + friction * D} is not linear in its coefficient {slots[0]!r}; "
            "write it so, or leave its slots empty"
        )
    names = tuple(s.name for s in linear)
    return Law(row.name, slots, smooth, friction, names, row.name in registry.EQUATION_15)


# ---------------------------------------------------------------- text
def _names(laws: Iterable[Law]) -> dict[Expression, str]:
    return {symbol(slot): f"th[{place(slot)}]" for law in laws for slot in law.slots}


def _present(slots: Iterable[str]) -> str:
    return " or ".join(f"th[{place(slot)}] != 0.0" for slot in slots)


def _groups(laws: Iterable[Law]) -> list[tuple[Law, ...]]:
    """Laws that share one look: those always there first, then powers of x, powers with v, and each other law alone."""
    found: dict[str, list[Law]] = {"always": []}
    for law in laws:
        kind = "powers of v" if law.force.has(V) else "powers of x"
        found.setdefault("always" if law.always else kind if law.powers else law.name, []).append(law)
    return [tuple(group) for group in found.values()]


def _sum_of(group: Sequence[Law], parts: Sequence[Expression], into: Sequence[str], first: bool) -> list[str]:
    """Lines that add a group's ``parts`` to the variables ``into``; the first group's begin them."""
    names = _names(group)
    lines = []
    done = [nested(part) for part in parts]
    common: list[tuple[Expression, Expression]] = []
    if not first:
        common, done = sp.cse(done, symbols=(sp.Symbol(f"w{i}", real=True) for i in range(1000)))
        if all(law.powers for law in group):
            common, done = [], [nested(part) for part in parts]
    lines += [f"{name.name} = {text(value, names)}" for name, value in common]
    for variable, part in zip(into, done, strict=True):
        if first:
            lines.append(f"{variable} = {text(part, names)}")
        elif part != 0:
            minus = part.could_extract_minus_sign()
            lines.append(f"{variable} {'-' if minus else '+'}= {text(-part if minus else part, names)}")
    if lines and not first:
        return [f"if {_present(slot for law in group for slot in law.shown)}:", *(f"    {line}" for line in lines)]
    return lines


def _adding(laws: Sequence[Law], parts: Sequence[str], into: Sequence[str], begun: bool = False) -> list[str]:
    """Lines over all groups: ``parts`` names what of a law is added ("smooth", "friction", "by x", "by v")."""
    lines = []
    for i, group in enumerate(_groups(laws)):
        if group or not begun:
            sums = [sum((_part(law, part) for law in group), sp.Integer(0)) for part in parts]
            lines += _sum_of(group, sums, into, i == 0 and not begun)
    return lines


def _part(law: Law, part: str) -> Expression:
    if part == "by x":
        return slope(law.force, X)
    if part == "by v":
        return slope(law.force, V)
    return law.smooth if part == "smooth" else law.friction


def _forces_text(laws: Sequence[Law]) -> str:
    outside = [law for law in laws if law.force.has(T, ECHO)]
    steady = [law for law in laws if law not in outside]
    rubbing = [law for law in steady if law.friction != 0]
    smooth = [law for law in steady if law.smooth != 0]
    late = [law for law in outside if law.force.has(ECHO)]
    first = " + ".join(text(law.force, _names([law])) for law in late) or "0.0"
    clocks = [law for law in outside if law not in late]
    return (
        function("_resisting", "th, x, v, d, side", "Friction's size in the direction d of motion, N.",
                 [*_adding(rubbing, ["friction"], ["size"]), "return size"])
        + function("_smooth_force", "th, x, v, d, side", "All forces of x and v but friction, N.",
                   [*_adding(smooth, ["smooth"], ["f"]), "return f"])
        + function("_outside_force", "th, x, v, d, side, t, echo", "Forces that the time tells, or an echo, N.",
                   [f"f = {first}", *_adding(clocks, ["smooth"], ["f"], begun=True), "return f"])
        + function("_slopes", "th, x, v, d, side, t", "Derivatives of all forces by x and by v, N/m and N s/m.",
                   [*_adding([*steady, *clocks], ["by x", "by v"], ["fx", "fv"]), "return fx, fv"])
    )  # fmt: skip


def _explicit_text(laws: Sequence[Law], oscillator: Oscillator) -> str:
    clocks = [law for law in laws if law.force.has(T) and not law.force.has(X, V, D, SIDE, ECHO)]
    lines = ["if slot == _MASS:", "    return -a", "if slot == _XE:", "    return fx"]
    lines += _derivatives([law for law in laws if law not in clocks])
    lines += [f"if slot in {_among(slot for law in clocks for slot in law.slots)}:",
              "    return _explicit_drive(th, slot, t)"]  # fmt: skip
    lines += oscillator.explicit_lines()
    return function(
        "_explicit_drive", "th, slot, t", "d(M a)/d(slot) of forces that the time alone tells, N per unit of the slot.",
        [*_derivatives(clocks), "return 0.0"],
    ) + function(
        "_explicit_force", "th, slot, y, nh, t, d, side, x, v, a, fx, echo",
        "d(M a)/d(slot) at fixed state, N per unit of the slot.", [*lines, "return 0.0"],
    )  # fmt: skip


def _derivatives(laws: Sequence[Law]) -> list[str]:
    """Lines that give the derivative of each law by each of its slots."""
    lines: list[str] = []
    for law in laws:
        for slot in law.slots:
            by = -slope(law.force, symbol(slot))
            if by != 0:
                lines += [f"if slot == {place(slot)}:", *(f"    {line}" for line in _returned(by, _names([law])))]
    return lines


def _returned(value: Expression, names: dict[Expression, str]) -> list[str]:
    """Lines that return a value; what stands in a long sum many times is worked out once."""
    if len(sp.Add.make_args(value)) <= LONG:
        return [f"return {text(value, names)}"]
    common, (rest,) = sp.cse([value], symbols=(sp.Symbol(f"w{i}", real=True) for i in range(1000)))
    return [*(f"{name.name} = {text(part, names)}" for name, part in common), f"return {text(rest, names)}"]


def _among(slots: Iterable[str]) -> str:
    """Places of the parameter vector as a tuple."""
    places = [place(slot) for slot in slots]
    return f"({', '.join(places)}{',' if len(places) == 1 else ''})"


def _events_text(laws: Sequence[Law], lanes: Sequence[Lanes]) -> str:
    """Which laws bend or jump, and where."""
    rubs = [s for law in laws if law.friction != 0 for s in law.linear]
    bends = [s for law in laws if law.force.has(D) for s in law.linear]
    kinks = [s for law in laws if law.force.has(SIDE) for s in law.linear]
    turns = sorted({*rubs, *bends}, key=[s for law in laws for s in law.slots].index)
    either = [f"dims[{3 + i}] > 0" for i, one in enumerate(lanes) if one.rate.has(D)]
    clocks = [s for law in laws if law.force.has(T) for s in law.shown]
    stirs = ["dims[1] > 0", *(f"dims[{3 + i}] > 0" for i, one in enumerate(lanes) if one.moves_at_rest)]

    return (
        function("_rubs", "th", "Whether friction can hold the body.", [f"return {_present(rubs)}"])
        + function("_turns", "th, active, dims", "Whether a law bends where the body reverses, or would.", [
            f"found = {' or '.join([_present(turns), *either])}", "for slot in active:",
            f"    found = found or slot in {_among(bends)}", "return found"])
        + function("_kinks", "th, active", "Whether a law bends where the body passes its rest position, or would.", [
            f"found = {_present(kinks)}", "for slot in active:", f"    found = found or slot in {_among(kinks)}",
            "return found"])
        + function("_stirs", "th, dims", "Whether something may move a body that sticks: what has a time of its own.", [
            f"return {' or '.join([*stirs, _present(clocks)])}"])
    )  # fmt: skip


def slots_of(laws: Sequence[Law], lanes: Sequence[Lanes]) -> tuple[str, ...]:
    """Places of the parameter vector without numbers, in order."""
    found = [*BODY, *(slot for law in laws for slot in law.slots)]
    return tuple(dict.fromkeys([*found, *(slot for one in lanes if not one.most for slot in one.slots)]))


def _rows(words: Iterable[str]) -> str:
    """Words as a tuple, twelve a line."""
    every = list(words)
    return "(\n" + "".join(f"    {', '.join(every[i : i + 12])},\n" for i in range(0, len(every), 12)) + ")"


def _slots_text(laws: Sequence[Law], oscillator: Oscillator, lanes: Sequence[Lanes]) -> str:
    plain = slots_of(laws, lanes)
    numbered = [(oscillator.slots, oscillator.most), *((one.slots, one.most) for one in lanes if one.most)]
    every = [*plain, *(f"{slot}{i}" for slots, most in numbered for i in range(1, most + 1) for slot in slots)]
    out = f"SLOTS: tuple[str, ...] = {_rows(map(repr, every))}\n".replace("'", '"')
    out += '"""Names of the parameter vector\'s places, in order: hm1 is the first hidden oscillator\'s mass."""\n\n'
    out += "SLOT: dict[str, int] = {name: i for i, name in enumerate(SLOTS)}\nN_SLOTS = len(SLOTS)\n\n"
    out += f"{_rows(map(place, plain))} = range({len(plain)})\n"
    at = len(plain)
    for slots, most in numbered:
        out += f"{place(slots[0])} = {at}\n"
        at += len(slots) * most
    out += f"_NH = {len(oscillator.slots)}\n_START = {oscillator.slots.index(STARTS[0])}\n"
    out += f"MAX_HIDDEN = {oscillator.most}\n"
    rubs = [slot for law in laws if law.friction != 0 for slot in law.linear]
    out += f"\nRUBBING: tuple[str, ...] = ({', '.join(map(repr, rubs))},)\n".replace("'", '"')
    return out + '"""Slots that hold friction: it goes with the normal force."""\n\n\n'


_POWERS = '''@njit(inline="always", **WITHIN)
def _power_law(v, p):
    """|v|^p sign(v); beyond a reversal it goes on as an odd function."""
    if v == 0.0:
        return 0.0
    return math.copysign(abs(v) ** p, v)


@njit(inline="always", **WITHIN)
def _power_slope(v, p, way):
    """p |v|^(p-1); 0 at v = 0, and beyond a reversal for an exponent below one, where it has a pole."""
    if v != 0.0 and (v * way > 0.0 or p >= 1.0):
        return p * abs(v) ** (p - 1.0)
    return 0.0


@njit(inline="always", **WITHIN)
def _power_log(v, p):
    """|v|^p sign(v) log|v|."""
    if v == 0.0:
        return 0.0
    return _power_law(v, p) * math.log(abs(v))


'''


def generated(rows: Sequence[type[Term]] | None = None) -> str:
    """Text of algebra.py for these rows (the registry's)."""
    laws, oscillator, lanes = read(registry.catalogue() if rows is None else rows)
    out = _HEAD + _slots_text(laws, oscillator, lanes) + _POWERS + _forces_text(laws)
    out += _explicit_text(laws, oscillator) + _events_text(laws, lanes)
    return (out + oscillator_text(oscillator) + lanes_text(oscillator, lanes)).rstrip() + "\n"


def texts() -> dict[Path, str]:
    """Every generated file of the registry's rows, and its text."""
    from undertow.equation.generate_columns import columns_text  # it reads rows as this file does

    return {TARGET: generated(), TARGET.with_name("columns.py"): columns_text(registry.catalogue())}


def main(arguments: Sequence[str]) -> int:
    """Write the generated files, or with --check say whether they are up to date: 0 where they are."""
    old = [
        (path, new) for path, new in texts().items() if not path.exists() or path.read_text(encoding="utf-8") != new
    ]
    if "--check" in arguments:
        said = "".join(f"{path} is not what the rows give; write it anew\n" for path, _ in old)
        sys.stdout.write(said or "up to date\n")
        return 1 if old else 0
    for path, new in old:
        path.write_text(new, encoding="utf-8")
    sys.stdout.write("".join(f"{path}: written\n" for path, _ in old) or "unchanged\n")
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
