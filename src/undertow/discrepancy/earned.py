"""Whether a verdict is earned: what is lacking for an answer turns it into ``cannot_tell``, with the reason.

Green (``nothing_missing``) is said after a search that ended, on channels that agree, where somebody measured or stated
how much trials differ. An effect is named only if it would also be named with twice a scatter that was assumed.

Belongs here: those conditions. Does not belong here: the search (search.py), words of effects (sentence.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

from undertow.comparison.candidate import Candidate, Diagnosis
from undertow.comparison.joint import fit_joint, free_run_error
from undertow.comparison.level import Level, Member
from undertow.comparison.search import ACCUSE_PROBABILITY, WORTH, beyond_doubt
from undertow.discrepancy.case import Case
from undertow.discrepancy.verdict import Verdict
from undertow.discrepancy.words import percent
from undertow.errors import IdentificationError

DOUBLED = 2.0
"""An assumed scatter may be wrong by this factor."""

WORSE = 1.2
"""What is named is not proved where the error of trials that it never saw rises by this factor."""

NEXT: Mapping[str, str] = {
    "contradiction": "correct unit, sign or column of the channels in the config, or state recordings.accept",
    "conditions": "correct that number or unit in the config, or list conditions in recordings.accept",
    "no_dry": "three releases of this spring in air",
    "assumed": "three releases in air, or three of the same size in this water, or state specimen.scatter",
    "unseen": "more releases: what these trials show does not carry over to the ones held out",
    "search": "look at the trials that could not be fitted; a start or a window in the config may help",
}
"""What would lead to an answer, by what is lacking."""


def earned(verdict: Verdict, case: Case, diagnosis: Diagnosis, holds_doubled: bool) -> Verdict:
    """The verdict itself, or ``cannot_tell`` with what is lacking, or ``present_but_small``.

    ``holds_doubled`` says whether what is named would be named with twice the scatter, where that was assumed.
    """
    if case.contradiction:
        return replace(without_answer(verdict, case, case.contradiction, "contradiction"), contradicted=True)
    if verdict.status == "nothing_missing":
        if diagnosis.looked == 0:
            return without_answer(verdict, case, "discrepancy.suspects names none: nothing was looked for", "search")
        if diagnosis.unfinished:
            left = ", ".join(label.replace("_", " ") for label in diagnosis.unfinished)
            return without_answer(verdict, case, f"not tried to the end within discrepancy.budget: {left}", "search")
        if case.no_dry:
            return without_answer(verdict, case, case.no_dry, "no_dry")
        if case.assumed:
            return without_answer(verdict, case, case.assumed, "assumed")
        return verdict if diagnosis.small is None else _small(verdict, case, diagnosis.small, diagnosis.null)
    if verdict.status == "explained" and diagnosis.accused and verdict.augmented is not None:
        before, after = case.baseline.held_out_nrmse, verdict.augmented.held_out_nrmse
        if after > WORSE * before:
            names = " and ".join(name.replace("_", " ") for name in diagnosis.best.names)
            rose = f"the trials it never saw went from {percent(before)} to {percent(after)}"
            said = f"{names} would be named, but {rose}"
            return without_answer(verdict, case, said, "unseen")
    if case.assumed and len(case.trials) > 1:
        within = verdict.verdict == ("unknown",) and case.baseline.nrmse <= DOUBLED * case.allowed
        named = set(verdict.verdict) - {"unknown"}
        if within or (named and diagnosis.accused and not holds_doubled):
            said = f"{case.assumed}, and with twice that nothing would be said"
            return without_answer(verdict, case, said, "assumed")
    return verdict


def without_answer(verdict: Verdict, case: Case, because: str, lacking: str) -> Verdict:
    """``cannot_tell``: the measured errors stay, what was named does not. ``lacking`` is a key of `NEXT`."""
    size, allowed = percent(case.baseline.nrmse), percent(case.allowed)
    limit = f"repeatability {allowed}{', assumed' if case.assumed else ''}"
    text = f"{case.label}: cannot tell, because {because}. The equation misses {size} of the motion ({limit})."
    return replace(
        verdict, status="cannot_tell", verdict=(), alternatives=(), parameters={}, augmented=None, confidence=math.nan,
        origin="undetermined", transfer={}, next_test=NEXT[lacking], sentence=text, because=because,
    )  # fmt: skip


def _small(verdict: Verdict, case: Case, small: Candidate, null: Candidate) -> Verdict:
    """``present_but_small``: evidence far beyond doubt for an effect that a free run hardly shows."""
    name = small.names[0]
    odds = (small.score - null.score) / math.log(10.0)
    text = (
        f"{case.label}: the equation misses {percent(case.baseline.nrmse)} of the motion (repeatability "
        f"{percent(case.allowed)}), no more than repetitions differ; but evidence of 10^{odds:.0f} to 1 says that "
        f"something small is there, most probably {name.replace('_', ' ')}."
    )
    return replace(verdict, status="present_but_small", verdict=(name,), sentence=text, confidence=math.nan)


def holds_with_twice_the_scatter(level: Level, diagnosis: Diagnosis) -> bool:
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
    odds = math.log(ACCUSE_PROBABILITY / (1.0 - ACCUSE_PROBABILITY))
    closer = before > after and math.sqrt(before**2 - after**2) > WORTH
    shown = closer or not best.suspects[-1].shown_by_free_run or beyond_doubt(null, best)
    return best.score > null.score + odds and shown


def _doubled(member: Member) -> Member:
    """A group whose trials differ by twice as much."""
    model, fixed = member.model, member.model.fixed
    if fixed is not None:
        scatter = {symbol: DOUBLED * value for symbol, value in fixed.scatter.items()}
        model = replace(model, fixed=replace(fixed, scatter=scatter))
    return replace(member, model=model, allowed=DOUBLED * member.allowed)
