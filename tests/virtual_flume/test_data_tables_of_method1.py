"""Method 1 on the flume: one trial done again, and the committed page is what the committed answers say."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from experiments.files import read_rows
from experiments.flume_tables.__main__ import own_answer, published, rows_of
from experiments.flume_tables.page import Row, drag_of_radiation, falling, largest, page
from undertow.campaign.config import load
from undertow.conditioning.condition import condition
from undertow.likelihood.fit import Specimen
from undertow.methods.method1 import history, search
from undertow.recording.catalogue import read_trial
from undertow.recording.gather import gather

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
DRY_LONG = (109_800.0, 480.0, 0.0073)
"""k (N/m), c (N s/m) and mu of the long spring's dry trials, as the run of configs/flume.yaml reports them."""


def committed() -> list[Row]:
    kept = json.loads((DOCS / "flume_tables.json").read_text(encoding="utf-8"))
    return [Row(**{k: float("nan") if v is None else v for k, v in row.items()}) for row in kept]


def test_the_committed_page_is_made_from_the_committed_answers():
    assert page(committed(), published(), own_answer()) == (DOCS / "flume_tables.md").read_text(encoding="utf-8")


def test_method_1_on_one_trial_gives_the_committed_answer():
    kept = largest(committed(), "long", 2.29)
    catalogue = load(ROOT / "configs" / "flume.yaml").catalogue()
    entry = next(e for e in gather(catalogue) if e.name == kept.trial)
    specimen = Specimen(mass_kg=2637.4, area_m2=0.483, submerged_volume_m3=0.1892)
    added, drag, _ = search(history(condition(read_trial(entry, catalogue))), DRY_LONG, specimen)
    assert added == pytest.approx(kept.added_mass_kg, abs=35.0)  # the trial's own k is within 1 % of the dry mean's
    assert drag == pytest.approx(kept.drag_coefficient, abs=1.0)  # c and mu above are rounded to two digits


def test_the_short_springs_added_mass_sits_on_its_bound_where_the_report_printed_zero():
    zeros = [row["water_depth_m"] for row in published()["6"] if row["added_mass_kg"] == 0.0]
    assert zeros == [2.22, 2.29]
    at = [row for row in committed() if row.spring == "short" and row.depth_m in zeros]
    assert len(at) == 10
    assert all(row.on_bound and row.added_mass_kg == 0.0 for row in at)


def test_the_long_springs_added_mass_rises_until_the_cells_are_nearly_full_and_no_further():
    masses = [largest(committed(), "long", depth).added_mass_kg for depth in (2.22, 2.29, 2.36, 2.43, 2.57)]
    assert masses[0] < masses[1] < masses[2]
    assert masses[2] > masses[3] > masses[4]  # the report's Table 4 goes on rising: named in the page


def test_radiations_share_of_drag_halves_when_the_release_doubles():
    answer = own_answer()["long"]["2.43"]
    assert drag_of_radiation(answer, 0.02) == pytest.approx(2.0 * drag_of_radiation(answer, 0.04))


def test_falling_counts_pairs_of_neighbouring_releases():
    rows = [Row("a", "long", 2.3, x, 1.0, 0.1, c, 0.1, False) for x, c in ((0.3, 1.0), (0.1, 3.0), (0.2, 0.5))]
    assert falling(rows) == "1 of 2"


def test_a_run_without_method_1_is_refused():
    with pytest.raises(ValueError, match=r"trials.csv has 1 rows and none of method1 with an added mass; run configs"):
        rows_of([{"method": "decay", "added_mass_kg": ""}])


def test_a_bound_in_the_outcome_is_kept(tmp_path):
    line = "r1,short,2.22,0.033,method1,0,,8.0,1.0,added_mass_kg on its bound 0 kg"
    head = (
        "trial,spring,water_depth_m,x0_target_m,method,added_mass_kg,added_mass_kg_stderr,drag_coefficient,"
        "drag_coefficient_stderr,outcome"
    )
    path = tmp_path / "trials.csv"
    path.write_text(f"{head}\n{line}\n", encoding="utf-8")
    (row,) = rows_of(read_rows(path))
    assert row.on_bound
    assert row.added_mass_kg == 0.0
