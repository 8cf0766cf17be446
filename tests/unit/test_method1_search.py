"""Method 1's search: starts that stop early end where complete ones do, and two minima are still distinguished."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize

from undertow.likelihood.fit import Specimen
from undertow.methods import method1
from undertow.methods.method1 import FINE, STARTS, History, runge_kutta, search

SPECIMEN = Specimen(mass_kg=2637.4, area_m2=0.97)
STRUCTURE = (109592.0, 590.0, 0.0073)
RELEASE_M = 0.107
STEP_S = 0.001
"""The report's time step."""


def history(added_kg: float, drag: float, noise_m: float, seed: int) -> History:
    """Eight seconds of the recipe's own motion with noise, 100 Hz."""
    k, c, mu = STRUCTURE
    friction = mu * SPECIMEN.normal_force_N
    unit = SPECIMEN.drag_N_per_unit_coefficient
    x = runge_kutta(2637.4 + added_kg, c, k, friction, unit * drag, RELEASE_M, STEP_S, 8000)
    t = np.arange(0, 8001, 10) * STEP_S
    return History(t, x[::10] + noise_m * np.random.default_rng(seed).standard_normal(t.size), RELEASE_M)


@pytest.mark.parametrize("added_kg", [60.0, 1271.0])
def test_a_start_in_a_known_valley_need_not_go_to_its_end(added_kg):
    data = history(added_kg, 8.1, 2e-4, 0)
    added, drag, rms = search(data, STRUCTURE, SPECIMEN)
    complete = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(method1, "SAME_RMS", 0.0)  # no valley is ever known
        patch.setattr(method1, "COARSE", FINE)
        complete = [*search(data, STRUCTURE, SPECIMEN)]
    # a simplex stops anywhere on the valley's rough floor: 0.5 kg and 0.02 measured on the Eq. 15 campaign
    assert added == pytest.approx(complete[0], abs=0.5)
    assert drag == pytest.approx(complete[1], abs=0.02)
    assert rms == pytest.approx(complete[2], rel=1e-3)


@pytest.mark.parametrize("slower", [0.05, 30.0])
def test_a_body_of_another_pace_gets_the_same_answer(slower):
    data = history(1271.0, 8.1, 2e-4, 2)
    k, c, mu = STRUCTURE
    here = search(data, STRUCTURE, SPECIMEN)
    later = History(slower * data.t, data.x, data.x0)
    calm = replace(SPECIMEN, gravity_m_per_s2=SPECIMEN.gravity_m_per_s2 / slower**2)
    there = search(later, (k / slower**2, c / slower, mu), calm)
    assert there == pytest.approx(here, rel=1e-6)


def test_stopping_early_spares_half_of_the_integrations(monkeypatch):
    counts: list[int] = []

    def counting(*args, **kwargs):
        end = minimize(*args, **kwargs)
        counts.append(end.nfev)
        return end

    monkeypatch.setattr(method1, "minimize", counting)
    search(history(1271.0, 8.1, 2e-4, 1), STRUCTURE, SPECIMEN)
    assert len(counts) == len(STARTS) + 1
    monkeypatch.setattr(method1, "SAME_RMS", 0.0)
    monkeypatch.setattr(method1, "COARSE", FINE)
    search(history(1271.0, 8.1, 2e-4, 1), STRUCTURE, SPECIMEN)
    assert sum(counts[:4]) < 0.7 * sum(counts[4:])
