"""Equations of many laws at once: derivatives of the generated text, and motions computed before it was generated."""

from __future__ import annotations

import json
import math
import types
from pathlib import Path

import numpy as np
import pytest

from undertow.equation import algebra
from undertow.equation.algebra import N_SLOTS, SLOT, SLOTS
from undertow.equation.kernel import integrate

MOTIONS = json.loads(Path(__file__).with_name("random_motions.json").read_text())
"""Motions by formulas and derivatives written by hand: a row each, with sensitivities by every number that it has.
The last five rows, of laws and a hook that came later, are by scipy's DOP853 with variational equations written by
hand. The sixth, whose bristles yield, is held at a twentieth of its first step: steps beside bristles are others now,
and its values are those of the same formulas with steps of a fortieth (c7eaa725, which gave the first values to
2e-14)."""


@pytest.fixture(scope="module")
def plain():
    """The generated functions as plain Python."""
    text = Path(algebra.__file__).read_text()
    text = text.replace("from numba import njit", "njit = lambda *a, **k: lambda function: function")
    module = types.ModuleType("algebra_as_python")
    exec(text, module.__dict__)
    return module


def _theta(rng: np.random.Generator) -> np.ndarray:
    """Every law at once, each number of the size of one."""
    theta = rng.uniform(0.3, 1.5, N_SLOTS) * np.where(rng.random(N_SLOTS) < 0.5, -1.0, 1.0)
    for name in ("mass", "vs", "p", "fb", "omega", *(f"{n}{i}" for n in ("hm", "hw") for i in (1, 2, 3)), "rt1", "rt2"):
        theta[SLOT[name]] = abs(theta[SLOT[name]])
    theta[SLOT["p"]] += 1.0
    return theta


def _point(rng: np.random.Generator) -> tuple[float, float, float, float, float, float]:
    """x, v, their directions d and side, the time, an echo."""
    x, v = rng.uniform(0.2, 1.0, 2) * rng.choice([-1.0, 1.0], 2)
    return x, v, math.copysign(1.0, v), math.copysign(1.0, x), rng.uniform(0.0, 3.0), rng.normal()


def _total(plain, th, x, v, d, side, t, echo):
    """All forces of laws without a state."""
    f = plain._smooth_force(th, x, v, d, side) + plain._outside_force(th, x, v, d, side, t, echo)
    return f + plain._resisting(th, x, v, d, side) * d


def _difference(of, at: float) -> float:
    """Central difference of the fourth order: its own error is under 1e-10 here."""
    h = 1e-3
    return (8.0 * (of(at + h) - of(at - h)) - of(at + 2.0 * h) + of(at - 2.0 * h)) / (12.0 * h)


@pytest.mark.parametrize("seed", range(8))
def test_slopes_are_the_derivatives_of_the_forces(plain, seed):
    rng = np.random.default_rng(seed)
    th, (x, v, d, side, t, echo) = _theta(rng), _point(rng)
    fx, fv = plain._slopes(th, x, v, d, side, t)
    assert fx == pytest.approx(_difference(lambda z: _total(plain, th, z, v, d, side, t, echo), x), rel=1e-6)
    assert fv == pytest.approx(_difference(lambda z: _total(plain, th, x, z, d, side, t, echo), v), rel=1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_explicit_derivatives_are_those_of_the_forces_by_every_number(plain, seed):
    rng = np.random.default_rng(100 + seed)
    th, (x, v, d, side, t, echo) = _theta(rng), _point(rng)
    y = rng.normal(size=(8, 1))

    def with_oscillators(theta: np.ndarray) -> float:
        pulls = sum(
            theta[SLOT[f"hm{i + 1}"]] * plain._hidden_restoring(theta, i, y[2 + 2 * i, 0], y[3 + 2 * i, 0])
            for i in range(3)
        )
        return pulls - _total(plain, theta, x, v, d, side, t, echo)

    def moved(slot: int):
        def at(value: float) -> float:
            theta = th.copy()
            theta[slot] = value
            return with_oscillators(theta)

        return at

    own = {SLOT[name] for name in ("mass", "xe")}  # by the acceleration and by the slope: not of the forces alone
    for slot in set(range(N_SLOTS)) - own:
        got = plain._explicit_force(th, slot, y, 3, t, d, side, x, v, 0.0, 0.0, echo)
        assert got == pytest.approx(_difference(moved(slot), th[slot]), rel=1e-6, abs=1e-9), SLOTS[slot]
    assert plain._explicit_force(th, SLOT["mass"], y, 3, t, d, side, x, v, 2.5, 0.5, echo) == -2.5
    assert plain._explicit_force(th, SLOT["xe"], y, 3, t, d, side, x, v, 2.5, 0.5, echo) == 0.5


@pytest.mark.parametrize("seed", range(4))
def test_slopes_of_hidden_oscillators_are_their_derivatives(plain, seed):
    rng = np.random.default_rng(200 + seed)
    th, (s, u) = _theta(rng), rng.normal(size=2)
    jac = np.zeros(6)
    for i in range(3):
        plain._hidden_slopes(th, i, s, u, jac)
        by_s = _difference(lambda z, i=i: plain._hidden_restoring(th, i, z, u), s)
        by_u = _difference(lambda z, i=i: plain._hidden_restoring(th, i, s, z), u)
        assert jac[2 * i : 2 * i + 2] == pytest.approx([by_s, by_u], rel=1e-6)


@pytest.mark.parametrize("seed", range(4))
def test_columns_of_memories_are_the_derivatives_of_their_rates(plain, seed):
    rng = np.random.default_rng(300 + seed)
    th, (x, v, d, side, t, _) = _theta(rng), _point(rng)
    dims = plain._dimensions(th)
    first, many = 2 + 2 * dims[1], dims[2]
    y = rng.normal(size=(dims[0], 2))

    def rates(theta: np.ndarray, shift: float) -> np.ndarray:
        moved = y[:, :1] + shift * y[:, 1:]
        k = np.zeros((1, dims[0], 1))
        plain._memory_rates(theta, moved, k, 0, dims, x + shift * y[0, 1], v + shift * y[1, 1], d, side, t)
        return k[0, first : first + many, 0]

    for slot in range(N_SLOTS):
        k = np.zeros((1, dims[0], 2))
        plain._memory_column(th, slot, y, k, 0, 1, dims, x, v, d, side, t, y[0, 1], y[1, 1])

        def along(shift: float, slot: int = slot) -> np.ndarray:
            theta = th.copy()
            theta[slot] += shift
            return rates(theta, shift)

        assert k[0, first : first + many, 1] == pytest.approx(_difference(along, 0.0), rel=1e-6, abs=1e-9), SLOTS[slot]


@pytest.mark.parametrize("row", MOTIONS, ids=lambda row: "-".join(list(row["theta"])[:6]))
def test_motions_and_sensitivities_are_those_of_formulas_written_by_hand(row):
    theta = np.zeros(N_SLOTS)
    for name, value in row["theta"].items():
        theta[SLOT[name]] = value
    names = list(row["theta"])
    times = np.linspace(0.0, row["until"], row["samples"])
    x = integrate(theta, np.array([SLOT[name] for name in names]), times, row["step"])[0]
    # events are found to 1e-10 of a step: the last digit of k1 moves these columns by up to 1e-11 of their largest
    for j, name in enumerate(["x", *names]):
        assert np.max(np.abs(x[row["at"], j] - row["values"][name])) < 1e-10 * row["largest"][name], name


def test_the_motions_have_every_law():
    own = {"hold"}  # the integrator's own room for what a hook holds
    assert {name for row in MOTIONS for name in row["theta"]} == set(SLOTS) - own
