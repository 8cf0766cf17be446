"""What stands behind each verdict of a run: every gate with its number and limit, and why each suspect is out.

Belongs here: that text, from verdict.json. Does not belong here: deciding anything (discrepancy/decision.py).
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from undertow.discrepancy.words import group_title
from undertow.errors import ConfigError, UndertowError
from undertow.report.gates import asked_words, outcome_words
from undertow.report.numbers import plain_number, short_number
from undertow.report.which_group import groups_meant
from undertow.report.wording import quantity_words, reason_words, rejected_words, values_in_words
from undertow.report.writing import true_minus


def explain_text(folder: Path, group: str = "") -> str:
    """Every group's gates (statistic, value, limit, passed) and rejected suspects; ``group`` takes those that these
    words or conditions fit (`groups_meant`).

    Raises ConfigError where the folder holds no run or no group fits, UndertowError where its verdict.json is spoiled.
    """
    return "\n\n".join(_explained(group_title(one["group"]), one) for one in explained(folder, group))


def explained(folder: Path, group: str = "") -> list[Mapping[str, Any]]:
    """The groups of verdict.json that these words or conditions fit; raises as `explain_text`."""
    groups = _groups(folder)
    chosen = [groups[at] for at in groups_meant(group, [one["group"] for one in groups])]
    if not chosen:
        titles = "; ".join(group_title(one["group"]) for one in groups)
        raise ConfigError(f"{folder} has no group {group!r}; it has {titles}")
    return chosen


def _groups(folder: Path) -> list[Mapping[str, Any]]:
    path = folder / "verdict.json"
    try:
        groups = json.loads(path.read_text(encoding="utf-8"))["groups"]
        if not groups:
            raise ValueError("it has no group")
        for one in groups:
            _explained(group_title(one["group"]), one)
        return list(groups)
    except (OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError) as reason:
        why = (reason.strerror or str(reason)) if isinstance(reason, OSError) else str(reason)
        if isinstance(reason, json.JSONDecodeError):
            why = f"it breaks off or is changed in line {reason.lineno}"
        raise (ConfigError if isinstance(reason, OSError) else UndertowError)(
            f"{folder} holds no finished run with its decisions ({path.name}: {why}); give a folder that undertow "
            "run has written"
        ) from reason


def _explained(title: str, one: Mapping[str, Any]) -> str:
    names = " or ".join(" and ".join(some) for some in (one["verdict"], *one["alternatives"]) if some)
    lines = [f"{title}: {one['status']}{': ' + names if names else ''}"]
    rows = [
        (g["gate"], g["statistic"], _number(g["value"]), _asked(g),
         outcome_words(g["gate"], g["passed"], one["status"], one["verdict"]))
        for g in one["decision"]
    ]  # fmt: skip
    head = ("gate", "statistic", "value", "asked for", "outcome")
    widths = [max(len(row[at]) for row in (head, *rows)) for at in range(len(head))]
    for row in (head, *rows):
        lines.append("  " + "  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip())
    lines += [f"  {g['gate']}: {reason_words(g['because'])}" for g in one["decision"] if g["because"]]
    if one["detectable"]:
        lines.append("  would have been seen, with 90 % power:")
        lines += [f"    {_seen(effect)}" for effect in one["detectable"]]
        lines.append(f"  not testable here: {', '.join(one['not_testable'])}")
    if one["rejected"]:
        lines.append("  not the answer:")
        lines += [f"    {r['name']}: {rejected_words(r['name'], r['because'])}" for r in one["rejected"]]
    return true_minus("\n".join(lines))


def _seen(one: Mapping[str, Any]) -> str:
    """From which size on an effect would have been seen, with the names of its numbers."""
    effect = ", ".join(filter(None, (one["name"], values_in_words(one.get("at", {}), one["unit"]))))
    size = f"{quantity_words(one['name'], one['parameter'])} {plain_number(one['value'], 2)} {one['unit']}".strip()
    return f"{effect}: from {size}, {short_number(100.0 * one['share_of_motion'], 2)} % of the motion"


def _asked(gate: Mapping[str, Any]) -> str:
    value, limit = (math.nan if gate[key] is None else gate[key] for key in ("value", "limit"))
    return f"{asked_words(gate['gate'], value, limit, gate['passed'])} {_number(gate['limit'])}"


def _number(value: float | None) -> str:
    return "-" if value is None else short_number(value)
