"""Functions that are compiled when their module is imported, once: the compiler's result is kept on disk.

Compiling happens in processes of its own, several beside each other, and every start, also the first, takes the result
from disk: a function that was compiled in the same process gives other last digits than the same one from disk.

Belongs here: those processes, their message, the sentence where the result cannot be kept. Does not belong here: what
is compiled. A module with compiled functions compiles at its import, before any worker process starts.
"""

from __future__ import annotations

import atexit
import hashlib
import logging
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba import njit
from numba.core import event

from undertow.errors import UndertowError

HEAVY = (
    "undertow.likelihood.eq15_search", "undertow.equation.kernel", "undertow.conditioning.fusion",
    "undertow.methods.method1",
)  # fmt: skip
"""Modules with compiled functions, the longest to compile first: where one is needed, all are."""

TASK = "UNDERTOW_COMPILES"
"""Variable of the environment that names the module which a process of its own compiles."""

OPTIONS: dict[str, Any] = {"fastmath": False, "error_model": "numpy", "nogil": True}
"""Compiler options of the integrators; only what Python calls is kept: what it calls is compiled into it."""

WITHIN: dict[str, Any] = {**OPTIONS, "_nrt": False, "no_cpython_wrapper": True}
"""For functions that allocate nothing: numba then does not count references to arrays, which cost half of the time.
Python cannot call them, which saves compiling a wrapper each."""

_POLL_S = 0.02


class _NotKeptError(Exception):
    """A function is not on disk."""


class _Absent(event.Listener):
    """Ends a decoration at the moment where numba, having found nothing on disk, would compile."""

    def on_start(self, event: Any) -> None:
        """Something would be compiled."""
        raise _NotKeptError

    def on_end(self, event: Any) -> None:
        """Nothing: never reached."""


class _Processes:
    """Processes that compile a module each, at most one a core at a time."""

    def __init__(self) -> None:
        self.said = False
        self._waiting: list[str] = []
        self._running: dict[str, subprocess.Popen[bytes]] = {}
        self._ended: set[str] = set()

    def compile(self, module: str) -> None:
        """Wait until the module's functions are on disk, or its process has ended without; say so once."""
        if not self.said:
            logging.getLogger("undertow").warning("compiling the integrator once, up to half a minute")
            atexit.register(self.end)
            self._waiting += HEAVY if module in HEAVY else ()
        self.said = True
        if module not in (*self._waiting, *self._running, *self._ended):
            self._waiting.append(module)
        try:
            while module not in self._ended:
                self._step()
                time.sleep(_POLL_S)
        except BaseException:
            self.end()
            raise

    def _step(self) -> None:
        """Note what has ended and start what may begin."""
        for module, process in [*self._running.items()]:
            if process.poll() is not None:
                del self._running[module]
                self._ended.add(module)
        while self._waiting and len(self._running) < (os.cpu_count() or 1):
            module = self._waiting.pop(0)
            said = {**os.environ, TASK: module, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
            self._running[module] = subprocess.Popen(
                [sys.executable, "-c", f"import importlib; importlib.import_module({module!r})"], env=said,
                stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            )  # fmt: skip

    def end(self) -> None:
        """End what still runs."""
        self._waiting.clear()
        for process in self._running.values():
            process.kill()
            process.wait()
        self._running.clear()


_PROCESSES = _Processes()


def mark_of(*modules: Any) -> int:
    """A number that stands for the text of these modules: part of a compiled function that calls theirs, it makes numba
    compile anew where they have changed."""
    text = b"".join(Path(str(module.__file__)).read_bytes() for module in modules)
    return int(hashlib.sha256(text).hexdigest()[:12], 16)


def compiled(signature: str, **options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Compile a function for that signature (numba's words) and keep the result on disk.

    Raises UndertowError where it cannot be kept.
    """

    def decorate(function: Callable[..., Any]) -> Any:
        asked = os.environ.get(TASK, "")
        try:
            try:
                with event.install_listener("numba:compile", _Absent()):
                    return njit(signature, cache=True, **options)(function)
            except _NotKeptError:
                pass
            if asked and asked != function.__module__:
                return njit(**options)(function)  # another process compiles it, and nothing calls it in this one
            if not asked and sys.executable:
                _PROCESSES.compile(function.__module__)
            return njit(signature, cache=True, **options)(function)
        except RuntimeError as reason:
            if "cannot cache function" not in str(reason):
                raise
            raise UndertowError(
                f"compiled functions cannot be kept ({reason}); set NUMBA_CACHE_DIR to a folder that can be written"
            ) from reason

    return decorate
