"""The proof: does the addition bring trials closer that no fit has seen, and does physics allow it?

Belongs here: free runs on held-out trials before and after, and the check of a slosh mode against its cell. Does not
belong here: finding the addition (search.py).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from undertow.comparison.clock import parts_of
from undertow.comparison.deviations import learned_mean, unit_of
from undertow.comparison.joint import JointFit, its_drift, its_own, shared_theta
from undertow.comparison.level import Addend, Level, Member, full_name, seen_by
from undertow.comparison.suspect import HOOK
from undertow.conditioning.motion import Motion
from undertow.discrepancy.case import Case
from undertow.discrepancy.findings import AugmentedRun
from undertow.discrepancy.verdict import PhysicalCheck
from undertow.equation.registry import row
from undertow.errors import IdentificationError
from undertow.likelihood.free_run import FreeRun, free_run
from undertow.likelihood.scale import contract_name
from undertow.quantities import Estimate
from undertow.recording.recording import Array
from undertow.uncertainty.repeats import mean_of_trials

STANDARD_GRAVITY_M_PER_S2 = 9.81

FINITE_AMPLITUDE_MARGIN = 0.05
"""Relative error within which a frequency still counts as above its lower bound: finite amplitude and the fit."""

SOFTENING_RATIO = 0.34
"""Depth over width above which sloshing softens with amplitude, below which it hardens (Tadjbakhsh and Keller 1960)."""


def score(level: Level, member: Member, fit: JointFit, motion: Motion, rest_std: float) -> float:
    """nrmse of one trial's free run with what all trials share; nan where there is no motion."""
    run = shared_run(level, member, fit, motion, rest_std)
    return math.nan if run is None else run.nrmse


def shared_run(level: Level, member: Member, fit: JointFit, motion: Motion, rest_std: float) -> FreeRun | None:
    """One trial's free run with what all trials share, k, c, mu as dry trials and these say; None where there is no
    motion.

    What every trial has of its own (an outside force's size and phase) is fitted to it, unseen or not.
    """
    try:
        theta = shared_theta(level, member, fit, motion.name, learned=True)
        return free_run(seen_by(fit.addends, motion), theta, rest_std, its_own(fit), drift=its_drift(fit, motion))
    except IdentificationError:
        return None


def learned_structure(member: Member, fit: JointFit) -> dict[str, Estimate]:
    """The structure's k, c, mu as dry trials and those in water together say, by their names in the contract: with
    these the free runs of what is named were made."""
    fixed, found = member.model.fixed, {}
    for term in () if fixed is None else member.model.terms:
        learned = learned_mean(member, fit.solution, term.structural)
        if learned is not None:
            key, unit, per_force = contract_name(term.name, member.model.specimen)
            found[key] = learned.scaled(per_force * unit_of(member, term.structural), unit)
    return found


def rms(values: Sequence[float]) -> float:
    """Root mean square of the finite values; nan without one."""
    finite = [v for v in values if math.isfinite(v)]
    return math.sqrt(float(np.mean(np.square(finite)))) if finite else math.nan


def median_error(values: Sequence[float]) -> float:
    """Median of the finite values, nan without one: what a group's trials miss, before and after, and what they may."""
    finite = [v for v in values if math.isfinite(v)]
    return float(np.median(finite)) if finite else math.nan


@dataclass(frozen=True)
class Closeness:
    """How far what is named reaches on a level: how many repeatabilities its training trials are away with it, and the
    share of the squared error of unseen trials that it explains (nan where there are none); ``unseen``: the error of
    the group's own unseen trials where an outside force is named, its size and phase fitted to each (else nan)."""

    away: float = 0.0
    explained: float = math.nan
    unseen: float = math.nan


NEAR = Closeness()
"""What reaches all trials."""


def error_of(motions: Iterable[Motion], runs: Mapping[str, AugmentedRun]) -> float:
    """What a typical one of these trials misses; nan where none has a free run."""
    return median_error([runs[m.name].nrmse for m in motions if m.name in runs])


def reach(cases: Sequence[Case], mine: Case, runs: Mapping[str, AugmentedRun], forced: bool) -> Closeness:
    """How far what is named reaches on the level's trials, in their groups' repeatabilities, and on those of one group
    (``mine``) that it never saw, where an outside force is named (``forced``); trials of a group by their median, as
    what the equation misses alone."""
    own = [error_of(case.member.motions, runs) / case.allowed for case in cases]
    told = [(case, error_of(case.held, runs)) for case in cases]
    pairs = [(case.baseline.held_out_nrmse / case.allowed, after / case.allowed) for case, after in told]
    before, after = (rms([pair[i] for pair in pairs if np.all(np.isfinite(pair))]) for i in (0, 1))
    unseen = next(error for case, error in told if case is mine) if forced else math.nan
    return Closeness(rms(own), 1.0 - (after / before) ** 2 if before > 0.0 else math.nan, unseen)


def kernel_damping(fit: JointFit, addend: Addend, rate: float) -> Estimate:
    """Linear damping that a kernel amounts to for a body that swings at ``rate`` (rad/s), N s/m.

    c(W) = -W Im[m (w^2 + 2 i z w W) / (w^2 - W^2 + 2 i z w W)]: the real part of its force on the velocity. The error
    is that of m, w, z by their covariance.
    """
    names = [f"{addend.prefix}.{a.name}" for a in addend.additions[:3]]

    def damping(numbers: Array) -> float:
        mass, w, z = numbers
        stiff = w**2 + 2j * z * w * rate
        return float(-rate * (mass * stiff / (stiff - rate**2)).imag)

    return _follows(fit, names, damping, "N s/m")


def _follows(fit: JointFit, names: Sequence[str], of: Callable[[Array], float], unit: str) -> Estimate:
    """A number that follows from several unknowns, with its error by their covariance."""
    index = [fit.solution.problem.names.index(n) for n in names]
    values = fit.solution.values[index]
    steps = 1e-4 * np.where(values == 0.0, 1.0, np.abs(values))
    ways = zip(steps, np.eye(len(names)), strict=True)
    slope = np.array([(of(values + h * e) - of(values - h * e)) / (2.0 * h) for h, e in ways])
    variance = float(slope @ fit.solution.covariance[np.ix_(index, index)] @ slope)
    return Estimate(of(values), math.sqrt(max(variance, 0.0)), 0.0, unit, "joint fit")


def _of_slots(fit: JointFit, addend: Addend, spring: str) -> dict[str, Estimate]:
    """Parameters of the added law that are no unknowns of the fit but follow from them: the displacement at which a
    hysteresis yields, from force and stiffness."""
    law = row(addend.prefix.split("#")[0])
    names = {a.slot: full_name(addend.prefix, a, spring, "") for a in addend.additions}
    if law is None or not set(names.values()) <= set(fit.solution.problem.names):
        return {}
    values = {slot: fit.value(name) for slot, name in names.items()}
    units = {p.name: p.unit for p in law.parameters}

    def of(key: str) -> Callable[[Array], float]:
        return lambda numbers: law.of_slots(dict(zip(names, numbers.tolist(), strict=True)))[key]

    return {key: _follows(fit, [*names.values()], of(key), units[key]) for key in law.of_slots(values)}


def addition_parameters(fit: JointFit, spring: str, rate: float = math.nan) -> dict[str, list[dict[str, Estimate]]]:
    """What was added, by name: one dictionary a time it was added, parameter -> estimate, for one spring whose body
    swings at ``rate`` (rad/s)."""
    found: dict[str, list[dict[str, Estimate]]] = {}
    for addend in fit.addends:
        numbers = _of_trials(fit, addend)
        for a in addend.additions:
            if a.scope == "trial":
                continue
            name = full_name(addend.prefix, a, spring, "")
            if name not in fit.solution.problem.names:
                continue
            value, error = fit.value(name), fit.solution.stderr(name)
            on_bound = value <= a.lower or value >= a.upper
            outcome = f"{name} on its bound {value:.4g} {a.unit}" if on_bound else "ok"
            numbers[a.name] = Estimate(value, math.nan if on_bound else error, 0.0, a.unit, "joint fit", outcome)
        numbers |= _of_slots(fit, addend, spring)
        if "kernel_mass_kg" in numbers:
            numbers = {"c_Ns_per_m": kernel_damping(fit, addend, rate), **numbers}
        found.setdefault(addend.prefix.split("#")[0], []).append(numbers)
    return found


_SAYS = {
    "acceleration_shift_s": ("shift_s", "s", 0.0, -1.0),
    "acceleration_gain": ("gain", "1", 1.0, 1.0),
    "drift_m": ("drift_m", "m", 0.0, 1.0),
}
"""What a freed nuisance says in a verdict: its name, unit, and value = first + factor x nuisance (a channel that is
late has a positive shift; its clock is read earlier in the fit)."""


def _of_trials(fit: JointFit, addend: Addend) -> dict[str, Estimate]:
    """What differs from trial to trial: the mean over trials of a sensor's error or of a force's amplitude, the
    largest speed at a release."""
    names = fit.solution.problem.names
    if addend.frees:
        label, unit, first, factor = _SAYS[addend.frees]
        mean = _mean_of(fit, addend.frees, unit)
        return {label: Estimate(first + factor * mean.value, mean.stderr, 0.0, unit, "joint fit")}
    prefix = f"{addend.prefix}.velocity_m_per_s["
    speeds = [Estimate(fit.value(n), fit.solution.stderr(n), 0.0, "m/s", n) for n in names if n.startswith(prefix)]
    if speeds:
        return {"velocity_m_per_s": max(speeds, key=lambda e: abs(e.value))}
    for a in (a for a in addend.additions if a.slot == HOOK):
        return {a.name: _mean_of(fit, f"{addend.prefix}.{a.name}", a.unit)}
    for a in (a for a in addend.additions if a.differs):
        mine = [n for n in names if n.startswith(f"{addend.prefix}.{a.name}[")]
        return {a.name: Estimate(*fit.apart(mine), 0.0, a.unit, "larger and smaller trials")}
    return {"amplitude_N": _mean_amplitude(fit, addend)} if addend.has_its_own_clock else {}


def _mean_of(fit: JointFit, name: str, unit: str) -> Estimate:
    """Mean over trials of what each has of its own by that name."""
    mine = [n for n in fit.solution.problem.names if n.startswith(f"{name}[")]
    return mean_of_trials([Estimate(fit.value(n), fit.solution.stderr(n), unit=unit) for n in mine], unit, "trials")


def _mean_amplitude(fit: JointFit, force: Addend) -> Estimate:
    """A force's amplitude, in the middle of each trial, the mean over trials: its error is what the trials differ by,
    and no less than the fit's own, in which a sensor's gain is off by the same in all of them."""
    found = [parts_of(fit, force, trial.name) for trial in fit.solution.problem.trials]
    index = [place for places, _ in found for place in places]
    parts = [counts @ fit.solution.values[places] for places, counts in found]
    sizes = np.hypot(*np.array(parts).T)
    slope = np.concatenate([
        part @ counts / max(size, 1e-300) / sizes.size
        for part, size, (_, counts) in zip(parts, sizes, found, strict=True)
    ])  # fmt: skip
    stated = math.sqrt(max(float(slope @ fit.solution.covariance[np.ix_(index, index)] @ slope), 0.0))
    differ = float(np.std(sizes, ddof=1)) / math.sqrt(sizes.size) if sizes.size > 1 else math.nan
    return Estimate(float(np.mean(sizes)), max(differ, stated), 0.0, "N", "mean of trials")


def closed_cell_frequency(width_m: float, depth_m: float, mode: int = 1) -> float:
    """Natural frequency of water in a closed rectangular cell, rad/s: w^2 = g k tanh(k h), k = mode pi / width.

    Lamb 1932, section 257.

    >>> round(closed_cell_frequency(0.31, 0.12), 2)
    9.13
    """
    k = mode * math.pi / width_m
    return math.sqrt(STANDARD_GRAVITY_M_PER_S2 * k * math.tanh(k * depth_m))


def check_cell(frequency: Estimate, cell: Mapping[str, float]) -> PhysicalCheck:
    """A resonator's frequency against its cell: the closed cell is the lower bound, an open bottom raises it.

    ``cell`` has surface_width_m and depth_m (nan where not stated: nothing is checked).
    """
    width, depth = cell.get("surface_width_m", math.nan), cell.get("depth_m", math.nan)
    if not (math.isfinite(width) and math.isfinite(depth) and width > 0.0 and depth > 0.0):
        nothing = "the config states no cell with a free surface at this level"
        return PhysicalCheck(found=frequency.value, because=nothing)
    bound = closed_cell_frequency(width, depth)
    shift = "softens" if depth / width > SOFTENING_RATIO else "hardens"
    error = frequency.stderr if math.isfinite(frequency.stderr) else 0.0
    margin = FINITE_AMPLITUDE_MARGIN * bound + 2.0 * error
    agrees = frequency.value > bound - margin
    side = "at or above" if agrees else "below"
    because = (
        f"a closed cell {width:.3g} m wide and {depth:.3g} m deep oscillates at {bound:.3g} rad/s; an open bottom "
        f"raises it, amplitude {shift} it; found {frequency.value:.3g} rad/s, {side} that bound"
    )
    return PhysicalCheck(bound, frequency.value, agrees, because)
