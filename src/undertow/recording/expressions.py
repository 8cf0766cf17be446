"""`recordings.pattern` held against file names, in a process of its own with a time limit.

Configs come from elsewhere, and a regular expression of seven characters can search a name for years. No look at an
expression says for sure how long it takes; a process can be ended.

Belongs here: that process, its sentences. Does not belong here: what the named groups are for (gather.py).
"""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from undertow.errors import ConfigError

SECONDS = 5
"""Of processor time, for all names of a campaign: ten thousand take some 50 ms, a Python that starts 20 ms."""

LONGEST_WAIT_S = 60.0
"""On a machine with much other work, and where the system limits no process's time."""

LONGEST = 1000
"""Characters of a pattern: a file system takes names of 255."""

_NO_PROCESS, _INSTEAD = "cannot be tried in a process of its own", "give the conditions in recordings.index"
_SHOWN = 100  # characters of a pattern in a message
_CHILD = """
import json, re, sys
seconds, pattern, names = json.load(sys.stdin)
try:
    import resource
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
except (ImportError, OSError, ValueError):
    pass
try:
    expression = re.compile(pattern)
except (re.error, RecursionError, OverflowError) as error:
    answer = {"error": str(error)}
else:
    found = [expression.search(name) for name in names]
    groups = [None if one is None else one.groupdict() for one in found]
    answer = {"groups": list(expression.groupindex), "found": groups}
json.dump(answer, sys.stdout)
"""


@dataclass(frozen=True)
class FoundNames:
    """The names of an expression's groups, and for each file name what they hold; None where it does not fit."""

    groups: tuple[str, ...]
    by_name: tuple[Mapping[str, str | None] | None, ...]


@lru_cache(maxsize=8)
def found_in(pattern: str, names: tuple[str, ...] = ()) -> FoundNames:
    """What an expression finds in file names; without names it is only looked at.

    Raises ConfigError where it is none, is longer than `LONGEST` or takes longer than `SECONDS`.

    >>> found_in(r"_(?P<depth>[0-9]+)m", ("disc_2m.csv", "notes.txt")).by_name
    ({'depth': '2'}, None)
    """
    shown = repr(pattern if len(pattern) <= _SHOWN else f"{pattern[:_SHOWN]}...")
    if len(pattern) > LONGEST:
        raise ConfigError(f"recordings.pattern {shown} has {len(pattern)} characters, and {LONGEST} are allowed")
    answer = _asked(shown, pattern, names)
    if "error" in answer:
        raise ConfigError(f"recordings.pattern {shown} is no regular expression: {answer['error']}")
    return FoundNames(tuple(answer["groups"]), tuple(answer["found"]))


def _asked(shown: str, pattern: str, names: Sequence[str]) -> Mapping[str, Any]:
    """The child's answer."""
    try:
        done = subprocess.run(
            [sys.executable, "-I", "-S", "-c", _CHILD],
            input=json.dumps([SECONDS, pattern, list(names)]), capture_output=True, text=True, timeout=LONGEST_WAIT_S,
        )  # fmt: skip
        late = done.returncode == -getattr(signal, "SIGXCPU", 0) != 0
    except subprocess.TimeoutExpired:
        late = True
    except OSError as error:
        raise ConfigError(f"recordings.pattern {shown} {_NO_PROCESS} ({error}); {_INSTEAD}") from error
    if late:
        raise ConfigError(
            f"recordings.pattern {shown} takes more than {SECONDS:g} s for {len(names)} file names; a repeat within a "
            "repeat, like (a+)+, or several .* can be tried in endless ways: write what stands between the groups"
        )
    if done.returncode != 0:
        raise ConfigError(f"recordings.pattern {shown} {_NO_PROCESS} (exit code {done.returncode}); {_INSTEAD}")
    answer: Mapping[str, Any] = json.loads(done.stdout)
    return answer
