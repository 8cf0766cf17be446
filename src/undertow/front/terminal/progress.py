"""Progress on stderr: a bar on a terminal, elsewhere a line every few seconds; stage, trial, time left.

Belongs here: what is shown of the work, and when. Does not belong here: the work (campaign/), results (verdicts.py).
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, ProgressColumn, Task, TaskID, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bars
from rich.text import Text

EVERY_S = 5.0
"""Between two lines where stderr is no terminal: a reader of a log sees within that time that the work goes on."""

ITEM_WIDTH = 36
"""Characters of a trial's or group's name that a bar shows."""


def duration_words(seconds: float) -> str:
    """A time as a reader wants it.

    >>> duration_words(4.2), duration_words(75.0), duration_words(5000.0)
    ('4 s', '1 min 15 s', '1 h 23 min')
    """
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"


def seconds_left(elapsed_s: float, done: int, of: int) -> float | None:
    """Time left of a stage, if its other items take as long as those that are done; None before the first.

    >>> seconds_left(10.0, 2, 6), seconds_left(10.0, 0, 6)
    (20.0, None)
    """
    return elapsed_s / done * (of - done) if done > 0 else None


@dataclass
class _Stage:
    """The stage that is worked on, and since when (``clock`` seconds)."""

    name: str
    done: int
    of: int
    item: str
    begun: float
    at_last: float


class Lines:
    """Progress as lines: each stage's start and end at once, between them one at most every ``every_s`` seconds.

    ``each`` item is said at once where it is set. `beat` says where the work is though nothing was finished.

    >>> said, now = [], [0.0]
    >>> lines = Lines(said.append, clock=lambda: now[0])
    >>> for done, item in enumerate(["r1", "r2", "r3", ""]):
    ...     lines("read", done, 3, item)
    ...     now[0] += 4.0
    >>> for line in said:
    ...     print(line)
    read: 0 of 3, at r1
    read: 2 of 3, at r3, 8 s so far, about 4 s left
    read: 3 of 3, 12 s
    """

    def __init__(
        self, say: Callable[[str], None], every_s: float = EVERY_S, clock: Callable[[], float] = time.monotonic,
        each: bool = False,
    ) -> None:  # fmt: skip
        self._say, self._every, self._clock, self._each = say, every_s, clock, each
        self._stage: _Stage | None = None
        self._last = -float("inf")
        self._lock = threading.Lock()

    def __call__(self, stage: str, done: int, of: int, item: str = "", /) -> None:
        """Take note of where a stage is, and say it if it is time."""
        with self._lock:
            now = self._clock()
            if self._stage is None or self._stage.name != stage:
                self._stage = _Stage(stage, done, of, item, now, now)
            self._stage.done, self._stage.of, self._stage.item, self._stage.at_last = done, of, item, now
            if of and (done in (0, of) or self._each or now - self._last >= self._every):
                self._print(now)
            if done == of:
                self._stage = None

    def beat(self) -> None:
        """Say where the work is, if nothing was said for as long."""
        with self._lock:
            now = self._clock()
            if self._stage is not None and now - self._last >= self._every:
                self._print(now)

    def _print(self, now: float) -> None:
        if self._stage is not None:
            self._last = now
            self._say(_line(self._stage, now))


def _line(stage: _Stage, now: float) -> str:
    """One stage's line; the time left counts from its last finished item."""
    parts = [f"{stage.name}: {stage.done} of {stage.of}"]
    if stage.item:
        parts.append(f"at {stage.item}")
    elapsed = now - stage.begun
    if stage.done == stage.of:
        return f"{parts[0]}, {duration_words(elapsed)}" if elapsed >= 1.0 else parts[0]
    if elapsed >= 1.0:
        parts.append(f"{duration_words(elapsed)} so far")
    left = seconds_left(stage.at_last - stage.begun, stage.done, stage.of)
    remaining = 0 if left is None else round(left - (now - stage.at_last))
    if remaining > 0:  # an item that takes longer than those before it says nothing of the time left
        parts.append(f"about {duration_words(remaining)} left")
    return ", ".join(parts)


class _TimeLeft(ProgressColumn):
    """A task's time left, from the items that are done."""

    def render(self, task: Task) -> Text:
        """The words; nothing before the first item or after the last."""
        left = seconds_left(task.elapsed or 0.0, int(task.completed), int(task.total or 0))
        shown = "" if left is None or task.finished else f"about {duration_words(left)} left"
        return Text(shown, style="cyan")


@contextmanager
def lines_shown(say: Callable[[str], None], each: bool = False, every_s: float = EVERY_S) -> Iterator[Lines]:
    """Progress as lines, said also while one item takes long."""
    lines, ended = Lines(say, every_s, each=each), threading.Event()

    def beats() -> None:
        while not ended.wait(every_s / 2.0):
            lines.beat()

    thread = threading.Thread(target=beats, name="progress", daemon=True)
    thread.start()
    try:
        yield lines
    finally:
        ended.set()
        thread.join()


@contextmanager
def bars_shown(console: Console) -> Iterator[Callable[..., None]]:
    """Progress as one bar a stage: trial or group that is worked on, how many are done, time gone and left."""
    columns = (
        TextColumn("{task.description}", markup=False), BarColumn(bar_width=20), MofNCompleteColumn(),
        TimeElapsedColumn(), _TimeLeft(), TextColumn("{task.fields[item]}", style="dim", markup=False),
    )  # fmt: skip
    with Bars(*columns, console=console) as bars:
        tasks: dict[str, TaskID] = {}

        def update(stage: str, done: int, of: int, item: str = "", /) -> None:
            """A stage's bar, made when it is first heard of."""
            if stage not in tasks and of:
                tasks[stage] = bars.add_task(stage, total=of, item="")
            if stage in tasks:
                shown = item if len(item) <= ITEM_WIDTH else f"{item[: ITEM_WIDTH - 3]}..."
                bars.update(tasks[stage], completed=done, total=of, item=shown)

        yield update
