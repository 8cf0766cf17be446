"""What the terminal shows: progress, the table of verdicts, JSON, quiet and verbose, completion, the page, changes."""

from __future__ import annotations

import io
import json
import os
import re
import subprocess
import sys
import webbrowser
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

from tests.command_line import undertow
from tests.findings_fixture import small_findings
from tests.written import write_verdict
from undertow.campaign.run import folder as run_folder
from undertow.campaign.run.folder import Finished
from undertow.campaign.run.workers import on_processes
from undertow.discrepancy.findings import Findings
from undertow.discrepancy.verdict import Described
from undertow.front.terminal.completion import group_titles, run_folders, term_names
from undertow.front.terminal.progress import Lines, bars_shown, lines_shown
from undertow.front.terminal.verdicts import no_gain_lines, probability_words, run_text
from undertow.quantities import Estimate
from undertow.report.extent import extent_of
from undertow.uncertainty.growth import LEVELS, Grown

Capture = pytest.CaptureFixture[str]


@pytest.fixture
def finished(tmp_path: Path) -> Finished:
    """A finished run of two groups, with doubts and a failed trial, and its verdict.json."""
    findings = replace(small_findings(), doubts=tuple(f"doubt number {i}" for i in range(12)))
    write_verdict(findings, tmp_path / "verdict.json")
    return Finished(tmp_path, findings, extent_of(findings))


def run(capsys: Capture, monkeypatch: pytest.MonkeyPatch, finished: Finished, *words: str) -> Any:
    """`undertow run` where the work is done already."""

    def done(*said: object, progress: Any, **settings: object) -> Finished:
        progress("read", 0, 1, "r1")
        progress("read", 1, 1)
        return finished

    monkeypatch.setattr("undertow.campaign.config.load", lambda *said: None)
    monkeypatch.setattr(run_folder, "run_to_folder", done)
    return undertow(capsys, "run", "any.yaml", *words)


# ---------------------------------------------------------------- progress
def test_a_line_is_said_every_few_seconds_though_one_item_takes_long() -> None:
    said: list[str] = []
    now = [0.0]
    lines = Lines(said.append, every_s=5.0, clock=lambda: now[0])
    lines("identification", 0, 2, "dry")
    for _ in range(20):
        now[0] += 1.0
        lines.beat()
    assert said == [
        "identification: 0 of 2, at dry", *(f"identification: 0 of 2, at dry, {s} s so far" for s in (5, 10, 15, 20)),
    ]  # fmt: skip


def test_time_left_is_what_the_other_items_need_at_the_pace_of_those_done() -> None:
    said: list[str] = []
    now = [0.0]
    lines = Lines(said.append, clock=lambda: now[0], each=True)
    lines("read", 0, 4, "a")
    now[0] = 30.0
    lines("read", 1, 4, "b")
    now[0] = 50.0
    lines.beat()
    now[0] = 140.0
    lines.beat()
    assert said[1:] == [
        "read: 1 of 4, at b, 30 s so far, about 1 min 30 s left",
        "read: 1 of 4, at b, 50 s so far, about 1 min 10 s left",
        "read: 1 of 4, at b, 2 min 20 s so far",  # the item takes longer than the one before said of all
    ]  # fmt: skip


def test_lines_end_with_the_block_and_an_empty_stage_is_no_line() -> None:
    said: list[str] = []
    with lines_shown(said.append, every_s=0.02) as lines:
        lines("dry", 0, 0)
        lines("read", 0, 1, "r1")
    before = len(said)
    assert said[0] == "read: 0 of 1, at r1"
    assert not any(line.startswith("dry") for line in said)
    assert len(said) == before


def test_a_terminal_sees_stage_trial_and_how_many_are_done() -> None:
    stream = io.StringIO()
    with bars_shown(Console(file=stream, force_terminal=True, width=120)) as update:
        update("read and condition", 0, 3, "[red]r1")
        update("read and condition", 2, 3, "r3")
    shown = stream.getvalue()
    assert "read and condition" in shown
    assert "2/3" in shown
    assert "r3" in shown
    assert "left" in shown


def test_work_on_processes_says_which_item_is_worked_on() -> None:
    said: list[tuple[object, ...]] = []
    on_processes(abs, [-1, 2], 1, "sizes", lambda *words: said.append(words), name=lambda item: f"item {item}")
    assert said == [("sizes", 0, 2, "item -1"), ("sizes", 1, 2, "item 2"), ("sizes", 2, 2)]


# ---------------------------------------------------------------- the end of a run
def test_a_run_ends_with_a_table_counts_and_the_page(capsys, monkeypatch, finished) -> None:
    said = run(capsys, monkeypatch, finished)
    lines = said.out.splitlines()
    assert lines[-1] == f"report: {finished.folder / 'report.html'}"
    for group in finished.findings.groups:
        assert any(group.label in line and "%" in line for line in lines)
        assert group.verdict.sentence not in said.out
    assert any(re.match(r"2 groups: .*1 nothing missing", line) for line in lines)
    assert said.out.count("doubt: ") == 10
    assert "2 more doubts" in said.out
    assert "read: 1 of 1" in said.err


def test_quiet_prints_the_last_line_alone_and_no_progress(capsys, monkeypatch, finished) -> None:
    said = run(capsys, monkeypatch, finished, "-q")
    assert said.out == f"report: {finished.folder / 'report.html'}\n"
    assert "read" not in said.err
    both = run(capsys, monkeypatch, finished, "-q", "-v")
    assert both.code == 2
    assert "--quiet and --verbose contradict each other; give one of them" in " ".join(both.err.split())


def test_verbose_adds_every_sentence_and_every_doubt(capsys, monkeypatch, finished) -> None:
    said = run(capsys, monkeypatch, finished, "-v")
    assert all(group.verdict.sentence in said.out for group in finished.findings.groups)
    assert said.out.count("doubt: ") == 12
    assert "read: 0 of 1, at r1" in said.err


def test_json_is_all_of_stdout_and_holds_verdicts_failures_and_doubts(capsys, monkeypatch, finished) -> None:
    said = run(capsys, monkeypatch, finished, "--json")
    data = json.loads(said.out)
    assert data["contract"] == 2
    assert [one["status"] for one in data["groups"]] == [g.verdict.status for g in finished.findings.groups]
    assert [one["trial"] for one in data["failed"]] == [one.name for one in finished.failed]
    assert len(data["doubts"]) == 12
    assert data["report"] == str(finished.folder / "report.html")
    assert said.code == 3, "a trial failed"


def test_colours_and_width_are_the_terminals_and_a_name_is_never_markup(finished) -> None:
    group = finished.findings.groups[0]
    named = replace(group, verdict=replace(group.verdict, group={"spring": "[red]soft[/red]"}))
    findings: Findings = replace(finished.findings, groups=(named, *finished.findings.groups[1:]))
    plain = run_text(replace(finished, findings=findings))
    assert "[red]soft[/red]" in plain
    assert "\x1b[" not in plain
    assert "\x1b[32m" in run_text(finished, 100, colour=True), "nothing_missing is green"
    assert all(len(line) <= 100 for line in run_text(finished, 100).splitlines() if "%" in line)


def test_why_a_repaired_error_is_the_larger_one_stands_below_the_table(finished) -> None:
    group = next(g for g in finished.findings.groups if g.verdict.verdict)
    worse = replace(group.verdict, baseline=Described(0.05, 0.05), augmented=Described(0.062, 0.062))
    findings = replace(finished.findings, groups=(replace(group, verdict=worse),))
    (said,) = no_gain_lines(findings)
    assert said.startswith(f"{group.label}: In this group the free-run error does not fall (5.0 % as ")
    assert said in run_text(replace(finished, findings=findings)).splitlines()


def test_why_a_group_cannot_be_told_stands_below_the_table(finished) -> None:
    group = finished.findings.groups[0]
    unsure = replace(group.verdict, status="cannot_tell", sentence="soft: cannot tell, because x.")
    groups = (replace(group, verdict=unsure),) * 4
    lines = run_text(replace(finished, findings=replace(finished.findings, groups=groups))).splitlines()
    assert lines.count(unsure.sentence) == 3
    assert "1 more group that cannot be told: -v prints each reason" in lines


def test_why_standard_errors_are_larger_is_one_sentence_a_group_with_verbose(finished) -> None:
    group = finished.findings.groups[0]
    found = (Grown("added_mass_kg", 9.0, 3, 0.03, 2.04), Grown("k_N_per_m", 9.0, 1, 0.01, 1.52, LEVELS))
    findings = replace(finished.findings, groups=(replace(group, grown=found), *finished.findings.groups[1:]))
    one = replace(finished, findings=findings)
    lines = [line for line in run_text(one, verbose=True).splitlines() if "standard errors are larger" in line]
    assert lines[0].startswith(f"{group.label}: ")
    assert "added mass (2) between trials fitted alone; stiffness (1.5) between groups on the same spring" in lines[0]
    assert len(lines) == 1
    assert "standard errors are larger" not in run_text(one)


def test_a_probability_is_never_said_where_nothing_is_claimed() -> None:
    assert probability_words({"status": "not_identifiable", "confidence": 0.86}) == "86 %"  # that it is one of them
    assert probability_words({"status": "cannot_tell", "confidence": 0.99}) == "-"
    assert probability_words({"status": "nothing_missing", "confidence": 0.9}) == "90 %"


# ---------------------------------------------------------------- open
def test_open_shows_the_page_in_the_browser(capsys, monkeypatch, tmp_path) -> None:
    opened: list[str] = []
    monkeypatch.setattr(webbrowser, "open", lambda address: opened.append(address) or True)
    (tmp_path / "report.html").write_text("<p>")
    said = undertow(capsys, "open", tmp_path)
    assert (said.code, said.out) == (0, f"{tmp_path / 'report.html'}\n")
    assert opened == [(tmp_path / "report.html").resolve().as_uri()]
    assert undertow(capsys, "open", tmp_path / "report.html").code == 0


def test_open_says_where_there_is_no_page_or_no_browser(capsys, monkeypatch, tmp_path) -> None:
    said = undertow(capsys, "open", tmp_path)
    assert said.code == 2  # as of `compare` and `predict`
    assert "has no page: neither report.html nor audit.html nor differ.html; give the folder that" in said.err
    (tmp_path / "audit.html").write_text("<p>")
    monkeypatch.setattr(webbrowser, "open", lambda address: False)
    said = undertow(capsys, "open", tmp_path)
    assert said.code == 1
    assert re.search(r"no browser can be started here; open \S+audit\.html yourself", said.err)
    assert said.out == f"{tmp_path / 'audit.html'}\n"


# ---------------------------------------------------------------- completion
def test_a_shell_completes_commands() -> None:
    words = {"_UNDERTOW_COMPLETE": "complete_bash", "COMP_WORDS": "undertow ex", "COMP_CWORD": "1"}
    done = subprocess.run(
        [sys.executable, "-m", "undertow"], capture_output=True, text=True, env={**os.environ, **words}
    )
    assert done.stdout.split() == ["explain"]


def test_completion_offers_runs_groups_and_terms(monkeypatch, finished, tmp_path) -> None:
    (tmp_path / "runs" / "flume").mkdir(parents=True)
    (tmp_path / "runs" / "flume" / "verdict.json").write_text((tmp_path / "verdict.json").read_text())
    monkeypatch.chdir(tmp_path)
    assert run_folders("") == ["runs/flume"]
    assert run_folders("runs/f") == ["runs/flume/"]
    assert run_folders("nowhere/") == []
    assert all("1.63" in title for title in group_titles("runs/flume", "1.63"))
    assert group_titles("nowhere", "") == []
    assert "hidden_resonator" in term_names("hid") + term_names("hidden")


# ---------------------------------------------------------------- compare
@pytest.fixture
def two_runs(finished: Finished, tmp_path: Path) -> list[Path]:
    """Two runs: in the second one group has another verdict, and its first parameter moved by five standard errors."""
    group = finished.findings.groups[1]
    name, first = next(iter(group.verdict.baseline.parameters.items()))
    error = 0.01 * abs(first.value)
    moved = {}
    for run_name, shift in (("a", 0.0), ("b", 5.0)):
        numbers = dict(group.verdict.baseline.parameters)
        numbers[name] = Estimate(first.value + shift * error, error, unit="kg")
        status = "cannot_tell" if shift else "unknown"
        verdict = replace(group.verdict, baseline=replace(group.verdict.baseline, parameters=numbers), status=status)
        moved[run_name] = replace(
            finished.findings, groups=(finished.findings.groups[0], replace(group, verdict=verdict))
        )
        (tmp_path / run_name).mkdir()
        write_verdict(moved[run_name], tmp_path / run_name / "verdict.json")
    return [tmp_path / "a", tmp_path / "b"]


def test_compare_shows_what_changed_and_by_how_many_standard_errors(capsys, two_runs, finished) -> None:
    said = undertow(capsys, "compare", *two_runs)
    assert said.code == 0
    assert finished.findings.groups[1].label in said.out
    assert finished.findings.groups[0].label not in said.out, "nothing changed there"
    assert "+3.5 standard errors" in said.out
    assert "cannot tell" in said.out
    assert said.out.splitlines()[-1] == (
        "2 groups: another verdict in 1, parameters changed by 2 standard errors or more in 1"
    )
    whole = undertow(capsys, "compare", *two_runs, "--all")
    assert finished.findings.groups[0].label in whole.out
    rows = json.loads(undertow(capsys, "compare", *two_runs, "--json").out)
    assert sum(row["changed"] for row in rows) == 2


def test_compare_says_where_nothing_changed_and_refuses_another_contract(capsys, two_runs) -> None:
    same = undertow(capsys, "compare", two_runs[0], two_runs[0])
    assert same.out == "2 groups: another verdict in 0, parameters changed by 2 standard errors or more in 0\n"
    old = json.loads((two_runs[1] / "verdict.json").read_text()) | {"contract": 1}
    (two_runs[1] / "verdict.json").write_text(json.dumps(old))
    refused = undertow(capsys, "compare", *two_runs)
    assert refused.code == 1
    assert "follows contract 1, this undertow reads 2; run the campaign again with it" in refused.err


def test_the_page_of_a_comparison_marks_what_changed(capsys, two_runs, tmp_path) -> None:
    undertow(capsys, "compare", *two_runs, "--out", tmp_path / "both.html")
    page = (tmp_path / "both.html").read_text()
    assert page.count('<tr class="changed">') == 2
    assert '<tr class="same">' in page
    assert "<script>" not in page
