"""One set of recordings that every method of the comparison gets, and how all are scored.

Two truths: Eq. 15 at 2.36 m on the short spring (four releases) and the same body with 300 kg of hidden water at
9.6 rad/s. The third release, 24 mm, is held out. Raw signals are cut from the release to where the motion ends and
taken about the rest position, alike for everyone.

Belongs here: data and scores. Does not belong here: methods (methods.py), the command (__main__.py).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import lsq_linear

from experiments.hidden_states import campaigns
from experiments.recovery.releases import plant, record_group
from undertow.conditioning.condition import condition
from undertow.conditioning.motion import Motion

Array = NDArray[np.float64]
Acceleration = Callable[[float, float], float]

WATER_DEPTH_M = 2.36
HELD_OUT = 2
"""Index of the release that no method sees before it is scored."""

HIDDEN_RELEASES_M = (0.016, 0.033, 0.024, 0.008)
LARGEST_LATENESS_S = 0.1
"""Under the largest noise a release may be seen this late; how late is fitted for every method alike."""

LARGEST_CLOCK_S = 0.001
"""Reach of the clock's linear part, between two steps of the lateness."""

LARGEST_REST_M = 0.002
LARGEST_START_SHARE = 0.02
"""A held-out trial's own rest position and x0 (a share of itself) may move so far, for every method alike."""

LARGEST_SCORE = 9.99
"""A free run that leaves every bound counts as this."""


@dataclass(frozen=True)
class Trial:
    """One trial from the release on: ``t`` (n,) s, raw ``x`` (m, about the rest), the ``x0`` (m) it was held at, and
    the conditioned ``motion`` of the same samples."""

    t: Array
    x: Array
    x0: float
    motion: Motion

    @property
    def run_times(self) -> Array:
        """Instants of a free run, (n + r,): those of the trial and as many more as the release may be seen late."""
        step = float(np.median(np.diff(self.t)))
        return np.arange(self.t.size + round(LARGEST_LATENESS_S / step)) * step


@dataclass(frozen=True)
class Data:
    """Training trials, the held-out one, and the true coefficients over the moving inertia by column name."""

    name: str
    noise: str
    seed: int
    training: tuple[Trial, ...]
    held_out: Trial
    truth: dict[str, float]


def equation_15(noise: str, seed: int) -> Data:
    """Eq. 15 itself."""
    truth = plant("short", WATER_DEPTH_M)
    body = truth.body
    coefficients = np.array([body.k_N_per_m, body.c_Ns_per_m, body.friction_N, body.drag_Ns2_per_m2]) / body.inertia_kg
    motions = [condition(recording) for recording in record_group(truth, noise, seed)]
    return _data("Eq. 15", noise, seed, motions, coefficients)


def hidden(noise: str, seed: int) -> Data:
    """300 kg of hidden water; the truth's columns are Eq. 15's four."""
    body = campaigns.plant("300 kg")
    rng = np.random.default_rng((seed, 23))
    motions = [condition(campaigns.record(body, x0, noise, rng, f"{x0:g} m")) for x0 in HIDDEN_RELEASES_M]
    coefficients = np.array([body.k, body.c, body.friction_N, body.drag]) / body.inertia_kg
    return _data("hidden oscillator", noise, seed, motions, coefficients)


def _data(name: str, noise: str, seed: int, motions: list[Motion], coefficients: Array) -> Data:
    trials = [_cut(motion) for motion in motions]
    held_out = trials.pop(HELD_OUT)
    names = ("x", "v", "sgn(v)", "v|v|")
    return Data(name, noise, seed, tuple(trials), held_out, dict(zip(names, map(float, coefficients), strict=True)))


def _cut(motion: Motion) -> Trial:
    """From the release to the end of the motion."""
    keep = motion.t <= motion.t[motion.inside][-1]
    x = motion.recorded("displacement")[keep] - motion.equilibrium.value
    recording = motion.recording
    held = recording.time < motion.window.release_s - LARGEST_LATENESS_S
    x0 = float(recording.channels["displacement"][held].mean()) - motion.equilibrium.value
    return Trial(motion.t[keep], x, x0, motion)


def simulate(acceleration: Acceleration, x0: float, t: Array) -> Array:
    """Free run (n, 2), x and v, from rest at ``x0`` by RK4 on the recording's own instants; nan once out of bounds.

    A method's sign(v) is taken as it is: at 1 kHz the step blurs a reversal by far less than any score here.
    """
    out = np.full((t.size, 2), np.nan)
    x, v = x0, 0.0
    step = float(np.median(np.diff(t)))
    for index in range(t.size):
        out[index] = x, v
        a1 = acceleration(x, v)
        a2 = acceleration(x + 0.5 * step * v, v + 0.5 * step * a1)
        v2 = v + 0.5 * step * a1
        a3 = acceleration(x + 0.5 * step * v2, v + 0.5 * step * a2)
        v3 = v + 0.5 * step * a2
        a4 = acceleration(x + step * v3, v + step * a3)
        x += step / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + (v + step * a3))
        v += step / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        if not abs(x) < 10.0 * abs(x0):
            break
    return out


def score(trial: Trial, run: Array) -> float:
    """RMS error of a free run (n + r, 2) at `Trial.run_times` over the trial's RMS displacement.

    The release's lateness is scanned sample by sample, and clock, rest and x0 are fitted linearly within their bounds.
    A run out of bounds scores `LARGEST_SCORE`.
    """
    if not np.all(np.isfinite(run)):
        return LARGEST_SCORE
    limit = np.array([LARGEST_CLOCK_S, LARGEST_REST_M, LARGEST_START_SHARE])
    late = range(run.shape[0] - trial.t.size + 1)
    first = min(late, key=lambda shift: float(np.sum((trial.x - run[shift : shift + trial.t.size, 0]) ** 2)))
    x, v = run[first : first + trial.t.size].T
    columns = np.column_stack([v, np.ones_like(x), x])
    left = trial.x - x - columns @ lsq_linear(columns, trial.x - x, (-limit, limit)).x
    return min(float(np.sqrt(np.mean(left**2) / np.mean(trial.x**2))), LARGEST_SCORE)
