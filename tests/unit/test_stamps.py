"""Dates and times of day become seconds since the first row, whatever their order; what is none has its line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from undertow.errors import RecordingError
from undertow.recording.layout import FileFormat
from undertow.recording.readers import read_table
from undertow.recording.stamps import is_stamp, seconds_of_clock, seconds_of_texts


@pytest.mark.parametrize(
    "cells",
    [
        ["2026-12-31T23:59:59.900Z", "2026-12-31T23:59:59.950Z", "2027-01-01T00:00:00.050Z"],
        ["31.12.2026 23:59:59,900", "31.12.2026 23:59:59,950", "01.01.2027 00:00:00,050"],
        ["12/31/2026 11:59:59.900 PM", "12/31/2026 11:59:59.950 PM", "1/1/2027 12:00:00.050 AM"],
        ["20261231 23:59:59.9+01:00", "20261231 23:59:59.95+01:00", "20270101 00:00:00.05+01:00"],
        ["23:59:59.9", "23:59:59.95", "0:00:00.05"],
        ["12:59:59.9 am", "12:59:59.95 a.m.", "1:00:00.05 AM"],
    ],
)
def test_a_moment_is_the_same_however_it_is_written(cells: list[str]) -> None:
    assert seconds_of_texts(pd.Series(cells)) == pytest.approx([0.0, 0.05, 0.15], abs=1e-9)


def test_noon_is_twelve_and_an_empty_cell_no_moment() -> None:
    found = seconds_of_texts(pd.Series(["11:59:59 AM", None, "12:00:01 PM"]))
    assert found[[0, 2]].tolist() == [0.0, 2.0]
    assert np.isnan(found[1])


@pytest.mark.parametrize("cell", ["10:61:00", "10:00:61", "10:00", "24.11.2026", "2026-11/24 10:00:00"])
def test_what_no_clock_shows_is_no_stamp(cell: str) -> None:
    assert not is_stamp(cell)


@pytest.mark.parametrize("cell", ["{}", "1{}0", "10:00:00{}x", "T{}T"])
def test_a_cell_of_any_length_is_looked_at_once(cell: str) -> None:
    assert not is_stamp(cell.format(" " * 100_000))


def test_a_clock_that_steps_back_a_little_is_no_next_day() -> None:
    assert seconds_of_texts(pd.Series(["10:00:01", "10:00:00"])).tolist() == [0.0, -1.0]


@pytest.mark.parametrize(
    "wrong",
    ["10:00", "soon", "10:00:00.1.2", "2026-03-01T10:00:00.2+02:00", "2026-03/1 1:00:00"],
)
def test_a_cell_that_is_no_stamp_or_of_another_zone_is_named_by_its_line(tmp_path: Path, wrong: str) -> None:
    path = tmp_path / "r.csv"
    path.write_text("# a remark\nt,x\n2026-03-01T10:00:00.1+01:00,1\n" + wrong + ",2\n")
    with pytest.raises(RecordingError, match=r"r\.csv: column 't', line 4: .* is no time stamp like the first, '2026"):
        read_table(path, FileFormat(skip_rows=1))


def test_the_first_stamp_is_shown_also_where_the_first_cell_is_empty(tmp_path: Path) -> None:
    path = tmp_path / "r.csv"
    path.write_text("t,x\n,1\n10:00:00.1,1\nsoon,2\n")
    with pytest.raises(RecordingError, match=r"line 4: 'soon' is no time stamp like the first, '10:00:00.1'; repair"):
        read_table(path, FileFormat())


def test_a_header_that_is_a_row_of_stamps_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "r.csv"
    path.write_text("10:00:00.1,1\n10:00:00.2,2\n10:00:00.3,3\n")
    with pytest.raises(RecordingError, match="the header line holds numbers"):
        read_table(path, FileFormat())
    assert read_table(path, FileFormat(header=False))[0].to_list() == pytest.approx([0.0, 0.1, 0.2])


def test_dates_and_durations_of_pandas_are_seconds_and_numbers_are_left_alone() -> None:
    dates = pd.Series([pd.NaT, pd.Timestamp("2026-03-01"), pd.Timestamp("2026-03-01 00:00:00.25")])
    assert seconds_of_clock(dates)[1:].tolist() == [0.0, 0.25]
    assert seconds_of_clock(pd.to_timedelta([5.0, 5.5], unit="s")).tolist() == [0.0, 0.5]
    assert seconds_of_clock(pd.Series([5.0, 5.5])) is None
    with pytest.raises(RecordingError, match="column 't' holds dates or durations, and none of them is there"):
        seconds_of_clock(pd.Series([pd.NaT, pd.NaT], name="t"))
