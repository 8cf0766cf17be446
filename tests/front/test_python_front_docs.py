"""The page on Python shows what comes out, and the notebooks run from their first cell to their last."""

from __future__ import annotations

import doctest
import json
import re
from pathlib import Path

import pytest

import undertow

DOCS = Path(__file__).resolve().parents[2] / "docs"
NOTEBOOKS = ("own_csv_to_verdict", "water_that_hides", "a_law_of_your_own", "every_name")

RESULTS = (
    "parameters", "plot", "plot_residual", "plot_corner", "confidence_interval", "predict", "score",
    "get_feature_names_out", "to_arviz", "to_latex", "to_sympy",
)  # fmt: skip
"""What results give, as the notebooks write it; programs are handed over by name (`HANDED_OVER`)."""

HANDED_OVER = ("python", "octave", "opensees", "json")


def test_the_pages_examples_come_out_as_shown(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    failed, tried = doctest.testfile(str(DOCS / "python_front.md"), module_relative=False)
    assert tried > 15
    assert failed == 0
    assert (tmp_path / "free_decay.m").exists()


def test_what_the_page_on_uncertainty_calls_is_there():
    failed, tried = doctest.testfile(str(DOCS / "uncertainty.md"), module_relative=False)
    assert (failed, tried) == (0, 15)


def run_notebook(name: str) -> dict:
    """What the cells of a notebook leave behind, run one after the other as plain Python."""
    scope: dict = {"__name__": "__main__"}
    book = json.loads((DOCS / "notebooks" / f"{name}.ipynb").read_text(encoding="utf-8"))
    for cell in book["cells"]:
        if cell["cell_type"] == "code":
            exec(compile("".join(cell["source"]), name, "exec"), scope)
    return scope


def test_every_notebook_of_the_folder_is_run():
    assert {path.stem for path in (DOCS / "notebooks").glob("*.ipynb")} == set(NOTEBOOKS)


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_a_notebook_shows_its_results_and_no_error(name):
    book = json.loads((DOCS / "notebooks" / f"{name}.ipynb").read_text(encoding="utf-8"))
    outputs = [out for cell in book["cells"] for out in cell.get("outputs", [])]
    assert any("image/png" in out.get("data", {}) for out in outputs)
    assert not [out for out in outputs if out["output_type"] == "error"]
    assert len(json.dumps(book)) < 300_000  # a page, not an archive


def test_the_notebook_on_own_files_names_the_drag(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    left = run_notebook("own_csv_to_verdict")
    assert left["found"][0].names == ("quadratic_drag",)
    assert left["program"] == Path("free_decay.m").read_text()  # in the folder that the notebook made


def test_the_notebook_on_water_names_the_resonator():
    left = run_notebook("water_that_hides")
    assert left["group"].names == ("hidden_resonator",)
    found = left["group"].estimates["hidden_resonator.mass_kg"]
    assert abs(found.value - 260.0) < 4.0 * found.total_stderr


def test_every_public_name_and_what_results_give_is_used_in_a_notebook():
    code = ""
    for name in NOTEBOOKS:
        book = json.loads((DOCS / "notebooks" / f"{name}.ipynb").read_text(encoding="utf-8"))
        code += "".join("".join(cell["source"]) + "\n" for cell in book["cells"] if cell["cell_type"] == "code")
    driven = {"fit_driven", "fit_response", "frequency_response"}  # docs/driven.md and docs/harmonic_sets.md have them
    for name in set(undertow.__all__) - {"Trials", "UndertowError", "__version__"} - driven:
        assert f"undertow.{name}(" in code, name
    for name in RESULTS:
        assert re.search(rf"\.{name}\b", code), name
    for name in HANDED_OVER:
        assert f'"{name}"' in code, name


def test_the_notebook_of_every_name_ends_with_the_run_it_made(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    left = run_notebook("every_name")
    assert left["found"].get_feature_names_out().tolist() == ["stiffness", "viscous_damping", "quadratic_drag"]
    assert left["said"][0].names == left["opened"][0].names == ("quadratic_drag",)
    assert min(left["fitted"].score(left["unseen"]), left["found"].score(left["unseen"])) > 0.98


@pytest.mark.slow
def test_the_notebook_on_an_own_law_predicts_what_it_has_not_seen():
    left = run_notebook("a_law_of_your_own")
    assert left["own"].score(left["unseen"]) > 0.985 > 0.97 > left["plain"].score(left["unseen"])
    assert left["discovered"].get_feature_names_out().tolist() == ["stiffness", "viscous_damping", "magnet_brake"]
