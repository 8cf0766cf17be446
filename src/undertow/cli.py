"""The terminal: commands, progress, exit codes. Results go to stdout, messages to stderr.

Belongs here: words typed and words printed. Does not belong here: any work; behind each command stands a function.
Exit 0 done, 1 failed, 2 usage or config, 3 done but some trials failed.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from undertow import __version__
from undertow.errors import ConfigError, UndertowError

if TYPE_CHECKING:
    from undertow.campaign.run import Progress

DONE, FAILED, USAGE, SOME_FAILED, INTERRUPTED = 0, 1, 2, 3, 130

app = typer.Typer(
    add_completion=False,
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    help="The equation of motion behind free-decay recordings, and the physics that a model leaves out.",
)

ConfigPath = Annotated[Path, typer.Argument(metavar="CONFIG", help="The campaign's YAML file (see configs/).")]
Overrides = Annotated[list[str] | None, typer.Option("--set", metavar="a.b=v", help="Replace one key of the config.")]


def _say(text: str) -> None:
    """A message to stderr."""
    typer.echo(text, err=True)


@contextmanager
def _bar() -> Iterator[Progress]:
    """A progress bar on stderr; plain lines where stderr is no terminal."""
    if not sys.stderr.isatty():

        def line(stage: str, done: int, of: int) -> None:
            if done in (0, of):
                _say(f"{stage}: {done} of {of}")

        yield line
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bar

    columns = (TextColumn("{task.description:22}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Bar(*columns, console=Console(stderr=True)) as bar:
        tasks: dict[str, object] = {}

        def update(stage: str, done: int, of: int) -> None:
            if stage not in tasks:
                tasks[stage] = bar.add_task(stage, total=of)
            bar.update(tasks[stage], completed=done, total=of)  # type: ignore[arg-type]

        yield update


@app.command()
def run(
    config: ConfigPath,
    overrides: Overrides = None,
    out: Annotated[Path | None, typer.Option("--out", metavar="DIR", help="Run folder; default runs/<name>.")] = None,
    jobs: Annotated[int, typer.Option("--jobs", min=0, help="Processes; 0: one a core.")] = 0,
    resume: Annotated[bool, typer.Option("--resume", help="Take finished groups from the run folder.")] = False,
) -> None:
    """The whole way, from recordings to report."""
    from undertow.campaign.folder import run_to_folder

    with _bar() as progress:
        finished = run_to_folder(config, overrides or (), out, jobs=jobs, resume=resume, progress=progress)
    typer.echo(finished.summary)
    if finished.failed:
        for trial in finished.failed:
            _say(f"failed: {trial.reason}")
        raise typer.Exit(SOME_FAILED)


@app.command()
def inspect(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="Recordings.")],
) -> None:
    """What is in a recording: channels, rate, gaps, noise, release, a proposed channel mapping."""
    from undertow.campaign.inspection import inspect_file

    bad = 0
    for file in files:
        try:
            typer.echo(inspect_file(file))
        except UndertowError as reason:
            bad += 1
            _say(f"{file}: {reason}")
    if bad:
        raise typer.Exit(FAILED if bad == len(files) else SOME_FAILED)


@app.command()
def compare(
    runs: Annotated[list[Path], typer.Argument(metavar="RUN...", help="Run folders.")],
    out: Annotated[Path | None, typer.Option("--out", metavar="FILE", help="Also write the table as HTML.")] = None,
) -> None:
    """Runs side by side."""
    from undertow.report.compare import compare_runs, comparison_html

    table = compare_runs(runs)
    if out is not None:
        from undertow.report.writing import write_text

        write_text(out, comparison_html(runs))
        _say(f"written: {out}")
    typer.echo(table.to_string(index=False))


@app.command()
def terms() -> None:
    """The shelf: every term, its law, unit, source, what it looks like when it is left out."""
    from undertow.campaign.inspection import describe_terms

    typer.echo(describe_terms())


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
    """Entry point: every expected error is one sentence and an exit code, never a traceback."""
    try:
        app(args=arguments, prog_name="undertow", standalone_mode=True)
    except ConfigError as error:
        _say(f"undertow: {error}")
        sys.exit(USAGE)
    except (UndertowError, OSError) as error:
        _say(f"undertow: {error}")
        sys.exit(FAILED)
    except KeyboardInterrupt:
        _say("undertow: interrupted; what was finished is kept, --resume goes on from there")
        sys.exit(INTERRUPTED)


if __name__ == "__main__":
    main()
