"""Links that lead out of the folder a campaign's files lie in: what is behind them is not the campaign's to name.

Belongs here: that question. Does not belong here: names with ``..`` in them (gather.py).
"""

from __future__ import annotations

import os
from functools import lru_cache
from pathlib import Path

COPY = "a link that leads out of its folder, to {target}; copy the file itself there"
"""What is said of such a file."""


def leads_out(path: str | os.PathLike[str], folder: str | os.PathLike[str]) -> str:
    """Where a file that is named below a folder lies in truth, if that is outside of it; else an empty text.

    The folder itself may be reached through links: it is what a person named.

    >>> leads_out("data/r1.csv", "data")
    ''
    """
    parent, home = os.path.dirname(path), _real(os.fspath(folder))
    if not os.path.islink(path):
        return "" if _inside(_real(parent), home) else os.path.realpath(path)
    target = os.path.realpath(path)
    return "" if _inside(target, home) else target


def refused(path: str | os.PathLike[str], folder: str | os.PathLike[str]) -> str:
    """The sentence's end for a file that leads out of the folder; empty where it does not."""
    target = leads_out(path, folder)
    return COPY.format(target=target) if target else ""


@lru_cache(maxsize=256)
def _real(folder: str) -> str:
    return os.path.realpath(folder)


def _inside(path: str, folder: str) -> bool:
    return path == folder or Path(path).is_relative_to(folder)
