"""What a run was made of: inputs, versions, seed, times.

Belongs here: provenance. Does not belong here: results.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
import os
import platform
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from itertools import chain
from pathlib import Path
from textwrap import indent
from typing import Any
from urllib.parse import urlsplit
from urllib.request import url2pathname

from undertow import __version__
from undertow.campaign.config import RunConfig
from undertow.discrepancy.findings import Findings
from undertow.recording.gather import gather

PACKAGES = ("numpy", "scipy", "pandas", "scikit-learn", "pysindy", "numba", "matplotlib", "pydantic", "pint", "joblib")
"""Packages whose version can change a number."""


def manifest(findings: Findings, config: RunConfig, config_path: Path, overrides: Sequence[str] = ()) -> dict[str, Any]:
    """Provenance of a run as plain values: inputs with sha256, versions, git revision, seed, wall time a stage (s).

    Inputs are the config, the index where there is one, and every trial's file, those that failed among them.
    """
    return provenance(findings, config, config_path, overrides) | {"inputs": list(_inputs(config))}


def provenance(
    findings: Findings, config: RunConfig, config_path: Path, overrides: Sequence[str] = ()
) -> dict[str, Any]:  # fmt: skip
    """The manifest but for its list of inputs, which is as long as the campaign."""
    return {
        "undertow": __version__,
        "git_revision": git_revision(),
        "source_sha256": source_digest(),
        "python": platform.python_version(),
        "platform": platform.platform(),
        "packages": package_versions(),
        "config": str(config_path),
        "config_sha256": file_digest(config_path),
        "overrides": list(overrides),
        "seed": config.seed,
        "wall_time_s": {stage: round(seconds, 3) for stage, seconds in findings.seconds.items()},
        "inputs": [],
        "failed": [{"trial": f.name, "reason": f.reason} for f in findings.failed],
        "notes": list(findings.notes),
    }


def manifest_pieces(made: Mapping[str, Any], config: RunConfig) -> Iterator[str]:
    """The text of manifest.json, input by input, from its `provenance`."""
    text = json.dumps({**made, "inputs": []}, indent=1, allow_nan=False, ensure_ascii=False)
    head, tail = text.split('"inputs": []', 1)
    yield f'{head}"inputs": ['
    before = ""
    for row in _inputs(config):
        yield f"{before}\n{indent(json.dumps(row, indent=1, ensure_ascii=False), '  ')}"
        before = ","
    yield ("\n ]" if before else "]") + tail


def _inputs(config: RunConfig) -> Iterator[dict[str, str]]:
    """The index and every trial's file: trial, path, sha256 (empty where the file is not there)."""
    catalogue = config.catalogue()
    index = [] if catalogue.index is None else [("index", catalogue.folder / catalogue.index)]
    for name, path in chain(index, ((entry.name, entry.path) for entry in gather(catalogue))):
        yield {"trial": name, "path": os.path.normpath(path), "sha256": file_digest(path)}


def file_digest(path: Path) -> str:
    """A file's sha256 in hexadecimal; empty where it cannot be read.

    >>> file_digest(Path("not there"))
    ''
    """
    try:
        with path.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()
    except OSError:
        return ""


def package_versions() -> Mapping[str, str]:
    """Installed versions of the packages that make numbers."""
    return {name: importlib.metadata.version(name) for name in PACKAGES}


@cache
def source_digest() -> str:
    """sha256 over undertow's own sources: two runs with the same one were made by the same code."""
    root = Path(__file__).resolve().parents[2]
    sums = hashlib.sha256()
    for path in sorted([*root.rglob("*.py"), *root.rglob("*.j2")]):
        sums.update(path.relative_to(root).as_posix().encode() + b"\0" + path.read_bytes())
    return sums.hexdigest()


def git_revision() -> str:
    """Commit of the source, with "+" where it was changed since; empty where it is not known.

    The source is the repository that holds this file, or the one that the package was installed from.
    """
    here = Path(__file__).resolve()
    try:
        _git(here.parent, "ls-files", "--error-unmatch", here.name)
        return _revision(here.parent)
    except (OSError, subprocess.SubprocessError):
        return _installed_revision(_direct_url())


def _direct_url() -> Mapping[str, Any]:
    """What pip noted of an installation from a folder or a repository (PEP 610); empty where it was neither."""
    try:
        text = importlib.metadata.distribution("undertow").read_text("direct_url.json")
        found = json.loads(text or "{}")
    except (importlib.metadata.PackageNotFoundError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def _installed_revision(direct_url: Mapping[str, Any]) -> str:
    """Commit that an installation came from, by pip's note of it."""
    commit = direct_url.get("vcs_info", {}).get("commit_id", "")
    address = urlsplit(str(direct_url.get("url", "")))
    if commit or address.scheme != "file":
        return str(commit)
    try:
        return _revision(Path(url2pathname(address.path)))
    except (OSError, subprocess.SubprocessError):
        return ""


def _revision(folder: Path) -> str:
    commit = _git(folder, "rev-parse", "HEAD")
    return commit + ("+" if _git(folder, "status", "--porcelain", "--untracked-files=no") else "")


def _git(folder: Path, *words: str) -> str:
    done = subprocess.run(["git", "-C", str(folder), *words], capture_output=True, text=True, check=True, timeout=10)
    return done.stdout.strip()
