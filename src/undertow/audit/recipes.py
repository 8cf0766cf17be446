"""What a paper's recipe returns for a motion that some physics made: Methods 1 and 2 run on exact trajectories.

Method 1's answer is the minimum of the displacement RMS over (m_a, C_d), m_a held at its bound
(methods/method1.py has the recipe as printed). On a trajectory without noise the same minimum is found by
Gauss-Newton on exact sensitivities, two hundred times faster than by Nelder-Mead; a coarse look over masses comes
first where there may be two minima.

Belongs here: recipes on simulated motions. Does not belong here: recipes on recordings (methods/), rivals.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from undertow.equation.kernel import N_SLOTS, SLOT, integrate
from undertow.errors import UndertowError
from undertow.methods.method2 import Instant, added_mass_at_peak, drag_at_crossing

Array = NDArray[np.float64]

SAMPLES_A_PERIOD = 16
"""Samples of the compared histories: without noise more of them change nothing (docs/published_tables.md)."""

STEPS_A_PERIOD = 14
"""Integrator's steps: beside 40 samples and steps a period the answers move by 0.2 kg and 0.1 in C_d (root mean square
over 45 rows of simulated tables), as much as with 20 steps."""

SEARCHED_MASSES = tuple(np.linspace(0.8, 1.8, 21))
"""Total masses over the structure's at which the RMS is looked at first where there may be several minima."""

SMALLEST_MASS_SHARE = 0.3
"""Total masses below this share of the structure's are not looked at: no added mass is that negative."""

DRAG_STARTS = (0.5, 2.0)
"""Starts of the drag over one that takes 5 % of the spring's force at the largest speed: sticking makes minima too."""

ITERATIONS = 25
STEP_TOLERANCE = 1e-3
"""The search ends with the first step that moves mass and drag by less than this share: the next would be a tenth."""

SLOPE_STEPS = 2
"""Steps of a search from an answer whose physics was moved a little: the rest of the way is second order."""

_NONE = np.zeros(0, dtype=np.int64)
_FITTED = np.array([SLOT["mass"], SLOT["q"]])


@dataclass(frozen=True)
class Known:
    """What the recipe holds fixed: mass kg, k N/m, c N s/m, mu, area m^2, submerged volume m^3, density kg/m^3, g."""

    mass_kg: float
    k_N_per_m: float
    c_Ns_per_m: float
    mu: float
    area_m2: float
    volume_m3: float = 0.0
    density_kg_per_m3: float = 1000.0
    gravity_m_per_s2: float = 9.81

    @property
    def friction_N(self) -> float:
        """mu (m g - V rho g), N."""
        return self.mu * (self.mass_kg - self.volume_m3 * self.density_kg_per_m3) * self.gravity_m_per_s2

    @property
    def drag_unit(self) -> float:
        """rho A / 2: drag force per unit C_d and squared velocity, kg/m."""
        return 0.5 * self.density_kg_per_m3 * self.area_m2

    def equation_15(self, mass_kg: float, drag: float, x0_m: float) -> Array:
        """Parameter vector of Eq. 15 released from ``x0_m``: total mass, and drag in N s^2/m^2."""
        theta = np.zeros(N_SLOTS)
        theta[SLOT["mass"]], theta[SLOT["q"]], theta[SLOT["x0"]] = mass_kg, drag, x0_m
        theta[SLOT["k1"]], theta[SLOT["c1"]], theta[SLOT["fc"]] = self.k_N_per_m, self.c_Ns_per_m, self.friction_N
        return theta


@dataclass(frozen=True)
class Returned:
    """What a recipe gives: added mass kg (without its bound), C_d, C_d with m_a on the bound 0."""

    added_mass_kg: float
    drag_coefficient: float
    bounded_drag: float = math.nan

    @property
    def bounded(self) -> tuple[float, float]:
        """(m_a, C_d) as printed under the bound m_a >= 0."""
        if self.added_mass_kg >= 0.0:
            return self.added_mass_kg, self.drag_coefficient
        return 0.0, self.bounded_drag


def trajectory(theta: Array, times: Array, step_s: float) -> tuple[Array, Array, Array]:
    """x, v, a (n,) of a parameter vector (kernel slots) at ``times``; UndertowError where it leaves every bound."""
    x, v, a, _, steps = integrate(theta, _NONE, times, step_s)
    if steps < 0:
        raise UndertowError(
            f"a rival's motion from {theta[SLOT['x0']]:g} m left every bound after {-steps} steps; narrow its prior"
        )
    return x[:, 0], v[:, 0], a[:, 0]


def method1_returns(
    theta: Array, known: Known, window_s: float, offset_m: float = 0.0, start: Returned | None = None,
    on_bound: bool = False, steps: int = ITERATIONS,
) -> Returned:  # fmt: skip
    """What Method 1 returns for the motion of ``theta`` recorded with a displacement offset, over ``window_s``.

    The history ends where the body stops for good. ``start`` is an answer near by, where only one minimum is expected
    (``steps`` are the most it may be away); without it masses are searched first. ``on_bound`` asks for C_d at m_a = 0
    even where m_a comes out positive.
    """
    period = 2.0 * math.pi * math.sqrt(known.mass_kg / known.k_N_per_m)
    times = np.arange(0.0, window_s, period / SAMPLES_A_PERIOD)
    step = period / STEPS_A_PERIOD
    x, v, _ = trajectory(theta, times, step)
    moving = int(np.flatnonzero(v)[-1]) + 2 if np.any(v) else times.size
    fitter = _Fitter(times[:moving], x[:moving] + offset_m, step, known)
    if start is None:
        return fitter.search()
    unit, bounded = known.drag_unit, math.nan
    mass, q, _ = fitter.descend(known.mass_kg + start.added_mass_kg, start.drag_coefficient * unit, steps=steps)
    if on_bound:
        first = start.bounded_drag if math.isfinite(start.bounded_drag) else start.drag_coefficient
        bounded = fitter.descend(known.mass_kg, first * unit, fixed_mass=True, steps=steps)[1] / unit
    return Returned(mass - known.mass_kg, q / unit, bounded)


@dataclass(frozen=True)
class _Fitter:
    """Eq. 15 fitted to a displacement history ``x`` (n,) m at ``times`` (n,) s: total mass and drag."""

    times: Array
    x: Array
    step_s: float
    known: Known

    def theta(self, mass: float, q: float) -> Array:
        """Parameter vector of Eq. 15 with what the recipe holds fixed; total mass kg, drag N s^2/m^2."""
        return self.known.equation_15(mass, q, float(self.x[0]))

    def rms(self, mass: float, q: float) -> float:
        """What Method 1 minimises: displacement RMS, m; infinite where the motion runs away."""
        x, _, _, _, steps = integrate(self.theta(mass, q), _NONE, self.times, self.step_s)
        return math.sqrt(float(np.mean((x[:, 0] - self.x) ** 2))) if steps >= 0 else math.inf

    def descend(
        self, mass: float, q: float, fixed_mass: bool = False, steps: int = ITERATIONS
    ) -> tuple[float, float, float]:
        """Gauss-Newton with damped steps from (mass, q): the minimum (mass, q, RMS before the last step)."""
        damping, lowest = 0.0, SMALLEST_MASS_SHARE * self.known.mass_kg
        best, normal = self._normal(mass, q)
        for i in range(steps):
            to_mass, to_q = _step(normal, damping, fixed_mass)
            new_mass = mass + to_mass if mass + to_mass > lowest else 0.5 * (mass + lowest)
            small = max(abs(to_mass) / self.known.mass_kg, abs(to_q) / self.known.drag_unit) < STEP_TOLERANCE
            if small or i + 1 == steps < ITERATIONS:
                mass, q = new_mass, q + to_q
                break
            value, new_normal = self._normal(new_mass, q + to_q)
            if value <= best:
                mass, q, best, normal, damping = new_mass, q + to_q, value, new_normal, damping * 0.1
            else:
                damping = max(10.0 * damping, 1e-3)
        return mass, q, math.sqrt(best / self.x.size)

    def _normal(self, mass: float, q: float) -> tuple[float, tuple[float, float, float, float, float]]:
        """Sum of squares and the normal equations: three products of the slopes, two gradients."""
        x, _, _, _, steps = integrate(self.theta(mass, q), _FITTED, self.times, self.step_s)
        if steps < 0:
            return math.inf, (1.0, 0.0, 1.0, 0.0, 0.0)
        x[:, 0] -= self.x
        p = (x.T @ x).tolist()
        return p[0][0], (p[1][1], p[1][2], p[2][2], p[1][0], p[2][0])

    def search(self) -> Returned:
        """The least of all minima that a scan over masses leads to, the bound m_a >= 0 as the recipe keeps it."""
        size = abs(float(self.x[0])) * math.sqrt(self.known.k_N_per_m / self.known.mass_kg)
        q = self.known.k_N_per_m * abs(float(self.x[0])) * 0.05 / max(size, 1e-9) ** 2
        masses = [share * self.known.mass_kg for share in SEARCHED_MASSES]
        values = [self.rms(mass, q) for mass in masses]
        edges = [math.inf, *values, math.inf]
        low = [i for i in range(len(values)) if edges[i + 1] <= edges[i] and edges[i + 1] <= edges[i + 2]]
        low = sorted(low, key=lambda i: values[i])[:2]
        found = sorted((self.descend(masses[i], q * more) for i in low for more in DRAG_STARTS), key=lambda end: end[2])
        answer = self.returned(*found[0][:2])
        if answer.added_mass_kg >= 0.0:
            return answer
        at_bound = self.descend(self.known.mass_kg, q, fixed_mass=True)
        above = [end for end in found if end[0] >= self.known.mass_kg and end[2] < at_bound[2]]
        return self.returned(*above[0][:2]) if above else answer

    def returned(self, mass: float, q: float) -> Returned:
        """An end of the search as the recipe prints it, with C_d on the bound."""
        unit = self.known.drag_unit
        bounded = self.descend(self.known.mass_kg, q, fixed_mass=True)[1] / unit
        return Returned(mass - self.known.mass_kg, q / unit, bounded)


def method2_returns(
    theta: Array, known: Known, offset_m: float = 0.0, turn_share: float = 0.0, keep_inertia: bool = True
) -> Returned:
    """What Method 2 returns for the motion of ``theta`` recorded with a displacement offset.

    At the first turning point friction jumps; ``turn_share`` says on which side of the jump the acceleration is read: 1
    just before (friction brakes), -1 just after (and at the release itself), 0 in the middle, where a zero-phase
    low-pass reads it. ``keep_inertia`` False takes Eq. 21 as printed, in magnitude.

    UndertowError where the motion ends before the first turning point.
    """
    mass, k = float(theta[SLOT["mass"]]), float(theta[SLOT["k1"]])
    for slot in ("hm1", "hm2", "hm3"):
        mass += float(theta[SLOT[slot]])
    period = 2.0 * math.pi * math.sqrt(mass / k)
    times = np.linspace(0.0, period, 400)
    x, v, a = trajectory(theta, times, period / 60.0)
    turns = np.flatnonzero((v[1:-1] * v[2:] <= 0.0) & (v[1:-1] != 0.0)) + 1
    recorded = x + offset_m
    crossings = np.flatnonzero(recorded[:-1] * recorded[1:] < 0.0)
    if not turns.size or not crossings.size or crossings[0] > turns[0]:
        raise UndertowError(
            f"a motion from {theta[SLOT['x0']]:g} m sticks within half a cycle; Method 2 needs one: larger releases"
        )
    i, j = int(turns[0]), int(crossings[0])
    wait = -v[i] / a[i]
    friction = float(theta[SLOT["fc"]])
    push = a[i] - math.copysign(1.0, a[i]) * (1.0 - turn_share) * friction / float(theta[SLOT["mass"]])
    peak = Instant(times[i] + wait, recorded[i] + 0.5 * v[i] * wait, 0.0, push)
    share = recorded[j] / (recorded[j] - recorded[j + 1])
    crossing = Instant(0.0, 0.0, float(v[j] + share * (v[j + 1] - v[j])), float(a[j] + share * (a[j + 1] - a[j])))
    added = added_mass_at_peak(peak, known.k_N_per_m, known.mass_kg)
    inertia = known.mass_kg + added if keep_inertia else 0.0
    drag = drag_at_crossing(crossing, inertia, known.c_Ns_per_m, known.friction_N, known.drag_unit)
    return Returned(added, drag if keep_inertia else abs(drag), drag)


def _step(normal: tuple[float, float, float, float, float], damping: float, fixed_mass: bool) -> tuple[float, float]:
    """The damped step of (mass, q) from the normal equations of two unknowns, or of q alone."""
    mm, mq, qq, to_m, to_q = normal
    mm, qq = mm * (1.0 + damping), qq * (1.0 + damping)
    determinant = mm * qq - mq * mq
    if fixed_mass or determinant <= 0.0:
        return 0.0, -to_q / qq
    return -(qq * to_m - mq * to_q) / determinant, -(mm * to_q - mq * to_m) / determinant
