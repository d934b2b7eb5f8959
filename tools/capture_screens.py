"""Take the screens of docs/reference/terminal.md: a real mission, watched in tmux.

The screen between `<!-- screen: 80x24 -->` and `<!-- end -->` is replaced. The picture is taken of
the same view by Textual, as SVG.

Run it as: python tools/capture_screens.py [NAME ...]     (tmux is needed)
"""

from __future__ import annotations

import argparse
import asyncio
import os
import re
import shlex
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "reference" / "terminal.md"
PICTURE = ROOT / "docs" / "images" / "watch.svg"
PROGRAM = [sys.executable, "-m", "bt_mission"]
RUN = ["run", "missions/explore.yaml", "--set", "legs=100"]
TMUX = ["tmux", "-L", f"bt_mission_screens_{os.getpid()}"]
LIMIT_S = 180.0
SIZE = (80, 24)
SCREEN = f"{SIZE[0]}x{SIZE[1]}"
SHOWN = r"repeat .* 3 of 100[^$]*▶ drive .*█.* of 2"
"""The screen is taken when it matches this."""


@contextmanager
def mission() -> Iterator[None]:
    """Run a mission on the stage, in real time, which other processes can watch."""
    command = [*PROGRAM, *RUN, "--visible", "--speed", "1", "--plain"]
    process = subprocess.Popen(  # noqa: S603 - our own program
        command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        yield
    finally:
        process.terminate()
        process.wait()


def tmux(*arguments: str) -> str:
    """Run tmux; return its output."""
    done = subprocess.run(  # noqa: S603 - tmux, with arguments of this file
        [*TMUX, *arguments], check=True, capture_output=True, text=True, cwd=ROOT
    )
    return done.stdout


def captured() -> str:
    """Return the screen of `bt-mission watch`, once it matches `SHOWN`."""
    variables = {"TERM": "screen-256color", "LC_ALL": "C.UTF-8"} | {
        name: value for name, value in os.environ.items() if name.startswith(("ROS_", "PYTHONPATH"))
    }
    settings = [f"{name}={value}" for name, value in variables.items()]
    command = shlex.join(["env", *settings, *PROGRAM, "watch"])
    width, height = map(str, SIZE)
    tmux("-u", "new-session", "-d", "-x", width, "-y", height, command)
    deadline = time.monotonic() + LIMIT_S  # noqa: TID251 - it watches a live program
    try:
        while not re.search(SHOWN, screen := tmux("capture-pane", "-p")):
            if time.monotonic() > deadline:  # noqa: TID251
                raise SystemExit(f"no match of '{SHOWN}' within {LIMIT_S:g} s in:\n{screen}")
            time.sleep(0.1)  # noqa: TID251
        return "\n".join(line.rstrip() for line in screen.rstrip("\n").split("\n"))
    finally:
        tmux("kill-server")


def put(name: str, text: str) -> None:
    """Write a screen into its place of the page."""
    page = PAGE.read_text(encoding="utf-8")
    place = re.compile(rf"(<!-- screen: {name} -->\n).*?(<!-- end -->)", re.DOTALL)
    if not place.search(page):
        raise SystemExit(f"{PAGE.name} has no place for the screen '{name}'")
    block = f"```text\n{text}\n```\n"
    page = place.sub(lambda match: match[1] + block + match[2], page)
    PAGE.write_text(page, encoding="utf-8")


async def draw() -> None:
    """Save a picture of the view, in colours."""
    from bt_mission.ros.discovery import ExecutiveDirectory  # noqa: PLC0415 - after the environment is set
    from bt_mission.views.terminal.marks import SIGNS  # noqa: PLC0415
    from bt_mission.views.tui.app import WatchApp  # noqa: PLC0415

    with ExecutiveDirectory() as observer:
        app = WatchApp(observer, SIGNS)
        async with app.run_test(size=(130, 38)) as pilot:
            deadline = time.monotonic() + LIMIT_S  # noqa: TID251
            while not (
                app.outlook.mission.elapsed_ns > 35e9 and "drive" in app.outlook.running_path
            ):
                if time.monotonic() > deadline:  # noqa: TID251
                    raise SystemExit("the mission makes no progress")
                await pilot.pause(0.1)
            save(app.export_screenshot(title="bt-mission watch"), PICTURE)


def save(picture: str, path: Path) -> None:
    """Write a picture of Rich without fonts of other sites: readers have a similar font."""
    picture = re.sub(r"@font-face \{.*?\}\s*", "", picture, flags=re.DOTALL)
    path.write_text(picture, encoding="utf-8")


def main() -> None:
    """Take the screen and the picture, or only what is named."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", choices=[SCREEN, "picture", []])
    options = parser.parse_args()
    if shutil.which("tmux") is None:
        raise SystemExit("tmux is not installed")
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    os.environ.setdefault("ROS_DOMAIN_ID", "97")  # not the default domain
    for name in options.names or [SCREEN, "picture"]:
        print(name, flush=True)
        with mission():
            if name == "picture":
                asyncio.run(draw())
            else:
                put(name, captured())


if __name__ == "__main__":
    main()
