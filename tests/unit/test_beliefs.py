"""What dry trials know enters a structure as values with errors, and pins down what water alone leaves open."""

import numpy as np
import pytest

import undertow
from experiments.structure.truths import OtherBody
from tests.short_trials import group, per_mass
from undertow.comparison.beliefs import Belief
from undertow.comparison.dry_beliefs import from_dry
from undertow.comparison.laws import laws
from undertow.comparison.stepwise_selection import Rules
from undertow.comparison.structure import Effort, find_structure
from undertow.conditioning.condition import condition
from undertow.equation.hydrodynamics import DragExponent
from undertow.equation.structure import CoulombFriction, Stiffness, ViscousDamping
from undertow.errors import IdentificationError

STRUCTURAL = (Stiffness(), ViscousDamping(), CoulombFriction())
POWER = (*STRUCTURAL, DragExponent())
ALONE = Effort(resamples=0, second_route=False)
DRY = OtherBody(2637.4, 590.0, 109592.0, 200.0, 0.0)
WET = OtherBody(3908.8, 590.0, 109592.0, 170.0, 0.0, power_N=2000.0, exponent=1.5)
"""The same body in water: more mass, friction less by buoyancy, drag between linear and quadratic."""


@pytest.fixture(scope="module")
def dry():
    return find_structure(
        [condition(one) for one in group(DRY, seed=3)], STRUCTURAL, Rules(known=(0, 1, 2)), effort=ALONE
    )


def wet(beliefs):
    return find_structure(
        [condition(one) for one in group(WET, seed=5)], POWER, Rules(known=(0, 1, 2, 3), beliefs=beliefs), effort=ALONE
    )


def test_a_dry_ratio_to_the_stiffness_holds_in_water_within_its_error(dry):
    beliefs = from_dry(dry, ("viscous_damping", "coulomb_friction"), {"coulomb_friction": 170.0 / 200.0})
    book = laws(STRUCTURAL, beliefs=beliefs)
    rows, values = book.believed()
    away = rows @ per_mass(WET)[:3] - values
    assert np.all(np.abs(away) < 3.5)  # two standard normals, narrower in water by the added mass
    wrong = rows @ (per_mass(WET)[:3] * [1.0, 1.2, 1.0]) - values
    assert np.max(np.abs(wrong)) > 5.0  # a fifth more damping contradicts the dry trials


def test_an_exponent_is_known_several_times_better_beside_dry_trials(dry):
    alone, beside = (wet(beliefs).numbers["drag_exponent.exponent"] for beliefs in ((), from_dry(dry)))
    assert beside.stderr < 0.5 * alone.stderr
    assert abs(beside.value - 1.5) < 4.0 * beside.stderr


def test_a_certain_belief_is_obeyed_and_a_vague_one_changes_nothing():
    certain = wet((Belief({"viscous_damping": 1.0}, 0.30, 1e-6),)).numbers["viscous_damping"]
    assert certain.value == pytest.approx(0.30, abs=1e-4)
    plain, vague = wet(()), wet((Belief({"viscous_damping": 1.0}, 0.30, 1e3),))
    assert vague.coefficients == pytest.approx(plain.coefficients, rel=1e-3)


def test_the_report_says_what_was_known_beforehand(dry):
    motions = [condition(one) for one in group(WET, seed=5)]
    terms = ("stiffness", "viscous_damping", "coulomb_friction", "drag_exponent")
    one = undertow.Discover(terms, known=terms, beliefs=from_dry(dry), resamples=0, outside=False).fit(motions)
    assert "known beforehand (dry trials r0, r1, r2): stiffness, viscous_damping" in one.fit_report()


def test_beliefs_that_say_nothing_are_refused(dry):
    with pytest.raises(IdentificationError, match=r"a belief about \{\}; give finite weights"):
        Belief({}, 0.0, 1.0)
    with pytest.raises(IdentificationError, match=r"a belief about viscous_damping of 0.2 \+- 0; give a finite value"):
        Belief({"viscous_damping": 1.0}, 0.2, 0.0)
    with pytest.raises(IdentificationError, match=r"a belief names 'cubic_damping', which is not in the library stiff"):
        laws(STRUCTURAL, beliefs=[Belief({"cubic_damping": 1.0}, 0.0, 1.0)])
    with pytest.raises(IdentificationError, match=r"holds stiffness, viscous_damping, .* and not quadratic_drag"):
        from_dry(dry, ("quadratic_drag",))
