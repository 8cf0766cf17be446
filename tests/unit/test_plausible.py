"""Numbers that no body has are doubted; numbers that some body has, and zeros, are not."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from tests.findings_fixture import small_findings
from undertow.campaign.run.plausible import implausible, with_doubts
from undertow.discrepancy.findings import GroupFindings
from undertow.likelihood.fit import Fit, Specimen
from undertow.quantities import Estimate

MASS_KG, K_N_PER_M = 2637.4, 109592.0


def group(stated_k: float = math.nan, **numbers: tuple[float, float]) -> GroupFindings:
    """A group without a structure of its own whose trials gave these numbers (value, standard error)."""
    dry, _ = small_findings().groups
    parameters = {name: Estimate(value, error) for name, (value, error) in numbers.items()}
    fit = Fit("output_error", ("r1",), {}, parameters)
    return replace(dry, structure=None, specimen=Specimen(MASS_KG, stated_k), fits={"output_error": fit})


@pytest.mark.parametrize(
    ("numbers", "sentence"),
    [
        ({"mu": (6.8e-6, 1e-7)}, "friction coefficient 0.00000680 +- 0.00000010 lies outside 0.0001 to 2: look at"),
        ({"mu": (3.1, 0.1)}, "friction coefficient 3.10 +- 0.10 lies outside 0.0001 to 2"),
        ({"mu": (-0.05, 0.001)}, "friction coefficient -0.05"),
        ({"drag_coefficient": (370.0, 5.0)}, "drag coefficient 370 +- 5 lies outside 0.01 to 100: look at the unit of"),
        ({"added_mass_kg": (-2000.0, 50.0)}, "added mass over stated mass -0.758 +- 0.019 lies outside -0.5 to 20"),
        ({"added_mass_kg": (9e4, 50.0)}, "added mass over stated mass 34.1"),
        ({"c_Ns_per_m": (2e4, 10.0), "k_N_per_m": (K_N_PER_M, 1.0), "total_mass_kg": (MASS_KG, 0.0)},
         "damping ratio 0.59 is over 0.5, and such a body does not swing twice: look at the window"),
        ({"viscous_damping_per_mass": (8.0, 0.1), "stiffness_per_mass": (41.5, 0.1)}, "damping ratio 0.62 is over 0.5"),
    ],
)  # fmt: skip
def test_a_number_that_no_body_has_is_doubted(numbers, sentence):
    ((kind, said),) = implausible(group(**numbers))
    assert said.startswith(sentence), said
    assert kind == ("damping" if "damping ratio" in sentence else "conditions")


@pytest.mark.parametrize(
    "numbers",
    [
        {"mu": (0.0, 0.001), "drag_coefficient": (-0.2, 0.5)},
        {"mu": (1e-6, 1e-3)},
        {"mu": (0.0058, 0.0002), "drag_coefficient": (8.1, 0.1), "added_mass_kg": (1271.0, 12.0)},
        {"added_mass_kg": (-430.0, 20.0)},
        {"mu": (math.nan, math.nan), "drag_coefficient": (500.0, math.nan)},
        {"c_Ns_per_m": (590.0, 10.0), "k_N_per_m": (K_N_PER_M, 1.0), "total_mass_kg": (MASS_KG, 0.0)},
        {"c_Ns_per_m": (590.0, 10.0), "k_N_per_m": (0.0, 1.0), "total_mass_kg": (MASS_KG, 0.0)},
    ],
)
def test_a_number_that_some_body_has_is_not_doubted(numbers):
    assert implausible(group(**numbers)) == ()


def test_another_stiffness_than_the_stated_one_is_doubted_beyond_its_error():
    ((_, said),) = implausible(group(90000.0, k_N_per_m=(K_N_PER_M, 200.0)))
    assert said.startswith("stiffness 109590 N/m is 22 % above the stated 90000 N/m, and more than 10 % is doubted")
    assert implausible(group(90000.0, k_N_per_m=(K_N_PER_M, 4000.0))) == ()
    assert implausible(group(105000.0, k_N_per_m=(K_N_PER_M, 200.0))) == ()


def test_doubts_stand_in_the_groups_notes_and_are_said_with_its_label():
    fine, odd = group(mu=(0.005, 0.001)), group(mu=(5.0, 0.1))
    groups, said = with_doubts([fine, odd])
    assert groups[0] == fine
    assert groups[1].notes[-1].startswith("friction coefficient 5.0")
    assert said == (f"{odd.label}: {groups[1].notes[-1]}",)


def test_a_number_that_no_body_has_is_never_green():
    odd = group(mu=(5.0, 0.1))
    green = replace(odd, verdict=replace(odd.verdict, status="nothing_missing", verdict=()))
    (said,), _ = with_doubts([green])
    assert said.verdict.status == "cannot_tell"
    assert said.verdict.because.startswith("friction coefficient 5.0")
    (known,), _ = with_doubts([green], {trial.motion.name: ("conditions",) for trial in green.trials})
    assert known.verdict.status == "nothing_missing"


def test_a_kind_that_every_trial_of_a_group_accepts_is_a_note_and_no_doubt():
    odd = group(mu=(5.0, 0.1))
    names = [trial.motion.name for trial in odd.trials]
    groups, said = with_doubts([odd], {name: ("conditions",) for name in names})
    assert said == ()
    assert groups[0].notes[-1].startswith("accepted (conditions): friction coefficient")
    assert with_doubts([odd], {names[0]: ("conditions",)})[1] != ()
    assert with_doubts([odd], {name: ("damping",) for name in names})[1] != ()
