"""Samples that are missing: ends are trimmed, gaps left out, and a channel or a trial that lacks too much is said.

What conditioning gets has no missing value and an uneven time where some were: nothing is filled in.

Belongs here: which instants stay. Does not belong here: finding dropouts (quality.py), clocks (clocks.py).
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from undertow.errors import RecordingError
from undertow.recording.channels import TimeWindow
from undertow.recording.clipping import runs
from undertow.recording.recording import LEFT_OUT, Array
from undertow.recording.spikes import Mask

MOST_MISSING = 0.2
"""Share of the displacement's samples, between its first and last, that may be missing: of two turns in five the
position of one is then unknown."""

MOST_MISSING_BESIDE = 0.05
"""Share that a channel beside it may lack for its sake to leave those instants out altogether; else it is left out."""

STILL_SHARE = 0.02
"""Instants before a channel begins may go if the displacement moves by less than this share of its range in them."""

Channels = dict[str, Array]


def complete(
    time: Array, channels: Mapping[str, Array], window: TimeWindow, primary: str
) -> tuple[Array, Channels, tuple[str, ...]]:
    """The instants at which all that is kept has a value, the channels there, and notes on what went.

    ``primary`` is the channel that must stay. Outside the window incomplete samples are left out and counted.

    Raises RecordingError where the window holds no sample or the primary channel lacks more than `MOST_MISSING`.
    """
    inside = window.contains(time)
    must_hold_samples(inside, time, window)
    finite = {name: np.isfinite(values) for name, values in channels.items()}
    span = _span(time, finite[primary], inside, primary)
    notes = [*_ends(span, finite[primary] & inside, inside, primary)]
    kept = dict(channels)
    for name in [one for one in channels if one != primary]:
        why = _lacks(channels[primary], finite[name], span & finite[primary], name, primary)
        if why:
            notes.append(why)
            del kept[name]
    whole = np.all([finite[name] for name in kept], axis=0)
    notes += [_gap(time, ~finite[name] & span, name) for name in kept if np.any(~finite[name] & span)]
    outside = int(np.count_nonzero(~whole & ~inside))
    if outside:
        notes.append(f"{outside} incomplete samples outside the window left out")
    stays = whole & (span | ~inside)
    return time[stays], {name: values[stays] for name, values in kept.items()}, tuple(notes)


def _limits(window: TimeWindow) -> str:
    if window.end_s is None:
        return f"from {window.start_s} s on"
    return f"until {window.end_s} s" if window.start_s is None else f"{window.start_s} to {window.end_s} s"


def must_hold_samples(inside: Mask, time: Array, window: TimeWindow, key: str = "trials.window") -> None:
    """RecordingError where a window, of this key of the config, holds none of the samples."""
    if not inside.any():
        raise RecordingError(
            f"the window {_limits(window)} holds none of the samples, which are at {time[0]:g} to "
            f"{time[-1]:g} s; correct {key}"
        )


def _span(time: Array, finite: Mask, inside: Mask, primary: str) -> Mask:
    """The samples of the window between the primary channel's first value and its last."""
    there = np.flatnonzero(finite & inside)
    if not there.size:
        raise RecordingError(f"{primary} has no values in {np.count_nonzero(inside)} samples; map another column")
    span = np.zeros(time.size, dtype=bool)
    span[there[0] : there[-1] + 1] = True
    span &= inside
    lacking = int(np.count_nonzero(span & ~finite))
    if lacking > MOST_MISSING * np.count_nonzero(span):
        first = float(time[np.flatnonzero(span & ~finite)[0]])
        raise RecordingError(
            f"{primary} lacks {lacking} of {np.count_nonzero(span)} values, the first at {first:g} s, and more than "
            f"{100.0 * MOST_MISSING:g} % is too much; end trials.window before it or repair the file"
        )
    return span


def _ends(span: Mask, there: Mask, inside: Mask, primary: str) -> list[str]:
    """That the primary channel has no value at the record's beginning or end."""
    trimmed = int(np.count_nonzero(inside & ~span & ~there))
    return [f"{trimmed} samples without a {primary} at the ends left out"] if trimmed else []


def _lacks(primary_values: Array, finite: Mask, needed: Mask, name: str, primary: str) -> str:
    """Why a channel beside the primary one is left out; empty where it stays."""
    lacking = needed & ~finite
    count, of = int(np.count_nonzero(lacking)), int(np.count_nonzero(needed))
    if count > MOST_MISSING_BESIDE * of:
        what = "has no values" if count == of else f"lacks {count} of {of} values"
        return f"{name} {what}: {LEFT_OUT}"
    there = np.flatnonzero(needed & finite)
    before = primary_values[: there[0]][needed[: there[0]]]
    moves = primary_values[needed]
    if before.size and float(np.ptp(before)) > STILL_SHARE * float(np.ptp(moves)):
        return f"{name} begins {before.size} samples after {primary}, which moves before: {LEFT_OUT}"
    return ""


def _gap(time: Array, missing: Mask, name: str) -> str:
    """How much of a channel is missing within the record, and where."""
    gaps = runs(missing)
    start, end = max(gaps, key=lambda gap: gap[1] - gap[0])
    length, at = (end - start) * float(np.median(np.diff(time))), time[start]
    many = "a gap" if len(gaps) == 1 else f"{len(gaps)} gaps"
    return (
        f"{name} lacks {np.count_nonzero(missing)} values in {many}, the longest of {length:.3g} s at {at:.4g} s: "
        "these samples are left out"
    )
