"""What the vertical load cells of a bridge section must read when its water has the mode that a run found.

An antisymmetric flow lifts nothing to first order: the sum of the two lines of cells is weight less buoyancy. Their
difference carries the overturning moment about the rail line, to which every horizontal force adds its own height:

    v2 - v1 = -(2 / gauge) [ (z_m - z_r) m x'' + (z_w - z_r) (q x'|x'| + m_a x'' + m_s (x'' + s'')) ]

with the mass at z_m, the water's forces at the middle of the wetted height z_w, the rail at z_r. s is the found mode,
driven by the measured acceleration. Nothing here is fitted to the vertical cells.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from undertow.conditioning.motion import Motion
from undertow.discrepancy.residual import even_motion
from undertow.equation import registry
from undertow.equation.term import Array

DATA = Path(__file__).resolve().parents[2] / "data" / "virtual_flume"
DENSITY_KG_PER_M3 = 1000.0


@dataclass(frozen=True)
class Mode:
    """A level as a run found it: participating mass (kg), frequency (rad/s) and damping ratio of its mode, added mass
    (kg) and drag coefficient of the rest."""

    mass_kg: float
    frequency_rad_per_s: float
    damping_ratio: float
    added_mass_kg: float
    drag_coefficient: float


@dataclass(frozen=True)
class Geometry:
    """What the laboratory knows: heights above the floor (m), gauge between the lines of cells, mass, drag area."""

    gauge_m: float
    rail_m: float
    mass_height_m: float
    water_height_m: float
    mass_kg: float
    area_m2: float


@dataclass(frozen=True)
class Comparison:
    """One trial: correlations of measured and predicted difference of the cells, of the water's part in it, and of the
    mode's part alone, with the measured mode's size over the predicted (slope through zero)."""

    trial: str
    whole: float
    water: float
    mode: float
    size: float


def geometry(depth_m: float) -> Geometry:
    """Geometry at a water depth from setup.json, which the laboratory has; KeyError for a level that it has not."""
    said = json.loads((DATA / "setup.json").read_text(encoding="utf-8"))
    levels = {float(level["water_depth_m"]): level for level in said["levels"]}
    level = levels[depth_m]
    water = said["girder_bottom_above_floor_m"] + 0.5 * level["wetted_height_m"]
    return Geometry(
        said["bearing_gauge_m"], said["rail_height_m"], said["mass_height_m"], water, said["structure_mass_kg"],
        level["area_m2"],
    )  # fmt: skip


def predicted_parts(motion: Motion, mode: Mode, place: Geometry) -> Mapping[str, Array]:
    """v2 - v1 in N along a trial's even motion inside its window, by part: structure, rest of the water, mode."""
    even = even_motion(motion)
    water = registry.find(
        "hidden_resonator", natural_frequency_rad_per_s=mode.frequency_rad_per_s, damping_ratio=mode.damping_ratio
    )
    rocking = water.force(even.x, even.v, even.a, even.t)
    drag = 0.5 * DENSITY_KG_PER_M3 * mode.drag_coefficient * place.area_m2 * even.v * np.abs(even.v)
    arm, high = place.water_height_m - place.rail_m, place.mass_height_m - place.rail_m
    moments = {
        "structure": high * place.mass_kg * even.a,
        "rest": arm * (mode.added_mass_kg * even.a + drag),
        "mode": arm * mode.mass_kg * rocking,
    }
    return {name: -(2.0 / place.gauge_m) * moment[even.inside] for name, moment in moments.items()}


def measured_difference(motion: Motion, path: Path) -> Array:
    """v2 - v1 as recorded, N, at the instants of `predicted_parts`."""
    table = pd.read_csv(path)
    even = even_motion(motion)
    time = motion.window.release_s + even.t[even.inside]
    difference = table["vload2_N"] - table["vload1_N"]
    return np.interp(time, table["time_s"].to_numpy(float), difference.to_numpy(float))


def compare(motion: Motion, path: Path, mode: Mode, depth_m: float) -> Comparison:
    """One trial's vertical cells against what the found mode predicts."""
    parts = predicted_parts(motion, mode, geometry(depth_m))
    measured = measured_difference(motion, path)
    water = measured - parts["structure"]
    alone = water - parts["rest"]
    alone, mode_part = alone - alone.mean(), parts["mode"] - parts["mode"].mean()
    return Comparison(
        motion.name,
        _correlation(measured, sum(parts.values(), 0.0 * measured)),
        _correlation(water, parts["rest"] + parts["mode"]),
        _correlation(alone, mode_part),
        float(alone @ mode_part / (mode_part @ mode_part)),
    )


def _correlation(one: Array, other: Array) -> float:
    return float(np.corrcoef(one, other)[0, 1])
