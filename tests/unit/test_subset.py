"""The best-subset optimiser: exact, sign-aware, honest about correlated noise, and a good citizen of pysindy."""

import itertools
import pickle

import numpy as np
import pysindy
import pytest
from scipy.integrate import solve_ivp
from sklearn.base import clone

from undertow.errors import IdentificationError
from undertow.methods.exact_subsets import residual_sums, search_subsets
from undertow.methods.subset import (
    BestSubset,
    autocovariance,
    effective_samples,
    project_out,
    score_matrix,
)


def planted(rows=400, columns=7, noise=0.3, seed=0):
    """Columns, a response of columns 1 (2.0) and 4 (-0.5), and the truth."""
    rng = np.random.default_rng(seed)
    x = rng.standard_normal((rows, columns))
    truth = np.zeros(columns)
    truth[1], truth[4] = 2.0, -0.5
    return x, (x @ truth + noise * rng.standard_normal(rows))[:, None], truth


def smooth_noise(rng, rows, width):
    """White noise averaged over ``width`` rows, unit variance."""
    return np.convolve(rng.standard_normal(rows + width - 1), np.ones(width) / np.sqrt(width), "valid")


def test_residual_sums_equal_least_squares_of_every_subset():
    x, y, _ = planted(rows=50, columns=5)
    stacked = np.column_stack([x / np.linalg.norm(x, axis=0), y])
    sums = residual_sums(stacked.T @ stacked)
    for mask in range(32):
        chosen = [j for j in range(5) if mask >> j & 1]
        fitted = x[:, chosen] @ np.linalg.lstsq(x[:, chosen], y, rcond=None)[0] if chosen else 0.0
        assert sums[mask] == pytest.approx(float(np.sum((y - fitted) ** 2)), rel=1e-10)  # rounding of 5 eliminations


def test_planted_columns_are_found_and_refitted_without_shrinking():
    x, y, truth = planted()
    optimizer = BestSubset().fit(x, y)
    assert np.array_equal(optimizer.support_[0], truth != 0.0)
    chosen = truth != 0.0
    assert optimizer.coef_[0, chosen] == pytest.approx(np.linalg.lstsq(x[:, chosen], y, rcond=None)[0][:, 0])
    assert np.all(optimizer.coef_[0, ~chosen] == 0.0)


def test_white_noise_alone_selects_nothing_in_nine_of_ten_draws():
    empty = 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        optimizer = BestSubset().fit(rng.standard_normal((500, 6)), rng.standard_normal((500, 1)))
        empty += not optimizer.support_.any()
    # chance of one of six columns above ln(500) + ln(6) = 8.0 is 6 * P(chi2_1 > 8.0) = 3 %
    assert empty >= 36


def test_scale_of_a_column_changes_nothing_but_its_coefficient():
    x, y, truth = planted()
    scale = np.array([1e-6, 1e5, 1.0, 1e8, 1e-3, 1.0, 10.0])
    optimizer = BestSubset().fit(x * scale, y)
    assert np.array_equal(optimizer.support_[0], truth != 0.0)
    assert optimizer.coef_[0] * scale == pytest.approx(BestSubset().fit(x, y).coef_[0], abs=1e-12)


def test_ten_times_the_rate_of_the_same_signal_gives_the_same_verdict():
    kept = {}
    for rate in (1, 10):
        rng = np.random.default_rng(5)
        t = np.arange(2000 * rate) / rate
        x = np.column_stack([np.sin(t / 8.0), np.cos(t / 8.0), np.sin(t / 5.0)])
        slow = np.repeat(rng.standard_normal(2000), rate)
        optimizer = BestSubset().fit(x, (x[:, 0] + 0.5 * slow)[:, None])
        kept[rate] = optimizer.support_[0].tolist(), float(optimizer.n_effective_[0])
    assert kept[1][0] == kept[10][0] == [True, False, False]
    assert kept[10][1] == pytest.approx(kept[1][1], rel=0.2)  # the noise is the same, held ten rows long


def test_correlated_noise_does_not_pass_for_signal():
    wrong_effective = wrong_rows = 0
    for seed in range(30):
        rng = np.random.default_rng(seed)
        t = np.arange(3000) / 100.0
        x = np.column_stack([np.sin(6.0 * t), *(np.sin(w * t + 1.0) for w in (3.0, 4.1, 5.3, 7.2))])
        y = (x[:, 0] + smooth_noise(rng, 3000, 40))[:, None]
        wrong_effective += BestSubset().fit(x, y).support_[0, 1:].any()
        wrong_rows += BestSubset(n_effective=3000).fit(x, y).support_[0, 1:].any()
    assert wrong_effective <= 5  # 75 independent samples: 4 columns * P(chi2_1 > ln 75 + ln 5) = 6 %
    assert wrong_rows >= 20


def test_score_matrix_is_the_covariance_of_repeated_scores():
    rng = np.random.default_rng(0)
    columns = np.column_stack([np.sin(np.arange(600) / 20.0), np.sin(np.arange(600) / 2.5)])
    noise = [smooth_noise(rng, 600, 12) for _ in range(2000)]
    found = np.cov(np.array(noise) @ columns, rowvar=False)
    exact = np.maximum(1.0 - np.arange(12) / 12.0, 0.0)  # autocovariance of a mean of 12, scaled to variance 1
    claimed = score_matrix(columns, exact, [600])
    assert np.diag(claimed) == pytest.approx(np.diag(found), rel=0.12)  # 2000 draws: 3 % a variance
    assert claimed[0, 0] > 5.0 * claimed[1, 1]  # slow noise disturbs the slow column


def test_noise_is_not_taken_as_correlated_across_trials():
    columns, covariance = np.ones((40, 1)), np.array([1.0, 0.9, 0.8])
    joined, apart = score_matrix(columns, covariance, [40]), score_matrix(columns, covariance, [20, 20])
    assert joined[0, 0] - apart[0, 0] == pytest.approx(2.0 * (0.9 + 0.8 + 0.8))


def test_a_trial_without_rows_changes_nothing():
    rng = np.random.default_rng(3)
    residual, columns = rng.standard_normal(200), rng.standard_normal((200, 2))
    with_none = autocovariance(residual, (120, 0, 80), 10)
    assert with_none == pytest.approx(autocovariance(residual, (120, 80), 10))
    assert score_matrix(columns, with_none, (0, 120, 80)) == pytest.approx(score_matrix(columns, with_none, (120, 80)))


def test_effective_samples_of_white_noise_are_its_rows():
    rng = np.random.default_rng(0)
    residual, column = rng.standard_normal(4000), np.sin(np.arange(4000) / 30.0)[:, None]
    covariance = autocovariance(residual, [4000])
    assert covariance.size < 20
    found = effective_samples(column, score_matrix(column, covariance, [4000]), covariance[0])
    assert found == pytest.approx(4000, rel=0.1)


def test_a_sign_constraint_refuses_the_wrong_sign_and_keeps_the_right_one():
    x, y, truth = planted()
    refused = BestSubset(signs={4: 1}).fit(x, y)
    assert not refused.support_[0, 4]
    assert refused.searches_[0].evidence[4] < 0.0
    allowed = BestSubset(signs={4: -1, 1: 1}).fit(x, y)
    assert np.array_equal(allowed.support_[0], truth != 0.0)


def test_sign_constrained_search_equals_brute_force():
    x, y, _ = planted(rows=60, columns=5, noise=1.5, seed=3)
    full = y[:, 0] - x @ np.linalg.lstsq(x, y[:, 0], rcond=None)[0]
    variance = float(full @ full) / 55.0
    signs = {0: 1, 1: -1, 4: 1}
    best = (np.inf, ())
    for size in range(6):
        for chosen in itertools.combinations(range(5), size):
            values, sums = np.zeros(0), float(y[:, 0] @ y[:, 0])
            if chosen:
                values = np.linalg.lstsq(x[:, chosen], y[:, 0], rcond=None)[0]
                sums = float(np.sum((y[:, 0] - x[:, chosen] @ values) ** 2))
            if all(signs.get(j, np.sign(v)) * v >= 0.0 for j, v in zip(chosen, values, strict=True)):
                best = min(best, (sums / variance + size * np.log(60 * 5), chosen))
    found = BestSubset(signs=signs, n_effective=60).fit(x, y)
    assert tuple(np.flatnonzero(found.support_[0])) == best[1]


def test_grouped_search_equals_brute_force():
    x, y, _ = planted(noise=1.5)
    plain = BestSubset(rival_difference=np.inf).fit(x, y).searches_[0]
    together, exclusive = ((0, 1),), ((4, 2, 6),)
    grouped = BestSubset(rival_difference=np.inf, together=together, exclusive=exclusive).fit(x, y).searches_[0]

    def allowed(candidate):
        chosen = set(candidate.columns)
        return len(chosen & {0, 1}) in (0, 2) and len(chosen & {4, 2, 6}) <= 1

    every = [candidate for candidate in (plain.best, *plain.rivals) if allowed(candidate)]
    found = [grouped.best, *grouped.rivals]
    assert {candidate.columns for candidate in found} == {candidate.columns for candidate in every}
    assert grouped.best.columns == min(every, key=lambda candidate: candidate.criterion).columns


def test_a_group_with_a_forced_member_is_in_as_a_whole():
    x, y, _ = planted()
    assert BestSubset(forced=(0,), together=((0, 3),)).fit(x, y).searches_[0].best.columns == (0, 1, 3, 4)


def test_information_and_estimates_give_the_misfits_back():
    x, y, _ = planted()
    optimizer = BestSubset(nuisance=(6,)).fit(x, y)
    information, theta = optimizer.information_[0], optimizer.estimates_[0]
    assert theta[:6] == pytest.approx(np.linalg.lstsq(x, y, rcond=None)[0][:6, 0])
    again = search_subsets(information, information @ theta, range(6), optimizer.n_effective_[0])
    assert again.best.criterion == pytest.approx(optimizer.searches_[0].best.criterion)


def test_forced_columns_stay_and_nuisance_is_fitted_but_never_counted():
    x, y, _ = planted()
    shifted = np.hstack([x, np.ones((400, 1))])
    optimizer = BestSubset(forced=(0,), nuisance=(7,)).fit(shifted, y + 5.0)
    assert np.flatnonzero(optimizer.support_[0]).tolist() == [0, 1, 4, 7]
    assert optimizer.coef_[0, 7] == pytest.approx(5.0, abs=0.06)  # 4 standard errors of a mean over 400 rows
    assert optimizer.searches_[0].best.columns == (0, 1, 4)


def test_two_equal_columns_are_each_others_rival():
    x, y, _ = planted()
    rng = np.random.default_rng(9)
    twin = x[:, [1]] + 0.01 * rng.standard_normal((400, 1))
    search = BestSubset().fit(np.hstack([x, twin]), y).searches_[0]
    supports = [search.best.columns, *(rival.columns for rival in search.rivals)]
    assert (1, 4) in supports
    assert (4, 7) in supports


def test_an_exact_copy_of_a_column_is_not_taken_twice():
    x, y, _ = planted()
    support = BestSubset().fit(np.hstack([x, x[:, [1]]]), y).support_[0]
    assert support[[1, 7]].sum() == 1


def test_clone_pickle_and_get_params_round_trip():
    optimizer = BestSubset(forced=(1,), signs={4: -1}, rival_difference=3.0)
    assert clone(optimizer).get_params() == optimizer.get_params()
    x, y, _ = planted()
    fitted = pickle.loads(pickle.dumps(optimizer.fit(x, y)))  # noqa: S301 - our own bytes
    assert np.array_equal(fitted.coef_, optimizer.coef_)


def test_lorenz_is_found_inside_plain_pysindy():
    def lorenz(_, z):
        return [10.0 * (z[1] - z[0]), z[0] * (28.0 - z[2]) - z[1], z[0] * z[1] - 8.0 / 3.0 * z[2]]

    t = np.arange(0.0, 10.0, 0.002)
    path = solve_ivp(lorenz, (0.0, 10.0), [-8.0, 8.0, 27.0], t_eval=t, rtol=1e-10, atol=1e-10).y.T
    noisy = path + 0.05 * np.random.default_rng(0).standard_normal(path.shape)
    model = pysindy.SINDy(optimizer=BestSubset(), feature_library=pysindy.PolynomialLibrary(2))
    model.fit(noisy, t=0.002)
    names = model.get_feature_names()
    found = [{names[j] for j in np.flatnonzero(row)} for row in model.optimizer.support_]
    assert found == [{"x0", "x1"}, {"x0", "x1", "x0 x2"}, {"x2", "x0 x1"}]


def test_project_out_leaves_nothing_of_the_nuisance():
    rng = np.random.default_rng(0)
    nuisance, values = rng.standard_normal((30, 3)), rng.standard_normal((30, 2))
    assert np.abs(nuisance.T @ project_out(nuisance, values)).max() < 1e-12
    assert project_out(np.empty((30, 0)), values) is values


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"trial_lengths": (100, 200)}, r"trial_lengths add up to 300 rows but the columns have 400"),
        ({"forced": (9,)}, r"forced names column 9; there are columns 0 to 6"),
        ({"nuisance": (-1,)}, r"nuisance names column -1"),
        ({"forced": (2,), "nuisance": (2,)}, r"columns \[2\] are both forced and nuisance"),
        ({"signs": {1: 2}}, r"the sign of column 1 is 2; give \+1 or -1"),
        ({"forced": (4,), "signs": {4: 1}}, r"none of 64 subsets obeys the signs \{4: 1\}"),
        ({"together": ((1, 9),)}, r"together names column 9; there are columns 0 to 6"),
        ({"exclusive": ((-2, 1),)}, r"exclusive names column -2; there are columns 0 to 6"),
        ({"forced": (1, 4), "exclusive": ((1, 4),)}, r"none of 32 subsets.*exclusive \[\[1, 4\]\]; .*loosen a group"),
    ],
)
def test_settings_that_cannot_be_met_are_named(settings, message):
    x, y, _ = planted()
    with pytest.raises(IdentificationError, match=message):
        BestSubset(**settings).fit(x, y)


def test_too_few_rows_and_too_many_columns_are_refused():
    x, y, _ = planted(rows=10)
    with pytest.raises(IdentificationError, match=r"10 rows for 7 columns.*at least 2 rows a column"):
        BestSubset().fit(x, y)
    rng = np.random.default_rng(0)
    with pytest.raises(IdentificationError, match=r"21 free columns; all subsets can be tried up to 20"):
        BestSubset().fit(rng.standard_normal((100, 21)), rng.standard_normal((100, 1)))


def test_forced_columns_that_are_the_same_force_are_refused():
    x, y, _ = planted()
    doubled = np.hstack([x, x[:, [1]]])
    with pytest.raises(IdentificationError, match=r"forced columns \[1, 7\] are combinations of each other"):
        BestSubset(forced=(1, 7)).fit(doubled, y)


def test_misfit_of_a_subset_is_the_chi_squared_of_what_it_leaves_out():
    rng = np.random.default_rng(2)
    root = rng.standard_normal((5, 5))
    information, theta = root @ root.T, rng.standard_normal(5)
    search = search_subsets(information, information @ theta, range(5), n_effective=1.0 + 1e-9, rival_difference=np.inf)
    assert len(search.rivals) == 2**5 - 1
    covariance = np.linalg.inv(information)
    for one in (search.best, *search.rivals):
        left = [j for j in range(5) if j not in one.columns]
        chi2 = theta[left] @ np.linalg.solve(covariance[np.ix_(left, left)], theta[left])
        assert one.criterion - len(one.columns) * np.log(5.0) == pytest.approx(chi2, abs=1e-6)
