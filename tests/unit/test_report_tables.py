"""The run folder's tables and verdict.json: what stands in them is what was found."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.findings_fixture import MARKUP, bare_findings, named, small_findings
from tests.written import (
    csv_text,
    levels_table,
    mismatch_table,
    trials_table,
    verdict_json,
    write_tables,
    write_verdict,
)
from undertow.discrepancy.findings import FailedTrial, TrialFindings
from undertow.errors import UndertowError
from undertow.likelihood.fit import Fit
from undertow.quantities import Estimate
from undertow.report.tables import NOTES_AT_MOST, RunTables, as_written, outcome_of
from undertow.report.verdict_file import plain
from undertow.report.writing import write_bytes, write_pieces, write_text

SCORES = ["nrmse", "sensor_floor_nrmse", "repeatability_nrmse", "outcome"]
SHARES = [
    "share_early", "share_middle", "share_late", "line_frequency_hz", "line_share", "amplitude_exponent",
    "static_share", "memory_share", "clock_share",
]  # fmt: skip
CSV_DIGITS = 1e-8
"""Relative: nine digits are written."""


def read(table: pd.DataFrame) -> pd.DataFrame:
    """The table as a reader of its CSV gets it."""
    return pd.read_csv(io.StringIO(csv_text(table)))


def same(written: float, found: float) -> bool:
    return bool(np.isclose(written, found, rtol=CSV_DIGITS, equal_nan=True))


# ---------------------------------------------------------------- tables
def test_every_estimate_of_every_trial_and_method_stands_in_trials_csv() -> None:
    findings = small_findings()
    table = read(trials_table(findings)).set_index(["trial", "method"])
    checked = 0
    for trial in (t for g in findings.groups for t in g.trials):
        for method, fit in trial.fits.items():
            row = table.loc[trial.motion.name, method]
            for name, estimate in fit.parameters.items():
                assert same(row[name], estimate.value)
                assert same(row[f"{name}_stderr"], estimate.total_stderr)
                checked += 1
            assert same(row.nrmse, trial.nrmse[method])
            assert same(row.sensor_floor_nrmse, trial.mismatch.sensor_floor_nrmse)
            assert same(row.repeatability_nrmse, trial.mismatch.repeatability_nrmse)
            assert row.outcome == outcome_of(fit)
    assert checked > 50


def test_trials_csv_has_the_contracts_columns_and_one_row_for_a_trial_that_failed() -> None:
    table = trials_table(small_findings())
    assert list(table.columns[:6]) == ["file", "trial", "spring", "water_depth_m", "operator", "method"]
    assert list(table.columns[-4:]) == SCORES
    failed = table[table.outcome.str.startswith("failed")]
    assert failed.outcome.tolist() == [
        "failed: no release found: displacement never leaves 0.4 mm; set trials.window"
    ]
    assert failed.file.tolist() == ["r9<b>"]
    assert failed.method.isna().all()


def test_a_failed_trial_keeps_the_conditions_it_was_found_under() -> None:
    failed = FailedTrial("r5", "constant channel", {"spring": "short", "water_depth_m": 2.22, "unheard_of": 1.0})
    last = trials_table(replace(small_findings(), failed=(failed,))).iloc[-1]
    assert (last.spring, last.water_depth_m) == ("short", 2.22)
    assert "unheard_of" not in last


def test_levels_csv_holds_each_groups_baseline_first_and_every_method_after_it() -> None:
    findings = small_findings()
    table = read(levels_table(findings))
    assert {"spring", "water_depth_m", "method", "equation", "equation_latex", *SCORES} <= set(table.columns)
    for group in findings.groups:
        rows = table[table.water_depth_m == group.key["water_depth_m"]].set_index("method")
        assert list(rows.index) == ["baseline", *group.fits]
        baseline = group.verdict.baseline
        assert same(rows.loc["baseline"].nrmse, baseline.nrmse)
        found = {"baseline": baseline.parameters} | {m: f.parameters for m, f in group.fits.items()}
        for method, numbers in found.items():
            for name, estimate in numbers.items():
                assert same(rows.loc[method][name], estimate.value)
                assert same(rows.loc[method][f"{name}_stderr"], estimate.total_stderr)


def test_a_methods_equation_bears_its_own_numbers() -> None:
    group = small_findings().groups[1]
    table = levels_table(small_findings())
    row = table[(table.method == "output_error") & (table.water_depth_m == 2.36)].iloc[0]
    drag = group.fits["output_error"].parameters["drag_coefficient"].value * 0.5 * 1000.0 * 0.97
    written = float(row.equation.split(" v |v|")[0].split("+ ")[-1])
    # digits as the error of 0.3 in C_d allows: 145 N s2/m2, written to the next ten
    assert written == pytest.approx(drag, abs=100.0)
    assert "\\dot{x}|\\dot{x}|" in row.equation_latex
    assert "m^{2}" in row.equation_latex


def test_mismatch_csv_is_the_mismatch_of_every_trial() -> None:
    findings = small_findings()
    table = read(mismatch_table(findings))
    trials = [t for g in findings.groups for t in g.trials]
    assert table.trial.tolist() == [t.motion.name for t in trials]
    assert table.missing.tolist() == [t.mismatch.missing for t in trials]
    assert table.held_out.tolist() == [t.held_out for t in trials]
    for column in (*SCORES[:3], *SHARES):
        assert all(same(a, getattr(t.mismatch, column)) for a, t in zip(table[column], trials, strict=True))


def test_truth_values_are_written_as_json_writes_them_and_what_was_not_computed_is_empty() -> None:
    first = csv_text(mismatch_table(small_findings())).splitlines()[1]
    assert ",false," in first
    assert ",,,,,,,,," in first


def test_a_condition_called_like_a_column_of_the_table_does_not_overwrite_it() -> None:
    findings = small_findings()
    key = {"method": "pull", "nrmse": 3.0}
    odd = replace(findings, groups=(replace(findings.groups[0], key=key),))
    table = levels_table(odd)
    assert table.condition_method.eq("pull").all()
    assert table.condition_nrmse.eq(3.0).all()
    assert table.method.iloc[0] == "baseline"
    assert len(set(trials_table(odd).columns)) == len(trials_table(odd).columns)


def test_several_trials_in_one_file_are_called_by_their_own_names() -> None:
    findings = small_findings()
    group = findings.groups[0]

    def moved(trial: TrialFindings) -> TrialFindings:
        recording = replace(trial.motion.recording, path="/data/all.mat")
        return replace(trial, motion=replace(trial.motion, recording=recording))

    together = replace(findings, groups=(replace(group, trials=tuple(moved(t) for t in group.trials)),))
    assert mismatch_table(together).file.tolist() == [t.motion.name for t in group.trials]
    assert mismatch_table(findings).file.iloc[0] == f"{group.trials[0].motion.name}.csv.gz"


def test_an_outcome_says_what_is_wrong_with_the_fit_and_with_its_numbers() -> None:
    fit = Fit("method1", ("r1",), {}, {"added_mass_kg": Estimate(0.0, outcome="on its bound")}, "stopped early")
    assert outcome_of(fit) == "stopped early; added_mass_kg: on its bound"
    assert outcome_of(replace(fit, outcome="ok", parameters={})) == "ok"


def test_tables_of_a_bare_recording_have_rows_and_no_conditions() -> None:
    findings = bare_findings()
    assert list(trials_table(findings).columns[:3]) == ["file", "trial", "method"]
    assert len(levels_table(findings)) == 2
    assert levels_table(findings).equation.iloc[0] == "1 x'' + 19.3 x + 0.03 v = 0"


# ---------------------------------------------------------------- verdict.json
def test_verdict_json_has_the_contracts_keys_and_no_others() -> None:
    said = verdict_json(small_findings())
    assert list(said) == ["contract", "groups", "across_groups"]
    assert list(said["across_groups"]) == ["verdict", "sentence"]
    described = {"nrmse", "held_out_nrmse", "parameters"}
    for entry in said["groups"]:
        assert set(entry) == {
            "group", "trials", "held_out", "status", "verdict", "alternatives", "confidence", "origin", "parameters",
            "baseline", "augmented", "sensor_floor_nrmse", "repeatability_nrmse", "rejected", "physical_check",
            "transfer", "next_test", "sentence", "because", "posterior", "decision",
            "p_value", "upper_bound", "detectable", "not_testable",
        }  # fmt: skip
        assert set(entry["baseline"]) == described  # and one more where trials were left out in turn
        assert set(entry["physical_check"]) == {"expected", "found", "agrees", "because"}


def test_verdict_json_says_what_the_verdict_says() -> None:
    findings = small_findings()
    group = named(findings.groups[1])
    entry = verdict_json(replace(findings, groups=(group,)))["groups"][0]
    assert entry["status"] == "explained"
    assert entry["verdict"] == ["hidden_resonator"]
    assert entry["alternatives"] == [["relaxation"]]
    assert entry["parameters"]["hidden_resonator"]["mass_kg"] == {"value": 300.0, "stderr": 6.0, "unit": "kg"}
    assert entry["augmented"]["held_out_nrmse"] == 0.04
    assert entry["physical_check"]["agrees"] is True
    assert entry["group"] == {"spring": "short", "water_depth_m": 2.36}
    assert entry["sentence"] == group.verdict.sentence


def test_across_groups_names_the_effect_of_most_groups_first() -> None:
    findings = small_findings()
    both = replace(findings, groups=(findings.groups[1], named(findings.groups[1]), named(findings.groups[1])))
    assert verdict_json(both)["across_groups"]["verdict"] == ["hidden_resonator", "unknown"]


def test_verdict_json_holds_no_nan_and_no_infinity(tmp_path: Path) -> None:
    def refuse(word: str) -> None:
        raise AssertionError(word)

    findings = small_findings()
    verdict = replace(findings.groups[0].verdict, confidence=math.inf, repeatability_nrmse=math.nan)
    odd = replace(findings, groups=(replace(findings.groups[0], verdict=verdict),))
    text = write_verdict(odd, tmp_path / "verdict.json").read_text()
    assert json.loads(text, parse_constant=refuse)["groups"][0]["confidence"] is None


def test_what_json_cannot_hold_is_refused_by_its_type() -> None:
    with pytest.raises(UndertowError, match=r"cannot hold \{1\} of type set; give numbers, texts, estimates"):
        plain({"sets": {1}})
    assert plain((np.float64(2.0), np.bool_(True), np.int64(3))) == [2.0, True, 3]


# ---------------------------------------------------------------- writing
def test_the_same_findings_give_the_same_bytes(tmp_path: Path) -> None:
    findings = small_findings()
    first, second = (write_tables(findings, tmp_path / name) for name in ("a", "b"))
    assert set(first) == {"trials.csv", "levels.csv", "mismatch.csv", "verdict.json"}
    assert all(first[name].read_bytes() == second[name].read_bytes() for name in first)
    assert not list(tmp_path.rglob("*.part"))


def test_an_older_file_stays_whole_when_writing_fails(tmp_path: Path) -> None:
    path = write_text(tmp_path / "a.txt", "old")
    with pytest.raises(TypeError, match="bytes-like"):
        write_bytes(path, "not bytes")  # type: ignore[arg-type]
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["a.txt"]


def test_a_written_file_is_readable_as_any_new_file(tmp_path: Path) -> None:
    plain_file = tmp_path / "plain"
    plain_file.write_text("")
    written = write_text(tmp_path / "ours", MARKUP)
    assert written.stat().st_mode == plain_file.stat().st_mode
    assert written.read_text() == MARKUP


def test_texts_of_trials_reach_the_tables_unchanged() -> None:
    assert any(MARKUP in name for name in read(trials_table(small_findings())).trial)


# ---------------------------------------------------------------- group by group
def test_groups_that_come_in_any_order_are_written_in_order(tmp_path: Path) -> None:
    findings = small_findings()
    write_tables(findings, tmp_path / "at_once")
    with RunTables(tmp_path / "one_by_one") as tables:
        for place in (1, 0):
            tables.add(findings.groups[place], (place,))
        assert list((tmp_path / "one_by_one").iterdir()) == [], "nothing appears before it is whole"
        tables.write(findings.failed, findings.across_groups)
    for path in (tmp_path / "at_once").iterdir():
        assert (tmp_path / "one_by_one" / path.name).read_bytes() == path.read_bytes(), path.name


def test_the_columns_of_a_late_group_are_columns_of_all(tmp_path: Path) -> None:
    dry, wet = small_findings().groups
    with RunTables(tmp_path) as tables:
        tables.add(replace(dry, key={"first": 1.0}), (0,))
        tables.add(replace(wet, key={"second": "x"}), (1,))
        tables.write((), "")
    levels = pd.read_csv(tmp_path / "levels.csv")
    assert list(levels.columns[:2]) == ["first", "second"]
    assert levels.second.isna().sum() == 1 + len(dry.fits)
    assert {"added_mass_kg", "added_mass_kg_stderr"} <= set(levels.columns), "which the dry group has not"


@pytest.mark.parametrize("number", [NOTES_AT_MOST, NOTES_AT_MOST + 1])
def test_notes_stand_in_a_file_of_their_own_where_the_manifest_cannot_hold_them(tmp_path: Path, number: int) -> None:
    with RunTables(tmp_path) as tables:
        tables.note([f"r{i}: two\nlines" for i in range(number)])
        tables.write((), "")
    assert (tmp_path / "notes.txt").exists() == (number > NOTES_AT_MOST)
    if number > NOTES_AT_MOST:
        assert (tmp_path / "notes.txt").read_text().splitlines()[-1] == f"r{number - 1}: two lines"


def test_a_piece_that_fails_leaves_the_older_file(tmp_path: Path) -> None:
    def pieces() -> Iterator[str]:
        yield "half"
        raise UndertowError("no more")

    write_text(tmp_path / "a.csv", "whole")
    with pytest.raises(UndertowError, match="no more"):
        write_pieces(tmp_path / "a.csv", pieces())
    assert [p.name for p in tmp_path.iterdir()] == ["a.csv"]
    assert (tmp_path / "a.csv").read_text() == "whole"


def test_the_verdict_written_in_pieces_is_the_verdict_as_json(tmp_path: Path) -> None:
    findings = small_findings()
    whole = json.dumps(verdict_json(findings), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    assert write_verdict(findings, tmp_path / "v.json").read_text(encoding="utf-8") == whole
    none = replace(findings, groups=())
    whole = json.dumps(verdict_json(none), indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    assert write_verdict(none, tmp_path / "v.json").read_text(encoding="utf-8") == whole


@pytest.mark.parametrize("text", ["=1+1", "+A1", "-A1", "@SUM(A1)", "\t=1", "'=1", "''=1"])
def test_a_text_that_begins_like_a_formula_is_a_text_in_a_spreadsheet_and_reads_back(text: str) -> None:
    cell = next(csv.reader(io.StringIO(csv_text(pd.DataFrame({"a": [text]})).split("\n", 1)[1])))[0]
    assert cell == f"'{text}"
    assert as_written(cell) == text
    head = csv_text(pd.DataFrame({text: [1.0]}))
    assert head.startswith(("'", "\"'"))


@pytest.mark.parametrize("text", ["long", "'s", "1-2", "a=b", ""])
def test_other_texts_and_numbers_stay_as_they_are(text: str) -> None:
    assert csv_text(pd.DataFrame({"a": [text], "b": [-1.5]})).split("\n")[1] == f"{text},-1.5"
    assert as_written(text) == text


def test_a_text_makes_no_row_of_its_own() -> None:
    text = csv_text(pd.DataFrame({"a": ["one\r=1\n=2"], "b": [1.0]}))
    assert [*csv.reader(io.StringIO(text, newline=""))] == [["a", "b"], ["one =1\n=2", "1"]]
