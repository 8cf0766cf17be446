"""The page: it says what was found, shows texts of others as texts, and needs nothing but itself."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from functools import cache
from html.parser import HTMLParser
from pathlib import Path

import pytest

from tests.findings_fixture import MARKUP, bare_findings, make_findings, named, small_findings
from undertow.discrepancy.findings import FailedTrial, Findings
from undertow.discrepancy.verdict import Described, Gate
from undertow.equation import registry
from undertow.equation.equation import Equation
from undertow.front.terminal.verdicts import status_said
from undertow.quantities import Estimate
from undertow.report import blocks
from undertow.report.behind import repaired_block
from undertow.report.extent import Extent, key_of
from undertow.report.first_screen import level_sentences
from undertow.report.group_figures import equation_svg
from undertow.report.html import ROWS_AT_MOST, page, page_figures, write_report
from undertow.report.style import page_style
from undertow.report.verdict_file import group_json

CONFIG_TEXT = f"name: {MARKUP}\ntitle: <b>&"
MANIFEST = {
    "undertow": "0.1.0", "config": "a<i>.yaml", "seed": 3, "packages": {"numpy": "2"}, "wall_time_s": {"read": 1.5},
    "config_text": CONFIG_TEXT,
}  # fmt: skip


def hostile() -> Findings:
    """The small campaign with markup in every text that comes from outside."""
    findings = small_findings()
    group = named(findings.groups[1])
    key = {"spring": f"s{MARKUP}", "water_depth_m": 2.36}
    group = replace(group, key=key, notes=(f"n{MARKUP}",))
    verdict = replace(group.verdict, sentence=f"v{MARKUP}", next_test=f"t{MARKUP}", group=key)
    failed = (FailedTrial(f"f{MARKUP}", f"r{MARKUP}", {}),)
    return replace(
        findings, groups=(findings.groups[0], replace(group, verdict=verdict)), failed=failed,
        across_groups=f"a{MARKUP}", notes=(f"o{MARKUP}",),
    )  # fmt: skip


@cache
def rendered(hostile_texts: bool = False) -> str:
    first, second = small_findings().groups
    findings = hostile() if hostile_texts else replace(small_findings(), groups=(first, named(second)))
    with page_style():
        return page(findings, page_figures(findings), MANIFEST)


class Reader(HTMLParser):
    """Tags that stay open, attributes that name a place, and the text."""

    VOID = frozenset({"meta", "br", "hr", "img", "link", "input"})

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[str] = []
        self.attributes: list[tuple[str, str]] = []
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += [(name, value or "") for name, value in attrs]
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes += [(name, value or "") for name, value in attrs]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag, tag

    def handle_data(self, data: str) -> None:
        if self.open[-1:] != ["script"]:
            self.text += data


def read(text: str) -> Reader:
    reader = Reader()
    reader.feed(text)
    reader.close()
    return reader


# ---------------------------------------------------------------- whole page
def test_every_tag_is_closed_in_its_order() -> None:
    assert read(rendered(True)).open == []


def test_no_text_from_outside_becomes_markup() -> None:
    reader = read(rendered(True))
    assert reader.tags.count("script") == 3  # the page's own: curves, library, what they do
    assert "i" not in reader.tags
    for mark in "stvfrano":
        assert f"{mark}{MARKUP}" in reader.text, mark
    assert CONFIG_TEXT in reader.text
    assert "a<i>.yaml" in reader.text
    assert not [name for name, _ in reader.attributes if name.startswith("on")]


def test_the_page_loads_nothing_from_anywhere() -> None:
    reader = read(rendered(True))
    for name, value in reader.attributes:
        if name in ("src", "href", "xlink:href", "data", "action"):
            assert value.startswith("#"), (name, value)
        if name == "style" or name.startswith("clip"):
            assert not re.search(r"url\((?!['\"]?#)", value)
    assert not {"link", "iframe", "object", "embed", "base", "img"} & set(reader.tags)
    style = rendered().split("<style>")[1].split("</style>")[0]
    assert "url(" not in style
    assert "@import" not in style
    outside = set(re.findall(r"(?:https?|file)://[^\"\s<]+", rendered()))
    assert outside <= {"http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"}


def test_every_link_of_the_page_leads_to_a_place_on_it() -> None:
    reader = read(rendered())
    places = {value for name, value in reader.attributes if name == "id"}
    links = {value[1:] for name, value in reader.attributes if name == "href"}
    assert {"spring-short-water-depth-1-63-m", "failed", "made"} <= links <= places


def test_the_same_findings_give_the_same_page_and_figures(tmp_path: Path) -> None:
    findings = bare_findings()
    folders = [tmp_path / "a", tmp_path / "b"]
    for folder in folders:
        folder.mkdir()
        write_report(findings, folder, MANIFEST)
    first, second = ({p.name: p.read_bytes() for p in folder.rglob("*.*")} for folder in folders)
    assert first == second
    assert {"report.html", "all-trials--runs.svg", "all-trials--equation.svg"} <= set(first)


@pytest.mark.parametrize("rotation", [False, True])
def test_one_trial_of_a_rate_alone_without_any_error_bar_makes_a_page(rotation: bool) -> None:
    findings = bare_findings(velocity_only=True, coordinate="rotation" if rotation else "translation")
    with page_style():
        text = read(page(findings, page_figures(findings), {})).text
    assert "19.3, no error bar" in text
    assert f"per unit {'inertia' if rotation else 'mass'}" in text
    assert ("inertia" in text) is rotation


def test_figures_of_a_group_called_all_trials_do_not_stand_above_the_groups() -> None:
    findings = bare_findings()
    with page_style():
        text = page(findings, page_figures(findings), {})
    above = text.split("<section")[0]
    assert "<figure>" not in above


def test_two_groups_whose_names_look_alike_keep_their_own_figures() -> None:
    group = bare_findings().groups[0]
    groups = tuple(replace(group, key={"spring": name}) for name in ("a b", "a-b", "a b runs", "水"))
    with page_style():
        names = set(page_figures(replace(bare_findings(), groups=groups)))
    kinds = {"energy", "equation", "equation-slim", "noise", "runs", "summary"}
    places = ("spring-a-b", "spring-a-b-2", "spring-a-b-runs", "spring")
    assert names == {"campaign--first", *(f"{place}--{kind}" for place in places for kind in kinds)}


# ---------------------------------------------------------------- what it says
def test_the_first_table_has_a_row_for_every_group_with_its_verdict() -> None:
    table = rendered().split('id="overview"')[1].split("</table>")[0]
    rows = table.split("<tr")[2:]
    assert len(rows) == 2
    assert [cell.partition("<")[0] for cell in table.split("<th>")[1:3]] == ["group", "verdict"]  # wide numbers follow
    assert ">nothing missing<" in rows[0].split("<td")[2]
    assert ">nothing missing<" in rows[0]
    assert ">hidden resonator<" in rows[1]
    assert "added mass (kg)" in table
    assert "viscous damping (N\u00a0s/m)" in table


def test_the_overview_holds_the_reference_methods_numbers() -> None:
    findings = make_findings()
    table = blocks.overview(findings, [str(i) for i in range(6)])
    column = table["columns"].index("added mass (kg)")
    statuses = set()
    for group, row in zip(findings.groups, table["rows"], strict=True):
        numbers, after = group.fits["output_error"].parameters, group.verdict.augmented
        said, unknown = row["cells"][column], group.verdict.status == "unknown"
        if group.dry:
            assert said == ""
        else:
            statuses.add(group.verdict.status)
            assert said.startswith("(") is unknown  # in brackets: bent by something that is missing and not known
            value, error = (float(part) for part in said.strip("()").split(" ± "))
            expected = numbers if after is None or unknown else after.parameters
            assert value == pytest.approx(expected["added_mass_kg"].value, abs=error)
            assert error == pytest.approx(expected["added_mass_kg"].total_stderr, rel=0.1)
    assert "unknown" in statuses


def test_where_something_is_named_the_overview_holds_the_repaired_numbers() -> None:
    """An added mass of 7.13 +- .05 kg had stood beside "hidden resonator", where 4.2 is right and the repair had it."""
    group = small_findings().groups[1]
    resonator = {"hidden_resonator": {"mass_kg": Estimate(3.0, 0.1, unit="kg")}}
    after = Described(0.01, 0.01, {"added_mass_kg": Estimate(4.22, 0.06, unit="kg")})
    named = replace(group.verdict, status="explained", verdict=("hidden_resonator",), parameters=resonator,
                    augmented=after)  # fmt: skip
    for status, said in (("explained", "4.22 ± 0.06"), ("not_identifiable", "4.22 ± 0.06"), ("unknown", "(")):
        one = replace(group, verdict=replace(named, status=status))
        table = blocks.overview(replace(small_findings(), groups=(one,)), ["a"])
        cell = table["rows"][0]["cells"][table["columns"].index("added mass (kg)")]
        assert cell.startswith(said)
    assert "4.22" not in cell  # what is described beside something unknown is not believed


def test_per_cent_stand_on_their_number_s_line_but_a_config_s_text_is_as_it_was_written() -> None:
    findings = replace(small_findings(), across_groups="misses 4.1 % of the motion")
    with page_style():
        text = page(findings, page_figures(findings), {"config_text": "title: 5 % of <all>"})
    assert '<p class="lead">misses 4.1\u00a0% of the motion</p>' in text
    assert "title: 5 % of &lt;all&gt;" in text


def test_the_sentence_over_all_groups_has_parameters_in_words() -> None:
    findings = replace(small_findings(), across_groups="But added_mass_kg is 3 kg with spring long")
    with page_style():
        text = page(findings, page_figures(findings), {})
    assert '<p class="lead">But added mass is 3 kg with spring long</p>' in text


def test_a_named_verdict_shows_its_numbers_check_next_test_and_what_was_ruled_out() -> None:
    text = read(rendered()).text.replace("\u00a0±\u00a0", " ± ")
    assert "explained with hidden resonator" in text
    for words in ("hidden resonator: mass300 ± 6 kg", "natural frequency9.60 ± 0.05 rad/s", "damping0.80 ± 0.20 1/m"):
        assert words in re.sub(r"\s*\n\s*", "", text)
    assert "the cells allow 1.5 Hz and more <i>" in text
    assert "a wave gauge <b>" in text
    assert "error stays at 0.38 <i>" in text
    assert "98\u00a0%" in text


@pytest.mark.parametrize(
    ("status", "names", "words", "tone"),
    [
        ("nothing_missing", (), "nothing missing", "good"),
        ("explained", ("hidden_resonator", "hidden_resonator"), "explained with 2 hidden resonators", "found"),
        ("unknown", ("unknown",), "not explained", "open"),
        ("unknown", ("relaxation", "unknown"), "relaxation + unknown", "open"),
        ("not_identifiable", ("relaxation",), "not identifiable: relaxation or linear damping", "open"),
    ],
)
def test_a_status_is_said_in_words_and_colour(status: str, names: tuple[str, ...], words: str, tone: str) -> None:
    verdict = replace(small_findings().groups[0].verdict, status=status, verdict=names)  # type: ignore[arg-type]
    verdict = replace(verdict, alternatives=(("linear_damping",),) if status == "not_identifiable" else ())
    assert blocks.status_words(verdict) == words
    assert blocks.tone(verdict) == tone


def test_what_leaves_more_than_noise_is_said_to_describe_on_page_and_terminal() -> None:
    """19 times the sensors' noise left had a tag "explained with"."""
    findings = replace(small_findings(), groups=(named(small_findings().groups[1]),))
    (group,) = findings.groups
    for passed, tag, cell in ((True, "explained with", "explained"), (False, "described by", "described")):
        gate = Gate("left_above_noise", "mean squared residual over noise", 371.0, 2.5, passed)
        verdict = replace(group.verdict, decision=(gate,))
        assert blocks.status_words(verdict) == f"{tag} hidden resonator"
        assert status_said(group_json(verdict)) == cell
        (said,) = level_sentences(replace(findings, groups=(replace(group, verdict=verdict),)))
        assert ("is described by" in said["text"]) is not passed


def test_the_methods_table_marks_a_bound_and_the_printed_recipe() -> None:
    group = small_findings().groups[1]
    block = blocks.group_block(small_findings(), group, "g", {})
    rows = {row["label"]: row for row in block["methods"]}
    assert rows["Method 2 as printed"]["as_printed"]
    mass = block["columns"].index("added mass (kg)")
    assert rows["Method 1"]["cells"][mass]["problem"] == "on its lower bound, 0 kg"
    drag = block["columns"].index("drag coefficient")
    assert rows["Method 2"]["cells"][drag]["text"] == "33, no error bar"
    assert rows["SINDy"]["cells"][mass]["parts"].startswith("noise ")


def test_methods_that_differ_are_named_with_the_difference() -> None:
    group = small_findings().groups[1]
    far = replace(group.fits["sindy"], parameters={"added_mass_kg": Estimate(200.0, 30.0, 0.0, "kg")})
    near = replace(group.fits["output_error"], parameters={"added_mass_kg": Estimate(-80.0, 40.0, 0.0, "kg")})
    two = replace(group, fits={"sindy": far, "output_error": near})
    assert blocks.agreement_texts(two, ["added_mass_kg"]) == [
        "They differ on added mass (SINDy and Output error by 280 kg, 5.6 standard errors apart)"
    ]
    alike = replace(two, fits={"sindy": far, "output_error": far})
    assert blocks.agreement_texts(alike, ["added_mass_kg", "mu"]) == [
        "The methods agree within two combined standard errors on added mass"
    ]


def test_trial_rows_say_where_an_unexplained_residual_is_and_nothing_of_an_explained_one() -> None:
    unexplained = small_findings().groups[1].trials[0]
    explained = replace(unexplained, mismatch=replace(unexplained.mismatch, repeatability_nrmse=2.0))
    assert blocks.where_words(explained) == ""
    assert blocks.where_words(unexplained) == "50 % in the second third, 80 % in a line at 1.61 Hz"
    unknown = dict.fromkeys(("share_early", "share_middle", "share_late", "line_share"), math.nan)
    nothing = replace(unexplained, mismatch=replace(unexplained.mismatch, **unknown))
    assert blocks.where_words(nothing) == ""


def test_counts_are_said_with_their_nouns() -> None:
    assert blocks.counts(bare_findings()) == {"trials": "1 trial", "groups": "1 group", "failed": "", "missing": ""}
    assert blocks.counts(small_findings())["missing"] == "4 of 8 trials"
    assert blocks.counts(small_findings())["failed"] == "1"


# ---------------------------------------------------------------- equation
@pytest.mark.parametrize("name", registry.names())
@pytest.mark.parametrize("mass", [1.0, 2637.4])
def test_every_term_of_the_registry_can_be_typeset(name: str, mass: float) -> None:
    stiffness, term = registry.find("stiffness"), registry.find(name)
    terms = (stiffness, term) if name != "stiffness" else (term,)
    equation = Equation(terms, (4.1e5, -0.5)[: len(terms)], mass)
    svg = equation_svg(equation, {"stiffness": 300.0, name: 0.2})
    assert svg.count("<use") > 10
    assert "<text" not in svg


# ---------------------------------------------------------------- a part of a large campaign
def test_a_page_of_a_large_campaign_says_how_much_it_leaves_out_and_where_that_stands() -> None:
    findings = small_findings()
    group = findings.groups[1]
    extent = Extent(1000, 250, 40, {"nothing_missing": 240, "unknown": 10}, {key_of(group): (400, 31)})
    failed = tuple(FailedTrial(f"f{i}", "no release", {}) for i in range(ROWS_AT_MOST + 7))
    notes = tuple(f"note {i}" for i in range(ROWS_AT_MOST + 9))
    large = replace(findings, failed=failed, notes=notes)
    with page_style():
        text = Reader()
        text.feed(page(large, page_figures(findings), MANIFEST, extent))
    assert "1000 trials in 250 groups" in text.text
    assert "40 of 1000 trials lie further" in text.text
    assert "Of 250 groups (nothing missing 240, not explained 10) this page shows 2" in text.text
    assert "31 of 400" in text.text
    assert "4 of 400 trials: the smallest and the largest release" in text.text
    assert "And 7 more, in trials.csv" in text.text
    assert f"({ROWS_AT_MOST} notes, 9 more in manifest.json)" in text.text
    assert (f"f{ROWS_AT_MOST - 1}" in text.text, f"f{ROWS_AT_MOST}" in text.text) == (True, False)


def test_a_page_that_shows_everything_speaks_of_no_part() -> None:
    assert "this page shows" not in rendered()
    assert "the figures show these too" not in rendered()
    assert "more, in trials.csv" not in rendered()


def test_published_values_stand_beside_what_is_found() -> None:
    findings = small_findings()
    group = findings.groups[1]
    known = replace(group, specimen=replace(group.specimen, published=(("drag_coefficient", 2.125), ("mu", 0.011))))
    block = blocks.group_block(findings, known, "a", {})
    assert dict(zip(block["columns"], block["published"], strict=True))["drag coefficient"] == "2.125"
    assert blocks.group_block(findings, group, "a", {})["published"] == []
    shown = replace(findings, groups=(findings.groups[0], known))
    with page_style():
        written = page(shown, page_figures(shown), {})
    assert "from the config; nothing was fitted to it" in written
    repaired = repaired_block(named(known))
    assert repaired["published"]
    assert "2.125" in [row["published"] for row in repaired["rows"]]
    assert not repaired_block(named(group))["published"]
