"""The scorer on verdicts made by hand: outcomes, shares, limits, calibration, and keys that an older contract lacks."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import norm

from experiments.blind_challenge import __main__ as entry
from experiments.blind_challenge import estimates, figures, gates, judge, page, score


def effect(
    names: list[str], near: list[str] | None = None, strength: float = 5.0, present: bool = True, **more: object
) -> dict:
    """An effect of a truth with one group."""
    group = {"strength": strength, "size": 2.0, "present": present, "parameters": more.pop("parameters", {})}
    return {
        "key": (names or ["ghost"])[0],
        "names": names,
        "near": near or [],
        "strength": strength,
        "best_power": 0.9,
        "size": 2.0,
        "groups": [group],
        **more,
    }


def truth(kind: str, effects: list[dict], reason: str = "", **measures: object) -> dict:
    """A truth of one group."""
    strata = dict.fromkeys(
        (
            "dry",
            "noise",
            "trials",
            "springs",
            "levels",
            "channels",
            "scatter",
            "frequency",
            "coordinate",
            "lost samples",
            "correlated noise",
        ),
        "any",
    )
    return {
        "case": "c0",
        "seed": 1,
        "kind": kind,
        "reason": reason,
        "strata": strata,
        "groups": [{"group": {"h": 1.0}}],
        "knows": ["mass"],
        "measures": {"effects": effects, **measures},
    }


def said(status: str, verdict: list[str] | None = None, **more: object) -> dict:
    """A group of a verdict."""
    return {"group": {"h": 1, "spring": "a"}, "status": status, "verdict": verdict or [], **more}


def case(truth_: dict, group: dict | None, **row: object) -> judge.CaseResult:
    """A judged case."""
    verdict = None if group is None else {"contract": 2, "groups": [group]}
    return judge.judge_case(
        {"case": "c0", "seed": 1, "exit": 0, "stopped": False, "seconds": 5.0, "verdict": verdict, **row}, truth_
    )


SLOSH = effect(["hidden_resonator"], ["relaxation"])
CUBIC = effect(["cubic_stiffness"])


@pytest.mark.parametrize(
    ("effects", "group", "outcome"),
    [
        ([], said("nothing_missing"), "right"),
        ([], said("cannot_tell"), "silent"),
        ([], said("explained", ["relaxation"]), "false"),
        ([], said("present_but_small"), "false"),
        ([], None, "absent"),
        ([SLOSH], said("explained", ["hidden_resonator"]), "named"),
        ([SLOSH], said("present_but_small", ["hidden_resonator"]), "named"),
        ([SLOSH], said("present_but_small"), "small unnamed"),
        ([SLOSH], said("not_identifiable", ["hidden_resonator"], alternatives=[["relaxation"]]), "first among rivals"),
        ([SLOSH], said("not_identifiable", ["cubic_damping"], alternatives=[["hidden_resonator"]]), "among rivals"),
        ([SLOSH], said("explained", ["relaxation"]), "described"),
        ([SLOSH], said("explained", ["cubic_damping"]), "wrong"),
        ([SLOSH], said("explained", ["hidden_resonator", "clipping"]), "wrong"),
        ([SLOSH], said("unknown", ["unknown"]), "unknown"),
        ([SLOSH], said("nothing_missing"), "missed"),
        ([SLOSH], said("cannot_tell"), "silent"),
        ([SLOSH, CUBIC], said("explained", ["cubic_stiffness", "hidden_resonator"]), "named"),
        ([SLOSH, CUBIC], said("explained", ["cubic_stiffness"]), "partly"),
        ([SLOSH, CUBIC], said("unknown", ["hidden_resonator", "unknown"]), "partly"),
        ([SLOSH, effect(["cubic_stiffness"], strength=0.4)], said("explained", ["hidden_resonator"]), "named"),
        ([effect([], ["hysteresis"])], said("explained", ["hysteresis"]), "described"),
    ],
)
def test_a_verdict_has_the_outcome_that_a_reader_would_give_it(effects: list, group: dict | None, outcome: str) -> None:
    assert case(truth("one", effects), group).groups[0].outcome == outcome


def test_groups_are_matched_by_the_conditions_of_the_truth() -> None:
    assert judge.same_group({"h": 1.0}, {"h": "1.0000000001", "spring": "a"})
    assert not judge.same_group({"h": 1.0}, {"h": 1.1})
    assert not judge.same_group({"spring": "a"}, {"h": 1.0})


def test_a_false_positive_is_counted_with_the_limit_of_clopper_and_pearson() -> None:
    nothing = {**truth("nothing", [], sharpness=2.0), "knows": ["scatter"]}
    cases = [case(nothing, said("nothing_missing", p_value=(i + 0.5) / 200)) for i in range(199)]
    cases.append(case(nothing, said("explained", ["clipping"], p_value=0.001)))
    found = score.nulls(cases)
    assert (found["n"], found["false"], found["accused"]) == (200, 1, 1)
    small = score.nulls([case(nothing, said("present_but_small"))])
    assert (small["false"], small["accused"], small["accused_upper"]) == (1, 0, pytest.approx(0.95))
    assert found["upper"] == pytest.approx(0.0235, abs=5e-4)  # exact limit of 1 of 200
    assert found["nothing_said_sharp"]["share"] == 199 / 200
    assert found["p"]["ks_p"] > 0.9
    assert found["p"]["missing"] == 0
    assert estimates.upper_limit(2, 700) < 0.01
    assert estimates.upper_limit(3, 700) > 0.01
    assert estimates.upper_limit(0, 0) == 1.0


def test_missing_p_values_are_said_and_not_invented() -> None:
    found = score.nulls([case(truth("nothing", []), said("nothing_missing"))])
    assert found["p"] == {"n": 0.0, "missing": 1}
    assert "`p_value` is missing in 1 campaigns" in "\n".join(
        page._missing({"nothing": found, "sure": {"without_number": 0}, "coverage": {"without_number": 0}})
    )


def test_half_power_is_recovered_from_drawn_detections() -> None:
    rng = np.random.default_rng(0)
    strength = np.exp(rng.uniform(math.log(0.3), math.log(10.0), 1500))
    hit = rng.random(1500) < norm.cdf(2.0 * np.log(strength / 1.7))
    found = estimates.half_power(strength.tolist(), hit.tolist())
    assert found is not None
    assert found["half"] == pytest.approx(1.7, rel=0.12)
    assert found["slope"] == pytest.approx(2.0, rel=0.2)
    assert found["lapse"] < 0.05
    assert estimates.half_power([1.0] * 20, [True] * 20) is None


def test_misses_of_strong_effects_do_not_move_the_half() -> None:
    rng = np.random.default_rng(1)
    strength = np.exp(rng.uniform(math.log(0.3), math.log(300.0), 1500))
    chance = 0.8 * norm.cdf(2.0 * np.log(strength / 2.0))
    found = estimates.half_power(strength.tolist(), (rng.random(1500) < chance).tolist())
    assert found is not None
    assert found["lapse"] == pytest.approx(0.2, abs=0.04)
    assert found["half"] == pytest.approx(2.0 * math.exp(norm.ppf(0.5 / 0.8) / 2.0), rel=0.12)


def test_a_calibrated_confidence_has_slope_one_and_an_overstated_one_less() -> None:
    rng = np.random.default_rng(1)
    c = rng.uniform(0.5, 0.99, 4000)
    honest = estimates.calibration(c.tolist(), (rng.random(4000) < c).tolist())
    boast = estimates.calibration(c.tolist(), (rng.random(4000) < 0.5 + 0.5 * (c - 0.5)).tolist())
    assert honest is not None
    assert boast is not None
    assert honest["slope"] == pytest.approx(1.0, abs=0.15)
    assert honest["intercept"] == pytest.approx(0.0, abs=0.15)
    assert honest["log_score"] == pytest.approx(honest["calibrated_log_score"], abs=0.03)
    assert boast["slope"] < 0.8
    curve = estimates.reliability(c.tolist(), (rng.random(4000) < c).tolist())
    assert sum(b["low"] <= b["right"] <= b["high"] for b in curve) >= len(curve) - 2


def test_intervals_cover_where_the_truth_lies_within_their_ninety_percent() -> None:
    known = effect(["hidden_resonator"], parameters={"mass_kg": 10.0, "damping_ratio": 0.02})
    numbers = {"hidden_resonator": [{"mass_kg": {"value": 11.0, "stderr": 1.0}, "damping_ratio": {"value": 0.02}}]}
    far = {"hidden_resonator": {"mass_kg": {"value": 12.0, "stderr": 1.0}}}
    cases = [case(truth("one", [known]), said("explained", ["hidden_resonator"], parameters=p)) for p in (numbers, far)]
    found = score.coverage(cases)
    assert (found["all"]["hits"], found["all"]["n"], found["without_number"]) == (1, 2, 2)
    weighed = {"hidden_resonator": {"mass_kg": {"value": 2.6, "stderr": 0.1, "unit": "kg per kg"}}}
    group = {"group": {"h": 1.0}, "body": {"mass": 4.0}}
    per_mass = {**truth("one", [known]), "groups": [group]}
    found = score.coverage([case(per_mass, said("explained", ["hidden_resonator"], parameters=weighed))])
    assert (found["all"]["hits"], found["all"]["n"]) == (1, 1)
    blind = {**truth("one", [known]), "knows": []}
    found = score.coverage([case(blind, said("explained", ["hidden_resonator"], parameters=numbers))])
    assert (found["all"]["n"], found["without_number"]) == (0, 1)  # a mass per mass is no mass


def decided(status: str, names: list[str], *failed: str, found: str = "", extra: tuple[str, ...] = ()) -> dict:
    """A verdict with its gates: those ``failed`` not passed; ``found`` had been named."""
    have = ("channels_agree", "search_ended", "p_value", "structure_known", *extra)
    rows = [{"gate": g, "value": float(g in failed), "passed": g not in failed} for g in (*have, *failed)]
    if found:
        rows.append({"gate": "evidence", "statistic": f"log odds of {found} over nothing", "passed": True})
        rows.append({"gate": "outweighed", "passed": "outweighed" not in failed})
    return said(status, names, decision=rows)


@pytest.mark.parametrize(
    ("kind", "effects", "verdict", "worth"),
    [
        ("one", ["relaxation"], decided("unknown", ["unknown"], "p_value", found="relaxation"), ("p_value", 1, 0)),
        ("one", ["relaxation"], decided("unknown", ["unknown"], "p_value", found="hysteresis"), ("p_value", 0, 1)),
        ("nothing", [], decided("cannot_tell", [], "upper_bound", extra=("nothing_left",)), ("upper_bound", 1, 0)),
        ("one", ["relaxation"], decided("present_but_small", ["unknown"], "nothing_left"), ("nothing_left", 0, 1)),
        ("nothing", [], decided("cannot_tell", [], "upper_bound", "search_ended", extra=("nothing_left",)), None),
        ("nothing", [], decided("nothing_missing", [], extra=("nothing_left",)), None),
    ],
)
def test_a_gate_is_worth_the_groups_that_it_alone_turns(kind, effects, verdict, worth):
    found = gates.worth([case(truth(kind, [effect([name]) for name in effects]), verdict)])
    if worth is None:
        assert found == {}
    else:
        name, right, wrong = worth
        assert found == {name: {"turned": 1, "right without": right, "wrong without": wrong}}


def test_the_frequency_of_kinds_weighs_the_calibration() -> None:
    right = [case(truth("nothing", []), said("nothing_missing", confidence=0.9)) for _ in range(20)]
    wrong = [case(truth("one", [SLOSH]), said("explained", ["clipping"], confidence=0.9)) for _ in range(20)]
    drawn = score.sureness(right + wrong)["fit"]["log_score"]
    common = score.sureness(right + wrong, {"nothing": 0.99, "one": 0.01})["fit"]["log_score"]
    assert common > drawn + 0.5


def test_a_confident_wrong_name_is_one_that_is_neither_right_nor_near() -> None:
    assert judge.confident_wrong(case(truth("one", [SLOSH]), said("explained", ["clipping"])))
    assert judge.confident_wrong(case(truth("nothing", []), said("explained", ["clipping"])))
    assert not judge.confident_wrong(case(truth("one", [SLOSH]), said("explained", ["relaxation"])))
    assert not judge.confident_wrong(case(truth("one", [SLOSH]), said("not_identifiable", ["clipping"])))
    assert not judge.confident_wrong(case(truth("cannot", [], "wrong unit"), said("explained", ["gain_error"])))


@pytest.mark.parametrize(
    ("reason", "effects", "group", "right"),
    [
        ("one trial", [], said("cannot_tell"), True),
        ("one trial", [], said("nothing_missing"), True),
        ("one trial", [], said("explained", ["clipping"]), False),
        ("one trial", [SLOSH], said("not_identifiable", ["relaxation"], alternatives=[["hidden_resonator"]]), True),
        ("one trial", [SLOSH], said("nothing_missing"), False),
        ("one trial", [SLOSH], said("explained", ["clipping"]), False),
        ("wrong unit", [], said("cannot_tell"), True),
        ("wrong unit", [], said("explained", ["gain_error"]), True),
        ("wrong unit", [], said("nothing_missing"), False),
        ("wrong sign", [], said("explained", ["cubic_damping"]), False),
    ],
)
def test_where_the_data_cannot_tell_the_right_answers_are_counted(
    reason: str, effects: list, group: dict, right: bool
) -> None:
    assert judge.cannot_right(case(truth("cannot", effects, reason), group)) is right


def test_a_refusal_with_a_message_answers_contradicting_channels() -> None:
    assert judge.cannot_right(case(truth("cannot", [], "wrong sign"), None, exit=2, messages="channels contradict"))
    assert not judge.cannot_right(case(truth("cannot", [], "one trial"), None, exit=2, messages="refused"))


def test_a_description_outside_the_catalogue_counts_where_it_says_so_and_predicts() -> None:
    iwan = effect([], ["hysteresis"])
    good = said(
        "explained",
        ["hysteresis"],
        sentence="A description: ...",
        augmented={"held_out_nrmse": 0.03},
        repeatability_nrmse=0.03,
    )
    assert score._outside_right(case(truth("outside", [iwan]), good))
    assert not score._outside_right(case(truth("outside", [iwan]), {**good, "sentence": "It is hysteresis."}))
    assert not score._outside_right(case(truth("outside", [iwan]), {**good, "augmented": {"held_out_nrmse": 0.05}}))
    left_out = {**good, "augmented": {"held_out_nrmse": None, "cross_validated_nrmse": 0.03}}
    assert score._outside_right(case(truth("outside", [iwan]), left_out))
    assert not score._outside_right(case(truth("outside", [iwan]), {**left_out, "augmented": {"nrmse": 0.01}}))
    far = {**good["augmented"], "held_out_nrmse": 0.05, "cross_validated_nrmse": 0.01}
    assert not score._outside_right(case(truth("outside", [iwan]), {**good, "augmented": far}))
    assert score._outside_right(case(truth("outside", [iwan]), said("unknown", ["unknown"])))
    assert score._outside_right(case(truth("outside", [iwan]), said("unknown", ["cubic_damping", "unknown"])))


def test_the_error_after_repair_is_compared_with_peers_by_group() -> None:
    group = said(
        "explained",
        ["hidden_resonator"],
        baseline={"held_out_nrmse": 0.3},
        augmented={"held_out_nrmse": 0.05},
        repeatability_nrmse=0.04,
    )
    peers = [{"case": "c0", "group": {"h": 1}, "held_out": [], "pysindy_xv": 0.2, "sysidentpy": "not installed"}]
    found = score.repair([case(truth("one", [SLOSH]), group)], peers)
    assert found["within"]["hits"] == 1
    assert found["worse_than_prescribed"]["hits"] == 0
    assert (found["peers"]["pysindy_xv"]["hits"], found["peers"]["sysidentpy"]["n"]) == (1, 0)


def test_rows_of_another_seed_or_without_a_truth_are_refused(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match="case c0: no truth in"):
        score.load([{"case": "c0", "seed": 1}], tmp_path)
    (tmp_path / "c0.json").write_text(json.dumps(truth("nothing", [])))
    with pytest.raises(ValueError, match="case c0: the row has seed 2"):
        score.load([{"case": "c0", "seed": 2}], tmp_path)


def test_the_page_is_made_from_rows_of_both_contracts_and_from_rows_without_verdicts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(page, "READINGS", tmp_path)
    (tmp_path / "1.md").write_text("## What this run was\n", encoding="utf-8")
    cases = [
        case(truth("nothing", []), said("nothing_missing", confidence=0.9)),
        case(truth("one", [SLOSH]), said("explained", ["hidden_resonator"], confidence=0.99, p_value=0.001)),
        case(truth("one", [CUBIC]), None, exit=None, stopped=True, seconds=300.1),
        case(truth("cannot", [], "wrong unit"), None, exit=2, messages="no"),
    ]
    t = score.tables(cases, [])
    text = page.page(t, {"seed": 1, "cases": 4, "rows": 4, "revisions": ["abc"]}, "x.svg")
    assert "neither of the two named seeds" in text
    assert text.endswith("## What this run was\n")
    other = page.page(t, {"seed": 2, "cases": 4, "rows": 4, "revisions": ["abc"]}, "x.svg")
    assert "What this run was" not in other
    assert "1 of 4 over 60 s of processor time (c0; stopped at 300 s: c0)" in text
    assert "Too few verdicts with a confidence" in text
    assert figures.figure(t).axes[0].get_xlabel().startswith("strength")


def test_scoring_without_rows_is_refused_with_the_next_step(tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match="has no row, at least one is needed; run `run --out"):
        entry.main(["score", "--out", str(tmp_path)])


def test_the_two_named_seeds_are_the_two_sets() -> None:
    seeds = {name: entry.seed_of(entry.arguments(["generate", "--set", name])) for name in ("calibration", "test")}
    assert len(set(seeds.values())) == 2
    assert entry.seed_of(entry.arguments(["generate", "--seed", "5"])) == 5


def test_scatter_is_known_where_it_is_stated_or_every_spring_has_three_dry_trials() -> None:
    def campaign(knows: list[str], *dry: int) -> judge.CaseResult:
        groups = [
            {"group": {"spring": str(i)}, "wet": wet, "trials": ["t.csv"] * n}
            for i, n in enumerate(dry) for wet in (False, True)
        ]  # fmt: skip
        return judge.CaseResult({}, {**truth("nothing", [], sharpness=2.0), "knows": knows, "groups": groups}, ())

    assert score.scatter_known(campaign(["scatter"], 0))
    assert score.scatter_known(campaign([], 3, 4))
    assert not score.scatter_known(campaign(["mass"], 3, 2))
