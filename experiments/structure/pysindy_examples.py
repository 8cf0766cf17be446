"""The best-subset optimiser and the term library inside a plain pysindy.SINDy, on pysindy's own examples.

    python -m experiments structure.pysindy_examples --seeds 20

Lorenz and Van der Pol, states recorded with noise, derivatives by finite differences of what pysindy sees: exact
support of every equation, beside pysindy's default optimiser on the same data, and with derivatives that
were measured with as much noise on exact states.
Writes pysindy_examples.csv here.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pysindy
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from experiments.files import write_rows
from undertow.equation.structure import (
    AsymmetricStiffness,
    CubicStiffness,
    PositionDamping,
    Stiffness,
    VanDerPolDamping,
    ViscousDamping,
)
from undertow.methods.library import TermLibrary
from undertow.methods.subset import BestSubset

Array = NDArray[np.float64]
FOLDER = Path(__file__).resolve().parent
STEP_S = 0.002
COLUMNS = ("example", "noise_share", "draws", "best_subset_exact", "stlsq_default_exact", "best_subset_given_rates")
NOISE_SHARES = (0.0, 1e-3, 1e-2)
"""Noise's standard deviation as a share of each state's."""

VAN_DER_POL_TERMS = (
    Stiffness(), ViscousDamping(), VanDerPolDamping(), AsymmetricStiffness(), CubicStiffness(), PositionDamping(),
)  # fmt: skip

IN_MINUTES = "--seeds 2 --out {}"

@dataclass(frozen=True)
class Example:
    """A system: its law, start, length, a library, and which features each equation truly has."""

    name: str
    law: Callable[[float, Array], list[float]]
    start: tuple[float, ...]
    seconds: float
    library: Callable[[], pysindy.feature_library.base.BaseFeatureLibrary]
    truth: tuple[frozenset[str], ...]


def _lorenz(_: float, z: Array) -> list[float]:
    return [10.0 * (z[1] - z[0]), z[0] * (28.0 - z[2]) - z[1], z[0] * z[1] - 8.0 / 3.0 * z[2]]


def _van_der_pol(_: float, z: Array) -> list[float]:
    return [z[1], 0.5 * (1.0 - z[0] ** 2) * z[1] - z[0]]


EXAMPLES = (
    Example(
        "lorenz", _lorenz, (-8.0, 8.0, 27.0), 10.0, lambda: pysindy.PolynomialLibrary(2),
        (frozenset({"x0", "x1"}), frozenset({"x0", "x1", "x0 x2"}), frozenset({"x2", "x0 x1"})),
    ),
    Example(
        "van_der_pol", _van_der_pol, (2.0, 0.0), 20.0, lambda: pysindy.PolynomialLibrary(3),
        (frozenset({"x1"}), frozenset({"x0", "x1", "x0^2 x1"})),
    ),
    Example(
        "van_der_pol, term library", _van_der_pol, (2.0, 0.0), 20.0, lambda: TermLibrary(VAN_DER_POL_TERMS),
        (frozenset({"viscous_damping"}), frozenset({"stiffness", "viscous_damping", "van_der_pol_damping"})),
    ),
)  # fmt: skip


def path_of(example: Example) -> Array:
    """The exact states (n, d)."""
    times = np.arange(0.0, example.seconds, STEP_S)
    solved = solve_ivp(example.law, (0.0, example.seconds), example.start, t_eval=times, rtol=1e-10, atol=1e-10)
    return np.asarray(solved.y.T, dtype=np.float64)


def exact_support(
    example: Example, states: Array, optimizer: pysindy.optimizers.base.BaseOptimizer, rates: Array | None = None
) -> bool:
    """Whether a plain pysindy.SINDy with this optimiser finds every equation's features and no others.

    ``rates`` (n, d) are the derivatives; None lets pysindy take finite differences.
    """
    model = pysindy.SINDy(optimizer=optimizer, feature_library=example.library())
    model.fit(states, t=STEP_S, x_dot=rates)
    names = model.get_feature_names()
    found = tuple(frozenset(names[j] for j in np.flatnonzero(row)) for row in model.optimizer.coef_)
    return found == example.truth


def noisy(states: Array, share: float, seed: int) -> Array:
    """States with white noise of ``share`` of each one's standard deviation."""
    draws = np.random.default_rng(seed).standard_normal(states.shape)
    return states + share * states.std(axis=0) * draws


def main(arguments: list[str] | None = None) -> int:
    """Count exact supports of both optimisers and write them."""
    parser = argparse.ArgumentParser(description="pysindy's examples with the best-subset optimiser.")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--out", type=Path, default=FOLDER)
    options = parser.parse_args(arguments)
    rows = []
    for example in EXAMPLES:
        states = path_of(example)
        for share in NOISE_SHARES:
            draws = [noisy(states, share, seed) for seed in range(options.seeds if share else 1)]
            ours = sum(exact_support(example, draw, BestSubset()) for draw in draws)
            theirs = sum(exact_support(example, draw, pysindy.STLSQ()) for draw in draws)
            # derivatives of the exact states beside noisy ones would be errors in the columns, another matter
            rates = [noisy(np.array([example.law(0.0, z) for z in states]), share, seed) for seed in range(len(draws))]
            given = sum(exact_support(example, states, BestSubset(), rate) for rate in rates)
            rows.append((example.name, share, len(draws), ours, theirs, given))
            print(*rows[-1], file=sys.stderr, flush=True)
    write_rows(options.out / "pysindy_examples.csv", COLUMNS, rows)
    return 0
