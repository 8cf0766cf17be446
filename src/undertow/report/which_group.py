"""Which of a run's groups a reader means: from words as they stand in a title, or conditions as they stand in a config.

Belongs here: that choice, and what is said where it fails. Does not belong here: titles (discrepancy/words.py), the
group of a recording's own conditions (front/run_prediction.py).
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from undertow.discrepancy.words import group_title
from undertow.errors import ConfigError
from undertow.recording.conditions import same_condition
from undertow.recording.recording import Condition

Conditions = Mapping[str, Condition]

_PIECE = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?|[^\W\d_]+")
"""A number, or letters: "2.3m" is 2.3 and m, "water_depth_m" is water, depth and m."""


def groups_meant(text: str, groups: Sequence[Conditions]) -> list[int]:
    """Places of the groups that ``text`` fits, all of them where it is empty.

    Words and numbers may be some of a title's, in any order; ``condition=value`` is of that condition alone, whose
    name may be shortened to some of its words. Where none fits so, a piece of a title is enough, cut anywhere.

    >>> groups = [{"spring": spring, "depth_m": depth} for spring in ("soft", "stiff") for depth in (2, 2.3)]
    >>> groups_meant("depth 2.3 m", groups), groups_meant("depth=2, stiff", groups), groups_meant("sti", groups)
    ([1, 3], [2], [2, 3])
    """
    said = [part for part in text.split(",") if part.strip()]
    titles = [group_title(group).casefold() for group in groups]
    wanted = " ".join(text.casefold().split())
    if wanted in titles:
        return [titles.index(wanted)]
    found = [at for at, group in enumerate(groups) if all(_fits(part, group) for part in said)]
    return found or [at for at, title in enumerate(titles) if wanted in title]


def group_meant(text: str, groups: Sequence[Conditions]) -> int:
    """Place of the only group that ``text`` fits; ConfigError with those to choose from where none or several do."""
    found = groups_meant(text, groups)
    if len(found) == 1:
        return found[0]
    among = [groups[at] for at in found] or groups
    fits = f"{len(found)} groups fit" if found else "no group fits"
    raise ConfigError(f"{fits} {text!r}; say one of: {'; '.join(group_title(group) for group in among)}")


def _fits(part: str, group: Conditions) -> bool:
    """Whether one part of what was said, between commas, is of this group."""
    key, sign, value = part.partition("=")
    if not sign:
        return _within(part, group_title(group), *group, *map(str, group.values()))
    return any(_within(key, column) and _is(value, column, own) for column, own in group.items())


def _is(said: str, column: str, own: Condition) -> bool:
    """Whether a value as written, perhaps with its unit, is this condition's."""
    return same_condition(said, own) or (
        bool(_pieces(said)) and _within(said, column, str(own)) and _within(str(own), said)
    )


def _within(said: str, *among: str) -> bool:
    """Whether every piece of what is said is a piece of the others."""
    there = [piece for text in among for piece in _pieces(text)]
    return all(any(same_condition(piece, one) for one in there) for piece in _pieces(said))


def _pieces(text: str) -> list[str]:
    return [piece.casefold() for piece in _PIECE.findall(text)]
