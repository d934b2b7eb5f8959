"""The options of ``--web``, and the commands that have them, as processes of their own."""

from __future__ import annotations

import argparse
import re
import signal
import subprocess
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from bt_mission import read_recording
from bt_mission.cli import replay, run_shown, web
from bt_mission.cli.main import main, make_parser
from bt_mission.testing.live_graph import command
from bt_mission.views.web.live import LiveMission
from tests.support.processes import PATIENCE_S, read_until, started
from tests.support.recordings import recording, with_facts
from tests.support.report_pages import data_of

if TYPE_CHECKING:
    from bt_mission.views.web.server import WebServer

HAS_WEB = all(find_spec(name) for name in web.NEEDED)
needs_web = pytest.mark.skipif(not HAS_WEB, reason="the extra 'web' is not installed")

EVERYWHERE = "0.0.0.0"  # noqa: S104 - that it is warned of is what is tested

WAIT = """\
mission: wait
world: empty_arena
tree:
  wait: 1
"""


def options(*words: str) -> argparse.Namespace:
    """Options as a command has them."""
    return make_parser().parse_args(["replay", "x.mcap", *words])


def link_in(text: str) -> str:
    """The link that a command has printed."""
    match = re.search(r"in a browser: (http://127\.0\.0\.1:\d+/[\w-]{22}/)", text)
    assert match, text
    return match[1]


def test_without_the_extra_it_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    """Before anything moves."""
    monkeypatch.setattr(web, "find_spec", lambda name: None)
    assert main(["replay", "x.mcap", "--web"]) == 2
    output = "--web needs starlette and uvicorn and websockets: pip install 'bt-mission[web]'"
    assert output in capsys.readouterr().err


@pytest.mark.parametrize("port", ["-1", "65536", "http", "8080.0"])
def test_a_port_is_a_number_of_sixteen_bits(port: str, capsys: pytest.CaptureFixture[str]):
    """What else is given is refused with what is expected."""
    with pytest.raises(SystemExit):
        options("--web", "--port", port)
    assert f"expected a port from 0 to 65535, got '{port}'" in capsys.readouterr().err


def test_another_process_gets_the_same_options():
    """That it is started with, too."""
    words = ["--web", "--port=0", "--open", "--read-only", "--host=127.0.0.1"]
    assert web.web_arguments(options(*words)) == words
    assert web.web_arguments(options("--web")) == ["--web"]


def page_of(link: str) -> str:
    """What stands at a link."""
    with urllib.request.urlopen(link, timeout=30) as page:  # noqa: S310 - it is one of ours
        return str(page.read(), "utf-8")


@needs_web
def test_a_page_for_other_machines_is_warned_of(capsys: pytest.CaptureFixture[str]):
    """With what whoever has the link can do, and a way that needs no warning."""
    from bt_mission.views.web.live import LiveMission  # noqa: PLC0415 - needs the extra
    from tests.support.watched import ScriptedGraph  # noqa: PLC0415 - as above

    shown = LiveMission(ScriptedGraph())
    with web.web_server(options("--web", "--port", "0", "--host", EVERYWHERE), shown) as server:
        reported = capsys.readouterr().err
        assert "--host 0.0.0.0: other machines can reach the page." in reported
        assert "watch and stop the mission" in reported
        assert f"ssh -L {server.port}:127.0.0.1:{server.port}" in reported
    with web.web_server(options("--web", "--port", "0"), shown):
        assert "other machines" not in capsys.readouterr().err


@needs_web
@needs_web
def test_forks_are_offered_with_the_file_as_it_was_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """A run on a graph, which cannot run again, says so; who may only look is offered none."""
    pages: list[str] = []

    class Server:
        async def serve(self, until: Callable[[], bool]) -> None:
            """There are no viewers."""

    @contextmanager
    def server(_: argparse.Namespace, page: str) -> Iterator[Server]:
        pages.append(page)
        yield Server()

    monkeypatch.setattr(replay, "page_server", server)
    monkeypatch.chdir(tmp_path)
    Path("my run.mcap").write_bytes(recording().read_bytes())
    with_facts(Path("live.mcap"), {"world": None})
    for words in (["my run.mcap"], ["live.mcap"], ["my run.mcap", "--read-only"]):
        assert main(["replay", *words, "--web"]) == 130
    offered, refused, none = (next(iter(data_of(page).values())).get("fork", {}) for page in pages)
    assert offered == {"command": "bt-mission fork 'my run.mcap' --at", "refusal": ""}
    assert "on a running graph" in refused["refusal"]
    assert none == {}


@needs_web
@pytest.mark.process
def test_a_run_is_shown_until_ctrl_c_and_then_told(tmp_path: Path):
    """Its page stays when it has ended; its files are whole by then, and the code is its own."""
    mission = tmp_path / "wait.yaml"
    mission.write_text(WAIT, encoding="utf-8")
    kept, page = tmp_path / "wait.mcap", tmp_path / "wait.html"
    files = ("--record", str(kept), "--report", str(page))
    with started("run", str(mission), "--web", "--port", "0", "--plain", *files) as process:
        seen = read_until(process, "the page stays until Ctrl-C")
        assert read_recording(kept).why_cut == ""
        assert page.exists()
        assert '<script type="module" src="app.js">' in page_of(link_in(seen))
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0
    assert "success" in out
    assert "Traceback" not in seen + out


@needs_web
@pytest.mark.process
def test_ctrl_c_while_it_runs_ends_the_mission_in_good_order(tmp_path: Path):
    """And the page with it."""
    mission = tmp_path / "wait.yaml"
    mission.write_text(WAIT.replace("wait: 1", "wait: 1000"), encoding="utf-8")
    with started("run", str(mission), "--web", "--port", "0", "--plain") as process:
        link_in(read_until(process, "in a browser"))
        read_until(process, "wait")
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 130
    assert "interrupted by Ctrl-C" in out
    assert "Traceback" not in out


FLEET = """\
fleet: waiting
robots:
  one:
    mission: wait.yaml
"""


@needs_web
@pytest.mark.parametrize("name", ["wait.yaml", "wait.fleet.yaml"])
def test_ctrl_c_while_it_starts_is_heard_by_the_first_step(
    name: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
):
    """Its mission does not run first, with nobody to stop it."""
    (tmp_path / "wait.yaml").write_text(WAIT, encoding="utf-8")
    (tmp_path / "wait.fleet.yaml").write_text(FLEET, encoding="utf-8")

    @contextmanager
    def interrupted(
        options: argparse.Namespace, shown: LiveMission, *, is_fast: bool
    ) -> Iterator[WebServer]:
        signal.raise_signal(signal.SIGINT)
        with web.web_server(options, shown, is_fast=is_fast) as server:
            yield server

    monkeypatch.setattr(run_shown, "web_server", interrupted)
    assert main(["run", str(tmp_path / name), "--web", "--port", "0"]) == 130
    assert "interrupted by Ctrl-C" in capsys.readouterr().out


@needs_web
@pytest.mark.process
def test_a_recording_is_shown_until_ctrl_c():
    """Its page is served as that of a mission."""
    with started("replay", str(recording()), "--web", "--port", "0") as process:
        link = link_in(read_until(process, "in a browser"))
        assert "requestAnimationFrame" in page_of(f"{link}app.js")
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 130
    assert "Traceback" not in out


@needs_web
@pytest.mark.process
def test_nobody_to_watch_ends_with_a_word_in_time():
    """As without a page."""
    arguments = ("watch", "nobody", "--web", "--port", "0", "--wait", "1")
    with started(*arguments, ROS_DOMAIN_ID="87") as process:
        out, _ = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 1
    assert "/nobody/bt_mission was not found" in out


@needs_web
@pytest.mark.process
def test_the_page_of_another_process_ends_with_the_one_that_has_started_it():
    """Even where that was killed: its standard input ends."""
    arguments = [*command("watch", "robot", "--web", "--port", "0"), "--until-input-ends"]
    with subprocess.Popen(
        arguments, stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdin is not None
        assert process.stderr is not None
        while "in a browser" not in process.stderr.readline():
            pass
        process.stdin.close()
        assert process.wait(timeout=PATIENCE_S) == 0
