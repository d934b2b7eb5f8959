"""The options of ``--foxglove``, and the commands that have them, as processes of their own."""

from __future__ import annotations

import re
import signal
import socket
import subprocess
from importlib.util import find_spec
from pathlib import Path

import pytest

from bt_mission.cli import web
from bt_mission.cli.main import main
from bt_mission.graph_tools.foxglove import LAYOUT
from bt_mission.testing.live_graph import LOCAL, command
from tests.support.processes import PATIENCE_S, read_until, started
from tests.support.project import ROOT
from tests.support.thorough import sample

needs_foxglove = pytest.mark.skipif(
    not all(find_spec(name) for name in web.NEEDED), reason="the extra 'web' is not installed"
)
FLEET = str(ROOT / "missions" / "fleets" / "two_wanderers.fleet.yaml")
FOREVER = "mission: forever\nworld: empty_arena\ntree: {wait: 100000}\n"
SINCE_1970_NS = 10**18
"""The clock of this machine is beyond, that of a simulation is not."""
ANY_PORT = "--foxglove-port=0"


@pytest.fixture
def mission(tmp_path: Path) -> str:
    """The file of a mission that does not end."""
    path = tmp_path / "forever.yaml"
    path.write_text(FOREVER, encoding="utf-8")
    return str(path)


def link_in(text: str) -> str:
    """The address that a command has printed."""
    match = re.search(r"in Foxglove: (ws://127\.0\.0\.1:\d+), layout (\S+)", text)
    assert match, text
    assert Path(match[2]) == LAYOUT
    return match[1]


def test_without_the_extra_it_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, mission: str, capsys: pytest.CaptureFixture[str]
):
    """Before anything moves."""
    monkeypatch.setattr(web, "find_spec", lambda name: None)
    assert main(["run", mission, "--foxglove"]) == 2
    output = "--foxglove needs starlette and uvicorn and websockets: pip install 'bt-mission[web]'"
    assert output in capsys.readouterr().err


@pytest.mark.parametrize("port", ["x", "-1", "65536"])
def test_a_port_is_a_number_of_one(port: str, mission: str, capsys: pytest.CaptureFixture[str]):
    """The message says which there are."""
    with pytest.raises(SystemExit) as ended:
        main(["run", mission, "--foxglove", "--foxglove-port", port])
    assert ended.value.code == 2
    assert f"expected a port from 0 to 65535, got '{port}'" in capsys.readouterr().err


@needs_foxglove
@pytest.mark.parametrize("words", [("run", "mission"), ("serve",), ("watch",)])
def test_a_port_that_is_taken_ends_it_before_anything_moves(
    words: tuple[str, ...], mission: str, capsys: pytest.CaptureFixture[str]
):
    """With what to do."""
    arguments = [mission if word == "mission" else word for word in words]
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert main([*arguments, "--foxglove", f"--foxglove-port={port}"]) == 2
    output = f"--foxglove-port {port}: the port is in use; --foxglove-port "
    assert output in capsys.readouterr().err


@needs_foxglove
@pytest.mark.process
@pytest.mark.parametrize(
    ("file", "topic"), sample([(FLEET, "/waffle1/odom"), ("", "/odom")], every=2)
)
def test_a_run_is_served_until_it_ends(mission: str, file: str, topic: str):
    """On the stage, also a fleet, in real time; Ctrl-C ends the mission in good order."""
    from tests.support.foxglove_client import FoxgloveClient  # noqa: PLC0415 - needs the extra

    with started("run", file or mission, "--foxglove", ANY_PORT, "--plain") as process:
        link = link_in(read_until(process, "in Foxglove"))
        with FoxgloveClient(link) as client:
            client.wait_for(lambda: topic in client.channels)
            client.subscribe(topic)
            client.wait_for(lambda: client.received[topic])
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 130
    assert "interrupted by Ctrl-C" in out
    assert "Traceback" not in out


@needs_foxglove
@pytest.mark.process
def test_a_graph_is_served_with_its_own_time(mission: str):
    """Topics of other processes: here those of a simulation, with the time of its clock."""
    from tests.support.foxglove_client import FoxgloveClient  # noqa: PLC0415 - needs the extra

    with (
        started("run", mission, "--visible", "--speed=1", "--plain", **LOCAL),
        started("watch", "--foxglove", ANY_PORT, **LOCAL) as process,
    ):
        link = link_in(read_until(process, "in Foxglove"))
        with FoxgloveClient(link) as client:
            client.wait_for(lambda: client.channels.keys() >= {"/odom", "/bt_mission/tree"})
            client.subscribe("/odom", "/bt_mission/tree")
            client.wait_for(lambda: client.received["/bt_mission/tree"])
            client.wait_for(lambda: any(t < SINCE_1970_NS for t, _ in client.received["/odom"]))
            client.wait_for(lambda: any(t < SINCE_1970_NS for t in client.times))
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 130
    assert "Traceback" not in out


@needs_foxglove
@pytest.mark.process
def test_the_server_of_another_process_ends_with_the_one_that_has_started_it():
    """Even where that was killed: its standard input ends."""
    arguments = [*command("watch", "--foxglove", ANY_PORT), "--until-input-ends"]
    with subprocess.Popen(
        arguments, stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdin is not None
        assert process.stderr is not None
        while "in Foxglove" not in process.stderr.readline():
            pass
        process.stdin.close()
        assert process.wait(timeout=PATIENCE_S) == 0
