"""The flume's own answer per level: added mass, damping and the water's modes; and each trial's truth.

Computed from the linear operators alone, twice: eigenvalues of the surface's state matrix, and a rational
fit of A(w), B(w).
"""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np

from experiments.virtual_flume import frequency, section
from experiments.virtual_flume.campaign import SEED, Trial, water_at
from experiments.virtual_flume.frequency import Mode, Water
from experiments.virtual_flume.rational import RationalFit, vector_fit
from experiments.virtual_flume.structure import DRAG_COEFFICIENT, MASS_KG, SPRINGS, drag_factor, normal_force
from experiments.virtual_flume.trials import rounded

Array = np.ndarray

LARGEST_DAMPING_RATIO = 0.10  # a pole above it is not called a mode
LEAST_MASS_SHARE = 0.02  # of m + A at the long spring's body frequency
NEIGHBOUR_BAND = 0.03  # relative distance in frequency within which cells' modes count as one resonator
FIT_PAIRS = 10
FIT_BAND = (2.0, 16.0)  # rad/s


@dataclass(frozen=True)
class LevelAnswer:
    """One level: A (kg) and B (N s/m) over `w` (rad/s), modes by both ways, the body's frequencies."""

    depth_m: float
    w: Array
    added_mass: Array
    damping: Array
    at_once_kg: float
    poles: list[Mode]
    named: list[Mode]
    beside: list[Mode]
    fit: RationalFit
    fitted: list[Mode]
    body: dict[str, dict[str, object]]


def sampled(water: Water, poles: list[Mode]) -> tuple[Array, Array, Array]:
    """Frequencies (rad/s), A (kg) and B (N s/m), close together around every light pole."""
    w = np.arange(FIT_BAND[0], FIT_BAND[1] + 1e-9, 0.05)
    near = 1.0 + np.array([-0.02, -0.01, -0.006, -0.003, -0.001, 0.0, 0.001, 0.003, 0.006, 0.01, 0.02])
    light = [m for m in poles if m.damping_ratio < 0.03 and abs(m.participating_mass) > 5.0]
    w = np.unique(np.concatenate([w, *[m.frequency * near for m in light]]))
    w = w[w <= FIT_BAND[1]]
    return w, *frequency.added_mass_and_damping(water, w)


def modal_mass(poles: list[Mode], s: complex) -> complex:
    """What modes add to the apparent mass at s: sum of m (2 z w s + w^2) / (s^2 + 2 z w s + w^2); kg."""
    total = 0.0 + 0.0j
    for m in poles:
        loss = 2.0 * m.damping_ratio * m.frequency * s
        total += m.participating_mass * (loss + m.frequency**2) / (s * s + loss + m.frequency**2)
    return total


def body_answer(water: Water, beside: list[Mode], stiffness: float) -> dict[str, object]:
    """A and B at a spring's body frequency (the one that carries most of a release), and all such frequencies.

    `beside`: the modes whose mass is taken out of A for the mass that follows the body at once.
    """
    found = frequency.body_frequencies(water, MASS_KG, stiffness)
    w = found[0].frequency
    added, damping = frequency.added_mass_and_damping(water, np.array([w]))
    return {
        "body_frequency_rad_per_s": w,
        "added_mass_kg": float(added[0]),
        "radiation_damping_Ns_per_m": float(damping[0]),
        "added_mass_without_resonators_kg": float(added[0] - modal_mass(beside, 1j * w).real),
        "frequencies_and_shares_of_a_release": [asdict(f) for f in found],
    }


def level_answer(depth_m: float, water: Water | None = None) -> LevelAnswer:
    """The answer of one wet level."""
    water = water or water_at(depth_m)
    if water is None:
        raise ValueError(f"water depth {depth_m} m is dry; there is no water to answer for")
    poles = frequency.modes(water)
    w, added, damping = sampled(water, poles)
    fit = vector_fit(w, added + damping / (1j * w), FIT_PAIRS)
    long_body = frequency.body_frequencies(water, MASS_KG, SPRINGS["long"].stiffness)[0]
    least = LEAST_MASS_SHARE * SPRINGS["long"].stiffness / long_body.frequency**2
    named = [m for m in poles if _is_light(m) and m.participating_mass > least]
    fitted = [m for m in fit.modes() if _is_light(m) and m.participating_mass > least]
    beside = [m for m in poles if any(_are_neighbours(m, n) for n in named)]
    body = {name: body_answer(water, beside, spring.stiffness) for name, spring in SPRINGS.items()}
    at_once = water.added_mass_at_once_kg
    return LevelAnswer(depth_m, w, added, damping, at_once, poles, named, beside, fit, fitted, body)


def _is_light(mode: Mode) -> bool:
    return mode.damping_ratio < LARGEST_DAMPING_RATIO and mode.participating_mass > 0.0


def _are_neighbours(mode: Mode, of: Mode) -> bool:
    """Equal cells move nearly as one: their modes lie close together and are as lightly damped."""
    near = abs(mode.frequency / of.frequency - 1.0) < NEIGHBOUR_BAND
    return near and mode.damping_ratio < 2.0 * of.damping_ratio


def truth(levels: list[LevelAnswer], everything: list[Trial]) -> dict[str, object]:
    """Contents of truth.json: the levels' answers, then every trial's own numbers."""
    table = {}
    for answer in levels:
        level = section.Level(answer.depth_m)
        lesser = [
            m for m in answer.poles if m.damping_ratio < LARGEST_DAMPING_RATIO and m not in answer.named
        ]
        table[f"{answer.depth_m:.2f}"] = {
            "hidden_resonators": [asdict(m) for m in answer.named],
            "hidden_resonators_all_neighbours_kg": sum(m.participating_mass for m in answer.beside),
            "hidden_resonators_by_rational_fit": [asdict(m) for m in answer.fitted],
            "rational_fit_worst_relative_error": answer.fit.worst_relative_error,
            "lesser_poles": [asdict(m) for m in lesser if abs(m.participating_mass) > 3.0],
            "added_mass_of_sudden_acceleration_kg": answer.at_once_kg,
            "by_spring": answer.body,
            "drag_coefficient": DRAG_COEFFICIENT,
            "area_m2": level.reference_area_m2,
            "drag_Ns2_per_m2": drag_factor(level),
            "normal_force_N": normal_force(level),
        }
    return {
        "campaign": "virtual flume",
        "kind": "linear potential flow of the whole section, open cells, radiated waves; nonlinear structure",
        "seed": SEED,
        "mode_units": {
            "frequency": "rad/s, body held",
            "damping_ratio": "-",
            "participating_mass": "kg, all cells",
        },
        "levels": rounded(table, 8),
        "trials": {t.file: rounded({k: v for k, v in asdict(t).items() if k != "file"}, 8) for t in everything},
    }
