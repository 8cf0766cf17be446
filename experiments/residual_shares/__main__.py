"""Shares of the residual force where it is known what is missing: writes docs/residual_shares.md.

    python -m experiments residual_shares [--run DIR]...

Every DIR is a finished run folder whose mismatch.csv is tabled too, e.g. of configs/flume.yaml.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from experiments.residual_shares.planted import PLANTED, shares
from undertow.discrepancy.shares import Shares

ROOT = Path(__file__).resolve().parents[2]
SEEDS = 10
KINDS = ("static", "memory", "clock")

HEAD = """\
# What kind of force is left over

`mismatch.csv` shares the residual force of every trial out: `static_share` (one function of x and v, learned on the
other trials), `clock_share` (of what that leaves, a steady oscillation whose phase is not tied to the release),
`memory_share` (what responses of hidden states to the motion explain beyond both). The equation's free coefficients are
refitted beside every law; a share is empty where a group has fewer than three trials, where their releases lie within a
factor of 1.2, and where the residual force is noise. How: `undertow.discrepancy.shares`.

    python -m experiments residual_shares
"""

TEXT = """\
A resonator's mean push over a cycle is a damping or a stiffness, and short decays show little else: a part of it is
static by right, the more the shorter the motion. Memory that forgets within a cycle (relaxation, hysteresis) is nearly
a function of x and v for the same reason. What the equation's own free drag can take up (most of a linear damping, of
Stribeck's friction) is not counted, and scatter of k, c and mu from trial to trial is no law: both leave less than one
in the sum. Waves that break (practice-four) are no linear memory: what the bank does not reach is in no share.
"""


def planted_table() -> Iterable[str]:
    """Medians over seeds and trials for every planted truth, and how many trials had shares at all."""
    yield "| planted | static | memory | clock | trials with shares |"
    yield "| --- | --- | --- | --- | --- |"
    for name in PLANTED:
        found = [one for seed in range(SEEDS) for one in shares(name, seed)]
        yield _row(name, found)


def run_table(folder: Path) -> Iterable[str]:
    """Medians over the trials of every group of a finished run."""
    table = pd.read_csv(folder / "mismatch.csv")
    columns = [f"{kind}_share" for kind in KINDS]
    keys = [c for c in ("spring", "water_depth_m") if c in table]
    yield "| group | static | memory | clock | trials with shares |"
    yield "| --- | --- | --- | --- | --- |"
    for key, group in table.groupby(keys):
        found = [Shares(*row) for row in group[columns].to_numpy(float)]
        yield _row(" ".join(str(k) for k in key), found)


def _row(name: str, found: Sequence[Shares]) -> str:
    defined = [one for one in found if math.isfinite(one.static)]
    if not defined:
        return f"| {name} | - | - | - | 0 of {len(found)} |"
    middle = " | ".join(f"{np.median([getattr(one, kind) for one in defined]):.2f}" for kind in KINDS)
    return f"| {name} | {middle} | {len(defined)} of {len(found)} |"


def main() -> None:
    """The page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--run", type=Path, action="append", default=[], help="a finished run folder")
    folders = parser.parse_args().run
    lines = [HEAD, f"## Planted ({SEEDS} campaigns of four trials each, medians over all trials)", ""]
    lines += planted_table()
    for folder in folders:
        lines += ["", f"## {folder.name} (medians over a group's trials)", "", *run_table(folder)]
    text = "\n".join([*lines, "", TEXT])
    (ROOT / "docs" / "residual_shares.md").write_text(text, encoding="utf-8")
    print(text)
