"""Real recordings, live from their configs: the numbers that others published, and the claims of docs/recordings.md."""

from __future__ import annotations

import functools
import json
from pathlib import Path

import pytest

from experiments.recordings.compare import apply, compare
from experiments.recordings.make import COMMAND, JSON, PAGE, changed_since
from experiments.recordings.page import page
from experiments.recordings.published import KVLCC2, REFERENCES, Reference
from experiments.recordings.studies import NO_SEARCH, STUDIES, plain, run_study
from undertow.discrepancy.findings import Findings

SHARED = Path(__file__).resolve().parents[2] / ".." / "shared" / "recordings"
with_recordings = pytest.mark.skipif(
    not SHARED.is_dir(), reason="the real recordings are not beside the repository (../shared/recordings)"
)
JUDGED = [reference for reference in REFERENCES if reference.limit_percent == reference.limit_percent]


@functools.cache
def found(name: str) -> Findings:
    """A study, run once a session by output error alone and without the search for what is missing, to be quick."""
    return run_study(next(study for study in STUDIES if study.name == name), "identify=[output_error]", NO_SEARCH)


@functools.cache
def stored() -> dict:
    return json.loads(JSON.read_text(encoding="utf-8"))


def stored_groups(name: str) -> list[dict]:
    return next(study["groups"] for study in stored()["studies"] if study["study"] == name)


def parameter(name: str, group: int, parameter: str) -> tuple[float, float]:
    """Value and standard error by output error in a group of a study."""
    estimate = found(name).groups[group].fits["output_error"].parameters[parameter]
    return estimate.value, estimate.total_stderr


def rms(name: str, group: int) -> float:
    trial = found(name).groups[group].trials[0]
    return float(((trial.measured - trial.simulated) ** 2).mean() ** 0.5)


@with_recordings
@pytest.mark.parametrize(
    "reference", JUDGED, ids=[f"{r.study}-{'-'.join(f'{v:g}' for v in r.group.values())}-{r.quantity}" for r in JUDGED]
)
def test_number_lies_within_the_limit_set_beside_the_published_one(reference):
    study = next(study for study in STUDIES if study.name == reference.study)
    row = compare([reference], [plain(study, found(reference.study))])[0]
    assert row["met"], row


def test_limits_are_those_that_were_set_beforehand():
    limits = {(r.study, tuple(r.group.values()), r.quantity): r.limit_percent for r in JUDGED}
    pendulum = {("rotary_pendulum", (t,), q): p for t in (90.0, 135.0) for q, p in (("k1", 1.0), ("c0", 10.0))}
    ship = {("kvlcc2", (15.5,), q): p for q, p in (("B1", 6.0), ("B2", 6.0), ("C1", 1.0))}
    assert limits == pendulum | ship


@with_recordings
@pytest.mark.parametrize("group", [0, 1])
def test_pendulum_needs_friction_and_a_sine_but_no_drag(group):
    friction, error = parameter("rotary_pendulum", group, "friction_N_per_mass")
    assert friction > 5.0 * error
    assert rms("rotary_pendulum", group) < 0.7 * rms("rotary_pendulum_viscous", group)
    assert rms("rotary_pendulum_straight", group) > 10.0 * rms("rotary_pendulum", group)
    drag, drag_error = parameter("rotary_pendulum_drag", group, "drag_Ns2_per_m2_per_mass")
    assert abs(drag) < 2.0 * drag_error


@with_recordings
def test_ship_at_rest_is_near_the_published_quadratic_model_and_hardens():
    published = {r.formula: r.value for r in REFERENCES if r.study == "kvlcc2_quadratic" and r.source == KVLCC2}
    for name, value in published.items():  # beside them, not judged by a limit: within 15 % says they are the same law
        assert parameter("kvlcc2_quadratic", 0, name)[0] == pytest.approx(value, rel=0.15)
    hardening, error = parameter("kvlcc2_hardening", 0, "cubic_stiffness_N_per_m3_per_mass")
    assert hardening > 10.0 * error
    assert rms("kvlcc2_hardening", 0) < 0.5 * rms("kvlcc2_quadratic", 0)


@with_recordings
def test_speed_adds_linear_damping_and_leaves_the_quadratic_part():
    at_rest, underway = (parameter("kvlcc2", group, "c_Ns_per_m_per_mass")[0] for group in (0, 1))
    assert underway > 3.0 * at_rest
    (q0, e0), (q1, e1) = (parameter("kvlcc2", group, "drag_Ns2_per_m2_per_mass") for group in (0, 1))
    assert abs(q1 - q0) < 2.0 * (e0**2 + e1**2) ** 0.5


@with_recordings
@pytest.mark.slow
def test_disc_in_air_has_linear_and_quadratic_damping_and_no_friction():
    for group in (0, 1):  # the two large decays
        for name in ("c_Ns_per_m", "drag_Ns2_per_m2"):
            value, error = parameter("spring_disc_two", group, name)
            assert value > 10.0 * error, (group, name)
        for alone in ("spring_disc_linear", "spring_disc_quadratic"):
            assert rms("spring_disc_two", group) < 0.95 * stored_groups(alone)[group]["trials"][0]["rms"]
    for group in (0, 1, 2):
        friction, error = parameter("spring_disc_air", group, "mu")
        assert abs(friction) < 2.0 * error, group


@with_recordings
def test_small_decay_of_the_disc_is_read_from_its_beginning():
    motion = found("spring_disc_air").groups[2].trials[0].motion
    assert motion.t[-1] > 120.0  # a quiet turn at 101 s, 0.1 mm a step, is not the release
    assert motion.amplitude == pytest.approx(0.005, rel=0.1)


@with_recordings
@pytest.mark.parametrize("name", ["bicycle_wheel_axial", "bicycle_wheel_radial"])
def test_linear_equation_holds_the_bicycle_wheel_and_richer_ones_gain_little(name):
    group = found(name).groups[0]
    assert group.verdict.status == "cannot_tell"  # nothing is looked for here
    assert group.trials[0].mismatch.nrmse < 0.02
    for richer, term in ((f"{name}_drag", "drag_Ns2_per_m2_per_mass"), (f"{name}_coulomb", "friction_N_per_mass")):
        gain = 1.0 - rms(richer, 0) / rms(name, 0)
        assert gain < 0.3, (richer, term)


@with_recordings
def test_equation_fails_on_the_building_whose_damper_is_not_seen_and_the_run_says_so():
    group = found("tmd_two_sensors").groups[0]
    assert group.verdict.status == "cannot_tell"  # of one trial, and nothing is looked for here
    assert "nothing was looked for. The equation misses 59 % of the motion" in group.verdict.sentence
    assert group.trials[0].mismatch.nrmse > 0.5
    assert group.trials[0].mismatch.line_frequency_hz == pytest.approx(1.25, rel=0.05)  # the README's second mode


@with_recordings
def test_richer_equation_of_the_building_ends_no_higher_than_the_linear_one():
    assert rms("tmd_two_sensors", 0) <= rms("tmd_linear", 0) * 1.001  # scored anew from each trial's own x0, v0


@with_recordings
@pytest.mark.slow
def test_tank_softens_in_every_decay_and_in_all_together():
    value, error = parameter("sloshing_tank", 0, "cubic_stiffness_N_per_m3_per_mass")
    assert value < -10.0 * error
    for trial in found("sloshing_tank").groups[0].trials:
        own = trial.fits["output_error"].parameters["cubic_stiffness_N_per_m3_per_mass"]
        assert own.value < -10.0 * own.total_stderr, trial.motion.name
    straight, softening = (found(n).groups[0].verdict.baseline.nrmse for n in ("sloshing_linear", "sloshing_tank"))
    assert straight > 1.4 * softening


@with_recordings
@pytest.mark.parametrize("name", ["kvlcc2", "rotary_pendulum", "spring_disc_air", "tmd_two_sensors", "sloshing_tank"])
def test_stored_numbers_are_those_of_a_live_run_and_what_is_far_off_is_not_called_explained_by_nothing(name):
    for kept, live in zip(stored_groups(name), found(name).groups, strict=True):
        if live.verdict.baseline.nrmse > live.verdict.repeatability_nrmse:
            assert kept["status"] != "nothing_missing"
        for name_of, before in kept["methods"]["output_error"]["parameters"].items():
            estimate = live.fits["output_error"].parameters[name_of]
            assert before["value"] == pytest.approx(estimate.value, rel=1e-3, abs=0.1 * estimate.total_stderr), COMMAND
        for before, now in zip(kept["trials"], live.trials, strict=True):
            assert before["nrmse"] == pytest.approx(now.mismatch.nrmse, rel=1e-3)  # printed to six digits
            assert before["repeatability_nrmse"] == pytest.approx(now.mismatch.repeatability_nrmse, rel=1e-3)


def test_page_is_the_stored_numbers():
    assert PAGE.read_text(encoding="utf-8") == page(stored())


def test_stored_limits_are_met():
    judged = [row for row in stored()["comparisons"] if row["met"] is not None]
    assert len(judged) == len(JUDGED)
    assert [row for row in judged if not row["met"]] == []


def test_changed_added_and_lost_sources_are_named():
    assert changed_since({"a": "1", "b": "1", "c": "1"}, {"a": "1", "b": "2", "d": "1"}) == ["b", "c", "d"]


def test_formulas_are_those_of_the_linear_oscillator():
    wheel = {
        "k_N_per_m_per_mass": {"value": 222.4, "stderr": 0.06},
        "c_Ns_per_m_per_mass": {"value": 0.455, "stderr": 0.006},
        "total_mass_kg": {"value": 0.209, "stderr": None},
    }
    period, error = apply("period", wheel, {})
    assert period == pytest.approx(0.42132, abs=1e-5)
    assert error == pytest.approx(period * 0.5 * 0.06 / 222.4)
    assert apply("decrement", wheel, {})[0] == pytest.approx(0.455 * period / 2.0)
    assert apply("frequency_of_mass", wheel, {})[0] == pytest.approx(1.3447, abs=1e-4)
    assert apply("rms_milli", {}, {"rms": 0.0044})[0] == pytest.approx(4.4)


def test_reference_without_a_result_is_an_error_and_not_dropped():
    with pytest.raises(LookupError, match="no result for nowhere"):
        compare([Reference("nowhere", "k", "1/s^2", "k_N_per_m_per_mass", 1.0, "none")], [])
