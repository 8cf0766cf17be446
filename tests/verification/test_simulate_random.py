"""A slice of experiments/integrator: one random equation of each kind against the independent reference."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from experiments.integrator.accuracy import KINDS, errors_of, random_case

TABLE = Path(__file__).resolve().parents[2] / "experiments" / "integrator" / "accuracy.csv"


@pytest.mark.parametrize("number", range(len(KINDS)), ids=KINDS)
def test_random_equation_agrees_with_the_reference(number):
    row = errors_of(number)
    # what simulate promises: 1e-5 of x0 at its default of 60 steps a period, 1e-7 at 200
    assert row["error_60"] < 1e-5
    assert row["error_200"] < 1e-7


def test_the_slice_holds_bodies_that_stick_and_bodies_that_start_again():
    rows = _committed()[: len(KINDS)]
    assert sum(float(row["share_at_rest"]) > 0.0 for row in rows) >= 5
    assert any(int(row["starts_again"]) > 0 for row in rows)


def test_light_cases_have_half_a_percent_of_damping():
    _, equation, _ = random_case(KINDS.index("light"))
    k, c = equation.coefficients[:2]
    assert c / (2.0 * (k * equation.mass_kg) ** 0.5) == pytest.approx(0.005)


def test_the_committed_table_keeps_the_promise_for_every_equation():
    rows = _committed()
    assert len(rows) >= 300
    assert max(float(row["error_60"]) for row in rows) < 1e-5
    assert max(float(row["error_200"]) for row in rows) < 1e-7


def _committed() -> list[dict[str, str]]:
    with TABLE.open() as file:
        return list(csv.DictReader(file))
