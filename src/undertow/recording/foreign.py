"""Other people's parsers: found or named with the extra to install, and whatever they raise becomes one sentence.

Belongs here: that boundary, once. Does not belong here: what is read through it (excel.py, labview.py, ...).
"""

from __future__ import annotations

import gc
import importlib
import logging
import sys
import traceback
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from undertow.errors import RecordingError, UndertowError

LONGEST_REASON = 120
"""Characters of a parser's own words in a sentence: some quote the whole file."""


def library(module: str, package: str, extra: str, path: Path) -> Any:
    """A module that comes with an extra; RecordingError naming the extra where it is not installed.

    >>> library("nowhere", "Nowhere", "labs", Path("r.now"))
    Traceback (most recent call last):
    undertow.errors.RecordingError: r.now is read through Nowhere, which is not installed; pip install 'undertow[labs]'
    """
    try:
        return importlib.import_module(module)
    except ImportError as error:
        raise RecordingError(
            f"{path} is read through {package}, which is not installed; pip install 'undertow[{extra}]'"
        ) from error


@contextmanager
def parsing(path: Path, kind: str, advice: str, cycles: bool = False) -> Iterator[None]:
    """A block in which a library reads ``path``: any error becomes a RecordingError, its warnings are not shown.

    ``cycles`` says that its half-made readers refer to themselves and end only when memory is searched for such.

    Damaged bytes make parsers raise anything, some of them bare Exceptions, so that nothing narrower can be caught.
    """
    loud, unraisable = logging.root.manager.disable, sys.unraisablehook
    logging.disable(logging.CRITICAL)
    sys.unraisablehook = lambda lost: None  # half-made readers complain when they are thrown away
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except UndertowError:
        raise
    except MemoryError as error:
        raise RecordingError(
            f"{path} asks for more memory than there is; is it damaged? {advice}, or lower recordings.limits.megabytes"
        ) from error
    except Exception as error:
        said = reason(error)
        _throw_away(error, cycles)
        raise RecordingError(f"{path} is no readable {kind} ({said}); {advice}") from error
    finally:
        logging.disable(loud)
        sys.unraisablehook = unraisable


def _throw_away(error: BaseException, cycles: bool) -> None:
    """Let go of what a failed parser held, while its complaints are not shown."""
    at: BaseException | None = error
    while at is not None:
        traceback.clear_frames(at.__traceback__)
        at = at.__context__
    if cycles:
        gc.collect()


def reason(error: BaseException) -> str:
    """A parser's complaint in a few words on one line; its kind where it says nothing.

    >>> reason(ValueError("bad header\\n at byte 3")), reason(KeyError())
    ('bad header', 'KeyError')
    """
    said = " ".join((str(error).strip().splitlines() or [""])[0].split())
    text = said if len(said) > 2 else f"{type(error).__name__} {said}".strip()
    return text if len(text) <= LONGEST_REASON else text[: LONGEST_REASON - 3] + "..."
