"""A process that has loaded what a run needs, and waits for the words of one command.

The editor keeps one: ``python -m bt_mission.cli.preloaded``. Loading takes most of the time until a
run is on its page. The words are a JSON list on one line of the standard input. The end of the
input ends the process.
"""

from __future__ import annotations

import json
import os
import runpy
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

SMALL = "mission: small\ntree: {wait: 0.1}\n"
"""A mission for a first run, which loads and compiles what every run uses."""


def main() -> None:
    """Get ready, then run a command, and leave with its exit code."""
    with _unheard():
        _load()
    words = sys.stdin.readline()
    if words:
        sys.argv[1:] = json.loads(words)
        runpy.run_module("bt_mission", run_name="__main__", alter_sys=True)


def _load() -> None:
    from action_servers.core.action import action
    from action_servers.robot_io.messages import generated_type
    from bt_mission.base.actions import declared
    from bt_mission.base.output import write_file
    from bt_mission.cli import main as run
    from bt_mission.views.html.pages import render
    from bt_mission.views.web.live import LiveMission
    from bt_mission.views.web.server import WebServer, page_files

    _ = LiveMission, WebServer
    for name in declared():
        generated_type(action(name).type)
    page_files()
    render("views/web/page/index.html")
    with TemporaryDirectory() as folder:
        mission = Path(folder) / "small.yaml"
        write_file(mission, SMALL)
        run(["run", str(mission), "--json", f"--record={folder}/small.mcap"])


@contextmanager
def _unheard() -> Iterator[None]:
    """Discard what is written to both outputs."""
    streams = (sys.stdout, sys.stderr)
    kept = [os.dup(stream.fileno()) for stream in streams]
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in streams:
        os.dup2(nowhere, stream.fileno())
    try:
        yield
    finally:
        for stream, before in zip(streams, kept, strict=True):
            stream.flush()
            os.dup2(before, stream.fileno())
            os.close(before)
        os.close(nowhere)


if __name__ == "__main__":
    main()
