"""Writing a file so that it appears whole or not at all, and a page's text from its template.

Belongs here: the atomic write, templates (templates/), the sign of a number where it is read. Does not belong here:
what is written.
"""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from markupsafe import Markup

PAGES = ("report.html", "audit.html", "differ.html")
"""Pages of the commands that write one, as they are called in a run folder."""


_MINUS = re.compile(r"(?:(?<=[\s(\[,:;=±→>|])|^)-(?=\.?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?![\w-]|\.\w))", re.MULTILINE)
"""A hyphen that is the sign of a number: not one inside a name or a power, nor at the beginning of a file's name."""


def true_minus(text: str) -> str:
    """A text for a reader: the sign of a negative number is a minus, hyphens in names stay. Files that programs read,
    and equations that are copied, keep what they have.

    >>> true_minus("-314 ± 76 in run-2, from -0.5 to 2e-5 (-1.2 %)")
    '\u2212314 ± 76 in run-2, from \u22120.5 to 2e-5 (\u22121.2 %)'
    >>> true_minus("trial -5deg of runs/-1.csv, 2024-01-02, m^-2")
    'trial -5deg of runs/-1.csv, 2024-01-02, m^-2'
    """
    return _MINUS.sub("\N{MINUS SIGN}", text) if "-" in text else text


def as_read(value: Any) -> Any:
    """A value as a page shows it: per cent stand on their number's line, negative numbers have a minus. What is
    `Markup` already stays."""
    plain = isinstance(value, str) and not isinstance(value, Markup)
    return true_minus(value.replace(" %", "\N{NO-BREAK SPACE}%")) if plain else value


def rendered(template: str, **values: Any) -> str:
    """A page's text: every value is escaped and stands there `as_read`, and one that the template asks for and nobody
    gave is an error."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("undertow.report"), autoescape=True, undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True, finalize=as_read,
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
