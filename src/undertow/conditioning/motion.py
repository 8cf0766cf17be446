"""How the body moved: x, v, a with their errors inside the motion window.

Belongs here: the frozen `Window` and `Motion`. Does not belong here: how they are found (release.py, fusion.py).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, wraps
from types import MappingProxyType
from typing import Concatenate, ParamSpec, TypeVar
from weakref import WeakKeyDictionary

import numpy as np

from undertow.errors import RecordingError
from undertow.quantities import Estimate
from undertow.recording.recording import Array, Recording, read_only

P = ParamSpec("P")
R = TypeVar("R")


@dataclass(frozen=True)
class Window:
    """Instants of one trial in its recording's time, s.

    ``release_s`` is when the body was let go (with ``release_stderr_s``); ``start_s`` to ``end_s`` is motion free
    of the release transient and of the stuck tail. ``held`` tells whether a hold before the release was seen:
    then the body starts from rest, and so does whatever it carries along.
    """

    release_s: float
    start_s: float
    end_s: float
    release_stderr_s: float = 0.0
    held: bool = False


@dataclass(frozen=True, eq=False)
class Motion:
    """Conditioned motion of one trial.

    ``t`` (n,) is s after the release; ``x``, ``v``, ``a`` (n,) are displacement from the sensor's zero in m (rad),
    velocity and acceleration, each with its standard error ``x_std``, ``v_std``, ``a_std`` (n,); all from one
    estimate (one Kalman smoother), so that they belong together. ``inside`` (n,) is True in the window.
    ``equilibrium`` is the rest position in the sensor's scale as an estimate; ``amplitude`` is |x - equilibrium| at
    the release; ``noise`` holds the standard deviation of each recorded channel's noise, in its SI unit.

    The samples run from the release to the recording's end at the recording's own instants.
    """

    recording: Recording
    window: Window
    t: Array
    x: Array
    v: Array
    a: Array
    x_std: Array
    v_std: Array
    a_std: Array
    inside: np.ndarray
    equilibrium: Estimate
    amplitude: float
    noise: Mapping[str, float]
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        for name in ("t", "x", "v", "a", "x_std", "v_std", "a_std"):
            object.__setattr__(self, name, read_only(getattr(self, name)))
        inside = np.array(self.inside, dtype=bool)
        inside.setflags(write=False)
        object.__setattr__(self, "inside", inside)
        object.__setattr__(self, "noise", MappingProxyType(dict(self.noise)))
        if not np.any(inside):
            raise RecordingError(
                f"trial {self.name}: no sample lies in the motion window {self.window.start_s:g} to "
                f"{self.window.end_s:g} s; set trials.window for it"
            )

    @cached_property
    def step_s(self) -> float:
        """Median step between samples, s."""
        return float(np.median(np.diff(self.t)))

    @property
    def name(self) -> str:
        """The trial's name, as its recording has it."""
        return self.recording.name

    def __repr__(self) -> str:
        return f"Motion({self.name!r}: {self.t.size} samples, released from {self.amplitude:.4g})"

    def windowed(self, channel: str) -> Array:
        """One of t, x, v, a, x_std, v_std, a_std inside the motion window, (n_inside,)."""
        values: Array = getattr(self, channel)[self.inside]
        return values

    def recorded(self, channel: str) -> Array:
        """A recorded channel from the release on, at the instants ``t``, (n,), in SI units."""
        return self.recording.channels[channel][-self.t.size :]


def once_a_motion(work: Callable[Concatenate[Motion, P], R]) -> Callable[Concatenate[Motion, P], R]:
    """``work`` of a motion and further arguments, done once for each and remembered as long as the motion lives: a
    search fits the same motions a thousand times."""
    kept: WeakKeyDictionary[Motion, dict[object, R]] = WeakKeyDictionary()

    @wraps(work)
    def asked(motion: Motion, /, *more: P.args, **named: P.kwargs) -> R:
        known = kept.setdefault(motion, {})
        key = more, tuple(named.items())
        if key not in known:
            known[key] = work(motion, *more, **named)
        return known[key]

    return asked
