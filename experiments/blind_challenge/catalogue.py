"""Effects with a name in the contract that act through the body, its springs, its rails or its release.

Doses are relative: 1 is a few hundredths of the force of the largest release, whatever the body's size.
"""

import math

import numpy as np

from experiments.blind_challenge.effects import EffectKind, Shape, add, nothing
from experiments.blind_challenge.rigs import Needs, Rig
from experiments.blind_challenge.scene import Change, Scene
from experiments.blind_challenge.truths import codes
from experiments.blind_challenge.truths.motion import Law

DRY = Needs(dry="many", knows_mass=True)
RAILS = Needs(friction=True)


def _sign(rng: np.random.Generator, rig: Rig) -> Shape:
    return {"sign": float(rng.choice([-1.0, 1.0]))}


def _reference(scene: Scene) -> tuple[float, float, float, float]:
    """Mass, frequency, stiffness and largest release that all trials share as a scale."""
    body = scene.rig.reference
    return body.mass, body.frequency, body.stiffness, scene.rig.largest


def _one(code: int, numbers: tuple[float, ...], scene: Scene, seen: bool = False) -> Change:
    return Change(scene.body, (Law(code, numbers),), seen_by_cell=(0,) if seen else ())


def _linear(shape: Shape, dose: float, scene: Scene) -> float:
    mass, w, _, _ = _reference(scene)
    return dose * 0.02 * mass * w * scene.share


def _cubic_damping(shape: Shape, dose: float, scene: Scene) -> float:
    mass, w, _, top = _reference(scene)
    return dose * 0.02 * mass / (w * top**2) * scene.share


def _power(shape: Shape, dose: float, scene: Scene) -> tuple[float, float]:
    exponent = 2.0 + shape["sign"] * min(dose * 0.1, 0.85)
    speed = 0.6 * scene.rig.reference.frequency * scene.rig.largest
    return scene.body.drag * speed ** (2.0 - exponent), exponent


def _stiff(power: int, shape: Shape, dose: float, scene: Scene) -> float:
    return shape["sign"] * dose * 0.04 * scene.rig.springs[scene.trial.spring] / scene.rig.largest ** (power - 1)


def _stiff_change(power: int) -> object:
    place = {2: 1, 3: 2, 5: 3}[power]

    def change(shape: Shape, dose: float, scene: Scene) -> Change:
        numbers = [0.0, 0.0, 0.0, 0.0]
        numbers[place] = _stiff(power, shape, dose, scene)
        return _one(codes.STIFF, tuple(numbers), scene, seen=True)

    return change


def _sine(shape: Shape, dose: float, scene: Scene) -> Change:
    share = min(dose * 0.2, 1.0)
    k = scene.body.stiffness
    return Change(scene.body.changed(stiffness=k * (1.0 - share)), (Law(codes.SINE, (k * share,)),))


def _stribeck(shape: Shape, dose: float, scene: Scene) -> tuple[float, float]:
    return dose * 0.3 * scene.body.coulomb, shape["speed"] * scene.rig.reference.frequency * scene.rig.largest


def _presliding(shape: Shape, dose: float, scene: Scene) -> Change:
    """Dahl's bristles instead of Coulomb's jump: the same force once slid through."""
    force = scene.body.coulomb
    slip = dose * 0.01 * scene.rig.largest
    return Change(scene.body.changed(coulomb=0.0), (Law(codes.DAHL, (force / slip, slip), (0.0,), (force,)),))


def _hysteresis(shape: Shape, dose: float, scene: Scene) -> tuple[float, float]:
    return dose * 0.04 * scene.rig.springs[scene.trial.spring], shape["yield"] * scene.rig.largest


def _hysteresis_change(shape: Shape, dose: float, scene: Scene) -> Change:
    k, slip = _hysteresis(shape, dose, scene)
    return Change(scene.body, (Law(codes.DAHL, (k, slip), (0.0,), (k * slip,)),))


def _slow_hook(shape: Shape, dose: float, scene: Scene) -> Change:
    time = dose * 0.05 * 2.0 * math.pi / scene.body.frequency
    return _one(codes.RAMP, (scene.body.stiffness * scene.trial.release, time), scene)


def _heavier(shape: Shape, dose: float, scene: Scene) -> Change:
    """From one trial of a group on, a part has been left on (or off) the body."""
    same = [t for t in scene.rig.trials if (t.spring, t.level) == (scene.trial.spring, scene.trial.level)]
    late = scene.wet and same.index(scene.trial) >= shape["from"] * len(same)
    factor = 1.0 + shape["sign"] * dose * 0.01 if late else 1.0
    return Change(scene.body.changed(mass=scene.body.mass * factor))


def _support(shape: Shape, dose: float, scene: Scene) -> Change:
    """The springs end at a support with a mass, a spring and a damper of its own."""
    k = scene.body.stiffness
    own = k / (dose * 0.05)
    mass = own / (shape["ratio"] * scene.rig.reference.frequency) ** 2
    damping = 2.0 * shape["damping"] * math.sqrt(own * mass)
    size = scene.rig.largest * dose * 0.05
    law = Law(codes.SUPPORT, (k, mass, damping, own), (k * scene.trial.release / (k + own), 0.0), (size, size))
    return Change(scene.body, (law,), seen_by_cell=(0,))


add(
    EffectKind("linear_damping", "radiation-like linear damping in the water", "water", ("linear_damping",), nothing,
               lambda s, d, e: _one(codes.LINEAR, (_linear(s, d, e),), e), ("cubic_damping",), needs=DRY,
               numbers=lambda s, d, e: {"c_Ns_per_m": _linear(s, d, e)}),
    EffectKind("cubic_damping", "damping by the cube of the velocity", "water", ("cubic_damping",), nothing,
               lambda s, d, e: _one(codes.CUBIC, (_cubic_damping(s, d, e),), e), ("drag_exponent",),
               numbers=lambda s, d, e: {"Ns3_per_m3": _cubic_damping(s, d, e)}),
    EffectKind("drag_exponent", "drag by another power of the velocity", "water", ("drag_exponent",), _sign,
               lambda s, d, e: Change(e.body.changed(drag=0.0), (Law(codes.POWER, _power(s, d, e)),)),
               ("cubic_damping", "linear_damping"), numbers=lambda s, d, e: {"exponent": _power(s, d, e)[1]},
               largest=8.5),
    *(
        EffectKind(name, f"springs with a force by x^{power}", "structure", (name,), _sign, _stiff_change(power),
                   {3: ("quintic_stiffness", "quadratic_stiffness"), 5: ("cubic_stiffness",), 2: ()}[power],
                   numbers=lambda s, d, e, p=power, u=unit: {u: _stiff(p, s, d, e)}, largest=12.0)
        for name, power, unit in (
            ("cubic_stiffness", 3, "N_per_m3"),
            ("quintic_stiffness", 5, "N_per_m5"),
            ("asymmetric_stiffness", 2, "N_per_m2"),
        )
    ),
    EffectKind("sine_restoring", "a pendulum's restoring moment", "structure", ("sine_restoring",), nothing, _sine,
               ("cubic_stiffness",), needs=Needs(coordinate="rotation"), largest=5.0,
               numbers=lambda s, d, e: {"N": e.body.stiffness * min(d * 0.2, 1.0)}),
    EffectKind("stribeck_friction", "friction that falls with the speed", "structure", ("stribeck_friction",),
               lambda r, g: {"speed": float(r.uniform(0.03, 0.2))},
               lambda s, d, e: _one(codes.STRIBECK, _stribeck(s, d, e), e), unknowns=2, needs=RAILS, largest=6.0,
               numbers=lambda s, d, e: dict(
                   zip(("static_force_N", "velocity_m_per_s"), _stribeck(s, d, e), strict=True))),
    EffectKind("asymmetric_friction", "friction that differs with the direction", "structure", ("asymmetric_friction",),
               _sign, lambda s, d, e: _one(codes.ONEWAY, (s["sign"] * d * 0.1 * e.body.coulomb,), e), needs=RAILS,
               largest=8.0, numbers=lambda s, d, e: {"force_N": s["sign"] * d * 0.1 * e.body.coulomb}),
    EffectKind("variable_normal_force", "friction that grows with the displacement", "structure",
               ("variable_normal_force",), nothing,
               lambda s, d, e: _one(codes.NORMAL, (d * 0.3 * e.body.coulomb / e.rig.largest,), e), needs=RAILS,
               numbers=lambda s, d, e: {"N_per_m": d * 0.3 * e.body.coulomb / e.rig.largest}),
    EffectKind("presliding", "bristles before the rail slides", "structure", ("presliding",), nothing, _presliding,
               ("hysteresis",), needs=RAILS, largest=15.0, linear=False, smallest=0.02,
               numbers=lambda s, d, e: {"slip_m": d * 0.01 * e.rig.largest}),
    EffectKind("imperfect_release", "a hook that lets go slowly", "set-up", ("imperfect_release",), nothing, _slow_hook,
               largest=8.0, linear=False),
    EffectKind("mass_change", "a part left on the body from one trial on", "set-up", ("mass_change",),
               lambda r, g: {"from": float(r.uniform(0.4, 0.8)), **_sign(r, g)}, _heavier,
               needs=Needs(trials=(6, 16), knows_mass=True), largest=20.0),
    EffectKind("support_compliance", "springs that end on an elastic support", "set-up", ("support_compliance",),
               lambda r, g: {"ratio": float(r.uniform(2.5, 6.0)), "damping": float(r.uniform(0.01, 0.2))}, _support,
               ("hidden_resonator", "relaxation"), unknowns=3, largest=6.0, linear=False),
    EffectKind("hysteresis", "a joint that yields", "structure", ("hysteresis",),
               lambda r, g: {"yield": float(r.uniform(0.1, 0.5))}, _hysteresis_change, ("presliding", "relaxation"),
               unknowns=2,
               numbers=lambda s, d, e: dict(
                   zip(("stiffness_N_per_m", "yield_displacement_m"), _hysteresis(s, d, e), strict=True))),
    EffectKind("coulomb_friction", "friction that the equation leaves out", "structure", ("coulomb_friction",), nothing,
               lambda s, d, e: Change(e.body.changed(coulomb=d * 0.005 * e.rig.reference.stiffness * e.rig.largest)),
               left_out=("coulomb_friction",),
               numbers=lambda s, d, e: {"force_N": d * 0.005 * e.rig.reference.stiffness * e.rig.largest}),
    EffectKind("added_mass", "added mass that the equation leaves out", "water", ("added_mass",), nothing,
               lambda s, d, e: Change(e.body.changed(mass=e.body.mass * (1.0 + d * 0.01 * e.share))), needs=DRY,
               left_out=("added_mass",), numbers=lambda s, d, e: {"mass_kg": e.body.mass * d * 0.01 * e.share}),
    EffectKind("quadratic_drag", "drag that the equation leaves out", "water", ("quadratic_drag",), nothing,
               lambda s, d, e: Change(e.body.changed(drag=d * 0.02 * e.rig.reference.mass / e.rig.largest * e.share)),
               left_out=("quadratic_drag",), near=("drag_exponent",),
               numbers=lambda s, d, e: {"drag_Ns2_per_m2": d * 0.02 * e.rig.reference.mass / e.rig.largest * e.share}),
)  # fmt: skip
