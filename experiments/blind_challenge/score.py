"""The scorer: it alone opens the truths. Tables of everything that the challenge must show, from rows and truths.

A number that the rows do not hold (a key that an older contract lacks) is None, and the page says that it is missing.
"""

import itertools
import json
import math
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

from experiments.blind_challenge import estimates as st
from experiments.blind_challenge.gates import worth
from experiments.blind_challenge.judge import (
    FOUND,
    NAMED,
    CaseResult,
    GroupResult,
    cannot_right,
    confident_wrong,
    holds,
    judge_case,
    statement_right,
)

SLOW = 60.0  # seconds
QUANTILE = 1.645  # of a 90 % interval
WITHOUT_MASS = {  # numbers that a campaign without a known mass has too
    "natural_frequency_rad_per_s", "damping_ratio", "exponent", "time_s", "delay_s", "shift_s", "velocity_m_per_s",
    "yield_displacement_m", "frequency_rad_per_s",
}  # fmt: skip
SHARP = 1.5  # sharpness above which U could be below B
PER_KG = "per kg"  # how the unit of a number per mass ends
FEWEST = 3  # dry trials of a spring that show how much trials differ
Table = dict[str, object]


def load(rows: Iterable[dict[str, object]], sealed: Path) -> list[CaseResult]:
    """Rows beside their truths; a row whose truth is not there, or is of another seed, is refused."""
    out = []
    for row in rows:
        path = sealed / f"{row['case']}.json"
        if not path.exists():
            raise FileNotFoundError(
                f"case {row['case']}: no truth in {sealed}; generate the challenge of seed {row.get('seed')} anew"
            )
        truth = json.loads(path.read_text(encoding="utf-8"))
        if truth["seed"] != row.get("seed"):
            raise ValueError(
                f"case {row['case']}: the row has seed {row.get('seed')}, "
                f"the truth {truth['seed']}; score rows of one seed"
            )
        out.append(judge_case(row, truth))
    return out


def share(hits: int, n: int) -> Table:
    """Hits of n with the 90 % interval of the share."""
    low, high = st.interval(hits, n)
    return {"hits": hits, "n": n, "share": hits / n if n else None, "low": low, "high": high}


def nulls(cases: list[CaseResult]) -> Table:
    """False positives over all and by stratum, what was said where a small effect could be seen (and scatter is known),
    and p-values."""
    held = [c for c in cases if c.kind == "nothing" and c.answered]
    false = [c for c in held if c.false]
    accused = sum(c.accused for c in held)
    strata: dict[str, Table] = {}
    for key in (
        "dry",
        "noise",
        "trials",
        "springs",
        "levels",
        "channels",
        "scatter",
        "frequency",
        "coordinate",
        "lost samples",
        "correlated noise",
    ):
        for value in sorted({str(c.truth["strata"][key]) for c in held}):
            part = [c for c in held if str(c.truth["strata"][key]) == value]
            hits = sum(c.false for c in part)
            strata[f"{key}: {value}"] = {"hits": hits, "n": len(part), "upper": st.upper_limit(hits, len(part))}
    sharp = [c for c in held if float(c.truth["measures"].get("sharpness", 0.0)) >= SHARP and scatter_known(c)]
    return {
        "n": len(held),
        "false": len(false),
        "upper": st.upper_limit(len(false), len(held)),
        "accused": accused,
        "accused_upper": st.upper_limit(accused, len(held)),
        "cases": [_short(c) for c in false],
        "strata": strata,
        "nothing_said": share(sum(_all_nothing(c) for c in held), len(held)),
        "nothing_said_sharp": share(sum(_all_nothing(c) for c in sharp), len(sharp)),
        "p": _p_values(held),
    }


def scatter_known(case: CaseResult) -> bool:
    """Whether the config or three dry trials of every spring say how much trials differ."""
    dry: dict[str, int] = {}
    for group in case.truth["groups"]:
        spring = str(group["group"].get("spring", ""))
        dry[spring] = dry.get(spring, 0) + (0 if group.get("wet", True) else len(group["trials"]))
    return "scatter" in case.truth["knows"] or min(dry.values()) >= FEWEST


def _all_nothing(case: CaseResult) -> bool:
    return all(g.outcome in ("right", "absent") for g in case.groups)


def _short(case: CaseResult) -> Table:
    """What a reader needs to look at a case again."""
    group = case.deciding
    return {
        "case": case.row["case"],
        "effects": [e["key"] for e in case.truth["measures"]["effects"]],
        "strength": case.strength,
        "outcome": group.outcome if group else "absent",
        "status": group.said.get("status") if group else None,
        "verdict": group.said.get("verdict") if group else None,
        "confidence": group.said.get("confidence") if group else None,
    }


def _p_values(cases: list[CaseResult]) -> Table:
    """One p a campaign: the group's own where all agree, else that of a group chosen by the case's number."""
    values = []
    for i, case in enumerate(cases):
        found = [g.said["p_value"] for g in case.groups if g.said.get("p_value") is not None]
        if found:
            values.append(float(found[i % len(found)]))
    return {**st.uniformity(values), "missing": len(cases) - len(values)}


def power(cases: list[CaseResult]) -> Table:
    """Detection and naming against strength, beside the best possible test, for effects of the catalogue."""
    held = [c for c in cases if c.kind == "one" and c.answered and c.strength > 0.0]
    strength = [c.strength for c in held]
    edges = [0.0, 0.5, 0.8, 1.25, 2.0, 4.0, 8.0, 16.0, math.inf]
    bins = []
    for low, high in itertools.pairwise(edges):
        part = [c for c in held if low <= c.strength < high]
        if part:
            bins.append(
                {
                    "from": low,
                    "to": None if math.isinf(high) else high,
                    "n": len(part),
                    "detected": share(sum(c.detected for c in part), len(part)),
                    "named": share(sum(_named(c) for c in part), len(part)),
                    "best": float(np.mean([c.best_power for c in part])),
                }
            )
    return {
        "bins": bins,
        "detection": st.half_power(strength, [c.detected for c in held]),
        "name": st.half_power(strength, [_named(c) for c in held]),
    }


def _named(case: CaseResult) -> bool:
    group = case.deciding
    return group is not None and group.outcome in NAMED


def _outcomes(cases: list[CaseResult]) -> dict[str, int]:
    """How often each outcome of the deciding group occurred."""
    out: dict[str, int] = {}
    for case in cases:
        group = case.deciding
        key = group.outcome if group else "absent"
        out[key] = out.get(key, 0) + 1
    return dict(sorted(out.items(), key=lambda item: -item[1]))


def names(cases: list[CaseResult], limit: float) -> Table:
    """Names right above a strength, by kind of truth; both of two; silence; confident wrong names over all."""
    answered = [c for c in cases if c.answered]
    one = [c for c in answered if c.kind == "one" and c.strength >= limit]
    two = [c for c in answered if c.kind == "two" and c.strength >= limit]
    outside = [c for c in answered if c.kind == "outside" and c.strength >= limit]
    cannot = [c for c in cases if c.kind == "cannot"]
    strong = [c for c in answered if c.kind in ("one", "two", "outside") and c.strength >= limit]
    by_effect: dict[str, dict[str, int]] = {}
    for case in (c for c in answered if c.kind in ("one", "outside")):
        key = case.truth["measures"]["effects"][0]["key"]
        by_effect.setdefault(key, {})
    for key in by_effect:
        by_effect[key] = _outcomes(
            [c for c in answered if c.kind in ("one", "outside") and c.truth["measures"]["effects"][0]["key"] == key]
        )
    wrong = [c for c in answered if confident_wrong(c)]
    return {
        "limit": limit,
        "one": share(sum(_named(c) for c in one), len(one)),
        "one_outcomes": _outcomes(one),
        "two": share(sum(_named(c) for c in two), len(two)),
        "two_outcomes": _outcomes(two),
        "outside": share(sum(_outside_right(c) for c in outside), len(outside)),
        "outside_outcomes": _outcomes(outside),
        "cannot": share(sum(cannot_right(c) for c in cannot), len(cannot)),
        "cannot_by_reason": _by_reason(cannot),
        "silent": share(sum(_silent(c) for c in strong), len(strong)),
        "by_effect": dict(sorted(by_effect.items())),
        "wrong": share(len(wrong), len(answered)),
        "wrong_cases": [_short(c) for c in wrong],
    }


def _silent(case: CaseResult) -> bool:
    group = case.deciding
    return group is not None and group.outcome == "silent"


def _by_reason(cases: list[CaseResult]) -> dict[str, Table]:
    reasons = sorted({str(c.truth["reason"]) for c in cases})
    parts = {reason: [c for c in cases if c.truth["reason"] == reason] for reason in reasons}
    return {reason: share(sum(cannot_right(c) for c in part), len(part)) for reason, part in parts.items()}


def _outside_right(case: CaseResult) -> bool:
    """`unknown`, with names before it or not, or a description that says so and predicts unseen trials within 1.5 times
    repeatability: those held back, or where none was those that a fit left out."""
    group = case.deciding
    if group is None:
        return False
    if group.outcome == "unknown" or group.said.get("status") == "unknown":
        return True
    says = "descri" in json.dumps([group.said.get(k) for k in ("sentence", "because", "origin")]).lower()
    ratio = _held_out_ratio(group) or _held_out_ratio(group, "cross_validated_nrmse")
    return group.outcome in FOUND and group.outcome != "wrong" and says and ratio is not None and ratio <= 1.5


def _held_out_ratio(group: GroupResult, key: str = "held_out_nrmse") -> float | None:
    after = (group.said.get("augmented") or {}).get(key)  # type: ignore[union-attr]
    repeat = group.said.get("repeatability_nrmse")
    return float(after) / float(repeat) if after is not None and repeat else None  # type: ignore[arg-type]


def coverage(cases: list[CaseResult]) -> Table:
    """Whether 90 % intervals of parameters hold the truth, where the right name was said and the truth has one.

    Without a known mass the program's numbers are per mass: those that have a mass in their unit are left out. A
    number said to be per kilogram is held against the truth over the group's own mass, its water's included.
    """
    inside: dict[str, list[bool]] = {}
    bare = 0
    for case in (c for c in cases if c.kind in ("one", "two")):
        for i, group in enumerate(case.groups):
            if group.outcome not in NAMED:
                continue
            for effect in group.effects:
                for name in effect["names"]:
                    said = (group.said.get("parameters") or {}).get(name)  # type: ignore[union-attr]
                    said = said[0] if isinstance(said, list) and said else said
                    for number, true in effect["groups"][i].get("parameters", {}).items():
                        if number not in WITHOUT_MASS and "mass" not in case.truth["knows"]:
                            continue
                        entry = said.get(number) if isinstance(said, dict) else None
                        if not isinstance(entry, dict) or not entry.get("stderr"):
                            bare += 1
                            continue
                        per = str(entry.get("unit", "")).endswith(PER_KG)
                        own = float(case.truth["groups"][i]["body"]["mass"]) if per else 1.0
                        miss = abs(float(entry["value"]) - float(true) / own) / float(entry["stderr"])
                        inside.setdefault(f"{name}.{number}", []).append(miss <= QUANTILE)
    total = [hit for hits in inside.values() for hit in hits]
    return {
        "all": share(sum(total), len(total)),
        "without_number": bare,
        "each": {key: share(sum(hits), len(hits)) for key, hits in sorted(inside.items())},
    }


def sureness(cases: list[CaseResult], frequency: dict[str, float] | None = None, exact: bool = True) -> Table:
    """Confidence against being right, one group a campaign: names complete and `exact`, or whether what is said holds;
    `frequency`: how often each kind occurs, where it is not as drawn.
    """
    confidence, right, kinds = [], [], []
    missing = 0
    for case in cases:
        group = case.deciding
        truth = None
        if group is not None and case.kind != "cannot":
            truth = statement_right(group, case.kind) if exact else holds(group)
        if truth is None or group is None:
            continue
        if group.said.get("confidence") is None:
            missing += 1
            continue
        confidence.append(float(group.said["confidence"]))  # type: ignore[arg-type]
        right.append(truth)
        kinds.append(case.kind)
    weights = None
    if frequency:
        weights = [frequency.get(kind, 0.0) / max(kinds.count(kind), 1) for kind in kinds]
    return {
        "fit": st.calibration(confidence, right, weights),
        "curve": st.reliability(confidence, right),
        "without_number": missing,
        "n": len(confidence),
    }


def repair(cases: list[CaseResult], peers: list[dict[str, object]]) -> Table:
    """Held-out error after repair beside repeatability, the prescribed equation and every peer."""
    explained = [g for c in cases for g in c.groups if g.said.get("status") == "explained"]
    ratios = [r for g in explained if (r := _held_out_ratio(g)) is not None]
    worse, pairs = 0, 0
    for group in (g for c in cases for g in c.groups):
        before, after = ((group.said.get(k) or {}).get("held_out_nrmse") for k in ("baseline", "augmented"))  # type: ignore[union-attr]
        if before is not None and after is not None:
            pairs += 1
            worse += float(after) > float(before) + 0.02
    return {
        "within": share(sum(r <= 1.5 for r in ratios), len(ratios)),
        "explained": len(explained),
        "worse_than_prescribed": share(worse, pairs),
        "peers": _beside_peers(cases, peers),
    }


def _beside_peers(cases: list[CaseResult], peers: list[dict[str, object]]) -> dict[str, Table]:
    """How often the error after repair is the smaller one, and the medians of both, over groups that both have."""
    own = {}
    for case in cases:
        for group in case.groups:
            after = (group.said.get("augmented") or group.said.get("baseline") or {}).get("held_out_nrmse")  # type: ignore[union-attr]
            if after is None:
                after = (group.said.get("baseline") or {}).get("held_out_nrmse")  # type: ignore[union-attr]
            if after is not None:
                own[str(case.row["case"]), json.dumps(_plain(group.truth["group"]), sort_keys=True)] = float(after)
    out: dict[str, Table] = {}
    for name in sorted({k for row in peers for k in row} - {"case", "group", "held_out"}):
        both = []
        for row in peers:
            key = str(row["case"]), json.dumps(_plain(row["group"]), sort_keys=True)
            if key in own and isinstance(row.get(name), float):
                both.append((own[key], float(row[name])))  # type: ignore[arg-type]
        wins = sum(a <= b for a, b in both)
        out[name] = {
            **share(wins, len(both)),
            "own_median": float(np.median([a for a, _ in both])) if both else None,
            "median": float(np.median([b for _, b in both])) if both else None,
        }
    return out


def _plain(group: object) -> dict[str, object]:
    """Numbers of a group's name as floats, so that two writings of it are one."""
    return {k: float(v) if isinstance(v, (int, float)) else v for k, v in dict(group).items()}  # type: ignore[call-overload]


def seconds(cases: list[CaseResult]) -> Table:
    """Seconds a campaign; those stopped or slower than SLOW; the first of every worker, which compiles, apart."""
    rows = [c.row for c in cases if not c.row.get("first_of_worker")]
    times = np.array([float(r["seconds"]) for r in rows]) if rows else np.zeros(0)  # type: ignore[arg-type]
    return {
        "n": len(rows),
        "median": float(np.median(times)) if rows else None,
        "q90": float(np.quantile(times, 0.9)) if rows else None,
        "slow": [str(r["case"]) for r in rows if r["stopped"] or float(r["seconds"]) > SLOW],  # type: ignore[arg-type]
        "stopped": [str(c.row["case"]) for c in cases if c.row["stopped"]],
        "failed": [str(c.row["case"]) for c in cases if not c.answered and not c.row["stopped"]],
        "total_hours": float(sum(float(c.row["seconds"]) for c in cases)) / 3600.0,  # type: ignore[arg-type]
    }


def tables(cases: list[CaseResult], peers: list[dict[str, object]], frequency: dict[str, float] | None = None) -> Table:
    """Everything at once."""
    strength = power(cases)
    half = strength["detection"]
    limit = 2.0 * (float(half["half"]) if half else 1.0)  # type: ignore[index]
    parts: dict[str, Callable[[], Table]] = {
        "nothing": lambda: nulls(cases),
        "names": lambda: names(cases, limit),
        "coverage": lambda: coverage(cases),
        "sure": lambda: sureness(cases, frequency),
        "held": lambda: sureness(cases, frequency, exact=False),
        "repair": lambda: repair(cases, peers),
        "seconds": lambda: seconds(cases),
        "gates": lambda: worth(cases),
    }
    kinds = {k: sum(c.kind == k for c in cases) for k in ("nothing", "one", "two", "outside", "cannot")}
    return {"kinds": kinds, "power": strength, **{name: make() for name, make in parts.items()}}
