"""Equations: what they refuse, how they are written, what they hand to the integrator."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

from undertow.equation import registry
from undertow.equation.equation import Equation, equation_15
from undertow.equation.hidden import even_step, linear_response
from undertow.equation.hydrodynamics import QuadraticDrag
from undertow.equation.kernel import SLOT
from undertow.equation.notation import plain_symbol, quantity_latex, term_latex
from undertow.equation.term import Share, SymbolPlace, Term
from undertow.errors import UndertowError
from undertow.quantities import Parameter


def one_term(name: str, coefficient: float, **inner: float) -> Equation:
    return Equation((registry.find("stiffness"), registry.find(name, **inner)), (109600.0, coefficient), mass_kg=3908.4)


def test_unequal_numbers_of_terms_and_coefficients_are_refused():
    with pytest.raises(UndertowError, match="2 terms but 1 coefficients; give one each"):
        Equation((registry.find("stiffness"), registry.find("viscous_damping")), (1.0,))


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_coefficient_that_is_not_finite_is_refused_with_its_unit(value):
    with pytest.raises(UndertowError, match=rf"of viscous_damping is {value}; give a finite value in N s/m"):
        one_term("viscous_damping", value)


def test_added_mass_that_eats_the_mass_is_refused():
    with pytest.raises(UndertowError, match="total mass is -100 kg; it must be positive: check added_mass"):
        equation_15(1000.0, -1100.0, 0.0, 1.0, 0.0, 0.0)


def test_equation_15_is_written_as_the_report_does():
    equation = Equation(
        tuple(registry.find(n) for n in ("stiffness", "viscous_damping", "coulomb_friction", "quadratic_drag")),
        (109600.0, 590.0, 170.0, 3924.0),
        mass_kg=3908.0,
    )
    assert str(equation) == "3908 x'' + 109600 x + 590 v + 170 sign(v) + 3924 v |v| = 0"


@pytest.mark.parametrize(
    ("name", "coefficient", "inner", "written"),
    [
        ("linear_damping", 900.0, {}, "+ 900 v = 0"),
        ("added_mass", 1271.0, {}, "+ 1271 x'' = 0"),
        ("cubic_damping", 2e4, {}, "+ 20000 v^3 = 0"),
        ("drag_exponent", 2e3, {"exponent": 1.5}, "+ 2000 |v|^1.5 sign(v) = 0"),
        ("cubic_stiffness", -4e7, {}, "- 4e+07 x^3 = 0"),
        ("quintic_stiffness", 4e10, {}, "+ 4e+10 x^5 = 0"),
        ("asymmetric_stiffness", 2e6, {}, "+ 2000000 x^2 = 0"),
        ("quadratic_stiffness", -2e6, {}, "- 2000000 x |x| = 0"),
        ("sine_restoring", 5e5, {}, "+ 500000 sin(x) = 0"),
        ("position_damping", 2e4, {}, "+ 20000 x v = 0"),
        ("van_der_pol_damping", 2e6, {}, "+ 2000000 x^2 v = 0"),
        ("stribeck_friction", 60.0, {"velocity_m_per_s": 0.02}, "+ 60 exp(-(v / 0.02)^2) sign(v) = 0"),
        ("asymmetric_friction", 30.0, {}, "+ 30 |sign(v)| = 0"),
        ("variable_normal_force", 5e3, {}, "+ 5000 |x| sign(v) = 0"),
        (
            "hidden_resonator",
            288.0,
            {"natural_frequency_rad_per_s": 9.6, "damping_ratio": 0.02},
            "+ 288 (x'' + s'') = 0; s'' + 2 · 0.02 · 9.6 s' + 9.6^2 s = -x''",
        ),
        ("relaxation", -3e4, {"time_s": 0.3}, "+ z = 0; z' = -30000 v - z / 0.3"),
        (
            "hysteresis",
            4e4,
            {"yield_displacement_m": 0.004},
            "+ r = 0; r' = 40000 v (1 - sign(v) r / (40000 · 0.004))",
        ),
        ("external_forcing", 300.0, {"frequency_rad_per_s": 7.0, "phase_rad": -1.0}, "+ 300 cos(7 t - 1) = 0"),
        ("delayed_echo", -500.0, {"delay_s": 1.7}, "- 500 v(t - 1.7) = 0"),
    ],
)
def test_every_term_is_written_with_its_numbers(name, coefficient, inner, written):
    assert str(one_term(name, coefficient, **inner)) == f"3908.4 x'' + 109600 x {written}"


def test_an_amplitude_dependent_resonator_shows_its_own_damping_and_stiffness():
    text = str(one_term("hidden_resonator", 300.0, quadratic_damping_per_m=3.0, cubic_stiffness_per_m2_s2=-500.0))
    assert text.endswith("+ 10^2 s + 3 s' |s'| - 500 s^3 = -x''")


def test_two_resonators_have_their_own_states():
    equation = Equation((registry.find("hidden_resonator"),) * 2, (300.0, 200.0), mass_kg=2637.4)
    assert str(equation).startswith("2637.4 x'' + 300 (x'' + s1'') + 200 (x'' + s2'') = 0; s1'' + ")


def test_of_two_resonators_states_and_symbols_are_numbered_and_units_are_not():
    one, two = (
        registry.find("hidden_resonator", natural_frequency_rad_per_s=w, damping_ratio=0.1) for w in (9.0, 16.0)
    )
    equation = Equation((registry.find("stiffness"), one, two), (100.0, 3.0, 4.0), mass_kg=10.0)
    written = equation.to_latex(numbers=True, errors={"hidden_resonator#2.natural_frequency_rad_per_s": 0.5})
    assert r"9\,\mathrm{rad/s}\,\dot{s}_1" in written
    assert r"((16.0 \pm 0.5)\,\mathrm{rad/s})^2\,s_2=-\ddot{x}" in written
    assert "s_1" not in written.replace(r"\dot{s}_1", "").replace(r"\ddot{s}_1", "").replace(r"\,s_1=", "")
    symbols = equation.to_latex()
    assert r"m_{s1}(\ddot{x}+\ddot{s}_1) + m_{s2}(\ddot{x}+\ddot{s}_2)" in symbols
    assert r"2\,\zeta_{s2}\,\omega_{s2}\,\dot{s}_2" in symbols


def test_digits_in_the_text_follow_the_errors():
    text = equation_15(2637.4, 1271.43, 590.0, 109600.0, 170.0, 3924.0).text({"added_mass": 12.2, "mass": 31.0})
    assert text.startswith("2640 x'' + 109600 x")
    assert "+ 1271 x''" in text


def test_latex_has_symbols_by_default():
    latex = equation_15(2637.4, 1271.0, 590.0, 109600.0, 170.0, 3924.0).to_latex()
    assert latex == (
        r"m\ddot{x} + k x + c \dot{x} + F_c\,\mathrm{sgn}(\dot{x}) + m_a \ddot{x} + q\,\dot{x}|\dot{x}| = 0"
    )


def test_latex_with_numbers_has_units_and_errors():
    latex = one_term("added_mass", 1271.43).to_latex(numbers=True, errors={"added_mass": 12.2})
    assert r"+ (1271 \pm 12)\,\mathrm{kg}\,\ddot{x} = 0" in latex


@pytest.mark.parametrize("name", registry.names())
def test_latex_of_every_term_is_balanced_and_holds_no_symbol_beside_its_number(name):
    latex = one_term(name, 3.0).to_latex(numbers=True)
    assert latex.count("{") == latex.count("}")
    assert latex.count("(") == latex.count(")")
    term = registry.find(name)
    force, memory = term_latex(term, 3.0)
    bare = (force + memory).replace(r"\mathrm", "")
    for parameter in term.parameters:
        if len(parameter.symbol) > 1:  # single letters also stand in units
            assert parameter.symbol not in bare


def test_the_hidden_state_stands_after_the_equation_of_motion():
    motion, memory = one_term("relaxation", 3e4).to_latex().split(r",\quad ")
    assert motion.endswith("+ z = 0")
    assert memory == r"\dot{z}=k_r\,\dot{x}-z/\tau"


def test_large_numbers_have_powers_of_ten():
    assert quantity_latex(4e10, "N/m^5") == r"4\times10^{10}\,\mathrm{N/m^{5}}"


def test_numbers_without_a_unit_stand_alone():
    assert quantity_latex(0.02, "1") == "0.02"


def test_plain_symbols_have_no_marks():
    assert plain_symbol(Parameter("a", "1", "c_{xx}")) == "c_xx"


def test_theta_adds_up_what_shares_a_slot():
    theta = equation_15(2637.4, 1271.0, 590.0, 109600.0, 170.0, 3924.0).theta(0.1, -0.2)
    got = {name: theta[SLOT[name]] for name in ("mass", "k1", "c1", "fc", "q", "x0", "v0")}
    assert got == pytest.approx(
        {"mass": 3908.4, "k1": 109600.0, "c1": 590.0, "fc": 170.0, "q": 3924.0, "x0": 0.1, "v0": -0.2}
    )


def test_theta_numbers_resonators():
    first = registry.find("hidden_resonator", natural_frequency_rad_per_s=5.0)
    second = registry.find("hidden_resonator", natural_frequency_rad_per_s=9.0)
    theta = Equation((first, second), (1.0, 2.0)).theta()
    assert [theta[SLOT[s]] for s in ("hm1", "hw1", "hm2", "hw2", "hm3")] == [1.0, 5.0, 2.0, 9.0, 0.0]


def test_theta_splits_a_forcing_into_cosine_and_sine():
    theta = one_term("external_forcing", 10.0, frequency_rad_per_s=2.0, phase_rad=0.5).theta()
    t = 0.3
    parts = theta[SLOT["fcos"]] * math.cos(2.0 * t) + theta[SLOT["fsin"]] * math.sin(2.0 * t)
    assert parts == pytest.approx(10.0 * math.cos(2.0 * t + 0.5))


@pytest.mark.parametrize(("count", "compiled"), [(3, True), (4, False)])
def test_the_compiled_integrator_holds_three_resonators(count, compiled):
    equation = Equation((registry.find("hidden_resonator"),) * count, (1.0,) * count)
    assert equation.compiled is compiled


def test_a_users_own_law_is_not_compiled():
    class Own(Term):
        """A law without slots."""

        name = "own"
        parameters = (Parameter("c", "N", "c"),)
        law = latex = "c"
        source = left_out = "test"

        def force(self, x, v, a, t):
            return np.ones_like(x)

    assert not Equation((Own(),), (1.0,)).compiled


def test_a_users_own_expression_with_an_inner_number_is_the_force_that_it_writes():
    @dataclass(frozen=True)
    class Own(Term):
        """A spring that softens, written as an expression."""

        length_m: float = 0.1
        name: ClassVar[str] = "softening_by_length"
        parameters: ClassVar = (Parameter("k_N_per_m", "N/m", "k"), Parameter("length_m", "m", "l", lower=1e-3))
        law = latex = "k x / (1 + (x / l)^2)"
        source = left_out = "test"

        def share(self, p, q, number):
            return Share(smooth=p["k_N_per_m"] * q.x / (1 + (q.x / p["length_m"]) ** 2))

    x, none = np.array([-0.2, 0.0, 0.05]), np.zeros(3)
    for length in (0.1, 0.03):
        assert Own(length).force(x, none, none, none) == pytest.approx(x / (1.0 + (x / length) ** 2))


def test_a_hidden_resonators_numbers_have_the_bounds_within_which_it_swings():
    bounds = {p.name: (p.lower, p.upper) for p in registry.find("hidden_resonator").parameters}
    assert bounds["damping_ratio"] == (0.0, 1.5)  # half above critical: what is slower is a relaxation
    assert bounds["mass_kg"] == (0.0, math.inf)
    assert bounds["natural_frequency_rad_per_s"] == (0.05, math.inf)
    assert bounds["quadratic_damping_per_m"] == (0.0, math.inf)


def test_no_coefficient_has_to_be_above_zero():
    # per unit mass the same law's coefficient is thousands of times smaller
    assert {law.parameters[0].lower for law in registry.catalogue()} == {0.0, -math.inf}


def test_laws_of_the_water_are_those_that_a_dry_group_does_not_have():
    of_water = {law.name for law in registry.catalogue() if law.of_water}
    water = {"added_mass", "added_stiffness", "quadratic_drag", "linear_damping", "cubic_damping", "drag_exponent"}
    assert of_water == water


def test_constants_cannot_be_edited():
    equation = Equation((), (), constants={"area_m2": 0.97})
    with pytest.raises(TypeError, match="does not support item assignment"):
        equation.constants["area_m2"] = 1.0


ALGEBRAIC = [
    registry.find(law.name)
    for law in registry.catalogue() if law.kind == "force" and law.slots and not law.is_inertia
]  # fmt: skip


@pytest.mark.parametrize("term", ALGEBRAIC, ids=lambda term: term.name)
@pytest.mark.parametrize(("x", "v"), [(0.03, -0.2), (-0.02, 0.05)])
def test_a_law_as_symbols_is_the_force_it_is_fitted_by(term, x, v):
    numbers = {term.coefficient.name: 7.0, **term.inner}
    share = term.share(numbers, SymbolPlace(x, v, float(np.sign(v)), 1.5, 0.4, 0.0), "")
    assert share.states == ()
    one = np.ones(1)
    assert float(share.smooth + share.friction * np.sign(v)) == pytest.approx(
        7.0 * float(term.force(x * one, v * one, 1.5 * one, 0.4 * one)[0]), rel=1e-9
    )


def test_first_guesses_of_damping_are_a_fiftieth_of_the_inertia_force():
    mass, rate, speed = 4.0, 10.0, 0.3
    drag = QuadraticDrag().start(mass, rate, speed)
    assert drag * speed**2 == pytest.approx(0.02 * mass * rate * speed)


def test_uneven_steps_are_refused_with_both_numbers():
    assert even_step(np.array([0.0, 0.1, 0.2, 0.3005]), "x") == pytest.approx(0.1)
    with pytest.raises(UndertowError, match=r"x: time steps differ by 0.002 s from their median 0.1 s; a hidden state"):
        even_step(np.array([0.0, 0.1, 0.2, 0.302]), "x")


def test_a_resonator_that_is_pulled_evenly_comes_along_and_one_left_alone_swings_at_its_frequency():
    t = np.arange(0.0, 40.0, 0.01)
    resonator, still = registry.find("hidden_resonator"), np.zeros(t.size)
    pull = resonator.force(still, still, np.ones(t.size), t)
    assert pull[-1] == pytest.approx(1.0, abs=1e-3)
    w, damping = resonator.natural_frequency_rad_per_s, resonator.damping_ratio
    peaks = t[1:-1][(pull[1:-1] > pull[:-2]) & (pull[1:-1] > pull[2:])]
    assert 2.0 * np.pi / np.median(np.diff(peaks[:8])) == pytest.approx(w * math.sqrt(1.0 - damping**2), rel=0.01)


@pytest.mark.parametrize(("z", "w", "step"), [(0.3, 9.0, 0.02), (0.02, 9.0, 0.1), (0.9, 2.0, 0.2)])
def test_a_filter_at_rest_that_is_pulled_from_the_first_sample_on_answers_as_its_closed_form(z, w, step):
    t = step * np.arange(60)
    found = linear_response([2.0 * z * w, w * w], [1.0, 2.0 * z * w, w * w], np.full(t.size, 1.7), step)
    wd = w * math.sqrt(1.0 - z * z)
    left = np.exp(-z * w * t) * (np.cos(wd * t) - z * w / wd * np.sin(wd * t))
    assert found == pytest.approx(1.7 * (1.0 - left), abs=1e-10)
