"""The page as a reader meets it: loaded in headless Chromium, from a file, without a network."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from tests.browser import BROWSER, REASON, Page, browser, pages_of
from tests.findings_fixture import MARKUP, small_findings
from tests.unit.test_report_first_screen import named_findings
from undertow.report.html import write_report

pytestmark = pytest.mark.skipif(BROWSER is None, reason=REASON)

TOO_WIDE = """JSON.stringify([...document.querySelectorAll("main *")].filter((e) => {
  const r = e.getBoundingClientRect();
  if (!r.width || r.right <= innerWidth + 1) return false;
  for (let p = e.parentElement; p; p = p.parentElement) {
    if (["auto", "scroll", "hidden"].includes(getComputedStyle(p).overflowX)) return false;
  }
  return true;
}).map((e) => `${e.tagName} ${e.textContent.slice(0, 40)}`).slice(0, 5))"""
"""Elements that stand out to the right of the window and of every box of their own that scrolls."""

LOAD_AT_MOST_S, SLOWED = 1.5, 4.0
"""Processor time of the page's thread for one load, s; how many times longer it may take on a machine that others use
(measured with nothing else: docs/performance_measured.md)."""

PAPER_PX = 688
"""Width of A4 within the page's margins of 14 mm, at 96 pixels an inch."""


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The small campaign's page: a trial's name is a script, one group's water is repaired."""
    return write_report(named_findings(), tmp_path_factory.mktemp("page"), {"config_text": MARKUP})


@pytest.fixture(scope="module")
def tab() -> Iterator[Page]:
    """One browser for all tests of this file."""
    with browser() as page:
        yield page


@pytest.fixture
def page(tab: Page, written: Path) -> Page:
    """The page just loaded, at a desk's size and light."""
    tab.shape(1440, 1000)
    tab.open(written)
    return tab


def explored(page: Page) -> Page:
    """The page with its explorer in view and drawn."""
    page.run('document.getElementById("explore").scrollIntoView()')
    page.until('document.querySelector("#explore-plot .main-svg")')
    return page


def test_the_page_loads_without_a_request_or_an_error_and_a_script_in_a_name_stays_text(page: Page) -> None:
    assert explored(page).troubles() == []
    assert page.run("[...document.scripts].every((s) => !s.textContent.includes('alert('))")
    assert MARKUP in page.run("document.body.textContent")
    names = page.run("[...document.querySelectorAll('#explore-trial option')].map((o) => o.textContent)")
    assert any(MARKUP in name for name in names)
    assert len(names) == sum(len(group.trials) for group in small_findings().groups)


def test_the_page_is_loaded_in_a_second_and_a_half(tab: Page, written: Path) -> None:
    found = []
    for _ in range(3):
        tab.open(written)
        found.append(tab.load_s())
    least = min(found, key=lambda one: one["loaded"])
    assert 0.0 < least["read"] <= least["loaded"]
    assert least["painted"] > 0.0
    assert 0.0 < least["busy"] < LOAD_AT_MOST_S
    assert least["loaded"] < SLOWED * LOAD_AT_MOST_S


@pytest.mark.parametrize("width", [390, 1440])
@pytest.mark.parametrize("dark", [False, True])
def test_sentence_picture_and_grid_stand_above_all_else_and_nothing_is_too_wide(
    tab: Page, written: Path, width: int, dark: bool
) -> None:
    tab.shape(width, 900, dark)
    tab.open(written)
    end = "(e) => document.querySelector(e).getBoundingClientRect().bottom + scrollY"
    ends = [tab.run(f"({end})('{what}')") for what in (".lead", "figure.first svg", "table.grid", "ul.levels")]
    assert ends[0] < 250
    assert max(ends[:3]) < 844  # the first screen of a phone; a desk's is higher
    assert max(ends) < tab.run("document.getElementById('overview').getBoundingClientRect().top + scrollY")
    assert tab.run("document.documentElement.scrollWidth") <= width
    assert json.loads(tab.run(TOO_WIDE)) == []
    paper = tab.run("getComputedStyle(document.querySelector('main')).backgroundColor")
    assert paper == ("rgb(22, 28, 35)" if dark else "rgb(255, 255, 255)")


@pytest.mark.parametrize("dark", [False, True])
def test_on_a_phone_the_whole_page_stays_within_the_screen_and_reads_downwards(
    tab: Page, written: Path, dark: bool
) -> None:
    tab.shape(390, 844, dark)
    tab.open(written)
    explored(tab)
    tab.run("document.querySelectorAll('details').forEach((d) => { d.open = true; })")
    assert json.loads(tab.run(TOO_WIDE)) == []
    assert tab.run("document.documentElement.scrollWidth") <= 390
    lefts = tab.run("[...document.querySelectorAll('ul.levels li')].map((e) => e.getBoundingClientRect().left)")
    assert len(lefts) > 1
    assert max(lefts) == min(lefts)
    heights = tab.run(
        "[...document.querySelectorAll('table.repaired td.n')].filter((e) => e.textContent.includes('±')).map((e) => {"
        " const at = e.firstChild.textContent.indexOf('±'), r = document.createRange();"
        " r.setStart(e.firstChild, 0); r.setEnd(e.firstChild, at + 3); return r.getClientRects().length; })"
    )
    assert heights
    assert set(heights) == {1}  # a value stands in one line with its error


@pytest.mark.parametrize("width", [1080, 1280])
def test_the_table_of_all_groups_needs_no_scrolling_and_a_number_breaks_before_its_error_alone(
    tab: Page, tmp_path: Path, width: int
) -> None:
    findings = named_findings()
    groups = [replace(g, key={"spring": "short and stiff", **g.key, "water_depth_m": d / 100})
              for d in range(150, 258, 18) for g in findings.groups]  # fmt: skip
    many = write_report(replace(findings, groups=tuple(groups)), tmp_path, {})
    tab.shape(width, 900)
    tab.open(many)
    box = "document.querySelector('table.all').parentElement"
    assert tab.run(f"{box}.scrollWidth") <= tab.run(f"{box}.clientWidth")
    numbers = tab.run("[...document.querySelectorAll('table.all td.n')].map((e) => e.textContent)")
    assert any("±\u00a0" in number for number in numbers)
    assert not any("± " in number or "→ " in number for number in numbers)


def test_beside_the_picture_of_few_groups_stand_their_sentences_and_no_empty_half(tab: Page, written: Path) -> None:
    tab.shape(1280, 900)
    tab.open(written)
    box = "(e) => document.querySelector(e).getBoundingClientRect()"
    picture, said, last = (tab.run(f"(({box})('{one}')).toJSON()") for one in
                           ("figure.first svg", "ul.levels", "p.caption"))  # fmt: skip
    assert said["left"] > picture["right"]
    assert said["top"] < picture["bottom"]
    assert max(said["bottom"], last["bottom"]) > picture["bottom"] - 0.2 * picture["height"]


def test_the_button_changes_the_theme_of_page_and_figures(page: Page) -> None:
    ink = "getComputedStyle(document.querySelector('figure.first svg text')).fill"
    before = page.run(ink)
    page.run("document.getElementById('theme').click()")
    assert page.run("document.documentElement.dataset.theme") == "dark"
    assert page.run(ink) != before
    page.run("document.getElementById('theme').click()")
    assert page.run(ink) == before


def test_the_explorer_zooms_turns_curves_and_channels_off_and_on_and_follows_a_link(page: Page) -> None:
    explored(page)
    plot = "document.getElementById('explore-plot')"
    before = page.run(f"{plot}.layout.xaxis.range")
    corner = page.run(f"(({{left, top}}) => [left, top])({plot}.querySelector('.nsewdrag').getBoundingClientRect())")
    for kind, x in (("mousePressed", 100), ("mouseMoved", 260), ("mouseReleased", 260)):
        place = {"x": corner[0] + x, "y": corner[1] + (20 if x == 100 else 90)}
        page.send("Input.dispatchMouseEvent", type=kind, button="left", buttons=1, clickCount=1, **place)
    after = page.run(f"{plot}.layout.xaxis.range")
    assert before[0] < after[0] < after[1] < before[1]
    page.run("document.querySelector('#explore-curves input[value=after]').click()")
    assert [t for t in page.run(f"{plot}.data.map((t) => [t.name, t.visible])") if t[0] == "with what was found"] == [
        ["with what was found", False]
    ] * 2
    assert page.run(f"{plot}.layout.xaxis.range") == after  # a curve less is no reason to lose one's place
    page.run("document.querySelector('#explore-channels input[value=residual]').click()")
    assert set(page.run(f"{plot}.data.map((t) => t.yaxis)")) == {"y"}
    page.run("document.querySelector('a[data-trial=\"2\"]').click()")
    page.until("document.getElementById('explore-trial').value === '2'")


def test_a_table_sorts_by_number_up_and_down(page: Page) -> None:
    table = "document.querySelectorAll('details table.sortable')[0]"
    column, heading = f"[...{table}.rows].slice(1).map((r) => r.cells[1].textContent)", f"{table}.rows[0].cells[1]"
    page.run("document.querySelectorAll('details').forEach((d) => { d.open = true; })")
    for order in ("ascending", "descending"):
        page.run(f"{heading}.querySelector('button').click()")
        values = [float(text) for text in page.run(column)]
        assert values == sorted(values, reverse=order == "descending")
        assert page.run(f"{heading}.getAttribute('aria-sort')") == order
    assert len(values) > 2


def test_on_paper_nothing_is_cut_and_a_group_takes_less_than_two_sheets(page: Page) -> None:
    page.shape(PAPER_PX, 1000, media="print")
    assert json.loads(page.run(TOO_WIDE)) == []
    assert page.run("[...document.querySelectorAll('.wide')].every((e) => e.scrollWidth <= e.clientWidth + 1)")
    assert page.run("getComputedStyle(document.querySelector('h2')).breakAfter") == "avoid"
    assert page.run("getComputedStyle(document.querySelector('figure')).breakInside") == "avoid"
    assert pages_of(page.pdf()) <= 6


def test_a_page_without_a_repair_says_what_the_equation_leaves(tab: Page, tmp_path: Path) -> None:
    plain = replace(small_findings(), groups=small_findings().groups[:1])
    tab.shape(390, 844)
    tab.open(write_report(plain, tmp_path, {}))
    assert explored(tab).troubles() == []
    curves = tab.run("[...document.querySelectorAll('#explore-curves input')].map((i) => i.value)")
    assert curves == ["measured", "before"]
    assert tab.run("document.documentElement.scrollWidth") <= 390
