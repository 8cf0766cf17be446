"""The Taylor arcs of Eq. 15 and the compiled search on them, held against the general kernel and the general search."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from undertow.equation.kernel import N_SLOTS, SLOT, integrate
from undertow.equation.taylor_series import LAWS, ORDER, TOLERANCE, accelerations, march, sample_at
from undertow.likelihood import eq15 as sheet
from undertow.likelihood import output_error
from undertow.likelihood.problem import Channel, Link, Problem, TrialProblem, Unknown

PLACES = [SLOT[name] for name in LAWS]
TIMES_S = np.arange(0.0, 10.0, 0.02)
DECAY = {"mass": 3908.0, "k1": 109530.0, "c1": 590.0, "q": 3924.0, "fc": 180.0, "xe": 0.001, "x0": 0.107}


def arcs_and_kernel(values: dict[str, float], tolerance: float) -> tuple[np.ndarray, np.ndarray]:
    """x, v, a of the motion and its derivatives by all eight laws, (3, n, 9) each."""
    theta = np.zeros(N_SLOTS)
    for name, value in values.items():
        theta[SLOT[name]] = value
    slots = np.arange(8)
    xs, vs, series = (np.empty((2000, ORDER + 1, 12)) for _ in range(3))
    ends, by, levels = np.empty(2001), np.empty((5, 12)), np.empty((TIMES_S.size, 12))
    steps = march(theta[PLACES], slots, TIMES_S[-1], ORDER, tolerance, xs, vs, ends, by)
    found = []
    accelerations(vs, steps, ORDER, series)
    for of_quantity in (xs, vs, series):
        sample_at(TIMES_S, 0.0, of_quantity, ends, steps, ORDER, levels)
        found.append(levels[:, :9].copy())
    by_slot = np.sort(PLACES)
    order = [0, *(1 + int(np.searchsorted(by_slot, place)) for place in PLACES)]
    exact = integrate(theta, by_slot.astype(np.int64), TIMES_S, 1e-3)[:3]
    return np.array(found), np.array([part[:, order] for part in exact])


@pytest.mark.parametrize(
    "change",
    [{}, {"v0": -0.4}, {"x0": -0.02, "fc": 900.0}, {"q": 0.0}, {"fc": 0.0}, {"x0": 0.0, "v0": 0.3}, {"c1": 0.0}],
    ids=["decay", "pushed", "early stop", "no drag", "no friction", "from rest position", "no viscous damping"],
)
@pytest.mark.parametrize(
    ("tolerance", "motion", "derivatives", "accelerations"),
    [(1e-10, 1e-9, 2e-7, 2e-6), (TOLERANCE, 4e-8, 5e-6, 1e-5)], ids=["exact", "as in fits"],
)  # fmt: skip
def test_arcs_and_their_sensitivities_agree_with_the_kernel(change, tolerance, motion, derivatives, accelerations):
    found, exact = arcs_and_kernel({**DECAY, **change}, tolerance)
    size = np.maximum(np.max(np.abs(exact), axis=1), 1e-12)
    error = np.max(np.abs(found - exact), axis=1) / size
    # series to that share of each step's motion; an acceleration loses two orders of its series, and a derivative by
    # drag holds twice the motion's frequency while the step is chosen by the motion
    assert np.max(error[:2, 0]) < motion
    assert np.max(error[:2]) < derivatives
    assert np.max(error[2]) < accelerations


def test_a_body_held_by_friction_stays_where_it_is_released():
    found, _ = arcs_and_kernel({**DECAY, "fc": 2e4}, TOLERANCE)
    assert np.all(found[0, :, 0] == 0.107)
    assert np.all(found[1:, :, 0] == 0.0)


def test_a_motion_that_damping_feeds_is_given_up():
    p = np.array([DECAY.get(name, 0.0) for name in LAWS])
    p[2], p[3] = -4e4, 0.0
    xs, vs = (np.empty((4000, ORDER + 1, 4)) for _ in range(2))
    assert march(p, np.zeros(0, dtype=np.int64), 60.0, ORDER, TOLERANCE, xs, vs, np.empty(4001), np.empty((5, 4))) == 0


def two_trials(seed: int = 0, width_s: float = 0.0237) -> Problem:
    """Two noisy releases, displacement and acceleration, with every nuisance a trial may have."""
    rng = np.random.default_rng(seed)
    unknowns = [Unknown("added", 800.0), Unknown("drag", 5.0), Unknown("c", 500.0), Unknown("mu", 0.006)]
    trials = []
    for number, x0 in enumerate((0.1, 0.04)):
        first = len(unknowns)
        unknowns += [
            Unknown("x0", x0), Unknown("shift", 0.0, prior_std=0.005), Unknown("rest", 0.0, prior_std=2e-3),
            Unknown("bias", 0.0, prior_std=0.1), Unknown("clock", 0.0, prior_std=0.005),
            Unknown("gain", 0.0, prior_std=0.01), Unknown("drift", 0.0, prior_std=1e-3),
        ]  # fmt: skip
        base = np.zeros(N_SLOTS)
        base[SLOT["mass"]], base[SLOT["k1"]] = 2637.4, 109530.0
        links = (
            Link(SLOT["mass"], 0), Link(SLOT["q"], 1, 485.0), Link(SLOT["c1"], 2), Link(SLOT["fc"], 3, 2.4e4),
            Link(SLOT["x0"], first),
        )  # fmt: skip
        t = np.arange(200) * 0.0237 + 0.01
        truth = np.array([1271.0, 8.09, 590.0, 0.0073])
        theta = base.copy()
        for link in links[:4]:
            theta[link.slot] += link.factor * truth[link.unknown]
        theta[SLOT["x0"]] = x0
        x, _, a = (part[:, 0] for part in integrate(theta, np.zeros(0, dtype=np.int64), t + 0.001, 1e-3)[:3])
        channels = (
            Channel(
                "displacement", x + 2e-4 * rng.standard_normal(t.size), 2e-4, first + 2, (first + 6,), -1, first + 5
            ),
            Channel("acceleration", a + 0.1 * rng.standard_normal(t.size), 0.1, first + 3, (), first + 4, -1),
        )
        trials.append(TrialProblem(f"r{number}", t, base, links, channels, first + 1, width_s, 1.19))
    return Problem(tuple(unknowns), tuple(trials))


def general(problem: Problem, monkeypatch: pytest.MonkeyPatch) -> output_error.Solution:
    """The fit by the search in Python on the general kernel."""
    with monkeypatch.context() as patch:
        patch.setattr(sheet, "is_plain", lambda problem: False)
        return output_error.fit(problem)


def test_the_compiled_search_ends_where_the_general_one_does(monkeypatch):
    problem = two_trials()
    fast, slow = output_error.fit(problem), general(problem, monkeypatch)
    stderr = np.sqrt(np.diag(slow.covariance))
    # both stop within 1e-3 standard errors of the optimum, of motions that differ by 5e-7 of the release
    assert np.max(np.abs(fast.values - slow.values) / stderr) < 1e-2
    assert np.allclose(np.sqrt(np.diag(fast.covariance)), stderr, rtol=1e-3)
    # where a reversal bends a displacement, the mean of a cubic and the exact mean differ by hundredths of the noise
    assert fast.chi2 == pytest.approx(slow.chi2, rel=1e-4)
    assert fast.outcome == slow.outcome == "ok"
    for mine, other in zip(fast.residuals, slow.residuals, strict=True):
        assert np.max(np.abs(mine - other)) < 2e-2  # units of noise; the values differ by 1e-3 standard errors


def test_residuals_and_jacobian_of_the_compiled_search_are_the_general_ones_at_its_values(monkeypatch):
    problem = two_trials(1)
    fast = output_error.fit(problem)
    for trial, r, jac, used in zip(problem.trials, fast.residuals, fast.jacobians, fast.used, strict=True):
        own = output_error.residuals(trial, fast.values)
        assert own is not None
        assert np.array_equal(used, own[2])
        # next to a reversal the kernel's longer step is felt, and a cubic is not the exact mean
        assert np.max(np.abs(r - own[0])) < 3e-3
        assert np.max(np.abs(jac - own[1]) / np.max(np.abs(own[1]), axis=0)) < 3e-3


def test_any_unknown_may_be_the_first_of_a_problem():
    """Here an accelerometer's clock, of a trial whose release is not late."""
    problem = two_trials()
    first = [u.name for u in problem.unknowns].index("clock")
    order = [first, *(i for i in range(len(problem.unknowns)) if i != first)]
    at = {old: new for new, old in enumerate(order)} | {-1: -1}
    usual = Problem(problem.unknowns, tuple(replace(trial, shift=-1) for trial in problem.trials))
    trials = []
    for trial in usual.trials:
        links = tuple(replace(link, unknown=at[link.unknown]) for link in trial.links)
        channels = tuple(
            replace(
                c, drift=tuple(at[j] for j in c.drift),
                **{name: at[getattr(c, name)] for name in ("offset", "shift", "gain")},
            )
            for c in trial.channels
        )
        trials.append(replace(trial, links=links, channels=channels))
    turned = output_error.fit(Problem(tuple(problem.unknowns[i] for i in order), tuple(trials)))
    found = output_error.fit(usual)
    stderr = np.sqrt(np.diag(found.covariance))
    assert np.max(np.abs(turned.values - found.values[order]) / stderr[order]) < 1e-2
    assert np.sqrt(np.diag(turned.covariance)) == pytest.approx(stderr[order], rel=1e-3)


def test_a_bound_is_kept_and_named(monkeypatch):
    problem = two_trials()
    bounded = replace(problem.unknowns[0], lower=1300.0, start=1500.0)
    problem = Problem((bounded, *problem.unknowns[1:]), problem.trials)
    fast, slow = output_error.fit(problem), general(problem, monkeypatch)
    assert fast.values[0] == slow.values[0] == 1300.0
    assert fast.outcome.startswith("on a bound: added = 1300")
    assert fast.cost == pytest.approx(slow.cost, rel=1e-5)


def test_only_equations_of_eq_15_are_searched_compiled():
    problem = two_trials()
    assert sheet.is_plain(problem)
    base = problem.trials[0].base.copy()
    base[SLOT["k3"]] = 1e5
    assert not sheet.is_plain(Problem(problem.unknowns, (replace(problem.trials[0], base=base), problem.trials[1])))


def test_without_a_spring_the_general_search_takes_over(monkeypatch):
    problem = two_trials()
    trials = []
    for trial in problem.trials:
        base = trial.base.copy()
        base[SLOT["k1"]] = 0.0
        trials.append(replace(trial, base=base))
    soft = Problem(problem.unknowns, tuple(trials))
    start = np.array([u.start for u in soft.unknowns])
    assert sheet.search(soft, start, np.array([math.inf]), 5, 1e-3, 1e-6) is None


def one_trial(bend: float) -> Problem:
    """Added mass and drag from one release whose amplitude wanders by ``bend`` of itself."""
    base = np.zeros(N_SLOTS)
    for name, value in DECAY.items():
        base[SLOT[name]] = value
    base[SLOT["mass"]], base[SLOT["q"]] = 2637.4, 0.0
    theta = base.copy()
    theta[SLOT["mass"]], theta[SLOT["q"]] = DECAY["mass"], DECAY["q"]
    t = np.arange(300) * 0.0237 + 0.01
    x = integrate(theta, np.zeros(0, dtype=np.int64), t, 1e-3)[0][:, 0] * (1.0 + bend * np.sin(t))
    channel = Channel("displacement", x + 2e-4 * np.random.default_rng(3).standard_normal(t.size), 2e-4)
    links = (Link(SLOT["mass"], 0), Link(SLOT["q"], 1, 485.0))
    return Problem(
        (Unknown("added", 800.0), Unknown("drag", 5.0)), (TrialProblem("r", t, base, links, (channel,), -1, 0.0, 1.19),)
    )


@pytest.mark.parametrize(("bend", "at_once"), [(0.0, True), (0.3, False)], ids=["fits", "does not fit"])
def test_the_whole_record_follows_a_window_at_once_only_where_the_equation_fits_it(bend, at_once):
    problem = one_trial(bend)
    start, ends = np.array([800.0, 5.0]), []
    for second in (2.4, 1.9):  # s; where it is left out its length changes nothing
        found = sheet.search(problem, start, np.array([1.19, second, math.inf]), 80, 1e-3, 1e-6)
        assert found is not None
        ends.append(found.values)
    assert np.array_equal(*ends) == at_once
    assert np.allclose(*ends, rtol=1e-5)


def test_the_compiled_covariance_is_the_inverse_of_the_normal_equations_and_is_withheld_where_they_are_singular():
    problem = two_trials()
    windows, start = np.array([math.inf]), np.array([u.start for u in problem.unknowns])
    found = sheet.search(problem, start, windows, 80, 1e-3, 1e-6)
    assert found is not None
    assert found.inverse is not None
    scale = np.sqrt(np.diag(found.normal))
    identity = (found.normal @ found.inverse) * (scale[None, :] / scale[:, None])
    assert np.max(np.abs(identity - np.eye(start.size))) < 1e-6  # condition below 1e8
    twice = tuple(replace(trial, links=(*trial.links, Link(SLOT["c1"], start.size))) for trial in problem.trials)
    same_again = Problem((*problem.unknowns, Unknown("c again", 0.0)), twice)
    fast = output_error.fit(same_again)
    assert fast.outcome.startswith(("not identifiable", "did not converge"))


def test_the_last_step_leaves_residuals_and_cost_where_they_are_at_its_end():
    problem = two_trials(2)
    found = output_error.fit(problem)
    again = [output_error.residuals(trial, found.values) for trial in problem.trials]
    chi2 = sum(float(r @ r) for r, _, _ in (part for part in again if part is not None))
    assert found.chi2 == pytest.approx(chi2, rel=1e-4)  # as above: the mean of a cubic
    assert found.chi2 == pytest.approx(sum(float(r @ r) for r in found.residuals), rel=1e-12)
    away = found.values - np.array([u.start for u in problem.unknowns])
    priors = sum((a / u.prior_std) ** 2 for a, u in zip(away, problem.unknowns, strict=True))
    assert found.cost - found.chi2 == pytest.approx(priors, rel=1e-3, abs=1e-3)
