"""What is kept of a campaign: all of a small one; of a large one what stands out, and right counts of the rest."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from tests.findings_fixture import small_findings
from undertow.campaign.config import RunConfig, load
from undertow.campaign.run import gathered as keeping
from undertow.campaign.run.gathered import GROUPS_SHOWN, TRIALS_SHOWN, Gathered, PortionFindings
from undertow.discrepancy.findings import FailedTrial, GroupFindings
from undertow.discrepancy.verdict import Status
from undertow.likelihood.fit import Fit
from undertow.quantities import Estimate
from undertow.report.arrange import excess
from undertow.report.tables import NOTES_AT_MOST

CONFIG = """\
name: many
recordings:
  files: "*.csv"
  channels: {time: {column: t, unit: s}, displacement: {column: x, unit: m}}
trials: {group_by: [water_depth_m], dry: {water_depth_m: 1.63}}
"""


@pytest.fixture
def config(tmp_path: Path) -> RunConfig:
    (tmp_path / "c.yaml").write_text(CONFIG)
    return load(tmp_path / "c.yaml")


@cache
def dry_and_open() -> tuple[GroupFindings, GroupFindings]:
    dry, unexplained = small_findings().groups
    return dry, unexplained


def explained(number: int) -> GroupFindings:
    """A wet group that its equation explains, at a level of its own."""
    dry, _ = dry_and_open()
    key = {"water_depth_m": 2.0 + number}
    verdict = replace(dry.verdict, group=key, status="nothing_missing", verdict=())
    return replace(dry, key=key, dry=False, verdict=verdict, fits={})


def loud(number: int, factor: float) -> GroupFindings:
    """A wet group whose trials lie so many times further from their equation."""
    _, group = dry_and_open()
    key = {"water_depth_m": 2.0 + number}
    trials = tuple(replace(t, mismatch=replace(t.mismatch, nrmse=factor * t.mismatch.nrmse)) for t in group.trials)
    return replace(group, key=key, trials=trials, verdict=replace(group.verdict, group=key), fits={})


def part(*groups: GroupFindings, notes: tuple[str, ...] = ()) -> PortionFindings:
    return PortionFindings(groups, (), notes)


def test_of_a_small_campaign_everything_is_kept(config: RunConfig) -> None:
    kept = Gathered(config)
    dry, group = dry_and_open()
    kept.add(PortionFindings((dry, group), (FailedTrial("f", "no release"),), ("a note",)))
    found = kept.findings({"read": 1.0})
    assert found.groups == (dry, group)
    assert (found.failed[0].name, found.notes[0], found.seconds) == ("f", "a note", {"read": 1.0})
    assert (kept.extent.trials, kept.extent.groups, kept.extent.missing) == (8, 2, 4)


def test_springs_that_disagree_stand_behind_the_last_sentence(config: RunConfig) -> None:
    kept = Gathered(config)
    pair = []
    for spring, mass in (("soft", 30.0), ("stiff", 40.0)):
        fit = Fit("output_error", ("r",), {}, {"added_mass_kg": Estimate(mass, 0.2, unit="kg")})
        key = {"spring": spring, "water_depth_m": 2.0}
        pair.append(replace(explained(0), key=key, fits={"output_error": fit}))
    kept.add(part(*pair))
    said = kept.findings({}).across_groups
    begun = "The equation explains 2 groups; nothing is missing. But water depth 2 m: added_mass_kg is 30"
    assert said.startswith(begun)


def test_failed_trials_and_groups_without_a_result_stand_in_the_last_sentence(config: RunConfig) -> None:
    kept = Gathered(config)
    lost = [FailedTrial(f"f{i}", "no release", {"water_depth_m": 9.0 + i // 2}) for i in range(3)]
    kept.add(PortionFindings((explained(0),), (*lost, FailedTrial("g", "no release", {"water_depth_m": 2.0})), ()))
    assert kept.findings({}).across_groups == (
        "The equation explains 1 group; nothing is missing. 4 trials failed, and 2 groups have no result: water depth "
        "9 m; water depth 10 m."
    )
    one = Gathered(config)
    one.add(PortionFindings((explained(0),), lost[:1], ()))
    assert one.findings({}).across_groups.endswith(" 1 trial failed, and 1 group has no result: water depth 9 m.")


def test_of_a_large_campaign_the_dry_groups_and_the_loudest_are_kept_and_all_are_counted(config: RunConfig) -> None:
    kept = Gathered(config)
    dry, _ = dry_and_open()
    kept.add(part(replace(dry, key={"water_depth_m": 1.63})))
    for start in range(0, 300, 50):
        quiet = [explained(i) for i in range(start, start + 49)]
        kept.add(part(*quiet, loud(start + 49, 1.0 + start)))
    found = kept.findings({})
    assert len(found.groups) == GROUPS_SHOWN
    assert found.groups[0].dry
    assert {g.key["water_depth_m"] for g in found.groups if g.verdict.status == "unknown"} == {
        2.0 + start + 49 for start in range(0, 300, 50)
    }
    assert (kept.extent.groups, kept.extent.trials) == (301, 4 * 301)
    assert kept.extent.statuses == {"nothing_missing": 295, "unknown": 6}
    assert found.across_groups == (
        "The equation leaves out: something unknown in 6 of 301 groups. In 295 groups nothing is missing."
    )
    assert len(kept.extent.sizes) == GROUPS_SHOWN


def test_a_sensor_s_fault_is_nothing_that_the_equation_leaves_out(config: RunConfig) -> None:
    kept = Gathered(config)
    _, group = dry_and_open()
    verdict = replace(group.verdict, status="explained", verdict=("clipping",), origin="instrument")
    kept.add(part(replace(group, verdict=verdict)))
    assert kept.findings({}).across_groups == "Not the motion but a sensor shows: clipping."


@pytest.mark.parametrize(
    ("status", "alternatives", "said"),
    [
        ("explained", (), "hidden resonator"),
        ("not_identifiable", (("relaxation",),), "hidden resonator or relaxation"),
        ("unknown", (), "something unknown beside or instead of hidden resonator"),
    ],
)
def test_the_sentence_over_all_groups_says_no_more_than_each_verdict(
    config: RunConfig, status: Status, alternatives: tuple[tuple[str, ...], ...], said: str
) -> None:
    kept = Gathered(config)
    _, group = dry_and_open()
    rest = ("unknown",) if status == "unknown" else ()
    verdict = replace(group.verdict, status=status, verdict=("hidden_resonator", *rest), alternatives=alternatives)
    kept.add(part(replace(group, verdict=verdict)))
    assert kept.findings({}).across_groups == f"The equation leaves out: {said}."


@pytest.mark.parametrize("portions", [60, 240])
def test_how_many_series_are_held_does_not_depend_on_how_many_trials_went_through(
    config: RunConfig, portions: int
) -> None:
    kept = Gathered(config)
    held = []
    for i in range(portions):
        kept.add(part(explained(i)))
        held.append(sum(len(group.trials) for group in kept._groups))
    assert max(held) == held[-1] == 4 * GROUPS_SHOWN
    assert all(not group.trials for group in kept._compared)
    assert len(kept._compared) <= keeping.COMPARED_AT_MOST + 1
    assert len(kept.extent.sizes) == GROUPS_SHOWN


def test_of_a_large_group_the_ends_and_the_worst_trials_are_kept_and_the_size_is_known(config: RunConfig) -> None:
    _, group = dry_and_open()
    trials = tuple(
        replace(
            group.trials[i % 4],
            motion=replace(group.trials[i % 4].motion, amplitude=0.01 + 1e-5 * i),
            mismatch=replace(group.trials[i % 4].mismatch, trial=f"t{i}", nrmse=0.1 + 0.001 * ((37 * i) % 400)),
        )
        for i in range(400)
    )  # fmt: skip
    kept = Gathered(config)
    kept.add(part(replace(group, trials=trials)))
    (shown,) = kept.findings({}).groups
    assert len(shown.trials) == TRIALS_SHOWN
    assert shown.trials[0] is trials[0]
    assert shown.trials[-1] is trials[-1]
    worst = sorted(trials[1:-1], key=excess)[-(TRIALS_SHOWN - 2) :]
    assert {t.mismatch.trial for t in shown.trials[1:-1]} == {t.mismatch.trial for t in worst}
    assert kept.extent.size_of(shown) == (400, sum(t.mismatch.missing for t in trials))


def test_notes_beyond_what_the_manifest_holds_are_counted(config: RunConfig) -> None:
    kept = Gathered(config)
    for _ in range(3):
        kept.add(part(explained(0), notes=tuple(str(i) for i in range(NOTES_AT_MOST // 2))))
    notes = kept.findings({}).notes
    assert len(notes) == NOTES_AT_MOST + 1
    assert notes[-1] == f"{NOTES_AT_MOST // 2} more notes stand in notes.txt"


def test_too_many_groups_are_not_compared_pair_by_pair_and_this_is_said(
    config: RunConfig, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(keeping, "group_drifts", lambda groups, water: pytest.fail(f"{len(groups)} were compared"))
    kept = Gathered(config)
    kept.add(part(*(explained(i) for i in range(keeping.COMPARED_AT_MOST + 1))))
    assert kept.findings({}).notes[-1].startswith("parameters that drift from group to group were not looked for: 201")


def test_run_keeps_every_series(config: RunConfig) -> None:
    kept = Gathered(config, everything=True)
    kept.add(part(*(explained(i) for i in range(3 * GROUPS_SHOWN))))
    assert len(kept.findings({}).groups) == 3 * GROUPS_SHOWN
