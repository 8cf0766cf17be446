"""Words of a command line that are empty, as a shell makes them of a variable that is not set.

Belongs here: which of them mean nothing, and the sentence. Does not belong here: commands (cli.py).
"""

from __future__ import annotations

from collections.abc import Sequence

MAY_BE_EMPTY = ("--group", "--scheduler", "--checksum", "--set")
"""Options whose text may be empty, as it is where they are left out; a path may not."""


def empty_word(words: Sequence[str]) -> str:
    """What is said of the first word that is empty and stands for a path, which would be this folder; empty where none
    is.

    >>> empty_word(["run", "c.yaml", "--out", ""])
    '--out is empty, as an unset shell variable is; give a path, or leave it out'
    >>> empty_word(["run", "c.yaml", "--out", "runs/a"])
    ''
    """
    for before, word in zip(("", *words), words, strict=False):
        named, equals, value = word.partition("=")
        if (word == "" and before not in MAY_BE_EMPTY) or (
            equals and not value and named.startswith("--") and named not in MAY_BE_EMPTY
        ):
            said = named if equals else before if before.startswith("--") else f"the word after {before!r}"
            return f"{said} is empty, as an unset shell variable is; give a path, or leave it out"
    return ""
