"""Draws of a fit's parameters given its trials: of the Laplace approximation, weighed by the true likelihood.

About its best point a posterior is close to a normal distribution whose covariance the fit knows already (Laplace).
Candidates are drawn from that and weighed by true over approximate density (importance sampling; Tierney and Kadane
1986, doi:10.1080/01621459.1986.10478240), weights above the mean times the root of their number cut off (Ionides 2008,
doi:10.1198/106186008X320456), and resampled to equal weights. Noise is as the residual shows it near the motion's
frequency (`noise_factors`); priors of nuisances and of random effects count as in the fit, and the scatter of these is
drawn too where few trials showed it: from what the dry trials and these trials say of it together. (Drawn from the dry
trials alone, it is far too small where these happened to agree: few candidates then carry all weight, and their draws
are too narrow.)

Belongs here: draws and how far they can be trusted. Does not belong here: intervals (intervals.py), the search.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from undertow.errors import IdentificationError
from undertow.likelihood import eq15, output_error
from undertow.likelihood.output_error import Solution
from undertow.likelihood.problem import Problem, TrialProblem
from undertow.likelihood.residuals import parameter_vector, residuals
from undertow.recording.recording import Array
from undertow.uncertainty.hierarchy import Effect, scatters_seen
from undertow.uncertainty.profile import as_noisy
from undertow.uncertainty.seeds import random_numbers

CANDIDATES = 2
"""Candidates a draw: resampled to equal weights, few of them are then drawn twice."""

FEWEST_EFFECTIVE = 100.0
"""Effective number of draws below which intervals from them are a rough guess."""

WIDE_SHARE = 0.1
"""Share of the candidates whose scatter is drawn as the dry trials alone leave it: should the linear view of these
trials be wrong, no weight exceeds ten times the mean for it."""

FLATTEST = 1e-12
"""Smallest curvature of a proposal over its largest: less is rounding."""


@dataclass(frozen=True)
class Draws:
    """Equally weighted draws: ``values`` name -> (n,); ``effective`` is how many independent draws the weights are
    worth (of ``candidates``), ``outcome`` "ok" or a sentence."""

    values: Mapping[str, Array]
    effective: float
    candidates: int
    outcome: str

    def quantiles(self, name: str, level: float = 0.9) -> tuple[float, float]:
        """Ends of the interval that holds ``level`` of one parameter's draws."""
        low, high = np.quantile(self.values[name], [0.5 - 0.5 * level, 0.5 + 0.5 * level])
        return float(low), float(high)


def posterior_draws(
    solution: Solution, draws: int, seed: int, effects: Sequence[Effect] = (), names: Sequence[str] = ()
) -> Draws:
    """Draws of a fit's unknowns (``names``: of these; none: of all).

    ``effects`` are what differs from trial to trial: their scatter is drawn with its degrees of freedom.

    Raises IdentificationError for fewer than two draws or an unknown name.
    """
    if draws < 2:
        raise IdentificationError(f"draws is {draws}; a posterior needs at least 2, and 1000 for its intervals")
    kept = names or solution.problem.names
    unknown = [name for name in kept if name not in solution.problem.names]
    if unknown:
        raise IdentificationError(f"draws of {unknown[0]!r}: the fit has {', '.join(solution.problem.names)}")
    rng = random_numbers(seed)
    problem = as_noisy(solution)
    best = output_error.fit(problem, solution.values, growing=False)
    candidates, proposed, scale = _proposals(best, CANDIDATES * draws, effects, rng)
    target = _target(problem, scale)
    log_weight = np.array([target(i, one) for i, one in enumerate(candidates)]) - proposed
    weights = _weights(log_weight)
    effective = float(1.0 / np.sum(weights**2))
    chosen = rng.permutation(_resampled(weights, draws, rng))
    at = {name: solution.problem.names.index(name) for name in kept}
    outcome = "ok"
    if effective < FEWEST_EFFECTIVE:
        outcome = (
            f"{len(candidates)} candidates are worth {effective:.0f} draws: the posterior is far from normal; take "
            "confidence_interval(method='profile')"
        )
    return Draws({name: candidates[chosen, i] for name, i in at.items()}, effective, len(candidates), outcome)


def _weights(log_weight: Array) -> Array:
    """Weights that sum to one, the largest cut off at the mean times the root of their number."""
    weights = np.exp(log_weight - np.max(log_weight))
    weights = np.minimum(weights, np.mean(weights) * math.sqrt(weights.size))
    total: Array = weights / np.sum(weights)
    return total


def _resampled(weights: Array, draws: int, rng: np.random.Generator) -> np.ndarray:
    """Systematic resampling: places (draws,) of candidates, each about its weight times the draws."""
    steps = (np.arange(draws) + rng.uniform()) / draws
    return np.minimum(np.searchsorted(np.cumsum(weights), steps), weights.size - 1)


def _proposals(
    best: Solution, count: int, effects: Sequence[Effect], rng: np.random.Generator
) -> tuple[Array, Array, Array]:
    """Candidates (n, p), the logarithm of their proposal density over the probability of their scatter (n,) up to a
    constant, and for each by how much every prior of what scatters is wider than stated (n, p)."""
    problem = best.problem
    noise = rng.standard_normal((count, best.values.size))
    spread = [e for e in effects if math.isfinite(e.freedom) and any(_is_own(n, e.symbol) for n in problem.names)]
    if not spread:
        values, vectors = np.linalg.eigh(best.covariance)
        root = vectors * np.sqrt(np.maximum(values, 0.0))
        return best.values + noise @ root.T, -0.5 * np.sum(noise**2, axis=1), np.ones(noise.shape)
    shared = [i for i, name in enumerate(problem.names) if not name.endswith(("]", "_mean"))]
    seen = scatters_seen(best, shared, spread)
    likely = (1.0 - WIDE_SHARE) * seen.posterior + WIDE_SHARE * seen.prior
    cells = rng.choice(likely.size, count, p=likely / np.sum(likely))
    scales = np.ones((likely.size, best.values.size))
    for j, effect in enumerate(seen.effects):
        columns = [i for i, n in enumerate(problem.names) if n == f"{effect.symbol}_mean" or _is_own(n, effect.symbol)]
        scales[:, columns] = seen.ratios[:, [j]]
    out, density = _given_scales(best, scales, cells, noise)
    return out, density + np.log(likely[cells]) - np.log(seen.prior[cells]), scales[cells]


def _given_scales(best: Solution, scales: Array, cells: np.ndarray, noise: Array) -> tuple[Array, Array]:
    """Candidates (n, p) of the normal distribution about the best point with priors ``scales[cell]`` times as wide, and
    the logarithm of their density (n,)."""
    centres, precision = best.problem.believed
    unit = np.sqrt(np.diag(best.covariance))
    unit[~(unit > 0.0)] = 1.0  # stiffness and friction coefficient are seven decades apart: in standard errors instead
    normal = np.linalg.pinv(best.covariance / np.outer(unit, unit), hermitian=True)
    pull, start = normal @ (best.values / unit), centres / unit
    precision = precision * unit**2
    out, density = np.empty(noise.shape), np.empty(noise.shape[0])
    for cell in np.unique(cells):
        wider = precision * (1.0 / scales[cell] ** 2 - 1.0)
        values, vectors = np.linalg.eigh(normal + np.diag(wider))
        values = np.maximum(values, FLATTEST * values[-1])
        centre = vectors @ ((vectors.T @ (pull + wider * start)) / values)
        of = np.flatnonzero(cells == cell)
        out[of] = unit * (centre + (noise[of] / np.sqrt(values)) @ vectors.T)
        density[of] = -0.5 * np.sum(noise[of] ** 2, axis=1) + 0.5 * np.sum(np.log(values))
    return out, density


def _is_own(name: str, symbol: str) -> bool:
    """Whether an unknown is one trial's own deviation of what scatters."""
    return name.startswith(f"{symbol}[")


def _target(problem: Problem, scale: Array) -> Callable[[int, Array], float]:
    """Logarithm of likelihood times prior of candidate i at its values, up to a constant; -inf out of bounds."""
    lower, upper = problem.bounds
    start, precision = problem.believed
    scatters = np.any(scale != 1.0, axis=0)
    chi2 = _misfit(problem)

    def log_density(i: int, values: Array) -> float:
        if np.any(values < lower) or np.any(values > upper):
            return -math.inf
        prior = -0.5 * float(np.sum(precision * ((values - start) / scale[i]) ** 2))
        return prior - float(np.sum(np.log(scale[i, scatters]))) - 0.5 * chi2(values)

    return log_density


def _misfit(problem: Problem) -> Callable[[Array], float]:
    """Sum of squared weighted residuals, inf without bounds: by the compiled twin of Eq. 15 where that has a motion."""
    fast = eq15.misfit(problem) if eq15.is_plain(problem) else None

    def chi2(values: Array) -> float:
        found = math.nan if fast is None else fast(values)
        return sum(_trial(trial, values) for trial in problem.trials) if math.isnan(found) else found

    return chi2


def _trial(trial: TrialProblem, values: Array) -> float:
    """One trial's share of it, without sensitivities: its parameters are held at the values; inf without bounds."""
    found = residuals(replace(trial, base=parameter_vector(trial, values), links=()), values)
    return math.inf if found is None else float(found[0] @ found[0])
