#!/usr/bin/env python3
"""Take the picture of the page of a run, docs/images/web.png, in a headless Chromium.

Runs and records explore.yaml, unless a recording is named: ``tools/capture_page.py [FILE.mcap]``.
The pictures of commands' pages are taken by ``tools/commands/NAME/capture_page.py``.
"""

from __future__ import annotations

import argparse
import asyncio
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image

from bt_mission.views.web.report.page import robot_runs, served_page_of
from bt_mission.views.web.server import PageServer, WebOptions
from tests.support.browser import Page, browser
from tests.support.web_pages import play_with

ROOT = Path(__file__).resolve().parent.parent

AT_S = 42.0
LIMIT_S = 300.0
READY = "document.querySelectorAll('.row').length > 3 && document.querySelector('#log li')"
OPEN_MAP = "document.getElementById('map-toggle').click()"
OPEN_CHART = "[...document.querySelectorAll('#variables button')].at(-1).click()"
DRAWN = (
    "document.querySelector('#chart-drawing polyline') "
    "&& document.getElementById('map-title').textContent.includes('x ')"
)


def command(*words: str) -> None:
    """Run a command of bt-mission."""
    subprocess.run([sys.executable, "-m", "bt_mission", *words], check=True)  # noqa: S603 - ourselves


def capture_web(recording: Path | None, page: Page, folder: Path) -> None:
    """Capture the page of a recording, with its map and a chart."""
    if recording is None:
        recording = folder / "explore.mcap"
        command("run", "explore", "--plain", "--record", str(recording))
    runs = [replace(run, data={**run.data, "at": AT_S}) for run in robot_runs(recording)]

    def look(link: str) -> None:
        page.visit(link, width=1180, height=900)
        page.until(READY)
        page.look(OPEN_MAP)
        page.look(OPEN_CHART)
        page.until(DRAWN)
        page.screenshot(folder / "web.png")

    served = PageServer(served_page_of(runs), WebOptions(port=0))
    play_with(served, lambda server: asyncio.to_thread(look, server.link), LIMIT_S)


def capture(name: str, take: Callable[[Page, Path], None], colours: int = 96) -> None:
    """Write docs/images/NAME.png, which `take` has a page write into a folder."""
    with TemporaryDirectory(ignore_cleanup_errors=True) as temporary:
        folder = Path(temporary)
        with browser(folder / "profile") as page:
            page.prefer("light")
            take(page, folder)
        picture = ROOT / "docs" / "images" / f"{name}.png"
        with Image.open(folder / f"{name}.png") as image:
            image.convert("RGB").quantize(colours).save(picture, optimize=True)
    print(picture, f"{picture.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("recording", nargs="?", type=Path)
    capture("web", partial(capture_web, parser.parse_args().recording))
