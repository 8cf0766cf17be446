"""Channels that contradict each other, through the command: exit codes, sentences, the page's first screen."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from tests.command_line import Said, undertow
from tests.small_campaign import Campaign, make_campaign, recorded, write_table

Capture = pytest.CaptureFixture[str]
DONE, USAGE, SOME_FAILED = 0, 2, 3
MARKUP = "<script>alert(1)"


@pytest.fixture
def campaign(tmp_path: Path) -> Campaign:
    """Two springs of three trials; the second one's name holds markup."""
    return make_campaign(tmp_path / "c", [0.03, 0.04, 0.05], springs=("long", f"stiff{MARKUP}"))


def run(capsys: Capture, campaign: Campaign) -> Said:
    return undertow(capsys, "run", campaign.config, "--out", campaign.folder / "run", "--jobs", 1)


def spoil(campaign: Campaign, factor: float, *names: str) -> None:
    for name in names:
        table = recorded(0.03 + 0.01 * (int(name[1:]) % 3), int(name[1:]))
        table[:, 2] *= factor
        write_table(campaign.folder / f"{name}.csv", table)


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("unit: m/s^2}", "unit: g}", r"acceleration seems to be in m/s\^2, not g"),
        ("unit: m/s^2}", "unit: m/s^2, sign: -1}", r"the sign of acceleration seems turned over"),
        ("{column: x, unit: m}", "{column: x, unit: mm}", r"displacement seems to be in m, not mm"),
        ("{column: t, unit: s}", "{column: t, unit: ms}", r"time seems to be in s, not ms"),
        ("displacement: {column: x, unit: m}\n    acceleration: {column: a,",
         "displacement: {column: a, unit: m}\n    acceleration: {column: x,",
         r"the columns of displacement and acceleration seem swapped"),
    ],
)  # fmt: skip
def test_a_mistake_in_the_channels_of_every_group_stops_the_run_before_it_fits(
    capsys: Capture, campaign: Campaign, old: str, new: str, sentence: str
) -> None:
    campaign.edit(old, new)
    said = run(capsys, campaign)
    assert said.code == USAGE
    assert re.search(r"undertow: the channels of every group contradict each other; correct the config", said.err)
    assert len(re.findall(sentence, said.err)) == 2  # one trial a group
    assert "identification" not in said.err
    assert not (campaign.folder / "run" / "verdict.json").exists()


def test_a_clock_without_a_unit_that_may_be_of_milliseconds_is_doubted_unless_accepted_or_said(
    capsys: Capture, campaign: Campaign
) -> None:
    """`init` asked whether it is ms, and the run of the config that it had written said nothing."""
    campaign.edit("    acceleration: {column: a, unit: m/s^2}\n", "")
    for at in range(6):
        fast = recorded(0.03 + 0.01 * (at % 3), at)[:, :2] * [250.0, 1.0]  # a period of a quarter of a second, in ms
        write_table(campaign.folder / f"r{at:02d}.csv", fast, "t,x")
    asked = "time: column 't' says no unit; s is assumed, a sample every 2.5 s: is it ms? correct recordings.channels.t"
    said = run(capsys, campaign)
    assert f"r00 and 2 more trials: {asked}" in said.out
    campaign.edit("    displacement:", "    acceleration: {column: a, unit: m/s^2}\n    displacement:")
    for at in range(6):
        table = recorded(0.03 + 0.01 * (at % 3), at) * [250.0, 1e3, 1.0]
        write_table(campaign.folder / f"r{at:02d}.csv", table, "t,x,a")
    assert asked in run(capsys, campaign).err  # beside what contradicts
    campaign.edit("    acceleration: {column: a, unit: m/s^2}\n", "")
    campaign.edit("recordings:\n", 'recordings:\n  accept: {"*": [unit]}\n')
    assert "is it ms?" not in run(capsys, campaign).out
    campaign.edit('  accept: {"*": [unit]}\n', "")
    campaign.edit("column: t,", "column: t_s,")
    for at in range(6):
        write_table(campaign.folder / f"r{at:02d}.csv", recorded(0.03, at)[:, :2] * [250.0, 1.0], "t_s,x")
    assert "is it ms?" not in run(capsys, campaign).out


def test_a_mass_in_tonnes_and_load_cells_in_kilonewtons_are_found_too(capsys: Capture, campaign: Campaign) -> None:
    for number in range(6):
        table = recorded(0.12 + 0.01 * (number % 3), number)
        force = 109.6 * table[:, 1] + 0.002 * np.random.default_rng(number).standard_normal(len(table))
        write_table(campaign.folder / f"r{number:02d}.csv", np.column_stack([table, force]), "t,x,a,f")
    campaign.edit("acceleration: {column: a, unit: m/s^2}",
                  "acceleration: {column: a, unit: m/s^2}\n    spring_force: {column: f, unit: N}")  # fmt: skip
    said = run(capsys, campaign)
    assert said.code == USAGE
    assert "spring_force seems to be in kN, not N" in said.err
    campaign.edit("unit: N}", "unit: kN}")
    campaign.edit("mass_kg: 2637.4", "mass_kg: 2.6374\n  stiffness_N_per_m: 109600")
    said = run(capsys, campaign)
    assert said.code == USAGE
    assert re.search(r"stated stiffness over stated mass is .* times the square of the motion's own", said.err)
    times = re.search(r"specimen\.mass_kg is ([0-9.]+) times what it should be", said.err)
    assert times is not None
    assert float(times[1]) == pytest.approx(1e-3, rel=0.002)


def test_one_group_that_contradicts_cannot_tell_and_the_other_is_finished(capsys: Capture, campaign: Campaign) -> None:
    spoil(campaign, 1.0 / 9.80665, "r03", "r04", "r05")
    spoil(campaign, -1.0, "r01")
    said = run(capsys, campaign)
    assert said.code == SOME_FAILED
    groups = json.loads((campaign.folder / "run/verdict.json").read_text())["groups"]
    verdicts = {group["group"]["spring"]: group for group in groups}
    stiff = verdicts[f"stiff{MARKUP}"]
    assert stiff["status"] == "cannot_tell"
    assert stiff["because"].startswith("the channels contradict each other in 3 of 3 trials (r03: acceleration is 0.10")
    assert "The equation misses" not in stiff["sentence"]  # nothing was looked for in it
    assert "contradict" not in verdicts["long"]["because"]
    assert verdicts["long"]["trials"] == ["r00", "r02"]
    assert "failed: trial r01: acceleration is -1 times the second derivative of the displacement" in said.err
    assert said.err.count("channels contradict each other: spring stiff") == 1


def test_doubts_stand_on_the_first_screen_escaped_and_in_the_terminal(capsys: Capture, campaign: Campaign) -> None:
    spoil(campaign, 1.08, "r03", "r04", "r05")
    said = run(capsys, campaign)
    assert said.code == DONE
    doubt = f"spring stiff{MARKUP}, r03 and 2 more trials: acceleration is 1.08 times the second derivative"
    assert f"doubt: {doubt}" in said.out
    page = (campaign.folder / "run/report.html").read_text()
    assert page.index("Doubts about the recordings") < page.index('<h2 id="overview">')
    assert doubt.replace("<", "&lt;").replace(">", "&gt;") in page
    assert MARKUP not in page
    manifest = json.loads((campaign.folder / "run/manifest.json").read_text())
    assert any(note.startswith("r04: acceleration is 1.08 times") for note in manifest["notes"])


def test_where_nothing_is_doubted_the_page_says_nothing_of_doubts(capsys: Capture, campaign: Campaign) -> None:
    said = run(capsys, campaign)
    assert said.code == DONE
    assert "doubt: " not in said.out
    assert "Doubts about" not in (campaign.folder / "run/report.html").read_text()


def test_spikes_and_lost_values_are_doubts_in_the_terminal_until_the_config_accepts_them(
    capsys: Capture, campaign: Campaign
) -> None:
    table = recorded(0.03, 0)
    table[[200, 300, 420], 1] += 0.01
    write_table(campaign.folder / "r00.csv", table)
    table = recorded(0.04, 1)
    table[250:270, 1] = table[250, 1]
    write_table(campaign.folder / "r01.csv", table)
    said = run(capsys, campaign)
    assert said.code == DONE, said.err
    spikes = r"doubt: spring long, r00: displacement: \d samples look like spikes, the first at"
    assert re.search(spikes, said.out)
    assert re.search(r"doubt: spring long, r01: displacement stands still at .*: values were lost; leave", said.out)
    campaign.edit("  index:", "  accept: {r00: [spikes], r01: [gaps]}\n  index:")
    said = run(capsys, campaign)
    assert said.code == DONE, said.err
    assert "doubt" not in said.out
    assert "accepted (spikes): displacement" in (campaign.folder / "run" / "report.html").read_text()
