"""How a file that `undertow.read` is given is laid out, by the file itself.

Belongs here: which of its tables is meant, where that begins. Does not belong here: columns (columns.py), the guess
itself (recording/propose_layout.py).
"""

from __future__ import annotations

from pathlib import Path

from undertow.errors import RecordingError
from undertow.recording.excel import EXCEL
from undertow.recording.layout import FileFormat
from undertow.recording.propose_layout import propose_layout
from undertow.recording.readers import READERS, suffix_of, tables_in
from undertow.recording.text import read_text

TABLES_SHOWN = 8
"""Tables of a file named in a message at most."""


def layout_of(path: Path, variable: str | None) -> FileFormat:
    """The layout that a text file's own lines or a sheet's rows show; of another file the table asked for, or the only
    structure.

    Raises RecordingError where a text is asked for a table, or a file of several structures for none.
    """
    if path.is_file() and READERS.get(suffix_of(path)) is read_text:
        if variable is not None:
            raise RecordingError(f"variable is {variable!r}, but {path} is text with one table; leave variable out")
        return propose_layout(path)
    if path.is_file() and suffix_of(path) in EXCEL:
        return _sheet(path, variable)
    if variable is None and suffix_of(path) == ".mat":
        inner = tables_in(path)
        if len(inner) > 1 and "" not in inner:
            listed = ", ".join(map(repr, inner[:TABLES_SHOWN])) + (" and others" if len(inner) > TABLES_SHOWN else "")
            raise RecordingError(f"{path} holds the tables {listed}; say which, as in variable={inner[0]!r}")
        variable = (inner[0] or None) if inner else None
    return FileFormat(variable=variable)


def _sheet(path: Path, variable: str | None) -> FileFormat:
    """The layout that a sheet's own rows show: of ``variable``, or of the first that holds a table of numbers."""
    failed: RecordingError | None = None
    for name in tables_in(path) if variable is None else (variable,):
        try:
            return propose_layout(path, name or None)
        except RecordingError as error:
            failed = failed or error
    raise failed or RecordingError(f"{path} holds no sheet; is it a recording?")
