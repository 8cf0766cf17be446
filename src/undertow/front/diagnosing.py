"""`diagnose`: what an equation leaves out, group by group, by the same course as `undertow run`.

Belongs here: from keyword arguments to that course, and its findings as a user handles them. Does not belong here: the
search (discrepancy/, comparison/), one group's result (diagnosed.py).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Unpack

import pandas as pd
from numpy.typing import ArrayLike

from undertow.campaign.config import RunConfig
from undertow.campaign.run import Read, run
from undertow.discrepancy.findings import FailedTrial, Findings
from undertow.equation.equation import Equation
from undertow.equation.registry import names as registered
from undertow.equation.term import Term
from undertow.errors import ConfigError, IdentificationError
from undertow.front.columns import Columns, Units
from undertow.front.diagnosed import DiagnosedGroup
from undertow.front.fitting import dry_trials
from undertow.front.known import RigAndRead, parted, terms_of, with_settings
from undertow.front.reading import Source, read
from undertow.front.trials import Trials
from undertow.front.verdicts import Verdicts
from undertow.recording.patterns import Patterns
from undertow.recording.recording import Condition


@dataclass(frozen=True, eq=False, repr=False)
class Diagnosis(Verdicts[DiagnosedGroup]):
    """What is said of every group of trials: a sequence of `DiagnosedGroup`, dry groups first.

    ``findings`` is what `undertow run` writes its report from; ``across_groups`` the sentence over all groups;
    ``failed`` the trials that could not be used.
    """

    findings: Findings
    groups: tuple[DiagnosedGroup, ...]

    @property
    def failed(self) -> tuple[FailedTrial, ...]:
        """Trials that could not be used, each with the reason."""
        return self.findings.failed

    @property
    def doubts(self) -> tuple[str, ...]:
        """What does not belong together in the recordings, or is no body's, a sentence each."""
        return self.findings.doubts

    @property
    def across_groups(self) -> str:
        """The sentence over all groups; empty where there is one."""
        return self.findings.across_groups

    @property
    def parameters(self) -> pd.DataFrame:
        """Parameters of every group's repaired equation (of the prescribed one where nothing is named)."""
        return pd.concat({group.label: group.parameters for group in self.groups}, names=["group"])

    def __repr__(self) -> str:
        lines = [group.sentence for group in self.groups]
        lines += [self.across_groups] if self.across_groups else []
        lines += [f"doubt: {one}" for one in self.doubts]
        return "\n".join([*lines, *(f"not used: {one.reason}" for one in self.failed)])


MEDIUM = "medium"
"""Condition that tells dry trials, given as such, from the others."""


def diagnose(
    trials: Source,
    equation: Sequence[str | Term] | Equation | None = None,
    *,
    t: ArrayLike | Sequence[ArrayLike] | None = None,
    columns: Columns | None = None,
    units: Units | None = None,
    group_by: Sequence[str] | None = None,
    dry: Mapping[str, Condition] | Source | None = None,
    hold_out: Any = None,
    suspects: Sequence[str] | None = None,
    scatter: Mapping[str, float] | None = None,
    budget: float | None = None,
    seed: int | None = None,
    jobs: int = 1,
    **more: Unpack[RigAndRead],
) -> Diagnosis:
    """What an equation leaves out of these trials, and how sure: the search that `undertow run` does.

    Parameters
    ----------
    trials : `Trials`, or all that `undertow.read` takes, arrays with ``t`` and ``units``. `undertow.load` brings a
        config's settings along, which the arguments replace.
    equation : names of the prescribed equation's terms, or terms; the trials' config's, which is Eq. 15, where nothing
        is said. A law of your own needs `slots`: the search is done by the compiled integrator.
    t, columns, units : of ``trials``, as of `undertow.read`.
    group_by : conditions that a group shares; none: all trials are one group.
    dry : conditions of the trials without water, as ``{"water_depth_m": 1.63}``; or those trials, as `undertow.fit`
        takes them, beside which ``trials`` are all in water.
    hold_out : trials that are never fitted: "auto", a list of names, {"every": n} or {"largest": n}.
    suspects : names of what may be missing; all of them where nothing is said.
    scatter : relative standard deviation of k, c, mu from trial to trial, where it is known.
    budget : how much a search may do, in multiples of the default.
    seed : of the replicas, repetitions and everything else that is drawn; the config's where nothing is said.
    jobs : processes (0: one a core).
    more : what is known of the rig (`Rig`), as ``mass_kg=2637.4``, a number or a table by a condition; and what else
        `undertow.read` takes, as ``rate_hz=100.0``.

    Raises ConfigError where the settings are wrong, IdentificationError for a law without slots, UndertowError where no
    group can be identified.

    >>> import undertow
    >>> law = {"stiffness": 400.0, "viscous_damping": 1.0, "cubic_stiffness": 4000.0}
    >>> runs = [undertow.simulate(law, x0=x0, mass_kg=4.0, rate_hz=60.0, duration_s=6.0) for x0 in (0.04, 0.08, 0.1)]
    >>> trials = [run.recorded(noise_m=1e-4, seed=i, name=f"r{i}") for i, run in enumerate(runs)]
    >>> found = diagnose(trials, ["stiffness", "viscous_damping"], mass_kg=4.0, stiffness_N_per_m=400.0,
    ...                  suspects=["cubic_stiffness"], scatter={"k": 0.001, "c": 0.05})
    >>> found[0].status, found[0].names
    ('explained', ('cubic_stiffness',))
    """
    reading, rig = parted(more)
    given = read(trials, columns, units, t=t, **reading)
    if dry is not None and not isinstance(dry, Mapping):
        given, group_by, dry = _beside_dry(given, dry_trials(dry), group_by)
    terms = terms_of(equation) if equation is not None else terms_of(given.config.equation.terms)
    unplaced = [term.name for term in terms if not term.slots]
    if unplaced:
        raise IdentificationError(
            f"equation has {', '.join(unplaced)}, a law of your own without slots, and what is missing is searched for "
            "beside laws of the registry alone; compare undertow.fit(...).score(unseen) with it and without"
        )
    known = [term.name for term in terms if term.name in registered()]
    config = with_settings(
        given.config,
        {
            "specimen": {**rig, "scatter": scatter},
            "trials": {"group_by": group_by, "dry": dry, "hold_out": hold_out},
            "equation": {"terms": known or None},
            "discrepancy": {"suspects": suspects, "budget": budget},
        },
        seed=seed,
    )
    _must_be_there(given, config, hold_out, dry)
    own = terms if any(term.name not in registered() for term in terms) else None
    findings = run(config, jobs, given=Read(given.motions, given.failed, given.accepted, given.found), terms=own)
    groups = tuple(DiagnosedGroup(group, _of_group(given, group.verdict.trials, config)) for group in findings.groups)
    return Diagnosis(findings, groups)


def _beside_dry(
    given: Trials, dry: Trials, group_by: Sequence[str] | None
) -> tuple[Trials, list[str], dict[str, Condition]]:
    """All trials, of which a condition says whether they are in air, and by which conditions they are grouped."""
    taken = {motion.name for motion in given}

    def marked(trials: Trials, medium: str) -> Trials:
        motions = []
        for m in trials:
            name = f"dry_{m.name}" if medium == "air" and m.name in taken else m.name
            conditions = {**m.recording.conditions, MEDIUM: medium}
            motions.append(replace(m, recording=replace(m.recording, name=name, conditions=conditions)))
        return replace(trials, motions=tuple(motions))

    groups = given.config.trials.group_by if group_by is None else group_by
    return marked(given, "water") + marked(dry, "air"), [*groups, MEDIUM], {MEDIUM: "air"}


def _must_be_there(given: Trials, config: RunConfig, hold_out: Any, dry: Mapping[str, Condition] | None) -> None:
    """ConfigError where trials are held out, or are dry, of which there are none: nothing would be proved by them."""
    names = [motion.name for motion in given]
    listed = [hold_out] if isinstance(hold_out, str) and hold_out != "auto" else hold_out
    for one in listed if isinstance(listed, list | tuple) else ():
        if not any(Patterns([str(one)]).fit(name, name) for name in names):
            raise ConfigError(f"hold_out names {one!r}, and no trial is called so; there are {', '.join(names)}")
    if dry and not any(config.is_dry(motion.recording.conditions) for motion in given):
        raise ConfigError(f"dry says {dict(dry)}, and no trial has these conditions; correct it or leave it out")


def _of_group(given: Trials, names: Sequence[str], config: RunConfig) -> Trials:
    return Trials(tuple(m for m in given if m.name in names), config, (), given.accepted, given.found)
