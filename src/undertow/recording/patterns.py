"""File name patterns of a config, and which trials they fit.

A trial is named by its file's name, its path or the end of it (as the index writes it), any of these without
the suffix, or its own name; ``*``, ``?`` and ``[...]`` stand for other characters. A pattern without a ``/`` is held
against names alone: ``*17*`` does not mean every file in the folder 2017.

Belongs here: names against patterns. Does not belong here: what a pattern is for (gather.py, campaign).
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from fnmatch import fnmatchcase
from functools import lru_cache
from pathlib import Path

from undertow.recording.readers import trial_name

_WILD = frozenset("*?[")
Names = tuple[str, str, str]


class Patterns:
    """Several patterns, asked for those that fit a trial; as quick with ten thousand plain names as with one.

    >>> Patterns(["*_01.txt", "sub/t_02.txt", "t_02", "t_03"]).fitting("t_02", "data/sub/t_02.txt")
    ('sub/t_02.txt', 't_02')
    """

    def __init__(self, patterns: Iterable[str]) -> None:
        self._order = {pattern: at for at, pattern in enumerate(patterns)}
        self._wild = [pattern for pattern in self._order if _WILD & set(pattern)]
        self._plain: dict[str, list[str]] = {}
        for pattern in self._order:
            self._plain.setdefault(pattern.rpartition("/")[2], []).append(pattern)

    def __bool__(self) -> bool:
        return bool(self._order)

    def fitting(self, name: str, file: str) -> tuple[str, ...]:
        """The patterns that fit the trial of this name in this file, in the order they were given."""
        if not self._order:
            return ()
        whole = file.replace(os.sep, "/")
        names = _names(whole.rpartition("/")[2])
        last = dict.fromkeys((name.rpartition("/")[2], *names))
        found = {p for text in last for p in self._plain.get(text, ()) if _is_end(p, name, whole, names)}
        found |= {pattern for pattern in self._wild if _looks_like(pattern, name, whole, names)}
        return tuple(sorted(found, key=self._order.__getitem__))

    def fit(self, name: str, file: str) -> bool:
        """Whether one of the patterns fits."""
        return bool(self.fitting(name, file))


@lru_cache(maxsize=8)
def patterns_of(patterns: tuple[str, ...]) -> Patterns:
    """The same `Patterns` for the same texts: a list of held-out files is asked group by group."""
    return Patterns(patterns)


def _is_end(pattern: str, name: str, whole: str, names: Names) -> bool:
    """Whether a plain text is the trial's name, its path, or whole parts of the path's end."""
    wanted = pattern.removeprefix("./")
    if wanted == name or wanted in names:
        return True
    return any(text == wanted or text.endswith(f"/{wanted}") for text in _paths(whole, names))


def _looks_like(pattern: str, name: str, whole: str, names: Names) -> bool:
    """Whether a pattern with wild characters fits; only one with a ``/`` is held against folders too."""
    wanted = pattern.removeprefix("./")
    if any(fnmatchcase(text, wanted) for text in (name, *names)):
        return True
    if "/" not in wanted:
        return False
    return any(fnmatchcase(text, end) for text in _paths(whole, names) for end in (wanted, f"*/{wanted}"))


def _paths(whole: str, names: Names) -> tuple[str, ...]:
    """A path as it was put together and without ``..``, both also without suffix."""
    cuts = [len(names[0]) - len(name) for name in names]
    both = (whole, os.path.abspath(whole).replace(os.sep, "/"))
    return tuple(dict.fromkeys(text[: len(text) - cut] for text in both for cut in cuts))


def _names(base: str) -> Names:
    """A file's name, the name of the file that is packed in it, and the name without any suffix."""
    return base, base.removesuffix(".gz"), trial_name(Path(base))
