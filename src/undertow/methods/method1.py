"""Method 1, the report's recipe: added mass and drag coefficient from the displacement's time history.

Fourth-order Runge-Kutta at 1 ms with sign() in the right-hand side, Nelder-Mead on (m_a, C_d), displacement RMS,
m_a >= 0; k, c, mu fixed at their dry values (report pages on Method 1; MATLAB's fminsearch). Kept as it was printed,
its integration error at reversals included, because it is what the report's tables were made with.

Belongs here: that recipe on a compiled right-hand side. Does not belong here: anything better (output_error.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.optimize import OptimizeResult, minimize

from undertow.compiling import compiled
from undertow.conditioning.motion import Motion
from undertow.conditioning.period import dominant_period
from undertow.equation.kernel import N_SLOTS, SLOT
from undertow.errors import IdentificationError
from undertow.likelihood.fit import Fit, Specimen, Structure
from undertow.likelihood.output_error import Solution, residuals
from undertow.likelihood.problem import Channel, Link, Problem, TrialProblem, Unknown
from undertow.quantities import OK, Estimate
from undertow.recording.recording import Array
from undertow.uncertainty.intervals import noise_covariance

STEPS_PER_PERIOD = 1000
"""Time steps a period of the dry body: the report's 1 ms on its long spring, half of that on the short one."""

ROUNDING = 1e-9
"""Least noise of a displacement, relative to its range."""

STARTS: tuple[tuple[float, float], ...] = ((0.2, 5.0), (0.4, 20.0), (0.05, 1.0))
"""Initial trials of (m_a / m, C_d); the best end is taken, since near a resonance there are two minima."""

COARSE = {"xatol": 1e-3, "fatol": 3e-6, "maxiter": 400}
FINE = {"xatol": 1e-5, "fatol": 3e-8, "maxiter": 400}
"""Where the simplex stops, in m_a / m or C_d and in RMS over that of the displacement: from the starts, and from the
best of their ends."""

SAME_VALLEY = (0.01, 0.5)
SAME_RMS = 1.1
"""So near to an end in (m_a / m, C_d), with so much of its RMS at most, a later start only goes there again: the two
minima near a resonance are ten times as far apart."""


@njit("f8(f8)", cache=True, inline="always", error_model="numpy")
def _sign(v):  # type: ignore[no-untyped-def]
    return 1.0 if v > 0.0 else (-1.0 if v < 0.0 else 0.0)


@compiled("f8[::1](f8, f8, f8, f8, f8, f8, f8, i8)", error_model="numpy")
def runge_kutta(
    mass: float, c: float, k: float, friction: float, drag: float, x0: float, dt: float, n: int
) -> Array:
    """Displacement (n + 1,) of M x'' + c x' + k x + F sign(x') + q x'|x'| = 0 from rest at x0, classical RK4."""
    out = np.empty(n + 1)
    x, v = x0, 0.0
    out[0] = x
    c, k, friction, drag = c / mass, k / mass, friction / mass, drag / mass
    half, sixth = 0.5 * dt, dt / 6.0
    for i in range(n):
        a1 = -(k * x + c * v + friction * _sign(v) + drag * v * abs(v))
        v2 = v + half * a1
        a2 = -(k * (x + half * v) + c * v2 + friction * _sign(v2) + drag * v2 * abs(v2))
        v3 = v + half * a2
        a3 = -(k * (x + half * v2) + c * v3 + friction * _sign(v3) + drag * v3 * abs(v3))
        v4 = v + dt * a3
        a4 = -(k * (x + dt * v3) + c * v4 + friction * _sign(v4) + drag * v4 * abs(v4))
        x += sixth * (v + 2.0 * v2 + 2.0 * v3 + v4)
        v += sixth * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        out[i + 1] = x
    return out


@dataclass(frozen=True)
class History:
    """What Method 1 fits: instants ``t`` (n,) s after the release, displacement ``x`` (n,) m from rest, and x0 (m)."""

    t: Array
    x: Array
    x0: float


def history(motion: Motion) -> History:
    """The displacement history of a motion, from its release to the end of its window."""
    keep = (motion.t >= 0.0) & (motion.t <= motion.window.end_s - motion.window.release_s)
    x = motion.recorded("displacement") - motion.equilibrium.value
    return History(motion.t[keep], np.ascontiguousarray(x[keep]), float(motion.x[0] - motion.equilibrium.value))


def search(
    data: History, structure: tuple[float, float, float], specimen: Specimen, lower_mass_kg: float = 0.0
) -> tuple[float, float, float]:
    """(m_a in kg, C_d, displacement RMS in m) that Method 1 returns; ``structure`` is (k, c, mu).

    ``lower_mass_kg`` is the bound on m_a (the report's 0; -inf lifts it).
    """
    k, c, mu = structure
    friction = mu * specimen.normal_force_N
    drag_unit = specimen.drag_N_per_unit_coefficient
    step = 2.0 * math.pi * math.sqrt(specimen.mass_kg / k) / STEPS_PER_PERIOD
    steps = math.ceil(float(data.t[-1]) / step)
    grid = np.arange(steps + 1) * step
    size = float(np.sqrt(np.mean(data.x**2)))

    def rms(p: Array) -> float:
        mass = specimen.mass_kg * (1.0 + max(float(p[0]), lower_mass_kg / specimen.mass_kg))
        if mass <= 0.1 * specimen.mass_kg:
            return math.inf
        x = runge_kutta(mass, c, k, friction, drag_unit * float(p[1]), data.x0, step, steps)
        with np.errstate(over="ignore", invalid="ignore"):  # negative drag runs away: a worse trial, not an error
            error = np.interp(data.t, grid, x) - data.x
            value = float(np.sqrt(np.mean(error * error))) / size
        return value if math.isfinite(value) else math.inf

    ends: list[OptimizeResult] = []

    def known(intermediate_result: OptimizeResult) -> None:
        """Stops a start that has come into the valley of an end already found."""
        for end in ends:
            near = np.all(np.abs(intermediate_result.x - end.x) < SAME_VALLEY)
            if near and intermediate_result.fun < SAME_RMS * end.fun:
                raise StopIteration

    for start in STARTS:
        ends.append(minimize(rms, np.array(start), method="Nelder-Mead", options=COARSE, callback=known))
    first = min(ends, key=lambda end: float(end.fun))
    # sign() makes the valley's floor rough, and a simplex stops on it: a new one from there goes on
    best = min(first, minimize(rms, first.x, method="Nelder-Mead", options=FINE), key=lambda end: float(end.fun))
    added = max(float(best.x[0]) * specimen.mass_kg, lower_mass_kg)
    return added, float(best.x[1]), float(best.fun) * size


def fit(motion: Motion, structure: Structure, specimen: Specimen) -> Fit:
    """Method 1 on one trial: added_mass_kg and drag_coefficient with noise and systematic errors.

    Errors are linear: sensitivities of the exact trajectory at the answer, the residual's own colour, and k, c, mu
    moved by their standard errors.

    Raises IdentificationError where mass, area or displacement is missing.
    """
    if not math.isfinite(specimen.mass_kg) or not specimen.area_m2 > 0.0:
        raise IdentificationError(
            f"trial {motion.name}: Method 1 needs mass_kg and area_m2, got {specimen.mass_kg:g} kg and "
            f"{specimen.area_m2:g} m2; add them to the specimen"
        )
    if "displacement" not in motion.recording.channels:
        have = ", ".join(motion.recording.channels)
        raise IdentificationError(f"trial {motion.name}: Method 1 fits displacement, recorded are {have}; map it")
    data = history(motion)
    added, drag, rms = search(data, (structure.k.value, structure.c.value, structure.mu.value), specimen)
    noise, systematic = _errors(motion, data, structure, specimen, (added, drag), rms)
    on_bound = added <= 0.0
    outcome = "added_mass_kg on its bound 0 kg" if on_bound else OK
    apart = f"{rms:.3g} rad" if specimen.rotation else f"{1e3 * rms:.3g} mm"
    estimates = {
        "added_mass_kg": Estimate(
            added, math.nan if on_bound else noise[0], systematic[0], specimen.unit("kg"), "method1", outcome
        ),
        "drag_coefficient": Estimate(drag, noise[1], systematic[1], "1", "method1", OK),
        "total_mass_kg": Estimate(
            specimen.mass_kg + added, noise[0], systematic[0], specimen.unit("kg"), "method1", outcome
        ),
    }
    return Fit("method1", (motion.name,), {}, estimates, outcome, (f"displacement RMS {apart}",), "mass")


def _errors(
    motion: Motion,
    data: History,
    structure: Structure,
    specimen: Specimen,
    answer: tuple[float, float],
    rms: float,
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Standard errors of (m_a, C_d) from noise, and from k, c, mu."""
    base = np.zeros(N_SLOTS)
    base[SLOT["mass"]] = specimen.mass_kg
    base[SLOT["x0"]] = data.x0
    normal, drag_unit = specimen.normal_force_N, specimen.drag_N_per_unit_coefficient
    unknowns = (
        Unknown("added_mass_kg", answer[0]), Unknown("drag_coefficient", answer[1]),
        Unknown("k", structure.k.value), Unknown("c", structure.c.value), Unknown("mu", structure.mu.value),
    )  # fmt: skip
    links = (
        Link(SLOT["mass"], 0), Link(SLOT["q"], 1, drag_unit), Link(SLOT["k1"], 2), Link(SLOT["c1"], 3),
        Link(SLOT["fc"], 4, normal),
    )  # fmt: skip
    step = max(1, data.t.size // 1500)
    channel = Channel("displacement", data.x[::step], max(rms, ROUNDING * float(np.ptp(data.x))))
    trial = TrialProblem(motion.name, data.t[::step], base, links, (channel,), -1, 0.0, dominant_period(motion))
    values = np.array([u.start for u in unknowns])
    got = residuals(trial, values)
    if got is None:
        return (math.nan, math.nan), (math.nan, math.nan)
    r, jac, _ = got
    two = jac[:, :2]
    covariance = np.asarray(np.linalg.pinv(two.T @ two), dtype=np.float64)
    problem = Problem(unknowns[:2], (trial,))
    solution = Solution(
        problem, values[:2], covariance, 0.0, float(r @ r), r.size, 0, OK, (r,), (two,), (np.arange(2),)
    )
    noise = np.sqrt(np.maximum(np.diag(noise_covariance(solution)), 0.0))
    moves = -covariance @ two.T @ jac[:, 2:] @ np.diag(
        [structure.k.total_stderr, structure.c.total_stderr, structure.mu.total_stderr]
    )
    systematic = np.sqrt(np.sum(np.nan_to_num(moves) ** 2, axis=1))
    return (float(noise[0]), float(noise[1])), (float(systematic[0]), float(systematic[1]))
