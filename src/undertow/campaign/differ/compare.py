"""A simulation made elsewhere against a recording: two equations side by side, and what the simulation lacks.

Both files are read with the same mapping and conditioned alike; both motions are given the equation that evidence
keeps from one library (SINDy), its numbers by output error; the two stand side by side, number by number. What the
recording has and the simulation's form of equation has not is then named (lacking.py).

Belongs here: the order of work. Does not belong here: the result's shape (discrepancy/difference.py), reading files
(files.py), its sentence (words.py), its page and JSON (report/difference.py).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from undertow.campaign.differ.lacking import UNEXPLAINED, UNKNOWN, allowed_error, fitted, judged, let_go, more, needs
from undertow.campaign.differ.words import sentence_of
from undertow.comparison.deviations import SLOTS, size_in
from undertow.conditioning.motion import Motion
from undertow.discrepancy.cycle_by_cycle import CycleComparison, compare_cycles, sidebands
from undertow.discrepancy.difference import Difference, Side, TermRow
from undertow.discrepancy.place import locate
from undertow.discrepancy.verdict import Verdict
from undertow.discrepancy.words import spelled
from undertow.equation import registry
from undertow.equation.term import Term
from undertow.errors import RecordingError
from undertow.likelihood.fit import Specimen
from undertow.likelihood.free_run import FreeRun, as_released, repeatability, scored_channel, sensor_floor
from undertow.methods.baseline import GroupFit
from undertow.methods.dry import DEFAULT_SCATTER
from undertow.methods.sindy import discover


def compare_motions(
    simulation: Motion,
    recording: Motion,
    terms: Sequence[str] = (),
    specimen: Specimen = UNKNOWN,
    scatter: Mapping[str, float] | None = None,
    seed: int = 0,
) -> Difference:
    """A simulated motion against a recorded one.

    ``terms`` are added to the library of laws; ``specimen`` gives the anchor (coefficients are per total mass without
    one); ``scatter`` the rig's relative scatter of k, c, mu, beyond which a number differs in earnest.

    Raises RecordingError where the two are not followed in the same channel, UndertowError where either motion cannot
    be given an equation.
    """
    channels = scored_channel(simulation), scored_channel(recording)
    if channels[0] != channels[1]:
        raise RecordingError(
            f"the simulation gives {channels[0]} and the recording {channels[1]}; both need the same: say with "
            "--config which columns are what"
        )
    if recording.recording.coordinate == "rotation":  # two files without a config say it by their units alone
        specimen = replace(specimen, rotation=True)
    library = _library(terms)
    mine, theirs = _kept(simulation, library), _kept(recording, library)
    first, second = fitted(simulation, mine, specimen), fitted(recording, theirs, specimen)
    form = _form(simulation, mine, first, library)
    sides = (
        Side(simulation, mine, first, let_go(simulation, first), judged(simulation, form, "simulation", specimen)),
        Side(recording, theirs, second, let_go(recording, second), judged(recording, form, "recording", specimen)),
    )
    spread = dict(scatter or DEFAULT_SCATTER)
    run = let_go(recording, first)
    limit = _repeatability(recording, run, spread, seed)
    mismatch = locate(recording, run, sensor_floor(recording, run), limit)
    has = tuple(dict.fromkeys(sides[0].verdict.verdict))
    wanted, by_equation = needs(recording, form, second, sides[1].verdict)
    larger = () if wanted else more(recording, first, fitted(recording, form, specimen), limit)
    lacks = (*(n for n in wanted if n not in has), *larger)
    visible = _effect(sides[0].verdict) > UNEXPLAINED * allowed_error(recording, sides[1].run)
    rivals = {n for names in sides[1].verdict.alternatives for n in names}
    extra = tuple(n for n in has if visible and n not in (*wanted, *rivals, "unknown"))
    released = as_released(recording, run.theta) or run
    found = Difference(
        *sides, _rows(first, second), run, mismatch, _cycles(recording, released), sidebands(recording, run), lacks,
        extra, larger, by_equation, "", _notes(simulation, recording, [n for n in wanted if n in has]), spread,
        released,
    )  # fmt: skip
    return replace(found, sentence=sentence_of(found))


def _effect(verdict: Verdict) -> float:
    """By how much what a verdict names moves the free run (nrmse)."""
    if verdict.augmented is None:
        return 0.0
    return math.sqrt(max(verdict.baseline.nrmse**2 - verdict.augmented.nrmse**2, 0.0))


def _library(terms: Sequence[str]) -> tuple[Term, ...]:
    """The laws both equations are found from: the config's and seven more; a pendulum's sine stands for its spring."""
    laws = [registry.find(name) for name in dict.fromkeys([*terms, *registry.SEVEN_TERMS])]
    taken = {name for law in laws for name in law.instead_of}
    return tuple(law for law in laws if law.kind == "force" and not law.is_inertia and law.name not in taken)


def _form(
    simulation: Motion, kept: tuple[Term, ...], fit: GroupFit, library: tuple[Term, ...]
) -> tuple[Term, ...]:
    """The simulation's form of equation, as what is known when something is looked for beside it.

    Where no equation of the library explains the simulation, what it has beside them bends the choice of terms: then
    the restoring force and the ordinary losses stand for its form.
    """
    run = let_go(simulation, fit)
    if run.nrmse <= allowed_error(simulation, run):
        return kept
    return tuple(t for t in library if t.name in registry.ORDINARY)


def _kept(motion: Motion, library: tuple[Term, ...]) -> tuple[Term, ...]:
    """The laws that evidence keeps for one motion, its restoring force always."""
    restoring = [t for t in library if t.is_spring]
    return discover([motion], library, known=restoring).terms


def _repeatability(motion: Motion, run: FreeRun, scatter: Mapping[str, float], seed: int) -> float:
    """nrmse that the simulation's equation would have in 95 % of repetitions on this rig."""
    spread = {slot: scatter.get(symbol, 0.0) * size_in(run.theta, slot) for symbol, slot in SLOTS.items()}
    return repeatability(run, spread, sensor_floor(motion, run), scored_channel(motion), seed)


def _rows(simulation: GroupFit, recording: GroupFit) -> tuple[TermRow, ...]:
    """Both equations' numbers, name by name."""
    rows = []
    for name in dict.fromkeys([*simulation.estimates, *recording.estimates]):
        mine, theirs = simulation.estimates.get(name), recording.estimates.get(name)
        sigmas = math.nan
        if mine is not None and theirs is not None:
            error = math.hypot(*(e.total_stderr if math.isfinite(e.total_stderr) else 0.0 for e in (mine, theirs)))
            sigmas = abs(theirs.value - mine.value) / error if error > 0.0 else math.nan
        rows.append(TermRow(name, mine, theirs, sigmas))
    return tuple(rows)


def _cycles(motion: Motion, run: FreeRun) -> CycleComparison | None:
    try:
        return compare_cycles(motion, run)
    except RecordingError:  # fewer than three turns: nothing to compare cycle by cycle
        return None


def _notes(simulation: Motion, recording: Motion, both: Sequence[str]) -> tuple[str, ...]:
    """What a reader should know of the two motions; ``both`` names what is beside the equations in either."""
    notes = ["one recording: nothing is held out, so that a name is not proved on an unseen trial"]
    if both:
        names = ", ".join("something that no suspect explains" if n == "unknown" else spelled(n) for n in both)
        notes.append(f"simulation and recording both show, beside the equations above: {names}")
    ratio = simulation.amplitude / recording.amplitude
    if not 0.8 < ratio < 1.25:
        notes.append(
            f"the simulation is released from {ratio:.2g} times the recording's amplitude: what depends on amplitude "
            "is compared across that difference"
        )
    if turned := released_to_opposite_sides(simulation, recording):
        notes.append(turned)
    for word, motion in (("simulation", simulation), ("recording", recording)):
        if not motion.window.held:
            notes.append(f"the {word} shows no hold before its release: what it carries along may be in motion already")
        notes += [f"{word}: {note}" for note in (*motion.recording.notes, *motion.notes)]
    return tuple(notes)


def released_to_opposite_sides(simulation: Motion, recording: Motion) -> str:
    """That the two begin on opposite sides of their rest positions, in a sentence; empty where they do not, or where no
    displacement was recorded."""
    starts = [
        float(motion.x[0]) - motion.equilibrium.value
        for motion in (simulation, recording) if "displacement" in motion.recording.channels
    ]  # fmt: skip
    if len(starts) < 2 or starts[0] * starts[1] >= 0.0:
        return ""
    unit = recording.recording.unit("displacement")
    return (
        f"the simulation is released from {starts[0]:+.3g} {unit} and the recording from {starts[1]:+.3g} {unit}, to "
        "opposite sides: if the body was pulled one way in both, turn the sign of displacement in one file (its column "
        "times -1); what is not alike both ways, as asymmetric stiffness, is wrong until then"
    )
