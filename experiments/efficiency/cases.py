"""The fits that efficiency and blind starts are measured on: Eq. 15 with 2, 4 or 5 unknowns, and a hidden oscillator.

Eq. 15's motion is scipy's (DOP853 split at reversals); 1 kHz samples in cells, 50 a period, white noise. Belongs here:
what is fitted to what. Does not belong here: studies of it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from experiments.eq15_campaign import tables
from experiments.eq15_campaign.motion import Floats, simulate
from experiments.recovery.releases import plant
from undertow.equation.kernel import N_SLOTS, SLOT, integrate
from undertow.likelihood.problem import SAMPLES_PER_PERIOD, Channel, Link, Problem, TrialProblem, Unknown

RECORD_S = 15.0
RATE_HZ = 1000.0
EQ15 = ("m_a", "C_d", "c", "mu", "x0")
"""Unknowns of Eq. 15 in the order in which they are freed: the first 2, 4 or 5."""

HIDDEN = ("m_a", "C_d", "m_s", "w_s", "z_s")
HIDDEN_TRUTH = (350.0, 8.0, 300.0, 9.6, 0.02)
HIDDEN_BOUNDS = (
    (-0.9 * tables.STRUCTURE_MASS_KG, np.inf), (-np.inf, np.inf), (0.0, 2.0 * tables.STRUCTURE_MASS_KG),
    (0.5, 40.0), (0.0, 1.0),
)  # fmt: skip
HIDDEN_STIFFNESS = 404000.0
HIDDEN_RELEASE_M = 0.033
ACCELERATION_NOISE = 0.1
EXACT_STEPS = 400
"""Steps a period of the hidden oscillator's motion (experiments/integrator: exact to 1e-10 of the release)."""

RANGES = {
    "m_a": (0.0, 2600.0), "C_d": (0.0, 40.0), "c": (100.0, 2000.0), "mu": (1e-3, 2e-2), "x0": (0.8, 1.2),
    "m_s": (20.0, 1000.0), "w_s": (3.0, 20.0), "z_s": (2e-3, 0.2),
}  # fmt: skip
"""Where blind starts come from, uniform (m_s, z_s in their logarithm): kg, 1, N s/m, 1, share of x0, kg, rad/s, 1."""
LOGARITHMIC = ("m_s", "z_s")


@dataclass(frozen=True)
class Case:
    """A fit without noise: its problem, the truth (p,), and the noise of each cell's mean."""

    problem: Problem
    truth: Floats
    names: tuple[str, ...]

    def noisy(self, rng: np.random.Generator) -> Problem:
        """The problem with a new realisation of the noise."""
        trial = self.problem.trials[0]
        channels = tuple(
            replace(c, values=c.values + c.sigma * rng.standard_normal(c.values.size)) for c in trial.channels
        )
        return Problem(self.problem.unknowns, (replace(trial, channels=channels),))

    def start(self, rng: np.random.Generator) -> Floats:
        """A blind start (p,), anywhere in `RANGES`."""
        values = []
        for name, truth in zip(self.names, self.truth, strict=True):
            low, high = RANGES[name]
            if name in LOGARITHMIC:
                values.append(float(np.exp(rng.uniform(np.log(low), np.log(high)))))
            else:
                values.append(float(rng.uniform(low, high)) * (truth if name == "x0" else 1.0))
        return np.array(values)


def _cells(period_s: float, end_s: float) -> tuple[Floats, int]:
    """Samples' instants (n, m) in cells, and m; the first one a step after the release."""
    m = max(1, round(period_s / SAMPLES_PER_PERIOD * RATE_HZ))
    n = int(end_s * RATE_HZ) // m
    return (np.arange(1, n * m + 1) / RATE_HZ).reshape(n, m), m


def eq15(spring: str, water_depth_m: float, count: int, noise_m: float) -> Case:
    """Eq. 15 at one level, its largest release until it sticks; the first ``count`` of `EQ15` unknown, k known."""
    truth = plant(spring, water_depth_m)
    x0 = tables.RELEASES_M[spring][-1]
    period = 2.0 * np.pi * np.sqrt(truth.body.inertia_kg / truth.k_N_per_m)
    stopped = simulate(truth.body, x0, np.array([0.0, RECORD_S])).stopped_s or RECORD_S
    instants, m = _cells(period, min(stopped, RECORD_S))
    x = simulate(truth.body, x0, instants.ravel()).x.reshape(instants.shape).mean(axis=1)
    drag_unit = 0.5 * tables.WATER_DENSITY_KG_PER_M3 * tables.REFERENCE_AREA_M2
    values = np.array([truth.added_mass_kg, truth.drag_coefficient, truth.c_Ns_per_m, truth.mu, x0])
    base = np.zeros(N_SLOTS)
    base[SLOT["mass"]], base[SLOT["k1"]] = tables.STRUCTURE_MASS_KG, truth.k_N_per_m
    slots = (("mass", 1.0), ("q", drag_unit), ("c1", 1.0), ("fc", truth.normal_force_N), ("x0", 1.0))
    links = []
    for i, (slot, factor) in enumerate(slots):
        if i < count:
            links.append(Link(SLOT[slot], i, factor))
        else:
            base[SLOT[slot]] = factor * values[i]
    channel = Channel("displacement", x, noise_m / np.sqrt(m))
    trial = TrialProblem(
        f"{spring} {water_depth_m:g}", instants.mean(axis=1), base, tuple(links), (channel,), -1,
        m / RATE_HZ, period,
    )  # fmt: skip
    lower = {"m_a": -0.9 * tables.STRUCTURE_MASS_KG}
    unknowns = tuple(
        Unknown(name, float(values[i]), lower=lower.get(name, -np.inf)) for i, name in enumerate(EQ15[:count])
    )
    return Case(Problem(unknowns, (trial,)), values[:count], EQ15[:count])


def hidden(noise_m: float) -> Case:
    """A body with a hidden oscillator, displacement and acceleration recorded; c, mu, k and the release known."""
    truth = plant("short", 2.36)
    drag_unit = 0.5 * tables.WATER_DENSITY_KG_PER_M3 * tables.REFERENCE_AREA_M2
    values = np.array(HIDDEN_TRUTH)
    base = np.zeros(N_SLOTS)
    known = {
        "mass": tables.STRUCTURE_MASS_KG, "k1": HIDDEN_STIFFNESS, "c1": truth.c_Ns_per_m,
        "fc": truth.mu * truth.normal_force_N, "x0": HIDDEN_RELEASE_M,
    }  # fmt: skip
    base[[SLOT[name] for name in known]] = list(known.values())
    slots = (("mass", 1.0), ("q", drag_unit), ("hm1", 1.0), ("hw1", 1.0), ("hz1", 1.0))
    links = tuple(Link(SLOT[slot], i, factor) for i, (slot, factor) in enumerate(slots))
    theta = base.copy()
    for link in links:
        theta[link.slot] += link.factor * values[link.unknown]
    period = float(2.0 * np.pi * np.sqrt(theta[SLOT["mass"]] / HIDDEN_STIFFNESS))
    instants, m = _cells(period, RECORD_S)
    none = np.zeros(0, dtype=np.int64)
    x, _, a = (part[:, 0] for part in integrate(theta, none, instants.ravel(), period / EXACT_STEPS)[:3])
    channels = tuple(
        Channel(quantity, exact.reshape(instants.shape).mean(axis=1), noise / np.sqrt(m))
        for quantity, exact, noise in (("displacement", x, noise_m), ("acceleration", a, ACCELERATION_NOISE))
    )
    unknowns = tuple(
        Unknown(name, value, lower=lower, upper=upper)
        for name, value, (lower, upper) in zip(HIDDEN, HIDDEN_TRUTH, HIDDEN_BOUNDS, strict=True)
    )
    trial = TrialProblem("hidden", instants.mean(axis=1), base, links, channels, -1, m / RATE_HZ, period)
    return Case(Problem(unknowns, (trial,)), values, HIDDEN)
