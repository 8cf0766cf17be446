"""The trials of the campaign: which there are, what is drawn for each, and the recording that results.

The report's numbers are in tables.py, the equation in motion.py, the instruments in sensors.py; make.py writes
and checks the files.
"""

from __future__ import annotations

import hashlib
import io
from dataclasses import dataclass

import numpy as np

from experiments.eq15_campaign import sensors, tables
from experiments.eq15_campaign.motion import Body, Floats, Motion, hold_and_release

SEED = 15
RATE_HZ = 250
RECORD_AFTER_RELEASE_S = 14.0
HOLD_S = (0.45, 0.95)
RELEASE_SCATTER = 0.02
"""The release reached lies within 2 % of the one intended."""

TRIAL_SCATTER = {"k": 0.003, "c": 0.06, "mu": 0.05}
"""Relative standard deviation from trial to trial; the campaign's README says why not the tables' own."""


@dataclass(frozen=True)
class Trial:
    """One release: place in the plan, spring, water depth (m) and the displacement intended (m)."""

    number: int
    spring: str
    water_depth_m: float
    x0_target_m: float

    @property
    def file(self) -> str:
        """File name that says nothing about the trial, the same at every making."""
        plan = f"eq15 {self.spring} {self.water_depth_m:.2f} {self.x0_target_m:.3f}"
        return f"r{hashlib.sha256(plan.encode()).hexdigest()[:4]}.csv.gz"


@dataclass(frozen=True)
class Truth:
    """What a trial's recording is made from; SI units, rounded as stored, so that truth.json is exact."""

    k_N_per_m: float
    c_Ns_per_m: float
    mu: float
    added_mass_kg: float
    drag_coefficient: float
    area_m2: float
    submerged_volume_m3: float
    x0_m: float
    hold_s: float
    stamp_error_s: float

    @property
    def normal_force_N(self) -> float:
        """Weight less buoyancy, N: m g - V rho g."""
        displaced_kg = self.submerged_volume_m3 * tables.WATER_DENSITY_KG_PER_M3
        return (tables.STRUCTURE_MASS_KG - displaced_kg) * tables.GRAVITY_M_PER_S2

    @property
    def body(self) -> Body:
        """The parameters as Eq. 15 groups them."""
        return Body(
            inertia_kg=tables.STRUCTURE_MASS_KG + self.added_mass_kg,
            c_Ns_per_m=self.c_Ns_per_m,
            k_N_per_m=self.k_N_per_m,
            friction_N=self.mu * self.normal_force_N,
            drag_Ns2_per_m2=0.5 * self.drag_coefficient * tables.WATER_DENSITY_KG_PER_M3 * self.area_m2,
        )


def plan_trials() -> list[Trial]:
    """The 48 trials: both springs, dry and five water depths, four releases each."""
    conditions = [
        (spring, depth, x0)
        for spring in ("long", "short")
        for depth in (tables.DRY_DEPTH_M, *tables.WET_DEPTHS_M)
        for x0 in tables.RELEASES_M[spring]
    ]
    return [Trial(number, *condition) for number, condition in enumerate(conditions)]


def draw_truth(trial: Trial, rng: np.random.Generator) -> Truth:
    """Parameters of one trial: dry means (Tables 1, 2) with scatter, m_a and Cd as printed (Tables 4, 6)."""
    k, c, mu = tables.dry_mean(trial.spring)
    k, c, mu = (
        mean * (1.0 + TRIAL_SCATTER[name] * rng.standard_normal())
        for name, mean in (("k", k), ("c", c), ("mu", mu))
    )
    dry = trial.water_depth_m == tables.DRY_DEPTH_M
    half_sample_s = 0.5 / RATE_HZ
    return Truth(
        k_N_per_m=round(k, 1),
        c_Ns_per_m=round(c, 2),
        mu=round(mu, 7),
        added_mass_kg=0.0 if dry else tables.ADDED_MASS_KG[trial.spring][trial.water_depth_m],
        drag_coefficient=0.0 if dry else tables.DRAG_COEFFICIENT[trial.spring][trial.water_depth_m],
        area_m2=0.0 if dry else tables.REFERENCE_AREA_M2,
        submerged_volume_m3=tables.submerged_volume(trial.water_depth_m),
        x0_m=round(trial.x0_target_m * (1.0 + rng.uniform(-RELEASE_SCATTER, RELEASE_SCATTER)), 6),
        hold_s=round(rng.uniform(*HOLD_S), 6),
        stamp_error_s=round(rng.uniform(-half_sample_s, half_sample_s), 6),
    )


def move(truth: Truth) -> tuple[Floats, Motion]:
    """Stamped times (s) of a record, shape (n,), and the motion at them.

    The body is held at x0 until the release. A sample stamped t was taken at t + stamp_error.
    """
    stamps = np.arange(round((truth.hold_s + RECORD_AFTER_RELEASE_S) * RATE_HZ)) / RATE_HZ
    return stamps, hold_and_release(truth.body, truth.x0_m, stamps + truth.stamp_error_s - truth.hold_s)


def make_trial(trial: Trial) -> tuple[str, dict[str, object]]:
    """A trial's recording as CSV text and its entry in truth.json."""
    rng = np.random.default_rng([SEED, trial.number])
    truth = draw_truth(trial, rng)
    stamps, motion = move(truth)
    spring_force = truth.k_N_per_m * motion.x
    quantities = (motion.x, motion.a, *(share * spring_force for share in sensors.LOAD_SHARES))
    gains = campaign_gains()
    columns, offsets = [stamps], {}
    for sensor, quantity in zip(sensors.SENSORS, quantities, strict=True):
        reading, offset = sensors.read(rng, sensor, gains[sensor.column], stamps, quantity)
        columns.append(reading)
        offsets[sensor.column] = offset
    text = io.StringIO()
    formats = ["%.4f", *(f"%.{sensor.decimals}f" for sensor in sensors.SENSORS)]
    header = ",".join(["time_s", *(sensor.column for sensor in sensors.SENSORS)])
    np.savetxt(text, np.column_stack(columns), fmt=formats, delimiter=",", header=header, comments="")
    release_s = round(truth.hold_s - truth.stamp_error_s, 6)
    stopped_s = None if motion.stopped_s is None else round(motion.stopped_s + release_s, 6)
    entry = {
        "spring": trial.spring,
        "water_depth_m": trial.water_depth_m,
        "x0_target_m": trial.x0_target_m,
        **vars(truth),
        "normal_force_N": round(truth.normal_force_N, 6),
        "friction_N": round(truth.body.friction_N, 6),
        "release_s": release_s,
        "stopped_s": stopped_s,
        "rest_m": None if stopped_s is None else round(float(motion.reversals_m[-1]), 9),
        "offsets": offsets,
    }
    return text.getvalue(), entry


def campaign_gains() -> dict[str, float]:
    """The sensors' gains (-), drawn once for the campaign."""
    return sensors.draw_gains(np.random.default_rng([SEED, len(plan_trials())]))
