"""Verdicts of several groups as one sequence, found just now or read from a run's folder.

Belongs here: what both say of their groups alike. Does not belong here: one group's numbers (diagnosed.py, opening.py).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from html import escape
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar

import pandas as pd

from undertow.recording.recording import Condition
from undertow.report.trial_curves import Axes, draw_errors, new_axes
from undertow.report.which_group import group_meant


class GroupVerdict(Protocol):
    """A group with its verdict."""

    @property
    def label(self) -> str:
        """Its conditions in words."""

    @property
    def conditions(self) -> Mapping[str, Condition]:
        """Its conditions by name."""

    @property
    def row(self) -> dict[str, Any]:
        """Its row of a table of verdicts."""


Group = TypeVar("Group", bound=GroupVerdict)


class Verdicts(Generic[Group]):
    """A sequence of groups with their verdicts."""

    if TYPE_CHECKING:
        groups: tuple[Group, ...]

    def __len__(self) -> int:
        return len(self.groups)

    def __iter__(self) -> Iterator[Group]:
        return iter(self.groups)

    def __getitem__(self, which: int | str) -> Group:
        """A group by place, by its label, or by words or conditions that it alone fits."""
        if isinstance(which, int):
            if not -len(self.groups) <= which < len(self.groups):
                said = f"there are {len(self.groups)}: 0 to {len(self.groups) - 1}"
                raise IndexError(f"group {which} is asked for, but {said}")
            return self.groups[which]
        return self.groups[group_meant(which, [group.conditions for group in self.groups])]

    @property
    def verdicts(self) -> pd.DataFrame:
        """One row a group: status, what is named, confidence, free-run error before and after, what is allowed."""
        index = pd.Index([group.label for group in self.groups], name="group")
        return pd.DataFrame([group.row for group in self.groups], index=index)

    def plot(self, axes: Axes | None = None) -> Axes:
        """Free-run error of every group before and after the repair, beside what is allowed; returns the Axes."""
        rows = [(g.label, *(g.row[key] for key in ("error", "error_repaired", "allowed"))) for g in self.groups]
        return draw_errors(rows, new_axes() if axes is None else axes)

    def _repr_html_(self) -> str:
        said = "".join(f"<p>{escape(line)}</p>" for line in str(self).splitlines())
        table = self.verdicts.to_html(border=0, float_format=lambda value: f"{value:.3g}", na_rep="-")
        return f"<div>{said}{table}</div>"
