"""A slice of the committed study of `undertow differ`: two pairs, and the table as it stands."""

from __future__ import annotations

import json

import pytest

from experiments.differ.__main__ import DOCS, result, table
from experiments.differ.pairs import pairs

STUDY = json.loads((DOCS / "differ.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", ["Eq. 15, 1200 N s/m more", "virtual flume, short spring, 2.29 m"])
@pytest.mark.slow
def test_a_pair_is_still_named_as_the_study_says(tmp_path, name):
    kept = next(row for row in STUDY if row["pair"] == name)
    found = result(next(pair for pair in pairs(tmp_path) if pair.name == name), tmp_path)
    assert found["lacks"] == kept["lacks"]
    assert [n for n in found["lacks"] if n != "unknown"] == found["truth"]  # one recording proves no law of water
    assert found["nrmse"] == pytest.approx(kept["nrmse"], rel=0.05)  # the smoother may change from version to version


def test_the_page_shows_the_studys_table():
    assert table(STUDY) in (DOCS / "differ.md").read_text(encoding="utf-8")
