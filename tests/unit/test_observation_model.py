"""What a channel sees of a motion: means over cells, single samples, the release, and the way a clock moves them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from undertow.equation.kernel import N_SLOTS, SLOT, integrate
from undertow.likelihood.observation_model import signal, swell
from undertow.likelihood.output_error import residuals
from undertow.likelihood.problem import Channel, Link, TrialProblem

BODY = {"mass": 3908.0, "k1": 109530.0, "c1": 590.0, "q": 3924.0, "fc": 180.0, "x0": 0.107}
PERIOD_S = 1.19
CELL_S = 0.024
SAMPLES = 24
NONE = np.zeros(0, dtype=np.int64)
RELEASE_M_PER_S2 = 109530.0 * 0.107 / 3908.0


def theta() -> np.ndarray:
    """The body's parameter vector."""
    out = np.zeros(N_SLOTS)
    out[[SLOT[name] for name in BODY]] = list(BODY.values())
    return out


def motion(times: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x, v, a (n, 1) on a fine step, held before the release."""
    x, v, a = integrate(theta(), NONE, np.maximum(times, 0.0), 1e-3)[:3]
    return x, v, a


def trial(first_s: float, width_s: float = CELL_S, count: int = 250, averaged: bool = True) -> TrialProblem:
    """Cells or single samples from ``first_s`` on, without data."""
    t = first_s + width_s * np.arange(count)
    return TrialProblem("r", t, theta(), (), (), -1, width_s, PERIOD_S, (), averaged)


def seen(of: TrialProblem, quantity: str, late_s: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Signal and rate of change, (n,) each, of a channel whose clock is late."""
    times = of.instants[0] + late_s
    level, rate = signal(of, quantity, motion(times), times, of.base, NONE)
    return level[:, 0], rate


def sampled_means(of: TrialProblem, quantity: str) -> np.ndarray:
    """Means of 2400 samples a cell, what comes before the release held."""
    fine = (np.arange(100 * SAMPLES) + 0.5) / (100 * SAMPLES) - 0.5
    times = (of.t[:, None] + of.width_s * fine).ravel()
    values = dict(zip(("displacement", "velocity", "acceleration"), motion(times), strict=True))[quantity][:, 0]
    if quantity == "acceleration":
        values = np.where(times >= 0.0, values, 0.0)
    return values.reshape(of.t.size, -1).mean(axis=1)


# largest step of a sampled mean: half a sample of the friction's or the release's jump; a displacement's cubic is
# off by 4e-7 of 0.107 m, and by a hundredth of the bend of a reversal inside the cell, 0.09 m/s2 times (24 ms)^2
TOLERANCES = {"displacement": 6e-7, "velocity": 1e-6, "acceleration": 2e-4}


@pytest.mark.parametrize("quantity", list(TOLERANCES))
def test_a_cells_signal_is_the_mean_of_its_samples(quantity):
    cells = trial(0.05)
    assert np.max(np.abs(seen(cells, quantity)[0] - sampled_means(cells, quantity))) < TOLERANCES[quantity]


@pytest.mark.parametrize("quantity", ["velocity", "acceleration"])
def test_what_a_cell_holds_from_before_the_release_is_a_body_at_rest(quantity):
    cells = trial(0.005, count=20)
    assert np.max(np.abs(seen(cells, quantity)[0] - sampled_means(cells, quantity))) < 10.0 * TOLERANCES[quantity]


def test_a_displacement_across_the_release_is_off_by_less_than_a_hundredth_of_its_bend():
    cells = trial(0.005, count=20)
    away = np.abs(seen(cells, "displacement")[0] - sampled_means(cells, "displacement"))
    assert away[0] < 0.01 * RELEASE_M_PER_S2 * CELL_S**2
    assert np.max(away[1:]) < TOLERANCES["displacement"]


def test_no_signal_jumps_when_a_reversal_passes_from_one_cell_into_the_next():
    step = 4e-5
    for averaged, width in ((True, CELL_S), (False, 0.5 * CELL_S)):
        cells = trial(0.05, width, averaged=averaged)
        for quantity, fastest in (("velocity", 3.2), ("acceleration", 25.0)):
            levels = np.array([seen(cells, quantity, late)[0] for late in np.arange(0.0, 0.03, step)])
            # the largest rate of change; an acceleration moves by the friction's jump while a reversal crosses a cell
            jump = 2.0 * 180.0 / 3908.0 / width if quantity == "acceleration" else 0.0
            assert np.max(np.abs(np.diff(levels, axis=0))) < 1.1 * (fastest + jump) * step


@pytest.mark.parametrize("averaged", [True, False])
@pytest.mark.parametrize("quantity", ["displacement", "velocity", "acceleration"])
def test_the_rate_of_change_is_what_a_late_clock_does(quantity, averaged):
    cells = trial(0.05, averaged=averaged)
    step = 1e-5
    slope = (seen(cells, quantity, step)[0] - seen(cells, quantity, -step)[0]) / (2.0 * step)
    rate = seen(cells, quantity)[1]
    # a single sample's rate is its mean over the step, (w D)^2 / 24 = 7e-4 of it and more while drag bends; where a
    # reversal stands on an edge the two differ by the step's share of the friction's jump
    assert np.median(np.abs(slope - rate)) < 3e-3 * np.max(np.abs(rate))
    assert np.quantile(np.abs(slope - rate), 0.95) < 2e-2 * np.max(np.abs(rate))


def test_a_sample_on_its_own_is_the_motion_there():
    samples = trial(0.05, 0.012, averaged=False)
    x, v, a = (part[:, 0] for part in motion(samples.t))
    assert np.max(np.abs(seen(samples, "displacement")[0] - x)) < 6e-7
    assert np.max(np.abs(seen(samples, "velocity")[0] - v)) < 2e-4  # m/s of 0.5; a reversal bends the cubic
    away = np.abs(seen(samples, "acceleration")[0] - a)
    turns = np.convolve(np.diff(np.sign(v), prepend=np.sign(v[0])) != 0.0, np.ones(3), "same") > 0.0
    assert np.max(away[~turns]) < 1e-5  # m/s2 of 3
    assert swell(samples) == pytest.approx(1.0 + (2.0 * np.pi / PERIOD_S * 0.012) ** 2 / 24.0)


def test_a_step_in_which_the_body_turns_has_its_mean_enlarged_as_a_logger_that_smooths_would():
    samples = trial(0.05, 0.012, averaged=False)
    v = motion(samples.instants[0])[1][:, 0]
    turns = v[:-1] * v[1:] <= 0.0
    assert np.count_nonzero(turns) > 3
    mean = np.diff(v) / samples.width_s
    level = seen(samples, "acceleration")[0]
    assert level[turns] == pytest.approx(swell(samples) * mean[turns], rel=1e-9)
    assert np.max(np.abs(level[turns] / mean[turns] - 1.0)) > 1e-4


def test_cells_that_do_not_touch_have_their_own_edges():
    cells = trial(0.05)
    gap = replace(cells, t=np.delete(cells.t, slice(40, 60)))
    assert (cells.instants[1], gap.instants[1]) == (1, 2)
    for quantity in ("displacement", "velocity", "acceleration"):
        for mine, other in zip(seen(gap, quantity), seen(cells, quantity), strict=True):
            assert mine == pytest.approx(np.delete(other, slice(40, 60)), abs=1e-9)


def test_instants_that_stand_alone_are_compared_with_the_motion_itself():
    lone = replace(trial(0.05), width_s=0.0)
    assert lone.instants == (lone.t, 0)
    for quantity, part in zip(("displacement", "velocity", "acceleration"), motion(lone.t), strict=True):
        assert np.array_equal(seen(lone, quantity)[0], part[:, 0])


@pytest.mark.parametrize("averaged", [True, False])
def test_the_jacobian_is_the_residuals_slope(averaged):
    base = theta()
    links = tuple(Link(SLOT[slot], i) for i, slot in enumerate(("mass", "c1", "fc", "k1", "x0")))
    values = np.array([BODY[slot] for slot in ("mass", "c1", "fc", "k1", "x0")])
    for link in links:
        base[link.slot] = 0.0
    cells = trial(0.05, averaged=averaged)
    nothing = np.zeros(cells.t.size)
    sigmas = {"displacement": 1e-3, "acceleration": 0.1, "velocity": 0.01, "spring_force": 10.0}
    channels = tuple(Channel(quantity, nothing, sigma) for quantity, sigma in sigmas.items())
    cells = replace(cells, base=base, links=links, channels=channels)
    got = residuals(cells, values)
    assert got is not None
    for i, value in enumerate(values):
        step = np.zeros(values.size)
        step[i] = 1e-5 * value
        above, below = residuals(cells, values + step), residuals(cells, values - step)
        assert above is not None
        assert below is not None
        slope = (above[0] - below[0]) / (2.0 * step[i])
        # second differences of steps of 1e-5, and the trajectory's own step changes with the stiffness and the mass
        assert np.max(np.abs(slope - got[1][:, i])) < 2e-3 * np.max(np.abs(slope))
