"""How an answer of the command is judged: by exit code, sentence and status, and green is found wherever it stands."""

from __future__ import annotations

import pytest

from experiments.misuse.answers import Groups, Outcome, Right, Stop, TrialsAlone, Way, falsely_green, shortfalls
from experiments.misuse.campaigns import Draft, bridge
from experiments.misuse.case import Case, leave
from experiments.misuse.mistakes import case
from experiments.misuse.running import run_case

WET = {"water_depth_m": 2.36}


def group(
    status: str, depth: float = 2.36, trials: tuple[str, ...] = ("t04", "t05"), **keys: object
) -> dict[str, object]:
    """A group as verdict.json has it."""
    verdict = {"group": {"water_depth_m": depth}, "trials": list(trials), "held_out": [], "status": status}
    return verdict | {"verdict": [], "sentence": "", "baseline": {"nrmse": 0.01, "parameters": {}}} | keys


def ended(code: int, *groups: dict[str, object], **keys: str) -> Outcome:
    return Outcome(code, verdict={"groups": list(groups)}, **keys)


STOP = (Stop(("dry", r"1\.65")),)
ALONE = (TrialsAlone(("clip",), trials=("t05",), others=1),)
WET_UNDECIDED = (Groups(("displacement",), frozenset({3}), where=WET, done=1),)


@pytest.mark.parametrize(
    ("outcome", "ways"),
    [
        (Outcome(2, err="undertow: dry names 1.65 m, no trial has it\n"), STOP),
        (ended(3, group("nothing_missing", trials=("t04",)), err="failed: t05: clipped\n"), ALONE),
        (ended(3, group("cannot_tell", because="displacement in mm"), group("nothing_missing", 1.63)), WET_UNDECIDED),
        (ended(0, group("nothing_missing")), (Right(groups=1),)),
    ],
)
def test_a_right_answer_lacks_nothing(outcome: Outcome, ways: tuple[Way, ...]) -> None:
    assert shortfalls(outcome, ways) == []
    assert not falsely_green(outcome, ways)


@pytest.mark.parametrize(
    ("outcome", "ways", "lacking"),
    [
        (Outcome(1, err="undertow: dry names 1.65 m\n"), STOP, "exit 1, not 2"),
        (Outcome(2, err="dry: 0 of 1\nundertow: 1.65\n"), STOP, r"no sentence says dry and 1\.65"),
        (Outcome(None, crash="traceback: KeyError: 'k'"), STOP, "traceback: KeyError: 'k'"),
        (Outcome(2, err="dry 1.65: {'k': 0.0}\n"), STOP, "a Python dictionary or exception in a message"),
        (Outcome(2, err="dry 1.65\n", warnings=("RuntimeWarning: x",)), STOP, "a Python warning: RuntimeWarning: x"),
        (ended(3, group("nothing_missing"), err="failed: t05: clipped\n"), ALONE, "t05 is in a group all the same"),
        (ended(3, err="failed: t05: clipped\n"), ALONE, "0 of 1 other trials are done"),
        (ended(3, group("cannot_tell", because="displacement")), WET_UNDECIDED, "other groups are not done"),
        (ended(3, group("cannot_tell")), WET_UNDECIDED, "water_depth_m 2.36: cannot_tell without a reason"),
        (ended(3, group("nothing_missing", 1.63)), WET_UNDECIDED, "no verdict on the group concerned"),
        (ended(0, group("cannot_tell", because="x"), page='class="tag good"'), (Groups(()),), "the page shows green"),
        (ended(0, group("unknown")), (Right(groups=1),), "water_depth_m 2.36: unknown (error 0.01)"),
        (ended(0, group("nothing_missing")), (Right(groups=1, held_out=("t04",)),), "held out: none, not t04"),
        (
            ended(0, group("nothing_missing", baseline={"parameters": {"m": {"value": 9.0, "stderr": 0.1}}})),
            (Right(groups=1, numbers=((WET, "m", 10.0),)),),
            "water_depth_m 2.36: m 9, not 10",
        ),
    ],
)
def test_what_a_wrong_answer_lacks_is_said(outcome: Outcome, ways: tuple[Way, ...], lacking: str) -> None:
    assert lacking in shortfalls(outcome, ways)


@pytest.mark.parametrize("ways", [STOP, (Groups(()),), (*STOP, Right())])
def test_green_where_the_mistake_concerns_every_group_is_false(ways: tuple[Way, ...]) -> None:
    assert falsely_green(ended(0, group("nothing_missing"), group("unknown", 1.63)), ways)


def test_green_of_a_group_that_the_mistake_does_not_concern_is_not_false() -> None:
    assert not falsely_green(ended(0, group("unknown"), group("nothing_missing", 1.63)), WET_UNDECIDED)


def test_an_exception_of_the_command_is_kept_and_not_raised(tmp_path, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    def fail(words: list[str]) -> None:
        raise ValueError("seven")

    monkeypatch.setattr("experiments.misuse.running.main", fail)
    assert run_case(case("mass_zero"), tmp_path).crash == "traceback: ValueError: seven"


def test_a_command_that_does_not_end_is_stopped(tmp_path, monkeypatch) -> None:  # type: ignore[no-untyped-def]
    def hang(words: list[str]) -> None:
        while True:
            pass

    monkeypatch.setattr("experiments.misuse.running.main", hang)
    outcome = run_case(case("mass_zero"), tmp_path, limit_s=0.2)
    assert (outcome.code, outcome.crash) == (None, "not ended after 0 s")


def test_a_base_campaign_is_untouched_by_what_a_case_does_to_it() -> None:
    def spoil(draft: Draft) -> None:
        draft.recordings["t01.csv"].loc[:, "x"] = 0.0
        draft.index["t01.csv"]["spring"] = "short"
        draft.set("specimen.scatter.k", 9.0)

    Case("spoilt", "", bridge, spoil, ()).draft()
    fresh = Case("fresh", "", bridge, leave, ()).draft()
    assert fresh.recordings["t01.csv"].x.abs().max() > 0.04
    assert fresh.index["t01.csv"]["spring"] == "long"
    assert fresh.config["specimen"]["scatter"]["k"] == 0.003
