"""Cases: the same seed the same bytes, nothing of the truth beside a laboratory, configs that the program reads."""

import ast
import json
import shutil
import time
import zlib
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from experiments.blind_challenge import cases, composition, effects, generate, laboratory
from experiments.blind_challenge.rigs import Needs, draw_rig, factors
from experiments.blind_challenge.scene import Change, mean_scene, merge, move, read, sample_count

PACKAGE = Path(effects.__file__).parent
SEED = 3


@pytest.fixture(scope="module")
def challenge(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small challenge, one case of each kind and two with nothing missing."""
    out = tmp_path_factory.mktemp("challenge")
    generate.generate(out, SEED, 6, shares=composition.SMALL_SHARES, small=True)
    return out


def test_the_full_composition_is_that_of_the_challenge() -> None:
    plans = composition.plans(composition.TEST_SEED, composition.FULL)
    kinds = Counter(plan.kind for plan in plans)
    assert kinds == {"nothing": 700, "one": 200, "two": 150, "outside": 150, "cannot": 100}
    dry = Counter(plan.dry for plan in plans if plan.kind == "nothing")
    assert dry == {"few": 233, "none": 140, "many": 327}
    assert set(composition.ONE) == {plan.effects[0] for plan in plans if plan.kind == "one"}
    assert set(composition.OUTSIDE) == {plan.effects[0] for plan in plans if plan.kind == "outside"}
    assert {plan.reason for plan in plans if plan.kind == "cannot"} == set(composition.CANNOT)
    assert all(len(set(plan.effects)) == 2 for plan in plans if plan.kind == "two")


def test_shares_are_divided_without_a_rest() -> None:
    assert sum(composition.counts(101, composition.SHARES).values()) == 101
    assert composition.counts(13, {"a": 1.0, "b": 1.0}) in ({"a": 7, "b": 6}, {"a": 6, "b": 7})


def test_no_cases_are_refused() -> None:
    with pytest.raises(ValueError, match="cases: 0 were asked for"):
        composition.plans(1, 0)


def test_the_same_seed_gives_the_same_bytes_and_another_does_not(challenge: Path, tmp_path: Path) -> None:
    again = tmp_path / "again"
    generate.generate(again, SEED, 6, shares=composition.SMALL_SHARES, small=True)
    assert generate.digest(again) == generate.digest(challenge)
    plan = composition.Plan("nothing", (), "few", small=True)
    generate.make(tmp_path / "a", 1, 0, plan)
    generate.make(tmp_path / "b", 2, 0, plan)
    assert generate.digest(tmp_path / "a") != generate.digest(tmp_path / "b")


def test_strengths_are_stated_anew_where_the_recordings_are_the_same(challenge: Path, tmp_path: Path) -> None:
    out = tmp_path / "again"
    shutil.copytree(challenge, out)
    (out / "rows.jsonl").write_text("kept\n")
    truths = {p.name: p.read_text() for p in (out / "sealed").iterdir()}
    for path in (out / "sealed").iterdir():
        path.write_text("{}")
    assert generate.measure_again(out) == 6
    assert {p.name: p.read_text() for p in (out / "sealed").iterdir()} == truths
    assert sorted(p.name for p in out.iterdir()) == ["laboratory", "rows.jsonl", "sealed"]
    recording = next((out / "laboratory" / "c0003" / "recordings").iterdir())
    recording.write_text(recording.read_text().replace("1", "2"))
    with pytest.raises(ValueError, match=f"case c0003: {recording.name} is not what this generator draws from seed 3"):
        generate.measure_again(out)


def test_a_laboratory_holds_recordings_index_and_config_and_no_word_of_the_truth(challenge: Path) -> None:
    words = {"truth", "sealed", "strength", "dose", *effects.table()} - {
        "added_mass",
        "quadratic_drag",
        "coulomb_friction",
    }
    for folder in (p for p in (challenge / "laboratory").iterdir() if p.is_dir()):
        names = {p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()}
        assert {n for n in names if not n.startswith("recordings/r")} == {"config.yaml", "campaign.csv"}
        text = (folder / "config.yaml").read_text() + (folder / "campaign.csv").read_text()
        text += "".join(p.read_text().splitlines()[0] for p in (folder / "recordings").iterdir())
        assert not [word for word in words if word in text]
    note = json.loads((challenge / "laboratory" / "challenge.json").read_text())
    assert set(note) == {"seed", "cases", "shares", "small", "digest"}


def test_the_truth_names_every_group_and_every_trial(challenge: Path) -> None:
    for path in (challenge / "sealed").iterdir():
        truth = json.loads(path.read_text())
        index = (challenge / "laboratory" / truth["case"] / "campaign.csv").read_text()
        assert all(f"recordings/{name}" in index for name in truth["trials"])
        assert sum(len(g["trials"]) for g in truth["groups"]) == len(truth["trials"])
        for effect in truth["measures"]["effects"]:
            assert effect["strength"] > 0.0
            assert 0.01 <= effect["best_power"] <= 1.0
            assert len(effect["groups"]) == len(truth["groups"])


def test_every_config_of_every_effect_and_reason_loads(challenge: Path, tmp_path: Path) -> None:
    from undertow.campaign.config import load

    for folder in (p for p in (challenge / "laboratory").iterdir() if p.is_dir()):
        assert load(folder / "config.yaml").name == folder.name
    plans = [composition.Plan("one", (key,), "few") for key in effects.table()]
    plans += [composition.Plan("cannot", (), "few", reason) for reason in composition.CANNOT]
    for i, plan in enumerate(plans):
        rng = np.random.default_rng(i)
        rig = cases._laboratory(rng, plan, [effects.kind(key) for key in plan.effects])
        case = cases.Case(f"c{i:04d}", plan, rig, (), {"effects": []}, (0, i))
        folder = tmp_path / case.name
        (folder / "recordings").mkdir(parents=True)
        (folder / "config.yaml").write_text(laboratory.config(case))
        (folder / "campaign.csv").write_text(laboratory.index_table(rig))
        (folder / "recordings" / rig.trials[0].file).write_text("t\n")
        assert tuple(load(folder / "config.yaml").equation.terms) == rig.terms


@pytest.mark.parametrize("key", sorted(effects.table()))
def test_an_effect_moves_its_trials_and_has_the_names_of_the_contract(key: str) -> None:
    k = effects.kind(key)
    rng = np.random.default_rng(zlib.crc32(key.encode()))
    rig = draw_rig(rng, replace(k.needs, friction=True, trials=(6, 6), levels=(1,), springs=(1,)), "few")
    rig = k.fit_rig(rng, rig) if k.fit_rig else rig
    shape = k.draw(rng, rig)
    wet = [t for t in rig.trials if rig.levels[t.level].wet]
    moved = 0.0
    for trial in (max(wet, key=lambda t: t.release), wet[-1]):  # clipping needs a large one, a changed mass a late one
        scene = mean_scene(rig, trial)
        samples = min(1500, sample_count(rig, trial))
        change, plain = k.applied(shape, 3.0, scene), Change(scene.body)
        with_effect = read(scene, change, move(scene, change, samples), 3)
        without = read(scene, plain, move(scene, plain, samples), 3)
        for channel, values in without.items():
            moved = max(moved, float(np.max(np.abs(with_effect[channel] - values)) / np.max(np.abs(values))))
        assert k.applied(shape, 0.0, scene) == plain
    assert moved > 1e-5
    assert set(k.names) <= contract_names()
    assert set(k.near) <= contract_names() | {"quadratic_stiffness"}
    if k.numbers:
        assert all(np.isfinite(v) for v in k.numbers(shape, 3.0, scene).values())


def contract_names() -> set[str]:
    """The names of what can be missing, as the contract lists them."""
    return set(
        [
            "linear_damping",
            "quadratic_drag",
            "cubic_damping",
            "drag_exponent",
            "cubic_stiffness",
            "quintic_stiffness",
            "asymmetric_stiffness",
            "sine_restoring",
            "coulomb_friction",
            "stribeck_friction",
            "asymmetric_friction",
            "presliding",
            "added_mass",
            "variable_normal_force",
            "hidden_resonator",
            "relaxation",
            "hysteresis",
            "external_forcing",
            "delayed_echo",
            "rest_offset",
            "imperfect_release",
            "support_compliance",
            "mass_change",
            "time_shift",
            "gain_error",
            "sensor_drift",
            "clipping",
        ]
    )


def test_what_a_config_says_by_condition_is_in_its_index(tmp_path: Path) -> None:
    import pandas as pd
    from ruamel.yaml import YAML

    for i in range(12):
        plan = composition.Plan("nothing", (), ("few", "none", "many")[i % 3])
        rig = cases._laboratory(np.random.default_rng(i), plan, [])
        case = cases.Case("c0000", plan, rig, (), {"effects": []}, (0, i))
        said = YAML(typ="safe").load(laboratory.config(case))
        (tmp_path / "campaign.csv").write_text(laboratory.index_table(rig))
        index = pd.read_csv(tmp_path / "campaign.csv")
        dry = said["trials"].get("dry", {})
        assert bool(dry) == (plan.dry != "none")
        assert all(int((index[key] == value).sum()) == rig.dry_trials for key, value in dry.items())
        assert all(key in index for key in said["trials"]["group_by"])
        wet = set(index["water_depth_m"]) - set(dry.values())
        for name, values in said["specimen"].items():
            if isinstance(values, dict) and values.get("by") == "water_depth_m":
                assert {float(k) for k in values if k != "by"} == wet, name
            elif isinstance(values, dict) and values.get("by") == "spring":
                assert {k for k in values if k != "by"} == set(index["spring"])
        assert said["equation"]["terms"] == list(rig.terms)


@pytest.mark.parametrize("shape", ["normal", "student", "two groups", "skewed"])
def test_every_shape_of_scatter_has_the_stated_deviation(shape: str) -> None:
    rng = np.random.default_rng(0)
    draws = np.array([factors(rng, (0.01, 0.1, 0.05), shape) for _ in range(6000)])
    assert np.allclose(draws.mean(axis=0), 1.0, atol=0.01)
    # a Student's tails are cut at four deviations
    assert np.allclose(draws.std(axis=0), (0.01, 0.1, 0.05), rtol=0.15 if shape == "student" else 0.05)


def test_two_effects_are_merged_with_both_bodies_laws_and_places() -> None:
    rig = draw_rig(np.random.default_rng(0), Needs(friction=True), "few")
    scene = mean_scene(rig, rig.trials[-1])
    soft = effects.kind("cubic_stiffness")
    slow = effects.kind("presliding")
    first = slow.applied({}, 1.0, scene)
    second = soft.applied({"sign": 1.0}, 1.0, scene)
    both = merge(first, second, scene.body)
    assert both.body.coulomb == 0.0
    assert both.laws == first.laws + second.laws
    assert both.seen_by_cell == (1,)


def test_a_truth_that_runs_away_is_refused_with_its_trial() -> None:
    plan = composition.Plan("one", ("delayed_echo",), "none", small=True)
    rng = np.random.default_rng(5)
    rig = cases._laboratory(rng, plan, [effects.kind("delayed_echo")])
    mad = cases.Dosed(effects.kind("delayed_echo"), {"delay": 1.5, "sign": -1.0}, 300.0)
    case = cases.Case("c0000", plan, rig, (mad,), {"effects": []}, (5, 0))
    with pytest.raises(laboratory.UnstableTruth, match="case c0000, trial r"):
        laboratory.recording(case, rig.trials[0])


def test_a_weaker_case_has_half_the_dose_and_half_the_strength() -> None:
    plan = composition.Plan("one", ("cubic_stiffness",), "none", small=True)
    case = cases.draw_case(4, 0, plan)
    weak = generate.weaker(case)
    assert weak.effects[0].dose == 0.5 * case.effects[0].dose
    strong, less = (c.measures["effects"][0]["strength"] for c in (case, weak))
    assert less == pytest.approx(0.5 * strong, rel=1e-3)


def test_an_unknown_effect_and_a_second_one_of_a_name_are_refused() -> None:
    with pytest.raises(KeyError, match="effect ghost: not in the table"):
        effects.kind("ghost")
    with pytest.raises(ValueError, match="effect stop: it is in the table already"):
        effects.add(effects.kind("stop"))


def test_nothing_here_imports_the_package_under_test() -> None:
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not [n for n in names if n.split(".")[0] == "undertow"], path


@pytest.mark.parametrize("key", sorted(key for key, k in effects.table().items() if not k.linear))
def test_the_smallest_dose_of_a_search_is_integrated_in_a_moment(key: str) -> None:
    k = effects.kind(key)
    for seed in range(4):
        rng = np.random.default_rng(seed)
        rig = draw_rig(rng, replace(k.needs, friction=True), "few")
        scene = mean_scene(rig, rig.trials[-1])
        shape = k.draw(rng, rig)
        began = time.process_time()
        move(scene, k.applied(shape, max(k.smallest, 1e-5 * k.largest), scene), sample_count(rig, rig.trials[-1]))
        assert time.process_time() - began < 2.0  # a hundred times what most laws take
