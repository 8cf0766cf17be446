"""Which of a run's groups a reader means by words or conditions."""

from __future__ import annotations

import pytest

from undertow.errors import ConfigError
from undertow.report.which_group import group_meant, groups_meant

GROUPS = [{"spring": spring, "depth_m": depth} for spring in ("soft", "stiff") for depth in (0.0, 2.0, 2.3)]


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("spring soft, depth 2.3 m", [2]),
        ("depth 2.3 m", [2, 5]),
        ("depth_m=2.3", [2, 5]),
        ("depth_m=2.30,spring=soft", [2]),
        ("depth = 2.3 m, SOFT", [2]),
        ("stiff 2", [4]),
        ("2.3m soft", [2]),
        ("sti", [3, 4, 5]),
        ("spring=2.3", []),
        ("width=2.3", []),
        ("depth_m=", []),
        ("", [0, 1, 2, 3, 4, 5]),
    ],
)
def test_words_and_conditions_mean_the_groups_that_a_reader_means(typed, meant):
    assert groups_meant(typed, GROUPS) == meant


def test_a_whole_title_is_that_group_though_others_hold_its_words():
    groups = [{"spring": "soft", "kind": "soft long"}, {"spring": "soft", "kind": "soft"}]
    assert groups_meant("spring soft, kind soft", groups) == [1]


def test_the_only_group_is_taken_and_several_are_listed():
    assert group_meant("soft 2.3", GROUPS) == 2
    with pytest.raises(ConfigError, match=r"^2 groups fit '2.3'; say one of: spring soft, depth 2.3 m; spring"):
        group_meant("2.3", GROUPS)
    with pytest.raises(ConfigError, match=r"^no group fits '9'; say one of: spring soft, depth 0 m; spring soft"):
        group_meant("9", GROUPS)
