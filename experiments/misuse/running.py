"""A case through the real command, in this process: files on disk, `undertow run`, what it left.

Each case has a time limit; whatever the command raises beside SystemExit is kept as a crash, not raised.
"""

from __future__ import annotations

import contextlib
import io
import json
import shutil
import signal
import time
import traceback
import warnings
from pathlib import Path
from types import FrameType

from experiments.misuse.answers import Outcome
from experiments.misuse.campaigns import write
from experiments.misuse.case import Case
from undertow.cli import main

LIMIT_S = 60.0
"""CPU time after which a case counts as not ended; an ordinary one takes a tenth of it."""


AGAIN_S = 1.0
"""Once out of time, a case is stopped again after this, should something have caught the first stop."""


class OutOfTimeError(BaseException):
    """The time limit; no handler of ordinary exceptions swallows it."""


def run_case(case: Case, folder: Path, limit_s: float = LIMIT_S) -> Outcome:
    """Write the case's campaign to `folder` and run the command on it, for at most `limit_s` s of CPU time."""
    shutil.rmtree(folder / "run", ignore_errors=True)  # what an earlier run said is no answer to this one
    draft = case.draft()
    config = write(draft, folder)
    words = ["run", str(config), "--jobs", "1", *(word.format(folder=folder) for word in draft.words)]
    if "--out" not in words:
        words += ["--out", str(folder / "run")]
    out, err = io.StringIO(), io.StringIO()
    began = time.process_time()
    code, crash, limit = None, "", _Limit(limit_s)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("default")
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                with limit:
                    main(words)
                code = 0
            except SystemExit as end:
                code = int(end.code or 0)
            except OutOfTimeError:
                pass
            except Exception as error:  # noqa: BLE001 - whatever comes out of the command is the finding
                crash = f"traceback: {_last_line(error)}"
    if limit.passed:
        crash = f"not ended after {limit_s:.0f} s"
    return Outcome(
        code,
        out.getvalue(),
        err.getvalue(),
        verdict=_verdict(folder / "run"),
        page=_text(folder / "run" / "report.html"),
        crash=crash,
        warnings=tuple(sorted({f"{w.category.__name__}: {w.message}" for w in caught})),
        seconds=time.process_time() - began,
    )


class _Limit:
    """Raises OutOfTimeError in its block after so many seconds of this process's CPU time; `passed` says that it did.

    Compiled code may turn what the signal raises into another error, so that `passed` decides, not the exception.
    """

    def __init__(self, seconds: float) -> None:
        self.seconds, self.passed = seconds, False

    def __enter__(self) -> None:
        self._before = signal.signal(signal.SIGPROF, self._stop)
        signal.setitimer(signal.ITIMER_PROF, self.seconds, AGAIN_S)

    def __exit__(self, *_: object) -> None:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, self._before)

    def _stop(self, _number: int, _frame: FrameType | None) -> None:
        self.passed = True
        raise OutOfTimeError


def _last_line(error: Exception) -> str:
    return traceback.format_exception_only(error)[-1].strip()


def _verdict(run: Path) -> dict[str, object] | None:
    text = _text(run / "verdict.json")
    return json.loads(text) if text else None


def _text(path: Path) -> str:
    return path.read_text() if path.is_file() else ""
