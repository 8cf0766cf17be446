"""The mass that a stated stiffness, or load cells, and dry trials give where a config states none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.small_campaign import BODY, make_campaign
from undertow.campaign.config import load
from undertow.campaign.run import run
from undertow.campaign.run.checking import Checker, sorted_out
from undertow.campaign.run.tasks import grouped, weighed
from undertow.likelihood.priors import GAIN_STD
from undertow.methods.baseline import terms_by_name
from undertow.recording.gather import gather

DRY = "trials:\n  group_by: [spring]\n  dry: {air: yes}\n"


def campaign(folder: Path, long: float, stiff: float) -> Path:
    """Dry trials of one rig under two names of its spring, whose stated stiffnesses are these; no mass is stated."""
    made = make_campaign(folder, [0.03, 0.05], springs=("long", "stiff"))
    index = made.folder / "campaign.csv"
    rows = index.read_text().splitlines()
    index.write_text("\n".join([rows[0] + ",air", *(row + ",yes" for row in rows[1:])]) + "\n")
    made.edit("trials:\n  group_by: [spring]\n", DRY)
    made.edit("  mass_kg: 2637.4\n", f"  stiffness_N_per_m: {{by: spring, long: {long}, stiff: {stiff}}}\n")
    return made.config


def found(path: Path):
    """The config with a mass, and the note."""
    config = load(path)
    check = Checker(config, config.catalogue())
    motions = sorted_out(config, [check(one) for one in gather(config.catalogue())]).motions
    return weighed(config, grouped(config, motions), terms_by_name(config.equation.terms))


def test_stiffness_and_dry_frequency_give_the_mass(tmp_path):
    config, (note,) = found(campaign(tmp_path / "c", BODY.k_N_per_m, BODY.k_N_per_m))
    assert config.specimen.mass_kg == pytest.approx(BODY.inertia_kg, rel=2e-3)
    assert note.startswith("mass 26")
    assert "from the stated stiffness and the dry trials' frequency" in note
    assert weighed(config, {}, ()) == (config, ())


def test_springs_that_give_different_masses_are_not_believed(tmp_path):
    config, (note,) = found(campaign(tmp_path / "c", BODY.k_N_per_m, 1.2 * BODY.k_N_per_m))
    assert config.specimen.mass_kg is None
    assert "give different masses" in note
    assert note.endswith("state specimen.mass_kg")


def test_a_run_is_in_kilograms_and_says_where_the_mass_is_from(tmp_path):
    findings = run(load(campaign(tmp_path / "c", BODY.k_N_per_m, BODY.k_N_per_m)))
    assert any("mass 26" in note for note in findings.notes)
    for group in findings.groups:
        k = group.fits["sindy"].parameters["k_N_per_m"]
        assert np.isclose(k.value, BODY.k_N_per_m, rtol=2e-2)


def with_load_cells(folder: Path) -> Path:
    """Dry trials whose springs' force was recorded; neither mass nor stiffness is stated."""
    config = campaign(folder, BODY.k_N_per_m, BODY.k_N_per_m)
    rng = np.random.default_rng(5)
    for path in sorted(folder.glob("r*.csv")):
        rows = pd.read_csv(path)
        rows["cell"] = BODY.k_N_per_m * rows["x"] + rng.normal(0.0, 5.0, len(rows))
        rows.to_csv(path, index=False)
    text = config.read_text()
    stated = next(line for line in text.splitlines() if "stiffness_N_per_m" in line)
    text = text.replace(f"{stated}\n", "  gravity_m_per_s2: 9.81\n")
    mapped = next(line for line in text.splitlines() if line.strip().startswith("displacement:"))
    text = text.replace("identify: [sindy]", "identify: [sindy, output_error]")
    config.write_text(text.replace(mapped, f"{mapped}\n    spring_force: {{column: cell, unit: N}}"))
    return config


def test_load_cells_and_dry_frequency_give_the_mass_with_their_gains_error(tmp_path):
    path = with_load_cells(tmp_path / "c")
    config, (note,) = found(path)
    assert config.specimen.mass_kg == pytest.approx(BODY.inertia_kg, rel=5e-3)
    assert "from the load cells and the dry trials' frequency" in note
    specimen = config.specimen_for({"spring": "long", "air": "yes"})
    assert specimen.mass_error_kg == pytest.approx(GAIN_STD * BODY.inertia_kg, rel=0.2)
    group = run(load(path)).groups[0]
    mass = group.fits["output_error"].parameters["total_mass_kg"]
    assert mass.source == "load cells"
    assert mass.systematic == pytest.approx(specimen.mass_error_kg)
    for fit in (group.fits["output_error"], group.fits["sindy"]):
        c = fit.parameters["c_Ns_per_m"]
        assert c.systematic == pytest.approx(specimen.mass_error_kg / specimen.mass_kg * c.value, rel=0.01)
