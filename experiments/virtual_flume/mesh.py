"""Graded meshes of trapezoids for the right half of a section that is symmetric about x = 0.

A mesh is a rectangle of rows and columns in index space. Rows are level; the lines between columns follow
the girders' sides, so that every wall is a line of the mesh; elements inside the concrete are marked dry. No
physics here.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from experiments.virtual_flume import section

Array = np.ndarray


@dataclass(frozen=True)
class Spacing:
    """Element sizes (m; quadratic elements, so nodes stand half as far apart) and the reach of the water.

    `refine` divides every size. `open_water_m` is left free; then comes the sponge, whose first
    `fine_sponge_m` keep the open water's elements: they absorb the short waves, and a coarser mesh there
    would throw those back.
    """

    refine: float = 1.0
    corner_m: float = 0.005
    near_m: float = 0.020
    growth: float = 0.30
    far_m: float = 0.06
    deep_m: float = 0.35
    open_water_m: float = 3.0
    fine_sponge_m: float = 3.5
    sponge_m: float = 12.0


@dataclass(frozen=True)
class TrapezoidMesh:
    """`x` (rows+1, columns+1) and `z` (rows+1,) of the corners, m; `wet` (rows, columns) marks the water.

    The free surface is the upper side of the wet elements of the last row.
    """

    x: Array
    z: Array
    wet: Array


def graded(start: float, end: float, first: float, last: float, growth: float, largest: float) -> Array:
    """Points from start to end, spaced `first` and `last` at the ends and growing by `growth` a metre; m.

    >>> graded(0.0, 1.0, 0.5, 0.5, 0.0, 0.5).tolist()
    [0.0, 0.5, 1.0]
    """
    s = np.linspace(start, end, 2001)
    size = np.minimum(np.minimum(first + growth * (s - start), last + growth * (end - s)), largest)
    count = np.concatenate([[0.0], np.cumsum(0.5 * (1.0 / size[1:] + 1.0 / size[:-1]) * np.diff(s))])
    n = max(1, int(np.ceil(count[-1] - 1e-9)))
    points = np.interp(np.linspace(0.0, count[-1], n + 1), count, s)
    points[0], points[-1] = start, end
    return points


def rectangular_tank(width_m: float, depth_m: float, refine: float = 1.0) -> TrapezoidMesh:
    """Right half of a closed rectangular cell: x from 0 to half the width, z from 0 to the depth; m."""
    fine, coarse = width_m / 60.0 / refine, width_m / 20.0 / refine
    x = graded(0.0, 0.5 * width_m, coarse, fine, 0.3, coarse)
    z = graded(0.0, depth_m, coarse, fine, 0.3, coarse)
    return TrapezoidMesh(np.tile(x, (z.size, 1)), z, np.ones((z.size - 1, x.size - 1), dtype=bool))


def flume(depth_m: float, spacing: Spacing | None = None) -> TrapezoidMesh:
    """Right half of the flume's water around the bridge section at a still level; all m.

    Raises ValueError where the water does not reach the girders.
    """
    spacing = spacing or Spacing()
    if section.Level(depth_m).is_dry:
        raise ValueError(
            f"water depth {depth_m} m does not reach the girders' bottom at {section.GIRDER_BOTTOM_M} m; "
            "there is no water section to mesh"
        )
    z = _rows(depth_m, spacing)
    height = z - section.GIRDER_BOTTOM_M
    columns, owner = _column_fractions(spacing)
    edges = _edge_lines(height, spacing)
    x = np.empty((z.size, columns.size))
    block = np.minimum(columns.astype(int), edges.shape[1] - 2)
    fraction = columns - block
    x[:] = edges[:, block] * (1.0 - fraction) + edges[:, block + 1] * fraction
    middle = 0.5 * (height[1:] + height[:-1])[:, None]
    in_girder = (owner % 2 == 1)[None, :] & (middle > 0.0) & (middle < section.GIRDER_HEIGHT_M)
    under_deck_edge = (owner < edges.shape[1] - 2)[None, :]
    in_deck = under_deck_edge & (middle > section.GIRDER_HEIGHT_M) & (middle < section.TOTAL_HEIGHT_M)
    return TrapezoidMesh(x, z, ~(in_girder | in_deck))


def _rows(depth_m: float, spacing: Spacing) -> Array:
    """Heights of the row lines from the floor to the level; m."""
    r = spacing.refine
    marks = [z for z, _ in section.PROFILE_M]
    marks += [section.GIRDER_HEIGHT_M + section.DECK_CHAMFER_M, section.TOTAL_HEIGHT_M]
    wet = depth_m - section.GIRDER_BOTTOM_M
    stops = [z for z in marks if z < wet - 1e-9] + [wet]
    fine, near = spacing.corner_m / r, spacing.near_m / r
    rows = [
        graded(0.0, section.GIRDER_BOTTOM_M, spacing.deep_m / r, fine, spacing.growth, spacing.deep_m / r)
    ]
    for low, high in pairwise(stops):
        rows.append(section.GIRDER_BOTTOM_M + graded(low, high, fine, fine, spacing.growth, near)[1:])
    return np.concatenate(rows)


def _blocks(spacing: Spacing) -> list[Array]:
    """Points of each block of columns at the girders' bottom: x = 0, the girders' sides, the far end; m."""
    r, half = spacing.refine, 0.5 * section.BOTTOM_FLANGE_M
    fine, near = spacing.corner_m / r, spacing.near_m / r
    stops = [0.0]
    for centre in section.girder_centres_m():
        stops += [centre - half, centre + half]
    blocks = []
    for i, (low, high) in enumerate(pairwise(stops)):
        blocks.append(graded(low, high, near if i == 0 else fine, fine, spacing.growth, near))
    fine_end = stops[-1] + spacing.open_water_m + spacing.fine_sponge_m
    end = stops[-1] + spacing.open_water_m + spacing.sponge_m
    far = spacing.far_m / r
    outside = graded(stops[-1], fine_end, fine, far, 0.06, far)
    sponge = graded(fine_end, end, far, 4.0 * far, 0.05, 4.0 * far)
    return [*blocks, np.concatenate([outside, sponge[1:]])]


def _column_fractions(spacing: Spacing) -> tuple[Array, Array]:
    """Column lines as block number plus fraction of the block's width, and each column's block."""
    lines, owner = [np.zeros(1)], []
    for i, points in enumerate(_blocks(spacing)):
        fraction = (points - points[0]) / (points[-1] - points[0])
        lines.append(i + fraction[1:])
        owner += [i] * (points.size - 1)
    return np.concatenate(lines), np.array(owner)


def _edge_lines(height: Array, spacing: Spacing) -> Array:
    """x of the blocks' limits at every row line, (rows+1, blocks+1); m. The outer follows the deck too."""
    heights, widths = (np.array(v) for v in zip(*section.PROFILE_M, strict=True))
    width = np.interp(height, heights, widths)
    above = height > section.GIRDER_HEIGHT_M + 1e-9
    lines = [np.zeros_like(height)]
    for centre in section.girder_centres_m():
        lines += [centre - 0.5 * width, centre + 0.5 * width]
    lines[-1] = np.where(above, section.deck_half_width_m(), lines[-1])
    end = section.deck_half_width_m() + spacing.open_water_m + spacing.sponge_m
    return np.column_stack([*lines, np.full_like(height, end)])
