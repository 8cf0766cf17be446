"""One sealed case from its plan: a laboratory drawn, effects given a strength, and the truth that only the scorer
reads.
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from experiments.blind_challenge import refit
from experiments.blind_challenge import strength as measure
from experiments.blind_challenge.composition import DRY_SHARES, STRENGTHS, Plan, needs_of
from experiments.blind_challenge.effects import EffectKind, Shape, kind
from experiments.blind_challenge.rigs import Rig, draw_rig
from experiments.blind_challenge.scene import Change, Scene, mean_scene, merge

PROBES = ("cubic_stiffness", "cubic_damping", "hidden_resonator")  # for how small an effect a laboratory could see
TRIES = 25  # of a laboratory in which the effect can be as strong as asked
SEARCH = 8  # evaluations of the strength where it does not follow the dose in proportion


@dataclass(frozen=True)
class Dosed:
    """An effect with its shape and its dose."""

    kind: EffectKind
    shape: Shape
    dose: float

    def change(self, scene: Scene) -> Change:
        """What it changes of a trial."""
        return self.kind.applied(self.shape, self.dose, scene)


@dataclass(frozen=True)
class Case:
    """A case: its plan, its laboratory, its effects, and measures of them for the truth."""

    name: str
    plan: Plan
    rig: Rig
    effects: tuple[Dosed, ...]
    measures: dict[str, object]
    seed: tuple[int, int]

    def change(self, scene: Scene) -> Change:
        """All effects on one trial."""
        change = Change(scene.body)
        for effect in self.effects:
            change = merge(change, effect.change(scene), scene.body)
        return change


def unknowns(effect: EffectKind, rig: Rig) -> int:
    """Numbers that a test with the true law must find."""
    acting = sum(effect.acts(mean_scene(rig, trial)) for trial in rig.trials)
    return effect.unknowns + effect.unknowns_a_trial * acting


def seen(effect: EffectKind, rig: Rig, found: measure.Strength) -> float:
    """Strength: 1 where the best possible test finds the effect every second time."""
    return math.sqrt(found.statistic / measure.half_power(unknowns(effect, rig)))


def _left_out(rig: Rig, kinds: list[EffectKind]) -> Rig:
    """The laboratory whose equation lacks what the effects bring: terms gone, their numbers zero."""
    gone = {term for k in kinds for term in k.left_out}
    levels = rig.levels
    if "quadratic_drag" in gone:
        levels = tuple(replace(level, drag=0.0) for level in levels)
    if "added_mass" in gone:
        levels = tuple(replace(level, added_mass=0.0) for level in levels)
    return replace(
        rig,
        levels=levels,
        mu=0.0 if "coulomb_friction" in gone else rig.mu,
        terms=tuple(term for term in rig.terms if term not in gone),
    )


def _laboratory(rng: np.random.Generator, plan: Plan, kinds: list[EffectKind]) -> Rig:
    """A laboratory that meets the plan and its effects."""
    needs = needs_of(plan, [k.needs for k in kinds])
    dry = plan.dry or needs.dry or str(rng.choice(list(DRY_SHARES), p=list(DRY_SHARES.values())))
    rig = draw_rig(rng, needs, dry)
    if plan.small:
        rig = replace(rig, periods=min(rig.periods, 10.0))
    if plan.reason in ("one trial", "no dry trials and no repeats"):
        rig = replace(rig, knows=rig.knows - {"scatter"})
    if plan.reason == "narrow amplitudes":
        rig = replace(rig, periods=min(rig.periods, 10.0))
    for k in kinds:
        rig = k.fit_rig(rng, rig) if k.fit_rig else rig
    return _left_out(rig, kinds)


def _target(rng: np.random.Generator, plan: Plan) -> tuple[str, float]:
    """How strong, and by which measure: what can be detected, or how far the free run moves beside repeatability."""
    low, high = STRENGTHS
    if plan.reason == "an effect below the noise":
        low, high = 0.1, 0.5
    elif plan.reason in (
        "over-damped resonator or relaxation",
        "added mass or a resonator far above",
        "narrow amplitudes",
    ):
        low, high = 2.0, 10.0
    elif plan.kind == "two":
        low = 1.0
    by = "detection" if plan.kind == "cannot" or rng.random() < 0.5 else "free run"
    return by, math.exp(rng.uniform(math.log(low), math.log(high)))


def _measured(effect: EffectKind, rig: Rig, found: measure.Strength, by: str) -> float:
    if by == "detection":
        return seen(effect, rig, found)
    if effect.place == "instrument" and found.leftover == 0.0:
        return found.size
    return found.leftover / (0.5 * found.repeatability)


def _dose(effect: EffectKind, shape: Shape, rig: Rig, views: list[measure.View], by: str, target: float) -> float:
    """The dose at which the effect is as strong as asked, within what the effect allows."""

    def value(dose: float) -> float:
        found = measure.strength_of(rig, views, lambda scene, d: effect.applied(shape, d, scene), dose, effect.linear)
        return max(_measured(effect, rig, found, by), 1e-12)

    if effect.linear:
        return min(effect.typical * target / value(effect.typical), effect.largest)
    low, high = max(1e-5 * effect.largest, effect.smallest), effect.largest
    if value(low) >= target:
        return low
    if value(high) <= target:
        return high
    for _ in range(SEARCH):
        middle = math.sqrt(low * high)
        low, high = (middle, high) if value(middle) < target else (low, middle)
    return math.sqrt(low * high)


def _refitted(rig: Rig, views: list[measure.View], effect: Dosed) -> tuple[measure.Strength, refit.Refit | None]:
    """Strength as the truth states it, and the refit that it is measured by."""
    kind, shape = effect.kind, effect.shape
    return refit.strength_of(rig, views, lambda scene, d: kind.applied(shape, d, scene), effect.dose, kind.linear)


def _group_measures(case_rig: Rig, views: list[measure.View], effect: Dosed) -> list[dict[str, object]]:
    """Strength and size in every group alone, with the dry trials of its spring."""
    out = []
    for spring, level in case_rig.groups():
        scenes = [v for v in views if (v.scene.trial.spring, v.scene.trial.level) == (spring, level)]
        dry = [v for v in views if v.scene.trial.spring == spring and not v.scene.wet and v.scene.trial.level != level]
        if not effect.kind.acts(scenes[0].scene):
            out.append({"strength": 0.0, "size": 0.0, "present": False})
            continue
        chosen = scenes + dry
        rig = replace(case_rig, trials=tuple(v.scene.trial for v in chosen))
        found, _ = _refitted(rig, chosen, effect)
        numbers = effect.kind.numbers(effect.shape, effect.dose, scenes[0].scene) if effect.kind.numbers else {}
        out.append(
            {
                "strength": seen(effect.kind, rig, found),
                "size": found.size,
                "free_run": found.leftover / (0.5 * found.repeatability),
                "present": True,
                "parameters": numbers,
            }
        )
    return out


def _strength(rig: Rig, views: list[measure.View], effect: Dosed) -> measure.Strength:
    return measure.strength_of(
        rig, views, lambda scene, d: effect.kind.applied(effect.shape, d, scene), effect.dose, effect.kind.linear
    )


def effect_measures(
    rig: Rig, views: list[measure.View], effects: list[Dosed], asked: list[tuple[str, float]]
) -> list[dict[str, object]]:
    """What the truth says of its effects: names, dose, strength, best possible power, size; also by group, and of two
    how strong each is where the other's size is free.
    """
    refits = [_refitted(rig, views, effect) for effect in effects]
    out = [_entry(rig, views, e, a, found) for e, a, (found, _) in zip(effects, asked, refits, strict=True)]
    for entry, (_, end), mine, other in zip(out, refits, effects, effects[::-1], strict=True):
        if len(effects) == 2 and end is not None:
            second = other.kind
            statistic = refit.beside(
                rig, end, lambda scene, d, o=other: o.kind.applied(o.shape, d, scene), other.dose, second.linear
            )
            entry["strength_beside"] = math.sqrt(statistic / measure.half_power(unknowns(mine.kind, rig)))
    return out


def _entry(
    rig: Rig, views: list[measure.View], effect: Dosed, asked: tuple[str, float], found: measure.Strength
) -> dict[str, object]:
    count = unknowns(effect.kind, rig)
    return {
        "key": effect.kind.key,
        "text": effect.kind.text,
        "place": effect.kind.place,
        "names": list(effect.kind.names),
        "near": list(effect.kind.near),
        "dose": effect.dose,
        "shape": effect.shape,
        "asked": list(asked),
        "unknowns": count,
        "statistic": found.statistic,
        "strength": seen(effect.kind, rig, found),
        "best_power": measure.best_power(found.statistic, count),
        "free_run": found.leftover,
        "repeatability": found.repeatability,
        "size": found.size,
        "bias": found.bias,
        "groups": _group_measures(rig, views, effect),
    }


def sharpness(rng: np.random.Generator, rig: Rig, views: list[measure.View]) -> float:
    """Smallest strength, over PROBES, of an effect of size 1: above 1.5 an effect as large as B is seen with 90 %
    power.
    """
    values = []
    for key in PROBES:
        probe = kind(key)
        found = _strength(rig, views, Dosed(probe, probe.draw(rng, rig), probe.typical))
        if found.size > 0.0:
            values.append(seen(probe, rig, found) / found.size)
    return float(min(values, default=0.0))


def draw_case(seed: int, index: int, plan: Plan) -> Case:
    """The case of that seed and index: the same numbers whatever else is drawn."""
    rng = np.random.default_rng([seed, index, 21])
    kinds = [kind(key) for key in plan.effects]
    best: tuple[float, Rig, list[measure.View], list[tuple[Dosed, tuple[str, float]]]] | None = None
    for _ in range(TRIES):
        rig = _laboratory(rng, plan, kinds)
        views = [measure.view(rig, trial) for trial in rig.trials]
        dosed = []
        short = 0.0
        for k in kinds:
            shape = k.draw(rng, rig)
            asked = _target(rng, plan)
            effect = Dosed(k, shape, _dose(k, shape, rig, views, *asked))
            dosed.append((effect, asked))
            reached = _measured(k, rig, _strength(rig, views, effect), asked[0]) / asked[1]
            short = max(short, -math.log(max(reached, 1e-12)))
        if best is None or short < best[0]:
            best = (short, rig, views, dosed)
        if short < 0.5 or plan.reason:
            break
    _, rig, views, dosed = best
    measures: dict[str, object] = {"effects": effect_measures(rig, views, [d for d, _ in dosed], [a for _, a in dosed])}
    if not kinds:
        measures["sharpness"] = sharpness(rng, rig, views)
        measures["repeatability"] = measure.repeatability(rig, views)
    return Case(f"c{index:04d}", plan, rig, tuple(d for d, _ in dosed), measures, (seed, index))
