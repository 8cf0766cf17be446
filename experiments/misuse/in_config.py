"""Mistakes in the config: keys and names that match nothing, impossible specimens, an equation that cannot be."""

from __future__ import annotations

from experiments.misuse.answers import Groups, Stop, TrialsAlone
from experiments.misuse.campaigns import Draft, bridge, pendulum, two_levels, two_springs
from experiments.misuse.case import Case

WET = {"water_depth_m": 2.36}
WET_TRIALS = ("t04", "t05", "t06")
DONE_OR_SOME_FAILED = frozenset({0, 3})


def _dry_level_not_there(draft: Draft) -> None:
    draft.set("trials.dry", {"water_depth_m": 1.65})


def _dry_is_the_wet_level(draft: Draft) -> None:
    draft.set("trials.dry", {"water_depth_m": 2.36})


def _dry_of_the_other_spring(draft: Draft) -> None:
    draft.drop(draft.files(spring="long", water_depth_m=1.63))


def _hold_out_misspelt(draft: Draft) -> None:
    draft.set("trials.hold_out", ["t02.csv", "t5.csv"])


def _hold_out_whole_group(draft: Draft) -> None:
    draft.set("trials.hold_out", [f"{trial}.csv" for trial in WET_TRIALS])


def _window_outside_the_record(draft: Draft) -> None:
    draft.set("trials.window", {"t05*": {"start_s": 40.0, "end_s": 60.0}})


def _window_ends_before_release(draft: Draft) -> None:
    draft.set("trials.window", {"*": {"end_s": 0.6}})


def _window_matches_nothing(draft: Draft) -> None:
    draft.set("trials.window", {"*17*": {"start_s": 0.2}})


def _exclude_matches_nothing(draft: Draft) -> None:
    draft.set("recordings.exclude", ["*17*"])


def _area_key_misspelt(draft: Draft) -> None:
    draft.set("specimen.area_m2", {"by": "water_depth_m", 2.63: 0.97})


def _volume_of_a_level_missing(draft: Draft) -> None:
    del draft.config["specimen"]["submerged_volume_m3"][2.29]


def _mass_zero(draft: Draft) -> None:
    draft.set("specimen.mass_kg", 0)


def _mass_negative(draft: Draft) -> None:
    draft.set("specimen.mass_kg", -5)


def _mass_in_grams(draft: Draft) -> None:
    draft.set("specimen.mass_kg", 2_637_400)


def _mass_in_tonnes(draft: Draft) -> None:
    draft.set("specimen.mass_kg", 2.6374)
    draft.set("specimen.submerged_volume_m3", {"by": "water_depth_m", 2.36: 0.0})


def _area_negative(draft: Draft) -> None:
    draft.set("specimen.area_m2", {"by": "water_depth_m", 2.36: -0.97})


def _volume_in_litres(draft: Draft) -> None:
    draft.set("specimen.submerged_volume_m3", {"by": "water_depth_m", 2.36: 277.5})


def _stiffness_ten_times(draft: Draft) -> None:
    draft.set("specimen.stiffness_N_per_m", 1_095_920)


def _density_in_g_per_cm3(draft: Draft) -> None:
    draft.set("specimen.water_density_kg_per_m3", 1.0)


def _key_misspelt(draft: Draft) -> None:
    draft.set("trails", draft.config.pop("trials"))


def _unknown_suspect(draft: Draft) -> None:
    draft.set("discrepancy.suspects", ["linear_dampening"])


def _no_stiffness(draft: Draft) -> None:
    draft.set("equation.terms", ["viscous_damping", "coulomb_friction", "added_mass", "quadratic_drag"])


def _rotation_as_translation(draft: Draft) -> None:
    draft.set("equation.coordinate", "translation")


MISTAKES = (
    Case(
        "dry_level_not_there",
        "`dry: {water_depth_m: 1.65}` where the index says 1.63",
        bridge,
        _dry_level_not_there,
        (Stop(("dry", r"1\.65")),),
    ),
    Case(
        "dry_is_the_wet_level",
        "`dry: {water_depth_m: 2.36}`, a level with an area and a submerged volume",
        bridge,
        _dry_is_the_wet_level,
        (Stop(("dry|submerged_volume_m3|area_m2",)), Groups(("dry",), codes=DONE_OR_SOME_FAILED)),
    ),
    Case(
        "dry_of_the_other_spring",
        "the long spring was tested in water alone, the short one in air too",
        two_springs,
        _dry_of_the_other_spring,
        (Groups(("dry",), where={"spring": "long", "water_depth_m": 2.36}, done=2),),
    ),
    Case(
        "hold_out_misspelt",
        "`hold_out: [t02.csv, t5.csv]`, and there is no t5",
        bridge,
        _hold_out_misspelt,
        (Stop(("hold_out", r"t5\b")),),
    ),
    Case(
        "hold_out_whole_group",
        "every trial in water is held out: nothing is left to fit",
        bridge,
        _hold_out_whole_group,
        (
            Stop(("hold_out|held out",)),
            Groups(("held out|hold_out|training",), DONE_OR_SOME_FAILED, where=WET, may_be_absent=True),
        ),
    ),
    Case(
        "window_outside_the_record",
        "one trial's window is 40 to 60 s, its record ends at 9.8 s",
        bridge,
        _window_outside_the_record,
        (Stop(("window", "t05")), TrialsAlone(("window",), trials=("t05",), others=5)),
    ),
    Case(
        "window_ends_before_release",
        "every window ends at 0.6 s, before the release",
        bridge,
        _window_ends_before_release,
        (Stop(("window|release|samples",), frozenset({1, 2})),),
    ),
    Case(
        "window_matches_nothing",
        "`window: {'*17*': ...}`, and no file has that name",
        bridge,
        _window_matches_nothing,
        (Stop(("window", "17")),),
    ),
    Case(
        "exclude_matches_nothing",
        "`exclude: ['*17*']`, and no file has that name",
        bridge,
        _exclude_matches_nothing,
        (Stop(("exclude", "17")),),
    ),
    Case(
        "area_key_misspelt",
        "`area_m2: {by: water_depth_m, 2.63: 0.97}` where the level is 2.36",
        bridge,
        _area_key_misspelt,
        (Stop(("area_m2", r"2\.63|2\.36")),),
    ),
    Case(
        "volume_of_a_level_missing",
        "`submerged_volume_m3` has no entry for one of two wet levels",
        two_levels,
        _volume_of_a_level_missing,
        (
            Groups(
                ("submerged_volume_m3", r"2\.29"),
                frozenset({3}),
                where={"water_depth_m": 2.29},
                done=2,
                may_be_absent=True,
            ),
        ),
    ),
    Case("mass_zero", "`mass_kg: 0`", bridge, _mass_zero, (Stop(("mass_kg",)),)),
    Case("mass_negative", "`mass_kg: -5`", bridge, _mass_negative, (Stop(("mass_kg", "-5")),)),
    Case(
        "mass_in_grams",
        "the mass in grams: 2,637,400; the load cells say otherwise",
        bridge,
        _mass_in_grams,
        (Stop(("mass|load cell|spring_force",)),),
    ),
    Case(
        "mass_in_tonnes",
        "the mass in tonnes: 2.6374, and no submerged volume that would make it float",
        bridge,
        _mass_in_tonnes,
        (Stop(("mass|load cell|spring_force",)),),
    ),
    Case("area_negative", "`area_m2` is -0.97", bridge, _area_negative, (Stop(("area_m2", r"-0\.97")),)),
    Case(
        "volume_in_litres",
        "the submerged volume in litres: buoyancy a hundred times the weight",
        bridge,
        _volume_in_litres,
        (Stop(("submerged_volume_m3|buoyancy", "weight|mass|float")),),
    ),
    Case(
        "stiffness_ten_times",
        "the stated spring is ten times the real one: 1,095,920 N/m",
        bridge,
        _stiffness_ten_times,
        (Stop(("stiffness",)), Groups(("stiffness",), codes=DONE_OR_SOME_FAILED)),
    ),
    Case(
        "density_in_g_per_cm3",
        "the water's density in g/cm3: 1.0, so that C_d is 8,000",
        bridge,
        _density_in_g_per_cm3,
        (Stop(("density|drag|C_d",)), Groups(("density|drag|C_d",), DONE_OR_SOME_FAILED, where=WET)),
    ),
    Case("key_misspelt", "`trails:` for `trials:`", bridge, _key_misspelt, (Stop(("trails", "trials")),)),
    Case(
        "unknown_suspect",
        "`suspects: [linear_dampening]`",
        bridge,
        _unknown_suspect,
        (Stop(("suspects", "linear_dampening")),),
    ),
    Case(
        "no_stiffness",
        "the equation's terms leave out the stiffness",
        bridge,
        _no_stiffness,
        (Stop(("stiffness", "term|equation")),),
    ),
    Case(
        "rotation_as_translation",
        "an angle in rad with `coordinate: translation`",
        pendulum,
        _rotation_as_translation,
        (Stop(("rad", "rotation|translation|metre| m")),),
    ),
)
