"""What a bootstrap and a whole campaign's identification cost, in fits by Method 1 in plain Python.

    python -m benchmarks.campaign          # three minutes; writes campaign.csv beside this file

CPU time, warm, one thread. The bootstrap redraws blocks of residuals of a four-parameter fit and fits again. The
campaign is configs/eq15.yaml: everything done for a group (five methods, each trial alone and together, free runs with
their floors), not reading, conditioning or the search for what is missing.
"""

from __future__ import annotations

import argparse
import csv
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.decay import record
from benchmarks.speed import cpu_seconds, method1
from experiments.efficiency.cases import eq15
from undertow.campaign.config import load
from undertow.campaign.run import course as campaign
from undertow.campaign.run.analysis import analyse
from undertow.campaign.run.tasks import group_task, grouped, structures_of
from undertow.likelihood import output_error
from undertow.likelihood.problem import Problem
from undertow.methods.baseline import terms_by_name

CONFIG = Path(__file__).resolve().parents[1] / "configs" / "eq15.yaml"
BLOCK_PERIODS = 1.5
CELLS_A_PERIOD = 50
NOISE_M = 2e-4
RECORD_S = 15.0


def bootstrap(count: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray, float]:
    """Spread of ``count`` bootstrap fits (4,), the covariance's stderr (4,), and CPU seconds of all fits."""
    rng = np.random.default_rng(seed)
    problem = eq15("long", 2.57, 4, NOISE_M).noisy(rng)
    best = output_error.fit(problem)
    trial, (channel,) = problem.trials[0], problem.trials[0].channels
    error = best.residuals[0] * channel.sigma
    path = channel.values + error
    n, block = error.size, round(BLOCK_PERIODS * CELLS_A_PERIOD)
    began = time.process_time()
    ends = np.empty((count, 4))
    for i in range(count):
        starts = rng.integers(0, n - block, size=-(-n // block))
        drawn = error[(starts[:, None] + np.arange(block)).ravel()[:n]]
        again = replace(channel, values=path - drawn)
        redrawn = Problem(problem.unknowns, (replace(trial, channels=(again,)),))
        ends[i] = output_error.fit(redrawn, best.values, growing=False).values
    spent = time.process_time() - began
    return ends.std(axis=0, ddof=1), np.sqrt(np.diag(best.covariance)), spent


def identification() -> tuple[float, float, int]:
    """CPU seconds of the Eq. 15 campaign's identification and of reading and conditioning it, and how many trials."""
    config = load(CONFIG)
    terms = terms_by_name(config.equation.terms)
    began = time.process_time()
    read = campaign.read_and_condition(config, 1)
    reading = time.process_time() - began
    groups = grouped(config, read.motions)
    structures = structures_of(config, groups, terms)
    tasks = [group_task(config, key, motions, terms, structures) for key, motions in groups.items()]
    analyse(tasks[0])  # compiles
    began = time.process_time()
    for task in tasks:
        analyse(task)
    return time.process_time() - began, reading, len(read.motions)


def main() -> None:
    """Measure, print and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fits", type=int, default=1000)
    parser.add_argument("--to", type=Path, default=Path(__file__).with_name("campaign.csv"))
    given = parser.parse_args()
    data = record(RECORD_S)
    plain = float(np.median([cpu_seconds(lambda: method1(data)) for _ in range(3)]))
    bootstrap(20)
    spread, stderr, spent = bootstrap(given.fits)
    whole, reading, trials = identification()
    table = [
        ("one Method 1 fit in plain Python", plain, 1.0),
        (f"{given.fits} bootstrap fits of 4 parameters", spent, spent / plain),
        (f"identification of the Eq. 15 campaign, {trials} trials", whole, whole / plain),
        (f"reading and conditioning of the Eq. 15 campaign, {trials} trials", reading, reading / plain),
    ]
    for what, seconds, ratio in table:
        print(f"{what:60} {seconds:8.3f} s  {ratio:7.3f} Method 1 fits")
    print("bootstrap spread over the covariance's stderr:", np.round(spread / stderr, 2).tolist())
    with given.to.open("w", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("what", "cpu_s", "method1_fits"))
        writer.writerows([(what, f"{seconds:.4g}", f"{ratio:.4g}") for what, seconds, ratio in table])


if __name__ == "__main__":
    main()
