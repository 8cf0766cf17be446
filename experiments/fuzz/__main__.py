"""Every reader given its own kind of file with changed, lost, doubled and foreign bytes, for a time.

    python -m experiments fuzz [SECONDS [FILE ...]]

writes fuzz.md and fuzz.csv: files a reader was given, how many it read and refused, the longest and the largest. Each
reader works in a child process that may have `LARGEST_MB` more than it has after its first file, and `LONGEST_S` of
processor time a file. What ends a child (a crash, its memory, its time), or an error that is none of undertow's, is
kept in `fuzz_found` for a test.

Belongs here: changes, children, the page. Does not belong here: files as they should be (tests/lab_files.py).
"""

from __future__ import annotations

import gc
import gzip
import io
import multiprocessing
import resource
import sys
import tempfile
import time
import traceback
import zipfile
from collections.abc import Callable
from dataclasses import asdict, dataclass, fields
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
import scipy.io

from experiments.files import read_rows, write_rows
from experiments.processor_time import spent
from experiments.revision import revision
from tests.lab_files import WRITERS, write_csv
from tests.small_campaign import recorded
from undertow.errors import UndertowError
from undertow.recording.index import read_index
from undertow.recording.propose_file import propose_file
from undertow.recording.readers import read_table, tables_in

HERE = Path(__file__).resolve().parent
FOUND = HERE / "fuzz_found"
SECONDS = 600.0
LONGEST_S, LARGEST_MB = 30.0, 2000.0
LONGEST_WAIT_S = 300.0
"""A child that waits and computes nothing hangs; on a busy machine it may wait for its turn."""

SAMPLES = 200
"""Of the recording: a short file has a larger share of structure, where changes matter."""

LENGTHS_4, LENGTHS_8 = (0, 1, 2**31 - 1, 2**32 - 1, 2**16, 2**24), (0, 2**63 - 1, 2**64 - 1, 2**40)
"""What a field of four or eight bytes may say of a length."""


@dataclass
class Score:
    """What a reader was given and did with it; ``wrong`` are files kept in `FOUND`."""

    file: str
    seconds: float = 0.0
    given: int = 0
    read: int = 0
    refused: int = 0
    wrong: int = 0
    longest_s: float = 0.0
    largest_mb: float = 0.0
    revision: str = ""


def changed(whole: bytes, rng: np.random.Generator) -> bytes:
    """A file with one to eight changes of one kind each."""
    out = bytearray(whole)
    for _ in range(int(rng.integers(1, 9))):
        at = int(rng.integers(0, max(len(out), 1)))
        at = at if rng.random() < 0.5 else at % min(len(out) or 1, 600)  # headers
        length = int(2.0 ** rng.uniform(0.0, 8.0))
        kind = int(rng.integers(0, 7))
        if kind == 0:
            out[at : at + 1] = rng.bytes(1)
        elif kind == 1:
            out[at : at + 1] = bytes([(out[at] ^ (1 << int(rng.integers(0, 8)))) if out else 0])
        elif kind == 2:
            del out[at : at + length]
        elif kind == 3:
            out[at:at] = out[at : at + length] * int(rng.integers(1, 4))
        elif kind == 4:
            out[at : at + 4] = LENGTHS_4[int(rng.integers(0, len(LENGTHS_4)))].to_bytes(4, "little")
        elif kind == 5:
            out[at : at + 8] = LENGTHS_8[int(rng.integers(0, len(LENGTHS_8)))].to_bytes(8, "little")
        else:
            del out[at:]
    return bytes(out)


def changed_inside(whole: bytes, rng: np.random.Generator) -> bytes:
    """A packed file whose content was changed before it was packed: its checksums hold, and its parser is reached."""
    if not zipfile.is_zipfile(io.BytesIO(whole)):
        return gzip.compress(changed(gzip.decompress(whole), rng), compresslevel=1)
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(whole)) as old, zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as new:
        names = old.namelist()
        hit = names[int(rng.integers(0, len(names)))]
        for name in names:
            new.writestr(name, changed(old.read(name), rng) if name == hit else old.read(name))
    return out.getvalue()


def write_gzip(path: Path) -> None:
    """Text, packed."""
    t, x, a = recorded(0.04, 0)[:SAMPLES].T
    write_csv(path, t, {"disp": (x, "m"), "acc": (a, "m/s^2")})
    path.write_bytes(gzip.compress(path.read_bytes()))


def whole(name: str, folder: Path) -> bytes:
    """A file of a kind as it should be."""
    t, x, a = recorded(0.04, 0)[:SAMPLES].T
    path = folder / name
    if name.endswith(".gz"):
        write_gzip(path)
    elif name == "plain.mat":
        scipy.io.savemat(path, {"run": {"time": t, "disp": x, "cells": np.array([x, "m"], dtype=object)}, "acc": a})
    else:
        WRITERS[name](path, t, {"disp": (x, "m"), "acc": (a, "m/s^2")})
    return path.read_bytes()


FILES = (*WRITERS, "r.csv.gz", "plain.mat")
PACKED = (".xlsx", ".gz")


def used(path: Path) -> bool:
    """Whether a file could be read by all that read it: its table, its tables' names, what is proposed for it."""
    sound = True
    for work in (read_table, tables_in, propose_file, *((_index,) if path.suffix == ".xlsx" else ())):
        sound &= _done(work, path)
    return sound


def _index(path: Path) -> object:
    """A workbook as the index of a campaign."""
    return list(read_index(path).rows())


def _done(work: Callable[[Path], object], path: Path) -> bool:
    try:
        work(path)
    except UndertowError as error:
        if not str(error) or len(str(error)) > 4000:
            raise AssertionError(f"no sentence: {str(error)[:100]!r}") from error
        return False
    return True


def child(pipe: Connection, folder: str) -> None:
    """Read the file that each name over the pipe says, and answer: read, refused, or a traceback."""
    sys.stderr = sys.stdout = open("/dev/null", "w")  # noqa: SIM115 - libraries that print
    first = True
    while name := pipe.recv():
        try:
            said = "read" if used(Path(folder) / name) else "refused"
        except BaseException:  # noqa: BLE001 - what a user would see as a traceback
            said = traceback.format_exc()
        if first:
            has = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
            most = has + round(LARGEST_MB * 1e6)
            resource.setrlimit(resource.RLIMIT_AS, (most, most))
            gc.freeze()  # a reader that searches memory after damage need not look at what was imported
        first = False
        pipe.send((said, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000.0))


class Reader:
    """A child at work in a folder; another one where it ends."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._start()

    def _start(self) -> None:
        self._pipe, other = multiprocessing.Pipe()
        self._process = multiprocessing.get_context("fork").Process(target=child, args=(other, str(self._folder)))
        self._process.start()
        other.close()

    def say(self, name: str) -> tuple[str, float]:
        """What the child says of a file, and its peak memory in MB."""
        self._pipe.send(name)
        if self._answers():
            try:
                answer: tuple[str, float] = self._pipe.recv()
                return answer
            except EOFError:
                said = "the child ended"
        else:
            said = f"more than {LONGEST_S:g} s"
        self._process.kill()
        self._process.join()
        self._start()
        return said, 0.0

    def _answers(self) -> bool:
        """Whether the child answers within `LONGEST_S` of its own processor time, waiting included `LONGEST_WAIT_S`."""
        child = self._process.pid or 0
        before, begun = spent(child), time.perf_counter()
        while not self._pipe.poll(0.5):
            if spent(child) - before > LONGEST_S or time.perf_counter() - begun > LONGEST_WAIT_S:
                return False
        return True

    def end(self) -> None:
        """End the child."""
        self._process.kill()
        self._process.join()


def fuzz(name: str, seconds: float, seed: int) -> Score:
    """Files of one kind for so many seconds."""
    score, rng = Score(name, revision=revision()), np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch)
        sound = whole(name, folder)
        reader = Reader(folder)
        if (said := reader.say(name)[0]) not in ("read", "refused"):  # a title above a sheet needs its layout
            raise SystemExit(f"{name} as it should be: {said}")
        begun = time.perf_counter()
        while (now := time.perf_counter()) - begun < seconds:
            inside = name.endswith(PACKED) and rng.random() < 0.7
            content = changed_inside(sound, rng) if inside else changed(sound, rng)
            (folder / name).write_bytes(content)
            said, megabytes = reader.say(name)
            score.longest_s = max(score.longest_s, time.perf_counter() - now)
            score.largest_mb = max(score.largest_mb, megabytes)
            score.given += 1
            score.read += said == "read"
            score.refused += said == "refused"
            if said not in ("read", "refused"):
                score.wrong += 1
                keep(name, content, said, score.wrong)
        score.seconds = time.perf_counter() - begun
        reader.end()
    return score


def keep(name: str, content: bytes, said: str, number: int) -> None:
    """A file that ended a reader, and how; the first three of a kind."""
    print(f"{name}: {said.strip().splitlines()[-1]}", flush=True)
    if number <= 3:
        FOUND.mkdir(exist_ok=True)
        (FOUND / f"{number}_{name}").write_bytes(content)
        (FOUND / f"{number}_{name}.said").write_text(said)


def main() -> None:
    """All readers, or those named, one after the other."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else SECONDS
    results = HERE / "fuzz.csv"
    rows = {row["file"]: row for row in read_rows(results)}
    for seed, name in enumerate(sys.argv[2:] or FILES):
        score = fuzz(name, seconds, seed + int(time.time()))
        print(score, flush=True)
        rows[name] = {key: f"{v:.2f}" if isinstance(v, float) else str(v) for key, v in asdict(score).items()}
        write_rows(results, [field.name for field in fields(Score)], rows.values())
    write_page(list(rows.values()))


HEAD = f"""\
# Readers given files with changed bytes

    python -m experiments fuzz 600

Ten minutes a reader is the command's default; the seconds that were run stand in the table. Each file has one to eight
changes: bytes, bits, lost and doubled stretches, lengths of 0 to 2^64, a cut; half of them in the first 600 bytes. In
.xlsx and .gz seven of ten files are changed before they are packed, so that their checksums hold. A reader reads the
table, the names of the tables, and what `init` proposes; .xlsx are read as an index besides, which this sheet is not:
none counts as read. *Wrong*: a crash, another error than undertow's, over
{LONGEST_S:g} s of processor time or over {LARGEST_MB:g} MB more than it has to begin with.

| file | s | given | read | refused | wrong | longest, s | peak of the process, MB | revision |
|---|---|---|---|---|---|---|---|---|
"""


def write_page(rows: list[dict[str, str]]) -> None:
    """fuzz.md, from fuzz.csv."""
    lines = [
        f"| {r['file']} | {float(r['seconds']):.0f} | {r['given']} | {r['read']} | {r['refused']} | {r['wrong']} | "
        f"{float(r['longest_s']):.1f} | {float(r['largest_mb']):.0f} | {r['revision']} |"
        for r in rows
    ]
    (HERE / "fuzz.md").write_text(HEAD + "\n".join(lines) + "\n")
