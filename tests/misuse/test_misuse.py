"""Ordinary mistakes through the command end in a sentence or in `cannot_tell`; campaigns in order stay as they are."""

from __future__ import annotations

from pathlib import Path

import pytest

from experiments.misuse.answers import falsely_green, shortfalls
from experiments.misuse.case import Case
from experiments.misuse.mistakes import CASES, FINE, MISTAKES, SMALL, case
from experiments.misuse.running import run_case


def _named(cases: tuple[Case, ...]) -> list[object]:
    """The study's small slice, and the others as slow tests: what each answered stands in docs/misuse.md."""
    slow = pytest.mark.slow
    return [pytest.param(c, id=c.name, marks=() if c.name in SMALL else slow) for c in cases]


@pytest.mark.parametrize("mistake", _named(MISTAKES))
def test_a_mistake_ends_in_a_sentence_or_in_cannot_tell(mistake: Case, tmp_path: Path) -> None:
    outcome = run_case(mistake, tmp_path / mistake.name)
    assert not falsely_green(outcome, mistake.ways), f"{mistake.done}: said to be in order"
    assert shortfalls(outcome, mistake.ways) == [], f"{mistake.done}\n{outcome.err}\n{outcome.out}"


@pytest.mark.parametrize("campaign", _named(FINE))
def test_a_campaign_in_order_is_green_or_explained(campaign: Case, tmp_path: Path) -> None:
    outcome = run_case(campaign, tmp_path / campaign.name)
    assert shortfalls(outcome, campaign.ways) == [], f"{campaign.done}\n{outcome.err}\n{outcome.out}"


def test_there_are_sixty_mistakes_and_ten_campaigns_in_order() -> None:
    assert (len(MISTAKES), len(FINE)) == (60, 10)
    assert len({candidate.name for candidate in CASES}) == 70
    assert [case(name).name for name in SMALL] == list(SMALL)
