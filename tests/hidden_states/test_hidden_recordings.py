"""Real recordings: the building that carries a damper, and the pendulum's friction; skipped where they are absent."""

import json

import pytest

from experiments.hidden_states import real
from undertow.comparison.hidden_trajectories import LINEAR
from undertow.equation.structure import CoulombFriction, SineRestoring, Stiffness, ViscousDamping

needs_recordings = pytest.mark.skipif(
    not real.RECORDINGS.exists(), reason=f"the real recordings are not at {real.RECORDINGS}; they are no part of this"
)


@needs_recordings
def test_the_building_gets_a_hidden_oscillator_between_its_two_modes():
    found = real.building(real.motions_of(real.BUILDING), LINEAR)
    assert found["count"] == 1
    assert found["backed"]
    low, high = found["modes_hz"]
    # two free waves through the same sensor: 0.888 and 1.251 Hz; five per cent, as one trial in noise of 1 mm gives
    assert low == pytest.approx(0.888, rel=0.05)
    assert high == pytest.approx(1.251, rel=0.05)
    assert found["nrmse"]["with an oscillator"] < 0.4 * found["nrmse"]["with static rivals"]


@needs_recordings
def test_the_pendulum_asks_for_sine_and_friction_beside_viscous_damping(monkeypatch):
    monkeypatch.setattr(real, "DAMPING", (ViscousDamping(), CoulombFriction()))
    first = real.motions_of(real.PENDULUM)[0]
    compared = real.compare(first, ((SineRestoring(),), (Stiffness(),)), real.DAMPING)
    assert compared["candidates"][0][0] == ["sine_restoring", "viscous_damping", "coulomb_friction"]
    assert compared["candidates"][1][1] > 6.0  # odds of 20 to 1 against the next
    # an independent output-error check in the recording's README: 120.3 and 1.99
    assert compared["numbers"]["sine_restoring"][0] == pytest.approx(120.3, rel=1e-3)
    assert compared["numbers"]["coulomb_friction"][0] == pytest.approx(1.99, rel=0.05)


def test_the_committed_answers_leave_viscous_and_quadratic_damping_of_the_pendulum_open():
    result = json.loads(real.RESULT.read_text())
    for swing in result["pendulum"]:
        sets = {tuple(sorted(names)): difference for names, difference, _, _ in swing["candidates"]}
        viscous = sets["coulomb_friction", "sine_restoring", "viscous_damping"]
        quadratic = sets["coulomb_friction", "quadratic_drag", "sine_restoring"]
        assert abs(viscous - quadratic) < 6.0
        assert not any("stiffness" in names for names, difference in sets.items() if difference < 6.0)


def test_without_recordings_the_command_says_where_they_are_expected(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(real, "RECORDINGS", tmp_path / "nowhere")
    assert real.main() == 1
    assert "nowhere" in capsys.readouterr().err
