"""equations.json of a campaign of decays: what `predict` needs of every group, in full precision.

Belongs here: its entries. Does not belong here: reading them and running them free (front/run_prediction.py), driven
trials (campaign/driven/run.py).
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from undertow.campaign.config import RunConfig
from undertow.comparison.deviations import SLOTS, size_in
from undertow.discrepancy.findings import GroupFindings
from undertow.discrepancy.repaired import repaired_equation, repaired_errors
from undertow.equation.equation import Equation
from undertow.equation.kernel import SLOT
from undertow.errors import IdentificationError
from undertow.likelihood.free_run import scored_channel
from undertow.likelihood.output_error import trajectory
from undertow.methods.dry import DEFAULT_SCATTER
from undertow.report.verdict_file import CONTRACT, plain

FEWEST_TRIALS = 4
"""Trials of a group from which on their free runs say how much differs from trial to trial."""


def equations_entry(group: GroupFindings, stated: Mapping[str, float] | None = None) -> dict[str, Any]:
    """One group's equations: the prescribed one, and the repaired one where what was found is a law of motion.

    ``noise`` and ``rest_std`` are the sensor's noise and how far its zero was from the rest position, rms over the
    trials, ``largest`` the largest amplitude among them, SI; ``missed_nrmse`` is what the equation leaves beyond
    repeatability. ``scatter`` from trial to trial is that of the dry trials, else as ``stated``, else assumed, and then
    no larger than the group's own free runs show.
    """
    verdict, versions = group.verdict, {}
    allowed = verdict.repeatability_nrmse
    inner, unit = {name: e.total_stderr for name, e in verdict.baseline.parameters.items()}, group.specimen.unit
    versions["baseline"] = _version(group.equation, group.equation_errors, verdict.baseline.nrmse, allowed, unit, inner)
    if verdict.augmented is not None:
        try:
            repaired = repaired_equation(group.equation, verdict, group.specimen)
        except IdentificationError:
            pass  # a clock, a gain, a release: the prescribed equation is what takes the body anywhere
        else:
            errors = repaired_errors(group.equation, group.equation_errors, verdict, group.specimen)
            inner = {name: e.total_stderr for name, e in verdict.augmented.parameters.items()}
            had = Counter(term.name for term in group.equation.terms)
            versions["augmented"] = _version(repaired, errors, verdict.augmented.nrmse, allowed, unit, inner, had)
    motions = [one.motion for one in group.trials]
    noise = [motion.noise.get(scored_channel(motion), 0.0) for motion in motions]
    structure, scatter = group.structure, stated or own_scatter(group)
    return {
        "group": dict(group.key), "label": group.label, "trials": [motion.name for motion in motions], "driven": False,
        "versions": versions, "noise": _rms(noise), "rest_std": _rms([m.equilibrium.value for m in motions]),
        "largest": _known(max((motion.amplitude for motion in motions), default=0.0)),
        "scatter": dict(scatter if structure is None else structure.scatter),
    }  # fmt: skip


def own_scatter(group: GroupFindings) -> dict[str, float]:
    """`DEFAULT_SCATTER`, smaller by one factor where free runs with nothing adjusted miss less than it says."""
    if not group.equation.compiled or len(group.trials) < FEWEST_TRIALS:
        return dict(DEFAULT_SCATTER)
    named = [SLOTS[name] for name in DEFAULT_SCATTER]
    slots = np.array([SLOT[slot] for slot in named], dtype=np.int64)
    missed, said = 0.0, 0.0
    for one in group.trials:
        if not math.isfinite(one.as_measured):
            continue
        theta = group.equation.theta(float(one.simulated[0]))
        sizes = [size_in(theta, slot) * share for slot, share in zip(named, DEFAULT_SCATTER.values(), strict=True)]
        moved = trajectory(theta, slots, np.maximum(one.t, 0.0))[0][:, 1:] * sizes
        said += float(np.mean(np.sum(moved**2, axis=1)))
        noise = one.motion.noise.get(scored_channel(one.motion), 0.0)
        missed += max(one.as_measured**2 * float(np.mean(one.measured**2)) - noise**2, 0.0)
    # the numbers were fitted to these trials: as many degrees of freedom are gone as a trial has scatters
    seen = missed * len(group.trials) / (len(group.trials) - 1)
    factor = min(1.0, math.sqrt(seen / said)) if said > 0.0 else 1.0
    return {name: factor * value for name, value in DEFAULT_SCATTER.items()}


def _rms(values: Sequence[float]) -> float:
    known = [value for value in values if math.isfinite(value)]
    return math.sqrt(float(np.mean(np.square(known)))) if known else 0.0


def _version(
    equation: Equation,
    errors: Mapping[str, float],
    nrmse: float,
    allowed: float,
    unit: Callable[[str], str],
    inner: Mapping[str, float] | None = None,
    had: Mapping[str, int] | None = None,
) -> dict[str, Any]:
    """One equation: its laws' numbers with their errors, each number for itself; ``had``: how often the prescribed one
    has each law, behind which the named ones stand. ``unit`` says in which unit a law's number is here."""
    rows = [row | {"unit": unit(row["unit"])} for row in _rows(equation, errors, inner or {}, had or {})]
    stderr = [row["stderr"] for row in rows]
    beyond = nrmse if not math.isfinite(allowed) or nrmse > allowed else 0.0
    return {
        "mass_kg": equation.mass_kg, "mass_stderr": _known(errors.get("mass", 0.0)), "rest_m": equation.rest_m,
        "compiled": equation.compiled, "equation": equation.text(errors), "rows": rows,
        "covariance": np.diag(np.square(stderr)).tolist(), "missed_nrmse": _known(beyond),
    }  # fmt: skip


def _rows(
    equation: Equation, errors: Mapping[str, float], inner: Mapping[str, float], had: Mapping[str, int]
) -> Iterator[dict[str, Any]]:
    counts = Counter[str]()
    for term, value in zip(equation.terms, equation.coefficients, strict=True):
        counts[term.name] += 1
        added = counts[term.name] - had.get(term.name, 0)
        prefix = f"{term.name}#{added}." if added > 1 else f"{term.name}{'.' if added > 0 and had else '_'}"
        once_more = added > 0 and term.name in had
        for parameter in term.parameters:
            leads = parameter is term.parameters[0]
            own = inner.get(f"{prefix}{parameter.name}", 0.0)
            yield {
                "term": term.name, "number": counts[term.name], "law": term.law, "parameter": parameter.name,
                "unit": parameter.unit, "value": value if leads else float(getattr(term, parameter.name)),
                "stderr": _known(errors.get(term.name, own) if leads and not once_more else own),
                "relative_to": term.relative_to,
            }  # fmt: skip


def _known(value: float) -> float:
    return float(value) if math.isfinite(value) else 0.0


def equations_file(entries: Sequence[Mapping[str, Any]], config: RunConfig) -> Any:
    """The whole file as plain values."""
    anchor = "mass" if config.specimen.mass_kg is not None else "none: per mass, or as the groups say"
    return plain(
        {"contract": CONTRACT, "coordinate": config.equation.coordinate, "anchor": anchor, "seed": config.seed,
         "groups": list(entries)}
    )  # fmt: skip
