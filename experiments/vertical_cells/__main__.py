"""Vertical load cells of the virtual flume, never fitted, against the modes that `undertow run` finds.

    python -m experiments vertical_cells            # runs configs/flume.yaml's search for resonators first (minutes)
    python -m experiments vertical_cells --run DIR  # takes the modes from a finished run folder

writes docs/vertical_cells.json and docs/vertical_cells.md.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from experiments.vertical_cells.cells import DATA, Comparison, Mode, compare
from undertow.campaign.config import load
from undertow.campaign.run import read_and_condition
from undertow.campaign.run.folder import run_to_folder
from undertow.conditioning.motion import Motion

ROOT = Path(__file__).resolve().parents[2]
CONFIG = ROOT / "configs" / "flume.yaml"
DOCS = ROOT / "docs"
SEARCH = ("identify=[output_error]", "discrepancy.suspects=[hidden_resonator]")
WANTED = 0.8
"""Correlation that was asked for."""


def modes(verdict: dict[str, Any]) -> dict[str, tuple[float, Mode]]:
    """Spring and depth -> depth (m) and mode, for every wet group whose verdict names one resonator or more (the
    strongest is taken)."""
    found = {}
    for group in verdict["groups"]:
        if "hidden_resonator" not in group["verdict"] or group["augmented"] is None:
            continue
        resonator = group["parameters"]["hidden_resonator"]
        first = resonator[0] if isinstance(resonator, list) else resonator
        rest = group["augmented"]["parameters"]
        depth = float(group["group"]["water_depth_m"])
        found[f"{group['group']['spring']} {depth}"] = (
            depth,
            Mode(
                first["mass_kg"]["value"], first["natural_frequency_rad_per_s"]["value"],
                first["damping_ratio"]["value"], rest["added_mass_kg"]["value"], rest["drag_coefficient"]["value"],
            ),
        )  # fmt: skip
    return found


def compared(found: dict[str, tuple[float, Mode]], motions: list[Motion]) -> Iterator[tuple[str, Comparison]]:
    """Every wet trial of a level with a mode against its vertical cells."""
    for motion in motions:
        conditions = motion.recording.conditions
        key = f"{conditions['spring']} {float(conditions['water_depth_m'])}"
        if key in found:
            depth, mode = found[key]
            yield key, compare(motion, DATA / Path(motion.recording.path).name, mode, depth)


def page(rows: dict[str, list[Comparison]], found: dict[str, tuple[float, Mode]]) -> str:
    """The table in words."""
    lines = [
        "# Vertical load cells that were never fitted",
        "",
        "The virtual flume's vertical cells read weight less buoyancy in their sum, and the overturning moment about",
        "the rail in their difference. No fit of undertow uses them. From the motion, the mode that the run of",
        "`configs/flume.yaml` found and the heights in setup.json the difference is predicted",
        "(`experiments/vertical_cells/cells.py`), and held against what was recorded: the whole of it, the water's",
        "part (structure's inertia off), and the mode's part alone (added mass and drag off too). *Size* is the",
        "measured mode's part over the predicted one.",
        "",
        "    python -m experiments vertical_cells",
        "",
        "| group | mode | trials | whole | water | mode alone | size |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for key, many in sorted(rows.items(), key=lambda row: row[0].split()[::-1]):
        mode = found[key][1]

        def span(name: str, many: list[Comparison] = many) -> str:
            values = [getattr(one, name) for one in many]
            return f"{min(values):.3f} to {max(values):.3f}"

        numbers = f"{mode.frequency_rad_per_s:.3f} rad/s, {mode.mass_kg:.0f} kg"
        spans = " | ".join(span(name) for name in ("whole", "water", "mode", "size"))
        lines.append(f"| {key} m | {numbers} | {len(many)} | {spans} |")
    good = {key: many for key, many in rows.items() if np.median([one.mode for one in many]) >= WANTED}
    bad = [key for key in rows if key not in good]
    every = [one for many in good.values() for one in many]
    lines += [
        "",
        f"Asked for: a correlation of {WANTED}. In {len(good)} groups the mode's part alone has it in "
        f"{sum(one.mode >= WANTED for one in every)} of {len(every)} trials.",
    ]
    if bad:
        lines += [
            "",
            f"In {', '.join(f'{key} m' for key in bad)} the cells refuse the mode: its part does not go with",
            "what they read. The water there radiates and does not oscillate in cells; what the fit took for a",
            "resonator is named wrongly, and the vertical cells, which no fit has seen, say so.",
        ]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Modes, comparison, docs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--run", type=Path, help="a finished run folder of configs/flume.yaml")
    folder = parser.parse_args().run
    with tempfile.TemporaryDirectory() as scratch:
        if folder is None:
            folder = run_to_folder(CONFIG, SEARCH, Path(scratch) / "flume").folder
        verdict = json.loads((folder / "verdict.json").read_text(encoding="utf-8"))
    found = modes(verdict)
    rows: dict[str, list[Comparison]] = {}
    for key, one in compared(found, list(read_and_condition(load(CONFIG)).motions)):
        rows.setdefault(key, []).append(one)
    kept = {
        "modes": {key: asdict(mode) for key, (_, mode) in found.items()},
        "trials": {key: [asdict(one) for one in many] for key, many in rows.items()},
    }
    (DOCS / "vertical_cells.json").write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")
    (DOCS / "vertical_cells.md").write_text(page(rows, found), encoding="utf-8")
    print(page(rows, found))
