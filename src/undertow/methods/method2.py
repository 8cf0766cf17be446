"""Method 2 of the flume report, the "CH Instant Method": a force balance at two instants.

At the first acceleration peak after the release x' = 0, and Eqs. 18-19 give m_a = -k x / x'' - m, friction left out. At
the first zero crossing of x Eq. 21 gives C_d. As printed it leaves out (m + m_a) x'', which is what balances the forces
there, so that its C_d is negative for every decay, whatever the water does; as evidently meant it keeps it.

Belongs here: the two balances and their errors. Does not belong here: fits to whole records (method1.py, sindy.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid
from scipy.signal import bessel, sosfiltfilt

from undertow.conditioning.motion import Motion
from undertow.errors import IdentificationError
from undertow.likelihood.fit import Fit, Specimen, Structure
from undertow.likelihood.scale import structural_parameters
from undertow.methods.decay import central_slopes
from undertow.quantities import OK, Estimate

Array = NDArray[np.float64]

CUTOFF_IN_FREQUENCIES = 20.0
"""Cut-off of the low-pass over the motion's frequency: the report prints none; a 20th passes the friction's step."""

FILTER_ORDER = 4
"""Bessel, forwards and backwards: instants stay where they are and a step makes no overshoot that a peak would take."""

NYQUIST_SHARE = 0.8
"""The cut-off stays below this share of half the sampling rate."""


@dataclass(frozen=True)
class Instant:
    """State at one instant: ``t`` s after the release, ``x`` m from rest, ``v`` m/s, ``a`` m/s^2, and their errors."""

    t: float
    x: float
    v: float
    a: float
    x_std: float = 0.0
    v_std: float = 0.0
    a_std: float = 0.0


@dataclass(frozen=True)
class Instants:
    """The two instants of Method 2: the first acceleration peak after the release and the first zero crossing."""

    peak: Instant
    crossing: Instant


def filtered_motion(motion: Motion) -> tuple[Array, Array, float]:
    """Acceleration low-passed and detrended and velocity by the trapezoidal rule, (n,) from the release on, and Hz.

    The filter is a zero-phase Bessel at 20 times the motion's frequency. Where a hold was recorded its mean is taken
    off and velocity is integrated from it, so that it starts from rest; else both are detrended by a straight line.

    Raises IdentificationError where no acceleration was recorded.
    """
    recording = motion.recording
    if "acceleration" not in recording.channels:
        have = ", ".join(recording.channels)
        raise IdentificationError(
            f"trial {motion.name} has no channel acceleration; it has {have}: Method 2 integrates one"
        )
    v, a = motion.windowed("v"), motion.windowed("a")
    frequency_hz = math.sqrt(float(np.mean(a**2)) / float(np.mean(v**2))) / (2.0 * math.pi)
    cutoff_hz = min(CUTOFF_IN_FREQUENCIES * frequency_hz, NYQUIST_SHARE * 0.5 * recording.rate_hz)
    sections = bessel(FILTER_ORDER, cutoff_hz, fs=recording.rate_hz, output="sos", norm="mag")
    smooth: Array = sosfiltfilt(sections, recording.channels["acceleration"])
    time = recording.time
    hold = time < motion.window.release_s - 1.0 / cutoff_hz
    if motion.window.held and np.count_nonzero(hold) > 1:
        smooth = smooth - smooth[hold].mean()
        speed = cumulative_trapezoid(np.where(hold, 0.0, smooth), time, initial=0.0)
    else:
        smooth = smooth - np.polyval(np.polyfit(time, smooth, 1), time)
        speed = cumulative_trapezoid(smooth, time, initial=0.0)
        speed = speed - np.polyval(np.polyfit(time, speed, 1), time)
    return smooth[-motion.t.size :], speed[-motion.t.size :], cutoff_hz


def find_instants(motion: Motion) -> Instants:
    """The first acceleration peak after the release and the first zero crossing of displacement from rest.

    The peak is that of the low-passed acceleration's size within a quarter of a period of the first turning point: the
    value at the release itself is spoilt by the release. Errors: white noise through the filter, and that of the
    rest position.

    Raises IdentificationError where the record ends before them.
    """
    acceleration, speed, cutoff_hz = filtered_motion(motion)
    x = motion.x - motion.equilibrium.value
    crossing = _first_crossing(motion, x, "zero crossing of displacement", 0)
    turn = _first_crossing(motion, motion.v, "turning point", crossing)
    quarter = max(2, turn - crossing)
    around = slice(max(crossing, turn - quarter), min(turn + quarter, x.size))
    peak = around.start + int(np.argmax(np.abs(acceleration[around])))
    a_std = motion.noise.get("acceleration", 0.0) * math.sqrt(min(1.0, 2.0 * cutoff_hz / motion.recording.rate_hz))
    quarter_s = float(motion.t[crossing] - motion.t[0])
    v_std = motion.noise.get("acceleration", 0.0) * math.sqrt(quarter_s / motion.recording.rate_hz)

    def at(index: int, share: float) -> Instant:
        pair = np.array([motion.t, x, speed, acceleration])[:, index : index + 2]
        time, place, rate, push = (pair @ [1.0 - share, share]).tolist()
        x_std = math.hypot(float(motion.x_std[index]), motion.equilibrium.total_stderr)
        return Instant(time, place, rate, push, x_std, v_std, a_std)

    share = float(x[crossing] / (x[crossing] - x[crossing + 1]))
    return Instants(peak=at(min(peak, x.size - 2), 0.0), crossing=at(crossing, share))


def _first_crossing(motion: Motion, values: Array, what: str, start: int) -> int:
    """Index of the last sample before ``values`` changes sign for the first time from ``start`` on."""
    signs = np.sign(values[start:])
    moving = np.flatnonzero(signs != 0.0)
    changes = np.flatnonzero(signs[moving][:-1] * signs[moving][1:] < 0.0)
    if not changes.size:
        raise IdentificationError(
            f"trial {motion.name}: no {what} within {motion.t[-1]:.3g} s after the release; Method 2 needs half a cycle"
        )
    return start + int(moving[changes[0]])


def added_mass_at_peak(peak: Instant, stiffness: float, mass_kg: float) -> float:
    """m_a = -k x / x'' - m in kg at a turning point (report Eqs. 18-19), friction left out.

    >>> added_mass_at_peak(Instant(0.6, -0.1, 0.0, 2.0), 100e3, 3000.0)
    2000.0
    """
    return -stiffness * peak.x / peak.a - mass_kg


def friction_bias_kg(friction_N: float, peak_acceleration_m_per_s2: float) -> float:
    """Bias of Eq. 19's m_a by the friction it leaves out: -mu N / |x''| in kg, exact just before the turning point.

    There friction still brakes, M |x''| = k |x| + mu N, so that k |x| / |x''| - m falls short of m_a by mu N / |x''|.
    Just after the turn, and at the release itself, it is too large by as much.

    >>> friction_bias_kg(170.0, -2.5)
    -68.0
    """
    return -friction_N / abs(peak_acceleration_m_per_s2)


def drag_at_crossing(
    crossing: Instant, inertia_kg: float, damping_Ns_per_m: float, friction_N: float, drag_N_per_unit_coefficient: float
) -> float:
    """C_d from the balance at x = 0; Eq. 21 as printed has ``inertia_kg`` 0.

    C_d = -[M x'' + c x' + sign(x') mu N] / (rho A / 2 x' |x'|).
    """
    others = damping_Ns_per_m * crossing.v + math.copysign(friction_N, crossing.v)
    return -(inertia_kg * crossing.a + others) / (drag_N_per_unit_coefficient * crossing.v * abs(crossing.v))


def identify_method2(motion: Motion, structure: Structure, specimen: Specimen) -> tuple[Fit, Fit]:
    """Method 2 as printed ('method2_printed') and with the inertia kept ('method2').

    Both share m_a of Eq. 19. The inertia kept at the crossing is that of the peak with friction in its balance, so that
    the bias of m_a does not pass on to C_d. ``stderr`` is the channels' noise through the balances and the error of the
    rest position; ``systematic`` that of k, c and mu.

    Raises IdentificationError without mass or area, or where the two instants are not in the record.
    """
    if not math.isfinite(specimen.mass_kg):
        raise IdentificationError(f"specimen mass is {specimen.mass_kg:g} kg; Method 2 needs it: state mass_kg")
    if not specimen.area_m2 > 0.0:
        raise IdentificationError(
            f"drag area is {specimen.area_m2:g} m^2; Method 2 needs one above 0: state area_m2, or leave dry trials out"
        )
    instants = find_instants(motion)
    return (
        _fit("method2_printed", motion, instants, structure, specimen, keep_inertia=False),
        _fit("method2", motion, instants, structure, specimen, keep_inertia=True),
    )


def _fit(
    method: str, motion: Motion, instants: Instants, structure: Structure, specimen: Specimen, keep_inertia: bool
) -> Fit:
    peak, crossing = instants.peak, instants.crossing
    normal, drag = specimen.normal_force_N, specimen.drag_N_per_unit_coefficient

    def solve(values: Array) -> Array:
        peak_x, peak_a, speed, acceleration, shift, k, c, mu = values
        added = added_mass_at_peak(Instant(peak.t, peak_x, 0.0, peak_a), k, specimen.mass_kg)
        # a wrong rest position leaves a spring force k shift at what is taken for the zero crossing
        braked = added - friction_bias_kg(mu * normal, peak_a)
        inertia = specimen.mass_kg + braked if keep_inertia else 0.0
        seen = Instant(crossing.t, 0.0, speed, acceleration)
        spring = k * shift / (drag * speed * abs(speed)) if keep_inertia else 0.0
        return np.array([added, drag_at_crossing(seen, inertia, c, mu * normal, drag) - spring])

    held = (structure.k, structure.c, structure.mu)
    point = np.array([peak.x, peak.a, crossing.v, crossing.a, 0.0, *(estimate.value for estimate in held)])
    noise = np.array([peak.x_std, peak.a_std, crossing.v_std, crossing.a_std, crossing.x_std])
    values, slopes = solve(point), central_slopes(solve, point, abs(peak.x))
    stderr = np.sqrt(np.sum((slopes[:, :5] * noise) ** 2, axis=1))
    systematic = np.sqrt(np.sum((slopes[:, 5:] * [estimate.total_stderr for estimate in held]) ** 2, axis=1))
    friction = structure.mu.value * normal
    bias = friction_bias_kg(friction, peak.a)
    notes = [f"Eq. 19 leaves out friction: up to {bias:.3g} kg of added mass at |x''| = {abs(peak.a):.3g} m/s^2"]
    outcome = OK
    if not keep_inertia:
        notes.append("Eq. 21 as printed leaves out (m + m_a) x'', which balances the forces at x = 0")
    if values[1] < 0.0:
        outcome = f"C_d is {values[1]:.3g}, which drag cannot be"
        outcome += "" if keep_inertia else ": Eq. 21 as printed is negative for every decay"
    parameters = {
        name: Estimate(float(value), float(error), float(held_error), unit, method)
        for name, unit, value, error, held_error in zip(
            ("added_mass_kg", "drag_coefficient"), (specimen.unit("kg"), "1"), values, stderr, systematic, strict=True
        )
    }
    parameters["total_mass_kg"] = Estimate(
        float(values[0]) + specimen.mass_kg, float(stderr[0]), float(systematic[0]), specimen.unit("kg"), method
    )
    parameters |= structural_parameters(structure, specimen)
    return Fit(method, (motion.name,), parameters=parameters, outcome=outcome, notes=tuple(notes), anchor="stiffness")
