"""What `diagnose` says of one group: verdict, repaired equation, tables and figures.

Belongs here: the frozen result, and the repaired equation from a verdict's numbers. Does not belong here: the search.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from html import escape
from typing import Any

import numpy as np
import pandas as pd

from undertow.campaign.run.equations import own_scatter
from undertow.discrepancy.findings import GroupFindings, TrialFindings
from undertow.discrepancy.repaired import repaired_equation, repaired_errors
from undertow.discrepancy.verdict import Status, Verdict
from undertow.equation.equation import Equation
from undertow.errors import IdentificationError
from undertow.front.found_equation import FoundNumbers
from undertow.front.prediction import scatter_of
from undertow.front.tables import parameter_lines
from undertow.front.trials import Trials
from undertow.likelihood.scale import structural_parameters
from undertow.quantities import OK, Estimate
from undertow.recording.recording import Array, Condition
from undertow.report.trial_curves import Axes, draw_runs_before_and_after, new_axes
from undertow.report.trial_figures import draw_residual, with_words
from undertow.uncertainty.posterior import Draws
from undertow.uncertainty.seeds import random_numbers


@dataclass(frozen=True, eq=False, repr=False)
class DiagnosedGroup(FoundNumbers):
    """One group's verdict with its numbers. ``findings`` holds everything, trial by trial."""

    findings: GroupFindings
    trials: Trials

    @property
    def verdict(self) -> Verdict:
        """Everything that verdict.json says of the group."""
        return self.findings.verdict

    @property
    def label(self) -> str:
        """The group's conditions in words."""
        return self.findings.label

    @property
    def conditions(self) -> Mapping[str, Condition]:
        """The group's conditions by name."""
        return dict(self.findings.key)

    @property
    def status(self) -> Status:
        """explained, nothing_missing, present_but_small, unknown, not_identifiable or cannot_tell."""
        return self.verdict.status

    @property
    def names(self) -> tuple[str, ...]:
        """What is missing, the strongest first."""
        return self.verdict.verdict

    @property
    def sentence(self) -> str:
        """What was found, in plain words."""
        return self.verdict.sentence

    @property
    def notes(self) -> tuple[str, ...]:
        """What a reader should know before using the numbers."""
        return self.findings.notes

    @property
    def error_after(self) -> float:
        """Free-run error with what was found; nan where nothing is named."""
        return self.verdict.augmented.nrmse if self.verdict.augmented is not None else math.nan

    @property
    def row(self) -> dict[str, Any]:
        """The group's row of a table of verdicts."""
        verdict = self.verdict
        return {
            "status": verdict.status, "missing": ", ".join(verdict.verdict), "confidence": verdict.confidence,
            "error": verdict.baseline.nrmse, "error_repaired": self.error_after,
            "held_out_error": verdict.baseline.held_out_nrmse,
            "held_out_repaired": verdict.augmented.held_out_nrmse if verdict.augmented else math.nan,
            "left_out_error": verdict.baseline.cross_validated_nrmse,
            "left_out_repaired": verdict.augmented.cross_validated_nrmse if verdict.augmented else math.nan,
            "allowed": verdict.repeatability_nrmse, "trials": len(verdict.trials), "sentence": verdict.sentence,
        }  # fmt: skip

    @property
    def estimates(self) -> dict[str, Estimate]:
        """Numbers of the repaired equation; of the prescribed one, by output error, where nothing is named."""
        plain = self.findings.fits.get("output_error")
        found = dict(self.verdict.baseline.parameters if plain is None else plain.parameters)
        found = found if self.verdict.augmented is None else dict(self.verdict.augmented.parameters)
        structure = self.findings.structure
        if structure is not None:
            held = structural_parameters(structure, self.findings.specimen)
            found |= {name: one for name, one in held.items() if name not in found}
        return found

    @property
    def trial_table(self) -> pd.DataFrame:
        """One row a trial: free-run error, what sensors and repetitions allow, error after, held out or not."""
        rows = [
            {
                "error": one.mismatch.nrmse, "error_repaired": one.augmented.nrmse if one.augmented else math.nan,
                "sensors": one.mismatch.sensor_floor_nrmse, "allowed": one.mismatch.repeatability_nrmse,
                "missing": one.mismatch.missing, "held_out": one.held_out, "amplitude": one.motion.amplitude,
            }
            for one in self.findings.trials
        ]  # fmt: skip
        return pd.DataFrame(rows, index=pd.Index([t.motion.name for t in self.findings.trials], name="trial"))

    @property
    def prescribed(self) -> Equation:
        """The prescribed equation with its numbers."""
        return self.findings.equation

    @cached_property
    def repaired(self) -> Equation:
        """The prescribed equation with what was found and all numbers refitted; the prescribed where nothing is named.

        Raises IdentificationError where what was found is no law of motion (a clock, a gain, a release), or has numbers
        of its own in each trial.
        """
        return repaired_equation(self.prescribed, self.verdict, self.findings.specimen)

    @property
    def equation(self) -> Equation:
        """The repaired equation, which is handed over."""
        return self.repaired

    def _own_score(self) -> float:
        """The score on the trials that were held out, or left out in turn, on all where none was."""
        table, apart = self.trial_table, self.row["left_out_repaired"]
        if math.isfinite(apart) and not table["held_out"].any():
            return 1.0 - float(apart)
        rows = table[table["held_out"]] if table["held_out"].any() else table
        return 1.0 - float(rows["error_repaired"].fillna(rows["error"]).mean())

    def theta_draws(self, draws: int, rng: np.random.Generator) -> tuple[Array, Mapping[str, float], str]:
        """Parameter vectors (draws, slots) as the numbers' errors spread them, each number for itself."""
        thetas = []
        for _ in range(draws):
            drawn = {
                name: replace(e, value=e.value + np.nan_to_num(e.total_stderr) * rng.standard_normal())
                for name, e in self.estimates.items()
            }
            described = replace(self.verdict.augmented or self.verdict.baseline, parameters=drawn)
            verdict = replace(self.verdict, augmented=described)
            thetas.append(repaired_equation(self.prescribed, verdict, self.findings.specimen).theta())
        stated = self.trials.config.specimen.scatter
        known = own_scatter(self.findings) if stated is None else dict(stated)
        return np.array(thetas), *scatter_of(self.findings.structure, known)

    def _errors(self) -> Mapping[str, float]:
        """Standard errors of the equation's coefficients by term name."""
        found = self.findings
        return repaired_errors(found.equation, found.equation_errors, found.verdict, found.specimen)

    def posterior(self, draws: int = 1000, seed: int = 0) -> Draws:
        """Draws of the repaired equation's numbers from the normal distribution of their errors and correlations.

        Laplace, without weights; a number without an error bar is left out. Raises IdentificationError where no number
        has one, or ``draws`` is below 2.
        """
        described = self.verdict.augmented or self.verdict.baseline
        known = {name: e for name, e in self.estimates.items() if 0.0 < e.total_stderr < math.inf}
        if draws < 2 or not known:
            raise IdentificationError(
                f"{self.label}: {draws} draws of {len(known)} numbers with an error bar; a posterior needs at least 2 "
                "draws of one number"
            )
        together = np.array([
            [1.0 if a == b else described.correlations.get(a, {}).get(b, 0.0) for b in known] for a in known
        ])  # fmt: skip
        size = np.array([e.total_stderr for e in known.values()])
        drawn = random_numbers(seed).multivariate_normal(
            np.zeros(size.size), together, draws, check_valid="ignore", method="eigh"
        )  # fmt: skip
        values = {name: e.value + s * z for (name, e), s, z in zip(known.items(), size, drawn.T, strict=True)}
        return Draws(values, float(draws), draws, OK)

    def plot(self, axes: Axes | None = None, trial: int | str | None = None) -> Axes:
        """Measured motion, the free runs of the prescribed equation and of that with more, the allowance as a band.

        The trial that shows it best where none is named: of the held-out ones that with the largest error.
        """
        axes = new_axes() if axes is None else axes
        return draw_runs_before_and_after(self._one(trial), axes, with_words(self.verdict))

    def plot_residual(self, axes: Axes | None = None, trial: int | str | None = None) -> Axes:
        """Measured less free run, before and after, with what repetitions allow in grey; returns the Axes."""
        return draw_residual(self._one(trial), new_axes() if axes is None else axes)

    def _one(self, trial: int | str | None) -> TrialFindings:
        found = self.findings.trials
        names = [one.motion.name for one in found]
        if trial in names:
            return found[names.index(str(trial))]
        if isinstance(trial, int) and -len(found) <= trial < len(found):
            return found[trial]
        if trial is not None:
            raise IdentificationError(f"no trial is called {trial!r} in {self.label}; there are {', '.join(names)}")
        unseen = [one for one in found if one.held_out] or list(found)
        return max(unseen, key=lambda one: one.mismatch.nrmse)

    def __repr__(self) -> str:
        return "\n".join([self.sentence, *parameter_lines(self.estimates), *(f"- {note}" for note in self.notes)])

    def _repr_html_(self) -> str:
        table = self.parameters.to_html(border=0, float_format=lambda value: f"{value:.5g}", na_rep="-")
        rejected = "".join(
            f"<li>not {escape(one.name)}: {escape(one.because)}</li>" for one in self.verdict.rejected
        )
        notes = "".join(f"<li>{escape(note)}</li>" for note in self.notes)
        return f"<div><p>{escape(self.sentence)}</p>{table}<ul>{notes}{rejected}</ul></div>"
