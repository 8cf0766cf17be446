"""The regression: exact on exact motions, honest errors, the right terms and no others."""

import numpy as np
import pytest

from tests.exact_motions import LONG, SHORT, exact_group, exact_motion
from undertow.equation.hydrodynamics import AddedMass, CubicDamping, QuadraticDrag
from undertow.equation.structure import (
    AsymmetricStiffness,
    CoulombFriction,
    CubicStiffness,
    PositionDamping,
    QuadraticStiffness,
    Stiffness,
    VanDerPolDamping,
    ViscousDamping,
)
from undertow.errors import IdentificationError
from undertow.methods.library import build_design
from undertow.methods.sindy import discover, select_terms, solve_design
from undertow.uncertainty.robust import robust_covariance

EQ15 = (Stiffness(), ViscousDamping(), CoulombFriction(), QuadraticDrag())
RIVALS = (
    AsymmetricStiffness(), CubicStiffness(), QuadraticStiffness(), CubicDamping(), PositionDamping(),
    VanDerPolDamping(),
)  # fmt: skip
NAMES = {term.name for term in EQ15}


def truth(body):
    """Coefficients of Eq. 15 over the total mass."""
    forces = np.array([body.k_N_per_m, body.c_Ns_per_m, body.friction_N, body.drag_Ns2_per_m2])
    return forces / body.inertia_kg


@pytest.mark.parametrize("body", [LONG, SHORT], ids=["long", "short"])
def test_exact_motions_return_exact_coefficients_whatever_the_sensors_offsets(body):
    result = discover(exact_group(body, offset_m=0.002, a_offset=0.05), EQ15, subset=False)
    assert result.names == tuple(term.name for term in EQ15)
    assert result.coefficients == pytest.approx(truth(body), rel=1e-7)  # the integrator's tolerance is 1e-12
    # the rest position is known here, so that the constants are the accelerometer's offset alone
    assert result.constants == pytest.approx(-0.05, abs=1e-6)


@pytest.mark.slow
def test_standard_errors_match_the_scatter_of_repeated_campaigns():
    z = []
    for seed in range(40):
        result = discover(exact_group(LONG, a_noise=0.1, rate_hz=200.0, seed=seed), EQ15, subset=False)
        z.append((result.coefficients - truth(LONG)) / np.sqrt(np.diag(result.covariance)))
    spread = np.sqrt(np.mean(np.square(z), axis=0))
    # 40 draws give a standard deviation of 11 %; the errors are on the wide side by construction
    assert np.all(spread > 0.6)
    assert np.all(spread < 1.25)


def test_trials_that_differ_widen_the_error_and_equal_ones_do_not():
    bodies = [type(LONG)(3908.8, 590.0 * f, 109592.0 * g, 170.0, 3924.0) for f, g in
              ((0.8, 1.003), (1.1, 0.998), (1.2, 1.001), (0.9, 0.996))]  # fmt: skip
    scattered = [exact_motion(b, x0, f"r{i}", a_noise=0.02, seed=i) for i, (b, x0) in
                 enumerate(zip(bodies, (0.03, 0.05, 0.07, 0.1), strict=True))]  # fmt: skip
    stiffness = 0
    assert solve_design(build_design(scattered, EQ15)).widening[stiffness] > 2.0
    assert solve_design(build_design(exact_group(LONG, a_noise=0.02), EQ15)).widening[stiffness] < 2.5


@pytest.mark.parametrize("body", [LONG, SHORT], ids=["long", "short"])
def test_ten_term_library_keeps_equation_15s_four_terms(body):
    exact = 0
    for seed in range(6):
        found = discover(exact_group(body, a_noise=0.05, rate_hz=250.0, seed=seed), EQ15 + RIVALS)
        exact += set(found.names) == NAMES
    assert exact >= 5


def test_friction_that_is_not_there_is_not_found():
    body = type(LONG)(3908.8, 590.0, 109592.0, 1e-9, 3924.0)
    found = discover(exact_group(body, a_noise=0.05), EQ15 + RIVALS)
    assert set(found.names) == NAMES - {"coulomb_friction"}


def test_a_known_term_is_kept_though_the_data_do_not_ask_for_it():
    body = type(LONG)(3908.8, 590.0, 109592.0, 1e-9, 3924.0)
    found = discover(exact_group(body, a_noise=0.05), EQ15, known=[CoulombFriction()])
    assert "coulomb_friction" in found.names
    assert found.fit.per_mass["coulomb_friction"].outcome.startswith("not distinct from 0")


def test_a_coefficient_of_impossible_sign_is_said_and_not_selected():
    body = type(LONG)(3908.8, 590.0, 109592.0, 170.0, -900.0)
    group = exact_group(body, a_noise=0.01)
    fixed = discover(group, EQ15, subset=False)
    assert "below 0, which quadratic_drag cannot be" in fixed.fit.per_mass["quadratic_drag"].outcome
    assert "quadratic_drag" not in discover(group, EQ15).names
    free = select_terms(build_design(group, EQ15), EQ15, signs=False)
    assert free.support_[0, EQ15.index(QuadraticDrag())]


def test_added_mass_is_part_of_the_total_mass_and_no_column():
    result = discover(exact_group(), (*EQ15, AddedMass()), subset=False)
    assert result.names == tuple(term.name for term in EQ15)


def test_rate_of_sampling_does_not_change_the_verdict():
    found = {
        rate: discover(exact_group(a_noise=0.05 * np.sqrt(rate / 1000.0), rate_hz=rate), EQ15 + RIVALS)
        for rate in (1000.0, 100.0)
    }
    assert found[1000.0].names == found[100.0].names
    assert found[1000.0].n_effective == pytest.approx(found[100.0].n_effective, rel=1.2)


def test_each_trial_alone_gives_its_own_equation():
    each = [discover([motion], EQ15, subset=False) for motion in exact_group()]
    assert [result.fit.trials for result in each] == [("r0",), ("r1",), ("r2",), ("r3",)]
    for result in each:
        assert result.coefficients == pytest.approx(truth(LONG), rel=1e-6)


def test_a_pair_that_one_trial_cannot_tell_apart_is_noted():
    result = discover([exact_motion(LONG, 0.1, a_noise=0.05)], (*EQ15, CubicDamping()), subset=False)
    assert any("quadratic_drag and cubic_damping are hardly distinguishable" in note for note in result.fit.notes)


def test_coefficients_per_mass_name_their_unit():
    found = discover(exact_group(), EQ15, subset=False).fit.per_mass["stiffness"]
    assert found.unit == "N/m / kg"
    assert found.value == pytest.approx(truth(LONG)[0])


def test_requests_that_have_no_answer_are_refused():
    group = exact_group()
    with pytest.raises(IdentificationError, match=r"1 terms besides the mass; give at least one"):
        discover(group, (AddedMass(),))
    with pytest.raises(IdentificationError, match=r"known term 'cubic_damping' is not in the library stiffness"):
        discover(group, EQ15, known=["cubic_damping"])
    with pytest.raises(IdentificationError, match=r"rank \d+ of \d+; two of the terms are the same force"):
        discover(group, (Stiffness(), Stiffness()), subset=False)
    with pytest.raises(IdentificationError, match=r"the best of all subsets of asymmetric_stiffness is none of them"):
        discover([exact_motion(LONG, 0.1, a_noise=200.0)], (AsymmetricStiffness(),))


def test_robust_covariance_of_correlated_noise_is_the_scatter_of_means():
    rng = np.random.default_rng(0)
    means, claimed = [], []
    for _ in range(200):
        noise = np.convolve(rng.standard_normal(1019), np.ones(20) / 20.0, "valid")
        covariance, factor = robust_covariance([np.ones((1000, 1))], [noise - noise.mean()], block=60, nuisance=0)
        means.append(noise.mean())
        claimed.append(np.sqrt(covariance[0, 0]))
        assert factor.tolist() == [1.0]
    assert np.median(claimed) == pytest.approx(np.std(means), rel=0.2)  # Bartlett's window of 3 lengths loses 10 %
