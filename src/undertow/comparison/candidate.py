"""Sets of suspects as fitted, and what is believed of them.

Belongs here: a candidate's score, posterior probabilities, rivals, why a candidate's numbers mean nothing. Does not
belong here: the search (search.py), fits (joint.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeGuard

import numpy as np
from scipy.stats import f as f_distribution

from undertow.comparison.clock import SIGNIFICANT, no_clock
from undertow.comparison.deviations import learned_mean
from undertow.comparison.joint import JointFit
from undertow.comparison.level import Addend, Level
from undertow.comparison.score_test import GridPlace
from undertow.comparison.suspect import Addition, Suspect, widening
from undertow.equation.kernel import SLOT
from undertow.methods.decay import load_cell_stiffness
from undertow.methods.dry import DEFAULT_SCATTER, PUBLISHED
from undertow.quantities import Estimate

FEEDS, FEEDING = 2.0, "feed energy into the motion"
"""Standard errors below zero from which on a coefficient that takes energy would feed it, and that in words."""

UNKNOWABLE = 1e-10
"""A standard error below that share of its value is one of rounding: nothing is known of that number (two laws are the
same there, and the direction between them is left out of the covariance)."""

NAMING_PROBABILITY = 0.99
"""Posterior probability from which a name is said."""

RIVAL_ODDS = NAMING_PROBABILITY / (1.0 - NAMING_PROBABILITY)
"""A rival whose posterior odds against the answer are better than 1 to this (99) is named beside it: a name alone is as
probable, among the sets that are answers, as a name must be beside nothing."""

FAST = 2.5
"""Rate over the body's fastest from which on a mode that fades at once is no mode."""

UNTOLD = 3.0
"""An inner number whose error is so many times its value is one that the data say nothing of."""

OVERDAMPED = 0.25
"""From this damping ratio on a resonator has no beat of its own: it looks like memory that relaxes."""

BENT = 5.0
"""A trial's own k this many times its scatter away is no mass that changed: all of the trial's forces are scaled."""

CELLS_TELL = 3.0
"""Masses that differ by so many times what load cells show of the stiffness are no stiffness that differs."""

UNUSUAL = 3.0
"""A sensor is named where it errs by more than this many times its prior."""

AS_SCATTER = 0.999
"""Trials of one mass lie so often within the spread up to which masses that differ are scatter of the stiffness: there
are several groups in a campaign."""
MANY = 1e6
"""Degrees of freedom of a scatter that is stated: as good as infinitely many."""

BOUNDED = 0.999
"""Share of an upper bound from which a number of what was added sits on it."""

ON_A_BOUND = 1e-3
"""Share of a bound within which a number of the equation sits on it."""


@dataclass(frozen=True)
class Candidate:
    """A set of suspects as fitted on one level; ``out`` says why it cannot be the answer (empty: it can),
    ``aside`` that its numbers are sound, and only its effect is not what counts."""

    suspects: tuple[Suspect, ...]
    fit: JointFit
    log_prior: float
    out: str = ""
    aside: bool = False

    @property
    def score(self) -> float:
        """Log posterior up to a constant."""
        return -0.5 * self.fit.criterion + self.log_prior

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the set, in the order they were found."""
        return tuple(s.name for s in self.suspects)

    @property
    def amounts_to(self) -> tuple[str, ...]:
        """Names of the set, of a law on its bound that of the simpler one which it becomes there."""
        if not any(any(s.becomes) for s in self.suspects):
            return self.names
        own = self.fit.addends[len(self.fit.addends) - len(self.suspects) :]
        return tuple(_at_its_bound(self.fit, addend, s) for s, addend in zip(self.suspects, own, strict=True))


@dataclass(frozen=True)
class Screened:
    """A suspect that was not fitted: one linear step already shows that it gains too little. ``score`` as a
    candidate's, estimated from that step; ``relative`` to the prescribed equation's."""

    suspect: Suspect
    gain: float
    score: float
    relative: float


@dataclass(frozen=True)
class LevelDiagnosis:
    """The search on one level: the prescribed equation alone, the best candidate, all others, posterior probability of
    the best among all, rivals (sets of names) that the data cannot separate from it, suspects screened out; ``small``
    is the most probable effect that evidence is overwhelming for though it moves the free run by less than what counts,
    ``looked`` how many suspects were tried, ``unfinished`` names those not tried to the end of their budget, ``looks``
    holds places of suspects' grids as seen from the prescribed equation, by label."""

    null: Candidate
    best: Candidate
    candidates: tuple[Candidate, ...]
    confidence: float
    rivals: tuple[tuple[str, ...], ...]
    screened: tuple[Screened, ...] = ()
    small: Candidate | None = None
    looked: int = 0
    unfinished: tuple[str, ...] = ()
    looks: Mapping[str, tuple[GridPlace, ...]] = field(default_factory=dict, repr=False)

    @property
    def named(self) -> bool:
        """Whether something is named as missing."""
        return bool(self.best.suspects)


def conclude(
    null: Candidate,
    best: Candidate,
    found: Sequence[Candidate],
    screened: Sequence[Screened],
    small: Candidate | None = None,
    looked: int = 0,
    unfinished: Sequence[str] = (),
    looks: Mapping[str, tuple[GridPlace, ...]] | None = None,
) -> LevelDiagnosis:
    """The diagnosis with its confidence and rivals."""
    likely = probability(best, found, screened)
    rivals = rivals_of(best, found)
    left = tuple(dict.fromkeys(unfinished))
    return LevelDiagnosis(
        null, best, tuple(found), likely, rivals, tuple(screened), small, looked, left, looks or {}
    )  # fmt: skip


def probability(
    one: Candidate, found: Sequence[Candidate], screened: Sequence[Screened], excluded: bool = False
) -> float:
    """Posterior probability of a set of names among all considered (variants of a name count together); with
    ``excluded`` among those too whose numbers mean nothing."""
    considered = [c for c in found if excluded or not c.out or c is one]
    scores = np.array([*(c.score for c in considered), *(s.score for s in screened)])
    names = [*(tuple(sorted(c.amounts_to)) for c in considered), *((s.suspect.name,) for s in screened)]
    weights = np.exp(scores - scores.max())
    mine = sum(w for w, n in zip(weights, names, strict=True) if n == tuple(sorted(one.amounts_to)))
    return float(mine / weights.sum())


def _at_its_bound(fit: JointFit, addend: Addend, suspect: Suspect) -> str:
    """The name of a law, of one whose inner number (a time, a speed) lies on a bound that of what it becomes there."""
    short, long = suspect.becomes
    for a in (a for a in addend.additions if a.inner):
        value = fit.values.get(f"{addend.prefix}.{a.name}", math.nan)
        if short and value * BOUNDED <= a.lower:
            return short
        if long and value >= BOUNDED * a.upper:
            return long
    return suspect.name


def rivals_of(best: Candidate, found: Sequence[Candidate]) -> tuple[tuple[str, ...], ...]:
    """Other sets of names within `RIVAL_ODDS`: of the same size, or with no name in common."""
    near = [
        c.names for c in found
        if not c.out and c.suspects and best.score - c.score < math.log(RIVAL_ODDS)
        and (len(c.names) == len(best.names) or not set(c.names) & set(best.names))
    ]  # fmt: skip
    if damping_ratio(best.fit) > OVERDAMPED:
        near.append(tuple(s.overdamped_as or s.name for s in best.suspects))
    if len(best.suspects) == 1:
        (alone,) = best.suspects
        near += [(name,) for name in alone.like]  # e.g. far above the body's frequency a resonator is an added mass
        swinging = [c for c in found if len(c.suspects) == 1 and c.suspects[0].swings and c.score > best.score]
        for ahead in (c for c in swinging if alone.plain and damping_ratio(c.fit) > OVERDAMPED):
            near += [(ahead.suspects[0].overdamped_as,), ahead.names]
    return tuple(names for names in dict.fromkeys(near) if sorted(names) != sorted(best.names))


def damping_ratio(fit: JointFit) -> float:
    """Largest damping ratio of the resonators that a fit holds, each spring's own too; 0 where it holds none."""
    found = [value for name, value in fit.values.items() if name.split("@")[0].endswith(".damping_ratio")]
    return max(found, default=0.0)


def evidence_by_name(diagnosis: LevelDiagnosis) -> dict[str, float]:
    """Log posteriors of single laws of the body and its water, up to a constant, where one of them or nothing is named:
    which law another water of the same rig lacks. Empty elsewhere."""
    if len(diagnosis.best.suspects) > 1 or not all(s.of_the_body for s in diagnosis.best.suspects):
        return {}
    alone = [c for c in diagnosis.candidates if len(c.suspects) == 1 and (c.aside or not c.out)]
    pairs = [*((c.suspects[0], c.score) for c in alone), *((s.suspect, s.score) for s in diagnosis.screened)]
    found: dict[str, float] = {}
    for suspect, score in pairs:
        if suspect.of_the_body:
            found[suspect.name] = max(found.get(suspect.name, -math.inf), score - diagnosis.null.score)
    return found


def doubt(level: Level, fit: JointFit, before: JointFit | None = None, doubted: str = "") -> str:
    """Why a candidate's numbers mean nothing: a bound, a coefficient not distinct from zero, or a law of the equation
    that would feed the motion, and did not in the fit ``before``, or is ``doubted`` there for it; empty where they do.
    """
    said_in = level.members[0].model.unit
    for addend in fit.addends:
        if addend in level.standing:
            continue
        beside = addend is fit.addends[-1] and len(fit.addends) > len(level.standing) + 1
        if addend.has_its_own_clock and (said := no_clock(level, fit, addend, beside, before)):
            return said
        if addend.frees and (said := _usual(level, fit, addend)):
            return said
        if said := _gone_at_once(level, fit, addend):
            return said
        strongest = 0.0
        inner = [n for a in addend.additions if a.inner for n in _names_of(fit, addend, a)]
        for a in addend.additions:
            names = _names_of(fit, addend, a)
            for name in names:
                value, error, unit = fit.value(name), fit.solution.stderr(name), said_in(a.unit)
                beyond = value >= a.upper * BOUNDED and not a.endless
                if beyond or (a.lower > 0.0 and value <= a.lower * 1.001):
                    return f"{name} = {value:.4g} {unit} sits on its bound"
                if a.inner and a.lower > 0.0 and not a.endless and not error < UNTOLD * value:
                    return f"{name} = {value:.4g} +- {error:.2g} {unit} could be anything"
                if a.inner or a is not addend.additions[0]:
                    continue
                if a.takes and value < -FEEDS * error and not _unloaded(level, a, name, value):
                    return f"{name} = {value:.4g} {unit} would {FEEDING}"
                if a.slot == "mass" and a.scope != "trial" and value < -FEEDS * error and level.is_dry:
                    return f"{name} = {value:.4g} {unit} would make the body lighter than it is said to be"
                error = _error_beside(fit, name, inner)
                strongest = max(strongest, abs(value) / error if error > 0.0 else 0.0)
            if a.differs:
                difference, error = fit.apart(names)
                strongest = difference / error if error > 0.0 else 0.0
                if said := _as_stiffness(level, fit, names):
                    return said
        if any(m.free_start for m in level.members) and any(a.slot.startswith("hm") for a in addend.additions):
            continue  # mass and a free start trade places: the evidence says whether it is there, not its size
        if addend.additions and not addend.additions[0].inner and strongest < SIGNIFICANT:
            return f"{addend.prefix} is {strongest:.1f} standard errors from zero"
    return _feeds(level, fit, None if FEEDING in doubted else before)


def errors_from_zero(fit: JointFit, addend: Addend) -> dict[str, float]:
    """Standard errors by which a law's coefficient ("") is distinct from zero, of several the most, and its
    "frequency"; empty where the coefficient is not what all trials share."""
    leading = next((a for a in addend.additions if not a.inner), None)
    if leading is None or leading.scope == "trial":
        return {}
    rate = next((a for a in addend.additions if a.inner and a.unit == "rad/s"), None)
    asked = {"": leading} if rate is None else {"": leading, "frequency": rate}
    return {what: _most_errors(fit, addend, a) for what, a in asked.items()}


def _most_errors(fit: JointFit, addend: Addend, a: Addition) -> float:
    """The most standard errors by which one of an addition's unknowns is distinct from zero; inf where none has any."""
    sizes = [abs(fit.value(n)) / e for n in _names_of(fit, addend, a) if (e := fit.solution.stderr(n)) > 0.0]
    return max(sizes, default=math.inf)


def _unloaded(level: Level, a: Addition, name: str, value: float) -> bool:
    """Whether a coefficient only takes back part of what the structure's own law takes where weight rests on it, and
    nobody said how much weight the water takes off: friction in water is then less than in air."""
    rests = [m for m in level.members if "@" not in name or name.endswith(f"@{m.label}")]
    return a.slot == "fc" and all(
        m.model.specimen.volume_assumed and m.model.base[SLOT["fc"]] + value > 0.0 for m in rests
    )  # fmt: skip


def _names_of(fit: JointFit, addend: Addend, a: Addition) -> list[str]:
    """Names of an addition's unknowns: the shared one, each spring's, each trial's."""
    full = f"{addend.prefix}.{a.name}"
    return [n for n in fit.solution.problem.names if n == full or n.startswith((f"{full}@", f"{full}["))]


def _error_beside(fit: JointFit, name: str, inner: Sequence[str]) -> float:
    """Standard error of a coefficient beside what its law has inside as fitted: a memory's stiffness and its time trade
    places, and both can be vague where the memory is not. (At zero what is inside has no meaning.)"""
    at = fit.solution.problem.names.index
    covariance, one, rest = fit.solution.covariance, at(name), [at(n) for n in inner]
    across, own = covariance[one, rest], covariance[np.ix_(rest, rest)]
    variance = float(covariance[one, one] - across @ np.linalg.pinv(own, rcond=1e-12, hermitian=True) @ across)
    return math.sqrt(max(variance, 0.0))


def _feeds(level: Level, fit: JointFit, before: JointFit | None) -> str:
    """Which law of the prescribed equation would have to feed energy into the motion beside what was added, or ends on
    its bound (an added mass that takes nearly all of the body's), in words: that is no explanation, only another
    description of what was seen. One that did so in the fit ``before`` is no reason, unless it does so the more."""

    def below(one: JointFit, name: str, limit: float) -> bool:
        if name not in one.values:
            return False
        value, error = one.value(name), one.solution.stderr(name)
        unknown = 0.0 < error <= UNKNOWABLE * abs(value)  # none at all: on its bound
        return not unknown and value < limit - SIGNIFICANT * error

    for member in level.members:
        dissipating = {term.name for term in member.model.terms if term.dissipates}
        for c in member.model.coefficients:
            name = c.name if c.name in fit.values else f"{c.name}@{member.label}"
            limit = 0.0 if c.term in dissipating else c.lower + ON_A_BOUND * abs(c.lower)
            if before is not None and below(before, name, limit):
                limit = before.value(name)
            if below(fit, name, limit):
                said = f"beside it {name} = {fit.value(name):.3g} +- {fit.solution.stderr(name):.2g} {c.unit} would "
                return said + (FEEDING if c.term in dissipating else "lie on its bound")
        for symbol in ("c", "mu"):
            here, there = (None if one is None else learned_mean(member, one.solution, symbol) for one in (fit, before))
            if _negative(here) and not _negative(there):
                unit = member.model.unit(here.unit)
                return (
                    f"beside it the dry {symbol} of {member.label} = {here.value:.3g} +- {here.stderr:.2g} {unit} "
                    f"would {FEEDING}"
                )
    return ""


def _negative(found: Estimate | None) -> TypeGuard[Estimate]:
    """Whether what takes energy is below zero, by as much as bars a suspect's own coefficient."""
    return found is not None and found.value < -FEEDS * found.stderr


def _as_stiffness(level: Level, fit: JointFit, names: Sequence[str]) -> str:
    """Whether masses differ no more than stiffness does from trial to trial on any rig, in words: a decay's period
    knows the ratio to all that moves alone, and few dry trials can look more alike than the rig is."""
    moving = [fit.theta(trial)[SLOT["mass"]] for trial in range(len(fit.solution.problem.trials))]
    spread = float(np.std([fit.value(n) for n in names]) / np.mean(moving))
    scatter = [m.model.fixed.scatter.get("k", 0.0) for m in level.members if m.model.fixed is not None]
    usual = max([DEFAULT_SCATTER["k"], *scatter])
    shown = PUBLISHED + min(MANY, *(m.scatter_freedom for m in level.members))
    chance = float(f_distribution.ppf(AS_SCATTER, len(names) - 1, shown))
    limit = usual * max(UNUSUAL, math.sqrt(chance * (len(names) - 1) / len(names)))
    if spread < limit and not spread > CELLS_TELL * _stiffness_differs(level):
        return (
            f"masses that differ by {100 * spread:.2g} % are no more than stiffness differs ({100 * usual:.2g} % as "
            f"far as these trials tell, so up to {100 * limit:.2g} %)"
        )
    bent = [abs(fit.value(u.name)) / u.prior_std for u in fit.solution.problem.unknowns if u.name.startswith("k[")]
    if max(bent, default=0.0) > BENT:
        return f"beside such masses a trial's stiffness would differ by {max(bent):.2g} times its scatter"
    return ""


def _stiffness_differs(level: Level) -> float:
    """Relative standard deviation of the trials' stiffness as load cells show it; inf where they do not show all."""
    seen = [set(motion.recording.channels) for member in level.members for motion in member.motions]
    if not all({"spring_force", "displacement"} <= channels for channels in seen):
        return math.inf
    slopes = [np.array([load_cell_stiffness(m).value for m in member.motions]) for member in level.members]
    return float(np.std(np.concatenate([one / one.mean() for one in slopes])))


def _gone_at_once(level: Level, fit: JointFit, addend: Addend) -> str:
    """Whether a mode far faster than the body is gone before the body has swung by a radian, in words: it then moves
    as part of the body, and all that shows it is the release."""
    inner = {a.slot[:2]: fit.values.get(f"{addend.prefix}.{a.name}", 0.0) for a in addend.additions if a.inner}
    rate, fades = inner.get("hw", 0.0), inner.get("hw", 0.0) * inner.get("hz", 0.0)
    if rate < FAST * level.scales.fastest or fades < level.scales.fastest:
        return ""
    return f"{addend.prefix} fades within {1.0 / fades:.2g} s: a release that was not sudden looks so"


def _usual(level: Level, fit: JointFit, addend: Addend) -> str:
    """Whether a suspected sensor errs no more than sensors usually do, in words."""
    names = addend.freed(fit.solution.problem.names)
    mine = [u for u in fit.solution.problem.unknowns if u.name in names]
    usual = mine[0].prior_std if addend.centres else mine[0].prior_std / widening(addend.frees)
    trials = sum(degree == 1 for degree in names.values())  # a short one may have fewer degrees
    error = math.sqrt(sum(fit.value(name) ** 2 for name in names) / trials)
    if error < UNUSUAL * usual:
        turns = addend.frees.endswith("_m") and level.members[0].model.specimen.rotation
        size = f"{error:.2g}{' rad' if turns else ''}"  # else the name says the unit
        return f"{addend.frees} of {size} is no more than {UNUSUAL:g} times what sensors usually err ({usual:.2g})"
    return ""
