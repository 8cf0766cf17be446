"""A server on this machine for tests of fetching: it knows ranges, cuts lines, redirects, and has a record's API."""

from __future__ import annotations

import hashlib
import json
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import numpy as np

CONTENT = np.random.default_rng(7).bytes(300_000)
MD5 = hashlib.md5(CONTENT).hexdigest()
SHA256 = hashlib.sha256(CONTENT).hexdigest()


class Server(ThreadingHTTPServer):
    """What it has, what it was asked, and how it misbehaves."""

    daemon_threads = True

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), Handler)
        self.files: dict[str, bytes] = {"/data/run.csv": CONTENT}
        self.etag: str | None = '"one"'
        self.cut_after: list[int] = []
        self.answers: list[int] = []
        self.redirects: dict[str, str] = {}
        self.ranges: list[str | None] = []
        self.says_length = True
        self.endless: tuple[bytes, float] | None = None

    @property
    def base(self) -> str:
        return f"http://127.0.0.1:{self.server_address[1]}"

    def record(self, **changes: object) -> None:
        """Describe a Zenodo record 12 with one file, as its API does."""
        file = {
            "key": "run.csv",
            "size": len(CONTENT),
            "checksum": f"md5:{MD5}",
            "links": {"self": f"{self.base}/data/run.csv"},
            **changes,
        }
        self.files["/records/12"] = json.dumps({"id": 12, "files": [file]}).encode()


class Handler(BaseHTTPRequestHandler):
    """Answers as its server says."""

    server: Server
    protocol_version = "HTTP/1.1"

    def log_message(self, *words: object) -> None:
        pass

    def do_GET(self) -> None:
        path = self.path.partition("?")[0]
        asked = self.headers.get("Range")
        self.server.ranges.append(asked)
        if self.server.answers:
            return self._plain(self.server.answers.pop(0))
        if path in self.server.redirects:
            return self._plain(302, self.server.redirects[path])
        if path not in self.server.files:
            return self._plain(404)
        body, start = self.server.files[path], 0
        if asked and self.headers.get("If-Range", self.server.etag) == self.server.etag:
            start = int(asked.removeprefix("bytes=").rstrip("-"))
            if start >= len(body):
                return self._plain(416)
        self.send_response(206 if start else 200)
        if self.server.etag:
            self.send_header("ETag", self.server.etag)
        if start:
            self.send_header("Content-Range", f"bytes {start}-{len(body) - 1}/{len(body)}")
        if self.server.says_length:
            self.send_header("Content-Length", str(len(body) - start))
        self.send_header("Connection", "close")
        self.end_headers()
        if self.server.endless is not None:
            return self._without_end(*self.server.endless)
        end = start + self.server.cut_after.pop(0) if self.server.cut_after else len(body)
        self.wfile.write(body[start:end])
        self.close_connection = True
        return None

    def _without_end(self, piece: bytes, pause_s: float) -> None:
        """The same bytes again and again until nobody listens."""
        self.close_connection = True
        try:
            for _ in range(10_000):
                self.wfile.write(piece)
                self.wfile.flush()
                time.sleep(pause_s)
        except OSError:
            return

    def _plain(self, status: int, location: str = "") -> None:
        self.send_response(status)
        if location:
            self.send_header("Location", location)
        self.send_header("Content-Length", "0")
        self.end_headers()


@contextmanager
def serving() -> Iterator[Server]:
    """A running server, ended with the block."""
    with Server() as running:
        thread = threading.Thread(target=running.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        yield running
        running.shutdown()
        thread.join()
