"""Frequency and damping of single cycles: closed forms, and errors that say how far they may be off."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.findings_fixture import bare_findings, small_findings
from undertow.conditioning.motion import Motion, Window
from undertow.discrepancy.cycle_by_cycle import Cycling, cycling
from undertow.discrepancy.findings import AugmentedRun, TrialFindings
from undertow.discrepancy.mismatch import Mismatch
from undertow.quantities import Estimate
from undertow.recording.recording import Recording
from undertow.report.mismatch_figures import draw_cycles, draw_where
from undertow.report.style import new_figure, page_style

RATE, RATIO = 10.0, 0.02
"""Natural frequency, rad/s, and damping ratio of the closed form."""


def linear_decay(error_m: float = 1e-5, seed: int = 0) -> TrialFindings:
    """Underdamped free motion, 5 s at 200 Hz, its smoothed errors as stated; free runs are the truth."""
    t = np.arange(0.0, 5.0, 0.005)
    damped = RATE * math.sqrt(1.0 - RATIO**2)
    z = np.exp((-RATIO * RATE + 1j * damped) * t)
    x = 0.05 * z.real
    v, a = (0.05 * ((-RATIO * RATE + 1j * damped) ** n * z).real for n in (1, 2))
    rng = np.random.default_rng(seed)
    shown = x + error_m * rng.standard_normal(t.size)
    std = np.full(t.size, error_m)
    motion = Motion(
        Recording("r", t, {"displacement": shown}), Window(0.0, 0.0, 5.0), t, shown, v, a, std, RATE * std,
        RATE**2 * std, t >= 0.0, Estimate(0.0, 0.0, 0.0, "m"), 0.05, {"displacement": error_m},
    )  # fmt: skip
    return TrialFindings(motion, {}, {}, Mismatch("r", 0.0, 0.0, 0.1), t, x, x)


def test_a_linear_decays_cycles_have_its_frequency_and_damping() -> None:
    found = cycling(linear_decay())
    assert found is not None
    assert found.frequency == pytest.approx(RATE * math.sqrt(1.0 - RATIO**2) / (2.0 * math.pi), rel=1e-3)
    assert found.damping == pytest.approx(RATIO, rel=0.02)
    assert found.before is not None
    assert found.before.damping == pytest.approx(RATIO, rel=0.02)
    assert found.after is None


def test_errors_grow_as_the_motion_dies_and_cover_the_scatter() -> None:
    found = cycling(linear_decay(2e-4))
    assert found is not None
    assert np.all(np.diff(found.damping_error) > 0.0)
    away = (found.damping - RATIO) / found.damping_error
    assert 0.3 < float(np.sqrt(np.mean(away**2))) < 2.0  # eight cycles of one draw


def test_turns_that_noise_makes_are_no_cycles() -> None:
    trial = linear_decay()
    ripple = 2.0 * np.sin(100.0 * trial.t)  # of the speed: turns at 16 Hz, of a body at 1.6 Hz
    for motion, some in ((trial.motion, True), (replace(trial.motion, v=trial.motion.v + ripple), False)):
        found = cycling(replace(trial, motion=motion))
        assert found is not None
        assert bool(found.frequency.size) is some
        with page_style():
            panel = draw_cycles(found, new_figure(5.0, 3.0).subplots(), "frequency")
        assert ("noise turns the motion" in panel.get_title(loc="left")) is not some


def test_panels_without_a_clear_cycle_take_no_room() -> None:
    group = small_findings().groups[1]
    trial, heights = group.trials[3], []
    found = cycling(trial)
    assert found is not None
    none = Cycling(*(np.zeros(0) for _ in range(5)))
    for cycles in (found, none):
        with page_style():
            figure = draw_where(group, trial, cycles, {"body": 2.0}, new_figure(11.0, 5.0))
        figure.canvas.draw()
        heights.append(figure.axes[2].get_position().height)
        bars = [a.get_ylabel() for a in figure.axes if a.get_ylabel().startswith(("amplitude", "force"))]
        assert bars == ["amplitude (mm)", "force (N)"]
    assert heights[1] < 0.2 * heights[0]


def test_what_was_found_has_its_own_cycles() -> None:
    trial = linear_decay()
    faster = 0.05 * np.exp(-0.3 * trial.t) * np.cos(1.1 * RATE * trial.t)
    found = cycling(replace(trial, augmented=AugmentedRun(0.1, trial.measured - faster)))
    assert found is not None
    assert found.after is not None
    assert found.after.frequency == pytest.approx(1.1 * RATE / (2.0 * math.pi), rel=1e-3)


def test_a_motion_that_hardly_turns_has_no_cycles() -> None:
    trial = linear_decay()
    short = replace(trial.motion, inside=trial.t < 0.2)
    assert cycling(replace(trial, motion=short)) is None
    noisy = replace(trial.motion, noise={"displacement": 0.05})
    assert cycling(replace(trial, motion=noisy)) is None


def test_a_rate_alone_and_a_hidden_resonator_have_cycles_too() -> None:
    assert cycling(bare_findings(velocity_only=True).groups[0].trials[0]) is not None
    assert cycling(small_findings().groups[1].trials[3]) is not None
