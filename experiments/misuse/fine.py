"""Ten campaigns that are in order: green, or explained where something was planted, with the right numbers."""

from __future__ import annotations

import math

from experiments.misuse.answers import Right
from experiments.misuse.campaigns import Draft, bridge, fast, pendulum, two_springs
from experiments.misuse.case import Case, leave, setting

WET = {"water_depth_m": 2.36}
ADDED_MASS = ((WET, "added_mass_kg", 1079.4), ({"water_depth_m": 1.63}, "added_mass_kg", None))
G = 9.81
DEGREES_PER_RADIAN = 180.0 / math.pi


def _decimal_comma(draft: Draft) -> None:
    draft.separator, draft.decimal = ";", ","
    draft.set("recordings.index_separator", ";")
    draft.set("recordings.index_decimal", ",")


def _excluded(draft: Draft) -> None:
    draft.damage["t02.csv"] = lambda whole: b""
    draft.set("recordings.exclude", ["t02*"])


def _other_units(draft: Draft) -> None:
    draft.change(
        draft.recordings,
        lambda table: table.assign(
            t=table.t * 1e3, x=table.x * 1e3, a=-table.a / G, lc1=table.lc1 / 1e3, lc2=table.lc2 / 1e3
        ),
    )
    draft.channel("time", unit="ms")
    draft.channel("displacement", unit="mm")
    draft.channel("acceleration", unit="g", sign=-1)
    draft.channel("spring_force", unit="kN")


def _gyro_alone(draft: Draft) -> None:
    draft.remove("recordings.channels.displacement")
    draft.channel("velocity", unit="deg/s")
    draft.change(draft.recordings, lambda table: table.assign(v=table.v * DEGREES_PER_RADIAN))


CAMPAIGNS = (
    Case("in_order", "air and water, nothing missing, every suspect tried", bridge,
         setting("discrepancy.suspects", "all"), (Right(numbers=ADDED_MASS),)),
    Case("linear_damping_in_water", "damping in water three times that in air", lambda: bridge(c_factor_wet=3.0), leave,
         (Right(explained=((WET, ("linear_damping",)),), numbers=ADDED_MASS),)),
    Case("index_with_decimal_comma", "an index `t01.csv;long;1,63` with index_separator and index_decimal", bridge,
         _decimal_comma, (Right(numbers=ADDED_MASS),)),
    Case("excluded_trial", "a recording that is empty is excluded", bridge, _excluded, (Right(numbers=ADDED_MASS),)),
    Case("held_out_by_file", "`hold_out: [t02.csv, t06]`: a file and a stem", bridge,
         setting("trials.hold_out", ["t02.csv", "t06"]), (Right(numbers=ADDED_MASS, held_out=("t02", "t06")),)),
    Case("short_hold", "a light body of 3.4 Hz, let go after less than half a period", fast, leave,
         (Right(numbers=(({"water_depth_m": 1.2}, "added_mass_kg", 3.0),)),)),
    Case("two_springs", "two springs, two trials each in air and in water", two_springs, leave,
         (Right(groups=4, numbers=ADDED_MASS),)),
    Case("torsion_pendulum", "three free swings, an angle and a rate gyro", pendulum, leave, (Right(groups=1),)),
    Case("rate_gyro_alone", "the same swings, a rate gyro in deg/s alone", pendulum, _gyro_alone, (Right(groups=1),)),
    Case("other_units",
         "time in ms, displacement in mm, load cells in kN, an accelerometer in g turned round, all labelled so",
         bridge, _other_units, (Right(numbers=ADDED_MASS),)),
)  # fmt: skip
