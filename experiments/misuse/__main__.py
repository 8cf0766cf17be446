"""Make ordinary mistakes through the command, see what is said, write docs/misuse.md and docs/misuse.json.

    python -m experiments misuse                         # 60 mistakes and 10 campaigns in order: about four minutes
    python -m experiments misuse --small                 # one or two of each kind; a table, no page
    python -m experiments misuse --only g_labelled_mps2  # one case and all that was said; no page

Exit 0 where every answer is right, 1 otherwise. `--out DIR` writes the page there, of the cases that were run.
"""

from __future__ import annotations

import argparse
import tempfile
from pathlib import Path

from experiments.misuse.mistakes import CASES, SMALL, case
from experiments.misuse.page import Answer, make_page, table_line
from experiments.misuse.running import run_case

DOCS = Path(__file__).resolve().parents[2] / "docs"


def main(arguments: list[str] | None = None) -> int:
    """Run the cases, print a line each, write the page."""
    options = _options(arguments)
    names = options.only or (SMALL if options.small else [candidate.name for candidate in CASES])
    answers = []
    with tempfile.TemporaryDirectory(prefix="misuse_") as scratch:
        for name in names:
            folder = (options.keep or Path(scratch)) / name
            answers.append(Answer.of(case(name), run_case(case(name), folder), folder))
            print(table_line(answers[-1]), flush=True)
            if options.only:
                print("\n".join(f"    {sentence}" for sentence in (*answers[-1].lacks, *answers[-1].said)))
    wrong = [answer for answer in answers if answer.lacks]
    green = sum(answer.green for answer in answers)
    print(f"{len(answers) - len(wrong)} of {len(answers)} right; {green} falsely green")
    if options.out or not (options.only or options.small):
        print("written: " + ", ".join(str(path) for path in make_page(answers, options.out or DOCS)))
    return 1 if wrong else 0


def _options(arguments: list[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="Ordinary mistakes through the command, and what is said of each.")
    parser.add_argument("--small", action="store_true", help="one case or two of each kind; no page")
    parser.add_argument("--only", action="append", metavar="NAME", help="this case (may be given again); no page")
    parser.add_argument("--out", type=Path, metavar="DIR", help="folder of misuse.md and misuse.json; default docs")
    parser.add_argument("--keep", type=Path, metavar="DIR", help="keep the campaigns and their run folders there")
    return parser.parse_args(arguments)
