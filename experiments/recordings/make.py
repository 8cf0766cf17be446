"""Run every real recording from its config and write docs/recordings.json and docs/recordings.md.

    python -m experiments recordings.make

needs the recordings beside the repository, in ../shared/recordings. Belongs here: the two files and what they were made
from. Does not belong here: runs (studies.py), published numbers (published.py), the page's text (page.py).
"""

from __future__ import annotations

import hashlib
import json
import subprocess
import sys
from collections.abc import Mapping
from typing import Any

from experiments.recordings.compare import compare
from experiments.recordings.page import page
from experiments.recordings.published import REFERENCES
from experiments.recordings.studies import RECORDINGS, ROOT, STUDIES, inputs, plain, run_study

COMMAND = "python -m experiments recordings.make"
JSON, PAGE = ROOT / "docs" / "recordings.json", ROOT / "docs" / "recordings.md"

ROOMS = ("recording", "conditioning", "equation", "likelihood", "uncertainty", "methods", "comparison")
"""Rooms of the package whose code decides what a recording gives."""

SOURCES = (
    *(f"src/undertow/{room}/**/*.py" for room in ROOMS),
    "src/undertow/quantities.py",
    "configs/recordings/*.yaml",
    "experiments/recordings/*.py",
)
"""What the page's coefficients come from: rooms, configs, these scripts. Scores and verdicts, which other rooms have a
hand in, are held against a live run by tests/recordings."""


def sources() -> dict[str, str]:
    """sha256 of every source file, by its path in the repository."""
    files = sorted({path for pattern in SOURCES for path in ROOT.glob(pattern)})
    return {str(path.relative_to(ROOT)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def changed_since(stored: Mapping[str, str], current: Mapping[str, str]) -> list[str]:
    """Source files that are not what they were, came, or went, sorted."""
    return sorted(name for name in {*stored, *current} if stored.get(name) != current.get(name))


def make() -> dict[str, Any]:
    """All studies, run now, with what they were made from."""
    before = sources()
    studies, read = [], {}
    for study in STUDIES:
        findings = run_study(study)
        studies.append(plain(study, findings))
        read |= inputs(findings)
    if sources() != before:
        raise SystemExit(f"sources changed while they ran: {', '.join(changed_since(before, sources()))}; run again")
    return {
        "made_by": COMMAND,
        "commit": _git("rev-parse", "HEAD"),
        "changed_since_commit": _git("status", "--porcelain", "--", *before).splitlines(),
        "inputs": dict(sorted(read.items())),
        "sources": before,
        "comparisons": compare(REFERENCES, studies),
        "studies": studies,
    }


def _git(*words: str) -> str:
    return subprocess.run(["git", "-C", str(ROOT), *words], capture_output=True, text=True, check=True).stdout.strip()


def main() -> int:
    """Write both files; 1 where the recordings are not there."""
    if not RECORDINGS.is_dir():
        print(f"{RECORDINGS} is not there: the real recordings stand beside the repository", file=sys.stderr)
        return 1
    made = make()
    JSON.write_text(json.dumps(made, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    PAGE.write_text(page(made), encoding="utf-8")
    judged = [row for row in made["comparisons"] if row["met"] is not None]
    print(f"{len(made['studies'])} runs; {sum(row['met'] for row in judged)} of {len(judged)} limits met")
    return 0
