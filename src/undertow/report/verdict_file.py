"""verdict.json: what a machine reads of a campaign (contract 2).

Belongs here: verdicts as plain JSON, and what is said of a run folder whose files somebody changed. Does not belong
here: how they were reached (discrepancy/).
"""

from __future__ import annotations

import dataclasses
import json
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from textwrap import indent
from typing import Any

import numpy as np

from undertow.discrepancy.verdict import Described, Verdict
from undertow.errors import ConfigError, UndertowError
from undertow.quantities import Estimate

CONTRACT = 2
"""Version of verdict.json's shape."""


def plain(value: object) -> Any:
    """A value as JSON knows it: estimates as value, stderr (total) and unit; what is not finite as None.

    Raises UndertowError for a value JSON cannot hold.

    >>> plain({"mass_kg": Estimate(288.0, 20.0, unit="kg"), "because": float("nan")})
    {'mass_kg': {'value': 288.0, 'stderr': 20.0, 'unit': 'kg'}, 'because': None}
    """
    if isinstance(value, Estimate):
        return {"value": plain(value.value), "stderr": plain(value.total_stderr), "unit": value.unit}
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, np.generic):
        return plain(value.item())
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if value is None or isinstance(value, (bool, int, str)):
        return value
    raise UndertowError(
        f"verdict.json cannot hold {value!r} of type {type(value).__name__}; give numbers, texts, estimates, or "
        "lists and mappings of them"
    )


def group_json(verdict: Verdict) -> dict[str, Any]:
    """One group's entry."""
    entry: dict[str, Any] = plain({
        "group": verdict.group,
        "trials": verdict.trials,
        "held_out": verdict.held_out,
        "status": verdict.status,
        "verdict": verdict.verdict,
        "alternatives": verdict.alternatives,
        "confidence": verdict.confidence,
        "posterior": verdict.posterior,
        "because": verdict.because,
        "decision": [
            {"gate": g.gate, "statistic": g.statistic, "value": g.value, "limit": g.limit, "passed": g.passed,
             "because": "" if g.passed else g.because}
            for g in verdict.decision
        ],
        "p_value": verdict.p_value,
        "upper_bound": verdict.upper_bound,
        "detectable": [dataclasses.asdict(one) for one in verdict.detectable],
        "not_testable": verdict.not_testable,
        "origin": verdict.origin,
        "parameters": verdict.parameters,
        "baseline": _described(verdict.baseline),
        "augmented": None if verdict.augmented is None else _described(verdict.augmented),
        "sensor_floor_nrmse": verdict.sensor_floor_nrmse,
        "repeatability_nrmse": verdict.repeatability_nrmse,
        "rejected": [{"name": suspect.name, "because": suspect.because} for suspect in verdict.rejected],
        "physical_check": dataclasses.asdict(verdict.physical_check),
        "transfer": verdict.transfer,
        "next_test": verdict.next_test,
        "sentence": verdict.sentence,
    })  # fmt: skip
    return entry


def _described(one: Described) -> dict[str, Any]:
    known = {"cross_validated_nrmse": one.cross_validated_nrmse} if math.isfinite(one.cross_validated_nrmse) else {}
    return {"nrmse": one.nrmse, "held_out_nrmse": one.held_out_nrmse, **known, "parameters": one.parameters}


def verdict_pieces(groups: Iterable[Mapping[str, Any]], sentence: str) -> Iterator[str]:
    """The text of verdict.json, group by group (`group_json`), with the sentence over all groups.

    >>> json.loads("".join(verdict_pieces([{"verdict": ["relaxation"]}], "One."))) == {
    ...     "contract": 2, "groups": [{"verdict": ["relaxation"]}],
    ...     "across_groups": {"verdict": ["relaxation"], "sentence": "One."}}
    True
    """
    names: Counter[str] = Counter()
    yield f'{{\n  "contract": {CONTRACT},\n  "groups": ['
    before = ""
    for group in groups:
        names.update(group["verdict"] if group.get("status") != "present_but_small" else ())
        yield f"{before}\n{indent(_text(group), '    ')}"
        before = ","
    across = {"verdict": [name for name, _ in names.most_common()], "sentence": sentence}
    end = "\n  " if before else ""
    yield f'{end}],\n  "across_groups": {indent(_text(across), "  ").lstrip()}\n}}\n'


def read_verdicts(folder: Path) -> dict[str, Any]:
    """verdict.json of a run folder, checked as far as every reader needs it: this contract's, with groups.

    Raises UndertowError where the folder holds no finished run (ConfigError: no such file), or one that was written
    under another contract.

    >>> try:
    ...     read_verdicts(Path("no_such_run"))
    ... except UndertowError as said:
    ...     print(str(said).partition(";")[0])
    run folder no_such_run: verdict.json cannot be read: No such file or directory
    """
    path = folder / "verdict.json"
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        for group in content["groups"]:
            if not {"group", "status", "verdict", "baseline"} <= set(group):
                raise KeyError("group, status, verdict, baseline")
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as reason:
        why = getattr(reason, "strerror", None) or f"it is not a run's verdict ({type(reason).__name__})"
        kind = ConfigError if isinstance(reason, OSError) else UndertowError
        raise kind(
            f"run folder {folder}: {path.name} cannot be read: {why}; give a folder that `undertow run` finished"
        ) from reason
    if content.get("contract") != CONTRACT:
        raise UndertowError(
            f"run folder {folder}: {path.name} follows contract {content.get('contract')!r}, this undertow reads "
            f"{CONTRACT}; run the campaign again with it"
        )
    return dict(content)


def _text(value: Mapping[str, Any]) -> str:
    return json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False)


def must_be_there(runs: Sequence[Path]) -> None:
    """ConfigError where one of these run folders is not there."""
    gone = next((run for run in runs if not run.exists()), None)
    if gone is not None:
        raise ConfigError(f"run folder {gone} is not there; give that of the report that `undertow run` ends with")


@contextmanager
def as_runs_write_them(runs: Sequence[Path], file: str = "verdict.json") -> Iterator[None]:
    """Within the block that file of these run folders is read and used, nothing else.

    Raises UndertowError where a value is missing or of another kind than a run writes, as `must_be_there`.
    """
    must_be_there(runs)
    page = next((run for run in runs if not run.is_dir()), None)
    if page is not None:
        raise ConfigError(f"run folder {page} is a file; give the folder it stands in, {page.parent}")
    try:
        yield
    except UndertowError:
        raise
    except (LookupError, TypeError, AttributeError, ValueError) as reason:
        named = ", ".join(str(run) for run in runs)
        raise UndertowError(
            f"run folder {named}: {file} is not as a run writes it ({type(reason).__name__}: {reason}); was it "
            "changed? run again"
        ) from reason
