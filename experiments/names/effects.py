"""What can be hidden: every name a verdict can give, as it changes a trial, with one size to be set.

Belongs here: which numbers of the equation, or which sensor, an effect changes, where it acts (water, structure,
outside, set-up, instrument), what is drawn for it. Does not belong here: how large it has to be (strength.py).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from experiments.names.rigs import FLUME, PENDULUM, Rig, Trial

Numbers = dict[str, float]


@dataclass(frozen=True)
class Scene:
    """One trial as an effect sees it: trial, rig, body rates of this and of the slowest spring (rad/s), speed and
    displacement scales of the largest release of this spring, draws of the campaign and of the trial (uniform 0-1)."""

    trial: Trial
    rig: Rig
    rate: float
    slowest: float
    speed: float
    largest: float
    later: bool
    campaign: Mapping[str, float]
    own: Mapping[str, float]

    @property
    def sign(self) -> float:
        """Sign of this campaign, for effects that can have either."""
        return 1.0 if self.campaign["sign"] < 0.5 else -1.0


Change = Callable[[Numbers, float, Scene], None]


@dataclass(frozen=True)
class Effect:
    """One name: where it acts, how it changes the equation's numbers at a size, largest size.

    ``place``: water and outside act on wet trials, the rest on all. ``lacks``: the term that the prescribed equation
    does without; ``seen_in`` a freedom of each trial that would take the effect up whole and is therefore not taken out
    when its strength is measured. Instruments change readings (recordings.py) by ``unit_size`` times the strength.
    """

    name: str
    place: str
    change: Change | None = None
    most: float = 1.0
    lacks: str = ""
    rig: Rig = FLUME
    seen_in: str = ""
    unit_size: float = field(default=0.0)


def _add(slot: str, scale: Callable[[Numbers, Scene], float], signed: bool = False) -> Change:
    """An effect that adds ``size`` of a natural scale to one number."""

    def change(p: Numbers, size: float, s: Scene) -> None:
        p[slot] = p.get(slot, 0.0) + size * scale(p, s) * (s.sign if signed else 1.0)

    return change


def _drag_exponent(p: Numbers, size: float, s: Scene) -> None:
    """q v|v| becomes d |v|^p sign(v), the same force at a third of the largest speed."""
    power = 2.0 + s.sign * size
    reference = s.campaign["speed"] / 3.0
    p["d"], p["p"] = p["q"] * reference ** (2.0 - power), power
    p["q"] = 0.0


def _without(slot: str) -> Change:
    """The term itself, weakened or strengthened: size 1 is as it is in the rig; the equation does without."""

    def change(p: Numbers, size: float, s: Scene) -> None:
        p[slot] *= size

    return change


def _added_mass(p: Numbers, size: float, s: Scene) -> None:
    p["M"] = s.rig.mass + size * (p["M"] - s.rig.mass)


def _sine(p: Numbers, size: float, s: Scene) -> None:
    p["ks"], p["k"] = size * p["k"], (1.0 - size) * p["k"]


def _stribeck(p: Numbers, size: float, s: Scene) -> None:
    p["fs"], p["vs"] = size * p["fc"], s.campaign["speed"] * (0.02 + 0.03 * s.campaign["first"])


def _presliding(p: Numbers, size: float, s: Scene) -> None:
    p["xb"] = size * p["fc"] / p["k"]


def resonator_rate(s: Scene) -> float:
    """Rate of the hidden water, rad/s: 0.75 to 1.5 of the body's, at least 6 % from it."""
    share = 0.75 + 0.75 * s.campaign["first"]
    if abs(share - 1.0) < 0.06:
        share = 1.0 + (0.06 if share >= 1.0 else -0.06)
    return share * s.campaign["rate"]


def _resonator(p: Numbers, size: float, s: Scene) -> None:
    mass = size * s.rig.mass
    p["hm"], p["hw"], p["hz"] = mass, resonator_rate(s), 0.01 + 0.04 * s.campaign["second"]


def _resonator_with_amplitude(p: Numbers, size: float, s: Scene) -> None:
    """Quadratic damping and softening, as steep waves have them; numbers as found for breaking water."""
    _resonator(p, size, s)
    p["hb"] = 0.6 / s.campaign["largest"] * (0.5 + s.campaign["third"])
    p["hg"] = -0.05 * (p["hw"] / s.campaign["largest"]) ** 2


def _relaxation(p: Numbers, size: float, s: Scene) -> None:
    p["rk"], p["rt"] = size * s.rig.mass * s.slowest**2, (1.0 + 3.0 * s.campaign["first"]) / s.slowest


def _hysteresis(p: Numbers, size: float, s: Scene) -> None:
    p["kh"], p["xh"] = size * p["k"], s.largest * (0.1 + 0.3 * s.campaign["first"])


def _forcing(p: Numbers, size: float, s: Scene) -> None:
    p["A"], p["ph"] = size * p["k"] * s.largest, 2.0 * np.pi * s.own["phase"]
    p["om"] = resonator_rate(s)
    while min(abs(p["om"] / rate - 1.0) for rate in (s.slowest, s.campaign["fastest"])) < 0.15:
        p["om"] *= 1.1  # a force at a body's own rate is a trial whose k differs


def _echo(p: Numbers, size: float, s: Scene) -> None:
    p["ge"], p["te"] = size * s.rig.mass * s.rate, (1.5 + 4.0 * s.campaign["first"]) * 2.0 * np.pi / s.slowest


def _rest(p: Numbers, size: float, s: Scene) -> None:
    p["rest"] = size * p["fc"] / p["k"] * (2.0 * s.own["normal"] if abs(s.own["normal"]) > 0.2 else 0.4)


def _slow_release(p: Numbers, size: float, s: Scene) -> None:
    p["ramp"] = size * 2.0 * np.pi / s.rate * (0.6 + 0.8 * s.own["other"])


def _support(p: Numbers, size: float, s: Scene) -> None:
    """A support of a tenth of the body's mass, size times as soft as the springs, damped by 2 %."""
    stiff = s.campaign["stiffest"] / size
    p["my"], p["ky"] = 0.1 * s.rig.mass, stiff
    p["cy"] = 0.04 * np.sqrt(stiff * p["my"])


def _taken_on(p: Numbers, size: float, s: Scene) -> None:
    """Mass taken on (or lost) between the trials: half of the wet ones, in no order of release, have it."""
    if s.later:
        p["M"] += s.sign * size * s.rig.mass


EFFECTS: tuple[Effect, ...] = (
    Effect("linear_damping", "water", _add("c", lambda p, s: p["c"]), 10.0),
    Effect("quadratic_drag", "water", _without("q"), 3.0, lacks="quadratic_drag"),
    Effect("cubic_damping", "water", _add("c3", lambda p, s: p["q"] / s.campaign["speed"]), 20.0),
    Effect("drag_exponent", "water", _drag_exponent, 1.0),
    Effect("added_mass", "water", _added_mass, 2.0, lacks="added_mass"),
    Effect("hidden_resonator", "water", _resonator, 0.4),
    Effect("hidden_resonator_amplitude", "water", _resonator_with_amplitude, 0.4),
    Effect("relaxation", "water", _relaxation, 0.5),
    Effect("external_forcing", "outside", _forcing, 0.3),
    Effect("delayed_echo", "outside", _echo, 0.3),
    Effect("cubic_stiffness", "structure", _add("k3", lambda p, s: p["k"] / s.largest**2, True), 0.5),
    Effect("quintic_stiffness", "structure", _add("k5", lambda p, s: p["k"] / s.largest**4, True), 0.5),
    Effect("asymmetric_stiffness", "structure", _add("k2", lambda p, s: p["k"] / s.largest, True), 0.5),
    Effect("sine_restoring", "structure", _sine, 1.0, rig=PENDULUM),
    Effect("coulomb_friction", "structure", _without("fc"), 1.2, lacks="coulomb_friction"),
    Effect("stribeck_friction", "structure", _stribeck, 1.5),
    Effect("asymmetric_friction", "structure", _add("fa", lambda p, s: p["fc"], True), 0.9, seen_in="rest"),
    Effect("presliding", "structure", _presliding, 10.0),
    Effect("variable_normal_force", "structure", _add("n", lambda p, s: p["fc"] / s.largest), 4.0),
    Effect("hysteresis", "structure", _hysteresis, 0.4),
    Effect("support_compliance", "set-up", _support, 0.3),
    Effect("rest_offset", "set-up", _rest, 20.0, seen_in="rest"),
    Effect("imperfect_release", "set-up", _slow_release, 0.7),
    Effect("mass_change", "set-up", _taken_on, 0.2),
    Effect("time_shift", "instrument", unit_size=4e-3),
    Effect("gain_error", "instrument", unit_size=0.01),
    Effect("sensor_drift", "instrument", unit_size=0.01),
    Effect("clipping", "instrument", unit_size=0.04),
    Effect("asymmetric_damping", "water", _add("ca", lambda p, s: p["c"], True), 1.0),
    Effect("asymmetric_drag", "water", _add("qa", lambda p, s: p["q"], True), 1.0),
)
"""Every name. Friction is kept small enough for the smallest release to swing twice. Units of the instruments': seconds
by which the accelerometer is late; relative gain of the accelerometer; drift of the displacement over the largest
release; share of the largest reading that is cut off."""


def find(name: str) -> Effect:
    """The effect of a name; KeyError where there is none.

    >>> find("relaxation").place
    'water'
    """
    for effect in EFFECTS:
        if effect.name == name:
            return effect
    raise KeyError(f"no effect {name!r}; there are {', '.join(e.name for e in EFFECTS)}")


def verdict_name(name: str) -> str:
    """The name that a verdict gives an effect: a resonator is one, whatever it depends on."""
    return "hidden_resonator" if name == "hidden_resonator_amplitude" else name


def acts_on(effect: Effect, trial: Trial) -> bool:
    """Whether an effect is there in this trial: water and outside forces only where there is water."""
    if effect.place in ("water", "outside") or effect.name == "mass_change":
        return trial.wet
    return True
