"""Driven bodies from Python: pysindy's habit, a plain fit, a free run with its band."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import lsim

import undertow
from undertow.comparison.driven_folds import validation_rms
from undertow.comparison.driven_search import without_law
from undertow.conditioning.driven import DrivenTrial
from undertow.conditioning.driven_records import driven_record
from undertow.conditioning.scale import driven_out_of_scale
from undertow.equation.driven_laws import find_driven
from undertow.errors import ConfigError, IdentificationError, NotFittedError, RecordingError
from undertow.likelihood.driven import DrivenLaws
from undertow.methods.driven import fit_driven

STEP, NOISE = 0.01, 1e-4


def shaken(seed, samples=2000):
    """Times, force, and the displacement of a body of 2 kg, 1 N s/m, 50 N/m with noise."""
    rng = np.random.default_rng(seed)
    t = np.arange(samples) * STEP
    u = np.convolve(rng.normal(size=samples + 30), np.hanning(30), "same")[:samples]
    x = lsim(([1.0], [2.0, 1.0, 50.0]), u, t)[1]
    return t, u, x + NOISE * rng.normal(size=samples)


def test_a_plain_fit_gives_numbers_within_their_errors():
    t, u, x = shaken(0)
    found = undertow.fit_driven(x, t=t, u=u)
    truth = {"mass_kg": 2.0, "stiffness.k_N_per_m": 50.0, "viscous_damping.c_Ns_per_m": 1.0}
    for name, true in truth.items():
        number = found.numbers[name]
        assert abs(number.value - true) < 4.0 * number.stderr < 0.05 * true
    assert found.rms == pytest.approx(NOISE, rel=0.05)


def test_a_free_run_needs_start_samples_alone():
    _, u, x = shaken(0)
    other = shaken(1)
    run = undertow.fit_driven(x, t=STEP, u=u).predict(other[2], t=STEP, u=other[1], start=40)
    assert np.sqrt(np.mean((run.values - other[2])[40:] ** 2)) < 1.2 * NOISE
    inside = (other[2] >= run.lower) & (other[2] <= run.upper)
    # rms of the residual is the noise's, so that 90 % of the samples lie inside, give or take
    assert np.mean(inside) == pytest.approx(0.9, abs=0.05)


def test_a_driven_body_is_simulated_from_a_state_under_an_input(capsys):
    t, u, x = shaken(0)
    found = undertow.fit_driven(x, t=t, u=u)
    found.print()
    assert capsys.readouterr().out.startswith("M x'' + k x + c v = F(t), M = 2")

    def slopes(at, y):
        return [y[1], (np.interp(at, t, u) - y[1] - 50.0 * y[0]) / 2.0]

    exact = solve_ivp(slopes, (0.0, t[-1]), [0.05, 0.3], t_eval=t, rtol=1e-9, atol=1e-12).y[0]
    # the numbers' own errors move it by some 1e-5 m
    assert found.simulate([0.05, 0.3], t, u) == pytest.approx(exact, abs=5e-5)
    assert found.simulate(0.05, STEP, u, v0=0.3) == pytest.approx(exact, abs=5e-5)
    assert found.score(x, t=t, u=u) > 0.99
    own = 1.0 - found.rms / np.sqrt(np.mean(x**2))
    assert found.score() == pytest.approx(own)
    with pytest.raises(RecordingError, match="x, t of a record is given alone; give x, t and u, or none of them"):
        found.score(x, t=t)


def test_discover_takes_an_input_as_pysindy_does():
    t, u, x = shaken(0)
    found = undertow.Discover(terms=["cubic_stiffness"], known=("stiffness", "viscous_damping"))
    driven = found.fit(x, t=t, u=u).driven_
    assert driven.added == ()
    assert driven.baseline.numbers["mass_kg"] == pytest.approx(2.0, rel=0.01)
    with pytest.raises(IdentificationError, match="u has 2000 samples but t is None; give the times"):
        found.fit(x, u=u)


def test_a_driven_discover_says_predicts_and_scores_what_it_found():
    t, u, x = shaken(0)
    found = undertow.Discover(terms=["cubic_stiffness"], known=("stiffness", "viscous_damping")).fit(x, t=t, u=u)
    assert found.parameters.loc["mass_kg", "value"] == pytest.approx(2.0, rel=0.01)
    assert found.equations()[0].startswith("M x'' + k x + c v = F(t), M = 2")
    rounded = found.equations(precision=1)[0]
    assert rounded.startswith("M x'' + k x + c v = F(t), M = 2.0; ")
    assert "+-" not in rounded
    assert all(len(part.split(" = ")[1].split()[0].split(".")[1]) == 1 for part in rounded.split("; ")[1:])
    assert str(found).startswith("x: the given equation misses")
    assert "array(" not in str(found) + repr(found.driven_) + repr(found.driven_.baseline) + found._repr_html_()
    assert "!" not in str(found)
    other = shaken(1)
    ahead = found.predict(other[2], t=STEP, u=other[1])
    assert np.sqrt(np.mean((ahead[0] - other[2]) ** 2)) < 1.2 * NOISE
    assert found.score(other[2], t=STEP, u=other[1]) > 0.99
    assert found.score() > 0.99
    assert found.simulate([0.05, 0.0], t, u)[0] == pytest.approx(0.05)
    with pytest.raises(NotFittedError, match=r"fitted to a driven body .* it has equations\(\), parameters"):
        _ = found.coefficients_
    with pytest.raises(IdentificationError, match="u is given, but this Discover was fitted without"):
        undertow.Discover().predict(x, t=t, u=u)


def test_a_spring_that_hardens_ninefold_is_found_although_the_linear_body_misses_most_of_its_motion():
    t = np.arange(4000) * STEP
    u = 40.0 * np.convolve(np.random.default_rng(3).standard_normal(t.size + 50), np.ones(51) / 51, "valid")

    def rates(time, state):
        x, v = state
        return [v, (np.interp(time, t, u) - 100.0 * x - 0.5 * v - 3000.0 * x**3) / 2.0]

    x = solve_ivp(rates, (0.0, t[-1]), [0.0, 0.0], t_eval=t, rtol=1e-9, atol=1e-11, max_step=STEP).y[0]
    x = x + NOISE * np.random.default_rng(9).standard_normal(t.size)
    found = undertow.Discover(known=("stiffness", "viscous_damping")).fit(x, t=t, u=u)
    assert found.driven_.added == ("cubic_stiffness",)
    assert found.driven_.validation[1] < 1.2 * NOISE < 0.01 * found.driven_.validation[0]
    assert "!" not in str(found)


def test_what_a_free_run_misses_is_said_first():
    t, u, x = shaken(0)
    stiff = undertow.fit_driven(x + 20.0 * np.max(np.abs(x)) * (x / np.max(np.abs(x))) ** 3, t=t, u=u)
    assert "sensor's noise: the equation lacks something" in str(stiff).split("\n")[1]
    assert str(undertow.fit_driven(x, t=t, u=u)).split("\n")[1].startswith("  mass_kg")
    run = stiff.predict(x, t=t, u=u)
    assert repr(run).startswith("free run of 2000 samples, started from the first 50")


def test_units_of_a_driven_body_are_brought_to_si():
    t, u, x = shaken(0)
    si = undertow.fit_driven(x, t=t, u=u)
    units = {"x": "mm", "u": "kN", "t": "ms", "v": "cm/s"}
    said = undertow.fit_driven(1000.0 * x, t=1000.0 * t, u=u / 1000.0, units=units)
    assert said.fit.values == pytest.approx(si.fit.values, rel=1e-6)
    discover = undertow.Discover(terms=["cubic_stiffness"], known=("stiffness", "viscous_damping"))
    found = discover.fit(1000.0 * x, t=t, u=u, units={"displacement": "mm", "force": "N"}).driven_
    assert found.baseline.numbers["mass_kg"] == pytest.approx(2.0, rel=0.01)
    ahead = said.predict(1000.0 * x, t=1000.0 * STEP, u=u / 1000.0, units=units)
    assert np.sqrt(np.mean((ahead.values - x) ** 2)) < 1.2 * NOISE
    turned = undertow.fit_driven(np.degrees(x), t=t, u=u / 1000.0, units={"x": "deg", "u": "kN m"})
    assert turned.fit.values == pytest.approx(si.fit.values, rel=1e-6)


def test_units_that_a_driven_fit_cannot_take_are_refused():
    t, u, x = shaken(0, 600)
    with pytest.raises(RecordingError, match="units names 'a', but of a driven body it may name x, v, t, u"):
        undertow.fit_driven(x, t=t, u=u, units={"a": "g"})
    with pytest.raises(RecordingError, match="force is said to be in 'mm'"):
        undertow.fit_driven(x, t=t, u=u, units={"u": "mm"})
    with pytest.raises(RecordingError, match="units is 'mm'; give a mapping"):
        undertow.fit_driven(x, t=t, u=u, units="mm")
    with pytest.raises(RecordingError, match=r"columns is .*, but with u x is an array"):
        undertow.Discover().fit(x, t=t, u=u, columns={"displacement": "x"})


def test_velocity_beside_displacement_is_left_alone():
    t, u, x = shaken(0)
    both = undertow.fit_driven(np.column_stack([x, np.gradient(x, t)]), t=t, u=u)
    assert both.numbers == undertow.fit_driven(x, t=t, u=u).numbers


@pytest.mark.parametrize(
    ("settings", "error", "match"),
    [
        ({"held": {"mass": 8.0}}, ConfigError, "'mass' is no number of this equation; it has mass_kg, stiffness.k_N_p"),
        ({"starts": {"foo": 1.0}}, ConfigError, "'foo' is no number of this equation; it has mass_kg, "),
        ({"held": {"mass_kg": "4"}}, ConfigError, "held says that mass_kg is '4'; give a finite number"),
        ({"starts": [1.0]}, ConfigError, r"starts is \[1.0\]; give numbers by name"),
        ({"held": {"mass_kg": 2.0, "stiffness.k_N_per_m": 50.0, "viscous_damping.c_Ns_per_m": 1.0}},
         IdentificationError, "all 3 numbers .* are held, and nothing is left to be found; leave one out"),
        ({"frame": "foo"}, ConfigError, "frame is 'foo'; give one of absolute, relative"),
        ({"quantity": "foo"}, ConfigError, "quantity is 'foo'; give one of force, base_displacement"),
        ({"hold": "foo"}, ConfigError, "hold is 'foo'; give one of zero, first, band_limited"),
        ({"equation": "stiffness"}, ConfigError, "equation is the single 'stiffness'; give a list of names"),
    ],
)  # fmt: skip
def test_an_argument_of_a_driven_fit_that_means_nothing_is_refused(settings, error, match):
    t, u, x = shaken(0)
    with pytest.raises(error, match=match):
        undertow.fit_driven(x, t=t, u=u, **settings)


def test_another_signal_beside_the_displacement_is_not_dropped_without_a_word():
    t, u, x = shaken(0)
    two = np.column_stack([x, shaken(1)[2]])
    said = r"x has the shape \(2000, 2\), and what stands beside its first column is not its velocity; give one displ"
    for given, drive in ((two, u), ([two, two], [u, u]), (np.column_stack([x, 0.0 * x]), u)):
        with pytest.raises(RecordingError, match=said):
            undertow.fit_driven(given, t=STEP, u=drive)
    with pytest.raises(RecordingError, match=said):
        undertow.Discover(known=("stiffness", "viscous_damping")).fit(two, t=t, u=u)


def test_arrays_that_do_not_fit_together_are_refused():
    t, u, x = shaken(0)
    with pytest.raises(RecordingError, match="force has 1999 samples but time has 2000"):
        undertow.fit_driven(x, t=t, u=u[1:])
    with pytest.raises(IdentificationError, match="equation names 0 terms"):
        undertow.fit_driven(x, t=t, u=u, equation=())


def test_a_law_that_another_makes_needless_goes_and_one_that_is_needed_stays():
    t, u, x = shaken(0)
    terms = [find_driven(name) for name in ("stiffness", "viscous_damping", "quadratic_drag")]
    trial = driven_record(x, t, u, "first")
    training, unseen = [trial.part(0, 1600)], [trial.part(1600, 2000)]
    current = fit_driven(training, DrivenLaws(tuple(terms)))
    lowest = validation_rms(unseen, current)
    assert without_law(training, unseen, current, "viscous_damping", lowest) is None
    lean, after = without_law(training, unseen, current, "quadratic_drag", lowest)
    assert [term.name for term in lean.laws.terms] == ["stiffness", "viscous_damping"]
    assert after < 1.02 * lowest


def test_a_driven_record_in_other_units_than_si_is_asked_for_or_doubted():
    """Files of decays were doubted so; of arrays in mm and ms the numbers were taken as they came."""
    t, u, x = shaken(0, 600)
    with pytest.raises(RecordingError, match=r"^t has no unit, and in seconds there would be a sample every .*units="):
        undertow.fit_driven(x, t=1e3 * t, u=u)
    with pytest.raises(RecordingError, match=r"^t has no unit, and in seconds there would be a sample every"):
        undertow.Discover(known=("stiffness",)).fit(x, t=1e3 * t, u=u)
    assert undertow.fit_driven(x, t=t, u=u).doubts == ()
    large = undertow.fit_driven(1e5 * x, t=t, u=1e5 * u).doubts
    assert len(large) == 1
    assert re.fullmatch(r"trial x moves by \S+ m with \S+ g, more than 100: is it in mm\? Correct the .*", large[0])
    slow = undertow.fit_driven(x, t=1e3 * t, u=u, units={"t": "s"})
    assert any(re.match(r"trial x moves with a period of \S+ s, longer than 400 s: is its time in ms\?", one)
               for one in slow.doubts)  # fmt: skip
    assert "! trial x moves with" in repr(slow)
    turned = driven_out_of_scale([large_trial(x, t, u)], "rotation")
    assert turned[0].startswith("a body turns by ")


def large_trial(x, t, u) -> DrivenTrial:
    return DrivenTrial("x", t, u, {"displacement": 10.0 * x / np.max(np.abs(x))})


def test_dates_are_times_and_what_is_no_number_is_refused():
    t, u, x = shaken(0, 600)
    dates = np.datetime64("2026-03-01") + np.round(1e9 * t).astype("timedelta64[ns]")
    by_dates = undertow.fit_driven(x, t=dates, u=u)
    assert by_dates.numbers["mass_kg"].value == pytest.approx(undertow.fit_driven(x, t=t, u=u).numbers["mass_kg"].value)
    with pytest.raises(RecordingError, match="u holds complex numbers, and is real"):
        undertow.fit_driven(x, t=t, u=u + 1j)
    with pytest.raises(RecordingError, match="x holds dates or durations, and no numbers"):
        undertow.fit_driven(dates, t=t, u=u)
    with pytest.raises(RecordingError, match="displacement has 40 values that are not finite"):
        undertow.fit_driven(np.ma.masked_greater(x, 0.9 * np.max(x)), t=t, u=u)
    with pytest.raises(RecordingError, match="t holds what is no number"):
        undertow.fit_driven(x, t=["soon"] * x.size, u=u)


def test_two_laws_of_one_force_are_refused_unless_one_is_held():
    t = np.arange(2000) * 0.01
    u = np.sin(0.1 * t**2)
    x = lsim(([1.0], [2.0, 1.0, 50.0]), u, t)[1]
    laws = ["stiffness", "viscous_damping", "linear_damping"]
    said = "viscous_damping.c_Ns_per_m and linear_damping.c_Ns_per_m are the same force, and only their sum is known"
    with pytest.raises(IdentificationError, match=said):
        undertow.fit_driven(x, equation=laws, t=t, u=u)
    found = undertow.fit_driven(x, equation=laws, t=t, u=u, held={"viscous_damping.c_Ns_per_m": 0.4})
    assert found.numbers["linear_damping.c_Ns_per_m"].value == pytest.approx(0.6, abs=0.01)
