"""Take the picture of the page of a sweep, docs/images/sweep.png, in a headless Chromium.

Sweeps explore.yaml with 200 scenarios (some minutes), unless the results of a sweep are named:
``tools/commands/sweep/capture_page.py [RESULTS]``.
"""

from __future__ import annotations

import argparse
from functools import partial
from pathlib import Path

from bt_mission.commands.sweep.report.page import write_sweep_page
from bt_mission.commands.sweep.store import ResultStore
from tests.support.browser import Page
from tools.capture_page import capture, command

VARIED = ("speed=0.06,0.1,0.15,0.2,0.26", "stopping_distance=0.3,0.5,0.7,0.9")


def capture_sweep(results: Path | None, page: Page, folder: Path) -> None:
    """Capture the page of a sweep."""
    if results is None:
        results = folder / "results"
        vary = [word for range_ in VARIED for word in ("--vary", range_)]
        command("sweep", "explore", *vary, "--seeds", "10", "-o", str(results))
    with ResultStore.read(results) as store:
        file = write_sweep_page(store, folder / "sweep.html")
    page.open(file, width=1180, height=1150)
    page.screenshot(folder / "sweep.png")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("results", nargs="?", type=Path)
    capture("sweep", partial(capture_sweep, parser.parse_args().results), colours=64)
