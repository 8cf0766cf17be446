"""One trial whose displacement has another scale: its friction and drag say so, and it bars every verdict."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.findings_fixture import small_findings
from undertow.campaign.run.plausible import with_doubts
from undertow.campaign.run.trial_scale import scaled_trial
from undertow.discrepancy.findings import GroupFindings
from undertow.likelihood.fit import Fit
from undertow.quantities import Estimate

ALIKE = [(0.00155, 29.7), (0.00160, 30.9), (0.00152, 29.0), (0.00157, 30.2)]


def of_numbers(numbers: list[tuple[float, float | None]], error: float = 0.02, outcome: str = "ok") -> GroupFindings:
    """A group whose trials, each alone, gave these frictions and drags, with a relative error."""
    group, trials = small_findings().groups[1], []
    for at, (mu, drag) in enumerate(numbers):
        found = {"mu": Estimate(mu, error * abs(mu))}
        if drag is not None:
            found["drag_Ns2_per_m2"] = Estimate(drag, 2.0 * error * abs(drag))
        one = group.trials[0]
        fit = Fit("output_error", (f"r{at}",), {}, found, outcome=outcome)
        trials.append(replace(one, motion=replace(one.motion, recording=replace(one.motion.recording, name=f"r{at}")),
                              fits={"output_error": fit}))  # fmt: skip
    return replace(group, trials=tuple(trials))


def scaled(times: float, drag: bool = True) -> list[tuple[float, float | None]]:
    """Four trials alike and one whose displacement is so many times too large."""
    rows = [*ALIKE, (0.00156 * times, 30.0 / times)]
    return [(mu, q if drag else None) for mu, q in rows]


@pytest.mark.parametrize(
    ("times", "said"),
    [
        (0.1, "0.1 times the friction of the others and 10 times their drag, as if its displacement were written 10 "
              "times too small"),
        (1 / 25.4, "too small"),
        (2.0, "2 times the friction of the others and 0.5 times their drag, as if its displacement were written 2 times"
              " too large"),
    ],
)  # fmt: skip
def test_friction_and_drag_of_one_trial_show_the_scale_of_its_displacement(times, said):
    text = scaled_trial(of_numbers(scaled(times)))
    assert text.startswith("trial r4 has ")
    assert said in text
    assert text.endswith("look at its unit and column (recordings.layouts), or leave it out (recordings.exclude)")


@pytest.mark.parametrize(
    "group",
    [
        of_numbers(scaled(1.45)),  # trials' friction differs by as much
        of_numbers([*ALIKE, (0.0024, 24.8)]),  # its drag may be the others' too
        of_numbers(scaled(1e-3), error=0.6),  # nobody knows, however large the factor
        of_numbers([*ALIKE, (0.000156, 30.0)]),  # the drag says that its scale is right: it slid less
        of_numbers([*ALIKE, (0.00156, 300.0)]),  # no friction of another scale: another drag
        of_numbers(scaled(0.1), error=0.6),  # nobody knows
        of_numbers(scaled(0.1), outcome="did not converge"),
        of_numbers([ALIKE[0], (0.000156, 300.0)]),  # which of two is wrong?
        of_numbers([(0.0016, 30.0), (0.0004, 90.0), (0.0064, 12.0), (0.00016, 300.0)]),  # none is like another
        of_numbers(scaled(0.2, drag=False)),  # no unit is five times another
        of_numbers(scaled(2.54, drag=False)),  # a dirty rail as well
        of_numbers([(-0.001, 30.0), *ALIKE[1:]]),
    ],
)
def test_what_shows_no_scale_is_not_called_one(group):
    assert scaled_trial(group) == ""


def test_without_drag_only_the_ratio_of_two_units_is_doubted():
    assert scaled_trial(of_numbers(scaled(0.1, drag=False))).startswith(
        "trial r4 has 0.1 times the friction of the others, as if its displacement were written "
    )


def test_such_a_trial_bars_whatever_was_found_unless_it_is_known_to_be_strange():
    group = of_numbers(scaled(0.1))
    for status in ("unknown", "nothing_missing", "explained"):
        told = replace(group, verdict=replace(group.verdict, status=status))
        (found,), _ = with_doubts([told])
        assert found.verdict.status == "cannot_tell"
        assert "r4 has 0.1 times the friction" in found.verdict.sentence
        (known,), _ = with_doubts([told], {"r4": ("conditions",)})
        assert known.verdict.status == status
