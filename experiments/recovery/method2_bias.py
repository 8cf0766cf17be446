"""What Method 2 makes of exact motions with the values of Tables 4 and 6: its biases beside their closed forms.

    python -m experiments recovery.method2_bias      # writes method2_bias.md here

Largest release of each level, no noise, the instants found on the exact motion. Recordings with sensors are elsewhere.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from experiments.eq15_campaign import tables
from experiments.eq15_campaign.motion import simulate
from experiments.recovery.releases import Truth, plant
from undertow.methods.method2 import Instant, added_mass_at_peak, drag_at_crossing, friction_bias_kg

FILE = Path(__file__).resolve().parent / "method2_bias.md"
DURATION_S, SAMPLES = 1.5, 150_001
HALF_DRAG = 0.5 * tables.WATER_DENSITY_KG_PER_M3 * tables.REFERENCE_AREA_M2
HEADER = """# Method 2 on exact motions

m_a by Eq. 19 just before the first turning point, where |x''| is largest; its error beside -mu N / |x''|, what leaving
friction out does. C_d at the first zero crossing of x: with the inertia kept (m + that m_a), with the inertia of the
peak's balance with friction in it, and as printed (Eq. 21, no inertia).

| spring | H, m | m_a, kg | Eq. 19 | error | -mu N / abs(x'') | C_d | m + m_a | with friction | as printed |
|---|---|---|---|---|---|---|---|---|---|
"""


def row(truth: Truth) -> str:
    """One level: errors of both balances on the largest release's exact motion."""
    body = truth.body
    times = np.linspace(0.0, DURATION_S, SAMPLES)
    moved = simulate(body, tables.RELEASES_M[truth.spring][-1], times)
    turn = int(np.searchsorted(times, moved.reversals_s[1])) - 1
    zero = int(np.flatnonzero(moved.x < 0.0)[0])
    peak = Instant(times[turn], moved.x[turn], moved.v[turn], moved.a[turn])
    crossing = Instant(times[zero], 0.0, moved.v[zero], moved.a[zero])
    added = added_mass_at_peak(peak, body.k_N_per_m, tables.STRUCTURE_MASS_KG)
    bias = friction_bias_kg(body.friction_N, peak.a)
    inertias = (tables.STRUCTURE_MASS_KG + added, tables.STRUCTURE_MASS_KG + added - bias, 0.0)
    drags = [
        drag_at_crossing(crossing, inertia, body.c_Ns_per_m, body.friction_N, HALF_DRAG) for inertia in inertias
    ]
    return (
        f"| {truth.spring} | {truth.water_depth_m} | {truth.added_mass_kg:.1f} | {added:.1f} "
        f"| {added - truth.added_mass_kg:.1f} | {bias:.1f} | {truth.drag_coefficient:.2f} | "
        + " | ".join(f"{drag:.2f}" for drag in drags)
        + " |\n"
    )


def main() -> int:
    """Write the table."""
    levels = [plant(spring, depth) for spring in ("long", "short") for depth in tables.WET_DEPTHS_M]
    FILE.write_text(HEADER + "".join(row(truth) for truth in levels))
    return 0
