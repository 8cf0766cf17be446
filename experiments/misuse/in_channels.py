"""Mistakes in the channels: units, signs, columns, clocks, sensors that do not move or move the wrong way."""

from __future__ import annotations

import numpy as np

from experiments.misuse.answers import Groups, Stop, TrialsAlone, Way
from experiments.misuse.campaigns import Draft, bridge, pendulum, slow_sampling, two_levels
from experiments.misuse.case import Case, channel, everywhere, leave, setting

STOPPED = frozenset({1, 2})
"""Refused as the config's fault, or because no trial can be used."""

G = 9.81


def contradiction(*says: str) -> tuple[Way, ...]:
    """The channels contradict each other in every group: the run stops before anything is fitted."""
    return (Stop(says),)


def _columns_swapped(draft: Draft) -> None:
    draft.channel("displacement", column="a")
    draft.channel("acceleration", column="x")


def _accelerometer_not_moving(draft: Draft) -> None:
    rng = np.random.default_rng(1)
    draft.change(draft.recordings, lambda table: table.assign(a=0.05 * rng.standard_normal(len(table))))


MISTAKES = (
    Case("displacement_labelled_mm", "displacement in m is labelled mm", bridge, channel("displacement", unit="mm"),
         contradiction("displacement", "mm|1,?000|unit")),
    Case("one_level_in_mm", "the trials of one wet level were exported in mm, the others in m", two_levels,
         lambda draft: draft.change(draft.files(water_depth_m=2.29), lambda table: table.assign(x=table.x * 1000.0)),
         (Groups(("displacement", "mm|1,?000|unit"), frozenset({3}), where={"water_depth_m": 2.29}, done=2),)),
    Case("load_cells_labelled_kn", "load cells in N are labelled kN", bridge, channel("spring_force", unit="kN"),
         contradiction("spring_force|load cell", "kN|1,?000|unit")),
    Case("one_load_cell_forgotten", "one of the two load cells is not in the config", bridge,
         channel("spring_force", columns=["lc1"]),
         (*contradiction("spring_force|load cell"), Groups(("spring_force|load cell",), codes=frozenset({3})))),
    Case("load_cells_of_opposite_sides", "the two load cells sit on opposite sides: their sum is nothing", bridge,
         everywhere(lambda table: table.assign(lc2=-table.lc2)), contradiction("spring_force|load cell")),
    Case("g_labelled_mps2", "an accelerometer in g is labelled m/s^2", bridge,
         everywhere(lambda table: table.assign(a=table.a / G)), contradiction("acceleration", r"\bg\b|9\.8|unit")),
    Case("acceleration_sign_turned", "the accelerometer was mounted the other way round", bridge,
         channel("acceleration", sign=-1), contradiction("acceleration", "sign")),
    Case("ms_labelled_s", "time in ms is labelled s", bridge,
         everywhere(lambda table: table.assign(t=table.t * 1000.0)), contradiction("time|period|acceleration")),
    Case("rate_hz_wrong", "`rate_hz: 250` where the recordings have 100 samples a second", bridge,
         setting("recordings.channels.time", {"rate_hz": 250}), contradiction("rate|time|acceleration")),
    Case("degrees_labelled_rad", "an angle in degrees is labelled rad; the gyro says otherwise", pendulum,
         everywhere(lambda table: table.assign(x=np.degrees(table.x))),
         contradiction("displacement|angle|velocity", "deg|57|unit")),
    Case("columns_swapped", "displacement and acceleration are exchanged in the config", bridge, _columns_swapped,
         contradiction("displacement|acceleration")),
    Case("column_not_there", "the displacement's column is misspelt", bridge, channel("displacement", column="pot"),
         (Stop(("no column|column", "'?pot'?"), STOPPED),)),
    Case("accelerometer_constant", "the accelerometer was not switched on: a constant 0.3 m/s^2", bridge,
         everywhere(lambda table: table.assign(a=0.3)), (Stop(("acceleration is constant",), STOPPED),)),
    Case("accelerometer_not_moving", "the accelerometer lay on the bench: noise alone", bridge,
         _accelerometer_not_moving, contradiction("acceleration")),
    Case("sampling_too_slow", "the body of 3.4 Hz was sampled five times a second and seems to swing at 1.6 Hz",
         slow_sampling, leave, (Stop(("rate|sampl|alias|acceleration",), STOPPED),)),
    Case("clipped", "the largest release ran into the end of the potentiometer's range", bridge,
         lambda draft: draft.change(["t05.csv"], lambda table: table.assign(x=table.x.clip(-0.06, 0.06))),
         (TrialsAlone(("displacement", "clip"), trials=("t05",), others=5),)),
)  # fmt: skip
