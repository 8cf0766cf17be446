"""Stated errors of a structure's numbers: as large as repeated campaigns scatter, and larger where trials differ."""

import numpy as np
import pytest

from experiments.structure.truths import OtherBody
from tests.short_trials import LONG, group, per_mass, released
from undertow.comparison.stepwise_selection import Rules
from undertow.comparison.structure import Effort, find_structure, number_covariance
from undertow.conditioning.condition import condition
from undertow.equation.hydrodynamics import QuadraticDrag
from undertow.equation.structure import CoulombFriction, Stiffness, ViscousDamping
from undertow.uncertainty.robust import scatter_factor

EQ15 = (Stiffness(), ViscousDamping(), CoulombFriction(), QuadraticDrag())
ALONE = Effort(resamples=0, second_route=False)


def found(recordings):
    return find_structure([condition(one) for one in recordings], EQ15, Rules(known=(0, 1, 2, 3)), effort=ALONE)


@pytest.mark.slow
def test_stated_errors_are_the_scatter_of_repeated_campaigns():
    z = []
    for seed in range(10):
        structure = found(group(LONG, seed))
        z.append((structure.coefficients - per_mass(LONG)) / np.sqrt(np.diag(structure.covariance)))
    spread = np.sqrt(np.mean(np.square(z), axis=0))
    # chi of ten draws lies in 0.55 to 1.5 with 99 %; errors are on the wide side where trials scatter by chance
    assert np.all(spread > 0.45)
    assert np.all(spread < 1.5)


def test_trials_that_differ_widen_the_errors():
    own = list(vars(LONG).values())
    bodies = [OtherBody(*own[:2], own[2] * factor, *own[3:]) for factor in (0.997, 1.002, 1.004, 0.998)]
    pairs = zip(bodies, (0.03, 0.05, 0.07, 0.1), strict=True)
    differing = found([released(body, x0, f"d{index}", index) for index, (body, x0) in enumerate(pairs)])
    alike = found([released(LONG, x0, f"a{i}", i) for i, x0 in enumerate((0.03, 0.05, 0.07, 0.1))])
    assert number_covariance(differing.found)[1][0] > 3.0
    assert number_covariance(alike.found)[1][0] < 3.0
    assert differing.numbers["stiffness"].stderr > 5.0 * alike.numbers["stiffness"].stderr


def test_a_coefficient_on_its_bound_says_so():
    structure = find_structure(
        [condition(one) for one in group(OtherBody(LONG.inertia_kg, 590.0, 109592.0, 170.0, -400.0))],
        EQ15, Rules(known=(0, 1, 2, 3)), effort=ALONE,
    )  # fmt: skip
    assert structure.numbers["quadratic_drag"].outcome.startswith("on its bound 0 N s^2/m^2 / kg")
    assert structure.numbers["stiffness"].outcome == "ok"
    assert structure.numbers["stiffness"].value == pytest.approx(109592.0 / LONG.inertia_kg, rel=1e-3)


@pytest.mark.parametrize(("apart", "wider"), [(2.0, False), (30.0, True)])
def test_two_trials_widen_an_error_only_where_they_surely_differ(apart, wider):
    """Each trial's score in its own standard deviations: two apart is chance, thirty is not."""
    gram = np.array([[100.0]])
    moments = [np.array([10.0 * apart / 2.0]), np.array([-10.0 * apart / 2.0])]
    (factor,) = scatter_factor([gram, gram], [gram, gram], moments)
    assert (factor > 4.0) == wider
    assert factor == 1.0 or wider
