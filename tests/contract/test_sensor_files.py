"""`undertow init` on folders where each sensor of a trial has a file of its own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.command_line import undertow
from tests.small_campaign import recorded, write_table
from undertow.campaign.config import load
from undertow.campaign.config.matching import planned
from undertow.campaign.run.checking import Checker
from undertow.campaign.starting import start
from undertow.recording.propose_file import propose_file

Capture = pytest.CaptureFixture[str]
PER_SENSOR = "files of one sensor each are joined to the trials that they are named like"
NAMES = {
    "a word for another": ("t{n:02d}_disp", "t{n:02d}_acc", "t{trial}_acc.csv", "t*_acc.csv"),
    "a word first": ("disp_{spring}_{n}", "acc_{spring}_{n}", "acc_{spring}_{repetition}.csv", "acc_*_*.csv"),
    "a word more": ("t{n:02d}", "t{n:02d}_acc", "{stem}_acc.csv", "*_acc.csv"),
}


def write_sensors(folder: Path, trial: str, sensor: str, count: int = 4) -> None:
    """Trials of a displacement and an acceleration, each in a file of its own."""
    folder.mkdir(exist_ok=True)
    for n in range(1, count + 1):
        table, said = recorded(0.03 + 0.005 * n, n), {"n": n, "spring": ("short", "long")[n % 2]}
        for name, columns, header in ((trial, [0, 1], "t [s],x [m]"), (sensor, [0, 2], "t [s],a [m/s^2]")):
            path = folder / f"{name.format(**said)}.csv"
            path.parent.mkdir(exist_ok=True)
            write_table(path, table[:, columns], header)


@pytest.mark.parametrize("names", NAMES)
def test_files_of_one_sensor_each_are_channels_of_the_trial_they_are_named_like(tmp_path: Path, names: str) -> None:
    """They had been left out, as files without a displacement."""
    trial, sensor, file, pattern = NAMES[names]
    write_sensors(tmp_path / "c", trial, sensor)
    done = start(tmp_path / "c")
    assert (done.trials, done.left_out) == (4, ())
    assert f"{pattern}: {PER_SENSOR} (file, in recordings.channels)" in done.doubts
    config = load(done.path)
    assert config.recordings.channels.acceleration is not None
    assert config.recordings.channels.acceleration.file == file
    assert config.recordings.exclude == (pattern,)
    for entry in planned(config).entries:
        checked = Checker(config, config.catalogue())(entry)
        assert checked.motion is not None
        assert set(checked.motion.recording.channels) == {"displacement", "acceleration"}
        assert checked.found == ()


def test_a_velocity_in_a_file_of_its_own_is_no_trial_of_its_own(tmp_path: Path) -> None:
    """Alone it says where a body is: each trial had been two."""
    write_sensors(tmp_path / "c", "run_{n}_pos", "run_{n}_vel")
    for n in range(1, 5):
        table = recorded(0.03 + 0.005 * n, n)
        speed = np.gradient(table[:, 1], table[:, 0])
        write_table(tmp_path / "c" / f"run_{n}_vel.csv", np.column_stack([table[:, 0], speed]), "t [s],v [m/s]")
    done = start(tmp_path / "c")
    assert done.trials == 4
    velocity = load(done.path).recordings.channels.velocity
    assert velocity is not None
    assert velocity.file == "run_{trial}_vel.csv"


def test_another_clock_of_a_sensor_stands_beside_its_file(tmp_path: Path) -> None:
    write_sensors(tmp_path / "c", "t{n}", "t{n}_acc")
    for path in (tmp_path / "c").glob("*_acc.csv"):
        path.write_text(path.read_text().replace("t [s]", "clock_s"))
    channels = load(start(tmp_path / "c").path).recordings.channels
    assert channels.acceleration is not None
    assert channels.acceleration.time is not None
    assert channels.acceleration.time.column == "clock_s"


def test_a_sensor_s_file_without_names_of_columns_is_what_its_name_says(tmp_path: Path) -> None:
    """Two columns without names: every acceleration had been a trial's displacement."""
    for n in range(3):
        table = recorded(0.04, n)
        np.savetxt(tmp_path / f"t{n}_disp.txt", table[:, :2], fmt="%.7g")
        np.savetxt(tmp_path / f"t{n}_acc.txt", table[:, [0, 2]], fmt="%.7g")
    assert dict(propose_file(tmp_path / "t0_acc.txt").proposal.channels)["acceleration"].unit == "m/s^2"
    done = start(tmp_path)
    assert done.trials == 3
    assert any("1 as acceleration in m/s^2; correct both" in doubt for doubt in done.doubts)
    acceleration = load(done.path).recordings.channels.acceleration
    assert acceleration is not None
    assert acceleration.file == "t{trial}_acc.txt"


@pytest.mark.parametrize(
    ("names", "said"),
    [
        (("disp/t{n}", "acc/t{n}"), "acc/t1.csv and 3 more files, beside disp/t1.csv, hold acceleration alone: copy "
         "them beside their trials' files, as disp/t1_acc.csv, and take the config away"),
        (("t{n}_disp", "t{n}_acc"), "t1_acc.csv and 3 more files, beside t1_disp.csv, hold acceleration alone: their "
         "lines are laid out otherwise than their trials'; save all of them in one way"),
    ],
)  # fmt: skip
def test_what_no_key_joins_is_said_with_what_to_do(
    capsys: Capture, tmp_path: Path, names: tuple[str, str], said: str
) -> None:
    write_sensors(tmp_path / "c", *names)
    if "/" not in names[0]:
        for path in (tmp_path / "c").glob("*_acc.csv"):
            path.write_text("logger 7\n" + path.read_text())
    told = undertow(capsys, "init", tmp_path / "c")
    assert told.code == 0
    assert f"  guessed: {said}" in told.out
    assert "4 files left out" in told.out
