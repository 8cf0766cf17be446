"""The study of posterior draws counts ranks as it says, and its page shows its file's numbers."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import undertow
from experiments.posterior.__main__ import (
    DRAWS,
    KINDS,
    MASS_KG,
    RELEASES_M,
    rank,
    recorded,
    scattered,
    structure,
    summary,
)

DOCS = Path(__file__).resolve().parents[2] / "docs"


def test_a_rank_is_the_share_of_draws_below_the_truth():
    assert rank(np.arange(199.0), 99.5) == pytest.approx(100.5 / 200.0)
    assert rank(np.arange(199.0), -1.0) == pytest.approx(0.5 / 200.0)


def test_even_ranks_are_flat_and_cover_and_draws_too_narrow_are_not():
    even = summary((np.arange(200) + 0.5) / 200.0)
    assert (even["p_flat"], even["coverage_percent"]) == (1.0, 90.0)
    rng = np.random.default_rng(0)
    narrow = np.array([rank(0.5 * rng.standard_normal(199), rng.standard_normal()) for _ in range(200)])
    assert summary(narrow)["p_flat"] < 0.01
    assert summary(narrow)["coverage_percent"] < 80.0


@pytest.mark.parametrize("kind", KINDS)
def test_truths_of_a_few_campaigns_lie_among_their_draws(kind):
    ranks = [one for seed in range(2) for one in KINDS[kind](seed).values()]
    assert all(0.0 < one < 1.0 for one in ranks)
    assert sum(0.01 < one < 0.99 for one in ranks) >= len(ranks) - 1
    assert len(set(ranks)) > len(ranks) // 2


def test_draws_are_not_few_where_the_dry_trials_agree_by_chance():
    # mu scatters by 5 %, the four dry trials show 1 %: drawn from those alone, 398 candidates were worth 24 draws
    rng = np.random.default_rng([5000, 2])
    rig = structure(rng)
    added, drag = rng.uniform(600.0, 2000.0), rng.uniform(2000.0, 6000.0)
    dry = [recorded(scattered(rig, MASS_KG, 0.0, rng), x0, f"d{x0}", rng) for x0 in RELEASES_M]
    wet = [recorded(scattered(rig, MASS_KG + added, drag, rng), x0, f"w{x0}", rng) for x0 in RELEASES_M]
    found = undertow.fit(wet, dry=dry, mass_kg=MASS_KG, area_m2=1.0)
    drawn = found.posterior(DRAWS, 5000)
    assert drawn.effective > 0.3 * drawn.candidates
    printed = found.estimates["drag_coefficient"].total_stderr
    assert 0.8 * printed < float(np.std(drawn.values["drag_coefficient"])) < 1.3 * printed


def test_the_page_shows_the_files_numbers():
    page = (DOCS / "uncertainty_measured.md").read_text(encoding="utf-8")
    for rows in json.loads((DOCS / "posterior.json").read_text()).values():
        for name, row in rows.items():
            assert f"{row['p_flat']} | {row['coverage_percent']}" in page, name
            assert sum(row["counts"]) == row["campaigns"] == 200
