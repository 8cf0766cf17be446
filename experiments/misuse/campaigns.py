"""The campaigns that mistakes are made in: a draft of recordings, index and config, and its files on disk.

Each base campaign is in order as it stands. A mistake edits the draft before it is written; what a recording holds
belongs to `rigs`, the mistakes to `mistakes_*`.
"""

from __future__ import annotations

import gzip
import io
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pandas as pd
from ruamel.yaml import YAML

from experiments.misuse.rigs import RIGS, SCATTER, Release, Rig, record

Damage = Callable[[bytes], bytes]

FEW_SUSPECTS = ("linear_damping", "hidden_resonator")
"""Tried where the mistake does not concern the search, so that a case costs seconds."""

TERMS = ("stiffness", "viscous_damping", "coulomb_friction", "added_mass", "quadratic_drag")


@dataclass
class Draft:
    """A campaign before it is written, open to every edit.

    Attributes
    ----------
    config : the config's keys.
    recordings : file name -> table, a row a sample; columns t, x, v, a, lc1, lc2 in SI units.
    index : file name -> its row's other columns, in the order of the index.
    index_rows : more rows of the index (a file named twice).
    separator, decimal : how the index is written.
    damage : file name -> what happens to its bytes on the way to the laboratory's disk.
    words : more words of the command; {folder} is the campaign's folder.
    """

    config: dict[str, Any]
    recordings: dict[str, pd.DataFrame]
    index: dict[str, dict[str, Any]]
    index_rows: list[dict[str, Any]] = field(default_factory=list)
    separator: str = ","
    decimal: str = "."
    damage: dict[str, Damage] = field(default_factory=dict)
    words: list[str] = field(default_factory=list)

    def set(self, path: str, value: object) -> None:
        """Set a key of the config: `trials.hold_out`; maps on the way are made."""
        *way, last = path.split(".")
        place = self.config
        for key in way:
            place = place.setdefault(key, {})
        place[last] = value

    def remove(self, path: str) -> None:
        """Remove a key of the config."""
        *way, last = path.split(".")
        place = self.config
        for key in way:
            place = place[key]
        del place[last]

    def channel(self, quantity: str, **keys: object) -> None:
        """Change keys of one channel of the config: unit, sign, column."""
        self.config["recordings"]["channels"][quantity].update(keys)

    def files(self, **conditions: object) -> list[str]:
        """The files whose index row has these conditions."""
        return [file for file, row in self.index.items() if conditions.items() <= row.items()]

    def drop(self, files: Iterable[str]) -> None:
        """Take files out of the campaign and its index."""
        for file in list(files):
            del self.recordings[file], self.index[file]

    def rename(self, old: str, new: str) -> None:
        """Give a recording another file name; the index follows, in its order."""
        self.recordings[new] = self.recordings.pop(old)
        self.index = {new if file == old else file: row for file, row in self.index.items()}

    def change(self, files: Iterable[str], edit: Callable[[pd.DataFrame], pd.DataFrame | None]) -> None:
        """Edit recordings, in place or by what `edit` returns."""
        for file in files:
            table = self.recordings[file]
            edited = edit(table)
            self.recordings[file] = table if edited is None else edited


def write(draft: Draft, folder: Path) -> Path:
    """Write recordings, campaign.csv and config.yaml to `folder`; returns the config's path."""
    folder.mkdir(parents=True, exist_ok=True)
    for file, table in draft.recordings.items():
        raw = table.to_csv(index=False, float_format="%.9g").encode()
        packed = gzip.compress(raw, mtime=0) if file.endswith(".gz") else raw
        (folder / file).write_bytes(draft.damage.get(file, lambda whole: whole)(packed))
    rows = [{"file": file} | row for file, row in draft.index.items()] + draft.index_rows
    text = pd.DataFrame(rows).to_csv(index=False, sep=draft.separator, decimal=draft.decimal)
    (folder / "campaign.csv").write_text(text)
    config = folder / "config.yaml"
    stream = io.StringIO()
    yaml = YAML(typ="safe", pure=True)
    yaml.sort_base_mapping_type_on_output = False
    yaml.default_flow_style = None  # short maps on one line
    yaml.width = 120
    yaml.dump(draft.config, stream)
    config.write_text(stream.getvalue())
    return config


def bridge(hardening_per_m2: float = 0.0, c_factor_wet: float = 1.0) -> Draft:
    """The bridge section on its long spring: t01 to t03 in air, t04 to t06 at 2.36 m, t05 the largest there."""
    releases = _plan("bridge", {"long": {1.63: 3, 2.36: 3}}, c_factor_wet, hardening_per_m2)
    return _draft("bridge", releases)


def two_levels() -> Draft:
    """The bridge section on its long spring: two trials each in air, at 2.29 m and at 2.36 m."""
    return _draft("bridge", _plan("bridge", {"long": {1.63: 2, 2.29: 2, 2.36: 2}}))


def two_springs() -> Draft:
    """The bridge section on both springs: two trials in air and two at 2.36 m each."""
    return _draft("bridge", _plan("bridge", {s: {1.63: 2, 2.36: 2} for s in ("long", "short")}))


def fast() -> Draft:
    """The light body of 3.4 Hz, held for 0.13 s: three trials in air, three in water."""
    return _draft("fast", _plan("fast", {"long": {0.5: 3, 1.2: 3}}))


def slow_sampling() -> Draft:
    """The light body of 3.4 Hz for 14 s at five samples a second."""
    releases = _plan("fast", {"long": {0.5: 3, 1.2: 3}})
    return _draft("fast", [replace(release, rate_hz=5.0, motion_s=14.0) for release in releases])


def pendulum() -> Draft:
    """Three free swings of the torsion pendulum: an angle and a rate gyro, no water."""
    return _rotation("pendulum", _plan("pendulum", {"long": {0.0: 3}}), ["stiffness", "viscous_damping"])


def roll_decay(hardening_per_rad2: float = 0.0) -> Draft:
    """One roll decay of the model hull: an angle alone, quadratic damping in the equation."""
    releases = _plan("hull", {"long": {0.0: 1}}, hardening_per_m2=hardening_per_rad2)
    draft = _rotation("hull", releases, ["stiffness", "viscous_damping", "quadratic_drag"])
    draft.remove("recordings.channels.velocity")
    return draft


def _plan(
    rig: str, trials: Mapping[str, Mapping[float, int]], c_factor_wet: float = 1.0, hardening_per_m2: float = 0.0
) -> list[Release]:
    """So many releases by spring and depth; what is planted is planted in water, or in all trials without dry ones."""
    releases: list[Release] = []
    dry = RIGS[rig].dry_depth_m if any(len(depths) > 1 for depths in trials.values()) else None
    for spring, depths in trials.items():
        for depth, count in depths.items():
            planted = {} if depth == dry else {"c_factor": c_factor_wet, "hardening_per_m2": hardening_per_m2}
            for x0 in RIGS[rig].releases_m[spring][:count]:
                releases.append(Release(spring, depth, x0, seed=len(releases), **planted))
    return releases


def _draft(rig_name: str, releases: list[Release]) -> Draft:
    """A translation rig's campaign: displacement, acceleration, two load cells; water level and spring in the index."""
    rig = RIGS[rig_name]
    recordings, index = _recorded(rig_name, releases)
    depths = {release.depth_m for release in releases}
    config = {
        "name": rig_name,
        "recordings": {
            "index": "campaign.csv",
            "channels": {
                "time": {"column": "t", "unit": "s"},
                "displacement": {"column": "x", "unit": "m"},
                "acceleration": {"column": "a", "unit": "m/s^2"},
                "spring_force": {"columns": ["lc1", "lc2"], "unit": "N"},
            },
        },
        "trials": {"group_by": ["spring", "water_depth_m"], "dry": {"water_depth_m": rig.dry_depth_m}},
        "specimen": _specimen(rig, depths - {rig.dry_depth_m}),
        "equation": {"terms": list(TERMS)},
        "identify": ["output_error"],
        "discrepancy": {"suspects": list(FEW_SUSPECTS)},
    }
    return Draft(config, recordings, index)


def _specimen(rig: Rig, wet: set[float]) -> dict[str, Any]:
    """What the laboratory knows of a translation rig."""
    return {
        "mass_kg": rig.mass_kg,
        "area_m2": {"by": "water_depth_m"} | {depth: rig.levels[depth].area_m2 for depth in sorted(wet)},
        "submerged_volume_m3": {"by": "water_depth_m"}
        | {depth: rig.levels[depth].volume_m3 for depth in sorted(wet)},
        "scatter": dict(SCATTER),
    }


def _rotation(rig_name: str, releases: list[Release], terms: list[str]) -> Draft:
    """A rotation rig's campaign: an angle and its rate, nothing known of the specimen but the scatter."""
    recordings, index = _recorded(rig_name, releases)
    config = {
        "name": rig_name,
        "recordings": {
            "index": "campaign.csv",
            "channels": {
                "time": {"column": "t", "unit": "s"},
                "displacement": {"column": "x", "unit": "rad"},
                "velocity": {"column": "v", "unit": "rad/s"},
            },
        },
        "trials": {"dry": None},
        "specimen": {"scatter": {"k": SCATTER["k"], "c": SCATTER["c"]}},
        "equation": {"terms": terms, "coordinate": "rotation"},
        "identify": ["output_error"],
        "discrepancy": {"suspects": list(FEW_SUSPECTS)},
    }
    return Draft(config, recordings, index)


def _recorded(rig_name: str, releases: list[Release]) -> tuple[dict[str, pd.DataFrame], dict[str, dict[str, Any]]]:
    """Recordings t01.csv, t02.csv, ... and the index's rows."""
    files = [f"t{number:02d}.csv" for number in range(1, len(releases) + 1)]
    recordings = {file: record(rig_name, release).copy() for file, release in zip(files, releases, strict=True)}
    rows = [{"spring": release.spring, "water_depth_m": release.depth_m} for release in releases]
    return recordings, dict(zip(files, rows, strict=True))
