"""What `Discover` says of real recordings: a pendulum's free swing and a ship's roll decay.

    python -m experiments.structure.real            # writes docs/structure_recordings.md

The recordings are read as configs/recordings says; they are not part of the project. Every trial alone, a library of
restoring and damping laws that was fixed before any of them was looked at.
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

Made by `python -m experiments.structure.real`: every trial alone, libraries fixed beforehand. Numbers are over the
inertia; units are printed for translation (m for rad, N for N m).

"""


@dataclass(frozen=True)
class Case:
    """A recording: its config, the trials looked at, the library."""

    title: str
    config: str
    trials: tuple[str, ...]
    terms: tuple[str, ...]


CASES = (
    Case(
        "Pendulum of a rotary inverted pendulum", "rotary_pendulum.yaml", ("_01", "_02"),
        ("stiffness", "sine_restoring", "viscous_damping", "coulomb_friction", "quadratic_drag", "cubic_stiffness",
         "cubic_damping"),
    ),
    Case(
        "Roll decay of the tanker KVLCC2", "kvlcc2.yaml", ("21338", "21340"),
        ("stiffness", "viscous_damping", "quadratic_drag", "cubic_stiffness", "quintic_stiffness", "cubic_damping",
         "coulomb_friction"),
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


def report(case: Case, motion: Motion) -> str:
    """The report of one trial."""
    return undertow.Discover(case.terms, resamples=RESAMPLES).fit([motion]).fit_report([motion])


def main() -> int:
    """Every trial of every case, as a page."""
    parts = []
    for case in CASES:
        parts.append(f"## {case.title}\n")
        for motion in motions(case):
            parts.append(f"```\n{report(case, motion)}\n```\n")
            print(motion.name, file=sys.stderr, flush=True)
    PAGE.write_text(HEAD + "\n".join(parts))
    return 0


if __name__ == "__main__":
    sys.exit(main())
