"""Simulation-based calibration of `Fitted.posterior`: where truths are drawn at random and each campaign is fitted, the
truth's rank among the draws is uniform (Talts et al. 2018, arXiv:1804.06788), and 90 % intervals hold it in 90 of 100.

    python -m experiments posterior [CAMPAIGNS [FIRST_SEED [KIND ...]]]

adds its seeds to docs/posterior.json. Two kinds of campaign, with the motions of experiments/eq15_campaign/motion.py: a
dry rig of known mass (k, c, mu unknown), and a body in water beside its dry trials, whose k, c, mu scatter from trial
to trial (added mass and drag unknown).

Belongs here: truths, ranks, the file. Does not belong here: fits and draws (undertow).
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
from scipy.stats import binomtest, chisquare

import undertow
from experiments.eq15_campaign.motion import Body, hold_and_release
from undertow.recording.recording import Recording

OUT = Path(__file__).resolve().parents[2] / "docs" / "posterior.json"
CAMPAIGNS = 200
DRAWS = 199
"""A rank is then one of 200 numbers, which ten bins divide evenly."""

BINS = 10
MASS_KG, GRAVITY = 2637.4, 9.81
RELEASES_M = (0.04, 0.06, 0.08, 0.1)
RATE_HZ, HOLD_S, SWINGS = 60.0, 0.5, 8.0
NOISE_M = 4e-4
SCATTER = {"k": 0.002, "c": 0.06, "mu": 0.05}
"""Of a rig that repeats well, relative, from trial to trial."""

Ranks = dict[str, float]


def recorded(body: Body, x0_m: float, name: str, rng: np.random.Generator) -> Recording:
    """A hold and a decay with white noise and a sensor whose zero is off by a millimetre."""
    period = 2.0 * np.pi / np.sqrt(body.k_N_per_m / body.inertia_kg)
    held, after = round(HOLD_S * RATE_HZ), round(SWINGS * period * RATE_HZ)
    moved = hold_and_release(body, x0_m, (np.arange(held + after) - held) / RATE_HZ)
    x = moved.x + 1e-3 * rng.standard_normal()
    return Recording(
        name, np.arange(held + after) / RATE_HZ, {"displacement": x + NOISE_M * rng.standard_normal(x.size)}
    )


def rank(draws: np.ndarray, truth: float) -> float:
    """Share of the draws below the truth, (0, 1)."""
    return (np.count_nonzero(draws < truth) + 0.5) / (draws.size + 1.0)


def structure(rng: np.random.Generator) -> dict[str, float]:
    """k, c and friction coefficient of a rig, drawn from wide ranges."""
    return {
        "k": rng.uniform(80e3, 140e3), "c": rng.uniform(400.0, 1500.0), "mu": rng.uniform(0.004, 0.012),
    }  # fmt: skip


def scattered(rig: dict[str, float], inertia_kg: float, drag: float, rng: np.random.Generator) -> Body:
    """The rig as it is in one trial."""
    k, c, mu = (rig[name] * max(1.0 + SCATTER[name] * rng.standard_normal(), 0.1) for name in ("k", "c", "mu"))
    return Body(inertia_kg, c, k, mu * MASS_KG * GRAVITY, drag)


def dry_campaign(seed: int) -> Ranks:
    """Ranks of k, c and mu of a rig whose trials are all alike."""
    rng = np.random.default_rng([seed, 1])
    rig = structure(rng)
    body = Body(MASS_KG, rig["c"], rig["k"], rig["mu"] * MASS_KG * GRAVITY, 0.0)
    trials = [recorded(body, x0, f"r{i}", rng) for i, x0 in enumerate(RELEASES_M)]
    found = undertow.fit(trials, ["stiffness", "viscous_damping", "coulomb_friction"], mass_kg=MASS_KG)
    drawn = found.posterior(DRAWS, seed).values
    return {
        "k_N_per_m": rank(drawn["k_N_per_m"], rig["k"]), "c_Ns_per_m": rank(drawn["c_Ns_per_m"], rig["c"]),
        "mu": rank(drawn["mu"], rig["mu"]),
    }  # fmt: skip


def wet_campaign(seed: int) -> Ranks:
    """Ranks of added mass and drag coefficient beside dry trials, where k, c and mu scatter."""
    rng = np.random.default_rng([seed, 2])
    rig = structure(rng)
    added, drag = rng.uniform(600.0, 2000.0), rng.uniform(2000.0, 6000.0)
    dry = [recorded(scattered(rig, MASS_KG, 0.0, rng), x0, f"d{i}", rng) for i, x0 in enumerate(RELEASES_M)]
    wet = [recorded(scattered(rig, MASS_KG + added, drag, rng), x0, f"w{i}", rng) for i, x0 in enumerate(RELEASES_M)]
    found = undertow.fit(wet, dry=dry, mass_kg=MASS_KG, area_m2=1.0)
    drawn = found.posterior(DRAWS, seed).values
    return {
        "added_mass_kg": rank(drawn["added_mass_kg"], added),
        "drag_coefficient": rank(drawn["drag_coefficient"], drag / 500.0),
    }


KINDS = {"dry": dry_campaign, "wet": wet_campaign}


def ranked(campaigns: int, first: int, kinds: Sequence[str]) -> Iterator[tuple[str, str, float]]:
    """Kind, parameter and rank of every campaign."""
    for seed in range(first, first + campaigns):
        for kind in kinds:
            for name, found in KINDS[kind](seed).items():
                yield kind, name, found


def summary(ranks: np.ndarray) -> dict[str, object]:
    """Counts in ten bins, how probable bins as uneven are by chance, and the coverage of 90 % intervals, in %."""
    counts, _ = np.histogram(ranks, bins=BINS, range=(0.0, 1.0))
    inside = int(np.count_nonzero((ranks > 0.05) & (ranks < 0.95)))
    ends = binomtest(inside, ranks.size).proportion_ci(0.9, "wilson")
    return {
        "campaigns": int(ranks.size), "counts": counts.tolist(), "p_flat": round(float(chisquare(counts).pvalue), 4),
        "coverage_percent": round(100.0 * inside / ranks.size, 1),
        "coverage_ends_percent": [round(100.0 * float(end), 1) for end in (ends.low, ends.high)],
    }  # fmt: skip


def main(campaigns: int = CAMPAIGNS, first: int = 0, kinds: Sequence[str] = tuple(KINDS)) -> None:
    """Run the campaigns and write what was found."""
    found: dict[str, list[float]] = {}
    for kind, name, one in ranked(campaigns, first, kinds):
        found.setdefault(f"{kind} {name}", []).append(one)
    data = {name: summary(np.array(values)) for name, values in found.items()}
    before = json.loads(OUT.read_text()) if OUT.exists() else {}
    whole = before | {f"seeds {first} to {first + campaigns - 1}": data}
    OUT.write_text(json.dumps(whole, indent=1) + "\n")
    for name, row in data.items():
        print(f"{name:22} p {row['p_flat']:<7} coverage {row['coverage_percent']} %  {row['counts']}")
