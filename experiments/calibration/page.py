"""The page about the probability that stands beside a verdict: its counts, families of truths left out, and
verdicts on a seed that nobody had looked at.

Belongs here: the one walk over rows and truths, those two tests, page and figure. Does not belong here: the file
of the counts (__main__.py), fits and bands (blind_challenge/estimates.py).
"""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from experiments.blind_challenge import estimates
from experiments.blind_challenge.figures import reliability_axes
from experiments.blind_challenge.judge import GroupResult, holds, judge_case, statement_right
from experiments.blind_challenge.page import number, table
from experiments.blind_challenge.run_cases import read_rows
from undertow.comparison.limits import FAR_ABOVE_NOISE
from undertow.discrepancy.calibration import BEYOND, LEANS, NEARLY, NEARLY_NOISE, Record, conditions_of, kind_of

PICTURE = "pictures/calibration.svg"

TENTHS = 10
"""Parts of the campaigns with nothing missing, each of them a family of truths."""

PARTS = 5
"""Parts into which families are dealt, one left out at a time."""


@dataclass(frozen=True)
class Said:
    """One verdict on a group of known truth: its campaign's families of truths, its kind, whether it holds, whether its
    names are complete and exact, whether it speaks for its campaign (one group of each, by the case's number: the
    probability is that of any group's verdict, and the one with the strongest effect is easier to get wrong)."""

    families: frozenset[str]
    kind: str
    right: bool
    exact: bool
    speaks: bool


def verdicts_of(folder: Path) -> list[Said]:
    """All verdicts of a folder of sealed campaigns that say something; those that data cannot tell are left out."""
    found = []
    for row in (row for row in read_rows(folder / "rows.jsonl") if row.get("verdict")):
        truth = json.loads((folder / "sealed" / f"{row['case']}.json").read_text(encoding="utf-8"))
        if truth["kind"] == "cannot":
            continue
        case = judge_case(row, truth)
        families = frozenset(str(e["key"]) for e in truth["measures"]["effects"])
        families |= frozenset() if families else {f"nothing, {int(str(row['case']).lstrip('c')) % TENTHS}"}
        said = [one for g in case.groups if (one := _said(g, case.kind, families)) is not None]
        if said:
            chosen = int(str(row["case"]).lstrip("c")) % len(said)
            said[chosen] = replace(said[chosen], speaks=True)
        found += said
    return found


def _said(group: GroupResult, kind: str, families: frozenset[str]) -> Said | None:
    right = holds(group)
    if right is None:
        return None
    name = kind_of(str(group.said["status"]), list(group.said["verdict"]), conditions_of(group.said["decision"]))
    exact = bool(statement_right(group, kind))
    return Said(families, name, right, exact, speaks=False)


def left_out(verdicts: Sequence[Said]) -> list[tuple[float, bool]]:
    """Probability and truth of the verdict that speaks for each campaign, counted without all campaigns that share a
    family of truths with it or with its part. Families are dealt into `PARTS`, so that truths of all kinds are held
    against the same counts: with one left out at a time those of missed effects would lack what they alone show."""
    families = sorted({family for v in verdicts for family in v.families})
    found = []
    for part in range(PARTS):
        here = set(families[part::PARTS])
        others = [v for v in verdicts if not v.families & here]
        for one in (v for v in verdicts if v.speaks and min(v.families) in here):
            alike = [v.right for v in others if v.kind == one.kind and not v.families & one.families]
            chance = Record(one.kind, len(alike), sum(alike)).probability
            if math.isfinite(chance):
                found.append((chance, one.right))
    return found


def by_counts(verdicts: Sequence[Said], records: Mapping[str, Record], exact: bool = False) -> list[tuple[float, bool]]:
    """The probability that the counts give the verdict that speaks for each campaign, and whether it holds (``exact``:
    whether its names are complete and exact)."""
    known = (v for v in verdicts if v.speaks and v.kind in records)
    return [(records[v.kind].probability, v.exact if exact else v.right) for v in known]


def measured(pairs: Sequence[tuple[float, bool]]) -> dict[str, Any]:
    """Slope, intercept and scores of probabilities beside truths, and their reliability curve."""
    chances, right = [c for c, _ in pairs], [r for _, r in pairs]
    fit, curve = estimates.calibration(chances, right), estimates.reliability(chances, right)
    return {"fit": fit, "curve": curve, "by_chance": estimates.by_chance(chances)}


def figure(first: Mapping[str, Any], fresh: Mapping[str, Any], exact: Mapping[str, Any]) -> Figure:
    """Both reliability curves beside each other."""
    made = Figure(figsize=(10.5, 4.2), layout="constrained")
    left, right = made.subplots(1, 2)
    reliability_axes(left, first["curve"], [])
    left.set_title("families of truths left out")
    reliability_axes(right, fresh["curve"], exact["curve"])
    right.set_title("fresh seeds")
    return made


def _test(found: Mapping[str, Any]) -> str:
    fit = found["fit"]
    if fit is None:
        return "Too few verdicts, or none that is wrong: no slope.\n"
    chance = "" if found["by_chance"] is None else (
        " A forecaster whose probabilities are true has, in 90 % of such samples, a slope of {:.2f} to {:.2f} and an "
        "intercept of {:+.2f} to {:+.2f}."
    ).format(*found["by_chance"][0], *found["by_chance"][1])  # fmt: skip
    rows = [
        (f"{b['n']:.0f}", number(b["confidence"]), number(b["right"]), f"{number(b['low'])} to {number(b['high'])}")
        for b in found["curve"]
    ]
    return (
        f"{fit['n']:.0f} campaigns, the verdict of one group each, chosen by the case's number. "
        f"Slope {fit['slope']:.2f} (0.8 to 1.25 asked), intercept {fit['intercept']:+.2f} (within 0.3), log score "
        f"{fit['log_score']:.3f}; a calibrated forecaster with these probabilities has "
        f"{fit['calibrated_log_score']:.3f}.{chance}\n\n"
        + table(["verdicts", "mean probability", "share that holds", "90 % band"], rows)
    )


def _by_kind(verdicts: Sequence[Said], records: Mapping[str, Record]) -> str:
    said, right = Counter(v.kind for v in verdicts), Counter(v.kind for v in verdicts if v.right)
    rows = []
    for kind in sorted(said):
        low, high = estimates.interval(right[kind], said[kind])
        chance = f"{records[kind].probability:.2f}" if kind in records else ""
        rows.append((kind, chance, f"{right[kind]} of {said[kind]}", f"{low:.2f} to {high:.2f}"))
    return table(["verdict", "probability", "held", "90 % interval of that share"], rows)


def page(
    counts: Mapping[str, Any], calibration: Sequence[Said], known: str, fresh: Sequence[Said], unseen: str
) -> tuple[str, Figure]:
    """The page in Markdown and its figure; ``known`` and ``unseen`` say what the verdicts before them are of."""
    records = {r["kind"]: Record(r["kind"], r["said"], r["right"]) for r in counts["records"]}
    first, last, exact = (
        measured(pairs)
        for pairs in (left_out(calibration), by_counts(fresh, records), by_counts(fresh, records, exact=True))
    )
    rows = [(r.kind, r.said, r.right, f"{r.probability:.2f}") for r in records.values()]
    seeds = ", ".join(str(seed) for seed in counts["seeds"])
    parts = [
        "# The probability beside a verdict\n",
        "After this page you know what the percentage beside a verdict means, and how it was tested.\n",
        "It is how often verdicts of that kind held on sealed campaigns of known truth (docs/blind_challenge.md), not "
        "a posterior among the models that were fitted: that stands beside it as `posterior`. A verdict holds where "
        "nothing as large as what counts is missing, something is, or every name is of an effect that is there or "
        "describes it; a further effect without a name does not count against it. Of s verdicts, r of which held, the "
        "next one holds with (r + 1/2) / (s + 1) (Jeffreys). `explained` is of four kinds: several effects, or "
        f"one that leaves at most {NEARLY_NOISE} times the noise (in variance), at most {FAR_ABOVE_NOISE} times, or "
        "more; `unknown` of three: none, one or several names stand beside it. `nothing_missing` is of five kinds: a "
        f"level that nearly stands out (p below {NEARLY}), one that leans to it (below {LEANS}) or does not, each seen "
        "sharply (no more than a tenth of what counts can hide) or not; something small without a name of two: "
        f"beyond every replica (p below {BEYOND}) or not.\n",
        "    python -m experiments calibration runs/a runs/b         # the counts; --add: to those that stand\n"
        "    python -m experiments calibration runs/a runs/b --fresh runs/c runs/d --page docs/calibration.md\n",
        "## Counts\n", f"{counts['campaigns']} campaigns of seeds {seeds}.\n",
        table(["verdict", "said", "held", "probability"], rows),
        "## Families of truths left out\n",
        f"{known}; their families of truths dealt into {PARTS} parts (a tenth of the "
        "campaigns with nothing missing counts as such a family); each part has the counts of campaigns that share no "
        "effect with it.\n", _test(first),
        f"## Fresh seeds\n\n{unseen}.\n", _test(last), "By kind, all groups:\n", _by_kind(fresh, records),
        "Names complete and exact, nothing missing at all (what the number does not promise):\n", _test(exact),
        f"![Share of verdicts that hold against the probability beside them]({PICTURE})\n",
    ]  # fmt: skip
    return "\n".join(parts), figure(first, last, exact)
