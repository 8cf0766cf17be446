"""Driven trials and decays from arrays, as users hand them over.

Belongs here: arrays to `DrivenTrial`. Does not belong here: files (campaign/driven/trials.py), fits.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from undertow.conditioning.driven import DrivenTrial, Frame, Quantity
from undertow.errors import RecordingError
from undertow.quantities import Hold
from undertow.recording.arrays import instants, real_numbers
from undertow.recording.recording import Array

Records = ArrayLike | Sequence[ArrayLike]
Times = ArrayLike | float | Sequence[ArrayLike | float]
Inputs = ArrayLike | Sequence[ArrayLike | None]


def driven_records(
    x: Records,
    t: Times,
    u: Inputs,
    hold: Hold,
    quantity: Quantity = "force",
    frame: Frame | None = None,
    instrument: ArrayLike | None = None,
) -> tuple[DrivenTrial, ...]:
    """One trial of displacement ``x`` (n,), times or a step ``t`` and input ``u`` (n,), or one for each of a list of x.

    ``x`` may have the velocity beside it (n, 2), which is not used. None in a list ``u`` is a decay. Raises
    RecordingError where the lists do not fit together or arrays do not.
    """
    many = isinstance(x, list | tuple) and len(x) > 0 and np.ndim(x[0]) > 0 and np.size(x[0]) > 2
    if not many:
        return (driven_record(x, t, u, hold, quantity, frame, instrument),)  # type: ignore[arg-type]
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
        driven_record(*one, hold, quantity, frame, name=f"x{i}")  # type: ignore[arg-type]
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
) -> DrivenTrial:
    """One record; ``u`` None: a decay from its release on."""
    moved = real_numbers(x, "x")
    moved = moved[:, 0] if moved.ndim == 2 else moved
    given = instants(t)
    times: Array = np.array(np.arange(moved.size) * float(given) if given.ndim == 0 else given, dtype=np.float64)
    frames: dict[str, Frame] = {} if frame is None else {"displacement": frame}
    return DrivenTrial(
        name, times, np.zeros(moved.size) if u is None else real_numbers(u, "u"), {"displacement": moved},
        quantity, hold, frames=frames, free=u is None,
        instrument=None if instrument is None else real_numbers(instrument, "instrument"),
    )  # fmt: skip
