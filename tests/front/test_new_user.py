"""From a new user's files to a plotted verdict: the docs' five lines and three commands, as they are printed."""

from __future__ import annotations

import json
import re
import time
import webbrowser
from pathlib import Path

import pytest

import undertow
from undertow.cli import main

DOCS = Path(__file__).resolve().parents[2] / "docs"
LAW = {"stiffness": 400.0, "viscous_damping": 1.0, "coulomb_friction": 0.4, "cubic_stiffness": 4000.0}
"""What the files hold; the equation that the docs prescribe has no cubic stiffness."""

LIMIT_S = 90.0
"""Processor time of either way in this process: three to five times what was measured (docs/python_front.md)."""


def files(folder: Path, names: str) -> None:
    """Four decays of two columns, semicolons, decimal commas, millimetres."""
    folder.mkdir(exist_ok=True)
    for i, x0 in enumerate((0.03, 0.05, 0.07, 0.1)):
        run = undertow.simulate(LAW, x0=x0, mass_kg=4.0, rate_hz=60.0, duration_s=6.0).recorded(noise_m=1e-4, seed=i)
        x = 1e3 * run.channels["displacement"]
        rows = [f"{t:.4f};{v:.3f}".replace(".", ",") for t, v in zip(run.time, x, strict=True)]
        (folder / f"decay{i}.csv").write_text("\n".join([names, *rows]) + "\n")


def printed(page: str, heading: str, language: str) -> str:
    """The first block of code below a heading of a page of the docs."""
    text = (DOCS / page).read_text(encoding="utf-8").partition(f"## {heading}\n")[2]
    found = re.search(rf"```{language}\n(.*?)```", text, re.DOTALL)
    assert found is not None
    return found.group(1)


@pytest.mark.slow
def test_five_lines_lead_from_csv_files_to_a_plotted_verdict(tmp_path, monkeypatch, capsys):
    files(tmp_path, "Zeit;Weg")
    monkeypatch.chdir(tmp_path)
    lines = printed("python_front.md", "Five lines", "python")
    assert len(lines.strip().splitlines()) == 5
    start, names = time.process_time(), {}
    exec(compile(lines, "python_front.md", "exec"), names)
    assert time.process_time() - start < LIMIT_S
    assert (tmp_path / "verdict.png").stat().st_size > 10_000
    assert names["found"][0].sentence in capsys.readouterr().out


@pytest.mark.slow
def test_three_commands_lead_from_csv_files_to_a_page(tmp_path, monkeypatch):
    files(tmp_path / "my_folder", "Zeit [s];Weg [mm]")
    monkeypatch.chdir(tmp_path)
    opened: list[str] = []
    monkeypatch.setattr(webbrowser, "open", lambda address, *_: opened.append(address) or True)
    text = printed("quickstart.md", "Your own recordings, without a line of code", "console")
    commands = [line.partition("#")[0].split()[2:] for line in text.strip().splitlines()]
    assert [command[0] for command in commands] == ["init", "run", "open"]
    start = time.process_time()
    for command in commands:
        with pytest.raises(SystemExit, match=r"^\d*$") as end:
            main(command)
        assert not end.value.code
    assert time.process_time() - start < LIMIT_S
    folder = next(tmp_path.rglob("verdict.json")).parent
    assert len(json.loads((folder / "verdict.json").read_text())["groups"]) == 1
    assert opened == [(folder / "report.html").as_uri()]
