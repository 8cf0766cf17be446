"""What the studies found, as docs/confusion.md with its json and svg.

Belongs here: counts, tables and the picture, made from committed rows alone. Does not belong here: any judging.
"""

from __future__ import annotations

from pathlib import Path


def make_page(results: Path, docs: Path) -> None:
    """Write docs/confusion.* from the rows of all studies."""
