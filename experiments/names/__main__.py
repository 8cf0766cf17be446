"""Run a study of the diagnosis; rows are written as they come, and a cut run goes on where it stopped.

    python -m experiments names --study nulls --seeds 30
    python -m experiments names --study confusion --seeds 1 --strengths 1.5 --names relaxation hysteresis
    python -m experiments names --folder /tmp/hidden --names relaxation --strengths 4   # a campaign on disk, not judged
    python -m experiments names --page                                                  # docs/confusion.* from the rows
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

from joblib import Parallel, delayed

from experiments.names.folder import write
from experiments.names.page import make_page
from experiments.names.rows import append, key, read
from experiments.names.studies import STRENGTHS, STUDIES, Case
from experiments.names.verdicts import Row, judge, outcome
from experiments.revision import revision

IN_MINUTES = "--study nulls --seeds 1 --out {}"
HERE = Path(__file__).resolve().parent
RESULTS = HERE / "results"
WITH_NAMES = ("confusion", "pairs")


def main(arguments: list[str] | None = None) -> int:
    """Run a study, write one campaign, or make the page."""
    options = _options(arguments)
    if options.page:
        make_page(RESULTS, HERE.parents[1] / "docs")
        return 0
    seeds = range(options.first, options.first + options.seeds)
    narrowed = {"names": tuple(options.names), "strengths": tuple(options.strengths)}
    cases = STUDIES[options.study](seeds, **(narrowed if options.study in WITH_NAMES else {}))
    if options.folder:
        for case in cases:
            print(write(case.campaign, options.folder / _name(case), case.view))
        return 0
    for row in _rows(_open(cases, options), options.jobs):
        append(options.out / f"{options.study}.csv", row)
        print(_line(row), flush=True)
    return 0


def _rows(cases: Iterator[Case], jobs: int) -> Iterator[Row]:
    """Rows as they come, by one process or several."""
    if jobs < 2:
        return (_row(case) for case in cases)
    rows: Iterator[Row] = Parallel(jobs, return_as="generator")(delayed(_row)(case) for case in cases)
    return rows


def _options(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Campaigns with one known thing missing, and what is said of them.")
    parser.add_argument("--study", choices=sorted(STUDIES), default="confusion")
    parser.add_argument("--seeds", type=int, default=1, help="how many seeds")
    parser.add_argument("--first", type=int, default=0, help="the first seed")
    parser.add_argument("--names", nargs="*", default=[], help="only these names (confusion, pairs)")
    parser.add_argument("--strengths", nargs="*", type=float, default=list(STRENGTHS))
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--out", type=Path, default=RESULTS, help="folder of the rows")
    parser.add_argument("--again", action="store_true", help="judge again what has a row already")
    parser.add_argument("--folder", type=Path, help="write the campaigns there and judge nothing")
    parser.add_argument("--page", action="store_true", help="make docs/confusion.* from the rows")
    return parser.parse_args(arguments)


def _name(case: Case) -> str:
    label = case.label
    return f"{label['study']}_{label['hidden'] or 'nothing'}_{label['strength']}_{label['seed']}".replace("+", "_and_")


def _open(cases: Iterator[Case], options: argparse.Namespace) -> Iterator[Case]:
    """The cases that have no row yet."""
    rows = [] if options.again else read(options.out / f"{options.study}.csv")
    done = {key(row) for row in rows}
    return (case for case in cases if key(case.label) not in done)


def _row(case: Case) -> Row:
    plan = case.campaign.plan
    row: Row = dict(case.label)
    row |= {"springs": "+".join(plan.springs), "trials": plan.wet_trials, "rate_hz": plan.rate_hz}
    row |= {"scatter": plan.scatter}
    row |= judge(case.campaign, case.view)
    return row | {"outcome": outcome(row), "revision": revision()}


def _line(row: Row) -> str:
    said = row.get("failed") or f"{row['wet'] or 'nothing'} (rivals {row['rivals']}; dry {row['dry'] or 'nothing'})"
    hidden = f"{row['hidden'] or 'nothing'} {row['strength']} seed {row['seed']}"
    return f"{row['outcome']:8s} {hidden:42s} {row.get('view', '')} {said} {row.get('cpu_s', '')} s"
