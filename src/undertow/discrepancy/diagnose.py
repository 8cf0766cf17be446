"""What is missing: suspects ranked by evidence on one level, alone and together.

Every suspect is added to the prescribed equation and everything is refitted, jointly over the level's training trials
and springs. The criterion (joint.py) is turned into probabilities with a stated prior: half that nothing is missing,
half shared equally among the suspects, and a hundredth of that for each further effect. A suspect whose numbers mean
nothing (on a bound, not told from zero) is out. Rivals within odds of 20 to 1 are named beside the answer.

Belongs here: the search. Does not belong here: the proof on held-out trials (prove.py), words (verdict.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from undertow.discrepancy.joint import Addend, JointFit, Level, fit_joint, free_run_error, full_name, residual_memory
from undertow.discrepancy.suspects import EACH_SPRING, Addition, Suspect
from undertow.errors import IdentificationError

PRIOR_NOTHING = 0.5
"""Prior probability that the prescribed equation lacks nothing."""

FURTHER_EFFECT_PRIOR = 0.01
"""Prior odds of a second (third) effect beside one that is there."""

RIVAL_ODDS = 20.0
"""A rival whose posterior odds against the answer are better than 1 to this is named beside it."""

ACCUSE_PROBABILITY = 0.99
"""Posterior probability from which a name is said."""

SIGNIFICANT = 3.0
"""A suspect's coefficient must be this many standard errors from zero."""

MOST_EFFECTS = 3

STRUCTURE_WHEN_DRY_IS_CLEAN = 0.01
"""Prior odds of a structural effect where dry trials of the same rig show nothing missing."""

ALWAYS_TRIED_BESIDE = frozenset({"linear_damping", "hidden_resonator", "coulomb_friction", "cubic_damping"})
"""Effects that water often brings together; others join only with evidence of their own."""

EVIDENCE_ALONE = 10.0
"""Gain in log posterior that a suspect must have shown alone to be tried beside another."""

DISSIPATES = frozenset({"linear_damping", "coulomb_friction"})
"""Additions that cannot be negative: water takes energy."""

OVERDAMPED = 0.25
"""From this damping ratio on a resonator has no beat of its own: it cannot be told from memory that relaxes."""

OWN_FREQUENCY = 0.1
"""A force this close (relative) to the body's own frequency cannot be told from a trial whose k differs."""

REMAINING = 0.8
"""A further effect must leave at most this share of the free run's error that stood before it."""

WORTH = 0.5
"""Share of repeatability by which the free run must come closer (in quadrature) for an effect to be named."""

REFINED = 2
"""Of several starts, so many of the best are followed to their end."""


@dataclass(frozen=True)
class Candidate:
    """A set of suspects as fitted on one level; ``out`` says why it cannot be the answer (empty: it can)."""

    suspects: tuple[Suspect, ...]
    fit: JointFit
    log_prior: float
    out: str = ""

    @property
    def score(self) -> float:
        """Log posterior up to a constant."""
        return -0.5 * self.fit.criterion + self.log_prior

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the set, in the order they were found."""
        return tuple(s.name for s in self.suspects)


@dataclass(frozen=True)
class Diagnosis:
    """The search on one level: the prescribed equation alone, the best candidate, all others, posterior probability of
    the best among all, rivals (sets of names) that the data cannot separate from it."""

    null: Candidate
    best: Candidate
    candidates: tuple[Candidate, ...]
    confidence: float
    rivals: tuple[tuple[str, ...], ...]

    @property
    def accused(self) -> bool:
        """Whether something is missing with a probability of `ACCUSE_PROBABILITY`."""
        return bool(self.best.suspects)


def diagnose(level: Level, suspects: Sequence[Suspect], allowed: float, clean_when_dry: bool = False) -> Diagnosis:
    """Search one level for what its equation lacks; ``allowed`` is the level's repeatability (nrmse).

    ``clean_when_dry`` says that the dry trials of the same rig need nothing: what belongs to the structure would have
    shown there.

    Evidence alone would accuse effects that no free run shows (a gram of water, the smoothing of an amplifier): what
    is named must also bring the free run of the training trials closer by `WORTH` of what repeating the test allows.
    The search for further effects ends where the free run is as close as repetitions are to each other.

    Raises IdentificationError where not even the prescribed equation can be fitted.
    """
    first = fit_joint(level, (), 1.0, {}, 10.0, growing=True)
    memory = residual_memory(first.solution)
    together = fit_joint(level, (), memory, _values(first), first.misfit, growing=False)
    null = Candidate((), _null(level, together), math.log(PRIOR_NOTHING))
    found, best = [null], null
    if len(level.members) == 1:
        suspects = [s for s in suspects if s.variant != EACH_SPRING]
    error = free_run_error(level, null.fit)
    for depth in range(MOST_EFFECTS):
        if depth and error <= allowed:
            break
        tried = []
        for suspect in suspects:
            if _may_join(best, suspect) and (depth == 0 or _promising(suspect, found, null)):
                prior = _log_prior(best, suspect, len(suspects), clean_when_dry)
                tried += [c] if (c := _added(level, best, suspect, prior)) is not None else []
        found += tried
        needed = best.score + math.log(ACCUSE_PROBABILITY / (1.0 - ACCUSE_PROBABILITY))
        probable = [c for c in tried if not c.out and c.score > needed]
        ahead = _worthwhile(level, probable, error, allowed, REMAINING if depth else 1.0)
        if ahead is None:
            break
        best, error = ahead
    return Diagnosis(null, best, tuple(found), _probability(best, found), _rivals(best, found))


def _null(level: Level, together: JointFit) -> JointFit:
    """The prescribed equation alone: one water for all springs, or each spring's own added mass and drag, whichever the
    data prefer. A suspect has to beat both."""
    if len(level.members) < 2:
        return together
    try:
        apart = fit_joint(replace(level, shared_water=False), (), together.memory, {}, together.misfit, growing=True)
    except IdentificationError:
        return together
    return min((together, apart), key=lambda f: f.criterion)


def _promising(suspect: Suspect, found: Sequence[Candidate], null: Candidate) -> bool:
    """Whether a suspect is tried beside what is there: one with a single start, a second resonator, or one that alone
    had evidence for it."""
    alone = [c.score - null.score for c in found if c.names == (suspect.name,)]
    cheap = suspect.name in ALWAYS_TRIED_BESIDE
    return cheap or max(alone, default=0.0) > EVIDENCE_ALONE


def _worthwhile(
    level: Level, candidates: Sequence[Candidate], error: float, allowed: float, remaining: float
) -> tuple[Candidate, float] | None:
    """The most probable candidate that brings the free run closer by what counts, with its error."""
    for candidate in sorted(candidates, key=lambda c: -c.score):
        closer = free_run_error(level, candidate.fit)
        if closer < remaining * error and math.sqrt(error**2 - closer**2) > WORTH * allowed:
            return candidate, closer
    return None


def _may_join(best: Candidate, suspect: Suspect) -> bool:
    """Whether a suspect can be added: once each, resonators up to three, one variant of a name."""
    if suspect.name == "external_forcing" and best.suspects:
        return False  # a clock of its own in every trial takes up whatever a memory leaves
    if suspect.name == "hidden_resonator":
        return not best.suspects or (not suspect.variant and sum(n == suspect.name for n in best.names) < 3)
    return suspect.name not in best.names


def _log_prior(best: Candidate, suspect: Suspect, count: int, clean_when_dry: bool) -> float:
    """Log prior of the best set with one more suspect."""
    before = math.log(FURTHER_EFFECT_PRIOR) + best.log_prior if best.suspects else math.log(1.0 - PRIOR_NOTHING)
    unlikely = STRUCTURE_WHEN_DRY_IS_CLEAN if clean_when_dry and suspect.origin == "structure" else 1.0
    return before + math.log(unlikely / count)


def _added(level: Level, best: Candidate, suspect: Suspect, prior: float) -> Candidate | None:
    """The best candidate with one more suspect, from several starts; None where no start gives a motion."""
    starts = suspect.starts(level.scales)
    waters = _waters(level, best, suspect)
    quick = [f for w in waters for start in starts if (f := _attempt(w, best, suspect, start)) is not None]
    if not quick:
        return None
    ahead = sorted(quick, key=lambda f: f.criterion)[: (REFINED if len(starts) * len(waters) > 1 else 1)]
    fit = min((_refined(level, f) for f in ahead), key=lambda f: f.criterion)
    return Candidate((*best.suspects, suspect), fit, prior, _doubt(level, fit))


def _waters(level: Level, best: Candidate, suspect: Suspect) -> tuple[Level, ...]:
    """Levels on which a suspect is tried: what stands decides; damping of each spring's own (waves radiated at its own
    frequency) comes with an added mass of its own too."""
    if best.suspects:
        return (replace(level, shared_water=best.fit.shared_water),)
    if suspect.variant == EACH_SPRING:
        return level, replace(level, shared_water=False)
    return (level,)


def _attempt(level: Level, best: Candidate, suspect: Suspect, start: float) -> JointFit | None:
    """One fit from one start, at the noise of what stands; None where it gives no motion."""
    addend = Addend(_prefix(best, suspect), _renumbered(suspect.additions(level.scales, start), best))
    known = _values(best.fit) if best.suspects or not suspect.memory else {}
    growing = not best.suspects and (suspect.memory or not level.shares(best.fit.solution.problem.names))
    try:
        return fit_joint(level, (*best.fit.addends, addend), best.fit.memory, known, best.fit.misfit, growing, True)
    except IdentificationError:
        return None


def _refined(level: Level, fit: JointFit) -> JointFit:
    """The same model refitted from where it is until its noise is its own."""
    level = replace(level, shared_water=fit.shared_water)
    return fit_joint(level, fit.addends, fit.memory, _values(fit), fit.misfit, growing=False)


def _prefix(best: Candidate, suspect: Suspect) -> str:
    number = sum(n == suspect.name for n in best.names) + 1
    return suspect.name if number == 1 else f"{suspect.name}#{number}"


def _renumbered(additions: Sequence[Addition], best: Candidate) -> tuple[Addition, ...]:
    """A second resonator takes the integrator's second place."""
    taken = sum(n == "hidden_resonator" for n in best.names)
    if not taken or not additions[0].slot.startswith("h") or additions[0].slot[-1] != "1":
        return tuple(additions)
    place = str(taken + 1)
    return tuple(replace(a, slot=a.slot[:-1] + place) for a in additions)


def _values(fit: JointFit) -> dict[str, float]:
    return dict(zip(fit.solution.problem.names, fit.solution.values.tolist(), strict=True))


def _doubt(level: Level, fit: JointFit) -> str:
    """Why a candidate's numbers mean nothing: a bound, or a coefficient not told from zero; empty where they do."""
    names = fit.solution.problem.names
    for addend in fit.addends:
        if addend.prefix == "external_forcing":
            clock = fit.value("external_forcing.frequency_rad_per_s")
            for own in (level.scales.slowest, level.scales.fastest):
                if abs(clock / own - 1.0) < OWN_FREQUENCY:
                    return f"external_forcing at {clock:.3g} rad/s is the body's own motion of {own:.3g} rad/s"
        first = addend.additions[0]
        strengths = []
        for a in addend.additions:
            full = f"{addend.prefix}.{a.name}"
            for name in (n for n in names if n == full or n.startswith(f"{full}@")):
                value = fit.value(name)
                at_bound = value >= a.upper * 0.999 or (a.lower > 0.0 and value <= a.lower * 1.001)
                if at_bound:
                    return f"{name} = {value:.4g} {a.unit} sits on its bound"
                if a is first:
                    error = fit.solution.stderr(name)
                    if addend.prefix in DISSIPATES and value < -2.0 * error:
                        return f"{name} = {value:.4g} {a.unit} would feed energy into the motion"
                    strengths.append(abs(value) / error if error > 0.0 else 0.0)
        if strengths and max(strengths) < SIGNIFICANT:
            return f"{addend.prefix} is {max(strengths):.1f} standard errors from zero"
    return ""


def _probability(best: Candidate, found: Sequence[Candidate]) -> float:
    """Posterior probability of the best set of names among all considered (variants of a name count together)."""
    scores = np.array([c.score for c in found if not c.out or c is best])
    names = [tuple(sorted(c.names)) for c in found if not c.out or c is best]
    weights = np.exp(scores - scores.max())
    mine = sum(w for w, n in zip(weights, names, strict=True) if n == tuple(sorted(best.names)))
    return float(mine / weights.sum())


def _rivals(best: Candidate, found: Sequence[Candidate]) -> tuple[tuple[str, ...], ...]:
    """Other sets of names of the same size within `RIVAL_ODDS`."""
    near = [
        c.names for c in found
        if not c.out and tuple(sorted(c.names)) != tuple(sorted(best.names)) and c.suspects
        and best.score - c.score < math.log(RIVAL_ODDS) and len(c.names) == len(best.names)
    ]  # fmt: skip
    if any(a.slot.startswith("hz") and best.fit.value(f"{d.prefix}.{a.name}") > OVERDAMPED
           for d in best.fit.addends for a in d.additions):  # fmt: skip
        near.append(tuple("relaxation" if n == "hidden_resonator" else n for n in best.names))
    return tuple(dict.fromkeys(near))


def strengths(diagnosis: Diagnosis) -> Mapping[str, float]:
    """By how much the log posterior of each single suspect exceeds that of the prescribed equation alone."""
    return {c.suspects[0].label: c.score - diagnosis.null.score for c in diagnosis.candidates if len(c.suspects) == 1}


__all__ = ["Candidate", "Diagnosis", "diagnose", "full_name", "strengths"]
