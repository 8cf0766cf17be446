"""Which columns explain a response: every subset is tried, none is missed.

`BestSubset` is a pysindy optimiser, at home in ``pysindy.SINDy(optimizer=BestSubset())``; nobody has to choose a
threshold. The search works on the Gram matrix of the columns, so that a million subsets take about a second.

Belongs here: the optimiser. Does not belong here: the search over subsets (exact_subsets.py), the noise's memory
(likelihood/noise.py), what the columns are (library.py) or what they mean (sindy.py).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import chain

import numpy as np
from numpy.typing import NDArray
from pysindy.optimizers.base import BaseOptimizer

from undertow.errors import IdentificationError
from undertow.likelihood.noise import autocovariance, effective_samples, score_matrix
from undertow.methods.exact_subsets import SubsetSearch, search_subsets

Array = NDArray[np.float64]

ROUNDING_SHARE = 1e-11
"""A residual below this share of the response's variance is rounding: both are then explained equally well. Chi-squared
of all columns is then at most 1e15 for 10 000 rows, and its rounding small beside a penalty of ten."""

MIN_ROWS_PER_COLUMN = 2
"""Rows needed for each column, so that the residual of the full model says something about the noise."""


class BestSubset(BaseOptimizer):  # type: ignore[misc]
    """Exact best subset by BIC under correlated noise, as a pysindy optimiser.

    Among all subsets S of the q free columns the one with the smallest extended BIC

        chi2_S + |S| [ln(n_eff) + ln(q)]

    is taken. chi2_S is the Wald statistic of leaving out the others: least-squares coefficients of all columns, with
    the covariance (X'X)^-1 X'RX (X'X)^-1 where R is the autocovariance of the full model's residual. Each column is
    thereby judged by the noise at its own frequencies, and ten times as many rows of the same signal give the same
    verdict. n_eff is the number of rows over the noise's correlation time as the columns see it.

    Parameters
    ----------
    forced : columns known to be there; every subset holds them.
    nuisance : columns that are fitted but never judged, such as a constant for each trial.
    signs : column -> +1 or -1, the only sign its coefficient may have; a subset that breaks it is refused. This is
        exact: where the best coefficient within the sign is 0, the subset without the column has been tried too.
    together : groups of columns that enter all or none, such as a law's coefficient and its inner parameter.
    exclusive : groups of columns of which at most one enters, such as one law with several exponents.
    trial_lengths : rows of each trial in their order; None takes all rows as one trial.
    rival_difference : subsets within this difference of the criterion are reported as rivals. 6 is odds of 20 to 1.
    n_effective : effective number of samples where it is known; None takes the correlation from the residual.
    memory : rows over which the residual may be correlated; None takes six times its own correlation time.
    copy_X : as in pysindy.

    Attributes
    ----------
    coef_ : (n_targets, n_features) coefficients, exactly 0 outside the support.
    support_ : (n_targets, n_features) True where a column is in the equation, nuisance included.
    searches_ : one `SubsetSearch` a target.
    n_effective_ : (n_targets,) effective numbers of samples.
    information_ : a target's information matrix (q, q) of the columns that are judged, in units of ``estimates_``.
    estimates_ : a target's least-squares coefficients (q,) with all judged columns in the equation.

    Raises
    ------
    IdentificationError
        Too few rows, more than 20 free columns, a column index or a sign that is none, nothing left by the
        constraints.

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
        memory: int | None = None,
        copy_X: bool = True,
        together: Sequence[Sequence[int]] = (),
        exclusive: Sequence[Sequence[int]] = (),
    ) -> None:
        super().__init__(copy_X=copy_X, unbias=False)
        self.forced = forced
        self.nuisance = nuisance
        self.signs = signs
        self.trial_lengths = trial_lengths
        self.rival_difference = rival_difference
        self.n_effective = n_effective
        self.memory = memory
        self.together = together
        self.exclusive = exclusive

    def _reduce(self, x: Array, y: Array) -> None:
        """Search the subsets of each target; called by pysindy's ``fit`` with x (n, p) and y (n, targets)."""
        lengths = self._lengths(x.shape[0])
        self._check_columns(x)
        coefficients = np.zeros((y.shape[1], x.shape[1]))
        searches = []
        self.information_: tuple[Array, ...] = ()
        self.estimates_: tuple[Array, ...] = ()
        for target in range(y.shape[1]):
            response = np.asarray(y[:, target], dtype=np.float64)
            search, coefficients[target] = self._search(x, response, lengths)
            searches.append(search)
        self.coef_ = coefficients
        self.searches_: tuple[SubsetSearch, ...] = tuple(searches)
        self.support_ = np.array([search.support(x.shape[1], self.nuisance) for search in searches])
        self.n_effective_ = np.array([search.n_effective for search in searches])

    def _search(self, x: Array, y: Array, lengths: Sequence[int]) -> tuple[SubsetSearch, Array]:
        judged = [column for column in range(x.shape[1]) if column not in set(self.nuisance)]
        nuisance = x[:, list(self.nuisance)]
        columns, response = project_out(nuisance, x[:, judged]), project_out(nuisance, y[:, None])[:, 0]
        scale = np.linalg.norm(columns, axis=0)
        scale[scale <= np.finfo(float).eps * np.linalg.norm(x[:, judged], axis=0)] = 1.0
        columns = columns / scale
        theta = np.linalg.lstsq(columns, response, rcond=None)[0]
        residual = response - columns @ theta
        floor = ROUNDING_SHARE * float(response @ response) / response.size + np.finfo(float).tiny
        if self.n_effective is None:
            covariance = autocovariance(residual, lengths, self.memory)
            covariance[0] = max(covariance[0], floor)
            scores = score_matrix(columns, covariance, lengths)
            n_effective = effective_samples(columns, scores, covariance[0])
        else:
            n_effective = float(self.n_effective)
            variance = max(float(residual @ residual) / response.size, floor)
            scores = columns.T @ columns * variance * response.size / n_effective
        freedom = max(n_effective - columns.shape[1] - len(self.nuisance), 1.0) / n_effective
        gram = columns.T @ columns
        information = freedom * gram @ np.linalg.pinv(scores, hermitian=True) @ gram
        self.information_ += (information * np.outer(scale, scale),)
        self.estimates_ += (theta / scale,)
        search = search_subsets(
            information,
            information @ theta,
            labels=tuple(judged),
            n_effective=n_effective,
            forced=tuple(self.forced),
            signs=dict(self.signs or {}),
            rival_difference=self.rival_difference,
            together=tuple(self.together),
            exclusive=tuple(self.exclusive),
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
        rows, columns = x.shape
        if rows < MIN_ROWS_PER_COLUMN * columns:
            raise IdentificationError(
                f"{rows} rows for {columns} columns; a best subset needs at least {MIN_ROWS_PER_COLUMN} rows a column: "
                "use a longer window or fewer terms"
            )
        settings: dict[str, Iterable[int]] = {
            "forced": self.forced, "nuisance": self.nuisance, "signs": self.signs or {},
            "together": chain.from_iterable(self.together), "exclusive": chain.from_iterable(self.exclusive),
        }  # fmt: skip
        for name, chosen in settings.items():
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
