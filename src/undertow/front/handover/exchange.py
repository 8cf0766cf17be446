"""An equation as JSON, and back.

Belongs here: that format. Does not belong here: programs (programs.py).
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

from undertow.equation.equation import Equation
from undertow.equation.registry import find
from undertow.errors import UndertowError
from undertow.quantities import unit_in_rotation

FORMAT = "undertow equation"
VERSION = 1
"""Of the format; another one is refused."""


def json_text(equation: Equation, errors: Mapping[str, float], rotation: bool = False) -> str:
    """An equation with its standard errors by term name and "term.parameter"; numbers in full precision. In a
    ``rotation`` units are those of moments, inertias and radians."""
    terms = []
    for term, coefficient in zip(equation.terms, equation.coefficients, strict=True):
        numbers = {term.coefficient.name: coefficient, **term.inner}
        units = {p.name: unit_in_rotation(p.unit) if rotation else p.unit for p in term.parameters}
        parameters = {name: {"value": float(numbers[name]), "unit": unit} for name, unit in units.items()}
        known = {p.name: errors.get(f"{term.name}.{p.name}", math.nan) for p in term.parameters[1:]}
        known[term.coefficient.name] = errors.get(term.name, math.nan)
        for name, error in known.items():
            parameters[name] |= {"stderr": error} if math.isfinite(error) else {}
        terms.append({"name": term.name, "law": term.law, "parameters": parameters})
    data = {
        "format": FORMAT, "version": VERSION, "text": str(equation), "latex": equation.to_latex(),
        "mass_kg": equation.mass_kg, "total_mass_kg": equation.total_mass_kg, "rest_m": equation.rest_m,
        "terms": terms,
    }  # fmt: skip
    return json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def equation_from_json(text: str) -> Equation:
    """The equation that `json_text` wrote; UndertowError where the text is something else.

    >>> from undertow.equation.equation import equation_15
    >>> law = equation_15(10.0, 2.0, 1.0, 400.0, 3.0, 5.0)
    >>> equation_from_json(json_text(law, {})) == law
    True
    """
    if not isinstance(text, str | bytes):
        raise UndertowError(f"text is of type {type(text).__name__}; give what to_json() wrote, as path.read_text()")
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as error:
        raise UndertowError(f"the text is no JSON ({error}); write it with to_json()") from error
    if not isinstance(data, dict) or data.get("format") != FORMAT or data.get("version") != VERSION:
        kind = data.get("format") if isinstance(data, dict) else type(data).__name__
        raise UndertowError(f"the text is {kind!r}, not {FORMAT!r} of version {VERSION}; write it with to_json()")
    terms, coefficients = [], []
    try:
        for one in data["terms"]:
            values: dict[str, Any] = {name: p["value"] for name, p in one["parameters"].items()}
            leading = find(one["name"]).coefficient.name
            coefficients.append(values.pop(leading))
            terms.append(find(one["name"], **values))
        return Equation(tuple(terms), tuple(coefficients), data["mass_kg"], data["rest_m"])
    except (KeyError, TypeError, AttributeError) as error:
        said = f"the text is no whole {FORMAT} ({error} is wrong or lacking); write it with to_json()"
        raise UndertowError(said) from error
