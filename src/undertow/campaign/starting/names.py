"""Conditions guessed from file names: ``T12_kurz_229_a`` is a trial's number, a word, a number and a repetition.

Belongs here: names. Does not belong here: what is in the files (survey.py), conditions of an index
(indexed.py).
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from undertow.recording.conditions import number
from undertow.recording.readers import suffix_of, trial_name
from undertow.recording.recording import Condition

DRY = frozenset(
    {"dry", "air", "empty", "nowater", "inair", "trocken", "luft", "leer", "sec", "seco", "vide", "asciutto", "aria"}
)
"""Words for a trial without water."""

WET = frozenset({"wet", "water", "full", "nass", "wasser", "voll", "eau", "agua", "acqua", "plein", "lleno"})
"""Words for a trial with water."""

WATER = (
    "depth", "level", "water", "immersion", "draft", "draught", "fill", "tiefe", "wasser", "pegel", "eintauch",
    "profond", "niveau", "eau", "nivel", "agua", "profundidad", "acqua", "livello", "fondale",
)  # fmt: skip
"""How names of columns, and what stands before a number, begin, word by word, that say how much water there is."""

SHORT = 4
"""Letters of a word that must stand whole."""


DEPTH = frozenset({"d", "h", "wd"})
"""Letters before a number that may say how much water there is: they do where one of the numbers is zero."""

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
    group shares, the condition and value of dry trials (None: none seen), what each named group was taken for, whether
    there are trials in water beside dry ones (``wet``), and in words what differs and no group goes by (``beside``)."""

    pattern: str = ""
    group_by: tuple[str, ...] = ()
    dry: tuple[str, Condition] | None = None
    meanings: dict[str, str] = field(default_factory=dict)
    wet: bool = False
    beside: str = ""


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
    group_by: dict[str, list[str]] = {}
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
            group_by[name] = column
        if dry is None:
            dry = next(((name, one) for one in column if one.lower() in DRY), None) or _no_depth(name, prefix, column)
            wet = dry is not None and any(one.lower() not in DRY for one in column)
    if not meanings:
        return Named()
    ends = sorted({suffix_of(base) for base in bases}, key=lambda end: (-len(end), end))
    suffix = "|".join(re.escape(end) for end in ends)
    pattern = f"(?i)^{f'{apart}+'.join(pieces)}(?:{suffix})$"
    if not all(re.search(pattern, base.name) for base in bases):
        return Named()
    return Named(pattern, _without_a_count(group_by, meanings), dry, meanings, wet)


def begins(name: str, beginnings: tuple[str, ...]) -> bool:
    """Whether a word of a column's name begins so; a beginning of `SHORT` letters stands whole (no "right")."""
    words = re.split(r"[\W_0-9]+", name.lower())
    long = tuple(one for one in beginnings if len(one) > SHORT)
    return any(word in beginnings or word.startswith(long) for word in words)


def _no_depth(name: str, prefix: str, column: Sequence[str]) -> tuple[str, Condition] | None:
    """The condition and value of trials without water where one of several depths is zero."""
    deep = prefix.lower() in DEPTH or begins(prefix, WATER)
    return (name, 0.0) if deep and any(number(one.removeprefix(prefix)) == 0.0 for one in column) else None


def _without_a_count(shared: Mapping[str, Sequence[str]], meanings: dict[str, str]) -> tuple[str, ...]:
    """The conditions that groups share, without the number of the trial in its group: with that every trial would be a
    group of its own."""
    rows = list(zip(*shared.values(), strict=True))
    counts = [name for name, column in shared.items() if _counts(column)]
    if len(set(rows)) < len(rows) or not counts:
        return tuple(shared)
    meanings[counts[-1]] = "number of the trial in its group"
    return tuple(name for name in shared if name != counts[-1])


def _counts(column: Sequence[str]) -> bool:
    """Whether parts of names are numbers of trials: whole, from 0 or 1 on, some may be missing."""
    found = [re.fullmatch(r"([A-Za-z]*)([0-9]+)", one) for one in column]
    whole = {int(one[2]) for one in found if one is not None and one[1].lower() in {"", *TRIAL}}
    return None not in found and bool(whole) and max(whole) <= 2 * len(whole)


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
