"""Release, window, fusion, clock, cycles: against exact motions of Eq. 15 and closed forms."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.signal import lfilter

from experiments.eq15_campaign.motion import simulate
from tests.exact_motions import LONG, SHORT, exact_motion
from undertow.conditioning.agreement import disagreements
from undertow.conditioning.condition import condition
from undertow.conditioning.cycles import Cycles, equilibrium, find_cycles
from undertow.conditioning.fusion import fuse
from undertow.conditioning.release import find_window
from undertow.errors import LostValuesError, RecordingError
from undertow.recording.noise import noise
from undertow.recording.recording import Recording

HOLD_S = 0.7


def released(
    body, x0, rate=250.0, sx=5e-5, sa=0.02, drift=0.0, clock_s=0.0, seed=1, channels=("displacement", "acceleration")
):
    """A record of a hold and a release, with noise, drift and a late accelerometer; and when the body stopped."""
    rng = np.random.default_rng(seed)
    time = np.arange(round((HOLD_S + 10.0) * rate)) / rate
    since = time - HOLD_S
    x, a = np.full(time.size, x0), np.zeros(time.size)
    moved = simulate(body, x0, since[since >= 0.0])
    x[since >= 0.0] = moved.x
    late = since + clock_s
    a[late >= 0.0] = simulate(body, x0, late[late >= 0.0]).a
    wander = drift * np.sin(2.0 * np.pi * time / 20.0)
    every = {
        "displacement": x + wander + sx * rng.standard_normal(time.size) + 1e-4,
        "acceleration": a + sa * rng.standard_normal(time.size) + 0.01,
    }
    return Recording("r1", time, {name: every[name] for name in channels}), moved.stopped_s


@pytest.mark.parametrize(("body", "x0"), [(LONG, 0.107), (LONG, 0.018), (SHORT, 0.033), (SHORT, 0.008)])
def test_release_is_found_between_samples(body, x0):
    recording, _ = released(body, x0)
    window = find_window(recording)
    assert window.held
    assert abs(window.release_s - HOLD_S) < 0.003 + window.release_stderr_s  # under a sample of 4 ms


@pytest.mark.parametrize(("body", "x0"), [(LONG, 0.03), (SHORT, 0.016), (SHORT, 0.033)])
def test_stuck_tail_is_cut_although_the_sensor_drifts(body, x0):
    recording, stopped = released(body, x0, drift=2e-4)
    assert stopped is not None
    period = 2.0 * np.pi * (body.inertia_kg / body.k_N_per_m) ** 0.5
    assert abs(find_window(recording).end_s - HOLD_S - stopped) < 0.75 * period


def means_of(recording, count):
    """The recording as a logger that averages ``count`` samples would have stored it."""
    n = recording.time.size // count

    def mean(values):
        return values[: n * count].reshape(n, count).mean(axis=1)

    return Recording(recording.name, mean(recording.time), {c: mean(v) for c, v in recording.channels.items()})


@pytest.mark.parametrize(("body", "x0"), [(LONG, 0.06), (SHORT, 0.016), (SHORT, 0.033)])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_window_is_the_same_at_every_sampling_rate(body, x0, seed):
    fast, _ = released(body, x0, rate=1000.0, sx=2e-4, sa=0.1, drift=2e-4, seed=seed)
    windows = [find_window(recording) for recording in (fast, means_of(fast, 4), means_of(fast, 10))]
    period = 2.0 * np.pi * (body.inertia_kg / body.k_N_per_m) ** 0.5
    starts, ends = [w.start_s - w.release_s for w in windows], [w.end_s for w in windows]
    assert np.ptp(starts) < 1e-3
    assert np.ptp(ends) < 0.05 * period  # a last swing more or less would be half a period


def with_slow_noise(size, until=np.inf, seed=3):
    """A release with displacement noise of first order (.8 a sample), and what its differences show of it."""
    recording, _ = released(LONG, 0.08, sx=1e-7)
    rng = np.random.default_rng(seed)
    slow = lfilter([0.6], [1.0, -0.8], rng.standard_normal(recording.time.size))
    values = recording.channels["displacement"] + np.where(recording.time < until, size, 5e-5) * slow
    made = Recording("r1", recording.time, {**recording.channels, "displacement": values})
    return made, noise(values)


def test_noise_that_is_slow_is_seen_while_the_body_is_held():
    recording, differences = with_slow_noise(2e-4)
    assert differences < 1e-4
    assert condition(recording).noise["displacement"] == pytest.approx(2e-4, rel=0.3)
    levels = {name: noise(values) for name, values in recording.channels.items()}
    alone = Recording("r1", recording.time, {"displacement": recording.channels["displacement"]})
    found = condition(alone, levels=levels).noise  # a channel that was taken away for cause keeps its level
    assert found["displacement"] == pytest.approx(2e-4, rel=0.3)
    assert found["acceleration"] == levels["acceleration"]


def test_white_noise_a_body_that_trembles_and_a_short_hold_say_nothing_more():
    for seed in range(1, 6):  # the scatter of a hold is by chance above what differences show in some of them
        white, _ = released(LONG, 0.08, seed=seed)
        assert dict(condition(white).noise) == {name: noise(values) for name, values in white.channels.items()}
    trembling, differences = with_slow_noise(2e-3, until=HOLD_S)
    assert condition(trembling).noise["displacement"] == differences
    recording, differences = with_slow_noise(2e-4)
    short = Recording("r1", recording.time[150:], {n: v[150:] for n, v in recording.channels.items()})
    found = condition(short, window=find_window(recording)).noise["displacement"]
    assert found == noise(short.channels["displacement"])


def test_a_record_in_mid_motion_has_no_hold():
    t = np.arange(0.0, 30.0, 0.01)
    x = 0.1 * np.exp(-0.05 * t) * np.cos(2.5 * t)
    window = find_window(
        Recording("r", t, {"displacement": x + 1e-6 * np.random.default_rng(0).standard_normal(t.size)})
    )
    assert not window.held
    assert window.start_s == t[0]


@pytest.mark.parametrize("before_s", [0.4, 0.1, -0.03, -0.1])
def test_a_release_in_a_gap_is_refused_and_a_gap_elsewhere_is_not(before_s):
    """A period is missing across the release, or right after it; or later."""
    whole, _ = released(LONG, 0.05)
    half = np.pi / np.sqrt(LONG.k_N_per_m / LONG.inertia_kg)
    at, length = HOLD_S - before_s, 2.0 * half
    lacking = without(whole, at, at + length)
    with pytest.raises(LostValuesError, match=r"no sample between .* s, where the body is let go, and a gap"):
        find_window(lacking)
    assert not find_window(lacking, start_s=at + length).held
    for harmless in (without(whole, 3.0, 3.0 + length), without(whole, HOLD_S, HOLD_S + 0.1 * half)):
        assert find_window(harmless).release_s == pytest.approx(HOLD_S, abs=0.01 * half)


def without(recording, start_s, end_s):
    """A recording without its samples between two instants, s."""
    kept = (recording.time <= start_s) | (recording.time >= end_s)
    channels = {name: values[kept] for name, values in recording.channels.items()}
    return Recording(recording.name, recording.time[kept], channels)


def test_a_record_of_noise_has_no_release():
    noise = 1e-4 * np.random.default_rng(2).standard_normal(2000)
    with pytest.raises(RecordingError, match=r"trial r: no release found: the record moves by .* m with noise of"):
        find_window(Recording("r", np.arange(2000) / 250.0, {"displacement": noise}))


def test_a_window_of_two_samples_is_refused():
    recording, _ = released(LONG, 0.05)
    with pytest.raises(
        RecordingError, match=r"3 samples lie in the motion window 1 to 1\.01 s; identification needs 20"
    ):
        find_window(recording, start_s=1.0, end_s=1.01)


def test_a_record_without_motion_channels_is_refused():
    record = Recording("r", np.arange(100) / 10.0, {"spring_force": np.cos(np.arange(100.0))})
    with pytest.raises(RecordingError, match=r"channels are spring_force; motion needs displacement"):
        find_window(record)


@pytest.mark.parametrize(("sx", "sa"), [(5e-5, 0.02), (2e-4, 0.1), (1e-3, 0.1)])
@pytest.mark.parametrize("rate", [250.0, 1000.0])
def test_fused_motion_is_within_its_stated_errors(sx, sa, rate):
    rng = np.random.default_rng(4)
    motion = exact_motion(LONG, 0.064, rate_hz=rate, duration_s=5.0)
    x = motion.x + sx * rng.standard_normal(motion.t.size)
    a = motion.a + sa * rng.standard_normal(motion.t.size)
    got = fuse(motion.t, {"displacement": x, "acceleration": a}, {"displacement": sx, "acceleration": sa}, (0.0, 0.003))
    inside = (motion.t > 0.1) & (motion.t < 4.0)
    for name in ("x", "v", "a"):
        error = (getattr(got, name) - getattr(motion, name))[inside] / getattr(got, f"{name}_std")[inside]
        assert 0.5 < np.sqrt(np.mean(error**2)) < 1.6  # correlated in time: one draw of a mean square
    assert np.std((got.a - motion.a)[inside]) < 0.9 * sa
    assert np.std((got.x - motion.x)[inside]) < 0.5 * sx


@pytest.mark.parametrize(("clock_s", "way"), [(0.02, "earlier"), (-0.02, "later")])
def test_an_acceleration_that_lags_is_later_in_every_sentence(clock_s, way):
    recording, _ = released(SHORT, 0.033, clock_s=clock_s)
    motion = condition(recording)
    assert re.search(rf"^acceleration is .* ms {way} than displacement at equal", motion.notes[0])
    (found,) = disagreements(recording, motion.window)
    assert f"{way} than displacement" in found.sentence


@pytest.mark.parametrize("clock_s", [0.0, 0.0013])
def test_clock_of_the_accelerometer_is_found(clock_s):
    recording, _ = released(SHORT, 0.033, clock_s=clock_s)
    after = recording.time >= HOLD_S + 0.008
    channels = {name: values[after] for name, values in recording.channels.items()}
    got = fuse(recording.time[after], channels, {"displacement": 5e-5, "acceleration": 0.02}, (0.01, 0.005))
    assert abs(got.clock_s - clock_s) < 4.0 * got.clock_stderr_s
    assert got.clock_stderr_s < 2e-4


def test_displacement_alone_and_velocity_alone_give_a_motion():
    motion = exact_motion(SHORT, 0.03, duration_s=4.0)
    rng = np.random.default_rng(5)
    x_only = fuse(
        motion.t, {"displacement": motion.x + 5e-5 * rng.standard_normal(motion.t.size)}, {"displacement": 5e-5}
    )
    v_only = fuse(motion.t, {"velocity": motion.v + 2e-3 * rng.standard_normal(motion.t.size)}, {"velocity": 2e-3})
    inside = (motion.t > 0.2) & (motion.t < 3.0)
    assert np.std((x_only.v - motion.v)[inside]) < 0.02 * np.std(motion.v[inside])
    assert np.std((v_only.a - motion.a)[inside]) < 0.05 * np.std(motion.a[inside])
    assert np.isnan(x_only.clock_s)


def test_uneven_samples_and_a_gap_are_smoothed_too():
    rng = np.random.default_rng(6)
    motion = exact_motion(LONG, 0.064, rate_hz=250.0, duration_s=5.0)
    keep = (rng.uniform(size=motion.t.size) > 0.2) & ~((motion.t > 2.0) & (motion.t < 2.1))
    got = fuse(
        motion.t[keep],
        {"displacement": motion.x[keep] + 5e-5 * rng.standard_normal(keep.sum())},
        {"displacement": 5e-5},
    )
    assert np.max(np.abs(got.x - motion.x[keep])) < 5e-4  # ten times the noise, in and around the gap


def test_an_accelerometer_alone_is_refused():
    t = np.arange(0.0, 2.0, 0.01)
    with pytest.raises(RecordingError, match=r"recorded are acceleration; .* drifts .*: map displacement or velocity"):
        fuse(t, {"acceleration": np.cos(10.0 * t)}, {"acceleration": 0.01})


def test_fusion_refuses_what_it_cannot_smooth():
    with pytest.raises(RecordingError, match=r"channels recorded are spring_force; motion needs"):
        fuse(np.arange(20.0), {"spring_force": np.zeros(20)}, {"spring_force": 1.0})
    with pytest.raises(RecordingError, match=r"3 samples after the release; smoothing needs 10"):
        fuse(np.arange(3.0), {"displacement": np.zeros(3)}, {"displacement": 1.0})


def test_decrement_and_frequency_of_linear_damping_are_the_closed_form():
    t = np.arange(0.0, 12.0, 0.002)
    w, z = 6.3, 0.02
    wd, b = w * np.sqrt(1 - z * z), z * w
    x = np.exp(-b * t) * np.cos(wd * t)
    v = np.exp(-b * t) * (-b * np.cos(wd * t) - wd * np.sin(wd * t))
    cycles = find_cycles(t, x, v, np.full(t.size, 1e-6))
    assert cycles.frequency_hz == pytest.approx(wd / (2 * np.pi), rel=1e-4)
    assert cycles.decrement == pytest.approx(2 * np.pi * z / np.sqrt(1 - z * z), rel=1e-3)


def test_equilibrium_is_the_centre_not_where_the_body_stops():
    recording, _ = released(LONG, 0.05, seed=7)
    motion = condition(recording)
    centre = motion.equilibrium
    stops = float(np.mean(recording.channels["displacement"][-100:]))
    assert abs(centre.value - 1e-4) < 4.0 * centre.stderr + 2e-5
    assert abs(stops - 1e-4) > 10.0 * abs(centre.value - 1e-4)


def turning_points(positions: list[float]) -> Cycles:
    p = np.array(positions)
    amplitude = 0.5 * np.abs(np.diff(p))
    time = np.arange(p.size, dtype=float)
    return Cycles(time, p, np.full(p.size, 1e-6), amplitude, 0.5 / np.diff(time), amplitude[1:])


@pytest.mark.parametrize("law", ["constant", "in proportion", "with the square"])
@pytest.mark.parametrize("count", [3, 4, 6])
def test_the_centre_of_a_motion_that_dies_within_few_swings_is_as_unsure_as_its_law(law, count):
    """Linear damping of a quarter of critical, the same loss by friction, and by drag: the rest position is 0."""
    swings = [1.0]
    while len(swings) < count:
        a = swings[-1]
        swings.append(a - 0.12 if law == "constant" else 0.45 * a if law == "in proportion" else a / (1.0 + 1.2 * a))
    found = equilibrium(turning_points([a * (-1) ** i for i, a in enumerate(swings)]))
    assert abs(found.value) < 1.5 * found.stderr
    assert found.stderr < {3: 0.05, 4: 0.01, 6: 0.0025}[count]


def test_a_light_damping_leaves_the_centre_of_a_long_decay_sure():
    swings = [0.95**i * (-1) ** i for i in range(30)]
    found = equilibrium(turning_points(swings))
    assert found.stderr < 1e-4
    assert abs(found.value) < found.stderr


def test_two_turning_points_make_no_cycles():
    t = np.linspace(0.0, 1.0, 50)
    with pytest.raises(RecordingError, match=r"1 turning points in the motion window of 1 s; a decay needs 3"):
        find_cycles(t, np.cos(4 * t), -np.sin(4 * t), np.ones(50))
