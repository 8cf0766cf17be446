"""The kinds of doubt about a trial that a config may accept beforehand (``recordings.accept``).

Belongs here: their names. Does not belong here: how a doubt arises (quality.py, conditioning).
"""

from __future__ import annotations

from typing import Literal, get_args

DoubtKind = Literal[
    "unit", "sign", "gain", "clock", "clipping", "conditions", "period", "damping", "hold", "gaps", "spikes", "releases"
]
"""One kind: a channel's unit, sign, gain or clock; a sensor at the end of its range; conditions that contradict what
is identified; a period that the rate cannot hold; damping too strong for a decay; the hold before the release; gaps;
spikes; several releases in one record."""

DOUBT_KINDS: tuple[DoubtKind, ...] = get_args(DoubtKind)
"""All kinds, in order."""
