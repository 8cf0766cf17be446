"""A slice of the hidden-state study, and its committed tables against the limits set beforehand."""

import dataclasses
import math

import numpy as np
import pytest

from experiments.eq15_campaign.motion import Body
from experiments.eq15_campaign.motion import simulate as simulate_eq15
from experiments.hidden_states import page, study
from experiments.hidden_states.campaigns import (
    NULLS,
    PLANTED,
    RELEASES_M,
    STIFFNESS_N_PER_M,
    baseline,
    null,
    plant,
    planted,
)
from experiments.hidden_states.motion import Oscillator, Plant, simulate
from undertow.comparison.hidden_fit import discover_hidden, fit_hidden, hidden_problem, without_unconfirmed
from undertow.comparison.hidden_rows import hidden_rows
from undertow.comparison.hidden_search import EQUATION_15, RIVALS, find_hidden
from undertow.conditioning.condition import condition
from undertow.equation.equation import Equation
from undertow.equation.hidden import HiddenResonator
from undertow.equation.registry import find
from undertow.equation.simulate import simulate as simulate_ours
from undertow.equation.structure import Stiffness
from undertow.errors import IdentificationError
from undertow.methods.library import build_design


@pytest.fixture(scope="module")
def campaign():
    """60 kg of hidden water under ordinary noise, with its conditioned trials."""
    made = planted("60 kg", "N3", 0)
    return made, [condition(recording) for recording in made.recordings]


@pytest.fixture(scope="module")
def fit(campaign):
    return discover_hidden(campaign[1])


def test_the_planted_motion_without_hidden_states_is_that_of_the_default_campaign():
    truth, times = baseline(), np.arange(6000) / 1000.0
    x, a = simulate(truth, RELEASES_M[1], times)
    other = simulate_eq15(
        Body(truth.inertia_kg, truth.c, truth.k, truth.friction_N, truth.drag), RELEASES_M[1], times
    )
    # two tolerances of DOP853, 1e-9 and 1e-12, over six seconds
    assert np.max(np.abs(x - other.x)) < 1e-9
    assert np.max(np.abs(a - other.a)) < 1e-6


def test_the_planted_motion_with_hidden_states_is_that_of_the_compiled_integrator():
    truth, times = plant("two of 200 kg"), np.arange(1, 5000) / 1000.0
    names = ("stiffness", "viscous_damping", "coulomb_friction", "quadratic_drag")
    terms = (*(find(name) for name in names), *(HiddenResonator(o.w, o.zeta) for o in truth.hidden))
    values = (truth.k, truth.c, truth.friction_N, truth.drag, *(o.mass_kg for o in truth.hidden))
    ours = simulate_ours(Equation(terms, values, mass_kg=truth.inertia_kg), RELEASES_M[1], times)
    x, _ = simulate(truth, RELEASES_M[1], times)
    # the compiled integrator's stated error, 1e-5 of x0
    assert np.max(np.abs(x - ours.x)) < 1e-5 * RELEASES_M[1]


def test_water_that_still_moves_pulls_a_stuck_body_loose_again():
    swinging = Oscillator(300.0, 9.6, 0.001)
    times = np.arange(0.0, 12.0, 0.001)
    body = Plant(3000.0, 800.0, 404000.0, 400.0, 3880.0, hidden=(swinging,))
    x, _ = simulate(body, 0.033, times)
    still = np.abs(np.diff(x)) < 1e-12
    starts = np.flatnonzero(np.diff(still.astype(int)) == -1)
    assert np.count_nonzero(still) > 0
    assert starts.size > 0


def test_rows_average_an_oscillators_response_as_the_design_does(campaign):
    motions = campaign[1]
    rows = hidden_rows(motions, EQUATION_15, RIVALS, 0.125, 4)
    inner = np.array([[9.6, 0.02], [20.0, 0.3]])
    terms = tuple(HiddenResonator(w, z) for w, z in inner)
    expected = build_design(motions, terms, 0.125, 0).columns
    assert np.max(np.abs(rows.hidden(inner) - expected)) < 1e-8 * np.max(np.abs(expected))  # rounding of FFT sums


def test_sixty_kilograms_are_found_once_with_frequency_mass_and_the_equation_beside(campaign, fit):
    truth = campaign[0].truth
    assert fit.count == 1
    assert fit.search.count == 1
    assert fit.backed
    assert fit.outcome == "ok"
    # four standard errors, that are themselves a hundredth of the limits set for the study
    mass = fit.masses(STIFFNESS_N_PER_M)[0]
    assert abs(fit.frequencies[0].value - 9.6) < 4.0 * fit.frequencies[0].stderr < 0.02 * 9.6
    assert abs(mass.value - 60.0) < 4.0 * mass.stderr < 0.1 * 60.0
    assert fit.moving_inertia(STIFFNESS_N_PER_M).value == pytest.approx(truth.inertia_kg, rel=1e-3)
    assert 0.9 < fit.chi2 < 1.3  # what is left is the sensors' noise
    first, *rest = fit.search.why()
    assert "kept, the evidence rises by" in first
    assert all("refused" in sentence for sentence in rest)


def test_an_oscillator_that_the_trajectories_do_not_confirm_is_taken_out_again(fit):
    weak = dataclasses.replace(fit.ratios[0], stderr=fit.ratios[0].value / 2.0)
    doubtful = dataclasses.replace(fit, ratios=(weak,))
    assert fit.confirmed == (True,)
    assert doubtful.confirmed == (False,)
    left = without_unconfirmed(doubtful)
    assert left.oscillators == ()
    assert "is under 3 standard errors; refused" in left.why()[-1]
    assert fit.search.count == 1  # the search it came from is as it was


def test_the_fits_vector_moves_as_the_recording_did(campaign, fit):
    from undertow.likelihood.free_run import free_run

    run = free_run(campaign[1][1], fit.theta(), 1e-3)
    assert run.nrmse < 0.03  # 0.2 mm of noise on 8 mm RMS is 0.025


def test_two_oscillators_are_told_from_one():
    row = study.identify(planted("two of 200 kg", "N3", 0))
    assert row.found == 2
    assert [pair[0] for pair in row.w] == [pytest.approx(7.5, rel=2e-3), pytest.approx(10.5, rel=2e-3)]
    assert [pair[0] for pair in row.mass] == [pytest.approx(200.0, rel=0.05)] * 2


@pytest.mark.parametrize("seed", range(len(NULLS)))
def test_nothing_is_found_where_nothing_is_hidden(seed):
    made = null(seed + len(NULLS))
    found = find_hidden([condition(recording) for recording in made.recordings])
    assert found.count == 0
    assert all("refused" in sentence for sentence in found.why())
    assert found.body_w == pytest.approx(math.sqrt(STIFFNESS_N_PER_M / baseline().inertia_kg), rel=0.06)


def test_a_null_campaign_of_each_kind_lacks_an_oscillator_and_has_what_its_name_says():
    made = {null(seed).kind: null(seed).truth for seed in range(len(NULLS))}
    assert list(made) == list(NULLS)
    assert not any(truth.hidden for truth in made.values())
    assert made["cubic stiffness"].k3 != 0.0
    assert made["Maxwell element"].maxwell[0] > 0.0
    assert made["friction asymmetry"].asymmetry_N != 0.0
    assert made["drag exponent"].exponent != 2.0


def test_a_search_and_a_fit_refuse_what_they_cannot_do(campaign, fit):
    motions = campaign[1]
    with pytest.raises(IdentificationError, match="most is 0; a search for hidden oscillators must allow at least 1"):
        find_hidden(motions, most=0)
    without = dataclasses.replace(fit, coefficients={"viscous_damping": fit.coefficients["viscous_damping"]})
    with pytest.raises(IdentificationError, match="404000 N/m gives no scale: the equation's terms are viscous_damp"):
        without.moving_inertia(404000.0)
    assert not without.backed
    many = [(9.6, 0.02, 0.1)] * 9
    with pytest.raises(IdentificationError, match="this equation has 9 and no other terms: leave some out"):
        hidden_problem(motions, (Stiffness(),), np.array([135.0]), many)


def test_an_equation_without_hidden_states_is_fitted_too():
    made = null(6)
    motions = [condition(recording) for recording in made.recordings]
    found = find_hidden(motions, most=1)
    fit = fit_hidden(motions, EQUATION_15, found)
    assert fit.count == 0
    assert fit.coefficients["quadratic_drag"].value == pytest.approx(made.truth.drag / made.truth.inertia_kg, rel=0.1)


def test_the_committed_tables_meet_the_limits_set_beforehand():
    rows = page.read(study.FOLDER / "planted.csv")
    assert len(rows) == study.SEEDS * len(PLANTED) * 3
    for row in rows:
        assert int(row["found"]) == len(PLANTED[row["kind"]]), row
    for kind, limit in page.MASS_LIMIT_PERCENT.items():
        for noise in ("N1", "N3", "N4"):
            own = [row for row in rows if (row["kind"], row["noise"]) == (kind, noise)]
            w = page.errors(own, "w_rad_per_s", lambda one: one.w)
            mass = page.errors(own, "mass_kg", lambda one: one.mass_kg)
            assert np.median(w) < page.FREQUENCY_LIMIT_PERCENT
            assert np.median(mass) < limit
    nulls = page.read(study.FOLDER / "nulls.csv")
    assert len(nulls) == study.NULL_CAMPAIGNS
    assert sum(int(row["found"]) > 0 for row in nulls) <= 2


def test_the_page_is_that_of_the_tables():
    assert page.PAGE.read_text() == page.text(study.FOLDER)


def test_a_false_alarm_rate_is_that_of_an_exponential_tail():
    rng = np.random.default_rng(3)
    rows = [{"largest_t": f"{value:.4f}"} for value in rng.exponential(1.0, 4000)]
    # P(t > 5) = exp(-5) = 0.0067; the tail's mean excess from 800 values is known within 4 %, times five
    assert page.false_alarm_rate(rows, 5.0) == pytest.approx(math.exp(-5.0), rel=0.5)


def test_a_row_is_written_with_several_oscillators_in_a_cell(tmp_path):
    row = study.Row(
        "two", "N1", 3, 2, 20.0, 90.0, ((7.5, 0.1), (10.5, 0.2)), ((200.0, 1.0), (201.0, 2.0)),
        ((0.02, 0.001), (0.03, 0.002)), 3, True, "ok",
    )  # fmt: skip
    study.write([row], tmp_path / "planted.csv")
    read = page.read(tmp_path / "planted.csv")[0]
    assert page.numbers(read, "w_rad_per_s") == [7.5, 10.5]
    assert page.numbers(read, "mass_stderr") == [1.0, 2.0]
    assert (read["found"], read["backed"], read["outcome"]) == ("2", "1", "ok")
