"""How the simulated tables were judged: names, classes, sizes of answers, false positives, coverage.

An answer is the set of names that are said: the verdict and its alternatives, and Eq. 15 where it is not ruled out. A
set that names more than `MOST_NAMES` says nothing and counts as wrong, whatever is in it. While Eq. 15 is not ruled out
it is the preferred one: the planted effect then counts only by its own name in a small set, never by its class.

Beside them stands an auditor who was told what no real one knows: how far the rows of these tables scatter, how often
each truth comes, and in hindsight the doubt at which to name. What it misses the tables do not say.

Belongs here: counting stored results, the page's section. Does not belong here: making tables (simulated.py).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import beta

from experiments.audit.simulated import COVERAGE_TABLES, INTERVALS, TABLES
from experiments.files import put
from undertow.audit.verdicts import ODDS

PAGE = Path(__file__).resolve().parents[2] / "docs" / "published_tables.md"
MARKS = ("<!-- simulated tables -->", "<!-- end of simulated tables -->")

FALSE_AT_MOST = 0.02
"""Share of the tables of Eq. 15 in which something may be named (false positives)."""

WANTED_COVERAGE = (0.86, 0.94)
"""Share of 90 % intervals that should hold what was planted."""

MOST_NAMES = 3
"""Names in a set that still says something: of seven to nine rivals a third."""

CLASSES = {
    "": "nothing", "linear_damping": "dissipation", "coulomb_friction": "dissipation", "drag_exponent": "dissipation",
    "hidden_resonator": "memory", "rest_offset": "set-up", "support_compliance": "set-up", "gain_error": "set-up",
}  # fmt: skip


def names_said(one: dict[str, Any]) -> list[tuple[str, ...]]:
    """The sets of names of one answer, the preferred one first; () is Eq. 15."""
    return [tuple(one["verdict"]), *(tuple(names) for names in one["alternatives"])]


def judged(one: dict[str, Any]) -> dict[str, bool]:
    """How one answer did: preferred name, preferred class, name in the set, in a small set, name or class."""
    truth, said = one["truth"], names_said(one)
    classes = {CLASSES[name] for name in said[0]} or {"nothing"}
    named = ((truth,) if truth else ()) in said or any(truth in names for names in said if truth)
    small = len(said) <= MOST_NAMES
    right_class = CLASSES[truth] in classes
    return {
        "preferred": said[0] == ((truth,) if truth else ()), "class": right_class, "named": named,
        "named_small": named and small, "right": right_class or (named and small),
        "open": bool(truth) and not said[0] and named and small,
    }  # fmt: skip


def told(results: Sequence[dict[str, Any]]) -> dict[str, int]:
    """The told auditor: planted effects found by name or class, and false positives, at the doubt that finds most of
    those that name something in no more than `FALSE_AT_MOST` of the tables where it is true."""
    audited = [one for one in results if "told_scatter" in one]
    often = Counter(one["truth"] for one in audited)
    shares = [_told_shares(one["told_scatter"], often) for one in audited]
    null = sorted(share[""] for one, share in zip(audited, shares, strict=True) if not one["truth"])
    doubt = null[int(FALSE_AT_MOST * len(null))] if null else 0.0
    said = []
    for one, share in zip(audited, shares, strict=True):
        effects = sorted((name for name in share if name), key=lambda name: -share[name])
        silent = share[""] >= doubt
        best = share[""] if silent else share[effects[0]]
        near = [] if silent and best >= 0.5 else [[name] for name in effects if share[name] * ODDS >= best]
        said.append({
            "truth": one["truth"], "verdict": [] if silent else near[0], "alternatives": near if silent else near[1:],
        })  # fmt: skip
    return {
        "right": sum(judged(one)["right"] for one in said if one["truth"]),
        "tables": sum(bool(one["truth"]) for one in said),
        "false_positives": sum(bool(one["verdict"]) for one in said if not one["truth"]),
    }


def _told_shares(evidences: dict[str, float], often: Counter[str]) -> dict[str, float]:
    """Probability of each truth ("" is Eq. 15) that comes up at all, by how often it does; 0 where it was not tried."""
    logs = {
        truth: evidences[truth or "equation 15"] + np.log(often[truth])
        for truth in often
        if (truth or "equation 15") in evidences
    }
    highest = max(logs.values())
    weights = {truth: float(np.exp(one - highest)) for truth, one in logs.items()}
    return {truth: weights.get(truth, 0.0) / sum(weights.values()) for truth in ("", *often)}


def coverage(results: Sequence[dict[str, Any]]) -> dict[str, dict[str, Any]]:
    """Tables whose 90 % interval holds what was planted, by parameter, with the 95 % range of the share."""
    found = {}
    for effect, name in INTERVALS:
        key = f"{effect}.{name}"
        those = [(one["intervals"][key], one["values"][key]) for one in results if key in one["intervals"]]
        inside, tables = sum(low <= value <= high for (_, low, high), value in those), len(those)
        low = float(beta.ppf(0.025, inside, tables - inside + 1)) if inside else 0.0
        high = float(beta.ppf(0.975, inside + 1, tables - inside)) if inside < tables else 1.0
        ranks = [one["ranks"][key] for one in results if key in one.get("ranks", {})]
        quarters = np.histogram(ranks, bins=4, range=(0.0, 1.0))[0].tolist()
        found[key] = {"tables": tables, "inside": inside, "low": low, "high": high, "quarters": quarters}
    return found


def summary(results: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Counts over the audited tables, in all and by truth; coverage over all."""
    audited = [one for one in results if "verdict" in one]
    by_truth = {}
    for truth in sorted({one["truth"] for one in audited}):
        those = [one for one in audited if one["truth"] == truth]
        by_truth[truth or "equation 15"] = _counts(those)
    null = [one for one in audited if not one["truth"]]
    return {
        "tables": len(audited), "covering": len(results) - len(audited),
        "effects": _counts([one for one in audited if one["truth"]]),
        "eq15": len(null), "false_positives": sum(bool(one["verdict"]) for one in null), "by_truth": by_truth,
        "expected": _expected(audited), "coverage": coverage(results), "told": told(results),
        "revisions": sorted({one["revision"] for one in results if "revision" in one}),
        "cpu_s": sum(one["cpu_s"] for one in results),
    }  # fmt: skip


def _expected(audited: Sequence[dict[str, Any]]) -> float:
    """Share of the tables of Eq. 15 that are false positives, by the probabilities alone."""
    kept = sum(one["equation_15"] for one in audited)
    return float(sum(one["equation_15"] for one in audited if one["verdict"]) / kept) if kept else 0.0


def _counts(those: Sequence[dict[str, Any]]) -> dict[str, Any]:
    scores = [judged(one) for one in those]
    keys = ("preferred", "class", "named", "named_small", "right", "open")
    counts: dict[str, Any] = {key: sum(score[key] for score in scores) for key in keys}
    sizes = [len(names_said(one)) for one in those]
    return {**counts, "tables": len(those), "size": float(np.median(sizes)) if sizes else 0.0}


def section(found: dict[str, Any]) -> str:
    """The section of docs/published_tables.md: counts, coverage, a table by truth."""
    one = found["effects"]
    lines = [
        f"| {truth.replace('_', ' ')} | {row['tables']} | {row['preferred']} | {row['class']} | {row['named_small']} "
        f"| {row['right']} | {row['named']} | {row['size']:g} |"
        for truth, row in found["by_truth"].items()
    ]
    head = (
        "| truth | tables | preferred | its class | in a set of three or fewer | name or class | in any set | names in "
        "the set (median) |"
    )
    return "\n".join([
        f"{found['tables']} simulated tables of the {TABLES} planned and {found['covering']} of {COVERAGE_TABLES} for "
        f"coverage alone, {found['cpu_s'] / 60.0:.0f} minutes of a core "
        f"(`python -m experiments audit.simulated run`; revision {', '.join(found['revisions']) or 'unknown'}).",
        f"With an effect planted, its name is among at most {MOST_NAMES} that are said in {one['named_small']} of "
        f"{one['tables']} tables, or its class (dissipation, memory, set-up) is the preferred one's: {one['right']} of "
        f"{one['tables']} ({100.0 * one['right'] / max(one['tables'], 1):.0f} %). It is the preferred name in "
        f"{one['preferred']}, its class the preferred one's in {one['class']}; a set has {one['size']:g} names "
        f"(median). {one['open']} of the {one['right']} stand beside an Eq. 15 that is not ruled out.",
        f"Where Eq. 15 is true there are false positives in {found['false_positives']} of {found['eq15']}; "
        f"by the audit's own probabilities in {100.0 * found['expected']:.1f} % of such tables.",
        f"An auditor who is told how far rows scatter, how often each truth comes and in hindsight at which doubt to "
        f"name finds {found['told']['right']} of {found['told']['tables']}, with {found['told']['false_positives']} of "
        f"{found['eq15']} false positives.",
        *(_covered(key, row) for key, row in found["coverage"].items()),
        _wanted(found),
        "",
        head,
        "|---|---|---|---|---|---|---|---|",
        *lines,
    ])  # fmt: skip


def _wanted(found: dict[str, Any]) -> str:
    """What was wanted, and whether it is reached."""
    one = found["effects"]
    shares = {
        "name or class in 90 %": one["right"] >= 0.9 * one["tables"],
        "at most 2 % false positives": found["false_positives"] <= FALSE_AT_MOST * found["eq15"],
    }
    for key, row in found["coverage"].items():
        reached = WANTED_COVERAGE[0] <= row["inside"] / max(row["tables"], 1) <= WANTED_COVERAGE[1]
        shares[f"coverage of {key.partition('.')[0].replace('_', ' ')} of 86 to 94 %"] = reached
    sofar = "" if found["tables"] == TABLES else " (so far)"
    said = [f"{text} ({'reached' if good else 'missed'})" for text, good in shares.items()]
    return f"Wanted{sofar}: {'; '.join(said)}."


def _covered(key: str, row: dict[str, Any]) -> str:
    effect = key.partition(".")[0].replace("_", " ")
    share = 100.0 * row["inside"] / max(row["tables"], 1)
    return (
        f"90 % intervals hold the planted {effect} in {row['inside']:g} of {row['tables']:g} ({share:.0f} %; 95 % "
        f"range of that share {100.0 * row['low']:.0f} to {100.0 * row['high']:.0f} %); ranks of the truth among the "
        f"draws by quarters: {', '.join(map(str, row['quarters']))}."
    )


def write_page(results: Sequence[dict[str, Any]]) -> None:
    """Put the section between its marks in docs/published_tables.md."""
    put(PAGE, section(summary(results)), *MARKS)
