"""algebra.py is what the rows give, and a row says what it is."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import ClassVar

import numpy as np
import pytest
import sympy as sp

from tests.contract.registry_cases import CASES
from undertow.compiling import mark_of
from undertow.equation import (
    algebra,
    columns,
    driven_forces,
    driven_kernel,
    driven_memory,
    driven_slots,
    generate,
    kernel,
    registry,
)
from undertow.equation.code_text import SIDE, D, V, X, directed, nested, slope, text
from undertow.equation.hidden import HiddenResonator, Relaxation
from undertow.equation.structure import CubicStiffness
from undertow.equation.term import Share, SymbolPlace
from undertow.errors import UndertowError

NAMES = registry.names()


def test_the_committed_text_is_what_the_rows_give():
    for path, new in generate.texts().items():
        assert path.read_text(encoding="utf-8") == new, "run `python -m undertow.equation.generate`"


def test_the_command_says_whether_the_text_is_up_to_date(tmp_path, monkeypatch, capsys):
    assert generate.main(["--check"]) == 0
    monkeypatch.setattr(generate, "TARGET", tmp_path / "algebra.py")
    assert generate.main(["--check"]) == 1
    assert "is not what the rows give" in capsys.readouterr().out
    assert generate.main([]) == 0
    assert generate.main(["--check"]) == 0


def test_a_compiled_integrator_is_kept_with_a_mark_of_the_generated_text(tmp_path):
    # numba's cache sees a function's own file and what it closes over; the slow test of a new row compiles anew
    (mark,) = (cell.cell_contents for cell in kernel.integrate.py_func.__closure__)
    assert mark == mark_of(algebra)
    other = tmp_path / "algebra.py"
    other.write_text(generate.TARGET.read_text() + "\n")
    assert mark_of(SimpleNamespace(__file__=other)) != mark
    (driven,) = (cell.cell_contents for cell in driven_kernel.drive.py_func.__closure__)
    assert driven == mark_of(algebra, kernel, driven_slots, driven_memory, driven_forces)


def test_columns_are_those_of_formulas_written_by_hand():
    rng = np.random.default_rng(5)
    x, v, t = rng.normal(size=(3, 40))
    still, sign = np.zeros(40), np.sign(v)
    by_hand = {
        "stiffness": x, "added_stiffness": x, "viscous_damping": v, "linear_damping": v, "coulomb_friction": sign,
        "quadratic_drag": v * abs(v), "cubic_damping": v**3, "asymmetric_damping": abs(v), "asymmetric_drag": v**2,
        "drag_exponent": sign * abs(v) ** 1.5,
        "cubic_stiffness": x**3, "quintic_stiffness": x**5, "asymmetric_stiffness": x**2,
        "stiffness_drift": x * (1.0 - np.exp(-t / 10.0)), "quadratic_stiffness": x * abs(x),
        "sine_restoring": np.sin(x), "position_damping": x * v,
        "van_der_pol_damping": x**2 * v, "asymmetric_friction": still + 1.0,
        "stribeck_friction": sign * np.exp(-((v / 0.01) ** 2)), "variable_normal_force": abs(x) * sign,
        "external_forcing": np.cos(5.0 * t), "changing_force": np.cos(5.0 * t),
    }  # fmt: skip
    assert set(columns.COLUMNS) == set(by_hand)
    for name, exact in by_hand.items():
        assert registry.find(name).force(x, v, still, t) == pytest.approx(exact, rel=1e-12, abs=1e-300), name


def test_a_force_that_changes_is_that_of_its_formula_and_of_its_places():
    t, still = np.linspace(0.0, 9.0, 50), np.zeros(50)
    inner = {
        "frequency_rad_per_s": 2.0, "phase_rad": 0.3, "change_per_s": -0.1, "change_phase_rad": 1.0,
        "bend_per_s2": 0.02, "bend_phase_rad": -0.5,
    }  # fmt: skip
    law = registry.find("changing_force", **inner)
    by_hand = np.cos(2.0 * t + 0.3) - 0.1 * t * np.cos(2.0 * t + 1.0) + 0.02 * t**2 * np.cos(2.0 * t - 0.5)
    assert law.force(still, still, still, t) == pytest.approx(by_hand, rel=1e-12, abs=1e-14)
    s = law.slot_values(7.0)
    cosine, sine = (s[f"g{part}"] + s[f"g{part}_t"] * t + s[f"g{part}_tt"] * t**2 for part in ("cos", "sin"))
    assert cosine * np.cos(2.0 * t) + sine * np.sin(2.0 * t) == pytest.approx(7.0 * by_hand, rel=1e-12, abs=1e-13)


def test_springs_give_their_force_and_its_slope():
    x = np.linspace(-0.9, 0.9, 7) + 0.05
    for slot, (law, slope_of) in columns.SPRINGS.items():
        assert slope_of(x) == pytest.approx((law(x + 1e-6) - law(x - 1e-6)) / 2e-6, rel=1e-6), slot
    assert set(columns.SPRINGS) == {"k1", "k2", "ka", "k3", "k5"}


def test_largest_slopes_are_those_of_formulas_written_by_hand():
    number = {slot: 1.0 + 0.1 * i for i, slot in enumerate(algebra.SLOTS)}
    at, x, v = number.__getitem__, 0.3, 0.7
    stiff = at("k1") + at("ks") + 2 * x * (at("k2") + at("ka")) + 3 * at("k3") * x**2 + 5 * at("k5") * x**4
    assert columns.stiffest(at, x) == pytest.approx(stiff + at("kb") + at("rk1") + at("rk2"))
    damping = at("c1") + at("cb") + 2 * (at("q") + at("qa")) * v + 3 * at("c3") * v**2 + at("xv") * x + at("xxv") * x**2
    assert columns.most_damped(at, x, v) == pytest.approx(damping)
    assert columns.fading(at) == pytest.approx((1 / at("rt1"), 1 / at("rt2")))
    assert columns.fading(lambda slot: 0.0) == (0.0, 0.0)


@pytest.mark.parametrize("name", NAMES)
def test_a_row_says_how_the_integrator_has_it(name):
    law = registry.find(name)
    if law.is_inertia:
        return
    place = SymbolPlace(*(sp.Symbol(one, real=True) for one in ("x", "v", "d", "a", "t", "echo")))
    share = law.by_slots({slot: sp.Symbol(slot, real=True) for slot in law.slots.values()}, place, "")
    whole = sp.sympify(share.smooth) + share.friction
    of_time = "delay" if whole.has(place.echo) else "input" if whole.has(place.t) else "force"
    assert law.kind == ("state" if share.states else of_time)


@pytest.mark.parametrize("name", [name for name in NAMES if name not in {"added_mass", "delayed_echo"}])
def test_the_integrators_own_numbers_give_the_same_expression(name):
    coefficient, inner, _ = CASES[name]
    law = registry.find(name, **inner)
    place = SymbolPlace(0.3, -0.2, -1.0, 1.5, 0.4, 0.7)
    slots = {slot: 0.0 for slot in law.slots.values()} | law.slot_values(coefficient)
    one = law.by_slots(slots, place, "")
    other = law.share({law.coefficient.name: coefficient, **law.inner}, place, "")
    assert float(sp.sympify(one.friction)) == pytest.approx(float(sp.sympify(other.friction)))
    free = {symbol: 0.37 for symbol in sp.sympify(one.smooth).free_symbols}
    assert float(sp.sympify(one.smooth).subs(free)) == pytest.approx(float(sp.sympify(other.smooth).subs(free)))
    for (_, rate), (_, again) in zip(one.states, other.states, strict=True):
        hidden = {symbol: 0.37 for symbol in sp.sympify(rate).free_symbols}
        assert float(sp.sympify(rate).subs(hidden)) == pytest.approx(float(sp.sympify(again).subs(hidden)))


# ---------------------------------------------------------------- text of expressions
C, P = sp.Symbol("c", real=True), sp.Symbol("p", real=True)
EXPRESSIONS = [
    C * X**3 - V / P, -X - V, X - 1 / (1 + V) ** 2, -X * V / (C * P), sp.sqrt(P) * sp.exp(-((V / P) ** 2)), X**9 * C,
    (X + V) ** 3 * 2 / 3, sp.sin(C * X) * sp.cos(V) + sp.tanh(V / P), sp.log(P) * sp.atan2(V, X), C / (P * sp.sqrt(P)),
    (X - V) * (C - P * (X + V)) / (X * P), P ** (C * X),
]  # fmt: skip


@pytest.mark.parametrize("expression", EXPRESSIONS, ids=str)
def test_text_evaluates_to_its_expression(expression):
    at = {"x": 0.7, "v": -0.4, "c": 1.3, "p": 2.1}
    exact = float(expression.subs({sp.Symbol(name, real=True): value for name, value in at.items()}))
    for written in (text(expression), text(nested(expression))):
        found = {"math": math, **at}
        exec(f"value = {written}", found)
        assert found["value"] == pytest.approx(exact, rel=1e-13)


def test_sizes_become_smooth_in_one_direction():
    assert directed(V * sp.Abs(V)) == V**2 * D
    assert directed(X * sp.Abs(X) * sp.sign(V) ** 2) == X**2 * SIDE
    assert text(directed(C * sp.Abs(V) ** P * sp.sign(V))) == "c * _power_law(v, p)"
    assert text(slope(directed(C * sp.Abs(V) ** P * sp.sign(V)), V)) == "c * _power_slope(v, p, d)"
    assert text(directed(C * sp.Abs(V) ** P)) == "c * d * _power_law(v, p)"


def test_a_law_that_bends_elsewhere_is_refused():
    with pytest.raises(UndertowError, match=r"has Abs\(x - 0.01\), which bends where the integrator knows no event"):
        directed(C * sp.Abs(X - 0.01))


def test_a_function_without_compiled_code_is_refused():
    with pytest.raises(UndertowError, match=r"has gamma\(x\), which compiled code does not hold"):
        text(sp.gamma(X))


# ---------------------------------------------------------------- rows that the integrator does not hold
def _row(of, base=CubicStiffness, **more):
    """A row with another expression."""
    said = {"name": "own", "slots": base.slots, "by_slots": lambda self, s, q, n: of(s, q)}
    return type("Own", (base,), said | more)


def _read(row):
    return generate.read([*registry.catalogue(), row])


def test_a_row_without_an_expression_is_refused():
    with pytest.raises(UndertowError, match="own has slots k3 and no expression; write its `share`"):
        _read(_row(lambda s, q: None))


def test_a_row_that_is_not_linear_in_its_coefficient_is_refused():
    with pytest.raises(UndertowError, match=r"own: its force .* is not linear in its coefficient 'k3'"):
        _read(_row(lambda s, q: Share(smooth=s["k3"] * q.x + q.v)))


def test_two_expressions_at_one_slot_are_refused():
    with pytest.raises(UndertowError, match="own and cubic_stiffness stand at slot 'k3' with other expressions"):
        _read(_row(lambda s, q: Share(smooth=s["k3"] * q.x**4)))


def test_a_memory_whose_force_is_not_its_state_is_refused():
    z = sp.Symbol("z", real=True)
    row = _row(lambda s, q: Share(smooth=2 * z, states=(("z", s["rk"] * q.v),)), Relaxation, present_by="time_s")
    with pytest.raises(UndertowError, match=r"own: a law with one state has this state as its force, .* force is 2\*z"):
        _read(row)


@pytest.mark.parametrize(
    ("friction", "rate"),
    [(lambda s: s["rk"], lambda q: q.v), (lambda s: 0, lambda q: q.a)],
    ids=["friction beside its state", "a rate of the acceleration"],
)
def test_a_memory_with_friction_or_with_a_rate_of_the_acceleration_is_refused(friction, rate):
    z = sp.Symbol("z", real=True)
    row = _row(
        lambda s, q: Share(smooth=z, friction=friction(s), states=(("z", rate(q)),)), Relaxation, present_by="time_s"
    )
    with pytest.raises(UndertowError, match=r"own: a law with one state .* a rate of x, v, t and the state; its force"):
        _read(row)


def _pendulum(pull):
    """A second kind of hidden oscillator."""
    s, u = sp.Symbol("s", real=True), sp.Symbol("u", real=True)
    most = {"held_by_kernel": 1, "present_by": "natural_frequency_rad_per_s"}
    of = lambda p, q: Share(smooth=-p["hm"] * pull(p, s), states=(("s", u), ("u", -q.a - p["hw"] * sp.sin(s))))  # noqa: E731
    return _row(of, HiddenResonator, **most)


def test_a_second_kind_of_hidden_oscillator_is_refused():
    with pytest.raises(UndertowError, match="own is a second kind of hidden oscillator; the integrator holds one kind"):
        _read(_pendulum(lambda p, s: p["hw"] * sp.sin(s)))


def test_a_hidden_oscillator_of_another_form_is_refused():
    with pytest.raises(UndertowError, match=r"own: a hidden oscillator has s' = u, u' = -a - R and pulls with m R"):
        generate.read([_pendulum(lambda p, s: p["hw"] * s)])


def test_rows_without_a_hidden_oscillator_are_refused():
    with pytest.raises(UndertowError, match="none of 1 rows is a hidden oscillator"):
        generate.read([CubicStiffness])


class Jerk(CubicStiffness):
    """A law of an angle and the time, not in the registry."""

    name: ClassVar[str] = "own_pulse"
    slots: ClassVar = {"N_per_m3": "kp"}

    def share(self, p, q, number):
        """A spring that the time stiffens, with a function of its own."""
        return Share(smooth=p["N_per_m3"] * q.x * sp.sin(q.t) * sp.tanh(q.v))


def test_a_new_row_gets_a_place_a_force_its_slopes_and_its_derivative():
    made = generate.generated([*registry.catalogue(), Jerk])
    assert '"kp"' in made
    assert "    if th[_KP] != 0.0:\n" in made
    for line in ("return -x * math.sin(t) * math.tanh(v)", "if slot == _KP:"):
        assert line in made
    names: dict[str, object] = {}
    exec(made.replace("from numba import njit", "njit = lambda *a, **k: lambda function: function"), names)
    th = np.zeros(names["N_SLOTS"])
    th[names["_KP"]] = 2.0
    x, v, t = 0.3, -0.4, 1.1
    force = names["_outside_force"](th, x, v, -1.0, 1.0, t, 0.0)
    assert force == pytest.approx(2.0 * x * np.sin(t) * np.tanh(v))
    slopes = names["_slopes"](th, x, v, -1.0, 1.0, t)
    assert slopes == pytest.approx((2.0 * np.sin(t) * np.tanh(v), 2.0 * x * np.sin(t) / np.cosh(v) ** 2))
