"""Methods 1 and 2 on motions that have the report's published values: do they give them back?

    python -m experiments published.methods_on_tables      # writes docs/methods.md

Belongs here: the two methods on Table 4 (long spring) and Table 6 (short spring), and the page. Does not belong here:
the simulated recordings (releases.py), noise, drift and scatter (experiments/recovery, docs/eq15_recovery.md).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from experiments.eq15_campaign import tables
from experiments.published.releases import LEVELS, RATE_HZ, RECORD_S, RELEASE_M, Level
from undertow.conditioning.condition import condition
from undertow.methods.method1 import History, search
from undertow.methods.method1 import fit as method1
from undertow.methods.method2 import find_instants, friction_bias_kg, identify_method2

PAGE = Path(__file__).resolve().parents[2] / "docs" / "methods.md"


@dataclass(frozen=True)
class Outcome:
    """What both methods make of one level; masses in kg.

    ``recorded`` is Method 1 on the recording, ``moving`` and ``whole`` on the exact history until the body stops and to
    the record's end, each (m_a, C_d). ``bias`` is -mu N / |x''| at the peak that Method 2 takes.
    """

    level: Level
    recorded: tuple[float, float]
    moving: tuple[float, float]
    whole: tuple[float, float]
    method2: tuple[float, float]
    printed_drag: float
    bias: float

    def errors(self, found: tuple[float, float]) -> tuple[float, float]:
        """Errors of (m_a, C_d) in %; of the total mass where Table 6 prints m_a = 0."""
        truth = self.level.added_mass_kg
        size = truth if truth > 0.0 else tables.STRUCTURE_MASS_KG
        return 100.0 * (found[0] - truth) / size, 100.0 * (found[1] / self.level.drag_coefficient - 1.0)

    @property
    def method2_error_kg(self) -> float:
        """Error of Method 2's added mass, kg."""
        return self.method2[0] - self.level.added_mass_kg


def judge(level: Level) -> Outcome:
    """Both methods on one level's recording, and Method 1 on its exact history."""
    motion = condition(level.record())
    one = method1(motion, level.structure, level.specimen)
    printed, meant = identify_method2(motion, level.structure, level.specimen)
    moving, whole = exact_history(level)
    return Outcome(
        level,
        (one.parameters["added_mass_kg"].value, one.parameters["drag_coefficient"].value),
        moving,
        whole,
        (meant.parameters["added_mass_kg"].value, meant.parameters["drag_coefficient"].value),
        printed.parameters["drag_coefficient"].value,
        friction_bias_kg(level.body.friction_N, find_instants(motion).peak.a),
    )


def exact_history(level: Level) -> tuple[tuple[float, float], tuple[float, float]]:
    """Method 1's (m_a, C_d) on the exact displacement until the body stops, and on the whole record."""
    x0, structure = RELEASE_M[level.spring], level.structure
    known = (structure.k.value, structure.c.value, structure.mu.value)
    times = np.arange(round(RECORD_S * RATE_HZ)) / RATE_HZ
    moved = level.moved(times)
    stop = math.inf if moved.stopped_s is None else moved.stopped_s
    found = [
        search(History(times[keep], moved.x[keep], x0), known, level.specimen)
        for keep in (times <= stop, times <= RECORD_S)
    ]
    return (found[0][0], found[0][1]), (found[1][0], found[1][1])


HEAD = """# Methods 1 and 2 on the report's own values

The report is that of `data/published` (Higgin, Loyola-Romero and others, *Assessment of Hydrodynamic Properties from
Free-Vibration Response of a Prestressed Girder Bridge Model*, 2301-10, 2026).

Motions of Eq. 15 with the added masses and drag coefficients of Table 4 (long spring, release 0.108 m) and Table 6
(short spring, 0.033 m), with k, c, mu of Tables 1 and 2, integrated exactly by scipy's DOP853 split at reversals
(nothing of undertow), and given to both methods: what they return should be what was put in. Made by

    python -m experiments published.methods_on_tables

*Recorded*: from a recording at 1000 Hz with 1 s of hold, through conditioning, almost without noise. *Exact history*:
the exact displacement until the body stops; *whole record*: until 15 s. The submerged volumes, which the report does
not print, are those of data/eq15_campaign; N = m g - V rho g. Where Table 6 prints m_a = 0 the error of m_a is in per
cent of the total mass."""

WORDS = """## What the tables say

- **Method 1 gives the published values back** within 0.2 % from the recording. What error there is comes from the
  instant of release, found to a few tenths of a millisecond (0.12 % of m_a); on the exact history it is 0.007 %
  and less. On the *whole* record, with the seconds after the body has stuck, m_a is off by up to 0.013 % and C_d by
  up to 0.94 %: the report's integrator (1 ms, sign() in the right-hand side) does not stick but slides on towards
  x = 0, and the sum of squares counts that. The motion window leaves the stuck tail out.
- **Method 2 as evidently meant** gives C_d within 5 %. Its m_a is too small by mu N / |x''|, because Eqs. 18-19 leave
  friction out. The closed form gives that bias to within a ninth of it; the rest is the low-pass, which moves the
  acceleration's peak off the turning point. The bias is 6 to 16 % of m_a on the long
  spring and 4 to 12 % on the short one, most at low water; where m_a is small it makes it negative.
- **Method 2 as printed** (Eq. 21 without the inertia) gives a negative C_d at every level: at the zero crossing inertia
  is what balances the forces, and without it nothing is left for drag but the wrong sign.
- None of these is an error that noise makes; they are there on perfect records. What noise and scatter add is in
  eq15_recovery.md."""


def page(outcomes: list[Outcome]) -> str:
    """docs/methods.md: one table a spring and method, and what they say."""
    parts = [HEAD]
    for spring, table in (("long", 4), ("short", 6)):
        rows = [outcome for outcome in outcomes if outcome.level.spring == spring]
        parts += [f"## {spring.capitalize()} spring, Table {table}", _method1(rows), _method2(rows)]
    return "\n\n".join([*parts, WORDS]) + "\n"


def _method1(rows: list[Outcome]) -> str:
    head = (
        "| H, m | m_a, kg | C_d | Method 1 recorded: m_a, kg | error, % | C_d | error, % "
        "| exact history: m_a, % | C_d, % | whole record: m_a, % | C_d, % |\n|" + "---|" * 11
    )
    lines = [
        f"| {o.level.water_depth_m} | {o.level.added_mass_kg:g} | {o.level.drag_coefficient:g} | {o.recorded[0]:.1f} "
        f"| {o.errors(o.recorded)[0]:+.2f} | {o.recorded[1]:.3f} | {o.errors(o.recorded)[1]:+.2f} "
        f"| {o.errors(o.moving)[0]:+.3f} | {o.errors(o.moving)[1]:+.3f} | {o.errors(o.whole)[0]:+.3f} "
        f"| {o.errors(o.whole)[1]:+.2f} |"
        for o in rows
    ]
    return "\n".join([head, *lines])


def _method2(rows: list[Outcome]) -> str:
    head = (
        "| H, m | m_a, kg | C_d | Method 2 recorded: m_a, kg | error, kg | -mu N / abs(x''), kg "
        "| C_d as meant | error, % | C_d as printed |\n|" + "---|" * 9
    )
    lines = [
        f"| {o.level.water_depth_m} | {o.level.added_mass_kg:g} | {o.level.drag_coefficient:g} | {o.method2[0]:.1f} "
        f"| {o.method2_error_kg:+.1f} | {o.bias:+.1f} | {o.method2[1]:.3f} | {o.errors(o.method2)[1]:+.2f} "
        f"| {o.printed_drag:.2f} |"
        for o in rows
    ]
    return "\n".join([head, *lines])


def main() -> int:
    """Write the page."""
    PAGE.write_text(page([judge(Level(*level)) for level in LEVELS]), encoding="utf-8")
    return 0
