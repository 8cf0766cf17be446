"""The building's sensor alone invents the damper that the other sensor saw."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from experiments.two_sensors.__main__ import CONFIG, SENSOR_1_HZ, START_RAD_PER_S
from experiments.two_sensors.building import coupled_modes, hidden_from
from undertow.campaign.config import load
from undertow.campaign.run import read_and_condition
from undertow.equation.kernel import N_SLOTS, SLOT

RECORDINGS = Path(__file__).resolve().parents[2] / ".." / "shared" / "recordings" / "tmd_two_sensors"


@pytest.mark.skipif(not RECORDINGS.is_dir(), reason=f"{RECORDINGS} is not there: the recordings lie beside the project")
def test_the_hidden_coordinate_is_the_dampers():
    motion = read_and_condition(load(CONFIG)).motions[0]
    found = hidden_from(motion, ("stiffness",), START_RAD_PER_S, Path(motion.recording.path))
    assert found.r2 >= 0.94
    assert found.correlation >= 0.9
    assert found.frequencies_hz == pytest.approx(SENSOR_1_HZ, rel=0.02)


def test_coupled_modes_of_an_undamped_pair_are_those_of_the_closed_form():
    theta = np.zeros(N_SLOTS)
    for slot, value in {"mass": 1.0, "k1": 30.0, "hm1": 0.2, "hw1": 6.0}.items():
        theta[SLOT[slot]] = value
    total = 30.0 + 36.0 * 1.2  # sum and product of squared frequencies: k/M + w^2 (1 + m/M), k/M w^2
    root = np.sqrt(total**2 / 4.0 - 30.0 * 36.0)
    expected = np.sqrt([total / 2.0 - root, total / 2.0 + root]) / (2.0 * np.pi)
    assert coupled_modes(theta) == pytest.approx(expected, rel=1e-9)
