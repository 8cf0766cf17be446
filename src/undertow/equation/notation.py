"""How an equation is written: in one line of text, and in LaTeX.

A term's ``law`` and ``latex`` hold its parameters' symbols; here numbers take their places, with the digits that
their errors allow. What stands behind the first comma of a law is the equation of its hidden state: it is written
after the equation of motion. Does not belong here: the laws themselves.
"""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Mapping

from undertow.equation.term import Term
from undertow.quantities import Parameter, format_number, unit_in_rotation


def plain_symbol(parameter: Parameter) -> str:
    """The parameter's symbol as the term's ``law`` writes it, without LaTeX's marks.

    >>> [plain_symbol(Parameter("", "1", symbol)) for symbol in (r"\\zeta_s", r"\\beta\\gamma")]
    ['zeta_s', 'beta gamma']
    """
    return re.sub(r"[\\{}]", "", re.sub(r"(?<=\w)\\", " ", parameter.symbol))


def term_text(
    term: Term, coefficient: float, error: float = math.nan, number: str = "", inner: Mapping[str, float] | None = None
) -> tuple[str, str]:
    """A term as text with numbers, sign in front, and the equation of its hidden state ("" where it has none).

    ``number`` tells several hidden states apart (s1, s2); ``inner`` are standard errors of inner parameters, by name.

    >>> from undertow.equation.structure import StribeckFriction
    >>> term_text(StribeckFriction(velocity_m_per_s=0.02), -60.0)
    ('- 60 exp(-(v / 0.02)^2) sign(v)', '')
    """
    errors = inner or {}
    values = {
        plain_symbol(p): format_number(float(getattr(term, p.name)), errors.get(p.name, math.nan))
        for p in term.parameters[1:]
    }
    symbol = plain_symbol(term.coefficient)
    force, memory = _parted(_numbered(term.law, number), ", ")
    sign = "+"
    if _holds(force, symbol):
        sign = "-" if coefficient < 0.0 else "+"
        force = _replaced(force, {symbol: format_number(abs(coefficient), error)})
    memory = _replaced(memory, {symbol: format_number(coefficient, error)} | values)
    return f"{sign} {_tidy(_replaced(force, values))}", _tidy(memory)


def term_latex(
    term: Term, coefficient: float | None = None, error: float = math.nan, number: str = "",
    inner: Mapping[str, float] | None = None, rotation: bool = False,
) -> tuple[str, str]:  # fmt: skip
    """A term in LaTeX and the equation of its hidden state; with a coefficient, numbers and units instead of symbols.

    ``inner`` are standard errors of inner parameters, by name. Parts of a hidden state that are zero are left out. In a
    ``rotation`` units are those of moments, inertias and radians.

    >>> from undertow.equation.structure import Stiffness
    >>> term_latex(Stiffness(), 109600.0, 300.0)[0]
    '+ (109600 \\\\pm 300)\\\\,\\\\mathrm{N/m}\\\\,x'
    >>> term_latex(Stiffness(), 20.0, rotation=True)[0]
    '+ 20\\\\,\\\\mathrm{N\\\\,m/rad}\\\\,x'
    """
    force, memory = _parted(_numbered(term.latex, number), r",\ ")
    sign = "+"
    if coefficient is not None:
        errors = inner or {}
        units = {p.name: unit_in_rotation(p.unit) if rotation else p.unit for p in term.parameters}
        values = {
            p.symbol: quantity_latex(float(getattr(term, p.name)), units[p.name], errors.get(p.name, math.nan))
            for p in term.parameters[1:]
        }
        memory = _without_zeros(memory, {p.symbol for p in term.parameters[1:] if getattr(term, p.name) == 0.0})
        symbol, unit = term.coefficient.symbol, units[term.coefficient.name]
        if _holds(force, symbol):
            sign = "-" if coefficient < 0.0 else "+"
            force = _replaced(force, {symbol: quantity_latex(abs(coefficient), unit, error) + r"\,"})
        memory = _replaced(memory, {symbol: quantity_latex(coefficient, unit, error)} | values).replace("+-", "-")
        memory = re.sub(r"(?<=[\d})])\\,(?=\(?\d)", r"\\cdot ", memory)
        force = re.sub(r"(\\,\s*)+", r"\\,", _replaced(force, values))
    elif number:
        symbols = {p.symbol: _symbol_numbered(p.symbol, number) for p in term.parameters}
        force, memory = _replaced(force, symbols), _replaced(memory, symbols)
    return f"{sign} {force}", memory


def _symbol_numbered(symbol: str, number: str) -> str:
    """A parameter's symbol where its law stands in an equation more than once.

    >>> _symbol_numbered(r"\\zeta_s", "_2"), _symbol_numbered("G", "_2")
    ('\\\\zeta_{s2}', 'G_2')
    """
    name, below, place = symbol.partition("_")
    return f"{name}_{{{place.strip('{}')}{number[1:]}}}" if below else f"{symbol}{number}"


def _parted(law: str, comma: str) -> tuple[str, str]:
    """A law's force and the equation of its hidden state: at the first comma outside brackets.

    >>> _parted("k max(|x| - g, 0), s' = v", ", ")
    ('k max(|x| - g, 0)', "s' = v")
    """
    at = law.find(comma)
    while at >= 0:
        if law.count("(", 0, at) == law.count(")", 0, at):
            return law[:at], law[at + len(comma) :]
        at = law.find(comma, at + 1)
    return law, ""


def _without_zeros(memory: str, symbols: Collection[str]) -> str:
    """An equation of a hidden state without the parts that hold one of these symbols, whose value is zero.

    >>> _without_zeros(r"\\ddot{s}+w^2 s+b s|s|+d (s + 1)^3=-x", {"b", "d"})
    '\\\\ddot{s}+w^2 s=-x'
    """
    left, equals, right = memory.partition("=")
    first, *parts = re.split(r"\+(?![^()]*\))", left)
    kept = [part for part in parts if not any(_holds(part, symbol) for symbol in symbols)]
    return "+".join([first, *kept]) + equals + right


def quantity_latex(value: float, unit: str, error: float = math.nan) -> str:
    """A number with its unit (none for "1") in LaTeX; with its error where that is finite.

    >>> quantity_latex(3924.2, "N s^2/m^2", 120.0)
    '(3920 \\\\pm 120)\\\\,\\\\mathrm{N\\\\,s^{2}/m^{2}}'
    """
    text = format_number(value, error)
    if math.isfinite(error) and error > 0.0:
        text = rf"({text} \pm {format_number(error, error)})"
    mantissa, marked, exponent = text.partition("e")
    if marked:
        text = rf"{mantissa}\times10^{{{int(exponent)}}}"
    if unit in ("", "1"):
        return text
    printed = re.sub(r"\^(-?\w+)", r"^{\1}", _as_powers(unit)).replace(" ", r"\,")
    return rf"{text}\,\mathrm{{{printed}}}"


def _as_powers(unit: str) -> str:
    """One over something as powers below zero; any other unit as it is.

    >>> _as_powers("1/m^2/s^2"), _as_powers("N s/m")
    ('m^-2 s^-2', 'N s/m')
    """
    if not unit.startswith("1/"):
        return unit
    parts = (part.partition("^") for part in unit[2:].split("/"))
    return " ".join(f"{base}^-{power or 1}" for base, _, power in parts)


def _pattern(symbol: str) -> str:
    """Matches a symbol that is not a part of a longer one."""
    return rf"(?<![\\A-Za-z_]){re.escape(symbol)}(?![A-Za-z_0-9])"


def _holds(law: str, symbol: str) -> bool:
    return re.search(_pattern(symbol), law) is not None


def _replaced(law: str, values: dict[str, str]) -> str:
    """The law with symbols replaced, all at once, so that no replacement is taken for a symbol."""
    if not values:
        return law
    either = re.compile("|".join(f"(?:{_pattern(s)})" for s in values))

    def written(found: re.Match[str]) -> str:
        value = values[found.group()]
        powered = found.end() < len(law) and law[found.end()] == "^"
        return f"({value})" if powered and "\\" in value else value

    return either.sub(written, law)


def _numbered(law: str, number: str) -> str:
    """The law with its hidden states s, z, r numbered, where there are several; numbers and their units come after."""
    if not number:
        return law
    law = re.sub(r"(?<![\\A-Za-z_0-9])([szr])(?![A-Za-z_0-9])", rf"\g<1>{number}", law)
    return re.sub(rf"\{{([szr]){number}\}}", rf"{{\g<1>}}{number}", law)  # dots stand over the letter alone


def _tidy(law: str) -> str:
    """Without parts and powers that are zero; dots between numbers that stand side by side; minus for a plus and a
    minus."""
    law = re.sub(r" \+ 0 [^+=]+(?= [+=])", "", law)
    law = re.sub(r" \([^()]*\)\^\(1-1\)", "", law).replace("^(0+", "^(")
    law = re.sub(r"(?<=\d) (?=\d)", " · ", law)
    return law.replace("+ -", "- ")
