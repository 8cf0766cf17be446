"""The study of how a campaign's cost grows still runs, and its committed results say what the docs say."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from benchmarks import campaign_scale
from benchmarks.campaign_scale import GROUP, RESULTS, kept, main, make, measure_parent
from undertow.campaign.config import load
from undertow.recording.gather import gather


def test_a_small_slice_counts_its_trials_and_what_they_cost(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(campaign_scale, "JOBS", 1)
    monkeypatch.setattr(campaign_scale, "WARM", GROUP)
    make(tmp_path / "campaign", 2 * GROUP)
    said: list[str] = []
    assert main(["--here", "light", str(tmp_path), str(2 * GROUP), "0"], said.append) == 0
    found = json.loads(said[0])
    assert (found["trials"], found["groups"], found["failed"]) == (2 * GROUP, 2, 0)
    assert 0.0 < found["cpu_ms_a_trial"] < 1e4
    assert found["trace"][-1][0] == 2 * GROUP
    assert [row[1] for row in found["trace"]] == sorted(row[1] for row in found["trace"])
    assert found["peak_MB"] >= found["peak_MB_before_page"] > 50.0


def test_the_parent_alone_writes_every_trial_it_is_given(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(campaign_scale, "JOBS", 1)
    found = measure_parent(40, tmp_path / "out", at_once=2 * GROUP)
    assert found["parent_trials"] == 40
    assert len((tmp_path / "out" / "mismatch.csv").read_text().splitlines()) == 41
    assert len(json.loads((tmp_path / "out" / "verdict.json").read_text())["groups"]) == 10


@pytest.mark.parametrize(("kind", "dry"), [("light", 0), ("water", 4), ("full", 4)])
def test_every_campaign_that_is_measured_has_its_trials_in_groups(kind: str, dry: int, tmp_path: Path) -> None:
    config = load(make(tmp_path, 8, campaign_scale.CONFIGS[kind]))
    entries = gather(config.catalogue())
    assert len(entries) == 8 + dry
    assert sum(config.is_dry(entry.conditions) for entry in entries) == dry


def test_a_new_result_takes_the_place_of_the_older_one_of_its_size(tmp_path: Path) -> None:
    results = tmp_path / "r.json"
    older = [{"kind": "light", "trials": 100.0, "cpu_s": 1.0}, {"kind": "full", "trials": 100.0}]
    results.write_text(json.dumps(older))
    new = {"kind": "light", "trials": 100.0, "cpu_s": 2.0}
    assert kept(results, new) == [{"kind": "full", "trials": 100.0}, new]


def test_in_the_committed_results_neither_cost_nor_memory_grows_with_the_campaign() -> None:
    light = [one for one in json.loads(RESULTS.read_text()) if one["kind"] == "light"]
    assert [one["trials"] for one in light] == [100.0, 1000.0, 10000.0, 100000.0]
    costs = [one["cpu_ms_a_trial"] for one in light]
    assert max(costs) / min(costs) < 1.2
    assert max(one["peak_MB"] for one in light) - min(one["peak_MB"] for one in light) < 100.0
    for one in light[1:]:  # what the parent needs for its first portion, and a kilobyte a trial at most
        assert one["peak_MB"] - light[0]["peak_MB"] < 30.0 + 1e-3 * one["trials"]
    assert max(one["largest_worker_MB"] for one in light) - light[0]["largest_worker_MB"] < 20.0
