"""Faults of instruments with a name in the contract: late, wrong in gain, drifting, saturated."""

import math

import numpy as np

from experiments.blind_challenge.effects import EffectKind, Shape, add, nothing
from experiments.blind_challenge.rigs import Needs, Rig
from experiments.blind_challenge.scene import Change, Fault, Scene

SECOND = Needs(channels=("acceleration",), coordinate="translation")


def _sign(rng: np.random.Generator, rig: Rig) -> Shape:
    return {"sign": float(rng.choice([-1.0, 1.0]))}


def _late(shape: Shape, dose: float, scene: Scene) -> float:
    return dose * 0.01 * 2.0 * math.pi / scene.rig.reference.frequency


def _late_cell(shape: Shape, dose: float, scene: Scene) -> Change:
    return Change(scene.body, faults=(Fault("time_shift", "spring_force", _late(shape, dose, scene)),))


def _fault(kind: str, channel: str, number: object) -> object:
    def change(shape: Shape, dose: float, scene: Scene) -> Change:
        return Change(scene.body, faults=(Fault(kind, channel, number(shape, dose, scene)),))

    return change


def _drift(shape: Shape, dose: float, scene: Scene) -> Change:
    span = shape["span"] * scene.rig.periods * 2.0 * math.pi / scene.rig.reference.frequency
    return Change(
        scene.body,
        faults=(Fault("sensor_drift", "displacement", shape["sign"] * dose * 0.02 * scene.rig.largest, span),),
    )


def _level(shape: Shape, dose: float, scene: Scene) -> float:
    return scene.rig.largest * (1.0 - min(0.03 * dose, 0.4))


add(
    EffectKind("time_shift", "an accelerometer that is late", "instrument", ("time_shift",), nothing,
               _fault("time_shift", "acceleration", _late), needs=SECOND,
               numbers=lambda s, d, e: {"shift_s": _late(s, d, e)}),
    EffectKind("late_cell", "load cells that are late", "instrument", ("time_shift",), nothing, _late_cell,
               ("linear_damping",), needs=Needs(channels=("spring_force",), coordinate="translation"),
               numbers=lambda s, d, e: {"shift_s": _late(s, d, e)}),
    EffectKind("gain_error", "an accelerometer with a wrong gain", "instrument", ("gain_error",), _sign,
               _fault("gain_error", "acceleration", lambda s, d, e: 1.0 + s["sign"] * min(0.02 * d, 0.7)), needs=SECOND,
               numbers=lambda s, d, e: {"gain": 1.0 + s["sign"] * min(0.02 * d, 0.7)}),
    EffectKind("sensor_drift", "a displacement sensor that drifts within a trial", "instrument", ("sensor_drift",),
               lambda r, g: {"span": float(r.uniform(0.3, 1.0)), **_sign(r, g)}, _drift),
    EffectKind("clipping", "a displacement sensor that saturates", "instrument", ("clipping",), nothing,
               _fault("clipping", "displacement", _level), largest=13.0, linear=False),
)  # fmt: skip
