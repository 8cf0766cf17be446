"""Campaigns with one known thing missing, for the shares of the residual force.

Four releases of an Eq. 15 with the rig's scatter in k, c and friction from trial to trial; what is planted beside it is
what the residual force should be shared out to.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from undertow.conditioning.condition import condition
from undertow.conditioning.motion import Motion
from undertow.discrepancy.shares import Shares, residual_shares
from undertow.equation import registry
from undertow.equation.equation import Equation, equation_15
from undertow.equation.simulate import simulate
from undertow.recording.recording import Recording

PLAIN = equation_15(2637.4, 300.0, 590.0, 109_600.0, 170.0, 1000.0)
RELEASES_M = (0.03, 0.05, 0.07, 0.10)
SCATTER = (0.003, 0.06, 0.05)
"""k, c and friction, relative, 1 sigma: an ordinary rig."""

NOISE_M, NOISE_M_PER_S2 = 2.5e-5, 0.012
RATE_HZ, HOLD_S, MOTION_S = 100.0, 0.5, 10.0
FREE = frozenset({"added_mass", "quadratic_drag"})
"""What is fitted in a wet group; k, c and mu are the dry trials'."""

PLANTED: Mapping[str, tuple[str, float, Mapping[str, float]] | None] = {
    "nothing": None,
    "linear damping, 500 N s/m": ("linear_damping", 500.0, {}),
    "cubic stiffness, 3e6 N/m3": ("cubic_stiffness", 3e6, {}),
    "Stribeck friction, 200 N": ("stribeck_friction", 200.0, {}),
    "relaxation, 8 kN/m, 0.4 s": ("relaxation", 8000.0, {"time_s": 0.4}),
    "hysteresis, 15 kN/m, 5 mm": ("hysteresis", 15_000.0, {"yield_displacement_m": 0.005}),
    "resonator, 60 kg": ("hidden_resonator", 60.0, {"natural_frequency_rad_per_s": 9.0, "damping_ratio": 0.01}),
    "resonator, 200 kg": ("hidden_resonator", 200.0, {"natural_frequency_rad_per_s": 9.0, "damping_ratio": 0.01}),
    "seiche, 300 N": ("external_forcing", 300.0, {"frequency_rad_per_s": 9.0}),
}
"""Name -> term, coefficient, inner parameters; a seiche has another phase in every trial."""


def campaign(name: str, seed: int) -> list[Motion]:
    """Four conditioned trials of one planted truth."""
    rng = np.random.default_rng(seed)
    planted = PLANTED[name]
    motions = []
    for number, x0 in enumerate(RELEASES_M):
        truth = PLAIN
        if planted is not None:
            term, coefficient, inner = planted
            phase = {"phase_rad": float(rng.uniform(0.0, 2.0 * np.pi))} if term == "external_forcing" else {}
            laws = (*PLAIN.terms, registry.find(term, **inner, **phase))
            truth = replace(PLAIN, terms=laws, coefficients=(*PLAIN.coefficients, coefficient))
        motions.append(_released(f"r{number}", truth, x0, rng))
    return motions


def _released(name: str, equation: Equation, x0: float, rng: np.random.Generator) -> Motion:
    own = [c * (1.0 + s * rng.standard_normal()) for c, s in zip(equation.coefficients[:3], SCATTER, strict=True)]
    truth = replace(equation, coefficients=(*own, *equation.coefficients[3:]))
    motion = simulate(truth, x0, np.arange(0.0, MOTION_S, 1.0 / RATE_HZ))
    held = round(HOLD_S * RATE_HZ)
    x, a = np.r_[np.full(held, x0), motion.x], np.r_[np.zeros(held), motion.a]
    channels = {
        "displacement": x + NOISE_M * rng.standard_normal(x.size),
        "acceleration": a + NOISE_M_PER_S2 * rng.standard_normal(a.size),
    }
    return condition(Recording(name, np.arange(x.size) / RATE_HZ, channels))


def shares(name: str, seed: int) -> list[Shares]:
    """Shares of a planted campaign's trials, the smallest release first."""
    motions = campaign(name, seed)
    found = residual_shares(motions, {m.name: PLAIN for m in motions}, FREE)
    return [found[m.name] for m in motions]
