"""Specimens that cannot be, and levels that a table leaves out: said with the config's line, before any reading."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.matching_fixture import config_with, make_list, plan_of, said_of
from undertow.campaign.config.source import Source
from undertow.campaign.config.specimen_rules import check_level
from undertow.errors import ConfigError

Change = tuple[str, str]
AREA, VOLUME = "{by: depth_m, 2.36: 0.97}", "{by: depth_m, 2.36: 0.2775, 2.43: 0.3}"
MASS = "mass_kg: 2637.4"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return make_list(tmp_path)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ([(MASS, "mass_kg: 0")], r"line 16: specimen\.mass_kg is 0 kg but must be larger than 0; correct it, or leave"),
        ([(MASS, "mass_kg: 1e300")], r"line 16: specimen\.mass_kg is 1e\+300 kg, which nothing has; correct it, or"),
        ([(MASS, "mass_kg: {by: spring, long: 3000, short: 1e-300}")], r"mass_kg is 1e-300 kg for spring short, which"),
        ([(MASS, "mass_kg: -5")], r"line 16: specimen\.mass_kg is -5 kg but must be larger than 0"),
        ([(MASS, "mass_kg: {by: spring, long: 3000, short: 0}")], r"specimen\.mass_kg is 0 kg for spring short but mu"),
        ([(VOLUME, VOLUME.replace("2.43: 0.3", "1.63: 0.3"))], r"line 19: specimen\.submerged_volume_m3 is 0\.3 m\^3 "
         r"for depth_m 1\.63, which trials\.dry calls dry, and a dry body displaces no water; correct one of the two"),
        ([("long: 109592", "long: -1")], r"line 17: specimen\.stiffness_N_per_m is -1 N/m for spring long but must be"),
        ([(AREA, "-0.97")], r"line 18: specimen\.area_m2 is -0\.97 m\^2 but must be larger than 0"),
        ([(AREA, "0")], r"line 18: specimen\.area_m2 is 0 m\^2 but must be larger than 0; .*: dry trials have 0 by th"),
        ([(AREA, AREA.replace("0.97", "-0.97"))], r"line 18: specimen\.area_m2 is -0\.97 m\^2 for depth_m 2\.36 but m"),
        ([(AREA, AREA.replace("0.97", "0"))], r"line 18: specimen\.area_m2 is 0 m\^2 for depth_m 2\.36, which trials"),
        ([(AREA, AREA.replace("0.97}", '0.97, "2,36": 1}'))], r"line 18: specimen\.area_m2 has 2\.36 and 2,36, which "
         r"are the same number; drop one"),
        ([("2.36: 0.2775", "2.36: -0.2775")], r"line 19: specimen\.submerged_volume_m3 is -0\.2775 m\^3 for depth_m "
         r"2\.36 but must not be negative"),
        ([("2.36: 0.2775", "2.36: 2.775")], r"line 19: specimen\.submerged_volume_m3 is 2\.775 m\^3 for depth_m "
         r"2\.36: its buoyancy of 27222\.8 N must be smaller than the weight of 25872\.9 N \(2637\.4 kg\); correct vo"),
        ([(VOLUME, "2.6374")], r"line 19: specimen\.submerged_volume_m3 is 2\.6374 m\^3: its buoyancy of 25872\.9 N m"),
        ([(MASS, "mass_kg: {by: m_kg}")], r"line 19: .* 0\.2775 m\^3 for depth_m 2\.36, m_kg 0\.3: its buoyancy of "
         r"2722\.28 N must be smaller than the weight of 2\.943 N"),
        ([(MASS, "mass_kg: {by: spring}")], r"line 16: specimen\.mass_kg is the condition 'spring' itself, which is "
         r"'long' in trial a1, no number"),
        ([(MASS, f"{MASS}\n  water_density_kg_per_m3: 0")], r"line 17: specimen\.water_density_kg_per_m3 is 0 but sho"),
        ([(MASS, f"{MASS}\n  gravity_m_per_s2: -9.81")], r"line 17: specimen\.gravity_m_per_s2 is -9\.81 but should b"),
        ([(MASS, f"{MASS}\n  scatter: {{mu: -0.1}}")], r"line 17: specimen\.scatter\.mu is -0\.1 but should be greate"),
        ([("length_m: 16.5", "length_m: 0")], r"line 20: specimen\.cell\.length_m is 0 m but must be larger than 0"),
    ],
)  # fmt: skip
def test_a_specimen_that_cannot_be_is_refused(folder: Path, changes: list[Change], said: str) -> None:
    assert re.search(said, said_of(folder, *changes))


def test_a_mass_that_is_a_condition_is_checked_trial_by_trial(folder: Path) -> None:
    index = folder / "data" / "campaign.csv"
    index.write_text(index.read_text().replace("2.36,0.3", "2.36,-0.3"))
    said = r"line 16: specimen\.mass_kg is -0\.3 kg in trial a3 but must be larger than 0"
    assert re.search(said, said_of(folder, (MASS, "mass_kg: {by: m_kg}")))


def test_an_inertia_is_not_weighed_against_a_volume(folder: Path) -> None:
    rotation = "name: small\nequation: {coordinate: rotation, terms: [stiffness]}"
    turning = ("name: small", rotation), ("unit: m}", "unit: deg}")
    assert plan_of(folder, ("2.36: 0.2775", "2.36: 2.775"), *turning).entries
    said = said_of(folder, (MASS, "mass_kg: 0"), *turning)
    assert "specimen.mass_kg is 0 kg m^2 but must be larger than 0" in said


@pytest.mark.parametrize(
    ("old", "new", "name"),
    [
        (AREA, "{by: depth_m, 2.43: 0.97}", "area_m2"),
        ("2.36: 0.2775, ", "", "submerged_volume_m3"),
        (MASS, "mass_kg: {by: depth_m, 1.63: 2637.4, 2.43: 2637.4}", "mass_kg"),
    ],
)
def test_a_wet_level_that_a_table_leaves_out_is_refused_alone(folder: Path, old: str, new: str, name: str) -> None:
    plan_of(folder, (old, new))
    config = config_with(folder, (old, new), ('exclude: ["c1*"]', "exclude: []"))
    check_level(config, {"spring": "long", "depth_m": 1.63})
    with pytest.raises(ConfigError, match=rf"specimen\.{name} has no value for depth_m 2\.36, it has .*2\.43; add it"):
        check_level(config, {"spring": "long", "depth_m": 2.36})


def test_a_level_without_any_table_and_a_spring_without_stiffness_are_identified(folder: Path) -> None:
    check_level(config_with(folder, ("long: 109592, ", "")), {"spring": "long", "depth_m": 2.36})
    config = config_with(folder, (f"  area_m2: {AREA}\n", ""), (f"  submerged_volume_m3: {VOLUME}\n", ""))
    check_level(config, {"spring": "long", "depth_m": 2.36})


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("dry: {depth_m: 1.63}", "dry: {depth_m: 1,63}", r"line 11: trials\.dry has 63 without a value: within braces "
         r"a comma parts entries; write 1\.63, or \"1,63\" in quotes$"),
        (AREA, "{by: depth_m, 2,36: 0.97}", r"line 18: specimen\.area_m2 has 2 without a value: within braces a comma"),
        (MASS, "mass_kg: 2637,4", r"line 16: specimen\.mass_kg is '2637,4' but .* number; write 2637\.4, without quot"),
        ("{\"a1*\": [unit]", "{\"a1*\": [units]", r"line 5: recordings\.accept\.a1\*\.0 is 'units' but should be 'uni"),
        ("{\"a1*\": [unit]", "{\"a1*\": []", r"line 5: accept names no kind of doubt for 'a1\*'; give unit, sign, gai"),
        ("  exclude", "  pattern: '(?P<a>.)'\n  exclude", r"line 4: pattern belongs to files; with an index its colum"),
        ("index: data/campaign.csv", "files: data/*\n  file: x", r"line 4: file belongs to index, but recordings has "),
        ("index: data/campaign.csv", "files: data/*\n  pattern: a", r"line 4: pattern 'a' has no named group, so it g"),
        ("index: data/campaign.csv", "files: data/*\n  pattern: '('", r"line 4: pattern '\(' is no regular expression"),
        ("  exclude", "  index_separator: semicolon\n  exclude", r"line 4: index_separator is 'semicolon'; give one c"),
    ],
)  # fmt: skip
def test_a_key_that_can_have_no_effect_is_refused_when_loaded(folder: Path, old: str, new: str, said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        config_with(folder, (old, new))


def test_a_config_is_equal_to_itself_read_again(folder: Path) -> None:
    assert config_with(folder) == config_with(folder)
    assert isinstance(config_with(folder)._source, Source)
