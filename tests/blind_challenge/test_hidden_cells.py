"""Steep water in cells: its linear limit, its energy, and that it is not linear where it is steep."""

import math

import numpy as np
import pytest

from experiments.blind_challenge.truths import cells, codes
from experiments.blind_challenge.truths.motion import Body, Law, resonator, simulate

LENGTH, DEPTH, BREADTH, GRAVITY = 4.0, 1.2, 0.05, 9.81
BODY = Body(1.0, 0.0, 4.0, 0.0, 0.0)
STEP = 2.0 * math.pi / BODY.frequency / 100.0


def water(damping: float = 0.0, modes: int = 4) -> Law:
    """A cell at rest."""
    numbers = cells.cell_numbers(LENGTH, DEPTH, BREADTH, GRAVITY, damping, modes)
    return Law(codes.CELL, tuple(numbers), (0.0,) * (2 * modes), (1.0,) * (2 * modes))


def test_small_water_is_its_linear_modes_and_the_mass_that_moves_with_the_body() -> None:
    damping, modes = 0.02, 4
    x0 = 1e-4
    steep = simulate(BODY, (water(damping),), x0, 600, STEP)
    linear = []
    rest = BREADTH * LENGTH * DEPTH
    for n in (1, 3):
        mass = cells.cell_mass(LENGTH, DEPTH, BREADTH, n)
        rest -= mass
        linear.append(resonator(mass, cells.cell_frequency(LENGTH, DEPTH, GRAVITY, n), damping, scale=x0))
    plain = simulate(BODY.changed(mass=1.0 + rest), tuple(linear), x0, 600, STEP)
    assert modes == 4
    assert np.max(np.abs(steep.x - plain.x)) / x0 < 2e-4  # second order in the surface over the depth


def test_water_without_damping_keeps_the_energy_of_body_and_water() -> None:
    motion = simulate(BODY, (water(),), 0.12, 400, STEP)
    numbers = np.array(water().numbers)
    energy = []
    for v, x, h in zip(motion.v, motion.x, motion.hidden, strict=True):
        shape = np.zeros((int(numbers[1]), 4))
        d, a, _, _ = cells._integrals(np.ascontiguousarray(h), 0, numbers, 0, shape, shape.copy())
        flow = np.linalg.solve(d, a @ h[4:])
        n = np.arange(1, 5)
        lever = BREADTH * LENGTH**2 * ((-1.0) ** n - 1.0) / (n * math.pi) ** 2
        kinetic = 0.5 * BREADTH * LENGTH * DEPTH * v**2 + v * lever @ flow + 0.5 * h[4:] @ a @ h[4:]
        height = BREADTH * GRAVITY * LENGTH / 4.0 * h[:4] @ h[:4]
        energy.append(0.5 * v**2 + 2.0 * x**2 + kinetic + height)
    assert np.max(np.abs(motion.hidden[:, 0])) > 0.15 * DEPTH  # steep enough to matter
    assert np.ptp(energy) / energy[0] < 1e-5


def test_steep_water_is_not_its_linear_modes() -> None:
    small, large = (simulate(BODY, (water(0.01),), x0, 500, STEP).x / x0 for x0 in (1e-4, 0.12))
    assert np.max(np.abs(small - large)) > 0.005


def test_the_participating_mass_of_an_even_mode_is_nothing() -> None:
    assert cells.cell_mass(LENGTH, DEPTH, BREADTH, 2) == 0.0


def test_the_modes_of_a_cell_together_hold_less_than_its_water() -> None:
    total = sum(cells.cell_mass(LENGTH, DEPTH, BREADTH, n) for n in range(1, 60, 2))
    assert total < BREADTH * LENGTH * DEPTH
    assert cells.cell_frequency(LENGTH, 50.0, GRAVITY) == pytest.approx(math.sqrt(GRAVITY * math.pi / LENGTH))
