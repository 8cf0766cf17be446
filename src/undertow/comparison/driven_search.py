"""What a driven equation lacks: suspects ranked by one linear step, fitted, and proved on parts that nobody fitted.

A suspect is added where the free run over the last part of the record, which nobody fitted, comes closer by `CLOSER`,
and where those over parts that were left out in turn do so surely, against their own scatter (driven_folds.py). The
first number of a law enters linearly, so that one Gauss-Newton step over its inner numbers' grid says what it may be
worth.

Belongs here: ranking, judging, the order. Does not belong here: which laws are suspected
(driven_suspects.py), fits (methods/driven.py), words.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from undertow.comparison.driven_folds import CLOSER, TRYING, Tried, by_stroke, come_closer, fold_errors, validation_rms
from undertow.comparison.driven_hysteresis import REMEMBERED, SLIDING, Contest, contest, remembers
from undertow.comparison.driven_suspects import OF_WATER, STATIC
from undertow.conditioning.driven import DrivenTrial
from undertow.equation.driven_hysteresis import BoucWen
from undertow.equation.driven_laws import find_driven
from undertow.errors import IdentificationError
from undertow.likelihood.driven import MASS, DrivenLaws, drive_for, driven_problem, extent_of
from undertow.likelihood.output_error import SearchEffort, residuals
from undertow.likelihood.problem import Problem
from undertow.methods.driven import DrivenFit, fit_driven, memory_samples
from undertow.methods.driven_begin import begun_beyond
from undertow.recording.recording import Array

HELD_BACK = 0.2
"""Share of the record, its end, that proof comes from."""
FEW_EFFECTIVE = 200.0
"""Below so many effective samples (a body without a spring adds up what its equation lacks, and its residual wanders)
the linear step says little, and more suspects are fitted."""
RANKED_SAMPLES = 12000
"""Samples on which suspects are ranked by one linear step."""
FITTED_AT_MOST = 3
"""Suspects that are fitted in a round, the best by the linear step."""
FITTED_WHERE_FEW = 6
"""The same where the linear step says little."""
SURE = 2.0
"""Standard errors by which a law's coefficient must differ from 0. Set on a synthetic carriage whose drive wanders, to
which a hysteresis of 15 +- 16 N/m was added: a force that fades along the record, and no law."""
ON_BOUND = "on a bound: "
"""How a fit's outcome begins where numbers ended at the edge of what they may be."""
UNFINISHED = "did not converge"
"""How it begins where the search went on when it was ended."""
AT_NOISE = 1.5
"""A free run over unseen samples that misses by no more than so many times the sensor's noise leaves a contest of
hystereses little to decide: members differ where there is more, by ten times the noise on bodies that are known."""
FARTHER, CONTINUED, STILL_FALLS = SearchEffort(48, 0.1), 5, 0.05
"""How far and how often the fit of a hysteresis is continued, and by what share its cost must have fallen each time.
Where bristles share a friction with a dry one, their numbers move along a valley that takes 100 to 200 iterations.
Others are not: an oscillator fitted to its end had followed a drive that wanders (a synthetic carriage, seed 6039)."""
YIELDS, PRESLIDES = (0.5, 1.5, 4.0), (0.02, 0.005)
"""Ways over which a hysteresis yields, as shares of the motion, and those of a body with dry friction besides."""
MISSED = 0.1
"""Share of the motion: an equation that misses more may have led its numbers astray (a hardening spring's mass to twice
itself). A suspect's fit then begins on windows too, and the closer of both is kept."""
ROUNDS = 4
"""Laws that are added at most."""

UNBOUNDED = 1e100
"""Derivatives beyond this are those of a motion that grows without bounds."""

Numbers = Mapping[str, float]


@dataclass(frozen=True, eq=False, repr=False)
class Proof:
    """Records that were held back, and the fits to the others: as given, and with what was added (without what differs
    from stroke to stroke)."""

    unseen: tuple[DrivenTrial, ...]
    before: DrivenFit
    after: DrivenFit


@dataclass(frozen=True, eq=False, repr=False)
class DrivenFound:
    """The equation as given and with what it lacked, both fitted to everything, and how that was decided.

    ``validation`` is the rms of the free run over samples that were held back, of both; ``added`` the laws' names;
    ``rivals`` the hystereses that the record cannot tell from the one that was added, ``members`` fits of all that
    competed, to what was not held back; ``proof`` the two equations whose validation it is.
    """

    baseline: DrivenFit
    augmented: DrivenFit | None
    added: tuple[str, ...]
    tried: tuple[Tried, ...]
    validation: tuple[float, float]
    rivals: tuple[str, ...] = ()
    members: Mapping[str, DrivenFit] = field(default_factory=dict)
    proof: Proof | None = None

    @property
    def best(self) -> DrivenFit:
        """The equation with what was added, or as given."""
        return self.augmented or self.baseline

    def __repr__(self) -> str:
        before, after = self.validation
        added = f"with {', '.join(self.added)} {after:.3g}" if self.added else "nothing was added"
        return f"the given equation misses samples it never saw by {before:.3g} rms; {added}\n{self.best}"


def suspects_for(trial: DrivenTrial, fitted: DrivenFit) -> list[tuple[str, list[Numbers]]]:
    """Names of laws that may be missing, with the grids of their inner numbers, relative to the trial's own motion."""
    extent = extent_of(trial)
    size = float(np.std(trial.outputs[trial.main])) if trial.main == "displacement" else extent.size
    rate = 2.0 * math.pi * _dominant_hz(trial)
    static = [*STATIC]
    if trial.mover == "water":
        static += OF_WATER
    grid: list[tuple[str, list[Numbers]]] = [(name, [{}]) for name in static]
    grid.append(("stribeck_friction", [{"velocity_m_per_s": s * extent.speed} for s in (0.02, 0.05, 0.15)]))
    grid.append(("relaxation", [{"time_s": s / rate} for s in (0.2, 1.0, 5.0)]))
    shapes = [(1.0 / (s * size), d / (s * size)) for s in YIELDS for d in (-0.7, 0.0, 0.7)]
    if any(term.name in SLIDING for term in fitted.laws.terms):
        shapes += [(1.0 / (s * size), 0.0) for s in PRESLIDES]
    grid.append(("bouc_wen", [{"loop": loop, "skew": skew, "exponent": 1.0} for loop, skew in shapes]))
    known = {"damping_ratio": 0.03}
    tones: list[Numbers] = [{"natural_frequency_rad_per_s": f * rate, **known} for f in (0.5, 0.8, 1.25, 2.0)]
    grid.append(("hidden_resonator", tones))
    own = {name for term in fitted.laws.terms for name in (term.name, *term.takes_the_place_of)}
    if fitted.laws.memory:
        own.add("bouc_wen")
    return [(name, inner) for name, inner in grid if name not in own]


def _dominant_hz(trial: DrivenTrial) -> float:
    """Where the recorded velocity has its power's middle, Hz."""
    x = trial.outputs[trial.main]
    power = np.abs(np.fft.rfft((x - x.mean()) * np.hanning(x.size))) ** 2
    f = np.fft.rfftfreq(x.size, 1.0 / trial.rate_hz)
    total = np.cumsum(power * f**2)
    return float(f[int(np.searchsorted(total, 0.5 * total[-1]))]) or trial.rate_hz / x.size


def discover_driven(
    trials: Sequence[DrivenTrial],
    laws: DrivenLaws,
    suspects: Sequence[str] | None = None,
    held_out: Sequence[DrivenTrial] = (),
) -> DrivenFound:
    """The equation's numbers, and which laws it lacks, proved on ``held_out`` trials or on the records' last fifth.

    ``suspects`` names the laws that may be added (None: all that fit, empty: none). Of decays, whose ends are noise,
    nothing is held back.
    """
    trials = sorted(trials, key=lambda trial: trial.free)
    ends = [t.t.size if held_out or t.free else int((1.0 - HELD_BACK) * t.t.size) for t in trials]
    training = [t.part(0, end) for t, end in zip(trials, ends, strict=True)]
    unseen = list(held_out) or [t.part(end, t.t.size) for t, end in zip(trials, ends, strict=True) if not t.free]
    base = fit_driven(training, laws)
    current, lowest = base, validation_rms(unseen, base)
    first, tried, added = lowest, list[Tried](), list[str]()
    family: Contest | None = None
    noise = max(trial.noise()[trial.main] for trial in unseen)
    for _ in range(ROUNDS):
        step = _round(training, unseen, current, lowest, suspects)
        tried += step[0]
        if step[1] is not None:
            current, lowest = step[1], step[2]
            added.append(step[0][-1].name)
        due = step[1] is None or added[-1] in REMEMBERED
        if family is None and due and remembers(current) and lowest > AT_NOISE * noise:
            family = contest(training, unseen, (current, lowest), suspects)
            tried += family.tried
            changed, (current, lowest) = family.fitted is not current, (family.fitted, family.rms)
            added = _names_added(added, base, current)
        elif step[1] is None:
            break
        if step[1] is None and not changed:
            break
    for name in added[:-1]:
        leaner = without_law(training, unseen, current, name, lowest)
        if leaner is not None:
            current, lowest = leaner
            added.remove(name)
    baseline = _on_everything(trials, laws, base)
    augmented = _on_everything(trials, current.started, current) if added else None
    best, lowest = by_stroke(augmented or baseline, (trials, training, unseen), current, lowest)
    baseline, augmented, first = (baseline, best, first) if added else (best, None, lowest)
    kinds = (family.rivals, family.members) if family else ((), {})
    proof = Proof(tuple(unseen), base, current)
    return DrivenFound(baseline, augmented, tuple(added), tuple(tried), (first, lowest), *kinds, proof)


def _names_added(added: Sequence[str], base: DrivenFit, current: DrivenFit) -> list[str]:
    """Laws that were added and still stand, and behind them those that took the place of others."""
    given, now = ({term.name for term in one.laws.terms} for one in (base, current))
    return [*(n for n in added if n in now), *(t.name for t in current.laws.terms if t.name in now - given - {*added})]


def _on_everything(trials: Sequence[DrivenTrial], laws: DrivenLaws, fitted: DrivenFit) -> DrivenFit:
    """A fit of a part, continued on all samples; from ``laws`` anew where its numbers have no bounded motion there."""
    try:
        return fit_driven(trials, fitted.started, windows=0)
    except IdentificationError:
        return fit_driven(trials, laws)


def without_law(
    training: Sequence[DrivenTrial], unseen: Sequence[DrivenTrial], current: DrivenFit, name: str, lowest: float
) -> tuple[DrivenFit, float] | None:
    """The fit without a law, and its rms on unseen samples, where that is no further away than a law must bring it
    closer; else None. What was added first may only have stood in for what was added later."""
    laws = current.started
    kept = {
        field: {key: value for key, value in getattr(laws, field).items() if not key.startswith(f"{name}.")}
        for field in ("starts", "fixed")
    }
    lean = replace(laws, terms=tuple(term for term in laws.terms if term.name != name), **kept)
    try:
        fitted = fit_driven(training, lean, windows=0)
    except IdentificationError:
        return None
    after = validation_rms(unseen, fitted)
    return (fitted, after) if after <= (1.0 + CLOSER) * lowest else None


def _round(
    training: Sequence[DrivenTrial],
    unseen: Sequence[DrivenTrial],
    current: DrivenFit,
    lowest: float,
    suspects: Sequence[str] | None,
) -> tuple[list[Tried], DrivenFit | None, float]:
    """One law more, if one earns it: what was tried (the accepted one last), its fit, its rms on unseen samples."""
    part = training[0].part(0, min(training[0].t.size, RANKED_SAMPLES))
    few = _effective(current) < FEW_EFFECTIVE
    free = [(n, grid) for n, grid in suspects_for(part, current) if suspects is None or n in suspects]
    ranked = sorted(((*_worth(part, current, name, grid), name) for name, grid in free), key=lambda r: -r[0])
    tried: list[Tried] = []
    fits: dict[str, DrivenFit] = {}
    for _, starts, name in ranked[: FITTED_WHERE_FEW if few else FITTED_AT_MOST]:
        try:
            laws = _with(current, name, starts)
            fits[name] = _fitted(training, laws, CONTINUED if name == BoucWen.name else 0)
            if current.rms[training[0].name] > MISSED * float(np.std(training[0].outputs[training[0].main])):
                fits[name] = min(fits[name], fit_driven(training, laws, effort=TRYING), key=lambda f: f.solution.cost)
        except IdentificationError as reason:
            tried.append(Tried(name, -math.inf, lowest, math.inf, str(reason)))
            continue
        tried.append(_judged(name, current, fits[name], unseen, lowest))
    tried = _by_folds(training, current, tried, fits)
    best = min((one for one in tried if not one.because), key=lambda one: one.after, default=None)
    if best is None:
        return tried, None, lowest
    return [*(one for one in tried if one is not best), best], fits[best.name], best.after


def _fitted(training: Sequence[DrivenTrial], laws: DrivenLaws, continued: int) -> DrivenFit:
    """A suspect's fit by `TRYING`, ``continued`` by `FARTHER` while that still takes away `STILL_FALLS` of its cost."""
    fitted = fit_driven(training, laws, windows=0, effort=TRYING)
    for _ in range(continued):
        if not fitted.outcome.startswith(UNFINISHED):
            break
        before, fitted = fitted, fit_driven(training, fitted.started, windows=0, effort=FARTHER)
        if fitted.solution.cost > (1.0 - STILL_FALLS) * before.solution.cost:
            break
    return fitted


def _by_folds(
    training: Sequence[DrivenTrial], current: DrivenFit, tried: Sequence[Tried], fits: Mapping[str, DrivenFit]
) -> list[Tried]:
    """Suspects that came closer to the last part, the closest first, proved on parts left out in turn, up to the first
    that holds."""
    before: Array | None = None
    out: list[Tried] = []
    held = False
    for one in sorted(tried, key=lambda one: one.after):
        if not one.because and held:
            one = replace(one, because="another law comes closer")
        elif not one.because:
            before = fold_errors(training, current.started) if before is None else before
            one = replace(one, because=come_closer(before, fold_errors(training, fits[one.name].started)))
            held = not one.because
        out.append(one)
    return out


def _effective(fitted: DrivenFit) -> float:
    """Samples of a fit's residuals over their memory."""
    return fitted.solution.n_data / max(memory_samples(r) for r in fitted.solution.residuals)


def _with(current: DrivenFit, name: str, starts: Numbers) -> DrivenLaws:
    """The laws with one more; the exponent of a hysteresis stays at one."""
    term = find_driven(name)
    held = {"bouc_wen.exponent": 1.0} if name == BoucWen.name else {}
    laws = current.started
    return replace(
        laws, terms=(*laws.terms, term), starts={**laws.starts, **starts}, fixed={**laws.fixed, **held}
    )


def _judged(
    name: str, current: DrivenFit, fitted: DrivenFit, unseen: Sequence[DrivenTrial], lowest: float
) -> Tried:
    """Evidence of a suspect's fit, and what the last part says of it; ``because`` says why it is not taken."""
    after = validation_rms(unseen, fitted)
    chi2 = (current.solution.chi2, fitted.solution.chi2)
    n = _effective(fitted)
    more = len(fitted.names) - len(current.names)
    evidence = 0.5 * (n * math.log(chi2[0] / chi2[1]) - more * math.log(max(n, 2.0)))
    because = ""
    if not _sound(name, fitted.outcome):
        because = fitted.outcome
    elif beyond := begun_beyond(fitted.solution.problem, fitted.solution.values):
        because = beyond
    elif unsure := _unsure(name, fitted):
        because = unsure
    elif not after < (1.0 - CLOSER) * lowest:
        because = f"unseen samples come no closer: {after:.4g} after {lowest:.4g}"
    return Tried(name, evidence, lowest, after, because)


def _unsure(name: str, fitted: DrivenFit) -> str:
    """Why a law's coefficient may as well be 0, by an error that knows of the residual's memory; empty where not."""
    coefficient = next(term for term in fitted.laws.terms if term.name == name).coefficient
    index = fitted.names.index(f"{name}.{coefficient.name}")
    value, error = float(fitted.values[index]), math.sqrt(max(float(fitted.covariance[index, index]), 0.0))
    if abs(value) > SURE * error:
        return ""
    return f"{coefficient.name} is {value:.3g} +- {error:.2g} {coefficient.unit}, within {SURE:g} standard errors of 0"


def _sound(name: str, outcome: str) -> bool:
    """Whether a fit can be judged: it may stop early, and another law's number may go to its bound, because the new
    law makes that one needless."""
    if outcome.startswith(ON_BOUND):
        return not any(one.startswith(f"{name}.") for one in outcome.removeprefix(ON_BOUND).split(", "))
    return outcome == "ok" or outcome.startswith(UNFINISHED)


def _worth(part: DrivenTrial, current: DrivenFit, name: str, grid: Sequence[Numbers]) -> tuple[float, Numbers]:
    """Cost that a law may take away by one Gauss-Newton step, the best of its grid, and the start values it gives."""
    best: tuple[float, Numbers] = (-math.inf, {})
    drives = {part.name: drive_for(part)}
    for inner in grid:
        term = find_driven(name)
        coefficient = f"{name}.{term.coefficient.name}"
        given = {f"{name}.{key}": value for key, value in inner.items()}
        laws = _with(current, name, {coefficient: 0.0, **given})
        problem = driven_problem([part], replace(laws, fixed={**laws.fixed, **given}), 1, None, drives)
        values = np.array([u.start for u in problem.unknowns])
        got = residuals(problem.trials[0], values)
        if got is None:
            continue
        r, jacobian, used = got
        if not np.all(np.abs(jacobian) < UNBOUNDED):
            continue
        column = [problem.names[j] for j in used].index(coefficient)
        scale = np.sqrt(np.sum(jacobian**2, axis=0))
        if not scale[column] > 0.0:
            continue
        others = [j for j in range(jacobian.shape[1]) if j != column and scale[j] > 0.0]
        without = jacobian[:, others] / scale[others]
        basis = np.linalg.qr(without)[0]
        direction = jacobian[:, column] - basis @ (basis.T @ jacobian[:, column])
        rest = r - basis @ (basis.T @ r)
        size = float(direction @ direction)
        if size <= 1e-10 * scale[column] ** 2:
            continue
        step = -float(direction @ rest) / size
        if not term.coefficient.lower <= step <= term.coefficient.upper:
            continue
        if (gain := step * step * size) > best[0]:
            best = (gain, {coefficient: step, **given, **_moved(problem, jacobian, r, used, step, column)})
    return best


def _moved(
    problem: Problem, jacobian: Array, r: Array, used: np.ndarray, step: float, column: int
) -> dict[str, float]:
    """Where the same step takes the other numbers of the equation."""
    others = [j for j in range(jacobian.shape[1]) if j != column]
    scale = np.sqrt(np.sum(jacobian[:, others] ** 2, axis=0))
    scale[scale == 0.0] = 1.0
    target = -(r + jacobian[:, column] * step)
    moves = np.linalg.lstsq(jacobian[:, others] / scale, target, rcond=1e-10)[0] / scale
    out = {}
    for j, move in zip(others, moves, strict=True):
        unknown = problem.unknowns[used[j]]
        value = unknown.start + float(move)
        sound = unknown.lower <= value <= unknown.upper and (unknown.name != MASS or value > 0.0)
        if "[" not in unknown.name and sound:
            out[unknown.name] = value
    return out
