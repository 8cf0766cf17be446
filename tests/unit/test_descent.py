"""Levenberg-Marquardt on sums of squares whose minimum is known."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pytest

from undertow.likelihood.descent import Rule, damped_step, descend

RULE = Rule(iterations=50, stop=1e-6)
NOWHERE = (np.full(2, -math.inf), np.full(2, math.inf))


@dataclass(frozen=True)
class Here:
    """Normal equations of residuals at one place."""

    normal: np.ndarray
    gradient: np.ndarray
    cost: float


def looker(residuals, jacobian, seen=None):
    """What `descend` asks: the place of some values, None above a cost or where a residual is not finite."""

    def look(values, above=math.inf):
        if seen is not None:
            seen.append(values.copy())
        r, j = residuals(values), jacobian(values)
        cost = float(r @ r)
        return Here(j.T @ j, j.T @ r, cost) if cost <= above else None

    return look


def valley(values):
    """Rosenbrock's residuals: minimum 0 at (1, 1)."""
    return np.array([10.0 * (values[1] - values[0] ** 2), 1.0 - values[0]])


def valley_slopes(values):
    return np.array([[-20.0 * values[0], 10.0], [-1.0, 0.0]])


MATRIX = np.array([[1.0, 0.2], [0.3, 2.0], [0.5, -1.0]])
TARGET = np.array([1.0, 2.0, 3.0])


def linear(values):
    return MATRIX @ values - TARGET


def slopes(_values):
    return MATRIX


def search(residuals, jacobian, start, bounds=NOWHERE, rule=RULE, seen=None):
    look = looker(residuals, jacobian, seen)
    start = np.array(start, dtype=float)
    return descend(look, start, looker(residuals, jacobian)(start), bounds, rule)


def test_a_linear_problem_is_solved_by_one_step_and_shown_to_be_by_another():
    seen = []
    end = search(linear, slopes, (5.0, -7.0), rule=replace(RULE, damping=0.0), seen=seen)
    assert end.values == pytest.approx(np.linalg.lstsq(MATRIX, TARGET)[0], rel=1e-12)
    assert (end.iterations, end.converged, len(seen)) == (2, True, 2)


def test_a_curved_valley_is_followed_to_its_end():
    end = search(valley, valley_slopes, (-1.2, 1.0))
    assert end.converged
    assert end.values == pytest.approx([1.0, 1.0], abs=1e-6)


def test_a_search_is_no_finer_than_the_errors_as_they_are():
    near = looker(valley, valley_slopes)
    start = np.array([-1.2, 1.0])
    fine = descend(near, start, near(start), NOWHERE, RULE)
    wide = descend(near, start, near(start), NOWHERE, RULE, lambda place: 1e8)  # a stop of 1e-2 standard errors
    assert wide.converged
    assert wide.iterations < fine.iterations
    # valley's own standard errors are 1 and 2.2
    assert np.max(np.abs(wide.values - fine.values)) < 3e-2
    one = descend(near, start, near(start), NOWHERE, RULE, lambda place: 1.0)
    assert one.values == pytest.approx(fine.values, abs=1e-5)


def test_a_step_that_damping_cut_short_does_not_end_a_search_while_it_gains():
    # beside 99 residuals of 0.33 that nothing moves, steps below 0.018 standard errors are short: the first that leads
    # down is 0.012 long, because arctan's full step from 100 overshoots to -15,500, and it gains more than one of 0.36
    def bent(values):
        return np.append(np.full(99, 0.33), math.atan(values[0]))

    def slope(values):
        return np.append(np.zeros(99), 1.0 / (1.0 + values[0] ** 2))[:, None]

    near, start = looker(bent, slope), np.array([100.0])
    bounds = (np.array([-math.inf]), np.array([math.inf]))
    end = descend(near, start, near(start), bounds, Rule(40, 0.05), lambda place: place.cost / 100.0)
    assert end.converged
    assert abs(end.values[0]) < 0.1


def test_a_step_that_leads_up_is_not_taken_and_the_next_one_is_shorter():
    costs, seen = [], []
    look = looker(valley, valley_slopes, seen)

    def noting(values, above):
        found = look(values, above)
        costs.append(math.inf if found is None else found.cost)
        return found

    start = np.array([-1.2, 1.0])
    descend(noting, start, looker(valley, valley_slopes)(start), NOWHERE, RULE)
    refused = [i for i, cost in enumerate(costs[:-1]) if cost == math.inf]
    assert refused  # the full step overshoots Rosenbrock's valley
    taken = [cost for cost in costs if cost < math.inf]
    assert taken == sorted(taken, reverse=True)
    stood = start
    for i, values in enumerate(seen[:-1]):
        if costs[i] < math.inf:
            stood = values
        elif costs[i + 1] == math.inf:
            assert np.linalg.norm(seen[i + 1] - stood) < np.linalg.norm(values - stood)


def test_a_place_that_does_not_exist_is_walked_around():
    def logarithm(values):
        return np.array([math.log(values[0]), values[1]]) if values[0] > 0.0 else np.full(2, math.inf)

    def slope(values):
        return np.diag([1.0 / values[0], 1.0])

    end = search(logarithm, slope, (4.0, 3.0))  # the first Gauss-Newton step leads to 4 - 4 ln 4 < 0
    assert end.values == pytest.approx([1.0, 0.0], abs=1e-6)


def test_an_unknown_on_its_bound_stays_while_the_gradient_points_outwards():
    free = np.linalg.lstsq(MATRIX, TARGET)[0]
    lower = np.array([free[0] + 1.0, -math.inf])
    end = search(linear, slopes, (lower[0] + 2.0, 0.0), (lower, NOWHERE[1]))
    other = np.linalg.lstsq(MATRIX[:, 1:], TARGET - MATRIX[:, 0] * lower[0])[0]
    assert end.values == pytest.approx([lower[0], other[0]], rel=1e-9)
    assert end.converged


def test_an_unknown_leaves_a_bound_where_the_gradient_points_inwards():
    free = np.linalg.lstsq(MATRIX, TARGET)[0]
    for bounds in ((free - 1.0, NOWHERE[1]), (NOWHERE[0], free + 1.0)):
        start = np.clip(free, bounds[0] + 1.0, None) if bounds[1] is NOWHERE[1] else bounds[1]
        assert search(linear, slopes, start, bounds).values == pytest.approx(free, rel=1e-9)


def test_no_unknown_moves_further_at_once_than_it_may():
    seen = []
    search(linear, slopes, (5.0, -7.0), rule=replace(RULE, farthest=0.5), seen=seen)
    moves = np.abs(np.diff(np.array([(5.0, -7.0), *seen]), axis=0))
    assert np.max(moves) <= 0.5
    assert np.max(moves) == pytest.approx(0.5)


def test_the_stop_is_in_standard_errors_or_in_the_unknowns_own_unit():
    scaled = np.array([1e6, 1e6])  # standard errors of about 1e-6
    ends = [
        search(lambda v: linear(scaled * v), lambda v: MATRIX * scaled, (1.0, 1.0),
               rule=replace(RULE, damping=1.0, stop=1e-3, in_own_unit=own, iterations=4))
        for own in (False, True)
    ]  # fmt: skip
    assert [end.converged for end in ends] == [False, True]


def test_a_search_out_of_iterations_says_so():
    end = search(valley, valley_slopes, (-1.2, 1.0), rule=replace(RULE, iterations=2))
    assert (end.iterations, end.converged) == (2, False)


def test_a_singular_matrix_gives_a_finite_step_in_the_direction_it_knows():
    here = Here(np.array([[4.0, 4.0], [4.0, 4.0]]), np.array([4.0, 4.0]), 1.0)
    step = damped_step(here, 0.0, np.ones(2, dtype=bool), np.full(2, 0.5))
    assert step == pytest.approx([-0.5, -0.5], rel=1e-6)


def test_an_unknown_that_moves_nothing_stays_and_leaves_the_others_their_step():
    here = Here(np.diag([4.0, 0.0]), np.array([4.0, 0.0]), 1.0)
    step = damped_step(here, 1.0, np.ones(2, dtype=bool), np.array([0.5, 1e150]))
    assert step == pytest.approx([-0.5, 0.0], rel=1e-14)  # a singular matrix would be damped by 1e-9 more


def test_an_unknown_that_is_held_does_not_move():
    here = Here(np.diag([4.0, 9.0]), np.array([4.0, 9.0]), 1.0)
    step = damped_step(here, 1.0, np.array([True, False]), np.array([0.5, 1.0 / 3.0]))
    assert step.tolist() == [-0.5, 0.0]  # damping 1 halves the step of -1


def test_a_step_that_led_up_is_followed_by_one_at_most_half_so_long():
    def bent(values):
        return np.arctan(values)

    def slope(values):
        return np.diag(1.0 / (1.0 + values**2))

    seen = []
    end = search(bent, slope, (3.0,), bounds=(np.full(1, -math.inf), np.full(1, math.inf)), seen=seen)
    away = [abs(float(values[0]) - 3.0) for values in seen]
    up = [abs(math.atan(float(values[0]))) > math.atan(3.0) for values in seen]
    first_down = up.index(False)
    assert first_down > 0
    assert all(after <= 0.5 * before for before, after in pairwise(away[: first_down + 1]))
    assert first_down < 6  # of a damping that grows from 1e-6 by eights it took nine
    assert end.values == pytest.approx([0.0], abs=1e-6)


@pytest.mark.parametrize(
    ("slope", "next_damping"), [(1.0, 1e-3), (0.6, 1e-2), (0.52, 4e-2)], ids=["foretold", "partly", "hardly"]
)
def test_damping_falls_stays_or_grows_by_how_much_of_what_was_foretold_was_gained(slope, next_damping):
    # residuals are the values themselves; a slope that is too small makes a step 1 / slope times too long, which gains
    # 1, 0.56 and 0.15 of what the normal equations promise
    seen = []
    rule = replace(RULE, damping=1e-2, iterations=2)
    search(lambda values: 1.0 * values, lambda values: slope * np.eye(2), (1.0, 1.0), rule=rule, seen=seen)
    first, second = (float(values[0]) for values in seen)
    assert first == pytest.approx(1.0 - 1.0 / (slope * 1.01), rel=1e-9)
    assert second / first == pytest.approx(1.0 - 1.0 / (slope * (1.0 + next_damping)), rel=1e-6, abs=1e-9)


def test_an_end_that_need_not_be_proved_is_not_looked_at():
    seen, unproved = [], []
    rule = replace(RULE, damping=1e-12, stop=1e-3)
    proved = search(linear, slopes, (5.0, -7.0), rule=rule, seen=seen)
    other = search(linear, slopes, (5.0, -7.0), rule=replace(rule, proved=False), seen=unproved)
    assert (len(seen), len(unproved)) == (2, 1)
    assert (proved.converged, other.converged) == (True, True)
    assert other.values == pytest.approx(proved.values, abs=1e-9)
