"""Two routes to one equation: trajectories, and the weak form on recorded samples; whether they say when one is wrong.

    python -m experiments structure.routes --seeds 5

Recordings of Eq. 15 as the recovery study makes them, of unequal length: with both sensors, with the displacement
alone, and with a weak form that takes the accelerometer for 8 ms late. Writes routes.csv here.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from experiments.files import write_rows
from experiments.recovery.releases import record_group
from experiments.structure.study import STATED_LEVELS, ten_terms
from experiments.structure.truths import KINDS, OtherTruth, plant_other
from undertow.comparison.structure import Effort, FoundStructure, find_structure
from undertow.conditioning.condition import condition
from undertow.methods.weak_form import second_route
from undertow.recording.recording import Recording

FOLDER = Path(__file__).resolve().parent
NOISE = ("N1", "N3")
SETTINGS = ("both sensors", "displacement alone", "late accelerometer")
LATE_S = 0.008
SHARES = (1.0, 0.6, 0.8, 0.7)
"""Share of each recording that is kept: trials of unequal length."""

COLUMNS = ("setting", "spring", "noise", "seed", "exact", "agrees", "chi2_per_term", "worst_first_z", "worst_second_z")


def recordings(truth: OtherTruth, noise: str, seed: int, setting: str) -> list[Recording]:
    """The four recordings cut to unequal lengths, with the channels of a setting."""
    kept = []
    for recording, share in zip(record_group(truth, noise, seed), SHARES, strict=True):
        count = round(share * recording.time.size)
        channels = {name: values[:count] for name, values in recording.channels.items()}
        if setting == "displacement alone":
            channels.pop("acceleration")
        kept.append(replace(recording, time=recording.time[:count], channels=channels))
    return kept


def judge(truth: OtherTruth, noise: str, seed: int, setting: str) -> tuple[object, ...]:
    """One row: whether the support is exact, whether the routes agree, the largest errors over standard errors."""
    motions = [condition(recording) for recording in recordings(truth, noise, seed, setting)]
    found = find_structure(motions, ten_terms(), effort=Effort(resamples=0))
    route = found.route
    if route is None:
        return (setting, truth.spring, noise, seed, int(set(found.names) == KINDS[truth.kind]), "", "", "", "")
    if setting == "late accelerometer":
        count = len(found.terms)
        clocks = {motion.name: LATE_S for motion in motions}
        route = second_route(motions, found.terms, found.coefficients, found.covariance[:count, :count], clocks)
    exact = set(found.names) == KINDS[truth.kind]
    first, second = errors(truth, found, route.values, route.stderr) if exact else (float("nan"), float("nan"))
    return (
        setting, truth.spring, noise, seed, int(exact), int(route.agrees), round(route.distance, 2), round(first, 2),
        round(second, 2),
    )  # fmt: skip


def errors(truth: OtherTruth, found: FoundStructure, values: np.ndarray, stderr: np.ndarray) -> tuple[float, float]:
    """Largest error over standard error of both routes' coefficients, Eq. 15's terms."""
    body = truth.body
    exact = dict(
        zip(
            ("stiffness", "viscous_damping", "coulomb_friction", "quadratic_drag"),
            np.array([body.k_N_per_m, body.c_Ns_per_m, body.friction_N, body.drag_Ns2_per_m2]) / body.inertia_kg,
            strict=True,
        )
    )
    true = np.array([exact[name] for name in found.names])
    own = np.sqrt(np.diag(found.covariance))[: true.size]
    return float(np.max(np.abs(found.coefficients - true) / own)), float(np.max(np.abs(values - true) / stderr))


def main(arguments: Sequence[str] | None = None) -> int:
    """Judge every setting, spring and noise, and write the rows."""
    parser = argparse.ArgumentParser(description="Two routes to one equation.")
    parser.add_argument("--seeds", type=int, default=5)
    options = parser.parse_args(arguments)
    rows = []
    for setting in SETTINGS:
        for spring, depth in STATED_LEVELS:
            truth = plant_other(spring, depth, "eq15")
            for noise in NOISE:
                rows += [judge(truth, noise, seed, setting) for seed in range(options.seeds)]
                print(*rows[-options.seeds :], sep="\n", file=sys.stderr, flush=True)
    write_rows(FOLDER / "routes.csv", COLUMNS, rows)
    return 0
