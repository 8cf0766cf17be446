"""From subset to subset: ends at the truth from a wrong start, obeys its rules, refines what is inside a law."""

from types import SimpleNamespace

import numpy as np
import pytest

from experiments.structure.truths import OtherBody
from tests.short_trials import LONG, group, per_mass, released
from undertow.comparison import stepwise_selection
from undertow.comparison.inclusion import block_sums, drawn, inclusion
from undertow.comparison.laws import laws
from undertow.comparison.polish import Linear
from undertow.comparison.stepwise_selection import (
    Rules,
    _as_a_line,
    _grown,
    _reweighted,
    _simplest,
    inner_values,
    penalty_of,
    walk,
)
from undertow.comparison.structure import left_over
from undertow.comparison.trajectories import in_cells
from undertow.conditioning.condition import condition
from undertow.equation.hydrodynamics import CubicDamping, DragExponent, QuadraticDrag
from undertow.equation.structure import (
    AsymmetricStiffness,
    CoulombFriction,
    CubicStiffness,
    Stiffness,
    StribeckFriction,
    ViscousDamping,
)

TERMS = (Stiffness(), ViscousDamping(), CoulombFriction(), QuadraticDrag(), CubicStiffness(), CubicDamping())
EQ15 = (0, 1, 2, 3)


def cells(body=LONG, seed=0):
    return [in_cells(condition(recording)) for recording in group(body, seed)]


@pytest.fixture(scope="module")
def trials():
    return cells()


@pytest.fixture(scope="module")
def found(trials):
    """Started from a wrong subset: cubic damping in the drag's place."""
    values = np.array([*per_mass(LONG)[:3], 0.0, 0.0, 0.5])
    return walk(trials, laws(TERMS), (0, 1, 2, 5), values, Rules())


def test_a_wrong_start_walks_to_the_truth(found):
    assert found.chosen == EQ15
    assert found.visited[0][0] == (0, 1, 2, 5)
    assert found.visited[0][1] > found.criterion + 20.0
    assert found.polished.values[:4] == pytest.approx(per_mass(LONG), rel=0.05)


def test_what_is_left_of_the_truth_is_the_noise(found):
    assert left_over(found) == pytest.approx(1.0, abs=0.06)  # 2000 cells: 1.6 %, and noise is estimated within 3 %


def test_the_criterion_is_misfit_and_a_price_for_every_number(found):
    price = found.penalty * len(found.book.columns(found.chosen))
    assert found.criterion == pytest.approx(found.polished.cost / found.widening + price)
    assert penalty_of(1000.0, 10) == pytest.approx(np.log(1000.0) + np.log(10.0))


def test_known_terms_stay_and_exclusive_ones_do_not_meet(trials):
    start = np.array([*per_mass(LONG), 0.0, 0.0])
    kept = walk(trials, laws(TERMS), EQ15, start, Rules(known=(0, 4)))
    assert set(kept.chosen) == {*EQ15, 4}
    apart = walk(trials, laws(TERMS), EQ15, start, Rules(exclusive=((1, 3),)))
    assert not {1, 3} <= set(apart.chosen)
    assert apart.criterion > kept.criterion + 20.0


def test_groups_enter_as_a_whole(trials):
    start = np.array([*per_mass(LONG), 0.0, 0.0])
    whole = walk(trials, laws(TERMS), EQ15, start, Rules(together=((3, 5),)))
    assert {3, 5} <= set(whole.chosen) or not {3, 5} & set(whole.chosen)


def test_an_exponent_is_refined_with_its_law():
    own = (LONG.inertia_kg, LONG.c_Ns_per_m, LONG.k_N_per_m, LONG.friction_N, 0.0)
    trials = cells(OtherBody(*own, power_N=2900.0, exponent=1.5))
    terms = (*TERMS[:3], DragExponent(2.0), CubicStiffness())
    start = np.array([*per_mass(LONG)[:3], 0.0, 0.0, 2.0])
    one = walk(trials, laws(terms), (0, 1, 2), start, Rules(known=(0, 1, 2)))
    assert one.chosen == (0, 1, 2, 3)
    assert one.polished.values[5] == pytest.approx(1.5, abs=0.15)


def test_inner_values_span_bounds_or_the_motions_own_size(trials):
    terms = (Stiffness(), DragExponent(), StribeckFriction())
    book = laws(terms)
    exponents, speeds = (inner_values(trials, book, place) for place in (3, 4))
    assert exponents.min() > 0.5
    assert exponents.max() < 4.0
    top = 0.1 * 2.0 * np.pi / trials[0].period_s
    assert speeds[[0, -1]] == pytest.approx([0.02 * top, 0.5 * top], rel=0.1)  # period and x0 as conditioned


def test_terms_that_are_there_are_found_again_and_others_are_not(found):
    shares = np.array(inclusion(found, resamples=20, seed=1))
    assert np.all(shares[list(EQ15)] >= 0.9)
    assert np.all(shares[4:] <= 0.3)
    assert inclusion(found, resamples=20, seed=1) == tuple(shares.tolist())


def test_too_few_resamples_are_refused(found):
    with pytest.raises(ValueError, match=r"5 resamples give no probability; draw at least 10"):
        inclusion(found, resamples=5)


def test_blocks_add_up_to_the_whole_and_draws_keep_each_parts_count():
    rng = np.random.default_rng(0)
    x, y = rng.standard_normal((230, 3)), rng.standard_normal(230)
    grams, moments, part = block_sums(x, y, (100, 130), 40)
    assert grams.sum(axis=0) == pytest.approx(x.T @ x)
    assert moments.sum(axis=0) == pytest.approx(x.T @ y)
    assert part.tolist() == [0, 0, 1, 1, 1]
    weights = drawn(part, rng)
    assert [weights[part == one].sum() for one in (0, 1)] == [2, 3]


def test_a_library_with_a_useless_law_pays_for_nothing(trials):
    terms = (*TERMS[:4], AsymmetricStiffness())
    one = walk(trials, laws(terms), (0, 1, 2, 3, 4), np.array([*per_mass(LONG), 1.0]), Rules())
    assert one.chosen == EQ15


def test_a_start_that_leads_nowhere_is_walked_on_growing_windows(trials):
    # a quarter more stiffness is out of phase after two periods; polishing the whole decay from there finds nothing
    far = np.array([1.3 * per_mass(LONG)[0], 0.0, 0.0, 0.0, 0.0, 0.0])
    one = walk(trials, laws(TERMS), (0, 1), far, Rules())
    assert one.chosen == EQ15
    assert left_over(one) < 1.1


def test_subsets_are_chosen_on_three_periods_then_six_and_polished_on_the_whole(monkeypatch):
    trials = [in_cells(condition(released(LONG, 0.1, "r", 0, duration_s=12.0)))]
    seen, place = [], SimpleNamespace(chosen=(0, 1), values=np.zeros(6), own=None)

    def noted(kind, result):
        return lambda given, *_: (seen.append((kind, max(float(np.ptp(one.t[:, 0])) for one in given))), result)[1]

    monkeypatch.setattr(stepwise_selection, "polish", noted("polished", place))
    monkeypatch.setattr(stepwise_selection, "walk_on", noted("walked", SimpleNamespace(polished=place)))
    assert _grown(trials, laws(TERMS), (0,), np.zeros(6), Rules()) is place
    period, whole = trials[0].period_s, float(np.ptp(trials[0].t[:, 0]))
    assert 6.0 * period < whole < 12.0 * period
    assert [kind for kind, _ in seen] == ["polished", "walked", "polished", "walked", "polished"]
    lengths = np.array([length for _, length in seen]) / period
    assert lengths == pytest.approx([3.0, 3.0, 6.0, 6.0, whole / period], abs=0.05)  # 20 cells a period


def test_a_start_whose_motion_has_no_end_gives_way_to_a_linear_oscillator_of_the_same_period(trials):
    chosen, values = _as_a_line(trials, laws(TERMS), Rules(known=(2,)))
    assert chosen == (0, 1, 2)
    rate = 2.0 * np.pi / np.median([trial.period_s for trial in trials])
    assert np.sqrt(values[0]) == pytest.approx(rate)
    assert 0.0 < values[1] < 0.05 * rate
    runaway = np.array([*per_mass(LONG)[:3], -80.0, 0.0, 0.0])
    one = walk(trials, laws(TERMS, signs=False), (0, 1, 2, 3), runaway, Rules(signs=False))
    assert set(EQ15) <= set(one.chosen)
    assert left_over(one) < 1.1


def test_a_channel_is_weighed_by_what_the_library_leaves_of_its_own_rows_in_all_trials(trials):
    left = {"displacement": (2.0, 4.0, 4.0), "acceleration": (1.0, 3.0, 1.0)}
    parts = []
    for number, trial in enumerate(trials):
        parts += [np.full(seen.values.size, left[seen.quantity][number]) for seen in trial.channels]
        parts.append(np.full(trial.prior.size, 50.0))  # rows of priors are no channel's
    response = np.concatenate(parts)
    linear = Linear(np.zeros((response.size, 1)), response, tuple(part.size for part in parts), np.zeros(1))
    for before, after in zip(trials, _reweighted(trials, linear), strict=True):
        factors = [b.sigma / a.sigma for a, b in zip(before.channels, after.channels, strict=True)]
        assert factors == pytest.approx([np.sqrt(np.mean(np.square(left[seen.quantity]))) for seen in before.channels])


def test_what_is_left_counts_the_sensors_noise_whatever_the_weights(found):
    weighed = [trial.reweighted([3.0] * len(trial.channels)) for trial in found.trials]
    again = walk(weighed, found.book, EQ15, found.polished.values, Rules())
    assert left_over(again) == pytest.approx(left_over(found), rel=1e-3)


@pytest.mark.parametrize(
    ("larger", "ahead", "expected"),
    [
        ({0, 2, 3, 4}, 5.9, "smaller"),  # two terms in the place of one, at less than 20 to 1
        ({0, 2, 3, 4}, 6.1, "larger"),
        ({0, 1, 3, 4}, 0.1, "larger"),  # one more term beside all of the smaller ones: the criterion alone
        ({0, 2, 3}, 0.1, "larger"),  # another term in the place of one
    ],
)
def test_several_terms_take_the_place_of_one_at_the_odds_of_a_rival(larger, ahead, expected):
    subsets = [({0, 1, 3}, 100.0, "smaller"), (larger, 100.0 - ahead, "larger")]
    assert _simplest(subsets, Rules()) == expected


def test_of_smaller_subsets_the_smallest_is_taken_and_of_two_alike_the_better():
    subsets = [({0, 2, 3, 4}, 100.0, "best"), ({0, 1, 5}, 101.0, "worse"), ({0, 1, 3}, 100.5, "better")]
    assert _simplest(subsets, Rules()) == "better"
    assert _simplest([*subsets, ({0, 1}, 105.9, "smallest")], Rules()) == "smallest"
