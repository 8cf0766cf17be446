"""The campaign: sixty releases with their scatter and instruments, as files a laboratory would leave.

Deterministic: every draw comes from `default_rng([SEED, trial])`. What the laboratory knows goes to
setup.json; what made the data goes to truth.json (see answer.py), which a program under test never reads.
"""

from __future__ import annotations

import gzip
import io
import json
from collections.abc import Iterator
from functools import lru_cache
from pathlib import Path

import numpy as np

from experiments.virtual_flume import section, sensors
from experiments.virtual_flume.frequency import DENSITY, GRAVITY, Water
from experiments.virtual_flume.march import Flume, Motion
from experiments.virtual_flume.structure import MASS_KG, normal_force, structure
from experiments.virtual_flume.trials import LOAD_SHARE, Plan, Trial, write_index
from experiments.virtual_flume.water import RAIL_HEIGHT_M, flume_water

Array = np.ndarray

SEED = 20260311
RATE_HZ = 250.0
DURATION_S = 14.0
RELEASES_M = {"long": (0.015, 0.025, 0.040, 0.066, 0.107), "short": (0.008, 0.012, 0.017, 0.024, 0.033)}
BEARING_GAUGE_M = 1.5  # between the two lines of vertical load cells; nominal
MASS_HEIGHT_M = 2.33  # centre of the moving mass above the floor; nominal


PLAN = Plan("virtual flume", SEED, RATE_HZ, section.WET_DEPTHS_M, RELEASES_M)


def trials() -> list[Trial]:
    """All sixty, in the order of level, spring and amplitude.

    >>> len(trials()), len({t.file for t in trials()})
    (60, 60)
    """
    return PLAN.trials()


@lru_cache(maxsize=8)
def water_at(depth_m: float) -> Water | None:
    """The flume's water at a level, None where dry; kept, since a level is used by ten trials."""
    return None if section.Level(depth_m).is_dry else flume_water(depth_m)


def motion_of(trial: Trial, keep_surface: bool = False) -> Motion:
    """The truth of a trial at its samples: 250 Hz, 14 s; times are true times, s."""
    level = section.Level(trial.water_depth_m)
    body = structure(level, trial.stiffness_N_per_m, trial.damping_Ns_per_m, trial.friction)
    time = np.arange(int(DURATION_S * RATE_HZ)) / RATE_HZ + trial.clock_offset_s
    return Flume(body, water_at(trial.water_depth_m)).release(trial.x0_m, trial.release_s, time, keep_surface)


def vertical_loads(trial: Trial, motion: Motion) -> tuple[Array, Array]:
    """Forces on the two lines of bearings, at -gauge/2 and +gauge/2 of the middle; N, (t,) each.

    Sum: weight less buoyancy (an antisymmetric flow lifts nothing to first order). Difference: the water's
    moment about the rail line, the drag's and the moving mass's.
    """
    level = section.Level(trial.water_depth_m)
    body = structure(level, trial.stiffness_N_per_m, trial.damping_Ns_per_m, trial.friction)
    drag_height = section.GIRDER_BOTTOM_M + 0.5 * level.wetted_height_m
    drag_moment = (drag_height - RAIL_HEIGHT_M) * body.drag * motion.v * np.abs(motion.v)
    mass_moment = (MASS_HEIGHT_M - RAIL_HEIGHT_M) * MASS_KG * motion.a
    difference = -(2.0 / BEARING_GAUGE_M) * (motion.moment + drag_moment + mass_moment)
    half = 0.5 * normal_force(level)
    return half - 0.5 * difference, half + 0.5 * difference


def recording(trial: Trial) -> bytes:
    """The trial's file before compression: CSV with a header line."""
    motion = motion_of(trial)
    spring_force = trial.stiffness_N_per_m * motion.x
    v1, v2 = vertical_loads(trial, motion)
    truth = (motion.x, motion.a, LOAD_SHARE * spring_force, (1.0 - LOAD_SHARE) * spring_force, v1, v2)
    return sensors.recording(PLAN, trial, sensors.SENSORS, truth, 4)


def _compressed(text: bytes) -> bytes:
    buffer = io.BytesIO()
    with gzip.GzipFile(filename="", mode="wb", fileobj=buffer, compresslevel=9, mtime=0) as stream:
        stream.write(text)
    return buffer.getvalue()


def setup() -> dict[str, object]:
    """What the laboratory knows, for setup.json."""
    levels = [section.Level(d) for d in section.WET_DEPTHS_M]
    return {
        "structure_mass_kg": MASS_KG,
        "g": GRAVITY,
        "rho_w": DENSITY,
        "span_m": section.SPAN_M,
        "model_width_m": round(2.0 * section.deck_half_width_m(), 3),
        "girders": section.GIRDERS,
        "girder_spacing_m": section.GIRDER_SPACING_M,
        "girder_bottom_above_floor_m": section.GIRDER_BOTTOM_M,
        "dry_water_depth_m": section.DRY_DEPTH_M,
        "rail_height_m": RAIL_HEIGHT_M,
        "bearing_gauge_m": BEARING_GAUGE_M,
        "mass_height_m": MASS_HEIGHT_M,
        "levels": [
            {
                "water_depth_m": level.depth_m,
                "wetted_height_m": round(level.wetted_height_m, 4),
                "area_m2": round(level.reference_area_m2, 4),
                "submerged_volume_m3": round(level.submerged_volume_m3, 4),
                "mass_of_water_in_cells_kg": round(level.water_in_cells_kg, 1),
                "cell_surface_width_m": round(level.surface_width_m, 4),
            }
            for level in levels
        ],
        "channels": {
            "time_s": "s",
            "displacement": "disp_m, string potentiometer",
            "acceleration": "accel_mps2",
            "spring_force": "loadcell1_N + loadcell2_N = spring force, sign as displacement (+k x)",
            "normal_force": "vload1_N + vload2_N = weight less buoyancy; 1 at -gauge/2, 2 at +gauge/2",
        },
    }


def write(folder: Path) -> Iterator[Trial]:
    """Write recordings, index and setup into a folder; yields each trial once its file stands."""
    folder.mkdir(parents=True, exist_ok=True)
    everything = trials()
    for trial in everything:
        (folder / trial.file).write_bytes(_compressed(recording(trial)))
        yield trial
    write_index(folder, everything)
    (folder / "setup.json").write_text(json.dumps(setup(), indent=1) + "\n")
