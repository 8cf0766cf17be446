"""Write the counts that verdicts are given their probability by.

    python -m experiments.blind_challenge generate --seed 2100901 --cases 160 --out runs/calibration
    python -m experiments.blind_challenge run --out runs/calibration --jobs 2
    python -m experiments.calibration runs/calibration

These 160 are calibration: some were looked at while the rules of that session were made, and after them two more were
(a name beside which unseen trials are 2 % of the motion further away, one of several effects without a level that
stands out). Cases that data cannot tell are left out: no statement about them is right or wrong.

A verdict holds where what it says is so: nothing as large as what counts is missing (`nothing_missing`), something is
(`unknown`, or small without a name), every name is of an effect that is there or, of an effect in no catalogue,
describes it. That a further effect has no name does not count against a name; the strict count, names complete and
exact, is `judge.statement_right` and stands in docs/blind_challenge.md.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from pathlib import Path

from experiments.blind_challenge.judge import holds, judge_case
from experiments.blind_challenge.run_cases import read_rows
from undertow.discrepancy.calibration import LEFT, kind_of

TARGET = Path(__file__).resolve().parents[2] / "src" / "undertow" / "discrepancy" / "calibration.json"


def counted(folder: Path) -> dict[str, object]:
    """Counts by kind with seed, revision and number of campaigns."""
    said: Counter[str] = Counter()
    right: Counter[str] = Counter()
    rows = [row for row in read_rows(folder / "rows.jsonl") if row.get("verdict")]
    for row in rows:
        truth = json.loads((folder / "sealed" / f"{row['case']}.json").read_text(encoding="utf-8"))
        if truth["kind"] == "cannot":
            continue
        for group in judge_case(row, truth).groups:
            is_right = holds(group)
            if is_right is None:
                continue
            left = next((g["value"] for g in group.said["decision"] if g["gate"] == LEFT), float("nan"))  # type: ignore[attr-defined]
            kind = kind_of(str(group.said["status"]), list(group.said["verdict"]), float(left))  # type: ignore[call-overload]
            said[kind] += 1
            right[kind] += is_right
    return {
        "seed": rows[0]["seed"] if rows else None,
        "revisions": sorted({str(row["revision"]) for row in rows}),
        "campaigns": len(rows),
        "records": [{"kind": kind, "said": said[kind], "right": right[kind]} for kind in sorted(said)],
    }


def main(arguments: list[str]) -> int:
    """Count and write."""
    (folder,) = arguments
    TARGET.write_text(json.dumps(counted(Path(folder)), indent=1) + "\n", encoding="utf-8")
    print(TARGET.read_text(encoding="utf-8"))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
