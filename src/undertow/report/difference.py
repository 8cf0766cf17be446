"""A simulation against a recording on one page, and as JSON for a machine.

Belongs here: differ.json, differ.html and its two figures. Does not belong here: the comparison (campaign/differ.py).
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from markupsafe import Markup
from matplotlib.axes import Axes

from undertow.discrepancy.difference import Difference, Side
from undertow.discrepancy.words import percent
from undertow.quantities import Estimate
from undertow.report.style import BLUE, INK, VERMILLION, new_figure, page_style, svg_text
from undertow.report.verdict_file import plain
from undertow.report.wording import parameter_name, parameter_words, reason_words
from undertow.report.writing import rendered, write_text

VERSION = 1
"""Version of differ.json's shape."""

WIDTH_IN, HEIGHT_IN = 11.0, 3.0
"""A figure over the whole page, inch."""


def write_difference(difference: Difference, folder: Path) -> Path:
    """Write differ.json and the self-contained differ.html; the page's path."""
    text = json.dumps(difference_json(difference), indent=1, allow_nan=False, ensure_ascii=False)
    write_text(folder / "differ.json", text)
    return write_text(folder / "differ.html", difference_page(difference))


def difference_json(difference: Difference) -> dict[str, Any]:
    """The comparison as plain values; what is not finite is None."""
    d, m, cycles = difference, difference.mismatch, difference.cycles
    names = {"simulation": d.simulation, "recording": d.recording}
    return {
        "version": VERSION,
        "sentence": d.sentence,
        "lacks": list(d.lacks),
        "extra": list(d.extra),
        "differs_in_number": list(d.more),
        "found_by": "equation" if d.by_equation else "search",
        "nrmse": plain(m.nrmse),
        "repeatability_nrmse": plain(m.repeatability_nrmse),
        "sensor_floor_nrmse": plain(m.sensor_floor_nrmse),
        "terms": [
            {
                "name": r.name, "simulation": _one(r.simulation), "recording": _one(r.recording),
                "sigmas": plain(r.sigmas),
            }
            for r in d.rows
        ],
        "equations": {name: _equation(side) for name, side in names.items()},
        "where": {
            "time": {"early": plain(m.share_early), "middle": plain(m.share_middle), "late": plain(m.share_late)},
            "line": {"frequency_hz": plain(m.line_frequency_hz), "share": plain(m.line_share)},
            "sidebands": plain(vars(d.bands)),
            "amplitude_exponent": plain(m.amplitude_exponent),
            "cycles": None if cycles is None else {name: plain(v.tolist()) for name, v in vars(cycles).items()},
        },
        "search": {
            "status": d.recording.verdict.status,
            "verdict": list(d.recording.verdict.verdict),
            "alternatives": [list(names) for names in d.recording.verdict.alternatives],
            "confidence": plain(d.recording.verdict.confidence),
            "parameters": plain(d.recording.verdict.parameters),
            "simulation_has": list(d.simulation.verdict.verdict),
        },
        "notes": list(d.notes),
    }


def _one(estimate: Estimate | None) -> Any:
    return None if estimate is None else plain(estimate)


def _equation(side: Side) -> dict[str, Any]:
    equation = side.fit.equation()
    return {
        "text": equation.text(side.fit.equation_errors()), "latex": equation.to_latex(numbers=True),
        "terms": [t.name for t in side.terms], "nrmse_of_its_own_motion": plain(side.run.nrmse),
    }  # fmt: skip


def difference_page(difference: Difference) -> str:
    """The page as text; everything in it, nothing fetched."""
    d = difference
    return rendered(
        "difference.html.j2",
        sentence=d.sentence,
        rows=[_row(r.name, r.simulation, r.recording, r.sigmas) for r in d.rows],
        found=_found(d.recording.verdict.parameters) if not d.by_equation else [],
        equations=[
            (name, side.fit.equation().text(side.fit.equation_errors()), percent(side.run.nrmse))
            for name, side in (("simulation", d.simulation), ("recording", d.recording))
        ],
        shares=_where(d),
        figures=[Markup(svg) for svg in _figures(d)],
        search=reason_words(d.recording.verdict.sentence),
        rejected=d.recording.verdict.rejected,
        notes=d.notes,
    )


def _row(name: str, one: Estimate | None, other: Estimate | None, sigmas: float) -> Mapping[str, str]:
    far = f"{sigmas:.1f}" if math.isfinite(sigmas) else ""
    return {
        "name": parameter_name(name).words, "simulation": "-" if one is None else str(one),
        "recording": "-" if other is None else str(other), "sigmas": far,
        "tone": "open" if one is None or other is None or sigmas > 3.0 else "",
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
    rows = [("of the difference in the first, second, last third", thirds)]
    if math.isfinite(m.line_frequency_hz):
        line = f"{m.line_frequency_hz:.3g} Hz, {percent(m.line_share)}"
        rows.append(("its strongest line beside the body's own", line))
        lower, upper = percent(d.bands.lower_share), percent(d.bands.upper_share)
        rows.append((f"sidebands {d.bands.spacing_hz:.3g} Hz below and above", f"{lower}, {upper}"))
    if math.isfinite(m.amplitude_exponent):
        rows.append(("it grows as amplitude to the power", f"{m.amplitude_exponent:.2g}"))
    return rows


def _figures(d: Difference) -> list[str]:
    """Motions above each other, then frequency and damping by amplitude."""
    with page_style():
        figure = new_figure(WIDTH_IN, HEIGHT_IN)
        draw_motions(d, figure.subplots())
        drawn = [svg_text(figure)]
        if d.cycles is not None and d.cycles.time.size > 1:
            figure = new_figure(WIDTH_IN, HEIGHT_IN)
            left, right = figure.subplots(1, 2)
            draw_cycles(d, left, "frequency_hz", "frequency (Hz)")
            draw_cycles(d, right, "damping_ratio", "damping ratio")
            drawn.append(svg_text(figure))
    return drawn


def draw_motions(d: Difference, axes: Axes) -> Axes:
    """The recording, the simulation's equation let go from the same release, and what is between them."""
    run = d.released or d.run
    axes.plot(run.t, run.measured, color=INK, label="recording")
    axes.plot(run.t, run.simulated, color=BLUE, label="simulation's equation, same release")
    axes.plot(run.t, run.residual, color=VERMILLION, label="difference")
    axes.set_xlabel("time after the release (s)")
    axes.set_ylabel(f"displacement ({d.recording.motion.recording.unit('displacement')})")
    axes.legend(ncols=3, loc="upper right")
    return axes


def draw_cycles(d: Difference, axes: Axes, what: str, label: str) -> Axes:
    """Frequency or damping of each cycle against its amplitude, recording and simulation's equation."""
    if d.cycles is not None:
        size, theirs = d.cycles.amplitude, getattr(d.cycles, f"{what}_simulated")
        axes.plot(size, getattr(d.cycles, what), "o", color=INK, label="recording")
        axes.plot(size, theirs, "s", color=BLUE, label="simulation's equation")
    axes.set_xlabel(f"amplitude of the cycle ({d.recording.motion.recording.unit('displacement')})")
    axes.set_ylabel(label)
    axes.legend()
    return axes
