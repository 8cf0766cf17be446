"""A slice of the committed study of residual shares: one campaign of each kind, and the page's own table."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from experiments.residual_shares.planted import PLANTED, shares

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "residual_shares.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("name", "kind"),
    [("cubic stiffness, 3e6 N/m3", "static"), ("resonator, 200 kg", "memory"), ("seiche, 300 N", "clock")],
)
def test_the_planted_kind_has_the_largest_share(name, kind):
    found = [one for one in shares(name, 0) if np.isfinite(one.static)]
    middle = {k: float(np.median([getattr(one, k) for one in found])) for k in ("static", "memory", "clock")}
    assert max(middle, key=lambda k: middle[k]) == kind
    assert middle[kind] > 0.6


def test_the_page_has_a_row_for_everything_planted():
    assert all(f"| {name} |" in PAGE for name in PLANTED)
