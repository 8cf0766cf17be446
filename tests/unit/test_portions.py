"""Which trials go through together: whole waters, dry ones first, no more than fit, none twice and none left out."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from undertow.campaign.config import RunConfig, load
from undertow.campaign.run import portions as division
from undertow.campaign.run.portions import Portion, portions
from undertow.recording.catalogue import Entry
from undertow.recording.recording import Condition

CONFIG = """\
name: many
recordings:
  files: "*.csv"
  channels: {time: {column: t, unit: s}, displacement: {column: x, unit: m}}
trials:
  group_by: [spring, level]
"""
DRY = "  dry: {level: dry}\n"


@pytest.fixture
def config(tmp_path: Path) -> RunConfig:
    return made(tmp_path, DRY)


def made(folder: Path, dry: str) -> RunConfig:
    (folder / "config.yaml").write_text(CONFIG + dry)
    return load(folder / "config.yaml")


def trials(spring: str, level: Condition, number: int) -> list[Entry]:
    return [
        Entry(f"{spring}{level}{i}", Path(f"{spring}{level}{i}.csv"), {"spring": spring, "level": level})
        for i in range(number)
    ]


def names(plan: Sequence[Portion]) -> list[list[str]]:
    return [[entry.name for entry in portion.entries] for portion in plan]


def many(levels: int, a_group: int = 3) -> list[Entry]:
    """Wet groups on two springs, and two dry groups in between."""
    wet = [e for level in range(levels) for spring in "ab" for e in trials(spring, 1.0 + level, a_group)]
    return [*wet, *trials("a", "dry", 2), *trials("b", "dry", 2)]


def test_a_campaign_that_fits_is_one_portion_in_its_own_order(config: RunConfig) -> None:
    entries = many(3)
    plan = portions(config, entries, at_once=len(entries))
    assert names(plan) == [[e.name for e in entries]]
    assert (plan[0].groups, plan[0].waters, plan[0].divided) == (8, 3, 0)


def test_every_trial_goes_through_once_and_dry_ones_go_first(config: RunConfig) -> None:
    entries = many(20)
    plan = portions(config, entries, at_once=15)
    gone = [name for one in names(plan) for name in one]
    assert sorted(gone) == sorted(e.name for e in entries)
    assert names(plan)[0] == ["adry0", "adry1", "bdry0", "bdry1"]
    assert all(portion.size <= 15 for portion in plan)
    assert sum(portion.groups for portion in plan) == 42
    assert sum(portion.waters for portion in plan) == 20


def test_groups_of_one_water_are_never_in_two_portions(config: RunConfig) -> None:
    plan = portions(config, many(20), at_once=10)  # 10: a water has 6, so that two do not fit
    for level in range(20):
        levels = [{e.conditions["level"] for e in portion.entries} for portion in plan]
        assert sum(1.0 + level in held for held in levels) == 1


def test_a_water_that_is_too_large_is_divided_between_groups_and_this_is_said(config: RunConfig) -> None:
    crowd = [e for i in range(9) for e in trials(f"s{i}", 1.0, 4)]
    plan = portions(config, [*crowd, *trials("a", "dry", 2)], at_once=10)
    assert [portion.divided for portion in plan] == [0, 9, 9, 9, 9, 9]
    for portion in plan[1:]:
        springs = {str(e.conditions["spring"]) for e in portion.entries}
        assert portion.size == 4 * len(springs), "a group is never cut"


def test_a_group_that_is_too_large_goes_alone_and_is_not_called_divided(config: RunConfig) -> None:
    plan = portions(config, [*trials("a", 1.0, 30), *trials("a", 2.0, 2)], at_once=10)
    assert [(portion.size, portion.divided) for portion in plan] == [(30, 0), (2, 0)]


def test_without_dry_trials_every_group_is_a_water_of_its_own(tmp_path: Path) -> None:
    config = made(tmp_path, "")
    plan = portions(config, many(5), at_once=6)
    assert all(portion.size <= 6 and not portion.divided for portion in plan)


def test_a_trial_that_lacks_a_condition_goes_first_and_stops_nothing_here(config: RunConfig) -> None:
    lost = Entry("lost", Path("lost.csv"), {"spring": "a"}, problem="its name does not fit")
    plan = portions(config, [*many(20), lost], at_once=15)
    assert names(plan)[0][0] == "lost"


def test_large_files_make_small_portions(config: RunConfig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(division, "BYTES_AT_ONCE", 250)
    entries = []
    for level in range(4):
        for one in trials("a", 1.0 + level, 1):
            path = tmp_path / one.path
            path.write_bytes(b"0" * 100)
            entries.append(Entry(one.name, path, one.conditions))
    assert [portion.size for portion in portions(config, entries)] == [2, 2]
