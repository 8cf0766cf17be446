"""From a level's diagnosis to what is said of each of its groups.

Belongs here: status, origin, rivals, rejected suspects, the next test, the sentence. Does not belong here: the search
(search.py) or the proof's numbers (validation.py).
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from undertow.comparison.by_trials import FEWEST_TRIALS, with_errors_by_trials
from undertow.comparison.candidate import LevelDiagnosis, evidence_by_name
from undertow.comparison.common_gains import with_common_gains
from undertow.comparison.deviations import mean_of_own
from undertow.comparison.joining import MOST_EFFECTS, has_room
from undertow.comparison.joint import free_run_error, with_own_errors
from undertow.comparison.level import Addend, Level, Member, full_name, make_level, member_rate
from undertow.comparison.limits import FAR_ABOVE_NOISE
from undertow.comparison.null_test import NullTest, null_test
from undertow.comparison.prescribed import at_its_own_sizes
from undertow.comparison.recurrences import with_errors_by_recurrences
from undertow.comparison.search import diagnose
from undertow.comparison.sizes import COUNTS_IN_STDERR
from undertow.comparison.support import supported
from undertow.comparison.suspect import Origin, Suspect
from undertow.comparison.suspects import SUSPECTS, all_suspects
from undertow.conditioning.motion import Motion
from undertow.discrepancy.calibration import rather_right, record_of
from undertow.discrepancy.case import Case
from undertow.discrepancy.decision import evidence, posterior
from undertow.discrepancy.dry_check import dry_answer
from undertow.discrepancy.earned import earned, holds_with_twice_the_scatter, of_several_causes, without_answer
from undertow.discrepancy.findings import AugmentedRun
from undertow.discrepancy.left_out import LeftOut, left_out
from undertow.discrepancy.naming import deciding_test, number_words, other_sets
from undertow.discrepancy.rejected import rejected_of
from undertow.discrepancy.sentence import (
    THREE_LAWS,
    changing_words,
    late_words,
    left_out_words,
    sentence_of,
    transfer_words,
)
from undertow.discrepancy.transfer import from_other_springs
from undertow.discrepancy.validation import (
    addition_parameters,
    check_cell,
    error_of,
    learned_structure,
    reach,
    shared_run,
)
from undertow.discrepancy.verdict import Described, PhysicalCheck, Status, Verdict
from undertow.discrepancy.words import percent
from undertow.likelihood.free_run import FreeRun, error_as_measured
from undertow.likelihood.scale import with_scale_error
from undertow.quantities import Estimate

STILL_MISSING = 2.0
"""With the addition the free run may be this many times repeatability away before the rest is called unknown too."""

UNPROVED = 1.5
"""Unseen trials that come no closer, and are this many times repeatability away, say that something else is missing:
one of them alone lies outside repeatability once in twenty."""

NOT_TESTABLE = ("rest_offset", "support_compliance")
"""What a free decay cannot show: a resting place off zero lies within what friction holds, and a support that gives is
part of the spring."""


@dataclass(frozen=True)
class Judged:
    """Verdicts of one level's groups, what was added to its equation (nothing where nothing is named), by trial the
    free run with all that is named, and log posteriors of single laws by name."""

    verdicts: tuple[Verdict, ...]
    labels: tuple[str, ...]
    addends: tuple[Addend, ...] = ()
    values: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    runs: Mapping[str, AugmentedRun] = field(default_factory=dict)
    evidence: Mapping[str, float] = field(default_factory=dict)


def judge(cases: Sequence[Case], suspects: Sequence[Suspect], standing: Sequence[Addend] = ()) -> tuple[Verdict, ...]:
    """A verdict for each group of one level; ``standing`` is what is missing in the dry trials already."""
    return judge_level(cases, suspects, standing).verdicts


def judge_level(
    cases: Sequence[Case], suspects: Sequence[Suspect], standing: Sequence[Addend] = (), budget: float = 1.0,
    levels: int = 1, dry: Sequence[Case] = (), told: Mapping[str, float] | None = None,
) -> Judged:
    """As `judge`, with what was added: what dry trials need, their wet groups need too. ``budget`` as in `diagnose`,
    ``levels`` of how many of the campaign this is one: each may stand out by chance; ``dry`` are the campaign's dry
    groups to whose equation nothing was added, ``told`` what other waters say of laws (`joining`)."""
    level = at_its_own_sizes(make_level([_member(c) for c in cases], standing))
    clean = all(c.has_dry and not c.dry for c in cases) and not standing
    diagnosis = supported(diagnose(level, suspects, clean, budget, told))
    tested = null_test(level, suspects, diagnosis.null.fit, diagnosis.candidates, levels, diagnosis.looks)
    moved = ({},) * len(cases) if not diagnosis.named else from_other_springs(
        level, diagnosis.best.fit, [(*c.member.motions, *c.held) for c in cases]
    )  # fmt: skip
    runs = {name: run for case in cases for name, run in _runs(level, case, diagnosis).items()}
    asked = diagnosis.named and any(case.assumed for case in cases)
    doubled = holds_with_twice_the_scatter(level, diagnosis) if asked else True
    springs, likely = {one.member.label for one in cases}, tested.tests[0].name if tested.tests else ""
    in_air = dry_answer(diagnosis, likely, [c for c in dry if clean and c.member.label in springs])
    fit = with_common_gains(with_own_errors(level, diagnosis.best.fit))
    fit = with_errors_by_trials(with_errors_by_recurrences(level, fit, diagnosis.best.suspects))
    diagnosis = replace(diagnosis, best=replace(diagnosis.best, fit=fit))
    forced = any(addend.has_its_own_clock for addend in fit.addends)
    folds = zip(cases, moved, left_out(level, cases, diagnosis), strict=True)
    said = (_verdict(level, case, diagnosis, to, runs, apart) for case, to, apart in folds)
    answers = [
        of_several_causes(earned(verdict, case, diagnosis, tested, doubled, in_air, reach(cases, case, runs, forced)))
        for verdict, case in zip(said, cases, strict=True)
    ]
    verdicts = tuple(_with_evidence(level, *pair, diagnosis, tested) for pair in zip(answers, cases, strict=True))
    labels = tuple(c.member.label for c in cases)
    if not any(set(diagnosis.best.names) <= set(answer.verdict) for answer in answers if diagnosis.named):
        # what is not said does not stand in water
        return Judged(verdicts, labels, runs=runs, evidence=evidence_by_name(diagnosis))
    errors = {n: fit.solution.stderr(n) for n in fit.solution.problem.names}
    numbers = {n: (v, errors[n]) for n, v in fit.values.items() if "." in n}
    return Judged(verdicts, labels, fit.addends, numbers, runs, evidence_by_name(diagnosis))


def _with_evidence(level: Level, verdict: Verdict, case: Case, diagnosis: LevelDiagnosis, tested: NullTest) -> Verdict:
    """A verdict with the numbers behind it: how often such a verdict holds, its posterior probability, the evidence
    before its other gates, and what the level's own null says."""
    verdict = rather_right(replace(verdict, decision=(*evidence(level, case, diagnosis), *verdict.decision)))
    record = record_of(verdict)
    return replace(
        verdict, posterior=posterior(diagnosis), confidence=record.probability if record else math.nan,
        p_value=tested.p_value, upper_bound=math.nan if diagnosis.named else tested.upper_bound,
        detectable=tuple(replace(one, unit=_unit(one.unit, case)) for one in tested.detectable),
        not_testable=(*NOT_TESTABLE, *_of_more_springs(level, case, diagnosis), *tested.not_testable),
        null=tested.scores,
    )  # fmt: skip


def _of_more_springs(level: Level, case: Case, diagnosis: LevelDiagnosis) -> tuple[str, ...]:
    """What water can do and only more springs than these would show: each may have an added mass of its own."""
    asked = (s for s in all_suspects() if s.told_by_springs)
    return tuple(s.name for s in asked if case.in_water and not has_room(level, s, diagnosis.null.fit))


def undecided(cases: Sequence[Case], reason: str) -> Judged:
    """Verdicts of a level whose search could not start or did not end: nobody can tell, and why."""
    verdicts = []
    for case in cases:
        plain = Verdict(
            case.key, case.trials, tuple(m.name for m in case.held), baseline=case.baseline,
            sensor_floor_nrmse=case.floor, repeatability_nrmse=case.allowed,
        )  # fmt: skip
        verdicts.append(without_answer(plain, case, f"no suspect could be tried: {reason}", "search"))
    return Judged(tuple(verdicts), tuple(c.member.label for c in cases))


def _member(case: Case) -> Member:
    """A case's member, its repeatability the case's where the member has none of its own."""
    return case.member if case.member.allowed < 1.0 else replace(case.member, allowed=case.allowed)


def _runs(level: Level, case: Case, diagnosis: LevelDiagnosis) -> dict[str, AugmentedRun]:
    """A case's free runs with what is named; none where nothing is, or where no motion comes of it."""
    if not diagnosis.named and not _known(level, case):
        return {}
    width = case.member.options.rest_offset_std
    fit, member = diagnosis.best.fit, case.member
    motions = {m.name: m for m in (*member.motions, *case.held)}
    runs = {name: shared_run(level, member, fit, m, width) for name, m in motions.items()}
    return {name: _augmented(run, motions[name]) for name, run in runs.items() if run is not None}


def _augmented(run: FreeRun, motion: Motion) -> AugmentedRun:
    """A free run as a figure shows it: nan where it starts later than the recorded motion."""
    samples = int(np.sum(motion.inside))
    residual = np.concatenate([np.full(samples - run.t.size, np.nan), run.residual])
    return AugmentedRun(run.nrmse, residual, error_as_measured(motion, run.theta))


def _verdict(
    level: Level, case: Case, diagnosis: LevelDiagnosis, moved: Mapping[str, float], runs: Mapping[str, AugmentedRun],
    apart: LeftOut,
) -> Verdict:
    plain = Verdict(
        case.key, case.trials, tuple(m.name for m in case.held), baseline=case.baseline,
        sensor_floor_nrmse=case.floor, repeatability_nrmse=case.allowed, rejected=rejected_of(diagnosis),
    )  # fmt: skip
    known = _known(level, case)
    if not diagnosis.named and not known:
        alone = diagnosis.null.fit
        as_scatter = alone.misfit <= FAR_ABOVE_NOISE and case.baseline.nrmse <= case.allowed
        return _without_a_name(plain, case, free_run_error(level, alone) > STILL_MISSING, as_scatter)
    fit, names = diagnosis.best.fit, (*known, *diagnosis.best.names)
    training, held = (error_of(motions, runs) for motions in (case.member.motions, case.held))
    added = [a for addend in fit.addends for a in addend.additions]
    if any(a.differs for a in added):
        held = math.nan  # what is an unseen trial's own, no other trial says
    own = any(a.of_its_own for a in added)
    said = len(case.trials) == 1 and any(map(math.isfinite, moved.values()))  # the same, of the other spring alone
    told = "" if said else left_out_words(apart, len(case.trials), own)
    if own and case.held:
        apart = LeftOut(case.baseline.held_out_nrmse, held)
    found = addition_parameters(fit, case.member.label, member_rate(case.member))
    found = {name: [with_scale_error(_told(one, case), case.specimen) for one in many] for name, many in found.items()}
    of_dry = ((*other, *diagnosis.best.names) for other in case.dry_rivals if known)
    rivals = other_sets(names, (*((*known, *other) for other in diagnosis.rivals), *of_dry))
    status: Status = "not_identifiable" if rivals else "explained"
    rest = training > STILL_MISSING * case.allowed and training > 0.5 * case.baseline.nrmse
    if diagnosis.named:
        rest = rest or held > max(UNPROVED * case.allowed, case.baseline.held_out_nrmse)
    return replace(
        plain,
        status="unknown" if rest else status,
        verdict=(*names, "unknown") if rest else names,
        alternatives=rivals,
        origin=_origin(case, diagnosis.best.suspects, known),
        baseline=replace(case.baseline, cross_validated_nrmse=apart.before),
        parameters={name: many[0] if len(many) == 1 else many for name, many in found.items()},
        augmented=Described(
            training, math.nan if own else held, _all_parameters(case, diagnosis, found),
            _correlations(case, diagnosis), apart.after,
        ),
        physical_check=_physics(case, found),
        next_test=deciding_test(names, rivals),
        transfer=moved,
        sentence=sentence_of(case, names, rivals, found, training, held, rest, known, own, bool(_left(diagnosis, case)))
        + changing_words(fit.addends) + transfer_words(moved) + told
        + (late_words(fit.addends) if len(names) == 1 and not rest else "")
        + (_biased(case, diagnosis) if diagnosis.named else "") + ("" if rest else _left(diagnosis, case)),
    )


def _biased(case: Case, diagnosis: LevelDiagnosis) -> str:
    """Which number of the equation would be wrong without what is named, in words, where that may be why it counts."""
    before, after = diagnosis.null.fit, diagnosis.best.fit
    name, away = after.moved(before)
    if before.misfit > FAR_ABOVE_NOISE or away <= COUNTS_IN_STDERR:
        return ""
    said = number_words(name, case.member.model.coefficients)
    return f" What would be wrong without it: {said}, by {away:.2g} of its standard errors."


def _left(diagnosis: LevelDiagnosis, case: Case) -> str:
    """That what is named describes the motion, in words: it leaves more than noise, or takes three laws; else empty."""
    left = diagnosis.best.fit.misfit
    if left <= FAR_ABOVE_NOISE:
        return THREE_LAWS if len(diagnosis.best.suspects) == MOST_EFFECTS else ""
    several = len(diagnosis.best.fit.solution.problem.trials) >= FEWEST_TRIALS
    errors = "; its numbers' errors hold by how much they move without one trial or another" if several else ""
    return (
        f" It is a description rather than the law: even with {case.own} of each trial's own it leaves "
        f"{math.sqrt(left):.2g} times the sensors' noise{errors}."
    )


def _unit(unit: str, case: Case) -> str:
    """A unit as this group's numbers have it."""
    return case.member.model.unit(unit)


def _told(numbers: Mapping[str, Estimate], case: Case) -> dict[str, Estimate]:
    """Numbers in these units, in what is said of a bound too."""
    units = {name: _unit(e.unit, case) for name, e in numbers.items()}
    return {
        name: replace(e, unit=units[name], outcome=re.sub(rf"(?<= ){re.escape(e.unit)}$", units[name], e.outcome))
        for name, e in numbers.items()
    }


def _without_a_name(plain: Verdict, case: Case, far: bool, as_scatter: bool = False) -> Verdict:
    """Nothing is missing, or something is and no suspect explains it: in most trials, or in some so much (``far``)
    that the level as a whole is out of reach of repetitions.

    Nothing is missing either where the group as a whole lies within repeatability and the scatter of k, c, mu brings
    its trials down to noise (``as_scatter``), though some lie outside: a few dry trials can repeat too well.
    """
    total = len(case.trials)
    if as_scatter and case.missing > total / 2:
        text = (
            f"{case.label}: the equation explains {total - case.missing} of {total} trials within repeatability and "
            f"the group as a whole (error {percent(case.baseline.nrmse)}, {case.repeats}), all "
            f"of them to the noise with {case.own} of their own; nothing is missing."
        )
        return replace(plain, status="nothing_missing", verdict=(), sentence=text)
    if case.missing <= total / 2 and not (far and case.missing):
        text = (
            f"{case.label}: the equation explains {total - case.missing} of {total} trials within repeatability "
            f"(error {percent(case.baseline.nrmse)}, {case.repeats}"
            f"{', beyond which scatter alone puts one in twenty' if case.missing else ''}); nothing is missing."
        )
        return replace(plain, status="nothing_missing", verdict=(), sentence=text)
    text = (
        f"{case.label}: the equation misses {percent(case.baseline.nrmse)} of the motion "
        f"({case.repeats}) in {case.missing} of {total} trials, and no suspect explains it: unknown."
        + (f" Of what is left stand {case.place}." if case.place else "")
    )
    return replace(plain, status="unknown", verdict=("unknown",), sentence=text)


def _known(level: Level, case: Case) -> tuple[str, ...]:
    """Names that the dry trials of this group's spring need already."""
    return tuple(
        addend.prefix for addend in level.standing
        if addend.frees or any(case.member.label in {label for label, _, _ in a.by_spring} for a in addend.additions)
    )  # fmt: skip


def _origin(case: Case, suspects: Sequence[Suspect], known: Sequence[str]) -> Origin:
    first = suspects[0] if suspects else None
    if known:
        instrument = {s.name for s in SUSPECTS if s.origin == "instrument"}
        return "instrument" if known[0] in instrument else "structure"
    if first is not None and first.origin in ("outside", "instrument", "undetermined"):
        return first.origin
    if case.dry:
        return "structure"
    return "water" if case.has_dry else "undetermined"


def _physics(case: Case, found: Mapping[str, Sequence[Mapping[str, Estimate]]]) -> PhysicalCheck:
    swinging = {s.name for s in SUSPECTS if s.swings}
    rates = [
        one["natural_frequency_rad_per_s"] for name, many in found.items() if name in swinging
        for one in many if "natural_frequency_rad_per_s" in one
    ]  # fmt: skip
    return check_cell(rates[0], case.cell) if rates else PhysicalCheck(because="no bound applies to this effect")


def _all_parameters(
    case: Case, diagnosis: LevelDiagnosis, found: Mapping[str, Sequence[Mapping[str, Estimate]]]
) -> dict[str, Estimate]:
    """The refitted equation's numbers and the additions', by name."""
    fit = diagnosis.best.fit
    numbers = {}
    for c in case.member.model.coefficients:
        name = c.name if c.name in fit.solution.problem.names else f"{c.name}@{case.member.label}"
        if name not in fit.solution.problem.names:
            continue  # an addition took its place
        together = Estimate(fit.value(name), fit.solution.stderr(name), 0.0, c.unit, "joint fit")
        numbers[c.name] = mean_of_own(case.member, fit.solution, c, name) or together
    numbers = with_scale_error(numbers | learned_structure(case.member, fit), case.specimen)
    for name, many in found.items():
        for i, one in enumerate(many):
            suffix = f"#{i + 1}" if i else ""
            numbers |= {f"{name}{suffix}.{key}": value for key, value in one.items()}
    return numbers


def _correlations(case: Case, diagnosis: LevelDiagnosis) -> dict[str, dict[str, float]]:
    """Correlations of the numbers that `_all_parameters` gives, as far as they are unknowns of the fit."""
    fit, label = diagnosis.best.fit, case.member.label
    known = fit.solution.problem.names
    unknowns = {c.name: next((n for n in (c.name, f"{c.name}@{label}") if n in known), "")
                for c in case.member.model.coefficients}  # fmt: skip
    for addend in fit.addends:
        for a in (a for a in addend.additions if a.scope != "trial"):
            unknowns[f"{addend.prefix}.{a.name}"] = full_name(addend.prefix, a, label, "")
    index = {name: known.index(unknown) for name, unknown in unknowns.items() if unknown in known}
    covariance = fit.solution.covariance
    errors = {name: math.sqrt(max(float(covariance[i, i]), 0.0)) for name, i in index.items()}
    return {
        one: {other: float(covariance[index[one], index[other]]) / (errors[one] * errors[other])
              for other in index if errors[other] > 0.0}
        for one in index if errors[one] > 0.0
    }  # fmt: skip
