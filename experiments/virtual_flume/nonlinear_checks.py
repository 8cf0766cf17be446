"""How far the steep cells can be trusted, as the tables of docs/nonlinear_cell.md: no data are written, no test is run.

`python -m experiments virtual_flume.nonlinear_checks` prints them (half a minute).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from experiments.virtual_flume import nonlinear_campaign as campaign
from experiments.virtual_flume.nonlinear_cell import (
    Losses,
    NonlinearFlume,
    first_frequency,
    free_wave,
    tadjbakhsh_keller,
)
from experiments.virtual_flume.nonlinear_water import Cell, theory_mode
from experiments.virtual_flume.structure import MASS_KG, SPRINGS, Structure

WIDTH_M = 0.3344
DEPTHS_M = (0.07, 0.09, 0.14, 0.17, 0.30)
AMPLITUDES = (0.01, 0.03, 0.06)  # at the wall, over the width
STEPS_A_PERIOD, PERIODS = 120, 6.2
FINER = (24, 8)  # elements, order, beside the campaign's


def linear_rows() -> Iterator[str]:
    """Relative errors of the first mode's frequency and mass against linear theory, per depth."""
    for depth in DEPTHS_M:
        found, theory = (
            Cell(WIDTH_M, depth, campaign.ELEMENTS, campaign.ORDER).linear_modes(1)[0],
            theory_mode(WIDTH_M, depth),
        )
        frequency = found.frequency / theory.frequency - 1.0
        mass = found.participating_area / theory.participating_area - 1.0
        yield f"| {depth:.2f} m | {theory.frequency:.3f} rad/s | {frequency:.1e} | {mass:.1e} |"


def amplitude_rows() -> Iterator[str]:
    """Change of a free wave's frequency with amplitude, ours and Tadjbakhsh and Keller's, per depth."""
    for depth in DEPTHS_M:
        cell = Cell(WIDTH_M, depth, 12, 6)
        linear = cell.linear_modes(1)[0].frequency
        period = 2.0 * np.pi / linear
        row = f"| {depth:.2f} m | {depth / WIDTH_M:.2f} |"
        for share in AMPLITUDES:
            a = share * WIDTH_M
            time, surface = free_wave(cell, a, PERIODS * period, period / STEPS_A_PERIOD, Losses())
            ours = first_frequency(cell, time, surface) / linear - 1.0
            row += f" {100 * ours:+.2f} % ({100 * tadjbakhsh_keller(WIDTH_M, depth, a):+.2f} %) |"
        yield row


def energy_rows() -> Iterator[str]:
    """Largest relative change of energy over 2 s without losses, at the releases of the campaign's second size."""
    for spring, set_of in SPRINGS.items():
        for depth in campaign.WET_DEPTHS_M:
            cell = campaign.cell_at(depth)
            if cell is None:
                continue
            flume = NonlinearFlume(
                Structure(MASS_KG, set_of.stiffness, 0.0, 0.0, 0.0), cell, campaign.CELLS_LENGTH_M, Losses()
            )
            y, direction = np.zeros(2 + 2 * flume.n), 0.0
            y[0] = campaign.RELEASES_M[spring][1]
            energy = [flume.energy(y)]
            for _ in range(40):
                y, direction = flume.advance(y, direction, 0.05)
                energy.append(flume.energy(y))
            worst = np.max(np.abs(np.array(energy) / energy[0] - 1.0))
            yield f"| {spring} | {depth:.2f} m | {1000 * campaign.RELEASES_M[spring][1]:.0f} mm | {worst:.1e} |"


def mesh_rows(duration_s: float = 4.0) -> Iterator[str]:
    """RMS difference of the body's motion between the campaign's mesh and a finer one, over RMS motion."""
    for trial in campaign.trials():
        sizes = campaign.RELEASES_M[trial.spring]
        if trial.water_depth_m not in campaign.WET_DEPTHS_M or trial.x0_target_m not in (sizes[1], sizes[-1]):
            continue
        trial = replace(trial, release_s=0.0, clock_offset_s=0.0)
        ours = campaign.motion_of(trial, duration_s=duration_s)
        finer = campaign.motion_of(trial, campaign.cell_at(trial.water_depth_m, *FINER), duration_s)
        error = np.sqrt(np.mean((ours.x - finer.x) ** 2) / np.mean(finer.x**2))
        row = f"| {trial.spring} | {trial.water_depth_m:.2f} m | {1000 * trial.x0_target_m:.0f} mm |"
        yield f"{row} {100 * error:.2f} % |"


def main() -> int:
    """Print every table."""
    tables = (
        ("| depth | frequency | its error | error of the mass |", linear_rows),
        ("| depth | over width |" + "".join(f" {a:.2f} of the width |" for a in AMPLITUDES), amplitude_rows),
        ("| spring | level | release | energy |", energy_rows),
        ("| spring | level | release | difference |", mesh_rows),
    )
    for head, rows in tables:
        print(f"\n{head}\n|{'---|' * (head.count('|') - 1)}")
        for row in rows():
            print(row, flush=True)
    return 0
