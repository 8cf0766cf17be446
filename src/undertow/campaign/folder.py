"""The run folder: what a finished campaign leaves on disk.

Belongs here: names and order of files. Does not belong here: their content (report/, manifest.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from io import StringIO
from pathlib import Path
from typing import Any

from ruamel.yaml import YAML

from undertow.campaign.config import load
from undertow.campaign.manifest import manifest
from undertow.campaign.run import Progress, run
from undertow.discrepancy.findings import FailedTrial, Findings
from undertow.errors import UndertowError


@dataclass(frozen=True)
class Finished:
    """What ``undertow run`` says when it is done."""

    folder: Path
    findings: Findings

    @property
    def failed(self) -> tuple[FailedTrial, ...]:
        """Trials that could not be used."""
        return self.findings.failed

    @property
    def summary(self) -> str:
        """Every group's sentence, the campaign's, and where the report is."""
        lines = [group.verdict.sentence for group in self.findings.groups]
        return "\n".join([*lines, self.findings.across_groups, f"report: {self.folder / 'report.html'}"])


def run_to_folder(
    config_path: Path,
    overrides: Sequence[str] = (),
    out: Path | None = None,
    *,
    jobs: int = 0,
    resume: bool = False,
    progress: Progress | None = None,
) -> Finished:
    """Run a campaign and write its folder (default ``runs/<name>``); finished groups are kept as they come.

    Raises ConfigError where the config is wrong, UndertowError where no trial can be used or the folder cannot be
    written.
    """
    from undertow.report.html import write_report
    from undertow.report.tables import write_tables
    from undertow.report.verdict_file import write_verdict
    from undertow.report.writing import write_text

    config = load(config_path, overrides)
    folder = out or Path("runs") / safe_name(config.name)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as reason:
        raise UndertowError(f"run folder {folder} cannot be made: {reason.strerror}; choose another with --out") from reason
    text = yaml_text(config.resolved())
    write_text(folder / "config.yaml", text)
    findings = run(config, jobs, progress or _silent, folder / "stages", resume)
    provenance = manifest(findings, str(config_path), config.seed)
    write_tables(findings, folder)
    write_verdict(findings, folder / "verdict.json")
    write_json(folder / "manifest.json", provenance)
    write_report(findings, folder, provenance | {"config_text": text})
    return Finished(folder, findings)


def _silent(stage: str, done: int, of: int) -> None:
    """No progress."""


def safe_name(name: str) -> str:
    """A folder name from a campaign's: letters, digits, dash, underscore; anything else becomes an underscore.

    >>> safe_name("../flume 2")
    '___flume_2'
    """
    return "".join(c if c.isalnum() or c in "-_" else "_" for c in name) or "run"


def yaml_text(data: dict[str, Any]) -> str:
    """Plain values as YAML."""
    writer = YAML()
    writer.default_flow_style = None
    stream = StringIO()
    writer.dump(data, stream)
    return stream.getvalue()


def write_json(path: Path, data: dict[str, Any]) -> None:
    """Plain values as JSON, whole or not at all."""
    import json

    from undertow.report.writing import write_text

    write_text(path, json.dumps(data, indent=1, allow_nan=False, ensure_ascii=False))
