"""What a run was made of: inputs, versions, seed, times.

Belongs here: provenance. Does not belong here: results.
"""

from __future__ import annotations

import importlib.metadata
import platform
import subprocess
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from undertow import __version__
from undertow.discrepancy.findings import Findings

PACKAGES = ("numpy", "scipy", "pandas", "scikit-learn", "pysindy", "numba", "matplotlib", "pydantic", "pint", "joblib")
"""Packages whose version can change a number."""


def manifest(findings: Findings, config_path: str, seed: int) -> dict[str, Any]:
    """Provenance of a run as plain values: inputs with sha256, versions, git revision, seed, wall time a stage (s)."""
    inputs = [
        {"trial": t.motion.name, "path": t.motion.recording.path, "sha256": t.motion.recording.sha256}
        for group in findings.groups
        for t in group.trials
    ]
    return {
        "undertow": __version__,
        "git_revision": git_revision(Path(__file__).parent),
        "python": platform.python_version(),
        "platform": platform.platform(),
        "packages": package_versions(),
        "config": config_path,
        "seed": seed,
        "wall_time_s": {stage: round(seconds, 3) for stage, seconds in findings.seconds.items()},
        "inputs": inputs,
        "failed": [{"trial": f.name, "reason": f.reason} for f in findings.failed],
        "notes": list(findings.notes),
    }


def package_versions() -> Mapping[str, str]:
    """Installed versions of the packages that make numbers."""
    return {name: importlib.metadata.version(name) for name in PACKAGES}


def git_revision(folder: Path) -> str:
    """Commit of the source, with "+" where it was changed since; empty outside a repository."""
    try:
        commit = _git(folder, "rev-parse", "HEAD")
        return commit + ("+" if _git(folder, "status", "--porcelain", "--untracked-files=no") else "")
    except (OSError, subprocess.SubprocessError):
        return ""


def _git(folder: Path, *words: str) -> str:
    done = subprocess.run(["git", "-C", str(folder), *words], capture_output=True, text=True, check=True, timeout=10)
    return done.stdout.strip()
