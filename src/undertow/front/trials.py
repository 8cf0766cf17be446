"""`Trials`: recordings read and conditioned, with everything that is known of them.

Belongs here: the frozen collection, choosing among its trials, its text, table and figure. Does not belong here:
reading (reading.py), fits (fitting.py).
"""

from __future__ import annotations

import html
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import wraps
from typing import Any, ParamSpec, TypeAlias, TypeVar, overload

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from undertow.campaign.config import RunConfig
from undertow.campaign.config.matching import contradicted_headers
from undertow.campaign.run.checking import Checked, doubted, each_once
from undertow.conditioning.agreement import Disagreement
from undertow.conditioning.motion import Motion
from undertow.conditioning.period import dominant_period
from undertow.conditioning.scale import out_of_scale
from undertow.discrepancy.findings import FailedTrial
from undertow.discrepancy.words import condition_words, count, group_title
from undertow.errors import RecordingError, UndertowError
from undertow.recording.conditions import same_condition
from undertow.recording.recording import LEFT_OUT, Condition, Recording
from undertow.report.trial_curves import Axes, draw_recording, new_axes

Given = ParamSpec("Given")
Made = TypeVar("Made")
_Several: TypeAlias = list[Any] | tuple[Any, ...] | NDArray[Any]

NAMES_SHOWN = 8
"""Names in a message at most."""

REASONS_SHOWN = 2
"""Reasons why trials cannot be used, in a message at most: most trials have the same."""

ARGUMENTS = {
    r"(recordings\.)?channels\.time: \{rate_hz: \.\.\.\}": "rate_hz=...",
    r" \(recordings\.exclude\)": "", r"set trials\.window\.start_s": "set window=(start_s, None)",
    r"set trials\.window\.end_s": "set window=(None, end_s)", r"trials\.window(\.\w+)?": "window=(start_s, end_s)",
    r'recordings\.releases: \{"[^"]*": (\[[^]]*\])\}, which undertow init and inspect write': r"releases=\1",
    r"\{start_s: ([^,]+), end_s: ([^}]+)\}": r"(\1, \2)", r"recordings\.releases": "releases=[(start_s, end_s), ...]",
    r"specimen\.(\w+)": r"\1", r"recordings\.accept": "accept=[...]",
    r"state recordings\.despike": "write NaN in their place",
    r"recordings\.channels\.(\w+)\.unit": r'units={"\1": ...}', r"recordings\.channels\.(\w+)\.sign": r"the sign of \1",
    r"recordings\.channels\.(\w+)": r'columns={"\1": ...}',
}
"""Pattern of a config's key that a sentence may name -> the argument of `read` that says the same, in their order."""


@dataclass(frozen=True, eq=False, repr=False)
class Trials(Sequence[Motion]):
    """Trials of one campaign, each a conditioned `Motion`, in the order they were read.

    ``failed`` are recordings that could not be used, each with the reason; ``config`` is what is known of the rig and
    of the groups, as a campaign's config says it; ``accepted`` is trial -> kinds of doubt that are known,
    ``found`` trial -> what does not belong together in it (docs/channel_checks.md).
    A sequence: ``trials[0]``, ``trials["r1"]``, ``trials[:3]`` and ``trials[[0, 2]]``.

    >>> import undertow
    >>> run = undertow.simulate({"stiffness": 400.0, "viscous_damping": 2.0}, x0=0.1, mass_kg=4.0, duration_s=6.0,
    ...                         rate_hz=100.0)
    >>> trials = undertow.read([run.recorded(noise_m=1e-4, name="r1", conditions={"spring": "long"})])
    >>> len(trials), trials.names, trials["r1"].recording.conditions["spring"]
    (1, ('r1',), 'long')
    >>> print(trials)
    1 trial
      r1 (spring long): released 0.1 m, period 0.629 s, 5.97 s at 100 Hz, displacement
    """

    motions: tuple[Motion, ...]
    config: RunConfig = field(repr=False)
    failed: tuple[FailedTrial, ...] = ()
    accepted: Mapping[str, tuple[str, ...]] = field(default_factory=dict, repr=False)
    found: Mapping[str, tuple[Disagreement, ...]] = field(default_factory=dict, repr=False)

    def __len__(self) -> int:
        return len(self.motions)

    def __iter__(self) -> Iterator[Motion]:
        return iter(self.motions)

    @overload
    def __getitem__(self, which: int | np.integer[Any] | str) -> Motion: ...

    @overload
    def __getitem__(self, which: slice | _Several) -> Trials: ...

    def __getitem__(self, which: int | np.integer[Any] | str | slice | _Several) -> Motion | Trials:
        """A trial by place or name, or several as `Trials`: by a slice, places, names, or an array of truth values."""
        if isinstance(which, slice):
            return replace(self, motions=self.motions[which])
        if isinstance(which, (int, np.integer)):
            if not -len(self) <= which < len(self):
                raise IndexError(f"trial {which} is asked for, but there are {len(self)}: 0 to {len(self) - 1}")
            return self.motions[which]
        if isinstance(which, (np.ndarray, list, tuple)):
            return replace(self, motions=tuple(self[one] for one in _places(which, len(self))))
        for motion in self.motions:
            if motion.name == which:
                return motion
        raise RecordingError(f"no trial is called {which!r}; there are {_listed(self.names)}")

    def __add__(self, other: Trials) -> Trials:
        """The trials of both, with what is known of the first; copies of an earlier one are listed in ``failed``."""
        both = each_once([Checked(m.name, m.recording.conditions, m) for m in (*self.motions, *other.motions)])
        copies = [one.failed for one in both if one.failed is not None]
        return replace(
            self, motions=tuple(one.motion for one in both if one.motion is not None),
            failed=(*self.failed, *other.failed, *copies),
            accepted={**self.accepted, **other.accepted}, found={**self.found, **other.found},
        )  # fmt: skip

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the trials, in order."""
        return tuple(motion.name for motion in self.motions)

    @property
    def recordings(self) -> tuple[Recording, ...]:
        """What the sensors said, in SI units."""
        return tuple(motion.recording for motion in self.motions)

    @property
    def coordinate(self) -> str:
        """translation (m) or rotation (rad)."""
        return self.config.equation.coordinate

    def where(self, **conditions: Condition) -> Trials:
        """The trials with these conditions, as ``trials.where(spring="long", water_depth_m=2.36)``.

        Raises RecordingError where none has them.
        """
        kept = tuple(
            m for m in self.motions
            if all(same_condition(m.recording.conditions.get(key), value) for key, value in conditions.items())
        )  # fmt: skip
        if not kept:
            there = {key: sorted({str(m.recording.conditions.get(key)) for m in self.motions}) for key in conditions}
            said = "; ".join(f"{key}: {', '.join(values)}" for key, values in there.items())
            raise RecordingError(f"none of {count(len(self), 'trial')} has {group_title(conditions)}; there is {said}")
        return replace(self, motions=kept)

    def groups(self, *by: str) -> dict[str, Trials]:
        """Trials by condition (by the config's ``group_by`` where none is named): label -> trials."""
        names = by or self.config.trials.group_by
        found: dict[str, list[Motion]] = {}
        for motion in self.motions:
            missing = [name for name in names if name not in motion.recording.conditions]
            if missing:
                have = ", ".join(motion.recording.conditions) or "none"
                raise RecordingError(f"trial {motion.name} has no condition {missing[0]!r}; it has {have}")
            label = group_title({name: motion.recording.conditions[name] for name in names})
            found.setdefault(label, []).append(motion)
        return {label: replace(self, motions=tuple(motions)) for label, motions in found.items()}

    @property
    def table(self) -> pd.DataFrame:
        """One row a trial: release amplitude, period, end of the motion, rate, noise, conditions (SI units)."""
        rows = []
        for motion in self.motions:
            channel = next(iter(motion.recording.channels))
            rows.append(
                {
                    "amplitude": motion.amplitude, "period_s": dominant_period(motion),
                    "duration_s": motion.window.end_s - motion.window.release_s, "rate_hz": motion.recording.rate_hz,
                    "held": motion.window.held, "channels": ", ".join(motion.recording.channels),
                    "noise": motion.noise.get(channel, math.nan), **motion.recording.conditions,
                }
            )  # fmt: skip
        return pd.DataFrame(rows, index=pd.Index(self.names, name="trial"))

    @property
    def doubts(self) -> tuple[str, ...]:
        """What may be wrong with the trials and stops nothing: a column whose name has another unit, channels that do
        not belong together or are left out, a motion out of scale; what is accepted is none."""
        known = {name for name, kinds in self.accepted.items() if "unit" in kinds}
        named = () if known else contradicted_headers(self.config)
        sized = out_of_scale([m for m in self.motions if m.name not in known])
        said = (*named, *doubted(self.found, self.motions), *sized)
        return said if self.config._source is not None else tuple(in_arguments(one) for one in said)

    @property
    def notes(self) -> tuple[str, ...]:
        """What reading and conditioning did to the trials beside that, a trial a line."""
        said = {doubt.sentence for doubts in self.found.values() for doubt in doubts}
        found = ((m.name, note) for m in self.motions for note in (*m.recording.notes, *m.notes))
        kept = tuple(f"{name}: {note}" for name, note in found if note not in said and LEFT_OUT not in note)
        return kept if self.config._source is not None else tuple(in_arguments(one) for one in kept)

    def plot(self, axes: Axes | None = None) -> Axes:
        """Every trial against the time after its release; returns the Axes."""
        axes = new_axes() if axes is None else axes
        for motion in self.motions:
            draw_recording(motion, axes)
        return axes

    def __repr__(self) -> str:
        lines = [count(len(self), "trial")]
        lines += [f"  {_line(motion)}" for motion in self.motions]
        lines += [f"  not used: {one.reason}" for one in self.failed]
        lines += [f"  ! {doubt}" for doubt in self.doubts]
        lines += [f"  - {note}" for note in self.notes[:NAMES_SHOWN]]
        more = len(self.notes) - NAMES_SHOWN
        return "\n".join([*lines, *([f"  - and {count(more, 'more note')} (notes)"] if more > 0 else [])])

    def _repr_html_(self) -> str:
        lines = (*(f"not used: {one.reason}" for one in self.failed), *self.doubts, *self.notes[:NAMES_SHOWN])
        said = "".join(f"<p>{html.escape(one)}</p>" for one in lines)
        table: Any = self.table.to_html(border=0, float_format=lambda value: f"{value:.4g}") if self.motions else ""
        return f"<div><p>{count(len(self), 'trial')}</p>{table}{said}</div>"


def in_arguments(sentence: str) -> str:
    """A sentence with the arguments of `read` in place of a config's keys."""
    for key, argument in ARGUMENTS.items():
        sentence = re.sub(key, argument, sentence)
    return sentence


def in_pythons_words(work: Callable[Given, Made]) -> Callable[Given, Made]:
    """The same function, whose errors name arguments of `read` in place of a config's keys, where no config was read.
    """

    @wraps(work)
    def wrapped(*given: Given.args, **named: Given.kwargs) -> Made:
        try:
            return work(*given, **named)
        except UndertowError as error:
            if not any(isinstance(one, Trials) and one.config._source is not None for one in given):
                error.args = (in_arguments(str(error)), *error.args[1:])
            raise

    return wrapped


def first_reasons(failed: Sequence[FailedTrial]) -> str:
    """Why trials cannot be used, the first reasons."""
    reasons = list(dict.fromkeys(one.reason for one in failed))
    more = len(reasons) - REASONS_SHOWN
    return "; ".join([*reasons[:REASONS_SHOWN], *([f"and {count(more, 'more trial')}"] if more > 0 else [])])


def _places(which: _Several, many: int) -> list[Any]:
    """Places or names, one by one; those of an array of truth values are where it is true."""
    given = np.asarray(which)
    if given.ndim != 1:
        raise IndexError(f"places of trials have the shape {given.shape}; give one list of places or names")
    if given.dtype.kind != "b":
        return list(which)
    if given.size != many:
        raise IndexError(f"{given.size} truth values are given, but there are {many} trials: give one a trial")
    return [*np.flatnonzero(given)]


def _line(motion: Motion) -> str:
    recording = motion.recording
    conditions = ", ".join(condition_words(key, value) for key, value in recording.conditions.items())
    unit = recording.unit("displacement")
    start = "released" if motion.window.held else "in motion from"
    length = motion.window.end_s - motion.window.release_s
    return (
        f"{recording.name}{f' ({conditions})' if conditions else ''}: {start} {motion.amplitude:.3g} {unit}, period "
        f"{dominant_period(motion):.3g} s, {length:.3g} s at {recording.rate_hz:.4g} Hz, "
        f"{', '.join(recording.channels)}"
    )


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - NAMES_SHOWN} more" if len(names) > NAMES_SHOWN else ""
    return ", ".join(names[:NAMES_SHOWN]) + more
