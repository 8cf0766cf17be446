"""The flume's solver against closed forms: sloshing of closed cells, energy, friction's decrement, the two answers."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from experiments.virtual_flume import frequency, section, structure, studies
from experiments.virtual_flume.march import Flume
from experiments.virtual_flume.mesh import Spacing, flume
from experiments.virtual_flume.rational import vector_fit
from experiments.virtual_flume.water import closed_cells, flume_water

FOLDER = Path(studies.__file__).parent
COARSE = Spacing(refine=0.5)
"""A quarter of the data's elements: still within 0.1 % of them (test_convergence_of_mesh.py), ten times as fast."""


@pytest.mark.parametrize(("width", "depth"), studies.CELLS_M)
def test_closed_cells_slosh_as_linear_theory_says(width, depth):
    rows = studies.closed_cell(width, depth)
    assert [row.order for row in rows] == [1, 3, 5]
    assert max(abs(row.frequency_error) for row in rows) < 0.002  # what the flume was asked to give
    assert max(abs(row.mass_error) for row in rows) < 0.01


def test_water_of_a_closed_cell_is_all_accounted_for_at_rest():
    water = closed_cells(0.334, 0.14, 17.25)
    mass = 1000.0 * 0.334 * 0.14 * 17.25
    assert frequency.apparent_mass(water, 1e-6j).real == pytest.approx(mass, rel=1e-6)  # slow sway carries all water


@pytest.mark.parametrize("spring", ["long", "short"])
def test_energy_stays_where_nothing_is_lost(spring):
    kept = studies.lossless_energy(2.36, spring, 4.0, COARSE)
    assert kept.largest_change < 1e-6


def test_energy_shows_a_sponge():
    water = flume_water(2.36, COARSE)
    body = structure.Structure(structure.MASS_KG, structure.SPRINGS["short"].stiffness, 0.0, 0.0, 0.0)
    motion = Flume(body, water).release(0.03, 0.0, np.linspace(0.0, 4.0, 50), keep_surface=True)
    total = studies.energy(water, body, motion)
    assert total[-1] < 0.99 * total[0]  # in 4 s the first long waves have reached the sponge
    assert np.max(np.diff(total)) < 1e-9 * total[0]  # a loss never gives back


def test_dry_friction_takes_two_slips_a_half_swing_and_then_holds():
    k, force = 109_600.0, 190.0
    body = structure.Structure(structure.MASS_KG, k, 0.0, 0.0, force)
    half = np.pi * np.sqrt(structure.MASS_KG / k)
    motion = Flume(body, None).release(0.015, 0.0, half * np.arange(12))
    slip = 2.0 * force / k
    swings = np.maximum(0.015 - slip * np.arange(12), 0.0)
    moving = swings > 0.5 * slip
    assert np.abs(motion.x)[moving] == pytest.approx(swings[moving], abs=1e-9)  # Runge-Kutta over ten swings of 2 ms
    assert abs(motion.x[-1]) <= force / k
    assert motion.x[-1] == motion.x[-2]


def test_the_rational_fit_finds_the_operators_pole():
    water = flume_water(2.29, COARSE)
    mode = frequency.modes(water)[0]
    near = mode.frequency * (1.0 + np.linspace(-0.02, 0.02, 41))
    w = np.unique(np.concatenate([np.arange(4.0, 14.0, 0.1), near]))
    added, damping = frequency.added_mass_and_damping(water, w)
    found = vector_fit(w, added + damping / (1j * w), 8).modes()
    nearest = min(found, key=lambda m: abs(m.frequency - mode.frequency))
    assert nearest.frequency == pytest.approx(mode.frequency, rel=1e-5)
    assert nearest.participating_mass == pytest.approx(mode.participating_mass, rel=0.01)


def test_radiated_waves_never_drive_the_body():
    _, damping = frequency.added_mass_and_damping(flume_water(2.43, COARSE), np.linspace(2.0, 16.0, 29))
    assert np.min(damping) > 0.0


def test_a_level_below_the_girders_has_no_section():
    with pytest.raises(ValueError, match=r"water depth 1.63 m does not reach the girders' bottom at 2.15 m"):
        flume(section.DRY_DEPTH_M)


def test_too_few_frequencies_are_refused_by_the_fit():
    with pytest.raises(ValueError, match="5 frequencies cannot fix 8 pole pairs; give at least 17"):
        vector_fit(np.linspace(1.0, 2.0, 5), np.ones(5, dtype=complex), 8)


def test_the_committed_checks_hold_what_was_asked_for():
    rows = json.loads((FOLDER / "results" / "checks.json").read_text(encoding="utf-8"))
    cells = [row for row in rows if row["kind"] == "ClosedCell"]
    assert len(cells) == 9
    for row in cells:
        assert row["frequency"] == pytest.approx(row["law_frequency"], rel=0.002)
        assert row["mass_share"] == pytest.approx(row["law_mass_share"], rel=0.01)
    kept = [row["largest_change"] for row in rows if row["kind"] == "Kept"]
    assert len(kept) == 4
    assert max(kept) < 1e-6
