"""The picture of a harmonic set: measured amplitudes and phases by frequency, and the fitted equation's both ways.

Belongs here: that picture. Does not belong here: what it shows (campaign/response), the page (driven_page.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from undertow.recording.recording import Array
from undertow.report.style import new_figure, page_style, svg_text


@dataclass(frozen=True)
class DrawnCurve:
    """Steady motions of an equation swept one way: ``frequency_Hz``, ``amplitude``, ``phase`` (deg), each (n,)."""

    label: str
    frequency_Hz: Array
    amplitude: Array
    phase: Array


@dataclass(frozen=True)
class DrawnSet:
    """One trial's points as recorded, phases in deg; ``rising`` and ``unseen`` (held out) are masks (n,)."""

    name: str
    unit: str
    frequency_Hz: Array
    amplitude: Array
    phase: Array
    rising: np.ndarray
    unseen: np.ndarray
    curves: Sequence[DrawnCurve]


def set_picture(drawn: DrawnSet) -> str:
    """Amplitude above, phase below: triangles are measured (up or down as the frequency went, hollow where nobody
    fitted them), lines are the equation's."""
    with page_style():
        figure = new_figure(8.0, 5.0)
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 2))
        for curve, style in zip(drawn.curves, ("-", "--"), strict=False):
            line = above.plot(curve.frequency_Hz, curve.amplitude, style, lw=1.0, label=curve.label)[0]
            below.plot(curve.frequency_Hz, curve.phase, style, lw=1.0, color=line.get_color())
        for way, marker, word in ((True, "^", "upward"), (False, "v", "downward")):
            for apart in (False, True):
                here = (drawn.rising == way) & (drawn.unseen == apart)
                if not here.any():
                    continue
                look = {"ls": "none", "marker": marker, "ms": 4.0, "color": "0.4"}
                look |= {"mfc": "none"} if apart else {}
                label = f"measured {word}{', not fitted' if apart else ''}"
                above.plot(drawn.frequency_Hz[here], drawn.amplitude[here], label=label, **look)
                below.plot(drawn.frequency_Hz[here], drawn.phase[here], **look)
        above.set_ylabel(f"amplitude, {drawn.unit}")
        above.legend()
        below.set_ylabel("phase, deg")
        below.set_xlabel("frequency, Hz")
        said = f"{escape(drawn.name)}: {drawn.frequency_Hz.size} points"
        return f"<figure>{svg_text(figure)}<figcaption>{said}</figcaption></figure>"
