"""The curves that go along with a page: what is packed is what was measured, to a fraction of the noise."""

from __future__ import annotations

import base64
import json
import zlib
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.findings_fixture import NOISE_M, bare_findings, named, small_findings
from undertow.discrepancy.findings import AugmentedRun
from undertow.report.explorer import FINENESS, TRIALS_AT_MOST, explorer_block, further_channels, steps_of, trial_data
from undertow.report.style import new_figure, page_style
from undertow.report.trial_curves import draw_runs_before_and_after


def unpacked(text: str) -> str:
    return zlib.decompress(base64.b64decode(text)).decode()


def values(curve: dict[str, Any]) -> np.ndarray:
    return curve["step"] * np.cumsum(curve["by"])


def test_a_packed_curve_is_within_half_a_step_of_its_values_and_steps_are_a_third_of_the_noise() -> None:
    trial = small_findings().groups[1].trials[0]
    data = trial_data(trial, 10_000)
    measured = next(c for c in data["curves"] if c["kind"] == "measured")["values"]
    assert measured["step"] == pytest.approx(1e3 * NOISE_M / FINENESS)
    assert np.max(np.abs(values(measured) - 1e3 * trial.measured)) <= 0.5 * measured["step"] * (1.0 + 1e-9)
    assert np.allclose(values(data["t"]), trial.t, atol=data["t"]["step"])


def test_a_curve_that_starts_late_says_where_and_one_with_gaps_stays_out() -> None:
    trial = small_findings().groups[1].trials[0]
    late, gaps = np.zeros(trial.t.size), np.zeros(trial.t.size)
    late[:7], gaps[20:30] = np.nan, np.nan
    kinds = {}
    for residual in (late, gaps):
        data = trial_data(replace(trial, augmented=AugmentedRun(0.1, residual)), 10_000)
        kinds[bool(np.isnan(residual[0]))] = {c["kind"]: c["start"] for c in data["curves"]}
    assert kinds[True]["after"] == 7
    assert "after" not in kinds[False]



def test_a_green_curve_says_what_it_is_of() -> None:
    """Repaired is a group in which something is named; else it is the candidate that comes closest."""
    group = named(small_findings().groups[1])
    nothing = replace(group, verdict=replace(group.verdict, verdict=()))
    for one, said in ((group, "with what was found"), (nothing, "with the closest candidate")):
        block = explorer_block(replace(small_findings(), groups=(one,)), ["g"])
        assert {t["found"] for t in json.loads(unpacked(block["data"]))["trials"]} == {said}
    trial = replace(group.trials[0], augmented=AugmentedRun(0.1, np.zeros(group.trials[0].t.size)))
    with page_style():
        drawn = draw_runs_before_and_after(trial, new_figure(5.0, 3.0).subplots(), "with the closest candidate")
    assert [line.get_label() for line in drawn.lines][-1] == "with the closest candidate: error 10 %"


def test_of_long_trials_every_nth_sample_goes_along_and_the_page_can_say_so() -> None:
    trial = small_findings().groups[1].trials[0]
    data = trial_data(trial, 100)
    assert data["every"] == -(-trial.t.size // 100)
    assert len(data["t"]["by"]) <= 100
    assert all(len(c["values"]["by"]) == len(data["t"]["by"]) for c in data["curves"])


def test_further_recorded_channels_go_along_with_their_units() -> None:
    trial = small_findings().groups[0].trials[0]
    recording = trial.motion.recording
    force = {**recording.channels, "spring_force": np.arange(recording.time.size, dtype=float)}
    motion = replace(trial.motion, recording=replace(recording, channels=force))
    ((name, found, unit),) = further_channels(replace(trial, motion=motion))
    assert (name, unit, found.size) == ("spring_force", "N", trial.t.size)
    assert found[0] == np.flatnonzero(motion.inside)[0]


def test_the_page_knows_every_trials_place_and_says_when_some_are_left_out() -> None:
    findings = small_findings()
    block = explorer_block(findings, ["a", "b"])
    trials = json.loads(unpacked(block["data"]))["trials"]
    assert [t["name"] for t in trials] == sorted(block["places"], key=block["places"].__getitem__)
    assert {t["anchor"] for t in trials} == {"a", "b"}
    assert block["more"] == ""
    group = bare_findings().groups[0]
    many = replace(bare_findings(), groups=(replace(group, trials=group.trials * (TRIALS_AT_MOST + 3)),))
    assert explorer_block(many, ["a"])["more"] == f"24 of {TRIALS_AT_MOST + 3} trials"


def test_the_library_is_plotlys_own_and_no_packed_text_ends_a_script() -> None:
    block = explorer_block(bare_findings(), ["a"])
    assert "plotly.js" in unpacked(block["library"])[:200]
    assert "<" not in block["library"] + block["data"]


def test_steps_of_a_curve_of_nothing_are_zero() -> None:
    assert steps_of(np.zeros(3), 0.0) == {"step": 1.0, "by": [0, 0, 0]}
