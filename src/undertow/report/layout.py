"""Where a figure's axes stand: matplotlib's constrained layout, whose second pass is left out where it changes nothing.

The second pass repeats the first with the ticks that the new sizes give, and takes as long: a tenth of a page's time.

Belongs here: that decision. Does not belong here: sizes and styles (style.py).
"""

from __future__ import annotations

from typing import Any

from matplotlib import _constrained_layout
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

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
