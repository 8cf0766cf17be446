"""A look at one file: what it finds of a known motion, and what it says where something stands in the way."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.io import savemat

from tests.small_campaign import HOLD_S, NOISE_M, recorded, write_table
from undertow.campaign.config import load
from undertow.campaign.inspection import inspect, inspect_file
from undertow.errors import RecordingError
from undertow.recording.catalogue import TimeWindow, read_trial
from undertow.recording.gather import gather

X0_M = 0.04


def test_a_released_motion_is_found_with_its_noise_and_release(tmp_path: Path) -> None:
    write_table(tmp_path / "r.csv", recorded(X0_M, 0), "time_s,disp_m,accel_mps2")
    seen = inspect(tmp_path / "r.csv")
    assert seen.motion is not None
    # the release falls on a sample; its stated error is under a tenth of the sampling step
    assert abs(seen.motion.window.release_s - HOLD_S) < 0.01
    assert abs(seen.motion.amplitude - X0_M) < 5.0 * NOISE_M
    assert seen.summary.channels["displacement"].noise == pytest.approx(NOISE_M, rel=0.3)  # 300 samples move slowly
    assert seen.remarks == ()


def test_a_file_that_does_not_move_is_shown_with_the_reason(tmp_path: Path) -> None:
    table = recorded(X0_M, 0)
    table[:, 1:] = np.random.default_rng(1).standard_normal((len(table), 2))
    write_table(tmp_path / "r.csv", table)
    seen = inspect(tmp_path / "r.csv")
    assert seen.motion is None
    assert "no motion: trial r.csv: no release found" in inspect_file(tmp_path / "r.csv")


@pytest.mark.parametrize(
    ("lost", "said"),
    [
        (slice(500, 550), "50 samples without a displacement at the ends left out"),
        (slice(0, 20), "20 samples without a displacement at the ends left out"),
        (slice(400, 410), "displacement lacks 10 values in a gap, the longest of 0.1 s at 4 s"),
        (slice(100, 110), "displacement lacks 10 values in a gap, the longest of 0.1 s at 1 s"),
    ],
)
def test_missing_values_are_left_out_and_the_release_stays(tmp_path: Path, lost: slice, said: str) -> None:
    table = recorded(X0_M, 0)
    table[lost, 1] = np.nan
    write_table(tmp_path / "r.csv", table)
    seen = inspect(tmp_path / "r.csv")
    assert seen.remarks[0].startswith(said)
    assert seen.motion is not None
    assert abs(seen.motion.window.release_s - HOLD_S) < 0.01
    assert f"  note: {said}" in inspect_file(tmp_path / "r.csv")


def test_a_column_without_any_value_is_not_mapped(tmp_path: Path) -> None:
    table = recorded(X0_M, 0)
    table[:, 2] = np.nan
    write_table(tmp_path / "r.csv", table)
    seen = inspect(tmp_path / "r.csv")
    assert list(seen.proposal.channels) == ["displacement"]
    assert "column 'a' has no values" in seen.proposal.remarks


def test_a_file_without_names_says_its_columns_and_the_keys_that_help(tmp_path: Path) -> None:
    write_table(tmp_path / "r.csv", recorded(X0_M, 0), "of 2026\nby hand")
    sentence = (
        r"550 rows, 3 columns without names: 0 \(0 to 5\.49\), 1 \(-0\.03\d+ to 0\.04\d*\), 2 .*; set recordings "
        r"\{skip_rows: 2, header: none\} and write recordings\.channels by number from 0$"
    )
    with pytest.raises(RecordingError, match=sentence):
        inspect(tmp_path / "r.csv")


def test_names_that_say_nothing_are_shown(tmp_path: Path) -> None:
    write_table(tmp_path / "r.csv", recorded(X0_M, 0)[:, 1:], "blue,green")
    with pytest.raises(RecordingError, match=r"2 columns: blue .*, green .* by hand; no column looks like time: give"):
        inspect(tmp_path / "r.csv")


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ({"M": np.ones((4, 3))}, r"it holds M \(array 4 x 3\): set recordings\.variable for a matrix"),
        ({"rig": {"u": np.arange(4.0)}}, r"it holds rig \(structure with u\)"),
        ({"note": "text"}, r"it holds note \(str\)"),
    ],
)
def test_a_matlab_file_says_what_it_holds(tmp_path: Path, content: dict[str, object], sentence: str) -> None:
    savemat(tmp_path / "m.mat", content)
    with pytest.raises(RecordingError, match=sentence):
        inspect(tmp_path / "m.mat")


def test_named_vectors_of_a_matlab_file_are_looked_at(tmp_path: Path) -> None:
    time, x, a = recorded(X0_M, 0).T
    savemat(tmp_path / "m.mat", {"time": time, "disp": x, "acc": a, "comment": "by hand"})
    assert inspect(tmp_path / "m.mat").motion is not None


NAMES = ("plain.csv", 'name with: "quotes" #1.csv', "'single'.csv", "1e3.csv", "no.csv", "r[1]*.csv")


@pytest.mark.parametrize("name", NAMES)
def test_what_is_proposed_is_a_config_whatever_the_files_name(tmp_path: Path, name: str) -> None:
    header = '"Zeit [s]","Weg: Pot ""A"" [mm]",null'
    table = recorded(X0_M, 0)
    table[:, 1] *= 1e3
    table[120, 1] = np.nan
    write_table(tmp_path / name, table, header)
    proposed = inspect_file(tmp_path / name).partition("proposed config:\n")[2]
    (tmp_path / "c.yaml").write_text(proposed)
    config = load(tmp_path / "c.yaml")
    catalogue = config.catalogue()
    (entry,) = gather(catalogue)
    assert read_trial(entry, catalogue).time.size == 549
    assert config.recordings.channels.displacement is not None
    assert config.recordings.channels.displacement.column == 'Weg: Pot "A" [mm]'
    assert entry.window == TimeWindow()
