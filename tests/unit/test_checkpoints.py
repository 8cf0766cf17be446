"""Finished groups on disk: what comes back is what went in, and its name changes with everything that decides it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.findings_fixture import MARKUP
from tests.small_campaign import recorded
from tests.written import levels_table, mismatch_table, trials_table, verdict_json
from undertow.campaign.run import checkpoints
from undertow.campaign.run.analysis import GroupTask, analyse
from undertow.comparison.detectable import Detectable
from undertow.comparison.level import Addend
from undertow.comparison.suspect import Addition
from undertow.comparison.tail import Histogram
from undertow.conditioning.condition import condition
from undertow.conditioning.motion import Motion
from undertow.discrepancy.findings import AugmentedRun, Findings, GroupFindings
from undertow.discrepancy.judge import Judged
from undertow.discrepancy.verdict import Described, PhysicalCheck, Rejected, Verdict
from undertow.equation import registry
from undertow.likelihood.fit import Specimen
from undertow.likelihood.scale import choose_anchor
from undertow.quantities import Estimate
from undertow.recording.recording import Recording
from undertow.uncertainty.growth import HALVES, Grown, grown_words


def motion(name: str, x0: float, seed: int = 0, gain: float = 1.0) -> Motion:
    time, x, a = recorded(x0, seed).T
    channels = {"displacement": gain * x, "acceleration": gain * a}
    return condition(Recording(name, time, channels, {"spring": MARKUP}, path=f"{name}.csv", sha256="same"))


@pytest.fixture(scope="module")
def task() -> GroupTask:
    specimen = Specimen(mass_kg=2637.4)
    terms = tuple(registry.find(name) for name in ("stiffness", "viscous_damping", "coulomb_friction"))
    motions = (motion("a", 0.03), motion("b", 0.05))
    anchor = choose_anchor(specimen, None, None, False)
    return GroupTask({"spring": MARKUP}, False, motions, terms, specimen, None, anchor, methods=("sindy",))


@pytest.fixture(scope="module")
def findings(task: GroupTask) -> GroupFindings:
    return analyse(task)


def kept(task: GroupTask, findings: GroupFindings, folder: Path) -> GroupFindings:
    checkpoints.save(findings, folder / "new" / "g.json")
    loaded = checkpoints.load(task, folder / "new" / "g.json")
    assert loaded is not None
    assert [path.name for path in (folder / "new").iterdir()] == ["g.json"]
    return loaded


def test_what_is_shown_of_a_loaded_group_is_what_was_found(
    task: GroupTask, findings: GroupFindings, tmp_path: Path
) -> None:
    def shown(group: GroupFindings) -> list[str]:
        whole = Findings("n", (group,), (), ("sindy",), "translation", {})
        tables = [table(whole).to_csv() for table in (trials_table, levels_table, mismatch_table)]
        return [*tables, json.dumps(verdict_json(whole)), str(group.equation), repr(group.equation_errors)]

    loaded = kept(task, findings, tmp_path)
    assert shown(loaded) == shown(findings)
    for one, other in zip(loaded.trials, findings.trials, strict=True):
        np.testing.assert_array_equal(one.simulated, other.simulated)
        np.testing.assert_array_equal(one.measured, other.measured)
        assert one.as_measured == other.as_measured
    assert loaded.fits == findings.fits or repr(loaded.fits) == repr(findings.fits)  # nan is not equal to itself


def test_a_verdict_with_everything_in_it_comes_back(
    task: GroupTask, findings: GroupFindings, tmp_path: Path
) -> None:
    mass = Estimate(288.0, 20.0, 3.0, "kg", "output_error")
    full = replace(
        findings.verdict, status="explained", verdict=("hidden_resonator",), alternatives=(("relaxation",),),
        parameters={"hidden_resonator": [{"mass_kg": mass}], "added_mass": {"mass_kg": mass}},
        augmented=Described(0.05, 0.06, {"mass_kg": mass}, {"mass_kg": {"mass_kg": 1.0}}, 0.07),
        rejected=(Rejected("cubic_stiffness", "0.38", -3.0),),
        physical_check=PhysicalCheck(9.4, 10.4, True, "cells"), p_value=0.003, upper_bound=0.02,
        detectable=(Detectable("hidden_resonator", "mass_kg", 4.1, "kg", 0.02, 7.9),), not_testable=("rest_offset",),
        null=Histogram(0.5, 9.0, (3, 990, 7), 12.0, 8.0),
    )  # fmt: skip
    loaded = kept(task, replace(findings, verdict=full), tmp_path).verdict
    assert loaded.parameters == full.parameters
    assert (loaded.augmented, loaded.rejected) == (full.augmented, full.rejected)
    for name in ("p_value", "upper_bound", "detectable", "not_testable", "null"):
        assert getattr(loaded, name) == getattr(full, name)
    assert (loaded.alternatives, loaded.physical_check) == (full.alternatives, full.physical_check)


def test_why_errors_are_larger_than_a_fits_own_comes_back(task: GroupTask, findings: GroupFindings, tmp_path: Path):
    found = (Grown("k_N_per_m", 9.25, 3, 0.026, 2.5), Grown("mu", 4.0, 1, 0.046, 1.5, HALVES))
    loaded = kept(task, replace(findings, grown=found), tmp_path)
    assert loaded.grown == found
    assert loaded.remarks == (*findings.notes, *grown_words(found))


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"seed": 1}, "the seed"),
        ({"held_out": ("b",)}, "what is held out"),
        ({"specimen": Specimen(mass_kg=2637.5)}, "the specimen"),
        ({"scatter": {"k": 0.003}}, "the scatter"),
        ({"freedom": 3.0}, "degrees of freedom of the scatter"),
        ({"dry": True}, "whether it is dry"),
        ({"methods": ("sindy", "output_error")}, "the methods"),
        ({"terms": (registry.find("stiffness"),)}, "the equation"),
        ({"terms": (registry.find("drag_exponent", exponent=1.5),)}, "an inner parameter"),
    ],
)
def test_a_groups_name_changes_with(task: GroupTask, changes: dict[str, object], why: str) -> None:
    assert checkpoints.digest(replace(task, **changes)) != checkpoints.digest(task), why  # type: ignore[arg-type]


def test_an_inner_parameter_changes_a_groups_name(task: GroupTask) -> None:
    one, other = (replace(task, terms=(registry.find("drag_exponent", exponent=p),)) for p in (1.5, 1.6))
    assert checkpoints.digest(one) != checkpoints.digest(other)


def test_the_same_file_read_in_another_unit_is_another_group(task: GroupTask) -> None:
    other = replace(task, motions=(motion("a", 0.03, gain=1.0 + 1e-9), task.motions[1]))
    assert checkpoints.digest(other) != checkpoints.digest(task)
    assert checkpoints.digest(replace(task, motions=(motion("a", 0.03), task.motions[1]))) == checkpoints.digest(task)


def test_a_force_in_another_unit_is_another_group_though_it_moves_nothing(task: GroupTask) -> None:
    first = task.motions[0]
    names = []
    for factor in (1.0, 1000.0):
        channels = {**first.recording.channels, "spring_force": factor * first.recording.channels["displacement"]}
        force = replace(first, recording=replace(first.recording, channels=channels))
        names.append(checkpoints.digest(replace(task, motions=(force,))))
    assert names[0] != names[1]


def test_another_version_of_a_package_that_calculates_changes_every_name(
    task: GroupTask, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = checkpoints.digest(task)
    monkeypatch.setattr(checkpoints, "package_versions", lambda: {"numpy": "1.0"})
    assert checkpoints.digest(task) != before


def test_changed_code_changes_every_name(task: GroupTask, monkeypatch: pytest.MonkeyPatch) -> None:
    before = checkpoints.digest(task)
    monkeypatch.setattr(checkpoints, "source_digest", lambda: "other")
    assert checkpoints.digest(task) != before


@pytest.mark.parametrize("text", ["", "{", "[]", "{}", '{"trials": []}', '{"trials": 1}', "null"])
def test_a_damaged_file_is_as_none(task: GroupTask, tmp_path: Path, text: str) -> None:
    (tmp_path / "g.json").write_text(text)
    assert checkpoints.load(task, tmp_path / "g.json") is None
    assert checkpoints.load(task, tmp_path / "nope.json") is None


def test_a_write_that_fails_leaves_the_older_file(task: GroupTask, findings: GroupFindings, tmp_path: Path) -> None:
    path = tmp_path / "g.json"
    checkpoints.save(findings, path)
    before = path.read_bytes()
    with pytest.raises(TypeError, match="not JSON serializable"):
        checkpoints.save(replace(findings, notes=(object(),)), path)  # type: ignore[arg-type]
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["g.json"]


def test_verdicts_of_groups_judged_together_come_back_in_their_order(task: GroupTask, tmp_path: Path) -> None:
    other = replace(task, key={"spring": "other"})
    explained = Verdict(
        task.key, ("a",), status="explained", verdict=("linear_damping",), confidence=0.999,
        parameters={"linear_damping": {"c_Ns_per_m": Estimate(480.0, 20.0, unit="N s/m")}},
    )  # fmt: skip
    plain = Verdict(other.key, ("a", "b"), status="nothing_missing")
    run = AugmentedRun(0.02, np.array([1.0, 0.5]), 0.07)
    by_spring = (("long", 80.0, 2.0), ("short", 70.0, 3.0))
    friction = Addition("force_N", "N", "fc", 0.0, 1.0, scope="spring", by_spring=by_spring, moves=("fc", "fs"))
    sine = Addition("stiffness_N_per_m", "N/m", "k", 0.0, 1.0, also=(("k3", -1.0 / 6.0),))
    clock = Addend("1.clock", (), frees="clock", centres=(0.1, 0.2), degree=2)
    addends = (Addend("0.friction", (friction, sine)), clock)
    values = {"0.friction.force_N": (80.0, 2.0)}
    judged = Judged((explained, plain), ("long", "short"), addends, values, {"a": run}, {"relaxation": 2.0})
    checkpoints.save_verdicts(judged, tmp_path / "v.json")
    loaded = checkpoints.load_verdicts((task, other), ("long", "short"), tmp_path / "v.json")
    assert loaded is not None
    first, second = loaded.verdicts
    assert (loaded.runs["a"].nrmse, loaded.runs["a"].as_measured) == (0.02, 0.07)
    assert loaded.runs["a"].residual.tolist() == [1.0, 0.5]
    assert repr((loaded.labels, loaded.addends, loaded.values)) == repr((judged.labels, judged.addends, judged.values))
    assert loaded.evidence == {"relaxation": 2.0}
    assert first.parameters == explained.parameters
    assert (first.verdict, second.status, second.group) == (("linear_damping",), "nothing_missing", other.key)
    fewer = checkpoints.load_verdicts((task,), ("long",), tmp_path / "v.json")
    assert fewer is None  # another number of groups is another level
    assert checkpoints.load_verdicts((task,), ("long",), tmp_path / "none.json") is None


def test_what_stands_from_dry_trials_changes_a_levels_name(task: GroupTask) -> None:
    assert checkpoints.level_digest((task,), "nothing") != checkpoints.level_digest((task,), "cubic_stiffness")
    assert checkpoints.level_digest((task,), "nothing") == checkpoints.level_digest((task,), "nothing")
