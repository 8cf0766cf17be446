"""The training parts of three public driven benchmarks, cut for the comparison, and how a free run is scored.

Four fifths are fitted; the last fifth is run free from its first samples, nothing of the output fed back. Data:
../shared/driven, beside the repository, never copied into it.

Belongs here: data and score. Does not belong here: methods (driven_methods.py), rounds and table (driven_table.py).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from undertow.quantities import Hold

Array = NDArray[np.float64]

FOLDER = Path(__file__).resolve().parents[3] / "shared" / "driven"
TRAINING_SHARE = 0.8
START = 50
"""Samples of the unseen part from which undertow takes its start state."""


@dataclass(frozen=True)
class DrivenSet:
    """One benchmark: ``x`` (n,) output and ``u`` (n,) input every ``step`` s, in the record's units.

    ``equation`` and ``hold`` are what undertow is given; ``smoothing`` the samples of the Savitzky-Golay window of
    smoothed differences (7 at least); ``decimate`` by how much discrete-time
    models thin the record; the score begins ``skip`` samples after the start; ``factor`` makes the error's unit.
    """

    name: str
    step: float
    x: Array
    u: Array
    equation: tuple[str, ...]
    hold: Hold
    smoothing: int
    decimate: int
    skip: int
    unit: str
    factor: float

    @property
    def cut(self) -> int:
        """Sample at which the unseen part begins."""
        return int(TRAINING_SHARE * self.x.size)

    @property
    def training(self) -> tuple[Array, Array]:
        """x and u that are fitted."""
        return self.x[: self.cut], self.u[: self.cut]

    @property
    def unseen(self) -> tuple[Array, Array]:
        """x and u of the free run; of x a method looks at the samples before `skip` alone."""
        return self.x[self.cut :], self.u[self.cut :]

    def shortened(self, samples: int) -> DrivenSet:
        """The set's first samples alone."""
        return replace(self, x=self.x[:samples], u=self.u[:samples])


_KINDS = {
    "emps": (
        "position_m", "force_N", 1e-3, ("viscous_damping", "coulomb_friction", "constant_force"), "first", 51, 10, 500,
        "mm", 1e3,
    ),
    "silverbox": (
        "output_V", "input_V", 1.0 / 610.3515625,
        ("stiffness", "viscous_damping", "asymmetric_stiffness", "cubic_stiffness", "constant_force"), "band_limited",
        7, 1, 50, "mV", 1e3,
    ),
    "bouc_wen": (
        "displacement_m", "force_N", 1.0 / 750.0, ("stiffness", "viscous_damping"), "band_limited", 7, 1, 50,
        "1e-6 m", 1e6,
    ),
}  # fmt: skip
NAMES = tuple(_KINDS)


def load(name: str, folder: Path = FOLDER) -> DrivenSet:
    """A benchmark's training part from its csv.gz in the folder."""
    x, u, step, *rest = _KINDS[name]
    with np.errstate(all="ignore"):
        rows = np.genfromtxt(folder / f"{name}_train.csv.gz", delimiter=",", names=True)
    return DrivenSet(name, step, np.array(rows[x]), np.array(rows[u]), *rest)  # type: ignore[arg-type]


def score(data: DrivenSet, run: Array, every: int = 1) -> float:
    """RMS of run (m,) minus the recorded output at every so many samples of the unseen part, from `skip` on, in the
    set's unit; inf where the run is not finite or leaves ten times the record's range.

    >>> data = DrivenSet("one", 1.0, np.zeros(10), np.zeros(10), (), "first", 7, 1, 0, "m", 1.0)
    >>> score(data, np.array([3.0, 3.0]))
    inf
    """
    seen = data.unseen[0][::every]
    first = -(-data.skip // every)
    away = (run[: seen.size] - seen[: run.size])[first:]
    if not np.all(np.isfinite(away)) or np.max(np.abs(away)) > 10.0 * np.ptp(data.x):
        return float("inf")
    return float(np.sqrt(np.mean(away**2))) * data.factor
