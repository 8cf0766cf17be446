"""The errors a user can meet. Every message names the quantity, the value, the rule and the next step."""

from __future__ import annotations


class UndertowError(ValueError):
    """Base of every error that undertow raises on purpose; the command line prints its text alone."""


class ConfigError(UndertowError):
    """The configuration is wrong: an unknown key, a value out of range, a path that is not there."""


class RecordingError(UndertowError):
    """A recording cannot be used as it is: missing column, wrong unit, NaN, no release."""


class ClippedError(RecordingError):
    """A channel is cut off at the end of its sensor's range: what it says there is not what happened."""


class IdentificationError(UndertowError):
    """An identification cannot give an answer that would be right."""


class NotFittedError(UndertowError, AttributeError):
    """A result was asked for before ``fit`` was called."""
