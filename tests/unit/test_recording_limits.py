"""Files that would take a machine's memory or time: refused with a sentence before they do."""

from __future__ import annotations

import gzip
import io
import struct
import time
import zipfile
import zlib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from tests.lab_files import WRITERS
from tests.small_campaign import recorded
from undertow.errors import RecordingError
from undertow.recording.layout import FileFormat
from undertow.recording.limits import LIMITS, Limits
from undertow.recording.readers import read_table, tables_in

SMALL = FileFormat(limits=Limits(megabytes=1.0))
TOO_MUCH = r"recordings\.limits\.megabytes allows"


@contextmanager
def within(seconds: float) -> Iterator[None]:
    """A block that must end in time."""
    start = time.perf_counter()
    yield
    assert time.perf_counter() - start < seconds


def zeros(megabytes: int, write: Callable[[bytes], object]) -> None:
    """So many MB of the byte 0, piece by piece."""
    for _ in range(megabytes):
        write(bytes(1_000_000))


def test_a_gzip_that_unfolds_to_more_than_allowed_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "r.csv.gz"
    member = gzip.compress(b"0,0\n" * 2_500_000, compresslevel=1)
    path.write_bytes(gzip.compress(b"t,x\n") + 30 * member)
    assert path.stat().st_size < 3e6
    with within(5.0), pytest.raises(RecordingError, match=rf"unfolds to more than the 1 MB that {TOO_MUCH}"):
        read_table(path, SMALL)
    with within(5.0), pytest.raises(RecordingError, match=rf"unfolds to more than the 256 MB that {TOO_MUCH}"):
        read_table(path)


def test_no_more_of_a_gzip_is_unfolded_than_allowed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "r.csv.gz").write_bytes(gzip.compress(b"t,x\n0,0\n"))
    asked: list[int] = []

    class Stream(io.BytesIO):
        def read(self, size: int | None = -1) -> bytes:
            asked.append(-1 if size is None else size)
            return super().read(size)

    monkeypatch.setattr(gzip, "open", lambda path: Stream(b"t,x\n" + b"0,0\n" * 500_000))
    with pytest.raises(RecordingError, match=r"unfolds to more than the 1 MB"):
        read_table(tmp_path / "r.csv.gz", SMALL)
    assert asked == [1_000_001]


def mat_bomb(path: Path, megabytes: int) -> None:
    """A MAT v5 file with a packed variable of doubles 0, written in pieces."""
    folded = zlib.compressobj(1)
    size = megabytes * 1_000_000
    head = struct.pack("<IIII", 6, 8, 6, 0) + struct.pack("<IIii", 5, 8, 1, size // 8) + struct.pack("<II", 1, 1)
    head += b"x".ljust(8, b"\0") + struct.pack("<II", 9, size)
    body = [folded.compress(struct.pack("<II", 14, len(head) + size) + head)]
    zeros(megabytes, lambda piece: body.append(folded.compress(piece)))
    packed = b"".join([*body, folded.flush()])
    path.write_bytes(b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM" + struct.pack("<II", 15, len(packed)) + packed)


def test_a_mat_file_that_unfolds_to_more_than_allowed_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "r.mat"
    mat_bomb(path, 300)
    assert path.stat().st_size < 3e6
    with within(5.0), pytest.raises(RecordingError, match=rf"unfolds to more than the 256 MB that {TOO_MUCH}"):
        read_table(path, columns=["x"])
    mat_bomb(path, 2)
    with pytest.raises(RecordingError, match=rf"unfolds to more than the 1 MB that {TOO_MUCH}"):
        read_table(path, SMALL, ["x"])
    assert len(read_table(path, columns=["x"])) == 250_000
    with pytest.raises(RecordingError, match=r"has no column 'y'"):
        read_table(path, SMALL, ["y"])  # what nobody asks for is not unfolded


@pytest.mark.parametrize("name", ["r.h5", "r73.mat"])
def test_an_hdf5_file_that_states_a_million_million_values_is_refused(tmp_path: Path, name: str) -> None:
    import h5py

    with h5py.File(tmp_path / name, "w", userblock_size=512 if name.endswith("mat") else 0) as file:
        dataset = file.create_dataset("x", shape=(10**12,), dtype="f8", chunks=(10**5,), compression="gzip")
        dataset.attrs["MATLAB_class"] = np.bytes_("double")
        file["t"] = np.arange(9.0)
    if name.endswith("mat"):
        with (tmp_path / name).open("r+b") as stream:
            stream.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")
    with within(5.0), pytest.raises(RecordingError, match=rf"'x' would take 8e\+06 MB, {TOO_MUCH} 256; is it"):
        read_table(tmp_path / name, columns=["x"])


def test_what_leads_out_of_an_hdf5_file_is_refused(tmp_path: Path) -> None:
    import h5py

    path = tmp_path / "r.h5"
    (tmp_path / "raw.bin").write_bytes(bytes(80))
    with h5py.File(path, "w") as file:
        file["t"] = np.arange(10.0)
        file.create_dataset("x", shape=(10,), dtype="f8", external=[(str(tmp_path / "raw.bin"), 0, 80)])
    with pytest.raises(RecordingError, match=r"'x' has its values in another file; only what lies in the file is read"):
        read_table(path, columns=["x"])
    with h5py.File(path, "w") as file:
        file["there"] = h5py.ExternalLink("other.h5", "/x")
    for layout in (FileFormat(variable="there"), FileFormat()):
        with pytest.raises(RecordingError, match=r"'there' links to the file 'other\.h5'; only what lies in the file"):
            read_table(path, layout)
    with h5py.File(path, "w") as file:
        group = file.create_group("a")
        group["a"] = group  # a group within itself
    with within(5.0), pytest.raises(RecordingError, match=r"lies more than 32 groups deep; is it damaged"):
        read_table(path)


def test_an_hdf5_file_with_endless_objects_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    import h5py

    from undertow.recording import hdf5, mat_sizes

    monkeypatch.setattr(hdf5, "OBJECTS_AT_MOST", 20)
    monkeypatch.setattr(mat_sizes, "OBJECTS_AT_MOST", 5)
    with h5py.File(tmp_path / "r.h5", "w") as file:
        for number in range(30):
            file[f"x{number}"] = 1.0
    with pytest.raises(RecordingError, match=r"has more than 20 objects; split it"):
        read_table(tmp_path / "r.h5")
    with h5py.File(tmp_path / "r.mat", "w", userblock_size=512) as file:
        cell = file.create_dataset("#refs#/a", data=np.arange(9.0))
        file.create_dataset("cells", data=np.array([cell.ref] * 9, dtype=h5py.ref_dtype))
    with pytest.raises(RecordingError, match=r"'cells' leads to more than 5 objects or 32 levels; save its tria"):
        read_table(tmp_path / "r.mat", columns=["cells"])


def test_a_table_of_a_hundred_thousand_columns_is_refused(tmp_path: Path) -> None:
    import pyarrow.parquet

    many = 100_000
    (tmp_path / "r.csv").write_text(",".join(f"c{i}" for i in range(many)) + "\n" + ",".join(["0"] * many) + "\n")
    pyarrow.parquet.write_table(pyarrow.table({f"c{i}": [0.0] for i in range(5000)}), tmp_path / "r.parquet")
    for name, columns in (("r.csv", many), ("r.parquet", 5000)):
        with within(5.0), pytest.raises(RecordingError, match=rf"has {columns} columns, recordings\.limits\.col"):
            read_table(tmp_path / name, columns=["c1"])


def test_a_line_without_an_end_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "r.csv"
    path.write_bytes(b"t,x\n" + b"1" * 3_000_000)
    with within(5.0), pytest.raises(RecordingError, match=r"line 2 has more than 1048576 characters; is it a"):
        read_table(path)
    path.write_bytes(b"t,x\n")
    with path.open("ab") as stream:
        stream.truncate(2_000_000_000)  # takes no space on the disk
    with within(5.0), pytest.raises(RecordingError, match=rf"its text would take 2000 MB, {TOO_MUCH} 256"):
        read_table(path)


def spreadsheet(path: Path, sheet: bytes) -> None:
    """A workbook whose sheet is these bytes."""
    import openpyxl

    whole, packed = io.BytesIO(), zipfile.ZipFile
    openpyxl.Workbook().save(whole)
    with packed(whole) as old, packed(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as new:
        for part in old.namelist():
            new.writestr(part, sheet if part.endswith("sheet1.xml") else old.read(part))


def test_a_workbook_that_unfolds_to_more_than_allowed_or_declares_types_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "r.xlsx"
    spreadsheet(path, b" " * 300_000_000)
    assert path.stat().st_size < 3e6
    with within(5.0), pytest.raises(RecordingError, match=rf"its sheets would take 300 MB, {TOO_MUCH} 256"):
        read_table(path)
    spreadsheet(path, b'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b "c">]><worksheet/>')
    with pytest.raises(RecordingError, match=r"its part 'xl/worksheets/sheet1\.xml' declares a document type"):
        read_table(path)


@pytest.mark.parametrize("name", ["r.tdms", "r.uff", "r.mf4", "r.parquet", "r.feather", "r.h5", "r.mat", "r.xlsx"])
def test_every_format_keeps_the_limit(tmp_path: Path, name: str) -> None:
    t, x, _ = recorded(0.04, 0).T
    WRITERS[name](tmp_path / name, t, {"disp": (x, "m")})
    column = "disp_m" if name == "r.mat" else "disp"
    with pytest.raises(RecordingError, match=r"(would take|unfolds to) .*recordings\.limits\.megabytes allows"):
        read_table(tmp_path / name, FileFormat(limits=Limits(megabytes=0.003)), [column])


def test_a_tdms_file_that_states_more_values_than_it_has_keeps_to_its_bytes(tmp_path: Path) -> None:
    t, x, _ = recorded(0.04, 0).T
    path = tmp_path / "r.tdms"
    WRITERS[path.name](path, t, {"disp": (x, "m")})
    content = path.read_bytes()
    assert content.count(struct.pack("<Q", x.size)) == 1
    path.write_bytes(content.replace(struct.pack("<Q", x.size), struct.pack("<Q", 10**12)))
    with within(5.0):
        assert len(read_table(path, columns=["disp"])) == x.size


def test_a_feather_file_that_states_huge_buffers_is_refused(tmp_path: Path) -> None:
    import pyarrow.feather

    path = tmp_path / "r.feather"
    pyarrow.feather.write_feather(pyarrow.table({"x": np.zeros(4_000_000)}), path, compression="zstd")
    assert path.stat().st_size < 1e5
    with pytest.raises(RecordingError, match=rf"its record batches would take 32 MB, {TOO_MUCH} 1;"):
        read_table(path, SMALL, ["x"])


def test_limits_allow_what_they_say() -> None:
    LIMITS.allow_bytes(Path("r.csv"), 256e6, "it")
    LIMITS.allow_columns(Path("r.csv"), 4096)
    with pytest.raises(RecordingError, match=r"r\.csv: it would take 256\.1 MB, recordings\.limits\.megabytes allows"):
        LIMITS.allow_bytes(Path("r.csv"), 256.1e6, "it")
    with pytest.raises(RecordingError, match=r"r\.csv has 4097 columns, recordings\.limits\.columns allows 4096"):
        LIMITS.allow_columns(Path("r.csv"), 4097)


def test_tables_of_a_damaged_file_are_a_sentence(tmp_path: Path) -> None:
    for name in ("r.mat", "r.h5", "r.xlsx", "r.tdms", "r.mf4"):
        (tmp_path / name).write_bytes(b"\x89HDF\r\n\x1a\nrubbish" * 30)
        with pytest.raises(RecordingError, match=rf"{name} is no readable .*; "):
            tables_in(tmp_path / name)
