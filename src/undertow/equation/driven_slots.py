"""Places of a driven body's numbers in the compiled integrator's vector: those of a decay, and behind them its own.

Belongs here: their names and numbers, without anything compiled. Does not belong here: which law has which
(driven_laws.py).
"""

from __future__ import annotations

from undertow.equation.algebra import SLOTS

EXTRA: tuple[str, ...] = (
    "gain", "delay", "offset", "bw_a", "bw_g", "bw_d", "bw_n", "bw_unit", "bw_z0",
    "moving", "base_v0", "absolute_v0", "wc", "wq", "wc3", "wave",
    "memory", "pinch", "pinch_w", "lg_c", "lg_r", "lg_v", "lg_m", "iw_f", "iw_x",
)  # fmt: skip
"""Names behind algebra.SLOTS. bw_unit is the force that |z| is counted in under the exponent, N. ``moving`` is 1 where
the input is the acceleration of a base, -1 where it is that of the water, else 0; base_v0 is the velocity of what
moves at the start by the recorded input (times the gain), absolute_v0 what has to be added to it; wc, wq, wc3 are
coefficients of r, r|r|, r^3 with r the body's velocity through the water (N s/m, N s^2/m^2, N s^3/m^3); wave is the
mass that the acceleration of the water acts on, rho V + m_a, kg. ``memory`` says which hysteresis stands at bw_a (the
stiffness of a small loop, N/m) and the slots of its own: pinch (1) and pinch_w (N); LuGre's F_c, F_s (N), v_s (m/s),
sigma1 (N s/m); Iwan's slip force (N) and chi (1)."""

BOUC_WEN, PINCHED, LUGRE, IWAN = 0.0, 1.0, 2.0, 3.0
"""Values of the slot ``memory``."""

SLIDERS = 10
"""Jenkins elements that stand for Iwan's distribution: its force is right to 1 / (4 SLIDERS^2) of the slip force."""

MOVING = {"force": 0.0, "base": 1.0, "water": -1.0}
"""Value of the slot ``moving`` by what the input is the motion of."""

DRIVEN_SLOTS: tuple[str, ...] = SLOTS + EXTRA
DRIVEN_SLOT: dict[str, int] = {name: i for i, name in enumerate(DRIVEN_SLOTS)}
N_DRIVEN = len(DRIVEN_SLOTS)
