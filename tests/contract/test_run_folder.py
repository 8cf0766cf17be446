"""The run folder as the contract has it, resumed and interrupted runs, and texts from files that must not act."""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest

from tests.command_line import Said, undertow
from tests.small_campaign import BODY, Campaign, make_campaign, recorded, write_table
from undertow.campaign.config import load
from undertow.campaign.run import course as campaign_run
from undertow.campaign.run.claim import claimed
from undertow.cli import main

Capture = pytest.CaptureFixture[str]

TABLES = ("trials.csv", "levels.csv", "mismatch.csv")
FILES = {"config.yaml", "manifest.json", "verdict.json", "equations.json", "report.html", "figures", "stages", *TABLES}
MARKUP = "<script>alert(1)"
SPRINGS = ("long", "stiff")
INTERRUPTED = 130


@pytest.fixture(scope="module")
def campaign(tmp_path_factory: pytest.TempPathFactory) -> Campaign:
    """Two springs, two trials each; one file's name and one spring's name hold markup, the campaign's name a path."""
    made = make_campaign(tmp_path_factory.mktemp("campaign"), [0.03, 0.05], springs=("long", f"stiff{MARKUP}"))
    (made.folder / "r01.csv").rename(made.folder / f"{MARKUP}--$_.csv")
    index = made.folder / "campaign.csv"
    index.write_text(index.read_text().replace("r01.csv", f"{MARKUP}--$_.csv"))
    made.edit("name: small", 'name: "../../<b>small"')
    return made


@pytest.fixture(scope="module")
def folder(campaign: Campaign) -> Path:
    """Its run folder, made by the command with a key set on the command line."""
    words = ["run", campaign.config, "--out", campaign.folder / "run", "--jobs", "1", "--set", "seed=3"]
    done = subprocess.run([sys.executable, "-m", "undertow", *map(str, words)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.rstrip().endswith(f"report: {campaign.folder / 'run' / 'report.html'}")
    assert "identification: 2 of 2" in done.stderr
    return campaign.folder / "run"


def run(capsys: Capture, campaign: Campaign, folder: Path, *words: str) -> Said:
    return undertow(capsys, "run", campaign.config, "--out", folder, "--jobs", 1, *words)


def tables(folder: Path) -> dict[str, bytes]:
    return {name: (folder / name).read_bytes() for name in TABLES}


def files_of(folder: Path) -> dict[str, bytes]:
    """A run's files, figures among them, without its parts."""
    found = (path for path in folder.rglob("*") if path.is_file() and path.parent.name != "stages")
    return {str(path.relative_to(folder)): path.read_bytes() for path in found}


def test_every_file_of_the_contract_is_there_and_nothing_half_written(folder: Path) -> None:
    assert {path.name for path in folder.iterdir()} == FILES
    assert not list(folder.rglob("*.part"))
    assert list((folder / "figures").glob("*.svg"))


def test_the_resolved_config_is_the_campaigns_and_resolves_to_itself(folder: Path, campaign: Campaign) -> None:
    again = load(folder / "config.yaml").resolved()
    assert again == load(campaign.config, ["seed=3"]).resolved()
    assert again["seed"] == 3
    assert again["equation"]["coordinate"] == "translation"


def test_a_run_folders_config_makes_the_same_run(folder: Path, tmp_path: Path, capsys: Capture) -> None:
    assert undertow(capsys, "run", folder / "config.yaml", "--out", tmp_path / "again", "--jobs", 1).code == 0
    assert tables(tmp_path / "again") == tables(folder)


def test_the_manifest_names_inputs_versions_seed_and_times(folder: Path, campaign: Campaign) -> None:
    said = json.loads((folder / "manifest.json").read_text())
    assert (said["seed"], said["overrides"], said["config"]) == (3, ["seed=3"], str(campaign.config))
    assert {"read and condition", "dry trials", "identification", "report"} <= set(said["wall_time_s"])
    assert said["packages"]["numpy"]
    assert re.fullmatch(r"([0-9a-f]{40}\+?)?", said["git_revision"])
    assert said["inputs"][0]["trial"] == "index"
    assert len(said["inputs"]) == 5
    for one in said["inputs"]:
        assert one["sha256"] == hashlib.sha256(Path(one["path"]).read_bytes()).hexdigest()


def test_the_tables_have_the_contracts_columns(folder: Path) -> None:
    trials, levels, mismatch = (pd.read_csv(folder / name) for name in TABLES)
    scores = {"nrmse", "sensor_floor_nrmse", "repeatability_nrmse", "outcome"}
    stiffness = {"k_N_per_m", "k_N_per_m_stderr"}
    assert {"file", "spring", "method"} | stiffness | scores <= set(trials.columns)
    assert {"spring", "method", "equation", "equation_latex"} | scores <= set(levels.columns)
    shares = {"missing", "share_early", "share_middle", "share_late", "line_frequency_hz", "line_share"}
    assert {"amplitude_exponent", "static_share", "memory_share", "clock_share", "nrmse"} | shares <= set(mismatch)
    assert len(mismatch) == 4
    truth = BODY.k_N_per_m  # kilograms come from the mass that the config states
    # 1 % is over ten standard errors at this noise
    found = levels[levels.method == "baseline"].k_N_per_m
    assert found.between(0.99 * truth, 1.01 * truth).all()


def test_the_verdict_has_every_key_and_no_nan(folder: Path) -> None:
    def refuse(word: str) -> None:
        raise AssertionError(f"verdict.json holds {word}")

    said = json.loads((folder / "verdict.json").read_text(), parse_constant=refuse)
    assert said["contract"] == 2
    assert set(said["across_groups"]) == {"verdict", "sentence"}
    keys = {
        "group", "trials", "held_out", "status", "verdict", "alternatives", "confidence", "origin", "parameters",
        "baseline", "augmented", "sensor_floor_nrmse", "repeatability_nrmse", "rejected", "physical_check", "next_test",
        "transfer", "sentence", "because", "posterior", "decision",
        "p_value", "upper_bound", "detectable", "not_testable",
    }  # fmt: skip
    for group in said["groups"]:
        assert set(group) == keys
        assert group["status"] == "cannot_tell"  # nothing was looked for
        assert "discrepancy.suspects" in group["because"]
        assert "search_ended" in [gate["gate"] for gate in group["decision"] if not gate["passed"]]
        assert all(set(g) == {"gate", "statistic", "value", "limit", "passed", "because"} for g in group["decision"])


def test_the_report_is_one_page_that_loads_nothing_and_shows_texts_from_files_as_text(folder: Path) -> None:
    whole = (folder / "report.html").read_text()
    assert "<script>alert(1)" not in whole
    page = re.sub(r"<script\b.*?</script>", "", whole, flags=re.DOTALL | re.IGNORECASE)  # the page's own
    assert "&lt;script&gt;alert(1)" in page
    assert "&lt;b&gt;small" in page
    assert not re.search(r"<(link|iframe|object|embed|base)\b", page, re.IGNORECASE)
    assert not re.search(r"(src|href)\s*=\s*[\"'](?!#|data:)", page, re.IGNORECASE)
    assert not re.search(r"url\((?!['\"]?#|['\"]?data:)|@import", page, re.IGNORECASE)
    assert not re.search(r"<[^>]+\son\w+\s*=", page)


def test_figures_have_plain_names_and_run_nothing(folder: Path) -> None:
    for path in (folder / "figures").iterdir():
        assert re.fullmatch(r"[a-z0-9-]+\.svg", path.name)
        assert "<script" not in path.read_text().lower()


def test_without_out_the_folder_is_called_after_the_campaign_and_stays_below_runs(
    capsys: Capture, campaign: Campaign, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    said = undertow(capsys, "run", campaign.config, "--jobs", 1)
    assert said.code == 0
    assert [path.name for path in (tmp_path / "runs").iterdir()] == ["_______b_small"]
    assert [path.name for path in tmp_path.iterdir()] == ["runs"]


# ---------------------------------------------------------------- resuming
class Counted:
    """Counts how many groups are analysed, and stops at one as Ctrl-C would."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, interrupt_at: int = -1) -> None:
        self.count, self.interrupt_at, self.analyse = 0, interrupt_at, campaign_run.analyse
        monkeypatch.setattr(campaign_run, "analyse", self)

    def __call__(self, task: campaign_run.GroupTask) -> object:
        self.count += 1
        if self.count == self.interrupt_at:
            raise KeyboardInterrupt
        return self.analyse(task)


@pytest.fixture
def small(tmp_path: Path) -> Campaign:
    return make_campaign(tmp_path / "small", [0.03, 0.05], springs=SPRINGS)


@pytest.fixture(scope="module")
def bare(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A finished run folder without a page."""
    folder = tmp_path_factory.mktemp("bare")
    small = make_campaign(folder / "small", [0.03, 0.05], springs=SPRINGS)
    with pytest.raises(SystemExit, match=r"^0?$"):
        main(["run", str(small.config), "--out", str(folder / "run"), "--jobs", "1", "--no-page"])
    return folder / "run"


def test_resume_takes_finished_groups_and_gives_identical_tables(
    capsys: Capture, small: Campaign, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert run(capsys, small, tmp_path / "run", "--no-page").code == 0
    before, verdict = tables(tmp_path / "run"), (tmp_path / "run" / "verdict.json").read_bytes()
    counted = Counted(monkeypatch)
    assert run(capsys, small, tmp_path / "run", "--no-page", "--resume").code == 0
    assert counted.count == 0
    assert tables(tmp_path / "run") == before
    assert (tmp_path / "run" / "verdict.json").read_bytes() == verdict
    assert run(capsys, small, tmp_path / "run", "--no-page").code == 0
    assert counted.count == 2, "without --resume every group is analysed again"


def test_an_interrupted_run_keeps_what_is_finished_and_goes_on_from_there(
    capsys: Capture, small: Campaign, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patched:
        Counted(patched, interrupt_at=2)
        said = run(capsys, small, tmp_path / "run")
    assert said.code == INTERRUPTED
    assert said.err.splitlines()[-1] == (
        "undertow: interrupted; finished groups are kept in the run folder, the same command with --resume goes on "
        "from there"
    )
    assert len(list((tmp_path / "run" / "stages").iterdir())) == 1
    assert not (tmp_path / "run" / "report.html").exists()
    counted = Counted(monkeypatch)
    assert run(capsys, small, tmp_path / "run", "--resume").code == 0
    assert counted.count == 1
    assert (tmp_path / "run" / "report.html").exists()


@pytest.mark.parametrize(
    ("change", "again"),
    [("seed", 2), ("offset", 2), ("mass", 2), ("recording", 1), ("nothing", 0)],
)
def test_a_stale_stage_is_not_taken(
    small: Campaign, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, change: str, again: int
) -> None:
    stages = tmp_path / "stages"
    campaign_run.run(load(small.config), jobs=1, stages_folder=stages)
    if change == "seed":
        small.edit("identify: [sindy]", "identify: [sindy]\nseed: 1")
    if change == "offset":  # the same file and the same window, read in another way
        small.edit("column: x, unit: m}", "column: x, unit: m, offset: 0.001}")
    if change == "mass":
        small.edit("2637.4", "2600")
    if change == "recording":
        write_table(small.folder / "r00.csv", recorded(0.03, seed=99))
    counted = Counted(monkeypatch)
    campaign_run.run(load(small.config), jobs=1, stages_folder=stages, resume=True)
    assert counted.count == again


def test_a_damaged_stage_is_made_again(
    small: Campaign, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    stages = tmp_path / "stages"
    campaign_run.run(load(small.config), jobs=1, stages_folder=stages)
    first, second, *verdicts = sorted(stages.iterdir(), key=lambda p: (p.name.startswith("verdict"), p.name))
    first.write_text(first.read_text()[:100])
    whole = second.read_text()
    at = whole.rindex("0.0") + 2  # one digit of one number
    second.write_text(f"{whole[:at]}1{whole[at + 1 :]}")
    for damaged in verdicts:
        damaged.write_text("[]")
    counted = Counted(monkeypatch)
    campaign_run.run(load(small.config), jobs=1, stages_folder=stages, resume=True)
    assert counted.count == 2
    assert caplog.text.count("it is made again") == 2 + len(verdicts)


def test_an_older_run_stays_whole_until_the_new_one_is_finished(
    capsys: Capture, small: Campaign, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert run(capsys, small, tmp_path / "run").code == 0
    before = files_of(tmp_path / "run")
    Counted(monkeypatch, interrupt_at=1)
    assert run(capsys, small, tmp_path / "run", "--set", "seed=9").code == INTERRUPTED
    assert files_of(tmp_path / "run") == before


def test_without_a_page_tables_are_the_same_and_an_older_page_shows_no_other_numbers(
    capsys: Capture, small: Campaign, tmp_path: Path
) -> None:
    whole, bare = tmp_path / "whole", tmp_path / "bare"
    run(capsys, small, whole)
    for _ in range(2):
        run(capsys, small, bare)
        said = run(capsys, small, bare, "--no-page")
    assert said.code == 0
    assert said.out.rstrip().endswith(f"report: {bare / 'verdict.json'}")
    assert tables(bare) == tables(whole)
    assert {p.name for p in bare.iterdir()} == FILES - {"report.html", "figures"} | {"earlier_run"}
    assert (bare / "earlier_run" / "report.html").is_file()
    assert any((bare / "earlier_run" / "figures").iterdir())


def test_a_run_beside_another_in_one_folder_is_refused(capsys: Capture, small: Campaign, tmp_path: Path) -> None:
    (tmp_path / "run").mkdir()
    with claimed(tmp_path / "run"):
        said = run(capsys, small, tmp_path / "run")
    assert said.code == 1
    assert re.search(r"^undertow: run folder .*run is in use by another run .*choose another with --out$", said.err)
    assert list((tmp_path / "run").iterdir()) == []


@pytest.mark.skipif(os.name != "posix", reason="limits the size of files")
@pytest.mark.parametrize("largest", [100, 30_000])
def test_a_disk_that_is_full_ends_in_one_sentence_and_leaves_an_older_run_whole(
    small: Campaign, tmp_path: Path, capsys: Capture, largest: int
) -> None:
    assert run(capsys, small, tmp_path / "run").code == 0
    before = files_of(tmp_path / "run")
    limited = f"import resource; resource.setrlimit(resource.RLIMIT_FSIZE, ({largest}, {largest})); "
    words = ["run", str(small.config), "--out", str(tmp_path / "run"), "--jobs", "1", "--set", "seed=9"]
    done = subprocess.run(
        [sys.executable, "-c", f"{limited}from undertow.cli import main; main({words!r})"],
        capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 1
    assert re.fullmatch(
        r"undertow: run folder .*run cannot be written: File too large .*; choose another with --out",
        done.stderr.splitlines()[-1],
    )
    assert "Traceback" not in done.stderr
    assert files_of(tmp_path / "run") == before
    assert not list((tmp_path / "run").rglob("*.part"))


def test_a_runs_own_tables_are_no_trials_of_a_glob(capsys: Capture, tmp_path: Path) -> None:
    campaign = make_campaign(tmp_path / "c", [0.03, 0.05])
    for name in ("campaign.csv", "trials.csv"):
        (campaign.folder / name).unlink(missing_ok=True)
    campaign.edit("index: campaign.csv", 'files: "*.csv"')
    campaign.edit("group_by: [spring]", "group_by: []")
    config = campaign.config.rename(campaign.folder / "flume.yaml")
    for _ in range(2):
        said = undertow(capsys, "run", config, "--out", campaign.folder, "--jobs", 1, "--no-page")
        assert said.code == 0, said.err
        trials = pd.read_csv(campaign.folder / "trials.csv")
        assert sorted(set(trials["trial"])) == ["r00", "r01"]
    (tmp_path / "c" / "undertow.yaml").unlink(missing_ok=True)
    assert undertow(capsys, "init", campaign.folder).code == 0
    proposed = (tmp_path / "c" / "undertow.yaml").read_text()
    assert "levels" not in proposed


def test_a_run_that_is_interrupted_before_its_first_group_says_that_nothing_is_kept(
    capsys: Capture, small: Campaign, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patched:
        Counted(patched, interrupt_at=1)
        said = run(capsys, small, tmp_path / "run")
    assert said.code == INTERRUPTED
    assert said.err.splitlines()[-1] == (
        "undertow: interrupted; no group was finished, the same command begins anew"
    )
    with monkeypatch.context() as patched:
        patched.setattr("undertow.campaign.run.folder.refuse_foreign_files", interrupted)
        said = run(capsys, small, tmp_path / "other")
    assert said.err.splitlines()[-1] == "undertow: interrupted; nothing was written, the same command begins anew"
    assert not (tmp_path / "other").exists()


def interrupted(*_: object) -> None:
    """Ctrl-C before anything is written."""
    raise KeyboardInterrupt


def test_a_config_is_never_replaced_by_its_resolved_form(capsys: Capture, small: Campaign) -> None:
    before = small.config.read_text()
    said = undertow(capsys, "run", small.config, "--out", small.folder)
    assert said.code == 1
    assert re.search(r"run folder .* holds the config itself, .*choose another folder with --out", said.err)
    assert small.config.read_text() == before


@pytest.mark.skipif(os.name != "posix", reason="sends SIGINT to a process group")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_ctrl_c_in_the_middle_ends_every_process_with_one_sentence(tmp_path: Path, number: signal.Signals) -> None:
    campaign = make_campaign(tmp_path / "c", [0.03, 0.04, 0.05], springs=[f"s{i}" for i in range(8)])
    words = ["run", str(campaign.config), "--out", str(tmp_path / "run"), "--jobs", "2"]
    with subprocess.Popen(
        [sys.executable, "-m", "undertow", *words], stderr=subprocess.PIPE, text=True, start_new_session=True,
        preexec_fn=_listen,
    ) as process:  # fmt: skip
        assert process.stderr is not None
        for line in process.stderr:
            if line.startswith("identification: 0"):
                break
        until = time.monotonic() + 180.0
        while not list((tmp_path / "run").glob("stages/*.json")) and time.monotonic() < until:
            time.sleep(0.01)
        (os.killpg if number == signal.SIGINT else os.kill)(process.pid, number)
        rest = process.stderr.read()
    assert process.returncode == INTERRUPTED
    *before, last = rest.splitlines()
    assert last.startswith("undertow: interrupted; finished groups are kept"), rest
    assert all(line.startswith("identification: ") for line in before), rest
    assert not _alive(process.pid)
    kept = list((tmp_path / "run" / "stages").glob("*.json"))
    assert 1 <= len(kept) < 8
    assert all(json.loads(path.read_text()) for path in kept)


def _listen() -> None:
    """Ctrl-C is heard also where the tests themselves run in the background, where a shell has it ignored."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def _alive(session: int) -> list[str]:
    """Processes of a session that still run, after 10 s of grace; those that ended and are not noticed yet apart."""
    listed: list[str] = []
    for _ in range(100):
        found = subprocess.run(["ps", "-o", "stat=,args=", "-s", str(session)], capture_output=True, text=True)
        listed = [line for line in found.stdout.splitlines() if not line.startswith("Z")]
        if not listed:
            break
        time.sleep(0.1)
    return listed


@pytest.mark.parametrize("wrappers", [1, 3])
def test_an_interrupt_that_compiled_code_wraps_is_an_interrupt(
    capsys: Capture, small: Campaign, monkeypatch: pytest.MonkeyPatch, wrappers: int
) -> None:
    """A compiled function that gives several arrays wraps the interrupt once for each of them."""
    def wrapped(*words: object, **named: object) -> None:
        raised: BaseException = KeyboardInterrupt()
        for _ in range(wrappers):
            error = SystemError("a dispatcher returned a result with an exception set")
            error.__cause__ = raised
            raised = error
        raise raised

    monkeypatch.setattr("undertow.campaign.run.folder.run_to_folder", wrapped)
    said = undertow(capsys, "run", small.config, "--out", small.folder.parent / "elsewhere")
    assert (said.code, said.err.startswith("undertow: interrupted")) == (INTERRUPTED, True)


def test_a_system_error_of_another_kind_is_no_interrupt(
    capsys: Capture, small: Campaign, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*words: object, **named: object) -> None:
        raise SystemError("bad argument to internal function") from TypeError("no array")

    monkeypatch.setattr("undertow.campaign.run.folder.run_to_folder", broken)
    with pytest.raises(SystemError, match="bad argument"):
        undertow(capsys, "run", small.config, "--out", small.folder.parent / "elsewhere")


def test_numbers_that_run_out_of_bounds_between_the_groups_end_a_run_in_a_sentence(
    capsys: Capture, small: Campaign, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def beyond(*said: object) -> object:
        raise OverflowError(34, "Numerical result out of range")

    monkeypatch.setattr("undertow.campaign.run.course.structures_of", beyond)
    said = run(capsys, small, tmp_path / "run")
    assert said.code == 1
    assert re.search(r"undertow: numbers ran out of bounds \(.*out of range.*\); look at the recordings", said.err)


def test_trials_are_judged_in_the_order_of_the_index(
    capsys: Capture, small: Campaign, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    index = small.folder / "campaign.csv"
    head, *rows = index.read_text().split()
    index.write_text("\n".join([head, *reversed(rows)]) + "\n")
    orders = []

    def seen(groups: object, order: list[str]) -> str:
        orders.append(order)
        return ""

    monkeypatch.setattr("undertow.campaign.run.plausible.no_scatter", seen)
    assert run(capsys, small, tmp_path / "run").code == 0
    assert orders == [[row.split(",")[0].removesuffix(".csv") for row in reversed(rows)]]


@pytest.mark.parametrize("spoilt", [None, "x", [], {}, -1, [[]], {"a": 1}])
def test_a_verdict_that_somebody_changed_ends_compare_and_explain_in_a_sentence_or_is_shown(
    capsys: Capture, bare: Path, tmp_path: Path, spoilt: object
) -> None:
    shutil.copytree(bare, tmp_path / "run")
    path = tmp_path / "run" / "verdict.json"
    whole = json.loads(path.read_text())
    keys = [("groups",), ("across_groups",), ("contract",), *(("groups", 0, key) for key in whole["groups"][0])]
    refused = 0
    for *above, last in keys:
        changed = json.loads(json.dumps(whole))
        place = changed
        for key in above:
            place = place[key]
        place[last] = spoilt
        path.write_text(json.dumps(changed))
        for words in (["explain", tmp_path / "run"], ["compare", tmp_path / "run", tmp_path / "run"]):
            said = undertow(capsys, *words)
            assert said.code in (0, 1), (last, words[0], said.err)
            refused += said.code
    assert refused > 0


@pytest.mark.parametrize("spoilt", [None, "x", [], {}, -1, [[]], {"a": 1}])
def test_equations_that_somebody_changed_end_predict_in_a_sentence_or_are_used(
    capsys: Capture, bare: Path, tmp_path: Path, spoilt: object
) -> None:
    shutil.copytree(bare, tmp_path / "run")
    path = tmp_path / "run" / "equations.json"
    whole = json.loads(path.read_text())
    group = whole["groups"][0]
    keys = [("groups",), ("contract",), *(("groups", 0, key) for key in group)]
    keys += [("groups", 0, "versions", "baseline", key) for key in group["versions"]["baseline"]]
    refused = 0
    for *above, last in keys:
        changed = json.loads(json.dumps(whole))
        place = changed
        for key in above:
            place = place[key]
        place[last] = spoilt
        path.write_text(json.dumps(changed))
        said = undertow(capsys, "predict", tmp_path / "run", "--x0", "0.04", "--duration", "2", "--rate", "50",
                        "--group", "spring=long")  # fmt: skip
        assert said.code in (0, 1, 2), (last, said.err)
        refused += said.code > 0
    assert refused > 0
    path.write_text("{")
    said = undertow(capsys, "predict", tmp_path / "run", "--x0", "0.04", "--duration", "2", "--rate", "50")
    assert said.code == 1
    assert "equations.json is not as a run writes it" in said.err
