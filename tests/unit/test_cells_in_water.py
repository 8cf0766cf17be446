"""Load cells that show another spring in water than in air: kilograms would go with it."""

from __future__ import annotations

import pytest

from tests.findings_fixture import small_findings
from undertow.campaign.run.tasks import Dry, _another_spring
from undertow.likelihood.fit import Structure
from undertow.quantities import Estimate

K = 11_400.0


def dry(ratio: float, spread: float = 0.001, scatter: float = 0.002) -> Dry:
    """Four dry trials whose cells show so much of the motion's stiffness."""
    mean = Estimate(K, 30.0, unit="N/m")
    structure = Structure(mean, mean, mean, {"k": scatter, "c": 0.1, "mu": 0.1}, "", 3.0)
    fit = next(iter(small_findings().groups))
    return Dry(structure, Estimate(ratio, spread, unit="1"), {f"t{i}": fit for i in range(4)})


def slopes(*over: float) -> dict[str, Estimate]:
    """Stiffness by the cells of water's trials, over the motion's in air."""
    return {f"w{i}": Estimate(K * one, 10.0, unit="N/m") for i, one in enumerate(over)}


@pytest.mark.parametrize(
    ("ratio", "seen", "said"),
    [
        (0.952, (0.967, 0.968, 0.966, 0.967), "a spring 1.6 % stiffer than in air, where they show 4.8 % less than"),
        (1.05, (1.02, 1.021, 1.019, 1.02), "a spring 2.9 % softer than in air, where they show 5.0 % more than"),
        (0.952, (0.9595, 0.9605, 0.96, 0.96), ""),  # .8 %: springs and gains differ so from day to day
        (0.952, (0.952, 0.953, 0.951), ""),
        (0.952, (), ""),
    ],
)
def test_cells_that_show_another_spring_in_water_are_said_with_both_numbers(ratio, seen, said):
    found = _another_spring(dry(ratio), slopes(*seen))
    assert said in found
    assert bool(found) == bool(said)


def test_stiffness_that_scatters_as_much_is_no_other_spring():
    assert _another_spring(dry(0.952, scatter=0.02), slopes(0.967, 0.968, 0.966, 0.967)) == ""
    assert _another_spring(dry(0.952, spread=float("nan")), slopes(0.99, 0.99)) == ""
