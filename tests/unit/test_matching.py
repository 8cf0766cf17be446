"""A config against its list of trials: what matches nothing is said with line, text, what there is, the nearest."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.matching_fixture import INDEX, config_with, make_list, plan_of, said_of
from undertow.campaign.config import RunConfig, load
from undertow.campaign.config.matching import SENTENCES_AT_MOST, planned, unmatched
from undertow.errors import ConfigError
from undertow.recording.catalogue import Entry

ROOT = Path(__file__).resolve().parents[2]
SHARED = ROOT / ".." / "shared"
CONFIGS = sorted(path for path in (ROOT / "configs").rglob("*.yaml") if path.stem != "published")

@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return make_list(tmp_path)


def test_a_config_that_matches_goes_through_with_what_it_says_of_each_trial(folder: Path) -> None:
    plan = plan_of(folder)
    assert [entry.name for entry in plan.entries] == ["a1", "a2", "a3", "a4", "b1", "b2", "b3", "b4"]
    assert plan.entries[0].accepted == ("unit", "clipping")
    assert (plan.entries[1].accepted, plan.entries[4].accepted) == (("clipping", "unit"), ())
    assert plan.entries[0].conditions["who"] == 0.5
    assert plan.entries[0].window.start_s == 1.0
    assert not plan.notes


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('["c1*"]', '["c1*", "*d1*"]',
         r"line 4: recordings\.exclude names '\*d1\*', which fits none of 9 trials: a1\.csv\.gz, .* and 1 more"),
        ('"a1*": [unit]', '"a33": [unit]', r"line 5: recordings\.accept names 'a33', .*; did you mean a3\.csv\.gz\?"),
        ('"a1*": {start', '"x*": {start', r"line 13: trials\.window names 'x\*', which fits none of 9 trials"),
        ('"a1*": {who', '"b44.csv.gz": {who', r"line 14: trials\.conditions names 'b44\.csv\.gz', .* mean b4\.csv\.gz"),
        ("hold_out: auto", "hold_out: [a3, r4935.csv.gz]",
         r"line 12: trials\.hold_out names 'r4935\.csv\.gz', which fits none of 8 trials"),
        ("hold_out: auto", "hold_out: [c1]",
         r"line 12: trials\.hold_out names 'c1', which recordings\.exclude leaves out; take it out of one of them"),
        ("[spring, depth_m]", "[sprign, depth_m]",
         r"line 10: trials\.group_by names 'sprign', but .*; they have depth_m, .*, who; did you mean spring\?"),
        ("dry: {depth_m: 1.63}", "dry: {depht_m: 1.63}", r"line 11: trials\.dry names 'depht_m', .* mean depth_m\?"),
        ("dry: {depth_m: 1.63}", "dry: {depth_m: 1.65}",
         r"line 11: trials\.dry says depth_m 1\.65, .* they have 1\.63, 2\.36, 2\.43; did you mean 1\.63\?"),
        ("dry: {depth_m: 1.63}", "dry: {depth_m: 2.43}",
         r"line 11: .* depth_m 2\.43, but no trial has it but those that recordings\.exclude leaves out"),
        ("dry: {depth_m: 1.63}", "dry: {depth_m: 1.63, m_kg: 0.3}",
         r"line 11: trials\.dry says depth_m 1\.63 and m_kg 0\.3, but no trial has them together"),
        ("long: 109592", "lang: 109592",
         r"line 17: specimen\.stiffness_N_per_m has spring lang, .*; they have long, short; did you mean long\?"),
        ("area_m2: {by: depth_m, 2.36", "area_m2: {by: depth_m, 2.63",
         r"line 18: specimen\.area_m2 has depth_m 2\.63, but no trial has it; they have .*; did you mean 2\.43\?"),
        ("area_m2: {by: depth_m", "area_m2: {by: depth",
         r"line 18: specimen\.area_m2 goes by 'depth', but no trial has such a condition; .*; did you mean depth_m\?"),
        ("surface_width_m: {by: depth_m, 2.36", "surface_width_m: {by: depth_m, 2.37",
         r"line 20: specimen\.cell\.surface_width_m has depth_m 2\.37, but"),
        ("index: data/campaign.csv", "index: data/campagin.csv", r"line 3: recordings\.index .*; did you mean 'campai"),
    ],
)  # fmt: skip
def test_what_matches_nothing_is_said(folder: Path, old: str, new: str, said: str) -> None:
    assert re.search(said, said_of(folder, (old, new)))


def test_what_was_set_on_the_command_line_is_said_as_it_was_set(folder: Path) -> None:
    config_with(folder)
    with pytest.raises(ConfigError, match=r"^--set trials\.dry\.depth_m=1\.65: trials\.dry says depth_m 1\.65"):
        planned(load(folder / "config.yaml", ["trials.dry.depth_m=1.65"]))


def test_every_problem_is_said_at_once_and_of_a_long_list_the_first(folder: Path) -> None:
    wrong = ", ".join(f"x{i}" for i in range(30))
    changes = ("hold_out: auto", f"hold_out: [{wrong}]"), ("[spring, depth", "[spirng, depth")
    said = said_of(folder, *changes).splitlines()
    assert len(said) == SENTENCES_AT_MOST + 1
    assert said[-1] == "and 11 more problems"


@pytest.mark.parametrize("value", ["1.63", "1.630", '"1,63"', '" 1,630"', "1.6300000001"])
def test_a_dry_level_is_a_number_in_either_notation(folder: Path, value: str) -> None:
    config = config_with(folder, ("dry: {depth_m: 1.63}", f"dry: {{depth_m: {value}}}"))
    assert [config.is_dry(entry.conditions) for entry in planned(config).entries] == [True, True, False, False] * 2


@pytest.mark.parametrize(("separator", "cell"), [(";", r"\1,\2"), ("\t", r"\1,\2"), (",", r'"\1,\2"')])
def test_an_index_with_decimal_commas_has_the_same_levels(folder: Path, separator: str, cell: str) -> None:
    german = re.sub(r"(\d)\.(\d+)", cell, INDEX.replace(",", separator))
    (folder / "data" / "campaign.csv").write_text(german)
    assert plan_of(folder).entries[0].conditions["depth_m"] == 1.63
    assert sum(config_with(folder).is_dry(entry.conditions) for entry in plan_of(folder).entries) == 4


def test_patterns_of_trials_that_are_left_out_for_now_may_stay(folder: Path) -> None:
    kept = ('"a1*": {start_s: 1.0}', '"c1*": {start_s: 1.0}'), ('"a1*": [unit]', '"c1": [unit]')
    assert len(plan_of(folder, *kept).entries) == 8


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ((("[spring, depth_m]", "[spring]"),),
         r"line 10: trials\.group_by puts the dry trial a1 and the wet trial a3 into one group \(spring long\); add"),
        ((("[spring, depth_m]", "[depth_m]"),),
         r"line 10: specimen\.stiffness_N_per_m goes by spring, which is long and short in one group .*; "
         r"add spring to trials\.group_by"),
        ((("mass_kg: 2637.4", "mass_kg: {by: m_kg}"), ("[spring, depth_m]", "[]"), ("{depth_m: 1.63}", "none")),
         r"line 10: specimen\.mass_kg goes by m_kg, which is 0\.2 and 0\.3 in one group \(all trials\); add m_kg"),
    ],
)  # fmt: skip
def test_trials_of_different_specimens_are_no_group(
    folder: Path, changes: tuple[tuple[str, str], ...], said: str
) -> None:
    assert re.search(said, said_of(folder, *changes))


@pytest.mark.parametrize(
    ("rule", "said"),
    [
        ("[a3, a4.csv.gz]", r"line 12: trials\.hold_out holds out all of 2 trials of the group spring long, depth_m "
         r"2\.36 \(a3, a4\), which leaves none to be fitted; hold out fewer"),
        ('["a*"]', r"holds out all of 2 trials of the group spring long, depth_m 1\.63 \(a1, a2\)"),
        ("{largest: 2}", r"holds out the 2 largest of 2 trials of the group spring long, depth_m 1\.63"),
    ],
)  # fmt: skip
def test_a_group_keeps_a_trial_to_be_fitted(folder: Path, rule: str, said: str) -> None:
    assert re.search(said, said_of(folder, ("hold_out: auto", f"hold_out: {rule}")))


def test_groups_without_a_held_out_trial_are_noted_where_others_have_some(folder: Path) -> None:
    (note,) = plan_of(folder, ("hold_out: auto", "hold_out: [a3.csv.gz, b1]")).notes
    assert note == (
        "trials.hold_out names no trial of 2 of 4 groups (spring long, depth_m 1.63; spring short, depth_m 2.36): what "
        "is found in them is not proved on an unseen trial"
    )
    assert not plan_of(folder, ("hold_out: auto", "hold_out: [a1, a3, b1, b3]")).notes
    assert not plan_of(folder, ("hold_out: auto", "hold_out: []")).notes
    assert not plan_of(folder, ("hold_out: auto", "hold_out: {every: 2}")).notes


def test_a_trial_without_a_condition_that_is_needed_fails_alone(folder: Path) -> None:
    index = INDEX.replace("a4.csv.gz,long,2.36", "a4.csv.gz,long,")
    (folder / "data" / "campaign.csv").write_text(index)
    problems = {entry.name: entry.problem for entry in plan_of(folder).entries if entry.problem}
    assert list(problems) == ["a4"]
    said = "it has no condition 'depth_m', by which trials.group_by goes; it has spring, m_kg: fill its cell"
    assert problems["a4"].startswith(said)


def test_a_pattern_of_file_names_that_fits_none_is_said(folder: Path) -> None:
    files = "files: data/*.csv.gz\n  pattern: '^(?P<spring>[xy])'"
    assert re.search(
        r"line 4: recordings\.pattern .* fits none of 9 file names \(a1\.csv\.gz, .*\); correct it",
        said_of(folder, ("index: data/campaign.csv", files)),
    )


def test_a_config_that_came_from_no_file_is_held_against_its_trials_too(folder: Path) -> None:
    plain = config_with(folder).model_dump(exclude_none=True)
    config = RunConfig.model_validate(plain)
    entries = [Entry("a1", "a1.csv", {"spring": "long", "depth_m": 1.63})]
    said = "config: recordings.exclude names 'c1*', which fits none of 1 trials"
    assert unmatched(config, entries)[0].startswith(said)


@pytest.mark.parametrize("path", CONFIGS, ids=[path.stem for path in CONFIGS])
def test_each_committed_config_matches_its_trials(path: Path) -> None:
    config = load(path)
    said = config.recordings.index or config.recordings.files or ""
    if "shared" in said and not SHARED.is_dir():
        pytest.skip("../shared with the real recordings is not beside the repository")
    plan = planned(config)
    assert plan.entries
    assert not [entry.problem for entry in plan.entries if entry.problem]
    assert not plan.notes
