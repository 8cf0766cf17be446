"""Pages draw the free run with what was found beside the equation's."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure

from tests.findings_fixture import small_findings
from undertow.discrepancy import calibration
from undertow.discrepancy.calibration import LEFT, record_of
from undertow.discrepancy.findings import AugmentedRun, TrialFindings
from undertow.discrepancy.verdict import Described, Gate
from undertow.front.terminal.verdicts import probability_words
from undertow.report.blocks import likelihood_words, overview, unseen_words, verdict_block
from undertow.report.html import page, page_figures
from undertow.report.style import GREEN
from undertow.report.trial_figures import draw_free_run, draw_residual, trial_heading


def with_addition() -> TrialFindings:
    """A trial whose free run with what was found misses a tenth of what the equation's misses."""
    trial = small_findings().groups[-1].trials[0]
    left = 0.1 * (trial.measured - trial.simulated)
    return replace(trial, augmented=AugmentedRun(0.1 * trial.mismatch.nrmse, left))


def green(axes) -> list[np.ndarray]:
    """Ordinates of the green lines."""
    return [np.asarray(line.get_ydata()) for line in axes.lines if line.get_color() == GREEN]


def test_the_run_with_what_was_found_is_drawn_about_the_equations_rest():
    trial = with_addition()
    axes = Figure().subplots()
    draw_free_run(trial, axes)
    (drawn,) = green(axes)
    measured = np.asarray(axes.lines[0].get_ydata())
    plain = np.asarray(axes.lines[1].get_ydata())
    assert np.max(np.abs(drawn - measured)) < 0.2 * np.max(np.abs(plain - measured))


def test_its_residual_is_drawn_and_its_error_said():
    trial = with_addition()
    axes = Figure().subplots()
    draw_residual(trial, axes)
    assert len(green(axes)) == 1
    assert "with what was found: error" in trial_heading(trial)


def test_without_a_verdict_nothing_is_added():
    trial = replace(with_addition(), augmented=None)
    axes = Figure().subplots()
    draw_free_run(trial, axes)
    assert green(axes) == []
    assert "what was found" not in trial_heading(trial)


def test_a_group_says_its_proof_on_unseen_trials_and_how_probable_it_is():
    found = small_findings()
    group = found.groups[-1]
    verdict = replace(
        group.verdict, status="explained", verdict=("hidden_resonator",), sentence="short: water swings.",
        confidence=0.91, posterior=0.72,
        baseline=replace(group.verdict.baseline, held_out_nrmse=0.5), augmented=Described(0.05, 0.06),
    )  # fmt: skip
    said = replace(found, groups=(replace(group, verdict=verdict),))
    assert unseen_words(verdict) == "50 % → 6.0 %"
    assert unseen_words(replace(verdict, augmented=Described(0.05))) == ""
    text = page(said, page_figures(said), {})
    text = text.replace("\u00a0%", " %")
    assert "50 % → 6.0 %" in text
    record = record_of(verdict)
    assert record is not None
    assert f"of {record.said} such verdicts (explained, only noise is left) on sealed campaigns" in text
    assert "which makes 91 % (docs/calibration.md)." in text
    assert "exactly this one has a posterior probability of 72 %." in text
    assert likelihood_words(replace(verdict, confidence=float("nan"))) == ""
    plain = verdict_block(replace(verdict, sentence="not the answer, because hidden_resonator is 2 N/m^3"))["sentence"]
    assert plain == "not the answer, because hidden resonator is 2 N/m³"
    assert verdict_block(replace(verdict, status="unknown"))["posterior"] == ""  # its names are no answer
    assert likelihood_words(replace(verdict, status="not_identifiable")) == ""


def test_few_verdicts_are_counted_and_make_no_percentage(monkeypatch):
    kind = "explained, more than noise is left"
    monkeypatch.setattr(calibration, "_records", lambda: {kind: calibration.Record(kind, 7, 5)})
    found = small_findings()
    group = found.groups[-1]
    left = Gate(LEFT, "mean squared residual over noise", 30.0, 2.5, False)
    verdict = replace(
        group.verdict, status="explained", verdict=("hidden_resonator",), confidence=0.58, decision=(left,),
        augmented=Described(0.05, 0.06),
    )  # fmt: skip
    record = record_of(verdict)
    assert record is not None
    assert record.few == "5 of 7"
    assert likelihood_words(verdict) == record.few
    assert verdict_block(verdict)["confidence"] == ""
    said = replace(found, groups=(replace(group, verdict=verdict),))
    text = page(said, page_figures(said), {})
    assert "which makes" not in text
    assert "such answers held on sealed campaigns of known truth: too few for a percentage" in text
    gates = [{"gate": LEFT, "value": 30.0, "limit": 2.5}]
    entry = {"status": "explained", "verdict": ["hidden_resonator"], "confidence": 0.58, "decision": gates}
    assert probability_words(entry) == record.few


def test_names_that_the_data_cannot_tell_apart_stand_together():
    group = small_findings().groups[-1]
    verdict = replace(
        group.verdict, status="not_identifiable", verdict=("linear_damping",), alternatives=(("relaxation",),)
    )
    row = overview(replace(small_findings(), groups=(replace(group, verdict=verdict),)), ["a"])["rows"][0]
    assert row["names"] == "linear damping or relaxation"
