"""The study of posterior draws counts ranks as it says, and its page shows its file's numbers."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from experiments.posterior.__main__ import KINDS, rank, summary

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


def test_the_page_shows_the_files_numbers():
    page = (DOCS / "uncertainty.md").read_text(encoding="utf-8")
    for rows in json.loads((DOCS / "posterior.json").read_text()).values():
        for name, row in rows.items():
            assert f"{row['p_flat']} | {row['coverage_percent']}" in page, name
            assert sum(row["counts"]) == row["campaigns"] == 200
