"""Make the Eq. 15 campaign, 48 snap releases of Eq. 15, or check the committed one against it.

    python -m experiments eq15_campaign.make            # write data/eq15_campaign
    python -m experiments eq15_campaign.make --check    # remake in memory; exit 1 on any difference

The files of the campaign stand here; what is in a recording stands in trials.py.
"""

from __future__ import annotations

import argparse
import gzip
import io
import json
from pathlib import Path

from experiments.eq15_campaign import tables
from experiments.eq15_campaign.trials import (
    RATE_HZ,
    SEED,
    TRIAL_SCATTER,
    campaign_gains,
    make_trial,
    plan_trials,
)

FOLDER = Path(__file__).resolve().parents[2] / "data" / "eq15_campaign"


def describe_setup() -> dict[str, object]:
    """What the laboratory knows before any analysis."""
    return {
        "structure_mass_kg": tables.STRUCTURE_MASS_KG,
        "g": tables.GRAVITY_M_PER_S2,
        "rho_w": tables.WATER_DENSITY_KG_PER_M3,
        "span_m": tables.SPAN_M,
        "girder_height_m": tables.GIRDER_HEIGHT_M,
        "reference_area_m2": tables.REFERENCE_AREA_M2,
        "dry_water_depth_m": tables.DRY_DEPTH_M,
        "levels": [
            {
                "water_depth_m": depth,
                "submerged_volume_m3": tables.submerged_volume(depth),
                "mass_of_water_in_cells_kg": tables.WATER_IN_CELLS_KG[depth],
            }
            for depth in tables.WET_DEPTHS_M
        ],
        "rate_hz": RATE_HZ,
        "channels": {
            "time_s": "s",
            "displacement": "disp_m, string potentiometer, +-0.15 m on 14 bits",
            "acceleration": "accel_mps2, +-20 m/s2 on 14 bits",
            "spring_force": "loadcell1_N + loadcell2_N, +-25 kN each on 14 bits; + k x, sign as displacement",
        },
    }


def make_campaign() -> dict[str, str]:
    """Every file of the campaign but its README: name to text (recordings uncompressed)."""
    trials = sorted(plan_trials(), key=lambda trial: trial.file)
    files: dict[str, str] = {}
    entries: dict[str, object] = {}
    index = ["file,spring,water_depth_m,x0_target_m"]
    for trial in trials:
        files[trial.file], entries[trial.file] = make_trial(trial)
        index.append(f"{trial.file},{trial.spring},{trial.water_depth_m:.2f},{trial.x0_target_m:.3f}")
    truth = {
        "made_by": "python -m experiments eq15_campaign.make",
        "equation": "(m+m_a) x'' + c x' + k x + sign(x') mu (m g - V rho g) + 1/2 Cd rho A x'|x'| = 0",
        "missing": [],
        "seed": SEED,
        "scatter": TRIAL_SCATTER,
        "gains": campaign_gains(),
        "trials": entries,
    }
    files["campaign.csv"] = "\n".join(index) + "\n"
    files["setup.json"] = json.dumps(describe_setup(), indent=1) + "\n"
    files["truth.json"] = json.dumps(truth, indent=1) + "\n"
    return files


def read_text(path: Path) -> str:
    """Text of a campaign file, unpacked when its name ends in .gz."""
    raw = path.read_bytes()
    return (gzip.decompress(raw) if path.suffix == ".gz" else raw).decode()


def write_file(path: Path, text: str) -> None:
    """Write a campaign file; a packed one carries neither a date nor a name, so that its bytes repeat."""
    raw = text.encode()
    if path.suffix == ".gz":
        packed = io.BytesIO()
        with gzip.GzipFile(filename="", mode="wb", compresslevel=9, fileobj=packed, mtime=0) as stream:
            stream.write(raw)
        raw = packed.getvalue()
    path.write_bytes(raw)


def find_differences(files: dict[str, str], folder: Path) -> list[str]:
    """What differs between remade `files` (name to text) and those in `folder`, one sentence each."""
    differences = []
    for name, text in files.items():
        if not (folder / name).is_file():
            differences.append(f"{name}: not in {folder}")
        elif (committed := read_text(folder / name)) != text:
            pairs = zip(committed.splitlines(), text.splitlines(), strict=False)
            row = next((row for row, (old, new) in enumerate(pairs, 1) if old != new), "the end")
            differences.append(f"{name}: differs from the remade one, first at line {row}")
    strays = {path.name for path in folder.glob("*.csv*")} - set(files)
    return differences + [f"{name}: not part of the campaign" for name in sorted(strays)]


def main(arguments: list[str] | None = None) -> int:
    """Write the campaign, or check it; 0 when all is well, 1 when a file differs."""
    parser = argparse.ArgumentParser(description="Make the Eq. 15 campaign, or check the committed one.")
    parser.add_argument("--check", action="store_true", help="remake in memory and compare; write nothing")
    parser.add_argument("--out", type=Path, default=FOLDER, help="folder of the campaign")
    options = parser.parse_args(arguments)
    files = make_campaign()
    if options.check:
        differences = find_differences(files, options.out)
        print("\n".join(differences) or f"{len(files)} files equal to the last printed digit")
        return 1 if differences else 0
    options.out.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        write_file(options.out / name, text)
    print(f"{len(files)} files written to {options.out}")
    return 0
