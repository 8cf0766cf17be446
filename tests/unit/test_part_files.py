"""A finished part of a run on disk: whole and its own, or as good as none, and said."""

from __future__ import annotations

import json
import logging
from pathlib import Path

import pytest

from undertow.campaign.run import part_files
from undertow.campaign.run.part_files import read_part, write_part

DATA = {"value": [0.1, 3e-300, float("nan"), float("inf"), None, True], "text": "\u00b5 \u2603 \"", "nested": {"1": []}}


@pytest.fixture
def part(tmp_path: Path) -> Path:
    write_part(tmp_path / "stages" / "abc.json", DATA)
    return tmp_path / "stages" / "abc.json"


def test_what_was_written_comes_back_and_nothing_else_lies_there(part: Path) -> None:
    assert repr(read_part(part)) == repr(DATA)
    assert [path.name for path in part.parent.iterdir()] == ["abc.json"]


def test_every_changed_digit_is_seen(part: Path, caplog: pytest.LogCaptureFixture) -> None:
    whole = part.read_text()
    digits = [at for at, character in enumerate(whole) if character.isdigit()]
    for at in digits:
        part.write_text(whole[:at] + str((int(whole[at]) + 1) % 10) + whole[at + 1 :])
        assert read_part(part) is None, whole[at - 10 : at + 10]
    assert len(caplog.records) == len(digits) > 50


def test_a_part_cut_anywhere_is_as_none(part: Path) -> None:
    whole = part.read_bytes()
    for keep in range(len(whole)):
        part.write_bytes(whole[:keep])
        assert read_part(part) is None, keep


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "is damaged: it cannot be read as JSON"),
        (b"\xff\xfe{}", "is damaged: it cannot be read as JSON"),
        (b"[" * 100_000, "is damaged: it cannot be read as JSON"),
        (b"null", "is damaged or foreign: a part has format, name, sha256 and data"),
        (b'{"trials": []}', "is damaged or foreign: a part has format, name, sha256 and data"),
        (b'{"format": 1, "name": "abc", "sha256": "", "data": 0}', "has format 1, and this version reads 3"),
        (b'{"format": 3, "name": "xyz", "sha256": "", "data": 0}', "was written under another name, 'xyz'"),
        (b'{"format": 3, "name": "abc", "sha256": [], "data": 0}', "is damaged: its checksum is another"),
        (b"\x80\x04K\x01.", "is damaged: it cannot be read as JSON"),
    ],
)
def test_what_is_no_part_of_this_run_is_said_and_made_again(
    part: Path, content: bytes, said: str, caplog: pytest.LogCaptureFixture
) -> None:
    part.write_bytes(content)
    with caplog.at_level(logging.WARNING, "undertow"):
        assert read_part(part) is None
    assert caplog.messages == [f"part abc.json of the run folder {said}; it is made again"]


def test_a_part_under_another_parts_name_is_not_taken(part: Path) -> None:
    part.rename(part.with_name("xyz.json"))
    assert read_part(part.with_name("xyz.json")) is None
    assert read_part(part) is None


def test_a_part_larger_than_memory_is_not_read(part: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(part_files, "LARGEST_BYTES", 10)
    monkeypatch.setattr(json, "loads", lambda text: pytest.fail("it was read"))
    assert read_part(part) is None
