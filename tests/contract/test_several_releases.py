"""One recording that holds several releases: `init` and `inspect` give each as a trial, `run` says what to write."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from tests.command_line import undertow
from tests.unit.test_releases import RATE_HZ, SESSIONS, decay, knocked, session
from undertow.campaign.config import load
from undertow.campaign.config.matching import planned
from undertow.campaign.starting import start
from undertow.errors import ConfigError
from undertow.recording.catalogue import read_trial
from undertow.recording.recording import Array

Capture = pytest.CaptureFixture[str]

CONFIG = """\
name: tank
recordings:
  index: trials.csv
  channels:
    time: {column: t_s, unit: s}
    displacement: {column: x_m, unit: m}
equation: {terms: [stiffness, viscous_damping]}
identify: [sindy]
discrepancy: {suspects: []}
"""


def write(path: Path, x: Array, acceleration: bool = False) -> None:
    rng = np.random.default_rng(x.size)
    t = np.arange(x.size) / RATE_HZ
    columns = {"t_s": t, "x_m": x + 1e-4 * rng.standard_normal(x.size)}
    if acceleration:
        columns["a_mps2"] = np.gradient(np.gradient(x, t), t) + 0.02 * rng.standard_normal(x.size)
    path.parent.mkdir(exist_ok=True)
    np.savetxt(path, np.column_stack(list(columns.values())), "%.6f", ",", header=",".join(columns), comments="")


@pytest.fixture
def tank(tmp_path: Path) -> Path:
    """Two recordings of three and of one release, with an index."""
    write(tmp_path / "s1.csv", SESSIONS["either side"][0])
    write(tmp_path / "s2.csv", np.r_[np.full(200, 0.1), decay(20, 0.1)])
    (tmp_path / "trials.csv").write_text("file,spring\ns1.csv,long\ns2.csv,long\n")
    (tmp_path / "run.yaml").write_text(CONFIG)
    return tmp_path


@pytest.mark.parametrize("acceleration", [False, True])
def test_init_gives_a_trial_for_each_release_and_says_so(
    capsys: Capture, tmp_path: Path, acceleration: bool
) -> None:
    folder = tmp_path / "tank"
    x, at = SESSIONS["either side"]
    write(folder / "s1.csv", x, acceleration)
    write(folder / "s2.csv", np.r_[np.full(200, 0.1), decay(20, 0.1)], acceleration)
    begun = undertow(capsys, "init", folder)
    assert begun.code == 0, begun.err
    assert "4 trials in one layout\n" in begun.out
    assert "guessed: 1 recording holds several releases on one clock (s1.csv 3): each release is a trial" in begun.out
    config = load(folder / "undertow.yaml")
    entries = planned(config).entries
    assert [one.name for one in entries] == ["s1_1", "s1_2", "s1_3", "s2"]
    assert [one.conditions.get("release") for one in entries] == [1.0, 2.0, 3.0, None]
    said = config.catalogue()
    for entry, release, following in zip(entries, at, [*at[1:], np.inf], strict=False):
        time = read_trial(entry, said).time
        assert time[0] < release < time[-1] < following
    ran = undertow(capsys, "run", folder / "undertow.yaml", "--out", tmp_path / "run", "--jobs", 1,
                   "--set", "identify=[decay]", "--set", "discrepancy.suspects=[]")  # fmt: skip
    assert ran.code == 0, ran.err
    assert "releases" not in ran.out


@pytest.mark.parametrize("x", [knocked(8.0, 1.0, 0.3), np.r_[np.full(300, 0.1), decay(30, 0.1)]])
def test_init_leaves_one_release_alone(tmp_path: Path, x: Array) -> None:
    write(tmp_path / "tank" / "s1.csv", x)
    assert start(tmp_path / "tank").trials == 1
    assert "releases" not in (tmp_path / "tank" / "undertow.yaml").read_text()


def test_a_release_that_cannot_be_used_is_left_out_alone(tmp_path: Path) -> None:
    cut, _ = session([decay(20, 0.1), decay(20, 0.08), decay(1.6, 0.1)])
    write(tmp_path / "tank" / "s1.csv", cut)
    begun = start(tmp_path / "tank")
    names = [name for name, _ in begun.left_out]
    assert begun.trials == 3 - len(names)
    kept = {one.name for one in planned(load(begun.path)).entries}
    assert kept == {"s1_1", "s1_2", "s1_3"} - set(names)


def test_inspect_proposes_the_same_parts(capsys: Capture, tank: Path) -> None:
    looked = undertow(capsys, "inspect", tank / "s1.csv", "--save")
    assert "doubt: it holds 3 releases on one clock: each is a trial (recordings.releases)" in looked.out
    assert len(planned(load(tank / "s1.yaml")).entries) == 3


def test_a_run_says_that_one_of_several_releases_is_used_and_what_to_write(capsys: Capture, tank: Path) -> None:
    write(tank / "s1.csv", SESSIONS["two"][0])
    ran = undertow(capsys, "run", tank / "run.yaml", "--out", tank / "run", "--jobs", 1)
    says = r"doubt: .*s1: it holds 2 releases .* only that of \S+ s is used.*recordings\.releases: (\{.*\]\})"
    found = re.search(says, ran.out)
    assert found, ran.out + ran.err
    again = undertow(capsys, "run", tank / "run.yaml", "--out", tank / "again", "--jobs", 1,
                     "--set", f"recordings.releases={found.group(1)}")  # fmt: skip
    assert again.code == 0
    assert "doubt" not in again.out
    assert (tank / "again" / "trials.csv").read_text().count("sindy") == 3
    known = undertow(capsys, "run", tank / "run.yaml", "--out", tank / "known", "--jobs", 1,
                     "--set", "recordings.accept={s1: [releases]}")  # fmt: skip
    assert "doubt" not in known.out


def test_a_trial_that_fails_by_them_says_so(capsys: Capture, tank: Path) -> None:
    ran = undertow(capsys, "run", tank / "run.yaml", "--out", tank / "run", "--jobs", 1)
    assert ran.code == (3 if "failed: trial s1" in ran.out + ran.err else 0)
    assert "s1: it holds 3 releases on one clock (let go near 2, 25.5, 49 s)" in ran.out + ran.err


@pytest.mark.parametrize(
    ("parts", "says"),
    [
        ("[{start_s: 0, end_s: 20}, {start_s: 15, end_s: 40}]", r"part 1 ends at 20 s and part 2 starts at 15 s"),
        ("[{start_s: 0}, {start_s: 15}]", r"part 1 ends at open and part 2 starts at 15 s"),
        ("[{start_s: 9, end_s: 5}]", r"starts at 9\.0 s and ends at 5\.0 s; it must end later"),
        ("[]", r"releases has no part for 's1\.csv'; give start_s and end_s of each release"),
    ],
)
def test_parts_that_share_samples_or_hold_none_stop_the_run(tank: Path, parts: str, says: str) -> None:
    with pytest.raises(ConfigError, match=says):
        load(tank / "run.yaml", [f"recordings.releases={{s1.csv: {parts}}}"])


def test_parts_of_a_recording_that_is_not_there_stop_the_run(tank: Path) -> None:
    config = load(tank / "run.yaml", ["recordings.releases={s9.csv: [{end_s: 3}]}"])
    with pytest.raises(ConfigError, match=r"recordings\.releases names 's9\.csv', which fits none of 2 trials"):
        planned(config)


def test_a_release_called_like_another_file_stops_the_run(tank: Path) -> None:
    (tank / "s1_2.csv").write_bytes((tank / "s2.csv").read_bytes())
    (tank / "trials.csv").write_text("file,spring\ns1.csv,long\ns1_2.csv,long\n")
    config = load(tank / "run.yaml", ["recordings.releases={s1.csv: [{end_s: 20}, {start_s: 24}]}"])
    with pytest.raises(ConfigError, match=r"s1\.csv and s1_2\.csv both have a trial called 's1_2'; rename one"):
        planned(config)


def test_a_part_without_samples_is_that_trials_failure(capsys: Capture, tank: Path) -> None:
    ran = undertow(capsys, "run", tank / "run.yaml", "--out", tank / "run", "--jobs", 1,
                   "--set", "recordings.releases={s2: [{end_s: 21}, {start_s: 900}]}")  # fmt: skip
    assert "s2_2: the window from 900.0 s on holds none of the samples" in ran.out + ran.err
    assert "correct recordings.releases" in ran.out + ran.err
