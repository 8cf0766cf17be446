"""Closed cells of steep water, held against linear theory, conservation laws and third-order standing waves."""

from __future__ import annotations

import numpy as np
import pytest

from experiments.virtual_flume import nonlinear_water
from experiments.virtual_flume.march import Flume
from experiments.virtual_flume.nonlinear_cell import (
    Losses,
    NonlinearFlume,
    first_frequency,
    free_wave,
    ordinary_losses,
    tadjbakhsh_keller,
)
from experiments.virtual_flume.nonlinear_water import Cell, theory_mode
from experiments.virtual_flume.structure import Structure
from experiments.virtual_flume.water import closed_cells

WIDTH = 0.3344  # m, a gap between two webs
LENGTH = 17.25  # m of cells
MASS = 2637.4  # kg
SHALLOW, BETWEEN, DEEP = 0.07, 0.14, 0.30  # m: depth over width 0.21, 0.42, 0.90; hardening turns softening at 0.337


def coarse(depth: float) -> Cell:
    return Cell(WIDTH, depth, elements=12, order=6)


def released(flume: Flume, x0: float) -> np.ndarray:
    y = np.zeros(2 + 2 * flume.n)
    y[0] = x0
    return y


def energies(flume: NonlinearFlume, x0: float, steps: int, step_s: float) -> np.ndarray:
    y, direction = released(flume, x0), 0.0
    out = [flume.energy(y)]
    for _ in range(steps):
        y, direction = flume.advance(y, direction, step_s)
        out.append(flume.energy(y))
    return np.array(out)


def steep_wave(cell: Cell) -> tuple[np.ndarray, np.ndarray]:
    s = np.pi * cell.x / cell.width
    return 0.2 * cell.depth * np.sin(s), 0.03 * np.cos(3.0 * s) * np.sin(s)


@pytest.mark.parametrize("depth", [SHALLOW, BETWEEN, DEEP])
@pytest.mark.parametrize("number", [1, 3])
def test_still_cells_have_the_frequencies_and_masses_of_linear_theory(depth, number):
    found = coarse(depth).linear_modes(2)[(number - 1) // 2]
    theory = theory_mode(WIDTH, depth, number)
    assert found.frequency == pytest.approx(theory.frequency, rel=0.002)
    assert found.participating_area == pytest.approx(theory.participating_area, rel=0.01)


@pytest.mark.parametrize("depth", [SHALLOW, BETWEEN, DEEP])
def test_a_small_wave_marched_in_time_has_the_frequency_of_linear_theory(depth):
    theory = theory_mode(WIDTH, depth).frequency
    period = 2.0 * np.pi / theory
    time, surface = free_wave(coarse(depth), 0.002 * depth, 2.4 * period, period / 100.0, Losses())
    assert first_frequency(coarse(depth), time, surface) == pytest.approx(theory, rel=0.0005)


@pytest.mark.parametrize(("stiffness", "x0"), [(109_600.0, 1e-4), (403_000.0, 3e-5)])
def test_a_small_release_moves_as_with_linear_water_from_another_mesh_and_solver(stiffness, x0):
    structure = Structure(MASS, stiffness, 500.0, 0.0, 0.0)
    time = np.arange(0.0, 1.2, 0.02)
    ours = NonlinearFlume(structure, coarse(BETWEEN), LENGTH, Losses()).release(x0, 0.0, time)
    linear = Flume(structure, closed_cells(WIDTH, BETWEEN, LENGTH)).release(x0, 0.0, time)
    # two meshes: their first frequencies and masses differ by up to 0.2 % and 1 %
    assert np.max(np.abs(ours.x - linear.x)) < 0.01 * x0


@pytest.mark.parametrize(("depth", "sign"), [(SHALLOW, 1.0), (BETWEEN, -1.0), (DEEP, -1.0)])
def test_a_standing_wave_hardens_in_shallow_and_softens_in_deep_water(depth, sign):
    cell, amplitude = coarse(depth), 0.03 * WIDTH
    linear = cell.linear_modes(1)[0].frequency
    time, surface = free_wave(cell, amplitude, 6.2 * 2.0 * np.pi / linear, 2.0 * np.pi / linear / 100.0, Losses())
    change = first_frequency(cell, time, surface) / linear - 1.0
    theory = tadjbakhsh_keller(WIDTH, depth, amplitude)
    assert np.sign(change) == np.sign(theory) == sign
    # a wave let go from a sine carries a free second harmonic, which third-order standing waves lack: least where deep
    assert change == pytest.approx(theory, rel=0.01 if depth == DEEP else 0.2)


def test_the_surface_force_is_the_exact_derivative_of_the_kinetic_energy():
    cell = coarse(BETWEEN)
    eta, p = steep_wave(cell)
    direction = 1e-3 * np.random.default_rng(4).standard_normal(eta.size)
    ahead, behind = cell.flow(eta + 1e-4 * direction, p), cell.flow(eta - 1e-4 * direction, p)
    difference = (ahead.flux - behind.flux) / 2e-4
    here = cell.flow(eta, p)
    # central difference: its own error is a few 1e-8
    assert 0.5 * p @ difference == pytest.approx(here.push @ direction, rel=1e-6)
    assert cell.x @ difference == pytest.approx(here.cross @ direction, rel=1e-6)


def test_no_water_enters_or_leaves_a_steep_cell():
    cell = coarse(SHALLOW)
    eta, p = steep_wave(cell)
    flux = cell.flow(eta, p).flux
    assert abs(flux.sum()) < 1e-12 * np.abs(flux).max()
    flume = NonlinearFlume(Structure(MASS, 109_600.0, 0.0, 0.0, 0.0), cell, LENGTH)
    y, _ = flume.advance(released(flume, 0.02), 0.0, 1.0)
    surface = y[2 : 2 + flume.n]
    assert surface.max() > 0.15 * SHALLOW  # the wave is there
    assert abs((cell.mass @ surface).sum()) < 1e-12 * cell.area


@pytest.mark.parametrize(("stiffness", "x0"), [(109_600.0, 0.03), (403_000.0, 0.008)])
def test_without_losses_energy_is_kept_to_a_millionth(stiffness, x0):
    flume = NonlinearFlume(Structure(MASS, stiffness, 0.0, 0.0, 0.0), coarse(BETWEEN), LENGTH, Losses())
    energy = energies(flume, x0, 25, 0.05)
    assert np.max(np.abs(energy / energy[0] - 1.0)) < 1e-6


def test_losses_only_ever_take_energy_from_a_wave_that_breaks():
    cell = coarse(SHALLOW)
    flume = NonlinearFlume(Structure(MASS, 109_600.0, 0.0, 0.0, 0.0), cell, LENGTH)
    energy = energies(flume, 0.03, 100, 0.01)
    quiet = NonlinearFlume(flume.structure, cell, LENGTH, Losses(flume.losses.layer_rate))
    assert np.max(np.diff(energy)) < 1e-9 * energy[0]  # the step's own error
    assert energy[-1] < 0.98 * energies(quiet, 0.03, 100, 0.01)[-1]  # breaking took a part that layers alone leave


def test_layers_make_a_small_wave_decay_at_their_own_rate():
    cell = coarse(BETWEEN)
    period = 2.0 * np.pi / cell.linear_modes(1)[0].frequency
    rate = 0.05
    _, surface = free_wave(cell, 1e-4, 4.0 * period, period / 100.0, Losses(layer_rate=rate))
    first = surface @ cell.mass @ np.sin(np.pi * cell.x / cell.width)
    assert np.log(first[0] / first[400]) / (4.0 * period) == pytest.approx(rate, rel=0.01)


def test_momentum_of_body_and_water_changes_by_springs_alone():
    flume = NonlinearFlume(Structure(MASS, 0.0, 0.0, 0.0, 0.0), coarse(BETWEEN), LENGTH)
    y = released(flume, 0.0)
    y[1] = 0.15
    y[2 : 2 + flume.n], y[2 + flume.n :] = steep_wave(flume.cell)
    before = flume.momentum(y)
    after, _ = flume.advance(y, 1.0, 0.4)
    assert abs(after[1] - y[1]) > 0.02  # the wave has pushed the body
    assert flume.momentum(after) == pytest.approx(before, rel=1e-6)


def test_friction_holds_a_body_that_the_spring_cannot_move_and_its_water_stays_still():
    flume = NonlinearFlume(Structure(MASS, 109_600.0, 500.0, 100.0, 180.0), coarse(BETWEEN), LENGTH)
    held = flume.release(0.0016, 0.0, np.arange(0.0, 0.2, 0.05), keep_surface=True)
    assert np.all(held.x == 0.0016)
    assert np.max(np.abs(held.eta)) < 1e-12
    assert flume.release(0.0018, 0.0, np.arange(0.0, 0.2, 0.05)).x[-1] < 0.00178


def test_a_finer_mesh_moves_a_steep_wave_by_less_than_half_a_percent_of_its_height():
    period = 2.0 * np.pi / theory_mode(WIDTH, BETWEEN).frequency
    walls = []
    for elements, order in ((12, 6), (20, 8)):
        cell = Cell(WIDTH, BETWEEN, elements, order)
        walls.append(free_wave(cell, 0.03, 1.5 * period, period / 120.0, ordinary_losses(cell))[1][:, 0])
    assert np.max(np.abs(walls[0] - walls[1])) < 5e-3 * np.ptp(walls[1])


@pytest.mark.parametrize(("width", "depth", "elements"), [(-0.3, 0.1, 12), (0.3, 0.0, 12), (0.3, 0.1, 1)])
def test_a_cell_without_size_is_refused(width, depth, elements):
    with pytest.raises(ValueError, match=rf"cell of {width:g} m x {depth:g} m with {elements} elements.*be positive"):
        Cell(width, depth, elements)


def test_a_surface_on_the_floor_is_refused_with_both_depths():
    cell = coarse(SHALLOW)
    with pytest.raises(ValueError, match=r"the water is 0 m deep somewhere, rest 0\.07 m"):
        cell.flow(np.full(cell.x.size, -SHALLOW), np.zeros(cell.x.size))


def test_a_torn_surface_is_refused(monkeypatch):
    cell = coarse(SHALLOW)
    monkeypatch.setattr(nonlinear_water, "dpbtrf", lambda band, lower: (band, 7))
    with pytest.raises(ValueError, match=r"unknown 7 of 150 under the surface has no positive pivot.*0\.07 m"):
        cell.flow(np.zeros(cell.x.size), cell.x)


def test_a_record_of_half_a_period_has_no_frequency():
    cell = coarse(BETWEEN)
    time, surface = free_wave(cell, 0.001, 0.2, 0.005, Losses())
    with pytest.raises(ValueError, match=r"0\.2 s hold [01] falls through zero.*at least two periods"):
        first_frequency(cell, time, surface)
