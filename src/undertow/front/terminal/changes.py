"""`undertow compare` on a terminal: what changed between runs, and all the rest where it is asked for.

Belongs here: the comparison's table as text. Does not belong here: what counts as a change (report/compare.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pandas as pd
from rich import box
from rich.table import Table
from rich.text import Text

from undertow.front.terminal.table import table_text
from undertow.report.compare import changes_in_words, compare_runs, quantity_words
from undertow.report.writing import true_minus


def comparison_text(
    folders: Sequence[Path], whole: bool = False, width: int = 0, colour: bool = False
) -> str:
    """The comparison for a terminal: a group's name, below it the quantities that differ (``whole``: all), and last how
    many groups changed."""
    table = compare_runs(folders)
    shown = table if whole else table[table["change"] != ""]
    lines = [table_text(_table(shown), width, colour)] if len(shown) else []
    return true_minus("\n".join([*lines, changes_in_words(table)]))


def comparison_json(folders: Sequence[Path]) -> list[dict[str, Any]]:
    """Every row of the comparison: group, quantity, each run's text, change, changed."""
    return [
        {str(name): bool(value) if name == "changed" else str(value) for name, value in row.items()}
        for row in compare_runs(folders).to_dict("records")
    ]


def _table(rows: pd.DataFrame) -> Table:
    """One column a run; a line between groups; what matters in colour."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for name in rows.columns[1:-1]:
        table.add_column(Text(str(name)), overflow="fold")
    for group, of_group in rows.groupby("group", sort=False):
        table.add_row(Text(str(group), style="bold"))
        for row in of_group.itertuples(index=False):
            quantity, *values, changed = row[1:]
            cells = [quantity_words(str(quantity)), *values]
            table.add_row(*(Text(str(cell)) for cell in cells), style="red" if changed else "")
    return table
