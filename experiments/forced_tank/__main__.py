"""What an equation from decays says of the same tank when it is driven: amplitudes that were held before the decays.

    python -m experiments forced_tank  # writes docs/pictures/forced_tank.svg, prints a table of docs/driven_measured.md

The tank was moved at .953, .960 and .967 of its natural frequency, then let go: its decays are in
../shared/recordings/sloshing_tank_decay, whose README has the sources. How far it was moved is not known: the force
that gives the first amplitude is found, goes with the square of the frequency, and must give the other two.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

import undertow
from undertow.report.style import page_style

ROOT = Path(__file__).resolve().parents[2]
DRIVEN_AT = (0.953, 0.960, 0.967)
TERMS = ("stiffness", "viscous_damping", "cubic_stiffness")
FREQUENCIES = np.linspace(1.10, 1.30, 81)


def amplitude(equation: object, frequency_Hz: float, force: float) -> float:
    """Amplitude at one frequency, swept down to it: of a softening body the upper branch."""
    path = np.linspace(1.30, frequency_Hz, 40)
    return float(undertow.frequency_response(equation, path, force=force, sweep="down").table["amplitude"].iloc[-1])


def main() -> None:
    """Fit the decays, find the force, predict, print and draw."""
    trials = undertow.load(ROOT / "configs" / "recordings" / "sloshing_tank.yaml")
    found = undertow.fit(trials, TERMS)
    print(found)
    stiffness = dict(zip((term.name for term in found.equation.terms), found.equation.coefficients, strict=True))
    natural = math.sqrt(stiffness["stiffness"] / found.equation.mass_kg) / (2.0 * math.pi)
    held = trials.table["amplitude"].to_numpy()
    at = natural * np.array(DRIVEN_AT)
    first = brentq(lambda force: amplitude(found, at[0], force) - held[0], 5.0, 12.0, xtol=1e-3)
    print(f"natural frequency {natural:.4f} Hz; force {first:.3f} at {at[0]:.4f} Hz")
    said = [amplitude(found, f, first * (f / at[0]) ** 2) for f in at]
    for share, f, one, other in zip(DRIVEN_AT, at, held, said, strict=True):
        print(f"| {share} | {f:.4f} | {one:.2f} | {other:.2f} |")
    draw(found, first, at, held)


def draw(equation: object, force: float, at: np.ndarray, held: np.ndarray) -> None:
    """Both sweeps and the amplitudes at which the decays begin."""
    from matplotlib import pyplot

    with page_style():
        figure, axes = pyplot.subplots(figsize=(6.4, 3.6))
        forces = force * (FREQUENCIES / at[0]) ** 2
        for sweep, style in (("down", "-"), ("up", "--")):
            table = undertow.frequency_response(equation, FREQUENCIES, force=forces, sweep=sweep).table
            axes.plot(table["frequency_Hz"], table["amplitude"], style, label=f"equation of the decays, swept {sweep}")
        axes.plot(at, held, "o", label="held before the decays")
        axes.set_xlabel("frequency of the drive (Hz)")
        axes.set_ylabel("centre of mass (% of the width)")
        axes.legend()
        figure.savefig(ROOT / "docs" / "pictures" / "forced_tank.svg", metadata={"Date": None})
