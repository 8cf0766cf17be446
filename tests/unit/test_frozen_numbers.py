"""Searches end where they did before they shared one loop: numbers kept from the loops that each had of its own."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.exact_motions import LONG, exact_group
from undertow.comparison.hidden_refine import refine_inner
from undertow.comparison.laws import laws
from undertow.comparison.polish import Polished, polish
from undertow.comparison.trajectories import in_cells
from undertow.conditioning.motion import Motion
from undertow.equation.hydrodynamics import QuadraticDrag
from undertow.equation.structure import CoulombFriction, Stiffness, ViscousDamping
from undertow.likelihood import output_error
from undertow.likelihood.fit import Specimen
from undertow.likelihood.group import group_model, terms_by_name
from undertow.likelihood.noise import residual_memory
from undertow.likelihood.output_error import Solution
from undertow.likelihood.problem import Link, ProblemBuilder, TrialOptions

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
    return output_error.fit(builder.build())


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
    assert found.cost == pytest.approx(315.984828795106, rel=SAME)
    assert found.values == pytest.approx(
        [28.036975346573485, 0.15095204050980454, 0.0435073610898791, 1.0035849550783673], rel=SAME
    )
    assert found.own[1][:2] == pytest.approx([0.10699712647642756, 1.1308001841003128e-07], rel=1e-6)


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
