"""What the page on structures shows is what comes out."""

import doctest
from pathlib import Path

DOCS = Path(__file__).resolve().parents[2] / "docs"


def test_the_pages_example_comes_out_as_shown():
    failed, tried = doctest.testfile(str(DOCS / "structure.md"), module_relative=False)
    assert tried > 10
    assert failed == 0
