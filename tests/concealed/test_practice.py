"""Practice campaigns whose makers share no equation with undertow: skipped where they are not beside the repository."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from undertow.campaign.config import load
from undertow.campaign.run import run

ROOT = Path(__file__).resolve().parents[2]
PRACTICE = ROOT.parent / "shared" / "practice"
needs_practice = pytest.mark.skipif(not PRACTICE.is_dir(), reason="practice campaigns (../shared/practice) not here")


def findings(name: str, suspects: str):
    settings = [f"discrepancy.suspects={suspects}", "identify=[output_error]"]
    config = load(ROOT / "configs" / "practice" / f"{name}.yaml", settings)
    return run(config, jobs=1)


def truth(name: str):
    return json.loads((PRACTICE / name / "TRUTH.json").read_text())


@needs_practice
def test_nothing_is_missing_where_equation_15_made_the_data():
    found = findings("two", "[linear_damping, hidden_resonator, cubic_stiffness, relaxation]")
    assert [g.verdict.status for g in found.groups] == ["nothing_missing"] * 6
    levels = truth("two")["levels"]
    area = 0.97
    trials = truth("two")["trials"]
    for group in found.groups:
        if group.dry:
            continue
        depth = f"{group.key['water_depth_m']:.2f}"
        numbers = group.fits["output_error"].parameters
        added = numbers["added_mass_kg"]
        scatter_kg = 0.003 * 3300.0 * 2.0  # two standard deviations of k's scatter, as mass
        assert abs(added.value - levels[depth]["rigid_added_mass_total"]) < max(3.0 * added.total_stderr, scatter_kg)
        drag = numbers["drag_coefficient"]
        q = next(t["q"] for t in trials.values() if f"{t['H']:.2f}" == depth)
        assert abs(drag.value - q / (0.5 * 1000.0 * area)) < 3.0 * drag.total_stderr


@pytest.mark.slow
@needs_practice
def test_slosh_in_closed_cells_is_named_and_proved():
    found = findings("one", "[linear_damping, hidden_resonator, cubic_stiffness]")
    levels = truth("one")["levels"]
    for group in found.groups:
        if group.dry:
            assert group.verdict.status == "nothing_missing"
            continue
        said, mode = group.verdict, levels[f"{group.key['water_depth_m']:.2f}"]
        assert said.verdict[0] == "hidden_resonator"
        assert said.origin == "water"
        resonator = said.parameters["hidden_resonator"]
        assert resonator["natural_frequency_rad_per_s"].value == pytest.approx(mode["omega1_linear"], rel=0.03)
        assert resonator["mass_kg"].value == pytest.approx(mode["participating_mass_mode1"], rel=0.2)
        if group.key["spring"] == "short":
            assert all(t.mismatch.missing for t in group.trials)
            assert said.baseline.held_out_nrmse > 4.0 * said.augmented.held_out_nrmse


@needs_practice
@pytest.mark.slow
def test_radiation_is_linear_damping_and_no_other_name():
    found = findings("three", "[linear_damping, hidden_resonator, relaxation, cubic_stiffness]")
    levels = truth("three")["levels"]
    for group in found.groups:
        if group.dry:
            assert group.verdict.verdict == ()
            continue
        assert group.verdict.verdict == ("linear_damping",)
        damping = group.verdict.parameters["linear_damping"]["c_Ns_per_m"]
        expected = levels[f"{group.key['water_depth_m']:.2f}"]["c_rad"]
        half_width = 1.645 * damping.stderr  # nominal 90 %
        assert abs(damping.value - expected) < half_width
        assert half_width < 0.25 * expected
