"""What the solver is worth: closed cells against linear theory, energy, the time step, the mesh and the sponge.

Numbers only; tables.py writes them down. Nothing here changes the solver or the data. `write` makes
results/checks.md and results/convergence.md with the numbers beside them as JSON (about 5 minutes on one core).
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from experiments.virtual_flume import campaign, frequency, section, structure, tables
from experiments.virtual_flume.frequency import DENSITY, GRAVITY, Mode, Water
from experiments.virtual_flume.march import Flume, energy
from experiments.virtual_flume.mesh import Spacing
from experiments.virtual_flume.water import closed_cells, flume_water

Array = np.ndarray

CELLS_M = ((0.327, 0.07), (0.334, 0.14), (0.289, 0.21))
"""Width and depth (m) of the closed cells: surface width and wetted height at the three levels with a surface."""

HIGHEST_SLOSH = 40.0
"""rad/s; the third antisymmetric slosh of the widest cell is at 21 rad/s, of the narrowest at 23."""

LIGHT = 0.10
"""Largest damping ratio of a pole that is followed: those above belong to the absorbed outer water."""

LEAST_POLE_KG = 3.0
"""Participating mass of the least pole that is followed; truth.json lists no smaller."""

LEAST_SHARE = 0.05
"""Share of a release at a body frequency from which A and B there are compared."""


@dataclass(frozen=True)
class ClosedCell:
    """One antisymmetric slosh (`order` 1, 3, 5): frequencies rad/s, participating masses as shares of the water."""

    width_m: float
    depth_m: float
    order: int
    frequency: float
    law_frequency: float
    mass_share: float
    law_mass_share: float

    @property
    def frequency_error(self) -> float:
        """Relative error of the frequency."""
        return self.frequency / self.law_frequency - 1.0

    @property
    def mass_error(self) -> float:
        """Relative error of the participating mass."""
        return self.mass_share / self.law_mass_share - 1.0


def closed_cell(width_m: float, depth_m: float, refine: float = 1.0) -> list[ClosedCell]:
    """The first three sloshes of a swaying rectangular tank beside linear theory.

    w = sqrt(g k tanh k h), k = n pi / width, and m_n / m = 8 width tanh(k h) / (pi^3 n^3 h) for n = 1, 3, 5: Graham
    and Rodriguez 1952 (J. Appl. Mech. 19, 381), Ibrahim 2005 (doi:10.1017/CBO9780511536656), chapter 5.
    """
    found = frequency.modes(closed_cells(width_m, depth_m, 1.0, refine), (0.5, HIGHEST_SLOSH))
    rows = []
    for order, mode in zip((1, 3, 5), found, strict=False):
        k = order * np.pi / width_m
        rate = float(np.tanh(k * depth_m))
        share = 8.0 * width_m * rate / ((np.pi * order) ** 3 * depth_m)
        water = DENSITY * width_m * depth_m
        law = float(np.sqrt(GRAVITY * k * rate))
        rows.append(
            ClosedCell(
                width_m, depth_m, order, mode.frequency, law, float(mode.participating_mass / water), float(share)
            )
        )
    return rows


@dataclass(frozen=True)
class Kept:
    """Largest relative change of the energy in a release without losses, over `duration_s`."""

    depth_m: float
    spring: str
    duration_s: float
    largest_change: float


def lossless_energy(depth_m: float, spring: str, duration_s: float, spacing: Spacing | None = None) -> Kept:
    """A release with no friction, drag, damper, sponge or layers: all its energy must stay."""
    water = flume_water(depth_m, spacing, lossless=True)
    body = structure.Structure(structure.MASS_KG, structure.SPRINGS[spring].stiffness, 0.0, 0.0, 0.0)
    time = np.arange(0.0, duration_s, 0.02)
    motion = Flume(body, water).release(campaign.RELEASES_M[spring][-1], 0.0, time, keep_surface=True)
    total = energy(water, body, motion)
    return Kept(depth_m, spring, duration_s, float(np.max(np.abs(total / total[0] - 1.0))))


@dataclass(frozen=True)
class Halved:
    """Largest change (m, m/s2) of displacement and acceleration in a trial when the time step is halved."""

    file: str
    depth_m: float
    spring: str
    displacement: float
    acceleration: float


def halved_step(number: int) -> Halved:
    """Trial `number` of the campaign marched again with steps of 1 ms where the data have 2 ms."""
    trial = campaign.trials()[number]
    level = section.Level(trial.water_depth_m)
    body = structure.structure(level, trial.stiffness_N_per_m, trial.damping_Ns_per_m, trial.friction)
    usual = campaign.motion_of(trial)
    time = np.linspace(usual.time[0], usual.time[-1], 4 * (usual.time.size - 1) + 1)
    fine = Flume(body, campaign.water_at(trial.water_depth_m)).release(trial.x0_m, trial.release_s, time)
    dx, da = float(np.max(np.abs(fine.x[::4] - usual.x))), float(np.max(np.abs(fine.a[::4] - usual.a)))
    return Halved(trial.file, trial.water_depth_m, trial.spring, dx, da)


def variants(depth_m: float) -> dict[str, Water]:
    """The water of a level with every element halved, the sponge twice as far, twice as long, twice as strong."""
    usual = Spacing()
    base = flume_water(depth_m, usual)
    start = section.deck_half_width_m() + usual.open_water_m
    twice = {"fine_sponge_m": 2.0 * usual.fine_sponge_m, "sponge_m": 2.0 * usual.sponge_m}
    return {
        "elements halved": flume_water(depth_m, replace(usual, refine=2.0)),
        "sponge twice as far": flume_water(depth_m, replace(usual, open_water_m=2.0 * usual.open_water_m)),
        "sponge twice as long": flume_water(depth_m, replace(usual, **twice)),
        "sponge twice as strong": replace(base, loss=np.where(base.operators.x > start, 2.0, 1.0) * base.loss),
    }


@dataclass(frozen=True)
class Shift:
    """A quantity of one level: its value in the data's water, and its relative change by variant.

    `share`: of a release at that body frequency, for A and B. `participating_mass`: kg, for a pole.
    """

    depth_m: float
    quantity: str
    spring: str
    frequency: float
    value: float
    change: dict[str, float]
    share: float | None = None
    participating_mass: float | None = None


def pole_shifts(depth_m: float, base: Water, others: dict[str, Water]) -> list[Shift]:
    """Frequencies (rad/s) of the light poles and how far each moves: to the pole nearest in s, of like mass."""
    followed = [m for m in frequency.modes(base) if m.damping_ratio < LIGHT and m.participating_mass > LEAST_POLE_KG]
    found = {name: frequency.modes(water) for name, water in others.items()}
    rows = []
    for mode in followed:
        change = {name: _nearest(mode, poles).frequency / mode.frequency - 1.0 for name, poles in found.items()}
        rows.append(
            Shift(
                depth_m, "pole", "", mode.frequency, mode.frequency, change,
                participating_mass=float(mode.participating_mass),
            )
        )  # fmt: skip
    return rows


def _nearest(mode: Mode, poles: list[Mode]) -> Mode:
    """The pole nearest in the plane of s among those with at least half the mass."""

    def place(m: Mode) -> complex:
        return m.frequency * complex(-m.damping_ratio, np.sqrt(1.0 - m.damping_ratio**2))

    alike = [m for m in poles if m.damping_ratio < 1.0 and m.participating_mass > 0.5 * mode.participating_mass]
    return min(alike, key=lambda m: abs(place(m) - place(mode)))


def coefficient_shifts(depth_m: float, base: Water, others: dict[str, Water]) -> list[Shift]:
    """A (kg) and B (N s/m) at the body's frequencies in the data's water, and their change at those frequencies."""
    rows = []
    for spring, nominal in structure.SPRINGS.items():
        for body in frequency.body_frequencies(base, structure.MASS_KG, nominal.stiffness):
            if body.share < LEAST_SHARE:
                continue
            at = np.array([body.frequency])
            usual = np.concatenate(frequency.added_mass_and_damping(base, at))
            moved = {
                name: np.concatenate(frequency.added_mass_and_damping(water, at)) / usual - 1.0
                for name, water in others.items()
            }
            for i, name in enumerate(("A", "B")):
                change = {key: float(v[i]) for key, v in moved.items()}
                rows.append(Shift(depth_m, name, spring, body.frequency, float(usual[i]), change, body.share))
    return rows


def write(folder: Path, say: Callable[[str], None]) -> None:
    """Both studies into a folder: checks.{md,json} and convergence.{md,json}."""
    folder.mkdir(parents=True, exist_ok=True)
    cells = [row for width, depth in CELLS_M for row in closed_cell(width, depth)]
    say("closed cells done")
    kept = [lossless_energy(depth, spring, 14.0) for depth in (2.29, 2.36) for spring in structure.SPRINGS]
    say("energy done")
    numbers = [t.number for t in campaign.trials() if t.water_depth_m in (2.29, 2.36) and t.number % 5 == 4]
    halved = [halved_step(number) for number in numbers]
    say("time step done")
    _keep(folder / "checks", tables.checks(cells, kept, halved), [*cells, *kept, *halved])
    rows: list[Shift] = []
    for depth in section.WET_DEPTHS_M:
        base, others = flume_water(depth), variants(depth)
        rows += pole_shifts(depth, base, others) + coefficient_shifts(depth, base, others)
        say(f"mesh and sponge at {depth:.2f} m done")
    _keep(folder / "convergence", tables.convergence(rows), rows)


def _keep(path: Path, page: str, rows: list[ClosedCell | Kept | Halved] | list[Shift]) -> None:
    """The page and its numbers, six digits."""
    path.with_suffix(".md").write_text(page, encoding="utf-8")
    kept = [{"kind": type(row).__name__, **asdict(row)} for row in rows]
    short = json.loads(json.dumps(kept), parse_float=lambda text: float(f"{float(text):.6g}"))
    lines = ",\n".join(" " + json.dumps(row) for row in short)
    path.with_suffix(".json").write_text(f"[\n{lines}\n]\n", encoding="utf-8")
