"""A run that searches, killed (SIGKILL, its process alone) at random moments, every fourth one twice, then resumed.

    python -m experiments kills [KILLED [FIRST_SEED]]

adds rows to kills.csv and writes kills.md: whether the tables of the resumed run are the bytes of an uninterrupted one,
whether every part that was finished is kept as it was, and how much work was lost: the seconds between the last
finished part (or the start) and the kill. Every twentieth run is the whole command on two processes, killed by the
clock; the others run in a copy of this process, which has imported everything, without the page, and are killed by
their processor time, so that most kills hit a search.

Belongs here: the campaign, kills, the comparison. Does not belong here: parts (undertow.campaign.run.checkpoints).
"""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from experiments.eq15_campaign.motion import hold_and_release
from experiments.files import read_rows, write_rows
from experiments.processor_time import spent
from experiments.revision import revision
from tests.small_campaign import BODY, HOLD_S, RATE_HZ, Campaign, Table, make_campaign, write_table
from undertow.campaign.run import folder as run_folder

HERE = Path(__file__).resolve().parent
RESULTS, PAGE = HERE / "kills.csv", HERE / "kills.md"
KILLED = 100
ON_TWO, TWICE = 20, 4
"""Every so many runs one on two processes, and one that is killed twice."""
POLL_S = 0.002
SPRINGS = ("a", "b", "c")
RELEASES_M = (0.03, 0.045, 0.06)
MOTION_S = 3.0
DRAG_NS2_PER_M2 = 2500.0
"""What the equation leaves out, so that every search has something to find."""
NOISE_M, NOISE_M_PER_S2 = 1e-4, 2e-2
SUSPECTS = ("cubic_stiffness", "linear_damping", "quadratic_drag", "hidden_resonator")
SCATTER = "  scatter: {k: 0.003, c: 0.06, mu: 0.05}\n"
TABLES = ("trials.csv", "levels.csv", "mismatch.csv", "verdict.json", "config.yaml")
COLUMNS = (
    "seed", "jobs", "kills", "after_s", "parts_of", "parts_at_kill", "parts_kept", "lost_s", "exit_code", "same_tables",
    "revision",
)  # fmt: skip


def campaign(folder: Path) -> Campaign:
    """Three springs, each searched for what is missing: six parts, of which three are searches."""
    made = make_campaign(folder, RELEASES_M, SPRINGS)
    made.edit("suspects: []", f"suspects: [{', '.join(SUSPECTS)}]")
    made.edit("  mass_kg: 2637.4\n", f"  mass_kg: 2637.4\n{SCATTER}")
    for seed, name in enumerate(made.files):
        write_table(folder / name, with_drag(RELEASES_M[seed % len(RELEASES_M)], seed))
    return made


def with_drag(x0_m: float, seed: int) -> Table:
    """A release of a body that has drag: time in s, displacement in m, acceleration in m/s2, (n, 3)."""
    rng = np.random.default_rng(seed)
    time = np.arange(round((HOLD_S + MOTION_S) * RATE_HZ)) / RATE_HZ
    motion = hold_and_release(replace(BODY, drag_Ns2_per_m2=DRAG_NS2_PER_M2), x0_m, time - HOLD_S)
    noise = rng.standard_normal((2, time.size))
    return np.column_stack([time, motion.x + NOISE_M * noise[0], motion.a + NOISE_M_PER_S2 * noise[1]])


def start(made: Campaign, out: Path, jobs: int, resume: bool = False) -> int:
    """A run in a process of its own, its number: the command on two processes; on one, a copy of this process."""
    if jobs > 1:
        words = ["run", str(made.config), "--out", str(out), "--jobs", str(jobs), *(["--resume"] if resume else [])]
        return subprocess.Popen(
            [sys.executable, "-m", "undertow", *words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        ).pid
    sys.stdout.flush()
    if child := os.fork():
        return child
    try:
        run_here(made, out, resume)
        os._exit(0)
    finally:
        os._exit(1)


def run_here(made: Campaign, out: Path, resume: bool = False) -> None:
    """A run on one process, this one, without the page."""
    run_folder.write_report = lambda findings, new, *more: None  # type: ignore[assignment]
    run_folder.run_to_folder(made.config, out=out, jobs=1, resume=resume)


def used_s(process: int, jobs: int, begun: float) -> float:
    """Processor time of a process (other work on the machine does not count); with workers, seconds since it began."""
    return time.perf_counter() - begun if jobs > 1 else spent(process)


def ended(process: int) -> int:
    """Exit code of a process, waited for."""
    return os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])


def kill_after(process: int, jobs: int, after_s: float) -> None:
    """Wait until a process has used so much time, and kill it, unless it has ended."""
    begun = time.perf_counter()
    while not os.waitid(os.P_PID, process, os.WEXITED | os.WNOHANG | os.WNOWAIT):
        if used_s(process, jobs, begun) >= after_s:
            os.kill(process, signal.SIGKILL)
            break
        time.sleep(POLL_S)
    ended(process)


def tables(out: Path) -> dict[str, bytes]:
    """What an uninterrupted run and a resumed one must share."""
    return {name: (out / name).read_bytes() for name in TABLES}


def parts(out: Path) -> dict[str, int]:
    """Finished parts and when each was written, ns."""
    return {path.name: path.stat().st_mtime_ns for path in (out / "stages").glob("*.json")}


def killed(made: Campaign, whole: Path, whole_s: Mapping[int, float], seed: int) -> dict[str, object]:
    """One run, killed once or twice and resumed: a row of kills.csv."""
    rng = np.random.default_rng(seed)
    jobs, times = 2 if seed % ON_TWO == 0 else 1, 2 if seed % TWICE == 1 else 1
    out = made.folder / f"run{seed}"
    moments, kept, had, lost = [], True, 0, 0.0
    for attempt in range(times):
        after = float(rng.uniform(0.0, whole_s[jobs]))
        before, begun = parts(out), time.time_ns()
        kill_after(start(made, out, jobs, bool(attempt)), jobs, after)
        now = parts(out)
        kept &= all(now.get(name) == at for name, at in before.items())
        had, moments = len(now), [*moments, after]
        lost = max(lost, (time.time_ns() - max([begun, *now.values()])) / 1e9)
    before = parts(out)
    code = ended(start(made, out, jobs, True))
    now = parts(out)
    kept &= all(now.get(name) == at for name, at in before.items())
    row = {
        "seed": seed, "jobs": jobs, "kills": times, "after_s": " ".join(f"{m:.2f}" for m in moments),
        "parts_of": len(now), "parts_at_kill": had, "parts_kept": kept, "lost_s": f"{lost:.1f}", "exit_code": code,
        "same_tables": code == 0 and tables(out) == tables(whole), "revision": revision(),
    }  # fmt: skip
    shutil.rmtree(out)
    return row


def main() -> None:
    """Kill, resume, compare, write."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else KILLED
    first = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    with tempfile.TemporaryDirectory() as scratch:
        made = campaign(Path(scratch) / "campaign")
        run_here(made, made.folder / "warm")
        begun = time.process_time()
        run_here(made, made.folder / "whole1")
        whole_s = {1: time.process_time() - begun}
        begun = time.perf_counter()
        if ended(start(made, made.folder / "whole2", 2)) != 0 or len(tables(made.folder / "whole2")) != len(TABLES):
            raise SystemExit("the uninterrupted run failed")
        whole_s[2] = time.perf_counter() - begun
        print(f"uninterrupted: {whole_s} s, {len(parts(made.folder / 'whole1'))} parts", flush=True)
        for seed in range(first, first + count):
            add(killed(made, made.folder / "whole1", whole_s, seed))
            write_page(whole_s[1])


def add(row: dict[str, object]) -> None:
    """One more row of kills.csv, in place of an older one of its seed."""
    rows = [one for one in read_rows(RESULTS) if one["seed"] != str(row["seed"])]
    write_rows(RESULTS, COLUMNS, sorted([*rows, row], key=lambda one: int(str(one["seed"]))))
    print(row, flush=True)


def write_page(whole_s: float) -> None:
    """kills.md, from kills.csv."""
    rows = read_rows(RESULTS)
    same, kept = (sum(row[name] == "True" for row in rows) for name in ("same_tables", "parts_kept"))
    some = sum(0 < int(row["parts_at_kill"]) < int(row["parts_of"]) for row in rows)
    lost = sorted(float(row["lost_s"]) for row in rows)
    revisions = ", ".join(dict.fromkeys(row["revision"] for row in rows))
    PAGE.write_text(f"""\
# Runs killed at random moments

    python -m experiments kills {len(rows)}

| | |
|---|---|
| runs killed (one in {TWICE} twice; one in {ON_TWO} on two processes) | {len(rows)} |
| resumed to the end, tables the bytes of an uninterrupted run | {same} |
| every part that was finished kept as it was | {kept} |
| killed with some parts finished and others not | {some} |
| seconds between the last finished part (or the start) and the kill: median, largest | {lost[len(lost) // 2]:.1f}, \
{lost[-1]:.1f} |
| processor time of the uninterrupted run without imports and page, s | {whole_s:.1f} |
| revision | {revisions} |

A kill before the first part loses reading and that part; one after the last loses the tables. `kills.csv` has a row a
run. The campaign has {len(SPRINGS)} springs of {len(RELEASES_M)} trials with a drag that the equation lacks, each
searched over {', '.join(SUSPECTS)}. The clock of the lost seconds runs on while other work has the cores.
""")
