"""Mistakes in the tests themselves: recordings that are no free decay, and too few of them to tell."""

from __future__ import annotations

import numpy as np
import pandas as pd

from experiments.misuse.answers import NOT_GREEN, Groups, TrialsAlone, Way
from experiments.misuse.campaigns import Draft, bridge, roll_decay
from experiments.misuse.case import Case, setting
from experiments.misuse.rigs import LOAD_SHARES, Release, record

HARDENING_PER_M2 = 12.0
"""Spring force k x (1 + 12 x^2): 14 % more at the largest release, 3 % more at half of it."""

DONE_OR_SOME_FAILED = frozenset({0, 3})

STUCK = "stuck|stay|stopped|at rest|(not|never) (swing|move|oscillat|come)|no (free )?(decay|swing|oscillat)|not a "
"""How a body that does not swing may be described."""


def no_decay(trial: str, level: float, *says: str) -> tuple[Way, ...]:
    """The trial is left out with a sentence, or its group is cannot_tell with one."""
    return (
        TrialsAlone(says, trials=(trial,), others=5),
        Groups((trial, *says), DONE_OR_SOME_FAILED, where={"water_depth_m": level}, done=0),
    )


def _driven(draft: Draft) -> None:
    rng = np.random.default_rng(2)
    table = draft.recordings["t05.csv"]
    w, k = 2.0 * np.pi * 0.8, 109_592.0
    x = 0.06 * np.sin(w * table.t)
    motion = {"x": (x, 5e-5), "v": (0.06 * w * np.cos(w * table.t), 2e-3), "a": (-w * w * x, 0.05)}
    forces = {cell: (share * k * x, 3.0) for cell, share in zip(("lc1", "lc2"), LOAD_SHARES, strict=True)}
    sensed = {column: x + noise * rng.standard_normal(len(table)) for column, (x, noise) in (motion | forces).items()}
    draft.recordings["t05.csv"] = table.assign(**sensed)


def _stuck(draft: Draft) -> None:
    """The line is let go, the body slips by a quarter and stays."""

    def slip(table: pd.DataFrame) -> pd.DataFrame:
        rng = np.random.default_rng(3)
        since = np.clip((table.t - 0.8) / 0.15, 0.0, 1.0)
        x = 0.107 * (1.0 - 0.25 * (since - np.sin(2.0 * np.pi * since) / (2.0 * np.pi)))
        v = np.gradient(x, table.t)
        noise = rng.standard_normal((4, len(table)))
        cells = {cell: share * 109_592.0 * x for cell, share in zip(("lc1", "lc2"), LOAD_SHARES, strict=True)}
        return table.assign(
            x=x + 5e-5 * noise[0],
            v=v,
            a=np.gradient(v, table.t) + 0.05 * noise[1],
            lc1=cells["lc1"] + 3.0 * noise[2],
            lc2=cells["lc2"] + 3.0 * noise[3],
        )

    draft.change(["t05.csv"], slip)


def _growing(draft: Draft) -> None:
    release = Release("long", 1.63, 0.030, seed=40, c_factor=-3.0)
    draft.recordings["t02.csv"] = record("bridge", release).copy()


def _dry_uneven(draft: Draft) -> None:
    draft.remove("specimen.scatter")
    draft.recordings["t02.csv"] = record("bridge", Release("long", 1.63, 0.107, seed=41, c_factor=8.0)).copy()


def _two_dry(draft: Draft) -> None:
    draft.drop(["t03.csv"])
    draft.remove("specimen.scatter")


def _one_trial(draft: Draft) -> None:
    draft.remove("specimen")
    draft.set("discrepancy.suspects", ["linear_damping", "coulomb_friction"])


def _hardening_in_water() -> Draft:
    return bridge(hardening_per_m2=HARDENING_PER_M2)


MISTAKES = (
    Case("driven", "one recording is of a driven test: a steady 0.8 Hz", bridge, _driven,
         no_decay("t05", 2.36, "driven|steady|does not (decay|die)|(not a|no) (free )?decay")),
    Case("stuck", "one body stuck: let go at 107 mm, it slipped to 80 mm and stayed", bridge, _stuck,
         no_decay("t05", 2.36, STUCK)),
    Case("growing", "one recording grows: the controller of a shaker was left on", bridge, _growing,
         no_decay("t02", 1.63, "grow")),
    Case("chopped", "one recording ends half a period after the release", bridge,
         lambda draft: draft.change(["t05.csv"], lambda table: table[table.t < 1.4]),
         no_decay("t05", 2.36, "period|cycle|swing|ends|cut|chopped|short")),
    Case("dry_uneven",
         "one of three trials in air was damped eight times as much: a hand on the line; scatter from the dry trials",
         bridge, _dry_uneven,
         (TrialsAlone(("uneven|differ|scatter|damping|group",), trials=("t02",), others=5),
          Groups(("t02|uneven|scatter|differ",), DONE_OR_SOME_FAILED))),
    Case("one_trial", "one roll decay alone, scatter not stated; its spring hardens, which no suspect is",
         lambda: roll_decay(hardening_per_rad2=1.0), _one_trial,
         (Groups((), DONE_OR_SOME_FAILED, statuses=NOT_GREEN),)),
    Case("two_dry_trials", "two trials in air, scatter not stated; the spring hardens in water, which no suspect is",
         _hardening_in_water, _two_dry,
         (Groups((), DONE_OR_SOME_FAILED, where={"water_depth_m": 2.36}, statuses=NOT_GREEN),)),
    Case("generous_scatter",
         "scatter stated as 10 % of k and 50 % of c: repeatability hides a spring that hardens in water",
         _hardening_in_water, setting("specimen.scatter", {"k": 0.1, "c": 0.5, "mu": 0.5}),
         (Groups((), DONE_OR_SOME_FAILED, where={"water_depth_m": 2.36}, statuses=NOT_GREEN),)),
)  # fmt: skip
