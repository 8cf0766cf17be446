"""One more suspect beside what stands: from several starts, or from the best places of its grid.

Belongs here: the fits of one suspect. Does not belong here: which are tried and believed (search.py, candidate.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from undertow.comparison.candidate import Candidate, doubt
from undertow.comparison.joint import JointFit, at_memory, fit_joint
from undertow.comparison.level import Addend, Level
from undertow.comparison.score_test import GridPlace, renumbered
from undertow.comparison.suspect import COMMON, EACH_SPRING, Addition, Suspect, widening
from undertow.comparison.suspects import RADIATION, kernel_additions
from undertow.errors import IdentificationError
from undertow.likelihood.budget import BudgetError, metered
from undertow.likelihood.noise import residual_memory

REFINED = 2
"""Of several starts, so many of the best are followed to their end."""

SAME_END = 0.01
"""Quick fits of one model whose criteria differ by less ended at the same place."""

QUICK_LOOKS = 300.0
"""What one start may spend, in looks at the level as it stands: those of laws that were named took under 200."""

LOST_LOOKS = 2.0
"""Times `QUICK_LOOKS`: what a law's own start may spend where all fits from its grid lost the way. Bristles take short
steps."""

NO_MORE_THAN_NOISE = 1.2
"""Mean squared residual over noise up to which nothing is left to be found by another start."""

LEFT_BY_CHANCE = 1.03
"""Mean squared residual over noise up to which no wider form is tried: what some thousand samples leave by chance. What
lies above it another law would take, and be more probable: a resonator was, beside a force that left 1.12."""

IN_VAIN = 2
"""Wider forms of a law one after the other that came no closer: a further one would not either."""

OF_NO_SIZE = 1e-3
"""Share of its scale at which a law's coefficient is as if the law were not there."""

FURTHER_OFF = 1.1
"""A fit that leaves so many times what it left without its last law lost the way: it could have left that law out."""

PAIR_BUDGET = 500.0
"""What a pair may spend that is fitted at once: those that were named took 5 to 100 looks (pairs study, 5030800),
bristles beside another law 1,900, and were none."""

SUSPECT_BUDGET = 3000.0
LEVEL_BUDGET = 8000.0
"""What one suspect, and all of a level together, may spend, in looks at the level with the prescribed equation: the
dearest that was named took 2000 (a resonator that depends on its amplitude)."""

TRIALS_A_BUDGET = 4.0
"""So many trials more double what may be spent: each brings unknowns of its own, and fits take more steps."""


def one_look(fit: JointFit) -> float:
    """Steps of one look at a fit's recordings with its unknowns: the unit of budgets."""
    return float(sum(trial.t.size * (1 + trial.slots.size) for trial in fit.solution.problem.trials))


def from_starts(
    level: Level, best: Candidate, suspect: Suspect, prior: float, most: float = math.inf,
    further: Sequence[float] = (), looked: Sequence[GridPlace] = (),
) -> Candidate | None:
    """The best candidate with one more suspect, from its own starts and ``further`` ones, and where a small one
    ``looked`` best; None where no start gives a motion, or none a criterion under ``most`` in a quick fit."""
    starts = (*suspect.starts(level.scales), *further)
    waters = _waters(level, best, suspect)
    quick = [f for w in waters for start in starts if (f := _attempt(w, best, suspect, start)) is not None]
    quick += [f for w in waters for place in looked if (f := _from_look(w, best, suspect, place)) is not None]
    if all(_lost(best, f) for f in quick):
        quick += [f for w in waters for start in starts if (f := _from_nothing(w, best, suspect, start)) is not None]
    quick = [f for f in quick if f.criterion < most]
    if not quick:
        return None
    ahead = sorted(quick, key=lambda f: f.criterion)[: (REFINED if len(starts) * len(waters) > 1 else 1)]
    ahead += _half_periods_on(level, best, suspect, ahead[0])
    fit = min((_refined(level, f) for f in _apart(ahead)), key=lambda f: f.criterion)
    return Candidate((*best.suspects, suspect), fit, prior, doubt(level, fit, best.fit, best.out))


def from_places(
    level: Level, best: Candidate, suspect: Suspect, places: Sequence[GridPlace], prior: float,
    further: Sequence[float] = (),
) -> Candidate | None:
    """The best candidate with one more suspect, from places of its grid, and in growing windows from ``further`` starts
    of its own; None without a motion.

    Water that swings by itself may be what kept the springs apart: it is also tried with one water for all.
    """
    stands = replace(level, shared_water=best.fit.shared_water)
    tried = [(stands, place) for place in places]
    if suspect.memory and suspect.origin == "water" and not best.suspects and stands != level:
        tried.append((level, places[0]))
    fits = [f for w, p in tried if (f := _from_place(w, best, suspect, p)) is not None]
    if places and all(_lost(best, f) for f in fits):  # one linear step from places tells little of bristles
        starts = suspect.starts(level.scales)[:REFINED]
        fits += [f for s in starts if (f := _attempt(stands, best, suspect, s, LOST_LOOKS)) is not None]
    if fits:
        fits += _half_periods_on(level, best, suspect, min(fits, key=lambda f: f.criterion))
    fits += [f for start in further if (f := _in_windows(stands, best, suspect, start)) is not None]
    if not fits:
        return None
    nearest = _apart(sorted(fits, key=lambda f: f.criterion))[:REFINED]
    ahead = min((_refined(level, f) for f in nearest), key=lambda f: f.criterion)
    return Candidate((*best.suspects, suspect), ahead, prior, doubt(level, ahead, best.fit, best.out))


def from_twin(
    level: Level, best: Candidate, suspect: Suspect, found: Candidate | None, twin: Candidate | None
) -> Candidate | None:
    """What was found of a suspect, or, if that comes closer, what a fit gives from where its ``twin`` ended, of which
    it is a wider form: from starts of its own it may end further off than that."""
    if found is None or twin is None:
        return found
    additions = suspect.additions(level.scales, suspect.starts(level.scales)[0])
    return _closer(level, best, found, twin, _as_addend(best, twin, additions))


def widened(level: Level, best: Candidate, suspect: Suspect, found: Candidate | None) -> Candidate | None:
    """What was found of a suspect, or, while it leaves more than noise, its wider forms from there where they come
    closer: each judged at the memory of what the one before it leaves. At that of what stands, which swings for long,
    thousands of samples may count as nine, and nothing would be worth a number more."""
    ahead, in_vain = found, 0
    for wider in suspect.wider:
        if ahead is None or ahead.fit.misfit <= LEFT_BY_CHANCE or in_vain == IN_VAIN:
            break
        last = ahead.fit.addends[-1]
        inner = next((f"{last.prefix}.{a.name}" for a in last.additions if a.inner), "")
        memory = min(residual_memory(ahead.fit.solution), best.fit.memory)
        before = ahead = _settled(level, best, replace(ahead, fit=at_memory(ahead.fit, memory)))
        if ahead.fit.misfit > LEFT_BY_CHANCE:
            form = wider if isinstance(wider, int) else wider(level.scales, ahead.fit.values.get(inner, 0.0))
            ahead = _closer(level, best, before, before, _as_addend(best, before, form))
        in_vain = in_vain + 1 if ahead is before else 0
    if found is None or ahead is None or ahead.fit.solution is found.fit.solution:
        return found
    return replace(ahead, fit=at_memory(ahead.fit, best.fit.memory))


def _settled(level: Level, best: Candidate, found: Candidate) -> Candidate:
    """What was found, fitted once more at the memory at which it is valued: at that of what stands priors held it, and
    a tone of one size seemed to change."""
    own = at_own(replace(level, shared_water=found.fit.shared_water), found)
    return found if own is found else replace(own, out=doubt(level, own.fit, best.fit, best.out))


def anew(level: Level, best: Candidate, found: Candidate) -> Candidate:
    """What was found of a law, or the same from its starts in growing windows with everything else free, where that
    comes closer: what stands makes good for a strong law that it lacks, and from there a fit may end beside it."""
    level, suspect = replace(level, shared_water=found.fit.shared_water), found.suspects[-1]
    starts = suspect.starts(level.scales)[:REFINED]
    fit = _nearer(*(_in_windows(level, best, suspect, start) for start in starts))
    fit = None if fit is None else _refined(level, fit)
    if fit is None or fit.criterion >= found.fit.criterion - SAME_END:
        return found
    return replace(found, fit=fit, out=doubt(level, fit, best.fit, best.out))


def _as_addend(best: Candidate, start: Candidate, form: tuple[Addition, ...] | int) -> Addend | None:
    """The last effect of where a fit starts, in another form beside what stands: with these unknowns (if any), or a
    drift of that degree."""
    last = replace(start.fit.addends[-1], centres=())
    if isinstance(form, int):
        return replace(last, degree=form)
    return replace(last, additions=renumbered(form, best.fit.addends)) if form else None


def _closer(level: Level, best: Candidate, found: Candidate, start: Candidate, addend: Addend | None) -> Candidate:
    """What was found, or the same with this last effect (if any), from where ``start`` ended and at the noise that it
    leaves, if that comes closer: at the noise of what stands, a thousand times that, priors would lead away."""
    level = replace(level, shared_water=start.fit.shared_water)
    stands = replace(best, fit=replace(best.fit, memory=found.fit.memory, misfit=start.fit.misfit))
    fit = None if addend is None else _with(level, stands, (addend,), start.fit.values, growing=False)
    if fit is None or fit.criterion >= found.fit.criterion:
        return found
    fit = _refined(level, fit)
    return replace(found, fit=fit, out=doubt(level, fit, best.fit, best.out))


def from_pair(
    level: Level, null: Candidate, alone: Sequence[Candidate], suspects: tuple[Suspect, Suspect],
    additions: Sequence[tuple[Addition, ...]], prior: float, budget: float,
) -> list[Candidate]:
    """The equation with two suspects at once, from where one step in both leads; one whose fits begin at starts of its
    own beside the other as fitted ``alone``. Nothing without a motion, or where it takes more than its budget."""
    level = replace(level, shared_water=null.fit.shared_water)
    one = Addend(suspects[0].name, additions[0])
    other = Addend(_prefix(suspects[:1], suspects[1]), renumbered(additions[1], (*null.fit.addends, one)))
    first, second = sorted(zip(suspects, (one, other), strict=True), key=lambda pair: pair[0].look is not None)
    own = second[0].look is not None
    with metered(budget):
        try:
            beside = next((c for c in alone if c.suspects == first[:1]), None) if own else None
            if beside is None:
                fit = _with(level, null, first[1:] if own else (one, other), null.fit.values, growing=False)
                if fit is None:
                    return []
                fit = fit if own else _refined(level, fit)
                beside = Candidate(first[:1] if own else suspects, fit, prior, doubt(level, fit, null.fit))
            found = from_starts(level, beside, second[0], prior) if own else beside
            return [] if found is None else [found]
        except BudgetError:
            return []


def as_radiation(level: Level, candidate: Candidate) -> Candidate:
    """The same model with its last resonator, which hardly rings, as a kernel of damping."""
    fit = candidate.fit
    *others, last = fit.addends
    place = int(last.additions[0].slot[-1])
    mass, frequency, damping = (fit.value(f"{last.prefix}.{a.name}") for a in last.additions[:3])
    kernel = Addend(RADIATION.name, kernel_additions(place, mass, frequency, damping))
    level = replace(level, shared_water=fit.shared_water)
    try:
        fit = fit_joint(level, (*others, kernel), fit.memory, fit.values, fit.misfit, growing=False)
    except IdentificationError:
        return candidate
    said = doubt(level, fit, candidate.fit, candidate.out)
    return Candidate((*candidate.suspects[:-1], RADIATION), fit, candidate.log_prior, said)


def at_own(level: Level, best: Candidate) -> Candidate:
    """What stands fitted once more at the memory at which it is valued: one linear step from it says then what a law
    beside it is worth, and priors weigh as much as they do there."""
    fit = _refined(level, best.fit)
    return replace(best, fit=fit) if fit.criterion < best.fit.criterion + SAME_END else best


def penalty_of(level: Level, fit: JointFit, suspect: Suspect) -> float:
    """What a suspect's unknowns cost beside a fit, in log evidence: half of ln(n_eff) each, and a sensor's wider priors
    or its common error."""
    copies = {"shared": 1, "spring": len(level.members), "trial": level.trials}
    additions = suspect.additions(level.scales, suspect.starts(level.scales)[0])
    each = 0.5 * math.log(max(fit.solution.n_data / fit.memory, 2.0))
    sensors = math.log(widening(suspect.frees)) * level.trials if suspect.frees else 0.0
    return sum(copies[a.scope] for a in additions) * each + (each if suspect.frees in COMMON else sensors)


def _waters(level: Level, best: Candidate, suspect: Suspect) -> tuple[Level, ...]:
    """Levels on which a suspect is tried: what stands decides; damping of each spring's own (waves radiated at its own
    frequency) comes with an added mass of its own too."""
    if suspect.variant == EACH_SPRING:
        return level, replace(level, shared_water=False)
    if best.suspects:
        return (replace(level, shared_water=best.fit.shared_water),)
    return (level,)


def _attempt(level: Level, best: Candidate, suspect: Suspect, start: float, looks: float = 1.0) -> JointFit | None:
    """One fit from one start, at the noise of what stands, in so many times `QUICK_LOOKS`; None where it gives no
    motion.

    What is far from what stands is fitted in growing windows and in one: either can end beside the answer.
    """
    additions = renumbered(suspect.additions(level.scales, start), best.fit.addends)
    addend = Addend(_prefix(best.suspects, suspect), additions, suspect.frees, late=suspect.late)
    known = best.fit.values if best.suspects or not suspect.memory else {}
    new = suspect.memory or suspect.at_the_beginning or not level.shares(best.fit.solution.problem.names)
    ways = (True, False) if new and not best.suspects else (False,)
    return _nearer(*(_with(level, best, (addend,), known, growing, looks) for growing in ways))


def _in_windows(level: Level, best: Candidate, suspect: Suspect, start: float) -> JointFit | None:
    """One fit from a start, everything in growing windows; None where it gives no motion."""
    additions = renumbered(suspect.additions(level.scales, start), best.fit.addends)
    return _with(level, best, (Addend(_prefix(best.suspects, suspect), additions),), {}, growing=True)


def _from_place(level: Level, best: Candidate, suspect: Suspect, place: GridPlace) -> JointFit | None:
    """One fit from a place of the grid, everything else where it stands, or where that lost the way, where the same
    step leads it: a memory takes over half of a spring. None where it gives no motion."""
    addend = Addend(_prefix(best.suspects, suspect), place.additions, suspect.frees)
    growing = level.shared_water != best.fit.shared_water
    fit = _with(level, best, (addend,), best.fit.values, growing)
    if growing or not place.beside.size or not _lost(best, fit):
        return fit
    moved = dict(zip(best.fit.values, place.beside.tolist(), strict=True))
    return _nearer(fit, _with(level, best, (addend,), moved, growing))


def _from_look(level: Level, best: Candidate, suspect: Suspect, place: GridPlace) -> JointFit | None:
    """One fit from where one linear step leads a law that was looked for at a small size with which what it has inside
    goes (a hysteresis that yields at one displacement), everything else where it stands; None without a motion."""
    size = place.additions[0]
    found = suspect.additions(level.scales, size.also[0][1])
    found = tuple(replace(a, start=max(a.start * size.start / found[0].start, a.lower)) for a in found)
    return _with(level, best, (Addend(_prefix(best.suspects, suspect), found),), best.fit.values, growing=False)


def _lost(best: Candidate, fit: JointFit | None) -> bool:
    """Whether a fit with one law more lost the way: it is further off than what stands."""
    return fit is None or fit.misfit > FURTHER_OFF * best.fit.misfit


def _from_nothing(level: Level, best: Candidate, suspect: Suspect, start: float) -> JointFit | None:
    """One fit from a law of no size, everything else where it stands; None where no small one leads to the law."""
    additions = renumbered(suspect.additions(level.scales, start), best.fit.addends)
    if suspect.has_no_zero or not additions or any(a.replaces for a in additions):
        return None
    none = tuple(a if a.inner else replace(a, start=OF_NO_SIZE * a.scale) for a in additions)
    return _with(level, best, (Addend(_prefix(best.suspects, suspect), none),), best.fit.values, growing=False)


def _nearer(*fits: JointFit | None) -> JointFit | None:
    """The fit of the lowest criterion; None where there is none."""
    return min((fit for fit in fits if fit is not None), key=lambda fit: fit.criterion, default=None)


def _half_periods_on(level: Level, best: Candidate, suspect: Suspect, fit: JointFit) -> list[JointFit]:
    """The closest fit to which half a period more, or less, with the coefficient turned, leads step by step, of every
    memory in it that recurs, an earlier one's too: in a slow decay echoes that far apart look much alike, and neither
    one linear step nor a fit without the last law puts them in order. Nothing where none does."""
    level = replace(level, shared_water=fit.shared_water)
    every, found = (*best.suspects, suspect), fit
    for place, one in enumerate(every, start=len(fit.addends) - len(every)):
        for way in (-math.pi / level.scales.slowest, math.pi / level.scales.slowest) if one.recurs else ():
            ahead: JointFit | None = found
            while ahead is not None:
                found, last = ahead, ahead.addends[-1]
                ahead = _with(level, best, (last,), turned(found, found.addends[place], way), growing=False)
                ahead = ahead if ahead is not None and ahead.criterion < found.criterion - SAME_END else None
    return [] if found is fit else [found]


def turned(fit: JointFit, addend: Addend, later_s: float) -> dict[str, float]:
    """A fit's values with a memory so much later, in s, and its coefficients turned."""
    delays = {f"{addend.prefix}.{a.name}" for a in addend.additions if a.unit == "s"}
    return {
        name: value if not name.startswith(f"{addend.prefix}.") else value + later_s if name in delays else -value
        for name, value in fit.values.items()
    }  # fmt: skip


def _with(
    level: Level, best: Candidate, more: tuple[Addend, ...], known: Mapping[str, float], growing: bool,
    looks: float = 1.0,
) -> JointFit | None:
    """A quick fit of what stands with one addend more, or two; None where it gives no motion, or takes so many steps
    that it is no start: of hysteresis that yields at next to nothing, which is dry friction.

    The error that a sensor has in all trials is found with wide priors first, then each trial's own about it; a drift
    may be every trial's own.
    """
    with metered(looks * QUICK_LOOKS * one_look(best.fit)) as meter:
        try:
            fit = fit_joint(level, (*best.fit.addends, *more), best.fit.memory, known, best.fit.misfit, growing, True)
            addend = more[-1]
            if not addend.frees or (level.trials == 1 and addend.frees not in COMMON):
                return fit
            mine = addend.freed([*fit.values])
            alike = ([fit.values[n] for n in mine if mine[n] == d] for d in range(1, max(mine.values()) + 1))
            addend = replace(addend, centres=tuple(float(np.mean(values)) for values in alike))
            common = fit_joint(level, (*best.fit.addends, addend), fit.memory, fit.values, fit.misfit, False, True)
            return common if addend.frees in COMMON else _nearer(fit, common)
        except IdentificationError:
            return None
        except BudgetError as out:
            if out.meter is not meter:
                raise
            return None


def _apart(fits: Sequence[JointFit]) -> list[JointFit]:
    """Quick fits without those that ended where an earlier one did: all would be followed to the same end."""
    found: list[JointFit] = []
    for fit in fits:
        if not any(fit.shared_water == f.shared_water and abs(fit.criterion - f.criterion) < SAME_END for f in found):
            found.append(fit)
    return found


def _refined(level: Level, fit: JointFit) -> JointFit:
    """The same model refitted from where it is until its noise is its own; as it is where no motion comes of that."""
    level = replace(level, shared_water=fit.shared_water)
    try:
        return fit_joint(level, fit.addends, fit.memory, fit.values, fit.misfit, growing=False)
    except IdentificationError:
        return fit


def _prefix(before: Sequence[Suspect], suspect: Suspect) -> str:
    number = sum(one.name == suspect.name for one in before) + 1
    return suspect.name if number == 1 else f"{suspect.name}#{number}"
