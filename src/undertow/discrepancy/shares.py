"""Static, memory or clock: what kind of force an equation leaves over.

One decay never crosses itself in (x, v): along it any force can pass for a function of x and v, for memory, or for a
force with its own clock. Trials of different amplitude tell them apart, if whole trials are left out: what was learned
on the others must give this one's residual force.

- static: one function of (x, v) - powers, dry friction's laws, their products;
- clock: of what that leaves, a steady oscillation at a frequency found on the other trials, with this trial's own size
  and phase, less what a phase tied to the release and a size tied to its amplitude would give;
- memory: responses to the measured motion of a bank of hidden states, at rest before the release (bank.py), without
  what is a clock's. A force from outside moves the body, so that a bank driven by the measured motion can copy it:
  only the phase across trials tells the two apart.

The equation's own free coefficients are refitted
beside every law: a wrong number in the equation is no missing law.

Belongs here: these shares. Does not belong here: the columns (bank.py), the learning (ridge.py), which law it is
(search.py).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from undertow.conditioning.motion import Motion
from undertow.conditioning.period import dominant_period
from undertow.discrepancy.bank import bank_frequencies, clock_pair, memory_columns, static_columns
from undertow.discrepancy.findings import TrialFindings
from undertow.discrepancy.residual import even_motion, residual_force, term_force
from undertow.discrepancy.ridge import left_out_residuals
from undertow.equation import registry
from undertow.equation.equation import Equation
from undertow.equation.kernel import SLOT
from undertow.equation.term import Array
from undertow.errors import UndertowError
from undertow.methods.baseline import GroupFit
from undertow.recording.noise import noise

FEWEST_TRIALS = 3
"""Shares are learned on two trials at least and tried on a third."""

DIFFERENT_AMPLITUDES = 1.2
"""The largest release must exceed the smallest by this factor: between equal ones a law is not put to the test."""

ROWS_PER_PERIOD = 24
"""Rows a period of the fastest trial: harmonics up to the fifth pass."""

ABOVE_NOISE = 1.0
"""A residual force whose variance exceeds its noise's by less than this factor is not shared out."""

BODY_BAND = 0.15
"""A clock this close (relative) to the body's own frequency cannot be distinguished from a trial whose k differs."""

INERTIA = frozenset({"mass", *(law.name for law in registry.catalogue() if law.is_inertia)})
"""A free mass is refitted as a free stiffness, at the mass that it has: with mass and stiffness both free, no equation
at all would leave no force at all."""

FINENESS = 8
"""Steps a line width (2 pi / window) in which a clock's frequency is looked for."""


@dataclass(frozen=True)
class Shares:
    """Fractions of one trial's residual force above noise; nan where they are not defined."""

    static: float = math.nan
    memory: float = math.nan
    clock: float = math.nan


@dataclass(frozen=True)
class _Rows:
    """One trial's rows: instants (n,), residual force ``y`` (n,) and its noise variance, columns (n, p) of the
    equation's own free terms, of static laws, of memory; the body's x and v (n, 2), its rate, the release amplitude."""

    t: Array
    y: Array
    noise: float
    own: Array
    static: Array
    memory: Array
    body: Array
    rate: float
    amplitude: float

    def above(self, left: Array) -> float:
        """Sum of squares of ``left`` (n,) above noise; zero where that is under `ABOVE_NOISE` times the noise's."""
        quiet = self.noise * left.size
        more = float(left @ left) - quiet
        return more if more > ABOVE_NOISE * quiet else 0.0


def residual_shares(
    motions: Sequence[Motion], equations: Mapping[str, Equation], free: Collection[str]
) -> dict[str, Shares]:
    """Shares of every trial of a group, by name.

    ``equations`` gives each trial's equation with its numbers; ``free`` the names of its terms whose coefficients were
    fitted in this group ("mass": the total mass). All nan with fewer than three trials, where their amplitudes lie
    within a factor of 1.2, and for a trial whose residual force is noise.
    """
    amplitudes = [m.amplitude for m in motions]
    if len(motions) < FEWEST_TRIALS or max(amplitudes) < DIFFERENT_AMPLITUDES * min(amplitudes):
        return {m.name: Shares() for m in motions}
    rows = _all_rows(motions, equations, frozenset(free))
    weights = [row.above(row.y) / float(row.y @ row.y) for row in rows]
    if sum(w > 0.0 for w in weights) < FEWEST_TRIALS - 1:
        return {m.name: Shares() for m in motions}
    after_own, after_static, after_memory = left_out_residuals(
        [r.y for r in rows], [r.own for r in rows], [[r.static for r in rows], [r.memory for r in rows]], weights
    )
    clock = _clock_parts(rows, after_static, weights)
    out = {}
    for i, row in enumerate(rows):
        total, above = float(after_own[i] @ after_own[i]), row.above(after_own[i])
        if above <= 0.0:
            out[motions[i].name] = Shares()
            continue
        static = _share(total - float(after_static[i] @ after_static[i]), above)
        both = _share(total - float(after_memory[i] @ after_memory[i]), above)
        untied = min(_share(clock[i], above), 1.0 - static)
        memory = min(max(both - static, 0.0), 1.0 - static - untied)
        out[motions[i].name] = Shares(static, memory, untied)
    return out


def with_shares(trials: Sequence[TrialFindings], baseline: GroupFit) -> tuple[TrialFindings, ...]:
    """A group's trials with the shares of their residual force against the group's equation in their mismatches.

    Each trial has its own stiffness where load cells gave one. Unchanged where shares are not defined.
    """
    free = {c.term or "mass" for c in baseline.model.coefficients}
    equations = {t.motion.name: _own_stiffness(baseline, t.motion.name) for t in trials}
    try:
        found = residual_shares([t.motion for t in trials], equations, free)
    except UndertowError:  # uneven steps, a window too short: the trials stay as they are located
        return tuple(trials)
    out = []
    for t in trials:
        one = found[t.motion.name]
        kinds = replace(t.mismatch, static_share=one.static, memory_share=one.memory, clock_share=one.clock)
        out.append(replace(t, mismatch=kinds))
    return tuple(out)


def _own_stiffness(baseline: GroupFit, trial: str) -> Equation:
    """The group's equation with the trial's own stiffness."""
    equation = baseline.equation()
    own = float(baseline.model.theta(baseline.values, trial)[SLOT["k1"]])
    numbers = [own if t.name == "stiffness" else c for t, c in zip(equation.terms, equation.coefficients, strict=True)]
    return replace(equation, coefficients=tuple(numbers))


def _share(explained: float, above: float) -> float:
    return min(max(explained / above, 0.0), 1.0)


def _all_rows(motions: Sequence[Motion], equations: Mapping[str, Equation], free: frozenset[str]) -> list[_Rows]:
    """Every trial's rows, with scales and a bank that all trials share."""
    evens = [even_motion(m) for m in motions]
    rates = [2.0 * math.pi / dominant_period(m) for m in motions]
    size = max(e.amplitude for e in evens)
    speed = max(float(np.max(np.abs(e.v))) for e in evens)
    span = max(float(e.t[-1]) for e in evens)
    bank = bank_frequencies(min(rates), max(rates), span)
    rows = []
    for motion, even, rate in zip(motions, evens, rates, strict=True):
        equation = equations[motion.name]
        left = residual_force(motion, equation)
        own = [term_force(t, even) for t in equation.terms if t.name in free - INERTIA]
        if free & INERTIA and "stiffness" not in free:
            own.append(even.x)
        columns = (
            np.column_stack(own) if own else np.zeros((even.t.size, 0)), static_columns(even, size, speed),
            memory_columns(even, size, min(rates), bank, span), np.column_stack([even.x, even.v]),
        )  # fmt: skip
        width = max(1, int(2.0 * math.pi / max(rates) / ROWS_PER_PERIOD / (even.t[1] - even.t[0])))
        t, y, *means = (_means(c, width) for c in (left.t, left.force, *(c[even.inside] for c in columns)))
        free_terms, static, memory, body = (c - c.mean(axis=0) for c in means)
        quiet = min(left.noise, noise(y)) ** 2
        rows.append(_Rows(t, y - y.mean(), quiet, free_terms, static, memory, body, rate, motion.amplitude))
    return rows


def _means(values: Array, width: int) -> Array:
    """Means of ``width`` consecutive samples; what is left over at the end is dropped."""
    count = values.shape[0] // width
    cut = values[: count * width].reshape(count, width, *values.shape[1:])
    return np.asarray(cut.mean(axis=1), dtype=np.float64)


def _clock_parts(rows: Sequence[_Rows], left: Sequence[Array], weights: Sequence[float]) -> list[float]:
    """Sum of squares of each trial's leftover that follows a clock of its own."""
    span = max(float(r.t[-1] - r.t[0]) for r in rows)
    step = 2.0 * math.pi / span / FINENESS
    rates = [r.rate for r in rows]
    tried = np.arange(2.0 * math.pi * 3.0 / span, 4.0 * max(rates), step)
    own = np.any([np.abs(tried / rate - 1.0) < BODY_BAND for rate in rates], axis=0)
    tried = tried[~own]
    free = [_project_out(r.body, y) for r, y in zip(rows, left, strict=True)]
    fits = [[_line(r, y, w) for w in tried] for r, y in zip(rows, free, strict=True)]
    powers = np.array([[gain for gain, _ in of_trial] for of_trial in fits])
    sizes = np.array([max(float(y @ y), 1e-300) for y in free])
    relative = powers * (np.array(weights) / sizes)[:, None]
    out = []
    for i, row in enumerate(rows):
        others = [j for j in range(len(rows)) if j != i]
        at = int(np.argmax(relative[others].sum(axis=0)))
        tied = row.amplitude * _tied([fits[j][at][1] / rows[j].amplitude for j in others])
        pair = _project_out(row.body, clock_pair(row.t, float(tried[at])))
        with_release = float(free[i] @ free[i]) - float(np.sum((free[i] - pair @ tied) ** 2))
        out.append(float(powers[i, at]) - max(with_release, 0.0))
    return out


def _tied(pairs: Sequence[Array]) -> Array:
    """Mean cosine and sine (2,) of the other trials, less what their scatter alone would give (James and Stein)."""
    mean = np.mean(pairs, axis=0)
    scatter = float(np.sum((np.array(pairs) - mean) ** 2)) / (len(pairs) * max(len(pairs) - 1, 1))
    return np.asarray(mean * max(1.0 - scatter / max(float(mean @ mean), 1e-300), 0.0), dtype=np.float64)


def _line(row: _Rows, y: Array, frequency: float) -> tuple[float, Array]:
    """Sum of squares that a steady oscillation takes off ``y`` (n,), and its cosine and sine (2,)."""
    pair = _project_out(row.body, clock_pair(row.t, frequency))
    size = np.linalg.solve(pair.T @ pair, pair.T @ y)
    return float(size @ (pair.T @ y)), np.asarray(size, dtype=np.float64)


def _project_out(columns: Array, values: Array) -> Array:
    """``values`` (n,) or (n, p) without what ``columns`` (n, q) and a constant explain."""
    basis, _ = np.linalg.qr(np.column_stack([columns, np.ones(columns.shape[0])]))
    return np.asarray(values - basis @ (basis.T @ values), dtype=np.float64)
