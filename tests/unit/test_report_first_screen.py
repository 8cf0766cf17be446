"""The page's first screen: sentences by level, the trial that shows most, the grid; what stands behind a verdict."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from matplotlib.figure import Figure

from tests.findings_fixture import MARKUP, bare_findings, make_findings, named, small_findings
from undertow.comparison.detectable import Detectable
from undertow.discrepancy.findings import AugmentedRun, Findings, GroupFindings, TrialFindings
from undertow.discrepancy.verdict import Described, Gate, Verdict
from undertow.quantities import Estimate
from undertow.report.before_after import errors_of
from undertow.report.behind import adjusted_words, gate_rows, posterior_words, repaired_block, seen_rows
from undertow.report.blocks import NO_BREAK, no_gain_words
from undertow.report.first_screen import (
    SENTENCES_AT_MOST,
    _cell,
    first_screen,
    grid,
    is_no_gain,
    level_sentences,
    shown_trial,
)
from undertow.report.html import page, page_figures
from undertow.report.style import GREEN, PRESCRIBED, page_style
from undertow.report.trial_figures import FIRST_POINTS, SWINGS_SHOWN, draw_first, half_cycle_peaks

GATES = (
    Gate("evidence", "log odds of hidden_resonator over nothing", 812.0, 4.6, True),
    Gate("posterior", "posterior probability", 0.9998, 0.99, True),
    Gate("rivals", "other sets", 1.0, 0.0, False, "because <i>this</i>"),
)


def repaired(group: GroupFindings, left: float = 0.1) -> GroupFindings:
    """The group with a named resonator and free runs that miss ``left`` of what the equation's miss."""
    group = named(group)
    verdict = replace(
        group.verdict, confidence=0.72, posterior=0.99, decision=GATES, alternatives=(),
        baseline=replace(group.verdict.baseline, held_out_nrmse=0.5),
        augmented=replace(group.verdict.augmented or Described(), held_out_nrmse=0.06),
    )  # fmt: skip

    def run(trial: TrialFindings) -> TrialFindings:
        return replace(
            trial, augmented=AugmentedRun(left * trial.mismatch.nrmse, left * (trial.measured - trial.simulated))
        )

    return replace(group, verdict=verdict, trials=tuple(run(trial) for trial in group.trials))


@cache
def named_findings() -> Findings:
    """The small campaign in which the second group's water is named and repaired."""
    first, second = small_findings().groups
    return replace(small_findings(), groups=(first, repaired(second)))


@cache
def figures_drawn() -> dict[str, str]:
    with page_style():
        return page_figures(named_findings())


@cache
def rendered() -> str:
    with page_style():
        return page(named_findings(), figures_drawn(), {})


def above_the_overview() -> str:
    return rendered().split('id="overview"')[0]


# ---------------------------------------------------------------- on the page
def test_the_first_screen_has_sentences_picture_numbers_and_grid_before_any_table_of_groups():
    first = above_the_overview().split("<h1>")[1]
    assert "<b>Water depth 2.36\u00a0m</b>: the equation leaves out water that oscillates by itself" in first
    assert '<figure class="first"><svg' in first
    for words in ("error of the equation as prescribed", "error of the repaired equation", "repeating the test",
                  "probability of this answer: as often as such verdicts held on sealed campaigns"):  # fmt: skip
        assert words in first
    assert "<b>72\u00a0%</b>" in first
    cells = re.findall(r'<a class="cell (\w+)" href="#([\w-]+)"', first)
    assert cells == [("good", "spring-short-water-depth-1-63-m"), ("found", "spring-short-water-depth-2-36-m")]


def test_the_picture_is_one_of_the_campaigns_figures_and_says_what_was_adjusted():
    drawn = figures_drawn()
    assert "equation repaired" in drawn["campaign--first"]
    first = above_the_overview()
    assert "Adjusted to this trial, alike for every equation: the release position x0, the clock and the rest" in first
    assert rendered().count("Adjusted to each trial, alike for every equation: the release position x0") == 2


def test_texts_from_files_on_the_first_screen_are_escaped():
    group = repaired(small_findings().groups[1])
    group = replace(group, key={"spring": f"s{MARKUP}", "water_depth_m": 2.36})
    trials = tuple(replace(t, held_out=t.motion.name == f"r{MARKUP}") for t in group.trials)
    unsure = small_findings().groups[0]
    because = replace(unsure.verdict, status="cannot_tell", because=f"b{MARKUP}", decision=())
    groups = (replace(unsure, verdict=because), replace(group, trials=trials))
    findings = replace(small_findings(), groups=groups, doubts=(f"d{MARKUP}",))
    with page_style():
        text = page(findings, page_figures(findings), {})
    first = text.split('id="overview"')[0]
    assert MARKUP not in text
    assert text.count("<script") == 3  # the page's own
    for mark in "dsrb":
        assert f"{mark}&lt;script&gt;" in first, mark


def test_a_letters_outline_is_defined_once_on_a_page():
    outlines = re.findall(r'<path id="([^"]+)" d="[^"]*" transform="[^"]*"/>', rendered())
    assert len(outlines) > 10
    assert len(outlines) == len(set(outlines))
    used = set(re.findall(r'<use xlink:href="#(DejaVu[^"]+)"', rendered()))
    assert used <= set(outlines)


# ---------------------------------------------------------------- the trial
def test_the_held_out_trial_where_the_repair_helps_most_is_shown():
    shown = shown_trial(named_findings())
    assert shown is not None
    assert shown.trial.held_out
    assert shown.place == 1
    assert shown.repaired


def test_a_trial_that_was_fitted_is_shown_only_where_none_was_held_out():
    group = repaired(small_findings().groups[1], left=0.95)
    trials = [replace(trial, held_out=False) for trial in group.trials]
    least = min(range(len(trials)), key=lambda i: trials[i].mismatch.nrmse)
    trials[least] = replace(trials[least], augmented=AugmentedRun(0.0, 0.0 * trials[least].measured))
    findings = replace(small_findings(), groups=(replace(group, trials=tuple(trials)),))
    shown = shown_trial(findings)
    assert shown is not None
    assert shown.trial.motion.name == trials[least].motion.name
    assert shown.gain == pytest.approx(trials[least].mismatch.nrmse)
    assert not first_screen(findings, ["a"])["shown"]["held_out"]


def test_without_a_name_the_held_out_trial_with_the_largest_error_is_shown():
    findings = make_findings()
    shown = shown_trial(findings)
    assert shown is not None
    assert not shown.repaired
    held = [t.mismatch.nrmse for g in findings.groups for t in g.trials if t.held_out]
    assert shown.error == max(held)
    words = [n["words"] for n in first_screen(findings, [str(i) for i in range(6)])["shown"]["numbers"]]
    assert words[0] == "error of the equation"
    assert "error of the repaired equation" not in words


def test_where_something_is_there_without_a_name_the_trial_shown_is_of_that_group():
    first, second = small_findings().groups
    green = replace(first, verdict=replace(first.verdict, status="nothing_missing", verdict=()))
    trials = tuple(replace(t, held_out=False, augmented=None) for t in second.trials)
    verdict = replace(second.verdict, status="unknown", verdict=("unknown",), augmented=None)
    findings = replace(small_findings(), groups=(green, replace(second, trials=trials, verdict=verdict)))
    assert any(t.held_out for t in green.trials)
    shown = shown_trial(findings)
    assert shown is not None
    assert (shown.place, shown.trial.held_out) == (1, False)
    assert shown.error == max(t.mismatch.nrmse for t in trials)
    quiet = replace(verdict, status="cannot_tell", verdict=())
    findings = replace(findings, groups=(green, replace(second, trials=trials, verdict=quiet)))
    shown = shown_trial(findings)
    assert shown is not None
    assert (shown.place, shown.trial.held_out) == (0, True)


def test_findings_without_trials_show_none():
    bare = bare_findings()
    assert shown_trial(replace(bare, groups=(replace(bare.groups[0], trials=()),))) is None


def test_the_numbers_are_the_shown_trials_own():
    findings = named_findings()
    block = first_screen(findings, ["a", "b"])["shown"]
    trial = next(t for t in findings.groups[1].trials if t.held_out)
    before, after = trial.mismatch.nrmse, 0.1 * trial.mismatch.nrmse
    assert block["numbers"][0]["value"] == f"{100 * before:.0f} %"
    assert block["numbers"][1]["value"] == f"{100 * after:.1f} %"
    assert block["anchor"] == "b"


def test_the_picture_draws_three_curves_of_the_first_swings():
    trial = next(t for t in named_findings().groups[1].trials if t.held_out)
    figure = draw_first(trial, Figure(), repaired=True)
    upper, lower = figure.axes
    assert [line.get_label() for line in upper.lines] == ["measured", "equation as prescribed", "equation repaired"]
    assert [line.get_color() for line in lower.lines] == [PRESCRIBED, GREEN]
    peaks, _ = half_cycle_peaks(trial.t, trial.measured, 0.02 * float(np.max(np.abs(trial.measured))))
    end = peaks[2 * SWINGS_SHOWN] if peaks.size > 2 * SWINGS_SHOWN else trial.t[-1]
    assert upper.get_xlim()[1] == pytest.approx(end)
    assert all(np.size(line.get_xdata()) <= FIRST_POINTS for line in upper.lines)
    plain = draw_first(trial, Figure(), repaired=False)
    assert len(plain.axes[0].lines) == 2


# ---------------------------------------------------------------- sentences and grid
@pytest.mark.parametrize(
    ("status", "names", "words"),
    [
        ("nothing_missing", (), "nothing is missing"),
        ("unknown", ("unknown",), "nothing that was tried explains it"),
        ("unknown", ("relaxation", "unknown"), "proved to be all that is missing; what comes closest is"),
        ("present_but_small", ("unknown",), "something smaller than repetitions differ is there, and nothing that was"),
        ("present_but_small", ("relaxation",), "smaller than repetitions differ, the equation leaves out memory"),
        ("cannot_tell", (), "cannot tell whether anything is missing: no dry trials"),
        ("not_identifiable", ("relaxation",), "memory that relaxes or linear damping beyond the structure's own; the"),
        ("explained", ("hidden_resonator",), "something that was not recorded and oscillates by itself"),
    ],
)
def test_every_status_has_a_sentence(status, names, words):
    group = small_findings().groups[1]
    verdict = replace(
        group.verdict, status=status, verdict=names, alternatives=(("linear_damping",),), because="no dry trials."
    )
    (said,) = level_sentences(replace(small_findings(), groups=(replace(group, verdict=verdict),)))
    assert words in said["text"]
    assert said["text"].endswith(").")


def test_springs_of_a_level_of_which_the_same_is_said_share_a_sentence():
    findings = make_findings()
    said = level_sentences(findings)
    assert [s["title"] for s in said] == [f"Water depth {level}\u00a0m" for level in (1.63, 2.36, 2.57)]
    assert said[0]["text"].count("nothing is missing") == 1
    assert "spring long: error" in said[0]["text"]
    assert "spring short: error" in said[0]["text"]
    assert said[1]["tone"] == "open"
    assert "nothing is missing" in said[1]["text"]


def test_the_grid_has_springs_as_rows_and_levels_as_columns():
    findings = make_findings()
    names = [str(i) for i in range(6)]
    table = grid(findings, names)
    assert table["columns"] == [f"water depth {level}\u00a0m" for level in (1.63, 2.36, 2.57)]
    assert [row["head"] for row in table["rows"]] == ["spring long", "spring short"]
    placed = {group.label: name for group, name in zip(findings.groups, names, strict=True)}
    for row in table["rows"]:
        for column, cell in zip(table["columns"], row["cells"], strict=True):
            assert cell["anchor"] == placed[f"{row['head']}, {column}".replace("\u00a0", " ")]
    assert table["rows"][1]["cells"][1]["tone"] == "open"


def test_a_level_without_a_springs_trials_leaves_its_cell_empty():
    findings = make_findings()
    table = grid(replace(findings, groups=findings.groups[:-1]), [str(i) for i in range(5)])
    assert table["rows"][1]["cells"][2] is None


def test_groups_that_no_spring_and_level_tell_apart_stand_in_one_row():
    group = small_findings().groups[0]
    keys = [{"operator": "a", "water_depth_m": depth, "day": day} for depth in (1.0, 2.0) for day in ("x", "y")]
    findings = replace(small_findings(), groups=tuple(replace(group, key=key) for key in keys))
    table = grid(findings, list("1234"))
    assert table["columns"] == []
    assert [cell["anchor"] for cell in table["rows"][0]["cells"]] == list("1234")
    assert level_sentences(findings)[0]["title"] == "Operator a, water depth 1 m, day x"
    with page_style():
        assert page(findings, page_figures(findings), {}).count('<a class="cell good"') == 4


def test_many_levels_have_no_more_sentences_than_fit():
    group = small_findings().groups[0]
    groups = tuple(replace(group, key={"water_depth_m": float(i)}) for i in range(SENTENCES_AT_MOST + 3))
    block = first_screen(replace(small_findings(), groups=groups), [str(i) for i in range(len(groups))])
    assert len(block["sentences"]) == SENTENCES_AT_MOST
    assert block["more"] == "3 more in the table below"


# ---------------------------------------------------------------- behind a verdict
def test_the_conditions_behind_a_verdict_stand_in_its_section_folded():
    section = rendered().split('<section id="spring-short-water-depth-2-36-m">')[1]
    details = section.split('<details class="gates part">')[1].split("</details>")[0]
    assert "3 conditions with their limits" in details
    assert "log odds of hidden resonator over nothing" in details
    assert "<td class=\"n\">812</td><td class=\"n\">at least 4.6</td><td>met</td>" in details
    assert "because &lt;i&gt;this&lt;/i&gt;" in details
    assert details.count("<b>") == 1


def test_a_probability_among_the_conditions_is_never_printed_as_certain():
    verdict = Verdict({}, (), decision=GATES)
    row = gate_rows(verdict)[1]
    assert (row["value"], row["limit"]) == ("over 99 %", "at least 99 %")
    unknown = gate_rows(replace(verdict, decision=(replace(GATES[1], value=math.nan),)))
    assert unknown[0]["value"] == "-"


def test_an_answer_that_larger_sets_hold_has_their_probability_beside_its_own():
    held = Gate("outweighed", "probability of the names that are said", 0.9999, 0.5, True)
    verdict = Verdict({}, (), status="explained", posterior=1e-20, decision=(held,))
    assert posterior_words(verdict).endswith("probability of under 1 %, and all sets that hold these over 99 %")
    exactly = tuple(replace(g, lacking="beside") if g.gate == "outweighed" else g for g in verdict.decision)
    assert "all sets that hold" not in posterior_words(replace(verdict, decision=exactly))  # it asked for this one
    assert posterior_words(replace(verdict, status="unknown")) == ""


def test_a_number_in_a_sentence_stands_with_the_name_of_its_quantity():
    findings = named_findings()
    trials = tuple(replace(t, as_measured=0.71) for t in findings.groups[1].trials)
    findings = replace(findings, groups=(findings.groups[0], replace(findings.groups[1], trials=trials)))
    with page_style():
        text = page(findings, figures_drawn(), {})
    assert "all three as measured, the error is 71" in text
    assert "where the rest is (shares of its square)" in text


def test_what_would_have_been_seen_stands_in_words_the_smallest_share_first():
    large = Detectable("cubic_damping", "coefficient_kg_s_per_m2", 310.0, "kg s/m^2", 0.02)
    small = Detectable("hidden_resonator", "mass_kg", 4.13, "kg", 0.011, 7.9, {"natural_frequency_rad_per_s": 5.234})
    first, second = seen_rows(Verdict({}, (), detectable=(large, small)))
    assert first == {
        "effect": "hidden resonator, natural frequency 5.2 rad/s", "seen": "mass 4.1 kg",
        "share": "1.1 %", "named": "7.9 kg",
    }  # fmt: skip
    assert (second["effect"], second["named"]) == ("cubic damping", "-")


def test_the_page_says_what_would_have_been_seen_and_what_is_not_testable():
    first, second = small_findings().groups
    small = Detectable("hidden_resonator", "mass_kg", 4.13, "kg", 0.011, 7.9)
    told = replace(second.verdict, detectable=(small,), not_testable=("rest_offset",))
    findings = replace(small_findings(), groups=(first, replace(second, verdict=told)))
    with page_style():
        text = page(findings, figures_drawn(), {})
    row = '<td>hidden resonator</td><td class="n">mass 4.1 kg</td><td class="n">1.1\u00a0%</td>'
    assert row + '<td class="n">7.9 kg</td>' in text
    assert "Not testable here: rest offset." in text
    assert text.count("What would have been seen") == 1


def test_the_repaired_equation_stands_beside_the_prescribed_one_and_is_believed():
    section = rendered().split('<section id="spring-short-water-depth-2-36-m">')[1]
    drawn = figures_drawn()
    assert "spring-short-water-depth-2-36-m--repaired" in drawn
    assert "spring-short-water-depth-1-63-m--repaired" not in drawn
    assert "<b>Repaired</b>" in section
    assert "Where both give a number, believe the repaired one" in section
    assert "<b>Repaired</b>" not in rendered().split('<section id="spring-short-water-depth-2-36-m">')[0]


def test_both_numbers_of_a_parameter_are_shown():
    group = repaired(small_findings().groups[1])
    mass = Estimate(300.0, 6.0, 0.0, "kg")
    after = {"added_mass_kg": Estimate(350.0, 7.0, 0.0, "kg"), "hidden_resonator.mass_kg": mass}
    before = {"added_mass_kg": Estimate(-80.0, 12.0, 0.0, "kg"), "drag_coefficient": Estimate(30.0, 2.0, 0.0, "1")}
    verdict = replace(group.verdict, baseline=Described(0.4, 0.5, before), augmented=Described(0.03, 0.04, after))
    block = repaired_block(replace(group, verdict=verdict))
    rows = {row["name"]: (row["before"], row["after"]) for row in block["rows"]}
    assert block["both"]
    beside = replace(verdict, status="unknown", verdict=(*verdict.verdict, "unknown"))
    assert not repaired_block(replace(group, verdict=beside))["both"]  # what is not the answer is not to be believed
    assert rows == {
        "added mass": ("-80 ± 12 kg", "350 ± 7 kg"),
        "drag coefficient": ("30.0 ± 2.0", "not in it"),
        "hidden resonator: mass": ("", "300 ± 6 kg"),
    }


def test_where_no_law_of_motion_is_named_the_numbers_stand_without_an_equation():
    group = repaired(small_findings().groups[1])
    after = {"time_shift.shift_s": Estimate(0.02, 0.001, 0.0, "s")}
    verdict = replace(group.verdict, verdict=("time_shift",), augmented=Described(0.03, 0.04, after))
    findings = replace(small_findings(), groups=(replace(group, verdict=verdict),))
    assert repaired_block(findings.groups[0])["latex"] == ""
    with page_style():
        drawn = page_figures(findings)
        text = page(findings, drawn, {})
    assert not [name for name in drawn if name.endswith("--repaired")]
    assert "no law of the body's motion with the same numbers in all trials" in text


def test_a_release_that_was_not_held_says_that_its_speed_was_adjusted():
    group = small_findings().groups[1]
    assert adjusted_words(group) == "the release position x0, the clock and the rest position"
    trial = group.trials[0]
    pushed = replace(trial, motion=replace(trial.motion, window=replace(trial.motion.window, held=False)))
    assert "x0, the release speed, the clock" in adjusted_words(replace(group, trials=(pushed,)))
    driven = replace(group, verdict=replace(group.verdict, verdict=("external_forcing",)))
    assert "outside force's own size and phase" in adjusted_words(driven)
    assert "drift" not in adjusted_words(driven)
    drifting = replace(group, verdict=replace(group.verdict, verdict=("sensor_drift", "unknown")))
    assert "the sensor's own drift, which is taken out" in adjusted_words(drifting)


def test_a_group_that_what_is_named_does_not_help_says_so_with_the_group_that_needs_it():
    first, second = named_findings().groups
    verdict = second.verdict
    assert verdict.augmented is not None
    worse = replace(
        second, key={**second.key, "spring": "other"},
        verdict=replace(
            verdict, repeatability_nrmse=0.2, baseline=replace(verdict.baseline, nrmse=0.03, held_out_nrmse=0.03),
            augmented=replace(verdict.augmented, nrmse=0.05, held_out_nrmse=0.05),
        ),
    )  # fmt: skip
    findings = replace(named_findings(), groups=(first, second, worse))
    said = no_gain_words(findings, worse)
    assert "does not fall (3.0 % as prescribed, 5.0 % repaired, on unseen trials, both within repeatabil" in said
    assert "What is named is needed there (" in said
    assert no_gain_words(findings, second) == ""
    alone = no_gain_words(replace(findings, groups=(first, worse)), worse)
    assert alone.endswith("both within repeatability, 20 %)")  # no other group of its water was fitted with it
    assert is_no_gain(worse.verdict)
    assert not is_no_gain(second.verdict)
    text = " ".join(s["text"] for s in level_sentences(findings))
    assert "no gain here, both within the 20\u00a0% of repeats" in text


def test_a_group_s_errors_are_those_of_unseen_trials_where_both_equations_have_them():
    before, after = Described(0.05, 0.06), Described(0.03, 0.04)
    assert errors_of(before, after) == (0.06, 0.04, "unseen")
    assert errors_of(before, Described(0.03)) == (0.05, 0.03, "fitted")
    assert errors_of(before, None) is None


def test_a_group_s_errors_are_those_of_trials_left_out_in_turn_where_none_was_held_back():
    before, after = Described(0.05, cross_validated_nrmse=0.07), Described(0.03, cross_validated_nrmse=0.04)
    assert errors_of(before, after) == (0.07, 0.04, "left-out")
    assert errors_of(replace(before, held_out_nrmse=0.06), replace(after, held_out_nrmse=0.05))[2] == "unseen"
    assert errors_of(before, Described(0.03)) == (0.05, 0.03, "fitted")
    second = named_findings().groups[1]
    verdict = replace(second.verdict, baseline=before, augmented=after)
    cell = _cell(replace(second, verdict=verdict), "a")
    assert cell["error"].replace(NO_BREAK, " ") == "7.0 % → 4.0 % (left out)"
    verdict = replace(verdict, augmented=Described(0.03))
    assert _cell(replace(second, verdict=verdict), "a")["error"].replace(NO_BREAK, " ") == "5.0 % → 3.0 % (fitted)"
    verdict = replace(verdict, augmented=Described(0.03, 0.04), baseline=Described(0.05, 0.06))
    assert _cell(replace(second, verdict=verdict), "a")["error"].replace(NO_BREAK, " ") == "6.0 % → 4.0 %"


@pytest.mark.parametrize(("count", "twice"), [(2, True), (1, False)])
def test_two_of_one_kind_are_said_on_the_first_screen_as_in_the_terminal(count, twice):
    second = named_findings().groups[1]
    verdict = replace(second.verdict, status="explained", verdict=("hidden_resonator",) * count, alternatives=())
    said = level_sentences(replace(named_findings(), groups=(replace(second, verdict=verdict),)))
    assert ("at two rates" in said[0]["text"]) == twice
