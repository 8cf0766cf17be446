"""Every bad input through its command, each in a process of its own.

    python -m experiments bad_inputs [WORD ...]

writes docs/bad_inputs.md (with WORDs: prints the cases whose names hold one): exit code, processor time, peak memory
and the sentence. A traceback, another exit code or sentence, more than `LONGEST_S` or `LARGEST_MB` are marked, and the
command ends with 1.

Belongs here: processes, the page. Does not belong here: the cases.
"""

from __future__ import annotations

import os
import re
import resource
import signal
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from experiments.bad_inputs import configs, recordings, words
from experiments.bad_inputs.case import Case

PAGE = Path(__file__).resolve().parents[2] / "docs" / "bad_inputs.md"
LONGEST_S, LARGEST_MB = 10.0, 2000.0
"""Processor time and peak memory of a command at most."""

WAITED_S = 300
"""Until a command counts as one that hangs, on a machine that others use."""

PARTS = {"Recordings": recordings.CASES, "Configs and indexes": configs.CASES, "Commands": words.CASES}
CASES = tuple(case for cases in PARTS.values() for case in cases)


@dataclass(frozen=True)
class Answer:
    """What a command ended with: exit code (negative: a signal), stderr, seconds of processor time, peak memory, MB."""

    code: int
    said: str
    seconds: float
    megabytes: float

    def wrong(self, case: Case) -> str:
        """What is not as the case says; empty where all is."""
        if "Traceback" in self.said:
            return "a traceback"
        if self.code != case.code:
            return f"exit code {self.code}, not {case.code}"
        if not re.search(case.says, self.said):
            return "another sentence"
        return "too long" if self.seconds > LONGEST_S else "too large" if self.megabytes > LARGEST_MB else ""


def answer(case: Case, folder: Path) -> Answer:
    """The command in a child of this process that has imported what commands need."""
    said = case.words(folder)
    heard = folder.parent / f"{folder.name}.stderr"
    child = os.fork()
    if child == 0:
        _be_the_command(said, heard)
    status, used = _ended(child)
    seconds = used.ru_utime + used.ru_stime
    code = -os.WTERMSIG(status) if os.WIFSIGNALED(status) else os.WEXITSTATUS(status)
    return Answer(code, heard.read_text(errors="replace"), seconds, used.ru_maxrss / 1000.0)


def _ended(child: int) -> tuple[int, resource.struct_rusage]:
    """Wait for a child, at most `WAITED_S`."""
    signal.signal(signal.SIGALRM, lambda number, frame: os.kill(child, signal.SIGKILL))
    signal.alarm(WAITED_S)
    try:
        _, status, used = os.wait4(child, 0)
    finally:
        signal.alarm(0)
    return status, used


def _be_the_command(said: list[str], heard: Path) -> None:
    """In the child: run the command, and leave without coming back."""
    from undertow.cli import main

    code = 99
    try:
        with heard.open("wb") as stream, open(os.devnull, "wb") as nothing:
            os.dup2(stream.fileno(), 2)
            os.dup2(nothing.fileno(), 1)
            main(said)
    except SystemExit as end:
        code = int(end.code or 0)
        sys.stderr.flush()
    except BaseException:  # noqa: BLE001 - what a user would see as a traceback
        import traceback

        traceback.print_exc()
        sys.stderr.flush()
    finally:
        os._exit(code)


def row(case: Case, got: Answer) -> str:
    """A line of the page's table."""
    lines = [line for line in got.said.splitlines() if not re.match(r"(read and condition|identification): ", line)]
    said = re.sub(r"/[^\s']*/c\d+(_outside)?/", "", lines[-1] if lines else "").replace("|", "\\|")
    shown = said if len(said) <= 220 else f"{said[:217]}..."
    wrong = got.wrong(case)
    mark = f" **{wrong}**" if wrong else ""
    return f"| {case.name} | {got.code}{mark} | {got.seconds:.1f} | {got.megabytes:.0f} | {shown} |"


def main() -> None:
    """Run the cases and write or print their answers."""
    import undertow.campaign.inspection
    import undertow.campaign.run.cluster
    import undertow.campaign.run.folder  # noqa: F401 - imported once for all children

    asked = sys.argv[1:]
    text, failed, count = "", 0, 0
    with tempfile.TemporaryDirectory() as scratch:
        for title, cases in PARTS.items():
            text += f"\n## {title}\n\n| input | exit code | s | MB | what is said |\n|---|---|---|---|---|\n"
            for case in cases:
                if asked and not any(word in case.name for word in asked):
                    continue
                got = answer(case, Path(scratch) / f"c{count}")
                count += 1
                failed += bool(got.wrong(case))
                text += row(case, got) + "\n"
                if asked or got.wrong(case):
                    print(row(case, got), got.said if got.wrong(case) else "", sep="\n", flush=True)
    if not asked:
        PAGE.write_text(head(count, failed) + text)
    print(f"{count} cases, {failed} wrong")
    raise SystemExit(1 if failed else 0)


def head(count: int, failed: int) -> str:
    """The page's beginning."""
    return f"""\
# Bad inputs, and what is said of them

After this page you know how undertow answers what it cannot use: one sentence with the quantity, the value, the rule
and the next step, an exit code (1: failed, 2: the words or the config are wrong), never a traceback, within seconds.

    python -m experiments bad_inputs

runs {count} bad inputs through the commands, each in a process of its own, with its processor time and its peak memory
(some 500 MB are the packages that every command has loaded here); {count - failed} are answered as their case says,
{failed} are not. The tests run all but the largest of them (`tests/contract/test_bad_inputs_table.py`); random texts
and changed bytes: `tests/unit/test_untrusted_input.py` and `experiments/fuzz`.
"""
