"""Mistakes in paths, recordings and the index."""

from __future__ import annotations

import numpy as np

from experiments.misuse.answers import Groups, Right, Stop, TrialsAlone, Way
from experiments.misuse.campaigns import Draft, bridge
from experiments.misuse.case import Case, everywhere, setting

ONE = "t05.csv"
"""The trial that is spoiled where one is: the largest release in water."""

ADDED_MASS = (({"water_depth_m": 2.36}, "added_mass_kg", 1079.4), ({"water_depth_m": 1.63}, "added_mass_kg", None))


def alone(*says: str) -> tuple[Way, ...]:
    """The spoiled trial is left out with a sentence; the five others are done."""
    return (TrialsAlone(says, trials=("t05",), others=5),)


def _out_cannot_be_written(draft: Draft) -> None:
    draft.words += ["--out", "{folder}/t01.csv/run"]


def _empty_file(draft: Draft) -> None:
    draft.damage[ONE] = lambda whole: b""


def _cut_gzip(draft: Draft) -> None:
    draft.rename(ONE, "t05.csv.gz")
    draft.damage["t05.csv.gz"] = lambda packed: packed[: len(packed) // 2]


def _text_in_a_column(draft: Draft) -> None:
    def spoil(whole: bytes) -> bytes:
        lines = whole.split(b"\n")
        cells = lines[400].split(b",")
        lines[400] = b",".join([cells[0], b"overload", *cells[2:]])
        return b"\n".join(lines)

    draft.damage[ONE] = spoil


def _nan_in_the_middle(draft: Draft) -> None:
    draft.recordings[ONE].loc[400:419, "x"] = np.nan


def _time_jumps_back(draft: Draft) -> None:
    draft.recordings[ONE].loc[500:, "t"] -= 2.0


def _decimal_comma(draft: Draft) -> None:
    draft.separator, draft.decimal = ";", ","


def _swapped_between_levels(draft: Draft) -> None:
    draft.index["t02.csv"], draft.index[ONE] = draft.index[ONE], draft.index["t02.csv"]


def _spring_in_capitals(draft: Draft) -> None:
    draft.index[ONE]["spring"] = "Long"


MISTAKES = (
    Case("index_not_there", "the index's path is wrong: ../data/campaign.csv", bridge,
         setting("recordings.index", "../data/campaign.csv"), (Stop((r"campaign\.csv", "not there|no such")),)),
    Case("out_cannot_be_written", "--out leads into a file", bridge, _out_cannot_be_written,
         (Stop(("cannot be written",), frozenset({1, 2})),)),
    Case("empty_file", "one recording is empty (0 bytes)", bridge, _empty_file, alone("empty")),
    Case("cut_gzip", "one recording is a .csv.gz of which half was copied", bridge, _cut_gzip,
         alone("cut|truncated|incomplete|ends before|damaged")),
    Case("text_in_a_column", "one cell of a recording says 'overload'", bridge, _text_in_a_column,
         alone("not a number")),
    Case("nan_in_the_middle", "0.2 s of one recording's displacement are missing", bridge, _nan_in_the_middle,
         (*alone("displacement|'x'", "not finite|missing|empty"), Right(numbers=ADDED_MASS))),
    Case("time_jumps_back", "one recording's clock was set back by 2 s in the middle", bridge, _time_jumps_back,
         alone("time", "increase|back")),
    Case("time_stamps_doubled", "time was exported with one decimal: ten samples with the same time", bridge,
         everywhere(lambda table: table.assign(t=np.floor(table.t * 10.0) / 10.0)),
         (Stop(("time", "increase|same|repeat|duplicate|coarser"), frozenset({1, 2})),)),
    Case("decimal_comma", "the index came from a spreadsheet, `t01.csv;long;1,63`, and the config says nothing of it",
         bridge, _decimal_comma, (Stop(("1,63|decimal|separator",)), Right(numbers=ADDED_MASS))),
    Case("same_file_twice", "the index names one recording in two rows", bridge,
         lambda draft: draft.index_rows.append({"file": ONE} | draft.index[ONE]),
         (Stop(("t05", "twice|two rows|again|duplicate|more than once|2 rows|rows")),)),
    Case("swapped_between_levels",
         "two rows of the index are swapped: a trial in air stands at 2.36 m and one at 2.36 m in air", bridge,
         _swapped_between_levels,
         (Stop(("t02|t05",)), TrialsAlone(("period|frequency|level|group",), trials=("t02", "t05"), others=4),
          Groups(("t02|t05",), codes=frozenset({0, 3})))),
    Case("levels_pooled", "group_by names the spring alone: air and water in one group", bridge,
         setting("trials.group_by", ["spring"]),
         (Stop(("group_by|water_depth_m",)), Groups(("water_depth_m|dry|period",), codes=frozenset({0, 3})))),
    Case("spring_in_capitals",
         "one row of the index says Long where the others say long: a trial of its own without trials in air", bridge,
         _spring_in_capitals,
         (Stop(("Long",)), Groups(("dry|air|one trial|alone",), codes=frozenset({0, 3}), where={"spring": "Long"},
          done=2))),
)  # fmt: skip
