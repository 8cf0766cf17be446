"""Units at the door, against conversions that can be looked up."""

from __future__ import annotations

import math

import numpy as np
import pytest

from undertow.errors import RecordingError
from undertow.recording import units
from undertow.recording.unit_sizes import SIZES, Size
from undertow.recording.units import ARBITRARY_LENGTHS, ELECTRICAL, KNOWN, _parsed, _size, factor_to_si, si_unit, to_si

STANDARD_GRAVITY = 9.80665  # m/s^2, CGPM 1901


@pytest.mark.parametrize("spelling", ["mm/s2", "mm/s^2", "mm/s²", "mm s-2", "mm/s/s", "mm/s**2", "[mm/s2]", " mm/s2 "])
def test_every_spelling_of_an_acceleration_is_the_same(spelling: str) -> None:
    assert factor_to_si(spelling, "acceleration") == (pytest.approx(1e-3, rel=1e-12), "m/s^2")


@pytest.mark.parametrize(("spelling", "factor"), [("g", 1.0), ("G", 1.0), ("mg", 1e-3)])
def test_g_is_gravity_and_neither_gram_nor_gauss(spelling: str, factor: float) -> None:
    assert factor_to_si(spelling, "acceleration")[0] == pytest.approx(factor * STANDARD_GRAVITY, rel=1e-12)


def test_gal_is_a_centimetre_per_second_squared_and_no_gallon() -> None:
    assert factor_to_si("gal", "acceleration")[0] == pytest.approx(0.01, rel=1e-12)


@pytest.mark.parametrize("spelling", ["kN-m", "kN m", "kN·m", "kN.m", "kNm", "kN*m"])
def test_a_rotation_has_a_moment_for_a_spring_force(spelling: str) -> None:
    assert factor_to_si(spelling, "spring_force", "rotation") == (pytest.approx(1000.0), "N m")


@pytest.mark.parametrize("spelling", ["deg", "°", "degree", "degrees"])
def test_degrees_become_radians(spelling: str) -> None:
    values, unit = to_si([180.0], spelling, "displacement", "rotation")
    assert unit == "rad"
    assert values[0] == pytest.approx(math.pi, rel=1e-12)


def test_an_uncalibrated_displacement_keeps_its_own_scale() -> None:
    values, unit = to_si(np.array([4.7]), "% ", "displacement")
    assert (values[0], unit) == (4.7, "%")
    assert factor_to_si("px/s", "velocity") == (1.0, "px/s")


def test_conversion_leaves_the_values_it_was_given() -> None:
    given = np.array([1.0, 2.0])
    to_si(given, "mm", "displacement")
    assert given.tolist() == [1.0, 2.0]


@pytest.mark.parametrize("channel", sorted(KNOWN))
def test_every_spelling_that_is_offered_is_understood(channel: str) -> None:
    for unit in KNOWN[channel]:
        understood = 0
        for coordinate in ("translation", "rotation"):
            try:
                factor_to_si(unit, channel, coordinate)
            except RecordingError:
                continue
            understood += 1
        assert understood, unit


@pytest.mark.parametrize(
    ("channel", "unit", "near"), [("displacement", "mn", "mm"), ("spring_force", "mn", "mN"), ("time", "mz", "ms")]
)
def test_a_slip_of_one_letter_is_answered_with_the_unit_of_that_quantity(channel: str, unit: str, near: str) -> None:
    with pytest.raises(RecordingError, match=rf"unit {unit!r} is not known; the nearest known spelling is {near!r}"):
        factor_to_si(unit, channel)


def test_an_unknown_unit_is_answered_with_the_nearest_one() -> None:
    with pytest.raises(RecordingError, match=r"acceleration: unit 'm/s\^\^2' is not known.*nearest.*'m/s\^2'"):
        factor_to_si("m/s^^2", "acceleration")


def test_a_wrong_dimension_names_both_units() -> None:
    with pytest.raises(
        RecordingError, match=r"displacement is said to be in 'kN'.*a translation's displacement is in m"
    ):
        factor_to_si("kN", "displacement")


def test_an_angle_in_translation_points_to_the_coordinate() -> None:
    with pytest.raises(RecordingError, match=r"set equation.coordinate to rotation"):
        factor_to_si("deg", "displacement")


def test_hertz_is_no_angular_velocity() -> None:
    with pytest.raises(RecordingError, match=r"rotation's velocity is in rad/s"):
        factor_to_si("Hz", "velocity", "rotation")


def test_percent_is_no_angle() -> None:
    with pytest.raises(RecordingError, match=r"rotation's displacement is in rad"):
        factor_to_si("%", "displacement", "rotation")


def test_a_load_cell_in_kilograms_is_told_to_say_kgf() -> None:
    with pytest.raises(RecordingError, match=r"write 'kgf'"):
        factor_to_si("kg", "spring_force")


@pytest.mark.parametrize("text", ["", "m**9**9**9", "m^99", "m**(9)", "3 mm", "x" * 500, "__import__('os')"])
def test_no_text_hangs_or_breaks_the_parser(text: str) -> None:
    with pytest.raises(RecordingError, match=r"is not known"):
        factor_to_si(text, "displacement")


def test_si_units_follow_the_coordinate() -> None:
    assert si_unit("time", "rotation") == "s"
    assert si_unit("displacement", "rotation") == "rad"


@pytest.mark.parametrize("unit", SIZES)
def test_a_size_that_is_kept_is_what_the_parser_says_to_the_last_digit(unit: str) -> None:
    assert SIZES[unit] == _parsed(unit, unit, "displacement")


@pytest.mark.parametrize("channel", KNOWN)
def test_every_spelling_offered_is_read_without_the_parser(channel: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(unit: str, *_: str) -> Size:
        raise AssertionError(unit)

    monkeypatch.setattr(units, "_parsed", refuse)
    offered = [unit for unit in KNOWN[channel] if unit.partition("/")[0] not in (*ARBITRARY_LENGTHS, *ELECTRICAL)]
    assert all(_size(unit, channel).value > 0.0 for unit in offered)
