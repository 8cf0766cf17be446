"""The runner with a program that is not the package: rows, exit codes, time limit, what was run is not run again."""

import json
from pathlib import Path

import pytest

from experiments.blind_challenge import run_cases

ROOT = Path(__file__).resolve().parents[2]
PROGRAM = """
import json, pathlib, sys, time
config, out = pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[4])
assert sys.argv[1] == "run" and sys.argv[5:] == ["--jobs", "1", "--no-page"]
what = config.read_text().strip()
print("seen: " + what + " beside " + ",".join(sorted(p.name for p in config.parent.iterdir())))
while what == "slow":
    pass
if what == "waits":
    time.sleep(600)
if what == "broken":
    raise RuntimeError("broken as asked")
if what == "refused":
    print("config: refused; mend it", file=sys.stderr)
    sys.exit(2)
if what == "text":
    sys.exit("a sentence")
out.mkdir(parents=True)
(out / "verdict.json").write_text(json.dumps({"contract": 2, "groups": [{"group": {}, "status": "nothing_missing"}]}))
"""


@pytest.fixture
def laboratories(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Five laboratories and a program called `fake_program`."""
    (tmp_path / "fake_program").mkdir()
    (tmp_path / "fake_program" / "__init__.py").write_text("")
    (tmp_path / "fake_program" / "__main__.py").write_text(PROGRAM)
    monkeypatch.syspath_prepend(str(tmp_path))
    monkeypatch.setattr(run_cases, "LIMIT", 2.0)
    monkeypatch.setattr(run_cases, "WARM", 20.0)
    folder = tmp_path / "laboratory"
    for name, what in (("c0", "fine"), ("c1", "slow"), ("c2", "broken"), ("c3", "refused"), ("c4", "text")):
        (folder / name).mkdir(parents=True)
        (folder / name / "config.yaml").write_text(what)
    (folder / "challenge.json").write_text(json.dumps({"seed": 5, "cases": 5, "digest": "d"}))
    return folder


def test_every_laboratory_has_one_row_with_exit_code_seconds_revision_and_verdict(
    laboratories: Path, tmp_path: Path
) -> None:
    rows = tmp_path / "rows.jsonl"
    assert run_cases.run(laboratories, rows, ROOT, module="fake_program") == 5
    found = {row["case"]: row for row in run_cases.read_rows(rows)}
    assert {name: row["exit"] for name, row in found.items()} == {"c0": 0, "c1": None, "c2": 1, "c3": 2, "c4": 1}
    assert [name for name, row in found.items() if row["stopped"]] == ["c1"]
    assert 2.0 <= found["c1"]["seconds"] < 5.0
    assert found["c0"]["verdict"]["groups"][0]["status"] == "nothing_missing"
    assert found["c2"]["verdict"] is None
    assert "broken as asked" in found["c2"]["messages"]
    assert "refused; mend it" in found["c3"]["messages"]
    assert "seen: fine beside config.yaml" in found["c0"]["messages"]
    assert found["c0"]["first_of_worker"] is True
    assert found["c3"]["first_of_worker"] is False
    assert all(row["seed"] == 5 and row["digest"] == "d" and len(row["revision"]) >= 40 for row in found.values())
    assert not list(tmp_path.glob("rows_runs"))
    assert run_cases.run(laboratories, rows, ROOT, module="fake_program") == 0


def test_only_the_cases_asked_for_are_run_in_two_processes(laboratories: Path, tmp_path: Path) -> None:
    rows = tmp_path / "rows.jsonl"
    assert run_cases.run(laboratories, rows, ROOT, jobs=2, only=["c0", "c3"], module="fake_program") == 2
    assert {row["case"] for row in run_cases.read_rows(rows)} == {"c0", "c3"}


def test_a_campaign_that_computes_nothing_is_stopped_too(
    laboratories: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(run_cases, "WARM", 2.0)
    monkeypatch.setattr(run_cases, "WAIT", 3.0)
    (laboratories / "c0" / "config.yaml").write_text("waits")
    rows = tmp_path / "rows.jsonl"
    assert run_cases.run(laboratories, rows, ROOT, only=["c0"], module="fake_program") == 1
    (row,) = run_cases.read_rows(rows)
    assert row["stopped"]
    assert row["seconds"] < 2.0


def test_no_file_has_no_rows(tmp_path: Path) -> None:
    assert run_cases.read_rows(tmp_path / "none.jsonl") == []
