"""`python -m experiments driven.efficiency [RECORDS]`: errors of driven fits beside the Cramer-Rao bound.

Bodies are known: every record of a case has the same body and input, and noise of its own. The bound comes of the
exact sensitivities at the truth, the start state among the unknowns; a fit begins from no start values where all laws
are linear in their numbers. An efficient fit's errors over the bound have an rms of 1.

Belongs here: these cases, their rows, the table of docs/driven_measured.md. Does not belong here: the fit
(methods/driven.py).
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from experiments.driven.bodies import NOTHING, slots_of, theta_of
from experiments.driven.page import kept
from undertow.conditioning.driven import DrivenTrial, Frame, Quantity
from undertow.equation.driven import driven_motion
from undertow.equation.driven_laws import find_driven
from undertow.equation.driven_slots import DRIVEN_SLOT
from undertow.equation.input import MotionSize
from undertow.likelihood.driven import MASS, DrivenLaws, drive_for
from undertow.methods.driven import fit_driven
from undertow.quantities import Hold, mover_of
from undertow.recording.recording import Array

RESULT = Path(__file__).with_name("efficiency.csv")
HEADER = ("case", "seed", "number", "truth", "found", "stderr", "bound")
RECORDS = 100
"""Records of a case; no rule was set on any."""
FIRST_SEED = 9000
RATE_HZ, SAMPLES, NOISE_M = 100.0, 3000, 1e-4
FINE = 60
"""Steps a period of the motions that stand for the truth."""
EQ15: Mapping[str, float] = {
    MASS: 4.0, "stiffness.k_N_per_m": 100.0, "viscous_damping.c_Ns_per_m": 3.0, "coulomb_friction.force_N": 5.0,
    "quadratic_drag.drag_Ns2_per_m2": 4.0,
}  # fmt: skip
STICKING: Mapping[str, float] = {
    MASS: 4.0, "stiffness.k_N_per_m": 100.0, "viscous_damping.c_Ns_per_m": 3.0, "coulomb_friction.force_N": 8.0,
}  # fmt: skip
HIDDEN: Mapping[str, float] = {
    MASS: 4.0, "stiffness.k_N_per_m": 100.0, "viscous_damping.c_Ns_per_m": 3.0, "hidden_resonator.mass_kg": 0.8,
    "hidden_resonator.natural_frequency_rad_per_s": 8.0, "hidden_resonator.damping_ratio": 0.04,
}  # fmt: skip
DELAY = "input_delay_s"


@dataclass(frozen=True)
class Case:
    """A body's ``numbers`` by name, what drives it, the numbers that a fit is told (``held``) or begins from
    (``starts``)."""

    numbers: Mapping[str, float]
    drive: str
    hold: Hold = "first"
    quantity: Quantity = "force"
    held: Mapping[str, float] = field(default_factory=dict)
    starts: Mapping[str, float] = field(default_factory=dict)

    @property
    def laws(self) -> DrivenLaws:
        """What is fitted."""
        names = dict.fromkeys(name.split(".")[0] for name in self.numbers if "." in name)
        return DrivenLaws(tuple(find_driven(name) for name in names), dict(self.held), dict(self.starts))

    @property
    def slots(self) -> dict[str, str]:
        """The integrator's slot of each number."""
        return slots_of(self.laws.terms, mover_of(self.quantity))

    def theta(self) -> Array:
        """The integrator's vector of the truth, from rest."""
        return theta_of(self.laws.terms, self.numbers, {}, mover_of(self.quantity))


def near(numbers: Mapping[str, float], share: float = 0.1) -> dict[str, float]:
    """Numbers that are off by that share, up and down in turn."""
    return {name: value * (1.0 + (share if i % 2 else -share)) for i, (name, value) in enumerate(numbers.items())}


CASES: Mapping[str, Case] = {
    "Eq. 15, random force": Case(EQ15, "random"),
    "Eq. 15, swept force": Case(EQ15, "swept"),
    "Eq. 15, swept base, mass known": Case(
        EQ15, "base", "band_limited", "base_displacement", held={MASS: EQ15[MASS]}
    ),
    "Eq. 15, random force, delay of 2 ms": Case(
        {**EQ15, DELAY: 0.002}, "random", "band_limited", starts={DELAY: 0.0, **near(EQ15)}
    ),
    "sticks and slips, harmonic force": Case(STICKING, "harmonic"),
    "hidden oscillator, random force": Case(
        HIDDEN, "random", starts=near(HIDDEN),
        held={"hidden_resonator.quadratic_damping_per_m": 0.0, "hidden_resonator.cubic_stiffness_per_m2_s2": 0.0},
    ),
}  # fmt: skip


def clean(case: Case) -> DrivenTrial:
    """The body's record without noise. What drives it is the same in all records of a case."""
    t = np.arange(SAMPLES) / RATE_HZ
    angle = 2.0 * np.pi * (0.2 * t + 0.5 * 1.4 / t[-1] * t**2)
    if case.drive == "random":
        rng = np.random.default_rng([FIRST_SEED, 1])  # not the noise's: the force would tell of it
        u = np.convolve(rng.normal(size=SAMPLES + 30), np.hanning(30), "same")[:SAMPLES] * 20.0
    elif case.drive == "swept":
        u = 60.0 * np.sin(angle)
    elif case.drive == "base":
        u = 0.2 * np.sin(angle)
    else:  # below the resonance, 1.5 times the friction: the body stands for a part of every half swing
        u = 12.0 * np.sin(2.0 * np.pi * 0.25 * t)
    frames: dict[str, Frame] = {"displacement": "relative"} if case.quantity != "force" else {}
    made = DrivenTrial("record", t, u, {"displacement": u}, case.quantity, case.hold, frames=frames)
    x = driven_motion(case.theta(), NOTHING, drive_for(made), t, MotionSize(), FINE).x[:, 0]
    return replace(made, outputs={"displacement": x})


def bound(case: Case, trial: DrivenTrial) -> dict[str, float]:
    """Cramer-Rao bound of every number that is not held, from the sensitivities at the truth, with the start state
    unknown."""
    sought = [name for name in case.numbers if name not in case.held]
    begin = ["x0", "v0", *(f"{kind}{number}" for number in case.laws.oscillators for kind in ("hs", "hu"))]
    active = np.array([DRIVEN_SLOT[slot] for slot in [*(case.slots[name] for name in sought), *begin]])
    motion = driven_motion(case.theta(), active, drive_for(trial), np.array(trial.t), MotionSize(), FINE)
    jacobian = motion.x[:, 1:] / NOISE_M
    scale = np.sqrt(np.sum(jacobian**2, axis=0))
    covariance = np.linalg.inv((jacobian / scale).T @ (jacobian / scale)) / np.outer(scale, scale)
    return dict(zip(sought, np.sqrt(np.diag(covariance)).tolist(), strict=False))


def rows(label: str, seeds: Sequence[int]) -> list[tuple[str, ...]]:
    """Numbers of so many records of a case, a line each."""
    case = CASES[label]
    whole = clean(case)
    limits, out = bound(case, whole), []
    for seed in seeds:
        noise = NOISE_M * np.random.default_rng(seed).normal(size=SAMPLES)
        trial = replace(whole, outputs={"displacement": whole.outputs["displacement"] + noise})
        found = fit_driven([trial], case.laws)
        errors = dict(zip(found.names, np.sqrt(np.diag(found.covariance)), strict=True))
        for name, limit in limits.items():
            numbers = (case.numbers[name], found.numbers[name], errors[name], limit)
            out.append((label, str(seed), name, *(f"{number:.8g}" for number in numbers)))
    return out


def ratios(lines: Sequence[Sequence[str]]) -> Array:
    """Errors over the Cramer-Rao bound (n,)."""
    truth, found, limit = (np.array([line[i] for line in lines], dtype=np.float64) for i in (3, 4, 6))
    return np.asarray((found - truth) / limit)


def table(lines: Sequence[Sequence[str]]) -> str:
    """Markdown: of each case the rms of all errors over the bound, of its worst number, and the largest."""
    out = [
        "| case | records | numbers | errors over the bound, rms | worst number | largest | stated over the bound |",
        "|---|---|---|---|---|---|---|",
    ]
    for label in dict.fromkeys(line[0] for line in lines):
        own = [line for line in lines if line[0] == label]
        names = list(dict.fromkeys(line[2] for line in own))
        each = {name: np.sqrt(np.mean(ratios([one for one in own if one[2] == name]) ** 2)) for name in names}
        worst = max(names, key=lambda name: each[name])
        stated = np.median([float(line[5]) / float(line[6]) for line in own])
        away = ratios(own)
        out.append(
            f"| {label} | {len(own) // len(names)} | {len(names)} | {np.sqrt(np.mean(away**2)):.2f} | "
            f"`{worst}` {each[worst]:.2f} | {np.max(np.abs(away)):.1f} | {stated:.2f} |"
        )
    return "\n".join(out)


def main() -> None:
    """Every case, the file and the page's table."""
    records = int(sys.argv[1]) if len(sys.argv) > 1 else RECORDS
    lines = []
    for label in CASES:
        lines += rows(label, range(FIRST_SEED, FIRST_SEED + records))
        print(table([line for line in lines if line[0] == label]).splitlines()[-1], flush=True)
    kept(RESULT, HEADER, lines, table, "efficiency")
