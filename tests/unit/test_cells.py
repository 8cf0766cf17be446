"""Closed cells against limits that anyone can work out."""

from __future__ import annotations

import math

import numpy as np
import pytest

from undertow.equation.cells import GRAVITY_M_PER_S2, CellModes, closed_cell
from undertow.errors import UndertowError


def apparent_mass_kg(modes: CellModes, frequency_rad_per_s: float) -> float:
    """Mass that a body swaying at this frequency feels, kg: rigid + sum m_n / (1 - w^2 / w_n^2); no damping."""
    ratio = (frequency_rad_per_s / modes.frequencies_rad_per_s) ** 2
    return modes.rigid_mass_kg + float(np.sum(modes.masses_kg / (1.0 - ratio)))


def test_a_slow_sway_carries_all_the_water():
    modes = closed_cell(0.33, 0.14, 16.5)
    # the eight modes and the rigid rest are the whole by construction; at zero frequency nothing is amplified
    assert apparent_mass_kg(modes, 0.0) == pytest.approx(modes.water_kg, rel=1e-12)


def test_a_body_below_the_first_mode_feels_more_than_the_water_and_above_it_less():
    modes = closed_cell(0.33, 0.14, 16.5)
    first = float(modes.frequencies_rad_per_s[0])
    assert apparent_mass_kg(modes, 0.8 * first) > modes.water_kg
    assert apparent_mass_kg(modes, 1.2 * first) < 0.0


def test_the_first_mode_of_deep_water_is_that_of_a_wave_of_twice_the_width():
    modes = closed_cell(0.33, 3.3, 1.0)
    assert modes.frequencies_rad_per_s[0] == pytest.approx(math.sqrt(GRAVITY_M_PER_S2 * math.pi / 0.33), rel=1e-8)


def test_shallow_water_goes_by_the_shallow_wave_speed_and_takes_8_over_pi_squared_of_the_mass():
    modes = closed_cell(1.0, 0.001, 1.0)
    wave = math.pi * math.sqrt(GRAVITY_M_PER_S2 * 0.001)
    assert modes.frequencies_rad_per_s[0] == pytest.approx(wave, rel=1e-5)  # tanh(kh) = kh to (kh)^2 / 3 = 3e-6
    assert modes.masses_kg[0] / modes.water_kg == pytest.approx(8.0 / math.pi**2, rel=1e-5)


def test_modes_rise_and_hold_less_and_less_water():
    modes = closed_cell(0.33, 0.14, 16.5)
    assert np.all(np.diff(modes.frequencies_rad_per_s) > 0.0)
    assert np.all(np.diff(modes.masses_kg) < 0.0)
    assert modes.masses_kg[-1] < 1e-3 * modes.water_kg


@pytest.mark.parametrize(("width", "depth", "length"), [(0.0, 0.1, 1.0), (0.3, -0.1, 1.0), (0.3, 0.1, math.nan)])
def test_lengths_that_are_none_are_refused(width, depth, length):
    with pytest.raises(UndertowError, match=r"cell (width|depth|length) is .* m; it must be positive"):
        closed_cell(width, depth, length)
