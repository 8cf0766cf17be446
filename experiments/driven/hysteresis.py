"""`python -m experiments driven.hysteresis [--calibration] [FILE]`: which hysteresis, proved on another amplitude.

Sprung bodies with one of the family's laws under a random force. The search knows the spring and the damper; what it
adds is run free on a record of twice and of half the amplitude that it was given, and so is every other member, fitted
to the same record. Seeds of the rules' calibration and those of the proof differ. A finished row is kept in FILE.

Belongs here: truths, records, rows, the table of docs/driven_measured.md. Does not belong here: the search
(comparison/driven_hysteresis.py).
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from experiments.driven.bodies import NOTHING, theta_of
from experiments.driven.page import resumed
from undertow.comparison.driven_folds import validation_rms
from undertow.comparison.driven_search import DrivenFound, discover_driven
from undertow.conditioning.driven import DrivenTrial
from undertow.equation.driven import driven_motion
from undertow.equation.driven_laws import find_driven
from undertow.equation.input import MotionSize, drive_of
from undertow.likelihood.driven import DrivenLaws
from undertow.methods.driven import DrivenFit

RESULT = Path(__file__).with_name("hysteresis.csv")
CALIBRATION, PROOF = 0, 7200
"""First seeds of the two sets; 7000 to 7103 proved the rules before."""
REPEATED = 4
"""Bodies of each truth."""
RATE_HZ, SAMPLES, NOISE_M = 100.0, 6000, 1e-4
FORCE_N = 25.0
"""Root mean square of the force in training; 12.5 and 50 N in the records that prove."""
GIVEN = ("stiffness", "viscous_damping")
TRUTHS = ("bouc_wen 1", "bouc_wen 2", "lugre", "iwan", "pinched")
HEADER = (
    "truth", "seed", "added", "rivals", "fifth", "half", "double", "given_half", "given_double", "member",
    "member_half", "member_double", "deviations", "seconds",
)  # fmt: skip


def numbers_of(truth: str, seed: int) -> Mapping[str, float]:
    """A body's numbers by law.parameter and ``mass_kg``."""
    rng = np.random.default_rng([seed, TRUTHS.index(truth)])

    def about(value: float) -> float:
        """A number within a third of that."""
        return float(value * rng.uniform(0.75, 1.33))

    body = {"mass_kg": about(4.0), "stiffness.k_N_per_m": about(100.0), "viscous_damping.c_Ns_per_m": about(3.0)}
    law = truth.split()[0]
    if law == "bouc_wen":
        exponent = float(truth.split()[1])
        inner = {"alpha_N_per_m": about(200.0), "loop": about(7.0), "skew": about(1.5), "exponent": exponent,
                 "unit_N": 20.0}  # fmt: skip
    elif law == "lugre":
        inner = {"sigma0_N_per_m": about(800.0), "coulomb_N": about(10.0), "static_N": about(6.0),
                 "velocity_m_per_s": about(0.15), "sigma1_Ns_per_m": 0.0}  # fmt: skip
    elif law == "iwan":
        inner = {"stiffness_N_per_m": about(250.0), "slip_N": about(25.0), "chi": 0.0}
    else:
        inner = {"alpha_N_per_m": about(300.0), "loop": about(10.0), "skew": 0.0, "pinch": 0.8, "width_N": about(8.0)}
    return body | {f"{law}.{key}": value for key, value in inner.items()}


def record(truth: str, seed: int, factor: float) -> DrivenTrial:
    """The body's record at a force of so many times FORCE_N, with white noise."""
    numbers, rng = numbers_of(truth, seed), np.random.default_rng([seed, round(100 * factor)])
    laws = [find_driven(name) for name in (*GIVEN, truth.split()[0])]
    t = np.arange(SAMPLES) / RATE_HZ
    u = np.convolve(rng.normal(size=t.size + 40), np.hanning(40), "same")[: t.size]
    u *= factor * FORCE_N / np.std(u)
    x = driven_motion(theta_of(laws, numbers, {}), NOTHING, drive_of(t, u), t, MotionSize(), 60).x[:, 0]
    return DrivenTrial("body", t, u, {"displacement": x + NOISE_M * rng.normal(size=t.size)}, hold="first")


def row(truth: str, seed: int) -> tuple[str, ...]:
    """One body's line: what is added; errors of free runs in units of the noise, of what was added, of the equation
    as given, and of the best of the other members; errors of the numbers in standard errors."""
    trial, begun = record(truth, seed, 1.0), time.perf_counter()
    found = discover_driven([trial], DrivenLaws(tuple(find_driven(name) for name in GIVEN)))
    seconds = time.perf_counter() - begun
    tests = [record(truth, seed, factor) for factor in (0.5, 2.0)]
    own, plain = away(tests, found.augmented or found.baseline), away(tests, found.baseline)
    law = truth.split()[0]
    others = {name: away(tests, one) for name, one in found.members.items() if name.split()[0] != law}
    if law == "bouc_wen" and truth != "bouc_wen 1" and "bouc_wen" in found.members:
        others["bouc_wen"] = away(tests, found.members["bouc_wen"])
    best = min(others, key=lambda name: sum(others[name]), default="")
    errors = (found.validation[1] / NOISE_M, *own, *plain)
    said = (truth, str(seed), " ".join(found.added) or "nothing", ", ".join(found.rivals))
    other = (best, *(f"{error:.4g}" for error in others.get(best, (np.nan, np.nan))))
    return (*said, *(f"{error:.4g}" for error in errors), *other, deviations(truth, seed, found), f"{seconds:.1f}")


def away(tests: Sequence[DrivenTrial], fitted: DrivenFit) -> list[float]:
    """Errors of the free runs over records that nobody fitted, in units of the noise."""
    return [validation_rms([one], fitted) / NOISE_M for one in tests]


def deviations(truth: str, seed: int, found: DrivenFound) -> str:
    """Errors of the numbers of the equation that was found, in standard errors, one after the other; empty where it is
    not that of the truth. Bouc and Wen's loop and skew are those in the truth's unit of z."""
    numbers, fitted = numbers_of(truth, seed), found.augmented or found.baseline
    values, turn = dict(zip(fitted.names, fitted.values.tolist(), strict=True)), np.eye(len(fitted.names))
    if any(name not in numbers for name in fitted.names) or len(found.added) != 1:
        return ""
    if "bouc_wen.exponent" in fitted.names:
        ratio = numbers["bouc_wen.unit_N"] / fitted.numbers["bouc_wen.unit_N"]
        scale, exponent = ratio ** (values["bouc_wen.exponent"] - 1.0), fitted.names.index("bouc_wen.exponent")
        for name in ("bouc_wen.loop", "bouc_wen.skew"):
            i = fitted.names.index(name)
            turn[i, i], turn[i, exponent] = scale, values[name] * scale * np.log(ratio)
            values[name] *= scale
    errors = np.sqrt(np.diag(turn @ fitted.covariance @ turn.T))
    return " ".join(
        f"{(values[name] - numbers[name]) / error:.2f}"
        for name, error in zip(fitted.names, errors, strict=True)
    )


def table(rows: Sequence[Sequence[str]]) -> str:
    """Markdown: by truth, what is added, errors on the other amplitudes, errors of the numbers."""
    lines = [
        "| truth | right law alone | beside it, or instead | half: found, given, best other | twice: found, given, "
        "best other | errors of numbers, rms (largest) | s |",
        "|---|---|---|---|---|---|---|",
    ]
    named = [dict(zip(HEADER, one, strict=True)) for one in rows]
    for truth in TRUTHS:
        own = [one for one in named if one["truth"] == truth]
        right = [one for one in own if one["added"] == truth.split()[0]]
        wrong = ", ".join(one["added"] for one in own if one not in right) or "none"
        numbers = np.array([float(n) for one in right for n in one["deviations"].split()] or [np.nan])

        def middle(key: str, own: Sequence[Mapping[str, str]] = own) -> str:
            values = [float(one[key]) for one in own]
            return "none" if np.any(np.isnan(values)) else f"{float(np.median(values)):.3g}"

        shown = [", ".join(middle(f"{key}{size}") for key in ("", "given_", "member_")) for size in ("half", "double")]
        size = f"{float(np.sqrt(np.mean(numbers**2))):.2g} ({float(np.max(np.abs(numbers))):.2g})"
        lines.append(
            f"| {len(own)} {truth} | {len(right)} | {wrong} | {shown[0]} | {shown[1]} | {size} | {middle('seconds')} |"
        )
    return "\n".join(lines)


def cases(first: int) -> Iterator[tuple[str, int]]:
    """Every body of a set: its truth and its seed."""
    for number in range(REPEATED):
        for truth in TRUTHS:
            yield truth, first + number


def main() -> None:
    """The study as a command."""
    resumed(
        RESULT, HEADER, (CALIBRATION, PROOF), cases, lambda truth, seed: (truth, str(seed)),
        lambda truth, seed: [row(truth, seed)], table, "hysteresis",
    )  # fmt: skip
