"""A release that is not sudden, a friction that the equation lacks, a force with its own clock: whole campaigns."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from experiments.names.folder import write
from experiments.names.rigs import Plan
from experiments.names.scenes import Campaign
from tests.concealed.test_diagnosis import SHORT, member
from undertow.campaign.config import load
from undertow.campaign.run import run
from undertow.comparison import suspects
from undertow.comparison.joint import build, swinging_until
from undertow.comparison.level import Addend, make_level, seen_by
from undertow.conditioning.period import dominant_period

PLAN = Plan(11, springs=("short",), wet_trials=3, dry_trials=3, rate_hz=100.0, seconds=8.0)
LATE = (Addend("imperfect_release", (), late=1.0),)


def found(name: str, size: float, folder):
    """Dry and wet findings of a campaign with one thing hidden."""
    findings = run(load(write(Campaign(PLAN, {name: size}), folder)), jobs=1)
    return next(g for g in findings.groups if g.dry), next(g for g in findings.groups if not g.dry)


@pytest.mark.slow
def test_a_slow_release_is_named_dry_and_wet_with_its_time_and_is_no_memory(tmp_path):
    for group in found("imperfect_release", 0.4, tmp_path):
        verdict = group.verdict
        assert verdict.verdict == ("imperfect_release",)
        assert "it took 0." in verdict.sentence
        assert "After 1 period" not in verdict.sentence
        assert verdict.augmented.nrmse < verdict.baseline.nrmse  # k, c, mu of each trial stay what they are
        assert not any(np.isnan(t.augmented.residual).any() for t in group.trials)


@pytest.mark.slow
def test_a_hold_that_fades_in_another_way_is_named_and_its_first_period_is_not_asked_for(tmp_path, monkeypatch):
    without = tuple(s for s in suspects.SUSPECTS if s.variant != "a hook that lets go slowly")
    monkeypatch.setattr(suspects, "SUSPECTS", without)
    for group in found("imperfect_release", 0.4, tmp_path):
        verdict = group.verdict
        assert verdict.verdict == ("imperfect_release",)
        assert "After 1 period nothing is missing." in verdict.sentence
        assert verdict.augmented.nrmse < 0.7 * verdict.baseline.nrmse
        skipped = [np.isnan(t.augmented.residual).sum() / t.t.size for t in group.trials]
        assert all(0.0 < share < 0.5 for share in skipped)  # fifteen periods, of which the smallest swings two


@pytest.mark.slow
def test_friction_that_the_equation_lacks_goes_with_the_normal_force(tmp_path):
    dry, wet = found("coulomb_friction", 0.6, tmp_path)
    assert dry.verdict.verdict == wet.verdict.verdict == ("coulomb_friction",)
    assert wet.verdict.origin == "structure"
    force = {g.dry: g.verdict.parameters["coulomb_friction"]["force_N"].value for g in (dry, wet)}
    carried = wet.specimen.normal_force_N / dry.specimen.normal_force_N
    assert carried < 0.95
    assert force[False] / force[True] == pytest.approx(carried, abs=0.02)  # a scatter of 5 % a trial


@pytest.mark.slow
def test_a_force_with_its_own_clock_is_proved_with_the_unseen_trials_own_phase(tmp_path):
    dry, wet = found("external_forcing", 0.02, tmp_path)
    assert dry.verdict.verdict == ()
    assert wet.verdict.verdict == ("external_forcing",)
    assert "with only that trial's size and phase of the force fitted" in wet.verdict.sentence
    assert math.isnan(wet.verdict.augmented.held_out_nrmse)  # no other trial says what phase an unseen one has
    unseen = [t for t in wet.trials if t.held_out]
    assert unseen
    assert all(t.augmented.nrmse < 0.5 * t.nrmse["baseline"] for t in unseen)


def test_a_model_without_the_release_starts_a_period_later_and_not_at_rest():
    motion = member("short", SHORT[-1:], 5000).motions[0]
    assert seen_by((), motion) is motion
    later = seen_by(LATE, motion)
    assert later.windowed("t")[0] == pytest.approx(dominant_period(motion), abs=0.02)
    assert later.windowed("t")[-1] == motion.windowed("t")[-1]
    assert motion.window.held
    assert not later.window.held


def test_a_motion_that_swings_twice_starts_early_enough_to_swing_on():
    motion = member("short", SHORT[-1:], 5000).motions[0]
    period = dominant_period(motion)
    brief = replace(motion, inside=motion.inside & (motion.t < 1.3 * period))
    later = seen_by(LATE, brief)
    assert 0.4 * period < later.windowed("t")[0] < 0.9 * period
    assert not later.window.held


def test_of_a_small_release_that_starts_later_a_period_counts():
    small = member("short", (0.003,), 5000)
    (motion,) = small.motions
    later = seen_by(LATE, motion)
    start = later.windowed("t")[0]
    assert swinging_until(motion, small, motion) < start + 0.5 * dominant_period(motion)  # friction soon holds it
    assert swinging_until(motion, small, later) == pytest.approx(start + dominant_period(later))
    (trial,) = build(make_level([small]), LATE).trials
    assert trial.t[-1] - trial.t[0] > 0.9 * dominant_period(later)


@pytest.mark.slow
def test_bristles_that_hardly_slide_are_named_though_the_dry_means_are_bent(tmp_path):
    for group in found("presliding", 8.0, tmp_path):
        assert group.verdict.verdict == ("presliding",)
        assert group.verdict.confidence > 0.5
