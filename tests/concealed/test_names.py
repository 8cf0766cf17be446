"""Campaigns with one known thing missing: their motion is right, their sizes are as stated, their verdicts count."""

from __future__ import annotations

import math
import re
from dataclasses import replace

import matplotlib
import numpy as np
import pytest

from experiments.eq15_campaign.motion import Body, simulate
from experiments.names import counts, rows
from experiments.names.__main__ import RESULTS, main
from experiments.names.effects import EFFECTS, acts_on, find
from experiments.names.folder import View, write
from experiments.names.motion import release
from experiments.names.page import _picture, page_text
from experiments.names.recordings import record
from experiments.names.rigs import FLUME, Plan
from experiments.names.scenes import Campaign
from experiments.names.seen import SLOTS, size_of
from experiments.names.strength import size_for
from experiments.names.studies import STUDIES, plan_of
from experiments.names.verdicts import judge, outcome
from undertow.campaign.config import load
from undertow.campaign.run import read_and_condition
from undertow.discrepancy.verdict import Verdict
from undertow.equation import registry
from undertow.equation.equation import Equation
from undertow.equation.simulate import simulate as undertow_simulate

BODY = {"M": 3200.0, "c": 820.0, "k": 403000.0, "fc": 150.0, "q": 2000.0}
EQ15 = ("viscous_damping", "stiffness", "coulomb_friction", "quadratic_drag")
SMALL = Plan(11, springs=("short",), wet_trials=3, dry_trials=3, rate_hz=100.0, seconds=8.0)
TIMES = np.arange(0.0, 8.0, 0.01)


def test_motion_is_that_of_the_default_campaigns_integrator():
    exact = simulate(Body(3200.0, 820.0, 403000.0, 150.0, 2000.0), 0.03, TIMES)
    path = release(BODY, 0.03, 8.1)
    x, a, spring = path.at(TIMES)
    assert np.max(np.abs(x - exact.x)) < 1e-10  # 1e-9 of the release; both integrate to 1e-12
    assert np.max(np.abs(a - exact.a)) < 1e-3  # straight between steps of 0.25 ms: w^2 a h^2 / 8
    assert spring == pytest.approx(403000.0 * x)
    assert path.stopped_s == pytest.approx(exact.stopped_s, abs=5e-4)  # two steps


@pytest.mark.parametrize(
    ("term", "numbers", "slots"),
    [
        (registry.find("cubic_damping"), 900.0, {"c3": 900.0}),
        (registry.find("asymmetric_damping"), 400.0, {"ca": 400.0}),
        (registry.find("asymmetric_drag"), -1500.0, {"qa": -1500.0}),
        (registry.find("cubic_stiffness"), 2e7, {"k3": 2e7}),
        (registry.find("quintic_stiffness"), 2e10, {"k5": 2e10}),
        (registry.find("asymmetric_stiffness"), 5e5, {"k2": 5e5}),
        (registry.find("variable_normal_force"), 3000.0, {"n": 3000.0}),
        (registry.find("asymmetric_friction"), 60.0, {"fa": 60.0}),
        (registry.find("stribeck_friction", velocity_m_per_s=0.02), 80.0, {"fs": 80.0, "vs": 0.02}),
        (registry.find("relaxation", time_s=0.2), 2e4, {"rk": 2e4, "rt": 0.2}),
        (registry.find("delayed_echo", delay_s=2.0), 200.0, {"ge": 200.0, "te": 2.0}),
        (
            registry.find("hidden_resonator", natural_frequency_rad_per_s=9.5, damping_ratio=0.03),
            150.0, {"hm": 150.0, "hw": 9.5, "hz": 0.03},
        ),
    ],
    ids=lambda value: getattr(value, "name", ""),
)  # fmt: skip
def test_a_hidden_law_is_the_registered_law(term, numbers, slots):
    terms = (*(registry.find(n) for n in EQ15), term)
    equation = Equation(terms, (820.0, 403000.0, 150.0, 2000.0, numbers), mass_kg=3200.0)
    theirs = undertow_simulate(equation, 0.03, TIMES + 1e-9)
    ours = release(BODY | slots, 0.03, 8.1).at(TIMES)[0]
    assert np.max(np.abs(ours - theirs.x)) < 3e-6  # a ten thousandth of the release


def test_a_body_on_bristles_alone_never_sticks():
    path = release(BODY | {"xb": 5e-4}, 0.03, 8.0)
    assert path.stopped_s > 7.9


def test_a_slow_release_starts_from_rest_and_lags():
    fast, slow = release(BODY, 0.03, 1.0), release(BODY | {"ramp": 0.1}, 0.03, 1.0)
    assert abs(slow.v[1]) < 0.1 * abs(fast.v[1])
    assert slow.x[400] > fast.x[400]


def test_a_support_gives_way_before_the_release():
    path = release(BODY | {"my": 260.0, "ky": 4e6, "cy": 1000.0}, 0.03, 1.0)
    assert path.spring[0] == pytest.approx(0.03 / (1 / 403000.0 + 1 / 4e6))


def test_a_number_that_the_equation_does_not_have_is_refused():
    with pytest.raises(KeyError, match=r"no number 'gremlin'; it has M, c, k"):
        release({"gremlin": 1.0}, 0.03, 1.0)


def test_an_effect_that_does_not_exist_is_refused():
    with pytest.raises(KeyError, match=r"no effect 'gremlin'; there are linear_damping"):
        find("gremlin")


def test_water_is_in_wet_trials_alone_and_structure_in_all():
    dry = next(t for t in SMALL.trials() if not t.wet)
    assert not acts_on(find("relaxation"), dry)
    assert acts_on(find("cubic_stiffness"), dry)
    assert not acts_on(find("external_forcing"), dry)


@pytest.mark.parametrize("name", ["hidden_resonator", "cubic_stiffness", "added_mass", "mass_change"])
def test_a_size_has_the_strength_it_was_made_for(name):
    size, reached = size_for(SMALL, name, 1.5)
    assert 0.0 < size < find(name).most
    assert reached == pytest.approx(1.5, rel=0.05)


def test_what_no_size_can_make_strong_says_how_strong_it_is():
    size, reached = size_for(SMALL, "drag_exponent", 50.0)
    assert size == find("drag_exponent").most
    assert reached < 50.0


@pytest.mark.parametrize("effect", [e for e in EFFECTS if e.rig is FLUME], ids=lambda e: e.name)
def test_every_effect_changes_a_recording(effect):
    size = effect.most if effect.change is not None else effect.unit_size * 4.0
    wet = [t for t in SMALL.trials() if t.wet][:2]  # of two wet trials at least one has what comes between trials
    largest = FLUME.springs["short"].releases[1]
    apart = 0.0
    for trial in wet:
        plain, hidden = record(Campaign(SMALL), trial), record(Campaign(SMALL, {effect.name: size}), trial)
        apart = max(apart, *(np.max(np.abs(plain[c] - hidden[c])) for c in ("disp_m", "accel_mps2")))
    assert apart > 1e-3 * largest


def test_a_view_changes_how_a_campaign_is_written_and_not_its_motion(tmp_path):
    campaign = Campaign(replace(SMALL, wet_trials=1, dry_trials=1))
    views = {"plain": View(), "other": View(millimetres=True, mirrored=True, shuffled=True, level_m=0.01)}
    motions = {}
    for name, view in views.items():
        read = read_and_condition(load(write(campaign, tmp_path / name, view)))
        assert not read.failed
        motions[name] = {m.name: m for m in read.motions}
    for trial, motion in motions["plain"].items():
        assert motions["other"][trial].amplitude == pytest.approx(motion.amplitude, rel=1e-3)
        assert np.max(np.abs(motions["other"][trial].v + motion.v)) < 2e-3 * np.max(np.abs(motion.v))


def test_windows_end_where_they_are_told_to(tmp_path):
    campaign = Campaign(replace(SMALL, wet_trials=1, dry_trials=1))
    ends = {t.file: 5.0 + t.order for t in campaign.plan.trials()}
    read = read_and_condition(load(write(campaign, tmp_path, View(), ends)))
    assert {m.name + ".csv": m.window.end_s for m in read.motions} == ends


def test_a_run_that_was_cut_goes_on_where_it_stopped(tmp_path, monkeypatch):
    from experiments.names import __main__ as command

    monkeypatch.setattr(command, "judge", lambda campaign, view: {"wet": "", "dry": "", "rivals": "", "failed": ""})
    for seeds in ("2", "3"):
        assert main(["--study", "nulls", "--seeds", seeds, "--out", str(tmp_path)]) == 0
    written = (tmp_path / "nulls.csv").read_text().splitlines()
    assert len(written) == 1 + 3
    assert [r["seed"] for r in rows.read(tmp_path / "nulls.csv")] == ["0", "1", "2"]


def test_outcomes_are_told_apart():
    said = {"failed": "", "hidden": "relaxation", "wet": "relaxation", "rivals": "", "dry": ""}
    assert outcome(said) == "right"
    assert outcome(said | {"wet": "cubic_damping", "rivals": "relaxation"}) == "rival"
    assert outcome(said | {"wet": "relaxation+unknown"}) == "right"
    assert outcome(said | {"wet": "relaxation+cubic_damping"}) == "more"
    assert outcome(said | {"wet": "unknown"}) == "unknown"
    assert outcome(said | {"hidden": "relaxation+time_shift"}) == "part"
    assert outcome(said | {"wet": ""}) == "nothing"
    assert outcome(said | {"wet": "", "dry": "relaxation"}) == "dry"
    assert outcome(said | {"wet": "hysteresis"}) == "wrong"
    assert outcome(said | {"hidden": "", "wet": ""}) == "right"
    assert outcome(said | {"hidden": "", "wet": "unknown"}) == "unknown"
    assert outcome(said | {"failed": "no trial"}) == "failed"


def test_every_study_draws_campaigns_from_seeds_alone():
    for name in ("nulls", "inseparable"):
        first, second = (next(iter(STUDIES[name](range(3, 4)))) for _ in range(2))
        assert first.label == second.label
        assert first.campaign == second.campaign
    assert plan_of(4).rate_hz in (100.0, 250.0, 1000.0)
    assert 3 <= plan_of(4).wet_trials <= 6


def test_a_null_campaign_gives_no_name_and_linear_damping_of_linear_damping():
    null = judge(Campaign(SMALL))
    assert null["wet"] == null["dry"] == ""
    assert math.isfinite(float(null["nrmse"]))
    size, _ = size_for(SMALL, "linear_damping", 4.0)
    damped = judge(Campaign(SMALL, {"linear_damping": size}))
    assert damped["dry"] == ""
    assert "linear_damping" in str(damped["wet"]) + str(damped["rivals"])


def test_p_values_of_nulls_are_held_against_the_uniform_law():
    grid = [
        {"wet": "", "dry": "", "seed": str(i), "status": "nothing_missing", "dry_status": "nothing_missing",
         "scatter": "report", "springs": "long", "p_value": f"{(i + 0.5) / 40:g}"} for i in range(40)
    ]  # fmt: skip
    found = counts.nulls(grid)
    assert (found["green"], found["false_positives"]) == (40, 0)
    assert found["uniform"]["all"]["ks_p"] > 0.99
    assert found["uniform"]["all"]["below .1"] == 4
    assert found["uniform"]["scatter stated"]["campaigns"] == 20
    high = [row | {"p_value": f"{float(row['p_value']) ** 0.25:g}"} for row in grid]
    assert counts.nulls(high)["uniform"]["all"]["ks_p"] < 0.01


def test_a_force_near_the_bodys_rate_that_is_called_a_resonator_is_counted():
    row = {"hidden": "external_forcing", "dry": "", "rivals": "", "failed": ""}
    found = counts.near([row | {"wet": w} for w in ("external_forcing", "hidden_resonator+unknown", "unknown")])
    assert (found["campaigns"], found["called_a_resonator"], found["right"]) == (3, 1, 1)


def test_a_row_fits_a_file_that_has_fewer_columns(tmp_path):
    path = tmp_path / "nulls.csv"
    path.write_text("study,hidden,strength,seed,view,wet\nnulls,,0.0,1,,\n")
    rows.append(path, {"study": "nulls", "hidden": "", "strength": 0.0, "seed": 2, "wet": "unknown", "p_value": "0.5"})
    assert [row["wet"] for row in rows.read(path)] == ["", "unknown"]


@pytest.mark.parametrize("name", sorted(SLOTS))
def test_a_planted_effect_has_the_size_that_a_null_says_it_would_see(name):
    campaign = Campaign(SMALL)
    wet = [t for t in SMALL.trials() if t.wet]
    planted = replace(campaign, sizes={name: size_of(campaign, Verdict({}, (wet[0].file,)), name, 12.5)})
    before, after = (
        [one.numbers(trial, scattered=False).get(SLOTS[name], 0.0) for trial in wet] for one in (campaign, planted)
    )
    assert max(abs(a - b) for a, b in zip(after, before, strict=True)) == pytest.approx(12.5)


def test_a_size_said_of_dry_trials_is_that_on_their_own_spring():
    campaign = Campaign(replace(SMALL, springs=("short", "long")))
    dry = {t.spring: t for t in campaign.plan.trials() if not t.wet}
    sizes = {s: size_of(campaign, Verdict({}, (t.file,)), "cubic_stiffness", 1e3) for s, t in dry.items()}
    for spring, trial in dry.items():
        planted = replace(campaign, sizes={"cubic_stiffness": sizes[spring]})
        assert abs(planted.numbers(trial, scattered=False)["k3"]) == pytest.approx(1e3)
    assert sizes["long"] > 5.0 * sizes["short"]  # 38 times: k over the square of the largest release


def test_the_picture_counts_every_campaign_in_letters_that_can_be_read(tmp_path, monkeypatch):
    monkeypatch.setitem(matplotlib.rcParams, "svg.fonttype", "none")
    many = rows.read(RESULTS / "confusion.csv")
    _picture(many, tmp_path / "p.svg")
    svg = (tmp_path / "p.svg").read_text(encoding="utf-8")
    sizes = {float(size) for size in re.findall(r"font(?:-size)?:[^;\"']*?([\d.]+)px", svg)}
    assert min(sizes) >= 9.0
    said = re.findall(r">([^<>]+)</text>", svg)
    found = counts.against(many)
    assert len(many) == sum(one.total() for _, counted in found for one in counted.values())
    assert {name.replace("_", " ") for name, _ in found} <= {text.strip() for text in said}
    assert sum(int(text.partition(":")[0]) for text in said if re.match(r"\d+(:|$)", text)) == len(many)
    order = [counted.keys() for _, counted in found]
    assert "right" in order[0]
    assert not {"right", "beside"} & order[-1]  # names that are found stand above those that are not


def test_the_page_is_made_from_the_rows_that_are_committed():
    found = {
        "revisions": [],
        "nulls": counts.nulls(rows.read(RESULTS / "nulls.csv")),
        "confusion": counts.by_name(rows.read(RESULTS / "confusion.csv")),
        "pairs": counts.by_name(rows.read(RESULTS / "pairs.csv")),
        "inseparable": counts.inseparable(rows.read(RESULTS / "inseparable.csv")),
        "seiche": counts.seiche(rows.read(RESULTS / "seiche.csv")),
        "near_seiche": counts.near(rows.read(RESULTS / "near_seiche.csv")),
        "invariance": counts.invariance(rows.read(RESULTS / "invariance.csv")),
    }
    page = (RESULTS.parents[2] / "docs" / "confusion.md").read_text(encoding="utf-8")
    body = page_text(found).rsplit("Judged at", 1)[0]
    assert page.startswith(body)
