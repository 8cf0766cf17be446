"""The runner: it is given the laboratories alone, runs the command line on each, and keeps what came out, one row a
case.

A worker process runs `undertow run config.yaml --jobs 1` as a user's shell would, but keeps the interpreter; a campaign
that takes more processor time than the limit is stopped and its row says so. The program is whatever `python -m
undertow` is on the path.
"""

import contextlib
import json
import multiprocessing
import os
import runpy
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from pathlib import Path

from experiments.processor_time import spent

LIMIT = 300.0  # seconds of processor time after which a campaign is taken to hang; one over 60 s is reported (score.py)
WARM = 600.0  # the first campaign of a worker: it compiles
WAIT = 10.0  # times as long may pass: a process that waits and computes nothing hangs
TAIL = 1500  # characters of the messages that a row keeps


@dataclass
class Worker:
    """A process that runs campaigns, the pipe to it, and what it is at."""

    process: multiprocessing.process.BaseProcess
    pipe: Connection
    case: str = ""
    started: float = 0.0
    spent_before: float = 0.0
    limit: float = LIMIT
    log: Path = field(default_factory=Path)


def revision(root: Path) -> str:
    """The commit that is checked out, with `+changes` where files of src differ from it."""
    head = subprocess.run(
        ["git", "rev-parse", "HEAD"], cwd=root, capture_output=True, text=True, check=True
    ).stdout.strip()
    changed = subprocess.run(
        ["git", "status", "--porcelain", "--", "src"], cwd=root, capture_output=True, text=True, check=True
    )
    return head + ("+changes" if changed.stdout.strip() else "")


def _exit_code(stop: SystemExit) -> int:
    """The number a shell would see."""
    if stop.code is None:
        return 0
    return stop.code if isinstance(stop.code, int) else 1


def _campaign(config: str, out: str, log: str, module: str) -> int:
    """Run the program's command in this process; its exit code. Messages go to `log`."""
    sys.argv = [module, "run", config, "--out", out, "--jobs", "1", "--no-page"]
    with (
        open(log, "w", encoding="utf-8") as stream,
        contextlib.redirect_stdout(stream),
        contextlib.redirect_stderr(stream),
    ):
        try:
            runpy.run_module(module, run_name="__main__", alter_sys=True)
        except SystemExit as stop:
            return _exit_code(stop)
    return 0


def _serve(pipe: Connection, module: str) -> None:
    """A worker's life: one campaign after the other until it is told None."""
    while (job := pipe.recv()) is not None:
        began = spent(os.getpid())
        try:
            code = _campaign(*job, module)
        except BaseException as problem:  # noqa: BLE001 (a crash of the program is a result and is written down)
            with open(job[2], "a", encoding="utf-8") as stream:
                stream.write(f"\n{type(problem).__name__}: {problem}")
            code = 1
        pipe.send((code, spent(os.getpid()) - began))


def _hire(module: str, limit: float) -> Worker:
    """A new worker, with the limit of its first campaign."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_serve, args=(theirs, module), daemon=True)
    process.start()
    return Worker(process, ours, limit=limit)


def _verdict(folder: Path) -> object:
    """What the run folder says, None where it says nothing."""
    path = folder / "verdict.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else None


def _row(worker: Worker, runs: Path, code: int | None, seconds: float, mark: dict[str, object]) -> dict[str, object]:
    """One row: case, exit code (None: stopped), seconds, verdict, the last messages."""
    text = worker.log.read_text(encoding="utf-8") if worker.log.exists() else ""
    return {
        **mark,
        "case": worker.case,
        "exit": code,
        "stopped": code is None,
        "seconds": round(seconds, 3),
        "first_of_worker": worker.limit == WARM,
        "verdict": _verdict(runs / worker.case),
        "messages": text[-TAIL:],
    }


def _finished(workers: list[Worker]) -> Iterator[tuple[Worker, int | None, float]]:
    """Workers whose campaign has ended or has taken too long."""
    wait([w.pipe for w in workers], timeout=0.2)
    for worker in workers:
        computed = spent(worker.process.pid or 0) - worker.spent_before
        if worker.pipe.poll():
            try:
                code, seconds = worker.pipe.recv()
            except EOFError:
                code, seconds = 1, computed
            yield worker, code, seconds
        elif computed > worker.limit or time.perf_counter() - worker.started > WAIT * worker.limit:
            yield worker, None, computed


def _rid(worker: Worker) -> None:
    """End a worker that is stuck or has done."""
    if worker.process.is_alive():
        worker.process.kill()
    worker.process.join()
    worker.pipe.close()


def run(
    laboratories: Path, rows: Path, root: Path, jobs: int = 1, only: list[str] | None = None, module: str = "undertow"
) -> int:
    """Run every laboratory that has no row of this revision yet; rows are appended as they come. Returns how many were
    run.
    """
    mark: dict[str, object] = {"revision": revision(root), **_origin(laboratories)}
    done = {row["case"] for row in read_rows(rows) if all(row.get(k) == v for k, v in mark.items())}
    todo = [
        p.name
        for p in sorted(laboratories.iterdir())
        if p.is_dir() and p.name not in done and (only is None or p.name in only)
    ]
    runs = rows.parent / (rows.stem + "_runs")
    runs.mkdir(parents=True, exist_ok=True)
    workers: list[Worker] = []
    count, hired = 0, 0
    with rows.open("a", encoding="utf-8") as stream:
        while todo or workers:
            while todo and len(workers) < jobs:
                workers.append(_start(_hire(module, WARM if hired < jobs else LIMIT), todo.pop(0), laboratories, runs))
                hired += 1
            for worker, code, seconds in list(_finished(workers)):
                stream.write(json.dumps(_row(worker, runs, code, seconds, mark)) + "\n")
                stream.flush()
                count += 1
                shutil.rmtree(runs / worker.case, ignore_errors=True)
                workers.remove(worker)
                if code is None or not worker.process.is_alive() or not todo:
                    _rid(worker)
                else:
                    worker.limit = LIMIT
                    workers.append(_start(worker, todo.pop(0), laboratories, runs))
    shutil.rmtree(runs, ignore_errors=True)
    return count


def _start(worker: Worker, case: str, laboratories: Path, runs: Path) -> Worker:
    """Send the next campaign to a worker."""
    worker.case, worker.started, worker.log = case, time.perf_counter(), runs / f"{case}.log"
    worker.spent_before = spent(worker.process.pid or 0)
    config = laboratories / case / "config.yaml"
    worker.pipe.send((os.fspath(config.resolve()), os.fspath((runs / case).resolve()), os.fspath(worker.log.resolve())))
    return worker


def _origin(laboratories: Path) -> dict[str, object]:
    """Seed, number and digest of a challenge: nothing of its truth."""
    note = json.loads((laboratories / "challenge.json").read_text(encoding="utf-8"))
    return {key: note[key] for key in ("seed", "cases", "digest")}


def read_rows(path: Path) -> list[dict[str, object]]:
    """The rows of a file, none where there is no file."""
    if not path.exists():
        return []
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines() if line.strip()]
