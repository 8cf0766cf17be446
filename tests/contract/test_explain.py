"""`undertow explain` prints every gate behind a verdict: statistic, value, limit, passed."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import pytest

from tests.command_line import undertow
from tests.findings_fixture import small_findings
from tests.written import write_verdict
from undertow.comparison.detectable import Detectable
from undertow.discrepancy import decision
from undertow.discrepancy.verdict import Gate, Rejected
from undertow.report.behind import gate_rows
from undertow.report.gates import CONDITIONS, OF_A_CANDIDATE, OF_THE_EQUATION

DECISION = (
    Gate("free_run", "free-run error over repeatability", 1.8, 1.0, False),
    Gate("comes_closer", "error of unseen trials after over before", 1.42, 1.2, False, "it went up", "unseen"),
    Gate("search_ended", "suspects not tried to the end", 0.0, 0.0, True, "not tried: none", "search"),
    Gate("posterior", "posterior probability", float("nan"), 0.99, False),
)


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """A folder with the verdicts of two groups, of which the second one has gates."""
    findings = small_findings()
    first, second = findings.groups
    inside = {"natural_frequency_rad_per_s": 5.234, "damping_ratio": 0.02}
    wide = Detectable("cubic_stiffness", "N_per_m3", 1734.0, "N/m^3", 0.0045, math.nan)
    seen = Detectable("hidden_resonator", "mass_kg", 4.13, "kg", 0.011, 7.9, inside)
    said = replace(
        second.verdict, decision=DECISION, rejected=(Rejected("relaxation", "on its bound"),), detectable=(seen, wide),
        not_testable=("rest_offset",),
    )  # fmt: skip
    write_verdict(replace(findings, groups=(first, replace(second, verdict=said))), tmp_path / "verdict.json")
    return tmp_path


def test_a_small_number_of_a_gate_is_a_power_of_ten_on_terminal_and_page(tmp_path, capsys):
    findings = small_findings()
    first, second = findings.groups
    tiny = (Gate("p_value", "p of the score test", 1e-6, 0.00143, True), Gate("evidence", "log odds", 2.5e7, 4.6, True))
    verdict = replace(second.verdict, decision=tiny)
    write_verdict(replace(findings, groups=(first, replace(second, verdict=verdict))), tmp_path / "verdict.json")
    said = undertow(capsys, "explain", tmp_path).out
    assert "  1 × 10⁻⁶  " in said
    assert "  2.5 × 10⁷  " in said
    assert [row["value"] for row in gate_rows(verdict)] == ["1 × 10⁻⁶", "2.5 × 10⁷"]


def test_every_gate_is_a_line_with_value_limit_and_whether_it_is_passed(run, capsys):
    said = undertow(capsys, "explain", run)
    assert said.code == 0
    lines = [" ".join(line.split()) for line in said.out.splitlines()]
    assert "gate statistic value asked for outcome" in lines
    assert "free_run free-run error over repeatability 1.8 at most 1 misses more than repetitions" in lines
    barred = "NOT met: bars an answer"
    assert f"comes_closer error of unseen trials after over before 1.42 at most 1.2 {barred}" in lines
    assert "search_ended suspects not tried to the end 0 at most 0 met" in lines
    assert "posterior posterior probability - at least 0.99 shared with other candidates: so it is not named" in lines
    assert "comes_closer: it went up" in lines
    assert "search_ended: not tried: none" not in lines  # a reason is that of a gate that is not passed
    assert "relaxation: on its bound" in lines
    at = "natural frequency 5.2 rad/s, damping ratio 0.020"
    assert f"hidden_resonator, {at}: from mass 4.1 kg, 1.1 % of the motion" in lines
    assert "cubic_stiffness: from 1700 N/m^3, 0.45 % of the motion" in lines
    assert "not testable here: rest_offset" in lines


def test_every_condition_of_a_decay_has_words_for_what_follows():
    """Another name would be read as a law that was tried on a driven body."""
    written = {
        name for file in (Path(decision.__file__).parents[1]).rglob("*.py")
        for name in re.findall(r'Gate\(\s*"(\w+)"', file.read_text(encoding="utf-8"))
    }  # fmt: skip
    assert len(written) > 15
    assert written <= CONDITIONS | set(OF_A_CANDIDATE) | set(OF_THE_EQUATION)
    assert len(CONDITIONS) <= 15


def test_under_a_green_verdict_a_candidate_that_is_not_named_is_no_failure(run, capsys):
    findings = small_findings()
    first, second = findings.groups
    weak = Gate("evidence", "log odds of relaxation over nothing", 2.8, 4.6, False)
    green = replace(first.verdict, status="nothing_missing", verdict=(), decision=(weak,))
    write_verdict(replace(findings, groups=(replace(first, verdict=green), second)), run / "verdict.json")
    said = " ".join(undertow(capsys, "explain", run, "--group", "1.63").out.split())
    assert "relaxation over nothing 2.8 at least 4.6 not reached: so it is not named" in said
    assert "NOT" not in said
    green = replace(green, status="not_identifiable", verdict=("relaxation",), alternatives=(("hysteresis",),))
    write_verdict(replace(findings, groups=(replace(first, verdict=green), second)), run / "verdict.json")
    assert "not_identifiable: relaxation or hysteresis" in undertow(capsys, "explain", run, "--group", "1.63").out


def test_one_group_is_taken_by_words_of_its_title_and_others_are_refused(run, capsys):
    dry = undertow(capsys, "explain", run, "--group", "1.63")
    assert "water depth 1.63 m" in dry.out
    assert "comes_closer" not in dry.out
    nowhere = undertow(capsys, "explain", run, "--group", "9.99")
    assert nowhere.code == 2
    assert "has no group '9.99'; it has spring short, water depth 1.63 m; spring short" in nowhere.err


@pytest.mark.parametrize("typed", ["water_depth_m=1.63", "water_depth_m=1.63,spring=short", "1.630 Short"])
def test_a_group_is_taken_by_its_conditions_in_any_order_too(run, capsys, typed):
    said = undertow(capsys, "explain", run, "--group", typed)
    assert said.code == 0
    assert said.out.startswith("spring short, water depth 1.63 m")
    assert "water depth 2.36 m" not in said.out


@pytest.mark.parametrize("text", [None, "{", "[]", '{"groups": [{}]}', '{"groups": [{"group": {}, "status": "x"}]}'])
def test_a_folder_without_decisions_is_said(tmp_path, capsys, text):
    if text is not None:
        (tmp_path / "verdict.json").write_text(text)
    said = undertow(capsys, "explain", tmp_path)
    assert said.code == (2 if text is None else 1)  # as of `compare`: a wrong folder is usage, a spoiled file a failure
    assert "holds no finished run with its decisions" in said.err
    assert "Expecting" not in said.err
    assert ("it breaks off or is changed in line 1" in said.err) == (text == "{")
