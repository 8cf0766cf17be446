"""What each group's analysis is given: its trials, what the dry trials say of its spring, its anchor, who is held out.

Belongs here: tasks from conditioned motions. Does not belong here: the order of work (course.py), the analysis
(analysis.py).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from undertow.campaign.config import GroupKey, RunConfig
from undertow.campaign.config.settings import EverySettings, LargestSettings
from undertow.campaign.config.specimen_rules import check_level
from undertow.campaign.run.analysis import GroupTask
from undertow.campaign.run.portions import group_order
from undertow.conditioning.motion import Motion
from undertow.discrepancy.words import percent
from undertow.equation.term import Term
from undertow.errors import RecordingError
from undertow.likelihood.fit import Specimen, Structure
from undertow.likelihood.problem import TrialOptions
from undertow.likelihood.scale import choose_anchor, on_load_cells, trial_stiffness, with_gain
from undertow.methods.baseline import GroupFit
from undertow.methods.decay import load_cell_stiffness
from undertow.methods.dry import Scatter, dry_fits, pooled_scatter, structural_terms, structure_from, uneven
from undertow.quantities import Estimate
from undertow.recording.patterns import patterns_of
from undertow.uncertainty.repeats import mean_of_trials

JOINT_AT_MOST = 60
"""Trials of a group that are fitted together and searched: every one has a clock and offsets of its own among the
unknowns, so that a joint fit's memory goes with the square of their number, and its time faster."""

MASSES_AGREE = 0.05
"""Springs give the same mass within this share of it, or their stated stiffnesses are not believed."""

LISTED_SHARE = 1 / 3
"""Part of `JOINT_AT_MOST` that may be held out by a list: as many as hold_out: auto holds out."""


def grouped(config: RunConfig, motions: Sequence[Motion]) -> dict[GroupKey, list[Motion]]:
    """Motions by group, dry groups first, then in order of their conditions; each in order of amplitude."""
    groups: dict[GroupKey, list[Motion]] = {}
    for motion in motions:
        groups.setdefault(config.group_key(motion.recording.conditions), []).append(motion)

    def order(key: GroupKey) -> tuple[object, ...]:
        return group_order(key, config.is_dry(groups[key][0].recording.conditions))

    return {key: sorted(groups[key], key=lambda m: (m.amplitude, m.name)) for key in sorted(groups, key=order)}


def _spring(config: RunConfig, key: GroupKey) -> GroupKey:
    """The part of a group's key that its dry trials share: everything the config's ``dry`` does not fix."""
    fixed = config.trials.dry or {}
    return tuple((name, value) for name, value in key if name not in fixed)


def level_count(config: RunConfig, groups: Mapping[GroupKey, bool], structures: Structures) -> int:
    """How many levels a campaign is judged in: its dry groups (True in ``groups``), and waters of springs with dry
    trials; a group of a spring without them is one for itself."""
    fixed = config.trials.dry or {}
    waters = {
        tuple((name, value) for name, value in key if name in fixed or _spring(config, key) not in structures)
        for key, dry in groups.items() if not dry
    }  # fmt: skip
    return sum(groups.values()) + len(waters)


@dataclass(frozen=True)
class Dry:
    """A structure from the fits of its dry trials, each alone, with the load cells' ratio to it (mean; stderr is the
    spread); ``uneven`` says that they differ by more than trials do."""

    structure: Structure
    ratio: Estimate
    fits: Mapping[str, GroupFit] = field(default_factory=dict)
    uneven: str = ""


Structures = Mapping[GroupKey, Dry]
"""What the dry trials say of each spring that has some."""


def weighed(
    config: RunConfig, groups: Mapping[GroupKey, Sequence[Motion]], terms: Sequence[Term]
) -> tuple[RunConfig, tuple[str, ...]]:
    """The config with the mass that dry trials give, k / w^2, where it states none, and a note: k is the stated
    stiffness, or what load cells show; as it is where springs give masses that differ by more than `MASSES_AGREE`."""
    if config.specimen.mass_kg is not None:
        return config, ()
    found: dict[GroupKey, Estimate] = {}
    for key, motions in groups.items():
        specimen = config.specimen_for(motions[0].recording.conditions)
        k = _known_stiffness(specimen, motions) if config.is_dry(motions[0].recording.conditions) else None
        if k is None:
            continue
        unit = replace(specimen, mass_kg=1.0, stiffness_N_per_m=math.nan)
        fits = dry_fits(motions, structural_terms(terms), unit, TrialOptions()).values()
        rates = [rate.value for fit in fits if (rate := fit.estimates.get("k_N_per_m")) and rate.value > 0.0]
        if rates:
            found[_spring(config, key)] = k.scaled(1.0 / float(np.mean(rates)), specimen.unit("kg"))
    if not found:
        return config, ()
    masses, of_mass = [mass.value for mass in found.values()], next(iter(found.values())).unit
    each = ", ".join(f"{mass.value:.6g} {mass.unit}{_of_spring(spring)}" for spring, mass in found.items())
    sources = " and ".join(sorted({mass.source for mass in found.values()}))
    if max(masses) > (1.0 + MASSES_AGREE) * min(masses):
        said = f"{sources} and the dry trials give different masses ({each}); state specimen.mass_kg"
        return config, (said,)
    mass, error = float(np.mean(masses)), max(mass.total_stderr for mass in found.values())
    said = f"mass {mass:.6g} {of_mass} from {sources} and the dry trials' frequency ({each})"
    return config.with_mass(mass, error), (said,)


ANOTHER_SPRING, SURELY = 0.01, 4.0
"""Relative difference between the load cells' stiffness in water and in air, and standard errors, from which on it is
another: springs and gains differ by less from day to day."""


def _known_stiffness(specimen: Specimen, motions: Sequence[Motion]) -> Estimate | None:
    """The spring's stiffness, N/m, as stated or as load cells show it; None where nothing says it."""
    if specimen.stiffness_N_per_m > 0.0:
        return Estimate(specimen.stiffness_N_per_m, unit="N/m", source="the stated stiffness")
    slopes = [slope for motion in motions if (slope := slope_of_cells(motion)) is not None]
    mean = mean_of_trials(slopes, "N/m", "the load cells") if slopes else None
    return with_gain(mean) if mean is not None and mean.value > 0.0 else None


def _of_spring(spring: GroupKey) -> str:
    words = " ".join(str(value) for _, value in spring)
    return f" with {words}" if words else ""


def structures_of(config: RunConfig, groups: Mapping[GroupKey, Sequence[Motion]], terms: Sequence[Term]) -> Structures:
    """The structure of every spring that has dry trials and a known mass."""
    fitted: dict[GroupKey, dict[str, GroupFit]] = {}
    slopes: dict[GroupKey, list[float]] = {}
    for key, motions in groups.items():
        if not config.is_dry(motions[0].recording.conditions):
            continue
        specimen = config.specimen_for(motions[0].recording.conditions)
        if not math.isfinite(specimen.mass_kg):
            continue
        spring = _spring(config, key)
        found = dry_fits(motions, structural_terms(terms), specimen, TrialOptions())
        if not found:
            continue
        fitted[spring] = found
        measured = [(m, slope_of_cells(m)) for m in motions]
        slopes[spring] = [
            slope.value / fitted[spring][m.name].estimates["k_N_per_m"].value
            for m, slope in measured
            if slope and m.name in found and "k_N_per_m" in found[m.name].estimates
        ]  # fmt: skip
    stated = config.specimen.scatter
    scatter = pooled_scatter(list(fitted.values()))
    if stated is not None:
        scatter = Scatter({"k": stated.k, "c": stated.c, "mu": stated.mu}, math.inf)
    away = [ratio / float(np.mean(ratios)) - 1.0 for ratios in slopes.values() for ratio in ratios]
    freedom = len(away) - sum(bool(ratios) for ratios in slopes.values())
    spread = math.sqrt(sum(d * d for d in away) / freedom) if freedom > 0 else math.nan
    return {
        spring: Dry(
            structure_from(fits, scatter),
            Estimate(float(np.mean(slopes[spring])) if slopes[spring] else math.nan, spread, unit="1"),
            fits,
            uneven(fits),
        )
        for spring, fits in fitted.items()
    }


def with_scatter(structures: Structures, seen: Scatter) -> Structures:
    """The structures where more than the dry trials shows how much trials differ."""
    return {spring: replace(dry, structure=structure_from(dry.fits, seen)) for spring, dry in structures.items()}


def slope_of_cells(motion: Motion) -> Estimate | None:
    """Slope of spring force on displacement, None where either is not recorded."""
    channels = motion.recording.channels
    if "spring_force" not in channels or "displacement" not in channels:
        return None
    return load_cell_stiffness(motion)


def group_task(
    config: RunConfig,
    key: GroupKey,
    motions: Sequence[Motion],
    terms: Sequence[Term],
    structures: Structures,
    repeated: Scatter | None = None,
) -> GroupTask:
    """One group's task; ``motions`` in order of amplitude. ``repeated`` is the scatter that the campaign's repetitions
    show, where no dry trials say any.

    Raises UndertowError where this group cannot be identified as the config says: a table leaves its level out, or no
    trial is left to be fitted.
    """
    conditions = motions[0].recording.conditions
    check_level(config, conditions)
    specimen = config.specimen_for(conditions)
    dry = config.is_dry(conditions)
    found = structures.get(_spring(config, key))
    structure = found.structure if found else None
    slopes = {m.name: s for m in motions if (s := slope_of_cells(m)) is not None}
    mean_slope = mean_of_trials(list(slopes.values()), "N/m", "load cells") if slopes else None
    anchor = choose_anchor(specimen, structure, mean_slope, dry, added_mass=any(t.is_inertia for t in terms))
    specimen = on_load_cells(specimen, anchor)
    stiffness = {}
    if found is not None and slopes and not dry and math.isfinite(found.ratio.value):
        stiffness = trial_stiffness(found.structure.k, slopes, found.ratio, found.structure.scatter["k"])
    scatter, freedom = _scatter(config, structure or _any(structures), repeated)
    together = looked_at_together(motions, _listed(config, motions))
    names = {m.name for m in together}
    held = held_out(config, together)
    if len(held) == len(together):
        raise RecordingError(
            f"trials.hold_out holds out all {len(held)} trials that can be used ({', '.join(held)}), which leaves none "
            "to be fitted; hold out fewer"
        )
    return GroupTask(
        dict(key), dry, tuple(motions), structural_terms(terms) if dry else tuple(terms), specimen,
        None if dry else structure, anchor, stiffness, scatter, freedom, structure,
        held, tuple(config.identify), _options(structure, specimen), config.seed,
        tuple(m.name for m in motions if m.name not in names),
        dry_trials=max((len(dry.fits) for dry in structures.values()), default=0),
        uneven=(found.uneven or ("" if dry else _another_spring(found, slopes))) if found else "",
    )  # fmt: skip


def _another_spring(found: Dry, slopes: Mapping[str, Estimate]) -> str:
    """That the load cells surely show another stiffness in a water than in air, beside the motion's own, in words: they
    feel more than the spring, or it is another, and kilograms go with it."""
    k, scatter = found.structure.k.value, math.hypot(found.structure.scatter["k"], found.ratio.stderr)
    if not slopes or not math.isfinite(found.ratio.value) or not math.isfinite(scatter):
        return ""
    off = float(np.mean([slope.value for slope in slopes.values()])) / (found.ratio.value * k) - 1.0
    if not abs(off) > max(ANOTHER_SPRING, SURELY * scatter * math.sqrt(1.0 / len(slopes) + 1.0 / len(found.fits))):
        return ""
    return (
        f"its load cells show a spring {percent(abs(off))} {'stiffer' if off > 0.0 else 'softer'} than in air, where "
        f"they show {percent(abs(found.ratio.value - 1.0))} {'more' if found.ratio.value > 1.0 else 'less'} than the "
        "motion: they feel more than the spring (what hangs on them, crosstalk), or it is another spring"
    )


def _scatter(
    config: RunConfig, structure: Structure | None, repeated: Scatter | None
) -> tuple[dict[str, float], float]:
    """Scatter of k, c, mu by symbol and the degrees of freedom it was seen with; empty where nobody knows it."""
    stated = config.specimen.scatter
    if stated is not None:
        return {"k": stated.k, "c": stated.c, "mu": stated.mu}, math.inf
    if structure is not None:
        return dict(structure.scatter), structure.scatter_freedom
    return (dict(repeated.values), repeated.freedom) if repeated is not None else ({}, math.inf)


def looked_at_together(motions: Sequence[Motion], listed: Collection[int] = ()) -> Sequence[Motion]:
    """At most `JOINT_AT_MOST` of a group's trials, which are in order of amplitude: evenly, both ends among them.

    Of those that a list holds out (``listed``, places in ``motions``) as many are taken as `LISTED_SHARE` allows.

    >>> len(looked_at_together(list(range(1000)))), looked_at_together([1, 2, 3])
    (60, [1, 2, 3])
    >>> sum(m % 10 == 0 for m in looked_at_together(list(range(1000)), range(0, 1000, 10)))
    20
    """
    if len(motions) <= JOINT_AT_MOST:
        return motions
    unseen = _evenly([at for at in range(len(motions)) if at in listed], int(LISTED_SHARE * JOINT_AT_MOST))
    seen = [at for at in range(len(motions)) if at not in listed]
    return [motions[at] for at in sorted([*unseen, *_evenly(seen, JOINT_AT_MOST - len(unseen))])]


def _evenly(places: Sequence[int], most: int) -> Sequence[int]:
    """At most so many of the places, evenly, both ends among them."""
    if len(places) <= most:
        return places
    return [places[i] for i in np.linspace(0, len(places) - 1, most).round().astype(int)]


def _any(structures: Structures) -> Structure | None:
    """A structure of another spring whose scatter was seen: it is pooled over all springs."""
    return next((dry.structure for dry in structures.values() if dry.structure.scatter_freedom > 0.0), None)


def _options(structure: Structure | None, specimen: Specimen) -> TrialOptions:
    """Nuisances of a trial: the rest position's prior is the width in which friction lets the body come to rest."""
    if structure is None:
        return TrialOptions()
    width = structure.mu.value * specimen.normal_force_N / structure.k.value
    return TrialOptions(rest_offset_std=width) if math.isfinite(width) and width > 0.0 else TrialOptions()


def held_out(config: RunConfig, motions: Sequence[Motion]) -> tuple[str, ...]:
    """Names of a group's trials that are never fitted; ``motions`` in order of amplitude.

    auto: from three trials on every third, starting with the second, never the smallest or the largest.
    """
    rule = config.trials.hold_out
    names = [m.name for m in motions]
    if rule == "auto":
        return tuple(names[i] for i in range(1, len(names) - 1, 3)) if len(names) >= 3 else ()
    if isinstance(rule, EverySettings):
        return tuple(names[1 :: rule.every]) if len(names) > 1 else ()
    if isinstance(rule, LargestSettings):
        if rule.largest >= len(names):
            raise RecordingError(
                f"trials.hold_out: largest {rule.largest} leaves none of the {len(names)} trials "
                f"({', '.join(names)}) to be fitted; hold out fewer"
            )
        return tuple(names[-rule.largest :])
    return tuple(names[at] for at in sorted(_listed(config, motions)))


def _listed(config: RunConfig, motions: Sequence[Motion]) -> set[int]:
    """Places of the motions that a list in ``trials.hold_out`` names."""
    rule = config.trials.hold_out
    if not isinstance(rule, tuple):
        return set()
    patterns = patterns_of(rule)
    return {at for at, m in enumerate(motions) if patterns.fit(m.name, m.recording.path)}
