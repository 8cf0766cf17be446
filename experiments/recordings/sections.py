"""The words of docs/recordings.md: what was recorded, and what the tables say.

Belongs here: text. Numbers that a run gives stand in the tables, not here; a sentence here must stay true when they
move within their errors (tests/recordings holds the claims).
"""

from __future__ import annotations

from dataclasses import dataclass

HEAD = """# Real recordings

Six public sets of recordings that nobody in this project made, each run from its config in `configs/recordings`, some
also with other equations. This page and `recordings.json` (all numbers, inputs and sources with their sha256) are made
by

    {command}

from commit {commit}. The recordings themselves are not part of the project; the configs expect them beside it.

How to read the tables: x'' + c1 x' + c2 x'|x'| + c3 x'^3 + c0 sign(x') + k1 x + k3 x^3 + k5 x^5 = 0 (ks sin x for a
pendulum), all per unit of moving mass or inertia, because a free decay alone gives no more than ratios. Errors are one
standard error, from the residual as it is. *rms* and *nrmse* are those of the free run from the release; *sensors* is
what the sensor's noise alone would give, and *repeatability* what an ordinary rig's scatter from trial to trial would
(no set has enough repeats to say: 0.4 % in k, 20 % in c and 10 % in friction are assumed, as in the flume report's dry
trials). **Over a record of many cycles 0.4 % in k alone turns the phase far, so that repeatability is wide there: a
free run within it does not say that the equation is complete, and with a scatter that is assumed no verdict says so.**
What is significant is then to be read from the coefficients, and from how the rms falls when a term is added. What is
missing is looked for with the config's own terms alone. With others the verdict is "cannot tell", or "unknown" where
the free run misses more than repetitions would. docs/recordings_verdicts.md has what is found with equations that are
too small."""


@dataclass(frozen=True)
class Section:
    """One set of recordings: title, the runs shown, unit of displacement, unit of what is scored, text before and "
    "after.

    ``milli`` prints rms in thousandths of the scored unit.
    """

    title: str
    studies: tuple[str, ...]
    unit: str
    scored: str
    about: str
    conclusion: str
    milli: bool = True


SHIP = Section(
    "Roll decay of the tanker KVLCC2, 0 and 15.5 knots",
    ("kvlcc2", "kvlcc2_quadratic", "kvlcc2_hardening", "kvlcc2_cubic"),
    "rad",
    "rad",
    "Model 1:68 in SSPA's basin, roll angle at 100 Hz, one decay at each speed (Alexandersson and Kjellberg 2021). The "
    "authors call c1, c2, c3 B1, B2, B3 and k1, k3, k5 C1, C3, C5.",
    "At speed the equation leaves half a per cent of the motion, and B1, B2 and C1 agree with the authors' within our "
    "errors, C3 and C5 within two of them: the two are nearly collinear over 9 degrees. Speed raises the linear "
    "damping nearly fourfold (lift on the hull) and leaves the quadratic part.\n\nAt rest the quadratic equation "
    "leaves several times the rms of the one with hardening: the stiffness is not constant. Damping there is not the "
    "quadratic law either. Adding x'^3 halves the rms once more, but turns the quadratic coefficient negative, in the "
    "authors' fit and in ours: a law that no drag has, standing in for one that is missing. The README sees a damping "
    "that is flat up to about 5.5 degrees and then climbs. The authors' C3, C5 and B3 there differ from ours far "
    "beyond our errors; their cell in the notebook loads another run, and their score is below ours.",
)

PENDULUM = Section(
    "Pendulum of a rotary inverted pendulum",
    ("rotary_pendulum", "rotary_pendulum_viscous", "rotary_pendulum_straight", "rotary_pendulum_drag"),
    "rad",
    "rad",
    "Encoder at 1000 Hz, two swings, from 0.75 s on, when the hand is off. The published model has viscous damping "
    "only.",
    "Friction is what the published model lacks: with it the rms falls by a third to more than a half, and each trial "
    "alone gives k1 and c0 of the independent check. Drag adds nothing, and its coefficient is zero within its error; "
    "with it c1 and c0 lose most of their sharpness. A straight spring in place of the sine is refused on both trials. "
    "c0 differs between the two trials by more than their errors: friction in this bearing is not one number.\n\nSINDy "
    "finds k1 too, but not the friction: c0 is zero within its error, and c1 takes up what c0 loses. It needs x'', "
    "which from displacement alone is smooth where friction jumps. Where only displacement was recorded, output error "
    "is the method for friction.",
)

DISC = Section(
    "Mass with a disc on a spring, in air",
    ("spring_disc_air", "spring_disc_linear", "spring_disc_quadratic", "spring_disc_two", "spring_disc_softening"),
    "m",
    "m",
    "Motion sensor, 100 Hz and 200 Hz, three decays: 7 cm, 8 cm and 5 mm. k = 14.919 N/m and m = 0.2016 kg stand in "
    "the file "
    "names, and the author calls this the linear case. Trial 3 has spikes, replaced by a running median of 7 samples.",
    "Linear and quadratic damping, both beyond doubt in the two large decays; friction is not significant in any of "
    "the three. The small decay hardly needs the drag. The moving mass is 3 to 4 % more than the label says (a third "
    "of the spring, and air).\n\nThe run says unknown of all three, and of the large decays that what is left has the "
    "shape of a stiffness or a mass that changes during each trial, which a single decay hardly tells from hysteresis "
    "or a spring that softens. What is left in the large decays, 2 to 3 mm, is far above the sensor, and more than "
    "half of it is a frequency that falls with amplitude: with cubic stiffness (*softening*) the rms of both falls to "
    "1.3 mm or less, k3 many standard errors below zero. That is seen, not claimed: k3 is not the same in the three "
    "decays. The README's ripple of 4 s, a side mode, stays. SINDy gives nothing usable on trial 3, and says so by its "
    "errors.",
)

WHEEL = Section(
    "Bicycle wheel, rate gyro alone",
    (
        "bicycle_wheel_axial", "bicycle_wheel_axial_drag", "bicycle_wheel_axial_coulomb",
        "bicycle_wheel_radial", "bicycle_wheel_radial_drag", "bicycle_wheel_radial_coulomb",
    ),
    "rad",
    "rad/s",
    "Compound pendulum (axial, 4.6 s) and torsion pendulum (radial, 2 s); angular velocity at 500 Hz is all there is, "
    "so that everything is scored against it.",
    "Linear, but for a per cent or two of the motion: of the axial wheel the data cannot tell. Period and R2 agree "
    "with the README's; its decrement of 0.03 for the axial wheel has one digit. Drag comes out negative in both, "
    "which drag cannot be, and friction on the axial wheel only by making c1 negative. On the radial wheel friction is "
    "significant by its own error and takes a quarter off an rms of half a per cent: the run names friction, and "
    "cannot tell which; what is named still leaves several times the sensor's noise.",
)

BUILDING = Section(
    "Model building with a tuned mass damper, the building's sensor alone",
    ("tmd_two_sensors", "tmd_linear", "tmd_cubic"),
    "m",
    "m",
    "Two time-of-flight sensors at 32 Hz, 1 mm a step; the damper's sensor is kept away from the analysis.",
    "The linear equation fails and the run says so (status unknown: with these terms nothing is looked for), with the "
    "residual's line at 1.2 Hz, beside the second mode (1.25 Hz in the README). With the config's own terms what "
    "oscillates by itself is named (explained), by a mass that is not distinguished from zero beside that drag and "
    "friction; docs/recordings_verdicts.md has it with the linear equation and sharp numbers. Friction, drag and "
    "damping together gain almost nothing over the linear equation. With cubic stiffness R2 reaches the README's 0.71 "
    "by absurd coefficients (negative damping held by friction, a k3 that would turn the spring round within the "
    "motion, all within two standard errors of zero), and there the comparison with repeatability is fooled: scatter "
    "of 20 % about an absurd damping makes any error look repeatable. A verdict is worth no more than the coefficients "
    "it stands on; these say by their errors that they are not identifiable.",
)

TANK = Section(
    "Liquid in a tank, three decays",
    ("sloshing_tank", "sloshing_linear", "sloshing_cubic"),
    "%",
    "% of width",
    "Centre of mass of the liquid in per cent of the tank's width, 30 Hz, 79 s (Baeuerlein and Avila 2021).",
    "Softening, k3 < 0, by many standard errors in each decay and in all together; the linear equation is refused. "
    "Friction-like damping at small amplitude is significant too, as the README finds: contact lines, or the image "
    "processing's threshold. c0 and c1 share one effect over this range of amplitude, which is why they differ from "
    "the check by more than k1 and k3 do (there with an asymmetric term).",
    milli=False,
)

SECTIONS = (SHIP, PENDULUM, DISC, WHEEL, BUILDING, TANK)
