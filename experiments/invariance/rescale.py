"""A campaign on disk written again for a body that is larger, slower or heavier: every number scales by its dimension.

Belongs here: which number scales how. Does not belong here: which campaigns and scales (studies.py), the comparison
(compare.py).
"""

from __future__ import annotations

import gzip
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from ruamel.yaml import YAML

CHANNELS: Mapping[str, tuple[float, float, float]] = {
    "time": (1.0, 0.0, 0.0),
    "displacement": (0.0, 1.0, 0.0),
    "velocity": (-1.0, 1.0, 0.0),
    "acceleration": (-2.0, 1.0, 0.0),
    "spring_force": (-2.0, 1.0, 1.0),
    "normal_force": (-2.0, 1.0, 1.0),
}
"""Powers of (time, length, mass) in each channel."""

SPECIMEN: Mapping[str, tuple[float, float, float]] = {
    "mass_kg": (0.0, 0.0, 1.0),
    "stiffness_N_per_m": (-2.0, 0.0, 1.0),
    "area_m2": (0.0, 2.0, 0.0),
    "water_density_kg_per_m3": (0.0, -3.0, 1.0),
    "gravity_m_per_s2": (-2.0, 1.0, 0.0),
    "submerged_volume_m3": (0.0, 3.0, 0.0),
}
"""Powers of (time, length, mass) in each entry of the specimen."""

DEFAULTS = {"water_density_kg_per_m3": 1000.0, "gravity_m_per_s2": 9.81}
"""Entries that a config has without saying so."""


@dataclass(frozen=True)
class Scale:
    """Factors of time, length and mass. A rotation's coordinate has no length: its ``length`` is 1."""

    time: float = 1.0
    length: float = 1.0
    mass: float = 1.0

    def factor(self, powers: tuple[float, float, float]) -> float:
        """By what a number of these powers is multiplied.

        >>> Scale(time=2.0, length=3.0).factor((-2.0, 1.0, 0.0))
        0.75
        """
        return float(self.time ** powers[0] * self.length ** powers[1] * self.mass ** powers[2])

    @property
    def label(self) -> str:
        """Name of the scale in a table."""
        return f"time x {self.time:g}, length x {self.length:g}, mass x {self.mass:g}"


def rescale(config: Path, folder: Path, scale: Scale) -> Path:
    """Write the campaign of ``config`` (a resolved config: index and CSV recordings) again into ``folder``.

    The rescaled recordings hold the same digits of noise and rounding: only the units of time, length and mass differ.
    Returns the path of the new config.
    """
    folder.mkdir(parents=True, exist_ok=True)
    said = YAML(typ="safe").load(config.read_text(encoding="utf-8"))
    recordings = said["recordings"]
    index = (config.parent / recordings["index"]).resolve()
    shutil.copy(index, folder / index.name)
    recordings["index"] = index.name
    factors = _columns(recordings["channels"], scale)
    for file in sorted({*index.parent.glob("*.csv"), *index.parent.glob("*.csv.gz")} - {index}):
        _write(file, folder / file.name, factors)
    said["specimen"] = _specimen(said.get("specimen", {}), scale, said.get("equation", {}).get("coordinate"))
    if isinstance(said.get("trials", {}).get("window"), dict):
        said["trials"]["window"] = {
            pattern: {name: scale.time * value for name, value in window.items()}
            for pattern, window in said["trials"]["window"].items()
        }
    new = folder / "config.yaml"
    with new.open("w", encoding="utf-8") as stream:
        YAML(typ="safe").dump(said, stream)
    return new


def _columns(channels: Mapping[str, Any], scale: Scale) -> dict[str, float]:
    """Factor of every mapped column."""
    factors = {}
    for name, one in channels.items():
        if isinstance(one, Mapping):
            for column in one.get("columns", [one.get("column")]):
                factors[column] = scale.factor(CHANNELS[name])
    return factors


def _write(file: Path, new: Path, factors: Mapping[str, float]) -> None:
    table = pd.read_csv(file)
    for column, factor in factors.items():
        table[column] = table[column].to_numpy(dtype=np.float64) * factor
    text = table.to_csv(index=False, float_format="%.17g")
    if new.suffix == ".gz":
        with gzip.open(new, "wt", encoding="utf-8", compresslevel=1) as stream:
            stream.write(text)
    else:
        new.write_text(text, encoding="utf-8")


def _specimen(said: Mapping[str, Any], scale: Scale, coordinate: str | None) -> dict[str, Any]:
    turning = coordinate == "rotation"
    out: dict[str, Any] = {}
    for name, value in {**DEFAULTS, **said}.items():
        powers = SPECIMEN.get(name)
        if name == "cell":
            out[name] = {key: _scaled(one, scale.length) for key, one in value.items()}
        elif powers is None or (turning and name in DEFAULTS):
            out[name] = value
        else:
            out[name] = _scaled(value, scale.factor(powers))
    return out


def _scaled(value: Any, factor: float) -> Any:
    if isinstance(value, Mapping):
        return {key: one if key == "by" else one * factor for key, one in value.items()}
    return value * factor
