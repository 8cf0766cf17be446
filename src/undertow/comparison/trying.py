"""Suspects tried on one level, each beside what stands: which of them, from where, and within which budget.

Belongs here: the fits that a search asks for. Does not belong here: which of them is believed (search.py), one
suspect's fits (attempt.py).
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field

from undertow.comparison import attempt, explained
from undertow.comparison.attempt import REFINED, from_places, from_starts
from undertow.comparison.candidate import RIVAL_ODDS, Candidate, Screened
from undertow.comparison.joining import log_prior, may_join
from undertow.comparison.joint import free_run_error, missed_share
from undertow.comparison.level import Level
from undertow.comparison.limits import FAR_ABOVE_NOISE, WORTH
from undertow.comparison.score_test import GridPlace, Stands, peaks, places
from undertow.comparison.suspect import Suspect
from undertow.likelihood.budget import BudgetError, metered

EVIDENCE_ALONE = 10.0
"""Gain in log posterior that a suspect must have shown alone to be tried beside another."""

FINE = 2.0
"""Up to this many times repeatability the free run's error is small enough for one linear step to show a gain."""

LINEAR = 0.1
"""Share of the motion that the free run may miss for a linear step to be trusted, however wide repeatability is."""

NEAR = 10.0
"""Mean squared residual over noise of a fit so near that the free run's share does not matter: trials differ."""

ODDS = math.log(RIVAL_ODDS)
"""Log odds from which a set has a name."""

LEAST_GAIN = 5.0
"""A linear step that raises the log evidence by less cannot lead to a name: half of what one needs. What a missing law
leaves swings for long; judged at half its memory (`_at_own_memory`) the step is worth more."""

OUT_OF_REACH = 1.2
"""A fit finds a line from a start within this ratio of its frequency."""

ON_TOP = 0.25
"""Share of a level's budget that suspects without evidence of their own may spend beside an answer."""


@dataclass
class Trying:
    """One level as a search goes on: what stands, what was tried, what may still be spent."""

    level: Level
    suspects: Sequence[Suspect]
    null: Candidate
    clean_when_dry: bool
    budget: float = 1.0
    told: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.unfinished: list[str] = []
        self.asked_for = True
        self.best, self.found = self.null, [self.null]
        self.memory = self.null.fit.memory
        self.screened: dict[str, Screened] = {}
        self.small: list[Candidate] = []
        self.stands: Stands | None = None
        self.looked: Stands | None = None
        self.looks: dict[str, tuple[GridPlace, ...]] = {}
        self.error = free_run_error(self.level, self.null.fit)
        most = attempt.LEVEL_BUDGET * self._one_look()
        self.left = {True: most, False: ON_TOP * most}

    def _one_look(self) -> float:
        """One look at the level with the prescribed equation, times what the config and the number of trials give."""
        trials = 1.0 + (self.level.trials - 1.0) / attempt.TRIALS_A_BUDGET
        return self.budget * trials * attempt.one_look(self.null.fit)

    def _prior(self, suspects: Sequence[Suspect]) -> float:
        told = sum(self.told.get(name, 0.0) for name in {s.name for s in suspects})
        return log_prior(suspects, len(self.suspects), self.clean_when_dry) + told

    def _as_far_as_possible(self, depth: int) -> list[Candidate]:
        """Candidates of this depth: of suspects that are asked for, and beside others of those on top, each kind until
        its budget ends."""
        promising = [s for s in self.suspects if not depth or self._promising(s)]
        on_top = [s for s in self.suspects if s not in promising]
        return self._spending(depth, promising, True) + self._spending(depth, on_top, False)

    def _spending(self, depth: int, suspects: Sequence[Suspect], asked_for: bool) -> list[Candidate]:
        """Candidates of these suspects; those tried so far where the budget of what is ``asked_for``, or of what is
        tried on top of that, ends. The latter is no doubt."""
        tried, self.asked_for = list[Candidate](), asked_for
        with metered(self.left[asked_for]) as meter:
            try:
                for candidate in self._tried(depth, suspects):
                    tried.append(candidate)
            except BudgetError:
                self._not_tried("further effects")
        self.left[asked_for] = max(self.left[asked_for] - meter.spent, 0.0)
        return tried

    def _anew(self, tried: Sequence[Candidate]) -> list[Candidate]:
        """Single suspects of which none leaves no more than noise, where the prescribed equation leaves far more: plain
        laws also from starts that owe nothing to it, the most probable first, until the budget ends, which is no doubt:
        all were tried."""
        found = list(tried)
        closest = min((c.fit.misfit for c in found), default=0.0)
        if self.null.fit.misfit <= FAR_ABOVE_NOISE or closest <= attempt.NO_MORE_THAN_NOISE:
            return found
        last = [c.suspects[-1] for c in found]
        able = [i for i, s in enumerate(last) if s.of_the_body and not (s.memory or s.moves)]
        with metered(self.left[True]) as meter, suppress(BudgetError):
            for i in sorted(able, key=lambda i: -found[i].score):
                found[i] = attempt.anew(self.level, self.null, found[i])
        self.left[True] = max(self.left[True] - meter.spent, 0.0)
        return found

    def _tried(self, depth: int, suspects: Sequence[Suspect]) -> Iterator[Candidate]:
        near = self.best.fit.misfit <= NEAR or missed_share(self.level, self.best.fit) <= LINEAR
        small, twin = self.error <= (FINE if near else WORTH), None
        for suspect in suspects:
            if not may_join(self.best, suspect) or not (small or self.asked_for):
                continue
            candidate = self._within_budget(suspect, small, depth, twin if suspect.swings else None)
            if candidate is not None:
                twin = candidate if suspect.swings and candidate.score > self.best.score + ODDS else twin
                yield candidate

    def _within_budget(self, suspect: Suspect, small: bool, depth: int, twin: Candidate | None) -> Candidate | None:
        """A suspect tried, also from where its ``twin`` ended, unless that takes more than one suspect may."""
        prior = self._prior((*self.best.suspects, suspect))
        with metered(attempt.SUSPECT_BUDGET * self._one_look()) as meter:
            try:
                candidate = self._small(suspect, prior, depth) if small else self._large(suspect, prior)
                candidate = attempt.from_twin(self.level, self.best, suspect, candidate, twin)
                candidate = attempt.widened(self.level, self.best, suspect, candidate)
                if candidate is None or not (depth and explained.fading(candidate)):
                    return candidate
                return attempt.as_radiation(self.level, candidate)
            except BudgetError as out:
                if out.meter is not meter:
                    raise
                self._not_tried(suspect.label)
        return None

    def _small(self, suspect: Suspect, prior: float, depth: int) -> Candidate | None:
        """A suspect where little is missing: fitted from the best places of its grid, or from its own starts where a
        place says nothing of the others, if one could gain enough."""
        if suspect.at_the_beginning or suspect.told_by_springs:  # a step from waters of each spring's own shows neither
            return from_starts(self.level, self.best, suspect, prior, self.best.fit.criterion)
        ahead = self._peaks(suspect)[:REFINED]
        if not ahead or ahead[0].gain * math.sqrt(self.best.fit.memory) < LEAST_GAIN:
            if not depth:
                self._screen_out(suspect, prior, ahead[0].gain if ahead else 0.0)
            return None
        if suspect.look is not None:
            return from_starts(self.level, self.best, suspect, prior, self.best.fit.criterion, looked=ahead)
        return from_places(self.level, self.best, suspect, ahead, prior)

    def _large(self, suspect: Suspect, prior: float) -> Candidate | None:
        """A suspect where much is missing: from several starts, and where its own line lies beyond them from that; a
        line that leaves the fit no way to it but a start on it (a clock) from the peaks of its grid, and from the
        body's own rate, where what is far from the motion has no peak."""
        if not suspect.on_a_line:
            most = self.best.fit.criterion if suspect.has_no_zero else math.inf
            seen = self._peaks(suspect)[:1] if suspect.swings and not self.best.suspects else ()
            further = beyond_starts(self.level, suspect, seen)
            looked = self._peaks(suspect)[:REFINED] if suspect.look is not None else ()
            return from_starts(self.level, self.best, suspect, prior, most, further, looked)
        ahead = self._peaks(suspect)[: REFINED + 1]
        further = () if self.best.suspects else own_rates(self.level)
        return from_places(self.level, self.best, suspect, ahead, prior, further) if ahead else None

    def _peaks(self, suspect: Suspect) -> tuple[GridPlace, ...]:
        """The best places of a suspect's grid as seen from what stands; looks from the prescribed equation are kept."""
        if self.stands is None or self.stands.fit.solution is not self.best.fit.solution:
            self.stands = Stands.of(self.best.fit)
        seen = places(self.level, self.stands, suspect)
        if not self.best.suspects:
            self.looks[suspect.label], self.looked = seen, self.stands
        return peaks(seen)

    def _screen_out(self, suspect: Suspect, prior: float, gain: float) -> None:
        """Keep what a suspect could gain at most, with the penalty of its unknowns."""
        relative = prior - self.null.log_prior + gain - attempt.penalty_of(self.level, self.null.fit, suspect)
        self.screened[suspect.label] = Screened(suspect, gain, self.null.score + relative, relative)

    def _not_tried(self, label: str) -> None:
        """Say that something was not tried to the end, where it is asked for: not of what is tried beside on top."""
        self.unfinished += [label] if self.asked_for else []

    def _promising(self, suspect: Suspect) -> bool:
        """Whether a suspect is tried beside what is there: one that often is, or that alone had evidence for it."""
        alone = (c.score - self.null.score for c in self.found if c.names == (suspect.name,))
        return suspect.often_beside or max(alone, default=0.0) > EVIDENCE_ALONE


def beyond_starts(level: Level, suspect: Suspect, seen: Sequence[GridPlace]) -> tuple[float, ...]:
    """Frequencies of places of a suspect's grid to which no fit from its starts would come."""
    starts = suspect.starts(level.scales)
    found = (a.start for place in seen for a in place.additions if a.unit == "rad/s")
    return tuple(w for w in found if not starts[0] / OUT_OF_REACH <= w <= starts[-1] * OUT_OF_REACH)


def own_rates(level: Level) -> tuple[float, ...]:
    """The body's rates on its springs, the slowest and the fastest, one where they are alike."""
    slow, fast = level.scales.slowest, level.scales.fastest
    return (slow, fast) if fast > slow * OUT_OF_REACH else (fast,)
