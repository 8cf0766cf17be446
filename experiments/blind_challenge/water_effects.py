"""Water and masses that move by themselves: resonators, relaxation, steep water in cells, decks, radiation."""

import math
from dataclasses import replace

import numpy as np

from experiments.blind_challenge.effects import EffectKind, Shape, add
from experiments.blind_challenge.rigs import GRAVITY, Needs, Rig
from experiments.blind_challenge.scene import Change, Scene
from experiments.blind_challenge.truths import codes
from experiments.blind_challenge.truths.cells import cell_frequency, cell_mass, cell_numbers
from experiments.blind_challenge.truths.motion import Law, resonator

SLOW = Needs(frequency=(0.3, 1.5), coordinate="translation", springs=(1,), trials=(1, 8), levels=(1, 1, 2))
HEAVY = Needs(trials=(1, 10), levels=(1, 1, 2))  # convolutions take a second a trial
SPECTRUM = np.linspace(0.0, 4.0, 241)  # frequencies of a damping spectrum over its peak


def _log(rng: np.random.Generator, low: float, high: float) -> float:
    return math.exp(rng.uniform(math.log(low), math.log(high)))


def _resonator_shape(nonlinear: bool = False, low: float = 0.5, high: float = 2.0) -> object:
    def draw(rng: np.random.Generator, rig: Rig) -> Shape:
        return {
            "ratio": _log(rng, low, high),
            "damping": _log(rng, 0.005, 0.08),
            "drag": float(rng.uniform(0.02, 0.3)) if nonlinear else 0.0,
            "cubic": float(rng.uniform(-0.05, 0.3)) if nonlinear else 0.0,
        }

    return draw


def _resonator_numbers(shape: Shape, dose: float, scene: Scene) -> dict[str, float]:
    body = scene.rig.reference
    return {
        "mass_kg": dose * 0.01 * body.mass * scene.share,
        "natural_frequency_rad_per_s": shape["ratio"] * body.frequency,
        "damping_ratio": shape["damping"],
    }


def _resonator(shape: Shape, dose: float, scene: Scene) -> Change:
    numbers = _resonator_numbers(shape, dose, scene)
    top = scene.rig.largest
    w = numbers["natural_frequency_rad_per_s"]
    law = resonator(
        numbers["mass_kg"], w, shape["damping"], shape["drag"] / top, shape["cubic"] * w**2 / top**2, scale=top
    )
    return Change(scene.body, (law,))


def _relaxation_numbers(shape: Shape, dose: float, scene: Scene) -> dict[str, float]:
    body = scene.rig.reference
    return {"stiffness_N_per_m": dose * 0.02 * body.stiffness * scene.share, "time_s": shape["time"] / body.frequency}


def _relaxation(shape: Shape, dose: float, scene: Scene) -> Change:
    k, time = _relaxation_numbers(shape, dose, scene).values()
    return Change(scene.body, (Law(codes.RELAX, (k, time), (0.0,), (k * scene.rig.largest,)),))


def _cell_shape(rng: np.random.Generator, rig: Rig) -> Shape:
    """Cells whose first mode is near the body's frequency: their length follows from gravity."""
    ratio, aspect = _log(rng, 0.7, 1.6), float(rng.uniform(0.2, 0.7))
    w = ratio * rig.reference.frequency
    return {
        "ratio": ratio,
        "aspect": aspect,
        "damping": _log(rng, 0.005, 0.03),
        "length": GRAVITY * math.pi * math.tanh(math.pi * aspect) / w**2,
    }


def _cells(shape: Shape, dose: float, scene: Scene) -> Change:
    length = shape["length"]
    depth = shape["aspect"] * length
    breadth = dose * 0.03 * scene.rig.reference.mass * scene.share / (length * depth)
    numbers = cell_numbers(length, depth, breadth, GRAVITY, shape["damping"], modes=4)
    sizes = (length,) * 4 + (length**2 * cell_frequency(length, depth, GRAVITY),) * 4
    return Change(scene.body, (Law(codes.CELL, tuple(numbers), (0.0,) * 8, sizes),))


def _cell_truth(shape: Shape, dose: float, scene: Scene) -> dict[str, float]:
    length = shape["length"]
    depth = shape["aspect"] * length
    breadth = dose * 0.03 * scene.rig.reference.mass * scene.share / (length * depth)
    return {
        "mass_kg": cell_mass(length, depth, breadth),
        "natural_frequency_rad_per_s": cell_frequency(length, depth, GRAVITY),
        "damping_ratio": shape["damping"],
    }


def _small_releases(rng: np.random.Generator, rig: Rig) -> Rig:
    """Releases that the cells can follow: a hundredth of the length of a cell tuned to the body."""
    length = GRAVITY * math.pi * 0.7 / rig.reference.frequency**2
    factor = length * rng.uniform(0.003, 0.012) / rig.largest
    return rescaled(rig, factor)


def rescaled(rig: Rig, factor: float) -> Rig:
    """The same rig with all releases, noises and friction times `factor`; drag so that its force over the spring's
    stays.
    """
    trials = tuple(replace(t, release=t.release * factor, rest=t.rest * factor) for t in rig.trials)
    sensors = tuple(replace(s, noise=s.noise * factor, offset=s.offset * factor) for s in rig.sensors)
    levels = tuple(replace(v, drag=v.drag / factor, area=float(f"{v.area / factor:.4g}")) for v in rig.levels)
    return replace(rig, largest=rig.largest * factor, mu=rig.mu * factor, trials=trials, sensors=sensors, levels=levels)


def _open_shape(rng: np.random.Generator, rig: Rig) -> Shape:
    return {
        "ratio": _log(rng, 0.6, 1.6),
        "damping": float(rng.uniform(0.04, 0.15)),
        "loss": float(rng.uniform(0.2, 1.0)),
    }


def _open_section(shape: Shape, dose: float, scene: Scene) -> Change:
    """A section open below, linear: odd sloshing modes of deep cells that leak energy downwards, and the radiation's
    memory.
    """
    body = scene.rig.reference
    laws = []
    for n in (1, 3, 5):
        mass = dose * 0.02 * body.mass * scene.share / n**2
        laws.append(
            resonator(mass, shape["ratio"] * body.frequency * math.sqrt(n), shape["damping"], scale=scene.rig.largest)
        )
    return Change(scene.body, (*laws, _radiating(shape["loss"] * dose, 1.3 * shape["ratio"], 2.0, scene)))


def retardation(peak: float, sharpness: float) -> object:
    """Kernel (1/s) of the damping B(w) = (w / wp)^4 exp(sharpness (1 - (w / wp)^2)), whose value at wp is 1: 2/pi int B
    cos(w t) dw.
    """
    line = SPECTRUM**4 * np.exp(sharpness * (1.0 - SPECTRUM**2))
    weight = np.full(SPECTRUM.size, peak * (SPECTRUM[1] - SPECTRUM[0]))
    weight[[0, -1]] *= 0.5

    def kernel(s: np.ndarray) -> np.ndarray:
        return 2.0 / math.pi * np.cos(np.outer(s, SPECTRUM * peak)) @ (line * weight)

    return kernel


def _radiating(dose: float, ratio: float, sharpness: float, scene: Scene) -> Law:
    body = scene.rig.reference
    gain = dose * 0.01 * body.mass * body.frequency * scene.share
    peak = ratio * body.frequency
    return Law(
        codes.KERNEL, (0.0, gain, 0.0), kernel=retardation(peak, sharpness), kernel_length=4.0 * 2.0 * math.pi / peak
    )


def _deck(shape: Shape, dose: float, scene: Scene) -> Change:
    """Sloshing water that hits a deck: a resonator whose mass meets a wall at a gap, and loses energy there."""
    body = scene.rig.reference
    mass = dose * 0.01 * body.mass * scene.share
    gap = shape["gap"] * scene.rig.largest
    w = shape["ratio"] * body.frequency
    stiffness = mass * (8.0 * body.frequency) ** 2 / math.sqrt(gap)
    loss = shape["loss"] / (body.frequency * gap)
    law = Law(codes.CONTACT, (mass, w, shape["damping"], gap, gap, stiffness, loss), (0.0, 0.0), (gap, gap * w))
    return Change(scene.body, (law,))


def _deck_shape(rng: np.random.Generator, rig: Rig) -> Shape:
    return {
        "ratio": _log(rng, 0.7, 1.5),
        "damping": _log(rng, 0.01, 0.08),
        "gap": float(rng.uniform(0.3, 1.5)),
        "loss": float(rng.uniform(0.3, 0.9)),
    }


def _pitch(shape: Shape, dose: float, scene: Scene) -> Change:
    """Pitch coupled to surge: the body rocks on its rails, and the displacement sensor sits off the axis."""
    return replace(_resonator(shape, dose, scene), hidden_in_x=shape["lever"] * min(dose * 0.01, 0.3))


def _left_over(shape: Shape, dose: float, scene: Scene) -> Change:
    """A resonator that still moves from the run before: amplitude and phase differ from run to run."""
    change = _resonator(shape, dose, scene)
    law = change.laws[0]
    w = law.numbers[1]
    size, angle = shape["left"] * scene.rig.largest, (w * scene.trial.clock) % (2.0 * math.pi)
    return Change(change.body, (replace(law, start=(size * math.cos(angle), -size * w * math.sin(angle))),))


def _with(draw: object, **ranges: tuple[float, float]) -> object:
    def both(rng: np.random.Generator, rig: Rig) -> Shape:
        return {**draw(rng, rig), **{name: float(rng.uniform(*ends)) for name, ends in ranges.items()}}

    return both


add(
    EffectKind("hidden_resonator", "water that oscillates by itself, linear", "water", ("hidden_resonator",),
               _resonator_shape(), _resonator, unknowns=3, numbers=_resonator_numbers),
    EffectKind("hidden_resonator_nonlinear", "water whose damping and frequency depend on its amplitude", "water",
               ("hidden_resonator",), _resonator_shape(True), _resonator, unknowns=5, numbers=_resonator_numbers),
    EffectKind("relaxation", "a force that relaxes (Maxwell element)", "water", ("relaxation",),
               lambda r, g: {"time": _log(r, 0.15, 4.0)}, _relaxation, unknowns=2, numbers=_relaxation_numbers),
    EffectKind("resonator_far_above", "water whose frequency is far above the body's", "water", ("hidden_resonator",),
               _resonator_shape(low=8.0, high=20.0), _resonator, ("added_mass",), unknowns=3,
               needs=Needs(dry="many", knows_mass=True), left_out=("added_mass",), numbers=_resonator_numbers),
    EffectKind("overdamped_resonator", "water so damped that it only creeps", "water", ("hidden_resonator",),
               lambda r, g: {"ratio": _log(r, 0.5, 2.0), "damping": float(r.uniform(2.0, 4.0)), "drag": 0.0,
                             "cubic": 0.0},
               _resonator, ("relaxation",), unknowns=3, numbers=_resonator_numbers),
    EffectKind("closed_cells", "fully nonlinear water in closed cells (Miles-Lukovsky)", "water", (), _cell_shape,
               _cells, ("hidden_resonator",), unknowns=3, needs=SLOW, numbers=_cell_truth, fit_rig=_small_releases,
               largest=10.0),
    EffectKind("open_section", "a linear section open below", "water", (), _open_shape, _open_section,
               ("hidden_resonator", "relaxation"), unknowns=4, needs=HEAVY),
    EffectKind("radiation", "radiation as a convolution", "water", (),
               lambda r, g: {"ratio": _log(r, 0.5, 1.8), "sharpness": float(r.uniform(1.5, 4.0))},
               lambda s, d, e: Change(e.body, (_radiating(d, s["ratio"], s["sharpness"], e),)),
               ("relaxation", "hidden_resonator", "linear_damping"), unknowns=4, needs=HEAVY),
    EffectKind("deck", "water that hits a deck", "water", (), _deck_shape, _deck, ("hidden_resonator",), unknowns=5),
    EffectKind("pitch", "pitch coupled to surge", "structure", (),
               _with(_resonator_shape(low=0.6, high=3.0), lever=(-1.0, 1.0)), _pitch, ("hidden_resonator",),
               unknowns=4),
    EffectKind("left_over_sloshing", "sloshing left over from the run before", "water", (),
               _with(_resonator_shape(), left=(0.1, 0.6)), _left_over, ("hidden_resonator", "external_forcing"),
               unknowns=3, unknowns_a_trial=2),
)  # fmt: skip
