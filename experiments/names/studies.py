"""The studies: which campaigns are made, by a seed alone.

Belongs here: plans drawn from seeds, the cases of every study. Does not belong here: verdicts (verdicts.py), tables
(page.py).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from experiments.names.effects import EFFECTS, find
from experiments.names.folder import View
from experiments.names.rigs import Plan
from experiments.names.scenes import Campaign
from experiments.names.strength import size_for

STRENGTHS = (0.5, 1.5, 4.0)
"""Around what can be detected: half, one and a half, and four times what repeating the test gives."""

HIDDEN_IN = 4
"""Most wet trials a spring where something is hidden; nulls have up to six."""

POOR = 10.0
"""Noise of poor sensors (0.5 mm, 0.5 m/s^2) over those of the Eq. 15 campaign: with good ones a damped resonator and a
relaxation, damping and drag are distinguished wherever they are seen at all."""

BRIEF_S = 2.0
"""Seconds in which the short spring swings four times, and drag has hardly an amplitude to depend on."""

TOGETHER = (
    *(("linear_damping", "cubic_stiffness"), ("hidden_resonator", "linear_damping")),
    *(("hidden_resonator", "external_forcing"), ("cubic_damping", "asymmetric_stiffness")),
    *(("relaxation", "sensor_drift"), ("hidden_resonator", "cubic_stiffness")),
)
"""Two effects at once that a free decay can distinguish."""


@dataclass(frozen=True)
class Case:
    """One campaign of a study: its label (study, what is hidden, strength, seed), what is made, how it is written."""

    label: dict[str, str | float | int]
    campaign: Campaign
    view: View = field(default_factory=View)


def plan_of(seed: int, name: str = "", most: int = 6) -> Plan:
    """A plan drawn from a seed: one or two springs, 3 to ``most`` trials, 100, 250 or 1000 Hz, 10 to 15 s, either
    scatter. One in six is at 1000 Hz, which is slow to judge."""
    rng = np.random.default_rng([seed, 0])
    springs = (("short",), ("long",), ("short", "long"))[rng.integers(3)]
    return Plan(
        seed,
        find(name).rig if name else find("linear_damping").rig,
        springs,
        wet_trials=int(rng.integers(3, most + 1)),
        dry_trials=int(rng.integers(3, min(most, 5) + 1)),
        rate_hz=float((100.0, 100.0, 250.0, 250.0, 250.0, 1000.0)[rng.integers(6)]),
        seconds=float(rng.uniform(10.0, 15.0)),
        scatter=("report", "careful")[rng.integers(2)],
    )


def nulls(seeds: range) -> Iterator[Case]:
    """Nothing is hidden; every other campaign's config states the scatter, the others leave it to the dry trials."""
    for seed in seeds:
        label = {"study": "nulls", "hidden": "", "strength": 0.0, "seed": seed}
        yield Case(label, Campaign(plan_of(seed)), View(stated=seed % 2 == 1))


def confusion(seeds: range, names: tuple[str, ...] = (), strengths: tuple[float, ...] = STRENGTHS) -> Iterator[Case]:
    """Every name at every strength."""
    for seed in seeds:
        for strength in strengths:
            for name in names or tuple(e.name for e in EFFECTS):
                yield hidden_case("confusion", (name,), strength, seed)


def pairs(seeds: range, names: tuple[str, ...] = (), strengths: tuple[float, ...] = STRENGTHS) -> Iterator[Case]:
    """Two effects at once, each at the strength."""
    for seed in seeds:
        for strength in strengths:
            for two in TOGETHER:
                if not names or set(two) & set(names):
                    yield hidden_case("pairs", two, strength, seed)


def hidden_case(study: str, names: tuple[str, ...], strength: float, seed: int) -> Case:
    """A campaign of a seed with effects of a strength hidden in it."""
    plan = plan_of(seed, names[0], HIDDEN_IN)
    found = {name: size_for(plan, name, strength) for name in names}
    label = {
        "study": study, "hidden": "+".join(names), "strength": strength, "seed": seed,
        "size": "+".join(f"{size:.4g}" for size, _ in found.values()),
        "reached": round(min(reached for _, reached in found.values()), 2),
    }  # fmt: skip
    return Case(label, Campaign(plan, {name: size for name, (size, _) in found.items()}), View(stated=seed % 2 == 1))


def inseparable(seeds: range) -> Iterator[Case]:
    """Effects that a free decay cannot tell from another: each of a pair as the truth in turn."""
    for seed in seeds:
        plan = replace(plan_of(seed, most=HIDDEN_IN), springs=("short",))
        mass = plan.rig.mass
        rate = math.sqrt(plan.rig.springs["short"].k / mass)
        far = {"hm": 0.15 * mass, "hw": 6.0 * rate, "hz": 0.01, "M": mass}
        damped = {"hm": 0.25 * mass, "hw": 1.1 * rate, "hz": 0.6}
        poor = replace(plan, rig=plan.rig.noisier(POOR))
        brief = replace(poor, spread=1.1, seconds=BRIEF_S)
        linear = {"quadratic_drag": 0.0, "linear_damping": 5.0}
        for names, truth, campaign in (
            ("added_mass+hidden_resonator", "hidden_resonator", Campaign(plan, {"added_mass": 0.0}, far)),
            ("added_mass+hidden_resonator", "added_mass", Campaign(plan, {"added_mass": 1.0})),
            ("hidden_resonator+relaxation", "hidden_resonator", Campaign(poor, {}, damped)),
            ("hidden_resonator+relaxation", "relaxation", Campaign(poor, {"relaxation": 0.4})),
            ("linear_damping+quadratic_drag", "quadratic_drag", Campaign(brief, {"quadratic_drag": 3.0})),
            ("linear_damping+quadratic_drag", "linear_damping", Campaign(brief, linear)),
        ):
            label = {"study": "inseparable", "hidden": names, "strength": 0.0, "seed": seed, "view": f"truth {truth}"}
            yield Case(label, campaign)


def seiche(seeds: range) -> Iterator[Case]:
    """Forces with a clock of their own, steady or slowly dying, and resonators at the same rates."""
    for seed in seeds:
        rng = np.random.default_rng([seed, 10])
        decay = float((0.0, rng.uniform(0.01, 0.1))[seed % 2])
        for name in ("external_forcing", "hidden_resonator"):
            case = hidden_case("seiche", (name,), round(float(rng.uniform(1.5, 4.0)), 2), seed)
            if name == "external_forcing" and decay:
                case = replace(case, campaign=replace(case.campaign, extra={"dec": decay}))
            dies = round(decay, 3) if name == "external_forcing" else ""
            yield replace(case, label=case.label | {"decay_per_s": dies})


def near_seiche(seeds: range) -> Iterator[Case]:
    """Forces with a clock of their own close to the body's own rate: 0.85 to 1.2 of it."""
    for seed in seeds:
        rng = np.random.default_rng([seed, 12])
        plan = plan_of(seed, "external_forcing", HIDDEN_IN)
        wet = next(t for t in plan.trials() if t.wet and t.spring == plan.springs[0])
        rate = math.sqrt(plan.means(wet)["k"] / plan.means(wet)["M"])
        share, size = float(rng.uniform(0.85, 1.2)), float(np.exp(rng.uniform(math.log(0.008), math.log(0.04))))
        label = {
            "study": "near_seiche", "hidden": "external_forcing", "strength": 0.0, "seed": seed,
            "size": f"{size:.4g}", "view": f"{share:.2f} of the body's rate",
        }  # fmt: skip
        yield Case(label, Campaign(plan, {"external_forcing": size}, {"om": share * rate}), View(stated=seed % 2 == 1))


VIEWS: dict[str, tuple[View, float]] = {
    "as recorded at 250 Hz": (View(), 250.0),
    "100 Hz": (View(), 100.0),
    "1000 Hz": (View(), 1000.0),
    "mm and g": (View(millimetres=True), 250.0),
    "mirrored": (View(mirrored=True), 250.0),
    "shuffled": (View(shuffled=True), 250.0),
    "rest level 1 cm up": (View(level_m=0.01), 250.0),
    "window a period longer": (View(cycles=1.0), 250.0),
    "window a period shorter": (View(cycles=-1.0), 250.0),
}
"""The same campaign written in other ways; the first is what the others are held against."""


def invariance(seeds: range) -> Iterator[Case]:
    """The same campaign in every view: in turn a null, linear damping, a resonator, a hardening spring, a force."""
    kinds = ("", "linear_damping", "hidden_resonator", "cubic_stiffness", "external_forcing")
    for seed in seeds:
        name = kinds[seed % len(kinds)]
        plan = replace(plan_of(seed, most=HIDDEN_IN), rate_hz=250.0)
        strength = 3.0 if name else 0.0
        sizes = {name: size_for(plan, name, strength)[0]} if name else {}
        for view, (how, rate) in VIEWS.items():
            label = {"study": "invariance", "hidden": name, "strength": strength, "seed": seed, "view": view}
            yield Case(label, Campaign(replace(plan, rate_hz=rate), sizes), how)


STUDIES = {
    "nulls": nulls, "confusion": confusion, "pairs": pairs, "inseparable": inseparable, "seiche": seiche,
    "near_seiche": near_seiche,
    "invariance": invariance,
}  # fmt: skip
