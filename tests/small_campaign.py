"""Small campaigns on disk for tests of the commands: exact motions at 100 Hz with a little noise, one known truth."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from experiments.eq15_campaign.motion import Body, simulate

BODY = Body(inertia_kg=2637.4, c_Ns_per_m=590.0, k_N_per_m=109_600.0, friction_N=150.0, drag_Ns2_per_m2=0.0)
HOLD_S, MOTION_S, RATE_HZ = 0.5, 5.0, 100.0
NOISE_M, NOISE_M_PER_S2 = 1e-4, 2e-2

CONFIG = """\
name: small
recordings:
  index: campaign.csv
  channels:
    time: {column: t, unit: s}
    displacement: {column: x, unit: m}
    acceleration: {column: a, unit: m/s^2}
trials:
  group_by: [spring]
specimen:
  mass_kg: 2637.4
equation:
  terms: [stiffness, viscous_damping, coulomb_friction]
identify: [sindy]
discrepancy: {suspects: []}
"""

Table = NDArray[np.float64]


@dataclass(frozen=True)
class Campaign:
    """A campaign's folder, its config and the names of its files."""

    folder: Path
    config: Path
    files: tuple[str, ...]

    def edit(self, old: str, new: str) -> None:
        """Replace a text of the config that must be there."""
        text = self.config.read_text()
        assert old in text, old
        self.config.write_text(text.replace(old, new))


@cache
def _exact(x0_m: float) -> tuple[Table, Table, Table]:
    """Time (s), displacement (m) and acceleration (m/s2) of a hold and the motion after it, each (n,)."""
    after = np.arange(0.0, MOTION_S, 1.0 / RATE_HZ)
    motion = simulate(BODY, x0_m, after)
    held = round(HOLD_S * RATE_HZ)
    time = np.arange(held + after.size) / RATE_HZ
    return time, np.r_[np.full(held, x0_m), motion.x], np.r_[np.zeros(held), motion.a]


def recorded(x0_m: float, seed: int) -> Table:
    """One trial as recorded, (n, 3): time in s, displacement in m, acceleration in m/s2."""
    rng = np.random.default_rng(seed)
    time, x, a = _exact(x0_m)
    x = x + NOISE_M * rng.standard_normal(x.size)
    return np.column_stack([time, x, a + NOISE_M_PER_S2 * rng.standard_normal(a.size)])


def write_table(path: Path, table: Table, header: str = "t,x,a") -> None:
    """A table as CSV."""
    np.savetxt(path, table, delimiter=",", header=header, comments="", fmt="%.8g")


def make_campaign(folder: Path, amplitudes_m: Sequence[float], springs: Sequence[str] = ("long",)) -> Campaign:
    """A campaign of one trial an amplitude and spring; all springs are the same one, under different names."""
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for seed, (spring, x0) in enumerate((s, x) for s in springs for x in amplitudes_m):
        name = f"r{seed:02d}.csv"
        write_table(folder / name, recorded(x0, seed))
        files.append((name, spring))
    rows = [f"{name},{spring}" for name, spring in files]
    (folder / "campaign.csv").write_text("\n".join(["file,spring", *rows]) + "\n")
    config = folder / "config.yaml"
    config.write_text(CONFIG)
    return Campaign(folder, config, tuple(name for name, _ in files))


def amplitudes(count: int) -> Iterator[float]:
    """So many releases between 20 and 60 mm; five different ones, because each takes a while to integrate."""
    return (0.02 + 0.01 * (i % 5) for i in range(count))
