"""Which revision a number was made with, as it stands beside it in a table."""

from __future__ import annotations

import subprocess
from pathlib import Path


def revision() -> str:
    """The git revision of this folder, with a + where source files differ from it."""
    where = ["git", "-C", str(Path(__file__).resolve().parents[1])]
    name = subprocess.run([*where, "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=True).stdout
    clean = subprocess.run([*where, "diff", "--quiet", "HEAD", "--", "src"], check=False).returncode == 0
    return name.strip() + ("" if clean else "+")
