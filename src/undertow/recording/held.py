"""Channels that a logger wrote more often than their sensor was read: every value stands there several times.

The repeats are no measurements: taken as such they are noise of none at all, and steps. What was read is kept, on a
clock of its own (clocks.py).

Belongs here: finding and leaving out repeats. Does not belong here: channels that stand still (dropouts.py,
clipping.py).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from undertow.recording.noise import quantum
from undertow.recording.parts import Part
from undertow.recording.recording import INPUTS, Array

FEWEST_READINGS = 30
"""Readings from which on their rhythm counts."""

IN_RHYTHM = 0.9
"""Share of readings that follow the one before after as many samples as most do, or one more or less: two clocks that
run beside each other. Values that repeat because the body rests, or moves by less than a step, have no rhythm."""

STEPS = 3.0
"""Finest steps of the channel by which most readings must differ from the one before: else rounding makes repeats."""


def readings(values: Array) -> np.ndarray:
    """Which samples (n,) are readings and no repeats of one: all of them but where values repeat in a rhythm.

    >>> read = np.cos(np.arange(50.0))
    >>> readings(np.repeat(read, 4))[:3].tolist(), readings(read).size
    ([0, 4, 8], 50)
    """
    every = np.arange(values.size)
    changes = np.flatnonzero(np.diff(values) != 0.0) + 1
    gaps = np.diff(changes)
    usual = int(np.median(gaps)) if gaps.size >= FEWEST_READINGS else 1
    if usual < 2 or np.mean(np.abs(gaps - usual) <= 1) < IN_RHYTHM:
        return every
    if np.median(np.abs(np.diff(values)[changes - 1])) < STEPS * quantum(values):
        return every
    return np.concatenate([
        np.arange(changes[0] % usual, changes[0], usual),
        *(np.arange(start, end, usual) for start, end in zip(changes, [*changes[1:], values.size], strict=True)),
    ])  # fmt: skip


def as_read(part: Part) -> tuple[list[Part], tuple[str, ...]]:
    """A part whose channels are at the instants at which their sensors were read, one part for each rhythm, and notes.
    What drives a body may be held on purpose, and stays."""
    if not INPUTS.keys().isdisjoint(part.channels) or not np.all(np.diff(part.time) > 0.0):
        return [part], ()
    rhythms = {name: readings(values) for name, values in part.channels.items()}
    found: dict[bytes, Part] = {}
    for name, index in rhythms.items():
        same = found.setdefault(index.tobytes(), Part(part.time[index], {}))
        found[index.tobytes()] = replace(same, channels={**same.channels, name: part.channels[name][index]})
    return list(found.values()), tuple(
        f"{name} repeats its values: it was read at {_rate(part.time[index]):.4g} Hz and written "
        f"{part.time.size / index.size:.3g} times as often; the repeats are left out"
        for name, index in rhythms.items() if index.size < part.time.size
    )  # fmt: skip


def _rate(time: Array) -> float:
    return (time.size - 1) / float(time[-1] - time[0])
