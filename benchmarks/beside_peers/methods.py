"""The methods of the comparison, each as its users run it, and each on the same data.

pysindy's users differentiate the displacement twice (finite or smoothed differences) or use the weak form; the
library is the ten terms of the recovery study. What pysindy does with our conditioned signals tells how much of the
difference is conditioning and how much is selection.

Belongs here: one function a method. Does not belong here: data and scores (data.py).
"""

from __future__ import annotations

import importlib
import os
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pysindy
from numpy.typing import NDArray

import undertow
from benchmarks.beside_peers.data import LARGEST_SCORE, Data, Trial, score, simulate
from experiments.recovery.sindy_recovery import TEN_TERMS
from undertow.comparison.discover import Discovery
from undertow.equation.hidden import HiddenResonator
from undertow.equation.kernel import SLOT
from undertow.likelihood.output_error import trajectory
from undertow.methods.sindy import discover

Array = NDArray[np.float64]

COLUMNS = ("x", "v", "sgn(v)", "v|v|", "x^2", "x^3", "x|x|", "v^3", "xv", "x^2v")
"""The ten terms; the first four are Eq. 15's."""

OURS = dict(
    zip(
        (
            "stiffness", "viscous_damping", "coulomb_friction", "quadratic_drag", "asymmetric_stiffness",
            "cubic_stiffness", "quadratic_stiffness", "cubic_damping", "position_damping", "van_der_pol_damping",
        ),
        COLUMNS,
        strict=True,
    )
)  # fmt: skip
SMOOTHING = {"window_length": 51, "polyorder": 3}
"""Savitzky-Golay window of the smoothed differences: 51 ms at 1 kHz, a tenth of a period."""

SCALED_THRESHOLD = 0.01
"""Threshold of STLSQ on scaled columns, in standard deviations of the acceleration."""

WEAK_FUNCTIONS = 200
SYSIDENTPY_FOLDER = "SYSIDENTPY_FOLDER"
"""Environment variable with the folder SysIdentPy was installed into, apart from our own environment."""

NAR_RATE_HZ = 50.0
NAR_LAGS = 6
NAR_TERMS = 15


@dataclass(frozen=True)
class Found:
    """One method's answer: coefficients by column of the equation for -x'' (empty where it has none), the free run's
    error on the held-out trial, and a note."""

    coefficients: dict[str, float]
    held_out: float
    note: str = ""


def columns(x: Array, v: Array) -> Array:
    """The ten columns (n, 10)."""
    size, speed = np.abs(x), np.abs(v)
    parts = (x, v, np.sign(v), v * speed, x * x, x**3, x * size, v**3, x * v, x * x * v)
    return np.column_stack(parts)


def _library() -> pysindy.CustomLibrary:
    """The ten terms as a pysindy library of two arguments."""
    functions = [
        lambda x, v: x, lambda x, v: v, lambda x, v: np.sign(v), lambda x, v: v * np.abs(v), lambda x, v: x * x,
        lambda x, v: x**3, lambda x, v: x * np.abs(x), lambda x, v: v**3, lambda x, v: x * v, lambda x, v: x * x * v,
    ]  # fmt: skip
    names = [lambda x, v, name=name: name for name in COLUMNS]
    return pysindy.CustomLibrary(functions, function_names=names)


def _scored(data: Data, values: Array, note: str = "") -> Found:
    """A found equation -x'' = columns @ values, run on the held-out trial."""
    kept = {name: float(value) for name, value in zip(COLUMNS, values, strict=True) if value != 0.0}
    a = -np.asarray(values, dtype=float)

    def acceleration(x: float, v: float) -> float:
        size, speed = abs(x), abs(v)
        restoring = x * (a[0] + a[4] * x + a[5] * x * x + a[6] * size)
        damping = v * (a[1] + a[3] * speed + a[7] * v * v + a[8] * x + a[9] * x * x)
        return float(restoring + damping + a[2] * np.sign(v))

    trial = data.held_out
    with np.errstate(over="ignore", invalid="ignore"):
        run = simulate(acceleration, trial.x0, trial.run_times)
    return Found(kept, score(trial, run), note)


def _pysindy(data: Data, optimizer: object, differences: Callable[[], object]) -> Found:
    """pysindy on states (x, v), v differenced from the raw displacement, x' differenced again by pysindy."""
    model = pysindy.SINDy(feature_library=_library(), optimizer=optimizer, differentiation_method=differences())
    speeds = [np.asarray(differences()(trial.x[:, None], trial.t)) for trial in data.training]
    states = [np.column_stack([trial.x, v]) for trial, v in zip(data.training, speeds, strict=True)]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model.fit(states, t=[trial.t for trial in data.training])
    return _scored(data, -model.coefficients()[1])


def finite_stlsq(data: Data) -> Found:
    """Defaults: finite differences, STLSQ with threshold 0.1."""
    return _pysindy(data, pysindy.STLSQ(), pysindy.FiniteDifference)


def _smoothed() -> object:
    return pysindy.SmoothedFiniteDifference(smoother_kws=SMOOTHING)


def smoothed_stlsq(data: Data) -> Found:
    """Smoothed differences, STLSQ with threshold 0.1."""
    return _pysindy(data, pysindy.STLSQ(), _smoothed)


def smoothed_sr3(data: Data) -> Found:
    """Smoothed differences, SR3 with its defaults."""
    return _pysindy(data, pysindy.SR3(), _smoothed)


def smoothed_ensemble(data: Data) -> Found:
    """Smoothed differences, 20 bags of STLSQ, median coefficients."""
    np.random.seed(data.seed)  # noqa: NPY002 - pysindy draws from numpy's global state
    bags = pysindy.EnsembleOptimizer(pysindy.STLSQ(), bagging=True, n_models=20)
    return _pysindy(data, bags, _smoothed)


def weak_form(data: Data) -> Found:
    """Weak form on x and smoothed v; trials one after the other, since it takes one grid: the largest alone."""
    trial = max(data.training, key=lambda one: float(np.max(np.abs(one.x))))
    v = np.asarray(_smoothed()(trial.x[:, None], trial.t))  # type: ignore[operator]
    np.random.seed(data.seed)  # noqa: NPY002 - as above
    library = pysindy.WeakPDELibrary(_library(), spatiotemporal_grid=trial.t, K=WEAK_FUNCTIONS)
    model = pysindy.SINDy(feature_library=library, optimizer=pysindy.STLSQ())
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model.fit(np.column_stack([trial.x, v]), t=trial.t)
    return _scored(data, -model.coefficients()[1], "largest trial alone")


def conditioned_stlsq(data: Data) -> Found:
    """STLSQ with its defaults on our smoothed x, v, a inside the motion window."""
    return _conditioned(data, pysindy.STLSQ(), scaled=False)


def conditioned_scaled(data: Data) -> Found:
    """STLSQ on our signals, columns scaled to unit deviation, threshold 1 % of the acceleration's."""
    return _conditioned(data, pysindy.STLSQ(threshold=SCALED_THRESHOLD, alpha=0.0), scaled=True)


def _conditioned(data: Data, optimizer: pysindy.STLSQ, scaled: bool) -> Found:
    rows, response = [], []
    for trial in data.training:
        motion = trial.motion
        rows.append(columns(motion.windowed("x") - motion.equilibrium.value, motion.windowed("v")))
        response.append(-motion.windowed("a"))
    matrix, target = np.vstack(rows), np.concatenate(response)
    scale = np.std(matrix, axis=0) if scaled else np.ones(matrix.shape[1])
    size = float(np.std(target)) if scaled else 1.0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        optimizer.fit(matrix / scale, target[:, None] / size)
    return _scored(data, optimizer.coef_[0] * size / scale)


def sysidentpy_nar(data: Data) -> Found:
    """SysIdentPy: NAR polynomial of degree 3 by FROLS on the largest trial at 50 Hz, free run on the held-out one."""
    folder = os.environ.get(SYSIDENTPY_FOLDER, "")
    if folder and folder not in sys.path:
        sys.path.append(folder)
    basis = importlib.import_module("sysidentpy.basis_function")
    selection = importlib.import_module("sysidentpy.model_structure_selection")
    model = selection.FROLS(
        model_type="NAR",
        basis_function=basis.Polynomial(degree=3),
        ylag=NAR_LAGS,
        order_selection=True,
        n_info_values=NAR_TERMS,
    )
    largest = max(data.training, key=lambda one: float(np.max(np.abs(one.x))))
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        model.fit(X=None, y=_thinned(largest))
        seen = _thinned(data.held_out)
        run = model.predict(X=None, y=seen, forecast_horizon=seen.size)
    return Found({}, _nar_score(seen[:, 0], np.ravel(run)), "no physical terms")


def _thinned(trial: Trial) -> Array:
    """Displacement averaged to `NAR_RATE_HZ`, (n, 1)."""
    cell = round(1.0 / NAR_RATE_HZ / float(np.median(np.diff(trial.t))))
    count = trial.x.size // cell
    means: Array = trial.x[: count * cell].reshape(count, cell).mean(axis=1)[:, None]
    return means


def _nar_score(seen: Array, run: Array) -> float:
    size = min(seen.size, run.size)
    left = seen[-size:] - run[-size:]
    error = float(np.sqrt(np.mean(left**2) / np.mean(seen**2))) if np.all(np.isfinite(left)) else np.inf
    return min(error, LARGEST_SCORE)


def undertow_sindy(data: Data) -> Found:
    """Our regression with selection among the ten terms."""
    result = discover([trial.motion for trial in data.training], TEN_TERMS)
    found = dict(zip((OURS[name] for name in result.names), result.coefficients, strict=True))
    return _scored(data, np.array([found.get(name, 0.0) for name in COLUMNS]))


def undertow_discover(data: Data) -> Found:
    """Our choice among the ten terms on simulated trajectories, with nothing known."""
    one = Discovery(resamples=0, outside=False, second_route=False).fit([trial.motion for trial in data.training])
    found = {OURS[term.name]: value for term, value in zip(one.terms_, one.coefficients_, strict=True)}
    return _scored(data, np.array([found.get(name, 0.0) for name in COLUMNS]))


def undertow_search(data: Data) -> Found:
    """Eq. 15 and the search for what it leaves out; known is only what every method assumes: trials repeat."""
    motions = [trial.motion for trial in data.training]
    group = undertow.diagnose(motions, hold_out=[], scatter={"k": 0.0, "c": 0.0, "mu": 0.0})[0]
    equation = group.repaired
    pairs = zip(equation.terms, equation.coefficients, strict=True)
    found = {OURS.get(term.name, term.name): value / equation.mass_kg for term, value in pairs if term.kind == "force"}
    theta = equation.theta()
    theta[SLOT["x0"]] = data.held_out.x0
    x, v, _ = trajectory(theta, np.zeros(0, dtype=np.int64), data.held_out.run_times)
    hidden = [term.inner["natural_frequency_rad_per_s"] for term in equation.terms if isinstance(term, HiddenResonator)]
    note = f"{len(hidden)} hidden" + "".join(f"{', ' if i else ': '}{w:.3f} rad/s" for i, w in enumerate(hidden))
    return Found(found, score(data.held_out, np.column_stack([x[:, 0], v[:, 0]])), note)


METHODS: dict[str, Callable[[Data], Found]] = {
    "pysindy, finite differences, STLSQ": finite_stlsq,
    "pysindy, smoothed differences, STLSQ": smoothed_stlsq,
    "pysindy, smoothed differences, SR3": smoothed_sr3,
    "pysindy, smoothed differences, ensemble": smoothed_ensemble,
    "pysindy, weak form": weak_form,
    "pysindy on our signals, STLSQ": conditioned_stlsq,
    "pysindy on our signals, scaled STLSQ": conditioned_scaled,
    "SysIdentPy, NAR by FROLS": sysidentpy_nar,
    "undertow, regression with selection": undertow_sindy,
    "undertow, Discover": undertow_discover,
    "undertow, Eq. 15 and what it leaves out": undertow_search,
}
