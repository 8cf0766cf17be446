"""Slices of experiments/efficiency and benchmarks: blind starts, the Cramer-Rao bound, bootstrap, speed."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks import campaign, decay, peers, speed
from experiments.efficiency import blind as blind_study
from experiments.efficiency import rates
from experiments.efficiency.bound import efficiency, markdown, rows
from experiments.efficiency.cases import eq15, hidden
from experiments.efficiency.rates import thinned
from experiments.recovery.releases import plant, record
from undertow.equation.kernel import SLOT
from undertow.errors import IdentificationError
from undertow.likelihood import multistart as blind
from undertow.likelihood import output_error
from undertow.likelihood.problem import Problem

EFFICIENCY = Path(__file__).resolve().parents[2] / "experiments" / "efficiency"


@pytest.mark.parametrize("kind", ["2", "4", "5"])
def test_every_blind_start_of_a_slice_ends_at_the_best_optimum(kind):
    found = blind_study.tried(kind, 10)
    assert blind_study.at_best(found) == 10


@pytest.mark.parametrize("kind", ["2", "4", "5", "hidden"])
def test_the_committed_blind_starts_end_at_the_best_optimum_in_99_of_100(kind):
    with (EFFICIENCY / "blind.csv").open() as file:
        found = [row for row in csv.DictReader(file) if row["kind"] == kind]
    assert len(found) == 500
    assert blind_study.at_best(found) >= 0.99 * len(found)


def test_a_hidden_oscillator_is_found_from_half_its_frequency():
    case = hidden(2e-4)
    rng = np.random.default_rng([0, 12])
    problem, start = case.noisy(rng), case.start(rng)
    assert start[3] < 5.0  # rad/s; the oscillator is at 9.6
    found = blind.fit(problem, start)
    best = output_error.fit(problem, case.truth, growing=False)
    # one valley with one bottom: costs agree to a tenth of a standard error
    assert abs(found.cost - best.cost) < blind_study.NEAR_COST


def test_a_start_that_growing_windows_lose_is_found_again_from_the_record():
    cases, lost = blind_study.cases("5"), 0
    for number in (0, 1, 486, 487):
        case, rng = cases[number % len(cases)], np.random.default_rng([7, number])
        problem, start = case.noisy(rng), case.start(rng)
        best = output_error.fit(problem, case.truth, growing=False).cost
        lost += output_error.fit(problem, start).cost > best + blind_study.NEAR_COST
        assert blind.fit(problem, start).cost < best + blind_study.NEAR_COST
    assert lost > 0  # else the second start proves nothing


def test_a_start_from_the_record_has_its_period_and_its_release():
    case = eq15("long", 2.57, 5, 2e-4)
    values = blind.from_record(case.problem, np.array([0.0, 30.0, 2000.0, 0.02, 0.2]))
    assert values[0] == pytest.approx(case.truth[0], abs=1.0)  # the period is the undamped one
    assert values[4] == pytest.approx(case.truth[4], rel=1e-2)  # the first cell's mean lies 12 ms after the release
    assert 0.0 < values[2] < case.truth[2]


def test_a_fit_without_any_motion_names_its_starts():
    case = eq15("long", 2.57, 2, 2e-4)
    trial = case.problem.trials[0]
    base = trial.base.copy()
    base[SLOT["c1"]] = -1e7
    broken = Problem(case.problem.unknowns, (replace(trial, base=base),))
    with pytest.raises(IdentificationError, match=r"no motion within bounds for .* set trials.window"):
        blind.fit(broken, np.array([500.0, 5.0]))


@pytest.mark.parametrize(("case", "count"), [(("long", 2.57, 4, 1e-4), 100), (("short", 2.36, 5, 1e-3), 150)])
def test_a_slice_of_realisations_scatters_as_the_bound_says(case, count):
    # the short spring's 1 mm: a body that sticks a turn too early is a valley of its own, twice the noise deep
    spread, bias = efficiency(eq15(*case), count)
    # 100 realisations: the spread is known to 7 %, the mean to 10 % of the bound
    assert np.all((spread > 0.75) & (spread < 1.25))
    assert np.all(np.abs(bias) < 0.4)


def test_the_committed_spreads_and_biases_lie_within_their_limits():
    with (EFFICIENCY / "efficiency.csv").open() as file:
        found = list(csv.DictReader(file))
    assert len({row["fit"] for row in found}) == 14
    assert all(row["within"] == "True" and row["count"] == "1000" for row in found)


def test_the_page_marks_what_lies_outside_its_limits():
    table = rows(30, [("a fit", eq15("short", 2.36, 2, 1e-4), (0.0, 0.1, 9.0))])
    assert markdown(table).count("**") == 4


def test_bootstrap_fits_scatter_as_the_covariance_says():
    spread, stderr, _ = campaign.bootstrap(60)
    # white residuals in blocks; 60 draws know a spread to 9 %, one residual's blocks to some 20 %
    assert np.all((spread / stderr > 0.5) & (spread / stderr < 1.6))


def test_undertow_and_its_rivals_give_the_same_two_numbers():
    data = decay.record(1.5)
    own = decay.identify(data)
    expert = peers.nelder_mead(data, peers.dop853_with_events)
    assert own[0] == pytest.approx(expert[0], abs=2.0)  # kg; cells' means against samples, one noise
    assert own[1] == pytest.approx(expert[1], abs=0.05)


def test_a_fit_is_hundreds_of_times_faster_than_method_1_even_on_a_short_record():
    data = decay.record(1.5)
    for _ in range(5):
        decay.identify(data)
    own = float(np.median([speed.cpu_seconds(lambda: decay.identify(data)) for _ in range(50)]))
    # on a record so short that half of undertow's time is fixed
    assert speed.cpu_seconds(lambda: speed.method1(data)) > 200.0 * own


def test_a_rows_ratio_is_against_undertow():
    data = decay.record(1.5)
    table = speed.rows(1.5, data, {"undertow": [1.0, 3.0], "other": [20.0]}, {"undertow": data.truth, "other": (0, 0)})
    assert [row["ratio"] for row in table] == [1.0, 10.0]


def test_a_quarter_and_a_tenth_of_the_rate_give_the_same_estimates():
    found = rates.differences("short", 2.36, "N3", 3)
    for rate in ("250 means", "250 samples", "100 means", "100 samples"):
        assert np.all(np.abs(found[rate, False]) < rates.LIMIT_STDERR)


def test_picked_samples_are_the_motion_with_the_noise_of_the_means():
    truth = plant("short", 2.36)
    found = rates.records(truth, "N3", 5)
    means, picked = found["100 means"], found["100 samples"]
    assert np.allclose(np.diff(picked.time), 0.01)
    # at rest before the release there is no motion to tell them apart
    held = picked.time < 0.9
    assert np.allclose(picked.channels["displacement"][held], means.channels["displacement"][held], atol=1e-12)
    moving = (picked.time > 1.2) & (picked.time < 4.0)
    away = picked.channels["acceleration"][moving] - means.channels["acceleration"][moving]
    assert 1e-4 < np.std(away) < 0.05  # a mean over 10 ms lacks 5e-4 of 3 m/s2, and half of friction's jump at times


def test_thinning_takes_means():
    full = record(plant("long", 2.57), 0.03, "N1", np.random.default_rng(0), "r")
    thin = thinned(full, 10)
    assert thin.time.size == full.time.size // 10
    assert thin.channels["displacement"][3] == pytest.approx(full.channels["displacement"][30:40].mean())
