"""Functions that are compiled when their module is imported, once: the compiler's result is kept on disk.

Belongs here: the message when that happens, and the sentence where the result cannot be kept. Does not belong here:
what is compiled. A module with compiled functions compiles at its import, before any worker process starts.
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import Any

from numba import njit
from numba.core import event

from undertow.errors import UndertowError


class _Announcement(event.Listener):
    """Says once in a process that something is compiled; a log message, which without a handler goes to stderr."""

    said = False

    def on_start(self, event: Any) -> None:
        """Something is compiled, not taken from disk."""
        if not _Announcement.said:
            logging.getLogger("undertow").warning("compiling the integrator once, up to half a minute")
        _Announcement.said = True

    def on_end(self, event: Any) -> None:
        """Nothing: what was compiled is used."""


def compiled(signature: str, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a function for that signature (numba's words) and keep the result on disk.

    Raises UndertowError where it cannot be kept.
    """

    def decorate(function: Callable[..., Any]) -> Any:
        try:
            with event.install_listener("numba:compile", _Announcement()):
                return njit(signature, cache=True, **options)(function)
        except RuntimeError as reason:
            if "cannot cache function" not in str(reason):
                raise
            raise UndertowError(
                f"compiled functions cannot be kept ({reason}); set NUMBA_CACHE_DIR to a folder that can be written"
            ) from reason

    return decorate
