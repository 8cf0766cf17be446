"""Trials as simulated motion sees them, and how that motion moves with every coefficient an equation could have.

    M = 1,  x'' + sum_i theta_i force_i(x, v; inner) = 0,  theta_i = coefficient_i / mass

is integrated from the release; displacement, velocity and acceleration are compared with the recorded samples, in
means over short cells, by the residuals of every fit (likelihood/residuals.py). No smoothed signal enters, so that no
column carries noise.

Belongs here: trials in cells, what their unknowns are to the likelihood, drift taken off. Does not belong here: the
search for values or terms (polish.py), intervals of the laboratory's parameters (baseline.py).
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
from undertow.equation.kernel import SLOT
from undertow.equation.term import PlacedTerm
from undertow.errors import IdentificationError
from undertow.likelihood.priors import GAIN_STD, LATE_RELEASE_RADIANS, clock_std
from undertow.likelihood.problem import Channel, Link, TrialProblem, cells
from undertow.likelihood.residuals import residuals

Array = NDArray[np.float64]

CHANNELS = ("displacement", "velocity", "acceleration")

DRIFT_ORDER_MOST = 4
"""Order of the polynomial taken off a channel: 15 s periods of drift leave 4 % of themselves after 12 s."""

PERIODS_PER_ORDER = 2.0
"""One order of drift for so many periods of the motion, so that drift stays slower than the motion."""

LEAST_NOISE = 1e-6
"""Noise of a channel is taken as at least this share of its own size: integration is as good as that."""

NUISANCES = ("shift", "clock", "gain")
"""What a trial's release and its accelerometer have of their own: late by, s, late by beside the others, relative."""

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
    factor, parts = np.ones(theta.size), np.ones(theta.size)
    for name in (name for name in trial.names if name.startswith(OWN)):
        slot = SLOT[name.removeprefix(OWN)]
        factor[slot], parts[slot] = 1.0 + mine[name], theta[slot]
    laws_slots = [int(book.slots[place]) for place in chosen]
    places = {slot: column for column, slot in enumerate(sorted({*laws_slots, *_slots_of(trial.names)}))}
    clocks = {name: len(places) + i for i, name in enumerate(n for n in NUISANCES if n in mine)}
    at = np.concatenate([np.zeros(len(places)), [mine[name] for name in clocks]])
    with np.errstate(over="ignore", invalid="ignore"):
        found = residuals(_as_problem(trial, theta * factor, places, clocks, book.placed), at)
        if found is None or not np.all(np.abs(found[0]) < LARGEST) or not np.all(np.abs(found[1]) < LARGEST):
            return None
    table = _in_cells(trial, np.column_stack(found[:2]))
    shared = table[:, [1 + places[slot] for slot in laws_slots]] * factor[laws_slots]
    columns = [clocks[name] if name in clocks else places[_slot_of(name)] for name in trial.names]
    scales = [1.0 if name in clocks else parts[_slot_of(name)] for name in trial.names]
    return Rows(table[:, 0], shared, table[:, [1 + column for column in columns]] * scales)


def _slot_of(name: str) -> int:
    """Where a trial's own unknown stands in the integrator."""
    return SLOT[name.removeprefix(OWN)]


def _slots_of(names: Sequence[str]) -> list[int]:
    return [_slot_of(name) for name in names if name not in NUISANCES]


def _as_problem(
    trial: Cells, theta: Array, places: Mapping[int, int], clocks: Mapping[str, int], placed: tuple[PlacedTerm, ...]
) -> TrialProblem:
    """The trial's samples as the one likelihood sees them: numbers at ``theta``, unknown deviations from those by their
    slots (``places``), and what the sensors have of their own (``clocks``)."""
    channels, samples = [], trial.t.shape[1]
    for seen in trial.channels:
        channel = Channel(seen.quantity, np.repeat(seen.values, samples), seen.sigma)
        if seen.quantity == "acceleration":
            channel = replace(channel, shift=clocks.get("clock", -1), gain=clocks.get("gain", -1))
        channels.append(channel)
    links = tuple(Link(slot, column) for slot, column in places.items())
    return TrialProblem(
        trial.name, trial.t.ravel(), theta, links, tuple(channels), clocks.get("shift", -1), period_s=trial.period_s,
        laws=placed,
    )  # fmt: skip


def _in_cells(trial: Cells, table: Array) -> Array:
    """Means over cells of every channel's rows, with what a slow drift and an offset can imitate taken off."""
    parts = table.reshape(len(trial.channels), *trial.t.shape, -1).mean(axis=2)
    return np.vstack([part - trial.drift @ (trial.drift.T @ part) for part in parts])
