"""`fit`: an equation's numbers from trials, by output error.

Belongs here: from keyword arguments to the fit. Does not belong here: the fit itself (methods/baseline.py), what its
result can do (fitted.py).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Unpack

from numpy.typing import ArrayLike

from undertow.conditioning.motion import Motion
from undertow.discrepancy.words import own_words
from undertow.equation.equation import Equation
from undertow.equation.registry import EQUATION_15
from undertow.equation.term import Term
from undertow.errors import FAILURES, IdentificationError, RecordingError
from undertow.front.columns import Columns, Units
from undertow.front.fitted import Fitted
from undertow.front.known import RigAndRead, group_specimen, parted, terms_of, with_settings
from undertow.front.reading import Source, agreeing, read
from undertow.front.trials import Trials, in_pythons_words
from undertow.likelihood.fit import Specimen, Structure
from undertow.likelihood.problem import TrialOptions
from undertow.likelihood.scale import Anchor, choose_anchor, on_load_cells
from undertow.methods.baseline import GroupFit, fit_alone, fit_group, group_model
from undertow.methods.decay import load_cell_stiffness
from undertow.methods.dry import dry_fits, pooled_scatter, structural_terms, structure_from
from undertow.uncertainty.disagreement import OF_ONE_TRIAL, grown
from undertow.uncertainty.growth import grown_words
from undertow.uncertainty.repeats import mean_of_trials


@in_pythons_words
def fit(
    trials: Source, equation: Sequence[str | Term] | Equation = EQUATION_15, *, dry: Source | None = None,
    t: ArrayLike | Sequence[ArrayLike] | None = None, columns: Columns | None = None, units: Units | None = None,
    **more: Unpack[RigAndRead],
) -> Fitted:  # fmt: skip
    """The numbers of an equation from all trials together, by output error: each is simulated from its release.

    Parameters
    ----------
    trials : `Trials`, or recordings of one specimen in one water: all that `undertow.read` takes, arrays with ``t`` and
        ``units``.
    equation : names of its terms beside the inertia (`undertow terms`), terms of your own, or an `Equation`, of which
        the terms count. Eq. 15 of the report where nothing is said.
    dry : trials of the structure alone, on the same spring: their k, c and mu are then held, with their errors and
        their scatter from trial to trial; ``mass_kg`` must be known.
    t, columns, units : of ``trials``, as of `undertow.read`.
    more : what is known of the rig (`Rig`), as ``mass_kg=2637.4, area_m2=0.97``, and what else `undertow.read` takes,
        as ``rate_hz=100.0``.

    A free decay gives ratios to the total mass only. Kilograms come from, in this order: dry trials with a mass; a
    stated stiffness; a mass where the equation has no added mass; load cells. Else every number is per total mass, and
    the result says so.

    Raises IdentificationError where the equation's motion leaves every bound or what is known of the rig contradicts
    the channels of every trial, ConfigError for a term that is not known.

    >>> import undertow
    >>> law = {"stiffness": 400.0, "viscous_damping": 2.0}
    >>> runs = [undertow.simulate(law, x0=x0, mass_kg=4.0, rate_hz=100.0, duration_s=6.0) for x0 in (0.05, 0.1)]
    >>> trials = [run.recorded(noise_m=1e-4, seed=i, name=f"r{i}") for i, run in enumerate(runs)]
    >>> found = undertow.fit(trials, ["stiffness", "viscous_damping"], mass_kg=4.0)
    >>> found.parameters["value"].round(1).to_dict()
    {'k_N_per_m': 400.0, 'c_Ns_per_m': 2.0}
    >>> print(round(found.score(), 2))
    1.0
    """
    reading, rig = parted(more)
    given = read(trials, columns, units, t=t, **reading)
    terms = terms_of(equation)
    used = agreeing(given, config := with_settings(given.config, {"specimen": rig}))
    specimen = group_specimen(config, [m.recording.conditions for m in used])
    motions = sorted(used, key=lambda m: (m.amplitude, m.name))
    structure = None if dry is None else _structure(dry_trials(dry), terms, specimen)
    anchor, notes = _anchor(specimen, structure, motions, terms)
    specimen = on_load_cells(specimen, anchor)
    model = group_model(terms, motions, specimen, structure, dry=False, anchored=anchor.known)
    if not model.coefficients:
        raise IdentificationError(
            f"{', '.join(t.name for t in terms)} has no unknown left: all of it comes from dry trials; add a law of "
            "the water, as added_mass"
        )
    if structure is not None and (own := own_words(model.scattering)):
        notes += (f"{own} {'are' if ' ' in own else 'is'} held as {structure.source} gave them, with their scatter",)
    options = TrialOptions()
    if structure is not None and structure.mu.value > 0.0:
        options = TrialOptions(rest_offset_std=structure.mu.value * specimen.normal_force_N / structure.k.value)
    found = fit_group(model, motions, options, "none" if structure is None else "trials and means")
    found, differ = _grown(found, motions, options)
    ordered = replace(used, motions=tuple(motions))
    return Fitted(ordered, found, anchor, structure, notes + differ)


def _grown(found: GroupFit, motions: Sequence[Motion], options: TrialOptions) -> tuple[GroupFit, tuple[str, ...]]:
    """The fit with errors that hold how much its trials differ, each fitted alone; and what is to be said of that."""
    if len(motions) < 2:
        return found, (OF_ONE_TRIAL,)
    alone, amplitudes = [], []
    for motion in motions:
        with suppress(*FAILURES):
            alone.append(fit_alone(found, motion, options).estimates)
            amplitudes.append(motion.amplitude)
    estimates, differ = grown(found.estimates, alone, amplitudes)
    return replace(found, estimates=estimates), grown_words(differ)


def dry_trials(dry: Source) -> Trials:
    """The dry trials; RecordingError, which says that ``dry`` is meant, where they cannot be read."""
    try:
        return read(dry)
    except RecordingError as error:
        said = str(error).replace("source is", "dry is").partition("; give paths, ")[0]
        raise RecordingError(
            f"{said}; t, columns and units are of trials alone: give dry=undertow.read(dry, t=..., units=...)"
        ) from error


def _structure(dry: Trials, terms: Sequence[Term], specimen: Specimen) -> Structure:
    """k, c, mu of the dry trials, each fitted alone; IdentificationError without a mass or a trial that can be."""
    if not math.isfinite(specimen.mass_kg):
        raise IdentificationError(
            f"dry holds {len(dry)} trials but mass_kg is {specimen.mass_kg}; a dry trial gives kilograms from the "
            "known mass: give mass_kg=..."
        )
    alone = replace(specimen, submerged_volume_m3=0.0, area_m2=0.0)
    fits = dry_fits(dry.motions, structural_terms(terms), alone, TrialOptions())
    return structure_from(fits, pooled_scatter([fits]))


def _anchor(
    specimen: Specimen, structure: Structure | None, motions: Sequence[Motion], terms: Sequence[Term]
) -> tuple[Anchor, tuple[str, ...]]:
    """What gives kilograms, and what to know of it."""
    cells = None
    if all({"spring_force", "displacement"} <= set(m.recording.channels) for m in motions):
        slopes = [load_cell_stiffness(m) for m in motions]
        cells = mean_of_trials(slopes, "N/m", "load cells")
    anchor = choose_anchor(specimen, structure, cells, added_mass=any(t.is_inertia for t in terms))
    notes = []
    if not anchor.known and math.isfinite(specimen.mass_kg):
        notes.append(
            f"mass_kg = {specimen.mass_kg:g} alone cannot part the body's mass from added mass: give "
            "stiffness_N_per_m or dry trials, or leave added_mass out"
        )
    return anchor, tuple(notes)
