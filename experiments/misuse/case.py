"""A case: a campaign, what the user did to it in words and as an edit, and the answers that are right."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import pandas as pd

from experiments.misuse.answers import Way
from experiments.misuse.campaigns import Draft

Edit = Callable[[Draft], object]


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
    edit: Edit
    ways: tuple[Way, ...]

    def draft(self) -> Draft:
        """The campaign with the mistake in it."""
        draft = self.base()
        self.edit(draft)
        return draft


def leave(draft: Draft) -> None:
    """No edit: the campaign is used as it stands."""


def setting(path: str, value: object) -> Edit:
    """Another value of a key of the config."""
    return lambda draft: draft.set(path, value)


def channel(quantity: str, **keys: object) -> Edit:
    """Other keys of one channel of the config."""
    return lambda draft: draft.channel(quantity, **keys)


def everywhere(edit: Callable[[pd.DataFrame], pd.DataFrame | None]) -> Edit:
    """An edit of every recording."""
    return lambda draft: draft.change(draft.recordings, edit)
