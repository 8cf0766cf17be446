"""A case: a campaign, what the user did to it in words and as an edit, and the answers that are right."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from experiments.misuse.answers import Way
from experiments.misuse.campaigns import Draft


@dataclass(frozen=True)
class Case:
    """One mistake, or one campaign in order.

    Attributes
    ----------
    name : one word, for --only and the tests.
    done : what the user did, in words.
    base : the campaign, in order.
    edit : does it.
    ways : answers that are right, any of them.
    """

    name: str
    done: str
    base: Callable[[], Draft]
    edit: Callable[[Draft], None]
    ways: tuple[Way, ...]

    def draft(self) -> Draft:
        """The campaign with the mistake in it."""
        draft = self.base()
        self.edit(draft)
        return draft


def leave(draft: Draft) -> None:
    """No edit: the campaign is used as it stands."""
