"""A body that carries closed cells of steep water: the release in time, with every loss and every stop.

The cells sway with the body. With phi measured against the cell, whose acceleration x'' tilts gravity, and M_w the
mass of the water,

    M p' = -1/2 p . (dS/d eta) p - g M eta - x'' M x - losses,
    d/dt [ (m + M_w) x' + rho' x . S p ] = -k x - c x' - q x'|x'| - friction,

so that momentum leaves only through spring, dashpot, drag and friction, and water's losses stay inside the cell. They
are pressures D eta' on the surface with a D that is symmetric and not negative: volume is kept, and energy only
falls, at eta' . D eta', whatever the wave. (A rate on p itself does neither in steep water: filtering p pumps it up.)

- laminar Stokes layers on the walls, as a decay of every small wave (water.py);
- a filter on the shortest waves, which the mesh does not resolve: nothing on the longer half of the modes;
- a breaking wave: D = b where the slope exceeds BREAKING_SLOPE, after Guignard and Grilli (2001, ISOPE), who
  let a pressure work against the surface's own velocity. Its strength is a choice, not a measurement: a spilling crest
  is damped within a fraction of a period. Waves steeper than that are rough here, and no authority.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from experiments.virtual_flume.frequency import DENSITY
from experiments.virtual_flume.march import Flume
from experiments.virtual_flume.nonlinear_water import GRAVITY, Cell, Flow
from experiments.virtual_flume.structure import Structure
from experiments.virtual_flume.water import stokes_layer_rate

Array = np.ndarray

BREAKING_SLOPE = (0.6, 1.0)  # breaking sets in at the first and is full at the second; 45 degrees is a standing crest's
BREAKING_STRENGTH = 0.5  # of the long-wave speed sqrt(g h): the surface's resistance b where breaking is full
FILTER_RATE = 60.0  # 1/s on the shortest mode, quadratic from nothing at the middle of the modes


@dataclass(frozen=True)
class Losses:
    """`layer_rate` 1/s, decay of a wave in laminar layers; `filter_rate` 1/s; `breaking` m/s at full breaking."""

    layer_rate: float = 0.0
    filter_rate: float = 0.0
    breaking: float = 0.0


def ordinary_losses(cell: Cell) -> Losses:
    """The losses of the campaign's cells."""
    speed = float(np.sqrt(GRAVITY * cell.depth))
    return Losses(stokes_layer_rate(cell.width), FILTER_RATE, BREAKING_STRENGTH * speed)


class NonlinearFlume(Flume):
    """Body and cells together: `length_m` of cells, all cells together. State [x, v, eta (n), p (n)] as in Flume."""

    def __init__(self, structure: Structure, cell: Cell, length_m: float, losses: Losses | None = None) -> None:
        self.structure, self.cell = structure, cell
        self.losses = ordinary_losses(cell) if losses is None else losses
        self.n = cell.x.size
        self.scale = DENSITY * length_m
        self.whole_mass = structure.mass + self.scale * cell.area
        self.steady_loss = self._steady_loss()

    def _steady_loss(self) -> Array:
        """M^-1 D of layers and filter, (n, n) m/s: a small wave's mode i decays at D_i l_i / 2 a second."""
        value, shape = self.cell.still_modes
        shortness = np.clip(np.linspace(-1.0, 1.0, self.n), 0.0, None)
        rate = 2.0 * self.losses.layer_rate + self.losses.filter_rate * shortness**2
        rate[0], value = 0.0, np.concatenate([[1.0], value[1:]])  # the level's own mode, which nothing moves
        return (shape * (rate / value)) @ shape.T @ self.cell.mass

    def _loss(self, eta: Array, eta_rate: Array) -> Array:
        """What the losses take from p', (n,) m2/s2."""
        lost = self.steady_loss @ eta_rate
        if self.losses.breaking:
            low, high = BREAKING_SLOPE
            over = np.clip((np.abs(self.cell.slope(eta)) - low) / (high - low), 0.0, 1.0)
            if over.any():
                smooth = self.losses.breaking * over * over * (3.0 - 2.0 * over)
                lost = lost + self.cell.inverse_mass @ self.cell.weighted(smooth, eta_rate)
        return lost

    def _water(self, y: Array) -> tuple[Flow, Array, Array]:
        """Flow, eta' (n,) m/s and p' (n,) m2/s2 in a cell that is not accelerated."""
        eta, p = y[2 : 2 + self.n], y[2 + self.n :]
        flow = self.cell.flow(eta, p)
        eta_rate = self.cell.inverse_mass @ flow.flux
        p_rate = -self.cell.inverse_mass @ flow.push - GRAVITY * eta - self._loss(eta, eta_rate)
        return flow, eta_rate, p_rate

    def _force(self, y: Array, water: tuple[Flow, Array, Array]) -> tuple[float, float]:
        """Force on the body without friction (N), and the mass that follows at once (kg)."""
        s, (flow, eta_rate, p_rate) = self.structure, water
        force = -s.stiffness * y[0] - s.damping * y[1] - s.drag * y[1] * abs(y[1])
        force -= self.scale * (flow.cross @ eta_rate + flow.sway_flux @ p_rate)
        return float(force), float(self.whole_mass - self.scale * self.cell.x @ flow.sway_flux)

    def free_force(self, y: Array) -> float:
        """All forces on a body at rest but friction; N."""
        return self._force(y, self._water(y))[0]

    def acceleration(self, y: Array, direction: float) -> float:
        """x'' of a body moving in a direction (+1, -1), 0 where friction holds it (0); m/s2."""
        if not direction:
            return 0.0
        force, inertia = self._force(y, self._water(y))
        return (force - direction * self.structure.friction_force) / inertia

    def rate(self, y: Array, direction: float) -> Array:
        """y' for a body moving in a direction (+1, -1), or held by friction (0)."""
        water = self._water(y)
        force, inertia = self._force(y, water)
        a = (force - direction * self.structure.friction_force) / inertia if direction else 0.0
        return np.concatenate([[y[1], a], water[1], water[2] - a * self.cell.x])

    def _sample(self, y: Array, direction: float) -> tuple[float, float, float, float]:
        return float(y[0]), float(y[1]), self.acceleration(y, direction), 0.0

    def energy(self, y: Array) -> float:
        """Energy of spring, body and water at a state; J. Constant where nothing is lost."""
        eta, p = y[2 : 2 + self.n], y[2 + self.n :]
        flow = self.cell.flow(eta, p)
        body = self.whole_mass * y[1] ** 2 + self.structure.stiffness * y[0] ** 2
        water = p @ flow.flux + 2.0 * y[1] * (self.cell.x @ flow.flux) + GRAVITY * eta @ self.cell.mass @ eta
        return float(0.5 * (body + self.scale * water))

    def momentum(self, y: Array) -> float:
        """Sway momentum of body and water; N s."""
        flow = self.cell.flow(y[2 : 2 + self.n], y[2 + self.n :])
        return float(self.whole_mass * y[1] + self.scale * self.cell.x @ flow.flux)


def free_wave(cell: Cell, amplitude_m: float, duration_s: float, step_s: float, losses: Losses) -> tuple[Array, Array]:
    """A wave let go at rest from the first linear mode's shape in a cell that stands still.

    `amplitude_m`: elevation at the wall. Returns times (t,) s and surfaces (t, n) m.
    """
    held = NonlinearFlume(Structure(1.0, 0.0, 0.0, 0.0, 0.0), cell, 1.0, losses)
    y = np.zeros(2 + 2 * cell.x.size)
    y[2 : 2 + cell.x.size] = -amplitude_m * np.sin(np.pi * cell.x / cell.width)
    time = np.arange(round(duration_s / step_s) + 1) * step_s
    surface = [y[2 : 2 + cell.x.size]]
    for _ in time[1:]:
        y = held.step(y, step_s, 0.0)
        surface.append(y[2 : 2 + cell.x.size])
    return time, np.array(surface)


def first_frequency(cell: Cell, time: Array, surface: Array) -> float:
    """Frequency (rad/s) of the first mode's amplitude, from its falling through zero, first time to last."""
    first = surface @ cell.mass @ np.sin(np.pi * cell.x / cell.width)
    down = np.nonzero((first[:-1] > 0.0) & (first[1:] <= 0.0))[0]
    if down.size < 2:
        raise ValueError(f"{time[-1]:g} s hold {down.size} falls through zero of the wave; march at least two periods")
    # cubic through four neighbours: the zero between two samples to the fourth order of the step
    crossings = [_zero(time[i - 1 : i + 3], first[i - 1 : i + 3]) for i in down if 0 < i < time.size - 2]
    return float(2.0 * np.pi * (len(crossings) - 1) / (crossings[-1] - crossings[0]))


def _zero(time: Array, value: Array) -> float:
    """Time at which the cubic through four samples passes zero, by inverse interpolation."""
    return float(sum(
        time[i] * np.prod([value[j] / (value[j] - value[i]) for j in range(4) if j != i]) for i in range(4)
    ))  # fmt: skip


def tadjbakhsh_keller(width_m: float, depth_m: float, amplitude_m: float) -> float:
    """Relative change of a standing wave's frequency at an amplitude, to third order.

    (1/2) e^2 w2 / w0 with e = k a, w0^2 = tanh(k h), w2 = (9 w0^-7 - 12 w0^-3 - 3 w0 - 2 w0^5) / 32
    (Tadjbakhsh and Keller 1960, doi:10.1017/S0022112060000724): negative, softening, above depth/width 0.337.

    >>> tadjbakhsh_keller(1.0, 0.33, 0.01) > 0.0 > tadjbakhsh_keller(1.0, 0.345, 0.01)
    True
    """
    k = np.pi / width_m
    w0 = np.sqrt(np.tanh(k * depth_m))
    w2 = (9.0 * w0**-7 - 12.0 * w0**-3 - 3.0 * w0 - 2.0 * w0**5) / 32.0
    return float(0.5 * (k * amplitude_m) ** 2 * w2 / w0)
