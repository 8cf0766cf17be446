"""Which columns explain a response: every subset is tried, none is missed.

`BestSubset` is a pysindy optimiser, at home in ``pysindy.SINDy(optimizer=BestSubset())``; nobody has to choose a
threshold. The search works on the Gram matrix of the columns, so that a million subsets take about a second.

Belongs here: the optimiser and the effective number of samples. Does not belong here: the search over subsets
(search.py), what the columns are (library.py) or what they mean (sindy.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from pysindy.optimizers.base import BaseOptimizer

from undertow.errors import IdentificationError
from undertow.identification.search import Candidate, Step, SubsetSearch, search_subsets

Array = NDArray[np.float64]

MEMORY_SHARE = 0.1
"""Lags up to this share of a trial enter its autocorrelation: longer ones are mostly the estimate's own noise."""

WINDOW_TIMES = 6.0
"""Lags are summed up to this many correlation times (Sokal 1997, doi:10.1007/978-1-4899-0319-8_6)."""

MIN_ROWS_PER_COLUMN = 2
"""Rows needed for each column, so that the residual of the full model says something about the noise."""


class BestSubset(BaseOptimizer):  # type: ignore[misc]
    """Exact best subset by BIC with effective samples, as a pysindy optimiser.

    Among all subsets S of the free columns the one with the smallest

        n_eff ln(RSS_S) + |S| ln(n_eff)

    is taken, where n_eff is the number of rows divided by the correlation time of the full model's residual as the
    columns see it (Bartlett 1946): ten times as many rows of the same signal give the same verdict. Rows that are zero
    throughout count as absent, so that a gap in a trial keeps its length in time.

    Parameters
    ----------
    forced : columns known to be there; every subset holds them.
    nuisance : columns that are fitted but never judged, such as a constant for each trial.
    signs : column -> +1 or -1, the only sign its coefficient may have; a subset that breaks it is refused. This is
        exact: where the best coefficient within the sign is 0, the subset without the column has been tried too.
    trial_lengths : rows of each trial in their order; None takes all rows as one trial.
    rival_difference : subsets within this difference of the criterion are reported as rivals. 6 is odds of 20 to 1.
    n_effective : effective number of samples where it is known; None takes it from the residual.
    copy_X : as in pysindy.

    Attributes
    ----------
    coef_ : (n_targets, n_features) coefficients, exactly 0 outside the support.
    support_ : (n_targets, n_features) True where a column is in the equation, nuisance included.
    searches_ : one `SubsetSearch` a target.
    trace_ : a target's steps from the full model down: which column was dropped at which cost; one tuple a target.
    rivals_ : a target's subsets within `rival_difference` of the best; one tuple a target.
    n_effective_ : (n_targets,) effective numbers of samples.

    Raises
    ------
    IdentificationError
        Too few rows, more than 20 free columns, a column index or a sign that is none, nothing left by the signs.

    >>> rng = np.random.default_rng(0)
    >>> X = rng.standard_normal((200, 5))
    >>> BestSubset().fit(X, 3.0 * X[:, [1]] + 0.1 * rng.standard_normal((200, 1))).support_
    array([[False,  True, False, False, False]])
    """

    def __init__(
        self,
        forced: Sequence[int] = (),
        nuisance: Sequence[int] = (),
        signs: Mapping[int, int] | None = None,
        trial_lengths: Sequence[int] | None = None,
        rival_difference: float = 6.0,
        n_effective: float | None = None,
        copy_X: bool = True,
    ) -> None:
        super().__init__(copy_X=copy_X, unbias=False)
        self.forced = forced
        self.nuisance = nuisance
        self.signs = signs
        self.trial_lengths = trial_lengths
        self.rival_difference = rival_difference
        self.n_effective = n_effective

    def _reduce(self, x: Array, y: Array) -> None:
        """Search the subsets of each target; called by pysindy's ``fit`` with x (n, p) and y (n, targets)."""
        lengths = self._lengths(x.shape[0])
        self._check_columns(x)
        coefficients = np.zeros((y.shape[1], x.shape[1]))
        searches = []
        for target in range(y.shape[1]):
            response = np.asarray(y[:, target], dtype=np.float64)
            search, coefficients[target] = self._search(x, response, lengths)
            searches.append(search)
        self.coef_ = coefficients
        self.searches_: tuple[SubsetSearch, ...] = tuple(searches)
        self.support_ = np.array([search.support(x.shape[1], self.nuisance) for search in searches])
        self.trace_: tuple[tuple[Step, ...], ...] = tuple(search.trace for search in searches)
        self.rivals_: tuple[tuple[Candidate, ...], ...] = tuple(search.rivals for search in searches)
        self.n_effective_ = np.array([search.n_effective for search in searches])

    def _search(self, x: Array, y: Array, lengths: Sequence[int]) -> tuple[SubsetSearch, Array]:
        judged = [column for column in range(x.shape[1]) if column not in set(self.nuisance)]
        nuisance = x[:, list(self.nuisance)]
        columns, response = project_out(nuisance, x[:, judged]), project_out(nuisance, y[:, None])[:, 0]
        scale = np.linalg.norm(columns, axis=0)
        scale[scale <= np.finfo(float).eps * np.linalg.norm(x[:, judged], axis=0)] = 1.0
        columns = columns / scale
        n_effective = self.n_effective
        if n_effective is None:
            residual = response - columns @ np.linalg.lstsq(columns, response, rcond=None)[0]
            n_effective = effective_samples(residual, columns, lengths)
        search = search_subsets(
            columns,
            response,
            labels=tuple(judged),
            forced=tuple(self.forced),
            signs=dict(self.signs or {}),
            n_effective=n_effective,
            rival_difference=self.rival_difference,
        )
        coefficients = np.zeros(x.shape[1])
        kept = [*search.best.columns, *self.nuisance]
        coefficients[kept] = np.linalg.lstsq(x[:, kept], y, rcond=None)[0]
        return search, coefficients

    def _lengths(self, rows: int) -> tuple[int, ...]:
        lengths = (rows,) if self.trial_lengths is None else tuple(int(length) for length in self.trial_lengths)
        if sum(lengths) != rows:
            raise IdentificationError(
                f"trial_lengths add up to {sum(lengths)} rows but the columns have {rows}; "
                "give the rows of each trial in the order of the columns"
            )
        return lengths

    def _check_columns(self, x: Array) -> None:
        rows, columns = int(np.count_nonzero(np.any(x != 0.0, axis=1))), x.shape[1]
        if rows < MIN_ROWS_PER_COLUMN * columns:
            raise IdentificationError(
                f"{rows} rows for {columns} columns; a best subset needs at least {MIN_ROWS_PER_COLUMN} rows a column: "
                "use a longer window or fewer terms"
            )
        for name, chosen in (("forced", self.forced), ("nuisance", self.nuisance), ("signs", self.signs or {})):
            for column in chosen:
                if not 0 <= column < columns:
                    raise IdentificationError(
                        f"{name} names column {column}; there are columns 0 to {columns - 1}"
                    )
        both = sorted(set(self.forced) & set(self.nuisance))
        if both:
            raise IdentificationError(f"columns {both} are both forced and nuisance; a nuisance is always there")
        for column, sign in (self.signs or {}).items():
            if sign not in (-1, 1):
                raise IdentificationError(f"the sign of column {column} is {sign!r}; give +1 or -1, or leave it out")


def project_out(nuisance: Array, values: Array) -> Array:
    """``values`` (n, q) less their least-squares image in the ``nuisance`` columns (n, r); r may be 0."""
    if nuisance.shape[1] == 0:
        return values
    basis, _ = np.linalg.qr(nuisance)
    remainder: Array = values - basis @ (basis.T @ values)
    return remainder


def effective_samples(residual: Array, columns: Array, lengths: Sequence[int]) -> float:
    """Independent samples in ``residual`` (n,) as far as coefficients of ``columns`` (n, p) are concerned.

    Trial i of n_i rows counts n_i / tau_i, where tau = sum over lags of rho_residual(lag) rho_column(lag), the factor
    by which correlation widens the variance of a coefficient (Bartlett 1946, doi:10.2307/2983611), averaged over the
    columns. Rows with residual and columns all zero are gaps. tau below 1 is taken as 1.

    >>> rng = np.random.default_rng(1)
    >>> noise, column = rng.standard_normal(4000), np.sin(np.arange(4000) / 50.0)[:, None]
    >>> held = effective_samples(np.repeat(noise, 10), np.repeat(column, 10, axis=0), [40000])
    >>> 0.7 < held / effective_samples(noise, column, [4000]) < 1.3
    True
    """
    total, first = 0.0, 0
    for length in lengths:
        part = slice(first, first + length)
        first += length
        present = np.any(columns[part] != 0.0, axis=1)
        rows = int(np.count_nonzero(present))
        if rows:
            total += rows / _correlation_time(residual[part], columns[part])
    return max(total, float(columns.shape[1] + 1))


def _correlation_time(residual: Array, columns: Array) -> float:
    """Bartlett's factor of one trial, summed over `WINDOW_TIMES` times the residual's own correlation time."""
    lags = max(1, int(MEMORY_SHARE * residual.size))
    residual_covariance = _autocovariance(residual[:, None], lags)[:, 0]
    column_covariance = _autocovariance(columns, lags)
    moving = column_covariance[0] > 0.0
    if residual_covariance[0] <= 0.0 or not np.any(moving):
        return 1.0
    own = residual_covariance / residual_covariance[0]
    times = 2.0 * np.cumsum(np.abs(own)) - 1.0
    long_enough = np.flatnonzero(np.arange(1, lags + 1) >= WINDOW_TIMES * times)
    window = int(long_enough[0]) + 1 if long_enough.size else lags
    correlation = column_covariance[:window, moving] / column_covariance[0, moving]
    factors = 2.0 * own[:window] @ correlation - 1.0
    return max(1.0, float(np.mean(factors)))


def _autocovariance(values: Array, lags: int) -> Array:
    """Sums of products at lags 0 to lags - 1 of each column of ``values`` (n, p): (lags, p)."""
    size = 2 ** int(np.ceil(np.log2(2 * values.shape[0])))
    spectrum = np.fft.rfft(values, size, axis=0)
    products: Array = np.fft.irfft(np.abs(spectrum) ** 2, size, axis=0)[:lags]
    return products
