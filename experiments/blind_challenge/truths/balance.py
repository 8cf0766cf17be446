"""Forces and rates at one instant: Eq. 15 and every law beside it, compiled once and handed to the integrator as a
pointer.

A pointer keeps the compiler from putting all laws into every function of the integrator anew.
"""

from collections.abc import Callable
from functools import cache

from numba import float64, int64, types

from experiments.blind_challenge.truths import codes
from experiments.blind_challenge.truths.algebraic import algebraic_force, algebraic_grip, algebraic_mass
from experiments.blind_challenge.truths.cells import cell_load, cell_rates
from experiments.blind_challenge.truths.compiled import kept_kernel, kernel, source_stamp
from experiments.blind_challenge.truths.friction import friction_force, friction_rates
from experiments.blind_challenge.truths.hidden import hidden_force, hidden_rates

NUMBERS = float64[::1]
RULE = types.UniTuple(float64, 3)(
    float64, NUMBERS, float64, NUMBERS, int64[:, ::1], NUMBERS, NUMBERS, float64, NUMBERS, int64
)


@kernel
def _memory_force(code, t, x, y, s, p, o):
    """Force of the stored past at t, with what the body has done since the step began."""
    u = (t - p[o + codes.MEMORY_START]) / p[o + codes.MEMORY_STEP]
    g0, g1, g2 = p[o + codes.MEMORY_NODES], p[o + codes.MEMORY_NODES + 1], p[o + codes.MEMORY_NODES + 2]
    past = g0 + u * (-3.0 * g0 + 4.0 * g1 - g2) + u * u * (2.0 * g0 - 4.0 * g1 + 2.0 * g2)
    if code == codes.KERNEL:
        past += p[o + codes.MEMORY_K0] * (x - p[o + codes.MEMORY_X]) + p[o + codes.MEMORY_K1] * y[s]
    return -past


def _build(stamp, water):
    """The compiled rule; its cache is keyed by `stamp` (see compiled.py). Without `water` cells are left out."""

    @kept_kernel(RULE)
    def balance(t, y, direction, body, law, numbers, scratch, swing, rate, base):
        """Rates of all states; returns (force without friction, friction, acceleration). Direction 0 is sticking."""
        mass, c, k, coulomb, q, rest = body[0], body[1], body[2], body[3], body[4], body[5]
        x, v = y[0], y[1]
        force = (-c if stamp != 0 else c) * v - k * (x - rest) - q * v * abs(v)
        for e in range(law.shape[0]):
            code = law[e, 0]
            o, s = law[e, 1], law[e, 3]
            if code < codes.RESONATOR:
                force += algebraic_force(code, t, x, v, numbers, o, swing)
                mass += algebraic_mass(code, t, numbers, o)
            elif code < codes.DAHL:
                force += hidden_force(code, y, s, numbers, o)
            elif code < codes.CELL:
                force += friction_force(code, v, y, s, numbers, o)
            elif code < codes.ECHO:
                if water:
                    push, more = cell_load(y, s, numbers, o, scratch, law[e, 5])
                    force += push
                    mass += more
            else:
                force += _memory_force(code, t, x, y, s, numbers, o)
        grip = coulomb
        way = direction if direction != 0.0 else (1.0 if force > 0.0 else -1.0)
        for e in range(law.shape[0]):
            if codes.UNEVEN <= law[e, 0] <= codes.NORMAL:
                grip += algebraic_grip(law[e, 0], x, v, way, numbers, law[e, 1])
        a = 0.0 if direction == 0.0 else (force - grip * direction) / mass
        rate[base] = v
        rate[base + 1] = a
        for e in range(law.shape[0]):
            code = law[e, 0]
            o, s = law[e, 1], law[e, 3]
            if codes.RESONATOR <= code < codes.DAHL:
                hidden_rates(code, x, v, a, y, s, numbers, o, rate, base + s)
            elif codes.DAHL <= code < codes.CELL:
                friction_rates(code, v, y, s, numbers, o, rate, base + s)
            elif code == codes.CELL:
                if water:
                    cell_rates(a, s, numbers, o, scratch, law[e, 5], rate, base + s)
            elif code == codes.KERNEL:
                rate[base + s] = x - numbers[o + codes.MEMORY_X]
        return force, grip, a

    return balance


@cache
def rule(water: bool) -> Callable[..., tuple[float, float, float]]:
    """The compiled right-hand side, with nonlinear water in cells or (sooner compiled) without."""
    return _build(source_stamp(), water)
