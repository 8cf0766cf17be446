"""Trials in cells, and how simulated motion moves with every number: against differences of the motion itself."""

from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

from tests.exact_motions import LONG, exact_group, exact_motion
from tests.short_trials import released
from undertow.comparison import polish as polishing
from undertow.comparison.laws import laws, why_not_simulated
from undertow.comparison.polish import linearise, polish
from undertow.comparison.trajectories import OWN, in_cells, trial_rows
from undertow.conditioning.condition import condition
from undertow.equation.forcing import ExternalForcing
from undertow.equation.hidden import HiddenResonator
from undertow.equation.hydrodynamics import DragExponent, QuadraticDrag
from undertow.equation.structure import CoulombFriction, CubicStiffness, Stiffness, StribeckFriction, ViscousDamping
from undertow.errors import IdentificationError
from undertow.likelihood.priors import CLOCK_RADIANS, clock_std
from undertow.recording.recording import Recording

TERMS = (Stiffness(), ViscousDamping(), CoulombFriction(), QuadraticDrag(), CubicStiffness(), StribeckFriction(0.05))
VALUES = np.array([28.0, 0.15, 0.043, 1.0, 5.0, 0.02, 0.05])


@pytest.fixture(scope="module")
def trial():
    return in_cells(exact_motion(LONG, 0.1, rate_hz=200.0, a_noise=0.02), {"k1": 0.01})


def test_derivatives_are_differences_of_the_residual(trial):
    differences_agree(trial, trial.start + np.array([0.0, 0.01, 0.002, 0.003, 0.02]))


def test_derivatives_of_an_accelerometer_alone_and_of_a_release_that_was_not_held_are_differences_too():
    motion = exact_motion(LONG, 0.1, rate_hz=200.0, a_noise=0.02)
    channels = {"acceleration": motion.recording.channels["acceleration"]}
    alone = in_cells(replace(motion, recording=Recording("r1", motion.recording.time, channels)))
    unheld = in_cells(replace(motion, window=replace(motion.window, held=False)))
    assert (alone.names, unheld.names) == (("x0", "shift"), ("x0", "v0", "clock", "gain"))
    differences_agree(alone, alone.start + np.array([0.0, 0.01]))
    differences_agree(unheld, unheld.start + np.array([0.0, 0.01, 0.002, 0.003]))


def differences_agree(trial, own):
    """Derivatives by every number of the laws and of the trial are central differences of its residual."""
    book = laws(TERMS)
    rows = trial_rows(trial, book, VALUES, own, range(len(VALUES)))
    for place, value in enumerate(VALUES):
        step = 1e-5 * value
        up, down = (VALUES + sign * step * (np.arange(VALUES.size) == place) for sign in (1.0, -1.0))
        pair = [trial_rows(trial, book, values, own, ()).residual for values in (up, down)]
        # a reversal that crosses a sample spoils that sample's difference of the acceleration: medians, not maxima
        change = (pair[0] - pair[1]) / (2.0 * step)
        assert np.median(np.abs(change - rows.shared[:, place])) < 1e-4 * np.abs(rows.shared[:, place]).max()
    for place, name in enumerate(trial.names):
        step = 1e-5
        up, down = (own + sign * step * (np.arange(own.size) == place) for sign in (1.0, -1.0))
        pair = [trial_rows(trial, book, VALUES, values, ()).residual for values in (up, down)]
        change = (pair[0] - pair[1]) / (2.0 * step)
        # an acceleration's clock is differentiated by differences between samples
        tolerance = 5e-3 if name in ("shift", "clock") else 1e-4
        assert np.median(np.abs(change - rows.own[:, place])) < tolerance * np.abs(rows.own[:, place]).max()


def test_offsets_and_slow_drift_of_the_sensors_leave_the_residual_alone():
    motion = exact_motion(LONG, 0.1, rate_hz=200.0, a_noise=0.02)
    clean = in_cells(motion)
    recording = motion.recording
    slow = 1e-3 * (1.0 + recording.time / 12.0 - (recording.time / 12.0) ** 2)
    drifted = {name: values + slow for name, values in recording.channels.items()}
    other = in_cells(replace(motion, recording=Recording("r", recording.time, drifted)))
    book = laws(TERMS)
    pair = [trial_rows(one, book, VALUES, clean.start, ()).residual for one in (clean, other)]
    assert pair[0] == pytest.approx(pair[1], abs=2e-3 * np.abs(pair[0]).max())  # their noises differ by 1e-3


def test_a_trial_with_a_stiffness_of_its_own_moves_as_that_stiffness_says(trial):
    book = laws(TERMS)
    own, stiffer = trial.start.copy(), VALUES.copy()
    own[trial.names.index(f"{OWN}k1")] = 0.02
    stiffer[0] *= 1.02
    shared = trial_rows(trial, book, stiffer, trial.start, ()).residual
    assert trial_rows(trial, book, VALUES, own, ()).residual == pytest.approx(shared, abs=1e-9 * np.abs(shared).max())


def test_a_motion_that_leaves_every_bound_has_no_rows(trial):
    runaway = VALUES.copy()
    runaway[3] = -80.0
    assert trial_rows(trial, laws(TERMS, signs=False), runaway, trial.start, (0, 1)) is None
    with pytest.raises(IdentificationError, match=r"the motion of stiffness.*leaves every bound on .*; give"):
        polish([trial], laws(TERMS, signs=False), range(6), runaway)
    fine = polish([trial], laws(TERMS), range(4), VALUES)
    with pytest.raises(IdentificationError, match=r"trial r1: the motion of .*leaves every bound"):
        linearise([trial], laws(TERMS, signs=False), replace(fine, values=runaway))


def test_polished_numbers_of_exact_motions_are_exact():
    motions = exact_group(LONG, rate_hz=200.0, a_noise=0.02)
    trials = [in_cells(motion) for motion in motions]
    terms = TERMS[:4]
    found = polish(trials, laws(terms), range(4), np.array([28.5, 0.3, 0.03, 0.8]), doubtful=True)
    exact = np.array([LONG.k_N_per_m, LONG.c_Ns_per_m, LONG.friction_N, LONG.drag_Ns2_per_m2]) / LONG.inertia_kg
    assert found.converged
    assert found.values == pytest.approx(exact, rel=1e-5)  # displacement is exact, its noise taken as 1e-6 of it


def test_a_start_far_away_finds_its_phase_on_growing_windows():
    trials = [in_cells(motion) for motion in exact_group(LONG, rate_hz=200.0, a_noise=0.02)]
    far = np.array([36.0, 0.5, 0.01, 0.1])
    alone = polish(trials, laws(TERMS[:4]), range(4), far)
    grown = polish(trials, laws(TERMS[:4]), range(4), far, doubtful=True)
    assert grown.values[0] == pytest.approx(LONG.k_N_per_m / LONG.inertia_kg, rel=1e-4)
    assert grown.cost <= alone.cost


@pytest.mark.parametrize(("ended", "share", "again"), [(True, 0.5, False), (True, 2.0, True), (False, 0.5, True)])
def test_a_doubtful_start_is_tried_on_growing_windows_where_it_fits_poorly_or_did_not_end(
    trial, monkeypatch, ended, share, again
):
    found, grown = polish([trial], laws(TERMS[:4]), range(4), VALUES[:4]), []
    rows = sum(seen.values.size for seen in trial.channels)
    poor = replace(found, converged=ended, chi2=share * polishing.POOR_FIT * rows)
    monkeypatch.setattr(polishing, "_search", lambda *_: poor)
    monkeypatch.setattr(polishing, "_grown", lambda *given: (grown.append(given), (VALUES[:4], []))[1])
    polish([trial], laws(TERMS[:4]), range(4), VALUES[:4], own=[np.zeros(0)], doubtful=True)
    assert bool(grown) == again


def test_the_linear_picture_predicts_what_a_step_does(trial):
    book = laws(TERMS)
    here = polish([trial], book, range(4), VALUES)
    linear = linearise([trial], book, here)
    assert sum(linear.lengths) == linear.response.size
    moved = here.values.copy()
    moved[4] += 1e-3 * abs(here.values[0])  # a cubic spring of 0.03 N/m^3 per kg
    there = linearise([trial], book, replace(here, values=moved))
    expected = linear.response - linear.columns @ moved
    found = there.response - there.columns @ moved
    change = linear.columns @ (moved - here.values)
    assert np.linalg.norm(found - expected) < 0.02 * np.linalg.norm(change)


def test_one_column_made_anew_is_that_of_the_whole_and_leaves_the_others(trial):
    book = laws(TERMS)
    here = polish([trial], book, range(4), VALUES)
    place = book.names.index("stribeck_friction.velocity_m_per_s")
    before = linearise([trial], book, here)
    friction = TERMS.index(StribeckFriction(0.05))
    whole = linearise([trial], book, here, inner={place: 0.09})
    one = linearise([trial], book, here, inner={place: 0.09}, only=friction, before=before)
    assert one.columns.shape == before.columns.shape
    assert one.columns == pytest.approx(whole.columns, rel=1e-9, abs=1e-9)
    assert np.abs(one.columns[:, friction] - before.columns[:, friction]).max() > 0.0
    assert one.columns[:, 0] == pytest.approx(before.columns[:, 0])


def test_channels_are_what_is_recorded_and_unknowns_follow_them():
    both = in_cells(condition(released(LONG, 0.1, "r", 0)))
    assert both.names == ("x0", "shift", "clock", "gain")
    alone = in_cells(condition(released(LONG, 0.1, "r", 0, channels=("x",))))
    assert alone.names == ("x0", "shift")
    assert [seen.quantity for seen in alone.channels] == ["displacement"]
    motion = exact_motion(LONG, 0.1)
    unheld = replace(motion, window=replace(motion.window, held=False))
    assert in_cells(unheld).names == ("x0", "v0", "clock", "gain")


def test_other_weights_are_those_of_another_trial_and_the_first_cannot_be_changed_in_place(trial):
    before = [(seen.sigma, seen.factor) for seen in trial.channels]
    weighed = trial.reweighted([2.0, 3.0])
    assert [(seen.sigma, seen.factor) for seen in weighed.channels] == [
        (by * sigma, by * factor) for by, (sigma, factor) in zip((2.0, 3.0), before, strict=True)
    ]
    assert [(seen.sigma, seen.factor) for seen in trial.channels] == before
    with pytest.raises(FrozenInstanceError, match="cannot assign to field 'sigma'"):
        trial.channels[0].sigma = 1.0


def test_a_recording_without_motion_is_refused():
    motion = exact_motion(LONG, 0.1)
    force = {"spring_force": motion.recording.channels["spring_force"]}
    bare = replace(motion, recording=Recording("f1", motion.recording.time, force))
    with pytest.raises(IdentificationError, match=r"trial f1: recorded is spring_force; map displacement"):
        in_cells(bare)


@pytest.mark.parametrize(
    ("terms", "reason"),
    [
        ((Stiffness(), HiddenResonator(9.0, 0.02)), "hidden_resonator is no force of x and v alone"),
        ((Stiffness(), ExternalForcing(3.0)), "external_forcing is no force of x and v"),
        ((Stiffness(), HiddenResonator(), ExternalForcing()), "hidden_resonator, external_forcing are no"),
        ((Stiffness(), DragExponent(1.5), DragExponent(2.5)), "two terms share the inner parameter cp, p"),
    ],
)
def test_libraries_that_cannot_be_simulated_are_named(terms, reason):
    assert reason in why_not_simulated(terms)
    with pytest.raises(IdentificationError, match=rf"{reason}.* cannot be judged on simulated .*{len(terms)} terms"):
        laws(terms)


def test_bounds_follow_the_signs():
    assert laws(TERMS).lower[:5].tolist() == [0.0, 0.0, 0.0, 0.0, -np.inf]
    assert np.all(np.isneginf(laws(TERMS, signs=False).lower[:5]))
    assert laws(TERMS).names[-1] == "stribeck_friction.velocity_m_per_s"


def test_a_release_may_be_late_by_its_prior_and_by_what_it_was_seen_with(trial):
    motion = exact_motion(LONG, 0.1, rate_hz=200.0, a_noise=0.02)
    unsure = replace(motion, window=replace(motion.window, release_stderr_s=0.3))
    late = [in_cells(one).prior[1] for one in (motion, unsure)]
    assert late[0] == pytest.approx(0.6 * trial.period_s / (2.0 * np.pi), rel=0.01)
    assert late[1] == pytest.approx(np.hypot(late[0], 0.3), rel=0.01)


def test_releases_are_tried_at_the_instant_seen_and_at_two_later_ones_within_a_tenth_of_a_period(trial, monkeypatch):
    tried, plain = [], polishing._search

    def noting(trials, book, places, values, own):
        if not len(places):
            tried.append(own[0][trial.names.index("shift")])
        return plain(trials, book, places, values, own)

    monkeypatch.setattr(polishing, "_search", noting)
    polish([trial], laws(TERMS[:4]), range(4), VALUES[:4])
    assert tried == pytest.approx(np.array([0.0, 0.3, 0.6]) * trial.period_s / (2.0 * np.pi))


def test_a_clock_is_known_to_an_angle_of_the_bodys_motion():
    assert clock_std(2.0 * np.pi) == pytest.approx(CLOCK_RADIANS)
    assert clock_std(3.0) == pytest.approx(3.0 * clock_std(1.0))
