"""Who can be missing: every suspect, its unknowns, and where it comes from.

Belongs here: what a suspect adds to an equation, in slots of the integrator, with starts and bounds. Does not belong
here: what a suspect is (suspect.py), the search (search.py).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.polynomial import Chebyshev, Polynomial

from undertow.comparison.bad_release import BAD_RELEASES, nothing
from undertow.comparison.suspect import DRIFT, EACH_SPRING, Addition, Origin, Scales, Scope, Suspect
from undertow.equation.forcing import ENVELOPE, DelayedEcho, ExternalForcing
from undertow.equation.hidden import HiddenResonator, Hysteresis, Relaxation
from undertow.equation.hydrodynamics import (
    AddedMass,
    AddedStiffness,
    CubicDamping,
    DragExponent,
    LinearDamping,
    QuadraticDrag,
)
from undertow.equation.registry import catalogue
from undertow.equation.structure import (
    AsymmetricStiffness,
    CoulombFriction,
    CubicStiffness,
    QuinticStiffness,
    SineRestoring,
    StiffnessDrift,
    StribeckFriction,
    VariableNormalForce,
)
from undertow.equation.term import Term
from undertow.errors import ConfigError

BRISTLES = "presliding"
"""Name of bristles that yield where dry friction would slide."""

NARROW = 0.3
"""Half waves, at most, that a force's size has in one of its cycles: 0.15 of its rate is a narrow band."""

MASS_STD = 0.1
"""Prior of a mass taken on or lost, relative to the body's."""

RINGS = 0.05
"""A resonator damped more than this loses a quarter of its swing in a cycle: it may be a kernel of fading memory."""


def _plain(
    law: type[Term], origin: Origin, size: Callable[[Scales], float], scope: Scope = "shared", variant: str = ""
) -> Suspect:
    """A suspect that is one coefficient of a law, starting from nothing."""
    one = law.parameters[0]

    def additions(scales: Scales, start: float) -> tuple[Addition, ...]:
        slot, scale = law.slots[one.name], size(scales)
        return (Addition(one.name, one.unit, slot, 0.0, scale, scope=scope, takes=law.dissipates),)

    return Suspect(law.name, origin, additions, variant=variant)


def _damping(s: Scales) -> float:
    """Linear damping that makes a fiftieth of the inertia force at full speed, N s/m."""
    return 0.02 * s.force / s.speed


def _share(s: Scales, power: int) -> float:
    """Coefficient of displacement^power that makes a fiftieth of the inertia force at full motion."""
    return 0.02 * s.force / s.size**power


def _echo_starts(s: Scales) -> tuple[float, ...]:
    """Delays from one to eight periods in steps of half a period, s: a fit moves by a quarter of one."""
    return tuple(0.5 * n * 2.0 * math.pi / s.slowest for n in range(2, 17))


def _resonator(amplitude_dependent: bool = False) -> Callable[[Scales, float], tuple[Addition, ...]]:
    def additions(s: Scales, start: float) -> tuple[Addition, ...]:
        n = "1"
        found = (
            Addition("mass_kg", "kg", f"hm{n}", 0.08 * s.mass, 0.05 * s.mass, lower=0.0, upper=2.0 * s.mass),
            Addition(
                "natural_frequency_rad_per_s", "rad/s", f"hw{n}", start, 0.1 * start, 0.2 * s.slowest, 6.0 * s.fastest,
                inner=True,
            ),
            Addition("damping_ratio", "1", f"hz{n}", 0.02, 0.02, lower=0.0, upper=0.7, inner=True),
        )
        if not amplitude_dependent:
            return found
        return (
            *found,
            Addition("quadratic_damping_per_m", "1/m", f"hb{n}", 0.3 / s.size * 0.1, 0.1 / s.size, lower=0.0),
            Addition("cubic_stiffness_per_m2_s2", "1/m^2/s^2", f"hg{n}", 0.0, (0.1 * start / s.size) ** 2),
        )

    return additions


def kernel_additions(place: int, mass: float, frequency: float, damping: float) -> tuple[Addition, ...]:
    """Damping that depends on frequency, as one passive kernel of the second order: the integrator's hidden oscillator
    at its ``place``, strongly damped. It never gives energy (mass, damping >= 0) and takes most near its frequency."""
    return (
        Addition("kernel_mass_kg", "kg", f"hm{place}", mass, 0.1 * mass, lower=0.0),
        Addition(
            "kernel_frequency_rad_per_s", "rad/s", f"hw{place}", frequency, 0.1 * frequency, 0.05 * frequency,
            20.0 * frequency, inner=True,
        ),
        Addition("kernel_damping_ratio", "1", f"hz{place}", damping, 0.1, RINGS, 3.0, inner=True),
    )  # fmt: skip


def _resonator_starts(s: Scales) -> tuple[float, ...]:
    """Starting frequencies over and between the body's own: a step of a fifth."""
    low, high = 0.7 * s.slowest, 1.6 * s.fastest
    count = max(4, math.ceil(math.log(high / low) / math.log(1.35)))
    return tuple(low * (high / low) ** (i / (count - 1)) for i in range(count))


def _geometric(low: float, high: float, ratio: float) -> tuple[float, ...]:
    """Values from ``low`` to ``high`` in steps of ``ratio`` at most."""
    count = max(2, math.ceil(math.log(high / low) / math.log(ratio)) + 1)
    return tuple(low * (high / low) ** (i / (count - 1)) for i in range(count))


def _fine_frequencies(s: Scales) -> tuple[float, ...]:
    """Frequencies in steps of 3 %: the width of a line that 2 % damping or ten seconds of motion leave."""
    return _geometric(0.5 * s.slowest, 4.0 * s.fastest, 1.03)


def _force_frequencies(s: Scales) -> tuple[float, ...]:
    """Frequencies of a force, bound to no body: in steps of 3 % of the slowest one below it, of themselves above."""
    below = tuple(share * s.slowest for share in np.arange(0.13, 0.985, 0.03))
    return (*below, *_geometric(s.slowest, 4.0 * s.fastest, 1.03))


def _fine_times(s: Scales) -> tuple[float, ...]:
    """Times in steps of 1.3, from where one linear step tells a memory from damping on: a fit may go below."""
    return _geometric(0.5 / s.slowest, 10.0 / s.slowest, 1.3)


def _fine_delays(s: Scales) -> tuple[float, ...]:
    """Delays in steps of an eighth of the period, from one to eight periods."""
    period = 2.0 * math.pi / s.slowest
    return tuple(period * n / 8.0 for n in range(8, 65))


def _fine_speeds(s: Scales) -> tuple[float, ...]:
    return _geometric(0.01 * s.speed, 0.3 * s.speed, 3.2)


def _fine_yields(s: Scales) -> tuple[float, ...]:
    return _geometric(0.02 * s.size, 0.7 * s.size, 2.5)


SHORTEST_MEMORY = 0.25
"""Radians of the slowest body that a relaxation remembers at least: a faster one is damping, to a sixteenth of it."""


STIFFEST, STIFFEST_BRISTLES = 20.0, 3000.0
"""Stiffness over the body's own at which a memory holds it fast while it lasts, and bristles look like sliding."""


def _relaxation(s: Scales, start: float) -> tuple[Addition, ...]:
    k = s.mass * s.rate**2
    return (
        Addition("stiffness_N_per_m", "N/m", "rk1", 0.01 * k, 0.02 * k, lower=0.0, upper=STIFFEST * k),
        Addition("time_s", "s", "rt1", start, 0.5 * start, SHORTEST_MEMORY / s.slowest, 10.0 / s.slowest,
                 inner=True),
    )


WIDEST_YIELD = 2.0
"""Force at which a joint yields over the spring's largest force: one that does not yield then holds the body fast, or
is a spring."""


def _hysteresis(s: Scales, start: float) -> tuple[Addition, ...]:
    k = 0.02 * s.mass * s.rate**2
    most = WIDEST_YIELD * s.mass * s.rate**2 * s.size
    return (
        Addition("stiffness_N_per_m", "N/m", "kb", k, k, lower=0.0),
        Addition("yield_force_N", "N", "fb", k * start, k * start, 1e-3 * k * s.size, most, inner=True),
    )


def _small_hysteresis(s: Scales, start: float) -> tuple[Addition, ...]:
    """The same at one displacement of yield: however small, it yields there."""
    (stiffness, _) = _hysteresis(s, start)
    return (replace(stiffness, also=(("fb", start),)),)


def _presliding(s: Scales, start: float) -> tuple[Addition, ...]:
    """Bristles that yield at the force of dry friction: none is left beside them."""
    k = s.mass * s.rate**2
    size, least, most = k * start, 1e-3 * k, STIFFEST_BRISTLES * k
    return (Addition("stiffness_N_per_m", "N/m", "kb", size, size, least, most, moves=("fc", "fb")),)


def _mass_change(s: Scales, start: float) -> tuple[Addition, ...]:
    """A mass of each trial's own, about what all have."""
    size = MASS_STD * s.mass
    return (Addition("mass_kg", "kg", "mass", 0.0, size, scope="trial", prior_std=size),)


def _stribeck(s: Scales, start: float) -> tuple[Addition, ...]:
    return (
        Addition("static_force_N", "N", "fs", 1e-3 * s.force, 5e-3 * s.force, lower=0.0),
        Addition("velocity_m_per_s", "m/s", "vs", start, 0.5 * start, 1e-3 * s.speed, 0.5 * s.speed, inner=True),
    )


def _forcing(s: Scales, start: float) -> tuple[Addition, ...]:
    force, low, high = 5e-3 * s.force, 0.1 * s.slowest, 6.0 * s.fastest
    return (
        Addition("frequency_rad_per_s", "rad/s", "omega", start, 0.05 * start, low, high, inner=True),
        Addition("cosine_N", "N", "fcos", force, force, scope="trial"),
        Addition("sine_N", "N", "fsin", force, force, scope="trial"),
    )


def _changing(degree: int) -> Callable[[Scales, float], tuple[Addition, ...]]:
    """The same force, whose size and phase change along the record, as a narrow band's do: with Chebyshev's polynomials
    of time, from its beginning (1) to its end (-1), up to this one; nothing where the band would not be narrow."""
    def additions(s: Scales, frequency: float) -> tuple[Addition, ...]:
        if degree > NARROW * frequency * s.record / (2.0 * math.pi):
            return ()
        slots = {"omega": "gomega", "fcos": "gcos", "fsin": "gsin"}
        found = [replace(a, slot=slots[a.slot]) for a in _forcing(s, frequency)]
        for n in range(1, degree + 1):
            powers = Chebyshev.basis(n)(Polynomial([1.0, -2.0 / s.record])).coef  # the first is 1
            for a in found[1:3]:
                also = tuple((f"{a.slot}{ENVELOPE[i]}", float(powers[i])) for i in range(1, n + 1))
                found.append(replace(a, name=f"{a.name}_{n}", start=0.0, also=also))
        return tuple(found)

    return additions


def _echo(s: Scales, start: float) -> tuple[Addition, ...]:
    """An echo comes back after three quarters of the slowest period at the earliest: sooner it is damping. How much of
    a wave comes back depends on its length: each spring has its own gain."""
    gain = 0.01 * s.mass * s.rate
    return (
        Addition("gain", "N s/m", "ge", gain, gain, scope="spring"),
        Addition("delay_s", "s", "tau_e", start, 0.2 * start, 4.7 / s.slowest, 60.0 / s.slowest, inner=True),
    )


def _power_law(scope: Scope) -> Callable[[Scales, float], tuple[Addition, ...]]:
    """A drag coefficient that goes with a power of the amplitude goes with the frequency too: each spring's own."""
    def additions(s: Scales, start: float) -> tuple[Addition, ...]:
        size = 0.03 * s.force / s.speed**start
        first = Addition("coefficient_N_sp_per_mp", "N (s/m)^p", "cp", size, size, 0.0, scope=scope, replaces="q")
        return first, Addition("exponent", "1", "p", start, 0.2, 0.3, 4.0, inner=True)

    return additions


def _drifting_stiffness(s: Scales, start: float) -> tuple[Addition, ...]:
    """A hundredth of the stiffness, from two swings to far beyond the record: a straight line."""
    k = 0.01 * s.mass * s.rate**2
    return (
        Addition("N_per_m", "N/m", "kd", k, k, scope="spring"),
        Addition(
            "time_s", "s", "td", start, 0.5 * start, 2.0 / s.slowest, 2000.0 / s.slowest, inner=True, endless=True,
        ),
    )


def _sine(s: Scales, start: float) -> tuple[Addition, ...]:
    """A sine instead of a line: what it takes from the line at small angles it gives back."""
    k = 0.05 * s.mass * s.rate**2
    return (Addition("N_per_m", "N/m", "ks", k, k, also=(("k1", -1.0),)),)


_POWER_LAW = Suspect(
    DragExponent.name, "water", _power_law("shared"), lambda s: (1.4, 2.8), fine=lambda s: (0.6, 1.4, 2.5, 3.0)
)
_RESONATOR = Suspect(
    HiddenResonator.name, "water", _resonator(), _resonator_starts, memory=True, fine=_fine_frequencies, swings=True,
    often_beside=True, overdamped_as=Relaxation.name,
)  # fmt: skip
SUSPECTS: tuple[Suspect, ...] = (
    replace(_plain(AddedMass, "water", lambda s: 0.05 * s.mass), like=(HiddenResonator.name,)),
    replace(_plain(AddedStiffness, "water", lambda s: _share(s, 1)), like=(HiddenResonator.name,)),
    _plain(QuadraticDrag, "water", lambda s: 0.02 * s.force / s.speed**2),
    _POWER_LAW,
    replace(_POWER_LAW, additions=_power_law("spring"), variant=EACH_SPRING),
    replace(_plain(LinearDamping, "water", _damping, variant="one for all springs"), plain=True, often_beside=True),
    replace(_plain(LinearDamping, "water", _damping, "spring", EACH_SPRING), plain=True, often_beside=True),
    replace(_plain(CubicDamping, "water", lambda s: 0.02 * s.force / s.speed**3), often_beside=True),
    replace(_plain(CubicStiffness, "structure", lambda s: _share(s, 3), "spring"), often_beside=True),
    _plain(QuinticStiffness, "structure", lambda s: _share(s, 5), "spring"),
    replace(_plain(AsymmetricStiffness, "structure", lambda s: _share(s, 2), "spring"), often_beside=True),
    replace(_plain(CoulombFriction, "structure", lambda s: 2e-3 * s.force, "spring"), often_beside=True),
    Suspect(StiffnessDrift.name, "undetermined", _drifting_stiffness, lambda s: (30.0 / s.slowest, 150.0 / s.slowest),
            fine=lambda s: _geometric(10.0 / s.slowest, 300.0 / s.slowest, 2.5)),
    _plain(VariableNormalForce, "structure", lambda s: 0.01 * s.force / s.size),
    Suspect(StribeckFriction.name, "structure", _stribeck, lambda s: (0.03 * s.speed,), fine=_fine_speeds,
            becomes=("", CoulombFriction.name)),
    _RESONATOR,
    replace(_RESONATOR, additions=_resonator(True), variant="amplitude-dependent"),
    Suspect(
        Relaxation.name, "water", _relaxation, lambda s: (0.5 / s.slowest, 1.2 / s.slowest, 4.0 / s.slowest), True,
        fine=_fine_times, fades=True, becomes=(LinearDamping.name, ""),
    ),
    Suspect(
        Hysteresis.name, "structure", _hysteresis, lambda s: (0.1 * s.size, 0.3 * s.size), True, fine=_fine_yields,
        look=_small_hysteresis, without_sliding=BRISTLES,
    ),
    Suspect(
        BRISTLES, "structure", _presliding, lambda s: (0.1, 1.0), fine=lambda s: _geometric(0.03, 1000.0, 3.2),
        words="bristles that yield where dry friction would slide",
        next_test="a slow push and pull of less than the friction, displacement and load recorded",
    ),
    Suspect(
        "mass_change", "undetermined", _mass_change, words="a mass that differs from trial to trial",
        next_test="the body weighed before and after every trial",
    ),
    Suspect(
        ExternalForcing.name, "outside", _forcing, _resonator_starts, fine=_force_frequencies, on_a_line=True,
        often_beside=True, wider=tuple(_changing(degree) for degree in (1, 2, 4, 6)),
    ),
    Suspect(DelayedEcho.name, "outside", _echo, _echo_starts, True, fine=_fine_delays, fades=True, recurs=True),
    Suspect(SineRestoring.name, "structure", _sine, of_angles=True),
    *BAD_RELEASES,
    Suspect(
        "time_shift", "instrument", nothing, frees="acceleration_shift_s",
        words="an accelerometer whose clock differs from the displacement's",
        next_test="a tap on the body at rest, recorded by all sensors",
    ),
    Suspect(
        "gain_error", "instrument", nothing, frees="acceleration_gain",
        words="an accelerometer whose gain does not fit the displacement's",
        next_test="a slow known displacement, and the accelerometer turned over in gravity",
    ),
    Suspect(
        "sensor_drift", "instrument", nothing, frees=DRIFT, words="a displacement sensor that drifts", wider=(3, 6),
        next_test="a minute of record with the body at rest",
    ),
)  # fmt: skip
"""All suspects; within their stated priors the sensors' shift, gain and drift are nuisances of every fit."""


RADIATION = Suspect(
    LinearDamping.name, "water", lambda s, start: kernel_additions(1, 0.05 * s.mass, start, 0.3),
    variant="passive kernel", plain=True, like=(HiddenResonator.name, Relaxation.name),
)  # fmt: skip
"""Damping by radiated waves, which depends on frequency: what a resonator that hardly rings is called."""


def all_suspects() -> tuple[Suspect, ...]:
    """`SUSPECTS`, and one for every further law of the registry that says where it belongs (`Term.suspect_of`): its
    coefficient, with the size that makes a fiftieth of the inertia force at full motion."""
    have = {s.name for s in SUSPECTS}
    further = [law for law in catalogue() if law.suspect_of and law.slots and law.name not in have]
    return (*SUSPECTS, *(_plain(law, law.suspect_of or "undetermined", _size_of(law)) for law in further))


def _size_of(law: type[Term]) -> Callable[[Scales], float]:
    def size(s: Scales) -> float:
        x, v, still = np.array([s.size]), np.array([s.speed]), np.zeros(1)
        return 0.02 * s.force / (abs(float(law().force(x, v, still, still)[0])) or 1.0)

    return size


def chosen(names: str | tuple[str, ...], rotation: bool = False) -> tuple[Suspect, ...]:
    """The suspects of a config's ``discrepancy.suspects``: all (a sine only where an angle is the coordinate:
    ``rotation``), or those named.

    ConfigError for a name that is no suspect.
    """
    if names == "all":
        return tuple(s for s in all_suspects() if rotation or not s.of_angles)
    known = {s.name: None for s in all_suspects()}
    for name in names:
        if name not in known:
            raise ConfigError(f"discrepancy.suspects: {name!r} is none of {', '.join(known)}")
    return tuple(s for s in all_suspects() if s.name in names)
