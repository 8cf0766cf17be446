"""Files of a run folder that somebody changed: what does not have a run's shape ends in a sentence.

Belongs here: that sentence. Does not belong here: what the files hold (verdict_file.py), texts that are no JSON.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from undertow.errors import ConfigError, UndertowError


def must_be_there(runs: Sequence[Path]) -> None:
    """ConfigError where one of these run folders is not there."""
    gone = next((run for run in runs if not run.exists()), None)
    if gone is not None:
        raise ConfigError(f"run folder {gone} is not there; give the one that `undertow run` printed in its last line")


@contextmanager
def as_runs_write_them(runs: Sequence[Path], file: str = "verdict.json") -> Iterator[None]:
    """Within the block that file of these run folders is read and used, nothing else.

    Raises UndertowError where a value is missing or of another kind than a run writes, as `must_be_there`.
    """
    must_be_there(runs)
    try:
        yield
    except UndertowError:
        raise
    except (LookupError, TypeError, AttributeError, ValueError) as reason:
        named = ", ".join(str(run) for run in runs)
        raise UndertowError(
            f"run folder {named}: {file} is not as a run writes it ({type(reason).__name__}: {reason}); was it "
            "changed? run again"
        ) from reason
