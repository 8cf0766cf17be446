"""The comparison with peers: its scores, a slice of it, and its committed page."""

import math

import numpy as np
import pytest

from benchmarks.beside_peers import __main__ as command
from benchmarks.beside_peers import methods, table
from benchmarks.beside_peers.data import LARGEST_SCORE, equation_15, score, simulate
from benchmarks.beside_peers.kept import write_rows

NAMES = ("x", "v", "sgn(v)", "v|v|")


@pytest.fixture(scope="module")
def data():
    return equation_15("N3", 0)


def test_the_held_out_release_is_not_among_the_training_ones(data):
    assert len(data.training) == 3
    assert data.held_out.motion.name not in {trial.motion.name for trial in data.training}
    assert tuple(data.truth) == NAMES


def test_the_truth_scores_what_the_sensor_alone_leaves_and_a_wrong_stiffness_does_not(data):
    k, c, friction, drag = data.truth.values()
    trial = data.held_out

    def acceleration(share):
        return lambda x, v: -(share * k * x + c * v + friction * np.sign(v) + drag * v * abs(v))

    start, times = trial.x0, trial.run_times
    noise = trial.motion.noise["displacement"] / float(np.sqrt(np.mean(trial.x**2)))
    assert score(trial, simulate(acceleration(1.0), start, times)) == pytest.approx(noise, rel=0.2)
    assert score(trial, simulate(acceleration(1.05), start, times)) > 0.3
    with np.errstate(over="ignore", invalid="ignore"):
        away = simulate(lambda x, v: 1e3 * x, start, times)
    assert score(trial, away) == LARGEST_SCORE


def test_every_coefficient_of_the_ten_columns_is_run_as_it_was_found(data):
    rng = np.random.default_rng(2)
    x, v = rng.uniform(-1.0, 1.0, 5), rng.uniform(-1.0, 1.0, 5)
    by_hand = [x, v, np.sign(v), v * abs(v), x**2, x**3, x * abs(x), v**3, x * v, x**2 * v]
    assert np.allclose(methods.columns(x, v), np.column_stack(by_hand))
    values = np.zeros(10)
    values[:4] = list(data.truth.values())
    found = methods._scored(data, values)
    assert found.coefficients == pytest.approx(data.truth)
    assert found.held_out < 0.04


def test_peers_and_ours_are_judged_alike_on_one_set_of_recordings(data):
    ours = table.judge(data, "ours", methods.undertow_sindy(data))
    peer = table.judge(data, "peer", methods.smoothed_stlsq(data))
    assert (ours.true_terms, ours.false_terms) == (4, 0)
    assert max(ours.percent) < 10.0
    # pysindy's default threshold takes friction away whatever the data say
    assert peer.percent[2] == 100.0
    assert ours.held_out < peer.held_out


def test_a_method_that_is_not_installed_gets_a_row_that_says_so(data):
    def absent(_):
        raise ModuleNotFoundError("no", name="sysidentpy")

    row = table._one(data, "SysIdentPy, NAR by FROLS", absent)
    assert row.note == "not run: sysidentpy is not installed"
    assert math.isnan(row.held_out)


def test_rows_come_back_as_they_were_written_and_the_command_writes_both_files(tmp_path, monkeypatch):
    quick = {name: methods.METHODS[name] for name in ("pysindy, weak form", "undertow, regression with selection")}
    monkeypatch.setattr(table, "METHODS", quick)
    assert command.main(["--seeds", "1", "--noises", "N1", "--out", str(tmp_path)]) == 0
    rows = table.read_rows(tmp_path / "results.csv")
    assert [row.method for row in rows] == [*quick, *quick]
    write_rows(rows, table.HEADER, tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_text() == (tmp_path / "results.csv").read_text()
    page = (tmp_path / "peers.md").read_text()
    assert page.count("| N1 | undertow, regression with selection |") == 2


def test_the_page_is_that_of_the_committed_rows(tmp_path):
    rows = table.read_rows(command.FOLDER / "results.csv")
    table.write_page(rows, tmp_path / "peers.md")
    assert (command.DOCS / "peers.md").read_text() == (tmp_path / "peers.md").read_text()
    assert {row.method for row in rows} == set(methods.METHODS)
    assert {row.truth for row in rows} == set(table.TRUTHS)
