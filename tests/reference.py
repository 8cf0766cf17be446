"""An independent integrator to hold the compiled one against: scipy's DOP853, split at every event, rtol 1e-12.

It knows the laws through ``Term.force`` (algebraic terms) and the ODEs as docs/terms.md states them (hidden ones).
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp

from undertow.equation.equation import Equation

SIGNED = {
    "coulomb_friction", "quadratic_drag", "drag_exponent", "stribeck_friction", "asymmetric_friction",
    "variable_normal_force", "hysteresis",
}  # fmt: skip
FRICTION = {"coulomb_friction", "stribeck_friction", "asymmetric_friction", "variable_normal_force"}


class Reference:
    """Right-hand side of an equation at a fixed direction of motion d (+1, -1, 0 = stuck)."""

    def __init__(self, equation: Equation) -> None:
        pairs = list(zip(equation.terms, equation.coefficients, strict=True))
        self.mass, self.rest = equation.total_mass_kg, equation.rest_m
        self.algebraic = [(t, c) for t, c in pairs if t.kind in ("force", "input") and t.name != "added_mass"]
        self.oscillators = [(t, c) for t, c in pairs if t.name == "hidden_resonator"]
        self.relaxations = [(t, c) for t, c in pairs if t.name == "relaxation"]
        self.hystereses = [(t, c) for t, c in pairs if t.name == "hysteresis"]
        self.timed = any(t.kind == "input" for t, _ in pairs)
        self.echoes = [(t, c) for t, c in pairs if t.name == "delayed_echo"]
        self.past = None
        self.n = 2 + 2 * len(self.oscillators) + len(self.relaxations) + len(self.hystereses)

    def oscillator(self, term, s, u):
        w, z = term.natural_frequency_rad_per_s, term.damping_ratio
        beyond = term.quadratic_damping_per_m * u * abs(u) + term.cubic_stiffness_per_m2_s2 * s**3
        return 2 * z * w * u + w**2 * s + beyond

    def force(self, t, y, v, friction: bool) -> float:
        """Force on the body at velocity v (used only to give the direction when it is tiny)."""
        one = np.ones(1)
        total = 0.0
        for term, c in self.algebraic:
            if term.name in FRICTION and not friction:
                continue
            total -= c * float(term.force(one * (y[0] - self.rest), one * v, one, one * t)[0])
        for i, (term, m) in enumerate(self.oscillators):
            total += m * self.oscillator(term, y[2 + 2 * i], y[3 + 2 * i])
        base = 2 + 2 * len(self.oscillators)
        total -= float(np.sum(y[base:]))
        for term, c in self.echoes:
            total -= c * self.past(t - term.delay_s)
        return total

    def slope(self, t, y, d):
        tiny = 1e-300
        v = 0.0 if d == 0 else (y[1] if y[1] * d > 0 else d * tiny)
        a = 0.0 if d == 0 else self.force(t, y, v, True) / self.mass
        dy = np.zeros(self.n)
        dy[0], dy[1] = (y[1] if d else 0.0), a
        for i, (term, _) in enumerate(self.oscillators):
            dy[2 + 2 * i] = y[3 + 2 * i]
            dy[3 + 2 * i] = -a - self.oscillator(term, y[2 + 2 * i], y[3 + 2 * i])
        base = 2 + 2 * len(self.oscillators)
        for j, (term, k) in enumerate(self.relaxations):
            dy[base + j] = k * dy[0] - y[base + j] / term.time_s
        for j, (term, k) in enumerate(self.hystereses):
            at = base + len(self.relaxations) + j
            dy[at] = k * dy[0] * (1 - d * y[at] / (k * term.yield_displacement_m))
        return dy

    def side(self, t, y) -> float:
        """Direction in which a body at rest starts to move (0: it sticks)."""
        for d in (1.0, -1.0):
            if self.force(t, y, d * 1e-300, True) * d > 0:
                return d
        return 0.0

    def excess(self, t, y) -> float:
        return max(self.force(t, y, d * 1e-300, True) * d for d in (1.0, -1.0))


def reference(equation: Equation, x0: float, times, v0: float = 0.0, rtol: float = 1e-12):
    """x, v (n,) at ``times``, by DOP853 split at velocity reversals, re-slips and (echo) multiples of the delay."""
    model = Reference(equation)
    delay = model.echoes[0][0].delay_s if model.echoes else np.inf
    pieces = []

    def past(t):
        if t < 0:
            return 0.0
        for start, stop, sol in reversed(pieces):
            if start <= t <= stop:
                return float(sol(t)[1])
        return 0.0

    model.past = past
    y = np.zeros(model.n)
    y[0], y[1] = x0, v0
    t, end = 0.0, float(times[-1])
    signed = any(term.name in SIGNED for term in equation.terms)
    breaks = [delay]
    out = np.zeros((2, len(times)))
    d = float(np.sign(y[1])) or model.side(t, y)
    while t < end:
        stop = min([end, t + delay] + [b for b in breaks if b > t + 1e-12])

        def turn(s, yy, d=d):
            return yy[1] * d

        def slip(s, yy):
            return model.excess(s, yy)

        turn.terminal, turn.direction = True, -1
        slip.terminal, slip.direction = True, 1
        events = [slip] if d == 0 else ([turn] if signed else [])
        for i, (term, _) in enumerate(model.oscillators):
            if term.quadratic_damping_per_m:
                def hidden(s, yy, i=i):
                    return yy[3 + 2 * i]
                hidden.terminal, hidden.direction = False, 0
        y_start = y.copy()
        if d != 0 and y_start[1] == 0.0:  # leave the reversal by a tiny exact step, so that the event is not its start
            dt = 1e-9
            a = model.slope(t, y_start, d)
            y_start = y_start + dt * a
            y_start[0] += 0.5 * dt**2 * a[1]
            t_start = t + dt
        else:
            t_start = t
        run = solve_ivp(lambda s, yy, d=d: model.slope(s, yy, d), (t_start, stop), y_start, "DOP853", events=events,
                        rtol=rtol, atol=1e-15, dense_output=True, max_step=0.05 if d else 0.01)  # short slips
        reached = float(run.t[-1])
        pieces.append((t_start, reached, run.sol))
        here = (times >= t) & (times <= reached)
        if np.any(here):
            got = run.sol(np.maximum(times[here], t_start))
            out[0, here], out[1, here] = got[0], got[1]
        y, t = run.y[:, -1].copy(), reached
        if run.status == 1:
            y[1] = 0.0
            d = model.side(t, y) if d != 0 else (1.0 if model.force(t, y, 0.0, False) > 0 else -1.0)
            breaks.append(t + delay)
        if d == 0 and not (model.oscillators or model.relaxations or model.timed or model.echoes):
            out[0, times > t] = y[0]
            break
    return out
