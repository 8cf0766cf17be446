"""Whether `detectable` is true: effects planted at 1.5 times and at half of the size that a campaign with nothing in it
says it would have seen, and how many of them are.

    python -m experiments names.seen --seeds 10 --first 910000 --jobs 2

A campaign of a seed is judged with nothing hidden in it; of every suspect each group that it acts on then says the
smallest effect that 90 % of its replicas would show. The smallest of these is what the campaign would have seen: half
of it is at most half of what any group says. The same campaign is made again with that law in it, 1.5 times and half as
large, with noise and scatter of its own (what was said is said of a repetition: of the same noise the place that shows
most is the one where it happens to push), and judged; it is seen where any of those groups has a p-value at which a
campaign of so many groups accuses.
Rows go to results/seen.csv, one a campaign.

Belongs here: that study. Does not belong here: campaigns (scenes.py), what a verdict is worth (verdicts.py).
"""

from __future__ import annotations

import argparse
import math
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from joblib import Parallel, delayed

from experiments.files import read_rows, table
from experiments.names.effects import find
from experiments.names.folder import View, write
from experiments.names.rows import append
from experiments.names.scenes import Campaign
from experiments.names.studies import HIDDEN_IN, plan_of
from experiments.revision import revision
from undertow.campaign.config import load
from undertow.campaign.run import run
from undertow.comparison.null_test import limit
from undertow.discrepancy.verdict import Verdict
from undertow.errors import UndertowError

IN_MINUTES = "--seeds 1 --out {}/seen.csv"
SLOTS = {
    "linear_damping": "c", "cubic_damping": "c3", "cubic_stiffness": "k3", "quintic_stiffness": "k5",
    "asymmetric_stiffness": "k2", "variable_normal_force": "n", "hidden_resonator": "hm", "relaxation": "rk",
    "delayed_echo": "ge", "external_forcing": "A",
}  # fmt: skip
"""The number of the campaign's equation that a suspect's first number is."""

INSIDE = {
    "hidden_resonator": {"natural_frequency_rad_per_s": "hw", "damping_ratio": "hz"}, "relaxation": {"time_s": "rt"},
    "delayed_echo": {"delay_s": "te"}, "external_forcing": {"frequency_rad_per_s": "om"},
}  # fmt: skip
"""The numbers of the campaign's equation that a suspect's inner numbers are: what is planted is what was said."""

DOSES = (0.5, 1.5)
RESULTS = Path(__file__).resolve().parent / "results" / "seen.csv"

Row = dict[str, str | float | int]


def verdicts_of(campaign: Campaign, view: View) -> list[Verdict]:
    """What is said of every group of a campaign."""
    with tempfile.TemporaryDirectory() as folder:
        return [g.verdict for g in run(load(write(campaign, Path(folder), view)), jobs=1).groups]


def wet_of(campaign: Campaign, verdicts: list[Verdict]) -> list[Verdict]:
    """Those of the groups in water."""
    wet = {t.file for t in campaign.plan.trials() if t.wet}
    return [v for v in verdicts if {Path(t).stem for t in v.trials} & {Path(w).stem for w in wet}]


def size_of(campaign: Campaign, verdict: Verdict, name: str, value: float) -> float:
    """The size of an effect that makes its number so large in a group's water, on the spring where it is the largest:
    all of these grow in proportion."""
    slot, one = SLOTS[name], replace(campaign, sizes={name: 1.0})
    trials = campaign.plan.trials()
    own = {Path(t).stem for t in verdict.trials}
    wet = any(t.wet for t in trials if Path(t.file).stem in own)
    level = [t for t in trials if t.wet == wet and (wet or Path(t.file).stem in own)]
    reached = max(abs(one.numbers(t, False)[slot] - campaign.numbers(t, False).get(slot, 0.0)) for t in level)
    return value / reached


def rows_of(seed: int) -> list[Row]:
    """One seed: the campaign with nothing hidden, then with every suspect at both doses."""
    campaign = Campaign(plan_of(seed, most=HIDDEN_IN))
    view, base = View(stated=seed % 2 == 1), {"study": "seen", "seed": seed, "revision": revision()}
    out: list[Row] = []
    try:
        everywhere = verdicts_of(campaign, view)
        wet = wet_of(campaign, everywhere)
    except UndertowError as reason:
        return [base | {"failed": str(reason)[:200]}]
    for name in SLOTS:
        everywhere_too = find(name).place == "structure"
        acting = everywhere if everywhere_too else wet
        again = replace(campaign, plan=replace(campaign.plan, repetition=1))
        found = [(size_of(again, v, name, d.value), d) for v in acting for d in v.detectable if d.name == name]
        if not found:
            continue
        size, smallest = min(found, key=lambda one: one[0])
        for dose in DOSES:
            began = time.process_time()
            row = base | {"hidden": name, "strength": dose, "size": f"{dose * smallest.value:.4g}"}
            inside = {slot: smallest.at[inner] for inner, slot in INSIDE.get(name, {}).items()}
            planted = replace(again, sizes={name: dose * size}, extra=inside)
            try:
                said = verdicts_of(planted, view)
                water = wet_of(planted, said)
            except UndertowError as reason:
                out.append(row | {"failed": str(reason)[:200]})
                continue
            acted_on = said if everywhere_too else water
            least = min((v.p_value for v in acted_on), default=math.nan)
            seen = least <= limit(len(said))
            names = {n for v in water for n in v.verdict} | {n for v in water for a in v.alternatives for n in a}
            out.append(row | {
                "reached": f"{smallest.share_of_motion:.4g}", "outcome": "seen" if seen else "not seen",
                "wet": "|".join(dict.fromkeys("+".join(v.verdict) for v in water)),
                "status": "|".join(dict.fromkeys(v.status for v in water)), "rivals": "named" if name in names else "",
                "p_value": least,
                "cpu_s": round(time.process_time() - began, 1),
            })  # fmt: skip
    return out


def counted(path: Path) -> str:
    """A table: seen of all, by suspect and dose."""
    rows = [r for r in read_rows(path) if not r["failed"]]
    total = Counter((r["hidden"], float(r["strength"])) for r in rows)
    seen = Counter((r["hidden"], float(r["strength"])) for r in rows if r["outcome"] == "seen")
    lines = []
    for name in (*SLOTS, ""):
        cells = []
        for dose in DOSES:
            mine = [k for k in total if k[1] == dose and name in ("", k[0])]
            cells.append(f"{sum(seen[k] for k in mine)} of {sum(total[k] for k in mine)}")
        lines.append((name or "**all**", *cells))
    return table(("suspect", "seen at half of it", "seen at 1.5 times"), lines)


def main() -> int:
    """Run the seeds, append rows as they come, print the table."""
    parser = argparse.ArgumentParser(description="Effects at 1.5 times and half of what a null says it would see.")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--out", type=Path, default=RESULTS)
    options = parser.parse_args()
    tasks = (delayed(rows_of)(options.first + i) for i in range(options.seeds))
    done: Iterator[list[Row]] = Parallel(options.jobs, return_as="generator")(tasks)
    for many in done:
        for row in many:
            append(options.out, row)
            print(row.get("hidden"), row.get("strength"), row.get("outcome", row.get("failed")), flush=True)
    print(counted(options.out))
    return 0
