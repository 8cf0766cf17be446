"""Write the counts that verdicts are given their probability by.

    python -m experiments blind_challenge generate --seed 2102001 --cases 100 --out runs/calibration
    python -m experiments blind_challenge run --out runs/calibration --jobs 2
    python -m experiments calibration runs/calibration [FOLDER ...]            # --add: beside the counts that stand
    python -m experiments calibration FOLDER [...] --fresh FOLDER [...] --page docs/calibration.md

Sealed campaigns of one or more seeds (1,129 of 2109001; 1,138 of 2112001, 2114001, 2115001, 2116001 and 2117001; 1,461
of 2100002, 2118001, 2120001, 2121001 and 2123001; 640 of 2132001 and 2133001; a revision each), which are calibration
from then on. Cases that data cannot tell are left out: no statement about them is right or wrong.

A verdict holds where what it says is so: nothing as large as what counts is missing (`nothing_missing`), something is
(`unknown`, or small without a name), every name is of an effect that is there or, of an effect in no catalogue,
describes it. That a further effect has no name does not count against a name; the strict count, names complete and
exact, is `judge.statement_right` and stands in docs/blind_challenge.md.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from experiments.blind_challenge.run_cases import read_rows
from experiments.calibration.page import PICTURE, Said, page, verdicts_of

Counts = dict[str, Any]

TARGET = Path(__file__).resolve().parents[2] / "src" / "undertow" / "discrepancy" / "calibration.json"


def counted(folders: Sequence[Path]) -> Counts:
    """Counts by kind with seeds, revisions and number of campaigns."""
    verdicts = [one for folder in folders for one in verdicts_of(folder)]
    said, right = Counter(v.kind for v in verdicts), Counter(v.kind for v in verdicts if v.right)
    rows = [row for folder in folders for row in read_rows(folder / "rows.jsonl") if row.get("verdict")]
    return {
        "seeds": sorted({row["seed"] for row in rows}),
        "revisions": sorted({str(row["revision"]) for row in rows}),
        "campaigns": len(rows),
        "records": [{"kind": kind, "said": said[kind], "right": right[kind]} for kind in sorted(said)],
    }


def together(one: Counts, other: Counts) -> Counts:
    """Two sets of counts as one; of a seed that both have none is counted twice."""
    twice = sorted(set(one["seeds"]) & set(other["seeds"]))
    if twice:
        raise ValueError(f"seeds {twice} are counted already")
    records: dict[str, Counter[str]] = {}
    for row in (*one["records"], *other["records"]):
        records.setdefault(row["kind"], Counter()).update({"said": row["said"], "right": row["right"]})
    return {
        "seeds": sorted({*one["seeds"], *other["seeds"]}),
        "revisions": sorted({*one["revisions"], *other["revisions"]}),
        "campaigns": one["campaigns"] + other["campaigns"],
        "records": [{"kind": kind, **found} for kind, found in sorted(records.items())],
    }


def _given(folders: Sequence[Path]) -> tuple[list[Said], str]:
    """All verdicts of folders, and the words for which cases they are of."""
    rows = [row for folder in folders for row in read_rows(folder / "rows.jsonl")]
    marks = sorted({f"seed {row['seed']}, revision {row['revision']}" for row in rows})
    return [one for folder in folders for one in verdicts_of(folder)], f"{len(rows)} cases of {'; '.join(marks)}"


def main(arguments: list[str] | None = None) -> int:
    """Count and write; with a page, write that instead, from the counts as they stand."""
    parser = argparse.ArgumentParser()
    parser.add_argument("folders", nargs="+", type=Path, help="calibration: folders of the blind challenge")
    parser.add_argument("--add", action="store_true", help="add to the counts that stand instead of replacing them")
    parser.add_argument("--fresh", nargs="+", type=Path, help="folders of seeds that nobody had looked at")
    parser.add_argument("--page", type=Path, help="where the page goes; needs --fresh")
    options = parser.parse_args(arguments)
    if options.page is None:
        found = counted(options.folders)
        if options.add:
            found = together(json.loads(TARGET.read_text(encoding="utf-8")), found)
        TARGET.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
        print(TARGET.read_text(encoding="utf-8"))
        return 0
    if options.fresh is None:
        parser.error("--page needs --fresh, a folder of a seed that nobody had looked at")
    counts = json.loads(TARGET.read_text(encoding="utf-8"))
    text, picture = page(counts, *_given(options.folders), *_given(options.fresh))
    (options.page.parent / PICTURE).parent.mkdir(parents=True, exist_ok=True)
    picture.savefig(options.page.parent / PICTURE)
    options.page.write_text(text, encoding="utf-8")
    return 0
