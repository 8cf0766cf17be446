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
from undertow.methods.library import DRIFT_ORDER, TermLibrary, build_design, evaluate, label, motion_period
from undertow.methods.subset import BestSubset

EQ15 = (Stiffness(), ViscousDamping(), CoulombFriction(), QuadraticDrag())


def truth(body=LONG):
    """Coefficients of Eq. 15 over the total mass."""
    forces = np.array([body.k_N_per_m, body.c_Ns_per_m, body.friction_N, body.drag_Ns2_per_m2])
    return forces / body.inertia_kg


@pytest.mark.parametrize("periods", [0.05, 0.5])
@pytest.mark.parametrize("rate_hz", [1000.0, 250.0, 100.0])
def test_equation_15_holds_row_by_row_at_every_rate(rate_hz, periods):
    design = build_design(exact_group(rate_hz=rate_hz), EQ15, periods)
    # a test function averages the equation itself, linear in columns and response: only the integrator's error is left
    assert np.abs(design.columns @ truth() - design.response).max() < 1e-8


def test_rows_do_not_depend_on_the_sampling_rate():
    fast = build_design([exact_motion(LONG, 0.1, rate_hz=1000.0)], EQ15)
    slow = build_design([exact_motion(LONG, 0.1, rate_hz=200.0)], EQ15)
    assert abs(fast.response.size - slow.response.size) <= 1
    at = np.interp(slow.time, fast.time, fast.columns[:, 0])
    assert at == pytest.approx(slow.columns[:, 0], abs=2e-3)  # interpolation between rows a tenth of a period apart


def test_no_test_function_reaches_out_of_the_window():
    motion = exact_motion(LONG, 0.1)
    design = build_design([motion], EQ15, 0.5)
    inside = motion.windowed("t")
    assert design.length_s == pytest.approx(0.5 * design.period_s)
    assert design.time.min() - 0.5 * design.length_s >= inside[0] - 0.002
    assert design.time.max() + 0.5 * design.length_s <= inside[-1] + 0.002


def test_period_is_that_of_the_body():
    period = 2.0 * np.pi * np.sqrt(LONG.inertia_kg / LONG.k_N_per_m)
    assert motion_period(exact_motion(LONG, 0.1)) == pytest.approx(period, rel=0.1)  # v^2 and a^2 fade unequally


def test_each_trial_has_its_own_constant_and_drift():
    group = exact_group()
    design = build_design(group, EQ15)
    assert design.trials == ("r0", "r1", "r2", "r3")
    assert design.nuisance.shape == (design.response.size, 4 * (DRIFT_ORDER + 1))
    first = design.trial == 0
    assert np.all(design.nuisance[~first][:, [0, 4]] == 0.0)
    assert np.all(design.nuisance[:, :4].sum(axis=1) == 1.0)
    assert sum(design.lengths) == design.response.size


def test_a_wrong_equilibrium_is_taken_up_by_the_constant_for_a_linear_spring():
    motion = exact_motion(LONG, 0.1, offset_m=0.003)
    object.__setattr__(motion, "equilibrium", type(motion.equilibrium)(0.0, 1e-3, unit="m"))
    design = build_design([motion], EQ15)
    missing = design.response - design.columns @ truth()
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


def test_library_runs_inside_plain_pysindy_that_differentiates_itself_on_several_trajectories():
    parts = [exact_motion(LONG, x0) for x0 in (0.05, 0.1)]
    states = [np.column_stack([motion.windowed("x"), motion.windowed("v")]) for motion in parts]
    model = pysindy.SINDy(feature_library=TermLibrary(EQ15), optimizer=BestSubset())
    model.fit(states, t=0.001)
    # central differences of v straddle friction's step: two hundredths of a coefficient
    assert model.coefficients()[1] == pytest.approx(-truth(), rel=0.05)


@pytest.mark.parametrize("beside", [pysindy.ConcatLibrary, pysindy.GeneralizedLibrary])
def test_library_stands_beside_another_library_of_pysindy(beside):
    parts = [exact_motion(LONG, x0, a_noise=0.01) for x0 in (0.05, 0.1)]
    states = [np.column_stack([motion.windowed("x"), motion.windowed("v")]) for motion in parts]
    rates = [np.column_stack([motion.windowed("v"), motion.windowed("a")]) for motion in parts]
    columns = beside([TermLibrary(EQ15[1:]), pysindy.PolynomialLibrary(degree=1, include_bias=False)])
    model = pysindy.SINDy(feature_library=columns, optimizer=pysindy.STLSQ(threshold=1e-3))
    model.fit(states, t=0.001, x_dot=rates, feature_names=["x", "v"])
    assert model.get_feature_names() == [*(term.name for term in EQ15[1:]), "x", "v"]
    assert model.coefficients()[1][3] == pytest.approx(-truth()[0], rel=0.01)  # noise .01 of 2.8 m/s^2


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
    with pytest.raises(NotFittedError, match="is not fitted"):
        TermLibrary(EQ15).transform(np.ones((3, 2)))


def test_designs_that_cannot_be_built_are_refused_with_the_number():
    with pytest.raises(IdentificationError, match=r"0 motions; give at least one trial"):
        build_design([], EQ15)
    with pytest.raises(IdentificationError, match=r"trial r1: \d rows .* test functions of 0\.\d+ s; 10 are needed"):
        build_design([exact_motion(LONG, 0.018, duration_s=0.9)], EQ15)


def test_evaluate_gives_one_column_a_term_in_order():
    ones = np.ones(3)
    columns = evaluate(EQ15, 2.0 * ones, -3.0 * ones, ones, ones)
    assert columns[0].tolist() == [2.0, -3.0, -1.0, -9.0]
    assert len(RELEASES_M) == 4
