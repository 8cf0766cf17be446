"""The peers on small data: Method 1 finds Eq. 15 again, errors are alike for all, held-out trials are those of the
rule.
"""

import importlib.util
import math

import numpy as np
import pytest

from experiments.blind_challenge import peer_data, peers
from experiments.blind_challenge.truths.motion import Body, simulate

STEP = 2.0 * math.pi / 60.0


def record(body: Body, x0: float, name: str) -> peer_data.Record:
    """A perfect recording of Eq. 15."""
    motion = simulate(body, (), x0, 600, STEP)
    return peer_data.Record(name, motion.time, motion.x, x0, {})


def group(body: Body, dry: bool) -> peer_data.Group:
    """Four trials, one of them held out."""
    records = [record(body, x0, f"r{x0}") for x0 in (0.7, 0.8, 0.9, 1.0)]
    return peer_data.Group({}, [records[0], *records[2:]], [records[1]], dry)


DRY = group(Body(1.0, 0.02, 1.3, 0.004, 0.0), True)
WET = group(Body(1.3, 0.02, 1.3, 0.004, 0.08), False)


def test_held_out_trials_are_every_third_from_the_second_but_never_an_end() -> None:
    assert peer_data.held_out([1.0, 2.0]) == set()
    assert peer_data.held_out([3.0, 1.0, 2.0]) == {2}
    assert peer_data.held_out([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]) == {1, 4}
    assert peer_data.held_out([1.0, 2.0, 3.0, 4.0, 5.0]) == {1}


def test_the_error_forgives_one_linear_step_of_release_time_and_rest_and_nothing_else() -> None:
    t = np.arange(0.0, 40.0, 0.05)
    x = np.exp(-0.03 * t) * np.cos(t)
    assert peers.aligned_error(x, 0.999 * x + 0.002) < 1e-6
    assert peers.aligned_error(x, np.exp(-0.03 * (t - 0.01)) * np.cos(t - 0.01)) < 1e-3
    assert peers.aligned_error(x, np.exp(-0.06 * t) * np.cos(t)) > 0.1
    assert peers.aligned_error(x, np.full(t.size, np.nan)) == peers.WORST


def test_method_1_finds_eq_15_again_from_dry_means() -> None:
    scale = peers.Scale(WET)
    p = peers.method1(WET, DRY, scale)
    w = scale.frequency
    exact = np.array([1.0 / w**2, 0.02 / 1.3 / w, 0.004 / 1.3 / w**2, 0.08 / 1.3])
    assert np.allclose(p, exact, rtol=0.02)
    assert peers._errors(WET, DRY, scale, "eq15_method1")[0] < 1e-3  # type: ignore[index]


@pytest.mark.parametrize("name", ["pysindy_xv", "pysindy_delay", "static_discrepancy", "gaussian_process"])
def test_a_peer_predicts_a_perfect_trial_of_eq_15(name: str) -> None:
    errors = peers._errors(WET, DRY, peers.Scale(WET), name)
    assert errors is not None
    assert errors[0] < 0.3


def test_sysidentpy_is_said_to_be_missing_where_it_is_not_installed() -> None:
    found = peers.sysidentpy_errors(WET, peers.Scale(WET))
    assert (found is None) == (importlib.util.find_spec("sysidentpy") is None)


def test_a_free_run_that_runs_away_ends_as_no_number() -> None:
    run = peers.free_run(np.arange(0.0, 40.0, 0.05), 1.0, lambda x, v: 5.0 * x)
    assert np.isnan(run[-1])


def test_a_trial_that_does_not_swing_has_no_scale() -> None:
    still = peer_data.Record("r", np.arange(200) * 0.1, np.exp(-0.1 * np.arange(200)), 1.0, {})
    with pytest.raises(ValueError, match="0 zero crossings in its longest trial, a frequency needs 3"):
        peers.Scale(peer_data.Group({}, [still], [], False))
