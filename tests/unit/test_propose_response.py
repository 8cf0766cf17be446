"""Columns of harmonic sets as laboratories name them."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from undertow.recording.propose_response import propose_response

F = np.linspace(0.5, 1.5, 12)
LAG = np.degrees(np.arctan2(0.3 * F, 1.0 - F**2))


def table(**columns) -> pd.DataFrame:
    """A table with these columns, their underscores as written."""
    return pd.DataFrame(columns)


@pytest.mark.parametrize(
    ("given", "mapped", "lag", "coordinate"),
    [
        (
            table(frequency_Hz=F, force_N=F, amplitude_mm=F, phase_lag_deg=LAG),
            {"frequency": "Hz", "force": "N", "amplitude": "mm", "phase": "deg"}, True, "translation",
        ),
        (
            table(**{"Freq [Hz]": F, "Ampl [mm]": F, "Phase [deg]": -LAG, "std_mm": F}),
            {"frequency": "Hz", "amplitude": "mm", "phase": "deg", "stderr": "mm"}, False, "translation",
        ),
        (
            table(freq=F, roll_amplitude_deg=F, phase_rad=np.radians(-LAG), moment_kNm=F),
            {"frequency": "Hz", "amplitude": "deg", "phase": "rad", "force": "kNm"}, False, "rotation",
        ),
        (  # phases before the base's acceleration: the relative motion leads it
            table(**{"f": F, "base_acc_mps2": F, "amplitude_mm": F, "phase_deg": 180.0 - LAG}),
            {"frequency": "Hz", "base_acceleration": "mps2", "amplitude": "mm", "phase": "deg"}, False, "translation",
        ),
        (
            table(**{"frequency_rad/s": F, "table_amplitude_mm": F, "x_amplitude_mm": F, "phase_deg": LAG}),
            {"frequency": "rad/s", "base_displacement": "mm", "amplitude": "mm", "phase": "deg"}, True, "translation",
        ),
    ],
)  # fmt: skip
def test_columns_are_told_by_their_names_and_units_and_a_lag_by_its_power(given, mapped, lag, coordinate):
    found = propose_response(given)
    assert found is not None
    assert {name: unit for name, (_, unit) in found.columns.items()} == mapped
    assert (found.lag, found.coordinate) == (lag, coordinate)


def test_what_is_assumed_is_said():
    found = propose_response(table(freq=F, amplitude=F, phase=-LAG, temperature=F))
    assert found is not None
    said = "; ".join(found.remarks)
    assert "frequency: column 'freq' says no unit; Hz is assumed" in said
    assert "column 'temperature' is not mapped" in said
    assert "no column looks like what drives: 1 N at every point is taken" in said


def test_a_recording_in_time_is_no_harmonic_set():
    assert propose_response(table(time_s=F, frequency_Hz=F, amplitude_mm=F, phase_deg=F)) is None
