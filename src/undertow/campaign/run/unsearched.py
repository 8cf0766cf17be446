"""What is said of a group before anything is searched: whether its equation explains its trials, and where it does not.

Belongs here: that verdict and its sentence. Does not belong here: suspects and their verdicts (discrepancy/).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from undertow.discrepancy.findings import TrialFindings
from undertow.discrepancy.validation import median_error
from undertow.discrepancy.verdict import Described, Verdict
from undertow.discrepancy.words import count, group_title, percent
from undertow.quantities import Estimate
from undertow.recording.recording import Condition


def unsearched_verdict(
    key: Mapping[str, Condition],
    held_out: tuple[str, ...],
    trials: Sequence[TrialFindings],
    parameters: Mapping[str, Estimate],
) -> Verdict:
    """Before suspects are searched: nobody can tell, with the mismatch's place."""
    missing = [t for t in trials if t.mismatch.missing]
    open_trials = [t for t in trials if not t.held_out]
    held = [t for t in trials if t.held_out]
    typical = median_error([t.mismatch.nrmse for t in open_trials])
    described = Described(
        typical, median_error([t.mismatch.nrmse for t in held]), parameters
    )
    limit = median_error([t.mismatch.repeatability_nrmse for t in trials])
    sentence = _sentence(group_title(key), missing, trials, typical, limit)
    return Verdict(
        key,
        tuple(t.motion.name for t in trials),
        held_out,
        "cannot_tell",
        baseline=described,
        sensor_floor_nrmse=median_error([t.mismatch.sensor_floor_nrmse for t in trials]),
        repeatability_nrmse=limit,
        sentence=sentence,
        because="nothing was looked for yet",
    )


def _sentence(
    label: str, missing: Sequence[TrialFindings], trials: Sequence[TrialFindings], typical: float, limit: float
) -> str:
    if not missing:
        return (
            f"{label}: the equation explains {count(len(trials), 'trial')} "
            f"(error {percent(typical)}, repeatability {percent(limit)})."
        )
    worst = max(missing, key=lambda t: t.mismatch.nrmse / t.mismatch.repeatability_nrmse)
    m = worst.mismatch
    parts = {"first": m.share_early, "second": m.share_middle, "last": m.share_late}
    where = max(parts, key=lambda part: parts[part] if math.isfinite(parts[part]) else -1.0)
    line = ""
    if math.isfinite(m.line_frequency_hz) and m.line_share > 0.2:
        line = f", {percent(m.line_share)} of it in a line at {m.line_frequency_hz:.2f} Hz"
    return (
        f"{label}: the equation does not explain {len(missing)} of {len(trials)} trials; worst {worst.motion.name}, "
        f"which it misses by {percent(m.nrmse)} (repeatability {percent(m.repeatability_nrmse)}), most in the "
        f"{where} third of the motion{line}."
    )
