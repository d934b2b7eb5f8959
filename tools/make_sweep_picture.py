#!/usr/bin/env python3
"""Make docs/images/sweep.png: the page of a sweep of explore.yaml, in a headless Chromium.

Carries 200 scenarios out (some minutes), or takes the results that are named:
``tools/make_sweep_picture.py RESULTS``.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image

from bt_mission.sweeps.report.page import write_sweep_page
from bt_mission.sweeps.store import ResultStore

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))
from tests.support.browser import browser  # noqa: E402 - found by the line above

PICTURE = ROOT / "docs" / "images" / "sweep.png"
SPEEDS, DISTANCES = "speed=0.06,0.1,0.15,0.2,0.26", "stopping_distance=0.3,0.5,0.7,0.9"
WIDTH, HEIGHT = 1180, 1150
COLOURS = 64


def main() -> int:
    """Carry the sweep out, and photograph its page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("results", type=Path, nargs="?")
    results = parser.parse_args().results
    with TemporaryDirectory() as name:
        folder = Path(name)
        if results is None:
            results = folder / "results"
            vary = ["--vary", SPEEDS, "--vary", DISTANCES, "--seeds", "10"]
            command = [sys.executable, "-m", "bt_mission", "sweep", "explore", *vary]
            subprocess.run([*command, "-o", str(results)], check=True)  # noqa: S603 - ourselves
        with ResultStore.read(results) as store:
            page = write_sweep_page(store, folder / "sweep.html")
        with browser(folder / "profile") as chromium:
            chromium.prefer("light")
            chromium.open(page, width=WIDTH, height=HEIGHT)
            chromium.screenshot(folder / "sweep.png")
        with Image.open(folder / "sweep.png") as picture:
            picture.convert("RGB").quantize(COLOURS).save(PICTURE, optimize=True)
    print(PICTURE, f"{PICTURE.stat().st_size / 1e3:.0f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
