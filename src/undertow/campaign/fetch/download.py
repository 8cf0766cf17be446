"""Bytes from an address into a file, going on where an earlier attempt was cut.

Belongs here: the transfer: https only, ranges, retries. Does not belong here: which files, names, checksums (fetch.py).
"""

from __future__ import annotations

import http.client
import json
import os
import time
import urllib.error
import urllib.request
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any
from urllib.parse import urlsplit

from undertow import __version__
from undertow.errors import UndertowError

CHUNK_BYTES = 1 << 20
"""Read and written at once; smaller chunks cost time on a fast line."""

TRIES = 5
"""Attempts at one file before the person is asked to start again."""

TIMEOUT_S = 30.0
"""Silence after which a connection counts as cut."""

PATIENCE_S, SLOWEST_BYTES_PER_S = 30.0, 500.0
"""A line that gives less on average over that time is given up: the modems of 1990 were ten times as fast."""

LARGEST_BYTES, UNSTATED_BYTES = 50_000_000_000, 2_000_000_000
"""Of one file at most, and of one whose size no server states: a record of Zenodo may have 50 GB."""

LOCAL = ("localhost", "127.0.0.1", "::1")
"""Hosts that may be asked without encryption: this machine."""

TEMPORARY = (429, 500, 502, 503, 504)
"""HTTP answers after which the same question may be answered a moment later."""

_SHOWN = 200  # characters of an address in a message

Received = Callable[[int, int], None]
"""Called with the bytes that are there and the bytes in all (0: not known)."""


def check_address(url: str, before: str = "") -> None:
    """Refuse an address that is not https (http on this machine apart), or that ``before`` may not lead to."""
    try:
        parts = urlsplit(url)
        (parts.hostname or "").encode("idna")
        wrong = "" if parts.port != 0 else "its port is 0"
    except ValueError as error:
        wrong = str(error)
    if not wrong and not (url.isascii() and url.isprintable() and " " not in url):
        wrong = "it has blanks or characters that an address writes with %"
    if wrong:
        raise UndertowError(f"address {url[:_SHOWN]!r} cannot be read ({wrong}); correct it")
    local = parts.hostname in LOCAL
    if not parts.hostname or not (parts.scheme == "https" or (parts.scheme == "http" and local)):
        led = f" (where {before} leads)" if before else ""
        raise UndertowError(f"address {url!r}{led} has scheme {parts.scheme!r}; only https is fetched: correct it")
    if before and local and urlsplit(before).hostname not in LOCAL:
        raise UndertowError(f"address {before} leads to this machine ({url}), which no public record does; check it")


class _Redirects(urllib.request.HTTPRedirectHandler):
    """Follows redirects only to addresses that could be asked for directly."""

    def redirect_request(
        self, req: urllib.request.Request, fp: IO[bytes], code: int, msg: str, headers: Any, newurl: str
    ) -> urllib.request.Request | None:
        check_address(newurl, before=req.full_url)
        return super().redirect_request(req, fp, code, msg, headers, newurl)


_OPENER = urllib.request.build_opener(_Redirects)


def open_address(url: str, headers: dict[str, str] | None = None) -> Any:
    """An open answer of a checked address; HTTPError and URLError as urllib raises them."""
    check_address(url)
    request = urllib.request.Request(url, headers={"User-Agent": f"undertow/{__version__}", **(headers or {})})
    return _OPENER.open(request, timeout=TIMEOUT_S)


def said_by(error: Exception) -> str:
    """A network error in a few words."""
    if isinstance(error, urllib.error.HTTPError):
        return f"{error.code} {error.reason}"
    return str(getattr(error, "reason", "") or error or type(error).__name__)


def pieces(answer: Any, url: str, most: int) -> Iterator[bytes]:
    """An answer's bytes as they arrive.

    Raises UndertowError where there are more than ``most``, or they come too slowly to ever end.
    """
    since, lately, total = time.monotonic(), 0, 0
    while chunk := answer.read1(CHUNK_BYTES):
        lately, total = lately + len(chunk), total + len(chunk)
        if total > most:
            raise UndertowError(f"{url} sends more than {most} bytes; fetch it by hand if it is the right file")
        yield chunk
        waited = time.monotonic() - since
        if waited > PATIENCE_S:
            if lately < SLOWEST_BYTES_PER_S * waited:
                raise UndertowError(
                    f"{url} sent {lately} bytes in {waited:.0f} s, less than {SLOWEST_BYTES_PER_S:g} a second; run the "
                    "same command again later: it goes on from there"
                )
            since, lately = time.monotonic(), 0


@dataclass(frozen=True)
class Download:
    """A file's address on its way into ``part``; what was received stays there until it is whole.

    Beside it, ``part`` + ".from" holds where it came from and the server's mark of that version (ETag), so that two
    versions are never joined. Without a mark only a file that is ``checked`` afterwards goes on. ``size`` is what its
    record says, bytes (-1: nothing does).
    """

    url: str
    part: Path
    checked: bool = False
    wait: Callable[[float], None] = time.sleep
    received: Received = lambda done, of: None
    size: int = -1

    @property
    def origin(self) -> Path:
        """The file that says where ``part`` came from."""
        return self.part.with_name(self.part.name + ".from")

    def run(self) -> Path:
        """Receive the rest, trying again where the line is cut; the whole ``part``.

        Raises UndertowError where the server refuses, or after `TRIES` attempts that each were cut.
        """
        for attempt in range(TRIES):
            if attempt:
                self.wait(2.0 ** (attempt - 1))
            try:
                if self._receive():
                    self.origin.unlink(missing_ok=True)
                    return self.part
                reason = "the connection ended early"
            except urllib.error.HTTPError as error:
                error.close()
                if error.code == 416:  # nothing behind what is there: another version
                    self.drop()
                elif error.code not in TEMPORARY:
                    raise UndertowError(f"{self.url} answers {said_by(error)}; check the address") from error
                reason = said_by(error)
            except (OSError, http.client.HTTPException) as error:
                reason = said_by(error)
        size = self.part.stat().st_size if self.part.exists() else 0
        raise UndertowError(
            f"{self.url} was cut {TRIES} times after {size} bytes ({reason}); run the same command again: it goes on "
            "from there"
        )

    def drop(self) -> None:
        """Forget what was received."""
        self.part.unlink(missing_ok=True)
        self.origin.unlink(missing_ok=True)

    def _receive(self) -> bool:
        """One attempt; whether the file is whole now."""
        mark = self._mark()
        may_go_on = bool(mark) or (self.checked and mark is not None)
        have = self.part.stat().st_size if may_go_on and self.part.exists() else 0
        headers = {"Range": f"bytes={have}-"} if have else {}
        if have and mark:
            headers["If-Range"] = mark
        with open_address(self.url, headers) as answer:
            goes_on = answer.status == 206 and _first_byte(answer) == have
            if answer.status == 206 and not goes_on:
                self.drop()
                return False
            have = have if goes_on else 0
            length = answer.headers.get("Content-Length")
            total = have + int(length) if length and length.isdecimal() and len(length) < 20 else 0
            most = LARGEST_BYTES if total else self.size if self.size >= 0 else UNSTATED_BYTES
            if total > most:
                raise UndertowError(
                    f"{self.url} has {total} bytes, more than {most}; fetch it by hand if it is the right file"
                )
            self._note(answer.headers.get("ETag") or answer.headers.get("Last-Modified") or "")
            with self.part.open("ab" if goes_on else "wb") as stream:
                for chunk in pieces(answer, self.url, most - have):
                    stream.write(chunk)
                    have += len(chunk)
                    self.received(have, total)
                stream.flush()
                os.fsync(stream.fileno())
        return have == total or not total

    def _mark(self) -> str | None:
        """The server's mark of the version that ``part`` is the beginning of; None where it came from elsewhere."""
        try:
            noted = json.loads(self.origin.read_text(encoding="utf-8"))
            mark = str(noted["mark"])
            same = noted["url"] == self.url
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
            return None
        return ("" if mark.startswith("W/") else mark) if same else None

    def _note(self, mark: str) -> None:
        self.origin.write_text(json.dumps({"url": self.url, "mark": mark}), encoding="utf-8")


def _first_byte(answer: Any) -> int:
    """Where an answer's range begins; -1 where it does not say."""
    said = str(answer.headers.get("Content-Range", "")).removeprefix("bytes ").partition("-")[0].strip()
    return int(said) if said.isdigit() else -1
