"""A slice of the hidden-state study, and its committed tables against the limits set beforehand."""

import math
from dataclasses import replace

import numpy as np
import pytest

import undertow
from experiments.eq15_campaign.motion import Body
from experiments.eq15_campaign.motion import simulate as simulate_eq15
from experiments.files import read_rows, write_rows
from experiments.hidden_states import page, study
from experiments.hidden_states.campaigns import (
    NULLS,
    PLANTED,
    RELEASES_M,
    STIFFNESS_N_PER_M,
    Campaign,
    baseline,
    null,
    plant,
    planted,
    record,
)
from experiments.hidden_states.motion import Oscillator, Plant, simulate
from undertow.equation.equation import Equation
from undertow.equation.hidden import HiddenResonator
from undertow.equation.registry import find
from undertow.equation.simulate import simulate as simulate_ours
from undertow.recording.recording import Recording

MAXWELL_SEED = 2
NOISES = ("N1", "N3", "N4")
LEAST_RIGHT = {("20 kg", "N4"): 6}
"""Campaigns of the committed eight that name what is there; elsewhere all. 20 kg under a millimetre of noise raise the
free run's error by a tenth, and twice the answer was `unknown`."""


def test_the_planted_motion_without_hidden_states_is_that_of_the_default_campaign():
    truth, times = baseline(), np.arange(6000) / 1000.0
    x, a = simulate(truth, RELEASES_M[1], times)
    other = simulate_eq15(Body(truth.inertia_kg, truth.c, truth.k, truth.friction_N, truth.drag), RELEASES_M[1], times)
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


def test_sixty_kilograms_are_found_once_with_frequency_mass_and_the_equation_beside():
    made = planted("60 kg", "N3", 0)
    group = undertow.diagnose(
        list(made.recordings), scatter=study.NO_SCATTER, stiffness_N_per_m=STIFFNESS_N_PER_M
    )[0]  # fmt: skip
    assert group.names == ("hidden_resonator",)
    w, mass = (group.estimates[f"hidden_resonator.{name}"] for name in ("natural_frequency_rad_per_s", "mass_kg"))
    # four standard errors, that are themselves within the limits set for the study
    assert abs(w.value - 9.6) < 4.0 * w.stderr < 0.02 * 9.6
    assert abs(mass.value - 60.0) < 4.0 * mass.stderr < 0.15 * 60.0
    assert group.estimates["total_mass_kg"].value == pytest.approx(made.truth.inertia_kg, rel=2e-3)
    # 0.2 mm of noise on 8 mm RMS is 0.025; the trials' own rest positions and clocks add to it
    assert group.error_after < 0.035 < 0.3 * group.verdict.baseline.nrmse


def test_two_oscillators_are_found_as_two():
    row = study.identify(planted("two of 200 kg", "N3", 0))
    assert page.right_number(row)
    assert page.numbers(row, "w_rad_per_s") == [pytest.approx(7.5, rel=2e-3), pytest.approx(10.5, rel=2e-3)]
    assert page.numbers(row, "mass_kg") == [pytest.approx(200.0, rel=0.05)] * 2


@pytest.mark.parametrize("seed", [seed + len(NULLS) for seed in range(len(NULLS))])
def test_nothing_that_is_not_there_is_named_where_no_oscillator_is(seed):
    assert page.false_names(study.identify(null(seed))) == set()


def test_a_maxwell_element_is_a_relaxation_and_no_oscillator():
    made = null(MAXWELL_SEED)
    k_r, tau = made.truth.maxwell
    row = study.identify(made)
    assert page.names(row) == ["relaxation"]
    assert abs(float(row["tau_s"]) - tau) < 4.0 * float(row["tau_s_stderr"])
    assert abs(float(row["k_r_N_per_m"]) - k_r) < 4.0 * float(row["k_r_N_per_m_stderr"])


def test_a_relaxation_beside_an_oscillator_is_named_too_or_left_as_unknown():
    truth = replace(plant("60 kg"), maxwell=(0.05 * STIFFNESS_N_PER_M, 0.2))
    rng = np.random.default_rng(5)
    records = tuple(record(truth, x0, "N1", rng, f"{x0:g} m") for x0 in RELEASES_M)
    row = study.identify(Campaign("60 kg", "N1", 5, truth, records))
    assert page.names(row)[0] == "hidden_resonator"
    assert set(page.names(row)) <= {"hidden_resonator", "relaxation"}
    # the oscillator alone is not the whole answer: it leaves five times the sensors' noise
    assert set(row["named"].split("+")) & {"relaxation", "unknown"}
    assert float(row["w_rad_per_s"]) == pytest.approx(9.6, rel=0.005)


def house(values: dict[str, float | dict[str, float]]) -> Recording:
    """A house of 1 kg at 6.5 rad/s released from 20 mm after a second's hold, its displacement alone."""
    run = undertow.simulate(
        {"stiffness": 42.0, "viscous_damping": 0.3, **values}, x0=0.02, mass_kg=1.0, rate_hz=40.0, duration_s=14.0
    )
    return run.recorded(noise_m=3e-4, seed=8, name="house")


def test_displacement_alone_shows_a_tuned_mass_damper_and_a_spring_that_bends_is_none():
    linear = ["stiffness", "viscous_damping"]
    damper = {"mass_kg": 0.06, "natural_frequency_rad_per_s": 7.2, "damping_ratio": 0.03}
    found = undertow.diagnose([house({"hidden_resonator": damper})], linear, mass_kg=1.0, scatter=study.NO_SCATTER)[0]
    assert found.names == ("hidden_resonator",)
    w = found.estimates["hidden_resonator.natural_frequency_rad_per_s"]
    assert abs(w.value - 7.2) < 5.0 * w.stderr < 1.5  # one trial of thirteen periods
    bent = undertow.diagnose([house({"cubic_stiffness": 12000.0})], linear, mass_kg=1.0, scatter=study.NO_SCATTER)[0]
    assert bent.names == ("cubic_stiffness",)
    assert bent.estimates["cubic_stiffness.N_per_m3"].value == pytest.approx(12000.0, rel=0.1)


def test_a_null_campaign_of_each_kind_lacks_an_oscillator_and_has_what_its_name_says():
    made = {null(seed).kind: null(seed).truth for seed in range(len(NULLS))}
    assert list(made) == list(NULLS) == list(page.TRUE_NAMES)
    assert not any(truth.hidden for truth in made.values())
    assert made["cubic stiffness"].k3 != 0.0
    assert made["Maxwell element"].maxwell[0] > 0.0
    assert made["friction asymmetry"].asymmetry_N != 0.0
    assert made["drag exponent"].exponent != 2.0


def test_the_committed_rows_are_those_of_fresh_seeds_and_meet_the_limits_set_beforehand():
    rows = read_rows(study.FOLDER / "planted.csv")
    assert len(rows) == study.SEEDS * len(PLANTED) * len(NOISES)
    assert {int(row["seed"]) for row in rows} == set(range(study.FIRST_SEED, study.FIRST_SEED + study.SEEDS))
    for kind in PLANTED:
        for noise in NOISES:
            own = [row for row in rows if (row["kind"], row["noise"]) == (kind, noise)]
            assert sum(map(page.right_number, own)) >= LEAST_RIGHT.get((kind, noise), study.SEEDS)
            w = page.errors(own, "w_rad_per_s", lambda one: one.w)
            mass = page.errors(own, "mass_kg", lambda one: one.mass_kg)
            assert np.median(w) < page.FREQUENCY_LIMIT_PERCENT
            assert np.median(mass) < page.MASS_LIMIT_PERCENT.get(kind, math.inf)
    # 118 oscillators: the root mean square of sound ratios lies between 0.8 and 1.2 in 99.7 of 100 such tables
    assert 0.8 < page.spread(rows, "w_rad_per_s", lambda one: one.w) < 1.2
    assert 0.8 < page.spread(rows, "mass_kg", lambda one: one.mass_kg) < 1.2


def test_the_committed_null_campaigns_name_nothing_hidden_that_is_not_there():
    rows = read_rows(study.FOLDER / "nulls.csv")
    seeds = range(study.FIRST_SEED, study.FIRST_SEED + study.NULL_CAMPAIGNS)
    assert [int(row["seed"]) for row in rows] == list(seeds)
    assert sum(bool(page.false_names(row)) for row in rows) <= len(rows) / 50  # one in fifty


def test_the_page_is_that_of_the_tables():
    assert page.PAGE.read_text() == page.text(study.FOLDER)


def test_a_row_is_written_with_several_oscillators_in_a_cell(tmp_path):
    row = dict.fromkeys(study.HEADER, "") | {
        "kind": "two of 200 kg", "named": "hidden_resonator+hidden_resonator", "w_rad_per_s": "7.5 10.5",
    }  # fmt: skip
    write_rows(tmp_path / "planted.csv", study.HEADER, [row])
    (read,) = read_rows(tmp_path / "planted.csv")
    assert read == row
    assert page.numbers(read, "w_rad_per_s") == [7.5, 10.5]
    assert page.right_number(read)
    assert not page.right_number({**read, "named": "hidden_resonator"})


def test_the_study_writes_the_rows_of_the_part_that_is_asked_for(tmp_path, monkeypatch):
    monkeypatch.setattr(study, "identify", lambda campaign: {"kind": campaign.kind, "seed": str(campaign.seed)})
    assert study.main(["nulls", "--first", "3", "--count", "2", "--out", str(tmp_path)]) == 0
    assert [row["kind"] for row in read_rows(tmp_path / "nulls.csv")] == ["drift", "friction asymmetry"]
