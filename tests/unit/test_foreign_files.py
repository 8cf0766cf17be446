"""A run never replaces files that no run has written: a list of trials called trials.csv, a folder of figures."""

from __future__ import annotations

from pathlib import Path

import pytest

from undertow.campaign.config import load
from undertow.campaign.run.claim import refuse_foreign_files
from undertow.campaign.run.folder import run_to_folder, yaml_text
from undertow.errors import UndertowError

CONFIG = """\
name: rig
recordings:
  index: trials.csv
  channels:
    time: {column: t, unit: s}
    displacement: {column: x, unit: mm}
"""
NAMES, MARKS = ("trials.csv", "figures"), ("manifest.json", "stages")


@pytest.fixture
def config(tmp_path: Path) -> Path:
    """A campaign's config in a folder with its list of trials."""
    (tmp_path / "trials.csv").write_text("file,spring\nr1.csv,soft\n")
    path = tmp_path / "rig.yaml"
    path.write_text(CONFIG)
    return path


def test_a_list_of_trials_and_figures_of_somebody_else_are_not_replaced(config):
    folder = config.parent
    (folder / "figures").mkdir()
    (folder / "figures" / "photo.jpg").write_text("a photo")
    with pytest.raises(UndertowError, match=r"holds trials\.csv, figures, which no run has written .* --out"):
        run_to_folder(config, out=folder)
    assert (folder / "trials.csv").read_text().startswith("file,spring")
    assert (folder / "figures" / "photo.jpg").exists()
    assert not (folder / "config.yaml").exists()


@pytest.mark.parametrize("mark", MARKS)
def test_a_runs_own_folder_is_run_into_again(config, mark):
    (config.parent / mark).mkdir()
    refuse_foreign_files(config.parent, config, NAMES, MARKS)


def test_another_campaigns_config_is_not_replaced_but_an_interrupted_runs_is(config, tmp_path):
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "config.yaml").write_text(CONFIG)
    with pytest.raises(UndertowError, match=r"holds config\.yaml, which no run has written"):
        refuse_foreign_files(folder, config, NAMES, MARKS)
    (folder / "config.yaml").write_text(yaml_text(load(config).resolved()))
    refuse_foreign_files(folder, config, NAMES, MARKS)
    refuse_foreign_files(folder / "nowhere", config, NAMES, MARKS)
