"""The repaired equation: the prescribed one with a verdict's numbers and the laws that it names.

Belongs here: putting those numbers and laws into the equation, and their errors. Does not belong here: finding them
(judge.py), writing the equation (equation/notation.py).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from undertow.comparison.suspect import UNIT
from undertow.comparison.suspects import all_suspects
from undertow.discrepancy.verdict import Verdict
from undertow.equation.equation import Equation
from undertow.equation.registry import find, row
from undertow.errors import IdentificationError
from undertow.likelihood.fit import Specimen
from undertow.likelihood.scale import contract_name
from undertow.quantities import Estimate


def repaired_equation(prescribed: Equation, verdict: Verdict, specimen: Specimen) -> Equation:
    """The prescribed equation with a verdict's numbers and the laws that it names.

    Raises IdentificationError where one of them is no law of motion.
    """
    if verdict.augmented is None:
        return prescribed
    numbers = verdict.augmented.parameters
    terms, values = [], []
    mass = prescribed.mass_kg
    if "total_mass_kg" in numbers and not any(t.is_inertia for t in prescribed.terms):
        mass = numbers["total_mass_kg"].value
    replaced, given_back = _taken(verdict)
    for term, value in zip(prescribed.terms, prescribed.coefficients, strict=True):
        slot = term.slots.get(term.coefficient.name, "")
        if slot not in replaced:
            terms.append(term)
            values.append(_refitted(term.name, value, numbers, specimen) + given_back.get(slot, 0.0))
    for name in named_laws(verdict):
        law = row(name)
        if law is None or law.own_clock:
            raise IdentificationError(
                f"{name} is no law of the body's motion with the same numbers in all trials; the repaired equation is "
                "the prescribed one with that corrected: take .prescribed and .parameters"
            )
        for at in range(_how_many(name, numbers)):
            prefix = f"{name}#{at + 1}." if at else f"{name}."
            given = {key.removeprefix(prefix): e.value for key, e in numbers.items() if key.startswith(prefix)}
            term, value = _added(name, given, specimen)
            terms.append(term)
            values.append(value)
    return Equation(tuple(terms), tuple(values), mass, prescribed.rest_m)


def named_laws(verdict: Verdict) -> tuple[str, ...]:
    """What a verdict names, each once, without "unknown"."""
    return tuple(name for name in dict.fromkeys(verdict.verdict) if name != "unknown")


def repaired_errors(
    prescribed: Equation, errors: Mapping[str, float], verdict: Verdict, specimen: Specimen
) -> dict[str, float]:
    """Standard errors of the repaired equation's coefficients by term name ("mass": total mass), as `errors` are of the
    prescribed one. Numbers that were held keep theirs, also where a law of the prescribed equation is named once more;
    a law that is named more than once has none."""
    if verdict.augmented is None:
        return dict(errors)
    numbers, out = verdict.augmented.parameters, dict(errors)
    prescribed_names = {term.name for term in prescribed.terms}
    for term in prescribed.terms:
        for key, factor in _keys(term.name, specimen):
            if key in numbers:
                out[term.name] = numbers[key].total_stderr / factor
                break
    if "total_mass_kg" in numbers and not any(t.is_inertia for t in prescribed.terms):
        out["mass"] = numbers["total_mass_kg"].total_stderr
    for name in named_laws(verdict):
        if row(name) is None or name in prescribed_names:
            continue
        out.pop(name, None)
        found = [numbers[f"{name}.{key}"] for key in (find(name).coefficient.name, _own_name(name))
                 if f"{name}.{key}" in numbers]  # fmt: skip
        if found and _how_many(name, numbers) == 1:
            out[name] = found[0].total_stderr
    return out


def _keys(term: str, specimen: Specimen) -> Iterator[tuple[str, float]]:
    """Under which names a term's coefficient stands among a verdict's numbers, and number per coefficient."""
    for known in (specimen, Specimen()):
        key, _, factor = contract_name(term, known)
        yield key, factor
        yield f"{key}_per_mass", factor


def _taken(verdict: Verdict) -> tuple[frozenset[str], Mapping[str, float]]:
    """Slots of the integrator whose coefficient what is named stands in place of, and what it adds to others (a sine
    instead of a line takes from the line)."""
    numbers = {} if verdict.augmented is None else verdict.augmented.parameters
    laws = named_laws(verdict)
    additions = {s.name: s.additions(UNIT, 1.0) for s in reversed(all_suspects()) if s.name in laws}
    also = {
        a.also[0]: a.also[1] * numbers[f"{name}.{a.name}"].value
        for name, many in additions.items() for a in many if a.also and f"{name}.{a.name}" in numbers
    }  # fmt: skip
    return frozenset(a.replaces for many in additions.values() for a in many if a.replaces), also


def _refitted(name: str, value: float, numbers: Mapping[str, Estimate], specimen: Specimen) -> float:
    """A prescribed term's coefficient as refitted; as it was where it was held."""
    for key, factor in _keys(name, specimen):
        if key in numbers:
            return numbers[key].value / factor
    return value


def _how_many(name: str, numbers: Mapping[str, Estimate]) -> int:
    count = 1
    while any(key.startswith(f"{name}#{count + 1}.") for key in numbers):
        count += 1
    return count


def _own_name(law: str) -> str:
    """What a suspect calls the coefficient of the law that it adds: the unknown that stands in its slot."""
    term = find(law)
    slot = term.slots.get(term.coefficient.name, "")
    unknowns = (a for s in all_suspects() if s.name == law for a in s.additions(UNIT, 1.0))
    return next((a.name for a in unknowns if a.slot == slot), term.coefficient.name)


def _added(name: str, given: Mapping[str, float], specimen: Specimen) -> tuple[Any, float]:
    """A named law as a term with its coefficient."""
    term = find(name)
    leading = term.coefficient.name
    values = dict(given)
    said = term.published
    if said is not None and leading not in values and said.ratio in values:
        values[leading] = values.pop(said.ratio) * getattr(specimen, said.per)
    if (own := _own_name(name)) in values:
        values[leading] = values[own]
    lacking = next((name for name, usual in term.inner.items() if name not in values and usual), "")
    if leading not in values or lacking:
        has = ", ".join(given) or "none"
        raise IdentificationError(
            f"{name} has no {lacking or leading} among its numbers ({has}); take .parameters instead"
        )
    inner = {p.name: values[p.name] for p in term.parameters[1:] if p.name in values}
    return find(name, **{**term.inner, **inner}), values[leading]
