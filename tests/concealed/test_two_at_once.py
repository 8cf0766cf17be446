"""Two laws that mask each other: one step in both shows them, and the search names them together."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import combinations
from types import SimpleNamespace

import numpy as np
import pytest

import undertow
from tests.concealed.test_diagnosis import member
from tests.concealed.test_small_effects import found, stands
from undertow.comparison import search
from undertow.comparison.candidate import LevelDiagnosis
from undertow.comparison.level import Level, make_level
from undertow.comparison.score_test import Stands, places
from undertow.comparison.search import diagnose
from undertow.comparison.suspects import chosen
from undertow.comparison.two_effects import best_pairs
from undertow.equation import registry
from undertow.equation.equation import Equation

LOOKED_FOR = ("linear_damping", "cubic_stiffness", "quintic_stiffness", "hysteresis", "relaxation")
HARD, JOINT, YIELD = 5e7, 33e3, 0.011
"""A spring that hardens (N/m^3) beside a joint that yields (N/m, m): together the period hardly goes with amplitude."""


def masked() -> Level:
    """Three releases of both, in a campaign that repeats so badly that the free run hides them."""
    hidden = (
        (registry.find("cubic_stiffness"), HARD),
        (registry.find("hysteresis", yield_displacement_m=YIELD), JOINT),
    )
    return make_level([replace(member("short", (0.014, 0.02, 0.03), 6100, hidden), allowed=0.3)])


@cache
def searched() -> LevelDiagnosis:
    return diagnose(masked(), chosen(LOOKED_FOR))


def test_two_laws_that_mask_each_other_are_named_together_with_their_numbers():
    said = searched()
    assert sorted(said.best.names) == ["cubic_stiffness", "hysteresis"]
    assert said.best.fit.misfit < 1.1
    for name, truth in (
        ("cubic_stiffness.N_per_m3@short", HARD),
        ("hysteresis.stiffness_N_per_m", JOINT),
        ("hysteresis.yield_force_N", JOINT * YIELD),
    ):
        error = said.best.fit.solution.stderr(name)
        assert abs(said.best.fit.value(name) - truth) < 3.0 * error
        assert error < 0.1 * truth


def test_neither_of_them_alone_leaves_noise_and_the_free_run_asks_for_no_more():
    said = searched()
    alone = [c for c in said.candidates if len(c.suspects) == 1]
    assert {"linear_damping", "relaxation"} <= {c.names[0] for c in alone}
    assert min(c.fit.misfit for c in alone) > 3.0
    most = max(c.score for c in alone)
    assert said.best.score > most + 50.0


def test_one_law_is_not_named_twice_over_where_it_leaves_noise():
    hidden = ((registry.find("cubic_stiffness"), HARD),)
    level = make_level([replace(member("short", (0.014, 0.02, 0.03), 6200, hidden), allowed=0.3)])
    assert diagnose(level, chosen(LOOKED_FOR)).best.names == ("cubic_stiffness",)


def test_the_gain_of_a_pair_is_that_of_one_step_in_all_its_coefficients():
    level = masked()
    fit = stands(level)
    at = Stands.of(fit)
    first, second = (found(n) for n in ("cubic_stiffness", "quintic_stiffness"))
    seen = [p for s in (first, second) for p in places(level, at, s)]
    (look,) = best_pairs(level, at, seen, 5)
    assert look.labels == ("cubic_stiffness", "quintic_stiffness")
    solution = fit.solution
    rows = [
        np.hstack([a[0], b[0]]) for a, b in zip(seen[0].columns, seen[1].columns, strict=True)
    ]  # fmt: skip
    precision = solution.problem.believed[1]
    normal = np.diag(precision).astype(float)
    slope = precision * (solution.values - np.array([u.start for u in solution.problem.unknowns]))
    n = normal.shape[0]
    whole = np.zeros((n + 2, n + 2))
    whole[:n, :n] = normal
    gradient = np.concatenate([slope, np.zeros(2)])
    for jac, mine, used, r in zip(solution.jacobians, rows, solution.used, solution.residuals, strict=True):
        both, where = np.hstack([jac, mine]), np.concatenate([used, [n, n + 1]])
        whole[np.ix_(where, where)] += both.T @ both
        gradient[where] += both.T @ r
    standing = 0.5 * float(gradient[:n] @ np.linalg.solve(whole[:n, :n], gradient[:n]))
    gain = 0.5 * float(gradient @ np.linalg.solve(whole, gradient)) - standing
    assert look.gain == pytest.approx(gain, rel=1e-3)
    assert look.alone == pytest.approx(max(p.gain for p in seen))


def test_a_step_against_a_sign_is_no_pair_and_one_suspect_makes_none():
    level = masked()
    at = Stands.of(stands(level))
    only = places(level, at, found("cubic_stiffness"))
    assert best_pairs(level, at, only, 5) == []
    seen = [*only, *places(level, at, found("hidden_resonator"))]
    for look in best_pairs(level, at, seen, 5):
        assert all(a.start >= 0.0 for a in look.additions[1] if a.name == "mass_kg")


def test_two_forms_of_one_name_are_no_pair_but_of_what_swings(monkeypatch):
    tried = []
    monkeypatch.setattr(search, "from_pair", lambda *given: tried.append([s.name for s in given[3]]) or [])
    level = make_level([member("short", (0.014, 0.02, 0.03), 6100), member("long", (0.02, 0.03), 6200)])
    suspects = [s for s in chosen(("linear_damping", "hidden_resonator")) if s.variant != "amplitude-dependent"]
    suspects.append(replace(suspects[-1], variant="another"))

    def seen(level: Level, stands: Stands, found: object, count: int) -> list[SimpleNamespace]:
        names = [s.label for s in suspects]
        return [SimpleNamespace(labels=pair, gain=1e3, alone=0.0, additions=()) for pair in combinations(names, 2)]

    monkeypatch.setattr(search, "best_pairs", seen)
    diagnose(level, suspects)
    assert ["linear_damping", "linear_damping"] not in tried
    assert ["linear_damping", "hidden_resonator"] in tried
    assert ["hidden_resonator", "hidden_resonator"] in tried


def test_a_second_law_is_looked_for_where_the_first_leaves_more_than_noise_though_repetitions_differ_by_more():
    resonator = registry.find("hidden_resonator", natural_frequency_rad_per_s=8.4, damping_ratio=0.02)
    hidden = ((resonator, 150.0), (registry.find("linear_damping"), 2500.0))
    level = make_level([replace(member("short", (0.01, 0.02, 0.03), 6300, hidden), allowed=0.9)])
    said = diagnose(level, chosen(("linear_damping", "hidden_resonator", "relaxation")))
    assert sorted(said.best.names) == ["hidden_resonator", "linear_damping"]
    assert said.best.fit.misfit < 1.2


def test_a_dashpot_that_hides_beside_water_near_the_bodys_rate_is_named_and_drag_is_right(monkeypatch):
    """A resonator alone is as close as repetitions are and leaves hardly more than noise; the structure's own dashpot
    then stands seven errors above what dry trials say of it."""
    resonator = registry.find("hidden_resonator", natural_frequency_rad_per_s=11.0, damping_ratio=0.01)
    hidden = ((resonator, 60.0), (registry.find("linear_damping"), 300.0))
    level = make_level([replace(member("short", (0.02, 0.03, 0.04), 6300, hidden), allowed=0.08)])
    suspects = chosen(("linear_damping", "hidden_resonator", "external_forcing", "cubic_damping", "relaxation"))
    said = diagnose(level, suspects).best
    assert said.names == ("hidden_resonator", "linear_damping")
    for name, truth in (("linear_damping.c_Ns_per_m", 300.0), ("drag_coefficient", 1.5)):
        assert abs(said.fit.value(name) - truth) < 3.0 * said.fit.solution.stderr(name)
    monkeypatch.setattr(search, "hides", lambda *_: False)
    alone = diagnose(level, suspects).best
    assert alone.names == ("hidden_resonator",)
    assert alone.fit.misfit < 1.5
    assert alone.fit.value("c_mean@short") > 5.0 * alone.fit.solution.stderr("c_mean@short")


def test_what_has_no_evidence_alone_is_tried_beside_an_answer_that_is_near():
    """Alone the cubic spring is worth nothing; beside the water it takes the rest (had been a description)."""
    resonator = registry.find("hidden_resonator", natural_frequency_rad_per_s=8.4, damping_ratio=0.01)
    hidden = ((resonator, 150.0), (registry.find("cubic_stiffness"), 5e6))
    level = make_level([replace(member("short", (0.02, 0.03, 0.04), 6300, hidden), allowed=0.3)])
    names = ("linear_damping", "hidden_resonator", "cubic_stiffness", "stribeck_friction", "relaxation")
    said = diagnose(level, chosen(names))
    assert diagnose(level, chosen(("cubic_stiffness",))).best.names == ()
    assert said.best.names == ("hidden_resonator", "cubic_stiffness")
    assert said.best.fit.misfit < 1.1
    value, error = (at("cubic_stiffness.N_per_m3@short") for at in (said.best.fit.value, said.best.fit.solution.stderr))
    assert abs(value - 5e6) < 3.0 * error < 1e6


def test_a_spring_whose_square_and_cube_keep_the_period_is_named_by_both() -> None:
    """As an air spring's: the square softens and the cube hardens it, so that the cube alone shows nothing, and a loop
    that never yields takes the square's place first, leaves nine times the noise and lies within what repeats."""
    rng, runs = np.random.default_rng(3), []
    names = ("stiffness", "viscous_damping", "asymmetric_stiffness", "cubic_stiffness")
    for at, x0 in enumerate((0.02, 0.03, 0.04, 0.05, 0.06)):
        numbers = (42e3 * (1.0 + 0.003 * rng.standard_normal()), 130.0 * (1.0 + 0.02 * rng.standard_normal()))
        air = Equation(tuple(map(registry.find, names)), (*numbers, -3.1e5, 2.2e6), mass_kg=300.0)
        run = undertow.simulate(air, x0=x0, rate_hz=60.0, duration_s=8.0)
        runs.append(run.recorded(noise_m=5e-5, seed=at, name=f"r{at}"))
    said = undertow.diagnose(undertow.read(runs), list(names[:2]), mass_kg=300.0)
    (group,) = said.groups
    assert set(group.verdict.verdict) == {"asymmetric_stiffness", "cubic_stiffness"}
    numbers = group.verdict.parameters
    assert numbers["cubic_stiffness"]["N_per_m3"].value == pytest.approx(2.2e6, rel=0.1)
    assert numbers["asymmetric_stiffness"]["N_per_m2"].value == pytest.approx(-3.1e5, rel=0.05)
    damping = group.estimates["c_Ns_per_m"]  # 130 +- 13 as trials without the square would differ
    assert abs(damping.value - 130.0) < damping.total_stderr < 8.0
