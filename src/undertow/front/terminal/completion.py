"""Words that a shell offers when a reader presses the tabulator: run folders, groups, terms.

Belongs here: those words. Does not belong here: the shells' scripts (typer has them).
"""

from __future__ import annotations

import json
from pathlib import Path

from undertow.discrepancy.words import group_title
from undertow.equation.registry import names
from undertow.report.writing import PAGES


def run_folders(incomplete: str) -> list[str]:
    """Folders that begin with these letters and hold a run; where none does, the folders to go on into."""
    start = Path(incomplete or ".")
    parent = start if incomplete.endswith("/") or not incomplete else start.parent
    begin = "" if parent == start else start.name
    try:
        folders = sorted(p for p in parent.iterdir() if p.is_dir() and p.name.startswith(begin) and p.name[0] != ".")
    except OSError:
        return []
    runs = [str(p) for p in folders if any((p / name).is_file() for name in PAGES)]
    below = [str(p) for folder in folders for p in sorted(folder.glob("*")) if (p / "verdict.json").is_file()]
    return [*runs, *below] or [f"{p}/" for p in folders]


def group_titles(run: object, incomplete: str) -> list[str]:
    """Titles of a run's groups that hold these letters."""
    try:
        groups = json.loads((Path(str(run)) / "verdict.json").read_text(encoding="utf-8"))["groups"]
        titles = [group_title(one["group"]) for one in groups]
    except (OSError, ValueError, LookupError, TypeError):
        return []
    return [title for title in titles if incomplete.casefold() in title.casefold()]


def term_names(incomplete: str) -> list[str]:
    """Terms of the registry that begin with these letters."""
    return [name for name in names() if name.startswith(incomplete)]
