"""What an effect is to the challenge: how it is drawn, how it acts, by which names it is rightly called.

`catalogue`, `outside` and `water_effects` fill the table; `kind` reads it.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from experiments.blind_challenge.rigs import Needs, Rig
from experiments.blind_challenge.scene import Change, Scene

Shape = dict[str, float | list[float]]


@dataclass(frozen=True)
class EffectKind:
    """One kind of truth.

    `names` are right; `near` describe it fairly without being it. `unknowns` counts the numbers of the law,
    `unknowns_a_trial` those that each trial has. `change` makes a trial with the effect at a dose; `numbers` gives the
    contract's parameters.
    """

    key: str
    text: str
    place: str  # water, structure, outside, set-up, instrument
    names: tuple[str, ...]
    draw: Callable[[np.random.Generator, Rig], Shape]
    change: Callable[[Shape, float, Scene], Change]
    near: tuple[str, ...] = ()
    unknowns: int = 1
    unknowns_a_trial: int = 0
    needs: Needs = field(default_factory=Needs)
    left_out: tuple[str, ...] = ()
    numbers: Callable[[Shape, float, Scene], dict[str, float]] | None = None
    typical: float = 1.0
    linear: bool = True  # whether small doses move the readings in proportion
    largest: float = 30.0
    smallest: float = 0.0  # where a smaller dose is too stiff to integrate
    fit_rig: Callable[[np.random.Generator, Rig], Rig] | None = None

    def acts(self, scene: Scene) -> bool:
        """Whether the effect is there in this trial: water needs water."""
        return self.place not in ("water", "outside") or scene.wet

    def applied(self, shape: Shape, dose: float, scene: Scene) -> Change:
        """The change of this trial, none where the effect does not act."""
        return self.change(shape, dose, scene) if self.acts(scene) and dose > 0.0 else Change(scene.body)


TABLE: dict[str, EffectKind] = {}


def add(*kinds: EffectKind) -> None:
    """Put kinds into the table; two with one key are refused."""
    for kind in kinds:
        if kind.key in TABLE:
            raise ValueError(f"effect {kind.key}: it is in the table already; give the second one another key")
        TABLE[kind.key] = kind


def table() -> dict[str, EffectKind]:
    """All kinds by key."""
    from experiments.blind_challenge import catalogue, forcing, instruments, outside, water_effects  # noqa: F401 (they fill it)

    return TABLE


def kind(key: str) -> EffectKind:
    """The kind of that key, or a sentence with the keys there are."""
    if key not in table():
        raise KeyError(f"effect {key}: not in the table; choose one of {', '.join(sorted(TABLE))}")
    return TABLE[key]


def nothing(rng: np.random.Generator, rig: Rig) -> Shape:
    """A shape without numbers."""
    return {}
