"""What the solver is worth: closed cells against linear theory, energy, the time step, the mesh and the sponge.

Numbers only; tables.py writes them down. Nothing here changes the solver or the data. `write` makes
results/checks.md and results/convergence.md with the numbers beside them as JSON (two and a half minutes on one core).
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

from experiments.virtual_flume import campaign, frequency, section, structure, tables
from experiments.virtual_flume.frequency import DENSITY, GRAVITY, Water
from experiments.virtual_flume.march import Flume, energy
from experiments.virtual_flume.mesh import Spacing
from experiments.virtual_flume.trials import rounded
from experiments.virtual_flume.water import closed_cells, flume_water

Array = np.ndarray

CELLS_M = ((0.327, 0.07), (0.334, 0.14), (0.289, 0.21))
"""Width and depth (m) of the closed cells: surface width and wetted height at the three levels with a surface."""

HIGHEST_SLOSH = 40.0
"""rad/s; the third antisymmetric slosh of the widest cell is at 21 rad/s, of the narrowest at 23."""

LEAST_SHARE = 0.05
"""Share of a release at a body frequency from which A and B there are compared."""

POLE_TURNS, POLE_STEP = 30, 1e-9
"""Newton's turns at most, and the relative step at which a pole stands still."""

TRUTH = Path(__file__).resolve().parents[2] / "data" / "virtual_flume" / "truth.json"


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


HALVED_AT_M = (2.36, 2.22, 2.29, 2.43, 2.57)
"""Levels at which every element size is halved too: a minute or two each."""


def variants(depth_m: float, base: Water) -> dict[str, Water]:
    """The water of a level with the sizes of elements doubled, the sponge twice as far, and twice as strong."""
    usual = Spacing()
    start = section.deck_half_width_m() + usual.open_water_m
    return {
        "elements doubled": flume_water(depth_m, replace(usual, refine=0.5)),
        "sponge twice as far": flume_water(depth_m, replace(usual, open_water_m=2.0 * usual.open_water_m)),
        "sponge twice as strong": replace(base, loss=np.where(base.operators.x > start, 2.0, 1.0) * base.loss),
    }


def halved(depth_m: float) -> dict[str, Water]:
    """The water of a level with every element size halved."""
    return {"elements halved": flume_water(depth_m, Spacing(refine=2.0))}


@dataclass(frozen=True)
class Shift:
    """A quantity of one level: its value in the data's water, and its relative change by variant.

    `quantity` is pole (rad/s), A (kg) or B (N s/m); `weight` the pole's participating mass (kg), or the share of a
    release that the body's frequency carries.
    """

    depth_m: float
    quantity: str
    spring: str
    frequency: float
    value: float
    weight: float
    change: dict[str, float]


def pole_near(water: Water, guess: complex) -> complex:
    """The pole of the apparent mass nearest to a guess, both 1/s, by Newton's method on S + M (s + n)^2 / g.

    Begins with the surface's answer to a sway at the guess, so that what the body drives is found.

    Raises ValueError where it does not stand still.
    """
    o = water.operators
    s, p = guess, np.zeros(o.x.size, dtype=complex)
    for turn in range(POLE_TURNS):
        shifted = s + water.loss
        matrix = o.stiffness + o.mass * (shifted[:, None] * shifted[None, :]) / GRAVITY
        slope = o.mass * (shifted[:, None] + shifted[None, :]) / GRAVITY
        u = np.linalg.solve(matrix, slope @ p if turn else o.coupling.astype(complex))
        if turn:
            step = (p @ p) / (p @ u)
            s -= step
            if abs(step) < POLE_STEP * abs(s):
                return complex(s)
        p = u / np.sqrt(u @ u)
    raise ValueError(
        f"pole near {guess:.5g} 1/s: still moving after {POLE_TURNS} turns, last at {s:.5g} 1/s; begin nearer to it"
    )


Row = ClosedCell | Kept | Halved | Shift


def shifts(depth_m: float, base: Water, others: dict[str, Water]) -> list[Shift]:
    """Poles named in the truth file, A and B at the body's frequencies, and how far each variant moves them."""
    said = json.loads(TRUTH.read_text(encoding="utf-8"))["levels"][f"{depth_m:.2f}"]
    rows = []
    for mode in said["hidden_resonators"]:
        zeta = mode["damping_ratio"]
        usual = pole_near(base, mode["frequency"] * complex(-zeta, np.sqrt(1.0 - zeta**2)))
        change = {name: abs(pole_near(water, usual)) / abs(usual) - 1.0 for name, water in others.items()}
        rows.append(Shift(depth_m, "pole", "", abs(usual), abs(usual), mode["participating_mass"], change))
    for spring, answer in said["by_spring"].items():
        for body in answer["frequencies_and_shares_of_a_release"]:
            if body["share"] >= LEAST_SHARE:
                rows += _coefficients(depth_m, spring, body, base, others)
    return rows


def _coefficients(
    depth_m: float, spring: str, body: dict[str, float], base: Water, others: dict[str, Water]
) -> list[Shift]:
    """A (kg) and B (N s/m) at one body frequency, held while the water changes."""
    at = np.array([body["frequency"]])
    usual = np.concatenate(frequency.added_mass_and_damping(base, at))
    moved = {
        name: np.concatenate(frequency.added_mass_and_damping(water, at)) / usual - 1.0
        for name, water in others.items()
    }
    return [
        Shift(
            depth_m, quantity, spring, body["frequency"], float(usual[i]), body["share"],
            {name: float(v[i]) for name, v in moved.items()},
        )
        for i, quantity in enumerate(("A", "B"))
    ]  # fmt: skip


def write(folder: Path, say: Callable[[str], None]) -> None:
    """Both studies into a folder: checks.{md,json} and convergence.{md,json}."""
    folder.mkdir(parents=True, exist_ok=True)
    cells = [_short(row) for width, depth in CELLS_M for row in closed_cell(width, depth)]
    say("closed cells done")
    kept = [_short(lossless_energy(depth, spring, 14.0)) for depth in (2.29, 2.36) for spring in structure.SPRINGS]
    say("energy done")
    numbers = [t.number for t in campaign.trials() if t.water_depth_m in (2.29, 2.36) and t.number % 5 == 4]
    finer = [_short(halved_step(number)) for number in numbers]
    say("time step done")
    _keep(folder / "checks", tables.checks(cells, kept, finer), [*cells, *kept, *finer])
    write_convergence(folder, say)


def write_convergence(folder: Path, say: Callable[[str], None]) -> None:
    """The study of mesh and sponge into convergence.{md,json}, kept as it grows."""
    rows: dict[tuple[float, str, float], Shift] = {}
    for depth in section.WET_DEPTHS_M:
        base = flume_water(depth)
        for row in shifts(depth, base, variants(depth, base)):
            rows[(depth, row.spring + row.quantity, row.frequency)] = row
        say(f"sponge at {depth:.2f} m done")
    for depth in HALVED_AT_M:
        for row in shifts(depth, flume_water(depth), halved(depth)):
            key = (depth, row.spring + row.quantity, row.frequency)
            rows[key] = replace(row, change={**row.change, **rows[key].change})
        say(f"mesh at {depth:.2f} m done")
        short = [_short(row) for row in rows.values()]
        _keep(folder / "convergence", tables.convergence(short), short)


def _short(row: Row) -> Row:
    """The row with its numbers to six digits, so that page and JSON say the same."""
    return type(row)(**rounded(asdict(row), 6))


def _keep(path: Path, page: str, rows: Sequence[Row]) -> None:
    """The page and its numbers."""
    path.with_suffix(".md").write_text(page, encoding="utf-8")
    lines = ",\n".join(" " + json.dumps({"kind": type(row).__name__, **asdict(row)}) for row in rows)
    path.with_suffix(".json").write_text(f"[\n{lines}\n]\n", encoding="utf-8")
