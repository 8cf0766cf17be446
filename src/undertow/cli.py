"""The terminal: commands, progress, exit codes. Results go to stdout, messages to stderr.

Belongs here: words typed and words printed. Does not belong here: any work; behind each command stands a function.
Exit 0 done, 1 failed, 2 usage or config, 3 done but some trials failed, 130 interrupted.
"""

from __future__ import annotations

import math
import os
import shutil
import signal
import sys
import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from typer.core import TyperGroup

from undertow import __version__
from undertow.errors import ConfigError, UndertowError, is_interrupt

if TYPE_CHECKING:
    from undertow.campaign.run.workers import Progress

DONE, FAILED, USAGE, SOME_FAILED, INTERRUPTED = 0, 1, 2, 3, 130


class _Commands(TyperGroup):
    """Every expected error of a command is one sentence and an exit code, never a traceback."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        from undertow.front.terminal.empty_words import empty_word
        if said := empty_word(args):
            ctx.fail(said)
        return super().parse_args(ctx, args)

    def invoke(self, ctx: Any) -> Any:
        try:
            with _terminable():
                return super().invoke(ctx)
        except ConfigError as error:
            _say(f"undertow: {error}")
            raise typer.Exit(USAGE) from error
        except BrokenPipeError:
            raise  # whoever read stdout has gone; typer ends quietly
        except UndertowError as error:
            _say(f"undertow: {error}")
            raise typer.Exit(FAILED) from error
        except OSError as error:
            _say(f"undertow: {error.filename or 'a file'}: {error.strerror or error}; check path, rights, space")
            raise typer.Exit(FAILED) from error
        except (KeyboardInterrupt, SystemError) as interruption:
            if not is_interrupt(interruption):
                raise
            noted = "; ".join(getattr(interruption, "__notes__", ()))
            _say("; ".join(filter(None, ("undertow: interrupted", noted or _GOES_ON.get(ctx.invoked_subcommand, "")))))
            raise typer.Exit(INTERRUPTED) from interruption


_IDLE_WORKER = "A worker stopped while some jobs were given to the executor"
"""What joblib warns of where a worker was idle for minutes and ended itself: it starts another one."""

_GOES_ON = {
    "run": "nothing was written, the same command begins anew",
    "fetch": "what was fetched is kept, the same command goes on from there",
}

app = typer.Typer(
    cls=_Commands,
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    help="The equation of motion behind free-decay recordings, and the physics that a model leaves out.",
)

ConfigPath = Annotated[Path, typer.Argument(metavar="CONFIG", help="The campaign's YAML file (see configs/).")]
AsJson = Annotated[bool, typer.Option("--json", help="Print the result as JSON on stdout, nothing else.")]
Quiet = Annotated[bool, typer.Option("--quiet", "-q", help="No progress, and of the result the last line alone.")]
Verbose = Annotated[bool, typer.Option("--verbose", "-v", help="A line of progress an item; every group's sentence.")]
Overrides = Annotated[list[str] | None, typer.Option("--set", metavar="a.b=v", help="Replace a key; repeatable.")]


def _run_folders(incomplete: str) -> list[str]:
    """Folders that begin so and hold a run, or others to go into: for completion."""
    from undertow.front.terminal.completion import run_folders
    return run_folders(incomplete)


def _groups(ctx: typer.Context, incomplete: str) -> list[str]:
    """Titles of the run's groups: for completion."""
    from undertow.front.terminal.completion import group_titles
    return group_titles(ctx.params.get("run"), incomplete)


def _term_names(incomplete: str) -> list[str]:
    """Terms of the registry: for completion."""
    from undertow.front.terminal.completion import term_names
    return term_names(incomplete)


def _say(text: str) -> None:
    """A message to stderr."""
    typer.echo(text, err=True)


@contextmanager
def _terminable() -> Iterator[None]:
    """SIGTERM ends the block as Ctrl-C does, so that worker processes end with it."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def interrupt(number: int, frame: object) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


@contextmanager
def _progress(quiet: bool = False, verbose: bool = False) -> Iterator[Progress]:
    """Progress on stderr: bars on a terminal, elsewhere a line every few seconds, one an item where ``verbose``."""
    if quiet:
        from undertow.campaign.run.workers import silent
        yield silent
    elif sys.stderr.isatty() and not verbose:
        from rich.console import Console

        from undertow.front.terminal.progress import bars_shown
        with bars_shown(Console(stderr=True)) as bars:
            yield bars
    else:
        from undertow.front.terminal.progress import lines_shown
        with lines_shown(_say, each=verbose) as lines:
            yield lines


def _print_json(value: object) -> None:
    """A result as JSON on stdout."""
    import json
    typer.echo(json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False))


def _width_and_colour() -> tuple[int, bool]:
    """Of the terminal that stdout is; 0 and none where it is none. Colour is left out where NO_COLOR is set."""
    if not sys.stdout.isatty():
        return 0, False
    return shutil.get_terminal_size().columns, not os.environ.get("NO_COLOR")


@app.command()
def run(
    config: ConfigPath,
    overrides: Overrides = None,
    out: Annotated[Path | None, typer.Option("--out", metavar="DIR", help="Run folder; default runs/<name>.")] = None,
    jobs: Annotated[int, typer.Option("--jobs", metavar="N", min=0, help="Worker processes; 0: one a core.")] = 0,
    resume: Annotated[bool, typer.Option("--resume", help="Take finished groups from the run folder.")] = False,
    as_json: AsJson = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
    scheduler: Annotated[
        str, typer.Option("--scheduler", metavar="ADDRESS", help="A Dask cluster's, such as tcp://host:8786.")
    ] = "",
    page: Annotated[bool, typer.Option("--page/--no-page", help="The page, or tables and verdicts alone.")] = True,
) -> None:
    """Go the whole way, from recordings to a report; print a table of verdicts."""
    if quiet and verbose:
        raise typer.BadParameter("--quiet and --verbose contradict each other; give one of them")
    with warnings.catch_warnings():
        from undertow.campaign.config import load
        load(config, overrides or ())  # what is wrong with it is said before the rest is imported, seconds later
        from undertow.campaign.run.cluster import on_cluster
        from undertow.campaign.run.folder import run_to_folder
        warnings.filterwarnings("ignore", _IDLE_WORKER)
        with on_cluster(scheduler), _progress(quiet, verbose) as say:
            finished = run_to_folder(config, overrides or (), out, jobs=jobs, resume=resume, progress=say, page=page)
    from undertow.front.terminal.verdicts import last_line, run_json, run_text
    if as_json:
        _print_json(run_json(finished))
    else:
        typer.echo(last_line(finished) if quiet else run_text(finished, *_width_and_colour(), verbose=verbose))
    for trial in finished.failed:
        _say(f"failed: {trial.reason if trial.name in trial.reason else f'{trial.name}: {trial.reason}'}")
    for sentence in finished.contradicted:
        _say(f"channels contradict each other: {sentence}")
    if finished.failed or finished.contradicted:
        raise typer.Exit(SOME_FAILED)


@app.command()
def init(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Where the recordings are.")],
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE", help="Config; default FOLDER/undertow.yaml.")
    ] = None,
    quiet: Quiet = False,
) -> None:
    """Write a config that runs as it is for a folder's recordings: layouts, channels, conditions from names."""
    from undertow.campaign.starting import start
    with _progress(quiet) as progress:
        started = start(folder, out, progress)
    typer.echo(started.summary)


@app.command()
def inspect(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="Recordings.")],
    save: Annotated[bool, typer.Option("--save", help="Write the proposed config beside each file.")] = False,
) -> None:
    """Say what is in a recording: channels, rate, gaps, noise, release, a proposed config."""
    from undertow.campaign.inspection import inspect_file, save_config
    bad = 0
    for file in files:
        try:
            told = inspect_file(file)
            typer.echo(told)
            if save:
                _say(f"written: {save_config(file, told)}")
        except UndertowError as reason:
            bad += 1
            _say(f"undertow: {reason if str(file) in str(reason) else f'{file}: {reason}'}")
    if bad:
        none = FAILED if any(file.exists() for file in files) else USAGE
        raise typer.Exit(none if bad == len(files) else SOME_FAILED)


@app.command()
def compare(
    runs: Annotated[list[Path], typer.Argument(metavar="RUN...", help="Run folders.", autocompletion=_run_folders)],
    out: Annotated[Path | None, typer.Option("--out", metavar="FILE", help="Also write the table as HTML.")] = None,
    whole: Annotated[bool, typer.Option("--all", help="Also what is the same in all runs.")] = False,
    as_json: AsJson = False,
) -> None:
    """Put runs side by side: what changed in verdicts, errors, prescribed and repaired parameters."""
    from undertow.front.terminal.changes import comparison_json, comparison_text
    from undertow.report.verdict_file import as_runs_write_them
    with as_runs_write_them(runs):
        if as_json:
            _print_json(comparison_json(runs))
        else:
            typer.echo(comparison_text(runs, whole, *_width_and_colour()))
        if out is not None:
            from undertow.report.compare import comparison_html
            from undertow.report.writing import write_text
            write_text(out, comparison_html(runs))
            _say(f"written: {out}")


@app.command("open")
def open_page(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="A run folder.", autocompletion=_run_folders)],
) -> None:
    """Open the page of a run in the browser."""
    from undertow.front.opening import page_of, show
    from undertow.report.verdict_file import must_be_there
    must_be_there([run])
    typer.echo(str(page_of(run)))
    show(run)


@app.command()
def explain(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="A run folder.", autocompletion=_run_folders)],
    group: Annotated[
        str, typer.Option("--group", metavar="G", help="Groups that these words fit.", autocompletion=_groups)
    ] = "",
    as_json: AsJson = False,
) -> None:
    """List every condition behind each verdict: statistic, value, what is asked for, what follows."""
    from undertow.report.explain import explain_text, explained
    from undertow.report.verdict_file import as_runs_write_them
    with as_runs_write_them([run]):
        if as_json:
            _print_json(explained(run, group))
        else:
            typer.echo(explain_text(run, group))


@app.command()
def differ(
    simulation: Annotated[Path, typer.Option("--simulation", metavar="FILE", help="One simulated release, any code.")],
    recording: Annotated[Path, typer.Option("--recording", metavar="FILE", help="One recorded release.")],
    config: Annotated[
        Path | None, typer.Option("--config", metavar="C", help="Which columns are what; default: by their names.")
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", metavar="DIR", help="Folder; default: runs/differ_...")] = None,
) -> None:
    """Compare a simulation made elsewhere with a recording: where they differ, what physics it lacks."""
    from undertow.campaign.differ.files import differ as differ_files
    typer.echo(differ_files(simulation, recording, config, out).summary)


@app.command()
def predict(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="A run folder.")],
    recording: Annotated[
        Path | None, typer.Option("--recording", metavar="FILE", help="A recording that nobody fitted.")
    ] = None,
    x0: Annotated[float, typer.Option(metavar="V", help="Release from V m (rad).", show_default=False)] = math.nan,
    duration: Annotated[float, typer.Option(metavar="S", help="From x0: for S s.", show_default=False)] = math.nan,
    rate: Annotated[float, typer.Option(metavar="HZ", help="Samples a second.", show_default=False)] = math.nan,
    group: Annotated[str, typer.Option("--group", metavar="G", help="The group: its words, as spring=short.")] = "",
    start: Annotated[int, typer.Option("--start", metavar="N", help="Driven: samples used to find the start.")] = 50,
    config: Annotated[
        Path | None, typer.Option("--config", metavar="C", help="Which columns are what; default: the run's config.")
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", metavar="FILE.csv", help="The table with its 90 % band.")] = None,
) -> None:
    """Run a finished run's equation on a recording that nobody fitted, or from --x0 for --duration at --rate."""
    from undertow.front.run_prediction import predict_any
    from undertow.report.verdict_file import as_runs_write_them
    with as_runs_write_them([run], "equations.json"):
        made = predict_any(run, recording, (x0, duration, rate), group, start, config, out)
    if out is not None:
        _say(f"written: {out}")
    for message in getattr(made, "messages", ()):
        _say(message)
    typer.echo(str(made))


@app.command()
def fetch(
    source: Annotated[str, typer.Argument(metavar="DOI-or-URL", help="A Zenodo record, or a file's address.")],
    into: Annotated[Path, typer.Option("--into", metavar="DIR", help="Folder of the files; default: here.")] = Path(),
    checksum: Annotated[
        str, typer.Option("--checksum", metavar="ALGORITHM:HEX", help="What a file's checksum must be, if known.")
    ] = "",
    quiet: Quiet = False,
) -> None:
    """Download a public record: checksums are compared, a download that was cut goes on."""
    from undertow.campaign.fetch.records import fetch as fetch_files
    with _progress(quiet) as progress:
        for file in fetch_files(source, into, checksum=checksum, progress=progress):
            typer.echo(str(file))


@app.command()
def terms(
    names: Annotated[
        list[str] | None,
        typer.Argument(metavar="[TERM]...", help="Only these; default: all.", autocompletion=_term_names),
    ] = None,
) -> None:
    """List every term: its law, unit, source, what it looks like when left out; then other names in verdicts."""
    from undertow.campaign.terms import describe_terms
    typer.echo(describe_terms(names or ()))


@app.command()
def audit(
    config: ConfigPath,
    overrides: Overrides = None,
    out: Annotated[Path | None, typer.Option("--out", metavar="DIR", help="Folder; default runs/<name>.")] = None,
    as_json: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Check published tables: what physics their trends and disagreements betray; write audit.json and audit.html."""
    from undertow.campaign.audit.published import audit_to_folder
    from undertow.report.audit_page import audit_text
    with _progress(quiet) as progress:
        findings, folder = audit_to_folder(config, out, overrides or (), progress)
    if as_json:
        typer.echo((folder / "audit.json").read_text(encoding="utf-8").rstrip())
        return
    for series in findings.series:
        typer.echo(f"{series.name}: {audit_text(series.verdict.sentence)}")
    typer.echo(f"{len(findings.checks)} things do not fit together; written: {folder / 'audit.html'}")


@app.callback(invoke_without_command=True)
def _version(
    context: typer.Context, version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False
) -> None:
    if version:
        typer.echo(f"undertow {__version__}")
        raise typer.Exit(DONE)
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


def main(arguments: list[str] | None = None) -> None:
    """Entry point: runs the command line (``sys.argv`` where None) and exits with its code.

    >>> main(["--version"])
    Traceback (most recent call last):
    SystemExit: 0
    """
    app(args=arguments, prog_name="undertow", standalone_mode=True)


if __name__ == "__main__":
    main()
