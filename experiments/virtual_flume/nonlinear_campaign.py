"""A small campaign on closed cells of steep water, as files a laboratory would leave, with its truth beside them.

A rougher truth than the section's (campaign.py): the water in the cells between the girders is kept by walls and a
floor that go with the body, and is fully nonlinear (nonlinear_cell.py); outside, water only carries the floor's
load and resists by quadratic drag. So nothing radiates, and the added mass is the cells' own water that does not
slosh. One level lies under depth / width 0.337, where a standing wave hardens with its amplitude, one above, where
it softens.

`python -m experiments virtual_flume.nonlinear_campaign FOLDER` writes it. Every draw comes from
`default_rng([SEED, trial])`; the program under test never reads truth.json.
"""

from __future__ import annotations

import gzip
import json
import sys
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path

import numpy as np

from experiments.virtual_flume import section, sensors
from experiments.virtual_flume.frequency import DENSITY, GRAVITY
from experiments.virtual_flume.march import Flume, Motion
from experiments.virtual_flume.nonlinear_cell import NonlinearFlume, tadjbakhsh_keller
from experiments.virtual_flume.nonlinear_water import Cell, theory_mode
from experiments.virtual_flume.structure import MASS_KG, Structure, normal_force, structure
from experiments.virtual_flume.trials import LOAD_SHARE, Plan, Trial, rounded, write_index
from experiments.virtual_flume.water import stokes_layer_rate

Array = np.ndarray

SEED = 20260807
RATE_HZ = 100.0
DURATION_S = 12.0
WET_DEPTHS_M = (2.24, 2.32)  # above the flume's floor: 0.09 and 0.17 m in the cells
RELEASES_M = {"long": (0.015, 0.021, 0.028, 0.032), "short": (0.006, 0.008, 0.010, 0.011)}
CELLS_LENGTH_M = (section.GIRDERS - 1) * section.SPAN_M  # all cells together, out of plane
ELEMENTS, ORDER = 16, 6  # along a cell and over its depth
CHANNELS = sensors.SENSORS[:4]  # displacement, acceleration, two load cells in line with the spring


PLAN = Plan("nonlinear cell", SEED, RATE_HZ, WET_DEPTHS_M, RELEASES_M)


def trials() -> list[Trial]:
    """All of them, in the order of level, spring and amplitude.

    >>> len(trials()), len({t.file for t in trials()})
    (24, 24)
    """
    return PLAN.trials()


def cell_at(depth_m: float, elements: int = ELEMENTS, order: int = ORDER) -> Cell | None:
    """One cell at a water level, None where dry: as wide as the gap between webs, as deep as the girders are wet."""
    level = section.Level(depth_m)
    return None if level.is_dry else Cell(level.surface_width_m, level.wetted_height_m, elements, order)


def body_of(trial: Trial) -> Structure:
    """The trial's structure; the cells' own buoyancy carries the water in them, so friction is the section's."""
    level = section.Level(trial.water_depth_m)
    return structure(level, trial.stiffness_N_per_m, trial.damping_Ns_per_m, trial.friction)


def motion_of(trial: Trial, cell: Cell | None = None, duration_s: float = DURATION_S) -> Motion:
    """The truth of a trial at its samples, surfaces kept; times are true times, s. `cell`: another mesh than ours."""
    cell = cell or cell_at(trial.water_depth_m)
    body = body_of(trial)
    time = np.arange(round(duration_s * RATE_HZ)) / RATE_HZ + trial.clock_offset_s
    flume = Flume(body, None) if cell is None else NonlinearFlume(body, cell, CELLS_LENGTH_M)
    return flume.release(trial.x0_m, trial.release_s, time, keep_surface=cell is not None)


def recording(trial: Trial, motion: Motion) -> bytes:
    """The trial's file before compression: CSV with a header line."""
    spring_force = trial.stiffness_N_per_m * motion.x
    truth = (motion.x, motion.a, LOAD_SHARE * spring_force, (1.0 - LOAD_SHARE) * spring_force)
    return sensors.recording(PLAN, trial, CHANNELS, truth, 2)


def setup() -> dict[str, object]:
    """What the laboratory knows, for setup.json."""
    levels = [section.Level(d) for d in WET_DEPTHS_M]
    return {
        "structure_mass_kg": MASS_KG,
        "g": GRAVITY,
        "rho_w": DENSITY,
        "dry_water_depth_m": section.DRY_DEPTH_M,
        "cells": section.GIRDERS - 1,
        "cells_length_m": CELLS_LENGTH_M,
        "levels": [
            {
                "water_depth_m": level.depth_m,
                "cell_width_m": round(level.surface_width_m, 4),
                "cell_depth_m": round(level.wetted_height_m, 4),
                "area_m2": round(level.reference_area_m2, 4),
                "submerged_volume_m3": round(level.submerged_volume_m3, 4),
            }
            for level in levels
        ],
        "channels": {
            "time_s": "s",
            "displacement": "disp_m, string potentiometer",
            "acceleration": "accel_mps2",
            "spring_force": "loadcell1_N + loadcell2_N = spring force, sign as displacement (+k x)",
        },
    }


def cubic_stiffness(width_m: float, depth_m: float) -> float:
    """b of s'' + w^2 s + b s^3 = -x'' that moves the first mode's frequency as third-order waves do; 1/(m2 s2).

    The mode's sway is s = a * 2 rho L / (k^2 m_1), a its elevation at the wall, since m_1 s' is the momentum of the
    water relative to the cell; b s^3 moves w by 3 b s^2 / (8 w^2).
    """
    mode, wave_number = theory_mode(width_m, depth_m), np.pi / width_m
    amplitude = 0.01 * width_m  # any: both sides go with its square
    sway = 2.0 * amplitude / (wave_number**2 * mode.participating_area)
    change = tadjbakhsh_keller(width_m, depth_m, amplitude)
    return float(8.0 * mode.frequency**2 * change / (3.0 * sway**2))


def level_truth(depth_m: float) -> dict[str, object]:
    """What small waves in a level's cells do, by linear theory, and how the first mode moves with amplitude.

    Kilograms are of all cells together. The first mode's frequency changes by the Tadjbakhsh and Keller share at
    an elevation of a tenth of the width at the walls; its damping is that of laminar layers.
    """
    level = section.Level(depth_m)
    width, depth = level.surface_width_m, level.wetted_height_m
    per_area = DENSITY * CELLS_LENGTH_M
    modes = [theory_mode(width, depth, number) for number in (1, 3, 5)]
    masses = [per_area * m.participating_area for m in modes]
    return {
        "modes": [
            {
                "frequency_rad_per_s": m.frequency,
                "participating_mass_kg": mass,
                "damping_ratio": stokes_layer_rate(width) / m.frequency,
            }
            for m, mass in zip(modes, masses, strict=True)
        ],
        "water_mass_kg": per_area * width * depth,
        "added_mass_without_the_first_mode_kg": per_area * width * depth - masses[0],
        "depth_over_width": depth / width,
        "relative_frequency_change_at_a_tenth_of_the_width": tadjbakhsh_keller(width, depth, 0.1 * width),
        "cubic_stiffness_per_m2_s2": cubic_stiffness(width, depth),
        "drag_Ns2_per_m2": structure(level, 1.0, 0.0, 0.0).drag,
        "normal_force_N": normal_force(level),
    }


def trial_truth(trial: Trial, motion: Motion) -> dict[str, object]:
    """A trial's own numbers, and how steep and how high its water went."""
    steep: dict[str, object] = {}
    cell = cell_at(trial.water_depth_m)
    if cell is not None:
        slope = np.array([np.abs(cell.slope(eta)).max() for eta in motion.eta])
        steep = {
            "highest_elevation_m": float(motion.eta.max()),
            "steepest_slope": float(slope.max()),
            "share_of_time_steeper_than_one": float(np.mean(slope > 1.0)),
        }
    return {**asdict(trial), **steep}


def write(folder: Path, chosen: list[Trial] | None = None) -> Iterator[Trial]:
    """Write recordings, index, setup and truth into a folder; yields each trial once its file stands."""
    folder.mkdir(parents=True, exist_ok=True)
    everything = trials() if chosen is None else chosen
    told = []
    for trial in everything:
        motion = motion_of(trial)
        (folder / trial.file).write_bytes(gzip.compress(recording(trial, motion), compresslevel=9, mtime=0))
        told.append(trial_truth(trial, motion))
        yield trial
    write_index(folder, everything)
    levels = {f"{depth:.2f}": level_truth(depth) for depth in WET_DEPTHS_M}
    kind = "fully nonlinear potential flow in closed cells that go with the body; nonlinear structure"
    truth = {"kind": kind, "seed": SEED, "levels": levels, "trials": told}
    for name, content in (("setup", setup()), ("truth", truth)):
        (folder / f"{name}.json").write_text(json.dumps(rounded(content, 6), indent=1) + "\n")


def main(arguments: list[str] | None = None) -> int:
    """Write the campaign into the folder named on the command line; 2 where none is named."""
    arguments = sys.argv[1:] if arguments is None else arguments
    if len(arguments) != 1:
        print("usage: python -m experiments virtual_flume.nonlinear_campaign FOLDER", file=sys.stderr)
        return 2
    for trial in write(Path(arguments[0])):
        told = f"{trial.file} {trial.spring:5s} {trial.water_depth_m:.2f} m {trial.x0_m:.4f} m"
        print(told, file=sys.stderr, flush=True)
    return 0
