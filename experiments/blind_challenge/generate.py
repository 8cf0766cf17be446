"""Draw and write a whole challenge, one case after the other or in a few processes."""

import hashlib
import json
import shutil
import tempfile
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path

from experiments.blind_challenge import cases, laboratory
from experiments.blind_challenge.composition import SHARES, Plan, plans

WEAKER = 0.5  # times the dose where a truth runs away
ATTEMPTS = 8


def make(out: Path, seed: int, index: int, plan: Plan) -> str:
    """One case, drawn and written; its name. One that runs away is made weaker, and its truth says the dose it has."""
    case = cases.draw_case(seed, index, plan)
    for _ in range(ATTEMPTS):
        try:
            laboratory.write(case, out)
            return case.name
        except laboratory.UnstableTruth:
            case = weaker(case)
    raise laboratory.UnstableTruth(f"case {case.name}: {plan.effects} runs away at every dose tried; look at its law")


def weaker(case: cases.Case) -> cases.Case:
    """The case with all doses halved and measured again."""
    effects = tuple(replace(effect, dose=effect.dose * WEAKER) for effect in case.effects)
    views = [cases.measure.view(case.rig, trial) for trial in case.rig.trials]
    asked = [tuple(entry["asked"]) for entry in case.measures["effects"]]  # type: ignore[index, union-attr]
    found = cases.effect_measures(case.rig, views, list(effects), asked)
    return replace(case, effects=effects, measures={**case.measures, "effects": found})


def _job(job: tuple[Path, int, int, Plan]) -> str:
    return make(*job)


def generate(
    out: Path, seed: int, total: int, jobs: int = 1, shares: dict[str, float] | None = None, small: bool = False
) -> list[str]:
    """Write `total` cases into `out`/laboratory and `out`/sealed (emptied first); returns their names in order."""
    for name in ("laboratory", "sealed"):
        if (out / name).exists():
            shutil.rmtree(out / name)
    work = [(out, seed, i, plan) for i, plan in enumerate(plans(seed, total, shares, small))]
    if jobs > 1:
        with ProcessPoolExecutor(jobs) as pool:
            names = list(pool.map(_job, work, chunksize=4))
    else:
        names = [_job(job) for job in work]
    note = {
        "seed": seed,
        "cases": total,
        "shares": dict(shares or SHARES),
        "small": small,
        "digest": digest(out),
    }
    (out / "laboratory" / "challenge.json").write_text(json.dumps(note, indent=1) + "\n", encoding="utf-8")
    return names


def measure_again(out: Path, jobs: int = 1) -> int:
    """State the strengths of a challenge anew: its cases are drawn again beside it, and where all recordings are the
    same, byte for byte, the truths are taken over. Returns how many cases.
    """
    note = json.loads((out / "laboratory" / "challenge.json").read_text(encoding="utf-8"))
    with tempfile.TemporaryDirectory(dir=out) as folder:
        again = Path(folder)
        names = generate(again, note["seed"], note["cases"], jobs, note["shares"], note.get("small", False))
        for name in names:
            for path in sorted(p for p in (again / "laboratory" / name).rglob("*.*") if p.is_file()):
                before = out / path.relative_to(again)
                if not before.is_file() or before.read_bytes() != path.read_bytes():
                    raise ValueError(
                        f"case {name}: {path.name} is not what this generator draws from seed {note['seed']}; measure "
                        "it at the revision that drew it"
                    )
        for name in names:
            shutil.copy(again / "sealed" / f"{name}.json", out / "sealed" / f"{name}.json")
    return len(names)


def digest(out: Path) -> str:
    """One number for all bytes of all laboratories and truths: equal seeds must give equal digests."""
    total = hashlib.sha256()
    for path in sorted(
        p
        for name in ("laboratory", "sealed")
        for p in (out / name).rglob("*.*")
        if p.is_file() and p.name != "challenge.json"
    ):
        total.update(str(path.relative_to(out)).encode())
        total.update(path.read_bytes())
    return total.hexdigest()
