"""The Eq. 15 campaign is what its README says: remade to the digit, and a motion of Eq. 15."""

from __future__ import annotations

import gzip
import json

import numpy as np
import pytest

from experiments.eq15_campaign import make
from experiments.eq15_campaign.motion import Body, simulate
from experiments.eq15_campaign.trials import make_trial, plan_trials


@pytest.mark.parametrize("number", [0, 30])
def test_a_trial_is_remade_equal_to_the_last_printed_digit(number):
    trial = plan_trials()[number]
    text, _ = make_trial(trial)
    with gzip.open(make.FOLDER / trial.file, "rt") as stream:
        assert stream.read() == text


def test_truth_has_an_entry_for_every_file_of_the_index():
    truth = json.loads((make.FOLDER / "truth.json").read_text())
    rows = (make.FOLDER / "campaign.csv").read_text().splitlines()[1:]
    assert {row.split(",")[0] for row in rows} == set(truth["trials"])
    assert len(rows) == 48


def test_energy_never_rises():
    body = Body(3716.8, 590.0, 109592.0, 175.0, 3880.0)
    motion = simulate(body, 0.107, np.linspace(0.0, 12.0, 4000))
    energy = 0.5 * body.inertia_kg * motion.v**2 + 0.5 * body.k_N_per_m * motion.x**2
    assert np.max(np.diff(energy)) < 1e-9 * energy[0]  # rounding of the integrator


def test_a_body_that_stuck_stays():
    body = Body(2637.4, 810.0, 402036.0, 165.0, 0.0)
    motion = simulate(body, 0.008, np.linspace(0.0, 12.0, 3000))
    assert motion.stopped_s is not None
    after = np.linspace(0.0, 12.0, 3000) > motion.stopped_s
    assert np.ptp(motion.x[after]) == 0.0
    assert abs(motion.x[-1]) <= body.friction_N / body.k_N_per_m


def test_friction_alone_takes_four_mu_N_over_k_from_the_peak_a_cycle():
    body = Body(2637.4, 0.0, 109592.0, 188.0, 0.0)
    motion = simulate(body, 0.05, np.linspace(0.0, 8.0, 2000))
    peaks = np.abs(motion.reversals_m[:-1])  # the last swing may end before the middle
    drops = -np.diff(peaks)
    assert drops == pytest.approx(2.0 * body.friction_N / body.k_N_per_m, rel=1e-9)  # a half cycle; closed form
