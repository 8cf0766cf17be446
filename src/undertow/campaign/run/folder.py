"""The run folder: what a finished campaign leaves on disk.

Belongs here: names and order of files. Does not belong here: their content (report/, manifest.py).
"""

from __future__ import annotations

import json
import logging
import shutil
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from ruamel.yaml import YAML

from undertow.campaign.config import RunConfig, load
from undertow.campaign.config.matching import planned
from undertow.campaign.driven.run import DrivenFinished, run_driven
from undertow.campaign.driven.trials import is_driven
from undertow.campaign.response.run import run_response
from undertow.campaign.run.claim import NEW, STAGES, claimed, refuse_foreign_files
from undertow.campaign.run.course import Course
from undertow.campaign.run.equations import equations_entry, equations_file
from undertow.campaign.run.gathered import Gathered, PortionFindings
from undertow.campaign.run.manifest import manifest_pieces, provenance
from undertow.campaign.run.portions import group_order
from undertow.campaign.run.workers import Progress, on_processes, silent
from undertow.discrepancy.findings import FailedTrial, Findings
from undertow.discrepancy.words import count
from undertow.errors import FAILURES, UndertowError, failure
from undertow.recording.run_files import MARK, TABLES
from undertow.report.extent import Extent
from undertow.report.html import write_report
from undertow.report.tables import RunTables
from undertow.report.writing import write_pieces, write_text

PAGE = "report.html"

RESULTS = (PAGE, "verdict.json", *TABLES, "equations.json", MARK)
"""What is moved into `EARLIER` when a later run in the same folder fails."""

FIGURES, NOTES = "figures", "notes.txt"
"""What stands beside the page, and what a run of many trials has to say of them."""

EARLIER = "earlier_run"

NO_PARTS = "a campaign of driven bodies keeps no parts: the same command begins anew"
"""What is said of one that was interrupted."""

PARTS_KEPT = "finished groups are kept in the run folder, the same command with --resume goes on from there"
NONE_FINISHED = "no group was finished, the same command begins anew"
"""What is said of an interrupted campaign of decays."""

DOUBTS_PRINTED = 10
"""Doubts about the recordings that the terminal shows."""

LONGEST_NAME = 80
"""Characters of a run folder's name at most: file systems take 255 bytes, and a letter may have four."""


@dataclass(frozen=True)
class Finished:
    """What ``undertow run`` says when it is done; ``contradicted`` are sentences of groups whose channels disagree."""

    folder: Path
    findings: Findings
    extent: Extent = field(default_factory=Extent)
    contradicted: tuple[str, ...] = ()
    page: bool = True

    @property
    def failed(self) -> tuple[FailedTrial, ...]:
        """Trials that could not be used."""
        return self.findings.failed

    @property
    def told(self) -> Path:
        """The file that tells most: the page, or verdict.json where none was asked for."""
        return self.folder / (PAGE if self.page else "verdict.json")

    @property
    def summary(self) -> str:
        """Every group's sentence (of many groups: of those shown), the campaign's, doubts, and where the report is."""
        lines = [group.verdict.sentence for group in self.findings.groups]
        if more := self.extent.groups - len(lines):
            lines.append(f"{count(more, 'more group')}: {self.folder / 'verdict.json'}")
        doubts = [f"doubt: {one}" for one in self.findings.doubts[:DOUBTS_PRINTED]]
        if more := len(self.findings.doubts) - len(doubts):
            doubts.append(f"{count(more, 'more doubt')}: {self.told}")
        return "\n".join([*lines, self.findings.across_groups, *doubts, f"report: {self.told}"])


def run_to_folder(
    config_path: Path,
    overrides: Sequence[str] = (),
    out: Path | None = None,
    *,
    jobs: int = 0,
    resume: bool = False,
    progress: Progress = silent,
    page: bool = True,
) -> Finished | DrivenFinished:
    """Run a campaign and write its folder (default ``runs/<name>``); finished groups are kept as they come.

    Without ``page`` tables, verdicts and equations are all that is written, in about half of the time; the page of an
    older run goes to `EARLIER`, for it would show other numbers.

    An older run's files stay until the new ones are ready, and are moved into `EARLIER` where the new run fails.
    ``config.yaml`` is there from the start, unless an older one is, so that an interrupted run can go on from its
    folder. Tables and verdict.json hold everything; the findings that are returned, and the page, at most as many
    groups and trials as a page can show (`gathered`).

    Raises ConfigError where the config is wrong, UndertowError where no trial can be used, the folder cannot be
    written or holds files of these names that no run has written, or another run is at work in it.
    """
    config = load(config_path, overrides)
    folder = out or Path("runs") / safe_name(config.name)
    text = yaml_text(config.resolved())
    refuse_foreign_files(folder, config_path, (*RESULTS, FIGURES, NOTES), (MARK, STAGES, EARLIER))
    try:
        if config.recordings.response is not None or is_driven(config):
            if jobs > 1:
                said = "--jobs %d: a campaign of driven bodies runs in one process"
                logging.getLogger("undertow").warning(said, jobs)
            return _of_driven(config, config_path, folder, text, overrides, resume, progress, page)
        stages = (folder / STAGES).absolute()  # workers of a cluster have other working directories
        course, gathered = Course(config, jobs, progress, stages, resume), Gathered(config)
        folder.mkdir(parents=True, exist_ok=True)  # a config that does not match its trials leaves no folder
        with _kept_said(stages), claimed(folder), _new_results(folder) as new:
            _prepare(folder, config_path, text)
            with RunTables(new) as tables:
                equations: list[tuple[tuple[object, ...], Any]] = []
                scatter = None if config.specimen.scatter is None else dict(config.specimen.scatter)
                for part in _or_set_aside(course.parts(), folder):
                    _take(part, gathered, tables, equations, scatter)
                    del part  # else two portions would be held
                start, seconds = time.perf_counter(), course.seconds
                del course  # its list of trials is as long as the campaign, and the manifest makes another
                findings = gathered.findings(seconds)
                write_text(new / "config.yaml", text)
                tables.write(findings.failed, findings.across_groups)
                entries = [entry for _, entry in sorted(equations, key=lambda one: str(one[0]))]
                write_json(new / "equations.json", equations_file(entries, config))
            made = provenance(findings, config, config_path, overrides)
            if page:
                write_report(findings, new, made | {"config_text": text}, gathered.extent, _Drawing(jobs))
            else:
                _set_aside(folder, (PAGE, FIGURES))
            made["wall_time_s"]["report"] = round(time.perf_counter() - start, 3)
            write_pieces(new / MARK, manifest_pieces(made, config))
    except OSError as reason:
        what = f"{reason.strerror or reason} ({reason.filename or folder})"
        raise UndertowError(f"run folder {folder} cannot be written: {what}; choose another with --out") from reason
    return Finished(folder, findings, gathered.extent, tuple(gathered.contradicted), page)


@contextmanager
def _kept_said(stages: Path) -> Iterator[None]:
    """An interruption of the block says whether finished groups are kept in the folder of parts."""
    try:
        yield
    except (KeyboardInterrupt, SystemError) as interruption:
        interruption.add_note(PARTS_KEPT if any(stages.glob("*.json")) else NONE_FINISHED)
        raise


def _of_driven(
    config: RunConfig, config_path: Path, folder: Path, text: str, overrides: Sequence[str], resume: bool,
    progress: Progress, page: bool,
) -> DrivenFinished:  # fmt: skip
    """A campaign of driven bodies into the folder, which is claimed and takes the new files as one of decays does."""
    planned(config)  # a config that does not match its trials leaves no folder
    if resume:
        logging.getLogger("undertow").warning("--resume: a campaign of driven bodies keeps no parts; it is made again")
    work, fresh = run_driven if config.recordings.response is None else run_response, not folder.exists()
    folder.mkdir(parents=True, exist_ok=True)
    try:
        with claimed(folder), _new_results(folder) as new:
            _prepare(folder, config_path, text)
            with _whole_or_aside(folder):
                done = work(config, config_path, new, text, overrides, progress, page)
            if not page:
                _set_aside(folder, (PAGE, FIGURES))
    except UndertowError:
        if fresh:
            _leave_none(folder)
        raise
    except (KeyboardInterrupt, SystemError) as interruption:
        interruption.add_note(NO_PARTS)
        raise
    return replace(done, folder=folder)


def _leave_none(folder: Path) -> None:
    """Take away a folder that holds a config alone: of a run that found nothing to write."""
    (folder / "config.yaml").unlink(missing_ok=True)
    with suppress(OSError):  # it holds more
        folder.rmdir()


@dataclass(frozen=True)
class _Drawing:
    """Draws the page's groups on as many processes as the run has."""

    jobs: int

    def __call__(self, work: Callable[[Any], Any], items: Sequence[Any]) -> list[Any]:
        return on_processes(work, items, self.jobs, "report")


@contextmanager
def _new_results(folder: Path) -> Iterator[Path]:
    """A folder for a run's files, which take the places of an older run's when all of them are written."""
    with TemporaryDirectory(dir=folder, prefix=NEW, ignore_cleanup_errors=True) as made:
        new = Path(made)
        yield new
        for one in sorted(new.iterdir(), key=lambda path: (path.name == MARK, path.name)):
            there = folder / one.name
            if there.is_dir():
                there.replace(new / f"older {one.name}")
            one.replace(there)


def _take(
    part: PortionFindings,
    gathered: Gathered,
    tables: RunTables,
    equations: list[tuple[tuple[object, ...], Any]],
    scatter: Mapping[str, float] | None,
) -> None:
    """One portion's groups into the tables and among the equations, and what the page shows of them kept."""
    gathered.add(part)
    tables.note(part.notes)
    for group in part.groups:
        order = group_order(group.key.items(), group.dry)
        tables.add(group, order)
        equations.append((order, equations_entry(group, scatter)))


def _prepare(folder: Path, config_path: Path, text: str) -> None:
    """The resolved config into the folder; refuse to write over a config that says something else."""
    kept = folder / "config.yaml"
    if not kept.exists():
        write_text(kept, text)
    elif kept.samefile(config_path) and kept.read_text(encoding="utf-8") != text:
        raise UndertowError(
            f"run folder {folder} holds the config itself, {config_path}, which its resolved form with --set would "
            "replace; choose another folder with --out"
        )


def _or_set_aside(parts: Iterator[PortionFindings], folder: Path) -> Iterator[PortionFindings]:
    """The parts of a run; an older run's results are set aside where none comes."""
    with _whole_or_aside(folder):
        yield from parts


@contextmanager
def _whole_or_aside(folder: Path) -> Iterator[None]:
    """Where the block fails, an older run's results are set aside; a library's error becomes a sentence."""
    try:
        yield
    except FAILURES as reason:
        _set_aside(folder)
        if isinstance(reason, UndertowError):
            raise
        raise UndertowError(failure(reason)) from reason


def _set_aside(folder: Path, names: Sequence[str] = RESULTS) -> None:
    """Move an older run's results out of the way of one that failed, or makes none of these: nobody takes them for its
    own."""
    found = [path for path in (folder / name for name in names) if path.exists()]
    if not found or not (folder / MARK).exists():
        return
    earlier = folder / EARLIER
    earlier.mkdir(exist_ok=True)
    for path in found:
        if (earlier / path.name).is_dir():
            shutil.rmtree(earlier / path.name)
        path.replace(earlier / path.name)


def safe_name(name: str) -> str:
    """A folder name from a campaign's: letters, digits, dash, underscore; anything else becomes an underscore.

    >>> safe_name("../flume 2")
    '___flume_2'
    """
    return "".join(c if c.isalnum() or c in "-_" else "_" for c in name)[:LONGEST_NAME] or "run"


def yaml_text(data: dict[str, Any]) -> str:
    """Plain values as YAML."""
    writer = YAML()
    writer.default_flow_style = None
    stream = StringIO()
    writer.dump(data, stream)
    return stream.getvalue()


def write_json(path: Path, data: dict[str, Any]) -> None:
    """Plain values as JSON, whole or not at all."""
    write_text(path, json.dumps(data, indent=1, allow_nan=False, ensure_ascii=False))
