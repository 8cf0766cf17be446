"""A user's own Term, unknown to the compiled integrator: its motion, its derivatives, its fit."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import pytest

from tests.exact_motions import LONG, exact_motion
from undertow.conditioning.condition import condition
from undertow.equation import registry
from undertow.equation.equation import Equation, equation_15
from undertow.equation.general import general_trajectory, spring_force
from undertow.equation.hidden import Relaxation
from undertow.equation.kernel import N_SLOTS, SLOT
from undertow.equation.simulate import simulate
from undertow.equation.structure import CoulombFriction, CubicStiffness, Stiffness, ViscousDamping
from undertow.equation.term import Array, PlacedTerm, Term
from undertow.errors import IdentificationError
from undertow.likelihood import free_run as free_runs
from undertow.likelihood import output_error
from undertow.likelihood.fit import Specimen
from undertow.likelihood.free_run import free_run
from undertow.likelihood.problem import TrialOptions
from undertow.methods.baseline import fit_group, group_model, terms_by_name
from undertow.quantities import Parameter
from undertow.recording.recording import Recording


@dataclass(frozen=True)
class DeepDrag(Term):
    """|v|^1.7 sign(v) (1 + (x / 0.05)^2): drag that grows where the body leaves its rest."""

    exponent: float = 1.7

    name: ClassVar[str] = "deep_drag"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("strength", "N (s/m)^1.7", "q"), Parameter("exponent", "1", "p", 1.0, 3.0),
    )  # fmt: skip
    law: ClassVar[str] = "|v|^p sign(v) (1 + (x / 0.05)^2)"
    latex: ClassVar[str] = r"q|v|^p"
    source: ClassVar[str] = "made up for this test"
    left_out: ClassVar[str] = "too little damping far out"

    def force(self, x: Array, v: Array, a: Array, t: Array) -> Array:
        """Force per unit strength, (n,)."""
        return np.abs(v) ** self.exponent * np.sign(v) * (1.0 + (x / 0.05) ** 2)


EQ15 = (Stiffness(), ViscousDamping(), CoulombFriction())
PLACES = tuple(PlacedTerm(t, (SLOT[t.slots[t.coefficient.name]],)) for t in EQ15)
MASS, STRENGTH = 2637.4, 900.0


def own_laws():
    return (*PLACES, PlacedTerm(DeepDrag(), (N_SLOTS, N_SLOTS + 1)))


def own_theta(strength=STRENGTH, exponent=1.7):
    theta = equation_15(MASS, 0.0, 300.0, 109_600.0, 180.0, 0.0).theta(0.08)
    return np.concatenate([theta, [strength, exponent]])


def test_the_general_path_moves_and_sticks_as_the_compiled_one_does():
    theta = equation_15(MASS, 0.0, 590.0, 109_600.0, 700.0, 0.0).theta(0.06)
    times = np.linspace(0.0, 9.0, 300)
    active = np.array([SLOT[name] for name in ("mass", "k1", "c1", "fc", "x0", "xe")], dtype=np.int64)
    general = general_trajectory(theta, PLACES, active, times)
    compiled = output_error.trajectory(theta, active, times)
    assert np.all(general[1][-20:, 0] == 0.0)  # at rest
    for ours, theirs in zip(general, compiled, strict=True):
        size = np.max(np.abs(theirs), axis=0)
        assert np.max(np.abs(ours - theirs) / size) < 2e-4  # differences of the laws; 1e-7 for the motion itself
    assert np.max(np.abs(general[0][:, 0] - compiled[0][:, 0])) < 1e-7 * 0.06 * 5.0  # both are right to 1e-7 of x0


def test_a_rest_lies_within_what_friction_holds_against_the_spring_or_a_pendulums_sine(monkeypatch):
    seen = []
    monkeypatch.setattr(free_runs, "free_run", lambda motion, theta, width, **_: seen.append(width))
    motion = exact_motion(LONG, 0.06, rate_hz=60.0, duration_s=4.0)
    for spring in ("stiffness", "sine_restoring"):
        law = Equation((registry.find(spring), CoulombFriction()), (400.0, 4.0), mass_kg=4.0)
        free_runs.equation_runs(law, [motion])
    free_runs.equation_runs(Equation((ViscousDamping(),), (1.0,)), [motion])
    own = motion.equilibrium.total_stderr
    assert seen == pytest.approx([np.hypot(0.01, own), np.hypot(0.01, own), own])


def test_a_free_run_is_adjusted_on_the_general_path_as_on_the_compiled_one():
    motion = exact_motion(LONG, 0.06, rate_hz=60.0, duration_s=4.0)
    motion = replace(motion, noise={"displacement": 1e-4})
    theta = equation_15(LONG.inertia_kg, 0.0, 700.0, LONG.k_N_per_m, 400.0, 0.0).theta(0.06)  # not the body's own
    general, compiled = (free_run(motion, theta, 1e-3, laws=laws) for laws in (PLACES, ()))
    assert compiled.nrmse > 0.01
    assert general.nrmse == pytest.approx(compiled.nrmse, rel=1e-4)
    assert general.nuisance.shape == compiled.nuisance.shape
    assert general.theta.size == theta.size
    adjusted = compiled.theta[SLOT["x0"]]
    assert general.simulated[0] == pytest.approx(compiled.simulated[0], abs=1e-4 * abs(adjusted))
    assert adjusted != pytest.approx(theta[SLOT["x0"]], rel=1e-4)


def test_derivatives_of_an_own_law_are_those_of_its_motion():
    times = np.linspace(0.0, 2.0, 60)
    active = np.array([N_SLOTS, N_SLOTS + 1], dtype=np.int64)
    x, _, a = general_trajectory(own_theta(), own_laws(), active, times)
    none = np.zeros(0, dtype=np.int64)
    for column, changes in ((1, {"strength": STRENGTH * 1e-4}), (2, {"exponent": 1e-4})):
        step = next(iter(changes.values()))
        value = {"strength": STRENGTH, "exponent": 1.7}
        ends = []
        for sign in (1.0, -1.0):
            moved = value | {name: value[name] + sign * step for name in changes}
            ends.append(general_trajectory(own_theta(**moved), own_laws(), none, times))
        for index, found in ((0, x), (2, a)):
            slope = (ends[0][index][:, 0] - ends[1][index][:, 0]) / (2.0 * step)
            size = np.max(np.abs(slope))
            assert np.quantile(np.abs(found[:, column] - slope), 0.95) < 1e-2 * size  # a jumps where v turns


def recorded(x0: float, seed: int) -> Recording:
    rng = np.random.default_rng(seed)
    equation = Equation((*EQ15, DeepDrag()), (109_600.0, 300.0, 180.0, STRENGTH), mass_kg=MASS)
    time = np.arange(0.0, 5.5, 0.01)
    free = time > 0.5
    motion = simulate(equation, x0, time[free] - 0.5)
    x, a = np.full(time.size, x0), np.zeros(time.size)
    x[free], a[free] = motion.x, motion.a
    noisy = {
        "displacement": x + 5e-5 * rng.standard_normal(time.size),
        "acceleration": a + 0.02 * rng.standard_normal(time.size),
        "spring_force": 1.002 * 109_600.0 * x + 4.0 * rng.standard_normal(time.size),
    }
    return Recording(f"own-{x0:g}", time, noisy)


def test_an_own_law_is_fitted_beside_the_known_ones():
    motions = [condition(recorded(0.08, 1), end_s=3.5)]
    model = group_model((*EQ15, DeepDrag()), motions, Specimen(MASS), None, dry=True, anchored=True)
    fit = fit_group(model, motions, TrialOptions())
    assert fit.outcome == "ok"
    for name, truth in (("deep_drag_strength", STRENGTH), ("deep_drag_exponent", 1.7), ("k_N_per_m", 109_600.0)):
        estimate = fit.estimates[name]
        assert abs(estimate.value - truth) < 4.0 * estimate.stderr, (name, estimate)
        assert estimate.stderr < 0.2 * truth
    again = simulate(fit.equation(), 0.08, np.linspace(0.0, 5.0, 200))
    truth = simulate(Equation((*EQ15, DeepDrag()), (109_600.0, 300.0, 180.0, STRENGTH), mass_kg=MASS), 0.08, again.t)
    assert np.sqrt(np.mean((again.x - truth.x) ** 2)) < 1e-4  # m: two noise levels


def test_an_own_law_beside_a_hidden_state_is_refused():
    laws = (*own_laws(), PlacedTerm(Relaxation(), (SLOT["rk1"], SLOT["rt1"])))
    with pytest.raises(IdentificationError, match="relaxation beside a law without compiled slots"):
        general_trajectory(own_theta(), laws, np.zeros(0, dtype=np.int64), np.linspace(0.0, 1.0, 5))


def test_a_law_whose_places_the_general_path_does_not_have_is_refused():
    motions = [condition(recorded(0.08, 1))]
    terms = (*EQ15, *terms_by_name(("external_forcing",)), DeepDrag())
    with pytest.raises(IdentificationError, match="external_forcing beside deep_drag, a law without compiled slots"):
        group_model(terms, motions, Specimen(MASS), None, dry=True, anchored=True)


def test_a_mass_that_is_not_positive_has_no_trajectory():
    theta = own_theta()
    theta[SLOT["mass"]] = -1.0
    with pytest.raises(IdentificationError, match=r"a trajectory needs a positive total mass .* got -1 kg"):
        general_trajectory(theta, own_laws(), np.zeros(0, dtype=np.int64), np.linspace(0.0, 1.0, 5))


def test_a_force_that_feeds_the_motion_leaves_every_bound():
    with np.errstate(over="ignore", invalid="ignore"), pytest.raises(IdentificationError, match="the motion"):
        general_trajectory(own_theta(-1e6), own_laws(), np.zeros(0, dtype=np.int64), np.linspace(0.0, 20.0, 5))


def test_spring_force_and_its_derivatives_follow_the_springs_law():
    theta = Equation((Stiffness(), CubicStiffness()), (1000.0, 5e4), mass_kg=1.0, rest_m=0.01).theta(0.1)
    x = np.array([[0.05, 1.0, 0.0], [-0.02, 0.5, 0.0]])
    slots = np.array([SLOT["k1"], SLOT["k3"]])
    force, rate = spring_force(theta, slots, x, np.array([2.0, -1.0]))
    here = x[:, 0] - 0.01
    slope = 1000.0 + 1.5e5 * here**2
    assert force[:, 0] == pytest.approx(1000.0 * here + 5e4 * here**3)
    assert force[:, 1] == pytest.approx(slope * x[:, 1] + here)
    assert force[:, 2] == pytest.approx(here**3)
    assert rate == pytest.approx(slope * np.array([2.0, -1.0]))


def test_load_cells_are_a_channel_with_a_gain_and_a_clock_of_their_own():
    motions = [condition(recorded(x0, seed)) for seed, x0 in enumerate((0.04, 0.08))]
    known = Specimen(MASS)
    terms = (*EQ15, *terms_by_name(("quadratic_drag",)))
    model = group_model(terms[:3], motions, known, None, dry=True, anchored=True)
    channels = ("displacement", "acceleration", "spring_force")
    fit = fit_group(model, motions, TrialOptions(channels=channels))
    names = fit.solution.problem.names
    assert names.count("spring_force_gain") == 1
    assert "spring_force_shift_s" in names
    assert fit.solution.value("spring_force_gain") == pytest.approx(0.002, abs=1e-3)
    assert abs(fit.solution.value("spring_force_shift_s")) < 5e-4
    assert len(fit.solution.problem.trials[0].channels) == 3
