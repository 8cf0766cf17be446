"""Whether a verdict is earned: what is lacking for an answer turns it into ``cannot_tell``, with the reason.

Green (``nothing_missing``) is said after a search that ended, on channels that agree, where somebody measured or stated
how much trials differ. An effect is named only if it would also be named with twice a scatter that was assumed.

Belongs here: what becomes of a verdict that is barred. Does not belong here: the conditions (decision.py), the search
(search.py), words of effects (sentence.py).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from dataclasses import replace

from undertow.comparison.candidate import NAMING_PROBABILITY, RIVAL_ODDS, Candidate, LevelDiagnosis
from undertow.comparison.explained import beyond_doubt, biases
from undertow.comparison.joint import fit_joint, free_run_error
from undertow.comparison.level import Level, Member
from undertow.comparison.limits import WORTH
from undertow.comparison.null_test import NullTest, SuspectTest
from undertow.comparison.sizes import COUNTS_IN_REPEATABILITY
from undertow.discrepancy.case import Case
from undertow.discrepancy.decision import DOUBLED, NAMED, NO_ANSWER, gates, indistinct
from undertow.discrepancy.dry_check import DryAnswer
from undertow.discrepancy.naming import in_words, next_test
from undertow.discrepancy.sentence import no_answer, not_all
from undertow.discrepancy.validation import NEAR, Closeness
from undertow.discrepancy.verdict import LEFT, Gate, Status, Verdict
from undertow.discrepancy.words import percent, rarely, spelled
from undertow.equation import registry
from undertow.errors import IdentificationError

NEXT: Mapping[str, str] = {
    "contradiction": "correct unit, sign or column of the channels in the config, or state recordings.accept",
    "conditions": "correct that number or unit in the config, or list conditions in recordings.accept",
    "ordered": "the first releases once more at the end of the series, with what may have changed noted beside each",
    "alone": "the group again without that trial: what the others show",
    "no_dry": "three releases of this spring in air, with the body's mass or the spring's stiffness in the config",
    "assumed": "three releases in air, or three of the same size in this water, or state specimen.scatter",
    "wide": "releases that differ less, or trials.window over fewer swings: what k differs by grows with every swing",
    "more": "more releases of this spring in this water, and larger ones",
    "unseen": "more releases: what these trials show does not carry over to the ones held out",
    "further": "more releases of different size in this water, from before the release until after rest",
    "outweighed": "more releases of different size in this water, recorded from before the release until after rest",
    "beside": "more releases of different size in this water: something beside what is named is not known yet",
    "distinct": "more releases of different size in this water, three of them of the same size",
    "described": "three releases of the same size in this water, one of them held out",
    "unnamed": "more releases of different size in this water, recorded from before the release until after rest",
    "dry": "more releases of different size in this water, some from rest to rest, and the same in air once more",
    "structure": "more dry releases of different size, some from rest to rest: what the structure lacks comes first",
    "search": "look at the trials that could not be fitted; a start or a window in the config may help",
}
"""What would lead to an answer, by what is lacking."""

_IN_WATER = " in this water"
_ELSEWHERE: Mapping[str, str] = {"assumed": "three releases of the same size, or state specimen.scatter"}
"""The same in air, and where nobody knows of water, if more than the water goes."""

MAY_COUNT = "; whether it is small these data do not tell."

NO_ANSWER_BUT = ("unseen", "further", "outweighed", "beside", "distinct", "described", "dry", "structure")
"""What is lacking where names are kept and what is missing is unknown."""


def earned(
    verdict: Verdict,
    case: Case,
    diagnosis: LevelDiagnosis,
    tested: NullTest,
    holds_doubled: bool,
    in_air: DryAnswer = NO_ANSWER,
    reach: Closeness = NEAR,
) -> Verdict:
    """The verdict itself, ``cannot_tell`` with what is lacking, or ``present_but_small``: the first of its `gates` that
    is not passed and bars its status decides. With what would lead on, also where nobody knows what is there."""
    decision = gates(verdict, case, diagnosis, tested, holds_doubled, in_air, reach)
    said = _by_its_gates(replace(verdict, decision=decision), case, diagnosis, tested, in_air)
    if said.next_test or not said.verdict:
        return said
    return replace(said, next_test=next_test(said.verdict[0]) or _next("unnamed", case))


def _by_its_gates(
    verdict: Verdict, case: Case, diagnosis: LevelDiagnosis, tested: NullTest, in_air: DryAnswer
) -> Verdict:
    """What becomes of a verdict that has its `gates`."""
    for gate in verdict.decision:
        if gate.passed or verdict.status not in gate.bars:
            continue
        if gate.lacking in ("small", "stands_out") and diagnosis.small is not None:
            return _small(verdict, case, diagnosis, diagnosis.small, in_air, tested)
        if gate.lacking == "left":
            return _left(verdict, case, gate)
        if gate.lacking == "stands_out":
            return _standing_out(verdict, case, diagnosis, tested, in_air)
        if gate.lacking in NO_ANSWER_BUT and verdict.status != "nothing_missing":
            not_distinct = any(g.gate == "distinct" and not g.passed for g in verdict.decision)
            vague = indistinct(diagnosis) if not_distinct else ()
            return _not_the_answer(verdict, case, gate, vague)
        said = without_answer(verdict, case, gate.because, gate.lacking)
        return replace(said, contradicted=bool(case.contradiction))
    if verdict.status == "explained" and not diagnosis.named and tested.significant:
        return _with_something_small(verdict, diagnosis, tested)
    if verdict.status in NAMED and in_air.because:
        alike = [law.looks_like for law in map(registry.row, verdict.verdict) if law is not None and law.looks_like]
        beside = f" In water {alike[0]} looks much like it, and is no law of this search." if alike else ""
        return replace(verdict, sentence=f"{verdict.sentence} It is there in water alone: {in_air.because}.{beside}")
    return verdict


def stands_in_water(verdict: Verdict) -> bool:
    """Whether a dry group's names leave no more than noise and nothing speaks against them but a few unseen trials,
    which the equation alone met by chance: in water the same names have other trials to prove them."""
    against = (g for g in verdict.decision if g.gate == LEFT or {*NAMED} & {*g.bars})
    failed = {g.gate for g in against if not g.passed}
    return set(verdict.verdict) > {"unknown"} and failed == {"comes_closer"}


def _not_the_answer(verdict: Verdict, case: Case, gate: Gate, vague: Collection[str] = ()) -> Verdict:
    """``unknown`` after the names but those that are ``vague``: what was excluded explains far more, nothing proves
    what leaves more than noise, trials come no closer (no free run is offered then), the dry trials contradict them, or
    lack what nobody knows."""
    text = no_answer(case.label, verdict.sentence, gate.because)
    if gate.lacking == "unseen":
        text = f"{verdict.sentence} But this is not proved: {gate.because}."
    elif gate.lacking == "beside":
        text = not_all(verdict.sentence, gate.because)
    said = replace(
        verdict, status="unknown", alternatives=(), origin="undetermined", next_test=_next(gate.lacking, case),
        sentence=text,
    )  # fmt: skip
    if gate.lacking in ("further", "outweighed"):  # describes nothing, or less likely than not: no name
        return replace(said, verdict=("unknown",), parameters={}, augmented=None)
    names = *(name for name in verdict.verdict if name not in (*vague, "unknown")), "unknown"
    if vague and len(names) == 1:
        return replace(said, verdict=names, parameters={}, augmented=None)
    return replace(said, verdict=names, augmented=None if gate.lacking == "unseen" else said.augmented)


def of_several_causes(verdict: Verdict) -> Verdict:
    """``unknown`` in place of a name that is only the shape of what several causes leave: the sentence describes it,
    and its numbers stay."""
    shapes = {name for name in registry.names() if registry.find(name).several_causes}
    said = [name for name in dict.fromkeys(verdict.verdict) if name in shapes]
    rivals = tuple(tuple("unknown" if n in shapes else n for n in names) for names in verdict.alternatives)
    if not said:
        return replace(verdict, alternatives=rivals)
    names = tuple(name for name in verdict.verdict if name not in (*shapes, "unknown"))
    words = " and ".join(in_words(name) for name in said)
    return replace(
        verdict, status="present_but_small" if verdict.status == "present_but_small" else "unknown",
        verdict=(*names, "unknown"), alternatives=rivals, origin="undetermined", next_test=next_test(said[0]),
        sentence=f"{verdict.sentence} That is the shape of {words}; a decay does not tell which: unknown.",
    )  # fmt: skip


def without_answer(verdict: Verdict, case: Case, because: str, lacking: str) -> Verdict:
    """``cannot_tell``: the measured errors stay, what was named does not. ``lacking`` is a key of `NEXT`."""
    missed = f"The equation misses {percent(case.baseline.nrmse)} of the motion ({case.repeats})."
    text = f"{case.label}: cannot tell, because {because}. {missed}"
    return replace(
        verdict, status="cannot_tell", verdict=(), alternatives=(), parameters={}, augmented=None,
        origin="undetermined", transfer={}, next_test=_next(lacking, case), sentence=text, because=because,
    )  # fmt: skip


def _next(lacking: str, case: Case) -> str:
    """What would lead to an answer, without water where the group is not known to be in it."""
    said = NEXT[lacking]
    return said if case.in_water else _ELSEWHERE.get(lacking, said.replace(_IN_WATER, ""))


def _small(
    verdict: Verdict, case: Case, diagnosis: LevelDiagnosis, small: Candidate, in_air: DryAnswer, tested: NullTest
) -> Verdict:
    """``present_but_small``: evidence far beyond doubt for an effect that a free run hardly shows; without a name
    (`_small_names`) it is ``unknown`` where it may count."""
    odds = (small.score - diagnosis.null.score) / math.log(10.0)
    likely = _small_names(diagnosis, small)
    words = ", or ".join(spelled(name) for name in likely[:3])
    name = likely[0] if len(likely) == 1 and not in_air.because else "unknown"
    surely = name != "unknown" or _surely_small(verdict, tested)
    text = (
        f"{case.label}: the equation misses {percent(case.baseline.nrmse)} of the motion "
        f"({case.repeats}), no more than repetitions differ; but evidence of 10^{odds:.0f} to 1 says that "
        f"something{' small' if surely else ''} is there, most probably {words}{_but(in_air)}"
        f"{'.' if surely else MAY_COUNT}"
    )
    status: Status = "present_but_small" if surely else "unknown"
    return replace(verdict, status=status, verdict=(name,), next_test=next_test(likely[0]), sentence=text)


def _small_names(diagnosis: LevelDiagnosis, small: Candidate) -> list[str]:
    """The name of an effect that a free run hardly shows, and all others that were fitted, excluded or not, and are
    nearly as probable; a set that holds it is no other."""
    near = [c for c in diagnosis.candidates if c.suspects and small.score - c.score < math.log(RIVAL_ODDS)]
    other = [c.amounts_to for c in near if not set(small.names) <= set(c.amounts_to)]
    return list(dict.fromkeys((small.names[0], *(" and ".join(names) for names in other))))


def _with_something_small(verdict: Verdict, diagnosis: LevelDiagnosis, tested: NullTest) -> Verdict:
    """What the dry trials need explains what counts in this water, and beside it something small stands out. It is a
    name of the verdict's where evidence is far beyond doubt and no other is nearly as probable: of four sealed
    campaigns (2132001, 2133001) that would have had a name by what stands out most, two would have had a wrong one."""
    small = diagnosis.small
    likely = _standing_names(tested) if small is None else _small_names(diagnosis, small)
    names = verdict.verdict if small is None or len(likely) > 1 else tuple(dict.fromkeys((*verdict.verdict, *likely)))
    words = ", or ".join(spelled(name) for name in likely[:3])
    text = (
        f"{verdict.sentence} Beside it something small stands out, as {rarely(tested.p_value)} of such levels with "
        f"nothing beside it do: most like {words}."
    )
    return replace(verdict, verdict=names, sentence=text)


def _surely_small(verdict: Verdict, tested: NullTest) -> bool:
    """Whether what has no name is small: none of what stands out nearly as much as the first would count, and nothing
    that would could hide. Of 59 groups of sealed campaigns (2122001, 2128001) of which this was not asked 23 had an
    effect that counts, of eleven where more could hide seven."""
    return not _more_could_hide(verdict) and all(t.size < 1.0 for t in _near(tested))


def _more_could_hide(verdict: Verdict) -> bool:
    """Whether something as large as what counts could hide."""
    return any(gate.gate == "upper_bound" and not gate.passed for gate in verdict.decision)


def _near(tested: NullTest) -> tuple[SuspectTest, ...]:
    """The suspects that stand out nearly as much as the first, which is one of them; none where none was tested."""
    return tuple(t for t in tested.tests if t is tested.tests[0] or t.p_value < tested.tests[0].p_value * RIVAL_ODDS)


def _left(verdict: Verdict, case: Case, gate: Gate) -> Verdict:
    """``unknown``, or ``present_but_small`` where what is left is under half of repeatability, and no more could hide:
    something is there that no suspect explains."""
    small = gate.value < COUNTS_IN_REPEATABILITY * case.allowed and not _more_could_hide(verdict)
    status: Status = "present_but_small" if small else "unknown"
    text = (
        f"{case.label}: the equation misses {percent(case.baseline.nrmse)} of the motion "
        f"({case.repeats}), no more than repetitions differ; but {gate.because}: something is there, and no "
        "suspect explains it."
    )
    return replace(verdict, status=status, verdict=("unknown",), sentence=text)


def _but(in_air: DryAnswer) -> str:
    """Why the most probable name is not said."""
    return f"; but {in_air.because}, so that it is something that looks like it" if in_air.because else ""


def _standing_out(
    verdict: Verdict, case: Case, diagnosis: LevelDiagnosis, tested: NullTest, in_air: DryAnswer
) -> Verdict:
    """``present_but_small`` or, where it would count, ``unknown``: no free run shows it, but hardly any level with
    nothing missing stands out as much. It has a name where no other suspect stands out nearly as much and the numbers
    of its fit mean something."""
    likely = _standing_names(tested)
    words = ", ".join(spelled(name) for name in likely[:3])
    sound = any(c.names == (likely[0],) and (c.aside or not c.out) for c in diagnosis.candidates)
    named = tested.tests[0].size < 1.0 and sound and len(likely) == 1 and not in_air.because
    small = named or _surely_small(verdict, tested)
    text = (
        f"{case.label}: the equation misses {percent(case.baseline.nrmse)} of the motion "
        f"({case.repeats}), no more than repetitions differ; but of levels like this with nothing missing "
        f"{rarely(tested.p_value)} stand out as much: something is there, most like {words}{_but(in_air)}"
        f"{'.' if small else MAY_COUNT}"
    )
    name = likely[0] if named else "unknown"
    status: Status = "present_but_small" if small else "unknown"
    return replace(verdict, status=status, verdict=(name,), next_test=next_test(likely[0]), sentence=text)


def _standing_names(tested: NullTest) -> list[str]:
    """Names of the suspects that stand out nearly as much as the first, which is one of them."""
    return list(dict.fromkeys(t.name for t in _near(tested)))


def holds_with_twice_the_scatter(level: Level, diagnosis: LevelDiagnosis) -> bool:
    """Whether what is named would be named if trials differed by twice as much as was assumed.

    The prescribed equation and the answer are fitted again; no other suspect is.
    """
    wider = replace(level, members=tuple(_doubled(member) for member in level.members))
    fits = []
    for one in (diagnosis.null, diagnosis.best):
        fit = one.fit
        try:
            at = replace(wider, shared_water=fit.shared_water)
            again = fit_joint(at, fit.addends, fit.memory, fit.values, fit.misfit, growing=False)
        except IdentificationError:
            return False
        fits.append(replace(one, fit=again))
    null, best = fits
    before, after = (free_run_error(wider, one.fit) for one in fits)
    odds = math.log(NAMING_PROBABILITY / (1.0 - NAMING_PROBABILITY))
    closer = before > after and math.sqrt(before**2 - after**2) > WORTH
    shown = closer or not best.suspects[-1].shown_by_free_run or beyond_doubt(null, best) or biases(null, best)
    return best.score > null.score + odds and shown


def _doubled(member: Member) -> Member:
    """A group whose trials differ by twice as much."""
    model, fixed = member.model, member.model.fixed
    if fixed is not None:
        scatter = {symbol: DOUBLED * value for symbol, value in fixed.scatter.items()}
        model = replace(model, fixed=replace(fixed, scatter=scatter))
    spread = {slot: DOUBLED * value for slot, value in member.spread.items()}
    return replace(member, model=model, allowed=DOUBLED * member.allowed, spread=spread)
