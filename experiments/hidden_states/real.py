"""A real recording with a hidden oscillator: the model building that carries a tuned mass damper.

    python -m experiments hidden_states.real

writes real.json here, which the page takes its last section from. The recording is that of
`configs/recordings/tmd_two_sensors.yaml`; it is not part of the project, and without it the command says so.

Belongs here: what is asked of the recording, and the answers as plain values. Does not belong here: how an oscillator
is found, and whether the damper's own sensor saw it (experiments/two_sensors).
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import undertow
from experiments.hidden_states.study import OSCILLATOR
from experiments.two_sensors.building import coupled_modes

ROOT = Path(__file__).resolve().parents[2]
CONFIG = ROOT / "configs" / "recordings" / "tmd_two_sensors.yaml"
RECORDING = ROOT / ".." / "shared" / "recordings" / "tmd_two_sensors"
RESULT = Path(__file__).resolve().parent / "real.json"
LINEAR = ("stiffness", "viscous_damping")
EQUATIONS = (LINEAR, (*LINEAR, "coulomb_friction", "quadratic_drag"))
"""Linear, and with the friction and drag of Eq. 15."""
PARAMETERS = {"mass": "mass_kg", "w": "natural_frequency_rad_per_s", "zeta": "damping_ratio"}


def building(terms: tuple[str, ...]) -> dict[str, Any]:
    """What the building's own sensor alone says is missing beside ``terms``, and the modes that it makes."""
    group = undertow.diagnose(undertow.load(CONFIG), terms)[0]
    numbers = {name: group.estimates[f"{OSCILLATOR}.{parameter}"] for name, parameter in PARAMETERS.items()}
    modes = coupled_modes(group.repaired.theta())
    return {
        "terms": list(terms),
        "names": list(group.names),
        "numbers": {name: [one.value, one.total_stderr] for name, one in numbers.items()},
        "modes_hz": list(modes),
        "error": group.verdict.baseline.nrmse,
        "error_repaired": group.error_after,
    }


def main() -> int:
    """Judge the building with both equations and write real.json; 1 where the recording is absent."""
    if not RECORDING.exists():
        print(f"no recording at {RECORDING}; {CONFIG} expects it there", file=sys.stderr)
        return 1
    RESULT.write_text(json.dumps([building(terms) for terms in EQUATIONS], indent=1) + "\n")
    return 0
