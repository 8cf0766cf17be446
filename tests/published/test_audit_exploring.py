"""Clouds through the recipes: densities, weights that a dense grid gives too, what is left as it is."""

from __future__ import annotations

import functools
import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from experiments.audit.simulated import CONFIG, design, structures
from tests.published.audit_config import mended_tables
from undertow.audit import exploring
from undertow.audit.bending import bent_surface
from undertow.audit.case import PrintedCase, case_returns
from undertow.audit.exploring import Cloud, explored_surface
from undertow.audit.posterior import posterior, weigh
from undertow.audit.rivals import EXPLORED, Rival, rivals
from undertow.audit.scatter import log_belief, log_sum
from undertow.audit.surface import Surface, at_print, build_surface, pinned_sheet
from undertow.campaign.audit.published import cases_of, constants_of
from undertow.campaign.audit.settings import load_audit
from undertow.campaign.audit.tables import read_table

MASS = "hidden_resonator.mass_kg"


@functools.cache
def level() -> PrintedCase:
    """Tables 4 and 6 at 2.22 m: one row a spring, one of them on the bound."""
    config = load_audit(CONFIG)
    constants = constants_of(config)
    tables = mended_tables([read_table(config, name) for name in config.tables], constants)
    said = next(one for one in config.audits if one.name == "Tables 4 and 6")
    return cases_of(config, said, tables, structures(), constants)[0][1]


def resonator(case: PrintedCase) -> Rival:
    return next(one for one in rivals(case, 8) if one.split)


@functools.cache
def pieces() -> Surface:
    return bent_surface(level(), build_surface(level(), resonator(level())))


@functools.cache
def explored() -> Surface:
    return explored_surface(level(), pieces())


def pinned() -> tuple[int, ...]:
    return tuple(i for i, one in enumerate(resonator(level()).unknowns) if one.name in EXPLORED)


def grid(frequencies: int, dampings: int) -> Surface:
    """The same posterior without any cloud: a sheet at every point of an even grid."""
    rival, (w, z) = resonator(level()), pinned()
    ranges = [(rival.unknowns[i].low, rival.unknowns[i].high) for i in (w, z)]
    sheets = []
    middles = [(np.arange(count) + 0.5) / count for count in (frequencies, dampings)]
    for shares in itertools.product(*middles):
        point = [low + share * (high - low) for (low, high), share in zip(ranges, shares, strict=True)]
        start = min((one.centre for one in pieces().sheets), key=lambda one: abs(one[w] - point[0])).copy()
        start[[w, z]] = point
        sheet = pinned_sheet(level(), rival, start, (w, z), None)
        if sheet is not None:
            sheets.append(replace(sheet, log_share=-math.log(frequencies * dampings)))
    return Surface(rival, tuple(sheets))


def evidence(surface: Surface) -> float:
    return log_sum(log_belief() + weigh(level(), surface).log_evidences)


@pytest.mark.slow
def test_a_cloud_weighs_what_a_dense_grid_weighs():
    dense = grid(24, 5)
    # a hundred points of each: 0.3 in the logarithm of an evidence, a fifth of an interval
    assert evidence(explored()) == pytest.approx(evidence(dense), abs=0.8)
    here, there = (posterior(weigh(level(), one)).interval(MASS) for one in (explored(), dense))
    assert here[0] == pytest.approx(there[0], rel=0.25)
    assert max(here[1], there[1]) < min(here[2], there[2])


def test_what_is_pinned_stays_and_the_recipes_were_run_there():
    sheet = explored().sheets[0]
    assert sheet.pinned == pinned()
    drawn = weigh(level(), Surface(explored().rival, (sheet,))).points
    free = [i for i in range(drawn.shape[-1]) if i not in pinned()]
    assert np.all(np.ptp(drawn.reshape(-1, drawn.shape[-1]), axis=0)[free] > 0.0)
    assert np.all(drawn[..., list(pinned())] == sheet.centre[list(pinned())])
    again = case_returns(level(), explored().rival.values(sheet.centre), at_print(level()))
    assert [one.added_mass_kg for one in again] == pytest.approx(sheet.values[:, 0])


def test_shares_of_a_cloud_add_up_to_the_whole_prior():
    # each point stands for prior over density: together they are the prior's whole mass, a wide cloud's error aside
    total = np.exp([sheet.log_share for sheet in explored().sheets]).sum()
    assert 0.3 < total < 2.0


def test_kernels_integrate_to_one():
    cloud = Cloud(np.array([[0.0, 0.0], [1.0, 0.5]]), np.array([0.25, 0.75]), np.array([0.1, 0.1]))
    axis = np.linspace(-8.0, 9.0, 171)
    points = np.array(list(itertools.product(axis, axis)))
    assert np.exp(cloud.log_density(points)).sum() * (axis[1] - axis[0]) ** 2 == pytest.approx(1.0, abs=1e-3)
    drawn = cloud.draw(4000, np.random.default_rng(0))
    assert drawn.mean(axis=0) == pytest.approx([0.75, 0.375], abs=0.1)  # 1 / sqrt(4000) of a width of 1.3


def test_method_2_has_one_answer_and_is_left_as_it_is():
    empty = design("method2", structures())
    case = empty.with_printed(
        np.array([(one.added_mass_kg, one.drag_coefficient) for one in case_returns(empty, {"added_mass_kg": 900.0})])
    )
    surface = build_surface(case, rivals(case, 2)[0])
    assert explored_surface(case, surface) is surface
    plain = build_surface(level(), rivals(level(), 2)[0])
    assert explored_surface(level(), plain) is plain  # Eq. 15 has nothing that bends


def test_a_cloud_that_no_recipe_can_be_run_in_leaves_the_surface(monkeypatch):
    monkeypatch.setattr(exploring, "pinned_sheet", lambda *_: None)
    assert explored_surface(level(), pieces()) is pieces()


def test_slopes_of_what_is_known_well_do_not_jump_from_point_to_point():
    case = design("springs", structures())
    rival = resonator(case)
    values = {
        "added_mass_kg": 400.0, "drag_coefficient": 6.0, "volume_m3": 0.5, MASS: 640.0,
        EXPLORED[0]: 6.67, EXPLORED[1]: 0.06,
    }  # fmt: skip
    printed = [one.bounded for one in case_returns(case, values)]
    case = case.with_printed(np.array(printed).round(1))
    names = [one.name for one in rival.unknowns]
    start = np.array([values.get(one.name, 0.0) for one in rival.unknowns])
    start = np.where([one.logarithmic for one in rival.unknowns], np.log(np.maximum(start, 1e-9)), start)
    known = [i for i, one in enumerate(rival.unknowns) if not one.bends]
    moved = []  # kg of m_a for the error of each nuisance
    for step in (0.0, 0.001, 0.002, 0.003):
        point = start.copy()
        point[names.index(EXPLORED[0])] += step
        sheet = pinned_sheet(case, rival, point, tuple(names.index(one) for one in EXPLORED), None)
        moved.append(sheet.slopes[:, 0, known] * [rival.unknowns[i].scale for i in known])
    assert np.max(np.abs(moved)) > 2.0
    # a search leaves some 0.02 kg: over a twentieth of an error that would be 0.5
    assert np.max(np.std(moved, axis=0)) < 0.1
