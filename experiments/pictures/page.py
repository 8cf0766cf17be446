"""The six pictures of docs/page.md, by headless Chromium from a finished run's page.

    python -m experiments pictures page runs/flume

Belongs here: what of the page each shows. Does not belong here: the browser (tests/browser.py).
"""

from __future__ import annotations

from pathlib import Path

from tests.browser import browser

TARGET = Path(__file__).resolve().parents[2] / "docs" / "pictures" / "page"
GROUP = "spring-short-water-depth-2-36-m"
"""The group whose section is shown, by its anchor."""

DESK, PHONE = (1100, 860), (390, 1150)
LOADED = "document.documentElement.classList.add('loaded')"
PLACE = "(e => {{ const r = e.getBoundingClientRect(); return [r.top + scrollY, r.height] }})({})"
WAIT = "new Promise(done => setTimeout(done, 500))"


def six(run: Path, target: Path = TARGET) -> None:
    """First screen, a group, its trials, the explorer, the first screen in the dark and on a phone."""
    with browser() as page:
        page.shape(*DESK)
        page.open(run / "report.html")
        page.run(LOADED)
        page.picture(target / "first_screen.png", x=0, y=0, width=DESK[0], height=DESK[1])
        top, _ = page.run(PLACE.format(f"document.querySelector('#{GROUP}')"))
        last, _ = page.run(PLACE.format(f"[...document.querySelectorAll('#{GROUP} h3')].at(-1)"))
        page.picture(target / "group.png", x=0, y=top, width=DESK[0], height=last - top - 10)
        page.run(f"document.querySelector('#{GROUP} details.part').open = true")
        page.run(WAIT)
        top, _ = page.run(PLACE.format(f"document.querySelector('#{GROUP} details.part')"))
        page.picture(target / "trials.png", x=0, y=top - 6, width=DESK[0], height=760)
        page.run("document.getElementById('explore').scrollIntoView()")
        page.until("document.querySelector('#explore-plot .main-svg')")
        page.run(WAIT)
        top, height = page.run(PLACE.format("document.getElementById('explore')"))
        page.picture(target / "explorer.png", x=0, y=top, width=DESK[0], height=height + 10)
        for name, shape, dark in (("dark", DESK, True), ("phone", PHONE, False)):
            page.shape(*shape, dark)
            page.open(run / "report.html")
            page.run(LOADED)
            page.picture(target / f"{name}.png", x=0, y=0, width=shape[0], height=shape[1])
