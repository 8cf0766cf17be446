"""Residuals of Eq. 15's trials, their Jacobian and normal equations, compiled, from a sheet of arrays.

Belongs here: what one set of values gives on a sheet (eq15.py writes it), and the room that this needs. Does not
belong here: integration (taylor_series.py), the search (eq15_search.py, whose cache does not see a change here).
"""

# mypy: disable-error-code="no-untyped-def, misc, untyped-decorator"

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numba import njit

from undertow.equation.lanes import LANES, load, plus_times, store
from undertow.equation.lanes import times as times_four
from undertow.equation.taylor_series import (
    LAWS,
    MOST_STEPS,
    ORDER,
    TOLERANCE,
    Places,
    accelerations,
    clear,
    integrals,
    march,
    sample_at,
    slopes_at,
)
from undertow.equation.term import Array
from undertow.likelihood.problem import EVEN

Arrays = tuple[Any, ...]
"""A sheet (eq15.py), the room that integration needs, a point of the search: arrays by their places."""
_FIRST, _LAST, _LINK, _LINK_END, _CHANNEL, _CHANNEL_END, _SHIFT, _ROW = range(8)
"""Columns of a sheet's ``places``: cells, links, channels (from, to), clock's unknown, first residual."""
_QUANTITY, _OFFSET, _DRIFT, _CLOCK, _GAIN, _VALUE = range(6)
"""Columns of a sheet's ``channels``: quantity, unknowns of its nuisances, first value."""
_WIDTH, _STRIDE, _AVERAGED, _SWELL = range(4)
"""Columns of a sheet's ``cells``: width in s, 0 for lone instants; how far apart two beginnings stand in the edges;
whether several samples make a cell; an acceleration's factor where they do not."""
_LOWER, _UPPER, _PRIOR, _PRECISION = range(4)
_MASS, _K = 0, 1
_u = np.uint64
_OPT: dict[str, Any] = {"error_model": "numpy", "nogil": True}
_BORROWS: dict[str, Any] = {**_OPT, "_nrt": False}
INNER: dict[str, Any] = {**_BORROWS, "no_cpython_wrapper": True}
"""For functions that allocate nothing: references to arrays are not counted, which costs time at every call. Python
cannot call the inner ones, which saves compiling a wrapper each."""
_SUMS: dict[str, Any] = {**_BORROWS, "fastmath": {"reassoc", "contract", "nsz"}}
"""For sums whose order does not matter; no value is assumed finite."""
_EARLY = (12, 1e-5)
"""Order and tolerance of the series while a window is not yet the whole record."""

_STEPS_A_RADIAN = 3.0
"""Steps that `march` may store a radian of the start's motion: it takes about one."""


@njit(**_SUMS)
def _channel(sheet, trial, channel, n, values, levels, rates, slot_column, column, r, jac, begin):
    """Weighted residuals of one channel, r[begin : begin + n], and their Jacobian, jac[:, begin : begin + n]."""
    t, _, places, _, links, factors, channels, sigmas, data, _ = sheet
    first = places[trial, _FIRST]
    weight = 1.0 / sigmas[channel]
    about = channels[channel]
    gain = 1.0 + (values[about[_GAIN]] if about[_GAIN] >= 0 else 0.0)
    offset = values[about[_OFFSET]] if about[_OFFSET] >= 0 else 0.0
    at = about[_VALUE]
    for row in range(n):
        r[begin + row] = (gain * levels[row, 0] + offset - data[at + row]) * weight
    for k in range(jac.shape[0]):
        for row in range(begin, begin + n):
            jac[k, row] = 0.0
    for link in range(places[trial, _LINK], places[trial, _LINK_END]):
        k, to, factor = slot_column[links[link, 0]], column[links[link, 1]], factors[link] * gain * weight
        for row in range(n):
            jac[to, begin + row] += factor * levels[row, k]
    for clock in (places[trial, _SHIFT], about[_CLOCK]):
        if clock >= 0:
            for row in range(n):
                jac[column[clock], begin + row] += gain * weight * rates[row]
    if about[_OFFSET] >= 0:
        for row in range(n):
            jac[column[about[_OFFSET]], begin + row] += weight
    if about[_GAIN] >= 0:
        for row in range(n):
            jac[column[about[_GAIN]], begin + row] += weight * levels[row, 0]
    if about[_DRIFT] >= 0:
        length = t[first + n - 1] - t[first]
        for row in range(n):
            line = weight * ((t[first + row] - t[first]) / length - 0.5)
            jac[column[about[_DRIFT]], begin + row] += line
            r[begin + row] += values[about[_DRIFT]] * line
    for row in range(n):
        if math.isnan(data[at + row]):  # it says nothing
            r[begin + row] = 0.0
            for k in range(jac.shape[0]):
                jac[k, begin + row] = 0.0


@njit(**INNER)
def _parameters(sheet, trial, values, p, slot_column, slots):
    """The short parameter vector of a trial, its active ``slots``, their number, which column of `march` each is."""
    _, bases, places, _, links, factors, _, _, _, _ = sheet
    for slot in range(p.size):
        p[slot] = bases[trial, slot]
        slot_column[slot] = 0
    for link in range(places[trial, _LINK], places[trial, _LINK_END]):
        p[links[link, 0]] += factors[link] * values[links[link, 1]]
        slot_column[links[link, 0]] = 1
    count = 0
    for slot in range(p.size):
        if slot_column[slot]:
            slots[count] = slot
            count += 1
            slot_column[slot] = count
    return count


@njit(**INNER)
def _cells_within(sheet, trial, seconds):
    """Cells of a trial's first ``seconds``."""
    t, places = sheet[0], sheet[2]
    first = places[trial, _FIRST]
    n = places[trial, _LAST] - first
    while n > 2 and t[first + n - 1] > t[first] + seconds:
        n -= 1
    return n


@njit(**_SUMS)
def _add(used, r, jac, begin, n, normal, gradient):
    """Add J^T J and J^T r of one channel to the normal equations; its sum of squares."""
    total = 0.0
    for row in range(begin, begin + n):
        total += r[row] * r[row]
    for i in range(used.size):
        slope = 0.0
        for row in range(begin, begin + n):
            slope += jac[i, row] * r[row]
        gradient[used[i]] += slope
        for j in range(i + 1):
            square = 0.0
            for row in range(begin, begin + n):
                square += jac[i, row] * jac[j, row]
            normal[used[i], used[j]] += square
            if i != j:
                normal[used[j], used[i]] += square
    return total


@njit(**_BORROWS)
def unknowns_in(column: Places, used: Places) -> int:
    """The first of ``used`` (unknowns,): a trial's unknowns in the order of its columns; their number."""
    count = 0
    for unknown in range(column.size):
        if column[unknown] >= 0:
            used[column[unknown]] = unknown
            count += 1
    return count


@njit(**INNER)
def _samples(quantity, times, at, xs, vs, series, ends, steps, order, clocked, levels, rates):
    """A channel's signal and sensitivities at single samples, and, where a clock is unknown, its rate of change."""
    if quantity == 2:
        accelerations(vs, steps, order, series)
    seen = xs if quantity == 0 else vs if quantity == 1 else series
    sample_at(times, at, seen, ends, steps, order, levels)
    if not clocked:
        return
    if quantity < 2:
        slopes_at(times, at, seen, ends, steps, order, rates)
        return
    n = times.size
    for row in range(n):
        lo, hi = max(row - 1, 0), min(row + 1, n - 1)
        rates[row] = (levels[hi, 0] - levels[lo, 0]) / (times[hi] - times[lo])


@njit(**INNER)
def _means(quantity, times, at, cell, xs, vs, series, ends, steps, order, clocked, instants, levels, pulls, rates):
    """The same in cells: a mean is the difference of the signal's integral from edge to edge (observation_model.py)."""
    n, width, stride = times.size, cell[_WIDTH], int(cell[_STRIDE])
    count = n + 1 if stride == 1 else 2 * n
    for row in range(n):
        instants[stride * row] = times[row] - 0.5 * width
        instants[stride * row + 1] = times[row] + 0.5 * width
    if quantity == 0:
        integrals(xs, ends, steps, order, series)
    seen = series if quantity == 0 else xs if quantity == 1 else vs
    sample_at(instants[:count], at, seen, ends, steps, order, levels)
    if clocked:
        slopes_at(instants[:count], at, seen, ends, steps, order, rates)
    if quantity == 0:
        for row in range(count):
            early = instants[row] + at
            if early >= 0.0:
                break
            for j in range(levels.shape[1]):
                levels[row, j] += early * xs[0, 0, j]
            rates[row] = xs[0, 0, 0]
    if quantity == 2 and cell[_AVERAGED] == 0.0:
        accelerations(vs, steps, order, series)
        sample_at(instants[:count], at, series, ends, steps, order, pulls)
        _lone(n, stride, 1.0 / width, cell[_SWELL], levels, pulls)
    else:
        for row in range(n):
            begin = _u(stride * row)
            for block in range(0, levels.shape[1], LANES):
                at_block = _u(block)
                left, right = load(levels, begin, at_block), load(levels, begin + _u(1), at_block)
                store(levels, _u(row), at_block, times_four(1.0 / width, plus_times(right, -1.0, left)))
    if clocked:
        for row in range(n):
            rates[row] = (rates[stride * row + 1] - rates[stride * row]) / width


@njit(**INNER)
def _lone(n, stride, per_second, swell, levels, pulls):
    """Velocities at the edges of single samples' steps become accelerations there: with those at the edges (``pulls``)
    where the body goes one way, else the mean over the step."""
    for row in range(n):
        begin = stride * row
        turns = levels[begin, 0] * levels[begin + 1, 0] <= 0.0
        for j in range(levels.shape[1]):
            mean = per_second * (levels[begin + 1, j] - levels[begin, j])
            levels[row, j] = swell * mean if turns else 1.5 * mean - 0.25 * (pulls[begin, j] + pulls[begin + 1, j])


@njit(**INNER)
def _trial(sheet, trial, column, values, seconds, precise, room, point):
    """One trial's rows, added to the normal equations of ``point``; its sum of squares, -1 without a motion."""
    t, _, places, cells, _, _, channels, _, _, _ = sheet
    xs, vs, ends, series, by, instants, levels, pulls, rates, p, slot_column, slots, used = room
    r, jac, normal, gradient = point
    active = slots[: _parameters(sheet, trial, values, p, slot_column, slots)]
    if not (p[_MASS] > 0.0 and p[_K] > 0.0 and p[_K] < 1e300):
        return -1.0
    n = _cells_within(sheet, trial, seconds)
    times = t[places[trial, _FIRST] : places[trial, _FIRST] + n]
    late = values[places[trial, _SHIFT]] if places[trial, _SHIFT] >= 0 else 0.0
    last = 0.0
    for channel in range(places[trial, _CHANNEL], places[trial, _CHANNEL_END]):
        clock = channels[channel, _CLOCK]
        last = max(last, times[n - 1] + late + (values[clock] if clock >= 0 else 0.0) + 0.5 * cells[trial, _WIDTH])
    order, tolerance = (ORDER, TOLERANCE) if precise else _EARLY
    steps = march(p, active, last, order, tolerance, xs, vs, ends, by)
    if steps == 0:
        return -1.0
    row = places[trial, _ROW]
    own = used[: unknowns_in(column, used)]
    total = 0.0
    for channel in range(places[trial, _CHANNEL], places[trial, _CHANNEL_END]):
        quantity, clock = channels[channel, _QUANTITY], channels[channel, _CLOCK]
        at = late + (values[clock] if clock >= 0 else 0.0)
        clocked = clock >= 0 or places[trial, _SHIFT] >= 0
        if cells[trial, _WIDTH] > 0.0 and (quantity == 2 or cells[trial, _AVERAGED] > 0.0):
            cell = cells[trial]
            _means(
                quantity, times, at, cell, xs, vs, series, ends, steps, order, clocked, instants, levels, pulls, rates
            )  # fmt: skip
        else:
            _samples(quantity, times, at, xs, vs, series, ends, steps, order, clocked, levels, rates)
        _channel(sheet, trial, channel, n, values, levels, rates, slot_column, column, r, jac, row)
        total += _add(own, r, jac, row, n, normal, gradient)
        row += n
    return total


@njit(**_BORROWS)
def evaluate(
    sheet: Arrays, columns: Places, values: Array, seconds: float, precise: bool, room: Arrays, point: Arrays
) -> tuple[float, float]:
    """Cost with priors and chi2 without; -1 without a motion. ``point`` (r, jac, normal, gradient) is filled."""
    box = sheet[9]
    _, _, normal, gradient = point
    clear(normal)
    for i in range(gradient.size):
        gradient[i] = 0.0
    chi2 = 0.0
    for trial in range(columns.shape[0]):
        found = _trial(sheet, trial, columns[trial], values, seconds, precise, room, point)
        if not found >= 0.0:
            return -1.0, -1.0
        chi2 += found
    cost = chi2
    for i in range(values.size):
        away = values[i] - box[_PRIOR, i]
        normal[i, i] += box[_PRECISION, i]
        gradient[i] += box[_PRECISION, i] * away
        cost += box[_PRECISION, i] * away * away
    return (cost, chi2) if cost < 1e300 else (-1.0, -1.0)


@njit(**_SUMS)
def spread_of_data(sheet: Arrays) -> float:
    """Sum of squares of all channels about their means, in units of their noise."""
    places, channels, sigmas, data = sheet[2], sheet[6], sheet[7], sheet[8]
    total = 0.0
    for trial in range(places.shape[0]):
        n = places[trial, _LAST] - places[trial, _FIRST]
        for channel in range(places[trial, _CHANNEL], places[trial, _CHANNEL_END]):
            first, whole, squares, count = channels[channel, _VALUE], 0.0, 0.0, 0
            for row in range(first, first + n):
                if not math.isnan(data[row]):
                    whole, count = whole + data[row], count + 1
            for row in range(first, first + n):
                if not math.isnan(data[row]):
                    squares += (data[row] - whole / count) ** 2
            total += squares / sigmas[channel] ** 2
    return total


@njit(**_BORROWS)
def rows_of(sheet: Arrays) -> Any:
    """Residuals of a whole problem."""
    last, places = sheet[2].shape[0] - 1, sheet[2]
    cells = places[last, _LAST] - places[last, _FIRST]
    return places[last, _ROW] + cells * (places[last, _CHANNEL_END] - places[last, _CHANNEL])


@njit(**_OPT)
def room_for(sheet: Arrays, start: Array) -> Arrays:
    """What `march` and the samples need: series of every step, instants, signals, levels, accelerations, rates,
    parameters."""
    t, _, places, cells, _, _, _, _, _, _ = sheet
    p, slot_column = np.empty(len(LAWS)), np.empty(len(LAWS), dtype=np.int64)
    slots, used = np.empty(len(LAWS), dtype=np.int64), np.empty(start.size, dtype=np.int64)
    steps, most, columns = 64, 0, 0
    for trial in range(places.shape[0]):
        columns = max(columns, _parameters(sheet, trial, start, p, slot_column, slots))
        first, last = places[trial, _FIRST], places[trial, _LAST]
        most = max(most, last - first)
        if p[_MASS] > 0.0 and p[_K] > 0.0:
            angle = min(math.sqrt(p[_K] / p[_MASS]) * t[last - 1], 1.0 * MOST_STEPS)
            steps = max(steps, 64 + int(_STEPS_A_RADIAN * angle))
        cells[trial, _STRIDE] = 1.0
        width = cells[trial, _WIDTH]
        for row in range(first + 1, last):
            if not abs(t[row] - t[row - 1] - width) <= EVEN * width:
                cells[trial, _STRIDE] = 2.0
                break
    width = 4 * ((4 + columns) // 4)
    shape = (min(steps, MOST_STEPS), ORDER + 1, width)
    return (
        np.empty(shape), np.empty(shape), np.empty(shape[0] + 1), np.empty(shape), np.empty((5, width)),
        np.empty(2 * most), np.empty((2 * most, width)), np.empty((2 * most, width)), np.empty(2 * most), p,
        slot_column, slots, used,
    )  # fmt: skip


@njit(**_OPT)
def points_room(rows: int, widest: int, size: int) -> Arrays:
    """Room for residuals, Jacobian, normal equations and gradient."""
    return np.empty(rows), np.empty((widest, rows)), np.empty((size, size)), np.empty(size)


@njit(**_SUMS)
def follow(
    sheet: Arrays, columns: Places, step: Array, cost: float, room: Arrays, point: Arrays
) -> tuple[float, float]:
    """Take a point along a short step: residuals and gradient linearly; the new cost and chi2."""
    places = sheet[2]
    r, jac, normal, gradient = point
    change = 0.0
    for i in range(step.size):
        moved = 0.0
        for j in range(step.size):
            moved += normal[i, j] * step[j]
        change += step[i] * (2.0 * gradient[i] + moved)
        gradient[i] += moved
    chi2 = 0.0
    for trial in range(columns.shape[0]):
        begin = places[trial, _ROW]
        end = begin + (places[trial, _LAST] - places[trial, _FIRST]) * (
            places[trial, _CHANNEL_END] - places[trial, _CHANNEL]
        )
        used = room[-1]
        for i in range(unknowns_in(columns[trial], used)):
            by = step[used[i]]
            for row in range(begin, end):
                r[row] += jac[i, row] * by
        for row in range(begin, end):
            chi2 += r[row] * r[row]
    return cost + change, chi2
