"""The one entry: draw the cases, run the program on the laboratories, score the verdicts against the truths.

    python -m experiments blind_challenge generate --set calibration --out runs/blind
    python -m experiments blind_challenge run --out runs/blind [--jobs 2]
    python -m experiments blind_challenge peers --out runs/blind
    python -m experiments blind_challenge measure --out runs/blind   # strengths of cases drawn before, stated anew
    python -m experiments blind_challenge score --out runs/blind --page docs/blind_challenge.md
    python -m experiments blind_challenge ablate --out runs/blind --first 200 --page docs/ablations.md
    python -m experiments blind_challenge all --small

`--small` is a slice of six quick cases, of which the lightest is run. The set `test` is for frozen revisions: run it
once, and take a new seed after a rule changed.
"""

import argparse
import json
import shutil
import sys
import tempfile
from pathlib import Path

from experiments.blind_challenge import composition

ROOT = Path(__file__).resolve().parents[2]
SMALL = 6  # cases of the small slice
SMALL_SEED = 7
ROWS = "rows.jsonl"
PEER_ROWS = "peers.jsonl"


def arguments(line: list[str]) -> argparse.Namespace:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", choices=("generate", "measure", "run", "peers", "score", "ablate", "all"))
    parser.add_argument(
        "--out", type=Path, default=Path("runs/blind"), help="folder of the challenge; default runs/blind"
    )
    parser.add_argument(
        "--set", choices=("calibration", "test"), default="calibration", help="which of the two named seeds"
    )
    parser.add_argument("--seed", type=int, help="another seed than the two named ones")
    parser.add_argument("--cases", type=int, default=composition.FULL, help=f"how many; default {composition.FULL}")
    parser.add_argument(
        "--shares", help='numbers of each kind, such as {"nothing": 700, "one": 200}; they are scaled to --cases'
    )
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--first", type=int, default=200, help="how many cases `ablate` decides again; default 200")
    parser.add_argument("--only", nargs="*", help="run these cases alone, such as c0003 c0017")
    parser.add_argument(
        "--frequency",
        help='how often each kind occurs in laboratories, for the calibration, such as {"nothing": 0.5, ...}',
    )
    parser.add_argument("--page", type=Path, help="where the page goes; default OUT/blind_challenge.md")
    parser.add_argument(
        "--small", action="store_true", help="a slice for continuous integration, in a folder of its own"
    )
    return parser.parse_args(line)


def seed_of(args: argparse.Namespace) -> int:
    """The seed that the arguments ask for."""
    if args.seed is not None:
        return int(args.seed)
    return composition.TEST_SEED if args.set == "test" else composition.CALIBRATION_SEED


def make(args: argparse.Namespace) -> None:
    """Draw and write the cases."""
    from experiments.blind_challenge.generate import generate

    shares = json.loads(args.shares) if args.shares else composition.SMALL_SHARES if args.small else None
    names = generate(args.out, seed_of(args), args.cases, args.jobs, shares, args.small)
    print(f"{len(names)} cases of seed {seed_of(args)} in {args.out}/laboratory; truths in {args.out}/sealed")


def state_again(args: argparse.Namespace) -> None:
    """State the strengths of a challenge anew."""
    from experiments.blind_challenge.generate import measure_again

    print(f"{measure_again(args.out, args.jobs)} truths stated anew in {args.out}/sealed")


def lightest(laboratories: Path) -> str:
    """The laboratory with the fewest recordings of those with two or more, then with the smallest: quick to run."""
    weights = []
    for folder in (p for p in laboratories.iterdir() if p.is_dir()):
        sizes = [path.stat().st_size for path in (folder / "recordings").iterdir()]
        weights.append((len(sizes) < 2, len(sizes), sum(sizes), folder.name))
    return min(weights)[-1]


def execute(args: argparse.Namespace) -> None:
    """Run the program on the laboratories."""
    from experiments.blind_challenge.run_cases import run

    count = run(args.out / "laboratory", args.out / ROWS, ROOT, args.jobs, args.only)
    print(f"{count} campaigns run; rows in {args.out / ROWS}")


def beside(args: argparse.Namespace) -> None:
    """Run the peers on the laboratories."""
    from experiments.blind_challenge.peers import run_peers

    print(
        f"{run_peers(args.out / 'laboratory', args.out / PEER_ROWS, args.only)} groups; rows in {args.out / PEER_ROWS}"
    )


def judge(args: argparse.Namespace) -> None:
    """Open the truths, write the page, its numbers and its figure."""
    import matplotlib.pyplot as plt

    from experiments.blind_challenge import figures, page, score
    from experiments.blind_challenge.run_cases import read_rows

    rows = read_rows(args.out / ROWS)
    if not rows:
        raise SystemExit(
            f"score: {args.out / ROWS} has no row, at least one is needed; run `run --out {args.out}` first"
        )
    cases = score.load(rows, args.out / "sealed")
    frequency = json.loads(args.frequency) if args.frequency else None
    tables = score.tables(cases, read_rows(args.out / PEER_ROWS), frequency)
    marks = {
        "seed": rows[0]["seed"], "cases": rows[0]["cases"], "rows": len(rows),
        "revisions": sorted({str(r["revision"]) for r in rows}),
    }  # fmt: skip
    target = args.page or args.out / "blind_challenge.md"
    picture = target.parent / "pictures" / "blind_challenge.svg"
    picture.parent.mkdir(parents=True, exist_ok=True)
    made = figures.figure(tables)
    made.savefig(picture, metadata={"Date": None})
    plt.close(made)
    target.write_text(page.page(tables, marks, "pictures/blind_challenge.svg"), encoding="utf-8")
    text = json.dumps({"marks": marks, **tables}, indent=1, default=float) + "\n"
    target.with_suffix(".json").write_text(text, encoding="utf-8")
    print(f"{len(rows)} rows scored; page in {target}")


def take_away(args: argparse.Namespace) -> None:
    """Run the first cases as they are and with something taken away, and write what each was worth."""
    from experiments.blind_challenge import ablate, score
    from experiments.blind_challenge.run_cases import read_rows, run

    laboratory, out = args.out / "laboratory", args.out / "ablations"
    cases = sorted(p.name for p in laboratory.iterdir() if p.is_dir())[: args.first]
    cases = [case for case in cases if args.only is None or case in args.only]
    out.mkdir(parents=True, exist_ok=True)
    whole = out / ROWS
    run(laboratory, whole, ROOT, args.jobs, cases)
    rows = read_rows(whole)
    before = score.load(rows, args.out / "sealed")
    found = {}
    for what, folder in ablate.prepare(laboratory, out, cases, ablate.suspects_of(rows)).items():
        run(folder, folder.parent / ROWS, ROOT, args.jobs)
        found[what] = ablate.beside(before, score.load(read_rows(folder.parent / ROWS), args.out / "sealed"))
    revisions = sorted({str(row["revision"]) for row in rows})
    target = args.page or args.out / "ablations.md"
    marks = {"seed": rows[0]["seed"], "cases": len(cases), "revisions": revisions}
    target.write_text(ablate.page(found, marks), encoding="utf-8")
    print(f"{len(cases)} cases decided again; page in {target}")


def main(line: list[str] | None = None) -> int:
    """Run one command; 0 when done."""
    args = arguments(sys.argv[1:] if line is None else line)
    if args.small:
        args.seed, args.cases = SMALL_SEED if args.seed is None else args.seed, SMALL
        if args.command == "all":
            args.out = Path(tempfile.mkdtemp(prefix="blind_challenge_"))
    commands = {
        "generate": make, "measure": state_again, "run": execute, "peers": beside, "score": judge, "ablate": take_away,
    }  # fmt: skip
    for name in ("generate", "run", "score") if args.command == "all" else (args.command,):
        if name == "run" and args.small and args.only is None:
            args.only = [lightest(args.out / "laboratory")]
        commands[name](args)
    if args.small and args.command == "all":
        shutil.rmtree(args.out)
    return 0
