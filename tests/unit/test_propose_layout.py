"""Where a text file's table begins: found from its lines, so that what is proposed reads it."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
import pytest

from undertow.errors import RecordingError
from undertow.recording.layout import FileFormat
from undertow.recording.propose import is_unit, propose_mapping
from undertow.recording.propose_file import propose_file
from undertow.recording.propose_layout import propose_layout
from undertow.recording.readers import read_table

ROWS = "0.0,1.5\n0.1,1.4\n0.2,1.2\n0.3,0.9\n"


@pytest.mark.parametrize(
    ("text", "layout"),
    [
        ("t,x\n" + ROWS, FileFormat()),
        ("\n# made by logger 7\n\nt,x\n" + ROWS, FileFormat(skip_rows=3)),
        ("t,x\ns,mm\n" + ROWS, FileFormat(unit_row=True)),
        ("Logger, of 1998\nt,x\n[s],[mm]\n" + ROWS, FileFormat(skip_rows=1, unit_row=True)),
        ("station,flume\nt,x\n" + ROWS, FileFormat(skip_rows=1)),
        (ROWS, FileFormat(header=False)),
        ("start,rate,len\n90,1000,5\n-1.5\n-1.4\n-1.3\n-1.2\n", FileFormat(header=False, skip_rows=2)),
        ("made,by\nus,all\nfrom,to\n90,1000\ngain,5\n" + ROWS, FileFormat(header=False, skip_rows=5)),
        ("t;x\n" + ROWS.replace(",", ";").replace(".", ","), FileFormat(decimal=",")),
        ("t\tx\n" + ROWS.replace(",", "\t"), FileFormat()),
        ("t x\n" + ROWS.replace(",", "   "), FileFormat()),
        ("t x\n" + ROWS.replace(",", " ").replace(".", ","), FileFormat(decimal=",")),
        ("t,x\n" + ROWS + "0.4,\n0.5,0.2\n0.6,0.1\n0.", FileFormat()),
    ],
)
def test_a_layout_is_found_and_reads_the_table(tmp_path: Path, text: str, layout: FileFormat) -> None:
    path = tmp_path / "a.csv"
    path.write_text(text)
    found = propose_layout(path)
    assert found == layout
    table = read_table(path, found)
    assert table.iloc[-4:, -1].dropna().size >= 2
    assert len(table) >= 4


@pytest.mark.parametrize("bad", ["---", "OVERLOAD"])
@pytest.mark.parametrize(("above", "broken", "below"), [(12, 3, 12), (12, 250, 12), (4, 1, 40)])
def test_cells_that_are_no_numbers_do_not_end_a_table_and_are_named(
    tmp_path: Path, bad: str, above: int, broken: int, below: int
) -> None:
    """The names of the columns were lost, and with them the beginning of the recording."""
    cells = ["0.5"] * above + [bad] * broken + ["0.4"] * below
    path = tmp_path / "a.csv"
    path.write_text("\n".join(["made by logger 7", "t [s],x [mm]", *(f"{at / 50},{x}" for at, x in enumerate(cells))]))
    found = propose_layout(path)
    assert found == FileFormat(skip_rows=1)
    with pytest.raises(RecordingError, match=rf"column 'x \[mm\]', line {above + 3}: '{bad}' is not a number"):
        read_table(path, found)


@pytest.mark.parametrize("text", ["one\ntwo\n", "a,b\n1,2\n", "The licence of 1991\nsays much\nand more\n1\n"])
def test_a_text_without_a_table_is_said_to_be_none(tmp_path: Path, text: str) -> None:
    path = tmp_path / "a.txt"
    path.write_text(text)
    with pytest.raises(RecordingError, match=r"a\.txt: no table of numbers begins in its first \d lines; is it a reco"):
        propose_layout(path)


def test_units_are_told_from_names() -> None:
    assert all(is_unit(text) for text in ("s", "[mm]", "kN", "m/s^2", "deg"))
    assert not any(is_unit(text) for text in ("pot1", "time", "load cell"))


@pytest.mark.parametrize("stamp", ["2026-11-24 09:30:00.{:03d}", "09:30:00.{:03d}", "24.11.2026 9:30:00.{:03d}"])
def test_a_table_with_time_stamps_is_found_with_its_header(tmp_path: Path, stamp: str) -> None:
    path = tmp_path / "stamps.csv"
    path.write_text("Time,disp [mm]\n" + "".join(f"{stamp.format(10 * at)},{0.1 * at:.3f}\n" for at in range(9)))
    layout = propose_layout(path)
    assert layout == FileFormat()
    assert read_table(path, layout)["Time"].to_list() == pytest.approx([0.01 * at for at in range(9)])


@pytest.mark.parametrize(
    ("header", "row"),
    [
        ("Date,Time,disp [mm]", "2026-11-24,09:30:{0:06.3f},{1:.3f}"),
        ("Time,disp [mm],status", "{0:.3f},{1:.3f},OK"),
        ("nr;status;Time;disp [mm]", "{2};gut;{0:.3f};{1:.3f}"),
        ("date Time disp", "2026-11-24 9:30:{0:06.3f} {1:.3f}"),
    ],
)
@pytest.mark.parametrize("comma", [False, True])
def test_texts_beside_numbers_are_left_out_and_hide_no_table(
    tmp_path: Path, header: str, row: str, comma: bool
) -> None:
    path = tmp_path / "r.csv"
    lines = [row.format(0.01 * at, 0.1 * at, at) for at in range(30)]
    text = "\n".join(["a remark", header, *lines]) + "\n"
    if comma:
        text = text.replace(",", "\t").replace(".", ",")
    path.write_text(text)
    table = read_table(path, propose_layout(path))
    assert table["Time"].to_list() == pytest.approx([0.01 * at for at in range(30)])
    assert table.iloc[:, -1].to_list() == pytest.approx([0.1 * at for at in range(30)])
    assert not {"status", "Date", "date"} & set(table.columns)


def test_texts_beside_numbers_of_a_sheet_are_left_out(tmp_path: Path) -> None:
    path = tmp_path / "r.xlsx"
    rows = {"Time": [0.01 * at for at in range(9)], "status": ["OK"] * 9, "disp [mm]": [0.1 * at for at in range(9)]}
    pd.DataFrame(rows).to_excel(path, index=False)
    assert list(read_table(path, propose_layout(path)).columns) == ["Time", "disp [mm]"]


def test_texts_of_another_decimal_mark_are_numbers_of_a_sheet(tmp_path: Path) -> None:
    path = tmp_path / "r.xlsx"
    pd.DataFrame({"t": [0.0, 0.1, 0.2], "x": ["1,5", "1,4", "1,3"]}).to_excel(path, index=False)
    with pytest.raises(RecordingError, match="column 'x', row 2: '1,5' is not a number"):
        read_table(path, FileFormat())


def test_one_column_of_numbers_among_texts_is_no_table(tmp_path: Path) -> None:
    path = tmp_path / "r.csv"
    path.write_text("Time,status\n" + "".join(f"{0.01 * at:.2f},OK\n" for at in range(9)))
    with pytest.raises(RecordingError, match="no table of numbers begins in its first 10 lines"):
        propose_layout(path)


def test_a_date_without_a_time_is_named_with_the_next_step(tmp_path: Path) -> None:
    path = tmp_path / "stamps.csv"
    path.write_text("Date,disp [mm]\n" + "".join(f"2026-11-24,{0.1 * at:.3f}\n" for at in range(9)))
    with pytest.raises(RecordingError, match=r"'2026-11-24' in line 10 is a date without a time of day in its column"):
        propose_layout(path)


def test_a_name_longer_than_any_field_ends_in_a_sentence(tmp_path: Path) -> None:
    path = tmp_path / "long.csv"
    path.write_text("t,x," + "( " * 200_000 + "\n" + "0.1,2,3\n" * 9)
    with pytest.raises(RecordingError, match=r"is no row of a table \(field larger than field limit"):
        propose_file(path)


def test_a_clock_without_a_unit_that_may_be_milliseconds_is_remarked(tmp_path: Path) -> None:
    path = tmp_path / "r.csv"
    path.write_text("t,x [mm]\n" + "".join(f"{20 * at},{0.1 * at:.2f}\n" for at in range(9)))
    remarks = propose_file(path).proposal.remarks
    assert "time: column 't' says no unit; s is assumed, a sample every 20 s: is it ms?" in remarks
    path.write_text(path.read_text().replace("t,x", "t [s],x"))
    assert not any("is it ms" in remark for remark in propose_file(path).proposal.remarks)


@pytest.mark.parametrize(("second", "taken"), [(1.05, "acc1 [m/s^2]"), (0.95, "acc1 [m/s^2]"), (1.3, "acc2 [m/s^2]")])
def test_of_two_columns_that_move_as_far_it_is_the_first_in_every_file(second: float, taken: str) -> None:
    """Which of two accelerometers moves further is the noise's: files of one campaign would have been mapped apart."""
    t = [0.01 * i for i in range(200)]
    swing = [(i % 20 - 10) / 10.0 for i in range(200)]
    table = pd.DataFrame({
        "t [s]": t, "x [m]": [0.1 * one for one in swing], "acc1 [m/s^2]": swing,
        "acc2 [m/s^2]": [second * one for one in swing],
    })  # fmt: skip
    assert propose_mapping(table).channels["acceleration"].columns == (taken,)
