"""One trial made: Eq. 15 with its scatter, the effects on top, and what perfect sensors would read.

An effect answers with a `Change`: another body, more laws, another release, faults of instruments. Changes of two
effects are merged.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import PchipInterpolator

from experiments.blind_challenge.rigs import MOST_SAMPLES, Rig, Trial
from experiments.blind_challenge.truths import codes
from experiments.blind_challenge.truths.motion import Body, Law, Motion, simulate

QUIET = 0.015  # of the release: below it the motion has died


@dataclass(frozen=True)
class Fault:
    """A fault of an instrument: kind, channel, its number (s, 1, m or level) and a second one where it has one."""

    kind: str
    channel: str
    number: float
    second: float = 0.0


@dataclass(frozen=True)
class Change:
    """What an effect changes of a trial: body, laws, release velocity (m/s), faults, spring law, share of s in x."""

    body: Body
    laws: tuple[Law, ...] = ()
    velocity: float = 0.0
    faults: tuple[Fault, ...] = ()
    seen_by_cell: tuple[int, ...] = ()  # which of `laws` the load cells carry
    hidden_in_x: float = 0.0  # displacement sensor reads x + share * first hidden state


@dataclass(frozen=True)
class Scene:
    """A trial of a rig with the mean (or its own) body."""

    rig: Rig
    trial: Trial
    body: Body

    @property
    def wet(self) -> bool:
        """Whether there is water."""
        return self.rig.levels[self.trial.level].wet

    @property
    def share(self) -> float:
        """Share of the full effect of the water at this level."""
        return self.rig.levels[self.trial.level].share


def merge(first: Change, second: Change, base: Body) -> Change:
    """Both changes at once; of the body's numbers, those that the second changed are taken from it."""
    changed = {name: value for name, value in vars(second.body).items() if value != getattr(base, name)}
    return Change(
        first.body.changed(**changed),
        first.laws + second.laws,
        first.velocity + second.velocity,
        first.faults + second.faults,
        first.seen_by_cell + tuple(i + len(first.laws) for i in second.seen_by_cell),
        first.hidden_in_x + second.hidden_in_x,
    )


def sample_count(rig: Rig, trial: Trial) -> int:
    """Samples after the release before the motion is known: the drawn number of periods."""
    period = 2.0 * math.pi / rig.body(trial.spring, trial.level).frequency
    return min(MOST_SAMPLES, int(rig.periods * period / rig.step))


def move(scene: Scene, change: Change, samples: int) -> Motion:
    """Motion of a trial at the samples after its release (the first entry is the release itself)."""
    trial = scene.trial
    return simulate(change.body, change.laws, trial.release, samples, scene.rig.step, trial.first, change.velocity)


def alive(motion: Motion, release: float, frequency: float) -> int:
    """Samples worth keeping: until the velocity has died, and two periods more."""
    moving = np.flatnonzero(np.abs(motion.v) > QUIET * release * frequency)
    last = motion.time[moving[-1]] if moving.size else 0.0
    end = max(last + 4.0 * math.pi / frequency, 8.0 * math.pi / frequency)
    return int(min(motion.time.size, np.searchsorted(motion.time, end)))


def _cell_force(change: Change, x: np.ndarray, hidden: np.ndarray) -> np.ndarray:
    """What load cells between springs and body read, N: + with displacement."""
    force = change.body.stiffness * (x - change.body.rest)
    for i in change.seen_by_cell:
        law = change.laws[i]
        if law.code == codes.STIFF:
            k1, k2, k3, k5 = law.numbers
            force = force + k1 * x + k2 * x**2 + k3 * x**3 + k5 * x**5
        elif law.code == codes.SUPPORT:
            place = sum(len(other.start) for other in change.laws[:i])
            force = force - law.numbers[0] * hidden[:, place]
    return force


def read(scene: Scene, change: Change, motion: Motion, held: int) -> dict[str, np.ndarray]:
    """Perfect sensors with their faults: channel -> values (SI) at `held` samples of the hold and at all after it.

    Without a hold (`held` = 0) the release itself is left out.
    """
    x = motion.x + scene.trial.rest + (change.hidden_in_x * motion.hidden[:, 0] if change.hidden_in_x else 0.0)
    clean = {
        "displacement": x,
        "acceleration": motion.a,
        "spring_force": _cell_force(change, motion.x, motion.hidden),
    }
    time = motion.time[1:]
    before = time[0] - scene.rig.step * np.arange(held, 0, -1)
    out = {}
    for sensor in scene.rig.sensors:
        values = clean[sensor.channel]
        rest = 0.0 if sensor.channel == "acceleration" else values[0]
        late = sum(f.number for f in change.faults if f.kind == "time_shift" and f.channel == sensor.channel)
        line = np.concatenate([np.full(held, rest), values[1:]])
        if late:
            line = _late(np.concatenate([before, time]), motion.time, values, rest, late)
        out[sensor.channel] = _faulty(line, np.concatenate([before, time]), change.faults, sensor.channel)
    return out


def _late(when: np.ndarray, time: np.ndarray, values: np.ndarray, rest: float, late: float) -> np.ndarray:
    """Values read `late` seconds late, by monotone cubics (no ringing at a jump); the held value before the release."""
    then = when - late
    return np.where(then < 0.0, rest, PchipInterpolator(time, values)(np.clip(then, 0.0, time[-1])))


def _faulty(values: np.ndarray, time: np.ndarray, faults: tuple[Fault, ...], channel: str) -> np.ndarray:
    """Gain, drift and clipping of one channel."""
    for fault in faults:
        if fault.channel != channel:
            continue
        if fault.kind == "gain_error":
            values = values * fault.number
        elif fault.kind == "sensor_drift":
            span = np.clip(time / fault.second, 0.0, None)
            values = values + fault.number * np.where(span < 1.0, span, 1.0)
        elif fault.kind == "clipping":
            values = np.clip(values, -fault.number, fault.number)
    return values


def with_own_factors(scene: Scene) -> Scene:
    """The scene with the trial's own k, c, mu and rest position."""
    trial = scene.trial
    return replace(scene, body=scene.rig.body(trial.spring, trial.level, trial.factors))


def mean_scene(rig: Rig, trial: Trial) -> Scene:
    """The scene with the mean numbers."""
    return Scene(rig, trial, rig.body(trial.spring, trial.level))
