"""Headless Chromium for tests of pages: the DevTools protocol over two pipes, with the standard library alone.

A test that needs it is skipped where no browser is installed (Debian: `apt-get install chromium`); UNDERTOW_CHROMIUM
names another one.
"""

from __future__ import annotations

import base64
import json
import os
import select
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

BROWSER = os.environ.get("UNDERTOW_CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")
"""Path of the browser; None where there is none."""

REASON = "no Chromium on this machine: install Debian's chromium, or name one in UNDERTOW_CHROMIUM"

FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-component-update",
    "--disable-background-networking", "--disable-sync", "--disable-extensions", "--hide-scrollbars", "--mute-audio",
    "--disable-dev-shm-usage", "--remote-debugging-pipe",
)  # fmt: skip

PATIENCE_S = 120.0
"""How long an answer may take: a loaded machine is no failed test."""


class BrowserError(Exception):
    """The browser said no, or said nothing."""


class Page:
    """One tab: commands, scripts, and everything it reported on the way (``events``)."""

    def __init__(self, out: int, back: int) -> None:
        self._out, self._back, self._rest, self._number = out, back, b"", 0
        self._session: str | None = None
        self.events: list[dict[str, Any]] = []
        target = self.send("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.send("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.send(f"{domain}.enable")
        self.send("Performance.enable", timeDomain="threadTicks")

    def send(self, method: str, **parameters: Any) -> dict[str, Any]:
        """One command and its answer."""
        self._number += 1
        message: dict[str, Any] = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._out, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._next()
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise BrowserError(f"{method}: {answer['error']}")
                return dict(answer["result"])

    def _next(self) -> dict[str, Any]:
        """The next message; one that answers no command is kept as an event."""
        end = time.monotonic() + PATIENCE_S
        while b"\0" not in self._rest:
            if not select.select([self._back], [], [], max(end - time.monotonic(), 0.0))[0]:
                raise BrowserError(f"no answer within {PATIENCE_S:g} s")
            more = os.read(self._back, 1 << 20)
            if not more:
                raise BrowserError("the browser has ended")
            self._rest += more
        one, self._rest = self._rest.split(b"\0", 1)
        message = dict(json.loads(one))
        if "id" not in message:
            self.events.append(message)
        return message

    def wait_for(self, event: str) -> None:
        """Until an event of that name has come since the last `open`."""
        while not any(one.get("method") == event for one in self.events):
            self._next()

    def open(self, path: Path) -> None:
        """Load a file and wait until it is complete."""
        self.events.clear()
        self.send("Page.navigate", url=path.resolve().as_uri())
        self.wait_for("Page.loadEventFired")

    def load_s(self) -> dict[str, float]:
        """Seconds from the request of the page to its first picture, to a document that is read, and to the end of its
        load event, by Navigation Timing and Paint Timing; ``busy``: processor time of the page's own thread, which
        does not depend on what else the machine does."""
        self.until("performance.getEntriesByType('navigation')[0].loadEventEnd > 0")
        self.until("performance.getEntriesByName('first-contentful-paint').length")
        found = self.run(
            "(({domInteractive, loadEventEnd}) => ({"
            "painted: performance.getEntriesByName('first-contentful-paint')[0].startTime, "
            "read: domInteractive, loaded: loadEventEnd}))(performance.getEntriesByType('navigation')[0])"
        )
        busy = next(m["value"] for m in self.send("Performance.getMetrics")["metrics"] if m["name"] == "TaskDuration")
        return {"busy": float(busy), **{name: float(value) / 1e3 for name, value in found.items()}}

    def run(self, script: str) -> Any:
        """The value of an expression in the page; a promise is waited for."""
        found = self.send("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in found:
            raise BrowserError(f"{script[:200]}: {found['exceptionDetails']}")
        return found["result"].get("value")

    def until(self, script: str) -> None:
        """Until an expression of the page is true."""
        end = time.monotonic() + PATIENCE_S
        while not self.run(f"Boolean({script})"):
            if time.monotonic() > end:
                raise BrowserError(f"not within {PATIENCE_S:g} s: {script}")
            time.sleep(0.05)

    def shape(self, width: int, height: int, dark: bool = False, media: str = "screen") -> None:
        """Size of the window in pixels, the reader's theme, screen or print."""
        self.send("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=False)
        theme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.send("Emulation.setEmulatedMedia", media=media, features=[theme])

    def picture(self, path: Path, **clip: float) -> Path:
        """What the window shows (or a clip of the page: x, y, width, height) as PNG."""
        whole = {"clip": {**clip, "scale": 1}, "captureBeyondViewport": True} if clip else {}
        path.write_bytes(base64.b64decode(self.send("Page.captureScreenshot", format="png", **whole)["data"]))
        return path

    def pdf(self) -> bytes:
        """The page printed, as its own style says."""
        self.send("Emulation.setEmulatedMedia", media="", features=[])
        said = self.send("Page.printToPDF", preferCSSPageSize=True, printBackground=True)
        return base64.b64decode(said["data"])

    def troubles(self) -> list[str]:
        """Errors that the page logged, and addresses that it asked for beside itself, since the last `open`."""
        out = []
        for one in self.events:
            said = one.get("params", {})
            asked = said["request"]["url"] if one.get("method") == "Network.requestWillBeSent" else "file:"
            if not asked.startswith(("file:", "data:", "blob:")):
                out.append(asked)
            if one.get("method") == "Runtime.exceptionThrown":
                out.append(str(said["exceptionDetails"]))
            if one.get("method") == "Log.entryAdded" and said["entry"]["level"] == "error":
                out.append(said["entry"]["text"])
            if one.get("method") == "Runtime.consoleAPICalled" and said["type"] == "error":
                out.append(str(said["args"]))
        return out


def pages_of(pdf: bytes) -> int:
    """How many pages a PDF of Chromium's has."""
    return pdf.count(b"/Type /Page\n") + pdf.count(b"/Type /Page ") + pdf.count(b"/Type /Page/")


@contextmanager
def browser() -> Iterator[Page]:
    """A browser of its own with an empty profile; ended, with its profile, when the block is left."""
    if BROWSER is None:
        raise BrowserError(REASON)
    to_read, out = os.pipe()
    back, to_write = os.pipe()
    with tempfile.TemporaryDirectory(prefix="undertow-browser-", ignore_cleanup_errors=True) as profile:
        pipes = f"3<&{to_read} 4>&{to_write}"
        command = " ".join(["exec", '"$0"', *FLAGS, '"--user-data-dir=$1"', "about:blank", pipes])
        process = subprocess.Popen(
            ["bash", "-c", command, BROWSER, profile], pass_fds=(to_read, to_write), stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        os.close(to_read)
        os.close(to_write)
        try:
            page = Page(out, back)
            yield page
        finally:
            os.close(out)
            os.close(back)
            process.terminate()
            try:
                process.wait(timeout=20)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()
