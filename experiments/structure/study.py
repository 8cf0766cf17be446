"""Which terms are found when the truth is known: Eq. 15, and equations that are not Eq. 15.

    python -m experiments structure.study support --kinds eq15 --seeds 100     # ten terms, exact support
    python -m experiments structure.study support --kinds eq15 --levels all --seeds 10
    python -m experiments structure.study support --kinds no_friction cubic_2 cubic_10 v3 --seeds 20
    python -m experiments structure.study exponent --kinds drag_1.5 --seeds 10 # a column with a parameter inside
    python -m experiments structure.study exponent --kinds stribeck --seeds 10
    python -m experiments structure.study exponent_dry --kinds drag_1.5 --seeds 5   # beside four dry trials
    python -m experiments structure.bound                                      # what these recordings hold at best
    python -m experiments structure.study table                                # docs/structure_measured.md

The dry trials are four releases of the same spring out of water, recorded alike: c / k carries over.
Each run adds rows to <study>.csv here, or replaces those of the same campaign; the last one writes the tables.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, fields, replace
from functools import lru_cache
from pathlib import Path

from experiments import files
from experiments.eq15_campaign import tables
from experiments.recovery.releases import NOISE, record_group
from experiments.structure.truths import KINDS, OtherTruth, plant_other
from undertow.comparison.beliefs import Belief
from undertow.comparison.dry_beliefs import from_dry
from undertow.comparison.stepwise_selection import Rules
from undertow.comparison.structure import Effort, FoundStructure, find_structure
from undertow.conditioning.condition import condition
from undertow.conditioning.motion import Motion
from undertow.equation import registry
from undertow.equation.registry import TEN_TERMS
from undertow.equation.term import Term

FOLDER = Path(__file__).resolve().parent
STATED_LEVELS = (("long", 2.57), ("short", 2.36))
ALL_LEVELS = tuple((spring, depth) for spring in ("long", "short") for depth in tables.WET_DEPTHS_M)
ALONE = Effort(resamples=0, second_route=False)
STUDIES = ("support", "exponent", "exponent_dry")
DRY_SEED = 50_000
"""First seed of the dry trials."""

STRUCTURAL = (0, 1, 2)
"""Stiffness, viscous damping and friction: what dry trials show to be there."""


@dataclass(frozen=True)
class Row:
    """One campaign: what was planted and found. ``inner`` is a refined parameter (nan: none), ``inner_stderr`` its
    standard error."""

    study: str
    kind: str
    spring: str
    water_depth_m: float
    noise: str
    seed: int
    exact: int
    kept: str
    rivals: int
    left: float
    inner: float = float("nan")
    inner_stderr: float = float("nan")
    seconds: float = 0.0

    @property
    def campaign(self) -> tuple[str, str, str, float, str, int]:
        """What tells campaigns apart."""
        return self.study, self.kind, self.spring, self.water_depth_m, self.noise, self.seed


def ten_terms() -> tuple[Term, ...]:
    """x, v, sgn v, v|v|, x^2, x^3, x|x|, v^3, xv, x^2 v."""
    return tuple(registry.find(name) for name in TEN_TERMS)


def with_inner(kind: str) -> tuple[Term, ...]:
    """The ten with the law that has a parameter inside: an exponent in the drag's place, or Stribeck friction added."""
    if kind == "stribeck":
        return (*ten_terms(), registry.find("stribeck_friction"))
    return tuple(registry.find("drag_exponent") if term.name == "quadratic_drag" else term for term in ten_terms())


def motions_of(truth: OtherTruth, noise: str, seed: int) -> list[Motion]:
    """The four recordings of a level, conditioned."""
    return [condition(recording) for recording in record_group(truth, noise, seed)]


@lru_cache(maxsize=512)
def dry_beliefs(dry: OtherTruth, noise: str, seed: int) -> tuple[Belief, ...]:
    """c / k from stiffness, viscous damping and friction in four dry trials."""
    motions = motions_of(dry, noise, DRY_SEED + seed)
    return from_dry(find_structure(motions, ten_terms()[:3], Rules(known=STRUCTURAL), effort=ALONE))


def judge(study: str, truth: OtherTruth, noise: str, seed: int) -> Row:
    """One campaign through one study."""
    motions, started = motions_of(truth, noise, seed), time.perf_counter()
    beliefs = dry_beliefs(replace(truth, kind="dry"), noise, seed) if study.endswith("_dry") else ()
    known = () if study == "support" else STRUCTURAL
    terms = with_inner(truth.kind) if study.startswith("exponent") else ten_terms()
    found = find_structure(motions, terms, Rules(known=known, beliefs=beliefs), effort=ALONE)
    return row_of(study, truth, noise, seed, found, time.perf_counter() - started)


def row_of(study: str, truth: OtherTruth, noise: str, seed: int, found: FoundStructure, seconds: float) -> Row:
    """What the tables are made of."""
    inner = next((estimate for name, estimate in found.numbers.items() if "." in name), None)
    return Row(
        study, truth.kind, truth.spring, truth.water_depth_m, noise, seed,
        int(set(found.names) == KINDS[truth.kind]), " ".join(sorted(found.names)), len(found.rivals),
        round(found.left, 4),
        round(inner.value, 4) if inner else float("nan"), round(inner.stderr, 4) if inner else float("nan"),
        round(seconds, 2),
    )  # fmt: skip


def read_rows(path: Path) -> dict[tuple[str, str, str, float, str, int], Row]:
    """Rows of an earlier run by campaign; empty where there is none."""
    kinds = {field.name: {"str": str, "float": float, "int": int}[str(field.type)] for field in fields(Row)}
    rows = [Row(**{name: kinds[name](text) for name, text in row.items()}) for row in files.read_rows(path)]
    return {row.campaign: row for row in rows}


def write_rows(rows: Iterable[Row], path: Path) -> None:
    """One row a campaign, sorted."""
    found = [asdict(row) for row in sorted(rows, key=lambda one: one.campaign)]
    files.write_rows(path, [field.name for field in fields(Row)], found)


def run(study: str, kinds: Sequence[str], levels: Sequence[tuple[str, float]], seeds: int) -> None:
    """Every campaign that has no row yet; the file is written after every group."""
    path = FOLDER / f"{study}.csv"
    rows = read_rows(path)
    for kind in kinds:
        for spring, depth in levels:
            truth = plant_other(spring, depth, kind)
            for noise in NOISE:
                group = []
                for seed in range(seeds):
                    key = (study, kind, spring, depth, noise, seed)
                    if key not in rows:
                        rows[key] = judge(study, truth, noise, seed)
                    group.append(rows[key])
                write_rows(rows.values(), path)
                exact, inner = sum(row.exact for row in group), [row.inner for row in group][:4]
                print(kind, spring, depth, noise, f"{exact} of {seeds}", inner, file=sys.stderr)
                sys.stderr.flush()


def main(arguments: list[str] | None = None) -> int:
    """Run a study, or write the tables."""
    parser = argparse.ArgumentParser(description="Terms found where the truth is known.")
    parser.add_argument("study", choices=(*STUDIES, "table"))
    parser.add_argument("--kinds", nargs="+", choices=tuple(KINDS), default=["eq15"])
    parser.add_argument("--levels", choices=("stated", "all"), default="stated")
    parser.add_argument("--seeds", type=int, default=20)
    options = parser.parse_args(arguments)
    if options.study == "table":
        from experiments.structure.page import write_page

        write_page()
        return 0
    run(options.study, options.kinds, ALL_LEVELS if options.levels == "all" else STATED_LEVELS, options.seeds)
    return 0
