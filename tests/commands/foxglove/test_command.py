"""The option ``--foxglove`` of commands that show a mission, as processes of their own."""

from __future__ import annotations

import re
import signal
import socket
import subprocess
from importlib.util import find_spec
from pathlib import Path

import pytest

from bt_mission.cli import web
from bt_mission.commands.foxglove import LAYOUT
from bt_mission.testing.live_graph import LOCAL, command
from tests.support.command_line import CommandLine
from tests.support.processes import PATIENCE_S, ended, read_until, started
from tests.support.project import ROOT
from tests.support.thorough import sample

if not all(find_spec(name) for name in web.NEEDED):
    pytest.skip("the extra 'web' is not installed", allow_module_level=True)

from tests.commands.foxglove.client import FoxgloveClient

FOREVER = "mission: wait\nworld: empty_arena\ntree:\n  wait: 100000\n"
TWO_ROBOTS = str(ROOT / "missions" / "fleets" / "two_wanderers.fleet.yaml")
SINCE_1970_NS = 10**18
"""The clock of this machine is beyond, that of a simulation is not."""
FOXGLOVE = ("--foxglove", "--foxglove-port=0")


def link_in(text: str) -> str:
    """The address that a command has printed."""
    match = re.search(r"in Foxglove: (ws://127\.0\.0\.1:\d+), layout (\S+)", text)
    assert match, text
    assert Path(match[2]) == LAYOUT
    return match[1]


def test_without_the_extra_it_says_what_to_install(
    cli: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Before anything moves."""
    monkeypatch.setattr(web, "find_spec", lambda name: None)
    cli.write("m.yaml", FOREVER)
    needs = "needs starlette and uvicorn and websockets: pip install 'bt-mission[web]'"
    assert f"--foxglove {needs}" in cli.refused("run m.yaml --foxglove")


@pytest.mark.parametrize("line", ["run m.yaml", "serve", "watch"])
def test_a_port_that_is_taken_ends_it_before_anything_moves(cli: CommandLine, line: str) -> None:
    """With what to do."""
    cli.write("m.yaml", FOREVER)
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        cli(f"{line} --foxglove --foxglove-port={port}", 2)
    assert f"--foxglove-port {port}: the port is in use; --foxglove-port " in cli.err


@pytest.mark.thorough
@pytest.mark.process
@pytest.mark.parametrize(
    ("file", "topic"), sample([(TWO_ROBOTS, "/waffle1/odom"), ("m.yaml", "/odom")], every=2)
)
def test_foxglove_sees_a_run_until_it_ends(cli: CommandLine, file: str, topic: str) -> None:
    """On the stage, also a fleet, in real time; Ctrl-C ends the mission in good order."""
    cli.write("m.yaml", FOREVER)
    with started("run", file, *FOXGLOVE, "--plain") as process:
        with FoxgloveClient(link_in(read_until(process, "in Foxglove"))) as client:
            client.wait_for(lambda: topic in client.channels)
            client.subscribe(topic)
            client.wait_for(lambda: client.received[topic])
        assert "interrupted by Ctrl-C" in ended(process, 130, signal.SIGINT)


@pytest.mark.thorough
@pytest.mark.process
def test_foxglove_sees_a_graph_with_its_own_time(cli: CommandLine) -> None:
    """Topics of other processes: here those of a simulation, with the time of its clock."""
    run = ("run", cli.write("m.yaml", FOREVER), "--visible", "--speed=1", "--plain")
    with started(*run, **LOCAL), started("watch", *FOXGLOVE, **LOCAL) as process:
        with FoxgloveClient(link_in(read_until(process, "in Foxglove"))) as client:
            client.wait_for(lambda: client.channels.keys() >= {"/odom", "/bt_mission/tree"})
            client.subscribe("/odom", "/bt_mission/tree")
            client.wait_for(lambda: client.received["/bt_mission/tree"])
            client.wait_for(lambda: any(t < SINCE_1970_NS for t, _ in client.received["/odom"]))
            client.wait_for(lambda: any(t < SINCE_1970_NS for t in client.times))
        ended(process, 130, signal.SIGINT)


@pytest.mark.process
def test_it_ends_with_the_process_that_has_started_it() -> None:
    """Even where that was killed: its standard input ends."""
    arguments = [*command("watch", *FOXGLOVE), "--until-input-ends"]
    with subprocess.Popen(
        arguments, stdin=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdin is not None
        assert process.stderr is not None
        while "in Foxglove" not in process.stderr.readline():
            pass
        process.stdin.close()
        assert process.wait(timeout=PATIENCE_S) == 0


def test_help_names_what_the_option_excludes(
    cli: CommandLine, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of the options that the command has."""
    monkeypatch.setenv("COLUMNS", "200")
    assert "--web, EXECUTIVE, --wait)" in " ".join(cli("watch --help").split())
