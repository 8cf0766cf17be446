"""How fast a fit of (m_a, C_d) is beside Method 1 in plain Python and other ways to do it: ratios from one run.

    python -m benchmarks.speed                  # five rounds, three minutes; writes speed.csv beside this file
    python -m benchmarks.speed --rounds 1 --without-solve-ivp

Same samples, same start, warm, interleaved, medians of CPU time (one thread each, so that a busy machine counts alike
for all). lmfit and rolldecay-estimators take part where they are installed.
"""

from __future__ import annotations

import argparse
import csv
import importlib.metadata
import importlib.util
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks import method1_plain, peers
from benchmarks.decay import Record, identify, record

FITS_A_ROUND = 200
RECORDS_S = (15.0, 8.9)
"""A whole record, its stuck end included, and the motion alone."""

COLD = """
import time
began = time.perf_counter()
from benchmarks.decay import identify, record
data = record(8.9)
middle = time.perf_counter()
identify(data)
print(middle - began, time.perf_counter() - middle)
"""


def cpu_seconds(run: Callable[[], object]) -> float:
    """CPU time of one call, s."""
    began = time.process_time()
    run()
    return time.process_time() - began


def method1(data: Record) -> tuple[float, float]:
    """(m_a in kg, C_d) by Method 1 in plain Python, one start."""
    added, drag, _ = method1_plain.identify(
        data.t.tolist(), data.x.tolist(), data.x0, data.mass, data.k, data.c, data.friction, data.drag_unit
    )
    return added, drag


def rivals() -> dict[str, Callable[[Record], tuple[float, float]]]:
    """Every other way to the same two numbers that is installed here."""
    found: dict[str, Callable[[Record], tuple[float, float]]] = {
        "Method 1, plain Python (RK4 1 kHz, Nelder-Mead)": method1,
        "DOP853 with events, Nelder-Mead": lambda data: peers.nelder_mead(data, peers.dop853_with_events),
    }
    if importlib.util.find_spec("lmfit"):
        name = f"lmfit {importlib.metadata.version('lmfit')} leastsq on DOP853 with events"
        found[name] = peers.lmfit_leastsq
    return found


def compare(seconds: float, rounds: int) -> list[dict[str, object]]:
    """One row a way: median seconds a fit, ratio to undertow's, the two numbers found."""
    data = record(seconds)
    ways = rivals()
    for _ in range(20):
        identify(data)
    times: dict[str, list[float]] = {"undertow": [], **{name: [] for name in ways}}
    answers = {"undertow": identify(data)}
    for _ in range(rounds):
        for name, way in ways.items():
            times["undertow"] += [cpu_seconds(lambda: identify(data)) for _ in range(FITS_A_ROUND // len(ways))]
            times[name].append(cpu_seconds(lambda way=way, name=name: answers.__setitem__(name, way(data))))
    return rows(seconds, data, times, answers)


def rows(
    seconds: float, data: Record, times: dict[str, list[float]], answers: dict[str, tuple[float, float]]
) -> list[dict[str, object]]:
    """The table's rows from all times and answers."""
    own = float(np.median(times["undertow"]))
    return [
        {
            "record_s": seconds, "way": name, "fits": len(spent), "median_s": float(np.median(spent)),
            "ratio": float(np.median(spent)) / own,
            "added_mass_error_kg": answers[name][0] - data.truth[0], "drag_error": answers[name][1] - data.truth[1],
        }
        for name, spent in times.items()
    ]  # fmt: skip


def cold_start(fresh: bool) -> tuple[float, float]:
    """Wall seconds of importing and of the first fit in a new process; ``fresh``: nothing compiled before."""
    with tempfile.TemporaryDirectory() as folder:
        env = {**os.environ, **({"NUMBA_CACHE_DIR": folder} if fresh else {})}
        done = subprocess.run([sys.executable, "-c", COLD], capture_output=True, text=True, check=True, env=env)
    imported, first = (float(part) for part in done.stdout.split())
    return imported, first


def rolldecay() -> str:
    """What rolldecay-estimators does with the record, or that it is absent."""
    if not importlib.util.find_spec("rolldecayestimators"):
        return "rolldecay-estimators is not installed: left out."
    pandas = importlib.import_module("pandas")
    estimator = importlib.import_module("rolldecayestimators.direct_estimator").DirectEstimator
    data = record(8.9)
    frame = pandas.DataFrame({"phi": data.x[::10]}, index=data.t[::10])
    fit = estimator(fit_method="integration")
    seconds = cpu_seconds(lambda: fit.fit(X=frame))
    version = importlib.metadata.version("rolldecay-estimators")
    return (
        f"rolldecay-estimators {version} has no friction and cannot hold k, c, mu: its quadratic model (100 Hz) takes "
        f"{seconds:.2g} s and finds a quadratic damping of {fit.parameters['d']:.3g} (the truth is positive)."
    )


def solve_ivp_once(seconds: float, own_s: float) -> dict[str, object]:
    """Row of one Nelder-Mead fit, to its end, on solve_ivp with sign() in the right-hand side."""
    data = record(seconds)
    way, answers = "solve_ivp as one writes it, Nelder-Mead", {}
    spent = cpu_seconds(lambda: answers.__setitem__(way, peers.nelder_mead(data, peers.as_one_writes_it)))
    times = {"undertow": [own_s], way: [spent]}
    return rows(seconds, data, times, {**answers, "undertow": data.truth})[1]


def main() -> None:
    """Run all, print the table, write it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--without-solve-ivp", action="store_true")
    parser.add_argument("--to", type=Path, default=Path(__file__).with_name("speed.csv"))
    given = parser.parse_args()
    table = [row for seconds in RECORDS_S for row in compare(seconds, given.rounds)]
    if not given.without_solve_ivp:
        table.append(solve_ivp_once(RECORDS_S[1], float(str(table[len(table) // 2]["median_s"]))))
    for row in table:
        print(f"{row['record_s']:5} s  {row['way']:58} {row['median_s']:.3g} s  x {row['ratio']:.5g}")
    for fresh in (True, False):
        imported, first = cold_start(fresh)
        state = "nothing compiled" if fresh else "compiled before"
        table.append({"way": f"cold start, {state}: imports", "median_s": imported})
        table.append({"way": f"cold start, {state}: first fit", "median_s": first})
        print(f"cold start, {state}: imports {imported:.2g} s, first fit {first:.2g} s (wall)")
    print(rolldecay())
    with given.to.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(table[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows([{k: f"{v:.4g}" if isinstance(v, float) else v for k, v in row.items()} for row in table])


if __name__ == "__main__":
    main()
