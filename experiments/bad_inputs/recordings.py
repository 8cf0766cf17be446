"""Recordings that are damaged, not what they seem, or larger than a machine.

Belongs here: files. Does not belong here: configs and indexes (configs.py), words of the command line (words.py).
"""

from __future__ import annotations

import gzip
import io
import struct
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np

from experiments.bad_inputs.case import FAILED, RATE_HZ, SOME_FAILED, USAGE, Case, Table, edit, recorded, write_table

RUBBISH = bytes(np.random.default_rng(1).integers(0, 256, 4000, dtype=np.uint8))


def table(change: Callable[[Table], Table | None]) -> Callable[[Path], object]:
    """The campaign's trial with changed values."""

    def spoil(folder: Path) -> None:
        values = recorded()
        changed = change(values)
        write_table(folder / "r00.csv", values if changed is None else changed)

    return spoil


def put(rows: slice | int, column: int, value: float) -> Callable[[Path], object]:
    """The campaign's trial with one value in some rows of a column."""
    return table(lambda values: values.__setitem__((rows, column), value))


def content(said: bytes) -> Callable[[Path], object]:
    """The campaign's trial with these bytes."""
    return lambda folder: (folder / "r00.csv").write_bytes(said)


def named(name: str, said: bytes | Callable[[Path], object] = RUBBISH) -> Callable[[Path], object]:
    """The campaign's trial in a file of another kind: bytes, or who writes it."""

    def spoil(folder: Path) -> None:
        path = folder / name
        if callable(said):
            said(path)
        else:
            path.write_bytes(said)
        edit(folder / "campaign.csv", "r00.csv", name)

    return spoil


def text(old: str, new: str) -> Callable[[Path], object]:
    """The campaign's trial with another text in one place."""
    return lambda folder: edit(folder / "r00.csv", old, new)


def without_release(values: Table) -> None:
    """A record that never moves."""
    values[:, 1] = 0.04 + 1e-4 * np.random.default_rng(1).standard_normal(len(values))
    values[:, 2] = 0.02 * np.random.default_rng(2).standard_normal(len(values))


def three_releases(values: Table) -> Table:
    """A record of three releases on one clock: held for 2 s, let go, held again."""
    held = np.repeat(values[:1], round(2.0 * RATE_HZ), axis=0)
    whole = np.concatenate([held, values] * 3)
    whole[:, 0] = np.arange(len(whole)) / RATE_HZ
    whole[:, 1] += 1e-4 * np.random.default_rng(3).standard_normal(len(whole))
    return whole


def beside_a_copy(change: Callable[[Table], Table]) -> Callable[[Path], object]:
    """The campaign's trial and, as another trial, the same recording changed."""

    def spoil(folder: Path) -> None:
        write_table(folder / "r01.csv", change(recorded()))
        with (folder / "campaign.csv").open("a") as index:
            index.write("r01.csv,long\n")

    return spoil


def gzip_bomb(path: Path) -> None:
    """2 MB that unfold to 1 GB of rows."""
    path.write_bytes(gzip.compress(b"t,x,a\n") + 60 * gzip.compress(b"0,0,0\n" * 3_000_000, compresslevel=1))


def mat_bomb(path: Path) -> None:
    """1 MB that unfold to 300 MB of doubles, MAT version 5."""
    size = 300_000_000
    folded = zlib.compressobj(1)
    head = struct.pack("<IIII", 6, 8, 6, 0) + struct.pack("<IIii", 5, 8, 1, size // 8) + struct.pack("<II", 1, 1)
    head += b"t".ljust(8, b"\0") + struct.pack("<II", 9, size)
    body = [folded.compress(struct.pack("<II", 14, len(head) + size) + head)]
    body += [folded.compress(bytes(1_000_000)) for _ in range(300)]
    packed = b"".join([*body, folded.flush()])
    path.write_bytes(b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM" + struct.pack("<II", 15, len(packed)) + packed)


def mat(path: Path) -> None:
    """A MAT v5 file cut in its second vector."""
    import scipy.io

    t, x, a = recorded().T
    scipy.io.savemat(path, {"t": t, "x": x, "a": a})
    path.write_bytes(path.read_bytes()[:-6000])


def hdf5(path: Path, size: int = 10**12) -> None:
    """HDF5 that states a million million values."""
    import h5py

    with h5py.File(path, "w", userblock_size=512 if path.suffix == ".mat" else 0) as file:
        for name in "txa":
            dataset = file.create_dataset(name, shape=(size,), dtype="f8", chunks=(10**5,), compression="gzip")
            dataset.attrs["MATLAB_class"] = np.bytes_("double")
    if path.suffix == ".mat":
        with path.open("r+b") as stream:
            stream.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")


def damaged_mat73(path: Path) -> None:
    """MAT v7.3 with rubbish behind its header."""
    hdf5(path, 10**6)
    path.write_bytes(path.read_bytes()[:600] + RUBBISH)


def linked_hdf5(path: Path) -> None:
    """HDF5 whose time lies in another file."""
    import h5py

    with h5py.File(path, "w") as file:
        file["t"] = h5py.ExternalLink("/etc/passwd", "/t")


def without_end(path: Path) -> None:
    """A line of 2 GB, which takes no space on the disk."""
    path.write_bytes(b"t,x,a\n")
    with path.open("ab") as stream:
        stream.truncate(2_000_000_000)


def workbook(sheet: bytes) -> Callable[[Path], object]:
    """A workbook whose sheet is these bytes."""

    def write(path: Path) -> None:
        import openpyxl

        whole, packed = io.BytesIO(), zipfile.ZipFile
        openpyxl.Workbook().save(whole)
        with packed(whole) as old, packed(path, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as new:
            for part in old.namelist():
                new.writestr(part, sheet if part.endswith("sheet1.xml") else old.read(part))

    return write


WIDE = (",".join(f"c{i}" for i in range(100_000)) + "\n" + ",".join(["0"] * 100_000) + "\n").encode()
TYPED = b'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY b "c">]><worksheet/>'

CASES = (
    Case("40 % of the displacement missing", put(slice(100, 320), 1, np.nan), r"displacement lacks 220 of 550 values"),
    Case("two rows of one time", lambda f: table(lambda v: v.__setitem__((200, 0), v[199, 0]))(f),
         r"time goes from 1\.99 s to 1\.99 s at sample 200; time must increase"),
    Case("time that goes back", table(lambda v: v.__setitem__((slice(300, None), 0), v[300:, 0] - 1.0)),
         r"time goes from 2\.99 s to 2 s at sample 300"),
    Case("a time that is infinite", put(5, 0, np.inf), r"time column 't' has 1 values that are not finite"),
    Case("a constant acceleration", put(slice(None), 2, 0.3), r"acceleration is constant at 0\.3 m/s\^2"),
    Case("a clipped displacement", table(lambda v: v.__setitem__((slice(None), 1), np.clip(v[:, 1], -0.02, 0.02))),
         r"displacement is clipped between"),
    Case("no release", table(without_release), r"no release found: the record moves by"),
    Case("three releases on one clock", table(three_releases),
         r"it holds 3 releases on one clock .*, and a trial is one: give each its part as a trial"),
    Case("one recording as two trials, turned round", beside_a_copy(lambda v: v * [1.0, -1.0, -1.0]),
         r"trial r01 is the recording r00 times -1; take one of them out of the campaign", SOME_FAILED),
    Case("one recording as two trials, every second sample", beside_a_copy(lambda v: v[::2]),
         r"trial r01 is every 2nd sample of r00; take one of them out of the campaign", SOME_FAILED),
    Case("two samples", table(lambda v: v[:2]), r"has 2 samples; at least 50 are needed"),
    Case("displacement times 1e300", table(lambda v: v.__setitem__((slice(None), 1), v[:, 1] * 1e300)), r"1e\+?60"),
    Case("an empty file", content(b"")  , r"r00\.csv is empty \(0 bytes\); copy it again"),
    Case("control bytes", content(b"\0\1\2\3"), r"r00\.csv is not text: 4 control bytes"),
    Case("a header alone", content(b"t,x,a\n"), r"has 1 lines after 0 skipped ones, and no data"),
    Case("a word among numbers", text("0.04", "off"), r"column 'x', line \d+: 'off.*' is not a number"),
    Case("a row with more cells", text("\n0.01,", "\n0.01,9,9,"), r"Expected 3 fields in line 2, saw 5; give rec"),
    Case("two columns of one name", text("t,x,a", "t,x,x"), r"has 2 columns named 'x'"),
    Case("a header of numbers", text("t,x,a", "1,2,3"), r"the header line holds numbers \(1, 2, 3\)"),
    Case("a column that is not there", text("t,x,a", "t,pos,a"), r"has no column 'x'; it has t, pos, a", USAGE),
    Case("100,000 columns", content(WIDE), r"has 100000 columns, recordings\.limits\.columns allows 4096"),
    Case("a line of 3 MB", content(b"t,x,a\n" + b"1" * 3_000_000), r"line 2 has more than 1048576 characters"),
    Case("a line of 2 GB", named("r.csv", without_end), r"its text would take 2000 MB"),
    Case("2 MB of gzip that unfold to 1 GB", named("r.csv.gz", gzip_bomb), r"unfolds to more than the 256 MB",
         slow=True),
    Case("a gzip that was cut", named("r.csv.gz", gzip.compress(b"t,x,a\n" * 999)[:40]), r"r\.csv\.gz"),
    Case("a pickle", named("r.pkl"), r"\.pkl can carry code and is never read"),
    Case("a NumPy file", named("r.npy"), r"\.npy can carry code and is never read"),
    Case("an old workbook", named("r.xls"), r"no reader for '\.xls'; .*save it as \.xlsx"),
    Case("an archive", named("r.zip"), r"r\.zip: is an archive, and no archive is opened; unpack it"),
    Case("no suffix", named("recording"), r"no reader for 'a name without suffix'|name without suffix"),
    Case("a folder as a recording", lambda f: (f / "r01").mkdir() or edit(f / "campaign.csv", "r00.csv", "r01"),
         r"r01 is (a folder|not there)", USAGE),
    Case("rubbish called .mat", named("r.mat"), r"r\.mat is no readable"),
    Case("a MAT file that was cut", named("r.mat", mat), r"r\.mat"),
    Case("1 MB of MAT that unfold to 300 MB", named("r.mat", mat_bomb), r"unfolds to more than the 256 MB", slow=True),
    Case("a damaged MAT 7.3 file", named("r.mat", damaged_mat73), r"r\.mat is no readable"),
    Case("MAT 7.3 that states 10^12 values", named("r.mat", hdf5), r"would take 8e\+06 MB"),
    Case("HDF5 that states 10^12 values", named("r.h5", hdf5), r"would take 8e\+06 MB"),
    Case("HDF5 that leads to another file", named("r.h5", linked_hdf5), r"'t' links to the file '/etc/passwd'"),
    Case("rubbish called .h5", named("r.h5"), r"r\.h5 is no readable"),
    Case("rubbish called .xlsx", named("r.xlsx"), r"r\.xlsx is no readable"),
    Case("a workbook that unfolds to 300 MB", named("r.xlsx", workbook(b" " * 300_000_000)), r"would take 300 MB",
         slow=True),
    Case("a workbook with a document type", named("r.xlsx", workbook(TYPED)), r"declares a document type"),
    Case("rubbish called .lvm", named("r.lvm"), r"r\.lvm"),
    Case("rubbish called .tdms", named("r.tdms"), r"r\.tdms is no readable"),
    Case("rubbish called .uff", named("r.uff"), r"r\.uff"),
    Case("rubbish called .mf4", named("r.mf4"), r"r\.mf4 is no readable"),
    Case("rubbish called .parquet", named("r.parquet"), r"r\.parquet is no readable"),
    Case("rubbish called .feather", named("r.feather"), r"r\.feather is no readable"),
)  # fmt: skip
"""Recordings through ``run``; a campaign's only trial, so that the run ends with the sentence."""

__all__ = ["CASES", "FAILED"]
