"""Searches end where they did before they shared one loop: numbers kept from the loops that each had of its own."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.exact_motions import LONG, exact_group, exact_motion
from undertow.comparison import trajectories
from undertow.comparison.laws import laws
from undertow.comparison.polish import Polished, polish
from undertow.comparison.trajectories import in_cells, trial_rows
from undertow.conditioning.motion import Motion
from undertow.equation.hydrodynamics import QuadraticDrag
from undertow.equation.structure import CoulombFriction, CubicStiffness, Stiffness, StribeckFriction, ViscousDamping
from undertow.likelihood import output_error
from undertow.likelihood.fit import Specimen
from undertow.likelihood.group import group_model, terms_by_name
from undertow.likelihood.noise import residual_memory
from undertow.likelihood.output_error import Solution
from undertow.likelihood.problem import Link, ProblemBuilder, TrialOptions
from undertow.likelihood.residuals import residuals
from undertow.methods.variable_projection import refine_inner

STEPS = 40
"""Integration steps a period when the numbers were kept."""

SAME = 1e-8
"""Relative: rounding of another processor grows by the searches' few steps to some 1e-11."""


@cache
def motions() -> tuple[Motion, ...]:
    """Two releases of the default body, 6 s at 100 Hz."""
    exact = exact_group(LONG, (0.03, 0.107), rate_hz=100.0, duration_s=6.0, a_noise=0.02)
    return tuple(replace(m, noise={**m.noise, "displacement": 1e-4}) for m in exact)


@cache
def solution(*terms: str) -> Solution:
    """Output error of an equation anchored by the body's stiffness."""
    specimen = Specimen(stiffness_N_per_m=LONG.k_N_per_m)
    model = group_model(terms_by_name(terms), motions(), specimen, None, dry=False, anchored=True)
    builder = ProblemBuilder()
    links = tuple(
        Link(model.place(c.slot), builder.unknown(c.name, c.start, lower=c.lower, scale=c.scale), c.factor)
        for c in model.coefficients
    )
    for motion in motions():
        builder.trial(motion, model.trial_base(motion.name), links, TrialOptions(), model.laws)
    return output_error.fit(builder.build(), effort=replace(output_error.FULL, steps_a_period=STEPS))


@cache
def polished() -> Polished:
    """Discover's values of four laws, from a start some way off."""
    book = laws((Stiffness(), ViscousDamping(), CoulombFriction(), QuadraticDrag()))
    trials = [in_cells(motion, {"k1": 0.01}) for motion in motions()]
    return polish(trials, book, range(4), np.array([28.5, 0.3, 0.03, 0.8]))


@pytest.mark.parametrize(
    ("terms", "values", "cost", "memory"),
    [
        (
            ("stiffness", "viscous_damping", "coulomb_friction", "quadratic_drag"),
            (3908.8030430340796, 590.0653924029344, 170.07948536631233, 3922.188423366481),
            327.7287278183661,
            11.658253798488044,
        ),
        (
            ("stiffness", "viscous_damping", "cubic_damping", "cubic_stiffness"),
            (3922.915337824332, 2599.061194903233, -2139.389541008299, 180923.22738944305),
            103918.0236559819,
            15.634758347326713,
        ),
    ],
    ids=["compiled as a whole", "general and wrong"],
)
def test_output_error_ends_at_the_same_numbers(terms, values, cost, memory):
    found = solution(*terms)
    assert found.values[:4] == pytest.approx(values, rel=SAME)
    assert found.cost == pytest.approx(cost, rel=SAME)
    assert residual_memory(found) == pytest.approx(memory, rel=SAME)


def test_discover_polishes_to_the_same_numbers():
    found = polished()
    assert found.converged
    # clocks move by differences between samples now, which were between cells: the kinks of reversals lie elsewhere
    assert found.cost == pytest.approx(315.984828795106, abs=0.1)
    assert found.values == pytest.approx(
        [28.036975346573485, 0.15095204050980454, 0.0435073610898791, 1.0035849550783673], rel=3e-5
    )
    assert found.own[1][0] == pytest.approx(0.10699712647642756, rel=SAME * 1e3)


def test_discover_sees_the_same_residuals_and_derivatives(monkeypatch):
    def as_then(trial, at):
        return residuals(replace(trial, steps_a_period=STEPS), at)

    monkeypatch.setattr(trajectories, "residuals", as_then)
    friction = (CoulombFriction(), QuadraticDrag(), CubicStiffness(), StribeckFriction(0.05))
    terms = (Stiffness(), ViscousDamping(), *friction)
    trial = in_cells(exact_motion(LONG, 0.1, rate_hz=200.0, a_noise=0.02), {"k1": 0.01})
    own = trial.start + np.array([0.0, 0.01, 0.002, 0.003, 0.02])
    rows = trial_rows(trial, laws(terms), np.array([28.0, 0.15, 0.043, 1.0, 5.0, 0.02, 0.05]), own, range(7))
    assert trial.names == ("x0", "shift", "clock", "gain", "own k1")
    assert np.linalg.norm(rows.residual) == pytest.approx(5856582.716513265, rel=SAME)
    assert np.linalg.norm(rows.shared, axis=0) == pytest.approx(
        [7906904.8234701315, 50272173.16956393, 289079406.0873349, 12900012.675800936, 26457.93267721933,
         36831866.03015536, 21731223.576499548], rel=SAME
    )  # fmt: skip
    assert np.linalg.norm(rows.own[:, [0, 3, 4]], axis=0) == pytest.approx(
        [348941276.93923783, 1659.012848144346, 217052289.27172917], rel=SAME
    )
    # clocks move by differences between samples now, which were between cells
    assert np.linalg.norm(rows.own[:, 1]) == pytest.approx(205896447.90261534, rel=5e-3)


def test_a_refined_wave_ends_at_the_same_numbers():
    t = np.linspace(0.0, 5.0, 300)

    def wave(inner):
        return np.column_stack([np.exp(-z * w * t) * np.cos(w * t) for w, z in inner])

    seen = 2.0 * wave([[7.0, 0.05]])[:, 0] + 1.0 + 0.1 * np.random.default_rng(0).standard_normal(t.size)
    bounds = (np.array([1.0, 1e-3]), np.array([20.0, 0.9]))
    found = refine_inner(wave, np.ones((t.size, 1)), seen, np.array([[6.0, 0.2]]), bounds)
    # a step below 1e-5 ends this search; it is taken now, where it once was not
    assert found.inner[0] == pytest.approx([7.003449687378081, 0.04985569300052434], rel=1e-5)
    assert found.coefficients == pytest.approx([2.0027962877671], rel=1e-5)
