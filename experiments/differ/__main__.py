"""`undertow differ` tried on pairs whose difference is known: writes docs/differ.json and the table of docs/differ.md.

    python -m experiments differ              # all pairs
    python -m experiments differ --only NAME  # one, printed alone
"""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any

from experiments.differ.pairs import Pair, pairs
from experiments.files import DOCS, put
from undertow.campaign.differ.files import differ
from undertow.report.verdict_file import plain

MARK = "<!-- table -->"
"""In docs/differ.md the table stands between two of these."""


def result(pair: Pair, folder: Path) -> dict[str, Any]:
    """What the comparison says of one pair, beside what is so."""
    found = differ(pair.simulation, pair.recording, pair.config, folder / "out").difference
    return {
        "pair": pair.name, "truth": list(pair.lacks), "lacks": list(found.lacks),
        "alternatives": [list(a) for a in found.recording.verdict.alternatives] if not found.by_equation else [],
        "nrmse": plain(found.mismatch.nrmse), "repeatability": plain(found.mismatch.repeatability_nrmse),
        "sentence": found.sentence,
    }  # fmt: skip


def table(rows: list[dict[str, Any]]) -> str:
    """The rows as markdown."""
    lines = ["| pair | truth | named as lacking | not distinguished from | misses |", "| --- | --- | --- | --- | --- |"]
    for row in rows:
        others = "; ".join(" + ".join(names) for names in row["alternatives"]) or "-"
        lines.append(
            f"| {row['pair']} | {', '.join(row['truth']) or 'nothing'} | {', '.join(row['lacks']) or 'nothing'} | "
            f"{others} | {100.0 * row['nrmse']:.2g} % |"
        )
    return "\n".join(lines)


def main() -> None:
    """All pairs, or one."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", help="name of one pair")
    only = parser.parse_args().only
    rows = []
    with tempfile.TemporaryDirectory() as scratch:
        for pair in pairs(Path(scratch)):
            if only is None or pair.name == only:
                rows.append(result(pair, Path(scratch)))
                print(rows[-1]["pair"], rows[-1]["lacks"], rows[-1]["alternatives"], flush=True)
    if only is None:
        (DOCS / "differ.json").write_text(json.dumps(rows, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
        put(DOCS / "differ.md", table(rows), MARK, MARK)
    print(table(rows))
