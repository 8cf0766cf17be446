"""How large an effect has to be: its free-run difference in units of what repeating the test gives.

The difference between the motion with the effect and without is freed of everything that the prescribed equation and
a trial's own start could take up (to first order: x0, clock and rest of each trial; added mass and drag of all; k, c,
mu too for what is in the structure, because the dry trials are fitted as well). Its RMS over all wet trials, relative
to their RMS displacement, over the 95 % quantile of the same measure for scatter of k, c and mu is the strength.

Belongs here: that measure and the size that gives a strength. Does not belong here: the effects themselves.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property

import numpy as np

from experiments.names.effects import Effect, find
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
DRAWS = 400
COARSER = 4.0
"""Factor by which sizes are tried downwards until one is weaker than wanted."""

SEARCH = 6
"""Steps of the search between two sizes on logarithmic scales."""

CLOSE = 0.03
"""A size is found when its strength is this close (relative) to the one wanted."""

COARSE_S = 1e-3
"""Step of the integration here, s: strengths need no more than a hundredth (but bristles are stiff)."""


def _moved(plan: Plan, trial: Trial, numbers: dict[str, float], x0: float) -> Floats:
    path = release(numbers, x0, plan.seconds, STEP_S if "xb" in numbers else COARSE_S)
    return path.at(np.arange(0.0, plan.seconds, EVERY_S))[0]


class Yardstick:
    """One plan's wet trials without anything hidden: their motion and its sensitivities."""

    def __init__(self, plan: Plan, lacks: tuple[str, ...] = ()) -> None:
        self.plan = plan
        self.trials = [t for t in plan.trials() if t.wet]
        self.plain = [_moved(plan, t, plan.means(t), t.x0) for t in self.trials]
        self.columns = [self._sensitivities(t, x) for t, x in zip(self.trials, self.plain, strict=True)]
        self.shared = tuple(s for s in SHARED if TERM_OF[s] not in lacks)
        self.structural = tuple(s for s in STRUCTURAL if TERM_OF.get(s) not in lacks)

    def _sensitivities(self, trial: Trial, plain: Floats) -> dict[str, Floats]:
        """Change of the motion for the whole of each number, for x0, the clock (s) and the rest (m)."""
        numbers = self.plan.means(trial)
        columns = {}
        for slot in (*SHARED, *STRUCTURAL):
            if numbers[slot] > 0.0:
                changed = numbers | {slot: numbers[slot] * (1.0 + NUDGE)}
                columns[slot] = (_moved(self.plan, trial, changed, trial.x0) - plain) / NUDGE
        columns["x0"] = (_moved(self.plan, trial, numbers, trial.x0 * (1.0 + NUDGE)) - plain) / NUDGE
        columns["clock"] = np.gradient(plain, EVERY_S)
        columns["rest"] = np.ones_like(plain)
        return columns

    @cached_property
    def repeatability(self) -> float:
        """95 % quantile over trials and draws of the nrmse that scatter of k, c, mu leaves."""
        rng = np.random.default_rng(self.plan.seed)
        scatter = SCATTER[self.plan.scatter]
        found = []
        for plain, columns in zip(self.plain, self.columns, strict=True):
            basis = _basis([columns[n] for n in ("x0", "clock", "rest")])
            size = math.sqrt(float(np.mean(plain**2)))
            parts = np.array([_freed(columns[s] * scatter[n], basis) for s, n in (("k", "k"), ("c", "c"), ("fc", "mu"))
                              if s in columns])  # fmt: skip
            draws = rng.standard_normal((DRAWS // len(self.trials) + 1, parts.shape[0])) @ parts
            found += (np.sqrt(np.mean(draws**2, axis=1)) / size).tolist()
        return float(np.quantile(found, 0.95))

    def difference(self, moved: list[Floats], structural: bool, kept: str = "") -> float:
        """RMS over trials of the relative difference to ``moved``, freed of what the equation can take up but for
        ``kept``."""
        count = self.plain[0].size
        columns = []
        for slot in (*self.shared, *(self.structural if structural else ())):
            for spring in ("",) if slot in SHARED else self.plan.springs:
                column = np.zeros(count * len(self.trials))
                for i, trial in enumerate(self.trials):
                    if spring in ("", trial.spring) and slot in self.columns[i]:
                        column[i * count : (i + 1) * count] = self.columns[i][slot] / self._size(i)
                columns.append(column)
        for i in range(len(self.trials)):
            for name in (n for n in ("x0", "clock", "rest") if n != kept):
                column = np.zeros(count * len(self.trials))
                column[i * count : (i + 1) * count] = self.columns[i][name] / self._size(i)
                columns.append(column)
        pairs = enumerate(zip(moved, self.plain, strict=True))
        parts = [(m - p) / self._size(i) for i, (m, p) in pairs]
        return math.sqrt(float(np.mean(_freed(np.concatenate(parts), _basis(columns)) ** 2)))

    def _size(self, i: int) -> float:
        return math.sqrt(float(np.mean(self.plain[i] ** 2)))


def _basis(columns: list[Floats]) -> Floats:
    return np.linalg.qr(np.array([c / (np.linalg.norm(c) or 1.0) for c in columns]).T)[0]


def _freed(values: Floats, basis: Floats) -> Floats:
    freed: Floats = values - basis @ (basis.T @ values)
    return freed


def strength_of(plan: Plan, name: str, size: float, yardstick: Yardstick) -> float:
    """Free-run difference of an effect at a size over the plan's repeatability."""
    effect = find(name)
    hidden = Campaign(plan, {name: size})
    moved = [_moved(plan, t, hidden.numbers(t, scattered=False), t.x0) for t in yardstick.trials]
    without = _weakest(effect)
    if without is not None:  # the term itself is hidden: nothing hidden is without it
        bare = Campaign(plan, {name: without})
        plain = [_moved(plan, t, bare.numbers(t, scattered=False), t.x0) for t in yardstick.trials]
        moved = [m - b + p for m, b, p in zip(moved, plain, yardstick.plain, strict=True)]
    structural = effect.place not in ("water", "outside") and effect.name != "mass_change"
    return yardstick.difference(moved, structural, effect.seen_in) / yardstick.repeatability


def _weakest(effect: Effect) -> float | None:
    return 0.0 if effect.lacks else None


def size_for(plan: Plan, name: str, strength: float) -> tuple[float, float]:
    """The size of an effect that has a strength in this plan, and the strength reached (less where even the largest
    sensible size is weaker); an instrument's is its unit times the strength."""
    effect = find(name)
    if effect.change is None:
        return effect.unit_size * strength, strength
    yardstick = Yardstick(plan, (effect.lacks,) if effect.lacks else ())
    high = effect.most
    reached = strength_of(plan, name, high, yardstick)
    if reached <= strength:
        return high, reached
    strong, weak = (high, reached), (0.0, 0.0)
    while weak[1] == 0.0:
        size = strong[0] / COARSER
        found = strength_of(plan, name, size, yardstick)
        if found < strength:
            weak = (size, max(found, 1e-6))
        else:
            strong = (size, found)
    return _between(lambda size: strength_of(plan, name, size, yardstick), strength, weak, strong)


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
    return weak
