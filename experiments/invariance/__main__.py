"""Run campaigns as they are and rescaled, compare their verdicts, and make docs/invariance.md.

    python -m experiments invariance                 # all twelve, three scales each: two hours on two cores
    python -m experiments invariance --small         # one campaign, one scale
    python -m experiments invariance --only two nothing --scales 1
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

from experiments.files import add_rows, read_rows, table
from experiments.invariance.campaigns import LENGTH, MASS, ROOT, SEED, TIME, makers, scales
from experiments.invariance.compare import differences, largest
from experiments.invariance.rescale import rescale
from experiments.revision import revision
from undertow.campaign.run.folder import run_to_folder

ROWS = Path(__file__).resolve().parent / "results" / "rescaled.csv"
HOLDS = ROWS.with_name("holds.csv")
COLUMNS = ("campaign", "time", "length", "mass", "groups", "differences", "largest", "seconds", "revision")


def main(arguments: list[str] | None = None) -> int:
    """Rows of the study, and its page."""
    parser = argparse.ArgumentParser(description="The same campaigns in other units of time, length and mass.")
    parser.add_argument("--only", nargs="*", default=[], help="campaigns")
    parser.add_argument("--scales", type=int, default=3, help="scales a campaign")
    parser.add_argument("--small", action="store_true", help="one campaign of few trials, one scale")
    parser.add_argument("--page", action="store_true", help="make the page from the rows there are")
    options = parser.parse_args(arguments)
    if options.page:
        return _page()
    names, count = (["nothing"], 1) if options.small else (options.only, options.scales)
    wrong = 0
    for place, (name, make) in enumerate(makers(names).items()):
        with tempfile.TemporaryDirectory() as folder:
            wrong += _campaign(place, name, make(Path(folder) / "as_it_is"), Path(folder), count, options.small)
    return min(wrong, 1) if options.small else _page()


def _campaign(place: int, name: str, config: Path | None, folder: Path, count: int, small: bool) -> int:
    """One campaign at all its scales; how many differ."""
    if config is None:
        print(f"{name}: its recordings are not here, left out", flush=True)
        return 0
    wrong = 0
    run_to_folder(config, (), folder / "first", jobs=1)
    for at, scale in enumerate(scales(place, count)):
        start = time.process_time()
        again = rescale(config, folder / f"rescaled{at}", scale)
        run_to_folder(again, (), folder / f"run{at}", jobs=1)
        found = differences(folder / "first", folder / f"run{at}", scale)
        far = largest(folder / "first", folder / f"run{at}", scale)
        said = "; ".join(f"{d.group} {d.what}" for d in found)
        row = (name, f"{scale.time:.4g}", f"{scale.length:.4g}", f"{scale.mass:.4g}", _groups(folder / "first"), said,
               f"{far:.3g}", round(time.process_time() - start), revision())  # fmt: skip
        print(" | ".join(map(str, row)), flush=True)
        wrong += bool(found)
        if not small:
            add_rows(ROWS, COLUMNS, [row])
    return wrong


def _groups(run: Path) -> int:
    return (run / "verdict.json").read_text(encoding="utf-8").count('"status"')


def _holds() -> list[str]:
    """The part on holds before the release, from the rows of holds.py; nothing where it was not run."""
    rows = read_rows(HOLDS)
    if not rows:
        return []
    right = sum(row["right"] == "True" for row in rows)
    lines = [
        "", "## Holds of any length, bodies of any period", "",
        "A light body in air and in water, Eq. 15 alone, every suspect looked for: `nothing_missing` is right in both "
        "groups, with the added mass within three standard errors (`python -m experiments invariance.holds`).", "",
        f"**{right} of {len(rows)} campaigns were right.**", "",
    ]  # fmt: skip
    cells = [
        (r["periods_held"], r["frequency_hz"], r["statuses"].replace("_", " "), r["added_mass_in_stderr"]) for r in rows
    ]
    head = ("held, periods", "body, Hz", "said dry; wet", "added mass, standard errors off")
    return [*lines, table(head, cells)]


def _page() -> int:
    """docs/invariance.md from the rows."""
    rows = read_rows(ROWS)
    same = sum(not row["differences"] for row in rows)
    ends = {"time": TIME, "length": LENGTH, "mass": MASS}
    ranges = ", ".join(f"{name} {low:.2g} to {high:g} times" for name, (low, high) in ends.items())
    lines = [
        "# The same verdict in other units", "",
        "After reading this page you know whether a watch's balance and a ship get the same treatment as a bridge.",
        "`python -m experiments invariance` makes it.", "",
        f"Every recording, specimen and window of a campaign was rescaled ({ranges}, noise and sampling rate alike; "
        f"seed {SEED}) and the campaign run again. Statuses, names and rivals must be the same, and every number must "
        "scale by its unit within a tenth of its standard error.", "",
        f"**{same} of {len(rows)} rescaled campaigns gave the same answers.**", "",
    ]  # fmt: skip
    shown = ("campaign", "time", "length", "mass", "groups", "largest", "differences", "revision")
    head = (*shown[:5], "largest difference, standard errors", "what differs", "revision")
    lines += [table(head, [[r[name] or "nothing" for name in shown] for r in rows]), *_holds()]
    (ROOT / "docs" / "invariance.md").write_text("\n".join([*lines, ""]), encoding="utf-8")
    return 0
