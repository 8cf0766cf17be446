"""Forces with a clock of their own and forces that come back: tones, a narrow-band seiche, echoes, reflections."""

import math

import numpy as np

from experiments.blind_challenge.effects import EffectKind, Shape, add
from experiments.blind_challenge.rigs import Needs, Rig
from experiments.blind_challenge.scene import Change, Scene
from experiments.blind_challenge.truths import codes
from experiments.blind_challenge.truths.motion import Law

LINES = 20  # of a narrow band
BAND = 3.0  # widths of a band on either side of its centre


def _tone(rng: np.random.Generator, rig: Rig) -> Shape:
    ratio = math.exp(rng.uniform(math.log(0.3), math.log(3.0)))
    return {"ratio": ratio, "lines": [ratio], "sizes": [1.0], "phases": [float(rng.uniform(0.0, 2.0 * math.pi))]}


def _band(low: float, high: float) -> object:
    def draw(rng: np.random.Generator, rig: Rig) -> Shape:
        ratio = math.exp(rng.uniform(math.log(low), math.log(high)))
        width = ratio * rng.uniform(0.003, 0.025)
        lines = ratio + width * np.sort(rng.uniform(-BAND, BAND, LINES))
        sizes = np.exp(-0.5 * ((lines - ratio) / width) ** 2) * rng.rayleigh(1.0, LINES)
        sizes /= math.sqrt(np.sum(sizes**2))
        return {
            "ratio": ratio,
            "width": width,
            "lines": lines.tolist(),
            "sizes": sizes.tolist(),
            "phases": rng.uniform(0.0, 2.0 * math.pi, LINES).tolist(),
        }

    return draw


def _waves(shape: Shape, dose: float, scene: Scene) -> tuple[float, list[float]]:
    """Number of lines, then amplitude (N), frequency (rad/s) and phase at this trial's release for each."""
    body = scene.rig.reference
    size = dose * 0.005 * body.stiffness * scene.rig.largest * scene.share
    out: list[float] = []
    for line, share, phase in zip(shape["lines"], shape["sizes"], shape["phases"], strict=True):
        w = line * body.frequency
        out += [size * share, w, (phase + w * scene.trial.clock) % (2.0 * math.pi)]
    return float(len(shape["lines"])), out


def _push(shape: Shape, dose: float, scene: Scene) -> Change:
    count, waves = _waves(shape, dose, scene)
    return Change(scene.body, (Law(codes.TONES, (count, *waves)),))


def _current(shape: Shape, dose: float, scene: Scene) -> Change:
    """A seiche whose water moves past the body: drag on the relative velocity, and the force of its acceleration."""
    count, waves = _waves(shape, dose, scene)
    body = scene.rig.reference
    level = scene.rig.levels[scene.trial.level]
    inertia = level.added_mass + 1000.0 * level.volume
    speeds = [value / (inertia * body.frequency) if i % 3 == 0 else value for i, value in enumerate(waves)]
    return Change(scene.body, (Law(codes.CURRENT, (scene.body.drag, inertia, count, *speeds)),))


def _echo(shape: Shape, dose: float, scene: Scene) -> tuple[float, float]:
    body = scene.rig.reference
    return (
        shape["sign"] * dose * 0.02 * body.mass * body.frequency * scene.share,
        shape["delay"] * 2.0 * math.pi / body.frequency,
    )


def dispersive(shape: Shape, scene: Scene) -> object:
    """Kernel of waves that come back from the flume's ends spread out: long ones first, a chirp under a bell, 1/s."""
    w = scene.rig.reference.frequency
    arrival, width, sweep = shape["delay"] * 2.0 * math.pi / w, shape["width"] * 2.0 * math.pi / w, shape["sweep"]

    def kernel(s: np.ndarray) -> np.ndarray:
        u = (s - arrival) / width
        phase = w * (s - arrival) * (1.0 + 0.25 * sweep * u)
        return np.exp(-0.5 * u**2) * np.cos(phase) / (width * math.sqrt(2.0 * math.pi))

    return kernel


def _reflection(shape: Shape, dose: float, scene: Scene) -> Change:
    body = scene.rig.reference
    gain = dose * 0.03 * body.mass * body.frequency * scene.share
    period = 2.0 * math.pi / body.frequency
    law = Law(
        codes.KERNEL,
        (0.0, gain, 0.0),
        kernel=dispersive(shape, scene),
        kernel_length=(shape["delay"] + 4.0 * shape["width"]) * period,
    )
    return Change(scene.body, (law,))


def _echo_shape(rng: np.random.Generator, rig: Rig) -> Shape:
    return {"delay": float(rng.uniform(1.5, 8.0)), "sign": float(rng.choice([-1.0, 1.0]))}


def _reflection_shape(rng: np.random.Generator, rig: Rig) -> Shape:
    width = float(rng.uniform(0.5, 1.5))
    return {
        "delay": float(rng.uniform(3.0 * width + 1.0, 3.0 * width + 5.0)),
        "width": width,
        "sweep": float(rng.uniform(0.2, 0.8)),
    }


def tone_numbers(s: Shape, d: float, e: Scene) -> dict[str, float]:
    _, waves = _waves(s, d, e)
    return {"amplitude_N": waves[0], "frequency_rad_per_s": waves[1]}


add(
    EffectKind("external_tone", "a force of one frequency with its own clock", "outside", ("external_forcing",), _tone,
               _push, unknowns=2, unknowns_a_trial=1, numbers=tone_numbers),
    *(
        EffectKind(key, text, "outside", ("external_forcing",), _band(low, high), _push, unknowns=2, unknowns_a_trial=2)
        for key, low, high, text in (
            ("external_narrow_band", 0.4, 2.5, "a seiche: a narrow-band random force"),
            ("external_close", 0.94, 1.06, "a seiche close to the body's frequency"),
        )
    ),
    EffectKind("delayed_echo", "a wave that comes back from the flume's end", "water", ("delayed_echo",), _echo_shape,
               lambda s, d, e: Change(e.body, (Law(codes.ECHO, (0.0, *_echo(s, d, e))),)), unknowns=2, largest=6.0,
               numbers=lambda s, d, e: dict(zip(("gain", "delay_s"), _echo(s, d, e), strict=True))),
    EffectKind("dispersive_reflections", "waves that come back spread out by dispersion", "water", (),
               _reflection_shape, _reflection, ("delayed_echo", "hidden_resonator"), unknowns=4, largest=10.0,
               needs=Needs(trials=(1, 10), levels=(1, 1, 2))),
    EffectKind("seiche_with_velocity", "a seiche that carries water past the body", "outside", (), _band(0.4, 2.0),
               _current, ("external_forcing",), unknowns=2, unknowns_a_trial=2),
)  # fmt: skip
