"""Links that lead out of a campaign's folder are refused wherever a campaign finds files; other links are followed."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import pytest

from tests.small_campaign import make_campaign
from undertow.campaign.config import load
from undertow.campaign.starting.survey import survey
from undertow.errors import ConfigError
from undertow.recording.channels import ChannelSpec
from undertow.recording.gather import gather
from undertow.recording.links import leads_out


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A campaign of two trials; the second is a link out of the folder."""
    made = make_campaign(tmp_path / "c", [0.03, 0.04]).folder
    (made / "r01.csv").rename(tmp_path / "outside.csv")
    os.symlink(tmp_path / "outside.csv", made / "r01.csv")
    return made


def test_a_file_an_index_names_is_refused_behind_a_link_out(folder: Path) -> None:
    sound, refused = gather(load(folder / "config.yaml").catalogue())
    assert not sound.problem
    target = folder.parent / "outside.csv"
    assert refused.problem == (
        f"the index names 'r01.csv', a link that leads out of its folder, to {target}; copy the file itself there"
    )


def test_a_file_a_glob_finds_is_refused_behind_a_link_out(folder: Path) -> None:
    catalogue = replace(load(folder / "config.yaml").catalogue(), index=None)
    for glob in ("*.csv", "../c/r*.csv", "r01.csv", "**/r*.csv"):
        found = {entry.name: entry.problem for entry in gather(replace(catalogue, files=glob))}
        assert "r01.csv is a link that leads out of its folder" in found["r01"], glob
        assert not found.get("r00", "")


def test_a_folder_that_is_a_link_out_hides_nothing(folder: Path) -> None:
    (folder.parent / "far").mkdir()
    (folder / "r00.csv").rename(folder.parent / "far" / "r00.csv")
    os.symlink(folder.parent / "far", folder / "near")
    index = folder / "campaign.csv"
    index.write_text(index.read_text().replace("r00.csv", "near/r00.csv"))
    assert "leads out of its folder" in gather(load(folder / "config.yaml").catalogue())[0].problem


def test_a_file_beside_a_trial_is_refused_behind_a_link_out(folder: Path) -> None:
    os.symlink(folder.parent / "outside.csv", folder / "r00_acc.csv")
    catalogue = load(folder / "config.yaml").catalogue()
    channels = {**catalogue.channels, "acceleration": ChannelSpec("a", "m/s^2", file="{stem}_acc.csv")}
    assert gather(replace(catalogue, channels=channels))[0].problem.startswith(
        "its channels' file 'r00_acc.csv' is a link that leads out of its folder"
    )


def test_an_index_behind_a_link_out_is_refused(folder: Path) -> None:
    (folder / "campaign.csv").rename(folder.parent / "other.csv")
    os.symlink(folder.parent / "other.csv", folder / "campaign.csv")
    with pytest.raises(ConfigError, match=r"recordings\.index .*campaign\.csv is a link that leads out of its folder"):
        gather(load(folder / "config.yaml").catalogue())


def test_init_leaves_a_link_out_unread(folder: Path) -> None:
    assert [(name, why.partition(",")[0]) for name, why in survey(folder).unread if name == "r01.csv"] == [
        ("r01.csv", "is a link that leads out of its folder")
    ]


def test_links_that_stay_and_a_folder_reached_through_one_are_followed(folder: Path) -> None:
    (folder / "r01.csv").unlink()
    os.symlink("r00.csv", folder / "r01.csv")
    os.symlink(folder, folder.parent / "way")
    for home in (folder, folder.parent / "way"):
        assert leads_out(home / "r01.csv", home) == ""
        assert not any(entry.problem for entry in gather(load(home / "config.yaml").catalogue()))
