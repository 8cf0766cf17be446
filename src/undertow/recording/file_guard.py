"""HDF5 and MDF files are looked at by another process first: on some damaged ones their libraries end or hang theirs.

One such process serves all files of a kind; it starts with the first file and ends with its input. Where none can be
started files are read without.

Belongs here: that process, its answers. Does not belong here: what it does with a file (file_child.py).
"""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import queue
import subprocess
import sys
import threading
from pathlib import Path

from undertow.errors import RecordingError

CHILD = Path(__file__).with_name("file_child.py")
LONGEST_WAIT_S = 300.0
"""Where the system limits no process's time, and on a machine with much other work."""

SEEN_AT_MOST = 10_000
"""Files that are remembered as looked at."""


class Guard:
    """The process that looks at files of a kind (HDF5, MDF); another one where it ends."""

    def __init__(self, kind: str = "HDF5", command: tuple[str, ...] | None = None) -> None:
        self._kind, self._command = kind, command or (sys.executable, "-P", str(CHILD), kind)
        self._lock = threading.Lock()
        self._sound: dict[tuple[str, int, int], bool] = {}
        self._process: subprocess.Popen[str] | None = None
        self._answers: queue.SimpleQueue[str] = queue.SimpleQueue()
        self._listener: threading.Thread | None = None
        self._owner, self._able, self._ready = os.getpid(), True, False

    def begin(self) -> None:
        """Start the process without waiting for it, where none was started before."""
        with self._lock:
            if self._able and self._process is None:
                self._start()

    def check(self, path: Path) -> None:
        """RecordingError where the library does not survive this file; OSError where there is none."""
        status = path.stat()
        known = (str(path.absolute()), status.st_mtime_ns, status.st_size)
        with self._lock:
            if not self._able:
                return
            if known not in self._sound:
                if len(self._sound) >= SEEN_AT_MOST:
                    self._sound.clear()
                self._sound[known] = self._ask(known[0])
            if not self._sound[known]:
                raise RecordingError(
                    f"{path} is damaged: the library that reads {self._kind} does not come to an end with it; copy the "
                    "file again, or save it again"
                )

    def close(self) -> None:
        """End the process."""
        process, self._process = self._process, None
        if process is None or self._owner != os.getpid():
            return
        process.kill()
        process.wait()
        if self._listener is not None:
            self._listener.join()
        for stream in (process.stdin, process.stdout):
            if stream is not None:
                with contextlib.suppress(OSError):  # what it was never told
                    stream.close()

    def _ask(self, path: str) -> bool:
        """Whether the process survives a file; one that had ended before is started again, once."""
        for _ in range(2):
            process = self._running()
            if process is None:
                return True
            try:
                assert process.stdin is not None
                process.stdin.write(json.dumps(path) + "\n")
                process.stdin.flush()
            except OSError:
                self.close()
                continue
            if self._answer():
                return True
            break
        self.close()
        return False

    def _answer(self) -> str:
        """The next line that the process says; empty where it ends or takes too long."""
        try:
            return self._answers.get(timeout=LONGEST_WAIT_S)
        except queue.Empty:
            return ""

    def _running(self) -> subprocess.Popen[str] | None:
        """The process, started anew where there is none, or where it is that of the process this one was copied from;
        None, now and ever after, where none can be started."""
        if self._process is None or self._owner != os.getpid() or self._process.poll() is not None:
            self._start()
        if self._process is not None and not self._ready:
            self._able = self._ready = bool(self._answer())
            if not self._able:
                self.close()
        return self._process

    def _start(self) -> None:
        """A new process, which is not waited for."""
        self.close()
        self._owner, self._answers, self._ready = os.getpid(), queue.SimpleQueue(), False
        try:
            self._process = subprocess.Popen(
                self._command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
            )
        except OSError:
            self._able = False
            return
        self._listener = threading.Thread(target=_listen, args=(self._process, self._answers), daemon=True)
        self._listener.start()


def _listen(process: subprocess.Popen[str], answers: queue.SimpleQueue[str]) -> None:
    """Pass on every line that a process says, and an empty one when it ends."""
    assert process.stdout is not None
    for line in process.stdout:
        answers.put(line)
    process.wait()
    answers.put("")


HDF5_GUARD, MDF_GUARD = Guard("HDF5"), Guard("MDF")
atexit.register(HDF5_GUARD.close)
atexit.register(MDF_GUARD.close)
