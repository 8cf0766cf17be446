"""Are hidden oscillators found, are they right, and how often is something named that is not there?

    python -m experiments hidden_states.study planted     # 8 seeds a truth and noise
    python -m experiments hidden_states.study nulls       # 120 campaigns without an oscillator
    python -m experiments hidden_states.study page        # docs/hidden_states.md from both tables and real.json

Tables: planted.csv, nulls.csv, a row a campaign, in this folder. ``--first``, ``--count`` and ``--out`` run a slice
elsewhere. Every campaign is judged by `undertow.diagnose`, the search of `undertow run`.

Belongs here: running campaigns and writing rows. Does not belong here: campaigns (campaigns.py), the page (page.py).
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator, Mapping
from pathlib import Path

import undertow
from experiments.files import write_rows
from experiments.hidden_states.campaigns import PLANTED, STIFFNESS_N_PER_M, Campaign, null, planted
from experiments.recovery.releases import NOISE
from undertow.quantities import Estimate

FOLDER = Path(__file__).resolve().parent
FIRST_SEED = 21_000
"""Seeds that nobody had looked at: 20000 to 20119 were, at an earlier revision."""

SEEDS = 8
NULL_CAMPAIGNS = 120
NO_SCATTER = {"k": 0.0, "c": 0.0, "mu": 0.0}
"""How much k, c and mu differ from trial to trial: not at all here, which two releases could not show."""

OSCILLATOR, RELAXATION = "hidden_resonator", "relaxation"
NUMBERS = {
    "w_rad_per_s": (OSCILLATOR, "natural_frequency_rad_per_s"),
    "mass_kg": (OSCILLATOR, "mass_kg"),
    "zeta": (OSCILLATOR, "damping_ratio"),
    "k_r_N_per_m": (RELAXATION, "stiffness_N_per_m"),
    "tau_s": (RELAXATION, "time_s"),
}
"""Columns with a value and a standard error each, oscillators by rising frequency: law and parameter."""

HEADER = (
    "kind", "noise", "seed", "status", "named", "rivals",
    *(f"{name}{end}" for name in NUMBERS for end in ("", "_stderr")),
    "true_k_r_N_per_m", "true_tau_s", "error", "error_repaired", "allowed", "cpu_s",
)  # fmt: skip

IN_MINUTES = "nulls --count 2 --out {}"
Row = dict[str, str]


def identify(campaign: Campaign) -> Row:
    """One campaign as a user would judge it who knows k and that trials repeat exactly, beside what is true."""
    started = time.process_time()
    group = undertow.diagnose(
        list(campaign.recordings), scatter=NO_SCATTER, stiffness_N_per_m=STIFFNESS_N_PER_M
    )[0]  # fmt: skip
    spent = time.process_time() - started
    k_r, tau = campaign.truth.maxwell
    verdict = group.verdict
    return {
        "kind": campaign.kind, "noise": campaign.noise, "seed": str(campaign.seed),
        "status": group.status, "named": "+".join(group.names),
        "rivals": "; ".join("+".join(names) for names in verdict.alternatives),
        **cells(group.estimates),
        "true_k_r_N_per_m": f"{k_r:.5g}" if k_r else "", "true_tau_s": f"{tau:.5g}" if k_r else "",
        "error": f"{verdict.baseline.nrmse:.4g}", "error_repaired": f"{group.error_after:.4g}",
        "allowed": f"{verdict.repeatability_nrmse:.4g}", "cpu_s": f"{spent:.1f}",
    }  # fmt: skip


def cells(estimates: Mapping[str, Estimate]) -> Row:
    """Values and standard errors of hidden states as text; several in one cell, apart by a space.

    >>> one = {"hidden_resonator.mass_kg": Estimate(60.0, 2.0, "kg", ""),
    ...        "hidden_resonator.natural_frequency_rad_per_s": Estimate(9.6, 0.01, "rad/s", "")}
    >>> {name: text for name, text in cells(one).items() if text}
    {'w_rad_per_s': '9.6', 'w_rad_per_s_stderr': '0.01', 'mass_kg': '60', 'mass_kg_stderr': '2'}
    """
    out = {}
    for column, (law, parameter) in NUMBERS.items():
        found = [estimates.get(f"{one}.{parameter}") for one in _by_frequency(law, estimates)]
        known = [one for one in found if one is not None]
        out[column] = " ".join(f"{one.value:.6g}" for one in known)
        out[f"{column}_stderr"] = " ".join(f"{one.stderr:.3g}" for one in known)
    return out


def _by_frequency(law: str, estimates: Mapping[str, Estimate]) -> list[str]:
    """A law's places in an equation ("law", "law#2"), the slowest first."""
    places = dict.fromkeys(name.split(".")[0] for name in estimates if name.split(".")[0].split("#")[0] == law)
    rate = {one: estimates.get(f"{one}.natural_frequency_rad_per_s") for one in places}
    return sorted(places, key=lambda one: rate[one].value if rate[one] is not None else 0.0)  # type: ignore[union-attr]


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


def main(arguments: list[str] | None = None) -> int:
    """Run one part of the study."""
    parser = argparse.ArgumentParser(description="Hidden oscillators: found, right, and false positives.")
    parser.add_argument("part", choices=("planted", "nulls", "page"))
    parser.add_argument("--first", type=int, default=FIRST_SEED)
    parser.add_argument("--count", type=int)
    parser.add_argument("--out", type=Path, default=FOLDER)
    options = parser.parse_args(arguments)
    if options.part == "page":
        from experiments.hidden_states.page import write_page

        write_page(options.out)
        return 0
    default = SEEDS if options.part == "planted" else NULL_CAMPAIGNS
    made = planted_campaigns if options.part == "planted" else null_campaigns
    campaigns = made(options.first, default if options.count is None else options.count)
    write_rows(options.out / f"{options.part}.csv", HEADER, (identify(campaign) for campaign in campaigns))
    return 0
