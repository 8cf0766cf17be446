"""The decay that the benchmarks share, and undertow's fit of it from samples to numbers.

The release of 0.107 m on the long spring at 2.57 m water (k, c, mu of Table 1, m_a and C_d of Table 4), integrated by
scipy, 1000 Hz, 0.2 mm noise. Belongs here: the record and the fit. Does not belong here: clocks and other solvers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from experiments.eq15_campaign import tables
from experiments.eq15_campaign.motion import Floats, simulate
from experiments.recovery.releases import plant
from undertow.equation.kernel import N_SLOTS, SLOT
from undertow.likelihood import output_error
from undertow.likelihood.problem import SAMPLES_PER_PERIOD, Channel, Link, Problem, TrialProblem, Unknown

RATE_HZ = 1000.0
NOISE_M = 2e-4
START = (0.2, 5.0)
"""Every search starts at m_a = 0.2 m, C_d = 5, as Method 1 in plain Python does."""


@dataclass(frozen=True)
class Record:
    """Samples of one release: ``t`` (n,) s, ``x`` (n,) m, release ``x0`` (m), what is known and the truth sought."""

    t: Floats
    x: Floats
    x0: float
    mass: float
    k: float
    c: float
    friction: float
    drag_unit: float
    truth: tuple[float, float]
    period_s: float


def record(seconds: float, seed: int = 0) -> Record:
    """The first ``seconds`` after the release; the body sticks at 8.9 s."""
    truth = plant("long", 2.57)
    t = np.arange(round(seconds * RATE_HZ)) / RATE_HZ
    exact = simulate(truth.body, 0.107, t).x
    body = truth.body
    noise = NOISE_M * np.random.default_rng(seed).standard_normal(t.size)
    return Record(
        t, exact + noise, 0.107, tables.STRUCTURE_MASS_KG, body.k_N_per_m, body.c_Ns_per_m, body.friction_N,
        0.5 * tables.WATER_DENSITY_KG_PER_M3 * tables.REFERENCE_AREA_M2,
        (truth.added_mass_kg, truth.drag_coefficient), 2.0 * np.pi * np.sqrt(body.inertia_kg / body.k_N_per_m),
    )  # fmt: skip


def problem(data: Record) -> Problem:
    """(m_a, C_d) from the samples' means in cells, 50 a period, as every fit of undertow sees a recording."""
    m = round(data.period_s / SAMPLES_PER_PERIOD * RATE_HZ)
    n = data.t.size // m
    base = np.zeros(N_SLOTS)
    known = {"mass": data.mass, "k1": data.k, "c1": data.c, "fc": data.friction, "x0": data.x0}
    for name, value in known.items():
        base[SLOT[name]] = value
    links = (Link(SLOT["mass"], 0), Link(SLOT["q"], 1, data.drag_unit))
    share = np.full(m, 1.0 / m)
    values = data.x[: n * m].reshape(n, m) @ share
    channel = Channel("displacement", values, NOISE_M / np.sqrt(m))
    t = data.t[: n * m].reshape(n, m) @ share
    unknowns = (
        Unknown("added_mass_kg", START[0] * data.mass, lower=-0.9 * data.mass), Unknown("drag", START[1])
    )  # fmt: skip
    return Problem(unknowns, (TrialProblem("r", t, base, links, (channel,), -1, m / RATE_HZ, data.period_s),))


def identify(data: Record) -> tuple[float, float]:
    """(m_a in kg, C_d) from the samples."""
    values = output_error.fit(problem(data)).values
    return float(values[0]), float(values[1])
