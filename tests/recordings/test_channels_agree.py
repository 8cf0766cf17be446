"""Nothing is said against the channels of recordings in which nothing is wrong, whatever physics they conceal."""

from __future__ import annotations

from pathlib import Path

import pytest

from undertow.campaign.config import load
from undertow.campaign.run.checking import Checked, Checker
from undertow.recording.gather import gather

ROOT = Path(__file__).resolve().parents[2]
SHARED = ROOT / ".." / "shared"

COMMITTED = ("eq15", "flume", "nonlinear_cell")
PRACTICE = ("one", "two", "three", "four")
RECORDINGS = (
    "bicycle_wheel_axial", "bicycle_wheel_radial", "kvlcc2", "rotary_pendulum", "sloshing_tank", "spring_disc_air",
    "tmd_two_sensors",
)  # fmt: skip

needs_shared = pytest.mark.skipif(not SHARED.is_dir(), reason="needs ../shared beside the repository")


def checked(config: str) -> list[Checked]:
    """Every trial of a campaign as a run checks it."""
    said = load(ROOT / "configs" / f"{config}.yaml")
    catalogue = said.catalogue()
    return [Checker(said, catalogue)(entry) for entry in gather(catalogue)]


def against(config: str) -> list[str]:
    """Everything that is said against a campaign's trials."""
    seen = checked(config)
    return [f"{c.name}: {f.sentence}" for c in seen for f in c.found] + [c.failed.reason for c in seen if c.failed]


@pytest.mark.parametrize("config", COMMITTED)
def test_committed_campaigns_are_not_doubted(config: str) -> None:
    assert against(config) == []


@needs_shared
@pytest.mark.parametrize("config", [f"practice/{name}" for name in PRACTICE])
def test_practice_campaigns_are_not_doubted(config: str) -> None:
    assert against(config) == []


@needs_shared
@pytest.mark.parametrize("config", [f"recordings/{name}" for name in RECORDINGS])
def test_real_recordings_are_not_doubted(config: str) -> None:
    assert against(config) == []


@needs_shared
def test_a_pendulum_that_a_hand_still_holds_is_doubted_where_no_window_is_set() -> None:
    config = load(ROOT / "configs" / "recordings" / "rotary_pendulum.yaml", ["trials.window=auto"])
    catalogue = config.catalogue()
    for entry in gather(catalogue):
        (doubt,) = Checker(config, catalogue)(entry).found
        assert doubt.kind == "hold"
        assert 0.2 < doubt.factor < 0.75  # s; by the recording's own description the hand is off at 0.75 s
