"""One piece of work on many items, on several processes, that stops at once when it is told to.

Belongs here: processes and their end. Does not belong here: what they do (course.py).
"""

from __future__ import annotations

import os
import signal
import threading
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Protocol, TypeVar

import joblib
from joblib.externals.loky.process_executor import TerminatedWorkerError

from undertow.errors import ConfigError, UndertowError


class Progress(Protocol):
    """Called with the stage's name, how many items are done, how many there are, and which one is worked on."""

    def __call__(self, stage: str, done: int, of: int, item: str = "", /) -> None:
        """Take note."""


FEWEST_FOR_PROCESSES = 3
"""Below this many items starting processes (0.5 to 1 s) costs more than it gives."""

_ELSEWHERE = -1
"""As many processes as there are workers on a cluster, which joblib writes so."""

Item = TypeVar("Item")
Result = TypeVar("Result")


def silent(stage: str, done: int, of: int, item: str = "", /) -> None:
    """No progress."""


def steps(progress: Progress, totals: Mapping[str, int]) -> Progress:
    """Progress of work that comes in several portions, counted through; ``totals`` is what a stage amounts to.

    What is looked at again beside later portions (a stage whose name starts with "dry") is said once.

    >>> seen = []
    >>> one = steps(lambda *said: seen.append(said), {"read": 4})
    >>> for done in (0, 1, 2, 0, 1, 2):
    ...     one("read", done, 2)
    >>> seen
    [('read', 0, 4), ('read', 1, 4), ('read', 2, 4), ('read', 3, 4), ('read', 4, 4)]
    """
    finished: Counter[str] = Counter()
    last: dict[str, tuple[int, int]] = {}

    def say(stage: str, done: int, of: int, item: str = "", /) -> None:
        before = finished[stage]
        if stage.startswith("dry") and before:
            return
        said = before + done, max(totals.get(stage, 0), before + of)
        if done == of:
            finished[stage] += of
        if last.get(stage) != said and (done or not before):
            progress(stage, *said, *([item] if item else []))
        last[stage] = said

    return say


def on_processes(
    work: Callable[[Item], Result], items: Sequence[Item], jobs: int, stage: str, progress: Progress = silent,
    name: Callable[[Item], str] | None = None,
) -> list[Result]:  # fmt: skip
    """``work(item)`` for all items, in order, on ``jobs`` processes (0: one a core), or on the workers of the backend
    that ``joblib.parallel_config`` has made the active one.

    ``name`` is what progress calls an item (None: progress says how many alone).

    ``work`` must be picklable. An exception of one item ends the others; so does an interruption, which only this
    process receives: workers do not see Ctrl-C, they are ended.

    Raises UndertowError where the system ended a worker, ConfigError where ``jobs`` is below 0.

    >>> on_processes(abs, [-1, 2], jobs=1, stage="sizes")
    [1, 2]
    """
    if jobs < 0:
        raise ConfigError(f"jobs is {jobs}; give how many processes, or 0 for one a core")
    count = _ELSEWHERE if _is_elsewhere() else jobs or os.cpu_count() or 1
    def say(done: int) -> None:
        progress(stage, done, len(items), *([name(items[done])] if name is not None and done < len(items) else []))

    say(0)
    done: list[Result] = []
    try:
        for result in _results(work, items, count):
            done.append(result)
            say(len(done))
    except TerminatedWorkerError as reason:
        raise UndertowError(
            f"{stage}: the system ended a worker process after {len(done)} of {len(items)} items (memory, most often); "
            "run again with --resume and --jobs 1"
        ) from reason
    return done


def _results(work: Callable[[Item], Result], items: Sequence[Item], count: int) -> Iterator[Result]:
    if count == 1 or (count != _ELSEWHERE and len(items) < FEWEST_FOR_PROCESSES) or not items:
        yield from map(work, items)
        return
    if count == _ELSEWHERE and joblib.effective_n_jobs(_ELSEWHERE) == 1:
        yield from _on_the_only_worker(work, items)
        return
    with _children_without_interrupts():
        results = joblib.Parallel(n_jobs=min(count, len(items)), return_as="generator")(
            joblib.delayed(_one)((work, item)) for item in items
        )
    yield from results


def _on_the_only_worker(work: Callable[[Item], Result], items: Sequence[Item]) -> Iterator[Result]:
    """Results in order from a cluster of one worker, where joblib would do the work in this process."""
    backend, _ = joblib.parallel.get_active_backend()
    futures = [backend.client.submit(_one, (work, item), pure=False) for item in items]
    for future in futures:
        yield future.result()


def _one(pair: tuple[Callable[[Item], Result], Item]) -> Result:
    """One piece of work, told in a tuple: Dask sends anything else that is large to a single worker beforehand, and
    the work is lost with that worker."""
    work, item = pair
    return work(item)


def _is_elsewhere() -> bool:
    """Whether joblib's active backend is a cluster, whose workers are as many as they are."""
    backend, _ = joblib.parallel.get_active_backend()
    return type(backend).__name__ == "DaskDistributedBackend"


@contextmanager
def _children_without_interrupts() -> Iterator[None]:
    """Processes started inside ignore SIGINT; one that comes meanwhile is delivered here at the end.

    Without this every worker answers Ctrl-C with a traceback of its own. Workers inherit that SIGINT is ignored; that
    it is also blocked keeps it for this process (on Linux; elsewhere the half second of starting may swallow one).
    Outside the main thread, where signals cannot be set, nothing is done.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    masks = hasattr(signal, "pthread_sigmask")
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT}) if masks else set()
    handler = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
        if masks:
            signal.pthread_sigmask(signal.SIG_SETMASK, mask)
