"""What a law of a user's own costs beside a built-in one: the same law as a row of the registry, as a class whose
formula is read, and as the same class integrated in Python.

    python -m benchmarks.own_law

writes own_law.csv: processor time of one motion with its sensitivities, and of one fit, medians of some rounds.

Belongs here: that comparison. Does not belong here: fits against other packages (speed.py).
"""

from __future__ import annotations

import csv
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from undertow.conditioning.condition import condition
from undertow.conditioning.motion import Motion
from undertow.equation import general
from undertow.equation.equation import Equation
from undertow.equation.registry import find
from undertow.equation.simulate import simulate
from undertow.equation.term import Array, Term
from undertow.likelihood.fit import Fit, Specimen
from undertow.likelihood.problem import TrialOptions
from undertow.methods.baseline import fit_group, group_model
from undertow.quantities import Parameter
from undertow.recording.recording import Recording

RESULT = Path(__file__).with_name("own_law.csv")
MASS_KG, K_N_PER_M, C_NS_PER_M, FRICTION_N, BRAKE = 2637.4, 109_600.0, 300.0, 180.0, 3e5
X0_M, DURATION_S, RATE_HZ, NOISE_M = 0.08, 5.0, 100.0, 2e-4
COMPILED_ROUNDS, PYTHON_ROUNDS = 5, 1


@dataclass(frozen=True)
class OwnBrake(Term):
    """Damping that grows with the square of the displacement, as a user would write it."""

    name: ClassVar[str] = "own_brake"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("Ns_per_m3", "N s/m^3", "q"),)
    law: ClassVar[str] = "q x^2 v"
    latex: ClassVar[str] = r"q x^2 \dot{x}"
    source: ClassVar[str] = "this benchmark"
    left_out: ClassVar[str] = "large swings die later"

    def force(self, x: Array, v: Array, a: Array, t: Array) -> Array:
        """x^2 v, (n,)."""
        return x**2 * v


def terms(own: bool) -> tuple[Term, ...]:
    """Spring, damper, friction and the law."""
    law = OwnBrake() if own else find("van_der_pol_damping")
    return (find("stiffness"), find("viscous_damping"), find("coulomb_friction"), law)


def released() -> Motion:
    """One noisy release."""
    equation = Equation(terms(own=False), (K_N_PER_M, C_NS_PER_M, FRICTION_N, BRAKE), mass_kg=MASS_KG)
    time_s = np.arange(0.0, DURATION_S, 1.0 / RATE_HZ)
    free = time_s > 0.5
    x = np.full(time_s.size, X0_M)
    x[free] = simulate(equation, X0_M, time_s[free] - 0.5).x
    noisy = x + NOISE_M * np.random.default_rng(0).standard_normal(x.size)
    return condition(Recording("r", time_s, {"displacement": noisy}))


def fitted(motion: Motion, own: bool) -> Fit:
    """Spring, damping, friction and the law from the release."""
    model = group_model(terms(own), [motion], Specimen(MASS_KG), None, dry=True, anchored=True)
    return fit_group(model, [motion], TrialOptions())


def cpu_s(work: Callable[[], object], rounds: int) -> float:
    """Median processor time."""
    taken = []
    for _ in range(rounds):
        begun = time.process_time()
        work()
        taken.append(time.process_time() - begun)
    return float(np.median(taken))


def main() -> None:
    """Measure, print, write."""
    motion, rows = released(), []
    read = general.formula_of
    for way, own, formula, rounds in (
        ("built in", False, read, COMPILED_ROUNDS), ("own law, read as a formula", True, read, COMPILED_ROUNDS),
        ("own law, integrated in Python", True, lambda *_: None, PYTHON_ROUNDS),
    ):  # fmt: skip
        general.formula_of = formula
        found = fitted(motion, own)
        name = "own_brake" if own else "van_der_pol_damping"
        number = next(e.value for key, e in found.estimates.items() if key.startswith(name))
        rows.append({"way": way, "fit_ms": 1e3 * cpu_s(lambda own=own: fitted(motion, own), rounds), "number": number})
        print(rows[-1], flush=True)
    with RESULT.open("w", newline="") as stream:
        writer = csv.DictWriter(stream, ("way", "fit_ms", "ratio", "number"), lineterminator="\n")
        writer.writeheader()
        for row in rows:
            ratio = float(str(row["fit_ms"])) / float(str(rows[0]["fit_ms"]))
            said = {"fit_ms": f"{row['fit_ms']:.4g}", "ratio": f"{ratio:.3g}", "number": f"{row['number']:.11g}"}
            writer.writerow({**row, **said})


if __name__ == "__main__":
    main()
