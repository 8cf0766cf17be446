"""A user's own law read as a list of operations: the same force, exact derivatives, the same motion; or not read."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
import pytest

from tests.unit.test_own_law import DeepDrag, own_laws, own_theta
from undertow.equation import general, tracing
from undertow.equation.equation import Equation
from undertow.equation.general import general_trajectory
from undertow.equation.kernel import N_SLOTS, SLOT
from undertow.equation.registry import find
from undertow.equation.simulate import simulate
from undertow.equation.tape import evaluate
from undertow.equation.term import Array, Term
from undertow.equation.tracing import Formula, UnreadableError, formula_of
from undertow.quantities import Parameter

X, V, T = np.linspace(-0.9, 0.8, 7), np.linspace(0.7, -0.6, 7), np.linspace(0.1, 2.0, 7)


@dataclass(frozen=True)
class Written(Term):
    """A law given as a function of x, v and t."""

    how: Any = field(default=None, compare=False)
    power: float = 1.3
    name: ClassVar[str] = "written"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("strength", "N", "q"), Parameter("power", "1", "p"))
    law: ClassVar[str] = "q f"
    latex: ClassVar[str] = "q f"
    source: ClassVar[str] = "made up for this test"
    left_out: ClassVar[str] = "nothing"

    def force(self, x: Array, v: Array, a: Array, t: Array) -> Array:
        return self.how(x, v, t, self.power)


def read(how: Any) -> Formula | None:
    tracing._CHECKS.clear()
    return formula_of([(Written(how), (0, 1))], np.array([2.0, 1.3]), 1.0, 1.0, 2.0)


FORMULAS = {
    "arithmetic": lambda x, v, t, p: -x + 3.0 * v - x * v / (2.0 + t),
    "powers": lambda x, v, t, p: np.abs(v) ** p * np.sign(v) + x**3 + 2.0**x + np.square(v),
    "roots and logarithms": lambda x, v, t, p: np.sqrt(1.0 + x) + np.log(2.0 + v) * np.log1p(v) / np.reciprocal(2 + x),
    "exponentials": lambda x, v, t, p: np.exp(-p * x) + np.expm1(v) + np.tanh(x / 0.3) + np.sinh(v) + np.cosh(x),
    "angles": lambda x, v, t, p: np.sin(p * t) + np.cos(x) + np.tan(v) + np.arctan(x) + np.arcsin(v) + np.arccos(x),
    "two numbers": lambda x, v, t, p: np.hypot(x, v) + np.arctan2(x, 2.0 + v) + np.maximum(x, 0.3) * np.minimum(v, p),
    "sides": lambda x, v, t, p: np.where((x > 0.1) & (v < 0.5), x**2, -p * x) + (x >= 0.2) * x + np.clip(v, -0.2, 0.3),
    "a constant force": lambda x, v, t, p: np.ones_like(x) + np.full_like(x, 2.0) + np.zeros_like(v),
}  # fmt: skip


@pytest.mark.parametrize("name", FORMULAS)
def test_a_formula_is_read_with_its_exact_derivatives(name):
    how = FORMULAS[name]
    found = read(how)
    assert found is not None
    theta = np.array([2.0, 1.3])
    force, slopes = evaluate(found.rows, found.constants, theta, np.array([2, 3]), X, V, T)
    assert force == pytest.approx(2.0 * how(X, V, T, 1.3), rel=1e-13)
    h = 1e-6  # central differences are right to 1e-9 or so
    by = [
        (how(X + h, V, T, 1.3) - how(X - h, V, T, 1.3)) / h, (how(X, V + h, T, 1.3) - how(X, V - h, T, 1.3)) / h,
        how(X, V, T, 1.3), (how(X, V, T, 1.3 + h) - how(X, V, T, 1.3 - h)) / h,
    ]  # fmt: skip
    for column, expected in enumerate(by):
        assert slopes[:, column] == pytest.approx(np.asarray(expected) + 0.0 * X, rel=1e-6, abs=1e-7)


UNREADABLE = {
    "a decision by a value": lambda x, v, t, p: v if x > 0.0 else -v,
    "a table": lambda x, v, t, p: np.interp(x, [-1.0, 1.0], [0.0, 1.0]),
    "a sum over samples": lambda x, v, t, p: np.cumsum(x),
    "an array of its own": lambda x, v, t, p: x * np.arange(7.0),
    "a number": lambda x, v, t, p: math.exp(x),
    "numpy's array": lambda x, v, t, p: np.asarray(x) * 2.0,
    "a method of arrays": lambda x, v, t, p: x.clip(0.0, 1.0),
    "an operation in place": lambda x, v, t, p: np.add(x, v, out=x),
    "no known operation": lambda x, v, t, p: np.heaviside(x, 0.5),
    "no finite number": lambda x, v, t, p: x * np.inf,
    "what the list does not give": lambda x, v, t, p: x if isinstance(x, np.ndarray) else v,
    "no end": lambda x, v, t, p: sum((x * float(i) for i in range(tracing.MOST_OPERATIONS)), v),
}


@pytest.mark.parametrize("name", UNREADABLE)
def test_a_law_that_is_no_formula_is_not_read(name):
    assert read(UNREADABLE[name]) is None


@pytest.mark.parametrize(
    ("how", "words"),
    [
        (bool, "a law decides by a value"), (np.asarray, "a law makes an array of its samples"),
        (np.cumsum, "a law calls cumsum, which"), (np.rint, "a law calls rint, which is no known operation"),
        (lambda x: x + np.arange(3.0), "combines its samples with an array of other numbers"),
        (lambda x: sum((x * float(i) for i in range(tracing.MOST_OPERATIONS)), x), "more than 2000 operations"),
    ],
)  # fmt: skip
def test_why_a_law_is_not_read_is_said(how, words):
    symbol = tracing._Sheet().note("x")
    with pytest.raises(UnreadableError, match=words):
        how(symbol)


def test_the_compiled_motion_of_an_own_law_is_the_one_in_python(monkeypatch):
    times = np.linspace(0.0, 5.5, 120)
    names = ("mass", "k1", "c1", "fc", "x0", "v0", "xe")
    active = np.array([*(SLOT[name] for name in names), N_SLOTS, N_SLOTS + 1], dtype=np.int64)
    ours = general_trajectory(own_theta(), own_laws(), active, times)
    monkeypatch.setattr(general, "formula_of", lambda *_: None)
    python = general_trajectory(own_theta(), own_laws(), active, times)
    for one, other in zip(ours, python, strict=True):
        size = np.max(np.abs(other), axis=0)
        assert np.max(np.abs(one - other)[:, 0]) < 1e-9 * size[0]
        assert np.max(np.abs(one - other) / size) < 1e-5  # the one in Python takes differences of the laws


def test_a_simulated_own_law_is_the_one_in_python_to_rest(monkeypatch):
    equation = Equation(
        (find("stiffness"), find("coulomb_friction"), DeepDrag()), (109_600.0, 400.0, 900.0), mass_kg=2637.4,
        rest_m=0.01,
    )
    times = np.linspace(0.0, 12.0, 200)
    ours = simulate(equation, 0.08, times, v0=-0.1)
    monkeypatch.setattr(general, "formula_of", lambda *_: None)
    python = simulate(equation, 0.08, times, v0=-0.1)
    assert np.max(np.abs(ours.x - python.x)) < 1e-9 * 0.08
    assert ours.v[-1] == 0.0


def test_a_constant_that_a_notebook_changes_is_seen(monkeypatch):
    width = {"m": 0.05}
    law = Written(lambda x, v, t, p: v * (1.0 + (x / width["m"]) ** 2))
    first = formula_of([(law, (0, 1))], np.array([2.0, 1.3]), 1.0, 1.0, 2.0)
    width["m"] = 0.03
    second = formula_of([(law, (0, 1))], np.array([2.0, 1.3]), 1.0, 1.0, 2.0)
    assert first is not None
    assert second is not None
    assert not np.array_equal(first.constants, second.constants)
