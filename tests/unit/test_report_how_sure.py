"""The page's first screen says how sure a verdict is, what was assumed, and why it is red inside the grey band."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.findings_fixture import small_findings
from tests.unit.test_report_first_screen import rendered, repaired
from undertow.discrepancy.verdict import Gate
from undertow.likelihood.fit import Structure
from undertow.quantities import Estimate
from undertow.report.behind import held_words
from undertow.report.blocks import NO_BREAK, record_words, sure_words
from undertow.report.first_screen import first_screen, grid


@pytest.mark.parametrize(
    ("status", "value", "words"),
    [
        ("explained", "72 %", "probability of this answer"),
        ("not_identifiable", "72 %", "probability that it is one of these"),
        ("cannot_tell", "none", "these data do not tell"),
    ],
)
def test_the_numbers_say_how_sure_every_kind_of_verdict_is(status, value, words):
    group = repaired(small_findings().groups[1])
    group = replace(group, verdict=replace(group.verdict, status=status))
    last = first_screen(replace(small_findings(), groups=(group,)), ["a"])["shown"]["numbers"][-1]
    assert last["value"] == value
    assert words in last["words"]


def test_a_repeatability_that_was_assumed_says_so_beside_its_number():
    group = repaired(small_findings().groups[1])
    unknown = replace(group.verdict, decision=(Gate("scatter_known", "reasons", 1.0, 0.0, False, "nobody repeated"),))
    for verdict, said in ((group.verdict, False), (unknown, True)):
        findings = replace(small_findings(), groups=(replace(group, verdict=verdict),))
        first = first_screen(findings, ["a"])
        assert ("assumed" in first["shown"]["numbers"][2]["words"]) is said
        assert (f"{NO_BREAK}%, assumed" in first["sentences"][0]["text"]) is said


def test_a_red_verdict_beside_an_error_inside_the_band_says_why():
    group = repaired(small_findings().groups[1])
    red = replace(group, verdict=replace(group.verdict, status="not_identifiable"))
    inside = [replace(t, mismatch=replace(t.mismatch, repeatability_nrmse=9.0)) for t in group.trials]
    for one, trials, said in ((red, inside, True), (red, group.trials, False), (group, inside, False)):
        findings = replace(small_findings(), groups=(replace(one, trials=tuple(trials)),))
        assert bool(first_screen(findings, ["a"])["shown"]["colour"]) is said


def test_one_group_has_its_sentence_beside_the_picture():
    one = replace(small_findings(), groups=small_findings().groups[:1])
    assert first_screen(one, ["a"])["place"] == "beside"


@pytest.mark.parametrize(
    ("error", "structure", "said"),
    [
        (48.0, False, "the load cells"),
        (48.0, True, "load cells; those of"),
        (0.0, True, "those of the structure, from the dry trials or the config"),
    ],
)
def test_what_was_held_says_where_it_comes_from(error, structure, said):
    known = Structure(Estimate(4801.0), Estimate(17.0), Estimate(0.0)) if structure else None
    one = small_findings().groups[1]
    body = replace(one.specimen, stiffness_N_per_m=4801.0, stiffness_error_N_per_m=error)
    words = held_words(replace(one, specimen=body, structure=known))
    assert said in words
    assert ("dry trials" in words) is structure


def test_the_page_says_which_trials_the_numbers_of_table_and_equation_include():
    text = rendered()
    assert "where something is named those of the repaired equation, fitted to the training trials" in text
    assert "fitted to all trials of a group together, held-out ones too (dry: means over its trials)" in text
    assert "its numbers from the training trials alone: the table of all groups has the held-out ones too" in text


def test_a_cell_and_a_section_say_how_sure_where_such_verdicts_were_counted():
    group = small_findings().groups[-1]
    verdict = replace(
        group.verdict, status="not_identifiable", verdict=("linear_damping",), confidence=0.82,
        alternatives=(("relaxation",), ("relaxation", "delayed_echo")),
    )  # fmt: skip
    assert sure_words(verdict) == "82 %"
    assert record_words(verdict).endswith("held, which makes 82 %")
    one = replace(small_findings(), groups=(replace(group, verdict=verdict),))
    (cell,) = grid(one, ["a"])["rows"][0]["cells"]
    assert (cell["names"], cell["sure"]) == ("linear damping or relaxation", "82 % sure")
    assert sure_words(replace(verdict, status="cannot_tell")) == ""  # which claims nothing
    assert sure_words(replace(verdict, confidence=float("nan"))) == ""
