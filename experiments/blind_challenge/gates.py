"""What each gate of the decision is worth: groups that it alone turns, and what would have been said without it.

A row keeps every gate with its value and whether it was passed. Where one gate alone was in the way, the verdict
without it is known: the names that the search had found, or that nothing is missing. Held against the truth it was
right or wrong.

Belongs here: that recount. Does not belong here: outcomes of what was said (judge.py), words (page.py).
"""

from collections import Counter
from dataclasses import replace

from experiments.blind_challenge.judge import CaseResult, holds, judge

OF_NAMES = ("p_value", "comes_closer", "outweighed", "described", "dry_trials_agree", "twice_the_scatter")
OF_GREEN = (
    "search_ended", "p_value", "structure_known", "scatter_known", "nothing_left", "upper_bound",
)  # fmt: skip
OF_UNKNOWN = ("more_than_noise", "search_ended", "twice_the_scatter")
OF_ALL = ("channels_agree",)
NAMED_BY = "log odds of "


def _before(gates: dict[str, dict[str, object]], status: str) -> tuple[dict[str, object], tuple[str, ...]]:
    """What stood before the gates (as a verdict), and which gates could bar it."""
    if "outweighed" in gates:
        names = str(gates["evidence"]["statistic"]).removeprefix(NAMED_BY).partition(" over")[0].split("+")
        barring = (*OF_NAMES, *OF_ALL)
        if float(str(gates["structure_known"]["value"])) and status == "unknown":
            barring = (*barring, "structure_known")  # what the dry trials lack bars names too
        return {"status": "explained", "verdict": names}, barring
    if "nothing_left" in gates:
        return {"status": "nothing_missing", "verdict": []}, (*OF_GREEN, *OF_ALL)
    return {"status": "unknown", "verdict": ["unknown"]}, (*OF_UNKNOWN, *OF_ALL)


def worth(cases: list[CaseResult]) -> dict[str, dict[str, int]]:
    """A gate: groups that it alone turns, and of these how many would be right and wrong without it."""
    counts: dict[str, Counter[str]] = {}
    for case in cases:
        for i, group in enumerate(case.groups):
            gates = {str(g["gate"]): g for g in group.said.get("decision") or []}
            if not gates:
                continue
            said, able = _before(gates, str(group.said.get("status")))
            failed = [name for name in able if name in gates and not gates[name]["passed"]]
            if len(failed) != 1:
                continue
            acting = [(e, e["groups"][i]) for e in case.truth["measures"]["effects"] if e["groups"][i]["present"]]
            right = holds(replace(group, outcome=judge(acting, group.said | said | {"alternatives": []})))
            counts.setdefault(failed[0], Counter())[{True: "right", False: "wrong"}.get(right, "open")] += 1
    return {
        name: {"turned": sum(found.values()), "right without": found["right"], "wrong without": found["wrong"]}
        for name, found in sorted(counts.items())
    }
