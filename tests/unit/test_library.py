"""Columns of a regression: the terms' own forces, averaged over cells without loss, inside the window only."""

import numpy as np
import pysindy
import pytest
from sklearn.base import clone
from sklearn.exceptions import NotFittedError

from tests.exact_motions import LONG, RELEASES_M, exact_group, exact_motion
from undertow.equation.hydrodynamics import AddedMass, DragExponent, QuadraticDrag
from undertow.equation.structure import CoulombFriction, Stiffness, ViscousDamping
from undertow.errors import IdentificationError
from undertow.identification.library import TermLibrary, build_design, evaluate, label
from undertow.identification.subset import BestSubset

EQ15 = (Stiffness(), ViscousDamping(), CoulombFriction(), QuadraticDrag())


def truth(body=LONG):
    """Coefficients of Eq. 15 over the total mass."""
    forces = np.array([body.k_N_per_m, body.c_Ns_per_m, body.friction_N, body.drag_Ns2_per_m2])
    return forces / body.inertia_kg


@pytest.mark.parametrize("rate_hz", [1000.0, 250.0, 100.0])
def test_equation_15_holds_row_by_row_at_every_rate(rate_hz):
    design = build_design(exact_group(rate_hz=rate_hz), EQ15)
    # cells average the equation itself, which is linear in columns and response: only the integrator's error is left
    assert np.abs(design.columns @ truth() - design.response).max() < 1e-8


def test_rows_cost_no_more_at_1_khz_than_at_200_hz():
    fast = build_design([exact_motion(LONG, 0.1, rate_hz=1000.0)], EQ15)
    slow = build_design([exact_motion(LONG, 0.1, rate_hz=200.0)], EQ15)
    assert fast.cell_s == pytest.approx(0.005)
    assert abs(fast.response.size - slow.response.size) <= 1


def test_rows_that_are_not_used_are_zero_and_slower_than_the_cut():
    motion = exact_motion(LONG, 0.1)
    design = build_design([motion], EQ15, slow_share=0.2, drift_order=0)
    assert 0.3 < design.used.mean() < 0.7  # the last cycles are slower than a fifth of the first throughout
    assert np.all(design.columns[~design.used] == 0.0)
    assert np.all(design.response[~design.used] == 0.0)
    fastest = np.abs(motion.windowed("v")).max()
    assert np.abs(design.columns[design.used, 1]).min() >= 0.2 * fastest
    assert design.time.min() >= motion.window.start_s - motion.window.release_s


def test_each_trial_has_its_own_constant_and_drift():
    group = exact_group()
    design = build_design(group, EQ15, drift_order=1)
    assert design.trials == ("r0", "r1", "r2", "r3")
    assert design.nuisance.shape == (design.used.size, 8)
    first = design.trial == 0
    assert np.all(design.nuisance[~first][:, [0, 4]] == 0.0)
    assert np.array_equal(design.nuisance[:, :4].sum(axis=1), design.used.astype(float))
    assert sum(design.lengths) == design.response.size


def test_a_wrong_equilibrium_is_taken_up_by_the_constant_for_a_linear_spring():
    motion = exact_motion(LONG, 0.1, offset_m=0.003)
    object.__setattr__(motion, "equilibrium", type(motion.equilibrium)(0.0, 1e-3, unit="m"))
    design = build_design([motion], EQ15, drift_order=0)
    missing = design.response[design.used] - (design.columns @ truth())[design.used]
    assert missing == pytest.approx(-0.003 * LONG.k_N_per_m / LONG.inertia_kg, abs=1e-8)


def test_a_label_carries_inner_parameters_so_that_two_exponents_stay_apart():
    assert label(Stiffness()) == "stiffness"
    assert label(DragExponent(1.5)) != label(DragExponent(1.8))


def test_library_runs_inside_plain_pysindy_and_finds_equation_15():
    motion = exact_motion(LONG, 0.1, a_noise=0.01)
    states = np.column_stack([motion.windowed("x"), motion.windowed("v")])
    rates = np.column_stack([motion.windowed("v"), motion.windowed("a")])
    model = pysindy.SINDy(feature_library=TermLibrary(EQ15), optimizer=BestSubset())
    model.fit(states, t=0.001, x_dot=rates, feature_names=["x", "v"])
    assert model.get_feature_names() == [term.name for term in EQ15]
    assert model.coefficients()[1] == pytest.approx(-truth(), rel=0.02)  # noise .01 of 2.8 m/s^2 over 8000 rows
    assert model.coefficients()[0].tolist() == pytest.approx([0.0, 1.0, 0.0, 0.0], abs=1e-8)


def test_library_takes_the_measured_acceleration_as_a_third_column():
    library = TermLibrary((AddedMass(), Stiffness()))
    states = np.array([[0.1, 1.0, -3.0], [0.2, 2.0, -4.0]])
    assert library.fit_transform(states).tolist() == [[-3.0, 0.1], [-4.0, 0.2]]
    several = library.transform([states, states[:1]])
    assert [part.shape for part in several] == [(2, 2), (1, 2)]
    assert clone(library).terms == library.terms


def test_a_term_without_its_acceleration_is_named():
    with pytest.raises(IdentificationError, match=r"added_mass is not finite at 2 of 2 samples; give the acceleration"):
        TermLibrary((AddedMass(),)).fit_transform(np.ones((2, 2)))


def test_library_refuses_no_terms_wrong_shapes_and_use_before_fit():
    with pytest.raises(IdentificationError, match=r"TermLibrary has 0 terms"):
        TermLibrary().fit(np.ones((3, 2)))
    with pytest.raises(IdentificationError, match=r"input of shape \(3, 4\); give columns x and v"):
        TermLibrary(EQ15).fit(np.ones((3, 4)))
    with pytest.raises(NotFittedError):
        TermLibrary(EQ15).transform(np.ones((3, 2)))


def test_designs_that_cannot_be_built_are_refused_with_the_number():
    with pytest.raises(IdentificationError, match=r"0 motions; give at least one trial"):
        build_design([], EQ15)
    with pytest.raises(IdentificationError, match=r"trial r1: \d+ cells of 50 ms .* 20 are needed"):
        build_design([exact_motion(LONG, 0.018, rate_hz=1000.0, duration_s=0.9)], EQ15, cell_rate_hz=20.0)
    mixed = [exact_motion(LONG, 0.1, "fast", rate_hz=200.0), exact_motion(LONG, 0.1, "slow", rate_hz=50.0)]
    with pytest.raises(IdentificationError, match=r"trial slow gives a row every 0\.02 s, fast every 0\.005 s"):
        build_design(mixed, EQ15)


def test_evaluate_gives_one_column_a_term_in_order():
    ones = np.ones(3)
    columns = evaluate(EQ15, 2.0 * ones, -3.0 * ones, ones, ones)
    assert columns[0].tolist() == [2.0, -3.0, -1.0, -9.0]
    assert len(RELEASES_M) == 4
