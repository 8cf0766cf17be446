"""Progress of the search speaks of water only where a campaign has dry trials to tell it from."""

from __future__ import annotations

from pathlib import Path

import pytest

from undertow.campaign.config import load
from undertow.campaign.run.judgement import judged

CONFIG = """\
name: any
recordings:
  files: "*.csv"
  channels: {time: {column: t, unit: s}, displacement: {column: x, unit: m}}
"""


@pytest.mark.parametrize(
    ("trials", "stage"),
    [("", "what is missing"), ("trials: {group_by: [depth_m], dry: {depth_m: 1.0}}\n", "wet: what is missing")],
)
def test_no_water_is_spoken_of_where_none_is_known(tmp_path: Path, trials: str, stage: str) -> None:
    (tmp_path / "c.yaml").write_text(CONFIG + trials)
    stages: list[str] = []
    judged(load(tmp_path / "c.yaml"), (), (), 1, lambda name, *_: stages.append(name))
    assert stage in stages
