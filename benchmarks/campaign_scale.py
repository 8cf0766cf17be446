"""How a campaign's cost grows with its trials: processor time, wall time and memory of the campaign path.

    python -m benchmarks.campaign_scale 100 1000          # writes benchmarks/campaign_scale.json

Recordings are made on disk (Eq. 15's structure, 5 s at 100 Hz, groups of four), read, conditioned, fitted (SINDy, the
baseline and its free runs, no suspects) with two jobs, and written to tables; no page. Each size runs in a process
of its own, whose peak memory is the one that counts, beside that of its largest worker.
"""

from __future__ import annotations

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from undertow.campaign.config import load
from undertow.campaign.run import run
from undertow.equation.equation import equation_15
from undertow.equation.simulate import simulate
from undertow.report.tables import write_tables

RESULTS = Path(__file__).with_suffix(".json")
GROUP = 4
JOBS = 2
RATE_HZ, HOLD_S, MOTION_S = 100.0, 0.5, 5.0
CONFIG = """\
name: scale
recordings:
  index: campaign.csv
  channels:
    time: {column: t, unit: s}
    displacement: {column: x, unit: m}
    acceleration: {column: a, unit: m/s^2}
trials:
  group_by: [group]
specimen:
  mass_kg: 2637.4
equation:
  terms: [stiffness, viscous_damping, coulomb_friction]
identify: [sindy]
discrepancy: {suspects: []}
"""


def make(folder: Path, trials: int) -> Path:
    """A campaign of so many recordings; its config."""
    rng = np.random.default_rng(trials)
    rows = ["file,group"]
    free = np.arange(0.0, MOTION_S, 1.0 / RATE_HZ)
    held = round(HOLD_S * RATE_HZ)
    time_s = np.arange(held + free.size) / RATE_HZ
    for i in range(trials):
        equation = equation_15(2637.4, 0.0, 590.0 * (1.0 + 0.06 * rng.standard_normal()), 109_600.0, 180.0, 0.0)
        x0 = float(rng.uniform(0.02, 0.1))
        motion = simulate(equation, x0, free)
        x = np.r_[np.full(held, x0), motion.x] + 5e-5 * rng.standard_normal(time_s.size)
        a = np.r_[np.zeros(held), motion.a] + 0.02 * rng.standard_normal(time_s.size)
        table = np.column_stack([time_s, x, a])
        np.savetxt(folder / f"r{i}.csv", table, delimiter=",", header="t,x,a", comments="", fmt="%.7g")
        rows.append(f"r{i}.csv,{i // GROUP}")
    (folder / "campaign.csv").write_text("\n".join(rows) + "\n")
    (folder / "config.yaml").write_text(CONFIG)
    return folder / "config.yaml"


def measure_here(config: Path, out: Path) -> dict[str, float]:
    """One campaign in this process: wall and processor seconds, peak memory of it and of its largest worker, MB."""
    start = time.perf_counter()
    findings = run(load(config), jobs=JOBS)
    write_tables(findings, out)
    wall = time.perf_counter() - start
    own = resource.getrusage(resource.RUSAGE_SELF)
    children = [path for path in Path("/proc").glob("[0-9]*/stat") if _parent(path) == os.getpid()]
    workers = [worker(int(path.parent.name)) for path in children]
    return {
        "trials": float(sum(len(group.trials) for group in findings.groups)),
        "wall_s": wall,
        "cpu_s": own.ru_utime + own.ru_stime + sum(cpu for cpu, _ in workers),
        "peak_MB": own.ru_maxrss / 1024.0,
        "largest_worker_MB": max((peak for _, peak in workers), default=0.0),
        **{f"{stage} s": seconds for stage, seconds in findings.seconds.items()},
    }


def _parent(stat: Path) -> int:
    try:
        return int(stat.read_text().rpartition(")")[2].split()[1])
    except OSError:  # it ended meanwhile
        return -1


def worker(process: int) -> tuple[float, float]:
    """Processor seconds and peak memory (MB) of a worker that is still there."""
    fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    status = Path(f"/proc/{process}/status").read_text()
    peak = next((int(line.split()[1]) for line in status.splitlines() if line.startswith("VmHWM")), 0)
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK"), peak / 1024.0


def measure(trials: int) -> dict[str, float]:
    """One size, in a process of its own, recordings in a temporary folder."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        config = make(folder, trials)
        command = [sys.executable, "-m", "benchmarks.campaign_scale", "--here", str(config), str(folder / "out")]
        said = subprocess.run(command, capture_output=True, text=True, check=True)
    found: dict[str, float] = json.loads(said.stdout.splitlines()[-1])
    return found


def main(arguments: list[str] | None = None) -> int:
    """Measure every size asked for, print a line each and write them."""
    parser = argparse.ArgumentParser(description="Cost of the campaign path by number of trials.")
    parser.add_argument("trials", nargs="*", type=int, default=[100, 1000], help="numbers of trials")
    parser.add_argument("--here", nargs=2, type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--out", type=Path, default=RESULTS, help="where the results go")
    options = parser.parse_args(arguments)
    if options.here:
        print(json.dumps(measure_here(*options.here)))
        return 0
    results = []
    for trials in options.trials:
        found = measure(trials)
        results.append(found)
        cost = found["cpu_s"] / found["trials"]
        print(f"{trials} trials: {cost:.3g} processor seconds each, peak {found['peak_MB']:.0f} MB", flush=True)
    options.out.write_text(json.dumps(results, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
