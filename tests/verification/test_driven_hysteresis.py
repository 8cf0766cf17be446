"""The family of hystereses: motions against scipy's integrators, sensitivities against differences, a law at a time.

The references have right-hand sides of their own, and split at knots, at reversals and where a slider slips.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.differences import slope, step_of
from undertow.equation.driven import STEPS_PER_PERIOD, driven_motion
from undertow.equation.driven_hysteresis import BoucWen, Iwan, LuGre, Pinched, sliders
from undertow.equation.driven_laws import find_driven, places
from undertow.equation.driven_slots import DRIVEN_SLOT, N_DRIVEN, SLIDERS
from undertow.equation.input import MotionSize, drive_of
from undertow.errors import ConfigError, IdentificationError

STEP, SAMPLES = 0.01, 400
EXTENT = MotionSize(1.0, 0.5)
NOTHING = np.zeros(0, dtype=np.int64)
BODY = {"mass": 4.0, "gain": 1.0, "k1": 60.0, "c1": 2.0, "x0": 0.05, "v0": 0.2}
CASES = {
    "bouc_wen 1": ("bouc_wen", {"alpha_N_per_m": 150.0, "loop": 4.0, "skew": 1.0, "exponent": 1.0}),
    "bouc_wen 1.5": (
        "bouc_wen", {"alpha_N_per_m": 150.0, "loop": 4.0, "skew": 1.0, "exponent": 1.5, "unit_N": 20.0}
    ),
    "bouc_wen 2": ("bouc_wen", {"alpha_N_per_m": 150.0, "loop": 4.0, "skew": -1.0, "exponent": 2.0, "unit_N": 20.0}),
    "bouc_wen 5": ("bouc_wen", {"alpha_N_per_m": 150.0, "loop": 6.0, "skew": 0.0, "exponent": 5.0, "unit_N": 20.0}),
    "pinched": ("pinched", {"alpha_N_per_m": 300.0, "loop": 6.0, "skew": 0.5, "pinch": 0.8, "width_N": 8.0}),
    "lugre": (
        "lugre", {"sigma0_N_per_m": 2e3, "coulomb_N": 15.0, "static_N": 8.0, "velocity_m_per_s": 0.1,
                  "sigma1_Ns_per_m": 5.0},
    ),
    "lugre, stiff": (
        "lugre", {"sigma0_N_per_m": 1e5, "coulomb_N": 15.0, "static_N": 8.0, "velocity_m_per_s": 0.05,
                  "sigma1_Ns_per_m": 50.0},
    ),
    "iwan": ("iwan", {"stiffness_N_per_m": 200.0, "slip_N": 30.0, "chi": 0.0}),
    "iwan, chi": ("iwan", {"stiffness_N_per_m": 200.0, "slip_N": 30.0, "chi": -0.4}),
}  # fmt: skip


def theta_of(name, numbers, **body):
    """The integrator's vector of the body with that law."""
    theta, term = np.zeros(N_DRIVEN), find_driven(name)
    values = {**BODY, **term.constants, "bw_unit": 1.0, **body}
    values |= {term.slots[parameter]: value for parameter, value in numbers.items()}
    for slot, value in values.items():
        theta[DRIVEN_SLOT[slot]] = value
    return theta


def random_input(size=15.0, seed=0):
    """Times and a smooth random force."""
    rng = np.random.default_rng(seed)
    t = np.arange(SAMPLES) * STEP
    return t, np.convolve(rng.normal(size=SAMPLES + 30), np.hanning(30), "same")[:SAMPLES] * size


def law_of(name, p):
    """Force and rates of a law's own states at v with direction d (and, of a slider, whether it slips)."""
    if name == "lugre":

        def stribeck(v):
            return p["coulomb_N"] + p["static_N"] * np.exp(-((v / p["velocity_m_per_s"]) ** 2))

        def deflects(v, z, d):
            return v - p["sigma0_N_per_m"] * d * v * z / stribeck(v)  # of the deflection in m, as in the literature

        return (
            lambda v, s, d, on: p["sigma0_N_per_m"] * s[0] + p["sigma1_Ns_per_m"] * deflects(v, s[0], d),
            lambda v, s, d, on: [deflects(v, s[0], d)],
        )
    if name == "iwan":
        stiffness = p["stiffness_N_per_m"] * sliders(p["chi"])[0]
        return (lambda v, s, d, on: np.sum(s)), (lambda v, s, d, on: list(stiffness * v * (~on)))

    def slack(z):
        return 1.0 - p["pinch"] * np.exp(-((z / p["width_N"]) ** 2)) if name == "pinched" else 1.0

    def rate(v, s, d, on):
        z = s[0]
        bent = (abs(z) / p.get("unit_N", 1.0)) ** (p.get("exponent", 1.0) - 1.0)
        return [slack(z) * (p["alpha_N_per_m"] * v - (p["loop"] * d * v * z + p["skew"] * v * abs(z)) * bent)]

    return (lambda v, s, d, on: s[0]), rate


def reference(name, numbers, drive, count, own):
    """x at the first ``count`` knots by Radau (stiff bristles) or DOP853, split at knots, reversals and slips."""
    force, rates = law_of(name, numbers)
    limits = numbers.get("slip_N", 1.0) * sliders(numbers.get("chi", 0.0))[1]
    y, out = np.array([BODY["x0"], BODY["v0"], *own]), [BODY["x0"]]
    on = np.zeros(SLIDERS, dtype=bool)
    for i in range(count - 1):
        begin, end = drive.knots[i], drive.knots[i + 1]
        t = begin
        for _ in range(60):
            d = np.sign(y[1]) or 1.0

            def slope(s, state, d=d, on=on, i=i, begin=begin, end=end):
                u = np.polyval(drive.pieces[i][::-1], (s - begin) / (end - begin))
                x, v, z = state[0], state[1], state[2:]
                a = (u - BODY["k1"] * x - BODY["c1"] * v - force(v, z, d, on)) / BODY["mass"]
                return [v, a, *rates(v, z, d, on)]

            got = solve_ivp(
                slope, (t, end), y, "Radau" if name == "lugre" else "DOP853", rtol=1e-10, atol=1e-13,
                max_step=0.2 * STEP if name == "iwan" else np.inf,  # a slip just before a reversal is not stepped over
                events=stops(name, d, t, limits, on),
            )  # fmt: skip
            t, y = got.t[-1], got.y[:, -1].copy()
            if got.status == 0:
                break
            which = next(j for j, times in enumerate(got.t_events) if times.size)
            if which == 0:
                y[1], on = 0.0, np.zeros(SLIDERS, dtype=bool)
                y[1] = np.sign(slope(t, y)[1]) * 1e-15
            else:
                on = on.copy()
                on[which - 1], y[1 + which] = True, d * limits[which - 1]
        out.append(y[0])
    return np.array(out)


def stops(name, d, begin, limits, on):
    """Events that end a piece: reversal, and slips; not the one that it starts from."""

    def reversal(s, y, *_):
        return d if s <= begin + 1e-12 else y[1]

    found = [reversal]
    if name == "iwan":
        found += [
            lambda s, y, i=i: 1.0 if on[i] else limits[i] - d * y[2 + i] for i in range(SLIDERS)
        ]
    for one in found:
        one.terminal = True
    return found


@pytest.mark.parametrize("hold", ["zero", "band_limited"])
@pytest.mark.parametrize("case", CASES)
def test_motion_is_that_of_scipys_integrators_to_a_millionth_and_of_short_steps_to_a_tenth_of_it(case, hold):
    name, numbers = CASES[case]
    t, u = random_input()
    drive = drive_of(t, u, hold)
    x = reference(name, numbers, drive, 100, [0.0] * (SLIDERS if name == "iwan" else 1))
    usual, fine = (
        driven_motion(theta_of(name, numbers), NOTHING, drive, drive.knots[:100], EXTENT, steps).x[:, 0]
        for steps in (STEPS_PER_PERIOD, 160)
    )
    assert np.max(np.abs(usual - x)) < 1e-6 * np.max(np.abs(x))
    assert np.max(np.abs(fine - x)) < 1e-7 * np.max(np.abs(x))


@pytest.mark.parametrize("beside", ["alone", "beside friction"])
@pytest.mark.parametrize("case", CASES)
def test_sensitivities_are_those_of_differences(case, beside):
    name, numbers = CASES[case]
    t, u = random_input()
    drive = drive_of(t, u, "first")
    body = {"fc": 3.0, "bw_z0": 2.0, "delay": 0.0137} if beside != "alone" else {"bw_z0": -4.0}
    theta = theta_of(name, numbers, **body)
    own = [find_driven(name).slots[key] for key, value in numbers.items() if (key, value) != ("exponent", 1.0)]
    fine = 300 if "stiff" in case else 1500
    # short steps: where the rule for steps chooses otherwise, a difference sees the error of a step too
    active = np.array([DRIVEN_SLOT[slot] for slot in ("mass", "k1", "x0", "v0", *body, *own)])
    motion = driven_motion(theta, active, drive, t[:120], EXTENT, fine)
    for column, slot in enumerate(active, 1):
        difference = slope(lambda one: driven_motion(one, NOTHING, drive, t[:120], EXTENT, fine).x[:, 0], theta, slot)
        rounding = 2e-14 / step_of(theta, slot)  # of two motions of 0.1 m after hundreds of steps
        assert np.max(np.abs(difference - motion.x[:, column])) < 1e-6 * np.max(np.abs(difference)) + rounding


@pytest.mark.parametrize("case", CASES)
def test_the_force_along_a_motion_is_that_of_the_states(case):
    name, numbers = CASES[case]
    t, u = random_input()
    motion = driven_motion(theta_of(name, numbers), NOTHING, drive_of(t, u, "first"), t, EXTENT)
    inner = {key: value for key, value in numbers.items() if key != find_driven(name).coefficient.name}
    scale = numbers[find_driven(name).coefficient.name]
    for key in ("coulomb_N", "static_N", "sigma1_Ns_per_m", "slip_N"):
        if key in inner:
            inner[key] /= scale  # these rows are per unit of their coefficient
    row = find_driven(name, **inner, **({"alpha": scale} if "alpha_N_per_m" in numbers else {}))
    x, v, a = motion.x[:, 0], motion.v[:, 0], motion.a[:, 0]
    force = scale * row.force(x - x[0], v, a, t)
    wanted = u - BODY["mass"] * a - BODY["c1"] * v - BODY["k1"] * x
    # a column goes in straight steps from sample to sample, and passes over what lies within one
    assert np.sqrt(np.mean((force - wanted) ** 2)) < 0.1 * np.std(wanted)


def test_a_slider_of_many_slips_at_its_force_and_all_carry_the_slip_force():
    x = np.linspace(0.0, 1.0, 2001)
    force = Iwan(slip_N=0.1).force(x, 0 * x, 0 * x, x)
    assert force[-1] == pytest.approx(0.1)
    # Iwan 1966: x - x^2 / (4 F_s) for a uniform distribution; ten sliders are chords of it
    inside = x < 0.2
    assert np.max(np.abs(force - (x - x**2 / 0.4))[inside]) < 0.1 / (4.0 * SLIDERS**2) * 1.01


def test_two_hystereses_in_an_equation_are_refused():
    with pytest.raises(ConfigError, match="'bouc_wen' and 'iwan' are 2 hystereses"):
        places((BoucWen(), Iwan()))


def test_a_law_that_goes_on_where_it_has_no_slope_ends():
    t, u = random_input()
    theta = theta_of("bouc_wen", {"alpha_N_per_m": 150.0, "loop": 4.0, "skew": 0.0, "exponent": 0.5})
    with pytest.raises(IdentificationError, match="leaves every bound after"):
        driven_motion(theta, NOTHING, drive_of(t, u, "first"), t, EXTENT)


def test_bristles_that_no_sample_sees_bend_are_refused_as_dry_friction():
    t, u = random_input()
    theta = theta_of("lugre", {**CASES["lugre"][1], "sigma0_N_per_m": 1e8})
    with pytest.raises(IdentificationError, match=r"sigma0 1e\+08 N/m bends over 1.5e-07 m.*its friction is dry"):
        driven_motion(theta, NOTHING, drive_of(t, u, "first"), t, EXTENT)


def test_pinching_of_nothing_is_bouc_and_wens_loop():
    t = np.linspace(0.0, 1.0, 300)
    x = np.sin(9.0 * t)
    loop = BoucWen(loop=3.0, skew=1.0).force(x, x, x, t)
    assert np.allclose(Pinched(loop=3.0, skew=1.0, pinch=0.0).force(x, x, x, t), loop, rtol=1e-12, atol=0.0)
    assert np.max(np.abs(Pinched(loop=3.0, skew=1.0, pinch=0.5).force(x, x, x, t) - loop)) > 0.05


@pytest.mark.parametrize(
    "row",
    [
        BoucWen(loop=60.0, skew=80.0, alpha=1000.0),
        BoucWen(loop=9.0, skew=-4.0, exponent=2.0, unit_N=5.0, alpha=1000.0),
        Pinched(loop=60.0, skew=10.0, pinch=0.8, width_N=5.0, alpha=1000.0),
    ],
)
def test_a_memory_stays_the_same_where_samples_are_far_apart(row):
    """A record of a fast motion moves by many times the way over which a loop forgets, from one sample to the next."""
    corners = np.array([0.0, 0.4, -0.3, 0.25, 0.2, 0.8, -0.6])
    dense = np.interp(np.linspace(0.0, 6.0, 60001), np.arange(7.0), corners)
    wanted = row.force(dense, dense, dense, dense)[::10000]
    assert row.force(corners, corners, corners, corners) == pytest.approx(wanted, rel=0.02)


def test_bristles_that_slip_carry_the_friction_at_their_speed():
    t = np.linspace(0.0, 2.0, 4001)
    force = LuGre(coulomb_N=0.01, static_N=0.005, velocity_m_per_s=0.5).force(0.4 * t, 0 * t + 0.4, 0 * t, t)
    assert force[-1] == pytest.approx(0.01 + 0.005 * np.exp(-0.64), rel=1e-6)
