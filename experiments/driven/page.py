"""Studies of driven bodies as commands, and their tables on docs/driven_measured.md.

Belongs here: what such studies have in common. Does not belong here: any table's content.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from experiments import files
from experiments.files import DOCS, add_missing, read_rows, write_rows

PAGE = DOCS / "driven_measured.md"
Lines = Sequence[Sequence[str]]


def put(table: str, name: str) -> None:
    """The page with the table between the marks of that name."""
    files.put(PAGE, table, f"<!-- {name} -->", f"<!-- end of {name} -->")


def read(path: Path) -> list[list[str]]:
    """Rows of a file that may not be there yet."""
    return [list(row.values()) for row in read_rows(path)]


def kept(result: Path, header: Sequence[str], lines: Lines, table: Callable[[Lines], str], name: str) -> None:
    """A whole study's rows as its file, and their table on the page."""
    write_rows(result, header, lines)
    put(table(lines), name)


def resumed(
    result: Path,
    header: Sequence[str],
    seeds: tuple[int, int],
    cases: Callable[[int], Iterable[tuple]],
    label: Callable[..., tuple[str, ...]],
    rows: Callable[..., Lines],
    table: Callable[[Lines], str],
    name: str,
) -> None:
    """A study as a command, ``[--calibration] [FILE]``: run what the file lacks; print the table, and put that of the
    proof on the page. ``seeds`` are the first ones of calibration and proof."""
    given = [word for word in sys.argv[1:] if not word.startswith("--")]
    path = Path(given[0]) if given else result
    every = cases(seeds[0] if "--calibration" in sys.argv else seeds[1])
    add_missing(path, header, every, lambda case: label(*case), lambda case: rows(*case))
    print(table(read(path)))
    if path == result:
        put(table(read(path)), name)
