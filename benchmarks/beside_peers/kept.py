"""Rows of a comparison as a file.

Belongs here: writing them. Does not belong here: what a row is (table.py, driven_table.py).
"""

from __future__ import annotations

import csv
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Protocol


class Line(Protocol):
    """A row that is kept."""

    def cells(self) -> Sequence[object]:
        """Its values, in the order of the header."""
        ...


def write_rows(rows: Iterable[Line], header: Sequence[str], path: Path) -> None:
    """A line a row, below the header."""
    with path.open("w", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(row.cells() for row in rows)
