"""The documentation's site builds without a warning, and its pages have every law, picture and public name."""

from __future__ import annotations

import importlib
import os
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

import undertow
from undertow.equation.registry import names

ROOT = Path(__file__).resolve().parents[2]
DOCS = ROOT / "docs"
SITE_PLUGINS = ("mkdocs", "material", "mkdocstrings", "mkdocs_jupyter")


@pytest.mark.skipif(
    any(find_spec(name) is None for name in SITE_PLUGINS), reason="mkdocs is not installed: pip install '.[docs]'"
)
def test_the_site_builds_without_a_warning_and_has_pictures_notebooks_and_the_api(tmp_path: Path) -> None:
    words = [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", str(tmp_path)]
    here = {**os.environ, "NO_MKDOCS_2_WARNING": "1", "EXECUTE_NOTEBOOKS": "false"}  # they have tests of their own
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, env=here)
    assert done.returncode == 0, done.stderr
    assert "WARNING" not in done.stderr
    front = (tmp_path / "index.html").read_text()
    assert front.count("<img") == 3
    assert not re.findall(r'<(?:script|link|img)[^>]+(?:src|href)="https?://(?!127)', front), "asks another server"
    assert "image/png" in (tmp_path / "notebooks" / "water_that_hides" / "index.html").read_text()
    api = "".join(page.read_text() for page in (tmp_path / "api").rglob("index.html"))
    for name in set(undertow.__all__) - {"__version__", "open"} | {"open_run"}:
        assert re.search(rf'id="undertow\.[a-z._]+\.{name}"', api), name


def test_every_page_is_in_the_navigation() -> None:
    listed = set(re.findall(r"([\w/]+\.(?:md|ipynb))$", (ROOT / "mkdocs.yml").read_text(), re.MULTILINE))
    pages = {str(path.relative_to(DOCS)) for kind in ("md", "ipynb") for path in DOCS.rglob(f"*.{kind}")}
    assert pages == listed


@pytest.mark.parametrize("law", names())
def test_a_law_has_the_picture_of_its_absence(law: str) -> None:
    assert f"(pictures/laws/{law}.svg)" in (DOCS / "terms.md").read_text()
    assert "<svg" in (DOCS / "pictures" / "laws" / f"{law}.svg").read_text()


def test_the_readme_has_a_picture_the_terminals_output_and_defines_its_words() -> None:
    readme = (ROOT / "README.md").read_text()
    picture = re.search(r"!\[[^]]+\]\((docs/[^)]+)\)", readme)
    assert picture is not None
    assert (ROOT / picture.group(1)).exists()
    for word in ("Eq. 15", "free run", "Method 1", "Method 2"):
        assert re.search(rf"^\| {word} \| \w+", readme, re.MULTILINE), word
    shown = [" ".join(line.split()) for line in (DOCS / "pictures" / "tour" / "terminal.txt").read_text().splitlines()]
    for line in readme.partition("```text\n")[2].partition("```")[0].splitlines():
        if "%" in line or "verdict" in line:
            assert " ".join(line.split()) in shown


@pytest.mark.skipif(find_spec("griffe") is None, reason="griffe is not installed: pip install '.[docs]'")
def test_docstrings_become_lists_and_code(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(DOCS)
    made = importlib.import_module("docstrings").as_markdown
    text = "Twice.\n\nParameters\n----------\nx : a number,\n    or several.\n\n>>> 1 + 1\n2\n\nRaises nothing."
    assert made(text).splitlines() == [
        "Twice.", "", "**Parameters**", "", "- **x**: a number,", "    or several.", "", "```pycon", ">>> 1 + 1", "2",
        "```", "", "Raises nothing.",
    ]  # fmt: skip
