"""A trial's channels in several tables, files, rates and clocks; layouts by file pattern; values that are missing."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.lab_files import write_tdms
from tests.small_campaign import HOLD_S, Campaign, make_campaign, recorded, write_table
from undertow.campaign.config import load
from undertow.campaign.config.matching import planned
from undertow.conditioning.condition import condition
from undertow.errors import ConfigError, RecordingError
from undertow.recording.catalogue import Catalogue, ChannelSpec, Entry, TimeSpec, TimeWindow, read_trial
from undertow.recording.clocks import BAND_LIMITED_ERROR, placed
from undertow.recording.gaps import complete
from undertow.recording.gather import gather
from undertow.recording.layout import FileFormat

RATE_HZ, FREQUENCY_HZ = 100.0, 1.3


def swing(time: np.ndarray, sensor: float = 1.0) -> np.ndarray:
    """A decaying cosine."""
    return sensor * np.exp(-0.1 * time) * np.cos(2.0 * np.pi * FREQUENCY_HZ * time)


def write(path: Path, **columns: np.ndarray) -> None:
    write_table(path, np.column_stack(list(columns.values())), ",".join(columns))


def catalogue(folder: Path, **channels: ChannelSpec) -> Catalogue:
    return Catalogue(folder, channels, TimeSpec("t"), files="r*.csv")


DISPLACEMENT = ChannelSpec(("x",), "m")


def test_a_channel_in_a_file_beside_with_its_own_rate_and_clock_is_interpolated(tmp_path: Path) -> None:
    slow, fast = np.arange(0.0, 10.0, 0.01), np.arange(0.0, 12.0, 0.004)
    write(tmp_path / "r1.csv", t=slow, x=swing(slow))
    write(tmp_path / "acc_1.csv", a=swing(fast - 0.5, 5.0))
    beside = ChannelSpec(("a",), "m/s^2", file="acc_{number}.csv", time=TimeSpec(rate_hz=250.0, start_s=-0.5))
    said = catalogue(tmp_path, displacement=DISPLACEMENT, acceleration=beside)
    said = replace(said, conditions={"r*": {"number": 1.0}})
    (entry,) = gather(said)
    recording = read_trial(entry, said)
    assert recording.time.tolist() == pytest.approx(slow.tolist())
    inner = (slow > 0.5) & (slow < 9.5)
    error = recording.channels["acceleration"] - swing(slow, 5.0)
    assert np.max(np.abs(error[inner])) < 5.0 * BAND_LIMITED_ERROR
    assert any(note.startswith("acceleration: 250 Hz, interpolated at the instants of displacement (100 Hz) as band")
               for note in recording.notes)  # fmt: skip


def test_a_clock_that_starts_later_is_added_to_the_stamps_of_its_column(tmp_path: Path) -> None:
    time = np.arange(0.0, 10.0, 0.01)
    write(tmp_path / "r1.csv", t=time, x=swing(time))
    write(tmp_path / "r1_a.csv", tick=1e3 * time, a=swing(time + 2.0, 5.0))
    late = TimeSpec("tick", "ms", start_s=2.0)
    beside = ChannelSpec(("a",), "m/s^2", file="{stem}_a.csv", time=late)
    said = catalogue(tmp_path, displacement=DISPLACEMENT, acceleration=beside)
    read = read_trial(gather(replace(said, files="r1.csv"))[0], said)
    assert "acceleration" not in read.channels  # it begins when the body already moves
    early = replace(beside, time=replace(late, start_s=-2.0))
    longer = np.arange(0.0, 12.0, 0.01)
    write(tmp_path / "r1_a.csv", tick=1e3 * longer, a=swing(longer - 2.0, 5.0))
    said = replace(said, channels={**said.channels, "acceleration": early}, files="r1.csv")
    read = read_trial(gather(said)[0], said)
    np.testing.assert_allclose(read.channels["acceleration"], swing(read.time, 5.0), atol=1e-6)


def test_a_channel_slower_than_the_displacement_is_left_out_and_said() -> None:
    slow, fast = np.arange(0.0, 10.0, 0.1), np.arange(0.0, 10.0, 0.01)
    found = placed("spring_force", slow, swing(slow), fast, "displacement")
    assert found.samples is None
    assert "spring_force was recorded at 10 Hz and displacement at 100 Hz: left out in this trial" in found.note


def test_a_channel_at_the_same_instants_is_taken_as_it_is() -> None:
    time = np.arange(0.0, 10.0, 0.01)
    found = placed("acceleration", time + 1e-6, swing(time), time, "displacement")
    assert found.note == ""
    assert found.samples is not None
    assert found.samples.tolist() == swing(time).tolist()


def test_uneven_steps_that_straight_lines_do_not_follow_are_said() -> None:
    time = np.cumsum(0.02 + 0.01 * np.sin(np.arange(400) / 30.0))
    found = placed("acceleration", time, swing(time, 5.0), np.arange(0.1, 7.0, 0.03), "displacement")
    assert found.samples is None
    assert "acceleration has uneven time steps, between which it may differ by" in found.note


@pytest.mark.parametrize(
    ("time", "said"), [(np.array([0.0]), "has no values"), (np.array([0.0, 2.0, 1.0]), "has a time that does not incr")]
)
def test_a_channel_without_a_clock_is_left_out_and_said(time: np.ndarray, said: str) -> None:
    found = placed("acceleration", time, np.ones(time.size), np.arange(5.0), "displacement")
    assert found.samples is None
    assert found.note.startswith(f"acceleration {said}")


def test_a_channel_missing_in_one_file_costs_that_channel_there(tmp_path: Path) -> None:
    time = np.arange(0.0, 10.0, 0.01)
    write(tmp_path / "r1.csv", t=time, x=swing(time), a=swing(time, 5.0))
    write(tmp_path / "r2.csv", t=time, x=swing(time))
    said = catalogue(tmp_path, displacement=DISPLACEMENT, acceleration=ChannelSpec(("a",), "m/s^2"))
    both, lone = (read_trial(entry, said) for entry in gather(said))
    assert list(both.channels) == ["displacement", "acceleration"]
    assert list(lone.channels) == ["displacement"]
    assert any(note.startswith("acceleration left out in this trial: ") and "no column 'a'" in note
               for note in lone.notes)  # fmt: skip
    write(tmp_path / "r3.csv", t=time, a=swing(time))
    with pytest.raises(RecordingError, match=r"trial r3: .*has no column 'x'"):
        read_trial(gather(said)[2], said)


def test_a_file_beside_that_is_not_there_costs_its_channel(tmp_path: Path) -> None:
    time = np.arange(0.0, 10.0, 0.01)
    write(tmp_path / "r1.csv", t=time, x=swing(time))
    beside = ChannelSpec(("a",), "m/s^2", file="{stem}_acc.csv")
    said = catalogue(tmp_path, displacement=DISPLACEMENT, acceleration=beside)
    (entry,) = gather(said)
    recording = read_trial(entry, said)
    assert list(recording.channels) == ["displacement"]
    (note,) = recording.notes
    assert note.startswith("acceleration left out in this trial: ")
    assert "r1_acc.csv is not there" in note


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("a_{depth}.csv", r"its channels' file 'a_\{depth\}\.csv' needs 'depth', which it lacks; it has stem"),
        ("../{stem}.csv", r"its channels' file '\.\./r1\.csv' must lie in the trial's folder; correct recordings\."),
    ],
)
def test_a_file_beside_with_a_wrong_name_is_the_trials_problem(tmp_path: Path, name: str, sentence: str) -> None:
    write(tmp_path / "r1.csv", t=np.arange(9.0), x=np.arange(9.0))
    said = catalogue(tmp_path, displacement=DISPLACEMENT, acceleration=ChannelSpec(("a",), "m/s^2", file=name))
    (entry,) = gather(said)
    with pytest.raises(RecordingError, match=sentence):
        read_trial(entry, said)
    with pytest.raises(RecordingError, match=r"channels lie in the file 'b\.csv', and nothing says where that is"):
        read_trial(Entry("r1", tmp_path / "r1.csv"), replace(said, channels={"displacement": ChannelSpec(
            ("x",), "m", file="b.csv")}))  # fmt: skip


def test_an_accelerometer_alone_is_refused_with_the_reason(tmp_path: Path) -> None:
    time = np.arange(0.0, 10.0, 0.01)
    write(tmp_path / "r1.csv", t=time, a=swing(time))
    said = catalogue(tmp_path, acceleration=ChannelSpec(("a",), "m/s^2"))
    with pytest.raises(RecordingError, match=r"are acceleration; an acceleration integrated twice drifts away"):
        read_trial(gather(said)[0], said)
    with pytest.raises(RecordingError, match=r"are spring_force; motion needs displacement or velocity: map"):
        read_trial(gather(said)[0], replace(said, channels={"spring_force": ChannelSpec(("a",), "N")}))


def test_channels_of_other_groups_of_one_file_have_their_own_tables(tmp_path: Path) -> None:
    import nptdms

    time = np.arange(0.0, 10.0, 0.01)
    write_tdms(tmp_path / "r1.tdms", time, {"x": (swing(time), "m")})
    with nptdms.TdmsWriter(str(tmp_path / "r1.tdms"), mode="a") as file:
        file.write_segment([nptdms.ChannelObject("Cells", "F", swing(time[::-1]), {"wf_increment": 0.01})])
    force = ChannelSpec(("F",), "N", variable="Cells", time=TimeSpec("time"))
    said = Catalogue(tmp_path, {"displacement": DISPLACEMENT, "spring_force": force}, TimeSpec("time"),
                     files="*.tdms", layout=FileFormat(variable="Trial"))  # fmt: skip
    recording = read_trial(gather(said)[0], said)
    np.testing.assert_allclose(recording.channels["spring_force"], swing(time[::-1]), rtol=1e-12)


# missing values ---------------------------------------------------------------------------------------------------


def test_blank_rows_at_the_end_are_trimmed(tmp_path: Path) -> None:
    time = np.arange(0.0, 10.0, 0.01)
    write(tmp_path / "r1.csv", t=time, x=swing(time))
    with (tmp_path / "r1.csv").open("a") as stream:
        stream.write(",\n" * 40 + "\n\n")
    said = catalogue(tmp_path, displacement=DISPLACEMENT)
    assert read_trial(gather(said)[0], said).time.size == time.size
    rated = replace(said, time=TimeSpec(rate_hz=100.0))
    assert read_trial(gather(rated)[0], rated).time.size == time.size


@pytest.mark.parametrize("first", [100, 250])
def test_a_gap_is_left_out_and_the_motion_is_the_same(first: int) -> None:
    table = recorded(0.04, 0)
    whole = condition(_recording(table))
    table[first : first + 15, 1] = np.nan
    time, channels, notes = complete(table[:, 0], {"displacement": table[:, 1], "acceleration": table[:, 2]},
                                     TimeWindow(), "displacement")  # fmt: skip
    assert notes == (f"displacement lacks 15 values in a gap, the longest of 0.15 s at {first / 100:g} s: these "
                     "samples are left out",)  # fmt: skip
    gapped = condition(_recording(np.column_stack([time, channels["displacement"], channels["acceleration"]])))
    assert gapped.window.release_s == pytest.approx(HOLD_S, abs=0.01)
    known = np.isin(np.round(whole.t + whole.window.release_s, 6), np.round(gapped.t + gapped.window.release_s, 6))
    error = gapped.x - whole.x[known]
    assert np.max(np.abs(error)) < 5.0 * np.max(whole.x_std)


def _recording(table: np.ndarray):
    from undertow.recording.recording import Recording

    return Recording("r", table[:, 0], {"displacement": table[:, 1], "acceleration": table[:, 2]})


def test_a_channel_that_lacks_much_is_left_out_and_the_displacement_refused() -> None:
    time = np.arange(0.0, 10.0, 0.01)
    channels = {"displacement": swing(time), "acceleration": swing(time, 5.0)}
    channels["acceleration"][200:300] = np.nan
    _, kept, notes = complete(time, channels, TimeWindow(), "displacement")
    assert list(kept) == ["displacement"]
    assert notes == ("acceleration lacks 100 of 1000 values: left out in this trial",)
    channels["displacement"][200:450] = np.nan
    with pytest.raises(RecordingError, match=r"displacement lacks 250 of 1000 values, the first at 2 s, and more"):
        complete(time, channels, TimeWindow(), "displacement")
    channels["displacement"][:] = np.nan
    with pytest.raises(RecordingError, match=r"displacement has no values in 1000 samples; map another column"):
        complete(time, channels, TimeWindow(), "displacement")


def test_a_channel_that_begins_in_the_middle_of_the_motion_is_left_out() -> None:
    time = np.arange(0.0, 10.0, 0.01)
    channels = {"displacement": swing(time), "acceleration": swing(time, 5.0)}
    channels["acceleration"][:30] = np.nan
    _, kept, notes = complete(time, channels, TimeWindow(), "displacement")
    assert list(kept) == ["displacement"]
    assert notes == (
        "acceleration begins 30 samples after displacement, which moves before: left out in this trial",
    )


@pytest.mark.parametrize("value", [1e300, 1e-300])
def test_values_and_rates_that_nothing_measures_are_refused(tmp_path: Path, value: float) -> None:
    time = np.arange(0.0, 10.0, 0.01)
    write(tmp_path / "r1.csv", t=time, x=swing(time, value))
    said = catalogue(tmp_path, displacement=DISPLACEMENT)
    with pytest.raises(RecordingError, match=r"displacement reaches .* m; a measured value lies between 1e-60 a"):
        read_trial(gather(said)[0], said)


# layouts by file pattern, through a config ------------------------------------------------------------------------


@pytest.fixture
def mixed(tmp_path: Path) -> Campaign:
    """Four trials in three layouts: plain, German text without an accelerometer, and another unit and sign."""
    campaign = make_campaign(tmp_path / "campaign", [0.03, 0.04, 0.05, 0.06])
    german, other = recorded(0.04, 1), recorded(0.05, 2)
    lines = [f"{t:.8g};{1e3 * x:.8g}".replace(".", ",") for t, x, _ in german]
    text = "Prüfstand 2\nZeit;Weg\n" + "\n".join(lines)
    (campaign.folder / "r01.csv").write_bytes(text.encode("cp1252"))
    other[:, 1] *= -100.0
    write_table(campaign.folder / "r02.csv", other)
    campaign.edit("trials:\n", """\
  layouts:
    r01.csv:
      skip_rows: 1
      separator: ";"
      decimal: ","
      encoding: cp1252
      channels:
        time: {column: Zeit, unit: s}
        displacement: {column: Weg, unit: mm}
        acceleration: none
    r02.csv:
      channels:
        displacement: {column: x, unit: cm, sign: -1}
trials:
""")
    return campaign


def test_a_campaign_with_several_layouts_is_read_to_the_same_motions(mixed: Campaign) -> None:
    config = load(mixed.config)
    said = config.catalogue()
    entries = planned(config).entries
    for at, (entry, x0) in enumerate(zip(entries, [0.03, 0.04, 0.05, 0.06], strict=True)):
        recording = read_trial(entry, said)
        true = recorded(x0, at)
        np.testing.assert_allclose(recording.channels["displacement"], true[:, 1], atol=1e-7)
        assert ("acceleration" in recording.channels) == (at != 1)
        assert recording.notes == ()


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("    r02.csv:", "    r09*:", r"config\.yaml line 18: recordings\.layouts names 'r09\*', which fits none of 4"),
        ("unit: cm,", "unit: cmm,", r"line 20: displacement: unit 'cmm' is not known"),
        ("encoding: cp1252", "encoding: ansi7", r"line 13: encoding 'ansi7' is not known; write utf-8"),
        ("{column: Weg, unit: mm}", "none", r"channels has neither displacement nor velocity; map one of them$"),
        ("{column: Zeit, unit: s}", "{column: Zeit, rate_hz: 5.0}", r"time has column 'Zeit' and rate_hz 5\.0; give"),
        ("unit: cm,", "unit: cm, time: {unit: s},", r"time has column None and rate_hz None; give exactly one"),
        ("acceleration: none", "acceleration: no", r"acceleration"),
    ],
)
def test_a_wrong_layout_is_said_with_its_line(mixed: Campaign, old: str, new: str, sentence: str) -> None:
    mixed.edit(old, new)
    with pytest.raises(ConfigError, match=sentence):
        planned(load(mixed.config))
