"""Every example in a docstring of the package gives what it shows."""

import doctest
import importlib
import pkgutil

import pytest

import undertow

MODULES = tuple(
    sorted(
        found.name
        for found in pkgutil.walk_packages(undertow.__path__, "undertow.")
        if not found.name.endswith(".__main__")  # importing it runs the terminal
    )
)
EXAMPLES = 150
"""Fewer would mean that examples are no longer found (there were 160 when this was written)."""


@pytest.mark.parametrize("name", MODULES)
def test_docstring_examples_come_out_as_shown(name):
    # examples speak as a reader's own session would: numpy and what the module imports are at hand
    failed, _ = doctest.testmod(importlib.import_module(name))
    assert failed == 0


def test_docstring_examples_are_found_in_the_whole_package():
    finder = doctest.DocTestFinder()
    found = [test for name in MODULES for test in finder.find(importlib.import_module(name))]
    assert sum(len(test.examples) for test in found) > EXAMPLES
