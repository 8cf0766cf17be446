"""Trials that swing like those of another group are found, others are not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from tests.decays import Decay, recorded
from undertow.campaign.run.neighbours import misplaced
from undertow.conditioning.condition import condition
from undertow.conditioning.motion import Motion

AIR, WATER = (("water_depth_m", 1.63),), (("water_depth_m", 2.36),)


def trials(frequencies_hz: Sequence[float], first: int) -> list[Motion]:
    """A decay a frequency, named t1, t2 ..., from three sizes on."""
    decays = [Decay(hz, size_m=0.02 * (1 + i), friction=0.01, seed=first + i) for i, hz in enumerate(frequencies_hz)]
    return [condition(replace(recorded(one), name=f"t{first + i}")) for i, one in enumerate(decays)]


def test_exchanged_trials_are_both_named_with_the_group_they_swing_like() -> None:
    found = misplaced({AIR: trials([1.0, 0.9, 1.0], 1), WATER: trials([0.9, 1.0, 0.9], 4)})
    assert sorted(found) == ["t2", "t5"]
    assert "as the trials of water depth 2.36 m do" in found["t2"]
    assert "recordings.accept" in found["t5"]


def test_a_group_of_its_own_period_and_one_of_scattered_periods_are_left_alone() -> None:
    assert misplaced({AIR: trials([1.0, 1.0, 1.0], 1), WATER: trials([0.9, 0.9, 0.9], 4)}) == {}
    # periods that scatter by 5 %: a trial 10 % off belongs to them
    assert misplaced({AIR: trials([1.0, 1.05, 0.95, 0.9], 1), WATER: trials([0.9, 0.9, 0.9], 5)}) == {}
    # two levels 3 % apart: periods go with amplitude by as much
    assert misplaced({AIR: trials([1.0, 0.97, 1.0, 1.0], 1), WATER: trials([0.97, 0.97, 0.97], 5)}) == {}
    # off its group, but like no other
    assert misplaced({AIR: trials([1.0, 0.8, 1.0], 1), WATER: trials([0.9, 0.9, 0.9], 4)}) == {}


def test_two_trials_are_too_few_to_say_which_is_the_groups() -> None:
    assert misplaced({AIR: trials([1.0, 0.9], 1), WATER: trials([0.9, 0.9, 0.9], 4)}) == {}


def test_one_trial_of_another_clock_is_named_and_its_group_is_not_lost() -> None:
    """One file in milliseconds under a header of seconds had failed its whole group: "something swings so fast"."""
    motions = trials([1.0, 1.05, 0.95, 1.0], 1)
    slow = recorded(Decay(1.0, size_m=0.05, friction=0.01, seed=9))
    motions.append(condition(replace(slow, name="t5", time=1000.0 * slow.time)))
    (said,) = misplaced({WATER: motions}).items()
    assert said[0] == "t5"
    assert "is its time in another unit? correct it for this file (recordings.layouts)" in said[1]
    assert list(misplaced({WATER: motions[2:]})) == ["t5"]
    assert misplaced({WATER: motions[3:]}) == {}
    scattered = [*trials([1.0, 0.98, 0.35], 1), motions[-1]]  # such a group says nothing of what a period should be
    assert misplaced({WATER: scattered}) == {}
    two = [*motions[:2], *trials([40.0, 41.0], 6)]  # which of them is wrong nobody can say
    assert misplaced({WATER: two}) == {}
