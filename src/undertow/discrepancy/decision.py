"""Every condition behind a verdict, as a number against a limit: what decides, in one list.

Belongs here: the gates and which statuses each bars. Does not belong here: the search (comparison/search.py), what
becomes of a verdict that is barred (earned.py), words of effects (sentence.py).
"""

from __future__ import annotations

import math

from undertow.comparison.candidate import (
    NAMING_PROBABILITY,
    RIVAL_ODDS,
    Candidate,
    LevelDiagnosis,
    errors_from_zero,
    probability,
)
from undertow.comparison.explained import NEARLY_ALL, explains
from undertow.comparison.joint import free_run_error
from undertow.comparison.level import Level
from undertow.comparison.limits import FAR_ABOVE_NOISE, OVERWHELMING, WORTH
from undertow.comparison.null_test import NullTest
from undertow.comparison.sizes import COUNTS_IN_REPEATABILITY
from undertow.comparison.support import MORE_LIKELY, support
from undertow.comparison.suspects import SUSPECTS
from undertow.discrepancy.alone import one_alone
from undertow.discrepancy.case import Case
from undertow.discrepancy.dry_check import CERTAIN, DryAnswer
from undertow.discrepancy.validation import NEAR, Closeness
from undertow.discrepancy.verdict import LEFT, Gate, Verdict
from undertow.discrepancy.wandering import as_what, left_share, no_physics, wanders
from undertow.discrepancy.words import percent, rarely, spelled

DISTINCT = 2.0
"""Standard errors from zero that a named law must keep where its error counts how much trials differ."""

DOUBLED = 2.0
"""An assumed scatter may be wrong by this factor."""

WORSE_SHARE = 0.02
"""What is named is not proved where it takes unseen trials further away by more than repeating a test does, or by more
than this share of the motion."""

LEFT_SHARE = 0.02
"""What k, c, mu of each trial's own leave of the motion, more than noise, is something that is missing from here on
(the same share by which unseen trials are further away), however much trials differ. Of 156 levels with nothing missing
(seed 2101101) 143 left under 1.3 times the noise (in variance); 13, whose noise is correlated, 2.7 to 4.6 times, all
of which wanders."""

PROVED = 1.5
"""Up to so many times repeatability unseen trials prove a name that leaves more than noise."""


WIDE = 0.3
"""Repeatability above which "nothing is missing" says little: half of it would still not count. Of 300 nulls of the
names study (5032000 on) no group in water has so much, of 192 green groups of sealed campaigns with nothing missing two
(one campaign), of 69 green groups of those with an effect twelve (2128001, the first 135 rows)."""

OF_ITS_OWN = 0.95
"""Share of what the equation's own fit leaves above noise that a description explains where no trial is unseen. Set
on the virtual flume's six releases that `differ` reads and on a disc in air with a linear law."""

NO_ANSWER = DryAnswer()
"""Dry trials that say nothing against what is named."""

GREEN = ("nothing_missing",)
NAMED = ("explained", "not_identifiable")
EVERY = ("nothing_missing", *NAMED, "unknown")


def gates(
    verdict: Verdict, case: Case, diagnosis: LevelDiagnosis, tested: NullTest, holds_doubled: bool,
    in_air: DryAnswer = NO_ANSWER, reach: Closeness = NEAR,
) -> tuple[Gate, ...]:
    """What a verdict must pass to be said, in order: the first that is not passed and bars its status decides.

    ``tested`` is the level beside its own null; ``holds_doubled`` says whether what is named would be named with twice
    the scatter, where that was assumed; ``in_air`` what dry trials say against it, ``reach`` how far it reaches on
    the level.
    """
    left = ", ".join(spelled(label) for label in diagnosis.unfinished)
    unsearched = GREEN if set(verdict.verdict) - {"unknown"} else (*GREEN, "unknown")
    surely = case.baseline.nrmse > DOUBLED * case.allowed  # that something is there
    closer = _comes_closer(verdict, case, diagnosis)
    none = tuple(gate for gate in closer if not gate.passed and gate.lacking == "further")
    found = (
        _flag("channels_agree", "groups of channels that contradict each other", case.contradiction, EVERY,
              "contradiction"),
        Gate("search_ended", "suspects not tried to the end", float(len(diagnosis.unfinished)), 0.0,
             not diagnosis.unfinished, f"not tried to the end within discrepancy.budget: {left}", "search", unsearched)
        if diagnosis.looked else _flag("search_ended", "searches that were not begun",
                                       "discrepancy.suspects names none that these trials could tell: nothing was "
                                       "looked for",
                                       GREEN if surely else unsearched, "search"),
        *_beside_its_null(verdict, case, diagnosis, tested),
        *none,
        _structure(case),
        _flag("scatter_known", "reasons why nobody knows how much trials differ", case.assumed, GREEN, "assumed"),
    )  # fmt: skip
    if verdict.status == "nothing_missing":
        found = (*found, _left_over(case, diagnosis))
    hidden = () if diagnosis.named or not math.isfinite(tested.p_value) else (_upper_bound(case, tested),)
    named = (*(() if none else closer), *_distinct(case, diagnosis), *_outweighed(diagnosis))
    named = (*named, *_described(verdict, case, diagnosis, reach), *_borne_out(verdict, case, diagnosis, in_air))
    return (*found, *hidden, *named, *_with_twice_the_scatter(verdict, case, holds_doubled))


def evidence(level: Level, case: Case, diagnosis: LevelDiagnosis) -> tuple[Gate, ...]:
    """How the answer, or where nothing is named the strongest suspect, stands against the prescribed equation."""
    error = free_run_error(level, diagnosis.null.fit)
    size = case.baseline.nrmse / case.allowed
    said = Gate("free_run", "free-run error over repeatability", size, 1.0, size <= 1.0)
    best = diagnosis.best if diagnosis.named else strongest(diagnosis)
    stands = "+".join(addend.prefix for addend in level.standing)
    left = () if diagnosis.named or not stands else (_left_with(stands, diagnosis.null),)
    if best is None:
        return (said, *left)
    names = "+".join(best.names)
    odds = math.log(NAMING_PROBABILITY / (1.0 - NAMING_PROBABILITY))
    gain = best.score - diagnosis.null.score
    after = free_run_error(level, best.fit)
    closer = math.sqrt(max(error**2 - after**2, 0.0))
    rivals = len(diagnosis.rivals) if diagnosis.named else 0
    return (
        said,
        Gate("evidence", f"log odds of {names} over nothing", gain, odds, gain > odds),
        Gate("numbers", f"reasons why the numbers of {names} mean nothing", float(bool(best.out)), 0.0, not best.out,
             best.out),
        Gate("free_run_closer", f"free run closer with {names}, in repeatabilities", closer, WORTH, closer > WORTH),
        Gate("rivals", f"other sets of names within odds of {RIVAL_ODDS:.0f}", float(rivals), 0.0, not rivals),
        Gate("posterior", f"posterior probability of {names}, excluded candidates included", posterior(diagnosis, best),
             NAMING_PROBABILITY, posterior(diagnosis, best) >= NAMING_PROBABILITY),
        *(left or (_left_with(names, best),)),
    )  # fmt: skip


def _left_with(names: str, one: Candidate) -> Gate:
    """What is left over the noise with what is said, or else with the strongest suspect."""
    left = one.fit.misfit
    statistic = f"mean squared residual over noise with {names}"
    return Gate(LEFT, statistic, left, FAR_ABOVE_NOISE, left <= FAR_ABOVE_NOISE)


def strongest(diagnosis: LevelDiagnosis) -> Candidate | None:
    """The most probable set of suspects that was fitted, excluded or not; None where none was."""
    return max((c for c in diagnosis.candidates if c.suspects), key=lambda c: c.score, default=None)


def posterior(diagnosis: LevelDiagnosis, one: Candidate | None = None) -> float:
    """Posterior probability of a set of names (None: of what is said) among everything fitted, excluded or not."""
    return probability(one or diagnosis.best, diagnosis.candidates, diagnosis.screened, excluded=True)


def _flag(gate: str, statistic: str, reason: str, bars: tuple[str, ...], lacking: str) -> Gate:
    return Gate(gate, statistic, float(bool(reason)), 0.0, not reason, reason, lacking, bars)


def _structure(case: Case) -> Gate:
    """Whether the dry trials tell the structure: none is no green, and what they lack, and nobody knows, is there in
    water too, where any name can be a description of it."""
    bars = GREEN if case.no_dry or not case.dry_unknown else (*GREEN, *NAMED)
    lacking, reason = "no_dry" if case.no_dry else "structure", case.no_dry or case.dry_unknown
    return _flag("structure_known", "reasons why the dry trials do not tell the structure", reason, bars, lacking)


def _without_a_null(diagnosis: LevelDiagnosis) -> Gate:
    """What green needs where no suspect can be held against replicas: no overwhelming evidence for a small effect."""
    small = 0.0 if diagnosis.small is None else diagnosis.small.score - diagnosis.null.score
    statistic = "log10 of the odds for the strongest effect that a free run hardly shows, where no replica can be made"
    value, limit = small / math.log(10.0), OVERWHELMING / math.log(10.0)
    return Gate("p_value", statistic, value, limit, diagnosis.small is None, "", "small", GREEN)


def _beside_its_null(
    verdict: Verdict, case: Case, diagnosis: LevelDiagnosis, tested: NullTest
) -> tuple[Gate, ...]:
    """Whether the level stands out among replicas of itself with nothing missing, as a name needs and green must not:
    how much trials differ, if it was assumed, is as uncertain in the replicas. A bad release is in no replica, and what
    nobody knows is in all of them."""
    if not math.isfinite(tested.p_value):
        return (_without_a_null(diagnosis),)
    p, asked = tested.p_value, "probability that a level with nothing missing stands out as much"
    if verdict.status == "nothing_missing":
        return (Gate("p_value", asked, p, tested.limit, not tested.significant, "", "stands_out", GREEN),)
    if diagnosis.named and _stands_in(diagnosis.best, tested):
        said = f"{percent(p)} of such levels with nothing missing stand out as much{as_what(diagnosis.best)}"
        return (Gate("p_value", asked, p, tested.limit, tested.significant, said, "more", NAMED),)
    if _carried(verdict, diagnosis):
        counts = tested.tests[0].size >= 1.0 or diagnosis.null.fit.misfit > FAR_ABOVE_NOISE
        said = f"of levels like this with nothing beside it {rarely(p)} stand out as much"
        return (Gate("p_value", asked, p, tested.limit, not (tested.significant and counts), said, "beside", NAMED),)
    return (_more_than_noise(case, diagnosis, tested),) if verdict.verdict == ("unknown",) else ()


def _carried(verdict: Verdict, diagnosis: LevelDiagnosis) -> bool:
    """Whether all that is said is what the dry trials need: it stands in the equation that this water is held to."""
    return not diagnosis.named and bool(set(verdict.verdict) - {"unknown"})


def _stands_in(best: Candidate, tested: NullTest) -> bool:
    """Whether the replicas have what is named: all of it, or some of it where it leaves no more than noise."""
    labels, known = {s.label for s in best.suspects}, {t.label for t in tested.tests}
    return labels <= known or bool(labels & known and best.fit.misfit <= FAR_ABOVE_NOISE)


def _more_than_noise(case: Case, diagnosis: LevelDiagnosis, tested: NullTest) -> Gate:
    """Whether there is something that nobody knows: more than noise beside k, c, mu of each trial's own that swings
    with the motion, or a level that stands out among its replicas. Else trials differ by more than is known, or a
    sensor wanders, and that is no missing physics."""
    misfit = diagnosis.null.fit.misfit
    goes_on = misfit > FAR_ABOVE_NOISE and wanders(diagnosis.null.fit)
    because = "nothing stands out, and " + (
        f"what the equation leaves is {no_physics(diagnosis.null.fit)}"
        if goes_on
        else f"{case.own} of each trial's own leave no more than noise: trials may differ by more than is known"
    )
    if goes_on and (one := one_alone(case, diagnosis.null.fit)) is not None:
        because = one.words
    statistic = f"mean squared residual over noise, {case.own} of each trial's own"
    passed = (misfit > FAR_ABOVE_NOISE and not goes_on) or tested.significant
    return Gate("more_than_noise", statistic, misfit, FAR_ABOVE_NOISE, passed, because, "assumed", ("unknown",))


def _left_over(case: Case, diagnosis: LevelDiagnosis) -> Gate:
    """Whether more than noise is left where trials differ so much that a free run hides it, of all trials or of a
    single one: repeatability as wide as half of the motion would call anything small."""
    fit = diagnosis.null.fit
    share = left_share(fit) if fit.misfit > FAR_ABOVE_NOISE else 0.0
    because = (
        f"{case.own} of each trial's own leave {percent(share)} of the motion, {math.sqrt(fit.misfit):.2g} times the "
        f"sensors' noise, and repetitions that differ by {percent(case.allowed)} hide it"
    )
    wandering = share > LEFT_SHARE and wanders(fit)
    because += f"; it is {no_physics(fit)}" if wandering else ""
    lacking = "more" if wandering else "left"
    one = one_alone(case, fit)
    if one is not None and one.share > LEFT_SHARE and not (one.largest and lacking == "left" and share > LEFT_SHARE):
        share, lacking, because = one.share, "alone", one.words
    statistic = f"share of the motion left, {case.own} of each trial's own, where that is more than noise"
    return Gate("nothing_left", statistic, share, LEFT_SHARE, share <= LEFT_SHARE, because, lacking, GREEN)


def _upper_bound(case: Case, tested: NullTest) -> Gate:
    """Whether something as large as what counts could hide, also among repetitions that differ by too much."""
    statistic = "largest free-run error that an effect of all trials, or what trials differ by, can hide"
    if case.allowed > WIDE:
        because = (
            f"repetitions differ by more than {percent(WIDE)} of the motion: an effect of half as much could hide in "
            "that"
        )
        hides = max(COUNTS_IN_REPEATABILITY * case.allowed, tested.upper_bound)
        return Gate("upper_bound", statistic, hides, COUNTS_IN_REPEATABILITY * WIDE, False, because, "wide", GREEN)
    hides, limit = tested.upper_bound, tested.smallest
    because = (
        f"{spelled(tested.hides_best)} beside what the equation has could hide in it and move the free run by "
        f"{percent(hides)}, more than half of repeatability ({percent(limit)})"
    )
    lacking = "more" if case.dry or case.has_dry else "no_dry"  # more trials in water alone show damping no better
    return Gate("upper_bound", statistic, hides, limit, not hides > limit, because, lacking, GREEN)


def _comes_closer(verdict: Verdict, case: Case, diagnosis: LevelDiagnosis) -> tuple[Gate, ...]:
    """Whether what is named carries over to the trials that it never saw, and describes those that it was fitted to: a
    description with which they are further away than without is none, also beside what is unknown; a name that leaves
    no more than noise of them stays beside it. Of an accelerometer no free run of the displacement says anything."""
    named = [spelled(name) for name in dict.fromkeys(verdict.verdict) if name != "unknown"]
    beside = {"unknown", *(s.name for s in SUSPECTS if s.frees.startswith("acceleration"))}
    if {*verdict.verdict} <= beside or verdict.augmented is None:
        return ()
    names, own, unseen = " and ".join(named), case.baseline.nrmse, case.baseline.held_out_nrmse
    statistic = f"free run further away, unseen trials in repeatabilities, any in {percent(WORSE_SHARE)} of the motion"

    def gate(away: float, because: str, lacking: str, bars: tuple[str, ...]) -> Gate:
        return Gate("comes_closer", statistic, away, 1.0, away <= 1.0, because, lacking, bars)

    went = f"with {names} the trials it was fitted to go from {percent(own)} to {percent(verdict.augmented.nrmse)}"
    further = (verdict.augmented.nrmse - own) / WORSE_SHARE
    lacking = "unseen" if diagnosis.best.fit.misfit <= FAR_ABOVE_NOISE else "further"  # with what the dry trials need
    found = [gate(further, went, lacking, EVERY)] if math.isfinite(further) else []
    after = verdict.augmented.held_out_nrmse
    if diagnosis.named and math.isfinite(unseen) and math.isfinite(after) and unseen > 0.0:
        away = max(math.sqrt(max(after**2 - unseen**2, 0.0)) / case.allowed, (after - unseen) / WORSE_SHARE)
        rose = f"{names} would be named, but the trials it never saw went from {percent(unseen)} to {percent(after)}"
        found.append(gate(away, rose, "unseen", (*NAMED, "unknown")))
    return tuple([g for g in found if not g.passed][:1] or sorted(found, key=lambda g: -g.value)[:1])


def indistinct(diagnosis: LevelDiagnosis) -> dict[str, str]:
    """Names of laws that were added and are not distinct from zero, or whose frequency is not, by their errors as
    printed, with what lies how many standard errors away."""
    fit, found = diagnosis.best.fit, {}
    for addend in fit.addends[-len(diagnosis.best.suspects) :]:
        name = addend.prefix.partition("#")[0]
        for what, away in errors_from_zero(fit, addend).items():
            if away < DISTINCT:
                of = f"the {what} of " if what else ""
                found[name] = f"{of}{spelled(name)} lies {away:.2g} standard errors from zero"
    return found


def _distinct(case: Case, diagnosis: LevelDiagnosis) -> tuple[Gate, ...]:
    """Whether every law that is named is distinct from zero by its error as printed, which counts how much trials
    differ: one that only some of them show is no law of this water. In three campaigns of 1,247 (seeds 2100002,
    2118001, 2120001) one was not, and none of the three was there."""
    if not diagnosis.named or case.member.free_start:  # a free start trades places with a mass
        return ()
    vague = indistinct(diagnosis)
    because = ", ".join(f"{words}, counting how much it moves from trial to trial" for words in vague.values())
    statistic = "laws that are named and not distinct from zero, counting how much trials differ"
    return (Gate("distinct", statistic, float(len(vague)), 0.0, not vague, because, "distinct", (*NAMED, "unknown")),)


def _outweighed(diagnosis: LevelDiagnosis) -> tuple[Gate, ...]:
    """Whether what is said, the answer or one of its rivals, alone or beside more, is more likely than all else that
    was fitted together, what was excluded for its numbers included: else something looks like it that nobody knows.

    A set that holds what is said does not speak against it, but where it is more probable, and no more than noise is
    left, what is said is not all: something is beside it that nobody knows. (What leaves more is said to be a
    description.) What was set aside because the free run hardly shows it is no better answer than one that it shows."""
    if not diagnosis.named:
        return ()
    found = support(diagnosis)
    exactly = diagnosis.best.fit.misfit <= FAR_ABOVE_NOISE and found.likely >= MORE_LIKELY
    likely, other = (found.exactly, found.rather) if exactly else (found.likely, found.other)
    of_what = "exactly these names, nothing beside them" if exactly else "the names that are said"
    because = spelled(" and ".join(other.names)) or "the equation as it is"
    because += f", excluded because {other.out}" if other.out else ""
    because = f"its probability is {percent(likely)}, and most probable is {because}"
    lacking, passed = "beside" if exactly else "outweighed", likely >= MORE_LIKELY
    statistic = f"probability of {of_what}, excluded candidates included"
    return (Gate("outweighed", statistic, likely, MORE_LIKELY, passed, because, lacking, NAMED),)


def _described(verdict: Verdict, case: Case, diagnosis: LevelDiagnosis, reach: Closeness) -> tuple[Gate, ...]:
    """Whether a name that leaves more than noise is an answer: it is where unseen trials come closer with it, about as
    close as repetitions are, by what was measured of them. Else it describes what is unknown, if the level's own trials
    come so close, or unseen ones show three quarters less of it (in variance), or, where none is unseen, their
    own fit leaves a twentieth: of 18 names with which they came so
    close (seeds 2106001, 2106501, 2107001) 13 were of the effect or described it, of 5 others (one there, four near the
    body's rate, 3981000) none; a slosh mode that no law of ours is halves the error of unseen trials. What the dry
    trials need describes the water's motion too, as far as it goes."""
    carried = _carried(verdict, diagnosis)
    if not (diagnosis.named or carried) or diagnosis.best.fit.misfit <= FAR_ABOVE_NOISE:
        return ()
    describes = explains(diagnosis.null, diagnosis.best, OF_ITS_OWN)
    describes = reach.explained >= NEARLY_ALL if math.isfinite(reach.explained) else describes
    if reach.away > PROVED and not describes and not carried:
        because = f"with it the trials of this water are {reach.away:.2g} times as far away as repetitions are"
        statistic = "free run of the level's trials over repeatability, where more than noise is left"
        return (Gate("described", statistic, reach.away, PROVED, False, because, "outweighed", EVERY[1:]),)
    unseen = reach.unseen  # of a force: all but a size and a phase of thousands of samples is told beforehand
    if not math.isfinite(unseen) and verdict.augmented is not None:
        unseen = verdict.augmented.held_out_nrmse
    measured, closer = math.isfinite(unseen) and not case.assumed, not unseen >= case.baseline.held_out_nrmse
    limit = percent(unseen if closer else case.baseline.held_out_nrmse)
    because = (
        f"unseen trials come no closer than {limit}, where repetitions differ by {percent(case.allowed)}"
        if measured
        else "how much repetitions differ was not measured, beside which alone unseen trials prove it"
        if math.isfinite(unseen)
        else "it has no unseen trial that would prove it"
    )
    proved = measured and closer and unseen <= PROVED * case.allowed
    statistic = "free run of unseen trials over repeatability, where more than noise is left"
    bars = NAMED if measured and not closer else ("explained",)  # rivals beside each other are descriptions all
    return (Gate("described", statistic, unseen / case.allowed, PROVED, proved, because, "described", bars),)


def _borne_out(verdict: Verdict, case: Case, diagnosis: LevelDiagnosis, in_air: DryAnswer) -> tuple[Gate, ...]:
    """Whether dry trials show what is named of the structure too, or it is sure to be the water's: it leaves no more
    than noise, and unseen trials come closer with it, and as close as repetitions are."""
    if not diagnosis.named:
        return ()
    unseen = math.nan if verdict.augmented is None else verdict.augmented.held_out_nrmse
    of_water = diagnosis.best.fit.misfit <= FAR_ABOVE_NOISE and unseen <= case.allowed
    of_water = of_water and unseen < case.baseline.held_out_nrmse
    statistic = "standard errors by which dry trials contradict a law of the structure" + (
        "; met, for unseen trials prove it of the water" if of_water and in_air.because else ""
    )
    bars, passed = NAMED, not in_air.because or of_water
    return (Gate("dry_trials_agree", statistic, in_air.away, CERTAIN, passed, in_air.because, "dry", bars),)


def _with_twice_the_scatter(verdict: Verdict, case: Case, holds_doubled: bool) -> tuple[Gate, ...]:
    """Whether a name, or that something is unknown, would also be said with twice a scatter that was assumed."""
    if not case.assumed or len(case.trials) < 2 or verdict.status == "nothing_missing":
        return ()
    size = case.baseline.nrmse / case.allowed
    within = verdict.verdict == ("unknown",) and size <= DOUBLED
    named = bool(set(verdict.verdict) - {"unknown"})
    said = f"{case.assumed}, and with twice that nothing would be said"
    passed = not within and (not named or holds_doubled)
    return (
        Gate("twice_the_scatter", "free-run error over repeatability, which was assumed", size, DOUBLED, passed, said,
             "assumed", EVERY),
    )  # fmt: skip
