"""`undertow inspect` on every file of the real recordings and the practice campaigns: an answer or one sentence."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.command_line import undertow

Capture = pytest.CaptureFixture[str]
SHARED = Path(__file__).resolve().parents[2] / ".." / "shared"

pytestmark = pytest.mark.skipif(not (SHARED / "recordings").is_dir(), reason="needs ../shared beside the repository")

READ = ("bicycle*.csv", "model_test_2*.csv", "molla*.csv", "resultingData.csv")
"""Files whose names and headers say enough to be looked at without any config."""


def _files(folder: str) -> list[Path]:
    return sorted(path for path in (SHARED / folder).rglob("*") if path.is_file())


@pytest.mark.parametrize("path", _files("recordings"), ids=lambda path: path.name)
def test_every_file_gives_an_answer_or_one_sentence(capsys: Capture, path: Path) -> None:
    said = undertow(capsys, "inspect", path)
    if any(path.match(pattern) for pattern in READ):
        assert said.code == 0
        assert "proposed config:" in said.out
        assert said.err == ""
    else:
        assert said.code == 1
        assert said.out == ""
        assert len(said.err.splitlines()) == 1
        assert said.err.count(str(path)) == 1
        assert re.search(r"; known: \.csv|set recordings", said.err), "the sentence names the key that helps"


@pytest.mark.parametrize(
    ("name", "hint"),
    [
        (
            "rotary_pendulum_free_swing/pendulum_free_swing_data_01.txt",
            r"5000 rows, 1 columns without names: 0 \(-135\.8 to .*\); set recordings \{skip_rows: 2, header: none\}",
        ),
        ("sloshing_tank_decay/xData.mat", r"it holds xData \(cell array 3 x 2\): .*recordings\.cells for a cell array"),
        ("kvlcc2_roll_decay/model_test_parameters.csv", r"no table of numbers begins in its first 4 lines"),
    ],
)
def test_an_odd_file_says_which_key_helps(capsys: Capture, name: str, hint: str) -> None:
    assert re.search(hint, undertow(capsys, "inspect", SHARED / "recordings" / name).err)


def test_missing_values_at_the_end_are_left_out_and_said(capsys: Capture) -> None:
    name = "molla_durissima_discopieno_14.91945_0.2016_1.csv"
    said = undertow(capsys, "inspect", SHARED / "recordings" / "spring_disc_air" / name)
    assert "11883 samples" in said.out  # of 11886
    assert "acceleration lacks 3 values in a gap, the longest of 0.03 s at 119.8 s: these samples are" in said.out


@pytest.mark.parametrize(
    "campaign", ["two", *(pytest.param(name, marks=pytest.mark.slow) for name in ("one", "three", "four"))]
)
def test_every_practice_trial_has_a_release_and_all_its_channels(capsys: Capture, campaign: str) -> None:
    files = [path for path in _files(f"practice/{campaign}") if path.name.endswith(".csv.gz")]
    said = undertow(capsys, "inspect", *files)
    assert said.code == 0
    assert said.out.count("released at") == len(files)
    assert said.out.count("spring_force: {columns: [loadcell1_N, loadcell2_N], unit: N}") == len(files)
