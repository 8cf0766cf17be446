"""What `Discover` says of real recordings: a pendulum's free swing and a ship's roll decay.

    python -m experiments structure.real            # writes docs/structure_recordings.md

The recordings are read as configs/recordings says; they are not part of the project. The swings of one
pendulum together, then every trial alone, with a library of restoring and damping laws that was fixed before any
was looked at.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import undertow
from undertow.campaign.config import load
from undertow.conditioning.condition import condition
from undertow.conditioning.motion import Motion
from undertow.recording.catalogue import read_trial
from undertow.recording.gather import gather

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "structure_recordings.md"
RESAMPLES = 50

HEAD = """# Structures of real recordings

Made by `python -m experiments structure.real`: the pendulum's two swings together,
then every trial alone; libraries fixed beforehand. Numbers are over the inertia; units are printed for
translation (m for rad, N for N m).

"""


@dataclass(frozen=True)
class Case:
    """A recording: its config, the trials looked at, the library, and whether they are one body in one state, so that
    one equation has to move all trials."""

    title: str
    config: str
    trials: tuple[str, ...]
    terms: tuple[str, ...]
    together: bool


CASES = (
    Case(
        "Pendulum of a rotary inverted pendulum", "rotary_pendulum.yaml", ("_01", "_02"),
        ("stiffness", "sine_restoring", "viscous_damping", "coulomb_friction", "quadratic_drag", "cubic_stiffness",
         "cubic_damping"),
        together=True,
    ),
    Case(
        "Roll decay of the tanker KVLCC2", "kvlcc2.yaml", ("21338", "21340"),
        ("stiffness", "viscous_damping", "quadratic_drag", "cubic_stiffness", "quintic_stiffness", "cubic_damping",
         "coulomb_friction"),
        together=False,  # at rest and at speed
    ),
)  # fmt: skip


def motions(case: Case) -> list[Motion]:
    """The case's trials, conditioned as its config says."""
    catalogue = load(ROOT / "configs" / "recordings" / case.config).catalogue()
    return [
        condition(read_trial(entry, catalogue), start_s=entry.window.start_s, end_s=entry.window.end_s)
        for entry in gather(catalogue)
        if any(name in entry.name for name in case.trials)
    ]


def report(case: Case, trials: list[Motion]) -> str:
    """The report of some of a case's trials."""
    return undertow.Discover(case.terms, resamples=RESAMPLES).fit(trials).fit_report(trials)


def main() -> int:
    """Every case's trials together where they can be, then each alone, as a page."""
    parts = []
    for case in CASES:
        parts.append(f"## {case.title}\n")
        every = motions(case)
        for trials in [*([every] if case.together else []), *([motion] for motion in every)]:
            parts.append(f"```\n{report(case, trials)}\n```\n")
            print(*(motion.name for motion in trials), file=sys.stderr, flush=True)
    PAGE.write_text(HEAD + "\n".join(parts))
    return 0
