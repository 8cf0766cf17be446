"""Mistakes in the config: keys and names that match nothing, impossible specimens, an equation that cannot be."""

from __future__ import annotations

from experiments.misuse.answers import Groups, Stop, TrialsAlone
from experiments.misuse.campaigns import Draft, bridge, pendulum, two_levels, two_springs
from experiments.misuse.case import Case, setting

WET = {"water_depth_m": 2.36}
WET_TRIALS = ("t04", "t05", "t06")
DONE_OR_SOME_FAILED = frozenset({0, 3})


def _volume_of_a_level_missing(draft: Draft) -> None:
    del draft.config["specimen"]["submerged_volume_m3"][2.29]


def _mass_in_tonnes(draft: Draft) -> None:
    draft.set("specimen.mass_kg", 2.6374)
    draft.set("specimen.submerged_volume_m3", {"by": "water_depth_m", 2.36: 0.0})


MISTAKES = (
    Case("dry_level_not_there", "`dry: {water_depth_m: 1.65}` where the index says 1.63", bridge,
         setting("trials.dry", {"water_depth_m": 1.65}), (Stop(("dry", r"1\.65")),)),
    Case("dry_is_the_wet_level", "`dry: {water_depth_m: 2.36}`, a level with an area and a submerged volume", bridge,
         setting("trials.dry", {"water_depth_m": 2.36}),
         (Stop(("dry|submerged_volume_m3|area_m2",)), Groups(("dry",), codes=DONE_OR_SOME_FAILED))),
    Case("dry_of_the_other_spring", "the long spring was tested in water alone, the short one in air too", two_springs,
         lambda draft: draft.drop(draft.files(spring="long", water_depth_m=1.63)),
         (Groups(("dry",), where={"spring": "long", "water_depth_m": 2.36}, done=2),)),
    Case("hold_out_misspelt", "`hold_out: [t02.csv, t5.csv]`, and there is no t5", bridge,
         setting("trials.hold_out", ["t02.csv", "t5.csv"]), (Stop(("hold_out", r"t5\b")),)),
    Case("hold_out_whole_group", "every trial in water is held out: nothing is left to fit", bridge,
         setting("trials.hold_out", [f"{trial}.csv" for trial in WET_TRIALS]),
         (Stop(("hold_out|held out",)), Groups(("held out|hold_out|training",), DONE_OR_SOME_FAILED, where=WET,
          may_be_absent=True))),
    Case("window_outside_the_record", "one trial's window is 40 to 60 s, its record ends at 9.8 s", bridge,
         setting("trials.window", {"t05*": {"start_s": 40.0, "end_s": 60.0}}),
         (Stop(("window", "t05")), TrialsAlone(("window",), trials=("t05",), others=5))),
    Case("window_ends_before_release", "every window ends at 0.6 s, before the release", bridge,
         setting("trials.window", {"*": {"end_s": 0.6}}), (Stop(("window|release|samples",), frozenset({1, 2})),)),
    Case("window_matches_nothing", "`window: {'*17*': ...}`, and no file has that name", bridge,
         setting("trials.window", {"*17*": {"start_s": 0.2}}), (Stop(("window", "17")),)),
    Case("exclude_matches_nothing", "`exclude: ['*17*']`, and no file has that name", bridge,
         setting("recordings.exclude", ["*17*"]), (Stop(("exclude", "17")),)),
    Case("area_key_misspelt", "`area_m2: {by: water_depth_m, 2.63: 0.97}` where the level is 2.36", bridge,
         setting("specimen.area_m2", {"by": "water_depth_m", 2.63: 0.97}), (Stop(("area_m2", r"2\.63|2\.36")),)),
    Case("volume_of_a_level_missing", "`submerged_volume_m3` has no entry for one of two wet levels", two_levels,
         _volume_of_a_level_missing,
         (Groups(("submerged_volume_m3", r"2\.29"), frozenset({3}), where={"water_depth_m": 2.29}, done=2,
          may_be_absent=True),)),
    Case("mass_zero", "`mass_kg: 0`", bridge, setting("specimen.mass_kg", 0), (Stop(("mass_kg",)),)),
    Case("mass_negative", "`mass_kg: -5`", bridge, setting("specimen.mass_kg", -5), (Stop(("mass_kg", "-5")),)),
    Case("mass_in_grams", "the mass in grams: 2,637,400; the load cells say otherwise", bridge,
         setting("specimen.mass_kg", 2_637_400), (Stop(("mass|load cell|spring_force",)),)),
    Case("mass_in_tonnes", "the mass in tonnes: 2.6374, and no submerged volume that would make it float", bridge,
         _mass_in_tonnes, (Stop(("mass|load cell|spring_force",)),)),
    Case("area_negative", "`area_m2` is -0.97", bridge,
         setting("specimen.area_m2", {"by": "water_depth_m", 2.36: -0.97}), (Stop(("area_m2", r"-0\.97")),)),
    Case("volume_in_litres", "the submerged volume in litres: buoyancy a hundred times the weight", bridge,
         setting("specimen.submerged_volume_m3", {"by": "water_depth_m", 2.36: 277.5}),
         (Stop(("submerged_volume_m3|buoyancy", "weight|mass|float")),)),
    Case("stiffness_ten_times", "the stated spring is ten times the real one: 1,095,920 N/m", bridge,
         setting("specimen.stiffness_N_per_m", 1_095_920),
         (Stop(("stiffness",)), Groups(("stiffness",), codes=DONE_OR_SOME_FAILED))),
    Case("density_in_g_per_cm3", "the water's density in g/cm3: 1.0, so that C_d is 8,000", bridge,
         setting("specimen.water_density_kg_per_m3", 1.0),
         (Stop(("density|drag|C_d",)), Groups(("density|drag|C_d",), DONE_OR_SOME_FAILED, where=WET))),
    Case("key_misspelt", "`trails:` for `trials:`", bridge,
         lambda draft: draft.set("trails", draft.config.pop("trials")), (Stop(("trails", "trials")),)),
    Case("unknown_suspect", "`suspects: [linear_dampening]`", bridge,
         setting("discrepancy.suspects", ["linear_dampening"]), (Stop(("suspects", "linear_dampening")),)),
    Case("no_stiffness", "the equation's terms leave out the stiffness", bridge,
         setting("equation.terms", ["viscous_damping", "coulomb_friction", "added_mass", "quadratic_drag"]),
         (Stop(("stiffness", "term|equation")),)),
    Case("rotation_as_translation", "an angle in rad with `coordinate: translation`", pendulum,
         setting("equation.coordinate", "translation"), (Stop(("rad", "rotation|translation|metre| m")),)),
)  # fmt: skip
