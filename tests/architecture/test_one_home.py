"""What stands in one place stays there: searches, residuals, the memory of noise, widths of priors."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from experiments.pictures import rooms

SOURCE = Path(__file__).resolve().parents[2] / "src" / "undertow"
TEXTS = {str(path.relative_to(SOURCE)): path.read_text() for path in sorted(SOURCE.rglob("*.py"))}

HOMES: dict[str, tuple[str, set[str]]] = {
    # a loop that raises and lowers its damping; the second is the first one compiled for Eq. 15, the third a recipe's
    # own search of two numbers in bare floats
    "a damped search": (
        r"damping = max\(|damping \*= ", {"likelihood/descent.py", "likelihood/eq15_search.py", "audit/recipes.py"}
    ),
    # weighted residuals of a recorded channel by the unknowns; the second is the first one compiled for Eq. 15
    "a channel's residual": (
        r"\bgain \* weight\b|\* gain \* weight", {"likelihood/channel_rows.py", "likelihood/eq15_rows.py"}
    ),
    # an autocorrelation; drawn in a figure, and of driven records up to where it first vanishes
    "an autocorrelation": (
        r"irfft\((power|np\.abs)", {"likelihood/noise.py", "methods/driven.py", "report/fit_figures.py"}
    ),
    "the clock's prior": (r"^\w*CLOCK_RADIANS = ", {"conditioning/fusion.py"}),
    "the gains' prior": (r"^\w*GAIN_STD = ", {"likelihood/priors.py"}),
}  # fmt: skip
"""What is looked for, how it is written, and where it stands."""


@pytest.mark.parametrize("idea", HOMES)
def test_an_idea_stands_only_where_it_is_at_home(idea):
    pattern, homes = HOMES[idea]
    assert {name for name, text in TEXTS.items() if re.search(pattern, text, re.MULTILINE)} == homes


def test_no_class_name_stands_twice():
    where: dict[str, list[str]] = {}
    for file, text in TEXTS.items():
        for name in re.findall(r"^class (\w+)", text, re.MULTILINE):
            where.setdefault(name, []).append(file)
    assert {name: files for name, files in where.items() if len(files) > 1} == {}


def test_modules_are_short_but_for_the_integrators():
    long = {name for name, text in TEXTS.items() if text.count("\n") > 400}
    assert long <= {"equation/kernel.py", "equation/driven_kernel.py"}


PACKAGE = {
    "low/a.py": "import math\n",
    "middle/b.py": "from undertow.low import a\nfrom undertow.errors import X\n",
    "high/c.py": "from undertow.middle.b import f\nfrom undertow.low.a import g\nimport undertow.low.a\n",
    "errors.py": "",
    "cli.py": "def main():\n    from undertow.high.c import h\n",
}


@pytest.fixture
def small(tmp_path) -> Path:
    """A package of three rooms, its ground and its door."""
    for name, text in PACKAGE.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


def test_the_picture_counts_import_statements_between_rooms(small):
    found = rooms.arrows(small)
    assert found == {("middle", "low"): 1, ("high", "middle"): 1, ("high", "low"): 2, ("cli", "high"): 1}
    assert rooms.lines_of(small) == {"low": 1, "middle": 2, "high": 3, "cli": 2}


def test_the_picture_leaves_out_arrows_that_follow_from_others(small):
    assert rooms.bare(rooms.arrows(small)) == {("middle", "low"), ("high", "middle"), ("cli", "high")}
    assert rooms.floors(rooms.arrows(small)) == {"low": 0, "middle": 1, "high": 2, "cli": 3}


def test_the_committed_picture_names_every_room():
    drawn = (SOURCE.parents[1] / "docs" / "pictures" / "rooms.svg").read_text()
    assert [room for room in rooms.lines_of() if f">{room}<" not in drawn] == []
