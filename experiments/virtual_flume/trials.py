"""Releases of a campaign with the numbers that each has of its own.

Every draw comes from `default_rng([seed, trial, 0])`. Belongs here: which releases, and their scatter. Does not belong
here: what moves in them (campaign.py, nonlinear_campaign.py), what sensors make of it (sensors.py).
"""

from __future__ import annotations

import csv
import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from experiments.virtual_flume import section
from experiments.virtual_flume.structure import SPRINGS, STIFFNESS_SCATTER

INDEX = ("file", "spring", "water_depth_m", "x0_target_m")
LOAD_SHARE = 0.49  # of the spring force in load cell 1
RELEASE_SCATTER = 0.01  # relative, of x0 about its target
CLIP_SIGMA = 2.0  # draws of k, c and mu stay within


@dataclass(frozen=True)
class Trial:
    """One release and its own numbers; SI units, `clock_offset_s` is true minus stamped time."""

    file: str
    spring: str
    water_depth_m: float
    x0_target_m: float
    x0_m: float
    release_s: float
    clock_offset_s: float
    stiffness_N_per_m: float
    damping_Ns_per_m: float
    friction: float
    number: int


@dataclass(frozen=True)
class Plan:
    """A campaign by its name and seed: rate of its logger, water levels (the dry one is added), releases a spring."""

    name: str
    seed: int
    rate_hz: float
    wet_depths_m: tuple[float, ...]
    releases_m: Mapping[str, Sequence[float]]

    def trials(self) -> list[Trial]:
        """All of them, in the order of level, spring and amplitude."""
        rows = [
            (spring, depth, target)
            for depth in (section.DRY_DEPTH_M, *self.wet_depths_m)
            for spring in ("long", "short")
            for target in self.releases_m[spring]
        ]
        return [self._draw(i, *row) for i, row in enumerate(rows)]

    def _draw(self, number: int, spring: str, depth: float, target: float) -> Trial:
        rng = np.random.default_rng([self.seed, number, 0])
        nominal = SPRINGS[spring]
        return Trial(
            file="r" + hashlib.sha256(f"{self.name} {self.seed} {number}".encode()).hexdigest()[:4] + ".csv.gz",
            spring=spring,
            water_depth_m=depth,
            x0_target_m=target,
            x0_m=_scattered(rng, target, RELEASE_SCATTER),
            release_s=round(float(rng.uniform(0.5, 1.0)), 4),
            clock_offset_s=float(rng.uniform(-0.5, 0.5) / self.rate_hz),
            stiffness_N_per_m=_scattered(rng, nominal.stiffness, STIFFNESS_SCATTER),
            damping_Ns_per_m=_scattered(rng, nominal.damping, nominal.damping_scatter),
            friction=_scattered(rng, nominal.friction, nominal.friction_scatter),
            number=number,
        )


def _scattered(rng: np.random.Generator, mean: float, relative: float) -> float:
    return mean * (1.0 + relative * float(np.clip(rng.standard_normal(), -CLIP_SIGMA, CLIP_SIGMA)))


def write_index(folder: Path, trials: Sequence[Trial]) -> None:
    """campaign.csv: a line a trial, in the order of the files' names, which says nothing."""
    with (folder / "campaign.csv").open("w", newline="") as stream:
        index = csv.DictWriter(stream, INDEX, extrasaction="ignore", lineterminator="\n")
        index.writeheader()
        index.writerows(sorted((asdict(t) for t in trials), key=lambda row: row["file"]))


def rounded(value: object, digits: int) -> object:
    """Numbers to so many digits, through dictionaries and lists: enough to compare, few enough to read."""
    if isinstance(value, dict):
        return {k: rounded(v, digits) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [rounded(v, digits) for v in value]
    return float(f"{float(value):.{digits}g}") if isinstance(value, float | np.floating) else value
