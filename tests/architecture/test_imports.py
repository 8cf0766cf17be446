"""The direction of imports: every arrow between rooms is in the table, and none is hidden inside a function."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

import pytest

SOURCE = Path(__file__).resolve().parents[2] / "src" / "undertow"
PACKAGE = "undertow"

GROUND = {"errors", "quantities", "compiling"}
BELOW_LIKELIHOOD = {"recording", "conditioning", "equation"}
BELOW_COMPARISON = BELOW_LIKELIHOOD | {"likelihood", "uncertainty", "methods"}
BELOW_REPORT = BELOW_COMPARISON | {"comparison", "discrepancy", "audit"}
MAY_IMPORT: dict[str, set[str]] = {
    "errors": set(),
    "quantities": set(),
    "compiling": set(),
    "recording": set(),
    "conditioning": {"recording"},
    "equation": set(),
    "likelihood": BELOW_LIKELIHOOD,
    "uncertainty": BELOW_LIKELIHOOD | {"likelihood"},
    "methods": BELOW_LIKELIHOOD | {"likelihood", "uncertainty"},
    "comparison": BELOW_COMPARISON,
    "discrepancy": BELOW_COMPARISON | {"comparison"},
    "audit": BELOW_COMPARISON | {"comparison"},
    "report": BELOW_REPORT,
    "campaign": BELOW_REPORT | {"report"},
    "front": BELOW_REPORT | {"report", "campaign"},
    "cli": {"campaign", "report", "front"},
    "__main__": {"cli"},
    "__init__": {"front"},
}
"""Which rooms a room may import beside itself and the ground floor, which all stand on."""

HEAVY = {"numba", "pysindy", "matplotlib", "sympy", "sklearn", "pymatreader", "jinja2", "scipy", "pint"}
HEAVY |= {"h5py", "openpyxl", "plotly", "pyarrow"}
"""May be imported inside a function, because they cost time; the terminal may defer anything to answer at once."""
REPORT_ALONE = {"matplotlib", "jinja2"}


def room_of(path: Path) -> str:
    """The room a file stands in: its folder, or its own name on the ground floor."""
    parts = path.relative_to(SOURCE).parts
    return parts[0] if len(parts) > 1 else path.stem


def imported_modules(tree: ast.AST) -> list[tuple[int, str, bool]]:
    """Line, full module name and whether inside a function, of every import; ``from p import m`` gives p.m."""
    inside = {
        id(node)
        for function in ast.walk(tree)
        if isinstance(function, (ast.FunctionDef, ast.AsyncFunctionDef))
        for node in ast.walk(function)
    }
    found = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found += [(node.lineno, alias.name, id(node) in inside) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            found += [(node.lineno, f"{base}.{alias.name}", id(node) in inside) for alias in node.names]
    return found


def wrong_arrows(path: Path, text: str) -> list[str]:
    """Sentences about every import of a file that the table does not allow."""
    room = room_of(path)
    wrong = []
    for line, module, hidden in imported_modules(ast.parse(text)):
        top, *rest = module.split(".")
        where = f"{path.relative_to(SOURCE)}:{line}"
        if top == PACKAGE:
            target = rest[0] if rest else "__init__"
            free = {room, "__version__", *GROUND}
            if target not in free | MAY_IMPORT[room]:
                wrong.append(f"{where}: {room} imports {target}")
        elif top in REPORT_ALONE and room != "report":
            wrong.append(f"{where}: {room} imports {top}; report alone may")
        elif hidden and room != "cli" and top not in HEAVY and top not in sys.stdlib_module_names:
            wrong.append(f"{where}: {top} is imported inside a function but is not heavy")
    return wrong


FILES = sorted(SOURCE.rglob("*.py"))


def test_every_room_is_in_the_table():
    assert {room_of(path) for path in FILES} <= set(MAY_IMPORT)


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(SOURCE)))
def test_every_import_is_in_the_table(path):
    assert wrong_arrows(path, path.read_text()) == []


@pytest.mark.parametrize("truth", ["virtual_flume", "eq15_campaign"])
def test_an_independent_truth_never_imports_undertow(truth):
    folder = SOURCE.parents[1] / "experiments" / truth
    modules = {m for p in sorted(folder.rglob("*.py")) for _, m, _ in imported_modules(ast.parse(p.read_text()))}
    assert modules
    assert {m for m in modules if m.split(".")[0] == PACKAGE} == set()


def test_relative_imports_are_not_used():
    relative = [
        f"{path.relative_to(SOURCE)}:{node.lineno}"
        for path in FILES
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.ImportFrom) and node.level > 0
    ]
    assert relative == []


@pytest.mark.parametrize(
    ("file", "text", "sentence"),
    [
        ("equation/new.py", "from undertow.conditioning.motion import Motion", "equation imports conditioning"),
        ("conditioning/new.py", "import undertow.equation.term", "conditioning imports equation"),
        ("conditioning/new.py", "from undertow import equation", "conditioning imports equation"),
        ("methods/new.py", "from undertow.comparison import search", "methods imports comparison"),
        ("campaign/new.py", "import matplotlib.pyplot as plt", "report alone may"),
        ("recording/new.py", "def read():\n    from undertow.campaign import config", "recording imports campaign"),
        ("recording/new.py", "def read():\n    import pandas", "inside a function but is not heavy"),
    ],
)
def test_the_reader_of_imports_finds_a_wrong_arrow(file, text, sentence):
    assert any(sentence in found for found in wrong_arrows(SOURCE / file, text))


def _loaded_after(statement: str) -> set[str]:
    code = f"{statement}\nimport sys\nprint(' '.join(sorted({{m.split('.')[0] for m in sys.modules}})))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


@pytest.mark.parametrize(
    "statement", ["import undertow", "import undertow; dir(undertow)", "import undertow.equation.registry"]
)
def test_importing_undertow_loads_neither_matplotlib_nor_pysindy_nor_numba(statement):
    assert _loaded_after(statement) & {"matplotlib", "pysindy", "numba", "sympy", "sklearn"} == set()
