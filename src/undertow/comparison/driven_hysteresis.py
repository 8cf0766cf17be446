"""Which hysteresis: members of the family compete where the simplest one, or dry friction, stands in an equation.

Each member takes the place of the one that stands, begins from its numbers, and is fitted to the same part of the
record. Members that come as close to unseen samples as the closest (within `CLOSER`) are rivals: the record cannot
tell them apart, and the one with fewest numbers is kept. One with more numbers than that which stands must also be
proved on parts that were left out in turn (driven_folds.py).

Belongs here: members, their starts, the contest. Does not belong here: whether a hysteresis is there at all
(driven_search.py), the rows (equation/driven_hysteresis.py).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from undertow.comparison.driven_folds import (
    CLOSER,
    TRYING,
    Tried,
    come_closer,
    fold_errors,
    validation_rms,
)
from undertow.conditioning.driven import DrivenTrial
from undertow.equation.driven_hysteresis import HYSTERESES, BoucWen, LuGre
from undertow.equation.driven_laws import find_driven
from undertow.errors import IdentificationError
from undertow.likelihood.driven import DrivenLaws, drive_for, driven_problem, extent_of
from undertow.likelihood.output_error import SearchEffort, residuals
from undertow.methods.driven import DrivenFit, fit_driven
from undertow.methods.driven_begin import begun_beyond
from undertow.recording.recording import Array

SLIDING = LuGre.takes_the_place_of
REMEMBERED = (BoucWen.name, *SLIDING)
"""Laws that open the contest where they stand in an equation."""
WITH_EXPONENT = "bouc_wen with exponent"
"""How Bouc and Wen's law is called where its exponent is found, not one."""
EFFORT = SearchEffort(30, 0.1)
WINDOWS = 6
"""Windows with start states of their own on which a member's fit begins: its start is the numbers of another law."""
START_PART, BEGUN = 4000, 4
"""Samples on which the starts of a member are compared, by one free run each; and starts that are fitted to them."""
BEND = 0.01
"""Way over which the bristles of dry friction bend at first, as a share of the motion."""

Numbers = Mapping[str, float]


@dataclass(frozen=True)
class Contest:
    """What stands after a contest, its rms on unseen samples, what was tried, whom the record cannot tell from the
    member that stands, and the fits of all members."""

    fitted: DrivenFit
    rms: float
    tried: tuple[Tried, ...] = ()
    rivals: tuple[str, ...] = ()
    members: Mapping[str, DrivenFit] = field(default_factory=dict)


def remembers(fitted: DrivenFit) -> bool:
    """Whether a law that opens the contest stands in the equation, and no other hysteresis."""
    names = {term.name for term in fitted.laws.terms}
    others = {term.name for term in HYSTERESES} - {"bouc_wen"}
    return not names & others and bool(names & {*REMEMBERED})


def contest(
    training: Sequence[DrivenTrial],
    unseen: Sequence[DrivenTrial],
    standing: tuple[DrivenFit, float],
    suspects: Sequence[str] | None = None,
) -> Contest:
    """The member of the family that the record shows; ``standing`` is the fit that it competes with, and its rms."""
    current, lowest = standing
    tried: list[Tried] = []
    fits: dict[str, DrivenFit] = {}
    for name, law, grid in _members(training[0], current):
        if suspects is not None and law not in suspects:
            continue
        try:
            start = _best_start(training[0], current, law, grid, name == WITH_EXPONENT)
            fits[name] = fit_driven(training, start, windows=0, effort=EFFORT)
        except IdentificationError as reason:
            tried.append(Tried(name, -math.inf, lowest, math.inf, str(reason)))
            continue
        tried.append(Tried(name, 0.0, lowest, validation_rms(unseen, fits[name]), _unsound(law, fits[name])))
    return _decided(training, standing, tried, fits)


def _decided(
    training: Sequence[DrivenTrial],
    standing: tuple[DrivenFit, float],
    tried: Sequence[Tried],
    fits: Mapping[str, DrivenFit],
) -> Contest:
    """Who is kept: fewest numbers among those that come as close as the closest; proved where it has as many numbers as
    what stands, or more."""
    current, lowest = standing
    own = _hysteresis_of(current) or "what stands"
    every = {own: (current, lowest)} | {one.name: (fits[one.name], one.after) for one in tried if not one.because}
    left, refused = dict(every), dict[str, str]()
    before = None
    while True:
        closest = min(after for _, after in left.values())
        alike = [name for name, (_, after) in left.items() if after <= (1.0 + CLOSER) * closest]
        kept = min(alike, key=lambda name: (len(left[name][0].names), left[name][1]))
        if kept == own or len(left[kept][0].names) < len(current.names):
            break
        before = fold_errors(training, current.started) if before is None else before
        why = come_closer(before, fold_errors(training, left[kept][0].started))
        if not why:
            break
        refused[kept] = why
        del left[kept]
    said = tuple(
        replace(one, because=one.because or refused.get(one.name) or ("" if one.name == kept else _other(one, kept)))
        for one in tried
    )
    fitted, rms = every[kept]
    near = (
        name for name, (_, after) in every.items()
        if after <= (1.0 + CLOSER) * rms and not name.startswith(kept)  # Bouc and Wen's with an exponent contains it
    )  # fmt: skip
    return Contest(fitted, rms, said, tuple(near), {name: fit for name, (fit, _) in every.items()})


def _other(one: Tried, kept: str) -> str:
    """Why a sound member is not the one that is kept."""
    return f"{kept} comes closer, or as close with fewer numbers: {one.after:.4g} on unseen samples"


def _hysteresis_of(fitted: DrivenFit) -> str | None:
    """Name of the hysteresis that stands in an equation."""
    return next((term.name for term in fitted.laws.terms if "bw_a" in term.slots.values()), None)


def _unsound(law: str, fitted: DrivenFit) -> str:
    """Why a member's fit is no law: a number of its own on a bound, or a start that no motion gives."""
    bounds = fitted.outcome.startswith("on a bound: ") and f"{law}." in fitted.outcome
    if bounds or fitted.outcome.startswith("not identifiable"):
        return fitted.outcome
    return begun_beyond(fitted.solution.problem, fitted.solution.values)


def _members(trial: DrivenTrial, current: DrivenFit) -> Iterator[tuple[str, str, Sequence[Numbers]]]:
    """Members by the name that is said, their law, and the grid of their starts: relative to the loop that stands, or
    to the friction."""
    extent, numbers = extent_of(trial), current.numbers
    speeds = [share * extent.speed for share in (0.05, 0.2)]
    friction = numbers.get(f"{SLIDING[0]}.force_N", 0.0)
    if _hysteresis_of(current) != "bouc_wen":
        stiffness = friction / (BEND * extent.size)
        yield "lugre", "lugre", [
            {"sigma0_N_per_m": s * stiffness, "coulomb_N": friction, "static_N": 0.2 * friction,
             "velocity_m_per_s": v} for s in (0.1, 1.0, 10.0) for v in speeds
        ]  # fmt: skip
        return
    alpha, loop, skew = (numbers[f"bouc_wen.{key}"] for key in ("alpha_N_per_m", "loop", "skew"))
    z = _pulled(trial, alpha, loop, skew)
    size, most = float(np.sqrt(np.mean(z**2))), float(np.max(np.abs(z)))
    yield WITH_EXPONENT, "bouc_wen", [
        {"alpha_N_per_m": alpha, "loop": s * loop, "skew": s * skew, "exponent": n, "unit_N": size}
        for n in (1.2, 2.0) for s in (0.7, 1.0)
    ]  # fmt: skip
    yield "pinched", "pinched", [
        {"alpha_N_per_m": s * alpha, "loop": loop, "skew": d * skew, "pinch": p, "width_N": w * size}
        for s in (1.0, 2.0) for d in (1.0, 0.0) for p in (0.4, 0.8) for w in (0.3, 0.8)
    ]  # fmt: skip
    plain = [{"stiffness_N_per_m": s * alpha, "slip_N": f * most} for s in (1.0, 1.5) for f in (0.9, 1.2, 2.0)]
    yield "iwan", "iwan", plain
    yield "lugre", "lugre", [
        {"sigma0_N_per_m": s * alpha, "coulomb_N": f * most + friction, "static_N": 0.2 * most, "velocity_m_per_s": v}
        for s in (1.0, 3.0) for f in (0.6, 0.9) for v in speeds
    ]  # fmt: skip


def _pulled(trial: DrivenTrial, alpha: float, loop: float, skew: float) -> Array:
    """What the loop that stands remembers along the recorded motion, N."""
    x = trial.outputs.get("displacement")
    if x is None:
        return np.array([alpha * extent_of(trial).size])
    z = alpha * BoucWen(loop=loop, skew=skew, alpha=alpha).force(x, x, x, trial.t)
    return z if np.all(np.isfinite(z)) and np.any(z) else np.array([alpha * extent_of(trial).size])


def _in_its_place(current: DrivenFit, law: str, numbers: Numbers, with_exponent: bool) -> DrivenLaws:
    """The equation with a member in the place of the hysteresis, and of the friction that it contains."""
    term = find_driven(law)
    gone = {law, _hysteresis_of(current) or "", *term.takes_the_place_of}
    laws = current.started
    starts, fixed = (
        {key: value for key, value in part.items() if key.split(".")[0] not in gone}
        for part in (laws.starts, laws.fixed)
    )
    if with_exponent:
        fixed["bouc_wen.unit_N"] = numbers["unit_N"]
    terms = (*(t for t in laws.terms if t.name not in gone), term)
    return replace(
        laws, terms=terms, fixed=fixed, starts=starts | {f"{law}.{key}": value for key, value in numbers.items()}
    )


def _best_start(
    trial: DrivenTrial, current: DrivenFit, law: str, grid: Sequence[Numbers], with_exponent: bool
) -> DrivenLaws:
    """The numbers of the closest fit to the first part of a record, begun from the `BEGUN` starts whose free runs come
    closest to it.

    Raises IdentificationError where none has a bounded motion, and where a member comes no closer to that part than
    what stands, or, with fewer numbers, not as close.
    """
    part = trial.part(0, min(trial.t.size, START_PART))
    drives, costs = {part.name: drive_for(part)}, list[tuple[float, int]]()
    starts = [_in_its_place(current, law, numbers, with_exponent) for numbers in grid]
    for i, laws in enumerate(starts):
        held = replace(laws, fixed={**laws.fixed, **laws.starts})
        problem = driven_problem([part], held, 1, None, drives)
        got = residuals(problem.trials[0], np.array([u.start for u in problem.unknowns]))
        if got is not None:
            costs.append((float(got[0] @ got[0]), i))
    best: DrivenFit | None = None
    for _, i in sorted(costs)[:BEGUN]:
        try:
            fitted = fit_driven([part], starts[i], drives, WINDOWS, TRYING)
        except IdentificationError:
            continue
        if (best is None or fitted.solution.chi2 < best.solution.chi2) and not _unsound(law, fitted):
            best = fitted
    if best is None:
        raise IdentificationError(
            f"none of {len(grid)} starts of {law} leads to a bounded motion inside its bounds; give start values"
        )
    plain = fit_driven([part], current.started, drives, WINDOWS, TRYING)
    allowed = 1.0 + CLOSER if len(best.names) < len(current.names) else 1.0 - CLOSER
    if best.solution.chi2 > allowed**2 * plain.solution.chi2:
        raise IdentificationError(
            f"{law} comes no closer to the first {part.t.size} samples than what stands: their squares are "
            f"{best.solution.chi2 / plain.solution.chi2:.3g} of what they were; leave it out"
        )
    return best.started
