"""Strength by a refit that follows an effect all the way, with algebra that keeps what the data leave free."""

import math
from dataclasses import replace

import numpy as np
import pytest

from experiments.blind_challenge import refit
from experiments.blind_challenge import strength as measure
from experiments.blind_challenge.effects import kind
from experiments.blind_challenge.rigs import Needs, Rig, draw_rig
from experiments.blind_challenge.scene import Change, Scene, move, read


@pytest.fixture(scope="module")
def rig() -> Rig:
    """Four trials in water of one spring, with friction, an accelerometer and a mass that nobody knows."""
    needs = Needs(
        trials=(4, 4), springs=(1,), levels=(1,), coordinate="translation", quiet=True, friction=True,
        channels=("acceleration",),
    )  # fmt: skip
    drawn = draw_rig(np.random.default_rng(5), needs, "none")
    return replace(
        drawn, scatter=(0.004, 0.05, 0.05), periods=12.0, knows=frozenset({"scatter"}),
        trials=tuple(t for t in drawn.trials)[:4],
    )  # fmt: skip


@pytest.fixture(scope="module")
def views(rig: Rig) -> list[measure.View]:
    """The campaign linearised as `strength` does."""
    return [measure.view(rig, trial) for trial in rig.trials]


def softer(scene: Scene, dose: float) -> Change:
    """A support that gives way and has no mass: another stiffness, nothing else."""
    return Change(scene.body.changed(stiffness=scene.body.stiffness / (1.0 + dose)))


def test_a_stiffness_twelve_percent_lower_has_no_strength_though_it_loses_a_cycle(rig: Rig, views: list) -> None:
    one_step = measure.strength_of(rig, views, softer, 0.12, linear=False)
    assert one_step.statistic > 1e4
    found, end = refit.strength_of(rig, views, softer, 0.12, linear=False)
    assert end is not None
    assert end.ended
    assert found.statistic < 0.1
    assert found.size < 0.05
    place = next(i for key, i in refit.Local(rig, end.views).problem.index.items() if key == ("k", 0, -1))
    mass = next(i for key, i in refit.Local(rig, end.views).problem.index.items() if key[0] == "ma")
    assert end.numbers[place] - end.numbers[mass] == pytest.approx(-math.log(1.12), abs=2e-3)  # k / M is what is known


def test_proportional_effects_are_as_strong_as_one_step_says(rig: Rig, views: list) -> None:
    for key in ("cubic_stiffness", "hidden_resonator"):
        law = kind(key)
        shape = law.draw(np.random.default_rng(1), rig)

        def change(scene: Scene, dose: float, law=law, shape=shape) -> Change:
            return law.applied(shape, dose, scene)

        old = measure.strength_of(rig, views, change, 1.0, linear=True)
        new, _ = refit.strength_of(rig, views, change, 1.0, linear=True)
        assert new.statistic == pytest.approx(old.statistic, rel=0.05)


def test_a_refit_that_follows_leaves_what_the_equation_does_not_have(rig: Rig, views: list) -> None:
    law = kind("cubic_stiffness")
    shape = law.draw(np.random.default_rng(1), rig)
    both, _ = refit.strength_of(
        rig, views, lambda s, d: replace(law.applied(shape, d, s), body=softer(s, 0.1 * d).body), 0.2, linear=False
    )
    alone, _ = refit.strength_of(rig, views, lambda s, d: law.applied(shape, d, s), 0.2, linear=True)
    assert both.statistic == pytest.approx(alone.statistic, rel=0.05)
    assert both.statistic > 100.0


def test_numbers_that_nothing_fixes_have_wide_errors(rig: Rig, views: list) -> None:
    local = refit.Local(rig, [refit._seen(v) for v in views])
    sure = local.deviations()
    named = {key[0]: i for key, i in local.problem.index.items() if key[2] < 0}
    assert sure[named["k"]] > 0.3  # the decay knows k / M alone: the priors are all that holds either
    assert sure[named["ma"]] > 0.3
    apart = np.zeros(sure.size)
    apart[named["k"]], apart[named["ma"]] = 1.0, -1.0
    cover = np.linalg.inv(local.matrix.T @ local.matrix)
    assert float(apart @ cover @ apart) < 0.01**2


def test_a_clock_off_by_less_than_a_sample_has_no_strength_where_friction_jumps(rig: Rig, views: list) -> None:
    seen = [refit._seen(v) for v in views]
    assert all(0.5 < v.kept.mean() < 1.0 for v in seen)
    count = seen[0].samples - 1
    assert np.all(seen[0].kept[:count] == 1.0)  # the displacement does not jump

    def slow(scene: Scene, dose: float) -> Change:
        return kind("imperfect_release").applied({}, dose, scene)

    found, _ = refit.strength_of(rig, views, slow, 5e-4, linear=False)
    assert found.statistic < 0.05
    assert found.size < 0.05


def test_readings_before_the_release_are_held(rig: Rig, views: list) -> None:
    view = refit._seen(views[0])
    numbers = dict.fromkeys(view.columns, 0.0)
    frequency = view.scene.body.frequency
    numbers["shift", 0] = -3.5 * rig.step * frequency
    x = refit._readings(view, numbers)["displacement"]
    truth = read(view.scene, Change(view.scene.body), move(view.scene, Change(view.scene.body), view.samples), 0)
    start = view.scene.trial.release + view.scene.trial.rest
    first = view.scene.trial.first
    held = math.ceil((3.5 * rig.step - first) / rig.step)
    assert np.allclose(x[:held], start, atol=1e-12)
    later = np.interp(
        np.arange(40) * rig.step + first + (held - 3.5) * rig.step,
        np.arange(60) * rig.step + first, truth["displacement"][:60],
    )  # fmt: skip
    assert np.allclose(x[held : held + 40], later, atol=2e-3 * rig.largest)


def test_an_effect_is_nothing_beside_its_own_twin(rig: Rig, views: list) -> None:
    law, other = kind("cubic_stiffness"), kind("hidden_resonator")
    shape, far = law.draw(np.random.default_rng(1), rig), other.draw(np.random.default_rng(2), rig)

    def change(scene: Scene, dose: float) -> Change:
        return law.applied(shape, dose, scene)

    found, end = refit.strength_of(rig, views, change, 1.0, linear=True)
    assert end is not None
    assert refit.beside(rig, end, change, 1.0, linear=True) < 1e-3 * found.statistic
    apart = refit.beside(rig, end, lambda s, d: other.applied(far, d, s), 1.0, linear=True)
    assert 0.05 * found.statistic < apart <= found.statistic


def test_a_motion_that_runs_away_is_without_limit(rig: Rig, views: list) -> None:
    def mad(scene: Scene, dose: float) -> Change:
        return Change(scene.body.changed(damping=-1e4 * scene.body.damping, drag=-scene.body.drag))

    with np.errstate(all="ignore"):
        found, end = refit.strength_of(rig, views, mad, 1.0, linear=False)
    assert found.statistic == math.inf
    assert end is None
