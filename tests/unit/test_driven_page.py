"""The page of driven bodies and harmonic sets: in the style of the page of decays, and nothing that no run computed."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from tests.browser import BROWSER, REASON, Page, browser
from tests.findings_fixture import MARKUP
from tests.unit.test_page_in_a_browser import TOO_WIDE
from undertow.campaign.driven.beside import (
    ByInstruments,
    Regressed,
    beside_output_error,
    strokes_sentence,
    strokes_table,
)
from undertow.campaign.driven.page import outcome_words, sure_words, tried_rows
from undertow.campaign.driven.run import found_words
from undertow.comparison.driven_folds import Tried
from undertow.discrepancy.findings import FailedTrial
from undertow.discrepancy.verdict import Described, Verdict
from undertow.equation.driven_laws import find_driven
from undertow.likelihood.driven_strokes import Strokes
from undertow.quantities import Estimate
from undertow.report.driven_figures import DrawnCurve, DrawnSet, draw_held_back, draw_set, draw_whole
from undertow.report.driven_page import (
    IN_TIME,
    Made,
    PagePart,
    PageTable,
    Picture,
    WrittenEquation,
    page_html,
    table_block,
)
from undertow.report.expressions import numeric_latex, numeric_lines
from undertow.report.style import GREEN, INK, PRESCRIBED, new_figure, page_style, svg_text
from undertow.report.trial_figures import Runs, drawn_as
from undertow.report.writing import write_text

T = np.linspace(0.0, 20.0, 2000)
SHOWN = drawn_as("displacement", "translation")
HYSTERESES = ("bouc_wen", "pinched", "lugre", "iwan")


def runs(offset: float = 0.0) -> Runs:
    """A motion of 0.1 m with free runs that miss 0.02 and 0.001 m of it."""
    x = offset + 0.1 * np.sin(6.0 * T)
    return Runs(T, x, x + 0.02 * np.cos(6.0 * T), x + 0.001, SHOWN, 0.002, "time (s)")


def driven(*laws: str) -> WrittenEquation:
    """A body of 4 kg with these laws, every number 1.5 +- 0.1 of its unit."""
    terms = [find_driven(name) for name in laws]
    numbers = {f"{t.name}.{p.name}": Estimate(1.5, 0.1, unit=p.unit) for t in terms for p in t.parameters}
    return WrittenEquation(terms, {"mass_kg": Estimate(4.0, 0.1, unit="kg"), **numbers})


def part(status: str = "explained", **change: object) -> PagePart:
    """One group with a name that is a script in every text that comes from outside."""
    before, after = Described(0.3, 0.31), Described(0.01, 0.012)
    verdict = Verdict({}, (MARKUP,), status=status, verdict=("cubic_stiffness",), baseline=before, augmented=after)  # type: ignore[arg-type]
    with page_style():
        first, whole = (svg_text(f) for f in (draw_held_back(runs(), new_figure(5.6, 3.9)),
                                              draw_whole(runs(), 16.0, new_figure(11.0, 3.8))))  # fmt: skip
    one = PagePart(
        verdict, f"Found in {MARKUP}.", "no probability.", driven("stiffness", "viscous_damping"),
        driven("stiffness", "viscous_damping", "cubic_stiffness", "bouc_wen"), [("31 %", "before", "alarm")],
        Picture(first, MARKUP), [Picture(whole, MARKUP)],
        [PageTable("Tried", [("law", "rms (mm)", "why"), (MARKUP, "−1.5", "an outcome in words " * 6)], MARKUP, False)],
        doubts=[f"Look at {MARKUP}"], notes=[MARKUP],
    )  # fmt: skip
    return replace(one, **change)  # type: ignore[arg-type]


def page_of(*parts: PagePart) -> str:
    """The page of these groups."""
    made = Made({"undertow": "0.1.0", "packages": {}}, MARKUP, (FailedTrial("lost", MARKUP),))
    return page_html(MARKUP, "1 trial of a driven body", parts, made)


def test_every_text_from_outside_stays_a_text():
    assert "<script>alert" not in page_of(part())
    assert MARKUP not in page_of(part())


def test_the_first_screen_has_a_tag_of_the_verdicts_colour_and_says_how_sure_it_is():
    for status, tone in (("explained", "found"), ("nothing_missing", "good"), ("unknown", "open")):
        named = () if status == "nothing_missing" else ("cubic_stiffness", *(("unknown",) if tone == "open" else ()))
        one = part()
        assert one.verdict is not None
        verdict = replace(one.verdict, status=status, verdict=named)  # type: ignore[arg-type]
        first = page_of(replace(one, verdict=verdict)).partition('<section id="first"')[2].partition("</section>")[0]
        assert f'<p class="lead"><span class="tag {tone}">' in first
        assert f'<li class="{tone}"><b>How sure</b>: no probability.</li>' in first


def test_several_groups_are_counted_and_each_has_its_box_and_section():
    one, other = part(), part(status="nothing_missing")
    assert one.verdict is not None
    assert other.verdict is not None
    parts = [replace(p, verdict=replace(p.verdict, group={"water": w}))
             for p, w in ((one, "wet"), (other, "dry")) if p.verdict]  # fmt: skip
    page = page_of(*parts)
    assert "2 groups: 1 explained, 1 nothing missing." in page
    assert page.count('<a class="cell ') == 2
    assert page.count('<section id="water-') == 2


@pytest.mark.parametrize("law", [*HYSTERESES, "relaxation", "hidden_resonator", "asymmetric_damping", "froude_krylov"])
def test_every_law_of_a_driven_body_is_typeset_with_its_numbers(law):
    one = driven("stiffness", law)
    written = numeric_latex(one.equation, one.errors, one.drive)
    assert f" = {IN_TIME['force']}" in written
    assert "+ -" not in written
    page = page_of(part(repaired=one))
    assert page.count('<figure class="equation">') == 2
    for symbol in (r"\alpha", r"\sigma_0", r"\sigma_1", "F_s", "P", "W"):
        assert symbol not in written.replace("Pe", ""), written


def test_a_hysteresis_whose_exponent_is_held_at_one_has_no_power():
    one = driven("bouc_wen")
    numbers = {**one.numbers, "bouc_wen.exponent": Estimate(1.0, 0.0), "bouc_wen.unit_N": Estimate(1.0, 0.0, unit="N")}
    held = replace(one, numbers=numbers)
    assert "^{" in numeric_latex(one.equation, one.errors).partition(r"\dot z")[2].replace("m^{-1}", "")
    assert "^{" not in numeric_latex(held.equation, held.errors).partition(r"\dot z")[2].replace("m^{-1}", "")


@pytest.mark.parametrize("law", [*HYSTERESES, "relaxation", "hidden_resonator", "asymmetric_damping", "froude_krylov"])
def test_every_number_of_a_driven_law_stands_in_its_text_and_in_its_latex(law):
    term = find_driven(law)
    sizes = {p.name: 1.5 + 0.0625 * at for at, p in enumerate(term.parameters)}
    numbers = {f"{law}.{name}": Estimate(value, 1e-4) for name, value in sizes.items()}
    one = replace(driven(law), numbers={"mass_kg": Estimate(4.0, 0.1, unit="kg"), **numbers})
    for written in (one.equation.text(one.errors), numeric_latex(one.equation, one.errors)):
        assert [value for value in sizes.values() if f"{value:.5g}" not in written] == [], written


def test_iwans_sliders_are_written_out_and_each_of_their_equations_has_a_line():
    one = driven("stiffness", "iwan")
    one = replace(one, numbers={**one.numbers, "iwan.chi": Estimate(0.0, 0.0)})
    assert "sum of s_1 to s_10 = 0; s_i' = 1.50 a_i v up to |s_i| = 1.50 b_i, a_i = (i/10)^(1) - " in (
        one.equation.text(one.errors)
    )
    lines = numeric_lines(one.equation, one.errors, 2, one.drive)
    assert [line.partition("=")[0] for line in lines[2:]] == [r"\dot s_i", "a_i", "b_i"]
    assert lines[3] == "a_i=(i/10)^{1}-((i-1)/10)^{1}"


def test_an_angles_numbers_have_the_units_of_a_rotation():
    rows = page_of(part(rotation=True)).partition("<th>parameter</th>")[2].partition("</table>")[0]
    assert "N m/rad" in rows
    assert "N/m<" not in rows


def test_tables_beside_an_angles_numbers_have_the_units_of_a_rotation():
    name, number = "viscous_damping.c_Ns_per_m", Estimate(3.0, 0.1, unit="N s/m")
    compared = SimpleNamespace(trial="a", output_error={name: number}, instrument={name: number}, apart={name: 0.0})
    given = SimpleNamespace(estimates={name: number})
    found = Regressed("a", {name: number}, 0.1, "ok")
    moving = Strokes(2e-6, 0.1, {"a": np.array([[0.1, 0.2]])}, {}, 0.0, 1.0)
    for coordinate, unit in (("translation", "N s/m"), ("rotation", "N m s/rad")):
        rows = [ByInstruments((compared,)).table(coordinate)[1], beside_output_error([found], given, coordinate)[1]]  # type: ignore[arg-type]
        assert [row[2:4] for row in rows] == [(f"3.00 ± 0.10 {unit}",) * 2] * 2
    assert strokes_table(moving, "rotation")[0][2] == "offset beyond its mean (N m)"
    assert "differs by 2 × 10⁻⁶ N m and the friction by 0.1 N m" in strokes_sentence(moving, "rotation")


def test_an_equation_that_runs_far_away_is_said_without_a_power_of_ten():
    trial = SimpleNamespace(main="displacement", outputs={"displacement": np.array([-1.0, 1.0])})
    found = SimpleNamespace(validation=(12.3, 12.3), added=(), tried=(1,))
    assert "misses 1230 % of the motion it never saw" in found_words([trial], found)  # type: ignore[list-item, arg-type]


def test_columns_of_numbers_stand_at_the_right_and_what_stands_for_a_number_with_them():
    rows = [("law", "error", "unit"), ("drag", "−1.5 %", "N"), ("spring", "not known", "N/m"), ("mass", "open", "kg")]
    assert [column["number"] for column in table_block(PageTable("t", rows))["columns"]] == [False, True, False]


def test_a_carriages_axis_begins_at_its_smallest_value_and_a_bodys_is_about_zero():
    with page_style():
        low, high = draw_held_back(runs(), new_figure(5.6, 3.9)).axes[0].get_ylim()
        assert low == pytest.approx(-high)
        low, high = draw_held_back(runs(offset=0.1), new_figure(5.6, 3.9)).axes[0].get_ylim()
    assert -0.2 * high < low < 0.0


def test_a_whole_record_has_the_colours_of_all_pages_and_what_was_held_back_is_grey():
    with page_style():
        upper, lower = draw_whole(runs(), 16.0, new_figure(11.0, 3.8)).axes
    assert [line.get_color() for line in upper.lines] == [INK, PRESCRIBED, GREEN]
    assert [line.get_label() for line in upper.lines] == ["measured", "equation as prescribed", "equation repaired"]
    assert [len(axes.patches) for axes in (upper, lower)] == [1, 2]  # below also what repeatability allows
    assert upper.patches[0].get_x() == 16.0  # type: ignore[attr-defined]


def test_points_are_triangles_hollow_where_held_back_and_the_way_down_is_dashed_where_both_are_there():
    hertz = np.linspace(0.5, 1.5, 10)
    ones, up = np.full(10, 0.01), np.arange(10) < 5
    curves = [DrawnCurve(repaired, way, hertz, ones, ones) for repaired in (False, True) for way in (True, False)]
    apart, left_over = np.arange(10) % 5 == 2, (ones, 0.1 * ones)
    both = DrawnSet("set", SHOWN, hertz, ones, -90.0 * np.ones(10), up, apart, curves, left_over)
    down = replace(both, rising=np.zeros(10, bool), curves=curves[1::2])
    with page_style():
        above, phase, left = draw_set(both, new_figure(11.0, 5.2)).axes
        alone = draw_set(down, new_figure(5.6, 3.9), phases=False).axes
    assert [(line.get_color(), line.get_linestyle()) for line in above.lines[:4]] == [
        (PRESCRIBED, "-"), (PRESCRIBED, "--"), (GREEN, "-"), (GREEN, "--")
    ]  # fmt: skip
    assert [(line.get_marker(), line.get_markerfacecolor()) for line in above.lines[4:]] == [
        ("^", INK), ("^", "none"), ("v", INK), ("v", "none")
    ]  # fmt: skip
    assert [line.get_color() for line in left.lines] == [PRESCRIBED, GREEN]
    assert (above.get_ylabel(), phase.get_ylabel()) == ("amplitude\n(mm)", "phase (°)")
    assert left.get_xlabel() == "frequency (Hz)"
    assert len(alone) == 2
    assert [line.get_linestyle() for line in alone[0].lines[:2]] == ["-", "-"]


def test_a_table_of_what_was_tried_has_units_and_says_a_number_once():
    tried = [Tried("quadratic_drag", math.nan, 0.004, math.inf, "unseen points come no closer: 4 after 4")]
    head, row = tried_rows(tried, 1e3, "mm")
    assert head == ("law", "without it (mm)", "with it (mm)", "outcome")
    assert row == ("quadratic drag", "4.00", "-", "unseen points come no closer")
    assert outcome_words(replace(tried[0], because="")) == "added"


def test_a_run_that_tried_nothing_claims_nothing():
    found = SimpleNamespace(tried=(), added=())
    assert sure_words([], found, False, "samples").endswith("No law was tried, so that nothing is claimed.")  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def tab() -> Iterator[Page]:
    """One browser for all tests of this file."""
    with browser() as page:
        yield page


@pytest.mark.skipif(BROWSER is None, reason=REASON)
@pytest.mark.parametrize("width", [390, 1440])
@pytest.mark.parametrize("dark", [False, True])
def test_nothing_is_too_wide_and_the_page_follows_the_theme(tab: Page, tmp_path: Path, width: int, dark: bool) -> None:
    tab.shape(width, 900, dark)
    tab.open(write_text(tmp_path / "report.html", page_of(part())))
    assert tab.troubles() == []
    tab.run("document.querySelectorAll('details').forEach((d) => { d.open = true; })")
    assert tab.run("document.documentElement.scrollWidth") <= width
    assert json.loads(tab.run(TOO_WIDE)) == []
    style = "getComputedStyle(document.querySelector('{}')).{}"
    assert tab.run(style.format("main", "backgroundColor")) == ("rgb(22, 28, 35)" if dark else "rgb(255, 255, 255)")
    tag = ".lead .tag"
    assert tab.run(style.format(tag, "color")) == "rgb(255, 255, 255)"
    assert tab.run(style.format(tag, "color")) != tab.run(style.format(tag, "backgroundColor"))
    ink = tab.run(style.format("figure.first svg text", "fill"))
    tab.run("document.getElementById('theme').click()")
    assert tab.run(style.format("figure.first svg text", "fill")) != ink
    tab.run("localStorage.clear()")
