"""What `undertow inspect` prints as a config runs as printed, saved beside the file; or nothing is proposed."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from tests.command_line import Said, undertow
from tests.decays import Decay, recorded, times
from undertow.recording.recording import Recording

Capture = pytest.CaptureFixture[str]

DECAY = Decay(1.6, 60.0, 0.04, 0.02, 0.004, noise=2e-3, held=0.8, periods=12.0, seed=4)
DONE, SOME_FAILED = 0, 3


def write(path: Path, header: str, columns: list[np.ndarray], separator: str = ",", decimal: str = ".") -> Path:
    """A table as a logger writes it."""
    rows = (separator.join(f"{value:.7g}".replace(".", decimal) for value in row) for row in zip(*columns, strict=True))
    path.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    return path


def plain(folder: Path) -> Path:
    r = recorded(DECAY)
    return write(folder / "r1.csv", "Time [s],Disp [m],Acc [m/s^2]", [r.time, *r.channels.values()])


def semicolons(folder: Path) -> Path:
    r = recorded(DECAY, ("displacement",), times(displacement=1e3))
    return write(folder / "Versuch 7.csv", "Zeit;Weg\n[s];[mm]", [r.time, r.channels["displacement"]], ";", ",")


def degrees(folder: Path) -> Path:
    r = recorded(DECAY, ("displacement",), times(displacement=10.0 * 180.0 / np.pi))
    return write(folder / "roll_01.txt", "time\troll_deg", [r.time, r.channels["displacement"]], "\t")


def gyro(folder: Path) -> Path:
    r = recorded(DECAY, ("velocity",))
    return write(folder / "gyro.csv", "time_s,gyro_rad/s", [r.time, r.channels["velocity"]])


def vibrometer(folder: Path) -> Path:
    r = recorded(DECAY, ("velocity",))
    return write(folder / "fork.csv", "time [s],vel [mm/s]", [r.time, 1e3 * r.channels["velocity"]])


def by_hand(folder: Path) -> Path:
    """Held by a hand that wobbles by a third of the release."""
    r = recorded(DECAY, ("displacement",))
    hold = r.time < DECAY.held / DECAY.frequency_hz
    wobble = 0.3 * DECAY.size_m * np.sin(2.0 * np.pi * r.time / 1.1)
    x = r.channels["displacement"] - np.where(hold, np.abs(wobble), 0.0)
    return write(folder / "hand.csv", "t [s],x [m]", [r.time, x])


LAYOUTS = (plain, semicolons, degrees, gyro, vibrometer, by_hand)


def pasted(capsys: Capture, path: Path) -> tuple[Path, Said]:
    """The config that inspect prints of a file, saved beside it."""
    said = undertow(capsys, "inspect", path)
    assert said.code == DONE
    config = path.parent / "pasted.yaml"
    config.write_text(said.out.partition("proposed config:\n")[2], encoding="utf-8")
    return config, said


@pytest.mark.parametrize("layout", LAYOUTS)
def test_what_is_proposed_runs_as_printed(capsys: Capture, tmp_path: Path, layout) -> None:
    config, said = pasted(capsys, layout(tmp_path))
    assert "  conditions: {" in said.out
    ran = undertow(capsys, "run", config, "--out", tmp_path / "run", "--jobs", 1)
    assert ran.code in (DONE, SOME_FAILED), ran.err
    assert (tmp_path / "run" / "verdict.json").exists()
    assert "failed:" not in ran.err


def test_a_gyro_that_stood_still_before_the_release_is_cut_there(capsys: Capture, tmp_path: Path) -> None:
    config, said = pasted(capsys, gyro(tmp_path))
    start = re.search(r"start_s: ([\d.]+)", config.read_text())
    assert start is not None
    assert float(start[1]) == pytest.approx(DECAY.held / DECAY.frequency_hz, abs=0.03)
    assert "doubt: it stays at rest for" in said.out


def contradicting(folder: Path) -> Path:
    r: Recording = recorded(DECAY, mistake=times(acceleration=1.0 / 9.80665))
    return write(folder / "r1.csv", "Time [s],Disp [m],Acc [m/s^2]", [r.time, *r.channels.values()])


def driven(folder: Path) -> Path:
    time = np.arange(800) / 50.0
    x = np.sin(2.0 * np.pi * time) + 1e-3 * np.random.default_rng(1).standard_normal(time.size)
    return write(folder / "r1.csv", "Time [s],Disp [m]", [time, x])


@pytest.mark.parametrize(
    ("made", "doubt", "reason"),
    [
        (contradicting, "doubt: acceleration is 0.102 times the second derivative of the displacement: acceleration "
         "seems to be in g, not m/s^2", "no config is proposed: a run would stop at what contradicts above"),
        (driven, "", "no config is proposed: trial r1: its amplitude declines by"),
    ],
)  # fmt: skip
def test_nothing_is_proposed_where_a_run_would_stop(capsys: Capture, tmp_path: Path, made, doubt, reason) -> None:
    said = undertow(capsys, "inspect", made(tmp_path))
    assert said.code == DONE
    assert doubt in said.out
    assert reason in said.out
    assert "proposed config:" not in said.out
