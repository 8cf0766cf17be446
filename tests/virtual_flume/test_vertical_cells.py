"""The vertical load cells, which no fit uses, go with the modes that a run found: a slice of the committed study."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from experiments.vertical_cells.cells import DATA, Mode, compare, geometry, predicted_parts
from undertow.campaign.config import load
from undertow.conditioning.condition import condition
from undertow.recording.catalogue import read_trial
from undertow.recording.gather import gather

ROOT = Path(__file__).resolve().parents[2]
STUDY = json.loads((ROOT / "docs" / "vertical_cells.json").read_text(encoding="utf-8"))
WITH_CELLS = (2.22, 2.29, 2.36)
"""Water depths at which the cells have a free surface, m."""


def trial(name: str):
    catalogue = load(ROOT / "configs" / "flume.yaml").catalogue()
    entry = next(e for e in gather(catalogue) if e.name == name)
    return condition(read_trial(entry, catalogue)), DATA / entry.path.name


@pytest.mark.parametrize("key", ["short 2.36", "long 2.22"])
def test_the_cells_go_with_the_found_mode_as_the_study_says(key):
    kept = STUDY["trials"][key][0]
    motion, path = trial(kept["trial"])
    found = compare(motion, path, Mode(**STUDY["modes"][key]), float(key.split()[1]))
    assert found.mode >= 0.8
    assert found.mode == pytest.approx(kept["mode"], abs=0.01)  # smoothing may change a little from version to version
    assert found.size == pytest.approx(kept["size"], rel=0.02)


def test_every_trial_with_free_surfaces_in_its_cells_reaches_what_was_asked_for():
    rows = [one for key, many in STUDY["trials"].items() if float(key.split()[1]) in WITH_CELLS for one in many]
    assert len(rows) == 30
    assert min(one["mode"] for one in rows) >= 0.8


def test_a_mode_of_another_frequency_is_refused_by_the_cells():
    kept = STUDY["trials"]["short 2.36"][0]
    motion, path = trial(kept["trial"])
    wrong = {**STUDY["modes"]["short 2.36"], "frequency_rad_per_s": 7.5}
    assert abs(compare(motion, path, Mode(**wrong), 2.36).mode) < 0.6


def test_without_water_only_the_structures_inertia_is_left():
    kept = STUDY["trials"]["short 2.36"][0]
    motion, _ = trial(kept["trial"])
    parts = predicted_parts(motion, Mode(0.0, 10.0, 0.01, 0.0, 0.0), geometry(2.36))
    assert np.max(np.abs(parts["mode"])) == np.max(np.abs(parts["rest"])) == 0.0
    assert np.max(np.abs(parts["structure"])) > 100.0
