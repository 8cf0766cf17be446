"""Water that adds a stiffness: three springs tell it from an added mass of each spring's own, two do not."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.concealed.test_diagnosis import LONG, SHORT, SPRINGS, member
from undertow.comparison.joining import has_room
from undertow.comparison.level import Level, make_level
from undertow.comparison.null_test import null_test
from undertow.comparison.search import diagnose
from undertow.comparison.suspects import all_suspects, chosen
from undertow.discrepancy.case import Case
from undertow.discrepancy.judge import judge
from undertow.discrepancy.transfer import from_other_springs
from undertow.discrepancy.verdict import Described
from undertow.equation import registry

FEW = chosen(("added_stiffness", "linear_damping", "cubic_stiffness", "relaxation"))
MIDDLE = (200000.0, 700.0, 0.007)
ADDED = 6000.0
(SUSPECT,) = (s for s in all_suspects() if s.name == "added_stiffness")


def level(monkeypatch, hidden) -> Level:
    """Three springs in one water."""
    monkeypatch.setitem(SPRINGS, "middle", MIDDLE)
    springs = (("short", SHORT), ("middle", (0.02, 0.04)), ("long", LONG))
    return make_level([member(name, releases, 5000 + 20 * i, hidden) for i, (name, releases) in enumerate(springs)])


@pytest.fixture
def stiffened(monkeypatch) -> Level:
    """The same with a stiffness that the water adds."""
    return level(monkeypatch, ((registry.find("added_stiffness"), ADDED),))


def test_three_springs_tell_a_stiffness_of_the_water(stiffened):
    found = diagnose(stiffened, FEW)
    assert not found.null.fit.shared_water  # each spring's own added mass comes closer than one for all
    assert found.best.names == ("added_stiffness",)
    assert found.rivals == (("hidden_resonator",),)
    fit = found.best.fit
    error = fit.solution.stderr("added_stiffness.N_per_m")
    assert fit.value("added_stiffness.N_per_m") == pytest.approx(ADDED, abs=3.0 * error)
    assert error < 0.2 * ADDED
    assert fit.moved(found.null.fit)[0].startswith("added_mass_kg@")
    assert fit.moved(found.null.fit)[1] > 10.0
    tested = null_test(stiffened, FEW, found.null.fit, found.candidates)  # each spring has its own water: no step to it
    assert {"linear_damping", "relaxation"} <= {test.name for test in tested.tests}
    assert "added_stiffness" not in {test.name for test in tested.tests}
    trials = [m.motions for m in stiffened.members]
    assert from_other_springs(stiffened, fit, trials) == ({}, {}, {})  # one spring alone does not tell it


def test_three_springs_with_an_added_mass_alone_need_no_stiffness(monkeypatch):
    assert diagnose(level(monkeypatch, ()), FEW).best.names == ()


def test_two_springs_do_not_tell_it_and_say_so(stiffened):
    two = make_level(stiffened.members[:2])
    found = diagnose(two, FEW)
    assert not has_room(two, SUSPECT, found.null.fit)
    assert has_room(stiffened, SUSPECT, found.null.fit)
    assert found.best.names == ()
    baseline = Described(0.01, 0.01, {})
    cases = [
        Case({"spring": m.label}, f"spring {m.label}", m, (), baseline, 0.004, 0.05, 0, False, True)
        for m in two.members
    ]
    for verdict in judge(cases, FEW):
        assert verdict.status == "nothing_missing"
        assert verdict.not_testable == ("rest_offset", "support_compliance", "added_stiffness")
    in_air = [replace(case, dry=True) for case in cases]
    assert all("added_stiffness" not in verdict.not_testable for verdict in judge(in_air, FEW))


def test_springs_of_which_nobody_knows_the_structure_do_not_tell_it(stiffened):
    first, *others = stiffened.members
    unknown = replace(first, model=replace(first.model, fixed=None))
    fit = diagnose(make_level(others), FEW).null.fit
    assert not has_room(replace(stiffened, members=(unknown, *others)), SUSPECT, fit)


def test_drag_with_another_power_has_a_coefficient_on_each_spring():
    """A drag coefficient that falls with the amplitude falls with the frequency too: one for all had been a dashpot."""
    shape = registry.find("drag_exponent", exponent=1.4)
    short = member("short", (0.008, 0.03), 5100, ((shape, 9000.0),))
    long = member("long", LONG, 5120, ((shape, 3000.0),))
    found = diagnose(make_level([short, long]), chosen(("drag_exponent", "linear_damping", "cubic_damping")))
    assert found.best.names == ("drag_exponent",)
    assert found.best.suspects[0].variant == "each spring's own"
    first, second = (found.best.fit.value(f"drag_exponent.coefficient_N_sp_per_mp@{s}") for s in ("short", "long"))
    assert first > 1.5 * second
