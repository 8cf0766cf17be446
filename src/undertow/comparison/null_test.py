"""How unusual a level is among replicas of itself in which nothing is missing: a p-value by simulation of its own null.

The prescribed equation is taken as linear about its fit, weighed by the noise that the closest fitted model leaves. To
the residuals of a replica (replicas.py) comes one law of the catalogue drawn at random, at most as large as what that
model surely leaves of its own (`replicas.surely_wrong`): no equation is exact. Replicas and recordings are scored
alike: for every suspect the largest gain of one Gauss-Newton step over its grid; of the recordings also what a fit
gained. A suspect's gain counts by its rank among the replicas, the level by the smallest of
these (Westfall and Young 1993): many suspects and fine grids, scatter, few trials and slow noise are all in it.

Ranks are weighed (Genovese, Roeder and Wasserman 2006, doi:10.1093/biomet/93.3.509): a suspect of which replicas show
what sensors, clocks and releases are believed to do shows that in no recording whose instruments are better than
believed, and would make every such level look more like its null than it is. It counts by the share of its spread in
replicas that is not theirs; an instrument further off than believed is far off.

Belongs here: p-values and what can still hide. Does not belong here: what would be seen (detectable.py), residuals of
replicas (replicas.py), sums over places (score_stack.py), what is said (discrepancy/).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from undertow.comparison.candidate import Candidate
from undertow.comparison.detectable import Detectable, detectable
from undertow.comparison.joining import has_room
from undertow.comparison.joint import JointFit, free_run_error
from undertow.comparison.level import Level
from undertow.comparison.limits import LEAST_P
from undertow.comparison.replicas import (
    ALIKE,
    at_noise_of,
    believed_widths,
    is_of_instrument,
    left_by,
    noise_over,
    of_one_sensor,
    replicas,
    surely_wrong,
    wanders_as,
    within_reason,
)
from undertow.comparison.score_stack import Scored, Stack
from undertow.comparison.score_test import GridPlace, Stands, places, reweighed, scaled_inverse
from undertow.comparison.sizes import COUNTS_IN_REPEATABILITY, Sizes
from undertow.comparison.suspect import Suspect
from undertow.comparison.tail import Histogram, Tail, wilks
from undertow.recording.recording import Array

DRAWS, FEWEST_DRAWS = 1000, 400
"""Replicas of a level, and of one so large that they have no `ROOM`."""

ROOM = 2e7
"""Numbers of residuals of replicas at a time (160 MB)."""

SIGNIFICANT = 0.01
"""Share of campaigns with nothing missing of which a level is said not to be like its null."""

NEAR, CLOSER = 10.0, 8
"""A p-value within this ratio of its limit is worked out once more, with so many times the replicas: a suspect's tail
is continued beyond what replicas show, and of a thousand the twenty largest tell by how much."""

LEAST_WEIGHT = 0.01
"""Smallest weight of a suspect's rank."""


@dataclass(frozen=True)
class SuspectTest:
    """One suspect against the level's null: the probability of such a gain, the gain, the effect's estimated size, and
    the largest free-run error that can still hide (95 %; nan where it is each trial's own), in units of what counts."""

    label: str
    p_value: float
    gain: float
    size: float
    hidden: float
    detectable: Detectable | None = None

    @property
    def name(self) -> str:
        """The suspect's name, without its variant."""
        return self.label.partition(" (")[0]


def limit(levels: int) -> float:
    """p-value below which a share `SIGNIFICANT` of campaigns with nothing missing and so many levels has one of them
    (Sidak 1967, doi:10.1080/01621459.1967.10482935).

    >>> round(limit(1), 6), round(limit(5), 6)
    (0.01, 0.002008)
    """
    return -math.expm1(math.log1p(-SIGNIFICANT) / levels)


@dataclass(frozen=True)
class NullTest:
    """A level against its own null; ``smallest`` is the free-run error (nrmse) from which on an effect counts,
    ``levels`` how many the campaign has, ``scores`` the level's largest score among those of its replicas, ``most`` the
    free-run error that is measured and what repetitions differ by: nothing moves the free run by more and hides."""

    p_value: float
    tests: tuple[SuspectTest, ...] = ()
    smallest: float = math.nan
    levels: int = 1
    scores: Histogram | None = None
    most: float = math.inf

    @property
    def limit(self) -> float:
        """p-value up to which this level is not like its null, `limit`."""
        return limit(self.levels)

    @property
    def significant(self) -> bool:
        """Whether the level is not like its null."""
        return self.p_value <= self.limit

    @property
    def upper_bound(self) -> float:
        """The largest free-run error (nrmse) that an effect of all trials can still hide; nan where none was tested."""
        return min(max((t.hidden for t in self.shared), default=math.nan) * self.smallest, self.most)

    @property
    def hides_best(self) -> str:
        """The name of the suspect that can hide most."""
        return max(self.shared, key=lambda t: t.hidden).name if self.shared else ""

    @property
    def shared(self) -> tuple[SuspectTest, ...]:
        """The tests of effects that all trials share, without those that nothing here shows: what differs from trial to
        trial is bounded by repeatability."""
        return tuple(t for t in self.tests if math.isfinite(t.hidden) and self._shows(t))

    @property
    def not_testable(self) -> tuple[str, ...]:
        """Names of what could be as large as the motion itself and not be seen."""
        shown = {t.name for t in self.tests if self._shows(t)}
        return tuple(sorted({t.name for t in self.tests} - shown))

    def _shows(self, test: SuspectTest) -> bool:
        seen = test.detectable.share_of_motion if test.detectable is not None else 0.0
        hidden = test.hidden * self.smallest if math.isfinite(test.hidden) else 0.0
        return max(seen, hidden) <= 1.0

    @property
    def detectable(self) -> tuple[Detectable, ...]:
        """What would have been seen, one entry a name (of its variants the easiest seen)."""
        found: dict[str, Detectable] = {}
        for one in (t.detectable for t in self.tests if t.detectable is not None and self._shows(t)):
            if one.name not in found or one.share_of_motion < found[one.name].share_of_motion:
                found[one.name] = one
        return tuple(found[name] for name in sorted(found))


def null_test(
    level: Level,
    suspects: Sequence[Suspect],
    null: JointFit,
    found: Sequence[Candidate],
    levels: int = 1,
    looks: Mapping[str, Sequence[GridPlace]] | None = None,
) -> NullTest:
    """A level, one of so many, against its null: ``null`` is the prescribed equation as fitted, ``found`` every
    candidate that was, ``looks`` places of suspects' grids as seen from that fit already, by label.

    Where a step from the null is too short to tell what a suspect gains, its fit tells, if its numbers mean something
    and are no slower than its grid: no replica is fitted, and a joint that hardly yields, or a resonator far slower
    than the body, follows a sensor that wanders. What makes trials differ (a mass of each trial's own) is not tested:
    it is scatter, of which as much is there as there is.
    """
    whole = [c.fit for c in found if c.fit.solution.n_data == null.solution.n_data]  # a late one leaves out a beginning
    closest = min((null, *whole), key=lambda fit: fit.misfit)
    before, null = null, at_noise_of(null, closest)
    stands = Stands.of(null)
    factors = [noise_over(*pair) for pair in zip(*(f.solution.problem.trials for f in (before, null)), strict=True)]
    usable = [s for s in suspects if not s.at_the_beginning and not s.is_scatter and has_room(level, s, null)]
    looks = {label: [p for p in seen if p.columns] for label, seen in (looks or {}).items()}
    every = [
        place
        for suspect in usable
        for place in (
            [reweighed(p, stands, factors) for p in looks[suspect.label]]
            if suspect.label in looks and not suspect.frees
            else places(level, stands, suspect)
        )
        if place.columns and place.width
    ]
    if not every:
        return NullTest(math.nan)
    stack = Stack.of(stands, every)
    sizes = Sizes.on(level, stands, _reported(null))
    left = left_by(null, closest)
    sound = [c for c in found if (c.aside or not c.out) and _looked_at(level, c)]
    alone = {p.label: [c.fit for c in sound if [s.label for s in c.suspects] == [p.label]] for p in every}
    together = {n: [c.fit for c in sound if len(c.suspects) == n] for n in {len(c.suspects) for c in sound} - {0, 1}}
    fitted = {label: _fitted_gain(null, fits) for label, fits in alone.items()}
    sets = {n: _fitted_gain(null, fits) for n, fits in together.items()}
    most = (1.0 + free_run_error(level, before)) * sizes.allowed
    rows = sum(r.size for r in left)
    noise = min(sum(float(r @ r) for r in left) / rows, 1.0)
    rng, draws = np.random.default_rng(level.trials), int(min(DRAWS, max(FEWEST_DRAWS, ROOM / rows)))
    for many in (draws, CLOSER * draws):
        scored = _scored(level, stack, sizes, left, rng, many)
        if not scored:
            return NullTest(math.nan)
        test = _ranked(scored, stack, sizes, fitted, sets, levels, noise)
        if not test.limit / NEAR < test.p_value < test.limit * NEAR:
            break
    return replace(test, most=most)


def _looked_at(level: Level, candidate: Candidate) -> bool:
    """Whether what a candidate has inside is no slower than replicas are looked at: a frequency below its suspect's
    grid, or a time beyond, by more than a step, is a sensor's that wanders."""
    own = candidate.fit.addends[len(candidate.fit.addends) - len(candidate.suspects) :]
    for suspect, addend in zip(candidate.suspects, own, strict=False):
        for a in (a for a in addend.additions if a.inner and a.unit in ("rad/s", "s")):
            on_grid = sorted({b.start for place in suspect.grid(level.scales) for b in place if b.name == a.name})
            value = candidate.fit.values.get(f"{addend.prefix}.{a.name}", math.nan)
            if len(on_grid) < 2 or not math.isfinite(value):
                continue
            if value < on_grid[0] ** 2 / on_grid[1] if a.unit == "rad/s" else value > on_grid[-1] ** 2 / on_grid[-2]:
                return False
    return True


def _reported(null: JointFit) -> dict[str, float]:
    """Standard errors of the numbers that a level reports, by their unknowns: those of no single trial."""
    return {n: null.solution.stderr(n) for n in null.solution.problem.names if not set("[.") & set(n)}


def _fitted_gain(null: JointFit, fits: Sequence[JointFit]) -> float:
    """The most that one of these fits gained, at the null's noise; 0 where there is none."""
    before = sum(float(r @ r) for r in null.solution.residuals) + null.solution.cost - null.solution.chi2
    after = [
        sum(float(r @ r) for r in left_by(null, fit)) + fit.solution.cost - fit.solution.chi2
        for fit in fits if fit.solution.n_data == null.solution.n_data
    ]  # fmt: skip
    return max((0.5 * (before - one) for one in after), default=0.0)


def _ranked(
    scored: Sequence[Scored],
    stack: Stack,
    sizes: Sizes,
    fitted: Mapping[str, float],
    sets: Mapping[int, float],
    levels: int,
    noise: float = 1.0,
) -> NullTest:
    """The test from scored places; ``fitted`` are gains by label that a fit has shown, ``sets`` the same of so many
    suspects together: of a replica the sum of its largest counts. No gain is rarer among replicas than the likelihood
    itself has it (`wilks`, ``noise`` its mean square): of what priors alone tell they may be too much alike."""
    shown = {s.place.label for s in scored}
    by_label = {label: [s for s in scored if s.place.label == label] for label in fitted if label in shown}
    largest = {label: np.max([s.gains for s in own], axis=0) for label, own in by_label.items()}
    observed = {label: max(fitted[label], *(s.gain for s in own)) for label, own in by_label.items()}
    ordered = np.sort(np.array(list(largest.values())), axis=0)[::-1]
    every = largest | {str(n): np.sum(ordered[:n], axis=0) for n in sets}
    tails = {label: Tail.of(values) for label, values in every.items()}
    weights = {label: _log_weight(by_label.get(label, ())) for label in every}
    least = _least(every, weights)
    gains = observed | {str(n): gain for n, gain in sets.items()}
    mine = {n: min(float(tails[n].log_p(np.array([gain]))[0]) - weights[n], 0.0) for n, gain in gains.items()}
    for label, own in by_label.items():
        mine[label] = max(mine[label], wilks(observed[label] / noise, own[0].place.width))
    together = Tail.of(-least)
    p_value = math.exp(float(together.log_p(np.array([-min(mine.values())]))[0]))
    threshold = -together.quantile(limit(levels))
    tests = []
    for label, own in by_label.items():
        best = max(own, key=lambda s: s.gain)
        fast = [s for s in own if not wanders_as(stack.stands.fit.solution, s.place.additions)] or own
        most = max(fast, key=lambda s: s.gain)
        seen = detectable(stack, scored, own, most, tails[label].at(threshold + weights[label]), sizes.allowed)
        common = any(a.scope != "trial" for a in best.place.additions if not a.inner)
        hidden = max(s.hidden for s in own) if common else math.nan
        size = float(best.measure.of(best.step[:, None])[0])
        tests.append(SuspectTest(label, math.exp(mine[label]), observed[label], size, hidden, seen))
    ordered_tests = tuple(sorted(tests, key=lambda t: t.p_value))
    scores = Histogram.of(-least, -min(mine.values()), -threshold)
    p_value, smallest_counts = min(max(p_value, LEAST_P), 1.0), COUNTS_IN_REPEATABILITY * sizes.allowed
    return NullTest(p_value, ordered_tests, smallest_counts, levels, scores)


def _log_weight(places: Sequence[Scored]) -> float:
    """Logarithm of a suspect's weight, from its places: of a set of suspects, without any, 0."""
    theirs = float(np.mean([s.of_instruments for s in places])) if places else 0.0
    return math.log(max(1.0 - theirs, LEAST_WEIGHT))


def _least(every: Mapping[str, Array], weights: Mapping[str, float]) -> Array:
    """The smallest weighed log p-value over suspects of every replica, (draws,), each half by the tails of the other:
    the recordings had no part in the tails either."""
    stacked, weighed = np.array(list(every.values())), np.array([weights[label] for label in every])
    half = stacked.shape[1] // 2
    parts = ((stacked[:, :half], stacked[:, half:]), (stacked[:, half:], stacked[:, :half]))
    least = (
        np.min([Tail.of(o).log_p(m) - w for m, o, w in zip(mine, others, weighed, strict=True)], axis=0)
        for mine, others in parts
    )
    return np.asarray(np.minimum(np.concatenate(list(least)), 0.0), dtype=np.float64)


def _scored(
    level: Level, stack: Stack, sizes: Sizes, left: Sequence[Array], rng: np.random.Generator, draws: int
) -> list[Scored]:
    """Every place with the scores of the recordings and of so many replicas, none where replicas are no motions;
    ``left`` as in `replicas.left_by`."""
    stands, parts = stack.stands, []
    at_once = int(max(1, min(draws, ROOM // sum(r.size for r in left))))
    for start in range(0, draws, at_once):
        residuals = replicas(level, stands.fit.solution, left, min(at_once, draws - start), rng)
        if not within_reason(stands.fit.solution, residuals):
            return []
        parts.append(stack.scores(residuals, stands.pulled(residuals)))
    noise = np.hstack(parts)
    observed = stack.scores([r[:, None] for r in stands.fit.solution.residuals], stands.gradient[:, None])[:, 0]
    widths = believed_widths(level, stands.fit.solution)
    measures = [sizes.measure(place) for place in stack.places]
    square = surely_wrong(stands.fit.solution, left)
    drawn = noise + _slightly_wrong(stack, square, draws, rng)
    out = []
    for place, own, measure in zip(stack.places, stack.slices, measures, strict=True):
        information = stack.information[own, own]
        if not stack.shows(place, own):
            continue
        scale = 1.0 / np.sqrt(np.maximum(np.diag(place.own), 1e-300))
        both = np.outer(scale, scale)
        inverse = np.linalg.pinv(information * both, rcond=1e-6, hermitian=True) * both
        theirs = _of_instruments(stack, own, noise[own], widths)
        out.append(Scored(place, own, observed[own], drawn[own], noise[own], information, inverse, measure, theirs))
    return out


def _of_instruments(stack: Stack, own: slice, noise: Array, widths: Array) -> float:
    """Share of the variance of replicas' scores (q, draws) at a place that is what instruments are believed to do, by
    ``widths`` as in `replicas.believed_widths`.

    A standard deviation of an unknown moves the scores by what the fit, which believes it small, does not take up."""
    unknowns = stack.stands.fit.solution.problem.unknowns
    mine = [i for i, u in enumerate(unknowns) if is_of_instrument(u)]
    moved = stack.away[own, mine] * widths[mine] / np.array([unknowns[i].prior_std for i in mine]) ** 2
    share = np.ones(len(mine))
    for alike in of_one_sensor(unknowns):
        at = np.searchsorted(mine, [i for i in alike if i in mine])
        share[at] = 1.0 - ALIKE
        moved = np.column_stack([moved, np.sum(moved[:, at], axis=1)])
    weights = np.append(share, np.full(moved.shape[1] - share.size, ALIKE))
    inverse = scaled_inverse(np.atleast_2d(np.cov(noise)), 1e-6)
    return float(np.einsum("qi,qv,vi,i->", moved, inverse, moved, weights)) / len(noise)


def _slightly_wrong(stack: Stack, square: float, draws: int, rng: np.random.Generator) -> Array:
    """What one law of the catalogue in every replica, as large as what the closest model leaves above the sensors'
    noise (a sum of squares), adds to the scores (width, draws): no equation is exact."""
    out = np.zeros((len(stack.information), draws))
    pairs = zip(stack.places, stack.slices, strict=True)
    able = [i for i, (place, at) in enumerate(pairs) if place.additions and stack.shows(place, at)]
    labels = sorted({stack.places[i].label for i in able})
    if not labels or square <= 0.0:
        return out
    own = {label: [i for i in able if stack.places[i].label == label] for label in labels}
    whose = [own[labels[i]] for i in rng.integers(len(labels), size=draws)]
    which = np.array([candidates[int(rng.integers(len(candidates)))] for candidates in whose])
    for index, at in enumerate(stack.slices):
        mine = np.flatnonzero(which == index)
        moved = rng.standard_normal((stack.places[index].width, mine.size))
        found = np.einsum("wn,wv,vn->n", moved, stack.information[at, at], moved)
        size = np.sqrt(square * rng.uniform(size=mine.size) / np.maximum(found, 1e-300))
        out[:, mine] = stack.information[:, at] @ (moved * size)
    return out
