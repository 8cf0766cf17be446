"""How exact the compiled integrator is: random equations against DOP853 split at every event (rtol 1e-12).

    nice -n 5 python -m experiments integrator.accuracy --cases 450

writes accuracy.csv (one row a case) and accuracy.md (quantiles a kind) beside this file. The equations: bodies of 2 to
5 t at 3 to 13 rad/s, damping ratio 0.5 to 8 %, friction that lets most of them stick within the 12 s, one extra of
each kind in turn. Errors are the largest over the motion, in units of the release x0.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import numpy as np

from experiments.files import write_rows
from tests.reference import reference
from undertow.equation import registry
from undertow.equation.equation import Equation
from undertow.equation.simulate import simulate

HERE = Path(__file__).parent
TIMES_S = np.arange(0.0, 12.0, 0.02)
STEPS_PER_PERIOD = (60, 200)
KINDS = (
    "plain", "light", "stick", "reslip", "hidden", "hidden_large", "two_hidden", "relaxation", "hysteresis", "echo",
    "forcing", "cubic", "stribeck", "variable_normal", "exponent",
)  # fmt: skip


def random_case(number: int) -> tuple[str, Equation, float]:
    """Kind, equation and release (m) of case ``number``; the number is the seed."""
    rng = np.random.default_rng(number)
    kind = KINDS[number % len(KINDS)]
    mass, w = rng.uniform(2000.0, 5000.0), rng.uniform(3.0, 13.0)
    x0 = rng.choice([-1.0, 1.0]) * rng.uniform(0.005, 0.1)
    k = mass * w**2
    damping = 0.005 if kind == "light" else rng.uniform(0.005, 0.08)
    friction = rng.uniform(0.0, 0.02) if kind == "light" else rng.uniform(0.002, 0.05)
    if kind in ("stick", "reslip"):
        friction = rng.uniform(0.15, 0.4)
    coefficients = {
        "stiffness": k,
        "viscous_damping": 2.0 * damping * mass * w,
        "coulomb_friction": friction * k * abs(x0),
        "quadratic_drag": rng.uniform(0.0, 0.3) * mass / abs(x0) if kind != "light" else 0.0,
    }
    extra = _extra(kind, rng, mass, w, abs(x0))
    if kind == "exponent":
        coefficients.pop("quadratic_drag")
    terms = [registry.find(name) for name in coefficients] + [term for term, _ in extra]
    values = [*coefficients.values(), *(value for _, value in extra)]
    return kind, Equation(tuple(terms), tuple(values), mass_kg=mass), float(x0)


def _extra(kind: str, rng: np.random.Generator, mass: float, w: float, x0: float) -> list:
    """The terms that a kind adds, with their coefficients."""
    k = mass * w**2

    def resonator(large: bool, share: float) -> tuple:
        inner = {"natural_frequency_rad_per_s": w * rng.uniform(0.5, 1.6), "damping_ratio": rng.uniform(0.002, 0.1)}
        if large:
            inner["quadratic_damping_per_m"] = rng.uniform(0.5, 5.0)
            inner["cubic_stiffness_per_m2_s2"] = rng.uniform(-0.02, 0.1) * w**2 / x0**2
        return registry.find("hidden_resonator", **inner), share * mass

    def harmonic() -> dict[str, float]:
        return {"frequency_rad_per_s": rng.uniform(1.0, 15.0), "phase_rad": rng.uniform(-3.0, 3.0)}

    made = {
        "reslip": lambda: [resonator(False, rng.uniform(0.1, 0.4))],
        "hidden": lambda: [resonator(False, rng.uniform(0.01, 0.3))],
        "hidden_large": lambda: [resonator(True, rng.uniform(0.01, 0.2))],
        "two_hidden": lambda: [resonator(False, 0.1), resonator(True, 0.05)],
        "relaxation": lambda: [
            (registry.find("relaxation", time_s=rng.uniform(0.05, 2.0)), rng.uniform(0.02, 0.3) * k)
        ],
        "hysteresis": lambda: [
            (registry.find("hysteresis", yield_displacement_m=rng.uniform(0.1, 0.8) * x0), rng.uniform(0.02, 0.2) * k)
        ],
        "echo": lambda: [
            (registry.find("delayed_echo", delay_s=rng.uniform(0.3, 3.0)), rng.uniform(-0.05, 0.05) * mass * w)
        ],
        "forcing": lambda: [(registry.find("external_forcing", **harmonic()), rng.uniform(0.01, 0.2) * k * x0)],
        "cubic": lambda: [(registry.find("cubic_stiffness"), rng.uniform(-0.2, 0.5) * k / x0**2)],
        "stribeck": lambda: [
            (registry.find("stribeck_friction", velocity_m_per_s=rng.uniform(0.1, 0.5) * w * x0), 0.05 * k * x0)
        ],
        "variable_normal": lambda: [(registry.find("variable_normal_force"), rng.uniform(0.01, 0.1) * k)],
        "exponent": lambda: [
            (registry.find("drag_exponent", exponent=rng.uniform(1.1, 2.8)), rng.uniform(0.01, 0.1) * mass * w)
        ],
    }
    return made[kind]() if kind in made else []


def errors_of(number: int) -> dict[str, float | int | str]:
    """One row of the table: largest error over x0 at each step size, share of the time at rest, stops and starts."""
    kind, equation, x0 = random_case(number)
    exact = reference(equation, x0, TIMES_S)[0]
    row: dict[str, float | int | str] = {"case": number, "kind": kind}
    for steps in STEPS_PER_PERIOD:
        motion = simulate(equation, x0, TIMES_S, steps_per_period=steps)
        row[f"error_{steps}"] = float(np.max(np.abs(motion.x - exact)) / abs(x0))
    still = np.diff(motion.x) == 0.0
    row["share_at_rest"] = float(np.mean(still))
    row["starts_again"] = int(np.sum(still[:-1] & ~still[1:]))
    return row


def main() -> None:
    """Run the cases, write the table and its summary."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cases", type=int, default=450)
    count = parser.parse_args().cases
    began = time.process_time()
    rows = [errors_of(number) for number in range(count)]
    seconds = time.process_time() - began
    shown = [[f"{v:.3g}" if isinstance(v, float) else v for v in row.values()] for row in rows]
    write_rows(HERE / "accuracy.csv", rows[0], shown)
    (HERE / "accuracy.md").write_text(summary(rows, seconds))


def summary(rows: list, seconds: float) -> str:
    """Median, 99 % quantile and largest error a kind, as a Markdown table."""
    lines = [
        f"# The compiled integrator against DOP853 split at events, {len(rows)} random equations",
        "",
        f"Largest error over 12 s in units of x0, by steps a period; {seconds:.0f} s of CPU. "
        "Made by `python -m experiments integrator.accuracy`.",
        "",
        "| kind | cases | stick | start again | 60: median | 99 % | largest | 200: median | 99 % | largest |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for kind in (*KINDS, "all"):
        mine = [row for row in rows if kind in (row["kind"], "all")]
        if not mine:
            continue
        cells = [kind, str(len(mine)), str(sum(r["share_at_rest"] > 0 for r in mine))]
        cells.append(str(sum(r["starts_again"] > 0 for r in mine)))
        for steps in STEPS_PER_PERIOD:
            errors = np.array([r[f"error_{steps}"] for r in mine])
            cells += [f"{q:.1e}" for q in (np.median(errors), np.quantile(errors, 0.99), errors.max())]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"
