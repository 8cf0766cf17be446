"""The family of hystereses that a driven body can have: Bouc-Wen with its exponent, pinched, LuGre, Iwan.

Of each law the first parameter is the stiffness of a small loop, N/m. One of them stands in an equation.

Belongs here: their rows, and their force along a motion. Does not belong here: which of them a record shows
(comparison/driven_hysteresis.py), the compiled rates (driven_memory.py).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from undertow.equation.driven_slots import BOUC_WEN, IWAN, LUGRE, PINCHED, SLIDERS
from undertow.equation.structure import CoulombFriction, StribeckFriction
from undertow.equation.term import Array, Term
from undertow.quantities import Parameter

_ALPHA = Parameter("alpha_N_per_m", "N/m", r"\alpha", lower=0.0)
_LOOP = Parameter("loop", "1/m", r"\beta\gamma")
_SKEW = Parameter("skew", "1/m", r"\beta\delta")
_LEAST = 1e-9
"""Lower bound of what a law divides by, in its own unit."""
STEPS_AT_MOST = 1000
"""Between two samples of a column."""


@dataclass(frozen=True)
class BoucWen(Term):
    """Bouc and Wen's hysteresis, F = z with z' = alpha v - (G |v| z + D v |z|) (|z| / u)^(n-1).

    G is the literature's beta gamma, D its beta delta, n its nu; alpha is the stiffness of a small loop. u is the force
    that |z| is counted in under the exponent, 1 N unless it is held at another: near the size of z, G and n can be
    told apart. The force can only take energy where G >= |D| (Erlicher and Point 2004,
    doi:10.1016/j.crme.2003.10.009); no bound asks for it. As a column it is integrated along the motion with the row's
    own numbers and given per alpha.
    """

    loop: float = 1.0
    skew: float = 0.0
    exponent: float = 1.0
    unit_N: float = 1.0
    alpha: float = 1.0
    name = "bouc_wen"
    kind = "state"
    parameters = (
        _ALPHA, _LOOP, _SKEW,
        Parameter("exponent", "", r"\nu", lower=1.0, upper=8.0),
        Parameter("unit_N", "N", "u", lower=_LEAST),
    )  # fmt: skip
    slots: ClassVar[Mapping[str, str]] = {
        "alpha_N_per_m": "bw_a", "loop": "bw_g", "skew": "bw_d", "exponent": "bw_n", "unit_N": "bw_unit",
    }  # fmt: skip
    constants: ClassVar[Mapping[str, float]] = {"memory": BOUC_WEN}
    held_unless_asked = ("unit_N",)
    law = "z, z' = alpha v - (beta gamma |v| z + beta delta v |z|) (|z| / u)^(nu-1)"
    latex = r"z,\ \dot z=\alpha\,\dot x-(\beta\gamma|\dot x|z+\beta\delta\,\dot x|z|)(|z|/u)^{\nu-1}"
    source = "Wen 1976, doi:10.1061/JMCEA3.0002106; Noel and Schoukens 2016"
    left_out = "loops in force against displacement whose width grows with amplitude, at any speed"

    def force(self, x: Array, v: Array, a: Array, t: Array) -> Array:
        """z / alpha in m along the displacement from z = 0 at t[0], straight from sample to sample."""

        def slope(z: float, way: float) -> float:
            bent = math.pow(abs(z) / self.unit_N, self.exponent - 1.0)
            return self.alpha - (self.loop * z * way + self.skew * abs(z)) * bent

        most = abs(self.loop) + abs(self.skew)
        if self.exponent > 1.0 and most > 0.0:  # its force is at most about (alpha / most)^(1 / n)
            most *= self.exponent * (self.alpha / most / self.unit_N) ** (1.0 - 1.0 / self.exponent)
        return _along(x, slope, most) / self.alpha


@dataclass(frozen=True)
class Pinched(Term):
    """Bouc and Wen's hysteresis of exponent one that slips where it passes z = 0: F = z with
    z' = (1 - P exp(-(z / W)^2)) (alpha v - G |v| z - D v |z|).

    Foliente's pinching of the slip-lock element of Baber and Noori, without its shift and without degradation: the
    form of fewest numbers. P is 0 for Bouc and Wen's loop, and near 1 for a joint with play.
    """

    loop: float = 1.0
    skew: float = 0.0
    pinch: float = 0.0
    width_N: float = 1.0
    alpha: float = 1.0
    name = "pinched"
    kind = "state"
    parameters = (
        _ALPHA, _LOOP, _SKEW,
        Parameter("pinch", "", "P", lower=0.0, upper=0.999),
        Parameter("width_N", "N", "W", lower=_LEAST),
    )  # fmt: skip
    slots: ClassVar[Mapping[str, str]] = {
        "alpha_N_per_m": "bw_a", "loop": "bw_g", "skew": "bw_d", "pinch": "pinch", "width_N": "pinch_w",
    }  # fmt: skip
    constants: ClassVar[Mapping[str, float]] = {"memory": PINCHED, "bw_n": 1.0, "bw_unit": 1.0}
    law = "z, z' = (1 - P exp(-(z / W)^2)) (alpha v - beta gamma |v| z - beta delta v |z|)"
    latex = r"z,\ \dot z=(1-P\,e^{-(z/W)^2})(\alpha\,\dot x-\beta\gamma|\dot x|z-\beta\delta\,\dot x|z|)"
    source = "Baber and Noori 1986, doi:10.1115/1.3269364; Foliente 1995, doi:10.1061/(ASCE)0733-9445(1995)121:6(1013)"
    left_out = "loops that are narrow and soft in their middle, as of joints with play"

    def force(self, x: Array, v: Array, a: Array, t: Array) -> Array:
        """z / alpha in m along the displacement from z = 0 at t[0], straight from sample to sample."""

        def slope(z: float, way: float) -> float:
            slack = 1.0 - self.pinch * math.exp(-((z / self.width_N) ** 2))
            return slack * (self.alpha - self.loop * z * way - self.skew * abs(z))

        most = abs(self.loop) + abs(self.skew) + self.alpha * self.pinch / self.width_N
        return _along(x, slope, most) / self.alpha


@dataclass(frozen=True)
class LuGre(Term):
    """Friction by bristles that bend before they slip: F = z + sigma1 q with z' = sigma0 q, q = v (1 - sign(v) z / g),
    g = F_c + F_s exp(-(v / v_s)^2).

    z is the force of the bristles, sigma0 times their deflection, whose rate is q; F_c + F_s is the static force of the
    literature, whose sigma2 v is `viscous_damping`. The law takes the place of Coulomb's friction and of Stribeck's,
    which it becomes where sigma0 grows beyond all bounds. sigma1 is 0 unless a start value is given; the force is
    passive where sigma2 is above sigma1 F_s / F_c (Barahanov and Ortega 2000, doi:10.1016/S0167-6911(00)00033-6).
    """

    coulomb_N: float = 1.0
    static_N: float = 0.0
    velocity_m_per_s: float = 0.01
    sigma1_Ns_per_m: float = 0.0
    name = "lugre"
    kind = "state"
    parameters = (
        Parameter("sigma0_N_per_m", "N/m", r"\sigma_0", lower=_LEAST),
        Parameter("coulomb_N", "N", "F_c", lower=_LEAST),
        Parameter("static_N", "N", "F_s", lower=0.0),
        Parameter("velocity_m_per_s", "m/s", "v_s", lower=1e-5),
        Parameter("sigma1_Ns_per_m", "N s/m", r"\sigma_1", lower=0.0),
    )
    slots: ClassVar[Mapping[str, str]] = {
        "sigma0_N_per_m": "bw_a", "coulomb_N": "lg_c", "static_N": "lg_r", "velocity_m_per_s": "lg_v",
        "sigma1_Ns_per_m": "lg_m",
    }  # fmt: skip
    constants: ClassVar[Mapping[str, float]] = {"memory": LUGRE}
    held_unless_asked = ("sigma1_Ns_per_m",)
    takes_the_place_of = (CoulombFriction.name, StribeckFriction.name)
    law = "z + sigma_1 q, z' = sigma_0 q, q = v (1 - sign(v) z / g(v)), g = F_c + F_s exp(-(v / v_s)^2)"
    latex = r"z+\sigma_1\,q,\ \dot z=\sigma_0\,q,\ q=\dot x(1-\mathrm{sgn}(\dot x)z/g),\ g=F_c+F_s\,e^{-(\dot x/v_s)^2}"
    source = "Canudas de Wit et al. 1995, doi:10.1109/9.376053"
    left_out = "a body that gives way before it slips, and lags more at low speed"

    def force(self, x: Array, v: Array, a: Array, t: Array) -> Array:
        """F / sigma0 in m with sigma0 of 1 N/m along the motion from z = 0 at t[0], exact along a straight step."""
        z, out = 0.0, np.zeros(x.size)
        size = self.coulomb_N + self.static_N * np.exp(-((v / self.velocity_m_per_s) ** 2))
        for i, move in enumerate(np.diff(x)):
            limit = size[i + 1] * np.sign(move)
            z = limit + (z - limit) * np.exp(-abs(move) / size[i + 1])
            out[i + 1] = z + self.sigma1_Ns_per_m * v[i + 1] * (1.0 - np.sign(v[i + 1]) * z / size[i + 1])
        return out


@dataclass(frozen=True)
class Iwan(Term):
    """Springs that slip one after the other, F = sum of s_i with s_i = K a_i (x - x_i) up to F_s b_i.

    Shares of the i-th of n sliders: a_i = (i/n)^(chi+1) - ((i-1)/n)^(chi+1), b_i the same with chi+2: stiffness is
    spread over ways to slip phi as phi^chi up to a largest (chi 0: Iwan's uniform distribution; Segalman's
    four-parameter joint without its last jump). K is the stiffness of all, F_s the force at which all slip. Ten sliders
    stand for the distribution, each slip at its instant.
    """

    slip_N: float = 1.0
    chi: float = 0.0
    name = "iwan"
    kind = "state"
    parameters = (
        Parameter("stiffness_N_per_m", "N/m", "K", lower=_LEAST),
        Parameter("slip_N", "N", "F_s", lower=_LEAST),
        Parameter("chi", "", r"\chi", lower=-0.9, upper=4.0),
    )
    slots: ClassVar[Mapping[str, str]] = {"stiffness_N_per_m": "bw_a", "slip_N": "iw_f", "chi": "iw_x"}
    constants: ClassVar[Mapping[str, float]] = {"memory": IWAN}
    held_unless_asked = ("chi",)
    law = (
        f"sum of s_1 to s_{SLIDERS}, s_i' = K a_i v up to |s_i| = F_s b_i, "
        "a_i = (i/n)^(chi+1) - ((i-1)/n)^(chi+1), b_i = (i/n)^(chi+2) - ((i-1)/n)^(chi+2)"
    ).replace("/n", f"/{SLIDERS}")
    latex = (
        r"s_1+\ldots+s_{n},\ \dot s_i=K\,a_i\dot x\ \mathrm{up\ to}\ |s_i|=F_s\,b_i,\ "
        r"a_i=(i/n)^{\chi+1}-((i-1)/n)^{\chi+1},\ b_i=(i/n)^{\chi+2}-((i-1)/n)^{\chi+2}"
    ).replace("{n}", f"{{{SLIDERS}}}").replace("/n", f"/{SLIDERS}")
    source = "Iwan 1966, doi:10.1115/1.3625199; Segalman 2005, doi:10.1115/1.1867982"
    left_out = "loops that begin with the smallest motion and close in force at no yield point"

    def force(self, x: Array, v: Array, a: Array, t: Array) -> Array:
        """F / K in m with K of 1 N/m along the displacement from s = 0 at t[0]."""
        stiffness, limit = sliders(self.chi)
        s, out = np.zeros(SLIDERS), np.zeros(x.size)
        for i, move in enumerate(np.diff(x)):
            s = np.clip(s + stiffness * move, -self.slip_N * limit, self.slip_N * limit)
            out[i + 1] = float(np.sum(s))
        return out


def _along(x: Array, slope: Callable[[float, float], float], most: float) -> Array:
    """A memory z along a displacement from z = 0: dz/dx = ``slope`` (z, way), way being 1 forth and -1 back.

    ``most`` bounds how fast the slope changes with z: steps are halves of its inverse at most, whatever lies between
    two samples, or the memory of a fast motion would leave all bounds.
    """
    z, out = 0.0, np.zeros(x.size)
    for i, move in enumerate(np.diff(x).tolist()):
        many = min(max(1, math.ceil(2.0 * abs(move) * most)), STEPS_AT_MOST)
        step, way = move / many, math.copysign(1.0, move)
        for _ in range(many):
            z += step * slope(z + 0.5 * step * slope(z, way), way)
        out[i + 1] = z
    return out


def sliders(chi: float, many: int = SLIDERS) -> tuple[Array, Array]:
    """Shares (many,) of stiffness and of slip force of Iwan's sliders, those with short ways first; each sums to 1.

    >>> sliders(0.0, 2)
    (array([0.5, 0.5]), array([0.25, 0.75]))
    """
    edges = np.arange(many + 1) / many
    return np.diff(edges ** (chi + 1.0)), np.diff(edges ** (chi + 2.0))


HYSTERESES: tuple[type[Term], ...] = (BoucWen, Pinched, LuGre, Iwan)
