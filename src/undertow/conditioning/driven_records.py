"""Driven trials and decays from arrays, as users hand them over.

Belongs here: arrays to `DrivenTrial`. Does not belong here: files (campaign/driven/trials.py), fits.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from undertow.conditioning.driven import DrivenTrial, Frame, Quantity
from undertow.errors import RecordingError
from undertow.quantities import Hold
from undertow.recording.arrays import instants, real_numbers
from undertow.recording.propose import step_in_doubt
from undertow.recording.recording import Array, Coordinate
from undertow.recording.units import factor_to_si, si_unit

Records = ArrayLike | Sequence[ArrayLike]
Times = ArrayLike | float | Sequence[ArrayLike | float]
Inputs = ArrayLike | Sequence[ArrayLike | None]
UnitsSaid = Mapping[str, str]
"""Array (x, v, t, u) or its quantity -> its unit; what is not said is in SI units."""


def driven_records(
    x: Records,
    t: Times,
    u: Inputs,
    hold: Hold,
    quantity: Quantity = "force",
    frame: Frame | None = None,
    instrument: ArrayLike | None = None,
    units: UnitsSaid | None = None,
) -> tuple[DrivenTrial, ...]:
    """One trial of displacement ``x`` (n,), times or a step ``t`` and input ``u`` (n,), or one for each of a list of x.

    ``x`` may have the velocity beside it (n, 2), which is not used. None in a list ``u`` is a decay. ``units`` are
    those of x, t and u, SI where they are not said. Raises RecordingError where the lists do not fit together, arrays
    do not, or a unit is none of its quantity.
    """
    many = isinstance(x, list | tuple) and len(x) > 0 and np.ndim(x[0]) > 0 and np.size(x[0]) > 2
    if not many:
        return (driven_record(x, t, u, hold, quantity, frame, instrument, units=units),)  # type: ignore[arg-type]
    records: list[ArrayLike] = list(x)  # type: ignore[arg-type]
    times = list(t) if isinstance(t, list | tuple) else [t] * len(records)
    inputs = list(u) if isinstance(u, list | tuple) else [u]
    if not len(records) == len(times) == len(inputs):
        raise RecordingError(
            f"x has {len(records)} records, t {len(times)} and u {len(inputs)}; give one of each, None as u of a decay"
        )
    if instrument is not None:
        raise RecordingError(f"an instrument is a signal beside one record, and x has {len(records)}; give one record")
    return tuple(
        driven_record(*one, hold, quantity, frame, name=f"x{i}", units=units)  # type: ignore[arg-type]
        for i, one in enumerate(zip(records, times, inputs, strict=True))
    )


def driven_record(
    x: ArrayLike,
    t: ArrayLike | float,
    u: ArrayLike | None,
    hold: Hold,
    quantity: Quantity = "force",
    frame: Frame | None = None,
    instrument: ArrayLike | None = None,
    name: str = "x",
    units: UnitsSaid | None = None,
) -> DrivenTrial:
    """One record; ``u`` None: a decay from its release on."""
    size = _sizes(units or {}, quantity)
    if isinstance(x, pd.DataFrame):
        raise RecordingError(f"x is a table of {x.shape[1]} columns; give its displacement, its times and u as arrays")
    moved = real_numbers(x, "x") * size["x"]
    moved = moved[:, 0] if moved.ndim == 2 else moved
    given = instants(t) * size["t"]
    times: Array = np.array(np.arange(moved.size) * float(given) if given.ndim == 0 else given, dtype=np.float64)
    if not {"t", "time"} & set(units or {}) and (step := step_in_doubt(pd.Series(times))):
        raise RecordingError(
            f"t has no unit, and in seconds there would be a sample every {step:g} s; say it, as in "
            'units={"t": "ms"} or "s"'
        )
    frames: dict[str, Frame] = {} if frame is None else {"displacement": frame}
    return DrivenTrial(
        name, times, np.zeros(moved.size) if u is None else real_numbers(u, "u") * size["u"],
        {"displacement": moved}, quantity, hold, frames=frames, free=u is None,
        instrument=None if instrument is None else real_numbers(instrument, "instrument"),
    )  # fmt: skip


def _sizes(units: UnitsSaid, quantity: Quantity) -> dict[str, float]:
    """What one unit of x, v, t and u is in SI; RecordingError for another name, or a unit of another quantity."""
    if not isinstance(units, Mapping):
        raise RecordingError(f'units is {units!r}; give a mapping, as in units={{"x": "mm", "u": "kN"}}')
    quantities = {"x": "displacement", "v": "velocity", "t": "time", "u": quantity}
    said = {short: units.get(short, units.get(long, "")) for short, long in quantities.items()}
    for name in units:
        if name not in {*quantities, *quantities.values()}:
            raise RecordingError(
                f"units names {name!r}, but of a driven body it may name {', '.join(quantities)} or "
                f"{', '.join(quantities.values())}; correct the name"
            )
    angle = any(one.strip() and _turns(one, quantities[name]) for name, one in said.items() if name in "xv")
    coordinate: Coordinate = "rotation" if angle else "translation"
    return {
        name: factor_to_si(unit or si_unit(quantities[name], coordinate), quantities[name], coordinate)[0]
        for name, unit in said.items()
    }


def _turns(unit: str, quantity: str) -> bool:
    """Whether a unit of displacement or velocity is an angle's."""
    try:
        factor_to_si(unit, quantity, "translation")
    except RecordingError:
        return True
    return False
