"""Output error for driven trials: start values, windows, then the whole record as one free run.

The start values that follow the record best over short windows begin the search; it goes on windows with start states
of their own on a part of the record, then on the whole as one motion. Errors of the numbers are those of residuals that
hang together: the covariance is widened by how much longer their memory is than a sample.

Belongs here: that order, errors, the free run that scores. Does not belong here: the search (likelihood/), which laws
(comparison/).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from undertow.conditioning.driven import DrivenTrial
from undertow.equation.driven_laws import felt
from undertow.equation.input import Drive
from undertow.errors import IdentificationError, UndertowError
from undertow.likelihood.driven import MASS, DrivenLaws, drive_for, driven_problem
from undertow.likelihood.driven_strokes import Strokes
from undertow.likelihood.output_error import SearchEffort, Solution, fit, residuals
from undertow.methods.driven_begin import begin_of, begins_held
from undertow.methods.driven_order import must_not_be_swapped
from undertow.methods.driven_start import half_lengths, start_values
from undertow.quantities import OK, Estimate, format_estimate
from undertow.recording.recording import Array

FIRST_SAMPLES = 6000
"""Samples that the windows are laid on at first; a tenth of a long record finds the way as well as all of it."""
WINDOWS = 24
WINDOWS_EFFORT = SearchEffort(25, 0.05, as_left=True)
WHOLE_EFFORT = SearchEffort(40, 0.05, as_left=True)
"""By the noise alone a carriage whose equation misses its motion by a thousand times the noise would be searched for to
the thousandth part of what can be known of it."""
BEGUN_ANEW = 2
"""Times that a start state is taken from the first samples: the second time with numbers that were fitted so."""
CYCLE_SAMPLES = 40
"""A motion that is recorded with many more samples a cycle is fitted to so many first."""
MEMORY_SHARE = 20
"""The residual's memory is summed up to this part of the record."""


@dataclass(frozen=True, eq=False, repr=False)
class DrivenFit:
    """A driven equation with its numbers.

    ``values`` and ``covariance`` (p, p) of the equation's ``names``; ``rms`` of the free run over what was fitted, a
    trial's main output; ``solution`` the search's end with the start states; ``begun`` names the trials whose start
    state was taken from their first samples; ``strokes`` what differs from stroke to stroke, where that was asked.
    """

    laws: DrivenLaws
    names: tuple[str, ...]
    values: Array
    covariance: Array
    rms: Mapping[str, float]
    solution: Solution
    outcome: str
    begun: tuple[str, ...] = ()
    strokes: Strokes | None = None

    @property
    def numbers(self) -> dict[str, float]:
        """Value of every number of the equation, held ones too."""
        return {**self.laws.fixed, **dict(zip(self.names, self.values.tolist(), strict=True))}

    @property
    def estimates(self) -> dict[str, Estimate]:
        """Every fitted number with its standard error and unit."""
        units, errors = self.laws.units, np.sqrt(np.maximum(np.diag(self.covariance), 0.0))
        pairs = zip(self.names, self.values, errors, strict=True)
        return {name: Estimate(float(v), float(e), unit=units.get(name, "")) for name, v, e in pairs}

    def __repr__(self) -> str:
        lines = [f"  {name}  {format_estimate(e)}" for name, e in self.estimates.items()]
        missed = ", ".join(f"{name} {rms:.3g}" for name, rms in self.rms.items())
        doubt = [] if self.outcome == OK else [f"! {self.outcome}"]
        laws = ", ".join(term.name for term in self.laws.terms)
        return "\n".join([laws, *doubt, *lines, f"- rms of the free run over what was fitted: {missed}"])

    @property
    def started(self) -> DrivenLaws:
        """The laws with these numbers as their starts."""
        return replace(self.laws, starts={**self.laws.starts, **self.numbers})


def fit_driven(
    trials: Sequence[DrivenTrial],
    laws: DrivenLaws,
    drives: Mapping[str, Drive] | None = None,
    windows: int = WINDOWS,
    effort: SearchEffort = WHOLE_EFFORT,
) -> DrivenFit:
    """The equation's numbers from driven trials by output error.

    ``laws.starts`` hold start values (none: from the first trial that is driven, for laws that are linear in their
    numbers); decays of the same body, which nothing drives, count beside trials that are driven.
    ``windows`` 0 goes to the whole record at once, ``effort`` is how far the search on it goes. Raises
    IdentificationError where no start has a bounded motion, or no trial is driven.
    """
    if all(trial.free for trial in trials):
        raise IdentificationError(
            f"nothing drives any of {len(trials)} trials: decays alone are fitted without an input; leave the input out"
        )
    coarse = _coarse(trials, laws, windows, effort)
    if coarse is not None:
        laws, windows = coarse.started, 0
    drives = {**(drives or {})}
    for trial in trials:
        drives.setdefault(trial.name, drive_for(trial))
    laws = anchored(trials, replace(laws, fixed={**laws.usual, **laws.fixed}))
    laws = laws if MASS in laws.starts else _own_starts(next(t for t in trials if not t.free), laws, drives)
    noise = {trial.name: trial.noise() for trial in trials}
    if windows:
        shorter = [t.part(0, min(t.t.size, FIRST_SAMPLES)) for t in trials]
        laws = _on_windows(shorter, laws, windows, noise, drives)
    known = coarse.begun if coarse is not None else ()
    begun = {
        t.name: dict(begin_of(t, laws, {**laws.fixed, **laws.starts}, drives[t.name], noise=noise[t.name]).state)
        for t in trials if t.name in known
    }  # fmt: skip
    solution = fit(driven_problem(trials, laws, 1, noise, drives, None, begun), growing=False, effort=effort)
    for _ in range(BEGUN_ANEW):
        numbers = {**laws.fixed, **{n: solution.value(n) for n in solution.problem.names if "[" not in n}}
        found = begins_held(trials, laws, numbers, drives, solution, noise, begun)
        if not found or found.keys() <= {*known}:
            break
        begun |= found
        again = driven_problem(trials, replace(laws, starts={**laws.starts, **numbers}), 1, noise, drives, None, begun)
        solution = fit(again, growing=False, effort=effort)
    return replace(_fitted(trials, laws, solution, noise), begun=tuple(begun))


def _coarse(trials: Sequence[DrivenTrial], laws: DrivenLaws, windows: int, effort: SearchEffort) -> DrivenFit | None:
    """The fit to fewer samples of slow motions, which finds the way for less; None where none can be spared.

    Where bodies stick the cost is rough, and half of the steps lead up: here they cost little.
    """
    if not windows or any(trial.mover != "force" for trial in trials):
        return None
    steps = min(trial.slowness(CYCLE_SAMPLES) for trial in trials)
    if steps < 2:
        return None
    try:
        return fit_driven([trial.thinned(steps) for trial in trials], laws, None, windows, effort)
    except UndertowError:
        return None  # all samples may do


def anchored(trials: Sequence[DrivenTrial], laws: DrivenLaws) -> DrivenLaws:
    """The laws with a mass of 1 where base or water alone drives and no number that forces go with is known: then every
    force is per mass, because motion says nothing of their size.

    Raises IdentificationError where added mass is asked for beside it, not distinct from the body's own, and where
    water moves that no law feels.
    """
    movers = {trial.mover for trial in trials}
    if movers == {"water"} and not any(felt(term) for term in laws.terms):
        raise IdentificationError(
            f"the water moves, and none of {', '.join(t.name for t in laws.terms)} feels it, so that nothing drives "
            "the body; add froude_krylov (rho V u'), quadratic_drag or linear_damping to the equation"
        )
    if "force" in movers:
        return laws
    sizes = {MASS, *(f"{term.name}.{term.coefficient.name}" for term in laws.terms)}
    known = sizes & {*laws.fixed, *laws.priors}
    if any(term.is_inertia for term in laws.terms) and (MASS not in known or len(known) < 2):
        raise IdentificationError(
            f"added mass beside motion of the {' and the '.join(sorted(movers))} alone, with {len(known)} forces "
            "known: M and m_a act as one, and every force is per their sum; give specimen.mass_kg and "
            "specimen.stiffness_N_per_m, or leave added_mass out"
        )
    return laws if known else replace(laws, fixed={**laws.fixed, MASS: 1.0})


def _own_starts(trial: DrivenTrial, laws: DrivenLaws, drives: Mapping[str, Drive]) -> DrivenLaws:
    """Start values from the record, those of the test function whose motion follows short windows best."""
    short = trial.part(0, min(trial.t.size, FIRST_SAMPLES))
    must_not_be_swapped(trial)
    linear = tuple(term for term in laws.terms if term.kind != "state")
    coefficients = {MASS: MASS, **{f"{t.name}.{t.coefficient.name}": t.name for t in linear}}
    held = {coefficients[name]: value for name, value in laws.fixed.items() if name in coefficients}
    best, lowest = None, math.inf
    for half in half_lengths(trial.t.size):
        found = start_values(trial, linear, half, held)
        if not found[MASS] > 0.0:
            continue
        tried = replace(laws, starts={**_named(laws, found), **laws.starts})
        cost = window_cost(short, tried, drives)
        if cost < lowest:
            best, lowest = tried, cost
    if best is None:
        raise IdentificationError(
            f"trial {trial.name}: no test function gives a positive mass with {', '.join(t.name for t in laws.terms)}; "
            "give start values, turn the input's sign, or check that input and output are not swapped"
        )
    return best


def _named(laws: DrivenLaws, found: Mapping[str, float]) -> dict[str, float]:
    """Start values by the unknowns' names, inside their bounds."""
    out = {MASS: found[MASS]}
    for place in laws.places:
        if place.parameter.name == place.term.coefficient.name and place.term.name in found:
            out[place.name] = min(max(found[place.term.name], place.parameter.lower), place.parameter.upper)
    return out


def window_cost(trial: DrivenTrial, laws: DrivenLaws, drives: Mapping[str, Drive]) -> float:
    """Mean squared residual of free runs over windows that start from the samples, with the laws' start values."""
    problem = driven_problem([trial], laws, WINDOWS, None, drives)
    values = np.array([u.start for u in problem.unknowns])
    total, count = 0.0, 0
    for piece in problem.trials:
        got = residuals(piece, np.clip(values, *problem.bounds))
        if got is None or not np.all(np.isfinite(got[0])):
            return math.inf
        total, count = total + float(got[0] @ got[0]), count + got[0].size
    return total / count


def _on_windows(
    trials: Sequence[DrivenTrial],
    laws: DrivenLaws,
    windows: int,
    noise: Mapping[str, Mapping[str, float]],
    drives: Mapping[str, Drive],
) -> DrivenLaws:
    """The laws with the numbers that windows give as their starts; half as many windows each time."""
    while windows > 1:
        solution = fit(driven_problem(trials, laws, windows, noise, drives), growing=False, effort=WINDOWS_EFFORT)
        found = {name: solution.value(name) for name in solution.problem.names if "[" not in name}
        laws = replace(laws, starts={**laws.starts, **found})
        windows //= 6
    return laws


def _fitted(
    trials: Sequence[DrivenTrial], laws: DrivenLaws, solution: Solution, noise: Mapping[str, Mapping[str, float]]
) -> DrivenFit:
    """Numbers and their covariance, widened for residuals with a memory and larger than the noise."""
    own = [i for i, name in enumerate(solution.problem.names) if "[" not in name]
    widening, rms = 1.0, {}
    total, count, memory = 0.0, 0, 1.0
    for trial, r in zip(trials, solution.residuals, strict=True):
        n = trial.t.size
        main = list(trial.outputs).index(trial.main)
        seen = r[main * n : (main + 1) * n]
        rms[trial.name] = float(np.sqrt(np.mean(seen**2))) * noise[trial.name][trial.main]
        memory = max(memory, memory_samples(seen))
        total, count = total + float(r @ r), count + r.size
    widening = total / max(count - len(own), 1) * memory
    return DrivenFit(
        laws, tuple(solution.problem.names[i] for i in own), solution.values[own],
        solution.covariance[np.ix_(own, own)] * widening, rms, solution, solution.outcome,
    )  # fmt: skip


def memory_samples(residual: Array) -> float:
    """How many samples of a residual say as much as one that has no memory (1: white).

    The sum of autocorrelations up to where they first vanish, both ways.

    >>> memory_samples(np.ones(100) * np.resize([1.0, -1.0], 100))
    1.0
    """
    x = residual - float(np.mean(residual))
    n = x.size
    spectrum = np.fft.rfft(x, 2 * n)
    correlation = np.fft.irfft(np.abs(spectrum) ** 2)[: max(2, n // MEMORY_SHARE)]
    if not correlation[0] > 0.0:
        return 1.0
    correlation = correlation / correlation[0]
    below = np.flatnonzero(correlation <= 0.0)
    return float(1.0 + 2.0 * np.sum(correlation[1 : below[0] if below.size else None]))


def free_run(trial: DrivenTrial, fitted: DrivenFit, start: int) -> Array:
    """The motion of the trial's main output (n,) from its first ``start`` samples alone: x0, v0 (and z0) fitted there.

    Raises IdentificationError where the motion leaves every bound.
    """
    drive = drive_for(trial)
    begin = begin_of(trial, fitted.laws, fitted.numbers, drive, start)
    return motion_from(trial, fitted.laws, fitted.numbers, begin.state, drive)


def motion_from(
    trial: DrivenTrial, laws: DrivenLaws, numbers: Mapping[str, float], state: Mapping[str, float], drive: Drive
) -> Array:
    """The motion of the trial's main output (n,) with those numbers from a start state (by slot)."""
    from undertow.equation.driven import driven_motion
    from undertow.likelihood.output_error import parameter_vector

    held = replace(laws, fixed=dict(numbers))
    piece = driven_problem([trial], held, 1, None, {trial.name: drive}, None, {trial.name: state}).trials[0]
    theta = parameter_vector(piece, np.zeros(0))
    motion = driven_motion(theta, np.zeros(0, dtype=np.int64), drive, piece.t, piece.extent)
    column = {"displacement": motion.x, "velocity": motion.v, "acceleration": motion.a}[trial.main]
    return np.array(column[:, 0])
