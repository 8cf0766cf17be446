"""A pendulum whose restoring moment differs from trial to trial as a spring's stiffness does is not accused of it."""

from __future__ import annotations

import numpy as np
import pandas as pd

from undertow.campaign.config import load
from undertow.campaign.run import run
from undertow.comparison.deviations import size_in
from undertow.equation import registry
from undertow.equation.equation import Equation
from undertow.equation.kernel import SLOT
from undertow.equation.simulate import simulate

INERTIA, MOMENT, RATE_HZ, SCATTER = 0.0245, 0.30, 60.0, 0.003
CONFIG = """
name: pendulum
recordings:
  index: index.csv
  channels: {time: {column: t, unit: s}, displacement: {column: angle, unit: rad}}
trials: {group_by: [bearing], dry: none}
equation: {terms: [sine_restoring, viscous_damping, coulomb_friction], coordinate: rotation}
specimen: {mass_kg: 0.0245, scatter: {k: 0.003, c: 0.05, mu: 0.05}}
identify: [output_error]
"""


def test_a_pendulum_whose_moment_scatters_lacks_nothing(tmp_path):
    rng = np.random.default_rng(4)
    t = np.arange(0.0, 30.0, 1.0 / RATE_HZ)
    for number, release in enumerate((0.9, 0.7, 0.5, 0.35, 0.25)):
        laws = tuple(registry.find(name) for name in ("sine_restoring", "viscous_damping", "coulomb_friction"))
        moment = MOMENT * (1.0 + SCATTER * rng.standard_normal())
        swing = simulate(Equation(laws, (moment, 0.0012, 0.0006), mass_kg=INERTIA), release, t)
        held = np.full(30, release)
        angle = np.concatenate([held, swing.x]) + 2e-4 * rng.standard_normal(held.size + t.size)
        table = pd.DataFrame({"t": np.arange(angle.size) / RATE_HZ, "angle": angle})
        table.to_csv(tmp_path / f"r{number}.csv", index=False)
    index = pd.DataFrame({"file": [f"r{i}.csv" for i in range(5)], "bearing": "new"})
    index.to_csv(tmp_path / "index.csv", index=False)
    (tmp_path / "config.yaml").write_text(CONFIG)
    (group,) = run(load(tmp_path / "config.yaml"), jobs=1).groups
    assert group.verdict.status == "nothing_missing"


def test_the_stiffness_of_a_pendulum_is_what_its_scatter_is_a_share_of():
    theta = np.zeros(len(SLOT))
    theta[SLOT["k1"]], theta[SLOT["ks"]], theta[SLOT["c1"]] = 2.0, -3.0, -4.0
    assert (size_in(theta, "k1"), size_in(theta, "c1")) == (5.0, 4.0)
