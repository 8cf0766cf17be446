"""What the structure study's recordings can hold of a drag exponent at best, whatever method reads them.

    python -m experiments structure.bound        # a minute; writes bound.csv here

The Cramer-Rao bound of the exponent's standard deviation, and by how much the best subset of the ten terms misses the
true motion, from the sensitivities of the simulated trials at the truth: white noise, each trial's own start, clock,
gain and drift unknown as in the study. Once from the trials in water alone, once beside four dry ones.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from experiments.files import write_rows
from experiments.recovery.releases import NOISE
from experiments.structure.study import STATED_LEVELS, STRUCTURAL, dry_beliefs, motions_of, ten_terms
from experiments.structure.truths import OtherTruth, plant_other
from undertow.comparison.beliefs import Belief
from undertow.comparison.laws import Laws, laws
from undertow.comparison.polish import Linear, linearise, polish
from undertow.comparison.trajectories import in_cells
from undertow.equation import registry
from undertow.methods.exact_subsets import search_subsets

Array = NDArray[np.float64]
FOLDER = Path(__file__).resolve().parent
EXPONENT = 1.5
COLUMNS = ("spring", "water_depth_m", "noise", "dry_trials", "exponent_std", "misfit")


@dataclass(frozen=True)
class Bound:
    """``exponent_std`` of any unbiased estimate; ``misfit`` (chi-squared) that the best subset of the ten leaves of the
    true motion, noise left out."""

    exponent_std: float
    misfit: float


def numbers_of(truth: OtherTruth, book: Laws) -> Array:
    """The library's numbers at the truth, over mass."""
    body = truth.body
    exact = {
        "stiffness": body.k_N_per_m, "viscous_damping": body.c_Ns_per_m, "coulomb_friction": body.friction_N,
        "drag_exponent": body.power_N, "drag_exponent.exponent": EXPONENT * body.inertia_kg,
    }  # fmt: skip
    return np.array([exact.get(name, 0.0) / body.inertia_kg for name in book.names])


def picture(truth: OtherTruth, noise: str, beliefs: tuple[Belief, ...]) -> tuple[Laws, Linear]:
    """The ten terms and the true law as columns around the truth."""
    book = laws((*ten_terms(), registry.find("drag_exponent")), beliefs=beliefs)
    values = numbers_of(truth, book)
    trials = [in_cells(motion) for motion in motions_of(truth, noise, 0)]
    near = polish(trials, book, (*STRUCTURAL, len(book.terms) - 1), values)
    return book, linearise(trials, book, replace(near, values=values))


def bound(truth: OtherTruth, noise: str, dry: bool) -> Bound:
    """The bound of one level and noise."""
    book, linear = picture(truth, noise, dry_beliefs(replace(truth, kind="dry"), noise, 0) if dry else ())
    places = [*STRUCTURAL, len(book.terms) - 1, len(book.terms)]
    columns = linear.columns[:, places]
    std = float(np.sqrt(np.linalg.inv(columns.T @ columns)[-1, -1]))
    ten = linear.columns[:, : len(book.terms) - 1]
    motion = linear.columns[:, places[:-1]] @ linear.at[places[:-1]]
    search = search_subsets(
        ten.T @ ten, ten.T @ motion, range(ten.shape[1]), motion.size, forced=STRUCTURAL if dry else ()
    )
    best = ten[:, list(search.best.columns)]
    left = motion - best @ np.linalg.lstsq(best, motion, rcond=None)[0]
    return Bound(std, float(left @ left))


def rows() -> Iterator[tuple[object, ...]]:
    """Every level and noise, without and with dry trials."""
    for (spring, depth), noise, dry in product(STATED_LEVELS, NOISE, (False, True)):
        found = bound(plant_other(spring, depth, "drag_1.5"), noise, dry)
        yield spring, depth, noise, int(dry), f"{found.exponent_std:.3g}", f"{found.misfit:.3g}"
        print(spring, noise, dry, found, file=sys.stderr, flush=True)


def main() -> None:
    """Write the rows."""
    write_rows(FOLDER / "bound.csv", COLUMNS, rows())
