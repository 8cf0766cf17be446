"""An equation as a model of OpenSees, in OpenSeesPy: masses, springs, dashpots and what yields between two nodes.

Forces of the displacement alone become one table of a multilinear elastic material; damping laws are viscous dashpots
with an exponent; friction is a stiff spring that yields; a hidden resonator is a second mass; a relaxation a Maxwell
element; bristles a Bouc-Wen element.

Belongs here: that translation. Does not belong here: running it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from undertow.equation.equation import Equation
from undertow.equation.registry import catalogue
from undertow.equation.term import Element, Term
from undertow.errors import UndertowError
from undertow.front.handover.programs import largest_step

STICKING = 2.0
"""Stiffness of the spring that stands for sticking, over mass by the square of the step: Newton's method still finds
whether it yields."""

TABLE_HALF = 400
"""Points of a table of elastic forces on each side: straight lines between them are good to 1e-5 of the force."""

FINER, FINER_YIELDING = 4.0, 32.0
"""How much shorter than a Runge-Kutta program's the steps of Newmark's method are: its clock is late by 5e-6 of a
period each period. What yields needs shorter ones: a stiffer spring for sticking, and Bouc-Wen's law is followed by
Euler's method."""

_ORDER: tuple[Element, ...] = ("elastic", "dashpot", "slider", "oscillator", "maxwell", "bristles", "drive", "inertia")


def followed() -> tuple[str, ...]:
    """Names of the laws that OpenSees has an element for."""
    known = [(_ORDER.index(law.element), law.speed_power or math.inf, law.name) for law in catalogue() if law.element]
    return tuple(name for *_, name in sorted(known, key=lambda one: one[:2]))


Pair = tuple[Term, float]


def opensees_text(equation: Equation, reach_m: float) -> str:
    """The module's text; see `HandOver.to_opensees`."""
    pairs = list(zip(equation.terms, equation.coefficients, strict=True))
    other = [term.name for term, _ in pairs if not term.element]
    if other:
        raise UndertowError(
            f"{other[0]} has no material in OpenSees; it follows {', '.join(followed())}: hand it over with "
            "to_python() or to_octave()"
        )
    yields = any(term.element in ("slider", "bristles") for term, _ in pairs)
    step = largest_step(equation, reach_m) / (FINER_YIELDING if yields else FINER)
    lines = ["ops.node(1, 0.0)", "ops.fix(1, 1)", "ops.node(2, 0.0)", f"ops.mass(2, {equation.total_mass_kg!r})"]
    lines += ["ops.timeSeries('Constant', 1)", "ops.pattern('Plain', 1, 1)"]
    between: list[str] = []
    elastic = [pair for pair in pairs if pair[0].element == "elastic"]
    if elastic:
        material, held = _elastic(elastic)
        between.append(material)
        lines += [f"held = {held}", "ops.load(2, -held)"]
    driven = [pair for pair in pairs if pair[0].element == "drive"]
    pulls = [f"{value * math.cos(term.inner['phase_rad'])!r}" for term, value in driven]
    lines.append(f"pull = {' + '.join(['held' if elastic else '0.0', *pulls])}  # on the body at the release")
    stiff = STICKING * equation.total_mass_kg / step**2
    resonators = [pair for pair in pairs if pair[0].element == "oscillator"]
    for term, value in pairs:
        between += term.materials(value, stiff)
    lines += _linked(between, 1, 2, 1)
    tag = len(between) + 1
    for at, (term, mass) in enumerate(resonators):
        node = 3 + at
        lines += [f"ops.node({node}, 0.0)", f"ops.mass({node}, {mass!r})"]
        inner = _resonator(term, mass, reach_m)
        lines += _linked(inner, 2, node, tag)
        tag += len(inner)
    lines += _loads(driven)
    return _PROGRAM.format(
        equation=equation, model="\n    ".join(lines), step=repr(step), rest=repr(equation.rest_m),
        table=_table(elastic, reach_m),
    )  # fmt: skip


def _elastic(pairs: Sequence[Pair]) -> tuple[str, str]:
    """Forces of displacement alone as one material, a spring or a table, and the force that holds the body."""
    if all(term.structural == "k" for term, _ in pairs):
        k = sum(value for _, value in pairs)
        return f"'Elastic', TAG, {k!r}", f"{k!r} * start"
    table = "'-strain', *(STRAINS_M - start), '-stress', *(FORCES_N - held)"
    return f"'ElasticMultiLinear', TAG, 0.0, {table}", "float(np.interp(start, STRAINS_M, FORCES_N))"


def _table(pairs: Sequence[Pair], reach_m: float) -> str:
    """The table of elastic forces, where one is needed."""
    if all(term.structural == "k" for term, _ in pairs):
        return ""
    at = np.linspace(-1.5 * reach_m, 1.5 * reach_m, 2 * TABLE_HALF + 1)
    still = np.zeros(at.size)
    force = sum((value * term.force(at, still, still, still) for term, value in pairs), np.zeros(at.size))
    ends = f"{float(at[0])!r}, {float(at[-1])!r}, {at.size}"
    return f"STRAINS_M = np.linspace({ends})\nFORCES_N = np.array({[float(one) for one in force]})\n"


def _resonator(term: Term, mass: float, reach_m: float) -> list[str]:
    """Materials between the body and a hidden mass."""
    w, z = term.inner["natural_frequency_rad_per_s"], term.inner["damping_ratio"]
    b, g = term.inner["quadratic_damping_per_m"], term.inner["cubic_stiffness_per_m2_s2"]
    if g == 0.0:
        out = [f"'Elastic', TAG, {mass * w * w!r}"]
    else:
        at = np.linspace(-10.0 * reach_m, 10.0 * reach_m, 20 * TABLE_HALF + 1)
        strains = ", ".join(repr(float(one)) for one in at)
        stresses = ", ".join(repr(float(one)) for one in mass * (w * w * at + g * at**3))
        out = [f"'ElasticMultiLinear', TAG, 0.0, '-strain', {strains}, '-stress', {stresses}"]
    if z > 0.0:
        out.append(f"'Viscous', TAG, {2.0 * mass * z * w!r}, 1.0")
    if b > 0.0:
        out.append(f"'Viscous', TAG, {mass * b!r}, 2.0")
    return out


def _linked(materials: Sequence[str], first: int, second: int, tag: int) -> list[str]:
    """Materials side by side in one zero-length element between two nodes."""
    lines = [f"ops.uniaxialMaterial({one.replace('TAG', str(tag + i))})" for i, one in enumerate(materials)]
    tags = ", ".join(str(tag + i) for i in range(len(materials)))
    ones = ", ".join("1" for _ in materials)
    if materials:
        element = f"ops.element('zeroLength', {second}, {first}, {second}, '-mat', {tags}, '-dir', {ones})"
        lines.append(element)
    return lines


def _loads(pairs: Sequence[Pair]) -> list[str]:
    """Harmonic forces on the body: what stands on the left of the equation pulls with the other sign."""
    lines = []
    for at, (term, value) in enumerate(pairs, 2):
        period = 2.0 * math.pi / term.inner["frequency_rad_per_s"]
        shift = term.inner["phase_rad"] + 0.5 * math.pi
        lines += [
            f"ops.timeSeries('Trig', {at}, 0.0, 1e9, {period!r}, '-factor', {-value!r}, '-shift', {shift!r})",
            f"ops.pattern('Plain', {at}, {at})",
            "ops.load(2, 1.0)",
        ]
    return lines


_PROGRAM = '''\
"""{equation}

Free motion of this equation as a model of OpenSees, written by undertow. SI units. Needs openseespy.
"""

import numpy as np
import openseespy.opensees as ops

LARGEST_STEP_S = {step}
REST_M = {rest}  # displacement in which the springs are at rest
{table}

def build(start):
    """One moving node between springs, dashpots and what yields; hidden masses hang on it.

    Displacements count from the release, ``start`` (m from rest): a constant load stands for the springs' tension
    there, and all else starts without force.
    """
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    {model}


def simulate(x0, times):
    """Displacement (m) and velocity (m/s) at ``times`` (s, rising from 0), released from x0 at rest."""
    start = x0 - REST_M
    build(start)
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("BandGeneral")
    ops.test("NormDispIncr", 1e-12 * abs(start) + 1e-300, 50)
    ops.algorithm("Newton")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")
    first = 1e-6 * LARGEST_STEP_S  # OpenSees starts without acceleration; a step so short finds it
    out, now = [], 0.0
    for time in times:
        steps = int(np.ceil((time - now) / LARGEST_STEP_S - 1e-9))
        for step in range(steps):
            if now == 0.0 and step == 0 and ops.analyze(1, first) != 0:
                raise RuntimeError("OpenSees found no acceleration at the release")
            if ops.analyze(1, (time - now) / steps) != 0:
                raise RuntimeError(f"OpenSees found no equilibrium near {{ops.getTime():g}} s")
        now = time
        out.append((ops.nodeDisp(2, 1) + x0, ops.nodeVel(2, 1)))
    return np.array(out).T
'''
