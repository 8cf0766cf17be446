"""A list of trials without recordings, and a config that matches it: for tests of what a config may name."""

from __future__ import annotations

from pathlib import Path

import pytest

from undertow.campaign.config import RunConfig, load
from undertow.campaign.config.matching import Plan, planned
from undertow.errors import ConfigError

INDEX = """\
file,spring,depth_m,m_kg
a1.csv.gz,long,1.63,0.2
a2.csv.gz,long,1.63,0.2
a3.csv.gz,long,2.36,0.3
a4.csv.gz,long,2.36,0.3
b1.csv.gz,short,1.63,0.2
b2.csv.gz,short,1.63,0.2
b3.csv.gz,short,2.36,0.3
b4.csv.gz,short,2.36,0.3
c1.csv.gz,short,2.43,0.3
"""
CONFIG = """\
name: small
recordings:
  index: data/campaign.csv
  exclude: ["c1*"]
  accept: {"a1*": [unit], "a*": [clipping, unit]}
  channels:
    time: {column: t, unit: s}
    displacement: {column: x, unit: m}
trials:
  group_by: [spring, depth_m]
  dry: {depth_m: 1.63}
  hold_out: auto
  window: {"a1*": {start_s: 1.0}}
  conditions: {"a1*": {who: "0,5"}}
specimen:
  mass_kg: 2637.4
  stiffness_N_per_m: {by: spring, long: 109592, short: 402036}
  area_m2: {by: depth_m, 2.36: 0.97}
  submerged_volume_m3: {by: depth_m, 2.36: 0.2775, 2.43: 0.3}
  cell: {surface_width_m: {by: depth_m, 2.36: 0.26}, length_m: 16.5}
"""


def make_list(folder: Path) -> Path:
    """The index with its (empty) files in ``folder``/data; the folder."""
    (folder / "data").mkdir()
    (folder / "data" / "campaign.csv").write_text(INDEX)
    for row in INDEX.splitlines()[1:]:
        (folder / "data" / row.partition(",")[0]).touch()
    return folder


def config_with(folder: Path, *changes: tuple[str, str]) -> RunConfig:
    """The config with some of its texts replaced, loaded from ``folder``."""
    text = CONFIG
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    (folder / "config.yaml").write_text(text)
    return load(folder / "config.yaml")


def said_of(folder: Path, *changes: tuple[str, str]) -> str:
    """What is said of a config that does not match."""
    with pytest.raises(ConfigError, match=r"config.yaml line \d+: ") as caught:
        planned(config_with(folder, *changes))
    return str(caught.value)


def plan_of(folder: Path, *changes: tuple[str, str]) -> Plan:
    """The trials of a config that matches."""
    return planned(config_with(folder, *changes))
