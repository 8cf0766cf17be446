"""How long a driven fit takes: numbers of the obvious equation from whole records of the public benchmarks.

    python -m benchmarks.driven_speed                  # five rounds; prints median and least CPU seconds, one core
    python -m benchmarks.driven_speed --rounds 1 --sets emps

Warm: the first fit of a set, which loads what is compiled, is not counted. Data: ../shared/driven, beside the
repository.

Belongs here: that clock. Does not belong here: errors beside peers (beside_peers/).
"""

from __future__ import annotations

import argparse
import time

import numpy as np

import undertow
from benchmarks.beside_peers.driven_sets import DrivenSet, load
from undertow.front.driving import Driven

SETS = ("emps", "silverbox")
"""Sets whose obvious equation describes them well enough for its time to mean something."""


def seconds(data: DrivenSet, rounds: int) -> tuple[list[float], Driven]:
    """CPU seconds of that many fits to the whole record, and the last fit."""

    def once() -> Driven:
        return undertow.fit_driven(data.x, t=data.step, u=data.u, equation=data.equation, hold=data.hold)

    found, spent = once(), []
    for _ in range(rounds):
        began = time.process_time()
        found = once()
        spent.append(time.process_time() - began)
    return spent, found


def main() -> None:
    """Fit and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--sets", nargs="+", choices=SETS, default=SETS)
    given = parser.parse_args()
    for name in given.sets:
        data = load(name)
        spent, found = seconds(data, given.rounds)
        print(
            f"{name}: {len(found.numbers)} numbers, {data.x.size} samples: median {np.median(spent):.2f} s, least "
            f"{min(spent):.2f} s; free run {found.rms * data.factor:.4g} {data.unit}"
        )


if __name__ == "__main__":
    main()
