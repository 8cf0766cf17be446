"""Instrumental variables for a body in closed loop: numbers by a signal that no noise of it reaches.

Where a controller makes the force of what a sensor says, the recorded force answers to everything that the equation
leaves out, and an estimate by the motion's own columns may be drawn to one side. The equation in weak form (rows j of
<w, law(x, v)>, driven_start.py) is then solved against columns Z of a motion that the instrument alone explains:

    sum_j Z_j (Phi_j theta - y_j) = 0,    theta = (Z' Phi)^-1 Z' y

The instrument, delayed and scaled to x, stands for the motion, and the laws at that motion are Z. It is one signal with
three numbers on purpose: each further one that is fitted to x brings a part of the noise back (Soderstrom and Stoica
1989, System identification, ch. 8 and 10; for robots Janot, Vandanjon and Gautier 2014,
doi:10.1109/TCST.2013.2246163). Errors are those of blocks of the record (Liang and Zeger 1986,
doi:10.1093/biomet/73.1.13), widened for few blocks.

Solved against its own columns the same equation is SINDy with a measured input (weak SINDy: Messenger and Bortz 2021,
doi:10.1016/j.jcp.2021.110525), over bumps of the length whose numbers follow the record best in free runs over windows.
Inner numbers of laws, gain and delay of the input are those of output error. Noise of x makes columns larger than they
are, so that numbers of a noisy record are drawn to 0.

Belongs here: these estimates, the first one's comparison with output error. Does not belong here: files, words.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import t as student

from undertow.conditioning.driven import DrivenTrial
from undertow.equation.term import Term
from undertow.errors import IdentificationError
from undertow.likelihood.driven import MASS, against_base, drive_for
from undertow.methods.driven import FIRST_SAMPLES, DrivenFit, memory_samples, window_cost
from undertow.methods.driven_start import half_lengths, row_step, weak_form
from undertow.quantities import Estimate
from undertow.recording.recording import Array

APART = 2.0
"""Standard errors of the difference from which on two estimates are said to be apart."""
BLOCKS = 20
"""Blocks of a record whose scatter gives the errors, at most."""
FEWEST_BLOCKS = 6
MEMORIES_A_BLOCK = 4.0
"""A block is at least so many memories of the residual long, so that blocks hang together little."""
LONGEST_DELAY_SHARE = 0.02
"""The longest delay of a loop that is tried, as a share of the record; delays are 0 and powers of two of a sample."""
SLOPE_SHARE = 4
"""Part of it over which velocities are taken to find the delay."""
WEAK_SHARE = 0.1
"""Share of the velocity's power that an instrument must explain: below it its errors say too little of themselves."""
STRONG_SHARE = 0.5
"""Share that the instruments must explain of every combination of an equation's columns, for bumps of that length:
where noise is more of a column than its instrument, errors of a ratio mean little (Staiger and Stock 1997)."""
STANDING_SHARE = 0.05
"""Share of the largest speed below which a body may stick: a force that jumps with the direction is not known there."""
JUMPS_SHARE = 1e-3
"""A law jumps at a reversal where its force does so by this share of its size at full speed."""
SHORTEST_HALF = 8
"""Half length of the shortest bump, samples: shorter ones are sums of a few samples, not integrals."""
ROWS_A_NUMBER = 10

Numbers = dict[str, tuple[float, float]]
"""Value and standard error by name."""


@dataclass(frozen=True)
class BesideInstrument:
    """Both estimates of each number by name, and the share of the velocity's power that the instrument explains."""

    trial: str
    output_error: dict[str, Estimate]
    instrument: dict[str, Estimate]
    strength: float

    @property
    def apart(self) -> dict[str, float]:
        """How far the estimates of each number are apart, in standard errors of their difference.

        Both errors are added as if independent: they come from one record, so that the true error of the difference is
        smaller and the rule is a careful one.
        """
        out = {}
        for name, one in self.instrument.items():
            other = self.output_error[name]
            out[name] = abs(one.value - other.value) / math.hypot(one.stderr, other.stderr)
        return out

    @property
    def sentence(self) -> str:
        """What is to be said where numbers are more than `APART` standard errors apart; empty where none are."""
        far = [name for name, size in self.apart.items() if size > APART]
        if not far:
            return ""
        told = "; ".join(
            f"{name} is {self.output_error[name]} by output error and {self.instrument[name]} by the instrument, "
            f"{self.apart[name]:.2g} standard errors apart"
            for name in far
        )
        return (
            f"trial {self.trial} runs in closed loop, and its force answers to what the equation leaves out: {told}; "
            "take the instrument's numbers, and look for what is missing"
        )


def beside_instrument(trial: DrivenTrial, fitted: DrivenFit) -> BesideInstrument:
    """The numbers of a fit by output error, beside those that the trial's instrument gives for the same equation.

    Inner numbers of laws, the input's gain and its delay are held at the fit's. Raises IdentificationError where the
    trial has no instrument or one that explains too little, its input is no force, its displacement was not recorded,
    a law has a state of its own, or too few rows are left.
    """
    terms = _explicit_laws(trial, fitted)
    copy, strength = motion_of_instrument(trial)
    if strength < WEAK_SHARE:
        raise IdentificationError(
            f"trial {trial.name}: the instrument explains {100.0 * strength:.2g} % of the velocity's power, under "
            f"{100.0 * WEAK_SHARE:g} %; map the controller's target"
        )
    alone = replace(trial, outputs={"displacement": trial.outputs["displacement"]})
    found = regressed(alone, fitted, terms, {"displacement": copy})
    if found is None:
        raise IdentificationError(
            f"trial {trial.name}: where the instrument moves, {1 + len(terms)} numbers are not told apart; give a "
            "longer record, with motion both ways and at several speeds"
        )
    known = fitted.estimates
    return BesideInstrument(trial.name, {name: known[name] for name in found}, found, strength)


def regressed(
    trial: DrivenTrial,
    fitted: DrivenFit,
    terms: tuple[Term, ...],
    motion: Mapping[str, Array],
    cost: Callable[[Mapping[str, float]], float] | None = None,
) -> dict[str, Estimate] | None:
    """The mass and each law's coefficient by the equation in weak form, solved against the same laws at ``motion``;
    held ones, gain and delay are the fit's. Of the bumps' lengths that one is taken whose numbers have the least
    ``cost``; without one, which knows them best. None where no bump tells the numbers apart at a finite cost.

    A sum over samples has the integral of w x'' exactly, but not that of w u where u is straight in between: its
    corners lie (w dt)^2 / 12 beyond it, which a weight of 1/12 to each neighbour takes away.
    """
    numbers = fitted.numbers
    delay = numbers.get("input_delay_s", 0.0)
    u = trial.u if delay == 0.0 else drive_for(trial).at(trial.t - delay)
    if trial.mover == "force" and trial.hold == "first":
        padded = np.concatenate([u[:1], u, u[-1:]])
        u = (padded[:-2] + 10.0 * padded[1:-1] + padded[2:]) / 12.0
    felt = replace(trial, u=numbers.get("input_gain", 1.0) * u)
    coefficients = {MASS: MASS, **{term.name: f"{term.name}.{term.coefficient.name}" for term in terms}}
    held = {short: numbers[name] for short, name in coefficients.items() if name in fitted.laws.fixed}
    shadow = replace(felt, outputs=motion)
    tried = [_by_bumps(felt, shadow, terms, half, held) for half in half_lengths(trial.t.size)]

    def cost_of(found: Numbers) -> float:
        """Cost of the numbers by their full names."""
        return log_errors(found) if cost is None else cost({coefficients[k]: v for k, (v, _) in found.items()})

    best = _surest([found for found in tried if found is not None], cost_of)
    if best is None:
        return None
    units = fitted.laws.units
    return {
        coefficients[short]: Estimate(value, error, unit=units[coefficients[short]])
        for short, (value, error) in best.items()
    }


def log_errors(found: Numbers) -> float:
    """Sum of the logarithms of all errors."""
    return sum(math.log(error) for _, error in found.values())


def _surest(tried: list[Numbers], cost_of: Callable[[Numbers], float]) -> Numbers | None:
    """The numbers of least cost, with errors that hold what the surer one of the next lengths says otherwise: sums over
    samples are no integrals, and a motion sampled coarsely shows it there. None where none has a finite cost."""
    costs = [cost_of(found) for found in tried]
    if not any(math.isfinite(cost) for cost in costs):
        return None
    place = int(np.argmin(costs))
    best, beside = tried[place], [*tried[max(place - 1, 0) : place], *tried[place + 1 : place + 2]]
    if not beside:
        return best
    other = min(beside, key=log_errors)
    return {name: (value, math.hypot(error, value - other[name][0])) for name, (value, error) in best.items()}


def _explicit_laws(trial: DrivenTrial, fitted: DrivenFit) -> tuple[Term, ...]:
    """The fit's laws with its inner numbers; IdentificationError where these or the trial do not lend themselves."""
    if trial.instrument is None:
        raise IdentificationError(f"trial {trial.name} has no instrument; map channels.instrument")
    if trial.mover != "force" or "displacement" not in trial.outputs:
        have = f"{trial.quantity} and {', '.join(trial.outputs)}"
        raise IdentificationError(
            f"trial {trial.name} has {have}; an instrument serves a force and a displacement alone: leave it out"
        )
    states = [term.name for term in fitted.laws.terms if term.kind != "force" and term.relative_to != "earth"]
    if states:
        raise IdentificationError(
            f"trial {trial.name}: {', '.join(states)} has a state of its own, which no instrument shows; compare the "
            "equation without it"
        )
    return with_inner_numbers(fitted)


def with_inner_numbers(fitted: DrivenFit) -> tuple[Term, ...]:
    """The fit's laws with the inner numbers that it found."""
    numbers = fitted.numbers
    return tuple(
        replace(term, **{name: numbers[f"{term.name}.{name}"] for name in term.inner}) for term in fitted.laws.terms
    )


def motion_of_instrument(trial: DrivenTrial) -> tuple[Array, float]:
    """The displacement (n,) that the instrument and its past explain, and the share of the velocity's power in it."""
    if trial.instrument is None:
        raise IdentificationError(f"trial {trial.name} has no instrument; map channels.instrument")
    x, r = trial.outputs["displacement"], trial.instrument
    longest = max(1, int(LONGEST_DELAY_SHARE * x.size))
    step = max(1, longest // SLOPE_SHARE)
    seen, given = (values[step:] - values[:-step] for values in (x, r))
    delays = [0, *(2**i for i in range(longest.bit_length()))]
    inside = [float(np.corrcoef(seen[d:], given[: given.size - d])[0, 1]) ** 2 for d in delays]
    delay = delays[int(np.argmax(inside))]
    late = np.concatenate([np.full(delay, r[0]), r[: r.size - delay]])
    slope, level = np.polyfit(late, x, 1)
    return np.asarray(slope * late + level), max(inside)


def _by_bumps(
    trial: DrivenTrial, copy: DrivenTrial, terms: tuple[Term, ...], half: int, held: dict[str, float]
) -> Numbers | None:
    """Value and standard error of the mass and each law's coefficient by bumps of that half length; None where too few
    rows are left or the instrument does not tell the numbers apart."""
    if half < SHORTEST_HALF:
        return None
    columns, response = weak_form(trial, terms, half)
    shadow, _ = weak_form(copy, terms, half)
    free = [name for name in columns if name not in held]
    y = response - sum((held[name] * columns[name] for name in held), 0.0 * response)
    phi = np.column_stack([columns[name] for name in free])
    z = np.column_stack([shadow[name] for name in free])
    kept = _moving(copy, terms, half, y.size)
    if np.count_nonzero(kept) < ROWS_A_NUMBER * len(free):
        return None
    phi, z, y = phi * kept[:, None], z * kept[:, None], y * kept
    size, scale = np.sqrt(np.mean(phi**2, axis=0)), np.sqrt(np.mean(z**2, axis=0))
    if not (np.all(size > 0.0) and np.all(scale > 0.0)):
        return None
    phi, z = phi / size, z / scale
    cross = z.T @ phi
    if explained(phi, z) < STRONG_SHARE:
        return None
    values = np.linalg.solve(cross, z.T @ y)
    left = z * (y - phi @ values)[:, None]
    errors = _block_errors(np.linalg.inv(cross), left, y - phi @ values)
    found = zip(free, values / size, errors / size, strict=True)
    return {name: (float(value), float(error)) for name, value, error in found}


def explained(phi: Array, z: Array) -> float:
    """Share of the power of the columns ``phi`` (m, p) that the instruments ``z`` (m, p) explain, of the combination of
    columns that they explain least: the smallest canonical correlation, squared.

    >>> x = np.eye(4)[:, :2]
    >>> float(explained(x, 3.0 * x)), float(explained(x, np.eye(4)[:, 1:3]))
    (1.0, 0.0)
    """
    if min(np.linalg.matrix_rank(phi), np.linalg.matrix_rank(z)) < phi.shape[1]:
        return 0.0
    between = np.linalg.qr(phi)[0].T @ np.linalg.qr(z)[0]
    return float(np.linalg.svd(between, compute_uv=False)[-1]) ** 2


def _block_errors(inverse: Array, left: Array, residual: Array) -> Array:
    """Standard errors (p,) from sums of ``left`` (m, p), instruments times residuals, over blocks of the record."""
    rows, many = left.shape
    longest = MEMORIES_A_BLOCK * memory_samples(residual)
    blocks = int(min(max(rows / longest, FEWEST_BLOCKS, many + 2), BLOCKS))
    edges = np.linspace(0, rows, blocks + 1).astype(int)[:-1]
    sums = np.add.reduceat(left, edges, axis=0)
    covariance = inverse @ (sums.T @ sums) @ inverse.T * blocks / (blocks - 1)
    few = float(student.ppf(0.95, blocks - 1) / student.ppf(0.95, math.inf))
    return np.asarray(few * np.sqrt(np.maximum(np.diag(covariance), np.finfo(float).tiny)))


def _moving(copy: DrivenTrial, terms: tuple[Term, ...], half: int, rows: int) -> Array:
    """1 for rows that can be used, 0 for those in which the instrument's motion stands or turns under a law whose force
    jumps there."""
    own = against_base(copy)
    x = own.outputs[own.main]
    v = x if own.main == "velocity" else np.gradient(x, copy.t)
    speed = float(np.max(np.abs(v)))
    size = float(np.std(x))
    if not any(jumps(term, size, speed) for term in terms):
        return np.ones(rows)
    standing = np.concatenate([[0], np.cumsum(np.abs(v) < STANDING_SHARE * speed)])
    begins = np.arange(rows) * row_step(half)
    return np.asarray(standing[begins + 2 * half + 1] == standing[begins], dtype=np.float64)


def jumps(term: Term, size: float, speed: float) -> bool:
    """Whether a law's force changes at once with the direction of motion, at a displacement of that ``size`` (m) and
    beside its force at that ``speed`` (m/s)."""
    here, full, nothing = np.array([size]), np.array([speed]), np.zeros(1)
    ahead, back = (float(term.force(here, way * 1e-9 * full, nothing, nothing)[0]) for way in (1.0, -1.0))
    return abs(ahead - back) > JUMPS_SHARE * abs(float(term.force(here, full, nothing, nothing)[0]))


def by_regression(trial: DrivenTrial, fitted: DrivenFit) -> dict[str, Estimate]:
    """The mass and each law's coefficient, by the names of the fit, of which it takes what is held.

    Raises IdentificationError where the trial is a decay or was recorded as acceleration alone, a law has a state of
    its own, or the record does not tell the numbers apart.
    """
    if trial.free:
        raise IdentificationError(
            f"trial {trial.name}: nothing drives it; regression with an input needs one, output error takes both"
        )
    if trial.main == "acceleration":
        raise IdentificationError(
            f"trial {trial.name}: acceleration alone is recorded; regression needs displacement or velocity: map one"
        )
    states = [term.name for term in fitted.laws.terms if term.kind in ("state", "delay")]
    if states:
        raise IdentificationError(
            f"trial {trial.name}: {', '.join(states)} has a state of its own, which no column shows; take the numbers "
            "of output error"
        )
    short = trial.part(0, min(trial.t.size, FIRST_SAMPLES))
    drives = {trial.name: drive_for(trial)}

    def missed(numbers: Mapping[str, float]) -> float:
        """By how much free runs over windows miss the record with these numbers; inf where they are no body's."""
        tried = {**fitted.laws.starts, **fitted.numbers, **numbers}
        if not tried[MASS] > 0.0:
            return math.inf
        try:
            return window_cost(short, replace(fitted.laws, starts=tried), drives)
        except IdentificationError:
            return math.inf

    found = regressed(trial, fitted, with_inner_numbers(fitted), trial.outputs, missed)
    if found is None:
        raise IdentificationError(
            f"trial {trial.name}: {1 + len(fitted.laws.terms)} numbers are not told apart by regression; give a longer "
            "record, with motion at several speeds"
        )
    return found
