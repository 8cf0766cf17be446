"""Fetching public records: against a server on this machine that knows ranges, cuts lines, redirects and lies."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.record_server import CONTENT, MD5, SHA256, Server, serving
from undertow.campaign.fetch import download
from undertow.campaign.fetch import records as fetch
from undertow.errors import ConfigError, UndertowError


@pytest.fixture
def server() -> Iterator[Server]:
    with serving() as running:
        yield running


def got(source: str, into: Path, checksum: str = "", api: str | None = None) -> list[fetch.Fetched]:
    return list(fetch.fetch(source, into, checksum=checksum, zenodo_api=api, wait=lambda seconds: None))


def test_a_file_is_fetched_whole_with_its_checksum_beside_it(server: Server, tmp_path: Path) -> None:
    (file,) = got(f"{server.base}/data/run.csv", tmp_path)
    assert file.path.read_bytes() == CONTENT
    assert (tmp_path / "run.csv.sha256").read_text() == f"{SHA256}  run.csv\n"
    assert SHA256 in str(file)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["run.csv", "run.csv.sha256"]


def test_a_cut_transfer_goes_on_where_it_stopped(server: Server, tmp_path: Path) -> None:
    server.cut_after = [100_000, 50_000]
    (file,) = got(f"{server.base}/data/run.csv", tmp_path)
    assert file.path.read_bytes() == CONTENT
    assert server.ranges == [None, "bytes=100000-", "bytes=150000-"]


def test_a_transfer_given_up_goes_on_with_the_same_command(server: Server, tmp_path: Path) -> None:
    server.cut_after = [40_000] * download.TRIES
    with pytest.raises(UndertowError, match=r"was cut 5 times after 200000 bytes .*run the same command again"):
        got(f"{server.base}/data/run.csv", tmp_path)
    assert not (tmp_path / "run.csv").exists()
    server.ranges.clear()
    (file,) = got(f"{server.base}/data/run.csv", tmp_path)
    assert file.path.read_bytes() == CONTENT
    assert server.ranges == ["bytes=200000-"]


def test_a_file_that_changed_meanwhile_is_not_joined_to_its_old_beginning(server: Server, tmp_path: Path) -> None:
    server.cut_after = [40_000] * download.TRIES
    with pytest.raises(UndertowError, match="was cut"):
        got(f"{server.base}/data/run.csv", tmp_path)
    server.files["/data/run.csv"], server.etag = CONTENT[::-1], '"two"'
    (file,) = got(f"{server.base}/data/run.csv", tmp_path)
    assert file.path.read_bytes() == CONTENT[::-1]


def test_without_a_mark_only_a_file_with_a_known_checksum_goes_on(server: Server, tmp_path: Path) -> None:
    server.etag, server.cut_after = None, [100_000, 100_000]
    got(f"{server.base}/data/run.csv", tmp_path / "unknown")
    assert server.ranges == [None, None, None]
    server.ranges, server.cut_after = [], [100_000]
    got(f"{server.base}/data/run.csv", tmp_path / "known", checksum=f"sha256:{SHA256}")
    assert server.ranges == [None, "bytes=100000-"]


def test_a_beginning_longer_than_the_file_is_dropped(server: Server, tmp_path: Path) -> None:
    (tmp_path / ".run.csv.part").write_bytes(CONTENT + b"more")
    (tmp_path / ".run.csv.part.from").write_text(json.dumps({"url": f"{server.base}/data/run.csv", "mark": '"one"'}))
    (file,) = got(f"{server.base}/data/run.csv", tmp_path)
    assert file.path.read_bytes() == CONTENT


def test_a_server_that_is_busy_is_asked_again(server: Server, tmp_path: Path) -> None:
    server.answers = [503, 429]
    (file,) = got(f"{server.base}/data/run.csv", tmp_path)
    assert file.size == len(CONTENT)


def test_a_wrong_checksum_leaves_nothing_behind(server: Server, tmp_path: Path) -> None:
    with pytest.raises(UndertowError, match=r"run\.csv: SHA256 hash .* does not match .*; it was dropped"):
        got(f"{server.base}/data/run.csv", tmp_path, checksum="sha256:" + "0" * 64)
    assert list(tmp_path.iterdir()) == []


def test_a_missing_file_is_said_with_its_address(server: Server, tmp_path: Path) -> None:
    with pytest.raises(UndertowError, match=r"/data/nope\.csv answers 404 Not Found; check the address"):
        got(f"{server.base}/data/nope.csv", tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_host_that_is_not_there_is_said(server: Server, tmp_path: Path) -> None:
    with pytest.raises(UndertowError, match=r"was cut 5 times after 0 bytes \(.*refused"):
        got("http://127.0.0.1:1/a.csv", tmp_path)


@pytest.mark.parametrize("name", ["..%2f..%2fpasswd", "%2e%2e", "", "a%5Cb.csv", "C%3Aa.csv", "a%0Ab", "%20a.csv"])
def test_a_name_that_leaves_the_folder_is_refused(server: Server, tmp_path: Path, name: str) -> None:
    with pytest.raises(UndertowError, match=r"names a file .* which is no plain file name inside the folder"):
        got(f"{server.base}/data/{name}", tmp_path)


@pytest.mark.parametrize(
    "address", ["http://example.org/a.csv", "ftp://example.org/a.csv", "file:///etc/passwd", "https:///a.csv"]
)
def test_only_https_is_fetched(tmp_path: Path, address: str) -> None:
    with pytest.raises(UndertowError, match=r"has scheme .*; only https is fetched"):
        got(address, tmp_path)


def test_a_redirect_may_not_leave_https(server: Server, tmp_path: Path) -> None:
    server.redirects["/data/away.csv"] = "http://example.org/a.csv"
    with pytest.raises(UndertowError, match=r"'http://example.org/a.csv' \(where .*away\.csv leads\) has scheme"):
        got(f"{server.base}/data/away.csv", tmp_path)


def test_a_public_address_may_not_lead_to_this_machine() -> None:
    with pytest.raises(UndertowError, match=r"leads to this machine \(http://localhost/secret\)"):
        download.check_address("http://localhost/secret", before="https://example.org/a.csv")


def test_a_file_that_is_there_is_not_fetched_again(server: Server, tmp_path: Path) -> None:
    got(f"{server.base}/data/run.csv", tmp_path)
    (again,) = got(f"{server.base}/data/run.csv", tmp_path)
    assert again.checked == "(there already)"
    assert len(server.ranges) == 1


@pytest.mark.parametrize("checksum", ["", f"md5:{MD5}"])
def test_a_file_that_differs_is_never_replaced(server: Server, tmp_path: Path, checksum: str) -> None:
    (tmp_path / "run.csv").write_text("mine")
    with pytest.raises(UndertowError, match=r"run\.csv is there already .* its checksum should be .*; move it away"):
        got(f"{server.base}/data/run.csv", tmp_path, checksum=checksum)
    assert (tmp_path / "run.csv").read_text() == "mine"


@pytest.mark.parametrize(
    "source",
    ["10.5281/zenodo.12", "doi:10.5281/zenodo.12", "https://doi.org/10.5281/zenodo.12", "https://zenodo.org/records/12",
     "https://zenodo.org/record/12?preview=1"],
)  # fmt: skip
def test_a_zenodo_record_gives_its_files_checked(server: Server, tmp_path: Path, source: str) -> None:
    server.record()
    (file,) = got(source, tmp_path, api=server.base)
    assert file.path.read_bytes() == CONTENT
    assert file.checked == "(md5 agrees)"


def test_a_records_own_checksum_file_is_kept(server: Server, tmp_path: Path) -> None:
    links = {"self": f"{server.base}/data/run.csv"}
    one = {"size": len(CONTENT), "checksum": f"md5:{MD5}", "links": links}
    files = [{"key": name, **one} for name in ("run.csv", "run.csv.sha256")]
    server.files["/records/12"] = json.dumps({"files": files}).encode()
    got("10.5281/zenodo.12", tmp_path, api=server.base)
    assert (tmp_path / "run.csv.sha256").read_bytes() == CONTENT


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"checksum": "md5:" + "0" * 32}, r"run\.csv: MD5 hash .* it was dropped"),
        ({"checksum": "crc32:abc"}, r"record 12 gives the checksum 'crc32:abc', none of md5"),
        ({"size": 5}, r"run\.csv has 300000 bytes, its record says 5"),
        ({"key": "../run.csv"}, r"record 12 names a file '\.\./run\.csv', which is no plain file name"),
        ({"links": {}}, r"record 12: .* in a way that is not known \(KeyError\('self'\)\)"),
        ({"links": {"self": "http://example.org/a"}}, r"has scheme 'http'; only https"),
    ],
)
def test_a_record_that_cannot_be_trusted_is_refused(
    server: Server, tmp_path: Path, changes: dict[str, object], sentence: str
) -> None:
    server.record(**changes)
    with pytest.raises(UndertowError, match=sentence):
        got("10.5281/zenodo.12", tmp_path, api=server.base)
    assert not (tmp_path / "run.csv").exists()
    assert not (tmp_path.parent / "run.csv").exists()


@pytest.mark.parametrize(
    ("body", "sentence"),
    [
        (b"<html>", r"record 12: .*/records/12 gives no JSON"),
        (b'{"files": []}', r"record 12 has no open files; look at https://zenodo\.org/records/12"),
    ],
)
def test_a_record_without_files_is_said(server: Server, tmp_path: Path, body: bytes, sentence: str) -> None:
    server.files["/records/12"] = body
    with pytest.raises(UndertowError, match=sentence):
        got("10.5281/zenodo.12", tmp_path, api=server.base)


def test_a_record_that_is_not_there_is_said(server: Server, tmp_path: Path) -> None:
    with pytest.raises(UndertowError, match=r"record 99: .*/records/99 answers 404 Not Found"):
        got("10.5281/zenodo.99", tmp_path, api=server.base)


@pytest.mark.parametrize(
    ("source", "checksum", "sentence"),
    [
        ("10.1000/182", "", r"DOI '10\.1000/182' is none of Zenodo's"),
        ("run.csv", "", r"source 'run\.csv' is neither a DOI nor an address"),
        ("https://example.org/a", "crc32:1", r"checksum 'crc32:1' is not ALGORITHM:HEX"),
        ("10.5281/zenodo.12", f"md5:{MD5}", r"was given for record 10\.5281/zenodo\.12, which has its own"),
    ],
)
def test_a_source_that_is_not_understood_is_said(source: str, checksum: str, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match=sentence):
        got(source, tmp_path, checksum)


def test_a_line_that_hardly_gives_anything_is_given_up(
    server: Server, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(download, "PATIENCE_S", 0.1)
    server.endless = b"x", 0.02
    with pytest.raises(UndertowError, match=r"sent \d+ bytes in 0 s, less than 500 a second; run the same comm"):
        got(f"{server.base}/data/run.csv", tmp_path)
    server.record()
    with pytest.raises(UndertowError, match=r"/records/12 sent \d+ bytes in 0 s, less than 500 a second"):
        got("10.5281/zenodo.12", tmp_path, api=server.base)


def test_an_answer_without_an_end_stops_at_what_a_file_may_have(
    server: Server, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(download, "UNSTATED_BYTES", 1 << 20)
    server.says_length, server.endless = False, (bytes(1 << 18), 0.0)
    with pytest.raises(UndertowError, match=r"run\.csv sends more than 1048576 bytes; fetch it by hand if it is"):
        got(f"{server.base}/data/run.csv", tmp_path)
    server.says_length, server.endless = True, None
    monkeypatch.setattr(download, "LARGEST_BYTES", 1000)
    with pytest.raises(UndertowError, match=r"run\.csv has 300000 bytes, more than 1000; fetch it by hand"):
        got(f"{server.base}/data/run.csv", tmp_path)


@pytest.mark.parametrize(
    ("address", "sentence"),
    [
        ("https://[::1", r"address 'https://\[::1' cannot be read \(Invalid IPv6 URL\); correct it"),
        ("https://example.org:port/a", r"cannot be read \(Port could not be cast"),
        ("https://example.org:0/a", r"cannot be read \(its port is 0\)"),
        ("https://example..org/a", r"cannot be read \(.*label"),
        ("https://example.org/a b", r"cannot be read \(it has blanks or characters that an address writes with %\)"),
        ("https://example.org/\x7f", r"cannot be read \(it has blanks"),
        ("https://example.org/ö", r"cannot be read \(it has blanks"),
        ("https://" + "a" * 5000, r"cannot be read \(.*label"),
        ("https://", r"has scheme 'https'; only https is fetched|cannot be read"),
    ],
)
def test_an_address_that_is_none_is_said(tmp_path: Path, address: str, sentence: str) -> None:
    with pytest.raises(UndertowError, match=sentence):
        got(address, tmp_path)


@pytest.mark.parametrize(
    "body",
    [
        b"[" * 100_000, b'"files"', b"[1, 2]", b'{"files": 3}', b'{"files": {"a": 1}}', b'{"files": [[]]}', b"\xff\xfe",
        b'{"files": [{"key": "a", "links": {"self": 1}, "checksum": 2, "size": 1e999}]}', b"NaN", b"null", b"1" * 9000,
        b'{"files": [{"key": "\\ud800", "links": {"self": "x"}, "checksum": "md5:00", "size": 1}]}',
    ],
)  # fmt: skip
def test_a_records_description_that_is_none_is_said(server: Server, tmp_path: Path, body: bytes) -> None:
    server.files["/records/12"] = body
    with pytest.raises(UndertowError, match=r"record 12.*(gives no JSON|not known|gives the checksum|names a file)"):
        got("10.5281/zenodo.12", tmp_path, api=server.base)


@pytest.mark.skipif(os.name != "posix", reason="sends SIGTERM")
def test_a_stopped_fetch_says_that_what_was_fetched_is_kept(server: Server, tmp_path: Path) -> None:
    server.endless = (b"x" * 1000, 0.05)
    words = ["fetch", f"{server.base}/data/run.csv", "--into", str(tmp_path)]
    with subprocess.Popen([sys.executable, "-m", "undertow", *words], stderr=subprocess.PIPE, text=True) as process:
        part = tmp_path / ".run.csv.part"
        until = time.monotonic() + 60.0
        while not part.exists() and time.monotonic() < until:
            time.sleep(0.02)
        process.terminate()
        assert process.stderr is not None
        said = process.stderr.read()
    assert process.returncode == 130
    assert said.splitlines()[-1] == (
        "undertow: interrupted; what was fetched is kept, the same command goes on from there"
    )
    assert part.exists()
