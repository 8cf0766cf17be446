"""Keeps of an audit's folder what docs/published_tables.md shows: verdicts and four figures.

    undertow audit configs/published.yaml --out runs/published && python -m experiments audit.keep runs/published

Nothing is computed here.
"""

from __future__ import annotations

import json
import shutil
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent / "published"
PICTURES = Path(__file__).resolve().parents[2] / "docs" / "pictures" / "published"
FIGURES = {
    "share-0": "table10_share", "series-0-open": "table05_open",
    "series-3-rows": "tables07_08_rows", "series-4-resonators": "tables04_06_resonators",
}  # fmt: skip


def main() -> None:
    """Copy figures under their names, and audit.json in one line a table."""
    folder = Path(sys.argv[1])
    HERE.mkdir(exist_ok=True)
    PICTURES.mkdir(parents=True, exist_ok=True)
    for source, name in FIGURES.items():
        shutil.copy(folder / "figures" / f"{source}.svg", PICTURES / f"{name}.svg")
    said = json.loads((folder / "audit.json").read_text(encoding="utf-8"))
    (HERE / "audit.json").write_text(json.dumps(said, indent=1) + "\n", encoding="utf-8")
