"""A hook that lets go slowly, in whole campaigns: its time comes back, alone and beside another effect."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.concealed.test_diagnosis import EQ15, MASS, SCATTER, SPECIMEN, SPRINGS
from tests.unit.test_earned import case
from undertow.campaign.run.rig import standing_addends
from undertow.comparison import after_release, search, trying
from undertow.comparison import null_test as null_module
from undertow.comparison.after_release import shows_later
from undertow.comparison.bad_release import BAD_RELEASES
from undertow.comparison.candidate import Candidate, LevelDiagnosis
from undertow.comparison.joining import has_room
from undertow.comparison.joint import build, fit_joint, its_own, shared_theta
from undertow.comparison.level import Addend, Level, Member, make_level
from undertow.comparison.null_test import null_test
from undertow.comparison.prescribed import plain_fit
from undertow.comparison.search import diagnose
from undertow.comparison.suspect import Addition
from undertow.comparison.suspects import SUSPECTS, chosen
from undertow.conditioning.condition import condition
from undertow.conditioning.period import dominant_period
from undertow.discrepancy.sentence import sentence_of
from undertow.discrepancy.validation import addition_parameters, shared_run
from undertow.equation import registry
from undertow.equation.equation import Equation
from undertow.equation.kernel import SLOT, integrate
from undertow.likelihood import output_error
from undertow.likelihood.fit import Structure
from undertow.likelihood.free_run import free_run
from undertow.likelihood.priors import LATE_RELEASE_RADIANS, clock_std
from undertow.likelihood.problem import TrialOptions
from undertow.methods.baseline import group_model, terms_by_name
from undertow.quantities import Estimate
from undertow.recording.recording import Recording

_, HOOK, LATE = BAD_RELEASES
PERIOD = 2.0 * math.pi * math.sqrt((MASS + 300.0) / SPRINGS["long"][0])


def recording(
    x0: float, seed: int, share: float, hidden=(), power: float = 0.0, noise: float = 1.0, slots=()
) -> Recording:
    """One release whose hook lets go over that share of a period, with so much of the sensors' noise; ``slots`` are
    further places of the integrator, with their values."""
    rng = np.random.default_rng(seed)
    k, c, mu = (v * (1 + SCATTER[s] * rng.standard_normal()) for s, v in zip(SCATTER, SPRINGS["long"], strict=True))
    numbers = (k, c, mu * SPECIMEN.normal_force_N, 300.0, 450.0)
    terms = tuple(registry.find(n) for n in EQ15) + tuple(term for term, _ in hidden)
    theta = Equation(terms, numbers + tuple(value for _, value in hidden), mass_kg=MASS).theta(x0, 0.0)
    theta[SLOT["let_go"]], theta[SLOT["let_go_p"]] = share * PERIOD, power
    for slot, value in dict(slots).items():
        theta[SLOT[slot]] = value
    hold = 0.6 + rng.uniform(0, 0.01)
    time = np.arange(round(12.0 * 200.0)) / 200.0
    moving = time >= hold
    moved = integrate(theta, np.zeros(0, dtype=np.int64), time[moving] - hold + 1e-9, PERIOD / 200.0)
    x, a = np.full(time.size, x0), np.zeros(time.size)
    x[moving], a[moving] = moved[0][:, 0], moved[2][:, 0]
    x, a = x + 5e-5 * noise * rng.standard_normal(time.size), a + 0.03 * noise * rng.standard_normal(time.size)
    return Recording(f"long{x0:g}", time, {"displacement": x, "acceleration": a})


def hooked(share: float, hidden=(), releases=(0.02, 0.035, 0.05), **how) -> Level:
    return level_of([recording(x0, 40 + i, share, hidden, **how) for i, x0 in enumerate(releases)])


def level_of(recordings, rubbing: float = 1.0) -> Level:
    motions = tuple(map(condition, recordings))
    k, c, mu = np.array(SPRINGS["long"]) * (1.0, 1.0, rubbing)
    structure = Structure(
        Estimate(k, 0.002 * k), Estimate(c, 0.035 * c), Estimate(mu, 0.03 * mu), SCATTER, "test", math.inf
    )
    model = group_model(terms_by_name(EQ15), motions, SPECIMEN, structure, dry=False, anchored=True)
    options = TrialOptions(rest_offset_std=mu * SPECIMEN.normal_force_N / k)
    return make_level([Member("long", model, motions, options, allowed=0.05)])


def fitted(level: Level, start: float = 0.1):
    plain = fit_joint(level, (), 1.0, {}, 2.0, growing=True)
    addend = Addend("imperfect_release", HOOK.additions(level.scales, start * PERIOD))
    return plain, fit_joint(level, (addend,), 1.0, plain.values, plain.misfit, growing=True)


@pytest.fixture(scope="module")
def slow() -> Level:
    return hooked(0.3)


@pytest.mark.parametrize("start", [0.03, 0.1, 0.3])
def test_the_time_of_every_trial_comes_back_wherever_the_fit_begins(slow, start):
    plain, fit = fitted(slow, start)
    times = [(n, v) for n, v in fit.values.items() if n.startswith("imperfect_release.release_time_s[")]
    assert len(times) == 3
    for name, value in times:
        assert value == pytest.approx(0.3 * PERIOD, abs=4.0 * fit.solution.stderr(name))
        assert fit.solution.stderr(name) < 0.01 * PERIOD
    assert fit.misfit < 1.1 < 50.0 < plain.misfit


def test_a_hook_that_let_go_at_once_is_not_worth_its_numbers():
    plain, fit = fitted(hooked(0.0))
    late = 2.0 * math.log(20.0)  # of every trial the release may have been seen as much later than a clock errs
    own = math.log(fit.solution.n_data)
    assert fit.criterion - plain.criterion == pytest.approx(3.0 * (late + own), abs=8.0)


def test_it_is_named_and_said_with_its_time(slow):
    found = diagnose(slow, chosen(("linear_damping", "relaxation", "hidden_resonator", "imperfect_release")))
    assert found.best.names == ("imperfect_release",)
    assert found.best.suspects == (HOOK,)
    said = addition_parameters(found.best.fit, "long", 5.0)["imperfect_release"]
    assert said[0]["release_time_s"].value == pytest.approx(0.3 * PERIOD, rel=0.02)


@pytest.mark.parametrize("law", [("cubic_stiffness", 6e6), ("cubic_damping", 4e4)])
def test_it_hides_no_other_effect_of_the_body_or_its_water(law):
    name, size = law
    level = hooked(0.25, ((registry.find(name), size),))
    found = diagnose(level, chosen(("linear_damping", "cubic_stiffness", "cubic_damping", "imperfect_release")))
    assert set(found.best.names) == {"imperfect_release", name}
    assert found.best.fit.misfit < 1.2


def test_an_unseen_trial_has_a_time_of_its_own_and_one_that_was_not_held_has_none(slow):
    _, fit = fitted(slow)
    (own,) = its_own(fit).values()
    assert own.typical == pytest.approx(0.3 * PERIOD, rel=0.02)
    (member,) = slow.members
    unseen = condition(recording(0.042, 77, 0.22))  # by another hand
    theta = shared_theta(slow, member, fit, unseen.name)
    assert theta[SLOT["let_go"]] == 0.0
    run = shared_run(slow, member, fit, unseen, 1e-4)
    assert 0.15 * PERIOD < run.theta[SLOT["let_go"]] < 0.4 * PERIOD  # beside a k that is not quite this trial's
    assert run.nrmse < 0.95 * free_run(unseen, theta, 1e-4).nrmse
    seen = shared_run(slow, member, fit, member.motions[0], 1e-4)  # as fitted: not on top of what it has
    assert 0.2 * PERIOD < seen.theta[SLOT["let_go"]] < 0.4 * PERIOD
    swinging = replace(unseen, window=replace(unseen.window, held=False))
    assert shared_run(slow, member, fit, swinging, 1e-4).theta[SLOT["let_go"]] == 0.0


def test_only_trials_that_were_held_have_a_hook(slow):
    (member,) = slow.members
    first, *rest = member.motions
    swinging = replace(first, window=replace(first.window, held=False))
    mixed = make_level([replace(member, motions=(swinging, *rest))])
    addend = (Addend("imperfect_release", HOOK.additions(slow.scales, 0.1)),)
    names = build(mixed, addend).names
    assert sum("release_time_s" in name for name in names) == 2
    assert not any(name.endswith(f"release_time_s[{first.name}]") for name in names)
    none = make_level([replace(member, motions=tuple(replace(m, window=swinging.window) for m in member.motions))])
    plain = fit_joint(slow, (), 1.0, {}, 2.0, growing=True)
    assert [has_room(one, HOOK, plain) for one in (slow, mixed, none)] == [True, True, False]


def test_a_release_seen_late_may_be_as_late_as_where_an_equation_is_searched(slow):
    def prior(addends):
        return next(u.prior_std for u in build(slow, addends).unknowns if u.name.startswith("shift_s["))

    (member,) = slow.members
    seen, period = member.motions[0].window.release_stderr_s, dominant_period(member.motions[0])
    wide = prior((Addend("imperfect_release", HOOK.additions(slow.scales, 0.1)),))
    assert wide == pytest.approx(math.hypot(seen, LATE_RELEASE_RADIANS * period / (2.0 * math.pi)))
    assert prior(()) == pytest.approx(math.hypot(seen, clock_std(period)))


def test_it_is_of_the_release_has_no_step_and_no_clock_of_its_own():
    assert HOOK.of_the_release
    assert not HOOK.has_its_own_clock
    assert not HOOK.of_the_body
    assert {s.label for s in SUSPECTS if s.at_the_beginning} == {HOOK.label, LATE.label}


def test_a_sentence_says_how_long_it_took():
    numbers = {"imperfect_release": [{"release_time_s": Estimate(0.312, 0.004, unit="s")}]}
    sentence = sentence_of(case(), ("imperfect_release",), [], numbers, 0.01, math.nan, False, ())
    assert "it took 0.312 ± 0.004 s" in sentence


@pytest.mark.parametrize("power", [1.6, 2.5])
def test_how_it_lets_go_comes_back_where_an_even_hook_leaves_more_than_noise(power):
    level = hooked(0.4, power=power, noise=0.2)
    found = diagnose(level, chosen(("linear_damping", "cubic_stiffness", "relaxation", "imperfect_release")))
    assert found.best.names == ("imperfect_release",)
    assert found.best.fit.value("imperfect_release.exponent") == pytest.approx(power, rel=0.05)
    assert found.best.fit.misfit < 1.1
    even = fitted(level)[1]
    assert even.misfit > 3.0


SHAPES = {
    "exponential": lambda u: math.exp(-3.0 * u),
    "half a cosine": lambda u: 0.5 * (1.0 + math.cos(math.pi * min(u, 1.0))),
    "square": lambda u: max(1.0 - u, 0.0) ** 2,
    "root": lambda u: math.sqrt(max(1.0 - u, 0.0)),
}


def let_go_as(shape: str, x0: float, seed: int, share: float, size: float = 5e-6) -> Recording:
    """A release whose force falls in that way, integrated in small steps, with noise of that size in m."""
    rng = np.random.default_rng(seed)
    k, c, mu = (v * (1 + SCATTER[s] * rng.standard_normal()) for s, v in zip(SCATTER, SPRINGS["long"], strict=True))
    numbers = (k, c, mu * SPECIMEN.normal_force_N, 300.0, 450.0)
    theta = Equation(tuple(registry.find(n) for n in EQ15), numbers, mass_kg=MASS).theta(x0, 0.0)
    mass, drag, friction = (float(theta[SLOT[slot]]) for slot in ("mass", "q", "fc"))
    fine, rate, hold = 20, 200.0, 0.6 + rng.uniform(0, 0.01)
    step, x, v = 1.0 / rate / fine, x0, 0.0
    moved = np.empty((2, round(11.3 * rate * fine)))
    for i in range(moved.shape[1]):
        pull = k * x0 * SHAPES[shape](i * step / (share * PERIOD)) - k * x - c * v - drag * v * abs(v)
        sticks = v == 0.0 and abs(pull) <= friction
        a = 0.0 if sticks else (pull - math.copysign(friction, v or pull)) / mass
        moved[:, i] = x, a
        after = 0.0 if v * (v + a * step) < 0.0 else v + a * step
        x, v = x + 0.5 * (v + after) * step, after
    time = np.arange(round(11.9 * rate)) / rate
    since = np.arange(moved.shape[1]) * step
    x_of, a_of = (np.interp(time - hold, since, one, left=first) for one, first in zip(moved, (x0, 0.0), strict=True))
    noise = rng.standard_normal((2, time.size))
    return Recording(
        f"long{x0:g}", time, {"displacement": x_of + size * noise[0], "acceleration": a_of + 600.0 * size * noise[1]}
    )


def more_probable(found: LevelDiagnosis) -> list[Candidate]:
    """Sound candidates that are far more probable than the answer, so that it would not be one."""
    return [c for c in found.candidates if not c.out and c.score > found.best.score + trying.ODDS]


def test_what_is_left_of_the_way_in_which_a_hook_lets_go_is_no_effect_beside_it(monkeypatch):
    level = level_of([let_go_as("half a cosine", x0, 40 + i, 0.15) for i, x0 in enumerate((0.02, 0.035, 0.05))])
    some = chosen(("cubic_stiffness", "drag_exponent", "imperfect_release"))
    assert diagnose(level, some).best.names == ("imperfect_release",)
    assert not more_probable(diagnose(level, some))
    monkeypatch.setattr(search, "shows_later", lambda level, candidate: True)
    passing = more_probable(diagnose(level, some))
    assert {c.names for c in passing} == {("imperfect_release", "cubic_stiffness")}
    assert not any(shows_later(level, c) for c in passing)


def test_what_is_asked_is_the_last_effect_beside_the_hook_and_the_body_is_still_released_at_rest(slow, monkeypatch):
    hook = Addend("imperfect_release", HOOK.additions(slow.scales, 0.1))
    first, last = (Addend(name, ()) for name in ("cubic_stiffness", "relaxation"))
    fit = SimpleNamespace(addends=(first, hook, last), shared_water=True, memory=1.0, values={"x": 1.0}, misfit=1.0)
    asked, gains = [], []

    def fit_later(level, addends, *_, **__):
        asked.append((level, addends))
        numbers = {"one": 0.0, **({"more": 0.0} if last in addends else {})}
        worth = 100.0 - (gains[-1] if last in addends else 0.0)
        return SimpleNamespace(criterion=worth, solution=SimpleNamespace(n_data=100), memory=1.0, values=numbers)

    monkeypatch.setattr(after_release, "fit_joint", fit_later)
    for over, shown in ((3.9, False), (4.1, True)):
        gains.append(over - math.log(100.0))  # what the number costs is not counted
        assert shows_later(slow, SimpleNamespace(fit=fit)) is shown
    (level, every), (_, without) = asked[:2]
    assert (every, without) == ((first, hook, last), (first, hook))
    for motion in level.members[0].motions:
        assert motion.window.held
        assert motion.windowed("t")[0] == pytest.approx(dominant_period(motion), rel=0.1)


def test_of_a_trial_alone_a_slow_release_may_have_been_seen_late_too(slow, monkeypatch):
    _, fit = fitted(slow)
    (member,) = slow.members
    priors, search = [], output_error.fit

    def seen(problem, *args, **options):
        priors.append(next(u.prior_std for u in problem.unknowns if u.name.startswith("shift_s[")))
        return search(problem, *args, **options)

    monkeypatch.setattr(output_error, "fit", seen)
    motion = member.motions[0]
    shared_run(slow, member, fit, motion, 1e-4)
    free_run(motion, shared_theta(slow, member, fit, motion.name), 1e-4)
    assert priors[0] > 2.0 * priors[1]


def test_an_effect_that_lasts_shows_after_the_release_too(slow):
    law = registry.find("asymmetric_stiffness")
    level = hooked(0.25, ((law, 2e5),))
    found = diagnose(level, chosen(("asymmetric_stiffness", "imperfect_release")))
    assert set(found.best.names) == {"asymmetric_stiffness", "imperfect_release"}
    assert shows_later(level, found.best)
    alone = Candidate((HOOK,), fitted(slow)[1], 0.0)
    assert shows_later(slow, alone)  # nothing is beside it


def test_how_a_hook_let_go_in_air_does_not_stand_in_water(slow):
    bent = Addend("imperfect_release", HOOK.wider[0](slow.scales, 0.0))
    law = Addend("cubic_stiffness", (Addition("N_per_m3", "N/m^3", "k3", 0.0, 1.0, scope="spring"),))
    numbers = {"imperfect_release.exponent": (1.4, 0.1), "cubic_stiffness.N_per_m3@long": (5e6, 1e5)}
    judged = SimpleNamespace(addends=(bent, law), labels=("long",), values=numbers)
    assert [addend.prefix for addend in standing_addends([judged])] == ["cubic_stiffness"]


@pytest.mark.slow
@pytest.mark.parametrize("size", [5e-6, 5e-5])
@pytest.mark.parametrize("share", [0.15, 0.4])
@pytest.mark.parametrize("shape", SHAPES)
def test_however_a_hook_lets_go_the_release_alone_is_named(shape, share, size):
    level = level_of([let_go_as(shape, x0, 40 + i, share, size) for i, x0 in enumerate((0.02, 0.035, 0.05))])
    found = diagnose(level, chosen("all"))
    assert found.best.names == ("imperfect_release",)
    assert found.rivals == ()


def test_no_step_from_nothing_shows_a_hook(slow):
    null = plain_fit(slow)
    with pytest.MonkeyPatch.context() as patch:
        asked = []
        patch.setattr(null_module, "places", lambda level, stands, suspect: (asked.append(suspect.label), ())[1])
        null_test(slow, chosen(("imperfect_release", "cubic_stiffness")), null, ())
    assert asked == ["cubic_stiffness", "imperfect_release"]
