"""The rig again, with what its dry trials need: k, c, mu, their scatter, and how far repetitions differ.

Hardening seen at several releases passes for scatter of k, a missing friction for scatter of c, as long as the term is
not in the equation of the dry trials. Once it is named, k, c, mu are found beside it, and the wet groups are held
against that rig.

Belongs here: that second look. Does not belong here: the search (discrepancy/), the order of work (judgement.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from undertow.campaign.config import GroupKey, RunConfig
from undertow.campaign.run.analysis import GroupTask, floors_of, rest_prior
from undertow.comparison.level import Addend
from undertow.comparison.suspect import DRIFT, Addition
from undertow.discrepancy.judge import Judged
from undertow.equation.algebra import RUBBING, SLOT
from undertow.errors import FAILURES
from undertow.likelihood.fit import Specimen, Structure
from undertow.likelihood.free_run import free_run
from undertow.likelihood.problem import TrialOptions
from undertow.methods.baseline import GroupModel, fit_group, group_model
from undertow.methods.dry import DEFAULT_SCATTER, Scatter, dry_fits, pooled_scatter, structural_terms, structure_from

MOST_SCATTER = 1.5
"""Scatter of k, c, mu from trial to trial that is still believed, over that of published rigs."""

Slots = Mapping[str, float]


@dataclass(frozen=True)
class WetRig:
    """A wet group's model with the rig found anew, its nuisances, and its repeatability."""

    model: GroupModel
    options: TrialOptions
    allowed: float


def standing_addends(dry: Sequence[Judged]) -> tuple[Addend, ...]:
    """What dry groups need, each spring's numbers with their errors, as it stands in every wet model; how a hook let go
    in air is no matter of the rig, and a sensor's drift is each trial's own, of twice the degree for a longer decay."""
    found: dict[str, dict[str, list[tuple[str, float, float]]]] = {}
    kinds: dict[str, Addend] = {}
    for judged in dry:
        for addend in (a for a in judged.addends if not a.hooked):
            kinds.setdefault(addend.prefix, addend)
            for a in addend.additions:
                for label in judged.labels:
                    for name in (f"{addend.prefix}.{a.name}@{label}", f"{addend.prefix}.{a.name}"):
                        if name in judged.values:
                            numbers = found.setdefault(addend.prefix, {}).setdefault(a.name, [])
                            numbers.append((label, *judged.values[name]))
                            break
    out = []
    for prefix, addend in kinds.items():
        if addend.frees:
            out.append(replace(addend, centres=(), degree=2 * addend.degree) if addend.frees == DRIFT else addend)
        elif prefix in found:
            additions = [_standing(a, found[prefix][a.name]) for a in addend.additions if a.name in found[prefix]]
            out.append(Addend(prefix, tuple(additions)))
    return tuple(out)


def _standing(a: Addition, numbers: Sequence[tuple[str, float, float]]) -> Addition:
    """An addition as each spring's own, held by its dry value and error."""
    held = tuple((label, value, error if error > 0.0 else abs(value) or a.scale) for label, value, error in numbers)
    return replace(a, scope="spring", by_spring=held)


def in_water(
    standing: Sequence[Addend], specimens: Mapping[str, Specimen], dry: Mapping[str, Specimen]
) -> tuple[Addend, ...]:
    """What stands where buoyancy takes weight off, from each spring's specimen in this water and dry.

    Friction goes with the normal force, and so do the bristles that yield where it slides (as normalised bristles
    do: Canudas-de-Wit and Tsiotras, Dynamic tire friction models for vehicle traction control, 38th CDC, 1999), or, a
    seal's or a guide's, does not: that is a standard deviation off. All is as it was where a normal force is not known.

    >>> from undertow.likelihood.fit import Specimen
    >>> rubs = Addition("force_N", "N", "fc", 0.0, 1.0, scope="spring", by_spring=(("short", 80.0, 2.0),))
    >>> dry = Specimen(mass_kg=1000.0)
    >>> wet = Specimen(mass_kg=1000.0, submerged_volume_m3=0.25)
    >>> pressed = in_water([Addend("coulomb_friction", (rubs,))], {"short": wet}, {"short": dry})[0]
    >>> [round(number, 1) for number in pressed.additions[0].by_spring[0][1:]]
    [60.0, 20.1]
    >>> held = (("short", 9e3, 50.0),)
    >>> bristles = Addition("stiffness_N_per_m", "N/m", "kb", 0.0, 1.0, moves=("fc", "fb"), by_spring=held)
    >>> links = replace(bristles, moves=None)  # a hysteresis of the structure: no weight is on it
    >>> wet = in_water([Addend("presliding", (bristles, links))], {"short": wet}, {"short": dry})[0]
    >>> [round(a.by_spring[0][1]) for a in wet.additions]
    [6750, 9000]
    """
    shares = {}
    for label in specimens.keys() & dry.keys():
        share = specimens[label].normal_force_N / dry[label].normal_force_N
        shares[label] = share if np.isfinite(share) else 1.0
    return tuple(
        replace(addend, additions=tuple(_pressed(a, shares) if _rubs(a) else a for a in addend.additions))
        for addend in standing
    )


def _rubs(a: Addition) -> bool:
    """Whether an addition is a friction, or takes the place of one."""
    return a.slot in RUBBING or (a.moves is not None and a.moves[0] in RUBBING)


def _pressed(a: Addition, shares: Mapping[str, float]) -> Addition:
    """A friction with each spring's share of its dry normal force."""
    return replace(
        a, by_spring=tuple((label, value * share, math.hypot(error * share, value * (1.0 - share)))
                           for label, value, error in a.by_spring for share in (shares.get(label, 1.0),)),
    )  # fmt: skip


def known_slots(standing: Sequence[Addend], label: str) -> dict[str, float]:
    """What stands for one spring, as values of the integrator's slots."""
    slots: dict[str, float] = {}
    for addend in standing:
        for a in addend.additions:
            for spring, value, _ in a.by_spring:
                if spring == label:
                    for slot, factor in a.slots:
                        slots[slot] = slots.get(slot, 0.0) + factor * value
    return slots


def moved_slots(standing: Sequence[Addend], label: str) -> dict[str, str]:
    """Slots whose content stands in another beside what stands for one spring."""
    return {
        a.moves[0]: a.moves[1]
        for addend in standing for a in addend.additions
        if a.moves is not None and label in {spring for spring, _, _ in a.by_spring}
    }  # fmt: skip


def with_known(
    config: RunConfig, tasks: Sequence[GroupTask], standing: Sequence[Addend]
) -> dict[GroupKey, WetRig | None]:
    """Each group's rig with what stands for its spring; None for dry groups, springs that need nothing, springs of
    which no dry trial can be fitted beside it, and where neither mass nor stiffness is known (a number per kilogram of
    dry body is none in water): their rig stays as it was."""
    fits = {
        spring_label(config, task): dry_fits(
            task.motions, structural_terms(task.terms), task.specimen, TrialOptions(),
            known_slots(standing, spring_label(config, task)), moved_slots(standing, spring_label(config, task)),
            task.dry_structure,
        )
        for task in tasks if task.dry and task.dry_structure is not None
    }  # fmt: skip
    scatter = pooled_scatter(list(fits.values()))
    known = next((task.dry_structure for task in tasks if task.dry_structure is not None), None)
    if known is not None and known.scatter_freedom > scatter.freedom:  # stated, or seen in repetitions too
        scatter = Scatter(known.scatter, known.scatter_freedom)
    structures = {label: structure_from(found, scatter) for label, found in fits.items() if found}
    weighed = dry_specimens(config, tasks)
    rigs: dict[GroupKey, WetRig | None] = {}
    for task in tasks:
        label = spring_label(config, task)
        slots = known_slots(in_water(standing, {label: task.specimen}, weighed), label)
        ready = not task.dry and task.anchor.known and label in structures and bool(slots)
        moved = moved_slots(standing, label)
        try:
            rigs[tuple(task.key.items())] = _rig(task, structures[label], slots, moved) if ready else None
        except FAILURES:
            rigs[tuple(task.key.items())] = None  # no motion beside what stands: the rig stays as it was
    return rigs


def dry_specimens(config: RunConfig, tasks: Sequence[GroupTask]) -> dict[str, Specimen]:
    """Each spring's specimen as it stands dry, by the spring's label."""
    return {spring_label(config, task): task.specimen for task in tasks if task.dry}


def spring_label(config: RunConfig, task: GroupTask) -> str:
    """What a group is called among those of its water: everything but what makes a trial dry."""
    fixed = config.trials.dry or {}
    return " ".join(str(v) for k, v in task.key.items() if k not in fixed) or "all"


def _rig(task: GroupTask, structure: Structure, slots: Slots, moved: Mapping[str, str]) -> WetRig:
    """One wet group's model and repeatability with the rig found anew."""
    task = replace(task, structure=structure, dry_structure=structure, stiffness={})
    model = group_model(task.terms, task.motions, task.specimen, structure, dry=False, anchored=task.anchor.known)
    base = model.base.copy()
    for old, new in moved.items():
        base[SLOT[new]], base[SLOT[old]] = base[SLOT[new]] + base[SLOT[old]], 0.0
    for slot, value in slots.items():
        base[SLOT[slot]] += value
    return WetRig(model, task.options, _repetitions(task, replace(model, base=base)))


def _repetitions(task: GroupTask, model: GroupModel) -> float:
    """Median over a group's trials of how far repetitions differ with its structure's scatter (nrmse)."""
    training = [m for m in task.motions if m.name not in task.held_out]
    fit = fit_group(model, training, task.options, "trials" if len(training) > 1 else "none")
    runs = [(m, free_run(m, model.theta(fit.values, m.name), rest_prior(task, m))) for m in task.motions]
    return float(np.median([floors_of(task, motion, run)[1] for motion, run in runs]))


def believable_repeatability(task: GroupTask) -> float:
    """How far repetitions of a group differ where the scatter seen in its dry trials is more than a rig has.

    A law that is missing in the dry trials passes for scatter, and would then hide itself. inf where the scatter is
    believable (`MOST_SCATTER` times what published rigs had).
    """
    structure = task.dry_structure
    if structure is None or structure.scatter_freedom == np.inf:
        return np.inf
    most = {symbol: MOST_SCATTER * usual for symbol, usual in DEFAULT_SCATTER.items()}
    if all(structure.scatter.get(symbol, 0.0) <= limit for symbol, limit in most.items()):
        return np.inf
    scatter = {symbol: min(structure.scatter.get(symbol, 0.0), limit) for symbol, limit in most.items()}
    structure = replace(structure, scatter=scatter, scatter_freedom=np.inf)
    task = replace(task, structure=structure, dry_structure=structure)
    model = group_model(task.terms, task.motions, task.specimen, structure, dry=task.dry, anchored=task.anchor.known)
    return _repetitions(task, model)
