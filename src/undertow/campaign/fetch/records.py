"""Public records: a DOI or an address becomes checked files in a folder.

The frame (a file appears whole and checked, or not at all) is pooch's; the transfer is download.py's, because pooch
starts again from the first byte. Belongs here: which files, their names, their checksums.
"""

from __future__ import annotations

import http.client
import json
import logging
import os
import re
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

import pooch

from undertow.campaign.fetch.download import Download, check_address, open_address, pieces, said_by
from undertow.errors import ConfigError, UndertowError

Progress = Callable[[str, int, int], None]

ZENODO_API = "https://zenodo.org/api"
"""Where Zenodo answers for its records (https://developers.zenodo.org)."""

LARGEST_ANSWER = 16 << 20
"""Bytes of a record's description at most: the longest on Zenodo are some hundred kB."""

ALGORITHMS = ("md5", "sha1", "sha256", "sha512")
"""Checksums that are understood, as ALGORITHM:HEX."""

_ZENODO_DOI = re.compile(r"^(?:doi:|https?://(?:dx\.)?doi\.org/)?10\.5281/zenodo\.(\d+)$", re.IGNORECASE)
_ZENODO_PAGE = re.compile(r"^https?://(?:www\.)?zenodo\.org/(?:api/)?records?/(\d+)/?(?:[?#].*)?$", re.IGNORECASE)
_ANY_DOI = re.compile(r"^(?:doi:|https?://(?:dx\.)?doi\.org/)?(10\.\d{4,9}/\S+)$", re.IGNORECASE)
_CHECKSUM = re.compile(rf"^({'|'.join(ALGORITHMS)}):([0-9a-f]{{32,128}})$", re.IGNORECASE)


@dataclass(frozen=True)
class RecordFile:
    """One file to be fetched: name, address, checksum as ALGORITHM:HEX and size in bytes ("" and -1: not known)."""

    name: str
    url: str
    checksum: str = ""
    size: int = -1


@dataclass(frozen=True)
class Fetched:
    """A file that is there: its path, size in bytes, sha256, and how it is known to be right."""

    path: Path
    size: int
    sha256: str
    checked: str

    def __str__(self) -> str:
        return f"{self.path}  {self.size} bytes  sha256:{self.sha256}  {self.checked}"


def fetch(
    source: str,
    into: Path = Path(),
    *,
    checksum: str = "",
    progress: Progress = lambda stage, done, of: None,
    zenodo_api: str | None = None,
    wait: Callable[[float], None] = time.sleep,
) -> Iterator[Fetched]:
    """Fetch every file of a Zenodo record (DOI or page), or the file of an address, one by one.

    Beside each file stands its checksum (``<name>.sha256``, as sha256sum reads it). A file that is there already and
    agrees is not fetched again; one that differs is never replaced. ``wait`` (s) is called between attempts.

    Raises ConfigError where the source or checksum cannot be understood; UndertowError where the server refuses or is
    cut for good, a checksum is wrong, a name leaves the folder, or a file in the folder differs.
    """
    files = resolve(source, checksum, zenodo_api)
    into.mkdir(parents=True, exist_ok=True)
    names = {file.name for file in files}
    for file in files:
        fetched = _fetch_one(file, into, progress, wait)
        if _beside(fetched.path).name not in names:
            _store(fetched.path, fetched.sha256)
        yield fetched


def resolve(source: str, checksum: str = "", zenodo_api: str | None = None) -> tuple[RecordFile, ...]:
    """The files that a DOI or an address stands for; raises as `fetch` does."""
    if checksum and not _CHECKSUM.match(checksum):
        raise ConfigError(f"checksum {checksum!r} is not ALGORITHM:HEX with one of {', '.join(ALGORITHMS)}; correct it")
    record = _ZENODO_DOI.match(source) or _ZENODO_PAGE.match(source)
    if record is not None:
        if checksum:
            raise ConfigError(f"checksum {checksum!r} was given for record {source}, which has its own; leave it out")
        return _zenodo_files(record[1], (zenodo_api or ZENODO_API).rstrip("/"))
    if _ANY_DOI.match(source):
        raise ConfigError(f"DOI {source!r} is none of Zenodo's (10.5281/zenodo.N); give the address of its file")
    if "://" not in source:
        raise ConfigError(f"source {source!r} is neither a DOI nor an address; give 10.5281/zenodo.N or https://...")
    check_address(source)
    return (RecordFile(safe_file_name(unquote(urlsplit(source).path.rpartition("/")[2]), source), source, checksum),)


def safe_file_name(name: str, where: str) -> str:
    """The name itself; UndertowError where it would leave its folder or cannot be a file's name.

    >>> safe_file_name("run 1.csv", "record 1")
    'run 1.csv'
    """
    strange = any(ord(c) < 32 or c in '/\\:*?"<>|' for c in name)
    if strange or name.strip(". ") == "" or name != name.strip() or len(name.encode()) > 200:
        raise UndertowError(
            f"{where} names a file {name!r}, which is no plain file name inside the folder; it is refused: fetch it by "
            "hand"
        )
    return name


def _zenodo_files(record: str, api: str) -> tuple[RecordFile, ...]:
    """Files of a Zenodo record, from its JSON description."""
    url = f"{api}/records/{record}"
    content = _json(url, record)
    try:
        files = tuple(
            RecordFile(
                safe_file_name(str(file["key"]), f"record {record}"), str(file["links"]["self"]),
                _known_checksum(str(file["checksum"]), record), int(file["size"]),
            )
            for file in content["files"]
        )  # fmt: skip
    except (KeyError, TypeError, ValueError, OverflowError) as error:
        if isinstance(error, UndertowError):
            raise
        raise UndertowError(
            f"record {record}: {url} describes its files in a way that is not known ({repr(error)[:100]}); fetch them "
            "by hand"
        ) from error
    names = [file.name.lower() for file in files]
    if not files or len(set(names)) < len(names):
        what = "no open files" if not files else f"two files of one name among {', '.join(names)}"
        raise UndertowError(f"record {record} has {what}; look at https://zenodo.org/records/{record}")
    for file in files:
        check_address(file.url, before=url)
    return files


def _known_checksum(text: str, record: str) -> str:
    """A record's checksum; every Zenodo file has one, so that none is a reason to stop."""
    plain = text if ":" in text else f"md5:{text}"
    if not _CHECKSUM.match(plain):
        known = ", ".join(ALGORITHMS)
        raise UndertowError(f"record {record} gives the checksum {text!r}, none of {known}; fetch its files by hand")
    return plain.lower()


def _json(url: str, record: str) -> Mapping[str, Any]:
    try:
        with open_address(url, {"Accept": "application/json"}) as answer:
            text = b"".join(pieces(answer, url, LARGEST_ANSWER))
        content = json.loads(text)
    except (OSError, http.client.HTTPException) as error:
        raise UndertowError(f"record {record}: {url} answers {said_by(error)}; check number and line") from error
    except (ValueError, RecursionError) as error:
        if isinstance(error, UndertowError):
            raise
        raise UndertowError(f"record {record}: {url} gives no JSON ({error}); try again later") from error
    return content if isinstance(content, dict) else {}


def _fetch_one(file: RecordFile, into: Path, progress: Progress, wait: Callable[[float], None]) -> Fetched:
    """One file, checked; left alone where it is there already."""
    target = into / file.name
    if target.exists():
        return _kept(file, target)
    pooch.get_logger().setLevel(logging.WARNING)
    steps = _InSteps(file.name, progress)

    def downloader(url: str, output_file: Any, _: Any) -> None:
        part = into / f".{file.name}.part"
        os.replace(Download(url, part, bool(file.checksum), wait, steps, file.size).run(), output_file)

    try:
        pooch.retrieve(file.url, file.checksum or None, fname=file.name, path=into, downloader=downloader)
    except UndertowError:
        raise
    except ValueError as error:
        said = str(error).partition(". Deleted")[0]
        raise UndertowError(f"{file.name}: {said}; it was dropped: try again, or ask who published it") from error
    size = target.stat().st_size
    if file.size >= 0 and size != file.size:
        target.unlink()
        raise UndertowError(f"{file.name} has {size} bytes, its record says {file.size}; it was dropped: try again")
    digest = pooch.file_hash(str(target))
    said = f"({file.checksum.partition(':')[0]} agrees)" if file.checksum else "(no published checksum)"
    return Fetched(target, size, digest, said)


def _kept(file: RecordFile, target: Path) -> Fetched:
    """A file that is there already, if it is the one; UndertowError where it is not, or nothing says that it is."""
    digest = pooch.file_hash(str(target))
    beside = _beside(target)
    noted = beside.read_text(encoding="utf-8").split(" ")[0] if beside.is_file() else ""
    if file.checksum:
        algorithm, _, wanted = file.checksum.lower().partition(":")
        right = pooch.file_hash(str(target), algorithm) == wanted
    else:
        right = noted == digest
    if not right:
        rule = file.checksum or (f"sha256:{noted}" if noted else "unknown: nothing beside it says what it was")
        raise UndertowError(
            f"{target} is there already with sha256:{digest}, but its checksum should be {rule}; move it away"
        )
    return Fetched(target, target.stat().st_size, digest, "(there already)")


@dataclass
class _InSteps:
    """Progress in whole MB, each once."""

    name: str
    progress: Progress
    last: int = -1

    def __call__(self, done: int, of: int) -> None:
        at, whole = done >> 20, max(of >> 20, 1)
        if at != self.last or done == of:
            self.last = at
            self.progress(f"{self.name} (MB)", whole if done == of else min(at, whole), whole)


def _beside(target: Path) -> Path:
    return target.with_name(target.name + ".sha256")


def _store(target: Path, digest: str) -> None:
    beside = _beside(target)
    partial = beside.with_name(f".{beside.name}.{os.getpid()}.part")
    partial.write_text(f"{digest}  {target.name}\n", encoding="utf-8")
    os.replace(partial, beside)
