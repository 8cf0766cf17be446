"""How strong an effect is, as the truth states it: `strength`'s question with exact algebra and a refit that follows.

`strength` draws doses by normal equations and one linear step. Both can mislead: normal equations lose what wide priors
leave nearly free (a mass that nothing fixes had an error of nought, and a hook that lets go in no time at all was
"five times what can be seen"), and an effect that slows the body by some percent runs out of phase with it, which one
step cannot follow, though another stiffness or mass follows it exactly (a soft support was "8,900 times"). Here the
least squares are solved by orthogonal factors, and where an effect is not proportional to its dose the prescribed
equation is linearised again where the last step ended, with the effect grown in stages so that no cycle is lost. The
free numbers and their priors are those of `strength`; so are the doses, and with them the cases of a seed.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from experiments.blind_challenge import strength as measure
from experiments.blind_challenge.rigs import Rig
from experiments.blind_challenge.scene import Change, Scene, move, read
from experiments.blind_challenge.strength import Linear, Strength, View

STAGES = (0.03, 0.1, 0.2, 0.35, 0.5, 0.7, 0.85, 1.0)  # shares of the dose
SMALL = 0.02  # change of the readings that a linear step follows: one stage
STEPS = 20  # linearisations in a stage
FARTHEST = 1.0  # change of a number in one step
BOUND = 2.0  # largest number: factors of seven, twice the release, a third of a period
TRIES = 8  # dampings of a step
FREE = 1e-12  # first damping, of a column's squared size
ENOUGH = 0.02  # relative fall of the statistic below which a stage has ended
LEAST = 0.05  # the same, absolute: far below what a test can see
FACTORS = {"k": "stiffness", "c": "damping", "mu": "coulomb", "ma": "mass", "q": "drag"}
NUDGE = 3e-5  # of a central difference quotient: a one-sided one spoils what the data leave nearly free
FAR = 5000.0  # statistic: some twenty times what can be seen
BESIDE = 2  # samples of an accelerometer left out beside a reversal: on which side of friction's jump is chance

Numbers = dict[tuple[str, int], float]


@dataclass(frozen=True)
class Seen(View):
    """A trial of which some samples are left out (0 of `kept`): of its columns, not of its base. `offsets` are columns
    of all samples.
    """

    kept: np.ndarray
    offsets: dict[tuple[str, int], np.ndarray]

    def white(self, readings: dict[str, np.ndarray]) -> np.ndarray:
        """Whitened readings, those left out nought."""
        return self.kept * measure.whiten(self.scene.rig, readings)


@dataclass(frozen=True)
class Refit:
    """Where a refit ended: trials linearised there, what is left of their readings (whitened; plain displacement, m),
    the free numbers (0: as the laboratory has them), the statistic, and whether it is a minimum.
    """

    views: list[Seen]
    left: list[np.ndarray]
    plain: list[np.ndarray]
    numbers: np.ndarray
    statistic: float
    ended: bool


def _readings(view: Seen, numbers: Numbers) -> dict[str, np.ndarray]:
    """Readings of the prescribed equation with its numbers moved: factors by their logarithm, the rest as `strength`
    has them.
    """
    scene, trial, rig = view.scene, view.scene.trial, view.scene.rig
    frequency = scene.body.frequency
    moved = {
        FACTORS[name]: getattr(scene.body, FACTORS[name]) * math.exp(amount)
        for (name, _), amount in numbers.items()
        if name in FACTORS
    }
    first = trial.first + numbers.get(("shift", 0), 0.0) / frequency
    held = math.ceil(1e-9 - first / rig.step) if first <= 0.0 else 0
    late = replace(trial, first=first + held * rig.step, release=trial.release + numbers[("x0", 0)] * rig.largest)
    change = Change(scene.body.changed(**moved), velocity=numbers[("v0", 0)] * rig.largest * frequency)
    there = Scene(rig, late, change.body)
    readings = read(there, change, move(there, change, view.samples), held)
    out = {}
    for i, sensor in enumerate(rig.sensors):
        scale = sensor.noise if sensor.channel != "displacement" else rig.largest
        out[sensor.channel] = readings[sensor.channel][: view.samples - 1] + numbers[("offset", i)] * scale
    return out


def _kept(rig: Rig, plain: np.ndarray) -> np.ndarray:
    """Which readings do not jump from one side of a sample to the other, by the displacement's reversals."""
    turns = np.flatnonzero(np.diff(np.sign(np.diff(plain, prepend=plain[0]))) != 0)
    quiet = np.ones(plain.size)
    for d in range(-BESIDE, BESIDE + 1):
        quiet[np.clip(turns + 1 + d, 0, quiet.size - 1)] = 0.0
    return np.concatenate([quiet if s.channel == "acceleration" else np.ones(quiet.size) for s in rig.sensors])


def _seen(view: View) -> Seen:
    """A trial about the laboratory's numbers, without what jumps."""
    offsets = {key: column for key, column in view.columns.items() if key[0] == "offset"}
    bare = Seen(**vars(view), kept=_kept(view.scene.rig, view.plain), offsets=offsets)
    return _linearised(bare, dict.fromkeys(view.columns, 0.0))


def _linearised(view: Seen, numbers: Numbers) -> Seen:
    """A trial about these numbers."""
    here = _readings(view, numbers)
    columns, plain = dict(view.columns), dict(view.plain_columns)
    for key in view.columns:
        if key[0] == "offset":
            columns[key] = view.kept * view.offsets[key]
            continue
        up, down = (_readings(view, {**numbers, key: numbers[key] + nudge}) for nudge in (NUDGE, -NUDGE))
        columns[key] = (view.white(up) - view.white(down)) / (2.0 * NUDGE)
        plain[key] = (up["displacement"] - down["displacement"]) / (2.0 * NUDGE)
    rest = view.scene.trial.rest
    whole = measure.whiten(view.scene.rig, here)
    return replace(view, base=whole, columns=columns, plain=here["displacement"] - rest, plain_columns=plain)


def _own(problem: Linear, j: int, view: Seen, numbers: np.ndarray) -> Numbers:
    """The numbers of one trial: what it shares and what is its own, added."""
    out = dict.fromkeys(view.columns, 0.0)
    for (name, place, _), at in problem.places[j].items():
        out[name, place] += float(numbers[at])
    return out


def _truth(view: Seen, change: Change) -> tuple[Seen, np.ndarray, np.ndarray]:
    """The trial without what jumps with the effect, and the readings: whitened, and the displacement less its rest."""
    readings = read(view.scene, change, move(view.scene, change, view.samples), 0)
    plain = readings["displacement"] - view.scene.trial.rest
    there = replace(view, kept=_kept(view.scene.rig, plain))
    return there, there.white(readings), plain


class Local:
    """The least-squares problem about some numbers, by orthogonal factors."""

    def __init__(self, rig: Rig, views: list[View], random: bool = True, plain: bool = False) -> None:
        """`random` and `plain`: as `strength.Linear` has them, whose numbers and priors these are."""
        self.problem = Linear(rig, views, random, plain)
        count = self.problem.prior.size
        rows = [np.diag(np.sqrt(self.problem.prior))]
        self.turns = []
        for block, at in self.problem.blocks:
            whole = np.zeros((block.shape[0], count))
            np.add.at(whole.T, at, block.T)
            used = np.unique(at)
            q, upper = np.linalg.qr(whole[:, used])
            row = np.zeros((upper.shape[0], count))
            row[:, used] = upper
            rows.append(row)
            self.turns.append(q)
        self.matrix = np.vstack(rows)
        self.size = np.linalg.norm(self.matrix, axis=0)

    def right(self, left: list[np.ndarray], numbers: np.ndarray) -> np.ndarray:
        """What is left, turned as the rows are."""
        turned = [q.T @ r for q, r in zip(self.turns, left, strict=True)]
        return np.concatenate([-np.sqrt(self.problem.prior) * numbers, *turned])

    def step(self, left: list[np.ndarray], numbers: np.ndarray, damping: float = 0.0) -> tuple[np.ndarray, float]:
        """Best change of the numbers, held back by `damping` of each column's size, and how far the cost then falls."""
        right = self.right(left, numbers)
        held = np.diag(np.full(self.size.size, math.sqrt(damping)))
        move = np.linalg.lstsq(
            np.vstack([self.matrix / self.size, held]), np.concatenate([right, np.zeros(self.size.size)]), rcond=1e-13
        )[0]
        rest = right - (self.matrix / self.size) @ move
        return move / self.size, float(right @ right - rest @ rest)

    def deviations(self) -> np.ndarray:
        """Standard deviations of all numbers."""
        upper = np.linalg.qr(self.matrix / self.size, mode="r")
        return np.linalg.norm(np.linalg.inv(upper), axis=1) / self.size

    def cost(self, left: list[np.ndarray], numbers: np.ndarray) -> float:
        """The statistic: what is left, and how far the numbers lie from their priors."""
        return sum(float(r @ r) for r in left) + float(numbers @ (self.problem.prior * numbers))


def _stage(
    rig: Rig, views: list[Seen], truths: list[np.ndarray], numbers: np.ndarray
) -> tuple[np.ndarray, list[Seen], bool]:
    """Numbers at which the statistic no longer falls, the trials linearised there, and whether it is a minimum."""
    places = Linear(rig, views, random=True, plain=False)

    def left(at: np.ndarray) -> list[np.ndarray]:
        return [
            t - v.white(_readings(v, _own(places, j, v, at)))
            for j, (v, t) in enumerate(zip(views, truths, strict=True))
        ]

    off = left(numbers)
    damping = 0.0
    for _ in range(STEPS):
        here = [_linearised(v, _own(places, j, v, numbers)) for j, v in enumerate(views)]
        local = Local(rig, here)
        cost = local.cost(off, numbers)
        for _ in range(TRIES):
            step, falls = local.step(off, numbers, damping)
            step = step * min(1.0, FARTHEST / max(float(np.max(np.abs(step))), 1e-300))
            if falls <= max(LEAST, ENOUGH * cost) and damping <= FREE:
                return numbers, here, True
            moved = np.clip(numbers + step, -BOUND, BOUND)
            tried = left(moved)
            there = local.cost(tried, moved)
            if math.isfinite(there) and there < cost:
                break
            damping = max(100.0 * damping, FREE)
        else:
            return numbers, here, False
        damping = damping / 100.0 if damping > FREE else 0.0
        numbers, off = moved, tried
        if cost - there <= max(LEAST, ENOUGH * cost):
            return numbers, [_linearised(v, _own(places, j, v, numbers)) for j, v in enumerate(views)], True
    return numbers, here, False


def _one_step(
    rig: Rig, views: list[Seen], change_of: Callable[[Scene, float], Change], dose: float, linear: bool
) -> Refit | None:
    """The refit by one linear step; None where the readings are no numbers."""
    white, plain = measure.effect_response(rig, views, change_of, dose, linear)
    if not all(np.all(np.isfinite(r)) for r in (*white, *plain)):
        return None
    white = [v.kept * r for v, r in zip(views, white, strict=True)]
    local = Local(rig, views)
    nowhere = np.zeros(local.size.size)
    step, falls = local.step(white, nowhere)
    left = local.problem.left(white, step)
    return Refit(views, left, plain, step, local.cost(white, nowhere) - falls, True)


def _followed(
    rig: Rig, views: list[Seen], change_of: Callable[[Scene, float], Change], dose: float, stages: tuple[float, ...]
) -> Refit:
    """The refit that follows the effect as it grows, in proportion from where it is far above what can be seen."""
    numbers = np.zeros(Linear(rig, views, random=True, plain=False).prior.size)
    before = stages[0]
    for share in stages:
        truths = [_truth(v, change_of(v.scene, dose * share)) for v in views]
        there, white = [v for v, _, _ in truths], [t for _, t, _ in truths]
        numbers, here, ended = _stage(rig, there, white, numbers * share / before)
        before = share
        left = [t - v.kept * v.base for t, v in zip(white, here, strict=True)]
        statistic = Local(rig, here).cost(left, numbers)
        if statistic > FAR:
            break
    rest = [(p - v.plain) / share for (_, _, p), v in zip(truths, here, strict=True)]
    return Refit(here, [r / share for r in left], rest, numbers / share, statistic / share**2, ended)


def refit(
    rig: Rig, views: list[View], change_of: Callable[[Scene, float], Change], dose: float, linear: bool
) -> Refit | None:
    """The prescribed equation fitted to the readings with the effect; None where these are no numbers.

    An effect that is not proportional to its dose is followed; where that does not end at a minimum, what it reached is
    a bound from above, and the lesser of it and of one step is taken.
    """
    seen = [_seen(v) for v in views]
    one = _one_step(rig, seen, change_of, dose, linear)
    if linear or one is None:
        return one
    white, plain = measure.responses(rig, views, lambda scene: change_of(scene, dose))
    large = measure.raw_change(views, plain, white) > SMALL
    followed = _followed(rig, seen, change_of, dose, STAGES if large else STAGES[-1:])
    return followed if followed.ended or followed.statistic < one.statistic else one


def strength_of(
    rig: Rig, views: list[View], change_of: Callable[[Scene, float], Change], dose: float, linear: bool
) -> tuple[Strength, Refit | None]:
    """Strength of an effect at a dose, and the refit that it is measured by."""
    repeat = measure.repeatability(rig, views)
    end = refit(rig, views, change_of, dose, linear)
    if end is None:
        return Strength(math.inf, math.inf, repeat, math.inf, math.inf), None
    same = Local(rig, end.views, random=False, plain=True)
    rest = same.problem.left(end.plain, same.step(end.plain, np.zeros(same.size.size))[0])
    scattered = Local(rig, end.views)
    sure = scattered.deviations()
    places = [i for key, i in scattered.problem.index.items() if key[0] in ("ma", "q") and key[2] < 0]
    bias = max((abs(end.numbers[i]) / sure[i] / 2.0 for i in places), default=0.0)
    free_run = math.sqrt(sum(float(r @ r) for r in rest) / sum(float(v.plain @ v.plain) for v in views))
    return Strength(end.statistic, free_run, repeat, max(free_run / (0.5 * repeat), bias), bias), end


def beside(rig: Rig, end: Refit, second: Callable[[Scene, float], Change], dose: float, linear: bool) -> float:
    """The statistic of a refitted effect where the size of a second one is free too."""
    white, _ = measure.effect_response(rig, end.views, second, dose, linear)
    if not all(np.all(np.isfinite(r)) for r in white):
        return end.statistic
    white = [v.kept * r for v, r in zip(end.views, white, strict=True)]
    local = Local(rig, end.views)
    nowhere = np.zeros(local.size.size)
    step, falls = local.step(white, nowhere)
    other = local.cost(white, nowhere) - falls
    if other <= 0.0:
        return end.statistic
    after = local.problem.left(white, step)
    both = sum(float(a @ r) for a, r in zip(after, end.left, strict=True))
    both += float(step @ (local.problem.prior * end.numbers))
    return max(end.statistic - both**2 / other, 0.0)
