"""Equations, orders and names of a report, and runs side by side."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest

from tests.findings_fixture import MARKUP, bare_findings, make_findings, small_findings
from tests.written import write_tables
from undertow.discrepancy.findings import GroupFindings
from undertow.discrepancy.words import group_title, percent
from undertow.equation import registry
from undertow.equation.equation import Equation
from undertow.errors import ConfigError, UndertowError
from undertow.front.terminal.changes import comparison_text
from undertow.likelihood.fit import Fit, Specimen
from undertow.quantities import Estimate
from undertow.report.arrange import (
    agreement,
    by_amplitude,
    chosen,
    excess,
    group_numbers,
    is_usable,
    spanning_conditions,
)
from undertow.report.compare import _cells, compare_runs, comparison_html
from undertow.report.expressions import (
    LATEX_LINE,
    force_factors,
    is_per_mass,
    method_equation,
    numeric_latex,
    numeric_lines,
)
from undertow.report.html import anchors
from undertow.report.numbers import printed_unit
from undertow.report.wording import estimate_text, parameter_name, problem_of


def wet() -> GroupFindings:
    return small_findings().groups[1]


def coefficient(equation: Equation, name: str) -> float:
    return {t.name: c for t, c in zip(equation.terms, equation.coefficients, strict=True)}[name]


# ---------------------------------------------------------------- equations
def test_a_methods_numbers_take_the_place_of_the_groups_in_its_equation() -> None:
    found = wet().fits["output_error"].parameters
    equation, errors = method_equation(wet(), "output_error")
    assert coefficient(equation, "added_mass") == found["added_mass_kg"].value
    assert coefficient(equation, "quadratic_drag") == pytest.approx(found["drag_coefficient"].value * 485.0)
    assert errors["quadratic_drag"] == pytest.approx(found["drag_coefficient"].total_stderr * 485.0)
    assert coefficient(equation, "stiffness") == coefficient(wet().equation, "stiffness")


def test_a_method_that_chose_its_own_terms_is_written_with_those() -> None:
    equation, errors = method_equation(wet(), "sindy")
    fit = wet().fits["sindy"]
    assert [term.name for term in equation.terms] == list(fit.per_mass)
    total = fit.parameters["total_mass_kg"]
    assert equation.mass_kg == total.value
    assert coefficient(equation, "stiffness") == pytest.approx(fit.per_mass["stiffness"].value * total.value)
    assert errors["mass"] == total.total_stderr


def test_inner_parameters_of_a_chosen_term_are_its_own() -> None:
    per_mass = {"drag_exponent": Estimate(2.0, 0.1), "drag_exponent.exponent": Estimate(1.4, 0.05)}
    group = replace(wet(), fits={"sindy": Fit("sindy", (), per_mass)})
    equation, _ = method_equation(group, "sindy")
    assert equation.terms == (registry.find("drag_exponent", exponent=1.4),)
    assert is_per_mass(equation, {})


def test_a_total_mass_that_is_not_positive_leaves_the_groups_equation() -> None:
    absurd = Fit("method2", (), {}, {"added_mass_kg": Estimate(-1e5)})
    equation, _ = method_equation(replace(wet(), fits={"method2": absurd}), "method2")
    assert equation == wet().equation
    assert method_equation(wet(), "no such method")[0] == wet().equation


def test_friction_and_drag_have_no_force_where_mass_and_area_are_not_known() -> None:
    factors = force_factors(Specimen())
    assert math.isnan(factors["mu"][1])
    assert math.isnan(factors["drag_coefficient"][1])
    mu = Fit("method1", (), {}, {"mu": Estimate(0.01)})
    group = replace(wet(), specimen=Specimen(), fits={"method1": mu})
    assert method_equation(group, "method1")[0] == group.equation


def test_numbers_errors_and_units_stand_in_the_latex_and_per_mass_none() -> None:
    stiffness = (registry.find("stiffness"),)
    with_mass = numeric_latex(Equation(stiffness, (402036.0,), 2637.4), {"stiffness": 300.0})
    assert with_mass == r"2637.4\,\mathrm{kg}\,\ddot{x} + (402000 \pm 300)\,\mathrm{N/m}\,x = 0"
    alone = numeric_latex(Equation((*stiffness, registry.find("coulomb_friction")), (41.6, 0.06)), {})
    assert alone == r"\ddot{x} + 41.6\,x + 0.06\,\mathrm{sgn}(\dot{x}) = 0"


@pytest.mark.parametrize("name", registry.names())
def test_a_broken_equation_is_the_whole_equation(name: str) -> None:
    terms = tuple(registry.find(n) for n in (*(n for n in registry.names()[:5] if n != name), name))
    numbers = (*(-3.0, 2.0, 1.5, 4.0, 5.0)[: len(terms) - 1], -6.0)
    equation = Equation(terms, numbers, 9.0)
    lines = numeric_lines(equation, {})
    motion = numeric_latex(equation, {}).split(r",\quad ")
    count = -(-(len(terms) + 1) // LATEX_LINE)
    assert " ".join(lines[:count]) == motion[0]
    assert lines[count:] == motion[1:]


# ---------------------------------------------------------------- orders
def test_groups_span_a_series_and_the_last_number_that_varies() -> None:
    span = spanning_conditions(make_findings())
    assert (span.series, span.level) == ("spring", "water_depth_m")
    assert span.level_of(wet()) == 2.36
    bare = spanning_conditions(bare_findings())
    assert (bare.series, bare.level) == (None, None)
    assert math.isnan(bare.level_of(wet()))
    assert bare.series_of(wet()) == ""


def test_the_chosen_trials_are_the_ends_and_the_worst_explained() -> None:
    trials = by_amplitude(wet().trials)
    assert [t.motion.amplitude for t in trials] == sorted(t.motion.amplitude for t in trials)
    worse = replace(trials[2], mismatch=replace(trials[2].mismatch, nrmse=9.0))
    assert chosen((trials[1], worse, trials[3], trials[0]), 3) == (trials[0], worse, trials[3])
    assert math.isnan(excess(bare_findings().groups[0].trials[0]))


def test_numbers_of_a_group_come_from_the_most_efficient_method_that_has_any() -> None:
    group = wet()
    assert group_numbers(group) == group.fits["output_error"].parameters
    others = {m: f for m, f in group.fits.items() if m != "output_error"}
    assert group_numbers(replace(group, fits=others)) == group.fits["method1"].parameters
    printed = {"method2_printed": group.fits["method2_printed"]}
    assert group_numbers(replace(group, fits=printed)) == group.verdict.baseline.parameters


def test_agreement_takes_no_estimate_without_an_error_on_a_bound_or_as_printed() -> None:
    found = agreement(wet(), "added_mass_kg")
    assert found is not None
    assert found.methods == 3  # not Method 1, on its bound; not the printed recipe
    assert found.distance == pytest.approx(
        found.difference
        / math.hypot(*(wet().fits[m].parameters["added_mass_kg"].total_stderr for m in found.pair))
    )
    assert agreement(wet(), "k_N_per_m") is None
    assert not is_usable(Estimate(1.0, 0.0))
    assert not is_usable(Estimate(math.inf, 1.0))


# ---------------------------------------------------------------- words
def test_groups_are_called_alike_on_the_page_and_in_sentences() -> None:
    assert wet().label == group_title(wet().key) == "spring short, water depth 2.36 m"
    assert group_title({}) == "all trials"
    assert group_title({"trigger_deg": 90.0, "ship_speed": 15.5}) == "trigger 90 deg, ship speed 15.5"


@pytest.mark.parametrize(("share", "words"), [(1.53, "153 %"), (0.0, "0 %"), (math.nan, "-"), (1e-6, "0.0001 %")])
def test_a_share_is_said_in_two_digits_without_a_power_of_ten(share: float, words: str) -> None:
    assert percent(share) == words


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("natural_frequency_rad_per_s", "natural frequency"),
        ("cubic_stiffness_per_m2_s2", "cubic stiffness"),
        ("sine_restoring_N_per_mass", "sine restoring per mass"),
        ("drag_Ns2_per_m2", "quadratic drag"),
        ("exponent", "exponent"),
    ],
)
def test_a_parameters_unit_is_no_part_of_its_words(name: str, words: str) -> None:
    assert parameter_name(name).words == words


def test_an_estimate_says_when_it_has_no_error_bar_or_no_value() -> None:
    assert estimate_text(Estimate(math.nan, 1.0)) == "not found"
    assert estimate_text(Estimate(4.0, 0.0, unit="kg")) == "4 kg"
    assert estimate_text(Estimate(-3.25, 0.5, unit="N s^2/m^2")) == "-3.2 ± 0.5 N s²/m²"
    assert printed_unit("1/m^2/s^2") == "1/m²/s²"
    assert problem_of(Estimate(1.0)) == "no error bar"
    assert problem_of(Estimate(1.0, 0.1)) == ""


def test_no_anchor_is_given_twice_or_is_one_of_the_pages_own() -> None:
    texts = ["made", "x" * 200, "x" * 300, "Ä", "ö", "<script>", "made"]
    places = anchors(texts)
    assert len(set(places)) == len(texts)
    assert "made" not in places
    assert all("--" not in place and len(place) < 70 for place in places)


# ---------------------------------------------------------------- runs side by side
def test_runs_stand_side_by_side_with_their_errors(tmp_path: Path) -> None:
    for name, seed in (("first", 0), ("second", 1)):
        write_tables(replace(make_findings(seed, cases=()), groups=make_findings(seed).groups[4:]), tmp_path / name)
    table = compare_runs([tmp_path / "first", tmp_path / "second"])
    assert list(table.columns) == ["group", "quantity", "first", "second", "change", "changed"]
    row = table[(table.group == "spring short, water depth 2.36 m") & (table.quantity == "verdict")].iloc[0]
    assert (row["first"], row["second"]) == ("not explained", "not explained")
    mass = table[table.quantity == "added_mass_kg"]
    assert mass["first"].str.contains(" ± 12 kg").all()
    assert "spring short, water depth 2.57 m" in comparison_text([tmp_path / "first", tmp_path / "second"], whole=True)
    with pytest.raises(ConfigError, match=r"^first is a single run; give two, as in undertow compare RUN RUN"):
        compare_runs([tmp_path / "first"])


def compared(tmp_path: Path, *runs: dict[str, Estimate]) -> dict[str, tuple[str, bool]]:
    """``quantity: (change, changed)`` of runs of one group with these parameters."""
    for at, parameters in enumerate(runs):
        found = small_findings()
        one = found.groups[0].verdict
        verdict = replace(one, baseline=replace(one.baseline, parameters=parameters), augmented=None)
        write_tables(replace(found, groups=(replace(found.groups[0], verdict=verdict),)), tmp_path / str(at))
    table = compare_runs([tmp_path / str(at) for at in range(len(runs))])
    return {row.quantity: (row.change, row.changed) for row in table.itertuples()}


def test_a_number_per_mass_is_compared_with_one_of_the_whole_body_by_its_mass(tmp_path: Path) -> None:
    whole = {"total_mass_kg": Estimate(12.0, 0.06, unit="kg"), "c_Ns_per_m": Estimate(25.0, 0.2, unit="N s/m")}
    per_kg = {"c_Ns_per_m_per_mass": Estimate(2.084, 0.01, unit="N s/m per kg")}
    assert compared(tmp_path / "a", whole, per_kg)["c_Ns_per_m"] == ("+0.0 standard errors", False)
    per_kg = {"c_Ns_per_m_per_mass": Estimate(2.4, 0.01, unit="N s/m per kg")}
    assert compared(tmp_path / "b", per_kg, whole)["c_Ns_per_m"] == ("-14.4 standard errors", True)


def test_numbers_in_units_that_do_not_convert_are_never_subtracted(tmp_path: Path) -> None:
    whole, per_kg = {"c": Estimate(25.0, 0.2, unit="N s/m")}, {"c": Estimate(2.0, 0.1, unit="N s/m per kg")}
    assert compared(tmp_path, whole, per_kg)["c"] == ("other unit, not comparable", False)


def test_a_group_that_one_run_lacks_is_empty_there_and_markup_is_shown_as_text(tmp_path: Path) -> None:
    findings = small_findings()
    odd = replace(findings.groups[0].verdict, group={"spring": MARKUP})
    write_tables(findings, tmp_path / "a")
    write_tables(replace(findings, groups=(replace(findings.groups[0], verdict=odd),)), tmp_path / "b")
    table = compare_runs([tmp_path / "a", tmp_path / "b"])
    assert (table[table.group == f"spring {MARKUP}"]["a"] == "").all()
    html = comparison_html([tmp_path / "a", tmp_path / "b"])
    assert "<script" not in html
    assert "&lt;script&gt;" in html


@pytest.mark.parametrize("content", [None, "{", '{"groups": [{"group": 3}]}', json.dumps([1])])
def test_a_folder_without_a_finished_run_is_named_with_the_next_step(tmp_path: Path, content: str | None) -> None:
    if content is not None:
        (tmp_path / "verdict.json").write_text(content)
    with pytest.raises(UndertowError, match=r"verdict.json cannot be read: .*; give a folder that `undertow run` fin"):
        compare_runs([tmp_path])


@pytest.mark.parametrize(
    ("status", "names", "said"),
    [
        ("explained", ["hidden_resonator", "hidden_resonator"], "explained: 2 hidden resonators"),
        ("unknown", ["linear_damping", "unknown"], "not explained: linear damping"),
        ("nothing_missing", [], "nothing missing"),
    ],
)
def test_runs_side_by_side_name_a_verdict_and_its_effects(status, names, said):
    entry = {"status": status, "verdict": names, "baseline": {"nrmse": 0.4, "held_out_nrmse": 0.5}, "augmented": None}
    quantity, cell = next(iter(_cells(entry, {})))
    assert (quantity, cell.text) == ("verdict", said)
