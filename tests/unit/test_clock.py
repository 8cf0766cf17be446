"""Whether an outside force has a clock of its own: what a memory leaves begins in units of the release and dies out."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from undertow.comparison.clock import TIED, TIED_SURELY, _locked, no_clock, parts_of

RELEASES = (0.02, 0.05, 0.01, 0.03)
TIMES = np.linspace(0.0, 10.0, 101)
STEADY = {"cosine_N": ("gcos",), "sine_N": ("gsin",)}
CHANGING = {f"{part}e_N_{n}": ("g" + part[:3], f"g{part[:3]}{end}") for n, end in enumerate(("_t", "_tt"), start=1)
            for part in ("cosin", "sin")}  # fmt: skip


def fitted(forces: np.ndarray, misfit: float = 3.0) -> tuple[Any, Any, Any]:
    """A level of two springs with two trials each, a fit with forces (4, 2 or 6) of known size, and the force."""
    slots = STEADY if forces.shape[1] == 2 else STEADY | CHANGING
    names = list(slots)
    trials = [f"r{i}" for i in range(4)]
    motions = [SimpleNamespace(name=name, amplitude=x0) for name, x0 in zip(trials, RELEASES, strict=True)]
    force = SimpleNamespace(
        prefix="external_forcing", has_its_own_clock=True,
        additions=[
            SimpleNamespace(name=name, of_its_own=True, also=own[1:], slots=tuple((slot, 1.0) for slot in own[-1:]))
            for name, own in slots.items()
        ],
    )  # fmt: skip
    unknowns = [f"external_forcing.{name}[{trial}]" for trial in trials for name in names]
    problem = SimpleNamespace(names=unknowns, trials=[SimpleNamespace(name=n, t=TIMES) for n in trials])
    solution = SimpleNamespace(problem=problem, values=forces.ravel(), covariance=1e-6 * np.eye(forces.size))
    fit = SimpleNamespace(solution=solution, misfit=misfit, value=lambda name: 3.0)
    members = [SimpleNamespace(motions=motions[:2]), SimpleNamespace(motions=motions[2:])]
    return SimpleNamespace(trials=4, members=members), fit, force


def of_phases(phases: list[float], scale: float = 1000.0) -> np.ndarray:
    """Forces (4, 2) in units of the release at these phases."""
    size = scale * np.array(RELEASES)
    return np.column_stack([size * np.cos(phases), size * np.sin(phases)])


def said(monkeypatch: pytest.MonkeyPatch, forces: np.ndarray, beside: bool, misfit: float, before: float = 4.0) -> str:
    monkeypatch.setattr("undertow.comparison.clock._own_motion", lambda *given: "")
    level, fit, force = fitted(forces, misfit)
    return no_clock(level, fit, force, beside, SimpleNamespace(misfit=before))


def test_a_force_in_units_of_the_release_is_a_memory_s_beside_another_effect(monkeypatch):
    tied = of_phases([0.3, 0.3, 1.0, 1.0])
    assert "tied to the release: phases and sizes agree in all trials by 100 %" in said(monkeypatch, tied, True, 3.0)
    assert said(monkeypatch, tied, False, 3.0) == ""  # alone and steady: a seiche begun by the release has no memory
    assert said(monkeypatch, of_phases([0.3, 2.5, 1.0, 4.0]), True, 3.0) == ""


def test_down_to_noise_it_must_be_tied_beyond_doubt(monkeypatch):
    """Of water that radiates waves a force was named at 1.7 times the noise, whose phases agreed in 1 of 100 draws."""
    surely = of_phases([0.3, 0.3, 1.0, 1.0])
    assert "tied to the release" in said(monkeypatch, surely, True, 1.7)
    nearly = of_phases([0.3, 1.2, 1.0, 1.6])  # agree in some 12 of 100 draws
    assert "tied to the release" in said(monkeypatch, nearly, True, 3.0)
    assert said(monkeypatch, nearly, True, 1.7) == ""
    assert TIED_SURELY < 0.12 < TIED


def through(first: np.ndarray, middle: np.ndarray, last: np.ndarray) -> np.ndarray:
    """Forces (4, 6) of these sizes where the record begins, in its middle and at its end."""
    slope, bend = -3.0 * first + 4.0 * middle - last, 2.0 * first - 4.0 * middle + 2.0 * last
    return np.column_stack([first, slope / TIMES[-1], bend / TIMES[-1] ** 2])


def test_a_force_that_dies_out_is_looked_at_where_the_record_begins(monkeypatch):
    """What a memory leaves begins in units of the release; by the middle it has died out, and its phases are any."""
    tied, any_ = of_phases([0.3, 0.3, 1.0, 1.0]), of_phases([0.1, 2.5, 1.0, 4.0], 300.0)
    assert "tied to the release" in said(monkeypatch, through(tied, any_, 0.1 * any_), False, 3.0)
    assert said(monkeypatch, through(tied, any_, 3.0 * any_), False, 3.0) == ""  # by chance it begins alike
    assert said(monkeypatch, through(3.0 * any_, any_, 0.1 * any_), False, 3.0) == ""
    assert "tied to the release" in said(monkeypatch, through(any_, tied, any_), False, 3.0)


@pytest.mark.parametrize(("share", "at"), [(0.0, 0.0), (0.5, 5.0), (1.0, 10.0)])
def test_a_force_s_parts_are_those_at_that_share_of_the_record(share, at):
    _, fit, force = fitted(np.tile([1.0, 2.0, 0.1, 0.2, 0.01, 0.02], (4, 1)))
    places, counts = parts_of(fit, force, "r1", share)
    there = 1.0 + 0.1 * at + 0.01 * at**2
    assert counts @ fit.solution.values[places] == pytest.approx([there, 2.0 * there])


@pytest.mark.parametrize(
    ("phases", "share"),
    [([0.3, 0.3, 1.0, 1.0], 1.0), ([0.3, 0.3 + np.pi, 1.0, 1.0], 1.0), ([0.3, 0.3 + np.pi / 2, 1.0, 1.0], 0.5),
     ([0.3, 0.3 + np.pi / 2, 1.0, 1.0 - np.pi / 2], 0.0)],
    ids=["the same", "opposite", "a quarter apart on one spring", "a quarter apart on both"],
)  # fmt: skip
def test_phases_are_locked_where_each_spring_s_trials_have_the_same_or_the_opposite_one(phases, share):
    level, fit, force = fitted(of_phases(phases))
    assert _locked(level, fit, force) == pytest.approx(share, abs=1e-12)
