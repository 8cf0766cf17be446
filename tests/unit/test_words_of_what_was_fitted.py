"""Sentences say what was fitted, people's names as they are written, and negative numbers with a minus."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.findings_fixture import bare_findings, small_findings
from undertow.campaign.run.analysis import _rests_on
from undertow.campaign.run.gathered import across
from undertow.discrepancy.alone import Alone
from undertow.discrepancy.verdict import Gate, Rejected
from undertow.discrepancy.words import spelled, with_names
from undertow.equation.registry import catalogue
from undertow.front.terminal.verdicts import missing_words
from undertow.likelihood.fit import Specimen
from undertow.likelihood.group import GroupModel, terms_by_name
from undertow.quantities import Estimate
from undertow.report.behind import gate_rows
from undertow.report.captions import scattering_words
from undertow.report.explain import _explained
from undertow.report.html import page, page_figures
from undertow.report.style import new_figure, svg_text
from undertow.report.wording import reason_words, rejected_words
from undertow.report.writing import true_minus

WEIGHED = Specimen(mass_kg=4.0)


@pytest.mark.parametrize(
    ("terms", "specimen", "anchored", "own"),
    [
        (("stiffness", "viscous_damping"), WEIGHED, True, ("k", "c")),
        (("stiffness", "coulomb_friction"), WEIGHED, True, ("k", "mu")),
        (("stiffness", "coulomb_friction"), WEIGHED, False, ("k", "friction")),
        (("coulomb_friction",), Specimen(), True, ("friction",)),
        (("stiffness", "coulomb_friction"), replace(WEIGHED, rotation=True), True, ("k", "friction")),
        (("cubic_stiffness",), WEIGHED, True, ()),
    ],
)
def test_what_may_be_each_trials_own_is_what_the_equation_has(terms, specimen, anchored, own):
    assert GroupModel(terms_by_name(terms), specimen, np.zeros(1), (), anchored=anchored).scattering == own


def test_a_page_speaks_of_friction_only_where_an_equation_has_it():
    assert scattering_words(bare_findings()) == "k and c"
    assert scattering_words(small_findings()) == "k, c and μ"
    findings = bare_findings()
    text = page(findings, page_figures(findings), {})
    assert text.count("if only k and c varied from trial to trial") == 2


def test_a_trial_alone_is_followed_with_the_numbers_that_it_has():
    assert Alone("r4", 0.06, 400.0, own="k and c").words.startswith("k and c of its own leave 6.0 %")


def test_people_have_a_capital_in_every_text():
    assert all(with_names(spelled(law.name)) == spelled(law.name) for law in catalogue())
    assert spelled("stribeck_friction") == "Stribeck friction"
    assert reason_words("stribeck_friction is 2.1 standard errors from zero").startswith("Stribeck friction is")
    assert reason_words("most like stribeck friction") == "most like Stribeck friction"
    assert rejected_words("stribeck_friction", "stribeck_friction.velocity_m_per_s = 2 m/s could") == (
        "velocity = 2 m/s could"
    )
    assert missing_words({"verdict": ["coulomb_friction"], "alternatives": [["bouc_wen"]]}) == (
        "Coulomb friction or Bouc-Wen"
    )
    assert across({"Stribeck friction": 1}, {"explained": 1}) == "The equation leaves out: Stribeck friction."
    (row,) = gate_rows(replace(small_findings().groups[0].verdict, decision=(
        Gate("evidence", "log odds of coulomb_friction over nothing", 1.0, 4.6, False),
    )))  # fmt: skip
    assert row["statistic"] == "log odds of Coulomb friction over nothing"


def test_numbers_below_zero_have_a_minus_on_the_page_and_equations_stay_to_be_copied():
    findings = bare_findings()
    (group,) = findings.groups
    rejected = (Rejected("cubic_damping", "cubic_damping.Ns3_per_m3 = -3.1 +- 0.2 N s^3/m^3 would feed"),)
    equation = replace(group.equation, coefficients=(19.3, -0.03))
    numbers = {"k_N_per_m_per_mass": Estimate(19.3, 0.1), "c_Ns_per_m_per_mass": Estimate(-0.03, 0.001)}
    fit = replace(group.fits["output_error"], parameters=numbers)
    verdict = replace(group.verdict, rejected=rejected)
    changed = replace(group, verdict=verdict, equation=equation, fits={"output_error": fit})
    findings = replace(findings, groups=(changed,))
    text = page(findings, page_figures(findings), {})
    assert "cubic damping = −3.1 ± 0.2 N s³/m³ would feed" in text
    assert "−0.0300 ± 0.0010" in text
    assert "x'' + 19.3 x - 0.03 v = 0" in text.replace("&#39;", "'")


def test_a_figures_letters_have_a_minus_and_its_coordinates_stay():
    figure = new_figure(2.0, 2.0)
    figure.text(0.5, 0.5, "a slope of -0.5")
    svg = svg_text(figure)
    assert "a slope of \N{MINUS SIGN}0.5" in svg
    assert svg.count("\N{MINUS SIGN}") == 1


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("-1", "−1"), ("(-1.2 to -3e-05)", "(−1.2 to −3e-05)"), ("run-2 of 2024-01-02", "run-2 of 2024-01-02"),
        ("10^-6, m^-2, e-5", "10^-6, m^-2, e-5"), ("/tmp/-1/x -5deg.csv -5.csv", "/tmp/-1/x -5deg.csv -5.csv"),
        ("x - 6", "x - 6"), ("± -2", "± −2"),
    ],
)  # fmt: skip
def test_only_the_sign_of_a_number_becomes_a_minus(text, said):
    assert true_minus(text) == said


def test_explain_prints_a_minus():
    gate = {"gate": "comes_closer", "statistic": "free run further away", "value": -0.469, "limit": 1.0, "passed": True}
    one = {
        "group": {}, "status": "unknown", "verdict": ["unknown"], "alternatives": [], "detectable": [], "rejected": [],
        "decision": [{**gate, "because": ""}],
    }  # fmt: skip
    assert "  \N{MINUS SIGN}0.469  at most 1" in _explained("all trials", one)


@pytest.mark.parametrize(
    ("terms", "said"),
    [
        (("stiffness", "viscous_damping"), "scatter; assumed for repeatability: 0.4 % in k, 20 % in c"),
        (("cubic_stiffness",), "say how trials scatter"),
    ],
)
def test_a_scatter_is_assumed_of_what_the_equation_has(terms, said):
    task = SimpleNamespace(anchor=SimpleNamespace(doubts=(), kind="none"), structure=None, scatter={}, apart=())
    (note,) = _rests_on(task, GroupModel(terms_by_name(terms), WEIGHED, np.zeros(1), ()))
    assert note.endswith(said)
