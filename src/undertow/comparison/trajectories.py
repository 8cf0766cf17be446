"""Trials as simulated motion sees them, and how that motion moves with every coefficient an equation could have.

    M = 1,  x'' + sum_i theta_i force_i(x, v; inner) = 0,  theta_i = coefficient_i / mass

is integrated from the release; displacement, velocity and acceleration are compared with the recorded samples, in
means over short cells. No smoothed signal enters, so that no column carries noise.

Belongs here: trials in cells, residuals, sensitivities. Does not belong here: the search for values or terms
(polish.py), intervals of the laboratory's parameters (baseline.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from undertow.comparison.laws import Laws
from undertow.conditioning.motion import Motion
from undertow.conditioning.period import dominant_period
from undertow.equation.kernel import N_SLOTS, SLOT
from undertow.errors import IdentificationError
from undertow.likelihood.output_error import trajectory
from undertow.likelihood.priors import GAIN_STD, LATE_RELEASE_RADIANS, clock_std
from undertow.likelihood.problem import cells

Array = NDArray[np.float64]

CHANNELS = ("displacement", "velocity", "acceleration")

DRIFT_ORDER_MOST = 4
"""Order of the polynomial taken off a channel: 15 s periods of drift leave 4 % of themselves after 12 s."""

PERIODS_PER_ORDER = 2.0
"""One order of drift for so many periods of the motion, so that drift stays slower than the motion."""

LEAST_NOISE = 1e-6
"""Noise of a channel is taken as at least this share of its own size: integration is as good as that."""

OWN = "own "
"""Begins the name of an unknown by which a trial's own k, c or friction departs from the shared one, relative."""

LARGEST = 1e100
"""Residuals and derivatives in units of noise beyond this belong to a motion that all but leaves every bound."""


@dataclass(frozen=True)
class Seen:
    """One channel of a trial: means over cells (n,) and the standard deviation ``sigma`` by which they are weighed,
    ``factor`` times what the sensor's noise gives."""

    quantity: str
    values: Array
    sigma: float
    factor: float = 1.0


@dataclass(frozen=True)
class Cells:
    """A trial in cells: instants ``t`` (n, m) s after the release, channels, drift's basis (n, r), first guesses.

    ``names`` are the trial's own unknowns, ``start`` (u,) their starts, ``prior`` (u,) standard deviations (inf: none).
    """

    name: str
    t: Array
    channels: tuple[Seen, ...]
    drift: Array
    names: tuple[str, ...]
    start: Array
    prior: Array
    period_s: float

    def shortened(self, seconds: float) -> Cells:
        """The same trial on the first ``seconds`` of its window."""
        keep = int(np.searchsorted(self.t[:, 0], self.t[0, 0] + seconds))
        channels = tuple(replace(seen, values=seen.values[:keep]) for seen in self.channels)
        return replace(self, t=self.t[:keep], channels=channels, drift=_drift_basis(self.t[:keep], self.period_s))

    def reweighted(self, factors: Sequence[float]) -> Cells:
        """The same trial with each channel's noise multiplied by a factor."""
        channels = tuple(
            replace(seen, sigma=seen.sigma * factor, factor=seen.factor * factor)
            for seen, factor in zip(self.channels, factors, strict=True)
        )
        return replace(self, channels=channels)


def in_cells(motion: Motion, scatter: Mapping[str, float] | None = None) -> Cells:
    """A motion's recorded samples in cells of a fiftieth of a period, with what is unknown of the trial itself.

    Unknown are x0, the release instant (v0 where no hold was seen), the accelerometer's clock and gain beside another
    channel; offsets and slow drift are taken off as a polynomial of time. ``scatter`` maps places of the integrator
    (k1, c1, fc, ...) to the relative standard deviation by which that number differs from trial to trial: each trial
    then has its own. Raises IdentificationError where no channel of motion is recorded or the window is too short.
    """
    period = dominant_period(motion)
    index, m = cells(motion, period)
    t = motion.t[index]
    recorded = [quantity for quantity in CHANNELS if quantity in motion.recording.channels]
    if not recorded:
        have = ", ".join(motion.recording.channels) or "nothing"
        raise IdentificationError(f"trial {motion.name}: recorded is {have}; map displacement or acceleration")
    channels = []
    for quantity in recorded:
        samples = motion.recorded(quantity)[index]
        noise = max(motion.noise.get(quantity, 0.0), LEAST_NOISE * float(np.std(samples)), np.finfo(float).tiny)
        channels.append(Seen(quantity, samples.mean(axis=1), noise / math.sqrt(m)))
    start = {"x0": (_release_position(motion), math.inf)}
    if motion.window.held:
        late = LATE_RELEASE_RADIANS * period / (2.0 * math.pi)
        start["shift"] = (0.0, math.hypot(late, motion.window.release_stderr_s))
    else:
        start["v0"] = (float(motion.v[0]), math.inf)
    if recorded[-1] == "acceleration" and len(recorded) > 1:
        start["clock"], start["gain"] = (0.0, clock_std(period)), (0.0, GAIN_STD)
    for slot, share in (scatter or {}).items():
        start[f"{OWN}{slot}"] = (0.0, share)
    values = np.array(list(start.values()))
    return Cells(
        motion.name, t, tuple(channels), _drift_basis(t, period), tuple(start), values[:, 0], values[:, 1], period
    )


def _release_position(motion: Motion) -> float:
    """Displacement from rest at the release, m: the hold's median where one was recorded, for a release seen late is
    seen at a smaller displacement."""
    recorded = motion.recording.channels.get("displacement")
    before = motion.recording.time < motion.window.release_s
    if not motion.window.held or recorded is None or not np.any(before):
        return float(motion.x[0] - motion.equilibrium.value)
    return float(np.median(recorded[before]) - motion.equilibrium.value)


def _drift_basis(t: Array, period_s: float) -> Array:
    """Orthonormal polynomials (n, r) of the cells' instants, of an order that stays slower than the motion."""
    middle = t.mean(axis=1)
    span = middle[-1] - middle[0]
    order = int(np.clip(span / period_s / PERIODS_PER_ORDER, 1, DRIFT_ORDER_MOST))
    basis, _ = np.linalg.qr(np.polynomial.legendre.legvander(2.0 * (middle - middle[0]) / span - 1.0, order))
    return np.asarray(basis, dtype=np.float64)


_Motion = tuple[Array, Array, Array]


@dataclass(frozen=True)
class Rows:
    """One trial at given values: residual (n,) predicted less recorded in units of noise, drift taken off; its
    derivatives by the chosen numbers of the laws (n, p) and by the trial's own unknowns (n, u)."""

    residual: Array
    shared: Array
    own: Array


def trial_rows(trial: Cells, book: Laws, values: Array, own: Array, chosen: Sequence[int]) -> Rows | None:
    """Residual and derivatives of one trial; None where the motion leaves every bound.

    ``values`` (p,) are the laws' numbers, ``own`` (u,) the trial's unknowns, ``chosen`` the places among ``values``
    whose derivatives are wanted.
    """
    mine = dict(zip(trial.names, own.tolist(), strict=True))
    theta = book.vector(values)
    theta[SLOT["x0"]], theta[SLOT["v0"]] = mine["x0"], mine.get("v0", 0.0)
    own_slots = {name: SLOT[name.removeprefix(OWN)] for name in trial.names if name.startswith(OWN)}
    shared_part = {name: float(theta[slot]) for name, slot in own_slots.items()}
    factor = np.ones(N_SLOTS)
    for name, slot in own_slots.items():
        factor[slot] = 1.0 + mine[name]
    wanted = [int(book.slots[place]) for place in chosen] + [SLOT["x0"], SLOT["v0"], *own_slots.values()]
    slots = np.array(sorted(set(wanted)), dtype=np.int64)
    place = {int(slot): 1 + index for index, slot in enumerate(slots)}
    clock = mine.get("clock", 0.0)
    simulated = _simulated(theta * factor, slots, trial.t.ravel() + mine.get("shift", 0.0), clock)
    if simulated is None:
        return None
    at, parts = [place[slot] for slot in wanted], []
    with np.errstate(over="ignore", invalid="ignore"):
        for seen in trial.channels:
            motion = simulated[1 if seen.quantity == "acceleration" else 0]
            parts.append(_channel(trial, seen, motion, at, mine, shared_part))
    stacked = np.vstack(parts)
    if not np.all(np.abs(stacked) < LARGEST):
        return None
    shared = stacked[:, 1 : 1 + len(chosen)] * factor[book.slots[list(chosen)]]
    return Rows(stacked[:, 0], shared, stacked[:, 1 + len(chosen) :])


def _simulated(theta: Array, slots: NDArray[np.int64], times: Array, clock: float) -> tuple[_Motion, _Motion] | None:
    """x, v, a with derivatives at ``times`` (n,) and at ``times`` + ``clock``; None where there is no such motion."""
    both = np.concatenate([times, times + clock]) if clock else times
    order = np.argsort(both, kind="stable")
    try:
        x, v, a = trajectory(theta, slots, np.maximum(both[order], 0.0))
    except IdentificationError:  # a step that went too far is no error of the caller's
        return None
    back = np.empty(order.size, dtype=np.int64)
    back[order] = np.arange(order.size)
    now, late = back[: times.size], back[-times.size :]
    return (x[now], v[now], a[now]), (x[late], v[late], a[late])


def _channel(
    trial: Cells,
    seen: Seen,
    motion: _Motion,
    at: Sequence[int],
    mine: Mapping[str, float],
    shared_part: Mapping[str, float],
) -> Array:
    """Residual, derivatives by the laws and by the trial's unknowns, (n, 1 + p + u), in units of noise.

    ``motion`` are x, v, a (n m, 1 + slots) at the cells' samples, ``at`` the columns of the laws, x0, v0 and of what
    the trial has of its own, whose shared part is in ``shared_part``.
    """
    signal = motion[CHANNELS.index(seen.quantity)].reshape(*trial.t.shape, -1).mean(axis=1)
    rate = np.gradient(signal[:, 0], trial.t.mean(axis=1))
    accelerometer = seen.quantity == "acceleration"
    gain = 1.0 + (mine.get("gain", 0.0) if accelerometer else 0.0)
    zero = np.zeros(signal.shape[0])
    laws_end = len(at) - 2 - len(shared_part)
    own = {
        "x0": gain * signal[:, at[laws_end]],
        "v0": gain * signal[:, at[laws_end + 1]],
        "shift": gain * rate,
        "clock": gain * rate if accelerometer else zero,
        "gain": signal[:, 0] if accelerometer else zero,
    }
    for index, (name, value) in enumerate(shared_part.items()):
        own[name] = gain * value * signal[:, at[laws_end + 2 + index]]
    table = np.column_stack(
        [gain * signal[:, 0] - seen.values, gain * signal[:, at[:laws_end]], *(own[name] for name in trial.names)]
    )
    table /= seen.sigma
    result: Array = table - trial.drift @ (trial.drift.T @ table)
    return result
