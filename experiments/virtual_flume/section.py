"""The bridge's cross-section and the levels of water: geometry only, no water physics.

Source of the girder: AASHTO (AASHO-PCI) standard I-beam Type III, prototype 45 in high: top flange 16 x 7
in, top haunch 4.5 in, web 7 x 19 in, bottom haunch 7.5 in, bottom flange 22 x 7 in; its area is 559.5 in2
(PCI Bridge Design Manual, appendix of standard products), which these heights reproduce exactly. The model
is 1:5.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

SCALE = 5.0  # prototype length over model length
INCH_M = 0.0254
_IN = INCH_M / SCALE

GIRDER_BOTTOM_M = 2.15  # above the flume's floor
GIRDER_HEIGHT_M = 45.0 * _IN  # 0.2286
TOTAL_HEIGHT_M = 0.28  # girder bottom to deck top
GIRDER_SPACING_M = 0.37
GIRDERS = 6
SPAN_M = 3.45  # out of plane
DECK_CHAMFER_M = 0.010  # the deck's lower edge, 15 mm outside the top flange, is drawn as a chamfer this high

BOTTOM_FLANGE_M = 22.0 * _IN  # 0.1118
WEB_M = 7.0 * _IN  # 0.0356
TOP_FLANGE_M = 16.0 * _IN  # 0.0813

DRY_DEPTH_M = 1.63
WET_DEPTHS_M = (2.22, 2.29, 2.36, 2.43, 2.57)

# height above the girder's bottom, width: straight lines between
PROFILE_M = (
    (0.0, BOTTOM_FLANGE_M),
    (7.0 * _IN, BOTTOM_FLANGE_M),
    (14.5 * _IN, WEB_M),
    (33.5 * _IN, WEB_M),
    (38.0 * _IN, TOP_FLANGE_M),
    (45.0 * _IN, TOP_FLANGE_M),
)


@dataclass(frozen=True)
class Level:
    """One water depth and what of the section it wets.

    `depth_m` is the still water's depth above the flume's floor. All lengths m, areas m2, volumes m3.

    >>> round(Level(2.29).surface_width_m, 4), Level(2.43).cells_have_surface
    (0.3344, False)
    """

    depth_m: float

    @property
    def wetted_height_m(self) -> float:
        """Height of the section under water, at most its total height; m."""
        return min(max(self.depth_m - GIRDER_BOTTOM_M, 0.0), TOTAL_HEIGHT_M)

    @property
    def is_dry(self) -> bool:
        """True where the water stays below the girders."""
        return self.depth_m <= GIRDER_BOTTOM_M

    @property
    def cells_have_surface(self) -> bool:
        """True where the still level stands between girder bottom and deck soffit."""
        return not self.is_dry and self.depth_m < GIRDER_BOTTOM_M + GIRDER_HEIGHT_M

    @property
    def surface_width_m(self) -> float:
        """Width of one cell's free surface at rest; m. Zero where there is none."""
        return GIRDER_SPACING_M - girder_width_m(self.wetted_height_m) if self.cells_have_surface else 0.0

    @property
    def reference_area_m2(self) -> float:
        """Frontal area for drag: span times wetted height; m2."""
        return SPAN_M * self.wetted_height_m

    @property
    def submerged_volume_m3(self) -> float:
        """Volume of concrete under the still level; m3."""
        height = self.wetted_height_m
        deck = max(height - GIRDER_HEIGHT_M, 0.0) * (deck_half_width_m() * 2.0)
        return SPAN_M * (GIRDERS * girder_area_m2(min(height, GIRDER_HEIGHT_M)) + deck)

    @property
    def water_in_cells_kg(self) -> float:
        """Water between the girders, from their bottom to the level or the soffit, five cells; kg."""
        height = min(self.wetted_height_m, GIRDER_HEIGHT_M)
        return 1000.0 * SPAN_M * (GIRDERS - 1) * (GIRDER_SPACING_M * height - girder_area_m2(height))


def girder_width_m(height_m: float) -> float:
    """Width of a girder at a height above its bottom; m.

    >>> round(girder_width_m(0.14), 5)
    0.03556
    """
    heights, widths = zip(*PROFILE_M, strict=True)
    return float(np.interp(height_m, heights, widths))


def girder_area_m2(height_m: float) -> float:
    """Area of one girder below a height above its bottom; m2.

    >>> round(girder_area_m2(1.0) / (0.0254 / 5.0) ** 2, 1)  # the standard's 559.5 in2
    559.5
    """
    area = 0.0
    for (z0, w0), (z1, _) in pairwise(PROFILE_M):
        top = min(z1, height_m)
        if top > z0:
            area += 0.5 * (w0 + girder_width_m(top)) * (top - z0)
    return area


def girder_centres_m() -> tuple[float, ...]:
    """Centres of the girders on the right of the middle of the section; m.

    >>> girder_centres_m()
    (0.185, 0.555, 0.925)
    """
    return tuple(round(GIRDER_SPACING_M * (i + 0.5), 9) for i in range(GIRDERS // 2))


def deck_half_width_m() -> float:
    """The deck ends above the outer girder's bottom flange; m (model width 1.96 m)."""
    return girder_centres_m()[-1] + 0.5 * BOTTOM_FLANGE_M


def solid_half_outline_m() -> list[np.ndarray]:
    """Outlines (k, 2) of the three girders on the right and half the deck, x and height above floor; m."""
    outlines = []
    for centre in girder_centres_m():
        right = [(centre + 0.5 * w, GIRDER_BOTTOM_M + z) for z, w in PROFILE_M]
        left = [(centre - 0.5 * w, GIRDER_BOTTOM_M + z) for z, w in reversed(PROFILE_M)]
        outlines.append(np.array(right + left))
    soffit, top = GIRDER_BOTTOM_M + GIRDER_HEIGHT_M, GIRDER_BOTTOM_M + TOTAL_HEIGHT_M
    edge, under = deck_half_width_m(), girder_centres_m()[-1] + 0.5 * TOP_FLANGE_M
    deck = [(0.0, soffit), (under, soffit), (edge, soffit + DECK_CHAMFER_M), (edge, top), (0.0, top)]
    return [*outlines, np.array(deck)]
