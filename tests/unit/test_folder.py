"""Names and texts of the run folder: nothing leaves it, nothing is written over."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.small_campaign import make_campaign
from undertow.campaign.run.folder import LONGEST_NAME, run_to_folder, safe_name, write_json, yaml_text
from undertow.errors import UndertowError


@pytest.mark.parametrize(
    ("name", "folder"),
    [
        ("flume", "flume"),
        ("../../etc", "______etc"),
        ("/absolute", "_absolute"),
        ("a b.c:d", "a_b_c_d"),
        ("..", "__"),
        ("", "run"),
        ("Wasserstand ß", "Wasserstand_ß"),
        ("x" * 300, "x" * LONGEST_NAME),
    ],
)
def test_a_campaigns_name_is_a_plain_folder_name(name: str, folder: str) -> None:
    assert safe_name(name) == folder
    assert Path(folder).name == folder


def test_yaml_reads_back_with_numbers_as_numbers_and_texts_as_texts() -> None:
    from ruamel.yaml import YAML

    data = {"a": 1e-3, "b": "no", "c": {"2.36": 0.97, "x": [1, "1"]}, "d": "a: b # c"}
    assert YAML(typ="safe").load(yaml_text(data)) == data


def test_json_without_nan_is_written_whole_or_not_at_all(tmp_path: Path) -> None:
    write_json(tmp_path / "m.json", {"a": [1, "ü"]})
    assert json.loads((tmp_path / "m.json").read_text(encoding="utf-8")) == {"a": [1, "ü"]}
    with pytest.raises(ValueError, match="not JSON compliant"):
        write_json(tmp_path / "m.json", {"a": float("nan")})
    assert json.loads((tmp_path / "m.json").read_text(encoding="utf-8"))["a"][0] == 1
    assert len(list(tmp_path.iterdir())) == 1


def test_a_folder_that_cannot_be_made_is_said(tmp_path: Path) -> None:
    campaign = make_campaign(tmp_path, [0.04])
    (tmp_path / "taken").write_text("")
    with pytest.raises(UndertowError, match=r"run folder .*taken cannot be written: File exists .*choose another with"):
        run_to_folder(campaign.config, out=tmp_path / "taken")


def test_the_folder_of_the_config_is_not_a_run_folder(tmp_path: Path) -> None:
    campaign = make_campaign(tmp_path, [0.04])
    with pytest.raises(UndertowError, match=r"holds the config itself, .*config\.yaml, which its resolved form"):
        run_to_folder(campaign.config, out=tmp_path)
