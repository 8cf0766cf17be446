"""A law that is an expression takes one row: its place in the compiled integrator is generated, not written.

The row is added to a copy of the package, whose compiled functions stay with it: a change of a row must reach them.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import undertow

pytestmark = pytest.mark.slow

ROW = '''

@dataclass(frozen=True)
class ClosingStop(Term):
    """A stop that closes with the displacement and drags while it does, F = k_w x |x| (1 + (v / 1 m/s)^2)."""

    name: ClassVar[str] = "closing_stop"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("N_per_m2", "N/m^2", "k_w"),)
    slots: ClassVar[Mapping[str, str]] = {"N_per_m2": "kw"}
    law: ClassVar[str] = "k_w x|x| (1 + v^2)"
    latex: ClassVar[str] = r"k_w x|x| (1 + \\\\dot{x}^2)"
    source: ClassVar[str] = "a test"
    left_out: ClassVar[str] = "a period that falls with amplitude"
    suspect_of: ClassVar = "structure"
    words: ClassVar[str] = "a stop that closes"
    next_test: ClassVar[str] = "a feeler gauge at the stop"

    def share(self, p: Mapping[str, Expression], q: SymbolPlace, number: str) -> Share:
        """A smooth force on either side."""
        import sympy as sp

        return Share(smooth=p["N_per_m2"] * q.x * sp.Abs(q.x) * (1 + q.v**2))
'''

USE = """
import numpy as np
import undertow
from undertow.equation import registry
from undertow.equation.kernel import N_SLOTS, SLOT, integrate

law = {"stiffness": 400.0, "viscous_damping": 1.0, "closing_stop": 500.0}
runs = [undertow.simulate(law, x0=x0, mass_kg=4.0, rate_hz=60.0, duration_s=5.0) for x0 in (0.04, 0.08, 0.1)]
plain = undertow.simulate({**law, "closing_stop": 0.0}, x0=0.1, mass_kg=4.0, rate_hz=60.0, duration_s=5.0)
print("moves", np.ptp(runs[-1].x - plain.x) / 0.1)

theta = np.zeros(N_SLOTS)
for name, value in {"mass": 4.0, "k1": 400.0, "c1": 1.0, "kw": 500.0, "x0": 0.1}.items():
    theta[SLOT[name]] = value
times, up, down = np.linspace(0.0, 5.0, 300), theta.copy(), theta.copy()
up[SLOT["kw"]], down[SLOT["kw"]] = 500.1, 499.9
none, own = np.zeros(0, np.int64), np.array([SLOT["kw"]])
by = (integrate(up, none, times, 0.005)[0] - integrate(down, none, times, 0.005)[0])[:, 0] / 0.2
print("gap", np.max(np.abs(integrate(theta, own, times, 0.005)[0][:, 1] - by)) / np.max(np.abs(by)))

seen = [run.recorded(noise_m=1e-4, seed=i, name=f"r{i}") for i, run in enumerate(runs)]
found = undertow.fit(seen, list(law), mass_kg=4.0, stiffness_N_per_m=400.0)
number = found.estimates["closing_stop_N_per_m2"]
print("fitted", number.value, number.total_stderr)
told = undertow.diagnose(
    seen, ["stiffness", "viscous_damping"], mass_kg=4.0, stiffness_N_per_m=400.0,
    suspects=["closing_stop", "linear_damping"], scatter={"k": 0.001, "c": 0.05},
)
print("named", *told[0].names)
print("said", told.findings.groups[0].verdict.sentence)
print("text", runs[0].equation)
print("listed", "closing_stop" in registry.names())
"""

AGAIN = """
import undertow
law = {"stiffness": 400.0, "viscous_damping": 1.0, "closing_stop": 500.0}
seen = [
    undertow.simulate({**law, "closing_stop": 0.0, "quadratic_stiffness": 500.0}, x0=x0, mass_kg=4.0, rate_hz=60.0,
    duration_s=5.0).recorded(noise_m=1e-4, seed=0, name=f"r{x0}") for x0 in (0.04, 0.08, 0.1)
]
number = undertow.fit(seen, list(law), mass_kg=4.0, stiffness_N_per_m=400.0).estimates["closing_stop_N_per_m2"]
print("fitted", number.value, number.total_stderr)
"""


@pytest.fixture(scope="module")
def package(tmp_path_factory) -> Path:
    """A copy of the package, with what it has compiled, and the new row."""
    folder = tmp_path_factory.mktemp("rows")
    shutil.copytree(Path(undertow.__file__).parent, folder / "undertow")  # times of change are kept: so is the cache
    file = folder / "undertow" / "equation" / "structure.py"
    file.write_text(file.read_text() + ROW.replace("\\\\\\\\", "\\\\"))
    _run(folder, "-m", "undertow.equation.generate")
    return folder


def _run(folder: Path, *command: str) -> dict[str, str]:
    """Lines that a fresh interpreter prints with that copy of the package, by their first word."""
    environment = {**os.environ, "PYTHONPATH": str(folder), "PYTHONWARNINGS": "ignore"}
    done = subprocess.run(
        [sys.executable, *command], cwd=folder, env=environment, capture_output=True, text=True, timeout=600
    )
    assert done.returncode == 0, done.stderr
    return dict(line.split(maxsplit=1) for line in done.stdout.splitlines() if " " in line)


def test_a_new_row_is_simulated_fitted_suspected_named_and_reported(package):
    said = _run(package, "-c", USE)
    assert float(said["moves"]) > 0.01
    assert float(said["gap"]) < 1e-5  # central differences of a part in 5,000
    value, error = map(float, said["fitted"].split())
    assert abs(value - 500.0) < 3.0 * error < 100.0
    assert said["named"] == "closing_stop"
    assert "A stop that closes explains it" in said["said"]
    assert "x|x| (1 + v^2)" in said["text"]
    assert said["listed"] == "True"


def test_a_row_whose_expression_changes_changes_the_fit(package):
    before = _run(package, "-c", AGAIN)
    file = package / "undertow" / "equation" / "structure.py"
    file.write_text(file.read_text().replace("sp.Abs(q.x) * (1 + q.v**2)", "sp.Abs(q.x) / 2"))
    _run(package, "-m", "undertow.equation.generate")
    after = _run(package, "-c", AGAIN)
    value, error = map(float, after["fitted"].split())
    assert abs(value - 1000.0) < 3.0 * error  # half the law, twice the coefficient
    assert abs(float(before["fitted"].split()[0]) - value) > 3.0 * error
