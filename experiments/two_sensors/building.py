"""A model building whose tuned mass damper the analysis never sees: the hidden coordinate against the damper's sensor.

Two time-of-flight sensors (tmd_two_sensors): sensor 2 on the building, sensor 1 on the damper. Only sensor 2 is fitted,
from 9.45 s on, with a hidden resonator whose state at that instant is free.

One record with a free start gives four numbers, two frequencies and two decays, for five unknowns (stiffness and
damping of the building, mass, frequency and damping of what is hidden): the building's own damping is therefore taken
once as zero and once as free, and both are said.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from undertow.comparison.joint import fit_joint
from undertow.comparison.level import Addend, Member, make_level
from undertow.comparison.suspects import SUSPECTS
from undertow.conditioning.motion import Motion
from undertow.equation.kernel import SLOT, integrate
from undertow.equation.simulate import fastest_frequency
from undertow.equation.term import Array
from undertow.likelihood.fit import Specimen
from undertow.likelihood.output_error import parameter_vector
from undertow.likelihood.problem import TrialOptions
from undertow.methods.baseline import group_model, terms_by_name

STEPS_PER_PERIOD = 60
"""Steps of the integrator a period of the fastest mode."""

OFF_FIRST_GUESS = 2.0
"""First guess of the mean squared residual in units of the sensor's noise."""

CLIPPED = 0.5
"""Sensor 1 reads 0 mm below its range."""


@dataclass(frozen=True)
class Hidden:
    """What sensor 2 alone says: R2 of the fit, coupled frequencies (Hz), mass over the building's,
    frequency (rad/s) and damping ratio of the hidden resonator, correlation of its coordinate with sensor 1."""

    terms: tuple[str, ...]
    r2: float
    frequencies_hz: tuple[float, ...]
    mass_ratio: float
    frequency_rad_per_s: float
    damping_ratio: float
    correlation: float


def hidden_from(motion: Motion, terms: Sequence[str], start_rad_per_s: float, damper: Path) -> Hidden:
    """Fit sensor 2 with these terms and one hidden resonator, then look at sensor 1."""
    model = group_model(terms_by_name(terms), [motion], Specimen(), None, dry=False, anchored=False)
    level = make_level([Member("all", model, (motion,), TrialOptions(), True)])
    resonator = next(s for s in SUSPECTS if s.name == "hidden_resonator")
    addend = Addend("hidden_resonator", resonator.additions(level.scales, start_rad_per_s))
    fit = fit_joint(level, (addend,), 1.0, {}, OFF_FIRST_GUESS, growing=True)
    trial = fit.solution.problem.trials[0]
    theta = parameter_vector(trial, fit.solution.values)
    t = motion.windowed("t")
    late = fit.solution.value(f"shift_s[{motion.name}]") if trial.shift >= 0 else 0.0
    step = 2.0 * math.pi / fastest_frequency(theta) / STEPS_PER_PERIOD
    times = np.ascontiguousarray(np.maximum(t + late, 0.0))
    x, _, _, states, _ = integrate(theta, np.zeros(0, dtype=np.int64), times, step)
    measured = motion.recorded("displacement")[motion.inside]
    left = measured - fit.solution.value(f"rest_m[{motion.name}]") - x[:, 0]
    return Hidden(
        tuple(terms), float(1.0 - np.sum(left**2) / np.sum((measured - measured.mean()) ** 2)), coupled_modes(theta),
        float(theta[SLOT["hm1"]] / theta[SLOT["mass"]]), float(theta[SLOT["hw1"]]), float(theta[SLOT["hz1"]]),
        _correlation(motion.window.release_s + t, states[:, 0], damper),
    )  # fmt: skip


def coupled_modes(theta: Array) -> tuple[float, ...]:
    """Frequencies (Hz) of body and hidden resonator together, the slower first."""
    mass, share = float(theta[SLOT["mass"]]), float(theta[SLOT["hm1"]])
    w, z = float(theta[SLOT["hw1"]]), float(theta[SLOT["hz1"]])
    inertia = np.array([[mass + share, share], [1.0, 1.0]])
    damping = np.diag([float(theta[SLOT["c1"]]), 2.0 * z * w])
    stiffness = np.diag([float(theta[SLOT["k1"]]), w * w])
    below = np.hstack([-np.linalg.solve(inertia, stiffness), -np.linalg.solve(inertia, damping)])
    roots = np.linalg.eigvals(np.vstack([np.hstack([np.zeros((2, 2)), np.eye(2)]), below]))
    upper = sorted((root for root in roots if root.imag > 0.0), key=lambda root: root.imag)
    return tuple(float(root.imag / (2.0 * math.pi)) for root in upper)


def _correlation(time: Array, hidden: Array, damper: Path) -> float:
    """Correlation of the hidden coordinate with sensor 1 where that is not clipped; its sign is the sensor's."""
    table = pd.read_csv(damper)
    at, seen = table["Time[s]"].to_numpy(float), table["sensor1[mm]"].to_numpy(float)
    open_ = np.interp(time, at, (seen <= CLIPPED).astype(float)) == 0.0
    return float(abs(np.corrcoef(hidden[open_], np.interp(time, at, seen)[open_])[0, 1]))
