"""Decimal marks that part thousands, columns that count rows, clocks coarser than samples, archives, mils: each is
refused with what to do, or read as what it is."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import undertow
from undertow.campaign.inspection import inspect_file
from undertow.campaign.starting.start import start
from undertow.errors import ConfigError, RecordingError
from undertow.recording.layout import FileFormat
from undertow.recording.propose import propose_mapping
from undertow.recording.propose_layout import propose_layout
from undertow.recording.readers import never_read, read_table
from undertow.recording.units import factor_to_si

TIME = np.arange(0.0, 8.0, 0.01)
MOTION_M = 0.05 * np.exp(-0.05 * TIME) * np.cos(10.0 * TIME)


def write(path: Path, head: str, row: str, time: list[str], x: list[str]) -> Path:
    """A table of texts with one header line."""
    path.write_text("\n".join([head, *(row.format(t, v) for t, v in zip(time, x, strict=True))]) + "\n", "utf-8")
    return path


@pytest.mark.parametrize(
    ("head", "row", "time", "x"),
    [
        ("time [s]\tx [um]", "{}\t{}", "0.00", "250,035"),
        ("Zeit [s];x [um]", "{};{}", "0,00", "250.035"),
        ("Zeit [s]\tx [um]", "{}\t{}", "0,00", "50.034"),
    ],
)
def test_marks_of_which_one_parts_thousands_are_refused_with_both(tmp_path, head, row, time, x):
    point = "." in time
    times = [f"{t:.2f}" if point else f"{t:.2f}".replace(".", ",") for t in TIME]
    file = write(tmp_path / "r1.txt", head, row, times, [x] * TIME.size)
    with pytest.raises(RecordingError, match=r"in line 200: one mark parts thousands; save the file without it"):
        propose_layout(file)


def test_a_point_beside_a_decimal_comma_is_no_number_whatever_the_config_says(tmp_path):
    values = ["999", *["50.034"] * (TIME.size - 1)]
    file = write(tmp_path / "r1.csv", "t;x", "{};{}", [f"{t:.2f}".replace(".", ",") for t in TIME], values)
    with pytest.raises(RecordingError, match=r"line 3: '50\.034' is not a number; the decimal mark is ',': if the po"):
        read_table(file, FileFormat(decimal=","))


@pytest.mark.parametrize("cell", ["00:58.010", "-32310.5.", "11:59:58:010"])
def test_a_cell_that_no_mark_makes_a_number_is_shown_with_its_line(tmp_path, cell):
    file = write(tmp_path / "r1.txt", "t\tx", "{}\t{}", [cell] * TIME.size, ["1.5"] * TIME.size)
    with pytest.raises(RecordingError, match=rf"'{cell}' in line 200 is no number: save such cells as plain numbers"):
        propose_layout(file)


@pytest.mark.parametrize(
    ("cell", "mark", "plain"),
    [("-32,310.5", "','", "-32310.5"), ("1.234,5", "'.'", "1234,5"), ("1'234.5", '"\'"', "1234.5"),
     ("12 345,6", "' '", "12345,6"), ("1.234.567", "'.'", "1234567")],
)  # fmt: skip
def test_a_number_with_parted_thousands_is_said_with_its_mark_and_as_it_should_be(tmp_path, cell, mark, plain):
    file = write(tmp_path / "r1.txt", "t;x", "{};{}", [f"{t:.2f}" for t in TIME], [cell] * TIME.size)
    said = rf"it parts thousands with {re.escape(mark)}; save the file without that mark, as {re.escape(plain)}$"
    with pytest.raises(RecordingError, match=rf"{re.escape(cell)}. in line 200 is read as no number: {said}"):
        propose_layout(file)
    with pytest.raises(RecordingError, match=rf"column 'x', line 2: .{re.escape(cell)}. is not a number; {said}"):
        read_table(file, FileFormat(separator=";"))


@pytest.mark.parametrize("decimal", [".", ","])
def test_thousands_are_no_decimals_where_whole_numbers_stand_beside_them(tmp_path, decimal):
    """Read as decimals, 40013 became 40.013 and 987 stayed, and nothing was said of it."""
    counts = np.round(1e6 * MOTION_M).astype(int)
    written = [f"{n:,}".replace(",", decimal) for n in counts]
    file = write(tmp_path / "r1.csv", "t [ms];x", "{};{}", [f"{1e3 * t:.0f}" for t in TIME], written)
    layout = propose_layout(file)
    assert layout.decimal == decimal
    with pytest.raises(RecordingError, match=rf"line 2: '50\{decimal}000' seems to be 50000 with parted tho"):
        read_table(file, layout)
    with pytest.raises(RecordingError, match=rf"line 3: '49\{decimal}725' seems to be 49725 with parted"):
        read_table(write(file, "t;x", "{};{}", ["1"] * TIME.size, ["987", *written[1:]]), layout)


@pytest.mark.parametrize("form", ["{:.3f}", "{:.7g}", "{:.3g}"])
def test_three_decimals_are_decimals_where_they_are_written_so(tmp_path, form):
    values = 500.0 + np.round(1e3 * MOTION_M, 3)
    values[7] = 501.0
    file = write(tmp_path / "r1.csv", "x,t", "{1},{0}", [f"{t:.2f}" for t in TIME], [form.format(v) for v in values])
    assert read_table(file, propose_layout(file))["x"].to_numpy() == pytest.approx(values, abs=0.6)


def test_a_comma_that_may_part_thousands_is_not_taken_for_a_decimal_comma_alone(tmp_path):
    times = [f"{1e3 * t:,.0f}" for t in TIME]
    file = write(tmp_path / "r1.csv", "t;x", "{};{}", times, [f"{v:.6f}" for v in MOTION_M])
    with pytest.raises(RecordingError, match=r"'1,000' is not a number; set decimal: ',', or save the file with"):
        read_table(file, FileFormat())


def test_quoted_decimal_commas_between_commas_are_read(tmp_path):
    texts = [f"{v:.5f}".replace(".", ",") for v in MOTION_M]
    file = write(tmp_path / "r1.csv", "t,x", '"{}","{}"', [f"{t:.2f}".replace(".", ",") for t in TIME], texts)
    found = read_table(file, propose_layout(file))
    assert found["x"].to_numpy() == pytest.approx(MOTION_M, abs=1e-5)
    assert found["t"].to_numpy() == pytest.approx(TIME)


def test_a_column_that_counts_rows_is_no_time():
    rows = pd.DataFrame({"Sample": np.arange(TIME.size), "x [mm]": 1e3 * MOTION_M})
    found = propose_mapping(rows)
    assert found.time is None
    assert "column 'Sample' counts rows and is no time; give channels.time: {rate_hz: ...}" in found.remarks
    timed = propose_mapping(rows.rename(columns={"Sample": "time"})).time
    assert timed is not None
    assert timed.column == "time"
    uneven = propose_mapping(rows.assign(Sample=0.5 * rows["Sample"])).time
    assert uneven is not None
    assert uneven.column == "Sample"


def test_a_clock_coarser_than_its_samples_is_said_as_that(tmp_path):
    file = tmp_path / "r1.csv"
    pd.DataFrame({"time [s]": np.floor(TIME), "x [mm]": 1e3 * MOTION_M}).to_csv(file, index=False)
    said = r"792 of 799 steps of time are 0 s: its clock is coarser than its samples; give rate_hz=\.\.\. in its"
    with pytest.raises(RecordingError, match=said):
        undertow.read(file)
    once = TIME.copy()
    once[100] = once[99]
    pd.DataFrame({"time [s]": once, "x [mm]": 1e3 * MOTION_M}).to_csv(file, index=False)
    with pytest.raises(RecordingError, match="remove duplicated or swapped rows"):
        undertow.read(file)


@pytest.mark.parametrize("name", ["all.zip", "all.7z", "a.tar"])
def test_a_folder_with_an_archive_alone_is_told_to_unpack_it(tmp_path, name):
    (tmp_path / name).write_bytes(b"PK")
    with pytest.raises(ConfigError, match=rf"{name}: is an archive, and no archive is opened; unpack it"):
        start(tmp_path)
    assert never_read(tmp_path / "r1.csv.gz") == ""


def test_a_mil_is_a_thousandth_of_an_inch():
    assert factor_to_si("mil", "displacement") == (pytest.approx(2.54e-5), "m")
    assert propose_mapping(pd.DataFrame({"t": TIME, "Disp (mil)": MOTION_M})).coordinate == "translation"


def test_an_inspected_driven_record_is_proposed_a_config_that_runs(tmp_path):
    rng = np.random.default_rng(0)
    force = np.convolve(rng.normal(size=TIME.size), np.hanning(30), "same")
    table = pd.DataFrame({"time [s]": TIME, "x [mm]": 1e3 * MOTION_M + 0.01 * rng.normal(size=TIME.size)})
    table.assign(**{"force [N]": force}).to_csv(tmp_path / "shaken.csv", index=False)
    told = inspect_file(tmp_path / "shaken.csv")
    assert "  group_by: []\n" in told
    assert "conditions:" not in told
