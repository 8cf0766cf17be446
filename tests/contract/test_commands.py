"""Every command: what it prints, where, with which exit code, and that the terminal answers at once."""

from __future__ import annotations

import importlib
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.command_line import undertow
from tests.record_server import CONTENT, MD5, SHA256, serving
from tests.small_campaign import make_campaign, recorded, write_table
from undertow import __version__
from undertow.campaign.config import load
from undertow.campaign.fetch import records as fetch
from undertow.comparison.driven_suspects import SUSPECTS_IN_TIME
from undertow.comparison.suspects import all_suspects
from undertow.discrepancy.judge import NOT_TESTABLE
from undertow.discrepancy.naming import FOUND_ELSEWHERE
from undertow.equation import registry
from undertow.errors import ConfigError, UndertowError
from undertow.recording.catalogue import read_trial
from undertow.recording.gather import gather
from undertow.report.verdict_file import must_be_there

Capture = pytest.CaptureFixture[str]
COMMANDS = ("run", "init", "inspect", "compare", "fetch", "terms")
HEAVY = ("numpy", "pandas", "scipy", "matplotlib", "pysindy", "numba", "sympy", "pint", "joblib", "jinja2", "pooch")


# ---------------------------------------------------------------- help, version, doors
@pytest.mark.parametrize("words", ["--help", "--version", "run --help"])
def test_help_imports_nothing_heavy(words: str) -> None:
    code = (
        "import sys\nfrom undertow.cli import main\n"
        f"try:\n    main({words.split()})\nexcept SystemExit as end:\n    assert not end.code\n"
        f"print([name for name in {HEAVY} if name in sys.modules], file=sys.stderr)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stderr.strip() == "[]"


def test_a_look_at_one_file_imports_neither_the_search_nor_what_it_calculates_with() -> None:
    heavy = ("undertow.comparison.null_test", "undertow.methods.baseline", "scipy.ndimage", "scipy.stats", "matplotlib")
    code = f"import sys, undertow.campaign.inspection; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(
    "module", ["undertow.campaign.config", "undertow.front.terminal.changes", "undertow.report.explain"]
)
def test_a_config_that_is_wrong_and_runs_that_are_read_wait_for_no_search(module: str) -> None:
    heavy = ("undertow.comparison.joint", "undertow.equation.kernel", "scipy.stats", "pysindy", "matplotlib")
    code = f"import sys, {module}; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_config_that_is_not_there_is_said_before_the_search_is_imported() -> None:
    code = (
        "import sys\nfrom undertow.cli import main\ntry:\n    main(['run', 'nope.yaml'])\nexcept SystemExit as end:\n"
        "    print(end.code, 'undertow.comparison.joint' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "2 False"
    assert "config nope.yaml cannot be read" in done.stderr


def test_importing_undertow_imports_no_matplotlib() -> None:
    code = "import sys, undertow.campaign.run.course; print('matplotlib' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_help_names_every_command(capsys: Capture) -> None:
    for words in (["--help"], []):
        said = undertow(capsys, *words)
        assert all(re.search(rf"^  {name}\b", said.out + said.err, re.MULTILINE) for name in COMMANDS)
    assert undertow(capsys, "--help").code == 0


def test_the_version_is_the_packages(capsys: Capture) -> None:
    assert undertow(capsys, "--version").out == f"undertow {__version__}\n"


@pytest.mark.parametrize("words", [["frobnicate"], ["run"], ["terms", "--loud"], ["fetch"]])
def test_wrong_usage_ends_with_2(capsys: Capture, words: list[str]) -> None:
    said = undertow(capsys, *words)
    assert said.code == 2
    assert "Usage: undertow" in said.err
    assert said.out == ""


def test_the_package_is_a_command_too() -> None:
    done = subprocess.run([sys.executable, "-m", "undertow", "terms", "stiffness"], capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("stiffness\n  law        k x\n")


def test_a_reader_who_leaves_early_is_no_error() -> None:
    words = [sys.executable, "-m", "undertow", "terms"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert "Traceback" not in process.stderr.read()


# ---------------------------------------------------------------- compiling
@pytest.mark.slow
def test_compiling_is_announced_once_and_only_where_it_happens(tmp_path: Path) -> None:
    write_table(tmp_path / "r.csv", recorded(0.04, 0), "t[s],x[m],a[m/s^2]")
    words = [sys.executable, "-m", "undertow", "inspect", str(tmp_path / "r.csv")]
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    said = [subprocess.run(words, capture_output=True, text=True, env=environment).stderr for _ in range(2)]
    assert said == ["compiling the integrator once, up to half a minute\n", ""]


@pytest.mark.slow
def test_a_first_start_gives_the_bytes_of_every_later_one(tmp_path: Path) -> None:
    campaign = make_campaign(tmp_path / "c", [0.03, 0.05])
    campaign.edit("identify: [sindy]", "identify: [output_error]")
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    for name in ("first", "later"):
        words = ["run", str(campaign.config), "--out", str(tmp_path / name), "--jobs", "1"]
        subprocess.run([sys.executable, "-m", "undertow", *words], env=environment, check=True, capture_output=True)
    first, later = (
        {str(path.relative_to(tmp_path / name)): path.read_bytes() for path in (tmp_path / name).rglob("*.[jc]s*")}
        for name in ("first", "later")
    )
    assert {name for name, content in first.items() if content != later[name]} == {"manifest.json"}


def test_a_result_that_cannot_be_kept_is_said() -> None:
    from undertow.compiling import compiled

    module: dict[str, Any] = {}
    exec("def double(x):\n    return 2.0 * x\n", module)  # a function without a file: numba has no place beside it
    with pytest.raises(UndertowError, match=r"cannot be kept \(cannot cache .*double.*\); set NUMBA_CACHE_DIR to"):
        compiled("f8(f8)")(module["double"])


def test_a_command_whose_compiled_functions_cannot_be_kept_ends_with_a_sentence(
    capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    from undertow import compiling

    def no_place(*_: object, **__: object) -> None:
        raise RuntimeError("cannot cache function '_smooth': no locator available for file 'x'")

    monkeypatch.setattr(compiling, "njit", no_place)
    for module in ("campaign.inspection", "conditioning.condition", "conditioning.fusion"):
        monkeypatch.delitem(sys.modules, f"undertow.{module}", raising=False)
    said = undertow(capsys, "inspect", "x.csv")
    assert said.code == 1
    assert re.search(r"compiled functions cannot be kept \(cannot cache .*\); set NUMBA_CACHE_DIR", said.err)


def test_what_is_compiled_is_said_once_in_a_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    from undertow import compiling

    monkeypatch.setattr(compiling, "_PROCESSES", compiling._Processes())
    (tmp_path / "halves.py").write_text("def half(x):\n    return 0.5 * x\ndef third(x):\n    return x / 3.0\n")
    monkeypatch.syspath_prepend(tmp_path)
    halves = importlib.import_module("halves")
    assert compiling.compiled("f8(f8)")(halves.half)(3.0) == 1.5
    assert compiling.compiled("f8(f8)")(halves.third)(3.0) == 1.0
    assert [(r.name, r.getMessage()) for r in caplog.records] == [
        ("undertow", "compiling the integrator once, up to half a minute")
    ]


def test_a_first_start_takes_from_disk_what_another_process_compiled(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from undertow import compiling

    monkeypatch.setattr(compiling, "_PROCESSES", compiling._Processes())
    (tmp_path / "thirds.py").write_text(
        "from undertow.compiling import compiled\n"
        "@compiled('f8(f8)')\ndef third(x):\n    return x / 3.0\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    third = importlib.import_module("thirds").third
    assert third(3.0) == 1.0
    assert sum(third.stats.cache_hits.values()) == 1
    assert not third.stats.cache_misses


def test_a_module_that_no_other_process_can_import_compiles_here(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from undertow import compiling

    monkeypatch.setattr(compiling, "_PROCESSES", compiling._Processes())
    (tmp_path / "quarters.py").write_text("def quarter(x):\n    return x / 4.0\n")
    monkeypatch.syspath_prepend(tmp_path)
    quarter = importlib.import_module("quarters").quarter
    quarter.__module__ = "not.there"
    found = compiling.compiled("f8(f8)")(quarter)
    assert found(4.0) == 1.0
    assert not found.stats.cache_hits


def test_a_process_that_compiles_one_module_leaves_the_functions_of_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from undertow import compiling

    (tmp_path / "fifths.py").write_text("def fifth(x):\n    return x / 5.0\n")
    monkeypatch.syspath_prepend(tmp_path)
    fifth = importlib.import_module("fifths").fifth
    monkeypatch.setenv(compiling.TASK, "another.module")
    assert compiling.compiled("f8(f8)")(fifth).signatures == []
    monkeypatch.setenv(compiling.TASK, "fifths")
    assert len(compiling.compiled("f8(f8)")(fifth).signatures) == 1


# ---------------------------------------------------------------- terms
def test_terms_lists_the_whole_registry_with_law_unit_source_and_sign(capsys: Capture) -> None:
    said = undertow(capsys, "terms")
    assert said.code == 0
    assert [line for line in said.out.splitlines() if not line.startswith(" ")] == list(registry.names())
    for block in re.split(r"\n(?! )", said.out.strip()):
        for key in ("law", "parameters", "source", "left out"):
            assert re.search(rf"^  {key} +\S", block, re.MULTILINE), block


def test_terms_shows_one_and_names_the_nearest(capsys: Capture) -> None:
    assert undertow(capsys, "terms", "added_mass").out.count("law") == 1
    said = undertow(capsys, "terms", "added_mas")
    assert said.code == 2
    assert "equation term 'added_mas' is not in the registry; did you mean 'added_mass'?" in said.err


def test_terms_answers_for_every_name_that_a_verdict_can_say(capsys: Capture) -> None:
    said = {suspect.name for suspect in all_suspects()} | {*SUSPECTS_IN_TIME, *FOUND_ELSEWHERE, *NOT_TESTABLE}
    assert {"presliding", "sensor_drift", "bouc_wen", "support_compliance"} < said
    for name in said:
        answer = undertow(capsys, "terms", name)
        assert (answer.code, answer.out.splitlines()[0]) == (0, name)
    assert "shown by   the body weighed before and after" in undertow(capsys, "terms", "mass_change").out


# ---------------------------------------------------------------- inspect
def test_inspect_proposes_a_config_that_reads_the_file(capsys: Capture, tmp_path: Path) -> None:
    table = recorded(0.04, 0)
    table[:, 1] *= 1e3
    table[:, 2] /= 9.80665
    write_table(tmp_path / "my run (1).csv", table, "Laboratory 7\nTime;pot;acc\n[s];[mm];[g]".replace(";", ","))
    said = undertow(capsys, "inspect", tmp_path / "my run (1).csv")
    assert said.code == 0
    assert re.search(r"550 samples, 5\.49 s at 100 Hz", said.out)
    assert re.search(r"displacement: -0\.03\d* to 0\.040\d* m, noise 0\.0001", said.out)
    assert re.search(r"released at 0\.49\d+ \+- 0\.00\d+ s, motion until \d", said.out)
    config = tmp_path / "config.yaml"
    config.write_text(said.out.partition("proposed config:\n")[2])
    catalogue = load(config).catalogue()
    (entry,) = gather(catalogue)
    recording = read_trial(entry, catalogue)
    assert recording.time.size == 550
    assert 0.0399 < recording.channels["displacement"][:40].mean() < 0.0401


def test_inspect_goes_on_after_a_file_it_cannot_read(capsys: Capture, tmp_path: Path) -> None:
    write_table(tmp_path / "good.csv", recorded(0.04, 0))
    said = undertow(capsys, "inspect", tmp_path / "nope.csv", tmp_path / "good.csv")
    assert said.code == 3
    assert "550 samples" in said.out
    assert re.match(r"undertow: \S*nope\.csv is not there; check the path", said.err)
    assert undertow(capsys, "inspect", tmp_path / "nope.csv").code == 2
    (tmp_path / "words.csv").write_text("no numbers\n")
    assert undertow(capsys, "inspect", tmp_path / "words.csv").code == 1


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("run", "c.yaml", "--out", ""), "--out is empty, as an unset shell variable is; give a path, or leave it out"),
        (("run", "c.yaml", "--out="), "--out is empty"),
        (("audit", "c.yaml", "--out", ""), "--out is empty"),
        (("init", ""), "the word after 'init' is empty"),
    ],
)
def test_a_path_that_is_empty_is_not_this_folder(capsys, tmp_path, monkeypatch, words, said):
    campaign = make_campaign(tmp_path, [0.03])
    (tmp_path / "c.yaml").write_text(campaign.config.read_text())
    monkeypatch.chdir(tmp_path)
    before = sorted(tmp_path.rglob("*"))
    got = undertow(capsys, *words)
    assert (got.code, said in got.err) == (2, True), got.err
    assert sorted(tmp_path.rglob("*")) == before


# ---------------------------------------------------------------- compare
def test_compare_puts_runs_of_one_name_side_by_side(capsys: Capture, tmp_path: Path) -> None:
    campaign = make_campaign(tmp_path, [0.03, 0.05], springs=("<b>",))
    for name, terms in (("a", "stiffness, coulomb_friction"), ("b", "stiffness, viscous_damping, coulomb_friction")):
        words = ["--out", tmp_path / name / "run", "--jobs", 1, "--set", f"equation.terms=[{terms}]"]
        assert undertow(capsys, "run", campaign.config, *words).code == 0
    said = undertow(capsys, "compare", tmp_path / "a/run", tmp_path / "b/run", "--out", tmp_path / "both.html")
    assert said.code == 0
    rows = {cells[0]: cells for row in said.out.splitlines() if (cells := re.split(r"  +", row.strip()))}
    assert rows["quantity"][1:3] == [str(tmp_path / "a/run"), str(tmp_path / "b/run")]
    assert len(rows["stiffness"]) == 4
    assert all("±" in cell for cell in rows["stiffness"][1:3])
    assert rows["viscous damping"][-1] == f"only in {tmp_path / 'b/run'}", "only one of the runs has it"
    page = (tmp_path / "both.html").read_text()
    assert "<td>viscous damping</td>" in page
    assert "c_Ns_per_m" not in said.out + page
    assert "&lt;b&gt;" in page
    assert "<b>" not in page
    assert said.out.endswith("errors or more in 1, parameters that one run alone has in 1\n")
    known = ["--out", tmp_path / "c" / "run", "--jobs", 1, "--set", "specimen.mass_kg=null"]
    assert undertow(capsys, "run", campaign.config, *known, *words[-2:]).code == 0
    known = undertow(capsys, "compare", tmp_path / "c/run", tmp_path / "b/run")
    assert "not comparable" not in known.out
    assert "standard errors or more in 0" in known.out
    equations = tmp_path / "b/run/equations.json"
    whole = equations.read_text()
    equations.write_text(whole[:200])
    cut = undertow(capsys, "compare", tmp_path / "a/run", tmp_path / "b/run")
    assert cut.code == 1
    assert f"{equations} is not as a run writes it (JSONDecodeError); run it again" in cut.err
    equations.write_text(whole)
    said = undertow(capsys, "compare", tmp_path / "a/run", tmp_path / "b/run", "--out", tmp_path / "no" / "both.html")
    assert said.code == 1
    assert re.search(r"undertow: .*both\.html.*: No such file or directory; check path, rights, space", said.err)


@pytest.mark.parametrize("content", ["", "{}", '{"groups": [1]}', "[]"])
def test_compare_says_which_folder_holds_no_run(capsys: Capture, tmp_path: Path, content: str) -> None:
    (tmp_path / "verdict.json").write_text(content)
    said = undertow(capsys, "compare", tmp_path)
    assert said.code == 1
    assert re.search(r"verdict\.json cannot be read: .*; give a folder that `undertow run` finished", said.err)


@pytest.mark.parametrize("words", [["compare"], ["explain"], ["open"], ["predict", "--x0", "1"]])
def test_a_run_folder_that_is_not_there_is_wrong_usage(capsys: Capture, tmp_path: Path, words: list[str]) -> None:
    said = undertow(capsys, *words, tmp_path / "nowhere")
    assert said.code == 2
    assert re.search(r"^undertow: run folder .*nowhere is not there; give that of the report that `unde", said.err)
    with pytest.raises(ConfigError, match=r"run folder .*nowhere is not there"):
        must_be_there([tmp_path / "nowhere"])
    (tmp_path / "report.html").write_text("the line that a run ends with names this file")
    if words != ["open"]:  # which takes the page itself as well
        said = undertow(capsys, *words, tmp_path / "report.html")
        assert said.code == 2
        assert f"report.html is a file; give the folder it stands in, {tmp_path}" in said.err


# ---------------------------------------------------------------- fetch
def test_fetch_brings_a_record_and_says_its_checksums(
    capsys: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with serving() as server:
        server.record()
        monkeypatch.setattr(fetch, "ZENODO_API", server.base)
        said = undertow(capsys, "fetch", "10.5281/zenodo.12", "--into", tmp_path / "new")
        assert said.code == 0
        assert said.out == f"{tmp_path / 'new' / 'run.csv'}  300000 bytes  sha256:{SHA256}  (md5 agrees)\n"
        assert (tmp_path / "new" / "run.csv").read_bytes() == CONTENT
        wrong = undertow(
            capsys, "fetch", f"{server.base}/data/run.csv", "--into", tmp_path, "--checksum", f"md5:{MD5[::-1]}"
        )
    assert wrong.code == 1
    assert re.search(r"undertow: run\.csv: MD5 hash .* does not match", wrong.err)


def test_fetch_interrupted_says_how_to_go_on(
    capsys: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(fetch, "fetch", interrupted)
    said = undertow(capsys, "fetch", "10.5281/zenodo.12", "--into", tmp_path)
    assert said.code == 130
    assert said.err == "undertow: interrupted; what was fetched is kept, the same command goes on from there\n"


@pytest.mark.parametrize(
    ("source", "code", "sentence"),
    [
        ("10.1000/182", 2, r"DOI '10\.1000/182' is none of Zenodo's .*; give the address of its file"),
        ("http://example.org/a.csv", 1, r"has scheme 'http'; only https is fetched"),
        ("https://example.org/..%2fa.csv", 1, r"which is no plain file name inside the folder"),
    ],
)
def test_fetch_refuses_what_it_should(
    capsys: Capture, tmp_path: Path, source: str, code: int, sentence: str
) -> None:
    said = undertow(capsys, "fetch", source, "--into", tmp_path)
    assert said.code == code
    assert re.search(f"undertow: .*{sentence}", said.err)
    assert list(tmp_path.iterdir()) == []


def test_help_says_what_a_command_does_and_no_nan(capsys: Capture) -> None:
    assert "nan" not in undertow(capsys, "predict", "--help").out
    listed = undertow(capsys, "--help").out.split("Commands:")[1].strip().splitlines()
    first = {line.split()[0]: line.split()[1] for line in listed}
    assert first["fetch"] == "Download"
    assert first["explain"] == "List"
