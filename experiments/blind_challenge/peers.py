"""Peers on the same cases, as their users would run them, scored on the free run of trials that they never saw.

Method 1 fits m_a and Cd of Eq. 15 to trajectories with k, c and mu from the dry trials; pysindy has a polynomial and
sign library on [x, v], or delay coordinates; static discrepancy regression and a Gaussian process learn the force that
Eq. 15 leaves as a function of (x, v); SysIdentPy fits a polynomial NAR model where it is installed. All work on x over
the largest release and t times the frequency, with derivatives by a Savitzky-Golay filter. For all alike the release,
the time and the rest position of a held-out trial may move by one linear step before the error is taken.
"""

import importlib.util
import json
import math
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import savgol_filter

from experiments.blind_challenge.peer_data import Group, Record, laboratory
from experiments.blind_challenge.truths.motion import Body, simulate

PEERS = ("eq15_method1", "pysindy_xv", "pysindy_delay", "static_discrepancy", "gaussian_process", "sysidentpy")
WORST = 10.0  # an error that is larger, or a run that diverges, counts as this
THRESHOLD = 0.01  # of STLSQ on scaled columns
POINTS = 300  # of a Gaussian process
DELAYS = 6  # coordinates, a twentieth of a period apart
Force = Callable[[float, float], float]


class Scale:
    """Largest release (m) and frequency (rad/s) of a group, and its trials in those units."""

    def __init__(self, group: Group) -> None:
        self.length = max(abs(r.hold) for r in group.training)
        longest = max(group.training, key=lambda r: r.x.size)
        crossings = np.flatnonzero(np.diff(np.sign(savgol_filter(longest.x, 11, 3))))
        if crossings.size < 3:
            raise ValueError(
                f"group {group.name}: {crossings.size} zero crossings in its longest trial, "
                "a frequency needs 3; leave it out"
            )
        crossings = crossings[: max(3, min(9, crossings.size))]
        self.frequency = math.pi / float(np.median(np.diff(longest.time[crossings])))

    def record(self, r: Record) -> tuple[np.ndarray, np.ndarray, float]:
        """Time, displacement and release, scaled."""
        return r.time * self.frequency, r.x / self.length, r.hold / self.length


def derivatives(t: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x, v, a by a Savitzky-Golay filter over a sixth of a period."""
    step = float(t[1] - t[0])
    width = max(7, int(2.0 * math.pi / 6.0 / step) | 1)
    return tuple(savgol_filter(x, width, 4, deriv=d, delta=step) for d in (0, 1, 2))  # type: ignore[return-value]


def aligned_error(x: np.ndarray, run: np.ndarray) -> float:
    """RMS error over RMS displacement after one linear step in release, time and rest position."""
    if not np.all(np.isfinite(run)) or np.max(np.abs(run)) > 20.0 * np.max(np.abs(x)):
        return WORST
    columns = np.column_stack([run, np.gradient(run), np.ones_like(run)])
    step = np.linalg.lstsq(columns, x - run, rcond=None)[0]
    error = x - run - columns @ step
    return min(WORST, float(np.sqrt(np.mean(error**2) / np.mean(x**2))))


def free_run(t: np.ndarray, x0: float, acceleration: Force) -> np.ndarray:
    """Runge-Kutta 4 at the samples; not a number from where it runs away."""
    out = np.full(t.size, np.nan)
    x, v = x0, 0.0
    h = float(t[1] - t[0])
    for i in range(t.size):
        out[i] = x
        if abs(x) > 50.0 or abs(v) > 50.0:
            break
        a1 = acceleration(x, v)
        a2 = acceleration(x + 0.5 * h * v, v + 0.5 * h * a1)
        a3 = acceleration(x + 0.5 * h * (v + 0.5 * h * a1), v + 0.5 * h * a2)
        a4 = acceleration(x + h * (v + 0.5 * h * a2), v + h * a3)
        x += h * v + h * h / 6.0 * (a1 + a2 + a3)
        v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
    return out


def _eq15_run(p: np.ndarray, t: np.ndarray, x0: float) -> np.ndarray:
    """Eq. 15 per unit mass: p = (k, c, F_c, q), exact stick and slip."""
    body = Body(1.0, max(p[1], 0.0), max(p[0], 1e-3), max(p[2], 0.0), p[3])
    return simulate(body, (), x0, t.size, float(t[1] - t[0])).x


def _eq15_fit(start: np.ndarray, free: list[int], data: list[tuple[np.ndarray, np.ndarray, float]]) -> np.ndarray:
    """Least squares of the free numbers on trajectories."""

    def residual(values: np.ndarray) -> np.ndarray:
        p = start.copy()
        p[free] = values
        out = []
        for t, x, x0 in data:
            run = _eq15_run(p, t, x0)
            columns = np.column_stack([np.gradient(run), np.ones_like(run)])
            error = x - run
            out.append(error - columns @ np.linalg.lstsq(columns, error, rcond=None)[0])
        return np.concatenate(out)

    least = np.array([1e-3, 0.0, 0.0, -np.inf])[free]
    fit = least_squares(residual, start[free], x_scale="jac", diff_step=1e-4, max_nfev=40, bounds=(least, np.inf))
    p = start.copy()
    p[free] = fit.x
    return p


def method1(group: Group, dry: Group | None, scale: Scale) -> np.ndarray:
    """Eq. 15 by Method 1: dry means of k, c, mu, then M and q of the wet trials; without dry trials all four."""
    data = [scale.record(r) for r in group.training]
    start = np.array([1.0, 0.01, 0.005, 0.05])
    if dry is None or group.dry:
        return _eq15_fit(start, [0, 1, 2, 3] if not group.dry else [0, 1, 2], data)
    singles = [
        _eq15_fit(np.array([1.5, 0.01, 0.005, 0.0]), [0, 1, 2], [scale.record(r)]) for r in dry.training + dry.held_out
    ]
    mean = np.mean(singles, axis=0)

    def wet(mass: float, drag: float) -> np.ndarray:
        return np.array([*(mean[:3] / mass), drag / mass])

    def residual(values: np.ndarray) -> np.ndarray:
        return np.concatenate([x - _eq15_run(wet(*values), t, x0) for t, x, x0 in data])

    fit = least_squares(residual, [mean[0], 0.05], diff_step=1e-4, max_nfev=25, bounds=([0.2, -5.0], [20.0, 20.0]))
    return wet(*fit.x)


def _library(x: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Polynomials to the third power in x and v, sign(v) and v|v|."""
    powers = [x**i * v**j for i in range(4) for j in range(4 - i)]
    return np.column_stack([*powers, np.sign(v), v * np.abs(v)])


def _sparse(columns: np.ndarray, target: np.ndarray) -> np.ndarray:
    """pysindy's STLSQ on columns scaled by their deviation."""
    import pysindy

    size = np.maximum(np.sqrt(np.mean(columns**2, axis=0)), 1e-12)
    spread = float(np.sqrt(np.mean(target**2))) or 1.0
    optimizer = pysindy.STLSQ(threshold=THRESHOLD, alpha=1e-6)
    optimizer.fit(columns / size, (target / spread)[:, None])
    return np.asarray(optimizer.coef_).ravel() * spread / size


def _stacked(group: Group, scale: Scale) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x, v, a of all training trials, their ends left out."""
    parts = []
    for r in group.training:
        t, x, _ = scale.record(r)
        lines = derivatives(t, x)
        edge = max(7, int(math.pi / 6.0 / (t[1] - t[0])))
        parts.append(np.column_stack(lines)[edge:-edge])
    return tuple(np.concatenate(parts).T)  # type: ignore[return-value]


def _poly_force(weights: np.ndarray) -> Force:
    exponents = [(i, j) for i in range(4) for j in range(4 - i)]

    def force(x: float, v: float) -> float:
        total = sum(w * x**i * v**j for w, (i, j) in zip(weights, exponents, strict=False) if w != 0.0)
        return float(total + weights[-2] * np.sign(v) + weights[-1] * v * abs(v))

    return force


def pysindy_xv(group: Group, dry: Group | None, scale: Scale) -> Force:
    """Sparse regression of a on the library of (x, v)."""
    x, v, a = _stacked(group, scale)
    return _poly_force(_sparse(_library(x, v), a))


def _eq15_force(p: np.ndarray) -> Force:
    return lambda x, v: float(-p[0] * x - p[1] * v - p[2] * np.sign(v) - p[3] * v * abs(v))


def static_discrepancy(group: Group, dry: Group | None, scale: Scale) -> Force:
    """Eq. 15 by Method 1 plus a sparse regression of what it leaves (Kaheman et al. 2019, Ebers et al. 2023)."""
    base = _eq15_force(method1(group, dry, scale))
    x, v, a = _stacked(group, scale)
    left = a - np.array([base(*pair) for pair in zip(x, v, strict=True)])
    more = _poly_force(_sparse(_library(x, v), left))
    return lambda x, v: base(x, v) + more(x, v)


def gaussian_process(group: Group, dry: Group | None, scale: Scale) -> Force:
    """Eq. 15 by Method 1 plus a Gaussian process of what it leaves in (x, v)."""
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

    base = _eq15_force(method1(group, dry, scale))
    x, v, a = _stacked(group, scale)
    left = a - np.array([base(*pair) for pair in zip(x, v, strict=True)])
    chosen = np.random.default_rng(0).permutation(x.size)[:POINTS]
    size = float(np.std(left)) or 1.0
    kernel = ConstantKernel(1.0) * RBF([0.5, 0.5], (0.05, 20.0)) + WhiteKernel(0.1, (1e-6, 10.0))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model = GaussianProcessRegressor(kernel).fit(np.column_stack([x, v])[chosen], left[chosen] / size)
    grid = np.linspace(-1.3, 1.3, 53)
    table = size * model.predict(np.array([(p, q) for p in grid for q in grid])).reshape(53, 53)

    def force(x: float, v: float) -> float:
        i, j = np.clip((np.array([x, v]) + 1.3) / 0.05, 0.0, 51.999)
        a, b = int(i), int(j)
        p, q = i - a, j - b
        near = table[a : a + 2, b : b + 2]
        more = (1 - p) * ((1 - q) * near[0, 0] + q * near[0, 1]) + p * ((1 - q) * near[1, 0] + q * near[1, 1])
        return base(x, v) + float(more)

    return force


def _coarse(t: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Displacement a twentieth of a period apart."""
    return np.interp(np.arange(t[0], t[-1], 2.0 * math.pi / 20.0), t, x)


def delay_errors(group: Group, scale: Scale) -> list[float]:
    """pysindy on delay coordinates: the next sample from the last DELAYS, linear and their squares, run free."""
    rows, targets = [], []

    def features(past: np.ndarray) -> np.ndarray:
        return np.concatenate([past, past**2, past**3])

    for r in group.training:
        x = _coarse(*scale.record(r)[:2])
        for i in range(DELAYS, x.size):
            rows.append(features(x[i - DELAYS : i]))
            targets.append(x[i])
    weights = _sparse(np.array(rows), np.array(targets))
    errors = []
    for r in group.held_out:
        x = _coarse(*scale.record(r)[:2])
        run = x.copy()
        for i in range(DELAYS, x.size):
            run[i] = np.clip(features(run[i - DELAYS : i]) @ weights, -100.0, 100.0)
        errors.append(aligned_error(x[DELAYS:], run[DELAYS:]))
    return errors


def sysidentpy_errors(group: Group, scale: Scale) -> list[float] | None:
    """SysIdentPy's FROLS with a polynomial NAR model on the longest training trial, run free; None where it is not
    installed.
    """
    if importlib.util.find_spec("sysidentpy") is None:
        return None
    from sysidentpy.basis_function import Polynomial
    from sysidentpy.model_structure_selection import FROLS

    longest = max(group.training, key=lambda r: r.x.size)
    y = _coarse(*scale.record(longest)[:2])[:, None]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model = FROLS(
            order_selection=True, n_info_values=12, ylag=DELAYS, model_type="NAR", basis_function=Polynomial(degree=2)
        )
        model.fit(y=y)
        errors = []
        for r in group.held_out:
            x = _coarse(*scale.record(r)[:2])[:, None]
            run = model.predict(y=x, steps_ahead=None, forecast_horizon=x.shape[0])
            errors.append(aligned_error(x[DELAYS:, 0], np.asarray(run)[DELAYS : x.shape[0], 0]))
    return errors


def _errors(group: Group, dry: Group | None, scale: Scale, name: str) -> list[float] | None:
    if name == "pysindy_delay":
        return delay_errors(group, scale)
    if name == "sysidentpy":
        return sysidentpy_errors(group, scale)
    data = [scale.record(r) for r in group.held_out]
    if name == "eq15_method1":
        p = method1(group, dry, scale)
        return [aligned_error(x, _eq15_run(p, t, x0)) for t, x, x0 in data]
    force = {"pysindy_xv": pysindy_xv, "static_discrepancy": static_discrepancy, "gaussian_process": gaussian_process}[
        name
    ]
    law = force(group, dry, scale)
    return [aligned_error(x, free_run(t, x0, law)) for t, x, x0 in data]


def peer_rows(folder: Path) -> list[dict[str, object]]:
    """One row a wet group with held-out trials: RMS of the held-out errors of every peer; what a peer cannot do is
    said.
    """
    _, groups = laboratory(folder)
    out = []
    for group in groups:
        if group.dry or not group.held_out:
            continue
        dry = next(
            (g for g in groups if g.dry and all(g.name[k] == v for k, v in group.name.items() if k != "water_depth_m")),
            None,
        )
        row: dict[str, object] = {
            "case": folder.name,
            "group": group.name,
            "held_out": [r.file for r in group.held_out],
        }
        for name in PEERS:
            try:
                errors = _errors(group, dry, Scale(group), name)
            except (ValueError, np.linalg.LinAlgError, IndexError, ZeroDivisionError) as problem:
                row[name] = f"{type(problem).__name__}: {problem}"[:200]
                continue
            row[name] = "not installed" if errors is None else float(np.sqrt(np.mean(np.square(errors))))
        out.append(row)
    return out


def run_peers(laboratories: Path, rows: Path, only: list[str] | None = None) -> int:
    """Rows of all laboratories that have none yet; how many were made."""
    done = (
        {json.loads(line)["case"] for line in rows.read_text(encoding="utf-8").splitlines()} if rows.exists() else set()
    )
    count = 0
    with rows.open("a", encoding="utf-8") as stream:
        for folder in sorted(p for p in laboratories.iterdir() if p.is_dir()):
            if folder.name in done or (only is not None and folder.name not in only):
                continue
            for row in peer_rows(folder):
                stream.write(json.dumps(row) + "\n")
                count += 1
            stream.flush()
    return count
