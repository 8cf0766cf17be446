"""A relaxation is a hidden state too: found beside the equation and beside oscillators, and not where there is none."""

from dataclasses import replace

import numpy as np
import pytest

from experiments.hidden_states import campaigns, relaxations
from undertow.comparison.hidden_relaxation import CRITICAL_GAIN, discover_states, find_relaxation
from undertow.conditioning.condition import condition
from undertow.conditioning.motion import Motion
from undertow.equation.equation import Equation
from undertow.equation.hidden import Relaxation
from undertow.equation.kernel import SLOT
from undertow.errors import IdentificationError

MAXWELL_SEED, NOTHING_SEED = 2, 6


def conditioned(campaign) -> list[Motion]:
    return [condition(recording) for recording in campaign.recordings]


@pytest.fixture(scope="module")
def maxwell():
    campaign = campaigns.null(MAXWELL_SEED)
    return campaign.truth, discover_states(conditioned(campaign))


def test_a_maxwell_element_is_one_hidden_state_and_no_oscillator(maxwell):
    truth, found = maxwell
    assert (found.count, found.fit.count) == (1, 0)
    k_r, time = truth.maxwell
    assert abs(found.relaxation.time_s.value - time) < 4.0 * found.relaxation.time_s.stderr
    assert found.relaxation.share == pytest.approx(k_r / truth.k, rel=0.03)  # its error and the time's go together
    assert "is kept: beside the rivals the squares fall by" in found.why()[-1]


def test_the_committed_rows_are_those_of_the_study_and_hold_no_false_alarm(maxwell):
    rows = relaxations.read_rows()
    assert [row.seed for row in rows] == list(range(relaxations.CAMPAIGNS))
    now = relaxations.as_row(campaigns.null(MAXWELL_SEED), maxwell[1])
    assert rows[MAXWELL_SEED].kept == now.kept == 1
    assert rows[MAXWELL_SEED].time_s == pytest.approx(now.time_s, rel=0.01)
    assert sum(row.kept for row in rows if row.true_share == 0.0) <= 1  # one in fifty
    assert all(row.kept for row in rows if row.true_share > 0.0 and row.noise == "N1")
    assert all(row.oscillators == 0 for row in rows)


def test_the_vector_of_all_states_moves_as_the_equation_with_a_relaxation(maxwell):
    _, found = maxwell
    one = found.relaxation
    terms = (*found.fit.terms, Relaxation(one.time_s.value))
    values = (*(found.fit.coefficients[term.name].value for term in found.fit.terms), one.stiffness.value)
    assert found.theta() == pytest.approx(Equation(terms, values, mass_kg=1.0).theta())


def test_beside_an_oscillator_both_are_found():
    truth = replace(campaigns.plant("60 kg"), maxwell=(0.05 * campaigns.STIFFNESS_N_PER_M, 0.2))
    rng = np.random.default_rng(5)
    records = [campaigns.record(truth, x0, "N1", rng, f"{x0:g} m") for x0 in campaigns.RELEASES_M]
    found = discover_states([condition(record) for record in records])
    assert (found.count, found.fit.count) == (2, 1)
    assert found.fit.frequencies[0].value == pytest.approx(9.6, rel=0.005)
    assert found.relaxation.time_s.value == pytest.approx(0.2, rel=0.1)


def test_where_nothing_is_hidden_the_relaxation_is_refused_with_the_number():
    found = discover_states(conditioned(campaigns.null(NOTHING_SEED)))
    assert found.count == 0
    assert found.relaxation.gain < CRITICAL_GAIN
    assert "is refused: the squares fall by" in found.why()[-1]
    assert found.theta()[SLOT["rk1"]] == 0.0


def test_trials_that_begin_in_motion_say_nothing_about_memory(maxwell):
    motions = conditioned(campaigns.null(MAXWELL_SEED))
    moving = [replace(motion, window=replace(motion.window, held=False)) for motion in motions]
    with pytest.raises(IdentificationError, match=r"2 trials, 2 of them in motion at the start .* give releases"):
        find_relaxation(moving, maxwell[1].fit)
