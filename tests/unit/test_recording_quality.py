"""Noise, steps, clipping, gaps and spikes on signals whose truth is known; and honest records that must pass."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from tests.decays import any_decay, exact
from undertow.errors import ClippedError, LostValuesError, RecordingError
from undertow.recording.clipping import _goes_beyond, begins_cut, levels, plateaus
from undertow.recording.dropouts import find_dropouts
from undertow.recording.noise import noise, quantum
from undertow.recording.propose import name_and_unit, propose_mapping
from undertow.recording.quality import check, doubts, summary
from undertow.recording.recording import Array, Recording
from undertow.recording.spikes import despike, find_spikes

RATE_HZ = 250.0


def decay(amplitude: float = 0.03, hold_s: float = 0.6, duration_s: float = 15.0) -> tuple[Array, Array]:
    """A hold, a snap release and a free decay at 1.9 Hz: time (s) and displacement (m)."""
    t = np.arange(int(duration_s * RATE_HZ)) / RATE_HZ
    moving = np.maximum(t - hold_s, 0.0)
    return t, amplitude * np.exp(-0.3 * moving) * np.cos(12.0 * moving)


def rounded(values: Array, step: float) -> Array:
    return np.round(values / step) * step


def recording(x: Array, t: Array | None = None, **channels: Array) -> Recording:
    time = np.arange(x.size) / RATE_HZ if t is None else t
    return Recording("r1", time, {"displacement": x, **channels})


@pytest.mark.parametrize("sigma", [2e-5, 2e-4, 1e-3])
@pytest.mark.parametrize("step", [0.0, 2e-5])
def test_noise_is_found_under_a_decay(sigma: float, step: float) -> None:
    _, x = decay()
    values = x + np.random.default_rng(3).normal(0.0, sigma, x.size)
    values = rounded(values, step) if step else values
    # 3750 samples give the median of a high difference to about 3 %; the smallest of seven orders is a little low
    assert noise(values) == pytest.approx(np.hypot(sigma, step / np.sqrt(12.0)), rel=0.15)


def test_a_channel_without_noise_has_that_of_its_rounding() -> None:
    _, x = decay()
    assert noise(rounded(x, 1e-3)) == pytest.approx(1e-3 / np.sqrt(12.0), rel=0.3)


@pytest.mark.parametrize("step", [2.44e-5, 1e-4, 1e-3])
def test_the_finest_step_is_found(step: float) -> None:
    _, x = decay()
    values = x + np.random.default_rng(4).normal(0.0, 3e-5, x.size)
    assert quantum(rounded(values, step)) == pytest.approx(step, rel=0.02)


def test_a_channel_on_no_grid_has_no_step() -> None:
    _, x = decay()
    assert quantum(x + np.random.default_rng(5).normal(0.0, 3e-5, x.size)) == 0.0


@pytest.mark.parametrize("sigma", [0.0, 1e-5, 1e-4])
@pytest.mark.parametrize("step", [0.0, 2.4e-5, 2e-4, 1e-3])
def test_an_honest_snap_release_is_not_called_clipped(sigma: float, step: float) -> None:
    t, x = decay()
    x = x + np.random.default_rng(6).normal(0.0, sigma, x.size) if sigma else x
    said = check(recording(rounded(x, step) if step else x, t))
    assert not any("cut" in doubt for doubt in said)


@pytest.mark.parametrize("sides", ["both", "upper", "lower"])
@pytest.mark.parametrize("step", [0.0, 2.4e-5])
def test_a_clipped_channel_is_refused(sides: str, step: float) -> None:
    t, x = decay()
    x = x + np.random.default_rng(7).normal(0.0, 3e-5, x.size)
    x = rounded(x, step) if step else x
    limit = 0.015
    low, high = (-limit if sides != "upper" else -np.inf), (limit if sides != "lower" else np.inf)
    with pytest.raises(RecordingError, match=r"displacement is clipped between"):
        check(recording(np.clip(x, low, high), t))


@pytest.mark.parametrize("limit", [0.5, 0.7, 0.8])
@pytest.mark.parametrize("sigma", [1e-5, 1e-4])
def test_a_level_under_noise_that_comes_afterwards_is_a_cut(limit: float, sigma: float) -> None:
    t, x = decay(hold_s=0.0)
    rng = np.random.default_rng(9)
    cut = np.clip(x, -0.03 * limit, np.inf) + rng.normal(0.0, sigma, x.size)
    (end,) = levels(cut, noise(cut))
    assert (end.value, end.upper) == (pytest.approx(-0.03 * limit, abs=2 * sigma), False)
    with pytest.raises(ClippedError, match=r"clipped .* swings end at -0.0\d+ m, flat but for noise") as seen:
        check(recording(cut, t))
    assert (seen.value.channel, seen.value.ends) == ("displacement", (end,))


@pytest.mark.parametrize("seed", [*range(6), 103, 167, 362, 432, 619, 662, 872, 1961, 3014, 3942, 3944])
def test_swings_that_nothing_cuts_have_no_level(seed: int) -> None:
    rng = np.random.default_rng(seed)
    t, rate = np.arange(4000) / RATE_HZ, rng.uniform(2.0, 60.0)
    x = np.exp(-rng.uniform(0.0, 0.5) * t) * np.cos(rate * t + rng.uniform(0.0, 6.0))
    x = x + rng.choice([1e-5, 1e-3, 1e-2, 3e-2]) * rng.standard_normal(t.size)
    assert levels(x, noise(x)) == ()
    assert levels(-x, noise(x)) == ()


@pytest.mark.parametrize("samples", [30, 60, 120])
def test_a_level_of_few_samples_that_is_left_at_once_is_a_cut_and_a_peak_of_as_few_is_none(samples: int) -> None:
    seen = 0
    for seed in range(30):
        rng = np.random.default_rng(seed)
        t = np.arange(8 * samples) / samples
        x = np.exp(-rng.uniform(0.1, 0.3) * t) * np.cos(2.0 * np.pi * t + rng.uniform(0.0, 6.0))
        noisy = x + 10.0 ** rng.uniform(-4.0, -2.5) * rng.standard_normal(t.size)
        assert levels(noisy, noise(noisy)) == ()
        cut = np.minimum(x, 0.8 * np.max(x)) + (noisy - x)
        seen += [end.upper for end in levels(cut, noise(cut))] == [True]
    assert seen >= {30: 20, 60: 24, 120: 25}[samples]


def pulled(rng: np.random.Generator, samples: int) -> Array:
    """A pull at constant speed, a hold of up to two periods and a release from rest: displacement of size 1, with noise
    of a ten-thousandth to three thousandths; ``samples`` a period."""
    damping, friction, hold = rng.choice([0.005, 0.03, 0.1]), rng.choice([0.0, 0.02, 0.05]), rng.choice([0.3, 1.0, 2.0])
    t = np.arange(-6 * samples, 10 * samples) / samples + rng.random() / samples
    angle = 2.0 * np.pi * np.maximum(t, 0.0)
    swing = np.exp(-damping * angle) * (np.cos(angle) + damping * np.sin(angle))
    x = np.where(angle < np.pi, friction + (1.0 - friction) * swing, swing)
    x = np.where(t < -hold, np.maximum(1.0 + rng.uniform(0.2, 3.0) * (t + hold), 0.0), x)
    return np.asarray(x + 10.0 ** rng.uniform(-4.0, -2.5) * rng.standard_normal(t.size))


@pytest.mark.parametrize("samples", [20, 40, 120, 400])
def test_a_hold_that_a_winch_comes_to_at_constant_speed_is_no_cut(samples: int) -> None:
    for seed in range(40):
        x = pulled(np.random.default_rng(seed), samples)
        assert levels(x, noise(x)) == (), seed
        exact = rounded(x, 0.003)
        assert plateaus(exact, quantum(exact)) == 0, seed


def test_a_pull_beyond_the_range_is_a_cut_though_a_hold_and_a_release_follow() -> None:
    seen = 0
    for seed in range(40):
        x = pulled(np.random.default_rng(seed), 120)
        cut = np.minimum(x, 0.8) + np.random.default_rng(seed).normal(0.0, 1e-3, x.size)
        seen += [end.upper for end in levels(cut, noise(cut))] == [True]
    assert seen >= 37  # the others are as few where no hold is held against anything


@pytest.mark.parametrize("samples", [30, 120, 400])
def test_a_record_that_begins_cut_is_doubted_and_one_that_begins_with_a_hold_is_not(samples: int) -> None:
    seen, tried = 0, 0
    for seed in range(40):
        rng = np.random.default_rng(seed)
        held = pulled(rng, samples)[5 * samples + samples // 2 :]  # half a period of the hold, where it lasts as long
        if held[0] < 0.9:
            continue
        assert begins_cut(held, noise(held)) is None, seed
        cut = np.minimum(held, 0.8) + rng.normal(0.0, 1e-3, held.size)
        level, lower = begins_cut(cut, noise(cut)), begins_cut(-cut, noise(cut))
        assert (level is None) == (lower is None)
        seen, tried = seen + (level == pytest.approx(0.8, abs=2e-3)), tried + 1
    assert tried > 10
    assert seen > 0.85 * tried  # noise bends a level by two standard deviations in 2 % and slow noise hides some


def test_a_body_that_creeps_back_and_uneven_samples_are_not_said_to_begin_cut() -> None:
    t, x = decay()
    rng = np.random.default_rng(9)
    creeping = 0.03 * np.exp(-2.0 * np.maximum(t - 0.6, 0.0)) + rng.normal(0.0, 3e-5, t.size)
    assert begins_cut(creeping, noise(creeping)) is None
    cut = np.minimum(x, 0.026) + rng.normal(0.0, 3e-5, x.size)
    uneven = t + rng.uniform(-0.3, 0.3, t.size) / RATE_HZ
    assert not any(one.kind == "clipping" for one in doubts(recording(cut, uneven)))


def test_a_hold_beyond_the_sensors_range_is_a_doubt_that_clipping_accepts() -> None:
    t, x = decay()
    noisy = np.minimum(x, 0.026) + np.random.default_rng(9).normal(0.0, 3e-5, x.size)
    (doubt,) = doubts(recording(noisy, t))
    assert (doubt.kind, doubt.channel) == ("clipping", "displacement")
    assert "displacement begins at 0.026" in doubt.sentence
    assert "leaves it at speed: its sensor is cut off there, or the body was pushed" in doubt.sentence


@pytest.mark.parametrize("seed", [36, 168, 266, 384, 387])
def test_noise_that_is_slower_than_the_samples_is_no_level(seed: int) -> None:
    rng = np.random.default_rng(seed)  # of 400 seeds these five passed for cut by the noise from sample to sample alone
    t, rate = np.arange(4000) / 400.0, rng.uniform(8.0, 25.0)
    x = np.exp(-rng.uniform(0.3, 1.0) * t) * np.cos(rate * t)
    slow = rng.standard_normal(t.size)
    for at in range(1, slow.size):
        slow[at] = 0.9 * slow[at - 1] + np.sqrt(1.0 - 0.81) * slow[at]
    assert levels(x + 0.02 * slow, noise(x + 0.02 * slow)) == ()


def test_most_levels_under_slow_noise_are_seen() -> None:
    t, x = decay(hold_s=0.0)
    seen = 0
    for seed in range(60):
        white = np.random.default_rng(seed).standard_normal(t.size + 3)
        cut = np.maximum(x, -0.02) + 1e-4 * np.convolve(white, np.ones(4) / 2.0, "valid")
        seen += [end.upper for end in levels(cut, noise(cut))] == [False]
    assert seen >= 40  # 16 by the noise from sample to sample


def test_a_body_that_is_driven_may_rest_at_its_turns() -> None:
    t, x = decay(hold_s=0.0)
    cut = np.maximum(x, -0.02) + np.random.default_rng(9).normal(0.0, 1e-4, x.size)
    check(recording(cut, t, force=np.sin(7.0 * t)))


def test_an_acceleration_jumps_to_its_extreme_at_the_release_and_is_not_cut() -> None:
    t, x = decay(hold_s=0.6)
    a = np.where(t < 0.6, 0.0, np.clip(-144.0 * x, -2.0, np.inf)) + np.random.default_rng(9).normal(0.0, 1e-2, x.size)
    assert levels(a, noise(a))
    check(recording(x, t, acceleration=a))


def test_a_load_cell_that_saturates_in_the_hold_is_refused() -> None:
    t, x = decay()
    force = rounded(4e5 * x + np.random.default_rng(8).normal(0.0, 20.0, x.size), 5.0)
    with pytest.raises(RecordingError, match=r"spring_force is clipped .* samples in a row do not move"):
        check(recording(x, t, spring_force=np.minimum(force, 11500.0)))


def test_one_cut_peak_is_a_doubt() -> None:
    t, x = decay(hold_s=0.0)
    x = np.maximum(x, -0.025)
    assert plateaus(x, 0.0) == 1
    assert any("one peak looks cut" in doubt for doubt in check(recording(x, t)))


def test_a_constant_channel_is_refused() -> None:
    t, x = decay()
    with pytest.raises(RecordingError, match=r"trial r1: acceleration is constant at 0 m/s\^2"):
        check(recording(x, t, acceleration=np.zeros(x.size)))


@pytest.mark.parametrize("n", [2, 49])
def test_too_few_samples_are_refused(n: int) -> None:
    with pytest.raises(RecordingError, match=f"trial r1 has {n} samples; at least 50"):
        check(recording(np.linspace(0.0, 1.0, n)))


def test_gaps_and_uneven_steps_are_doubts_with_their_numbers() -> None:
    t, x = decay()
    keep = np.r_[0:1000, 1100:1200, 1250 : t.size]
    said = summary(recording(x[keep], t[keep]))
    assert (said.gaps, said.largest_gap_s) == (2, pytest.approx(0.404))
    assert any("2 gaps in time, the longest of 0.404 s" in doubt for doubt in said.doubts)
    uneven = t + np.random.default_rng(9).uniform(-0.3, 0.3, t.size) / RATE_HZ
    assert any("is uneven" in doubt for doubt in check(recording(x, uneven)))


def test_a_channel_of_noise_is_a_doubt() -> None:
    values = np.random.default_rng(10).normal(0.0, 1.0, 2000)
    assert any("less than ten times its noise" in doubt for doubt in check(recording(values)))


def test_a_summary_says_what_check_would_raise() -> None:
    said = summary(recording(np.zeros(100)))
    assert "constant" in said.doubts[0]
    assert said.channels["displacement"].unit == "m"


@pytest.mark.parametrize("length", [1, 2, 3])
def test_spikes_are_found_and_bridged(length: int) -> None:
    _, x = decay()
    truth = x + np.random.default_rng(11).normal(0.0, 3e-5, x.size)
    spoiled = truth.copy()
    places = [300, 1111, 2500]
    for place in places:
        spoiled[place : place + length] += 0.05
    cleaned, count = despike(spoiled, 7)
    assert count == 3 * length
    assert np.max(np.abs(cleaned - truth)) < 1e-3  # a cubic over three samples of a 0.5 s period
    assert np.max(np.abs(spoiled - truth)) == pytest.approx(0.05)


@pytest.mark.parametrize("step", [0.0, 2.4e-5, 1e-3])
def test_peaks_and_the_release_are_no_spikes(step: float) -> None:
    _, x = decay()
    x = x + np.random.default_rng(12).normal(0.0, 3e-5, x.size)
    assert not find_spikes(rounded(x, step) if step else x).any()


def test_despiking_refuses_a_width_or_a_signal_it_cannot_judge() -> None:
    with pytest.raises(RecordingError, match=r"width of 4 samples is not usable"):
        find_spikes(np.zeros(100), 4)
    half = np.where(np.random.default_rng(13).random(1000) < 0.08, 1.0, 0.0) + 1e-6 * np.arange(1000.0)
    with pytest.raises(RecordingError, match=r"of 1000 samples are spikes"):
        despike(half, 7)
    assert not find_spikes(np.zeros(5), 7).any()


def test_names_of_laboratories_are_understood() -> None:
    assert name_and_unit("sensor1[mm]") == ("sensor1", "mm")
    assert name_and_unit("loadcell1_N") == ("loadcell1", "N")
    assert name_and_unit("Force (kN)") == ("Force", "kN")
    endless = "( " * 400_000  # a search for a unit took the square of the name's length: hours
    assert name_and_unit(endless) == (endless, "")


def test_a_mapping_is_proposed_from_names_and_units() -> None:
    t = np.arange(10.0)
    names = ["time_s", "disp_m", "accel_mps2", "loadcell1_N", "loadcell2_N", "temperature_C"]
    proposal = propose_mapping(pd.DataFrame({name: t * (at + 1) for at, name in enumerate(names)}))
    assert proposal.time is not None
    assert proposal.time.column == "time_s"
    assert proposal.channels["displacement"].columns == ("disp_m",)
    assert proposal.channels["acceleration"].unit == "mps2"
    assert proposal.channels["spring_force"].columns == ("loadcell1_N", "loadcell2_N")
    assert proposal.remarks == ("column 'temperature_C' is not mapped",)


def test_a_rows_number_is_not_taken_for_the_time_beside_it() -> None:
    t = np.arange(10.0)
    for first, said in (("nr", "column 'nr' is not mapped"), ("", "a column without a name is not mapped; name it")):
        proposal = propose_mapping(pd.DataFrame({first: t, "t": 0.01 * t, "disp_m": t * t}))
        assert proposal.time is not None
        assert proposal.time.column == "t"
        assert any(said in remark for remark in proposal.remarks)
    alone = propose_mapping(pd.DataFrame({"": t, "disp_m": t * t}))
    assert alone.time is None
    assert "no column looks like time" in alone.remarks[-1]


def test_a_rate_gyro_is_a_rotation_and_its_unit_an_assumption() -> None:
    proposal = propose_mapping(pd.DataFrame({"time": [0.0, 1.0, 2.0], "angular_velocity": [1.0, 0.0, -1.0]}))
    assert proposal.coordinate == "rotation"
    assert proposal.channels["velocity"].unit == "rad/s"
    assert "rad/s is assumed" in proposal.remarks[0]


def test_without_time_a_rate_is_asked_for() -> None:
    proposal = propose_mapping(pd.DataFrame({"x": [1.0, 0.0, -1.0]}), {"x": "mm"})
    assert proposal.time is None
    assert any("rate_hz" in remark for remark in proposal.remarks)


def test_the_jump_of_the_acceleration_at_a_release_is_no_spike() -> None:
    t, x = decay()
    a = np.where(t < 0.6, 0.0, -144.0 * x) + np.random.default_rng(14).normal(0.0, 0.01, t.size)
    assert not find_spikes(a).any()


@pytest.mark.parametrize(("at", "off", "said"), [(400, 0.2, True), (400, 0.01, False), (51, 0.2, False)])
def test_one_sample_far_off_is_said_where_it_is_no_release_and_counts(at: int, off: float, said: bool) -> None:
    t = np.arange(800) * 0.01
    x = np.where(t < 0.5, 0.1, 0.1 * np.exp(-0.2 * (t - 0.5)) * np.cos(10.0 * (t - 0.5)))
    x += 2e-4 * np.random.default_rng(0).normal(size=t.size)
    x[at] += off
    (doubt,) = check(Recording("r", t, {"displacement": x})) or ("",)
    assert (f"one sample looks like a spike, {x[at]:.4g} m at {t[at]:.4g} s; state recordings" in doubt) is said


def test_spikes_are_not_seen_at_the_edges_of_a_gap_in_time() -> None:
    t, x = decay()
    keep = np.r_[0:900, 1020:1500, 1630 : t.size]
    said = summary(recording(x[keep] + np.random.default_rng(15).normal(0.0, 3e-5, keep.size), t[keep]))
    assert said.channels["displacement"].spikes == 0
    assert not any("spikes" in doubt for doubt in said.doubts)


@pytest.mark.parametrize("filled", [0.0, "last", -0.02])
@pytest.mark.parametrize("step", [0.0, 1e-4])
def test_values_that_were_lost_and_filled_are_a_doubt_that_gaps_accepts(filled: float | str, step: float) -> None:
    t, x = decay()
    x = x + np.random.default_rng(16).normal(0.0, 3e-5, x.size)
    x = rounded(x, step) if step else x
    for start in (700, 1310):
        x[start : start + 25] = x[start] if filled == "last" else filled
    (doubt,) = (one for one in doubts(recording(x, t)) if one.kind == "gaps")
    assert doubt.channel == "displacement"
    level = x[700] if filled == "last" else filled
    assert f"displacement stands still 2 times, the longest at {level:.5g} m, from {t[700]:.4g} to" in doubt.sentence
    assert "list gaps in recordings.accept" in doubt.sentence


def test_a_number_that_means_no_value_is_refused_as_such_and_not_as_clipping() -> None:
    t, x = decay()
    for start in (700, 1310):
        x[start : start + 25] = -9999.0
    with pytest.raises(RecordingError, match=r"trial r1: displacement stands still 2 times, the longest at -9999 m"):
        check(recording(x, t))
    assert any("values were lost" in said for said in check(recording(x, t), ("gaps",)))


@pytest.mark.parametrize("places", [[0], [700], [700, 701, 702], [300, 900, 1500], [-3, -2, -1]])
def test_a_number_far_outside_all_others_is_refused_however_few_samples_hold_it(places: list[int]) -> None:
    t, x = decay()
    x[places] = -9999.0
    said = r"trial r1: displacement: \d samples? (is|are) -9999 m, the first at .* s, and all others lie between -0\.02"
    with pytest.raises(LostValuesError, match=said):
        doubts(recording(x, t))
    [doubt] = [one for one in doubts(recording(x, t), ["gaps"]) if one.kind == "gaps"]
    assert "a number far outside the others is written where values were lost" in doubt.sentence


@pytest.mark.parametrize("step", [0.0, 1e-4, 3e-3])
def test_holds_peaks_rests_and_a_slow_sensor_written_several_times_are_no_lost_values(step: float) -> None:
    t, x = decay()
    x[t < 0.6] = x[0]
    x[t > 10.0] = 0.001  # it sticks
    for kept in (1, 6):
        slow = np.repeat(x[::kept], kept)[: x.size]
        assert find_dropouts(rounded(slow, step) if step else slow, step) == []


def test_any_honest_decay_has_no_lost_values() -> None:
    rng = np.random.default_rng(17)
    for _ in range(200):
        planted = any_decay(rng)
        for name, values in exact(planted)[1].items():
            step = float(rng.choice([0.0, 10.0 ** rng.uniform(-4.0, -1.5)])) * float(np.ptp(values))
            kept = rounded(values, step) if step else values
            assert name == "acceleration" or find_dropouts(kept, step) == [], planted


def test_how_far_a_swing_goes_beyond_a_level_is_a_number_where_the_record_ends_on_it() -> None:
    assert np.isfinite(_goes_beyond(np.array([0.2, 0.05, 0.0, 0.0]), 1.0))
    assert _goes_beyond(np.zeros(5), 1.0) == 0.0  # it does not fall
    assert _goes_beyond(np.array([0.0, 0.5, 2.0, 4.5]), 4.0) == pytest.approx(0.0, abs=1e-9)  # from rest
