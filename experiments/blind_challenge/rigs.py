"""Laboratories: bodies from one kilogram to a ship, their springs, waters, sensors and trials, drawn by chance.

Everything scales with the body: lengths with its size, releases with its length, noise with the release. A rig knows
the true mean numbers of Eq. 15; what its laboratory writes down is decided in `laboratory`.
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np

from experiments.blind_challenge.truths.motion import Body

GRAVITY = 9.81  # m/s^2
WATER = 1000.0  # kg/m^3
TERMS = ("stiffness", "viscous_damping", "coulomb_friction", "added_mass", "quadratic_drag")
MOST_TRIALS = 30  # in a campaign, so that a search takes seconds
MOST_SAMPLES = 3000  # after the release, in a trial


@dataclass(frozen=True)
class Level:
    """A water depth (m): added mass (kg), drag q (N s^2/m^2), area (m^2), wet volume (m^3), share of effects."""

    depth: float
    added_mass: float = 0.0
    drag: float = 0.0
    area: float = 0.0
    volume: float = 0.0
    share: float = 0.0

    @property
    def wet(self) -> bool:
        """Whether there is water at the body."""
        return self.share > 0.0


@dataclass(frozen=True)
class Trial:
    """A release: file, spring, level, release (m), factors on k, c and mu, hold (s), clock (s), where it rests (m)."""

    file: str
    spring: int
    level: int
    release: float
    factors: tuple[float, float, float]
    hold: float
    first: float  # time of the first sample after the release, s
    clock: float
    rest: float = 0.0


@dataclass(frozen=True)
class Sensor:
    """A channel: noise (SI, 1 sigma), correlation from sample to sample, zero offset (SI), unit with its size in SI,
    step.
    """

    channel: str
    noise: float
    correlation: float
    offset: float
    unit: str
    unit_size: float
    column: str


@dataclass(frozen=True)
class Rig:
    """True means of a campaign and the way it was recorded. Springs are stiffnesses (N/m), dampings in N s/m."""

    mass: float
    springs: tuple[float, ...]
    dampings: tuple[float, ...]
    mu: float
    levels: tuple[Level, ...]
    scatter: tuple[float, float, float]
    scatter_shape: str
    largest: float
    step: float
    periods: float
    trials: tuple[Trial, ...]
    sensors: tuple[Sensor, ...]
    coordinate: str = "translation"
    terms: tuple[str, ...] = TERMS
    knows: frozenset[str] = frozenset()
    facts: dict[str, object] = field(default_factory=dict)

    def body(self, spring: int, level: int, factors: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> Body:
        """Eq. 15 of a spring and a level, with factors on k, c and mu; at rest where the springs are."""
        water = self.levels[level]
        normal = GRAVITY * (self.mass - WATER * water.volume)
        k, c, mu = self.springs[spring] * factors[0], self.dampings[spring] * factors[1], self.mu * factors[2]
        return Body(self.mass + water.added_mass, c, k, mu * normal, water.drag)

    @property
    def reference(self) -> Body:
        """Eq. 15 of the first spring in the fullest water."""
        shares = [level.share for level in self.levels]
        return self.body(0, int(np.argmax(shares)))

    @property
    def dry_trials(self) -> int:
        """How many trials were made without water."""
        return sum(not self.levels[trial.level].wet for trial in self.trials)

    def groups(self) -> list[tuple[int, int]]:
        """Spring and level of every group, in order."""
        return sorted({(trial.spring, trial.level) for trial in self.trials})


@dataclass(frozen=True)
class Needs:
    """What a truth asks of its laboratory."""

    dry: str | None = None  # none, few, many; None: any
    trials: tuple[int, int] = (1, 20)  # in the first wet group
    springs: tuple[int, ...] = (1, 1, 2)
    levels: tuple[int, ...] = (1, 1, 2, 2, 3)
    coordinate: str | None = None
    channels: tuple[str, ...] = ()
    frequency: tuple[float, float] = (0.3, 10.0)
    knows_mass: bool = False
    friction: bool = False
    quiet: bool = False
    spread: tuple[float, float] = (0.25, 0.75)  # smallest release over the largest


def _size(rng: np.random.Generator, needs: Needs) -> tuple[float, float, float]:
    """Mass (kg), frequency (Hz) and largest release (m): heavy bodies are long and slow."""
    mass = 10.0 ** rng.uniform(0.0, 7.0)
    length = (mass / (0.5 * WATER)) ** (1.0 / 3.0)
    frequency = 3.0 * mass ** (-1.0 / 6.0) * math.exp(rng.normal(0.0, 0.7))
    low, high = needs.frequency
    if not low <= frequency <= high:
        frequency = math.exp(rng.uniform(math.log(low), math.log(min(high, 3.0 * low))))
    return mass, frequency, length * rng.uniform(0.02, 0.12)


def _levels(rng: np.random.Generator, mass: float, largest: float, needs: Needs, dry: bool) -> tuple[Level, ...]:
    """Dry level first where there is one, then the wet ones from shallow to deep."""
    count = int(rng.choice(needs.levels))
    full_mass, full_drag = rng.uniform(0.1, 0.8) * mass, 10.0 ** rng.uniform(-1.7, -0.5) * mass / largest
    volume = rng.uniform(0.1, 0.5) * mass / WATER
    shares = [*np.sort(rng.uniform(0.35, 0.9, count - 1)).tolist(), 1.0]
    size = (mass / WATER) ** (1.0 / 3.0)
    depth = size * rng.uniform(1.0, 3.0)
    area = 2.0 * full_drag / WATER / rng.uniform(0.6, 2.5)
    wet = [
        Level(
            round(depth + size * share, 3),
            full_mass * share,
            full_drag * share,
            float(f"{area * share:.4g}"),
            float(f"{volume * share:.4g}"),
            share,
        )
        for share in shares
    ]
    return (Level(round(0.8 * depth, 3)), *wet) if dry else tuple(wet)


def factors(rng: np.random.Generator, scatter: tuple[float, float, float], shape: str) -> tuple[float, float, float]:
    """Factors of a trial on k, c and mu; every shape of scatter has the stated standard deviation."""
    draws = rng.normal(size=3)
    if shape == "student":
        draws = rng.standard_t(3, size=3) / math.sqrt(3.0)
    elif shape == "two groups":
        draws = np.where(rng.random(3) < 0.5, -1.0, 1.0) * 0.95 + rng.normal(size=3) * math.sqrt(1.0 - 0.95**2)
    elif shape == "skewed":
        draws = rng.exponential(size=3) - 1.0
    values = 1.0 + np.clip(draws, -4.0, 4.0) * np.asarray(scatter)
    return float(values[0]), float(max(values[1], 0.05)), float(max(values[2], 0.05))


def _counts(
    rng: np.random.Generator, needs: Needs, springs: int, levels: tuple[Level, ...], dry: str
) -> list[list[int]]:
    """Trials a spring and level."""
    low, high = needs.trials
    first = round(math.exp(rng.uniform(math.log(low), math.log(high + 0.49))))
    out = []
    room = MOST_TRIALS
    for spring in range(springs):
        row = []
        for level in levels:
            if not level.wet:
                n = int(rng.integers(1, 4)) if dry == "few" else int(rng.integers(4, 9 if springs == 1 else 6))
                n = max(1, n // springs) if dry == "few" else n
            elif level.share == 1.0 and spring == 0:
                n = first
            else:
                n = min(first, round(math.exp(rng.uniform(math.log(max(1, min(low, 3))), math.log(6.4)))))
            n = max(1, min(n, room - 1))
            room = max(2, room - n)
            row.append(n)
        out.append(row)
    return out


def _sensors(rng: np.random.Generator, needs: Needs, largest: float, body: Body, rotation: bool) -> tuple[Sensor, ...]:
    """Displacement always, acceleration and spring force sometimes, with noise relative to the largest release."""
    noise = 10.0 ** rng.uniform(-4.0, -2.6 if needs.quiet else math.log10(0.03))
    correlation = float(rng.uniform(0.3, 0.8)) if rng.random() < 0.1 else 0.0
    length = [("deg", math.pi / 180.0), ("rad", 1.0)] if rotation else [("m", 1.0), ("mm", 1e-3), ("cm", 1e-2)]
    force = [("N", 1.0), ("kN", 1e3)]
    rate = [("rad/s^2", 1.0)] if rotation else [("m/s^2", 1.0), ("g", GRAVITY)]
    out = []
    columns = [f"ch{i}" for i in rng.permutation(6)]
    tops = {
        "displacement": largest,
        "acceleration": body.frequency**2 * largest,
        "spring_force": body.stiffness * largest,
    }
    for channel, units in (("displacement", length), ("acceleration", rate), ("spring_force", force)):
        chance = 1.0 if channel == "displacement" or channel in needs.channels else 0.3
        if rng.random() >= chance or (rotation and channel == "spring_force"):
            continue
        own = noise if channel == "displacement" else noise * 10.0 ** rng.uniform(-0.3, 0.8)
        unit, size = units[rng.integers(len(units))]
        zero = float(rng.normal(0.0, 0.003)) if channel != "acceleration" else float(rng.normal(0.0, 0.001))
        top = tops[channel]
        out.append(Sensor(channel, own * top, correlation, zero * top, unit, size, columns[len(out)]))
    return tuple(out)


def draw_rig(rng: np.random.Generator, needs: Needs, dry: str) -> Rig:
    """A laboratory that meets `needs`; `dry` is none, few or many."""
    rotation = needs.coordinate == "rotation" or (
        needs.coordinate is None and not needs.channels and rng.random() < 0.06
    )
    mass, frequency, largest = _size(rng, needs)
    if rotation:
        largest = rng.uniform(0.15, 0.7)
    levels = _levels(rng, mass, largest, needs, dry != "none")
    if rotation:
        levels = tuple(replace(level, volume=0.0) for level in levels)
    count = int(rng.choice(needs.springs))
    stiffness = mass * (2.0 * math.pi * frequency) ** 2
    springs = (stiffness,) if count == 1 else (stiffness, stiffness * rng.uniform(1.5, 2.2))
    ratio = 10.0 ** rng.uniform(-2.7, -1.5)
    dampings = tuple(2.0 * ratio * math.sqrt(k * mass) for k in springs)
    level = 10.0 ** rng.uniform(-2.7, -1.5)  # Coulomb force over the force of the largest release
    if needs.friction:
        level = max(level, 5e-3)
    mu = level * stiffness * largest / (GRAVITY * mass)
    scatter = (10.0 ** rng.uniform(-3.0, -2.0), rng.uniform(0.03, 0.2), rng.uniform(0.03, 0.12))
    shape = "normal" if rng.random() < 0.85 else str(rng.choice(["student", "two groups", "skewed"]))
    rig = Rig(
        mass,
        springs,
        dampings,
        mu,
        levels,
        scatter,
        shape,
        largest,
        1.0,
        rng.uniform(10.0, 25.0),
        (),
        (),
        "rotation" if rotation else "translation",
    )
    fastest = max(rig.body(s, i).frequency for s in range(count) for i in range(len(levels)))
    rig = replace(rig, step=_clean(2.0 * math.pi / fastest / rng.uniform(60.0, 120.0)))
    rig = replace(rig, sensors=_sensors(rng, needs, largest, rig.reference, rotation))
    rig = replace(rig, trials=_trials(rng, needs, rig, dry))
    return replace(rig, knows=_knowledge(rng, needs, rig, dry))


def _clean(step: float) -> float:
    """A sampling step that prints in few digits, s."""
    return float(f"{step:.3g}")


def _trials(rng: np.random.Generator, needs: Needs, rig: Rig, dry: str) -> tuple[Trial, ...]:
    """Releases between a share of the largest and the largest, in the order in which they were made."""
    counts = _counts(rng, needs, len(rig.springs), rig.levels, dry)
    smallest = rng.uniform(*needs.spread)
    plan = [(s, i) for s, row in enumerate(counts) for i, n in enumerate(row) for _ in range(n)]
    names = rng.choice(16**4, size=len(plan), replace=False)
    out = []
    clock = 0.0
    for (spring, level), name in zip(plan, names, strict=True):
        body = rig.body(spring, level)
        period = 2.0 * math.pi / body.frequency
        same = sum(trial.spring == spring and trial.level == level for trial in out)
        release = rig.largest * (1.0 if same == 0 else rng.uniform(smallest, 1.0))
        out.append(
            Trial(
                f"r{name:04x}.csv",
                spring,
                level,
                float(release),
                factors(rng, rig.scatter, rig.scatter_shape),
                float(rng.uniform(0.5, 1.2) * period),
                float(rig.step * rng.integers(1, 5) / 4.0),
                clock,
                float(rng.normal(0.0, 0.002) * rig.largest),
            )
        )
        clock += float(rng.uniform(60.0, 200.0) * period)
    return tuple(out)


def _knowledge(rng: np.random.Generator, needs: Needs, rig: Rig, dry: str) -> frozenset[str]:
    """What the laboratory writes in its config."""
    known = set()
    if needs.knows_mass or rng.random() < 0.85:
        known.add("mass")
    if rng.random() < 0.5:
        known.add("stiffness")
    if rng.random() < 0.8:
        known.add("area")
    if rng.random() < (0.6 if dry == "none" else 0.15):
        known.add("scatter")
    return frozenset(known)
