"""Who can be missing: every suspect, its unknowns, and where it comes from.

Belongs here: what a suspect adds to an equation, in slots of the integrator, with starts and bounds. Does not belong
here: the search (search.py).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

from undertow.errors import ConfigError

Scope = Literal["shared", "spring", "trial"]
Origin = Literal["water", "structure", "outside", "instrument", "undetermined"]

EACH_SPRING = "each spring's own"
"""Variant of a suspect that a level with one spring cannot tell from the shared one."""


MASS_STD = 0.1
"""Prior of a mass taken on or lost, relative to the body's."""

RINGS = 0.05
"""A resonator damped more than this loses a quarter of its swing in a cycle: it may be a kernel of fading memory."""


@dataclass(frozen=True)
class Scales:
    """Sizes of one level's motion: mass (kg), angular rate (rad/s), speed (m/s), displacement (m), slowest and
    fastest body rate over the springs (rad/s)."""

    mass: float
    rate: float
    speed: float
    size: float
    slowest: float
    fastest: float

    @property
    def force(self) -> float:
        """Inertia force at full motion, N."""
        return self.mass * self.rate * self.speed


@dataclass(frozen=True)
class Addition:
    """One unknown of a suspect: contract name, unit, slot, start, bounds, and whether all trials share it.

    ``inner`` marks what has no effect where the coefficient beside it is zero (a frequency, a time). ``replaces`` is
    the slot of a coefficient of the equation that is left out beside it; ``also`` a slot that it moves too, with the
    factor (a sine instead of a line); ``by_spring`` (label, value, standard error) what each spring's dry trials say;
    ``moves`` says that everything in the first slot, scatter included, stands in the second instead (dry friction
    becomes the yield force of bristles).
    """

    name: str
    unit: str
    slot: str
    start: float
    scale: float
    lower: float = -math.inf
    upper: float = math.inf
    scope: Scope = "shared"
    prior_std: float = math.inf
    inner: bool = False
    replaces: str = ""
    also: tuple[str, float] | None = None
    by_spring: tuple[tuple[str, float, float], ...] = ()
    moves: tuple[str, str] | None = None

    @property
    def differs(self) -> bool:
        """Whether what it says is how trials differ: their own numbers about what all share, held by a prior."""
        return self.scope == "trial" and math.isfinite(self.prior_std)

    @property
    def of_its_own(self) -> bool:
        """Whether every trial has its own and nothing is known of it beforehand: size and phase of an outside force.
        (A speed at the release is adjusted in every free run.)"""
        return self.scope == "trial" and not math.isfinite(self.prior_std) and self.slot != "v0"


@dataclass(frozen=True)
class Suspect:
    """A suspect: its name in the contract, where it comes from when found wet but not dry, and its unknowns.

    ``additions`` gives the unknowns at one start; ``starts`` are alternative first values of the searched parameter
    (frequency, time), ``fine`` the steps in which a small one is looked for; ``memory`` tells whether it remembers.
    ``frees`` names a nuisance of every trial (a sensor's clock, gain, drift) whose prior is widened instead: what it
    says is in the instrument, and no free run of the displacement shows it. ``on_a_line`` says that a fit finds it from
    a start within its line only (a clock). ``late`` asks nothing of so many first periods: what is wrong
    with the release shows there and nowhere else.
    """

    name: str
    origin: Origin
    additions: Callable[[Scales, float], tuple[Addition, ...]]
    starts: Callable[[Scales], tuple[float, ...]] = lambda scales: (0.0,)
    memory: bool = False
    variant: str = ""
    fine: Callable[[Scales], tuple[float, ...]] | None = None
    frees: str = ""
    on_a_line: bool = False
    late: float = 0.0

    @property
    def has_no_zero(self) -> bool:
        """Whether no small value of it is as if it were not there (bristles: infinitely stiff ones are)."""
        return self.late > 0.0 or any(a.moves for a in self.additions(UNIT, 1.0))

    @property
    def of_the_release(self) -> bool:
        """Whether it says what was wrong with the release, and nothing of what moves."""
        return self.name == "imperfect_release"

    @property
    def has_its_own_clock(self) -> bool:
        """Whether it acts on the body whatever that does, with a size and a phase of its own in every trial."""
        return self.name == "external_forcing"

    @property
    def shown_by_free_run(self) -> bool:
        """Whether what it adds can bring a free run of the displacement closer (x0, v0 are adjusted anyway)."""
        return not (self.frees or self.of_the_release)

    def grid(self, scales: Scales) -> tuple[tuple[Addition, ...], ...]:
        """The additions at every place where a small effect is looked for."""
        places = (self.fine or self.starts)(scales)
        return tuple(self.additions(scales, start) for start in places)

    @property
    def label(self) -> str:
        """Name with its variant, for tables of rivals."""
        return f"{self.name} ({self.variant})" if self.variant else self.name


UNIT = Scales(1.0, 1.0, 1.0, 1.0, 1.0, 1.0)
"""Scales of one, to ask a suspect what it is made of."""


def _plain(
    name: str,
    origin: Origin,
    parameter: tuple[str, str, str],
    size: Callable[[Scales], float],
    scope: Scope = "shared",
    variant: str = "",
) -> Suspect:
    """A suspect with one coefficient: (contract name, unit, slot), starting from nothing."""
    label, unit, slot = parameter

    def additions(scales: Scales, start: float) -> tuple[Addition, ...]:
        return (Addition(label, unit, slot, 0.0, size(scales), scope=scope),)

    return Suspect(name, origin, additions, variant=variant)


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
    """Values from ``low`` to ``high``, each at most ``ratio`` times the one before."""
    count = max(2, math.ceil(math.log(high / low) / math.log(ratio)) + 1)
    return tuple(low * (high / low) ** (i / (count - 1)) for i in range(count))


def _fine_frequencies(s: Scales) -> tuple[float, ...]:
    """Frequencies in steps of 3 %: the width of a line that 2 % damping or ten seconds of motion leave."""
    return _geometric(0.5 * s.slowest, 2.5 * s.fastest, 1.03)


def _fine_times(s: Scales) -> tuple[float, ...]:
    return _geometric(0.7 / s.slowest, 10.0 / s.slowest, 1.3)


def _fine_delays(s: Scales) -> tuple[float, ...]:
    """Delays in steps of an eighth of the period, from one to eight periods."""
    period = 2.0 * math.pi / s.slowest
    return tuple(period * n / 8.0 for n in range(8, 65))


def _fine_speeds(s: Scales) -> tuple[float, ...]:
    return _geometric(0.01 * s.speed, 0.3 * s.speed, 3.2)


def _fine_yields(s: Scales) -> tuple[float, ...]:
    return _geometric(0.02 * s.size, 0.7 * s.size, 2.5)


def _relaxation(s: Scales, start: float) -> tuple[Addition, ...]:
    """A relaxation must remember longer than two thirds of a radian of the slowest body: a faster one is damping."""
    return (
        Addition(
            "stiffness_N_per_m", "N/m", "rk1", 0.01 * s.mass * s.rate**2, 0.02 * s.mass * s.rate**2,
            lower=0.0, upper=STIFFEST * s.mass * s.rate**2,
        ),
        Addition("time_s", "s", "rt1", start, 0.5 * start, 0.7 / s.slowest, 10.0 / s.slowest, inner=True),
    )


def _hysteresis(s: Scales, start: float) -> tuple[Addition, ...]:
    k = 0.02 * s.mass * s.rate**2
    return (
        Addition("stiffness_N_per_m", "N/m", "kb", k, k, lower=0.0),
        Addition("yield_force_N", "N", "fb", k * start, k * start, lower=1e-3 * k * s.size, inner=True),
    )


STIFFEST = 20.0
"""Stiffness of bristles over the body's own from which on they cannot be told from sliding (and are slow to follow)."""


def _presliding(s: Scales, start: float) -> tuple[Addition, ...]:
    """Bristles that yield at the force of dry friction: none is left beside them."""
    k = s.mass * s.rate**2
    size, least, most = k * start, 1e-3 * k, STIFFEST * k
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
    force = 5e-3 * s.force
    return (
        Addition(
            "frequency_rad_per_s", "rad/s", "omega", start, 0.05 * start, 0.1 * s.slowest, 6.0 * s.fastest, inner=True
        ),
        Addition("cosine_N", "N", "fcos", force, force, scope="trial"),
        Addition("sine_N", "N", "fsin", force, force, scope="trial"),
    )


def _echo(s: Scales, start: float) -> tuple[Addition, ...]:
    """An echo comes back after three quarters of the slowest period at the earliest: sooner it is damping. How much of
    a wave comes back depends on its length: each spring has its own gain."""
    gain = 0.01 * s.mass * s.rate
    return (
        Addition("gain", "N s/m", "ge", gain, gain, scope="spring"),
        Addition("delay_s", "s", "tau_e", start, 0.2 * start, 4.7 / s.slowest, 60.0 / s.slowest, inner=True),
    )


def _drag_exponent(s: Scales, start: float) -> tuple[Addition, ...]:
    size = 0.03 * s.force / s.speed**start
    return (
        Addition("coefficient_N_sp_per_mp", "N (s/m)^p", "cp", size, size, lower=0.0, replaces="q"),
        Addition("exponent", "1", "p", start, 0.2, 0.3, 4.0, inner=True),
    )


def _sine(s: Scales, start: float) -> tuple[Addition, ...]:
    """A sine instead of a line: what it takes from the line at small angles it gives back."""
    k = 0.05 * s.mass * s.rate**2
    return (Addition("N_per_m", "N/m", "ks", k, k, also=("k1", -1.0)),)


def _release(s: Scales, start: float) -> tuple[Addition, ...]:
    """Each trial's own speed at the release."""
    return (Addition("velocity_m_per_s", "m/s", "v0", 0.0, 0.02 * s.speed, scope="trial"),)


def _nothing(s: Scales, start: float) -> tuple[Addition, ...]:
    return ()


SUSPECTS: tuple[Suspect, ...] = (
    _plain("added_mass", "water", ("mass_kg", "kg", "mass"), lambda s: 0.05 * s.mass),
    _plain("quadratic_drag", "water", ("drag_Ns2_per_m2", "N s^2/m^2", "q"), lambda s: 0.02 * s.force / s.speed**2),
    Suspect("drag_exponent", "water", _drag_exponent, lambda s: (1.4, 2.8), fine=lambda s: (0.6, 1.4, 2.5, 3.0)),
    _plain("linear_damping", "water", ("c_Ns_per_m", "N s/m", "c1"), _damping, variant="one for all springs"),
    _plain("linear_damping", "water", ("c_Ns_per_m", "N s/m", "c1"), _damping, "spring", EACH_SPRING),
    _plain("cubic_damping", "water", ("Ns3_per_m3", "N s^3/m^3", "c3"), lambda s: 0.02 * s.force / s.speed**3),
    _plain("cubic_stiffness", "structure", ("N_per_m3", "N/m^3", "k3"), lambda s: _share(s, 3), "spring"),
    _plain("quintic_stiffness", "structure", ("N_per_m5", "N/m^5", "k5"), lambda s: _share(s, 5), "spring"),
    _plain("asymmetric_stiffness", "structure", ("N_per_m2", "N/m^2", "k2"), lambda s: _share(s, 2), "spring"),
    _plain("coulomb_friction", "structure", ("force_N", "N", "fc"), lambda s: 2e-3 * s.force, "spring"),
    _plain("variable_normal_force", "structure", ("N_per_m", "N/m", "fn"), lambda s: 0.01 * s.force / s.size),
    Suspect("stribeck_friction", "structure", _stribeck, lambda s: (0.03 * s.speed,), fine=_fine_speeds),
    Suspect("hidden_resonator", "water", _resonator(), _resonator_starts, memory=True, fine=_fine_frequencies),
    Suspect(
        "hidden_resonator", "water", _resonator(True), _resonator_starts, True, "amplitude-dependent", _fine_frequencies
    ),
    Suspect("relaxation", "water", _relaxation, lambda s: (1.2 / s.slowest, 4.0 / s.slowest), True, fine=_fine_times),
    Suspect("hysteresis", "structure", _hysteresis, lambda s: (0.2 * s.size,), True, fine=_fine_yields),
    Suspect("presliding", "structure", _presliding, lambda s: (0.1, 1.0)),
    Suspect("mass_change", "undetermined", _mass_change),
    Suspect("external_forcing", "outside", _forcing, _resonator_starts, fine=_fine_frequencies, on_a_line=True),
    Suspect("delayed_echo", "outside", _echo, _echo_starts, True, fine=_fine_delays),
    Suspect("sine_restoring", "structure", _sine),
    Suspect("imperfect_release", "outside", _release),
    Suspect("imperfect_release", "outside", _nothing, variant="a hold that fades", late=1.0),
    Suspect("time_shift", "instrument", _nothing, frees="acceleration_shift_s"),
    Suspect("gain_error", "instrument", _nothing, frees="acceleration_gain"),
    Suspect("sensor_drift", "instrument", _nothing, frees="drift_m"),
)
"""All suspects; within their stated priors the sensors' shift, gain and drift are nuisances of every fit."""


RADIATION = Suspect(
    "linear_damping", "water", lambda s, start: kernel_additions(1, 0.05 * s.mass, start, 0.3), variant="passive kernel"
)
"""Damping by radiated waves, which depends on frequency: what a resonator that hardly rings is called."""


def chosen(names: str | tuple[str, ...], rotation: bool = False) -> tuple[Suspect, ...]:
    """The suspects of a config's ``discrepancy.suspects``: all (a sine only where an angle is the coordinate:
    ``rotation``), or those named.

    ConfigError for a name that is no suspect.
    """
    if names == "all":
        return tuple(s for s in SUSPECTS if rotation or s.name != "sine_restoring")
    known: Mapping[str, None] = dict.fromkeys(s.name for s in SUSPECTS)
    for name in names:
        if name not in known:
            raise ConfigError(f"discrepancy.suspects: {name!r} is none of {', '.join(known)}")
    return tuple(s for s in SUSPECTS if s.name in names)
