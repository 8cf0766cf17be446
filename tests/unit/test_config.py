"""The config: what it accepts, what it says of a mistake, and what follows from it for a trial."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from ruamel.yaml import YAML

from undertow.campaign.config import RunConfig, load, look_up, schema_text, write_schema
from undertow.campaign.config.settings import Table
from undertow.campaign.response.sets import sweeps
from undertow.equation import registry
from undertow.errors import ConfigError
from undertow.recording.catalogue import TimeWindow, read_trial
from undertow.recording.conditions import same_condition
from undertow.recording.gather import gather

ROOT = Path(__file__).resolve().parents[2]
SHARED = ROOT / ".." / "shared"
CONFIGS = sorted((ROOT / "configs").glob("*/*.yaml"))

GOOD = """\
name: small
recordings:
  index: data/campaign.csv
  channels:
    time: {column: t, unit: s}
    displacement: {column: x, unit: mm}
    spring_force: {columns: [f1, f2], unit: kN}
trials:
  group_by: [spring, depth_m]
  dry: {depth_m: 1.63}
specimen:
  mass_kg: 2637.4
  stiffness_N_per_m: {by: spring, long: 109592, short: 402036}
  area_m2: 0.97
  submerged_volume_m3: {by: depth_m, 2.36: 0.2775}
  cell: {surface_width_m: {by: depth_m, 2.36: 0.26}, length_m: 16.5}
"""


def written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "config.yaml"
    path.write_text(text)
    return path


def changed(tmp_path: Path, old: str, new: str) -> Path:
    assert old in GOOD
    return written(tmp_path, GOOD.replace(old, new))


@pytest.fixture
def config(tmp_path: Path) -> RunConfig:
    return load(written(tmp_path, GOOD))


def test_defaults_are_those_of_the_main_job(config: RunConfig, tmp_path: Path) -> None:
    assert config.equation.terms[0] == "stiffness"
    assert config.identify == ("decay", "sindy", "method1", "method2", "output_error")
    assert (config.seed, config.trials.hold_out, config.trials.window) == (0, "auto", "auto")
    assert config.folder == tmp_path


def test_channels_become_the_recording_rooms_own(config: RunConfig) -> None:
    catalogue = config.catalogue()
    assert catalogue.channels["spring_force"].columns == ("f1", "f2")
    assert catalogue.channels["displacement"].columns == ("x",)
    assert (catalogue.time.column, catalogue.index) == ("t", "data/campaign.csv")


def test_a_specimen_is_looked_up_by_the_trials_conditions(config: RunConfig) -> None:
    wet = config.specimen_for({"spring": "short", "depth_m": 2.36})
    assert (wet.stiffness_N_per_m, wet.area_m2, wet.submerged_volume_m3) == (402036.0, 0.97, 0.2775)
    assert config.cell_for({"depth_m": 2.36})["surface_width_m"] == 0.26
    assert math.isnan(config.cell_for({"depth_m": 2.36})["depth_m"])


def test_a_dry_trial_has_no_area_and_no_volume(config: RunConfig) -> None:
    dry = config.specimen_for({"spring": "long", "depth_m": 1.63})
    assert (dry.area_m2, dry.submerged_volume_m3) == (0.0, 0.0)


def test_a_volume_is_assumed_in_water_alone_and_where_nobody_stated_one(config: RunConfig) -> None:
    silent = config.model_copy(update={"specimen": config.specimen.model_copy(update={"submerged_volume_m3": None})})
    wet, dry = ({"spring": "short", "depth_m": depth} for depth in (2.36, 1.63))
    assert silent.specimen_for(wet).volume_assumed
    assert not silent.specimen_for(dry).volume_assumed
    assert not config.specimen_for(wet).volume_assumed


def test_what_a_table_lacks_is_unknown_when_wet(config: RunConfig) -> None:
    other = config.specimen_for({"spring": "medium", "depth_m": 2.29})
    assert math.isnan(other.stiffness_N_per_m)
    assert math.isnan(other.submerged_volume_m3)


def test_a_table_by_a_condition_that_no_trial_has_is_refused(config: RunConfig) -> None:
    with pytest.raises(ConfigError, match=r"specimen\.stiffness_N_per_m goes by 'spring'.*it has depth_m"):
        config.specimen_for({"depth_m": 2.36})


def test_by_alone_is_the_condition_itself() -> None:
    assert look_up("mass_kg", Table(by="m_kg"), {"m_kg": 0.2016}) == 0.2016
    with pytest.raises(
        ConfigError, match=r"specimen\.mass_kg is the condition 'm_kg' itself, which is 'heavy', no number"
    ):
        look_up("mass_kg", Table(by="m_kg"), {"m_kg": "heavy"})


def test_numbers_in_keys_and_conditions_are_compared_as_numbers() -> None:
    assert same_condition(2.3600004, "2.36")
    assert not same_condition(2.36001, "2.36")
    assert not same_condition(None, "2.36")
    assert same_condition("long", "long")


def test_groups_and_dry_trials_follow_the_conditions(config: RunConfig) -> None:
    assert config.group_key({"depth_m": 2.36, "spring": "long", "x0": 1.0}) == (("spring", "long"), ("depth_m", 2.36))
    assert config.is_dry({"depth_m": 1.6300000001})
    assert not config.is_dry({"depth_m": 2.36})
    with pytest.raises(ConfigError, match=r"trials\.group_by: a trial has no condition 'spring'; it has depth_m"):
        config.group_key({"depth_m": 2.36})


@pytest.mark.parametrize("dry", ["none", "null", "~"])
def test_without_dry_trials_no_trial_is_dry(tmp_path: Path, dry: str) -> None:
    config = load(changed(tmp_path, "{depth_m: 1.63}", dry))
    assert config.trials.dry is None
    assert not config.is_dry({"depth_m": 1.63})


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            "  channels:",
            "  chanels:",
            r"config\.yaml line 4: unknown key 'chanels' in recordings; did you mean 'channels'\?",
        ),
        (
            "unit: mm",
            "units: mm",
            r"line 6: unknown key 'units' in recordings\.channels\.displacement; did you mean 'unit'",
        ),
        ("name: small", "nmae: small", r"line 1: unknown key 'nmae' in the config; did you mean 'name'"),
        ("name: small", "zzz: 1\nname: small", r"line 1: unknown key 'zzz' in the config; it may have discrepancy, "),
        ("mass_kg: 2637.4", "mass_kg: 2637.4\n  scatter: {stiffness: 0.004}",
         r"unknown key 'stiffness' in specimen.scatter; it may have c \(Viscous damping, 1 sigma over i"),
        ("mass_kg: 2637.4", "mass_kg: 2637.4\n  scatter: 0.004",
         r"specimen.scatter is 0.004 but should be keys with values; it may have c .*, k \(Stiffness, .* 0.4 %\), mu"),
        ("name: small", "name: small\nidentify: []", r"identify is \[\] but should have at least 1 of them"),
        ("name: small", "name: small\nidentify: [sindyy]", r"^config.yaml line 2: identify.0 is .* 'output_error'$"),
        ("name: small\n", "", "the config has no 'name'; it is needed"),
        ("unit: mm", "unit: furlongz", r"line 6: displacement: unit 'furlongz' is not known"),
        ("unit: mm", "unit: deg", r"line 6: .*set equation\.coordinate to rotation"),
        ("column: x, ", "", r"line 6: displacement has column None and columns None; give exactly one"),
        ("column: x,", "column: x, columns: [x],", r"line 6: displacement has column 'x' and columns"),
        ("column: t,", "column: t, rate_hz: 10,", r"line 5: time has column 't' and rate_hz 10\.0; give exactly one"),
        ("    displacement: {column: x, unit: mm}\n", "", r"line 4: channels has neither displacement nor velocity"),
        ("  index: data/campaign.csv", "  skip_rows: 1", r"line 2: recordings has index None and files None"),
        ("name: small", "name: small\nidentify: sindy", r"line 2: identify is 'sindy' but should be a list"),
        ("name: small", "name: small\ndiscrepancy: {suspects: drag}", "is 'drag' but should be 'all' or a list"),
        ("mass_kg: 2637.4", "mass_kg: heavy", r"line 12: specimen\.mass_kg is 'heavy' but should be a valid number"),
        ("mass_kg: 2637.4", "mass_kg: true", r"line 12: specimen\.mass_kg is True but"),
        ("mass_kg: 2637.4", "mass_kg: .nan", r"line 12: specimen\.mass_kg is nan but should be a finite number"),
        ("short: 402036", "short: stiff", r"line 13: specimen\.stiffness_N_per_m\.short is 'stiff' but"),
        ("{by: spring, long", "{long", r"line 13: specimen\.stiffness_N_per_m has no 'by'"),
        ("name: small", "name: small\nseed: 1.5", r"line 2: seed is 1\.5 but should be a valid integer"),
        (
            "name: small",
            "name: small\nidentify: [sindi]",
            r"line 2: identify\.0 is 'sindi' but should be 'decay', 'sindy'",
        ),
        (
            "name: small",
            "name: small\nequation: {terms: [stifness]}",
            r"line 2: .*'stifness' is not in the registry; .*'stiffness'",
        ),
        (
            "name: small",
            "name: small\nequation: {terms: [viscous_damping, asymmetric_stiffness]}",
            r"line 2: equation\.terms has viscous_damping, asymmetric_stiffness and nothing that pulls the body back",
        ),
        (
            "name: small",
            "name: small\nequation: {terms: [stiffness, viscous_damping, stiffness]}",
            r"line 2: equation\.terms names 'stiffness' twice; take one of them out",
        ),
        (
            "  group_by",
            "  hold_out: {evry: 3}\n  group_by",
            r"line 9: unknown key 'evry' in trials\.hold_out; did you mean 'every'",
        ),
        (
            "  group_by",
            "  window: {'*': {start: 3}}\n  group_by",
            r"line 9: unknown key 'start' in trials\.window\.\*; .*'start_s'",
        ),
        (
            "  group_by",
            "  window: {'*': {start_s: 3, end_s: 2}}\n  group_by",
            r"line 9: the window starts at 3\.0 s and ends at 2\.0",
        ),
        (
            "  channels:",
            "  despike: {displacment: {median: 7}}\n  channels:",
            r"line 4: despike names 'displacment', which is no mapped",
        ),
        (
            "  channels:",
            "  despike: {displacement: {median: 6}}\n  channels:",
            r"line 4: median is 6 samples; give an odd number",
        ),
        ("name: small", "name: small\nname: twice", r"line 2: found duplicate key"),
        ("name: small", "name: [small", r"config\.yaml line \d+: .*; correct the YAML"),
        ("name: small", "name: !!python/object/apply:os.system [ls]", r"line 1: a tag .* is not read"),
        ("name: small", "name: &a small\nseed: *a", r"line 2: an alias .* is not read"),
    ],
)
def test_a_mistake_is_named_with_its_line(tmp_path: Path, old: str, new: str, said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        load(changed(tmp_path, old, new))


def test_every_mistake_is_said_at_once(tmp_path: Path) -> None:
    path = changed(tmp_path, "mass_kg: 2637.4", "mass_kg: heavy\n  maas: 1")
    with pytest.raises(ConfigError, match="heavy") as caught:
        load(path)
    assert len(str(caught.value).splitlines()) == 2


@pytest.mark.parametrize(
    ("text", "said"), [("", "is empty; is it"), ("- a\n- b\n", "holds a list, not"), ("x", "holds one text")]
)
def test_a_file_without_keys_is_no_config(tmp_path: Path, text: str, said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        load(written(tmp_path, text))


def test_a_folder_as_a_config_is_answered_with_what_makes_one(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"cannot be read: Is a directory; undertow init .* writes a config"):
        load(tmp_path)


def test_a_missing_config_and_one_that_is_no_text_are_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=r"no\.yaml cannot be read: No such file"):
        load(tmp_path / "no.yaml")
    (tmp_path / "config.yaml").write_bytes(b"\xff\xfe\xfd\x80")
    with pytest.raises(ConfigError, match=r"it is not UTF-8 text"):
        load(tmp_path / "config.yaml")


def test_overrides_reach_every_depth_and_are_read_as_yaml(tmp_path: Path) -> None:
    said = ["seed=3", "specimen.stiffness_N_per_m.long=1.1e5", "identify=[sindy]", "equation.coordinate=translation"]
    config = load(written(tmp_path, GOOD), [*said, "trials.hold_out={every: 2}", "trials.group_by.0=x0"])
    assert (config.seed, config.identify) == (3, ("sindy",))
    assert config.specimen_for({"spring": "long", "depth_m": 2.36}).stiffness_N_per_m == 1.1e5
    assert config.trials.group_by == ("x0", "depth_m")
    assert config.trials.hold_out != "auto"


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("seed=abc", "--set seed=abc: seed is 'abc' but should be a valid integer"),
        ("trials.window=[5, 1]", r"trials.window is \[5, 1\] but should be 'auto' or keys with values"),
        ("seeed=1", "--set seeed=1: unknown key 'seeed' in the config; did you mean 'seed'"),
        ("seed", "--set seed: it must read key.key=value"),
        ("seed..x=1", "it must read key.key=value"),
        ("seed=[1", r"'\[1' is no YAML value"),
        ("name.x=1", "'x' lies below 'small', which has no keys"),
        ("trials.group_by.7=x", "'7' is no place in a list of 2"),
    ],
)
def test_an_override_that_is_wrong_is_named(tmp_path: Path, override: str, said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        load(written(tmp_path, GOOD), [override])


def test_a_resolved_config_is_the_same_run_from_anywhere(config: RunConfig, tmp_path: Path) -> None:
    plain = config.resolved()
    elsewhere = tmp_path / "run" / "config.yaml"
    elsewhere.parent.mkdir()
    with elsewhere.open("w") as stream:
        YAML().dump(plain, stream)
    again = load(elsewhere)
    assert again.resolved() == plain
    assert Path(plain["recordings"]["index"]) == tmp_path / "data" / "campaign.csv"


def test_the_committed_schema_is_the_generated_one(tmp_path: Path) -> None:
    write_schema(tmp_path / "schema.json")
    committed = (ROOT / "configs" / "run.schema.json").read_text(encoding="utf-8")
    assert (tmp_path / "schema.json").read_text(encoding="utf-8") == schema_text()
    assert json.loads(committed) == json.loads(schema_text()), "run python -m undertow.campaign.config.run_config"


def test_every_key_in_the_schema_is_described() -> None:
    schema = json.loads(schema_text())
    silent = [
        f"{name}.{key}"
        for name, model in [("config", schema), *schema["$defs"].items()]
        for key, value in model.get("properties", {}).items()
        if not value.get("description")
    ]
    assert silent == []


def test_every_term_in_the_registry_may_be_prescribed(tmp_path: Path) -> None:
    terms = ", ".join(registry.names())
    assert (
        load(changed(tmp_path, "name: small", f"name: small\nequation: {{terms: [{terms}]}}")).equation.terms
        == registry.names()
    )


CELLS = """\
name: tank
recordings:
  files: x.mat
  cells: {variable: xData, trial: row, time: 0, displacement: 1}
  channels: {time: {unit: s}, displacement: {unit: "%"}}
trials: {window: {"*": {start_s: 1}}}
"""


def test_cells_give_channels_their_columns(tmp_path: Path) -> None:
    catalogue = load(written(tmp_path, CELLS)).catalogue()
    assert catalogue.time.column == 0
    assert catalogue.channels["displacement"].columns == (1,)
    assert catalogue.windows["*"] == TimeWindow(1.0, None)


def test_columns_beside_cells_and_cells_without_keys_are_named(tmp_path: Path) -> None:
    text = CELLS.replace("{unit: s}", "{column: t, unit: s}").replace('{unit: "%"}', "{column: x, unit: m}")
    clock = "time has column, and recordings.cells says that it is cell 0 of a trial; remove one"
    with pytest.raises(ConfigError, match=clock) as caught:
        load(written(tmp_path, text))
    assert "displacement has column, and recordings.cells says that it is cell 1 of a trial" in str(caught.value)
    true = text.replace("{variable: xData, trial: row, time: 0, displacement: 1}", "true")
    with pytest.raises(ConfigError, match=r"cells is True but should be keys with values; it may have .*variable"):
        load(written(tmp_path, true))


@pytest.mark.parametrize("path", CONFIGS, ids=[path.stem for path in CONFIGS])
def test_each_committed_config_loads(path: Path) -> None:
    assert load(path).name


@pytest.mark.skipif(not SHARED.is_dir(), reason="../shared with the real recordings is not beside the repository")
@pytest.mark.parametrize("path", CONFIGS, ids=[path.stem for path in CONFIGS])
def test_each_committed_config_reads_its_recordings(path: Path) -> None:
    config = load(path)
    catalogue = config.catalogue()
    entries = gather(catalogue)
    assert not [entry.problem for entry in entries if entry.problem]
    if config.recordings.response is not None:
        assert sweeps(config)[1] == {}
        return
    for entry in entries[:3]:
        recording = read_trial(entry, catalogue)
        assert recording.time.size > 500
        config.group_key(recording.conditions)
        config.specimen_for(recording.conditions)


def test_published_values_go_by_level_and_a_level_without_one_has_none(tmp_path: Path) -> None:
    more = "  published: {drag_coefficient: {by: depth_m, 2.36: 2.1}, rest_offset_m: -0.002}\n"
    config = load(written(tmp_path, GOOD + more))
    known = config.specimen_for({"spring": "long", "depth_m": 2.36}).published
    assert known == (("drag_coefficient", 2.1), ("rest_offset_m", -0.002))
    assert config.specimen_for({"spring": "long", "depth_m": 2.29}).published == (("rest_offset_m", -0.002),)
    assert load(written(tmp_path, GOOD)).specimen_for({"spring": "long", "depth_m": 2.36}).published == ()
