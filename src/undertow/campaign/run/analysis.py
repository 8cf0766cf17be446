"""One group's trials through every identifier, and what their equation does not explain.

Belongs here: the order of work inside a group. Does not belong here: reading, conditioning, writing (course.py).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from undertow.campaign.run.differing import baseline_grown, of_any_trial, with_grown_errors
from undertow.campaign.run.unsearched import unsearched_verdict
from undertow.comparison.deviations import size_in
from undertow.conditioning.motion import Motion
from undertow.discrepancy.drifts import amplitude_drifts
from undertow.discrepancy.findings import GroupFindings, TrialFindings
from undertow.discrepancy.place import locate
from undertow.discrepancy.shares import with_shares
from undertow.discrepancy.words import count, group_title
from undertow.equation.kernel import SLOT
from undertow.equation.term import Term
from undertow.errors import FAILURES, failure
from undertow.likelihood.fit import Fit, Specimen, Structure
from undertow.likelihood.free_run import (
    FreeRun,
    error_as_measured,
    free_run,
    repeatability,
    scored_channel,
    sensor_floor,
)
from undertow.likelihood.problem import TrialOptions
from undertow.likelihood.scale import Anchor, to_physical
from undertow.methods import decay, method1, method2
from undertow.methods.baseline import GroupFit, GroupModel, as_fit, fit_group, group_model
from undertow.methods.dry import DEFAULT_SCATTER
from undertow.methods.sindy import SindyResult, discover
from undertow.quantities import OK, Estimate
from undertow.recording.recording import Condition
from undertow.uncertainty.disagreement import of_one_trial
from undertow.uncertainty.repeats import mean_of_trials

PER_TRIAL = ("decay", "sindy", "method1", "method2", "output_error")
"""Methods that a trial can be given alone."""


@dataclass(frozen=True)
class GroupTask:
    """Everything one group's analysis needs: trials in order of amplitude, equation, specimen, structure, anchor.

    ``apart`` names trials that are too many to be fitted together: each is fitted alone and held against the group's
    equation, which never saw it. ``contradiction`` says which of its channels contradict each other, in words.
    ``dry_trials`` is how many dry trials the spring has of which most are there; ``uneven`` says that its own differ
    by more than trials do.
    """

    key: Mapping[str, Condition]
    dry: bool
    motions: tuple[Motion, ...]
    terms: tuple[Term, ...]
    specimen: Specimen
    structure: Structure | None
    anchor: Anchor
    stiffness: Mapping[str, Estimate] = field(default_factory=dict)
    scatter: Mapping[str, float] = field(default_factory=dict)
    freedom: float = math.inf
    dry_structure: Structure | None = None
    held_out: tuple[str, ...] = ()
    methods: tuple[str, ...] = PER_TRIAL
    options: TrialOptions = field(default_factory=TrialOptions)
    seed: int = 0
    apart: tuple[str, ...] = ()
    contradiction: str = ""
    dry_trials: int = 0
    uneven: str = ""

    @property
    def joint(self) -> tuple[Motion, ...]:
        """The trials that are looked at together: all but those ``apart``."""
        return tuple(m for m in self.motions if m.name not in self.apart) if self.apart else self.motions


def analyse(task: GroupTask) -> GroupFindings:
    """All methods on one group, its baseline equation, free runs, mismatches and verdict."""
    training = [m for m in task.joint if m.name not in task.held_out]
    model = group_model(
        task.terms, task.joint, task.specimen, task.structure, dry=task.dry, anchored=task.anchor.known,
        stiffness={n: e.value for n, e in task.stiffness.items()},
    )  # fmt: skip
    baseline = _baseline(task, _baseline_model(task, model), training)
    fits = _group_fits(task, model)
    singles = _single_fits(task, model)
    fits |= _means_of_singles(singles)
    if task.dry and len(task.motions) > 1 and "output_error" in fits:
        fits["output_error"] = _mean_structure(fits["output_error"], singles)
    fits, differ = with_grown_errors(fits, singles, {m.name: m.amplitude for m in task.motions})
    baseline, too = baseline_grown(baseline, training, singles)
    if scatter := _of_any_trial(task):
        baseline = of_any_trial(baseline, scatter)
    alone = (of_one_trial(_by_symbol(scatter, model)),) if len(training) == 1 else ()
    trials = tuple(_trial(task, model, baseline, motion, singles[motion.name]) for motion in task.motions)
    trials = _with_shares(task, trials, baseline)
    equation = baseline.equation()
    return GroupFindings(
        task.key, task.dry, trials, task.specimen, task.structure, fits, equation, baseline.equation_errors(),
        unsearched_verdict(task.key, task.held_out, trials, baseline.estimates),
        (*_rests_on(task, model), *alone, *(one.sentence for one in amplitude_drifts(trials, group_title(task.key)))),
        (*too, *differ),
    )  # fmt: skip


def _with_shares(
    task: GroupTask, trials: Sequence[TrialFindings], baseline: GroupFit
) -> tuple[TrialFindings, ...]:  # fmt: skip
    """Shares of what is left over, learned on whole trials that are left out in turn: of the joint ones."""
    together = [t for t in trials if t.motion.name not in task.apart]
    found = {t.motion.name: t for t in with_shares(together, baseline)}
    return tuple(found.get(t.motion.name, t) for t in trials)


def _rests_on(task: GroupTask, model: GroupModel) -> Iterator[str]:
    """What a group's numbers rest on, in words: its anchor, what was assumed, what was not done with every trial."""
    yield from task.anchor.doubts
    if task.anchor.kind == "load cells":
        rests = "inertias and moments" if task.specimen.rotation else "kilograms and newtons"
        yield f"{rests} rest on the {task.anchor.sentence}"
    if task.structure is None and not task.scatter:
        parts = ", ".join(f"{100 * v:g} % in {k}" for k, v in _by_symbol(DEFAULT_SCATTER, model).items())
        assumed = f"; assumed for repeatability: {parts}" if parts else ""
        yield f"neither dry trials nor specimen.scatter say how trials scatter{assumed}"
    if task.apart:
        yield (
            f"of {count(len(task.motions), 'trial')} {len(task.joint)}, spread over all amplitudes, are fitted "
            f"together and searched; the other {len(task.apart)} are fitted alone and held against that equation"
        )


def _by_symbol(scatter: Mapping[str, float], model: GroupModel) -> dict[str, float]:
    """A scatter of what the equation has of it: k, c, mu (or friction, where no weight is known)."""
    called = {"mu" if symbol == "friction" else symbol: symbol for symbol in model.scattering}
    return {called[symbol]: share for symbol, share in scatter.items() if symbol in called}


def _of_any_trial(task: GroupTask) -> Mapping[str, float]:
    """How much another trial would differ from the only one, where that is known and the fit does not hold it."""
    return task.scatter if len(task.joint) == 1 and task.structure is None else {}


def _baseline_model(task: GroupTask, model: GroupModel) -> GroupModel:
    """Dry groups are held against the dry means themselves, so that scatter between them is what it is elsewhere."""
    if not task.dry or task.dry_structure is None:
        return model
    return group_model(task.terms, task.joint, task.specimen, task.dry_structure, dry=True, anchored=True)


def _baseline(task: GroupTask, model: GroupModel, training: Sequence[Motion]) -> GroupFit:
    """The equation fitted to the training trials, so that their free runs come closest.

    Random effects keep the loudest trial from deciding alone where the equation is right; where it is wrong they can
    take up what it lacks. Both fits are scored, the better one is the baseline.
    """
    plain = fit_group(model, training, task.options)
    if model.fixed is None or len(training) < 2:
        return plain
    fits = [plain, fit_group(model, training, task.options, "trials")]

    def error(fit: GroupFit) -> float:
        scores = [_score(m, model.theta(fit.values, m.name), rest_prior(task, m)) for m in training]
        return float(np.mean(np.square([s if math.isfinite(s) else 1e3 for s in scores])))

    return min(fits, key=error)


def rest_prior(task: GroupTask, motion: Motion) -> float:
    """Prior width of a trial's rest position: mu N / k, within which friction lets a body rest, where known; never
    under its own error, m."""
    error, structure = motion.equilibrium.total_stderr, task.structure
    if structure is None:
        return error
    width = structure.mu.value * task.specimen.normal_force_N / structure.k.value
    return max(width, error) if math.isfinite(width) else error


def _group_fits(task: GroupTask, model: GroupModel) -> dict[str, Fit]:
    """Methods that take a group's trials together: output error with random effects, SINDy pooled."""
    names = [m.name for m in task.joint]
    fits: dict[str, Fit] = {}
    if "output_error" in task.methods:
        joint = fit_group(model, task.joint, task.options, "trials and means")
        joint = of_any_trial(joint, scatter) if (scatter := _of_any_trial(task)) else joint
        fits["output_error"] = as_fit(joint, "output_error", names, task.anchor.sentence)
    if "sindy" in task.methods:
        fits["sindy"] = _attempt("sindy", tuple(names), lambda: _sindy(task, task.joint))
    return fits


def _attempt(method: str, trials: tuple[str, ...], work: Callable[[], Fit]) -> Fit:
    """The method's Fit, or an empty one whose outcome is the reason why there is none."""
    try:
        return work()
    except FAILURES as reason:
        return Fit(method, trials, outcome=failure(reason))


def _sindy(task: GroupTask, motions: Sequence[Motion]) -> Fit:
    terms = [t for t in task.terms if not t.is_inertia and not (task.dry and t.of_area)]
    found: SindyResult = discover(motions, terms, subset=False)
    physical = to_physical(found.names, found.coefficients, found.covariance, task.anchor, task.specimen, task.dry)
    notes = (*found.fit.notes, _selected(motions, terms))
    return replace(found.fit, method="sindy", parameters=physical, notes=notes, anchor=task.anchor.sentence)


def _selected(motions: Sequence[Motion], terms: Sequence[Term]) -> str:
    """Which of the prescribed terms a free choice by evidence keeps, in words."""
    if len(motions) < 2:
        return ""
    kept = discover(motions, terms).names
    dropped = [t.name for t in terms if t.name not in kept]
    return "evidence keeps every term" if not dropped else f"evidence would do without {', '.join(dropped)}"


def _single_fits(task: GroupTask, model: GroupModel) -> dict[str, dict[str, Fit]]:
    """Every method on every trial alone."""
    out: dict[str, dict[str, Fit]] = {}
    for motion in task.motions:
        fits: dict[str, Fit] = {}
        for method in task.methods:
            for name, work in _single(task, model, motion, method).items():
                fits[name] = _attempt(name, (motion.name,), work)
        out[motion.name] = fits
    return out


def _single(task: GroupTask, model: GroupModel, motion: Motion, method: str) -> dict[str, Callable[[], Fit]]:
    """What a method runs on one trial: name -> work; empty where it does not apply."""
    structure, specimen = task.structure, task.specimen
    own = task.stiffness.get(motion.name)
    if method == "output_error":
        said = task.anchor.sentence
        return {method: lambda: as_fit(fit_group(model, [motion], task.options), method, [motion.name], said)}
    if method == "sindy":
        return {method: lambda: _sindy(task, [motion])}
    if method == "decay" and task.dry:
        return {method: lambda: decay.identify_decay(motion, specimen)}
    if method in ("method1", "method2") and not task.dry and structure is not None:
        if not (math.isfinite(specimen.mass_kg) and specimen.area_m2 > 0.0):
            return {}
        k = own.value if own else structure.k.value
        trial_structure = replace(structure, k=replace(structure.k, value=k))
        if method == "method1":
            return {method: lambda: method1.fit(motion, trial_structure, specimen)}
        if "acceleration" not in motion.recording.channels:
            return {}
        both: dict[str, Fit] = {}

        def instants(name: str) -> Fit:
            """Method 2's fit of that name; both come from one look at the instants."""
            if not both:
                both.update({f.method: f for f in method2.identify_method2(motion, trial_structure, specimen)})
            return both[name]

        return {name: (lambda name=name: instants(name)) for name in ("method2", "method2_printed")}  # type: ignore[misc]
    return {}


def _mean_structure(pooled: Fit, singles: Mapping[str, Mapping[str, Fit]]) -> Fit:
    """Dry trials by output error: means over trials, each fitted alone, with errors from their scatter.

    Together they would share one k, which no rig keeps: the loudest trial's would pass for all, sure of itself.
    """
    alone = [fits["output_error"] for fits in singles.values() if fits["output_error"].parameters]
    parameters = dict(pooled.parameters)
    for name, one in pooled.parameters.items():
        found = [fit.parameters[name] for fit in alone if name in fit.parameters]
        if len(found) > 1 and any(estimate.stderr > 0.0 for estimate in found):
            mean = mean_of_trials(found, one.unit, f"mean of {len(found)} trials")
            parameters[name] = replace(mean, systematic=one.systematic)
    return replace(pooled, parameters=parameters, notes=(*pooled.notes, "mean over trials, each fitted alone"))


def _means_of_singles(singles: Mapping[str, Mapping[str, Fit]]) -> dict[str, Fit]:
    """Group rows of the methods that work trial by trial: means over trials with errors from their scatter."""
    out: dict[str, Fit] = {}
    methods = {name for fits in singles.values() for name in fits} - {"sindy", "output_error"}
    for method in sorted(methods):
        good = [fits[method] for fits in singles.values() if method in fits and fits[method].parameters]
        if not good:
            continue
        parameters = {}
        for name in good[0].parameters:
            estimates = [f.parameters[name] for f in good if name in f.parameters]
            mean = mean_of_trials(estimates, estimates[0].unit, f"mean of {len(estimates)} trials")
            systematic = float(np.mean([e.systematic for e in estimates]))
            bounded = [e.outcome for e in estimates if e.outcome != OK]
            outcome = f"{len(bounded)} of {len(estimates)} trials: {bounded[0]}" if bounded else OK
            parameters[name] = replace(mean, systematic=systematic, outcome=outcome)
        outcomes = [e.outcome for e in parameters.values() if e.outcome != OK]
        outcome = outcomes[0] if outcomes else OK
        out[method] = Fit(method, tuple(singles), {}, parameters, outcome, ("mean over trials",), good[0].anchor)
    return out


def theta_of(model: GroupModel, baseline: GroupFit, fit: Fit, trial: str) -> np.ndarray:
    """The integrator's parameter vector that a method's numbers stand for; the baseline's where it gives none."""
    parameters = fit.parameters
    model = baseline.model if not all(c.name in parameters for c in model.coefficients) else model
    values = baseline.values
    values |= {c.name: parameters[c.name].value for c in model.coefficients if c.name in parameters}
    theta = model.theta(values, trial)
    if fit.method == "sindy" and model.anchored:
        normal = model.specimen.normal_force_N
        plain = (("k_N_per_m", "k1", 1.0), ("c_Ns_per_m", "c1", 1.0), ("friction_N", "fc", 1.0))
        for name, slot, factor in (*plain, ("mu", "fc", normal)):
            if name in parameters:
                theta[SLOT[slot]] = factor * parameters[name].value
    return theta


def _trial(
    task: GroupTask, model: GroupModel, baseline: GroupFit, motion: Motion, fits: Mapping[str, Fit]
) -> TrialFindings:
    """One trial's free runs: the baseline's with its floors, and each method's own score."""
    width = rest_prior(task, motion)
    run = free_run(motion, baseline.model.theta(baseline.values, motion.name), width)
    floor, limit = floors_of(task, motion, run)
    scores = {"baseline": run.nrmse}
    for name, fit in fits.items():
        if fit.parameters:
            scores[name] = _score(motion, theta_of(model, baseline, fit, motion.name), width)
    mismatch = locate(motion, run, floor, limit)
    return TrialFindings(
        motion, fits, scores, mismatch, run.t, run.measured, run.simulated, motion.name in task.held_out,
        as_measured=error_as_measured(motion, run.theta),
    )  # fmt: skip


def _score(motion: Motion, theta: np.ndarray, width: float) -> float:
    """nrmse of a free run; nan where the numbers describe no motion (as Method 2 as printed often does)."""
    try:
        return free_run(motion, theta, width).nrmse
    except FAILURES:
        return math.nan


def floors_of(task: GroupTask, motion: Motion, run: FreeRun) -> tuple[float, float]:
    """What the sensors alone and repetitions of a trial would leave of its free run (nrmse)."""
    floor = sensor_floor(motion, run)
    freedom = task.structure.scatter_freedom if task.structure is not None else task.freedom
    spread = spread_of_repetitions(task, run)
    return floor, repeatability(run, spread, floor, scored_channel(motion), task.seed, freedom)


def spread_of_repetitions(task: GroupTask, run: FreeRun) -> dict[str, float]:
    """Standard deviations of the slots k1, c1, fc from trial to trial, the dry means' own errors included."""
    relative = task.structure.scatter if task.structure is not None else task.scatter or DEFAULT_SCATTER
    means = {"k": 0.0, "c": 0.0, "mu": 0.0}
    if task.structure is not None:
        for symbol in means:
            estimate: Estimate = getattr(task.structure, symbol)
            means[symbol] = estimate.total_stderr / estimate.value if estimate.value else 0.0
    spread = {}
    rubs = "fb" if run.theta[SLOT["fc"]] == 0.0 else "fc"  # bristles may stand in friction's place
    for symbol, slot in (("k", "k1"), ("c", "c1"), ("mu", rubs)):
        own = relative.get(symbol, 0.0)
        error = means[symbol] if math.isfinite(means[symbol]) and not task.dry else 0.0
        if symbol == "k":
            error = 0.0  # the group's added mass takes the mean of k up
        spread[slot] = math.hypot(own, error) * size_in(run.theta, slot)
    return spread
