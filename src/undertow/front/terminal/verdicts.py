"""A run's verdicts as a table with each status counted, as text of the terminal and as JSON.

Belongs here: the rows, columns and counts of what `undertow run` prints. Does not belong here: how a verdict was
reached (discrepancy/), pages (report/), progress.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from rich import box
from rich.table import Table
from rich.text import Text

from undertow.campaign.driven.run import DrivenFinished
from undertow.campaign.run.folder import DOUBTS_PRINTED, Finished
from undertow.discrepancy.calibration import conditions_of, record_for
from undertow.discrepancy.findings import Findings
from undertow.discrepancy.verdict import Described, is_description
from undertow.discrepancy.words import count, either, group_title, least_sets, percent
from undertow.front.terminal.table import table_text
from undertow.quantities import or_nan
from undertow.report.before_after import BEHIND, errors_of
from undertow.report.blocks import no_gain_words
from undertow.report.verdict_file import group_json, read_verdicts
from undertow.report.wording import STATUS_WORDS, effects_words, in_plain_words, sentence_words
from undertow.report.writing import true_minus
from undertow.uncertainty.growth import grown_words

COLOURS: Mapping[str, str] = {
    "nothing_missing": "green", "explained": "cyan", "present_but_small": "cyan", "cannot_tell": "yellow",
    "not_identifiable": "magenta", "unknown": "red",
}  # fmt: skip
"""Of each status; green is nothing_missing alone."""

REASONS_PRINTED = 3
"""Groups that cannot be told whose reason is printed without ``verbose``."""

CERTAIN = 0.99
"""From here on a probability is printed as "over 99 %": calibration says no more."""

DESCRIBED = "described"
"""The cell of a group that is explained by what leaves more than noise."""

Entry = Mapping[str, Any]
"""A group's entry of verdict.json."""


def counted(statuses: Mapping[str, int], described: int = 0) -> str:
    """How many groups have each status, the most frequent first.

    >>> counted({"explained": 3, "nothing_missing": 5})
    '8 groups: 5 nothing missing, 3 explained'
    >>> counted({"explained": 3}, described=1)
    '3 groups: 3 explained (1 of them described: more than noise is left)'
    """
    more = f" ({described} of them {DESCRIBED}: more than noise is left)" if described else ""
    words = [
        f"{number} {STATUS_WORDS[status].removesuffix(' with')}{more if status == 'explained' else ''}"
        for status, number in sorted(statuses.items(), key=lambda pair: -pair[1])
    ]
    return f"{count(sum(statuses.values()), 'group')}: {', '.join(words)}"


def verdict_table(entries: Sequence[Entry]) -> Table:
    """One row a group: status, what is named, free-run error before and after (of unseen trials where the repaired
    equation has one, as on the page; else "fitted"), what repeating gives, how sure."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for name in ("group", "verdict", "what is missing"):
        table.add_column(name, overflow="fold")
    for name in ("free-run error", "repaired", "repeating gives", "probability"):
        table.add_column(name, justify="right")
    for one in entries:
        table.add_row(
            Text(group_title(one["group"])),
            Text(status_said(one), style=COLOURS[one["status"]]),
            Text(missing_words(one)), *errors_words(one), percent(or_nan(one["repeatability_nrmse"])),
            probability_words(one),
        )  # fmt: skip
    return table


def status_said(entry: Entry) -> str:
    """A group's status in words; a name that leaves more than noise describes.

    >>> status_said({"status": "explained", "decision": [{"gate": "left_above_noise", "passed": False}]})
    'described'
    """
    described = is_description(entry["status"], {gate["gate"]: gate["passed"] for gate in entry.get("decision", ())})
    if described and entry["status"] == "explained":
        return DESCRIBED
    return STATUS_WORDS[entry["status"]].removesuffix(" with")


def errors_words(entry: Entry) -> tuple[str, str]:
    """A group's free-run error as prescribed and repaired.

    >>> errors_words({"baseline": {"nrmse": 0.4, "held_out_nrmse": 0.5}, "augmented": {"held_out_nrmse": 0.06}})
    ('50 %', '6.0 %')
    >>> errors_words({"baseline": {"nrmse": 0.4}, "augmented": {"nrmse": 0.06}})
    ('40 %', '6.0 % fitted')
    >>> both = {"nrmse": 0.04, "cross_validated_nrmse": 0.05}
    >>> errors_words({"baseline": {"nrmse": 0.4, "cross_validated_nrmse": 0.5}, "augmented": both})
    ('50 %', '5.0 % left out')
    >>> errors_words({"baseline": {"nrmse": 0.4, "held_out_nrmse": 0.5}, "augmented": None})
    ('40 %', '-')
    """
    before, after = (
        one and Described(
            or_nan(one.get("nrmse")), or_nan(one.get("held_out_nrmse")),
            cross_validated_nrmse=or_nan(one.get("cross_validated_nrmse")),
        ) for one in (entry["baseline"], entry["augmented"])
    )  # fmt: skip
    errors = errors_of(before, after)
    if errors is None:
        return percent(before.nrmse), "-"
    return percent(errors[0]), f"{percent(errors[1])} {BEHIND[errors[2]]}".rstrip()


def missing_words(entry: Entry) -> str:
    """What is named, and the rivals that cannot be excluded.

    >>> missing_words({"verdict": ["hidden_resonator"], "alternatives": [["relaxation"]]})
    'hidden resonator or relaxation'
    """
    sets = [names for names in (entry["verdict"], *entry["alternatives"]) if names]
    return either([effects_words(names) for names in least_sets(sets)]) if sets else "-"


def probability_words(entry: Entry) -> str:
    """How probable what is said is (of ``not_identifiable`` that it is one of its names), or of few such verdicts how
    many held; "-" where none is calibrated, and of ``cannot_tell``, which claims nothing.

    >>> [probability_words({"status": "explained", "confidence": p}) for p in (0.973, 0.9999, None)]
    ['97 %', 'over 99 %', '-']
    """
    sure = or_nan(entry["confidence"])
    if not math.isfinite(sure) or entry["status"] == "cannot_tell":
        return "-"
    record = record_for(entry["status"], entry.get("verdict", ()), conditions_of(entry.get("decision", ())))
    if record is not None and record.few:
        return record.few
    return "over 99 %" if sure > CERTAIN else percent(sure)


def run_text(finished: Finished | DrivenFinished, width: int = 0, colour: bool = False, verbose: bool = False) -> str:
    """What `undertow run` prints: table of verdicts, counts, why a repaired error is the larger one, the sentence over
    all groups, doubts, where the page is. Of groups that cannot be told the first few sentences say why.

    ``verbose`` adds every shown group's sentence, why its standard errors are larger than the fit's own, and every
    doubt; ``width`` is the terminal's (0: none).
    """
    if isinstance(finished, DrivenFinished):
        entries = read_verdicts(finished.folder)["groups"]
        table, number = table_text(verdict_table(entries), width, colour), Counter(one["status"] for one in entries)
        why = cannot_tell_lines([one["sentence"] for one in entries if one["status"] == "cannot_tell"])
        why = [one for one in why if one not in finished.sentence]
        return "\n".join([*map(true_minus, (table, counted(number), *why, finished.sentence)), last_line(finished)])
    shown, extent, doubts = finished.findings.groups, finished.extent, finished.findings.doubts
    entries = [group_json(g.verdict) for g in shown]
    lines = [table_text(verdict_table(entries), width, colour)]
    if more := extent.groups - len(shown):
        lines.append(f"{count(more, 'more group')}: {finished.folder / 'verdict.json'}")
    described = sum(status_said(one) == DESCRIBED for one in entries)
    lines.append(counted(extent.statuses, described))
    lines += no_gain_lines(finished.findings)
    said = {g.label: sentence_words(g.verdict.sentence, g.label) for g in shown}
    if not verbose:
        lines += cannot_tell_lines([said[g.label] for g in shown if g.verdict.status == "cannot_tell"])
    if verbose:
        lines += said.values()
        lines += [f"{g.label}: {in_plain_words(words)}" for g in shown for words in grown_words(g.grown)]
    lines.append(in_plain_words(finished.findings.across_groups))
    listed = doubts if verbose else doubts[:DOUBTS_PRINTED]
    lines += [f"doubt: {one}" for one in listed]
    if more := len(doubts) - len(listed):
        lines.append(f"{count(more, 'more doubt')}: {finished.told}")
    return "\n".join([*map(true_minus, lines), last_line(finished)])


def no_gain_lines(findings: Findings) -> list[str]:
    """A sentence for each group whose repaired equation has the larger free-run error: why."""
    return [f"{g.label}: {said}" for g in findings.groups if (said := no_gain_words(findings, g))]


def cannot_tell_lines(sentences: Sequence[str]) -> list[str]:
    """The first `REASONS_PRINTED` sentences of groups that cannot be told, and how many more there are.

    >>> cannot_tell_lines(["a: cannot tell, because x."] * 4)[-1]
    '1 more group that cannot be told: -v prints each reason'
    """
    more = len(sentences) - REASONS_PRINTED
    rest = [f"{count(more, 'more group')} that cannot be told: -v prints each reason"] if more > 0 else []
    return [*sentences[:REASONS_PRINTED], *rest]


def last_line(finished: Finished | DrivenFinished) -> str:
    """Where the page is (without one, verdict.json): the last line of `undertow run`, the only one with ``--quiet``."""
    return f"report: {finished.told}"


def run_json(finished: Finished | DrivenFinished) -> dict[str, Any]:
    """verdict.json of the run with its folder, page, failed trials, contradictions and doubts."""
    return {
        **read_verdicts(finished.folder),
        "folder": str(finished.folder),
        "report": str(finished.told),
        "failed": [{"trial": one.name, "because": one.reason} for one in finished.failed],
        "contradicted": list(finished.contradicted),
        "doubts": [] if isinstance(finished, DrivenFinished) else list(finished.findings.doubts),
    }
