"""What the water between the girders would make of Method 1, without any fit: closed cells, and cells open below.

    python -m experiments audit.cells      # prints the table of docs/published_tables.md

Closed cells: the first modes of rectangles that hold the printed water (equation/cells.py), the rest moving with the
walls. Open cells: the poles of the virtual flume (data/virtual_flume/truth.json: linear potential flow around the
whole section, solved by an independent program), with the added mass that it finds beside them at each spring's
frequency. The body is that of Tables 1 and 2, released as in Tables 4 and 6; drag coefficient 2, cells damped by 2 %,
Method 1 as in the audit.
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from pathlib import Path

from experiments.audit.simulated import CONFIG, structures
from undertow.audit.case import PrintedCase, Row, row_returns
from undertow.campaign.audit.settings import load_audit
from undertow.equation.cells import closed_cell

TRUTH = Path(__file__).resolve().parents[2] / "data" / "virtual_flume" / "truth.json"
PRINTED = {2.22: (322.9, 0.0), 2.29: (717.8, 0.0), 2.36: (1079.4, 299.0)}
RELEASES = {"long": (0.108, 10.0), "short": (0.033, 5.0)}
DRAG, DAMPING = 2.0, 0.02


@dataclass(frozen=True)
class Prediction:
    """One level and kind of cell: first mode, and Method 1's m_a for the long and the short spring, kg."""

    water_depth_m: float
    kind: str
    frequency_rad_per_s: float
    mass_kg: float
    returned_kg: tuple[float, float]
    printed_kg: tuple[float, float]


def predictions() -> list[Prediction]:
    """Both kinds of cells at the three levels at which they have a surface."""
    said = load_audit(CONFIG).laboratory
    cell = said.cell
    if cell is None:
        return []
    flume = json.loads(TRUTH.read_text(encoding="utf-8"))["levels"]
    found = []
    for level, width, depth in zip(cell.water_depth_m, cell.surface_width_m, cell.depth_m, strict=True):
        closed = closed_cell(width, depth, cell.length_m)
        rest = {spring: closed.water_kg - float(closed.masses_kg[0]) for spring in RELEASES}
        mode = (float(closed.frequencies_rad_per_s[0]), float(closed.masses_kg[0]))
        found.append(_predicted(level, "closed", mode, rest))
        pole = flume[f"{level:g}"]["hidden_resonators"][0]
        beside = {
            spring: flume[f"{level:g}"]["by_spring"][spring]["added_mass_without_resonators_kg"] for spring in RELEASES
        }
        found.append(_predicted(level, "open below", (pole["frequency"], pole["participating_mass"]), beside))
    return found


def _predicted(level: float, kind: str, mode: tuple[float, float], rest: dict[str, float]) -> Prediction:
    said = load_audit(CONFIG).laboratory
    dry = structures()
    returned = []
    for spring, (release, window) in RELEASES.items():
        row = Row(kind, spring, release, "method1", 1.0, 1.0, window_s=window)
        case = PrintedCase(f"{kind} {level}", (row,), dry, said.mass_kg, said.area_m2)
        values = {
            "added_mass_kg": rest[spring], "drag_coefficient": DRAG, "hidden_resonator.mass_kg": mode[1],
            "hidden_resonator.natural_frequency_rad_per_s": mode[0], "hidden_resonator.damping_ratio": DAMPING,
        }  # fmt: skip
        returned.append(row_returns(case, row, values).added_mass_kg)
    return Prediction(level, kind, mode[0], mode[1], (returned[0], returned[1]), PRINTED[level])


def page_table(found: list[Prediction]) -> str:
    """The table as Markdown; below its bound Method 1 prints 0."""
    head = (
        "| H, m | cells | first mode, rad/s | participating mass, kg | m_a long, kg | printed | m_a short, kg | "
        "printed |\n|---|---|---|---|---|---|---|---|"
    )
    lines = [
        f"| {one.water_depth_m} | {one.kind} | {one.frequency_rad_per_s:.2f} | {one.mass_kg:.0f} | "
        f"{one.returned_kg[0]:.0f} "
        f"| {one.printed_kg[0]:g} | {one.returned_kg[1]:.0f} | {one.printed_kg[1]:g} |"
        for one in found
    ]
    return "\n".join([head, *lines])


def main() -> None:
    """Print the table."""
    sys.stdout.write(page_table(predictions()) + "\n")
