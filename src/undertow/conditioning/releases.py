"""The releases of one record that holds several on one clock: held, let go, decay, pulled and held, let go, decay.

Everything is relative to the record's own swings, their time and their noise.

Belongs here: where each release and its decay begin and end. Does not belong here: the release of one trial
(release.py), the config that gives each as a trial (campaign).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from undertow.conditioning.release import HELD_AWAY_SHARE
from undertow.conditioning.swings import NOISE_RANGE, PAUSED, Swings, find_swings
from undertow.recording.catalogue import TimeWindow
from undertow.recording.noise import noise
from undertow.recording.recording import INPUTS, Array, Recording

FOLLOWING = 3
"""Swings after a release that say how long one takes and what the body swings about."""

FEWEST_SWINGS = 2
"""Whole swings after a hold from which on the body was let go, not moved by hand."""

GREW = 1.2
"""A swing from a hold is so many times the last one before it, as nothing but a pull makes it; and a decay whose swings
become so many times its first one is none."""

STILL = 0.15
"""A body is held while it moves by less than this share of its first swing in the time of a swing; one that swings
moves by a quarter of it where it is slowest. Jacks creep, and some pull slowly until they let go."""

REST_BAND = 0.1
"""A body lies at rest where it stays within this share of the next pull for more than half of the time before it."""

PIECES = 4
"""Pieces of a swing's time, over the means of which noise is no motion."""

LISTED = 3
"""Releases of which a sentence gives the instants."""


@dataclass(frozen=True)
class Released:
    """One release of several in a record, s of its time: held from ``start_s``, let go near ``release_s``, and free
    until ``end_s``, where the record ends or the body is pulled again."""

    start_s: float
    release_s: float
    end_s: float

    @property
    def part(self) -> TimeWindow:
        """The part of the record that is this trial, the hold included."""
        return TimeWindow(self.start_s, self.end_s)


@dataclass(frozen=True)
class _Hold:
    """A turn at which a body was held and let go: its place among the turns, first and last sample of the hold, how
    long the body stayed there and how long a swing takes then (s), and where it was held less what it swings about, in
    the channel's unit."""

    turn: int
    first: int
    last: int
    stayed: float
    usual: float
    away: float


@dataclass(frozen=True)
class _Displacement:
    """A displacement ``values`` (n,) at ``time`` (n,) s with its swings and the samples (m,) of their turns."""

    time: Array
    values: Array
    seen: Swings
    turns: np.ndarray


def several_releases(recording: Recording, levels: Mapping[str, float] | None = None) -> tuple[Released, ...]:
    """The releases of a record that holds more than one, in order; empty where it holds one or none.

    A body is let go where it stays at a turn for longer than at any turn of its decays, still and away from what it
    swings about afterwards, leaves it as quickly as it swings, and swings further than it did before: no body that
    nothing pulls gets there. Beats, knocks and a body that sticks do not look so. Only a displacement shows it, and
    only without a measured input. ``levels`` is the noise of every channel, where it is known.

    >>> t = np.arange(0.0, 20.0, 0.01)
    >>> def after(hold): return np.exp(-0.2 * np.maximum(t - hold, 0)) * np.cos(6.0 * np.maximum(t - hold, 0))
    >>> record = Recording("r", np.arange(2 * t.size) * 0.01, {"displacement": np.r_[after(2.0), 0.7 * after(3.0)]})
    >>> [round(one.release_s, 1) for one in several_releases(record)]
    [2.0, 23.0]
    """
    if "displacement" not in recording.channels or any(name in INPUTS for name in recording.channels):
        return ()
    time, values = recording.time, recording.channels["displacement"]
    level = (levels or {}).get("displacement") or noise(values)
    seen = find_swings(time, values, level)
    record = _Displacement(time, values, seen, np.searchsorted(time, seen.time))
    holds = _holds(record)
    if len(holds) < 2:
        return ()
    final = _final_pull(record, holds[-1])
    if not _decays(record, holds, record.turns.size - 1 - len(final)):
        return ()
    pulls = [*((two.first, two.away) for two in holds[1:]), *final]
    margin = NOISE_RANGE * level
    stops = [_pulled(values, one, *pull, margin) for one, pull in zip(holds, pulls, strict=False)]
    stops += [] if final else [time.size - 1]
    return tuple(
        Released(float(time[one.first]), float(time[one.last]), float(time[stop]))
        for one, stop in zip(holds, stops, strict=True)
    )


def releases_said(found: Sequence[Released], name: str, used_s: float | None = None) -> str:
    """That a record holds several releases, which of them is used alone (let go at ``used_s``; None: none), and what
    makes a trial of each, in a sentence; ``name`` is its file's."""
    at = ", ".join(f"{one.release_s:.3g}" for one in found[:LISTED])
    parts = ", ".join(f"{{start_s: {one.start_s:.6g}, end_s: {one.end_s:.6g}}}" for one in found[:LISTED])
    more = ", ..." if len(found) > LISTED else ""
    used = "a trial is one" if used_s is None else f"only that of {used_s:.4g} s is used"
    return (
        f"it holds {len(found)} releases on one clock (let go near {at}{more} s), and {used}: give each its part as "
        f'a trial with recordings.releases: {{"{name}": [{parts}{more}]}}, which undertow init and inspect write, or '
        "list releases in recordings.accept"
    )


def _holds(record: _Displacement) -> list[_Hold]:
    """Holds that a release follows; before the second and later ones the body swung less far."""
    size, found = record.seen.size, list[_Hold]()
    for i in range(record.turns.size - 1 - FEWEST_SWINGS):
        if i > 1 and size[i] <= GREW * size[i - 2]:
            continue
        one = _hold(record, i)
        if one is not None and (not found or i - found[-1].turn > FEWEST_SWINGS):
            found.append(one)
    return found


def _hold(record: _Displacement, i: int) -> _Hold | None:
    """The hold at the ``i``-th turn; None where the body was not held and let go there. A record may begin with a hold
    of any length."""
    time, values, seen = record.time, record.values, record.seen
    following, size = seen.position[i + 1 : i + 2 + FOLLOWING], seen.size[i]
    usual = float(np.median(seen.took[i + 1 : i + 1 + FOLLOWING]))
    if following.size <= FEWEST_SWINGS or seen.took[i] > PAUSED * usual:
        return None
    came, passed = _stay(record, i)
    stayed = float(time[passed] - time[came])
    if i and stayed <= PAUSED * usual:
        return None
    last = max(int(np.searchsorted(time, time[passed] - 0.5 * usual)), came)
    first = max(int(np.searchsorted(time, time[last] - usual)), came)
    pieces = [np.mean(piece) for piece in np.array_split(values[first : last + 1], PIECES) if piece.size]
    if i and np.ptp(pieces) > STILL * size:
        return None
    held = float(np.median(values[first : last + 1]))
    centre = float(np.mean(0.25 * (following[:-2] + 2.0 * following[1:-1] + following[2:])))
    if abs(held - centre) <= HELD_AWAY_SHARE * abs(held - seen.position[i + 1]):
        return None
    moved = np.flatnonzero(np.abs(values[came : last + 1] - held) > STILL * size) if i else np.empty(0, dtype=int)
    return _Hold(i, came + int(moved[-1]) + 1 if moved.size else came, last, stayed, usual, held - centre)


def _stay(record: _Displacement, i: int) -> tuple[int, int]:
    """The first sample of the stay at a turn and the first after it: within half the swing that follows."""
    values, turns = record.values, record.turns
    at, half = values[turns[i]], 0.5 * record.seen.size[i]
    after = np.flatnonzero(np.abs(values[turns[i] : turns[i + 1] + 1] - at) >= half)
    passed = int(turns[i] + after[0]) if after.size else int(turns[i + 1])
    before = np.flatnonzero(np.abs(values[turns[i - 1] : turns[i]] - at) >= half) if i else np.empty(0, dtype=int)
    return (int(turns[i - 1] + before[-1]) + 1 if before.size else int(turns[max(i - 1, 0)])), passed


def _final_pull(record: _Displacement, one: _Hold) -> list[tuple[int, float]]:
    """Where the hold begins with which a record ends, and how far it is from what the body swung about after its last
    release; empty where it ends otherwise."""
    end, still = record.values[record.time >= record.time[-1] - one.usual], STILL * record.seen.size[one.turn]
    held = float(np.median(end))
    away = held - (float(record.values[one.last]) - one.away)
    if abs(away) <= HELD_AWAY_SHARE * abs(one.away) or float(np.ptp(end)) >= still:
        return []
    return [(int(np.flatnonzero(np.abs(record.values - held) > still)[-1]) + 1, away)]


def _decays(record: _Displacement, holds: Sequence[_Hold], end: int) -> bool:
    """Whether between the holds, and before the turn ``end``, there are decays: no swing much larger than the first, no
    turn at which the body stays as if it were held."""
    size, most = record.seen.size, min(one.stayed for one in holds[1:]) / PAUSED
    for one, stop in zip(holds, [*(one.turn for one in holds[1:]), end], strict=True):
        if float(np.max(size[one.turn : max(stop - 1, one.turn + 1)])) > GREW * size[one.turn]:
            return False
        stays = (_stay(record, i) for i in range(one.turn + 1, stop - 1))
        if any(record.time[passed] - record.time[came] > most for came, passed in stays):
            return False
    return True


def _pulled(values: Array, one: _Hold, held: int, away: float, margin: float) -> int:
    """The last sample of a decay before the body is pulled ``away`` and held from a sample on: the last at which it did
    not come closer to that by more than a margin, or the last of the rest that it lay in."""
    way = np.sign(away) * values[one.last : held + 1][::-1]
    least = np.minimum.accumulate(way)
    swung = np.flatnonzero(way > least + margin)
    climb = way[: int(swung[0]) if swung.size else way.size]
    rest, band = float(np.median(climb)), REST_BAND * abs(away)
    if float(np.mean(np.abs(climb - rest) <= band)) <= 0.5:
        rest = float(climb.min())
    return int(held - np.argmax(climb <= rest + min(margin, band)))
