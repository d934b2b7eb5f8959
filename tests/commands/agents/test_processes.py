"""`bt-mission mcp` as a process: its output, and signals."""

from __future__ import annotations

import json
import os
import signal
import subprocess
from pathlib import Path
from typing import Any

import pytest

from bt_mission.testing.live_graph import LOCAL, command
from tests.support.processes import PATIENCE_S, printed_beside_libraries
from tests.support.thorough import sample

pytestmark = pytest.mark.process

SITE = """\
site: lab
robot: burger
world: empty_arena
requirements: {is slow: always speed < 0.3}
approvers: ["AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA="]
"""


@pytest.fixture
def site(tmp_path: Path) -> str:
    """The file of a site."""
    path = tmp_path / "site.yaml"
    path.write_text(SITE, encoding="utf-8")
    return str(path)


def test_what_libraries_print_is_not_in_the_output(site: str) -> None:
    """Fast DDS prints errors to standard output."""
    assert printed_beside_libraries("mcp", "--site", site) == ""


@pytest.mark.thorough
@pytest.mark.parametrize("number", sample([signal.SIGTERM, signal.SIGINT], 2))
def test_a_signal_during_the_job_of_an_agent_leaves_no_files(
    site: str, tmp_path: Path, number: signal.Signals
) -> None:
    """The job ends first, with its folder."""
    with subprocess.Popen(
        command("mcp", "--site", site),
        env=os.environ | LOCAL,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    ) as process:
        written, read = process.stdin, process.stdout
        assert written is not None
        assert read is not None

        def send(call: int | None, method: str, **params: Any) -> None:
            message = {"jsonrpc": "2.0", "method": method, "params": params}
            print(json.dumps(message | ({"id": call} if call else {})), file=written, flush=True)

        def ask(call: int, tool: str, **arguments: Any) -> Any:
            send(call, "tools/call", name=tool, arguments=arguments)
            answers = (json.loads(line) for line in read)
            return next(each for each in answers if each.get("id") == call)["result"]

        client = {"name": "test", "version": "1"}
        send(1, "initialize", protocolVersion="2025-03-26", capabilities={}, clientInfo=client)
        send(None, "notifications/initialized")
        ask(2, "propose", name="m", text="mission: m\ntree: {wait: 1}\n")
        send(3, "tools/call", name="prove", arguments={"name": "m"})
        assert ask(4, "status")["structuredContent"]["job"] == "prove m"
        work = tmp_path / "agents/proposals"
        assert len(list(work.glob(".work-*"))) == 1
        process.send_signal(number)
        assert process.wait(PATIENCE_S) == 130
        assert not list(work.glob(".work-*"))
