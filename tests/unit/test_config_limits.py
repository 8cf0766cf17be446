"""Configs, overrides and units that no laboratory writes: refused with a sentence, in seconds, without a traceback."""

from __future__ import annotations

import re
import time
from pathlib import Path

import pytest

from tests.command_line import undertow
from tests.small_campaign import CONFIG, make_campaign
from undertow.campaign.config import load
from undertow.campaign.config.source import read_source
from undertow.errors import ConfigError, RecordingError
from undertow.recording.channels import TimeSpec
from undertow.recording.units import factor_to_si


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("a: " + "{" * 30_000, r"c\.yaml line 1: lists and keys lie more than 32 levels deep; no key"),
        ("a: " + "[" * 30_000, r"more than 32 levels deep"),
        ("".join(f"{' ' * i}a:\n" for i in range(600)), r"c\.yaml line 33: lists and keys lie more than 32 levels"),
        ("".join(f"k{i}: {i}\n" for i in range(100_000)), r"has 1377780 bytes, more than 1000000; is it a co"),
        ("a: " + "9" * 5_000, r"c\.yaml: Exceeds the limit"),
        ("? - name:\n", r"c\.yaml line 1: a key is a list or has keys itself; write it as plain text"),
        ("a: 1\n{b: 2}: 3\n", r"c\.yaml line 2: a key is a list or has keys itself"),
        ("a: {[1, 2]: 3}\n", r"c\.yaml line 1: a key is a list or has keys itself"),
        ("a: &b [1]\nc: *b\n", r"c\.yaml line 2: an alias \(\*\.\.\.\) is not read"),
        ("a: !!python/object:os.system x\n", r"c\.yaml line 1: a tag \(!\.\.\.\) is not read"),
    ],
)
def test_a_config_that_a_parser_would_take_minutes_for_is_refused(tmp_path: Path, text: str, sentence: str) -> None:
    (tmp_path / "c.yaml").write_text(text)
    start = time.perf_counter()
    with pytest.raises(ConfigError, match=sentence):
        read_source(tmp_path / "c.yaml")
    assert time.perf_counter() - start < 5.0


def test_a_config_of_more_keys_than_allowed_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from undertow.campaign.config import source

    (tmp_path / "c.yaml").write_text("a: 1\n" * 300)
    monkeypatch.setattr(source, "TOKENS_AT_MOST", 1000)
    with pytest.raises(ConfigError, match=r"line 250: there are more than 1000 keys, values and marks up to here"):
        read_source(tmp_path / "c.yaml")


@pytest.mark.parametrize(
    ("override", "sentence"),
    [
        ("name=" + "[" * 3000, r"--set name=\.\.\. line 1: lists and keys lie more than 32 levels deep"),
        ("name=" + "{" * 3000, r"more than 32 levels deep"),
        (".".join("a" * 3000) + "=1", r"--set a\.a\.a.*\.\.\.: the key has 3000 parts; no key of a config has"),
        ("seed=" + "9" * 5000, r"--set seed=9+\.\.\.: '9+\.\.\. is no YAML value; quote it"),
        ("name=[1", r"is no YAML value; quote it"),
        ("name=!x 1", r"a tag \(!\.\.\.\) is not read; write the value itself"),
        ("=1", r"--set =1: it must read key\.key=value"),
    ],
)
def test_an_override_that_is_no_value_is_refused(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, override: str, sentence: str
) -> None:
    campaign = make_campaign(tmp_path, [0.04])
    said = undertow(capsys, "run", campaign.config, "--set", override)
    assert said.code == 2
    assert re.search(sentence, said.err), said.err
    assert len(said.err) < 400


@pytest.mark.parametrize(
    "unit",
    ["m-", "m//", "m/", "(", "m(m", "m**", "m^^2", "-", "%%", "m/s/", "m[m", "'m", "1e999", "m\0", "m" * 3000, "\ud800",
     "m s^-", "m**m", "lambda", "m:=1", "#", "\\", "µ°", "²"],
)  # fmt: skip
def test_a_unit_that_is_none_is_said(unit: str) -> None:
    with pytest.raises(RecordingError, match=r"displacement(: unit .* is not known; |\ is said to be in )"):
        factor_to_si(unit, "displacement")


@pytest.mark.parametrize("rate", ["1e-300", "1e300"])
def test_a_rate_that_no_logger_has_is_refused(tmp_path: Path, rate: str) -> None:
    campaign = make_campaign(tmp_path, [0.04])
    campaign.config.write_text(CONFIG.replace("{column: t, unit: s}", f"{{rate_hz: {rate}}}"))
    with pytest.raises(ConfigError, match=r"config\.yaml line 5: rate_hz is 1e.*300 Hz, which no logger has; give the"):
        load(campaign.config)
    with pytest.raises(RecordingError, match=r"rate_hz is 1e.*300 Hz, which no logger has; give the samples"):
        TimeSpec(rate_hz=float(rate))
