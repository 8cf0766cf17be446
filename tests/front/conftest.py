"""Figures of one test are closed before the next."""

from collections.abc import Iterator

import pytest
from matplotlib import pyplot


@pytest.fixture(autouse=True)
def closed_figures() -> Iterator[None]:
    """pyplot keeps every figure until somebody closes it, and warns at the twenty-first."""
    yield
    pyplot.close("all")
