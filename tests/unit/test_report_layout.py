"""One pass of the layout where a second one would change nothing: the same places, in half of the time."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.ticker import FixedLocator, NullLocator

from undertow.report import drawing
from undertow.report.drawing import lay_out
from undertow.report.style import new_figure


def drawn(values: np.ndarray):
    figure = new_figure(11.0, 3.0)
    left, right = figure.subplots(1, 2)
    left.plot(values)
    left.set_ylabel("displacement (m)")
    right.semilogy(np.abs(values) + 1e-6)
    right.set_title("right")
    return figure


def places(figure) -> np.ndarray:
    return np.array([axes.get_position().bounds for axes in figure.axes])


@pytest.mark.parametrize("size", [1.0, 1e-5, 123456.0])
def test_one_pass_gives_the_places_of_two(size):
    values = size * np.sin(np.linspace(0.0, 6.0, 50))
    ours, theirs = drawn(values), drawn(values)
    theirs.get_layout_engine().execute(theirs)
    lay_out(ours)
    assert places(ours) == pytest.approx(places(theirs), abs=2e-3)  # a fiftieth of an inch
    assert not isinstance(ours.get_layout_engine(), drawing.ConstrainedLayoutEngine)


@pytest.mark.parametrize("fault", [AttributeError, TypeError])
def test_a_matplotlib_without_these_passes_lays_out_as_it_does(monkeypatch, fault):
    values = np.sin(np.linspace(0.0, 6.0, 50))
    ours, theirs = drawn(values), drawn(values)
    theirs.get_layout_engine().execute(theirs)

    def absent(*_, **__):
        raise fault

    monkeypatch.setattr(drawing, "_renderer", absent)
    lay_out(ours)
    assert places(ours) == pytest.approx(places(theirs), abs=1e-12)


def test_other_ticks_after_the_first_pass_ask_for_a_second(monkeypatch):
    figure, asked = drawn(np.arange(5.0)), []
    changing = iter([[("1", "2")], [("1", "2", "3")]])
    monkeypatch.setattr(drawing, "_ticks", lambda _: next(changing))
    monkeypatch.setattr(drawing.ConstrainedLayoutEngine, "execute", lambda self, figure: asked.append(figure))
    lay_out(figure)
    assert asked == [figure]


def test_an_axis_without_ticks_has_no_tick_texts():
    figure = new_figure(3.0, 2.0)
    axes = figure.add_subplot()
    axes.xaxis.set_major_locator(NullLocator())  # gives a list, other locators an array
    axes.yaxis.set_major_locator(FixedLocator([0.5]))
    assert [len(texts) for texts in drawing._ticks(figure)] == [0, 1]


def test_a_colour_bar_has_room_for_its_numbers():
    figure = new_figure(11.0, 3.0)
    left, right = figure.subplots(1, 2)
    left.set_axis_off()
    figure.colorbar(right.imshow(np.arange(-6.0, 6.0).reshape(3, 4), aspect="auto"), ax=right, pad=0.02, fraction=0.04)
    lay_out(figure)
    assert figure.axes[2].get_tightbbox().x1 <= figure.bbox.x1
