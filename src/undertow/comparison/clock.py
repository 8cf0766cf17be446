"""Whether an outside force that was fitted has a clock of its own: phases that do not go with the release.

Belongs here: that question. Does not belong here: whether numbers mean anything otherwise (candidate.py).
"""

from __future__ import annotations

import math

import numpy as np

from undertow.comparison.joint import JointFit, shared_theta
from undertow.comparison.level import Addend, Level
from undertow.comparison.limits import FAR_ABOVE_NOISE
from undertow.equation.forcing import ENVELOPE
from undertow.equation.kernel import SLOT
from undertow.recording.recording import Array

SIGNIFICANT = 3.0
"""A suspect's coefficient must be this many standard errors from zero."""

TIED = 0.2
"""A force named beside another effect has phases of its own: were they drawn at random, they would agree from trial to
trial as much as they do in at least this share of draws. Fewer, and it is what the other effect leaves."""

TIED_SURELY = 0.02
"""The same share where a force beside another effect leaves no more than noise: a memory leaves hardly a tone so pure,
but of water that radiates waves (a kernel that rings and fades) one was named whose phases agreed in 1 of 100 draws."""

FADED = 1.0 / 3.0
"""Share of its first size that a force which dies out keeps to every record's end: radiated waves kept .09 to .17."""

DRAWS = 2000
"""Random phases drawn for that share."""

CLOCKED = 2
"""Trials in which an outside force must be distinct from zero: in one alone a clock explains whatever is left, but
for a tone that is `PURE`, which nothing else is."""

OWN_FREQUENCY = 0.1
"""A force this close (relative) to the body's own frequency may be the body's own motion: its phases decide."""

OWN_LEAVES = 1.5
"""Times the noise, in variance, that a force near the body's own frequency may leave that is not `PURE`: a spring that
changes in time left 1.7 beside one, a seiche whose size wanders 1.3 (c0093 of sealed seed 2128001)."""

LOCKED = 0.7
"""Twice the phases agree by at least this where a force near the body's own frequency is locked to the release, as what
the equation leaves is; of phases drawn at random, those of three trials do so in 27 of 100 campaigns, of six in 5."""

PURE = 0.998
"""Share of what lies above noise that a force with a size and a phase of its own in every trial explains, down to the
noise, only if it is one: what an equation leaves of the body's own motion dies out with it and is no tone. Of seiches
near the body's rate (4002500 to 4002539 of the names study) it left 8 in 10,000 at most, where a stiffness drifted from
trial to trial (c0105 of sealed seed 2108001) 95."""


def at_a_resonance(fit: JointFit) -> bool:
    """Whether an outside force has the frequency of a resonator that the same fit holds."""
    clock = _clock(fit, next(addend for addend in fit.addends if addend.has_its_own_clock))
    swings = [v for name, v in fit.values.items() if name.split("@")[0].endswith("natural_frequency_rad_per_s")]
    return any(abs(clock / swing - 1.0) < OWN_FREQUENCY for swing in swings)


def _clock(fit: JointFit, force: Addend) -> float:
    """Frequency of an outside force, rad/s."""
    return fit.value(f"{force.prefix}.frequency_rad_per_s")


def parts_of(fit: JointFit, force: Addend, trial: str, share: float = 0.5) -> tuple[list[int], Array]:
    """An outside force's cosine and sine in the middle of one trial, or after another ``share`` of it, as a sum of
    unknowns: their places (n,), and what each counts (2, n)."""
    names = fit.solution.problem.names
    t = next(one.t for one in fit.solution.problem.trials if one.name == trial)
    at = float(t[0] + share * (t[-1] - t[0]))
    own = [a for a in force.additions if a.of_its_own]
    rows = [
        [sum(by * at ** ENVELOPE.index(slot[4:]) for slot, by in a.slots if slot[1:4] == part) for a in own]
        for part in ("cos", "sin")
    ]
    return [names.index(f"{force.prefix}.{a.name}[{trial}]") for a in own], np.array(rows)


def changes(force: Addend) -> bool:
    """Whether an outside force changes along the record."""
    return any(a.of_its_own and a.also for a in force.additions)


def _size(fit: JointFit, force: Addend, trial: str, share: float = 0.5) -> complex:
    """An outside force in the middle of one trial, or after another ``share`` of it: its cosine, and its sine as
    imaginary part."""
    places, counts = parts_of(fit, force, trial, share)
    return complex(*(counts @ fit.solution.values[places]))


def no_clock(level: Level, fit: JointFit, force: Addend, beside: bool, before: JointFit | None) -> str:
    """Why an outside force has no clock of its own, in words; empty where it has. ``beside``: something was named
    before it, whose memory may be what is left: it leaves hardly a tone so pure that has another size and phase in
    every trial, and one with the same is a resonator. What changes along the record may be a memory too. ``before`` is
    the fit without it."""
    pure = before is not None and _pure(fit, before, OWN_LEAVES if changes(force) else FAR_ABOVE_NOISE)
    said = "" if pure else _own_motion(level, fit, force)
    said = said or ("" if level.trials == 1 and pure else _in_one_trial(level, fit, force))
    left = (beside and fit.misfit > FAR_ABOVE_NOISE) or (changes(force) and not pure)
    if said or not (left or beside):
        return said
    least = TIED if left else TIED_SURELY
    return _tied(level, fit, force, least) or (_tied(level, fit, force, least, 0.0) if _fades(fit, force) else "")


def _pure(fit: JointFit, before: JointFit, most: float) -> bool:
    """Whether an outside force leaves only noise, at most so many times, of what lay far above it: phases that agree,
    as those of two or three trials often do by chance, then say nothing."""
    return fit.misfit <= most and before.misfit - fit.misfit > PURE * (before.misfit - 1.0)


def _own_motion(level: Level, fit: JointFit, force: Addend) -> str:
    """Whether an outside force at the body's own frequency is what the equation leaves of the motion itself, in words:
    that keeps its phase to the release."""
    clock = _clock(fit, force)
    for member in level.members:
        theta = shared_theta(level, member, fit, member.motions[0].name)
        own = math.sqrt(max(theta[SLOT["k1"]] + theta[SLOT["ks"]], 0.0) / theta[SLOT["mass"]])
        if own > 0.0 and abs(clock / own - 1.0) < OWN_FREQUENCY:
            agree = _locked(level, fit, force)
            if agree >= LOCKED:
                return (
                    f"{force.prefix} at {clock:.3g} rad/s is the body's own motion of {own:.3g} rad/s: its phases in "
                    f"the trials are locked to the release by {100 * agree:.0f} %"
                )
            if fit.misfit > OWN_LEAVES:
                return (
                    f"{force.prefix} at {clock:.3g} rad/s, beside the body's own motion of {own:.3g} rad/s, leaves "
                    "more than noise: a body whose rate goes with its swing looks so"
                )
    return ""


def _locked(level: Level, fit: JointFit, force: Addend) -> float:
    """How far the phases of an outside force agree from trial to trial on each spring, their sign left out: 1 where
    every trial has the same or the opposite one, as what an equation leaves of the body's own motion has."""
    total, trials = 0.0, 0
    for member in level.members:
        sizes = [_size(fit, force, m.name) for m in member.motions]
        turned = [(one / abs(one)) ** 2 for one in sizes if abs(one) > 0.0]
        total, trials = total + abs(sum(turned)), trials + len(turned)
    return total / trials if trials > len(level.members) else 1.0


def _in_one_trial(level: Level, fit: JointFit, force: Addend) -> str:
    """Whether an outside force is distinct from zero in fewer than two trials, in words: one trial knows no clock."""
    told = 0
    for motion in (m for member in level.members for m in member.motions):
        places, counts = parts_of(fit, force, motion.name)
        errors = np.sqrt(np.diag(counts @ fit.solution.covariance[np.ix_(places, places)] @ counts.T))
        told += math.hypot(*(counts @ fit.solution.values[places] / np.maximum(errors, 1e-300))) > SIGNIFICANT
    if told >= CLOCKED:
        return ""
    return f"{force.prefix} is distinct from zero in {told} of {level.trials} trials; {CLOCKED} show a clock of its own"


def _fades(fit: JointFit, force: Addend) -> bool:
    """Whether an outside force dies out along every record, as what a memory leaves does: by the middle its phases may
    be any, and it is to be looked at where the record begins."""
    trials = [one.name for one in fit.solution.problem.trials]
    ends = [tuple(abs(_size(fit, force, name, share)) for share in (0.0, 1.0)) for name in trials]
    return changes(force) and all(last < FADED * first for first, last in ends)


def _tied(level: Level, fit: JointFit, force: Addend, least: float, at: float = 0.5) -> str:
    """Whether an outside force's phase is tied to the release on each spring, in words: sizes in units of the release
    and phases that agree after a share ``at`` of the record, as they do in fewer than ``least`` of random draws, are a
    memory's."""
    forces = [np.array([_size(fit, force, m.name, at) / m.amplitude for m in one.motions]) for one in level.members]
    total = sum(float(np.sum(np.abs(own) ** 2)) for own in forces)
    if total == 0.0:
        return ""

    def agreement(phased: list[np.ndarray]) -> np.ndarray:
        """Share (draws,) of the forces' squares that one force a spring, in units of the release, holds."""
        return np.asarray(sum(np.abs(own.sum(axis=-1)) ** 2 / own.shape[-1] for own in phased)) / total

    rng = np.random.default_rng(0)
    drawn = [own * np.exp(2j * math.pi * rng.random((DRAWS, own.size))) for own in forces]
    seen = float(agreement(forces))
    chance = float(np.mean(agreement(drawn) >= seen * (1.0 - 1e-12)))
    if chance >= least:
        return ""
    return (
        f"{force.prefix} is tied to the release: phases and sizes agree in all trials by {100 * seen:.0f} %, as "
        f"phases of its own would in {100 * chance:.0f} of 100 campaigns"
    )
