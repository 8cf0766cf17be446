"""The path for laws that the compiled integrator does not know: a user's own Term can be fitted and simulated too.

A law that is a formula is read once (tracing.py) and integrated by compiled code (tape_march.py); one that is more (a
look-up, a decision by a value) by the same method in Python, some hundred times slower.

Integrated by DOP853 from reversal to reversal, together with the sensitivities of every wanted number: the laws' slopes
by x, v and inner parameters come from differences of the laws themselves, taken on the side on which the body moves, so
that nothing jumps inside a stretch. At a reversal the sensitivity of v is multiplied by a+ / a-, or ends where the body
sticks; a body at rest stays at rest, which holds for laws without a clock of their own.

Belongs here: which of both, the one in Python, and the force in a spring that load cells see. Does not belong here:
laws (structure.py and its neighbours), the compiled integrators (kernel.py, tape_march.py), fits.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.integrate import solve_ivp

from undertow.equation.columns import SPRINGS
from undertow.equation.equation import Equation
from undertow.equation.kernel import N_SLOTS, SLOT
from undertow.equation.term import Array, PlacedTerm, Term, force_of
from undertow.equation.tracing import Formula, formula_of
from undertow.errors import IdentificationError

RELATIVE_TOLERANCE = 1e-8
"""Of DOP853: the motion is then right to some 1e-7 of x0, far below any sensor."""

DIFFERENCE = 1e-6
"""Step of the laws' slopes, relative to the motion's size: second-order differences are then right to 1e-9 or so."""

STANDSTILL = 1e-9
"""Speed, relative to the motion's, at which a law is asked which way it pushes a body at rest."""

UNCONTROLLED = 1e300
"""Absolute tolerance of what does not decide the step."""

MOST_REVERSALS = 100_000
"""A motion that turns more often is not one: a law that feeds it."""

WRONG = "a coefficient is wrong"
TURNS = f"the motion turns more than {MOST_REVERSALS} times; a coefficient has the wrong sign"

Samples = tuple[Array, Array, Array]
"""x, v, a, each (n, 1 + p)."""


def placed_terms(terms: Sequence[Term]) -> tuple[tuple[PlacedTerm, ...], dict[str, int]]:
    """All forces with their places where a law has no compiled slots, and the places of such laws' parameters.

    IdentificationError where a law beside such a one has memory, or no place of its own.
    """
    own = [term for term in terms if not term.slots]
    places: dict[str, int] = {}
    for term in own:
        for parameter in term.parameters:
            places[f"{term.name}.{parameter.name}"] = N_SLOTS + len(places)
    if not own:
        return (), {}
    placed: dict[int, PlacedTerm] = {}
    for term in terms:
        if not term.is_inertia:
            at = tuple(place_of(term, p.name, places) for p in term.parameters)
            placed.setdefault(at[0], PlacedTerm(term, at))  # two laws of one place are one force, as in the kernel
    return tuple(placed.values()), places


def place_of(term: Term, parameter: str, places: Mapping[str, int]) -> int:
    """Where a parameter of a law stands in the parameter vector; ``places`` are those of laws without slots."""
    own = f"{term.name}.{parameter}"
    if own in places:
        return places[own]
    slot = term.slots.get(parameter, "")
    if slot not in SLOT or term.kind != "force":
        raise IdentificationError(
            f"{term.name} beside {next(iter(places)).partition('.')[0]}, a law without compiled slots: "
            f"its {parameter} has no place of its own; give the law slots or leave {term.name} out"
        )
    return SLOT[slot]


def placed_equation(equation: Equation) -> tuple[Array, tuple[PlacedTerm, ...]]:
    """The parameter vector of an equation, those of laws without compiled slots behind the integrator's own, and all
    forces with their places where it has such a law (else nothing)."""
    laws, places = placed_terms(equation.terms)
    pairs = list(zip(equation.terms, equation.coefficients, strict=True))
    known = [pair for pair in pairs if pair[0].slots]
    compiled = replace(equation, terms=tuple(t for t, _ in known), coefficients=tuple(c for _, c in known))
    theta = np.concatenate([compiled.theta(), np.zeros(len(places))])
    for term, value in (pair for pair in pairs if not pair[0].slots):
        for name, number in {term.coefficient.name: value, **term.inner}.items():
            theta[places[f"{term.name}.{name}"]] = number
    return theta, laws


@dataclass(frozen=True)
class OwnMotion:
    """Laws at one parameter vector and the places whose derivatives are wanted; the motion's ``size`` (m) and ``speed``
    (m/s), the speed that counts as standstill, and the relative and absolute (2,) tolerances of x and v."""

    theta: Array
    laws: tuple[PlacedTerm, ...]
    active: tuple[int, ...]
    size: float
    speed: float
    still: float
    relative: float
    absolute: Array

    def slopes(self, t: Array, x: Array, v: Array, side: float) -> tuple[Array, Array, Array, Array]:
        """a (n,), its derivatives by x and by v (n,), and by the active numbers (n, p), moving to ``side`` (+1, -1).

        Where none is wanted, sample by sample: a law may then decide by a value.
        """
        mass = self.theta[SLOT["mass"]]
        dx, dv = DIFFERENCE * self.size, DIFFERENCE * self.speed
        count = x.size
        here = x - self.theta[SLOT["xe"]]
        moving = side * np.maximum(v * side, self.still)
        if not self.active:
            samples = zip(here[:, None], moving[:, None], t[:, None], strict=True)
            a = np.array([-self._force(*sample) / mass for sample in samples])
            return a, np.zeros(count), np.zeros(count), np.zeros((count, 0))
        xs = np.concatenate([here, here + dx, here - dx, here, here])
        vs = np.concatenate([moving, moving, moving, moving + side * dv, moving + side * 2.0 * dv])
        still, times = np.zeros(5 * count), np.tile(t, 5)
        total = np.zeros(5 * count)
        by: dict[int, Array] = {}
        for law in self.laws:
            coefficient, term = law.at(self.theta)
            force = force_of(term, xs, vs, still, times)
            total += coefficient * force
            by[law.places[0]] = by.get(law.places[0], 0.0) - force[:count] / mass
            for place, parameter in zip(law.places[1:], law.term.parameters[1:], strict=True):
                if place in self.active:
                    by[place] = -coefficient * _by_inner(term, parameter.name, here, moving, t) / mass
        f = total.reshape(5, count)
        a = -f[0] / mass
        ax = -(f[1] - f[2]) / (2.0 * dx) / mass
        av = -side * (-3.0 * f[0] + 4.0 * f[3] - f[4]) / (2.0 * dv) / mass
        by |= {SLOT["mass"]: -a / mass, SLOT["xe"]: -ax}
        zero = np.zeros(count)
        return a, ax, av, np.column_stack([by.get(place, zero) for place in self.active])

    def _force(self, x: Array, v: Array, t: Array) -> float:
        """All laws' force at one sample, each (1,), N."""
        placed = (law.at(self.theta) for law in self.laws)
        return sum(coefficient * float(force_of(law, x, v, np.zeros(1), t)[0]) for coefficient, law in placed)


def _by_inner(term: Term, name: str, x: Array, v: Array, t: Array) -> Array:
    """Derivative (n,) of a law's force per unit coefficient by an inner parameter."""
    value = float(getattr(term, name))
    step = DIFFERENCE * max(abs(value), 1e-3)
    up, down = (replace(term, **{name: value + sign * step}) for sign in (1.0, -1.0))
    still = np.zeros(x.size)
    return np.asarray((up.force(x, v, still, t) - down.force(x, v, still, t)) / (2.0 * step), dtype=np.float64)


def general_trajectory(
    theta: Array, laws: Sequence[PlacedTerm], active: np.ndarray, times: Array
) -> tuple[Array, Array, Array]:
    """x, v, a, each (n, 1 + p), at ``times`` (n,), s, rising: the motion and its derivatives by ``active`` (p,) places.

    ``theta`` is the parameter vector of the compiled integrator, longer where laws have no slots there; all forces come
    from ``laws``. Raises IdentificationError where the mass is not positive, a law has memory, or the motion leaves
    every bound.
    """
    mass = float(theta[SLOT["mass"]])
    if not mass > 0.0 or not np.all(np.isfinite(theta)):
        raise IdentificationError(f"a trajectory needs a positive total mass and finite parameters, got {mass:g} kg")
    memory = [law.term.name for law in laws if law.term.kind == "state"]
    if memory:
        raise IdentificationError(
            f"{', '.join(memory)} beside a law without compiled slots cannot be integrated; give the law slots or take "
            "the hidden state out"
        )
    motion = _sized(theta, tuple(laws), tuple(int(place) for place in active), times)
    instants = np.ascontiguousarray(times, dtype=np.float64)
    return followed(motion, instants)[0]


def followed(motion: OwnMotion, times: Array) -> tuple[Samples, int]:
    """x, v, a at ``times`` (n,), s, rising, and the steps taken. IdentificationError where it leaves every bound."""
    formula = formula_of(motion.laws, motion.theta, motion.size, motion.speed or 1.0, float(times[-1]))
    return _march(motion, times) if formula is None else _compiled(motion, formula, times)


def _compiled(motion: OwnMotion, formula: Formula, times: Array) -> tuple[Samples, int]:
    """The motion by compiled code."""
    from undertow.equation.tape_march import DONE, INITIAL, MASS, REST, TURNING, march

    theta = np.ascontiguousarray(motion.theta)
    in_laws = {place for law in motion.laws for place in law.places}
    outside = {SLOT["mass"]: MASS, SLOT["xe"]: REST}
    by = np.array(
        [2 + j if p in in_laws else outside.get(p, INITIAL) for j, p in enumerate(motion.active)], dtype=np.int64
    )
    columns = np.full(theta.size, -1, dtype=np.int64)
    columns[np.array(motion.active, dtype=np.int64)[by > 0]] = by[by > 0]
    sizes = np.array([theta[SLOT["mass"]], theta[SLOT["xe"]], motion.still])
    tolerances = np.array([motion.relative, *motion.absolute])
    x, v, a, ending, steps, when = march(
        formula.rows, formula.constants, theta, columns, by, sizes, _start(motion).ravel(), tolerances, times,
        MOST_REVERSALS,
    )  # fmt: skip
    if ending == DONE:
        return (x, v, a), steps
    raise IdentificationError(TURNS if ending == TURNING else f"the motion leaves every bound at {when:.3g} s; {WRONG}")


def _start(motion: OwnMotion) -> Array:
    """x and v at the release with their derivatives, (2, 1 + p)."""
    state = np.zeros((2, 1 + len(motion.active)))
    for row, slot in enumerate(("x0", "v0")):
        state[row, 0] = motion.theta[SLOT[slot]]
        if SLOT[slot] in motion.active:
            state[row, 1 + motion.active.index(SLOT[slot])] = 1.0
    return state


def _sized(theta: Array, laws: tuple[PlacedTerm, ...], active: tuple[int, ...], times: Array) -> OwnMotion:
    """The motion's size and speed, from its start and the acceleration there."""
    x0, v0 = float(theta[SLOT["x0"]]), float(theta[SLOT["v0"]])
    span = float(times[-1])
    rough = max(abs(x0 - float(theta[SLOT["xe"]])), abs(v0) * 0.1 * span) or 1.0
    first = _of_size(theta, laws, active, rough, rough)
    push = abs(float(first.slopes(np.zeros(1), np.array([x0]), np.array([v0]), -math.copysign(1.0, x0))[0][0]))
    speed = max(abs(v0), math.sqrt(push * rough), rough / span if span > 0.0 else 0.0)
    return _of_size(theta, laws, active, rough, speed)


def _of_size(
    theta: Array, laws: tuple[PlacedTerm, ...], active: tuple[int, ...], size: float, speed: float
) -> OwnMotion:
    """The motion of that size with the tolerances of fits."""
    absolute = RELATIVE_TOLERANCE * np.array([size, speed])
    return OwnMotion(theta, laws, active, size, speed, STANDSTILL * speed, RELATIVE_TOLERANCE, absolute)


def _march(motion: OwnMotion, times: Array) -> tuple[Samples, int]:
    """From reversal to reversal up to the last of ``times``; the steps taken."""
    columns = 1 + len(motion.active)
    state = _start(motion)
    x, v, a = (np.zeros((times.size, columns)) for _ in range(3))
    t, end, steps = 0.0, float(times[-1]), 0
    side = float(np.sign(state[1, 0])) or _leaves(motion, t, state[0, 0])
    for _ in range(MOST_REVERSALS):
        here = times >= t
        if side == 0.0:
            x[here], v[here], a[here] = state[0], 0.0, 0.0
            return (x, v, a), steps
        t, state, before, more = _stretch(motion, (t, end), state, side, times, (x, v, a))
        steps += more
        if t >= end:
            return (x, v, a), steps
        turned = _leaves(motion, t, state[0, 0])
        after = motion.slopes(np.array([t]), state[0, :1], np.zeros(1), turned)[0][0] if turned else 0.0
        state[1] *= after / before if before else 0.0
        state[1, 0] = 0.0
        side = turned
    raise IdentificationError(TURNS)


def _leaves(motion: OwnMotion, t: float, x: float) -> float:
    """Direction in which a body at rest starts to move, 0 where it sticks."""
    at = np.array([t]), np.array([x]), np.zeros(1)
    for side in (1.0, -1.0):
        if motion.slopes(*at, side)[0][0] * side > 0.0:
            return side
    return 0.0


def _stretch(
    motion: OwnMotion, span: tuple[float, float], state: Array, side: float, times: Array, out: Samples
) -> tuple[float, Array, float, int]:
    """One stretch to its reversal or the end: fills samples; gives its last instant, state and acceleration there, and
    its steps.

    Steps follow the motion's own error; its derivatives are as smooth and need no other ones.
    """
    shape = state.shape
    started = abs(state[1, 0]) <= motion.still

    def slope(t: float, flat: Array) -> Array:
        y = flat.reshape(shape)
        a, ax, av, by = motion.slopes(np.array([t]), y[0, :1], y[1, :1], side)
        rate = np.empty(shape)
        rate[0] = y[1]
        rate[1, 0] = a[0]
        rate[1, 1:] = ax[0] * y[0, 1:] + av[0] * y[1, 1:] + by[0]
        return rate.ravel()

    def reversal(t: float, flat: Array) -> float:
        return float(flat[shape[1]]) * side + (motion.still if started and t == span[0] else 0.0)

    reversal.terminal, reversal.direction = True, -1  # type: ignore[attr-defined]
    tolerance = np.full(shape, UNCONTROLLED)
    tolerance[:, 0] = motion.absolute
    piece = solve_ivp(
        slope, span, state.ravel(), "DOP853", events=reversal, dense_output=True, rtol=motion.relative,
        atol=tolerance.ravel(),
    )  # fmt: skip
    last = piece.y[:, -1].reshape(shape)
    if not np.all(np.isfinite(last)) or piece.status < 0:
        raise IdentificationError(f"the motion leaves every bound at {piece.t[-1]:.3g} s; {WRONG}")
    stop = float(piece.t[-1])
    _fill(motion, times, (span[0], stop), piece.sol, side, out)
    before = motion.slopes(np.array([stop]), last[0, :1], np.zeros(1), side)[0][0]
    return stop, last, float(before), piece.t.size


def _fill(
    motion: OwnMotion, times: Array, span: tuple[float, float], dense: Callable[[Array], Array], side: float,
    out: Samples,
) -> None:  # fmt: skip
    """Samples of one stretch."""
    x, v, a = out
    here = (times >= span[0]) & (times <= span[1])
    if not np.any(here):
        return
    y = dense(times[here]).reshape(2, x.shape[1], -1).transpose(0, 2, 1)
    x[here], v[here] = y
    level, ax, av, by = motion.slopes(times[here], y[0, :, 0], y[1, :, 0], side)
    a[here, 0] = level
    a[here, 1:] = ax[:, None] * y[0, :, 1:] + av[:, None] * y[1, :, 1:] + by


def spring_force(theta: Array, slots: np.ndarray, x: Array, v: Array) -> tuple[Array, Array]:
    """Force in the springs (n, 1 + p) with its derivatives by ``slots`` (p,), and its rate of change (n,), N and N/s.

    The sum of all laws that are ``sprung``: what load cells in the springs see. ``x`` (n, 1 + p) is
    the displacement with its derivatives, ``v`` (n,) the velocity.
    """
    here = x[:, 0] - theta[SLOT["xe"]]
    springs = {slot: (law(here), slope(here)) for slot, (law, slope) in SPRINGS.items()}
    rate = sum((theta[SLOT[name]] * slope for name, (_, slope) in springs.items()), np.zeros(here.size))
    force = np.empty(x.shape)
    force[:, 0] = sum((theta[SLOT[name]] * law for name, (law, _) in springs.items()), np.zeros(here.size))
    force[:, 1:] = rate[:, None] * x[:, 1:]
    for column, slot in enumerate(slots.tolist(), start=1):
        for name, (law, _) in springs.items():
            if slot == SLOT[name]:
                force[:, column] += law
        if slot == SLOT["xe"]:
            force[:, column] -= rate
    return force, rate * v
