"""The recordings of the hidden-state study: two releases of the short spring, with and without hidden oscillators.

With one: 300, 60 or 20 kg at 9.6 rad/s, or two of 200 kg at 7.5 and 10.5 rad/s, all with a damping ratio of 0.02.
Without: Eq. 15 as it is, or with cubic stiffness, a Maxwell element, ten times the sensors' drift, friction that
depends on the direction, or another drag exponent; how much of it is drawn anew for every campaign.

Belongs here: what is planted and how the sensors see it. Does not belong here: what is found (study.py).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from experiments.eq15_campaign import tables
from experiments.eq15_campaign.motion import Floats
from experiments.hidden_states.motion import Oscillator, Plant, simulate
from experiments.recovery.releases import NOISE, RATE_HZ, RECORD_AFTER_RELEASE_S, seen
from undertow.recording.recording import Recording

STIFFNESS_N_PER_M = 404000.0
ADDED_MASS_KG = 350.0
WATER_DEPTH_M = 2.36
RELEASES_M = (0.016, 0.033)
"""Two of the short spring's releases, the second and the largest."""

PLANTED: dict[str, tuple[Oscillator, ...]] = {
    "300 kg": (Oscillator(300.0, 9.6, 0.02),),
    "60 kg": (Oscillator(60.0, 9.6, 0.02),),
    "20 kg": (Oscillator(20.0, 9.6, 0.02),),
    "two of 200 kg": (Oscillator(200.0, 7.5, 0.02), Oscillator(200.0, 10.5, 0.02)),
}
DRIFT_TIMES = 10.0
"""Drift of the null campaigns named so, in times of the ordinary one: 2 mm and 0.2 m/s^2 at most."""

REFERENCE_SPEED_M_PER_S = 0.2
"""Speed at which another drag exponent gives the same drag: the middle of these decays."""


def baseline() -> Plant:
    """Eq. 15 of the study: k, m_a as stated, dry c and mu of Table 2, C_d of Table 6 at 2.36 m."""
    _, c, mu = tables.dry_mean("short")
    buoyancy = tables.submerged_volume(WATER_DEPTH_M) * tables.WATER_DENSITY_KG_PER_M3
    normal = (tables.STRUCTURE_MASS_KG - buoyancy) * tables.GRAVITY_M_PER_S2
    drag = 0.5 * tables.WATER_DENSITY_KG_PER_M3 * tables.REFERENCE_AREA_M2
    return Plant(
        tables.STRUCTURE_MASS_KG + ADDED_MASS_KG, c, STIFFNESS_N_PER_M, mu * normal,
        drag * tables.DRAG_COEFFICIENT["short"][WATER_DEPTH_M],
    )  # fmt: skip


def plant(name: str) -> Plant:
    """The body with the hidden oscillators of that name in `PLANTED`."""
    return replace(baseline(), hidden=PLANTED[name])


def _nothing(body: Plant, rng: np.random.Generator) -> Plant:
    return body


def _cubic(body: Plant, rng: np.random.Generator) -> Plant:
    """Cubic stiffness of 2 to 10 % of k at the largest release, of either sign."""
    share = rng.uniform(0.02, 0.10) * rng.choice((-1.0, 1.0))
    return replace(body, k3=share * body.k / max(RELEASES_M) ** 2)


def _maxwell(body: Plant, rng: np.random.Generator) -> Plant:
    """A Maxwell element of 1 to 10 % of k that forgets within 0.03 to 0.5 s."""
    return replace(body, maxwell=(rng.uniform(0.01, 0.10) * body.k, float(np.exp(rng.uniform(*np.log((0.03, 0.5)))))))


def _asymmetric(body: Plant, rng: np.random.Generator) -> Plant:
    """Friction that differs between the directions by 10 to 60 % of its mean, either way."""
    return replace(body, asymmetry_N=0.5 * rng.uniform(0.1, 0.6) * rng.choice((-1.0, 1.0)) * body.friction_N)


def _exponent(body: Plant, rng: np.random.Generator) -> Plant:
    """Drag of exponent 1.3 to 1.7 or 2.3 to 2.7, equal to the quadratic one at the reference speed."""
    exponent = rng.uniform(1.3, 1.7) + rng.choice((0.0, 1.0))
    return replace(body, exponent=exponent, drag=body.drag * REFERENCE_SPEED_M_PER_S ** (2.0 - exponent))


NULLS: dict[str, Callable[[Plant, np.random.Generator], Plant]] = {
    "nothing": _nothing, "cubic stiffness": _cubic, "Maxwell element": _maxwell, "drift": _nothing,
    "friction asymmetry": _asymmetric, "drag exponent": _exponent,
}  # fmt: skip


@dataclass(frozen=True)
class Campaign:
    """Two recordings and what made them: ``kind`` is a name of `PLANTED` or `NULLS`."""

    kind: str
    noise: str
    seed: int
    truth: Plant
    recordings: tuple[Recording, ...]


def planted(kind: str, noise: str, seed: int) -> Campaign:
    """A campaign with the hidden oscillators of that kind."""
    rng = np.random.default_rng((seed, list(PLANTED).index(kind), list(NOISE).index(noise)))
    return _campaign(kind, noise, seed, plant(kind), rng, 1.0)


def null(seed: int) -> Campaign:
    """A campaign without hidden oscillator; kinds and noises take turns, the rest is drawn from ``seed``."""
    kind = list(NULLS)[seed % len(NULLS)]
    noise = list(NOISE)[seed // len(NULLS) % len(NOISE)]
    rng = np.random.default_rng((seed, 17))
    truth = NULLS[kind](baseline(), rng)
    return _campaign(kind, noise, seed, truth, rng, DRIFT_TIMES if kind == "drift" else 1.0)


def _campaign(
    kind: str, noise: str, seed: int, truth: Plant, rng: np.random.Generator, drift_times: float
) -> Campaign:
    records = tuple(record(truth, x0, noise, rng, f"{x0:g} m", drift_times) for x0 in RELEASES_M)
    return Campaign(kind, noise, seed, truth, records)


@lru_cache(maxsize=256)
def _move(truth: Plant, x0_m: float, early_s: float) -> tuple[Floats, Floats]:
    return simulate(truth, x0_m, early_s + np.arange(round(RECORD_AFTER_RELEASE_S * RATE_HZ)) / RATE_HZ)


def record(
    truth: Plant, x0_m: float, noise: str, rng: np.random.Generator, name: str, drift_times: float = 1.0
) -> Recording:
    """One trial with the sensors of the recovery study; the drift is so many times the ordinary one."""
    moved = _move(truth, x0_m, rng.integers(0, 10) / 10.0 / RATE_HZ)
    conditions = {"spring": "short", "water_depth_m": WATER_DEPTH_M}
    return Recording(name, *seen(x0_m, *moved, noise, rng, drift_times), conditions)
