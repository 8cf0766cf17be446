"""A simulation against a recording: what it lacks is named, what is equal is not, and bad files are one sentence."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.command_line import undertow
from undertow.campaign.differ.compare import compare_motions
from undertow.campaign.differ.files import differ
from undertow.campaign.differ.lacking import UNKNOWN, _in_kilograms
from undertow.campaign.differ.words import sentence_of
from undertow.conditioning.condition import condition
from undertow.conditioning.motion import Motion
from undertow.discrepancy.verdict import Described, Verdict
from undertow.equation import registry
from undertow.equation.equation import Equation, equation_15
from undertow.equation.simulate import simulate
from undertow.errors import ConfigError, RecordingError
from undertow.likelihood.fit import Specimen
from undertow.quantities import Estimate
from undertow.recording.recording import Recording
from undertow.report.difference import _found, difference_json, lead_of, sure_of

SPRING_N_PER_M = 109_600.0
PLAIN = equation_15(2637.4, 300.0, 590.0, SPRING_N_PER_M, 170.0, 1000.0)
SPECIMEN = Specimen(stiffness_N_per_m=SPRING_N_PER_M)
NOISE_M, NOISE_M_PER_S2 = 2.5e-5, 0.012
RATE_HZ, HOLD_S, MOTION_S = 100.0, 0.5, 8.0

CONFIG = """\
name: pair
recordings:
  files: recording.csv
  channels:
    time: {column: time_s, unit: s}
    displacement: {column: disp_mm, unit: mm}
    acceleration: {column: accel_mps2, unit: m/s^2}
    spring_force: {column: loadcell_N, unit: N}
specimen: {stiffness_N_per_m: 109600}
equation: {terms: [stiffness, viscous_damping, coulomb_friction, added_mass, quadratic_drag]}
"""


def with_term(name: str, coefficient: float, **inner: float) -> Equation:
    term = registry.find(name, **inner)
    return replace(PLAIN, terms=(*PLAIN.terms, term), coefficients=(*PLAIN.coefficients, coefficient))


def channels(equation: Equation, x0: float, noisy: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Time, displacement (m) and acceleration of a hold and the motion after it; a simulation has no noise."""
    rng = np.random.default_rng(1)
    motion = simulate(equation, x0, np.arange(0.0, MOTION_S, 1.0 / RATE_HZ))
    held = round(HOLD_S * RATE_HZ)
    x, a = np.r_[np.full(held, x0), motion.x], np.r_[np.zeros(held), motion.a]
    if noisy:
        x = x + NOISE_M * rng.standard_normal(x.size)
        a = a + NOISE_M_PER_S2 * rng.standard_normal(a.size)
    return np.arange(x.size) / RATE_HZ, np.round(x, 6), np.round(a, 5)


def moved(equation: Equation, noisy: bool, x0: float = 0.1) -> Motion:
    time, x, a = channels(equation, x0, noisy)
    return condition(Recording("recording" if noisy else "simulation", time, {"displacement": x, "acceleration": a}))


def table(path: Path, equation: Equation, noisy: bool, x0: float = 0.1) -> Path:
    time, x, a = channels(equation, x0, noisy)
    head = "time_s,disp_mm,accel_mps2"
    np.savetxt(path, np.column_stack([time, 1e3 * x, a]), delimiter=",", header=head, comments="", fmt="%.5f")
    return path


@pytest.fixture(scope="module")
def simulated() -> Motion:
    return moved(PLAIN, noisy=False)


def test_a_complete_simulation_lacks_nothing(simulated):
    found = compare_motions(simulated, moved(PLAIN, noisy=True, x0=0.08), specimen=SPECIMEN)
    assert found.lacks == found.extra == ()
    assert not found.mismatch.missing
    assert "lacks no law" in found.sentence
    assert all(not row.sigmas > 4.0 for row in found.rows)  # four numbers, each within its errors


@pytest.mark.slow
def test_water_that_the_simulation_has_not_is_named_in_kilograms(simulated):
    truth = with_term("hidden_resonator", 200.0, natural_frequency_rad_per_s=9.0, damping_ratio=0.01)
    found = compare_motions(simulated, moved(truth, noisy=True), specimen=SPECIMEN)
    assert found.lacks == ("hidden_resonator",)
    assert not found.by_equation
    numbers = found.recording.verdict.parameters["hidden_resonator"]
    assert numbers["mass_kg"].value == pytest.approx(200.0, rel=0.05)
    assert numbers["natural_frequency_rad_per_s"].value == pytest.approx(9.0, rel=0.01)


def test_the_pages_first_sentence_says_one_thing_where_nothing_that_was_tried_is_the_answer(simulated):
    """A name and "no suspect explains it" at once contradict each other: the name is the closest of what was tried."""
    found = compare_motions(simulated, moved(PLAIN, noisy=True, x0=0.08), specimen=SPECIMEN)
    assert lead_of(found).startswith("The simulation lacks no law that this recording shows: its equation stays within")
    side, verdict = found.recording, found.recording.verdict
    open_side = replace(side, verdict=replace(verdict, verdict=("hidden_resonator", "unknown")))
    closest = replace(found, recording=open_side, lacks=("hidden_resonator", "unknown"), by_equation=False)
    assert "no suspect" not in lead_of(closest)
    assert "oscillates by itself" in lead_of(closest)
    said = sentence_of(closest)  # the terminal says the page's first words, and then how sure and how far
    assert said.startswith(lead_of(closest))
    assert "It is the closest of what was tried" in said
    assert "A repeated test would miss" in said
    assert "closest of what was tried" in sure_of(closest)
    nothing = replace(closest, lacks=("unknown",))
    assert "lacks something that no suspect explains: its equation misses" in lead_of(nothing)
    assert not sure_of(nothing)


@pytest.mark.slow
def test_what_both_have_beside_their_equations_is_not_lacking():
    truth = with_term("hidden_resonator", 200.0, natural_frequency_rad_per_s=9.0, damping_ratio=0.01)
    found = compare_motions(moved(truth, noisy=False, x0=0.06), moved(truth, noisy=True))
    assert found.lacks == ()
    assert any("both show, beside the equations above: hidden resonator" in note for note in found.notes)


@pytest.mark.slow
def test_a_law_of_the_recordings_own_equation_is_named(simulated):
    found = compare_motions(simulated, moved(with_term("cubic_stiffness", 3e6), noisy=True), specimen=SPECIMEN)
    assert found.lacks == ("cubic_stiffness",)
    assert found.by_equation
    row = next(r for r in found.rows if "cubic" in r.name)
    assert row.simulation is None
    assert row.recording.value == pytest.approx(3e6, rel=0.05)


def test_more_damping_than_the_simulation_has_is_named_as_a_difference_in_number(simulated):
    found = compare_motions(simulated, moved(with_term("linear_damping", 1500.0), noisy=True), specimen=SPECIMEN)
    assert found.lacks == found.more == ("linear_damping",)
    assert "lacks enough linear damping" in found.sentence


def test_a_simulation_on_another_spring_is_let_go_where_the_recording_was(simulated):
    """The score adjusts the release, down to a fraction where frequencies differ; cycles are those of the whole one."""
    stiff = moved(equation_15(2637.4, 300.0, 590.0, 1.4 * SPRING_N_PER_M, 170.0, 1000.0), noisy=True)
    found = compare_motions(simulated, stiff)
    assert found.run.simulated[0] < 0.7 * stiff.amplitude
    assert found.released.simulated[0] == pytest.approx(stiff.amplitude, rel=0.02)
    assert found.cycles.damping_ratio_simulated[0] < 2.0 * found.cycles.damping_ratio[0]
    assert "differs in stiffness per mass" in found.sentence


def test_motions_in_different_channels_are_not_compared(simulated):
    only = moved(PLAIN, noisy=True).recording
    speed = np.gradient(only.channels["displacement"], only.time)
    bare = condition(replace(only, channels={"velocity": speed}))
    with pytest.raises(RecordingError, match="simulation gives displacement and the recording velocity"):
        compare_motions(simulated, bare)


def test_a_pair_of_files_gives_a_page_and_a_json_that_agree(tmp_path, capsys):
    simulation = table(tmp_path / "simulation.csv", PLAIN, noisy=False)
    recording = table(tmp_path / "recording.csv", with_term("cubic_stiffness", 3e6), noisy=True)
    config = tmp_path / "pair.yaml"
    config.write_text(CONFIG)
    said = undertow(
        capsys, "differ", "--simulation", simulation, "--recording", recording, "--config", config, "--out",
        tmp_path / "out",
    )  # fmt: skip
    assert said.code == 0, said.err
    found = json.loads((tmp_path / "out" / "differ.json").read_text())
    assert found["lacks"] == ["cubic_stiffness"]
    assert found["sentence"] in said.out
    assert found["where"]["time"]["early"] + found["where"]["time"]["late"] <= 1.0 + 1e-9
    page = (tmp_path / "out" / "differ.html").read_text().replace("\N{NO-BREAK SPACE}", " ")
    assert "lacks stiffness with the cube" in page
    assert "repeatability" not in page  # the search's limit is what one recording allows, and is called so
    assert "k 0.4 %, c 20 %" in page
    assert "displacement (mm)" in page
    assert "damping of a cycle (% of critical)" in page
    assert page.count("<figcaption") == 2
    assert page.count("<svg") == 2
    assert 'src="http' not in page
    assert "<script src" not in page
    assert 'id="theme"' in page
    lead = re.search(r'<p class="lead">(.*?)</p>', page)[1]
    assert re.fullmatch(r"The simulation lacks stiffness .*: with it the error falls from 3\d % to 0\.0\d+ % .*", lead)
    assert "How sure: the recording&#39;s own equation needs it" in page
    assert "<td>simulation&#39;s equation with its own numbers</td>" in page
    assert not re.search(r"x&#39;&#39;|\^\d|in 1 of 1 trials", page)
    row = next(r for r in found["terms"] if r["name"] == "total_mass_kg")
    assert row["simulation"]["value"] == pytest.approx(2937.4, rel=1e-3)


def spoiled(tmp_path: Path, how: str) -> Path:
    """A simulation's file with one thing wrong with it."""
    lines = table(tmp_path / "simulation.csv", PLAIN, noisy=False).read_text().splitlines()
    if how == "two samples":
        lines = lines[:3]
    elif how == "another column":
        lines[0] = lines[0].replace("disp_mm", "weg")
    elif how == "nan":
        for at in range(100, 300):
            time, _, a = lines[at].split(",")
            lines[at] = f"{time},nan,{a}"
    elif how == "nothing":
        lines = []
    path = tmp_path / "spoiled.csv"
    path.write_text("\n".join(lines) + ("\n" if lines else ""))
    return path


@pytest.mark.parametrize(
    ("how", "sentence"),
    [
        ("two samples", "simulation .*: 2 samples; a release and its decay need 20"),
        ("another column", "simulation .* has no column 'disp_mm'; it has time_s, weg, accel_mps2"),
        ("nan", "simulation .* displacement lacks 200 of .* values, the first at 0.9"),
        ("nothing", "is empty"),
    ],
)
def test_a_file_that_cannot_be_used_is_one_sentence_and_exit_code_one(tmp_path, capsys, how, sentence):
    recording = table(tmp_path / "recording.csv", PLAIN, noisy=True)
    config = tmp_path / "pair.yaml"
    config.write_text(CONFIG)
    bad = spoiled(tmp_path, how)
    with pytest.raises(RecordingError, match=sentence):
        differ(bad, recording, config, tmp_path / "out")
    said = undertow(capsys, "differ", "--simulation", bad, "--recording", recording, "--config", config)
    assert said.code == 1
    assert len(said.err.strip().splitlines()) == 1


def test_a_path_that_is_not_there_and_a_missing_option_are_usage_errors(tmp_path, capsys):
    recording = table(tmp_path / "recording.csv", PLAIN, noisy=True)
    with pytest.raises(ConfigError, match=r"--simulation .*nowhere\.csv is no file; give the path"):
        differ(tmp_path / "nowhere.csv", recording)
    assert undertow(capsys, "differ", "--simulation", tmp_path / "nowhere.csv", "--recording", recording).code == 2
    assert undertow(capsys, "differ", "--recording", recording).code == 2
    config = tmp_path / "nowhere.yaml"
    assert (
        undertow(capsys, "differ", "--simulation", recording, "--recording", recording, "--config", config).code == 2
    )


def test_a_folder_that_cannot_be_written_is_said(tmp_path, capsys, monkeypatch, simulated):
    recording = table(tmp_path / "recording.csv", PLAIN, noisy=True)
    blocked = tmp_path / "file"
    blocked.write_text("")
    result = compare_motions(simulated, moved(PLAIN, noisy=True), specimen=SPECIMEN)
    monkeypatch.setattr("undertow.campaign.differ.files.compare_motions", lambda *_, **__: result)
    said = undertow(capsys, "differ", "--simulation", recording, "--recording", recording, "--out", blocked / "in")
    assert said.code == 1
    assert "cannot be written" in said.err


def test_a_rotation_is_not_compared_with_a_translation(tmp_path):
    recording = table(tmp_path / "recording.csv", PLAIN, noisy=True)
    turned = tmp_path / "turned.csv"
    turned.write_text(recording.read_text().replace("disp_mm", "roll_deg").replace("accel_mps2", "other"))
    with pytest.raises(RecordingError, match="looks like a rotation, the recording's like a translation"):
        differ(turned, recording)


def test_numbers_of_two_angles_are_moments_without_a_config_too():
    one, other = (moved(PLAIN, noisy=noisy) for noisy in (False, True))
    turned = [replace(m, recording=replace(m.recording, coordinate="rotation")) for m in (one, other)]
    said = difference_json(compare_motions(turned[0], turned[1]))
    units = [row["recording"]["unit"] for row in said["terms"] if row["recording"]]
    assert all("N m" in unit or "kg m^2" in unit for unit in units), units
    assert r"N\,m" in said["equations"]["recording"]["latex"]
    assert r"\mathrm{N/m" not in said["equations"]["recording"]["latex"]


def test_a_simulation_in_another_unit_lacks_no_physics(tmp_path):
    recording = table(tmp_path / "recording.csv", PLAIN, noisy=True)
    rows = np.loadtxt(recording, delimiter=",", skiprows=1)
    rows[:, 1] *= 1e-3
    simulation = tmp_path / "simulation.csv"
    np.savetxt(simulation, rows, delimiter=",", header="time_s,disp_mm,accel_mps2", comments="", fmt="%.8f")
    said = r"released from .*e-05 m and the recording from 0\.0.* m, 0\.00.* times as far, .* for another unit"
    with pytest.raises(RecordingError, match=said):
        differ(simulation, recording, out=tmp_path / "out")


def test_a_simulation_whose_milliseconds_are_read_as_seconds_lacks_no_physics(tmp_path):
    recording = table(tmp_path / "recording.csv", PLAIN, noisy=True)
    rows = np.loadtxt(recording, delimiter=",", skiprows=1)
    rows[:, 0] *= 1e3
    simulation = tmp_path / "simulation.csv"
    np.savetxt(simulation, rows, delimiter=",", header="time_s,disp_mm,accel_mps2", comments="", fmt="%.8f")
    slow = pair(simulation, recording, acceleration=False)
    said = (
        r"the simulation's period is 1\.0.e\+03 s and the recording's 1\.0. s, 1e\+03 times as long, and more than 3 "
        r"times is taken for another unit of time: correct the unit .* recordings\.channels\.time\.unit"
    )
    with pytest.raises(RecordingError, match=said):
        differ(*slow, out=tmp_path / "out")


def pair(simulation: Path, recording: Path, acceleration: bool) -> tuple[Path, Path]:
    """Both tables with their last column named as no channel, so that it is not read."""
    if not acceleration:
        for path in (simulation, recording):
            path.write_text(path.read_text().replace("accel_mps2", "other"))
    return simulation, recording


def test_a_sign_and_an_assumed_unit_are_said_beside_the_sentence(tmp_path, capsys):
    recording = table(tmp_path / "recording.csv", PLAIN, noisy=True)
    time, x, _ = channels(PLAIN, -0.09, noisy=False)
    simulation = tmp_path / "simulation.csv"
    np.savetxt(simulation, np.column_stack([time, x]), delimiter=",", header="t,x", comments="", fmt="%.6f")
    pair(simulation, recording, acceleration=False)
    out = tmp_path / "out"
    said = undertow(capsys, "differ", "--simulation", simulation, "--recording", recording, "--out", out)
    assert said.code == 0, said.err
    lines = said.out.splitlines()
    assert "note: simulation: displacement: column 'x' says no unit; m is assumed" in said.out
    sides = r"note: the simulation is released from -0\.0.* m and the recording from \+0\.\d+ m, to opposite sides"
    assert re.search(sides, said.out)
    assert lines[-1].startswith("report: ")
    notes = json.loads((out / "differ.json").read_text())["notes"]
    assert any("to opposite sides" in note for note in notes)
    assert any("m is assumed" in note for note in notes)


def test_units_that_nobody_said_and_that_contradict_each_other_are_asked_for(tmp_path):
    recording = table(tmp_path / "recording.csv", PLAIN, noisy=True)
    nameless = tmp_path / "nameless.csv"
    nameless.write_text(recording.read_text().replace("disp_mm", "pot").replace("accel_mps2", "acc"))
    said = r"simulation .*nameless\.csv: .*seems to be in mm, not m.*Guessed: displacement: column 'pot' "
    with pytest.raises(RecordingError, match=said):
        differ(nameless, recording, out=tmp_path / "out")


def test_what_a_recording_has_is_shown_in_words_and_per_kilogram_once():
    own = {"mass_kg": Estimate(0.0885, 0.0005, unit="kg per kg")}
    verdict = Verdict({}, (), augmented=Described(0.01, math.nan, {}), parameters={"hidden_resonator": [own]})
    told = _in_kilograms(verdict, UNKNOWN)
    assert _found(told.parameters) == [("hidden resonator: mass", "0.0885 ± 0.0005 kg per kg")]
