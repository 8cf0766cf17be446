"""Mistakes in the channels: units, signs, columns, clocks, sensors that do not move or move the wrong way."""

from __future__ import annotations

import numpy as np

from experiments.misuse.answers import Groups, Stop, TrialsAlone, Way
from experiments.misuse.campaigns import Draft, bridge, pendulum, slow_sampling, two_levels
from experiments.misuse.case import Case, leave

STOPPED = frozenset({1, 2})
"""Refused as the config's fault, or because no trial can be used."""

G = 9.81


def contradiction(*says: str) -> tuple[Way, ...]:
    """The channels contradict each other in every group: the run stops before anything is fitted."""
    return (Stop(says),)


def _displacement_labelled_mm(draft: Draft) -> None:
    draft.channel("displacement", unit="mm")


def _one_level_in_mm(draft: Draft) -> None:
    draft.change(draft.files(water_depth_m=2.29), lambda table: table.assign(x=table.x * 1000.0))


def _load_cells_labelled_kn(draft: Draft) -> None:
    draft.channel("spring_force", unit="kN")


def _one_load_cell_forgotten(draft: Draft) -> None:
    draft.channel("spring_force", columns=["lc1"])


def _load_cells_of_opposite_sides(draft: Draft) -> None:
    draft.change(draft.recordings, lambda table: table.assign(lc2=-table.lc2))


def _g_labelled_mps2(draft: Draft) -> None:
    draft.change(draft.recordings, lambda table: table.assign(a=table.a / G))


def _acceleration_sign_turned(draft: Draft) -> None:
    draft.channel("acceleration", sign=-1)


def _ms_labelled_s(draft: Draft) -> None:
    draft.change(draft.recordings, lambda table: table.assign(t=table.t * 1000.0))


def _rate_hz_wrong(draft: Draft) -> None:
    draft.set("recordings.channels.time", {"rate_hz": 250})


def _degrees_labelled_rad(draft: Draft) -> None:
    draft.change(draft.recordings, lambda table: table.assign(x=np.degrees(table.x)))


def _columns_swapped(draft: Draft) -> None:
    draft.channel("displacement", column="a")
    draft.channel("acceleration", column="x")


def _column_not_there(draft: Draft) -> None:
    draft.channel("displacement", column="pot")


def _accelerometer_constant(draft: Draft) -> None:
    draft.change(draft.recordings, lambda table: table.assign(a=0.3))


def _accelerometer_not_moving(draft: Draft) -> None:
    rng = np.random.default_rng(1)
    draft.change(draft.recordings, lambda table: table.assign(a=0.05 * rng.standard_normal(len(table))))


def _clipped(draft: Draft) -> None:
    draft.change(["t05.csv"], lambda table: table.assign(x=table.x.clip(-0.06, 0.06)))


MISTAKES = (
    Case(
        "displacement_labelled_mm",
        "displacement in m is labelled mm",
        bridge,
        _displacement_labelled_mm,
        contradiction("displacement", "mm|1,?000|unit"),
    ),
    Case(
        "one_level_in_mm",
        "the trials of one wet level were exported in mm, the others in m",
        two_levels,
        _one_level_in_mm,
        (Groups(("displacement", "mm|1,?000|unit"), frozenset({3}), where={"water_depth_m": 2.29}, done=2),),
    ),
    Case(
        "load_cells_labelled_kn",
        "load cells in N are labelled kN",
        bridge,
        _load_cells_labelled_kn,
        contradiction("spring_force|load cell", "kN|1,?000|unit"),
    ),
    Case(
        "one_load_cell_forgotten",
        "one of the two load cells is not in the config",
        bridge,
        _one_load_cell_forgotten,
        (*contradiction("spring_force|load cell"), Groups(("spring_force|load cell",), codes=frozenset({3}))),
    ),
    Case(
        "load_cells_of_opposite_sides",
        "the two load cells sit on opposite sides: their sum is nothing",
        bridge,
        _load_cells_of_opposite_sides,
        contradiction("spring_force|load cell"),
    ),
    Case(
        "g_labelled_mps2",
        "an accelerometer in g is labelled m/s^2",
        bridge,
        _g_labelled_mps2,
        contradiction("acceleration", r"\bg\b|9\.8|unit"),
    ),
    Case(
        "acceleration_sign_turned",
        "the accelerometer was mounted the other way round",
        bridge,
        _acceleration_sign_turned,
        contradiction("acceleration", "sign"),
    ),
    Case(
        "ms_labelled_s",
        "time in ms is labelled s",
        bridge,
        _ms_labelled_s,
        contradiction("time|period|acceleration"),
    ),
    Case(
        "rate_hz_wrong",
        "`rate_hz: 250` where the recordings have 100 samples a second",
        bridge,
        _rate_hz_wrong,
        contradiction("rate|time|acceleration"),
    ),
    Case(
        "degrees_labelled_rad",
        "an angle in degrees is labelled rad; the gyro says otherwise",
        pendulum,
        _degrees_labelled_rad,
        contradiction("displacement|angle|velocity", "deg|57|unit"),
    ),
    Case(
        "columns_swapped",
        "displacement and acceleration are exchanged in the config",
        bridge,
        _columns_swapped,
        contradiction("displacement|acceleration"),
    ),
    Case(
        "column_not_there",
        "the displacement's column is misspelt",
        bridge,
        _column_not_there,
        (Stop(("no column|column", "'?pot'?"), STOPPED),),
    ),
    Case(
        "accelerometer_constant",
        "the accelerometer was not switched on: a constant 0.3 m/s^2",
        bridge,
        _accelerometer_constant,
        (Stop(("acceleration is constant",), STOPPED),),
    ),
    Case(
        "accelerometer_not_moving",
        "the accelerometer lay on the bench: noise alone",
        bridge,
        _accelerometer_not_moving,
        contradiction("acceleration"),
    ),
    Case(
        "sampling_too_slow",
        "the body of 3.4 Hz was sampled five times a second and seems to swing at 1.6 Hz",
        slow_sampling,
        leave,
        (Stop(("rate|sampl|alias|acceleration",), STOPPED),),
    ),
    Case(
        "clipped",
        "the largest release ran into the end of the potentiometer's range",
        bridge,
        _clipped,
        (TrialsAlone(("displacement", "clip"), trials=("t05",), others=5),),
    ),
)
