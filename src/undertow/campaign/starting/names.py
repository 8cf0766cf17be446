"""Conditions guessed from file names: ``T12_kurz_229_a`` is a trial's number, a word, a number and a repetition.

Belongs here: names. Does not belong here: what is in the files (survey.py), conditions of an index
(indexed.py).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from undertow.recording.readers import suffix_of, trial_name
from undertow.recording.recording import Condition

DRY = frozenset(
    {"dry", "air", "empty", "nowater", "inair", "trocken", "luft", "leer", "sec", "seco", "vide", "asciutto", "aria"}
)
"""Words for a trial without water."""

WET = frozenset({"wet", "water", "full", "nass", "wasser", "voll", "eau", "agua", "acqua", "plein", "lleno"})
"""Words for a trial with water."""

SPRING = frozenset(
    {"short", "long", "soft", "stiff", "hard", "weak", "strong", "kurz", "lang", "weich", "hart", "steif", "court"}
)
"""Words that springs are called by."""

TRIAL = frozenset({"t", "r", "v", "n", "nr", "no", "run", "test", "trial", "versuch", "messung", "exp", "rec", "file"})
"""What a trial's number is preceded by."""

REPEAT = frozenset({"rep", "repeat", "repetition", "wdh", "take"})
"""What a repetition's number is preceded by."""

MOST_LEVELS = 0.5
"""A condition of a group takes at most this many values a trial: two trials of each."""

_APART = r"[_\-\s]"
_NUMBER = r"[0-9]+(?:[.,][0-9]+)?"


@dataclass(frozen=True)
class Named:
    """``pattern`` (a regular expression with named groups; empty where names have no common form), conditions that a
    group shares, the condition and value of dry trials (None: none seen), what each named group was taken for, and
    whether there are trials in water beside dry ones (``wet``)."""

    pattern: str = ""
    group_by: tuple[str, ...] = ()
    dry: tuple[str, Condition] | None = None
    meanings: dict[str, str] = field(default_factory=dict)
    wet: bool = False


def read_names(files: Sequence[str]) -> Named:
    """What file names say, where all have the same number of parts between ``_``, ``-`` and blanks.

    >>> read_names(["T1_kurz_229_a.csv", "T2_kurz_229_b.csv", "T3_lang_229_a.csv", "T4_lang_229_b.csv"]).group_by
    ('spring',)
    """
    bases = [Path(name) for name in files]
    parts = [[part for part in re.split(f"{_APART}+", trial_name(base)) if part] for base in bases]
    if len({len(one) for one in parts}) != 1 or len(files) < 2:
        return Named()
    marks = {mark for base in bases for mark in re.findall(_APART, trial_name(base))}
    apart = re.escape(marks.pop()) if len(marks) == 1 else _APART
    piece = f"[^{apart.strip('[]')}]+"
    columns = [list(column) for column in zip(*parts, strict=True)]
    pieces: list[str] = []
    meanings: dict[str, str] = {}
    group_by: list[str] = []
    dry: tuple[str, Condition] | None = None
    wet = False
    for at, column in enumerate(columns):
        if len(set(column)) == 1:
            pieces.append(re.escape(column[0]))
            continue
        name, prefix, meaning, shared = _meaning(column, at == len(columns) - 1)
        name = name if name not in meanings else f"{name}_{at + 1}"
        inside = _NUMBER if prefix else f"{piece}?" if at == len(columns) - 1 else piece
        pieces.append(f"{re.escape(prefix)}(?P<{name}>{inside})")
        meanings[name] = meaning
        if shared:
            group_by.append(name)
        if dry is None:
            dry = next(((name, one) for one in column if one.lower() in DRY), None)
            wet = dry is not None and any(one.lower() not in DRY for one in column)
    if not meanings:
        return Named()
    ends = sorted({suffix_of(base) for base in bases}, key=lambda end: (-len(end), end))
    suffix = "|".join(re.escape(end) for end in ends)
    pattern = f"(?i)^{f'{apart}+'.join(pieces)}(?:{suffix})$"
    if not all(re.search(pattern, base.name) for base in bases):
        return Named()
    return Named(pattern, tuple(group_by), dry, meanings, wet)


def _meaning(column: Sequence[str], last: bool) -> tuple[str, str, str, bool]:
    """The name of one part, the letters before its number, what it was taken for, and whether groups share it."""
    few = len(set(column)) <= MOST_LEVELS * len(column)
    lower = {one.lower() for one in column}
    prefixed = [re.fullmatch(rf"([A-Za-z]+)({_NUMBER})", one) for one in column]
    prefixes = {found.group(1) for found in prefixed if found}
    if all(prefixed) and len(prefixes) == 1:
        prefix = prefixes.pop()
        if prefix.lower() in REPEAT:
            return "repetition", prefix, "number of a repetition", False
        if prefix.lower() in TRIAL and not few:
            return "trial", prefix, "number of the trial", False
        return prefix.lower(), prefix, f"number after {prefix!r}", few
    if lower & DRY or lower & WET:
        return "water", "", "dry or with water", True
    if lower & SPRING:
        return "spring", "", "name of the spring", True
    numbers = all(re.fullmatch(_NUMBER, one) for one in column)
    if last and all(len(one) == 1 and (one.isalpha() or one.isdigit()) for one in column):
        return "repetition", "", "letter or digit of a repetition", False
    if numbers:
        return ("level", "", "a number that several trials share", True) if few else (
            "trial", "", "a number that every trial has for itself", False)  # fmt: skip
    if few:
        return "kind", "", "a word that several trials share", True
    return "label", "", "a word of each trial", False
