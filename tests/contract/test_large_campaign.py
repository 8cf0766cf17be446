"""A campaign that does not fit into memory: what is held stays the same, what is found too, and nothing is lost."""

from __future__ import annotations

import json
import weakref
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.campaign_scale import WATER, make
from tests.command_line import undertow
from tests.findings_fixture import small_findings
from tests.small_campaign import Campaign, make_campaign, recorded
from tests.written import csv_text, levels_table, mismatch_table, trials_table, verdict_json
from undertow.campaign.config import load
from undertow.campaign.run import Course, gathered, run
from undertow.campaign.run import course as campaign_run
from undertow.campaign.run import folder as run_folder
from undertow.campaign.run import tasks as group_tasks
from undertow.campaign.run.analysis import GroupTask
from undertow.campaign.run.checking import Checked
from undertow.campaign.run.folder import run_to_folder
from undertow.campaign.run.gathered import Gathered
from undertow.conditioning.condition import condition
from undertow.conditioning.motion import Motion
from undertow.discrepancy.findings import GroupFindings, TrialFindings
from undertow.discrepancy.mismatch import Mismatch
from undertow.discrepancy.verdict import Verdict
from undertow.errors import UndertowError
from undertow.recording.catalogue import Entry
from undertow.recording.recording import Recording

TABLES = ("trials.csv", "levels.csv", "mismatch.csv", "verdict.json")
AT_ONCE = 20
SHOWN = 3


@pytest.fixture(autouse=True, scope="module")
def no_page() -> Iterator[None]:
    """Pages take seconds each and are tested elsewhere."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(run_folder, "write_report", lambda *_: None)
        yield


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Campaign:
    """Five springs of two trials."""
    return make_campaign(tmp_path_factory.mktemp("five"), [0.03, 0.05], springs=[f"s{i}" for i in range(5)])


@pytest.fixture(scope="module")
def whole(campaign: Campaign) -> Path:
    """Its run folder, all trials at once."""
    run_to_folder(campaign.config, out=campaign.folder / "whole", jobs=1)
    return campaign.folder / "whole"


def test_in_portions_the_same_is_found_as_at_once(
    campaign: Campaign, whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(campaign_run, "TRIALS_AT_ONCE", 4)
    finished = run_to_folder(campaign.config, out=tmp_path / "run", jobs=1)
    assert finished.extent.groups == 5
    for name in TABLES:
        assert (tmp_path / "run" / name).read_bytes() == (whole / name).read_bytes(), name
    assert {p.name for p in (tmp_path / "run").iterdir()} == {p.name for p in whole.iterdir()}


def test_what_dry_trials_say_reaches_every_portion(tmp_path: Path) -> None:
    config = load(make(tmp_path, 8, WATER), ["discrepancy.suspects=[linear_damping]", "identify=[output_error]"])
    whole, parts = Gathered(config), Gathered(config)
    for part in Course(config, jobs=1).parts():
        whole.add(part)
    portions = list(Course(config, jobs=1, at_once=4).parts())
    assert [[g.dry for g in part.groups] for part in portions] == [[True], [False], [False]]
    for part in portions:
        parts.add(part)
    one, other = whole.findings({}), parts.findings({})
    assert verdict_json(one) == verdict_json(other)
    for table in (trials_table, levels_table, mismatch_table):
        assert csv_text(table(one)) == csv_text(table(other))
    assert all(group.structure is not None for group in other.groups if not group.dry)


def test_an_interruption_between_portions_loses_nothing_and_resume_gives_the_same(
    campaign: Campaign, whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(campaign_run, "TRIALS_AT_ONCE", 4)
    analyse, done = campaign_run.analyse, list[GroupTask]()

    def interrupted(task: GroupTask) -> GroupFindings:
        if len(done) == 3:
            raise KeyboardInterrupt("in the middle")
        done.append(task)
        return analyse(task)

    monkeypatch.setattr(campaign_run, "analyse", interrupted)
    with pytest.raises(KeyboardInterrupt, match="in the middle"):
        run_to_folder(campaign.config, out=tmp_path / "run", jobs=1)
    assert not (tmp_path / "run" / "trials.csv").exists()
    assert sorted(p.name for p in (tmp_path / "run").iterdir()) == ["config.yaml", "stages"]
    done.clear()

    def counted(task: GroupTask) -> GroupFindings:
        done.append(task)
        return analyse(task)

    monkeypatch.setattr(campaign_run, "analyse", counted)
    run_to_folder(campaign.config, out=tmp_path / "run", jobs=1, resume=True)
    assert len(done) == 2, "three of five groups were finished"
    for name in TABLES:
        assert (tmp_path / "run" / name).read_bytes() == (whole / name).read_bytes(), name


def test_a_trial_that_fails_in_a_late_portion_is_listed_and_the_command_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(campaign_run, "TRIALS_AT_ONCE", 2)
    made = make_campaign(tmp_path, [0.04], springs=["a", "b", "c"])
    (tmp_path / made.files[2]).write_text("t,x,a\n0,1,2\n")
    said = undertow(capsys, "run", made.config, "--out", tmp_path / "run", "--jobs", 1)
    assert said.code == 3
    assert f"failed: trial {Path(made.files[2]).stem}" in said.err
    assert "read and condition: 3 of 3" in said.err
    assert said.err.count("read and condition: 0 of 3") == 1
    table = pd.read_csv(tmp_path / "run" / "trials.csv")
    assert table.outcome.str.startswith("failed").tolist() == [False, False, True]


def test_a_campaign_of_which_nothing_can_be_used_says_how_many_trials_it_has(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(campaign_run, "TRIALS_AT_ONCE", 2)
    made = make_campaign(tmp_path, [0.04], springs=["a", "b", "c"])
    for name in made.files:
        (tmp_path / name).write_text("t,x,a\n0,1,2\n")
    with pytest.raises(UndertowError, match="none of 3 trials can be used: trial r00"):
        run(load(made.config), jobs=1)


# ---------------------------------------------------------------- what is held, with an analysis that takes no time
@cache
def one_motion() -> Motion:
    time, x, a = recorded(0.04, 0).T
    return condition(Recording("r", time, {"displacement": x, "acceleration": a}))


def quickly(task: GroupTask) -> GroupFindings:
    """Findings of the right shape at once: a mismatch that grows with the group's number, no fits."""
    far = 0.01 * (1.0 + float(str(task.key["spring"])[1:]))
    trials = tuple(
        TrialFindings(
            m, {}, {"baseline": far}, Mismatch(m.name, far, 0.01, 0.05), m.t, m.x, m.x, m.name in task.held_out
        ) for m in task.motions
    )  # fmt: skip
    names = tuple(m.name for m in task.motions)
    verdict = Verdict(task.key, names, task.held_out, "nothing_missing", sentence="nothing is missing")
    equation = small_findings().groups[0].equation
    return GroupFindings(task.key, task.dry, trials, task.specimen, None, {}, equation, {}, verdict)


Tasks = Sequence[GroupTask]
Groups = Sequence[GroupFindings]
Judge = Callable[..., list[GroupFindings]]


def taken(_: object, tasks: Tasks, groups: Groups, *__: object) -> list[GroupFindings]:
    return list(groups)


def renamed(entry: Entry) -> Recording:
    return replace(one_motion().recording, name=entry.name, conditions=entry.conditions)


class StandIn:
    """Reading, conditioning, analysis and search that take no time, in this process; ``alive`` counts motions."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, judge: Judge = taken) -> None:
        self._made = list[weakref.ref[Motion]]()
        monkeypatch.setattr(campaign_run, "Checker", lambda *_: self._checked)
        monkeypatch.setattr(campaign_run, "analyse", quickly)
        monkeypatch.setattr(campaign_run.checkpoints, "save", lambda *_: None)
        monkeypatch.setattr(campaign_run, "judged", judge)
        monkeypatch.setattr(campaign_run, "each_once", list)  # copies stand for trials here

    def _checked(self, entry: Entry) -> Checked:
        motion = replace(one_motion(), recording=renamed(entry))
        self._made.append(weakref.ref(motion))
        return Checked(entry.name, entry.conditions, motion)

    def alive(self) -> int:
        """Motions of this campaign that this process still holds."""
        return sum(one() is not None for one in self._made)


def repeated(folder: Path, groups: int, a_group: int = 4) -> Campaign:
    """A campaign whose trials are one recording again and again, in groups."""
    made = make_campaign(folder, [0.04])
    rows = [f"r{i:04d}.csv,s{i // a_group}" for i in range(groups * a_group)]
    for row in rows[1:]:
        (folder / f"r{row[1:5]}.csv").hardlink_to(folder / made.files[0])
    (folder / made.files[0]).rename(folder / "r0000.csv")
    (folder / "campaign.csv").write_text("\n".join(["file,spring", *rows]) + "\n")
    return made


@pytest.mark.parametrize("groups", [15, 60])
def test_what_is_held_does_not_grow_with_the_campaign(
    groups: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    held = list[int]()

    def judge(config: object, tasks: Tasks, found: Groups, *_: object) -> list[GroupFindings]:
        held.append(campaign.alive())
        return list(found)

    campaign = StandIn(monkeypatch, judge)
    monkeypatch.setattr(campaign_run, "TRIALS_AT_ONCE", AT_ONCE)
    monkeypatch.setattr(gathered, "GROUPS_SHOWN", SHOWN)
    finished = run_to_folder(repeated(tmp_path / "c", groups).config, out=tmp_path / "run", jobs=1)
    assert len(held) == 4 * groups / AT_ONCE
    assert max(held) <= AT_ONCE + 4 * SHOWN
    # everything is on disk, and the loudest groups are shown
    assert (finished.extent.trials, finished.extent.groups) == (4 * groups, groups)
    assert len(pd.read_csv(tmp_path / "run" / "mismatch.csv")) == 4 * groups
    assert len(json.loads((tmp_path / "run" / "verdict.json").read_text())["groups"]) == groups
    assert {g.key["spring"] for g in finished.findings.groups} == {f"s{groups - 1 - i}" for i in range(SHOWN)}
    assert f"{groups - SHOWN} more groups: {tmp_path / 'run' / 'verdict.json'}" in finished.summary


def test_one_group_of_many_trials_is_fitted_and_searched_on_some_and_all_are_listed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    searched: list[tuple[int, int]] = []

    def judge(config: object, tasks: Tasks, found: Groups, *_: object) -> list[GroupFindings]:
        searched.extend((len(t.motions), len(g.trials)) for t, g in zip(tasks, found, strict=True))
        names = [tuple(t.motion.name for t in g.trials) for g in found]
        return [replace(g, verdict=replace(g.verdict, trials=n)) for g, n in zip(found, names, strict=True)]

    StandIn(monkeypatch, judge)
    config = load(repeated(tmp_path / "c", 1, a_group=300).config)
    (part,) = Course(config, jobs=1).parts()
    most = group_tasks.JOINT_AT_MOST
    assert searched == [(most, most)]
    assert len(part.groups[0].trials) == 300
    assert len(set(part.groups[0].verdict.trials)) == 300


def test_the_trials_looked_at_together_are_spread_over_all_amplitudes_and_held_out_by_the_same_rule(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    motion = one_motion()
    motions = [
        replace(motion, amplitude=0.01 + 1e-4 * i, recording=replace(motion.recording, name=f"r{i:03d}"))
        for i in range(178)  # 178: every third of them, the rule for held-out trials, would be all of those looked at
    ]
    config = load(make_campaign(tmp_path, [0.04]).config)
    task = group_tasks.group_task(config, (("spring", "s0"),), motions, (), {})
    joint = [m.amplitude for m in task.joint]
    assert (joint[0], joint[-1]) == (motions[0].amplitude, motions[-1].amplitude)
    assert np.max(np.diff(joint)) <= 1.5 * np.min(np.diff(joint))
    assert len(task.held_out) == 20
    assert set(task.held_out) < {m.name for m in task.joint}
    assert set(task.apart) == {m.name for m in motions} - {m.name for m in task.joint}


def test_a_list_of_held_out_trials_is_among_those_looked_at_together(tmp_path: Path) -> None:
    motion = one_motion()
    motions = [
        replace(motion, amplitude=0.01 + 1e-4 * i, recording=replace(motion.recording, name=f"r{i:03d}", path=""))
        for i in range(178)
    ]
    config = load(make_campaign(tmp_path, [0.04]).config, ["trials.hold_out=[r001, r002, r003]"])
    task = group_tasks.group_task(config, (("spring", "s0"),), motions, (), {})
    assert task.held_out == ("r001", "r002", "r003")
    assert len(task.joint) == group_tasks.JOINT_AT_MOST
    config = load(make_campaign(tmp_path, [0.04]).config, ['trials.hold_out=["r0*"]'])
    task = group_tasks.group_task(config, (("spring", "s0"),), motions, (), {})
    assert len(task.held_out) == 20
    assert len(task.joint) == group_tasks.JOINT_AT_MOST


def test_dry_trials_that_need_something_are_looked_at_beside_every_portion(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    looked_at: list[list[object]] = []

    def needy(_: object, tasks: Tasks, found: Groups, *__: object) -> list[GroupFindings]:
        looked_at.append([t.key["spring"] for t in tasks])
        needs = [replace(g.verdict, status="explained", verdict=("cubic_stiffness",)) for g in found]
        return [replace(g, verdict=v) if g.dry else g for g, v in zip(found, needs, strict=True)]

    StandIn(monkeypatch, needy)
    made = repeated(tmp_path / "c", 4, a_group=2)
    made.edit("  group_by: [spring]\n", "  group_by: [spring]\n  dry: {spring: s0}\n")
    monkeypatch.setattr(campaign_run, "structures_of", lambda *_: {})
    parts = list(Course(load(made.config), jobs=1, at_once=4).parts())
    assert looked_at == [["s0"], ["s0", "s1", "s2"], ["s0", "s3"]]
    assert [[g.key["spring"] for g in part.groups] for part in parts] == [["s0"], ["s1", "s2"], ["s3"]]


def test_groups_of_a_water_that_cannot_be_judged_together_say_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    StandIn(monkeypatch)
    monkeypatch.setattr(campaign_run, "structures_of", lambda *_: {})
    made = repeated(tmp_path / "c", 6, a_group=2)
    dry = '  dry: {level: 1.63}\n  conditions: {"r000[01].csv": {level: 1.63}}\n'
    made.edit("  group_by: [spring]\n", f"  group_by: [spring]\n{dry}")
    notes = [part.notes for part in Course(load(made.config), jobs=1, at_once=4).parts()]
    assert notes[1][-1] == (
        "spring s1 to spring s2: 2 of this water's 5 groups, which are too many to be judged together"
    )


def test_levels_are_counted_by_what_is_judged_together(tmp_path: Path) -> None:
    config = load(make(tmp_path, 2, WATER))
    spring = ()  # of one spring all of a key is what its dry trials fix
    groups = {(("level", "dry"),): True, (("level", 1.0),): False, (("level", 2.0),): False}
    assert group_tasks.level_count(config, groups, {spring: None}) == 3
    assert group_tasks.level_count(config, groups, {}) == 3
    one = {(("level", 1.0), ("spring", "a")): False, (("level", 1.0), ("spring", "b")): False}
    assert group_tasks.level_count(config, one, {(("spring", "a"),): None, (("spring", "b"),): None}) == 1
    assert group_tasks.level_count(config, one, {}) == 2
