"""Records that show no free decay are told from those that do, at any speed; what they show is said."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import undertow
from tests.decays import Decay, exact
from undertow.conditioning.condition import condition
from undertow.conditioning.decaying import after_hold, hold_not_cut, refuse_no_decay, why_no_decay
from undertow.conditioning.motion import Window
from undertow.conditioning.period import dominant_period
from undertow.conditioning.release import find_window, half_period
from undertow.conditioning.swings import find_swings
from undertow.errors import RecordingError
from undertow.front.simulation import simulate
from undertow.recording.recording import Recording

Array = NDArray[np.float64]

FREQUENCIES_HZ = (0.05, 1.0, 300.0)
SIZE_M = 1.8
PERIODS, SAMPLES = 12.0, 50.0
HELD = 2.0
"""Periods held before a release."""


def axis(samples: float = SAMPLES, periods: float = PERIODS) -> Array:
    """Instants of a record in periods, (n,)."""
    return np.arange(round(periods * samples)) / samples


def free(t: Array, damping: float = 0.02, held: float = HELD) -> Array:
    """A release after a hold, over its size, at instants in periods."""
    since = np.maximum(t - held, 0.0)
    return np.exp(-damping * 2.0 * np.pi * since) * np.cos(2.0 * np.pi * since)


def softer_to_one_side(t: Array) -> Array:
    """Let go on a spring that hardly pushes back on one side, x'' + x - x^2 = 0 near x = 1: half of a period is spent
    beyond half its deflection there."""
    length = 8.65  # of a period, in units of the spring's own time
    size = brentq(lambda x: x**2 / 2.0 - x**3 / 3.0 - 0.99 / 6.0, 0.0, 1.0)
    since = length * np.maximum(t - HELD, 0.0)
    return solve_ivp(lambda _, y: [y[1], y[0] ** 2 - y[0] - 2e-4 * y[1]], (0.0, since[-1]), [size, 0.0],
                     t_eval=np.unique(since), rtol=1e-9).y[0][np.searchsorted(np.unique(since), since)] / size


def record(shape: Array, frequency: float = 1.0, samples: float = SAMPLES, noise: float = 2e-3) -> Recording:
    """A record of that shape, with noise."""
    time = np.arange(shape.size) / (samples * frequency)
    x = SIZE_M * (shape + noise * np.random.default_rng(1).standard_normal(shape.size))
    return Recording("r1", time, {"displacement": x})


def said_of(recording: Recording) -> str:
    """Why a record is not used, as a campaign says it; empty where it is."""
    try:
        window = find_window(recording)
        refuse_no_decay(recording, window)
        dominant_period(condition(recording, window=window))
    except ValueError as reason:
        return why_no_decay(recording) or str(reason)
    return ""


T = axis()
TURNS = 2.0 * np.pi * T
NO_DECAY = {
    "driven": (np.sin(TURNS) + 0.3, r"its amplitude declines by .* % in 11\.5 periods and no hold is seen before"),
    "three driven periods": (np.sin(TURNS)[:175], r"its amplitude declines by .* % in 3 periods and no hold is seen"),
    "driven from rest": ((1.0 - np.exp(-0.3 * np.maximum(T - 2.0, 0.0))) * np.sin(TURNS),
                         r"declines by -.* % in|its swings grow from"),
    "growing": (0.02 * np.exp(0.05 * TURNS) * np.cos(TURNS), r"its swings grow from .* to .* m at .* s: something"),
    "growing after a hold": (
        np.where(T < HELD, 0.1, 0.1 * np.exp(0.25 * (T - HELD)) * np.cos(TURNS)), r"its swings grow from .* to"),
    "stuck": (np.where(T < HELD, 1.0, np.where(T < 2.3, 0.6 + 0.4 * np.cos((T - 2.0) * 10.5), 0.2)),
              r"it moves from 1\.8 to 0\.36 m at .* s and stays there without swinging: friction or damping stops it"),
    "over-damped": (np.where(T < HELD, 1.0, np.exp(-3.1 * (T - HELD)) * (1.0 + 3.1 * (T - HELD))),
                    r"it moves from 1\.8 to -?0\.0.* m at .* s and stays there without swinging"),
    "chopped after 0.7 periods": (free(T)[:135], r"it turns once between .* s, where it begins to move, and"),
    "chopped after 1.2 periods": (free(T)[:160], r"it turns 2 times between .*; a decay needs 3 turns: record longer"),
    "chopped without a hold": (free(T, held=0.0)[:35], r"it turns once between .*; a decay needs 3 turns"),
    "drifting": (free(T, held=0.0) + 4.0 * T / PERIODS, r"what it swings about moves by .* m between .* and it"),
    "driven and drifting": (np.cos(TURNS) + 4.0 * T / PERIODS, r"what it swings about moves by .* a sensor that"),
    "jumping": (free(T, held=0.0) + 1.0 * (T > 7.26), r"what it swings about moves by"),
    "caught": (np.where(T < 9.0, free(T, held=0.0), 2.5), r"and ends at 4\.5 m, further away than it ever swung"),
    "caught by hand": (np.where(T < 7.9, free(T), 0.0), r"it swings by .* m at .* s, each swing .* m less than the "
                       r"one before, and lies still from .* s on: it was caught or stopped; set trials\.window\.end_s"),
    "held again": (np.where(T < 8.0, free(T), np.where(T < 9.5, 0.9, 0.9 * free(T - 9.5, held=0.0))),
                   r"it stays on one side for .* from .* s on, and a swing of .* it is held again; set trials\.window"),
    "held again for less than half a period": (
        np.where(T < 8.0, free(T), np.where(T < 8.44, 0.9, 0.9 * free(T - 8.44, held=0.0))),
        r"it stays on one side for .* from .* s on, and a swing of .* it is held again; set trials\.window"),
    "pulled out slowly again": (
        np.where(T < 8.0, free(T), np.where(T < 10.0, 0.45 * (T - 8.0), 0.9 * free(T - 10.0, held=0.0))),
        r"it stays on one side for .* from .* s on, and a swing of .* it is held again; set trials\.window"),
    "never let go": (1.0 + 1e-3 * T, r"it goes from .* to .* m and never turns: the record ends"),
}  # fmt: skip
DECAYS = {
    "released": free(T),
    "released with hardly any damping": free(T, 5e-4),
    "in mid-motion": free(T, 3e-3, held=0.0),
    "in mid-motion with hardly any damping": free(T, 8e-4, held=0.0),
    "strongly damped": free(T, 0.2),
    "beating": 0.5 * np.exp(-0.12 * np.maximum(T - HELD, 0.0))
    * (np.cos(0.95 * TURNS - 0.95 * 2.0 * np.pi * HELD) + np.cos(1.08 * TURNS - 1.08 * 2.0 * np.pi * HELD)),
    "two periods and the record ends at a turn": free(T)[:210],
}  # fmt: skip
DECAYS["beating"] = np.where(T < HELD, 1.0, DECAYS["beating"])
DECAYS["softer to one side"] = softer_to_one_side(T)
DECAYS["beating at once beside a nearly tuned body"] = np.where(
    T < HELD, 1.0,
    0.5 * np.exp(-0.05 * np.maximum(T - HELD, 0.0))
    * (np.cos(0.8 * 2.0 * np.pi * (T - HELD)) + np.cos(1.25 * 2.0 * np.pi * (T - HELD))),
)  # fmt: skip


@pytest.mark.parametrize("frequency", FREQUENCIES_HZ)
@pytest.mark.parametrize("name", NO_DECAY)
def test_what_is_no_decay_is_recognised(name, frequency):
    shape, sentence = NO_DECAY[name]
    assert re.search(sentence, said_of(record(shape, frequency))), said_of(record(shape, frequency))


def test_a_body_that_friction_stops_after_two_turns_is_not_said_to_have_stayed():
    """It swung by 49, -14.6 and 3.7 mm, and was said to stay without swinging."""
    law = {"stiffness": 4000.0, "viscous_damping": 443.0, "coulomb_friction": 2.0}
    run = simulate(law, x0=0.0494, mass_kg=100.0, rate_hz=100.0, duration_s=5.0)
    x = np.concatenate([np.full(100, run.x[0]), run.x]) + 1e-4 * np.random.default_rng(1).standard_normal(600)
    said = said_of(Recording("r1", np.arange(600) / 100.0, {"displacement": x}))
    assert re.search(r"it turns 2 times .* s, where it lies still; a decay needs 3 turns: release it from", said)


def test_of_several_holds_the_first_is_named():
    long = axis(50.0, 36.0)
    shape = free(long)
    for begins, held in ((12.0, 1.5), (24.0, 1.7)):
        released = begins + held
        shape = np.where(long < begins, shape, np.where(long < released, 1.0, free(long, held=released)))
    said = said_of(record(shape, 1.0))
    assert re.search(r"from 1[12][0-9.]* s on, and 1 times more, .* set trials\.window\.end_s before 1[12]", said), said


@pytest.mark.parametrize("frequency", FREQUENCIES_HZ)
@pytest.mark.parametrize("name", DECAYS)
def test_a_decay_is_used(name, frequency):
    noise = 2e-4 if "hardly" in name else 2e-3
    assert said_of(record(DECAYS[name], frequency, noise=noise)) == ""


@pytest.mark.parametrize("frequency", FREQUENCIES_HZ)
@pytest.mark.parametrize("samples", [3.0, 5.0, 6.5])
def test_a_rate_too_low_for_the_motion_is_said_with_the_rate_that_is_needed(samples, frequency):
    shape = free(axis(samples, 22.0))
    said = said_of(record(shape, frequency, samples))
    assert f"has {samples:.1f} samples a period" in said
    assert f"record at {16.0 * frequency:.2g} Hz or more" in said
    assert said_of(record(free(axis(12.0, 22.0)), frequency, 12.0)) == ""


@pytest.mark.parametrize(("kind", "name"), [("damping", "driven"), ("hold", "drifting")])
def test_a_doubt_that_is_accepted_does_not_refuse(kind, name):
    recording = record(NO_DECAY[name][0])
    window = find_window(recording)
    with pytest.raises(RecordingError, match=rf"trial r1: .*list {kind} in recordings\.accept"):
        refuse_no_decay(recording, window)
    refuse_no_decay(recording, window, accepted=(kind,))


@pytest.mark.parametrize("frequency", FREQUENCIES_HZ)
def test_a_beat_that_goes_on_to_the_end_has_the_bodys_period(frequency):
    """Only the maxima of the beat stand out of what the record's end still does; their distance is no period."""
    decay = Decay(frequency, 38.2, damping=0.00436, second=0.39, held=0.0)
    for periods in np.arange(20.0, 27.0, 0.25):
        time, channels = exact(replace(decay, periods=periods))
        half = half_period(time, channels["displacement"], 1e-5)
        assert half * frequency == pytest.approx(0.5, rel=0.1)  # a second mode moves single crossings


@pytest.mark.parametrize("samples", [200, 210])
def test_a_record_that_ends_at_a_turn_is_cut_at_its_release(samples):
    """Where it ends is as far from the middle as where it was held."""
    window = find_window(record(free(T)[:samples]))
    assert window.held
    assert window.release_s == pytest.approx(HELD, abs=0.01)


def test_a_decline_that_says_nothing_of_damping_is_none_however_well_it_is_known():
    said = said_of(record(np.exp(-3e-4 * T) * np.sin(TURNS), noise=1e-6))
    assert re.search(r"its amplitude declines by 0\.3\d* % in 11\.5 periods and no hold is seen before", said), said


def test_what_follows_an_end_that_was_asked_for_does_not_count():
    recording = record(NO_DECAY["caught"][0])
    window = find_window(recording, end_s=8.9)
    with pytest.raises(RecordingError, match=r"it was caught or moved; end trials\.window at 8\."):
        refuse_no_decay(recording, find_window(recording))
    refuse_no_decay(recording, window, end_s=8.9)


def test_swings_about_a_place_that_drifts_are_never_called_no_crossings():
    shape = np.where(T < 9.5, np.cos(TURNS), np.cos(TURNS)) + 8.0 * T / PERIODS
    assert "crossings" not in said_of(record(shape))
    seen = find_swings(T, shape, 1e-4)
    assert abs(seen.half_period_s - 0.5) < 0.04  # a slope of two thirds of the motion moves turns by 0.03


@pytest.mark.parametrize("frequency", FREQUENCIES_HZ)
def test_a_body_that_stops_within_one_swing_is_released_from_its_hold(frequency):
    """Damped to one overshoot; it then lies still, and its sensor drifts by a percent until the record ends."""
    since = np.maximum(T - HELD, 0.0)
    shape = np.exp(-3.0 * since) * (np.cos(2.0 * np.pi * since) + 0.48 * np.sin(2.0 * np.pi * since))
    shape = np.where(since > 0.75, -0.05, shape) + 0.002 * np.maximum(since - 0.75, 0.0)
    window = find_window(record(shape, frequency, noise=1e-4))
    assert window.held
    assert window.release_s * frequency == pytest.approx(HELD, abs=0.05)


def test_the_pause_of_a_beat_is_no_half_period():
    """Crossings half a period apart and two: an oscillator takes the motion up and gives it back."""
    side = np.select([T < 0.5, T < 1.0, T < 3.0, T < 3.5], [1.0, -1.0, 0.5, -0.5], 0.0)
    assert half_period(T, side, 1e-6) == pytest.approx(0.5, abs=0.03)  # of 0.5 and 2.0
    even = np.select([T < 0.5, T < 1.0, T < 1.6, T < 2.1], [1.0, -1.0, 0.5, -0.5], 0.0)
    assert half_period(T, even, 1e-6) == pytest.approx(0.55, abs=0.03)  # of 0.5 and 0.6 the middle


def test_the_period_of_a_motion_that_drifts_is_that_of_its_turns():
    recording = record(free(T, held=0.0) + 0.5 * T**2 / PERIODS)
    window = find_window(recording)
    motion = condition(recording, window=window)
    assert dominant_period(motion) == pytest.approx(1.0, rel=0.05)


@pytest.mark.parametrize("start", [0.5, 1.2])
@pytest.mark.parametrize("frequency", FREQUENCIES_HZ)
def test_a_window_that_begins_in_a_hold_is_moved_to_the_release(frequency: float, start: float) -> None:
    pulled = np.where(T < 0.4, T / 0.4, free(T))  # the hold lasts from .4 to 2 periods
    recording = record(pulled, frequency)
    levels = {"displacement": 2e-3 * SIZE_M}
    window = find_window(recording, start_s=start / frequency)
    held = hold_not_cut(recording, window, levels)
    assert held is not None
    moved = after_hold(recording, window, held, None, levels)
    assert moved is not None
    assert moved.held
    assert moved.release_s * frequency == pytest.approx(HELD, abs=0.05)
    assert hold_not_cut(recording, moved, levels) is None
    assert f"and the trial used from {moved.start_s:.4g} s on; set trials" in held.sentence(moved.start_s)


def test_a_hold_in_the_window_is_doubted_with_the_start_that_cuts_it_off():
    recording = record(free(T, held=1.5))
    window = find_window(recording, start_s=0.0)
    seen = hold_not_cut(recording, window)
    assert seen is not None
    said = seen.sentence(None)
    assert "a hold before the release seems not to be cut off; set trials.window.start_s near 1.5" in said
    assert seen.end_s == pytest.approx(1.5, abs=0.05)  # friction and damping move half a swing by so much
    gyro = Recording("r1", recording.time, {"velocity": np.gradient(free(T, held=1.5), recording.time)})
    stood = hold_not_cut(gyro, find_window(gyro, start_s=0.0))
    assert stood is not None
    assert stood.end_s == pytest.approx(1.5, abs=0.05)
    assert hold_not_cut(recording, find_window(recording)) is None
    assert hold_not_cut(record(free(T, held=0.0)), find_window(recording, start_s=0.0)) is None


def test_a_hold_that_the_window_begins_with_is_no_second_one():
    held = record(free(T))
    refuse_no_decay(held, Window(0.0, 0.0, float(held.time[-1])))


@pytest.mark.parametrize("end", [7.0, 10.0], ids=["it swings on", "smaller swings came after"])
def test_a_window_that_ends_elsewhere_shows_nobody_who_catches(end):
    shape = free(T) if end == 7.0 else np.where(T < 6.0, free(T), np.where(end > T, 0.05 * np.cos(TURNS), 0.0))
    refuse_no_decay(record(shape), Window(HELD, HELD, end, held=True))


def test_a_body_that_stops_at_its_last_small_swings_is_not_caught():
    refuse_no_decay(record(np.where(T < 9.9, free(T, 0.04), 0.0)), Window(HELD, HELD, 10.3, held=True))


def test_a_body_whose_last_swings_were_too_small_to_be_seen_is_not_caught():
    water = {"added_mass": 1271.0, "quadratic_drag": 3924.0}
    slosh = {"mass_kg": 260.0, "natural_frequency_rad_per_s": 6.4, "damping_ratio": 0.01}
    body = {"stiffness": 109600.0, "viscous_damping": 590.0, "coulomb_friction": 150.0, **water}
    run = undertow.simulate(
        {**body, "hidden_resonator": slosh}, x0=0.06, mass_kg=2637.4, rate_hz=40.0, duration_s=12.0
    )  # fmt: skip
    recording = run.recorded(noise_m=3e-4, seed=1, name="r1")
    refuse_no_decay(recording, find_window(recording))


@pytest.mark.parametrize(
    ("sizes", "caught"),
    [
        ((1.0, 0.9, 0.6, 0.3, 0.29, 0.285, 0.28, 0.275, 0.27, 0.265), False),
        ((1.0, 0.97, 0.94, 0.91, 0.88, 0.85, 0.82, 0.79), True),
    ],
    ids=["it beats", "it lost as much in every swing"],
)
def test_a_body_is_caught_where_it_stops_in_a_swing_larger_than_any_swing_lost(sizes, caught):
    turns = 2.0 * np.maximum(T - HELD, 0.0)
    swing = np.minimum(turns.astype(int), len(sizes))
    shape = np.array([*sizes, 0.0])[swing] * np.cos(np.pi * turns)
    recording = record(np.where(turns < len(sizes) - 0.5, shape, 0.0))
    if caught:
        with pytest.raises(RecordingError, match="it was caught or stopped"):
            refuse_no_decay(recording, find_window(recording))
    else:
        refuse_no_decay(recording, find_window(recording))
