"""The errors a user can meet. Every message names the quantity, the value, the rule and the next step."""

from __future__ import annotations

from collections.abc import Sized
from dataclasses import dataclass
from reprlib import Repr


class UndertowError(ValueError):
    """Base of every error that undertow raises on purpose; the command line prints its text alone."""


class ConfigError(UndertowError):
    """The configuration is wrong: an unknown key, a value out of range, a path that is not there."""


class RecordingError(UndertowError):
    """A recording cannot be used as it is: missing column, wrong unit, NaN, no release."""


class MisnamedError(RecordingError):
    """The config names what a recording does not have (a column, a variable), or states a rate that it contradicts."""


@dataclass(frozen=True)
class RangeEnd:
    """One end of a sensor's range, upper or lower: the ``value`` there, and how near (``band``) another is the same."""

    value: float
    upper: bool
    band: float


class ClippedError(RecordingError):
    """A channel is cut off at the end of its sensor's range: what it says there is not what happened. ``channel``
    names it, ``ends`` are where it is seen to be cut under noise."""

    def __init__(self, message: str, channel: str = "", ends: tuple[RangeEnd, ...] = ()) -> None:
        super().__init__(message)
        self.channel, self.ends = channel, ends


class LostValuesError(RecordingError):
    """A channel holds a number that a logger writes for no value, or lacks the values that say when the body was let
    go: what the motion seems to be there is not what happened."""


class IdentificationError(UndertowError):
    """An identification cannot give an answer that would be right."""


class NotFittedError(UndertowError, AttributeError):
    """A result was asked for before ``fit`` was called."""


def shown(value: object) -> str:
    """What was given as a message shows it in one line, also where its own text cannot be made: data by their kind and
    size.

    >>> shown(3.0), shown(["a"]), shown(memoryview(b"abc"))
    ('3.0', "['a']", 'memoryview of shape (3,)')
    """
    kind, shape = type(value).__name__, getattr(value, "shape", None)
    if isinstance(shape, tuple) and shape:
        return f"{kind} of shape {shape}"
    safe = Repr()
    safe.maxother = safe.maxstring = 200
    text = safe.repr(value)
    if "\n" not in text:
        return text
    return f"{kind} of {len(value)} entries" if isinstance(value, Sized) else kind


FAILURES = (ValueError, ArithmeticError)
"""What may end the work on one trial, one group or one level without ending the others': every error of ours, and
numbers that ran out of bounds in a library (its linear algebra's errors are ValueErrors)."""


def failure(error: Exception) -> str:
    """Why a piece of work failed, in one sentence.

    >>> failure(RecordingError("trial r1: no release found"))
    'trial r1: no release found'
    >>> failure(ZeroDivisionError("division by zero"))
    'numbers ran out of bounds (division by zero); look at the recordings and the specimen'
    """
    if isinstance(error, UndertowError):
        return str(error)
    return f"numbers ran out of bounds ({error}); look at the recordings and the specimen"


def is_interrupt(error: BaseException | None) -> bool:
    """Whether Ctrl-C ended the work: compiled code makes system errors of it, one on top of another.

    >>> is_interrupt(KeyboardInterrupt()), is_interrupt(SystemError("bad argument"))
    (True, False)
    """
    while isinstance(error, SystemError):
        error = error.__cause__ or error.__context__
    return isinstance(error, KeyboardInterrupt)
