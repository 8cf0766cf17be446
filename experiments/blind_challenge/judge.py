"""One verdict against one truth: what was said of a group, and what of a campaign.

Outcomes of a group without an effect: right, silent, false. With one: named, first among rivals, among rivals, partly,
described, unknown, small unnamed, wrong, missed, silent. `absent` where the program said nothing of the group.
"""

from dataclasses import dataclass

NAMED = ("named", "first among rivals")
FOUND = ("named", "first among rivals", "among rivals", "partly", "described", "unknown", "small unnamed", "wrong")
CONTRADICTIONS = ("wrong unit", "swapped channels", "wrong sign")
ASKED = 1.0  # strength from which an effect must be named beside another


@dataclass(frozen=True)
class GroupResult:
    """A group: its outcome, the strength of its strongest effect (0 where there is none) and the verdict itself."""

    outcome: str
    strength: float
    size: float
    said: dict[str, object]
    truth: dict[str, object]
    effects: tuple[dict[str, object], ...]


@dataclass(frozen=True)
class CaseResult:
    """A campaign: the row of the runner, the truth, its groups and what is counted of it."""

    row: dict[str, object]
    truth: dict[str, object]
    groups: tuple[GroupResult, ...]

    @property
    def kind(self) -> str:
        """nothing, one, two, outside or cannot."""
        return str(self.truth["kind"])

    @property
    def strength(self) -> float:
        """Strength of the weakest effect, all groups together and beside the other one; 0 where nothing is missing."""
        effects = self.truth["measures"]["effects"]
        return min((float(e.get("strength_beside", e["strength"])) for e in effects), default=0.0)

    @property
    def best_power(self) -> float:
        """Chance of the best possible test."""
        return min((float(e["best_power"]) for e in self.truth["measures"]["effects"]), default=0.0)

    @property
    def answered(self) -> bool:
        """Whether there is a verdict at all."""
        return bool(self.groups) and any(g.outcome != "absent" for g in self.groups)

    @property
    def deciding(self) -> GroupResult | None:
        """The group with the strongest effect; without effects the first one with a name, else the first."""
        said = [g for g in self.groups if g.outcome != "absent"]
        if not said:
            return None
        if any(g.effects for g in said):
            return max(said, key=lambda g: g.strength)
        return next((g for g in said if g.outcome == "false"), said[0])

    @property
    def false(self) -> bool:
        """Whether a group without an effect was said to have one."""
        return any(g.outcome == "false" for g in self.groups)

    @property
    def accused(self) -> bool:
        """The same of an effect that counts: `present_but_small` says that what is there does not."""
        return any(g.outcome == "false" and g.said.get("status") != "present_but_small" for g in self.groups)

    @property
    def detected(self) -> bool:
        """Whether a group with an effect was said to have one."""
        return any(g.outcome in FOUND for g in self.groups if g.effects)


def same_group(truth: dict[str, object], said: dict[str, object]) -> bool:
    """Whether two names of groups are one: keys of the truth, numbers within 1e-6."""
    for key, value in truth.items():
        if key not in said:
            return False
        other = said[key]
        try:
            if abs(float(value) - float(other)) > 1e-6 * max(abs(float(value)), 1.0):  # type: ignore[arg-type]
                return False
        except (TypeError, ValueError):
            if str(value) != str(other):
                return False
    return True


def _matched(names: set[str], effects: tuple[dict[str, object], ...], optional: tuple[dict[str, object], ...]) -> str:
    """all, some or none of the effects have their name in `names`; other where a name belongs to none."""
    left = set(names)
    hits = 0
    for effect in effects:
        own = left & set(effect["names"])
        if own:
            left -= {sorted(own)[0]}
            hits += 1
    for effect in optional:
        left -= set(effect["names"])
    if left:
        return "other"
    return "all" if hits == len(effects) else "some" if hits else "none"


def judge(effects: list[tuple[dict[str, object], dict[str, object]]], said: dict[str, object] | None) -> str:
    """Outcome of a group. `effects`: the effects that act in it, each with its measures there (strength, size)."""
    if said is None:
        return "absent"
    status = said.get("status")
    if not effects:
        return {"nothing_missing": "right", "cannot_tell": "silent"}.get(str(status), "false")
    if status == "nothing_missing":
        return "missed"
    if status == "cannot_tell":
        return "silent"
    asked = tuple(e for e, m in effects if float(m["strength"]) >= ASKED) or tuple(e for e, _ in effects)
    optional = tuple(e for e, _ in effects if e not in asked)
    names = set(said.get("verdict") or []) - {"unknown"}
    if not names:
        return "small unnamed" if status == "present_but_small" else "unknown"
    match = _matched(names, asked, optional)
    if match == "all":
        return "first among rivals" if status == "not_identifiable" else "partly" if status == "unknown" else "named"
    rivals = [set(r) - {"unknown"} for r in said.get("alternatives") or []] if status == "not_identifiable" else []
    if any(_matched(r, asked, optional) == "all" for r in rivals):
        return "among rivals"
    if match in ("some", "none"):
        return "partly"
    near = {n for e in (*asked, *optional) for n in (*e["near"], *e["names"])}
    return "described" if names <= near else "wrong"


def judge_case(row: dict[str, object], truth: dict[str, object]) -> CaseResult:
    """A whole campaign."""
    verdict = row.get("verdict") or {}
    said = list(verdict.get("groups", [])) if isinstance(verdict, dict) else []
    out = []
    for i, group in enumerate(truth["groups"]):
        entry = next((s for s in said if same_group(group["group"], s.get("group", {}))), None)
        acting = [(e, e["groups"][i]) for e in truth["measures"]["effects"] if e["groups"][i]["present"]]
        out.append(
            GroupResult(
                judge(acting, entry),
                max((float(m["strength"]) for _, m in acting), default=0.0),
                max((float(m["size"]) for _, m in acting), default=0.0),
                entry or {},
                group,
                tuple(e for e, _ in acting),
            )
        )
    return CaseResult(row, truth, tuple(out))


def cannot_right(case: CaseResult) -> bool:
    """Whether a case that the data cannot decide was answered rightly.

    Right are: cannot_tell, not_identifiable with the truth among the rivals or (without an effect) at all, the name,
    a refusal
    with a message where channels contradict, and nothing_missing where nothing is or what is there is smaller than B.
    """
    reason = case.truth["reason"]
    contradiction = reason in CONTRADICTIONS
    if not case.answered:
        return contradiction and case.row["exit"] in (1, 2, 3) and bool(case.row.get("messages"))
    for group in case.groups:
        status = str(group.said.get("status", ""))
        if group.outcome == "absent" or (status in ("cannot_tell", "not_identifiable") and not group.effects):
            continue
        if contradiction:
            names = set(group.said.get("verdict") or [])
            if status == "unknown" or names & {"gain_error", "time_shift"}:
                continue
            return False
        if not group.effects:
            if group.outcome == "false":
                return False
        elif group.outcome == "missed":
            if group.size >= 1.0:
                return False
        elif group.outcome not in ("silent", "named", "first among rivals", "among rivals", "small unnamed"):
            return False
    if contradiction:
        return all(g.outcome == "absent" or g.said.get("status") != "nothing_missing" for g in case.groups)
    return True


def confident_wrong(case: CaseResult) -> bool:
    """Whether any group was explained by a name that is neither right nor near."""
    blamed = {"gain_error", "time_shift"} if case.truth["reason"] in CONTRADICTIONS else set()
    for group in case.groups:
        names = set(group.said.get("verdict") or []) - {"unknown"} - blamed
        if str(group.said.get("status")) == "explained" and names and group.outcome in ("false", "wrong"):
            return True
    return False


def statement_right(group: GroupResult, kind: str) -> bool | None:
    """Whether exactly what status and verdict say is so; None where nothing is said (cannot_tell) or of no case."""
    if group.outcome in ("absent", "silent"):
        return None
    if group.outcome == "unknown":
        return kind == "outside"
    return group.outcome in ("right", "named", "first among rivals", "among rivals", "small unnamed")


def holds(group: GroupResult) -> bool | None:
    """Whether what is said of a group is so: nothing as large as what counts is missing, something is, or every name is
    of an effect that is there or describes it, a further one without a name beside it or not. None where nothing is
    said."""
    if group.outcome in ("absent", "silent"):
        return None
    if group.outcome == "missed":
        return group.size < 1.0
    return group.outcome == "right" or (group.outcome in FOUND and group.outcome != "wrong")
