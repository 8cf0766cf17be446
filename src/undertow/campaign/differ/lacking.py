"""What one motion has beside an equation's form: laws that its own equation holds, or suspects that a search names.

Two ways lead to a name. The recording's own equation, found from the same library, may hold laws that the simulation's
form has not; or no such equation explains the recording, and a hidden state, an outside force or memory does
(discrepancy.diagnose, the simulation's form being what is known). The one that comes closer in free run is believed.

Belongs here: names of what is lacking on one recording. Does not belong here: the comparison (differ.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from undertow.comparison.level import Member, make_level
from undertow.comparison.limits import WORTH
from undertow.comparison.suspect import Scales, Suspect
from undertow.comparison.suspects import all_suspects
from undertow.conditioning.motion import Motion
from undertow.discrepancy.case import Case
from undertow.discrepancy.judge import judge
from undertow.discrepancy.verdict import Described, Verdict
from undertow.equation.kernel import SLOT
from undertow.equation.term import Term
from undertow.errors import IdentificationError
from undertow.likelihood.fit import Specimen
from undertow.likelihood.free_run import FreeRun, free_run, sensor_floor
from undertow.likelihood.problem import TrialOptions
from undertow.likelihood.scale import choose_anchor
from undertow.methods.baseline import GroupFit, fit_group, group_model
from undertow.quantities import Estimate

UNKNOWN = Specimen()
"""A specimen of which nothing is known: coefficients are per total mass."""

RESOLUTION = 0.01
"""Share of the motion below which one recording decides nothing: a sensor's gain and linearity, half a per cent each
way. Scatter from trial to trial is no limit here: the equation is fitted to this very trial."""

CLOSE = 2.0
"""An equation explains a motion when its free run stays within this many times what is allowed."""

UNEXPLAINED = 3.0
"""From this many times what is allowed on, what no name explains is said to be unknown."""

PER_KG = " per kg"
"""What the unit of a number over the total mass ends in."""

FORCES = ("N", "kg")
"""First letters of the units of what is linear in the total mass."""

SIGNIFICANT = 3.0
"""Two coefficients differ when they lie this many standard errors apart; one is there when it is so far from zero."""


def fitted(motion: Motion, terms: Sequence[Term], specimen: Specimen = UNKNOWN) -> GroupFit:
    """An equation of these terms fitted to one motion by output error; per total mass without an anchor."""
    anchored = choose_anchor(specimen, None).known
    model = group_model(tuple(terms), [motion], specimen, None, dry=False, anchored=anchored)
    return fit_group(model, [motion], TrialOptions())


def let_go(motion: Motion, fit: GroupFit) -> FreeRun:
    """The fitted equation let go from a motion's release."""
    return free_run(motion, fit.model.theta(fit.values), motion.equilibrium.total_stderr)


def allowed_error(motion: Motion, run: FreeRun) -> float:
    """nrmse below which nothing is looked for on one trial: its sensor's noise and `RESOLUTION`."""
    return math.hypot(sensor_floor(motion, run), RESOLUTION)


def judged(motion: Motion, terms: Sequence[Term], label: str, specimen: Specimen) -> Verdict:
    """What one motion needs beside an equation of these terms whose numbers are its own.

    The search is per total mass, which fixes the size of every unknown; what it finds is given in kilograms where the
    specimen's stiffness is known.
    """
    fit = fitted(motion, terms, replace(UNKNOWN, rotation=specimen.rotation))
    run = let_go(motion, fit)
    allowed = allowed_error(motion, run)
    member = Member(label, fit.model, (motion,), TrialOptions(), not motion.window.held)
    described = Described(run.nrmse, math.nan, fit.estimates)
    floor = sensor_floor(motion, run)
    case = Case({}, label, member, (), described, floor, allowed, int(run.nrmse > allowed), False, False)
    taken = {c.slot for c in fit.model.coefficients}
    scales = make_level([member]).scales
    suspects = [s for s in all_suspects() if _slot(s, scales) not in taken]
    return _in_kilograms(judge([case], suspects)[0], specimen)


def _slot(suspect: Suspect, scales: Scales) -> str:
    """Where in the integrator a suspect's coefficient stands; empty for one that is no term."""
    starts = suspect.starts(scales)
    additions = suspect.additions(scales, starts[0]) if starts else ()
    return additions[0].slot if additions else ""


def _in_kilograms(verdict: Verdict, specimen: Specimen) -> Verdict:
    """The verdict's parameters times the total mass where a known stiffness gives it, else said to be per kilogram."""
    if verdict.augmented is None:
        return verdict
    per_mass = verdict.augmented.parameters.get("k_N_per_m_per_mass")
    anchored = choose_anchor(specimen, None).known and per_mass is not None and per_mass.value > 0.0
    mass = specimen.stiffness_N_per_m / per_mass.value if anchored and per_mass is not None else 1.0

    def scaled(found: object) -> object:
        if isinstance(found, Mapping):
            return {name: scaled(one) for name, one in found.items()}
        if isinstance(found, list):
            return [scaled(one) for one in found]
        if isinstance(found, Estimate) and found.unit.startswith(FORCES):
            return found.scaled(mass, found.unit.removesuffix(PER_KG) + ("" if anchored else PER_KG))
        return found

    return replace(verdict, parameters={name: scaled(found) for name, found in verdict.parameters.items()})


def needs(motion: Motion, form: Sequence[Term], own: GroupFit, verdict: Verdict) -> tuple[tuple[str, ...], bool]:
    """Names of what a motion has beside the simulation's ``form``, and whether they come from its own equation.

    ``own`` is the equation found for the motion from the library, ``verdict`` what the search beside ``form`` says.
    Something unknown is said from `UNEXPLAINED` times what is allowed on: no rig is explained to the last per cent.
    """
    known = let_go(motion, fitted(motion, form))
    allowed = allowed_error(motion, known)
    if known.nrmse <= allowed:
        return (), True
    said = tuple(n for n in dict.fromkeys(verdict.verdict) if n != "unknown" or known.nrmse > UNEXPLAINED * allowed)
    searched = verdict.augmented.nrmse if verdict.augmented is not None else known.nrmse
    error = let_go(motion, own).nrmse
    if error > CLOSE * allowed or (error > allowed and error > searched):
        return said, False
    names = _further_laws(motion, form, own, error, allowed)
    return (names, True) if names else (said, False)


def _further_laws(
    motion: Motion, form: Sequence[Term], own: GroupFit, error: float, allowed: float
) -> tuple[str, ...]:
    """Laws of a motion's own equation that the form has not and that the free run does not do without, the one that is
    missed most first."""
    have = {t.name for t in form}
    found = []
    for term in own.model.terms:
        numbers = [own.estimates[c.name] for c in own.model.coefficients if c.term == term.name]
        if term.name in have or not all(abs(e.value) > SIGNIFICANT * _size(e) for e in numbers):
            continue
        rest = [t for t in own.model.terms if t.name != term.name]
        try:
            without = let_go(motion, fitted(motion, rest)).nrmse
        except IdentificationError:
            without = math.inf
        if math.sqrt(max(without**2 - error**2, 0.0)) > WORTH * allowed:
            found.append((without, term.missing_as or term.name))
    return tuple(name for _, name in sorted(found, reverse=True))


def more(recording: Motion, simulated: GroupFit, known: GroupFit, limit: float) -> tuple[str, ...]:
    """Losses of which the recording has more than the simulation, by more than errors and than a repeated test.

    ``known`` is the simulation's form of equation with the recording's numbers; ``limit`` the nrmse of a repetition.
    """
    own = let_go(recording, known).nrmse
    found = []
    losses = {t.name: t.missing_as or t.name for t in known.model.terms if t.dissipates}
    for c in known.model.coefficients:
        if c.term not in losses or c.name not in simulated.estimates:
            continue
        mine, theirs = simulated.estimates[c.name], known.estimates[c.name]
        if not theirs.value - mine.value > SIGNIFICANT * math.hypot(_size(mine), _size(theirs)):
            continue
        theta = known.model.theta(known.values)
        theta[SLOT[c.slot]] += c.factor * (mine.value - theirs.value)
        worse = free_run(recording, theta, recording.equilibrium.total_stderr).nrmse
        if math.sqrt(max(worse**2 - own**2, 0.0)) > limit:
            found.append(losses[c.term])
    return tuple(found)


def _size(estimate: Estimate) -> float:
    """Standard error, zero where there is none."""
    return estimate.total_stderr if math.isfinite(estimate.total_stderr) else 0.0
