"""`python -m experiments driven.bands [--calibration] [FILE]`: what the 90 % bands of predicted driven motions hold.

Bodies with numbers drawn at random are fitted to one record, with the law that they have beyond the given equation
added, or kept from the search, so that the equation lacks something for good. The equation is run free on fresh
records of the same size and of 1.5 times the force; counted are samples inside the band, beyond those of the start.
A finished row is kept in FILE, so that a run goes on where it stopped.

Belongs here: these cases, rows, the table of docs/driven_measured.md. Does not belong here: the band
(methods/driven_equations.py).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from experiments.driven.bodies import GIVEN, Body, body, record
from experiments.driven.page import resumed
from undertow.comparison.driven_search import discover_driven
from undertow.conditioning.driven import DrivenTrial
from undertow.equation.driven_laws import find_driven
from undertow.likelihood.driven import DrivenLaws
from undertow.methods.driven_begin import START_SAMPLES
from undertow.methods.driven_equations import predict_driven, read_back, written

RESULT = Path(__file__).with_name("bands.csv")
HEADER = ("kind", "seed", "missing", "searched", "added", "force", "covered", "half_width", "missed", "noise", "motion")
CALIBRATION, PROOF = 0, 8000
"""First seeds of the two sets."""
REPEATED = 4
"""Bodies of each kind and law."""
FORCES = (1.0, 1.5)
"""Size of the fresh records' force, that of the training record being 1."""
FRESH = 2
"""Fresh records of each size."""
LACKING = ("", "cubic_stiffness", "bouc_wen", "stribeck_friction", "position_damping")


def cases(first: int) -> Iterator[tuple[Body, bool]]:
    """Every body of a set, and whether the search may add laws; a body that lacks nothing is searched alone."""
    for number in range(REPEATED):
        for i, missing in enumerate(LACKING):
            for kind in ("random", "swept"):
                one = body(kind, first + 100 * number + i, missing)
                yield one, True
                if missing:
                    yield one, False


def label(one: Body, searched: bool) -> tuple[str, ...]:
    """What a body's lines begin with."""
    return one.kind, str(one.seed), one.missing or "nothing", "yes" if searched else "no"


def rows(one: Body, searched: bool) -> list[tuple[str, ...]]:
    """One body's lines, one for each size of the force."""
    trial = record(one)
    laws = DrivenLaws(tuple(find_driven(name) for name in GIVEN[one.kind]))
    found = discover_driven([trial], laws, None if searched else ())
    fitted = found.augmented or found.baseline
    error = max(found.validation[1 if found.augmented else 0], *fitted.rms.values())
    equation = read_back(written(fitted, error, motion_of(trial), trial))
    out = []
    for force in FORCES:
        counts = []
        for again in range(1, FRESH + 1):
            fresh = record(one, force=force, again=again)
            made = predict_driven(fresh, equation, START_SAMPLES)
            after = slice(START_SAMPLES, None)
            seen, low, high = (a[after] for a in (fresh.outputs[fresh.main], made.lower, made.upper))
            away = seen - made.values[after]
            counts.append((
                np.mean((seen >= low) & (seen <= high)), np.mean(0.5 * (high - low)), np.sqrt(np.mean(away**2)),
                trial.noise()[trial.main], motion_of(fresh),
            ))  # fmt: skip
        mean = (f"{number:.4g}" for number in np.mean(counts, axis=0))
        out.append((*label(one, searched), " ".join(found.added) or "nothing", f"{force:g}", *mean))
    return out


def motion_of(trial: DrivenTrial) -> float:
    """Root mean square of what moves."""
    return float(np.std(trial.outputs[trial.main]))


def table(lines: Sequence[Sequence[str]]) -> str:
    """Markdown: by what the equation lacks and the force, samples in the band and its width."""
    named = [dict(zip(HEADER, one, strict=True)) for one in lines]
    out = [
        "| equation | force | bodies | samples in the band (least and most) | half width, median | missed, rms |",
        "|---|---|---|---|---|---|",
    ]
    for label, wanted in (("complete", True), ("lacks a law", False)):
        for force in FORCES:
            own = [
                one for one in named
                if float(one["force"]) == force and wanted == (one["missing"] == one["added"])
            ]  # fmt: skip
            if not own:
                continue
            covered = 100.0 * np.array([float(one["covered"]) for one in own])
            wide, away = (
                np.median([100.0 * float(one[key]) / float(one["motion"]) for one in own])
                for key in ("half_width", "missed")
            )
            out.append(
                f"| {label} | {force:g} | {len(own)} | {np.mean(covered):.0f} % ({np.min(covered):.0f} to "
                f"{np.max(covered):.0f}) | {wide:.2g} % of the motion | {away:.2g} % |"
            )
    return "\n".join(out)


def main() -> None:
    """The study as a command."""
    resumed(RESULT, HEADER, (CALIBRATION, PROOF), cases, label, rows, table, "bands")
