"""Provenance: the commit of the code that ran, however it was installed."""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from tests.findings_fixture import small_findings
from tests.small_campaign import make_campaign
from undertow.campaign.config import load
from undertow.campaign.run import manifest


def repository(folder: Path) -> str:
    """A repository with one commit; its hash."""

    def git(*words: str) -> str:
        identity = ["-c", "user.name=t", "-c", "user.email=t@example.org"]
        done = subprocess.run(["git", "-C", str(folder), *identity, *words], capture_output=True, text=True, check=True)
        return done.stdout.strip()

    folder.mkdir()
    git("init", "-q")
    (folder / "a.py").write_text("a = 1\n")
    git("add", "a.py")
    git("commit", "-qm", "a")
    return git("rev-parse", "HEAD")


def test_a_file_outside_every_repository_has_the_revision_pip_noted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    commit = repository(tmp_path / "clone with space")
    monkeypatch.setattr(manifest, "__file__", str(tmp_path / "site-packages" / "manifest.py"))
    note = {"url": (tmp_path / "clone with space").as_uri(), "dir_info": {}}
    monkeypatch.setattr(manifest, "_direct_url", lambda: note)
    assert manifest.git_revision() == commit
    (tmp_path / "clone with space" / "a.py").write_text("a = 2\n")
    assert manifest.git_revision() == commit + "+"


def test_an_untracked_installation_inside_a_repository_is_not_that_repositorys_code(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    repository(tmp_path / "project")
    installed = tmp_path / "project" / ".venv" / "manifest.py"
    installed.parent.mkdir()
    installed.write_text("")
    monkeypatch.setattr(manifest, "__file__", str(installed))
    monkeypatch.setattr(manifest, "_direct_url", lambda: {})
    assert manifest.git_revision() == ""


@pytest.mark.parametrize(
    ("note", "commit"),
    [
        ({"url": "https://example.org/u.git", "vcs_info": {"vcs": "git", "commit_id": "abc"}}, "abc"),
        ({"url": "file:///not/there"}, ""),
        ({"url": "https://example.org/u.whl"}, ""),
        ({}, ""),
    ],
)
def test_what_pip_noted_is_read_as_far_as_it_goes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, note: dict[str, object], commit: str
) -> None:
    monkeypatch.setattr(manifest, "__file__", str(tmp_path / "manifest.py"))
    monkeypatch.setattr(manifest, "_direct_url", lambda: note)
    assert manifest.git_revision() == commit


@pytest.mark.parametrize("text", [None, "", "nonsense", "[1]"])
def test_a_note_of_pip_that_is_missing_or_damaged_is_no_note(
    monkeypatch: pytest.MonkeyPatch, text: str | None
) -> None:
    class Installed:
        def read_text(self, name: str) -> str | None:
            assert name == "direct_url.json"
            return text

    monkeypatch.setattr(importlib.metadata, "distribution", lambda name: Installed())
    assert manifest._direct_url() == {}


def test_every_package_that_makes_numbers_has_a_version() -> None:
    assert all(version[0].isdigit() for version in manifest.package_versions().values())


def test_a_files_digest_is_its_sha256(tmp_path: Path) -> None:
    (tmp_path / "a").write_bytes(b"recording")
    assert manifest.file_digest(tmp_path / "a") == hashlib.sha256(b"recording").hexdigest()
    assert manifest.file_digest(tmp_path) == ""


def test_the_sources_digest_is_the_same_twice() -> None:
    first = manifest.source_digest()
    manifest.source_digest.cache_clear()
    assert manifest.source_digest() == first
    assert len(first) == 64


def test_a_manifest_written_in_pieces_is_the_manifest_as_json(tmp_path: Path) -> None:
    made = make_campaign(tmp_path, [0.03, 0.05])
    config = load(made.config)
    findings = replace(small_findings(), notes=('an odd note: "inputs": []',))
    whole = json.dumps(manifest.manifest(findings, config, made.config), indent=1, allow_nan=False, ensure_ascii=False)
    pieces = manifest.manifest_pieces(manifest.provenance(findings, config, made.config), config)
    assert "".join(pieces) == whole
