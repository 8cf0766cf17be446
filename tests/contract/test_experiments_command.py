"""Every study starts in one way, and pages name no study that is not there."""

from __future__ import annotations

import re
import sys
from pathlib import Path

from experiments import __main__ as command
from experiments.files import add_missing, put, read_rows, table, write_rows

ROOT = Path(__file__).resolve().parents[2]
NAMED = re.compile(r"python -m experiments ([a-z][a-z_0-9.]*[a-z0-9])")


def test_every_study_that_a_page_names_is_there():
    pages = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "data").rglob("README.md")]
    named = {name for page in pages for name in NAMED.findall(page.read_text(encoding="utf-8"))}
    assert len(named) > 30
    assert named - command.studies().keys() == set()


def test_no_page_starts_a_study_in_another_way():
    pages = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "experiments").rglob("*.py")]
    assert [p.name for p in pages if "python -m experiments." in p.read_text(encoding="utf-8")] == []


def test_a_name_that_no_study_has_is_answered_with_the_list(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["experiments", "astrology"])
    assert command.main() == 2
    assert re.search(r"^structure\.routes +Two routes to one equation", capsys.readouterr().err, re.MULTILINE)


def test_a_study_that_was_cut_goes_on_where_it_stopped(tmp_path):
    asked = []

    def rows(number):
        asked.append(number)
        return [(str(number), "half"), (str(number), "whole")]

    path = tmp_path / "rows.csv"
    for cases in (range(2), range(3)):
        add_missing(path, ("number", "part"), cases, lambda number: (str(number),), rows)
    assert asked == [0, 1, 2]
    assert [row["number"] for row in read_rows(path)] == ["0", "0", "1", "1", "2", "2"]


def test_rows_come_back_as_they_were_written(tmp_path):
    path = tmp_path / "rows.csv"
    assert read_rows(path) == []
    write_rows(path, ("a", "b"), [(1, "x, y"), {"a": 2, "b": ""}])
    assert read_rows(path) == [{"a": "1", "b": "x, y"}, {"a": "2", "b": ""}]


def test_a_page_keeps_what_stands_around_the_marks(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("before\n<!-- t -->\nold\n<!-- end -->\nafter\n", encoding="utf-8")
    put(page, table(("a", "b"), [(1, 2)]), "<!-- t -->", "<!-- end -->")
    assert page.read_text(encoding="utf-8") == (
        "before\n<!-- t -->\n| a | b |\n|---|---|\n| 1 | 2 |\n<!-- end -->\nafter\n"
    )
