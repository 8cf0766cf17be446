"""Laws with hidden states that are no friction: a mass on a spring, a relaxing force, a part in a gap, a wake, a
support.

`hidden_force` is the force on the body at the present states, `hidden_rates` fills the rates of the states once the
body's acceleration is known.
"""

from experiments.blind_challenge.truths import codes
from experiments.blind_challenge.truths.algebraic import contact
from experiments.blind_challenge.truths.compiled import kernel


@kernel
def _gap_force(h, s, p, o):
    """Force of the walls on a part (or on a sheet of water) that is further than its gaps, N."""
    return -contact(h[s] - p[o + 3], h[s + 1], p[o + 5], p[o + 6]) + contact(
        -h[s] - p[o + 4], -h[s + 1], p[o + 5], p[o + 6]
    )


@kernel
def _resonator_pull(h, s, p, o):
    """Acceleration by which spring and damper pull a hidden mass back, m/s^2."""
    return (
        2.0 * p[o + 2] * p[o + 1] * h[s + 1]
        + p[o + 1] * p[o + 1] * h[s]
        + p[o + 3] * h[s + 1] * abs(h[s + 1])
        + p[o + 4] * h[s] ** 3
    )


@kernel
def hidden_force(code, h, s, p, o):
    """Force of a law with hidden states on the body, N."""
    if code == codes.RESONATOR:
        return p[o] * _resonator_pull(h, s, p, o)
    if code == codes.RELAX:
        return -h[s]
    if code == codes.CONTACT:
        return p[o] * (2.0 * p[o + 2] * p[o + 1] * h[s + 1] + p[o + 1] * p[o + 1] * h[s]) - _gap_force(h, s, p, o)
    if code == codes.WAKE:
        return p[o] * h[s]
    if code == codes.SUPPORT:
        return p[o] * h[s]
    return 0.0


@kernel
def hidden_rates(code, x, v, a, h, s, p, o, rate, d):
    """Rates of the hidden states, written into `rate`."""
    if code == codes.RESONATOR:
        rate[d] = h[s + 1]
        rate[d + 1] = -_resonator_pull(h, s, p, o) - a
    elif code == codes.RELAX:
        rate[d] = p[o] * v - h[s] / p[o + 1]
    elif code == codes.CONTACT:
        rate[d] = h[s + 1]
        rate[d + 1] = (
            -2.0 * p[o + 2] * p[o + 1] * h[s + 1] - p[o + 1] * p[o + 1] * h[s] + _gap_force(h, s, p, o) / p[o] - a
        )
    elif code == codes.WAKE:
        rate[d] = h[s + 1]
        rate[d + 1] = -p[o + 2] * p[o + 1] * (h[s] * h[s] - 1.0) * h[s + 1] - p[o + 1] * p[o + 1] * h[s] + p[o + 3] * a
    elif code == codes.SUPPORT:
        rate[d] = h[s + 1]
        rate[d + 1] = (p[o] * (x - h[s]) - p[o + 2] * h[s + 1] - p[o + 3] * h[s]) / p[o + 1]
