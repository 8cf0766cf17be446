"""What goes into a group's errors besides noise: dry means, trial-to-trial scatter, areas, volumes, load cells."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import undertow
from experiments.coverage.campaigns import make_campaign
from experiments.coverage.study import TERMS
from experiments.eq15_campaign import tables
from undertow.campaign.run.analysis import theta_of
from undertow.conditioning.condition import condition
from undertow.equation.equation import Equation
from undertow.equation.kernel import SLOT
from undertow.equation.registry import find
from undertow.errors import IdentificationError
from undertow.likelihood.fit import Fit, Specimen
from undertow.likelihood.priors import GAIN_STD
from undertow.likelihood.problem import TrialOptions
from undertow.likelihood.scale import choose_anchor, to_physical, trial_stiffness
from undertow.methods import baseline
from undertow.methods.baseline import fit_group, group_model, terms_by_name
from undertow.methods.dry import (
    DEFAULT_SCATTER,
    Scatter,
    dry_fits,
    pooled_scatter,
    structural_terms,
    structure_from,
    uneven,
)
from undertow.quantities import Estimate

OPTIONS = TrialOptions(rest_offset_std=1e-3)


@cache
def trials():
    campaign = make_campaign("practice", 3, 11)
    dry, wet = ([condition(r) for r in group] for group in (campaign.dry, campaign.wet))
    fits = dry_fits(dry, structural_terms(TERMS), Specimen(tables.STRUCTURE_MASS_KG), TrialOptions())
    return campaign.truth, fits, wet


def fitted(scattering, structure_change=None, **specimen):
    return group_fit(scattering, structure_change, **specimen).estimates


def group_fit(scattering, structure_change=None, **specimen):
    truth, fits, wet = trials()
    structure = structure_from(fits, pooled_scatter([fits]))
    if structure_change is not None:
        structure = structure_change(structure)
    water = Specimen(
        tables.STRUCTURE_MASS_KG, area_m2=tables.REFERENCE_AREA_M2,
        submerged_volume_m3=tables.submerged_volume(truth.water_depth_m), **specimen,
    )  # fmt: skip
    model = group_model(TERMS, wet, water, structure, dry=False, anchored=True)
    return fit_group(model, wet, OPTIONS, scattering)


def certain(structure):
    """The same structure, known exactly and the same in every trial."""
    return replace(
        structure, scatter={"k": 0.0, "c": 0.0, "mu": 0.0}, scatter_freedom=math.inf,
        **{s: Estimate(getattr(structure, s).value, 0.0) for s in ("k", "c", "mu")},
    )  # fmt: skip


def damped(fit, factor):
    """A dry trial's fit with so many times its damping and friction."""
    model = replace(fit.model, base=fit.model.base.copy())
    for slot in ("c1", "fc"):
        model.base[SLOT[slot]] *= factor
    more = {name: e.scaled(factor, e.unit) if name in ("c_Ns_per_m", "mu") else e for name, e in fit.estimates.items()}
    return replace(fit, model=model, estimates=more)


def test_a_dry_trial_with_a_hand_on_the_line_is_named_and_scatter_is_not():
    _, fits, _ = trials()
    first, *others = fits
    assert uneven(fits) == ""
    assert uneven({**fits, first: damped(fits[first], 2.0)}) == ""
    said = uneven({**fits, first: damped(fits[first], 8.0)})
    assert said.startswith(f"the dry trials are uneven: {first} is damped ")
    assert said.endswith("times as much as the other 2, and their scatter says nothing of the rig")
    assert uneven({first: damped(fits[first], 8.0), others[0]: fits[others[0]]}) == ""  # of two nobody knows which


@pytest.mark.parametrize("scattering", ["none", "trials", "trials and means"])
def test_a_structure_from_three_dry_trials_widens_what_is_found_in_water(scattering):
    known = fitted("none", certain)
    for name in ("added_mass_kg", "drag_coefficient"):
        found = fitted(scattering)[name]
        assert found.total_stderr > 1.5 * known[name].total_stderr
        assert found.systematic > 0.0
        assert known[name].systematic == 0.0


def test_slopes_that_overflow_give_no_error_bar_and_no_warning():
    found = group_fit("none")
    steep = replace(found.solution, jacobians=tuple(np.full_like(rows, 1e308) for rows in found.solution.jacobians))
    values, halves, _ = baseline._with_structure(found.model, found.model.fixed, steep)
    assert np.all(np.isfinite(values))
    assert not np.any(np.isfinite(halves))


def test_an_area_that_is_not_known_well_is_a_drag_coefficient_that_is_not():
    sure, unsure = fitted("none"), fitted("none", area_error_m2=0.1 * tables.REFERENCE_AREA_M2)
    drag = unsure["drag_coefficient"]
    assert drag.value == sure["drag_coefficient"].value
    assert drag.systematic == pytest.approx(math.hypot(sure["drag_coefficient"].systematic, 0.1 * drag.value))
    assert unsure["added_mass_kg"] == sure["added_mass_kg"]


@pytest.mark.parametrize(("scattering", "grown"), [("none", 1.2), ("trials and means", 1.01)])
def test_a_volume_that_is_not_known_well_moves_the_friction_and_with_it_the_drag(scattering, grown):
    """Least where every trial finds its own friction, which the trials then show as well as the volume does."""
    sure, unsure = fitted(scattering), fitted(scattering, volume_error_m3=0.5)
    assert unsure["drag_coefficient"].systematic > grown * sure["drag_coefficient"].systematic


def test_a_force_of_gravity_s_error_is_the_volume_s():
    specimen = Specimen(2637.4, volume_error_m3=0.01)
    assert specimen.normal_force_error_N == pytest.approx(0.01 * 1000.0 * 9.81)


def test_load_cells_alone_know_k_as_well_as_their_gain():
    anchor = choose_anchor(Specimen(), None, Estimate(1000.0, 1.0, unit="N/m"))
    assert anchor.stiffness.systematic == pytest.approx(1000.0 * GAIN_STD)
    assert anchor.stiffness.total_stderr == pytest.approx(math.hypot(1.0, 5.0))


@pytest.mark.parametrize("slope", [-1000.0, 0.0, math.nan])
def test_load_cells_whose_force_does_not_rise_with_the_displacement_give_no_kilograms(slope):
    anchor = choose_anchor(Specimen(), None, Estimate(slope, 1.0, unit="N/m"))
    assert (anchor.kind, anchor.known) == ("none", False)


@pytest.mark.parametrize(
    ("cells", "said"),
    [(1020.0, ("stiffness from config is 1000 N/m but from load cells 1020 N/m (+2.0 %)",)), (1009.0, ()), (991.0, ())],
)
def test_a_stiffness_that_load_cells_contradict_by_over_one_per_cent_is_said(cells, said):
    anchor = choose_anchor(Specimen(stiffness_N_per_m=1000.0), None, Estimate(cells, 1.0, unit="N/m"))
    assert anchor.doubts == said
    assert anchor.stiffness.value == 1000.0


def test_a_trials_stiffness_follows_its_load_cells_as_far_as_they_can_be_trusted():
    k, ratio = Estimate(1000.0, 2.0, unit="N/m"), Estimate(0.98, 0.003)
    slopes = {"stiffer": Estimate(0.98 * 1010.0, 0.1, unit="N/m"), "mean": Estimate(980.0, 0.1, unit="N/m")}
    found = trial_stiffness(k, slopes, ratio, 0.004)
    trust = 0.004**2 / (0.004**2 + 0.003**2)
    assert found["stiffer"].value == pytest.approx(1000.0 * (1.0 + 0.01 * trust))
    assert found["mean"].value == pytest.approx(1000.0)
    assert found["mean"].stderr == pytest.approx(1000.0 * 0.004 * math.sqrt(1.0 - trust))
    assert found["mean"].systematic == pytest.approx(2.0)
    assert trial_stiffness(k, slopes, ratio, 0.0)["stiffer"].value == 1000.0  # springs that do not scatter


def test_coefficients_over_mass_become_kilograms_with_the_anchors_error():
    anchor = choose_anchor(Specimen(mass_kg=3.0, stiffness_N_per_m=1000.0), None)
    anchor = replace(anchor, stiffness=Estimate(1000.0, 0.0, 20.0, unit="N/m"))
    spread = np.diag([0.5, 0.01]) ** 2
    found = to_physical(
        ["stiffness", "viscous_damping"], np.array([250.0, 0.3]), spread, anchor, Specimen(mass_kg=3.0), dry=False
    )
    assert found["c_Ns_per_m"].value == pytest.approx(1.2)
    assert found["c_Ns_per_m"].systematic == pytest.approx(0.02 * 1.2)
    assert found["c_Ns_per_m"].stderr == pytest.approx(math.hypot(4.0 * 0.01, 1.2 * 0.5 / 250.0))
    assert found["added_mass_kg"].value == pytest.approx(1.0)
    assert found["added_mass_kg"].stderr == pytest.approx(4.0 * 0.5 / 250.0)
    assert found["added_mass_kg"].systematic == pytest.approx(0.08)


def test_in_water_a_weighed_body_beside_dry_trials_has_the_dry_stiffness_over_the_frequency_for_its_mass():
    _, fits, _ = trials()
    structure = replace(structure_from(fits, pooled_scatter([fits])), k=Estimate(1000.0, 0.0, unit="N/m"))
    specimen, names = Specimen(mass_kg=3.0), ["stiffness", "viscous_damping"]
    anchor = choose_anchor(specimen, structure)
    assert anchor.kind == "mass"
    wet = to_physical(names, np.array([250.0, 0.3]), np.zeros((2, 2)), anchor, specimen, dry=False)
    assert {name: one.value for name, one in wet.items()} == pytest.approx(
        {"k_N_per_m": 1000.0, "c_Ns_per_m": 1.2, "total_mass_kg": 4.0, "added_mass_kg": 1.0}
    )
    dry = to_physical(names, np.array([330.0, 0.3]), np.zeros((2, 2)), anchor, specimen, dry=True)
    assert {name: one.value for name, one in dry.items()} == pytest.approx(
        {"k_N_per_m": 990.0, "c_Ns_per_m": 0.9, "total_mass_kg": 3.0}
    )


def test_in_air_a_stated_stiffness_gives_kilograms_where_nothing_was_weighed():
    anchor = choose_anchor(Specimen(stiffness_N_per_m=1000.0), None, dry=True)
    found = to_physical(["stiffness"], np.array([250.0]), np.zeros((1, 1)), anchor, Specimen(), dry=True)
    assert {name: one.value for name, one in found.items()} == {"k_N_per_m": 1000.0, "total_mass_kg": 4.0}


def test_a_mass_gives_kilograms_where_the_equation_has_no_added_mass_and_not_beside_one():
    specimen, cells = Specimen(mass_kg=3.0), Estimate(1000.0, 1.0, unit="N/m")
    anchor = choose_anchor(specimen, None, cells, added_mass=False)
    assert (anchor.kind, anchor.sentence) == ("mass", "mass 3 kg, as given")
    assert choose_anchor(specimen, None, cells).kind == "load cells"
    assert not choose_anchor(specimen, None).known
    stated = replace(specimen, stiffness_N_per_m=1000.0)
    assert choose_anchor(stated, None, added_mass=False).kind == "stiffness"
    assert not choose_anchor(Specimen(), None, added_mass=False).known


def test_numbers_over_a_known_mass_become_kilograms_without_an_error_of_the_mass():
    specimen = Specimen(mass_kg=3.0)
    anchor = choose_anchor(specimen, None, added_mass=False)
    spread = np.array([[0.25, 0.004], [0.004, 0.0001]])
    found = to_physical(["stiffness", "viscous_damping"], np.array([250.0, 0.3]), spread, anchor, specimen, dry=False)
    assert {name: one.value for name, one in found.items()} == pytest.approx(
        {"k_N_per_m": 750.0, "c_Ns_per_m": 0.9, "total_mass_kg": 3.0}
    )
    assert found["k_N_per_m"].stderr == pytest.approx(3.0 * 0.5)
    assert found["c_Ns_per_m"].stderr == pytest.approx(3.0 * 0.01)
    assert found["total_mass_kg"].total_stderr == 0.0
    assert found["k_N_per_m"].systematic == 0.0


def test_dry_means_carry_the_freedom_they_were_seen_with():
    _, fits, _ = trials()
    structure = structure_from(fits, pooled_scatter([fits]))
    assert structure.c.freedom == 2.0
    both = pooled_scatter([fits, fits])
    assert both.freedom == 4.0
    assert structure_from(fits, both).c.stderr < structure.c.stderr  # pooled over springs: less widened


def test_scatter_is_the_standard_deviation_where_noise_is_small():
    _, fits, _ = trials()
    values = np.array([f.estimates["k_N_per_m"].value for f in fits.values()])
    seen = float(np.std(values, ddof=1) / np.mean(values))
    assert pooled_scatter([fits]).values["k"] == pytest.approx(seen, rel=0.15)  # noise of single trials is taken out


def test_errors_of_damping_and_friction_go_against_each_other():
    _, fits, _ = trials()
    known = structure_from(fits, Scatter({"k": 0.0, "c": 0.0, "mu": 0.0}, math.inf))
    scattered = structure_from(fits, Scatter({"k": 0.004, "c": 0.2, "mu": 0.1}, math.inf))
    assert -1.0 <= known.c_with_mu < -0.7  # noise alone
    assert known.c_with_mu < scattered.c_with_mu <= 0.0  # scatter moves each by itself
    assert known.mean_errors["c"] == pytest.approx(known.c.stderr)  # a stated scatter is not widened
    few = structure_from(fits, Scatter({"k": 0.004, "c": 0.2, "mu": 0.1}, 2.0))
    assert few.mean_errors["c"] == pytest.approx(scattered.mean_errors["c"])
    assert few.c.stderr > 1.5 * few.mean_errors["c"]


def test_one_dry_trial_shows_no_scatter_and_says_so():
    _, fits, _ = trials()
    one = dict(list(fits.items())[:1])
    scatter = pooled_scatter([one])
    assert scatter.values == DEFAULT_SCATTER
    assert scatter.freedom == 0.0
    assert structure_from(one, scatter).source == "output error on 1 dry trials; scatter assumed, not seen"


def test_a_structure_of_no_dry_trial_is_refused():
    with pytest.raises(IdentificationError, match="structure: 0 dry trials were fitted; give k, c, mu in the config"):
        structure_from({}, pooled_scatter([{}]))


def test_hardening_per_unit_mass_has_its_unit_per_kg():
    _, _, wet = trials()
    terms = terms_by_name(("stiffness", "viscous_damping", "cubic_stiffness", "quintic_stiffness"))
    model = group_model(terms, wet, Specimen(), None, dry=False, anchored=False)
    units = {c.name: c.unit for c in model.coefficients}
    assert units["cubic_stiffness_N_per_m3_per_mass"] == "N/m^3 per kg"
    assert units["quintic_stiffness_N_per_m5_per_mass"] == "N/m^5 per kg"
    assert all(unit.endswith("per kg") for unit in units.values())


def test_where_load_cells_alone_give_the_scale_the_fit_is_per_unit_mass():
    _, _, wet = trials()
    model = group_model(TERMS, wet, Specimen(), None, dry=False, anchored=True)
    assert not model.anchored
    assert all(math.isfinite(c.start) and c.unit.endswith("per kg") for c in model.coefficients)
    assert group_model(TERMS, wet, Specimen(stiffness_N_per_m=1e5), None, dry=False, anchored=True).anchored


def test_dry_trials_with_a_stated_stiffness_and_no_mass_have_one_scale():
    *_, dry = trials()
    model = group_model(TERMS, dry, Specimen(stiffness_N_per_m=1e5), None, dry=True, anchored=True)
    names = [c.name for c in model.coefficients]
    assert "total_mass_kg" in names
    assert not any(name.startswith("k_N_per_m") for name in names)  # free too, it would give no kilograms
    weighed = group_model(TERMS, dry, Specimen(mass_kg=9.0, stiffness_N_per_m=1e5), None, dry=True, anchored=True)
    assert next(c.name for c in weighed.coefficients) == "k_N_per_m"


def test_kilograms_of_a_regression_do_not_move_an_equation_per_unit_mass():
    _, _, wet = trials()
    names = ("stiffness", "viscous_damping")
    model = group_model(terms_by_name(names), wet, Specimen(), None, dry=False, anchored=False)
    baseline = fit_group(model, wet, OPTIONS)
    regression = Fit("sindy", ("a",), {}, {"k_N_per_m": Estimate(1.4e8, unit="N/m")})
    theta = theta_of(model, baseline, regression, wet[0].name)
    assert theta[SLOT["k1"]] == baseline.model.theta(baseline.values, wet[0].name)[SLOT["k1"]]


def test_a_law_of_the_water_that_is_another_does_not_move_the_mass_off_all_trials():
    """Drag goes with |v|^1.5: what that leaves, counted as a sensor's noise, outweighed what dry trials say of k. A
    group's added mass was -44 kg where every trial gave 45."""
    rng = np.random.default_rng(5)
    names = ("stiffness", "viscous_damping", "coulomb_friction", "added_mass")
    drag = find("drag_exponent", exponent=1.5)

    def recorded(x0, wet):
        stiffness = 9000.0 * (1.0 + 0.004 * rng.standard_normal())
        terms = (*map(find, names), drag) if wet else tuple(map(find, names[:3]))
        equation = Equation(terms, (stiffness, 20.0, 5.0, 45.0, 120.0)[: len(terms)], mass_kg=180.0)
        run = undertow.simulate(equation, x0=x0, rate_hz=100.0, duration_s=12.0)
        return run.recorded(noise_m=2e-4, seed=int(1e3 * x0) + wet, name=f"{'w' if wet else 'd'}{x0}")

    dry, water = (undertow.read([recorded(x0, wet) for x0 in (0.06, 0.08, 0.1, 0.12)]) for wet in (False, True))
    found = undertow.fit(water, [*names, "quadratic_drag"], dry=dry, mass_kg=180.0)
    assert found.parameters.loc["added_mass_kg", "value"] == pytest.approx(45.0, abs=6.0)
    assert any("the equation lacks something" in doubt for doubt in found.doubts)  # as many times the noise as before


def test_damping_of_the_structure_and_of_the_water_keep_their_own_numbers():
    _, fits, wet = trials()
    structure = structure_from(fits, pooled_scatter([fits]))
    water = Specimen(tables.STRUCTURE_MASS_KG, area_m2=tables.REFERENCE_AREA_M2, submerged_volume_m3=0.0)
    model = group_model((*TERMS, find("linear_damping")), wet, water, structure, dry=False, anchored=True)
    fit = fit_group(model, wet, OPTIONS)
    found = dict(zip((t.name for t in fit.equation().terms), fit.equation().coefficients, strict=True))
    assert found["viscous_damping"] == structure.c.value
    assert found["linear_damping"] == pytest.approx(fit.estimates["linear_damping_c_Ns_per_m"].value)
    theta = model.theta(fit.values)
    assert fit.equation().theta(0.1)[SLOT["c1"]] == pytest.approx(float(theta[SLOT["c1"]]))


def test_two_laws_of_one_force_are_refused_where_nothing_tells_them_apart():
    _, _, wet = trials()
    water = Specimen(tables.STRUCTURE_MASS_KG, area_m2=tables.REFERENCE_AREA_M2, submerged_volume_m3=0.0)
    said = "^viscous_damping and linear_damping are the same force, and only their sum is known: take one of them out"
    with pytest.raises(IdentificationError, match=said):
        group_model((*TERMS, find("linear_damping")), wet, water, None, dry=False, anchored=True)
