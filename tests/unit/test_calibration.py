"""The probability of a verdict is how often verdicts of its kind were right."""

from __future__ import annotations

import json
import math

import pytest

from experiments.blind_challenge import estimates
from experiments.blind_challenge.judge import GroupResult, holds
from experiments.calibration.__main__ import TARGET, counted, main, together
from experiments.calibration.page import Said, by_counts, left_out, measured, verdicts_of
from undertow.discrepancy.calibration import (
    HIDES,
    LEFT,
    STANDS_OUT,
    Record,
    conditions_of,
    kind_of,
    rather_right,
    record_of,
)
from undertow.discrepancy.verdict import Gate, Verdict


@pytest.mark.parametrize(
    ("status", "names", "decision", "kind"),
    [
        ("cannot_tell", (), {}, ""),
        ("nothing_missing", (), {}, "nothing_missing"),
        ("nothing_missing", (), {STANDS_OUT: (0.4, 0.01), HIDES: (0.005, 0.04)}, "nothing_missing"),
        ("nothing_missing", (), {STANDS_OUT: (0.04, 0.01)}, "nothing_missing, leans to standing out"),
        ("nothing_missing", (), {STANDS_OUT: (0.4, 0.01), HIDES: (0.003, 0.04)}, "nothing_missing, seen sharply"),
        ("nothing_missing", (), {STANDS_OUT: (0.2, 0.01), HIDES: (0.003, 0.04)},
         "nothing_missing, seen sharply, leans to standing out"),
        ("nothing_missing", (), {STANDS_OUT: (0.02, 0.01), HIDES: (0.003, 0.04)}, "nothing_missing, nearly stands out"),
        ("explained", ("relaxation",), {LEFT: (1.2, 2.5)}, "explained, to the noise"),
        ("explained", ("relaxation",), {LEFT: (2.4, 2.5)}, "explained, nearly to the noise"),
        ("explained", ("relaxation", "stribeck_friction"), {LEFT: (2.4, 2.5)}, "explained, several effects"),
        ("explained", ("hidden_resonator", "hidden_resonator"), {LEFT: (1.2, 2.5)}, "explained, several effects"),
        ("explained", ("relaxation",), {LEFT: (2.6, 2.5)}, "explained, more than noise is left"),
        ("present_but_small", ("unknown",), {STANDS_OUT: (2e-5, 0.01)}, "present_but_small, not named"),
        ("present_but_small", ("unknown",), {STANDS_OUT: (2e-6, 0.01)},
         "present_but_small, not named, beyond every replica"),
        ("present_but_small", ("relaxation",), {STANDS_OUT: (0.001, 0.01)}, "present_but_small, named"),
        ("unknown", ("unknown",), {}, "unknown, not named"),
        ("unknown", ("relaxation", "unknown"), {LEFT: (9.0, 2.5)}, "unknown, beside a name"),
        ("unknown", ("relaxation", "stop", "unknown"), {LEFT: (9.0, 2.5)}, "unknown, beside several names"),
    ],
)  # fmt: skip
def test_a_verdict_has_a_kind(status, names, decision, kind):
    assert kind_of(status, names, decision) == kind


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


@pytest.mark.parametrize(
    ("status", "names", "kept"),
    [
        ("unknown", ("relaxation", "stop", "unknown"), False), ("unknown", ("relaxation", "unknown"), True),
        ("unknown", ("unknown",), True), ("explained", ("relaxation", "stop"), True), ("cannot_tell", (), True),
    ],
)  # fmt: skip
def test_names_that_are_wrong_more_often_than_right_are_not_said(status, names, kept):
    verdict = Verdict({}, (), status=status, verdict=names, sentence="They come closest.", alternatives=(("stop",),))
    said = rather_right(verdict)
    assert (said == verdict) == kept
    if not kept:
        assert (said.verdict, said.alternatives) == (("unknown",), ())
        assert said.sentence.startswith("They come closest. Of such answers with several names 20 of 74 held")
        assert record_of(said).probability > 0.9


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
        "key": "relaxation", "names": ["relaxation"], "near": [], "groups": [
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


def _said(family: str, kind: str, right: bool, speaks: bool = True) -> Said:
    return Said(frozenset({family}), kind, right, right, speaks)


def test_one_group_of_each_campaign_speaks_for_it_whichever_has_the_strongest_effect(tmp_path):
    groups = [{"group": {"spring": name}} for name in "abc"]
    truth = {"kind": "nothing", "reason": "", "groups": groups, "measures": {"effects": []}}
    (tmp_path / "sealed").mkdir()
    rows = []
    for case in ("c0003", "c0004"):
        (tmp_path / "sealed" / f"{case}.json").write_text(json.dumps(truth), encoding="utf-8")
        said = [{**one, "status": status, "verdict": [], "decision": []}
                for one, status in zip(groups, ("nothing_missing", "cannot_tell", "unknown"), strict=True)]  # fmt: skip
        rows.append(json.dumps({"case": case, "seed": 1, "revision": "r", "verdict": {"groups": said}}))
    (tmp_path / "rows.jsonl").write_text("\n".join(rows), encoding="utf-8")
    spoken = [(v.kind, v.speaks) for v in verdicts_of(tmp_path)]
    green, other = "nothing_missing", "unknown, not named"
    assert spoken == [(green, False), (other, True), (green, True), (other, False)]


def test_a_family_is_given_the_counts_of_the_others():
    many = [
        *(_said("relaxation", "unknown", right=False) for _ in range(9)),
        *(_said("hysteresis", "unknown", right=True) for _ in range(4)),
        _said("hysteresis", "unknown", right=True, speaks=False),
    ]
    found = left_out(many)
    assert sorted(found) == [(0.5 / 10.0, True)] * 4 + [(5.5 / 6.0, False)] * 9  # of nine none held, of five all
    assert left_out(many[:1]) == []  # nothing else was seen


def test_truths_that_are_left_out_together_have_the_same_counts():
    """Six families in five parts: the first and the last share one, and each verdict is tested once."""
    families = "abcdef"
    many = [_said(family, "unknown", right=family != "f") for family in families for _ in range(3)]
    found = left_out(many)
    assert len(found) == 18
    assert found[:6] == [(12.5 / 13.0, True)] * 3 + [(12.5 / 13.0, False)] * 3  # "a" and "f" without each other
    assert found[6:] == [(12.5 / 16.0, True)] * 12  # of fifteen others "f" did not hold
    both = Said(frozenset("af"), "unknown", True, True, False)
    assert left_out([*many, both])[6:9] == [(13.5 / 17.0, True)] * 3  # "b" with the pair, which shares nothing with it
    two = Said(frozenset("bc"), "unknown", True, True, True)
    assert left_out([*many, two])[9] == (9.5 / 13.0, True)  # its part is that of "b", and "c" is out too


def test_probabilities_are_those_of_the_counts_and_unknown_kinds_have_none():
    records = {"unknown": Record("unknown", 9, 9)}
    verdicts = [_said("a", "unknown", right=True), _said("a", "explained, to the noise", right=True)]
    assert by_counts(verdicts, records) == [(0.95, True)]
    wrong = [Said(frozenset({"a"}), "unknown", True, False, True)]
    assert by_counts(wrong, records, exact=True) == [(0.95, False)]


def test_a_calibrated_forecaster_has_slope_one_and_a_sure_one_less():
    pairs = [(chance, i < round(100 * chance)) for chance in (0.6, 0.8, 0.95) for i in range(100)]
    fit = measured(pairs)["fit"]
    assert fit["slope"] == pytest.approx(1.0, abs=0.05)
    assert fit["intercept"] == pytest.approx(0.0, abs=0.05)
    sure = measured([(c**2 / (c**2 + (1.0 - c) ** 2), right) for c, right in pairs])["fit"]  # twice the log odds
    assert sure["slope"] == pytest.approx(0.5, abs=0.05)


def test_how_far_a_true_forecasters_slope_lies_by_chance_is_known():
    few, many = [0.9, 0.95, 0.99] * 20, [0.6, 0.9, 0.95] * 700
    (low, high), (under, over) = estimates.by_chance(few)
    assert low < 1.0 < high
    assert under < 0.0 < over
    (closer, close), _ = estimates.by_chance(many)
    assert 0.8 < closer < 1.0 < close < 1.25 < high
    assert estimates.by_chance([0.99] * 10) is None


def test_conditions_that_are_held_against_nothing_are_no_numbers():
    (pair,) = conditions_of([{"gate": LEFT, "value": 1.0, "limit": None}]).values()
    assert pair[0] == 1.0
    assert math.isnan(pair[1])


def test_the_page_is_made_of_the_counts_and_of_a_fresh_folder(tmp_path, capsys):
    effect = {"key": "relaxation", "names": ["relaxation"], "near": [], "groups": [
        {"present": True, "strength": 9.0, "size": 2.0},
    ]}  # fmt: skip
    said = [
        {"status": "explained", "verdict": ["relaxation"], "decision": [{"gate": LEFT, "value": 1.2, "limit": 2.5}]},
        {"status": "nothing_missing", "verdict": [], "decision": [{"gate": STANDS_OUT, "value": 0.4, "limit": 0.01}]},
    ]
    (tmp_path / "sealed").mkdir()
    (tmp_path / "pictures").mkdir()
    rows = []
    for i in range(24):
        truth = {
            "kind": "one", "reason": "", "seed": 7, "groups": [{"group": {"spring": "a"}}],
            "measures": {"effects": [effect]},
        }  # fmt: skip
        (tmp_path / "sealed" / f"c{i}.json").write_text(json.dumps(truth), encoding="utf-8")
        groups = [{"group": {"spring": "a"}, **said[i % 2]}]
        rows.append(json.dumps({"case": f"c{i}", "seed": 7, "revision": "r", "verdict": {"groups": groups}}))
    (tmp_path / "rows.jsonl").write_text("\n".join(rows), encoding="utf-8")
    path = tmp_path / "calibration.md"
    assert main([str(tmp_path), "--fresh", str(tmp_path), "--page", str(path)]) == 0
    text = path.read_text(encoding="utf-8")
    assert "24 cases of seed 7, revision r." in text
    assert "24 cases of seed 7, revision r; their families of truths" in text
    assert "A forecaster whose probabilities are true has, in 90 % of such samples, a slope of" in text
    assert main([str(tmp_path), "--fresh", str(tmp_path), str(tmp_path), "--page", str(path)]) == 0
    twice = path.read_text(encoding="utf-8")
    assert "48 cases of seed 7, revision r." in twice
    assert "| 24 of 24 |" in twice
    counts = {r["kind"]: Record(**r).probability for r in json.loads(TARGET.read_text(encoding="utf-8"))["records"]}
    assert f"| explained, to the noise | {counts['explained, to the noise']:.2f} | 12 of 12 |" in text
    assert f"| nothing_missing | {counts['nothing_missing']:.2f} | 0 of 12 |" in text
    assert (tmp_path / "pictures" / "calibration.svg").stat().st_size > 1000
    with pytest.raises(SystemExit, match="2"):
        main([str(tmp_path), "--page", str(path)])
    assert "--page needs --fresh" in capsys.readouterr().err


def test_counts_of_two_runs_are_added_and_no_seed_is_counted_twice():
    one = {"seeds": [1], "revisions": ["a"], "campaigns": 4, "records": [{"kind": "unknown", "said": 3, "right": 2}]}
    more = [{"kind": "explained", "said": 1, "right": 1}, {"kind": "unknown", "said": 5, "right": 4}]
    other = {"seeds": [2], "revisions": ["a"], "campaigns": 6, "records": more}
    both = together(one, other)
    assert (both["seeds"], both["revisions"], both["campaigns"]) == ([1, 2], ["a"], 10)
    assert both["records"] == [more[0], {"kind": "unknown", "said": 8, "right": 6}]
    with pytest.raises(ValueError, match=r"seeds \[1\] are counted already"):
        together(one, one)
