"""`fit_driven`: the numbers of a driven body's equation from arrays, and its free run on a record nobody fitted.

Belongs here: from arrays to the fit, what its result can do. Does not belong here: the fit (methods/driven.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, get_args

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy.signal import detrend

from undertow.campaign.driven.run import ADEQUATE, far_away
from undertow.conditioning.driven import DrivenTrial, Frame, Quantity
from undertow.conditioning.driven_records import Inputs, Records, Times, UnitsSaid, driven_record, driven_records
from undertow.conditioning.scale import driven_out_of_scale
from undertow.discrepancy.words import percent
from undertow.equation.driven_laws import find_driven, numbers_to_find
from undertow.equation.term import Term
from undertow.errors import ConfigError, IdentificationError, RecordingError, shown
from undertow.front.found_equation import STATES, must_be_decimals, start_state
from undertow.front.known import named_terms
from undertow.front.tables import parameter_lines, parameter_table
from undertow.likelihood.driven import DrivenLaws, extent_of
from undertow.methods.driven import DrivenFit
from undertow.methods.driven import fit_driven as fit_trials
from undertow.methods.driven_equations import (
    DrivenEquation,
    DrivenPrediction,
    equation_text,
    predict_driven,
    simulate_driven,
    written,
)
from undertow.methods.driven_instrument import BesideInstrument, beside_instrument
from undertow.methods.driven_shares import Told, shares_of
from undertow.methods.driven_strokes import vary_by_stroke
from undertow.quantities import OK, Estimate, Hold, MovingQuantity
from undertow.recording.arrays import instants, real_numbers
from undertow.recording.recording import Array

QUANTITIES: tuple[str, ...] = ("force", *get_args(MovingQuantity))
FRAMES: tuple[str, ...] = get_args(Frame)
HOLDS: tuple[str, ...] = get_args(Hold)
"""What an input can be, what x is relative to where a base moves, and what the input is between samples."""

ASKED = ("input_gain", "input_delay_s")
"""Numbers of the input that are found where a start is given for them."""

LIKE = 0.5
"""Least correlation of a displacement with its velocity summed over time: noise leaves more, another signal far less.
"""


@dataclass(frozen=True, eq=False, repr=False)
class Driven:
    """A fitted driven equation: ``fit`` with everything, ``trials`` what it was fitted to."""

    fit: DrivenFit
    trials: tuple[DrivenTrial, ...]

    @property
    def trial(self) -> DrivenTrial:
        """The first record that is driven."""
        return next(trial for trial in self.trials if not trial.free)

    @property
    def told(self) -> Mapping[str, Told]:
        """Standard errors of each number from all records, from driven ones and from decays alone; empty without
        decays."""
        return shares_of(self.trials, self.fit)

    @property
    def numbers(self) -> Mapping[str, Estimate]:
        """Every number with its standard error and unit, by ``mass_kg`` and law.parameter."""
        return self.fit.estimates

    @property
    def parameters(self) -> pd.DataFrame:
        """One row a number: value, stderr, low and high of its 90 % interval, unit, note."""
        return parameter_table(self.numbers)

    def equations(self, precision: int | None = None) -> list[str]:
        """The equation in one line, with its laws' symbols, and its numbers with their errors, or with ``precision``
        decimals."""
        must_be_decimals(precision)
        return [equation_text(written(self.fit, self.rms, self._size, self.trial), precision)]

    def print(self, precision: int | None = None) -> None:
        """Print `equations`, one a line."""
        print(*self.equations(precision), sep="\n")

    @property
    def doubts(self) -> tuple[str, ...]:
        """What a reader must know first: a search that failed, a bound, a motion out of scale, a free run that misses
        more than noise."""
        said = [] if self.fit.outcome == OK else [self.fit.outcome]
        said += driven_out_of_scale([one for one in self.trials if not one.free])
        noise = self.trial.noise()["displacement"]
        if self.rms > ADEQUATE * noise:
            share = self.rms / self._size
            said.append(
                f"the free run over what was fitted misses {percent(share)} of the motion, {self.rms / noise:.2g} "
                "times the sensor's noise: the equation lacks something"
            )
            said += [far.strip()] if (far := far_away(self.trials, share)) else []
        return tuple(said)

    def __repr__(self) -> str:
        lines = [f"! {one}" for one in self.doubts]
        return "\n".join([self.equations()[0].split("; ")[0], *lines, *parameter_lines(self.numbers)])

    @property
    def rms(self) -> float:
        """RMS of the free run over the first driven record, unit of x."""
        return self.fit.rms[self.trial.name]

    def by_instrument(self) -> BesideInstrument:
        """The numbers beside those that the instrument gives; IdentificationError where the record has none."""
        return beside_instrument(self.trial, self.fit)

    def by_stroke(self) -> Driven:
        """The same equation with an offset and a friction that vary from stroke to stroke: ``fit.strokes`` says by how
        much, ``numbers`` and `predict`'s band are beside that. IdentificationError where the record does not ask for
        it."""
        return Driven(vary_by_stroke(self.trials, self.fit), self.trials)

    def predict(
        self, x: ArrayLike, *, t: ArrayLike | float, u: ArrayLike, start: int = 50, units: UnitsSaid | None = None
    ) -> DrivenPrediction:
        """The free run (SI) under another input, from the first ``start`` samples of x alone, with its 90 % band."""
        return predict_driven(self._record(x, t, u, units), self._equation, start)

    def simulate(
        self, x0: ArrayLike, t: ArrayLike | float, u: ArrayLike, *, v0: float | None = None,
        units: UnitsSaid | None = None,
    ) -> Array:  # fmt: skip
        """Displacement (n,) in SI under the input ``u`` (n,) at the times (or the step) ``t``, from ``x0`` (m, rad) and
        ``v0``, or from the state [x0, v0] as pysindy writes it; relative to a base that moves. What it was recorded
        beside, sensors and their noise, has no part in it."""
        begun, speed = start_state(x0, v0)
        still = np.zeros(real_numbers(u, "u").size)
        return simulate_driven(self._record(still, t, u, units), self._equation, begun, speed)

    def score(
        self, x: ArrayLike | None = None, *, t: ArrayLike | float | None = None, u: ArrayLike | None = None,
        start: int = 50, units: UnitsSaid | None = None,
    ) -> float:  # fmt: skip
        """1 less the free run's error (RMS over RMS displacement) on one record, best one that was not fitted; the mean
        over its own records where none is given."""
        if x is None and t is None and u is None:
            sizes = [float(np.sqrt(np.mean(trial.outputs[trial.main] ** 2))) for trial in self.trials]
            shares = [self.fit.rms[trial.name] / size for trial, size in zip(self.trials, sizes, strict=True)]
            return 1.0 - float(np.mean(shares))
        if x is None or t is None or u is None:
            given = ", ".join(name for name, one in (("x", x), ("t", t), ("u", u)) if one is not None)
            raise RecordingError(f"{given} of a record is given alone; give x, t and u, or none of them")
        record = self._record(x, t, u, units)
        moved = record.outputs["displacement"]
        missed = predict_driven(record, self._equation, start).values - moved  # noqa: PD011
        return 1.0 - float(np.sqrt(np.mean(missed**2) / np.mean(moved**2)))

    def _record(self, x: ArrayLike, t: ArrayLike | float, u: ArrayLike, units: UnitsSaid | None) -> DrivenTrial:
        """Another record of the same kind."""
        must_be_displacements(x, t)
        frame = self.trial.frames.get("displacement")
        return driven_record(x, t, u, self.trial.hold, self.trial.quantity, frame, units=units)

    @property
    def _size(self) -> float:
        """Standard deviation of the first driven record's motion, unit of x."""
        return float(np.std(self.trial.outputs["displacement"]))

    @property
    def _equation(self) -> DrivenEquation:
        """Everything that a free run needs."""
        varying = self.fit.strokes
        return DrivenEquation(
            self.fit.started, self.fit.names, self.fit.values, self.fit.covariance,
            self.rms if varying is None else varying.beyond, self._size, self.trial.noise()["displacement"],
            extent_of(self.trial), {}, (0.0, 0.0) if varying is None else varying.spreads,
        )  # fmt: skip


def fit_driven(
    x: Records,
    *,
    t: Times,
    u: Inputs,
    equation: Sequence[str | Term] = ("stiffness", "viscous_damping"),
    hold: Hold = "first",
    starts: Mapping[str, float] | None = None,
    held: Mapping[str, float] | None = None,
    quantity: Quantity = "force",
    frame: Frame | None = None,
    instrument: ArrayLike | None = None,
    units: UnitsSaid | None = None,
) -> Driven:
    """The numbers of M x'' + sum of laws = u(t) by output error: one free run over the whole record.

    ``x`` (n,) displacement, ``t`` (n,) times or the step in s, ``u`` (n,) the measured force, ``hold`` what it is
    between samples. Several records of one body are lists of these (``t`` may be one step for all); of a decay, from
    its release on, u is None: nothing drives it. ``starts`` gives start values by ``mass_kg`` and law.parameter,
    ``held`` what is known; a hysteresis needs starts. ``quantity`` says what u is where it is motion of the base
    (base_displacement, base_velocity, base_acceleration) or of the water (water_velocity, water_acceleration),
    ``frame`` whether x is absolute or relative to a base that moves; where no number is held then, all forces are per
    mass. ``instrument`` (n,) is a signal that moves the body and that no noise of it reaches (the target of a
    controller that makes the force): `Driven.by_instrument` then gives the numbers by it. ``units`` are those of x, t
    and u, as ``{"x": "mm", "u": "kN"}``; what is not said is in SI units, and so are the results.

    Raises RecordingError where the arrays do not fit together, IdentificationError where no start has bounds.

    >>> t = np.arange(1000) * 0.01
    >>> u = np.sin(0.3 * t**2)
    >>> from scipy.signal import lsim
    >>> x = lsim(([1.0], [2.0, 1.0, 50.0]), u, t)[1]
    >>> found = fit_driven(x, t=t, u=u)
    >>> round(found.numbers["stiffness.k_N_per_m"].value, 2)
    50.0
    """
    terms = named_terms(equation, find_driven)
    if not terms:
        raise IdentificationError(f"equation names {len(terms)} terms; give at least one law beside the inertia")
    for name, said, known in (("quantity", quantity, QUANTITIES), ("frame", frame, FRAMES), ("hold", hold, HOLDS)):
        if said is not None and said not in known:
            raise ConfigError(f"{name} is {shown(said)}; give one of {', '.join(known)}")
    laws = DrivenLaws(terms, {} if held is None else held, {} if starts is None else starts)
    numbers_to_find(list(laws.units), laws.fixed, laws.starts, ASKED, laws.usual)
    must_be_displacements(x, t)
    trials = driven_records(x, t, u, hold, quantity, frame, instrument, units)
    return Driven(fit_trials(trials, laws), trials)


def must_be_displacements(x: Any, t: Any) -> None:
    """RecordingError where a column stands beside a displacement that is not its velocity: it would be left out, and
    nobody said what it is."""
    many = isinstance(x, list | tuple) and len(x) > 0 and np.ndim(x[0]) > 0
    times = t if many and isinstance(t, list | tuple) else [t] * (len(x) if many else 1)
    for one, clock in zip(x if many else [x], times, strict=False):
        if np.ndim(one) < STATES or isinstance(one, pd.DataFrame):
            continue
        moved = real_numbers(one, "x")
        if moved.ndim != STATES or moved.shape[1] > STATES or not _goes_on(moved, clock):
            raise RecordingError(
                f"x has the shape {moved.shape}, and what stands beside its first column is not its velocity; give one "
                "displacement (n,), with the velocity beside it or not; several records are a list of these"
            )


def _goes_on(moved: Array, clock: ArrayLike) -> bool:
    """Whether the second column of (n, 2) is the velocity of the first: summed over time it goes as the first does."""
    if moved.shape[1] < STATES or not np.all(np.isfinite(moved)):
        return True
    times = instants(clock)
    steps = np.diff(times) if times.shape == moved.shape[:1] else np.ones(moved.shape[0] - 1)
    gone = np.cumsum(0.5 * (moved[1:, 1] + moved[:-1, 1]) * steps)
    both = detrend(moved[1:, 0]), detrend(gone)
    return float(both[0] @ both[1]) > LIKE * float(np.linalg.norm(both[0]) * np.linalg.norm(both[1]))
