"""The table of bad inputs, through the commands in this process: the sentence and the exit code of each."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from experiments.bad_inputs.__main__ import CASES, Answer
from experiments.bad_inputs.case import Case, run_words
from tests.command_line import undertow


@pytest.mark.parametrize(
    "case", [pytest.param(case, marks=pytest.mark.slow if case.slow else ()) for case in CASES], ids=lambda c: c.name
)
def test_a_bad_input_is_answered_in_a_sentence(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, case: Case
) -> None:
    monkeypatch.setattr("undertow.campaign.run.cluster.PATIENCE_S", 0.5)
    monkeypatch.chdir(tmp_path)
    said = undertow(capsys, *case.words(tmp_path / "c"))
    assert said.code == case.code, said.err
    assert re.search(case.says, said.err), said.err
    assert len(said.err) < 4000


def test_there_are_at_least_eighty_of_them_and_each_has_its_own_name() -> None:
    assert len({case.name for case in CASES}) == len(CASES) >= 80


def test_the_campaign_that_they_spoil_is_sound(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    said = undertow(capsys, *Case("nothing", lambda folder: None, "").words(tmp_path / "c"))
    assert said.code == 0, said.err
    assert run_words(tmp_path)[0] == "run"


@pytest.mark.parametrize(
    ("answer", "wrong"),
    [
        (Answer(1, "undertow: it says this", 1.0, 300.0), ""),
        (Answer(1, "Traceback (most recent call last):\nit says this", 1.0, 300.0), "a traceback"),
        (Answer(-9, "it says this", 1.0, 300.0), "exit code -9, not 1"),
        (Answer(1, "it says that", 1.0, 300.0), "another sentence"),
        (Answer(1, "it says this", 61.0, 300.0), "too long"),
        (Answer(1, "it says this", 1.0, 2001.0), "too large"),
    ],
)
def test_what_the_command_marks_as_wrong(answer: Answer, wrong: str) -> None:
    assert answer.wrong(Case("a", lambda folder: None, "says this")) == wrong
