"""undertow audit: its files, its exit codes, its messages."""

from __future__ import annotations

import contextlib
import html
import io
import json
import re
from pathlib import Path

import pytest

from tests.command_line import undertow
from undertow.campaign.audit.published import audit
from undertow.campaign.audit.settings import load_audit
from undertow.campaign.audit.tables import read_table
from undertow.campaign.config import load
from undertow.cli import main
from undertow.errors import ConfigError

CONFIG = Path(__file__).resolve().parents[2] / "configs" / "published.yaml"
SMALL = 'audits=[{name: Table 8, tables: [table08], what_if: {"softer": {short: 386500}}}]'
"""The cheapest audit of the committed ones: four rows, Method 2."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("audit")
    said = io.StringIO()
    with pytest.raises(SystemExit, match=r"^\d*$") as end, contextlib.redirect_stdout(said):
        main(["audit", str(CONFIG), "--set", SMALL, "--set", "nodes=8", "--out", str(out)])
    assert not end.value.code
    assert "Table 8: " in said.getvalue()
    (out / "terminal.txt").write_text(said.getvalue(), encoding="utf-8")
    return out


def test_a_config_of_recordings_is_no_audit():
    with pytest.raises(ConfigError, match=r"flume\.yaml is a config of recordings, for undertow run; an audit's has"):
        load_audit(CONFIG.with_name("flume.yaml"))
    with pytest.raises(ConfigError, match=r"published\.yaml is a config of published tables, for undertow audit"):
        load(CONFIG)


def test_audit_json_has_the_contracts_names_and_a_sentence_a_table(folder):
    said = json.loads((folder / "audit.json").read_text(encoding="utf-8"))
    assert said["contract"] == 1
    (table,) = said["tables"]
    assert table["status"] in {"explained", "nothing_missing", "unknown", "not_identifiable"}
    assert table["verdict"] == ["rest_offset"]
    assert set(table["what_if"]) == {"softer"}
    found = table["groups"][0]["parameters"]["rest_offset"]["offset_m"]
    assert found["low"] < found["value"] < found["high"]
    assert found["stderr"] > 0.0
    assert found["unit"] == "m"
    assert table["sentence"].endswith(".")
    assert sum(rival["probability"] for rival in table["rivals"]) == pytest.approx(1.0)
    caps = [one["rows_scatter_at_most_of_mass"] for one in table["equation_15_probability"]]
    assert caps == [0.05, 0.1, 0.2]


def test_every_check_has_a_rule_and_both_numbers_or_says_there_is_one(folder):
    said = json.loads((folder / "audit.json").read_text(encoding="utf-8"))
    assert len(said["checks"]) > 30
    for check in said["checks"]:
        assert check["rule"]
        assert check["sentence"].endswith(".")
        if check["rule"] not in {"on its bound", "not printed"}:
            assert None not in (check["printed"], check["expected"])


def test_the_page_stands_alone_and_shows_every_figure(folder):
    page = (folder / "audit.html").read_text(encoding="utf-8")
    assert page.count("<svg") == len(list((folder / "figures").glob("*.svg"))) == 3
    assert not re.search(r'(src|href)="(?!#|data:)', page)
    assert "http" not in re.sub(r'xmlns(:\w+)?="[^"]*"|<!DOCTYPE[^>]*>', "", page)


def test_the_terminal_says_the_pages_sentence_in_words(folder):
    said = (folder / "terminal.txt").read_text(encoding="utf-8").splitlines()
    assert "rest offset" in said[0]
    assert not re.search(r"\b[a-z]+_[a-z]+|\de[+-]?\d", said[0])
    series = json.loads((folder / "audit.json").read_text(encoding="utf-8"))["tables"][0]
    assert "rest_offset" in series["sentence"]  # in the file names are those of the contract


def readable(page: str) -> str:
    """What a reader sees of a page: no styles, scripts or tags."""
    return html.unescape(re.sub(r"<style>.*?</style>|<script>.*?</script>|<[^>]*>", "", page, flags=re.DOTALL))


def test_the_page_has_words_and_signs_in_place_of_names(folder):
    text = readable((folder / "audit.html").read_text(encoding="utf-8"))
    assert not re.findall(r"\b[a-z]+_[A-Za-z]\w*|\+-|\^\d|\d[eE][+-]?\d|x''", text)
    assert "1.0918 × 10⁸" in text
    assert "water depth 2.22 and 2.29\N{NO-BREAK SPACE}m" in text
    assert "rest offset: offset, m" in text


def test_the_page_begins_with_what_the_tables_contradict_and_what_follows(folder):
    text = readable((folder / "audit.html").read_text(encoding="utf-8"))
    lead = "These tables contradict themselves, each other or the equation in 43 places, most often (16) where one"
    follows = "Eq. 15 alone prints 0 of 1 tables or pairs of tables that were tried; what prints them is named for 1."
    assert text.index(lead) < text.index(follows) < text.index("Verdicts")


def test_every_figure_has_a_caption_and_its_probabilities_a_prior(folder):
    page = (folder / "audit.html").read_text(encoding="utf-8")
    assert len(re.findall(r"</svg>\s*<figcaption>", page)) == page.count("<svg")
    assert "evidence times a prior" in page
    assert "Linear damping of the water is counted as drag too" in page


def test_probabilities_are_per_cent_in_table_sentence_and_figure(folder):
    table = json.loads((folder / "audit.json").read_text(encoding="utf-8"))["tables"][0]
    percent = f"{100.0 * table['confidence']:.3g}\N{NO-BREAK SPACE}%"
    page = (folder / "audit.html").read_text(encoding="utf-8")
    assert f"<td>{percent}</td>" in page
    assert f"probability {percent}" in page
    assert not re.search(r"probability (?:of |above )?0\.\d", readable(page))


def test_what_is_said_of_several_tables_is_one_row(folder):
    page = (folder / "audit.html").read_text(encoding="utf-8")
    assert page.count('<td class="rule">same quantity</td>') == 2  # added mass, drag coefficient
    assert "<li>Table 4 and Table 9: 1271.4 and 2042\N{NO-BREAK SPACE}kg, 1 of 1 common rows</li>" in page
    assert "Tables 5, 7 and 8: potential energy is headed kJ" in page
    assert "Table 4 and Table 6: the same water" in page


def test_the_page_follows_the_readers_dark_or_light(folder):
    page = (folder / "audit.html").read_text(encoding="utf-8")
    assert 'id="theme"' in page
    assert "prefers-color-scheme: dark" in page
    assert "var(--fig-ink)" in page


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("audits=[{name: a, tables: [table99]}]", "names table 'table99'; there are table01"),
        ("tables.table05.columns.release.unit=kg", "unit 'kg' is no release; write one that converts to m"),
        ("tables.table05.columns.release.column=x", "there is no column 'x'; the file has x0_m"),
        ("tables.table05.file=none.csv", "none.csv cannot be read: No such file or directory; check the path"),
        ("tables.table05.columns={speed: {column: x0_m, unit: m}}", "quantity 'speed' is not known; a column may be "),
        ("laboratory.cell.depth_m=[0.1]", "must have one value a level, got 3, 3, 1"),
        ("audits=[{name: a, tables: [table01]}]", "table table01 has recipe 'envelope'; state method1 or method2"),
        ("tables.table05.columns.release={column: x0_m, unit: '2'}", "unit '2' is no release"),
    ],
)  # fmt: skip
def test_what_a_config_gets_wrong_is_said_in_one_sentence(override, message):
    with pytest.raises(ConfigError, match=re.escape(message)):
        audit(load_audit(CONFIG, [override]))


def test_a_table_without_releases_is_refused_with_its_remedy():
    columns = "tables.table08.columns={added_mass: {column: added_mass_kg, unit: kg}}"
    with pytest.raises(ConfigError, match="table table08 has neither release nor energy; map one of them"):
        audit(load_audit(CONFIG, [SMALL, columns]))


SMALL_TABLE = (
    "name: t\nlaboratory: {mass_kg: 1, area_m2: 1, dry: 0}\n"
    "tables: {t: {title: T, file: t.csv, columns: {release: {column: x0_m, unit: UNIT}, "
    "added_mass: {column: m_a, unit: kg}}}}\n"
)


@pytest.mark.parametrize(
    ("table", "unit", "message"),
    [
        ("x0_m,m_a\n0.1,much\n", "m", "added_mass: row 1 holds 'much', which is no number; correct the file"),
        ("x0_m,m_a\n0.1,\n", "m", "row 1 holds '', which is no number"),
        ("x0_m,m_a\n0.1,1\n0.2,nan\n", "m", "row 2 holds 'nan', which is not finite or beyond 1e+12 kg"),
        ("x0_m,m_a\n0.1,1e300\n", "m", "row 1 holds '1e300', which is not finite or beyond"),
        ("x0_m,m_a\n0.1,1\n-0.2,2\n", "m", "release: row 2 is -0.2 m; it must be positive, leave the row out"),
        ("x0_m,m_a\n0,1\n", "mm", "release: row 1 is 0 mm; it must be positive"),
        ("", "m", "t.csv has 0 rows below its header; a table needs one"),
        ("x0_m,m_a\n", "m", "t.csv has 0 rows below its header"),
        ("x0_m,m_a\n0.1,1,2\n", "m", "row 1 of t.csv has 3 cells and its header 2; give each row one cell a column"),
        ("x0_m,m_a\n0.1\n", "m", "row 1 of t.csv has 1 cells and its header 2"),
        ("x0_m,m_a,m_a\n0.1,1,2\n", "m", "the header of t.csv repeats a name: x0_m, m_a, m_a; rename one"),
        ("x0_m,mass\n0.1,1\n", "m", "added_mass: there is no column 'm_a'; the file has x0_m, mass"),
        ("x0_m,m_a\n0.1,1\n", "-m", "unit '-m' is no release; write one that converts to m"),
        ("x0_m,m_a\n0.1,1\n", "0 m", "unit '0 m' is no release"),
    ],
)  # fmt: skip
def test_a_table_that_cannot_be_read_is_refused_with_its_row(tmp_path, table, unit, message):
    (tmp_path / "t.csv").write_text(table, encoding="utf-8")
    (tmp_path / "audit.yaml").write_text(SMALL_TABLE.replace("UNIT", f"'{unit}'"), encoding="utf-8")
    with pytest.raises(ConfigError, match=re.escape(message)):
        read_table(load_audit(tmp_path / "audit.yaml"), "t")


def test_a_file_that_is_no_text_is_refused(tmp_path):
    (tmp_path / "t.csv").write_bytes(b"\xff\xfe\x00\x01")
    (tmp_path / "audit.yaml").write_text(SMALL_TABLE.replace("UNIT", "m"), encoding="utf-8")
    with pytest.raises(ConfigError, match=r"t\.csv cannot be read: it is no CSV in UTF-8; check the path"):
        read_table(load_audit(tmp_path / "audit.yaml"), "t")


def test_what_a_stranger_called_his_table_stays_text_and_inside_the_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    name = "<script>alert(1)</script>"
    (tmp_path / "t.csv").write_text("x0_m,m_a\n0.1,1\n0.2,2\n0.3,3\n0.4,5\n", encoding="utf-8")
    said = SMALL_TABLE.replace("UNIT", "m").replace("title: T", f'title: "{name}"').replace("name: t", "name: ../../t")
    (tmp_path / "audit.yaml").write_text(said, encoding="utf-8")
    with pytest.raises(SystemExit, match=r"^\d*$") as end, contextlib.redirect_stdout(io.StringIO()):
        main(["audit", "audit.yaml"])
    assert not end.value.code
    (page,) = tmp_path.rglob("audit.html")
    assert page.parent.parent == tmp_path / "runs"
    text = page.read_text(encoding="utf-8")
    assert "<script>alert" not in text
    assert "&lt;script&gt;" in text


def test_a_tag_in_the_yaml_is_not_run(capsys, tmp_path):
    (tmp_path / "audit.yaml").write_text("name: !!python/object/apply:os.getcwd []\n", encoding="utf-8")
    answered = undertow(capsys, "audit", tmp_path / "audit.yaml")
    assert answered.code == 2
    assert "line 1: a tag (!...) is not read" in answered.err


def test_releases_that_stick_at_once_end_in_one_sentence(capsys, tmp_path):
    small = "tables.table08.columns.release={column: added_mass_kg, unit: nm}"
    answered = undertow(capsys, "audit", CONFIG, "--set", SMALL, "--set", small, "--out", tmp_path)
    assert answered.code == 1
    assert "rivals can be tried; audit case Table 8: the recipes cannot be run" in answered.err.splitlines()[-1]
    assert "Traceback" not in answered.err


def test_a_wrong_config_exits_with_2_and_a_missing_one_too(capsys, tmp_path):
    assert undertow(capsys, "audit", CONFIG, "--set", "nodes=1").code == 2
    assert undertow(capsys, "audit", tmp_path / "none.yaml").code == 2
