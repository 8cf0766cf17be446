"""A finished part of a run as a file: JSON with its layout's number, its name and a checksum of what it holds.

A part is taken again only where all three agree; a damaged, renamed or older file is as good as none, and said. Nothing
is ever unpickled.

Belongs here: that file. Does not belong here: what a part holds (checkpoints.py).
"""

from __future__ import annotations

import hashlib
import json
import logging
from pathlib import Path
from typing import Any

from undertow.report.writing import write_bytes

FORMAT = 3
"""Number of this file's layout; a file of another is not taken."""

LARGEST_BYTES = 2**30
"""Of a part that is read: one of sixty trials has some 10 MB."""


def write_part(path: Path, data: Any) -> None:
    """Write plain values (numbers, texts, lists, mappings by text); the file appears whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    body = json.dumps(data)
    head = json.dumps({"format": FORMAT, "name": path.stem, "sha256": _sum(body)})
    write_bytes(path, f'{head[:-1]}, "data": {body}}}'.encode())


def read_part(path: Path) -> Any:
    """What a part holds; None where there is no such file, or, with a message, one that is not as it was written."""
    try:
        if path.stat().st_size > LARGEST_BYTES:
            return _refused(path, f"has more than {LARGEST_BYTES} bytes")
        kept = json.loads(path.read_bytes())
    except FileNotFoundError:
        return None
    except (OSError, ValueError, RecursionError):
        return _refused(path, "is damaged: it cannot be read as JSON")
    if not isinstance(kept, dict) or set(kept) != {"format", "name", "sha256", "data"}:
        return _refused(path, "is damaged or foreign: a part has format, name, sha256 and data")
    if kept["format"] != FORMAT:
        return _refused(path, f"has format {kept['format']!r}, and this version reads {FORMAT}")
    if kept["name"] != path.stem:
        return _refused(path, f"was written under another name, {kept['name']!r}")
    if kept["sha256"] != _sum(json.dumps(kept["data"])):
        return _refused(path, "is damaged: its checksum is another")
    return kept["data"]


def _sum(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _refused(path: Path, why: str) -> None:
    """Say that a part is made again, and why."""
    logging.getLogger("undertow").warning("part %s of the run folder %s; it is made again", path.name, why[:200])
