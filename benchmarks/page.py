"""How long the page of 80 trials of 15,000 samples takes, and how large it is: limits 20 s on two cores, 8 MB.

    python -m benchmarks.page                      # writes benchmarks/page.json
    python -m benchmarks.page --trials 80 --samples 15000 --jobs 2

The findings are made: 16 groups of five releases, every second group with a hidden resonator named and its free runs
repaired, so that every figure of a group's section is drawn. Processor time is that of this process and its workers,
which are warm as after a run; on a machine that others use, processor time over the number of workers is what a
free one would take.
"""

from __future__ import annotations

import argparse
import json
import os
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from undertow.campaign.run.workers import on_processes
from undertow.conditioning.motion import Motion, Window
from undertow.discrepancy.findings import AugmentedRun, Findings, GroupFindings, TrialFindings
from undertow.discrepancy.mismatch import Mismatch
from undertow.discrepancy.verdict import Described, Rejected, Verdict
from undertow.equation import registry
from undertow.equation.equation import Equation, equation_15
from undertow.equation.simulate import simulate
from undertow.likelihood.fit import Fit, Specimen
from undertow.quantities import Estimate
from undertow.recording.recording import Recording
from undertow.report.html import write_report

RESULTS = Path(__file__).with_suffix(".json")
MASS_KG, K_N_PER_M, NOISE_M, A_GROUP, RATE_HZ = 2637.4, 109600.0, 1e-4, 5, 500.0
LIMIT_S, LIMIT_MB = 20.0, 8.0

PRESCRIBED = equation_15(MASS_KG, 500.0, 300.0, K_N_PER_M, 60.0, 900.0)
WATER = {"natural_frequency_rad_per_s": 9.0, "damping_ratio": 0.02}
TRUE = Equation(
    (*PRESCRIBED.terms, registry.find("hidden_resonator", **WATER)), (*PRESCRIBED.coefficients, 200.0),
    PRESCRIBED.mass_kg,
)  # fmt: skip


def made_trial(name: str, x0: float, samples: int, hidden: bool, seed: int) -> TrialFindings:
    """One release with noise, of the prescribed equation or of the one with a resonator; its free runs."""
    t = np.arange(samples) / RATE_HZ
    true, run = simulate(TRUE if hidden else PRESCRIBED, x0, t), simulate(PRESCRIBED, x0, t)
    measured = true.x + NOISE_M * np.random.default_rng(seed).standard_normal(samples)
    std = np.full(samples, 0.1 * NOISE_M)
    channels = {"displacement": measured, "acceleration": true.a}
    recording = Recording(name, t, channels, {"level": 1.0}, path=f"{name}.csv")
    window = Window(0.0, 0.0, float(t[-1]), held=True)
    motion = Motion(
        recording, window, t, true.x, true.v, true.a, std, 10.0 * std, 100.0 * std, t >= 0.0,
        Estimate(0.0, 1e-5, 0.0, "m"), x0, {"displacement": NOISE_M, "acceleration": 1e-2},
    )  # fmt: skip
    size = float(np.sqrt(np.mean(measured**2)))
    error = float(np.sqrt(np.mean((measured - run.x) ** 2))) / size
    numbers = {"added_mass_kg": Estimate(500.0, 9.0, unit="kg"), "drag_coefficient": Estimate(2.0, 0.1, unit="1")}
    fits = {m: Fit(m, (name,), parameters=numbers) for m in ("sindy", "method1", "output_error")}
    after = AugmentedRun(NOISE_M / size, measured - true.x) if hidden else None
    mismatch = Mismatch(name, error, NOISE_M / size, 0.05, 0.3, 0.4, 0.3)
    return TrialFindings(motion, fits, {"baseline": error}, mismatch, t, measured, run.x, x0 == 0.04, after)


def made_group(number: int, samples: int) -> GroupFindings:
    """Five releases at one level; every second level has the resonator, named."""
    hidden = number % 2 == 1
    sizes = (0.02, 0.03, 0.04, 0.05, 0.06)
    trials = tuple(made_trial(f"r{number:02d}{i}", x0, samples, hidden, 10 * number + i) for i, x0 in enumerate(sizes))
    names = tuple(t.motion.name for t in trials)
    numbers = dict(trials[0].fits["sindy"].parameters)
    water = {"mass_kg": Estimate(200.0, 2.0, unit="kg"), "damping_ratio": Estimate(0.02, 0.002, unit="1"),
             "natural_frequency_rad_per_s": Estimate(9.0, 0.02, unit="rad/s")}  # fmt: skip
    repaired = numbers | {f"hidden_resonator.{name}": e for name, e in water.items()}
    alike = {one: dict.fromkeys(repaired, 0.3) for one in repaired}
    found = Described(0.02, 0.02, repaired, alike) if hidden else None
    key = {"spring": "long", "level_m": 1.0 + 0.01 * number}
    verdict = Verdict(
        key, names, (names[2],), "explained" if hidden else "nothing_missing", ("hidden_resonator",) * hidden,
        confidence=0.99, baseline=Described(0.4, 0.4, numbers), augmented=found, repeatability_nrmse=0.05,
        rejected=tuple(Rejected(f"suspect_{i}", "odds against it", -3.0 * i - 3.0) for i in range(12)),
        sentence=f"level {number}: made for timing.", posterior=0.99,
    )  # fmt: skip
    errors = {term.name: 0.01 * value for term, value in zip(PRESCRIBED.terms, PRESCRIBED.coefficients, strict=True)}
    fits = {name: Fit(name, names, parameters=numbers) for name in ("sindy", "method1", "output_error")}
    return GroupFindings(key, False, trials, Specimen(MASS_KG, K_N_PER_M, 0.9), None, fits, PRESCRIBED, errors, verdict)


@dataclass(frozen=True)
class Timed:
    """A work of the workers' with the processor time it took; picklable."""

    work: Callable[[Any], Any]

    def __call__(self, item: Any) -> tuple[Any, float]:
        before = time.process_time()
        done = self.work(item)
        return done, time.process_time() - before


def main() -> None:
    """Make the findings, write the page once to warm the workers (two groups) and once in full."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--trials", type=int, default=80)
    parser.add_argument("--samples", type=int, default=15_000)
    parser.add_argument("--jobs", type=int, default=2)
    asked = parser.parse_args()
    groups = tuple(made_group(number, asked.samples) for number in range(asked.trials // A_GROUP))
    findings = Findings("timing", groups, (), ("sindy", "method1", "output_error"), "translation", {})

    spent: list[float] = []

    def each(work: Callable[[Any], Any], items: Sequence[Any]) -> list[Any]:
        done = on_processes(Timed(work), items, asked.jobs, "report")
        spent[:] = [seconds for _, seconds in done]
        return [result for result, _ in done]

    with tempfile.TemporaryDirectory() as folder:
        write_report(replace(findings, groups=groups[:3]), Path(folder), {}, None, each)
        start, before = time.perf_counter(), time.process_time()
        path = write_report(findings, Path(folder), {}, None, each)
        wall, mine, size = time.perf_counter() - start, time.process_time() - before, path.stat().st_size / 1e6
    found = {
        "trials": len(groups) * A_GROUP, "samples": asked.samples, "jobs": asked.jobs, "wall_s": round(wall, 1),
        "cpu_s_of_the_parent": round(mine, 1), "cpu_s_of_the_workers": round(sum(spent), 1),
        "megabytes": round(size, 2), "limit_s": LIMIT_S, "limit_mb": LIMIT_MB,
        "load_average": round(os.getloadavg()[0], 1),
    }  # fmt: skip
    RESULTS.write_text(json.dumps(found, indent=1) + "\n")
    print(json.dumps(found))


if __name__ == "__main__":
    main()
