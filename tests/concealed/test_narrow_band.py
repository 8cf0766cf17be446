"""A force of a narrow band: its size and phase change as fast as the band is wide, in every trial in another way."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from tests.concealed.test_diagnosis import member
from undertow.comparison import attempt
from undertow.comparison.attempt import widened
from undertow.comparison.candidate import Candidate
from undertow.comparison.clock import parts_of
from undertow.comparison.joint import free_run_error, its_own, shared_theta
from undertow.comparison.level import Level, make_level
from undertow.comparison.prescribed import plain_fit
from undertow.comparison.search import diagnose
from undertow.comparison.suspect import Scales
from undertow.comparison.suspects import NARROW, SUSPECTS, chosen
from undertow.equation import registry
from undertow.equation.forcing import ENVELOPE
from undertow.equation.kernel import SLOT
from undertow.equation.term import Term
from undertow.likelihood.free_run import free_run

(FORCE,) = chosen(("external_forcing",))
RELEASES = (0.03, 0.04, 0.05)


def band(rng: np.random.Generator, rate: float, length: float, width: float) -> tuple[Term, float]:
    """A band of that many radians of phase over the record, as powers of time, and its coefficient for a mean square
    of 1."""
    lines = rng.normal(0.0, width / length, 12)
    sizes = rng.rayleigh(1.0, 12) * np.exp(2j * math.pi * rng.random(12))
    t = np.linspace(0.0, length, 200)
    envelope = (sizes * np.exp(1j * np.outer(t, lines))).sum(axis=1)
    envelope /= math.sqrt(np.mean(np.abs(envelope) ** 2))
    both, order = (envelope.real, envelope.imag), len(ENVELOPE) - 1
    cosine, sine = (Polynomial.fit(t, part, order).convert().coef for part in both)
    size = math.hypot(cosine[0], sine[0])
    numbers = {"phase_rad": math.atan2(-sine[0], cosine[0])}
    for n, (c, s) in enumerate(zip(cosine[1:], sine[1:], strict=True), start=1):
        grows, turns = registry.row("changing_force").parameters[1 + 2 * n : 3 + 2 * n]
        numbers |= {grows.name: math.hypot(c, s) / size, turns.name: math.atan2(-s, c)}
    return registry.find("changing_force", frequency_rad_per_s=rate, **numbers), size


@cache
def swept(width: float, size: float = 1500.0, ratio: float = 1.6) -> tuple[Level, float]:
    """A level under such a force, of so many N, and the force's rate."""
    still = make_level([member("short", RELEASES, 2000)])
    rate, rng, parts = ratio * still.scales.slowest, np.random.default_rng(5), []
    for i, x0 in enumerate(RELEASES):
        force, unit = band(rng, rate, still.scales.record, width)
        parts.append(member("short", (x0,), 2000 + i, ((force, unit * size),)))
    return make_level([replace(parts[0], motions=tuple(m for part in parts for m in part.motions))]), rate


def test_a_band_that_turns_three_times_over_in_a_record_is_named_and_leaves_noise():
    level, rate = swept(3.0)
    said = diagnose(level, chosen(("linear_damping", "cubic_damping", "external_forcing")))
    assert said.null.fit.misfit > 1000.0
    assert said.best.names == ("external_forcing",)
    assert said.best.fit.misfit < 1.3
    assert said.best.fit.value("external_forcing.frequency_rad_per_s") == pytest.approx(rate, rel=0.02)
    assert {"gcos_t4", "gsin_t4"} <= {a.also[-1][0] for a in said.best.fit.addends[-1].additions[3:]}
    assert free_run_error(level, said.best.fit) < 1.0  # sizes and phases fitted to each trial, k at its dry value


def test_wider_forms_begin_at_the_noise_that_the_last_one_left(monkeypatch):
    """At the noise of what stands, thousands of times that, a fit from the right place ended eight times further off,
    and at the memory of what stands 2,793 samples counted as nine (c0072 of sealed seed 2135001)."""
    level, _ = swept(1.0)
    null = Candidate((), plain_fit(level), 0.0)
    steady = replace(FORCE, wider=())
    (found,) = [c for c in diagnose(level, [steady]).candidates if c.suspects]
    found = replace(found, fit=attempt.at_memory(found.fit, null.fit.memory))
    asked: list[tuple[float, float]] = []
    real = attempt._with

    def watched(level, best, *given, **more):
        asked.append((best.fit.misfit, best.fit.memory))
        return real(level, best, *given, **more)

    monkeypatch.setattr(attempt, "_with", watched)
    wide = widened(level, null, FORCE, found)
    assert wide.fit.misfit < 1.3 < 3.0 < found.fit.misfit
    assert wide.fit.memory == null.fit.memory
    assert asked[0][0] == pytest.approx(found.fit.misfit, rel=0.05)  # fitted once more at its own memory
    assert asked[0][0] < 0.1 * null.fit.misfit
    assert asked[0][1] < 0.5 * null.fit.memory
    assert widened(level, null, steady, found) is found
    assert widened(level, null, FORCE, replace(found, fit=replace(found.fit, misfit=1.02))).fit.misfit == 1.02
    assert widened(level, null, FORCE, None) is None
    asked.clear()
    settled = replace(found.fit, misfit=1.02, solution=replace(found.fit.solution))
    monkeypatch.setattr(attempt, "at_own", lambda _, one: replace(one, fit=settled))
    assert widened(level, null, FORCE, found).fit.misfit == 1.02  # priors had held it: a tone that does not change
    assert asked == []


def test_after_two_forms_that_came_no_closer_no_further_one_is_tried(monkeypatch):
    level, _ = swept(1.0)
    null = Candidate((), plain_fit(level), 0.0)
    (found,) = [c for c in diagnose(level, [replace(FORCE, wider=())]).candidates if c.suspects]
    tried: list[int] = []
    monkeypatch.setattr(attempt, "at_own", lambda _, one: one)
    monkeypatch.setattr(attempt, "_closer", lambda *given: (tried.append(len(given[-1].additions)), given[2])[1])
    assert widened(level, null, FORCE, found) is found
    assert tried == [5, 7]
    assert len(FORCE.wider) > len(tried)


def test_no_form_is_wider_than_a_narrow_band():
    scales = Scales(1.0, 5.0, 0.2, 1.0, 5.0, 5.0, record=10.0)
    cycles = 4.0 / NARROW
    for rate, most in ((2.0 * math.pi * cycles / 10.0 * 1.001, 4), (2.0 * math.pi * cycles / 10.0 * 0.999, 2)):
        forms = [form(scales, rate) for form in FORCE.wider]
        assert max(len(form) for form in forms) == 3 + 2 * most
        assert [bool(form) for form in forms] == sorted((bool(form) for form in forms), reverse=True)


def test_the_parts_of_a_form_are_polynomials_that_begin_at_one_and_end_at_plus_or_minus_one():
    scales = Scales(1.0, 5.0, 0.2, 1.0, 5.0, 5.0, record=20.0)
    for a in FORCE.wider[-1](scales, 9.0)[3:]:
        at = [sum(by * t ** ENVELOPE.index(slot[4:]) for slot, by in a.slots) for t in (0.0, 10.0, 20.0)]
        order = int(a.name.rsplit("_", 1)[1])
        assert at == pytest.approx([1.0, math.cos(order * math.pi / 2.0), (-1.0) ** order], abs=1e-9)


def test_an_unseen_trial_has_sizes_of_its_own_fitted_and_a_seen_one_keeps_its_own():
    level, _ = swept(1.0)
    (one,) = level.members
    best = diagnose(level, [s for s in SUSPECTS if s.name == "external_forcing"]).best
    motion = one.motions[0]
    own = its_own(best.fit)
    assert len(own) == len(best.fit.addends[-1].additions) - 1
    theta = shared_theta(level, one, best.fit, motion.name)
    unseen = theta.copy()
    names = best.fit.solution.problem.names
    for a in (a for a in best.fit.addends[-1].additions if a.of_its_own):
        value = best.fit.solution.values[names.index(f"external_forcing.{a.name}[{motion.name}]")]
        for slot, by in a.slots:
            unseen[SLOT[slot]] -= by * value
    seen, anew = (free_run(motion, at, 1e-3, own) for at in (theta, unseen))
    assert anew.nrmse == pytest.approx(seen.nrmse, rel=1e-3)
    assert free_run(motion, unseen, 1e-3).nrmse > 5.0 * anew.nrmse
    places, counts = parts_of(best.fit, best.fit.addends[-1], motion.name, 0.0)
    there = counts @ best.fit.solution.values[places]
    assert there == pytest.approx([theta[SLOT["gcos"]], theta[SLOT["gsin"]]], rel=2e-3)  # 15 ms after the release

