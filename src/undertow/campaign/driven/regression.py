"""SINDy beside output error in a driven campaign: rows of trials.csv and levels.csv, and of the page.

Belongs here: these, for every trial. Does not belong here: the estimate (methods/driven_regression.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from undertow.conditioning.driven import DrivenTrial
from undertow.errors import IdentificationError
from undertow.methods.driven import DrivenFit, free_run
from undertow.methods.driven_begin import START_SAMPLES
from undertow.methods.driven_regression import by_regression
from undertow.quantities import OK, Estimate
from undertow.report.wording import parameter_words


@dataclass(frozen=True)
class Regressed:
    """One trial's numbers by regression (none where it could not be made), how much of the motion a free run with them
    misses, and ``ok`` or the reason."""

    trial: str
    numbers: Mapping[str, Estimate]
    nrmse: float
    outcome: str

    def row(self) -> dict[str, Any]:
        """The trial's row of trials.csv."""
        numbers: dict[str, Any] = {}
        for name, one in self.numbers.items():
            numbers |= {name: one.value, f"{name}_stderr": one.stderr}
        missed = {"nrmse": self.nrmse} if math.isfinite(self.nrmse) else {}
        return {"file": self.trial, "method": "sindy", **numbers, **missed, "outcome": self.outcome}


def regressions(trials: Sequence[DrivenTrial], given: DrivenFit) -> tuple[Regressed, ...]:
    """Every trial by regression, with the laws of the ``given`` equation."""
    return tuple(_one(trial, given) for trial in trials)


def _one(trial: DrivenTrial, given: DrivenFit) -> Regressed:
    numbers: Mapping[str, Estimate] = {}
    try:
        numbers = by_regression(trial, given)
        values = [numbers[n].value if n in numbers else v for n, v in zip(given.names, given.values, strict=True)]
        run = free_run(trial, replace(given, values=np.array(values)), START_SAMPLES)
    except IdentificationError as reason:
        return Regressed(trial.name, numbers, math.nan, str(reason))
    measured = trial.outputs[trial.main]
    return Regressed(trial.name, numbers, float(np.sqrt(np.mean((run - measured) ** 2)) / np.std(measured)), OK)


def beside_output_error(found: Sequence[Regressed], given: DrivenFit) -> list[tuple[str, ...]]:
    """Rows of the page, the first the header; empty where no regression was made."""
    numbers, units = given.numbers, given.laws.units
    errors = dict(zip(given.names, np.sqrt(np.maximum(np.diag(given.covariance), 0.0)).tolist(), strict=True))
    rows: list[tuple[str, ...]] = []
    for one in found:
        rows += [
            (one.trial, parameter_words(name), str(Estimate(numbers[name], errors[name], unit=units[name])), str(value))
            for name, value in one.numbers.items()
        ]
        if one.outcome != OK:
            rows.append((one.trial, "", "", one.outcome))
    return [("trial", "number", "output error", "SINDy"), *rows] if rows else []
