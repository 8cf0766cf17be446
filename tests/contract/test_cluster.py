"""A run on a Dask cluster gives what a run on processes gives, also where a worker is killed in the middle."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import joblib
import pytest

from tests.command_line import undertow
from tests.local_cluster import local_cluster
from tests.small_campaign import make_campaign
from undertow.campaign.run import cluster
from undertow.campaign.run.workers import on_processes
from undertow.errors import ConfigError

TABLES = ("trials.csv", "levels.csv", "mismatch.csv", "verdict.json")


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="kills a process")
def test_a_cluster_that_loses_a_worker_in_the_middle_gives_the_same_numbers(tmp_path: Path) -> None:
    campaign = make_campaign(tmp_path / "c", [0.03, 0.05], springs=[f"s{i}" for i in range(6)])
    words = [sys.executable, "-m", "undertow", "run", str(campaign.config), "--out"]
    subprocess.run([*words, str(tmp_path / "here"), "--jobs", "2"], check=True, capture_output=True)
    with local_cluster(2) as found, subprocess.Popen(
        [*words, str(tmp_path / "there"), "--scheduler", found.address], stderr=subprocess.PIPE, text=True
    ) as process:  # fmt: skip
        until = time.monotonic() + 300.0
        while not list((tmp_path / "there").glob("stages/*.json")) and time.monotonic() < until:
            assert process.poll() is None
            time.sleep(0.01)
        os.kill(found.workers[0], signal.SIGKILL)
        assert process.stderr is not None
        said = process.stderr.read()
    assert process.returncode == 0, said
    assert "identification: 6 of 6" in said
    for name in TABLES:
        assert (tmp_path / "there" / name).read_bytes() == (tmp_path / "here" / name).read_bytes(), name
    here, there = (  # a part is what the killed worker was writing: nobody reads it
        {path.name: path.read_bytes() for path in (tmp_path / run / "stages").iterdir() if path.suffix != ".part"}
        for run in ("here", "there")
    )
    assert here == there


@pytest.mark.parametrize("address", ["", "tcp://127.0.0.1:1", "host", "ftp://x:1", "tcp://127.0.0.1:99999"])
def test_a_scheduler_that_is_not_there_is_said(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, address: str
) -> None:
    monkeypatch.setattr(cluster, "PATIENCE_S", 0.5)
    if address:  # a config is read before a scheduler is asked
        monkeypatch.setattr("undertow.campaign.config.load", lambda *said: None)
    said = undertow(capsys, "run", tmp_path / "none.yaml", "--scheduler", address)
    assert said.code == 2
    reason = r"config .*none\.yaml cannot be read" if not address else (
        rf"--scheduler '{re.escape(address)}' cannot be reached \(.*\); give the address that the scheduler printed"
    )  # fmt: skip
    assert re.match(f"undertow: {reason}", said.err), said.err


def test_without_dask_its_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ConfigError, match=r"needs Dask, which is not installed; pip install 'undertow\[dask\]'"):
        cluster.on_cluster("tcp://127.0.0.1:1").__enter__()


def test_workers_that_would_give_other_numbers_are_refused() -> None:
    code, packages = cluster.made_by()
    cluster._alike({"tcp://a": (code, packages)}, "x")
    with pytest.raises(ConfigError, match=r"'x' has no workers; start some, with: dask worker x"):
        cluster._alike({}, "x")
    with pytest.raises(ConfigError, match=r"worker tcp://a of x has numpy 1\.0 \(here .*\); install the same there"):
        cluster._alike({"tcp://a": (code, packages | {"numpy": "1.0"})}, "x")
    with pytest.raises(ConfigError, match=r"worker tcp://a of x has other sources of undertow; install the same"):
        cluster._alike({"tcp://a": ("other", packages)}, "x")


def test_the_backend_that_is_active_does_the_work() -> None:
    here = threading.get_ident()

    def where(item: int) -> int:
        return threading.get_ident()

    with joblib.parallel_config("threading"):
        assert here not in on_processes(where, [1, 2, 3, 4], 2, "work")


def test_a_cluster_of_one_worker_does_the_work_and_not_this_process() -> None:
    with local_cluster(1) as found, cluster.on_cluster(found.address):
        assert on_processes(lambda _: os.getpid(), range(3), 0, "who") == [found.workers[0]] * 3
