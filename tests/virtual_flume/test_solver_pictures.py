"""The page's pictures: what is drawn is the section and an antisymmetric surface, and the files stay small."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from experiments.virtual_flume import figures, section

DOCS = Path(__file__).resolve().parents[2] / "docs"
LARGEST_PICTURE_BYTES = 200_000


def test_every_picture_of_the_page_is_there_and_small():
    named = re.findall(r"\((pictures/virtual_flume/[^)]+)\)", (DOCS / "virtual_flume.md").read_text(encoding="utf-8"))
    assert len(named) == 4
    assert all((DOCS / name).stat().st_size < LARGEST_PICTURE_BYTES for name in named)
    assert {path.name for path in (DOCS / "pictures" / "virtual_flume").iterdir()} == {Path(n).name for n in named}


def test_the_surface_has_a_piece_in_each_cell_and_one_outside_each_side():
    level = section.Level(2.29)
    x = np.linspace(0.01, 3.0, 300)
    pieces = figures.surface_pieces(x, 0.01 * x, level)
    assert len(pieces) == section.GIRDERS + 1
    inner = pieces[1:-1]
    widths = [px[-1] - px[0] for px, _ in inner]
    assert widths == pytest.approx([level.surface_width_m] * 5, abs=0.02)  # the nodes above stand 10 mm apart
    for px, eta in pieces:
        assert eta == pytest.approx(0.01 * px)  # an odd surface stays odd when mirrored
    assert all(a[0][-1] < b[0][0] for a, b in pairwise(pieces))


def test_the_section_is_drawn_with_six_girders_and_the_deck_from_both_halves():
    axes = figures.draw_section(Figure().subplots())
    assert len(axes.patches) >= 2 * 4
    corners = np.concatenate([patch.get_xy() for patch in axes.patches if len(patch.get_xy()) > 4])
    assert np.min(corners[:, 0]) == pytest.approx(-section.deck_half_width_m())
    assert np.max(corners[:, 1]) == pytest.approx(section.GIRDER_BOTTOM_M + section.TOTAL_HEIGHT_M)


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        (figures.release_of_short_spring, r"water depth 1.63 m is dry; the picture needs one of \(2.22, 2.29"),
        (figures.slosh_frequency, r"water depth 1.63 m is dry; no slosh there, choose one of \(2.22, 2.29"),
    ],
)
def test_a_dry_level_has_no_picture(asked, said):
    with pytest.raises(ValueError, match=said):
        asked(section.DRY_DEPTH_M)
