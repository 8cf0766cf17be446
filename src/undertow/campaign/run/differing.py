"""A group's numbers with errors that hold how much its trials differ, each fitted alone.

Belongs here: which fits are compared with which. Does not belong here: the test and the errors
(uncertainty/disagreement.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from undertow.likelihood.fit import Fit
from undertow.methods.baseline import GroupFit
from undertow.uncertainty.disagreement import OF_ONE_TRIAL, grown, grown_words

JOINT = ("output_error", "sindy")
"""Methods that take a group's trials together."""

MEAN = "mean over trials"
"""How the note of a fit begins whose numbers are means of single fits: scatter is in their errors already."""

Singles = Mapping[str, Mapping[str, Fit]]
"""Trial -> method -> its fit of that trial alone."""


def with_grown_errors(fits: Mapping[str, Fit], singles: Singles) -> dict[str, Fit]:
    """The methods' fits of all trials together, errors grown where trials differ by more; a note says so."""
    return {name: _grown(fit, singles) for name, fit in fits.items()}


def _grown(fit: Fit, singles: Singles) -> Fit:
    if fit.method not in JOINT or any(note.startswith(MEAN) for note in fit.notes):
        return fit
    alone = [singles[name][fit.method].parameters for name in fit.trials if fit.method in singles[name]]
    parameters, found = grown(fit.parameters, alone)
    return replace(fit, parameters=parameters, notes=(*fit.notes, *grown_words(found)))


def baseline_grown(
    baseline: GroupFit, singles: Sequence[Mapping[str, Fit]]
) -> tuple[GroupFit, tuple[str, ...]]:
    """The baseline with errors that hold how much its trials differ, and what is to be said of that."""
    if len(singles) == 1:
        return baseline, (OF_ONE_TRIAL,)
    alone = [fits["output_error"].parameters for fits in singles if "output_error" in fits]
    estimates, found = grown(baseline.estimates, alone)
    return replace(baseline, estimates=estimates), grown_words(found)
