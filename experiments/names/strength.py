"""How large an effect has to be: what the prescribed equation cannot follow, in units of what repeating the test gives.

The motion with the effect is fitted by the prescribed equation: x0, clock and rest of each trial, added mass and drag
of all; k, c, mu of each spring too for what is in the structure, because the dry trials have it as well. The RMS of
what is left, relative to the RMS displacement, over the 95 % quantile of the same measure for scatter of k, c and mu
(x0, clock and rest adjusted) is the strength. Of each spring the largest and the smallest release count.

Belongs here: that measure and the size that gives a strength. Does not belong here: the effects themselves.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from experiments.names.effects import find
from experiments.names.motion import STEP_S, Floats, release
from experiments.names.rigs import SCATTER, Plan, Trial
from experiments.names.scenes import Campaign

EVERY_S = 0.02
"""Spacing of the instants compared, s: 13 in the fastest period."""

NUDGE = 1e-3
"""Relative change of a number by which a sensitivity is found."""

SHARED = ("M", "q")
STRUCTURAL = ("k", "c", "fc")
TERM_OF = {"M": "added_mass", "q": "quadratic_drag", "fc": "coulomb_friction"}
TRIALS_OWN = ("x0", "clock", "rest")

DRAWS = 400
COARSER = 4.0
"""Factor by which sizes are tried downwards until one is weaker than wanted."""

SEARCH = 5
"""Steps of the search between two sizes on logarithmic scales."""

CLOSE = 0.06
"""A size is found when its strength is this close (relative) to the one wanted."""

COARSE_S = 1e-3
"""Step of the integration here, s: strengths need no more than a hundredth (but bristles are stiff)."""

REFITS, SETTLED, DAMPING = 5, 0.02, 1e-3
"""Most steps of a fit; relative gain below which it has settled; its first damping (Levenberg-Marquardt)."""


@dataclass(frozen=True)
class Fitted:
    """The prescribed equation on one trial: its numbers and the trial's own start."""

    trial: Trial
    numbers: dict[str, float]
    own: dict[str, float]

    def move(self, seconds: float) -> Floats:
        """Displacement at the instants compared, m."""
        times = np.arange(0.0, seconds, EVERY_S) + self.own["clock"]
        step = STEP_S if "xb" in self.numbers else COARSE_S
        path = release(self.numbers, self.own["x0"], seconds + 0.2, step)
        moved: Floats = path.at(np.maximum(times, 0.0))[0] + self.own["rest"]
        return moved

    def changed(self, name: str, by: float) -> Fitted:
        """The same with one number larger by ``by``; inertia and stiffness at most halved, the others not below 0."""
        if name in TRIALS_OWN:
            return Fitted(self.trial, self.numbers, self.own | {name: self.own[name] + by})
        least = 0.5 * self.numbers[name] if name in ("M", "k") else 0.0
        return Fitted(self.trial, self.numbers | {name: max(self.numbers[name] + by, least)}, self.own)


class Yardstick:
    """One plan's largest and smallest wet releases without anything hidden, and what can be refitted to them."""

    def __init__(self, plan: Plan, name: str) -> None:
        effect = find(name)
        self.plan, self.effect = plan, effect
        wet = [t for t in plan.trials() if t.wet]
        between = name == "mass_change"  # what comes between trials needs them all
        self.trials = wet if between else [t for s in plan.springs for t in _ends([t for t in wet if t.spring == s])]
        structural = effect.place not in ("water", "outside") and not between
        slots = (*SHARED, *(STRUCTURAL if structural else ()))
        self.slots = tuple(s for s in slots if TERM_OF.get(s) != effect.lacks or not effect.lacks)
        self.own = tuple(n for n in TRIALS_OWN if n != effect.seen_in)
        self.plain = [self._start(t, self.plan.means(t)) for t in self.trials]
        self.repeatability = self._repeatability()

    def _start(self, trial: Trial, numbers: dict[str, float]) -> Fitted:
        return Fitted(trial, numbers, {"x0": trial.x0, "clock": 0.0, "rest": 0.0})

    def _prescribed(self, trial: Trial) -> Fitted:
        numbers = self.plan.means(trial)
        bare = {"added_mass": ("M", self.plan.rig.mass), "quadratic_drag": ("q", 0.0), "coulomb_friction": ("fc", 0.0)}
        if self.effect.lacks:
            slot, value = bare[self.effect.lacks]
            numbers[slot] = value
        return self._start(trial, numbers)

    def _repeatability(self) -> float:
        rng = np.random.default_rng(self.plan.seed)
        scatter = SCATTER[self.plan.scatter]
        found: list[float] = []
        for fitted in self.plain:
            plain = fitted.move(self.plan.seconds)
            basis = _basis([self._sensitivity(fitted, plain, n) for n in TRIALS_OWN])
            parts = []
            for slot, symbol in zip(STRUCTURAL, ("k", "c", "mu"), strict=True):
                column = self._sensitivity(fitted, plain, slot) * fitted.numbers[slot] * scatter[symbol]
                parts.append(column - basis @ (basis.T @ column))
            draws = rng.standard_normal((DRAWS, len(parts))) @ np.array(parts)
            found += (np.sqrt(np.mean(draws**2, axis=1)) / _rms(plain)).tolist()
        return float(np.quantile(found, 0.95))

    def _sensitivity(self, fitted: Fitted, plain: Floats, name: str) -> Floats:
        """Change of the motion for one unit of a number."""
        if name == "clock":
            return np.gradient(plain, EVERY_S)
        if name == "rest":
            return np.ones_like(plain)
        size = abs(fitted.own[name] if name in TRIALS_OWN else fitted.numbers[name])
        by = NUDGE * (size or self.plan.means(fitted.trial).get(name, 0.0) or 1.0)
        return (fitted.changed(name, by).move(self.plan.seconds) - plain) / by

    def strength(self, size: float) -> float:
        """What the prescribed equation cannot follow of the effect at a size, over repeatability."""
        hidden = Campaign(self.plan, {self.effect.name: size})
        truths = [self._start(t, hidden.numbers(t, scattered=False)).move(self.plan.seconds) for t in self.trials]
        return self._left(truths) / self.repeatability

    def _left(self, truths: list[Floats]) -> float:
        """RMS over trials of what is left relative to their motion, after the prescribed equation is fitted."""
        current = [self._prescribed(t) for t in self.trials]
        best, damping = math.inf, DAMPING
        motions = [f.move(self.plan.seconds) for f in current]
        for _ in range(REFITS):
            error = self._error(truths, motions)
            settled = error > (1.0 - SETTLED) * best
            best = min(best, error)
            if settled:
                break
            step = self._step(current, motions, truths, damping)
            trial = [_moved_by(f, s) for f, s in zip(current, step, strict=True)]
            tried = [f.move(self.plan.seconds) for f in trial]
            if self._error(truths, tried) < best:
                current, motions = trial, tried
            else:
                step = self._step(current, motions, truths, 1e3 * damping)
                current = [_moved_by(f, s) for f, s in zip(current, step, strict=True)]
                motions = [f.move(self.plan.seconds) for f in current]
        return min(best, self._error(truths, motions))

    def _error(self, truths: list[Floats], motions: list[Floats]) -> float:
        return math.sqrt(float(np.mean([(_rms(t - m) / _rms(t)) ** 2 for t, m in zip(truths, motions, strict=True)])))

    def _step(
        self, current: list[Fitted], motions: list[Floats], truths: list[Floats], damping: float
    ) -> list[dict[str, float]]:
        """One damped least-squares step of every number that can be refitted, a trial an entry."""
        count, places = motions[0].size, {}
        columns, groups = [], []
        for slot in self.slots:
            groups += [(slot, s) for s in (("",) if slot in SHARED else self.plan.springs)]
        groups += [(name, f.trial.file) for f in current for name in self.own]
        for name, where in groups:
            column = np.zeros(count * len(current))
            for i, fitted in enumerate(current):
                if where in ("", fitted.trial.spring, fitted.trial.file):
                    column[i * count : (i + 1) * count] = self._sensitivity(fitted, motions[i], name) / _rms(truths[i])
            places[name, where] = len(columns)
            columns.append(column)
        matrix = np.array(columns).T
        norms = np.linalg.norm(matrix, axis=0)
        norms[norms == 0.0] = 1.0
        left = np.concatenate([(t - m) / _rms(t) for t, m in zip(truths, motions, strict=True)])
        scaled = np.vstack([matrix / norms, math.sqrt(damping) * np.eye(norms.size)])
        found = np.linalg.lstsq(scaled, np.concatenate([left, np.zeros(norms.size)]), rcond=None)[0] / norms
        return [{name: found[i] for (name, where), i in places.items() if where in ("", f.trial.spring, f.trial.file)}
                for f in current]  # fmt: skip


def _ends(trials: list[Trial]) -> list[Trial]:
    return [trials[0], trials[-1]] if len(trials) > 1 else trials


def _moved_by(fitted: Fitted, step: dict[str, float]) -> Fitted:
    for name, by in step.items():
        fitted = fitted.changed(name, by)
    return fitted


def _rms(values: Floats) -> float:
    return math.sqrt(float(np.mean(values**2)))


def _basis(columns: list[Floats]) -> Floats:
    return np.linalg.qr(np.array([c / np.linalg.norm(c) for c in columns]).T)[0]


def size_for(plan: Plan, name: str, strength: float) -> tuple[float, float]:
    """The size of an effect that has a strength in this plan, and the strength reached (less where even the largest
    sensible size is weaker); an instrument's is its unit times the strength."""
    effect = find(name)
    if effect.change is None:
        return effect.unit_size * strength, strength
    yardstick = Yardstick(plan, name)
    high = effect.most
    reached = yardstick.strength(high)
    if reached <= strength:
        return high, reached
    strong, weak = (high, reached), (0.0, 0.0)
    while weak[1] == 0.0:
        size = strong[0] / COARSER
        found = yardstick.strength(size)
        if found < strength:
            weak = (size, max(found, 1e-6))
        else:
            strong = (size, found)
    return _between(yardstick.strength, strength, weak, strong)


def _between(
    measure: Callable[[float], float], strength: float, weak: tuple[float, float], strong: tuple[float, float]
) -> tuple[float, float]:
    """The size between two, each with its strength, that has the strength wanted."""
    for _ in range(SEARCH):
        span = math.log(strong[0] / weak[0])
        share = math.log(strength / weak[1]) / math.log(strong[1] / weak[1])
        size = weak[0] * math.exp(span * min(max(share, 0.1), 0.9))
        found = measure(size)
        if abs(found / strength - 1.0) < CLOSE:
            return size, found
        if found < strength:
            weak = (size, found)
        else:
            strong = (size, found)
    return min(weak, strong, key=lambda one: abs(math.log(one[1] / strength)))
