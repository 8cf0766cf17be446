"""The whole way on a small slice with the real program."""

from pathlib import Path

from experiments.blind_challenge import __main__ as entry
from experiments.blind_challenge.peers import peer_rows
from experiments.blind_challenge.run_cases import read_rows


def test_a_small_challenge_is_drawn_run_beside_peers_and_scored(tmp_path: Path) -> None:
    out = ["--small", "--out", str(tmp_path)]
    entry.main(["generate", *out])
    entry.main(["run", *out])
    rows = read_rows(tmp_path / "rows.jsonl")
    assert [row["case"] for row in rows] == [entry.lightest(tmp_path / "laboratory")]
    assert rows[0]["exit"] in (0, 2, 3)
    assert isinstance(peer_rows(tmp_path / "laboratory" / "c0001"), list)
    entry.main(["score", *out])
    assert "## Targets" in (tmp_path / "blind_challenge.md").read_text()
    assert (tmp_path / "pictures" / "blind_challenge.svg").stat().st_size > 1000
