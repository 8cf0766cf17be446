"""`undertow init` and `inspect --save`: from a folder of files to a config that runs as it is."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.command_line import undertow
from tests.lab_files import write_csv, write_excel, write_mat, write_parquet, write_tdms
from tests.small_campaign import recorded, write_table
from undertow.campaign.config import load
from undertow.campaign.config.matching import planned
from undertow.campaign.run.checking import Checker
from undertow.campaign.starting import start
from undertow.campaign.starting.indexed import find_index
from undertow.campaign.starting.names import read_names
from undertow.conditioning.agreement import Disagreement
from undertow.errors import ConfigError, UndertowError
from undertow.recording.catalogue import read_trial
from undertow.recording.recording import Recording

Capture = pytest.CaptureFixture[str]

KINDS = (
    ("csv", write_csv), ("xlsx", write_excel), ("tdms", write_tdms), ("mat", write_mat), ("parquet", write_parquet)
)  # fmt: skip


@pytest.fixture(scope="module")
def thirteen(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Thirteen trials in five formats, three layouts of columns and two units; a text that is none."""
    folder = tmp_path_factory.mktemp("campaign") / "tank"
    folder.mkdir()
    for at in range(13):
        suffix, write = KINDS[at % 5]
        t, x, a = recorded(0.03 + 0.01 * (at % 4), at).T
        columns = {"disp": (x, "m")} if suffix == "tdms" else {"disp": (1e3 * x, "mm"), "acc": (a, "m/s^2")}
        write(folder / f"T{at + 1:02d}_{'lang' if at < 7 else 'kurz'}_{'ab'[at % 2]}.{suffix}", t, columns)
    (folder / "T14_lang_a.csv").write_text("broken off\n")
    (folder / "photo.jpg").write_bytes(b"x")
    return folder


def test_thirteen_files_in_five_formats_go_from_init_to_a_verdict(
    capsys: Capture, thirteen: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("undertow.report.html.svg_text", lambda *said, **how: "<svg></svg>")  # half of the time
    begun = undertow(capsys, "init", thirteen)
    assert begun.code == 0
    assert "13 trials in 5 layouts; 1 file left out:" in begun.out
    assert "  T14_lang_a.csv: no table of numbers begins in its first 1 lines" in begun.out
    looked = undertow(capsys, "inspect", thirteen / "T02_lang_b.xlsx")
    assert "proposed config:" in looked.out
    config = thirteen / "undertow.yaml"
    quick = ["--set", "identify=[sindy]", "--set", "discrepancy.suspects=[]", "--jobs", 1]
    ran = undertow(capsys, "run", config, "--out", tmp_path / "run", *quick)
    assert ran.code == 0, ran.err
    verdict = json.loads((tmp_path / "run" / "verdict.json").read_text())
    sizes = {group["group"]["spring"]: len(group["trials"]) for group in verdict["groups"]}
    assert sizes == {"kurz": 6, "lang": 7}


def test_the_command_that_init_names_next_can_be_pasted(capsys: Capture, tmp_path: Path) -> None:
    (tmp_path / "my tank").mkdir()
    write_table(tmp_path / "my tank" / "r1.csv", recorded(0.04, 0), "t[s],x[m],a[m/s^2]")
    said = undertow(capsys, "init", tmp_path / "my tank").out
    assert said.rstrip().endswith(f"undertow run '{tmp_path}/my tank/undertow.yaml'")


def test_what_init_writes_reads_every_trial_as_it_was_recorded(thirteen: Path) -> None:
    path = thirteen / "undertow.yaml"
    if not path.exists():
        start(thirteen)
    config = load(path)
    said = config.catalogue()
    entries = planned(config).entries
    assert len(entries) == 13
    for entry in entries:
        at = int(entry.conditions["trial"]) - 1
        true, read = recorded(0.03 + 0.01 * (at % 4), at), read_trial(entry, said)
        np.testing.assert_allclose(read.channels["displacement"], true[:, 1], atol=1e-11)
        assert ("acceleration" in read.channels) == (at % 5 != 2)
    text = path.read_text()
    assert "# parts of the file names are conditions: trial (number of the trial), spring (name of the spring)" in text
    assert "# specimen:\n#   mass_kg:" in text
    assert "group_by: [spring]" in text


@pytest.mark.parametrize(
    ("files", "group_by", "dry", "conditions"),
    [
        (["T1_kurz_229_a.csv", "T2_kurz_163_b.csv", "T3_lang_229_a.csv", "T4_lang_163_b.csv"],
         ("spring", "level"), None, ["trial", "spring", "level", "repetition"]),
        (["d2.36_1.csv", "d2.36_2.xlsx", "d1.63_1.csv", "d1.63_2.csv"], ("d",), None, ["d", "repetition"]),
        (["dry-1.csv", "dry-2.csv", "wet-1.csv.gz", "wet-2.csv"],
         ("water",), ("water", "dry"), ["water", "repetition"]),
        (["r01.csv", "r02.csv", "r03.csv"], (), None, ["trial"]),
        (["m 1,5 x.csv", "m 1,5 y.csv", "m 2,5 x.csv", "m 2,5 y.csv"], ("level",), None, ["level", "repetition"]),
        (["oak_take1.csv", "oak_take2.csv", "elm_take1.csv", "elm_take2.csv"], ("kind",), None, ["kind", "repetition"]),
        (["10.csv", "17.csv"], (), None, ["trial"]),
        (["apple_1.csv", "pear_2.csv"], (), None, ["label", "repetition"]),
        (["b_d0_T1.csv", "b_d0_T2.csv", "b_d1.63_T1.csv", "b_d1.63_T2.csv"], ("d",), ("d", 0.0), ["d", "t"]),
        (["b_i0.0_n1.mat", "b_i0.0_n3.mat", "b_i0.4_n1.mat", "b_i0.4_n3.mat"], ("i",), None, ["i", "n"]),
        (["run_T10_a.csv", "run_T10_b.csv", "run_T20_a.csv", "run_T20_b.csv"], ("t",), None, ["t", "repetition"]),
        (["a.csv", "b_1.csv"], (), None, []),
        (["one.csv"], (), None, []),
    ],
)  # fmt: skip
def test_conditions_are_guessed_from_names(
    files: list[str], group_by: tuple[str, ...], dry: tuple[str, str] | None, conditions: list[str]
) -> None:
    found = read_names(files)
    assert found.group_by == group_by
    assert found.dry == dry
    assert list(found.meanings) == conditions
    assert bool(found.pattern) == bool(conditions)


@pytest.mark.parametrize(("water", "in_water"), [("wet", True), ("236", True), ("air", False)])
def test_where_wet_trials_stand_beside_dry_ones_the_equation_has_what_still_water_does(
    capsys: Capture, tmp_path: Path, water: str, in_water: bool
) -> None:
    for at in range(4):
        write_table(tmp_path / f"s_{'dry' if at % 2 else water}_{'ab'[at // 2]}.csv", recorded(0.03 + 0.01 * at, at))
    begun = undertow(capsys, "init", tmp_path)
    assert begun.code == 0, begun.err
    config = load(tmp_path / "undertow.yaml")
    structure = ("stiffness", "viscous_damping", "coulomb_friction")
    assert config.equation.terms == (*structure, *(("added_mass", "quadratic_drag") if in_water else ()))
    assert ("area_m2 and submerged_volume_m3" in begun.out) is in_water


def test_a_hold_that_would_count_as_motion_is_cut(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_table(tmp_path / "r1.csv", recorded(0.04, 0), "time_s,disp_m,acc_mps2")
    write_table(tmp_path / "r2.csv", recorded(0.05, 1), "time_s,disp_m,acc_mps2")
    compared = Checker._compared

    def held(self: Checker, recording: Recording, *rest: object) -> object:
        """As the check, with a hand that it sees in r1 as long as that is not cut."""
        found, known = compared(self, recording, *rest)  # type: ignore[arg-type]
        window = rest[1]
        if recording.name == "r1" and window.release_s < 0.6:  # type: ignore[attr-defined]
            found = (*found, Disagreement("hold", ("displacement",), 0.753, False, "a hand"))
        return found, known

    monkeypatch.setattr(Checker, "_compared", held)
    done = start(tmp_path)
    said = load(done.path).trials.window
    assert said != "auto"
    assert {name: window.start_s for name, window in said.items()} == {"r1.csv": 0.76}
    assert "# a hand holds the body before these instants" in done.path.read_text()


def test_a_trial_that_a_run_could_not_use_is_left_out_with_the_reason(tmp_path: Path) -> None:
    for at in range(3):
        write_table(tmp_path / f"r{at}.csv", recorded(0.04, at), "time_s,disp_m,acc_mps2")
    short = recorded(0.04, 3)[:40]
    write_table(tmp_path / "r3.csv", short, "time_s,disp_m,acc_mps2")
    wrong = recorded(0.04, 4)
    wrong[:, 2] *= -1.0
    write_table(tmp_path / "r4.csv", wrong, "time_s,disp_m,acc_mps2")
    write_table(tmp_path / "turn.csv", recorded(0.04, 5)[:, :2], "time_s,angle_deg")
    done = start(tmp_path)
    reasons = dict(done.left_out)
    assert set(reasons) == {"r3.csv", "r4.csv", "turn.csv"}
    assert reasons["r3.csv"].startswith("trial r3 has 40 samples")
    assert reasons["r4.csv"].startswith("contradicts itself; correct it, then take it out of exclude: ")
    assert reasons["turn.csv"] == (
        "it is a rotation and most files are a translation: it needs a config of its own"
    )
    assert done.trials == 3
    assert len(planned(load(done.path)).entries) == 3
    assert "    # contradicts itself; correct it" in done.path.read_text()


def test_names_that_do_not_fit_together_give_no_conditions(tmp_path: Path) -> None:
    for at, name in enumerate(("Kurz_a", "kurz_b", "Kurz_c", "kurz_d")):
        write_table(tmp_path / f"{name}.csv", recorded(0.04, at), "time_s,disp_m,acc_mps2")
    done = start(tmp_path)
    assert load(done.path).trials.group_by == ()
    assert "# File names give no conditions that fit together (the condition spring is" in done.path.read_text()


@pytest.mark.parametrize("name", ["sub folder", "[x]"])
def test_files_in_folders_and_of_awkward_names_are_found(tmp_path: Path, name: str) -> None:
    (tmp_path / name).mkdir()
    write_table(tmp_path / name / "a [1] 'b'.csv", recorded(0.04, 0), "time_s,disp_m,acc_mps2")
    write_table(tmp_path / "plain.CSV", recorded(0.05, 1), "time_s,disp_m,acc_mps2")
    (tmp_path / "runs").mkdir()
    write_table(tmp_path / "runs" / "trials.csv", recorded(0.04, 0), "time_s,disp_m,acc_mps2")
    assert len(planned(load(start(tmp_path).path)).entries) == 2


def test_columns_that_may_be_other_trials_are_said_with_the_one_taken(capsys: Capture, tmp_path: Path) -> None:
    trials = [recorded(0.03 + 0.01 * at, at) for at in range(3)]
    table = np.column_stack([trials[0][:, 0], *(1e3 * one[:, 1] for one in trials)])
    write_table(tmp_path / "all.csv", table, "t [s],x1 [mm],x2 [mm],x3 [mm]")
    said = undertow(capsys, "init", tmp_path)
    assert said.code == 0
    assert "column 'x3 [mm]' is taken, which moves furthest; 'x1 [mm]', 'x2 [mm]' look like it" in said.out
    assert "save each with the time as a file of its own" in said.out


def test_a_unit_that_no_file_says_is_assumed_and_said_on_the_terminal(capsys: Capture, tmp_path: Path) -> None:
    write_table(tmp_path / "r1.csv", recorded(0.04, 0)[:, :2], "time,disp")
    said = undertow(capsys, "init", tmp_path)
    assert said.code == 0
    assert "  guessed: displacement: column 'disp' says no unit; m is assumed" in said.out


def test_trials_one_below_another_are_said_with_how_to_split_them(capsys: Capture, tmp_path: Path) -> None:
    trials = [np.column_stack([np.full(len(one), at + 1.0), one]) for at, one in enumerate([recorded(0.04, 0)] * 3)]
    write_table(tmp_path / "all.csv", np.concatenate(trials), "trial,t [s],disp [m],acc [m/s^2]")
    said = undertow(capsys, "init", tmp_path)
    assert said.code == 2
    assert "all.csv: holds 3 trials one below another (by column 'trial'): split it into files" in said.err
    assert """for n, one in table.groupby('trial'): one.to_csv(f"trial_{n}.csv", index=False)""" in said.err
    write_table(tmp_path / "all.csv", np.concatenate(trials)[:, 1:], "t [s],disp [m],acc [m/s^2]")
    said = undertow(capsys, "init", tmp_path)
    assert "no column of numbers counts them" in said.err
    assert "table.groupby((table['t [s]'].diff() < 0).cumsum())" in said.err


def test_where_no_trial_agrees_with_the_config_it_is_written_to_be_corrected(capsys: Capture, tmp_path: Path) -> None:
    write_table(tmp_path / "r1.csv", recorded(0.04, 0) * [1.0, 1e3, 1.0], "time,disp,acc")
    said = undertow(capsys, "init", tmp_path)
    assert said.code == 1
    assert "take it out of exclude" not in said.err
    assert "displacement seems to be in mm, not m; correct recordings.channels.displacement.unit" in said.err
    path = tmp_path / "undertow.yaml"
    assert f"{path} is written with all of them: correct it there, then undertow run {path}" in said.err
    assert "(guessed: displacement: column 'disp' says no unit; m is assumed; " in said.err
    text = path.read_text()
    assert text.startswith("# Proposed by `undertow init` from the files. Correct it first, no trial can be used:")
    assert "runs as it is" not in text
    path.write_text(path.read_text().replace("{column: disp, unit: m}", "{column: disp, unit: mm}"))
    config = load(path)
    assert Checker(config, config.catalogue())(planned(config).entries[0]).contradiction == ""


def test_a_text_that_is_no_table_is_not_what_is_blamed(tmp_path: Path) -> None:
    (tmp_path / "LICENSE.txt").write_text("Permission is granted\n" * 9)
    (tmp_path / "swing.txt").write_text("".join(f"{(-0.5) ** at}\n" for at in range(9)))
    lacks = r"2 files looked at\); swing\.txt: no column is named .*; 9 rows, 1 columns without names.*rate_hz"
    with pytest.raises(ConfigError, match=lacks):
        start(tmp_path)
    (tmp_path / "swing.txt").unlink()
    with pytest.raises(ConfigError, match=r"LICENSE\.txt: no table of numbers begins in its first 9 lines"):
        start(tmp_path)


def test_two_columns_without_names_are_time_and_displacement_where_the_first_rises_evenly(
    capsys: Capture, tmp_path: Path
) -> None:
    for at in range(3):
        table = recorded(0.04, at)[:, :2]
        np.savetxt(tmp_path / f"r{at}.txt", table, fmt="%.7g")
    said = undertow(capsys, "init", tmp_path)
    assert said.code == 0
    assert "columns have no names: 0, which rises evenly, is taken as the time in s and 1 as disp" in said.out
    config = load(tmp_path / "undertow.yaml")
    assert Checker(config, config.catalogue())(planned(config).entries[0]).contradiction == ""
    (tmp_path / "undertow.yaml").unlink()
    table[20, 0] = table[19, 0]  # a clock that stands still is none
    for at in range(3):
        np.savetxt(tmp_path / f"r{at}.txt", table, fmt="%.7g")
    with pytest.raises(ConfigError, match=r"2 columns without names: 0 \(0 to .*\), 1 "):
        start(tmp_path)
    table[:, 0] = np.arange(len(table))
    for at in range(3):
        np.savetxt(tmp_path / f"r{at}.txt", table, fmt="%.7g")
    with pytest.raises(ConfigError, match=r"no column looks like time: give channels.time: \{rate_hz: \.\.\.\}"):
        start(tmp_path)


def test_a_folder_of_driven_records_has_a_config_that_runs_as_it_is(capsys: Capture, tmp_path: Path) -> None:
    """A driven record does not decay: tried as a decay none could be used, and the run took all of them."""
    for seed in (1, 2):
        force = np.convolve(np.random.default_rng(seed).standard_normal(3000), np.hanning(30), "same")
        rows, x, v = [], 0.0, 0.0
        for at, f in enumerate(force):
            rows.append((0.01 * at, f, 1e3 * x))
            v += 0.01 * (f - 20.0 * v - 900.0 * x) / 12.0
            x += 0.01 * v
        write_table(tmp_path / f"r{seed}.csv", np.array(rows), "t [s],force [N],x [mm]")
    still = np.array(rows) * [1.0, 0.0, 1.0]
    write_table(tmp_path / "r3.csv", still, "t [s],force [N],x [mm]")
    said = undertow(capsys, "init", tmp_path)
    assert said.code == 0, said.err
    assert re.search(r": 2 trials in .*; 1 file left out:\n  r3.csv: ", said.out)
    assert "next: look at the equation's terms" in said.out
    config = load(tmp_path / "undertow.yaml")
    assert config.equation.terms == ("stiffness", "viscous_damping", "constant_force")
    assert config.identify == ("output_error",)
    assert [entry.name for entry in planned(config).entries] == ["r1", "r2"]


def test_bodies_of_other_periods_are_groups_of_their_own(capsys: Capture, tmp_path: Path) -> None:
    for at, (name, slower) in enumerate((("axial", 1.0), ("radial", 3.0))):
        write_table(tmp_path / f"wheel_{name}_swing.csv", recorded(0.04, at)[:, :2] * [slower, 1.0], "t [s],disp [m]")
    said = undertow(capsys, "init", tmp_path)
    assert said.code == 0, said.err
    assert "  guessed: trials swing at periods from 0.993 to 2.98 s" in said.out
    assert ": groups go by label too" in said.out
    assert "group_by: [label]" in (tmp_path / "undertow.yaml").read_text()


@pytest.fixture(params=["versuche.csv", "list.xlsx", "numbers.csv"])
def listed(request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """Six recordings in a folder below an index, one file that it does not name, and one that is not there."""
    (tmp_path / "data").mkdir()
    for at in range(7):
        write_table(tmp_path / "data" / f"v{at + 1}.csv", recorded(0.03 + 0.01 * (at % 3), at), "t,x,a")
    kind = request.param
    names = [f"v{at + 1}" if kind == "numbers.csv" else f"data/v{at + 1}.csv" for at in range(7) if at != 3]
    names += ["v9" if kind == "numbers.csv" else "data/v9.csv"]
    rows = [
        {("test" if kind == "numbers.csv" else "file"): name, "no": at + 1, "depth_m": "0,0" if at < 3 else "1,2",
         "spring": "soft" if at % 2 else "stiff", "x0_mm": 30 + 10 * (at % 3)}
        for at, name in enumerate(names)
    ]  # fmt: skip
    if kind == "numbers.csv":
        for path in (tmp_path / "data").iterdir():
            path.rename(tmp_path / path.name)
    table = pd.DataFrame(rows)
    if kind == "list.xlsx":
        table.to_excel(tmp_path / kind, index=False)
    else:
        table.to_csv(tmp_path / kind, sep=";", index=False)
    return tmp_path


@pytest.mark.parametrize("water", ["Wassertiefe [cm]", "water level (cm)", "Wasserstand [cm]"])
def test_a_column_of_the_index_with_its_unit_parts_dry_trials_from_those_in_water(tmp_path: Path, water: str) -> None:
    """Its name was passed over, dry trials and those in water were one group, and nothing was said of it."""
    for at in range(6):
        write_table(tmp_path / f"v{at}.csv", recorded(0.03 + 0.01 * (at % 3), at), "t,x,a")
    rows = [{"file": f"v{at}.csv", water: 0 if at < 3 else 120, "rope": "new" if at % 2 else "old"} for at in range(6)]
    pd.DataFrame(rows).to_csv(tmp_path / "list.csv", index=False)
    done = start(tmp_path)
    config = load(done.path)
    assert config.trials.group_by == (water,)
    assert config.trials.dry == {water: 0}
    assert planned(config).entries
    assert "list.csv: rope differs among trials; no group goes by it (trials.group_by)" in done.doubts
    assert "# list.csv: rope differs among trials" in done.path.read_text("utf-8")


def test_the_index_of_a_folder_gives_trials_and_conditions(listed: Path) -> None:
    """It had been left out as no recording, and dry trials and those in water were one group."""
    done = start(listed)
    config = load(done.path)
    index = config.recordings.index
    assert index in ("versuche.csv", "list.xlsx", "numbers.csv")
    assert config.trials.group_by == ("depth_m", "spring")
    assert config.trials.dry == {"depth_m": 0.0}
    assert {"added_mass", "quadratic_drag"} <= set(config.equation.terms)
    entries = planned(config).entries
    assert [entry.name for entry in entries] == ["v1", "v2", "v3", "v5", "v6", "v7"]
    assert [entry.conditions["depth_m"] for entry in entries] == [0.0] * 3 + [1.2] * 3
    left_out = dict(done.left_out)
    below = "" if index == "numbers.csv" else "data/"
    assert left_out[f"{below}v4.csv"] == f"is not in the index {index}"
    assert "is not there" in left_out[f"{below}v9.csv"]


def test_a_condition_of_the_index_that_parts_bodies_parts_groups(tmp_path: Path) -> None:
    for at in range(4):
        table = recorded(0.04, at)
        table[:, 0] *= 1.5 if at > 1 else 1.0
        write_table(tmp_path / f"v{at}.csv", table[:, :2], "t,x")
    rows = [f"v{at}.csv,{[3.5, 3.5, 7, 7][at]},{at}" for at in range(4)]
    (tmp_path / "trials.csv").write_text("\n".join(["recording,ballast_kg,run", *rows]), encoding="utf-8")
    done = start(tmp_path)
    config = load(done.path)
    assert (config.recordings.index_column, config.trials.group_by) == ("recording", ("ballast_kg",))
    assert "groups go by ballast_kg too" in done.path.read_text("utf-8")


@pytest.mark.parametrize(
    ("column", "shared"),
    [("Wasser_tiefe", True), ("water", True), ("rig", True), ("right_mm", False), ("filler", False), ("x0_mm", False)],
)
def test_names_of_columns_say_what_groups_share(tmp_path: Path, column: str, shared: bool) -> None:
    for at in range(4):
        (tmp_path / f"v{at}.csv").write_text("t,x", encoding="utf-8")
    rows = [f"v{at}.csv,{at % 2 + 1}" for at in range(4)]
    (tmp_path / "trials.csv").write_text("\n".join([f"file,{column}", *rows]), encoding="utf-8")
    found = find_index(tmp_path, [f"v{at}.csv" for at in range(4)] + ["trials.csv"])
    assert found is not None
    assert found.named.group_by == ((column,) if shared else ())


def test_a_cell_of_the_index_that_is_empty_leaves_out_its_trial_and_not_the_column(tmp_path: Path) -> None:
    """All trials had been one group, dry or not, and nothing was said of it."""
    for at in range(6):
        write_table(tmp_path / f"v{at}.csv", recorded(0.03 + 0.005 * at, at)[:, :2], "t,x")
    rows = [f"v{at}.csv,{[0, 0, 1.2, '', 1.2, 0][at]},{at or ''}" for at in range(6)]
    (tmp_path / "trials.csv").write_text("\n".join(["file,depth_m,run", *rows]), encoding="utf-8")
    done = start(tmp_path)
    config = load(done.path)
    assert config.trials.group_by == ("depth_m",)
    assert config.trials.dry == {"depth_m": 0.0}
    assert dict(done.left_out) == {
        "v3.csv": "trials.csv has no depth_m for it; fill that cell in, and take the file out of recordings.exclude"
    }
    assert [entry.name for entry in planned(config).entries] == ["v0", "v1", "v2", "v4", "v5"]


@pytest.mark.parametrize(
    ("header", "said"),
    [("t [s],x [foo]", r"r1.csv: displacement: unit 'foo' is not known; .* \(column 'x \[foo\]'\)"),
     ("t [s],a [m/s^2]", r"r1.csv: no column is named like .*; an acceleration integrated twice drifts away from")],
)  # fmt: skip
def test_why_no_column_says_where_the_body_is(tmp_path: Path, header: str, said: str) -> None:
    write_table(tmp_path / "r1.csv", recorded(0.04, 0)[:, :2], header)
    with pytest.raises(ConfigError, match=said):
        start(tmp_path)


def test_an_old_spreadsheet_is_said_to_be_left_out_with_what_to_save_it_as(tmp_path: Path) -> None:
    (tmp_path / "r1.xls").write_bytes(b"\xd0\xcf")
    with pytest.raises(ConfigError, match=r"\(1 file looked at\); r1.xls: no reader for '.xls'; save it as .xlsx"):
        start(tmp_path)


def test_a_file_that_is_never_read_is_said_to_be_left_out(capsys: Capture, tmp_path: Path) -> None:
    for at in range(2):
        write_table(tmp_path / f"v{at}.csv", recorded(0.04, at)[:, :2], "t,x")
    (tmp_path / "v2.npz").write_bytes(b"PK")
    why = ".npz can carry code and is never read; save it as CSV, MAT or HDF5"
    assert dict(start(tmp_path).left_out) == {"v2.npz": why}
    alone = tmp_path / "alone"
    alone.mkdir()
    (tmp_path / "v2.npz").rename(alone / "v2.npz")
    with pytest.raises(ConfigError, match=rf"alone can be read as a recording \(1 file looked at\); v2.npz: {why}"):
        start(alone)


def test_a_table_that_names_a_few_recordings_is_no_index(tmp_path: Path) -> None:
    for at in range(4):
        write_table(tmp_path / f"v{at}.csv", recorded(0.04, at), "t,x,a")
    notes = ["who;what", "me;v1.csv", "you;v2.csv", *(f"us;tea {at}" for at in range(5))]
    (tmp_path / "notes.csv").write_text("\n".join(notes), encoding="utf-8")
    done = start(tmp_path)
    assert load(done.path).recordings.index is None
    assert done.trials == 4


def test_a_folder_that_cannot_be_begun_with_is_said(capsys: Capture, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"nowhere is no folder; give the one that holds the recordings"):
        start(tmp_path / "nowhere")
    with pytest.raises(ConfigError, match=r"holds no file with the suffix of a recording, as \.csv"):
        start(tmp_path)
    (tmp_path / "a.csv").write_text("blue,green\n1,2\n2,4\n3,7\n4,3\n")
    with pytest.raises(ConfigError, match=r"no file in .* can be read as .* \(1 file looked at\); a\.csv: no column"):
        start(tmp_path)
    write_table(tmp_path / "b.csv", recorded(0.04, 1)[:20], "time_s,disp_m,acc_mps2")
    with pytest.raises(UndertowError, match=r"none of 1 trials in .* can be used; b\.csv: trial b has 20 samples"):
        start(tmp_path)
    with pytest.raises(ConfigError, match=r"must lie in .*: its paths are relative to it; give a name there"):
        start(tmp_path, tmp_path / "elsewhere" / "c.yaml")
    (tmp_path / "undertow.yaml").write_text("name: mine\n")
    said = undertow(capsys, "init", tmp_path)
    assert said.code == 2
    assert "undertow.yaml is there already and is not overwritten; move it away or give another with --out" in said.err


def test_inspect_saves_the_config_that_it_proposes(capsys: Capture, tmp_path: Path) -> None:
    write_table(tmp_path / "r1.csv", recorded(0.04, 0), "time_s,disp_m,acc_mps2")
    said = undertow(capsys, "inspect", tmp_path / "r1.csv", "--save")
    assert said.code == 0
    assert f"written: {tmp_path / 'r1.yaml'}" in said.err
    config = load(tmp_path / "r1.yaml")
    assert [entry.name for entry in planned(config).entries] == ["r1"]
    again = undertow(capsys, "inspect", tmp_path / "r1.csv", "--save")
    assert again.code == 1
    assert "r1.yaml is there already and is not overwritten; move it away" in again.err
    still = recorded(0.04, 0)
    still[:, 1:] = 1e-3 * np.random.default_rng(1).standard_normal((len(still), 2))
    write_table(tmp_path / "still.csv", still, "time_s,disp_m,acc_mps2")
    none = undertow(capsys, "inspect", tmp_path / "still.csv", "--save")
    assert none.code == 1
    assert "still.csv: no config is proposed, so that none is saved; see what stands above" in none.err
    assert not (tmp_path / "still.yaml").exists()
