"""What the page of verdicts on real recordings says is what the package says."""

from __future__ import annotations

from pathlib import Path

import pytest

from experiments.real_verdicts.__main__ import CASES, PAGE, page, said, verdicts

RECORDINGS = Path(__file__).resolve().parents[2] / ".." / "shared" / "recordings"


@pytest.mark.skipif(not RECORDINGS.exists(), reason="real recordings (../shared/recordings) not here")
@pytest.mark.slow
def test_a_tanker_given_a_straight_spring_lacks_its_hardening_or_a_spring_that_changes():
    case = next(c for c in CASES if c.config == "kvlcc2")
    found, _ = verdicts(case, exact=False)
    at_rest, ahead = found  # at rest something else is missing too: damping that sets in above 5.5 degrees
    assert at_rest.verdict == ("unknown",)
    assert "fifth power of the displacement comes closest" in at_rest.sentence
    assert ahead.verdict == ("unknown",)  # one trial: what goes with its amplitude goes with its time
    assert ahead.alternatives == (("quintic_stiffness",),)  # k5 of the published equation
    assert ahead.sentence.split(". ")[1].startswith("A stiffness or a mass that changes during each trial explains it")
    assert ahead.augmented is not None
    assert ahead.augmented.nrmse < 0.3 * ahead.baseline.nrmse
    assert all(said(verdict) in PAGE.read_text(encoding="utf-8") for verdict in found)


def test_every_case_has_its_rows_on_the_page():
    text = PAGE.read_text(encoding="utf-8")
    assert all(text.count(f"| {case.title} | {case.known} | assumed |") >= 1 for case in CASES)
    assert page([]).splitlines()[0] == text.splitlines()[0]
