"""The picture of the rooms, from the imports as they are: who stands on whom.

    python -m experiments pictures rooms               docs/pictures/rooms.svg, and the counts on the terminal

An arrow points to what is imported. Drawn are the arrows that follow from no others: a room that imports a second and
a third, which the second imports too, has one arrow. Belongs here: reading imports and drawing them. Does not belong
here: which imports are allowed (tests/architecture).
"""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from matplotlib.figure import Figure

SOURCE = Path(__file__).resolve().parents[2] / "src" / "undertow"
PACKAGE = "undertow"
GROUND = frozenset({"errors", "quantities", "compiling", "__init__", "__main__", "__version__"})
"""What every room may import, and the doors of the package: not drawn."""

Arrows = Mapping[tuple[str, str], int]

BOX = (1.7, 0.5)
STEP = (2.3, 0.95)


def room_of(path: Path, source: Path) -> str:
    """The room a file stands in: its folder, or its own name."""
    parts = path.relative_to(source).parts
    return parts[0] if len(parts) > 1 else path.stem


def lines_of(source: Path = SOURCE) -> dict[str, int]:
    """Lines of code and text of each room that is drawn."""
    lines: Counter[str] = Counter()
    for path in sorted(source.rglob("*.py")):
        room = room_of(path, source)
        if room not in GROUND:
            lines[room] += path.read_text(encoding="utf-8").count("\n")
    return dict(lines)


def arrows(source: Path = SOURCE) -> dict[tuple[str, str], int]:
    """How many import statements of one room name another: (from, to) -> statements."""
    found: Counter[tuple[str, str]] = Counter()
    for path in sorted(source.rglob("*.py")):
        room = room_of(path, source)
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            for target in _targets(node):
                if target != room and not {room, target} & GROUND:
                    found[room, target] += 1
    return dict(found)


def _targets(node: ast.AST) -> set[str]:
    """Rooms that an import statement names."""
    names: list[str] = []
    if isinstance(node, ast.Import):
        names = [alias.name for alias in node.names]
    elif isinstance(node, ast.ImportFrom):
        names = [f"{node.module or ''}.{alias.name}" for alias in node.names]
    parts = [name.split(".") for name in names]
    return {part[1] for part in parts if part[0] == PACKAGE and len(part) > 1}


def bare(found: Arrows) -> set[tuple[str, str]]:
    """The arrows that follow from no others."""
    below = {room: {b for a, b in found if a == room} for room in {r for pair in found for r in pair}}

    @cache
    def reached(room: str) -> frozenset[str]:
        return frozenset(below[room].union(*(reached(other) for other in below[room])))

    return {(a, b) for a, b in found if not any(b in reached(other) for other in below[a] - {b})}


def floors(found: Arrows) -> dict[str, int]:
    """The floor of each room: one above the highest that it imports."""
    below = {room: {b for a, b in found if a == room} for room in {r for pair in found for r in pair}}

    @cache
    def floor(room: str) -> int:
        return 1 + max((floor(other) for other in below[room]), default=-1)

    return {room: floor(room) for room in below}


def draw(found: Arrows, lines: Mapping[str, int], figure: Figure, ink: str, pale: str) -> Figure:
    """Rooms as boxes on their floors, with thousands of lines, and the arrows between them."""
    storeys: dict[int, list[str]] = {}
    for room, floor in sorted(floors(found).items()):
        storeys.setdefault(floor, []).append(room)
    at = {
        room: ((i - 0.5 * (len(rooms) - 1)) * STEP[0], floor * STEP[1])
        for floor, rooms in storeys.items() for i, room in enumerate(rooms)
    }  # fmt: skip
    axes = figure.subplots()
    axes.set_axis_off()
    axes.set_xlim(-2.6, 2.6)
    axes.set_ylim(-BOX[1], max(y for _, y in at.values()) + BOX[1])
    for a, b in sorted(bare(found)):
        (xa, ya), (xb, yb) = at[a], at[b]
        bend = 0.0 if ya - yb < 1.5 * STEP[1] else 0.35
        axes.annotate(
            "", (xb, yb + 0.5 * BOX[1]), (xa, ya - 0.5 * BOX[1]),
            arrowprops={"arrowstyle": "->", "color": ink, "lw": 0.9, "connectionstyle": f"arc3,rad={bend}"},
        )  # fmt: skip
    for room, (x, y) in at.items():
        text = f"{room}\n{lines.get(room, 0) / 1000.0:.1f} k lines"
        box = {"boxstyle": "round,pad=0.35", "facecolor": pale, "edgecolor": ink, "lw": 0.6}
        axes.text(x, y, text, ha="center", va="center", color=ink, bbox=box)
    return figure
