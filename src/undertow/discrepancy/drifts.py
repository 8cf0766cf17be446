"""Parameters that drift although they should not: with amplitude, from spring to spring, from level to level.

A law's numbers are constants. Where fits of single trials give one that goes with the release's amplitude, or where two
springs in the same water give two added masses, the equation bends a number to stand for something it has not.

Belongs here: finding such drifts and saying them. Does not belong here: what makes them (search.py).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import t as student

from undertow.discrepancy.findings import GroupFindings, TrialFindings
from undertow.discrepancy.verdict import Verdict
from undertow.discrepancy.words import condition_words, count, percent
from undertow.equation.term import Array
from undertow.methods.dry import DEFAULT_SCATTER
from undertow.quantities import OK, Estimate, format_number
from undertow.recording.recording import Condition

METHOD = "output_error"
"""The method whose numbers are compared: it has the smallest errors, and says when it has none."""

FALSE_ALARM = 0.01
"""Chance that one of a group's parameters is said to drift where none does."""

FEWEST_TRIALS = 4
"""Trials a straight line against amplitude needs to have two degrees of freedom."""

FEWEST_RANKED, FEWEST_SPLIT = 3, 4
"""Trials of a group that are ranked; that can change at one of them, two on either side."""

ORDERED = 0.001
"""Chance with which scatter is said to go with the release or with the trials' order, or to change at one trial, where
it does not."""

WIDE, ORDERED_WIDE = 3.0, 0.01
"""The same chance where trials differ by so many times what rigs' stiffness scatters: nine trials of two groups in
perfect order are one campaign in 1,400, and a rig that changes is not rare."""

OF_SCATTER = frozenset({"upper_bound", "nothing_left", "scatter_known", "twice_the_scatter"})
"""Conditions that fail where trials differ by more than is known, or by so much that nothing else shows."""

PERMUTED = 20000
"""Orders drawn at random."""

WORTH_SAYING = 0.004
"""Relative change of stiffness over mass over a group's trials from which on it is said: as much as rigs scatter."""

WATER = ("added_mass_kg", "drag_coefficient", "drag_Ns2_per_m2")
"""Parameters of the water: the same for all springs at one level."""

STRUCTURE = ("k_N_per_m", "c_Ns_per_m", "mu", "friction_N")
"""Parameters of the structure: the same at all levels on one spring."""


@dataclass(frozen=True)
class Drift:
    """One parameter that is no constant: its name, along what ("amplitude" or a condition), how probable such a drift
    is by chance, and the sentence."""

    parameter: str
    along: str
    chance: float
    sentence: str


def amplitude_drifts(trials: Sequence[TrialFindings], label: str) -> tuple[Drift, ...]:
    """Parameters of single trials' fits that go with the logarithm of the release amplitude.

    A straight line, each trial weighed by its own error and by the scatter that the line leaves; Student's t with n - 2
    degrees of freedom, the chance shared among the parameters. Empty below four trials.
    """
    table: dict[str, list[tuple[float, Estimate]]] = {}
    for trial in trials:
        fit = trial.fits.get(METHOD)
        for name, estimate in (fit.parameters if fit is not None else {}).items():
            if estimate.outcome == OK and math.isfinite(estimate.stderr) and estimate.stderr > 0.0:
                table.setdefault(name, []).append((math.log(trial.motion.amplitude), estimate))
    found = []
    known = {name: rows for name, rows in table.items() if len(rows) >= FEWEST_TRIALS}
    for name, rows in known.items():
        size = np.array([s for s, _ in rows])
        values, errors = (np.array([getattr(e, what) for _, e in rows]) for what in ("value", "stderr"))
        if float(np.ptp(size)) <= 0.0:
            continue
        low, high, chance = _line(size, values, errors)
        if chance < FALSE_ALARM / len(known):
            unit = rows[0][1].unit
            factor, swing = (1.0, "rad") if trials[0].motion.recording.coordinate == "rotation" else (1e3, "mm")
            ends = (low, factor * math.exp(size.min()), high, factor * math.exp(size.max()))
            first, small, last, large = (format_number(float(f"{end:.3g}")) for end in ends)
            found.append(
                Drift(
                    name, "amplitude", chance,
                    f"{label}: {name} goes with amplitude, from {first} at {small} {swing} to {last} {unit} "
                    f"at {large} {swing} (chance {chance:.1g}); a constant does not",
                )
            )  # fmt: skip
    return tuple(found)


def _line(size: Array, values: Array, errors: Array) -> tuple[float, float, float]:
    """Values of the straight line at the smallest and largest size, and the chance of such a slope without one."""
    extra = 0.0
    columns = np.column_stack([np.ones(size.size), size - size.mean()])
    freedom = size.size - 2
    for _ in range(50):
        weights = 1.0 / (errors**2 + extra)
        normal = columns.T @ (weights[:, None] * columns)
        line = np.linalg.solve(normal, columns.T @ (weights * values))
        excess = float(np.sum(weights * (values - columns @ line) ** 2)) / freedom
        if excess <= 1.0 + 1e-3:
            break
        extra = (float(np.mean(errors**2)) + extra) * excess - float(np.mean(errors**2))
    error = math.sqrt(float(np.linalg.inv(normal)[1, 1]))
    chance = float(2.0 * student.sf(abs(float(line[1])) / error, freedom))
    ends = (columns @ line)[[int(np.argmin(size)), int(np.argmax(size))]]
    return float(ends[0]), float(ends[1]), chance


def group_drifts(groups: Sequence[GroupFindings], water: Collection[str]) -> tuple[Drift, ...]:
    """Parameters of groups' fits that differ where they should not.

    ``water`` names the conditions that are the water's (the config's ``dry`` keys): what belongs to the water must not
    differ between springs at one level, what belongs to the structure not between levels on one spring. Pairs of
    groups are compared by their errors; the chance is shared among the pairs.
    """
    pairs = []
    for one, other in itertools.combinations([g for g in groups if not g.dry], 2):
        differing = {name for name in one.key if one.key[name] != other.key.get(name)}
        names = WATER if differing and not differing & set(water) else STRUCTURE
        if differing and (differing <= set(water) or not differing & set(water)):
            pairs += [(one, other, differing, name) for name in names]
    compared = [(p, e) for p in pairs if (e := _both(p[0], p[1], p[3])) is not None]
    found = []
    for (one, other, differing, name), (first, second) in compared:
        away = abs(first.value - second.value) / math.hypot(first.total_stderr, second.total_stderr)
        chance = math.erfc(away / math.sqrt(2.0))
        if chance < FALSE_ALARM / len(compared):
            where = " and ".join(sorted(differing))
            found.append(Drift(name, where, chance, _pair_sentence(name, one.key, other.key, differing, first, second)))
    return tuple(found)


def springs_apart(groups: Sequence[GroupFindings], water: Collection[str]) -> str:
    """That springs do not agree on a number of one water where nothing is named, as a sentence behind another;
    empty where they do. Each group's equation has its own numbers, so that no free run shows it."""
    fine = [g for g in groups if g.verdict.status in ("nothing_missing", "cannot_tell")]
    found = sorted((d for d in group_drifts(fine, water) if water and d.parameter in WATER), key=lambda d: d.chance)
    if not found:
        return ""
    more = {1: "", 2: " One more pair differs."}.get(len(found), f" {len(found) - 1} more pairs differ.")
    return (
        f" But {found[0].sentence} (errors of each group's own fit).{more} Each group's equation keeps its own; "
        "stiffness that the water adds would look so, or water that moves by itself."
    )


def no_scatter(groups: Sequence[GroupFindings], order: Sequence[str] = ()) -> str:
    """That what differs between trials goes with the release, or with the order of their names, or changed at one trial
    in the campaign's ``order`` (of their names where it is not given), in all groups together of which nothing is said,
    in words; empty where it may be scatter.

    Each trial's own stiffness over its mass is ranked within its group. Kendall's tau, added over the groups, is held
    against orders drawn at random (the few trials of one group would not show it), and a straight line against the
    scatter about it. A change is held against them by the
    likelihood of two means beside one. Less than `WORTH_SAYING` is not said.
    """
    quiet = [g for g in groups if nothing_said(g.verdict)]
    found = [rows for rows in (rates(g) for g in quiet) if len(rows) >= FEWEST_RANKED]
    why = "scatter goes with nothing; a law that the equation lacks does, or a rig that changes from trial to trial"
    ways = []
    for along, words in ((2, "with the size of the release"), (3, "in the order of the trials' names")):
        pairs = [(np.array([r[along] for r in rows]), np.array([r[1] for r in rows])) for rows in found]
        if not pairs or any(float(np.ptp(size)) == 0.0 for size, _ in pairs):
            continue
        changes = [float(np.polyfit(size, rate, 1)[0] * np.ptp(size)) for size, rate in pairs]
        chance = _chance_of_an_order(pairs) if _worth_saying(changes) else 1.0
        if chance < _limit(changes):
            ways.append((words, changes, chance))
    said, chance, limit, clearer = _changed(quiet, order)
    if chance < limit and (clearer or not ways):
        return f"{said} ({_rare(chance)}): {why} (a part taken off or left on the body, a spring that slipped)"
    if not ways:
        return ""
    (_, changes, chance), way = ways[0], "rises" if sum(ways[0][1]) > 0.0 else "falls"
    along_both = ", and as much ".join(words for words, _, _ in ways)
    return (
        f"stiffness over mass of single trials {way} {along_both}, by {percent(_typical(changes))} in "
        f"{count(len(found), 'group')} ({_rare(chance)}): {why} (temperature, a part that works loose)"
    )


def nothing_said(verdict: Verdict) -> bool:
    """Whether nothing is missing, or nobody can tell because trials differ by more than is known."""
    reasons = {gate.gate for gate in verdict.decision if not gate.passed and gate.because == verdict.because}
    return verdict.status == "nothing_missing" or (verdict.status == "cannot_tell" and bool(reasons & OF_SCATTER))


def _changed(groups: Sequence[GroupFindings], order: Sequence[str]) -> tuple[str, float, float, bool]:
    """That trials changed at one of them in words, how often that comes by chance, what chance may be said, and whether
    it is likelier than straight lines along the order or the release."""
    place = {name: i for i, name in enumerate(order)}
    found = [sorted(rates(g), key=lambda row: place.get(row[0], row[3])) for g in groups]
    found = [rows for rows in found if len(rows) >= FEWEST_SPLIT]
    in_order = [np.array([row[1] for row in rows]) for rows in found]
    steps = [_step(rate) for rate in in_order]
    changes = [change for _, change, _ in steps]
    if not steps or not _worth_saying(changes):
        return "", 1.0, 0.0, False
    clearest = max(range(len(steps)), key=lambda i: steps[i][2])
    way, first = "higher" if changes[clearest] > 0.0 else "lower", found[clearest][steps[clearest][0]][0]
    said = f"stiffness over mass is {way} from one trial on, by {percent(abs(changes[clearest]))} from trial {first}"
    lines = [
        sum(_gain_of_line(np.arange(len(rows), dtype=np.float64) if of is None else np.array([row[of] for row in rows]),
                          rate) for rows, rate in zip(found, in_order, strict=True))
        for of in (None, 2)
    ]  # fmt: skip
    clearer = sum(gain for *_, gain in steps) > max(lines)
    return said, _chance_of_steps(in_order), _limit(changes), clearer


def _typical(changes: Sequence[float]) -> float:
    return float(np.median(np.abs(changes)))


def _worth_saying(changes: Sequence[float]) -> bool:
    return _typical(changes) >= WORTH_SAYING


def _limit(changes: Sequence[float]) -> float:
    """The chance below which one of three orders is said, for changes of that size."""
    return (ORDERED_WIDE if _typical(changes) > WIDE * DEFAULT_SCATTER["k"] else ORDERED) / 3.0


def _rare(chance: float) -> str:
    return f"by chance in at most one campaign of {1.0 / max(chance, 1.0 / PERMUTED):,.0f}"


def _splits(rates_in_order: Array) -> tuple[Array, Array]:
    """Of every row (..., n): what a change after each place (..., n - 3), two trials on either side, takes of its
    variance, and by how much the mean changes there."""
    n = rates_in_order.shape[-1]
    apart = rates_in_order - rates_in_order.mean(axis=-1, keepdims=True)
    many = np.arange(2, n - 1)
    below = np.cumsum(apart, axis=-1)[..., 1 : n - 2]
    each = 1.0 / many + 1.0 / (n - many)
    return below**2 * each / np.maximum(np.sum(apart**2, axis=-1, keepdims=True), 1e-300), -below * each


def _gain(share: Array, trials: int) -> Array:
    """Log likelihood that two means gain over one, where they take this share of the variance."""
    return -0.5 * trials * np.log(np.maximum(1.0 - share, 1e-12))


def _gain_of_line(size: Array, rate: Array) -> float:
    """The same of a straight line along ``size``."""
    if float(np.ptp(size)) == 0.0 or float(np.ptp(rate)) == 0.0:
        return 0.0
    return float(_gain(np.array(np.corrcoef(size, rate)[0, 1] ** 2), rate.size))


def _step(rate: Array) -> tuple[int, float, float]:
    """The first trial after the clearest change, by how much it changes, and the gain in log likelihood."""
    share, change = _splits(rate)
    at = int(np.argmax(share))
    return at + 2, float(change[at]), float(_gain(share[at], rate.size))


def _chance_of_steps(in_order: Sequence[Array]) -> float:
    """How often orders drawn at random gain as much by one change in each group."""
    rng = np.random.default_rng(len(in_order))
    own, drawn = 0.0, np.zeros(PERMUTED)
    for rate in in_order:
        own += _step(rate)[2]
        mixed = rng.permuted(np.tile(rate, (PERMUTED, 1)), axis=1)
        drawn += _gain(_splits(mixed)[0].max(axis=-1), rate.size)
    return float(np.mean(drawn >= own - 1e-9))


def rates(group: GroupFindings) -> list[tuple[str, float, float, float]]:
    """Name, logarithm of stiffness over mass, logarithm of the release and place among the names, of every trial that
    was fitted."""
    rows = []
    for place, trial in enumerate(sorted(group.trials, key=lambda one: one.motion.name)):
        numbers = trial.fits[METHOD].parameters if METHOD in trial.fits else {}
        moved = [(numbers.get("k_N_per_m"), 1.0), (numbers.get("total_mass_kg"), -1.0)]
        rate = [sign * math.log(e.value) for e, sign in moved if e is not None and e.outcome == OK and e.value > 0.0]
        if len(rate) == len([e for e, _ in moved if e is not None]) > 0:
            rows.append((trial.motion.name, sum(rate), math.log(trial.motion.amplitude), float(place)))
    return rows


def _chance_of_an_order(pairs: Sequence[tuple[Array, Array]]) -> float:
    """The chance of such an order in all groups together, by ranks or by one straight line, whichever is rarer: seven
    trials in perfect order are one in 144 by ranks, on a line that leaves a tenth of their scatter far fewer."""
    return min(2.0 * min(_chance_of_ranks(pairs), _chance_of_a_line(pairs)), 1.0)


def _chance_of_a_line(pairs: Sequence[tuple[Array, Array]]) -> float:
    """The chance of so steep a line, of one slope in all groups and a mean of each, where trials scatter about it as
    they do (Student)."""
    size, rate = (np.concatenate([one[which] - one[which].mean() for one in pairs]) for which in (0, 1))
    freedom = rate.size - len(pairs) - 1
    squares = float(size @ size) * float(rate @ rate)
    share = min(float(size @ rate) ** 2 / squares, 1.0 - 1e-12) if squares > 0.0 else 0.0
    return float(2.0 * student.sf(math.sqrt(freedom * share / (1.0 - share)), freedom)) if freedom > 0 else 1.0


def _chance_of_ranks(pairs: Sequence[tuple[Array, Array]]) -> float:
    """How often ranks drawn at random agree as much within all groups together, either way."""
    rng = np.random.default_rng(len(pairs))
    own, drawn = 0.0, np.zeros(PERMUTED)
    for rate, size in pairs:
        order = np.sign(size[:, None] - size[None, :])
        own += 0.5 * float(np.sum(order * np.sign(rate[:, None] - rate[None, :])))
        mixed = rng.permuted(np.tile(rate, (PERMUTED, 1)), axis=1)
        drawn += 0.5 * np.einsum("ij,nij->n", order, np.sign(mixed[:, :, None] - mixed[:, None, :]))
    return float(np.mean(np.abs(drawn) >= abs(own) - 0.5))


def _both(one: GroupFindings, other: GroupFindings, name: str) -> tuple[Estimate, Estimate] | None:
    """A parameter as both groups' own fits have it, with errors; None where one has not, or only holds it fixed."""
    first, second = own_number(one, name), own_number(other, name)
    return None if first is None or second is None else (first, second)


def own_number(group: GroupFindings, name: str, method: str = METHOD) -> Estimate | None:
    """A parameter as a group's own fit has it, with its error; None where it has not, or holds it."""
    found = group.fits[method].parameters.get(name) if method in group.fits else None
    held = group.structure is not None and name in STRUCTURE
    if found is None or held or found.outcome != OK or not 0.0 < found.total_stderr < math.inf:
        return None
    return found


def _pair_sentence(
    name: str,
    one: Mapping[str, Condition],
    other: Mapping[str, Condition],
    differing: Collection[str],
    first: Estimate,
    second: Estimate,
) -> str:
    def words(key: Mapping[str, Condition], names: Collection[str]) -> str:
        return ", ".join(condition_words(n, key[n]) for n in key if n in names)

    common = words(one, [n for n in one if n not in differing])
    place = f"{common}: " if common else ""
    why = "one water has one value" if name in WATER else "one structure has one value"
    first, second = (replace(e, stderr=e.total_stderr, systematic=0.0) for e in (first, second))
    return f"{place}{name} is {first} with {words(one, differing)}, but {second} with {words(other, differing)}; {why}"
