"""What a driven trial may miss although nothing is missing: the sensor's noise, and what trials differ by.

Belongs here: which of the two ways to know the second a campaign has, rows for tables and page. Does not belong here:
either way (methods/driven_repeatability.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from undertow.campaign.config import RunConfig
from undertow.conditioning.driven import DrivenTrial, white_noise
from undertow.methods.driven import DrivenFit, free_run
from undertow.methods.driven_begin import START_SAMPLES
from undertow.methods.driven_repeatability import repeatability_by_repeats, repeatability_by_scatter, scattered

UNKNOWN = (
    "nobody knows by how much trials of this body differ: specimen.scatter says nothing of its laws, and no two trials "
    "had the same input"
)


@dataclass(frozen=True)
class Floors:
    """By trial: nrmse, the sensor's floor, repeatability (only where it is known); ``because`` says where from, or why
    it is not known."""

    nrmse: Mapping[str, float]
    sensor: Mapping[str, float]
    repeatability: Mapping[str, float]
    because: str

    @property
    def worst_repeatability(self) -> float | None:
        """The largest of all trials; None where none is known."""
        return max(self.repeatability.values(), default=None)

    def scores(self, trial: str) -> dict[str, Any]:
        """Both floors of a trial for trials.csv; what is not known is left out."""
        known = {"repeatability_nrmse": self.repeatability[trial]} if trial in self.repeatability else {}
        return {"sensor_floor_nrmse": self.sensor[trial], **known}

    def rows(self) -> list[dict[str, Any]]:
        """Rows of mismatch.csv; ``missing`` is empty where repeatability is not known."""
        return [
            {"file": name, "nrmse": nrmse, "sensor_floor_nrmse": self.sensor[name],
             "repeatability_nrmse": self.repeatability.get(name, ""),
             "missing": nrmse > self.repeatability[name] if name in self.repeatability else ""}
            for name, nrmse in self.nrmse.items()
        ]  # fmt: skip

    def table(self) -> list[tuple[str, ...]]:
        """Rows of the page, the first the header."""
        rows = [
            (name, f"{100.0 * nrmse:.3g} %", f"{100.0 * self.sensor[name]:.3g} %",
             f"{100.0 * self.repeatability[name]:.3g} %" if name in self.repeatability else "not known", self.because)
            for name, nrmse in self.nrmse.items()
        ]  # fmt: skip
        return [("trial", "missed of the motion", "by the sensor's noise alone", "between trials", "known from"), *rows]


def sensor_noise(trial: DrivenTrial, fitted: DrivenFit) -> float:
    """White noise of the main output, 1 sigma: of the record, or of what the free run leaves of it where that is less.

    A motion with few samples a cycle looks like noise in the record; what is left of it does not.
    """
    left = trial.outputs[trial.main] - free_run(trial, fitted, START_SAMPLES)
    return min(trial.noise()[trial.main], white_noise(left))


def floors_of(
    config: RunConfig, trials: Sequence[DrivenTrial], unseen: Sequence[DrivenTrial], fitted: DrivenFit
) -> Floors:
    """Both floors of every trial that was fitted: repeatability by the stated scatter, else by trials of one input,
    held-out ones too."""
    size = {t.name: float(np.std(t.outputs[t.main])) for t in trials}
    nrmse = {t.name: fitted.rms[t.name] / size[t.name] for t in trials}
    sensor = {t.name: sensor_noise(t, fitted) / size[t.name] for t in trials}
    stated = {} if config.specimen.scatter is None else dict(config.specimen.scatter)
    if scattered(fitted, stated):
        drawn = {t.name: repeatability_by_scatter(t, fitted, stated, sensor[t.name], config.seed) for t in trials}
        return Floors(nrmse, sensor, drawn, "specimen.scatter")
    every = repeatability_by_repeats([*trials, *unseen])
    seen = {name: value for name, value in every.items() if name in nrmse}
    return Floors(nrmse, sensor, seen, "trials of the same input" if seen else UNKNOWN)
