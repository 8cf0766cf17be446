"""Mistakes planted in decays of any size, speed, rate and noise are found; where nothing is wrong nothing is said."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from tests.decays import STIFFNESS_N_PER_M, Decay, Mistake, any_decay, exact, recorded, replaced, times
from undertow.conditioning.agreement import Disagreement, disagreements
from undertow.conditioning.band import band_of
from undertow.conditioning.motion import Window
from undertow.conditioning.pairs import Stated
from undertow.conditioning.release import find_window

XA = ("displacement", "acceleration")
XVA = ("displacement", "velocity", "acceleration")
VA = ("velocity", "acceleration")
XF = ("displacement", "spring_force")
XAF = ("displacement", "acceleration", "spring_force")

G_M_PER_S2 = 9.80665
TRIALS = 20
FOUND = 19
"""At least so many of them are named rightly; all of them are seen."""


def found_in(
    decay: Decay, names: tuple[str, ...], mistake: Mistake | None = None, units: Mapping[str, str] | None = None,
    specimen: bool = False,
) -> tuple[Disagreement, ...]:  # fmt: skip
    """What is said of a decay with a mistake."""
    recording = recorded(decay, names, mistake)
    known = (decay.mass_kg, STIFFNESS_N_PER_M) if specimen else (math.nan, math.nan)
    return disagreements(recording, find_window(recording), Stated(units or {}, *known, wet=False))


def decays(name: str, count: int = TRIALS) -> list[Decay]:
    """Decays of any body, other ones for every name; none near 1 rad/s, where x and x'' are as large in SI."""
    rng = np.random.default_rng(sum(map(ord, name)))
    drawn = (any_decay(rng) for _ in range(2 * count))
    return [one for one in drawn if abs(math.log(one.rate)) > 0.2][:count]


def silent(decay: Decay, time: np.ndarray, channels: Mapping[str, np.ndarray]) -> np.ndarray:
    """An accelerometer that was not connected: noise alone."""
    largest = np.max(np.abs(channels["acceleration"]))
    return decay.noise * largest * np.random.default_rng(decay.seed).standard_normal(time.size)


def elsewhere(decay: Decay, time: np.ndarray, channels: Mapping[str, np.ndarray]) -> np.ndarray:
    """The acceleration of another body, which swings faster."""
    since = np.maximum(time - decay.held / decay.frequency_hz, 0.0)
    largest = np.max(np.abs(channels["acceleration"]))
    return largest * np.exp(-0.02 * decay.rate * since) * np.cos(1.31 * decay.rate * time)


def late(angle: float) -> Mistake:
    """An accelerometer whose clock is so many radians of the motion late."""
    return replaced(acceleration=lambda d, t, c: np.interp(t - angle / d.rate, t, c["acceleration"]))


CERTAIN = {
    "acceleration in g labelled m/s^2": (XA, times(acceleration=1.0 / G_M_PER_S2), {}, "unit", "to be in g, not m/s^2"),
    "acceleration in m/s^2 labelled g": (
        XA, times(acceleration=G_M_PER_S2), {"acceleration": "g"}, "unit", "acceleration seems to be in m/s^2, not g"),
    "millimetres labelled m": (XA, times(displacement=1e3), {}, "unit", "displacement seems to be in mm, not m"),
    "metres labelled mm": (
        XA, times(displacement=1e-3), {"displacement": "mm"}, "unit", "displacement seems to be in m, not mm"),
    "centimetres labelled m": (XA, times(displacement=1e2), {}, "unit", "displacement seems to be in cm, not m"),
    "time in ms labelled s": (XA, times(time=1e3), {}, "unit", "time seems to be in ms, not s"),
    "time in s labelled ms": (XA, times(time=1e-3), {"time": "ms"}, "unit", "time seems to be in s, not ms"),
    "time in ms, three channels": (XVA, times(time=1e3), {}, "unit", ": time seems to be in ms, not s; correct"),
    "velocity in mm/s labelled m/s": (VA, times(velocity=1e3), {}, "unit", "velocity seems to be in mm/s, not m/s"),
    "kilonewtons labelled N": (XF, times(spring_force=1e-3), {}, "unit", "spring_force seems to be in kN, not N"),
    "kilonewtons beside an accelerometer": (
        XAF, times(spring_force=1e-3), {}, "unit", ": spring_force seems to be in kN, not N"),
    "millimetres labelled m beside g": (
        XA, times(displacement=1e3, acceleration=1.0 / G_M_PER_S2), {}, "unit",
        "acceleration seems to be in g, not m/s^2, and displacement in mm, not m; correct recordings.channels.accel"),
    "milliseconds labelled s beside g": (
        XA, times(time=1e3, acceleration=1.0 / G_M_PER_S2), {}, "unit",
        "acceleration seems to be in g, not m/s^2, and time in ms, not s"),
    "acceleration turned over": (XA, times(acceleration=-1.0), {}, "sign", "sign of acceleration seems turned over"),
    "displacement turned over": (XVA, times(displacement=-1.0), {}, "sign", ": the sign of displacement seems turned"),
    "load cells turned over": (XF, times(spring_force=-1.0), {}, "sign", "sign of spring_force seems turned over"),
    "a gain of 1.6": (XA, times(acceleration=1.6), {}, "gain", r"times what it should be"),
    "one load cell of two": (XAF, times(spring_force=0.5), {}, "gain", "is one of two load cells not mapped?"),
    "columns swapped": (
        XA, replaced(displacement=lambda d, t, c: c["acceleration"], acceleration=lambda d, t, c: c["displacement"]),
        {}, "unit", "the columns of displacement and acceleration seem swapped"),
    "accelerometer not connected": (XA, replaced(acceleration=silent), {}, "gain", "shows nothing of the motion"),
    "another body's accelerometer": (XA, replaced(acceleration=elsewhere), {}, "gain", "do not belong together"),
    "a velocity as acceleration": (
        XA, replaced(acceleration=lambda d, t, c: c["velocity"]), {}, "clock", "another quantity"),
}  # fmt: skip
DOUBTS = {
    "a gain of 1.15": (XA, times(acceleration=1.15), "gain", "more than 3 % off is doubted"),
    "a gain of 0.85, three channels": (XVA, times(velocity=0.85), "gain", "more than 3 % off is doubted"),
    "a clock late by 0.35 rad": (XA, late(0.35), "clock", "acceleration is 0.3. rad of the motion later than displ"),
}
SPECIMEN = {"kilonewtons labelled N", "kilonewtons beside an accelerometer", "one load cell of two"}


@pytest.mark.parametrize("name", CERTAIN)
def test_a_planted_contradiction_is_found_and_named(name):
    names, mistake, units, kind, text = CERTAIN[name]
    seen = [found_in(decay, names, mistake, units, name in SPECIMEN) for decay in decays(name)]
    assert all(any(one.certain for one in f) for f in seen)
    right = [len(f) == 1 and f[0].kind == kind and text in f[0].sentence for f in seen]
    assert sum(right) >= FOUND, [f for f, ok in zip(seen, right, strict=True) if not ok]


def test_two_wrong_units_that_fit_better_than_one_are_named_before_it():
    """Centimetres labelled m beside an acceleration in g differ from millimetres beside m/s^2 by 2 %."""
    mistake = times(displacement=1e2, acceleration=1.0 / G_M_PER_S2)
    clean = Decay(1.0, size_m=0.1, friction=0.005, noise=1e-4, seed=3)
    (found,) = found_in(clean, XA, mistake, {"displacement": "m", "acceleration": "m/s^2", "time": "s"})
    two = "acceleration seems to be in g, not m/s^2, and displacement in cm, not m"
    assert f": {two} or displacement seems to be in mm, not m; correct" in found.sentence
    (found,) = found_in(clean, XA, times(displacement=1e3))
    assert "displacement seems to be in mm, not m; correct" in found.sentence
    assert "not m/s^2, and" not in found.sentence


def test_a_force_as_acceleration_contradicts_whatever_its_factor():
    mistake = replaced(acceleration=lambda d, t, c: 1e3 * c["spring_force"])
    seen = [found_in(decay, XA, mistake) for decay in decays("a force as acceleration")]
    assert all(any(one.certain for one in found) for found in seen)
    named = [f for found in seen for f in found if "is a column another quantity (a force" in f.sentence]
    assert len(named) >= 0.8 * len(seen)  # its factor may be that of a unit by chance


@pytest.mark.parametrize("name", DOUBTS)
def test_a_planted_doubt_is_found_and_is_no_contradiction(name):
    names, mistake, kind, text = DOUBTS[name]
    seen = [found_in(decay, names, mistake) for decay in decays(name)]
    right = [len(f) == 1 and f[0].kind == kind and not f[0].certain for f in seen]
    assert sum(right) >= FOUND, [f for f, ok in zip(seen, right, strict=True) if not ok]
    assert re.search(text, next(f[0].sentence for f, ok in zip(seen, right, strict=True) if ok))


@pytest.mark.parametrize("names", [XA, XVA, XAF, VA, XF])
def test_nothing_is_said_of_clean_trials(names):
    rng = np.random.default_rng(5)
    drawn = decays(" ".join(names), 40)
    gains = [times(**{name: 1.0 + 0.005 * rng.standard_normal() for name in names}) for _ in drawn]
    seen = [found_in(d, names, gain, specimen=not d.second) for d, gain in zip(drawn, gains, strict=True)]
    assert [f for found in seen for f in found if f.certain] == []
    assert sum(bool(found) for found in seen) <= 1  # of 40: 2 % of 200 in all


@pytest.mark.parametrize(("names", "mistake"), [
    (XA, times(acceleration=1.0 / G_M_PER_S2)), (XAF, times(spring_force=-1.0)), (XA, late(0.35)), (XA, None),
])  # fmt: skip
def test_the_answer_is_the_same_for_a_slow_large_body_and_a_fast_small_one(names, mistake):
    said = []
    for frequency, size in ((0.05, 10.0), (1.0, 0.1), (300.0, 1e-6)):
        found = found_in(Decay(frequency, size_m=size, friction=0.005, noise=3e-3, seed=3), names, mistake)
        said.append([(f.kind, f.channels, round(f.factor, 3), f.certain) for f in found])
    assert said[0] == said[1] == said[2]


def test_mass_and_stiffness_tell_the_unit_of_time_without_a_second_channel():
    decay = Decay(2.0, noise=1e-3)
    (found,) = found_in(decay, ("displacement",), times(time=1e3), specimen=True)
    assert (found.kind, found.certain) == ("unit", True)
    assert "stated stiffness over stated mass is 1000000 times" in found.sentence
    assert "time seems to be in ms, not s" in found.sentence
    assert found_in(decay, ("displacement",), specimen=True) == ()


def test_a_mass_three_times_too_small_is_a_period_that_contradicts():
    decay = Decay(2.0, noise=1e-3)
    recording = recorded(decay, ("displacement",))
    stated = Stated({}, decay.mass_kg / 3.0, STIFFNESS_N_PER_M, wet=False)
    (found,) = disagreements(recording, find_window(recording), stated)
    assert (found.kind, found.certain) == ("period", True)
    assert "specimen.mass_kg is 0.333 times what it should be" in found.sentence


def test_water_that_moves_along_is_no_contradiction():
    decay = Decay(2.0, noise=1e-3)
    recording = recorded(decay, XF)
    stated = Stated({}, decay.mass_kg / 5.0, STIFFNESS_N_PER_M, wet=True)  # added mass of four times the body's
    assert disagreements(recording, find_window(recording), stated) == ()


def test_load_cells_are_held_against_the_mass_where_no_stiffness_is_stated():
    decay = Decay(2.0, noise=1e-3)
    recording = recorded(decay, XF, times(spring_force=1e-3))
    for wet in (False, True):
        stated = Stated({"spring_force": "N"}, decay.mass_kg, wet=wet)
        (found,) = disagreements(recording, find_window(recording), stated)
        assert (found.kind, found.certain) == ("unit", True)
        assert "spring_force seems to be in kN, not N" in found.sentence


@pytest.mark.parametrize(
    ("mistake", "mass", "first"),
    [({}, 10.0, "specimen.mass_kg"), ({"spring_force": 1.0 / 9.80665}, 1.0, "recordings.channels.spring_force.unit")],
)
def test_a_mass_with_its_point_misplaced_is_told_from_kilograms_force(mistake, mass, first):
    decay = Decay(2.0, noise=1e-3)
    recording = recorded(decay, XF, times(**mistake))
    stated = Stated({"spring_force": "N"}, mass * decay.mass_kg, wet=False)
    (found,) = disagreements(recording, find_window(recording), stated)
    assert (found.kind, found.certain) == ("unit", True)
    assert "specimen.mass_kg is 10 times what it should be" in found.sentence
    assert "spring_force seems to be in kgf, not N" in found.sentence
    assert f"; correct {first} or " in found.sentence


def test_a_stiffness_stated_in_kilonewtons_is_named_beside_the_load_cells():
    decay = Decay(2.0, noise=1e-3)
    recording = recorded(decay, XF)
    (found,) = disagreements(recording, find_window(recording), Stated({}, math.nan, 1e-3 * STIFFNESS_N_PER_M))
    assert found.certain
    assert "specimen.stiffness_N_per_m is 0.001 times what it should be" in found.sentence


def test_a_scale_that_is_no_unit_is_not_held_against_an_acceleration_in_size():
    recording = recorded(Decay(2.0, noise=1e-3), XA, times(displacement=37.0))
    window = find_window(recording)
    assert disagreements(recording, window, Stated({"displacement": "%"})) == ()
    assert disagreements(recording, window)[0].certain
    turned = recorded(Decay(2.0, noise=1e-3), XA, times(displacement=-37.0))
    assert disagreements(turned, window, Stated({"displacement": "%"}))[0].kind == "sign"


def test_a_wrong_rate_is_said_by_its_factor():
    recording = recorded(Decay(2.0, noise=1e-3), XVA, times(time=2.0))
    (found,) = disagreements(recording, find_window(recording), Stated({"time": "rate"}))
    assert found.certain
    assert "the time is 2 times what it should be; correct recordings.channels.time.rate_hz" in found.sentence


def test_friction_that_turns_the_acceleration_over_between_two_samples_is_no_gain():
    """At 12 samples a period a sample stands on every turn: the factor is 1.04 with an error of 0.005."""
    decay = Decay(1.0, samples=12.0, damping=0.01, friction=0.06, noise=1e-4, periods=20.0)
    assert found_in(decay, XA) == ()


def test_a_unit_is_named_though_the_gain_is_off_too():
    (found,) = found_in(Decay(2.0, noise=1e-3), XA, times(acceleration=1.06 / G_M_PER_S2))
    assert (found.kind, found.certain) == ("unit", True)
    assert "acceleration seems to be in g, not m/s^2" in found.sentence


def test_a_gain_that_noise_leaves_open_is_a_doubt_and_no_contradiction():
    """45 % off with a standard error of 4 %: 3.75 of them beyond 30 %, where a contradiction needs five."""
    decay = Decay(2.0, samples=14.0, damping=0.12, noise=0.03, periods=8.0, seed=1)
    recording = recorded(decay, XA, times(acceleration=1.45))
    window = find_window(recording)
    (found,) = disagreements(recording, window)
    assert (found.kind, found.certain) == ("gain", False)
    assert disagreements(recorded(replace(decay, noise=1e-3), XA, times(acceleration=1.45)), window)[0].certain


def test_two_mistakes_at_once_are_both_said():
    found = found_in(Decay(2.0, noise=1e-3), XA, times(acceleration=-1.0 / G_M_PER_S2))
    assert {f.kind for f in found} == {"sign", "unit"}
    assert all(f.certain for f in found)


def test_what_no_single_unit_explains_is_said_without_a_guess():
    mistake = times(displacement=7.0, velocity=0.4)
    found = found_in(Decay(2.0, noise=1e-3), XVA, mistake)
    assert any(f.certain and "no unit of one channel explains all that was compared" in f.sentence for f in found)


def test_less_than_a_period_or_eight_samples_of_it_compares_nothing():
    recording = recorded(Decay(1.0, noise=1e-3), XA, times(acceleration=-1.0))
    assert band_of(recording, Window(1.0, 1.02, 1.8)) is None
    assert disagreements(recording, Window(1.0, 1.02, 1.8)) == ()
    few = recorded(Decay(1.0, samples=7.0, noise=1e-3), XA, times(acceleration=-1.0))
    assert disagreements(few, Window(1.0, 1.02, 15.0)) == ()


def test_a_gap_is_left_out_and_not_interpolated():
    decay = Decay(1.0, noise=1e-3, periods=20.0)
    time, channels = exact(decay)
    whole = recorded(decay, XA)
    kept = (time < 6.0) | (time > 8.4)
    gap = type(whole)("r1", whole.time[kept], {n: v[kept] for n, v in whole.channels.items()})
    band = band_of(gap, Window(1.0, 1.02, 20.0))
    assert band is not None
    relation = band.relation("acceleration", "displacement")
    assert abs(relation.size - 1.0) < 0.005
    assert set(channels) >= set(XA)
