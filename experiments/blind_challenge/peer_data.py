"""A laboratory's folder read plainly for the peers: trials in SI, groups, and which trials are held out."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
from ruamel.yaml import YAML

UNITS = {
    "m": 1.0,
    "mm": 1e-3,
    "cm": 1e-2,
    "rad": 1.0,
    "deg": np.pi / 180.0,
    "m/s^2": 1.0,
    "g": 9.81,
    "rad/s^2": 1.0,
    "N": 1.0,
    "kN": 1e3,
}


@dataclass(frozen=True)
class Record:
    """Displacement from the release on: time (s, 0 = release), x and its hold (m), conditions."""

    file: str
    time: np.ndarray
    x: np.ndarray
    hold: float
    conditions: dict[str, object]


@dataclass(frozen=True)
class Group:
    """Trials of one spring and level, those held out, and whether it is dry."""

    name: dict[str, object]
    training: list[Record]
    held_out: list[Record]
    dry: bool


def _released(time: np.ndarray, x: np.ndarray) -> tuple[int, float]:
    """Sample of the release and the held displacement: the last sample that is still within the hold's noise."""
    first = x[: max(5, x.size // 200)]
    hold, spread = float(np.median(first)), float(np.std(first)) + 1e-12
    out = np.flatnonzero(np.abs(x - hold) > 6.0 * spread + 0.01 * np.ptp(x))
    return max(int(out[0]) - 1, 0) if out.size else 0, hold


def _record(folder: Path, row: dict[str, object], channel: dict[str, object], time: str) -> Record:
    table = pd.read_csv(folder / str(row["file"]))
    t = table[time].to_numpy(float)
    x = table[channel["column"]].to_numpy(float) * UNITS[str(channel["unit"])] * float(channel.get("sign", 1))  # type: ignore[arg-type]
    step = float(np.median(np.diff(t)))
    even = np.arange(t[0], t[-1] + 0.5 * step, step)
    x = np.interp(even, t, x)
    start, hold = _released(even, x)
    rest = float(np.mean(x[-max(5, x.size // 20) :]))
    conditions = {k: v for k, v in row.items() if k != "file"}
    return Record(Path(str(row["file"])).name, even[start:] - even[start], x[start:] - rest, hold - rest, conditions)


def held_out(releases: list[float]) -> set[int]:
    """Which trials are held out: by release, every third from the second on, never the smallest or the largest."""
    order = np.argsort(releases)
    if len(order) < 3:
        return set()
    return {int(order[i]) for i in range(1, len(order) - 1, 3)}


def laboratory(folder: Path) -> tuple[dict[str, object], list[Group]]:
    """Config and groups of a laboratory's folder."""
    config = YAML(typ="safe").load((folder / "config.yaml").read_text(encoding="utf-8"))
    channels, trials = config["recordings"]["channels"], config["trials"]
    index = pd.read_csv(folder / config["recordings"]["index"])
    records = [
        _record(folder, row, channels["displacement"], channels["time"]["column"]) for row in index.to_dict("records")
    ]
    groups: dict[tuple[object, ...], list[Record]] = {}
    for record in records:
        groups.setdefault(tuple(record.conditions[c] for c in trials["group_by"]), []).append(record)
    out = []
    for key, members in groups.items():
        name = dict(zip(trials["group_by"], key, strict=True))
        away = held_out([abs(r.hold) for r in members])
        dry = bool(trials.get("dry")) and all(members[0].conditions[k] == v for k, v in trials["dry"].items())
        out.append(
            Group(
                name,
                [r for i, r in enumerate(members) if i not in away],
                [r for i, r in enumerate(members) if i in away],
                dry,
            )
        )
    return config, out
