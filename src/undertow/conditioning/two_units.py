"""Two wrong units at once that explain that channels disagree: millimetres labelled m beside an acceleration in g.

Belongs here: that search, of the units that laboratories write most. Does not belong here: one wrong entry
(remedies.py), how it is said (agreement.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import combinations, product
from types import MappingProxyType

from undertow.conditioning.pairs import Pair, Stated
from undertow.conditioning.remedies import ERRORS, MOST_NAMED, Remedy, how_far, other_units, tied_channels
from undertow.recording.recording import Coordinate
from undertow.recording.units import si_unit

USUAL: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "time": ("s", "ms"),
        "displacement": ("m", "mm", "cm", "rad", "deg"),
        "velocity": ("m/s", "mm/s", "cm/s", "rad/s", "deg/s"),
        "acceleration": ("m/s^2", "mm/s^2", "g", "mg", "rad/s^2", "deg/s^2"),
        "spring_force": ("N", "kN", "kgf", "N m", "kN m"),
    }
)
"""Units of which two at once are believed: of all that are known some two meet any factor."""

NEAR = 0.01
"""What one unit leaves is no more than sensors differ by: two are looked for only beyond that."""


def two_unit_remedies(
    pairs: Sequence[Pair], stated: Stated, coordinate: Coordinate, one: Sequence[Remedy] = ()
) -> tuple[Remedy, ...]:
    """Units of two channels (or of one and the time) with which all laws hold, the nearest first, as one remedy each;
    none where ``one`` unit alone does, to within what the laws are known to.
    """
    errors = [pair.stderr / pair.size for pair in pairs if pair.sized and pair.size > 0.0]
    if not errors or any(remedy.away <= max(NEAR, ERRORS * max(errors)) for remedy in one):
        return ()
    nearest = min((remedy.away for remedy in one), default=math.inf)
    found = []
    for channels in combinations(tied_channels(pairs), 2):
        tried = [_usual(name, stated, coordinate) for name in channels]
        for chosen in product(*tried):
            away = how_far(pairs, {name: factor for name, (_, _, factor) in zip(channels, chosen, strict=True)})
            if away is not None and away < nearest:
                found.append((away, _remedy(channels, chosen, away)))
    found.sort(key=lambda each: each[0])
    return tuple(remedy for _, remedy in found[:MOST_NAMED])


def _usual(channel: str, stated: Stated, coordinate: Coordinate) -> list[tuple[str, str, float]]:
    """Usual units that a channel may be in instead of the stated one (SI where none is), with the factor."""
    if channel not in USUAL:
        return []
    here = stated.units.get(channel) or si_unit(channel, coordinate)
    found = other_units(channel, stated, coordinate)
    return [one for one in found if one[0] in USUAL[channel] and one[1] == here]


def _remedy(channels: tuple[str, ...], chosen: tuple[tuple[str, str, float], ...], away: float) -> Remedy:
    """Two changes as one."""
    (first, (unit, said, _)), (second, (other, told, _)) = zip(channels, chosen, strict=True)
    seems = f"{first} seems to be in {unit}, not {said}, and {second} in {other}, not {told}"
    keys = " and ".join(f"recordings.channels.{name}.unit" for name in channels)
    return Remedy(first, seems, keys, away=away)
