"""Numbers that the tables show: limits, fits of power, calibration. No verdicts here, only counts and lists."""

import math

import numpy as np
from scipy.optimize import minimize
from scipy.special import expit
from scipy.stats import beta, binom, kstest, norm

SURE = 1e-3  # confidences are kept this far from 0 and 1
MOST_LAPSES = 0.45  # of a share that is missed however strong it is: with half of all there is no half power


def upper_limit(hits: int, n: int, level: float = 0.95) -> float:
    """One-sided Clopper-Pearson upper limit of a share; 1 where nothing was counted."""
    return 1.0 if n == 0 or hits >= n else float(beta.ppf(level, hits + 1, n - hits))


def interval(hits: int, n: int, level: float = 0.90) -> tuple[float, float]:
    """Two-sided Clopper-Pearson interval of a share."""
    if n == 0:
        return 0.0, 1.0
    tail = 0.5 * (1.0 - level)
    low = 0.0 if hits == 0 else float(beta.ppf(tail, hits, n - hits + 1))
    high = 1.0 if hits == n else float(beta.ppf(1.0 - tail, hits + 1, n - hits))
    return low, high


def uniformity(values: list[float]) -> dict[str, float]:
    """Kolmogorov-Smirnov of p-values against the uniform law, and the shares below .01, .05 and .1."""
    if not values:
        return {"n": 0.0}
    p = np.asarray(values)
    test = kstest(p, "uniform")
    return {
        "n": float(p.size),
        "ks": float(test.statistic),
        "ks_p": float(test.pvalue),
        "below_01": float(np.mean(p <= 0.01)),
        "below_05": float(np.mean(p <= 0.05)),
        "below_10": float(np.mean(p <= 0.1)),
    }


def half_power(strength: list[float], hit: list[bool]) -> dict[str, float] | None:
    """Where the share of hits passes one half: a probit against log strength times (1 - lapse), with a small ridge.

    The lapse is the share that is missed however strong it is, as for psychometric functions (Wichmann and Hill 2001):
    without it a few such misses turn the curve about the half, which then says nothing of where that lies. None where
    it cannot be fitted.
    """
    s, y = np.log(np.asarray(strength)), np.asarray(hit, dtype=float)
    if s.size < 10 or y.min() == y.max():
        return None

    def loss(p: np.ndarray) -> float:
        chance = np.clip((1.0 - MOST_LAPSES * expit(p[2])) * norm.cdf(p[1] * (s - p[0])), 1e-9, 1.0 - 1e-9)
        likely = np.sum(y * np.log(chance) + (1.0 - y) * np.log(1.0 - chance))
        return float(-likely + 0.01 * (p[1] - 1.0) ** 2 + 0.01 * p[2] ** 2)

    starts = np.quantile(s, [0.25, 0.5, 0.75])
    options = {"xatol": 1e-6, "fatol": 1e-9, "maxiter": 5000}
    fits = [minimize(loss, np.array([at, 1.0, -2.0]), method="Nelder-Mead", options=options) for at in starts]
    middle, slope, lapse = min(fits, key=lambda fit: float(fit.fun)).x
    lapse = MOST_LAPSES * float(expit(lapse))
    half = math.exp(middle + float(norm.ppf(0.5 / (1.0 - lapse))) / slope)
    return {"half": half, "slope": float(slope), "lapse": lapse, "n": float(s.size)}


def calibration(
    confidence: list[float], right: list[bool], weights: list[float] | None = None
) -> dict[str, float] | None:
    """Logistic regression of right on logit(confidence), the log score, and that of a calibrated forecaster."""
    if len(confidence) < 10 or all(right) or not any(right):
        return None
    c = np.clip(np.asarray(confidence, dtype=float), SURE, 1.0 - SURE)
    y = np.asarray(right, dtype=float)
    w = np.ones_like(c) if weights is None else np.asarray(weights, dtype=float)
    w = w / np.mean(w)
    logit = np.log(c / (1.0 - c))

    def loss(p: np.ndarray) -> tuple[float, np.ndarray]:
        z = p[0] + p[1] * logit
        over = w * (expit(z) - y)
        return float(np.sum(w * (np.logaddexp(0.0, z) - y * z))), np.array([np.sum(over), over @ logit])

    fit = minimize(loss, np.array([0.0, 1.0]), method="BFGS", jac=True)
    score = float(np.sum(w * (y * np.log(c) + (1.0 - y) * np.log(1.0 - c))) / np.sum(w))
    ideal = float(np.sum(w * (c * np.log(c) + (1.0 - c) * np.log(1.0 - c))) / np.sum(w))
    return {
        "n": float(c.size),
        "intercept": float(fit.x[0]),
        "slope": float(fit.x[1]),
        "log_score": score,
        "calibrated_log_score": ideal,
    }


def by_chance(confidence: list[float], draws: int = 100) -> tuple[tuple[float, float], tuple[float, float]] | None:
    """Ranges that hold slope and intercept of a forecaster whose confidence is true in 90 % of such samples; None where
    few of them have any."""
    rng, c = np.random.default_rng(0), np.asarray(confidence, dtype=float)
    drawn = [calibration(confidence, (rng.random(c.size) < c).tolist()) for _ in range(draws)]
    fits = [fit for fit in drawn if fit is not None]
    if 2 * len(fits) < draws:
        return None
    slope, intercept = (np.quantile([fit[name] for fit in fits], [0.05, 0.95]) for name in ("slope", "intercept"))
    return (float(slope[0]), float(slope[1])), (float(intercept[0]), float(intercept[1]))


def reliability(confidence: list[float], right: list[bool], bins: int = 8) -> list[dict[str, float]]:
    """Bins of equal count: mean confidence, share right, and the 90 % band of the share were the confidence true."""
    if not confidence:
        return []
    c, y = np.asarray(confidence, dtype=float), np.asarray(right, dtype=float)
    order = np.argsort(c, kind="stable")
    out = []
    for part in np.array_split(order, min(bins, c.size)):
        mean, n = float(np.mean(c[part])), part.size
        out.append(
            {
                "n": float(n),
                "confidence": mean,
                "right": float(np.mean(y[part])),
                "low": float(binom.ppf(0.05, n, mean)) / n,
                "high": float(binom.ppf(0.95, n, mean)) / n,
            }
        )
    return out
