"""Rivals behind simulated tables: the right one is named, nobody is accused where Eq. 15 is true, errors are
sentences."""

from __future__ import annotations

import functools
import math
from dataclasses import replace

import numpy as np
import pytest

from experiments.audit.simulated import CONFIG, design, structures
from undertow.campaign.audit import cases_of, constants_of, mended_tables
from undertow.campaign.audit_settings import load_audit
from undertow.campaign.audit_tables import read_table
from undertow.discrepancy.audit.answer import Answer, answer, fitted_surface
from undertow.discrepancy.audit.case import Case, Row, case_returns
from undertow.discrepancy.audit.posterior import log_mean, posterior, scatters, surface_error, weigh
from undertow.discrepancy.audit.rivals import Rival, rivals
from undertow.discrepancy.audit.surface import build_surface, printed_values
from undertow.discrepancy.audit.verdicts import judge, next_test
from undertow.errors import UndertowError

NODES = 8


def simulated(truth: dict[str, float], scatter: float = 0.01) -> Case:
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


def test_nobody_is_accused_where_equation_15_is_true():
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
    assert sum(w.probability for w in found(name).weights if not w.rival.effects) < 0.01


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


def test_a_mean_of_logarithms_is_safe_far_from_one():
    assert log_mean(np.array([-2000.0, -2000.0])) == -2000.0
    assert log_mean(np.array([-np.inf])) == -math.inf


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
        Case("c", rows, structures(), 2637.4, 0.97)


def test_releases_too_small_for_the_recipe_are_said_once_for_all_rivals():
    case = Case("c", (row(release_m=0.0005),), structures(), 2637.4, 0.97)
    with pytest.raises(UndertowError, match=r"audit of c: 0 of \d+ rivals can be tried; .*releases are too small"):
        answer([case], NODES)
    with pytest.raises(UndertowError, match=r"cannot be run under equation 15 at any of 1 nodes"):
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
