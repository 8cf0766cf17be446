"""What each kind of evidence is worth: the same campaigns decided again without hidden states, without the other
springs, without the trials in air.

Belongs here: campaigns with something taken away, and what was said of them beside what had been said. Does not belong
here: running (run_cases.py), outcomes (judge.py), what a gate alone turns (gates.py).
"""

import os
import shutil
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd
from ruamel.yaml import YAML

from experiments.blind_challenge.judge import NAMED, CaseResult, confident_wrong
from experiments.blind_challenge.page import READINGS, percent, table
from experiments.blind_challenge.score import share

HIDDEN_STATES = ("hidden_resonator", "relaxation", "hysteresis", "presliding")

Taken = tuple[dict[str, Any], pd.DataFrame]
"""A campaign's config and index with something taken away."""

Row = dict[str, Any]


def suspects_of(rows: list[Row]) -> list[str]:
    """Every name that a verdict named or says to have tried."""
    groups = [g for row in rows for g in (row["verdict"] or {}).get("groups", [])]
    found = {str(r["name"]) for g in groups for r in g["rejected"]} | {str(n) for g in groups for n in g["verdict"]}
    return sorted(found - {"unknown", "clipping"})


def without_hidden_states(config: Row, index: pd.DataFrame, names: list[str]) -> Taken | None:
    """No suspect that carries a motion of its own."""
    return config | {"discrepancy": {"suspects": [n for n in names if n not in HIDDEN_STATES]}}, index


def without_dry_trials(config: Row, index: pd.DataFrame, names: list[str]) -> Taken | None:
    """No trial in air; None where there is none."""
    trials = dict(config["trials"])
    dry = trials.pop("dry", None)
    if not dry:
        return None
    ((condition, value),) = dry.items()
    wet = index[(index[condition].astype(float) - float(value)).abs() > 1e-6]
    return config | {"trials": trials}, wet


def without_other_springs(config: Row, index: pd.DataFrame, names: list[str]) -> Taken | None:
    """The spring with the most trials alone; None where there is no other."""
    if "spring" not in index or index["spring"].nunique() < 2:
        return None
    return config, index[index["spring"] == index["spring"].value_counts().idxmax()]


ABLATIONS: dict[str, Callable[[Row, pd.DataFrame, list[str]], Taken | None]] = {
    "hidden states": without_hidden_states,
    "trials in air": without_dry_trials,
    "the other spring": without_other_springs,
}


def prepare(laboratory: Path, out: Path, cases: list[str], names: list[str]) -> dict[str, Path]:
    """Laboratories with something taken away, by what it is; recordings are linked, not copied."""
    yaml = YAML(typ="safe")
    yaml.default_flow_style = False
    made = {}
    for what, take in ABLATIONS.items():
        folder = out / what.replace(" ", "_") / "laboratory"
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        shutil.copy(laboratory / "challenge.json", folder)
        for case in cases:
            source = laboratory / case
            with (source / "config.yaml").open(encoding="utf-8") as stream:
                config = yaml.load(stream)
            taken = take(config, pd.read_csv(source / "campaign.csv"), names)
            if taken is None or taken[1].empty:
                continue
            target = folder / case
            (target / "recordings").mkdir(parents=True)
            for path in (source / "recordings").iterdir():
                os.link(path, target / "recordings" / path.name)
            with (target / "config.yaml").open("w", encoding="utf-8") as stream:
                yaml.dump(taken[0], stream)
            taken[1].to_csv(target / "campaign.csv", index=False)
        made[what] = folder
    return made


def beside(before: list[CaseResult], after: list[CaseResult]) -> Row:
    """Counts of both over the groups that both have: false accusations, strong effects named, green, wrong names."""
    known = {str(c.row["case"]): c for c in before}
    counts: dict[str, Counter[str]] = {"with": Counter(), "without": Counter()}
    total: Counter[str] = Counter()
    for case in after:
        was = known.get(str(case.row["case"]))
        if was is None or not was.answered or not case.answered or case.kind == "cannot":
            continue
        both = [i for i, g in enumerate(case.groups) if g.outcome != "absent" and was.groups[i].outcome != "absent"]
        pair = [replace(one, groups=tuple(one.groups[i] for i in both)) for one in (was, case)]
        if not both:
            continue
        total["cases"] += 1
        total["nothing" if case.kind == "nothing" else "effects"] += 1
        for name, one in zip(counts, pair, strict=True):
            deciding = one.deciding
            if case.kind == "nothing":
                counts[name]["false"] += one.false
                counts[name]["green"] += all(g.outcome == "right" for g in one.groups)
            else:
                counts[name]["detected"] += one.detected
                counts[name]["named"] += deciding is not None and deciding.outcome in (*NAMED, "described")
            counts[name]["wrong"] += confident_wrong(one)
    return {"total": total, **counts}


def page(found: dict[str, Row], marks: Row) -> str:
    """docs/ablations.md."""
    rows = []
    for what, one in found.items():
        n = one["total"]
        for label, key, of in (
            ("nothing missing: something said", "false", n["nothing"]),
            ("nothing missing: said so", "green", n["nothing"]),
            ("effects: detected", "detected", n["effects"]), ("effects: named or described", "named", n["effects"]),
            ("confident wrong name", "wrong", n["cases"]),
        ):  # fmt: skip
            rows.append((what, label, *(percent(share(one[side][key], of)) for side in ("with", "without"))))
    read = READINGS / "ablations.md"
    return "\n".join([
        "# What each kind of evidence is worth\n",
        "After this page you know what is lost where a laboratory has one spring alone, no trials in air, or where no "
        "suspect with a motion of its own is tried. It is made by\n",
        "    python -m experiments blind_challenge ablate --out runs/blind --first 200 --page docs/ablations.md\n",
        f"The first {marks['cases']} cases of the blind challenge's seed {marks['seed']}, which had been looked into: "
        f"calibration. Revision {', '.join(marks['revisions'])}. Counted are groups that both runs have, of campaigns "
        "that have what is taken away; cases that cannot tell are left out. An effect is of any strength, from a third "
        "of what can be seen. What a gate alone turns is in [the blind challenge](blind_challenge.md).\n",
        table(["without", "what", "with it", "without it"], rows),
        *([read.read_text(encoding="utf-8")] if read.is_file() else []),
    ])  # fmt: skip
