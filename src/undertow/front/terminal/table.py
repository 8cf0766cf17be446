"""A table on a terminal, or where there is none, as text.

Belongs here: that, without anything that takes long to import. Does not belong here: what stands in a table.
"""

from __future__ import annotations

import io

from rich.console import Console
from rich.table import Table

NO_TERMINAL_WIDTH = 2000
"""Characters a line may have where stdout is no terminal: tables are then as wide as their content."""


def table_text(table: Table, width: int = 0, colour: bool = False) -> str:
    """A table as text; ``width`` 0 lets it be as wide as its content."""
    stream = io.StringIO()
    console = Console(
        file=stream, width=width or NO_TERMINAL_WIDTH, force_terminal=colour, highlight=False, no_color=not colour
    )
    console.print(table)
    return "\n".join(line.rstrip() for line in stream.getvalue().splitlines() if line.strip())
