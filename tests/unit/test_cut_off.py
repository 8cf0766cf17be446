"""Trials that a sensor's range cut off are said in their group's verdict."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.findings_fixture import small_findings
from undertow.campaign.run.cut_off import SeenEnd, common, reached, with_clipped
from undertow.discrepancy.findings import FailedTrial
from undertow.errors import ClippedError, RangeEnd
from undertow.recording.quality import check
from undertow.recording.recording import Recording


class Grouped:
    """The one thing asked of a config: a trial's group."""

    @staticmethod
    def group_key(conditions):
        """Every condition is part of it."""
        return tuple(conditions.items())


@pytest.fixture(scope="module")
def group():
    """A group in which nothing is missing."""
    found = small_findings().groups[0]
    sentence = "dry: the equation explains 3 of 3 trials; nothing is missing."
    return replace(found, verdict=replace(found.verdict, status="nothing_missing", verdict=(), sentence=sentence))


def test_a_sensor_cut_off_is_the_verdict_where_nothing_else_is_missing(group):
    failed = (FailedTrial("t07", "clipped", dict(group.key), clipped=True),)
    verdict = with_clipped(Grouped(), group, failed).verdict
    assert verdict.verdict == ("clipping",)
    assert verdict.origin == "instrument"
    assert "t07" in verdict.sentence
    assert "nothing is missing" not in verdict.sentence


def test_beside_another_name_it_is_only_said(group):
    named = replace(group, verdict=replace(group.verdict, status="explained", verdict=("linear_damping",)))
    failed = (FailedTrial("t07", "clipped", dict(group.key), clipped=True),)
    verdict = with_clipped(Grouped(), named, failed).verdict
    assert verdict.verdict == ("linear_damping",)
    assert "t07" in verdict.sentence


def test_trials_of_other_groups_and_other_faults_say_nothing(group):
    failed = (
        FailedTrial("t08", "clipped", {"spring": "another"}, clipped=True),
        FailedTrial("t09", "no release", dict(group.key)),
    )
    assert with_clipped(Grouped(), group, failed) is group


@pytest.mark.parametrize(
    ("value", "upper", "size", "is_cut"),
    [
        (0.02, True, 0.01997, True),
        (0.02, True, 0.0199, False),  # four standard deviations short of it: a cut swing comes to the level
        (0.02, True, 0.021, False),
        (-0.02, False, 0.0201, True),
        (-0.02, False, 0.0199, False),
        (-0.02, False, 0.021, False),  # beyond it: its range was another
    ],
)
def test_a_trial_that_comes_to_an_end_of_range_seen_elsewhere_is_cut_too(value, upper, size, is_cut):
    t = np.arange(400) / 100.0
    recording = Recording("t02", t, {"displacement": size * np.cos(6.0 * t)})
    said = reached(recording, [SeenEnd("t01", "displacement", RangeEnd(value, upper, 2e-4))])
    assert bool(said) is is_cut
    assert ("trial t02: displacement comes to" in said and "clipped in trial t01" in said) is is_cut
    assert reached(recording, [SeenEnd("t01", "spring_force", RangeEnd(value, upper, 2e-4))]) == ""


def test_an_end_beyond_which_other_trials_go_is_none_of_the_sensors():
    t = np.arange(400) / 100.0
    high, low = (SeenEnd("t01", "displacement", RangeEnd(end, end > 0.0, 2e-4)) for end in (0.02, -0.02))
    beside = [Recording("t02", t, {"displacement": 0.0199 * np.cos(6.0 * t)})]
    assert common([high, low], beside) == (high, low)
    lopsided = Recording("t03", t, {"displacement": 0.0199 * np.cos(6.0 * t) - 1e-3})
    assert common([high, low], [*beside, lopsided]) == (high,)
    assert common([high], [Recording("t04", t, {"acceleration": np.cos(6.0 * t)})]) == (high,)


def test_a_recording_cut_at_its_range_says_so_by_its_error():
    time = np.arange(0.0, 10.0, 0.01)
    swing = np.clip(0.1 * np.exp(-0.05 * time) * np.cos(5.0 * time), -0.06, 0.06)
    swing += np.where(np.abs(swing) < 0.06, 1e-4 * np.random.default_rng(3).standard_normal(time.size), 0.0)
    with pytest.raises(ClippedError, match="displacement is clipped"):
        check(Recording("cut", time, {"displacement": swing}))
