"""How strong an effect is, measured without the program under test.

The prescribed equation is linearised about its mean numbers. Per trial the release, the start velocity, the time and
the rest position are free, k, c and mu scatter as the laboratory's trials do; per spring the means of k, c and mu and
per level m_a and Cd are free. What an effect leaves after all that, weighed by noise and scatter, is the expected
likelihood-ratio statistic `lambda` of a test that knows the law and the scatter: no test can expect more. `size` is the
same question without noise: how far the free run moves after the refit, over half of repeatability, or a reported
number over two standard errors. Doses are found by this measure, one linear step; what a truth states is `refit`'s.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from scipy.optimize import brentq
from scipy.stats import chi2, ncx2

from experiments.blind_challenge.rigs import Rig, Trial
from experiments.blind_challenge.scene import (
    QUIET,
    Change,
    Scene,
    mean_scene,
    move,
    read,
    sample_count,
    with_own_factors,
)
from experiments.blind_challenge.truths.motion import Motion

LEVEL = 0.01  # of a detection
NUDGE = 1e-5  # relative step of a difference quotient
WIDE = 3.0  # prior of a free number, relative: wide
DRAWS = 400  # for the 95 % quantile of repeatability
SMALL = 2e-4  # change of the readings at which the second order is far below any noise
STUCK = 3.0  # swings below so many times F_c / k are left out


@dataclass(frozen=True)
class View:
    """A trial as the sensors see it: whitened base reading, columns by parameter, the plain displacement and its
    columns.
    """

    scene: Scene
    samples: int
    base: np.ndarray
    columns: dict[tuple[str, int], np.ndarray]
    plain: np.ndarray
    plain_columns: dict[tuple[str, int], np.ndarray]


@dataclass(frozen=True)
class Strength:
    """lambda, and the refit's leftover over the motion (1), repeatability (1), size (1) and bias over two standard
    errors.
    """

    statistic: float
    leftover: float
    repeatability: float
    size: float
    bias: float


def whiten(rig: Rig, readings: dict[str, np.ndarray]) -> np.ndarray:
    """All channels over their noise, one after the other, the noise's correlation taken out."""
    out = []
    for sensor in rig.sensors:
        line = readings[sensor.channel] / sensor.noise
        r = sensor.correlation
        if r:
            line = np.concatenate([line[:1], (line[1:] - r * line[:-1]) / math.sqrt(1.0 - r * r)])
        out.append(line)
    return np.concatenate(out)


def _moved(rig: Rig, scene: Scene, samples: int, name: str, amount: float) -> dict[str, np.ndarray]:
    """Readings with one number of the prescribed equation, or of the release, moved by a relative amount."""
    body, trial, velocity = scene.body, scene.trial, 0.0
    if name == "k":
        body = body.changed(stiffness=body.stiffness * (1.0 + amount))
    elif name == "c":
        body = body.changed(damping=body.damping * (1.0 + amount))
    elif name == "mu":
        body = body.changed(coulomb=body.coulomb * (1.0 + amount))
    elif name == "ma":
        body = body.changed(mass=body.mass * (1.0 + amount))
    elif name == "q":
        body = body.changed(drag=body.drag * (1.0 + amount))
    elif name == "x0":
        trial = replace(trial, release=trial.release + amount * rig.largest)
    elif name == "v0":
        velocity = amount * rig.largest * body.frequency
    moved = Scene(rig, trial, body)
    change = Change(body, velocity=velocity)
    return read(moved, change, move(moved, change, samples), 0)


def _names(rig: Rig, trial: Trial) -> list[tuple[str, int]]:
    """Parameters that move a trial: name and the spring or level it belongs to."""
    out = [("k", trial.spring)]
    if "viscous_damping" in rig.terms:
        out.append(("c", trial.spring))
    if "coulomb_friction" in rig.terms and rig.mu > 0.0:
        out.append(("mu", trial.spring))
    if rig.levels[trial.level].wet:
        out += [("ma", trial.level)] if "added_mass" in rig.terms else []
        out += [("q", trial.level)] if "quadratic_drag" in rig.terms else []
    return [*out, ("x0", 0), ("v0", 0)]


def _swinging(scene: Scene, motion: Motion) -> int:
    """Samples until a swing is no longer large beside what friction alone holds: where the body stops is chance."""
    body = scene.body
    quiet = max(STUCK * body.coulomb / body.stiffness, QUIET * scene.trial.release) * body.frequency
    moving = np.flatnonzero(np.abs(motion.v) > quiet)
    least = int(8.0 * math.pi / body.frequency / scene.rig.step)
    return int(min(motion.v.size, max(moving[-1] + 1 if moving.size else 0, least)))


def view(rig: Rig, trial: Trial, own: bool = False) -> View:
    """Base reading and columns of one trial, about the mean numbers or (`own`) about the trial's own k, c and mu."""
    scene = with_own_factors(mean_scene(rig, trial)) if own else mean_scene(rig, trial)
    change = Change(scene.body)
    motion = move(scene, change, sample_count(rig, trial))
    samples = _swinging(scene, motion)
    motion = move(scene, change, samples)
    base = read(scene, change, motion, 0)
    columns, plain = {}, {}
    white = whiten(rig, base)
    for name in _names(rig, trial):
        moved = _moved(rig, scene, samples, name[0], NUDGE)
        columns[name] = (whiten(rig, moved) - white) / NUDGE
        plain[name] = (moved["displacement"] - base["displacement"]) / NUDGE
    rates = {c: np.gradient(values, rig.step) / scene.body.frequency for c, values in base.items()}
    columns["shift", 0] = whiten(rig, rates)
    plain["shift", 0] = rates["displacement"]
    for i, sensor in enumerate(rig.sensors):
        ones = {s.channel: np.full(samples - 1, rig.largest * (s.channel == sensor.channel)) for s in rig.sensors}
        scale = sensor.noise if sensor.channel != "displacement" else rig.largest
        columns["offset", i] = whiten(rig, ones) * (scale / rig.largest)
    plain["offset", 0] = np.full(samples - 1, rig.largest)
    return View(scene, samples, white, columns, base["displacement"] - trial.rest, plain)


class Linear:
    """The linearised campaign: one dense least-squares problem with priors for the scatter of k, c and mu."""

    def __init__(self, rig: Rig, views: list[View], random: bool, plain: bool) -> None:
        """`random`: k, c, mu scatter from trial to trial; `plain`: displacement alone, all samples equal."""
        self.rig, self.views, self.plain = rig, views, plain
        self.places: list[dict[tuple[str, int, int], int]] = []
        index: dict[tuple[str, int, int], int] = {}
        precision: list[float] = []
        spread = dict(zip(("k", "c", "mu"), rig.scatter, strict=True))
        for j, v in enumerate(views):
            own: dict[tuple[str, int, int], int] = {}
            for name, place in self.columns(v):
                keys = [(name, place, -1)] if name in ("k", "c", "mu", "ma", "q") else [(name, place, j)]
                if random and name in spread:
                    keys.append((name, place, j))
                for key in keys:
                    if key not in index:
                        index[key] = len(precision)
                        precision.append(self._precision(key, spread))
                    own[key] = index[key]
            self.places.append(own)
        self.index = index
        self.prior = np.array(precision)
        self.blocks = []
        self.matrix = np.diag(self.prior)
        for v, own in zip(views, self.places, strict=True):
            block = np.column_stack([self.columns(v)[key[:2]] for key in own])
            at = np.fromiter(own.values(), dtype=int)
            self.blocks.append((block, at))
            self.matrix[np.ix_(at, at)] += block.T @ block

    def columns(self, v: View) -> dict[tuple[str, int], np.ndarray]:
        """The columns that this problem uses of a trial."""
        return v.plain_columns if self.plain else v.columns

    def _precision(self, key: tuple[str, int, int], spread: dict[str, float]) -> float:
        name, _, j = key
        if name in spread and j >= 0:
            return 1.0 / spread[name] ** 2
        unit = (
            (0.01 * self.rig.largest) ** 2 if self.plain else 1.0
        )  # keeps the ridge small beside the data in either scale
        if name == "k" and {"stiffness", "mass"} <= self.rig.knows and not self.plain:
            return 1.0 / 0.01**2
        return unit * 1e-6 if self.plain else 1.0 / WIDE**2 * (1e-6 if name == "offset" else 1.0)

    def solve(self, residuals: list[np.ndarray], start: np.ndarray | None = None) -> tuple[np.ndarray, float]:
        """Best change of all numbers for these residuals, and the statistic that is left."""
        right = np.zeros(self.prior.size)
        total = 0.0
        for (block, at), r in zip(self.blocks, residuals, strict=True):
            right[at] += block.T @ r
            total += float(r @ r)
        if start is not None:
            right -= self.prior * start
            total += float(start @ (self.prior * start))
        step = np.linalg.lstsq(self.matrix, right, rcond=1e-14)[0]
        return step, max(total - float(right @ step), 0.0)

    def inner(self, first: list[np.ndarray], second: list[np.ndarray]) -> float:
        """Product of two sets of residuals after the refit: the statistic where both are one."""
        rights = np.zeros((2, self.prior.size))
        total = 0.0
        for (block, at), a, b in zip(self.blocks, first, second, strict=True):
            rights[0, at] += block.T @ a
            rights[1, at] += block.T @ b
            total += float(a @ b)
        return total - float(rights[0] @ np.linalg.lstsq(self.matrix, rights[1], rcond=1e-14)[0])

    def score(self, effect: list[np.ndarray], residuals: list[np.ndarray], apart: np.ndarray) -> float:
        """The likelihood-ratio score of an effect: normal with deviation 1 and the effect's size as mean.

        `apart` is how far the numbers, about which the problem is linear, lie from their priors' centres.
        """
        right = np.zeros(self.prior.size)
        for (block, at), e in zip(self.blocks, effect, strict=True):
            right[at] += block.T @ e
        held = float(np.linalg.lstsq(self.matrix, right, rcond=1e-14)[0] @ (self.prior * apart))
        return (self.inner(effect, residuals) + held) / math.sqrt(self.inner(effect, effect))

    def left(self, residuals: list[np.ndarray], step: np.ndarray) -> list[np.ndarray]:
        """Residuals after the linear step."""
        return [r - block @ step[at] for (block, at), r in zip(self.blocks, residuals, strict=True)]

    def deviations(self) -> np.ndarray:
        """Standard deviations of all numbers."""
        return np.sqrt(np.clip(np.diag(np.linalg.pinv(self.matrix, rcond=1e-14, hermitian=True)), 0.0, None))


def responses(
    rig: Rig, views: list[View], change_of: Callable[[Scene], Change]
) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Readings with the effect less those without, whitened and as plain displacement."""
    white, plain = [], []
    for v in views:
        change = change_of(v.scene)
        if change == Change(v.scene.body):
            white.append(np.zeros_like(v.base))
            plain.append(np.zeros_like(v.plain))
            continue
        readings = read(v.scene, change, move(v.scene, change, v.samples), 0)
        white.append(whiten(rig, readings) - v.base)
        plain.append(readings["displacement"] - v.scene.trial.rest - v.plain)
    return white, plain


def repeatability(rig: Rig, views: list[View]) -> float:
    """95 % quantile of the free run's error when k, c and mu scatter and nothing else does, over the motion (1)."""
    rng = np.random.default_rng(0)
    values = []
    for v in views:
        names = [n for n in ("k", "c", "mu") if (n, v.scene.trial.spring) in v.plain_columns]
        block = np.column_stack([v.plain_columns[n, v.scene.trial.spring] for n in names])
        gram = block.T @ block / float(v.plain @ v.plain)
        draws = rng.normal(size=(DRAWS, len(names))) * np.array([rig.scatter[("k", "c", "mu").index(n)] for n in names])
        values.append(np.sqrt(np.einsum("ij,jk,ik->i", draws, gram, draws)))
    return float(np.quantile(np.minimum(np.concatenate(values), 2.0), 0.95))


@cache
def half_power(unknowns: int) -> float:
    """The statistic at which a test with that many unknown numbers is passed every second time at LEVEL."""
    limit = chi2.isf(LEVEL, unknowns)
    return float(brentq(lambda x: ncx2.sf(limit, unknowns, x) - 0.5, 1e-6, 10.0 * limit + 100.0))


def best_power(statistic: float, unknowns: int) -> float:
    """Chance that the likelihood ratio with the true law passes LEVEL: no test of that level has more."""
    return float(ncx2.sf(chi2.isf(LEVEL, unknowns), unknowns, max(statistic, 1e-9)))


def raw_change(views: list[View], plain: list[np.ndarray], white: list[np.ndarray]) -> float:
    """How far the readings move before any refit, over the motion (1): of the displacement or, where more, of all
    channels.
    """
    motion = sum(float(v.plain @ v.plain) for v in views)
    seen = sum(float(v.base @ v.base) for v in views)
    return max(math.sqrt(sum(float(r @ r) for r in plain) / motion), math.sqrt(sum(float(r @ r) for r in white) / seen))


def judged(rig: Rig, views: list[View], white: list[np.ndarray], plain: list[np.ndarray]) -> Strength:
    """Strength of a change of the readings, by one linear refit; without limit where they are no numbers."""
    if not all(np.all(np.isfinite(r)) for r in (*white, *plain)):
        return Strength(math.inf, math.inf, repeatability(rig, views), math.inf, math.inf)
    scattered, same = Linear(rig, views, random=True, plain=False), Linear(rig, views, random=False, plain=True)
    step, statistic = scattered.solve(white)
    move_plain, _ = same.solve(plain)
    left = same.left(plain, move_plain)
    sure = scattered.deviations()
    places = [i for key, i in scattered.index.items() if key[0] in ("ma", "q") and key[2] < 0]
    bias = max((abs(step[i]) / sure[i] / 2.0 for i in places), default=0.0)
    rest = math.sqrt(sum(float(r @ r) for r in left) / sum(float(v.plain @ v.plain) for v in views))
    repeat = repeatability(rig, views)
    return Strength(statistic, rest, repeat, max(rest / (0.5 * repeat), bias), bias)


def effect_response(
    rig: Rig, views: list[View], change_of: Callable[[Scene, float], Change], dose: float, linear: bool
) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Change of the readings at a dose. `linear`: taken where it moves them by SMALL, then scaled to the dose."""
    if not linear:
        return responses(rig, views, lambda scene: change_of(scene, dose))
    probe = dose
    for _ in range(8):
        white, plain = responses(rig, views, lambda scene, d=probe: change_of(scene, d))
        moved = raw_change(views, plain, white)
        if moved <= 2.0 * SMALL:
            break
        probe *= 0.7 * SMALL / moved if math.isfinite(moved) else 0.01  # a motion that runs away is far too strong
    factor = dose / probe
    return [factor * r for r in white], [factor * r for r in plain]


def strength_of(
    rig: Rig, views: list[View], change_of: Callable[[Scene, float], Change], dose: float, linear: bool
) -> Strength:
    """Strength of an effect at a dose."""
    return judged(rig, views, *effect_response(rig, views, change_of, dose, linear))
