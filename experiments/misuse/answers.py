"""What the command ended with, and which answers are right: a sentence and an exit code, or `cannot_tell`; never green.

A `Way` is one acceptable answer; a case has one or several, because some mistakes may rightly be refused before the
fit or found after it. How the command is called belongs to `running`.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

GREEN = "nothing_missing"
UNDECIDED = frozenset({"cannot_tell"})
NOT_GREEN = frozenset({"cannot_tell", "unknown", "not_identifiable", "present_but_small"})
"""Statuses that say no name and are not green: right where an effect was planted that no suspect has."""

PROGRESS = r".*: \d+ of \d+(, .*)?"
"""A line of progress on the terminal, whole."""

GREEN_WORDS = "nothing is missing"
GREEN_ON_THE_PAGE = 'class="tag good"'
SENTENCES_IN_VERDICT = ("because", "sentence")

Group = Mapping[str, Any]
Where = Mapping[str, object]


@dataclass(frozen=True)
class Outcome:
    """What one run of the command left.

    Attributes
    ----------
    code : exit code; None where it ended by an exception or out of time.
    out, err : what stood on the terminal.
    verdict : verdict.json, None where there is none.
    page : report.html, empty where there is none.
    crash : the exception, or that time ran out; empty otherwise.
    warnings : Python warnings that would have reached the terminal.
    seconds : CPU time.
    """

    code: int | None
    out: str = ""
    err: str = ""
    verdict: Mapping[str, Any] | None = None
    page: str = ""
    crash: str = ""
    warnings: tuple[str, ...] = ()
    seconds: float = 0.0

    @property
    def groups(self) -> list[Group]:
        """The groups of verdict.json."""
        return list(self.verdict["groups"]) if self.verdict else []

    @property
    def lines(self) -> list[str]:
        """Messages on the terminal: standard error without the lines of progress."""
        return [line for line in self.err.splitlines() if line.strip() and not re.fullmatch(PROGRESS, line)]

    def unfit(self) -> list[str]:
        """What is wrong with this ending whatever was asked for."""
        wrong = [self.crash] if self.crash else []
        wrong += [f"a Python warning: {text}" for text in self.warnings]
        said = self.err + self.out
        wrong += ["a Python dictionary or exception in a message"] if re.search(r"\{'|Traceback|Error\(", said) else []
        wrong += [
            f"{_name(group)}: cannot_tell without a reason"
            for group in self.groups
            if group["status"] == "cannot_tell" and not group.get("because")
        ]
        return wrong


@dataclass(frozen=True)
class Way(ABC):
    """One acceptable answer. `says` are regular expressions that one and the same sentence must match, all of them."""

    says: tuple[str, ...]
    codes: frozenset[int]

    @abstractmethod
    def lacks(self, outcome: Outcome) -> list[str]:
        """What of this answer the outcome lacks; empty where it is this answer."""

    @abstractmethod
    def words(self) -> str:
        """This answer in words, for the page."""

    def concerns(self, group: Group) -> bool:
        """Whether green would be wrong for this group."""
        return True

    def _code(self, outcome: Outcome) -> list[str]:
        return [] if outcome.code in self.codes else [f"exit {outcome.code}, not {_either(self.codes)}"]

    def _said(self, sentences: Iterable[str]) -> list[str]:
        if any(all(re.search(part, sentence, re.IGNORECASE) for part in self.says) for sentence in sentences):
            return []
        return [f"no sentence says {' and '.join(self.says)}"]

    def _about(self) -> str:
        return ", a sentence with " + " and ".join(f"`{part}`" for part in self.says) if self.says else ""


@dataclass(frozen=True)
class Stop(Way):
    """The run stops with a sentence on standard error, before anything is fitted."""

    codes: frozenset[int] = frozenset({2})

    def lacks(self, outcome: Outcome) -> list[str]:
        return self._code(outcome) + self._said(outcome.lines)

    def words(self) -> str:
        return f"exit {_either(self.codes)}{self._about()}"


@dataclass(frozen=True)
class TrialsAlone(Way):
    """These trials are listed with their reason and left out; every other trial is in a group that has a verdict."""

    trials: tuple[str, ...] = ()
    others: int = 0
    codes: frozenset[int] = frozenset({3})

    def lacks(self, outcome: Outcome) -> list[str]:
        used = [_stem(trial) for group in outcome.groups for trial in group["trials"]]
        lacking = self._code(outcome)
        for trial in self.trials:
            lacking += self._said(line for line in outcome.lines if trial in line)
            lacking += [f"{trial} is in a group all the same"] if trial in used else []
        return lacking + ([] if len(used) == self.others else [f"{len(used)} of {self.others} other trials are done"])

    def words(self) -> str:
        return f"exit 3, {', '.join(self.trials)} left out alone{self._about()}"

    def concerns(self, group: Group) -> bool:
        return any(_stem(trial) in self.trials for trial in group["trials"])


@dataclass(frozen=True)
class Groups(Way):
    """The groups concerned have one of the statuses; the others are done. `where` is empty where all are concerned.

    `may_be_absent`: a group that could not be fitted at all may be missing from verdict.json when the exit code is 3
    and the sentence stands on standard error.
    """

    codes: frozenset[int] = frozenset({0})
    where: Where = field(default_factory=dict)
    statuses: frozenset[str] = UNDECIDED
    names: tuple[str, ...] = ()
    done: int = 1
    may_be_absent: bool = False

    def lacks(self, outcome: Outcome) -> list[str]:
        concerned = [group for group in outcome.groups if self.concerns(group)]
        lacking = self._code(outcome)
        if not concerned and not (self.may_be_absent and outcome.code == 3):
            lacking.append("no verdict on the group concerned")
        for group in concerned:
            lacking += self._status(group)
        if len(outcome.groups) - len(concerned) < self.done and self.where:
            lacking.append("other groups are not done")
        in_verdict = [str(group.get(key) or "") for group in concerned for key in SENTENCES_IN_VERDICT]
        lacking += self._said([*outcome.lines, *in_verdict])
        return lacking + ([] if self.where else _green_words(outcome))

    def _status(self, group: Group) -> list[str]:
        if group["status"] in self.statuses or (group["status"] == "explained" and group["verdict"] == [*self.names]):
            return []
        return [f"{_name(group)}: {group['status']} {', '.join(group['verdict'])}".rstrip()]

    def words(self) -> str:
        which = _conditions(self.where) or "every group"
        named = f" or explained by {' and '.join(self.names)}" if self.names else ""
        return f"exit {_either(self.codes)}, {which}: {_either(self.statuses)}{named}{self._about()}"

    def concerns(self, group: Group) -> bool:
        return matches(group, self.where)


@dataclass(frozen=True)
class Right(Way):
    """The campaign is in order or was understood: green everywhere but where `explained` says, and right numbers.

    `explained` : (where, names). `numbers` : (where, parameter, true value, or
    None where the equation must not have it). `held_out` : trials that were not fitted.
    """

    says: tuple[str, ...] = ()
    codes: frozenset[int] = frozenset({0})
    groups: int = 2
    explained: tuple[tuple[Where, tuple[str, ...]], ...] = ()
    numbers: tuple[tuple[Where, str, float | None], ...] = ()
    held_out: tuple[str, ...] = ()

    def lacks(self, outcome: Outcome) -> list[str]:
        lacking = self._code(outcome)
        if len(outcome.groups) != self.groups:
            lacking.append(f"{len(outcome.groups)} groups, not {self.groups}")
        for group in outcome.groups:
            names = next((list(names) for where, names in self.explained if matches(group, where)), [])
            wanted = ("explained", names) if names else (GREEN, [])
            if (group["status"], group["verdict"]) != wanted:
                found = f"{group['status']} {', '.join(group['verdict'])}".rstrip()
                lacking.append(f"{_name(group)}: {found} (error {group['baseline']['nrmse']})")
        for where, parameter, truth in self.numbers:
            there = [group for group in outcome.groups if matches(group, where)]
            lacking += [] if there else [f"no group with {_conditions(where)}"]
            lacking += [text for group in there for text in _wrong_number(group, parameter, truth)]
        unseen = sorted(_stem(trial) for group in outcome.groups for trial in group["held_out"])
        if self.held_out and unseen != sorted(self.held_out):
            lacking.append(f"held out: {', '.join(unseen) or 'none'}, not {', '.join(self.held_out)}")
        return lacking

    def words(self) -> str:
        told = [f"{_conditions(where)} explained by {' and '.join(names)}" for where, names in self.explained]
        return "; ".join(["exit 0, right numbers", *told, "nothing_missing elsewhere" if told else "nothing_missing"])

    def concerns(self, group: Group) -> bool:
        return False


def shortfalls(outcome: Outcome, ways: tuple[Way, ...]) -> list[str]:
    """What keeps the outcome from being right: empty, or what the nearest acceptable answer lacks."""
    nearest = min((way.lacks(outcome) for way in ways), key=len)
    return outcome.unfit() + nearest


def falsely_green(outcome: Outcome, ways: tuple[Way, ...]) -> bool:
    """Whether a mistake ended in green: the answer is not right and a group that it concerns is `nothing_missing`."""
    refusals = [way for way in ways if not isinstance(way, Right)]
    if not refusals or not shortfalls(outcome, ways):
        return False
    green = [group for group in outcome.groups if group["status"] == GREEN]
    return any(all(way.concerns(group) for way in refusals) for group in green)


def _wrong_number(group: Group, parameter: str, truth: float | None) -> list[str]:
    """Whether a parameter is farther from the truth than four standard errors and 2 %."""
    version = group["baseline"] if group["status"] == GREEN else group["augmented"]
    found = ((version or {}).get("parameters") or {}).get(parameter)
    if truth is None or found is None:
        return [] if truth is None and found is None else [f"{_name(group)}: {parameter} {found}, not {truth}"]
    near = abs(found["value"] - truth) <= 4.0 * (found["stderr"] or 0.0) + 0.02 * abs(truth)
    return [] if near else [f"{_name(group)}: {parameter} {found['value']:.4g}, not {truth:.4g}"]


def matches(group: Group, where: Where) -> bool:
    """Whether a group has these conditions; numbers are compared as numbers."""
    return all(_same(group["group"].get(key), value) for key, value in where.items())


def _same(one: object, other: object) -> bool:
    try:
        return abs(float(str(one)) - float(str(other))) < 1e-6
    except ValueError:
        return str(one) == str(other)


def _green_words(outcome: Outcome) -> list[str]:
    """Green on the terminal or on the page, where no group may be green."""
    wrong = ["the terminal says that nothing is missing"] if GREEN_WORDS in outcome.out else []
    return wrong + (["the page shows green"] if GREEN_ON_THE_PAGE in outcome.page else [])


def _name(group: Group) -> str:
    return _conditions(group["group"]) or "all trials"


def _conditions(where: Where) -> str:
    return ", ".join(f"{key} {value}" for key, value in where.items())


def _stem(trial: str) -> str:
    return re.sub(r"(\.csv)?(\.gz)?$", "", trial)


def _either(choices: Iterable[object]) -> str:
    return " or ".join(str(choice) for choice in sorted(choices, key=str))
