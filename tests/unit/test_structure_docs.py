"""What the page and the docstrings of structure finding show is what comes out."""

import doctest
import importlib
import warnings
from pathlib import Path

import pytest

DOCS = Path(__file__).resolve().parents[2] / "docs"
MODULES = ("adequacy", "collinearity", "discover", "library", "robust", "search", "structure_report", "subset")


def test_the_pages_example_comes_out_as_shown():
    failed, tried = doctest.testfile(str(DOCS / "structure.md"), module_relative=False)
    assert tried > 10
    assert failed == 0


@pytest.mark.parametrize("name", MODULES)
def test_docstrings_examples_come_out_as_shown(name):
    module = importlib.import_module(f"undertow.identification.{name}")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # examples speak as a reader's own session would: numpy and what the module imports are at hand
        failed, tried = doctest.testmod(module)
    assert tried > 0
    assert failed == 0
