"""Energy a cycle: what laws take along a motion adds up to what it loses; what is left out stands as not explained."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.findings_fixture import small_findings
from undertow.conditioning.motion import Motion, Window
from undertow.discrepancy.energy import EnergyBudget, energy_budget
from undertow.equation import registry
from undertow.equation.equation import Equation
from undertow.equation.simulate import simulate
from undertow.quantities import Estimate
from undertow.recording.recording import Recording

MASS_KG, K_N_PER_M, X0_M = 2637.4, 4.0e5, 0.03
BARE = (("stiffness", K_N_PER_M), ("viscous_damping", 600.0), ("coulomb_friction", 100.0), ("quadratic_drag", 3000.0))


def equation(*pairs: tuple[str, float], **inner: float) -> Equation:
    terms = [registry.find(name, **(inner if name == "hidden_resonator" else {})) for name, _ in pairs]
    return Equation(tuple(terms), tuple(value for _, value in pairs), MASS_KG)


@cache
def moved(true: tuple[tuple[str, float], ...]) -> Motion:
    """An exact motion of 4 s at 500 Hz, its errors a hundredth of a millimetre."""
    t = np.arange(0.0, 4.0, 0.002)
    inner = {"natural_frequency_rad_per_s": 9.0, "damping_ratio": 0.03} if "hidden_resonator" in dict(true) else {}
    run = simulate(equation(*true, **inner), X0_M, t)
    std = np.full(t.size, 1e-5)
    recording = Recording("r", t, {"displacement": run.x})
    return Motion(
        recording, Window(0.0, 0.0, 4.0, held=True), t, run.x, run.v, run.a, std, std, std, t >= 0.0,
        Estimate(0.0, 0.0, 0.0, "m"), X0_M, {"displacement": 1e-5},
    )  # fmt: skip


def budget(true: tuple[tuple[str, float], ...], believed: Equation) -> EnergyBudget:
    found = energy_budget(moved(true), believed)
    assert found is not None
    return found


def test_what_three_laws_take_is_what_the_springs_lose() -> None:
    found = budget(BARE, equation(*BARE))
    assert set(found.taken) == {"viscous_damping", "coulomb_friction", "quadratic_drag"}
    assert np.max(np.abs(found.unexplained)) < 0.002 * found.stored[0]  # the trapezium at 240 samples a swing
    x1 = math.sqrt(2.0 * found.stored[0] / K_N_PER_M)
    x2 = math.sqrt(2.0 * (found.stored[0] - found.lost[0]) / K_N_PER_M)
    assert found.taken["coulomb_friction"][0] == pytest.approx(100.0 * 2.0 * (x1 + x2), rel=0.01)  # F times the path


def test_a_law_that_the_equation_leaves_out_stands_as_not_explained() -> None:
    found = budget(BARE, equation(*BARE[:3]))
    whole = budget(BARE, equation(*BARE))
    assert found.share("unexplained") == pytest.approx(whole.share("quadratic_drag"), abs=0.01)
    assert found.share("unexplained") > 0.05


def test_a_hidden_resonator_takes_energy_and_gives_some_of_it_back() -> None:
    true = (*BARE, ("hidden_resonator", 300.0))
    inner = {"natural_frequency_rad_per_s": 9.0, "damping_ratio": 0.03}
    found = budget(true, equation(*true, **inner))
    assert np.min(found.taken["hidden_resonator"]) < 0.0 < np.max(found.taken["hidden_resonator"])
    assert np.max(np.abs(found.unexplained)) < 0.01 * found.stored[0]


def test_a_hardening_spring_stores_energy_and_takes_none() -> None:
    true = (*BARE, ("cubic_stiffness", 5.0e7))
    found = budget(true, equation(*true))
    assert "cubic_stiffness" not in found.taken
    position = np.max(np.abs(moved(true).x[1:400]))
    assert found.stored[0] < 0.5 * K_N_PER_M * position**2 + 0.25 * 5.0e7 * position**4
    assert found.stored[0] > 0.5 * K_N_PER_M * found_turn(true) ** 2 * 1.01


def found_turn(true: tuple[tuple[str, float], ...]) -> float:
    """Size of the first turning point after the release, m."""
    motion = moved(true)
    return float(np.abs(motion.x[np.flatnonzero(motion.v[1:-1] * motion.v[2:] < 0.0)[0] + 1]))


@pytest.mark.parametrize("what", ["velocity alone", "two swings"])
def test_without_displacement_or_clear_cycles_there_is_no_budget(what: str) -> None:
    motion = moved(BARE)
    if what == "velocity alone":
        motion = replace(motion, recording=Recording("r", motion.t, {"velocity": motion.v}))
    else:
        motion = replace(motion, inside=motion.t < 1.0)
    assert energy_budget(motion, equation(*BARE)) is None


def test_a_dry_group_of_the_small_campaign_has_a_closed_budget() -> None:
    group = small_findings().groups[0]
    found = energy_budget(group.trials[3].motion, group.equation)
    assert found is not None
    assert abs(found.share("unexplained")) < 0.05
