"""Words of the command line that cannot be followed: other commands than ``run`` among them.

Belongs here: commands and their arguments. Does not belong here: configs (configs.py).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from experiments.bad_inputs.case import USAGE, Case, run_words

Spoilt = Callable[[Path], list[str]]


def run(*more: str) -> Spoilt:
    """``run`` with more words; ``{}`` stands for the folder."""
    return lambda folder: run_words(folder, *(word.replace("{}", str(folder)) for word in more))


def words(*said: str) -> Spoilt:
    """Any command; ``{}`` stands for the folder."""
    return lambda folder: [word.replace("{}", str(folder)) for word in said]


def files(*contents: tuple[str, bytes], then: Sequence[str]) -> Spoilt:
    """Files, then a command."""

    def spoil(folder: Path) -> list[str]:
        for name, content in contents:
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content)
        return [word.replace("{}", str(folder)) for word in then]

    return spoil


CASES = (
    Case("a negative number of processes", run("--jobs", "-1"), r"Invalid value for '--jobs'", USAGE),
    Case("an option that is none", run("--colour"), r"No such option", USAGE),
    Case("a run folder that is a file", run("--out", "{}/r00.csv"), r"run folder .*r00\.csv cannot be written: File"),
    Case("a run folder below a file", run("--out", "{}/r00.csv/run"), r"cannot be written: Not a directory .*--out"),
    Case("a run folder that cannot be written", run("--out", "/proc/undertow"), r"run folder /proc/undertow cannot be"),
    Case("the campaign's folder as run folder", run("--out", "{}"), r"holds the config itself"),
    Case("a scheduler that is none", run("--scheduler", "host"), r"--scheduler 'host' cannot be reached", USAGE),
    Case("inspect of a text", words("inspect", "{}/config.yaml"), r"no reader for '\.yaml'"),
    Case("inspect of a folder", words("inspect", "{}"), r"is a folder; check the path"),
    Case("inspect of nothing", words("inspect", "{}/none.csv"), r"none\.csv is not there; check the path", USAGE),
    Case("inspect of an index", words("inspect", "{}/campaign.csv"), r"no table of numbers begins in its first 2"),
    Case("init of no folder", words("init", "{}/none"), r"none"  , USAGE),
    Case("init of a folder without recordings", files(("e/a.yaml", b""), then=["init", "{}/e"]), r"e .*no", USAGE),
    Case("init of rubbish alone", files(("e/a.mat", b"\0" * 999), then=["init", "{}/e"]), r"a\.mat", USAGE),
    Case("init over a config", files(("undertow.yaml", b"name: mine"), then=["init", "{}"]), r"there already", USAGE),
    Case("compare of a folder without a run", words("compare", "{}"), r"verdict\.json cannot be read", code=2),
    Case("compare of a damaged run", files(("run/verdict.json", b"[" * 100_000), then=["compare", "{}/run"]),
         r"run folder .*verdict\.json"),
    Case("explain of a folder without a run", words("explain", "{}"), r"verdict\.json", code=2),
    Case("explain of a verdict that is none", files(("run/verdict.json", b"{}"), then=["explain", "{}/run"]),
         r"verdict\.json"),
    Case("terms of a word", words("terms", "lift"), r"'lift' is not in the registry", USAGE),
    Case("differ without a recording", words("differ", "--simulation", "{}/r00.csv", "--recording", "{}/none.csv"),
         r"--recording .*none\.csv is no file; give the path", USAGE),
    Case("audit of a campaign's config", words("audit", "{}/config.yaml"), r"config\.yaml", USAGE),
    Case("fetch of a word", words("fetch", "nonsense", "--into", "{}"), r"is neither a DOI nor an address", USAGE),
    Case("fetch of another's DOI", words("fetch", "10.1000/x", "--into", "{}"), r"is none of Zenodo's", USAGE),
    Case("fetch over http", words("fetch", "http://host/a.csv", "--into", "{}"), r"only https is fetched: correct it"),
    Case("fetch of a file's address", words("fetch", "file:///etc/passwd", "--into", "{}"), r"only https is fetched"),
    Case("fetch of an address with half a bracket", words("fetch", "https://[::1/a.csv", "--into", "{}"),
         r"cannot be read \(Invalid IPv6 URL\); correct it"),
    Case("fetch of a port that is none", words("fetch", "https://host:99999/a.csv", "--into", "{}"),
         r"cannot be read \(Port out of range"),
    Case("fetch of an address with blanks", words("fetch", "https://host/a b.csv", "--into", "{}"),
         r"cannot be read \(it has blanks"),
    Case("fetch without a file's name", words("fetch", "https://localhost/", "--into", "{}"), r"names a file ''"),
    Case("fetch of a name that leaves the folder", words("fetch", "https://localhost/..%2f..%2fa.csv", "--into", "{}"),
         r"which is no plain file name"),
    Case("a checksum that is none", words("fetch", "https://localhost/a.csv", "--checksum", "md5:xyz"),
         r"checksum 'md5:xyz' is not ALGORITHM:HEX", USAGE),
)  # fmt: skip
"""Commands that cannot be followed."""
