"""What the laboratory's sensors make of a trial, and what an instrument that is hidden changes.

Belongs here: holds, clocks, sampling, sensors (those of the Eq. 15 campaign), instruments' effects. Does not belong
here: the motion (motion.py), files (folder.py).
"""

from __future__ import annotations

import numpy as np

from experiments.eq15_campaign import sensors
from experiments.names.motion import Floats, release
from experiments.names.rigs import Trial
from experiments.names.scenes import Campaign, make_scene

HOLD_S = (0.45, 0.95)
FASTEST_HZ = 1000.0
"""Every trial is sampled this fast; slower loggers keep every second, fourth, tenth sample."""


def record(campaign: Campaign, trial: Trial) -> dict[str, Floats]:
    """A trial as recorded: column -> (n,), time_s first; the body is held at its release before it is let go.

    The accelerometer's lateness, a gain, a drift or a cut are there where the campaign hides them.
    """
    plan = campaign.plan
    rng = np.random.default_rng([plan.chances, 6, trial.order])
    hold = rng.uniform(*HOLD_S)
    error = rng.uniform(-0.5, 0.5) / plan.rate_hz
    fine = np.arange(round((hold + plan.seconds) * FASTEST_HZ)) / FASTEST_HZ
    x0 = campaign.released(trial)
    path = release(campaign.numbers(trial), x0, plan.seconds + 0.1)
    x, a, spring = _seen(path.at, fine + error - hold, x0)
    late = campaign.sizes.get("time_shift", 0.0)
    if late:
        _, a, _ = _seen(path.at, fine + error - hold - late, x0)
    quantities = [x, a]
    if len(plan.rig.sensors) > 2:
        quantities += [share * spring for share in sensors.LOAD_SHARES]
    gains = sensors.draw_gains(np.random.default_rng([plan.seed, 7]))
    read: dict[str, Floats] = {}
    for place, (sensor, quantity) in enumerate(zip(plan.rig.sensors, quantities, strict=True)):
        gain = gains.get(sensor.column, 1.0) * (1.0 + campaign.sizes.get("gain_error", 0.0) * (place == 1))
        own = np.random.default_rng([plan.chances, 8, trial.order, place])
        drifted = quantity + _drift(campaign, trial, own, fine) * (place == 0)
        read[sensor.column] = _cut(campaign, trial, place, sensors.read(own, sensor, gain, fine, drifted)[0])
    keep = slice(None, None, round(FASTEST_HZ / plan.rate_hz))
    return {"time_s": fine[keep], **{column: values[keep] for column, values in read.items()}}


def _seen(at: object, since: Floats, x0: float) -> tuple[Floats, Floats, Floats]:
    """Displacement, acceleration, spring force at instants before (held) and after the release."""
    x, a, spring = at(np.maximum(since, 0.0))  # type: ignore[operator]
    held = since < 0.0
    return np.where(held, x0, x), np.where(held, 0.0, a), np.where(held, spring[0], spring)


def _drift(campaign: Campaign, trial: Trial, rng: np.random.Generator, times: Floats) -> Floats:
    """A hidden drift of the displacement: straight, with one slow bend, either way; size over the largest release."""
    size = campaign.sizes.get("sensor_drift", 0.0)
    if not size:
        return np.zeros_like(times)
    largest = campaign.plan.rig.springs[trial.spring].releases[1]
    part = times / times[-1]
    way = 1.0 if rng.uniform() < 0.5 else -1.0
    drift: Floats = way * size * largest * (part + 0.3 * rng.uniform(-1.0, 1.0) * np.sin(np.pi * part))
    return drift


def _cut(campaign: Campaign, trial: Trial, place: int, values: Floats) -> Floats:
    """A reading cut off at a share below the largest release's: of the displacement or of the accelerometer."""
    share = campaign.sizes.get("clipping", 0.0)
    scene = make_scene(campaign.plan, trial)
    if not share or place != (0 if scene.sign > 0.0 else 1):
        return values
    largest = campaign.plan.rig.springs[trial.spring].releases[1]
    top = largest * (1.0 if place == 0 else scene.rate**2) * max(1.0 - share, 0.1)
    return np.clip(values, -top, top)
