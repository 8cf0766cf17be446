"""Which campaigns are rescaled, and by how much: practice, both flumes, Eq. 15 itself, the names study.

Belongs here: that list. Does not belong here: how a campaign is rescaled (rescale.py), the comparison (compare.py).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from experiments.invariance.rescale import Scale
from experiments.names.folder import write
from experiments.names.studies import STUDIES

ROOT = Path(__file__).resolve().parents[2]

TIME, LENGTH, MASS = (1.0 / 30.0, 20.0), (1e-3, 30.0), (1e-6, 1e4)
"""Ranges of the factors: a watch's balance and a ship beside a bridge."""

ON_DISK = (
    "configs/practice/one.yaml", "configs/practice/two.yaml", "configs/practice/three.yaml",
    "configs/practice/four.yaml", "configs/flume.yaml", "configs/nonlinear_cell.yaml", "configs/eq15.yaml",
)  # fmt: skip
"""Campaigns with a config of their own; those of the practice set lie beside the repository."""

PLANTED = ("", "linear_damping", "hidden_resonator", "cubic_stiffness", "external_forcing")
"""Campaigns of the names study: nothing, and one effect each."""

STRENGTH = 3.0
"""Size of an effect, in what repeating the test gives."""

SEED = 8100
"""Seed of these campaigns and of the factors; no rule was made on them."""


def scales(campaign: int, count: int) -> Sequence[Scale]:
    """So many scales for a campaign, drawn evenly in the logarithm; the first ones are the ranges' corners."""
    rng = np.random.default_rng([SEED, campaign])
    corners = (Scale(TIME[0], LENGTH[0], MASS[0]), Scale(TIME[1], LENGTH[1], MASS[1]))
    drawn = [Scale(*(float(np.exp(rng.uniform(*np.log(ends)))) for ends in (TIME, LENGTH, MASS))) for _ in range(count)]
    return (corners[campaign % 2], *drawn)[:count]


def makers(names: Sequence[str] = ()) -> dict[str, Callable[[Path], Path | None]]:
    """Campaign name -> function that gives its config, made in the folder where it has to be (None: it is absent)."""
    found: dict[str, Callable[[Path], Path | None]] = {}
    for config in ON_DISK:
        found[Path(config).stem] = lambda folder, config=config: _present(ROOT / config)
    for effect in PLANTED:
        found[effect or "nothing"] = lambda folder, effect=effect: _planted(effect, folder)
    return {name: make for name, make in found.items() if not names or name in names}


def _present(config: Path) -> Path | None:
    lies_outside = "../shared" in config.read_text(encoding="utf-8")
    return None if lies_outside and not (ROOT.parent / "shared" / "practice").is_dir() else config


def _planted(effect: str, folder: Path) -> Path:
    seeds = range(SEED, SEED + 1)
    told = {"names": (effect,), "strengths": (STRENGTH,)}
    case = next(iter(STUDIES["confusion"](seeds, **told) if effect else STUDIES["nulls"](seeds)))
    return write(case.campaign, folder, case.view)
