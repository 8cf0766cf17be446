"""Static, memory or clock: each planted alone, with the rig's scatter, and told from the others on left-out trials."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from undertow.conditioning.condition import condition
from undertow.conditioning.motion import Motion
from undertow.discrepancy.residual import even_motion, residual_force
from undertow.discrepancy.ridge import left_out_residuals
from undertow.discrepancy.shares import Shares, residual_shares
from undertow.equation import registry
from undertow.equation.equation import Equation, equation_15
from undertow.equation.simulate import simulate
from undertow.errors import IdentificationError
from undertow.recording.recording import Recording

PLAIN = equation_15(2637.4, 300.0, 590.0, 109_600.0, 170.0, 1000.0)
RELEASES_M = (0.03, 0.05, 0.07, 0.10)
SCATTER = (0.003, 0.06, 0.05)  # k, c and friction from trial to trial, 1 sigma, as dry trials of a rig have
NOISE_M, NOISE_M_PER_S2 = 2.5e-5, 0.012
RATE_HZ, HOLD_S, MOTION_S = 100.0, 0.5, 10.0
WATER = frozenset({"added_mass", "quadratic_drag"})


def with_term(name: str, coefficient: float, **inner: float) -> Equation:
    term = registry.find(name, **inner)
    return replace(PLAIN, terms=(*PLAIN.terms, term), coefficients=(*PLAIN.coefficients, coefficient))


def released(name: str, equation: Equation, x0: float, rng: np.random.Generator) -> Motion:
    """One conditioned trial of an equation whose k, c and friction have this trial's own values."""
    own = [c * (1.0 + s * rng.standard_normal()) for c, s in zip(equation.coefficients[:3], SCATTER, strict=True)]
    own_equation = replace(equation, coefficients=(*own, *equation.coefficients[3:]))
    motion = simulate(own_equation, x0, np.arange(0.0, MOTION_S, 1.0 / RATE_HZ))
    held = round(HOLD_S * RATE_HZ)
    x, a = np.r_[np.full(held, x0), motion.x], np.r_[np.zeros(held), motion.a]
    channels = {
        "displacement": x + NOISE_M * rng.standard_normal(x.size),
        "acceleration": a + NOISE_M_PER_S2 * rng.standard_normal(x.size),
    }
    return condition(Recording(name, np.arange(x.size) / RATE_HZ, channels))


def shares_of(truths: list[Equation], seed: int) -> list[Shares]:
    rng = np.random.default_rng(seed)
    motions = [released(f"r{i}", e, x0, rng) for i, (e, x0) in enumerate(zip(truths, RELEASES_M, strict=True))]
    found = residual_shares(motions, {m.name: PLAIN for m in motions}, WATER)
    return [found[m.name] for m in motions]


def loudest(found: list[Shares]) -> Shares:
    """Median over the two largest releases, whose residual stands clearest above noise."""
    two = found[-2:]
    return Shares(*(float(np.mean([getattr(s, kind) for s in two])) for kind in ("static", "memory", "clock")))


def test_a_cubic_spring_is_static():
    found = loudest(shares_of([with_term("cubic_stiffness", 3e6)] * 4, seed=1))
    assert found.static > 0.85  # what scatter from trial to trial leaves is not the spring's
    assert found.memory + found.clock < 0.1


def test_more_linear_damping_is_static():
    found = loudest(shares_of([with_term("linear_damping", 500.0)] * 4, seed=2))
    assert found.static > 0.6  # scatter of c and k is as large as a third of it
    assert found.memory + found.clock < 0.2


def test_water_that_oscillates_is_memory():
    truth = with_term("hidden_resonator", 200.0, natural_frequency_rad_per_s=9.0, damping_ratio=0.01)
    for one in shares_of([truth] * 4, seed=3):
        assert one.memory > 0.7  # the smallest release stops after few cycles
        assert one.static + one.clock < 0.2


def test_a_seiche_is_a_clock():
    phases = (0.5, 1.5, 5.0, 3.7)
    truths = [with_term("external_forcing", 300.0, frequency_rad_per_s=9.0, phase_rad=p) for p in phases]
    found = shares_of(truths, seed=4)
    assert np.median([s.clock for s in found]) > 0.8
    assert np.median([s.static + s.memory for s in found]) < 0.2


def test_a_force_with_the_same_phase_at_every_release_is_no_clock():
    truth = with_term("external_forcing", 300.0, frequency_rad_per_s=9.0, phase_rad=1.0)
    truths = [replace(truth, coefficients=(*truth.coefficients[:-1], 300.0 * x0 / 0.1)) for x0 in RELEASES_M]
    assert max(s.clock for s in shares_of(truths, seed=5) if math.isfinite(s.clock)) < 0.3


def test_where_nothing_is_missing_no_share_is_claimed():
    for one in shares_of([PLAIN] * 4, seed=6):
        assert math.isnan(one.static) or one.static + one.memory + one.clock < 0.5


def test_equal_amplitudes_and_pairs_of_trials_have_no_shares():
    rng = np.random.default_rng(7)
    motions = [released(f"r{i}", PLAIN, 0.05, rng) for i in range(3)]
    equations = {m.name: PLAIN for m in motions}
    assert all(math.isnan(s.static) for s in residual_shares(motions, equations, WATER).values())
    assert all(math.isnan(s.static) for s in residual_shares(motions[:2], equations, WATER).values())


def test_the_residual_force_is_the_one_that_was_planted():
    rng = np.random.default_rng(8)
    motion = released("r", with_term("linear_damping", 500.0), 0.1, rng)
    left = residual_force(motion, PLAIN)
    fast = np.abs(left.v) > 0.1
    slope = float(np.polyfit(left.v[fast], -left.force[fast], 1)[0])
    assert slope == pytest.approx(500.0, rel=0.25)  # one trial's c lies 6 % of 590, its k 0.3 % of 1.1e5 N/m away


def test_its_band_covers_it_where_the_equation_is_right():
    rng = np.random.default_rng(9)
    exact = replace(PLAIN, coefficients=PLAIN.coefficients)
    truth = simulate(exact, 0.1, np.arange(0.0, MOTION_S, 1.0 / RATE_HZ))
    held = round(HOLD_S * RATE_HZ)
    x, a = np.r_[np.full(held, 0.1), truth.x], np.r_[np.zeros(held), truth.a]
    channels = {
        "displacement": x + NOISE_M * rng.standard_normal(x.size),
        "acceleration": a + NOISE_M_PER_S2 * rng.standard_normal(x.size),
    }
    left = residual_force(condition(Recording("r", np.arange(x.size) / RATE_HZ, channels)), exact)
    share = np.mean(np.abs(left.force - np.median(left.force)) < 2.0 * left.force_std)
    assert share > 0.9  # 95 % were the errors Gaussian and the smoother's model exact


def test_a_window_too_short_for_a_residual_force_is_refused():
    motion = released("r", PLAIN, 0.1, np.random.default_rng(10))
    short = replace(motion, inside=motion.t < 0.1)
    with pytest.raises(IdentificationError, match=r"trial r: \d+ even samples in the motion window; .* needs 20"):
        residual_force(short, PLAIN)


def test_a_force_that_is_not_finite_is_refused():
    motion = released("r", PLAIN, 0.1, np.random.default_rng(11))
    unbounded = with_term("cubic_stiffness", 1e308)
    loud = replace(motion, x=1e3 * motion.x)
    with np.errstate(over="ignore"), pytest.raises(
        IdentificationError, match="trial r: the force of cubic_stiffness is not finite"
    ):
        residual_force(loud, unbounded)


def test_a_law_is_not_learned_from_one_trial():
    y = [np.ones(5), np.ones(5)]
    none = [np.zeros((5, 0))] * 2
    with pytest.raises(IdentificationError, match="1 of 2 trials have a weight above 0"):
        left_out_residuals(y, none, [[np.ones((5, 1))] * 2], [1.0, 0.0])


def test_an_even_motion_starts_at_the_release_about_the_rest_position():
    motion = released("r", PLAIN, 0.1, np.random.default_rng(12))
    even = even_motion(motion)
    assert even.x[0] == pytest.approx(0.1, abs=1e-3)  # the rest lies within friction's width of zero
    assert np.ptp(np.diff(even.t)) < 1e-9
