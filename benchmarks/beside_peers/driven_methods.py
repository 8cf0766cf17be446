"""The methods of the driven comparison, each as its users run it, on standardised data where it has no units.

A method fits the training part and gives what runs free over the unseen one; the fit alone is timed. pysindy's users
give x, v by differences and ``u=``; SysIdentPy's a NARX polynomial in lagged outputs and inputs; jax-sysid's a state
space, linear, then with a small net beside it.

Belongs here: one method each. Does not belong here: data and score (driven_sets.py), rounds (driven_table.py).
"""

from __future__ import annotations

import importlib
import itertools
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
import pysindy
from scipy.interpolate import CubicSpline

import undertow
from benchmarks.beside_peers.driven_sets import START, Array, DrivenSet
from undertow.conditioning.driven import DrivenTrial
from undertow.front.driving import Driven

Run = Callable[[], tuple[Array, int]]
"""Free run over the unseen part, and every how many samples of it."""
Method = Callable[[DrivenSet], Run]

SUBSTEPS = 8
"""Steps of RK4 a sample in pysindy's free runs: 0.09 rad of Silverbox's resonance each."""
NARX_TERMS = 30
"""Terms among which the criterion (BIC) of FROLS chooses the number."""
JAX_STATES = 3
JAX_NEURONS = 8
JAX_SAMPLES = 20_000
"""Samples, the last ones of the training part, that the state space is trained on."""
JAX_EPOCHS = (500, 2000)
"""Epochs of Adam and of L-BFGS, of the linear model and again with the net."""


# ---------------------------------------------------------------- undertow
def _given(data: DrivenSet) -> dict[str, Any]:
    return {"t": data.step, "u": data.training[1], "hold": data.hold}


def _runs(data: DrivenSet, found: Driven) -> Run:
    x, u = data.unseen
    return lambda: (found.predict(x, t=data.step, u=u, start=START).values, 1)


def undertow_numbers(data: DrivenSet) -> Run:
    """The obvious equation's numbers."""
    return _runs(data, undertow.fit_driven(data.training[0], equation=data.equation, **_given(data)))


def undertow_discover(data: DrivenSet) -> Run:
    """The obvious equation and what the search adds to it, chosen on the training part alone."""
    x = data.training[0]
    found = undertow.Discover(known=data.equation).fit(x, **_given(data)).driven_
    trial = DrivenTrial("x", np.arange(x.size) * data.step, data.training[1], {"displacement": x}, "force", data.hold)
    return _runs(data, Driven(found.augmented or found.baseline, (trial,)))


# ---------------------------------------------------------------- pysindy
def _cubic(names: tuple[str, ...]) -> tuple[str, ...]:
    """All products of up to three of the names, with 1, as Python writes them."""
    lines = ("*".join(p) for n in (1, 2, 3) for p in itertools.combinations_with_replacement(names, n))
    return ("1.0", *lines)


PHYSICAL = {
    "emps": ("1.0", "v", "u", "np.sign(v)"),
    "silverbox": ("1.0", "x", "v", "u", "x*x", "x*x*x"),
    "bouc_wen": ("1.0", "x", "v", "u"),
}
"""Columns of the obvious equation."""


def _library(columns: tuple[str, ...], names: str) -> Any:
    """A pysindy library of these expressions in three arguments."""
    code = [eval(f"lambda {names}: {text} + 0.0*({names.split(',')[0]})", {"np": np}) for text in columns]  # noqa: S307
    return pysindy.CustomLibrary(code, function_names=[lambda *a, text=text: text for text in columns])


def _right_side(columns: tuple[str, ...], coefficients: Array, names: str) -> Callable[..., tuple[float, ...]]:
    """The found equations as one function of three numbers."""
    rows = (
        "+".join(f"({c!r})*{text}" for c, text in zip(map(float, row), columns, strict=True) if c != 0.0) or "0.0"
        for row in coefficients
    )
    return eval(f"lambda {names}: ({', '.join(rows)},)", {"np": np})  # type: ignore[no-any-return] # noqa: S307


def _own_columns(data: DrivenSet) -> tuple[str, ...]:
    return PHYSICAL[data.name]


def _all_cubic(_data: DrivenSet) -> tuple[str, ...]:
    return _cubic(("x", "v", "u"))


def _continuous(columns: Callable[[DrivenSet], tuple[str, ...]], threshold: float, way: str) -> Method:
    """pysindy on x, v and u in units of their deviation, time in units of x over v."""

    def differences(data: DrivenSet) -> Any:
        kws = {"window_length": data.smoothing, "polyorder": 3}
        if way == "smoothed":
            return pysindy.SmoothedFiniteDifference(smoother_kws=kws)
        return pysindy.SpectralDerivative() if way == "spectral" else pysindy.FiniteDifference()

    def fit(data: DrivenSet) -> Run:
        x, u = data.training
        times = np.arange(x.size) * data.step
        v = np.asarray(differences(data)(x[:, None], times))[:, 0]
        middle, size, speed, push = float(x.mean()), float(x.std()), float(v.std()), float(u.std())
        beat = speed / size
        optimizer = pysindy.STLSQ(threshold=threshold, alpha=0.05 if threshold else 0.0)
        terms = columns(data)
        model = pysindy.SINDy(optimizer, _library(terms, "x,v,u"), differences(data))
        states = np.column_stack([(x - middle) / size, v / speed])
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            model.fit(states, t=times * beat, u=(u / push)[:, None])
        right = _right_side(terms, model.coefficients(), "x,v,u")

        def run() -> tuple[Array, int]:
            seen, force = data.unseen
            first = seen[: data.skip]
            slope = np.asarray(differences(data)(first[:, None], times[: data.skip]))[:, 0]
            at = data.skip // 2
            begin = ((first[at] - middle) / size, slope[at] / speed)
            moved = _runge_kutta(right, begin, force[at:] / push, data.step * beat) * size + middle
            return np.concatenate([first[:at], moved]), 1

        return run

    return fit


def _runge_kutta(right: Callable[..., tuple[float, ...]], begin: tuple[float, float], u: Array, h: float) -> Array:
    """First state (n,) from ``begin`` by RK4 in `SUBSTEPS` a sample, the input a cubic spline between them; nan once
    out of bounds."""
    out = np.full(u.size, np.nan)
    x, v = begin
    force = CubicSpline(np.arange(u.size), u)(np.arange(2 * SUBSTEPS * (u.size - 1) + 1) / (2 * SUBSTEPS)).tolist()
    h /= SUBSTEPS
    for i in range(SUBSTEPS * (u.size - 1) + 1):
        if i % SUBSTEPS == 0:
            out[i // SUBSTEPS] = x
        if 2 * i + 2 >= len(force) or not abs(x) + abs(v) < 1e3:
            break
        first, half, last = force[2 * i : 2 * i + 3]
        a = right(x, v, first)
        b = right(x + 0.5 * h * a[0], v + 0.5 * h * a[1], half)
        c = right(x + 0.5 * h * b[0], v + 0.5 * h * b[1], half)
        d = right(x + h * c[0], v + h * c[1], last)
        x += h / 6.0 * (a[0] + 2.0 * b[0] + 2.0 * c[0] + d[0])
        v += h / 6.0 * (a[1] + 2.0 * b[1] + 2.0 * c[1] + d[1])
    return out


def pysindy_discrete(data: DrivenSet) -> Run:
    """pysindy in discrete time: states x and x one sample before, cubic library, threshold 0.001."""
    (x, u), names = _thin(data), "x,y,u"
    terms = _cubic(("x", "y", "u"))
    model = pysindy.DiscreteSINDy(optimizer=pysindy.STLSQ(threshold=1e-3), feature_library=_library(terms, names))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        model.fit(np.column_stack([x[1:], x[:-1]]), t=1, u=u[1:, None])
    right = _right_side(terms, model.coefficients(), names)

    def run() -> tuple[Array, int]:
        seen, force = _thin(data, unseen=True)
        at = data.skip // data.decimate
        one, before = float(seen[at]), float(seen[at - 1])
        out = seen.copy()
        for i in range(at, seen.size):
            out[i] = one
            if not abs(one) < 1e3:
                out[i:] = np.nan
                break
            one, before = right(one, before, force[i])
        return _back(data, out), data.decimate

    return run


# ---------------------------------------------------------------- standardised and thinned
def _thin(data: DrivenSet, unseen: bool = False) -> tuple[Array, Array]:
    """x and u in the training part's deviations about its means; thinned, every so many samples of x, and the mean of u
    from one of them to the next."""
    pair = data.unseen if unseen else data.training
    x, u = ((one - seen.mean()) / seen.std() for one, seen in zip(pair, data.training, strict=True))
    if data.decimate == 1:
        return x, u
    every = data.decimate
    count = -(-u.size // every)
    padded = np.append(u, np.full(count * every - u.size, u[-1]))
    return x[::every], padded.reshape(count, every).mean(axis=1)


def _back(data: DrivenSet, run: Array) -> Array:
    x = data.training[0]
    return run * x.std() + x.mean()


def _narx(degree: int, lags: int) -> Method:
    """SysIdentPy: NARX polynomial by FROLS, least squares, as many terms as BIC asks for."""

    def fit(data: DrivenSet) -> Run:
        basis = importlib.import_module("sysidentpy.basis_function")
        estimator = importlib.import_module("sysidentpy.parameter_estimation").LeastSquares()
        model = importlib.import_module("sysidentpy.model_structure_selection").FROLS(
            order_selection=True, n_info_values=NARX_TERMS, info_criteria="bic", ylag=lags, xlag=lags,
            estimator=estimator, basis_function=basis.Polynomial(degree=degree),
        )  # fmt: skip
        x, u = _thin(data)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            model.fit(X=u[:, None], y=x[:, None])

        def run() -> tuple[Array, int]:
            seen, force = _thin(data, unseen=True)
            with warnings.catch_warnings(), np.errstate(all="ignore"):
                warnings.simplefilter("ignore")
                got = np.ravel(model.predict(X=force[:, None], y=seen[:, None]))
            return _back(data, got), data.decimate

        return run

    return fit


def _state_space(net: bool) -> Method:
    """jax-sysid: a linear state space; with ``net`` trained on with tanh neurons beside A and B."""

    def fit(data: DrivenSet) -> Run:
        models = importlib.import_module("jax_sysid.models")
        numpy = importlib.import_module("jax.numpy")
        x, u = (one[-JAX_SAMPLES:, None] for one in _thin(data))
        model = models.LinearModel(JAX_STATES, 1, 1)
        model.init(sigma=0.9)
        _train(model, x, u)
        if net:
            a, b, c = (np.asarray(part) for part in model.params)
            rng = np.random.default_rng(0)
            inner = 0.1 * rng.standard_normal((JAX_NEURONS, JAX_STATES + 1))
            start = [a, b, c, np.zeros((JAX_STATES, JAX_NEURONS)), inner, np.zeros(JAX_NEURONS)]

            def ahead(x: Any, u: Any, params: Any) -> Any:
                a, b, _, outer, inner, bias = params
                return a @ x + b @ u + outer @ numpy.tanh(inner @ numpy.concatenate([x, u]) + bias)

            model = models.Model(JAX_STATES, 1, 1, state_fcn=ahead, output_fcn=lambda x, u, params: params[2] @ x)
            model.init(params=start)
            _train(model, x, u)

        def run() -> tuple[Array, int]:
            seen, force = _thin(data, unseen=True)
            few = data.skip // data.decimate
            begin = model.learn_x0(force[:few, None], seen[:few, None], LBFGS_refinement=True, verbosity=False)
            return _back(data, np.ravel(model.predict(begin, force[:, None])[0])), data.decimate

        return run

    return fit


def _train(model: Any, x: Array, u: Array) -> None:
    model.loss(rho_x0=1e-3, rho_th=1e-6)
    model.optimization(adam_eta=0.002, adam_epochs=JAX_EPOCHS[0], lbfgs_epochs=JAX_EPOCHS[1], iprint=-1)
    model.fit(x, u)


METHODS: dict[str, Method] = {
    "undertow, the obvious equation": undertow_numbers,
    "undertow, with what it lacks": undertow_discover,
    "pysindy, the equation's columns, smoothed, least squares": _continuous(_own_columns, 0.0, "smoothed"),
    "pysindy, the equation's columns, spectral, least squares": _continuous(_own_columns, 0.0, "spectral"),
    "pysindy, cubic library, smoothed, STLSQ 0.01": _continuous(_all_cubic, 0.01, "smoothed"),
    "pysindy, cubic library, spectral, STLSQ 0.01": _continuous(_all_cubic, 0.01, "spectral"),
    "pysindy, cubic library, finite differences, STLSQ 0.1": _continuous(_all_cubic, 0.1, "finite"),
    "pysindy, discrete time, cubic library, STLSQ 0.001": pysindy_discrete,
    "SysIdentPy, NARX, degree 1, 5 lags": _narx(1, 5),
    "SysIdentPy, NARX, degree 2, 5 lags": _narx(2, 5),
    "SysIdentPy, NARX, degree 3, 2 lags": _narx(3, 2),
    "jax-sysid, linear state space": _state_space(False),
    "jax-sysid, state space with a net": _state_space(True),
}
