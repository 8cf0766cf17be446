"""Releases with the report's published values, as a noiseless laboratory would record them, and their truth.

Belongs here: simulated recordings from Tables 1, 2, 4 and 6 by the exact integrator. Does not belong here: any method.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from experiments.eq15_campaign import tables
from experiments.eq15_campaign.motion import Body, Motion, hold_and_release, simulate
from undertow.likelihood.fit import Specimen, Structure
from undertow.quantities import Estimate
from undertow.recording.recording import Recording

RATE_HZ = 1000.0
"""The report's sampling rate."""

HOLD_S, RECORD_S = 1.0, 15.0
NOISE_M, NOISE_M_PER_S2 = 1e-6, 1e-4
"""A thousandth of a potentiometer's and of an accelerometer's noise: conditioning needs some, the methods feel none."""

RELEASE_M = {"long": 0.108, "short": 0.033}
"""Releases of Table 4 and Table 6."""

LEVELS = tuple((spring, depth) for spring in ("long", "short") for depth in tables.WET_DEPTHS_M)


@dataclass(frozen=True)
class Level:
    """One row of Table 4 (long spring) or Table 6 (short): truth, what is known of the structure, and the body."""

    spring: str
    water_depth_m: float

    @property
    def added_mass_kg(self) -> float:
        """As printed, kg."""
        return tables.ADDED_MASS_KG[self.spring][self.water_depth_m]

    @property
    def drag_coefficient(self) -> float:
        """As printed."""
        return tables.DRAG_COEFFICIENT[self.spring][self.water_depth_m]

    @property
    def specimen(self) -> Specimen:
        """Mass, area and submerged volume."""
        return Specimen(
            tables.STRUCTURE_MASS_KG,
            area_m2=tables.REFERENCE_AREA_M2,
            submerged_volume_m3=tables.submerged_volume(self.water_depth_m),
        )

    @property
    def structure(self) -> Structure:
        """k, c, mu: means of the dry trials (Tables 1, 2), without error."""
        k, c, mu = tables.dry_mean(self.spring)
        return Structure(
            Estimate(k, 0.0, unit="N/m"), Estimate(c, 0.0, unit="N s/m"), Estimate(mu, 0.0, unit="1"),
            {"k": 0.0, "c": 0.0, "mu": 0.0}, "Tables 1 and 2",
        )  # fmt: skip

    @property
    def body(self) -> Body:
        """The parameters as Eq. 15 groups them."""
        k, c, mu = tables.dry_mean(self.spring)
        known = self.specimen
        return Body(
            known.mass_kg + self.added_mass_kg, c, k, mu * known.normal_force_N,
            self.drag_coefficient * known.drag_N_per_unit_coefficient,
        )  # fmt: skip

    def moved(self, times_s: np.ndarray) -> Motion:
        """The exact motion at ``times_s`` (n,) s after the release."""
        return simulate(self.body, RELEASE_M[self.spring], times_s)

    def record(self) -> Recording:
        """Displacement and acceleration at 1000 Hz: held for 1 s, then 15 s of motion and rest."""
        time = np.arange(round((HOLD_S + RECORD_S) * RATE_HZ)) / RATE_HZ
        motion = hold_and_release(self.body, RELEASE_M[self.spring], time - HOLD_S)
        rng = np.random.default_rng(15)
        channels = {
            "displacement": motion.x + NOISE_M * rng.standard_normal(time.size),
            "acceleration": motion.a + NOISE_M_PER_S2 * rng.standard_normal(time.size),
        }
        return Recording(f"{self.spring} {self.water_depth_m:.2f} m", time, channels)
