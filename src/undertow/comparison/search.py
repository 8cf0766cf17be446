"""What is missing: suspects ranked by evidence on one level, alone and together.

Every suspect is added to the prescribed equation and everything is refitted, jointly over the level's training trials
and springs. The criterion (joint.py) is turned into probabilities with a stated prior: half that nothing is missing,
half shared equally among the suspects, and a hundredth of that for each further effect. A suspect whose numbers mean
nothing (on a bound, not distinct from zero) is out. Rivals within odds of 99 to 1 are named beside the answer.

Belongs here: the search. Does not belong here: the fits that it asks for (trying.py), beliefs (joining.py,
candidate.py), what is explained (explained.py), the proof on held-out trials (validation.py), words (judge.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from undertow.comparison import attempt, explained
from undertow.comparison.after_release import shows_later
from undertow.comparison.attempt import from_pair
from undertow.comparison.candidate import Candidate, LevelDiagnosis, conclude
from undertow.comparison.clock import changes
from undertow.comparison.explained import ALL, NEARLY_ALL, SLIDING, asked, beyond_doubt, biases, explains, hides
from undertow.comparison.joining import MOST_EFFECTS, PRIOR_NOTHING, has_room, may_pair
from undertow.comparison.joint import at_memory, free_run_error, missed_share
from undertow.comparison.level import Level
from undertow.comparison.limits import FAR_ABOVE_NOISE, OVERWHELMING, WORTH
from undertow.comparison.needless import leanest, shorter_sets
from undertow.comparison.prescribed import FURTHER, further_on, plain_fit
from undertow.comparison.suspect import Suspect
from undertow.comparison.trying import LEAST_GAIN, LINEAR, ODDS, Trying
from undertow.comparison.two_effects import PAIRS, best_pairs
from undertow.likelihood.noise import residual_memory

REMAINING = 0.8
"""A further effect must leave at most this share of the free run's error that stood before it."""

BESIDE = 2
"""Where no single effect is enough, so many of the most probable ones are tried with another."""


class _Search(Trying):
    """One level's search as it goes on."""

    def run(self) -> LevelDiagnosis:
        """Add effects one after the other until none is worth it, or the level's budget is spent."""
        self._grow()
        small = None if self.best.suspects else self._overwhelming()
        rest = list(self.screened.values()), small, len(self.suspects), self.unfinished, self.looks
        return conclude(self.null, self.best, self.found, *rest)

    def _grow(self) -> None:
        for depth in range(MOST_EFFECTS):
            near = self.error <= 1.0 and self.best.fit.misfit <= FAR_ABOVE_NOISE
            if depth and (near or len(self.best.suspects) == MOST_EFFECTS):
                break
            tried = self._as_far_as_possible(depth)
            tried = self._further_on(tried) if depth else self._first(self._anew(tried))
            self.found += tried
            possible = sorted((c for c in tried if not c.out), key=lambda c: -c.score)
            probable = [c for c in possible if c.score > self.best.score + ODDS]
            ahead = self._worthwhile(probable, REMAINING if depth else 1.0)
            if ahead is None and not depth:
                self._worthwhile([c for c in possible if abs(c.score - self.best.score) <= ODDS], 1.0)
            if ahead is None:
                ahead = self._without_one(tried, ODDS) if depth else self._two_at_once(tried, ODDS)
            if ahead is None:
                break
            ahead = self._leaner(*ahead, ahead[0].score) or ahead
            self._stand(*self._plainer(ahead, probable))
        self.best, self.error = self._two_that_leave_noise() or (self.best, self.error)
        self.best, self.error = self._from_another_first() or (self.best, self.error)
        self.best, self.error = self._beside_a_hook() or (self.best, self.error)
        self.best, self.error = self._hiding_beside() or (self.best, self.error)
        self.best, self.error = self._in_place_of_two() or (self.best, self.error)

    def _overwhelming(self) -> Candidate | None:
        """The most probable single law against which nothing but its size speaks; None where there is none."""
        able = (c for c in self.small if c.score - self.null.score > OVERWHELMING)
        return max(able, key=lambda c: c.score, default=None)

    def _leaner(self, candidate: Candidate, error: float, least: float) -> tuple[Candidate, float] | None:
        """The same last effect without an earlier one that it makes needless (needless.py), and its error."""
        shorter = shorter_sets(self.level, self.null.fit, candidate, self._prior)
        self.found += [one for one, _ in shorter]
        return leanest(shorter, error, least)

    def _without_one(self, tried: Sequence[Candidate], least: float) -> tuple[Candidate, float] | None:
        """The leanest of the candidates that would be more probable than what stands, by ``least`` in log evidence, but
        for a number that means nothing: an earlier effect's any more, or the last one's at all."""
        doubted = [c for c in tried if c.out and len(c.suspects) > 1 and c.score > self.best.score + least]
        lean = [found for c in doubted if (found := self._leaner(c, self.error, self.best.score + least)) is not None]
        return max(lean, key=lambda pair: pair[0].score, default=None)

    def _two_at_once(self, tried: Sequence[Candidate], least: float) -> tuple[Candidate, float] | None:
        """Two effects of which neither is enough alone, where what is left lies far above noise: further effects beside
        the most probable single ones, or one that is found beside another alone, if that is more probable than any
        single one that the free run hardly shows. Where repetitions differ as much, two must explain nearly all."""
        if self.null.fit.misfit <= FAR_ABOVE_NOISE:
            return None
        pairs = self._beside(tried)
        most = max([self.null.score + least, *(c.score for c in self.small)])
        probable = sorted((c for c in pairs if not c.out and c.score > most), key=lambda c: -c.score)
        lean = self._without_one(pairs, least)
        if self.error <= 1.0:
            probable = [c for c in probable if explains(self.null, c, ALL)]
        ahead = self._worthwhile(probable, REMAINING)
        return ahead or (self._worthwhile([lean[0]], 1.0) if lean and lean[0].score > most else None)

    def _beside(self, singles: Sequence[Candidate]) -> list[Candidate]:
        """Further effects beside the most probable of these, whether a gate excludes it alone or not."""
        able, stands = [c for c in singles if not c.suspects[0].of_the_release], self.best
        pairs: list[Candidate] = []
        for first in sorted(able, key=lambda c: -c.score)[:BESIDE]:
            self.best = first
            pairs += self._as_far_as_possible(1)
        self.best = stands
        pairs = self._first(pairs)
        self.found = [*self.found, *pairs]
        return pairs

    def _from_another_first(self) -> tuple[Candidate, float] | None:
        """Two effects, with the free run's error, that are more probable than an answer which leaves much of what lies
        far above noise, and, of several effects, more than repetitions differ by: of two strong effects either may hide
        what the other alone would explain. A lone force that changes along the record, with numbers of its own in every
        trial, may hold any two that die out, and a release that leaves more than noise any that die out at once. In
        place of one effect that comes as close as repetitions two must explain nearly all of it."""
        noisy, one = self.best.fit.misfit > FAR_ABOVE_NOISE, len(self.best.suspects) == 1
        short = noisy and not explains(self.null, self.best, ALL)
        any_two = one and (changes(self.best.fit.addends[-1]) or (noisy and self.best.suspects[0].of_the_release))
        if any_two or (short and self.error > 1.0 and self.best.suspects):
            return self._other_pair(self.best.suspects[:1])
        before = self.null, self.best, self.found, self.small, self.screened
        pair = self._other_pair(self.best.suspects) if one and short else None
        if pair is None or not explains(self.null, pair[0], ALL):  # what only describes is no rival of what was not
            self.null, self.best, self.found, self.small, self.screened = before  # looked for either
            return None
        return pair

    def _in_place_of_two(self) -> tuple[Candidate, float] | None:
        """Two effects, with the free run's error, that are more probable than two beside which a third is likely: of a
        dashpot and a drag of another power one is chosen before a resonator is known, and a third makes good for it."""
        both = set(self.best.suspects)
        more = max((c.score for c in self.found if not c.out and both < set(c.suspects)), default=-math.inf)
        return self._other_pair(self.best.suspects) if len(both) == 2 and more > self.best.score + ODDS else None

    def _other_pair(self, taken: Sequence[Suspect]) -> tuple[Candidate, float] | None:
        """The most probable pair that begins with a single effect of another name than those taken, with the free run's
        error, where it is more probable than what stands."""
        names = {s.name for s in taken}
        pairs = self._beside([c for c in self.found if len(c.suspects) == 1 and c.suspects[0].name not in names])
        able = [c for c in pairs if not c.out and c.score > self.best.score + ODDS]
        ahead = max(able, key=lambda c: c.score, default=None)
        return None if ahead is None else (ahead, free_run_error(self.level, ahead.fit))

    def _beside_a_hook(self) -> tuple[Candidate, float] | None:
        """A hook that let go slowly and an effect beside it, with the free run's error, that are more probable than an
        answer which asks nothing of the first periods: there the motion is largest, and what it leaves out with them
        shows most."""
        alone = [c for c in self.found if len(c.suspects) == 1 and c.fit.addends[0].hooked]
        if not self.best.suspects or not self.best.suspects[0].late or not alone:
            return None
        stands, self.best = self.best, max(alone, key=lambda c: c.score)
        pairs = self._as_far_as_possible(1)
        self.best = stands
        pairs = self._first(pairs)
        self.found += pairs
        able = [c for c in pairs if not c.out and c.score > self.best.score + ODDS]
        ahead = max(able, key=lambda c: c.score, default=None)
        return None if ahead is None else (ahead, free_run_error(self.level, ahead.fit))

    def _hiding_beside(self) -> tuple[Candidate, float] | None:
        """A law of the body that hides beside an answer as close as repetitions, with the free run's error: beside a
        resonator near the body's rate a dashpot is drag, and less added mass. One that the free run alone had set aside
        is such a law too; one whose numbers mean nothing may have led the answer itself out of a bad place."""
        enough = self.error <= 1.0 and self.best.fit.misfit <= FAR_ABOVE_NOISE
        if not enough or not 0 < len(self.best.suspects) < MOST_EFFECTS:
            return None
        beside = self._further_on(self._spending(1, [s for s in self.suspects if s.of_the_body], False))
        self.found += beside
        able = [c for c in self.found if c.score > self.best.score + OVERWHELMING and hides(self.best, c)]
        ahead = max(able, key=lambda c: c.score, default=None)
        return self._without_one(beside, ODDS) if ahead is None else (ahead, free_run_error(self.level, ahead.fit))

    def _two_that_leave_noise(self) -> tuple[Candidate, float] | None:
        """Two effects that explain nearly all, with the free run's error, where one leaves more, however close to the
        motion: two that mask each other are both weak alone."""
        far = missed_share(self.level, self.null.fit) > LINEAR  # one linear step tells nothing
        if far or self.looked is None or len(self.best.suspects) > 1:
            return None
        pairs: list[Candidate] = []
        by = {s.label: s for s in self.suspects if s.of_the_body}
        for look in best_pairs(self.level, self.looked, [p for n in by for p in self.looks.get(n, ())], PAIRS):
            both = by[look.labels[0]], by[look.labels[1]]
            if may_pair(*both) and (look.gain - look.alone) * math.sqrt(self.null.fit.memory) > LEAST_GAIN:
                prior, spent = self._prior(both), attempt.PAIR_BUDGET * self._one_look()
                pairs += from_pair(self.level, self.null, self.found, both, look.additions, prior, spent)
        self.found += pairs
        least = max(c.score for c in self.found if len(c.suspects) < 2 and (c.aside or not c.out)) + ODDS
        able = [c for c in pairs if not c.out and c.score > least and explains(self.null, c, ALL)]
        return max(((c, free_run_error(self.level, c.fit)) for c in able), key=lambda pair: pair[0].score, default=None)

    def _first(self, tried: list[Candidate]) -> list[Candidate]:
        """What was tried beside the prescribed equation, and all that was found before, valued at the memory of the
        closest: what a missing law leaves swings for long, and would pass for few samples of noise."""
        return self._lasting(self._valued(tried, min(tried, key=lambda c: c.fit.misfit, default=self.null)))

    def _further_on(self, tried: list[Candidate]) -> list[Candidate]:
        """The same beside what stands, where the closest of the candidates is more probable than that then."""
        closest = min((c for c in tried if not c.out), key=lambda c: c.fit.misfit, default=self.null)
        one, other = (at_memory(c.fit, self._memory(closest)).criterion for c in (closest, self.best))
        ahead = 0.5 * (other - one) + closest.log_prior - self.best.log_prior
        return self._lasting(self._valued(tried, closest) if ahead > ODDS else tried)

    def _lasting(self, tried: list[Candidate]) -> list[Candidate]:
        """The candidates without what would be an answer beside a slow hook, and does not show after the release."""
        least = self.best.score + ODDS
        return [c for c in tried if c.out or c.score < least or shows_later(self.level, c)]

    def _memory(self, closest: Candidate) -> float:
        """Memory between that of what stands (or the equation) and that of a candidate's residual."""
        return math.sqrt(self.memory * residual_memory(closest.fit.solution))

    def _valued(self, tried: list[Candidate], closest: Candidate) -> list[Candidate]:
        """The candidates, and all that was found before, valued at the memory of one of them, if it is shorter."""
        memory = self._memory(closest)
        if memory >= self.null.fit.memory:
            return tried
        old = [self.null, self.best, *self.found, *self.small, *tried]
        new = {id(c): replace(c, fit=at_memory(c.fit, memory)) for c in old}
        self.null, self.best = new[id(self.null)], new[id(self.best)]
        self.found, self.small = ([new[id(c)] for c in many] for many in (self.found, self.small))
        self.screened = {k: replace(s, score=self.null.score + s.relative) for k, s in self.screened.items()}
        return [new[id(c)] for c in tried]

    def _stand(self, ahead: Candidate, error: float) -> None:
        """Let a candidate be what stands, all valued at the memory of what it leaves, and fitted once more there."""
        self.best, self.error = ahead, error
        self._valued([], self.best)
        again = attempt.at_own(self.level, self.best)
        self.found = [again if c is self.best else c for c in self.found]
        self.best, self.memory = again, min(residual_memory(again.fit.solution), self.memory)

    def _worthwhile(self, probable: Sequence[Candidate], remaining: float) -> tuple[Candidate, float] | None:
        """The most probable candidate that brings the free run closer by what counts, with its error; where none does,
        the most probable one if it is beyond doubt. A sensor must be the most probable of all, and so must a force with
        a size and a phase of its own in every trial, which takes up what a memory leaves.

        Those before it that do not are set aside. Behind one that the free run hardly shows another is an answer only
        if the free run shows that, and if it too leaves no more than noise where the one beyond doubt does.
        """
        doubtless: tuple[Candidate, float] | None = None
        behind = False
        for place, candidate in enumerate(probable):
            closer = free_run_error(self.level, candidate.fit)
            counts = closer < remaining * self.error and math.sqrt(self.error**2 - closer**2) > WORTH
            counts = counts or (not (behind or self.best.suspects) and closer <= 1.0 and biases(self.null, candidate))
            last = candidate.suspects[-1]
            if not explains(self.best, candidate, asked(candidate)):
                before, left = (math.sqrt(c.fit.misfit) for c in (self.best, candidate))
                self._set_aside([candidate], f"it leaves {left:.2g} of {before:.2g} times the sensors' noise", False)
                continue
            if place and last.has_its_own_clock:
                self._set_aside([candidate], f"{probable[0].suspects[-1].label} is the more probable answer")
                continue
            if doubtless is not None and doubtless[0].fit.misfit <= FAR_ABOVE_NOISE < candidate.fit.misfit:
                self._set_aside([candidate], f"{doubtless[0].suspects[-1].label} leaves no more than noise")
                continue
            if counts or not (behind or last.shown_by_free_run or (place and last.frees)):
                if doubtless is not None:
                    self._too_small(doubtless[0])
                return candidate, closer if counts else min(closer, self.error)
            behind = True
            if not place and beyond_doubt(self.best, candidate):
                doubtless = candidate, closer
                continue
            self._too_small(candidate)
        return doubtless

    def _too_small(self, candidate: Candidate) -> None:
        """Set a candidate aside because the free run hardly shows it."""
        gain = candidate.score - self.best.score
        self._set_aside([candidate], f"brings the free run closer by less than counts (log odds {gain:.0f})")
        if not self.best.suspects and len(candidate.suspects) == 1:
            self.small.append(candidate)

    def _plainer(self, ahead: tuple[Candidate, float], probable: Sequence[Candidate]) -> tuple[Candidate, float]:
        """Linear damping instead of a memory that does not ring, where the free run cannot tell them apart; bristles in
        friction's place instead of hysteresis beside which no friction is left, unless that is far more probable.

        Waves radiated away leave a memory; a spring's own damping (and added mass) is what it amounts to at that
        spring's frequency. It is then called damping that depends on frequency, with the reason. A memory that is more
        probable than damping stays its rival.
        """
        (candidate, error), bent = ahead, ahead[0].suspects[-1].without_sliding
        if bent and explained.slides(candidate) < SLIDING:
            names, least = (*candidate.names[:-1], bent), candidate.score - OVERWHELMING
            bristles = [c for c in probable if c.names == names and c.score > least]
            return (bristles[0], free_run_error(self.level, bristles[0].fit)) if bristles else ahead
        if not explained.single_fading(candidate):
            return ahead
        for other in (c for c in probable if len(c.suspects) == 1 and c.suspects[0].plain):
            stands = free_run_error(self.level, other.fit)
            far = other.fit.misfit > FAR_ABOVE_NOISE or candidate.score - other.score > OVERWHELMING
            doubtless = far and explains(other, candidate, NEARLY_ALL)
            if doubtless and not explained.fading(candidate):
                continue
            if stands < self.error and (stands <= 1.0 or stands**2 - error**2 < WORTH**2):
                reason = (
                    "a memory that fades within a cycle or two brings the free run no closer than linear damping does "
                    f"({error:.2g} against {stands:.2g} times repeatability)"
                )
                memories = [c for c in self.found if explained.single_fading(c) and c.score <= other.score]
                self._set_aside(memories, reason)
                if not explained.fading(candidate) or stands <= error:
                    return other, stands
                radiation = attempt.as_radiation(self.level, candidate)
                self.found.append(radiation)
                return radiation, free_run_error(self.level, radiation.fit)
        return ahead

    def _set_aside(self, candidates: Sequence[Candidate], reason: str, aside: bool = True) -> None:
        """Mark candidates as no answer, with the reason; ``aside``: whatever their evidence."""
        these = {id(c) for c in candidates}
        self.found = [
            replace(c, out=c.out or reason, aside=c.aside or (aside and not c.out)) if id(c) in these else c
            for c in self.found
        ]


def diagnose(
    level: Level, suspects: Sequence[Suspect], clean_when_dry: bool = False, budget: float = 1.0,
    told: Mapping[str, float] | None = None,
) -> LevelDiagnosis:
    """Search one level for what its equation lacks.

    ``clean_when_dry`` says that the dry trials of the same rig need nothing: what belongs to the structure would have
    shown there.

    Evidence alone would name effects that no free run shows (a gram of water, an amplifier's smoothing): what is named
    must also bring the free run of the training trials closer by `WORTH` of `Member.allowed`. Further effects are
    looked for until it is as close as repetitions and no more than noise is left; an equation that had ended short of
    its optimum is searched again. ``budget`` multiplies what may be spent, ``told`` is what other waters add to priors.

    Raises IdentificationError where not even the prescribed equation can be fitted.
    """
    null = Candidate((), plain_fit(level), math.log(PRIOR_NOTHING))
    usable = [s for s in suspects if has_room(level, s, null.fit)]
    found, again = _Search(level, usable, null, clean_when_dry, budget, told or {}).run(), FURTHER
    while again and (null_on := further_on(level, found.null, found.candidates, found.best)) is not None:
        on = _Search(level, usable, null_on, clean_when_dry, budget, told or {})
        found, again = on.run(), again - 1
    return found
