"""Python face of the integrator: a body, the laws beside Eq. 15, and the motion after the release.

Units are SI; in a rotation a mass is an inertia, a force a moment and a displacement an angle.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from experiments.blind_challenge.truths import codes
from experiments.blind_challenge.truths.balance import rule
from experiments.blind_challenge.truths.march import march

TOLERANCE = 1e-9  # of the integrator, relative to the scales of the states
MEMORY_STEPS = 240  # outer steps a period where the past matters


@dataclass(frozen=True)
class Body:
    """Numbers of Eq. 15: M = m + m_a (kg), c (N s/m), k (N/m), Coulomb force (N), drag q (N s^2/m^2), rest position
    (m).
    """

    mass: float
    damping: float
    stiffness: float
    coulomb: float
    drag: float
    rest: float = 0.0

    @property
    def frequency(self) -> float:
        """sqrt(k / M), rad/s."""
        return float(np.sqrt(self.stiffness / self.mass))

    def changed(self, **numbers: float) -> "Body":
        """The same body with some numbers replaced."""
        return replace(self, **numbers)


@dataclass(frozen=True)
class Law:
    """One law beside Eq. 15: its code, its numbers, its states at the release, their scales, and a kernel (KERNEL)."""

    code: int
    numbers: tuple[float, ...]
    start: tuple[float, ...] = ()
    scales: tuple[float, ...] = ()
    kernel: Callable[[np.ndarray], np.ndarray] | None = None
    kernel_length: float = 0.0


@dataclass(frozen=True)
class Motion:
    """Displacement, velocity, acceleration and hidden states (samples x states) at `time` (s, 0 = release)."""

    time: np.ndarray
    x: np.ndarray
    v: np.ndarray
    a: np.ndarray
    hidden: np.ndarray = field(repr=False)


def resonator(
    mass: float, frequency: float, ratio: float, drag: float = 0.0, cubic: float = 0.0, scale: float = 1.0
) -> Law:
    """A hidden resonator at rest: mass (kg), frequency with the body held (rad/s), damping ratio; b and g of the
    contract.
    """
    return Law(
        codes.RESONATOR, (mass, frequency, ratio, drag, cubic), start=(0.0, 0.0), scales=(scale, scale * frequency)
    )


def _layout(laws: tuple[Law, ...]) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, int]:
    """Table of places, numbers, hidden states at the release, their scales, size of the scratch."""
    rows, numbers, start, scales, scratch = [], [], [], [], 0
    for law in laws:
        held = list(law.numbers) + [0.0] * (codes.MEMORY_SIZE - len(law.numbers) if law.code >= codes.ECHO else 0)
        states = (0.0,) if law.code == codes.KERNEL else law.start
        sizes = (1.0,) if law.code == codes.KERNEL else law.scales
        rows.append(
            (law.code, len(numbers), len(numbers) + len(held), 2 + len(start), 2 + len(start) + len(states), scratch)
        )
        numbers += held
        start += states
        scales += sizes
        scratch += 3 * len(states) // 2 if law.code == codes.CELL else 0
    table = np.array(rows, dtype=np.int64).reshape(len(rows), 6)
    return (
        table,
        np.array(numbers, dtype=float),
        np.array(start, dtype=float),
        np.array(scales, dtype=float),
        max(scratch, 1),
    )


def _kernels(laws: tuple[Law, ...], step: float) -> np.ndarray:
    """Two rows a kernel, at whole outer steps and half a step later; a KERNEL law's first number counts them."""
    held = [law for law in laws if law.code == codes.KERNEL]
    size = max([4, *(int(law.kernel_length / step) + 3 for law in held)])
    out = np.zeros((max(2 * len(held), 2), size))
    for i, law in enumerate(held):
        assert law.kernel is not None
        line = law.kernel(0.5 * step * np.arange(2 * size))
        out[2 * i], out[2 * i + 1] = line[0::2], line[1::2]
    return out


def has_memory(laws: tuple[Law, ...]) -> bool:
    """Whether a law needs the stored past, and so a grid that begins at the release."""
    return any(law.code >= codes.ECHO for law in laws)


def simulate(
    body: Body,
    laws: tuple[Law, ...],
    x0: float,
    samples: int,
    step: float,
    first: float | None = None,
    v0: float = 0.0,
    tolerance: float = TOLERANCE,
) -> Motion:
    """Motion at 0, `first`, `first` + `step`, ... (`samples` of them after the release; `first` is `step` where None).

    With memory laws the outer step is divided so that a period has MEMORY_STEPS; `first` must then be a multiple of a
    quarter of `step`.
    """
    first = step if first is None else first
    table, numbers, hidden, hidden_scales, scratch = _layout(laws)
    parts, lead = 1, 0
    fine = step
    if has_memory(laws):
        parts = 4 * max(1, int(np.ceil(step * body.frequency * MEMORY_STEPS / (8 * np.pi))))
        fine = step / parts
        lead = round(first / fine)
    y = np.concatenate([[x0, v0], hidden])
    length = max(abs(x0 - body.rest), 1e-12)
    scales = np.concatenate([[length, length * body.frequency], np.maximum(hidden_scales, 1e-300)])
    for row, law in zip(table, laws, strict=True):
        if law.code == codes.KERNEL:
            scales[row[3]] = length / body.frequency
            numbers[row[1]] = sum(other.code == codes.KERNEL for other in laws[: list(laws).index(law)])
    count = samples if parts == 1 else lead + (samples - 2) * parts + 1
    out = np.empty((count, 1 + y.size))
    values = np.array([body.mass, body.damping, body.stiffness, body.coulomb, body.drag, body.rest])
    march(
        rule(any(law.code == codes.CELL for law in laws)),
        first if parts == 1 else fine,
        fine,
        y,
        float(np.sign(v0)),
        values,
        table,
        numbers,
        np.zeros(scratch),
        _kernels(laws, fine),
        scales,
        tolerance,
        out,
    )
    if parts > 1:
        out = out[np.concatenate([[0], np.arange(lead, count, parts)])]
    time = np.concatenate([[0.0], first + step * np.arange(samples - 1)])
    return Motion(time, out[:, 0], out[:, 1], out[:, 2], out[:, 3:])
