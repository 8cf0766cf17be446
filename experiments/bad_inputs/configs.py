"""Configs and indexes that are wrong, endless, or lead out of their folder.

Belongs here: texts of config.yaml, --set and campaign.csv. Does not belong here: recordings (recordings.py).
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

from experiments.bad_inputs.case import CONFIG, FAILED, USAGE, Case, edit, run_words


def config(old: str, new: str) -> Callable[[Path], object]:
    """The config with another text in one place."""
    return lambda folder: edit(folder / "config.yaml", old, new)


def written(text: str | bytes) -> Callable[[Path], object]:
    """A config of this text."""
    said = text.encode() if isinstance(text, str) else text
    return lambda folder: (folder / "config.yaml").write_bytes(said)


def override(said: str) -> Callable[[Path], list[str]]:
    """``run --set``."""
    return lambda folder: run_words(folder, "--set", said)


def index(text: str) -> Callable[[Path], object]:
    """An index of this text."""
    return lambda folder: (folder / "campaign.csv").write_text(text)


def link(folder: Path) -> None:
    """A trial that is a link out of the campaign's folder."""
    outside = folder.parent / f"{folder.name}_outside"
    outside.mkdir(exist_ok=True)
    (folder / "r00.csv").replace(outside / "secret.csv")
    os.symlink(outside / "secret.csv", folder / "r00.csv")


def linked_by_glob(folder: Path) -> None:
    """The same, found by a glob."""
    link(folder)
    edit(folder / "config.yaml", "index: campaign.csv", 'files: "r*.csv"')
    edit(folder / "config.yaml", "trials:\n  group_by: [spring]\n", "")


def endless_pattern(folder: Path) -> None:
    """A pattern that tries a file's name in more ways than there are seconds."""
    (folder / "r00.csv").replace(folder / f"{'a' * 120}!.csv")
    edit(folder / "config.yaml", "index: campaign.csv", 'files: "a*.csv"\n  pattern: "(?P<spring>(a+)+)$"')


def old_workbook(folder: Path) -> None:
    """An index as Excel saved it before 2007."""
    (folder / "campaign.xls").write_bytes(b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1" + bytes(504))
    edit(folder / "config.yaml", "campaign.csv", "campaign.xls")


def deep(levels: int) -> str:
    """A list in a list in a list."""
    return "[" * levels + "]" * levels


def one(name: str, old: str, new: str, says: str, code: int = USAGE) -> Case:
    """A config with another text in one place."""
    return Case(name, config(old, new), says, code)


CASES = (
    one("an unknown key", "  channels:", "  chanels:", r"line 4: unknown key 'chanels' in recordings; did you mean"),
    one("a unit that is none", "unit: m}", "unit: furlongz}", r"line 6: displacement: unit 'furlongz' is not known"),
    one("the unit m-", "unit: m}", 'unit: "m-"}', r"displacement: unit 'm-' is not known"),
    one("the unit m//", "unit: m}", 'unit: "m//"}', r"displacement: unit 'm//' is not known"),
    one("a unit of 10,000 characters", "unit: m}", f"unit: {'m' * 10_000}}}", r"displacement: unit 'm+' is not known"),
    one("a unit to a huge power", "unit: m}", 'unit: "m**9**9**9**9"}', r"displacement: unit .* is not known"),
    one("a mass for a length", "unit: m}", "unit: kg}", r"displacement is said to be in 'kg', which is kg in SI"),
    one("rate_hz 1e-300", "{column: t, unit: s}", "{rate_hz: 1.0e-300}", r"rate_hz is 1e-300 Hz, which no logger has"),
    one("a term that is none", "viscous_damping]", "viscous]", r"equation term 'viscous' is not in the registry"),
    one("a mass in words", "mass_kg: 2637.4", "mass_kg: heavy", r"specimen\.mass_kg is 'heavy' but should be a valid"),
    one("a suspect that is none", "suspects: []", "suspects: [ghosts]", r"discrepancy\.suspects: 'ghosts' is none of"),
    one("brackets that do not close", "identify: [sindy]", "identify: [sindy", r"line 1\d: .*; correct the YAML"),
    one("a key twice", "name: bad", "name: bad\nname: worse", r"line 2: .*name.*; correct the YAML"),
    one("a key that is needed", "name: bad\n", "", r"the config has no 'name'; it is needed"),
    one("a group that is no condition", "[spring]", "[depth]", r"trials\.group_by names .depth., but"),
    one("a YAML tag", "name: bad", "name: !!python/object/apply:os.system [ls]", r"line 1: a tag .* is not read"),
    one("a YAML alias", "name: bad", "name: &a bad\nseed: *a", r"an alias \(\*\.\.\.\) is not read"),
    one("an index that is not there", "campaign.csv", "nope.csv", r"recordings\.index .*nope\.csv is not there"),
    Case("a pattern that searches for ever", endless_pattern, r"takes more than 5 s for 1 file names; a repeat within",
         USAGE, slow=True),
    one("a glob that goes up again and again", "index: campaign.csv", 'files: "*/../*/../*/../r*.csv"',
        r"recordings\.files .* goes up \(\.\.\) from a wildcard; give each folder its own glob"),
    one("a term named twice", "[stiffness, viscous_damping]", "[stiffness, stiffness]",
        r"equation\.terms names 'stiffness' twice; take one of them out"),
    Case("an index of Excel before 2007", old_workbook, r"is an old or foreign spreadsheet; save it as \.xlsx or CSV",
         USAGE),
    one("a glob that fits nothing", "index: campaign.csv", 'files: "*.tsv"', r"recordings\.files '\*\.tsv' fits no"),
    Case("100,000 keys", written(CONFIG + "".join(f"k{i}: 0\n" for i in range(100_000))),
         r"has \d+ bytes, more than 1000000|more than 100000 keys", USAGE),
    Case("30,000 braces", written("{" * 30_000), r"line 1: lists and keys lie more than 32 levels deep", USAGE),
    Case("a config of 2 MB", written("#" * 2_000_000), r"has 2000000 bytes, more than 1000000; is it a config", USAGE),
    Case("a config that is no text", written(b"\xff\xfe\x00name"), r"cannot be read: it is not UTF-8 text", USAGE),
    Case("a config that is a list", written("- a\n- b\n"), r"holds a list, not keys with values", USAGE),
    Case("an empty config", written(b"\n"), r"is empty; is it a config", USAGE),
    Case("a config that is not there", lambda f: (f / "config.yaml").unlink(), r"cannot be read: No such file", USAGE),
    Case("a folder as a config", lambda f: ["run", str(f)], r"cannot be read: Is a directory", USAGE),
    Case("--set without =", override("nonsense"), r"--set nonsense: it must read key\.key=value", USAGE),
    Case("--set 3,000 lists deep", override(f"name={deep(3000)}"), r"lie more than 32 levels deep", USAGE),
    Case("--set of 3,000 keys", override(".".join("a" * 3000) + "=1"), r"the key has 3000 parts", USAGE),
    Case("--set of a negative seed", override("seed=-1"), r"--set seed=-1: seed is -1 but should be greater", USAGE),
    Case("--set with a misspelt key", override("specimen.mas_kg=1"), r"unknown key 'mas_kg' in specimen; did", USAGE),
    Case("--set with a tag", override("name=!!python/name:os.system x"), r"a tag \(!\.\.\.\) is not read", USAGE),
    Case("an index that names a file which is not there", index("file,spring\ngone.csv,long\n"),
         r"the index names 'gone\.csv', but .* is not there; copy it or drop the row", USAGE),
    Case("an index that names ../", index("file,spring\n../r00.csv,long\n"),
         r"names the file '\.\./r00\.csv'; it must lie in the index's folder", USAGE),
    Case("an index that names /etc/passwd", index("file,spring\n/etc/passwd,long\n"),
         r"names the file '/etc/passwd'; it must lie in the index's folder", USAGE),
    Case("a link out of the folder, by an index", link, r"a link that leads out of its folder, to .*secret\.csv",
         USAGE),
    Case("a link out of the folder, by a glob", linked_by_glob, r"r00\.csv is a link that leads out", USAGE),
    Case("an index that lists a file twice", index("file,spring\nr00.csv,a\nr00.csv,b\n"),
         r"trial '.*r00\.csv' is listed 2 times", USAGE),
    Case("parts of one recording that overlap",
         override("recordings.releases={r00: [{end_s: 3}, {start_s: 2}]}"),
         r"part 1 ends at 3 s and part 2 starts at 2 s: parts of one recording share no sample", USAGE),
    Case("an index row with more cells", index("file,spring\nr00.csv,long,9\n"),
         r"campaign\.csv line 2 has 3 cells but the header has 2", USAGE),
    Case("an index with a column twice", index("file,spring,spring\nr00.csv,a,b\n"), r"has 2 columns named 'spring'",
         USAGE),
    Case("an index of a header alone", index("file,spring\n"), r"has no rows below its header", USAGE),
    Case("an empty index", index("\n"), r"recordings\.index: .*campaign\.csv is empty \(1 bytes\)", USAGE),
    Case("an index of control bytes", index("\0\1\2"), r"recordings\.index: .*is not text", USAGE),
    Case("an index without the file's column", index("name,spring\nr00.csv,a\n"), r"has no column 'file'; it has name",
         USAGE),
)  # fmt: skip
"""Configs and indexes through ``run``."""

__all__ = ["CASES", "FAILED"]
