"""A law of a user's own in `Discover`'s library: kept or left out like any term, with its inner parameter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

import undertow
from undertow.equation.equation import Equation
from undertow.equation.kernel import N_SLOTS, SLOT
from undertow.equation.registry import find
from undertow.equation.structure import CubicStiffness
from undertow.equation.term import Array, Term
from undertow.errors import IdentificationError
from undertow.quantities import Parameter

LIBRARY = ["stiffness", "viscous_damping", "coulomb_friction", "cubic_stiffness"]


@dataclass(frozen=True)
class Brake(Term):
    """A magnet over a part of the rail."""

    width_m: float = 0.05

    name: ClassVar[str] = "brake"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("strength_Ns_per_m", "N s/m", "b", 0.0), Parameter("width_m", "m", "w", 0.001, 1.0),
    )  # fmt: skip
    law: ClassVar[str] = "b v / (1 + (x / w)^2)"
    latex: ClassVar[str] = r"b \dot{x} / (1 + (x / w)^2)"
    source: ClassVar[str] = "made up for this test"
    left_out: ClassVar[str] = "small swings die sooner than large ones"

    def force(self, x: Array, v: Array, a: Array, t: Array) -> Array:
        """Force over the strength, (n,)."""
        return v / (1.0 + (x / self.width_m) ** 2)


class OwnCubic(CubicStiffness):
    """A law of the registry as a user would write it."""

    name: ClassVar[str] = "own_cubic"
    slots: ClassVar = {}

    def force(self, x: Array, v: Array, a: Array, t: Array) -> Array:
        """x^3, (n,)."""
        return x**3


class Table(Brake):
    """A law that looks up a table."""

    name: ClassVar[str] = "table"

    def force(self, x: Array, v: Array, a: Array, t: Array) -> Array:
        """v times what a table says, (n,)."""
        return v * np.interp(x, [-1.0, 0.0, 1.0], [0.0, 1.0, 0.0])


def trials_of(*laws: tuple[Term, float]) -> undertow.Trials:
    body = Equation(*zip((find("stiffness"), 400.0), (find("viscous_damping"), 0.4), *laws, strict=True), mass_kg=4.0)
    runs = [undertow.simulate(body, x0=x0, duration_s=6.0, rate_hz=50.0) for x0 in (0.04, 0.1, 0.07)]
    return undertow.read([run.recorded(noise_m=2e-4, seed=i, name=f"r{i}") for i, run in enumerate(runs)])


def discovered(trials: undertow.Trials, *own: Term) -> undertow.Discover:
    return undertow.Discover([*LIBRARY, *own], resamples=0, outside=False).fit(trials)


def test_a_law_of_ones_own_is_kept_with_its_inner_parameter():
    trials = trials_of((Brake(0.03), 6.0))
    found = discovered(trials[:2], OwnCubic(), Brake())
    assert [term.name for term in found.terms_] == ["stiffness", "viscous_damping", "brake"]
    strength, width = found.estimates_["brake"], found.estimates_["brake.width_m"]
    assert abs(strength.value - 1.5) < 3.0 * strength.total_stderr < 0.3
    assert abs(width.value - 0.03) < 3.0 * width.total_stderr < 0.009
    assert found.structure_.left == pytest.approx(1.0, abs=0.1)
    without = discovered(trials[:2])
    assert found.score(trials[2:]) > 0.98 > without.score(trials[2:])
    band = found.prediction(trials[2:], draws=40)
    assert band.notes[0].startswith("band: the numbers' errors")
    assert 0.8 < band.runs[0].inside <= 1.0
    thetas = found.theta_draws(2000, np.random.default_rng(0))[0]
    errors = np.std(thetas, axis=0)
    assert sorted(errors[errors > 0.0]) == pytest.approx(sorted(found.parameters["stderr"]), rel=0.06)
    together = np.corrcoef(thetas[:, [SLOT["c1"], N_SLOTS]].T)[0, 1]
    covariance = found.structure_.covariance
    assert together == pytest.approx(covariance[1, 2] / np.sqrt(covariance[1, 1] * covariance[2, 2]), abs=0.05)
    assert together < -0.8  # the brake and the damping, of which a band knows the sum


def test_a_law_of_ones_own_that_is_not_there_is_left_out():
    found = discovered(trials_of(), Brake())
    assert [term.name for term in found.terms_] == ["stiffness", "viscous_damping"]


def test_a_law_of_the_registry_written_anew_gives_what_the_registrys_gives():
    trials = trials_of((find("cubic_stiffness"), 8000.0))
    ours, own = (
        undertow.Discover(["stiffness", "viscous_damping", law], resamples=0, outside=False).fit(trials)
        for law in ("cubic_stiffness", OwnCubic())
    )
    assert own.coefficients_ == pytest.approx(ours.coefficients_, rel=1e-4)
    for mine, theirs in zip(own.estimates_.values(), ours.estimates_.values(), strict=True):
        assert mine.stderr == pytest.approx(theirs.stderr, rel=2e-2)
    assert own.score(trials) == pytest.approx(ours.score(trials), abs=1e-5)


def test_what_lies_beyond_a_law_of_ones_own_is_said_not_to_have_been_searched():
    found = undertow.Discover(["stiffness", "viscous_damping", Brake()], resamples=0, second_route=False)
    found.fit(trials_of((Brake(0.03), 6.0)))
    assert found.adequate_ is None
    assert "equation has brake, a law of your own without slots" in found.outside_.sentence


@pytest.mark.parametrize(
    ("settings", "reason"),
    [
        ({"terms": ["stiffness", Table()]}, "^table is no formula of numpy's functions, so that a library with it"),
        ({"terms": ["stiffness", Brake()], "scatter": {"brake": 0.1}}, "your own law is alike in all trials"),
    ],
)
def test_what_a_library_with_a_law_of_ones_own_cannot_have_is_said(settings, reason):
    with pytest.raises(IdentificationError, match=reason):
        undertow.Discover(**settings, resamples=0).fit(trials_of())
