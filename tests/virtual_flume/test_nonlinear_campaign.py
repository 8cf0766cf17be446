"""The committed campaign of steep closed cells: remade in slices, held with its truth; its maker knows no undertow."""

from __future__ import annotations

import ast
import csv
import gzip
import json
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from experiments.virtual_flume import nonlinear_campaign as maker
from experiments.virtual_flume import nonlinear_checks, sensors
from experiments.virtual_flume.nonlinear_cell import tadjbakhsh_keller
from experiments.virtual_flume.nonlinear_water import theory_mode

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT / "data" / "nonlinear_cell"
TRUTH = json.loads((DATA / "truth.json").read_text(encoding="utf-8"))
TRIALS = {t.file: t for t in maker.trials()}


def columns(text: bytes) -> np.ndarray:
    return np.genfromtxt(text.decode().splitlines(), delimiter=",", names=True)


def committed(trial: maker.Trial) -> np.ndarray:
    return columns(gzip.decompress((DATA / trial.file).read_bytes()))


def steepest(depth: float, spring: str) -> maker.Trial:
    return next(
        t
        for t in TRIALS.values()
        if (t.water_depth_m, t.spring, t.x0_target_m) == (depth, spring, maker.RELEASES_M[spring][-1])
    )


def test_the_index_names_every_trial_and_nothing_but_what_a_laboratory_knows():
    with (DATA / "campaign.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert {row["file"] for row in rows} == set(TRIALS) == {p.name for p in DATA.glob("*.csv.gz")}
    for row in rows:
        trial = TRIALS[row["file"]]
        assert (row["spring"], float(row["water_depth_m"])) == (trial.spring, trial.water_depth_m)
    assert set(rows[0]) == {"file", "spring", "water_depth_m", "x0_target_m"}


def test_a_remade_recording_is_the_committed_one(tmp_path):
    dry = next(t for t in TRIALS.values() if t.water_depth_m < 2.0)
    assert [t.file for t in maker.write(tmp_path, [dry])] == [dry.file]
    new, old = columns(gzip.decompress((tmp_path / dry.file).read_bytes())), committed(dry)
    assert new.dtype.names == old.dtype.names
    for sensor in maker.CHANNELS:
        # another machine's last bit may tip a reading over to the next step of the converter
        step = sensor.quantum + 10.0**-sensor.decimals
        assert np.max(np.abs(new[sensor.column] - old[sensor.column])) < 1.01 * step


@pytest.mark.parametrize(("depth", "spring"), [(2.24, "long"), (2.32, "short")])
def test_the_steepest_recordings_are_what_the_march_gives_within_their_sensors(depth, spring):
    trial = steepest(depth, spring)
    motion = maker.motion_of(trial, duration_s=1.6)
    old, n = committed(trial), motion.x.size
    gains = sensors.instrument_gains(np.random.default_rng([maker.SEED, 10_000]))
    for sensor, truth in zip(maker.CHANNELS[:2], (motion.x, motion.a), strict=True):
        error = old[sensor.column][:n] - gains[sensor.column] * truth
        assert np.max(np.abs(error)) < sensor.offset + 3.0 * sensor.drift + 5.0 * sensor.noise + sensor.quantum


@pytest.mark.parametrize("depth", maker.WET_DEPTHS_M)
def test_truth_holds_the_modes_and_masses_of_linear_theory(depth):
    level, cell = TRUTH["levels"][f"{depth:.2f}"], maker.cell_at(depth)
    theory = theory_mode(cell.width, cell.depth)
    first = level["modes"][0]
    assert first["frequency_rad_per_s"] == pytest.approx(theory.frequency, rel=1e-5)
    assert first["frequency_rad_per_s"] == pytest.approx(cell.linear_modes(1)[0].frequency, rel=0.002)
    mass = 1000.0 * maker.CELLS_LENGTH_M * cell.linear_modes(1)[0].participating_area
    assert first["participating_mass_kg"] == pytest.approx(mass, rel=0.01)
    assert level["added_mass_without_the_first_mode_kg"] + first["participating_mass_kg"] == pytest.approx(
        level["water_mass_kg"], rel=1e-5
    )


@pytest.mark.parametrize("depth", maker.WET_DEPTHS_M)
def test_truth_is_what_its_maker_says_today(depth):
    made = maker.level_truth(depth)
    kept = TRUTH["levels"][f"{depth:.2f}"]
    assert set(made) == set(kept)
    for name in set(made) - {"modes"}:
        assert kept[name] == pytest.approx(made[name], rel=1e-5), name  # six digits are kept


def test_a_duffing_mode_with_the_stated_cubic_stiffness_moves_as_third_order_waves_do():
    width, depth, a = 0.3344, 0.09, 0.008
    cubic, mode = maker.cubic_stiffness(width, depth), theory_mode(width, depth)
    sway = 2.0 * a / ((np.pi / width) ** 2 * mode.participating_area)
    motion = solve_ivp(
        lambda t, y: [y[1], -(mode.frequency**2) * y[0] - cubic * y[0] ** 3],
        (0.0, 2.5),
        [sway, 0.0],
        rtol=1e-10,
        atol=1e-13,
        events=lambda t, y: y[1],
    )
    frequency = np.pi * (motion.t_events[0].size - 2) / (motion.t_events[0][-1] - motion.t_events[0][1])
    expected = tadjbakhsh_keller(width, depth, a)
    assert frequency / mode.frequency - 1.0 == pytest.approx(expected, rel=0.02)  # both to third order in a


def test_one_level_hardens_with_amplitude_and_the_other_softens():
    change = {d: level["relative_frequency_change_at_a_tenth_of_the_width"] for d, level in TRUTH["levels"].items()}
    assert change["2.24"] > 0.0 > change["2.32"]


def test_every_level_has_gentle_and_steep_water():
    for depth in maker.WET_DEPTHS_M:
        slopes = [t["steepest_slope"] for t in TRUTH["trials"] if t["water_depth_m"] == depth]
        assert min(slopes) < 0.3 < 0.7 < max(slopes)


def test_the_campaign_stays_small():
    assert sum(p.stat().st_size for p in DATA.iterdir()) < 1_500_000


def test_without_a_folder_the_command_says_how_to_use_it(capsys):
    assert maker.main([]) == 2
    assert "usage: python -m experiments virtual_flume.nonlinear_campaign FOLDER" in capsys.readouterr().err


def test_the_maker_imports_nothing_of_undertow():
    for path in (ROOT / "experiments" / "virtual_flume").glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not [n for n in names if n.split(".")[0] == "undertow"], path.name


def test_the_published_checks_still_print_what_the_page_says():
    page = (ROOT / "docs" / "nonlinear_cell.md").read_text(encoding="utf-8")
    rows = list(nonlinear_checks.linear_rows())
    assert len(rows) == len(nonlinear_checks.DEPTHS_M)
    for row in rows:
        depth, frequency, *errors = (cell.strip() for cell in row.strip("|").split("|"))
        assert f"| {depth} | {frequency} |" in page
        assert max(abs(float(e)) for e in errors) < 1e-5
    difference = next(nonlinear_checks.mesh_rows(0.5)).strip("| ").split("|")[-1]
    assert float(difference.removesuffix("% ").removesuffix("%")) < 0.01
