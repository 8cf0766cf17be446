"""Anchors of the page's parts, which are also names of figures' files.

Belongs here: those names. Does not belong here: what a reader sees (wording.py).
"""

from __future__ import annotations

import itertools
import re
from collections.abc import Sequence

RESERVED_ANCHORS = frozenset({"campaign", "first", "overview", "failed", "made"})
"""Anchors of the page's own parts."""

ANCHOR_AT_MOST = 60
"""Letters of an anchor: it is also a file's name."""


def safe_anchor(text: str) -> str:
    """A text as an anchor of a page: lower case letters, digits and single dashes.

    >>> safe_anchor("spring short, water depth 2.36 m")
    'spring-short-water-depth-2-36-m'
    """
    return re.sub(r"[^a-z0-9]+", "-", text.lower())[:ANCHOR_AT_MOST].strip("-") or "group"


def anchors(texts: Sequence[str]) -> list[str]:
    """One anchor a text, numbered where two would be alike.

    >>> anchors(["depth 2.3", "depth 2,3", "水"])
    ['depth-2-3', 'depth-2-3-2', 'group']
    """
    out: list[str] = []
    for text in texts:
        plain = safe_anchor(text)
        free = (f"{plain}-{number}" for number in itertools.count(2))
        out.append(plain if plain not in {*out, *RESERVED_ANCHORS} else next(a for a in free if a not in out))
    return out
