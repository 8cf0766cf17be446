"""How well SINDy, pooled over a level's four trials, gives back a planted Eq. 15: 20 seeds a level and noise.

    python -m experiments recovery.sindy_recovery                 # the two levels with a stated limit
    python -m experiments recovery.sindy_recovery --levels all    # five levels, both springs

writes sindy_recovery.csv (a row a campaign) and sindy_recovery.md (p90 of the errors beside limits and bounds) here.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from experiments.eq15_campaign import tables
from experiments.eq15_campaign.motion import Floats
from experiments.files import write_rows
from experiments.recovery.bound import bound
from experiments.recovery.releases import NOISE, Truth, plant, record_group
from undertow.conditioning.condition import condition
from undertow.conditioning.motion import Motion
from undertow.equation.hydrodynamics import CubicDamping, QuadraticDrag
from undertow.equation.structure import (
    AsymmetricStiffness,
    CoulombFriction,
    CubicStiffness,
    PositionDamping,
    QuadraticStiffness,
    Stiffness,
    VanDerPolDamping,
    ViscousDamping,
)
from undertow.methods.sindy import discover

FOLDER = Path(__file__).resolve().parent
SEEDS = 20
STATED_LEVELS = (("long", 2.57), ("short", 2.36))
LIMITS = {"N1": (1.0, 12.0, 3.0, 12.0), "N3": (3.0, 18.0, 5.0, 14.0), "N4": (5.0, 25.0, 6.0, 22.0)}
"""Largest p90 of |error|: m_a in kg, c, mu and C_d in per cent; or 1.3 times the bound where that is larger."""

BOUND_SHARE = 1.3
QUANTITIES = ("added_mass_kg", "c_percent", "mu_percent", "drag_percent")
EQ15 = (Stiffness(), ViscousDamping(), CoulombFriction(), QuadraticDrag())
TEN_TERMS = (
    *EQ15, AsymmetricStiffness(), CubicStiffness(), QuadraticStiffness(), CubicDamping(), PositionDamping(),
    VanDerPolDamping(),
)  # fmt: skip

IN_MINUTES = "--seeds 2 --out {}"

@dataclass(frozen=True)
class Outcome:
    """One campaign: ``errors`` (4,) in the units of `QUANTITIES`, ``z`` (4,) errors of the coefficients over their
    stderr, and the terms that the best subset of ten kept."""

    truth: Truth
    noise: str
    seed: int
    errors: Floats
    z: Floats
    kept: tuple[str, ...]

    @property
    def exact(self) -> bool:
        """Whether the best subset is Eq. 15's four terms and no others."""
        return set(self.kept) == {term.name for term in EQ15}


def recover(truth: Truth, noise: str, seed: int) -> Outcome:
    """Record, condition and identify one campaign; k is known, so that m_a = k / (k / M) - m."""
    motions = [condition(recording) for recording in record_group(truth, noise, seed)]
    return judge(truth, noise, seed, motions)


def judge(truth: Truth, noise: str, seed: int, motions: list[Motion]) -> Outcome:
    """Errors of the fixed form and the terms of the selected one."""
    result = discover(motions, EQ15, subset=False)
    found = dict(zip(result.names, result.coefficients, strict=True))
    total = truth.k_N_per_m / found["stiffness"]
    drag = 0.5 * tables.WATER_DENSITY_KG_PER_M3 * tables.REFERENCE_AREA_M2
    found = np.array(
        [
            total - tables.STRUCTURE_MASS_KG,
            found["viscous_damping"] * total,
            found["coulomb_friction"] * total / truth.normal_force_N,
            found["quadratic_drag"] * total / drag,
        ]
    )
    scale = np.array([1.0, *(truth.unknowns[1:] / 100.0)])
    body = truth.body
    exact = np.array([body.k_N_per_m, body.c_Ns_per_m, body.friction_N, body.drag_Ns2_per_m2]) / body.inertia_kg
    z = (result.coefficients - exact) / np.sqrt(np.diag(result.covariance))
    kept = discover(motions, TEN_TERMS).names
    return Outcome(truth, noise, seed, (found - truth.unknowns) / scale, z, kept)


def ninetieth(outcomes: Iterable[Outcome]) -> Floats:
    """p90 of |error| (4,) over the campaigns."""
    p90: Floats = np.quantile([np.abs(outcome.errors) for outcome in outcomes], 0.9, axis=0)
    return p90


def limit(noise: str, lowest: Floats) -> Floats:
    """What the p90 may be (4,): the stated number or 1.3 times the bound."""
    return np.maximum(LIMITS[noise], BOUND_SHARE * lowest)


def cells(one: Outcome) -> list[object]:
    """A campaign's row."""
    errors = [f"{error:.4f}" for error in one.errors]
    return [one.truth.spring, one.truth.water_depth_m, one.noise, one.seed, *errors, int(one.exact), " ".join(one.kept)]


def tabulate(groups: dict[tuple[Truth, str], list[Outcome]]) -> str:
    """Markdown: a row a level and noise; every cell p90 / limit (bound)."""
    lines = [
        "| spring | H, m | noise | m_a, kg | c, % | mu, % | C_d, % | exact support | rms error / stderr |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for (truth, noise), outcomes in groups.items():
        lowest = bound(truth, noise)
        allowed, found = limit(noise, lowest), ninetieth(outcomes)
        cells = [
            f"{'**' if value > most else ''}{value:.2g}{'**' if value > most else ''} / {most:.3g} ({least:.2g})"
            for value, most, least in zip(found, allowed, lowest, strict=True)
        ]
        ratio = np.sqrt(np.mean([outcome.z**2 for outcome in outcomes], axis=0))
        cells.append(f"{sum(outcome.exact for outcome in outcomes)} of {len(outcomes)}")
        cells.append(", ".join(f"{value:.1f}" for value in ratio))
        lines.append(f"| {truth.spring} | {truth.water_depth_m} | {noise} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


HEADER = """# Recovery of Eq. 15 by SINDy

p90 of |error| over {seeds} seeds / limit (p90 of the Cramer-Rao bound); bold where it is over the limit, which was
stated for long 2.57 m and short 2.36 m. Four trials a level, 1000 Hz, k known, k, c, mu equal in all trials; noise on x
and a: N1 0.05 mm, 0.02 m/s2; N3 0.2 mm, 0.1 m/s2; N4 1 mm, 0.1 m/s2; drift, free offsets, 14 bits. Exact support: the
best subset of ten terms on forces alone is Eq. 15's four and no others (chosen on trajectories:
docs/structure_measured.md). The last column is the root mean square of error over standard
error for k, c, friction and drag over mass.

"""


def main(arguments: list[str] | None = None) -> int:
    """Run the study and write its rows and its table."""
    parser = argparse.ArgumentParser(description="Recovery of Eq. 15 by SINDy.")
    parser.add_argument("--levels", choices=("stated", "all"), default="stated")
    parser.add_argument("--seeds", type=int, default=SEEDS)
    parser.add_argument("--out", type=Path, default=FOLDER)
    options = parser.parse_args(arguments)
    levels = STATED_LEVELS
    if options.levels == "all":
        levels = tuple((spring, depth) for spring in ("long", "short") for depth in tables.WET_DEPTHS_M)
    groups: dict[tuple[Truth, str], list[Outcome]] = {}
    for spring, depth in levels:
        for noise in NOISE:
            truth = plant(spring, depth)
            groups[truth, noise] = [recover(truth, noise, seed) for seed in range(options.seeds)]
            print(spring, depth, noise, np.round(ninetieth(groups[truth, noise]), 2), file=sys.stderr, flush=True)
    header = ("spring", "water_depth_m", "noise", "seed", *QUANTITIES, "exact", "kept")
    rows = [cells(one) for outcomes in groups.values() for one in outcomes]
    write_rows(options.out / "sindy_recovery.csv", header, rows)
    (options.out / "sindy_recovery.md").write_text(HEADER.format(seeds=options.seeds) + tabulate(groups))
    return 0
