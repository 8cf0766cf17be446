"""Friction and hysteresis with states: Dahl, Bouc-Wen with degradation and pinching, Iwan, LuGre, rate and state.

Sources: Dahl 1968; Baber and Noori 1985 (pinching); Iwan 1966; Canudas de Wit et al. 1995; Dieterich 1979 and Ruina
1983 (ageing law, regularised as by Rice, Lapusta and Ranjith 2001).
"""

import math

from experiments.blind_challenge.truths import codes
from experiments.blind_challenge.truths.compiled import kernel


@kernel
def _sign(v):
    return 1.0 if v > 0.0 else (-1.0 if v < 0.0 else 0.0)


@kernel
def _lugre_rate(h, s, v, p, o):
    level = p[o + 2] + (p[o + 3] - p[o + 2]) * math.exp(-((v / p[o + 4]) ** 2))
    return v - p[o] * abs(v) * h[s] / level


@kernel
def _rate_state(h, s, v, p, o):
    theta = max(h[s], 1e-12 * p[o + 4] / p[o + 3])
    exponent = (p[o] + p[o + 2] * math.log(p[o + 3] * theta / p[o + 4])) / p[o + 1]
    return p[o + 1] * math.asinh(0.5 * v / p[o + 3] * math.exp(exponent))


@kernel
def friction_force(code, v, h, s, p, o):
    """Force of a friction with states on the body, N."""
    if code == codes.DAHL:
        return -h[s]
    if code == codes.BOUCWEN:
        return -p[o] * p[o + 1] * h[s]
    if code == codes.IWAN:
        total = 0.0
        for i in range(int(p[o])):
            total -= h[s + i]
        return total
    if code == codes.LUGRE:
        return -(p[o] * h[s] + p[o + 1] * _lugre_rate(h, s, v, p, o))
    if code == codes.RATE_STATE:
        return -_rate_state(h, s, v, p, o)
    return 0.0


@kernel
def _bouc_wen_rates(v, h, s, p, o, rate, d):
    z, energy = h[s], h[s + 1]
    u = v / p[o + 1]
    n, beta, gamma = p[o + 2], p[o + 3], p[o + 4]
    strength = 1.0 + p[o + 5] * energy
    softness = 1.0 + p[o + 6] * energy
    top = (1.0 / (strength * (beta + gamma))) ** (1.0 / n)
    severity = p[o + 7] * (1.0 - math.exp(-p[o + 9] * energy))
    width = (p[o + 10] + p[o + 11] * energy) * (p[o + 12] + severity)
    pinch = 1.0 - severity * math.exp(-(((z * _sign(v) - p[o + 8] * top) / width) ** 2))
    power = abs(z) ** (n - 1.0) * z
    rate[d] = pinch / softness * (u - strength * (beta * abs(u) * power + gamma * u * abs(z) ** n))
    rate[d + 1] = z * u


@kernel
def friction_rates(code, v, h, s, p, o, rate, d):
    """Rates of the states of a friction, written into `rate`."""
    if code == codes.DAHL:
        rate[d] = p[o] * v * (1.0 - _sign(v) * h[s] / (p[o] * p[o + 1]))
    elif code == codes.BOUCWEN:
        _bouc_wen_rates(v, h, s, p, o, rate, d)
    elif code == codes.IWAN:
        for i in range(int(p[o])):
            sliding = abs(h[s + i]) >= p[o + 2 + 2 * i] and h[s + i] * v > 0.0
            rate[d + i] = 0.0 if sliding else p[o + 1 + 2 * i] * v
    elif code == codes.LUGRE:
        rate[d] = _lugre_rate(h, s, v, p, o)
    elif code == codes.RATE_STATE:
        rate[d] = 1.0 - abs(v) * h[s] / p[o + 4]
