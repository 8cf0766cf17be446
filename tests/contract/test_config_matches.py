"""A config that names what is not there, through the command: a sentence and exit 2; a level or trial that fails: 3."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from tests.command_line import Said, undertow
from tests.small_campaign import Campaign, make_campaign
from undertow.campaign.run import folder

Capture = pytest.CaptureFixture[str]

DONE, USAGE, SOME_FAILED = 0, 2, 3
LEVELS = ("1.63", "2.22", "2.36")
SPECIMEN = """\
  mass_kg: 2637.4
  area_m2: {by: depth_m, 2.22: 0.97, 2.36: 0.97}
  submerged_volume_m3: {by: depth_m, 2.22: 0.09, 2.36: 0.28}
"""


@pytest.fixture
def campaign(tmp_path: Path) -> Campaign:
    """Three releases dry and at each of two levels: the files r00 to r08."""
    made = make_campaign(tmp_path / "campaign", [0.03, 0.04, 0.05], springs=LEVELS)
    index = made.folder / "campaign.csv"
    index.write_text(index.read_text().replace("spring", "depth_m"))
    made.edit("group_by: [spring]", "group_by: [depth_m]\n  dry: {depth_m: 1.63}")
    made.edit("  mass_kg: 2637.4\n", SPECIMEN)
    return made


@pytest.fixture(autouse=True)
def without_page(monkeypatch: pytest.MonkeyPatch) -> None:
    """The page takes most of a small run's time, and nothing here looks at it."""
    monkeypatch.setattr(folder, "write_report", lambda *_: None)


def run(capsys: Capture, campaign: Campaign, *words: str) -> Said:
    return undertow(capsys, "run", campaign.config, "--out", campaign.folder / "run", "--jobs", 1, *words)


def verdicts(campaign: Campaign) -> dict[float, dict[str, Any]]:
    groups = json.loads((campaign.folder / "run" / "verdict.json").read_text())["groups"]
    return {group["group"]["depth_m"]: group for group in groups}


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("dry: {depth_m: 1.63}", "dry: {depth_m: 1.65}", r"line 10: trials\.dry says depth_m 1\.65, .* mean 1\.63\?"),
        ("  dry", "  hold_out: [r4935.csv.gz]\n  dry", r"line 10: trials\.hold_out names 'r4935\.csv\.gz', which fits"),
        ("  dry", "  hold_out: [r00, r01, r02]\n  dry", r"line 10: trials\.hold_out holds out all of 3 trials of the"),
        ("  channels:", '  exclude: ["*r99*"]\n  channels:', r"line 4: recordings\.exclude names '\*r99\*', which fit"),
        ("  channels:", '  accept: {"*99*": [unit]}\n  channels:', r"line 4: recordings\.accept names '\*99\*'"),
        ("  dry", '  window: {"*99*": {start_s: 1}}\n  dry', r"line 10: trials\.window names '\*99\*', which fits non"),
        ("group_by: [depth_m]", "group_by: [depth]", r"line 9: trials\.group_by names 'depth', .* mean depth_m\?"),
        ("m3: {by: depth_m, 2.22", "m3: {by: depth_m, 2.2", r"line 14: specimen\.submerged_volume_m3 has depth_m 2\.2"),
        ("mass_kg: 2637.4", "mass_kg: -5", r"line 12: specimen\.mass_kg is -5 kg but must be larger than 0"),
        ("2.36: 0.28", "2.36: 2.8", r"line 14: .* 2\.8 m\^3 for depth_m 2\.36: its buoyancy of 27468 N must be smalle"),
    ],
)
def test_a_run_stops_before_it_reads_anything(
    capsys: Capture, campaign: Campaign, old: str, new: str, sentence: str
) -> None:
    campaign.edit(old, new)
    said = run(capsys, campaign)
    assert said.code == USAGE
    assert re.search(rf"^undertow: config\.yaml {sentence}", said.err), said.err
    assert "read and condition" not in said.err
    assert said.out == ""
    assert not (campaign.folder / "run").exists()


@pytest.mark.parametrize(
    ("quantity", "old"), [("area_m2", "2.22: 0.97, "), ("submerged_volume_m3", "2.22: 0.09, ")]
)
def test_a_wet_level_that_a_table_leaves_out_fails_alone(
    capsys: Capture, campaign: Campaign, quantity: str, old: str
) -> None:
    campaign.edit(old, "")
    said = run(capsys, campaign)
    assert said.code == SOME_FAILED
    failed = [line for line in said.err.splitlines() if line.startswith("failed: ")]
    assert [line[8:11] for line in failed] == ["r03", "r04", "r05"]
    sentence = rf"specimen\.{quantity} has no value for depth_m 2\.22, it has 2\.36; add it to the table \(config"
    assert all(re.search(sentence, line) for line in failed), failed
    assert list(verdicts(campaign)) == [1.63, 2.36]
    trials = pd.read_csv(campaign.folder / "run" / "trials.csv")
    assert trials[trials.depth_m == 2.22].outcome.str.startswith("failed: specimen.").all()


def test_a_held_out_file_is_held_out_and_groups_without_one_are_noted(capsys: Capture, campaign: Campaign) -> None:
    campaign.edit("  dry", "  hold_out: [r03.csv, campaign/r04]\n  dry")
    assert run(capsys, campaign).code == DONE
    assert {level: group["held_out"] for level, group in verdicts(campaign).items()} == {
        1.63: [], 2.22: ["r03", "r04"], 2.36: []
    }  # fmt: skip
    notes = json.loads((campaign.folder / "run" / "manifest.json").read_text())["notes"]
    assert notes[0].startswith("trials.hold_out names no trial of 2 of 3 groups (depth_m 1.63; depth_m 2.36): what is")


def test_a_group_left_without_a_usable_trial_to_be_fitted_fails_alone(capsys: Capture, campaign: Campaign) -> None:
    campaign.edit("  dry", "  hold_out: [r03, r04]\n  dry")
    (campaign.folder / "r05.csv").unlink()
    said = run(capsys, campaign)
    assert said.code == SOME_FAILED
    assert "failed: trial r05: the index names 'r05.csv'" in said.err
    assert "trials.hold_out holds out all 2 trials that can be used (r03, r04), which leaves none to be" in said.err
    assert list(verdicts(campaign)) == [1.63, 2.36]


def test_a_trial_without_its_level_fails_alone(capsys: Capture, campaign: Campaign) -> None:
    index = campaign.folder / "campaign.csv"
    index.write_text(index.read_text().replace("r05.csv,2.22", "r05.csv,"))
    said = run(capsys, campaign)
    assert said.code == SOME_FAILED
    assert "failed: trial r05: it has no condition 'depth_m', by which trials.group_by goes; it has none" in said.err
    assert [len(group["trials"]) for group in verdicts(campaign).values()] == [3, 2, 3]


def test_an_index_with_decimal_commas_gives_the_same_numbers(capsys: Capture, campaign: Campaign) -> None:
    assert run(capsys, campaign).code == DONE
    before = pd.read_csv(campaign.folder / "run" / "trials.csv")
    index = campaign.folder / "campaign.csv"
    index.write_text(re.sub(r"(\d)\.(\d)", r"\1,\2", index.read_text().replace(",", ";")))
    assert run(capsys, campaign).code == DONE
    pd.testing.assert_frame_equal(pd.read_csv(campaign.folder / "run" / "trials.csv"), before)
