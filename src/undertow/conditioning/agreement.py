"""Whether the channels of one trial belong to the same motion: unit, sign, gain and clock of each against the others.

An acceleration is the second derivative of the displacement beside it, whatever moves the body: hidden water, drag or a
force from outside change neither. So a disagreement is a mistake in the recording or in what the config says of it, and
it is found before anything is fitted. All limits are relative to the trial's own period, size and noise.

Belongs here: `Disagreement` and what is said of it. Does not belong here: laws and limits (pairs.py), what would mend
it (remedies.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from undertow.conditioning.band import band_of
from undertow.conditioning.motion import Motion, Window
from undertow.conditioning.pairs import Pair, Stated, pairs_of
from undertow.conditioning.remedies import (
    Remedy,
    other_remedies,
    sign_remedies,
    specimen_remedies,
    swap_remedy,
    unit_remedies,
)
from undertow.conditioning.two_units import two_unit_remedies
from undertow.recording.recording import Recording

DOUBT_ERRORS = 3.0
"""A law is doubted where it misses its limits by so many standard errors."""

SURE_ERRORS = 5.0
"""And contradicted by so many."""

CLOCK_DOUBT = 0.15
"""Angle between two channels' clocks that is doubted, rad: five times what filters of one logger differ by."""

CLOCK_WRONG = math.pi / 4.0
"""Angle from which on a channel no longer goes with the other one rather than beside it, rad."""

LOUD = 25.0
"""Power in the band over noise (5 in amplitude) from which on a channel shows something."""

UNRELATED = 0.5
"""Less of a channel's power than this goes with the other one: they show different motions."""


AWAY_DIGITS = 3
"""Decimals to which two remedies are compared: within a part in a thousand units of channels come first."""

WELL_KNOWN = 0.1
"""A factor whose relative error is under this says that two columns go together the other way round."""


@dataclass(frozen=True)
class Disagreement:
    """Channels that do not belong together as the config says.

    ``kind`` is "unit", "sign", "gain", "clock" or "period", as `recordings.accept` names it; ``factor`` how many times
    too large the first channel is against the second (for a clock: by how many rad of the motion it is later).
    ``certain`` tells contradiction from doubt. ``sentence`` says what was found, what it seems to be, and what to do.
    """

    kind: str
    channels: tuple[str, ...]
    factor: float
    certain: bool
    sentence: str


def disagreements(
    recording: Recording, window: Window, stated: Stated | None = None, levels: Mapping[str, float] | None = None
) -> tuple[Disagreement, ...]:
    """What does not belong together in one trial's motion window; empty where all does, or nothing can be compared.

    ``stated`` is what the config says of units and specimen, ``levels`` the channels' noise where it is known.

    >>> import numpy as np
    >>> t = np.arange(0.0, 10.0, 0.01)
    >>> x = 0.02 * np.cos(5.0 * t)
    >>> record = Recording("r1", t, {"displacement": x, "acceleration": -25.0 * x / 9.81})
    >>> [found] = disagreements(record, Window(0.0, 0.0, 10.0))
    >>> found.kind, round(1.0 / found.factor, 2), found.certain
    ('unit', 9.81, True)
    """
    stated = stated or Stated()
    band = band_of(recording, window, levels)
    if band is None:
        return ()
    pairs = pairs_of(band, stated)
    wrong = [p for p in pairs if _contradicts(p)]
    if any(p.turns for p in wrong):
        swap = swap_remedy(band, stated, recording.coordinate, _hold)
        if swap is not None:
            plain = not any(_strange(p) or p.negative for p in wrong)
            units = unit_remedies(pairs, stated, recording.coordinate) if plain else ()
            return (_swapped(next(p for p in wrong if p.turns), swap, units),)
    strange = [p for p in pairs if _strange(p)]
    lost = _lost(strange, pairs)
    rest = [p for p in pairs if not _strange(p) and not set(lost) & {p.first, p.second}]
    found = [_not_of_it(p, lost) for p in _once(strange, lost)]
    sizes = _sizes(rest, stated, recording)
    signs = () if any(d.kind == "gain" and d.certain and d.factor < 0.0 for d in sizes) else _signs(rest)
    return (*found, *signs, *sizes, *_clocks(rest))


def _hold(pairs: Sequence[Pair]) -> bool:
    """Whether all laws hold, surely and without a doubt."""
    if any(_contradicts(p) or p.negative or p.outside(p.agrees, DOUBT_ERRORS) for p in pairs):
        return False
    return bool(pairs) and all(p.stderr < WELL_KNOWN * p.size and p.coherence > UNRELATED for p in pairs if p.turns)


def _contradicts(pair: Pair) -> bool:
    return _strange(pair) or _surely_negative(pair) or pair.outside(pair.allowed, SURE_ERRORS)


def _strange(pair: Pair) -> bool:
    """Whether two channels show different motions, or one of them none."""
    return pair.turns and (_silent(pair) or _unrelated(pair) or _sure_of_angle(pair, CLOCK_WRONG))


def _silent(pair: Pair) -> bool:
    """Whether the first channel does not see, beside its noise, a motion that it must see."""
    unseen = pair.loudness < LOUD and pair.size < SURE_ERRORS * pair.stderr
    return unseen and pair.outside(pair.allowed, SURE_ERRORS)


def _unrelated(pair: Pair) -> bool:
    return pair.loudness > LOUD and pair.coherence < UNRELATED


def _sure_of_angle(pair: Pair, limit: float) -> bool:
    """Whether two clocks are surely apart by more than an angle, rad."""
    return pair.size > 0.0 and abs(pair.clock) - SURE_ERRORS * pair.stderr / pair.size > limit


def _surely_negative(pair: Pair) -> bool:
    return pair.negative and not _strange(pair) and pair.size > SURE_ERRORS * pair.stderr


def _lost(strange: Sequence[Pair], pairs: Sequence[Pair]) -> tuple[str, ...]:
    """Channels that go with no other one though the others go together; all of them where nobody can tell."""
    if not strange:
        return ()
    names = dict.fromkeys(name for p in strange for name in (p.first, p.second))
    turning = [p for p in pairs if p.turns]
    alone = [n for n in names if all(_strange(p) for p in turning if n in (p.first, p.second))]
    silent = [p.first for p in strange if _silent(p)]
    return tuple(silent[:1] or alone[:1] if len(turning) > 1 else silent[:1] or alone)


def _once(strange: Sequence[Pair], lost: Sequence[str]) -> list[Pair]:
    """The pairs to be spoken of: one for each channel that is lost."""
    said: list[Pair] = []
    for pair in strange:
        mine = {pair.first, pair.second} & set(lost)
        if not any(mine & {p.first, p.second} for p in said):
            said.append(pair)
    return said


def _said(kind: str, pair: Pair, factor: float, text: str, certain: bool = True) -> Disagreement:
    """A disagreement of two channels, with how to accept it."""
    channels, sentence = (pair.first, pair.second), f"{text}, or list {kind} in recordings.accept"
    return Disagreement(kind, channels, factor, certain, sentence)


def _not_of_it(pair: Pair, lost: Sequence[str]) -> Disagreement:
    """A channel that shows another motion, or none."""
    which = lost[0] if len(lost) == 1 else pair.first
    columns = f"correct recordings.channels.{which}, take it out"
    if _silent(pair):
        text = (
            f"{pair.first} shows nothing of the motion that {pair.second} shows (at most "
            f"{100.0 * (pair.size + 2.0 * pair.stderr):.2g} % of it): was the sensor connected, is it the right "
            f"column? {columns}"
        )
        return _said("gain", pair, pair.size, text)
    if _unrelated(pair):
        text = (
            f"{pair.first} and {pair.second} do not belong together: {100.0 * pair.coherence:.0f} % of one goes with "
            f"the other about the motion's frequency, and over {100.0 * UNRELATED:.0f} % must; is a column swapped, or "
            f"from another trial? {columns}"
        )
        return _said("gain", pair, pair.size, text)
    later = "later" if pair.clock > 0.0 else "earlier"
    share = abs(pair.clock) / (2.0 * math.pi)
    text = (
        f"{pair.first} is {share:.2f} periods {later} than {pair.second} says it must be; a quarter of a period is "
        f"another quantity (a velocity in place of an acceleration), any other angle another trial or clock: {columns}"
    )
    return _said("clock", pair, pair.clock, text)


def _swapped(pair: Pair, swap: Remedy, units: Sequence[Remedy]) -> Disagreement:
    """Two columns that go together the other way round; a unit would have to meet that factor by chance."""
    seems = " or ".join(remedy.seems for remedy in (swap, *units))
    text = f"{pair.measured}, and would be 1 the other way round: {seems}; correct {swap.key}"
    return _said("unit", pair, pair.value.real, text)


def _signs(pairs: Sequence[Pair]) -> list[Disagreement]:
    """Channels that go against each other."""
    against = [p for p in pairs if _surely_negative(p)]
    if not against:
        return []
    remedies = sign_remedies([p for p in pairs if p.turns])
    pair = next((p for p in against if remedies and remedies[0].channel in (p.first, p.second)), against[0])
    seems = " or ".join(remedy.seems for remedy in remedies) or "a sign seems turned over"
    keys = " or ".join(remedy.key for remedy in remedies) or f"recordings.channels.{pair.first}.sign"
    found = _said("sign", pair, pair.value.real, f"{pair.measured}: {seems}; correct {keys}")
    return [replace(found, channels=(remedies[0].channel,)) if len(remedies) == 1 else found]


def _sizes(pairs: Sequence[Pair], stated: Stated, recording: Recording) -> list[Disagreement]:
    """Channels that are too large or too small: another unit where one explains it, a gain else."""
    wrong = [p for p in pairs if p.outside(p.allowed, SURE_ERRORS)]
    doubted = [p for p in pairs if p.outside(p.agrees, DOUBT_ERRORS) and p not in wrong]
    if not wrong:
        return [_gain(p) for p in _apart(doubted)]
    single = (*unit_remedies(pairs, stated, recording.coordinate), *specimen_remedies(pairs, stated))
    turned = any(p.negative for p in wrong)  # a sign and two units are met by chance
    double = () if turned else two_unit_remedies(pairs, stated, recording.coordinate, single)
    # a point misplaced in the stated mass is 10, kgf for N 9.81: what fits better is named first
    units = tuple(sorted((*single, *double), key=lambda one: round(one.away, AWAY_DIGITS)))
    if not units and any(p.negative for p in wrong):
        return [_another_column(next(p for p in wrong if p.negative))]
    remedies = units or other_remedies(pairs, stated)
    if not remedies:
        return [_unexplained(p) for p in _apart(wrong)]
    named = remedies[0].channel
    pair = next((p for p in wrong if p.powers.get(named)), wrong[0])
    kind = "unit" if units else _gain_or_period(pair)
    seems = " or ".join(remedy.seems for remedy in remedies)
    keys = " or ".join(dict.fromkeys(remedy.key for remedy in remedies))
    return [_said(kind, pair, pair.size, f"{pair.measured}: {seems}; correct {keys}")]


def _apart(pairs: Sequence[Pair]) -> list[Pair]:
    """Of pairs that share a channel the first one: the same fault is said once."""
    said: list[Pair] = []
    for pair in pairs:
        if not any({pair.first, pair.second} & {p.first, p.second} for p in said):
            said.append(pair)
    return said


def _gain(pair: Pair) -> Disagreement:
    """A doubt about a gain."""
    off = 100.0 * max(pair.agrees[1] - 1.0, 1.0 - pair.agrees[0])
    text = (
        f"{pair.measured} (+- {pair.stderr:.2g}), and more than {off:.0f} % off is doubted: look at the calibration of "
        f"{_both(pair)}"
    )
    return _said(_gain_or_period(pair), pair, pair.size, text, certain=False)


def _another_column(pair: Pair) -> Disagreement:
    """A size that no unit explains, the wrong way round: another quantity than the config says."""
    text = (
        f"{pair.measured}, and neither a sign nor a unit alone explains it: is a column another quantity (a force, or "
        f"a displacement in place of an acceleration)? correct recordings.channels.{pair.first} or .{pair.second}"
    )
    return _said("gain", pair, pair.value.real, text)


def _unexplained(pair: Pair) -> Disagreement:
    """A size that no single change explains."""
    text = (
        f"{pair.measured} and must be 1; no unit of one channel explains all that was compared: look at unit, gain and "
        f"column of {_both(pair)}"
    )
    return _said(_gain_or_period(pair), pair, pair.size, text)


def _both(pair: Pair) -> str:
    return "stiffness, mass and time" if pair.first == "time" else f"{pair.first} and {pair.second}"


def _gain_or_period(pair: Pair) -> str:
    return "period" if pair.first == "time" else "gain"


def _clocks(pairs: Sequence[Pair]) -> list[Disagreement]:
    """Channels whose clocks are apart, by less than what makes them another motion's."""
    found = []
    late = [p for p in pairs if p.size > 0.0 and abs(p.clock) - DOUBT_ERRORS * p.stderr / p.size > CLOCK_DOUBT]
    for pair in _apart(late):
        later = "later" if pair.clock > 0.0 else "earlier"
        text = (
            f"{pair.first} is {abs(pair.clock):.2f} rad of the motion {later} than {pair.second} at equal time "
            f"stamps, and more than {CLOCK_DOUBT:g} rad is doubted: look at filters and clocks of both"
        )
        found.append(_said("clock", pair, pair.clock, text, certain=False))
    return found


def accelerometer_late_s(motion: Motion) -> float:
    """How much later than the displacement a trial's acceleration is by its swings, s (below zero: earlier); zero where
    that is no more than `DOUBT_ERRORS` standard errors, or the two cannot be compared.

    >>> import numpy as np
    >>> from undertow.conditioning.condition import condition
    >>> t = np.arange(0.0, 10.0, 0.01)
    >>> x = lambda t: 0.02 * np.cos(5.0 * np.maximum(t, 0.0))
    >>> late = np.where(t > 1.04, -25.0 * x(t - 1.04), 0.0)
    >>> record = Recording("r1", t, {"displacement": x(t - 1.0), "acceleration": late})
    >>> round(accelerometer_late_s(condition(record)), 3)
    0.04
    """
    band = band_of(motion.recording, motion.window, motion.noise)
    if band is None or not {"displacement", "acceleration"} <= set(band.channels):
        return 0.0
    pair = next(p for p in pairs_of(band, Stated()) if (p.first, p.second) == ("acceleration", "displacement"))
    unsure = pair.size == 0.0 or abs(pair.clock) <= DOUBT_ERRORS * pair.stderr / pair.size
    return 0.0 if unsure else pair.clock * band.period_s / (2.0 * math.pi)
