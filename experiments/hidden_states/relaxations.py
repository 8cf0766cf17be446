"""Are relaxations found beside the equation, and how often is one found where there is none?

    python -m experiments.hidden_states.relaxations

The null campaigns of the study of oscillators, one in six of which holds a Maxwell element of 1 to 10 % of the
stiffness that forgets within 0.03 to 0.5 s. Writes relaxations.csv here, a row a campaign.
"""

from __future__ import annotations

import argparse
import csv
import sys
from dataclasses import astuple, dataclass, fields
from pathlib import Path

from experiments.hidden_states.campaigns import Campaign, null
from undertow.comparison.hidden_relaxation import HiddenStates, discover_states
from undertow.conditioning.condition import condition

FOLDER = Path(__file__).resolve().parent
RESULT = FOLDER / "relaxations.csv"
CAMPAIGNS = 54


@dataclass(frozen=True)
class Row:
    """One campaign: the planted share of the stiffness and time (0: none), the drop of the squares, what was found."""

    kind: str
    noise: str
    seed: int
    true_share: float
    true_time_s: float
    gain: float
    kept: int
    share: float
    time_s: float
    time_stderr: float
    oscillators: int


def as_row(campaign: Campaign, found: HiddenStates) -> Row:
    """The verdict beside the truth."""
    k_r, time = campaign.truth.maxwell
    one = found.relaxation
    if one is None:
        raise ValueError(f"{campaign.kind} {campaign.noise} {campaign.seed}: its trials begin in motion")
    return Row(
        campaign.kind, campaign.noise, campaign.seed, round(k_r / campaign.truth.k, 4), round(time, 4) if k_r else 0.0,
        round(one.gain, 1), int(one.kept), round(one.share, 4), float(f"{one.time_s.value:.3g}"),
        float(f"{one.time_s.stderr:.2g}"), found.fit.count,
    )  # fmt: skip


def judge(seed: int) -> Row:
    """One campaign from its recordings to the verdict."""
    campaign = null(seed)
    return as_row(campaign, discover_states([condition(recording) for recording in campaign.recordings]))


def read_rows(path: Path = RESULT) -> list[Row]:
    """The committed rows."""
    with path.open(newline="") as stream:
        kinds = {field.name: {"str": str, "int": int, "float": float}[str(field.type)] for field in fields(Row)}
        return [Row(**{name: kinds[name](text) for name, text in row.items()}) for row in csv.DictReader(stream)]


def main(arguments: list[str] | None = None) -> int:
    """Every campaign, written as they come."""
    parser = argparse.ArgumentParser(description="Relaxations found and false alarms.")
    parser.add_argument("--count", type=int, default=CAMPAIGNS)
    parser.add_argument("--out", type=Path, default=RESULT)
    options = parser.parse_args(arguments)
    with options.out.open("w", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow([field.name for field in fields(Row)])
        for seed in range(options.count):
            writer.writerow(astuple(judge(seed)))
            stream.flush()
    return 0


if __name__ == "__main__":
    sys.exit(main())
