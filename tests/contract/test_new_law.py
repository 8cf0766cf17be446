"""A law written as one class is simulated, fitted, suspected, named and reported: nothing else knows its name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import pytest

import undertow
from undertow.equation import registry
from undertow.equation.term import Array, Element, Term
from undertow.errors import ConfigError
from undertow.quantities import Parameter

K_N_PER_M, C_NS_PER_M, MASS_KG, OWN_N_PER_M2 = 400.0, 1.0, 4.0, 500.0


@dataclass(frozen=True)
class ClosingGap(Term):
    """A support that stiffens as it closes, F = k_g x|x|."""

    name: ClassVar[str] = "closing_gap"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("N_per_m2", "N/m^2", "k_g"),)
    slots: ClassVar[Mapping[str, str]] = {"N_per_m2": "ka"}
    law: ClassVar[str] = "k_g x|x|"
    latex: ClassVar[str] = "k_g x|x|"
    source: ClassVar[str] = "a test"
    left_out: ClassVar[str] = "a period that falls with amplitude"
    suspect_of: ClassVar = "structure"
    words: ClassVar[str] = "a gap that closes"
    next_test: ClassVar[str] = "a feeler gauge at the support"
    element: ClassVar[Element] = "elastic"

    def force(self, x: Array, v: Array, a: Array, t: Array) -> Array:
        """x|x|, in m^2."""
        return x * np.abs(x)


@pytest.fixture
def with_own_law(monkeypatch):
    """The registry with the new law on it, for one test."""
    monkeypatch.setattr(registry, "_LAWS", registry.catalogue())
    registry.register(ClosingGap)
    return registry


def recordings() -> list:
    law = {"stiffness": K_N_PER_M, "viscous_damping": C_NS_PER_M, "closing_gap": OWN_N_PER_M2}
    runs = [undertow.simulate(law, x0=x0, mass_kg=MASS_KG, rate_hz=60.0, duration_s=5.0) for x0 in (0.04, 0.08, 0.1)]
    return [run.recorded(noise_m=1e-4, seed=i, name=f"r{i}") for i, run in enumerate(runs)]


def test_a_new_law_is_simulated_and_handed_over(with_own_law):
    law = {"stiffness": K_N_PER_M, "closing_gap": OWN_N_PER_M2}
    run = undertow.simulate(law, x0=0.1, mass_kg=MASS_KG, rate_hz=50.0, duration_s=1.0)
    plain = undertow.simulate({"stiffness": K_N_PER_M}, x0=0.1, mass_kg=MASS_KG, rate_hz=50.0, duration_s=1.0)
    assert np.ptp(run.x - plain.x) > 0.01 * np.ptp(plain.x)
    assert "'ElasticMultiLinear'" in run.to_opensees()


def test_a_new_law_is_fitted(with_own_law):
    found = undertow.fit(
        recordings(), ["stiffness", "viscous_damping", "closing_gap"], mass_kg=MASS_KG, stiffness_N_per_m=K_N_PER_M
    )
    number = found.estimates["closing_gap_N_per_m2"]
    assert abs(number.value - OWN_N_PER_M2) < 3.0 * number.total_stderr
    assert number.total_stderr < 0.1 * OWN_N_PER_M2


def test_a_new_law_is_suspected_named_and_reported(with_own_law):
    found = undertow.diagnose(
        recordings(), ["stiffness", "viscous_damping"], mass_kg=MASS_KG, stiffness_N_per_m=K_N_PER_M,
        suspects=["closing_gap", "linear_damping"], scatter={"k": 0.001, "c": 0.05},
    )  # fmt: skip
    assert found[0].names == ("closing_gap",)
    verdict = found.findings.groups[0].verdict
    assert verdict.next_test == ClosingGap.next_test
    assert "A gap that closes explains it" in verdict.sentence
    assert "a gap that closes" in found._repr_html_() or "closing_gap" in found._repr_html_()


def test_a_name_is_taken_once(with_own_law):
    with pytest.raises(ConfigError, match="'closing_gap' is in the registry already; give the law a name of its own"):
        registry.register(ClosingGap)
