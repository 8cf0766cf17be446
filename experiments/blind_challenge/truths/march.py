"""Compiled integration: Dormand-Prince 5(4), stopped at every reversal of the velocity, with exact stick and slip.

M x'' + c x' + k (x - x_e) + q x'|x'| + (F_c + grip) sign(x') = sum of forces. Where the velocity reaches zero the
forces without friction decide: within the friction the body sticks (x fixed, hidden states go on) until they exceed it.
No sign is smoothed.
"""

import numpy as np
from numba import float64, int64, types

from experiments.blind_challenge.truths import codes
from experiments.blind_challenge.truths.balance import NUMBERS, RULE
from experiments.blind_challenge.truths.compiled import kept_kernel, kernel, source_stamp, summed

STAGE = np.array(
    [
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [1 / 5, 0.0, 0.0, 0.0, 0.0, 0.0],
        [3 / 40, 9 / 40, 0.0, 0.0, 0.0, 0.0],
        [44 / 45, -56 / 15, 32 / 9, 0.0, 0.0, 0.0],
        [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0.0, 0.0],
        [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656, 0.0],
        [35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
    ]
)
MARCH = types.void(
    types.FunctionType(RULE),
    float64,
    float64,
    NUMBERS,
    float64,
    NUMBERS,
    int64[:, ::1],
    NUMBERS,
    NUMBERS,
    float64[:, ::1],
    NUMBERS,
    float64,
    float64[:, ::1],
)
NODE = np.array([0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0])
ERROR = np.array([71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40])
LEAST_STEP = 1e-9  # of the outer step: below it an event counts as here and now
MOST_STEPS = 100_000  # within an outer one: what runs away takes smaller ones without end
ROUNDS = 60  # of a bracketing search for an event


@kernel
def _step(rule, t, h, y, direction, body, law, numbers, scratch, swing, scales, tolerance, slopes, new):
    """One Dormand-Prince step into `new`; returns the error over the tolerance."""
    n = y.size
    for s in range(7):
        for i in range(n):
            total = 0.0
            for r in range(s):
                total += STAGE[s, r] * slopes[r * n + i]
            new[i] = y[i] + h * total
        rule(t + NODE[s] * h, new, direction, body, law, numbers, scratch, swing, slopes, s * n)
    worst = 0.0
    for i in range(n):
        total = 0.0
        for s in range(7):
            total += ERROR[s] * slopes[s * n + i]
        worst = max(worst, abs(h * total) / (tolerance * (scales[i] + abs(new[i]))))
    return worst if worst == worst else 1e6  # not a number: refuse the step


@kernel
def _excess(rule, t, y, body, law, numbers, scratch, swing, slopes):
    """Force without friction over the friction that holds a body at rest: positive where it must slip; and its sign."""
    force, grip, _ = rule(t, y, 0.0, body, law, numbers, scratch, swing, slopes, 7 * y.size)
    return abs(force) - max(grip, 0.0), 1.0 if force > 0.0 else -1.0


@kernel
def _locate(rule, t, h, y, direction, body, law, numbers, scratch, swing, scales, tolerance, slopes, new):
    """Fraction of a step at which a reversal (slipping) or a loss of grip (sticking) happens, by bracketing."""
    low, high = 0.0, h
    low_value, high_value = 0.0, 0.0  # not known yet: halve
    side = 0
    for i in range(ROUNDS):
        if low_value == 0.0 or high_value == 0.0 or i % 4 == 3:
            middle = 0.5 * (low + high)
        else:
            middle = (low * high_value - high * low_value) / (high_value - low_value)
        _step(rule, t, middle, y, direction, body, law, numbers, scratch, swing, scales, tolerance, slopes, new)
        if direction == 0.0:
            value, _ = _excess(rule, t + middle, new, body, law, numbers, scratch, swing, slopes)
        else:
            value = -direction * new[1]
        if value > 0.0:
            high, high_value = middle, value
            low_value = 0.5 * low_value if side == 1 else low_value
            side = 1
        else:
            low, low_value = middle, value
            high_value = 0.5 * high_value if side == -1 else high_value
            side = -1
        if direction != 0.0 and abs(value) < 1e-13 * scales[1]:
            high = middle
            break
        if abs(high - low) < 1e-13 * h:
            break
    _step(rule, t, high, y, direction, body, law, numbers, scratch, swing, scales, tolerance, slopes, new)
    return high


@kernel
def _after_stop(rule, t, y, body, law, numbers, scratch, swing, slopes):
    """Direction after the velocity became zero: 0 where friction holds."""
    over, way = _excess(rule, t, y, body, law, numbers, scratch, swing, slopes)
    if over <= 0.0:
        return 0.0
    return way


@kernel
def advance(rule, t, span, y, direction, body, law, numbers, scratch, turns, scales, tolerance, slopes, new):
    """Integrate `y` in place over `span` seconds; returns the direction at its end. nan of what runs away."""
    done = 0.0 if np.isfinite(y[0]) else span
    h = min(span, turns[2])
    short = steps = 0
    while done < span * (1.0 - 1e-14):
        steps += 1
        if steps > MOST_STEPS:
            y[:] = np.nan
            return direction
        h = min(h, span - done)
        error = _step(
            rule, t + done, h, y, direction, body, law, numbers, scratch, turns[0], scales, tolerance, slopes, new
        )
        if error > 1.0 and h > LEAST_STEP * span:
            h *= max(0.2, 0.9 * error**-0.2)
            continue
        if direction == 0.0:
            over, _ = _excess(rule, t + done + h, new, body, law, numbers, scratch, turns[0], slopes)
            event = over > 0.0
        else:
            event = direction * new[1] < 0.0
        taken = h
        if event:
            taken = _locate(
                rule, t + done, h, y, direction, body, law, numbers, scratch, turns[0], scales, tolerance, slopes, new
            )
            new[1] = 0.0
        y[:] = new
        done += taken
        if event:
            short = short + 1 if taken < LEAST_STEP * span else 0
            if direction != 0.0:
                turns[0] = 0.5 * abs(y[0] - turns[1])
                turns[1] = y[0]
            direction = _after_stop(rule, t + done, y, body, law, numbers, scratch, turns[0], slopes)
            if short > 20:
                direction = 0.0
        if not event:
            h = taken * min(5.0, max(0.2, 0.9 * max(error, 1e-10) ** -0.2))
            turns[2] = max(h, turns[2]) if taken < 0.5 * turns[2] else h
    return direction


@kernel
def _recall(n, step, law, numbers, kernels, past, speeds):
    """Write what every memory law needs for the outer step that begins at node n."""
    for e in range(law.shape[0]):
        code = law[e, 0]
        if code < codes.ECHO:
            continue
        p, o = numbers, law[e, 1]
        p[o + codes.MEMORY_START] = n * step
        p[o + codes.MEMORY_STEP] = step
        p[o + codes.MEMORY_X] = past[n, 0]
        row = 2 * int(p[o + codes.MEMORY_ROW])
        for node in range(3):
            if code == codes.ECHO:
                then = (n + 0.5 * node) * step - p[o + codes.MEMORY_DELAY]
                value = _delayed(then, step, past)
            else:
                value = _convolved(n, node, step, kernels[row], kernels[row + 1], past, speeds)
            p[o + codes.MEMORY_NODES + node] = p[o + codes.MEMORY_GAIN] * value
        if code == codes.KERNEL:
            even, odd = kernels[row], kernels[row + 1]
            p[o + codes.MEMORY_K0] = p[o + codes.MEMORY_GAIN] * even[0]
            p[o + codes.MEMORY_K1] = p[o + codes.MEMORY_GAIN] * (-3.0 * even[0] + 4.0 * odd[0] - even[1]) / step


@kernel
def _delayed(t, step, past):
    """Velocity at an earlier time, m/s: cubic Hermite between the stored nodes, 0 before the release."""
    if t <= 0.0:
        return 0.0
    i = int(t / step)
    s = t / step - i
    v0, v1, a0, a1 = past[i, 1], past[i + 1, 1], past[i, 2] * step, past[i + 1, 2] * step
    return v0 + s * (a0 + s * (3.0 * (v1 - v0) - 2.0 * a0 - a1 + s * (2.0 * (v0 - v1) + a0 + a1)))


@summed
def _product(first, second):
    """Sum of products of two lines of equal length, in any order of summation."""
    total = 0.0
    for i in range(first.size):
        total += first[i] * second[i]
    return total


@kernel
def _convolved(n, node, step, even, odd, past, speeds):
    """Integral of K(t - s) v(s) over the stored past, to node n, t half a step times `node` later; ends corrected.

    `even` holds K at whole steps, `odd` half a step later; `speeds` holds the velocities, the latest node first.
    """
    if n == 0:
        return 0.0
    line = odd if node == 1 else even
    skip = 1 if node == 2 else 0
    count = min(n + 1, even.size - skip - 1)
    last = n - count + 1
    newest = speeds.size - 1 - n
    total = _product(line[skip : skip + count], speeds[newest : newest + count])
    total -= 0.5 * (line[skip] * past[n, 1] + line[skip + count - 1] * past[last, 1])
    end = _slope(0, node, step, even, odd, past[n, 1], past[n, 2])
    start = _slope(count - 1, node, step, even, odd, past[last, 1], past[last, 2])
    return step * total + step * step / 12.0 * (start - end)


@kernel
def _slope(m, node, step, even, odd, v, a):
    """Derivative by s of K(t - s) v(s) at a node m steps back."""
    if node == 1:
        value, bend = odd[m], even[m + 1] - even[m]
    elif node == 2:
        value, bend = even[m + 1], odd[m + 1] - odd[m]
    elif m == 0:
        value, bend = even[0], -3.0 * even[0] + 4.0 * odd[0] - even[1]
    else:
        value, bend = even[m], odd[m] - odd[m - 1]
    return -bend / step * v + value * a


def _build(stamp):
    """The compiled `march`. Its cache is keyed by `stamp`, so a change of any law's source compiles it anew."""

    @kept_kernel(MARCH)
    def march(rule, first, step, y, direction, body, law, numbers, scratch, kernels, scales, tolerance, out):
        """Fill `out` (nodes, 1 + states) with x, v, a and the hidden states at 0, `first`, `first` + `step`, ...

        With memory laws `first` must equal `step`: the past is stored at even nodes.
        """
        n = y.size if stamp != 0 else 0
        slopes = np.zeros(8 * n)
        new = np.empty(n)
        turns = np.array([abs(y[0] - body[5]), y[0], step])  # last half swing, last turning point, next step
        t = 0.0
        out[0, :] = 0.0
        out[0, 0] = y[0]
        speeds = np.zeros(out.shape[0])
        _recall(0, step, law, numbers, kernels, out, speeds)
        if direction == 0.0:
            direction = _after_stop(rule, t, y, body, law, numbers, scratch, turns[0], slopes)
        for i in range(out.shape[0]):
            _, _, a = rule(t, y, direction, body, law, numbers, scratch, turns[0], slopes, 7 * n)
            out[i, 0], out[i, 1], out[i, 2] = y[0], y[1], a
            out[i, 3:] = y[2:]
            if i == out.shape[0] - 1:
                break
            speeds[out.shape[0] - 1 - i] = y[1]
            _recall(i, step, law, numbers, kernels, out, speeds)
            for e in range(law.shape[0]):
                if law[e, 0] == codes.KERNEL:
                    y[law[e, 3]] = 0.0
            span = first if i == 0 else step
            direction = advance(
                rule, t, span, y, direction, body, law, numbers, scratch, turns, scales, tolerance, slopes, new
            )
            t += span

    return march


march = _build(source_stamp())
