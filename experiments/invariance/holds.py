"""Campaigns with nothing missing, let go after holds of no time to three periods, of bodies slow and fast.

    python -m experiments invariance.holds        # eighteen campaigns, ten minutes; writes results/holds.csv

A light body of 3.4 Hz in air and in water (Eq. 15 alone), with its time stretched. Every suspect is looked for; the
answer must be `nothing_missing` in both groups, and the added mass within three standard errors.

Belongs here: those campaigns and their rows. Does not belong here: other units (campaigns.py).
"""

from __future__ import annotations

import json
import tempfile
from pathlib import Path

from experiments.files import write_rows
from experiments.invariance.rescale import Scale, rescale
from experiments.misuse.campaigns import Draft, fast, write
from experiments.misuse.rigs import FAST, Release, record
from undertow.campaign.run.folder import run_to_folder

HZ = 3.4
HOLDS = (0.0, 0.1, 0.2, 0.5, 1.0, 3.0)
"""Holds before the release, in periods of the dry body."""

STRETCHED = (0.05, 1.0, 30.0)
"""Factors of time: bodies of 68, 3.4 and 0.11 Hz."""

SEED = 8200
ROWS = Path(__file__).resolve().parent / "results" / "holds.csv"
COLUMNS = ("periods_held", "frequency_hz", "statuses", "added_mass_in_stderr", "right")


def draft(periods: float, seed: int) -> Draft:
    """The light body's campaign with this hold: three trials in air, three in water, all suspects."""
    made = fast()
    made.set("discrepancy.suspects", "all")
    for at, (name, row) in enumerate(made.index.items()):
        size = FAST.releases_m["long"][at % 3]
        release = Release("long", float(row["water_depth_m"]), size, seed + at, hold_s=periods / HZ)
        made.recordings[name] = record("fast", release)
    return made


def main() -> int:
    """Run all, write the rows; 1 where an answer is wrong."""
    rows = []
    for at, periods in enumerate(HOLDS):
        for stretched in STRETCHED:
            with tempfile.TemporaryDirectory() as folder:
                config = write(draft(periods, SEED + 10 * at), Path(folder) / "campaign")
                if stretched != 1.0:
                    config = rescale(config, Path(folder) / "stretched", Scale(stretched, 1.0, 1.0))
                run_to_folder(config, ("identify=[output_error]",), Path(folder) / "run", jobs=1)
                said = json.loads((Path(folder) / "run" / "verdict.json").read_text(encoding="utf-8"))["groups"]
            mass = said[-1]["baseline"]["parameters"]["added_mass_kg"]
            off = (mass["value"] - FAST.levels[1.2].added_mass_kg) / mass["stderr"]
            statuses = "; ".join(f"{g['status']} {'+'.join(g['verdict'])}".strip() for g in said)
            right = all(g["status"] == "nothing_missing" for g in said) and abs(off) < 3.0
            rows.append((periods, round(HZ / stretched, 3), statuses, round(off, 2), right))
            print(" | ".join(map(str, rows[-1])), flush=True)
    write_rows(ROWS, COLUMNS, rows)
    print(f"{sum(row[-1] for row in rows)} of {len(rows)} right")
    return int(not all(row[-1] for row in rows))
