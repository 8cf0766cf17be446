"""The command line called in this process, for tests of what it says and of the code it ends with."""

from __future__ import annotations

from typing import NamedTuple

import pytest

from undertow.cli import main


class Said(NamedTuple):
    """What a command ended with: exit code, standard output, standard error."""

    code: int
    out: str
    err: str


def undertow(capsys: pytest.CaptureFixture[str], *words: object) -> Said:
    """Run ``undertow words...``; it must end with an exit code and never show a traceback."""
    capsys.readouterr()
    with pytest.raises(SystemExit, match=r"^\d*$") as end:
        main([str(word) for word in words])
    captured = capsys.readouterr()
    assert "Traceback" not in captured.err
    assert "Traceback" not in captured.out
    return Said(int(end.value.code or 0), captured.out, captured.err)
