"""Writing a file so that it appears whole or not at all, and a page's text from its template.

Belongs here: the atomic write, templates (templates/). Does not belong here: what is written.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from markupsafe import Markup

PAGES = ("report.html", "audit.html", "differ.html")
"""Pages of the commands that write one, as they are called in a run folder."""


def rendered(template: str, **values: Any) -> str:
    """A page's text: every value is escaped, and one that the template asks for and nobody gave is an error. Per cent
    stand on their number's line."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    def together(value: Any) -> Any:
        plain = isinstance(value, str) and not isinstance(value, Markup)
        return value.replace(" %", "\N{NO-BREAK SPACE}%") if plain else value

    environment = Environment(
        loader=PackageLoader("undertow.report"), autoescape=True, undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True, finalize=together,
    )  # fmt: skip
    return environment.get_template(template).render(**values)


def write_text(path: Path, text: str) -> Path:
    """Write UTF-8 text through a temporary file in the same folder; an older file stays until the new one is whole."""
    return write_bytes(path, text.encode("utf-8"))


def write_bytes(path: Path, content: bytes) -> Path:
    """Write bytes through a temporary file in the same folder, with the rights of an ordinary new file."""
    return _write(path, (content,))


def write_pieces(path: Path, pieces: Iterable[str]) -> Path:
    """As `write_text`, piece by piece: a file larger than memory; if making a piece fails, the older file stays."""
    return _write(path, (piece.encode("utf-8") for piece in pieces))


def _write(path: Path, contents: Iterable[bytes]) -> Path:
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.", suffix=".part")
    try:
        with os.fdopen(handle, "wb") as stream:
            for content in contents:
                stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        mask = os.umask(0o022)  # it is read by setting it for a moment
        os.umask(mask)
        os.chmod(name, 0o666 & ~mask)
        os.replace(name, path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
    return path
