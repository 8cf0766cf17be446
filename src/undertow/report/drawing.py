"""A figure as SVG text: where its axes stand, and one renderer that measures its letters for the layout and draws it.

matplotlib measures with one renderer and draws with another, and each begins with nothing known of any text; typeset
texts are parsed by both. The second pass of its constrained layout repeats the first with the ticks that the new sizes
give, and takes as long, a tenth of a page's time: it is left out where it changes nothing.

Belongs here: that way to SVG. Does not belong here: style and the SVG's size (style.py).
"""

from __future__ import annotations

import gc
import io
from collections.abc import Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

from matplotlib import _constrained_layout
from matplotlib.backends.backend_mixed import MixedModeRenderer
from matplotlib.backends.backend_svg import FigureCanvasSVG, RendererSVG
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.textpath import text_to_path

Ticks = list[tuple[str, ...]]

passes: Any = _constrained_layout
"""Its parts, of which matplotlib promises nothing: `lay_out` does without where they have changed."""


def lay_out(figure: Figure) -> None:
    """Place the axes of a figure with a constrained layout, and switch the layout off, so that drawing keeps them."""
    engine = figure.get_layout_engine()
    if engine is None or not figure.axes:
        return
    if not (isinstance(engine, ConstrainedLayoutEngine) and _one_pass(figure, engine.get())):
        engine.execute(figure)
    figure.set_layout_engine("none")


def _one_pass(figure: Figure, asked: dict[str, Any]) -> bool:
    """The first pass; False where a second one would find other ticks or move a colour bar, or where this matplotlib
    has no such passes."""
    if any(hasattr(place, "_colorbar") for place in figure.axes):
        return False
    pads = {name: asked[name] for name in ("h_pad", "w_pad")}
    inches = {"h_pad": pads["h_pad"] / figure.get_figheight(), "w_pad": pads["w_pad"] / figure.get_figwidth()}
    spaces = {name: asked[name] for name in ("hspace", "wspace")}
    before = _ticks(figure)
    try:
        renderer = _renderer(figure)
        grids = passes.make_layoutgrids(figure, None, rect=asked["rect"])
        if asked.get("compress") or not grids["hasgrids"]:
            return False
        passes.make_layout_margins(grids, figure, renderer, **inches, **spaces)
        passes.make_margin_suptitles(grids, figure, renderer, **inches)
        passes.match_submerged_margins(grids, figure)
        grids[figure].update_variables()
        if not passes.check_no_collapsed_axes(grids, figure):
            return False
        passes.reposition_axes(grids, figure, renderer, **inches, **spaces)
    except (AttributeError, TypeError):
        return False
    return _ticks(figure) == before


def _renderer(figure: Any) -> Any:
    """What measures a figure's texts."""
    return figure._get_renderer()


def _ticks(figure: Figure) -> Ticks:
    """The texts at all ticks of a figure."""
    axes = [axis for place in figure.axes for axis in (place.xaxis, place.yaxis)]
    return [tuple(axis.get_major_formatter().format_ticks(list(axis.get_majorticklocs()))) for axis in axes]


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
