"""`undertow differ` on two driven files: simulations that lack a law, have another number, or lack nothing."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from experiments.driven.bodies import NOTHING, Body, body, record
from tests.command_line import undertow as command
from undertow.campaign.differ.driven import compare_driven
from undertow.equation.driven import driven_motion
from undertow.equation.driven_laws import find_driven
from undertow.equation.input import MotionSize, drive_of
from undertow.errors import ConfigError
from undertow.likelihood.driven import DrivenLaws

CONFIG = """
name: shaken
recordings:
  files: recording.csv
  channels:
    time: {column: time_s, unit: s}
    displacement: {column: position_m, unit: m}
    force: {column: force_N, unit: N, hold: first}
equation: {terms: [stiffness, viscous_damping, coulomb_friction]}
identify: [output_error]
discrepancy: {suspects: [quadratic_drag, cubic_stiffness, position_damping]}
"""
SEED = 8400
LAWS = DrivenLaws(tuple(find_driven(name) for name in ("stiffness", "viscous_damping", "coulomb_friction")))
SUSPECTS = ("quadratic_drag", "cubic_stiffness")


@pytest.fixture(scope="module")
def with_drag():
    """A body with a quadratic drag that nobody put into its simulation."""
    return body("random", SEED, "quadratic_drag")


def without(one: Body, **other: float) -> Body:
    """The body without its missing law, and with other numbers."""
    kept = {name: value for name, value in one.numbers.items() if not name.startswith(one.missing)}
    return replace(one, missing="", numbers={**kept, **other})


def simulated(one: Body, again: int = 1):
    """A record of the body under another force, without noise."""
    trial = record(one, again=again)
    t = np.array(trial.t)
    x = driven_motion(one.theta(), NOTHING, drive_of(t, trial.u, "first"), t, MotionSize(), 60).x[:, 0]
    return replace(trial, outputs={"displacement": x})


def write(path, trial):
    """A table of time, position and force."""
    columns = {"time_s": trial.t, "position_m": trial.outputs["displacement"], "force_N": trial.u}
    pd.DataFrame(columns).to_csv(path, index=False)


@pytest.fixture(scope="module")
def lacking(with_drag, tmp_path_factory):
    """A folder with both files and the config, and the command's answer."""
    folder = tmp_path_factory.mktemp("differ")
    write(folder / "simulation.csv", simulated(without(with_drag)))
    write(folder / "recording.csv", record(with_drag))
    (folder / "c.yaml").write_text(CONFIG)
    return folder


def test_a_law_that_the_simulation_lacks_is_named_and_how_far_it_is_away(lacking, capsys):
    pair = ("--simulation", lacking / "simulation.csv", "--recording", lacking / "recording.csv")
    said = command(capsys, "differ", *pair, "--config", lacking / "c.yaml", "--out", lacking / "out")
    assert said.code == 0, said.err
    assert "The simulation lacks" in said.out
    found = json.loads((lacking / "out" / "differ.json").read_text())
    assert found["lacks"] == ["quadratic_drag"]
    assert found["extra"] == []
    assert found["nrmse"] > 10.0 * found["nrmse_of_its_own_equation"]
    assert "quadratic_drag.drag_Ns2_per_m2" in found["differs_in_number"]  # 0 there, a number here
    page = (lacking / "out" / "differ.html").read_text()
    assert "standard errors apart" in page
    assert "<td>viscous damping</td>" in page
    assert "displacement" in page  # a name of the record there had run over the picture's edge
    assert page.count('<figure class="equation">') == 2  # of simulation and recording, typeset
    assert 'id="theme"' in page
    assert page.count("<td>viscous damping</td>") == 1
    assert '<b class="alarm">' in page


def test_a_driven_file_without_a_config_asks_for_one(lacking, capsys):
    pair = ("--simulation", lacking / "simulation.csv", "--recording", lacking / "recording.csv")
    said = command(capsys, "differ", *pair)
    assert said.code == 1
    assert "simulation.csv is driven (force); say with --config which column drives it" in said.err


def test_what_the_simulation_has_beyond_the_recording_is_extra(with_drag):
    found = compare_driven(record(with_drag, again=1), record(without(with_drag)), LAWS, SUSPECTS)
    assert found.lacks == ()
    assert found.extra == ("quadratic_drag",)
    assert "which the recording does not show" in found.sentence


def test_two_runs_of_one_body_differ_in_nothing(with_drag):
    found = compare_driven(simulated(with_drag), record(with_drag), LAWS, SUSPECTS)
    assert found.lacks == found.extra == found.far == ()
    assert found.missed < 2.0 * found.own
    assert "lacks no law that this recording shows: under the recording's input" in found.sentence


def test_a_number_that_differs_is_named_with_its_standard_errors_and_no_other(with_drag):
    calm = without(with_drag)
    softer = {"stiffness.k_N_per_m": 0.97 * calm.numbers["stiffness.k_N_per_m"]}
    found = compare_driven(simulated(without(with_drag, **softer)), record(calm), LAWS, SUSPECTS)
    assert found.far == ("stiffness.k_N_per_m",)
    row = next(row for row in found.rows if row.name == "stiffness.k_N_per_m")
    assert row.simulation.value / row.recording.value == pytest.approx(0.97, abs=0.002)
    assert "differs in stiffness (" in found.sentence


def test_an_angle_is_drawn_in_degrees_and_its_numbers_are_moments(lacking, tmp_path, capsys):
    turns = CONFIG.replace("unit: m}", "unit: rad}").replace("unit: N,", "unit: N m,")
    turns = turns.replace("equation: {", "equation: {coordinate: rotation, ")
    (tmp_path / "turns.yaml").write_text(turns)
    pair = ("--simulation", lacking / "simulation.csv", "--recording", lacking / "recording.csv")
    said = command(capsys, "differ", *pair, "--config", tmp_path / "turns.yaml", "--out", tmp_path)
    assert said.code == 0, said.err
    page, found = (tmp_path / "differ.html").read_text(), json.loads((tmp_path / "differ.json").read_text())
    assert ">angle<" in page
    assert ">(°)<" in page
    assert "(mm)" not in page
    assert "an angle in rad moves" in page
    numbers = page.partition("Numbers, with the laws of both")[2].partition("</table>")[0]
    assert "N m/rad" in numbers
    assert " N/m<" not in numbers
    units = {row["name"]: row["recording"]["unit"] for row in found["terms"]}
    assert units["stiffness.k_N_per_m"] == "N m/rad"
    assert units["mass_kg"] == "kg m^2"
    assert "N s²/m²" not in said.out
    assert "standard errors apart)" in said.out


def test_files_of_other_columns_are_refused(with_drag):
    one = record(with_drag)
    other = replace(one, outputs={"velocity": np.gradient(one.outputs["displacement"], one.t)})
    with pytest.raises(ConfigError, match="the simulation has force and velocity, the recording force and d"):
        compare_driven(other, one, LAWS, SUSPECTS)


def test_harmonic_sets_are_refused(lacking, capsys):
    text = "name: s\nrecordings:\n  files: recording.csv\n  response:\n    frequency: {column: time_s, unit: Hz}\n"
    text += "    amplitude: {column: position_m, unit: m}\n    phase: {column: position_m, unit: rad}\n"
    (lacking / "set.yaml").write_text(text + "    force: {value: 1.0, unit: N}\nequation: {terms: [stiffness]}\n")
    pair = ("--simulation", lacking / "simulation.csv", "--recording", lacking / "recording.csv")
    said = command(capsys, "differ", *pair, "--config", lacking / "set.yaml")
    assert said.code == 2
    assert "describes harmonic sets (response); undertow differ takes records in time" in said.err
