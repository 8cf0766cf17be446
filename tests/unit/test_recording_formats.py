"""The formats that laboratories keep: one trial written by other libraries comes back as the same motion."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.lab_files import WRITERS, write_csv, write_excel, write_feather, write_hdf5, write_lvm, write_mat, write_uff
from tests.small_campaign import recorded
from undertow.conditioning.condition import condition
from undertow.conditioning.motion import Motion
from undertow.errors import MisnamedError, RecordingError
from undertow.recording.catalogue import Catalogue, Entry, read_trial
from undertow.recording.layout import FileFormat
from undertow.recording.propose_file import propose_file
from undertow.recording.readers import read_table, tables_in
from undertow.recording.recording import Recording

EXACT, TWELVE_DIGITS = 1e-14, 1e-11
"""Of a channel's largest value: what doubles keep besides the factor of a unit, and 12 digits of a text."""

PRECISION = {"r.csv": TWELVE_DIGITS, "r.lvm": TWELVE_DIGITS, "r.uff": TWELVE_DIGITS}


def truth() -> dict[str, Any]:
    """A trial's instants, displacement and acceleration in SI."""
    time, x, a = recorded(0.04, 0).T
    return {"time": time, "disp": x, "acc": a}


def as_written(x: Any, a: Any) -> dict[str, Any]:
    """The channels in the units of the laboratory."""
    return {"disp": (1e3 * x, "mm"), "acc": (a, "m/s^2")}


def write(path: Path, writer: Callable[..., None] | None = None) -> Path:
    true = truth()
    (writer or WRITERS[path.name])(path, true["time"], as_written(true["disp"], true["acc"]))
    return path


@cache
def true_motion() -> Motion:
    true = truth()
    return condition(Recording("r", true["time"], {"displacement": true["disp"], "acceleration": true["acc"]}))


def read(path: Path) -> Recording:
    """The file as its own lines and names propose it."""
    found = propose_file(path)
    assert found.complete, found.proposal
    return read_trial(Entry("r", path), Catalogue(path.parent, found.proposal.channels, found.proposal.time,
                                                  files=path.name, layout=found.layout))  # fmt: skip


def reading(path: Path) -> str | None:
    """What a file is refused with; None where it is read."""
    try:
        read_table(path, FileFormat(), None)
    except RecordingError as error:
        return str(error)
    return None


@pytest.mark.parametrize("name", WRITERS)
def test_a_trial_of_every_format_comes_back_as_the_same_motion(tmp_path: Path, name: str) -> None:
    back = condition(read(write(tmp_path / name)))
    true, precision = true_motion(), PRECISION.get(name, EXACT)
    for channel, values in true.recording.channels.items():
        largest = float(np.max(np.abs(values)))
        assert np.max(np.abs(back.recording.channels[channel] - values)) < precision * largest, channel
    for quantity in ("t", "x", "v", "a", "x_std", "v_std", "a_std"):
        values = getattr(true, quantity)
        # the smoother's own rounding, which its matrices make larger than the format's
        assert np.max(np.abs(getattr(back, quantity) - values)) < 1e-6 * np.max(np.abs(values)), quantity
    assert back.window.release_s == pytest.approx(true.window.release_s, abs=1e-9)


@pytest.mark.parametrize("name", WRITERS)
def test_a_column_that_a_file_does_not_have_is_said_with_those_it_has(tmp_path: Path, name: str) -> None:
    path = write(tmp_path / name)
    layout = propose_file(path).layout
    with pytest.raises(MisnamedError, match=r"has no column 'dist'; it has .*disp.*; (did you mean|correct)"):
        read_table(path, layout, ["dist"])


@pytest.mark.parametrize("name", [name for name in WRITERS if name != "r.csv"])
@pytest.mark.parametrize("keep", [0.0, 0.1, 0.5, 0.98])
def test_a_file_that_was_cut_is_read_or_refused_in_a_sentence(tmp_path: Path, name: str, keep: float) -> None:
    path = write(tmp_path / name)
    content = path.read_bytes()
    path.write_bytes(content[: int(keep * len(content))])
    said = reading(path)
    assert said is None or (path.name in said and "; " in said), said


@pytest.mark.parametrize("name", [name for name in WRITERS if name != "r.csv"])
def test_a_file_with_changed_bytes_is_read_or_refused_in_a_sentence(tmp_path: Path, name: str) -> None:
    content = write(tmp_path / name).read_bytes()
    rng = np.random.default_rng(3)
    for _ in range(5):
        spoilt = bytearray(content)
        for at in rng.integers(0, len(spoilt), 8):
            spoilt[at] = int(rng.integers(256))
        (tmp_path / name).write_bytes(spoilt)
        said = reading(tmp_path / name)
        assert said is None or name in said, said


@pytest.mark.parametrize(
    ("name", "package", "extra"),
    [("r.tdms", "npTDMS", "labs"), ("r.uff", "pyuff", "labs"), ("r.mf4", "asammdf", "labs"),
     ("r.parquet", "pyarrow", "parquet"), ("r.feather", "pyarrow", "parquet")],
)  # fmt: skip
def test_a_library_that_is_not_installed_is_named_with_its_extra(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, package: str, extra: str
) -> None:
    path = write(tmp_path / name)

    def none(module: str) -> None:
        raise ImportError(module)

    monkeypatch.setattr(importlib, "import_module", none)
    with pytest.raises(RecordingError, match=rf"read through {package}, .* not installed; pip .*'undertow\[{extra}\]'"):
        read_table(path, FileFormat(), ["disp"])


def test_a_sheet_of_several_is_named_and_commas_and_blanks_are_understood(tmp_path: Path) -> None:
    import openpyxl

    path = write(tmp_path / "r.xlsx")
    book = openpyxl.load_workbook(path)
    other = book.create_sheet("Commas")
    for row in (["t", "x", "of"], [0.0, "1,5", None], [0.1, "#N/A", None], [0.2, 2, None], [None, None, None]):
        other.append(row)
    book.save(path)
    assert tables_in(path) == ("Trial", "Commas")
    table = read_table(path, FileFormat(variable="Commas", decimal=","), ["t", "x"])
    assert table["t"].tolist() == [0.0, 0.1, 0.2]
    np.testing.assert_array_equal(table["x"], [1.5, np.nan, 2.0])
    with pytest.raises(RecordingError, match=r"column 'of' has no values; where it holds formulas, open it in Excel"):
        read_table(path, FileFormat(variable="Commas"), ["of"])
    with pytest.raises(RecordingError, match=r"column 'x', row 2: '1,5' is not a number; repair the file"):
        read_table(path, FileFormat(variable="Commas"), ["x"])
    with pytest.raises(MisnamedError, match=r"no sheet 'Trail'; it has 'Trial', 'Commas'"):
        read_table(path, FileFormat(variable="Trail"), ["x"])
    with pytest.raises(RecordingError, match=r"the header row holds numbers \(0\.0\d, .*set header: none"):
        read_table(path, FileFormat(variable="Trial", skip_rows=5), None)
    with pytest.raises(RecordingError, match=r"has 0 rows after 90 skipped ones, and no data among them"):
        read_table(path, FileFormat(variable="Commas", skip_rows=90), None)


def test_dates_in_a_sheet_are_seconds_since_the_first_row(tmp_path: Path) -> None:
    import datetime

    import openpyxl

    book = openpyxl.Workbook()
    start = datetime.datetime(2024, 5, 3, 14, 0, 0)
    book.active.append(["when", "for", "at", "x"])
    for at in range(3):
        late = datetime.timedelta(seconds=0.5 * at)
        book.active.append([start + late, late, datetime.time(0, 0, 2 * at), float(at)])
    book.save(tmp_path / "d.xlsx")
    table = read_table(tmp_path / "d.xlsx", FileFormat(), ["when", "for", "at"])
    np.testing.assert_allclose(table["when"], [0.0, 0.5, 1.0], atol=1e-3)  # Excel keeps milliseconds
    np.testing.assert_allclose(table["for"], [0.0, 0.5, 1.0], atol=1e-3)
    np.testing.assert_allclose(table["at"], [0.0, 2.0, 4.0])


def test_the_time_of_a_measurement_file_may_be_stated_alone(tmp_path: Path) -> None:
    path = write(tmp_path / "r.lvm")
    text = path.read_text()
    head, _, data = text.partition("X_Value\t")
    rows = [line.partition("\t")[2] for line in data.splitlines()[1:]]
    alone = head.replace("X_Columns\tOne", "X_Columns\tNo").replace("Delta_X\t1.0", "Delta_X\t0.01")
    path.write_text(alone + "disp\tacc\tComment\n" + "\n".join(rows) + "\n")
    back = read(path)
    np.testing.assert_allclose(back.time, truth()["time"], atol=1e-12)
    np.testing.assert_allclose(back.channels["displacement"], truth()["disp"], rtol=1e-11)
    path.write_text(alone.replace("Delta_X\t0.01", "") + "disp\tacc\tComment\n" + "\n".join(rows) + "\n")
    with pytest.raises(RecordingError, match=r"states neither X_Value nor X0 and Delta_X; give channels\.time"):
        read_table(path, FileFormat(), ["X_Value", "disp"])


def test_a_measurement_file_with_decimal_commas_is_the_same(tmp_path: Path) -> None:
    back = read(write(tmp_path / "r.lvm", lambda *said: write_lvm(*said, decimal=",")))
    np.testing.assert_allclose(back.channels["displacement"], truth()["disp"], rtol=1e-11)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("time,x\n0,1\n", r"has no header of a LabVIEW measurement file; is its suffix right"),
        ("LabVIEW Measurement\n***End_of_Header***\n", r"has a LabVIEW header and no data below it; copy it again"),
    ],
)
def test_a_text_that_is_no_measurement_file_is_refused(tmp_path: Path, text: str, sentence: str) -> None:
    (tmp_path / "r.lvm").write_text(text)
    with pytest.raises(RecordingError, match=sentence):
        read_table(tmp_path / "r.lvm", FileFormat(), None)


def test_groups_of_a_tdms_file_are_named_and_clocks_that_differ_are_said(tmp_path: Path) -> None:
    import nptdms

    path, values = tmp_path / "two.tdms", np.arange(40.0)
    with nptdms.TdmsWriter(str(path)) as file:
        file.write_segment([
            nptdms.ChannelObject("fast", "disp", values, {"wf_increment": 0.01}),
            nptdms.ChannelObject("fast", "acc", values, {"wf_increment": 0.02}),
            nptdms.ChannelObject("slow", "load", values[:9], {"wf_increment": 0.1}),
        ])  # fmt: skip
    assert tables_in(path) == ("fast", "slow")
    with pytest.raises(MisnamedError, match=r"holds 2 groups: 'fast', 'slow'; name one in recordings\.variable"):
        read_table(path, FileFormat(), ["disp"])
    with pytest.raises(RecordingError, match=r"disp, acc have clocks of their own \(100 Hz, 50 Hz\); give the slower"):
        read_table(path, FileFormat(variable="fast"), ["time", "disp", "acc"])
    table = read_table(path, FileFormat(variable="slow"), ["time", "load"])
    np.testing.assert_allclose(table["time"], 0.1 * np.arange(9))


def test_a_universal_file_without_time_responses_is_refused(tmp_path: Path) -> None:
    path = write(tmp_path / "r.uff")
    lines = path.read_text().splitlines()
    for at, line in enumerate(lines):
        if at and lines[at - 1].startswith("NONE") and line[:5].strip() == "1":  # function type
            lines[at] = "    4" + line[5:]
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(RecordingError, match=r"has 2 data sets, none of them a time response \(58, function type 1\)"):
        read_table(path, FileFormat(), None)


def test_responses_of_a_universal_file_with_other_times_need_their_own(tmp_path: Path) -> None:
    true, path = truth(), tmp_path / "r.uff"
    write_uff(path, true["time"], {"disp": (true["disp"], "m")})
    write_uff(path, true["time"][:100], {"acc": (true["acc"][:100], "m/s^2")})
    with pytest.raises(RecordingError, match=r"'acc' has other times than 'disp'; give it its own"):
        read_table(path, FileFormat(), ["time", "disp", "acc"])
    assert len(read_table(path, FileFormat(), ["time", "acc"])) == 100
    assert len(read_table(path, FileFormat(), ["time", 0])) == true["time"].size


def test_groups_of_an_mdf_file_have_their_own_clocks(tmp_path: Path) -> None:
    import asammdf

    fast, slow, path = np.arange(0.0, 2.0, 0.01), np.arange(0.0, 2.0, 0.05), tmp_path / "r.mf4"
    with asammdf.MDF(version="4.10") as file:
        file.append([asammdf.Signal(samples=np.cos(fast), timestamps=fast, name="disp", unit="m")])
        file.append([asammdf.Signal(samples=np.cos(slow), timestamps=slow, name="load", unit="N")])
        file.save(path, overwrite=True)
    assert read_table(path, FileFormat(), ["time", "load"])["time"].tolist() == slow.tolist()
    with pytest.raises(RecordingError, match=r"disp, load lie in different channel groups, each with its own clock"):
        read_table(path, FileFormat(), ["time", "disp", "load"])
    found = propose_file(path).proposal
    assert found.channels["spring_force"].variable == "1"
    assert found.channels["spring_force"].time is not None


def test_a_column_of_texts_in_an_arrow_table_is_refused(tmp_path: Path) -> None:
    import pyarrow.feather
    import pyarrow.parquet

    when = pyarrow.array([0, 500], pyarrow.timestamp("ms"))
    table = pyarrow.table({"t": [0.0, 0.1], "x": ["a", "b"], "when": when})
    pyarrow.parquet.write_table(table, tmp_path / "r.parquet")
    pyarrow.feather.write_feather(table, tmp_path / "r.feather")
    for name in ("r.parquet", "r.feather"):
        assert read_table(tmp_path / name, FileFormat(), ["when"])["when"].tolist() == [0.0, 0.5]
        with pytest.raises(RecordingError, match=r"column 'x' holds string, not numbers; map another"):
            read_table(tmp_path / name, FileFormat(), ["x"])


def test_tables_of_an_hdf5_file_are_groups_matrices_and_fields(tmp_path: Path) -> None:
    import h5py

    path = write(tmp_path / "r.h5")
    with h5py.File(path, "a") as file:
        file["matrix"] = np.arange(20.0).reshape(2, 10)
        file["fields"] = np.zeros(5, dtype=[("t", "f8"), ("x", "f4"), ("note", "S4")])
        file["one"] = 3.0
    assert tables_in(path) == ("fields", "matrix", "trial")
    assert read_table(path, FileFormat(variable="matrix"))[1].tolist() == list(range(10, 20))
    assert list(read_table(path, FileFormat(variable="fields"))) == ["t", "x"]
    with pytest.raises(MisnamedError, match=r"holds 3 tables: 'fields', 'matrix', 'trial'; name one"):
        read_table(path, FileFormat())
    with pytest.raises(MisnamedError, match=r"has no table 'trail'; it has 'fields', 'matrix', 'trial'"):
        read_table(path, FileFormat(variable="trail"))
    with pytest.raises(RecordingError, match=r"'note' holds a .*, not numbers; only arrays of numbers"):
        read_table(path, FileFormat(variable="fields"), ["note"])


def test_vectors_of_different_lengths_are_one_table_only_where_those_of_one_length_are_asked(tmp_path: Path) -> None:
    import h5py

    path = tmp_path / "r.h5"
    with h5py.File(path, "w") as file:
        for name, size in {"time": 9, "x": 9, "load": 3}.items():
            file[name] = np.arange(float(size))
    assert list(read_table(path, FileFormat())) == ["time", "x"]
    with pytest.raises(RecordingError, match=r"columns differ in length \(time: 9, load: 3\); map columns of one"):
        read_table(path, FileFormat(), ["time", "load"])


def test_what_else_a_matlab_file_holds_does_not_matter(tmp_path: Path) -> None:
    import scipy.io

    true = truth()
    scipy.io.savemat(tmp_path / "r.mat", {
        "t": true["time"], "x": true["disp"], "g": 9.81, "note": "by hand", "n": np.array([[1, 2], [3, 4]]),
        "cells": np.array([1.0, "a"], dtype=object), "info": {"rate": 100.0},
    })  # fmt: skip
    assert read_table(tmp_path / "r.mat", FileFormat(), ["t", "x"]).shape == (true["time"].size, 2)
    with pytest.raises(MisnamedError, match=r"has no column 'y'; it has t, x"):
        read_table(tmp_path / "r.mat", FileFormat(), ["t", "y"])


def test_a_text_in_another_encoding_is_read_with_it(tmp_path: Path) -> None:
    path = tmp_path / "r.csv"
    path.write_bytes("時間,変位\n0.0,1.0\n0.1,2.0\n".encode("shift_jis"))
    table = read_table(path, FileFormat(encoding="shift_jis"), ["変位"])
    assert table["変位"].tolist() == [1.0, 2.0]
    with pytest.raises(RecordingError, match=r"is not in encoding 'utf-8' \(.*\); correct recordings\.encoding"):
        read_table(path, FileFormat(encoding="utf-8"), None)


def test_the_only_table_of_any_format_needs_no_name(tmp_path: Path) -> None:
    for name, writer in (("a.xlsx", write_excel), ("a.h5", write_hdf5), ("a.feather", write_feather)):
        found = propose_file(write(tmp_path / name, writer))
        assert found.layout == replace(FileFormat(), skip_rows=found.layout.skip_rows, unit_row=found.layout.unit_row)
    assert tables_in(write(tmp_path / "a.csv", write_csv)) == ("",)
    assert tables_in(write(tmp_path / "a.mat", write_mat)) == ("",)
