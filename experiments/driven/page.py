"""Tables of docs/driven_measured.md: what stands between two marks is made anew.

Belongs here: that replacement. Does not belong here: any table's content.
"""

from __future__ import annotations

from pathlib import Path

PAGE = Path(__file__).resolve().parents[2] / "docs" / "driven_measured.md"


def put(table: str, name: str) -> None:
    """The page with the table between the marks of that name."""
    begin, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
    before, rest = PAGE.read_text(encoding="utf-8").split(begin)
    PAGE.write_text(f"{before}{begin}\n{table}\n{end}{rest.split(end)[1]}", encoding="utf-8")
