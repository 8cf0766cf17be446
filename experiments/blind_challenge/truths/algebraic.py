"""Laws of the time, the displacement and the velocity at one instant, compiled; each answers (force, mass, grip)."""

import math

from experiments.blind_challenge.truths import codes
from experiments.blind_challenge.truths.compiled import kernel


@kernel
def _tones(t, p, o):
    force = 0.0
    for i in range(int(p[o])):
        force += p[o + 1 + 3 * i] * math.cos(p[o + 2 + 3 * i] * t + p[o + 3 + 3 * i])
    return force


@kernel
def _current(t, v, p, o):
    u = 0.0
    rate = 0.0
    for i in range(int(p[o + 2])):
        angle = p[o + 4 + 3 * i] * t + p[o + 5 + 3 * i]
        u += p[o + 3 + 3 * i] * math.cos(angle)
        rate -= p[o + 3 + 3 * i] * p[o + 4 + 3 * i] * math.sin(angle)
    return -p[o] * ((v - u) * abs(v - u) - v * abs(v)) + p[o + 1] * rate


@kernel
def contact(depth, speed, stiffness, loss):
    """Hunt and Crossley 1975: k d^1.5 (1 + loss d'), never pulling; N for a depth in m and its rate in m/s."""
    if depth <= 0.0:
        return 0.0
    return max(stiffness * depth**1.5 * (1.0 + loss * speed), 0.0)


@kernel
def _keulegan(v, p, o, swing):
    """Drag whose coefficient is q (1 + share ((S / S0)^power - 1)), S the last half swing."""
    ratio = max(swing / p[o + 3], 0.02)
    return -p[o] * p[o + 1] * (ratio ** p[o + 2] - 1.0) * v * abs(v)


@kernel
def _uneven(x, p, o):
    grip = 0.0
    for i in range(int(p[o])):
        grip += p[o + 1 + 3 * i] * math.sin(p[o + 2 + 3 * i] * x + p[o + 3 + 3 * i])
    return grip


@kernel
def algebraic_force(code, t, x, v, p, o, swing):
    """Force of an algebraic law, N."""
    if code == codes.LINEAR:
        return -p[o] * v
    if code == codes.CUBIC:
        return -p[o] * v * v * v
    if code == codes.POWER:
        return -p[o] * abs(v) ** p[o + 1] * (1.0 if v > 0 else -1.0)
    if code == codes.EVEN:
        return -p[o] * abs(v) ** p[o + 1]
    if code == codes.STIFF:
        return -(p[o] * x + p[o + 1] * x * x + p[o + 2] * x**3 + p[o + 3] * x**5)
    if code == codes.SINE:
        return -p[o] * math.sin(x)
    if code == codes.TONES:
        return _tones(t, p, o)
    if code == codes.FADING:
        return p[o] * math.exp(-p[o + 3] * t) * math.cos(p[o + 1] * t + p[o + 2])
    if code == codes.CURRENT:
        return _current(t, v, p, o)
    if code == codes.STOP:
        return -contact(x - p[o], v, p[o + 1], p[o + 2])
    if code == codes.MAGNET:
        return p[o] / (p[o + 1] - x) ** 2 - p[o] / p[o + 1] ** 2
    if code == codes.HEAT:
        return -p[o] * (1.0 - math.exp(-t / p[o + 1])) * x
    if code == codes.KEULEGAN:
        return _keulegan(v, p, o, swing)
    if code == codes.RAMP:
        return p[o] * max(0.0, 1.0 - t / p[o + 1])
    if code == codes.BEND:
        return -p[o] * x * (1.0 - (2.0 * x / p[o + 1]) ** 2)
    return 0.0


@kernel
def algebraic_mass(code, t, p, o):
    """Mass that an algebraic law adds to the body, kg."""
    if code == codes.LEAK:
        return -p[o] * (1.0 - math.exp(-t / p[o + 1]))
    return 0.0


@kernel
def algebraic_grip(code, x, v, direction, p, o):
    """Friction that an algebraic law adds to the Coulomb force, N; `direction` is the sign of the (coming) velocity."""
    if code == codes.UNEVEN:
        return _uneven(x, p, o)
    if code == codes.STRIBECK:
        return p[o] * math.exp(-((v / p[o + 1]) ** 2))
    if code == codes.ONEWAY:
        return p[o] * direction
    if code == codes.NORMAL:
        return p[o] * abs(x)
    return 0.0
