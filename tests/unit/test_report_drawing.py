"""A figure as SVG: what matplotlib itself would draw, with sizes of texts known from figure to figure."""

from __future__ import annotations

import gc
import io

import numpy as np
import pytest
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import text_to_path

from undertow.report import drawing
from undertow.report.style import new_figure, page_style


def figure_with_texts():
    figure = new_figure(6.0, 2.5)
    axes = figure.subplots()
    axes.plot(np.linspace(0.0, 1.0, 5), label="measured")
    axes.set_ylabel("added mass (kg)")
    axes.set_title(r"$m_a\,\ddot{x}$")
    axes.legend()
    return figure


def test_the_drawing_is_matplotlibs_own_once_the_axes_stand():
    with page_style():
        ours, theirs = figure_with_texts(), figure_with_texts()
        drawn = drawing.drawn(ours)
        theirs.set_dpi(drawing.POINTS_PER_INCH)
        theirs.set_layout_engine("none")
        theirs.axes[0].set_position(ours.axes[0].get_position())
        stream = io.StringIO()
        FigureCanvasSVG(theirs).print_svg(stream, metadata={"Date": None})
    assert drawn == stream.getvalue()


@pytest.mark.parametrize("text", ["0.25", r"$\ddot{x}$"])
@pytest.mark.parametrize("size", [7.5, 12.0])
def test_a_text_is_as_large_as_matplotlib_measures_it(text, size):
    font = FontProperties(size=size)
    expected = text_to_path.get_text_width_height_descent(text, font, "$" in text)
    assert drawing._size_of(text, font, "$" in text) == pytest.approx(expected, rel=1e-12)


def test_a_text_is_measured_once_for_all_figures():
    drawing._size_of.cache_clear()
    with page_style():
        drawing.drawn(figure_with_texts())
        known = drawing._size_of.cache_info().misses
        drawing.drawn(figure_with_texts())
    assert drawing._size_of.cache_info().misses == known > 0


def test_equal_figures_give_equal_bytes():
    with page_style():
        assert drawing.drawn(figure_with_texts()) == drawing.drawn(figure_with_texts())


def _fail_inside():
    with drawing.without_collection():
        assert not gc.isenabled()
        raise ValueError("inside")


@pytest.mark.parametrize("enabled", [True, False])
def test_collection_is_as_it_was_after_the_block_even_if_that_fails(enabled):
    was = gc.isenabled()
    try:
        (gc.enable if enabled else gc.disable)()
        with pytest.raises(ValueError, match="inside"):
            _fail_inside()
        assert gc.isenabled() is enabled
    finally:
        (gc.enable if was else gc.disable)()
