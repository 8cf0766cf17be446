"""Anything as a recording, an index, a config or a unit: it is read, or refused with a sentence, and nothing else.

``UNDERTOW_EXAMPLES=10000`` runs as many of each; the default is for every change.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import openpyxl
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from tests.lab_files import WRITERS
from tests.small_campaign import CONFIG, recorded
from undertow.campaign.config import load
from undertow.errors import UndertowError
from undertow.recording.index import read_index
from undertow.recording.layout import FileFormat
from undertow.recording.propose_file import propose_file
from undertow.recording.readers import read_table
from undertow.recording.units import factor_to_si

EXAMPLES = int(os.environ.get("UNDERTOW_EXAMPLES", "60"))
usual = settings(
    max_examples=EXAMPLES, deadline=None, derandomize=EXAMPLES < 1000,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)  # fmt: skip

CELLS = st.sampled_from(
    ["0", "1.5", "-2e-3", "1,5", "nan", "", " ", "x", "[mm]", "t", '"', "'", "1e999", "9" * 400, "\ufeff", "#", "\0"]
)
MARKS = st.sampled_from([",", ";", "\t", " ", "|", "\n", "\r\n", "\r"])
TABLES = st.lists(st.tuples(CELLS, MARKS).map("".join), max_size=60).map("".join)
UNITS = st.text(st.sampled_from("mskNgdeg°%µ²-/*^(). '\"[]0123456789#:=\\{}"), max_size=12)
KEYS = CONFIG.replace("{", " { ").replace("}", " } ").split(" ")
YAMLS = st.lists(st.sampled_from([*KEYS, "\n", "\n  ", "- ", "null", "1e400", "[", "]", "0x9", "~", "?", ": "]),
                 max_size=40).map(" ".join)  # fmt: skip


def in_a_sentence(work: Callable[[], object]) -> None:
    """Work that ends, or is refused in one line with something to do."""
    try:
        work()
    except UndertowError as error:
        said = str(error)
        assert said
        assert len(said) < 4000, said


@usual
@example(text="9" * 400 + ",", header=False, decimal=".", skip=0)
@example(text='0\n0\n"\n",0,', header=False, decimal=".", skip=2)
@given(text=TABLES, header=st.booleans(), decimal=st.sampled_from([".", ","]), skip=st.integers(0, 3))
def test_any_text_is_a_recording_or_refused(tmp_path: Path, text: str, header: bool, decimal: str, skip: int) -> None:
    path = tmp_path / "r.csv"
    path.write_text(text, encoding="utf-8", newline="")
    in_a_sentence(lambda: read_table(path, FileFormat(header=header, decimal=decimal, skip_rows=skip)))
    in_a_sentence(lambda: propose_file(path))


@usual
@given(text=TABLES, separator=st.sampled_from(["auto", ",", ";", " "]), decimal=st.sampled_from(["auto", ".", ","]))
def test_any_text_is_an_index_or_refused(tmp_path: Path, text: str, separator: str, decimal: str) -> None:
    path = tmp_path / "index.csv"
    path.write_text(text, encoding="utf-8", newline="")
    in_a_sentence(lambda: [*read_index(path, separator, decimal).rows()])


@settings(usual, max_examples=max(EXAMPLES // 10, 6))
@given(rows=st.lists(st.lists(CELLS.filter(lambda cell: cell != "\0"), max_size=6), max_size=8))
def test_any_sheet_is_an_index_or_refused(tmp_path: Path, rows: list[list[str]]) -> None:
    book = openpyxl.Workbook()
    for row in rows:
        book.active.append([float(cell) if cell in ("1.5", "-2e-3") else cell for cell in row])
    book.save(tmp_path / "index.xlsx")
    in_a_sentence(lambda: [*read_index(tmp_path / "index.xlsx").rows()])


@usual
@given(text=YAMLS)
def test_any_text_is_a_config_or_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "config.yaml"
    path.write_text(text, encoding="utf-8")
    in_a_sentence(lambda: load(path))
    path.write_text(CONFIG, encoding="utf-8")
    in_a_sentence(lambda: load(path, [f"recordings.{text}", text]))


@usual
@given(unit=UNITS, channel=st.sampled_from(["time", "displacement", "acceleration", "spring_force"]))
def test_any_text_is_a_unit_or_refused(unit: str, channel: str) -> None:
    in_a_sentence(lambda: factor_to_si(unit, channel))


@pytest.mark.parametrize("name", [name for name in WRITERS if name not in ("r.csv", "r.lvm")])
@settings(usual, max_examples=max(EXAMPLES // 10, 6))
@given(changes=st.lists(st.tuples(st.floats(0.0, 1.0, exclude_max=True), st.integers(0, 255)), min_size=1, max_size=6))
def test_any_change_of_a_file_is_read_or_refused(tmp_path: Path, name: str, changes: list[tuple[float, int]]) -> None:
    path = tmp_path / name
    if not (tmp_path / "whole").exists():
        t, x, a = recorded(0.04, 0).T
        WRITERS[name](path, t, {"disp": (x, "m"), "acc": (a, "m/s^2")})
        (tmp_path / "whole").write_bytes(path.read_bytes())
    spoilt = bytearray((tmp_path / "whole").read_bytes())
    for share, value in changes:
        spoilt[int(share * len(spoilt))] = value
    path.write_bytes(spoilt)
    in_a_sentence(lambda: read_table(path))
