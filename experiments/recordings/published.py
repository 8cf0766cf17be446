"""Published numbers of the real recordings, each with its source, and what of ours stands beside it.

Only numbers that others published or stated, the unit, the formula that makes ours comparable, and the limit that was
set beforehand belong here (``limit_percent`` nan: shown, not judged). No number of ours.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

KVLCC2 = (
    "Alexandersson and Kjellberg 2021, KVLCC2 roll decay, Mendeley Data 10.17632/2stvkyngj9.1; "
    "authors' notebooks 01.1 and 01.3"
)
CHECK = "independent output-error check, README of the recording (scipy least_squares on RK4)"
README = "README of the recording"


@dataclass(frozen=True)
class Reference:
    """One published number beside one of ours.

    ``study`` and ``group`` say which run, ``quantity`` and ``unit`` what it is, ``formula`` how ours is made: the name
    of a parameter, or a formula of compare.py, as "period", "ratio a/b". ``trial`` (a part of its name) takes the fit
    of that trial alone.
    """

    study: str
    quantity: str
    unit: str
    formula: str
    value: float
    source: str
    limit_percent: float = math.nan
    group: Mapping[str, str | float] = field(default_factory=dict)
    trial: str = ""


K1, KS, C = "k_N_per_m_per_mass", "sine_restoring_N_per_mass", "c_Ns_per_m_per_mass"
Q, F = "drag_Ns2_per_m2_per_mass", "friction_N_per_mass"
K3, K5, C3 = (
    "cubic_stiffness_N_per_m3_per_mass", "quintic_stiffness_N_per_m5_per_mass", "cubic_damping_Ns3_per_m3_per_mass",
)  # fmt: skip

_RUN = {"ship_speed": 15.5}
_REST = {"ship_speed": 0.0}
_SHIP = (
    Reference("kvlcc2", "B1", "1/s", C, 0.0557, KVLCC2, 6.0, _RUN),
    Reference("kvlcc2", "B2", "1/rad", Q, 0.0521, KVLCC2, 6.0, _RUN),
    Reference("kvlcc2", "C1", "1/s^2", K1, 6.0886, KVLCC2, 1.0, _RUN),
    Reference("kvlcc2", "C3", "1/(s rad)^2", K3, -3.18, KVLCC2, math.nan, _RUN),
    Reference("kvlcc2", "C5", "1/(s^2 rad^4)", K5, 396.2, KVLCC2, math.nan, _RUN),
    Reference("kvlcc2", "B1", "1/s", C, 0.0564, CHECK, math.nan, _RUN),
    Reference("kvlcc2", "B2", "1/rad", Q, 0.0503, CHECK, math.nan, _RUN),
    Reference("kvlcc2", "C1", "1/s^2", K1, 6.087, CHECK, math.nan, _RUN),
    Reference("kvlcc2_quadratic", "B1", "1/s", C, 0.016, KVLCC2, math.nan, _REST),
    Reference("kvlcc2_quadratic", "B2", "1/rad", Q, 0.060, KVLCC2, math.nan, _REST),
    Reference("kvlcc2_quadratic", "C1", "1/s^2", K1, 6.108, KVLCC2, math.nan, _REST),
    Reference("kvlcc2_quadratic", "rms", "mrad", "rms_milli", 4.39, CHECK, math.nan, _REST),
    Reference("kvlcc2_hardening", "B1", "1/s", C, 0.0146, CHECK, math.nan, _REST),
    Reference("kvlcc2_hardening", "B2", "1/rad", Q, 0.0610, CHECK, math.nan, _REST),
    Reference("kvlcc2_hardening", "C1", "1/s^2", K1, 6.065, CHECK, math.nan, _REST),
    Reference("kvlcc2_hardening", "C3", "1/(s rad)^2", K3, 3.89, CHECK, math.nan, _REST),
    Reference("kvlcc2_hardening", "rms", "mrad", "rms_milli", 1.35, CHECK, math.nan, _REST),
    Reference("kvlcc2_cubic", "B1", "1/s", C, 0.026, KVLCC2, math.nan, _REST),
    Reference("kvlcc2_cubic", "B2", "1/rad", Q, -0.033, KVLCC2, math.nan, _REST),
    Reference("kvlcc2_cubic", "B3", "s/rad^2", C3, 0.190, KVLCC2, math.nan, _REST),
    Reference("kvlcc2_cubic", "C1", "1/s^2", K1, 6.078, KVLCC2, math.nan, _REST),
    Reference("kvlcc2_cubic", "C3", "1/(s rad)^2", K3, 2.383, KVLCC2, math.nan, _REST),
    Reference("kvlcc2_cubic", "C5", "1/(s^2 rad^4)", K5, 33.35, KVLCC2, math.nan, _REST),
)

_T1, _T2 = {"trigger_deg": 90.0}, {"trigger_deg": 135.0}
_PENDULUM = (
    Reference("rotary_pendulum", "k1", "1/s^2", KS, 120.3, CHECK, 1.0, _T1),
    Reference("rotary_pendulum", "c1", "1/s", C, 0.23, CHECK, math.nan, _T1),
    Reference("rotary_pendulum", "c0", "rad/s^2", F, 1.99, CHECK, 10.0, _T1),
    Reference("rotary_pendulum", "rms", "mrad", "rms_milli", 6.07, CHECK, math.nan, _T1),
    Reference("rotary_pendulum", "k1", "1/s^2", KS, 120.2, CHECK, 1.0, _T2),
    Reference("rotary_pendulum", "c1", "1/s", C, 0.27, CHECK, math.nan, _T2),
    Reference("rotary_pendulum", "c0", "rad/s^2", F, 1.35, CHECK, 10.0, _T2),
    Reference("rotary_pendulum", "rms", "mrad", "rms_milli", 8.88, CHECK, math.nan, _T2),
    Reference("rotary_pendulum_viscous", "rms", "mrad", "rms_milli", 15.4, CHECK, math.nan, _T1),
    Reference("rotary_pendulum_viscous", "rms", "mrad", "rms_milli", 14.3, CHECK, math.nan, _T2),
    Reference("rotary_pendulum_straight", "rms", "mrad", "rms_milli", 195.0, CHECK, math.nan, _T1),
    Reference("rotary_pendulum_straight", "rms", "mrad", "rms_milli", 362.0, CHECK, math.nan, _T2),
)

_MASS_1, _MASS_3, _MASS_4 = {"trial": 1.0}, {"trial": 3.0}, {"trial": 4.0}
_C1, _C2 = "ratio c_Ns_per_m/total_mass_kg", "ratio drag_Ns2_per_m2/total_mass_kg"
_DISC = (
    Reference("spring_disc_air", "k/omega^2", "kg", "total_mass_kg", 0.209, README, math.nan, _MASS_1),
    Reference("spring_disc_two", "c1", "1/s", _C1, 0.025, CHECK, math.nan, _MASS_1),
    Reference("spring_disc_two", "c2", "1/m", _C2, 0.133, CHECK, math.nan, _MASS_1),
    Reference("spring_disc_two", "c1", "1/s", _C1, 0.032, CHECK, math.nan, _MASS_3),
    Reference("spring_disc_two", "c2", "1/m", _C2, 0.098, CHECK, math.nan, _MASS_3),
    Reference("spring_disc_two", "f", "Hz", "frequency_of_mass", 1.348, README, math.nan, _MASS_4),
)

_WHEEL = (
    Reference("bicycle_wheel_axial", "T", "s", "period", 1.425, README),
    Reference("bicycle_wheel_axial", "decrement", "1", "decrement", 0.03, README),
    Reference("bicycle_wheel_axial", "rms", "rad/s", "rms", 0.00796, CHECK),
    Reference("bicycle_wheel_axial_coulomb", "rms", "rad/s", "rms", 0.00795, CHECK),
    Reference("bicycle_wheel_radial", "T", "s", "period", 0.4214, README),
    Reference("bicycle_wheel_radial", "decrement", "1", "decrement", 0.096, README),
    Reference("bicycle_wheel_radial", "R2", "1", "r2", 0.99997, CHECK),
)

_BUILDING = (
    Reference("tmd_linear", "R2", "1", "r2", 0.638, CHECK),
    Reference("tmd_linear", "rms", "mm", "rms_milli", 4.4, CHECK),
    Reference("tmd_cubic", "R2", "1", "r2", 0.711, CHECK),
)

_TANK = (
    Reference("sloshing_linear", "rms", "% of width", "own_rms", 0.38, CHECK, math.nan, {}, "xData_1"),
    Reference("sloshing_cubic", "rms", "% of width", "own_rms", 0.068, CHECK, math.nan, {}, "xData_1"),
    Reference("sloshing_cubic", "k1", "1/s^2", K1, 61.2, CHECK, math.nan, {}, "xData_1"),
    Reference("sloshing_cubic", "k3", "1/(s %)^2", K3, -0.396, CHECK, math.nan, {}, "xData_1"),
    Reference("sloshing_cubic", "c1", "1/s", C, 0.134, CHECK, math.nan, {}, "xData_1"),
    Reference("sloshing_cubic", "k3", "1/(s %)^2", K3, -0.381, CHECK, math.nan, {}, "xData_2"),
    Reference("sloshing_cubic", "k3", "1/(s %)^2", K3, -0.399, CHECK, math.nan, {}, "xData_3"),
    Reference("sloshing_tank", "c0", "%/s^2", F, 0.156, CHECK, math.nan, {}, "xData_1"),
    Reference("sloshing_tank", "c1", "1/s", C, 0.094, CHECK, math.nan, {}, "xData_1"),
    Reference("sloshing_tank", "c0", "%/s^2", F, 0.138, CHECK, math.nan, {}, "xData_2"),
    Reference("sloshing_tank", "c0", "%/s^2", F, 0.148, CHECK, math.nan, {}, "xData_3"),
)

REFERENCES: tuple[Reference, ...] = (*_SHIP, *_PENDULUM, *_DISC, *_WHEEL, *_BUILDING, *_TANK)
