"""All trials of one water fitted together: the prescribed equation, its structure's scatter, instruments, additions.

Springs of one water share the water: added mass, drag and what is added are the same for both, k, c and mu are each
spring's own within their errors and each trial's own within the scatter. The residual's size is found with the fit:
each model is judged at the noise it leaves itself, n_eff ln(misfit) + priors + a penalty for every unknown.

Belongs here: that fit and its criterion. Does not belong here: which additions are tried (suspects.py, search.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from undertow.comparison.deviations import SLOTS, of_the_means, structure_links, unit_of
from undertow.comparison.evidence import criterion, of_an_effect, tempered, trial_misfits
from undertow.comparison.jumps import without_jumps
from undertow.comparison.level import Addend, Level, Member, full_name, seen_by
from undertow.comparison.suspect import DRIFT, HOOK, Addition, Scales, widening
from undertow.conditioning.motion import Motion
from undertow.conditioning.period import dominant_period
from undertow.equation.kernel import SLOT
from undertow.errors import IdentificationError
from undertow.likelihood import output_error
from undertow.likelihood.free_run import STEADY, OwnDrift, OwnUnknown, free_run
from undertow.likelihood.noise import BY_CHANCE, residual_memory
from undertow.likelihood.output_error import Solution
from undertow.likelihood.priors import CLOCK_RADIANS, DRIFT_SHARE, GAIN_STD, LATE_RELEASE_RADIANS
from undertow.likelihood.problem import Link, Problem, ProblemBuilder
from undertow.methods.dry import DEFAULT_SCATTER
from undertow.recording.recording import Array

LAST_SWINGS = 3.0
"""Swings count down to this many times mu N / k."""

COARSE_FITS = 3
"""Fits of one model by which its own noise is found, at most, before the last one, which goes to the end."""

SETTLED = 0.2
"""A trial's noise is found when its logarithm moves by less than this from fit to fit."""

SLOWER = 0.5
"""Degree, at most, of a sensor's drift in one of the body's cycles: half of that many times it turns back, a quarter as
often as the body."""

STEPS_A_PERIOD = 20.0
"""Numbers that a force of which nothing is known has in a period of the motion: two for each line up to ten times the
body's rate, where the body shows a hundredth of it."""


@dataclass(frozen=True)
class JointFit:
    """One model on one level: the solution at its own noise, and what it is worth.

    ``misfit`` is the mean squared residual in units of the sensors' noise (geometric mean over trials); ``criterion``
    is twice the negative log evidence (BIC for unknowns without prior): lower is better; ``memory`` the cells over
    which residuals are correlated; ``shared_water`` whether added mass and drag are one for all springs.
    """

    addends: tuple[Addend, ...]
    solution: Solution
    misfit: float
    criterion: float
    memory: float
    shared_water: bool = True
    misfits: Mapping[str, float] = field(default_factory=dict)

    def value(self, name: str) -> float:
        """Value of an unknown by its full name."""
        return self.solution.value(name)

    def theta(self, trial: int) -> Array:
        """Parameter vector of one trial as fitted, its own deviations included."""
        return output_error.parameter_vector(self.solution.problem.trials[trial], self.solution.values)

    def moved(self, before: JointFit) -> tuple[str, float]:
        """The reported number that differs most from another fit's, and by how many of its standard errors: of those
        of no single trial and of no addition, a spring's own beside one for all; empty and 0 where both report none."""
        mine = self.solution.problem.names
        reported = {n: n if n in mine else n.partition("@")[0] for n in before.solution.problem.names}
        names = {n: now for n, now in reported.items() if not set("[.") & set(n) and now in mine}
        errors = {n: before.solution.stderr(n) for n in names}
        away = {n: abs(self.value(now) - before.value(n)) / errors[n] for n, now in names.items() if errors[n] > 0.0}
        return max(away.items(), key=lambda one: one[1], default=("", 0.0))

    def apart(self, names: Sequence[str]) -> tuple[float, float]:
        """By how much the larger of some unknowns exceed the smaller ones (means, parted at the widest gap), and the
        standard error: what all have in common cancels, with its error."""
        index = np.array([self.solution.problem.names.index(name) for name in names])
        values = self.solution.values[index]
        order = np.argsort(values)
        gap = int(np.argmax(np.diff(values[order]))) + 1
        weights = np.zeros(values.size)
        weights[order[:gap]], weights[order[gap:]] = -1.0 / gap, 1.0 / (values.size - gap)
        variance = float(weights @ self.solution.covariance[np.ix_(index, index)] @ weights)
        return float(weights @ values), math.sqrt(max(variance, 0.0))

    @property
    def values(self) -> dict[str, float]:
        """Values of all unknowns by name."""
        return dict(zip(self.solution.problem.names, self.solution.values.tolist(), strict=True))


def build(level: Level, addends: Sequence[Addend]) -> Problem:
    """The joint problem: shared water, each spring's structure, each trial's deviations and sensors, additions."""
    builder = ProblemBuilder()
    replaced = frozenset().union(*(addend.replaced for addend in addends))
    largest = max(m.amplitude for member in level.members for m in member.motions)
    for member in level.members:
        drift = DRIFT_SHARE * largest
        options = replace(
            member.options, displacement_gain_std=GAIN_STD, acceleration_gain_std=GAIN_STD, drift_std=drift,
        )  # fmt: skip
        for motion in member.motions:
            links = []
            for c in (c for c in member.model.coefficients if c.slot not in replaced):
                shared = level.shared_water and member.model.fixed is not None
                name = c.name if shared else f"{c.name}@{member.label}"
                index = builder.unknown(name, c.start, lower=c.lower, upper=c.upper, scale=c.scale)
                links.append(Link(SLOT[c.slot], index, c.factor))
            links += structure_links(builder, member, motion.name)
            hooked = motion.window.held and any(addend.hooked for addend in addends)
            links += _rubbing(builder, level.standing, member, motion.name)
            for addend in addends:
                for a in (a for a in addend.additions if a.slot != HOOK or hooked):
                    links += _links(builder, addend.prefix, a, member.label, motion.name)
                if member.free_start:
                    links += _free_hidden(builder, addend, level.scales, motion.name)
            base, links = _moved(addends, member.label, member.model.trial_base(motion.name), links)
            seen = seen_by(addends, motion)
            ends = replace(
                options, end_s=swinging_until(motion, member, seen), hooked=hooked,
                drift_degree=_degree(addends, motion),
            )  # fmt: skip
            builder.trial(seen, base, tuple(links), ends)
    return _freed(without_jumps(level, builder.build()), addends)


def swinging_until(motion: Motion, member: Member, seen: Motion) -> float:
    """Until when a trial's swings count, s after the release: those under `LAST_SWINGS` times the width in which
    friction lets the body rest are left out, for where it stops is chance, and the misfit has kinks there. Where a
    model follows the motion from later on alone (``seen``), a first period counts: too little would be left of a small
    release to be looked at. inf without friction."""
    structure = member.model.fixed
    if structure is None or not structure.mu.value > 0.0:
        return math.inf
    width = structure.mu.value * unit_of(member, "mu") / structure.k.value
    away = np.abs(motion.x - motion.equilibrium.value) * motion.inside
    large = np.flatnonzero(away > LAST_SWINGS * width)
    least = 0.0 if seen is motion else float(seen.windowed("t")[0]) + dominant_period(seen)
    return max(float(motion.t[large[-1]]), least) if large.size and width > 0.0 else math.inf


def _moved(
    addends: Sequence[Addend], spring: str, base: Array, links: Sequence[Link]
) -> tuple[Array, list[Link]]:
    """A trial's base and links with what an addend moves in its new slot."""
    links = list(links)
    for addend in addends:
        for old, new in addend.moved(spring).items():
            base = base.copy()
            base[new], base[old] = base[new] + base[old], 0.0
            links = [replace(link, slot=new) if link.slot == old else link for link in links]
    return base, links


def _freed(problem: Problem, addends: Sequence[Addend]) -> Problem:
    """The same problem with the priors of suspected sensors widened, or about their common error."""
    unknowns = problem.unknowns
    for addend in (d for d in addends if d.frees):
        mine = addend.freed(problem.names)
        unknowns = tuple(
            u if u.name not in mine
            else replace(u, start=addend.centres[mine[u.name] - 1]) if addend.centres
            else replace(u, prior_std=widening(addend.frees) * u.prior_std)
            for u in unknowns
        )  # fmt: skip
    return replace(problem, unknowns=unknowns)


def _links(builder: ProblemBuilder, prefix: str, a: Addition, spring: str, trial: str) -> list[Link]:
    name = full_name(prefix, a, spring, trial)
    start, prior = a.start, a.prior_std
    if a.by_spring:
        known = {label: (value, error) for label, value, error in a.by_spring}
        if spring not in known:
            return []
        start, prior = known[spring]
    limits = {"lower": a.lower, "upper": a.upper, "prior_std": prior, "scale": a.scale}
    index = builder.unknown(name, start, unit=a.unit, **limits)
    return [Link(SLOT[slot], index, factor) for slot, factor in a.slots]


def _free_hidden(builder: ProblemBuilder, addend: Addend, scales: Scales, trial: str) -> list[Link]:
    """Initial state of a hidden oscillator where nothing says that it was at rest."""
    links = []
    for a in addend.additions:
        if a.slot.startswith("hw"):
            for slot, size in ((f"hs{a.slot[2:]}", scales.size), (f"hu{a.slot[2:]}", scales.speed)):
                links.append(Link(SLOT[slot], builder.unknown(f"{addend.prefix}.{slot}[{trial}]", 0.0, scale=size)))
    return links


def _rubbing(builder: ProblemBuilder, standing: Sequence[Addend], member: Member, trial: str) -> list[Link]:
    """This trial's deviation from a dry friction that the equation lacks and the dry trials named: it scatters as
    friction coefficients do."""
    structure = member.model.fixed
    if structure is None or structure.mu.value > 0.0:
        return []
    sizes = [
        abs(value) for addend in standing for a in addend.additions if a.slot in ("fc", "fs")
        for label, value, _ in a.by_spring if label == member.label
    ]  # fmt: skip
    if not sizes:
        return []
    std = max(structure.scatter.get("mu", 0.0), DEFAULT_SCATTER["mu"]) * max(sizes)
    return [Link(SLOT["fc"], builder.unknown(f"friction_N[{trial}]", 0.0, prior_std=std, scale=std))]


def free_run_error(level: Level, fit: JointFit) -> float:
    """RMS over training trials of the free run's nrmse in units of its group's repeatability.

    k, c, mu stand at their dry values; x0, clock and rest are adjusted to each trial.
    """
    return _rms_error(level, fit, [m.allowed for m in level.members])


def missed_share(level: Level, fit: JointFit) -> float:
    """RMS over training trials of the free run's nrmse itself: the share of the motion that it misses."""
    return _rms_error(level, fit, [1.0] * len(level.members))


def _rms_error(level: Level, fit: JointFit, units: Sequence[float]) -> float:
    squares = [
        (_error(level, member, fit, motion) / unit) ** 2
        for member, unit in zip(level.members, units, strict=True)
        for motion in member.motions
    ]
    return math.sqrt(float(np.mean(squares)))


def its_own(fit: JointFit) -> dict[str, OwnUnknown]:
    """Unknowns that are every trial's own, as its release is; the time in which a hook lets go from where the trials'
    mean has it."""
    found = {}
    for name, a in ((f"{addend.prefix}.{a.name}", a) for addend in fit.addends for a in addend.additions):
        if a.of_its_own:
            found[name] = OwnUnknown(a.scale, a.slots)
        elif a.slot == HOOK:
            times = [value for full, value in fit.values.items() if full.startswith(f"{name}[")]
            found[name] = OwnUnknown(a.scale, a.slots, float(np.mean(times)), a.lower, a.upper)
    return found


def its_drift(fit: JointFit, motion: Motion) -> OwnDrift:
    """How a displacement sensor that is suspected may drift in a trial of its own."""
    if not any(addend.frees == DRIFT for addend in fit.addends):
        return STEADY
    return OwnDrift(widening(DRIFT) * DRIFT_SHARE * motion.amplitude, _degree(fit.addends, motion))


def _degree(addends: Sequence[Addend], motion: Motion) -> int:
    """Degree in time of a sensor's drift in one trial, no more than `SLOWER` in a cycle of the body."""
    cycles = float(np.ptp(motion.windowed("t"))) / dominant_period(motion)
    return max(1, min(max((addend.degree for addend in addends), default=1), int(SLOWER * cycles)))


def _error(level: Level, member: Member, fit: JointFit, motion: Motion) -> float:
    """One trial's free-run error; infinite where what all trials share gives it no motion with bounds. What every trial
    has of its own (an outside force's size and phase) is adjusted to it, as its release is: as fitted beside a k of
    this trial's own it would not be that of the k that all share."""
    theta = shared_theta(level, member, fit, motion.name)
    try:
        seen, width = seen_by(fit.addends, motion), member.options.rest_offset_std
        return free_run(seen, theta, width, its_own(fit), drift=its_drift(fit, motion)).nrmse
    except IdentificationError:
        return math.inf


def shared_theta(level: Level, member: Member, fit: JointFit, trial: str, learned: bool = False) -> Array:
    """Parameter vector of one trial from what all trials share: no deviations of this trial, and of the dry means only
    where they are the group's own, or where what trials in water say of them too is asked for (``learned``)."""
    known = fit.values
    theta = member.model.trial_base(trial)
    replaced = frozenset().union(*(addend.replaced for addend in fit.addends))
    if member.own_means or learned:
        for mean in of_the_means(member):
            for symbol, factor in mean.moves:
                theta[SLOT[SLOTS[symbol]]] += factor * unit_of(member, symbol) * known.get(mean.name, 0.0)
    for c in member.model.coefficients:
        if c.slot not in replaced:
            name = c.name if c.name in known else f"{c.name}@{member.label}"
            theta[SLOT[c.slot]] += c.factor * known[name]
    theta, _ = _moved(fit.addends, member.label, theta, ())
    for addend in fit.addends:
        for a in addend.additions:
            value = known.get(full_name(addend.prefix, a, member.label, trial), 0.0)
            for slot, factor in a.slots:
                theta[SLOT[slot]] += factor * value
            if member.free_start and a.slot.startswith("hw"):
                for slot in (f"hs{a.slot[2:]}", f"hu{a.slot[2:]}"):
                    theta[SLOT[slot]] += known.get(f"{addend.prefix}.{slot}[{trial}]", 0.0)
    return theta


def fit_joint(
    level: Level,
    addends: Sequence[Addend],
    memory: float,
    start: Mapping[str, float],
    misfit: float,
    growing: bool,
    quick: bool = False,
) -> JointFit:
    """The model with these addends at its own noise, each trial's its own.

    ``memory`` is the number of cells over which residuals are correlated; ``start`` gives values of unknowns by name
    where known; ``misfit`` a first guess of the mean squared residual in units of the sensors' noise.
    """
    problem = build(level, addends)
    values = np.array([start.get(u.name, u.start) for u in problem.unknowns])
    misfits = {t.name: misfit for t in problem.trials}
    efforts = (output_error.QUICK,) if quick else (*[output_error.COARSE] * COARSE_FITS, output_error.CLOSE)
    settled = False
    for i, effort in enumerate(efforts):
        if settled and effort is not efforts[-1]:
            continue
        hot = tempered(problem, misfits, memory)
        solution = output_error.fit(hot, values, growing=growing and i == 0, effort=effort)
        values = solution.values
        found = trial_misfits(solution, misfits, memory)
        settled = max(abs(math.log(found[name] / misfits[name])) for name in found) < SETTLED
        misfits = found
    typical = math.exp(float(np.mean(np.log(list(misfits.values())))))
    samples = max(solution.n_data / memory, 2.0)
    worth = criterion(solution, misfits, memory) + _width(problem, addends, samples)
    worth += _skipped(problem, addends, memory)
    return JointFit(tuple(addends), solution, typical, worth, memory, level.shared_water, misfits)


def fit_standing(level: Level) -> JointFit:
    """The prescribed equation with what stands already, at its own noise and memory."""
    first = fit_joint(level, level.standing, 1.0, {}, 10.0, growing=True)
    memory = residual_memory(first.solution)
    return fit_joint(level, level.standing, memory, first.values, first.misfit, growing=False)


def _width(problem: Problem, addends: Sequence[Addend], samples: float) -> float:
    """What a suspected sensor costs: 2 ln of how much wider for every prior, ln(n_eff) for a common error; and each
    trial's own number of an addition, ln(n_eff), where its prior only keeps it from trading places with what all share.
    """
    held = [u.name for u in problem.unknowns if of_an_effect(u.name) and math.isfinite(u.prior_std)]
    cost = math.log(samples) * len(held)
    for addend in (d for d in addends if d.frees):
        mine = len(addend.freed(problem.names))
        each = 2.0 * math.log(widening(addend.frees))
        cost += len(addend.centres) * math.log(samples) if addend.centres else each * mine
    hooks = sum(SLOT[HOOK] in t.slots for t in problem.trials)
    return cost + 2.0 * math.log(LATE_RELEASE_RADIANS / CLOCK_RADIANS) * hooks


def _skipped(problem: Problem, addends: Sequence[Addend], memory: float) -> float:
    """What it costs to ask nothing of the first periods: a number, ln(n_eff), for every n_eff of their samples, or for
    every step of a force that may have held the body then, whichever is fewer."""
    periods = max((addend.late for addend in addends), default=0.0)
    values = [len(t.channels) * periods * t.period_s / float(np.median(np.diff(t.t))) for t in problem.trials]
    kept = sum(len(t.channels) * t.t.size for t in problem.trials)
    numbers = sum(min(value / memory, STEPS_A_PERIOD * periods) for value in values)
    return numbers * math.log(max((kept + sum(values)) / memory, 2.0))


def at_memory(fit: JointFit, memory: float) -> JointFit:
    """The same fit valued as if residuals were correlated over ``memory`` cells."""
    problem, addends = fit.solution.problem, fit.addends
    worth = criterion(fit.solution, fit.misfits, memory)
    worth += _width(problem, addends, max(fit.solution.n_data / memory, 2.0)) + _skipped(problem, addends, memory)
    return replace(fit, criterion=worth, memory=memory)


def with_own_errors(level: Level, fit: JointFit) -> JointFit:
    """The fit with numbers and errors at the memory of its own residual, and the evidence that it was compared by.

    Sets are compared at a memory that they share, between the equation's and the closest one's: what a law leaves out
    swings for long. Of a law that is there the errors would be as many times too large as the root of that memory.
    """
    memory = max(residual_memory(fit.solution) - BY_CHANCE, 1.0)
    if memory >= fit.memory:
        return fit
    at = replace(level, shared_water=fit.shared_water)
    try:
        own = fit_joint(at, fit.addends, memory, fit.values, fit.misfit, growing=False)
    except IdentificationError:
        return fit
    return replace(own, criterion=fit.criterion, memory=fit.memory)
