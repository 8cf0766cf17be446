"""One run at a time in one folder, whatever ended the one before."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from undertow.campaign.run.claim import LOCK, claimed
from undertow.errors import UndertowError

HOLD = """
import sys, time
from pathlib import Path
from undertow.campaign.run.claim import claimed
with claimed(Path(sys.argv[1])):
    print("held", flush=True)
    time.sleep(60.0)
"""


def test_a_second_run_in_a_folder_is_refused_and_a_later_one_is_not(tmp_path: Path) -> None:
    with (
        claimed(tmp_path),
        pytest.raises(UndertowError, match=rf"is in use by another run \(process {os.getpid()} on .*\); wait for it"),
        claimed(tmp_path),
    ):
        pass
    with claimed(tmp_path):
        pass
    assert list(tmp_path.iterdir()) == []


def test_an_error_in_a_run_gives_the_folder_back(tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError, match="by zero"), claimed(tmp_path):
        _ = 1 / 0
    with claimed(tmp_path):
        pass


@pytest.mark.skipif(os.name != "posix", reason="kills a process")
def test_a_process_that_was_killed_holds_nothing_and_what_it_left_half_written_goes(tmp_path: Path) -> None:
    with subprocess.Popen([sys.executable, "-c", HOLD, str(tmp_path)], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"held\n"
        with pytest.raises(UndertowError, match=f"in use by another run .process {process.pid} on "), claimed(tmp_path):
            pass
        process.send_signal(signal.SIGKILL)
    (tmp_path / "stages").mkdir()
    (tmp_path / "stages" / ".abc.json.x1.part").write_text("{")
    (tmp_path / "stages" / "abc.json").write_text("{}")
    (tmp_path / ".new.x1" / "figures").mkdir(parents=True)
    assert (tmp_path / LOCK).exists()
    with claimed(tmp_path):
        assert {path.name for path in tmp_path.rglob("*")} == {LOCK, "stages", "abc.json"}
