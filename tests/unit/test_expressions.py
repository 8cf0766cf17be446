"""Expressions of a config held against file names: what they find, and that none takes for ever."""

from __future__ import annotations

import time

import pytest

from undertow.errors import ConfigError
from undertow.recording import expressions
from undertow.recording.expressions import LONGEST, found_in


def test_named_groups_are_found_in_names_of_any_bytes() -> None:
    found = found_in(r"(?P<spring>\w+)_(?P<note>x)?(?P<depth>\d+)", ("kurz_229.csv", "nothing", "t\udcff_1.csv", "ü_2"))
    assert found.groups == ("spring", "note", "depth")
    assert found.by_name[0] == {"spring": "kurz", "note": None, "depth": "229"}
    assert found.by_name[1] is None
    assert found.by_name[3] == {"spring": "ü", "note": None, "depth": "2"}


@pytest.mark.parametrize(
    "pattern",
    [r"(?P<x>(a+)+)$", r"(?P<x>a*)a*a*a*a*a*a*a*a*a*b", r"(?P<x>(aa|aa|b)*)d", r"(?P<x>(.*a){25})$"],
)
def test_a_pattern_that_would_search_for_years_ends_in_a_sentence(
    pattern: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(expressions, "SECONDS", 1)
    begun = time.perf_counter()
    with pytest.raises(
        ConfigError, match=r"recordings\.pattern .* takes more than 1 s for 1 file names; a repeat with"
    ):
        found_in(pattern, ("a" * 120 + "!.csv",))
    assert time.perf_counter() - begun < 20.0


@pytest.mark.parametrize(
    ("pattern", "said"),
    [
        ("(", r"'\(' is no regular expression: missing \)"),
        ("(?P<a>x)" + "(" * 900, r"is no regular expression"),
        ("(?P<a>x){99999999999}", r"is no regular expression: the repetition number is too large"),
        ("(?P<a>x)" * LONGEST, rf"has 8000 characters, and {LONGEST} are allowed"),
    ],
)
def test_a_pattern_that_is_none_is_refused_with_its_reason(pattern: str, said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        found_in(pattern, ("a.csv",))


def test_a_process_that_answers_nothing_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(expressions, "_CHILD", "raise SystemExit(3)")
    with pytest.raises(ConfigError, match=r"cannot be tried in a process of its own \(exit code 3\); give the cond"):
        found_in("(?P<asked_once>x)", ("a.csv",))
    monkeypatch.setattr(expressions, "_CHILD", "import time; time.sleep(60)")
    monkeypatch.setattr(expressions, "LONGEST_WAIT_S", 1.0)
    with pytest.raises(ConfigError, match=r"takes more than 5 s for 1 file names"):
        found_in("(?P<asked_again>x)", ("a.csv",))


def test_where_no_process_can_be_started_that_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.executable", "/nowhere/python")
    with pytest.raises(
        ConfigError, match=r"cannot be tried in a process of its own .*give the conditions in recording"
    ):
        found_in("(?P<never_asked_before>x)", ("a.csv",))
