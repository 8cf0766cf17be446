"""docs/misuse.md and docs/misuse.json: every case, the exit code, the sentences, and whether that is right."""

from __future__ import annotations

import json
import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from experiments.misuse.answers import Outcome, falsely_green, shortfalls
from experiments.misuse.case import Case
from experiments.misuse.mistakes import FINE, THEMES

LONGEST = 260
"""Characters of a sentence on the page; misuse.json has it whole."""


@dataclass(frozen=True)
class Answer:
    """A case and what the command answered.

    Attributes
    ----------
    name, done, wanted : the case: what the user did, which answers are right.
    code : exit code; None where the command ended by an exception or was stopped.
    said : messages on standard error, then what verdict.json says of each group.
    statuses : status and names by group.
    lacks : what keeps the answer from being right; empty where it is.
    green : whether a mistake ended in green.
    """

    name: str
    done: str
    wanted: str
    code: int | None
    said: tuple[str, ...]
    statuses: tuple[str, ...]
    lacks: tuple[str, ...]
    green: bool

    @classmethod
    def of(cls, case: Case, outcome: Outcome, folder: Path) -> Answer:
        """The answer to `case`; `folder`, where the campaign lay, is left out of what was said."""
        said = [*([outcome.crash] if outcome.crash else []), *outcome.lines]
        said += [str(group.get("because") or group["sentence"]) for group in outcome.groups]
        return cls(
            name=case.name,
            done=case.done,
            wanted="; or ".join(way.words() for way in case.ways),
            code=outcome.code,
            said=tuple(sentence.replace(f"{folder}/", "").replace(str(folder), ".") for sentence in said),
            statuses=tuple(" ".join([g["status"], *g["verdict"]]) for g in outcome.groups),
            lacks=tuple(shortfalls(outcome, case.ways)),
            green=falsely_green(outcome, case.ways),
        )


def table_line(answer: Answer) -> str:
    """One line for the terminal."""
    judged = "right" if not answer.lacks else "GREEN" if answer.green else "wrong"
    what = "; ".join(answer.lacks) if answer.lacks else (answer.said or ("",))[0]
    return f"{judged:6s} {answer.name:28s} {'-' if answer.code is None else answer.code}  {_short(what, 130)}"


def make_page(answers: Sequence[Answer], folder: Path) -> tuple[Path, Path]:
    """Write misuse.md and misuse.json to `folder`; returns their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    page, data = folder / "misuse.md", folder / "misuse.json"
    themes = {theme: [case.name for case in cases] for theme, cases in THEMES.items()}
    themes["Campaigns that are in order"] = [case.name for case in FINE]
    blocks = [_opening(answers)]
    for theme, names in themes.items():
        rows = [answer for answer in answers if answer.name in names]
        blocks += [f"## {theme}", _table(rows), _wanting(rows)] if rows else []
    page.write_text("\n\n".join(block for block in blocks if block) + "\n")
    data.write_text(json.dumps([asdict(answer) for answer in answers], indent=1, ensure_ascii=False) + "\n")
    return page, data


def _opening(answers: Sequence[Answer]) -> str:
    fine = {case.name for case in FINE}
    mistakes = [answer for answer in answers if answer.name not in fine]
    right = sum(not answer.lacks for answer in mistakes)
    kept = sum(not answer.lacks for answer in answers if answer.name in fine)
    return f"""# Ordinary mistakes, and what is said of them

Here one can look up what the command answers to a mistake in a path, a unit, a channel, the config or the test itself.
`python -m experiments misuse` makes this page: small campaigns (exact Eq. 15, `experiments/misuse`), one mistake in
each, `undertow run` on it. A mistake must end in a sentence and exit 1 or 2, in exit 3 with the trial or group
left out alone, or in `cannot_tell`; it must never end in `nothing_missing`.

| | right |
|---|---|
| mistakes | {right} of {len(mistakes)} |
| of them ended in `nothing_missing` | {sum(answer.green for answer in mistakes)} |
| campaigns that are in order | {kept} of {len(answers) - len(mistakes)} |"""


def _table(rows: Sequence[Answer]) -> str:
    head = "| case | what was done | exit | statuses | what was said | right |\n|---|---|---|---|---|---|"
    return "\n".join([head, *(_row(answer) for answer in rows)])


def _row(answer: Answer) -> str:
    said = " / ".join(_short(sentence, LONGEST) for sentence in answer.said[:2]) or "(nothing)"
    cells = (
        f"`{answer.name}`",
        answer.done,
        "none" if answer.code is None else str(answer.code),
        ", ".join(answer.statuses) or "-",
        said,
        "no, green" if answer.green else "no" if answer.lacks else "yes",
    )
    return "| " + " | ".join(cell.replace("|", r"\|") for cell in cells) + " |"


def _wanting(rows: Sequence[Answer]) -> str:
    """What is not right yet, and what would be."""
    wrong = [answer for answer in rows if answer.lacks]
    if not wrong:
        return ""
    lines = [f"- `{answer.name}`: {'; '.join(answer.lacks)}. Right would be: {answer.wanted}." for answer in wrong]
    return "\n".join(["Not right:", "", *lines])


def _short(text: str, longest: int) -> str:
    one_line = re.sub(r"\s+", " ", text)
    return one_line if len(one_line) <= longest else one_line[: longest - 3].rstrip() + "..."
