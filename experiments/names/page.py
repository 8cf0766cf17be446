"""What the studies found, as docs/confusion.md with its json and svg.

Belongs here: words, tables and the picture, made from the studies' rows alone. Does not belong here: counts
(counts.py), any judging (verdicts.py).
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from experiments.names import counts
from experiments.names.rows import read

HEADINGS = {
    "right": "its name", "beside": "its name and\nunknown", "more": "its name and\nanother",
    "rival": "another, it\nas a rival", "part": "one of two", "wrong": "a wrong name",
    "unknown": "something\nunknown", "dry": "it, in dry\ntrials alone", "nothing": "nothing", "failed": "no verdict",
}  # fmt: skip
"""Columns of the picture, from right to wrong, in words."""

COLOURS = {"right": "#009E73", "beside": "#009E73", "more": "#E69F00", "rival": "#E69F00", "part": "#E69F00",
           "wrong": "#D55E00"}  # fmt: skip
"""Colours of its cells; all others are grey."""

CELL_IN = (1.55, 0.3)
"""Width and height of a cell, inch."""

READING = Path(__file__).resolve().parent / "reading.md"
"""Why verdicts came out wrong, written by hand from single campaigns looked into."""

HEAD = """\
# Which name each effect gets

Campaigns simulated with one known thing missing, judged by the package as `undertow run` judges them, and counted.
`python -m experiments names --page` makes this page from the rows in `experiments/names/results`, one line a campaign
with the revision that judged it. `python -m experiments names --study NAME --seeds N` adds rows (nulls, confusion,
pairs, inseparable, seiche, near_seiche, invariance); with `--folder DIR` it writes the campaigns themselves, for
`undertow run`.

The motion is integrated by the blind challenge's code (that of the rows so far by a fourth-order Runge-Kutta at 4 kHz;
both lie within 1e-11 m of data/eq15_campaign's integrator), with k, c, mu of every trial its own: scatter of the report
(k 0.4, c 23, mu 9 %) or of a careful rig (0.3, 6, 5 %). Sensors have noise, gain, offset, drift, a clock error, and 14
bits. A campaign has one or two springs, 3 or 4 trials a spring, wet and dry (nulls up to 6), 10 to 15 s at 100, 250 or
1000 Hz. What belongs to structure, set-up or instruments is in the dry trials too; what belongs to the water is not.

**Strength** is what the prescribed equation cannot follow of an effect once it is fitted to the motion (with k, c, mu
free where the dry trials have the effect too), over repeatability (the 95 % quantile of the same measure for scatter
alone). Effects that stay weak at any sensible size keep that size: the rows say what was reached.
Instruments: strength 1 is an accelerometer 4 ms late or 1 % off, a drift of 1 % of the largest release, 4 % of the
largest reading cut off.
"""


def make_page(results: Path, docs: Path) -> None:
    """Write docs/confusion.md, .json and .svg from the rows of all studies."""
    studies = ("nulls", "confusion", "pairs", "inseparable", "seiche", "near_seiche", "invariance")
    rows = {study: read(results / f"{study}.csv") for study in studies}
    found: dict[str, Any] = {
        "revisions": sorted({r["revision"] for many in rows.values() for r in many}),
        "nulls": counts.nulls(rows["nulls"]),
        "confusion": counts.by_name(rows["confusion"]),
        "pairs": counts.by_name(rows["pairs"]),
        "inseparable": counts.inseparable(rows["inseparable"]),
        "seiche": counts.seiche(rows["seiche"]),
        "near_seiche": counts.near(rows["near_seiche"]),
        "invariance": counts.invariance(rows["invariance"]),
    }
    (docs / "confusion.json").write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    (docs / "confusion.md").write_text(page_text(found), encoding="utf-8")
    if rows["confusion"]:
        _picture(rows["confusion"], docs / "confusion.svg")


def page_text(found: Mapping[str, Any]) -> str:
    """The page, from the counts alone."""
    parts = [HEAD, _wanted(found), _nulls(found["nulls"]), _names("One effect", found["confusion"], True)]
    if found["pairs"]:
        parts.append(_names("Two effects at once", found["pairs"], False))
    if found["inseparable"]:
        parts.append(_inseparable(found["inseparable"]))
    if any(part["campaigns"] for part in found["seiche"].values()):
        parts.append(_seiche(found["seiche"]))
    if found["near_seiche"]["campaigns"]:
        parts.append(_near(found["near_seiche"]))
    if found["invariance"]:
        parts.append(_invariance(found["invariance"]))
    parts.append(READING.read_text(encoding="utf-8"))
    revisions = ", ".join(f"`{r}`" for r in found["revisions"])
    plural = "s" if len(found["revisions"]) > 1 else ""
    parts.append(f"Judged at revision{plural} {revisions}; each row says at which.\n")
    return "\n".join(parts)


def _wanted(found: Mapping[str, Any]) -> str:
    """What the studies are to show, and how far they are."""
    pairs = found["inseparable"].values()
    both, tried = (sum(one[key] for one in pairs) for key in ("both", "campaigns"))
    wrong = sum(one["a_wrong_one"] for one in pairs)
    confused = ", ".join(f"{one['confused']} of {one['campaigns']} ({name})" for name, one in found["seiche"].items())
    views = found["invariance"].values()
    changed = sum(len(one["verdict_changed"]) for one in views)
    seen = max((one["campaigns"] for one in views), default=0)
    apart = sum(one["confidence_further_than_0.05"] for one in views)
    return "\n".join([
        "## Against what is wanted", "",
        "| wanted | measured so far |", "|---|---|",
        "| 300 nulls, at most 3 false positives | "
        f"{found['nulls']['false_positives']} of {found['nulls']['campaigns']} |",
        "| every name at three strengths | see the tables: most of it has one campaign a name, a look and no rate |",
        "| inseparable pairs: both names in 90 %, a wrong one in 2 % | "
        f"both in {both}, a wrong one in {wrong} of {tried} |",
        f"| 100 seiches and 100 resonators, at most 2 confused | {confused} |",
        f"| 30 campaigns in every view, verdict unchanged, confidence within 0.05 | {seen} campaigns, {changed} "
        f"verdicts changed, {apart} confidences further |",
        "",
    ])  # fmt: skip


def _nulls(null: Mapping[str, Any]) -> str:
    text = f"## Nothing hidden\n\n{null['campaigns']} campaigns, {null['false_positives']} false positives"
    if null["false_positives"]:
        said = "; ".join(f"{name} ({count})" for name, count in null["false_positives_of"].items())
        text += f": {said}. Seeds {', '.join(map(str, null['seeds']))}"
    return text + ".\n" + _p_values(null)


def _p_values(null: Mapping[str, Any]) -> str:
    """How often all groups are green, and p-values beside the uniform law."""
    if not null["uniform"]["all"]["campaigns"]:
        return ""
    lines = [
        "", f"All groups are `nothing_missing` in {null['green']} of {null['campaigns']}. p-values of the campaigns "
        "beside the uniform law (Kolmogorov-Smirnov):", "",
        "| nulls | campaigns | mean | below .01 | below .05 | below .1 | distance | its p |", "|---|" + "---|" * 7,
    ]  # fmt: skip
    for label, one in null["uniform"].items():
        numbers = (one[k] for k in ("campaigns", "mean", "below .01", "below .05", "below .1", "ks", "ks_p"))
        lines.append(f"| {label} | " + " | ".join(f"{n:g}" for n in numbers) + " |")
    return "\n".join([*lines, ""])


def _names(title: str, found: Mapping[str, Any], picture: bool) -> str:
    """Names by strength, outcomes in words."""
    strengths = sorted({float(s) for many in found.values() for s in many})
    lines = [f"## {title}", ""]
    if picture:
        lines += ["![What is hidden against what is said](confusion.svg)", ""]
    lines += [
        "right: exactly the hidden names (or these and unknown). more: them and another. rival: named as inseparable "
        "from the answer. part: one of two. dry: named in the dry trials, not in the wet ones. unknown: only "
        "that something is missing. nothing: nothing said. wrong: another name without the hidden one.", "",
        "| hidden | " + " | ".join(f"strength {s:g}" for s in strengths) + " |",
        "|---|" + "---|" * len(strengths),
    ]  # fmt: skip
    for name, many in found.items():
        cells = [_cell(many[f"{s:g}"]) if f"{s:g}" in many else "" for s in strengths]
        lines.append(f"| {name.replace('+', ' + ')} | " + " | ".join(cells) + " |")
    totals = [_total(found, f"{s:g}") for s in strengths]
    return "\n".join([*lines, "| **all** | " + " | ".join(totals) + " |", ""])


def _cell(one: Mapping[str, Any]) -> str:
    """`3 right, 1 wrong: relaxation`."""
    parts = [f"{one[o]} {o}" for o in counts.OUTCOMES if o in one]
    said = ", ".join(one["said"])
    return ", ".join(parts) + (f": {said.replace('+', ' + ')}" if said else "")


def _total(found: Mapping[str, Any], strength: str) -> str:
    cells = [many[strength] for many in found.values() if strength in many]
    total = sum(c["campaigns"] for c in cells)
    counted = {o: sum(c.get(o, 0) for c in cells) for o in counts.OUTCOMES}
    return f"{total}: " + ", ".join(f"{n} {o}" for o, n in counted.items() if n)


def _inseparable(found: Mapping[str, Any]) -> str:
    lines = [
        "## Pairs that a free decay cannot separate", "",
        "Both names count where they stand in the verdict or among its rivals.", "",
        "| pair | campaigns | both | only the true one | a wrong one | nothing | said |",
        "|---|---|---|---|---|---|---|",
    ]  # fmt: skip
    for pair, one in found.items():
        said = "; ".join(f"{name} ({count})" for name, count in one["said"].items())
        numbers = " | ".join(str(one[k]) for k in ("campaigns", "both", "the_true_one", "a_wrong_one", "nothing"))
        lines.append(f"| {pair} | {numbers} | {said} |")
    return "\n".join([*lines, ""])


def _seiche(found: Mapping[str, Any]) -> str:
    lines = [
        "## A seiche is no resonator",
        "",
        "| hidden | campaigns | called the other | outcomes |",
        "|---|---|---|---|",
    ]
    for name, one in found.items():
        lines.append(f"| {name} | {one['campaigns']} | {one['confused']} | {_cell(one)} |")
    return "\n".join([*lines, ""])


def _near(found: Mapping[str, Any]) -> str:
    return "\n".join([
        "## A force near the body's own rate", "",
        f"{found['campaigns']} forces with a clock of their own at 0.85 to 1.2 of the body's rate: {_cell(found)}. "
        f"Called a resonator, alone or beside others: {found['called_a_resonator']}.", "",
    ])  # fmt: skip


def _invariance(found: Mapping[str, Any]) -> str:
    lines = [
        "## The same campaign, written otherwise", "",
        "| view | campaigns | verdicts changed | confidence further than 0.05 | largest difference |",
        "|---|---|---|---|---|",
    ]  # fmt: skip
    for view, one in found.items():
        changed = f"{len(one['verdict_changed'])}" + (": " if one["verdict_changed"] else "")
        changed += "; ".join(one["verdict_changed"])
        lines.append(f"| {view} | {one['campaigns']} | {changed} | {one['confidence_further_than_0.05']} | "
                     f"{one['largest_confidence_difference']} |")  # fmt: skip
    return "\n".join([*lines, ""])


def _picture(rows: list[dict[str, str]], path: Path) -> None:
    """What is hidden against what is said of it: campaigns of all strengths, counted."""
    table = counts.against(rows)
    columns = [kind for kind in HEADINGS if any(kind in counted for _, counted in table)]
    matplotlib.rcParams["svg.hashsalt"] = "confusion"
    figure, axes = plt.subplots(figsize=(CELL_IN[0] * len(columns), CELL_IN[1] * (len(table) + 1)))
    for i, (_, counted) in enumerate(table):
        total = sum(one.total() for one in counted.values())
        for j, kind in enumerate(columns):
            if kind in counted:
                _cell_drawn(axes, (j, i), kind, counted[kind], total)
    labels = [f"{name.replace('_', ' ')}  " for name, _ in table]
    axes.set_yticks(range(len(table)), labels, fontsize=11)
    axes.set_xticks(range(len(columns)), [HEADINGS[kind] for kind in columns], fontsize=11, fontweight="bold")
    axes.set(xlim=(-0.5, len(columns) - 0.5), ylim=(len(table) - 0.5, -0.5))
    axes.tick_params(length=0, top=False, labeltop=True, labelbottom=False)
    axes.hlines([i + 0.5 for i in range(len(table) - 1)], -0.5, len(columns) - 0.5, color="#dddddd", lw=0.6)
    axes.spines[:].set_visible(False)
    axes.set_ylabel("hidden", fontsize=11)
    axes.set_title(f"what was said, in campaigns of strength {_listed(rows)} together", fontsize=11, pad=12)
    figure.savefig(path, bbox_inches="tight", metadata={"Date": None})
    plt.close(figure)


def _listed(rows: list[dict[str, str]]) -> str:
    """Strengths of the rows, smallest first."""
    return ", ".join(f"{s:g}" for s in sorted({float(r["strength"]) for r in rows}))


def _cell_drawn(axes: Axes, place: tuple[int, int], kind: str, said: Counter[str], total: int) -> None:
    """How many campaigns had an outcome: darker the more of all, with the other names that were said."""
    corner, shade = (place[0] - 0.49, place[1] - 0.46), 0.2 + 0.3 * said.total() / total
    axes.add_patch(Rectangle(corner, 0.98, 0.92, color=COLOURS.get(kind, "#777777"), alpha=shade, lw=0))
    others = ", ".join(name.replace("_", " ").replace("+", " + ") for name in said if name)
    axes.text(*place, f"{said.total()}: {others}" if others else str(said.total()), ha="center",
              va="center_baseline", fontsize=9 if others else 11)  # fmt: skip
