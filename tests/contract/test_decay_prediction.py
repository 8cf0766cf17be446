"""A finished campaign of decays, its equation run free on recordings and starts that nobody fitted."""

from __future__ import annotations

import json
import re
import shutil

import numpy as np
import pandas as pd
import pytest

import undertow
from experiments.eq15_campaign.motion import simulate as exact
from tests.command_line import undertow as command
from tests.small_campaign import BODY, NOISE_M, make_campaign, recorded, write_table
from undertow.campaign.run.folder import run_to_folder
from undertow.errors import ConfigError
from undertow.front.run_prediction import predict_run

AMPLITUDES = [0.03, 0.06]
LONG = {"spring": "long"}
NAMED = """\
name: small
recordings:
  files: "r*.csv"
  pattern: "r0(?P<number>[0-9])"
  channels:
    time: {column: t, unit: s}
    displacement: {column: x, unit: m}
"""
"""A campaign whose file names are its conditions."""


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A folder with a campaign of two springs, its run, and two recordings that are not in it."""
    folder = tmp_path_factory.mktemp("decays")
    made = make_campaign(folder, AMPLITUDES, springs=("long", "stiff"))
    made.edit("  mass_kg: 2637.4", "  mass_kg: 2637.4\n  scatter: {k: 0.0005, c: 0.02, mu: 0.02}")
    run_to_folder(made.config, out=folder / "run", jobs=1)
    write_table(folder / "inside.csv", recorded(0.045, 71))
    write_table(folder / "beyond.csv", recorded(0.09, 72))
    return folder


def test_equations_json_holds_every_groups_laws_with_their_errors(finished):
    groups = json.loads((finished / "run" / "equations.json").read_text())["groups"]
    assert [group["group"] for group in groups] == [{"spring": "long"}, {"spring": "stiff"}]
    rows = {row["term"]: row for row in groups[0]["versions"]["baseline"]["rows"]}
    # in newtons: the config states the mass, and the equation has no added mass
    assert rows["stiffness"]["value"] == pytest.approx(BODY.k_N_per_m, rel=2e-3)
    assert 0.0 < rows["stiffness"]["stderr"] < 0.01 * rows["stiffness"]["value"]
    assert rows["coulomb_friction"]["relative_to"] == "base"
    assert groups[0]["scatter"] == {"k": 0.0005, "c": 0.02, "mu": 0.02}
    assert groups[0]["noise"] == pytest.approx(NOISE_M, rel=0.2)


@pytest.mark.parametrize("name", ["inside.csv", "beyond.csv"])
def test_a_decay_nobody_fitted_lies_in_the_band(finished, name):
    made = predict_run(finished / "run", finished / name, group=LONG, out=finished / "p.csv")
    table = pd.read_csv(finished / "p.csv")
    assert list(table.columns) == ["time_s", "measured", "predicted", "lower", "upper", "used"]
    assert len(table) == len(pd.read_csv(finished / name))
    assert 30 < table["used"].sum() < 60  # half a second of hold
    assert made.rms < 0.03 * np.std(table["measured"])
    assert made.covered > 0.8
    # the band is of the order of what is missed, not of the motion
    assert np.mean(table["upper"] - table["lower"]) < 0.2 * np.std(table["measured"])


def test_an_opened_group_says_moves_and_is_scored_as_any_found_equation(finished):
    group = undertow.open(finished / "run")["spring stiff"]
    assert [term.name for term in group.equation.terms] == ["stiffness", "viscous_damping", "coulomb_friction"]
    assert group.equations()[0].startswith("2637.4 x'' + 109")
    assert len(group.equations()[0]) < 60  # digits as the errors allow
    motion = group.simulate(0.05, duration_s=3.0, rate_hz=200.0)
    assert motion.x == pytest.approx(exact(BODY, 0.05, motion.t).x, abs=1e-4)
    ahead = group.predict(x0=0.05, duration_s=3.0, rate_hz=200.0).run.predicted
    assert ahead[:600] == pytest.approx(motion.x[:600], abs=1e-6)
    columns = {"time": "t", "displacement": "x"}
    unseen = undertow.read(str(finished / "inside.csv"), columns=columns, units={"displacement": "m"})
    assert group.score(unseen) == pytest.approx(group.score(), abs=0.01)
    assert 0.95 < group.score() == 1.0 - group.row["error"]  # nobody named anything, no trial was held out
    assert "def simulate" in group.to_python()


def test_nothing_after_the_hold_moves_a_prediction(finished):
    table = pd.read_csv(finished / "inside.csv")
    late = table.copy()
    late.loc[late["t"] > 2.0, "x"] *= 0.9
    late.to_csv(finished / "late.csv", index=False)
    seen, other = (predict_run(finished / "run", finished / f"{n}.csv", group=LONG).run for n in ("inside", "late"))
    early = seen.t < 1.0
    # the release instant is the motion's own, found from its first swing
    assert np.max(np.abs(seen.predicted[early] - other.predicted[early])) < 5.0 * NOISE_M


def test_a_decay_never_tested_is_predicted_from_its_start(finished):
    made = undertow.open(finished / "run").predict(x0=0.07, duration_s=3.0, rate_hz=200.0, group=LONG)
    assert made.run.predicted[0] == pytest.approx(0.07)
    assert made.run.t.size == 601
    assert np.isnan(made.rms)
    assert np.all(made.run.lower < made.run.upper)
    assert made.csv().splitlines()[1].startswith("0,,0.07,")


def test_a_recording_of_any_name_is_predicted_by_a_run_whose_file_names_are_conditions(finished, capsys):
    """With the group said nothing is asked of the name; brackets in it are no wildcards."""
    (finished / "named.yaml").write_text(NAMED)
    shutil.copy(finished / "inside.csv", finished / "new [1].csv")
    words = ("--group", "long", "--config", finished / "named.yaml")
    assert command(capsys, "predict", finished / "run", "--recording", finished / "new [1].csv", *words).code == 0


def test_a_prediction_does_not_replace_the_recording(finished):
    file = finished / "inside.csv"
    before = file.read_bytes()
    with pytest.raises(ConfigError, match=r"the table would replace the recording .*inside\.csv"):
        predict_run(finished / "run", file, group=LONG, out=str(file))
    assert file.read_bytes() == before


def test_a_start_beside_a_recording_is_refused(finished, capsys):
    file = finished / "inside.csv"
    said = command(capsys, "predict", finished / "run", "--recording", file, "--x0", "99", "--rate", "3")
    assert said.code == 2
    assert f"--x0 99 --rate 3 beside the recording {file}, which has its own; give one of the two" in said.err
    with pytest.raises(ConfigError, match=r"--duration 1 beside the recording .*, which has its own; give one"):
        predict_run(finished / "run", file, duration_s=1.0)


def test_the_command_predicts_decays(finished, capsys):
    seen = ("--recording", finished / "inside.csv", "--group", "spring=long")
    said = command(capsys, "predict", finished / "run", *seen)
    assert said.code == 0
    assert said.out.rstrip().splitlines()[-1].startswith("rms 0.000")
    assert said.out.rstrip().endswith(" m")
    assert repr(predict_run(finished / "run", finished / "inside.csv", group=LONG)) == said.out.rstrip()
    words = ("--x0", "0.05", "--duration", "2", "--rate", "50", "--group", "spring=stiff", "--out", finished / "n.csv")
    assert command(capsys, "predict", finished / "run", *words).code == 0
    assert len(pd.read_csv(finished / "n.csv")) == 101


def test_a_start_without_a_recording_prints_what_the_motion_is_like(finished, capsys):
    words = ("--duration", "6", "--rate", "50", "--group", "spring=stiff")
    said = command(capsys, "predict", finished / "run", "--x0", "0.05", *words)
    made = predict_run(finished / "run", x0=0.05, duration_s=6.0, rate_hz=50.0, group={"spring": "stiff"})
    table = made.run
    assert said.out == f"{made!r}\n"
    assert said.out.startswith("peak 0.05 m\nperiod ")
    turns = np.count_nonzero((table.predicted[:-1] < 0.0) & (table.predicted[1:] >= 0.0))
    assert f"s (mean of {turns - 1}); last swing 0.0" in said.out
    assert "90 % band: +- " in said.out


def test_a_rate_that_does_not_show_the_motion_is_said_with_the_one_that_does(finished, capsys):
    """Two samples a second alias the swing to a period that is not its own."""
    words = ("predict", finished / "run", "--x0", "0.05", "--duration", "6", "--group", "spring=stiff")
    fine, coarse = command(capsys, *words, "--rate", "50"), command(capsys, *words, "--rate", "2")
    assert coarse.code == 0
    period = float(re.search(r"period ([0-9.]+) s \(mean of", fine.out).group(1))
    said = re.search(r"period ([0-9.]+) s by the equation: these samples are too few to show it", coarse.out)
    assert float(said.group(1)) == pytest.approx(period, rel=1e-3)
    needed = re.search(r"too few samples: 2 samples a second are .*: give --rate ([0-9.]+) or more", coarse.err)
    assert 8.0 <= float(needed.group(1)) * period <= 8.0 + 0.1 * period
    assert "too few" not in fine.err + fine.out
    assert "too few" not in command(capsys, *words, "--rate", needed.group(1)).err


def test_a_recording_that_was_fitted_or_is_of_another_group_is_said(finished, capsys):
    index = pd.read_csv(finished / "campaign.csv")
    file = finished / index["file"][list(index["spring"]).index("stiff")]
    own = command(capsys, "predict", finished / "run", "--recording", file)
    assert own.code == 0
    assert re.search(r"^note: r\d+ is one of the trials that this equation was fitted to: how well", own.err)
    lines = own.out.splitlines()
    assert re.fullmatch(r"rms over the motion's own rms: [0-9.]+ %", lines[-2])
    assert re.fullmatch(r"rms [0-9.e-]+ m", lines[-1])
    other = command(capsys, "predict", finished / "run", "--recording", file, "--group", "spring=long")
    assert re.search(r"note: .* is of spring stiff by its name .* by the equation of spring long, as", other.err)
    assert "fitted to" not in other.err
    new = command(capsys, "predict", finished / "run", "--recording", finished / "inside.csv", "--group", "long")
    assert new.err == ""


def test_a_recording_that_was_held_out_is_not_said_to_be_fitted(finished, capsys, tmp_path):
    run = tmp_path / "run"
    shutil.copytree(finished / "run", run)
    index = pd.read_csv(finished / "campaign.csv")
    file = finished / index["file"][0]
    words = ("predict", run, "--recording", file)
    assert "fitted to" in command(capsys, *words).err
    said = json.loads((run / "verdict.json").read_text())
    for group in said["groups"]:
        group["held_out"] = [name for name in group["trials"] if name == file.stem]
    (run / "verdict.json").write_text(json.dumps(said))
    assert "fitted to" not in command(capsys, *words).err


def test_a_table_is_not_written_under_a_name_of_another_format(finished):
    with pytest.raises(ConfigError, match=r"--out is .*o\.xlsx and the table is written as CSV; .*, as o\.csv"):
        predict_run(finished / "run", x0=0.05, duration_s=2.0, rate_hz=50.0, group=LONG, out=finished / "o.xlsx")


def test_a_start_beyond_what_was_tested_is_said(finished, capsys):
    words = ("--duration", "2", "--rate", "50", "--group", "spring=stiff")
    largest = max(AMPLITUDES)
    inside = command(capsys, "predict", finished / "run", "--x0", 1.05 * largest, *words)
    assert "beyond" not in inside.err
    beyond = command(capsys, "predict", finished / "run", "--x0", 100.0 * largest, *words)
    assert beyond.code == 0
    assert re.search(r"beyond what was tested: it starts at .* m, 1?[0-9.]+ times the largest amplitude", beyond.err)


def test_a_recording_that_the_run_lists_is_predicted_by_the_group_of_its_conditions(finished):
    index = pd.read_csv(finished / "campaign.csv")
    for file, spring in zip(index["file"], index["spring"], strict=True):
        made = predict_run(finished / "run", finished / file)
        said = predict_run(finished / "run", finished / file, group={"spring": spring})
        assert made.label == said.label
        assert made.rms == said.rms
    assert set(index["spring"]) == {"long", "stiff"}


def test_a_run_whose_index_is_gone_asks_for_the_group(finished):
    index = finished / "campaign.csv"
    aside = index.rename(finished / "aside.csv")
    try:
        with pytest.raises(ConfigError, match=r"gives .* no conditions; say --group"):
            predict_run(finished / "run", finished / "r01.csv")
    finally:
        aside.rename(index)


def test_a_group_or_a_start_that_is_not_said_stops_with_what_there_is(finished):
    nothing = r"has 2 groups and its list of trials gives .*inside\.csv no conditions; say --group, one of: spring=long"
    with pytest.raises(ConfigError, match=nothing):
        predict_run(finished / "run", finished / "inside.csv")
    with pytest.raises(ConfigError, match="the run has 2 groups and no conditions are given; say --group, one of"):
        predict_run(finished / "run", x0=0.05, duration_s=2.0, rate_hz=50.0)
    with pytest.raises(ConfigError, match="0 groups of the run have spring soft; say --group"):
        predict_run(finished / "run", finished / "inside.csv", group={"spring": "soft"})
    with pytest.raises(ConfigError, match=r"^--duration is not given, or no number; a decay .* needs all of --x0"):
        predict_run(finished / "run", x0=0.05, rate_hz=50.0, group=LONG)
    with pytest.raises(ConfigError, match=r"^--duration and --rate are not given"):
        predict_run(finished / "run", x0=0.05, group=LONG)
    with pytest.raises(ConfigError, match=r"neither a recording nor a start is given; give --recording, or --x0"):
        predict_run(finished / "run", group=LONG)
    with pytest.raises(ConfigError, match=r"--rate is -5 Hz; give one above zero"):
        predict_run(finished / "run", x0=0.05, duration_s=2.0, rate_hz=-5.0, group=LONG)
    with pytest.raises(ConfigError, match=r"a decay of 1e\+09 s at 50 Hz has 5e\+10 samples; at most 1000000"):
        predict_run(finished / "run", x0=0.05, duration_s=1e9, rate_hz=50.0, group=LONG)
    with pytest.raises(ConfigError, match=r"nowhere.csv is not there"):
        predict_run(finished / "run", finished / "nowhere.csv")
    with pytest.raises(ConfigError, match="no group fits 'soft'; say one of: spring "):
        predict_run(finished / "run", x0=0.05, duration_s=2.0, rate_hz=50.0, group="soft")
    with pytest.raises(ConfigError, match="2 groups fit 'spring'; say one of: spring "):
        predict_run(finished / "run", x0=0.05, duration_s=2.0, rate_hz=50.0, group="spring")


def test_words_that_one_group_fits_are_its_conditions(finished):
    said = predict_run(finished / "run", x0=0.05, duration_s=2.0, rate_hz=50.0, group="Spring long")
    assert said.label == predict_run(finished / "run", x0=0.05, duration_s=2.0, rate_hz=50.0, group=LONG).label
