"""Dry decays: the envelope is exact for Eq. 1, the spring shows in period and load cells, few trials say so."""

import math

import numpy as np
import pytest

from experiments.eq15_campaign.motion import Body, simulate
from tests.exact_motions import exact_motion
from undertow.errors import IdentificationError
from undertow.likelihood.fit import Specimen
from undertow.methods.decay import (
    fit_envelope,
    identify_decay,
    load_cell_stiffness,
    stiffness_disagreement,
    turning_points,
)
from undertow.quantities import Estimate

MASS_KG, MU = 2637.4, 0.0073
FRICTION_N = MU * MASS_KG * 9.81
DRY = Body(inertia_kg=MASS_KG, c_Ns_per_m=590.0, k_N_per_m=109592.0, friction_N=FRICTION_N, drag_Ns2_per_m2=0.0)
SPECIMEN = Specimen(mass_kg=MASS_KG, area_m2=0.0)


def decay(x0=0.1, body=DRY, **sensors):
    return exact_motion(body, x0, **sensors)


def test_envelope_of_equation_1_returns_damping_friction_and_period():
    fit = identify_decay(decay(), SPECIMEN)
    # turning points are interpolated between 1 ms samples
    assert fit.parameters["c_Ns_per_m"].value == pytest.approx(590.0, rel=2e-4)
    assert fit.parameters["mu"].value == pytest.approx(MU, rel=2e-4)
    assert fit.parameters["k_N_per_m"].value == pytest.approx(109592.0, rel=1e-5)
    assert fit.parameters["damping_ratio"].value == pytest.approx(590.0 / 2.0 / math.sqrt(109592.0 * MASS_KG), rel=2e-4)
    assert fit.anchor == "mass"


def test_a_turning_point_is_where_the_exact_motion_turns():
    motion = decay(rate_hz=250.0)
    exact = simulate(DRY, 0.1, motion.t)
    times, places = turning_points(motion)
    assert times == pytest.approx(exact.reversals_s[1 : times.size + 1], abs=2e-5)
    assert places == pytest.approx(exact.reversals_m[1 : times.size + 1], abs=1e-6)


def test_frictionless_decay_has_the_logarithmic_decrement_and_says_that_friction_is_not_told_from_0():
    # a window to 0.9 of 12 s, friction of nothing
    body = Body(MASS_KG, 590.0, 109592.0, 1e-9, 0.0)
    envelope = fit_envelope(decay(body=body))
    zeta = 590.0 / 2.0 / math.sqrt(109592.0 * MASS_KG)
    assert envelope.values[0] == pytest.approx(2.0 * math.pi * zeta / math.sqrt(1.0 - zeta**2), rel=1e-4)
    assert "not distinct from 0" in identify_decay(decay(body=body), SPECIMEN).parameters["mu"].outcome


def test_envelope_does_not_care_where_the_sensor_has_its_zero():
    shifted = fit_envelope(decay(offset_m=0.004))
    assert shifted.rest_m == pytest.approx(0.004, abs=2e-6)
    assert shifted.values == pytest.approx(fit_envelope(decay()).values, rel=1e-6)


def test_a_stiffness_anchors_where_there_is_no_mass_and_neither_gives_ratios_over_mass():
    by_stiffness = identify_decay(decay(), Specimen(stiffness_N_per_m=109592.0))
    assert by_stiffness.parameters["c_Ns_per_m"].value == pytest.approx(590.0, rel=3e-4)
    assert by_stiffness.anchor == "stiffness"
    per_mass = identify_decay(decay(), Specimen())
    assert per_mass.parameters["k_N_per_m_per_mass"].value == pytest.approx(109592.0 / MASS_KG, rel=1e-5)
    assert per_mass.parameters["mu"].value == pytest.approx(MU, rel=3e-4)
    assert per_mass.anchor == "none"


def test_a_decay_of_four_turning_points_is_refused_with_the_count():
    with pytest.raises(IdentificationError, match=r"trial r1: [0-4] turning points .* the envelope needs 5"):
        fit_envelope(decay(x0=0.009))


def test_load_cells_return_their_stiffness_despite_offsets_and_noise():
    motion = decay(force_noise=30.0, force_offset_N=250.0, offset_m=0.003)
    spring = load_cell_stiffness(motion)
    assert spring.unit == "N/m"
    assert abs(spring.value - 109592.0) < 4.0 * spring.stderr
    assert spring.stderr < 1e-3 * spring.value


def test_load_cell_error_is_the_scatter_of_repetitions():
    springs = [load_cell_stiffness(decay(force_noise=50.0, rate_hz=250.0, seed=seed)) for seed in range(25)]
    scatter = np.std([spring.value for spring in springs])
    assert np.mean([spring.stderr for spring in springs]) == pytest.approx(scatter, rel=0.45)  # 14 % from 25 draws


def test_two_springs_that_disagree_are_both_printed():
    motion = decay(k_cells_N_per_m=115000.0, force_noise=300.0)
    (note,) = identify_decay(motion, SPECIMEN).notes
    assert "109592" in note
    assert "by the period, 11" in note
    assert "they differ by 4.9 %" in note
    close = stiffness_disagreement(Estimate(100.0, 1.0, unit="N/m"), Estimate(100.5, 1.0, unit="N/m"))
    assert "they agree within 1 %, apart by 0.5 % (0.35 standard errors)" in close


def test_load_cells_that_were_not_recorded_are_named():
    motion = decay()
    channels = {name: values for name, values in motion.recording.channels.items() if name != "spring_force"}
    object.__setattr__(motion.recording, "channels", channels)
    with pytest.raises(IdentificationError, match=r"trial r1 has no channel spring_force; it has displacement"):
        load_cell_stiffness(motion)
    assert identify_decay(motion, SPECIMEN).notes == ()
