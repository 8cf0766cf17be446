"""How much a campaign's trials differ where its dry trials are too few to say: by releases of one size in any group.

It is one rig: what its trials scatter by at one water they scatter by at another.

Belongs here: which fits show it. Does not belong here: what such fits say (methods/repeated.py), dry trials
(methods/dry.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from undertow.campaign.config import GroupKey, RunConfig
from undertow.campaign.run.tasks import Structures, group_task
from undertow.conditioning.motion import Motion
from undertow.equation.term import Term
from undertow.errors import FAILURES
from undertow.likelihood.fit import Fit, Structure
from undertow.methods.baseline import as_fit, fit_group, group_model
from undertow.methods.dry import DEFAULT_SCATTER, Scatter
from undertow.methods.repeated import FEWEST, pooled, repetitions, scatter_of_repetitions

REPEATED_AT_MOST = 60
"""Repetitions of one size that are fitted: the scatter is then known within a tenth."""


def scatter_seen(
    config: RunConfig,
    groups: Mapping[GroupKey, Sequence[Motion]],
    terms: Sequence[Term],
    structures: Structures,
) -> Scatter | None:
    """Scatter of k, c, mu from all releases that were repeated, with what the dry trials show; None where the config
    states it, the dry trials show it by themselves, or nothing shows it."""
    dry = next((found.structure for found in structures.values()), None)
    if config.specimen.scatter is not None or (dry is not None and dry.scatter_freedom >= FEWEST - 1):
        return None
    known = Scatter(dry.scatter, dry.scatter_freedom) if dry is not None else Scatter(DEFAULT_SCATTER, 0.0)
    sets = [
        _fits(config, key, together[:REPEATED_AT_MOST], terms, structures)
        for key, motions in groups.items()
        if not (dry is not None and config.is_dry(motions[0].recording.conditions))
        for together in repetitions(motions)
    ]
    seen = scatter_of_repetitions(sets, known.freedom)
    return None if seen is None else pooled(known, seen)


def _fits(
    config: RunConfig, key: GroupKey, motions: Sequence[Motion], terms: Sequence[Term], structures: Structures
) -> list[Fit]:
    """Each of these trials fitted alone; one that cannot be has no place in it."""
    found = list[Fit]()
    try:
        task = group_task(config, key, motions, terms, structures)
        model = group_model(
            task.terms, motions, task.specimen, _sure(task.structure), dry=task.dry, anchored=task.anchor.known
        )
    except FAILURES:
        return found
    for motion in motions:
        try:
            found.append(as_fit(fit_group(model, [motion], task.options), "output_error", [motion.name], ""))
        except FAILURES:
            continue
    return found


def _sure(structure: Structure | None) -> Structure | None:
    """A structure without errors: its own are alike in all trials, and no noise by which they may differ."""
    if structure is None:
        return None
    k, c, mu = (replace(e, stderr=0.0, systematic=0.0) for e in (structure.k, structure.c, structure.mu))
    return replace(structure, k=k, c=c, mu=mu, scatter=dict.fromkeys(structure.scatter, 0.0))
