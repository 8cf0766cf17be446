"""A bad input and what the command must answer; and the small campaign that most of them spoil.

Belongs here: the case, the campaign. Does not belong here: the inputs (recordings.py, configs.py, words.py).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Table = NDArray[np.float64]

FAILED, USAGE, SOME_FAILED = 1, 2, 3

RATE_HZ, HOLD_S, MOTION_S = 100.0, 0.5, 5.0
MASS_KG, OMEGA_RAD_PER_S, DECAY_PER_S = 2637.4, 6.447, 0.11

CONFIG = """\
name: bad
recordings:
  index: campaign.csv
  channels:
    time: {column: t, unit: s}
    displacement: {column: x, unit: m}
    acceleration: {column: a, unit: m/s^2}
trials:
  group_by: [spring]
specimen:
  mass_kg: 2637.4
equation:
  terms: [stiffness, viscous_damping]
identify: [sindy]
discrepancy: {suspects: []}
"""


@dataclass(frozen=True)
class Case:
    """One bad input. ``spoil`` changes the campaign in a folder; a list that it returns are the command's words, which
    else are `run_words`.

    ``says`` is a regular expression of the sentence, ``code`` the exit code. ``slow``: seconds, or hundreds of MB.
    """

    name: str
    spoil: Callable[[Path], object]
    says: str
    code: int = FAILED
    slow: bool = False

    def words(self, folder: Path) -> list[str]:
        """Make the campaign in an empty folder, spoil it; the words of the command."""
        make(folder)
        words = self.spoil(folder)
        return words if isinstance(words, list) else run_words(folder)


def run_words(folder: Path, *more: str) -> list[str]:
    """``run`` of the folder's campaign."""
    return ["run", str(folder / "config.yaml"), "--out", str(folder / "run"), "--jobs", "1", *more]


def recorded(x0_m: float = 0.04, seed: int = 0) -> Table:
    """A hold and a linear decay, (n, 3): time s, displacement m, acceleration m/s2, with a little noise."""
    rng = np.random.default_rng(seed)
    held = round(HOLD_S * RATE_HZ)
    after = np.arange(round(MOTION_S * RATE_HZ)) / RATE_HZ
    root = -DECAY_PER_S + 1j * np.sqrt(OMEGA_RAD_PER_S**2 - DECAY_PER_S**2)
    factor = x0_m * np.conj(root) / (np.conj(root) - root)
    x, a = (2.0 * np.real(factor * root**order * np.exp(root * after)) for order in (0, 2))
    x, a = np.r_[np.full(held, x0_m), x], np.r_[np.zeros(held), a]
    noise = rng.standard_normal((2, x.size))
    return np.column_stack([np.arange(x.size) / RATE_HZ, x + 1e-4 * noise[0], a + 2e-2 * noise[1]])


def write_table(path: Path, table: Table, header: str = "t,x,a") -> None:
    """A table as CSV."""
    np.savetxt(path, table, delimiter=",", header=header, comments="", fmt="%.8g")


def make(folder: Path) -> None:
    """A campaign of one good trial: r00.csv, campaign.csv, config.yaml."""
    folder.mkdir(parents=True, exist_ok=True)
    write_table(folder / "r00.csv", recorded())
    (folder / "campaign.csv").write_text("file,spring\nr00.csv,long\n")
    (folder / "config.yaml").write_text(CONFIG)


def edit(path: Path, old: str, new: str) -> None:
    """Replace the first place of a text that must be there."""
    text = path.read_text()
    if old not in text:
        raise ValueError(f"{path.name} has no {old!r}; correct the case")
    path.write_text(text.replace(old, new, 1))
