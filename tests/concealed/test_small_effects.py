"""Small effects: one linear step foresees what a fit finds; memory that fades is damping; sensors can be named."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

from tests.concealed.test_diagnosis import LONG, SHORT, member
from undertow.comparison import attempt, candidate, search, trying
from undertow.comparison.attempt import from_pair, from_places, from_starts, from_twin
from undertow.comparison.candidate import Candidate
from undertow.comparison.clock import SIGNIFICANT
from undertow.comparison.explained import asked, explains
from undertow.comparison.joint import JointFit, fit_joint, fit_standing
from undertow.comparison.level import Addend, Level, make_level
from undertow.comparison.score_test import GridPlace, Stands, peaks, places
from undertow.comparison.search import diagnose
from undertow.comparison.suspects import SUSPECTS, Suspect, chosen, kernel_additions
from undertow.comparison.trying import beyond_starts, own_rates
from undertow.discrepancy.case import Case
from undertow.discrepancy.judge import judge
from undertow.discrepancy.validation import addition_parameters, kernel_damping
from undertow.discrepancy.verdict import Described
from undertow.equation import registry
from undertow.likelihood import output_error
from undertow.likelihood.budget import BudgetError, metered
from undertow.recording.recording import Recording


def found(name: str, variant: str = "") -> Suspect:
    """A suspect by its name and variant."""
    return next(s for s in SUSPECTS if s.name == name and s.variant == variant)


def stands(level: Level) -> JointFit:
    """The prescribed equation fitted to a level."""
    return fit_standing(level)


def test_the_linear_step_foresees_the_gain_of_the_fit():
    level = make_level([member("short", SHORT, 2000, ((registry.find("linear_damping"), 250.0),))])
    fit = stands(level)
    damping = found("linear_damping", "one for all springs")
    ahead = peaks(places(level, Stands.of(fit), damping))
    candidate = from_places(level, Candidate((), fit, 0.0), damping, ahead, 0.0)
    assert candidate is not None
    cells = fit.solution.n_data / fit.memory
    gained = 0.5 * (fit.criterion - candidate.fit.criterion + math.log(cells))  # without the new unknown's penalty
    assert ahead[0].gain > 5.0
    assert ahead[0].gain == pytest.approx(gained, rel=0.4)  # the noise is found anew by the fit, not by the step


def test_the_nearest_places_of_a_grid_are_followed_to_their_end(monkeypatch):
    level = make_level([member("short", SHORT[:1], 2000)])
    fit = stands(level)
    quick = iter([replace(fit, criterion=fit.criterion + away) for away in (5.0, 1.0, 9.0, 3.0)])
    followed = []

    def to_the_end(level: Level, one: JointFit) -> JointFit:
        followed.append(one.criterion - fit.criterion)
        return one

    monkeypatch.setattr(attempt, "_from_place", lambda *_: next(quick))
    monkeypatch.setattr(attempt, "_refined", to_the_end)
    damping = found("linear_damping", "one for all springs")
    ahead = peaks(places(level, Stands.of(fit), damping))[:1] * 4
    candidate = from_places(level, Candidate((), fit, 0.0), damping, ahead, 0.0)
    assert followed == pytest.approx([1.0, 3.0])
    assert candidate is not None
    assert candidate.fit.criterion == pytest.approx(fit.criterion + 1.0)


def test_water_that_swings_at_twice_the_bodys_rate_is_offered_its_own_line(monkeypatch):
    # as a long spring has it in the flume: no fit from the resonator's starts comes there
    suspect = found("hidden_resonator")
    level = make_level([member("long", LONG, 2000)])
    frequency = 2.1 * level.scales.rate
    assert suspect.starts(level.scales)[-1] < frequency / 1.2
    water = registry.find("hidden_resonator", natural_frequency_rad_per_s=frequency, damping_ratio=0.003)
    level = make_level([member("long", LONG, 2000, ((water, 300.0),))])
    seen = peaks(places(level, Stands.of(stands(level)), suspect))[:1]
    assert beyond_starts(level, suspect, seen) == pytest.approx([frequency], rel=0.08)
    offered = []
    monkeypatch.setattr(trying, "FINE", 0.0)  # where little is missing every place of the grid is looked at
    monkeypatch.setattr(trying, "WORTH", 0.0)
    monkeypatch.setattr(trying, "from_starts", lambda *given: offered.append(given[5]))
    diagnose(level, [suspect])
    assert offered == [beyond_starts(level, suspect, seen)]


def test_a_wider_form_is_also_fitted_from_where_its_twin_ended():
    water = registry.find("hidden_resonator", natural_frequency_rad_per_s=9.6, damping_ratio=0.02)
    level = make_level([member("short", SHORT, 700, ((water, 150.0),))])
    null, (linear, wider) = Candidate((), stands(level), 0.0), (s for s in SUSPECTS if s.name == "hidden_resonator")
    twin = from_starts(level, null, linear, 0.0)
    assert twin is not None
    lost = Candidate((wider,), replace(twin.fit, criterion=twin.fit.criterion + 500.0), -1.0, "it sits on its bound")
    assert from_twin(level, null, wider, lost, None) is lost
    assert from_twin(level, null, wider, None, twin) is None
    mended = from_twin(level, null, wider, lost, twin)
    assert mended.suspects == (wider,)
    assert mended.fit.criterion < twin.fit.criterion + 20.0  # two more numbers that nothing asks for
    assert mended.fit.value("hidden_resonator.natural_frequency_rad_per_s") == pytest.approx(9.6, rel=0.01)
    assert "bound" not in mended.out
    assert from_twin(level, null, wider, mended, twin) is mended


def test_a_wider_form_is_offered_what_its_twin_found_that_is_worth_it(monkeypatch):
    water = registry.find("hidden_resonator", natural_frequency_rad_per_s=9.6, damping_ratio=0.02)
    pair, offered = [s for s in SUSPECTS if s.swings], []
    monkeypatch.setattr(attempt, "from_twin", lambda *given: (offered.append((given[2], given[4])), given[3])[1])
    diagnose(make_level([member("short", SHORT, 700, ((water, 150.0),))]), pair)
    assert [one for one, _ in offered[:2]] == pair
    assert offered[0][1] is None
    assert offered[1][1].suspects == (pair[0],)
    offered.clear()
    monkeypatch.setattr(trying, "ODDS", 1e9)  # as if what the twin found were not worth it
    diagnose(make_level([member("short", SHORT, 700, ((water, 150.0),))]), pair)
    assert [twin for _, twin in offered[:2]] == [None, None]


@pytest.mark.parametrize("away", [-2, 1, 3])
def test_an_echo_is_found_from_a_place_some_half_periods_off(away):
    """Its linear steps come in no order in a slow decay: the true one had been the sixth peak of a sealed case."""
    suspect, delay = found("delayed_echo"), 2.58
    level = make_level([member("short", SHORT, 7100, ((registry.find("delayed_echo", delay_s=delay), 900.0),))])
    null, half = Candidate((), stands(level), 0.0), math.pi / level.scales.slowest
    place = GridPlace("delayed_echo", suspect.additions(level.scales, delay + away * half), 9.0)
    candidate = from_places(level, null, suspect, [place], 0.0)
    assert candidate.fit.value("delayed_echo.delay_s") == pytest.approx(delay, abs=0.03)
    assert candidate.fit.value("delayed_echo.gain@short") == pytest.approx(900.0, rel=0.1)
    stays = from_places(level, null, replace(suspect, recurs=False), [place], 0.0)
    assert abs(stays.fit.value("delayed_echo.delay_s") - delay) > 0.5 * half


@pytest.mark.parametrize("joined", [from_starts, from_places])
def test_an_echo_that_another_law_joins_is_walked_half_periods_on_too(joined):
    """Alone it had been fitted to what two effects leave, and had ended half a period beside (a sealed case)."""
    echo, cubic, delay = found("delayed_echo"), found("cubic_stiffness"), 2.58
    laws = ((registry.find("delayed_echo", delay_s=delay), 900.0), (registry.find("cubic_stiffness"), 3e6))
    level = make_level([member("short", SHORT, 7100, laws)])
    null, half = Candidate((), stands(level), 0.0), math.pi / level.scales.slowest
    place = GridPlace("delayed_echo", echo.additions(level.scales, delay + half), 9.0)
    beside = from_places(level, null, replace(echo, recurs=False), [place], 0.0)
    assert abs(beside.fit.value("delayed_echo.delay_s") - delay) > 0.5 * half

    def both(first):
        stood = replace(beside, suspects=(first,))
        seen = GridPlace("cubic_stiffness", cubic.additions(level.scales, 0.0), 9.0)
        return joined(level, stood, cubic, *([] if joined is from_starts else [[seen]]), 0.0)

    together = both(echo)
    assert together.suspects == (echo, cubic)
    assert together.fit.value("delayed_echo.delay_s") == pytest.approx(delay, abs=0.03)
    assert together.fit.value("cubic_stiffness.N_per_m3@short") == pytest.approx(3e6, rel=0.1)
    assert abs(both(replace(echo, recurs=False)).fit.value("delayed_echo.delay_s") - delay) > 0.5 * half


def test_two_of_a_kind_at_once_have_numbers_of_their_own():
    water = registry.find("hidden_resonator", natural_frequency_rad_per_s=9.6, damping_ratio=0.02)
    level = make_level([member("short", SHORT, 700, ((water, 150.0),))])
    null, pair = Candidate((), stands(level), 0.0), tuple(s for s in SUSPECTS if s.name == "hidden_resonator")
    additions = [pair[0].additions(level.scales, 9.6), pair[1].additions(level.scales, 14.0)]
    (both,) = from_pair(level, null, (), pair, additions, 0.0, math.inf)
    masses = [f"hidden_resonator{n}.mass_kg" for n in ("", "#2")]
    assert [f"{a.prefix}.mass_kg" for a in both.fit.addends] == masses
    assert both.fit.value(masses[0]) != both.fit.value(masses[1])


def test_no_line_within_the_starts_is_offered_twice():
    suspect, level = found("hidden_resonator"), make_level([member("long", LONG, 2000)])
    seen = peaks(places(level, Stands.of(stands(level)), suspect))
    rates = [next(a.start for a in place.additions if a.unit == "rad/s") for place in seen]
    starts = suspect.starts(level.scales)
    within = [place for place, w in zip(seen, rates, strict=True) if starts[0] <= w <= starts[-1]]
    assert within
    assert beyond_starts(level, suspect, within) == ()


@pytest.mark.parametrize(("slow", "fast", "rates"), [(5.0, 12.0, (5.0, 12.0)), (11.6, 11.7, (11.7,))])
def test_a_force_at_the_bodys_own_rate_is_tried_in_growing_windows_from_there(monkeypatch, slow, fast, rates):
    suspect, level = found("external_forcing"), make_level([member("short", SHORT, 2000)])
    level = replace(level, scales=replace(level.scales, slowest=slow, fastest=fast))
    assert own_rates(level) == rates
    offered, windows = [], []
    monkeypatch.setattr(trying, "FINE", 0.0)
    monkeypatch.setattr(trying, "WORTH", 0.0)
    monkeypatch.setattr(trying, "from_places", lambda *given: offered.append(given[-1]))
    diagnose(level, [suspect])
    assert offered == [rates]
    best = Candidate((), stands(level), 0.0)
    monkeypatch.setattr(
        attempt, "_with", lambda *given, growing: windows.append((given[2][0].additions[0].start, growing))
    )
    assert from_places(level, best, suspect, (), 0.0, rates) is None
    assert windows == [(rate, True) for rate in rates]


def test_a_start_that_takes_too_many_steps_is_none(monkeypatch):
    level = make_level([member("short", SHORT, 2000, ((registry.find("linear_damping"), 250.0),))])
    stand, damping = Candidate((), stands(level), 0.0), found("cubic_damping")
    assert from_starts(level, stand, damping, 0.0) is not None
    with metered(1.0), pytest.raises(BudgetError, match="integrator steps"):  # all suspects together are another matter
        from_starts(level, stand, damping, 0.0)
    monkeypatch.setattr(attempt, "QUICK_LOOKS", 0.5)
    assert from_starts(level, stand, damping, 0.0) is None


def test_the_grid_peaks_at_a_light_resonators_frequency():
    resonator = registry.find("hidden_resonator", natural_frequency_rad_per_s=8.4, damping_ratio=0.02)
    level = make_level([member("short", SHORT, 2100, ((resonator, 20.0),))])
    suspect = found("hidden_resonator")
    best = peaks(places(level, Stands.of(stands(level)), suspect))[0]
    frequency = next(a.start for a in best.additions if a.slot == "hw1")
    assert frequency == pytest.approx(8.4, rel=0.03)  # one step of the grid
    mass = next(a.start for a in best.additions if a.slot == "hm1")
    assert mass == pytest.approx(20.0, rel=0.5)


def test_where_nothing_is_hidden_hardly_anything_is_fitted():
    diagnosis = diagnose(make_level([member("short", SHORT, 2200)]), chosen("all"))
    assert diagnosis.best.names == ()
    assert len(diagnosis.screened) > len(diagnosis.candidates)
    assert all(s.gain < 5.0 for s in diagnosis.screened)
    assert 0.5 < diagnosis.confidence < 1.0


def test_damping_of_a_kernel_at_its_own_frequency_is_that_of_a_dashpot():
    level = make_level([member("short", SHORT[:2], 2300)])
    addend = Addend("linear_damping", kernel_additions(1, 60.0, 9.0, 0.3))
    fit = fit_joint(level, (addend,), 4.0, {}, 2.0, growing=False, quick=True)
    mass, w, z = (fit.value(f"linear_damping.kernel_{n}") for n in ("mass_kg", "frequency_rad_per_s", "damping_ratio"))
    # force over velocity of m (w^2 + 2 i z w W) / (w^2 - W^2 + 2 i z w W) at W = w
    assert kernel_damping(fit, addend, w).value == pytest.approx(mass * w / (2.0 * z), rel=1e-9)


def test_a_resonator_that_hardly_rings_is_called_damping():
    fading = registry.find("hidden_resonator", natural_frequency_rad_per_s=6.0, damping_ratio=0.5)
    hidden = ((fading, 220.0),)
    level = make_level([member("short", SHORT, 2400, hidden), member("long", LONG, 2420, hidden)])
    diagnosis = diagnose(level, chosen(("linear_damping", "hidden_resonator", "relaxation")))
    assert "hidden_resonator" not in diagnosis.best.names
    assert diagnosis.best.names[:1] in {("linear_damping",), ("relaxation",)}


def changed(spring: str, seed: int, change) -> object:
    """A group whose recordings went through a faulty sensor."""
    import tests.concealed.test_diagnosis as base

    plain = base.recording

    def faulty(spring: str, x0: float, seed: int, hidden=()) -> Recording:
        return change(plain(spring, x0, seed, hidden))

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(base, "recording", faulty)
        return member(spring, SHORT, seed)


def late(recording: Recording) -> Recording:
    """The accelerometer 11 ms behind."""
    a = recording.channels["acceleration"]
    shifted = np.interp(recording.time - 0.011, recording.time, a)
    return replace(recording, channels={**recording.channels, "acceleration": shifted})


def drifting(recording: Recording) -> Recording:
    """The displacement 1.5 mm off at the end."""
    x = recording.channels["displacement"]
    return replace(recording, channels={**recording.channels, "displacement": x + 1.5e-3 * recording.time / 10.0})


@pytest.mark.slow
def test_an_accelerometer_that_is_late_is_named_with_its_delay():
    group = changed("short", 2500, late)
    case = Case({"spring": "short"}, "spring short", group, (), Described(), 0.004, 0.05, 0, False, True)
    (verdict,) = judge([case], chosen("all"))
    assert verdict.verdict == ("time_shift",)
    assert verdict.origin == "instrument"
    assert verdict.parameters["time_shift"]["shift_s"].value == pytest.approx(0.011, abs=1e-3)


@pytest.mark.slow
def test_a_displacement_that_drifts_is_named():
    diagnosis = diagnose(make_level([changed("short", 2600, drifting)]), chosen("all"))
    assert diagnosis.best.names == ("sensor_drift",)


def test_what_the_dry_trials_need_stands_in_the_wet_equation():
    hidden = ((registry.find("cubic_stiffness"), 6.0e7),)
    group = member("short", SHORT, 2700, hidden)
    suspect = found("cubic_stiffness")
    (plain,) = suspect.grid(make_level([group]).scales)
    held = replace(plain[0], by_spring=(("short", 6.0e7, 3e6),))
    case = Case({"spring": "short"}, "spring short", group, (), Described(), 0.004, 0.05, 3, False, True)
    (verdict,) = judge([case], chosen("all"), (Addend("cubic_stiffness", (held,)),))
    assert verdict.verdict == ("cubic_stiffness",)
    assert verdict.origin == "structure"
    assert "dry trials need cubic stiffness" in verdict.sentence


def test_a_small_hysteresis_yields_in_its_look_and_is_found_from_its_starts():
    hysteresis = registry.find("hysteresis", yield_displacement_m=0.006)
    level = make_level([member("short", SHORT, 2700, ((hysteresis, 30000.0),))])
    suspect, fit = found("hysteresis"), stands(level)
    ahead = peaks(places(level, Stands.of(fit), suspect))[0]
    (stiffness,) = ahead.additions
    assert ahead.gain > 20.0  # at a yield force of its own it would never yield, and be a spring
    assert stiffness.also
    assert stiffness.start == pytest.approx(30000.0, rel=0.5)
    diagnosis = diagnose(level, (suspect,))
    best = max((c for c in diagnosis.candidates if c.suspects), key=lambda c: c.score)
    k, force = (best.fit.value(f"hysteresis.{n}") for n in ("stiffness_N_per_m", "yield_force_N"))
    assert force / k == pytest.approx(0.006, rel=0.3)
    (said,) = addition_parameters(best.fit, "short")["hysteresis"]
    assert said["yield_displacement_m"].value == pytest.approx(force / k)  # the repaired equation had its usual 5 mm
    assert 0.0 < said["yield_displacement_m"].stderr < 0.3 * force / k
    assert said["yield_displacement_m"].unit == "m"


def test_what_need_explain_no_share_is_not_held_against_a_fit_that_took_it_up():
    before, after = (SimpleNamespace(fit=SimpleNamespace(misfit=m)) for m in (2.0, 2.1))
    assert explains(before, after, 0.0)
    assert not explains(before, after, 0.75)
    assert asked(SimpleNamespace(suspects=(found("added_mass"),))) == 0.0


def test_a_bad_release_may_leave_what_noise_is_known_by_and_else_a_twentieth():
    release = (found("imperfect_release"),)
    shares = [asked(SimpleNamespace(suspects=release, fit=SimpleNamespace(misfit=m))) for m in (1.4, 1.6)]
    assert shares == [0.75, 0.95]


def test_behind_what_hides_within_repeatability_another_must_show_in_the_free_run(monkeypatch):
    """An echo that would bias a number is no answer where a stiffness is more probable and hardly shows."""
    monkeypatch.setattr(search, "free_run_error", lambda _, fit: fit.miss)
    monkeypatch.setattr(search, "biases", lambda _, candidate: candidate.biases)

    def one(name: str, score: float, miss: float, biases: bool) -> SimpleNamespace:
        return SimpleNamespace(
            suspects=(found(name),), names=(name,), score=score, fit=SimpleNamespace(misfit=1.0, miss=miss),
            biases=biases, out="", aside=False,
        )  # fmt: skip

    def worthwhile(probable: list[SimpleNamespace]) -> object:
        null = SimpleNamespace(suspects=(), score=7.0, fit=SimpleNamespace(misfit=1.1, miss=0.9))
        state = SimpleNamespace(level=None, null=null, best=null, error=0.9, small=[], found=list(probable))
        for name in ("_too_small", "_set_aside"):
            setattr(state, name, partial(getattr(search._Search, name), state))
        monkeypatch.setattr(search, "replace", lambda c, **new: SimpleNamespace(**(vars(c) | new)))
        answer = search._Search._worthwhile(state, probable, 1.0)
        aside.append({c.names[0]: c.out for c in state.found})
        return answer

    aside: list[dict[str, str]] = []

    stiffness = one("cubic_stiffness", 50.0, 0.85, biases=False)
    assert worthwhile([stiffness, one("delayed_echo", 45.0, 0.85, biases=True)]) is None
    assert aside[-1]["cubic_stiffness"] == "brings the free run closer by less than counts (log odds 43)"
    assert worthwhile([one("delayed_echo", 45.0, 0.85, biases=True)]) is not None
    shown = one("cubic_damping", 40.0, 0.2, biases=False)
    assert worthwhile([stiffness, shown])[0] is shown


@pytest.mark.parametrize(("error", "closer", "counts"), [(1.03, 0.95, True), (1.03, 1.01, False), (0.9, 0.85, True)])
def test_what_biases_a_number_counts_where_beside_it_the_free_run_is_within_repeatability(
    monkeypatch, error, closer, counts
):
    """A dashpot that moved drag by nine standard errors was refused: the equation alone missed 1.03 repeatabilities."""
    monkeypatch.setattr(search, "free_run_error", lambda *_: closer)
    monkeypatch.setattr(search, "biases", lambda *_: True)
    monkeypatch.setattr(search, "beyond_doubt", lambda *_: False)
    null = SimpleNamespace(suspects=(), score=0.0, fit=SimpleNamespace(misfit=1.05))
    damped = SimpleNamespace(suspects=(found("cubic_damping"),), names=("cubic_damping",), score=7.0, fit=null.fit)
    aside = []
    state = SimpleNamespace(level=None, null=null, best=null, error=error, _too_small=aside.append)
    assert search._Search._worthwhile(state, [damped], 1.0) == ((damped, closer) if counts else None)
    assert aside == ([] if counts else [damped])


def test_bristles_stand_for_a_loop_beside_which_nothing_slides_and_what_was_found_before_it_stays(monkeypatch):
    monkeypatch.setattr(search, "free_run_error", lambda _, fit: fit.miss)
    monkeypatch.setattr(search.explained, "slides", lambda candidate: candidate.slides)

    def one(names: tuple[str, ...], miss: float, slides: float = 0.0, score: float = 0.0) -> SimpleNamespace:
        suspects, fit = tuple(found(n) for n in names), SimpleNamespace(miss=miss)
        return SimpleNamespace(suspects=suspects, names=names, fit=fit, slides=slides, score=score)

    loop = one(("cubic_stiffness", "hysteresis"), 1.0, score=0.99 * search.OVERWHELMING)
    bristles = [one(names, 2.0 + i) for i, names in enumerate([
        ("presliding",), ("quintic_stiffness", "presliding"), ("cubic_stiffness", "presliding"),
    ])]  # fmt: skip
    plainer = partial(search._Search._plainer, SimpleNamespace(level=None, found=[], error=1.0))
    assert plainer((loop, 1.0), [loop, *bristles]) == (bristles[-1], 4.0)
    assert plainer((loop, 1.0), [loop, *bristles[:-1]]) == (loop, 1.0)
    likelier = one(loop.names, 1.0, score=1.01 * search.OVERWHELMING)
    assert plainer((likelier, 1.0), [likelier, *bristles]) == (likelier, 1.0)
    monkeypatch.setattr(search.explained, "single_fading", lambda _: False)
    rubs = one(("cubic_stiffness", "hysteresis"), 1.0, slides=1.0)
    assert plainer((rubs, 1.0), [rubs, *bristles]) == (rubs, 1.0)


def test_of_doubted_pairs_the_leanest_more_probable_by_what_is_asked_goes_on():
    asked, lean = [], SimpleNamespace(score=42.0)

    def leaner(candidate: SimpleNamespace, error: float, least: float) -> tuple[SimpleNamespace, float] | None:
        asked.append((candidate, error, least))
        return (lean, 0.5) if candidate.score > 40.0 else None

    state = SimpleNamespace(best=SimpleNamespace(score=20.0), error=1.5, _leaner=leaner)
    one = SimpleNamespace(out="any", suspects=(1,), score=99.0)
    two = SimpleNamespace(out="", suspects=(1, 2), score=99.0)
    near, far, further = (SimpleNamespace(out="any", suspects=(1, 2), score=score) for score in (24.0, 26.0, 50.0))
    assert search._Search._without_one(state, [one, two, near, far, further], 5.0) == (lean, 0.5)
    assert asked == [(far, 1.5, 25.0), (further, 1.5, 25.0)]
    assert search._Search._without_one(state, [near, far], 5.0) is None


@pytest.mark.parametrize(
    ("before", "memory", "damping", "plain"),
    [(3.0, 0.8, 0.9, True), (3.0, 0.8, 2.0, False), (3.0, 1.9, 1.95, True), (0.85, 0.8, 0.9, False)],
    ids=["both within repetitions", "the memory alone comes near", "both as far", "damping comes no closer"],
)
def test_damping_stands_for_a_memory_that_fades_where_the_free_run_cannot_tell_them(
    monkeypatch, before, memory, damping, plain
):
    monkeypatch.setattr(search, "free_run_error", lambda _, fit: fit.miss)
    monkeypatch.setattr(search.explained, "single_fading", lambda candidate: candidate.names == ("relaxation",))
    monkeypatch.setattr(search.explained, "fading", lambda _: False)

    def one(name: str, variant: str, score: float, miss: float) -> SimpleNamespace:
        fit = SimpleNamespace(misfit=1.1, miss=miss)
        return SimpleNamespace(suspects=(found(name, variant),), names=(name,), score=score, fit=fit)

    fades = one("relaxation", "", 50.0, memory)
    damped = one("linear_damping", "one for all springs", 45.0, damping)
    state = SimpleNamespace(level=None, found=[fades, damped], error=before, _set_aside=lambda *_: None)
    answer = search._Search._plainer(state, (fades, memory), [fades, damped])
    assert answer == ((damped, damping) if plain else (fades, memory))


@pytest.mark.parametrize("spoilt", ["no motion", "no derivatives"])
def test_a_place_without_a_motion_or_its_derivatives_shows_nothing(monkeypatch, spoilt):
    level = make_level([member("short", SHORT, 2000)])
    at, usual = Stands.of(stands(level)), output_error.residuals

    def spoil(trial: object, values: object) -> object:
        r, jac, used = usual(trial, values)
        return None if spoilt == "no motion" else (r, np.full_like(jac, np.nan), used)

    damping = found("linear_damping", "one for all springs")
    (sound,) = places(level, at, damping)
    assert sound.columns
    monkeypatch.setattr(output_error, "residuals", spoil)
    (place,) = places(level, at, damping)
    assert (place.gain, place.columns) == (0.0, ())


def test_a_searched_number_starts_on_both_sides_of_what_the_equation_has():
    scales = make_level([member("short", SHORT, 2000)]).scales
    for suspect in SUSPECTS:
        starts, fine = suspect.starts(scales), (suspect.fine or suspect.starts)(scales)
        assert min(fine) <= min(starts) <= max(starts) <= max(fine) or suspect.memory or suspect.look, suspect.label
    exponents = found("drag_exponent").starts(scales)
    assert min(exponents) < 2.0 < max(exponents)  # a drag of exponent 2 is the equation's own


@pytest.mark.parametrize(("left", "answer"), [(30.0, "relaxation"), (1.1, "hysteresis")])
def test_what_leaves_no_more_than_noise_is_not_passed_over_for_a_description_that_comes_closer(
    monkeypatch, left, answer
):
    """A memory beyond doubt that brings trials no closer, whose k differ, and a loop that leaves five times noise."""
    monkeypatch.setattr(search, "free_run_error", lambda _, fit: fit.miss)
    monkeypatch.setattr(search, "beyond_doubt", lambda *_: True)
    monkeypatch.setattr(search, "replace", lambda c, **new: SimpleNamespace(**(vars(c) | new)))

    def one(name: str, score: float, misfit: float, miss: float) -> SimpleNamespace:
        fit = SimpleNamespace(misfit=misfit, miss=miss)
        return SimpleNamespace(suspects=(found(name),), names=(name,), score=score, fit=fit, out="", aside=False)

    null = SimpleNamespace(suspects=(), score=0.0, fit=SimpleNamespace(misfit=7000.0, miss=3.4))
    probable = [one("relaxation", 660.0, 1.1, 4.5), one("hysteresis", 350.0, left, 1.0)]
    state = SimpleNamespace(level=None, null=null, best=null, error=3.4, small=[], found=list(probable))
    for name in ("_too_small", "_set_aside"):
        setattr(state, name, partial(getattr(search._Search, name), state))
    assert search._Search._worthwhile(state, probable, 1.0)[0].names == (answer,)
    aside = {c.names[0]: c.out for c in state.found if c.aside}
    assert ("relaxation leaves no more than noise" in aside.get("hysteresis", "")) == (answer == "relaxation")


@pytest.mark.parametrize(
    ("error", "left", "score", "changing", "pair", "answer"),
    [
        (6.0, 4000.0, 60.0, False, 1.0, "external_forcing"), (0.9, 4000.0, 60.0, False, 1.0, "external_forcing"),
        (0.9, 4000.0, 60.0, False, 900.0, ""), (6.0, 4000.0, 60.0, False, 900.0, "external_forcing"),
        (6.0, 500.0, 60.0, False, 1.0, ""), (6.0, 900.0, 60.0, False, 1.0, "external_forcing"),
        (6.0, 4000.0, 16.0, False, 1.0, ""), (0.9, 1.5, 60.0, True, 1.0, "external_forcing"),
        (0.9, 1.5, 16.0, True, 1.0, ""),
    ],
)  # fmt: skip
def test_two_strong_effects_are_found_from_another_first_one(monkeypatch, error, left, score, changing, pair, answer):
    """An echo took up a third of what a force and a resonator leave; the pair is looked for beside the force, and where
    the echo is as close as repetitions must explain nearly all (else it is no rival either). So it is looked for where
    a force that changes along the record (here in the echo's place) left no more than noise."""
    monkeypatch.setattr(search, "changes", lambda addend: changing and addend == "delayed_echo")
    monkeypatch.setattr(search, "free_run_error", lambda _, fit: fit.miss)

    def one(names: tuple[str, ...], score: float, misfit: float) -> SimpleNamespace:
        suspects = tuple(found(name) for name in names)
        fit = SimpleNamespace(misfit=misfit, miss=0.5, addends=names)
        return SimpleNamespace(suspects=suspects, score=score, fit=fit, out="")

    null, echo, force = one((), 0.0, 12000.0), one(("delayed_echo",), 15.0, left), one(("external_forcing",), 12.0, 3e3)
    other = one(("delayed_echo",), 14.0, left + 1.0)  # the same law in another form is no other first one
    other.suspects = (replace(other.suspects[0], variant="another"),)
    tried: list[object] = []

    def beside(depth: int) -> list[SimpleNamespace]:
        tried.append(state.best)
        return [one(("external_forcing", "hidden_resonator"), score, pair)]

    state = SimpleNamespace(
        level=None, null=null, best=echo, error=error, found=[null, echo, other, force], small=[], screened={},
        _as_far_as_possible=beside, _first=lambda tried: tried,
    )
    state._beside = partial(search._Search._beside, state)
    state._other_pair = partial(search._Search._other_pair, state)
    ahead = search._Search._from_another_first(state)
    assert ("" if ahead is None else ahead[0].suspects[0].name) == answer
    assert state.best is echo
    assert tried == ([force] if changing or left > 600.0 else [])
    assert (len(state.found) == 5) is (bool(tried) and (bool(answer) or error > 1.0 or changing))


def test_a_release_that_leaves_more_than_noise_is_held_against_pairs(monkeypatch):
    """It explained 96 % of what a resonator and a dashpot leave in two swings, and 700 times the noise stayed."""
    monkeypatch.setattr(search, "free_run_error", lambda _, fit: fit.miss)
    monkeypatch.setattr(search, "changes", lambda addend: False)
    variants = {"imperfect_release": "a hold that fades", "linear_damping": "one for all springs"}

    def one(names: tuple[str, ...], score: float, misfit: float) -> SimpleNamespace:
        suspects = tuple(found(name, variants.get(name, "")) for name in names)
        return SimpleNamespace(
            suspects=suspects, score=score, out="", fit=SimpleNamespace(misfit=misfit, miss=0.9, addends=names)
        )

    for left, answer in ((703.0, "hidden_resonator"), (2.0, "")):
        null, release = one((), 0.0, 16655.0), one(("imperfect_release",), 50.0, left)
        water, both = one(("hidden_resonator",), 40.0, 450.0), one(("hidden_resonator", "linear_damping"), 92.0, 4.0)
        state = SimpleNamespace(
            level=None, null=null, best=release, error=2.0, found=[null, release, water], small=[], screened={}
        )
        state._beside = lambda singles, both=both: [both]
        state._other_pair = partial(search._Search._other_pair, state)
        ahead = search._Search._from_another_first(state)
        assert ("" if ahead is None else ahead[0].suspects[0].name) == answer


@pytest.mark.parametrize(
    ("third", "out", "pair", "asked", "answer"),
    [
        (7.1, "", 16.0, True, "linear_damping"),
        (7.1, "", 4.0, True, ""),  # no more probable than what stands
        (4.0, "", 16.0, False, ""),  # the third is not likely
        (7.1, "would feed energy", 16.0, False, ""),
    ],
)
def test_two_beside_which_a_third_is_likely_are_held_against_two_others(monkeypatch, third, out, pair, asked, answer):
    """A drag of power 1.1 was taken for a dashpot before a resonator was known, and cubic damping made good for it."""
    monkeypatch.setattr(search, "free_run_error", lambda _, fit: 0.2)

    def one(names: tuple[str, ...], score: float, out: str = "") -> SimpleNamespace:
        every = {"linear_damping": "one for all springs"}
        suspects = tuple(found(name, every.get(name, "")) for name in names)
        return SimpleNamespace(suspects=suspects, score=score, fit=SimpleNamespace(), out=out)

    power, dashpot = one(("drag_exponent",), 27.1), one(("linear_damping",), 26.3)
    water = one(("hidden_resonator",), 12.0)
    stands = one(("drag_exponent", "hidden_resonator"), 220.0)
    three = one(("drag_exponent", "hidden_resonator", "cubic_damping"), 220.0 + third, out)
    singles: list[object] = []

    def beside(given: list[SimpleNamespace]) -> list[SimpleNamespace]:
        singles.extend(given)
        return [one(("linear_damping", "hidden_resonator"), 220.0 + pair)]

    state = SimpleNamespace(level=None, best=stands, found=[power, dashpot, water, stands, three], _beside=beside)
    state._other_pair = partial(search._Search._other_pair, state)
    ahead = search._Search._in_place_of_two(state)
    assert singles == ([dashpot] if asked else [])
    assert ("" if ahead is None else ahead[0].suspects[0].name) == answer
    state.best = power
    assert search._Search._in_place_of_two(state) is None  # of one effect pairs were tried


@pytest.mark.parametrize(
    ("score", "misfit", "out", "aside", "moves", "named"),
    [
        (256.0, 1.077, "brings the free run closer by less than counts", True, True, True),
        (256.0, 1.077, "", False, True, True),
        (256.0, 1.077, "would feed energy", False, True, False),
        (230.0, 1.077, "", False, True, False),  # no million to one
        (256.0, 1.6, "", False, True, False),  # half of what is left
        (256.0, 1.077, "", False, False, False),  # no number that anybody reads
    ],
)
def test_a_law_that_hides_is_more_probable_by_a_million_takes_the_rest_and_moves_a_number(
    monkeypatch, score, misfit, out, aside, moves, named
):
    monkeypatch.setattr(search, "free_run_error", lambda _, fit: 0.4)

    def one(score: float, misfit: float, out: str = "", aside: bool = False) -> SimpleNamespace:
        fit = SimpleNamespace(misfit=misfit, moved=lambda before: ("drag", 6.0 if moves else 1.0))
        return SimpleNamespace(suspects=(found("hidden_resonator"),), score=score, fit=fit, out=out, aside=aside)

    hidden = one(score, misfit, out, aside)
    led, asked = [one(280.0, 1.0, "it is 0.8 standard errors from zero")], []
    state = SimpleNamespace(
        level=None, best=one(219.0, 2.162), error=0.8, suspects=(), found=[hidden], _spending=lambda *_: led,
        _further_on=lambda tried: tried,
        _without_one=lambda tried, least: asked.append((tried, least)),
    )
    ahead = search._Search._hiding_beside(state)
    assert (ahead == (hidden, 0.4)) is named
    assert (ahead is None) is not named
    assert asked == ([] if named else [(led, search.ODDS)])  # what led the answer out of a bad place goes again
    state.best.fit.misfit = 2.6  # far above noise: the search has gone on already
    assert search._Search._hiding_beside(state) is None


def test_a_law_begins_at_its_own_starts_where_every_place_of_its_grid_lost_the_way(monkeypatch):
    level = make_level([member("short", SHORT[:1], 2000, ((registry.find("linear_damping"), 250.0),))])
    null, damping = Candidate((), stands(level), 0.0), found("linear_damping", "one for all springs")
    (place,) = places(level, Stands.of(null.fit), damping)
    near = from_places(level, null, damping, [place], 0.0)
    lost = replace(null.fit, misfit=5.0 * null.fit.misfit, criterion=null.fit.criterion + 1e4)
    looks = []

    def from_a_place(*_: object) -> JointFit:
        return lost

    def attempted(level: Level, best: Candidate, suspect: Suspect, start: float, most: float) -> JointFit | None:
        looks.append(most)
        return began(level, best, suspect, start, most)

    began = attempt._attempt
    monkeypatch.setattr(attempt, "_from_place", from_a_place)
    monkeypatch.setattr(attempt, "_attempt", attempted)
    limits, metered = [], attempt.metered
    monkeypatch.setattr(attempt, "metered", lambda limit: (limits.append(limit), metered(limit))[1])
    again = from_places(level, null, damping, [place], 0.0)
    assert again is not None
    assert looks == [attempt.LOST_LOOKS]
    assert limits == [attempt.LOST_LOOKS * attempt.QUICK_LOOKS * attempt.one_look(null.fit)]
    assert again.fit.misfit == pytest.approx(near.fit.misfit, rel=1e-3)
    monkeypatch.setattr(attempt, "_from_place", lambda *_: null.fit)
    from_places(level, null, damping, [place], 0.0)
    assert len(looks) == 1, "a place that came closer is enough"


def test_a_place_knows_where_what_stands_goes_beside_its_law():
    """The same step in both: drag gives to a dashpot what it had taken up of it."""
    level = make_level([member("short", SHORT, 2000, ((registry.find("linear_damping"), 250.0),))])
    null, damping = Candidate((), stands(level), 0.0), found("linear_damping", "one for all springs")
    (place,) = places(level, Stands.of(null.fit), damping)
    fit = from_places(level, null, damping, [place], 0.0).fit
    names = [name for name in null.fit.values if name.startswith(("drag", "added_mass"))]
    assert names
    at = list(null.fit.values)
    for name in names:
        before, after, told = null.fit.values[name], fit.values[name], place.beside[at.index(name)]
        assert abs(told - after) < 0.2 * abs(before - after) or abs(told - after) < 0.2 * fit.solution.stderr(name)
    (force, *_) = places(level, Stands.of(null.fit), found("external_forcing"))
    assert force.beside.size == 0  # sizes of every trial's own start alike: no one step leads there


@pytest.mark.parametrize(("left", "asked"), [(1e4, True), (2.0, False)], ids=["lost its way", "came closer"])
def test_a_fit_that_loses_the_way_is_tried_again_from_where_the_whole_step_leads(monkeypatch, left, asked):
    """A memory takes over half of a spring: with the spring where it stood its fit ended a hundred times further off
    than without the memory (a sealed case)."""
    relaxation, level = found("relaxation"), make_level([member("short", SHORT[:1], 7200)])
    fit = replace(stands(level), misfit=2.6)
    null, begun = Candidate((), fit, 0.0), []

    def with_addend(
        level: Level, best: Candidate, more: tuple[Addend, ...], known: dict[str, float], growing: bool
    ) -> JointFit:
        begun.append((known, [a.start for a in more[0].additions]))
        away = left if len(begun) == 1 else 1.0
        return replace(fit, misfit=away, criterion=away)

    monkeypatch.setattr(attempt, "_with", with_addend)
    additions, moved = relaxation.additions(level.scales, 0.2), fit.solution.values + 1.0
    place = GridPlace("relaxation", additions, 20.0, beside=moved)
    ended = attempt._from_place(level, null, relaxation, place)
    assert [known for known, _ in begun] == [fit.values, dict(zip(fit.values, moved, strict=True))][: 1 + asked]
    assert ended.misfit == (1.0 if asked else left)
    begun.clear()
    monkeypatch.setattr(attempt, "_attempt", lambda *_: replace(fit, misfit=left, criterion=left))
    monkeypatch.setattr(attempt, "_refined", lambda level, fit: fit)
    assert from_starts(level, null, relaxation, 0.0).fit.misfit == (1.0 if asked else left)
    small = [(known, starts[0] < 1e-2 * additions[0].scale) for known, starts in begun]
    assert small == [(fit.values, True)] * (len(relaxation.starts(level.scales)) if asked else 0)


def test_no_start_of_no_size_is_tried_where_one_found_the_way_nor_a_place_on_another_water(monkeypatch):
    relaxation, level = found("relaxation"), make_level([member("short", SHORT[:1], 7200)])
    fit, begun = replace(stands(level), misfit=2.6), []
    null, ends = Candidate((), fit, 0.0), iter([1e4, 2.0, 1e4])
    monkeypatch.setattr(attempt, "_with", lambda *given, **_: begun.append(given) or replace(fit, misfit=1e4))
    monkeypatch.setattr(attempt, "_attempt", lambda *_: replace(fit, misfit=next(ends)))
    monkeypatch.setattr(attempt, "_refined", lambda level, fit: fit)
    assert from_starts(level, null, relaxation, 0.0) is not None
    assert begun == []
    place = GridPlace("relaxation", relaxation.additions(level.scales, 0.2), 20.0, beside=fit.solution.values)
    other = replace(level, shared_water=not fit.shared_water)
    assert attempt._from_place(other, null, relaxation, place).misfit == 1e4
    assert len(begun) == 1  # in growing windows from starts of its own: nothing that stands is where the step says


def test_no_law_begins_at_no_size_that_nothing_small_leads_to():
    level = make_level([member("short", SHORT[:1], 7200)])
    null = Candidate((), stands(level), 0.0)
    for name in ("presliding", "drag_exponent", "time_shift"):
        suspect = found(name)
        assert attempt._from_nothing(level, null, suspect, suspect.starts(level.scales)[0]) is None


def test_a_vague_memory_is_distinct_from_zero_by_its_stiffness_beside_its_time():
    """A short memory is known by stiffness times time alone: each of them is vague, and it is there."""
    memory, level = found("relaxation"), make_level([member("short", SHORT, 7300, (
        (registry.find("relaxation", time_s=0.035), 10000.0),
    ))])  # fmt: skip
    null = Candidate((), stands(level), 0.0)
    fit = from_starts(level, null, memory, 0.0).fit
    name, inner = "relaxation.stiffness_N_per_m", "relaxation.time_s"
    value, error = fit.value(name), fit.solution.stderr(name)
    beside = candidate._error_beside(fit, name, [inner])
    at = [fit.solution.problem.names.index(n) for n in (name, inner)]
    both = np.linalg.inv(fit.solution.covariance[np.ix_(at, at)])
    assert beside == pytest.approx(both[0, 0] ** -0.5, rel=1e-6)
    assert candidate._error_beside(fit, name, []) == pytest.approx(error)
    assert value / error < SIGNIFICANT < value / beside
    assert candidate.doubt(level, fit, null.fit) == ""
