"""Which trials a file name pattern of a config fits, in every spelling that people write."""

from __future__ import annotations

import pytest

from undertow.recording.patterns import Patterns

FILE = "/lab/2017/configs/../data/run a/r4935.csv.gz"


@pytest.mark.parametrize(
    "spelled",
    [
        "r4935.csv.gz", "r4935.csv", "r4935", "./r4935.csv.gz", "run a/r4935.csv.gz", "run a/r4935", FILE,
        "/lab/2017/data/run a/r4935.csv.gz", "../data/run a/r4935.csv.gz", "*4935*", "r493?.csv.gz", "r49[34]5*",
        "run a/r49*", "*/run a/*", "*_4935",
    ],
)  # fmt: skip
def test_a_file_is_named_by_its_name_its_path_its_stem_or_the_trials_name(spelled: str) -> None:
    name = "r4935" if spelled != "*_4935" else "trial_4935"
    assert Patterns([spelled]).fitting(name, FILE) == (spelled,)


@pytest.mark.parametrize("spelled", ["4935", "r493", "a/r4935.csv.gz", "r4935.gz", "*.txt", "r4935.csv.gz/x", "data"])
def test_a_part_of_a_name_is_another_name(spelled: str) -> None:
    assert not Patterns([spelled]).fit("r4935", FILE)


def test_one_trial_of_a_file_with_several_has_a_name_of_its_own() -> None:
    assert Patterns(["xData_3", "xData.mat", "xData_2"]).fitting("xData_3", "a/xData.mat") == ("xData_3", "xData.mat")


def test_a_pattern_of_names_does_not_fit_a_folder() -> None:
    assert not Patterns(["*2017*"]).fit("r4935", FILE)
    assert Patterns(["*/2017/*"]).fit("r4935", FILE)


def test_a_name_with_brackets_is_named_by_itself() -> None:
    assert Patterns(["t[1].csv"]).fit("t[1]", "t[1].csv")
    assert Patterns(["t[1].csv"]).fit("t1", "t1.csv")


def test_patterns_are_given_in_the_order_they_were_written() -> None:
    said = ["r4936", "*.gz", "r4935", "r*"]
    assert Patterns(said).fitting("r4935", FILE) == ("*.gz", "r4935", "r*")
    assert not Patterns([])
