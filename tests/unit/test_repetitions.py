"""How much trials differ, as releases of one size show it, in any group of a campaign whose dry trials are too few."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from experiments.eq15_campaign.motion import Body
from tests.short_trials import LONG, released
from undertow.campaign.config import RunConfig, load
from undertow.campaign.run import judgement
from undertow.campaign.run.course import Course, Read
from undertow.campaign.run.repeating import scatter_seen
from undertow.campaign.run.rig import with_known
from undertow.campaign.run.tasks import group_task, structures_of, with_scatter
from undertow.comparison.level import Addend, Member
from undertow.comparison.suspect import Addition
from undertow.conditioning.condition import condition
from undertow.conditioning.motion import Motion
from undertow.equation.kernel import SLOT
from undertow.likelihood.fit import Fit
from undertow.likelihood.problem import TrialOptions
from undertow.methods.baseline import terms_by_name
from undertow.methods.dry import DEFAULT_SCATTER, RIGS_WITHIN, Scatter, believed
from undertow.methods.repeated import pooled, repetitions, scatter_of_repetitions
from undertow.quantities import Estimate

DRY = Body(2637.4, 590.0, 109592.0, 170.0, 0.0)
TERMS = ["stiffness", "viscous_damping", "coulomb_friction", "added_mass", "quadratic_drag"]
CONFIG = f"""\
name: repeated
recordings:
  files: "*.csv"
  channels: {{time: {{column: t, unit: s}}, displacement: {{column: x, unit: m}}}}
trials:
  group_by: [level]
  dry: {{level: 0}}
specimen: {{mass_kg: 2637.4, area_m2: 1.75, submerged_volume_m3: 0.5}}
equation: {{terms: [{", ".join(TERMS)}]}}
"""


def sizes(*amplitudes: float) -> list[Any]:
    return [SimpleNamespace(amplitude=a) for a in amplitudes]


@pytest.mark.parametrize(
    ("amplitudes", "sets"),
    [
        ((0.1,), ()),
        ((0.03, 0.06, 0.1), ()),
        ((0.1, 0.03, 0.105, 0.031, 0.109), ((0.1, 0.105, 0.109), (0.03, 0.031))),
        ((0.1, 0.108, 0.116), ((0.1, 0.108),)),
    ],
)
def test_releases_within_a_tenth_repeat_each_other(amplitudes: tuple[float, ...], sets: tuple[Any, ...]) -> None:
    assert tuple(tuple(m.amplitude for m in one) for one in repetitions(sizes(*amplitudes))) == sets


def fits(**numbers: tuple[float, ...]) -> list[Fit]:
    """One fit a value, each number with an error of a thousandth of it."""
    each = zip(*numbers.values(), strict=True)
    return [
        Fit("output_error", ("t",), {}, {n: Estimate(v, 1e-3 * v) for n, v in zip(numbers, values, strict=True)})
        for values in each
    ]


def test_sets_of_repetitions_share_one_scatter_about_means_of_their_own() -> None:
    rng = np.random.default_rng(3)
    factors = 1.0 + 0.02 * rng.standard_normal((2, 12))
    sets = [fits(k_N_per_m=tuple(size * row)) for size, row in zip((100.0, 900.0), factors, strict=True)]
    found = scatter_of_repetitions(sets)
    assert found is not None
    assert found.freedom == 22.0
    assert found.values["k"] == pytest.approx(np.sqrt(np.mean(np.var(factors, axis=1, ddof=1))), rel=0.05)
    assert found.values["mu"] == 0.0  # no equation has it


@pytest.mark.parametrize(
    ("away", "noise", "least", "most"),
    [
        (5.3, 26.7, 0.5, 3.0),  # no trial knows its friction: it had been 17 times the mean
        (0.2, 0.01, 1.7, 2.3),  # three trials that tell decide
    ],
)
def test_trials_whose_noise_hides_their_scatter_leave_what_rigs_have(
    away: float, noise: float, least: float, most: float
) -> None:
    """Beside a usual scatter of .1 of the friction."""
    fits = [
        Fit("output_error", (f"r{at}",), {}, {"mu": Estimate(0.01 * (1.0 + at * away), 0.01 * noise)})
        for at in (-1.0, 0.0, 1.0)
    ]
    seen = scatter_of_repetitions([fits])
    assert seen is not None
    assert least * DEFAULT_SCATTER["mu"] < seen.values["mu"] < most * DEFAULT_SCATTER["mu"]


def test_a_number_that_was_held_says_nothing_of_scatter() -> None:
    held = {"k_N_per_m": (5.0, 5.0, 5.0), "mu": (0.1, 0.1, 0.1)}
    found = scatter_of_repetitions([fits(**held, total_mass_kg=(10.0, 10.3, 9.8))])
    assert found is not None
    assert "mu" not in found.values
    assert found.values["k"] == pytest.approx(0.025, rel=0.3)  # the mass that goes with the stiffness


@pytest.mark.parametrize(
    ("trials", "known", "shown"), [(2, 0.0, False), (2, 1.0, True), (3, 0.0, True), (1, 5.0, False)]
)
def test_two_degrees_of_freedom_are_needed_wherever_they_come_from(trials: int, known: float, shown: bool) -> None:
    one = fits(k_N_per_m=(5.0, 5.1, 5.2)[:trials])
    assert (scatter_of_repetitions([one], known) is not None) == shown


def test_two_sights_of_one_scatter_count_by_their_degrees_of_freedom() -> None:
    both = pooled(Scatter({"k": 0.01, "c": 0.3}, 3.0), Scatter({"k": 0.02, "mu": 0.1}, 1.0))
    assert both.freedom == 4.0
    assert both.values["k"] == pytest.approx(np.sqrt((3.0 * 0.01**2 + 0.02**2) / 4.0))
    assert both.values["c"] == pytest.approx(0.3)  # unseen the second time, and more than rigs scatter
    few = pooled(Scatter({"k": 0.01, "c": 0.01}, 1.0), Scatter({"k": 0.01}, 11.0))
    assert few.values["c"] == believed({"c": 0.01}, 1.0, "c") > 0.1  # eleven more degrees of freedom say nothing of c
    assert both.values["mu"] == pytest.approx(0.05)  # the first saw none


@cache
def motion(body: Body, level: int, at: int, k: float, x0_m: float = 0.1) -> Motion:
    body = replace(body, k_N_per_m=k * body.k_N_per_m)
    recording = released(body, x0_m, f"l{level}t{at}", 10 * level + at, 6.0, ("x",))
    return condition(replace(recording, conditions={"level": level}))


def campaign(dry: int, repeated: int, spread: float) -> dict[Any, list[Motion]]:
    """So many dry trials, so many releases of one size in one water with a stiffness that differs, one in another."""
    factors = 1.0 + spread * np.random.default_rng(5).standard_normal(max(repeated, dry))
    groups: dict[Any, list[Motion]] = {
        (("level", 1),): [motion(LONG, 1, i, float(k)) for i, k in enumerate(factors[:repeated])],
        (("level", 2),): [motion(LONG, 2, 0, 1.0)],
    }
    if dry:
        groups[("level", 0),] = [motion(DRY, 0, i, float(k)) for i, k in enumerate(factors[:dry])]
    return groups


def configured(folder: Path, text: str = CONFIG) -> RunConfig:
    (folder / "config.yaml").write_text(text)
    return load(folder / "config.yaml")


def test_what_one_water_repeats_says_how_trials_differ_in_another(tmp_path: Path) -> None:
    config, groups, terms = configured(tmp_path), campaign(1, 8, 0.02), terms_by_name(TERMS)
    structures = structures_of(config, groups, terms)
    seen = scatter_seen(config, groups, terms, structures)
    assert seen is not None
    assert seen.freedom == 7.0
    actual = np.std((1.0 + 0.02 * np.random.default_rng(5).standard_normal(8)), ddof=1)
    assert seen.values["k"] == pytest.approx(actual, rel=0.25)  # dry it would be assumed: 0.4 %
    assert seen.values["c"] == DEFAULT_SCATTER["c"]  # held in water: only assumed
    again = with_scatter(structures, seen)
    task = group_task(config, (("level", 2),), groups[("level", 2),], terms, again, seen)
    assert task.structure is not None
    assert (task.structure.scatter["k"], task.structure.scatter_freedom) == (seen.values["k"], 7.0)
    assert task.structure.k.stderr > structures[()].structure.k.stderr  # one dry trial is one draw of a wider scatter


def test_cells_that_show_another_spring_in_water_make_its_group_as_unsure_as_uneven_dry_trials(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config, groups, terms = configured(tmp_path), campaign(3, 3, 0.002), terms_by_name(TERMS)
    structures = structures_of(config, groups, terms)
    monkeypatch.setattr("undertow.campaign.run.tasks._another_spring", lambda found, slopes: "another spring")
    asked = {key: group_task(config, key, one, terms, structures).uneven for key, one in groups.items()}
    assert asked[("level", 1),] == "another spring"
    assert asked[("level", 0),] != "another spring"


def test_without_dry_trials_every_group_takes_what_the_campaign_repeats(tmp_path: Path) -> None:
    config, terms = configured(tmp_path), terms_by_name(TERMS)
    groups = campaign(0, 6, 0.02)
    seen = scatter_seen(config, groups, terms, {})
    assert seen is not None
    task = group_task(config, (("level", 2),), groups[("level", 2),], terms, {}, seen)
    assert (task.scatter, task.freedom) == (seen.values, 5.0)
    assert group_task(config, (("level", 2),), groups[("level", 2),], terms, {}).scatter == {}


@pytest.mark.parametrize(
    ("dry", "repeated", "text"),
    [
        (3, 8, CONFIG),
        (1, 8, CONFIG.replace("0.5}", "0.5, scatter: {k: 0.01, c: 0.1, mu: 0.1}}")),
        (0, 8, CONFIG.replace("0.5}", "0.5, scatter: {k: 0.01, c: 0.1, mu: 0.1}}")),
        (1, 1, CONFIG),
    ],
)
def test_nothing_is_asked_of_repetitions_where_more_is_known_or_none_are_there(
    tmp_path: Path, dry: int, repeated: int, text: str
) -> None:
    config, groups, terms = configured(tmp_path, text), campaign(dry, repeated, 0.01), terms_by_name(TERMS)
    assert scatter_seen(config, groups, terms, structures_of(config, groups, terms)) is None


def test_two_dry_trials_count_beside_repetitions(tmp_path: Path) -> None:
    config, groups, terms = configured(tmp_path), campaign(2, 4, 0.02), terms_by_name(TERMS)
    seen = scatter_seen(config, groups, terms, structures_of(config, groups, terms))
    assert isinstance(seen, Scatter)
    assert seen.freedom == 4.0


def said_of(folder: Path, groups: dict[Any, list[Motion]]) -> dict[int, str]:
    """Why the run says no more of each water than it does."""
    config = configured(folder, CONFIG + "discrepancy: {suspects: [cubic_damping]}\n")
    motions = tuple(m for group in groups.values() for m in group)
    (part,) = Course(config, jobs=1, given=Read(motions, ())).parts()
    return {int(str(group.key["level"])): group.verdict.because for group in part.groups}


def test_a_run_asks_no_group_for_repetitions_that_another_one_has(tmp_path: Path) -> None:
    asks = "3 dry trials of a spring, 3 releases of one size"
    assert said_of(tmp_path, campaign(1, 1, 0.005))[2].startswith(asks)
    assert not any(because.startswith(asks) for because in said_of(tmp_path, campaign(1, 4, 0.005)).values())


@pytest.mark.parametrize("freedom", [1.0, 3.0, 12.0])
@pytest.mark.parametrize("seen", [1e-6, 0.02, 0.1])
def test_the_believed_scatter_is_the_most_probable_one_beside_other_rigs(freedom: float, seen: float) -> None:
    logs = np.linspace(-12.0, 1.0, 260_001)
    away = (logs - np.log(DEFAULT_SCATTER["c"])) / np.log(RIGS_WITHIN)
    density = -freedom * (logs + 0.5 * (seen / np.exp(logs)) ** 2) - 0.5 * away**2
    most = float(np.exp(logs[np.argmax(density)]))
    assert believed({"c": seen}, freedom, "c") == pytest.approx(max(most, seen), rel=1e-3)
    assert believed({"c": 0.3}, freedom, "c") == 0.3  # more than rigs have: as seen
    assert believed({"c": seen}, 0.0, "c") == pytest.approx(DEFAULT_SCATTER["c"])


def test_few_repetitions_that_look_alike_are_pooled_with_published_rigs() -> None:
    theta = np.zeros(len(SLOT))
    theta[[SLOT["k1"], SLOT["c1"]]] = 400.0, 20.0
    equation = SimpleNamespace(compiled=True, theta=lambda _: theta)
    group: Any = SimpleNamespace(equation=equation, trials=(1,))
    lone: Any = SimpleNamespace(scatter={"k": 1e-4, "c": 0.5, "mu": 0.0}, freedom=2.0)
    blank = Member("all", cast(Any, SimpleNamespace(fixed=None)), (), TrialOptions(), False)
    member = judgement._with_scatter(blank, lone, group)
    assert member.spread["k1"] == believed(lone.scatter, 2.0, "k") > 10.0 * lone.scatter["k"]
    assert (member.spread["c1"], member.sizes["k1"], member.freedom) == (0.5, 400.0, 2.0)


def test_what_dry_trials_need_does_not_forget_what_repetitions_showed(tmp_path: Path) -> None:
    config, groups, terms = configured(tmp_path), campaign(1, 6, 0.02), terms_by_name(TERMS)
    structures = structures_of(config, groups, terms)
    seen = scatter_seen(config, groups, terms, structures)
    assert seen is not None
    tasks = [group_task(config, key, one, terms, with_scatter(structures, seen), seen) for key, one in groups.items()]
    harder = Addition("N_per_m3", "N/m^3", "k3", 0.0, 1.0, scope="spring", by_spring=(("all", 1e4, 1e3),))
    rigs = with_known(config, tasks, [Addend("cubic_stiffness", (harder,))])
    rig = rigs[("level", 2),]
    assert rig is not None
    assert rig.model.fixed is not None
    assert (rig.model.fixed.scatter["k"], rig.model.fixed.scatter_freedom) == (seen.values["k"], seen.freedom)
    unweighed = [replace(task, anchor=replace(task.anchor, kind="none")) for task in tasks]
    assert set(with_known(config, unweighed, [Addend("cubic_stiffness", (harder,))]).values()) == {None}
