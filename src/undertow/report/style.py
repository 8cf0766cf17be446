"""How figures look: colours that colour-blind readers can distinguish, type sizes, markers, and the way to SVG and PNG.

Belongs here: style and saving. Does not belong here: what is drawn (figures.py, trial_figures.py).
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

from matplotlib import rc_context
from matplotlib.axis import Axis
from matplotlib.figure import Figure

from undertow.report.drawing import drawn
from undertow.report.numbers import short_number
from undertow.report.writing import true_minus

BLUE, ORANGE, GREEN, VERMILLION = "#0072B2", "#E69F00", "#009E73", "#D55E00"
PURPLE, SKY, INK, GREY, PALE = "#CC79A7", "#56B4E9", "#222222", "#777777", "#d9d9d9"
"""Okabe and Ito's palette (jfly.uni-koeln.de/color, 2008), and greys; vermillion is kept for what is not explained."""

NOT_EXPLAINED, PRESCRIBED = VERMILLION, BLUE
"""What is not explained (a trial, a number, a residual); the free run as prescribed, in every figure."""

_METHOD_COLOURS: Mapping[str, str] = {
    "output_error": INK,
    "sindy": BLUE,
    "method1": ORANGE,
    "method2": GREEN,
    "decay": PURPLE,
    "method2_printed": GREY,
}
_SPARE_COLOURS = (SKY, "#8C6D31", "#7B4FA3")
_MARKERS = ("o", "s", "^", "D", "v", "P", "X")

SETTINGS: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "axes.titlelocation": "left",
    "axes.labelsize": 9.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.7,
    "axes.formatter.use_mathtext": True,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e6e6e6",
    "grid.linewidth": 0.6,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "legend.fontsize": 8.0,
    "legend.frameon": False,
    "lines.linewidth": 0.9,
    "path.simplify_threshold": 0.2,
    "svg.hashsalt": "undertow",
    "svg.fonttype": "none",
    "mathtext.fontset": "dejavusans",
    "figure.constrained_layout.use": True,
}
"""matplotlib settings of every figure, at the page's width of eleven inches."""

DRAWN: Mapping[str, tuple[float, str]] = {"translation": (1e3, "mm"), "rotation": (180.0 / math.pi, "°")}
"""Drawn units a metre or a radian, and what they are called, by coordinate."""

SVG_DECIMALS = 1
"""Decimals of a point (1/72 inch) in an SVG: a tenth is a seventh of a pixel at the page's size."""


def method_colour(method: str, methods: tuple[str, ...] = ()) -> str:
    """A method's colour, the same in every figure; methods of a user's own share the spare ones in order.

    >>> method_colour("sindy"), method_colour("mine", ("sindy", "mine"))
    ('#0072B2', '#56B4E9')
    """
    if method in _METHOD_COLOURS:
        return _METHOD_COLOURS[method]
    own = [name for name in methods if name not in _METHOD_COLOURS]
    return _SPARE_COLOURS[own.index(method) % len(_SPARE_COLOURS)] if method in own else _SPARE_COLOURS[0]


def series_marker(index: int) -> str:
    """Marker of the i-th series (spring), the same in every figure."""
    return _MARKERS[index % len(_MARKERS)]


TICKS_AT_MOST = 5
"""Numbers on a log axis that do not run into each other on a narrow panel."""


def plain_log_ticks(axis: Axis, values: Sequence[float]) -> None:
    """Ticks of a log axis that shows these positive values, in plain numbers.

    At 1, 2, 5 of each decade, or fewer over a wide range; at the ends where that gives fewer than two.
    """
    if not values:
        return
    low, high = min(values) / 1.3, max(values) * 1.3
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    for steps, every in (((1, 2, 5), 1), ((1, 3), 1), ((1,), 1), ((1,), 2), ((1,), 4)):
        ticks = [step * 10.0**decade for decade in decades if decade % every == 0 for step in steps]
        shown = [tick for tick in ticks if low <= tick <= high]
        if len(shown) <= TICKS_AT_MOST:
            break
    if len(shown) < 2:
        shown = sorted({float(f"{min(values):.3g}"), float(f"{max(values):.3g}")})
    axis.set_ticks(shown, [short_number(tick, 6).removeprefix("1 × ") for tick in shown])
    axis.set_ticks([], minor=True)


@contextmanager
def page_style() -> Iterator[None]:
    """Axes made inside the block have the page's style."""
    with rc_context(SETTINGS):
        yield


def new_figure(width_in: float, height_in: float) -> Figure:
    """An empty figure in the page's style; it belongs to no window and to no global list."""
    with rc_context(SETTINGS):
        return Figure(figsize=(width_in, height_in), layout="constrained")


_WRITTEN = re.compile(r"(?<=>)[^<>]+(?=</(?:text|tspan)>)")
"""What is written in a figure, as letters."""


def svg_text(figure: Figure, outlines: bool = False) -> str:
    """The figure as SVG, equal bytes for equal figures (no date, fixed identifiers).

    Letters are text in the reader's font; with ``outlines`` they are drawn, as typeset equations need.
    """
    with rc_context(SETTINGS | {"svg.fonttype": "path" if outlines else "none"}):
        return _WRITTEN.sub(lambda found: true_minus(found.group()), _compact(drawn(figure)))


_THEMED: Mapping[str, str] = {
    INK.lower(): "--fig-ink", "#000000": "--fig-ink", GREY: "--fig-grey", PALE: "--fig-pale", "#e6e6e6": "--fig-grid",
    "#ffffff": "--paper", BLUE.lower(): "--fig-blue", GREEN.lower(): "--fig-green", VERMILLION.lower(): "--fig-alarm",
}  # fmt: skip
"""What the page calls the colours that must differ on dark and on light paper; all others serve on both."""

_THEMED_COLOUR = re.compile("|".join(map(re.escape, _THEMED)))


def in_theme(svg: str) -> str:
    """A figure for a page: colours by the page's names, so that they follow its theme. Files keep the colours.

    >>> in_theme('style="fill: none; stroke: #222222"')
    'style="fill: none; stroke: var(--fig-ink)"'
    """
    return _THEMED_COLOUR.sub(lambda found: f"var({_THEMED[found.group()]})", svg)


_COORDINATES = re.compile(r'(?<= )(d|x|y|points)="[^"]*"')
_LONG_NUMBER = re.compile(r"-?\d+\.\d+")


def _compact(svg: str) -> str:
    """The same drawing in a third of the bytes: coordinates to SVG_DECIMALS, no metadata, no indentation."""
    svg = re.sub(r"\s*<metadata>.*?</metadata>", "", svg, count=1, flags=re.DOTALL)
    svg = re.sub(r"\n\s+", "\n", svg)
    return _COORDINATES.sub(lambda found: _LONG_NUMBER.sub(_rounded, found.group()).replace("\n", ""), svg)


def _rounded(number: re.Match[str]) -> str:
    text = f"{float(number.group()):.{SVG_DECIMALS}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text
