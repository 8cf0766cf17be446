"""How much one recording may take: what a file states or unfolds to is held against this before anything is read.

Files are made elsewhere; a few bytes can unfold to gigabytes, or state sizes that no machine has. A laboratory whose
honest recordings are larger raises the limit (``recordings.limits``).

Belongs here: the limits and their sentences. Does not belong here: how a format states its size (its reader).
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from undertow.errors import RecordingError

MEGABYTES = 256.0
"""What the part of a recording that is asked for may unfold to, 10^6 bytes: an hour of 8 channels at 1 kHz as doubles;
reading and conditioning need some ten times as much, and a laptop has 8 GB."""

COLUMNS = 4096
"""Columns of one table: the widest loggers have some hundred channels; a spreadsheet ends at 16,384."""

LONGEST_LINE = 1 << 20
"""Characters of a line of text: a row of `COLUMNS` numbers of 17 digits takes 100,000."""


@dataclass(frozen=True)
class Limits:
    """What a recording may take at most; ``megabytes`` are 10^6 bytes."""

    megabytes: float = MEGABYTES
    columns: int = COLUMNS

    @property
    def bytes(self) -> int:
        """The same as ``megabytes`` in bytes."""
        return int(self.megabytes * 1e6)

    def allow_bytes(self, path: Path, needed: float, what: str) -> None:
        """RecordingError where ``what`` would take more than ``megabytes``; ``needed`` is in bytes."""
        if needed > self.bytes:
            raise RecordingError(
                f"{path}: {what} would take {needed / 1e6:.4g} MB, recordings.limits.megabytes allows "
                f"{self.megabytes:g}; is it the right file? raise the limit if it is"
            )

    def allow_unfolded(self, path: Path, before: int, size: int) -> None:
        """RecordingError where what was unfolded ``before`` and ``size`` bytes more are too much."""
        if before + size > self.bytes:
            raise RecordingError(
                f"{path} unfolds to more than the {self.megabytes:g} MB that recordings.limits.megabytes allows; is it "
                "the right file? raise the limit if it is"
            )

    def allow_columns(self, path: Path, count: int) -> None:
        """RecordingError where a table has more columns than ``columns``."""
        if count > self.columns:
            raise RecordingError(
                f"{path} has {count} columns, recordings.limits.columns allows {self.columns}; is it the right file, "
                "separator or orientation? raise the limit if it is"
            )


LIMITS = Limits()
"""What holds where a config says nothing."""
