"""A campaign on disk, as a laboratory would hand it over: index, recordings, config; `undertow run` reads it.

Belongs here: files and the views in which the same campaign can be written (rate, units, sign, order, rest level,
window). Does not belong here: what is in a recording (recordings.py).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from experiments.names.recordings import record
from experiments.names.rigs import DRY_DEPTH_M, SCATTER, WATER_KG_PER_M3, WET_DEPTH_M, Plan, Trial
from experiments.names.scenes import Campaign

TERMS = ("stiffness", "viscous_damping", "coulomb_friction", "added_mass", "quadratic_drag")
STANDARD_GRAVITY = 9.80665
"""m/s^2 in one g."""


@dataclass(frozen=True)
class View:
    """How a campaign is written; none of it is physics.

    ``millimetres``: displacement in mm and acceleration in g; ``mirrored``: every sign the other way round;
    ``shuffled``: trials in another order; ``level_m``: added to every displacement; ``cycles``: the window ends so many
    periods after (before) where it would by itself; ``stated``: the config states the scatter.
    """

    millimetres: bool = False
    mirrored: bool = False
    shuffled: bool = False
    level_m: float = 0.0
    cycles: float = 0.0
    stated: bool = False


def write(
    campaign: Campaign, folder: Path, view: View | None = None, ends: Mapping[str, float] | None = None
) -> Path:
    """Write a campaign into a folder, with ends of windows by file (s) where given; the path of its config."""
    view = view or View()
    folder.mkdir(parents=True, exist_ok=True)
    trials = list(campaign.plan.trials())
    for trial in trials:
        _write_trial(folder / trial.file, record(campaign, trial), view)
    if view.shuffled:
        np.random.default_rng([campaign.plan.seed, 9]).shuffle(trials)  # type: ignore[arg-type]
    rows = [f"{t.file},{t.spring},{WET_DEPTH_M if t.wet else DRY_DEPTH_M:.2f}" for t in trials]
    (folder / "campaign.csv").write_text("\n".join(["file,spring,water_depth_m", *rows]) + "\n", encoding="utf-8")
    config = folder / "config.yaml"
    config.write_text(_config(campaign, view, ends or {}), encoding="utf-8")
    return config


def _write_trial(path: Path, columns: dict[str, np.ndarray], view: View) -> None:
    names = list(columns)
    sign = -1.0 if view.mirrored else 1.0
    table = [columns[names[0]]]
    for place, name in enumerate(names[1:]):
        values = sign * columns[name] + (view.level_m if place == 0 else 0.0)
        if view.millimetres and place < 2:
            values = values * 1e3 if place == 0 else values / STANDARD_GRAVITY
        table.append(values)
    np.savetxt(path, np.column_stack(table), "%.8g", ",", header=",".join(names), comments="")


def _config(campaign: Campaign, view: View, ends: Mapping[str, float]) -> str:
    """The config: what the laboratory knows, and nothing of what is hidden."""
    plan, rig = campaign.plan, campaign.plan.rig
    columns = [s.column for s in rig.sensors]
    turning = rig.coordinate == "rotation"
    units = ("mm", "g") if view.millimetres else (("rad", "rad/s^2") if turning else ("m", "m/s^2"))
    channels = [
        "    time: {column: time_s, unit: s}",
        f"    displacement: {{column: {columns[0]}, unit: {units[0]}}}",
        f"    acceleration: {{column: {columns[1]}, unit: {units[1]}}}",
    ]
    if len(columns) > 2:
        channels.append(f"    spring_force: {{columns: [{', '.join(columns[2:])}], unit: N}}")
    depth = f"{WET_DEPTH_M:.2f}"
    specimen = [f"  mass_kg: {rig.mass}", f"  area_m2: {{by: water_depth_m, {depth}: {rig.area}}}"]
    if rig.volume:
        specimen.append(f"  submerged_volume_m3: {{by: water_depth_m, {depth}: {rig.volume}}}")
    specimen.append(f"  water_density_kg_per_m3: {WATER_KG_PER_M3}")
    if view.stated:
        scatter = ", ".join(f"{name}: {value}" for name, value in SCATTER[plan.scatter].items())
        specimen.append(f"  scatter: {{{scatter}}}")
    terms = ", ".join(t for t in TERMS if t not in campaign.lacks)
    return "\n".join([
        "name: hidden", "recordings:", "  index: campaign.csv", "  channels:", *channels,
        "trials:", "  group_by: [spring, water_depth_m]", f"  dry: {{water_depth_m: {DRY_DEPTH_M}}}",
        *_windows(ends), "specimen:", *specimen,
        f"equation: {{terms: [{terms}], coordinate: {rig.coordinate}}}", "identify: [output_error]", "seed: 0", "",
    ])  # fmt: skip


def _windows(ends: Mapping[str, float]) -> list[str]:
    return ["  window:", *(f"    {name}: {{end_s: {end:.3f}}}" for name, end in ends.items())] if ends else []


def period(plan: Plan, trial: Trial) -> float:
    """A trial's period by the equation without anything hidden, s."""
    numbers = plan.means(trial)
    return float(2.0 * np.pi * np.sqrt(numbers["M"] / numbers["k"]))
