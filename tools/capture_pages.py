#!/usr/bin/env python3
"""Take pictures of pages for docs/images, in a headless Chromium: web.png, edit.png and sweep.png.

Runs and records explore.yaml, and sweeps it with 200 scenarios (some minutes), unless a recording
or the results of a sweep are named:
``tools/capture_pages.py [web [FILE.mcap] | edit | sweep [RESULTS]]``.
"""

from __future__ import annotations

import argparse
import asyncio
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image

from bt_mission.base.dds.middleware import prepare_middleware
from bt_mission.commands.edit.web.server import EditServer
from bt_mission.commands.edit.web.workspace import Workspace
from bt_mission.commands.sweep.report.page import write_sweep_page
from bt_mission.commands.sweep.store import ResultStore
from bt_mission.views.web.report.page import robot_runs, served_page_of
from bt_mission.views.web.server import PageServer, WebOptions

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
from tests.support.browser import Page, browser  # noqa: E402 - found by the line above
from tests.support.web_pages import play_with  # noqa: E402 - as above

VARIED = ("speed=0.06,0.1,0.15,0.2,0.26", "stopping_distance=0.3,0.5,0.7,0.9")
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


def capture_sweep(page: Page, results: Path | None, folder: Path) -> None:
    """Capture the page of a sweep."""
    if results is None:
        results = folder / "results"
        vary = [word for range_ in VARIED for word in ("--vary", range_)]
        command("sweep", "explore", *vary, "--seeds", "10", "-o", str(results))
    with ResultStore.read(results) as store:
        file = write_sweep_page(store, folder / "sweep.html")
    page.open(file, width=1180, height=1150)


def capture_web(page: Page, recording: Path | None, folder: Path) -> None:
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


def capture_edit(page: Page, _: Path | None, folder: Path) -> None:
    """Capture the editor beside a run."""
    prepare_middleware()
    missions = folder / "missions"
    missions.mkdir()
    (missions / "explore.yaml").write_bytes((ROOT / "missions" / "explore.yaml").read_bytes())

    def look(link: str) -> None:
        page.visit(link, width=1440, height=820)
        page.until("document.querySelectorAll('.node').length > 5")
        page.look("document.getElementById('speed').value = '4'")
        page.look("document.getElementById('run').click()")
        frame = "document.getElementById('run-frame').contentDocument"
        page.until(f"{frame}.getElementById('log')?.children.length > 6", 60)
        page.screenshot(folder / "edit.png")

    editor = EditServer(Workspace(missions), WebOptions(port=0))
    play_with(editor, lambda server: asyncio.to_thread(look, server.link), LIMIT_S)


def main() -> None:
    """Capture all, or one."""
    parser = argparse.ArgumentParser(description=__doc__)
    captures = {"web": capture_web, "edit": capture_edit, "sweep": capture_sweep}
    parser.add_argument("name", nargs="?", choices=captures)
    parser.add_argument("source", nargs="?", type=Path)
    options = parser.parse_args()
    for name in [options.name] if options.name else captures:
        with TemporaryDirectory(ignore_cleanup_errors=True) as temporary:
            folder = Path(temporary)
            with browser(folder / "profile") as page:
                page.prefer("light")
                captures[name](page, options.source, folder)
                if name == "sweep":
                    page.screenshot(folder / "sweep.png")
            picture = ROOT / "docs" / "images" / f"{name}.png"
            with Image.open(folder / f"{name}.png") as image:
                colours = 64 if name == "sweep" else 96
                image.convert("RGB").quantize(colours).save(picture, optimize=True)
        print(picture, f"{picture.stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
