"""How many hidden oscillators a motion carries along, and which.

The regression of sindy.py, with rivals of every static kind and relaxations beside the equation's own terms: an
oscillator must explain what all of these together cannot. Frequencies are scanned on a grid, the best few starts are
refined, and one more oscillator is taken in as long as its mass stands out of the residual's own, coloured noise by
more than it does in campaigns that have none.

Belongs here: scan, refinement of starts, the test for one more. Does not belong here: the columns (hidden_library.py),
the final numbers (hidden_fit.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from undertow.comparison.hidden_library import Oscillator, oscillator_grid
from undertow.comparison.hidden_refine import refine_inner
from undertow.comparison.hidden_rows import HiddenRows, hidden_rows
from undertow.conditioning.motion import Motion
from undertow.equation.hidden import HiddenResonator, Relaxation
from undertow.equation.hydrodynamics import CubicDamping, DragExponent, QuadraticDrag
from undertow.equation.structure import (
    AsymmetricStiffness,
    CoulombFriction,
    CubicStiffness,
    PositionDamping,
    QuadraticStiffness,
    Stiffness,
    VanDerPolDamping,
    ViscousDamping,
)
from undertow.equation.term import Term
from undertow.errors import IdentificationError
from undertow.likelihood.noise import autocovariance, effective_samples, score_matrix
from undertow.methods.library import Design, label
from undertow.methods.subset import project_out

Array = NDArray[np.float64]

EQUATION_15: tuple[Term, ...] = (Stiffness(), ViscousDamping(), CoulombFriction(), QuadraticDrag())
"""Terms of the report's Eq. 15 besides the mass."""

RIVALS: tuple[Term, ...] = (
    AsymmetricStiffness(), CubicStiffness(), QuadraticStiffness(), CubicDamping(), PositionDamping(),
    VanDerPolDamping(), DragExponent(1.5), Relaxation(0.03), Relaxation(0.1), Relaxation(0.3), Relaxation(1.0),
)  # fmt: skip
"""Static laws and memories without a beat that an oscillator must not stand in for."""

TEST_PERIODS = 0.125
"""Length of the test functions in periods: short, so that the rivals' harmonics speak too, as where terms are told
apart."""

DRIFT_ORDER = 4
"""Slow drift taken off each trial: a polynomial of one more turn than a regression of the body alone takes."""

FREQUENCY_RANGE = (0.3, 2.0)
"""Scanned frequencies over the body's own: below, drift and added stiffness look alike, above, added mass."""

DAMPING_RANGE = (1e-3, 0.4)
"""Damping ratios of what is called an oscillator: beyond 0.4 nothing beats, a relaxation says the same."""

CRITICAL_T = 10.0
"""Wald statistic (mass ratio over its standard error) that an oscillator must exceed."""

STARTS = 3
"""Peaks of each scan that are refined; one grid step from the truth is near enough to get there."""

SAME_FREQUENCY = 0.05
"""Starts closer than this share of their frequency lead to the same place."""

AT_BOUND = 1e-3
"""A parameter within this share of a bound ran into it."""

PARAMETERS_EACH = 3
"""Mass, frequency and damping of an oscillator: what BIC counts."""

QUICK_ITERATIONS = 8
"""Iterations after which the best start is distinguished from the others."""


@dataclass(frozen=True)
class HiddenOscillator:
    """A hidden oscillator as the regression sees it.

    ``w`` natural frequency with the body held, rad/s; ``zeta`` damping ratio; ``ratio`` its mass over the inertia that
    moves with the body, with ``ratio_stderr``; ``trial_ratios`` the same in each trial, everything else shared.
    """

    w: float
    zeta: float
    ratio: float
    ratio_stderr: float
    trial_ratios: tuple[float, ...]

    @property
    def t(self) -> float:
        """Ratio over its standard error."""
        return self.ratio / self.ratio_stderr

    @property
    def term(self) -> HiddenResonator:
        """The same as a term."""
        return HiddenResonator(self.w, self.zeta)


@dataclass(frozen=True)
class HiddenStep:
    """One more oscillator was tried: all oscillators then, the share of the squares that they took of what the set
    kept before had left, the evidence for them (half of it is a logarithm of odds), the weakest t, whether the
    numbers can be those of oscillators at all, whether they were kept, and why (or why not) in words."""

    oscillators: tuple[HiddenOscillator, ...]
    gain: float
    evidence: float
    weakest_t: float
    sound: bool
    kept: bool
    because: str


@dataclass(frozen=True)
class HiddenSearch:
    """What was found: ``oscillators``, the strongest mass first; every ``step``; the body's frequency w^2 = k / M from
    the same regression (``body_w``, rad/s; nan without a stiffness); ``n_effective`` samples; names of the terms."""

    oscillators: tuple[HiddenOscillator, ...]
    steps: tuple[HiddenStep, ...]
    body_w: float
    n_effective: float
    terms: tuple[str, ...]
    rivals: tuple[str, ...]

    @property
    def count(self) -> int:
        """Number of hidden oscillators."""
        return len(self.oscillators)

    def why(self) -> tuple[str, ...]:
        """A sentence for each oscillator tried."""
        return tuple(step.because for step in self.steps)


def find_hidden(
    motions: Sequence[Motion],
    terms: Sequence[Term] = EQUATION_15,
    rivals: Sequence[Term] = RIVALS,
    most: int = 3,
    critical_t: float = CRITICAL_T,
    seeds: Sequence[Oscillator] = (),
) -> HiddenSearch:
    """Hidden oscillators of several trials together, each at rest before the release.

    ``terms`` is the equation without hidden states, ``rivals`` what is offered beside it; ``most`` ends the search.
    ``seeds`` are further starts (w in rad/s, zeta), e.g. from `hidden_modes`. An oscillator is kept where its mass is
    positive, also in every trial, below the body's own, and exceeds its standard error ``critical_t`` times;
    those found before must remain so.

    Raises IdentificationError without trials, for ``most`` below 1, and as `build_design` does.
    """
    if most < 1:
        raise IdentificationError(f"most is {most}; a search for hidden oscillators must allow at least 1")
    own = tuple(term for term in terms if not term.is_inertia)
    beside = tuple(term for term in rivals if label(term) not in {label(one) for one in own})
    rows = hidden_rows(motions, own, beside, TEST_PERIODS, DRIFT_ORDER)
    body = 2.0 * math.pi / rows.design.period_s
    grid = np.array(oscillator_grid(FREQUENCY_RANGE[0] * body, FREQUENCY_RANGE[1] * body))
    scan = _Scan(grid, rows.hidden(grid), tuple(seeds), body)
    found: tuple[HiddenOscillator, ...] = ()
    steps: list[HiddenStep] = []
    plain = beside_rivals = np.zeros((0, 2))
    for _ in range(most):
        plain = _extend(rows, plain, scan, rivals=False)
        beside_rivals = _extend(rows, beside_rivals, scan, rivals=True, other=plain)
        steps.append(_weigh(rows, found, beside_rivals, scan, critical_t))
        if steps[-1].kept:
            found = steps[-1].oscillators
        elif found or len(steps) > 1:
            break
    judged, stiffness, n_effective = _judge(rows, np.array([[o.w, o.zeta] for o in found]).reshape(-1, 2))
    ordered = tuple(sorted(judged, key=lambda one: -one.ratio))
    names = tuple(label(term) for term in own)
    body_w = math.sqrt(stiffness) if stiffness > 0.0 else math.nan
    return HiddenSearch(ordered, tuple(steps), body_w, n_effective, names, tuple(label(term) for term in beside))


@dataclass(frozen=True)
class _Scan:
    """The grid (m, 2), its columns (n, m), the caller's seeds and the body's frequency in rad/s."""

    grid: Array
    columns: Array
    seeds: tuple[Oscillator, ...]
    body: float

    @property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper w and zeta of a refinement."""
        low, high = (share * self.body for share in FREQUENCY_RANGE)
        return np.array([low, DAMPING_RANGE[0]]), np.array([high, DAMPING_RANGE[1]])


def _extend(rows: HiddenRows, before: Array, scan: _Scan, rivals: bool, other: Array | None = None) -> Array:
    """One oscillator more than ``before``, all refined together: (m + 1, 2).

    Several starts a few iterations each, the best one to its end. ``other`` is a further start for all of them: a set
    found without rivals, which two oscillators need, since the rivals can hide the first of two.
    """
    starts = [np.vstack([before, start]) for start in _starts(rows, before, scan, rivals)]
    if other is not None:
        starts.append(other)
    fixed, response = rows.fixed(rivals), rows.design.response
    tried = [refine_inner(rows.hidden, fixed, response, s, scan.bounds, QUICK_ITERATIONS) for s in starts]
    sound = [one for one in tried if np.all(one.coefficients > 0.0) and np.all(one.coefficients < 1.0)] or tried
    best = min(sound, key=lambda one: one.squares)
    return refine_inner(rows.hidden, fixed, response, best.inner, scan.bounds).inner


def _weigh(
    rows: HiddenRows, found: tuple[HiddenOscillator, ...], inner: Array, scan: _Scan, critical_t: float
) -> HiddenStep:
    """The verdict on a set of oscillators, against those ``found`` before."""
    judged, _, n_effective = _judge(rows, inner)
    before = _left_over(rows, np.array([[o.w, o.zeta] for o in found]).reshape(-1, 2))
    gain = 1.0 - _left_over(rows, inner) / before
    spent = PARAMETERS_EACH * (len(judged) - len(found)) * math.log(n_effective)
    evidence = -n_effective * math.log(max(1.0 - gain, np.finfo(float).tiny)) - spent
    weakest = min(judged, key=lambda one: one.t)
    unsound = objection = _unsound(judged, scan.bounds)
    if not objection and weakest.t < critical_t:
        objection = f"t = {weakest.t:.1f} at {weakest.w:.4g} rad/s is below {critical_t:g}"
    if not objection and evidence <= 0.0:
        objection = f"the evidence falls by {-evidence:.1f}"
    members = ", ".join(
        f"{one.w:.4g} rad/s (damping {one.zeta:.3g}, mass ratio {one.ratio:.3g}, t {one.t:.1f})" for one in judged
    )
    text = f"{len(judged)} hidden: {members} take {100.0 * gain:.0f} % of what was left; "
    text += f"refused, {objection}" if objection else f"kept, the evidence rises by {evidence:.1f}"
    return HiddenStep(judged, gain, evidence, weakest.t, unsound == "", objection == "", text)


def _left_over(rows: HiddenRows, inner: Array) -> float:
    """Sum of squares that terms, rivals, drifts and these oscillators leave."""
    held = np.hstack([rows.fixed(rivals=True), rows.hidden(inner)])
    return float(np.sum(project_out(held, rows.design.response[:, None]) ** 2))


def _unsound(judged: tuple[HiddenOscillator, ...], bounds: tuple[Array, Array]) -> str:
    """Why the set cannot be hidden oscillators whatever its statistic; empty where it can."""
    for one in judged:
        if not 0.0 < one.ratio < 1.0:
            return f"the mass ratio {one.ratio:.3g} at {one.w:.4g} rad/s is not between 0 and 1"
        if min(one.trial_ratios) <= 0.0:
            return f"a trial has the mass ratio {min(one.trial_ratios):.3g} at {one.w:.4g} rad/s"
        if not bounds[0][0] * (1.0 + AT_BOUND) < one.w < bounds[1][0] * (1.0 - AT_BOUND):
            return f"a frequency ran to the bound {one.w:.4g} rad/s"
        if one.zeta > bounds[1][1] * (1.0 - AT_BOUND):
            return f"the damping ratio at {one.w:.4g} rad/s ran to the bound {one.zeta:.3g}"
    return ""


def _starts(rows: HiddenRows, before: Array, scan: _Scan, rivals: bool) -> list[Oscillator]:
    """The seeds and the peaks of the scan over what terms (and rivals) and the oscillators before leave."""
    held = rows.fixed(rivals)
    held = np.hstack([held, rows.hidden(before)])
    columns = project_out(held, scan.columns)
    residual = project_out(held, rows.design.response[:, None])[:, 0]
    size = np.maximum(np.sum(columns**2, axis=0), np.finfo(float).tiny)
    along = columns.T @ residual
    gain = np.where(along > 0.0, along**2 / size, 0.0)
    distinct: list[Oscillator] = []
    for w, z in [*scan.seeds, *_peaks(scan.grid, gain)]:
        if all(abs(math.log(w / other)) > SAME_FREQUENCY for other, _ in distinct):
            distinct.append((w, z))
    return distinct


def _peaks(grid: Array, gain: Array) -> list[Oscillator]:
    """The `STARTS` highest local maxima over frequency, each at its best damping."""
    frequencies = np.unique(grid[:, 0])
    table = gain.reshape(frequencies.size, -1)
    best = table.max(axis=1)
    padded = np.concatenate([[-np.inf], best, [-np.inf]])
    peaks = np.flatnonzero((best >= padded[:-2]) & (best >= padded[2:]) & (best > 0.0))
    chosen = peaks[np.argsort(-best[peaks])][:STARTS]
    damping = grid[:, 1].reshape(frequencies.size, -1)
    return [(float(frequencies[i]), float(damping[i, int(np.argmax(table[i]))])) for i in chosen]


def _judge(rows: HiddenRows, inner: Array) -> tuple[tuple[HiddenOscillator, ...], float, float]:
    """Masses with standard errors under the residual's own correlation, k / M, and effective samples.

    Each trial's own ratio comes from the same regression with the oscillator's column split by trials.
    """
    design, count = rows.design, len(inner)
    fixed = rows.fixed(rivals=True)
    hidden = rows.hidden(inner)
    stacked = np.hstack([fixed, hidden])
    theta = np.linalg.lstsq(stacked, design.response, rcond=None)[0]
    residual = design.response - stacked @ theta
    noise = autocovariance(residual, design.lengths, rows.memory)
    judged: list[HiddenOscillator] = []
    samples = float(design.response.size)
    for index in range(count):
        place = fixed.shape[1] + index
        column = project_out(np.delete(stacked, place, axis=1), stacked[:, [place]])
        size = float(np.sum(column**2))
        scores = score_matrix(column, noise, design.lengths)
        samples = min(samples, effective_samples(column, scores, max(float(noise[0]), np.finfo(float).tiny)))
        freedom = samples / max(samples - stacked.shape[1], 1.0)
        stderr = math.sqrt(max(float(scores[0, 0]), np.finfo(float).tiny) * freedom) / max(size, np.finfo(float).tiny)
        alone = _each_trial(design, stacked, place)
        w, zeta = (float(value) for value in inner[index])
        judged.append(HiddenOscillator(w, zeta, float(theta[place]), stderr, alone))
    terms = np.linalg.lstsq(np.hstack([design.columns[:, : rows.own], hidden, design.nuisance]), design.response)[0]
    stiffness = float(terms[design.names.index("stiffness")]) if "stiffness" in design.names[: rows.own] else math.nan
    return tuple(judged), stiffness, samples


def _each_trial(design: Design, stacked: Array, place: int) -> tuple[float, ...]:
    """The coefficient of one column in each trial, all other coefficients being those of all trials together."""
    own = np.zeros((design.response.size, len(design.trials)))
    own[np.arange(design.response.size), design.trial] = stacked[:, place]
    split = np.hstack([np.delete(stacked, place, axis=1), own])
    theta = np.linalg.lstsq(split, design.response, rcond=None)[0]
    return tuple(float(value) for value in theta[-len(design.trials) :])
