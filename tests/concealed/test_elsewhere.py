"""What another water of the same rig lacks, tried on a level from the numbers that it has there."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import pytest

from tests.concealed.test_diagnosis import SHORT, member
from tests.concealed.test_small_effects import found
from undertow.campaign.run.other_waters import told_by_others
from undertow.comparison import elsewhere as module
from undertow.comparison import search
from undertow.comparison.candidate import Candidate
from undertow.comparison.elsewhere import Elsewhere, from_elsewhere, that_come_closer
from undertow.comparison.joining import log_prior
from undertow.comparison.joint import JointFit, fit_joint
from undertow.comparison.level import Addend, Level, make_level
from undertow.comparison.search import _Search, diagnose
from undertow.discrepancy.judge import Judged, lacking_as_elsewhere
from undertow.discrepancy.verdict import Verdict
from undertow.equation import registry

RESONATOR = registry.find("hidden_resonator", natural_frequency_rad_per_s=9.6, damping_ratio=0.02)
BOTH = ((RESONATOR, 150.0), (registry.find("cubic_stiffness"), 3.0e7))
NAMES = ("cubic_stiffness", "hidden_resonator")


@cache
def lacking_both() -> tuple[Level, JointFit]:
    """A level that lacks a resonator and a spring's cube, and the prescribed equation fitted to it."""
    level = make_level([member("short", SHORT, 8100, BOTH)])
    return level, fit_joint(level, (), 1.0, {}, 10.0, growing=True)


def there(*names: str, **values: float) -> Elsewhere:
    """What another water lacks: these laws, as there, with these numbers by the last part of their names."""
    level, _ = lacking_both()
    addends = tuple(Addend(n, s.additions(level.scales, s.starts(level.scales)[0])) for n in names for s in [found(n)])
    known = {f"{d.prefix}.{a.name}": values.get(a.name, a.start) for d in addends for a in d.additions}
    return Elsewhere(addends, tuple((n if "cubic" not in n else f"{n}@other", v) for n, v in known.items()))


NEAR = {"natural_frequency_rad_per_s": 10.2, "mass_kg": 110.0, "damping_ratio": 0.04, "N_per_m3": 2.0e7}


def test_a_fit_begins_at_the_numbers_of_the_other_water():
    level, null = lacking_both()
    plain = Candidate((), null, 0.0)
    candidate = from_elsewhere(level, plain, [found(n) for n in NAMES], there(*NAMES, **NEAR), 1e12)
    assert candidate is not None
    assert candidate.names == NAMES
    assert candidate.out == ""
    assert candidate.fit.value("hidden_resonator.natural_frequency_rad_per_s") == pytest.approx(9.6, rel=0.01)
    assert candidate.fit.misfit < 1.3
    begins = there(*NAMES, **NEAR).beginning()
    assert [a.start for a in begins[1].additions] == [110.0, 10.2, 0.04]
    assert begins[0].additions[0].start == 2.0e7  # another spring's, where this one has none


def test_it_is_fitted_in_one_window_and_in_growing_ones_for_either_can_end_beside_the_answer(monkeypatch):
    level, null = lacking_both()
    tried, plain = [], fit_joint
    monkeypatch.setattr(module, "fit_joint", lambda at, addends, memory, known, misfit, growing, quick=False: (
        tried.append((growing, quick)), plain(at, addends, memory, known, misfit, growing, quick))[1])
    from_elsewhere(level, Candidate((), null, 0.0), [found(n) for n in NAMES], there(*NAMES, **NEAR), 1e12)
    assert tried == [(False, True), (True, True), (False, False)]


def test_nothing_is_tried_of_a_law_that_is_no_suspect_here_or_beyond_the_budget():
    level, null = lacking_both()
    plain = Candidate((), null, 0.0)
    assert from_elsewhere(level, plain, [found("hidden_resonator")], there(*NAMES, **NEAR), 1e12) is None
    assert from_elsewhere(level, plain, [found(n) for n in NAMES], there(*NAMES, **NEAR), 1.0) is None


def test_a_fit_that_is_not_followed_to_its_end_is_none(monkeypatch):
    level, null = lacking_both()
    plain = fit_joint

    def only_quick(*given: object, quick: bool = False, **more: object) -> JointFit:
        if not quick:
            raise module.IdentificationError("no motion")
        return plain(*given, quick=True, **more)

    monkeypatch.setattr(module, "fit_joint", only_quick)
    suspects = [found(n) for n in NAMES]
    assert from_elsewhere(level, Candidate((), null, 0.0), suspects, there(*NAMES, **NEAR), 1e12) is None


def test_what_one_law_alone_hid_is_an_answer_where_another_water_tells_both(monkeypatch):
    """With no pair looked for, the level alone ends with one law; told by another water it has both."""
    level, _ = lacking_both()
    suspects = [found(n) for n in NAMES]
    monkeypatch.setattr(_Search, "_beside", lambda *_: [])
    monkeypatch.setattr(_Search, "_two_that_leave_noise", lambda _: None)
    plain = _Search._as_far_as_possible
    monkeypatch.setattr(_Search, "_as_far_as_possible", lambda self, depth: [] if depth else plain(self, depth))
    alone = diagnose(level, suspects)
    assert len(alone.best.names) < 2
    told = diagnose(level, suspects, elsewhere=[there(*NAMES, **NEAR)])
    assert set(told.best.names) == set(NAMES)
    (both,) = (c for c in told.candidates if set(c.names) == set(NAMES))
    assert both.log_prior == pytest.approx(log_prior(both.suspects, len(suspects), clean_when_dry=False))
    with monkeypatch.context() as patch:
        patch.setattr(search, "from_elsewhere", lambda *_: replace(both, out="its numbers mean nothing"))
        assert diagnose(level, suspects, elsewhere=[there(*NAMES, **NEAR)]).best.names == alone.best.names
    believed = _Search._prior
    monkeypatch.setattr(_Search, "_prior", lambda self, many: believed(self, many) - 1e6 * (len(many) > 1))
    assert diagnose(level, suspects, elsewhere=[there(*NAMES, **NEAR)]).best.names == alone.best.names


def test_a_wider_form_of_a_law_is_the_suspect_that_has_it():
    level, _ = lacking_both()
    plain, wider = found("hidden_resonator"), found("hidden_resonator", "amplitude-dependent")
    more = Addend("hidden_resonator#2", wider.additions(level.scales, wider.starts(level.scales)[0]))
    assert module._like(more, [plain, wider], level) is wider
    assert module._like(more, [plain], level) is plain
    assert module._like(more, [found("cubic_stiffness")], level) is None


def test_what_is_not_there_is_no_answer_though_another_water_lacks_it():
    level = make_level([member("short", SHORT, 8200)])
    told = diagnose(level, [found(n) for n in NAMES], elsewhere=[there(*NAMES, **NEAR)])
    assert told.best.names == ()
    assert any(set(c.names) == set(NAMES) for c in told.candidates)  # it was tried, and counts among all that was


def test_another_search_is_worth_it_where_what_others_lack_comes_closer_than_what_was_found():
    level, null = lacking_both()
    suspects, both = [found(n) for n in NAMES], there(*NAMES, **NEAR)
    assert that_come_closer(level, suspects, [both], null.misfit) == (both,)
    assert that_come_closer(level, suspects, [both], 0.9) == ()
    assert that_come_closer(level, suspects, [both], float("nan")) == ()
    without = make_level([member("short", SHORT, 8200)])
    assert that_come_closer(without, suspects, [both], 100.0) == ()  # its numbers mean nothing there
    assert that_come_closer(level, suspects[:1], [both], null.misfit) == ()  # it is no suspect here
    assert that_come_closer(level, suspects, [both], null.misfit, budget=1e-9) == ()
    case = SimpleNamespace(member=level.members[0])
    alone = Judged((), ("short",), misfit=null.misfit)
    assert lacking_as_elsewhere([case], suspects, (), [both], alone) == (both,)
    assert lacking_as_elsewhere([case], suspects, (), [both], replace(alone, misfit=0.9)) == ()


def judged(status: str, *names: str, addends: tuple[Addend, ...] = (), prefix: str = "") -> Judged:
    """One water's verdict, and what was added to its equation."""
    verdict = Verdict({}, (), status=status, verdict=names)
    values = {f"{prefix or d.prefix}.{a.name}": (2.0, 0.1) for d in addends for a in d.additions}
    return Judged((verdict,), ("short",), addends, {**values, "external_forcing.cosine_N[r1]": (3.0, 0.1)})


def addend(name: str) -> Addend:
    """A suspect as it is added."""
    level, _ = lacking_both()
    suspect = found(name)
    return Addend(name, suspect.additions(level.scales, suspect.starts(level.scales)[0]), suspect.frees)


@pytest.mark.parametrize(
    ("status", "names", "asked"),
    [
        ("unknown", ("unknown",), True),
        ("unknown", ("cubic_stiffness", "unknown"), True),
        ("explained", ("cubic_stiffness",), True),
        ("explained", ("hidden_resonator", "cubic_stiffness"), False),
        ("explained", ("quadratic_drag",), False),
        ("nothing_missing", (), False),
        ("cannot_tell", (), False),
    ],
)
def test_a_water_is_told_what_another_lacks_where_nobody_knows_or_it_is_part_of_that(status, names, asked):
    sure = judged("explained", *NAMES, addends=(addend("cubic_stiffness"), addend("hidden_resonator")))
    told = told_by_others(0, [judged(status, *names), sure])
    assert bool(told.elsewhere) == asked == bool(told)
    if asked:
        (one,) = told.elsewhere
        assert one.names == NAMES
        assert not any("[" in name for name, _ in one.values)
        assert dict(one.values)["hidden_resonator.mass_kg"] == 2.0


def test_no_water_tells_what_it_is_not_sure_of_what_the_dry_trials_lack_or_a_sensor_or_release_had():
    lost = judged("unknown", "unknown")
    unsure = judged("not_identifiable", "cubic_stiffness", addends=(addend("cubic_stiffness"),))
    assert not told_by_others(0, [lost, unsure])
    dry = judged("explained", "cubic_stiffness", addends=(addend("cubic_stiffness"),))
    assert told_by_others(0, [lost, dry]).elsewhere
    assert not told_by_others(0, [lost, dry], standing=["cubic_stiffness"])
    known = judged("explained", "cubic_stiffness")  # which the dry trials need: it is no part of what others lack
    sure = judged("explained", "hidden_resonator", addends=(addend("hidden_resonator"),))
    assert not told_by_others(0, [known, sure], standing=["cubic_stiffness"])
    part = judged("explained", "cubic_stiffness", "hidden_resonator")  # the first of which the dry trials need
    more = judged("explained", "x", addends=(addend("hidden_resonator"), addend("relaxation")))
    assert told_by_others(0, [part, more], standing=["cubic_stiffness"]).elsewhere
    assert not told_by_others(0, [part, more])
    assert not told_by_others(0, [lost, judged("explained", "gain_error", addends=(addend("gain_error"),))])
    late = replace(addend("hidden_resonator"), late=1.0)
    assert not told_by_others(0, [lost, judged("explained", "imperfect_release", addends=(late,))])
    same = [judged("explained", "hidden_resonator", addends=(addend("hidden_resonator"),)) for _ in range(3)]
    assert len(told_by_others(0, [lost, *same]).elsewhere) == 1
