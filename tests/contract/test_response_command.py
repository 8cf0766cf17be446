"""A harmonic set from its file to a config, a run folder and predictions; what no set can hold, in sentences."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import undertow
from experiments.harmonic_set.__main__ import main as generate
from tests.command_line import undertow as command
from tests.decays import Decay, recorded
from undertow.campaign.config import load
from undertow.campaign.inspection import inspect_file, save_config
from undertow.campaign.run.folder import run_to_folder
from undertow.campaign.starting import start
from undertow.equation.driven import driven_motion
from undertow.equation.driven_slots import DRIVEN_SLOT, N_DRIVEN
from undertow.equation.input import MotionSize, drive_of
from undertow.errors import ConfigError, RecordingError, UndertowError
from undertow.report.numbers import plain_number

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT / "data" / "harmonic_set"
TRUTH = json.loads((DATA / "truth.json").read_text())
FILES = ("config.yaml", "manifest.json", "report.html", "trials.csv", "levels.csv", "mismatch.csv", "equations.json")

CONFIG = """
name: body
recordings:
  files: body*.csv
  response:
    frequency: {column: f, unit: Hz}
    amplitude: {column: a, unit: mm}
    phase: {column: p, unit: deg}
    force: {value: 1.0, unit: N}
equation: {terms: [stiffness, viscous_damping]}
identify: [output_error]
discrepancy: {suspects: [cubic_stiffness, quadratic_drag]}
"""
FREQUENCIES = np.linspace(0.55, 1.2, 30)


def write_set(path: Path, laws: dict, sweep: str = "up", noise: float = 2e-4, seed: int = 0, **drive) -> pd.DataFrame:
    """A body of 2 kg swept one way, noise (m) on both parts: f in Hz, a in mm, p in deg, rows as they were measured."""
    drive = drive or {"force": 1.0}
    made = undertow.frequency_response(laws, FREQUENCIES, sweep=sweep, mass_kg=2.0, **drive).table
    rng = np.random.default_rng(seed)
    motion = made["amplitude"].to_numpy() * np.exp(1j * made["phase_rad"].to_numpy())
    motion = motion + noise * (rng.standard_normal(len(made)) + 1j * rng.standard_normal(len(made)))
    table = pd.DataFrame({"f": FREQUENCIES, "a": 1e3 * np.abs(motion), "p": np.degrees(np.angle(motion))})
    table = table if sweep == "up" else table[::-1]
    table.to_csv(path, index=False)
    return table


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """The run folder of the committed config."""
    folder = tmp_path_factory.mktemp("harmonic") / "run"
    return folder, run_to_folder(ROOT / "configs" / "driven" / "harmonic_set.yaml", out=folder)


def test_a_run_names_the_cubic_stiffness_that_the_equation_lacks_and_its_numbers_cover_the_truth(finished):
    folder, done = finished
    (verdict,) = json.loads((folder / "verdict.json").read_text())["groups"]
    assert verdict["status"] == "explained"
    assert verdict["verdict"] == ["cubic_stiffness"]
    found = verdict["augmented"]["parameters"]
    assert set(found) == set(TRUTH) - {"noise_m"}
    away = [(found[name]["value"] - TRUTH[name]) / found[name]["stderr"] for name in found]
    assert np.max(np.abs(away)) < 3.0
    assert verdict["parameters"]["cubic_stiffness"]["N_per_m3"] == found["cubic_stiffness.N_per_m3"]
    assert verdict["augmented"]["held_out_nrmse"] < 0.01 < 0.5 < verdict["baseline"]["held_out_nrmse"]
    assert verdict["unseen_points"] == 12
    assert "12 points it never saw; with cubic stiffness" in done.summary


def test_the_run_folder_has_the_contracts_files_and_opens(finished):
    folder, _ = finished
    for name in FILES:
        assert (folder / name).stat().st_size > 0
    page = (folder / "report.html").read_text()
    assert page.count("<svg") == 7  # the first screen, two equations twice (for a phone), two sweeps
    assert "phase (°)" in page
    assert "What was tried, on points nobody fitted" in page
    first = page.partition('<section id="first"')[2].partition("</section>")[0]
    assert '<span class="tag found">explained with cubic stiffness</span>' in first
    assert "The equation leaves out stiffness with the cube of the displacement." in first
    assert "<b>How sure</b>: no probability is computed for harmonic sets." in first
    (verdict,) = json.loads((folder / "verdict.json").read_text())["groups"]
    p_value = f"p = {plain_number(verdict['p_value'], 2)}"
    assert f"Noise alone would leave what is left, or more, with {p_value}." in first
    assert f"<b>{p_value}</b>how often noise alone would leave" in first
    assert [first.count(f"var(--fig-{colour})") > 0 for colour in ("ink", "blue", "green")] == [True] * 3
    assert "m_kg" not in page.partition("Config as resolved")[0]
    assert {one.name for one in (folder / "figures").glob("*.svg")} == {
        "all-trials--first.svg", "all-trials--run-1.svg", "all-trials--run-2.svg"
    }  # fmt: skip
    entry = json.loads((folder / "equations.json").read_text())["groups"][0]
    assert entry["versions"]["augmented"]["terms"] == ["stiffness", "viscous_damping", "cubic_stiffness"]
    assert len(entry["versions"]["augmented"]["covariance"]) == 4
    assert {one["trial"] for one in json.loads((folder / "manifest.json").read_text())["inputs"]} == {
        "sweep_up", "sweep_down"
    }  # fmt: skip
    opened = undertow.open(folder)
    assert opened[0].names == ("cubic_stiffness",)
    assert len(opened.trials) == 4
    assert opened.predict(DATA / "sweep_down.csv").rms < 2.0 * TRUTH["noise_m"]
    with pytest.raises(UndertowError, match="is a driven body: take the run's predict; its numbers are in `repaired`"):
        opened[0].equations()
    assert load(folder / "config.yaml").recordings.response is not None  # the resolved config is a config again


def test_explain_and_compare_take_the_run(finished, capsys):
    folder, _ = finished
    assert "quintic_stiffness: cubic stiffness comes closer" in command(capsys, "explain", folder).out
    assert command(capsys, "compare", folder, folder).code == 0


def test_a_prediction_sweeps_as_the_set_was_measured_and_jumps_where_it_does(finished, capsys, tmp_path):
    folder, _ = finished
    for name in ("sweep_up", "sweep_down"):
        said = command(capsys, "predict", folder, "--recording", DATA / f"{name}.csv", "--out", tmp_path / "p.csv")
        assert said.code == 0
        made = pd.read_csv(tmp_path / "p.csv")
        assert list(made.columns)[:6] == ["frequency_Hz", "measured", "predicted", "lower", "upper", "used"]
        assert np.max(np.abs(made["predicted"] - made["measured"])) < 5.0 * TRUTH["noise_m"]
        inside = np.mean((made["lower"] <= made["measured"]) & (made["measured"] <= made["upper"]))
        assert inside > 0.75  # 33 points, 90 % expected with a standard error of 5 %
        assert said.out.splitlines()[-1].startswith("rms 0.000")


def test_the_equation_of_a_set_runs_free_on_a_record_in_time(finished, capsys, tmp_path):
    folder, _ = finished
    rng = np.random.default_rng(5)
    t = 0.02 * np.arange(2000)
    u = np.convolve(rng.normal(size=2030), np.hanning(30), "same")[:2000]
    theta = np.zeros(N_DRIVEN)
    numbers = {"mass": 2.0, "k1": 50.0, "c1": 0.6, "k3": 400.0, "gain": 1.0, "bw_unit": 1.0, "bw_n": 1.0}
    for name, value in numbers.items():
        theta[DRIVEN_SLOT[name]] = value
    x = driven_motion(theta, np.zeros(0, dtype=np.int64), drive_of(t, u), t, MotionSize(), 40).x[:, 0]
    noisy = x + TRUTH["noise_m"] * rng.normal(size=t.size)
    pd.DataFrame({"t": t, "x": noisy, "u": u}).to_csv(tmp_path / "burst.csv", index=False)
    channels = "time: {column: t}, displacement: {column: x, unit: m}, force: {column: u, unit: N}"
    (tmp_path / "c.yaml").write_text(f"name: b\nrecordings: {{files: burst.csv, channels: {{{channels}}}}}\n")
    said = command(capsys, "predict", folder, "--recording", tmp_path / "burst.csv", "--config", tmp_path / "c.yaml")
    assert said.code == 0
    assert float(said.out.split()[-2]) < 0.005 * np.std(x)


def test_a_prediction_of_a_set_that_is_not_there_says_so(finished, capsys):
    folder, _ = finished
    said = command(capsys, "predict", folder, "--recording", "nowhere.csv")
    assert (said.code, "nowhere.csv is not there; give the path of a harmonic set" in said.err) == (2, True)


def test_inspect_saves_a_config_of_a_harmonic_set_that_runs(tmp_path):
    (tmp_path / "sweep_up.csv").write_bytes((DATA / "sweep_up.csv").read_bytes())
    told = inspect_file(tmp_path / "sweep_up.csv")
    assert "a harmonic set: 33 points, 0.55 to 1.2 Hz, 33 of them reached upward and 0 downward" in told
    assert "phase: {column: phase_lag_deg, unit: deg, sign: -1}" in told
    config = save_config(tmp_path / "sweep_up.csv", told)
    done = run_to_folder(config, ["discrepancy.suspects=[]"], out=tmp_path / "run")
    assert "6 points it never saw; nothing was checked: discrepancy.suspects names no law" in done.summary
    assert done.sentence.endswith("more than noise is left.")
    assert undertow.open(tmp_path / "run")[0].status == "cannot_tell"


def test_init_writes_one_config_for_all_sweeps_of_a_folder(tmp_path):
    for name in ("sweep_up.csv", "sweep_down.csv"):
        (tmp_path / name).write_bytes((DATA / name).read_bytes())
    pd.DataFrame({"freq_Hz": FREQUENCIES, "amplitude": 1.0 + FREQUENCIES, "phase": -100.0 * FREQUENCIES}).to_csv(
        tmp_path / "other.csv", index=False
    )
    started = start(tmp_path)
    assert started.trials == 2
    assert "its columns are not those of" in dict(started.left_out)["other.csv"]
    config = load(started.path)
    assert config.recordings.files == ("sweep_down.csv", "sweep_up.csv")


def test_a_set_beside_recordings_in_time_is_left_out_of_their_config(tmp_path):
    r = recorded(Decay(1.6, 60.0, 0.04, 0.02, 0.004, noise=2e-3, held=0.8, periods=12.0, seed=4), ("displacement",))
    pd.DataFrame({"time_s": r.time, "disp_m": r.channels["displacement"]}).to_csv(tmp_path / "r1.csv", index=False)
    (tmp_path / "sweep_up.csv").write_bytes((DATA / "sweep_up.csv").read_bytes())
    started = start(tmp_path)
    assert started.trials == 1
    assert dict(started.left_out)["sweep_up.csv"] == (
        "is a harmonic set, and needs a config of its own (recordings.response)"
    )


def test_a_set_of_few_points_is_fitted_and_nothing_is_said_to_be_checked(tmp_path):
    write_set(tmp_path / "body.csv", {"stiffness": 50.0, "viscous_damping": 0.6})
    pd.read_csv(tmp_path / "body.csv")[::2].to_csv(tmp_path / "body.csv", index=False)
    (tmp_path / "c.yaml").write_text(CONFIG)
    done = run_to_folder(tmp_path / "c.yaml", out=tmp_path / "run")
    (verdict,) = json.loads((tmp_path / "run" / "verdict.json").read_text())["groups"]
    assert verdict["status"] == "cannot_tell"
    assert "of 15 points 3 are held out; laws are tried where 20 are fitted and 5 held out" in verdict["because"]
    assert verdict["baseline"]["parameters"]["stiffness.k_N_per_m"]["value"] == pytest.approx(50.0, rel=0.01)
    assert "nothing was checked" in done.summary


def test_what_no_law_of_the_library_explains_is_unknown(tmp_path):
    """A second mass on a spring of its own, in closed form: two resonances."""
    w = 2.0 * np.pi * FREQUENCIES
    inner = 0.1 * (5.3**2 + 0.2j * 5.3 * w)
    motion = 1.0 / (50.0 - 2.0 * w**2 + 0.6j * w - inner * w**2 / (5.3**2 - w**2 + 0.2j * 5.3 * w))
    pd.DataFrame({"f": FREQUENCIES, "a": 1e3 * np.abs(motion), "p": np.degrees(np.angle(motion))}).to_csv(
        tmp_path / "body.csv", index=False
    )
    (tmp_path / "c.yaml").write_text(CONFIG)
    run_to_folder(tmp_path / "c.yaml", out=tmp_path / "run")
    (verdict,) = json.loads((tmp_path / "run" / "verdict.json").read_text())["groups"]
    assert verdict["status"] == "unknown"
    assert verdict["verdict"][-1] == "unknown"


def test_a_body_on_a_shaking_table_lacks_the_waters_drag_and_groups_have_equations_of_their_own(tmp_path):
    laws = {"stiffness": 50.0, "viscous_damping": 0.6}
    for water, drag in (("wet", {"quadratic_drag": 8.0}), ("dry", {})):
        write_set(tmp_path / f"body_{water}.csv", laws | drag, base_displacement=0.03, frame="absolute")
    text = CONFIG.replace("force: {value: 1.0, unit: N}", "base_displacement: {value: 60.0, unit: mm, given_as: pe")
    text = text.replace("given_as: pe", "given_as: peak_to_peak}").replace("unit: mm}", "unit: mm, frame: absolute}")
    text = text.replace("  response:", "  pattern: body_(?P<water>[a-z]+)[.]csv\n  response:")
    (tmp_path / "c.yaml").write_text(text + "trials: {group_by: [water]}\nspecimen: {mass_kg: 2.0}\n")
    run_to_folder(tmp_path / "c.yaml", out=tmp_path / "run")
    groups = json.loads((tmp_path / "run" / "verdict.json").read_text())["groups"]
    found = {group["group"]["water"]: group for group in groups}
    assert (found["dry"]["status"], found["wet"]["status"]) == ("nothing_missing", "explained")
    drag = found["wet"]["parameters"]["quadratic_drag"]["drag_Ns2_per_m2"]
    assert abs(drag["value"] - 8.0) < 4.0 * drag["stderr"] < 1.0
    version = json.loads((tmp_path / "run" / "equations.json").read_text())["groups"][1]["versions"]["augmented"]
    assert {row["term"]: row["relative_to"] for row in version["rows"]}["quadratic_drag"] == "water"


@pytest.mark.parametrize(
    ("before", "after", "sentence"),
    [
        ("unit: Hz", "unit: m", r"response\.frequency: frequency is said to be in 'm', .* may be in Hz, kHz, rad/s"),
        ("unit: deg", "unit: mm", r"response\.phase: phase is said to be in 'mm'"),
        ("unit: Hz", "unit: blips", r"frequency: unit 'blips' is not known; it may be Hz"),
        ("unit: mm", "unit: N", r"response\.amplitude: displacement is said to be in 'N'"),
        ("unit: N}", "unit: mm}", r"response\.force: force is said to be in 'mm'"),
        ("value: 1.0", "value: -1.0", "force is -1 N; an amplitude and an error are above zero"),
        ("value: 1.0, ", "", "force has column None and value None; give exactly one of them"),
        ("    force", "    base_displacement", r"response\.base_displacement: base_displacement is said to be in 'N'"),
        ("    force: {value: 1.0, unit: N}\n", "", "has the drives none; give exactly one of force, base_disp"),
        ("force: {value: 1.0, unit: N}", "base_displacement: {value: 1.0, unit: mm}", "amplitude has no frame, and"),
        ("viscous_damping", "hidden_resonator", "'hidden_resonator' keeps a state from one period to the next"),
        ("terms: [stiffness, ", "terms: [", "nothing that pulls the body back"),
        ("identify:", "trials: {hold_out: {every: 2}}\nidentify:", "of a harmonic set give auto or a list of files"),
        ("identify:", "trials: {dry: {water: no}}\nidentify:", r"trials\.dry has no effect on a harmonic set"),
        ("  response:", "  channels: {time: {rate_hz: 1.0}}\n  response:", "channels and response; a harmonic set has"),
        ("    force", "    sweep: {}\n    force", "sweep has column None and by None; give exactly one"),
        ("    force", "    sweep: sideways\n    force", "sweep is 'sideways' but should be 'order', 'up', 'down' or k"),
        ("    force", "    stderr: {unit: mm}\n    force", "stderr has column None and value None"),
    ],
)
def test_a_config_that_cannot_be_a_harmonic_sets_stops_with_a_sentence(tmp_path, before, after, sentence):
    assert before in CONFIG
    (tmp_path / "c.yaml").write_text(CONFIG.replace(before, after, 1))
    with pytest.raises(ConfigError, match=sentence):
        load(tmp_path / "c.yaml")


@pytest.mark.parametrize(
    ("row", "column", "value", "sentence"),
    [
        (4, "f", 0.0, r"column 'f' \(frequency\) is 0 in row 5 of 30, not above zero; a body at rest has no response"),
        (2, "a", -3.0, r"column 'a' \(amplitude\) is -3 in row 3 of 30, not above zero; an amplitude has no sign"),
        (6, "p", np.nan, r"column 'p' \(phase\) has 1 values that are not finite, the first in row 7 of 30; repair"),
    ],
)
def test_points_that_cannot_be_measured_fail_their_trial_in_a_sentence(tmp_path, row, column, value, sentence):
    table = write_set(tmp_path / "body.csv", {"stiffness": 50.0, "viscous_damping": 0.6})
    table.loc[row, column] = value
    table.to_csv(tmp_path / "body.csv", index=False)
    (tmp_path / "c.yaml").write_text(CONFIG)
    with pytest.raises(UndertowError, match=f"none of 1 trials can be used: trial body: {sentence}"):
        run_to_folder(tmp_path / "c.yaml", out=tmp_path / "run")
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("before", "after", "sentence"),
    [
        ("value: 1.0", "value: {by: newtons}", "trial body: response.force goes by 'newtons', but it has no such cond"),
        ("    force", "    sweep: {by: way}\n    force", "response.sweep goes by 'way', which is None in this trial"),
    ],
)
def test_a_condition_that_a_trial_lacks_fails_it_in_a_sentence(tmp_path, before, after, sentence):
    write_set(tmp_path / "body.csv", {"stiffness": 50.0, "viscous_damping": 0.6})
    (tmp_path / "c.yaml").write_text(CONFIG.replace(before, after, 1))
    with pytest.raises(UndertowError, match=sentence):
        run_to_folder(tmp_path / "c.yaml", out=tmp_path / "run")


def test_the_committed_set_is_what_its_generator_writes(tmp_path):
    generate(tmp_path)
    for name in ("sweep_up", "sweep_down"):
        made, kept = (pd.read_csv(folder / f"{name}.csv").to_numpy() for folder in (tmp_path, DATA))
        assert made == pytest.approx(kept, abs=2e-3)  # the last printed digit


def test_one_bad_file_fails_alone(tmp_path):
    write_set(tmp_path / "body_1.csv", {"stiffness": 50.0, "viscous_damping": 0.6})
    write_set(tmp_path / "body_2.csv", {"stiffness": 50.0, "viscous_damping": 0.6}).drop(columns="p").to_csv(
        tmp_path / "body_2.csv", index=False
    )
    (tmp_path / "c.yaml").write_text(CONFIG)
    done = run_to_folder(tmp_path / "c.yaml", ["discrepancy.suspects=[]"], out=tmp_path / "run")
    assert [one.name for one in done.failed] == ["body_2"]
    assert "has no column 'p'; it has f, a; correct recordings.response" in done.failed[0].reason


def test_phases_of_the_other_sign_are_told_by_the_power_that_the_body_would_give(tmp_path):
    table = write_set(tmp_path / "body.csv", {"stiffness": 50.0, "viscous_damping": 0.6})
    table.assign(p=-table["p"]).to_csv(tmp_path / "body.csv", index=False)
    (tmp_path / "c.yaml").write_text(CONFIG)
    with pytest.raises(UndertowError, match=r"gives power to what drives it .* set response\.phase\.sign: -1"):
        run_to_folder(tmp_path / "c.yaml", out=tmp_path / "run")


def test_a_stated_force_may_go_by_a_condition_and_a_sweep_by_another(tmp_path):
    for name, sweep in (("body_up_1", "up"), ("body_down_2", "down")):
        laws = {"stiffness": 50.0, "viscous_damping": 0.6}
        write_set(tmp_path / f"{name}.csv", laws, sweep, force=float(name[-1])).sample(frac=1.0, random_state=1).to_csv(
            tmp_path / f"{name}.csv", index=False
        )
    text = CONFIG.replace("{value: 1.0, unit: N}", "{value: {by: newtons}, unit: N}\n    sweep: {by: way}")
    text = text.replace("  response:", "  pattern: body_(?P<way>[a-z]+)_(?P<newtons>[0-9])[.]csv\n  response:")
    (tmp_path / "c.yaml").write_text(text)
    done = run_to_folder(tmp_path / "c.yaml", out=tmp_path / "run")
    verdict = json.loads((tmp_path / "run" / "verdict.json").read_text())["groups"][0]
    assert verdict["status"] == "nothing_missing", done.summary
    assert verdict["baseline"]["parameters"]["mass_kg"]["value"] == pytest.approx(2.0, rel=0.01)
    proved = run_to_folder(tmp_path / "c.yaml", ["trials.hold_out=[body_up_1]"], out=tmp_path / "proved")
    (verdict,) = json.loads((tmp_path / "proved" / "verdict.json").read_text())["groups"]
    assert (verdict["held_out"], verdict["unseen_points"]) == (["body_up_1"], 30), proved.summary
    run_to_folder(tmp_path / "c.yaml", ["trials.hold_out=[]"], out=tmp_path / "nothing")
    (verdict,) = json.loads((tmp_path / "nothing" / "verdict.json").read_text())["groups"]
    assert (verdict["status"], verdict["because"][:33]) == ("cannot_tell", "of 60 points 0 are held out; laws")


def test_a_harmonic_set_without_phases_is_no_config(tmp_path):
    pd.DataFrame({"frequency_Hz": np.arange(1.0, 9.0), "amplitude_mm": np.arange(2.0, 10.0)}).to_csv(
        tmp_path / "r.csv", index=False
    )
    with pytest.raises(RecordingError, match="in which nothing looks like phase; a run needs amplitude and phase"):
        inspect_file(tmp_path / "r.csv")
