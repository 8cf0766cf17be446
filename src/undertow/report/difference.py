"""A simulation against a recording on one page, and as JSON for a machine.

Belongs here: differ.json, differ.html and its two figures. Does not belong here: the comparison (campaign/differ.py).
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from markupsafe import Markup
from matplotlib.axes import Axes

from undertow.discrepancy.difference import FAR, Difference, Side
from undertow.discrepancy.naming import in_words
from undertow.discrepancy.words import either, least_sets, percent, spelled
from undertow.quantities import Estimate
from undertow.report.numbers import plain_number, printed_unit, short_number
from undertow.report.style import BLUE, INK, VERMILLION, in_theme, new_figure, page_style, svg_text
from undertow.report.trial_figures import Response, response_of, time_axes
from undertow.report.verdict_file import plain
from undertow.report.wording import parameter_name, parameter_words, reason_words, rejected_words
from undertow.report.writing import rendered, write_text

VERSION = 1
"""Version of differ.json's shape."""

WIDTH_IN, HEIGHT_IN = 11.0, 3.0
"""A figure over the whole page, inch."""

MOTIONS = (
    "The simulation's equation, released where and when the recording was: where the orange curve is as large as the "
    "recording's, the equation predicts nothing of the motion. The errors in the table are this one or smaller: for "
    "them release, clock and rest position are adjusted to the recording."
)
CYCLES = (
    "Frequency and damping of every full cycle, large ones at the right: points off the squares show at which "
    "amplitude the two differ. A point without a square: the simulation's equation has come to rest by then."
)
"""Captions of the figures."""


def write_difference(difference: Difference, folder: Path) -> Path:
    """Write differ.json and the self-contained differ.html; the page's path."""
    text = json.dumps(difference_json(difference), indent=1, allow_nan=False, ensure_ascii=False)
    write_text(folder / "differ.json", text)
    return write_text(folder / "differ.html", difference_page(difference))


def difference_json(difference: Difference) -> dict[str, Any]:
    """The comparison as plain values; what is not finite is None."""
    d, m, cycles = difference, difference.mismatch, difference.cycles
    turns = d.recording.motion.recording.coordinate == "rotation"
    verdict, names = d.recording.verdict, {"simulation": d.simulation, "recording": d.recording}
    said: dict[str, Any] = plain({
        "version": VERSION,
        "sentence": d.sentence,
        "lacks": d.lacks,
        "extra": d.extra,
        "differs_in_number": d.more,
        "found_by": "equation" if d.by_equation else "search",
        "nrmse": m.nrmse,
        "repeatability_nrmse": m.repeatability_nrmse,
        "sensor_floor_nrmse": m.sensor_floor_nrmse,
        "terms": [vars(row) for row in d.rows],
        "equations": {name: _equation(side, turns) for name, side in names.items()},
        "where": {
            "time": {"early": m.share_early, "middle": m.share_middle, "late": m.share_late},
            "line": {"frequency_hz": m.line_frequency_hz, "share": m.line_share},
            "sidebands": vars(d.bands),
            "amplitude_exponent": m.amplitude_exponent,
            "cycles": None if cycles is None else {name: values.tolist() for name, values in vars(cycles).items()},
        },
        "search": {
            "status": verdict.status,
            "verdict": verdict.verdict,
            "alternatives": verdict.alternatives,
            "confidence": verdict.confidence,
            "parameters": verdict.parameters,
            "simulation_has": d.simulation.verdict.verdict,
        },
        "notes": d.notes,
    })  # fmt: skip
    return said


def _equation(side: Side, rotation: bool) -> dict[str, Any]:
    equation = side.fit.equation()
    return {
        "text": equation.text(side.fit.equation_errors()), "latex": equation.to_latex(numbers=True, rotation=rotation),
        "terms": [t.name for t in side.terms], "nrmse_of_its_own_motion": side.run.nrmse,
    }  # fmt: skip


def difference_page(difference: Difference) -> str:
    """The page as text; everything in it, nothing fetched."""
    d = difference
    return rendered(
        "difference.html.j2",
        lead=lead_of(d),
        sure=sure_of(d),
        errors=_errors(d),
        cycles=d.cycles.sentence() if d.cycles is not None else "",
        rows=[_row(r.name, r.simulation, r.recording, r.sigmas) for r in d.rows],
        found=_found(d.recording.verdict.parameters) if not d.by_equation else [],
        equations=[
            (name, _equation_words(side), percent(side.run.nrmse))
            for name, side in (("simulation", d.simulation), ("recording", d.recording))
        ],
        shares=_where(d),
        figures=[(Markup(in_theme(svg)), caption) for svg, caption in _figures(d)],
        search=_search_words(d.recording.verdict.sentence),
        rejected=[
            (spelled(r.name), _alone(rejected_words(r.name, r.because))) for r in d.recording.verdict.rejected
        ],
        scatter=", ".join(
            f"{symbol.replace('mu', 'μ')} {short_number(100.0 * share, 2)} %" for symbol, share in d.scatter.items()
        ),
        notes=d.notes,
    )


def lead_of(d: Difference) -> str:
    """What the simulation lacks, and by how much the error falls with it: the page's first sentence."""
    said = listed_in_words([n for n in d.lacks if n != "unknown"], d.more)
    extra = f", and has {listed_in_words(d.extra)}, which the recording does not show" if d.extra else ""
    start, missed = "The simulation lacks", percent(d.mismatch.nrmse)
    if not d.lacks:
        far = [parameter_name(row.name).words for row in d.rows if row.sigmas > FAR]
        but = f", but differs in {', '.join(far)}" if far else ""
        does = "misses" if d.mismatch.missing else "stays within"
        return f"{start} no law that this recording shows{but}{extra}: its equation {does} {missed} of the motion."
    if not said:
        return f"{start} something that no suspect explains{extra}: its equation misses {missed} of the motion."
    before, after = _before_after(d)
    falls = f"with it the error falls from {before} to {after}" if after else f"its equation misses {missed}"
    return f"{start} {said}{extra}: {falls} of the motion."


def listed_in_words(names: Sequence[str], more: Sequence[str] = ()) -> str:
    """Names in words; of those in ``more`` the simulation has some, but not enough."""
    return " and ".join(f"{'enough ' if n in more else ''}{in_words(n, alone=True)}" for n in names)


def _before_after(d: Difference) -> tuple[str, str]:
    """Errors without and with what is lacking: of both equations, or of the simulation's form in the search."""
    found = d.recording.verdict
    if d.by_equation or d.more:
        return percent(d.mismatch.nrmse), percent(d.recording.run.nrmse)
    after = percent(found.augmented.nrmse) if found.augmented is not None else "-"
    return percent(found.baseline.nrmse), after.removesuffix("-")


def sure_of(d: Difference) -> str:
    """How sure what is lacking is; empty where nothing is named."""
    found = d.recording.verdict
    if not set(d.lacks) - {"unknown"}:
        return ""
    if d.by_equation:
        return "the recording's own equation needs it; no other recording was there to prove it"
    if "unknown" in found.verdict:
        return "it is the closest of what was tried and leaves more than noise; one recording does not prove it"
    rivals = [listed_in_words(names) for names in least_sets((found.verdict, *found.alternatives))[1:]]
    if rivals and not d.more:
        return f"this recording cannot tell it from {either(rivals)}"
    return "found in this one recording; no other was there to prove it"


def _errors(d: Difference) -> list[tuple[str, str]]:
    """Every error of the page with what it is of, each a share of the recording's motion."""
    found = d.recording.verdict
    rows = [
        ("simulation's equation with its own numbers", percent(d.mismatch.nrmse)),
        ("the same form of equation, its numbers fitted to the recording", percent(found.baseline.nrmse)),
    ]
    if found.augmented is not None and not d.by_equation and set(d.lacks) - {"unknown", *d.more}:
        rows.append(("that form with what is lacking", percent(found.augmented.nrmse)))
    return [
        *rows,
        ("the equation that the evidence keeps for the recording alone", percent(d.recording.run.nrmse)),
        ("for comparison: what a repeated test would differ by", percent(d.mismatch.repeatability_nrmse)),
    ]


def _equation_words(side: Side) -> str:
    text = side.fit.equation().text(side.fit.equation_errors())
    return printed_unit(text.replace("x''", "ẍ").removeprefix("1 "))


def _alone(text: str) -> str:
    """A sentence about trials where there is one recording."""
    return text.replace(" in 1 of 1 trials", "").replace("the trials it was fitted to", "this recording")


def _search_words(sentence: str) -> str:
    """The search's sentence: its limit is what one recording allows, and no repeatability."""
    text = reason_words(sentence.removeprefix("recording: "))
    text = text.replace("within repeatability", "within what is allowed").replace("repeatability", "allowed")
    return _alone(text[:1].upper() + text[1:])


def _row(name: str, one: Estimate | None, other: Estimate | None, sigmas: float) -> Mapping[str, str]:
    far = plain_number(sigmas, 2) if math.isfinite(sigmas) else ""
    return {
        "name": parameter_name(name).words, "simulation": "-" if one is None else printed_unit(str(one)),
        "recording": "-" if other is None else printed_unit(str(other)), "sigmas": far,
        "tone": "open" if one is None or other is None or sigmas > FAR else "",
    }  # fmt: skip


def _found(parameters: Mapping[str, object]) -> list[tuple[str, str]]:
    """What the search found beside the simulation's form: name and number, one a line."""
    out = []
    for name, found in parameters.items():
        for one in found if isinstance(found, list) else [found]:
            if isinstance(one, Mapping):
                out += [(parameter_words(f"{name}.{key}"), str(value).removesuffix(" 1")) for key, value in one.items()]
    return out


def _where(d: Difference) -> list[tuple[str, str]]:
    m = d.mismatch
    thirds = f"{percent(m.share_early)}, {percent(m.share_middle)}, {percent(m.share_late)}"
    rows = [("share of the squared difference in the first, second and last third of the motion", thirds)]
    if math.isfinite(m.line_frequency_hz):
        line = f"{m.line_frequency_hz:.3g} Hz, {percent(m.line_share)}"
        rows.append(("its strongest frequency beside the body's own, and its share of the squared difference", line))
        lower, upper = percent(d.bands.lower_share), percent(d.bands.upper_share)
        rows.append((f"shares {d.bands.spacing_hz:.3g} Hz below and above the body's frequency", f"{lower}, {upper}"))
    if math.isfinite(m.amplitude_exponent):
        rows.append(("power of the amplitude with which it grows from cycle to cycle", f"{m.amplitude_exponent:.2g}"))
    return rows


def _figures(d: Difference) -> list[tuple[str, str]]:
    """Motions above each other, then frequency and damping by amplitude, each with its caption."""
    with page_style():
        figure = new_figure(WIDTH_IN, HEIGHT_IN)
        axes = draw_motions(d, figure.subplots())
        figure.legend(handles=list(axes.lines), loc="outside upper left", ncols=3)
        drawn = [(svg_text(figure), MOTIONS)]
        if d.cycles is not None and d.cycles.time.size > 1:
            figure = new_figure(WIDTH_IN, HEIGHT_IN)
            left, right = figure.subplots(1, 2)
            draw_cycles(d, left, "frequency_hz", "frequency of a cycle (Hz)")
            draw_cycles(d, right, "damping_ratio", "damping of a cycle (% of critical)", 100.0)
            figure.legend(handles=list(left.lines), loc="outside upper left", ncols=2)
            drawn.append((svg_text(figure), CYCLES))
    return drawn


def _drawn(d: Difference) -> Response:
    return response_of(d.recording.motion.recording)


def draw_motions(d: Difference, axes: Axes) -> Axes:
    """The recording, the simulation's equation let go from the same release, and what is between them."""
    run, shown = d.released or d.run, _drawn(d)
    axes.plot(run.t, shown.factor * run.measured, color=INK, label="recording")
    axes.plot(run.t, shown.factor * run.simulated, color=BLUE, label="simulation's equation, same release")
    axes.plot(run.t, shown.factor * run.residual, color=VERMILLION, lw=0.7, label="recording minus simulation")
    time_axes(axes, f"{shown.words} ({shown.unit})")
    return axes


def draw_cycles(d: Difference, axes: Axes, what: str, label: str, factor: float = 1.0) -> Axes:
    """Frequency or damping of each cycle, times ``factor``, by amplitude: recording and simulation's equation."""
    shown = _drawn(d)
    if d.cycles is not None:
        size, theirs = shown.factor * d.cycles.amplitude, factor * getattr(d.cycles, f"{what}_simulated")
        axes.plot(size, factor * getattr(d.cycles, what), "o", ms=4.0, color=INK, label="recording")
        axes.plot(size, theirs, "s", ms=4.0, mfc="none", color=BLUE, label="simulation's equation, at the same time")
    axes.set(xlabel=f"amplitude of the recording's cycle ({shown.unit})", ylabel=label)
    return axes
