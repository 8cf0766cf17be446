"""The generated part that hidden states need: their rates, slopes and derivatives by their own parameters.

A hidden oscillator is a row whose expression has a displacement s and a velocity u relative to the body, u' = -a - R,
and pulls at the body with m R; a memory is a row with one state z whose rate may depend on z, x, v and t and whose
force is z. Any number of memories can stand in the registry; of oscillators one kind.

Belongs here: text of their functions. Does not belong here: laws without a state (generate.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from undertow.equation.code_text import A, V, X, directed, function, place, slope, symbol, text
from undertow.equation.term import Expression, Share, Term
from undertow.errors import UndertowError

STARTS = ("hs", "hu")
"""Places of a hidden oscillator's displacement and velocity at the release, behind its own parameters."""


@dataclass(frozen=True)
class Oscillator:
    """The hidden oscillator: slots of one (its parameters, then its start), how many there can be, the slot whose
    positive value says that there is one, and R with its symbols s and u."""

    slots: tuple[str, ...]
    most: int
    present: str
    pull: Expression
    s: Expression
    u: Expression

    @classmethod
    def of(cls, row: type[Term], slots: tuple[str, ...], share: Share) -> Oscillator:
        """From a row's expression; UndertowError where it is of another form."""
        (first, speed), (second, rate) = share.states[:2]
        s, u = sp.Symbol(first, real=True), sp.Symbol(second, real=True)
        pull = sp.expand(-rate - A)
        alike = speed == u and not pull.has(A) and sp.expand(share.smooth + symbol(slots[0]) * pull) == 0
        if len(share.states) != 2 or not alike:
            raise UndertowError(
                f"{row.name}: a hidden oscillator has s' = u, u' = -a - R and pulls with m R at the body; its "
                f"{second}' is {rate}; write it so, or leave its slots empty"
            )
        return cls((*slots, *STARTS), row.held_by_kernel, row.slots[row.present_by], pull, s, u)

    @property
    def names(self) -> dict[Expression, str]:
        """What the parameters are called in the text."""
        named = {symbol(slot): f"th[o + {i}]" for i, slot in enumerate(self.slots)}
        return {**named, symbol(self.slots[0]): "th[o]", self.s: "s", self.u: "u"}

    @property
    def first(self) -> str:
        """The place of the first one's first parameter."""
        return f"o = {place(self.slots[0])} + i * _NH"

    def by(self, one: Expression) -> Expression:
        """Derivative of R."""
        way = sp.Symbol("way", real=True)
        smooth = slope(self.pull.subs(sp.Abs(self.u), self.u * way), one)
        return sp.expand(smooth.subs(way, sp.Abs(self.u) / self.u))

    def explicit_lines(self) -> list[str]:
        """Lines of the derivative of the body's force by the parameters of its oscillators."""
        return [
            "for i in range(nh):", f"    {self.first}", "    if slot >= o and slot < o + _NH:", "        if slot == o:",
            "            return _hidden_restoring(th, i, y[2 + 2 * i, 0], y[3 + 2 * i, 0])",
            "        return th[o] * _explicit_hidden(th, slot, i, y[2 + 2 * i, 0], y[3 + 2 * i, 0])",
        ]  # fmt: skip


def oscillator_text(one: Oscillator) -> str:
    """Functions of the hidden oscillators."""
    names = one.names
    explicit = [one.first, "p = slot - o"]
    for i, slot in enumerate(one.slots[1 : -len(STARTS)], start=1):
        explicit += [f"if p == {i}:", f"    return {text(one.by(symbol(slot)), names)}"]
    kinks = [slot for slot in one.slots if sp.diff(one.pull, symbol(slot)).has(sp.Abs)]
    bent = " or ".join(f"th[o + {one.slots.index(slot)}] != 0.0" for slot in kinks) or "False"
    return (
        function("_hidden_restoring", "th, i, s, u", "R of hidden oscillator i, per unit mass.", [
            one.first, f"return {text(one.pull, names)}"])
        + function("_hidden_slopes", "th, i, s, u, jac", "Derivatives of R by s and by u, into jac.", [
            one.first, f"jac[2 * i] = {text(one.by(one.s), names)}", f"jac[2 * i + 1] = {text(one.by(one.u), names)}"])
        + function("_explicit_hidden", "th, slot, i, s, u", "dR / d(slot) at fixed state.", [*explicit, "return 0.0"])
        + function("_hidden_kinks", "th, i", "Whether R bends where u = 0.", [one.first, f"return {bent}"])
    )  # fmt: skip


@dataclass(frozen=True)
class Lanes:
    """A memory: its slots, how many there can be (0: one, whose slots have no number), the slot whose positive value
    says that there is one, and the rate of its state in the direction of motion."""

    slots: tuple[str, ...]
    most: int
    present: str
    rate: Expression
    state: Expression

    @classmethod
    def of(cls, row: type[Term], slots: tuple[str, ...], share: Share) -> Lanes:
        """From a row's expression; UndertowError where its force is not its state."""
        ((name, rate),) = share.states
        state = sp.Symbol(name, real=True)
        if share.smooth != state or share.friction != 0 or sp.sympify(rate).has(A):
            raise UndertowError(
                f"{row.name}: a law with one state has this state as its force, and a rate of x, v, t and the state; "
                f"its force is {share.smooth} with {name}' = {rate}; write it so, or leave its slots empty"
            )
        return cls(slots, row.held_by_kernel, row.slots[row.present_by], directed(rate), state)

    @property
    def moves_at_rest(self) -> bool:
        """Whether the state changes while the body stands still."""
        return bool(sp.simplify(self.rate.subs(V, 0)) != 0)

    @property
    def names(self) -> dict[Expression, str]:
        """What the parameters are called in the text."""
        at = {symbol(slot): f"th[{self.at(i)}]" for i, slot in enumerate(self.slots)}
        return {**at, self.state: "z"}

    def at(self, i: int) -> str:
        """The place of parameter i."""
        if not self.most:
            return place(self.slots[i])
        return f"o + {i}" if i else "o"

    def loop(self, number: int, lines: Sequence[str]) -> list[str]:
        """Lines over all of it."""
        if self.most:
            first = [f"for j in range(dims[{3 + number}]):", f"    o = {place(self.slots[0])} + j * {len(self.slots)}"]
        else:
            first = [f"if dims[{3 + number}] > 0:"]
        return [*first, "    z = y[at, 0]", *(f"    {line}" for line in lines), "    at += 1"]


def _column(one: Lanes) -> list[str]:
    """Lines of a state's sensitivity."""
    names = one.names
    by_state = ((V, "dv"), (one.state, "y[at, c]"), (X, "dx"))
    parts = [(slope(one.rate, of), sp.Symbol(times)) for of, times in by_state]
    rate = " + ".join(text(sp.factor_terms(by) * times, names) for by, times in parts if by != 0)
    lines = [f"rate = {rate}"]
    own = [(one.at(i), slope(one.rate, symbol(slot))) for i, slot in enumerate(one.slots)]
    own += [(place("xe"), -slope(one.rate, X))]
    found = [(where, by) for where, by in own if by != 0]
    for i, (where, by) in enumerate(found):
        lines += [f"{'el' if i else ''}if slot == {where}:", f"    rate += {text(sp.factor_terms(by), names)}"]
    return [*lines, "k[stage, at, c] = rate"]


def lanes_text(oscillator: Oscillator, lanes: Sequence[Lanes]) -> str:
    """Functions of the memories, and the state's dimensions."""
    look = oscillator.slots.index(oscillator.present)
    count = ["nh = 0", "for i in range(MAX_HIDDEN):",
             f"    if th[{place(oscillator.slots[0])} + i * _NH + {look}] > 0.0:", "        nh = i + 1"]  # fmt: skip
    rates, columns = ["at = 2 + 2 * dims[1]"], ["at = 2 + 2 * dims[1]"]
    for number, one in enumerate(lanes):
        if one.most:
            here = f"{place(one.slots[0])} + j * {len(one.slots)} + {one.slots.index(one.present)}"
            count += [f"n{number} = 0", f"for j in range({one.most}):", f"    if th[{here}] > 0.0:",
                      f"        n{number} = j + 1"]  # fmt: skip
        else:
            count.append(f"n{number} = 1 if th[{place(one.present)}] > 0.0 else 0")
        rates += one.loop(number, [f"k[stage, at, 0] = {text(sp.factor_terms(one.rate), one.names)}"])
        columns += one.loop(number, _column(one))
    many = " + ".join(f"n{i}" for i in range(len(lanes))) or "0"
    each = "".join(f", n{i}" for i in range(len(lanes)))
    count += [f"many = {many}", f"return 2 + 2 * nh + many, nh, many{each}"]
    return (
        function("_dimensions", "th", "Length of the state; how many hidden oscillators, memories, and each memory.",
                 count, inline=False)
        + function("_memory_rates", "th, y, k, stage, dims, x, v, d, side, t", "Rates of all memories into k.", rates)
        + function("_memory_column", "th, slot, y, k, stage, c, dims, x, v, d, side, t, dx, dv",
                   "Rates of the memories' sensitivities by column c.", columns)
    )  # fmt: skip
