"""Pairs of a simulation and a recording that `undertow differ` is tried on; no simulator here is undertow's.

Simulations: the Eq. 15 of `experiments/eq15_campaign` (its own integrator) and a pendulum by scipy. Recordings: that
Eq. 15 with a rig's own numbers and noise, the virtual flume (potential flow), a real pendulum.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.integrate import solve_ivp

from experiments.eq15_campaign.motion import Body, hold_and_release
from undertow.equation.term import Array

ROOT = Path(__file__).resolve().parents[2]
FLUME = ROOT / "data" / "virtual_flume"
PENDULUM = ROOT / ".." / "shared" / "recordings" / "rotary_pendulum_free_swing" / "pendulum_free_swing_data_01.txt"

RATE_HZ, HOLD_S, MOTION_S = 100.0, 0.5, 10.0
NOISE_M, NOISE_M_PER_S2 = 2.5e-5, 0.012
"""The virtual flume's potentiometer and accelerometer."""

SPRINGS_N_PER_M = {"long": 109_600.0, "short": 403_000.0}
FRICTION_N = {"long": 178.0, "short": 159.0}
DAMPING_NS_PER_M = {"long": 590.0, "short": 821.0}
"""Dry means of the physical test's Tables 1 and 2 (mu times the weight less buoyancy)."""

ADDED_MASS_KG = 300.0
"""What somebody who has not measured it might put into a simulation."""

MASS_KG, DENSITY_KG_PER_M3 = 2637.4, 1000.0
DRAG_COEFFICIENT, AREA_M2 = 2.0, {2.22: 0.2415, 2.29: 0.483, 2.36: 0.7245}

PENDULUM_K, PENDULUM_C = 119.5, 0.47
"""Viscous-only pendulum, 1/s^2 and 1/s: the published form, its two numbers fitted to the recording."""


@dataclass(frozen=True)
class Pair:
    """Two files, the config that maps them ("" where names suffice), and what the simulation lacks."""

    name: str
    simulation: Path
    recording: Path
    config: Path | None
    lacks: tuple[str, ...]


def body_of(spring: str, depth_m: float) -> Body:
    """Eq. 15 with dry means and textbook numbers for the water."""
    drag = 0.5 * DENSITY_KG_PER_M3 * DRAG_COEFFICIENT * AREA_M2[depth_m]
    return Body(
        MASS_KG + ADDED_MASS_KG, DAMPING_NS_PER_M[spring], SPRINGS_N_PER_M[spring], FRICTION_N[spring], drag
    )


def write_release(path: Path, body: Body, x0_m: float, noise: int | None = None) -> Path:
    """One release as a table: s, m, m/s2; with the sensors' noise from a seed, or exact."""
    time = np.arange(round((HOLD_S + MOTION_S) * RATE_HZ)) / RATE_HZ
    motion = hold_and_release(body, x0_m, time - HOLD_S)
    x, a = motion.x, motion.a
    if noise is not None:
        rng = np.random.default_rng(noise)
        x, a = x + NOISE_M * rng.standard_normal(x.size), a + NOISE_M_PER_S2 * rng.standard_normal(a.size)
    table = pd.DataFrame({"time_s": time, "disp_m": x, "accel_mps2": a})
    table.to_csv(path, index=False, float_format="%.7f")
    return path


def swing(time: Array, angle: float) -> Array:
    """Angle (rad) of the viscous-only pendulum let go at ``angle``, (n,)."""

    def slope(_: float, y: Array) -> list[float]:
        return [y[1], -PENDULUM_K * math.sin(y[0]) - PENDULUM_C * y[1]]

    found = solve_ivp(slope, (0.0, float(time[-1])), [angle, 0.0], "DOP853", time, rtol=1e-10, atol=1e-12)
    return np.asarray(found.y[0], dtype=np.float64)


def pairs(folder: Path) -> Iterator[Pair]:
    """All pairs, written into a folder as they are asked for."""
    own = body_of("long", 2.36)
    made = write_release(folder / "eq15_long_2.36.csv", own, 0.1)
    rig = replace(own, k_N_per_m=1.003 * own.k_N_per_m, c_Ns_per_m=1.06 * own.c_Ns_per_m)
    config = flume_config(folder)
    yield Pair("Eq. 15, this rig's own k and c", made, write_release(folder / "rig.csv", rig, 0.08, 1), config, ())
    damped = replace(own, c_Ns_per_m=own.c_Ns_per_m + 1200.0)
    recording = write_release(folder / "damped.csv", damped, 0.08, 2)
    yield Pair("Eq. 15, 1200 N s/m more", made, recording, config, ("linear_damping",))
    index = pd.read_csv(FLUME / "campaign.csv")
    for spring, release in (("long", 0.066), ("short", 0.024)):
        for depth in AREA_M2:
            row = index[
                (index.spring == spring) & (index.water_depth_m == depth) & np.isclose(index.x0_target_m, release)
            ].iloc[0]
            made = write_release(folder / f"eq15_{spring}_{depth}.csv", body_of(spring, depth), release)
            name = f"virtual flume, {spring} spring, {depth} m"
            yield Pair(name, made, FLUME / row.file, config, ("hidden_resonator",))
    if PENDULUM.is_file():
        yield pendulum_pair(folder)


def flume_config(folder: Path) -> Path:
    """Which columns are what in the flume's recordings, for both files."""
    path = folder / "flume.yaml"
    path.write_text(
        "name: differ\n"
        "recordings:\n"
        f"  files: {FLUME.as_posix()}/r*.csv.gz\n"
        "  channels:\n"
        "    time: {column: time_s, unit: s}\n"
        "    displacement: {column: disp_m, unit: m}\n"
        "    acceleration: {column: accel_mps2, unit: m/s^2}\n"
        "equation:\n"
        "  terms: [stiffness, viscous_damping, coulomb_friction, added_mass, quadratic_drag]\n",
        encoding="utf-8",
    )
    return path


def pendulum_pair(folder: Path) -> Pair:
    """A real pendulum let go, and the viscous-only one from its first free turning point on."""
    lines = PENDULUM.read_text(encoding="utf-8").splitlines()[2:]
    angle = np.array([float(line) for line in lines])
    free = angle[750:]  # the hand is off from 0.75 s on (README of the recording)
    recorded = folder / "pendulum.csv"
    time = np.arange(free.size) / 1000.0
    pd.DataFrame({"time_s": time, "angle_deg": free}).to_csv(recorded, index=False, float_format="%.6f")
    top = float(np.max(np.abs(free[:900])))
    made = folder / "pendulum_viscous.csv"
    turned = np.degrees(swing(time, math.radians(top)))
    pd.DataFrame({"time_s": time, "angle_deg": turned}).to_csv(made, index=False, float_format="%.6f")
    config = folder / "pendulum.yaml"
    config.write_text(
        "name: pendulum\nrecordings:\n  files: pendulum.csv\n  channels: {time: {column: time_s, unit: s}, "
        "displacement: {column: angle_deg, unit: deg}}\nequation: {terms: [sine_restoring, viscous_damping], "
        "coordinate: rotation}\n",
        encoding="utf-8",
    )
    return Pair("real pendulum, viscous-only model", made, recorded, config, ("coulomb_friction",))
