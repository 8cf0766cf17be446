"""Bad input through the command: one sentence with quantity, value, rule and next step, an exit code, no traceback."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.command_line import undertow
from tests.small_campaign import Campaign, Table, amplitudes, make_campaign, recorded, write_table

Capture = pytest.CaptureFixture[str]

FAILED, USAGE, SOME_FAILED = 1, 2, 3


@pytest.fixture
def campaign(tmp_path: Path) -> Campaign:
    """One good trial."""
    return make_campaign(tmp_path / "campaign", [0.04])


def with_nan(table: Table) -> Table:
    table[100:310, 1] = np.nan
    return table


def with_duplicated_time(table: Table) -> Table:
    table[200, 0] = table[199, 0]
    return table


def with_time_going_back(table: Table) -> Table:
    table[300:, 0] -= 1.0
    return table


def with_exchanged_columns(table: Table) -> Table:
    table[:, [0, 1]] = table[:, [1, 0]]
    return table


def with_constant_acceleration(table: Table) -> Table:
    table[:, 2] = 0.3
    return table


def with_clipped_displacement(table: Table) -> Table:
    table[:, 1] = np.clip(table[:, 1], -0.025, 0.025)
    return table


def without_release(table: Table) -> Table:
    table[:, 1] = 0.04 + 1e-4 * np.random.default_rng(1).standard_normal(len(table))
    table[:, 2] = 0.02 * np.random.default_rng(2).standard_normal(len(table))
    return table


def with_two_samples(table: Table) -> Table:
    return table[:2]


def with_infinite_time(table: Table) -> Table:
    table[5, 0] = np.inf
    return table


@pytest.mark.parametrize(
    ("spoil", "sentence"),
    [
        (with_nan, r"displacement lacks 210 of 550 values, the first at 1 s, and more than 20 % .*; end trials\.w"),
        (with_duplicated_time, r"time goes from 1\.99 s to 1\.99 s at sample 200; time must increase: remove dupl"),
        (with_exchanged_columns, r".*increase: displacement does, from sample to sample: are the columns of .*time"),
        (with_time_going_back, r"time goes from 2\.99 s to 2 s at sample 300; time must increase"),
        (with_constant_acceleration, r"acceleration is constant at 0\.3 m/s\^2 over 5\.49 s; was the sensor connected"),
        (with_clipped_displacement, r"displacement is clipped between -0\.025 and 0\.025 m: .* widen the sensor's"),
        (without_release, r"no release found: the record moves by .* m with noise of .* m; motion must exceed"),
        (with_two_samples, r" has 2 samples; at least 50 are needed for three cycles: is it the right file"),
        (with_infinite_time, r"time column 't' has 1 values that are not finite, the first in row 6 of 550; repair"),
    ],
)
def test_a_recording_that_cannot_be_used_is_said(
    capsys: Capture, campaign: Campaign, spoil: Callable[[Table], Table], sentence: str
) -> None:
    write_table(campaign.folder / "r00.csv", spoil(recorded(0.04, 0)))
    said = undertow(capsys, "run", campaign.config, "--out", campaign.folder / "run")
    assert said.code == FAILED
    assert re.search(rf"undertow: none of 1 trials can be used: trial r00.*{sentence}", said.err), said.err


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("t,x,a", "t,pos,a", r"r00\.csv has no column 'x'; it has t, pos, a; correct recordings\.channels"),
        ("0.04", "off", r"r00\.csv: column 'x', line \d+: 'off.*' is not a number; repair the file"),
        ("t,x,a", "1,2,3", r"the header line holds numbers \(1, 2, 3\); set header: none, columns by number"),
        ("t,x,a", "t,x,x", r"r00\.csv has 2 columns named 'x'; rename all but one"),
    ],
)
def test_a_table_that_is_not_what_the_config_says_is_said(
    capsys: Capture, campaign: Campaign, old: str, new: str, sentence: str
) -> None:
    path = campaign.folder / "r00.csv"
    path.write_text(path.read_text().replace(old, new, 1))
    said = undertow(capsys, "run", campaign.config, "--out", campaign.folder / "run")
    assert said.code == (USAGE if "has no column" in sentence else FAILED)
    assert re.search(sentence, said.err), said.err


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"", r"r00\.csv is empty \(0 bytes\); copy it again"),
        (b"\x00\x01\x02\x03", r"r00\.csv is not text: 4 control bytes .* is its suffix right"),
        (b"t,x,a\n", r"r00\.csv has 1 lines after 0 skipped ones, and no data among them; check skip_rows"),
    ],
)
def test_a_file_that_is_no_table_is_said(capsys: Capture, campaign: Campaign, content: bytes, sentence: str) -> None:
    (campaign.folder / "r00.csv").write_bytes(content)
    said = undertow(capsys, "run", campaign.config, "--out", campaign.folder / "run")
    assert said.code == FAILED
    assert re.search(sentence, said.err), said.err


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("r" * 3000, r"the index names .r{200}\.\.\.., but such a file is not there; copy it or drop the row"),
        ("gone.csv", r"the index names 'gone\.csv', but .*gone\.csv is not there; copy it or drop the row"),
        ("../r00.csv", r"the index names the file '\.\./r00\.csv'; it must lie in the index's folder"),
        ("/etc/passwd", r"the index names the file '/etc/passwd'; it must lie in the index's folder"),
        ("r00.pkl", r"\.pkl can carry code and is never read; save it as CSV, MAT or HDF5"),
        ("r00.xyz", r"no reader for '\.xyz'; known: \.csv"),
    ],
)
def test_an_index_that_names_a_wrong_file_is_said(
    capsys: Capture, campaign: Campaign, name: str, sentence: str
) -> None:
    if name.startswith("r00"):
        (campaign.folder / name).write_bytes(b"x")
    (campaign.folder / "campaign.csv").write_text(f"file,spring\n{name},long\n")
    said = undertow(capsys, "run", campaign.config, "--out", campaign.folder / "run")
    assert said.code == (FAILED if name.startswith("r00") else USAGE)
    assert re.search(sentence, said.err), said.err


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("  channels:", "  chanels:", r"config\.yaml line 4: unknown key 'chanels' in recordings; did you mean"),
        ("unit: m}", "unit: furlongz}", r"line 6: displacement: unit 'furlongz' is not known; .*it may be m, mm"),
        ("unit: m}", "unit: kg}", r"line 6: displacement is said to be in 'kg', which is kg in SI base units"),
        ("coulomb_friction]", "coulom_friction]", r"line 13: equation term 'coulom_friction' is not in the registry; "),
        ("mass_kg: 2637.4", "mass_kg: heavy", r"line 11: specimen\.mass_kg is 'heavy' but should be a valid number"),
        ("suspects: []", "suspects: [ghosts]", r"line 15: discrepancy\.suspects: 'ghosts' is none of .*hidden_reson"),
        ("identify: [sindy]", "identify: [sindy", r"line 1\d: .*; correct the YAML"),
        ("index: campaign.csv", "index: nope.csv", r"recordings\.index .*nope\.csv is not there; paths are relative"),
        ("group_by: [spring]", "group_by: [depth]", r"line 9: trials\.group_by names .depth., but .* spring"),
        ("name: small\n", "", r"the config has no 'name'; it is needed"),
    ],
)
def test_a_mistake_in_the_config_is_named_with_its_line(
    capsys: Capture, campaign: Campaign, old: str, new: str, sentence: str
) -> None:
    campaign.edit(old, new)
    said = undertow(capsys, "run", campaign.config, "--out", campaign.folder / "run")
    assert said.code == USAGE
    assert re.search(rf"^(undertow: )?.*{sentence}", said.err, re.MULTILINE), said.err


@pytest.mark.parametrize(
    ("words", "code", "sentence"),
    [
        (["--set", "recordings.separator=((("], USAGE, r"separator is '\(\(\('; give one character, tab"),
        (["--set", r'recordings.separator="\n"'], USAGE, r"recordings\.separator.*separator is '\\n'; give one char"),
        (["--set", r'recordings.index_separator="\""'], USAGE, r"index_separator is '\"'; give one character, tab"),
        (["--set", "nonsense"], USAGE, r"--set nonsense: it must read key\.key=value"),
        (["--set", "seed=-1"], USAGE, r"--set seed=-1: seed is -1 but should be greater than or equal to 0"),
        (["--set", "specimen.mas_kg=1"], USAGE, r"--set specimen\.mas_kg=1: unknown key 'mas_kg' in specimen; did you"),
        (["--set", "equation.terms=[lift]"], USAGE, r"equation term 'lift' is not in the registry"),
        (["--jobs", "many"], USAGE, r"Invalid value for '--jobs'"),
        (["--jobs", "-1"], USAGE, r"Invalid value for '--jobs'"),
        (["--out", "{folder}/campaign.csv"], FAILED, r"run folder .*campaign\.csv cannot be written: File exists"),
        (["--out", "{folder}/r00.csv/run"], FAILED, r"run folder .* cannot be written: Not a directory .*--out"),
        (["--colour"], USAGE, r"No such option"),
    ],
)
def test_a_mistake_on_the_command_line_is_said(
    capsys: Capture, campaign: Campaign, words: list[str], code: int, sentence: str
) -> None:
    words = [word.format(folder=campaign.folder) for word in words]
    said = undertow(capsys, "run", campaign.config, *words)
    assert said.code == code
    assert re.search(sentence, said.err), said.err


def test_a_config_that_is_not_there_is_said(capsys: Capture, tmp_path: Path) -> None:
    said = undertow(capsys, "run", tmp_path / "nope.yaml")
    assert said.code == USAGE
    assert re.search(r"undertow: config .*nope\.yaml cannot be read: No such file .*; check the path", said.err)


def test_a_trial_that_fails_among_fifty_is_listed_and_the_others_are_done(capsys: Capture, tmp_path: Path) -> None:
    campaign = make_campaign(tmp_path, list(amplitudes(50)))
    write_table(tmp_path / "r17.csv", with_nan(recorded(0.04, 17)))
    said = undertow(capsys, "run", campaign.config, "--out", tmp_path / "run", "--jobs", 1)
    assert said.code == SOME_FAILED
    failed = [line for line in said.err.splitlines() if line.startswith("failed: ")]
    assert len(failed) == 1
    assert re.match(r"failed: trial r17: displacement lacks 210 of 550 values, the first at 1 s", failed[0])
    trials = pd.read_csv(tmp_path / "run" / "trials.csv")
    assert trials[trials.method == "sindy"].trial.nunique() == 49
    assert trials[trials.trial == "r17"].outcome.str.startswith("failed: trial r17: displacement lacks").all()
    assert "r17" in (tmp_path / "run" / "report.html").read_text()


def test_a_group_that_cannot_be_identified_does_not_stop_the_others(
    capsys: Capture, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from undertow.campaign.run import course as run
    from undertow.errors import IdentificationError

    def analyse(task: run.GroupTask) -> object:
        if task.key["spring"] == "soft":
            raise IdentificationError("k is 0 N/m; it must be positive: look at the spring")
        return original(task)

    original = run.analyse
    monkeypatch.setattr(run, "analyse", analyse)
    campaign = make_campaign(tmp_path, [0.04], springs=("hard", "soft"))
    said = undertow(capsys, "run", campaign.config, "--out", tmp_path / "run", "--jobs", 1)
    assert said.code == SOME_FAILED
    assert "failed: r01: k is 0 N/m; it must be positive: look at the spring" in said.err
    (tmp_path / "campaign.csv").write_text("file,spring\nr01.csv,soft\n")
    said = undertow(capsys, "run", campaign.config, "--out", tmp_path / "run", "--jobs", 1)
    assert said.code == FAILED
    assert "none of 1 groups can be identified: k is 0 N/m" in said.err


@pytest.mark.parametrize(
    ("words", "code", "sentence"),
    [
        (["run", "nope.yaml"], USAGE, r"^undertow: config nope\.yaml cannot be read"),
        (["run", "config.yaml", "--set", "x"], USAGE, r"^undertow: --set x: it must read"),
        (["inspect", "campaign.csv"], FAILED, r"no table of numbers begins in its first 2 lines; is it a recording"),
        (["compare", "."], USAGE, r"^undertow: run folder .*verdict\.json cannot be read"),
    ],
)
def test_the_real_command_never_shows_a_traceback(
    campaign: Campaign, words: list[str], code: int, sentence: str
) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "undertow", *words], cwd=campaign.folder, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == code
    assert "Traceback" not in done.stderr
    assert re.search(sentence, done.stderr, re.MULTILINE), done.stderr
    assert done.stdout == ""


def test_a_failed_run_leaves_no_older_answer_in_its_folder(capsys, tmp_path) -> None:
    campaign = make_campaign(tmp_path / "data", [0.03, 0.05])
    out = tmp_path / "run"
    assert undertow(capsys, "run", campaign.config, "--out", out, "--jobs", 1).code == 0
    for name in campaign.files:
        (campaign.folder / name).write_text("")
    said = undertow(capsys, "run", campaign.config, "--out", out, "--jobs", 1)
    assert said.code == 1
    assert not (out / "verdict.json").exists()
    assert not (out / "report.html").exists()
    assert (out / "earlier_run" / "verdict.json").exists()


def test_a_misspelt_config_leaves_an_older_answer_where_it_is(capsys, tmp_path) -> None:
    campaign = make_campaign(tmp_path / "data", [0.03, 0.05])
    out = tmp_path / "run"
    assert undertow(capsys, "run", campaign.config, "--out", out, "--jobs", 1).code == 0
    assert undertow(capsys, "run", campaign.config, "--out", out, "--set", "naem=x").code == 2
    assert (out / "verdict.json").exists()


def test_a_column_that_no_recording_has_is_the_configs_fault(capsys, tmp_path) -> None:
    campaign = make_campaign(tmp_path / "data", [0.03, 0.05])
    campaign.edit("column: x", "column: pot")
    said = undertow(capsys, "run", campaign.config, "--out", tmp_path / "run", "--jobs", 1)
    assert said.code == 2
    assert "none of 2 trials can be used" in said.err
    assert said.err.count("has no column 'pot'") == 1


def test_the_same_recording_under_two_names_is_used_once(capsys, tmp_path) -> None:
    campaign = make_campaign(tmp_path / "data", [0.03, 0.05, 0.04])
    first, second, _ = campaign.files
    (campaign.folder / second).write_bytes((campaign.folder / first).read_bytes())
    said = undertow(capsys, "run", campaign.config, "--out", tmp_path / "run", "--jobs", 1)
    assert said.code == 3
    assert f"is the same recording as {Path(first).stem}" in said.err


def test_a_recording_that_was_exported_again_is_used_once(capsys, tmp_path) -> None:
    campaign = make_campaign(tmp_path / "data", [0.03, 0.05, 0.04])
    first, second, _ = campaign.files
    table = pd.read_csv(campaign.folder / first).iloc[15:]
    table.to_csv(campaign.folder / second, index=False, float_format="%.5g")
    said = undertow(capsys, "run", campaign.config, "--out", tmp_path / "run", "--jobs", 1)
    assert said.code == 3
    assert f"is the same recording as {Path(first).stem}" in said.err


def test_a_condition_in_capital_letters_makes_no_group_of_its_own(capsys, tmp_path) -> None:
    campaign = make_campaign(tmp_path / "data", [0.03, 0.05, 0.04])
    index = campaign.folder / "campaign.csv"
    index.write_text(index.read_text().replace(f"{campaign.files[1]},long", f"{campaign.files[1]},Long "))
    said = undertow(capsys, "run", campaign.config, "--out", tmp_path / "run", "--jobs", 1)
    assert said.code == 2
    assert "spell it alike in the index" in said.err
