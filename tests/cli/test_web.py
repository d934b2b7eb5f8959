"""The options of ``--web``, and their commands, as processes of their own."""

from __future__ import annotations

import argparse
import re
import signal
import subprocess
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from bt_mission import read_recording
from bt_mission.cli import run_shown, web
from bt_mission.cli.main import make_parser
from bt_mission.testing.live_graph import command
from bt_mission.views.web.live import LiveMission
from tests.support.command_line import CommandLine
from tests.support.processes import PATIENCE_S, ended, read_until, started
from tests.support.project import ROOT
from tests.support.recordings import recording

if TYPE_CHECKING:
    from bt_mission.views.web.server import WebServer

pytestmark = pytest.mark.skipif(
    not all(find_spec(name) for name in web.NEEDED), reason="the extra 'web' is not installed"
)

EVERYWHERE = "0.0.0.0"  # noqa: S104 - that it is warned of is what is tested
WAIT = "mission: wait\nworld: empty_arena\ntree:\n  wait: 1\n"
FOREVER = WAIT.replace("wait: 1", "wait: 100000")
FLEET = "fleet: waiting\nrobots:\n  one:\n    mission: wait.yaml\n"
TWO_ROBOTS = str(ROOT / "missions" / "fleets" / "two_wanderers.fleet.yaml")
SINCE_1970_NS = 10**18
"""The clock of this machine is beyond, that of a simulation is not."""
WEB = ("--web", "--port", "0")


def options(*words: str) -> argparse.Namespace:
    """Options as a command has them."""
    return make_parser().parse_args(["replay", "x.mcap", *words])


def link_in(text: str) -> str:
    """The link to a page that a command has printed."""
    match = re.search(r"in a browser: (http://127\.0\.0\.1:\d+/[\w-]{22}/)", text)
    assert match, text
    return match[1]


def page_of(link: str) -> str:
    """What stands at a link."""
    with urllib.request.urlopen(link, timeout=30) as page:  # noqa: S310 - it is one of ours
        return str(page.read(), "utf-8")


@pytest.mark.parametrize("line", ["replay x.mcap --web", "run m.yaml --web"])
def test_without_the_extra_it_says_what_to_install(
    cli: CommandLine, monkeypatch: pytest.MonkeyPatch, line: str
) -> None:
    """Before anything moves."""
    monkeypatch.setattr(web, "find_spec", lambda name: None)
    cli.write("m.yaml", FOREVER)
    needs = "needs starlette and uvicorn and websockets: pip install 'bt-mission[web]'"
    assert f"{line.rsplit(maxsplit=1)[-1]} {needs}" in cli.refused(line)


def test_another_process_gets_the_same_options() -> None:
    """That it is started with, too."""
    words = ["--web", "--port=0", "--open", "--read-only", "--host=127.0.0.1"]
    assert web.web_arguments(options(*words)) == words
    assert web.web_arguments(options("--web")) == ["--web"]


def test_a_page_for_other_machines_is_warned_of(capsys: pytest.CaptureFixture[str]) -> None:
    """With what whoever has the link can do, and a way that needs no warning."""
    from tests.support.watched import ScriptedGraph  # noqa: PLC0415 - needs the extra

    shown = LiveMission(ScriptedGraph())
    with web.web_server(options(*WEB, "--host", EVERYWHERE), shown) as server:
        reported = capsys.readouterr().err
        assert "--host 0.0.0.0: other machines can reach the page." in reported
        assert "watch and stop the mission" in reported
        assert f"ssh -L {server.port}:127.0.0.1:{server.port}" in reported
    with web.web_server(options(*WEB), shown):
        assert "other machines" not in capsys.readouterr().err


@pytest.mark.parametrize("name", ["wait.yaml", "wait.fleet.yaml"])
def test_ctrl_c_while_it_starts_is_heard_by_the_first_step(
    name: str, cli: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its mission does not run first, with nobody to stop it."""
    cli.write("wait.yaml", WAIT)
    cli.write("wait.fleet.yaml", FLEET)

    @contextmanager
    def interrupted(
        options: argparse.Namespace, shown: LiveMission, *, is_fast: bool
    ) -> Iterator[WebServer]:
        signal.raise_signal(signal.SIGINT)
        with web.web_server(options, shown, is_fast=is_fast) as server:
            yield server

    monkeypatch.setattr(run_shown, "web_server", interrupted)
    assert "interrupted by Ctrl-C" in cli(f"run {name} --web --port 0", 130)


@pytest.mark.process
def test_a_run_is_shown_until_ctrl_c_and_then_told(cli: CommandLine) -> None:
    """Its page stays when it has ended; its files are whole by then, and the code is its own."""
    cli.write("wait.yaml", WAIT)
    files = ("--record", "wait.mcap", "--report", "wait.html")
    with started("run", "wait.yaml", *WEB, "--plain", *files) as process:
        seen = read_until(process, "the page stays until Ctrl-C")
        assert read_recording("wait.mcap").why_cut == ""
        assert Path("wait.html").exists()
        assert '<script type="module" src="app.js">' in page_of(link_in(seen))
        assert "success" in ended(process, 0, signal.SIGINT)
    assert "Traceback" not in seen


@pytest.mark.thorough
@pytest.mark.process
def test_ctrl_c_while_it_runs_ends_the_mission_in_good_order(cli: CommandLine) -> None:
    """And the page with it."""
    with started("run", cli.write("wait.yaml", FOREVER), *WEB, "--plain") as process:
        link_in(read_until(process, "in a browser"))
        read_until(process, "wait")
        assert "interrupted by Ctrl-C" in ended(process, 130, signal.SIGINT)


@pytest.mark.thorough
@pytest.mark.process
def test_a_recording_is_shown_until_ctrl_c() -> None:
    """Its page is served as that of a mission."""
    with started("replay", str(recording()), *WEB) as process:
        link = link_in(read_until(process, "in a browser"))
        assert "requestAnimationFrame" in page_of(f"{link}app.js")
        ended(process, 130, signal.SIGINT)


@pytest.mark.process
def test_nobody_to_watch_ends_with_a_word_in_time() -> None:
    """As without a page."""
    with started("watch", "nobody", *WEB, "--wait", "1", ROS_DOMAIN_ID="87") as process:
        out, _ = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 1
    assert "/nobody/bt_mission was not found" in out


@pytest.mark.process
def test_it_ends_with_the_process_that_has_started_it() -> None:
    """Even where that was killed: its standard input ends."""
    arguments = [*command("watch", "robot", *WEB), "--until-input-ends"]
    with subprocess.Popen(
        arguments, stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdin is not None
        assert process.stderr is not None
        while "in a browser" not in process.stderr.readline():
            pass
        process.stdin.close()
        assert process.wait(timeout=PATIENCE_S) == 0
