"""The studies' numbers as pages of markdown; nothing is computed here but the worst of each column."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from experiments.virtual_flume.studies import ClosedCell, Halved, Kept, Shift

COMMAND = "    python -m experiments virtual_flume --only studies"


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> list[str]:
    """Lines of a markdown table.

    >>> table(["a", "b"], [["1", "2"]])
    ['| a | b |', '|---|---|', '| 1 | 2 |']
    """
    head = list(head)
    lines = [head, ["---"] * len(head), *[list(row) for row in rows]]
    return ["|" + "|".join(line) + "|" if line[0] == "---" else "| " + " | ".join(line) + " |" for line in lines]


def percent(value: float) -> str:
    """A relative change in per cent, two significant digits.

    >>> percent(-0.00123), percent(0.0)
    ('-0.12', '0')
    """
    return f"{100.0 * value:+.2g}" if value else "0"


def checks(cells: list[ClosedCell], kept: list[Kept], halved: list[Halved]) -> str:
    """results/checks.md."""
    head = ["# Checks of the virtual flume's solver", "", "Made by", "", COMMAND]
    return "\n".join([*head, *_cells(cells), *_energy(kept), *_step(halved)]) + "\n"


def _cells(cells: list[ClosedCell]) -> list[str]:
    rows = (
        (
            f"{c.width_m:.3f}", f"{c.depth_m:.2f}", str(c.order), f"{c.frequency:.4f}", f"{c.law_frequency:.4f}",
            percent(c.frequency_error), f"{c.mass_share:.5f}", f"{c.law_mass_share:.5f}", percent(c.mass_error),
        )
        for c in cells
    )  # fmt: skip
    return [
        "",
        "## Closed rectangular cells",
        "",
        "The solver's tank, swayed, against sqrt(g k tanh k h) with k = n pi / width and the participating mass of",
        "linear theory, 8 width tanh(k h) / (pi^3 n^3 h) of the water's mass (Graham and Rodriguez 1952). Wanted:",
        "0.2 % and 1 %.",
        "",
        *table(("width, m", "depth, m", "n", "w, rad/s", "law", "error, %", "mass share", "law", "error, %"), rows),
    ]


def _energy(kept: list[Kept]) -> list[str]:
    return [
        "",
        "## Energy",
        "",
        "Largest release of each spring with friction, drag, damper, sponge and layers off: largest relative change of",
        "the energy of spring, body and water. Wanted: 1e-6.",
        "",
        *table(
            ("depth, m", "spring", "seconds", "largest change"),
            ((f"{k.depth_m:.2f}", k.spring, f"{k.duration_s:g}", f"{k.largest_change:.1e}") for k in kept),
        ),
    ]


def _step(halved: list[Halved]) -> list[str]:
    rows = (
        (
            h.file.split(".")[0], f"{h.depth_m:.2f}", h.spring, f"{1e6 * h.displacement:.2g}",
            f"{h.acceleration:.1e}",
        )
        for h in halved
    )  # fmt: skip
    return [
        "",
        "## Time step",
        "",
        "Trials of the campaign marched with 1 ms instead of 2 ms: largest change anywhere in 14 s. Where the body",
        "sticks or starts, the acceleration jumps within one sample; a jump that falls on the other side of a sample",
        "would show here as a change of the jump's size.",
        "",
        *table(("trial", "depth, m", "spring", "displacement, um", "acceleration, m/s2"), rows),
    ]


VARIANTS = ("elements halved", "elements doubled", "sponge twice as far", "sponge twice as strong")


def worst(rows: list[Shift], quantity: str, variant: str) -> float:
    """Largest size of a variant's relative change over the rows of one quantity ("pole", "A" or "B") that have it."""
    return max(abs(row.change[variant]) for row in rows if row.quantity == quantity and variant in row.change)


def _changes(row: Shift) -> list[str]:
    return [percent(row.change[name]) if name in row.change else "" for name in VARIANTS]


def convergence(rows: list[Shift]) -> str:
    """results/convergence.md."""
    lines = [
        "# Mesh and sponge of the virtual flume",
        "",
        "What changes, in per cent of the value in the water that made the data, when every element size is halved",
        "(2.5 times as many elements) or doubled, when the sponge begins twice as far out (6 m from the deck, not 3),",
        "and when it absorbs twice as strongly. Made by",
        "",
        COMMAND,
        "",
        "Wanted: poles within 1 %, A and B at the body's frequencies within 3 %. The largest changes:",
        "",
        *table(
            ("", *VARIANTS),
            ((f"{q}, %", *(percent(worst(rows, q, n)).lstrip("+") for n in VARIANTS)) for q in ("pole", "A", "B")),
        ),
        "",
        "## Poles named in the truth file",
        "",
        *table(
            ("depth, m", "w, rad/s", "mass, kg", *VARIANTS),
            (
                (f"{r.depth_m:.2f}", f"{r.frequency:.4f}", f"{r.weight:.1f}", *_changes(r))
                for r in rows
                if r.quantity == "pole"
            ),
        ),
        "",
        "## A and B at the body's frequencies",
        "",
        "At every body frequency that carries 5 % of a release or more, held fixed while the water is changed.",
        "",
        *table(
            ("depth, m", "spring", "w, rad/s", "share", "", "value", *VARIANTS),
            (
                (
                    f"{r.depth_m:.2f}", r.spring, f"{r.frequency:.3f}", f"{r.weight:.2f}", r.quantity,
                    f"{r.value:.1f} {'kg' if r.quantity == 'A' else 'N s/m'}", *_changes(r),
                )
                for r in rows
                if r.quantity != "pole"
            ),
        ),
    ]  # fmt: skip
    return "\n".join(lines) + "\n"
