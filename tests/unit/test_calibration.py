"""The probability of a verdict is how often verdicts of its kind were right."""

from __future__ import annotations

import json
import math

import pytest

from experiments.blind_challenge.judge import GroupResult, holds
from experiments.calibration.__main__ import TARGET, counted
from undertow.discrepancy.calibration import LEFT, Record, kind_of, record_of
from undertow.discrepancy.verdict import Gate, Verdict


@pytest.mark.parametrize(
    ("status", "names", "left", "kind"),
    [
        ("cannot_tell", (), math.nan, ""),
        ("nothing_missing", (), math.nan, "nothing_missing"),
        ("explained", ("relaxation",), 2.4, "explained, to the noise"),
        ("explained", ("relaxation",), 2.6, "explained, more than noise is left"),
        ("present_but_small", ("unknown",), math.nan, "present_but_small, not named"),
        ("present_but_small", ("relaxation",), math.nan, "present_but_small, named"),
        ("unknown", ("relaxation", "unknown"), 9.0, "unknown"),
    ],
)
def test_a_verdict_has_a_kind(status, names, left, kind):
    assert kind_of(status, names, left) == kind


def test_a_record_is_no_certainty():
    assert Record("x", 9, 9).probability == pytest.approx(0.95)
    assert Record("x", 0, 0).probability != Record("x", 0, 0).probability
    assert record_of(Verdict({}, (), status="cannot_tell")) is None


@pytest.mark.parametrize(
    ("left", "kind"), [(1.1, "explained, to the noise"), (30.0, "explained, more than noise is left")]
)
def test_a_verdicts_record_is_found_by_the_condition_that_was_counted(left, kind):
    gate = Gate(LEFT, "mean squared residual over noise", left, 2.5, left <= 2.5)
    said = record_of(Verdict({}, (), status="explained", verdict=("relaxation",), decision=(gate,)))
    assert said is not None
    assert said.kind == kind


def test_the_counts_of_the_package_are_of_a_stated_run():
    kept = json.loads(TARGET.read_text(encoding="utf-8"))
    assert kept["campaigns"] > 100
    assert 1 <= len(kept["revisions"]) <= len(kept["seeds"])
    for row in kept["records"]:
        assert 0 <= row["right"] <= row["said"]
        one = Record(**row)
        assert 0.0 < one.probability < 1.0
    green = record_of(Verdict({}, (), status="nothing_missing"))
    assert green is not None
    assert green.said > 50


@pytest.mark.parametrize(
    ("outcome", "size", "held"),
    [
        ("silent", 3.0, None),
        ("absent", 3.0, None),
        ("right", 0.0, True),
        ("false", 0.0, False),
        ("missed", 0.9, True),
        ("missed", 1.1, False),
        ("named", 3.0, True),
        ("partly", 3.0, True),
        ("described", 3.0, True),
        ("wrong", 3.0, False),
    ],
)
def test_a_verdict_holds_where_what_it_says_is_so(outcome, size, held):
    assert holds(GroupResult(outcome, 9.0, size, {}, {}, ())) is held


def test_campaigns_are_counted_by_what_was_said_and_what_is_so(tmp_path):
    groups = [{"group": {"spring": "a"}}, {"group": {"spring": "b"}}]
    effect = {
        "names": ["relaxation"], "near": [], "groups": [
            {"present": True, "strength": 9.0, "size": 2.0}, {"present": False, "strength": 0.0, "size": 0.0},
        ],
    }  # fmt: skip
    (tmp_path / "sealed").mkdir()
    for case, kind in (("c0", "one"), ("c1", "cannot")):
        truth = {"kind": kind, "reason": "", "groups": groups, "measures": {"effects": [effect]}}
        (tmp_path / "sealed" / f"{case}.json").write_text(json.dumps(truth), encoding="utf-8")
    gate = [{"gate": LEFT, "value": 1.2}]
    said = [
        {"group": {"spring": "a"}, "status": "explained", "verdict": ["relaxation"], "decision": gate},
        {"group": {"spring": "b"}, "status": "nothing_missing", "verdict": [], "decision": []},
    ]
    rows = [{"case": c, "seed": 1, "revision": "r", "verdict": {"groups": said}} for c in ("c0", "c1")]
    (tmp_path / "rows.jsonl").write_text("\n".join(json.dumps(row) for row in rows), encoding="utf-8")
    found = counted([tmp_path])
    assert found["records"] == [
        {"kind": "explained, to the noise", "said": 1, "right": 1}, {"kind": "nothing_missing", "said": 1, "right": 1},
    ]  # fmt: skip
    assert (found["seeds"], found["revisions"], found["campaigns"]) == ([1], ["r"], 2)
    both = counted([tmp_path, tmp_path])
    assert (both["seeds"], both["campaigns"], both["records"][0]["said"]) == ([1], 4, 2)
