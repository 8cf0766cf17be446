"""The driven comparison: scores, what the peers are given, the time limit, and its committed table."""

import importlib.util
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lsim

from benchmarks.beside_peers import __main__ as command
from benchmarks.beside_peers import driven_methods, driven_table
from benchmarks.beside_peers.driven_sets import FOLDER, NAMES, DrivenSet, load, score
from benchmarks.beside_peers.kept import write_rows

STEP = 0.02


@pytest.fixture(scope="module")
def swept():
    """x'' + x' + 50 x = u under a sweep, in the place of Bouc-Wen's set, without noise."""
    t = np.arange(4000) * STEP
    u = np.sin(2.0 * np.pi * (0.2 + 0.01 * t) * t)
    x = lsim(([1.0], [1.0, 1.0, 50.0]), u, t)[1]
    equation = ("stiffness", "viscous_damping")
    return DrivenSet("bouc_wen", STEP, np.asarray(x), u, equation, "first", 7, 1, 50, "m", 1.0)


def test_a_score_is_the_rms_beyond_the_samples_that_a_start_may_use(swept):
    seen = swept.unseen[0]
    away = seen + 0.1
    away[: swept.skip] = 1e6
    assert score(swept, away) == pytest.approx(0.1)
    assert score(replace(swept, factor=1e3), away) == pytest.approx(100.0)
    assert score(swept, (seen + 0.1)[::10], every=10) == pytest.approx(0.1)
    assert score(swept, np.full(seen.size, np.nan)) == math.inf
    assert score(swept, seen + 20.0 * np.ptp(swept.x)) == math.inf


@pytest.mark.parametrize(
    ("method", "share"),
    [
        ("undertow, the obvious equation", 1e-3),
        ("undertow, with what it lacks", 1e-3),
        ("pysindy, the equation's columns, smoothed, least squares", 0.15),
        ("pysindy, discrete time, cubic library, STLSQ 0.001", 0.15),
    ],
)
def test_a_linear_body_is_run_free_over_what_nobody_fitted(swept, method, share):
    _, error, note = driven_table.timed(driven_methods.METHODS[method], swept)
    assert note == ""
    assert error < share * float(np.std(swept.unseen[0]))


@pytest.mark.parametrize(
    ("package", "method"),
    [
        ("sysidentpy", "SysIdentPy, NARX, degree 1, 5 lags"),
        ("jax_sysid", "jax-sysid, linear state space"),
        ("jax_sysid", "jax-sysid, state space with a net"),
    ],
)
def test_a_peer_that_is_installed_follows_a_linear_body_and_one_that_is_not_says_so(
    swept, package, method, monkeypatch
):
    monkeypatch.setattr(driven_methods, "JAX_EPOCHS", (300, 300))
    spent, error, note = driven_table.timed(driven_methods.METHODS[method], swept)
    if importlib.util.find_spec(package) is None:
        assert note == f"not run: {package} is not installed"
        assert math.isnan(spent)
    else:
        assert error < 0.2 * float(np.std(swept.unseen[0]))


def test_the_free_run_of_a_found_equation_is_the_motion_of_that_equation():
    right = driven_methods._right_side(("x", "v", "u"), np.array([[0.0, 1.0, 0.0], [-50.0, -1.0, 1.0]]), "x,v,u")
    t = np.arange(500) * 0.05
    u = np.sin(1.3 * t)
    run = driven_methods._runge_kutta(right, (0.1, 0.0), u, 0.05)
    fine = np.arange(499 * 50 + 1) * 0.001
    truth = lsim(([1.0], [1.0, 1.0, 50.0]), np.sin(1.3 * fine), fine)[1][::50]
    w = math.sqrt(49.75)
    free = 0.1 * np.exp(-0.5 * t) * (np.cos(w * t) + 0.5 / w * np.sin(w * t))
    # the spline's ends and RK4 at 0.04 rad a step
    assert np.max(np.abs(run - truth - free)) < 1e-4


def test_thinned_data_keep_every_so_many_outputs_and_the_mean_force_between_them(swept):
    thin = replace(swept, decimate=3)
    x, u = driven_methods._thin(thin)
    seen, force = swept.training
    assert x == pytest.approx(((seen - seen.mean()) / seen.std())[::3])
    assert u[4] == pytest.approx(np.mean(((force - force.mean()) / force.std())[12:15]))
    assert x.size == u.size == math.ceil(seen.size / 3)


def test_columns_of_a_cubic_library_are_all_products_of_up_to_three():
    columns = driven_methods._cubic(("x", "v", "u"))
    assert len(columns) == 20
    assert {"1.0", "x*v*u", "u*u*u", "v"} <= set(columns)


def test_a_fit_that_takes_its_limit_is_ended_and_says_so(swept):
    def forever(_data):
        while True:
            pass

    spent, error, note = driven_table.timed(forever, swept, 0.05)
    assert math.isnan(spent)
    assert math.isnan(error)
    assert note == "ended after 0.05 s"


def test_rows_come_back_as_they_were_written_and_the_command_writes_both_files(swept, tmp_path, monkeypatch):
    quick = {name: driven_methods.METHODS[name] for name in list(driven_methods.METHODS)[:1]}
    monkeypatch.setattr(driven_table, "METHODS", quick)
    monkeypatch.setattr(driven_table, "load", lambda name: swept)
    assert command.main(["driven", "--sets", "bouc_wen", "--rounds", "2", "--out", str(tmp_path)]) == 0
    rows = driven_table.read_rows(tmp_path / "driven.csv")
    assert [(row.method, row.fits, row.ratio) for row in rows] == [(driven_table.OURS, 2, 1.0)]
    write_rows(rows, driven_table.HEADER, tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_text() == (tmp_path / "driven.csv").read_text()
    assert (tmp_path / "driven.md").read_text().startswith("| method | bouc_wen, m | s | ratio |")


def test_the_table_on_the_page_is_that_of_the_committed_rows():
    rows = driven_table.read_rows(command.FOLDER / "driven.csv")
    page = (command.DOCS / "driven_measured.md").read_text(encoding="utf-8")
    assert driven_table.tabulate(rows) in page
    assert {row.method for row in rows} == set(driven_methods.METHODS)
    assert {row.name for row in rows} == set(NAMES)


@pytest.mark.skipif(not Path(FOLDER).is_dir(), reason="../shared/driven is not there")
def test_four_fifths_are_fitted_and_the_rest_is_unseen():
    data = load("emps")
    assert data.x.size == data.u.size == 24841
    assert data.training[0].size == 19872
    assert data.training[0].size + data.unseen[0].size == data.x.size
