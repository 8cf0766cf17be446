"""The sixty mistakes and the ten campaigns that are in order."""

from __future__ import annotations

from experiments.misuse import fine, in_channels, in_config, in_files, in_trials
from experiments.misuse.case import Case

THEMES: dict[str, tuple[Case, ...]] = {
    "Files and the index": in_files.MISTAKES,
    "The config": in_config.MISTAKES,
    "The channels": in_channels.MISTAKES,
    "The tests": in_trials.MISTAKES,
}
"""Mistakes by where they are made."""

MISTAKES: tuple[Case, ...] = tuple(case for cases in THEMES.values() for case in cases)

FINE: tuple[Case, ...] = fine.CAMPAIGNS
"""Campaigns that must stay green or explained, whatever is done about the mistakes."""

CASES: tuple[Case, ...] = MISTAKES + FINE

SMALL = (
    "index_not_there", "cut_gzip", "dry_level_not_there", "volume_of_a_level_missing", "g_labelled_mps2",
    "one_level_in_mm", "stuck", "two_dry_trials", "linear_damping_in_water", "other_units",
)  # fmt: skip
"""One case or two of each kind, for --small."""


def case(name: str) -> Case:
    """The case of that name. Raises KeyError with the names there are."""
    for candidate in CASES:
        if candidate.name == name:
            return candidate
    raise KeyError(f"no case '{name}'; there are {', '.join(candidate.name for candidate in CASES)}")
