"""An equation handed over moves as ours: in Python, in Octave and in OpenSees, with every law of the registry."""

from __future__ import annotations

import importlib.util
import json
import shutil
import subprocess
from typing import ClassVar

import numpy as np
import pytest

import undertow
from undertow.equation import registry
from undertow.equation.equation import Equation
from undertow.equation.structure import CoulombFriction, Stiffness
from undertow.errors import UndertowError
from undertow.front.handover.exchange import equation_from_json, json_text
from undertow.front.handover.opensees import followed
from undertow.front.handover.symbols import system_of
from undertow.front.simulation import equation_of

MASS_KG, X0_M = 4.0, 0.1
BODY = {"stiffness": 400.0, "viscous_damping": 1.0}
LAWS = {
    "stiffness": {},
    "viscous_damping": {},
    "coulomb_friction": {"coulomb_friction": 3.0},
    "added_mass": {"added_mass": 1.5},
    "quadratic_drag": {"quadratic_drag": 6.0},
    "added_stiffness": {"added_stiffness": 40.0},
    "linear_damping": {"linear_damping": 2.0},
    "cubic_damping": {"cubic_damping": 5.0},
    "asymmetric_damping": {"asymmetric_damping": 0.6},
    "asymmetric_drag": {"asymmetric_drag": -4.0},
    "drag_exponent": {"drag_exponent": {"coefficient_N_sp_per_mp": 4.0, "exponent": 1.5}},
    "cubic_stiffness": {"cubic_stiffness": 9000.0},
    "quintic_stiffness": {"quintic_stiffness": 9e5},
    "asymmetric_stiffness": {"asymmetric_stiffness": 600.0},
    "stiffness_drift": {"stiffness_drift": {"N_per_m": -40.0, "time_s": 1.5}},
    "quadratic_stiffness": {"quadratic_stiffness": 900.0},
    "sine_restoring": {"sine_restoring": 200.0},
    "position_damping": {"position_damping": 20.0},
    "van_der_pol_damping": {"van_der_pol_damping": 300.0},
    "stribeck_friction": {
        "coulomb_friction": 2.0, "stribeck_friction": {"static_force_N": 1.0, "velocity_m_per_s": 0.2}
    },
    "asymmetric_friction": {"coulomb_friction": 3.0, "asymmetric_friction": 1.0},
    "variable_normal_force": {"coulomb_friction": 1.0, "variable_normal_force": 20.0},
    "hidden_resonator": {
        "coulomb_friction": 1.0,
        "hidden_resonator": [
            {"mass_kg": 0.4, "natural_frequency_rad_per_s": 9.0, "damping_ratio": 0.02},
            {"mass_kg": 0.3, "natural_frequency_rad_per_s": 14.0, "quadratic_damping_per_m": 3.0,
             "cubic_stiffness_per_m2_s2": 500.0},
        ],
    },
    "relaxation": {"relaxation": {"stiffness_N_per_m": 60.0, "time_s": 0.2}, "coulomb_friction": 2.0},
    "hysteresis": {"hysteresis": {"stiffness_N_per_m": 150.0, "yield_displacement_m": 0.02}},
    "external_forcing": {
        "external_forcing": {"amplitude_N": 3.0, "frequency_rad_per_s": 7.0, "phase_rad": 0.5}, "coulomb_friction": 2.0
    },
    "changing_force": {
        "changing_force": {
            "amplitude_N": 3.0, "frequency_rad_per_s": 7.0, "phase_rad": 0.5, "change_per_s": -0.2,
            "change_phase_rad": 0.3, "bend_per_s2": 0.01, "bend_phase_rad": 2.0,
        },
    },
    "delayed_echo": {"delayed_echo": {"gain": 2.0, "delay_s": 0.7}},
}  # fmt: skip
"""Every term of the registry with what it needs beside it."""

WITHIN = 1e-3
"""Of the RMS of our own motion: what the issue of a hand-over is, far above both integrators' errors."""


LONG_S, SHORT_S = 8.0, 1.0
"""Long enough for friction to hold the body; a period and a half, with an echo of it, for the slow Octave."""


def run_of(name: str, duration_s: float = LONG_S) -> undertow.front.simulation.Simulation:
    """Our own motion with one law beside spring and damper."""
    return undertow.simulate(BODY | LAWS[name], x0=X0_M, mass_kg=MASS_KG, duration_s=duration_s, rate_hz=50.0)


def run_in_octave(name: str) -> undertow.front.simulation.Simulation:
    """The motion that Octave repeats: to its end for friction alone."""
    return run_of(name, 0.5 * LONG_S if name == "coulomb_friction" else SHORT_S)


def assert_alike(x: np.ndarray, run: undertow.front.simulation.Simulation) -> None:
    assert np.sqrt(np.mean((x - run.x) ** 2)) < WITHIN * np.sqrt(np.mean(run.x**2))


def test_every_law_of_the_registry_is_handed_over():
    assert set(LAWS) == set(registry.names())
    for name in registry.names():
        assert system_of(equation_of(BODY | LAWS[name], MASS_KG)).values["mass_kg"] >= MASS_KG


@pytest.mark.parametrize("name", LAWS)
def test_a_python_program_moves_as_our_equation(name):
    run = run_of(name)
    scope: dict = {}
    exec(compile(run.to_python(), "free_decay.py", "exec"), scope)
    x, v = scope["simulate"](X0_M, run.t)
    assert_alike(x, run)
    assert np.sqrt(np.mean((v - run.v) ** 2)) < WITHIN * np.sqrt(np.mean(run.v**2))


def test_a_python_program_needs_no_undertow_and_keeps_rest_and_start(tmp_path):
    law = Equation(*zip(*[(Stiffness(), 400.0)], strict=True), mass_kg=4.0, rest_m=0.02)
    run = undertow.simulate(law, x0=0.1, v0=0.3, duration_s=3.0, rate_hz=50.0)
    text = run.to_python(tmp_path / "decay.py")
    assert (tmp_path / "decay.py").read_text() == text
    assert "import undertow" not in text
    scope: dict = {}
    exec(compile(text, "decay.py", "exec"), scope)
    assert_alike(scope["simulate"](0.1, run.t, 0.3)[0], run)


@pytest.fixture(scope="module")
def octave_motions(tmp_path_factory):
    """Displacements of all programs, run by Octave in one session: name -> (n,)."""
    octave = shutil.which("octave-cli") or shutil.which("octave")
    if octave is None:
        pytest.skip("Octave is not installed (Debian's package octave)")
    folder = tmp_path_factory.mktemp("octave")
    lines = []
    for name in LAWS:
        run = run_in_octave(name)
        run.to_octave(folder / f"decay_{name}.m")
        times = f"(0:{run.t.size - 1}) / 50"
        lines.append(f"x = decay_{name}({X0_M}, {times}); dlmwrite('{name}.txt', x', 'precision', '%.12g');")
    (folder / "every.m").write_text("\n".join(lines))
    subprocess.run([octave, "--no-gui", "--norc", "every.m"], cwd=folder, check=True, capture_output=True, timeout=600)
    return {name: np.loadtxt(folder / f"{name}.txt") for name in LAWS}


@pytest.mark.parametrize("name", LAWS)
def test_an_octave_program_moves_as_our_equation(name, octave_motions):
    assert_alike(octave_motions[name], run_in_octave(name))


@pytest.mark.parametrize("name", [name for name in LAWS if name in followed()])
def test_an_opensees_model_moves_as_our_equation(name):
    if importlib.util.find_spec("openseespy") is None:
        pytest.skip("openseespy is not installed (pip install openseespy; it needs Debian's libblas3 and liblapack3)")
    run = run_of(name)
    scope: dict = {}
    exec(compile(run.to_opensees(), "model.py", "exec"), scope)
    x, _ = scope["simulate"](X0_M, run.t)
    assert_alike(x, run)


def test_an_opensees_model_keeps_the_rest_position_of_the_springs():
    pytest.importorskip("openseespy", reason="openseespy is not installed")
    law = Equation(*zip(*[(Stiffness(), 400.0), (CoulombFriction(), 3.0)], strict=True), mass_kg=4.0, rest_m=0.02)
    run = undertow.simulate(law, x0=0.1, duration_s=3.0, rate_hz=50.0)
    scope: dict = {}
    exec(compile(run.to_opensees(), "model.py", "exec"), scope)
    assert_alike(scope["simulate"](0.1, run.t)[0], run)


@pytest.mark.parametrize("name", LAWS)
def test_an_equation_comes_back_from_json_as_it_went(name):
    law = run_of(name).equation
    assert equation_from_json(json_text(law, {"stiffness": 2.0})) == law


def test_json_says_units_and_errors(tmp_path):
    run = run_of("relaxation")
    data = json.loads(run.to_json(tmp_path / "law.json"))
    assert data["terms"][0]["parameters"]["k_N_per_m"] == {"value": 400.0, "unit": "N/m"}
    assert data["text"] == str(run.equation)
    erring = json.loads(json_text(run.equation, {"stiffness": 2.0}))
    assert erring["terms"][0]["parameters"]["k_N_per_m"]["stderr"] == 2.0


def test_sympy_has_the_equation_and_its_hidden_states():
    import sympy as sp

    given = run_of("hidden_resonator").to_sympy()
    motion, *states = given.with_numbers()
    t = sp.Symbol("t", real=True)
    x = sp.Function("x", real=True)(t)
    assert motion.lhs.coeff(x.diff(t, 2)) == 4.0
    assert motion.lhs.coeff(x) == 400.0
    assert len(states) == 4
    assert given.symbols["hidden_resonator2_mass_kg"] in given.values


def test_latex_has_numbers_with_errors_of_a_fit():
    run = run_of("viscous_damping")
    found = undertow.fit(run.recorded(noise_m=1e-4), ["stiffness", "viscous_damping"], mass_kg=MASS_KG)
    assert r"\pm" in found.to_latex()
    assert found.to_latex(numbers=False) == r"M\ddot{x} + k x + c \dot{x} = 0"


def test_what_cannot_be_handed_over_is_refused():
    class Own(Stiffness):
        """A law of a user's own."""

        name = "own_spring"
        slots: ClassVar = {}

    own = Equation((Own(),), (400.0,), mass_kg=4.0)
    run = undertow.simulate(own, x0=0.1, duration_s=1.0, rate_hz=50.0)
    for write in (run.to_python, run.to_octave):
        with pytest.raises(UndertowError, match="with a law of your own"):
            write()
    with pytest.raises(UndertowError, match="own_spring is a law of your own, written as code"):
        run.to_sympy()
    with pytest.raises(UndertowError, match="own_spring has no material in OpenSees"):
        run.to_opensees()
    with pytest.raises(UndertowError, match="stribeck_friction has no material in OpenSees"):
        run_of("stribeck_friction").to_opensees()
    with pytest.raises(UndertowError, match="Octave cannot call a function 'my-law'"):
        run_of("stiffness").to_octave(path="my-law.m")
    with pytest.raises(UndertowError, match="the text is 'other', not 'undertow equation'"):
        equation_from_json('{"format": "other"}')
    with pytest.raises(UndertowError, match="the text is no whole undertow equation \\('terms' is wrong or lacking\\)"):
        equation_from_json('{"format": "undertow equation", "version": 1}')


def test_coefficients_by_name_are_checked():
    with pytest.raises(UndertowError, match="hidden_resonator lacks its mass_kg; it has mass_kg, natural_frequency"):
        equation_of({"hidden_resonator": {"damping_ratio": 0.1}})
    with pytest.raises(UndertowError, match="relaxation has no parameter 'tau'"):
        equation_of({"relaxation": {"stiffness_N_per_m": 1.0, "tau": 2.0}})
    with pytest.raises(UndertowError, match="equation is of type list; give an Equation"):
        equation_of(["stiffness"])


@pytest.mark.parametrize("text", ["", "{", "[" * 100_000])
def test_an_equation_that_is_no_json_is_refused(text: str) -> None:
    with pytest.raises(UndertowError, match=r"the text is no JSON \(.*\); write it with to_json"):
        equation_from_json(text)
