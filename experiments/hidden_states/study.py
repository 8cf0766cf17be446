"""Are hidden oscillators found, are they right, and how often is one found where there is none?

    python -m experiments.hidden_states.study calibrate   # null campaigns behind the critical value
    python -m experiments.hidden_states.study planted     # 20 seeds a truth and noise
    python -m experiments.hidden_states.study nulls       # 300 campaigns without one, other seeds
    python -m experiments.hidden_states.study page        # docs/hidden_states.md from the three tables

Tables: calibration.csv, planted.csv, nulls.csv, a row a campaign, in this folder. ``--first``, ``--count`` and
``--out`` run a slice elsewhere.

Belongs here: running campaigns and writing rows. Does not belong here: campaigns (campaigns.py), the page (page.py).
"""

from __future__ import annotations

import argparse
import csv
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from experiments.hidden_states.campaigns import PLANTED, STIFFNESS_N_PER_M, Campaign, null, planted
from experiments.recovery.releases import NOISE
from undertow.comparison.hidden_fit import HiddenFit, discover_hidden
from undertow.comparison.hidden_search import CRITICAL_T
from undertow.conditioning.condition import condition

FOLDER = Path(__file__).resolve().parent
SEEDS = 20
NULL_CAMPAIGNS = 300
CALIBRATION_CAMPAIGNS = 48
CALIBRATION_FIRST_SEED = 10_000
"""Seeds of the campaigns that set the critical value; those of the count of false alarms start at 0."""

HEADER = (
    "kind", "noise", "seed", "found", "largest_t", "evidence", "w_rad_per_s", "w_stderr", "mass_kg", "mass_stderr",
    "zeta", "zeta_stderr", "modes", "backed", "outcome",
)  # fmt: skip


@dataclass(frozen=True)
class Row:
    """One campaign: how many were found, the largest statistic of any sound set (0: none), and the fitted numbers."""

    kind: str
    noise: str
    seed: int
    found: int
    largest_t: float
    evidence: float
    w: tuple[tuple[float, float], ...]
    mass: tuple[tuple[float, float], ...]
    zeta: tuple[tuple[float, float], ...]
    modes: int
    backed: bool
    outcome: str

    def cells(self) -> list[str]:
        """The row as text; several oscillators in one cell, apart by a space."""
        numbers = []
        for pairs in (self.w, self.mass, self.zeta):
            numbers += [" ".join(f"{pair[i]:.5g}" for pair in pairs) for i in (0, 1)]
        head = [self.kind, self.noise, str(self.seed), str(self.found), f"{self.largest_t:.2f}", f"{self.evidence:.1f}"]
        return [*head, *numbers, str(self.modes), str(int(self.backed)), self.outcome]


def identify(campaign: Campaign, critical_t: float = CRITICAL_T) -> Row:
    """Condition, search and fit one campaign, as a user would with k known."""
    motions = [condition(recording) for recording in campaign.recordings]
    return as_row(campaign, discover_hidden(motions, critical_t=critical_t))


def as_row(campaign: Campaign, fit: HiddenFit) -> Row:
    """The fit's numbers; oscillators by rising frequency."""
    order = sorted(range(fit.count), key=lambda i: fit.frequencies[i].value)
    masses = fit.masses(STIFFNESS_N_PER_M)
    sound = [step for step in fit.search.steps if step.sound]
    best = max(sound, key=lambda step: step.weakest_t, default=None)

    def pairs(estimates: Iterable[object]) -> tuple[tuple[float, float], ...]:
        listed = list(estimates)
        return tuple((listed[i].value, listed[i].stderr) for i in order)  # type: ignore[attr-defined]

    return Row(
        campaign.kind, campaign.noise, campaign.seed, fit.count,
        best.weakest_t if best else 0.0, best.evidence if best else 0.0,
        pairs(fit.frequencies), pairs(masses), pairs(fit.dampings), len(fit.modes.modes), fit.backed, fit.outcome,
    )  # fmt: skip


def planted_campaigns(first: int, count: int) -> Iterator[Campaign]:
    """Every truth and noise, ``count`` seeds from ``first`` on."""
    for seed in range(first, first + count):
        for kind in PLANTED:
            for noise in NOISE:
                yield planted(kind, noise, seed)


def null_campaigns(first: int, count: int) -> Iterator[Campaign]:
    """``count`` campaigns without hidden oscillator, seeds from ``first`` on."""
    for seed in range(first, first + count):
        yield null(seed)


def write(rows: Iterable[Row], path: Path) -> None:
    """A line a campaign, written as they come."""
    with path.open("w", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(HEADER)
        for row in rows:
            writer.writerow(row.cells())
            stream.flush()


def main(arguments: list[str] | None = None) -> int:
    """Run one part of the study."""
    parser = argparse.ArgumentParser(description="Hidden oscillators: found, right, and false alarms.")
    parser.add_argument("part", choices=("calibrate", "planted", "nulls", "page"))
    parser.add_argument("--first", type=int)
    parser.add_argument("--count", type=int)
    parser.add_argument("--out", type=Path, default=FOLDER)
    options = parser.parse_args(arguments)
    if options.part == "page":
        from experiments.hidden_states.page import write_page

        write_page(options.out)
        return 0
    if options.part == "planted":
        campaigns = planted_campaigns(options.first or 0, options.count or SEEDS)
        name = "planted.csv"
    else:
        calibrate = options.part == "calibrate"
        first = CALIBRATION_FIRST_SEED if calibrate else 0
        count = options.count or (CALIBRATION_CAMPAIGNS if calibrate else NULL_CAMPAIGNS)
        campaigns = null_campaigns(first if options.first is None else options.first, count)
        name = "calibration.csv" if calibrate else "nulls.csv"
    critical = float("inf") if options.part == "calibrate" else CRITICAL_T
    write((identify(campaign, critical) for campaign in campaigns), options.out / name)
    return 0


if __name__ == "__main__":
    sys.exit(main())
