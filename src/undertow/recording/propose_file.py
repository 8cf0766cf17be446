"""A guess at a whole file: its table, layout and mapping; channels in its other tables are added with their own clocks.

Belongs here: which of a file's tables is the trial. Does not belong here: what columns mean (propose.py), where a table
begins (propose_layout.py), anything that a run relies on.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

import pandas as pd

from undertow.errors import RecordingError
from undertow.recording.excel import EXCEL
from undertow.recording.layout import FileFormat
from undertow.recording.parts import FOLLOWED
from undertow.recording.propose import Proposal, propose_mapping, two_without_names
from undertow.recording.propose_layout import propose_layout
from undertow.recording.propose_response import ResponseProposal, propose_response
from undertow.recording.readers import READERS, read_table, suffix_of, tables_in
from undertow.recording.text import read_text

TABLES_LOOKED_AT = 12
"""Tables of one file that are read: a file with more holds many trials, and its first ones show the layout."""

_FILE_WORDS: Mapping[str, str] = MappingProxyType(
    {
        "acceleration": r"acc|beschl", "velocity": r"vel|gyro|geschw", "displacement": r"disp|weg$",
        "spring_force": r"force|load|cell|kraft|lc\d*$",
    }
)  # fmt: skip
"""How words of file names begin that say which sensor a file is of."""


@dataclass(frozen=True)
class FileProposal:
    """A proposed reading of a file: its ``layout`` and mapping, and the ``table`` that these are of; ``response`` is
    that of a harmonic set, whose mapping in time is empty."""

    layout: FileFormat
    proposal: Proposal
    table: pd.DataFrame
    response: ResponseProposal | None = None

    @property
    def complete(self) -> bool:
        """Whether it says where the body is and when."""
        return self.proposal.time is not None and any(name in self.proposal.channels for name in FOLLOWED)


def propose_file(path: Path) -> FileProposal:
    """The reading that a file's own lines, names and units suggest.

    Raises RecordingError where nothing of it can be read.
    """
    seen: list[FileProposal] = []
    failed: RecordingError | None = None
    for layout in _layouts(path):
        try:
            found = propose_layout(path, layout.variable) if suffix_of(path) in EXCEL else layout
            table = read_table(path, found)
            if (response := propose_response(table, table.attrs.get("units"))) is not None:
                return FileProposal(found, Proposal(None, {}, response.coordinate), table, response)
        except RecordingError as error:
            failed = failed or error
            continue
        seen.append(FileProposal(found, propose_mapping(table, table.attrs.get("units")), table))
    if not seen:
        raise failed or RecordingError(f"{path} holds no table; is it a recording?")
    first = next((one for one in seen if one.complete), None)
    first = first or next((one for one in seen if one.proposal.channels), seen[0])
    return _of_two(_with_others(first, [one for one in seen if one is not first]), len(seen), path)


def _of_two(found: FileProposal, tables: int, path: Path) -> FileProposal:
    """The same of a file's only table with two columns without names (`two_without_names`); the second one is another
    channel where the file's name speaks of it."""
    proposal = None if found.complete or tables > 1 else two_without_names(found.table, channel_of(path) or FOLLOWED[0])
    return found if proposal is None else replace(found, proposal=proposal)


def channel_of(path: Path) -> str:
    """The channel that a part of a file's name speaks of; empty where none or several do.

    >>> channel_of(Path("t01_acc.csv")), channel_of(Path("t01_disp.csv")), channel_of(Path("t01.csv"))
    ('acceleration', 'displacement', '')
    """
    words = re.split(r"[_\-\s.]+", path.name)
    found = {name for name, start in _FILE_WORDS.items() if any(re.match(start, one, re.IGNORECASE) for one in words)}
    return found.pop() if len(found) == 1 else ""


def _layouts(path: Path) -> Sequence[FileFormat]:
    """One layout a table of the file."""
    if path.is_file() and READERS.get(suffix_of(path)) is read_text:
        return [propose_layout(path)]
    names = tables_in(path)[:TABLES_LOOKED_AT]
    if len(names) == 1 and suffix_of(path) != ".mat":
        return [FileFormat()]
    return [FileFormat(variable=name or None) for name in names] or [FileFormat()]


def _with_others(first: FileProposal, others: Sequence[FileProposal]) -> FileProposal:
    """The same with channels that only other tables of the file have."""
    channels, remarks = dict(first.proposal.channels), list(first.proposal.remarks)
    for one in others:
        for name, spec in one.proposal.channels.items():
            if name not in channels and one.proposal.time is not None and one.layout.variable is not None:
                channels[name] = replace(spec, variable=one.layout.variable, time=one.proposal.time)
                remarks.append(f"{name} lies in the table {one.layout.variable!r} with its own clock")
    proposal = replace(first.proposal, channels=channels, remarks=tuple(remarks))
    return replace(first, proposal=proposal)
