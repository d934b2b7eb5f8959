"""Takes the screens of docs/reference/terminal.md: real missions, watched or replayed in tmux.

In the page, each screen stands between `<!-- screen: NAME -->` and the next `<!-- end -->`; what is
between is written anew. The picture of the README is taken of the same view by Textual, as SVG.

Run it as: python tools/capture_screens.py [NAME ...]     (tmux is needed; it takes some minutes)
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
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).resolve().parent.parent
PAGE = ROOT / "docs" / "reference" / "terminal.md"
PICTURE = ROOT / "docs" / "images" / "watch.svg"
PROGRAM = [sys.executable, "-m", "bt_mission"]
TMUX = ["tmux", "-L", f"bt_mission_screens_{os.getpid()}"]
LIMIT_S = 180.0
TURNING = r"▶ turn away .*\n(.*\n)*.*✓ turn away"
UTF_8 = {"LC_ALL": "C.UTF-8"}
ASCII = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}


@dataclass(frozen=True)
class Screen:
    """One screen of the page.

    :param mission: what `bt-mission run` is given.
    :param watch: what `bt-mission watch` is given.
    :param replay: what `bt-mission replay` is given besides a recording of the mission; None
        watches it as it runs.
    :param until: is waited for before keys are pressed, and again before the screen is taken.
    :param keys: as tmux names them; each waits for the text beside it.
    """

    mission: str
    size: tuple[int, int]
    until: str
    keys: tuple[tuple[str, str], ...] = ()
    watch: str = ""
    replay: str | None = None
    locale: dict[str, str] | None = None


EXPLORE, PATROL = "missions/explore.yaml --set legs=100", "missions/patrol.yaml"
EXPLORE_SHORT = "missions/explore.yaml"
TYPED = tuple(
    (key, rf"\n{text}\s*$")
    for key, text in zip("21.4", ("2", "21", r"21\.", r"21\.4"), strict=True)
)
LATER = r"repeat .* 3 of 100[^$]*▶ drive .*[█#].* of 2"
SCREENS = {
    "80x24": Screen(EXPLORE, (80, 24), LATER),
    "140x45": Screen(EXPLORE, (140, 45), LATER),
    "paused": Screen(
        EXPLORE,
        (80, 24),
        LATER,
        (
            ("/", "search"),
            ("turn", "»"),
            ("Enter", "b break"),
            ("b", "●"),
            ("f", "breakpoint at 'turn away'"),
        ),
    ),
    "map": Screen(
        PATROL,
        (80, 24),
        "current_waypoint 2",
        (("Tab", "goals"), ("Tab", "variables"), ("Tab", "map"), ("z", "^.*\n.*\n─ map")),
    ),
    "ascii": Screen(EXPLORE, (60, 16), LATER.replace("▶", ">"), locale=ASCII),
    "narrow": Screen(EXPLORE, (20, 10), r"drive [3-9]\d%"),
    "help": Screen(EXPLORE, (80, 24), "▶", (("?", "this help"),)),
    "replay": Screen(
        EXPLORE_SHORT,
        (80, 24),
        "▶",
        (("p", "paused"), ("t", "seconds"), *TYPED, ("Enter", r"21\.40")),
        replay="",
    ),
    "replay help": Screen(EXPLORE_SHORT, (80, 24), "▶", (("?", "this help"),), replay=""),
}


# ---- processes -------------------------------------------------------------------------------


@contextmanager
def mission(arguments: str) -> Iterator[None]:
    """A mission on the stage, in real time, that others of this machine may look on at."""
    command = [*PROGRAM, "run", *shlex.split(arguments), "--visible", "--speed", "1", "--plain"]
    process = subprocess.Popen(  # noqa: S603 - our own program
        command, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
    )
    try:
        yield
    finally:
        process.terminate()
        process.wait()


def tmux(*arguments: str) -> str:
    """Run tmux; gives what it prints."""
    done = subprocess.run(  # noqa: S603 - tmux, with what stands here
        [*TMUX, *arguments], check=True, capture_output=True, text=True
    )
    return done.stdout


def wait_for(pattern: str, look: Callable[[], str]) -> str:
    """Look until a pattern is found; gives what was seen then."""
    deadline = time.monotonic() + LIMIT_S  # noqa: TID251 - it watches a live program
    while not re.search(pattern, seen := look()):
        if time.monotonic() > deadline:  # noqa: TID251
            raise SystemExit(f"'{pattern}' was not seen within {LIMIT_S:g} s in:\n{seen}")
        time.sleep(0.1)  # noqa: TID251
    return seen


def recorded(arguments: str, path: Path) -> None:
    """Record a mission on the stage."""
    subprocess.run(  # noqa: S603 - our own program
        [*PROGRAM, "run", *shlex.split(arguments), "--record", str(path), "--json"],
        check=True,
        cwd=ROOT,
        stdout=subprocess.DEVNULL,
    )


def captured(screen: Screen, arguments: list[str]) -> str:
    """What stands on a terminal of that size.

    :param arguments: what `bt-mission` is given.
    """
    width, height = screen.size
    # A terminal has no variables of ours but those that are put into the command.
    variables = {"TERM": "screen-256color", **(screen.locale or UTF_8)} | {
        name: value for name, value in os.environ.items() if name.startswith(("ROS_", "PYTHONPATH"))
    }
    settings = [f"{name}={value}" for name, value in variables.items()]
    command = ["env", *settings, *PROGRAM, *arguments]
    utf_8 = [] if screen.locale is ASCII else ["-u"]
    subprocess.run(  # noqa: S603
        [
            *TMUX,
            *utf_8,
            "new-session",
            "-d",
            "-x",
            str(width),
            "-y",
            str(height),
            shlex.join(command),
        ],
        check=True,
        cwd=ROOT,
    )
    try:

        def look() -> str:
            return tmux("capture-pane", "-p")

        seen = wait_for(screen.until, look)
        for key, then in screen.keys:
            tmux("send-keys", key)
            seen = wait_for(then, look)
        return "\n".join(line.rstrip() for line in seen.rstrip("\n").split("\n"))
    finally:
        tmux("kill-server")


def taken(screen: Screen) -> str:
    """A screen of a mission that runs, or of its recording."""
    if screen.replay is None:
        with mission(screen.mission):
            return captured(screen, ["watch", *shlex.split(screen.watch)])
    with TemporaryDirectory() as folder:
        path = Path(folder) / "explore.mcap"
        recorded(screen.mission, path)
        return captured(screen, ["replay", str(path), *shlex.split(screen.replay)])


# ---- what they are for -----------------------------------------------------------------------


def put(name: str, text: str) -> None:
    """Write a screen into its place of the page."""
    page = PAGE.read_text(encoding="utf-8")
    place = re.compile(rf"(<!-- screen: {name} -->\n).*?(<!-- end -->)", re.DOTALL)
    if not place.search(page):
        raise SystemExit(f"{PAGE.name} has no place for the screen '{name}'")
    shown = f"```text\n{text}\n```\n"
    page = place.sub(lambda match: match[1] + shown + match[2], page)
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
                    raise SystemExit("the mission does not get on")
                await pilot.pause(0.1)
            picture = app.export_screenshot(title="bt-mission watch")
            # Fonts that would be fetched from elsewhere: whoever looks has one of the kind.
            picture = re.sub(r"@font-face \{.*?\}\s*", "", picture, flags=re.DOTALL)
            PICTURE.write_text(picture, encoding="utf-8")


def main() -> None:
    """Take all screens, or those that are named."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", choices=[*SCREENS, "picture", []])
    options = parser.parse_args()
    if shutil.which("tmux") is None:
        raise SystemExit("tmux is not installed")
    os.environ["ROS_AUTOMATIC_DISCOVERY_RANGE"] = "LOCALHOST"
    os.environ.setdefault("ROS_DOMAIN_ID", "97")  # apart from what else runs here
    for name in options.names or [*SCREENS, "picture"]:
        print(name, flush=True)
        if name == "picture":
            with mission(EXPLORE):
                asyncio.run(draw())
        else:
            put(name, taken(SCREENS[name]))


if __name__ == "__main__":
    main()
