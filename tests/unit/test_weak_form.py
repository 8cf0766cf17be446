"""The second route: the weak form on recorded samples, whatever was recorded, and its word on the first route."""

from dataclasses import replace

import numpy as np
import pytest

from tests.exact_motions import LONG, exact_group, exact_motion
from tests.short_trials import LONG as NOISY_LONG
from tests.short_trials import group, per_mass
from undertow.conditioning.condition import condition
from undertow.equation.hydrodynamics import LinearDamping, QuadraticDrag
from undertow.equation.structure import CoulombFriction, Stiffness, ViscousDamping
from undertow.errors import IdentificationError
from undertow.methods.weak_form import measured_design, response_channel, second_route
from undertow.recording.recording import Recording

EQ15 = (Stiffness(), ViscousDamping(), CoulombFriction(), QuadraticDrag())
TRUTH = np.array([LONG.k_N_per_m, LONG.c_Ns_per_m, LONG.friction_N, LONG.drag_Ns2_per_m2]) / LONG.inertia_kg
TIGHT = np.diag((1e-4 * TRUTH) ** 2)


def only(motion, **channels):
    """The motion with these recorded channels alone; True takes the recording's own."""
    own = motion.recording
    kept = {name: own.channels[name] if values is True else values for name, values in channels.items()}
    return replace(motion, recording=Recording(own.name, own.time, kept))


def with_rate(motion):
    """The motion as a rate gyro alone would have recorded it."""
    held = motion.recording.time.size - motion.t.size
    return only(motion, velocity=np.concatenate([np.zeros(held), motion.v]))


@pytest.mark.parametrize(
    ("change", "response", "tolerance"),
    [
        (lambda m: m, "acceleration", 1e-6),
        # partial integration by sums: friction's kink in a and the finite test function leave a few 1e-4
        (lambda m: only(m, displacement=True), "displacement", 2e-3),
        (with_rate, "velocity", 2e-3),
    ],
    ids=["acceleration", "displacement", "velocity"],
)
def test_exact_records_give_exact_coefficients_whatever_was_recorded(change, response, tolerance):
    motions = [change(motion) for motion in exact_group(LONG, offset_m=0.002, a_offset=0.05)]
    assert {response_channel(motion) for motion in motions} == {response}
    route = second_route(motions, EQ15, TRUTH, TIGHT)
    assert route.values == pytest.approx(TRUTH, rel=tolerance)
    assert route.response == response


@pytest.mark.parametrize("change", [lambda m: only(m, displacement=True), with_rate], ids=["displacement", "velocity"])
def test_linear_damping_of_the_water_is_weighed_on_the_record_as_that_of_the_structure(change):
    motions = [change(exact_motion(LONG, 0.1))]
    laws = (ViscousDamping(), LinearDamping())
    dry, wet = (measured_design(motions, (Stiffness(), law)).columns[:, 1] for law in laws)
    assert np.array_equal(dry, wet)


def test_trials_of_unequal_length_have_their_own_rows():
    motions = [exact_motion(LONG, 0.1, "long"), exact_motion(LONG, 0.1, "short", duration_s=6.0)]
    design = measured_design(motions, EQ15)
    assert design.lengths[0] > 1.3 * design.lengths[1]
    assert second_route(motions, EQ15, TRUTH, TIGHT).values == pytest.approx(TRUTH, rel=1e-6)


def test_routes_agree_on_noise_and_disagree_with_wrong_numbers():
    # 12, 15 and 21: their residuals show too little memory in the direction of the whole loss of energy
    truth = per_mass(NOISY_LONG)
    groups = [[condition(recording) for recording in group(NOISY_LONG, seed=seed)] for seed in (1, 12, 15, 21)]
    routes = [second_route(motions, EQ15, truth, np.diag((1e-3 * truth) ** 2)) for motions in groups]
    assert all(route.agrees for route in routes)
    motions, route = groups[0], routes[0]
    assert "weak form on the recorded acceleration agrees: F = " in route.sentence
    wrong = second_route(motions, EQ15, truth * np.array([1.02, 1.0, 1.0, 1.0]), np.diag((1e-3 * truth) ** 2))
    assert not wrong.agrees
    assert "DISAGREES" in wrong.sentence
    assert wrong.sentence.endswith("standard errors in stiffness")


def test_a_late_accelerometer_is_corrected_by_its_clock():
    motions = [condition(recording) for recording in group(NOISY_LONG, seed=1)]
    truth = per_mass(NOISY_LONG)
    late = {motion.name: 0.01 for motion in motions}
    assert not second_route(motions, EQ15, truth, np.diag((1e-3 * truth) ** 2), late).agrees

    def delayed(motion):
        a = motion.recording.channels["acceleration"]
        # sampled 10 ms later than stamped
        return only(motion, displacement=True, acceleration=np.concatenate([a[2:], a[-2:]]))

    moved = [delayed(motion) for motion in motions]
    assert second_route(moved, EQ15, truth, np.diag((1e-3 * truth) ** 2), late).agrees


def test_what_gives_no_rows_is_refused_with_its_number():
    with pytest.raises(IdentificationError, match=r"0 motions; give at least one trial"):
        measured_design([], EQ15)
    with pytest.raises(IdentificationError, match=r"trial r1: \d rows in a window of 0.89\d* s.*10 are needed"):
        measured_design([exact_motion(LONG, 0.1, duration_s=1.1)], EQ15)
    motion = exact_motion(LONG, 0.1)
    with pytest.raises(IdentificationError, match=r"trial r1: recorded is spring_force; map displacement, velocity"):
        response_channel(only(motion, spring_force=True))
