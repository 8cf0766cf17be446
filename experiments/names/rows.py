"""Rows of the studies on disk, one file a study; a campaign judged again replaces its row.

Belongs here: reading, appending, which campaigns are done. Does not belong here: what is in a row (verdicts.py).
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from experiments.files import add_rows, read_rows

COLUMNS = (
    *("study", "hidden", "strength", "seed", "size", "reached", "view", "decay_per_s", "springs", "trials", "rate_hz"),
    *("scatter", "outcome", "wet", "rivals", "dry", "status", "dry_status", "p_value"),
    *("confidence", "nrmse", "augmented", "repeatability"),
    *("trials_failed", "cpu_s", "failed", "revision"),
)
IDENTITY = ("study", "hidden", "strength", "seed", "view")
"""What tells one campaign of a study from another."""


def key(row: Mapping[str, object]) -> tuple[str, ...]:
    """A row's campaign.

    >>> key({"study": "nulls", "hidden": "", "strength": 0.0, "seed": 3})
    ('nulls', '', '0.0', '3', '')
    """
    return tuple(str(row.get(column, "")) for column in IDENTITY)


def read(path: Path) -> list[dict[str, str]]:
    """Rows of a study, the latest of each campaign, in the order in which campaigns came first; none without a file."""
    return list({key(row): row for row in read_rows(path)}.values())


def append(path: Path, row: Mapping[str, object]) -> None:
    """Add one row at the end of a study's file, in the columns that it has."""
    columns = path.read_text(encoding="utf-8").partition("\n")[0].split(",") if path.exists() else COLUMNS
    add_rows(path, columns, [[row.get(column, "") for column in columns]])
