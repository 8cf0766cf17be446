"""For the site: docstrings as the project writes them, as Markdown that reads well.

Examples stand under no heading of their own and become code; a parameter's line is ``name : what it is``, without a
type, which the signature has, and becomes an item. Loaded by mkdocs.yml as an extension of griffe, which reads them.
"""

from __future__ import annotations

import re
from typing import Any

import griffe

HEADING = "Parameters"


def as_markdown(text: str) -> str:
    """A docstring with fences around its examples, and its parameters as a list."""
    out: list[str] = []
    example = listed = False
    for line in text.splitlines():
        if not example and line.startswith(">>> "):
            out.append("```pycon")
            example = True
        if not line.strip():
            if example:
                out.append("```")
            example = listed = False
        if listed and out[-1] == HEADING:
            out[-1:] = [f"**{HEADING}**", ""]
            continue
        listed = listed or line == HEADING
        out.append(re.sub(r"^(\*{0,2}\w[\w, ]*) : ", r"- **\1**: ", line) if listed else line)
    return "\n".join([*out, "```"] if example else out)


class AsMarkdown(griffe.Extension):
    """Rewrites every object's docstring."""

    def on_object(self, *, obj: Any, **kwargs: Any) -> None:
        """Called by griffe for every module, class, function and attribute it has read."""
        if obj.docstring is not None:
            obj.docstring.value = as_markdown(obj.docstring.value)
