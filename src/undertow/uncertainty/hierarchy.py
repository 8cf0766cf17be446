"""How sure a group's parameters are when its trials differ, and when how much they differ is itself known from few.

Every trial has its own k, c, mu about the rig's means; the means and the scatter come from a handful of dry trials, and
the trials in water say something of the scatter too. Linear about the fit's end, the parameters are normal given the
scatter, and the scatter's own posterior weighs these normals: intervals as wide as few trials make them.

Belongs here: that posterior of an output-error solution. Does not belong here: the search (output_error.py), what the
residual's noise is (intervals.py), which effects are random (baseline.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy import stats

from undertow.errors import IdentificationError
from undertow.likelihood.output_error import Solution
from undertow.recording.recording import Array
from undertow.uncertainty.confidence import mixture_half_width
from undertow.uncertainty.intervals import noise_factors

LEVELS = 13
"""Values of each scatter that the posterior is summed over, even in the logarithm."""

TAIL = 1e-3
"""Probability left out at either end of them, before the group's own trials are seen."""

ASSUMED_FREEDOM = 2.0
"""Degrees of freedom of a scatter that was assumed, not seen: right within a factor of two or so."""


@dataclass(frozen=True)
class Effect:
    """A quantity that differs from trial to trial: its symbol, and the degrees of freedom its scatter was seen with.

    Its unknowns in the problem are ``symbol_mean`` (the mean's own uncertainty, if it is fitted) and ``symbol[trial]``;
    their priors' widths are the scatter as seen and the mean's error that follows from it.
    """

    symbol: str
    freedom: float


@dataclass(frozen=True)
class Posterior:
    """Parameters that all trials share: ``values`` (q,), half widths of intervals at `INTERVAL_LEVEL` (q,), and the
    share (q,) of their variance that comes from the uncertain means of what scatters; ``scatter`` maps a symbol to
    the posterior mean of its scatter over the one the fit assumed."""

    values: Array
    half_widths: Array
    share_of_means: Array
    scatter: dict[str, float]


@dataclass(frozen=True)
class _Trial:
    """What one trial says of the shared unknowns and of its own effects, its nuisances eliminated: a quadratic."""

    normal: Array
    right: Array
    own: np.ndarray


def group_posterior(solution: Solution, shared: Sequence[int], effects: Sequence[Effect]) -> Posterior:
    """Posterior of the unknowns ``shared`` (indices) of a fit whose trials differ in ``effects``.

    Given scatters s the model is normal (Lindley and Smith 1972); before the group's trials s_j^2 is
    freedom s_0j^2 / chi^2(freedom), as the dry trials leave it, the mean's error going with s. The group's marginal
    likelihood weighs the scatters; an interval holds `INTERVAL_LEVEL` of the weighted normals. The residual's colour
    enters as `noise_factors`.

    IdentificationError without a shared unknown.
    """
    if not shared:
        have = ", ".join(solution.problem.names[:5])
        raise IdentificationError(f"a posterior of {len(shared)} shared unknowns; name some of {have}, ...")
    found, centre, covariance, back = _mixture(solution, shared, effects)
    weights, count = found.posterior, len(shared)
    values = weights @ centre[:, :count]
    spread = np.sqrt(np.maximum(np.einsum("sii->si", covariance)[:, :count], 0.0))
    halves = np.array([mixture_half_width(values[i], centre[:, i], spread[:, i], weights) for i in range(count)])
    typical = {e.symbol: float(np.sqrt(weights @ found.ratios[:, j] ** 2)) for j, e in enumerate(found.effects)}
    return Posterior(values * back, halves * back, _share(covariance, weights, count), typical)


@dataclass(frozen=True)
class Scatters:
    """Scatters of ``effects`` over the assumed ones, ``ratios`` (m, effects), and how probable each row is: ``prior``
    (m,) as the dry trials leave it, ``posterior`` (m,) with the group's own trials; both sum to 1."""

    effects: tuple[Effect, ...]
    ratios: Array
    prior: Array
    posterior: Array


def scatters_seen(solution: Solution, shared: Sequence[int], effects: Sequence[Effect]) -> Scatters:
    """What a fit's own trials say of the scatters of ``effects``, as `group_posterior` sums over them."""
    return _mixture(solution, shared, effects)[0]


def _mixture(
    solution: Solution, shared: Sequence[int], effects: Sequence[Effect]
) -> tuple[Scatters, Array, Array, Array]:
    """Scatters with their weights; mean (m, c) and covariance (m, c, c) of shared unknowns and means given each; and
    the unit of every shared unknown (q,)."""
    names = solution.problem.names
    present = tuple(e for e in effects if any(n.startswith(f"{e.symbol}[") for n in names))
    means = [names.index(f"{e.symbol}_mean") if f"{e.symbol}_mean" in names else -1 for e in present]
    common = np.array([*shared, *(m for m in means if m >= 0)], dtype=np.int64)
    scales = _scales(solution, common[: len(shared)])
    trials = _trials(solution, common, present, scales)
    ratios, prior = _scatters(present)
    of_mean = [i for i, m in enumerate(means) if m >= 0]
    centre, covariance, log_weight = _given_scatter(trials, ratios, len(shared), of_mean)
    weights = np.exp(log_weight - np.max(log_weight)) * prior
    seen = Scatters(present, ratios, prior / np.sum(prior), weights / np.sum(weights))
    return seen, centre, covariance, scales[common[: len(shared)]]


@dataclass(frozen=True)
class Held:
    """What a fit holds fixed that differs from trial to trial: ``slopes`` (trials, q), d(parameter) / d(deviation) of
    each trial, the deviation's ``scatter`` as seen with ``freedom`` degrees of freedom, and the ``mean_error`` that all
    trials share, in the deviation's unit."""

    slopes: Array
    scatter: float
    mean_error: float
    freedom: float


def held_intervals(noise: Array, held: Sequence[Held]) -> tuple[Array, Array]:
    """Half widths (q,) at `INTERVAL_LEVEL` of parameters fitted with something held, and the share (q,) of the
    variance that the means' errors make.

    ``noise`` (q,) is the variance from the residual. The scatters are not in the fit, so that only the dry trials speak
    of them: variance = noise + sum_j r_j^2 (s_j^2 sum_i d_ij^2 + e_j^2 (sum_i d_ij)^2), r_j^2 as freedom / chi^2.
    """
    ratios, weights = _scatters([Effect("", h.freedom) for h in held])
    weights = weights / np.sum(weights)
    own = np.array([h.scatter**2 * np.sum(h.slopes**2, axis=0) for h in held]).reshape(len(held), noise.size)
    mean = np.array([h.mean_error**2 * np.sum(h.slopes, axis=0) ** 2 for h in held]).reshape(len(held), noise.size)
    spread = np.sqrt(noise + ratios**2 @ (own + mean))
    zero = np.zeros(ratios.shape[0])
    halves = np.array([mixture_half_width(0.0, zero, spread[:, i], weights) for i in range(noise.size)])
    typical = weights @ ratios**2
    share = (typical @ mean) / np.maximum(noise + typical @ (own + mean), np.finfo(float).tiny)
    return halves, share


def _scales(solution: Solution, shared: np.ndarray) -> Array:
    """A size for every unknown, so that the small systems are well conditioned: its prior's width, or its scale."""
    unknowns = solution.problem.unknowns
    scales = np.array([u.prior_std if np.isfinite(u.prior_std) else u.scale for u in unknowns])
    scales[shared] = [unknowns[i].scale for i in shared]
    return scales


def _scatters(effects: Sequence[Effect]) -> tuple[Array, Array]:
    """Scatters over the assumed ones (m, effects) and their weights (m,), as the dry trials leave them."""
    axes, logs = [], []
    for effect in effects:
        freedom = effect.freedom if effect.freedom > 0.0 else ASSUMED_FREEDOM
        if np.isinf(freedom):
            axes.append(np.ones(1))
            logs.append(np.zeros(1))
            continue
        ends = np.sqrt(freedom / stats.chi2.ppf([1.0 - TAIL, TAIL], freedom))
        ratio = np.geomspace(float(ends[0]), float(ends[1]), LEVELS)
        axes.append(ratio)
        logs.append(-freedom * (np.log(ratio) + 0.5 / ratio**2))
    rows = list(product(*axes))
    grid = np.array(rows, dtype=np.float64).reshape(len(rows), len(effects))
    log_weight = np.array([sum(values) for values in product(*logs)], dtype=np.float64)
    return grid, np.exp(log_weight - np.max(log_weight))


def _trials(solution: Solution, common: np.ndarray, effects: Sequence[Effect], scales: Array) -> list[_Trial]:
    """Each trial's quadratic in (common, own effects), in units of ``scales``, absolute values of the unknowns."""
    names = solution.problem.names
    unknowns = solution.problem.unknowns
    factors = noise_factors(solution)
    out = []
    rows = zip(
        solution.problem.trials, solution.residuals, solution.jacobians, solution.used, factors, strict=True
    )
    for trial, r, jac, used, factor in rows:
        own = np.array([names.index(f"{e.symbol}[{trial.name}]") for e in effects], dtype=np.int64)
        kept = np.concatenate([common, own])
        loose = np.setdiff1d(used, kept)
        order = np.concatenate([kept, loose])
        place = {int(j): i for i, j in enumerate(used)}
        columns = np.zeros((r.size, order.size))
        for at, j in enumerate(order):
            if int(j) in place:
                columns[:, at] = jac[:, place[int(j)]] * scales[j]
        weight = np.repeat(1.0 / factor, trial.t.size)
        values = solution.values[order] / scales[order]
        normal = columns.T @ (columns * weight[:, None])
        right = normal @ values - columns.T @ (r * weight)
        for at in range(kept.size, order.size):
            prior = unknowns[order[at]]
            precision = (scales[order[at]] / prior.prior_std) ** 2
            normal[at, at] += precision
            right[at] += precision * prior.start / scales[order[at]]
        out.append(_without(normal, right, kept.size, np.arange(common.size, kept.size)))
    return out


def _without(normal: Array, right: Array, kept: int, own: np.ndarray) -> _Trial:
    """The quadratic with everything after the first ``kept`` unknowns eliminated."""
    if normal.shape[0] == kept:
        return _Trial(normal, right, own)
    cross = normal[:kept, kept:]
    solved = np.linalg.lstsq(normal[kept:, kept:], np.column_stack([cross.T, right[kept:]]), rcond=None)[0]
    return _Trial(normal[:kept, :kept] - cross @ solved[:, :-1], right[:kept] - cross @ solved[:, -1], own)


def _given_scatter(
    trials: Sequence[_Trial], ratios: Array, shared: int, of_mean: Sequence[int]
) -> tuple[Array, Array, Array]:
    """Mean (m, c), covariance (m, c, c) of the common unknowns and log marginal likelihood (m,), for each scatter."""
    count = shared + len(of_mean)
    precision = 1.0 / ratios**2
    total = np.zeros((ratios.shape[0], count, count))
    right = np.zeros((ratios.shape[0], count))
    log_weight: Array = np.zeros(ratios.shape[0])
    for at, j in enumerate(of_mean):
        total[:, shared + at, shared + at] += precision[:, j]
        log_weight += 0.5 * np.log(precision[:, j])
    for trial in trials:
        inner = trial.normal[np.ix_(trial.own, trial.own)] + precision[:, :, None] * np.eye(trial.own.size)
        cross = trial.normal[:count, count:]
        solved = np.linalg.solve(inner, np.broadcast_to(
            np.column_stack([cross.T, trial.right[count:]]), (*inner.shape[:2], count + 1)
        ))  # fmt: skip
        total += trial.normal[:count, :count] - cross @ solved[:, :, :-1]
        right += trial.right[:count] - solved[:, :, -1] @ cross.T
        log_weight += 0.5 * np.sum(np.log(precision), axis=1) - 0.5 * np.linalg.slogdet(inner).logabsdet
        log_weight += 0.5 * solved[:, :, -1] @ trial.right[count:]
    covariance = np.asarray(np.linalg.inv(total), dtype=np.float64)
    centre = np.einsum("mij,mj->mi", covariance, right)
    log_weight += 0.5 * np.sum(centre * right, axis=1) - 0.5 * np.linalg.slogdet(total).logabsdet
    return centre, covariance, log_weight


def _share(covariance: Array, weights: Array, shared: int) -> Array:
    """Share (q,) of the shared unknowns' variance that goes with the uncertain means."""
    typical = np.einsum("m,mij->ij", weights, covariance)
    if typical.shape[0] == shared:
        return np.zeros(shared)
    cross, means = typical[:shared, shared:], typical[shared:, shared:]
    explained = np.einsum("ij,ij->i", cross, np.linalg.solve(means, cross.T).T)
    variance = np.maximum(np.diag(typical)[:shared], np.finfo(float).tiny)
    return np.asarray(np.clip(explained / variance, 0.0, 1.0), dtype=np.float64)
