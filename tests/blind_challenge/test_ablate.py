"""Campaigns with something taken away: what is left of them, and what is counted."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd
import pytest
from ruamel.yaml import YAML

from experiments.blind_challenge import ablate
from experiments.blind_challenge.judge import CaseResult, GroupResult

CONFIG = {"name": "c0001", "trials": {"group_by": ["spring", "water_depth_m"], "dry": {"water_depth_m": 1.2}}}
INDEX = pd.DataFrame({
    "file": [f"recordings/r{i}.csv" for i in range(5)], "spring": ["soft", "soft", "stiff", "soft", "soft"],
    "water_depth_m": [1.2, 1.2, 1.2, 2.0, 2.0],
})  # fmt: skip
NAMES = ["cubic_stiffness", "hidden_resonator", "relaxation"]


def test_what_is_taken_away_is_gone_and_all_else_is_there():
    config, index = ablate.without_hidden_states(CONFIG, INDEX, NAMES)
    assert config == CONFIG | {"discrepancy": {"suspects": ["cubic_stiffness"]}}
    assert index.equals(INDEX)
    config, index = ablate.without_dry_trials(CONFIG, INDEX, NAMES)
    assert "dry" not in config["trials"]
    assert index["water_depth_m"].tolist() == [2.0, 2.0]
    assert "dry" in CONFIG["trials"]  # the campaign itself is as it was
    config, index = ablate.without_other_springs(CONFIG, INDEX, NAMES)
    assert set(index["spring"]) == {"soft"}


def test_nothing_is_taken_where_there_is_nothing_of_it():
    bare = {"name": "c0001", "trials": {"group_by": []}}
    assert ablate.without_dry_trials(bare, INDEX, NAMES) is None
    assert ablate.without_other_springs(CONFIG, INDEX[INDEX["spring"] == "soft"], NAMES) is None
    assert ablate.without_other_springs(CONFIG, INDEX.drop(columns="spring"), NAMES) is None


def test_laboratories_with_something_taken_away_run_as_they_are(tmp_path: Path):
    case = tmp_path / "laboratory" / "c0001"
    (case / "recordings").mkdir(parents=True)
    for i in range(5):
        (case / "recordings" / f"r{i}.csv").write_text("t,x\n0,1\n")
    (tmp_path / "laboratory" / "challenge.json").write_text("{}")
    with (case / "config.yaml").open("w") as stream:
        YAML(typ="safe").dump(CONFIG, stream)
    INDEX.to_csv(case / "campaign.csv", index=False)
    made = ablate.prepare(tmp_path / "laboratory", tmp_path / "ablations", ["c0001"], NAMES)
    assert list(made) == list(ablate.ABLATIONS)
    for folder in made.values():
        index = pd.read_csv(folder / "c0001" / "campaign.csv")
        assert all((folder / "c0001" / name).is_file() for name in index["file"])
        assert (folder / "challenge.json").is_file()


def case(outcome: str, kind: str = "one", name: str = "c0001") -> CaseResult:
    effects: tuple[dict[str, Any], ...] = () if kind == "nothing" else ({"key": "relaxation"},)
    group = GroupResult(outcome, 3.0, 3.0, {"status": "explained"}, {}, effects)
    truth = {"kind": kind, "reason": "", "measures": {"effects": list(effects)}}
    return CaseResult({"case": name}, truth, (group,))


@pytest.mark.parametrize(
    ("was", "now", "key", "counts"),
    [
        ("named", "missed", "named", (1, 0)), ("unknown", "silent", "detected", (1, 0)),
        ("right", "false", "false", (0, 1)), ("right", "silent", "green", (1, 0)),
    ],
)  # fmt: skip
def test_what_was_said_stands_beside_what_is_said_without_it(was, now, key, counts):
    kind = "nothing" if was == "right" else "one"
    found = ablate.beside([case(was, kind)], [case(now, kind)])
    assert (found["with"][key], found["without"][key]) == counts
    assert found["total"]["cases"] == 1
    assert "| hidden states | " in ablate.page({"hidden states": found}, {"seed": 1, "cases": 1, "revisions": ["abc"]})


def test_groups_that_one_run_lacks_and_cases_that_cannot_tell_are_not_counted():
    assert ablate.beside([case("named")], [case("absent")])["total"] == {}
    assert ablate.beside([case("named")], [case("named", name="c0002")])["total"] == {}
    assert ablate.beside([case("silent", "cannot")], [case("silent", "cannot")])["total"] == {}
    two = replace(case("named"), groups=(*case("named").groups, *case("missed").groups))
    half = replace(two, groups=(two.groups[0], case("absent").groups[0]))
    found = ablate.beside([two], [half])
    assert (found["with"]["named"], found["without"]["named"]) == (1, 1)
    strong = replace(two, groups=(two.groups[0], replace(two.groups[1], strength=9.0)))
    found = ablate.beside([half], [strong])  # what the first run lacks does not decide the second
    assert (found["with"]["named"], found["without"]["named"]) == (1, 1)


def test_suspects_are_those_that_verdicts_name_or_tried():
    groups = [{"rejected": [{"name": "relaxation"}], "verdict": ["cubic_stiffness", "unknown"]}]
    assert ablate.suspects_of([{"verdict": {"groups": groups}}, {"verdict": None}]) == ["cubic_stiffness", "relaxation"]
