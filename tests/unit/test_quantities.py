"""Numbers keep the digits that their errors allow."""

from __future__ import annotations

import math

import pytest

from undertow.quantities import Estimate, Parameter, format_estimate, format_number, significant_decimals


@pytest.mark.parametrize(
    ("error", "decimals"),
    [(12.2, 0), (0.044, 2), (29.0, 0), (31.0, -1), (0.0299, 3), (0.03, 2), (2.99, 1), (3.0, 0), (1500.0, -2)],
)
def test_errors_below_thirty_keep_two_digits_and_others_one(error, decimals):
    assert significant_decimals(error) == decimals


@pytest.mark.parametrize("error", [0.0, -1.0, math.nan, math.inf])
def test_no_usable_error_gives_no_digits(error):
    assert significant_decimals(error) is None


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (1271.43, 12.2, "1271"),
        (0.66172, 0.0044, "0.662"),
        (109612.3, 310.0, "109600"),
        (109600.0, math.nan, "109600"),
        (402036.4, math.nan, "402040"),
        (2e6, math.nan, "2000000"),
        (4e7, math.nan, "4e+07"),
        (0.000123456, math.nan, "0.00012346"),
        (-0.0, 1.0, "0.0"),
        (math.inf, 1.0, "not finite"),
        (math.nan, 1.0, "-"),
    ],
)
def test_a_number_has_the_digits_of_its_error_or_five(value, error, text):
    assert format_number(value, error) == text


def test_estimate_prints_both_errors_and_the_unit():
    assert str(Estimate(1271.43, 12.2, 8.0, unit="kg")) == "1271 ± 12 (noise) ± 8 (systematic) kg"


def test_estimate_with_noise_alone_prints_one_error():
    assert format_estimate(Estimate(9.6123, 0.014, unit="rad/s")) == "9.612 ± 0.014 rad/s"


def test_a_pure_number_has_no_unit():
    assert format_estimate(Estimate(1.6168, 0.0051, unit="1")) == "1.617 ± 0.005"


def test_estimate_without_noise_error_prints_its_systematic_one():
    assert format_estimate(Estimate(3924.0, math.nan, 120.0, unit="N s^2/m^2")) == (
        "3920 ± 120 (systematic) N s^2/m^2"
    )


def test_a_number_taken_over_from_another_fit_prints_its_systematic_error_alone():
    assert format_estimate(Estimate(2414000.0, 6e-30, 12000.0, unit="N/m")) == "2414000 ± 12000 (systematic) N/m"
    assert "(noise)" in format_estimate(Estimate(2414000.0, 6.0, 12000.0, unit="N/m"))


def test_an_error_of_rounding_alone_is_not_printed():
    assert format_estimate(Estimate(0.0620991929, 4e-23, unit="N")) == "0.062099 N"
    assert format_estimate(Estimate(0.0620991929, 4e-9, unit="N")) == "0.062099193 ± 0.000000004 N"


def test_total_error_adds_both_parts_in_quadrature():
    assert Estimate(1.0, 3.0, 4.0).total_stderr == pytest.approx(5.0)


def test_scaling_by_a_negative_factor_keeps_errors_positive():
    scaled = Estimate(2.0, 0.3, 0.1, unit="N").scaled(-10.0, "dN")
    assert (scaled.value, scaled.stderr, scaled.systematic, scaled.unit) == pytest.approx((-20.0, 3.0, 1.0, "dN"))


def test_an_estimate_cannot_be_edited():
    with pytest.raises(AttributeError, match="cannot assign to field 'value'"):
        Estimate(1.0).value = 2.0


def test_a_parameter_without_bounds_may_take_any_value():
    free = Parameter("stiffness", "N/m", "k")
    assert (free.lower, free.upper) == (-math.inf, math.inf)
