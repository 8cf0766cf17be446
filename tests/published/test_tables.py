"""The transcribed tables: the numbers that this project uses, and what is odd in them, as their README says."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from experiments.eq15_campaign import tables

FOLDER = Path(__file__).resolve().parents[2] / "data" / "published"
MASS_KG = 2637.4


def column(name: str, quantity: str) -> np.ndarray:
    with (FOLDER / f"{name}.csv").open(newline="") as stream:
        return np.array([float(row[quantity]) for row in csv.DictReader(stream)])


def test_there_are_ten_tables_and_the_readme_names_each():
    files = sorted(path.name for path in FOLDER.glob("table*.csv"))
    assert len(files) == 10
    readme = (FOLDER / "README.md").read_text(encoding="utf-8")
    assert [name for name in files if name not in readme] == []


@pytest.mark.parametrize(("spring", "name"), [("long", "table01_dry_long"), ("short", "table02_dry_short")])
def test_the_default_campaign_is_made_from_the_dry_tables(spring, name):
    assert tuple(column(name, "c_Ns_per_m")) == tables.DRY_C_NS_PER_M[spring]
    assert tuple(column(name, "mu")) == tables.DRY_MU[spring]
    assert tuple(column(name, "k_N_per_m")) == tables.DRY_K_N_PER_M[spring]


@pytest.mark.parametrize(
    ("spring", "name"), [("long", "table04_method1_long_by_level"), ("short", "table06_method1_short_by_level")]
)
def test_the_default_campaign_is_made_from_the_wet_tables(spring, name):
    depths = column(name, "water_depth_m")
    assert dict(zip(depths, column(name, "added_mass_kg"), strict=True)) == tables.ADDED_MASS_KG[spring]
    assert dict(zip(depths, column(name, "drag_coefficient"), strict=True)) == tables.DRAG_COEFFICIENT[spring]
    assert dict(zip(depths, column(name, "water_in_cells_kg"), strict=True)) == tables.WATER_IN_CELLS_KG


@pytest.mark.parametrize("name", ["table01_dry_long", "table02_dry_short"])
def test_stiffness_is_in_newtons_per_metre_whatever_the_heading_says(name):
    k = column(name, "initial_load_N") / column(name, "x0_m")
    np.testing.assert_allclose(column(name, "k_N_per_m"), k, rtol=0.02)


def test_energies_are_joules_and_those_of_table_7_are_not_of_these_releases():
    k = tables.dry_mean("long")[0]
    x0 = column("table05_method1_long_full_submergence", "x0_m")
    energy = column("table05_method1_long_full_submergence", "potential_energy_J")
    np.testing.assert_allclose(energy, 0.5 * k * x0**2, rtol=0.04)  # x0 is printed to 1 mm
    seventh = column("table07_method2_long_full_submergence", "potential_energy_J")
    np.testing.assert_allclose(np.sort(seventh) / np.sort(energy), 3.54, rtol=0.01)


def test_printed_dry_period_of_the_short_spring_and_its_stiffness_disagree_by_4_percent():
    printed_period_s = 0.519
    k = MASS_KG * (2.0 * np.pi / printed_period_s) ** 2
    assert tables.dry_mean("short")[0] / k - 1.0 == pytest.approx(0.040, abs=0.002)


def test_damping_of_the_long_spring_is_two_groups_and_no_scatter():
    x0, c = column("table01_dry_long", "x0_m"), column("table01_dry_long", "c_Ns_per_m")
    assert c[x0 < 0.045].min() > 680.0
    assert c[x0 > 0.045].max() < 455.0


def test_accelerations_of_table_10_imply_more_mass_than_printed():
    x0 = column("table10_summary_long_full_submergence", "x0_m")
    a = column("table10_summary_long_full_submergence", "max_acceleration_m_per_s2")
    implied = tables.dry_mean("long")[0] * x0 / a
    assert implied.min() > 4200.0
    assert implied.max() < 4750.0


def test_drag_force_of_table_10_is_the_drag_law_with_its_own_area():
    name = "table10_summary_long_full_submergence"
    force = 0.5 * 1000.0 * 0.97 * column(name, "drag_coefficient") * column(name, "max_velocity_m_per_s") ** 2
    np.testing.assert_allclose(force, column(name, "drag_force_N"), rtol=0.02)
