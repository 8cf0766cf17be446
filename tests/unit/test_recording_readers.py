"""Files as laboratories write them, right and wrong, through small files on disk."""

from __future__ import annotations

import gzip
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import scipy.io

from undertow.errors import RecordingError
from undertow.recording.layout import CellLayout, FileFormat
from undertow.recording.readers import READERS, count_trials, read_table, suffix_of, trial_name

PLAIN = "time,x,comment\n0.0,1.5,start\n0.1,-2.5e-3,\n0.2,3,end\n"


def write(path: Path, text: str | bytes) -> Path:
    data = text.encode() if isinstance(text, str) else text
    path.write_bytes(gzip.compress(data) if path.suffix == ".gz" else data)
    return path


@pytest.mark.parametrize("name", ["r.csv", "r.txt", "r.csv.gz", "R.CSV"])
def test_plain_and_zipped_text_read_alike(tmp_path: Path, name: str) -> None:
    table = read_table(write(tmp_path / name, PLAIN), columns=["x", "time"])
    assert table["x"].tolist() == [1.5, -0.0025, 3.0]
    assert table["time"].tolist() == [0.0, 0.1, 0.2]


@pytest.mark.parametrize(
    ("text", "layout"),
    [
        ("a;b\n1,5;2\n3,0;4\n", FileFormat(decimal=",")),
        ("a\tb\n1.5\t2\n3.0\t4\n", FileFormat()),
        ("a   b\n1.5   2\n3.0 4\n", FileFormat()),
        ("a|b\r\n1.5|2\r\n3.0|4\r\n", FileFormat()),
        ('"a", "b"\n1.5, 2\n3.0, 4\n', FileFormat()),
        ("# a, b\n1.5,2\n3.0,4\n", FileFormat()),
        ("\ufeffa,b\n1.5,2\n3.0,4\n", FileFormat()),
        ("Rig 3, of May\nmore words\na,b\nm,s\n1.5,2\n3.0,4\n", FileFormat(skip_rows=2, unit_row=True)),
        ("a,b\n\n1.5,2\n\n3.0,4\n\n\n", FileFormat()),
    ],
)
def test_separators_headers_and_decimal_commas_give_one_table(tmp_path: Path, text: str, layout: FileFormat) -> None:
    table = read_table(write(tmp_path / "r.csv", text), layout, ["a", "b"])
    assert table["a"].tolist() == [1.5, 3.0]
    assert table["b"].tolist() == [2.0, 4.0]


def test_without_a_header_columns_are_numbers(tmp_path: Path) -> None:
    table = read_table(
        write(tmp_path / "r.txt", "90, 1000\n1.5,2\n3.0,4\n"), FileFormat(header=False, skip_rows=1), [1]
    )
    assert table[1].tolist() == [2.0, 4.0]


def test_one_column_alone_is_a_table(tmp_path: Path) -> None:
    assert read_table(write(tmp_path / "r.txt", "-90.36\n-90.64\n"), FileFormat(header=False))[0].tolist() == [
        -90.36,
        -90.64,
    ]


def test_a_unit_row_is_kept(tmp_path: Path) -> None:
    table = read_table(write(tmp_path / "r.csv", "t,x\ns,mm\n0,1\n1,2\n"), FileFormat(unit_row=True))
    assert table.attrs["units"] == {"t": "s", "x": "mm"}


@pytest.mark.parametrize("encoding", ["utf-16", "latin-1"])
def test_spreadsheet_encodings_are_read(tmp_path: Path, encoding: str) -> None:
    path = write(tmp_path / "r.csv", "Winkel [°];t\n1;0\n2;1\n".encode(encoding))
    assert read_table(path, columns=["Winkel [°]"])["Winkel [°]"].tolist() == [1.0, 2.0]


def test_text_in_a_number_column_is_named_with_its_line(tmp_path: Path) -> None:
    path = write(tmp_path / "r.csv", "made by a logger\ntime,x\n0,1\n\n1,overload\n2,3\n")
    with pytest.raises(RecordingError, match=r"r\.csv: column 'x', line 5: 'overload' is not a number"):
        read_table(path, FileFormat(skip_rows=1), ["x"])


def test_a_decimal_comma_is_suspected_where_it_is_one(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"line 2: '1,5' is not a number; set decimal: ','"):
        read_table(write(tmp_path / "r.csv", "a;b\n1,5;2\n3,0;4\n"))


def test_truth_values_are_no_numbers(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"'True' is not a number"):
        read_table(write(tmp_path / "r.csv", "a,b\nTrue,1\nFalse,2\n"), columns=["a"])


def test_an_unmapped_column_may_hold_anything(tmp_path: Path) -> None:
    assert list(read_table(write(tmp_path / "r.csv", PLAIN), columns=["x"]).columns) == ["x"]


@pytest.mark.parametrize(
    ("name", "data", "said"),
    [
        ("r.csv", b"", "is empty"),
        ("r.csv", b" \n\n", "is empty"),
        ("r.csv", b"time,x\n", "no data"),
        ("r.csv", bytes(range(256)) * 20, "is not text"),
        ("r.csv", b"0.0,1.0\n0.1,2.0\n0.2,3.0\n", "header line holds numbers.*header: none"),
        ("r.csv", b"t,x\n0,1\n1,2,3,4\n", "is no table"),
        ("r.mat", b"not a MATLAB file, but long enough to be looked at" * 10, "no readable MATLAB file"),
        ("r.pkl", b"x", "can carry code"),
        ("r.npy", b"x", "can carry code"),
        ("r.xyz", b"x", "no reader for '.xyz'"),
        ("r", b"x", "no reader for 'a name without suffix'"),
    ],
)
def test_a_file_that_is_no_recording_says_what_it_is(tmp_path: Path, name: str, data: bytes, said: str) -> None:
    with pytest.raises(RecordingError, match=said):
        read_table(write(tmp_path / name, data))


def test_a_truncated_gzip_is_not_a_short_recording(tmp_path: Path) -> None:
    whole = gzip.compress(b"t,x\n" + b"".join(b"%d,%d\n" % (i, i * i) for i in range(5000)))
    (tmp_path / "r.csv.gz").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(RecordingError, match=r"not a whole gzip file"):
        read_table(tmp_path / "r.csv.gz")


def test_a_missing_file_and_a_folder_are_told_apart(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"is not there"):
        read_table(tmp_path / "r.csv")
    with pytest.raises(RecordingError, match=r"is a folder; check the path: give one .* undertow init"):
        read_table(tmp_path)


def test_a_missing_column_is_answered_with_the_nearest(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"no column 'tme'; it has time, x, comment; did you mean 'time'\?"):
        read_table(write(tmp_path / "r.csv", PLAIN), columns=["tme"])


def test_a_column_name_that_stands_twice_is_not_guessed(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"2 columns named 'x'"):
        read_table(write(tmp_path / "r.csv", "t,x,x\n0,1,2\n1,3,4\n"), columns=["x"])


def test_matlab_matrices_structures_and_vectors_are_tables(tmp_path: Path) -> None:
    t, x = np.arange(4.0), np.arange(4.0) ** 2
    scipy.io.savemat(tmp_path / "r.mat", {"run": {"t": t, "x": x, "by": "me"}, "m": np.column_stack([t, x])})
    assert read_table(tmp_path / "r.mat", FileFormat(variable="m"), [1])[1].tolist() == x.tolist()
    assert read_table(tmp_path / "r.mat", FileFormat(variable="run"), ["x"])["x"].tolist() == x.tolist()
    with pytest.raises(RecordingError, match=r"no variable 'run.y'"):
        read_table(tmp_path / "r.mat", FileFormat(variable="run.y"))
    with pytest.raises(RecordingError, match=r"not numbers"):
        read_table(tmp_path / "r.mat", FileFormat(variable="run.by"))
    scipy.io.savemat(tmp_path / "v.mat", {"t": t, "x": x, "short": np.arange(3.0)})
    assert read_table(tmp_path / "v.mat", columns=["t", "x"])["x"].tolist() == x.tolist()
    with pytest.raises(RecordingError, match=r"differ in length"):
        read_table(tmp_path / "v.mat", columns=["t", "short"])


def cell_file(path: Path, trials: list[tuple[list[float], list[float]]]) -> Path:
    cells = np.empty((len(trials), 2), dtype=object)
    for at, (t, x) in enumerate(trials):
        cells[at, 0], cells[at, 1] = np.array(t), np.array(x)
    scipy.io.savemat(path, {"data": cells})
    return path


def test_cells_hold_one_trial_a_row(tmp_path: Path) -> None:
    path = cell_file(
        tmp_path / "c.mat", [([0.0, 1.0, 2.0], [1.0, 0.0, -1.0]), ([0.0, 1.0, 2.0, 3.0], [4.0, 3.0, 2.0, 1.0])]
    )
    layout = FileFormat(cells=CellLayout("data", "row", {"time": 0, "displacement": 1}))
    assert count_trials(path, layout) == 2
    assert read_table(path, layout, [1], trial=1)[1].tolist() == [4.0, 3.0, 2.0, 1.0]
    with pytest.raises(RecordingError, match=r"has 2 trials; there is none with number 2"):
        read_table(path, layout, trial=2)
    with pytest.raises(RecordingError, match=r"has 2 cells; there is none with number 5"):
        read_table(path, layout, [5], trial=0)


def test_a_matrix_is_no_cell_array_of_trials(tmp_path: Path) -> None:
    scipy.io.savemat(tmp_path / "m.mat", {"data": np.eye(3)})
    with pytest.raises(RecordingError, match=r"no cell array of trials"):
        count_trials(tmp_path / "m.mat", FileFormat(cells=CellLayout("data")))


def test_suffixes_lead_to_readers_and_leave_the_name() -> None:
    assert suffix_of(Path("a.b.TXT.gz")) in READERS
    assert trial_name(Path("disc_14.9_0.2_3.csv")) == "disc_14.9_0.2_3"


def test_a_file_of_one_endless_line_is_no_table(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"is no row of a table"):
        read_table(write(tmp_path / "r.csv", "x" * 200_000 + "\n1\n2\n"))


def test_numbers_too_long_for_an_integer_are_numbers(tmp_path: Path) -> None:
    table = read_table(
        write(tmp_path / "r.csv", "a,b\n18446744073709551615,1\n99999999999999999999999999,2\n"), columns=["a"]
    )
    assert table["a"].tolist() == [18446744073709551615.0, 1e26]


@pytest.mark.parametrize("value", [np.zeros((2, 3, 4)), np.array([1.0 + 1.0j, 2.0])])
def test_an_array_that_is_no_matrix_of_real_numbers_is_refused(tmp_path: Path, value: np.ndarray) -> None:
    scipy.io.savemat(tmp_path / "r.mat", {"data": value})
    with pytest.raises(RecordingError, match=r"'data' holds a .* array .*, not numbers"):
        read_table(tmp_path / "r.mat", FileFormat(variable="data"))


@pytest.mark.parametrize("kind", ["csv", "xlsx"])
def test_a_row_of_units_that_holds_numbers_is_a_row_of_data(tmp_path, kind):
    """It was taken for units, and the first sample was lost."""
    table, file = pd.DataFrame({"t": [0.0, 0.1, 0.2, 0.3], "x": [1.0, 0.9, 0.7, 0.4]}), tmp_path / f"r1.{kind}"
    table.to_csv(file, index=False) if kind == "csv" else table.to_excel(file, index=False)
    with pytest.raises(RecordingError, match=r"the row of units holds numbers \(0(.0)?, 1(.0)?\); set unit_row"):
        read_table(file, FileFormat(unit_row=True))
