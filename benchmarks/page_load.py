"""How long a page takes to load in headless Chromium: limit 1.5 s.

    python -m benchmarks.page_load runs/flume/report.html [PAGE ...]     # writes benchmarks/page_load.json

Each page is loaded some times, each time by a browser that has just started with an empty profile. Seconds from the
request to the first picture, to the document read and its scripts run, and to the end of the load event (Navigation
Timing, Paint Timing), and processor time of the page's own thread: least, median and largest. On a machine that others
use, the least is nearest to a free one. Belongs here: that measurement. Does not belong here: the time it takes to
make a page (page.py).
"""

from __future__ import annotations

import json
import os
import statistics
import sys
from pathlib import Path
from typing import Any

from tests.browser import browser

RESULTS = Path(__file__).with_suffix(".json")
LOADS, WIDTH_PX, HEIGHT_PX, LIMIT_S = 9, 1440, 1000, 1.5


def measured(path: Path) -> dict[str, Any]:
    """A page's load times in s, least, median and largest of `LOADS`, and its size."""
    found = []
    for _ in range(LOADS):
        with browser() as tab:
            tab.shape(WIDTH_PX, HEIGHT_PX)
            tab.open(path)
            found.append(tab.load_s())
    columns = {name: [one[name] for one in found] for name in found[0]}
    times = {
        f"{name}_s": [round(of(values), 3) for of in (min, statistics.median, max)] for name, values in columns.items()
    }
    return {"page": path.parent.name, "megabytes": round(path.stat().st_size / 1e6, 2), **times}


def main(arguments: list[str] | None = None) -> int:
    """Load the pages and write their times."""
    pages = [Path(one) for one in (sys.argv[1:] if arguments is None else arguments)]
    if not pages:
        print((__doc__ or "").strip())
        return 2
    rows = [measured(page) for page in pages]
    found = {"loads": LOADS, "limit_s": LIMIT_S, "load_average": round(os.getloadavg()[0], 1), "pages": rows}
    RESULTS.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    print(json.dumps(found, indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
