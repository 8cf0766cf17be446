"""How many cases of which kind: the table of a challenge, and the plan of every case before anything is drawn."""

from dataclasses import dataclass, replace

import numpy as np

from experiments.blind_challenge.rigs import Needs

CALIBRATION_SEED = 2_100_001  # may be looked at
TEST_SEED = 2_100_002  # run once a frozen revision
FULL = 1300
SHARES = {"nothing": 700, "one": 200, "two": 150, "outside": 150, "cannot": 100}  # of FULL
DRY_SHARES = {"few": 1.0 / 3.0, "none": 1.0 / 5.0, "many": 7.0 / 15.0}
STRENGTHS = (1.0 / 3.0, 10.0)  # what can be seen is 1
SMALL_SHARES = {"nothing": 2, "one": 1, "two": 1, "outside": 1, "cannot": 1}
LOST = 0.08  # of the cases with nothing missing have lost samples

ONE = (
    "hidden_resonator", "hidden_resonator_nonlinear", "relaxation", "linear_damping", "cubic_damping", "drag_exponent",
    "cubic_stiffness", "quintic_stiffness", "asymmetric_stiffness", "sine_restoring", "stribeck_friction",
    "variable_normal_force", "presliding", "hysteresis", "coulomb_friction", "added_mass", "quadratic_drag",
    "external_tone", "external_narrow_band", "external_close", "delayed_echo", "imperfect_release", "mass_change",
    "support_compliance", "time_shift", "gain_error", "sensor_drift", "clipping",
)  # fmt: skip
PAIRED = (
    "hidden_resonator", "relaxation", "cubic_damping", "cubic_stiffness", "asymmetric_stiffness", "stribeck_friction",
    "hysteresis", "external_tone", "external_narrow_band", "delayed_echo", "sensor_drift", "imperfect_release",
    "hidden_resonator_nonlinear", "linear_damping", "drag_exponent",
)  # fmt: skip
OUTSIDE = {
    "deck": 2, "wake": 2, "rattle": 2, "bending_rail": 2, "keulegan_drag": 2, "stop": 2, "magnet": 2, "leak": 2,
    "uneven_rail": 2, "warming": 2, "dispersive_reflections": 2, "seiche_with_velocity": 2, "closed_cells": 2,
    "open_section": 2, "radiation": 2, "pitch": 1, "left_over_sloshing": 1, "iwan": 1, "bouc_wen_pinching": 1,
    "lugre": 1, "rate_state": 1,
}  # fmt: skip
CANNOT = (
    "one trial", "no dry trials and no repeats", "added mass or a resonator far above", "narrow amplitudes",
    "an effect below the noise", "over-damped resonator or relaxation", "late load cells or damping", "wrong unit",
    "swapped channels", "wrong sign", "friction that only moves the rest position",
)  # fmt: skip


@dataclass(frozen=True)
class Plan:
    """What a case will be: its kind, its effects, which dry trials, and the reason where the data cannot tell."""

    kind: str
    effects: tuple[str, ...] = ()
    dry: str | None = None
    reason: str = ""
    lost: bool = False
    small: bool = False  # a few short trials, for continuous integration


def counts(total: int, shares: dict[str, float]) -> dict[str, int]:
    """`total` divided by shares, whole numbers that add up (largest remainders)."""
    whole = sum(shares.values())
    exact = {name: total * share / whole for name, share in shares.items()}
    out = {name: int(value) for name, value in exact.items()}
    for name in sorted(exact, key=lambda n: out[n] - exact[n])[: total - sum(out.values())]:
        out[name] += 1
    return out


def _cycle(rng: np.random.Generator, items: list[str], n: int) -> list[str]:
    """`n` items, each as often as the others up to one, in random order."""
    out: list[str] = []
    while len(out) < n:
        out += [items[i] for i in rng.permutation(len(items))]
    return out[:n]


def plans(seed: int, total: int, shares: dict[str, float] | None = None, small: bool = False) -> list[Plan]:
    """The plans of a challenge in random order; the same seed, number and shares give the same plans."""
    if total < 1:
        raise ValueError(f"cases: {total} were asked for; ask for 1 or more")
    rng = np.random.default_rng([seed, total])
    n = dict.fromkeys(SHARES, 0) | counts(total, dict(shares or SHARES))
    out = []
    for dry, count in counts(n["nothing"], DRY_SHARES).items():
        lost = set(rng.choice(count, size=round(LOST * count), replace=False).tolist()) if count else set()
        out += [Plan("nothing", (), dry, lost=i in lost) for i in range(count)]
    out += [Plan("one", (key,)) for key in _cycle(rng, list(ONE), n["one"])]
    for _ in range(n["two"]):
        first, second = rng.choice(len(PAIRED), size=2, replace=False)
        pair = (PAIRED[first], PAIRED[second])
        same = {"hidden_resonator", "hidden_resonator_nonlinear"}
        clash = set(pair) == same or {"cubic_damping", "drag_exponent"} == set(pair)
        out.append(Plan("two", ("hidden_resonator", "cubic_stiffness") if clash else pair))
    weighted = [key for key, weight in OUTSIDE.items() for _ in range(weight)]
    out += [Plan("outside", (key,)) for key in _cycle(rng, weighted, n["outside"])]
    out += [_cannot(rng, reason) for reason in _cycle(rng, list(CANNOT), n["cannot"])]
    return [replace(out[i], small=small) for i in rng.permutation(len(out))]


def _cannot(rng: np.random.Generator, reason: str) -> Plan:
    """A case that the data cannot decide, by its reason."""
    vague = ("linear_damping", "cubic_damping", "drag_exponent", "relaxation")
    maybe = () if rng.random() < 0.5 else (str(rng.choice(vague)),)
    if reason in ("one trial", "no dry trials and no repeats"):
        return Plan("cannot", maybe, "none", reason)
    effects = {
        "added mass or a resonator far above": ("added_mass", "resonator_far_above"),
        "narrow amplitudes": ("quadratic_drag", "coulomb_friction"),
        "an effect below the noise": (
            "hidden_resonator",
            "cubic_stiffness",
            "relaxation",
            "hysteresis",
            "external_tone",
        ),
        "over-damped resonator or relaxation": ("overdamped_resonator", "relaxation"),
        "late load cells or damping": ("late_cell",),
        "friction that only moves the rest position": ("asymmetric_friction",),
    }.get(reason)
    if effects is None:
        return Plan("cannot", (), None, reason)
    return Plan("cannot", (str(rng.choice(effects)),), "none" if reason == "narrow amplitudes" else None, reason)


def needs_of(plan: Plan, kinds: list[Needs]) -> Needs:
    """What the laboratory must have for all effects and for the reason, the strictest of each."""
    out = Needs()
    values = vars(out).copy()
    for need in kinds:
        for name, value in vars(need).items():
            if value != getattr(Needs(), name):
                values[name] = value
    special: dict[str, dict[str, object]] = {
        "one trial": {"trials": (1, 1), "springs": (1,), "levels": (1,), "knows_mass": False},
        "no dry trials and no repeats": {"trials": (1, 1), "levels": (2, 3), "springs": (1, 2)},
        "narrow amplitudes": {"trials": (2, 6), "springs": (1,), "levels": (1,), "spread": (0.97, 0.99)},
        "wrong unit": {"channels": ("acceleration",), "coordinate": "translation"},
        "swapped channels": {"channels": ("acceleration", "spring_force"), "coordinate": "translation"},
        "wrong sign": {"channels": ("acceleration",), "coordinate": "translation"},
    }
    short = {"trials": (1, 4), "springs": (1,), "levels": (1,)} if plan.small else {}
    return Needs(**{**values, **short, **special.get(plan.reason, {})})  # type: ignore[arg-type]
