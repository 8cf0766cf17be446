"""Synthetic campaigns for the study of coverage: one spring, dry and at one water level, a few releases each.

The equation is Eq. 15 with the flume report's numbers (experiments/eq15_campaign/tables.py); k, c and mu differ from
trial to trial, and the instruments are no better than real ones: coloured noise, drift, offsets, gains, clocks that
disagree by up to 5 ms. Belongs here: what is drawn and recorded. Does not belong here: what is estimated (study.py).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from experiments.eq15_campaign import tables
from undertow.equation.equation import Equation, equation_15
from undertow.equation.simulate import simulate
from undertow.recording.recording import Recording

Floats = NDArray[np.float64]

RATE_HZ = 125.0
HOLD_S = 0.6
RECORD_AFTER_RELEASE_S = 8.0
CLOCK_S = 5e-3
"""Largest difference between the two channels' clocks, and between the stamps' and the release, s."""

WHITE = {"displacement": 5e-5, "acceleration": 0.05}
"""Standard deviation of the white part of the noise, m and m/s^2."""

COLOURED_SHARE = (0.3, 1.0)
"""Standard deviation of the coloured part over the white part's: drawn uniformly for every channel of a trial."""

COLOUR_TIME_S = (0.01, 0.1)
"""Correlation time of the coloured part (first-order autoregressive), drawn uniformly."""

DRIFT = {"displacement": 2e-4, "acceleration": 0.02}
DRIFT_PERIODS_S = (15.0, 40.0)
OFFSET = {"displacement": 5e-4, "acceleration": 0.025}
GAIN_STD = 0.002
RELEASE_SCATTER = 0.02

SCATTERS = ("tables", "practice")


@dataclass(frozen=True)
class Truth:
    """What a campaign is made from: the rig's mean k, c, mu, the water's m_a and C_d, the scatter of k, c, mu."""

    spring: str
    water_depth_m: float
    k_N_per_m: float
    c_Ns_per_m: float
    mu: float
    added_mass_kg: float
    drag_coefficient: float
    scatter: dict[str, float]

    def value(self, name: str) -> float:
        """A parameter by its name in levels.csv."""
        return float(getattr(self, name))


@dataclass(frozen=True)
class Campaign:
    """A campaign's truth with its dry and its wet recordings."""

    truth: Truth
    dry: tuple[Recording, ...]
    wet: tuple[Recording, ...]


def draw_scatter(kind: str, rng: np.random.Generator) -> dict[str, float]:
    """Relative standard deviations of k, c, mu: of Tables 1 and 2 (c 20 to 26 %), or as a careful rig repeats (6 %)."""
    if kind == "tables":
        return {"k": 0.004, "c": float(rng.uniform(0.20, 0.26)), "mu": float(rng.uniform(0.06, 0.11))}
    return {"k": 0.003, "c": 0.06, "mu": 0.05}


def draw_truth(kind: str, rng: np.random.Generator) -> Truth:
    """One spring and one level of the report, drawn alike often."""
    spring = str(rng.choice(["long", "short"]))
    depth = float(rng.choice(tables.WET_DEPTHS_M))
    k, c, mu = tables.dry_mean(spring)
    added, drag = tables.ADDED_MASS_KG[spring][depth], tables.DRAG_COEFFICIENT[spring][depth]
    return Truth(spring, depth, k, c, mu, added, drag, draw_scatter(kind, rng))


def normal_force(depth_m: float) -> float:
    """Weight less buoyancy, N; the whole weight when dry."""
    displaced = tables.submerged_volume(depth_m) * tables.WATER_DENSITY_KG_PER_M3
    return (tables.STRUCTURE_MASS_KG - displaced) * tables.GRAVITY_M_PER_S2


def draw_equation(truth: Truth, depth_m: float, rng: np.random.Generator) -> Equation:
    """The equation of one trial: its own k, c, mu about the rig's means."""
    k, c, mu = (
        mean * (1.0 + truth.scatter[name] * float(rng.standard_normal()))
        for name, mean in (("k", truth.k_N_per_m), ("c", truth.c_Ns_per_m), ("mu", truth.mu))
    )
    wet = depth_m != tables.DRY_DEPTH_M
    per_drag = 0.5 * tables.WATER_DENSITY_KG_PER_M3 * tables.REFERENCE_AREA_M2
    friction = mu * normal_force(depth_m if wet else 0.0)
    added, drag = (truth.added_mass_kg, truth.drag_coefficient * per_drag) if wet else (0.0, 0.0)
    return equation_15(tables.STRUCTURE_MASS_KG, added, max(c, 0.0), k, friction, drag)


def read_sensor(exact: Floats, time: Floats, quantity: str, gain: float, rng: np.random.Generator) -> Floats:
    """What a sensor makes of a quantity (n,): gain, offset, drift, white and coloured noise."""
    drift = 0.5 * rng.uniform(-1.0, 1.0) * DRIFT[quantity]
    period, phase = rng.uniform(*DRIFT_PERIODS_S), rng.uniform(0.0, 2.0 * np.pi)
    slow = drift * (np.sin(2.0 * np.pi * time / period + phase) - np.sin(phase))
    memory = float(np.exp(-1.0 / (RATE_HZ * rng.uniform(*COLOUR_TIME_S))))
    coloured = _coloured(time.size, memory, rng) * WHITE[quantity] * rng.uniform(*COLOURED_SHARE)
    white = WHITE[quantity] * rng.standard_normal(time.size)
    return gain * exact + rng.uniform(-1.0, 1.0) * OFFSET[quantity] + slow + coloured + white


def _coloured(count: int, memory: float, rng: np.random.Generator) -> Floats:
    """Stationary autoregressive noise of unit variance: n_i = memory n_(i-1) + sqrt(1 - memory^2) e_i."""
    kicks = np.sqrt(1.0 - memory**2) * rng.standard_normal(count)
    kicks[0] = rng.standard_normal()
    return np.asarray(lfilter([1.0], [1.0, -memory], kicks), dtype=np.float64)


def record(
    truth: Truth, depth_m: float, x0_m: float, gains: dict[str, float], rng: np.random.Generator, name: str
) -> Recording:
    """One trial as recorded: each channel samples the motion with its own clock."""
    equation = draw_equation(truth, depth_m, rng)
    x0 = x0_m * (1.0 + rng.uniform(-RELEASE_SCATTER, RELEASE_SCATTER))
    time = np.arange(round((HOLD_S + RECORD_AFTER_RELEASE_S) * RATE_HZ)) / RATE_HZ
    release = HOLD_S + rng.uniform(0.0, 1.0 / RATE_HZ)
    channels = {}
    for quantity in ("displacement", "acceleration"):
        late = rng.uniform(0.0, CLOCK_S) if quantity == "acceleration" else 0.0
        since = time + rng.choice([-1.0, 1.0]) * late - release
        free = since >= 0.0
        motion = simulate(equation, x0, since[free])
        exact = np.full(time.size, x0 if quantity == "displacement" else 0.0)
        exact[free] = motion.x if quantity == "displacement" else motion.a
        channels[quantity] = read_sensor(exact, time, quantity, gains[quantity], rng)
    return Recording(name, time, channels, {"spring": truth.spring, "water_depth_m": depth_m})


def amplitudes(spring: str, count: int) -> Floats:
    """Releases of ``count`` trials (m), spread as evenly in ratio as the report's own range."""
    smallest, *_, largest = tables.RELEASES_M[spring]
    return np.asarray(np.geomspace(smallest, largest, count), dtype=np.float64)


def make_campaign(kind: str, count: int, seed: int) -> Campaign:
    """A campaign of ``count`` dry and ``count`` wet trials, everything drawn from ``seed``."""
    rng = np.random.default_rng([SCATTERS.index(kind), count, seed])
    truth = draw_truth(kind, rng)
    gains = {name: 1.0 + GAIN_STD * float(rng.standard_normal()) for name in WHITE}
    both = [
        tuple(
            record(truth, depth, x0, gains, rng, f"{label}{i}")
            for i, x0 in enumerate(amplitudes(truth.spring, count).tolist())
        )
        for label, depth in (("dry", tables.DRY_DEPTH_M), ("wet", truth.water_depth_m))
    ]
    return Campaign(truth, *both)
