"""How long another process has computed, whatever else a busy machine does.

Belongs here: that number. Does not belong here: what a process may take (fuzz/, blind_challenge/).
"""

from __future__ import annotations

import os
from pathlib import Path


def spent(process: int) -> float:
    """Processor time of a running process and of its children that have ended, s; nan where the system does not say.

    >>> spent(os.getpid()) > 0.0
    True
    """
    try:
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
    except OSError:
        return float("nan")
    return sum(int(ticks) for ticks in fields[11:15]) / os.sysconf("SC_CLK_TCK")
