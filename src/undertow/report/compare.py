"""Runs side by side, from their run folders: what changed in verdicts, errors, prescribed and repaired parameters.

Belongs here: joining verdict.json of several runs, what counts as a change, the comparison's page. Does not belong
here: running anything, the terminal's table (front/terminal/).
"""

from __future__ import annotations

import json
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd
from jinja2 import Environment

from undertow.discrepancy.words import count, group_title, percent
from undertow.equation.registry import row
from undertow.errors import ConfigError, UndertowError
from undertow.quantities import Estimate, or_nan, unit_in_rotation
from undertow.report.verdict_file import read_verdicts
from undertow.report.wording import STATUS_WORDS, effects_words, estimate_text, parameter_words
from undertow.report.writing import as_read

NOTEWORTHY = 2.0
"""Standard errors (of both runs, in quadrature) from which on a parameter counts as changed; contract 2 takes the same
for an effect that moves a reported parameter. Runs of the same recordings share their noise and agree far better."""

CHANGED, ONLY = "changed", "only in"

OTHER_UNIT = "other unit, not comparable"

PER_MASS = "_per_mass"
"""In a parameter's name where no mass or stiffness is known; its unit says so too, and the rows of both are one."""

_PAGE = """<!doctype html><html lang="en"><head><meta charset="utf-8"><title>undertow: runs side by side</title>
<meta name="viewport" content="width=device-width, initial-scale=1"><style>
:root{color-scheme:light dark}body{font:14px/1.5 system-ui,sans-serif;margin:2em auto;padding:0 1em;max-width:70em}
table{border-collapse:collapse;width:100%}th,td{padding:4px 10px;border-bottom:1px solid #8886;text-align:left;
vertical-align:top}.wide{overflow-x:auto}tr.changed td:last-child{color:#D55E00;font-weight:600}
tr.same{opacity:.65}h2{font-size:1.1em;margin:1.6em 0 .3em}</style></head><body><h1>Runs side by side</h1>
<p>{{ summary }}</p><p>A parameter is marked where it moved by {{ limit }} standard errors or more.</p>
{% for group, rows in groups %}<h2>{{ group }}</h2><div class="wide"><table>
<tr>{% for c in columns %}<th>{{ c }}</th>{% endfor %}</tr>
{% for cells, kind in rows %}
<tr class="{{ kind }}">{% for cell in cells %}<td>{{ cell }}</td>{% endfor %}</tr>{% endfor %}
</table></div>{% endfor %}</body></html>"""


def _per_mass(unit: str) -> tuple[str, str]:
    """A unit over that of the mass, in translation and in rotation."""
    return f"{unit} per kg", f"{unit} per {unit_in_rotation('kg')}"


@dataclass(frozen=True)
class Cell:
    """What one run says of one quantity: its ``text``, the number behind a parameter and the total ``mass`` beside it
    (None: not known), and whether another one counts as a change (errors move with every parameter, they do not)."""

    text: str
    number: Estimate | None = None
    counts: bool = True
    mass: Estimate | None = None

    def in_unit(self, unit: str) -> Estimate | None:
        """The number in that unit; None where it cannot be had."""
        if self.number is None or self.number.unit == unit:
            return self.number
        mass = self.mass
        if mass is None or not mass.value > 0.0 or unit not in _per_mass(self.number.unit):
            return None
        moved = self.number.value * mass.total_stderr / mass.value
        error = math.hypot(self.number.total_stderr, moved) if math.isfinite(moved) else self.number.total_stderr
        return Estimate(self.number.value, error).scaled(1.0 / mass.value, unit)


def compare_runs(folders: Sequence[Path]) -> pd.DataFrame:
    """One row a group and quantity (verdict, errors, prescribed and repaired parameters), one column a run, as text.

    ``change`` says how later runs differ from the first one ("" where they print the same), ``changed`` whether that is
    more than `NOTEWORTHY` standard errors, another verdict, or something that one run alone has. Of a number and one
    per unit mass the first is divided by its run's total mass; other units are not compared, which is said. Groups and
    quantities stand in the order of the runs; an empty cell is what a run does not have. Runs of one name are
    distinguished by their paths.

    Raises UndertowError where a folder holds no finished run, or one written under another contract, ConfigError for a
    single run.
    """
    names = _labels(folders)
    runs = [dict(_one_run(folder)) for folder in folders]
    if len(runs) < 2:
        raise ConfigError(f"{', '.join(names)} is a single run; give two, as in undertow compare RUN RUN")
    rows = []
    for group in dict.fromkeys(group for run in runs for group in run):
        entries = [run.get(group, {}) for run in runs]
        for quantity in dict.fromkeys(q for entry in entries for q in entry):
            cells = [entry.get(quantity, Cell("")) for entry in entries]
            changes = [_change(cells[0], cell, names[0], name) for name, cell in zip(names[1:], cells[1:], strict=True)]
            rows.append({
                "group": group, "quantity": quantity, **dict(zip(names, (c.text for c in cells), strict=True)),
                "change": _joined([words for words, _ in changes], names[1:]),
                "changed": any(matters for _, matters in changes),
            })  # fmt: skip
    return pd.DataFrame(rows, columns=pd.Index(["group", "quantity", *names, "change", "changed"]))


def changes_in_words(table: pd.DataFrame) -> str:
    """How many groups there are, in how many verdicts and parameters changed, or one run alone has some."""
    verdicts = table[(table["quantity"] == "verdict") & (table["change"] != "")]["group"].nunique()
    numbers = table[table["changed"] & ~table["quantity"].isin(_ENTRY_QUANTITIES)]
    alone = numbers["change"].str.contains(ONLY)
    moved = numbers[~alone | numbers["change"].str.contains(f"errors|{CHANGED}")]["group"].nunique()
    more = f", parameters that one run alone has in {numbers[alone]['group'].nunique()}" if alone.any() else ""
    return (
        f"{count(int(table['group'].nunique()), 'group')}: another verdict in {verdicts}, parameters changed by "
        f"{NOTEWORTHY:g} standard errors or more in {moved}{more}"
    )


def comparison_html(folders: Sequence[Path]) -> str:
    """The comparison as a page, what changed marked; all texts escaped."""
    table = compare_runs(folders)
    columns = list(table.columns[1:-1])
    groups = [
        (
            group,
            [
                ([quantity_words(str(row[1])), *row[2:-1]], "changed" if row[-1] else "" if row[-2] else "same")
                for row in rows.itertuples(index=False)
            ],
        )
        for group, rows in table.groupby("group", sort=False)
    ]
    return Environment(autoescape=True, finalize=as_read).from_string(_PAGE).render(
        columns=columns, groups=groups, summary=changes_in_words(table), limit=f"{NOTEWORTHY:g}"
    )  # fmt: skip


def quantity_words(quantity: str) -> str:
    """A row's quantity as a reader wants it.

    >>> quantity_words("repaired: hidden_resonator.mass_kg"), quantity_words("k_N_per_m"), quantity_words("verdict")
    ('repaired: hidden resonator: mass', 'stiffness', 'verdict')
    """
    repaired, start, name = quantity.rpartition("repaired: ")
    return f"{repaired}{start}{parameter_words(name)}"


def _change(first: Cell, other: Cell, first_name: str, other_name: str) -> tuple[str, bool]:
    """How one run's cell differs from the first run's in words, and whether that matters."""
    if first.text == other.text:
        return "", False
    counts = first.counts and other.counts
    if not first.text or not other.text:
        return f"{ONLY} {first_name if first.text else other_name}", counts
    if first.number is None or other.number is None:
        return CHANGED, counts
    before, after = first.in_unit(other.number.unit), other.number
    if before is None:
        before, converted = first.number, other.in_unit(first.number.unit)
        if converted is None:
            return OTHER_UNIT, False
        after = converted
    error = math.hypot(before.total_stderr, after.total_stderr)
    shift = after.value - before.value
    if not (math.isfinite(error) and error > 0.0):
        return CHANGED, shift != 0.0
    return f"{round(shift / error, 1) + 0.0:+.1f} standard errors", abs(shift) >= NOTEWORTHY * error


def _joined(changes: Sequence[str], names: Sequence[str]) -> str:
    """One run's change alone, or each with its run."""
    if len(changes) == 1:
        return changes[0]
    return "; ".join(f"{name}: {words}" for words, name in zip(changes, names, strict=True) if words)


def _labels(folders: Sequence[Path]) -> list[str]:
    """A name a run: its folder's, its path where two folders have one name, numbered where a path is given twice."""
    short = Counter(folder.resolve().name for folder in folders)
    names = [f.resolve().name if short[f.resolve().name] == 1 else str(f) for f in folders]
    seen: Counter[str] = Counter()
    out = []
    for name in names:
        seen[name] += 1
        out.append(name if seen[name] == 1 else f"{name} ({seen[name]})")
    return out


def _one_run(folder: Path) -> Iterator[tuple[str, dict[str, Cell]]]:
    masses = _masses(folder)
    for entry in read_verdicts(folder)["groups"]:
        title = group_title(entry["group"])
        yield title, dict(_cells(entry, masses.get(title, {})))


def _masses(folder: Path) -> dict[str, dict[str, Estimate]]:
    """Total mass of every group's equations by their version, as equations.json has them; none in an older run."""
    path = folder / "equations.json"
    try:
        groups = json.loads(path.read_text(encoding="utf-8"))["groups"] if path.exists() else []
    except (ValueError, KeyError, TypeError) as reason:
        raise UndertowError(f"{path} is not as a run writes it ({type(reason).__name__}); run it again") from reason
    return {
        group_title(group["group"]): {name: _total_mass(one) for name, one in group.get("versions", {}).items() if one}
        for group in groups
    }


def _total_mass(version: Mapping[str, Any]) -> Estimate:
    added = [one for one in version["rows"] if (law := row(one["term"])) is not None and law.is_inertia]
    errors = [or_nan(version.get("mass_stderr")), *(or_nan(one["stderr"]) for one in added)]
    return Estimate(version["mass_kg"] + sum(one["value"] for one in added), math.hypot(*errors), unit="kg")


_ENTRY_QUANTITIES = (
    "verdict", "free-run error", "held-out error", "repaired: free-run error", "repaired: held-out error",
    "repeatability",
)  # fmt: skip
"""What a group has beside its parameters."""


def _cells(entry: Mapping[str, Any], masses: Mapping[str, Estimate]) -> Iterator[tuple[str, Cell]]:
    """What one group's entry of verdict.json says: quantity -> cell; ``masses`` by the equation's version."""
    baseline, after = entry["baseline"], entry.get("augmented")
    named = [name for name in entry["verdict"] if name != "unknown"]
    status, said = STATUS_WORDS[entry["status"]].removesuffix(" with"), effects_words(named)
    yield "verdict", Cell(f"{status}: {said}" if said else status)
    yield "free-run error", _error(baseline["nrmse"])
    yield "held-out error", _error(baseline["held_out_nrmse"])
    if after:
        yield "repaired: free-run error", _error(after["nrmse"])
        yield "repaired: held-out error", _error(after["held_out_nrmse"])
        yield "repaired: error of trials left out in turn", _error(after.get("cross_validated_nrmse"))
    yield "repeatability", _error(entry["repeatability_nrmse"])
    for start, described in (("", baseline), ("repaired: ", after or {"parameters": {}})):
        numbers = {name: number for name, one in described["parameters"].items() if (number := _estimate(one))}
        for name, number in numbers.items():
            mass = numbers.get("total_mass_kg", masses.get("augmented" if start else "baseline"))
            cell = Cell(estimate_text(number), number, mass=mass)
            yield f"{start}{name.replace(PER_MASS, '')}", cell


def _estimate(one: Any) -> Estimate | None:
    """A parameter of verdict.json; None where it has no value."""
    if not isinstance(one, dict) or one.get("value") is None:
        return None
    return Estimate(float(one["value"]), or_nan(one.get("stderr")), unit=str(one.get("unit", "")))


def _error(value: Any) -> Cell:
    return Cell(percent(or_nan(value)), counts=False)
