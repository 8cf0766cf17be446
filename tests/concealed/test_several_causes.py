"""A frequency that drifts with the time since release: described, with its size, never called one of its causes."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.concealed.test_diagnosis import SHORT, member
from undertow.campaign.run.judgement import _beside_unknown
from undertow.campaign.run.rig import standing_addends
from undertow.comparison.level import make_level
from undertow.comparison.search import diagnose
from undertow.comparison.suspects import SUSPECTS, chosen
from undertow.discrepancy.case import Case
from undertow.discrepancy.earned import of_several_causes
from undertow.discrepancy.judge import judge, judge_level
from undertow.discrepancy.verdict import Described, Verdict
from undertow.equation import registry

DRIFT, HARD = -12e3, 3e7
"""A stiffness that falls by 3 % within seconds (N/m), and a spring that hardens as much at 20 mm (N/m^3)."""
LIKE_IT = chosen(("stiffness_drift", "cubic_stiffness", "quintic_stiffness", "hysteresis", "linear_damping"))
SAID = Verdict({"spring": "short"}, ("a",), status="explained", verdict=("stiffness_drift",), sentence="Explained.",
               origin="structure", parameters={"stiffness_drift": {}})  # fmt: skip


def hides(name: str, size: float, seed: int, **inner: float):
    """A level of three releases with one law, searched for those that look like a drift."""
    return diagnose(make_level([member("short", SHORT, seed, ((registry.find(name, **inner), size),))]), LIKE_IT)


def test_a_drift_in_releases_of_several_sizes_is_no_spring_that_hardens():
    found = hides("stiffness_drift", DRIFT, 7300, time_s=3.0)
    assert found.best.names == ("stiffness_drift",)
    size, error = (
        found.best.fit.value("stiffness_drift.N_per_m@short"),
        found.best.fit.solution.stderr("stiffness_drift.N_per_m@short"),
    )
    assert abs(size - DRIFT) < 3.0 * error
    assert error < 0.2 * abs(DRIFT)
    time = found.best.fit.value("stiffness_drift.time_s")
    assert time == pytest.approx(3.0, abs=3.0 * found.best.fit.solution.stderr("stiffness_drift.time_s"))


def test_a_drift_too_slow_to_end_is_a_straight_line_and_is_not_excluded_for_its_time():
    found = hides("stiffness_drift", 100.0 * DRIFT, 7300, time_s=500.0)
    assert found.best.names == ("stiffness_drift",)
    rate, time = (found.best.fit.value(f"stiffness_drift.{n}") for n in ("N_per_m@short", "time_s"))
    assert time > 20.0  # releases are over in 6 s
    assert rate / time == pytest.approx(DRIFT / 5.0, rel=0.2)


def test_a_spring_that_hardens_is_not_taken_for_a_drift():
    found = hides("cubic_stiffness", HARD, 7320)
    assert found.best.names == ("cubic_stiffness",)
    assert "stiffness_drift" not in {name for rival in found.rivals for name in rival.names}


def test_the_verdict_describes_a_drift_and_says_unknown():
    one = member("short", SHORT, 7340, ((registry.find("stiffness_drift", time_s=3.0), DRIFT),))
    case = Case({"spring": "short"}, "short", one, (), Described(0.4), 0.004, 0.05, 4, False, True)
    (verdict,) = judge([case], LIKE_IT)
    assert (verdict.status, verdict.verdict) == ("unknown", ("unknown",))
    shape = "That is the shape of a stiffness or a mass that changes during each trial"
    assert verdict.sentence.endswith(f"{shape}; a decay does not tell which: unknown.")
    assert "after a long rest" in verdict.next_test
    assert verdict.parameters["stiffness_drift"]["N_per_m"].value == pytest.approx(DRIFT, rel=0.2)


def test_what_dry_trials_cannot_tell_apart_water_does_not_tell_apart_either():
    group = member("short", SHORT, 7320, ((registry.find("cubic_stiffness"), HARD),))
    dry = Case({"spring": "short"}, "short", group, (), Described(0.4), 0.004, 0.05, 4, True, True)
    first = judge_level([dry], LIKE_IT)
    assert [v.verdict for v in first.verdicts] == [("cubic_stiffness",)]
    rivals = (("quintic_stiffness",), ("unknown",))
    puzzled = replace(first, verdicts=(replace(first.verdicts[0], status="not_identifiable", alternatives=rivals),))
    (wet,) = _beside_unknown([replace(dry, dry=False)], [puzzled])
    assert wet.dry_rivals == rivals
    assert _beside_unknown([dry], [puzzled]) == [dry]
    assert _beside_unknown([replace(dry, dry=False)], [first])[0].dry_rivals == ()
    (said,) = judge([wet], LIKE_IT, standing_addends([first]))
    assert (said.status, said.verdict, said.alternatives) == ("not_identifiable", ("cubic_stiffness",), rivals)
    assert "cannot tell it from stiffness with the fifth power of the displacement or something that nobody knows" in (
        said.sentence
    )
    (left,) = (gate for gate in said.decision if gate.gate == "left_above_noise")
    assert left.statistic == "mean squared residual over noise with cubic_stiffness"
    assert left.passed
    (sure,) = judge([replace(wet, dry_rivals=())], LIKE_IT, standing_addends([first]))
    assert (sure.status, sure.alternatives) == ("explained", ())


def test_only_a_drift_is_of_several_causes_and_it_is_looked_for():
    assert [name for name in registry.names() if registry.find(name).several_causes] == ["stiffness_drift"]
    assert "stiffness_drift" in {suspect.name for suspect in SUSPECTS}


@pytest.mark.parametrize(
    ("status", "names", "then", "said"),
    [
        ("explained", ("stiffness_drift",), "unknown", ("unknown",)),
        ("present_but_small", ("stiffness_drift",), "present_but_small", ("unknown",)),
        ("unknown", ("stiffness_drift", "unknown"), "unknown", ("unknown",)),
        ("explained", ("cubic_damping", "stiffness_drift"), "unknown", ("cubic_damping", "unknown")),
    ],
)
def test_a_shape_becomes_unknown_and_what_is_named_beside_it_stays(status, names, then, said):
    verdict = of_several_causes(replace(SAID, status=status, verdict=names))
    assert (verdict.status, verdict.verdict, verdict.origin) == (then, said, "undetermined")
    assert verdict.parameters == SAID.parameters
    assert "a stiffness or a mass that changes during each trial" in verdict.sentence


def test_a_shape_among_rivals_is_an_unknown_rival():
    named = replace(SAID, verdict=("cubic_stiffness",), alternatives=(("stiffness_drift",), ("hysteresis",)))
    verdict = of_several_causes(named)
    assert verdict.alternatives == (("unknown",), ("hysteresis",))
    assert replace(verdict, alternatives=named.alternatives) == named


def test_a_verdict_without_a_shape_is_as_it_was():
    named = replace(SAID, verdict=("cubic_stiffness",), sentence="Named.")
    assert of_several_causes(named) == named
