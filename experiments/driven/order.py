"""How often swapped columns of force and displacement are refused, and columns in their places are not:
``python -m experiments driven.order`` (under a minute, and the table of docs/driven_measured.md).

Belongs here: the cases and their counts. Does not belong here: the rule (methods/driven_order.py).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from experiments.driven.bodies import NOTHING, body, record, theta_of
from experiments.driven.page import put
from undertow.campaign.config import load
from undertow.campaign.driven.trials import driven_trials
from undertow.conditioning.driven import DrivenTrial
from undertow.equation.driven import driven_motion
from undertow.equation.input import MotionSize, drive_of
from undertow.errors import IdentificationError
from undertow.methods.driven_order import must_not_be_swapped

SEEDS = range(13000, 13008)
LAWS = ("", "bouc_wen", "quadratic_drag", "hidden_resonator", "cubic_stiffness", "stribeck_friction")
DELAYS_S = (0.002, 0.02, 0.05)
LIGHT = {"mass": 4.0, "k1": 100.0, "c1": 0.3}
STIFF = {"mass": 0.04, "k1": 100.0, "c1": 0.3}
SETS = ("emps", "silverbox", "bouc_wen")


def simple(numbers: dict[str, float], seed: int, swept: bool = False, delay: float = 0.0) -> DrivenTrial:
    """30 s of a sprung body with those numbers under a random or a swept force that it feels later; noise 0.1 mm."""
    rng = np.random.default_rng(seed)
    t = np.arange(3000) * 0.01
    u = np.convolve(rng.normal(size=t.size + 30), np.hanning(30), "same")[: t.size] * 20.0
    if swept:
        u = 60.0 * np.sin(2.0 * np.pi * (0.2 * t + 0.5 * 1.4 / t[-1] * t**2))
    theta = theta_of((), {}, {"delay": delay, **numbers})
    x = driven_motion(theta, NOTHING, drive_of(t, u, "first"), t, MotionSize(), 60).x[:, 0]
    return DrivenTrial("simple", t, u, {"displacement": x + 1e-4 * rng.normal(size=t.size)})


def cases() -> Iterator[tuple[str, list[DrivenTrial]]]:
    """Each row of the table and its records."""
    for kind in ("random", "swept"):
        name = f"spring, damper, friction, without and with one of five laws, {kind} force"
        yield name, [record(body(kind, seed, law)) for law in LAWS for seed in SEEDS]
    name = "spring and light damper, force felt 2, 20 or 50 ms later"
    yield name, [simple(LIGHT, s, swept, d) for d in DELAYS_S for swept in (False, True) for s in SEEDS]
    yield "far stiffer than the force is fast", [simple(STIFF, seed) for seed in SEEDS]
    yield "carriage in closed loop, pushed by 0 or 20 N", [
        record(body("carriage", seed), pushed_N=push) for push in (0.0, 20.0) for seed in SEEDS[:3]
    ]
    for name in SETS:
        yield name, list(driven_trials(load(f"configs/driven/{name}.yaml"))[0])


ORDERS: dict[str, Callable[[DrivenTrial], tuple[np.ndarray, np.ndarray]]] = {
    "in their places": lambda trial: (trial.u, trial.outputs["displacement"]),
    "the force's sign turned": lambda trial: (-trial.u, trial.outputs["displacement"]),
    "swapped": lambda trial: (trial.outputs["displacement"], trial.u),
    "swapped, one sign turned": lambda trial: (-trial.outputs["displacement"], trial.u),
}
"""Columns as force and displacement, by their order."""


def refused(trial: DrivenTrial, order: str) -> bool:
    """Whether the columns in that order are refused as swapped."""
    u, x = ORDERS[order](trial)
    try:
        must_not_be_swapped(DrivenTrial(trial.name, trial.t, u, {"displacement": x}))
    except IdentificationError:
        return True
    return False


def main() -> None:
    """Every case, and the page's table."""
    lines = [f"| records | number | {' | '.join(ORDERS)} |", "|---" * (2 + len(ORDERS)) + "|"]
    for name, trials in cases():
        counts = [sum(refused(trial, order) for trial in trials) for order in ORDERS]
        lines.append(f"| {name} | {len(trials)} | {' | '.join(map(str, counts))} |")
        print(lines[-1], flush=True)
    put("\n".join(lines), "order")
