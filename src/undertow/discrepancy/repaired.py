"""The repaired equation: the prescribed one with a verdict's numbers and the laws that it names.

Belongs here: putting those numbers and laws into the equation, and their errors. Does not belong here: finding them
(judge.py), writing the equation (equation/notation.py).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from typing import Any

from undertow.comparison.suspect import UNIT
from undertow.comparison.suspects import all_suspects
from undertow.discrepancy.verdict import Verdict
from undertow.equation.equation import Equation
from undertow.equation.registry import catalogue, find, row
from undertow.equation.term import Term
from undertow.errors import IdentificationError
from undertow.likelihood.fit import Specimen
from undertow.likelihood.scale import contract_name
from undertow.quantities import Estimate


def repaired_equation(prescribed: Equation, verdict: Verdict, specimen: Specimen) -> Equation:
    """The prescribed equation with a verdict's numbers and the laws that these are numbers of. What has a clock of its
    own, or is no law of the body's motion (a sensor, a release), is left out beside one that is.

    Raises IdentificationError where none of them is a law of motion, or lacks a number.
    """
    laws = _laws(verdict)
    if laws and not any(_is_of_motion(name) for name in laws):
        raise IdentificationError(
            f"{laws[0]} is no law of the body's motion with the same numbers in all trials; the repaired equation is "
            "the prescribed one with that corrected: take .prescribed and .parameters"
        )
    return refitted_equation(prescribed, verdict, specimen)


def refitted_equation(prescribed: Equation, verdict: Verdict, specimen: Specimen) -> Equation:
    """As `repaired_equation`; where none of the laws is one of motion the prescribed one with a verdict's numbers."""
    if verdict.augmented is None:
        return prescribed
    numbers = verdict.augmented.parameters
    terms, values = [], []
    mass = prescribed.mass_kg
    if "total_mass_kg" in numbers and not any(t.is_inertia for t in prescribed.terms):
        mass = numbers["total_mass_kg"].value
    laws = _laws(verdict)
    replaced, given_back = _taken(laws, numbers)
    taken_along, moved = _moved(laws), {}
    for term, value in zip(prescribed.terms, prescribed.coefficients, strict=True):
        slot = term.slots.get(term.coefficient.name, "")
        refitted = _refitted(term.name, value, numbers, specimen) + given_back.get(slot, 0.0)
        if slot in taken_along:
            moved[slot] = refitted
        elif slot not in replaced:
            terms.append(_with_inner(term, refitted, numbers))
            values.append(refitted)
    found = [one for name in laws for one in _added_of(name, numbers, specimen, moved)]
    terms += [term for term, _ in found]
    values += [value for _, value in found]
    return Equation(tuple(terms), tuple(values), mass, prescribed.rest_m)


def _is_of_motion(name: str) -> bool:
    """Whether a law is a force of the body's own motion: one with the same numbers in all trials."""
    law = row(name)
    return bool(_moved((name,))) if law is None else not law.own_clock


def _laws(verdict: Verdict) -> tuple[str, ...]:
    """What a verdict's numbers are of, each once: what it names, and what is described beside what nobody knows."""
    numbers = {} if verdict.augmented is None else verdict.augmented.parameters
    described = (name.partition(".")[0].partition("#")[0] for name in numbers if "." in name)
    return tuple(dict.fromkeys((*named_laws(verdict), *described)))


def _added_of(
    name: str, numbers: Mapping[str, Estimate], specimen: Specimen, moved: Mapping[str, float]
) -> Iterator[tuple[Any, float]]:
    """A law that was added as terms with their coefficients, as often as it was: none where it is no law of motion.
    ``moved`` is what the prescribed equation had in slots from which the law takes it."""
    law = row(name)
    if law is None and (new := _moved((name,))):
        yield _of_what_moved(name, new, numbers, moved)
    if law is None or law.own_clock:
        return
    for at in range(_how_many(name, numbers)):
        prefix = f"{name}#{at + 1}." if at else f"{name}."
        given = {key.removeprefix(prefix): e.value for key, e in numbers.items() if key.startswith(prefix)}
        yield _added(name, given, specimen)


def _moved(laws: Collection[str]) -> dict[str, str]:
    """Slots of the integrator whose content these laws take to another: bristles yield where friction slid."""
    additions = (a for s in all_suspects() if s.name in laws for a in s.additions(UNIT, 1.0))
    return dict(a.moves for a in additions if a.moves is not None)


def _of_what_moved(
    name: str, new: Mapping[str, str], numbers: Mapping[str, Estimate], moved: Mapping[str, float]
) -> tuple[Any, float]:
    """The registry's law with the slots of a suspect that takes what the equation has to another one."""
    own = _own_slots(name)
    slots = {slot: numbers[key].value for slot, key in own.items() if key in numbers}
    slots |= {new[old]: value for old, value in moved.items()}
    law = next((one for one in catalogue() if slots and set(one.slots.values()) == set(slots)), None)
    if law is None:
        raise IdentificationError(f"{name} has no number for each of {', '.join((*own, *new.values()))}")
    return find(law.name, **law.of_slots(slots)), slots[law.slots[law.parameters[0].name]]


def _own_slots(name: str) -> dict[str, str]:
    """A suspect's slots in the integrator, and what its numbers there are called."""
    return {a.slot: f"{name}.{a.name}" for s in all_suspects() if s.name == name for a in s.additions(UNIT, 1.0)}


def _errors_of_what_moved(
    name: str, new: Mapping[str, str], numbers: Mapping[str, Estimate], moved: Mapping[str, Estimate]
) -> dict[str, float]:
    """Standard errors of such a law's numbers, by its name and "law.parameter": what each moves by with an error of
    what it is made of."""
    values = {slot: one.value for slot, one in moved.items()}
    law, leading = _of_what_moved(name, new, numbers, values)
    found = dict.fromkeys((p.name for p in law.parameters), 0.0)
    keys = [key for key in _own_slots(name).values() if key in numbers]
    own = [_of_what_moved(name, new, {**numbers, key: _higher(numbers[key])}, values) for key in keys]
    had = [_of_what_moved(name, new, numbers, {**values, slot: _higher(one).value}) for slot, one in moved.items()]
    for other, value in (*own, *had):
        for at, p in enumerate(law.parameters):
            by = getattr(other, p.name) - getattr(law, p.name) if at else value - leading
            found[p.name] = math.hypot(found[p.name], by)
    first, *rest = law.parameters
    return {law.name: found[first.name]} | {f"{law.name}.{p.name}": found[p.name] for p in rest}


def _higher(one: Estimate) -> Estimate:
    """A number one standard error higher."""
    return replace(one, value=one.value + one.total_stderr)


def _with_inner(term: Term, value: float, numbers: Mapping[str, Estimate]) -> Term:
    """A prescribed term with its inner numbers as refitted; with those that it had where they are none."""
    inner = {p.name: numbers[key].value for p in term.parameters[1:] if (key := f"{term.name}_{p.name}") in numbers}
    leading = term.slots.get(term.coefficient.name, "")
    for slot, p in term.slot_parameters.items():
        key = next((k for k in (f"{term.name}_{p.name}", f"{term.name}_{p.name}_per_mass") if k in numbers), "")
        inner |= term.of_slots({leading: value, slot: numbers[key].value}) if key else {}
    return replace(term, **inner) if inner else term


def named_laws(verdict: Verdict) -> tuple[str, ...]:
    """What a verdict names, each once, without "unknown"."""
    return tuple(name for name in dict.fromkeys(verdict.verdict) if name != "unknown")


def repaired_errors(
    prescribed: Equation, errors: Mapping[str, float], verdict: Verdict, specimen: Specimen
) -> dict[str, float]:
    """Standard errors of the repaired equation's coefficients by term name ("mass": total mass), of inner numbers by
    "term.parameter", as `errors` are of the prescribed one. Numbers that were held keep theirs, also where a law of the
    prescribed equation is named once more; a law that is named more than once has none."""
    if verdict.augmented is None:
        return dict(errors)
    numbers = verdict.augmented.parameters
    out = dict(errors) | {name: one.total_stderr for name, one in numbers.items() if "." in name}
    inner = {f"{t.name}.{p.name}": f"{t.name}_{p.name}" for t in prescribed.terms for p in t.parameters[1:]}
    out |= {name: numbers[key].total_stderr for name, key in inner.items() if key in numbers}
    prescribed_names = {term.name for term in prescribed.terms}
    _, given_back = _taken(_laws(verdict), {name: replace(e, value=e.total_stderr) for name, e in numbers.items()})
    for term in prescribed.terms:
        for key, factor in _keys(term.name, specimen):
            if key in numbers:
                also = given_back.get(term.slots.get(term.coefficient.name, ""), 0.0)
                out[term.name] = math.hypot(numbers[key].total_stderr / factor, also)
                break
    if "total_mass_kg" in numbers and not any(t.is_inertia for t in prescribed.terms):
        out["mass"] = numbers["total_mass_kg"].total_stderr
    had = {}
    for term, value in zip(prescribed.terms, prescribed.coefficients, strict=True):
        if term.name in out:
            refitted = _refitted(term.name, value, numbers, specimen)
            had[term.slots.get(term.coefficient.name, "")] = Estimate(refitted, out[term.name])
    for name in _laws(verdict):
        new = _moved((name,)) if row(name) is None else {}
        if new and set(new) <= set(had):
            out |= _errors_of_what_moved(name, new, numbers, {slot: had[slot] for slot in new})
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
    for known in (specimen, Specimen(rotation=specimen.rotation)):
        key, _, factor = contract_name(term, known)
        yield key, factor
        yield f"{key}_per_mass", factor


def _taken(laws: Collection[str], numbers: Mapping[str, Estimate]) -> tuple[frozenset[str], Mapping[str, float]]:
    """Slots of the integrator whose coefficient these laws stand in place of, and what they add to others (a sine
    instead of a line takes from the line)."""
    additions = {s.name: s.additions(UNIT, 1.0) for s in reversed(all_suspects()) if s.name in laws}
    also = {
        slot: factor * numbers[f"{name}.{a.name}"].value
        for name, many in additions.items() for a in many for slot, factor in a.also if f"{name}.{a.name}" in numbers
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
