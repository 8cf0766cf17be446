"""What a suspect could gain at most, seen from where the fit stands: one linear step instead of a search.

Where the equation already explains the motion nearly as well as repetitions would, an addition can only be small. Its
gain is then that of one Gauss-Newton step in its coefficients (a score test), over a fine grid of what it has inside
(frequency, damping, time); only what could matter is fitted. The best places of the grid are the fit's starts.

Belongs here: that step. Does not belong here: fits (joint.py), the search (search.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from undertow.comparison.joint import JointFit
from undertow.comparison.level import Addend, Level, full_name
from undertow.comparison.suspect import COMMON, Addition, Suspect
from undertow.equation.kernel import SLOT
from undertow.likelihood import output_error
from undertow.likelihood.problem import Link, TrialProblem
from undertow.recording.recording import Array

TINY = 1e-6
"""Share of its scale at which a coefficient stands that the integrator would skip at zero."""

SKIPPED_AT_ZERO = frozenset({"ge", "kb"})
"""Slots without whose value the integrator leaves out the whole law, its sensitivity too."""

LARGEST = 1e100
"""Of a column, in units of the noise: beyond, its square leaves every bound."""


@dataclass(frozen=True)
class GridPlace:
    """One place of a suspect's grid as seen from a fit: its additions starting where one step leads, by how much the
    log evidence could rise (``gain``, before any penalty), and what the step is made of.

    ``columns`` are, a trial, the derivatives (rows, p) of weighed residuals by the place's coefficients and their
    indices (p,); ``cross`` (unknowns, width) and ``own`` (width, width) their products with the fit's columns and each
    other. Empty columns: the motion leaves every bound here. ``whole``: nothing small leads to the law; the one column
    is the step from nothing to the law as its additions start, to be taken as it is. ``beside`` (unknowns,): where what
    stands goes beside additions as they start; empty where those differ from trial to trial.
    """

    label: str
    additions: tuple[Addition, ...]
    gain: float
    columns: tuple[tuple[Array, np.ndarray], ...] = ()
    cross: Array = field(default_factory=lambda: np.zeros((0, 0)))
    own: Array = field(default_factory=lambda: np.zeros((0, 0)))
    whole: bool = False
    beside: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def width(self) -> int:
        """Number of coefficients."""
        return int(self.own.shape[0])


def places(level: Level, stands: Stands, suspect: Suspect) -> tuple[GridPlace, ...]:
    """Every place of a suspect's grid, in the grid's order; of a suspected sensor the one of its prior given up. A
    place where the motion leaves every bound counts nothing."""
    if suspect.frees:
        return (_freed(stands, suspect),)
    grid = [renumbered(additions, stands.fit.addends) for additions in suspect.grid(level.scales)]
    if suspect.moves:
        return tuple(_switched(level, stands, suspect.label, additions) for additions in grid)
    return tuple(_place(level, stands, suspect.label, additions) for additions in grid)


def renumbered(additions: Sequence[Addition], beside: Sequence[Addend]) -> tuple[Addition, ...]:
    """A resonator beside others takes the integrator's next place."""
    taken = sum(a.slot.startswith("hm") for d in beside for a in d.additions)
    if not taken or not additions or not additions[0].slot.startswith("h") or additions[0].slot[-1] != "1":
        return tuple(additions)
    place = str(taken + 1)
    return tuple(replace(a, slot=a.slot[:-1] + place) for a in additions)


def reweighed(place: GridPlace, stands: Stands, factors: Sequence[Array]) -> GridPlace:
    """A place seen from the same fit weighed by other noise: ``factors`` (rows,) of every trial are the old one over
    the new one."""
    columns = tuple((mine * by[:, None], where) for (mine, where), by in zip(place.columns, factors, strict=True))
    cross, own, step, gain = _stepped(stands, columns, place.width)
    gain = _gain_whole(stands, cross, own, step) if place.whole else gain
    return replace(place, gain=gain, columns=columns, cross=cross, own=own)


def peaks(found: Sequence[GridPlace]) -> tuple[GridPlace, ...]:
    """Places whose gain is no less than their neighbours', the best first."""
    gains = [p.gain for p in found]
    high = [p for i, p in enumerate(found) if p.gain >= max(gains[max(0, i - 1) : i + 2])]
    return tuple(sorted(high, key=lambda p: -p.gain))


@dataclass(frozen=True)
class Stands:
    """The fit that stands: its trials, each trial's Jacobian, the inverse of its normal matrix, and the gradient."""

    fit: JointFit
    inverse: Array
    gradient: Array

    @classmethod
    def of(cls, fit: JointFit) -> Stands:
        """From a fit's Jacobians and residuals, priors included."""
        solution = fit.solution
        centres, precision = solution.problem.believed
        normal = np.diag(precision)
        gradient = precision * (solution.values - centres)
        for jac, r, used in zip(solution.jacobians, solution.residuals, solution.used, strict=True):
            normal[np.ix_(used, used)] += jac.T @ jac
            gradient[used] += jac.T @ r
        return cls(fit, scaled_inverse(normal, 1e-12), gradient)

    def pulled(self, residuals: Sequence[Array]) -> Array:
        """Gradients (unknowns, n) of the unknowns that stand, at residuals (rows, n) of every trial."""
        out = np.zeros((len(self.fit.solution.values), residuals[0].shape[1]))
        for jac, r, used in zip(self.fit.solution.jacobians, residuals, self.fit.solution.used, strict=True):
            out[used] += jac.T @ r
        return out


def scaled_inverse(matrix: Array, rcond: float) -> Array:
    """Inverse of a normal matrix, its unknowns in units of their own information: without directions that have less
    than a share ``rcond`` of the largest."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(matrix), 1e-300))
    both = np.outer(scale, scale)
    return np.asarray(np.linalg.pinv(matrix * both, rcond=rcond, hermitian=True) * both)


def _place(level: Level, stands: Stands, label: str, additions: tuple[Addition, ...]) -> GridPlace:
    """One Gauss-Newton step in the coefficients of one place, everything that stands moving along."""
    solution = stands.fit.solution
    names = _coefficient_names(level, additions)
    columns = []
    for trial in solution.problem.trials:
        reduced = _reduced(level, trial, solution.values, additions, names)
        got = output_error.residuals(reduced, np.zeros(len(names)))
        if got is None or not _can_be_squared(got[1]):
            return GridPlace(label, additions, 0.0)
        columns.append((got[1], got[2]))
    cross, own, step, gain = _stepped(stands, columns, len(names))
    additions = started(level, additions, step)
    moved = _beside(stands, additions, names, cross)
    return GridPlace(label, additions, gain, tuple(columns), cross, own, beside=moved)


def _can_be_squared(columns: Array) -> bool:
    """Whether products of these columns are numbers: beside a place from which a body falls what moves its start grows
    without end."""
    return bool(np.all(np.abs(columns) < LARGEST))


def _beside(stands: Stands, additions: tuple[Addition, ...], names: list[str], cross: Array) -> Array:
    """Values of what stands after the step that goes with a place's coefficients as they start, within their bounds."""
    if any(a.scope == "trial" for a in additions):
        return np.zeros(0)
    starts = {f".{a.name}": a.start for a in additions}
    step = np.array([starts[name.split("@")[0]] for name in names])
    solution = stands.fit.solution
    low, high = np.array([(u.lower, u.upper) for u in solution.problem.unknowns]).T
    moved = solution.values - stands.inverse @ (stands.gradient + cross @ step)
    return np.asarray(np.clip(moved, low, high), dtype=np.float64)


def started(level: Level, additions: tuple[Addition, ...], step: Array) -> tuple[Addition, ...]:
    """A place's additions, its coefficients where a step (width,) leads."""
    names = _coefficient_names(level, additions)
    return tuple(a if a.inner else replace(a, start=_start(a, names, step)) for a in additions)


def _switched(level: Level, stands: Stands, label: str, additions: tuple[Addition, ...]) -> GridPlace:
    """A law that no small value of leads to, as it starts: the difference of the two motions stands for a derivative,
    everything that stands moving along."""
    solution = stands.fit.solution
    none = np.zeros(0)
    columns = []
    for trial in solution.problem.trials:
        plain = _reduced(level, trial, solution.values, (), [])
        base = plain.base.copy()
        for a in additions:
            if a.moves is not None:
                old, new = (SLOT[slot] for slot in a.moves)
                base[new], base[old] = base[new] + base[old], 0.0
            base[SLOT[a.slot]] = a.start
        before, after = (output_error.residuals(replace(plain, base=b), none) for b in (plain.base, base))
        if before is None or after is None or not _can_be_squared(after[0]):
            return GridPlace(label, additions, 0.0)
        columns.append(((after[0] - before[0])[:, None], np.zeros(1, dtype=np.int64)))
    cross, own, step, _ = _stepped(stands, columns, 1)
    return GridPlace(
        label, additions, _gain_whole(stands, cross, own, step), tuple(columns), cross, own, whole=True
    )  # fmt: skip


def _gain_whole(stands: Stands, cross: Array, own: Array, step: Array) -> float:
    """What a law gains that is taken whole, not in the share that the step asks for."""
    left = float(own[0, 0] - cross[:, 0] @ stands.inverse @ cross[:, 0])
    return max(left * (float(step[0]) - 0.5), 0.0)


def _freed(stands: Stands, suspect: Suspect) -> GridPlace:
    """A sensor's shift, gain or drift in every trial beside its own prior; of what a sensor has in all trials alike the
    common one. (Free in every trial it would take up what one trial's body differs by.)"""
    solution = stands.fit.solution
    mine = [i for i, name in enumerate(solution.problem.names) if name.startswith(f"{suspect.frees}[")]
    alike = suspect.frees in COMMON
    columns = []
    for jac, used in zip(solution.jacobians, solution.used, strict=True):
        here = [at for at, index in enumerate(used.tolist()) if index in mine]
        whose = [0 if alike else mine.index(int(used[at])) for at in here]
        columns.append((jac[:, here], np.array(whose, dtype=np.int64)))
    cross, own, _, gain = _stepped(stands, columns, 1 if alike else len(mine))
    return GridPlace(suspect.label, (), gain, tuple(columns), cross, own)


def _stepped(
    stands: Stands, columns: Sequence[tuple[Array, np.ndarray]], width: int
) -> tuple[Array, Array, Array, float]:
    """Products of a place's columns with what stands and with each other, its step, and the step's gain."""
    solution = stands.fit.solution
    cross, own, slope = np.zeros((len(solution.values), width)), np.zeros((width, width)), np.zeros(width)
    for (mine, where), jac, used, r in zip(columns, solution.jacobians, solution.used, solution.residuals, strict=True):
        cross[used[:, None], where] += jac.T @ mine
        own[where[:, None], where] += mine.T @ mine
        slope[where] += mine.T @ r
    schur = own - cross.T @ stands.inverse @ cross
    slope = slope - cross.T @ stands.inverse @ stands.gradient
    scale = 1.0 / np.sqrt(np.maximum(np.diag(own), 1e-300))
    step = -scale * (np.linalg.pinv(schur * np.outer(scale, scale), rcond=1e-6, hermitian=True) @ (scale * slope))
    return cross, own, step, max(-0.5 * float(slope @ step), 0.0)


def linear_estimate(level: Level, stands: Stands, additions: tuple[Addition, ...]) -> tuple[float, float] | None:
    """The first coefficient of a law as one step from the fit finds it, what it has inside where it starts, and its
    standard error; None where the law has no motion or the fit leaves nothing of it."""
    place = _place(level, stands, "", additions)
    if not place.columns:
        return None
    left = place.own - place.cross.T @ stands.inverse @ place.cross
    if not left[0, 0] > 1e-6 * place.own[0, 0]:
        return None
    *_, step, _ = _stepped(stands, place.columns, place.width)
    return float(step[0]), float(np.sqrt(np.linalg.pinv(left, hermitian=True)[0, 0]))


def _coefficient_names(level: Level, additions: tuple[Addition, ...]) -> list[str]:
    """Names of a place's coefficients: shared ones, each spring's, each trial's."""
    found: dict[str, None] = {}
    for member in level.members:
        for motion in member.motions:
            for a in additions:
                if not a.inner:
                    found[full_name("", a, member.label, motion.name)] = None
    return list(found)


def _reduced(
    level: Level, trial: TrialProblem, values: Array, additions: tuple[Addition, ...], names: list[str]
) -> TrialProblem:
    """A trial where it stands, with the place's coefficients as its only unknowns."""
    member = next(m for m in level.members if any(motion.name == trial.name for motion in m.motions))
    theta = output_error.parameter_vector(trial, values)
    links = []
    for a in additions:
        if a.inner:
            theta[SLOT[a.slot]] = a.start
        else:
            index = names.index(full_name("", a, member.label, trial.name))
            for slot, factor in a.slots:
                theta[SLOT[slot]] += factor * TINY * a.scale if a.slot in SKIPPED_AT_ZERO else 0.0
                links.append(Link(SLOT[slot], index, factor))
    late = values[trial.shift] if trial.shift >= 0 else 0.0
    channels = tuple(replace(c, offset=-1, drift=(), shift=-1, gain=-1) for c in trial.channels)
    return replace(trial, t=trial.t + late, base=theta, links=tuple(links), channels=channels, shift=-1)


def _start(a: Addition, names: list[str], step: Array) -> float:
    """Where the step leads a coefficient (the largest of a spring's or a trial's own), inside its bounds."""
    steps = [s for name, s in zip(names, step, strict=True) if name.split("@")[0].split("[")[0] == f".{a.name}"]
    largest = max(steps, key=abs, default=a.start)
    low = a.lower if a.lower != 0.0 else 1e-3 * a.scale
    return float(min(max(largest, low), a.upper))
