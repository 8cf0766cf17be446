"""Kilograms and their errors in water alone: by load cells where nobody states a spring, and of a single trial."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from tests.small_campaign import BODY, Campaign, make_campaign, recorded, write_table
from undertow.campaign.run.folder import run_to_folder

WET = "equation:\n  terms: [stiffness, viscous_damping, coulomb_friction, added_mass]"


@pytest.fixture(scope="module", params=["mass_kg: 2000", "submerged_volume_m3: 0.0"], ids=["a mass", "no mass"])
def finished(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The run's folder, of a body whose dry mass is 2,000 kg, stated or not."""
    campaign: Campaign = make_campaign(tmp_path_factory.mktemp("wet"), (0.05, 0.08, 0.11))
    for seed, (file, x0) in enumerate(zip(campaign.files, (0.05, 0.08, 0.11), strict=True)):
        table = recorded(x0, seed)
        noise = 5.0 * np.random.default_rng(50 + seed).standard_normal(len(table))
        force = 1e-3 * (BODY.k_N_per_m * recorded(x0, 0)[:, 1] + noise)
        write_table(campaign.folder / file, np.column_stack([table, force]), "t,x,a,f")
    campaign.edit("equation:\n  terms: [stiffness, viscous_damping, coulomb_friction]", WET)
    campaign.edit("mass_kg: 2637.4", request.param)
    campaign.edit("trials:", "    spring_force: {column: f, unit: kN}\ntrials:")
    campaign.edit("identify: [sindy]", "identify: [sindy, output_error]")
    run_to_folder(campaign.config, out=campaign.folder / "out")
    return campaign.folder / "out"


@pytest.fixture(scope="module")
def rows(finished: Path) -> dict[str, dict[str, str]]:
    """levels.csv by method."""
    with (finished / "levels.csv").open(newline="") as stream:
        return {row["method"]: row for row in csv.DictReader(stream)}


def test_the_page_says_where_kilograms_come_from(finished: Path) -> None:
    page = (finished / "report.html").read_text(encoding="utf-8")
    assert "kilograms and newtons rest on the stiffness 109600" in page


@pytest.mark.parametrize("method", ["baseline", "output_error", "sindy"])
def test_kilograms_are_those_of_the_load_cells(rows: dict[str, dict[str, str]], method: str) -> None:
    row = rows[method]
    assert float(row["c_Ns_per_m"]) == pytest.approx(BODY.c_Ns_per_m, rel=0.05)
    if row.get("total_mass_kg"):
        assert float(row["total_mass_kg"]) == pytest.approx(BODY.inertia_kg, rel=0.005)
        assert float(row["total_mass_kg_stderr"]) > 0.005 * BODY.inertia_kg  # a gain of load cells
    if row.get("added_mass_kg"):
        assert float(row["added_mass_kg"]) == pytest.approx(BODY.inertia_kg - 2000.0, rel=0.02)
        assert float(row["added_mass_kg_stderr"]) > 0.005 * BODY.inertia_kg
    assert row.get("total_mass_kg") or row["added_mass_kg"]


def test_the_stiffness_is_told_beside_them(rows: dict[str, dict[str, str]]) -> None:
    for method in ("output_error", "sindy"):
        row = rows[method]
        assert float(row["k_N_per_m"]) == pytest.approx(BODY.k_N_per_m, rel=0.002)
        assert float(row["k_N_per_m_stderr"]) == pytest.approx(0.005 * BODY.k_N_per_m, rel=0.1)


def test_the_interval_of_a_single_trial_holds_how_much_another_would_differ(tmp_path: Path) -> None:
    campaign = make_campaign(tmp_path, (0.08,))
    campaign.edit("equation:\n  terms: [stiffness, viscous_damping, coulomb_friction]", WET)
    stated = f"mass_kg: 2000\n  stiffness_N_per_m: {BODY.k_N_per_m}\n  scatter: {{k: 0.01, c: 0.1, mu: 0.2}}"
    campaign.edit("mass_kg: 2637.4", stated)
    campaign.edit("identify: [sindy]", "identify: [output_error]")
    run_to_folder(campaign.config, out=tmp_path / "out")
    with (tmp_path / "out" / "levels.csv").open(newline="") as stream:
        rows = {row["method"]: row for row in csv.DictReader(stream)}
    for method in ("baseline", "output_error"):
        row = rows[method]
        assert float(row["added_mass_kg_stderr"]) == pytest.approx(0.01 * BODY.inertia_kg, rel=0.05)
        assert float(row["c_Ns_per_m_stderr"]) == pytest.approx(0.1 * BODY.c_Ns_per_m, rel=0.2)
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    said = "one trial: intervals hold that another would differ by 1 % in k, 10 % in c, 20 % in friction coefficient"
    assert said.replace(" %", "\u00a0%") in page
