"""Files on which the libraries of HDF5 and MDF end or hang are a sentence, and cost a look by another process."""

from __future__ import annotations

import logging
import os
import signal
import struct
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import h5py
import numpy as np
import pytest

from tests.lab_files import WRITERS
from tests.small_campaign import recorded
from undertow.errors import RecordingError
from undertow.recording import file_child, file_guard, hdf5
from undertow.recording.file_guard import Guard
from undertow.recording.readers import read_table, tables_in

GONE = r"r\.h5 is damaged: the library that reads HDF5 does not come to an end with it; copy the file again"


@pytest.fixture
def sound(tmp_path: Path) -> Path:
    """A file with units, which are texts of any length: they lie in a heap of their own."""
    t, x, a = recorded(0.04, 0)[:200].T
    WRITERS["r.h5"](tmp_path / "r.h5", t, {"disp": (x, "m"), "acc": (a, "m/s^2")})
    return tmp_path / "r.h5"


def endless(path: Path) -> None:
    """Free space of no size in the heap of texts, by which the library steps on for ever."""
    content = bytearray(path.read_bytes())
    at = content.index(b"GCOL")
    (size,) = struct.unpack_from("<Q", content, at + 8)
    first = struct.pack("<HHIQ", 1, 0, 0, 1) + b"s".ljust(8, b"\0")
    content[at + 16 : at + size] = first + bytes(size - 16 - len(first))
    path.write_bytes(content)


def test_a_sound_file_is_looked_at_once(sound: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    own = Guard._ask
    monkeypatch.setattr(Guard, "_ask", lambda guard, path: asked.append(path) or own(guard, path))
    assert len(read_table(sound)) == 200
    assert tables_in(sound) == ("trial",)
    assert asked == [str(sound)]
    os.utime(sound, ns=(1, 1))
    read_table(sound)
    assert len(asked) == 2


def test_a_file_that_hangs_the_library_is_refused(sound: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    endless(sound)
    quick = Path(sound.parent / "quick.py")
    quick.write_text(file_guard.CHILD.read_text().replace("BYTES_A_SECOND = 5.0", "BYTES_A_SECOND = 1.0"))
    guard = Guard(command=(sys.executable, "-P", str(quick), "HDF5"))
    monkeypatch.setattr("undertow.recording.hdf5.HDF5_GUARD", guard)
    asked: list[str] = []
    own = Guard._ask
    monkeypatch.setattr(Guard, "_ask", lambda guard, path: asked.append(path) or own(guard, path))
    for work in (read_table, tables_in):
        with pytest.raises(RecordingError, match=GONE):
            work(sound)
    assert len(asked) == 1  # it takes its time once
    guard.close()


def test_a_process_that_ended_is_started_again(sound: Path) -> None:
    guard = Guard()
    guard.check(sound)
    process = guard._process
    assert process is not None
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    os.utime(sound, ns=(2, 2))
    guard.check(sound)
    assert guard._process is not None
    assert guard._process.pid != process.pid
    guard.close()
    assert guard._process is None


def test_a_process_that_was_begun_is_the_one_that_is_asked(sound: Path) -> None:
    guard = Guard()
    guard.begin()
    begun = guard._process
    guard.begin()
    guard.check(sound)
    assert begun is not None
    assert guard._process is begun
    guard.close()


@pytest.mark.parametrize("command", [("no_such_program",), (sys.executable, "-c", "import no_such_library")])
def test_where_no_process_can_be_started_files_are_read_without(sound: Path, command: tuple[str, ...]) -> None:
    guard = Guard(command=command)
    guard.check(sound)
    guard.check(sound)
    assert not guard._able


def test_a_process_that_ends_on_a_file_says_so(sound: Path) -> None:
    guard = Guard(command=(sys.executable, "-c", "print('ready', flush=True); input()"))
    with pytest.raises(RecordingError, match=GONE):
        guard.check(sound)
    with pytest.raises(FileNotFoundError, match=r"none\.h5"):
        guard.check(sound.with_name("none.h5"))


def test_the_look_ends_with_its_input_and_survives_what_is_no_file(sound: Path, tmp_path: Path) -> None:
    (tmp_path / "text.h5").write_text("no HDF5")
    lines = "".join(f'"{path}"\n' for path in (sound, tmp_path / "text.h5", tmp_path / "none.h5"))
    done = subprocess.run(
        [sys.executable, "-P", str(file_guard.CHILD), "HDF5"], input=lines, capture_output=True, text=True, timeout=60
    )
    assert done.stdout.split() == ["ready", "seen", "seen", "seen"]
    assert done.returncode == 0


def test_the_look_touches_what_a_reader_may(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "r.h5"
    with h5py.File(path, "w") as file:
        file.attrs["by"] = "me"
        group = file.create_group("a/b")
        group["x"] = np.arange(9.0)
        group["x"].attrs["unit"] = "m"
        group.create_dataset("long", shape=(10**9,), dtype="f8", chunks=(1000,))
        group["self"] = group
        file["out"] = h5py.ExternalLink("other.h5", "/x")
    seen: list[str] = []
    attributes, values = file_child._attributes, file_child._values
    monkeypatch.setattr(file_child, "_attributes", lambda node: seen.append(node.name) or attributes(node))
    monkeypatch.setattr(file_child, "_values", lambda node: seen.append(f"{node.name} values") or values(node))
    file_child.look_at_hdf5(str(path))
    assert {"/", "/a", "/a/b", "/a/b/x", "/a/b/x values", "/a/b/long values"} <= set(seen)
    assert len(seen) < 10 * file_child.DEEPEST  # a group within itself


@pytest.mark.parametrize("kind", ["in another file", "put together", "texts", "chunks of 4 GB"])
def test_the_look_leaves_values_alone_that_lie_elsewhere_or_are_too_large(tmp_path: Path, kind: str) -> None:
    with h5py.File(tmp_path / "r.h5", "w") as file:
        if kind == "in another file":
            node = file.create_dataset("x", (8,), dtype="f8", external=[("other.bin", 0, 64)])
        elif kind == "put together":
            layout = h5py.VirtualLayout(shape=(8,), dtype="f8")
            layout[:] = h5py.VirtualSource("other.h5", "x", shape=(8,))
            node = file.create_virtual_dataset("x", layout)
        elif kind == "texts":
            node = file.create_dataset("x", data=["a", "b"], dtype=h5py.string_dtype())
        else:
            node = file.create_dataset("x", (5 * 10**8,), dtype="f8", chunks=(5 * 10**8,))
        shape = ("shape", "size", "dtype", "chunks", "external", "is_virtual")
        file_child._values(Unread(**{name: getattr(node, name) for name in shape}))


class Unread(SimpleNamespace):
    """A dataset whose values nobody may read."""

    def __getitem__(self, place: object) -> None:
        raise AssertionError(f"values are read at {place}")


def test_the_look_limits_its_memory_before_it_begins(monkeypatch: pytest.MonkeyPatch) -> None:
    done: list[str] = []
    monkeypatch.setattr(file_child, "limit_memory", lambda: done.append("limited"))
    monkeypatch.setattr("builtins.print", lambda text, flush: done.append(text))
    monkeypatch.setattr("sys.stdin", [])
    monkeypatch.setattr("sys.argv", ["file_child.py", "HDF5"])
    file_child.main()
    assert done == ["limited", "ready"]
    logging.disable(logging.NOTSET)


@pytest.mark.skipif(sys.platform != "linux", reason="memory is limited where /proc tells how much there is")
def test_the_limit_of_memory_holds() -> None:
    code = f"import runpy; runpy.run_path({str(file_guard.CHILD)!r})['limit_memory'](); bytearray(2_100_000_000)"
    done = subprocess.run([sys.executable, "-P", "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    assert "MemoryError" in done.stderr


def test_a_copy_of_this_process_asks_a_process_of_its_own(sound: Path) -> None:
    guard = Guard()
    guard.check(sound)
    first = guard._process
    assert first is not None
    guard._owner = -1  # as in a process that was forked
    os.utime(sound, ns=(2, 2))
    guard.check(sound)
    assert guard._process is not None
    assert guard._process.pid != first.pid
    assert first.poll() is None  # it still serves the process that started it
    guard.close()
    first.kill()
    first.communicate()


def test_a_file_that_ends_the_process_is_asked_for_once(sound: Path, tmp_path: Path) -> None:
    asked = tmp_path / "asked"
    code = f"print('ready', flush=True); open({str(asked)!r}, 'a').write(input())"
    guard = Guard(command=(sys.executable, "-c", code))
    with pytest.raises(RecordingError, match=GONE):
        guard.check(sound)
    assert asked.read_text().count("r.h5") == 1


@pytest.fixture
def measured(tmp_path: Path) -> Path:
    """An MDF file with a clock and two channels, 24 bytes a record."""
    t, x, a = recorded(0.04, 0)[:200].T
    WRITERS["r.mf4"](tmp_path / "r.mf4", t, {"disp": (x, "m"), "acc": (a, "m/s^2")})
    return tmp_path / "r.mf4"


def changed_block(path: Path, kind: bytes, at: int, value: int, size: str, number: int = 0) -> None:
    """An MDF file's block of a kind with another value ``at`` bytes after its links."""
    content, found = bytearray(path.read_bytes()), -1
    for _ in range(number + 1):
        found = content.index(b"##" + kind, found + 1)
    (links,) = struct.unpack_from("<Q", content, found + 16)
    struct.pack_into(size, content, found + 24 + 8 * links + at, value)
    path.write_bytes(content)


@pytest.mark.parametrize("number", [0, 1, 2])
@pytest.mark.parametrize("first_byte", [17, 24, 2**24, 2**32 - 1])
def test_a_channel_beyond_its_record_is_damage_and_no_memory_is_read(
    measured: Path, number: int, first_byte: int
) -> None:
    changed_block(measured, b"CN", 4, first_byte, "<I", number)
    said = r"r\.mf4 is damaged: (channel '\w+' ends at byte \d+ of records of 24 bytes|the library that reads MDF)"
    with pytest.raises(RecordingError, match=said):
        read_table(measured)


def test_records_shorter_than_their_channels_are_damage(measured: Path) -> None:
    changed_block(measured, b"CG", 24, 23, "<I")
    with pytest.raises(RecordingError, match=r"channel 'acc' ends at byte 24 of records of 23 bytes; copy the file"):
        read_table(measured)


def test_a_mark_of_invalid_values_beyond_the_record_is_damage(tmp_path: Path) -> None:
    import asammdf

    t = 0.01 * np.arange(50.0)
    marks = np.arange(50) > 44
    with asammdf.MDF(version="4.10") as file:
        signal = asammdf.Signal(np.sin(t), t, name="x", invalidation_bits=marks)
        file.append([signal])
        path = Path(file.save(tmp_path / "r.mf4"))
    whole = path.read_bytes()
    sound = read_table(path)["x"].to_numpy()
    np.testing.assert_array_equal(np.isnan(sound), marks)  # a gap, as an empty cell
    np.testing.assert_array_equal(sound[~marks], np.sin(t)[~marks])
    for number in range(whole.count(b"##CN")):
        path.write_bytes(whole)
        changed_block(path, b"CN", 16, 2**20, "<I", number)  # a bit's place, where values are marked at all
        try:
            table = read_table(path)
        except RecordingError as error:
            assert "is damaged: channel 'x' ends at byte 16 of records of 16 bytes" in str(error)  # noqa: PT017
        else:
            assert len(table) == 50


def test_a_channel_of_texts_is_no_channel(measured: Path) -> None:
    changed_block(measured, b"CN", 2, 7, "<B", 2)
    assert list(read_table(measured).columns) == ["time", "disp"]
    with pytest.raises(RecordingError, match=r"channel 'acc' holds texts or bytes; only numbers are read"):
        read_table(measured, columns=["acc"])


def test_an_mdf_file_whose_links_go_in_a_circle_is_refused(measured: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    changed_block(measured, b"HD", -48, measured.read_bytes().index(b"##HD"), "<Q")  # its first data group: itself
    quick = measured.with_name("quick.py")
    quick.write_text(file_guard.CHILD.read_text().replace("BYTES_A_SECOND = 5.0", "BYTES_A_SECOND = 1.0"))
    guard = Guard("MDF", (sys.executable, "-P", str(quick), "MDF"))
    monkeypatch.setattr("undertow.recording.mdf.MDF_GUARD", guard)
    with pytest.raises(RecordingError, match=r"the library that reads MDF does not come to an end with it; copy the"):
        read_table(measured)
    guard.close()


@pytest.mark.parametrize("version", ["2.14", "3.30", "4.20"])
def test_older_versions_of_mdf_are_read_as_they_were_written(tmp_path: Path, version: str) -> None:
    import asammdf

    t = 0.01 * np.arange(50.0)
    names = np.array([b"ab"] * t.size)
    columns = {"x": np.sin(t), "count": np.arange(50, dtype="u1"), "gate": np.arange(50, dtype="u2") % 2, "n": names}
    signals = [asammdf.Signal(v, t, name=key, encoding="utf-8" if key == "n" else None) for key, v in columns.items()]
    with asammdf.MDF(version=version) as file:
        file.append(signals)
        path = file.save(tmp_path / ("r.mf4" if version > "4" else "r.mdf"))
    table = read_table(Path(path))
    assert list(table.columns) == ["time", "x", "count", "gate"]
    np.testing.assert_array_equal(table["x"], columns["x"])
    np.testing.assert_array_equal(table["count"], columns["count"])


def test_the_look_at_an_mdf_file_reads_the_first_record_of_a_long_one(
    measured: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    import asammdf

    counts: list[object] = []
    own = asammdf.MDF.get
    monkeypatch.setattr(asammdf.MDF, "get", lambda *a, **more: counts.append(more["record_count"]) or own(*a, **more))
    file_child.look_at_mdf(str(measured))
    monkeypatch.setattr(file_child, "WHOLE_BYTES", 100)
    file_child.look_at_mdf(str(measured))
    assert counts == [None] * 3 + [1] * 3


def test_the_look_goes_as_far_as_the_reader() -> None:
    """A script that imports nothing of the package states the reader's limits again."""
    assert file_child.OBJECTS_AT_MOST == hdf5.OBJECTS_AT_MOST
    assert file_child.DEEPEST == hdf5.DEEPEST
