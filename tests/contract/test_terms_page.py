"""docs/terms.md says what the registry says."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from undertow.equation import registry

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "terms.md").read_text()
SECTIONS = dict(zip(re.findall(r"^### (\w+)$", PAGE, re.M), re.split(r"^### \w+$", PAGE, flags=re.M)[1:], strict=True))


def test_the_page_has_a_paragraph_for_every_term_and_for_nothing_else():
    assert sorted(SECTIONS) == sorted(registry.names())


def test_the_table_has_the_order_of_the_registry():
    assert tuple(re.findall(r"^\| \[(\w+)\]", PAGE, re.M)) == registry.names()


@pytest.mark.parametrize("term", registry.catalogue(), ids=lambda term: term.name)
def test_the_paragraph_has_the_law_the_units_and_the_look_of_the_registry(term):
    text = " ".join(SECTIONS[term.name].split())
    assert f"`{term.law}`" in text
    assert term.source in text
    assert f"Left out: {term.left_out}." in text
    assert not term.causes or f"May be: {term.causes}." in text
    for parameter in term.parameters:
        unit = "ratio (1)" if parameter.unit == "1" else parameter.unit
        assert f"`{parameter.name}` in {unit}" in text


@pytest.mark.parametrize("term", registry.catalogue(), ids=lambda term: term.name)
def test_the_table_has_the_law_and_the_unit_of_the_registry(term):
    law = term.law.replace("|", r"\|")
    assert f"(#{term.name}) | `{law}` | {term.parameters[0].unit} |" in PAGE
