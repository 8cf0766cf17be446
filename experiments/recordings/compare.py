"""A published number beside ours: value, standard error, difference in per cent, limit met or not.

Belongs here: the formulas that make ours comparable. Does not belong here: the numbers (published.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from experiments.recordings.published import Reference

_MILLI = 1e3


def compare(references: Sequence[Reference], studies: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """One row a reference, in their order, ready for JSON.

    LookupError where no study, group or trial fits a reference, so that none is dropped silently.
    """
    return [_row(reference, *_find(reference, studies)) for reference in references]


def _find(
    reference: Reference, studies: Sequence[Mapping[str, Any]]
) -> tuple[Mapping[str, Any], Mapping[str, Any]]:
    """The methods' results (group's or trial's) and the trial whose scores stand for them."""
    for study in studies:
        if study["study"] != reference.study:
            continue
        for group in study["groups"]:
            if all(group["group"].get(key) == value for key, value in reference.group.items()):
                if not reference.trial:
                    return group["methods"], group["trials"][0]
                for trial in group["trials"]:
                    if reference.trial in trial["trial"]:
                        return trial["methods"], trial
    raise LookupError(f"no result for {reference.study}, {dict(reference.group)}, trial {reference.trial!r}")


def _row(reference: Reference, methods: Mapping[str, Any], trial: Mapping[str, Any]) -> dict[str, Any]:
    ours, stderr = apply(reference.formula, methods["output_error"]["parameters"], trial)
    sindy, sindy_stderr = apply(reference.formula, methods.get("sindy", {}).get("parameters", {}), {})
    difference = 100.0 * (ours - reference.value) / abs(reference.value)
    limit = reference.limit_percent if math.isfinite(reference.limit_percent) else None
    return {
        "study": reference.study,
        "group": dict(reference.group),
        "trial": reference.trial,
        "quantity": reference.quantity,
        "unit": reference.unit,
        "published": reference.value,
        "source": reference.source,
        "ours": short(ours),
        "stderr": short(stderr),
        "sindy": short(sindy),
        "sindy_stderr": short(sindy_stderr),
        "difference_percent": round(difference, 3) if math.isfinite(difference) else None,
        "limit_percent": limit,
        "met": None if limit is None else bool(abs(difference) <= limit),
    }


def short(value: float) -> float | None:
    """Six significant digits; None where there is no number."""
    return float(f"{value:.6g}") if math.isfinite(value) else None


def apply(formula: str, parameters: Mapping[str, Any], trial: Mapping[str, Any]) -> tuple[float, float]:
    """Value and standard error of a formula on a method's parameters and a trial's scores; nan where it has none.

    A parameter's name; "ratio a/b"; "period" 2 pi / sqrt(k); "decrement" c pi / sqrt(k), the linear oscillator's;
    "frequency_of_mass" sqrt(k / M) / 2 pi with the configured k; "rms", "rms_milli" (in thousandths), "r2" of the
    group's equation, "own_rms" of the trial's own.
    """
    if formula in ("rms", "rms_milli", "own_rms", "r2"):
        value = trial.get(formula.removesuffix("_milli"))
        scale = _MILLI if formula.endswith("_milli") else 1.0
        return (math.nan if value is None else value * scale), math.nan
    names = formula.removeprefix("ratio ").split("/")
    first, error = _parameter(parameters, names[0])
    if formula.startswith("ratio "):
        second, other = _parameter(parameters, names[1])
        value = first / second
        return value, abs(value) * math.hypot(error / first, other / second)
    k, k_error = _parameter(parameters, "k_N_per_m_per_mass")
    if formula == "period":
        value = 2.0 * math.pi / math.sqrt(k) if k > 0.0 else math.nan
        return value, 0.5 * value * k_error / k
    if formula == "decrement":
        c, c_error = _parameter(parameters, "c_Ns_per_m_per_mass")
        value = math.pi * c / math.sqrt(k) if k > 0.0 else math.nan
        return value, value * math.hypot(c_error / c, 0.5 * k_error / k)
    if formula == "frequency_of_mass":
        mass, mass_error = _parameter(parameters, "total_mass_kg")
        value = math.sqrt(CONFIGURED_DISC_STIFFNESS_N_PER_M / mass) / (2.0 * math.pi)
        return value, 0.5 * value * mass_error / mass
    return first, error


CONFIGURED_DISC_STIFFNESS_N_PER_M = 14.91945
"""In the spring-disc recordings' file names; the config takes it from there."""


def _parameter(parameters: Mapping[str, Any], name: str) -> tuple[float, float]:
    found = parameters.get(name, {})
    value, error = found.get("value"), found.get("stderr")
    return math.nan if value is None else value, math.nan if error is None else error
