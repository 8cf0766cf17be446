"""From an index or from names to recordings in SI units, and every way that goes wrong."""

from __future__ import annotations

import hashlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from undertow.errors import ConfigError, RecordingError
from undertow.recording import gather as gather_module
from undertow.recording.catalogue import Catalogue, ChannelSpec, Entry, TimeSpec, TimeWindow, cut, read_trial
from undertow.recording.conditions import condition
from undertow.recording.gather import gather, listing
from undertow.recording.layout import CellLayout, FileFormat

HEAD = "t,x_mm,f1,f2\n"


def rows(n: int = 60, **changed: str) -> str:
    """A small decay: x in mm, two load cells; ``changed`` replaces whole lines by their number (r5="...")."""
    lines = [f"{i * 0.01:.2f},{10 * np.cos(0.3 * i) * 0.97**i:.4f},{i},{2 * i}" for i in range(n)]
    for key, line in changed.items():
        lines[int(key[1:])] = line
    return HEAD + "\n".join(lines) + "\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "data").mkdir()
    for name in ("a", "b", "c"):
        (tmp_path / "data" / f"{name}.csv").write_text(rows())
    index = "file,spring,depth_m,note\na.csv,long,2.36,\nb.csv,short,1.63,wet deck\nc.csv,short,2.36,nan\n"
    (tmp_path / "data" / "campaign.csv").write_text(index)
    return tmp_path


def catalogue(folder: Path) -> Catalogue:
    channels = {"displacement": ChannelSpec(("x_mm",), "mm"), "spring_force": ChannelSpec(("f1", "f2"), "kN")}
    return Catalogue(folder, channels, TimeSpec("t"), index="data/campaign.csv")


def one(folder: Path, text: str) -> tuple[Entry, Catalogue]:
    (folder / "data" / "a.csv").write_text(text)
    said = catalogue(folder)
    return gather(said)[0], said


def test_an_index_gives_trials_with_their_conditions(folder: Path) -> None:
    entries = gather(catalogue(folder))
    assert [entry.name for entry in entries] == ["a", "b", "c"]
    assert dict(entries[0].conditions) == {"spring": "long", "depth_m": 2.36}
    assert dict(entries[1].conditions) == {"spring": "short", "depth_m": 1.63, "note": "wet deck"}


def test_columns_are_summed_converted_and_turned(folder: Path) -> None:
    said = replace(catalogue(folder), channels={"displacement": ChannelSpec(("x_mm",), "mm", -1.0, 2.0),
                                                "spring_force": ChannelSpec(("f1", "f2"), "kN")})  # fmt: skip
    recording = read_trial(gather(said)[0], said)
    assert recording.channels["displacement"][0] == pytest.approx(-(10.0 - 2.0) * 1e-3, rel=1e-12)
    assert recording.channels["spring_force"][7] == pytest.approx(21e3, rel=1e-12)
    assert recording.rate_hz == pytest.approx(100.0)
    assert recording.sha256 == hashlib.sha256((folder / "data" / "a.csv").read_bytes()).hexdigest()


def test_a_file_missing_from_the_disk_is_one_failed_trial(folder: Path) -> None:
    (folder / "data" / "b.csv").unlink()
    said = catalogue(folder)
    entries = gather(said)
    assert [bool(entry.problem) for entry in entries] == [False, True, False]
    with pytest.raises(RecordingError, match=r"trial b: the index names 'b\.csv', but .*b\.csv is not there"):
        read_trial(entries[1], said)


@pytest.mark.parametrize(
    "name", ["../secret.csv", "/etc/passwd", "x/../../secret.csv", "..\\secret.csv", "C:\\x.csv", "~/x"]
)
def test_an_index_does_not_lead_out_of_its_folder(folder: Path, name: str) -> None:
    (folder / "secret.csv").write_text(rows())
    (folder / "data" / "campaign.csv").write_text(f"file,spring\na.csv,long\n{name},long\n")
    said = catalogue(folder)
    entry = gather(said)[1]
    assert entry.path.parent == folder / "data"
    with pytest.raises(RecordingError, match=r"must lie in the index's folder"):
        read_trial(entry, said)


def test_a_name_is_made_from_the_index_columns(folder: Path) -> None:
    (folder / "data" / "campaign.csv").write_text("id;speed\na;0\nb;15.5\n")
    entries = gather(replace(catalogue(folder), file="{id}.csv"))
    assert [(entry.path.name, entry.conditions["speed"]) for entry in entries] == [("a.csv", 0.0), ("b.csv", 15.5)]


def test_trials_under_the_same_conditions_hold_one_read_only_table_of_them(folder: Path) -> None:
    (folder / "data" / "campaign.csv").write_text("id,speed\na,0\nb,15.5\nc,0\n")
    a, b, c = (entry.conditions for entry in gather(replace(catalogue(folder), file="{id}.csv")))
    assert (a is c, a is b) == (False, False)  # the file's own column differs
    (folder / "data" / "campaign.csv").write_text("file,speed\na.csv,0\nb.csv,15.5\nc.csv,0\n")
    a, b, c = (entry.conditions for entry in gather(catalogue(folder)))
    assert (a is c, a is b, dict(b)) == (True, False, {"speed": 15.5})
    with pytest.raises(TypeError, match="item assignment"):
        a["speed"] = 1.0  # type: ignore[index]


def test_conditions_of_an_entry_do_not_change_with_what_they_were_made_from() -> None:
    given = {"speed": 1.0}
    entry = Entry("a", Path("a.csv"), given)
    given["speed"] = 2.0
    assert (entry.conditions["speed"], entry.path, entry.file) == (1.0, Path("a.csv"), "a.csv")


@pytest.mark.parametrize(
    ("name", "value"), [("a_050_acc.csv", 50.0), ("a_1.630_acc.csv", 1.63), ("a_1,63_acc.csv", 1.63)]
)
def test_a_number_in_a_made_name_may_be_spelt_otherwise(folder: Path, name: str, value: float) -> None:
    """run_050 was looked for as run_50, and the accelerometer left out of that trial."""
    (folder / "data" / name).write_text(rows())
    spec = ChannelSpec(("a",), "m/s^2", file="{stem}_{n}_acc.csv")
    said = replace(catalogue(folder), channels={"displacement": ChannelSpec(("x",), "mm"), "acceleration": spec},
                   conditions={"*": {"n": value}})  # fmt: skip
    assert gather(said)[0].beside == {spec.file: str(folder / "data" / name)}
    (folder / "data" / f"a_0{name[2:]}").write_text(rows())  # two that write it: as written, which is not there
    assert gather(said)[0].beside[spec.file] == str(folder / "data" / f"a_{value:g}_acc.csv")
    (folder / "data" / f"a_{value:g}_acc.csv").write_text(rows())
    assert gather(said)[0].beside[spec.file] == str(folder / "data" / f"a_{value:g}_acc.csv")


def test_a_value_in_a_made_name_is_no_path(folder: Path) -> None:
    (folder / "data" / "campaign.csv").write_text("id,speed\n../a,0\n")
    assert "must lie in" in gather(replace(catalogue(folder), file="{id}.csv"))[0].problem


def test_a_folder_is_looked_at_once_however_often_a_glob_says_so(folder: Path) -> None:
    deep = folder.joinpath(*["d"] * 40)
    deep.mkdir(parents=True)
    (deep / "z.csv").write_text("t,x\n")
    said = replace(catalogue(folder), index=None, files="./" + "**/" * 12 + "z.csv")  # 10^11 ways down
    assert [entry.name for entry in gather(said)] == ["z"]
    above = replace(catalogue(folder), folder=folder / "d", index=None, files="../data/[a]*.csv")
    assert [entry.name for entry in gather(above)] == ["a"]


def test_names_give_conditions_by_a_pattern(folder: Path) -> None:
    said = replace(catalogue(folder), index=None, files="data/[abc].csv", pattern=r"(?P<letter>[ab])\.csv")
    entries = gather(said)
    assert [entry.conditions.get("letter") for entry in entries] == ["a", "b", None]
    assert "does not fit recordings.pattern" in entries[2].problem


def test_conditions_windows_and_exclusions_go_by_file_name(folder: Path) -> None:
    said = replace(
        catalogue(folder),
        exclude=("c*",),
        conditions={"a.*": {"run": 1.0}},
        windows={"*": TimeWindow(0.1), "b": TimeWindow(0.2, 0.3)},
    )
    entries = gather(said)
    assert [entry.name for entry in entries] == ["a", "b"]
    assert entries[0].conditions["run"] == 1.0
    assert (entries[0].window, entries[1].window) == (TimeWindow(0.1), TimeWindow(0.2, 0.3))


def test_one_trial_of_a_file_with_several_is_left_out(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gather_module, "count_trials", lambda *_: 3)
    said = replace(
        catalogue(folder), index=None, files="data/a.csv", layout=FileFormat(cells=CellLayout("x")), exclude=("a_2",)
    )
    kept, left_out = listing(said)
    assert ([entry.name for entry in kept], [entry.name for entry in left_out]) == (["a_1", "a_3"], ["a_2"])


def test_trials_of_one_name_carry_their_folder(folder: Path) -> None:
    (folder / "more").mkdir()
    (folder / "more" / "a.csv").write_text(rows())
    said = replace(catalogue(folder), index=None, files="*/a.csv")
    assert [entry.name for entry in gather(said)] == ["data/a.csv", "more/a.csv"]


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"index": "no.csv"}, r"recordings\.index .*no\.csv is not there"),
        ({"index_column": "path"}, "has no column 'path'; it has file, spring, depth_m, note"),
        ({"file": "{idd}.csv"}, "has no column 'idd'"),
        ({"index": None, "files": "data/*.dat"}, r"recordings\.files 'data/\*\.dat' fits no file"),
        ({"index": None, "files": "data/*.csv", "pattern": "("}, "is no regular expression"),
        ({"index": None, "files": "*/../" * 30 + "data/*.csv"}, r"goes up \(\.\.\) from a wildcard; give each"),
        ({"index": None, "files": "**/a/**/a/**/*.csv"}, r"has 3 times \*\*; 2 are allowed"),
        ({"files": "data/*.csv"}, "give exactly one"),
        ({"exclude": ("*",)}, "leaves no trial"),
    ],
)
def test_a_catalogue_that_cannot_be_gathered_says_why(folder: Path, changes: dict[str, object], said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        gather(replace(catalogue(folder), **changes))  # type: ignore[arg-type]


def test_an_empty_index_and_a_repeated_trial_are_refused(folder: Path) -> None:
    index = folder / "data" / "campaign.csv"
    index.write_text("file,spring\n")
    with pytest.raises(ConfigError, match=r"has no rows"):
        gather(catalogue(folder))
    index.write_text("file,spring\na.csv,long\na.csv,long\n")
    with pytest.raises(ConfigError, match=r"is listed 2 times"):
        gather(catalogue(folder))
    index.write_bytes(bytes(range(32)))
    with pytest.raises(ConfigError, match=r"is not text"):
        gather(catalogue(folder))


def test_values_that_are_missing_are_left_out_counted_and_timed(folder: Path) -> None:
    entry, said = one(folder, rows(r20="0.20,,1,2", r21="0.21,NaN,1,2"))
    recording = read_trial(entry, said)
    assert recording.time.size == 58
    assert not np.any((recording.time > 0.195) & (recording.time < 0.215))
    assert "displacement lacks 2 values in a gap, the longest of 0.02 s at 0.2 s: these samples are left out" in (
        recording.notes
    )


def test_nan_outside_the_window_is_left_out_and_counted(folder: Path) -> None:
    entry, said = one(folder, rows(r58="0.58,,1,2", r59="0.59,1,,2"))
    recording = read_trial(replace(entry, window=TimeWindow(None, 0.5)), said)
    assert recording.time.size == 58
    assert "2 incomplete samples outside the window left out" in recording.notes


def test_a_window_beside_the_record_is_refused(folder: Path) -> None:
    entry, said = one(folder, rows())
    with pytest.raises(RecordingError, match=r"window from 8.5 s on holds none of the samples"):
        read_trial(replace(entry, window=TimeWindow(8.5)), said)


@pytest.mark.parametrize(("line", "said"), [("0.18,1,1,2", "0.19 s to 0.18 s"), ("0.19,1,1,2", "0.19 s to 0.19 s")])
def test_time_that_does_not_increase_is_refused(folder: Path, line: str, said: str) -> None:
    entry, where = one(folder, rows(r20=line))
    with pytest.raises(RecordingError, match=f"time goes from {said}"):
        read_trial(entry, where)


def test_a_time_stamp_that_is_missing_is_refused(folder: Path) -> None:
    entry, said = one(folder, rows(r20=",1,1,2"))
    with pytest.raises(RecordingError, match=r"time column 't' has 1 values that are not finite, the first in row 21"):
        read_trial(entry, said)


def test_a_missing_column_and_an_unknown_unit_name_the_trial(folder: Path) -> None:
    entry, said = one(folder, rows())
    with pytest.raises(RecordingError, match=r"trial a: .*no column 'x_m'; .* did you mean 'x_mm'"):
        read_trial(entry, replace(said, channels={"displacement": ChannelSpec(("x_m",), "mm")}))
    with pytest.raises(RecordingError, match=r"trial a: displacement: unit 'furlongz' is not known"):
        read_trial(entry, replace(said, channels={"displacement": ChannelSpec(("x_mm",), "furlongz")}))


def test_time_comes_from_a_column_or_a_rate_and_not_both(folder: Path) -> None:
    entry, said = one(folder, rows())
    known = replace(entry, accepted=("clock",))
    assert read_trial(known, replace(said, time=TimeSpec(rate_hz=50.0))).time[1] == pytest.approx(0.02)
    with pytest.raises(RecordingError, match=r"give one of them"):
        TimeSpec("t", rate_hz=50.0)
    with pytest.raises(RecordingError, match=r"give one of them"):
        TimeSpec()


def test_spikes_are_replaced_only_where_stated_and_counted(folder: Path) -> None:
    entry, said = one(folder, rows(r30="0.30,500,1,2"))
    assert read_trial(entry, said).channels["displacement"].max() == pytest.approx(0.5)
    cleaned = read_trial(entry, replace(said, despike={"displacement": 7}))
    assert np.abs(cleaned.channels["displacement"]).max() < 0.011
    assert "displacement: 1 of 60 samples replaced as spikes (running median of 7)" in cleaned.notes


def test_an_arbitrary_scale_is_noted(folder: Path) -> None:
    entry, said = one(folder, rows())
    recording = read_trial(entry, replace(said, channels={"displacement": ChannelSpec(("x_mm",), "%")}))
    assert recording.channels["displacement"][0] == 10.0
    assert any("uncalibrated scale" in note for note in recording.notes)


def test_a_broken_cell_file_is_one_failed_trial(folder: Path) -> None:
    (folder / "data" / "d.mat").write_bytes(b"garbage " * 100)
    layout = FileFormat(cells=CellLayout("x"))
    entries = gather(replace(catalogue(folder), index=None, files="data/d.mat", layout=layout))
    assert "no readable MATLAB file" in entries[0].problem


def test_numbers_among_conditions_are_numbers() -> None:
    assert [condition(text) for text in ("2.36", "1e-3", " long ", "inf")] == [2.36, 0.001, "long", "inf"]


def test_a_recording_is_cut_to_a_window_without_changing_itself(folder: Path) -> None:
    entry, said = one(folder, rows())
    whole = read_trial(entry, said)
    part = cut(whole, TimeWindow(0.1, 0.2))
    assert (part.time[0], part.time[-1], whole.time.size) == (0.1, 0.2, 60)
    assert part.channels["displacement"].tolist() == whole.channels["displacement"][10:21].tolist()
    with pytest.raises(RecordingError, match=r"holds none of the samples"):
        cut(whole, TimeWindow(9.0))


def test_an_index_that_is_no_table_is_refused(folder: Path) -> None:
    (folder / "data" / "campaign.csv").write_text("file,spring\n" + "x" * 200_000 + ",long\n")
    with pytest.raises(ConfigError, match=r"is no table \(field larger"):
        gather(catalogue(folder))


def test_a_row_of_an_index_that_ends_early_is_one_failed_trial(folder: Path) -> None:
    (folder / "data" / "campaign.csv").write_text("spring,id\nlong,a\nshort\n")
    entries = gather(replace(catalogue(folder), file="{id}.csv"))
    assert [bool(entry.problem) for entry in entries] == [False, True]
