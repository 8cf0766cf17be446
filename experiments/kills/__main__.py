"""A run that searches, killed (SIGKILL, its process alone) at random moments, every fourth one twice, then resumed.

    python -m experiments.kills [KILLED [FIRST_SEED]]

adds rows to kills.csv and writes kills.md: whether the tables of the resumed run are the bytes of an uninterrupted one,
whether every part that was finished is kept as it was, and how much work was lost: the seconds between the last
finished part (or the start) and the kill. Odd seeds run on two processes. 100 take some hours on two cores.

Belongs here: the campaign, kills, the comparison. Does not belong here: parts (undertow.campaign.run.checkpoints).
"""

from __future__ import annotations

import csv
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from tests.small_campaign import Campaign, make_campaign

HERE = Path(__file__).resolve().parent
RESULTS, PAGE = HERE / "kills.csv", HERE / "kills.md"
KILLED = 20
SPRINGS = ("a", "b", "c")
RELEASES_M = (0.03, 0.05)
SUSPECTS = ("cubic_stiffness", "linear_damping", "quadratic_drag")
TABLES = ("trials.csv", "levels.csv", "mismatch.csv", "verdict.json", "config.yaml")
COLUMNS = (
    "seed", "jobs", "kills", "after_s", "parts_of", "parts_at_kill", "parts_kept", "lost_s", "exit_code", "same_tables",
)  # fmt: skip


def campaign(folder: Path) -> Campaign:
    """Three springs, each searched for what is missing: six parts, of which three are searches."""
    made = make_campaign(folder, RELEASES_M, SPRINGS)
    made.edit("suspects: []", f"suspects: [{', '.join(SUSPECTS)}]")
    return made


def start(made: Campaign, out: Path, jobs: int, *more: str) -> subprocess.Popen[bytes]:
    """The command, in a process of its own."""
    words = ["run", str(made.config), "--out", str(out), "--jobs", str(jobs), *more]
    return subprocess.Popen(
        [sys.executable, "-m", "undertow", *words], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )


def tables(out: Path) -> dict[str, bytes]:
    """What an uninterrupted run and a resumed one must share."""
    return {name: (out / name).read_bytes() for name in TABLES}


def parts(out: Path) -> dict[str, int]:
    """Finished parts and when each was written, ns."""
    return {path.name: path.stat().st_mtime_ns for path in (out / "stages").glob("*.json")}


def killed(made: Campaign, whole: Path, whole_s: float, seed: int) -> dict[str, object]:
    """One run, killed once or twice and resumed: a row of kills.csv."""
    rng = np.random.default_rng(seed)
    jobs, times = 1 + seed % 2, 2 if seed % 4 == 0 else 1
    out = made.folder / f"run{seed}"
    moments, kept, had, lost = [], True, 0, 0.0
    for attempt in range(times):
        after = float(rng.uniform(0.0, whole_s))
        before, begun = parts(out), time.time_ns()
        process = start(made, out, jobs, *(["--resume"] if attempt else []))
        try:
            process.wait(after)
        except subprocess.TimeoutExpired:
            os.kill(process.pid, signal.SIGKILL)
            process.wait()
        now = parts(out)
        kept &= all(now.get(name) == at for name, at in before.items())
        had, moments = len(now), [*moments, after]
        lost = max(lost, (time.time_ns() - max([begun, *now.values()])) / 1e9)
    before = parts(out)
    code = start(made, out, jobs, "--resume").wait()
    now = parts(out)
    kept &= all(now.get(name) == at for name, at in before.items())
    return {
        "seed": seed, "jobs": jobs, "kills": times, "after_s": " ".join(f"{m:.1f}" for m in moments),
        "parts_of": len(now), "parts_at_kill": had, "parts_kept": kept, "lost_s": f"{lost:.1f}", "exit_code": code,
        "same_tables": code == 0 and tables(out) == tables(whole),
    }  # fmt: skip


def main() -> None:
    """Kill, resume, compare, write."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else KILLED
    first = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    with tempfile.TemporaryDirectory() as scratch:
        made = campaign(Path(scratch) / "campaign")
        begun = time.perf_counter()
        if start(made, made.folder / "whole", 1).wait() != 0:
            raise SystemExit("the uninterrupted run failed")
        whole_s = time.perf_counter() - begun
        print(f"uninterrupted: {whole_s:.0f} s, {len(parts(made.folder / 'whole'))} parts", flush=True)
        for seed in range(first, first + count):
            add(killed(made, made.folder / "whole", whole_s, seed))
            write_page(whole_s)


def add(row: dict[str, object]) -> None:
    """One more row of kills.csv, in place of an older one of its seed."""
    rows = [one for one in read() if one["seed"] != str(row["seed"])]
    with RESULTS.open("w", newline="") as stream:
        writer = csv.DictWriter(stream, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(sorted([*rows, row], key=lambda one: int(str(one["seed"]))))
    print(row, flush=True)


def read() -> list[dict[str, str]]:
    """The rows of kills.csv."""
    if not RESULTS.exists():
        return []
    with RESULTS.open(newline="") as stream:
        return list(csv.DictReader(stream))


def write_page(whole_s: float) -> None:
    """kills.md, from kills.csv."""
    rows = read()
    same, kept = (sum(row[name] == "True" for row in rows) for name in ("same_tables", "parts_kept"))
    some = sum(0 < int(row["parts_at_kill"]) < int(row["parts_of"]) for row in rows)
    lost = sorted(float(row["lost_s"]) for row in rows)
    PAGE.write_text(f"""\
# Runs killed at random moments

    python -m experiments.kills {len(rows)}

| | |
|---|---|
| runs killed (one in four twice; every second one on two processes) | {len(rows)} |
| resumed to the end, tables the bytes of an uninterrupted run | {same} |
| every part that was finished kept as it was | {kept} |
| killed with some parts finished and others not | {some} |
| seconds between the last finished part (or the start) and the kill: median, largest | {lost[len(lost) // 2]:.1f}, \
{lost[-1]:.1f} |
| seconds of the uninterrupted run, imports among them | {whole_s:.0f} |

A kill before the first part loses the imports, reading and that part; one after the last loses the page. `kills.csv`
has a row a run. The campaign has {len(SPRINGS)} springs of {len(RELEASES_M)} trials, each searched over
{', '.join(SUSPECTS)}.
""")


if __name__ == "__main__":
    main()
