"""What becomes of trials and groups whose channels contradict each other; and of doubts that a config accepts."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.small_campaign import Campaign, make_campaign, recorded, write_table
from undertow.campaign.config import RunConfig, load
from undertow.campaign.run.checking import Checked, Checker, _stops, sorted_out
from undertow.campaign.run.cut_off import SeenEnd
from undertow.discrepancy.findings import FailedTrial
from undertow.errors import ConfigError, RangeEnd
from undertow.recording.catalogue import Entry
from undertow.recording.gather import gather

IN_G = 1.0 / 9.80665


@pytest.fixture
def campaign(tmp_path: Path) -> Campaign:
    """Two springs of three trials each: r00 to r02, r03 to r05."""
    return make_campaign(tmp_path / "c", [0.03, 0.04, 0.05], springs=("long", "stiff"))


def spoil(campaign: Campaign, factor: float, *names: str) -> None:
    """Accelerations of trials multiplied."""
    for name in names:
        table = recorded(0.03 + 0.01 * (int(name[1:]) % 3), int(name[1:]))
        table[:, 2] *= factor
        write_table(campaign.folder / f"{name}.csv", table)


def entries_of(config: RunConfig) -> tuple[Entry, ...]:
    return gather(config.catalogue())


def checked(config: RunConfig, accepted: dict[str, tuple[str, ...]] | None = None) -> list[Checked]:
    """Every trial as a run checks it; ``accepted`` as `recordings.accept` says it of a trial."""
    check = Checker(config, config.catalogue())
    out = []
    for entry in entries_of(config):
        known = (accepted or {}).get(entry.name, ())
        out.append(check(_Accepting(entry, known) if known else entry))
    return out


class _Accepting:
    """An entry whose doubts are known."""

    def __init__(self, entry: Entry, accepted: tuple[str, ...]) -> None:
        self._entry, self.accepted = entry, accepted

    def __getattr__(self, name: str) -> object:
        return getattr(self._entry, name)


def test_a_trial_that_contradicts_alone_fails_alone(campaign: Campaign) -> None:
    spoil(campaign, IN_G, "r01")
    config = load(campaign.config)
    seen = sorted_out(config, checked(config))
    assert [f.name for f in seen.failed] == ["r01"]
    assert seen.failed[0].reason.startswith("trial r01: acceleration is 0.102 times the second derivative")
    assert sorted(m.name for m in seen.motions) == ["r00", "r02", "r03", "r04", "r05"]
    assert seen.contradicted == {}


def test_half_of_a_group_that_contradicts_is_the_groups(campaign: Campaign) -> None:
    spoil(campaign, IN_G, "r00", "r02")
    config = load(campaign.config)
    seen = sorted_out(config, checked(config))
    assert seen.failed == ()
    assert len(seen.motions) == 6
    (key,) = seen.contradicted
    assert dict(key) == {"spring": "long"}
    said = seen.contradicted[key]
    assert said.startswith("the channels contradict each other in 2 of 3 trials (r00: acceleration is 0.10")
    assert "acceleration seems to be in g, not m/s^2" in said


def test_where_every_group_contradicts_the_run_stops_with_one_sentence_a_group(campaign: Campaign) -> None:
    spoil(campaign, IN_G, "r00", "r01", "r04", "r05")
    config = load(campaign.config)
    trials = checked(config)
    with pytest.raises(ConfigError, match=r"the channels of every group contradict each other; correct the") as e:
        sorted_out(config, trials)
    lines = str(e.value).splitlines()
    assert [line.partition(":")[0] for line in lines[1:]] == ["  spring long, trial r00", "  spring stiff, trial r04"]
    assert set(sorted_out(config, trials, stops=False).contradicted) == {(("spring", "long"),), (("spring", "stiff"),)}


def test_of_many_groups_five_are_named() -> None:
    one = Checked("r", {}, None, None, ())
    text = _stops({(("spring", f"s{i}"),): replace(one, name=f"r{i}") for i in range(8)})
    assert text.splitlines()[-1] == "  and 3 more groups"
    assert len(text.splitlines()) == 7


def test_a_doubt_is_noted_and_said_once_a_group(campaign: Campaign) -> None:
    spoil(campaign, 1.08, "r00", "r01", "r02")
    config = load(campaign.config)
    trials = checked(config)
    seen = sorted_out(config, trials)
    assert len(seen.motions) == 6
    assert seen.contradicted == {}
    (doubt,) = seen.doubts
    assert doubt.startswith("spring long, r00 and 2 more trials: acceleration is 1.08 times the second derivative")
    noted = next(one.motion for one in trials if one.name == "r01")
    assert noted is not None
    assert any(note.startswith("acceleration is 1.08 times") for note in noted.notes)


@pytest.mark.parametrize(("factor", "kind"), [(IN_G, "unit"), (-1.0, "sign"), (1.08, "gain")])
def test_what_is_accepted_is_noted_and_neither_doubted_nor_a_contradiction(
    campaign: Campaign, factor: float, kind: str
) -> None:
    spoil(campaign, factor, "r00")
    config = load(campaign.config)
    wrong = checked(config, {"r00": ("clock", "hold")})[0]
    assert [f.kind for f in wrong.found] == [kind]
    right = checked(config, {"r00": (kind,)})[0]
    assert right.found == ()
    assert right.contradiction == ""
    assert right.motion is not None
    assert any(note.startswith(f"accepted ({kind}): acceleration is ") for note in right.motion.notes)


def test_a_cut_peak_that_is_known_is_used_and_noted(campaign: Campaign) -> None:
    config = load(campaign.config)
    table = recorded(0.03, 0)
    table[:, 1] = np.clip(table[:, 1], -0.015, 0.015)
    write_table(campaign.folder / "r00.csv", table)
    cut = checked(config)[0]
    assert cut.failed is not None
    assert cut.failed.clipped
    known = checked(config, {"r00": ("clipping", "gain", "hold", "damping", "clock")})[0]
    assert known.motion is not None
    assert known.motion.recording.notes[0].startswith("accepted (clipping): displacement is clipped between -0.015 and")


def test_a_failure_says_what_contradicts_before_anything_else(campaign: Campaign) -> None:
    config = load(campaign.config)
    table, rng = recorded(0.03, 0), np.random.default_rng(1)
    table[:, 1] = 0.03 * np.cos(6.0 * table[:, 0]) + 1e-5 * rng.standard_normal(len(table))
    table[:, 2] = -36.0 * table[:, 1]
    write_table(campaign.folder / "r00.csv", table)
    driven = checked(config)[0]
    assert driven.failed is not None
    assert driven.failed.reason.startswith("trial r00: its amplitude declines by ")
    table[:, 2] *= IN_G
    write_table(campaign.folder / "r00.csv", table)
    also_in_g = checked(config)[0]
    assert also_in_g.failed is not None
    assert also_in_g.failed.reason.startswith("trial r00: acceleration is 0.102 times the second derivative")
    assert also_in_g.contradiction


def test_a_trial_that_sticks_says_so_and_not_that_it_has_few_turns(campaign: Campaign) -> None:
    config = load(campaign.config)
    table = recorded(0.03, 0)
    table[:, 1] = np.where(table[:, 0] < 3.0, 0.03, 0.0) + 1e-5 * np.random.default_rng(1).standard_normal(len(table))
    write_table(campaign.folder / "r00.csv", table)
    stuck = checked(config)[0]
    assert stuck.failed is not None
    assert "r00: it moves from 0.03 to" in stuck.failed.reason
    assert "m at 3 s and stays there without swinging" in stuck.failed.reason


def test_a_trial_with_filled_values_says_so_and_not_that_friction_stops_it(campaign: Campaign) -> None:
    for places in (slice(200, 211), slice(300, 301)):
        table = recorded(0.03, 0)
        table[places, 1] = -9999.0
        write_table(campaign.folder / "r00.csv", table)
        failed = checked(load(campaign.config))[0].failed
        assert failed is not None
        assert "displacement" in failed.reason
        assert "-9999 m" in failed.reason
        assert "values were lost" in failed.reason.replace("where values", "values")


def test_a_trial_whose_release_lies_in_a_gap_fails_unless_its_window_begins_after_it(campaign: Campaign) -> None:
    table = recorded(0.03, 0)
    table[40:115, 1] = np.nan
    write_table(campaign.folder / "r00.csv", table)
    failed = checked(load(campaign.config))[0].failed
    assert failed is not None
    said = r"trial r00: no sample between 0\.39 and 1\.15 s, where the body is let go, .*; begin trials\.window"
    assert re.match(said, failed.reason)
    campaign.edit("trials:", "trials:\n  window: {r00: {start_s: 1.15}}")
    assert checked(load(campaign.config))[0].failed is None


def test_a_specimen_whose_table_does_not_know_a_trial_is_no_failure_of_the_check(campaign: Campaign) -> None:
    campaign.edit("mass_kg: 2637.4", "mass_kg: {by: colour, red: 1.0}")
    config = load(campaign.config)
    assert all(one.failed is None for one in checked(config))


def test_a_trial_whose_window_begins_in_a_hold_begins_at_its_release(campaign: Campaign) -> None:
    for at in range(6):
        table = recorded(0.03 + 0.01 * (at % 3), at)
        held = np.column_stack([np.zeros(100), np.full(100, table[:20, 1].mean()), np.zeros(100)])
        held[:, 1:] += table[:20, 1:].std(axis=0) * np.random.default_rng(at).standard_normal((100, 2))
        table = np.vstack([held, table])
        table[:, 0] = 0.01 * np.arange(len(table))
        write_table(campaign.folder / f"r{at:02d}.csv", table)
    asked = load(campaign.config, ['trials.window={"*": {start_s: 0.5}}'])
    for one, free in zip(checked(asked), checked(load(campaign.config)), strict=True):
        assert one.motion is not None
        assert free.motion is not None
        assert one.motion.window.release_s == pytest.approx(free.motion.window.release_s, abs=0.01)
        (doubt,) = one.found
        assert (doubt.kind, doubt.certain) == ("hold", False)
        assert "a hold before the release is cut off, and the trial used from" in doubt.sentence
    known = checked(asked, {"r00": ("hold",)})[0]
    assert known.motion is not None
    assert known.motion.window.release_s == 0.5


def test_a_trial_that_reaches_the_end_of_anothers_range_is_not_used(campaign: Campaign) -> None:
    config = load(campaign.config)
    trials = checked(config)
    by_name = {one.name: one.motion for one in trials}
    assert by_name["r02"] is not None
    highest = float(np.max(by_name["r02"].recording.channels["displacement"]))
    seen = SeenEnd("r05", "displacement", RangeEnd(highest, True, 1e-3 * highest))
    trials = [replace(one, motion=None, ends=(seen,)) if one.name == "r05" else one for one in trials]
    found = sorted_out(config, trials)
    assert [(f.name, f.clipped) for f in found.failed] == [("r02", True)]
    assert "it is clipped in trial r05" in found.failed[0].reason
    trials = [replace(one, accepted=("clipping",)) if one.name == "r02" else one for one in trials]
    assert sorted_out(config, trials).failed == ()


def test_a_level_that_other_trials_pass_accuses_no_sensor(campaign: Campaign) -> None:
    config = load(campaign.config)
    trials = checked(config)
    by_name = {one.name: one.motion for one in trials}
    assert by_name["r02"] is not None
    highest = float(np.max(by_name["r02"].recording.channels["displacement"]))
    seen = SeenEnd("r05", "displacement", RangeEnd(0.8 * highest, True, 0.01 * highest))
    cut = FailedTrial("r05", "trial r05: clipped", dict(trials[5].conditions), clipped=True)
    trials = [replace(one, motion=None, failed=cut, ends=(seen,)) if one.name == "r05" else one for one in trials]
    (only,) = sorted_out(config, trials).failed
    assert (only.name, only.clipped) == ("r05", False)
    assert "other trials go beyond: only this one is left out" in only.reason
    trials = [
        replace(one, motion=None, failed=replace(cut, name="r04"), ends=(replace(seen, trial="r04"),))
        if one.name == "r04" else one for one in trials
    ]  # fmt: skip
    both = sorted_out(config, trials).failed
    assert [one.name for one in both] == ["r04", "r05"]
    assert all("other trials go beyond: only these 2 are left out" in one.reason for one in both)
