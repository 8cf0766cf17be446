"""How a campaign's cost grows with its trials: processor time and memory of ``undertow run --jobs 2``.

    python -m benchmarks.campaign_scale 100 1000 10000          # writes benchmarks/campaign_scale.json
    python -m benchmarks.campaign_scale --water 100 1000        # five terms, beside dry trials
    python -m benchmarks.campaign_scale --full 100              # every method, every suspect
    python -m benchmarks.campaign_scale --parent 100000         # what the parent process alone does and holds

Recordings are made on disk: Eq. 15 (long spring) in water, groups of four releases, each group at a level of its own
with an added mass and a drag of its own, and four dry releases that all share; 4 s at 50 Hz, displacement and
acceleration with noise, k, c and mu scattering from trial to trial.

The default is light: releases without water, stiffness, damping and friction by output error (each trial alone, each
group together), baseline, free runs with their floors, mismatch; nothing is searched. ``--water`` has the five terms of
Eq. 15 beside dry trials, with Method 2 and output error. ``--full`` runs every method and tries every suspect.

Each size runs in a process of its own, warm: a campaign of 32 trials has gone through the same processes before (of
fewer than three groups nothing would be identified in the workers, and they would load their code while counted).
What is counted is everything from the config to the run folder but the page (``--page``), whose cost does not depend on
the number of trials. Peak memory is the process's, since its beginning, beside that of its largest worker; the trace
says how both and the processor time stood as the groups went through.
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
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from undertow.campaign.config import load
from undertow.campaign.run import folder as run_folder
from undertow.campaign.run import run
from undertow.campaign.run.folder import run_to_folder
from undertow.campaign.run.gathered import Gathered, PortionFindings
from undertow.campaign.run.portions import TRIALS_AT_ONCE, Portion, group_order, portions
from undertow.discrepancy.findings import GroupFindings
from undertow.equation.equation import equation_15
from undertow.equation.simulate import simulate
from undertow.recording.gather import gather
from undertow.report.tables import RunTables

RESULTS = Path(__file__).with_suffix(".json")
GROUP = 4
DRY = 4
JOBS = 2
WARM = 32
RATE_HZ, HOLD_S, MOTION_S = 50.0, 0.5, 4.0
MASS_KG, AREA_M2, RHO = 2637.4, 0.97, 1000.0
CONFIG = """\
name: scale
recordings:
  index: campaign.csv
  channels:
    time: {column: t, unit: s}
    displacement: {column: x, unit: m}
    acceleration: {column: a, unit: m/s^2}
"""
LIGHT = CONFIG + """\
trials: {group_by: [level]}
specimen: {mass_kg: 2637.4}
equation: {terms: [stiffness, viscous_damping, coulomb_friction]}
identify: [output_error]
discrepancy: {suspects: []}
"""
WATER = CONFIG + """\
trials: {group_by: [level], dry: {level: dry}}
specimen: {mass_kg: 2637.4, area_m2: 0.97}
identify: [method2, output_error]
discrepancy: {suspects: []}
"""
FULL = WATER.replace("identify: [method2, output_error]\n", "").replace("suspects: []", "suspects: all")
CONFIGS = {"light": LIGHT, "water": WATER, "full": FULL}


def make(folder: Path, trials: int, config: str = LIGHT) -> Path:
    """A campaign of so many recordings, and four dry ones where the config speaks of them; its config."""
    wet = "dry:" in config
    folder.mkdir(parents=True, exist_ok=True)
    rng = np.random.default_rng(trials)
    rows = ["file,level"]
    free = np.arange(0.0, MOTION_S, 1.0 / RATE_HZ)
    held = round(HOLD_S * RATE_HZ)
    time_s = np.arange(held + free.size) / RATE_HZ
    for i in range(-DRY if wet else 0, trials):
        group = i // GROUP
        of_group = np.random.default_rng((trials, 1 + group))
        added, drag = (0.0, 0.0) if i < 0 or not wet else (of_group.uniform(100.0, 900.0), of_group.uniform(2.0, 9.0))
        k, c, friction = (109_592.0, 590.0, 150.0) * (1.0 + np.array((0.003, 0.06, 0.05)) * rng.standard_normal(3))
        equation = equation_15(MASS_KG, added, c, k, friction, 0.5 * RHO * AREA_M2 * drag)
        x0 = float(rng.uniform(0.03, 0.1))
        motion = simulate(equation, x0, free)
        x = np.r_[np.full(held, x0), motion.x] + 5e-5 * rng.standard_normal(time_s.size)
        a = np.r_[np.zeros(held), motion.a] + 0.02 * rng.standard_normal(time_s.size)
        table = np.column_stack([time_s, x, a])
        np.savetxt(folder / f"r{i}.csv", table, delimiter=",", header="t,x,a", comments="", fmt="%.7g")
        rows.append(f"r{i}.csv,{'dry' if i < 0 else f'{1.0 + 1e-4 * group:.4f}'}")
    (folder / "campaign.csv").write_text("\n".join(rows) + "\n")
    (folder / "config.yaml").write_text(config)
    return folder / "config.yaml"


def cpu_s() -> float:
    """Processor seconds of this process, of its workers that live and of those that ended."""
    spent = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in spent) + sum(cpu for cpu, _ in workers())


def workers() -> list[tuple[float, float]]:
    """Processor seconds and peak memory (MB) of each child process."""
    children = [path for path in Path("/proc").glob("[0-9]*/stat") if _parent(path) == os.getpid()]
    return [worker(int(path.parent.name)) for path in children]


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


def peak_mb() -> float:
    """Peak memory of this process, MB: of it alone, where rusage begins with that of the process that started it."""
    return worker(os.getpid())[1]


@contextmanager
def page_apart(wanted: bool) -> Iterator[list[float]]:
    """Processor seconds of every page that is written inside, and peak memory before it, MB; none where not wanted."""
    written, write = list[float](), run_folder.write_report

    def timed(*given: Any) -> Path:
        before, memory = time.process_time(), peak_mb()
        if wanted:
            write(*given)
        written.extend((time.process_time() - before, memory))
        return RESULTS

    run_folder.write_report = timed
    try:
        yield written
    finally:
        run_folder.write_report = write


class Trace:
    """Progress of a run that notes, portion by portion: trials identified, processor seconds, peak memory (MB)."""

    def __init__(self, began: float, trials: int) -> None:
        self.rows = list[list[float]]()
        self._began, self._trials = began, trials

    def __call__(self, stage: str, done: int, of: int, *names: str) -> None:
        """Called by the run; notes the state whenever a tenth more of the groups has been identified."""
        if stage == "identification" and done * 10 // max(of, 1) > len(self.rows) - 1:
            largest = max((peak for _, peak in workers()), default=0.0)
            self.rows.append([done * self._trials / of, round(cpu_s() - self._began, 2), peak_mb(), largest])
            print(self.rows[-1], file=sys.stderr, flush=True)


def measure_here(config: Path, out: Path, trials: int, page: bool) -> dict[str, Any]:
    """One campaign in this process, warm: seconds, peak memory of it and of its largest worker, MB."""
    cold, began = cpu_s(), time.perf_counter()
    run(load(make(out.parent / "warm", WARM, config.read_text())), jobs=JOBS)
    warm, start = cpu_s(), time.perf_counter()
    trace = Trace(warm, trials)
    with page_apart(page) as written:
        finished = run_to_folder(config, out=out, jobs=JOBS, progress=trace)
    wall, spent, (paged, before_page) = time.perf_counter() - start, cpu_s() - warm, written
    found = finished.extent.trials
    return {
        "trials": float(trials),
        "groups": float(finished.extent.groups),
        "failed": float(len(finished.failed)),
        "cpu_ms_a_trial": 1e3 * (spent - paged) / found,
        "cpu_s": spent - paged,
        "wall_s": wall,
        "start_cpu_s": warm - cold,
        "start_wall_s": start - began,
        "peak_MB_before_page": before_page,
        "peak_MB": peak_mb(),
        "largest_worker_MB": max((peak for _, peak in workers()), default=0.0),
        **{f"{stage} s": seconds for stage, seconds in finished.findings.seconds.items()},
        **({"page_cpu_s": paged, "page_MB": (out / "report.html").stat().st_size / 2**20} if page else {}),
        "trace": trace.rows,
    }


def measure_parent(trials: int, out: Path, at_once: int = TRIALS_AT_ONCE // 4) -> dict[str, float]:
    """What the parent does with finished groups, and holds: a quarter of a portion, analysed once, again and again.

    Each time under other names and levels; nothing is read or fitted. The list of all trials, which a run holds to its
    end, is held here too: an index of so many rows and files with nothing in them.
    """
    config = load(make(out.parent / "parent", min(at_once, trials)))
    found = [g for g in run(config, jobs=JOBS).groups if not g.dry]
    gathered, before, memory = Gathered(config), time.process_time(), peak_mb()
    plan = planned(out.parent / "plan", trials)
    with RunTables(out) as tables:
        done = 0
        while done < trials:
            part = PortionFindings(tuple(_renamed(group, done + i) for i, group in enumerate(found)), (), ())
            gathered.add(part)
            for group in part.groups:
                tables.add(group, group_order(group.key.items(), group.dry))
                done += len(group.trials)
        findings = gathered.findings({})
        tables.write((), findings.across_groups)
    spent = time.process_time() - before
    return {
        "parent_trials": float(done), "parent_cpu_ms_a_trial": 1e3 * spent / done, "peak_MB_before": memory,
        "peak_MB": peak_mb(), "portions": float(len(plan)), "shown": float(len(findings.groups)),
        **{f"{name} MB": (out / name).stat().st_size / 2**20 for name in ("trials.csv", "verdict.json")},
    }  # fmt: skip


def planned(folder: Path, trials: int) -> tuple[Portion, ...]:
    """The portions of a campaign of so many trials, whose files are empty."""
    folder.mkdir(parents=True)
    rows = [f"r{i}.csv,{1.0 + 1e-4 * (i // GROUP):.4f}" for i in range(trials)]
    for i in range(trials):
        (folder / f"r{i}.csv").touch()
    (folder / "campaign.csv").write_text("\n".join(["file,level", *rows]) + "\n")
    (folder / "config.yaml").write_text(LIGHT)
    config = load(folder / "config.yaml")
    return portions(config, gather(config.catalogue()))


def _renamed(group: GroupFindings, number: int) -> GroupFindings:
    """The group at another level, its trials in other files."""

    def moved(name: str) -> str:
        return f"{name}_{number}"

    trials = []
    for trial in group.trials:
        recording = trial.motion.recording
        recording = replace(recording, name=moved(recording.name), path=moved(recording.path))
        trials.append(replace(trial, motion=replace(trial.motion, recording=recording)))
    key = {"level": 1.0 + 1e-4 * number}
    verdict = replace(group.verdict, group=key, trials=tuple(moved(name) for name in group.verdict.trials))
    return replace(group, key=key, trials=tuple(trials), verdict=verdict)


def measure(trials: int, kind: str, page: bool) -> dict[str, Any]:
    """One size, in a process of its own, recordings in a temporary folder; ``kind`` is light, water, full or parent."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if kind != "parent":
            make(folder / "campaign", trials, CONFIGS[kind])
        given = [kind, str(folder), str(trials), str(int(page))]
        command = [sys.executable, "-m", "benchmarks.campaign_scale", "--here", *given]
        said = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
    return {"kind": kind, **json.loads(said.stdout.splitlines()[-1])}


def here(kind: str, folder: Path, trials: int, page: bool) -> dict[str, Any]:
    """The measurement itself."""
    if kind == "parent":
        return measure_parent(trials, folder / "out")
    return measure_here(folder / "campaign" / "config.yaml", folder / "out", trials, page)


def kept(results: Path, new: dict[str, Any]) -> list[dict[str, Any]]:
    """Results with a new one in the place of an older one of its kind and size, in order."""

    def name(one: dict[str, Any]) -> tuple[str, float]:
        return one["kind"], one.get("trials", one.get("parent_trials", 0.0))

    older = json.loads(results.read_text()) if results.exists() else []
    return sorted([*(one for one in older if name(one) != name(new)), new], key=name)


def main(arguments: list[str] | None = None, say: Callable[[str], None] = print) -> int:
    """Measure every size asked for, print a line each and write them."""
    parser = argparse.ArgumentParser(description="Cost of the campaign path by number of trials.")
    parser.add_argument("trials", nargs="*", type=int, default=[], help="numbers of trials, light configuration")
    parser.add_argument("--water", nargs="*", type=int, default=[], help="the same with five terms, beside dry trials")
    parser.add_argument("--full", nargs="*", type=int, default=[], help="the same with every method and suspect")
    parser.add_argument("--parent", nargs="*", type=int, default=[], help="the parent alone, nothing fitted")
    parser.add_argument("--page", action="store_true", help="write the page too, counted apart")
    parser.add_argument("--here", nargs=4, help=argparse.SUPPRESS)
    parser.add_argument("--out", type=Path, default=RESULTS, help="where the results go")
    options = parser.parse_args(arguments)
    if options.here:
        kind, folder, number, page = options.here
        say(json.dumps(here(kind, Path(folder), int(number), page == "1")))
        return 0
    asked = {"light": options.trials, "water": options.water, "full": options.full, "parent": options.parent}
    for kind, trials in ((kind, number) for kind, numbers in asked.items() for number in numbers):
        found = measure(trials, kind, options.page)
        options.out.write_text(json.dumps(kept(options.out, found), indent=1) + "\n")
        say(json.dumps({n: round(v, 3) if isinstance(v, float) else v for n, v in found.items() if n != "trace"}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
