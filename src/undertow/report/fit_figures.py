"""Figures of how sure a group's answer is: suspects by evidence, replicas, correlations of the repaired numbers,
residual against noise, friction.

Each function takes a finished result and an Axes (or a Figure) and returns it; none fits, filters or saves. Does not
belong here: where a mismatch is (mismatch_figures.py), parameters by method (figures.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from scipy.special import ndtri

from undertow.comparison.tail import Histogram
from undertow.discrepancy.findings import GroupFindings, TrialFindings
from undertow.discrepancy.repaired import named_laws
from undertow.discrepancy.verdict import Described, Rejected, Verdict
from undertow.discrepancy.words import spelled
from undertow.quantities import Estimate
from undertow.recording.recording import Array
from undertow.report.arrange import by_amplitude, is_usable
from undertow.report.numbers import short_number
from undertow.report.style import BLUE, DRAWN, GREEN, GREY, INK, NOT_EXPLAINED, PALE, SKY, plain_log_ticks
from undertow.report.trial_figures import response, thinned
from undertow.report.wording import effects_words, estimate_text, p_words, parameter_words
from undertow.report.writing import true_minus

FRICTION = ("mu", "friction_N")
"""Under which names a trial's friction stands among its numbers: a coefficient, or a force (of a rotation a moment)."""

PAIRS_AT_MOST = 7
"""Parameters of a pair plot: more have no room for their names."""

TIGHT = 0.9
"""Correlation from which two numbers are known together better than each alone."""

LAGS_IN_SWINGS = 3.0
"""Lags of an autocorrelation, in swings of the body."""

LAGS_AT_MOST = 240
"""Points of an autocorrelation."""

QUANTILES = 80
"""Points of a quantile plot."""

SUSPECTS_AT_MOST = 14
"""Bars of suspects: the strongest."""

FAR_APART = 30.0
"""Logarithms of odds beyond which their axis is a logarithm's too."""

POORLY_KNOWN = 5.0
"""A rest position whose error is this many times the median one does not widen the frame."""

HOLDS_DIFFER = 1.5
"""The longest hold must be this many times the shortest before friction is drawn against it."""


def odds_beside(verdict: Verdict) -> str:
    """What the odds of a verdict's rejected suspects are beside, in words: what is said, the candidate that comes
    closest where that is not said, or the equation as it is.

    The search's best set is in no list of rejected suspects; the conditions name it, and where nothing was best the
    strongest suspect, which was rejected.
    """
    if named_laws(verdict):
        words = effects_words(name for name in verdict.verdict if name != "unknown")
        return f"{words} (closest, not proved)" if verdict.status == "unknown" else words
    tested = next((gate.statistic for gate in verdict.decision if gate.gate == "evidence"), "")
    names = tested.removeprefix("log odds of ").removesuffix(" over nothing").split("+")
    if not tested or {*names} & {one.name for one in verdict.rejected}:
        return "the equation as it is"
    return f"{effects_words(names)} (closest, not said)"


def draw_suspects(said: str, others: Sequence[Rejected], figure: Figure) -> Figure:
    """Bars: log10 of the odds of every suspect beside what is ``said`` (zero, the diamond); orange: more than it."""
    axes = figure.subplots()
    rows = sorted((r for r in others if math.isfinite(r.log_odds)), key=lambda r: -r.log_odds)[:SUSPECTS_AT_MOST]
    odds = [r.log_odds / math.log(10.0) for r in rows]
    axes.barh(range(1, len(rows) + 1), odds, height=0.6, color=[NOT_EXPLAINED if o > 0.0 else BLUE for o in odds])
    axes.plot([0.0], [0], "D", color=GREEN, ms=6.0, clip_on=False)
    for at, value in enumerate(odds, 1):
        side, align = (3, "left") if value >= 0.0 else (-3, "right")
        words = true_minus(f"{value:.0f}" if abs(value) >= 10.0 else short_number(value, 2))
        axes.annotate(words, (value, at), (side, 0), textcoords="offset points", va="center", ha=align, fontsize=7.5)
    axes.axvline(0.0, color=GREY, lw=0.6)
    axes.set_yticks(range(len(rows) + 1), [said, *(spelled(r.name) for r in rows)])
    if max(map(abs, odds), default=0.0) > FAR_APART:
        axes.set_xscale("symlog", linthresh=1.0)
        axes.xaxis.set_major_formatter(lambda value, _: true_minus(f"{value:.0f}"))
    axes.margins(x=0.1)
    axes.invert_yaxis()
    axes.grid(axis="y", visible=False)
    axes.set_xlabel(f"log10 of the odds beside {said}")
    return figure


def draw_null(scores: Histogram, p_value: float, figure: Figure) -> Figure:
    """Histogram of the largest score of every replica in which nothing is missing, the score beyond which a
    level is not like them, and this level's own; scores as minus log10 of a probability."""
    axes = figure.subplots()
    to_log10 = 1.0 / math.log(10.0)
    axes.stairs(scores.counts, scores.edges * to_log10, fill=True, color=PALE)
    axes.stairs(scores.counts, scores.edges * to_log10, color=GREY, lw=0.7)
    axes.axvline(scores.limit * to_log10, color=GREY, ls="--", lw=0.9, label="beyond: not like the replicas")
    own, colour = scores.own * to_log10, NOT_EXPLAINED if scores.own > scores.limit else BLUE
    axes.axvline(own, color=colour, lw=1.6, label=f"this level, {p_words(p_value)}")
    axes.set_xscale("log")
    low = min(scores.edges[0] * to_log10, own) if own > 0.0 else scores.edges[0] * to_log10
    high = max(scores.edges[-1], scores.limit, scores.own) * to_log10
    axes.set_xlim(low / 1.1, high * 1.15)
    plain_log_ticks(axes.xaxis, [low, high])
    axes.set_ylim(bottom=0.0)
    axes.grid(axis="y", visible=False)
    axes.set(xlabel="largest score of any suspect (minus log10 of its probability)", ylabel="replicas")
    figure.legend(handles=list(axes.lines), loc="outside upper left", ncols=2)
    return figure


def pair_names(repaired: Described) -> list[str]:
    """Parameters of a pair plot: those fitted together that have an error, the most correlated first where many."""
    numbers, matrix = repaired.parameters, repaired.correlations
    usable = [n for n in numbers if n in matrix and is_usable(numbers[n])]
    strength = {n: max((abs(matrix[n].get(o, 0.0)) for o in usable if o != n), default=0.0) for n in usable}
    kept = sorted(usable, key=lambda n: -strength[n])[:PAIRS_AT_MOST]
    return [n for n in usable if n in kept]


def draw_pairs(repaired: Described, axes: Axes) -> Axes:
    """Ellipses of one and two standard errors of every pair of the repaired equation's numbers, each pair in its own
    cell and to the scale of its errors, with the correlation in the corner that its ellipse leaves free; the numbers
    stand at the sides."""
    names = pair_names(repaired)
    around = np.linspace(0.0, 2.0 * math.pi, 29)
    for row in range(1, len(names)):
        for column in range(row):
            r = repaired.correlations[names[row]].get(names[column], 0.0)
            turned = r * np.cos(around) + math.sqrt(max(1.0 - r * r, 0.0)) * np.sin(around)
            rings = [np.column_stack([column + s * np.cos(around), -row + s * turned]) for s in (0.2, 0.4)]
            axes.add_collection(LineCollection(rings, colors=[BLUE, SKY], linewidths=1.0))
            colour, side = NOT_EXPLAINED if abs(r) > TIGHT else INK, 1.0 if r < 0.0 else -1.0
            axes.text(
                column + 0.46 * side, -row + 0.46, true_minus(f"{round(r, 2) + 0.0:+.2f}"), fontsize=7.5,
                va="top", ha="right" if side > 0.0 else "left", color=colour,
            )  # fmt: skip
    marks = [Line2D([], [], color=BLUE, label="one standard error"), Line2D([], [], color=SKY, label="two")]
    marks.append(Line2D([], [], ls="none", label="number: correlation"))
    axes.figure.legend(handles=marks, loc="outside upper left", ncols=3)
    axes.set_xlim(-0.5, len(names) - 1.5)
    axes.set_ylim(-len(names) + 0.5, -0.5)
    sides = [f"{parameter_words(n).replace(': ', chr(10))}\n{estimate_text(repaired.parameters[n])}" for n in names]
    axes.set_yticks([-i for i in range(1, len(names))], sides[1:], fontsize=7.5)
    axes.set_xticks(range(len(names) - 1), sides[:-1], fontsize=7.5)
    axes.set_xticks(np.arange(len(names)) - 0.5, minor=True)
    axes.set_yticks(-np.arange(len(names)) - 0.5, minor=True)
    axes.grid(which="major", visible=False)
    axes.grid(which="minor", visible=True)
    axes.tick_params(which="both", length=0)
    return axes


def left_after(trial: TrialFindings) -> Array:
    """What the believed equation's free run leaves of a trial, (n,), in the unit it is drawn in."""
    residual = trial.measured - trial.simulated if trial.augmented is None else trial.augmented.residual
    return np.asarray(residual[np.isfinite(residual)] * response(trial).factor, dtype=np.float64)


def draw_noise(trial: TrialFindings, period: float, figure: Figure) -> Figure:
    """Autocorrelation of what the believed equation leaves of one trial, grey the 95 % band of white noise; and its
    quantiles against those of the sensor's noise, grey a residual that is nothing else."""
    left, right = figure.subplots(1, 2)
    residual = left_after(trial)
    residual = residual - residual.mean()
    step = float(np.median(np.diff(trial.t)))
    lags = np.arange(min(residual.size // 2, max(int(LAGS_IN_SWINGS * period / step), 10)))
    size = 1 << (2 * residual.size - 1).bit_length()
    power = np.abs(np.fft.rfft(residual, size)) ** 2
    correlation = np.fft.irfft(power)[: lags.size] / max(float(residual @ residual), 1e-300)
    white = 1.96 / math.sqrt(residual.size)
    left.axhspan(-white, white, color=PALE, lw=0)
    left.plot(*thinned(lags * step, correlation, LAGS_AT_MOST), color=BLUE)
    left.set(xlabel="lag (s)", ylabel="autocorrelation")
    shown = response(trial)
    channel = "displacement" if shown.words in ("displacement", "angle") else "velocity"
    noise = trial.motion.noise.get(channel, 0.0) * shown.factor
    levels = (np.arange(QUANTILES) + 0.5) / QUANTILES
    normal = ndtri(levels)
    if noise > 0.0:
        words = f"sensor noise, {short_number(noise, 2)} {shown.unit}"
        right.plot(normal, normal * noise, color=GREY, lw=1.0, label=words)
    right.plot(normal, np.quantile(residual, levels), ".", ms=3.0, color=BLUE, label="residual")
    right.set(xlabel="quantile of a normal distribution", ylabel=f"residual ({shown.unit})")
    right.legend(loc="upper left")
    return figure


def hold_of(trial: TrialFindings) -> float:
    """How long the body was held before its release, s; nan where no hold was seen."""
    window = trial.motion.window
    return window.release_s - float(trial.motion.recording.time[0]) if window.held else math.nan


def friction_panels(group: GroupFindings) -> list[str]:
    """Which panels of friction say something of a group: "hold", "rest", "damping", "drag"."""
    laws = zip(group.equation.terms, group.equation.coefficients, strict=True)
    if not any(term.structural == "mu" and value > 0.0 for term, value in laws):
        return []
    singles = _singles(group)
    holds = [hold_of(t) for t, _ in singles if math.isfinite(hold_of(t))]
    out = []
    if len(singles) > 2 and len(holds) == len(singles) and max(holds) > HOLDS_DIFFER * min(holds):
        out.append("hold")
    if sum(1 for t in group.trials if math.isfinite(_resting(t))) > 1:
        out.append("rest")
    for panel, other in (("damping", "c_Ns_per_m"), ("drag", "drag_coefficient")):
        if sum(1 for _, numbers in singles if other in numbers) > 2:
            out.append(panel)
    return out


def _singles(group: GroupFindings) -> list[tuple[TrialFindings, dict[str, Estimate]]]:
    """Trials with a friction of their own, and all their numbers, from the first method that has them."""
    out: list[tuple[TrialFindings, dict[str, Estimate]]] = []
    for trial in by_amplitude(group.trials):
        for method in ("output_error", "sindy", "decay"):
            numbers = trial.fits[method].parameters if method in trial.fits else {}
            name = next((one for one in FRICTION if one in numbers), "")
            if name and is_usable(numbers[name]):
                out.append((trial, dict(numbers)))
                break
    alike = len({_friction_of(numbers).value for _, numbers in out}) < len(out)  # held at the dry trials' mean
    return [] if alike else out


def _friction_of(numbers: Mapping[str, Estimate]) -> Estimate:
    """A trial's friction: as a coefficient or, where it has none, as a force."""
    return next(numbers[name] for name in FRICTION if name in numbers)


def _resting(trial: TrialFindings) -> float:
    """Where a body rested in the end, about the centre of its motion, m; nan where it still moved."""
    motion = trial.motion
    tail = motion.t > motion.windowed("t")[-1]
    if "displacement" not in motion.recording.channels or np.count_nonzero(tail) < 10:
        return math.nan
    last = motion.recorded("displacement")[tail][np.count_nonzero(tail) // 2 :]
    noise = motion.noise.get("displacement", 0.0)
    still = float(np.std(last)) < 3.0 * noise
    return float(np.mean(last)) - motion.equilibrium.value if still else math.nan


def draw_friction(group: GroupFindings, panels: Sequence[str], figure: Figure) -> Figure:
    """Friction of single trials against the hold before them, against c and C_d; where bodies came to rest, with the
    band within which friction can hold them (mu N / k)."""
    singles = _singles(group)
    factor, unit = DRAWN[group.trials[0].motion.recording.coordinate]
    for kind, axes in zip(panels, figure.subplots(1, len(panels), squeeze=False)[0], strict=True):
        if kind == "rest":
            _draw_rest(group, axes, factor, unit)
            continue
        other = {"damping": "c_Ns_per_m", "drag": "drag_coefficient"}.get(kind, "")
        for trial, numbers in singles:
            if other and other not in numbers:
                continue
            place = numbers[other].value if other else hold_of(trial)
            error = numbers[other].total_stderr if other else 0.0
            mu = _friction_of(numbers)
            axes.errorbar([place], [mu.value], [mu.total_stderr], [error], fmt="o", ms=4.0, color=INK, elinewidth=0.8)
        named = "coefficient" if singles and "mu" in singles[0][1] else "force"
        unit_of = group.specimen.unit
        axes.set_ylabel(f"friction {named} of that trial ({'-' if named == 'coefficient' else unit_of('N')})")
        axes.set_xlabel({"hold": "hold before the release (s)",
                         "damping": f"viscous damping of that trial ({unit_of('N s/m')})",
                         "drag": "drag coefficient of that trial (-)"}[kind])  # fmt: skip
    return figure


def _draw_rest(group: GroupFindings, axes: Axes, factor: float, unit: str) -> None:
    values = dict(zip((t.name for t in group.equation.terms), group.equation.coefficients, strict=True))
    width = factor * values["coulomb_friction"] / values["stiffness"] if values.get("stiffness") else math.nan
    if math.isfinite(width):
        axes.axhspan(-width, width, color=PALE, lw=0, label="held by friction")
    rested = [(t.motion.amplitude, _resting(t), t.motion.equilibrium.total_stderr) for t in group.trials]
    size, place, error = factor * np.array([one for one in rested if math.isfinite(one[1])]).T
    axes.errorbar(size, place, error, fmt="o", ms=4.0, color=INK, elinewidth=0.8, label="a trial ± standard error")
    known = error <= POORLY_KNOWN * np.median(error)
    reach = 1.1 * max(float(np.max(np.abs(place[known]) + error[known])), width if math.isfinite(width) else 0.0)
    axes.set_ylim(-reach, reach)
    axes.set(xlabel=f"release amplitude ({unit})", ylabel=f"rest off the swing's centre ({unit})")
    axes.legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, borderaxespad=0.1, borderpad=0.0)
