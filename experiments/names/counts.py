"""What the rows of the studies add up to: counts a name and strength, false positives, confusions, changed verdicts.

Belongs here: numbers of docs/confusion.json. Does not belong here: how they are shown (page.py).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence

import numpy as np
from scipy.stats import kstest

from experiments.names.effects import EFFECTS, verdict_name
from experiments.names.verdicts import names_in, outcome

Row = Mapping[str, str]
Numbers = dict[str, object]

OUTCOMES = ("right", "more", "rival", "part", "dry", "unknown", "nothing", "wrong", "failed")
WITH_ANOTHER = ("wrong", "more", "rival", "part")
"""Outcomes in which another name was said."""
CONFIDENCE_WITHIN = 0.05
"""A view's confidence may differ by so much from the first view's."""


def said(row: Row) -> str:
    """A row's wet verdict as one label: names in order of the alphabet, or nothing.

    >>> said({"wet": "relaxation+cubic_damping|relaxation", "failed": ""})
    'cubic_damping+relaxation'
    """
    if row["failed"]:
        return "failed"
    return "+".join(sorted(names_in(row["wet"]))) or "nothing"


def nulls(rows: Sequence[Row]) -> Numbers:
    """How many null campaigns were false positives, wet or dry, and with which name; unknown counts too."""
    wrong = [r for r in rows if r["wet"] or r["dry"]]
    names = Counter(" and ".join(f"{w} {r[w]}" for w in ("dry", "wet") if r[w]) for r in wrong)
    return {
        "campaigns": len(rows),
        "green": sum(r["status"] == "nothing_missing" and r.get("dry_status") == "nothing_missing" for r in rows),
        "uniform": {label: _uniform(mine) for label, mine in _strata(rows).items()},
        "false_positives": len(wrong),
        "false_positives_of": dict(names.most_common()),
        "seeds": [int(r["seed"]) for r in wrong],
    }


def _strata(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """Nulls by rig, springs and whether the config states the scatter."""
    found: dict[str, list[Row]] = {"all": list(rows)}
    for row in rows:
        stated = "stated" if int(row["seed"]) % 2 else "from the dry trials"
        for label in (f"scatter of {row['scatter']}", f"springs {row['springs']}", f"scatter {stated}"):
            found.setdefault(label, []).append(row)
    return found


def _uniform(rows: Sequence[Row]) -> Numbers:
    """p-values of campaigns with nothing missing beside the uniform law."""
    p = np.array([float(r["p_value"]) for r in rows if r.get("p_value")])
    if not p.size:
        return {"campaigns": 0}
    ks = kstest(p, "uniform")
    return {
        "campaigns": int(p.size), "mean": round(float(np.mean(p)), 3), "below .01": int(np.sum(p < 0.01)),
        "below .05": int(np.sum(p < 0.05)), "below .1": int(np.sum(p < 0.1)), "ks": round(float(ks.statistic), 3),
        "ks_p": float(f"{ks.pvalue:.2g}"),
    }  # fmt: skip


def near(rows: Sequence[Row]) -> Numbers:
    """Forces near the body's own rate: outcomes, and how many were called a resonator, alone or beside others."""
    return _counted(rows) | {"called_a_resonator": sum("hidden_resonator" in names_in(r["wet"]) for r in rows)}


def by_name(rows: Sequence[Row]) -> Numbers:
    """Each hidden name and strength: its outcomes, and what was said instead; names in the order of the catalogue."""
    order = {e.name: place for place, e in enumerate(EFFECTS)}
    found: Numbers = {}
    hidden = sorted({r["hidden"] for r in rows}, key=lambda n: (order.get(n, len(order)), n))
    for name in hidden:
        strengths = sorted({float(r["strength"]) for r in rows if r["hidden"] == name})
        found[name] = {f"{s:g}": _counted([r for r in rows if r["hidden"] == name and float(r["strength"]) == s])
                       for s in strengths}  # fmt: skip
    return found


def _counted(rows: Sequence[Row]) -> Numbers:
    outcomes = Counter(outcome(r) for r in rows)
    others = Counter(said(r) for r in rows if outcome(r) in WITH_ANOTHER)
    return {
        "campaigns": len(rows),
        **{o: outcomes[o] for o in OUTCOMES if outcomes[o]},
        "said": dict(others.most_common()),
        "named_in_dry_trials": sum(verdict_name(r["hidden"]) in names_in(r["dry"]) for r in rows),
    }


def against(rows: Sequence[Row]) -> list[tuple[str, dict[str, Counter[str]]]]:
    """Each hidden name with what was said of it, all strengths together: outcome -> how often which other names.

    "right" is parted: "beside" where unknown stands beside the hidden name. Names that are found most often come first,
    then those of the catalogue's order.
    """
    found = []
    for effect in EFFECTS:
        counted: dict[str, Counter[str]] = {}
        for row in (r for r in rows if r["hidden"] == effect.name):
            kind = outcome(row)
            kind = "beside" if kind == "right" and "unknown" in names_in(row["wet"]) else kind
            counted.setdefault(kind, Counter())[said(row) if kind in WITH_ANOTHER else ""] += 1
        if counted:
            found.append((effect.name, counted))
    return sorted(found, key=lambda one: -sum(one[1][kind].total() for kind in ("right", "beside") if kind in one[1]))


def seiche(rows: Sequence[Row]) -> Numbers:
    """Forces called resonators, and resonators called forces."""
    found: Numbers = {}
    for name, other in (("external_forcing", "hidden_resonator"), ("hidden_resonator", "external_forcing")):
        mine = [r for r in rows if r["hidden"] == name]
        found[name] = _counted(mine) | {"confused": sum(other in names_in(r["wet"]) for r in mine)}
    return found


def inseparable(rows: Sequence[Row]) -> Numbers:
    """Pairs that a free decay cannot separate, by which of them is there: both said (verdict or rival), or not."""
    found: Numbers = {}
    for pair, truth in dict.fromkeys((r["hidden"], r["view"]) for r in rows):
        mine = [r for r in rows if (r["hidden"], r["view"]) == (pair, truth)]
        two = frozenset(pair.split("+"))
        all_names = [(names_in(r["wet"]) | names_in(r["rivals"])) - {"unknown"} for r in mine]
        found[f"{pair.replace('+', ' and ')}, {truth}"] = {
            "campaigns": len(mine),
            "both": sum(two <= names for names in all_names),
            "the_true_one": sum(names & two == {truth.removeprefix("truth ")} for names in all_names),
            "a_wrong_one": sum(bool(names) and truth.removeprefix("truth ") not in names for names in all_names),
            "nothing": sum(not names for names in all_names),
            "said": dict(Counter(_with_rivals(r) for r in mine).most_common()),
        }
    return found


def _with_rivals(row: Row) -> str:
    return said(row) + (f" (or {row['rivals']})" if row["rivals"] else "")


def invariance(rows: Sequence[Row]) -> Numbers:
    """Each view against the first of its campaign: verdicts that differ, and confidences further than the tolerance."""
    first: dict[tuple[str, str], Row] = {}
    for row in rows:
        first.setdefault((row["hidden"], row["seed"]), row)
    found: Numbers = {}
    for view in dict.fromkeys(r["view"] for r in rows):
        mine = [(r, first[r["hidden"], r["seed"]]) for r in rows if r["view"] == view]
        changed = [
            f"{r['hidden'] or 'nothing'}, seed {r['seed']}: {said(f)} to {said(r)}"
            for r, f in mine
            if said(r) != said(f)
        ]
        same = [(r, f) for r, f in mine if said(r) == said(f) != "failed"]
        apart = [abs(float(r["confidence"]) - float(f["confidence"])) for r, f in same]
        found[view] = {
            "campaigns": len(mine),
            "verdict_changed": changed,
            "confidence_further_than_0.05": sum(a > CONFIDENCE_WITHIN for a in apart),
            "largest_confidence_difference": round(max(apart, default=0.0), 3),
        }
    return found
