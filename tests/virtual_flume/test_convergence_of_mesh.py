"""A slice of the study of mesh and sponge, and the committed study itself."""

from __future__ import annotations

import itertools
import json
from pathlib import Path

import pytest

from experiments.virtual_flume import studies, tables
from experiments.virtual_flume.mesh import Spacing
from experiments.virtual_flume.water import flume_water

RESULTS = Path(studies.__file__).parent / "results"
DEPTH_M = 2.36


@pytest.fixture(scope="module")
def slice_of_study():
    """One level: the data's elements doubled, and the sponge twice as far and twice as strong."""
    base = flume_water(DEPTH_M)
    return studies.shifts(DEPTH_M, base, studies.variants(DEPTH_M, base))


@pytest.mark.slow
def test_the_cells_pole_stands_still_under_a_coarser_mesh_and_a_farther_sponge(slice_of_study):
    (pole,) = (row for row in slice_of_study if row.quantity == "pole")
    assert pole.value == pytest.approx(10.59955, rel=1e-6)  # truth.json has it from all eigenvalues at once
    assert max(abs(v) for v in pole.change.values()) < 0.01


@pytest.mark.slow
def test_added_mass_and_damping_at_the_bodys_frequencies_stand_still(slice_of_study):
    rows = [row for row in slice_of_study if row.quantity != "pole"]
    assert {row.spring for row in rows} == {"long", "short"}
    for quantity, variant in itertools.product("AB", ("elements doubled", "sponge twice as far")):
        assert tables.worst(rows, quantity, variant) < 0.03, (quantity, variant)


def test_a_guess_where_no_pole_is_near_is_refused(monkeypatch):
    monkeypatch.setattr(studies, "POLE_TURNS", 3)
    with pytest.raises(ValueError, match=r"pole near 7\+0.5j 1/s: still moving after 3 turns"):
        studies.pole_near(flume_water(DEPTH_M, Spacing(refine=0.5)), 7.0 + 0.5j)


def committed() -> list[studies.Shift]:
    rows = json.loads((RESULTS / "convergence.json").read_text(encoding="utf-8"))
    return [studies.Shift(**{key: value for key, value in row.items() if key != "kind"}) for row in rows]


def test_the_committed_study_has_every_level_and_every_variant():
    rows = committed()
    assert {row.depth_m for row in rows} == {2.22, 2.29, 2.36, 2.43, 2.57}
    assert {row.quantity for row in rows} == {"pole", "A", "B"}
    assert all(set(row.change) == set(tables.VARIANTS) for row in rows)


def test_in_the_committed_study_every_pole_moves_by_less_than_a_per_cent():
    assert max(abs(v) for row in committed() if row.quantity == "pole" for v in row.change.values()) < 0.01


def test_the_committed_page_prints_the_committed_numbers():
    assert tables.convergence(committed()) == (RESULTS / "convergence.md").read_text(encoding="utf-8")
