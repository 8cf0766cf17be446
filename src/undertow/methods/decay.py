"""The structure's own parameters from dry decays: envelope, period and load cells.

The envelope of a decay with viscous and dry friction (report Eqs. 2-13; Markho 1980) is, at turning point i,

    A_i = x0 e^{-z i / 2} - c0 (1 - e^{-z i / 2}),   c0 = x_f coth(z / 4),   z = 2 pi zeta / sqrt(1 - zeta^2)

which is Eq. 10 at t = i T / 2; Eq. 2 as printed has the wrong sign in its last exponent. It is exact for Eq. 1.

Belongs here: dry trials, and the spring by its load cells. Does not belong here: water.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from undertow.conditioning.motion import Motion
from undertow.errors import IdentificationError
from undertow.likelihood.fit import Fit, Specimen
from undertow.quantities import OK, Estimate
from undertow.uncertainty.robust import robust_covariance

Array = NDArray[np.float64]

MIN_TURNING_POINTS = 5
"""The envelope has four unknowns: first amplitude, z, x_f and the rest position."""

NOTICEABLE_STIFFNESS_SHARE = 0.01
"""Two stiffnesses that differ by more than this are told to the reader."""


@dataclass(frozen=True)
class Envelope:
    """Envelope of one decay: ``values`` z, x_f (m) and omega_d (rad/s), with their ``covariance`` (3, 3).

    ``rest_m`` is the rest position in the sensor's scale.
    """

    values: Array
    covariance: Array
    rest_m: float

    @property
    def damping_ratio(self) -> float:
        """zeta = z / sqrt(4 pi^2 + z^2), from Eq. 3."""
        z = float(self.values[0])
        return z / math.hypot(2.0 * math.pi, z)

    @property
    def natural_frequency_rad_per_s(self) -> float:
        """omega_n = omega_d / sqrt(1 - zeta^2), rad/s (Eq. 7); dry friction does not change the period."""
        return float(self.values[2]) / math.sqrt(1.0 - self.damping_ratio**2)


def turning_points(motion: Motion) -> tuple[Array, Array]:
    """Instants (s after the release) and displacements (m, sensor's scale) where v changes sign in the window, (n,)."""
    t, x, v, a = (motion.windowed(name) for name in ("t", "x", "v", "a"))
    before = np.flatnonzero(v[:-1] * v[1:] < 0.0)
    step = t[before + 1] - t[before]
    # friction makes a jump at the turn, so that each side is extrapolated with its own a; both see the same instant
    left, right = -v[before] / a[before], step - v[before + 1] / a[before + 1]
    delay = np.clip(0.5 * (left + right), 0.0, step)
    return t[before] + delay, x[before] + 0.5 * v[before] * delay


def fit_envelope(motion: Motion) -> Envelope:
    """The report's envelope (Eqs. 2-13) fitted to the turning points of one trial.

    Raises IdentificationError with fewer than 5 turning points in the window.
    """
    times, places = turning_points(motion)
    if times.size < MIN_TURNING_POINTS:
        raise IdentificationError(
            f"trial {motion.name}: {times.size} turning points in the window from {motion.window.start_s:g} to "
            f"{motion.window.end_s:g} s; the envelope needs {MIN_TURNING_POINTS}: take a larger release"
        )
    index = np.arange(times.size, dtype=np.float64)
    sides = np.sign(places[0] - places[1]) * (-1.0) ** index
    scale = 0.5 * abs(places[0] - places[1])

    def misfit(unknowns: Array) -> Array:
        first, z, friction, rest = unknowns
        difference: Array = places / scale - rest - sides * _envelope(first, z, friction, index)
        return difference

    start = [1.0, 0.05, 0.01, float(np.mean(places[-2:])) / scale]
    bounds = ([0.0, 1e-6, -1.0, -np.inf], [np.inf, 2.0 * math.pi, 1.0, np.inf])
    found = least_squares(misfit, start, bounds=bounds, x_scale=[1.0, 0.1, 0.01, 0.01], xtol=1e-14, ftol=1e-14)
    spread = float(np.sum(found.fun**2)) / max(times.size - 4, 1)
    noise = float(np.interp(times, motion.t, motion.x_std).mean()) / scale
    covariance = np.linalg.inv(found.jac.T @ found.jac) * max(spread, noise**2)
    slope, slope_error = _half_period(times, float(np.interp(times, motion.t, motion.v_std).mean()), motion)
    frequency = math.pi / slope
    stretch = np.array([1.0, scale])
    joint = np.zeros((3, 3))
    joint[:2, :2] = covariance[1:3, 1:3] * np.outer(stretch, stretch)
    joint[2, 2] = (frequency * slope_error / slope) ** 2
    return Envelope(
        values=np.array([found.x[1], found.x[2] * scale, frequency]),
        covariance=joint,
        rest_m=float(found.x[3] * scale),
    )


def _envelope(first: float, z: float, friction: float, index: Array) -> Array:
    """Amplitudes (n,) at turning points 0, 1, ...: Eq. 10 at t = i T / 2, in the unit of ``first`` and ``friction``."""
    left = np.exp(-0.5 * z * index)
    amplitudes: Array = first * left - friction / math.tanh(0.25 * z) * (1.0 - left)
    return amplitudes


def _half_period(times: Array, v_std: float, motion: Motion) -> tuple[float, float]:
    """Time between turning points and its standard error, s: straight line through their instants."""
    index = np.arange(times.size) - 0.5 * (times.size - 1)
    slope = float(index @ times / (index @ index))
    residual = times - times.mean() - slope * index
    spread = math.sqrt(float(residual @ residual) / max(times.size - 2, 1))
    # an error of v moves its zero by v_std / |a|
    a_at = np.abs(np.interp(times, motion.t, motion.a))
    noise = v_std / float(np.median(a_at)) if np.median(a_at) > 0.0 else 0.0
    return slope, max(spread, noise) / math.sqrt(float(index @ index))


def identify_decay(motion: Motion, specimen: Specimen) -> Fit:
    """zeta, omega_n, c, mu and k of one dry decay by its envelope and period.

    c = 2 zeta omega_n m (Eq. 4), x_f = mu N / k (Eq. 6), k = m omega_n^2 (Eq. 14). The mass is the specimen's; without
    one it is k / omega_n^2 from the specimen's stiffness; without either, c and k come over mass and mu from
    x_f omega_n^2 / g. Of a rotation friction is a moment, not a share of the weight.

    Raises IdentificationError as `fit_envelope` does.
    """
    envelope = fit_envelope(motion)
    mass, anchor = specimen.mass_kg, "mass"
    if not math.isfinite(mass):
        mass, anchor = specimen.stiffness_N_per_m / envelope.natural_frequency_rad_per_s**2, "stiffness"
    suffix = ""
    if not math.isfinite(mass):
        mass, anchor, suffix = 1.0, "none", "_per_mass"
    buoyancy = specimen.submerged_volume_m3 * specimen.water_density_kg_per_m3 if not suffix else 0.0
    normal = (mass - buoyancy) * specimen.gravity_m_per_s2

    rubs, of, share = ("mu", "1", normal) if not specimen.rotation else (f"friction_N{suffix}", "N", 1.0)

    def derive(values: Array) -> Array:
        z, friction, frequency = values
        zeta = z / math.hypot(2.0 * math.pi, z)
        natural = frequency / math.sqrt(1.0 - zeta**2)
        stiffness = mass * natural**2
        return np.array([zeta, natural, 2.0 * zeta * natural * mass, friction * stiffness / share, stiffness])

    values, jacobian = derive(envelope.values), central_slopes(derive, envelope.values)
    errors = np.sqrt(np.diag(jacobian @ envelope.covariance @ jacobian.T))
    over = f" / {specimen.unit('kg')}" if suffix else ""
    names = {
        "damping_ratio": "1",
        "natural_frequency_rad_per_s": "rad/s",
        f"c_Ns_per_m{suffix}": f"{specimen.unit('N s/m')}{over}",
        rubs: of if of == "1" else f"{specimen.unit(of)}{over}",
        f"k_N_per_m{suffix}": f"{specimen.unit('N/m')}{over}",
    }
    parameters = {
        name: Estimate(float(value), float(error), unit=unit, source="decay envelope", outcome=_outcome(value, error))
        for (name, unit), value, error in zip(names.items(), values, errors, strict=True)
    }
    return Fit("decay", (motion.name,), parameters=parameters, anchor=anchor, notes=_spring_note(motion, parameters))


def _outcome(value: float, error: float) -> str:
    if abs(value) < 2.0 * error:
        return f"not distinct from 0: {value:.3g} with a standard error of {error:.2g}"
    return OK


def central_slopes(function: Callable[[Array], Array], point: Array, size: float = 1.0) -> Array:
    """Central differences (m, n) at ``point`` (n,), each step 1e-6 of the value (of ``size`` where it is 0): of smooth
    closed forms, error 1e-10.

    >>> central_slopes(np.square, np.array([3.0])).round(6).tolist()
    [[6.0]]
    """
    columns = []
    for index in range(point.size):
        step = np.zeros_like(point)
        step[index] = 1e-6 * (abs(float(point[index])) or size)
        columns.append((function(point + step) - function(point - step)) / (2.0 * step[index]))
    return np.column_stack(columns)


def _spring_note(motion: Motion, parameters: dict[str, Estimate]) -> tuple[str, ...]:
    if "spring_force" not in motion.recording.channels or "k_N_per_m" not in parameters:
        return ()
    return (stiffness_disagreement(parameters["k_N_per_m"], load_cell_stiffness(motion)),)


def load_cell_stiffness(motion: Motion) -> Estimate:
    """k in N/m of one trial: slope of the spring force against displacement over the hold and the window.

    Constants take up the offsets of both sensors; a column of v takes up a small delay between them, F(t - tau) = k x -
    k tau v. Displacement is the smoothed one in the window and the mean of the hold before it, so that its noise does
    not flatten the slope.

    Raises IdentificationError where no spring force was recorded.
    """
    if "spring_force" not in motion.recording.channels:
        have = ", ".join(motion.recording.channels)
        raise IdentificationError(f"trial {motion.name} has no channel spring_force; it has {have}: map the load cells")
    force, displacement = motion.recording.channels["spring_force"], motion.recording.channels["displacement"]
    moving = motion.recorded("spring_force")[motion.inside]
    hold = motion.recording.time < motion.window.release_s - motion.window.release_stderr_s
    held = int(np.count_nonzero(hold)) if motion.window.held else 0
    x, v, y = motion.windowed("x"), motion.windowed("v"), moving
    if held:
        x = np.concatenate([np.full(held, displacement[hold].mean()), x])
        v = np.concatenate([np.zeros(held), v])
        y = np.concatenate([force[hold], y])
    columns = np.column_stack([x - x.mean(), v, np.ones_like(x)])
    solution = np.linalg.lstsq(columns, y, rcond=None)[0]
    period_s = 2.0 * math.pi * math.sqrt(np.mean(motion.windowed("v") ** 2) / np.mean(motion.windowed("a") ** 2))
    block = max(2, round(period_s * motion.recording.rate_hz))
    covariance, _ = robust_covariance([columns], [y - columns @ solution], block)
    value, error = float(solution[0]), math.sqrt(covariance[0, 0])
    if held:
        leverage = held * abs(columns[0, 0]) / float(columns[:, 0] @ columns[:, 0])
        error = math.hypot(error, value * leverage * float(displacement[hold].std()) / math.sqrt(held))
    return Estimate(value, error, unit="N/m", source="load cells")


def stiffness_disagreement(by_period: Estimate, by_load_cells: Estimate) -> str:
    """One sentence on two stiffnesses, N/m, with both numbers and whether they agree within 1 %.

    >>> stiffness_disagreement(Estimate(386.5e3, 4e3, unit="N/m"), Estimate(403e3, 3e3, unit="N/m"))[-54:]
    'load cells: they differ by 4.3 % (3.3 standard errors)'
    """
    share = (by_load_cells.value - by_period.value) / by_period.value
    error = math.hypot(by_period.total_stderr, by_load_cells.total_stderr)
    count = abs(by_load_cells.value - by_period.value) / error if error > 0.0 else math.inf
    verdict = "they differ" if abs(share) > NOTICEABLE_STIFFNESS_SHARE else "they agree within 1 %, apart"
    return (
        f"k is {by_period} by the period, {by_load_cells} by the load cells: {verdict} by "
        f"{100.0 * abs(share):.2g} % ({count:.2g} standard errors)"
    )
