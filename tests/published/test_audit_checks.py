"""What is odd in the published tables is found by the checks; where nothing is odd they are silent."""

from __future__ import annotations

import functools

import numpy as np
import pytest

from tests.published.audit_config import without_audits
from undertow.audit.comparisons import check_comparisons
from undertow.audit.findings import TWICE, AuditFindings, merged
from undertow.audit.forces import check_forces
from undertow.audit.headings import correct_units
from undertow.audit.identities import check_identities
from undertow.audit.patterns import check_patterns
from undertow.audit.tables import Column, Constants, PublishedTable
from undertow.campaign.audit.published import audit, dry_structures
from undertow.errors import UndertowError

DRY, WET = 1.63, 2.57
CONSTANTS = Constants(2637.4, 0.97, (0.0, 0.0), "spring", "water_depth_m", DRY)


@functools.cache
def published() -> AuditFindings:
    return audit(without_audits())


def one(rule: str, table: str, quantity: str = ""):
    found = [
        o for o in published().checks
        if o.rule == rule and table in o.tables and (not quantity or o.quantity == quantity)
    ]  # fmt: skip
    assert found, f"no oddity {rule} in {table}"
    return found[0]


@pytest.mark.parametrize(
    ("table", "quantity"),
    [
        ("table01", "stiffness"), ("table02", "stiffness"), ("table05", "energy"), ("table07", "energy"),
        ("table08", "energy"),
    ],
)  # fmt: skip
def test_headings_a_thousand_times_too_large_are_found_and_mended(table, quantity):
    assert one("unit", table, quantity).printed / one("unit", table, quantity).expected > 900.0
    mended = next(t for t in published().tables if t.name == table)
    assert np.median(mended.columns[quantity].values) < 1e6


def test_no_other_heading_is_mended():
    assert len([o for o in published().checks if o.rule == "unit"]) == 5


def test_table_7s_energies_are_those_of_the_other_spring():
    sentence = one("identity", "table07", "energy").sentence
    assert "3.66 times" in sentence  # the releases of Table 10
    assert "3.55 times" in sentence  # those of Table 5
    assert "that of the short spring" in sentence


def test_the_short_springs_period_and_stiffness_disagree():
    found = one("identity", "text", "stiffness")
    assert found.printed == 404000.0
    assert found.expected == pytest.approx(386546.0, abs=10.0)  # m (2 pi / 0.519 s)^2


def test_the_captions_slips_and_the_stiffness_behind_their_releases_are_found():
    assert len([o for o in published().checks if o.rule == "slip of the point"]) == 3
    assert "3.859e+05 N/m" in one("releases stated twice", "figure06").sentence


def test_table_1s_drift_of_k_and_two_groups_of_c_are_found():
    assert one("drift", "table01", "stiffness").sentence.count("108965 +- 79 N/m") == 1
    groups = one("two groups", "table01", "damping")
    assert (groups.expected, groups.printed) == pytest.approx((710.25, 430.3), abs=0.1)


def test_table_9_contradicts_table_4():
    mass = one("same quantity", "table09", "added_mass")
    assert (mass.expected, mass.printed) == (1271.4, 2042.0)
    assert one("same quantity", "table09", "drag_coefficient").printed == 25.0


def test_table_10s_maxima_give_another_mass_than_printed():
    found = one("largest acceleration", "table10")
    assert found.printed == pytest.approx(3908.8)
    assert 4100.0 < found.expected < 4700.0


def test_one_water_has_two_added_masses():
    assert "322.9 and 0 kg" in one("same water", "table06").sentence
    assert len([o for o in published().checks if o.rule == "on its bound"]) == 2


def test_the_formulas_that_cannot_be_meant_and_the_volume_that_is_not_printed_are_said():
    for table in ("table07", "table08", "table10"):
        assert one("formula", table, "drag_coefficient").expected < 0.0
        assert "leave friction out" in one("formula", table, "added_mass").sentence
    assert one("not printed", "table05").expected == pytest.approx(0.00729 * 9810.0 * 1.1, rel=0.01)


def test_table_10s_drag_needs_no_water():
    share = published().shares[0]
    assert share.table == "table10"
    assert np.all(share.printed < share.dry_high)
    assert share.share_high.max() < 0.2


def test_drag_falls_with_the_release_as_no_constant_coefficient_does():
    laws = {t.table: t.law for t in published().trends if t.quantity == "drag_coefficient"}
    assert laws["table05"].exponent == pytest.approx(-1.12, abs=0.01)
    assert laws["table05"].stderr == pytest.approx(0.18, abs=0.01)
    assert laws["table07"].exponent == pytest.approx(-1.0, abs=0.01)


def column(values, digits: float = 1e-9) -> Column:
    values = np.asarray(values, dtype=float)
    return Column(values, np.full(values.size, digits))


def clean_tables() -> list[PublishedTable]:
    """A dry and a wet table that agree with each other and with every identity, scattering a little."""
    rng = np.random.default_rng(3)
    release = np.array([0.015, 0.02, 0.03, 0.04, 0.06, 0.09, 0.11])
    k = 109592.0 * (1.0 + 0.003 * rng.standard_normal(7))
    c = 590.0 * (1.0 + 0.06 * rng.standard_normal(7))
    dry = {
        "release": column(release), "load": column(k * release), "stiffness": column(k), "damping": column(c),
        "damping_ratio": column(c / (2.0 * np.sqrt(k * 2637.4))),
        "friction_coefficient": column(0.0073 * (1.0 + 0.05 * rng.standard_normal(7))),
    }  # fmt: skip
    wet = {
        "release": column(release), "energy": column(0.5 * k.mean() * release**2),
        "added_mass": column(1200.0 * (1.0 + 0.02 * rng.standard_normal(7))),
        "drag_coefficient": column(6.0 * (1.0 + 0.05 * rng.standard_normal(7))),
    }  # fmt: skip
    return [
        PublishedTable("dry", "Dry", dry, {"spring": "long", "water_depth_m": DRY}, recipe="envelope"),
        PublishedTable("wet", "Wet", wet, {"spring": "long", "water_depth_m": WET}, recipe="method1"),
    ]


def test_tables_that_fit_together_raise_no_oddity():
    tables, units = correct_units(clean_tables(), CONSTANTS)
    structures = dry_structures(tables, CONSTANTS)
    found = [
        *units, *check_identities(tables, CONSTANTS), *check_patterns(tables, CONSTANTS),
        *check_comparisons(tables, CONSTANTS), *check_forces(tables, structures, CONSTANTS),
    ]  # fmt: skip
    assert [o.sentence for o in found] == []


@pytest.mark.parametrize(
    ("table", "quantity", "change", "rule"),
    [
        (1, "energy", lambda v: v * 2.0, "identity"),
        (1, "energy", lambda v: v * 1000.0, "unit"),
        (0, "damping", lambda v: v * np.array([1.4] * 3 + [0.8] * 4), "two groups"),
        (0, "stiffness", lambda v: 109592.0 * (1.0 + 0.1 * np.linspace(0.0, 1.0, 7)), "drift"),
        (1, "drag_coefficient", lambda v: 0.05 / np.array([0.015, 0.02, 0.03, 0.04, 0.06, 0.09, 0.11]), "too smooth"),
        (1, "added_mass", lambda v: np.where(np.arange(7) == 2, 0.0, v), "on its bound"),
    ],
)
def test_one_planted_oddity_is_found(table, quantity, change, rule):
    tables = clean_tables()
    planted = tables[table].replaced(quantity, column(change(tables[table].columns[quantity].values)))
    tables[table] = planted
    tables, units = correct_units(tables, CONSTANTS)
    found = [*units, *check_identities(tables, CONSTANTS), *check_patterns(tables, CONSTANTS)]
    assert rule in {o.rule for o in found if planted.name in o.tables}


def test_columns_of_different_lengths_are_refused():
    with pytest.raises(UndertowError, match=r"table t: columns have .*'release': 2, 'load': 3.* rows"):
        PublishedTable("t", "T", {"release": column([1.0, 2.0]), "load": column([1.0, 2.0, 3.0])})


def test_checks_that_say_the_same_are_one_row_and_none_is_lost():
    rows = published().together()
    assert len(rows) < len(published().checks) // 2 + 1
    said = " ".join(line for _, lines in rows for line in lines)
    twice = [check for check in published().checks if check.rule == TWICE]
    assert all(f"{check.expected:.5g} and {check.printed:.5g}" in said for check in twice)
    assert len({tuple(lines) for _, lines in rows}) == len(rows)


def test_sentences_that_differ_in_numbers_alone_keep_the_order_of_every_number():
    both = merged(["Table 5: 9 of 9 rows, 2 kg.", "Table 7: 9 of 9 rows, 3 kg.", "Table 8: 9 of 9 rows, 2 kg."])
    assert both == "Tables 5, 7 and 8: 9 of 9 rows, 2, 3 and 2 kg."


def test_a_lead_without_contradictions_says_so():
    lead = AuditFindings("clean", (), (), (), (), (), ()).lead
    assert lead == "No two numbers of these tables contradict each other."
