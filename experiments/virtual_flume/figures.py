"""The page's four pictures: the section, the surface in the cells, A and B over frequency, a beat.

A drawing function takes finished numbers and Axes; `write` computes them from the flume alone (a minute) and saves
small SVG files that are the same, byte for byte, on one machine.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from experiments.virtual_flume import answer, campaign, section
from experiments.virtual_flume.march import Motion

Array = np.ndarray

WATER, DEEP, CONCRETE = "#cfe3f1", "#1f6fa8", "#b9b4ab"
SPRING_COLOURS = {"long": "#8a4b08", "short": "#6b2f8a"}
SHOWN_HALF_WIDTH_M = 1.45
BEAT_LEVEL_M = 2.36
CELL_LEVEL_M = 2.29
"""Where the largest release of the short spring keeps the surface (just) under the soffit."""

RCPARAMS = {
    "svg.hashsalt": "virtual flume", "svg.fonttype": "none", "font.size": 9.0, "axes.spines.top": False,
    "axes.spines.right": False,
}  # fmt: skip


def draw_concrete(axes: Axes) -> Axes:
    """Both halves of the section at rest; metres, heights above the floor."""
    for half in section.solid_half_outline_m():
        for sign in (1.0, -1.0):
            axes.add_patch(Polygon(half * (sign, 1.0), closed=True, facecolor=CONCRETE, edgecolor=CONCRETE, lw=0.3))
    return axes


def surface_pieces(x: Array, eta: Array, level: section.Level) -> list[tuple[Array, Array]]:
    """The surface (m) of the whole section, one piece a cell and one each side: the half mirrored, eta(-x) = -eta(x).

    `x` (n,) are the half's nodes, `eta` (n,) the elevation there; x = 0, where it is zero, is no node.
    """
    x, eta = np.concatenate([[0.0], x]), np.concatenate([[0.0], eta])
    half = 0.5 * section.girder_width_m(level.wetted_height_m)
    walls = [wall for centre in section.girder_centres_m() for wall in (centre - half, centre + half)]
    limits = [0.0, *walls, np.inf]
    pieces = []
    for low, high in zip(limits[::2], limits[1::2], strict=True):
        inside = (x > low - 1e-6) & (x < high + 1e-6)
        pieces.append((x[inside], eta[inside]))
    mirrored = [(-px[::-1], -pe[::-1]) for px, pe in pieces]
    middle = (np.concatenate([mirrored[0][0], pieces[0][0]]), np.concatenate([mirrored[0][1], pieces[0][1]]))
    return [*reversed(mirrored[1:]), middle, *pieces[1:]]


def draw_water(axes: Axes, pieces: list[tuple[Array, Array]], level: section.Level, below_m: float) -> Axes:
    """Water from a height below the section up to the surface, and the surface as a line."""
    reach = 0.5 * section.girder_width_m(level.wetted_height_m)  # to the girders' middles, behind the concrete
    axes.axhspan(below_m, section.GIRDER_BOTTOM_M, color=WATER, lw=0, zorder=-2)
    for whole, heights in pieces:
        shown = np.abs(whole) < SHOWN_HALF_WIDTH_M + 0.1
        x, eta = whole[shown], heights[shown]
        under_flanges = np.concatenate([[x[0] - reach], x, [x[-1] + reach]])
        height = level.depth_m + np.concatenate([eta[:1], eta, eta[-1:]])
        axes.fill_between(under_flanges, section.GIRDER_BOTTOM_M - 0.002, height, color=WATER, lw=0, zorder=-2)
        axes.plot(x, level.depth_m + eta, color=DEEP, lw=1.0)
    return axes


def draw_section(axes: Axes) -> Axes:
    """The section with its water at 2.36 m, the other levels as dashes, and its sizes."""
    level = section.Level(BEAT_LEVEL_M)
    x = np.linspace(0.0, SHOWN_HALF_WIDTH_M, 300)[1:]
    draw_water(axes, surface_pieces(x, 0.0 * x, level), level, 2.0)
    draw_concrete(axes)
    edge = section.deck_half_width_m()
    for depth in section.WET_DEPTHS_M:
        axes.plot([edge + 0.06, SHOWN_HALF_WIDTH_M], [depth, depth], color=DEEP, lw=0.7, ls=(0, (4, 3)))
        axes.annotate(
            f"{depth:.2f} m", (SHOWN_HALF_WIDTH_M, depth), (3, 0), textcoords="offset points", va="center", color=DEEP
        )
    arrow = {"arrowstyle": "<->", "lw": 0.7}
    left, right = section.girder_centres_m()[:2]
    for low, high, z, text in ((left, right, 2.10, "0.37 m"), (-edge, edge, 2.49, f"{2.0 * edge:.2f} m")):
        axes.annotate("", (low, z), (high, z), arrowprops=arrow)
        axes.text(0.5 * (low + high), z + 0.008, text, ha="center", va="bottom")
    axes.annotate("", (-edge - 0.1, 2.15), (-edge - 0.1, 2.43), arrowprops=arrow)
    axes.text(-edge - 0.13, 2.29, "0.28 m", ha="right", va="center")
    axes.set(xlim=(-SHOWN_HALF_WIDTH_M, SHOWN_HALF_WIDTH_M), ylim=(2.0, 2.62), aspect="equal")
    axes.set(xlabel="x, m", ylabel="height above the floor, m")
    return axes


def draw_coefficients(axes: tuple[Axes, Axes], level: answer.LevelAnswer) -> tuple[Axes, Axes]:
    """A (kg) and B (N s/m) over frequency, with every body frequency that carries 5 % of a release."""
    for panel, values, scale in zip(axes, (level.added_mass, level.damping), (1e3, 1e3), strict=True):
        panel.plot(level.w, values / scale, color=DEEP, lw=1.0)
        panel.axhline(0.0, color="0.6", lw=0.5)
        for spring, body in level.body.items():
            for one in body["frequencies_and_shares_of_a_release"]:  # type: ignore[attr-defined]
                if one["share"] >= 0.05:
                    panel.axvline(one["frequency"], color=SPRING_COLOURS[spring], lw=0.4 + 1.4 * one["share"], ls="--")
        panel.set_xlim(*answer.FIT_BAND)
    axes[0].set_ylim(-1.5, 4.0)
    axes[1].set_ylim(-0.2, 6.0)
    axes[0].set_ylabel(f"{level.depth_m:.2f} m\nA, t")
    axes[1].set_ylabel("B, kN s/m")
    return axes


def draw_beat(axes: tuple[Axes, Axes], motion: Motion, wall_m: Array, start_s: float) -> tuple[Axes, Axes]:
    """Displacement (mm) and the surface at the middle cell's right wall (mm), both over time since the release."""
    t = motion.time - start_s
    axes[0].plot(t, 1e3 * motion.x, color="0.2", lw=0.8)
    axes[1].plot(t, 1e3 * wall_m, color=DEEP, lw=0.8)
    axes[0].set_ylabel("displacement, mm")
    axes[1].set_ylabel("surface at the\nmiddle cell's wall, mm")
    axes[1].set_xlabel("time since release, s")
    return axes


def _save(figure: Figure, path: Path) -> None:
    figure.savefig(path, metadata={"Date": None, "Creator": None}, bbox_inches="tight")


def _section_picture(folder: Path) -> None:
    figure = Figure(figsize=(7.5, 2.2))
    draw_section(figure.subplots())
    _save(figure, folder / "section.svg")


def _coefficient_picture(folder: Path) -> None:
    figure = Figure(figsize=(7.5, 8.0), layout="constrained")
    panels = figure.subplots(len(section.WET_DEPTHS_M), 2, sharex=True)
    for row, depth in zip(panels, section.WET_DEPTHS_M, strict=True):
        draw_coefficients(tuple(row), answer.level_answer(depth, campaign.water_at(depth)))
    for panel in panels[-1]:
        panel.set_xlabel("frequency, rad/s")
    panels[0, 0].set_title("added mass", fontsize=9)
    panels[0, 1].set_title("radiation damping", fontsize=9)
    for spring, colour in SPRING_COLOURS.items():
        panels[0, 1].plot([], [], color=colour, ls="--", label=f"body on the {spring} spring")
    panels[0, 1].legend(fontsize=7, frameon=False, loc="upper right")
    _save(figure, folder / "added_mass_and_damping.svg")


def release_of_short_spring(depth_m: float) -> tuple[campaign.Trial, Motion, Array]:
    """The largest release of the short spring at a level: its trial, motion with surface, and the nodes' x (m).

    Raises ValueError where the level is dry.
    """
    water = campaign.water_at(depth_m)
    if water is None:
        raise ValueError(f"water depth {depth_m} m is dry; the picture needs one of {section.WET_DEPTHS_M} m")
    chosen = [t for t in campaign.trials() if t.water_depth_m == depth_m and t.spring == "short"]
    trial = max(chosen, key=lambda t: t.x0_target_m)
    return trial, campaign.motion_of(trial, keep_surface=True), water.operators.x


def at_wall_of_middle_cell(motion: Motion, x: Array, depth_m: float) -> Array:
    """Elevation (m) at the middle cell's right wall, (t,)."""
    wall = section.girder_centres_m()[0] - 0.5 * section.girder_width_m(section.Level(depth_m).wetted_height_m)
    return motion.eta[:, int(np.argmin(np.abs(x - wall)))]


def _beat_picture(folder: Path) -> None:
    trial, motion, x = release_of_short_spring(BEAT_LEVEL_M)
    figure = Figure(figsize=(7.5, 3.4), layout="constrained")
    wall = at_wall_of_middle_cell(motion, x, BEAT_LEVEL_M)
    draw_beat(tuple(figure.subplots(2, 1, sharex=True)), motion, wall, trial.release_s)
    _save(figure, folder / "beats.svg")


def _surface_picture(folder: Path) -> None:
    trial, motion, x = release_of_short_spring(CELL_LEVEL_M)
    level = section.Level(CELL_LEVEL_M)
    period = 2.0 * np.pi / slosh_frequency(CELL_LEVEL_M)
    highest = int(np.argmax(np.abs(at_wall_of_middle_cell(motion, x, CELL_LEVEL_M))))
    instants = [int(np.searchsorted(motion.time, motion.time[highest] + q * period / 4.0)) for q in range(4)]
    figure = Figure(figsize=(7.5, 5.6), layout="constrained")
    for panel, i in zip(figure.subplots(4, 1, sharex=True), instants, strict=True):
        draw_water(panel, surface_pieces(x, motion.eta[i], level), level, 2.05)
        draw_concrete(panel)
        panel.set(xlim=(-SHOWN_HALF_WIDTH_M, SHOWN_HALF_WIDTH_M), ylim=(2.05, 2.48), aspect="equal")
        panel.set_ylabel("height, m")
        panel.set_title(
            f"{motion.time[i] - trial.release_s:.2f} s after the release, body at {1e3 * motion.x[i]:+.1f} mm",
            fontsize=8, loc="left", pad=2,
        )  # fmt: skip
    panel.set_xlabel("x, m")
    _save(figure, folder / "surface.svg")


def slosh_frequency(depth_m: float) -> float:
    """Frequency (rad/s) of the heaviest light pole at a level: the cells' common slosh."""
    water = campaign.water_at(depth_m)
    if water is None:
        raise ValueError(f"water depth {depth_m} m is dry; no slosh there, choose one of {section.WET_DEPTHS_M}")
    light = [m for m in answer.frequency.modes(water) if m.damping_ratio < answer.LARGEST_DAMPING_RATIO]
    return light[0].frequency


def write(folder: Path, say: Callable[[str], None]) -> None:
    """All pictures into a folder, and their sizes said."""
    folder.mkdir(parents=True, exist_ok=True)
    with mpl.rc_context(RCPARAMS):
        for make in (_section_picture, _surface_picture, _beat_picture, _coefficient_picture):
            make(folder)
    for path in sorted(folder.glob("*.svg")):
        say(f"{path.name}: {path.stat().st_size / 1000:.0f} kB")
