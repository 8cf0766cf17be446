"""Every term in the registry keeps its contract: law, compiled integrator, sensitivities, units, column."""

from __future__ import annotations

import math

import numpy as np
import pint
import pytest

from tests.contract.registry_cases import CASES, MASS_KG, TIMES_S, X0_M, equation_with
from tests.reference import reference
from undertow.equation import registry
from undertow.equation.equation import Equation
from undertow.equation.kernel import N_SLOTS, SLOT, SLOTS, integrate
from undertow.equation.simulate import fastest_frequency, simulate

ALL = registry.names()
ONE_SIDED = {"hs1": 0.02, "hu1": 0.2, "v0": 0.3}
"""Sizes to perturb initial values by that are zero in these motions, in their units."""


def test_every_term_in_the_registry_has_a_case_here():
    assert set(CASES) == set(ALL)


@pytest.fixture(scope="module")
def exact():
    """Reference motions, computed once a term."""
    known: dict[str, np.ndarray] = {}

    def of(name: str) -> np.ndarray:
        if name not in known:
            known[name] = reference(equation_with(name), X0_M, TIMES_S)
        return known[name]

    return of


@pytest.mark.parametrize("name", ALL)
@pytest.mark.parametrize(("steps_per_period", "tolerance"), [(200, 1e-7), (60, 1e-5)])
def test_compiled_motion_agrees_with_dop853_split_at_events(name, steps_per_period, tolerance, exact):
    # the promise of simulate: 1e-5 of x0 at its default, 1e-7 at 200 steps a period (measured: 6e-9 and 4e-7 at worst)
    motion = simulate(equation_with(name), X0_M, TIMES_S, steps_per_period=steps_per_period)
    assert np.max(np.abs(motion.x - exact(name)[0])) < tolerance * X0_M


@pytest.mark.parametrize("name", ALL)
def test_compiled_velocity_agrees_with_dop853_split_at_events(name, exact):
    # relative to the largest velocity; the reference leaves the release by an Euler step of 1 ns (1e-8 of it)
    motion = simulate(equation_with(name), X0_M, TIMES_S, steps_per_period=200)
    assert np.max(np.abs(motion.v - exact(name)[1])) < 1e-6 * np.max(np.abs(motion.v))


def _active_slots(theta: np.ndarray, name: str) -> list[int]:
    active = {i for i in range(N_SLOTS) if theta[i] != 0.0} | {SLOT["v0"]}
    if name == "hidden_resonator":
        active |= {SLOT["hs1"], SLOT["hu1"]}
    return sorted(active)


def _largest_gap(theta: np.ndarray, slot: int, column: np.ndarray, h: float) -> float:
    """Largest difference of a sensitivity column from the central difference, relative to the column's largest."""
    none = np.zeros(0, dtype=np.int64)
    size = 1e-6 * (abs(theta[slot]) or ONE_SIDED[SLOTS[slot]])
    up, down = theta.copy(), theta.copy()
    up[slot] += size
    down[slot] -= size
    difference = (integrate(up, none, TIMES_S, h)[0] - integrate(down, none, TIMES_S, h)[0])[:, 0] / (2.0 * size)
    return float(np.max(np.abs(difference - column)) / np.max(np.abs(difference)))


@pytest.mark.parametrize("name", ALL)
def test_sensitivity_of_every_active_slot_agrees_with_finite_differences(name):
    # a velocity at the release: from rest the derivative by v0 is one-sided (friction turns with v0's sign)
    theta = equation_with(name, rest_m=0.0005).theta(X0_M, 0.03)
    active = np.array(_active_slots(theta, name))
    h = 2.0 * math.pi / fastest_frequency(theta) / 200
    columns = integrate(theta, active, TIMES_S, h)[0][:, 1:]
    # central differences with a step of 1e-6: rounding of x (1e-16 / 1e-6) weighs up to 1e4 on the smallest columns
    tolerance = 2e-6
    gaps = {SLOTS[slot]: _largest_gap(theta, slot, columns[:, j], h) for j, slot in enumerate(active)}
    assert {slot: gap for slot, gap in gaps.items() if not gap < tolerance} == {}


@pytest.mark.parametrize("exponent", [0.5, 1.0, 3.0])
def test_sensitivity_of_a_power_law_holds_at_other_exponents(exponent):
    base = equation_with("drag_exponent")
    own = registry.find("drag_exponent", exponent=exponent)
    theta = Equation((*base.terms[:-1], own), (*base.coefficients[:-1], 300.0), mass_kg=MASS_KG).theta(X0_M, 0.03)
    slots = np.array([SLOT["mass"], SLOT["cp"], SLOT["p"]])
    h = 2.0 * math.pi / fastest_frequency(theta) / 200
    columns = integrate(theta, slots, TIMES_S, h)[0][:, 1:]
    # below one the slope of the law has a pole at every reversal, which the finest steps resolve to some per cent; at
    # an exponent of 3 the term is small and its columns carry more of the difference's rounding
    tolerance = 3e-2 if exponent < 1.0 else 1e-5
    for j, slot in enumerate(slots):
        assert _largest_gap(theta, slot, columns[:, j], h) < tolerance


@pytest.mark.parametrize("name", [name for name in ALL if registry.find(name).kind == "force"])
def test_a_law_pulls_back_where_its_force_at_rest_has_the_sign_of_the_displacement(name):
    law, at_rest = registry.find(name, **CASES[name][1]), np.zeros(2)
    x = np.array([-0.1, 0.1])
    assert law.pulls_back == (not law.is_inertia and bool(np.all(law.force(x, at_rest, at_rest, at_rest) * x > 0.0)))


def _column(name: str, steps_per_period: int = 200):
    """A simulated motion with the term, and the term's column of that motion: force per unit coefficient."""
    t = np.arange(0.0, 4.0, 0.001)
    equation = equation_with(name)
    motion = simulate(equation, X0_M, t, steps_per_period=steps_per_period)
    return equation, motion, equation.terms[-1].force(motion.x, motion.v, motion.a, t)


@pytest.mark.parametrize("name", ALL)
def test_columns_of_a_simulated_motion_balance_to_zero(name):
    equation, motion, own = _column(name)
    t = motion.t
    total = equation.mass_kg * motion.a + equation.coefficients[-1] * own
    for term, value in zip(equation.terms[:-1], equation.coefficients[:-1], strict=True):
        total = total + value * term.force(motion.x, motion.v, motion.a, t)
    moving = np.abs(motion.v) > 0.05 * np.max(np.abs(motion.v))
    largest = np.max(np.abs(equation.mass_kg * motion.a))
    # columns with memory take the drive as straight between 1 ms samples, also where friction jumps in between
    tolerance = 1e-4 if equation.terms[-1].kind == "state" else 1e-6
    assert np.max(np.abs(total[moving])) < tolerance * largest


def test_hidden_resonator_column_is_the_force_inside_the_simulation():
    equation, motion, column = _column("hidden_resonator")
    term = equation.terms[-1]
    s, u = motion.hidden[:, 0], motion.hidden[:, 1]
    w = term.natural_frequency_rad_per_s
    inside = -(
        2.0 * term.damping_ratio * w * u
        + w**2 * s
        + term.quadratic_damping_per_m * u * np.abs(u)
        + term.cubic_stiffness_per_m2_s2 * s**3
    )
    # straight drive between 1 ms samples, jumps of a at reversals in between
    assert np.max(np.abs(column - inside)) < 5e-4 * np.max(np.abs(inside))


UNITS = pint.UnitRegistry()


def _unit(text: str, exponent: float | None) -> pint.Unit:
    return UNITS.Unit(text.replace("^p", f"^{exponent}").replace(" ", "*") if text != "1" else "dimensionless")


@pytest.mark.parametrize("name", sorted(set(ALL) - {"sine_restoring"}))
def test_coefficient_times_column_is_a_force(name):
    # the column's unit from how it scales when metres and seconds are renamed
    _, inner, _ = CASES[name]
    term = registry.find(name, **inner)
    rng = np.random.default_rng(3)
    n = 400
    t = np.linspace(0.0, 4.0, n)
    x = 0.01 * np.cos(6.0 * t) + 0.001 * rng.standard_normal()
    v, a = -0.06 * np.sin(6.0 * t), -0.36 * np.cos(6.0 * t)
    metre, second = 1000.0, 1000.0  # as millimetres and milliseconds
    in_small_units = {"m": metre, "s": second}
    scaled = {
        p.name: inner[p.name] * _scale(_unit(p.unit, inner.get("exponent")), in_small_units)
        for p in term.parameters[1:]
        if p.name in inner
    }
    si = term.force(x, v, a, t)
    small = registry.find(name, **scaled).force(x * metre, v * metre / second, a * metre / second**2, t * second)
    unit = UNITS.newton / _unit(term.coefficient.unit, inner.get("exponent"))
    at = int(np.argmax(np.abs(si)))
    assert small[at] / si[at] == pytest.approx(_scale_of_dimension(unit, in_small_units), rel=1e-9)


def _scale(unit: pint.Unit, sizes: dict[str, float]) -> float:
    return _scale_of_dimension(unit, sizes)


def _scale_of_dimension(unit: pint.Unit, sizes: dict[str, float]) -> float:
    """By what a number grows when metre and second are made smaller by ``sizes`` (kg and rad are kept)."""
    dimension = (1 * unit).to_base_units().dimensionality
    assert set(dimension) <= {"[length]", "[time]"}, f"{unit} holds more than lengths and times"
    return sizes["m"] ** dimension.get("[length]", 0) * sizes["s"] ** dimension.get("[time]", 0)


def test_mass_cancels_in_the_balance_of_a_per_mass_equation():
    equation = equation_with("hidden_resonator")
    per_mass = Equation(
        equation.terms, tuple(c / MASS_KG for c in equation.coefficients), mass_kg=1.0, rest_m=equation.rest_m
    )
    # the same motion, up to rounding: friction scales with the mass as every force does
    gap = simulate(per_mass, X0_M, TIMES_S).x - simulate(equation, X0_M, TIMES_S).x
    assert np.max(np.abs(gap)) < 1e-10 * X0_M
