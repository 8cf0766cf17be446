"""The index as a table: its own separator, its own decimal mark, and where it cannot know."""

from __future__ import annotations

import datetime
import zipfile
from pathlib import Path

import openpyxl
import pytest

from undertow.errors import ConfigError
from undertow.recording.conditions import condition, number, same_condition
from undertow.recording.index import read_index
from undertow.recording.recording import Condition

ROWS = "file,spring,depth_m,x0_m\na.csv,long,1.63,0.107\nb.csv,long,2.36,0.05\n"


def conditions(tmp_path: Path, text: str, separator: str = "auto", decimal: str = "auto") -> list[list[Condition]]:
    path = tmp_path / "campaign.csv"
    path.write_text(text)
    index = read_index(path, separator, decimal)
    return [[index.value(column, cell) for column, cell in row.items() if column != "file"] for row in index.rows()]


def german(text: str) -> str:
    return text.replace(",", ";").replace(".", ",").replace(",csv", ".csv")


EXPECTED: list[list[Condition]] = [["long", 1.63, 0.107], ["long", 2.36, 0.05]]


@pytest.mark.parametrize(
    ("text", "separator", "decimal"),
    [
        (ROWS, "auto", "auto"),
        (ROWS, ",", "."),
        (german(ROWS), "auto", "auto"),
        (german(ROWS), ";", ","),
        (german(ROWS).replace(";", "\t"), "auto", "auto"),
        (german(ROWS).replace(";", "\t"), "tab", ","),
        (german(ROWS).replace(";", "  "), "space", "auto"),
        ("file,spring,depth_m,x0_m\na.csv,long,\"1,63\",0.107\nb.csv,long,\"2,36\",0.05\n", "auto", "auto"),
        ("\n" + german(ROWS) + ";;;\n", "auto", "auto"),
    ],
)
def test_an_index_is_read_with_its_own_separator_and_decimal(
    tmp_path: Path, text: str, separator: str, decimal: str
) -> None:
    assert conditions(tmp_path, text, separator, decimal) == EXPECTED


def test_a_column_with_texts_among_its_commas_is_text_where_commas_part_cells(tmp_path: Path) -> None:
    said = 'file,depth_m,note\na.csv,"1,63","3,4"\nb.csv,dry,"5,6"\n'
    assert conditions(tmp_path, said) == [["1,63", 3.4], ["dry", 5.6]]
    assert conditions(tmp_path, said.replace(",", ";").replace('"1;63"', "1,63").replace('"3;4"', "3,4").replace(
        '"5;6"', "5,6")) == [[1.63, 3.4], ["dry", 5.6]]  # fmt: skip


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('file,k\na.csv,"109,592"\nb.csv,"402,036"\n', r"column 'k' has 109,592, where a comma .*index_decimal"),
        ("file;k;x0\na.csv;109,592;0.1\n", r"column 'k' has 109,592, where a comma may be a decimal mark or part"),
        ("file;x0\na.csv;1,5\nb.csv;2.5\n", r"column 'x0' has 1,5 and 2\.5, where a comma may be a decimal mark"),
        ("file,x,x\na.csv,1,2\n", r"campaign\.csv has 2 columns named 'x'; keep one"),
        ("file,depth_m\na.csv,1.63\nb.csv,2,36\n", r"line 3 has 3 cells but the header has 2; put a cell with a comma"),
    ],
)
def test_what_an_index_may_mean_in_two_ways_is_asked(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        conditions(tmp_path, text)


def test_thousands_are_not_asked_about_once_the_decimal_is_set_or_shown(tmp_path: Path) -> None:
    quoted = 'file,k\na.csv,"109,592"\n'
    assert conditions(tmp_path, quoted, decimal=",") == [[109.592]]
    assert conditions(tmp_path, quoted, decimal=".") == [["109,592"]]
    assert conditions(tmp_path, "file;k;x0\na.csv;109,592;0,1\n") == [[109.592, 0.1]]
    assert conditions(tmp_path, 'file,k,x0\na.csv,"109,592","0,1"\n') == [[109.592, 0.1]]


def test_an_index_that_is_not_there_is_said_with_the_nearest_file(tmp_path: Path) -> None:
    (tmp_path / "campaign.csv").write_text(ROWS)
    with pytest.raises(ConfigError, match=r"campagin\.csv is not there; .*; did you mean 'campaign\.csv'\?"):
        read_index(tmp_path / "campagin.csv")


@pytest.mark.parametrize("text", ["1_63", "inf", "nan", "1,234.5", "1.234,5", "0x10", "", "-", "e5", "1 63"])
def test_what_is_not_written_like_a_number_is_a_text(text: str) -> None:
    assert number(text) is None
    assert condition(f" {text} ") == text


@pytest.mark.parametrize("text", ["1.63", "1,63", " +1.630", "163e-2", "1,63e0"])
def test_a_number_may_be_written_with_a_point_or_a_comma(text: str) -> None:
    assert condition(text) == pytest.approx(1.63, rel=1e-12)
    assert same_condition(text, 1.63)


def test_numbers_are_equal_by_their_own_size() -> None:
    assert same_condition(2.3600004, "2,36")
    assert not same_condition(2.36001, "2,36")
    assert not same_condition(2.0e-7, 3.0e-7)
    assert same_condition(0.0, "0,0")
    assert same_condition(" long", "long")
    assert not same_condition(None, "None")


def test_an_index_whose_name_no_file_system_takes_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"recordings\.index .*x+ is not there; paths are relative"):
        read_index(tmp_path / ("x" * 3000))


def test_a_folder_is_no_index(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"recordings\.index .* is a folder; give the table that lists the trials"):
        read_index(tmp_path)


def workbook(path: Path, rows: list[list[object]], **more: list[list[object]]) -> Path:
    """An index as Excel saves it; ``more`` are further sheets."""
    book = openpyxl.Workbook()
    for row in rows:
        book.active.append(row)
    for name, others in more.items():
        sheet = book.create_sheet(name)
        for row in others:
            sheet.append(row)
    book.save(path)
    return path


def test_an_index_of_excel_is_read_as_the_same_table_of_text(tmp_path: Path) -> None:
    day = datetime.datetime(2026, 11, 24, 9, 30)
    rows: list[list[object]] = [
        ["file", "spring", "depth_m", "trial", "day", "note"],
        ["a.csv", "long", 1.63, 1, day, "lids, two\nof them"],
        [],
        ["b.csv", "long", 2.36, 2.0, day, None],
        ["c.csv", " long ", 0.1 + 0.2, 12, day, "#N/A"],
    ]
    index = read_index(workbook(tmp_path / "campaign.xlsx", rows, other=[["x"], [1]]))
    assert index.columns == ("file", "spring", "depth_m", "trial", "day", "note")
    when = "2026-11-24 09:30:00"
    assert [[index.value(key, text) for key, text in row.items()] for row in index.rows()] == [
        ["a.csv", "long", 1.63, 1.0, when, "lids, two of them"],
        ["b.csv", "long", 2.36, 2.0, when, ""],
        ["c.csv", "long", 0.3, 12.0, when, ""],
    ]


def test_an_index_of_excel_that_is_none_ends_in_a_sentence(tmp_path: Path) -> None:
    wide = workbook(tmp_path / "wide.xlsx", [["file", "x"], ["a.csv", 1, 2]])
    with pytest.raises(ConfigError, match=r"wide\.xlsx line 2 has 3 cells but the header has 2; name its column, or"):
        list(read_index(wide).rows())
    with pytest.raises(ConfigError, match=r"index_separator is ';', but wide\.xlsx is a workbook; leave it out"):
        read_index(wide, separator=";")
    damaged = workbook(tmp_path / "below.xlsx", [["file"], ["a.csv"], ["b.csv"]])
    with zipfile.ZipFile(damaged) as parts:
        kept = {part.filename: parts.read(part).replace(b'r="3"', b'r="900000000"') for part in parts.infolist()}
    with zipfile.ZipFile(damaged, "w") as parts:
        for name, data in kept.items():
            parts.writestr(name, data)
    with pytest.raises(ConfigError, match=r"below\.xlsx: a row lies below row 1048576, the last of any"):
        read_index(damaged)
    (tmp_path / "broken.xlsx").write_bytes(b"PK\x03\x04 and no more")
    with pytest.raises(ConfigError, match=r"recordings\.index: .*broken\.xlsx is no readable Excel workbook"):
        read_index(tmp_path / "broken.xlsx")
    (tmp_path / "old.xls").write_bytes(b"\xd0\xcf\x11\xe0")
    with pytest.raises(ConfigError, match=r"old\.xls is an old or foreign spreadsheet; save it as \.xlsx or CSV"):
        read_index(tmp_path / "old.xls")
    empty = workbook(tmp_path / "empty.xlsx", [])
    assert list(read_index(empty).rows()) == []


def test_numbers_typed_with_a_comma_into_a_workbook_are_read_or_asked_about(tmp_path: Path) -> None:
    texts = read_index(workbook(tmp_path / "texts.xlsx", [["file", "depth_m"], ["a.csv", "1,63"], ["b.csv", "2,36"]]))
    assert [texts.value("depth_m", row["depth_m"]) for row in texts.rows()] == [1.63, 2.36]
    mixed = workbook(tmp_path / "mixed.xlsx", [["file", "depth_m"], ["a.csv", "1,63"], ["b.csv", 2.36]])
    with pytest.raises(ConfigError, match=r"mixed\.xlsx: column 'depth_m' has 1,63 and 2\.36, where a comma may be"):
        read_index(mixed)
