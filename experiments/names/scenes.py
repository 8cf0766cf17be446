"""A campaign: a plan with what is hidden in it, and each trial's numbers.

Belongs here: draws of a campaign and its trials, effects applied. Does not belong here: how large an effect has to be
(strength.py), what sensors make of it (recordings.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from experiments.names.effects import Effect, Scene, acts_on, find
from experiments.names.rigs import SCATTER, Plan, Trial

CAMPAIGN_DRAWS = ("sign", "first", "second", "third")


@dataclass(frozen=True)
class Campaign:
    """A plan and the sizes of what is hidden in it, by name; ``extra`` sets numbers of every wet trial outright."""

    plan: Plan
    sizes: Mapping[str, float] = field(default_factory=dict)
    extra: Mapping[str, float] = field(default_factory=dict)

    @property
    def effects(self) -> tuple[Effect, ...]:
        """What is hidden."""
        return tuple(find(name) for name in self.sizes)

    @property
    def lacks(self) -> tuple[str, ...]:
        """Terms that the prescribed equation does without."""
        return tuple(e.lacks for e in self.effects if e.lacks)

    def numbers(self, trial: Trial, scattered: bool = True) -> dict[str, float]:
        """The equation's numbers in a trial, with its own k, c, mu where ``scattered``, and what is hidden."""
        numbers = self.plan.means(trial)
        scene = make_scene(self.plan, trial)
        if scattered:
            rng = np.random.default_rng([self.plan.chances, 3, trial.order])
            for slot, symbol in (("k", "k"), ("c", "c"), ("fc", "mu")):
                share = SCATTER[self.plan.scatter][symbol] * rng.standard_normal()
                numbers[slot] *= max(1.0 + share, 0.2)
        for effect in self.effects:
            if effect.change is not None and acts_on(effect, trial):
                effect.change(numbers, self.sizes[effect.name], scene)
        return numbers | (dict(self.extra) if trial.wet else {})

    def released(self, trial: Trial) -> float:
        """Release reached: within 2 % of the one intended."""
        rng = np.random.default_rng([self.plan.chances, 4, trial.order])
        return trial.x0 * (1.0 + rng.uniform(-0.02, 0.02))


def make_scene(plan: Plan, trial: Trial) -> Scene:
    """A trial as effects see it, with the campaign's draws (the same for all its trials) and its own."""
    rng = np.random.default_rng([plan.seed, 2])
    wet = [t for t in plan.trials() if t.wet]
    rates = {t.spring: _rate(plan, t) for t in wet}
    speeds = {t.spring: rates[t.spring] * max(u.x0 for u in wet if u.spring == t.spring) for t in wet}
    draws = {name: rng.uniform() for name in CAMPAIGN_DRAWS}
    chosen = plan.springs[0]
    draws |= {
        "rate": rates[chosen],
        "fastest": max(rates.values()),
        "speed": max(speeds.values()),
        "largest": plan.rig.springs[chosen].releases[1],
        "stiffest": max(plan.rig.springs[s].k for s in plan.springs),
    }
    mine = np.random.default_rng([plan.chances, 5, trial.order])
    own = {"phase": mine.uniform(), "normal": mine.standard_normal(), "other": mine.uniform()}
    largest = plan.rig.springs[trial.spring].releases[1]
    same = [t for t in wet if t.spring == trial.spring]
    places = np.random.default_rng([plan.seed, 11]).permutation(len(same))
    later = trial.wet and bool(places[same.index(trial)] >= len(same) // 2)
    return Scene(
        trial, plan.rig, rates[trial.spring], min(rates.values()), speeds[trial.spring], largest, later, draws, own
    )


def _rate(plan: Plan, trial: Trial) -> float:
    numbers = plan.means(trial)
    return math.sqrt(numbers["k"] / numbers["M"])
