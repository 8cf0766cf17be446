"""Real recordings given with an equation that is too small for them, or large enough, and what the package says.

    python -m experiments real_verdicts            # ten recordings, half an hour; writes docs/recordings_verdicts.md

Each recording is run twice: with the repeatability of an ordinary rig (assumed, as nobody repeated these tests), and as
if the rig repeated exactly, where only noise is in the way. Needs the recordings beside the repository, in
../shared/recordings. Belongs here: those runs and their page. Does not belong here: coefficients
(experiments/recordings).
"""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from pathlib import Path

from experiments.files import table
from experiments.revision import revision
from undertow.campaign.config import load
from undertow.campaign.run import run
from undertow.discrepancy.verdict import Verdict

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "recordings_verdicts.md"
EXACT = "specimen.scatter={k: 1.0e-6, c: 1.0e-6, mu: 1.0e-6}"
ONLY = "identify=[output_error]"


@dataclass(frozen=True)
class Given:
    """One recording with the equation that is given to the package, and what its authors know of it."""

    config: str
    title: str
    known: str
    settings: tuple[str, ...] = ()


CASES = (
    Given(
        "rotary_pendulum", "Rotary pendulum, the author's viscous equation; trial 02 held out",
        "dry friction in the bearing",
        ("equation.terms=[sine_restoring, viscous_damping]", "trials.group_by=[]",
         "trials.hold_out=[pendulum_free_swing_data_02]"),
    ),
    Given(
        "kvlcc2", "Tanker KVLCC2 rolling, quadratic damping and a straight spring",
        "hardening (k5); at 0 kn damping that sets in above 5.5 degrees",
        ("equation.terms=[stiffness, viscous_damping, quadratic_drag]",),
    ),
    Given(
        "tmd_two_sensors", "Building with a tuned mass damper, sensor 2 alone",
        "the damper, which sensor 1 shows",
        ("equation.terms=[stiffness, viscous_damping]", "trials.hidden_at_release=free"),
    ),
    Given("rotary_pendulum", "Rotary pendulum, with dry friction", "nothing that is known"),
    Given("kvlcc2", "Tanker KVLCC2 rolling, the published equation", "at 0 kn damping that sets in above 5.5 degrees"),
    Given(
        "spring_disc_air", "Disc on a spring in air, a linear equation", "drag of the air",
        ("equation.terms=[stiffness, viscous_damping]",),
    ),
    Given("spring_disc_air", "Disc on a spring in air, with drag and friction", "nothing that is known"),
    Given("sloshing_tank", "Water in a sloshing tank", "nothing that is known"),
    Given("bicycle_wheel_axial", "Bicycle wheel, axial axis", "nothing"),
    Given("bicycle_wheel_radial", "Bicycle wheel, radial axis", "nothing"),
)  # fmt: skip


def verdicts(case: Given, exact: bool) -> tuple[tuple[Verdict, ...], float]:
    """Verdicts of a recording's groups, and the processor time a group took (s)."""
    started = time.process_time()
    settings = [ONLY, *case.settings, *([EXACT] if exact else [])]
    findings = run(load(ROOT / "configs" / "recordings" / f"{case.config}.yaml", settings), jobs=1)
    spent = time.process_time() - started
    return tuple(group.verdict for group in findings.groups), spent / len(findings.groups)


def said(verdict: Verdict) -> str:
    """A verdict's names with its rivals, or its status where it has none."""
    names = " + ".join(n.replace("_", " ") for n in verdict.verdict) or verdict.status.replace("_", " ")
    rivals = "; ".join(" + ".join(n.replace("_", " ") for n in names) for names in verdict.alternatives)
    return f"{names} (or {rivals})" if rivals else names


def page(rows: list[tuple[Given, bool, Verdict, float]]) -> str:
    """The page."""
    lines = [
        "# Verdicts on real recordings",
        "",
        "Public recordings, each given with an equation that its authors know to be too small, or with one that is",
        "thought to be large enough.",
        "`python -m experiments real_verdicts` makes this page; the recordings are not part of the project.",
        "",
        "Nobody repeated these tests: how far repetitions would differ is assumed as an ordinary rig's (k 0.4, c 20,",
        "mu 10 %), or, in the rows marked exact, as nothing, so that only noise is in the way. nrmse before and after",
        "what is named, on the trials fitted and on the ones held out. Seconds: processor time a group, one core.",
        f"All rows are of revision {revision()}.",
        "",
    ]
    cells = []
    for case, exact, v, seconds in rows:
        group = ", ".join(f"{k} {x}" for k, x in v.group.items()) or "all"
        after = f" to {v.augmented.nrmse:.3g}" if v.augmented else ""
        held = f"{v.baseline.held_out_nrmse:.3g}" if v.held_out else "none"
        held += f" to {v.augmented.held_out_nrmse:.3g}" if v.held_out and v.augmented else ""
        scatter = "exact" if exact else "assumed"
        error = f"{v.baseline.nrmse:.3g}{after}"
        cells.append((case.title, case.known, scatter, group, said(v), error, held, f"{seconds:.0f}"))
    head = ("recording", "known to be missing", "scatter", "group", "said", "nrmse", "held out", "s")
    lines.append(table(head, cells))
    lines += ["", "## In the package's words", ""]
    lines += [f"- {case.config}, {'exact' if exact else 'assumed'}: {v.sentence}" for case, exact, v, _ in rows]
    return "\n".join(lines) + "\n"


def main() -> int:
    """Run every case both ways and write the page; 1 where the recordings are not there."""
    if not (ROOT / ".." / "shared" / "recordings").exists():
        print(f"no recordings in {(ROOT / '..' / 'shared' / 'recordings').resolve()}", file=sys.stderr)
        return 1
    rows = []
    for case in CASES:
        for exact in (False, True):
            found, seconds = verdicts(case, exact)
            for verdict in found:
                rows.append((case, exact, verdict, seconds))
                scatter = "exact" if exact else "assumed"
                print(case.title, scatter, dict(verdict.group), said(verdict), f"{seconds:.0f} s", flush=True)
    PAGE.write_text(page(rows), encoding="utf-8")
    return 0
