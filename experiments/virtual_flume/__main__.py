"""One command that remakes everything: `python -m experiments virtual_flume` from the repository's root.

`--only` with data, answer, studies or pictures remakes a part.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path

from experiments.virtual_flume import answer, campaign, section

ROOT = Path(__file__).resolve().parents[2]
DATA = ROOT / "data" / "virtual_flume"
RESULTS = Path(__file__).resolve().parent / "results"
PICTURES = ROOT / "docs" / "pictures" / "virtual_flume"


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)


def make_data() -> None:
    """Recordings, index and setup."""
    for trial in campaign.write(DATA):
        _say(f"{trial.file}  {trial.spring:5s}  {trial.water_depth_m:.2f} m  {trial.x0_m:.4f} m")


def make_answer() -> None:
    """The flume's own answer and every trial's truth."""
    levels = [answer.level_answer(depth) for depth in section.WET_DEPTHS_M]
    (DATA / "truth.json").write_text(json.dumps(answer.truth(levels, campaign.trials()), indent=1) + "\n")


def make_studies() -> None:
    """Tables of convergence and of the checks, as markdown."""
    from experiments.virtual_flume import studies

    studies.write(RESULTS, _say)


def make_pictures() -> None:
    """The page's pictures."""
    from experiments.virtual_flume import figures

    figures.write(PICTURES, _say)


PARTS = {"data": make_data, "answer": make_answer, "studies": make_studies, "pictures": make_pictures}


def main(arguments: list[str] | None = None) -> int:
    """Run the parts asked for; seconds go to standard error."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", choices=sorted(PARTS), help="remake one part")
    chosen = parser.parse_args(arguments).only
    for name, make in PARTS.items():
        if chosen in (None, name):
            start = time.perf_counter()
            make()
            _say(f"{name}: {time.perf_counter() - start:.0f} s")
    return 0
