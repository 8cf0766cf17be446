"""Units where an angle is the coordinate: one home (`Specimen.unit`), from the fit to the page."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

import undertow
from tests.findings_fixture import bare_findings
from undertow.equation.equation import Equation
from undertow.equation.registry import find
from undertow.likelihood.fit import Fit, Specimen, Structure
from undertow.likelihood.group import GroupModel, group_model, terms_by_name
from undertow.likelihood.scale import choose_anchor, structural_parameters, to_physical
from undertow.methods.decay import identify_decay
from undertow.quantities import Estimate
from undertow.report.blocks import group_block
from undertow.report.captions import captions
from undertow.report.expressions import numeric_latex
from undertow.report.tables import level_rows

TERMS = ("stiffness", "viscous_damping", "coulomb_friction", "quadratic_drag", "cubic_stiffness")
BODY = {"stiffness": 20.0, "viscous_damping": 0.05, "coulomb_friction": 0.04}


def turning_units(specimen: Specimen, anchored: bool = True) -> dict[str, str]:
    """Units of what is fitted in a group of one rotation, by name."""
    motion = bare_findings(coordinate="rotation").groups[0].trials[0].motion
    model = group_model(terms_by_name(TERMS), [motion], specimen, None, dry=True, anchored=anchored)
    return {c.name: c.unit for c in model.coefficients}


def test_numbers_of_a_rotation_are_fitted_in_moments_and_friction_is_no_share_of_a_weight():
    assert turning_units(Specimen(mass_kg=2.0, area_m2=0.3, rotation=True)) == {
        "k_N_per_m": "N m/rad", "c_Ns_per_m": "N m s/rad", "friction_N": "N m", "cubic_stiffness_N_per_m3": "N m/rad^3",
    }  # fmt: skip
    assert turning_units(Specimen(mass_kg=2.0))["mu"] == "1"


def test_without_an_inertia_they_are_per_unit_of_it():
    units = turning_units(Specimen(rotation=True), anchored=False)
    assert units["k_N_per_m_per_mass"] == "N m/rad per kg m^2"
    assert units["friction_N_per_mass"] == "N m per kg m^2"
    assert units["cubic_stiffness_N_per_m3_per_mass"] == "N m/rad^3 per kg m^2"


@pytest.mark.parametrize(("known", "unit"), [({"mass_kg": 2.0}, "N m s/rad"), ({}, "N m s/rad per kg m^2")])
def test_a_regression_on_a_rotation_has_the_same_units(known, unit):
    body = Specimen(rotation=True, **known)
    anchor = choose_anchor(body, None, dry=True)
    found = to_physical(["stiffness", "viscous_damping"], np.array([10.0, 0.1]), np.eye(2), anchor, body, True)
    assert next(e.unit for name, e in found.items() if name.startswith("c_Ns_per_m")) == unit
    assert not known or found["total_mass_kg"].unit == "kg m^2"
    assert anchor.sentence == ("mass 2 kg m^2 with the dry frequency" if known else anchor.sentence)


def test_an_envelope_of_a_rotation_gives_friction_as_a_moment():
    run = undertow.simulate(BODY, x0=0.3, mass_kg=0.5, rate_hz=200.0, duration_s=8.0)
    (motion,) = undertow.read(run.recorded(noise_m=1e-4, seed=0))
    moment = identify_decay(motion, Specimen(mass_kg=0.5, rotation=True)).parameters["friction_N"]
    assert moment.unit == "N m"
    assert moment.value == pytest.approx(BODY["coulomb_friction"], rel=0.02)  # envelope and equation differ by so much


def test_a_units_suffix_of_a_reason_is_that_of_the_groups_numbers():
    model = GroupModel((), Specimen(rotation=True), np.zeros(1), ())
    assert model.unit("m/s") == "rad/s"
    assert replace(model, anchored=False).unit("kg") == "kg m^2 per kg m^2"


def test_what_dry_trials_of_a_rotation_hold_is_a_moment():
    held = Structure(Estimate(20.0, unit="N/m"), Estimate(0.1, unit="N s/m"), Estimate(0.5))
    found = structural_parameters(held, Specimen(mass_kg=2.0, gravity_m_per_s2=10.0, rotation=True))
    assert {name: (e.value, e.unit) for name, e in found.items()} == {
        "k_N_per_m": (20.0, "N m/rad"), "c_Ns_per_m": (0.1, "N m s/rad"), "friction_N": (10.0, "N m"),
    }  # fmt: skip


def swung(name: str, x0: float, more: dict[str, float], seed: int) -> undertow.Trials:
    """One release of a body that turns, recorded in degrees."""
    run = undertow.simulate({**BODY, **more}, x0=x0, mass_kg=0.5, rate_hz=100.0, duration_s=8.0)
    noise = 1e-4 * np.random.default_rng(seed).standard_normal(run.t.size)
    return undertow.read(np.rad2deg(run.x + noise), t=run.t, units={"displacement": "deg"}, names=[name])


def test_friction_of_the_dry_trials_stands_in_water_as_the_moment_that_it_is():
    dry = undertow.read([one[0] for one in (swung("a", 0.3, {}, 0), swung("b", 0.2, {}, 1))])
    wet = undertow.read([swung("c", 0.3, {"quadratic_drag": 0.2}, 2)[0]])
    found = undertow.fit(wet, [*BODY, "quadratic_drag"], dry=dry, mass_kg=0.5)
    assert found.parameters.loc["friction_N", "unit"] == "N m"
    assert found.estimates["friction_N"].value == pytest.approx(BODY["coulomb_friction"], rel=0.02)
    assert found.estimates["drag_Ns2_per_m2"].value == pytest.approx(0.2, rel=0.05)
    assert found.estimates["drag_Ns2_per_m2"].unit == "N m s^2/rad^2"
    assert r"\mathrm{kg\,m^{2}}" in found.to_latex()
    units = [p["unit"] for one in json.loads(found.to_json())["terms"] for p in one["parameters"].values()]
    assert units == ["N m/rad", "N m s/rad", "N m", "N m s^2/rad^2"]
    assert any(note.startswith("k, c and friction are held as") for note in found.notes)


def test_the_equation_of_a_rotation_is_written_with_moments_and_an_inertia():
    equation = Equation((find("stiffness"), find("stribeck_friction", velocity_m_per_s=0.2)), (20.0, 0.5), 0.5)
    written = numeric_latex(equation, {}, rotation=True)
    assert written.startswith(r"0.5\,\mathrm{kg\,m^{2}}\,\ddot{x} + 20\,\mathrm{N\,m/rad}\,x + 0.5\,\mathrm{N\,m}")
    assert r"0.2\,\mathrm{rad/s}" in written


def weighed_group():
    """The bare campaign as a rotation whose inertia is known, its numbers as a fit has them."""
    findings = bare_findings(coordinate="rotation")
    (group,) = findings.groups
    body = Specimen(mass_kg=0.5, rotation=True)
    k, c = Estimate(9.65, 0.1, unit="N m/rad"), Estimate(-0.015, 0.001, unit="N m s/rad")
    numbers = {"k_N_per_m": k, "c_Ns_per_m": c}
    rival = {name: e.scaled(2.0, e.unit) for name, e in numbers.items()}
    fits = {"output_error": Fit("output_error", ("r1",), {}, numbers), "sindy": Fit("sindy", ("r1",), {}, rival)}
    group = replace(group, specimen=body, equation=replace(group.equation, mass_kg=0.5), fits=fits)
    return replace(findings, groups=(group,)), group


def test_a_groups_section_says_moments_everywhere():
    findings, group = weighed_group()
    block = group_block(findings, group, "g", {})
    assert block["columns"] == ["stiffness (N\u00a0m/rad)", "viscous damping (N\u00a0m\u00a0s/rad)"]
    assert "N m/rad, " in block["agreement"][0]
    assert r"\mathrm{N\,m\,s/rad}" in block["latex"][1]
    assert r"\mathrm{N\,m\,s/rad}" in str(next(level_rows(group))["equation_latex"])


def test_energy_per_inertia_is_no_energy_per_kilogram():
    findings = bare_findings(coordinate="rotation")
    assert "J/(kg m²)" in captions(findings, findings.groups[0])["energy"]
    plain = bare_findings()
    assert "J/kg" in captions(plain, plain.groups[0])["energy"]
