"""An equation as a program of its own, for Python and for Octave or MATLAB.

Both march with the classical Runge-Kutta method in small fixed steps; a step that crosses a reversal of the velocity is
shortened to it, and there friction decides whether the body turns or sticks. No package of ours is needed to run them.

Belongs here: those texts. Does not belong here: the laws (symbols.py).
"""

from __future__ import annotations

import math
from collections.abc import Callable
from textwrap import indent

from undertow.equation.equation import Equation
from undertow.equation.simulate import fastest_frequency
from undertow.equation.term import Expression
from undertow.errors import UndertowError
from undertow.front.handover.symbols import system_of

STEPS_PER_PERIOD = 200
"""Steps of the fourth-order method a period of the fastest motion: errors under 1e-6 of x0."""


def largest_step(equation: Equation, reach_m: float) -> float:
    """Largest step of a program for releases up to ``reach_m``, s."""
    if not equation.compiled:
        raise UndertowError(
            f"an equation of {len(equation.terms)} terms with a law of your own, or more hidden states than three "
            "resonators and two relaxations, cannot be handed over as a program; simulate it with undertow.simulate"
        )
    return 2.0 * math.pi / fastest_frequency(equation.theta(reach_m)) / STEPS_PER_PERIOD


def python_text(equation: Equation, reach_m: float) -> str:
    """The module's text; see `HandOver.to_python`."""
    from sympy import pycode

    step = largest_step(equation, reach_m)
    system = system_of(equation)
    values = "\n".join(f"{name} = {number!r}  # {system.words[name]}" for name, number in system.values.items())
    names = ", ".join(["x", "v", *(name for name, _ in system.states)])
    rates = ", ".join(["speed", "a", *(_printed(rate, pycode) for _, rate in system.states)])
    return _PYTHON.format(
        equation=equation, values=values, rest=repr(equation.rest_m), step=repr(step), size=2 + len(system.states),
        names=names, smooth=_printed(system.smooth, pycode), friction=_printed(system.friction, pycode), rates=rates,
        delay=system.delay or "0.0",
    )  # fmt: skip


def octave_text(equation: Equation, reach_m: float, name: str) -> str:
    """The function file's text; see `HandOver.to_octave`."""
    from sympy import Symbol, octave_code

    if not name.isidentifier():
        raise UndertowError(f"Octave cannot call a function {name!r}; give the file a name of letters and digits")
    step = largest_step(equation, reach_m)
    system = system_of(equation)
    values = "\n".join(f"p.{key} = {number!r};  % {system.words[key]}" for key, number in system.values.items())
    names = ["x", "v", *(state for state, _ in system.states)]
    unpack = "\n".join(f"{key} = y({at});" for at, key in enumerate(names, 1))
    unpack = unpack.replace("x = y(1);", f"x = y(1) - ({equation.rest_m!r});")

    def written(expression: Expression) -> str:
        given = [symbol for symbol in getattr(expression, "free_symbols", ()) if symbol.name in system.values]
        fields = {symbol: Symbol(f"p__{symbol.name}", real=True) for symbol in given}
        return _printed(expression.subs(fields) if fields else expression, octave_code).replace("p__", "p.")

    rates = "; ".join(["speed", "a", *(written(rate) for _, rate in system.states)])
    return _OCTAVE.format(
        name=name, equation=equation, values=values, step=repr(step), size=2 + len(system.states),
        unpack=indent(unpack, "  "), smooth=written(system.smooth), friction=written(system.friction), rates=rates,
        delay=f"p.{system.delay}" if system.delay else "0",
    )  # fmt: skip


def _printed(expression: Expression, printer: Callable[[Expression], str]) -> str:
    import sympy as sp

    return printer(sp.sympify(expression))


_PYTHON = '''\
"""{equation}

Free motion of this equation, written by undertow. SI units. Needs numpy alone.
"""

import bisect
import math

import numpy as np

{values}
REST_M = {rest}  # displacement in which the springs are at rest
LARGEST_STEP_S = {step}


def forces(t, y, d, echo):
    """Smooth forces and the size of friction, N, at the state y, moving to the side d (+1, -1, 0: at rest)."""
    {names} = y
    x = x - REST_M
    return {smooth}, {friction}


def rates(t, y, d, echo):
    """d(state)/dt; the body is held where d is 0."""
    {names} = y
    smooth, friction = forces(t, y, d, echo)
    speed, a = (v, -(smooth + friction * d) / mass_kg) if d else (0.0, 0.0)
    x = x - REST_M
    return np.array([{rates}])


def side(t, y, echo):
    """Where a body at rest starts to move: +1, -1, or 0 where friction holds it."""
    y = np.array(y)
    y[1] = 0.0
    for d in (1.0, -1.0):
        smooth, friction = forces(t, y, d, echo)
        if -smooth * d > friction:
            return d
    return 0.0


class Past:
    """Velocities so far, for what comes back after a delay."""

    def __init__(self):
        self.t, self.v = [0.0], [0.0]

    def add(self, t, v):
        self.t.append(t)
        self.v.append(v)

    def at(self, t):
        when = t - {delay}
        if not {delay} or when < 0.0:
            return 0.0
        i = min(max(bisect.bisect_left(self.t, when), 1), len(self.t) - 1)
        share = (when - self.t[i - 1]) / (self.t[i] - self.t[i - 1])
        return self.v[i - 1] + min(share, 1.0) * (self.v[i] - self.v[i - 1])


def step(t, y, d, h, past):
    """The state after h seconds, by the classical Runge-Kutta method."""
    k1 = rates(t, y, d, past.at(t))
    k2 = rates(t + h / 2, y + h / 2 * k1, d, past.at(t + h / 2))
    k3 = rates(t + h / 2, y + h / 2 * k2, d, past.at(t + h / 2))
    k4 = rates(t + h, y + h * k3, d, past.at(t + h))
    return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)


def ends(t, y, d, past):
    """Whether a stretch of motion (or of rest, d = 0) is over at the state y."""
    return y[1] * d < 0.0 if d else side(t, y, past.at(t)) != 0.0


def advance(t, y, d, h, past):
    """One step, or less of it up to where the body turns, sticks or starts: time, state and direction after it."""
    new = step(t, y, d, h, past)
    if not ends(t + h, new, d, past):
        return t + h, new, d
    low, high = 0.0, h
    for _ in range(60):
        middle = 0.5 * (low + high)
        if ends(t + middle, step(t, y, d, middle, past), d, past):
            high = middle
        else:
            low = middle
    t, y = t + high, step(t, y, d, high, past)
    y[1] = 0.0
    return t, y, side(t, y, past.at(t))


def simulate(x0, times, v0=0.0):
    """Displacement (m) and velocity (m/s) at ``times`` (s, rising from 0), released from x0 at v0."""
    y = np.zeros({size})
    y[0], y[1] = x0, v0
    t, past = 0.0, Past()
    d = math.copysign(1.0, v0) if v0 else side(t, y, 0.0)
    out = []
    for time in times:
        while t < time - 1e-12 * LARGEST_STEP_S:
            t, y, d = advance(t, y, d, min(LARGEST_STEP_S, time - t), past)
            past.add(t, y[1])
        out.append(y[:2])
    return np.array(out).T


if __name__ == "__main__":
    times = np.arange(0.0, 4000 * LARGEST_STEP_S, 10 * LARGEST_STEP_S)
    for t, x, v in zip(times, *simulate(0.1, times)):
        print(f"{{t:.6g}},{{x:.8g}},{{v:.8g}}")
'''

_OCTAVE = """\
function [x, v] = {name}(x0, times, v0)
% {equation}
%
% Displacement (m) and velocity (m/s) at times (s, rising from 0), released from x0 (m) at v0 (m/s).
% Free motion of this equation, written by undertow. SI units. For Octave and MATLAB.
  if nargin < 3
    v0 = 0;
  end
  p = parameters();
  largest = {step};
  y = zeros({size}, 1);
  y(1) = x0;
  y(2) = v0;
  t = 0;
  past.t = 0;
  past.v = 0;
  d = sign(v0);
  if d == 0
    d = side(t, y, 0, p);
  end
  x = zeros(size(times));
  v = zeros(size(times));
  for i = 1:numel(times)
    while t < times(i) - 1e-12 * largest
      [t, y, d] = advance(t, y, d, min(largest, times(i) - t), past, p);
      if {delay} > 0
        past.t(end + 1) = t;
        past.v(end + 1) = y(2);
      end
    end
    x(i) = y(1);
    v(i) = y(2);
  end
end

function p = parameters()
{values}
end

function [smooth, friction] = forces(t, y, d, echo, p)
% Smooth forces and the size of friction, N, at the state y, moving to the side d (+1, -1, 0: at rest).
{unpack}
  smooth = {smooth};
  friction = {friction};
end

function dy = rates(t, y, d, echo, p)
% d(state)/dt; the body is held where d is 0.
{unpack}
  [smooth, friction] = forces(t, y, d, echo, p);
  speed = 0;
  a = 0;
  if d ~= 0
    speed = v;
    a = -(smooth + friction * d) / p.mass_kg;
  end
  dy = [{rates}];
end

function d = side(t, y, echo, p)
% Where a body at rest starts to move: +1, -1, or 0 where friction holds it.
  y(2) = 0;
  for d = [1, -1]
    [smooth, friction] = forces(t, y, d, echo, p);
    if -smooth * d > friction
      return;
    end
  end
  d = 0;
end

function echo = echo_at(t, past, p)
% The velocity a delay ago, for what comes back.
  echo = 0;
  when = t - {delay};
  if {delay} > 0 && when >= 0
    if numel(past.t) > 1
      echo = interp1(past.t, past.v, min(when, past.t(end)));
    end
  end
end

function y = march(t, y, d, h, past, p)
% The state after h seconds, by the classical Runge-Kutta method.
  k1 = rates(t, y, d, echo_at(t, past, p), p);
  k2 = rates(t + h / 2, y + h / 2 * k1, d, echo_at(t + h / 2, past, p), p);
  k3 = rates(t + h / 2, y + h / 2 * k2, d, echo_at(t + h / 2, past, p), p);
  k4 = rates(t + h, y + h * k3, d, echo_at(t + h, past, p), p);
  y = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
end

function over = ends(t, y, d, past, p)
% Whether a stretch of motion (or of rest, d = 0) is over at the state y.
  if d ~= 0
    over = y(2) * d < 0;
  else
    over = side(t, y, echo_at(t, past, p), p) ~= 0;
  end
end

function [t, y, d] = advance(t, y, d, h, past, p)
% One step, or less of it up to where the body turns, sticks or starts.
  new = march(t, y, d, h, past, p);
  if ~ends(t + h, new, d, past, p)
    t = t + h;
    y = new;
    return;
  end
  low = 0;
  high = h;
  for i = 1:60
    middle = 0.5 * (low + high);
    if ends(t + middle, march(t, y, d, middle, past, p), d, past, p)
      high = middle;
    else
      low = middle;
    end
  end
  y = march(t, y, d, high, past, p);
  t = t + high;
  y(2) = 0;
  d = side(t, y, echo_at(t, past, p), p);
end
"""
