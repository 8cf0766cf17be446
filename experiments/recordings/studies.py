"""Which configs are run on the real recordings, and which other equations beside the configured one.

Belongs here: runs and their results as plain values. Does not belong here: published numbers (published.py), the page
(page.py), the files (make.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from undertow.campaign.config import load
from undertow.campaign.run import run
from undertow.discrepancy.findings import Findings, GroupFindings, TrialFindings
from undertow.likelihood.fit import Fit

ROOT = Path(__file__).resolve().parents[2]
CONFIGS = ROOT / "configs" / "recordings"
RECORDINGS = ROOT / ".." / "shared" / "recordings"


NO_SEARCH = "discrepancy.suspects=[]"


@dataclass(frozen=True)
class Study:
    """One run: its name, its config, and other terms than the config's (empty: the config as it is).

    What is missing is searched only for the config's own equation; with other terms the point is their score.
    """

    name: str
    config: str
    terms: tuple[str, ...] = ()

    @property
    def overrides(self) -> list[str]:
        """The overrides as the terminal's --set takes them."""
        return [f"equation.terms=[{', '.join(self.terms)}]", NO_SEARCH] if self.terms else []


_LINEAR = ("stiffness", "viscous_damping")
_BOTH = (*_LINEAR, "quadratic_drag")

STUDIES = (
    Study("kvlcc2", "kvlcc2"),
    Study("kvlcc2_quadratic", "kvlcc2", _BOTH),
    Study("kvlcc2_hardening", "kvlcc2", (*_BOTH, "cubic_stiffness")),
    Study("kvlcc2_cubic", "kvlcc2", (*_BOTH, "cubic_damping", "cubic_stiffness", "quintic_stiffness")),
    Study("rotary_pendulum", "rotary_pendulum"),
    Study("rotary_pendulum_viscous", "rotary_pendulum", ("sine_restoring", "viscous_damping")),
    Study("rotary_pendulum_straight", "rotary_pendulum", (*_LINEAR, "coulomb_friction")),
    Study(
        "rotary_pendulum_drag",
        "rotary_pendulum",
        ("sine_restoring", "viscous_damping", "coulomb_friction", "quadratic_drag"),
    ),
    Study("spring_disc_air", "spring_disc_air"),
    Study("spring_disc_linear", "spring_disc_air", _LINEAR),
    Study("spring_disc_quadratic", "spring_disc_air", ("stiffness", "quadratic_drag")),
    Study("spring_disc_two", "spring_disc_air", _BOTH),
    Study("spring_disc_softening", "spring_disc_air", (*_BOTH, "cubic_stiffness")),
    Study("bicycle_wheel_axial", "bicycle_wheel_axial"),
    Study("bicycle_wheel_axial_drag", "bicycle_wheel_axial", _BOTH),
    Study("bicycle_wheel_axial_coulomb", "bicycle_wheel_axial", (*_LINEAR, "coulomb_friction")),
    Study("bicycle_wheel_radial", "bicycle_wheel_radial"),
    Study("bicycle_wheel_radial_drag", "bicycle_wheel_radial", _BOTH),
    Study("bicycle_wheel_radial_coulomb", "bicycle_wheel_radial", (*_LINEAR, "coulomb_friction")),
    Study("tmd_two_sensors", "tmd_two_sensors"),
    Study("tmd_linear", "tmd_two_sensors", _LINEAR),
    Study("tmd_cubic", "tmd_two_sensors", (*_BOTH, "coulomb_friction", "cubic_stiffness")),
    Study("sloshing_tank", "sloshing_tank"),
    Study("sloshing_linear", "sloshing_tank", _LINEAR),
    Study("sloshing_cubic", "sloshing_tank", (*_LINEAR, "cubic_stiffness")),
)


def run_study(study: Study, *overrides: str) -> Findings:
    """Everything a study's run finds; further ``overrides`` as the terminal's --set takes them."""
    return run(load(CONFIGS / f"{study.config}.yaml", [*study.overrides, *overrides]), jobs=1)


def plain(study: Study, findings: Findings) -> dict[str, Any]:
    """A study's findings as JSON values."""
    return {
        "study": study.name,
        "config": f"configs/recordings/{study.config}.yaml",
        "overrides": study.overrides,
        "failed": [failed.reason for failed in findings.failed],
        "groups": [_group(group) for group in findings.groups],
    }


def inputs(findings: Findings) -> dict[str, str]:
    """sha256 of every recording that was read, by its path inside the folder of recordings."""
    folder = RECORDINGS.resolve()
    found = {}
    for group in findings.groups:
        for trial in group.trials:
            recording = trial.motion.recording
            found[str(Path(recording.path).resolve().relative_to(folder))] = recording.sha256
    return found


def _group(group: GroupFindings) -> dict[str, Any]:
    verdict = group.verdict
    return {
        "group": dict(group.key),
        "equation": group.equation.text(group.equation_errors),
        "status": verdict.status,
        "sentence": verdict.sentence,
        "notes": list(group.notes),
        "methods": {name: _fit(fit) for name, fit in group.fits.items()},
        "trials": [_trial(trial) for trial in group.trials],
    }


def _trial(trial: TrialFindings) -> dict[str, Any]:
    away = trial.measured - trial.simulated
    mismatch = trial.mismatch
    scale = float(np.sqrt(np.mean(trial.measured**2)))
    return {
        "trial": trial.motion.name,
        "amplitude": _number(trial.motion.amplitude),
        "window_s": [_number(trial.motion.window.start_s), _number(trial.motion.window.end_s)],
        "rms": _number(float(np.sqrt(np.mean(away**2)))),
        "own_rms": _number(scale * trial.nrmse.get("output_error", math.nan)),
        "nrmse": _number(mismatch.nrmse),
        "r2": _number(1.0 - float(np.var(away) / np.var(trial.measured))),
        "sensor_floor_nrmse": _number(mismatch.sensor_floor_nrmse),
        "repeatability_nrmse": _number(mismatch.repeatability_nrmse),
        "methods": {name: _fit(fit) for name, fit in trial.fits.items()},
    }


def _fit(fit: Fit) -> dict[str, Any]:
    parameters: Mapping[str, Any] = {
        name: {
            "value": _number(estimate.value),
            "stderr": _number(estimate.total_stderr),
            "unit": estimate.unit,
        }
        for name, estimate in fit.parameters.items()
    }
    return {"outcome": fit.outcome, "parameters": parameters}


def _number(value: float) -> float | None:
    """Six significant digits, more than any error here allows; None where there is no number (JSON has no nan)."""
    return float(f"{value:.6g}") if math.isfinite(value) else None
