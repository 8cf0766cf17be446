"""The mass that a stated stiffness and dry trials give where a config states none."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.small_campaign import BODY, make_campaign
from undertow.campaign.config import load
from undertow.campaign.run import run
from undertow.campaign.run.checking import Checker, sorted_out
from undertow.campaign.run.tasks import grouped, weighed
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
