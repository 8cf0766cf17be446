"""What the equation of a harmonic set lacks: laws tried one by one, proved on points that nobody fitted.

A law is added by the driven bodies' rule (driven_search.py), with points in place of samples: the steady motions at
points that were held back come closer by `CLOSER`, those at points left out in turn do so surely, against their own
scatter, and its coefficient is not 0. A point of a set is an experiment of its own: its noise does not hang together
with its neighbour's, as that of a record does, so that fewer standard errors are asked for.

Belongs here: the list of suspects, judging, the order. Does not belong here: fits (methods/harmonic_set.py), words.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.stats import chi2

from undertow.comparison.driven_folds import CLOSER, Tried, ratio_of
from undertow.comparison.driven_search import ROUNDS, SURE
from undertow.comparison.driven_suspects import STATIC
from undertow.conditioning.harmonic import HarmonicSet
from undertow.equation.driven_laws import find_driven, places
from undertow.equation.structure import StribeckFriction
from undertow.equation.term import Array, Term
from undertow.errors import IdentificationError
from undertow.methods.harmonic_set import HarmonicFit, fit_harmonic_set, missed_at

FOLDS = 5
"""Points are held back, and left out in turn, by fifths: every fifth point of a sweep."""
FEWEST_POINTS = 25
"""Points below which no law is tried: twenty are fitted, five more are held back."""
DEVIATIONS = 3.0
"""Standard errors by which the ratio of squared errors must be below 1: by chance one law in 700 is."""
ENOUGH = 0.01
"""How often noise alone must leave as much as is left, or more than noise is said to be left."""
DRAWS = 4999
"""Draws of signs that what is left is held against."""

COSTLY = (StribeckFriction.name,)
"""Tried where it is named: a fit takes a hundred times as long."""
UNSEEN_LAWS = ("asymmetric_stiffness", "asymmetric_damping", "position_damping", "constant_force")
"""Laws that by symmetry have no part at the drive's frequency in first order: amplitude and phase hardly show them."""
TRYING = 15
"""Evaluations that tell what a law is worth; what is kept is fitted to the end."""
RIVAL = 1.5
"""Times what the closest law misses at unseen points up to which another one is held against it."""

Sweep = np.ndarray
"""Places of the points of one sweep in a set, by frequency."""


@dataclass(frozen=True)
class ResponseFound:
    """The equation as given and with what it lacked, both fitted to everything, and how that was decided.

    ``validation`` is the rms of what both miss at points that were held back (``unseen``, mask (n,)); ``added`` the
    laws' names, ``alternatives`` pairs of an added law and one that the points cannot tell from it. ``p_value`` is how
    often noise alone would leave what is left; ``unchecked`` why no law was tried, empty where laws were; ``proof`` are
    the two equations fitted to the other points alone.
    """

    baseline: HarmonicFit
    augmented: HarmonicFit | None
    added: tuple[str, ...]
    alternatives: tuple[tuple[str, str], ...]
    tried: tuple[Tried, ...]
    validation: tuple[float, float]
    unseen: np.ndarray
    p_value: float
    unchecked: str = ""
    proof: tuple[HarmonicFit, HarmonicFit] | None = None

    @property
    def best(self) -> HarmonicFit:
        """The equation with what was added."""
        return self.augmented or self.baseline

    @property
    def adequate(self) -> bool:
        """Whether what is left may be noise."""
        return self.p_value > ENOUGH


def every_fifth(along: Sequence[Sweep], points: int) -> np.ndarray:
    """Mask (points,) of every fifth point of each sweep, the third first: never its lowest or highest frequency.

    >>> every_fifth([np.arange(8)], 8).nonzero()[0]
    array([2])
    """
    mask = np.zeros(points, dtype=bool)
    for sweep in along:
        mask[sweep[FOLDS // 2 : -1 : FOLDS]] = True
    return mask


def suspects_for(measured: HarmonicSet, terms: Sequence[Term], named: Sequence[str] | None) -> list[str]:
    """Laws of x and v that may be missing: all that act at the drive's frequency, or those of them that are named."""
    every = [name for name in STATIC if name not in UNSEEN_LAWS]
    every += (["linear_damping"] if measured.mover == "base" else []) + ([*COSTLY] if named else [])
    own = {term.name for term in terms}
    return [name for name in every if name not in own and (named is None or name in named)]


def discover_response(
    measured: HarmonicSet,
    along: Sequence[Sweep],
    terms: Sequence[Term],
    held: Mapping[str, float],
    suspects: Sequence[str] | None = None,
    held_out: np.ndarray | None = None,
    seed: int = 0,
) -> ResponseFound:
    """The equation's numbers, and which laws it lacks, proved on points ``held_out`` (mask; None: every fifth).

    ``along`` are the set's sweeps, ``suspects`` the laws that may be added (None: all that fit, empty: none). Raises
    IdentificationError where the points are fewer than the unknowns.
    """
    unseen = every_fifth(along, measured.rate.size) if held_out is None else held_out
    if lacking := _too_few(measured, terms, unseen):
        base, nothing = fit_harmonic_set(measured, terms, held, {}), (math.nan, math.nan)
        none, p_value = np.zeros(unseen.size, dtype=bool), _p_value(base, measured, along, seed)
        return ResponseFound(base, None, (), (), (), nothing, none, p_value, lacking)
    folds = _folds(along, unseen)
    search = _PointSearch(measured.part(~unseen), measured.part(unseen), folds, held, suspects)
    first = current = search.fitted(tuple(terms))
    tried, added, rivals = list[Tried](), list[str](), list[tuple[str, str]]()
    for _ in range(ROUNDS):
        best, alike, more = search.round(current)
        tried += more
        if best is None:
            break
        current = best
        added.append(more[-1].name)
        rivals += [(added[-1], name) for name in alike]
    for name in added[:-1]:
        if (leaner := search.without(current, name)) is not None:
            current = leaner
            added.remove(name)
    alternatives = tuple(pair for pair in rivals if pair[0] in added)
    baseline = fit_harmonic_set(measured, terms, held, {}, whole=False)
    augmented = fit_harmonic_set(measured, current.fit.terms, held, current.starts, whole=False) if added else None
    p_value = _p_value(augmented or baseline, measured, along, seed)
    validation = first.unseen_rms, current.unseen_rms
    unchecked = "" if tried else "discrepancy.suspects names no law that can be tried on a harmonic set"
    return ResponseFound(
        baseline, augmented, tuple(added), alternatives, tuple(tried), validation, unseen, p_value, unchecked,
        (first.fit, current.fit),
    )  # fmt: skip


def _too_few(measured: HarmonicSet, terms: Sequence[Term], unseen: np.ndarray) -> str:
    """Why no law is tried; empty where points are enough."""
    held_out, points = int(np.sum(unseen)), measured.rate.size
    fitted = points - held_out
    if points < FEWEST_POINTS or held_out < FOLDS or fitted < (FOLDS - 1) * FOLDS:
        return (
            f"of {points} points {held_out} are held out; laws are tried where {(FOLDS - 1) * FOLDS} are fitted and "
            f"{FOLDS} held out"
        )
    numbers = len(places(terms, measured.mover)) + 2
    if fitted * (FOLDS - 1) // FOLDS < numbers:
        return f"{fitted} points are fitted, too few to leave a fifth of them out beside {numbers} numbers"
    return ""


def _folds(along: Sequence[Sweep], unseen: np.ndarray) -> np.ndarray:
    """The fifth of each training point, (training points,): in turn along each sweep."""
    fold = np.zeros(unseen.size, dtype=np.int64)
    for sweep in along:
        seen = sweep[~unseen[sweep]]
        fold[seen] = np.arange(seen.size) % FOLDS
    return np.asarray(fold[~unseen])


@dataclass(frozen=True)
class _Candidate:
    """An equation fitted to the training points, and what it misses at unseen ones; ``left_out`` are squared errors at
    training points by fits without them, (training points,), where they were asked for."""

    fit: HarmonicFit
    unseen_rms: float
    left_out: Array = field(default_factory=lambda: np.zeros(0))

    @property
    def starts(self) -> dict[str, float]:
        """Its free numbers."""
        return {name: value for name, value in self.fit.values.items() if name not in self.fit.held}


@dataclass(frozen=True)
class _PointSearch:
    """One law after the other on training points; ``proof`` are the points that nobody fitted."""

    training: HarmonicSet
    proof: HarmonicSet
    fold: np.ndarray
    held: Mapping[str, float]
    suspects: Sequence[str] | None

    def fitted(self, terms: tuple[Term, ...]) -> _Candidate:
        """An equation on the training points."""
        fit = fit_harmonic_set(self.training, terms, self.held, {}, whole=False, evaluations=TRYING)
        return _Candidate(fit, float(np.sqrt(np.mean(missed_at(fit, self.proof) ** 2))))

    def with_left_out(self, one: _Candidate) -> _Candidate:
        """The same with what it misses at training points left out in turn."""
        if one.left_out.size:
            return one
        left_out = np.zeros(self.training.rate.size)
        for fold in range(FOLDS):
            out = self.fold == fold
            part = fit_harmonic_set(self.training.part(~out), one.fit.terms, self.held, one.starts, False, TRYING)
            left_out[out] = np.sum(missed_at(part, self.training.part(out)) ** 2, axis=0)
        return replace(one, left_out=left_out)

    def without(self, current: _Candidate, name: str) -> _Candidate | None:
        """The same equation without a law, where points come no surely closer with it; else None. What was added first
        may only have stood in for what was added later."""
        lean = self.fitted(tuple(term for term in current.fit.terms if term.name != name))
        if not _no_closer(lean.unseen_rms, current.unseen_rms):
            return None
        lean, current = self.with_left_out(lean), self.with_left_out(current)
        return lean if _not_surely(lean.left_out, current.left_out) else None

    def round(self, current: _Candidate) -> tuple[_Candidate | None, tuple[str, ...], list[Tried]]:
        """The law that comes closest to unseen points of those that hold, rivals that the points cannot tell from it,
        and all that was tried (the law that is taken last)."""
        before, fits, because = current.unseen_rms, dict[str, _Candidate](), dict[str, str]()
        for name in suspects_for(self.training, current.fit.terms, self.suspects):
            try:
                fits[name] = self.fitted((*current.fit.terms, find_driven(name)))
            except IdentificationError as reason:
                because[name] = str(reason)
                continue
            because[name] = _unsure(name, fits[name].fit) or _no_closer(before, fits[name].unseen_rms)
        first, alike = "", list[str]()
        for name in sorted((n for n in fits if not because[n]), key=lambda n: fits[n].unseen_rms):
            if first and fits[name].unseen_rms > RIVAL * fits[first].unseen_rms:
                because[name] = f"{first} comes closer"
                continue
            current, fits[name] = self.with_left_out(current), self.with_left_out(fits[name])
            because[name] = _not_surely(current.left_out, fits[name].left_out)
            if first and not because[name]:
                told = not _not_surely(fits[name].left_out, fits[first].left_out, SURE)
                because[name] = f"{first} comes closer" if told else f"not distinguishable from {first}"
                alike += [] if told else [name]
            first = first or ("" if because[name] else name)
        tried = [Tried(name, math.nan, before, fits[name].unseen_rms if name in fits else math.inf, because[name])
                 for name in sorted(because, key=lambda name: name == first)]  # fmt: skip
        return (fits[first] if first else None), tuple(alike), tried


def _unsure(name: str, fitted: HarmonicFit) -> str:
    """Why a law's coefficient may as well be 0; empty where not."""
    coefficient = find_driven(name).coefficient.name
    number = fitted.numbers[f"{name}.{coefficient}"]
    if abs(number.value) > SURE * number.stderr:
        return ""
    found = f"{number.value:.3g} +- {number.stderr:.2g} {number.unit}"
    return f"{coefficient} is {found}, within {SURE:g} standard errors of 0"


def _no_closer(before: float, after: float) -> str:
    """Why unseen points speak against a law; empty where they do not."""
    return "" if after < (1.0 - CLOSER) * before else f"unseen points come no closer: {after:.4g} after {before:.4g}"


def _not_surely(before: Array, after: Array, deviations: float = DEVIATIONS) -> str:
    """Why squared errors ``after`` (n,) are no sure gain over ``before`` (n,), by the ratio of their sums; empty where
    they are."""
    ratio, error = ratio_of(before, after)
    if 1.0 - ratio > deviations * error:
        return ""
    return (
        f"points left out in turn come no surely closer: their squared errors are {ratio:.3g} +- {error:.2g} of what "
        f"they were, where {deviations:g} standard errors below 1 are asked for"
    )


def _p_value(fitted: HarmonicFit, measured: HarmonicSet, along: Sequence[Sweep], seed: int) -> float:
    """How often noise alone would leave what is left: points that are neighbours in a sweep err alike, held against
    the same errors with signs drawn anew; where errors are stated also by its size (Bonferroni: the smaller, twice)."""
    sigma = measured.sigma if measured.sigma.size else np.ones(measured.rate.size)
    left = fitted.missed / sigma
    pairs = np.concatenate([np.stack([sweep[:-1], sweep[1:]]) for sweep in along], axis=1)
    products = left[:, pairs[0]] * left[:, pairs[1]]
    signs = np.random.default_rng(seed).choice((-1.0, 1.0), (DRAWS, *left.shape))
    drawn = np.einsum("dcp,cp->d", signs[:, :, pairs[0]] * signs[:, :, pairs[1]], products)
    alike = (1.0 + float(np.sum(drawn >= np.sum(products)))) / (1.0 + DRAWS)
    if not measured.sigma.size:
        return alike
    size = float(chi2.sf(np.sum(left**2), left.size - len(fitted.free)))
    return min(1.0, 2.0 * min(alike, size))
