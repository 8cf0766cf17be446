"""The one trial of a group that was filtered, or lost samples: as close as repetitions are, and far above its noise."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import undertow
from undertow.discrepancy.alone import Alone, one_alone

LAW = {"stiffness": 400.0, "viscous_damping": 1.0}


def recorded(x0: float, seed: int, filtered: bool, gap: bool = False) -> pd.DataFrame:
    """A decay of 1.6 Hz at 60 Hz after a hold; filtered over a third of a period, or a quarter of a second cut out."""
    k, c = (1.0 + part * np.random.default_rng(seed).standard_normal() for part in (0.002, 0.05))
    law = {"stiffness": 400.0 * k, "viscous_damping": c}
    run = undertow.simulate(law, x0=x0, mass_kg=4.0, rate_hz=60.0, duration_s=8.0)
    x = np.concatenate([np.full(30, x0), run.x])
    x = x + 1e-4 * np.random.default_rng(100 + seed).standard_normal(x.size)
    t = np.arange(x.size) / 60.0
    if filtered:
        x = np.convolve(np.pad(x, 6, mode="edge"), np.full(13, 1.0 / 13.0), mode="valid")
    if gap:
        x = np.delete(x, slice(130, 145))
        t = t[: x.size]
    return pd.DataFrame({"t": t, "x": x})


@pytest.mark.parametrize(
    ("how", "held", "status"),
    [("", "r4", "nothing_missing"), ("filtered", "r4", "cannot_tell"), ("filtered", "r1", "cannot_tell"),
     ("gap", "r4", "cannot_tell")],
)  # fmt: skip
def test_a_trial_that_is_not_what_it_seems_bars_green(how: str, held: str, status: str) -> None:
    strange = {"filtered": how == "filtered", "gap": how == "gap"}
    tables = [recorded(0.08, at, **(strange if at == 4 else {"filtered": False})) for at in range(6)]
    found = undertow.diagnose(
        tables, ["stiffness", "viscous_damping"], units={"x": "m"}, mass_kg=4.0, stiffness_N_per_m=400.0,
        suspects=["cubic_stiffness"], scatter={"k": 0.004, "c": 0.1}, names=[f"r{at}" for at in range(6)],
        hold_out=[held],
    )  # fmt: skip
    assert found[0].status == status
    if how:
        assert "of the motion of trial r4" in found[0].verdict.because
        assert "leave it out (recordings.exclude)" in found[0].verdict.because


def trials(*misfits: float) -> tuple[SimpleNamespace, SimpleNamespace]:
    """A group of so many trials, and a fit that leaves so much of each, always 3 % of the motion."""
    names = [f"r{at}" for at in range(len(misfits))]
    channel = SimpleNamespace(quantity="displacement", sigma=0.03, values=np.array([-1.0, 1.0]))
    fitted = tuple(SimpleNamespace(name=name, t=np.zeros(2), channels=(channel,)) for name in names)
    solution = SimpleNamespace(problem=SimpleNamespace(trials=fitted), residuals=[np.ones(2)] * len(misfits))
    fit = SimpleNamespace(solution=solution, misfits=dict(zip(names, misfits, strict=True)))
    motions = tuple(SimpleNamespace(name=name, amplitude=0.05) for name in names)
    return SimpleNamespace(member=SimpleNamespace(motions=motions), held=(), own="k, c and mu"), fit


@pytest.mark.parametrize(
    ("misfits", "name"),
    [((1.0, 9.0, 1.1), "r1"), ((1.0, 2.4, 0.5), ""), ((1.0, 9.0, 2.5), ""), ((1.0, 9.0), ""), ((3.0, 3.1, 12.5), "r2")],
)
def test_one_trial_stands_out_where_the_next_leaves_far_less(misfits: tuple[float, ...], name: str) -> None:
    found = one_alone(*trials(*misfits))
    assert (found.name if found else "") == name
    if found:
        assert found == Alone(name, pytest.approx(0.03), max(misfits))


@pytest.mark.parametrize(("release", "physics"), [(0.05, False), (0.052, False), (0.06, True)])
def test_what_the_largest_release_alone_meets_may_be_physics(release: float, physics: bool) -> None:
    case, fit = trials(1.0, 1.0, 400.0)
    case.member.motions[2].amplitude = release
    found = one_alone(case, fit)
    assert (found.largest, "as a stop" in found.words) == (physics, physics)


def test_trials_of_other_groups_do_not_count() -> None:
    case, fit = trials(1.0, 1.0, 1.0, 50.0)
    case.member.motions = case.member.motions[:3]
    assert one_alone(case, fit) is None
