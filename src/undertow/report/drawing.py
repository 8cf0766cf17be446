"""A figure as SVG text: one renderer measures its letters for the layout and then draws it.

matplotlib measures with one renderer and draws with another, and each begins with nothing known of any text; typeset
texts are parsed by both. Belongs here: that way to SVG. Does not belong here: style and the SVG's size (style.py),
where axes stand (layout.py).
"""

from __future__ import annotations

import gc
import io
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

from matplotlib.backends.backend_mixed import MixedModeRenderer
from matplotlib.backends.backend_svg import FigureCanvasSVG, RendererSVG
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import text_to_path

from undertow.report.layout import lay_out

POINTS_PER_INCH = 72
"""An SVG's own resolution: at it letters are measured for the layout."""

TEXTS_KEPT = 20_000
"""Sizes of texts that are remembered: a page of eighty trials has some thousands."""

Size = tuple[float, float, float]


@lru_cache(maxsize=TEXTS_KEPT)
def _size_of(text: str, font: FontProperties, math: bool) -> Size:
    """Width, height and descent of a text in points."""
    width, height, descent = text_to_path.get_text_width_height_descent(text, font, math)
    return float(width), float(height), float(descent)


class _Renderer(RendererSVG):
    """matplotlib's SVG, with sizes of texts that are known from one figure to the next."""

    def get_text_width_height_descent(self, s: str, prop: FontProperties, ismath: Any) -> Size:
        """Width, height and descent of a text in points."""
        return _size_of(s, prop.copy(), bool(ismath))


class _Canvas(FigureCanvasSVG):
    """A canvas whose layout measures with the renderer that draws."""

    def __init__(self, figure: Figure, stream: io.StringIO) -> None:
        super().__init__(figure)
        width, height = (float(side) for side in figure.get_size_inches())
        svg = _Renderer(width * POINTS_PER_INCH, height * POINTS_PER_INCH, stream, image_dpi=figure.dpi,
                        metadata={"Date": None})  # type: ignore[no-untyped-call]  # fmt: skip
        self._renderer: Any = MixedModeRenderer(figure, width, height, figure.dpi, svg)  # type: ignore[no-untyped-call]

    def get_renderer(self) -> Any:
        """The renderer, as matplotlib's layout asks for it."""
        return self._renderer


@contextmanager
def without_collection() -> Iterator[None]:
    """No search for unreachable objects inside the block: artists refer to each other by thousands, all in use."""
    was = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was:
            gc.enable()


def drawn(figure: Figure) -> str:
    """A figure laid out and drawn as SVG text with its metadata; equal bytes for equal figures."""
    stream = io.StringIO()
    figure.set_dpi(POINTS_PER_INCH)
    renderer = _Canvas(figure, stream).get_renderer()
    lay_out(figure)
    figure.draw(renderer)
    renderer.finalize()
    return stream.getvalue()
