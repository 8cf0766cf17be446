"""What a laboratory hands over: recordings, an index and a config, each as text; and the truth for the sealed folder.

The folder of a case holds nothing but what a laboratory would write. Names of files and channels say nothing.
"""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from experiments.blind_challenge.cases import Case
from experiments.blind_challenge.rigs import WATER, Rig, Sensor, Trial
from experiments.blind_challenge.scene import alive, mean_scene, move, read, sample_count, with_own_factors

SPRINGS = ("soft", "stiff")
RUNAWAY = 5.0  # times the release: no record of an experiment


class UnstableTruth(ValueError):
    """The drawn truth grows without limit or is no number; it must be drawn weaker."""


def noisy(rng: np.random.Generator, sensor: Sensor, values: np.ndarray) -> np.ndarray:
    """The sensor's zero and its noise on top of a perfect reading, SI."""
    white = rng.normal(size=values.size)
    noise = white.copy()
    r = sensor.correlation
    if r:
        for i in range(1, noise.size):
            noise[i] = r * noise[i - 1] + math.sqrt(1.0 - r * r) * white[i]
    return values + sensor.offset + sensor.noise * noise


def _decimals(sensor: Sensor) -> int:
    """Decimals with which a reading is written: a fifth of the noise or finer."""
    return max(0, math.ceil(-math.log10(sensor.noise / sensor.unit_size / 5.0)))


def recording(case: Case, trial: Trial) -> str:
    """A trial as CSV: time and channels, hold first."""
    rig = case.rig
    index = rig.trials.index(trial)
    rng = np.random.default_rng([*case.seed, 77, index])
    scene = with_own_factors(mean_scene(rig, trial))
    change = case.change(scene)
    motion = move(scene, change, sample_count(rig, trial))
    if not np.all(np.isfinite(motion.x)) or np.max(np.abs(motion.x)) > RUNAWAY * rig.largest:
        raise UnstableTruth(
            f"case {case.name}, trial {trial.file}: the motion leaves {RUNAWAY} releases; draw it weaker"
        )
    keep = alive(motion, trial.release, scene.body.frequency)
    held = round(trial.hold / rig.step)
    readings = read(scene, change, motion, held)
    lines = [(_noisy_column(rng, sensor, readings[sensor.channel][: held + keep - 1])) for sensor in rig.sensors]
    time = rig.step * np.arange(lines[0].size)
    rows = np.ones(time.size, dtype=bool)
    if case.plan.lost:
        rows = _kept(rng, time.size)
    decimals = max(0, -math.floor(math.log10(rig.step)) + 3)
    header = ",".join(["t", *(sensor.column for sensor in rig.sensors)])
    columns = [np.char.mod(f"%.{decimals}f", time[rows])]
    for sensor, line in zip(rig.sensors, lines, strict=True):
        columns.append(np.char.mod(f"%.{_decimals(sensor)}f", line[rows]))
    return "\n".join([header, *map(",".join, zip(*columns, strict=True))]) + "\n"


def _noisy_column(rng: np.random.Generator, sensor: Sensor, values: np.ndarray) -> np.ndarray:
    return noisy(rng, sensor, values) / sensor.unit_size


def _kept(rng: np.random.Generator, n: int) -> np.ndarray:
    """Rows that were written: single ones are lost, and sometimes a few in a row; never the first or the last."""
    keep = rng.random(n) >= rng.uniform(0.001, 0.01)
    if rng.random() < 0.5:
        start = int(rng.integers(n // 4, n - 12))
        keep[start : start + int(rng.integers(2, 8))] = False
    keep[[0, -1]] = True
    return keep


def index_table(rig: Rig) -> str:
    """The campaign's index."""
    head = ["file", *(["spring"] if len(rig.springs) > 1 else []), "water_depth_m"]
    rows = [",".join(head)]
    for trial in rig.trials:
        row = [f"recordings/{trial.file}", *([SPRINGS[trial.spring]] if len(rig.springs) > 1 else [])]
        rows.append(",".join([*row, _number(rig.levels[trial.level].depth)]))
    return "\n".join(rows) + "\n"


def _number(value: float) -> str:
    """A number that YAML 1.2 reads as a number."""
    text = f"{value:.6g}"
    return text.replace("e", ".0e") if "e" in text and "." not in text else text


def _flow(table: dict[str, object]) -> str:
    """A mapping on one line."""
    parts = []
    for key, value in table.items():
        if isinstance(value, dict):
            parts.append(f"{key}: {_flow(value)}")
        elif isinstance(value, (list, tuple)):
            parts.append(f"{key}: [{', '.join(map(str, value))}]")
        else:
            parts.append(f"{key}: {_number(value) if isinstance(value, float) else value}")
    return "{" + ", ".join(parts) + "}"


def _channels(case: Case) -> list[str]:
    """Lines of the channels, with the mistake of the case where its reason is one."""
    sensors = list(case.rig.sensors)
    by = {sensor.channel: i for i, sensor in enumerate(sensors)}
    signs = dict.fromkeys(by, 1)
    if case.plan.reason == "wrong unit":
        i = by["acceleration"]
        sensors[i] = replace(sensors[i], unit="g" if sensors[i].unit != "g" else "m/s^2")
    elif case.plan.reason == "wrong sign":
        signs["acceleration"] = -1
    elif case.plan.reason == "swapped channels":
        i, j = by["acceleration"], by["spring_force"]
        sensors[i], sensors[j] = (
            replace(sensors[i], column=sensors[j].column),
            replace(sensors[j], column=sensors[i].column),
        )
    lines = ["    time: {column: t, unit: s}"]
    for sensor in sensors:
        sign = ", sign: -1" if signs[sensor.channel] < 0 else ""
        lines.append(f"    {sensor.channel}: {{column: {sensor.column}, unit: {sensor.unit}{sign}}}")
    return lines


def config(case: Case) -> str:
    """The config: what a laboratory knows of its rig, and no more."""
    rig = case.rig
    two, dry = len(rig.springs) > 1, [level for level in rig.levels if not level.wet]
    group = [*(["spring"] if two else []), *(["water_depth_m"] if len(rig.levels) > 1 else [])]
    lines = [f"name: {case.name}", "recordings:", "  index: campaign.csv", "  channels:", *_channels(case), "trials:"]
    lines.append(f"  group_by: [{', '.join(group)}]")
    if dry:
        lines.append(f"  dry: {{water_depth_m: {_number(dry[0].depth)}}}")
    facts: dict[str, object] = {}
    if "mass" in rig.knows:
        facts["mass_kg"] = rig.mass
    if "stiffness" in rig.knows:
        facts["stiffness_N_per_m"] = (
            {"by": "spring", **dict(zip(SPRINGS, rig.springs, strict=False))} if two else rig.springs[0]
        )
    facts["water_density_kg_per_m3"] = WATER
    wet = [level for level in rig.levels if level.wet]
    if "area" in rig.knows:
        facts["area_m2"] = {"by": "water_depth_m", **{_number(level.depth): level.area for level in wet}}
    if rig.coordinate == "translation":
        facts["submerged_volume_m3"] = {"by": "water_depth_m", **{_number(level.depth): level.volume for level in wet}}
    if "scatter" in rig.knows:
        facts["scatter"] = dict(zip(("k", "c", "mu"), (float(f"{s:.2g}") for s in rig.scatter), strict=True))
    lines.append("specimen:")
    lines += [f"  {key}: {_flow(v) if isinstance(v, dict) else _number(v)}" for key, v in facts.items()]
    lines += ["equation:", f"  terms: [{', '.join(rig.terms)}]", f"  coordinate: {rig.coordinate}", "seed: 0"]
    return "\n".join(lines) + "\n"


def truth(case: Case) -> dict[str, object]:
    """Everything that the scorer may know."""
    rig = case.rig
    groups = []
    for spring, level in rig.groups():
        water = rig.levels[level]
        name: dict[str, object] = {"spring": SPRINGS[spring]} if len(rig.springs) > 1 else {}
        if len(rig.levels) > 1:
            name["water_depth_m"] = float(_number(water.depth))
        trials = [t for t in rig.trials if (t.spring, t.level) == (spring, level)]
        body = rig.body(spring, level)
        groups.append(
            {
                "group": name,
                "wet": water.wet,
                "trials": [t.file for t in trials],
                "body": vars(body),
                "period_s": 2 * math.pi / body.frequency,
            }
        )
    return {
        "case": case.name,
        "seed": case.seed[0],
        "kind": case.plan.kind,
        "reason": case.plan.reason,
        "lost": case.plan.lost,
        "measures": case.measures,
        "groups": groups,
        "strata": strata(case),
        "scatter": dict(zip(("k", "c", "mu"), rig.scatter, strict=True)),
        "scatter_shape": rig.scatter_shape,
        "trials": {
            t.file: {"release_m": t.release, "factors": t.factors, "clock_s": t.clock, "rest_m": t.rest}
            for t in rig.trials
        },
        "mass_kg": rig.mass,
        "terms": list(rig.terms),
        "coordinate": rig.coordinate,
        "knows": sorted(rig.knows),
    }


def strata(case: Case) -> dict[str, object]:
    """By what the false positives are split."""
    rig = case.rig
    dry = rig.dry_trials
    noise = rig.sensors[0].noise / rig.largest
    most = max(sum((t.spring, t.level) == g for t in rig.trials) for g in rig.groups())
    return {
        "dry": "none" if dry == 0 else "few" if dry <= 3 else "many",
        "noise": "below 3e-4" if noise < 3e-4 else "3e-4 to 3e-3" if noise < 3e-3 else "above 3e-3",
        "trials": "1" if most == 1 else "2 to 4" if most <= 4 else "5 to 20",
        "springs": len(rig.springs),
        "levels": sum(level.wet for level in rig.levels),
        "channels": len(rig.sensors),
        "scatter": "normal" if rig.scatter_shape == "normal" else "not normal",
        "frequency": "below 1 Hz" if rig.reference.frequency < 2.0 * math.pi else "above 1 Hz",
        "coordinate": rig.coordinate,
        "lost samples": "yes" if case.plan.lost else "no",
        "noise_value": noise,
        "correlated noise": "yes" if rig.sensors[0].correlation else "no",
    }


def write(case: Case, out: Path) -> None:
    """The laboratory's folder under `out`/laboratory, and the truth under `out`/sealed, which no runner is given."""
    texts = {trial.file: recording(case, trial) for trial in case.rig.trials}
    folder = out / "laboratory" / case.name
    (folder / "recordings").mkdir(parents=True, exist_ok=True)
    for name, text in texts.items():
        (folder / "recordings" / name).write_text(text, encoding="utf-8")
    (folder / "campaign.csv").write_text(index_table(case.rig), encoding="utf-8")
    (folder / "config.yaml").write_text(config(case), encoding="utf-8")
    sealed = out / "sealed"
    sealed.mkdir(parents=True, exist_ok=True)
    (sealed / f"{case.name}.json").write_text(json.dumps(truth(case), indent=1, default=float) + "\n", encoding="utf-8")
