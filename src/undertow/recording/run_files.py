"""Tables that a run has written: they are no recordings, wherever its folder is.

Belongs here: how they are known. Does not belong here: what they hold (report/tables.py), the folder (campaign/run).
"""

from __future__ import annotations

import os

TABLES = ("trials.csv", "levels.csv", "mismatch.csv")
"""Names of a run's tables."""

MARK = "manifest.json"
"""What stands beside them in every run folder."""


def is_of_a_run(path: str) -> bool:
    """Whether a file is one of a run's own tables: by its name, and the manifest beside it.

    >>> is_of_a_run("flume/r01.csv"), is_of_a_run("no_such_folder/levels.csv")
    (False, False)
    """
    folder, name = os.path.split(path)
    return name in TABLES and os.path.isfile(os.path.join(folder, MARK))
