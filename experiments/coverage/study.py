"""Do nominal 90 % intervals hold the truth in 90 of 100 campaigns? Few trials, coloured noise, drift, clocks, scatter.

    python -m experiments coverage.study            # 402 campaigns, 6 minutes on one core; writes coverage.csv

Each campaign goes the way that `undertow run` goes: conditioned, k, c, mu from its dry trials, then the group in water
by output error; what is counted is value +- 1.645 stderr, as levels.csv has them. Belongs here: that count. Does not
belong here: how a campaign is made (campaigns.py).
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np

from experiments.coverage.campaigns import SCATTERS, Campaign, Truth, make_campaign
from experiments.eq15_campaign import tables
from experiments.files import read_rows, write_rows
from undertow.conditioning.condition import condition
from undertow.conditioning.motion import Motion
from undertow.likelihood.fit import Specimen
from undertow.likelihood.problem import TrialOptions
from undertow.methods.baseline import fit_group, group_model, terms_by_name
from undertow.methods.dry import dry_fits, pooled_scatter, structural_terms, structure_from
from undertow.quantities import Estimate
from undertow.uncertainty.repeats import mean_of_trials

IN_MINUTES = "--campaigns 1 --out {}/coverage.csv"
RESULTS = Path(__file__).with_name("coverage.csv")
TERMS = terms_by_name(("stiffness", "viscous_damping", "coulomb_friction", "added_mass", "quadratic_drag"))
COUNTS = (3, 4, 6)
CAMPAIGNS = 67
"""Campaigns a scatter and number of trials: 402 in all; a coverage of 90 % over 402 has a standard error of 1.5 %."""

FIRST_SEED = 2000
"""Seeds of the committed results: the errors were worked out on other ones."""

NORMAL_90 = 1.6449
DRY = ("k_N_per_m", "c_Ns_per_m", "mu")
WET = ("added_mass_kg", "drag_coefficient")
HEADER = ("scatter", "trials", "seed", "fit", "parameter", "value", "stderr", "truth", "inside")


@dataclass(frozen=True)
class Entry:
    """One interval of one campaign: the fit it comes from, its parameter, value, standard error, and the truth."""

    scatter: str
    trials: int
    seed: int
    fit: str
    parameter: str
    value: float
    stderr: float
    truth: float

    @property
    def inside(self) -> bool:
        """Whether the nominal 90 % interval holds the truth."""
        return abs(self.value - self.truth) <= NORMAL_90 * self.stderr


def intervals(truth: Truth, dry: Sequence[Motion], wet: Sequence[Motion]) -> Iterator[tuple[str, str, Estimate]]:
    """Every estimate of a campaign with the fit it comes from: dry means, and the group in water fitted two ways.

    "baseline" holds the dry means and fits the group's trials together; "output_error" lets every trial have its own
    k, c, mu: the rows of these names in levels.csv.
    """
    air = Specimen(mass_kg=tables.STRUCTURE_MASS_KG)
    fits = dry_fits(dry, structural_terms(TERMS), air, TrialOptions())
    for name in DRY:
        yield "dry", name, mean_of_trials([fit.estimates[name] for fit in fits.values()], "", "dry trials")
    structure = structure_from(fits, pooled_scatter([fits]))
    water = Specimen(
        mass_kg=tables.STRUCTURE_MASS_KG, area_m2=tables.REFERENCE_AREA_M2,
        submerged_volume_m3=tables.submerged_volume(truth.water_depth_m),
    )  # fmt: skip
    model = group_model(TERMS, wet, water, structure, dry=False, anchored=True)
    options = TrialOptions(rest_offset_std=structure.mu.value * water.normal_force_N / structure.k.value)
    for label, scattering in (("baseline", "trials"), ("output_error", "trials and means")):
        fit = fit_group(model, wet, options, scattering)  # type: ignore[arg-type]
        for name in WET:
            yield label, name, fit.estimates[name]


def measure(campaign: Campaign, scatter: str, trials: int, seed: int) -> list[Entry]:
    """All intervals of one campaign beside its truth."""
    motions = [[condition(recording) for recording in group] for group in (campaign.dry, campaign.wet)]
    return [
        Entry(scatter, trials, seed, fit, name, e.value, e.total_stderr, campaign.truth.value(name))
        for fit, name, e in intervals(campaign.truth, *motions)
    ]


def study(campaigns: int, first: int = 0) -> Iterator[Entry]:
    """Every interval of ``campaigns`` campaigns a scatter and number of trials, from seed ``first`` on, in turn."""
    for seed, scatter, trials in product(range(first, first + campaigns), SCATTERS, COUNTS):
        yield from measure(make_campaign(scatter, trials, seed), scatter, trials, seed)


@dataclass(frozen=True)
class Coverage:
    """Share of intervals that hold the truth, with its standard error, and the median half width over the rms error."""

    entries: int
    share: float
    stderr: float
    width: float


def coverage(entries: Iterable[Entry]) -> Coverage:
    """What a set of intervals covers."""
    rows = list(entries)
    inside = np.array([e.inside for e in rows])
    share = float(np.mean(inside))
    relative = np.array([e.stderr / abs(e.truth) for e in rows if e.truth != 0.0])
    width = float(np.median(relative)) if relative.size else float("nan")
    return Coverage(len(rows), share, float(np.sqrt(share * (1.0 - share) / len(rows))), width)


def summary(entries: Sequence[Entry]) -> list[str]:
    """Coverage of every fit and parameter, over all campaigns and by number of trials and scatter."""
    head = "| fit | parameter | all | 3 trials | 4 trials | 6 trials | Tables 1, 2 | practice | median error, % |"
    lines = [head, "|---" * 9 + "|"]
    for fit, name in dict.fromkeys((e.fit, e.parameter) for e in entries):
        own = [e for e in entries if (e.fit, e.parameter) == (fit, name)]
        every = coverage(own)
        parts = [[e for e in own if e.trials == n] for n in COUNTS]
        parts += [[e for e in own if e.scatter == s] for s in SCATTERS]
        shares = " | ".join(f"{100.0 * coverage(p).share:.0f}" for p in parts)
        said = f"{100.0 * every.share:.1f} ± {100.0 * every.stderr:.1f}"
        lines.append(f"| {fit.replace('_', ' ')} | {name} | {said} | {shares} | {100.0 * every.width:.2g} |")
    return lines


def cells(entry: Entry) -> list[str]:
    """An interval's row."""
    numbers = [f"{number:.6g}" for number in (entry.value, entry.stderr, entry.truth)]
    said = (entry.scatter, str(entry.trials), str(entry.seed), entry.fit, entry.parameter)
    return [*said, *numbers, str(entry.inside).lower()]


def read(path: Path) -> list[Entry]:
    """The intervals of a table of `cells`."""
    numbers = {"trials": int, "seed": int, "value": float, "stderr": float, "truth": float}
    return [Entry(**{name: numbers.get(name, str)(row[name]) for name in HEADER[:-1]}) for row in read_rows(path)]


def main(arguments: list[str] | None = None) -> int:
    """Run the study, write its rows and print the table of docs/uncertainty_measured.md."""
    parser = argparse.ArgumentParser(description="Coverage of nominal 90 % intervals on synthetic campaigns.")
    parser.add_argument("--campaigns", type=int, default=CAMPAIGNS, help="campaigns a scatter and number of trials")
    parser.add_argument("--first", type=int, default=FIRST_SEED, help="first seed")
    parser.add_argument("--out", type=Path, default=RESULTS, help="where the rows go")
    options = parser.parse_args(arguments)
    write_rows(options.out, HEADER, map(cells, study(options.campaigns, options.first)))
    print("\n".join(summary(read(options.out))))
    return 0
