"""The committed recordings are what the command makes, and the folder stays small."""

from __future__ import annotations

import csv
import gzip
import io
import json
import struct
from pathlib import Path

import numpy as np
import pytest

from experiments.virtual_flume import answer, campaign, frequency, section, sensors

DATA = Path(__file__).resolve().parents[2] / "data" / "virtual_flume"
LARGEST_FOLDER_BYTES = 6_000_000


def table(text: str) -> tuple[list[str], np.ndarray]:
    rows = list(csv.reader(io.StringIO(text)))
    return rows[0], np.array(rows[1:], dtype=float)


@pytest.mark.parametrize("number", [3, 27])
def test_a_recording_made_again_is_the_committed_one_within_a_quantum(number):
    trial = campaign.trials()[number]
    again = campaign.recording(trial).decode()
    kept = gzip.decompress((DATA / trial.file).read_bytes()).decode()
    if again == kept:  # on the machine that made them: to the last printed digit
        return
    header, one = table(again)
    assert (header, one.shape) == (table(kept)[0], table(kept)[1].shape)
    for sensor, made, stored in zip(sensors.SENSORS, one[:, 1:].T, table(kept)[1][:, 1:].T, strict=True):
        printed = 10.0**-sensor.decimals  # two roundings to a printed digit on top of the converter's step
        assert np.max(np.abs(made - stored)) <= sensor.quantum + printed, sensor.column


def test_recordings_of_the_test_above_are_one_dry_and_one_of_the_short_spring_in_water():
    plan = campaign.trials()
    assert (plan[3].spring, plan[3].water_depth_m) == ("long", section.DRY_DEPTH_M)
    assert (plan[27].spring, plan[27].water_depth_m) == ("short", 2.29)


def test_index_and_files_are_the_plans_and_say_nothing_of_the_truth():
    with (DATA / "campaign.csv").open(newline="") as stream:
        rows = {row["file"]: row for row in csv.DictReader(stream)}
    plan = {t.file: t for t in campaign.trials()}
    assert set(rows) == set(plan) == {p.name for p in DATA.glob("*.csv.gz")}
    assert all(set(row) == {"file", "spring", "water_depth_m", "x0_target_m"} for row in rows.values())
    for name, row in rows.items():
        assert (row["spring"], float(row["water_depth_m"])) == (plan[name].spring, plan[name].water_depth_m)
    kept, made = json.loads((DATA / "setup.json").read_text()), json.loads(json.dumps(campaign.setup()))
    assert kept["channels"].keys() == made["channels"].keys()  # their descriptions are prose and may be reworded
    assert {k: v for k, v in kept.items() if k != "channels"} == {k: v for k, v in made.items() if k != "channels"}


def test_every_recording_is_fourteen_seconds_at_250_hz_with_a_hold_first():
    for trial in campaign.trials()[::13]:
        header, rows = table(gzip.decompress((DATA / trial.file).read_bytes()).decode())
        assert header == ["time_s", *[s.column for s in sensors.SENSORS]]
        assert rows.shape == (3500, 7)
        assert np.diff(rows[:, 0]) == pytest.approx(0.004, abs=1e-9)
        held = rows[rows[:, 0] < trial.release_s - 0.01, 1]
        assert 0.5 <= trial.release_s <= 1.0
        assert held == pytest.approx(trial.x0_m, abs=0.001)  # gain 0.3 % of at most 0.107 m, offset, noise


def test_the_folder_is_under_six_megabytes_and_its_archives_bear_no_date():
    assert sum(p.stat().st_size for p in DATA.iterdir()) < LARGEST_FOLDER_BYTES
    for path in DATA.glob("*.gz"):
        magic, _, flags, modified = struct.unpack("<HBBI", path.read_bytes()[:8])
        assert (magic, flags, modified) == (0x8B1F, 0, 0), path.name


def test_truth_made_again_for_a_level_is_the_committed_one():
    truth = json.loads((DATA / "truth.json").read_text())
    kept = truth["levels"]["2.29"]
    water = campaign.water_at(2.29)
    mode = frequency.modes(water)[0]
    assert mode.frequency == pytest.approx(kept["hidden_resonators"][0]["frequency"], rel=1e-6)
    assert mode.participating_mass == pytest.approx(kept["hidden_resonators"][0]["participating_mass"], rel=1e-5)
    for spring, nominal in answer.SPRINGS.items():
        said = kept["by_spring"][spring]
        w = said["body_frequency_rad_per_s"]
        added, damping = frequency.added_mass_and_damping(water, np.array([w]))
        assert added[0] == pytest.approx(said["added_mass_kg"], rel=1e-5)
        assert damping[0] == pytest.approx(said["radiation_damping_Ns_per_m"], rel=1e-4)
        assert w**2 * (answer.MASS_KG + added[0]) == pytest.approx(nominal.stiffness, rel=1e-6)
    assert truth["trials"].keys() == {t.file for t in campaign.trials()}


def test_a_dry_level_has_no_answer():
    with pytest.raises(ValueError, match=r"water depth 1.63 m is dry; there is no water to answer for"):
        answer.level_answer(section.DRY_DEPTH_M)
