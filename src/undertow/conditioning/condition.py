"""From a recording to a motion: the one public entry of this package.

Belongs here: the order of work. Does not belong here: the work (release.py, fusion.py, cycles.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from undertow.conditioning.cycles import equilibrium, find_cycles
from undertow.conditioning.fusion import Smoothed, fuse
from undertow.conditioning.motion import Motion, Window
from undertow.conditioning.release import find_window
from undertow.recording.noise import noise
from undertow.recording.recording import Array, Recording
from undertow.recording.spikes import MAD_TO_SIGMA

MOTION_CHANNELS = ("displacement", "velocity", "acceleration")

FEWEST_HELD = 30
"""Samples of a hold, fewer than which do not show slow noise."""

SLOW, NOT_AT_REST = 1.5, 4.0
"""A held channel whose values scatter by between so many times what its differences show has slow noise: less is
chance, more is a body that is not at rest."""

CLOCK_SIGNIFICANT = 3.0
"""A clock difference of more standard errors than this is said."""


def condition(
    recording: Recording,
    *,
    start_s: float | None = None,
    end_s: float | None = None,
    window: Window | None = None,
    levels: Mapping[str, float] | None = None,
) -> Motion:
    """Window, smoothed x, v, a with errors, noise and equilibrium of one recording.

    ``start_s``, ``end_s`` (s, the recording's time) override the window found; ``window`` and ``levels`` (the noise of
    every channel) are taken where they are known already.

    Raises RecordingError where nothing moves, nothing that moves was recorded, or the window is too short.
    """
    if levels is None:
        levels = {name: noise(values) for name, values in recording.channels.items()}
    if window is None:
        window = find_window(recording, start_s, end_s, levels)
    if window.held:
        levels = _while_held(recording, window, levels)
    after = recording.time >= window.release_s
    t = recording.time[after] - window.release_s
    channels = {n: recording.channels[n][after] for n in MOTION_CHANNELS if n in recording.channels}
    smoothed = fuse(t, channels, levels, _hold_bias(recording, window, levels))
    inside = (recording.time[after] >= window.start_s) & (recording.time[after] <= window.end_s)
    cycles = find_cycles(t[inside], smoothed.x[inside], smoothed.v[inside], smoothed.x_std[inside])
    centre = equilibrium(cycles)
    first = abs(float(smoothed.x[0]) - centre.value)
    amplitude = max(first, float(np.max(np.abs(smoothed.x[inside] - centre.value)))) if not window.held else first
    return Motion(
        recording, window, t, smoothed.x, smoothed.v, smoothed.a, smoothed.x_std, smoothed.v_std, smoothed.a_std,
        inside, centre, amplitude, levels, _notes(smoothed),
    )  # fmt: skip


def _held(recording: Recording, window: Window) -> Array:
    """Which samples (n,) lie in the hold, as far before the release as the motion is not asked after it."""
    return np.asarray(recording.time < window.release_s - (window.start_s - window.release_s))


def _while_held(recording: Recording, window: Window, levels: Mapping[str, float]) -> Mapping[str, float]:
    """The noise of every channel with that which is slow: what a channel scatters about a line in the hold (by medians:
    a hook may let go slowly at its end), where that is surely more than its differences show, and no motion."""
    hold = _held(recording, window)
    if np.count_nonzero(hold) < FEWEST_HELD:
        return levels
    columns = np.vander(recording.time[hold] - window.release_s, 2)
    found = dict(levels)
    for name in levels.keys() & recording.channels.keys():
        level, held = levels[name], recording.channels[name][hold]
        left = held - columns @ np.linalg.lstsq(columns, held, rcond=None)[0]
        scatter = MAD_TO_SIGMA * float(np.median(np.abs(left)))
        if SLOW * level < scatter < NOT_AT_REST * level:
            found[name] = scatter
    return found


def _hold_bias(recording: Recording, window: Window, levels: Mapping[str, float]) -> tuple[float, float]:
    """Mean of the acceleration while held, and its standard error with room for drift; (0, 0) without a hold."""
    if not window.held or "acceleration" not in recording.channels:
        return 0.0, 0.0
    hold = _held(recording, window)
    if np.count_nonzero(hold) < 10:
        return 0.0, 0.0
    values = recording.channels["acceleration"][hold]
    return float(values.mean()), 0.25 * levels["acceleration"]


def _notes(smoothed: Smoothed) -> tuple[str, ...]:
    """What the smoother found out about the instruments."""
    clock, error = smoothed.clock_s, smoothed.clock_stderr_s
    if not math.isfinite(clock) or abs(clock) <= CLOCK_SIGNIFICANT * error:
        return ()
    later = "earlier" if clock > 0.0 else "later"  # samples of a later instant show the motion earlier
    return (
        f"acceleration is {1e3 * abs(clock):.2f} +- {1e3 * error:.2f} ms {later} than displacement at equal time "
        "stamps; corrected",
    )
