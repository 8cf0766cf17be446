"""One trial to explore: the trials' curves as numbers inside the page, and the library that draws them in a browser.

Belongs here: which curves go along, their packing, the library's bundle. Does not belong here: what the browser does
with them (templates/page.js), pictures that stand on the page as they are (trial_figures.py).
"""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np

from undertow.discrepancy.findings import Findings, TrialFindings
from undertow.discrepancy.words import percent
from undertow.recording.recording import Array
from undertow.report.arrange import chosen
from undertow.report.numbers import short_number
from undertow.report.small_multiples import PANELS_AT_MOST
from undertow.report.style import DRAWN
from undertow.report.trial_figures import WITH_FOUND, reach, response, with_words

TRIALS_AT_MOST = 120
"""Trials that can be explored on one page; of more, an equal part of every group: its ends and the worst explained."""

SAMPLES_AT_MOST = 4000
"""Samples of a curve: at forty a swing a hundred swings, more than a screen is wide at any zoom that shows one."""

VALUES_AT_MOST = 1_500_000
"""Samples of all curves of a page: packed some 2 MB."""

FINENESS = 3.0
"""Steps of a packed curve a standard deviation of its sensor's noise."""

FINEST = 2.0**-15
"""Least step of a packed curve, over its largest value: a screen has a tenth of that."""

LEVEL = 9
"""zlib's strongest: the page is written once and mailed many times."""

CHANNEL_UNITS: Mapping[str, tuple[str, str]] = {
    "velocity": ("m/s", "rad/s"),
    "acceleration": ("m/s²", "rad/s²"),
    "spring_force": ("N", "N m"),
    "normal_force": ("N", "N"),
    "force": ("N", "N m"),
}
"""Units of further channels, of a translation and of a rotation."""


def explorer_block(findings: Findings, names: Sequence[str]) -> Mapping[str, Any]:
    """What the page's template needs: ``data`` and ``library`` packed, ``places`` (trial -> its number), ``more``
    (trials left out, in words). ``names`` are the groups' anchors."""
    trials: list[dict[str, Any]] = []
    places: dict[str, int] = {}
    at_most = max(TRIALS_AT_MOST // max(len(findings.groups), 1), 2)
    shown = [chosen(group.trials, min(at_most, PANELS_AT_MOST)) for group in findings.groups]
    samples = samples_at_most(sum(len(few) for few in shown))
    for group, anchor, few in zip(findings.groups, names, shown, strict=True):
        for trial in few:
            places[trial.motion.name] = len(trials)
            data = trial_data(trial, samples, with_words(group.verdict))
            trials.append({**data, "group": group.label, "anchor": anchor})
    left_out = sum(len(group.trials) for group in findings.groups) - len(trials)
    return {
        "data": packed(json.dumps({"trials": trials}, separators=(",", ":"), allow_nan=False)),
        "library": library(),
        "places": places,
        "more": f"{len(trials)} of {len(trials) + left_out} trials" if left_out else "",
    }


def samples_at_most(trials: int) -> int:
    """Samples of one curve where so many trials go along, each with up to five curves.

    >>> samples_at_most(59), samples_at_most(120)
    (4000, 2500)
    """
    return min(SAMPLES_AT_MOST, VALUES_AT_MOST // (5 * max(trials, 1)))


def trial_data(trial: TrialFindings, samples: int, found: str = WITH_FOUND) -> dict[str, Any]:
    """One trial for the browser: its name and errors in words, instants ``t``, ``curves`` (as `steps_of` gives them);
    ``found`` says what the equation with more than the prescribed is.

    Every curve has a ``panel`` ("motion", or a further recorded channel) and a ``kind``: measured, before or after.
    """
    shown = response(trial)
    every = max(1, -(-trial.t.size // samples))
    noise = trial.motion.noise
    step = noise.get("displacement" if shown.words in ("displacement", "angle") else "velocity", 0.0) * shown.factor
    curves = [_curve("motion", "measured", trial.measured * shown.factor, every, step)]
    run = np.clip(trial.simulated, -reach(trial), reach(trial))  # one that leaves the recording leaves no axis
    curves.append(_curve("motion", "before", run * shown.factor, every, step))
    after = None if trial.augmented is None else (trial.measured - trial.augmented.residual) * shown.factor
    if after is not None and after.size == trial.t.size:
        curves.append(_curve("motion", "after", after, every, step))
    panels = [{"name": "motion", "words": shown.words, "unit": shown.unit}]
    for name, values, unit in further_channels(trial):
        panels.append({"name": name, "words": name.replace("_", " "), "unit": unit})
        curves.append(_curve(name, "measured", values, every, noise.get(name, 0.0)))
    factor, unit = DRAWN[trial.motion.recording.coordinate]
    return {
        "name": trial.motion.name,
        "amplitude": f"{short_number(trial.motion.amplitude * factor)} {unit}",
        "held_out": trial.held_out,
        "before": percent(trial.mismatch.nrmse),
        "found": found,
        "after": "" if trial.augmented is None else percent(trial.augmented.nrmse),
        "allowed": percent(trial.mismatch.repeatability_nrmse),
        "every": every,
        "t": steps_of(trial.t[::every], 0.0),
        "panels": panels,
        "curves": [curve for curve in curves if curve["values"]],
    }


def further_channels(trial: TrialFindings) -> list[tuple[str, Array, str]]:
    """Recorded channels beside the one the free run is compared with, at the trial's instants: name, (n,), unit."""
    motion = trial.motion
    turning = motion.recording.coordinate == "rotation"
    own = "displacement" if "displacement" in motion.recording.channels else "velocity"
    out = []
    for name in motion.recording.channels:
        if name == own or name not in CHANNEL_UNITS:
            continue
        values = motion.recorded(name)[motion.inside]
        if values.size == trial.t.size:
            out.append((name, values, CHANNEL_UNITS[name][turning]))
    return out


def _curve(panel: str, kind: str, values: Array, every: int, noise: float) -> dict[str, Any]:
    """One curve as the browser takes it; without values where it has gaps inside."""
    few = values[::every]
    finite = np.isfinite(few)
    start = int(np.argmax(finite)) if finite.any() else few.size
    whole = bool(finite[start:].all()) and start < few.size
    return {"panel": panel, "kind": kind, "start": start, "values": steps_of(few[start:], noise) if whole else {}}


def steps_of(values: Array, noise: float) -> dict[str, Any]:
    """A curve (n,) in whole steps from sample to sample: ``step`` (its unit), ``by`` (n integers, the first from zero).

    Steps are a third of the noise (`FINENESS`), and never finer than `FINEST` of the largest value.

    >>> packed_curve = steps_of(np.array([0.0, 0.5, 1.0]), 0.75)
    >>> packed_curve["step"], packed_curve["by"]
    (0.25, [0, 2, 2])
    """
    largest = float(np.max(np.abs(values))) if values.size else 0.0
    step = max(noise / FINENESS, largest * FINEST) or 1.0
    whole = np.rint(values / step).astype(np.int64)
    return {"step": step, "by": np.diff(whole, prepend=0).tolist()}


def packed(text: str) -> str:
    """A text as zlib's stream in base64: a third of its size, and no letter in it that HTML takes for its own.

    >>> zlib.decompress(base64.b64decode(packed("a < b"))).decode()
    'a < b'
    """
    return base64.b64encode(zlib.compress(text.encode("utf-8"), LEVEL)).decode("ascii")


@cache
def library() -> str:
    """plotly's own bundle from its Python package, packed; the browser unpacks it when the explorer is opened."""
    from plotly.offline import get_plotlyjs  # half a second that a page of tables alone need not wait for

    return packed(get_plotlyjs())
