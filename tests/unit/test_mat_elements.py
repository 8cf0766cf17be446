"""Variables of MATLAB 5 files whose elements are not what MATLAB writes: refused before a library meets them."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
import scipy.sparse

from undertow.errors import RecordingError
from undertow.recording.mat_elements import DEEPEST
from undertow.recording.readers import read_table, tables_in

FLAGS, DIMENSIONS, NAME, VALUES = 136, 152, 168, 176
"""Where the elements of the first variable begin, uncompressed."""


def saved(path: Path, folded: bool = False, **variables: Any) -> bytearray:
    scipy.io.savemat(path, variables or {"t": np.arange(50.0), "x": np.arange(50.0)}, do_compression=folded)
    return bytearray(path.read_bytes())


def inner(depth: int) -> dict[str, Any]:
    return {"a": inner(depth - 1)} if depth else {"x": np.arange(3.0)}


def test_every_class_that_matlab_writes_is_left_to_its_reader(tmp_path: Path) -> None:
    cells = np.array([np.arange(4.0), "text", np.array([[1, 2]], dtype=np.int16)], dtype=object)
    for folded in (False, True):
        path = tmp_path / f"{folded}.mat"
        saved(
            path, folded, t=np.arange(50.0), x=np.arange(50.0), z=np.arange(3.0) + 1j, cells=cells, note="by hand",
            sparse=scipy.sparse.eye(5).tocsc(), empty=np.zeros((0, 3)), on=True, small=np.int8(3),
            run={"t": np.arange(5.0), "more": {"x": np.arange(5.0)}, "text": "a"},
        )  # fmt: skip
        assert list(read_table(path).columns) == ["t", "x"]
        assert set(tables_in(path)) >= {"", "run", "run.more"}


@pytest.mark.parametrize(
    ("at", "value", "said"),
    [
        (VALUES, 8, r"'t' has an element of kind 8 and 400 bytes where it should not"),
        (VALUES + 4, 2**31, r"has an element of kind 9 and 2147483648 bytes where it should not"),
        (FLAGS, 5, r"has an element of kind 5 and 8 bytes"),
        (FLAGS + 8, 19, r"is of class 19, which MATLAB does not write"),
        (FLAGS + 8, 1, r"has an element of kind 9 and 400 bytes where a matrix should be|is said to hold 50 parts"),
        (DIMENSIONS + 12, 2**30, r"is said to hold \d+ values in \d+ bytes"),
        (DIMENSIONS + 4, 1, r"has 1 bytes of dimensions"),
        (132, 4, r"a variable has an element of kind 6 and 0 bytes where it should not"),
    ],
)
def test_a_changed_word_is_a_sentence(tmp_path: Path, at: int, value: int, said: str) -> None:
    content = saved(tmp_path / "r.mat")
    content[at : at + 4] = struct.pack("<I", value)
    (tmp_path / "r.mat").write_bytes(content)
    with pytest.raises(RecordingError, match=rf"r\.mat is damaged: .*{said}.*save it again with -v7"):
        read_table(tmp_path / "r.mat")


def test_a_structure_of_more_parts_than_bytes_is_refused(tmp_path: Path) -> None:
    content = saved(tmp_path / "r.mat", run={"t": np.arange(50.0)})
    content[DIMENSIONS + 8 : DIMENSIONS + 12] = struct.pack("<I", 2**31 - 1)
    (tmp_path / "r.mat").write_bytes(content)
    with pytest.raises(RecordingError, match=r"'run' is said to hold 2147483647 parts in \d+ bytes"):
        read_table(tmp_path / "r.mat")


def test_packed_bytes_that_were_changed_or_cut_are_a_sentence(tmp_path: Path) -> None:
    content = saved(tmp_path / "r.mat", folded=True, t=np.random.default_rng(1).standard_normal(500))
    changed = content.copy()
    changed[400] ^= 16
    (tmp_path / "r.mat").write_bytes(changed)
    with pytest.raises(RecordingError, match=r"r\.mat is damaged: a variable does not unfold"):
        read_table(tmp_path / "r.mat")
    (tmp_path / "r.mat").write_bytes(content[:900])
    with pytest.raises(RecordingError, match=r"variable 't' ends early"):
        read_table(tmp_path / "r.mat")
    tag = struct.pack("<II", 15, 8)
    (tmp_path / "r.mat").write_bytes(content[:128] + tag + b"x\x9c" + bytes(6))
    with pytest.raises(RecordingError, match=r"does not unfold \(Error -3"):
        read_table(tmp_path / "r.mat")


def test_structures_in_structures_end_somewhere(tmp_path: Path) -> None:
    saved(tmp_path / "r.mat", run=inner(DEEPEST - 1))
    assert tables_in(tmp_path / "r.mat")[0].startswith("run.a.a")
    saved(tmp_path / "r.mat", run=inner(DEEPEST + 1))
    with pytest.raises(RecordingError, match=rf"holds more than {DEEPEST} levels of structures"):
        tables_in(tmp_path / "r.mat")
