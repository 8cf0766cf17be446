"""Free runs and group fits where the equation is wrong: they end with numbers, and never above a simpler equation."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from experiments.recovery.releases import plant, record
from undertow.conditioning.condition import condition
from undertow.conditioning.motion import Motion, Window
from undertow.equation.kernel import N_SLOTS, SLOT
from undertow.errors import IdentificationError
from undertow.likelihood import free_run as freerun
from undertow.likelihood import output_error
from undertow.likelihood.fit import Specimen
from undertow.likelihood.free_run import error_as_measured, free_run, repeatability, sensor_floor
from undertow.likelihood.problem import Channel, Link, TrialOptions, TrialProblem
from undertow.methods.baseline import GroupFit, fit_group, group_model, terms_by_name
from undertow.quantities import Estimate
from undertow.recording.recording import Recording

LINEAR = ("stiffness", "viscous_damping")
EQ15 = (*LINEAR, "coulomb_friction", "quadratic_drag")
NOISE_M = 0.0012


def beat(seed: int) -> Motion:
    """Two damped modes, 0.888 and 1.251 Hz, of random size and phase: a building beside an unseen damper."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 8.0, 0.0315)
    p1, p2 = rng.uniform(-3.0, 3.0, 2)
    a1, a2 = rng.uniform(0.008, 0.016, 2)
    x = 0.12 + NOISE_M * rng.standard_normal(t.size)
    x += a1 * np.exp(-0.21 * t) * np.cos(2.0 * np.pi * 0.888 * t + p1)
    x += a2 * np.exp(-0.39 * t) * np.cos(2.0 * np.pi * 1.251 * t + p2)
    return condition(Recording("beat", t, {"displacement": x}), start_s=0.0)


def fitted(motion: Motion, names: tuple[str, ...]) -> GroupFit:
    model = group_model(terms_by_name(names), [motion], Specimen(), None, dry=False, anchored=False)
    return fit_group(model, [motion], TrialOptions())


def growing_theta(drag: float) -> np.ndarray:
    """Damping that brakes slow motion and feeds fast motion: m 1, k 30, c 1.3, q negative."""
    theta = np.zeros(N_SLOTS)
    theta[SLOT["mass"]], theta[SLOT["k1"]], theta[SLOT["c1"]], theta[SLOT["q"]] = 1.0, 30.0, 1.3, drag
    return theta


@pytest.mark.parametrize("seed", [6, 13, 19])
def test_a_richer_equation_never_fits_worse_than_the_linear_one(seed):
    # without a second start the four-term equation ends at 1.9, 2.3 and 3.4 times the linear one's chi2 on these
    motion = beat(seed)
    assert fitted(motion, EQ15).solution.chi2 <= fitted(motion, LINEAR).solution.chi2 * (1.0 + 1e-9)


def test_a_fit_whose_sensitivities_overflow_ends_with_finite_errors():
    found = fitted(beat(22), EQ15)
    assert np.all(np.isfinite(found.solution.values))
    assert np.all(np.isfinite(found.solution.covariance))


def test_an_equation_that_feeds_fast_motion_is_scored_where_its_motion_has_bounds():
    motion = beat(1)
    theta = growing_theta(-60.0)
    theta[SLOT["x0"]] = 0.05
    with pytest.raises(IdentificationError, match="leaves every bound"):
        output_error.trajectory(theta, np.zeros(0, dtype=np.int64), motion.t)
    run = free_run(motion, growing_theta(-60.0), 1e-3)
    assert math.isfinite(run.nrmse)


def test_repeatability_leaves_out_draws_whose_motion_has_no_bounds():
    motion = beat(1)
    run = free_run(motion, growing_theta(-20.0), 1e-3)
    floor = sensor_floor(motion, run)
    wild = repeatability(run, {"c1": 1.3}, floor, "displacement", seed=0)
    assert floor < wild < math.inf


def test_repeatability_without_scatter_is_the_sensors_floor():
    motion = beat(1)
    run = free_run(motion, growing_theta(0.0), 1e-3)
    floor = sensor_floor(motion, run)
    assert repeatability(run, {"c1": 0.0}, floor, "displacement", seed=0) == floor


@pytest.mark.parametrize("slot", ["c1", "k1"])
def test_repetitions_of_an_accelerometer_alone_scatter_as_those_of_the_displacement(slot):
    share = 0.1 if slot == "c1" else 0.02  # a stiffness moves the frequency, of which the clock takes a part up
    motion, floors, spread = released(), [], {slot: share * linear_theta()[SLOT[slot]]}
    for quantity, values in (("displacement", motion.x), ("acceleration", motion.a)):
        seen = replace(motion, recording=Recording("r", motion.t, {quantity: values}), noise={quantity: 1e-5})
        run = free_run(seen, linear_theta(), 1e-3)
        floors.append(repeatability(run, spread, 0.0, quantity, seed=3))
    # of a linear decay every derivative is the same wave with another phase
    assert floors[1] == pytest.approx(floors[0], rel=0.05)


def test_fewer_samples_and_longer_steps_give_the_same_repeatability(monkeypatch):
    truth = plant("short", 2.36)
    motion = condition(record(truth, 0.024, "N3", np.random.default_rng(4), "r"))
    theta, body = np.zeros(N_SLOTS), truth.body
    theta[[SLOT[slot] for slot in ("mass", "k1", "c1", "fc", "q")]] = (
        body.inertia_kg, body.k_N_per_m, body.c_Ns_per_m, body.friction_N, body.drag_Ns2_per_m2,
    )  # fmt: skip
    run = free_run(motion, theta, 1e-3)
    spread = {"k1": 0.003 * body.k_N_per_m, "c1": 0.06 * body.c_Ns_per_m, "fc": 0.05 * body.friction_N}
    coarse = repeatability(run, spread, 0.0, "displacement", seed=2)
    monkeypatch.setattr(freerun, "SAMPLES_PER_PERIOD", 10**6)
    monkeypatch.setattr(freerun, "DRAWN_STEPS_PER_PERIOD", 200)
    # both are RMS over the same draws; 50 samples a period leave half a per cent of what a period holds
    assert coarse == pytest.approx(repeatability(run, spread, 0.0, "displacement", seed=2), rel=0.01)


def released(late_s: float = 0.0, low_m: float = 0.0) -> Motion:
    """A linear decay from 50 mm, recorded with a clock that is late and a zero that is low."""
    t = np.arange(0.0, 6.0, 0.01)
    rate, ratio = 2.0 * math.pi, 0.02
    damped = rate * math.sqrt(1.0 - ratio**2)
    at = np.maximum(t - late_s, 0.0)
    z = (1.0 - 1j * ratio * rate / damped) * np.exp((-ratio * rate + 1j * damped) * at)
    x = 0.05 * z.real
    v, a = (0.05 * ((-ratio * rate + 1j * damped) ** n * z).real for n in (1, 2))
    std = np.full(t.size, 1e-5)
    return Motion(
        Recording("r", t, {"displacement": x}), Window(0.0, 0.0, 6.0, held=True), t, x, v, a, std, std, std, t >= 0.0,
        Estimate(low_m, 1e-5, 0.0, "m"), 0.05, {"displacement": 1e-5},
    )  # fmt: skip


def linear_theta() -> np.ndarray:
    theta = np.zeros(N_SLOTS)
    theta[SLOT["mass"]], theta[SLOT["k1"]], theta[SLOT["c1"]] = 1.0, 4.0 * math.pi**2, 0.08 * math.pi
    return theta


def test_with_nothing_adjusted_a_right_equation_has_no_error_and_a_late_clock_or_a_low_zero_counts():
    assert error_as_measured(released(), linear_theta()) < 1e-4
    late = released(late_s=0.02)  # 2 pi 0.02: the phase by which two equal swings differ
    assert error_as_measured(late, linear_theta()) == pytest.approx(2.0 * math.pi * 0.02, rel=0.05)
    assert error_as_measured(released(low_m=-0.005), linear_theta()) > 0.1
    assert free_run(late, linear_theta(), 1e-3).nrmse < 0.02


def test_with_nothing_adjusted_a_rate_alone_and_a_motion_without_bounds_have_no_error():
    motion = released()
    rate = replace(motion, recording=Recording("r", motion.t, {"velocity": motion.v}))
    assert math.isnan(error_as_measured(rate, linear_theta()))
    assert math.isnan(error_as_measured(motion, growing_theta(-300.0)))


def test_before_the_release_the_body_is_held_where_it_was_let_go():
    run = free_run(released(late_s=0.035), linear_theta(), 1e-3)
    assert run.simulated[:3] == pytest.approx(run.theta[SLOT["x0"]], rel=1e-12)
    assert run.simulated[6] < run.simulated[0]


def test_a_residual_before_the_release_is_that_of_the_body_where_it_was_let_go():
    theta, t = linear_theta(), 0.01 * np.arange(1, 7)
    theta[SLOT["x0"]] = 0.05
    seen = Channel("displacement", np.full(t.size, 0.05), 1.0)
    trial = TrialProblem("r", t, theta, (Link(SLOT["k1"], 0),), (seen,), shift=1)
    r, _, _ = output_error.residuals(trial, np.array([0.0, -0.035]))
    assert r[:3] == pytest.approx(0.0, abs=1e-15)
    assert np.all(np.diff(r[2:]) < 0.0)


def drawn_values(monkeypatch: pytest.MonkeyPatch, slot: str, spread: float, freedom: float = math.inf) -> np.ndarray:
    """What a slot is in the repetitions of a linear decay."""
    run = free_run(released(), linear_theta(), 1e-3)
    seen, plain = [], output_error.trajectory

    def noting(theta, *rest):
        seen.append(theta[SLOT[slot]])
        return plain(theta, *rest)

    with monkeypatch.context() as patch:
        patch.setattr(output_error, "trajectory", noting)
        repeatability(run, {slot: spread}, 0.0, "displacement", seed=1, freedom=freedom)
    return np.array(seen[2:])


def test_no_repetition_has_damping_that_feeds_the_motion(monkeypatch):
    values = drawn_values(monkeypatch, "c1", 0.5)
    assert values.min() == 0.0
    assert values.max() > 0.5


def test_scatter_of_few_trials_is_drawn_from_students_distribution(monkeypatch):
    many = drawn_values(monkeypatch, "k1", 0.1)
    one = drawn_values(monkeypatch, "k1", 0.1, freedom=1.0)
    assert np.std(many) == pytest.approx(0.1, rel=0.15)
    # quartiles of Cauchy's distribution are 2.0 apart, of the normal one 1.35
    assert np.subtract(*np.quantile(one, (0.75, 0.25))) > 1.25 * np.subtract(*np.quantile(many, (0.75, 0.25)))


def test_scatter_that_nobody_saw_is_drawn_as_it_is_assumed(monkeypatch):
    known, assumed = (drawn_values(monkeypatch, "k1", 0.1, freedom=freedom) for freedom in (math.inf, 0.0))
    assert assumed.tolist() == known.tolist()
