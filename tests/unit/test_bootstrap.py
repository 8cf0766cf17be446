"""Block bootstrap of regressions: it agrees with theory where that is known, and costs next to nothing."""

from __future__ import annotations

import time

import numpy as np
import pytest

from tests.small_campaign import BODY, recorded
from undertow.conditioning.condition import condition
from undertow.errors import IdentificationError
from undertow.methods.baseline import terms_by_name
from undertow.methods.bootstrap import block_bootstrap, bootstrap_sindy
from undertow.recording.recording import Recording
from undertow.uncertainty.confidence import widening


def regression(rng, rows=2000, memory=0.0):
    columns = rng.standard_normal((rows, 2))
    noise = rng.standard_normal(rows)
    for i in range(1, rows):
        noise[i] += memory * noise[i - 1]
        columns[i] += memory * columns[i - 1]
    return columns, columns @ np.array([1.0, -2.0]) + noise


def test_white_noise_gives_the_textbook_standard_error():
    columns, response = regression(np.random.default_rng(1))
    found = block_bootstrap(columns, response, [2000], 10, whole_trials=False)
    exact = np.sqrt(np.diag(np.linalg.inv(columns.T @ columns)))
    assert found.stderr == pytest.approx(exact, rel=0.2)  # 200 blocks: 5 %, 1000 draws: 2 %
    assert np.all(np.abs(found.values - [1.0, -2.0]) < 4.0 * found.stderr)


def test_blocks_longer_than_the_residual_s_memory_see_its_correlation():
    columns, response = regression(np.random.default_rng(2), memory=0.9)
    short = block_bootstrap(columns, response, [2000], 1, whole_trials=False)
    long = block_bootstrap(columns, response, [2000], 50, whole_trials=False)
    assert np.all(long.stderr > 1.8 * short.stderr)  # both remember 10 rows: sqrt((1 + .81) / (1 - .81)) = 3.1


def test_trials_that_differ_are_drawn_whole_and_widened_for_being_few():
    rng = np.random.default_rng(3)
    levels = rng.normal(5.0, 1.0, 4)
    response = np.repeat(levels, 200) + 0.01 * rng.standard_normal(800)
    found = block_bootstrap(np.ones((800, 1)), response, [200] * 4, 10)
    plain = np.std(levels, ddof=1) / 2.0
    assert found.stderr[0] == pytest.approx(plain * widening(3.0), rel=0.1)  # 1000 draws
    inside = block_bootstrap(np.ones((800, 1)), response, [200] * 4, 10, whole_trials=False)
    assert inside.stderr[0] < 0.01 * found.stderr[0]


def test_an_interval_holds_its_share_of_the_draws():
    columns, response = regression(np.random.default_rng(4))
    found = block_bootstrap(columns, response, [2000], 10, whole_trials=False)
    low, high = found.interval(0.9)
    share = np.mean((found.draws > low) & (found.draws < high), axis=0)
    assert share == pytest.approx([0.9, 0.9], abs=0.01)


def test_a_seed_repeats_and_another_one_does_not():
    columns, response = regression(np.random.default_rng(5), 400)
    draws = [block_bootstrap(columns, response, [400], 10, 100, seed, False).draws for seed in (1, 1, 2)]
    assert np.array_equal(draws[0], draws[1])
    assert not np.array_equal(draws[0], draws[2])


def test_a_thousand_models_cost_less_than_a_second():
    columns, response = regression(np.random.default_rng(6))
    start = time.process_time()
    block_bootstrap(columns, response, [2000], 10, whole_trials=False)
    assert time.process_time() - start < 1.0  # a few ms on a free core


def test_an_equation_s_coefficients_come_with_errors_that_hold_the_truth():
    motions = []
    for seed, x0 in enumerate((0.03, 0.045, 0.06)):
        table = recorded(x0, seed)
        channels = {"displacement": table[:, 1], "acceleration": table[:, 2]}
        motions.append(condition(Recording(f"r{seed}", table[:, 0], channels)))
    terms = terms_by_name(("stiffness", "viscous_damping", "coulomb_friction", "added_mass"))
    found = bootstrap_sindy(motions, terms)
    assert found.names == ("stiffness", "viscous_damping", "coulomb_friction")
    assert found.trials == 3
    truth = np.array([BODY.k_N_per_m, BODY.c_Ns_per_m, BODY.friction_N]) / BODY.inertia_kg
    assert np.all(np.abs(found.values - truth) < 5.0 * found.stderr)
    alone = bootstrap_sindy(motions[2:], terms, periods=0.5)
    assert alone.trials == 0
    assert np.all(alone.stderr > 0.0)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (([100], 10, 100, 0, False), "trials of 100 rows, 120 rows of columns, 120 of response"),
        (([120], 10, 20, 0, False), "20 draws give no interval; draw at least 50"),
        (([120], 50, 100, 0, False), "trial 0 has 120 rows, 2 blocks of 50; it needs 4"),
        (([120], 10, 100, 0, True), "1 trial cannot be drawn whole; draw its blocks"),
    ],
)
def test_what_cannot_be_resampled_is_refused(arguments, said):
    columns, response = regression(np.random.default_rng(7), 120)
    with pytest.raises(IdentificationError, match=said):
        block_bootstrap(columns, response, *arguments)
