"""Rivals behind simulated tables: the right one is named, nothing is named where Eq. 15 is true, errors are
sentences."""

from __future__ import annotations

import functools
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import multivariate_normal, norm

from experiments.audit.simulated import CONFIG, design, structures
from tests.published.audit_config import mended_tables
from undertow.audit.answer import Answer, answer
from undertow.audit.case import PrintedCase, Row, case_returns
from undertow.audit.exploring import fitted_surface
from undertow.audit.posterior import RivalPosterior, posterior, weigh
from undertow.audit.rivals import Rival, RivalUnknown, rivals
from undertow.audit.sampling import log_likelihood, log_prior
from undertow.audit.scatter import MASS_SHARES, log_belief, log_sum, scatters
from undertow.audit.surface import SMALLEST_DRAG, Sheet, build_surface, printed_values
from undertow.audit.verdicts import judge, next_test
from undertow.campaign.audit.published import cases_of, constants_of
from undertow.campaign.audit.settings import load_audit
from undertow.campaign.audit.tables import read_table
from undertow.errors import UndertowError

NODES = 8


def simulated(truth: dict[str, float], scatter: float = 0.01) -> PrintedCase:
    """Method 2 on two springs, four releases each, printed with a scatter of 1 % of the moving mass and of C_d."""
    empty = design("method2", structures())
    values = {"added_mass_kg": 900.0, "drag_coefficient": 6.0, "volume_m3": 0.3, **truth}
    printed = np.array([(one.added_mass_kg, one.drag_coefficient) for one in case_returns(empty, values)])
    rng = np.random.default_rng(8)
    printed[:, 0] += scatter * empty.mass_kg * rng.standard_normal(printed.shape[0])
    printed[:, 1] *= 1.0 + scatter * rng.standard_normal(printed.shape[0])
    return empty.with_printed(printed)


@functools.cache
def found(name: str) -> Answer:
    truths = {
        "nothing": {}, "offset": {"rest_offset.offset_m": 0.0015}, "friction": {"coulomb_friction.force_N": 110.0},
        "damping": {"linear_damping.c_Ns_per_m": 1500.0},
    }  # fmt: skip
    return answer([simulated(truths[name])], NODES)


def test_nothing_is_named_where_equation_15_is_true():
    verdict = judge(found("nothing"))
    assert verdict.verdict == ()
    assert verdict.status == "nothing_missing"
    assert verdict.informs_about_water


@pytest.mark.parametrize(
    ("name", "effect"),
    [("offset", "rest_offset"), ("friction", "coulomb_friction"), ("damping", "linear_damping")],
)
def test_a_planted_effect_is_named_and_equation_15_is_not(name, effect):
    verdict = judge(found(name))
    assert effect in {one for names in (verdict.verdict, *verdict.alternatives) for one in names}
    assert sum(w.probability for w in found(name).weights if not w.rival.effects) < 0.02


def test_intervals_hold_the_planted_numbers():
    damping = found("damping").of("linear_damping")
    low, high = damping.posteriors[0].interval("linear_damping.c_Ns_per_m")[1:]
    assert low < 1500.0 < high
    offset = found("offset").of("rest_offset").posteriors[0]
    middle, low, high = offset.interval("rest_offset.offset_m")
    assert low < 0.0015 < high
    assert middle == pytest.approx(0.0015, rel=0.3)


def test_probabilities_add_up_to_one_and_are_ordered():
    shares = [w.probability for w in found("nothing").weights]
    assert sum(shares) == pytest.approx(1.0)
    assert shares == sorted(shares, reverse=True)


def surface_error(case: PrintedCase, found: RivalPosterior, draws: int = 8) -> np.ndarray:
    """Root-mean-square difference (2,) of surface and recipes over the first draws: m_a in kg, C_d as a share."""
    errors = []
    for i in range(draws):
        values = {name: float(column[i]) for name, column in found.draws.items()}
        exact = case_returns(case, values)
        for j, (row, one) in enumerate(zip(case.rows, exact, strict=True)):
            drag = one.bounded_drag if row.on_bound else one.drag_coefficient
            size = max(abs(row.drag_coefficient), SMALLEST_DRAG)
            gap = found.predicted[i, j] - np.array([one.added_mass_kg, drag])
            errors.append([gap[0], gap[1] / size])
    return np.sqrt(np.nanmean(np.square(errors), axis=0))


def test_the_surface_is_the_recipes_at_its_posterior():
    case = found("offset").cases[0]
    gap = surface_error(case, found("offset").of("rest_offset").posteriors[0])
    assert gap[0] < 0.01 * case.mass_kg  # the scatter that was added
    assert gap[1] < 0.02


def test_numbers_that_a_dry_body_prints_carry_no_information_about_the_water():
    empty = design("method2", structures())
    printed = np.array([(one.added_mass_kg, one.drag_coefficient) for one in case_returns(empty, {"turn_share": 0.5})])
    verdict = judge(answer([empty.with_printed(printed)], NODES))
    assert not verdict.informs_about_water
    assert "no information about the water" in verdict.sentence


def test_the_same_seed_gives_the_same_evidence():
    case = simulated({})
    surface = fitted_surface(case, rivals(case, NODES)[0])
    once, again = (weigh(case, surface, seed=3) for _ in range(2))
    assert np.array_equal(once.logs, again.logs)
    assert not np.array_equal(once.logs, weigh(case, surface, seed=4).logs)


def test_a_prior_put_in_place_of_another_is_kept_to():
    case = simulated({})
    rival = rivals(case, NODES)[0].given({"k.short": (-0.039, 0.001)})
    draws = posterior(weigh(case, fitted_surface(case, rival))).draws["k.short"]
    assert draws.mean() == pytest.approx(-0.039, abs=0.002)


def test_what_other_cases_say_of_the_scatter_moves_a_posterior():
    case = simulated({})
    weighed = weigh(case, fitted_surface(case, rivals(case, NODES)[0]))
    large = np.array([-0.0 if mass > 100.0 else -1e6 for mass, _ in scatters(case)])
    assert posterior(weighed, elsewhere=large).mass_scatter_kg > 100.0
    assert posterior(weighed).mass_scatter_kg < 60.0  # 26 kg were added


def test_published_table_8_is_an_offset_of_the_displacement():
    config = load_audit(CONFIG)
    dry = structures()
    tables = [read_table(config, name) for name in config.tables]
    constants = constants_of(config)
    tables = mended_tables(tables, constants)
    said = next(one for one in config.audits if one.name == "Table 8")
    ((_, case),) = cases_of(config, said, tables, dry, constants)
    verdict = judge(answer([case], NODES))
    assert verdict.verdict == ("rest_offset",)
    interval = verdict.parameters[0]["rest_offset"]["offset_m"]
    assert 0.0005 < interval.low < interval.high < 0.0012


def test_the_test_that_would_decide_belongs_to_what_is_open():
    assert "stops it" in next_test(("linear_damping",), (("coulomb_friction",),), True)
    assert "dry release" in next_test(("linear_damping",), (), False)
    assert next_test(("linear_damping",), (), True) == ""
    assert "recordings" in next_test(("linear_damping",), (("support_compliance",),), True)
    assert "third spring" in next_test(("gain_error",), (("support_compliance",),), True)


def test_a_sum_of_logarithms_is_safe_far_from_one():
    assert log_sum(np.array([-2000.0, -2000.0])) == pytest.approx(-2000.0 + math.log(2.0))
    assert log_sum(np.array([-np.inf])) == -math.inf


def test_rows_scatter_by_at_most_the_cap_and_evenly_below():
    for cap, allowed in ((0.05, 6), (0.1, 7), (0.2, 8)):
        believed = np.exp(log_belief(cap)).reshape(len(MASS_SHARES), -1).sum(axis=1)
        assert believed == pytest.approx([1.0 / allowed] * allowed + [0.0] * (len(MASS_SHARES) - allowed))


def test_the_density_of_a_print_is_the_normal_one_and_a_bound_is_its_tail():
    case = replace(simulated({}), rows=(row(), row(recipe="method1", added_mass_kg=0.0)))
    covariance = np.array([[900.0, 12.0], [12.0, 0.25]])
    predicted = np.array([[880.0, 6.4], [-40.0, 6.1]])
    found_density = log_likelihood(case, predicted[None, None], np.broadcast_to(covariance, (1, 2, 2, 2)))[0, 0]
    both = multivariate_normal([880.0, 6.4], covariance).logpdf([900.0, 6.0])
    bound = norm.logcdf(40.0 / 30.0) + norm.logpdf(6.0, 6.1, 0.5)
    assert found_density == pytest.approx(both + bound, rel=1e-9)


def test_a_prior_that_is_cut_off_still_adds_up_to_one():
    unknowns = (RivalUnknown("compliance", 0.0, 5.0, 2.0),)
    points = np.linspace(-1.0, 5.0, 6001)
    density = np.exp(log_prior(unknowns, points[None, :, None])[0])
    assert np.trapezoid(density, points) == pytest.approx(1.0, abs=1e-3)  # the step of the grid at the cut
    assert density[points < 0.0].max() == 0.0


def test_a_bent_sheet_predicts_its_quadratic():
    rng = np.random.default_rng(1)
    curves = rng.normal(size=(2, 2, 3, 3))
    sheet = Sheet(None, np.ones(3), rng.normal(size=(2, 2)), rng.normal(size=(2, 2, 3)), 0.0, curves)
    away = rng.normal(size=3)
    expected = sheet.values + sheet.slopes @ away + np.einsum("rckl,k,l->rc", curves, away, away)
    assert sheet.predict((1.0 + away)[None])[0] == pytest.approx(expected)


def stiffness_prior(structures_changed: dict[str, float]) -> RivalUnknown:
    case = simulated({})
    dry = {name: replace(one, k_other=structures_changed.get(name, math.nan)) for name, one in structures().items()}
    rival = next(one for one in rivals(replace(case, structures=dry), NODES) if one.effects == ("gain_error",))
    return next(one for one in rival.unknowns if one.name.startswith("gain_error"))


def test_a_mis_stated_stiffness_lies_between_the_dry_numbers_or_is_anywhere_within_a_few_per_cent():
    k = structures()["short"].k
    told = stiffness_prior({"short": 0.96 * k, "long": 109592.0})
    assert told.name == "gain_error.stiffness_short"
    assert (told.mean, told.deviation) == (pytest.approx(-0.02), pytest.approx(0.02))
    agrees = stiffness_prior({"long": structures()["long"].k})
    assert agrees.name == "gain_error.stiffness_long"
    assert (agrees.mean, agrees.deviation) == (pytest.approx(0.0), 0.005)
    silent = stiffness_prior({})
    assert (silent.name, silent.mean, silent.deviation) == ("gain_error.stiffness_short", 0.0, 0.04)


def test_a_stiffness_that_is_given_is_not_mis_stated_again():
    rival = next(one for one in rivals(simulated({}), NODES) if one.effects == ("gain_error",))
    given = rival.given({"k.short": (-0.039, 0.001)})
    assert next(one for one in given.unknowns if one.name.startswith("gain_error")).deviation == 0.005


def test_pieces_of_a_resonators_range_hold_the_whole_prior():
    rival = next(one for one in rivals(simulated({}), NODES) if one.split)
    edges = rival.edges
    assert edges.size == NODES + 1
    frequency = next(one for one in rival.unknowns if one.name == rival.split)
    assert (edges[0], edges[-1]) == (frequency.low, frequency.high)
    inside = rival.within((edges[2], edges[3]))
    assert inside.values(np.array([one.centre for one in inside.unknowns]))[rival.split] == pytest.approx(
        math.exp(0.5 * (edges[2] + edges[3]))
    )


def believing(answered: Answer, shift: float) -> Answer:
    """The same answer where Eq. 15 explains the rows by scatter alone, if they scatter by 20 % and 40 %."""
    largest = np.full(len(scatters(answered.cases[0])), -1e3)
    largest[-1] = shift + max(weight.log_evidence for weight in answered.weights)
    return replace(answered, weights=tuple(
        one if one.rival.effects or not one.rival.water else replace(one, at_scatter=largest)
        for one in answered.weights
    ))  # fmt: skip


def test_a_verdict_that_rests_on_rows_that_hardly_scatter_says_so():
    sure, doubtful = judge(found("offset")), judge(believing(found("offset"), 9.0))
    assert "rests on rows" not in sure.sentence
    assert "where 20 % (527 kg from row to row) are as likely as less, Eq. 15 keeps a probability" in doubtful.sentence
    assert doubtful.equation_if[0.1] < 0.02 < doubtful.equation_if[0.2]
    assert doubtful.verdict == sure.verdict


def row(**changes) -> Row:
    return replace(Row("t", "long", 0.05, "method2", 900.0, 6.0), **changes)


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        ((), r"audit case c: 0 rows; name a table"),
        ((row(spring="middle"),), r"no structure 'middle', known are long, short; add it"),
        ((row(release_m=0.0),), r"a row of t has release 0 m; it must be positive"),
    ],
)
def test_a_case_that_cannot_be_is_refused(rows, message):
    with pytest.raises(UndertowError, match=message):
        PrintedCase("c", rows, structures(), 2637.4, 0.97)


def test_releases_too_small_for_the_recipe_are_said_once_for_all_rivals():
    case = PrintedCase("c", (row(release_m=0.0005),), structures(), 2637.4, 0.97)
    with pytest.raises(UndertowError, match=r"audit of c: 0 of \d+ rivals can be tried; .*releases are too small"):
        answer([case], NODES)
    with pytest.raises(UndertowError, match=r"cannot be run under equation 15 in any of 1 ranges"):
        build_surface(case, rivals(case, NODES)[0])


def test_a_prior_without_any_draw_is_refused():
    case = simulated({})
    base = rivals(case, NODES)[0]
    surface = build_surface(case, base)
    far = [replace(one, low=1e9, high=2e9) if one.name == "volume_m3" else one for one in base.unknowns]
    nowhere = Rival((), tuple(far))
    sheets = tuple(replace(sheet, centre=sheet.centre * np.nan) for sheet in surface.sheets)
    with pytest.raises(UndertowError, match="no draw of equation 15 lies within its priors"), np.errstate(all="ignore"):
        weigh(case, replace(surface, rival=nowhere, sheets=sheets))


def test_an_unknown_that_a_rival_has_not_is_refused():
    with pytest.raises(UndertowError, match=r"equation 15 has no unknown 'offset', it has added_mass_kg"):
        found("nothing").of().posteriors[0].interval("offset")


def test_printed_values_keep_what_is_not_printed():
    case = replace(simulated({}), rows=(row(drag_coefficient=math.nan),))
    assert np.isnan(printed_values(case)[0, 1])
