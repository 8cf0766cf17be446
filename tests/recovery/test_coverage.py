"""Stated intervals hold the truth as often as they say: a slice of the study, and the committed study itself."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from experiments.coverage.campaigns import make_campaign
from experiments.coverage.study import RESULTS, WET, Entry, coverage, intervals, measure, read, summary
from experiments.eq15_campaign.tables import submerged_volume
from undertow.campaign.config import load
from undertow.campaign.run import run
from undertow.conditioning.condition import condition

DOCS = Path(__file__).resolve().parents[2] / "docs" / "uncertainty_measured.md"

CONFIG = """\
name: coverage
recordings:
  index: campaign.csv
  channels:
    time: {{column: t, unit: s}}
    displacement: {{column: x, unit: m}}
    acceleration: {{column: a, unit: m/s^2}}
trials:
  group_by: [water_depth_m]
  dry: {{water_depth_m: 1.63}}
specimen:
  mass_kg: 2637.4
  area_m2: {{by: water_depth_m, {depth}: 0.97}}
  submerged_volume_m3: {{by: water_depth_m, {depth}: {volume}}}
equation:
  terms: [stiffness, viscous_damping, coulomb_friction, added_mass, quadratic_drag]
identify: [output_error]
discrepancy: {{suspects: []}}
"""


def test_a_slice_of_the_study_still_runs_and_covers():
    entries = [e for kind in ("tables", "practice") for e in measure(make_campaign(kind, 3, 77), kind, 3, 77)]
    assert len(entries) == 14
    assert all(np.isfinite(e.stderr) and e.stderr > 0.0 for e in entries)
    assert sum(e.inside for e in entries) >= 9  # of 14 at 90 %: fewer once in 600 draws, were they independent


def test_the_study_goes_the_way_of_the_main_run(tmp_path):
    """The same recordings through files, config and `run` give the study's values and standard errors."""
    campaign = make_campaign("practice", 3, 5)
    depth = campaign.truth.water_depth_m
    rows = ["file,water_depth_m"]
    for recording in (*campaign.dry, *campaign.wet):
        table = np.column_stack([recording.time, *(recording.channels[n] for n in ("displacement", "acceleration"))])
        np.savetxt(tmp_path / f"{recording.name}.csv", table, delimiter=",", header="t,x,a", comments="", fmt="%.12g")
        rows.append(f"{recording.name}.csv,{recording.conditions['water_depth_m']}")
    (tmp_path / "campaign.csv").write_text("\n".join(rows) + "\n")
    (tmp_path / "config.yaml").write_text(CONFIG.format(depth=depth, volume=submerged_volume(depth)))
    findings = run(load(tmp_path / "config.yaml"), jobs=1)
    dry, wet = (group.fits["output_error"].parameters for group in findings.groups)
    motions = [[condition(recording) for recording in group] for group in (campaign.dry, campaign.wet)]
    for fit, name, expected in intervals(campaign.truth, *motions):
        if fit == "baseline":
            continue
        found = (wet if name in WET else dry)[name]
        assert found.value == pytest.approx(expected.value, rel=1e-3, abs=0.02 * expected.total_stderr)
        assert found.total_stderr == pytest.approx(expected.total_stderr, rel=0.02)  # files round to 12 digits


def test_the_committed_study_is_the_one_that_the_page_shows():
    page = DOCS.read_text(encoding="utf-8")
    for line in summary(read(RESULTS)):
        assert line in page


def test_the_committed_study_covers_what_it_says():
    entries = read(RESULTS)
    assert len({(e.scatter, e.trials, e.seed) for e in entries}) >= 400
    for fit, name in dict.fromkeys((e.fit, e.parameter) for e in entries):
        found = coverage(e for e in entries if (e.fit, e.parameter) == (fit, name))
        assert 0.86 - found.stderr <= found.share <= 0.94 + found.stderr, (fit, name, found)  # 402: 1.2 to 1.6 %


def test_an_interval_that_misses_is_counted_as_a_miss():
    entry = Entry("practice", 3, 0, "dry", "mu", 1.0, 0.1, 1.1)
    assert entry.inside
    assert not replace(entry, truth=1.17).inside
    assert coverage([entry, replace(entry, truth=1.17)]).share == 0.5
