"""What studies keep: rows of CSV files, tables in Markdown, the marked part of a page.

Belongs here: reading and writing them. Does not belong here: what stands in any row or table.
"""

from __future__ import annotations

import csv
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TypeVar

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"

Case = TypeVar("Case")
Cells = Sequence[object] | Mapping[str, object]


def read_rows(path: Path) -> list[dict[str, str]]:
    """Rows of a file by the names of its header; none where there is no file."""
    if not path.exists():
        return []
    with path.open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def write_rows(path: Path, header: Iterable[str], rows: Iterable[Cells]) -> None:
    """A file of these rows, each on the disk before the next one is asked for."""
    with path.open("w", newline="", encoding="utf-8") as stream:
        _write(stream, [list(header)])
        for row in rows:
            _write(stream, [row])


def add_rows(path: Path, header: Iterable[str], rows: Iterable[Cells]) -> None:
    """Rows at a file's end; a new file begins with the header."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("a", newline="", encoding="utf-8") as stream:
        _write(stream, [*([] if stream.tell() else [list(header)]), *rows])


def _write(stream: object, rows: Iterable[Cells]) -> None:
    writer = csv.writer(stream, lineterminator="\n")  # type: ignore[arg-type]
    writer.writerows([*row.values()] if isinstance(row, Mapping) else row for row in rows)
    stream.flush()  # type: ignore[attr-defined]


def add_missing(
    path: Path,
    header: Sequence[str],
    cases: Iterable[Case],
    label: Callable[[Case], tuple[str, ...]],
    rows: Callable[[Case], Sequence[Sequence[object]]],
) -> None:
    """Rows of every case whose label no row of the file begins with, printed and added a case at a time: a study that
    was cut goes on where it stopped."""
    done = [list(row.values()) for row in read_rows(path)]
    for case in cases:
        own = list(label(case))
        if all(row[: len(own)] != own for row in done):
            found = rows(case)
            for row in found:
                print(*row, flush=True)
            add_rows(path, header, found)


def table(head: Sequence[str], rows: Iterable[Iterable[object]]) -> str:
    """A Markdown table.

    >>> print(table(["case", "right"], [("one", 1)]))
    | case | right |
    |---|---|
    | one | 1 |
    """
    lines = ["| " + " | ".join(map(str, row)) + " |" for row in (head, *rows)]
    return "\n".join([lines[0], "|" + "---|" * len(head), *lines[1:]])


def put(page: Path, text: str, begin: str, end: str) -> None:
    """A page with other text between two marks."""
    before, rest = page.read_text(encoding="utf-8").split(begin, 1)
    after = rest.split(end, 1)[1]
    page.write_text(f"{before}{begin}\n{text}\n{end}{after}", encoding="utf-8")
