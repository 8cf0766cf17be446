"""Effects hidden in simulated campaigns: the right name is said, and where nothing is hidden nothing is named."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from undertow.comparison import search, trying
from undertow.comparison.candidate import Candidate
from undertow.comparison.joint import fit_joint
from undertow.comparison.level import Member, make_level
from undertow.comparison.prescribed import plain_fit
from undertow.comparison.search import diagnose
from undertow.comparison.suspects import SUSPECTS, chosen
from undertow.conditioning.condition import condition
from undertow.discrepancy import judge as judging
from undertow.discrepancy.case import Case
from undertow.discrepancy.judge import judge
from undertow.discrepancy.validation import check_cell, closed_cell_frequency
from undertow.discrepancy.verdict import Described
from undertow.equation import registry
from undertow.equation.equation import Equation
from undertow.equation.simulate import simulate
from undertow.errors import ConfigError, IdentificationError
from undertow.likelihood import output_error
from undertow.likelihood.budget import spend
from undertow.likelihood.fit import Specimen, Structure
from undertow.likelihood.problem import TrialOptions
from undertow.methods.baseline import group_model, terms_by_name
from undertow.quantities import Estimate
from undertow.recording.recording import Recording

MASS, VOLUME, AREA = 2637.4, 0.25, 0.65
SCATTER = {"k": 0.003, "c": 0.06, "mu": 0.05}
SPRINGS = {"short": (403000.0, 820.0, 0.0065), "long": (109500.0, 590.0, 0.0073)}
EQ15 = ("stiffness", "viscous_damping", "coulomb_friction", "added_mass", "quadratic_drag")
SPECIMEN = Specimen(MASS, area_m2=AREA, submerged_volume_m3=VOLUME)
FEW = chosen(("linear_damping", "cubic_stiffness", "hidden_resonator", "relaxation", "coulomb_friction"))


def recording(spring: str, x0: float, seed: int, hidden=()) -> Recording:
    """One release of Eq. 15 with k, c, mu of this trial, what is hidden, and sensors with noise."""
    duration_s, rate_hz = 9.0, 250.0
    rng = np.random.default_rng(seed)
    k, c, mu = (v * (1 + SCATTER[s] * rng.standard_normal()) for s, v in zip(SCATTER, SPRINGS[spring], strict=True))
    numbers = (k, c, mu * SPECIMEN.normal_force_N, 300.0, 450.0)
    terms = tuple(registry.find(n) for n in EQ15) + tuple(term for term, _ in hidden)
    equation = Equation(terms, numbers + tuple(value for _, value in hidden), mass_kg=MASS)
    hold = 0.6 + rng.uniform(0, 0.01)
    time = np.arange(round((hold + duration_s) * rate_hz)) / rate_hz
    moving = time >= hold
    motion = simulate(equation, x0, time[moving] - hold + 1e-9)
    x, a = np.full(time.size, x0), np.zeros(time.size)
    x[moving], a[moving] = motion.x, motion.a
    x = x + 5e-5 * rng.standard_normal(time.size) + rng.uniform(-1e-4, 1e-4)
    a = a + 0.03 * rng.standard_normal(time.size) + rng.uniform(-0.02, 0.02)
    return Recording(f"{spring}{x0:g}", time, {"displacement": x, "acceleration": a})


def member(spring: str, releases, seed: int, hidden=()) -> Member:
    """One spring's trials with its structure as dry tests would give it."""
    k, c, mu = SPRINGS[spring]
    structure = Structure(
        Estimate(k, 0.002 * k), Estimate(c, 0.035 * c), Estimate(mu, 0.03 * mu), SCATTER, "test", math.inf
    )
    motions = tuple(condition(recording(spring, x0, seed + i, hidden)) for i, x0 in enumerate(releases))
    model = group_model(terms_by_name(EQ15), motions, SPECIMEN, structure, dry=False, anchored=True)
    return Member(spring, model, motions, TrialOptions(rest_offset_std=mu * SPECIMEN.normal_force_N / k), allowed=0.05)


SHORT, LONG = (0.008, 0.016, 0.03), (0.02, 0.05)


@pytest.mark.parametrize("seed", [100, 300])
def test_nothing_is_named_where_nothing_is_hidden(seed):
    level = make_level([member("short", SHORT, seed)])
    found = diagnose(level, FEW)
    assert found.best.names == ()
    assert not found.named


def test_linear_damping_is_named_alone_with_its_size():
    hidden = ((registry.find("linear_damping"), 500.0),)
    level = make_level([member("short", SHORT, 500, hidden), member("long", LONG, 520, hidden)])
    found = diagnose(level, FEW)
    assert found.best.names == ("linear_damping",)
    names = [n for n in found.best.fit.solution.problem.names if n.startswith("linear_damping.")]
    assert names
    for name in names:
        error = found.best.fit.solution.stderr(name)
        assert abs(found.best.fit.value(name) - 500.0) < 3.0 * error  # three standard errors, two draws at most


def test_hidden_resonator_is_named_with_frequency_and_mass():
    resonator = registry.find("hidden_resonator", natural_frequency_rad_per_s=9.6, damping_ratio=0.02)
    level = make_level([member("short", SHORT, 700, ((resonator, 150.0),))])
    found = diagnose(level, FEW)
    assert found.best.names[0] == "hidden_resonator"
    assert found.best.fit.value("hidden_resonator.natural_frequency_rad_per_s") == pytest.approx(9.6, rel=0.01)
    assert found.best.fit.value("hidden_resonator.mass_kg") == pytest.approx(150.0, rel=0.05)  # k's own 0.2 % is 3 %


@pytest.mark.parametrize("law", ["cubic_stiffness", "asymmetric_stiffness"])
def test_a_strong_law_of_one_release_is_found_whatever_makes_good_for_it(law):
    """From the numbers that the prescribed equation has without it, its fit ended a thousand times further off."""
    strong = 0.6 * 403000.0 / 0.04 ** (2 if law == "cubic_stiffness" else 1)
    motions = (condition(recording("short", 0.035, 7000, ((registry.find(law), strong),))),)
    terms = terms_by_name(("stiffness", "viscous_damping", "coulomb_friction"))
    model = group_model(terms, motions, SPECIMEN, None, dry=True, anchored=True)
    level = make_level([Member("short", model, motions, TrialOptions(rest_offset_std=1e-3), allowed=0.05)])
    found = diagnose(level, chosen((law, "linear_damping", "quintic_stiffness", "coulomb_friction")))
    assert found.best.names[0] == law
    assert found.best.fit.misfit < 5.0 < 1e-3 * found.null.fit.misfit
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(trying.Trying, "_anew", lambda self, tried: list(tried))
        assert diagnose(level, chosen((law,))).candidates[-1].fit.misfit > 1000.0


def test_an_added_mass_of_each_springs_own_is_no_missing_physics():
    short = member("short", SHORT, 900)
    heavy = ((registry.find("added_mass"), 400.0),)
    found = diagnose(make_level([short, member("long", LONG, 920, heavy)]), FEW)
    assert found.best.names == ()


def test_verdict_proves_on_trials_it_never_saw():
    resonator = registry.find("hidden_resonator", natural_frequency_rad_per_s=9.6, damping_ratio=0.02)
    hidden = ((resonator, 150.0),)
    group = member("short", SHORT, 1100, hidden)
    held = condition(recording("short", 0.022, 1150, hidden))
    cell = {"surface_width_m": 0.31, "depth_m": 0.14, "length_m": 17.0}
    baseline = Described(0.4, 0.4, {})
    case = Case({"spring": "short"}, "spring short", group, (held,), baseline, 0.004, 0.05, 4, False, True, cell)
    (verdict,) = judge([case], FEW)
    assert verdict.status == "explained"
    assert verdict.origin == "water"
    assert verdict.augmented is not None
    assert verdict.augmented.held_out_nrmse < 0.1  # repeatability of one trial, 0.05, twice
    assert verdict.physical_check.agrees
    assert "never saw" in verdict.sentence
    assert verdict.p_value <= 0.01
    assert math.isnan(verdict.upper_bound)  # what can hide beside the answer was not asked
    assert {d.name for d in verdict.detectable} >= {"cubic_stiffness", "linear_damping"}
    assert verdict.not_testable[:2] == ("rest_offset", "support_compliance")
    assert {r.name for r in verdict.rejected} >= {"cubic_stiffness", "linear_damping"}


def test_a_verdict_is_of_what_is_supported_with_errors_of_common_gains(monkeypatch):
    """Nothing that is outweighed is said, and a covariance nine times as large gives errors three times as large."""
    stiff = ((registry.find("cubic_stiffness"), 3.0e7),)
    group = member("short", SHORT, 1200, stiff)
    case = Case({"spring": "short"}, "spring short", group, (), Described(0.4), 0.004, 0.05, 4, False, True)

    def error() -> float:
        (verdict,) = judge([case], chosen(("cubic_stiffness",)))
        return verdict.parameters["cubic_stiffness"]["N_per_m3"].stderr

    plain = error()

    def with_covariance(factor: float) -> float:
        monkeypatch.setattr(
            judging, "with_common_gains",
            lambda fit: replace(fit, solution=replace(fit.solution, covariance=factor * fit.solution.covariance)),
        )  # fmt: skip
        return error()

    own = with_covariance(1.0)  # without what one gain of all trials adds
    assert 0.9 * plain < own < plain
    assert with_covariance(9.0) == pytest.approx(3.0 * own, rel=0.01)  # a scale's error beside it stays
    monkeypatch.setattr(judging, "supported", lambda found: replace(found, best=found.null, rivals=()))
    (verdict,) = judge([case], chosen(("cubic_stiffness",)))
    assert "cubic_stiffness" not in verdict.parameters


def test_closed_cell_is_the_lower_bound_of_its_slosh_mode():
    bound = closed_cell_frequency(0.31, 0.12)
    assert bound == pytest.approx(9.13, rel=1e-3)  # Lamb 1932, section 257
    assert check_cell(Estimate(9.4, 0.05), {"surface_width_m": 0.31, "depth_m": 0.12}).agrees is True
    assert check_cell(Estimate(7.0, 0.05), {"surface_width_m": 0.31, "depth_m": 0.12}).agrees is False
    assert check_cell(Estimate(9.4, 0.05), {}).agrees is None


def test_a_suspect_that_does_not_exist_is_refused():
    with pytest.raises(ConfigError, match=r"'gremlin' is none of added_mass"):
        chosen(("gremlin",))


def test_every_suspect_writes_into_slots_of_the_integrator():
    from undertow.equation.kernel import SLOT

    level = make_level([member("short", SHORT[:1], 1300)])
    for suspect in SUSPECTS:
        for start in suspect.starts(level.scales):
            for addition in suspect.additions(level.scales, start):
                assert addition.slot in SLOT
                assert addition.lower <= addition.start <= addition.upper


def test_a_level_without_trials_is_refused():
    group = member("short", SHORT[:1], 1400)
    empty = Member(group.label, group.model, (), group.options)
    with pytest.raises(IdentificationError, match=r"level of 1 groups has no trial"):
        make_level([empty])


def test_a_search_whose_budget_ends_decides_by_what_it_has_tried(monkeypatch):
    level = make_level([member("short", SHORT, 500, ((registry.find("linear_damping"), 2500.0),))])
    damping = [s for s in FEW if s.name == "linear_damping"]
    rest = [s for s in FEW if s.name != "linear_damping"]
    whole = diagnose(level, [*damping, *rest])
    assert whole.best.names == ("linear_damping",)
    assert whole.unfinished == ()
    monkeypatch.setattr(search.attempt, "LEVEL_BUDGET", 130.0)
    cut = diagnose(level, [*damping, *rest])
    assert cut.best.names == ("linear_damping",)
    assert "further effects" in cut.unfinished


def test_what_is_tried_on_top_may_stay_unfinished(monkeypatch):
    """Suspects without evidence of their own, beside an answer, come last; that they were too dear is no doubt."""
    level = make_level([member("short", SHORT, 500, ((registry.find("linear_damping"), 2500.0),))])
    order, tried = [], search._Search._within_budget

    def limited(self, suspect, small, depth, twin):
        order.append((depth, self._promising(suspect), self.asked_for))
        if depth and not self._promising(suspect):
            self._not_tried(suspect.label)
            return None
        return tried(self, suspect, small, depth, twin)

    monkeypatch.setattr(search._Search, "_within_budget", limited)
    monkeypatch.setattr("undertow.comparison.search.FAR_ABOVE_NOISE", 0.0)  # as if it left more than noise
    found = diagnose(level, chosen(("linear_damping", "quintic_stiffness", "hysteresis", "hidden_resonator")))
    assert found.unfinished == ()
    beside = [promising for depth, promising, _ in order if depth]
    assert {True, False} <= set(beside)
    assert all(asked == (promising or not depth) for depth, promising, asked in order)
    first_round = beside[: beside.index(False)]
    assert all(first_round)


def test_what_is_tried_on_top_spends_a_fourth_of_its_own_and_only_where_one_step_tells():
    level = make_level([member("short", SHORT, 500, ((registry.find("linear_damping"), 2500.0),))])
    (one,) = chosen(("cubic_stiffness",))
    state = search._Search(level, [one], Candidate((), plain_fit(level), 0.0), clean_when_dry=False)
    whole, on_top = state.left[True], state.left[False]
    assert on_top == pytest.approx(0.25 * whole)

    def dear(depth, suspects):
        spend(0.5 * on_top)
        yield from ()
        spend(whole)

    state._tried = dear
    assert state._spending(1, [one], False) == []
    assert (state.left, state.unfinished) == ({True: whole, False: 0.0}, [])
    assert state._spending(1, [one], True) == []
    assert (state.left, state.unfinished) == ({True: 0.0, False: 0.0}, ["further effects"])
    del state._tried
    state.error, state._within_budget = 10.0, lambda suspect, *_: suspect
    for asked_for, tried in ((True, [one]), (False, [])):
        state.asked_for = asked_for
        assert list(state._tried(1, [one])) == tried  # far off a linear step tells nothing


def test_a_step_that_is_known_to_be_worse_is_not_computed_to_its_end(monkeypatch):
    level = make_level([member("short", SHORT, 5000)])
    problem = fit_joint(level, (), 1.0, {}, 10.0, growing=False, quick=True).solution.problem
    at = np.array([u.start for u in problem.unknowns])
    whole = output_error._evaluate(problem, at)
    computed = []
    plain = output_error.residuals
    first = float(np.sum(plain(problem.trials[0], at)[0] ** 2))
    monkeypatch.setattr(output_error, "residuals", lambda *given: computed.append(given) or plain(*given))
    assert output_error._evaluate(problem, at, 0.5 * first) is None
    assert len(computed) == 1
    again = output_error._evaluate(problem, at, whole.cost)
    assert again.cost == whole.cost
    np.testing.assert_array_equal(again.gradient, whole.gradient)
