"""docs/blind_challenge.md from the tables: target beside what was reached, and every miss by its case."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from experiments.blind_challenge.composition import CALIBRATION_SEED, TEST_SEED
from experiments.blind_challenge.run_cases import LIMIT
from experiments.blind_challenge.score import SLOW

Rows = Iterable[Iterable[object]]

READINGS = Path(__file__).resolve().parent / "readings"
"""What the rows of a seed show, written by hand after its cases were looked into: SEED.md."""


def table(head: list[str], rows: Rows) -> str:
    """A Markdown table."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join([*lines, *("| " + " | ".join(map(str, row)) + " |" for row in rows)]) + "\n"


def percent(part: dict[str, Any] | None) -> str:
    """A share with its interval and counts, or that it is not there."""
    if not part or not part["n"]:
        return "no case"
    low, high = 100 * part["low"], 100 * part["high"]
    return f"{100 * part['share']:.1f} % ({low:.1f} to {high:.1f}; {part['hits']} of {part['n']})"


def number(value: object, form: str = ".3g") -> str:
    """A number, or that it is not there."""
    return "not there" if value is None else format(value, form)


def _met(good: bool | None) -> str:
    return "no number" if good is None else "reached" if good else "missed"


def _targets(t: dict[str, Any]) -> list[tuple[str, str, str, str]]:
    """What was asked, what came out, and whether it was reached."""
    n, s, power = t["nothing"], t["names"], t["power"]
    half, halves = _half(power["detection"])
    name, names = _half(power["name"])
    worst = max((v["upper"] for v in n["strata"].values() if v["n"] >= 100), default=None)

    def at_least(part: dict[str, Any], limit: float) -> str:
        return _met(None if not part["n"] else part["share"] >= limit)

    def at_most(part: dict[str, Any], limit: float) -> str:
        return _met(None if not part["n"] else part["share"] <= limit)

    covers = t["coverage"]["all"]
    return [
        ("nothing missing: false positives, one-sided 95 % limit", "at most 1 %",
         f"{n['false']} of {n['n']}, limit {100 * n['upper']:.2f} %", _met(n["upper"] <= 0.01 if n["n"] else None)),
        ("of these, an effect that counts (not present_but_small), one-sided 95 % limit", "(no target)",
         f"{n['accused']} of {n['n']}, limit {100 * n['accused_upper']:.2f} %", ""),
        ("the same as the first in any stratum of 100 cases or more", "at most 3 %", "no stratum" if worst is None else
         f"limit {100 * worst:.2f} %",
         _met(None if worst is None else worst <= 0.03)),
        ("nothing_missing said where scatter is known and a small effect could be seen", "at least 80 %",
         percent(n["nothing_said_sharp"]), at_least(n["nothing_said_sharp"], 0.8)),
        ("strength at half power, detection", "at most 1.5", halves, _met(None if half is None else half <= 1.5)),
        ("strength at half power, name", "at most 2", names, _met(None if name is None else name <= 2.0)),
        ("one effect above twice that strength: named", "at least 92 %", percent(s["one"]), at_least(s["one"], 0.92)),
        ("two effects above it: both named", "at least 80 %", percent(s["two"]), at_least(s["two"], 0.8)),
        ("in no catalogue, above it: unknown, or a description that predicts", "at least 80 %", percent(s["outside"]),
         at_least(s["outside"], 0.8)),
        ("the data cannot tell: answered rightly", "(no target)", percent(s["cannot"]), ""),
        ("confident wrong name", "at most 2 % of all", percent(s["wrong"]), at_most(s["wrong"], 0.02)),
        ("cannot_tell above twice that strength", "at most 10 %", percent(s["silent"]), at_most(s["silent"], 0.1)),
        ("90 % intervals of parameters hold the truth", "86 to 94 %", percent(covers),
         _met(0.86 <= covers["share"] <= 0.94 if covers["n"] else None)),
        ("confidence, what is said holds: slope and intercept", "0.8 to 1.25, within 0.3", *_slope(t["held"])),
        ("confidence, names complete and exact: slope and intercept", "0.8 to 1.25, within 0.3",
         *_slope(t["sure"])),
        ("held-out error after repair within 1.5 times repeatability", "at least 80 %", percent(t["repair"]["within"]),
         at_least(t["repair"]["within"], 0.8)),
        ("worse than the prescribed equation by more than 2 % of the motion", "never",
         percent(t["repair"]["worse_than_prescribed"]),
         at_most(t["repair"]["worse_than_prescribed"], 0.0)),
    ]  # fmt: skip


def _peers(t: dict[str, Any]) -> str:
    rows = [
        (name, percent(part), number(part["own_median"]), number(part["median"]))
        for name, part in t["repair"]["peers"].items()
    ]
    if not rows:
        return "No peer was run beside these rows.\n"
    return table(["peer", "error after repair is the smaller", "median here", "median of the peer"], rows)


def _cases(cases: list[dict[str, Any]]) -> str:
    """A table of cases that missed."""
    if not cases:
        return "None.\n"
    rows = [
        (
            c["case"],
            ", ".join(c["effects"]) or "nothing",
            number(c["strength"]),
            c["status"],
            c["verdict"],
            c["confidence"],
        )
        for c in cases
    ]
    return table(["case", "truth", "strength", "status", "verdict", "confidence"], rows)


def _origin(marks: dict[str, Any]) -> str:
    """Which rows these are."""
    seed = int(marks["seed"])
    named = {
        CALIBRATION_SEED: "calibration (may be looked at and tuned on)",
        TEST_SEED: "test (run once a frozen revision)",
    }
    word = named.get(seed, "neither of the two named seeds")
    return table(
        ["rows", "seed", "cases drawn", "rows scored", "revision"],
        [(word, seed, marks["cases"], marks["rows"], ", ".join(marks["revisions"]))],
    )


def _half(fit: dict[str, float] | None) -> tuple[float | None, str]:
    """Where the share passes one half, and that in words with the share that is missed however strong it is."""
    if fit is None:
        return None, number(None)
    return fit["half"], f"{number(fit['half'])} ({100 * fit['lapse']:.0f} % missed however strong)"


def _slope(sure: dict[str, Any]) -> tuple[str, str]:
    """Slope and intercept of a calibration, and whether they are as they should be."""
    fit = sure["fit"]
    if fit is None:
        return "not there", _met(None)
    within = 0.8 <= fit["slope"] <= 1.25 and abs(fit["intercept"]) <= 0.3
    return f"{fit['slope']:.2f}, {fit['intercept']:+.2f}", _met(within)


def _missing(t: dict[str, Any]) -> list[str]:
    """Keys that the rows do not hold: an older contract, said and not invented."""
    out = []
    if t["nothing"]["p"].get("missing"):
        out.append(f"- `p_value` is missing in {t['nothing']['p']['missing']} campaigns with nothing missing.")
    if t["sure"]["without_number"]:
        out.append(f"- `confidence` is missing in {t['sure']['without_number']} campaigns.")
    if t["coverage"]["without_number"]:
        out.append(
            f"- {t['coverage']['without_number']} parameters of the truth have no value with an error in the verdict."
        )
    return out or ["- Nothing that the tables need."]


def page(t: dict[str, Any], marks: dict[str, Any], picture: str) -> str:
    """The whole page."""
    n, s, p, sec = t["nothing"], t["names"], t["nothing"]["p"], t["seconds"]
    parts = [
        "# The blind challenge\n",
        "After this page you know how far a verdict can be trusted on effects that nobody here tuned to, and how to "
        "rerun the test.\n",
        "Cases are drawn by `experiments/blind_challenge`, which shares no code with the package; strengths are "
        "measured there, as the expected likelihood ratio of the true law after the prescribed equation was refitted, "
        "with the trials' scatter known (strength 1: the best possible test at p = .01 finds it every second time).\n",
        "    python -m experiments blind_challenge generate --set test --out runs/blind\n"
        "    python -m experiments blind_challenge run --out runs/blind\n"
        "    python -m experiments blind_challenge score --out runs/blind --page docs/blind_challenge.md\n",
        "## Which rows these are\n", _origin(marks),
        table(["truth", "cases"], t["kinds"].items()),
        "## Targets\n", table(["what", "target", "reached", ""], _targets(t)),
        f"![power and reliability]({picture})\n",
        "## Nothing missing\n",
        f"`nothing_missing` was said of all groups in {percent(n['nothing_said'])}. ",
        _uniform(p), table(["stratum", "false", "cases", "one-sided 95 % limit"],
            [(k, v["hits"], v["n"], f"{100 * v['upper']:.1f} %") for k, v in n["strata"].items()]),
        "False positives:\n", _cases(n["cases"]),
        "## Power\n", table(["strength", "cases", "detected", "named", "best possible"],
            [(f"{b['from']:g} to {number(b['to'])}" if b["to"] else f"from {b['from']:g}", b["n"],
              percent(b["detected"]), percent(b["named"]), f"{100 * b['best']:.0f} %") for b in t["power"]["bins"]]),
        "## Names\n", f"The limit for strong effects is a strength of {s['limit']:.2f}.\n",
        _outcome_table(s), table(["truth", "outcomes"],
            [(k, ", ".join(f"{o} {c}" for o, c in v.items())) for k, v in s["by_effect"].items()]),
        "Where the data cannot tell:\n", table(["reason", "answered rightly"],
            [(k, percent(v)) for k, v in s["cannot_by_reason"].items()]),
        "Confident wrong names:\n", _cases(s["wrong_cases"]),
        "## Parameters\n", table(["parameter", "90 % interval holds the truth"],
            [(k, percent(v)) for k, v in t["coverage"]["each"].items()]),
        "## Confidence\n",
        "What is said holds (nothing as large as what counts is missing, something is, or every name is of an effect "
        "that is there or describes it):\n", _sure(t["held"]),
        "Names complete and exact, nothing missing at all:\n", _sure(t["sure"]), "## Held-out error\n", _peers(t),
        "## Gates\n",
        "Groups that one gate alone turned, decided again without it (names that had been found, or nothing missing); "
        "docs/discrepancy.md has what each asks.\n",
        table(["gate", "turned", "right without it", "wrong without it"],
            [(k, v["turned"], v["right without"], v["wrong without"]) for k, v in t["gates"].items()]),
        "## Seconds\n",
        f"Median {number(sec['median'])} s, 90 % below {number(sec['q90'])} s, {len(sec['slow'])} of {sec['n']} over "
        f"{SLOW:g} s of processor time ({', '.join(sec['slow']) or 'none'}; stopped at {LIMIT:g} s: "
        f"{', '.join(sec['stopped']) or 'none'}); without a verdict: {', '.join(sec['failed']) or 'none'}; "
        f"{sec['total_hours']:.2f} h in all.\n",
        "## What the rows do not hold\n", "\n".join(_missing(t)) + "\n",
    ]  # fmt: skip
    read = READINGS / f"{marks['seed']}.md"
    return "\n".join([*parts, read.read_text(encoding="utf-8")] if read.is_file() else parts)


def _uniform(p: dict[str, Any]) -> str:
    if not p.get("n"):
        return "No p-value is in these rows.\n"
    return (
        f"p-values of {p['n']:.0f} campaigns against the uniform law: Kolmogorov-Smirnov {p['ks']:.3f} "
        f"(p = {p['ks_p']:.3f}); {100 * p['below_01']:.1f} % at or below .01, {100 * p['below_05']:.1f} % below .05, "
        f"{100 * p['below_10']:.1f} % below .1.\n"
    )


def _outcome_table(s: dict[str, Any]) -> str:
    rows = [
        (label, ", ".join(f"{o} {c}" for o, c in s[key].items()) or "no case")
        for label, key in (
            ("one effect", "one_outcomes"),
            ("two effects", "two_outcomes"),
            ("in no catalogue, above the limit", "outside_outcomes"),
        )
    ]
    return table(["truth", "outcomes of the group with the strongest effect"], rows)


def _sure(sure: dict[str, Any]) -> str:
    fit = sure["fit"]
    if fit is None:
        return "Too few verdicts with a confidence for a curve.\n"
    rows = [
        (f"{b['n']:.0f}", f"{b['confidence']:.3f}", f"{b['right']:.3f}", f"{b['low']:.3f} to {b['high']:.3f}")
        for b in sure["curve"]
    ]
    return (
        f"Slope {fit['slope']:.2f}, intercept {fit['intercept']:+.2f}, log score {fit['log_score']:.3f} "
        f"(a calibrated forecaster with these confidences: {fit['calibrated_log_score']:.3f}).\n\n"
        + table(["verdicts", "mean confidence", "share right", "90 % band"], rows)
    )
