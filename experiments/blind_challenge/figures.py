"""Figures of the page: power beside the best possible, reliability of the confidence, p-values. They draw what is
given.
"""

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure


def power_axes(axes: Axes, bins: list[dict[str, Any]]) -> Axes:
    """Shares detected and named against strength, with 90 % intervals, beside the best possible test."""
    centre = [np.sqrt(max(b["from"], 0.25) * (b["to"] or 32.0)) for b in bins]
    for key, label, colour in (("detected", "detected", "C0"), ("named", "named", "C1")):
        mid = np.array([b[key]["share"] for b in bins])
        low = mid - np.array([b[key]["low"] for b in bins])
        high = np.array([b[key]["high"] for b in bins]) - mid
        axes.errorbar(centre, mid, [np.clip(low, 0, None), np.clip(high, 0, None)], fmt="o-", color=colour, label=label)
    axes.plot(centre, [b["best"] for b in bins], "k--", label="best possible")
    axes.set(
        xscale="log",
        xlabel="strength (1: best possible test finds it every second time)",
        ylabel="share",
        ylim=(0, 1.03),
    )
    ticks = (0.3, 1, 3, 10, 30)
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.set_xticks([], minor=True)
    axes.legend(loc="upper left")
    return axes


def reliability_axes(axes: Axes, curve: list[dict[str, float]], exact: list[dict[str, float]]) -> Axes:
    """Share of verdicts that hold against confidence, with the 90 % band of a confidence that means what it says;
    beside it the share whose names are complete and `exact`."""
    c = [b["confidence"] for b in curve]
    axes.fill_between(
        c, [b["low"] for b in curve], [b["high"] for b in curve], alpha=0.25, color="0.5", label="90 % band"
    )
    axes.plot([0, 1], [0, 1], "k:", lw=1)
    axes.plot(c, [b["right"] for b in curve], "o-", label="what is said holds")
    if exact:
        strict = [b["right"] for b in exact]
        axes.plot([b["confidence"] for b in exact], strict, ".:", color="0.4", label="names complete and exact")
    lowest = max(np.floor(10.0 * min([1.0, *c, *(b["low"] for b in curve)])) / 10.0, 0.0)  # verdicts crowd near one
    said = [b["right"] for b in [*curve, *exact]]
    axes.set(xlabel="confidence", ylabel="share right", xlim=(lowest, 1.01), ylim=(min([lowest, *said]) - 0.02, 1.02))
    axes.legend(loc="upper left")
    return axes


def figure(tables: dict[str, Any]) -> Figure:
    """Both beside each other; an axes without numbers says so."""
    made, (left, right) = plt.subplots(1, 2, figsize=(10.5, 4.2), layout="constrained")
    bins, curve, exact = tables["power"]["bins"], tables["held"]["curve"], tables["sure"]["curve"]
    if bins:
        power_axes(left, bins)
    else:
        left.set_title("no effect of the catalogue in these rows")
    if curve:
        reliability_axes(right, curve, exact)
    else:
        right.set_title("no confidence in these rows")
    return made
