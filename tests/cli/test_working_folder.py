"""Code of the working folder runs only where a mission names it, whatever the command."""

from __future__ import annotations

import json
import os
import shlex
import signal
import subprocess
import sys
from collections.abc import Callable, Mapping
from http.client import HTTPConnection
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

import pytest

from bt_mission.base.commands import ROWS
from bt_mission.base.python_process import python_environment, safe_processes
from bt_mission.commands.agents.permits import new_key
from bt_mission.testing.live_graph import LOCAL
from tests.support.agents import SITE
from tests.support.processes import PATIENCE_S, read_until
from tests.support.thorough import sample

pytestmark = pytest.mark.process

PROGRAM = Path(sys.executable).with_name("bt-mission")
NAMES = ("json", "yaml", "rclpy", "numpy", "mujoco", "pickle", "signal", "socket", "asyncio")
PLANTED = """\
import sys
with open({marks!r}, "a") as marks:
    marks.write(f"{{__name__}} in {{sys.orig_argv}}\\n")
raise ImportError("planted")
"""
MISSION = "mission: m\nworld: empty_arena\ntree: {turn: {angle: 5}, timeout: 20}\n"
LINES: Mapping[str, str] = {
    "run": "run m.yaml --json",
    "watch": "watch --wait 0",
    "revise": "revise nobody m.yaml",
    "edit": "edit . --port 0",
    "check": "check m.yaml",
    "convert": "convert m.yaml",
    "new": "new project",
    "missions": "missions",
    "worlds": "worlds",
    "robots": "robots",
    "tree": "tree m.yaml",
    "schema": "schema",
    "serve": "serve --web --port 0",
    "mcp": "mcp --site site.yaml",
    "approve": "approve --site site.yaml",
    "actions": "actions list",
    "topics": "topics list",
    "services": "services list",
    "sim": "sim --world empty_arena --no-camera",
    "servers": "servers",
    "mapper": "mapper --ros-args --log-level debug",
    "arbiter": "arbiter",
    "replay": "replay run.mcap --once",
    "fork": "fork run.mcap --at 0.2",
    "report": "report run.mcap",
    "verify": "verify run.mcap --require safe.yaml",
    "sweep": "sweep m.yaml --seeds 2 --workers 2",
    "sweep-report": "sweep-report nothing",
    "falsify": "falsify m.yaml --budget 2 --workers 2",
    "reproduce": "reproduce run.mcap -o case",
    "prove": "prove m.yaml",
    "diff": "diff run.mcap run.mcap",
    "explain": "explain BT-203",
    "doctor": "doctor",
    "docs": "docs seeds",
    "completion": "completion bash",
}
"""Each command as it gets far in the folder. Nodes serve until they are interrupted."""

SERVES = {
    "edit": "in a browser: ",
    "serve": "in a browser: ",
    "sim": "empty_arena",
    "servers": "servers",
    "mapper": "DEBUG",
    "arbiter": "arbiter",
}
"""What commands say that end by Ctrl-C only."""


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The recording of a short run."""
    folder = tmp_path_factory.mktemp("recorded")
    (folder / "m.yaml").write_text(MISSION)
    command = [str(PROGRAM), "run", "m.yaml", "--json", "--record", "run.mcap"]
    subprocess.run(command, cwd=folder, check=True, capture_output=True)
    return (folder / "run.mcap").read_bytes()


@pytest.fixture
def marks(tmp_path: Path, recording: bytes) -> Path:
    """A file that planted modules of the folder write to, when one is executed."""
    marks = tmp_path / "marks.txt"
    for name in NAMES:
        (tmp_path / f"{name}.py").write_text(PLANTED.format(marks=str(marks)))
    (tmp_path / "m.yaml").write_text(MISSION)
    (tmp_path / "safe.yaml").write_text("requirements: {slow: always speed < 1}\n")
    (tmp_path / "run.mcap").write_bytes(recording)
    line = new_key(tmp_path / "key.pem", "")
    site = SITE.replace("arena.yaml", "empty_arena")
    (tmp_path / "site.yaml").write_text(f'{site}approvers: ["{line}"]\n')
    return marks


def asks_of_the_page(line: str) -> None:
    """Check, run and prove a mission as the page of the editor does."""
    address = urlsplit(line.rsplit(maxsplit=1)[-1])

    def ask(request: str, **facts: Any) -> Any:
        connection = HTTPConnection(address.netloc)
        connection.request("POST", f"{address.path}api/{request}", json.dumps(facts))
        answer = json.loads(connection.getresponse().read())
        connection.close()
        return answer

    assert "error" not in ask("check", name="m.yaml", page="a", text=MISSION)
    ask("prove", name="m.yaml", text=MISSION)
    ask("run", name="m.yaml", text=MISSION, speed="16")
    while not (proved := ask("proved"))["is_over"]:
        continue
    assert proved["result"]["findings"] is not None, proved
    while (ran := ask("ran"))["state"] == "starting":
        continue
    assert ran["state"] == "served", ran


def calls_of_an_agent(process: subprocess.Popen[str]) -> None:
    """Propose a mission and have it proved, as a client of the protocol does."""
    written, read = process.stdin, process.stdout
    assert written is not None
    assert read is not None

    def send(number: int | None, method: str, **parameters: Any) -> Any:
        message = {"jsonrpc": "2.0", "method": method, "params": parameters}
        written.write(json.dumps(message | ({"id": number} if number else {})) + "\n")
        written.flush()
        while number is not None:
            answer = json.loads(read.readline())
            if answer.get("id") == number:
                return answer["result"]
        return None

    client = {"name": "test", "version": "1"}
    send(1, "initialize", protocolVersion="2025-03-26", capabilities={}, clientInfo=client)
    send(None, "notifications/initialized")
    text = MISSION.replace("world: empty_arena\n", "")
    send(2, "tools/call", name="propose", arguments={"name": "m", "text": text})
    proved = send(3, "tools/call", name="prove", arguments={"name": "m"})
    assert not proved.get("isError"), proved
    written.close()


ACTS: Mapping[str, Callable[[str], None]] = {"edit": asks_of_the_page}


@pytest.mark.parametrize("name", sample([row.name for row in ROWS if row.help], 9, first=5))
def test_no_command_executes_a_module_beside_its_files(
    name: str, tmp_path: Path, marks: Path
) -> None:
    """Not even where an empty entry of `PYTHONPATH` stands for the folder."""
    path = os.pathsep + os.environ.get("PYTHONPATH", "")
    with subprocess.Popen(
        [PROGRAM, *shlex.split(LINES[name])],
        cwd=tmp_path,
        env=os.environ | LOCAL | {"PYTHONPATH": path},
        stdin=subprocess.PIPE if name == "mcp" else subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=None if name == "mcp" else subprocess.STDOUT,
        text=True,
    ) as process:
        output = ""
        try:
            if name == "mcp":
                calls_of_an_agent(process)
            if name in SERVES:
                output = read_until(process, SERVES[name])
                ACTS.get(name, lambda _: None)(output.splitlines()[-1])
                process.send_signal(signal.SIGINT)
            assert process.stdout is not None
            output += process.stdout.read()
            process.wait(PATIENCE_S)
        finally:
            process.kill()
    assert "Traceback" not in output
    assert (marks.read_text() if marks.exists() else "") == "", output


def test_the_folder_is_on_the_path_where_somebody_named_it() -> None:
    """Empty entries are left out, others stay."""
    path = os.pathsep.join(("", "/a", "", "/b"))
    assert python_environment({"PYTHONPATH": path})["PYTHONPATH"] == f"/a{os.pathsep}/b"
    assert "PYTHONPATH" not in python_environment({"PYTHONPATH": os.pathsep})


def test_processes_of_libraries_are_safe_for_a_while(monkeypatch: pytest.MonkeyPatch) -> None:
    """Afterwards the environment is as before, also that of the processes themselves."""
    monkeypatch.delenv("PYTHONSAFEPATH", raising=False)
    before = dict(os.environ)
    with safe_processes() as variables:
        assert os.environ["PYTHONSAFEPATH"] == "1"
        assert variables == {"PYTHONSAFEPATH": ""}
    assert dict(os.environ) == before
