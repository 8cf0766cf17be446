"""Effects whose form is in no catalogue: frictions with states, contacts, a magnet, a leak, a rail that bends, heat.

Names are empty where no name is right; `near` are names that describe the effect fairly, if the verdict says that it
describes.
"""

import math

import numpy as np

from experiments.blind_challenge.effects import EffectKind, Shape, add
from experiments.blind_challenge.rigs import Needs, Rig
from experiments.blind_challenge.scene import Change, Scene
from experiments.blind_challenge.truths import codes
from experiments.blind_challenge.truths.motion import Law

RAILS = Needs(friction=True)
JOINTS = 8  # Jenkins elements of an Iwan joint


def _uniform(**ranges: tuple[float, float]) -> object:
    def draw(rng: np.random.Generator, rig: Rig) -> Shape:
        return {name: float(rng.uniform(*ends)) for name, ends in ranges.items()}

    return draw


def _lugre(shape: Shape, dose: float, scene: Scene) -> Change:
    """LuGre in place of Coulomb: bristles that yield at 1 % of the release times the dose, a static peak, micro-
    damping.
    """
    force = scene.body.coulomb
    slip = dose * 0.01 * scene.rig.largest
    static = force * (1.0 + shape["peak"])
    stiff = force / slip
    speed = shape["speed"] * scene.rig.reference.frequency * scene.rig.largest
    damp = shape["damping"] * math.sqrt(stiff * scene.body.mass)
    law = Law(codes.LUGRE, (stiff, damp, force, static, speed), (0.0,), (slip,))
    return Change(scene.body.changed(coulomb=0.0), (law,))


def _rate_state(shape: Shape, dose: float, scene: Scene) -> Change:
    """Rate-and-state friction that weakens with speed, in place of Coulomb; a and b times the dose."""
    force = scene.body.coulomb
    a = min(0.1 * dose, 0.4) * force
    speed = shape["speed"] * scene.rig.reference.frequency * scene.rig.largest
    memory = shape["slip"] * scene.rig.largest
    law = Law(codes.RATE_STATE, (force, a, shape["weakening"] * a, speed, memory), (memory / speed,), (memory / speed,))
    return Change(scene.body.changed(coulomb=0.0), (law,))


def _rail(rng: np.random.Generator, rig: Rig) -> Shape:
    return {
        "sizes": rng.rayleigh(1.0, 3).tolist(),
        "waves": rng.uniform(1.0, 9.0, 3).tolist(),
        "phases": rng.uniform(0.0, 2.0 * math.pi, 3).tolist(),
    }


def _uneven(shape: Shape, dose: float, scene: Scene) -> Change:
    """Friction uneven along the rail: three waves, together never more than the friction itself."""
    total = min(0.2 * dose, 0.9) * scene.body.coulomb
    sizes = np.asarray(shape["sizes"]) / np.sum(shape["sizes"]) * total
    waves = np.asarray(shape["waves"]) / scene.rig.largest
    numbers = np.column_stack([sizes, waves, shape["phases"]]).ravel().tolist()
    return Change(scene.body, (Law(codes.UNEVEN, (float(len(sizes)), *numbers)),))


def _iwan(shape: Shape, dose: float, scene: Scene) -> Change:
    """An Iwan joint: elements of one stiffness that slip one after the other up to `reach` times the release."""
    k = dose * 0.04 * scene.rig.springs[scene.trial.spring] / JOINTS
    slips = np.linspace(1.0 / JOINTS, 1.0, JOINTS) ** shape["spread"] * shape["reach"] * scene.rig.largest
    numbers = np.column_stack([np.full(JOINTS, k), k * slips]).ravel().tolist()
    return Change(scene.body, (Law(codes.IWAN, (float(JOINTS), *numbers), (0.0,) * JOINTS, tuple(k * slips)),))


def _bouc_wen(shape: Shape, dose: float, scene: Scene) -> Change:
    """Bouc-Wen with degradation (delta) and pinching, Baber and Noori 1985."""
    k = dose * 0.04 * scene.rig.springs[scene.trial.spring]
    slip = shape["yield"] * scene.rig.largest
    numbers = (
        k,
        slip,
        shape["n"],
        0.5 + 0.4 * shape["beta"],
        0.5 - 0.4 * shape["beta"],
        shape["delta"],
        shape["delta"],
        shape["pinch"],
        0.1,
        0.5,
        0.3,
        0.05,
        0.2,
    )
    return Change(scene.body, (Law(codes.BOUCWEN, numbers, (0.0, 0.0), (1.0, 1.0)),))


def _keulegan(shape: Shape, dose: float, scene: Scene) -> Change:
    """Drag whose coefficient falls with KC, which is taken from the last half swing."""
    share = min(0.2 * dose, 1.0)
    numbers = (scene.body.drag, share, -shape["power"], 0.5 * scene.rig.largest)
    return Change(scene.body, (Law(codes.KEULEGAN, numbers),))


def _wake(shape: Shape, dose: float, scene: Scene) -> Change:
    """A wake that oscillates by itself in a slight current (Facchinetti, de Langre and Biolley 2004)."""
    w = scene.rig.reference.frequency * shape["ratio"]
    force = dose * 0.003 * scene.rig.reference.stiffness * scene.rig.largest * scene.share
    coupling = shape["coupling"] / scene.rig.largest
    start = (2.0 * math.cos(w * scene.trial.clock), -2.0 * w * math.sin(w * scene.trial.clock))
    return Change(scene.body, (Law(codes.WAKE, (force, w, shape["epsilon"], coupling), start, (1.0, w)),))


def _stop(shape: Shape, dose: float, scene: Scene) -> Change:
    """A soft stop on one side, beyond a gap."""
    gap = shape["gap"] * scene.rig.largest
    stiffness = dose * 0.1 * scene.rig.reference.stiffness / math.sqrt(scene.rig.largest)
    loss = shape["loss"] / (scene.rig.reference.frequency * scene.rig.largest)
    return Change(scene.body, (Law(codes.STOP, (gap, stiffness, loss)),))


def _magnet(shape: Shape, dose: float, scene: Scene) -> Change:
    """A magnet (or a piece of iron) at one end of the rail."""
    distance = shape["distance"] * scene.rig.largest
    strength = dose * 0.01 * scene.rig.reference.stiffness * scene.rig.largest * (distance - scene.rig.largest) ** 2
    return Change(scene.body, (Law(codes.MAGNET, (strength, distance)),))


def _leak(shape: Shape, dose: float, scene: Scene) -> Change:
    """Water that the body lifted at the start of each run drains out of it while it moves."""
    mass = dose * 0.01 * scene.rig.reference.mass * scene.share
    time = shape["time"] * 2.0 * math.pi / scene.rig.reference.frequency
    return Change(scene.body.changed(mass=scene.body.mass + mass), (Law(codes.LEAK, (mass, time)),))


def _rattle(shape: Shape, dose: float, scene: Scene) -> Change:
    """A loose part that slides in a gap and hits both ends."""
    body = scene.rig.reference
    mass = dose * 0.01 * body.mass
    gap = shape["gap"] * scene.rig.largest
    stiffness = mass * (15.0 * body.frequency) ** 2 / math.sqrt(gap)
    loss = shape["loss"] / (body.frequency * scene.rig.largest)
    law = Law(codes.CONTACT, (mass, 0.0, 0.0, gap, gap, stiffness, loss), (0.0, 0.0), (gap, gap * body.frequency))
    return Change(scene.body, (law,))


def _bending(shape: Shape, dose: float, scene: Scene) -> Change:
    """A rail that bends under the body: a valley whose slope is no straight line, and friction that follows."""
    span = shape["span"] * scene.rig.largest
    k = dose * 0.08 * scene.rig.reference.stiffness * (shape["span"] / 2.5) ** 2
    grip = dose * shape["grip"] * scene.body.coulomb / scene.rig.largest
    return Change(scene.body, (Law(codes.BEND, (k, span)), Law(codes.NORMAL, (grip,))))


def _warming(shape: Shape, dose: float, scene: Scene) -> Change:
    """Springs that soften with the temperature of the day, and within a run as they work."""
    last = max(trial.clock for trial in scene.rig.trials) or 1.0
    k = scene.body.stiffness
    day = dose * 0.004 * shape["day"] * scene.trial.clock / last
    time = shape["time"] * 2.0 * math.pi / scene.rig.reference.frequency
    return Change(scene.body.changed(stiffness=k * (1.0 - day)), (Law(codes.HEAT, (-dose * 0.01 * k, time)),))


add(
    *(
        EffectKind(key, text, "structure", (), draw, change, near, unknowns=3, needs=RAILS, smallest=ends[0],
                   largest=ends[1], linear=ends[0] == 0.0)
        for key, text, draw, change, near, ends in (
            ("lugre", "LuGre friction", _uniform(peak=(0.0, 0.6), speed=(0.02, 0.1), damping=(0.05, 0.5)), _lugre,
             ("presliding", "stribeck_friction", "hysteresis"), (0.05, 10.0)),
            ("rate_state", "rate-and-state friction",
             _uniform(speed=(0.03, 0.1), slip=(0.02, 0.2), weakening=(0.8, 2.0)), _rate_state,
             ("stribeck_friction", "linear_damping"), (1.5, 4.0)),
            ("uneven_rail", "friction uneven along the rail", _rail, _uneven, ("variable_normal_force",), (0.0, 4.5)),
            ("bending_rail", "a rail that bends", _uniform(span=(2.3, 4.0), grip=(0.0, 0.05)), _bending,
             ("cubic_stiffness", "variable_normal_force"), (0.0, 8.0)),
        )
    ),
    *(
        EffectKind(key, text, "structure", (), draw, change, near, unknowns=3, largest=10.0)
        for key, text, draw, change, near in (
            ("iwan", "an Iwan joint", _uniform(spread=(0.7, 2.0), reach=(0.3, 1.0)), _iwan,
             ("hysteresis", "presliding")),
            ("bouc_wen_pinching", "Bouc-Wen hysteresis with degradation and pinching",
             _uniform(n=(1.0, 2.5), beta=(-0.5, 1.0), delta=(0.005, 0.03), pinch=(0.3, 0.9), **{"yield": (0.1, 0.5)}),
             _bouc_wen, ("hysteresis", "presliding")),
            ("stop", "a stop on one side", _uniform(gap=(0.3, 0.85), loss=(0.0, 0.4)), _stop,
             ("asymmetric_stiffness", "cubic_stiffness")),
            ("magnet", "a magnet at one end", _uniform(distance=(1.4, 2.5)), _magnet, ("asymmetric_stiffness",)),
            ("rattle", "a rattling part", _uniform(gap=(0.03, 0.3), loss=(0.2, 0.8)), _rattle, ("hysteresis",)),
            ("warming", "stiffness that drifts with temperature", _uniform(day=(0.0, 2.0), time=(5.0, 30.0)), _warming,
             ("mass_change",)),
        )
    ),
    *(
        EffectKind(key, text, "water", (), draw, change, near, unknowns=3)
        for key, text, draw, change, near in (
            ("keulegan_drag", "drag that depends on KC", _uniform(power=(0.3, 1.2)), _keulegan,
             ("drag_exponent", "cubic_damping", "linear_damping")),
            ("wake", "a wake oscillator", _uniform(ratio=(0.5, 2.0), epsilon=(0.05, 0.4), coupling=(0.0, 1.0)), _wake,
             ("external_forcing", "hidden_resonator")),
            ("leak", "a leak that changes the mass during a run", _uniform(time=(3.0, 20.0)), _leak, ("mass_change",)),
        )
    ),
)  # fmt: skip
