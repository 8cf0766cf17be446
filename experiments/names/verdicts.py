"""A campaign judged: the package run on its folder as `undertow run` runs it, and the verdict as rows.

The only module here that imports the package. Report, decay, SINDy and Methods 1 and 2 are left out: no verdict
depends on them. Does not belong here: which campaigns (studies.py).
"""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

from experiments.names.effects import verdict_name
from experiments.names.folder import View, period, write
from experiments.names.scenes import Campaign
from undertow.campaign.config import load
from undertow.campaign.run import read_and_condition, run
from undertow.discrepancy.verdict import Verdict
from undertow.errors import UndertowError

Row = dict[str, str | float | int]


def judge(campaign: Campaign, view: View | None = None) -> Row:
    """What is said of a campaign: ``dry`` and ``wet`` names (a plus between them, a bar between groups that differ),
    rivals, confidence (the lowest wet one), status, errors before and after, seconds of work; ``failed`` says why where
    there is no verdict."""
    started = time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        try:
            config = write(campaign, Path(folder), view)
            if view is not None and view.cycles:
                write(campaign, Path(folder), view, _ends(campaign, config, view.cycles))
            findings = run(load(config), jobs=1)
        except UndertowError as reason:
            return {"failed": str(reason).replace("\n", " ")[:200]}
    dry = [g.verdict for g in findings.groups if g.dry]
    wet = [g.verdict for g in findings.groups if not g.dry]
    sizes = [v.baseline.nrmse for v in wet]
    after = [v.augmented.nrmse for v in wet if v.augmented is not None]
    return {
        "dry": _different([_said(v) for v in dry]),
        "wet": _different([_said(v) for v in wet]),
        "rivals": _different(["; ".join("+".join(a) for a in v.alternatives) for v in wet]),
        "status": _different([v.status for v in wet]),
        "dry_status": _different([v.status for v in dry]),
        "p_value": _of_the_campaign([*dry, *wet]),
        "confidence": round(min((v.confidence for v in wet), default=float("nan")), 4),
        "nrmse": round(max(sizes, default=float("nan")), 4),
        "augmented": round(max(after), 4) if after else "",
        "repeatability": round(max((v.repeatability_nrmse for v in wet), default=float("nan")), 4),
        "trials_failed": len(findings.failed),
        "cpu_s": round(time.process_time() - started, 1),
        "failed": "",
    }


def _ends(campaign: Campaign, config: Path, cycles: float) -> dict[str, float]:
    """Ends of all windows, so many periods after (before) where they are by themselves, s."""
    motions = {m.name: m for m in read_and_condition(load(config)).motions}
    trials = {t.file: t for t in campaign.plan.trials() if Path(t.file).stem in motions}
    return {f: motions[Path(f).stem].window.end_s + cycles * period(campaign.plan, t) for f, t in trials.items()}


def _said(verdict: Verdict) -> str:
    return "+".join(dict.fromkeys(verdict.verdict))


def _of_the_campaign(verdicts: Sequence[Verdict]) -> str:
    """The campaign's p-value from those of its levels (groups of one water have one): how often the smallest of so many
    would be as small where nothing is missing; empty where no level was held against its null."""
    found = {v.p_value for v in verdicts if math.isfinite(v.p_value)}
    return f"{-math.expm1(len(found) * math.log1p(-min(found))):.4g}" if found and min(found) < 1.0 else ""


def _different(texts: list[str]) -> str:
    return "|".join(dict.fromkeys(texts))


def names_in(said: str) -> frozenset[str]:
    """Every name in a row's text.

    >>> sorted(names_in("relaxation|hidden_resonator+unknown"))
    ['hidden_resonator', 'relaxation', 'unknown']
    """
    return frozenset(name.strip() for part in said.split("|") for one in part.split(";") for name in one.split("+")
                     if name.strip())  # fmt: skip


def outcome(row: Mapping[str, object]) -> str:
    """How a row's verdict stands to its truth, in one word.

    right: exactly the hidden names; rival: all of them, if rivals named beside the answer count; more: all of them and
    another; part: one of two and no other; dry: no name in the wet groups, but the dry trials name it; unknown: only
    that something is missing; nothing: nothing said; wrong: another name and not the hidden one; failed: no verdict.
    """
    if row.get("failed"):
        return "failed"
    truth = frozenset(verdict_name(n) for n in str(row["hidden"]).split("+") if n)
    said = names_in(str(row["wet"]))
    named = said - {"unknown"}
    if named == truth and (truth or not said):
        return "right"
    if not named and truth and truth <= names_in(str(row["dry"])):
        return "dry"
    if not said:
        return "nothing"
    if not named:
        return "unknown"
    if truth and truth <= named:
        return "more"
    if truth and truth <= named | names_in(str(row["rivals"])):
        return "rival"
    return "part" if named < truth else "wrong"
