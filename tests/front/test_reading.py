"""`undertow.read`: one decay as file, table, array or recording is the same trial; what is not said is refused."""

from __future__ import annotations

import re
from decimal import Decimal

import numpy as np
import pandas as pd
import pytest
import scipy.io

import undertow
from undertow.errors import ConfigError, RecordingError

LAW = {"stiffness": 400.0, "viscous_damping": 2.0}
MM = 1000.0


def recording(x0: float = 0.1, seed: int = 0, **settings):
    """A hold and a decay of 6 s at 100 Hz with 0.1 mm of noise."""
    run = undertow.simulate(LAW, x0=x0, mass_kg=4.0, rate_hz=100.0, duration_s=6.0)
    return run.recorded(noise_m=1e-4, seed=seed, **settings)


@pytest.fixture(scope="module")
def decay():
    return recording(name="r1")


def table_of(one, factor: float = MM) -> pd.DataFrame:
    return pd.DataFrame({"t": one.time, "x": factor * one.channels["displacement"]})


def written(folder, one, name: str = "r1.csv"):
    """The two columns as a German spreadsheet exports them: semicolons, decimal commas, millimetres."""
    path = folder / name
    table_of(one).to_csv(path, sep=";", decimal=",", index=False)
    return path


# ---------------------------------------------------------------- one decay in five shapes
def test_a_file_a_table_an_array_and_a_recording_are_the_same_trial(decay, tmp_path):
    mm = {"x": "mm"}
    x, t = MM * decay.channels["displacement"], decay.time
    read = {
        "path": undertow.read(written(tmp_path, decay), units=mm),
        "text": undertow.read(str(tmp_path / "r1.csv"), units=mm),
        "glob": undertow.read(str(tmp_path / "*.csv"), units=mm),
        "table": undertow.read(table_of(decay), units=mm, names=["r1"]),
        "array": undertow.read((x, t), units=mm, names=["r1"]),
        "X, t": undertow.read(x[:, None], t=t, units=mm, names=["r1"]),
        "step": undertow.read([x], units={"displacement": "mm"}, t=[0.01], names=["r1"]),
        "recording": undertow.read(decay),
    }
    for how, trials in read.items():
        assert trials.names == ("r1",), how
        assert trials[0].x == pytest.approx(read["recording"][0].x, abs=1e-6), how
        assert trials[0].amplitude == pytest.approx(0.1, rel=0.01), how


def test_trials_motions_and_recordings_of_trials_pass_as_they_are(decay):
    trials = undertow.read(decay)
    assert undertow.read(trials) is trials
    assert undertow.read(trials[0])[0] is trials[0]
    assert undertow.read(list(trials.recordings)).names == trials.names


def test_columns_of_an_array_are_displacement_and_velocity():
    run = undertow.simulate(LAW, x0=0.1, mass_kg=4.0, rate_hz=100.0, duration_s=6.0)
    trials = undertow.read(np.column_stack([run.x, run.v]), t=run.t, units={"x": "m", "v": "m/s"})
    assert set(trials[0].recording.channels) == {"displacement", "velocity"}
    three = np.column_stack([run.x, run.v, run.a])
    trials = undertow.read(three, t=run.t, units={"x": "m", "v": "m/s", "a": "m/s^2"})
    assert set(trials[0].recording.channels) == {"displacement", "velocity", "acceleration"}
    with pytest.raises(RecordingError, match=r"velocity \(column 'v'\) has no unit; say it, as in units=.*mm/s"):
        undertow.read(three, t=run.t, units={"x": "m", "a": "m/s^2"})


def test_a_sentence_of_read_names_its_arguments_and_no_keys_of_a_config():
    t = np.arange(0.0, 8.0, 0.01)
    for x in (0.1 * np.sin(7.0 * t), np.exp(t / 4.0) * np.cos(10.0 * t)):
        with pytest.raises(RecordingError, match=r"window=\(|accept=\[") as said:
            undertow.read(x + 1e-4 * np.random.default_rng(0).standard_normal(t.size), t=t, units={"x": "m"})
        assert not re.search(r"trials\.window|recordings\.(accept|exclude)", str(said.value))


def test_units_come_from_names_and_unit_rows_where_a_table_has_them(decay, tmp_path):
    named = table_of(decay).rename(columns={"x": "x [mm]", "t": "t [s]"})
    assert undertow.read(named)[0].amplitude == pytest.approx(0.1, rel=0.01)
    path = tmp_path / "row.csv"
    body = table_of(decay).to_csv(index=False).split("\n", 1)
    path.write_text(f"{body[0]}\ns,mm\n{body[1]}")
    assert undertow.read(path)[0].amplitude == pytest.approx(0.1, rel=0.01)


def test_columns_and_units_of_time_as_said_and_several_columns_are_summed(decay):
    x = decay.channels["displacement"]
    table = pd.DataFrame({"a": 1e3 * decay.time, "b": x, "lc1": 10.0 * x, "lc2": 30.0 * x})
    columns = {"time": "a", "displacement": "b", "spring_force": ["lc1", "lc2"]}
    units = {"a": "ms", "displacement": "m", "lc1": "kN", "lc2": "kN"}
    one = undertow.read(table, columns, units)[0].recording
    assert one.rate_hz == pytest.approx(100.0)
    assert one.channels["spring_force"] == pytest.approx(4e4 * x)


def test_a_rate_stands_for_a_column_of_time(decay):
    one = undertow.read(table_of(decay)[["x"]], {"displacement": "x"}, {"x": "mm"}, rate_hz=100.0)[0]
    assert one.recording.time == pytest.approx(decay.time)


def test_an_angle_is_a_rotation(decay):
    trials = undertow.read(table_of(decay, np.degrees(1.0)), units={"x": "deg"})
    assert trials.coordinate == "rotation"
    assert trials[0].amplitude == pytest.approx(0.1, rel=0.01)
    with pytest.raises(RecordingError, match="2 trials are in translation and in rotation; read them apart"):
        undertow.read([trials[0], undertow.read(decay)[0]])


# ---------------------------------------------------------------- names, conditions, windows
def test_conditions_are_of_all_trials_one_a_trial_or_by_name(decay):
    two = [decay, recording(0.05, 1, name="r2")]
    tables = [table_of(one) for one in two]
    said = {"units": {"x": "mm"}, "names": ["r1", "r2"]}
    for conditions, expected in (
        ({"spring": "long"}, ["long", "long"]),
        ([{"spring": "long"}, {"spring": "short"}], ["long", "short"]),
        ({"r1": {"spring": "long"}, "r2": {"spring": "short"}}, ["long", "short"]),
    ):
        trials = undertow.read(tables, conditions=conditions, **said)
        assert [m.recording.conditions["spring"] for m in trials] == expected
    with pytest.raises(RecordingError, match="conditions has 1 entries but there is a trial 2"):
        undertow.read(tables, conditions=[{"spring": "long"}], **said)
    with pytest.raises(RecordingError, match="conditions names r1 but no trial 'r2'; add it"):
        undertow.read(tables, conditions={"r1": {"spring": "long"}}, **said)
    with pytest.raises(RecordingError, match=r"names is \['r1'\], which names no trial 2"):
        undertow.read(tables, units={"x": "mm"}, names=["r1"])


def test_a_window_is_of_all_trials_or_of_one(decay):
    for window in ((None, 4.0), {"r1": (None, 4.0)}):
        cut = undertow.read(table_of(decay), units={"x": "mm"}, names=["r1"], window=window)[0]
        assert cut.window.end_s <= 4.0 < undertow.read(decay)[0].window.end_s


@pytest.mark.parametrize("window", [5, (1.0,), (0.0, 1.0, 2.0), ("a", "b"), "ab"])
def test_a_window_that_is_no_pair_of_instants_is_refused(decay, window):
    with pytest.raises(undertow.UndertowError, match=r"^window is .*; give \(start_s, end_s\) in s; None"):
        undertow.read(table_of(decay), units={"x": "mm"}, names=["r1"], window=window)


@pytest.mark.parametrize(("ask", "what"), [(undertow.load, "config"), (undertow.open, "folder")])
@pytest.mark.parametrize("path", [None, 5, ["runs"]])
def test_what_is_no_path_is_refused(ask, what, path):
    with pytest.raises(undertow.UndertowError, match=f"^{what} is .*of type {type(path).__name__}; give a path"):
        ask(path)


# ---------------------------------------------------------------- what people hold in memory
DAY = pd.Timestamp("2026-11-24 09:30:00")


def shapes_of(x, t):
    """One decay as people hold it whose time is no column of seconds."""
    dates = DAY + pd.to_timedelta(t, unit="s")
    table = pd.DataFrame({"x": x})
    return {
        "index of dates": table.set_index(dates),
        "index of dates with a name": table.set_index(dates.rename("time")),
        "index of durations": table.set_index(pd.to_timedelta(t, unit="s")),
        "index of seconds": table.set_index(pd.Index(t)),
        "index in ms that says so": table.set_index(pd.Index(1000.0 * t, name="t [ms]")),
        "index of whole ms that says so": table.set_index(pd.Index(np.round(1000.0 * t).astype(int), name="t [ms]")),
        "column of dates": table.assign(time=dates),
        "column of dates of a zone": table.assign(time=dates.tz_localize("Europe/Berlin")),
        "column of durations": table.assign(time=pd.to_timedelta(t, unit="s")),
        "series": pd.Series(x, index=t, name="x"),
        "series without a name": pd.Series(x, index=dates),
        "columns by name": {"t": t, "x": x},
        "lists by name": {"t": t.tolist(), "x": x.tolist()},
        "series by name": {"t": pd.Series(t), "x": pd.Series(x)},
        "array beside dates": (x, dates.to_numpy()),
        "array beside dates of a zone": (x, dates.tz_localize("Europe/Berlin")),
        "masked array that hides nothing": (np.ma.masked_invalid(x), t),
    }


@pytest.mark.parametrize("shape", shapes_of(np.zeros(1), np.zeros(1)))
def test_time_is_seconds_however_it_is_held(decay, shape):
    given = shapes_of(MM * decay.channels["displacement"], decay.time)[shape]
    trials = undertow.read(given, units={"x": "mm"}, names=["r1"])
    assert trials.names == ("r1",)
    assert trials[0].recording.rate_hz == pytest.approx(100.0, rel=1e-6)
    assert trials[0].x == pytest.approx(undertow.read(decay)[0].x, abs=1e-6)


# ---------------------------------------------------------------- files that hold several tables
def matlab(path, one, **more):
    """The decay in mm in a structure ``data`` of a MATLAB file, beside what else it holds."""
    data = {"t": one.time, "x_mm": MM * one.channels["displacement"]}
    scipy.io.savemat(path, {"data": data, "fs": 100.0, "operator": "hand", **more})
    return path


def test_a_structure_of_a_matlab_file_is_read_by_itself_and_by_name(decay, tmp_path):
    path = matlab(tmp_path / "r1.mat", decay)
    shapes = ({}, {"variable": "data"}, {"columns": {"time": "t", "displacement": "x_mm"}, "units": {"x_mm": "mm"}})
    for said in shapes:
        trials = undertow.read(path, **said)
        assert trials.names == ("r1",)
        assert trials[0].x == pytest.approx(undertow.read(decay)[0].x, abs=1e-6)
    with pytest.raises(RecordingError, match=r"units names 'data.x_mm', which is neither a column \('t', 'x_mm'\)"):
        undertow.read(path, units={"data.x_mm": "mm"})


def test_of_several_structures_or_sheets_one_is_said(decay, tmp_path):
    path = matlab(tmp_path / "r1.mat", decay, other={"a": np.zeros(5), "b": np.zeros(5)})
    with pytest.raises(RecordingError, match=r"holds the tables 'data', 'other'; say which, as in variable='data'"):
        undertow.read(path)
    with pytest.raises(RecordingError, match=r"has no variable 'date' \(no 'date' among data, fs, operator, other"):
        undertow.read(path, variable="date")
    with pd.ExcelWriter(tmp_path / "r2.xlsx") as book:
        pd.DataFrame({"who": ["me"]}).to_excel(book, sheet_name="About", index=False)
        table_of(decay).to_excel(book, sheet_name="Data", index=False)
    for one, variable in ((path, "data"), (tmp_path / "r2.xlsx", "Data")):
        units = {} if variable == "data" else {"x": "mm"}
        found = undertow.read(one, units=units, variable=variable)[0]
        assert found.x == pytest.approx(undertow.read(decay)[0].x, abs=1e-6)


def test_a_sheet_is_read_where_its_table_begins_as_init_reads_it(decay, tmp_path):
    """Two header rows, or a sheet of notes before the data, were no number and no data."""
    rows = table_of(decay)
    head = pd.DataFrame([["Channel 1", "Channel 2"], ["t [s]", "x [mm]"]], columns=rows.columns)
    pd.concat([head, rows.astype(object)]).to_excel(tmp_path / "r1.xlsx", index=False, header=False)
    with pd.ExcelWriter(tmp_path / "r2.xlsx") as book:
        pd.DataFrame({"who": ["me"]}).to_excel(book, sheet_name="About", index=False)
        rows.rename(columns={"x": "x [mm]"}).to_excel(book, sheet_name="Data", index=False)
    for name in ("r1.xlsx", "r2.xlsx"):
        assert undertow.read(tmp_path / name)[0].amplitude == pytest.approx(0.1, rel=0.01)
    with pd.ExcelWriter(tmp_path / "r3.xlsx") as book:
        pd.DataFrame({"who": ["me"]}).to_excel(book, sheet_name="About", index=False)
    with pytest.raises(RecordingError, match=r"r3.xlsx: no table of numbers begins in its first 2 lines"):
        undertow.read(tmp_path / "r3.xlsx")


def test_a_file_without_numbers_and_a_unit_that_is_none_are_said(decay, tmp_path):
    """The first ended in an IndexError, the second was called a column that is named like no channel."""
    scipy.io.savemat(tmp_path / "r1.mat", {"note": "nothing"})
    with pytest.raises(RecordingError, match=r"r1.mat: it holds no column of numbers; is it a recording\? name a"):
        undertow.read(tmp_path / "r1.mat")
    with pytest.raises(RecordingError, match=r"^displacement: unit 'foo' is not known.*column 'x \[foo\]'"):
        undertow.read(table_of(decay).rename(columns={"x": "x [foo]"}))


def test_a_variable_of_what_holds_one_table_is_refused(decay, tmp_path):
    path = written(tmp_path, decay)
    with pytest.raises(RecordingError, match=r"variable is 'data', but .*r1.csv is text with one table; leave"):
        undertow.read(path, units={"x": "mm"}, variable="data")
    with pytest.raises(RecordingError, match="variable is 'data', but trial 1 is no file; leave variable out"):
        undertow.read(table_of(decay), units={"x": "mm"}, variable="data")


# ---------------------------------------------------------------- samples that are missing
GAPS = {100: 1, 200: 3, 330: 2}
"""First missing sample -> how many."""


def gapped(one, gaps=GAPS):
    """The displacement in mm with gaps."""
    x = MM * one.channels["displacement"].copy()
    for first, many in gaps.items():
        x[first : first + many] = np.nan
    return x


def test_samples_that_are_missing_in_memory_are_left_out_as_those_of_a_file_are(decay, tmp_path):
    x, t = gapped(decay), decay.time
    table = pd.DataFrame({"t": t, "x": x})
    table.to_csv(tmp_path / "r1.csv", index=False)
    from_file = undertow.read(tmp_path / "r1.csv", units={"x": "mm"})[0].recording
    assert from_file.time.size == t.size - sum(GAPS.values())
    hidden = np.ma.array(np.nan_to_num(x, nan=1e4), mask=np.isnan(x))
    shapes = {
        "array": (x, t), "array with a step": (x, 0.01), "masked array": (hidden, t), "table": table,
        "nullable column": table.astype({"x": "Float64"}),
        "objects": table.astype({"x": object}).replace({np.nan: None}),
        "series": pd.Series(x, index=t, name="x"), "masked array by name": {"t": t, "x": hidden},
    }  # fmt: skip
    said = {"time": "t", "displacement": "x"}
    for how, shape in shapes.items():
        columns = said if how == "objects" else None
        one = undertow.read(shape, columns, units={"x": "mm"}, names=["r1"])[0].recording
        assert one.time == pytest.approx(from_file.time), how
        assert one.channels["displacement"] == pytest.approx(from_file.channels["displacement"]), how
        assert one.notes == from_file.notes, how


def test_a_table_that_lacks_a_fifth_of_its_displacement_fails_beside_those_that_do_not(decay):
    trials = undertow.read([(gapped(decay, {150: 200}), decay.time), table_of(decay)], units={"x": "mm"})
    assert trials.names == ("trial_2",)
    assert "trial trial_1: displacement lacks 200 of 650 values" in trials.failed[0].reason


def test_a_time_that_is_missing_is_refused_unless_its_row_is_blank(decay):
    table = table_of(decay)
    blank = table.copy()
    blank.loc[100, ["t", "x"]] = np.nan
    assert undertow.read(blank, units={"x": "mm"})[0].recording.time.size == decay.time.size - 1
    table.loc[100, "t"] = np.nan
    with pytest.raises(RecordingError, match="trial trial_1: time column 't' has 1 values that are not finite"):
        undertow.read(table, units={"x": "mm"})


def test_a_channel_with_gaps_beside_the_displacement_is_left_out_or_its_instants_are(decay):
    both = recording(acceleration_noise=0.01)
    table = table_of(both).assign(a=both.channels["acceleration"])
    units = {"x": "mm", "a": "m/s^2"}
    table.loc[100:109, "a"] = np.nan
    assert undertow.read(table, units=units)[0].recording.time.size == len(table) - 10
    table.loc[100:199, "a"] = np.nan
    one = undertow.read(table, units=units)[0].recording
    assert (one.time.size, list(one.channels)) == (len(table), ["displacement"])


def test_dates_in_a_text_file_are_seconds_too_and_their_unit_cannot_be_another(decay, tmp_path):
    dates = (DAY + pd.to_timedelta(decay.time, unit="s")).strftime("%d.%m.%Y %H:%M:%S.%f")
    pd.DataFrame({"Zeit": dates, "Weg [mm]": MM * decay.channels["displacement"]}).to_csv(
        tmp_path / "r1.csv", sep=";", decimal=",", index=False
    )
    assert undertow.read(tmp_path / "r1.csv")[0].x == pytest.approx(undertow.read(decay)[0].x, abs=1e-6)
    for kind in ("csv", "xlsx", "parquet"):
        path = tmp_path / f"r2.{kind}"
        table = pd.DataFrame({"t": pd.to_datetime(dates, format="%d.%m.%Y %H:%M:%S.%f"), "x": decay.time})
        {"csv": table.to_csv, "xlsx": table.to_excel, "parquet": table.to_parquet}[kind](path, index=False)
        for given in (path, table):
            with pytest.raises(RecordingError, match=r"column 't' holds dates or times .* said to be 'ms'; write s"):
                undertow.read(given, units={"x": "mm", "t": "ms"})


def test_a_clock_is_no_channel(decay, tmp_path):
    dates = DAY + pd.to_timedelta(decay.time, unit="s")
    table = table_of(decay).assign(clock=dates)
    table.to_csv(tmp_path / "r.csv", index=False)
    for given in (table, tmp_path / "r.csv"):
        with pytest.raises(RecordingError, match="displacement is said to be in column 'clock', which holds dates"):
            undertow.read(given, {"time": "t", "displacement": "clock"}, {"displacement": "mm"})


def test_a_unit_of_what_is_no_channel_is_not_called_a_channels(decay):
    with pytest.raises(RecordingError, match="none of the columns 't', 'temp' is named like a channel"):
        undertow.read(table_of(decay).rename(columns={"x": "temp"}), units={"temp": "degC"})


def test_a_time_without_a_unit_that_may_be_milliseconds_or_rows_is_asked_for(decay):
    table = table_of(decay)
    for t in (MM * decay.time, np.arange(len(table))):
        with pytest.raises(RecordingError, match=r"time \(column 't'\) has no unit, and in seconds there would"):
            undertow.read(table.assign(t=t), units={"x": "mm"})
    assert undertow.read(table.assign(t=MM * decay.time), units={"x": "mm", "t": "ms"})[0].recording.rate_hz > 99.0
    assert undertow.read(table.assign(t=MM * decay.time), units={"x": "mm", "time": "s"})[0].recording.rate_hz < 0.2
    assert undertow.read(table.assign(t=0.9 * decay.time / 0.01), units={"x": "mm"})[0].recording.rate_hz > 1.0


def test_tables_by_name_are_trials_of_these_names(decay):
    other = recording(0.2, seed=1)
    larger = pd.Series(MM * other.channels["displacement"], other.time, name="x")
    tables = {"small": table_of(decay), "large": larger}
    assert undertow.read(tables, units={"x": "mm"}).names == ("small", "large")
    assert undertow.read(tables, units={"x": "mm"}, names=["a", "b"]).names == ("a", "b")


def test_an_index_that_is_no_time_is_none(decay):
    table = table_of(decay)
    for index in (pd.Index(range(50, 50 + len(table))), pd.Index(range(len(table)), name="sample")):
        with pytest.raises(RecordingError, match="none of the columns 'x' looks like time"):
            undertow.read(table[["x"]].set_index(index), units={"x": "mm"})
    beside = undertow.read(table.set_index(pd.Index(2.0 * decay.time)), units={"x": "mm"}, names=["r1"])
    assert beside[0].recording.rate_hz == pytest.approx(100.0)


# ---------------------------------------------------------------- what cannot be used
def test_a_unit_that_nobody_says_is_refused(decay, tmp_path):
    with pytest.raises(RecordingError, match=r"displacement \(column 'x'\) has no unit; say it, as in units="):
        undertow.read(table_of(decay))
    path = written(tmp_path, decay)
    with pytest.raises(RecordingError, match=r"r1.csv: displacement \(column 'x'\) has no unit"):
        undertow.read(path)


def test_two_columns_without_names_are_time_and_displacement_as_init_takes_them(decay, tmp_path):
    path = tmp_path / "r1.txt"
    np.savetxt(path, table_of(decay), fmt="%.9g")
    scipy.io.savemat(tmp_path / "r1.mat", {"d": table_of(decay).to_numpy()})
    for source in (path, tmp_path / "r1.mat", pd.DataFrame(table_of(decay).to_numpy())):
        read = undertow.read(source, units={"displacement": "mm"})
        assert read[0].amplitude == pytest.approx(0.1, rel=0.01)
        with pytest.raises(RecordingError, match=r"displacement \(column 1\) has no unit; say it, as in units="):
            undertow.read(source)
    rows = pd.DataFrame(np.column_stack([np.arange(len(decay.time)), decay.channels["displacement"]]))
    with pytest.raises(RecordingError, match=r'column 0 counts rows and is no time; say rate_hz=.*"displ.*": 1'):
        undertow.read(rows, units={"displacement": "mm"})


def test_trials_one_below_another_are_refused_with_the_column_that_counts_them(decay, tmp_path):
    both = pd.concat([table_of(decay).assign(run=name) for name in "ab"])
    with pytest.raises(RecordingError, match=r"the table holds 2 trials one below another \(by column 'run'\): give"):
        undertow.read(both, units={"x": "mm"})
    both.drop(columns="run").to_csv(tmp_path / "all.csv", index=False)
    (tmp_path / "c.yaml").write_text(
        "{name: c, recordings: {files: all.csv, channels: {time: {column: t, unit: s}, "
        "displacement: {column: x, unit: mm}}}, equation: {terms: [stiffness]}}"
    )
    with pytest.raises(RecordingError, match=r"time begins again 1 times .*: the file holds 2 trials one below"):
        undertow.load(tmp_path / "c.yaml")


def test_columns_that_look_alike_are_refused_until_one_is_named(decay):
    small = table_of(decay).rename(columns={"x": "x1 [mm]"})
    table = small.assign(**{"x2 [mm]": 2.0 * small["x1 [mm]"]})
    with pytest.raises(RecordingError, match=r"columns 'x2 \[mm\]', 'x1 \[mm\]' all look like displacement; say which"):
        undertow.read(table)
    one = undertow.read(table, columns={"time": "t", "displacement": "x1 [mm]"})
    assert one[0].amplitude == pytest.approx(undertow.read(table_of(decay), units={"x": "mm"})[0].amplitude)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"units": {"y": "mm"}}, r"units names 'y', which is neither a column \('t', 'x'\) nor a quantity"),
        ({"columns": {"depth": "x"}}, "columns names the quantity 'depth'; it may be time, displacement"),
        ({"columns": {"time": "t", "displacement": "y"}}, "columns says that displacement is in 'y'; the table has"),
        ({"columns": {"time": "t"}}, "columns names no channel beside time"),
        ({"columns": {"displacement": "x"}}, "columns names displacement but no time"),
        ({"units": {"x": "mm"}, "accept": ["noise"]}, "accept names 'noise'; give a list of"),
        ({"accept": "gain"}, r"accept is the text 'gain'; give a list, as in accept=\['gain'\]"),
        ({"accept": ["gains"]}, "accept names 'gains'; give a list of"),
        ({"units": "mm"}, r"units is 'mm'; give a mapping, as in units=\{\"x\": \"mm\"\}"),
        ({"columns": "x"}, "columns is 'x'; give a mapping, as in columns="),
        ({"units": {"x": "milimeter"}}, "unit 'milimeter' is not known; the nearest known spelling is 'mm'"),
    ],
)
def test_what_is_said_of_a_table_and_is_not_there_is_refused(decay, settings, message):
    with pytest.raises(RecordingError, match=message):
        undertow.read(table_of(decay), **settings)


@pytest.mark.parametrize("held", ["texts", "objects", "decimals", "nullable"])
def test_numbers_are_read_however_a_table_holds_them(decay, held):
    table = table_of(decay).round(6)
    texts = table.astype(str)
    texts.loc[7, "x"] = None
    table.loc[7, "x"] = np.nan
    given = {
        "texts": texts, "objects": table.astype(object).where(table.notna(), None),
        "decimals": table.assign(x=[None if v is None else Decimal(v) for v in texts["x"]]),
        "nullable": table.convert_dtypes(),
    }[held]  # fmt: skip
    read = undertow.read(given, units={"x": "mm"})[0]
    assert np.array_equal(read.x, undertow.read(table, units={"x": "mm"})[0].x)


@pytest.mark.parametrize(
    ("cell", "said"),
    [("overload", "'overload' in row 7 from 0; write None or NaN where a value is missing"),
     ([1.0], r"\[1.0\] in row 7 from 0; write None or NaN"),
     ("0,5", "'0,5' in row 7 from 0; numbers have a decimal comma: read the file with decimal=','")],
)  # fmt: skip
def test_a_cell_that_is_no_number_is_said_with_its_column_value_and_row(decay, cell, said):
    table = table_of(decay).astype(object)
    table.at[7, "x"] = cell
    for columns in (None, {"time": "t", "displacement": "x"}):
        with pytest.raises(RecordingError, match=rf"^column 'x' holds what is no number, {said}"):
            undertow.read(table, columns=columns, units={"x": "mm"})
    table.index = table.index + 100
    with pytest.raises(RecordingError, match=r"in row 7 from 0 \(index 107\); "):
        undertow.read(table, units={"x": "mm"})


def test_a_column_of_words_beside_the_channels_is_passed_over(decay):
    table = table_of(decay).assign(position="left")
    assert undertow.read(table, units={"x": "mm"})[0].amplitude == pytest.approx(0.1, rel=0.01)


@pytest.mark.parametrize(
    ("change", "settings", "message"),
    [
        (lambda t: t.assign(x=t.x + 0j), {}, r"^column 'x' holds complex numbers; give real part"),
        (lambda t: t.set_axis(pd.MultiIndex.from_tuples([("t", "s"), ("x", "mm")]), axis=1), {},
         r"^the table has 2 rows of names, as \('x', 'mm'\); make one of them, as in table.columns = "),
        (lambda t: t.assign(y=t.x).set_axis(["t", "x", "x"], axis=1), {}, r"^the table has 2 columns 'x'; rename"),
        (lambda t: t, {"units": {"x": 3}}, r"^units says that 'x' is in 3; give the unit's name, as in \"mm\""),
        (lambda t: t, {"rate_hz": "50"}, r"^rate_hz is '50'; give samples in a second, as in rate_hz=100.0"),
        (lambda t: t, {"columns": {"time": None, "displacement": "x"}}, r"^columns says that time is in None; the tab"),
        (lambda t: t, {"names": [3]}, r"^names has 3 for trial 1; give a text, as in \"r1\""),
        (lambda t: t, {"conditions": 5}, r"^conditions is 5; give a mapping, as in "),
        (lambda t: t.assign(t=0.0), {}, r"its clock is coarser than its samples; give rate_hz=... in its place"),
    ],
)  # fmt: skip
def test_what_no_table_or_setting_can_be_is_refused_in_a_sentence(decay, change, settings, message):
    with pytest.raises(RecordingError, match=message):
        undertow.read(change(table_of(decay)), **{"units": {"x": "mm"}, **settings})


def test_a_table_without_a_channel_time_or_numbers_is_refused(decay):
    table = table_of(decay)
    with pytest.raises(RecordingError, match="none of the columns 'foo', 'bar' is named like a channel"):
        undertow.read(table.set_axis(["foo", "bar"], axis=1))
    with pytest.raises(RecordingError, match="none of the columns 'x' looks like time"):
        undertow.read(table[["x"]], units={"x": "mm"})
    with pytest.raises(RecordingError, match="is named like a channel and holds numbers"):
        undertow.read(table.assign(x="wet"), units={"x": "mm"})
    with pytest.raises(RecordingError, match="column 'x' holds what is no number"):
        undertow.read(table.assign(x="wet"), {"time": "t", "displacement": "x"}, {"x": "mm"})
    assert len(undertow.read(table.assign(remark="wet"), units={"x": "mm"})) == 1


@pytest.mark.parametrize(
    ("source", "t", "message"),
    [
        (np.zeros((2, 2, 2)), 0.1, r"X has the shape \(2, 2, 2\); give \(n,\) or \(n, k\)"),
        (np.zeros(5), 0.0, "t is 0 s; a time step must be positive"),
        (np.zeros(5), np.zeros(4), r"X has 5 rows but t has the shape \(4,\); give one instant a row"),
        ([np.zeros(5), np.zeros(5)], [0.1], "X holds 2 trials but t 1; give one time axis a trial"),
        (np.zeros(5), None, "source is of type ndarray; give paths, DataFrames, recordings, or X together with t"),
        (np.ones(5) * 1j, 0.1, "X holds complex numbers, and is real"),
        (np.ones(5), pd.DatetimeIndex([None] * 5), "holds dates or durations, and none of them is there"),
        (pd.to_timedelta(np.ones(5)), 0.1, "X holds dates or durations, and no numbers"),
        (["a", "b"], 0.1, "X holds what is no number"),
        ({"t": [0.0, 0.1], "x": [1.0]}, None, "the columns 't', 'x' make no table"),
        (np.ma.masked_greater(np.cos(np.arange(0.0, 60.0, 0.1)), 0.5), 0.01, "displacement lacks .* is too much"),
        ("no_such_*.csv", None, "the glob 'no_such_.*csv' fits no file; correct it"),
        ([], None, "source holds 0 trials"),
    ],
)
def test_a_source_that_holds_no_decay_is_refused(source, t, message):
    with pytest.raises(RecordingError, match=message):
        undertow.read(source, units={"x": "m"}, t=t)


def test_a_trial_that_cannot_be_used_is_listed_beside_those_that_can(decay):
    still = pd.DataFrame({"t": np.arange(500) / 100.0, "x": np.zeros(500)})
    trials = undertow.read([table_of(decay), still], units={"x": "mm"})
    assert trials.names == ("trial_1",)
    assert "trial_2" in trials.failed[0].reason
    assert f"not used: {trials.failed[0].reason}" in str(trials)
    with pytest.raises(RecordingError, match="trial_1"):
        undertow.read([still], units={"x": "mm"})


def test_channels_that_contradict_each_other_fail_their_trial_unless_accepted(decay):
    """A displacement in millimetres that is called metres: the accelerometer knows better."""
    both = recording(seed=1, name="wrong", acceleration_noise=0.01)
    table = table_of(both).assign(a=both.channels["acceleration"])
    units = {"x": "m", "a": "m/s^2"}
    trials = undertow.read([decay, *undertow.read([table], units=units, accept=["gain", "unit"]).recordings])
    assert trials.names == ("r1",)
    assert 'units={"acceleration": ...} or units={"displacement": ...}' in trials.failed[0].reason
    assert "list unit in accept=[...]" in trials.failed[0].reason
    with pytest.raises(RecordingError, match="accelerat"):
        undertow.read([table], units=units)


def test_a_config_without_a_trial_that_can_be_used_is_refused(tmp_path):
    (tmp_path / "still.csv").write_text("t,x\n" + "\n".join(f"{i / 100},0.0" for i in range(500)))
    config = tmp_path / "run.yaml"
    config.write_text(
        "name: none\nrecordings:\n  files: '*.csv'\n  channels:\n    time: {column: t, unit: s}\n"
        "    displacement: {column: x, unit: m}\n"
    )
    with pytest.raises((RecordingError, ConfigError), match="none of 1 trial can be used"):
        undertow.load(config)


# ---------------------------------------------------------------- the collection
@pytest.fixture(scope="module")
def several(decay):
    wet = [recording(x0, i, name=f"w{i}", conditions={"depth": 2.36}) for i, x0 in enumerate((0.05, 0.1))]
    return undertow.read([*wet, recording(0.08, 5, name="d", conditions={"depth": "dry"})])


def test_trials_are_chosen_by_place_name_slice_and_condition(several):
    assert several["w1"] is several[1]
    assert several[:2].names == several.where(depth=2.36).names == ("w0", "w1")
    assert (several[:1] + several[2:]).names == ("w0", "d")
    with pytest.raises(IndexError, match="trial 3 is asked for, but there are 3: 0 to 2"):
        several[3]
    assert several[np.int64(1)] is several[1] is several[np.int32(-2)]
    for which in (np.array([2, 0]), [2, 0], (np.int64(2), np.int64(0)), ["d", "w0"]):
        assert several[which].names == ("d", "w0")
        assert several[which].config is several.config
    assert several[np.array([True, False, True])].names == ("w0", "d")
    with pytest.raises(IndexError, match="trial 3 is asked for"):
        several[np.array([0, 3])]
    with pytest.raises(IndexError, match="2 truth values are given, but there are 3 trials"):
        several[np.array([True, False])]
    with pytest.raises(IndexError, match=r"places of trials have the shape \(1, 2\); give one list"):
        several[np.array([[0, 1]])]
    groups = several.groups("depth")
    assert [trials.names for trials in groups.values()] == [("w0", "w1"), ("d",)]
    with pytest.raises(RecordingError, match="no trial is called 'w7'; there are w0, w1, d"):
        several["w7"]
    with pytest.raises(RecordingError, match=r"none of 3 trials has depth 7.*there is depth: 2.36, dry"):
        several.where(depth=7.0)
    with pytest.raises(RecordingError, match="trial w0 has no condition 'spring'; it has depth"):
        several.groups("spring")


def test_trials_show_what_they_are(several):
    assert list(several.table.index) == ["w0", "w1", "d"]
    assert several.table["period_s"].to_numpy() == pytest.approx(2.0 * np.pi / 10.0, rel=0.01)
    assert "w0 (depth 2.36): released 0.05 m, period 0.62" in str(several)
    assert "<table" in several._repr_html_()
    assert len(several.plot().lines) == 3


def test_what_a_prompt_shows_of_a_result_is_its_text_and_no_archive(several):
    run = undertow.simulate(LAW, x0=0.1, mass_kg=4.0)
    assert repr(several) == str(several)
    assert repr(run) == str(run)
    assert repr(undertow.predict(run.equation, x0=0.1, times=run.t)).startswith("free run of 4 x''")


def test_a_table_as_the_motion_of_a_driven_body_is_refused():
    table = pd.DataFrame({"t": np.arange(300.0), "x": np.arange(300.0)})
    with pytest.raises(RecordingError, match="x is a table of 2 columns; give its displacement"):
        undertow.fit_driven(table, t=0.01, u=np.arange(300.0))


# ---------------------------------------------------------------- several releases on one clock
def session(sizes=(0.1, 0.08)) -> tuple[pd.DataFrame, float]:
    """Releases one after another, each with its hold, in mm; and where the second one's hold begins, s."""
    parts = [MM * recording(x0, seed).channels["displacement"] for seed, x0 in enumerate(sizes)]
    x = np.concatenate(parts)
    return pd.DataFrame({"t": 0.01 * np.arange(x.size), "x": x}), 0.01 * parts[0].size


def test_each_release_of_one_record_is_a_trial_where_its_part_is_said(tmp_path):
    table, second = session()
    parts, mm = [(None, second - 0.005), (second - 0.005, None)], {"x": "mm"}
    table.to_csv(tmp_path / "tank.csv", index=False)
    read = {
        "file": undertow.read(tmp_path / "tank.csv", units=mm, releases=parts),
        "by name": undertow.read(tmp_path / "tank.csv", units=mm, releases={"tank": parts}),
        "table": undertow.read(table, units=mm, names=["tank"], releases=parts),
    }
    for how, trials in read.items():
        assert trials.names == ("tank_1", "tank_2"), how
        assert [m.recording.conditions["release"] for m in trials] == [1.0, 2.0], how
        assert [m.amplitude for m in trials] == pytest.approx([0.1, 0.08], rel=0.01), how
    cut = undertow.read(table, units=mm, names=["tank"], releases=parts, window={"tank_2": (None, second + 3.0)})
    assert cut[0].window.end_s == read["table"][0].window.end_s
    assert cut[1].window.end_s <= second + 3.0 < read["table"][1].window.end_s


def test_what_python_says_of_several_releases_is_what_python_takes():
    table, _ = session((0.1, 0.08, 0.06))
    with pytest.raises(RecordingError, match=r"3 releases on one clock.* as a trial with releases=\[") as said:
        undertow.read(table, units={"x": "mm"})
    given = re.search(r"releases=(\[.*?\)\])", str(said.value))
    parts = [tuple(map(float, one.split(", "))) for one in re.findall(r"\((.*?)\)", given[1])]
    assert len(undertow.read(table, units={"x": "mm"}, releases=parts)) == 3


@pytest.mark.parametrize(
    ("releases", "said"),
    [
        ([], r"releases is \[\]; give \(start_s, end_s\) of each"),
        ([(1.0,)], r"releases is \[\(1.0,\)\]; give \(start_s, end_s\) of each"),
        ([5.0, 6.0], r"releases is \[5.0, 6.0\]; give"),
        ([(50.0, 60.0)], r"the window 50.0 to 60.0 s holds none of the samples.*correct releases=\["),
    ],
)
def test_parts_that_are_none_are_refused(releases, said):
    with pytest.raises(RecordingError, match=said):
        undertow.read(session()[0], units={"x": "mm"}, releases=releases)


def test_a_recording_that_was_read_is_not_parted(decay):
    with pytest.raises(RecordingError, match="releases is said of r1, which was read already"):
        undertow.read(decay, releases=[(0.0, 3.0), (3.0, 6.0)])
