#!/usr/bin/env python3
"""Make docs/images/web.png: the page of a recording of explore.yaml, in a headless Chromium.

Carries the mission out and records it, or takes the recording that is named:
``tools/make_web_picture.py FILE.mcap``.
"""

from __future__ import annotations

import argparse
import asyncio
import subprocess
import sys
from contextlib import closing
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image

from bt_mission.recording.replay.player import Player
from bt_mission.recording.replay.timeline import read_timeline
from bt_mission.views.web.replay import ReplayedMission
from bt_mission.views.web.server import WebOptions, WebServer

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
from tests.support.browser import Page, browser  # noqa: E402 - found by the line above

PICTURE = ROOT / "docs" / "images" / "web.png"
AT_S = 42.0
WIDTH, HEIGHT = 1180, 900
COLOURS = 96
READY = "document.querySelectorAll('.row').length > 3 && document.querySelector('#log li')"
OPEN = "document.getElementById('map-toggle').click()"
CHART = "[...document.querySelectorAll('#variables button')].at(-1).click()"
DRAWN = (
    "document.querySelector('#chart-drawing polyline') "
    "&& document.getElementById('map-title').textContent.includes('x ')"
)


def photograph(page: Page, link: str, file: Path) -> None:
    """Open the page with its map and a chart, and save what is seen."""
    page.prefer("light")
    page.visit(link, width=WIDTH, height=HEIGHT)
    page.until(READY)
    page.look(OPEN)
    page.look(CHART)
    page.until(DRAWN)
    page.screenshot(file)


async def serve(recording: Path, page: Page, file: Path) -> None:
    """Serve the page while it is photographed."""
    shown = ReplayedMission(Player(read_timeline(recording), at_s=AT_S))
    with closing(WebServer(shown, WebOptions(port=0))) as server:
        is_over = False
        serving = asyncio.create_task(server.serve(lambda: is_over))
        try:
            await asyncio.to_thread(photograph, page, server.link, file)
        finally:
            is_over = True
            await serving


def main() -> int:
    """Record the mission, and photograph its page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("recording", type=Path, nargs="?")
    recording = parser.parse_args().recording
    with TemporaryDirectory(ignore_cleanup_errors=True) as name:
        folder = Path(name)
        if recording is None:
            recording = folder / "explore.mcap"
            command = [sys.executable, "-m", "bt_mission", "run", "explore", "--plain"]
            subprocess.run([*command, "--record", str(recording)], check=True)  # noqa: S603 - ourselves
        with browser(folder / "profile") as page:
            asyncio.run(serve(recording, page, folder / "web.png"))
        with Image.open(folder / "web.png") as picture:
            picture.convert("RGB").quantize(COLOURS).save(PICTURE, optimize=True)
    print(PICTURE, f"{PICTURE.stat().st_size / 1e3:.0f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
