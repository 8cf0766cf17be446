"""Finished groups on disk, so that an interrupted run goes on where it stopped.

A group's findings are kept as JSON (numbers, texts) without its motions: recordings are read again, which is cheap.
Its name is a digest of everything that decides it: the group's task, the recordings' bytes and samples, the code, the
packages that calculate.

Belongs here: what a part holds. Does not belong here: the file around it (part_files.py), what a group's analysis is.
"""

from __future__ import annotations

import dataclasses
import hashlib
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from undertow import __version__
from undertow.campaign.run.analysis import GroupTask
from undertow.campaign.run.manifest import package_versions, source_digest
from undertow.campaign.run.part_files import FORMAT, read_part, write_part
from undertow.comparison.detectable import Detectable
from undertow.comparison.level import Addend
from undertow.comparison.tail import Histogram
from undertow.conditioning.motion import Motion
from undertow.discrepancy.findings import AugmentedRun, GroupFindings, TrialFindings
from undertow.discrepancy.judge import Judged
from undertow.discrepancy.mismatch import Mismatch
from undertow.discrepancy.verdict import Described, Gate, PhysicalCheck, Rejected, Verdict
from undertow.equation import registry
from undertow.equation.equation import Equation
from undertow.likelihood.fit import Fit
from undertow.quantities import Estimate
from undertow.uncertainty.growth import Grown


def digest(task: GroupTask) -> str:
    """Name of a group's finished findings: what decides it, hashed.

    The motions count with their samples, so that a changed unit, sign or window of the same file is another name; the
    code counts with its sources.
    """
    said = {f.name: getattr(task, f.name) for f in dataclasses.fields(task)}
    motions, terms = said.pop("motions"), said.pop("terms")
    made_by = f"{__version__} {FORMAT} {source_digest()} {sorted(package_versions().items())}"
    sums = hashlib.sha256(made_by.encode())
    sums.update(repr([(name, _sorted(value)) for name, value in said.items()]).encode())
    sums.update(repr([(t.name, _sorted(t.inner)) for t in terms]).encode())
    for motion in motions:
        _add_motion(motion, sums)
    return sums.hexdigest()[:20]


def _add_motion(motion: Motion, sums: Any) -> None:
    """A motion's samples, window, rest position and names, added to a hash."""
    recording = motion.recording
    about = (motion.name, recording.sha256, recording.coordinate, _sorted(recording.conditions), motion.window)
    sums.update(repr((*about, motion.equilibrium, motion.amplitude, _sorted(motion.noise))).encode())
    arrays = {"t": motion.t, "x": motion.x, "v": motion.v, "a": motion.a, "time": recording.time, **recording.channels}
    for name, values in sorted(arrays.items()):
        sums.update(name.encode() + np.ascontiguousarray(values).tobytes())


def _sorted(value: Any) -> Any:
    return sorted(value.items()) if isinstance(value, Mapping) else value


def level_digest(tasks: Sequence[GroupTask], also: str) -> str:
    """Name of the finished verdicts of groups that are judged together; ``also`` is what else decides them."""
    sums = hashlib.sha256(also.encode())
    for task in tasks:
        sums.update(digest(task).encode())
    return sums.hexdigest()[:20]


def save_verdicts(judged: Judged, path: Path) -> None:
    """Write the verdicts of one level, its trials' free runs and what was added to its equation."""
    kept = {name: [run.nrmse, run.residual.tolist(), run.as_measured] for name, run in judged.runs.items()}
    added = {"addends": _plain(judged.addends), "values": _plain(judged.values), "evidence": dict(judged.evidence)}
    write_part(path, {"verdicts": [_plain(v) for v in judged.verdicts], "runs": kept, **added})


def load_verdicts(tasks: Sequence[GroupTask], labels: Sequence[str], path: Path) -> Judged | None:
    """One level as saved, in the order of its groups (called ``labels``); None where none is there that fits."""
    data = read_part(path)
    if data is None:
        return None
    try:
        verdicts = tuple(_verdict(one, task) for one, task in zip(data["verdicts"], tasks, strict=True))
        runs = {name: AugmentedRun(run[0], np.array(run[1]), run[2]) for name, run in data["runs"].items()}
        values = {name: (float(value), float(error)) for name, (value, error) in data["values"].items()}
        evidence = {name: float(score) for name, score in data["evidence"].items()}
        addends = _made(tuple[Addend, ...], data["addends"])
        return Judged(verdicts, tuple(labels), addends, values, runs, evidence)
    except (LookupError, TypeError, ValueError, AttributeError):
        return None


def save(findings: GroupFindings, path: Path) -> None:
    """Write a group's findings; the file appears whole or not at all."""
    write_part(path, _plain(findings))


def _plain(value: Any) -> Any:
    if isinstance(value, GroupFindings):
        fields = ("dry", "held", "fits", "verdict", "notes", "grown", "equation_errors")
        out = {name: _plain(getattr(value, name)) for name in fields if hasattr(value, name)}
        terms = [[t.name, dict(t.inner)] for t in value.equation.terms]
        out["equation"] = [terms, list(value.equation.coefficients), value.equation.mass_kg, value.equation.rest_m]
        out["trials"] = [_plain(t) for t in value.trials]
        return out
    if isinstance(value, TrialFindings):
        return {
            "name": value.motion.name, "fits": _plain(value.fits), "nrmse": dict(value.nrmse),
            "mismatch": _plain(value.mismatch), "held_out": value.held_out, "t": value.t.tolist(),
            "measured": value.measured.tolist(), "simulated": value.simulated.tolist(),
            "as_measured": value.as_measured,
        }  # fmt: skip
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: _plain(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, tuple | list):
        return [_plain(v) for v in value]
    return value.item() if isinstance(value, np.generic) else value


def load(task: GroupTask, path: Path) -> GroupFindings | None:
    """A group's findings as saved, joined with its motions; None where there are none that fit."""
    data = read_part(path)
    if data is None:
        return None
    try:
        by_name = {t["name"]: t for t in data["trials"]}
        trials = tuple(_trial(by_name[m.name], m) for m in task.motions)
        terms, coefficients, mass, rest = data["equation"]
        equation = Equation(
            tuple(registry.find(name, **inner) for name, inner in terms), tuple(coefficients), mass, rest
        )
        return GroupFindings(
            task.key, task.dry, trials, task.specimen, task.structure, _made(dict[str, Fit], data["fits"]), equation,
            data["equation_errors"], _verdict(data["verdict"], task), tuple(data["notes"]),
            tuple(Grown(**one) for one in data["grown"]),
        )  # fmt: skip
    except (LookupError, TypeError, ValueError, AttributeError):
        return None


def _trial(data: Mapping[str, Any], motion: Any) -> TrialFindings:
    t, measured, simulated = (np.array(data[name], dtype=np.float64) for name in ("t", "measured", "simulated"))
    return TrialFindings(
        motion, _made(dict[str, Fit], data["fits"]), data["nrmse"], Mismatch(**data["mismatch"]), t, measured,
        simulated, data["held_out"], as_measured=data["as_measured"],
    )  # fmt: skip


@cache
def _reader(kind: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind)


def _made(kind: Any, data: Any) -> Any:
    """Plain values as what they were; ValueError where they are none of it."""
    return _reader(kind).validate_python(data)


_ESTIMATE = {f.name for f in dataclasses.fields(Estimate)}


def _revived(value: Any) -> Any:
    """Plain values with every mapping that has an estimate's fields made an estimate again, at any depth."""
    if isinstance(value, Mapping):
        return Estimate(**value) if set(value) == _ESTIMATE else {key: _revived(v) for key, v in value.items()}
    return [_revived(v) for v in value] if isinstance(value, list) else value


_KINDS: Mapping[str, Any] = {
    "trials": tuple[str, ...], "held_out": tuple[str, ...], "verdict": tuple[str, ...],
    "alternatives": tuple[tuple[str, ...], ...], "baseline": Described, "augmented": Described | None,
    "rejected": tuple[Rejected, ...], "physical_check": PhysicalCheck, "detectable": tuple[Detectable, ...],
    "not_testable": tuple[str, ...], "null": Histogram | None, "decision": tuple[Gate, ...],
}  # fmt: skip
"""What of a verdict is no number and no text."""


def _verdict(data: Mapping[str, Any], task: GroupTask) -> Verdict:
    made = {name: _made(kind, data[name]) for name, kind in _KINDS.items()}
    return Verdict(**(dict(data) | made | {"group": task.key, "parameters": _revived(data["parameters"])}))
