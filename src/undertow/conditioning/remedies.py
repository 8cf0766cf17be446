"""What one wrong entry of a config would explain that channels disagree: a unit, a sign, a time base, swapped columns.

A remedy is looked for as one change that makes every law hold that was checked. Where several would, all are named:
of two channels alone nobody can tell which one is wrong.

Belongs here: that search. Does not belong here: the laws (pairs.py), how it is said (agreement.py).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

from undertow.conditioning.band import Band
from undertow.conditioning.pairs import MASS, STIFFNESS, Pair, Stated, pairs_of, three_digits
from undertow.errors import RecordingError
from undertow.recording.recording import Coordinate
from undertow.recording.units import KNOWN, factor_to_si, si_unit

ERRORS = 3.0
"""Standard errors within which a law may miss its limits and hold."""

UNIT_ROOM = 0.05
"""A unit explains a factor within this share: gains of sensors beside it."""

MOST_NAMED = 3
"""Remedies that a sentence names."""

SLIPS = (0.1, 10.0, 0.01, 100.0, 1e-3, 1e3)
"""What a stated mass or stiffness is multiplied by where its point is misplaced, or its unit is in thousands."""

RATE = "rate"
"""Stands for the unit of a time that comes from a constant rate."""

SWAPPABLE = ("displacement", "velocity", "acceleration")
"""Channels whose columns may be swapped."""


@dataclass(frozen=True)
class Remedy:
    """One change that makes all laws hold: of which ``channel`` (or "time", mass, stiffness), what ``seems`` wrong, the
    ``key`` of the config to correct, how many times too large it is (``factor``), and how far the laws then are from
    holding exactly (``away``, summed logarithms)."""

    channel: str
    seems: str
    key: str
    factor: float = math.nan
    away: float = math.nan


def unit_remedies(pairs: Sequence[Pair], stated: Stated, coordinate: Coordinate) -> tuple[Remedy, ...]:
    """Units of one channel, or of the time, with which all laws hold; the nearest of each, the likeliest first."""
    found: list[tuple[float, Remedy]] = []
    for channel in tied_channels(pairs):
        best: tuple[float, Remedy] | None = None
        for unit, said, factor in other_units(channel, stated, coordinate):
            away = how_far(pairs, {channel: factor})
            if away is not None and (best is None or away < best[0]):
                key = f"recordings.channels.{channel}.unit"
                best = away, Remedy(channel, f"{channel} seems to be in {unit}, not {said}", key, away=away)
        if best is not None:
            found.append(best)
    found.sort(key=lambda one: one[0])
    return tuple(remedy for _, remedy in found[:MOST_NAMED])


def specimen_remedies(pairs: Sequence[Pair], stated: Stated) -> tuple[Remedy, ...]:
    """Stiffness or mass stated powers of ten (`SLIPS`) too large or small, where that alone makes all laws hold;
    the nearest of each."""
    found = []
    for remedy in other_remedies(pairs, stated, (STIFFNESS, MASS)):
        tried = [(how_far(pairs, {remedy.channel: factor}), factor) for factor in SLIPS]
        fitting = [(away, factor) for away, factor in tried if away is not None]
        if fitting:
            away, factor = min(fitting)
            said = f"{remedy.channel} is {three_digits(1.0 / factor)} times what it should be"
            found.append(Remedy(remedy.channel, said, remedy.key, 1.0 / factor, away))
    return tuple(found)


def other_remedies(pairs: Sequence[Pair], stated: Stated, among: Sequence[str] = ()) -> tuple[Remedy, ...]:
    """Channels, the time, mass or stiffness (or only those ``among``) that one factor of no known unit would bring to
    agree with all others."""
    found = []
    for channel in among or tied_channels(pairs):
        tied = [p for p in pairs if p.powers.get(channel, 0) and p.sized and p.outside(p.allowed, ERRORS)]
        if not tied or tied[0].size == 0.0:
            continue
        needed = tied[0].size ** (-1.0 / tied[0].powers[channel])
        if how_far(pairs, {channel: needed}) is None:
            continue
        size = 1.0 / needed
        if channel == "time":
            rate = stated.units.get("time") == RATE
            key = f"recordings.channels.time.{'rate_hz' if rate else 'unit'}"
            found.append(Remedy(channel, f"the time is {three_digits(size)} times what it should be", key, size))
        else:
            said = f"{channel} is {three_digits(size)} times what it should be"
            halved = channel == "spring_force" and abs(2.0 * size - 1.0) < 2.0 * UNIT_ROOM
            said += " (is one of two load cells not mapped?)" if halved else ""
            key = channel if channel in (STIFFNESS, MASS) else f"recordings.channels.{channel}"
            found.append(Remedy(channel, said, key, size))
    return tuple(found[:MOST_NAMED])


def sign_remedies(pairs: Sequence[Pair]) -> tuple[Remedy, ...]:
    """Channels that, turned over, would go the right way with all others."""
    against = {(p.first, p.second) for p in pairs if p.turns and p.negative}
    found = []
    for channel in dict.fromkeys(name for p in pairs if p.turns for name in (p.first, p.second)):
        turned = {(p.first, p.second) for p in pairs if p.turns and channel in (p.first, p.second)}
        if turned == against:
            key = f"recordings.channels.{channel}.sign"
            found.append(Remedy(channel, f"the sign of {channel} seems turned over", key))
    return tuple(found)


def swap_remedy(
    band: Band, stated: Stated, coordinate: Coordinate, holds: Callable[[Sequence[Pair]], bool]
) -> Remedy | None:
    """Two columns that, taken for each other, make all laws hold (``holds``); None where no two do."""
    have = [name for name in SWAPPABLE if name in band.channels]
    for one, other in combinations(have, 2):
        scale = _scale(one, stated, coordinate) / _scale(other, stated, coordinate)
        channels, levels = dict(band.channels), dict(band.noise)
        channels[one], channels[other] = scale * band.channels[other], band.channels[one] / scale
        levels[one], levels[other] = scale * band.noise[other], band.noise[one] / scale
        if holds(pairs_of(replace(band, channels=channels, noise=levels), stated)):
            seems = f"the columns of {one} and {other} seem swapped"
            return Remedy(one, seems, f"recordings.channels.{one} and .{other}")
    return None


def tied_channels(pairs: Sequence[Pair]) -> tuple[str, ...]:
    """Channels, time, mass and stiffness that any sized law ties; the derived ones first, what is stated last."""
    names = dict.fromkeys(name for p in pairs if p.sized for name, power in p.powers.items() if power)
    last = ("time", STIFFNESS, MASS)
    return (*(name for name in names if name not in last), *(name for name in last if name in names))


def other_units(channel: str, stated: Stated, coordinate: Coordinate) -> Iterator[tuple[str, str, float]]:
    """Units that a channel may be in instead of another, with the factor that its values would change by.

    Where nobody says what the config has, it may be SI, or SI may be what it should have.
    """
    said = stated.units.get(channel, "")
    if channel not in KNOWN or said == RATE or stated.uncalibrated(channel):
        return
    si = si_unit(channel, coordinate)
    here = _factor(said or si, channel, coordinate)
    seen = {1.0}
    for unit in KNOWN[channel]:
        factor = _factor(unit, channel, coordinate) / here
        if math.isfinite(factor) and all(abs(factor / other - 1.0) > 1e-6 for other in seen):
            seen.add(factor)
            yield unit, said or si, factor
            if not said:
                yield si, unit, 1.0 / factor


def _factor(unit: str, channel: str, coordinate: Coordinate) -> float:
    """What one unit is in SI; nan where it is none of this channel's, or no unit at all."""
    try:
        factor, target = factor_to_si(unit, channel, coordinate)
    except RecordingError:
        return math.nan
    return factor if target == si_unit(channel, coordinate) else math.nan


def _scale(channel: str, stated: Stated, coordinate: Coordinate) -> float:
    """SI of one stated unit; 1 where nothing, or nothing known, is stated."""
    factor = _factor(stated.units.get(channel, ""), channel, coordinate) if stated.units.get(channel) else 1.0
    return factor if math.isfinite(factor) else 1.0


def how_far(pairs: Sequence[Pair], factors: Mapping[str, float]) -> float | None:
    """How far (summed logarithms) the laws are from holding with channels times ``factors``; None where one does not.
    """
    away = 0.0
    for pair in pairs:
        if not pair.sized or pair.size == 0.0:
            continue
        size = pair.size * math.prod(factor ** pair.powers.get(name, 0) for name, factor in factors.items())
        room = math.log1p(UNIT_ROOM + ERRORS * pair.stderr / pair.size)
        low, high = (math.log(limit) for limit in pair.agrees)
        if not low - room <= math.log(size) <= high + room:
            return None
        away += abs(math.log(size))
    return away


def units_of(catalogue_units: Mapping[str, str], rate_hz: float | None) -> dict[str, str]:
    """Units as `Stated` takes them: those of the channels, and the time's, which a constant rate has none of.

    >>> units_of({"displacement": "mm", "time": "s"}, 250.0)
    {'displacement': 'mm', 'time': 'rate'}
    """
    return {**catalogue_units, "time": RATE} if rate_hz is not None else dict(catalogue_units)
