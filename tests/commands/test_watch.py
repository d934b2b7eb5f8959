"""``bt-mission watch``: which executive it takes; as a process beside that of the mission."""

from __future__ import annotations

import argparse
import json
import os
import pty
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from bt_mission.base import wall_clock
from bt_mission.cli.executives import SAY_S, look_for
from bt_mission.executive.events.source import ListedExecutive
from bt_mission.testing.live_graph import LOCAL
from tests.support.processes import PATIENCE_S, read_until, started

DRIVE = """\
mission: drive
world: empty_arena
tree:
  repeat: {count: 1000}
  do:
    turn: {angle: 90}
    name: turn round
    timeout: 100
"""


@pytest.fixture(scope="module")
def mission(tmp_path_factory: pytest.TempPathFactory) -> Iterator[subprocess.Popen[str]]:
    """A mission that runs for long, and is visible to other processes."""
    path = tmp_path_factory.mktemp("watched") / "drive.yaml"
    path.write_text(DRIVE, encoding="utf-8")
    arguments = ("run", str(path), "--visible", "--speed", "1", "--plain")
    with started(*arguments, **LOCAL) as process:
        read_until(process, "▶ turn round")
        yield process


@pytest.mark.process
def test_the_tree_is_printed_once(mission: subprocess.Popen[str]):
    """With all statuses, though the watcher has come late."""
    with started("watch", "--once", "--wait", "60", **LOCAL) as watch:
        out, _ = watch.communicate(timeout=PATIENCE_S)
    assert watch.returncode == 0
    lines = out.splitlines()
    assert lines[0].startswith("drive   ")
    assert lines[0].endswith("running")
    assert any("turn round" in line for line in lines)


@pytest.mark.process
def test_what_happens_is_streamed_until_the_reader_leaves(mission: subprocess.Popen[str]):
    """One object a line; a pipe that closes is no traceback."""
    with started("watch", "--json", "--wait", "60", **LOCAL) as watch:
        assert watch.stdout is not None
        events = [json.loads(watch.stdout.readline()) for _ in range(5)]
        watch.stdout.close()
        assert watch.wait(timeout=PATIENCE_S) == 130
    assert [event["event"] for event in events if event["event"] == "start"] == ["start"]


@pytest.mark.process
def test_a_picture_is_drawn_on_a_terminal(mission: subprocess.Popen[str]):
    """Until somebody presses q; the terminal is then as it was."""
    seen, code = on_terminal("xterm-256color", "turn round", b"q")
    assert code == 0
    assert "Traceback" not in seen
    assert "\x1b[?1049h" in seen
    assert "\x1b[?1049l" in seen


@pytest.mark.thorough
@pytest.mark.process
def test_a_terminal_that_cannot_be_drawn_on_has_plain_lines(mission: subprocess.Popen[str]):
    """With a word."""
    seen, code = on_terminal("dumb", "▶ turn round", b"\x03")
    assert code == 130
    assert "TERM=dumb: this terminal cannot show the full-screen view; printing plain lines" in seen
    assert "\x1b" not in seen


@pytest.mark.process
def test_nobody_there_is_told(tmp_path: Path):
    """With what was looked for; code 1 when waiting was limited."""
    apart = {**LOCAL, "ROS_DOMAIN_ID": str(int(os.environ["ROS_DOMAIN_ID"]) % 100 + 1)}
    with started("watch", "robot7", "--once", "--wait", "1", **apart) as watch:
        out, _ = watch.communicate(timeout=PATIENCE_S)
    assert watch.returncode == 1
    assert "/robot7/bt_mission was not found (ROS domain" in out


# In a session of its own, the first terminal that a process opens is the one whose Ctrl-C it gets.
ON_TERMINAL = """\
import os, sys
os.open(os.ttyname(0), os.O_RDWR)
os.execv(sys.executable, [sys.executable, "-m", "bt_mission", "watch", "--wait", "60"])
"""


def on_terminal(term: str, until: str, keys: bytes) -> tuple[str, int]:
    """Watch on a terminal of that kind, press keys when something is seen; all output and code."""
    terminal, theirs = pty.openpty()
    watch = subprocess.Popen(
        [sys.executable, "-c", ON_TERMINAL],
        env=os.environ | LOCAL | {"TERM": term, "COLUMNS": "80", "LINES": "24"},
        stdin=theirs,
        stdout=theirs,
        stderr=theirs,
        start_new_session=True,
    )
    os.close(theirs)
    try:
        seen = read_terminal(terminal, until.encode())
        os.write(terminal, keys)
        seen += read_terminal(terminal, b"")
        return seen.decode(), watch.wait(timeout=PATIENCE_S)
    finally:
        watch.kill()
        watch.wait()
        os.close(terminal)


def read_terminal(terminal: int, until: bytes) -> bytes:
    """What is written until something is seen; without it, until nobody writes any more."""
    seen = b""
    while not (until and until in seen):
        try:
            seen += os.read(terminal, 65536)
        except OSError:  # it has no other end any more
            break
    return seen


# ---- which executive, without processes --------------------------------------------------------


class Watched:
    """A graph in which executives come up late, on its own clock."""

    where = "a test"

    def __init__(self, come_s: float) -> None:
        self.now_s = 0.0
        self.attached = ""
        self._come_s = come_s

    def serve(self, wall_s: float) -> None:
        """Let time pass."""
        self.now_s += wall_s

    def is_over(self) -> bool:
        """All come at once."""
        return self.now_s > self._come_s

    def find(self) -> tuple[ListedExecutive, ...]:
        """All at once."""
        names = ("/r1/bt_mission", "/r2/bt_mission") if self.now_s > self._come_s else ()
        return tuple(ListedExecutive(name) for name in names)

    def attach(self, name: str, **_: Any) -> Any:
        """Remember who is watched; no mission is known."""
        self.attached = name

        def close() -> None:
            self.attached = ""

        return SimpleNamespace(take=lambda **_: SimpleNamespace(messages=()), close=close)


def looked(
    monkeypatch: pytest.MonkeyPatch, come_s: float, name: str, wait_s: float | None = None
) -> str:
    """Look for an executive; gives whom it found."""
    graph: Any = Watched(come_s)

    class Since:
        def __init__(self) -> None:
            self._start_s = graph.now_s

        @property
        def elapsed_s(self) -> float:
            return float(graph.now_s - self._start_s)

    monkeypatch.setattr(wall_clock, "Stopwatch", Since)
    look_for(graph, argparse.Namespace(executive=name, wait=wait_s))
    return str(graph.attached)


@pytest.mark.thorough
def test_who_comes_up_just_then_is_not_said_to_be_absent(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The list of those that are there would name it."""
    assert looked(monkeypatch, 0.9 * SAY_S, "/r2") == "/r2/bt_mission"
    assert capsys.readouterr().err == ""


@pytest.mark.thorough
def test_who_is_there_when_the_time_is_up_is_taken(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Also where nobody had come up before."""
    assert looked(monkeypatch, 0.9 * SAY_S, "/r2", SAY_S) == "/r2/bt_mission"
    assert looked(monkeypatch, 0.9 * SAY_S, "/r3", SAY_S) == ""
    assert "no executive /r3/bt_mission (a test); available:" in capsys.readouterr().err
