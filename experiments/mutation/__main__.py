"""Do the unit tests notice a changed line? Mutants drawn by a seed in likelihood, comparison and laws.

    pip install '.[mutation]' && python -m experiments mutation --seed 1 --mutants 30
    python -m experiments mutation --again       # those that survived, once more, after tests were added

A place (module, line, column) is drawn with equal probability, then one of cosmic-ray's operators that change it. Each
mutant runs against the tests of its module alone (`tests_of`), in place, and the file is put back. What changes nothing
but annotations is not drawn. Rows are added to results.csv. Belongs here: the draw and the count. Does not belong here:
operators (cosmic-ray), tests.
"""

from __future__ import annotations

import argparse
import ast
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import numpy as np
import parso
from cosmic_ray.mutating import mutate_code
from cosmic_ray.operators.provider import OperatorProvider

from experiments.files import add_rows, read_rows, write_rows

ROOT = Path(__file__).resolve().parents[2]
SOURCE = ROOT / "src" / "undertow"
RESULTS = Path(__file__).resolve().parent / "results.csv"
TIMEOUT_S = 900.0
FAMILIES = ("ReplaceComparisonOperator", "ReplaceBinaryOperator", "ReplaceUnaryOperator", "NumberReplacer", "AddNot",
            "ReplaceTrueWithFalse", "ReplaceFalseWithTrue", "ReplaceAndWithOr", "ReplaceOrWithAnd", "ReplaceBreakWith",
            "ReplaceContinueWith")  # fmt: skip

LAWS = (
    "term", "structure", "hydrodynamics", "hidden", "forcing", "input", "cells", "base_motion", "driven_laws",
    "driven_hysteresis", "registry", "algebra", "notation", "code_text", "generate", "generate_columns",
    "generate_states",
)  # fmt: skip
"""Modules of equation/ in which laws are stated, looked up and turned into code; compiled motion is held by frozen
numbers."""


def modules() -> list[str]:
    """Modules that are mutated: all of likelihood and comparison, and those of the laws."""
    rooms = [path for room in ("likelihood", "comparison") for path in (SOURCE / room).glob("[a-z]*.py")]
    return sorted(str(path.relative_to(SOURCE)) for path in (*rooms, *(SOURCE / f"equation/{n}.py" for n in LAWS)))


def tests_of(module: str) -> list[Path]:
    """The tests of a module: those that import it, or, where none does, a module that imports it, and so on."""
    tests = list((ROOT / "tests").rglob("test_*.py"))
    asked, seen = {module}, {module}
    while asked:
        own = {path for one in asked for path in _importers(one, tests)}
        if own:
            return sorted(own)
        above = (path for one in asked for path in _importers(one, SOURCE.rglob("*.py")))
        asked = {str(path.relative_to(SOURCE)) for path in above} - seen
        seen |= asked
    raise LookupError(f"{module}: no test reaches it")


def _importers(module: str, files: Iterable[Path]) -> set[Path]:
    name = module.removesuffix(".py").replace("/", ".")
    package, _, last = name.rpartition(".")
    asked = re.compile(rf"undertow\.{name}\b|from undertow\.{package} import [^\n]*\b{last}\b")
    return {path for path in files if asked.search(path.read_text(encoding="utf-8"))}


@dataclass(frozen=True)
class Row:
    """One mutant and what became of it."""

    seed: int
    module: str
    line: int
    operator: str
    before: str
    after: str
    outcome: str
    seconds: float


COLUMNS = [field.name for field in fields(Row)]


@dataclass(frozen=True)
class Mutant:
    """One operator at one place of a module."""

    module: str
    place: tuple[int, int]
    operator: str
    occurrence: int


def mutants_of(module: str) -> list[Mutant]:
    """Every mutant of a module, by cosmic-ray's operators of the FAMILIES."""
    tree = parso.parse((SOURCE / module).read_text(encoding="utf-8"))
    provider = OperatorProvider()
    found = []
    for name in provider:
        if not name.startswith(FAMILIES):
            continue
        operator = provider[name]()
        places = [start for node in _nodes(tree) for start, _ in operator.mutation_positions(node)]
        found += [Mutant(module, place, name, i) for i, place in enumerate(places)]
    return found


def _nodes(node: parso.tree.NodeOrLeaf) -> Iterator[parso.tree.NodeOrLeaf]:
    yield node
    for child in getattr(node, "children", ()):
        yield from _nodes(child)


def bare(text: str) -> str:
    """A module's code without annotations and docstrings."""
    tree = ast.parse(text)
    for node in ast.walk(tree):
        if isinstance(node, ast.arg | ast.AnnAssign):
            node.annotation = ast.Name("object")
        if isinstance(node, ast.FunctionDef):
            node.returns = None
    return ast.dump(tree)


def drawn(seed: int, count: int) -> Iterator[tuple[Mutant, str]]:
    """Mutants by seed with their text: a place with equal probability, then an operator that changes what is run."""
    rng = np.random.default_rng(seed)
    by_place: dict[tuple[str, tuple[int, int]], list[Mutant]] = {}
    for module in modules():
        for mutant in mutants_of(module):
            by_place.setdefault((module, mutant.place), []).append(mutant)
    places = sorted(by_place)
    given = 0
    for index in rng.permutation(len(places)):
        choices = by_place[places[index]]
        mutant = choices[int(rng.integers(len(choices)))]
        text = (SOURCE / mutant.module).read_text(encoding="utf-8")
        operator = OperatorProvider()[mutant.operator]()
        changed = mutate_code(text, operator, mutant.occurrence)
        if changed is None or bare(changed) == bare(text):
            continue
        yield mutant, changed
        given += 1
        if given == count:
            return


def judged(seed: int, mutant: Mutant, changed: str) -> Row:
    """Run a mutant against its module's tests; the file is put back whatever happens."""
    text = (SOURCE / mutant.module).read_text(encoding="utf-8")
    pairs = zip(text.splitlines(), changed.splitlines(), strict=False)
    before, after = next(((a.strip(), b.strip()) for a, b in pairs if a != b), ("", ""))
    began = time.monotonic()
    outcome = outcome_of(mutant.module, text, changed)
    seconds = round(time.monotonic() - began, 1)
    return Row(seed, mutant.module, mutant.place[0], mutant.operator, before, after, outcome, seconds)


def outcome_of(module: str, text: str, changed: str) -> str:
    """What a module's tests say of a changed text; ``text`` is put back whatever happens."""
    path = SOURCE / module
    tests = [str(path) for path in tests_of(module)]
    command = [sys.executable, "-m", "pytest", "-q", "-x", "-n", "0", "-p", "no:cacheprovider", *tests]
    try:
        path.write_text(changed, encoding="utf-8")
        with tempfile.TemporaryDirectory() as cache:  # numba's goes by the text of one file, not of those it takes in
            own = {"NUMBA_CACHE_DIR": cache} if "numba" in text else {}
            code = subprocess.run(
                command, cwd=ROOT, capture_output=True, timeout=TIMEOUT_S, check=False, env={**os.environ, **own}
            ).returncode
    except subprocess.TimeoutExpired:
        return "killed by time"
    finally:
        path.write_text(text, encoding="utf-8")
    return "survived" if code == 0 else "killed"


def again() -> None:
    """Run once more what survived, at the line that still reads so, and write the outcomes."""
    rows = read_rows(RESULTS)
    for row in rows:
        text = (SOURCE / row["module"]).read_text(encoding="utf-8")
        if row["outcome"] == "survived" and text.count(row["before"]) >= 1:
            lines = text.splitlines(keepends=True)
            near = [i for i, line in enumerate(lines) if line.strip() == row["before"]]
            i = min(near, key=lambda i: abs(i + 1 - int(row["line"])))
            lines[i] = lines[i].replace(row["before"], row["after"])
            outcome = outcome_of(row["module"], text, "".join(lines))
            row["outcome"] = "survived" if outcome == "survived" else f"{outcome} by a test added since"
            print(f"{row['outcome']:32} {row['module']}:{row['line']} {row['before']}  ->  {row['after']}", flush=True)
            write_rows(RESULTS, COLUMNS, rows)


def main(arguments: list[str] | None = None) -> int:
    """Draw mutants, run them, add their rows to results.csv."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--mutants", type=int, default=30)
    parser.add_argument("--again", action="store_true", help="run the survivors once more")
    asked = parser.parse_args(arguments)
    if asked.again:
        again()
        return 0
    for mutant, changed in drawn(asked.seed, asked.mutants):
        row = judged(asked.seed, mutant, changed)
        add_rows(RESULTS, COLUMNS, [asdict(row)])
        print(f"{row.outcome:14} {row.module}:{row.line} {row.before}  ->  {row.after}", flush=True)
    return 0
